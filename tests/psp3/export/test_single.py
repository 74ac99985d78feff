"""Robots in single precision, beside themselves in double."""

from __future__ import annotations

import functools
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest

import psp3
from fuzzy2.errors import NotExportable
from psp3.export.face import c_code
from psp3.multibody.closing import SMALLEST_STEP
from psp3.robots.closed_loop_robot import ClosedLoopRobot
from tests.c_code import Library, compiled
from tests.helpers import Array
from tests.psp3.export.robots_of_all_kinds import MAKERS, States, some_frames

pytestmark = pytest.mark.slow

ROUNDING = 2.0**-24
"""Of a number in single precision, as a share of it."""

ROUNDINGS = 300.0
"""An answer may be off by so many roundings.

It is a sum of some hundred products along chains of bodies, of a pose whose loops are closed to two
roundings of the robot's size, which turn a link of some centimeters by fifty. Near a singular pose
one rounding of the positions alone changes an answer by much: there no arithmetic of seven digits
knows better. Everywhere else this is two in 1e5.
"""

STATES = 150


def _states(robot: Any, far: bool) -> Iterator[list[Array]]:
    """Yield states that single precision can hold: on a path, or anywhere near the reference."""
    rng, (p, n) = np.random.default_rng(0), (len(robot.coordinates_q), len(robot.coordinates_v))
    for number in range(STATES):
        q = robot.reference + 0.05 * np.sin(0.02 * number * np.arange(1, p + 1))
        if far:
            q = robot.reference + rng.choice([0.02, 0.1]) * rng.normal(size=p)
        if p > n:
            q[-4:] /= np.linalg.norm(q[-4:])
        yield [_in_single(x) for x in (q, *rng.normal(size=(3, n)))]


def _in_single(x: Array) -> Array:
    return x.astype(np.float32).astype(float)


class Pair:
    """A robot in both precisions, each with a memory of its own."""

    def __init__(self, robot: Any, name: str, folder: Path) -> None:
        self.wide, self.narrow = (
            Library(code, compiled(code, folder, "gcc", optimized))
            for code, optimized in (
                (c_code(robot, precision=one, name=f"{name}_{one}", frames=frames), optimized)
                for frames in [some_frames(robot)]
                for one, optimized in (("double", "-O1"), ("single", "-O2"))
            )
        )
        self.functions = {
            one.name.removeprefix(f"{name}_double_"): one for one in self.wide.code.functions[1:]
        }
        self.rng = np.random.default_rng(1)

    def reset(self) -> None:
        """Begin with the reference pose on both sides."""
        self.wide.call("reset")
        self.narrow.call("reset")

    def given(self, name: str, state: list[Array]) -> list[Array]:
        """Return what a function takes of positions, speeds, accelerations and forces."""
        of = dict(zip(("positions", "speeds", "accelerations", "forces"), state, strict=True))
        return [
            of[one.name][: one.size] for one in self.functions[name].visible if one.role == "in"
        ]

    def compared(self, name: str, arguments: list[Array]) -> list[Array]:
        """Return of each array that a function writes its error, size, and change by a rounding.

        That is the most that one rounding of each argument, up or down, makes of the right answer.
        """
        before = self.wide.state.copy()
        right, wide = self.wide.call(name, *arguments)
        code, narrow = self.narrow.call(name, *arguments)
        assert code == right, (name, arguments)
        if right != 0:
            assert all(np.isnan(array).all() for array in narrow)
            return []
        after, changes = self.wide.state.copy(), np.zeros(len(wide))
        for _ in range(4):
            near = [x + self.rng.choice([-1.0, 1.0], x.size) * _rounding(x) for x in arguments]
            self.wide.state[:] = before
            code, others = self.wide.call(name, *near)
            if code == 0:
                changes = np.maximum(changes, _distances(wide, others))
        self.wide.state[:] = after
        sizes = [np.abs(array).max() for array in wide]
        return [*np.transpose([_distances(wide, narrow), sizes, changes])]


def _distances(some: list[Array], others: list[Array]) -> Array:
    return np.array([np.abs(a - b.astype(float)).max() for a, b in zip(some, others, strict=True)])


def _rounding(x: Array) -> Array:
    """Return a rounding of what is moved by x: places and angles are sums that begin with 1."""
    return ROUNDING * (1.0 + np.abs(x))


def _roundings(name: str, rows: list[list[Array]]) -> Array:
    """Return by how many roundings the arrays of each answer are off.

    A rounding is one of the arguments; of the largest number of the array, or, since what is small
    may be left of parts that are not, of an array of usual size; of a meter or a radian where it is
    a place.
    """
    errors, sizes, changes = np.moveaxis(np.array(rows), -1, 0)
    usual = np.maximum(sizes, np.median(sizes, axis=0))
    if name == "configuration" or name.endswith("placement"):
        usual = np.maximum(usual, 1.0)
    of_one = np.maximum(changes, ROUNDING * usual)
    return np.divide(errors, of_one, out=np.zeros_like(errors), where=errors > 0.0)


@pytest.fixture(scope="module")
def paired(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], tuple[Any, Pair]]:
    """Return a function that makes a robot and its pair, once."""

    @functools.cache
    def pair(name: str) -> tuple[Any, Pair]:
        folder = tmp_path_factory.mktemp(name)
        robot = MAKERS[name](folder)
        return robot, Pair(robot, name, folder)

    return pair


@pytest.mark.parametrize("name", MAKERS)
def test_answers_are_off_by_no_more_than_roundings(name: str, paired: Any) -> None:
    """On a path, from the last pose, and anywhere near the reference, from there."""
    robot, pair = paired(name)
    for far in (False, True):
        found: dict[str, list[list[Array]]] = {function: [] for function in pair.functions}
        pair.reset()
        for state in _states(robot, far):
            for function in pair.functions:
                if far:
                    pair.reset()
                if row := pair.compared(function, pair.given(function, state)):
                    found[function].append(row)
        for function, rows in found.items():
            assert len(rows) > 0.8 * STATES, function
            assert _roundings(function, rows).max() <= ROUNDINGS, function


@pytest.mark.parametrize("name", MAKERS)
def test_what_double_precision_refuses_is_refused(name: str, paired: Any) -> None:
    """Also far away, at NaN and infinity, but where a pose is singular within seven digits."""
    robot, pair = paired(name)
    states, others = States(robot), 0
    for _ in range(2 * STATES):
        q, v, a = states.next()
        pair.reset()
        right, _ = pair.wide.call("inverse_dynamics", q, v, a)
        code, (forces,) = pair.narrow.call("inverse_dynamics", q, v, a)
        others += (code == 0) != (right == 0)
        assert np.isfinite(forces).all() if code == 0 else np.isnan(forces).all()
    assert others <= 0.01 * 2 * STATES


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
    for place in (
        ("dynamics", "motors.py"),
        ("fuzzy_control", "adaptive_kernels.py"),
        ("control", "task_space_kernels.py"),
    ):
        sources += Path(psp3.__file__).parent.joinpath(*place).read_text(encoding="utf-8")
    for name in CONSTANTS:
        assert re.search(rf"^(\w+, )*{name}(, \w+)* = ", sources, re.M), name
    assert CONSTANTS["SMALLEST_STEP"] > SMALLEST_STEP
