"""Robots in single precision, beside themselves in double."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest

import psp3
from fuzzy2.errors import NotExportable
from psp3.description.parts import ROBOTS
from psp3.export.face import c_code
from psp3.multibody.closing import SMALLEST_STEP
from psp3.robots.closed_loop_robot import ClosedLoopRobot
from tests.c_code import Library, compiled
from tests.helpers import Array
from tests.psp3.export.robots_of_all_kinds import MAKERS

pytestmark = pytest.mark.slow

TYPICAL, ALMOST_ALL = 1e-5, 1e-3
"""Share of the largest number by which a half of all answers, and 99 of 100, may differ.

Roundings of 6e-8 go through loops whose pivots are a hundredth, near singular poses a thousandth,
of the largest.
"""

PARTLY = {"gripper": ("actuator_forces",)}
"""Where a motor does little of what is asked for, as the gripper's one tendon, digits are lost."""


def _states(robot: Any, count: int, far: bool) -> Any:
    """Yield states that single precision can hold: on a path, or anywhere near the reference."""
    rng, (p, n) = np.random.default_rng(0), (len(robot.coordinates_q), len(robot.coordinates_v))
    for number in range(count):
        q = robot.reference + 0.05 * np.sin(0.02 * number * np.arange(1, p + 1))
        if far:
            q = robot.reference + rng.choice([0.02, 0.1]) * rng.normal(size=p)
        if p > n:
            q[-4:] /= np.linalg.norm(q[-4:])
        yield tuple(x.astype(np.float32).astype(float) for x in (q, *rng.normal(size=(2, n))))


@pytest.mark.parametrize("name", ROBOTS)
def test_codes_are_the_same_and_numbers_nearly(name: str, tmp_path: Path) -> None:
    robot = MAKERS[name](tmp_path)
    libraries = []
    for precision in ("double", "single"):
        code = c_code(robot, precision=precision, name=f"{name}_{precision}")
        libraries.append(Library(code, compiled(code, tmp_path)))
    errors: dict[str, list[float]] = {}
    for far in (False, True):
        for library in libraries:
            library.call("reset")
        for q, v, a in _states(robot, 150, far):
            if far:
                for library in libraries:
                    library.call("reset")
            for function, arguments in _asked(robot, q, v, a):
                (right, wide), (code, narrow) = (
                    library.call(function, *arguments) for library in libraries
                )
                assert code == right, (function, q)
                if right == 0:
                    errors.setdefault(function, []).append(_error(wide, narrow))
    for function, found in errors.items():
        loose = 10.0 if function in PARTLY.get(name, ()) else 1.0
        assert np.median(found) <= loose * TYPICAL, function
        assert np.quantile(found, 0.99) <= loose * ALMOST_ALL, function


def _asked(robot: Any, q: Array, v: Array, a: Array) -> list[tuple[str, tuple[Array, ...]]]:
    asked = [
        ("configuration", (q,)),
        ("inverse_dynamics", (q, v, a)),
        ("forward_dynamics", (q, v, a)),
        ("equation_of_motion", (q, v)),
    ]
    if not robot.drives_coordinates:
        asked.append(("actuator_forces", (q, v, a[: robot.commanded])))
    return asked


def _error(wide: list[Array], narrow: list[Array]) -> float:
    right, given = np.concatenate(wide), np.concatenate(narrow).astype(float)
    return float(np.abs(given - right).max() / np.abs(right).max())


def test_what_seven_digits_do_not_tell_apart_is_refused() -> None:
    """A four-bar that is nearly stretched out at home: its equations are nearly the same."""
    model, body = pin.Model(), pin.Inertia(1.0, np.array([0.1, 0.0, 0.0]), 0.01 * np.eye(3))

    def hinge(parent: int, x: float, name: str) -> int:
        at = pin.SE3(np.eye(3), np.array([x, 0.0, 0.0]))
        joint: int = model.addJoint(parent, pin.JointModelRZ(), at, name)
        model.appendBodyToJoint(joint, body, pin.SE3.Identity())
        return joint

    coupler, rocker = hinge(hinge(0, 0.0, "crank"), 0.3, "coupler"), hinge(0, 0.8, "rocker")
    ends = [pin.SE3(np.eye(3), np.array([x, 0.0, 0.0])) for x in (0.4, 0.3)]
    loop = pin.RigidConstraintModel(
        pin.ContactType.CONTACT_3D,
        model,
        coupler,
        ends[0],
        rocker,
        ends[1],
        pin.ReferenceFrame.LOCAL,
    )
    for bend, refused in ((1e-2, False), (1e-6, True)):
        q0 = _stretched(bend)
        robot = ClosedLoopRobot(model, [loop], ["crank"], q0)
        assert c_code(robot, name="r").source
        if refused:
            with pytest.raises(NotExportable, match=r"single precision.*smallest pivot"):
                c_code(robot, name="r", precision="single")
        else:
            assert c_code(robot, name="r", precision="single").source


def _stretched(bend: float) -> Array:
    """Return a configuration of the four-bar whose coupler and rocker are bent by an angle."""
    # The crank of 0.3 at an angle such that coupler (0.4) and rocker (0.3) are almost one line.
    distance = np.sqrt(0.4**2 + 0.3**2 + 2.0 * 0.4 * 0.3 * np.cos(bend))
    crank = np.arccos((0.3**2 + 0.8**2 - distance**2) / (2.0 * 0.3 * 0.8))
    pin1 = 0.3 * np.array([np.cos(crank), np.sin(crank)])
    line = np.arctan2(-pin1[1], 0.8 - pin1[0])
    at_coupler = np.arccos((0.4**2 + distance**2 - 0.3**2) / (2.0 * 0.4 * distance))
    end = pin1 + 0.4 * np.array([np.cos(line + at_coupler), np.sin(line + at_coupler)])
    rocker = np.arctan2(end[1], end[0] - 0.8)
    return np.array([crank, line + at_coupler - crank, rocker])


def test_the_steps_of_single_precision_are_larger() -> None:
    """The numbers of the kernels are replaced by name; a name that is none would do nothing."""
    from psp3.export.single import CONSTANTS

    modules = ("closing", "least_squares")
    sources = "".join(
        Path(psp3.__file__).parent.joinpath("multibody", f"{name}.py").read_text(encoding="utf-8")
        for name in modules
    )
    motors = Path(psp3.__file__).parent.joinpath("dynamics", "motors.py")
    sources += motors.read_text(encoding="utf-8")
    for name in CONSTANTS:
        assert f"\n{name} = " in sources, name
    assert CONSTANTS["SMALLEST_STEP"] > SMALLEST_STEP
