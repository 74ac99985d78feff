"""The 3-PSP's closed form on symbols, against its own numbers and against the general core."""

from __future__ import annotations

import casadi
import numpy as np
import pytest

import psp3
from psp3.errors import InvalidValue, UnreachablePose
from psp3.symbolic import SymbolicPSP3, SymbolicRobot
from tests.helpers import random_states

ROBOT = psp3.load("psp3")
SYMBOLIC = SymbolicPSP3(ROBOT)
ROUNDING = 1e-12
"""The same operations in the same order: the difference that was seen is 0."""


def states(count: int) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    rng = np.random.default_rng(3)
    heights, speeds = random_states(rng, count)
    return list(zip(heights, speeds, rng.normal(size=(count, 3)), strict=True))


def test_it_is_what_the_robot_says() -> None:
    for a, v, w in states(50):
        forces = ROBOT.inverse_dynamics(a, v, w)
        found = SYMBOLIC.inverse_dynamics(a, v, w).full().ravel()
        assert found == pytest.approx(forces, rel=ROUNDING)
        accelerations = SYMBOLIC.forward_dynamics(a, v, forces).full().ravel()
        assert accelerations == pytest.approx(ROBOT.forward_dynamics(a, v, forces), rel=ROUNDING)
        for one, other in zip(
            SYMBOLIC.equation_of_motion(a, v), ROBOT.equation_of_motion(a, v), strict=True
        ):
            assert one.full().reshape(other.shape) == pytest.approx(other, rel=ROUNDING)
        pose = ROBOT.forward_kinematics(a)
        for name in ("center", "rotation", "arms", "tip"):
            part = SYMBOLIC.forward_kinematics(heights=a)[name].full()
            expected = getattr(pose, name)
            assert part.reshape(expected.shape) == pytest.approx(expected, abs=1e-15)


def test_the_general_core_says_the_same() -> None:
    """Two routes that share the parameters; 1e-10 of the largest force."""
    core = SymbolicRobot(ROBOT)
    for a, v, w in states(20):
        forces = SYMBOLIC.inverse_dynamics(a, v, w).full()
        other = core.inverse_dynamics(ROBOT.configuration(a), v, w).full()
        assert np.abs(forces - other).max() <= 1e-10 * np.abs(forces).max()


def test_derivatives_are_those_of_the_robot() -> None:
    x = [casadi.SX.sym(name, 3) for name in ("heights", "speeds", "accelerations")]
    forces = SYMBOLIC.inverse_dynamics(*x)
    slopes = casadi.Function("slopes", x, [casadi.jacobian(forces, one) for one in x])
    for a, v, w in states(20):
        expected = psp3.inverse_dynamics_derivatives(ROBOT, a, v, w)
        for found, matrix in zip(slopes(a, v, w), expected, strict=True):
            assert np.abs(found.full() - matrix).max() <= 1e-10 * np.abs(matrix).max()


def test_the_jacobian_of_the_tip_is_its_derivative() -> None:
    heights = casadi.SX.sym("heights", 3)
    slope = casadi.jacobian(SYMBOLIC.forward_kinematics(heights)[3], heights)
    by_casadi = casadi.Function("slope", [heights], [slope])
    for a, _, _ in states(20):
        found = SYMBOLIC.tip_jacobian(a).full()
        assert found == pytest.approx(by_casadi(a).full(), abs=1e-13)
        assert found == pytest.approx(ROBOT.tip_jacobian(a), abs=1e-15)


def test_what_is_no_pose_is_not_a_number() -> None:
    """Tilted by 80 degrees at an azimuth of 90 degrees an arm would have a negative length."""
    azimuths = 2.0 * np.pi / 3.0 * np.arange(3)
    heights, rest = np.tan(np.radians(80.0)) * 0.181 * np.sin(azimuths), np.zeros(3)
    with pytest.raises(UnreachablePose):
        ROBOT.forward_kinematics(heights)
    assert np.isnan(SYMBOLIC.inverse_dynamics(heights, rest, rest).full()).all()
    assert np.isnan(SYMBOLIC.forward_kinematics(heights)[3].full()).all()


@pytest.mark.parametrize("robot", ["psp3", psp3.load("five_bar")])
def test_other_robots_are_refused(robot: object) -> None:
    with pytest.raises(InvalidValue, match="SymbolicRobot"):
        SymbolicPSP3(robot)  # type: ignore[arg-type]


def test_it_says_what_it_is() -> None:
    assert repr(SYMBOLIC) == "SymbolicPSP3(3-PSP robot)"
    assert SYMBOLIC.inverse_dynamics.name_in() == ["heights", "speeds", "accelerations"]
