"""Derivatives of every kind of robot that is loaded from a file, against eighth-order differences.

Springs, couplings, tendons, hinges, floating bases, spins that are coordinates, feet on the ground,
more and fewer motors than coordinates. Differences along a floating base are along its twists.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from numpy.testing import assert_allclose

import psp3
from psp3.errors import InvalidValue
from psp3.robots.closed_loop_robot import ClosedLoopRobot
from tests.helpers import Array, derivative
from tests.mujoco_null_space import biped, doubled, five_bar, gripper, rod

SPRING = 'stiffness="30" springref=".2" damping=".3"'
LEGS = ("l_hip", "l_motor", "r_hip", "r_motor")

TEXTS = {
    "a spring and a motor": (five_bar("m1", spring=SPRING), "keep"),
    "three motors": (five_bar("m1", "m2", "p1"), "lock"),
    "coupled fingers on a tendon": (gripper(), "keep"),
    "a hinge of two that is kept": (doubled(), "keep"),
    "a hinge of two that is locked": (doubled(), "lock"),
    "a spin that is kept": (rod(), "keep"),
    "a spin that is locked": (rod(), "lock"),
    "floating, springs on the feet": (biped(*LEGS, "l_knee", "r_knee"), "keep"),
    "floating": (biped(*LEGS), "lock"),
}

SHIPPED: dict[str, Callable[[], ClosedLoopRobot]] = {
    "planar_4rrr": lambda: psp3.load("planar_4rrr"),
    "jansen": lambda: psp3.load("jansen"),
    "agile_eye": lambda: psp3.load("agile_eye"),
    "hexa": lambda: psp3.load("hexa"),
    "gripper": lambda: psp3.load("gripper"),
    "gripper, held": lambda: psp3.load("gripper", free="lock"),
    "biped": lambda: psp3.load("biped"),
    "biped on a foot": lambda: psp3.load("biped", closures=[("left_foot", "world", "6d")]),
}


BEYOND_PINOCCHIO = {
    *("a spring and a motor", "coupled fingers on a tendon", "a spin that is locked"),
    *("agile_eye", "hexa", "gripper", "gripper, held", "biped", "biped on a foot"),
}
"""Robots with springs, damping, couplings, hinges, held spins or rounding."""


@pytest.fixture(params=[*TEXTS, *SHIPPED])
def robot(request: pytest.FixtureRequest, tmp_path: Path) -> ClosedLoopRobot:
    if request.param in SHIPPED:
        return SHIPPED[request.param]()
    text, free = TEXTS[request.param]
    file = tmp_path / "robot.xml"
    file.write_text(text, encoding="utf-8")
    return ClosedLoopRobot.from_mjcf(file, free=free)


def moved(a: Array, way: Array) -> Array:
    """Return positions after a way (n,) along the speeds; a floating base, the last, by a twist."""
    if len(a) == len(way):
        return np.asarray(a + way)
    base = pin.XYZQUATToSE3(a[-7:]) * pin.exp6(way[-6:])
    return np.concatenate([a[:-7] + way[:-6], pin.SE3ToXYZQUAT(base)])


def columns(function: Callable[[Array], Array], n: int, step: float) -> Array:
    """Return the derivative at zero of a function of ways (n,), as columns."""
    return np.stack(
        [derivative(lambda t, u=unit: function(t * u), step) for unit in np.eye(n)], axis=-1
    )


def test_derivatives_of_both_dynamics(robot: ClosedLoopRobot) -> None:
    """1e-9 of the largest entry, of which differences leave at most a half.

    Loops that rounding leaves open are followed to first order in how far they are: 1e-6 of the
    agile eye's six digits, of which 1e-7 is left.
    """
    rng, n = np.random.default_rng(4), len(robot.coordinates_v)
    a = moved(robot.reference, rng.uniform(-0.05, 0.05, n))
    v, w = 0.5 * rng.normal(size=(2, n))
    bar = 1e-9 if robot.closure_mismatch.length < 1e-9 else 1e-6
    for found, function in (
        (robot.inverse_dynamics_derivatives(a, v, w), robot.inverse_dynamics),
        (robot.forward_dynamics_derivatives(a, v, w), robot.forward_dynamics),
    ):
        expected = (
            columns(lambda way: function(moved(a, way), v, w), n, 1e-3),  # noqa: B023
            columns(lambda way: function(a, v + way, w), n, 0.1),  # noqa: B023
            columns(lambda way: function(a, v, w + way), n, 0.1),  # noqa: B023
        )
        for one, other in zip(found, expected, strict=True):
            assert_allclose(one, other, rtol=0.0, atol=bar * np.abs(other).max())


def test_derivatives_of_pinocchios_route(
    robot: ClosedLoopRobot, request: pytest.FixtureRequest
) -> None:
    """The same matrices from Pinocchio's derivatives of the tree, which share no kernel.

    1e-9 of the largest entry. Where Pinocchio differentiates less than there is, that is said.
    """
    rng, n = np.random.default_rng(6), len(robot.coordinates_v)
    a = moved(robot.reference, rng.uniform(-0.05, 0.05, n))
    v, w = 0.5 * rng.normal(size=(2, n))
    other = robot.dynamics("pinocchio")
    if request.node.callspec.params["robot"] in BEYOND_PINOCCHIO:
        with pytest.raises(InvalidValue, match="covers every robot"):
            other.inverse_dynamics_derivatives(a, v, w)
        return
    for name in ("inverse_dynamics_derivatives", "forward_dynamics_derivatives"):
        for one, expected in zip(
            getattr(robot, name)(a, v, w), getattr(other, name)(a, v, w), strict=True
        ):
            assert_allclose(one, expected, rtol=0.0, atol=1e-9 * np.abs(expected).max())
