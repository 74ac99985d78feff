"""A motion to look at: from rest, within limits, for every robot."""

from __future__ import annotations

import numpy as np
import pytest

import psp3
from psp3.errors import InvalidValue
from psp3.trajectories.sway import Sway

TIMES = np.linspace(0.0, 2.0, 201)


@pytest.mark.parametrize("name", ["psp3", "five_bar", "planar_3rrr", "delta", "tricept"])
def test_every_robot_can_make_it_from_rest(name: str) -> None:
    robot = psp3.load(name)
    sway = Sway(robot=robot)
    motion = sway.check(TIMES)
    np.testing.assert_allclose(motion.positions[0], robot.reference, atol=1e-15)
    np.testing.assert_allclose(motion.positions[-1], robot.reference, atol=1e-12)
    np.testing.assert_allclose(motion.speeds[0], 0.0, atol=1e-15)
    assert (np.ptp(motion.positions, axis=0) > sway.amplitudes).all()
    # Rates are those of the positions: differences of second order, of a motion of some rad/s³.
    between = np.gradient(motion.positions, TIMES, axis=0)[1:-1]
    np.testing.assert_allclose(motion.speeds[1:-1], between, atol=5e-3)


def test_motors_have_phases_of_their_own() -> None:
    positions = Sway(robot=psp3.load("delta")).check(TIMES).positions
    apart = positions - positions[0]
    assert np.linalg.matrix_rank(apart, tol=1e-6) == 2


def test_joints_without_limits_move_as_those_with_wide_ones() -> None:
    """Pinocchio gives them the largest numbers as limits; the distance of these is beyond all."""
    amplitudes, five_bar = [], psp3.load("five_bar")
    for limit in (np.finfo(float).max, 1e6):
        model = five_bar.model.copy()
        model.lowerPositionLimit = np.full(model.nq, -limit)
        model.upperPositionLimit = np.full(model.nq, limit)
        robot = psp3.ClosedLoopRobot(
            model, five_bar.constraint_models, five_bar.actuated, five_bar.q0
        )
        amplitudes.append(Sway(robot=robot).amplitudes)
    np.testing.assert_array_equal(*amplitudes)


def test_a_robot_that_can_hardly_move_is_offered_another_home() -> None:
    """Its elbows are held by their limits."""
    five_bar = psp3.load("five_bar")
    model = five_bar.model.copy()
    for name in ("leg1_elbow", "leg2_elbow"):
        place = model.joints[model.getJointId(name)].idx_q
        model.lowerPositionLimit[place] = five_bar.q0[place] - 1e-6
        model.upperPositionLimit[place] = five_bar.q0[place] + 1e-6
    robot = psp3.ClosedLoopRobot(model, five_bar.constraint_models, five_bar.actuated, five_bar.q0)
    with pytest.raises(InvalidValue) as caught:
        Sway(robot=robot)
    message = str(caught.value)
    assert message.startswith("reference pose must be farther from singular poses and limits")
    assert "a pose home in an SRDF beside the URDF" in message
    assert caught.value.value == five_bar.reference.tolist()


def test_motor_at_a_limit_moves_away_from_it() -> None:
    five_bar = psp3.load("five_bar")
    model = five_bar.model.copy()
    model.lowerPositionLimit[five_bar.actuated_q[0]] = five_bar.reference[0]
    model.upperPositionLimit[five_bar.actuated_q[1]] = five_bar.reference[1]
    robot = psp3.ClosedLoopRobot(model, five_bar.constraint_models, five_bar.actuated, five_bar.q0)
    apart = Sway(robot=robot).check(TIMES).positions - robot.reference
    assert apart[:, 0].min() >= 0.0
    assert apart[:, 1].max() <= 0.0
    assert np.abs(apart).max(axis=0).min() > 0.05


def test_amplitude_of_ones_own() -> None:
    robot = psp3.load("five_bar")
    np.testing.assert_allclose(Sway(0.1, 4.0, robot).amplitudes, 0.1)
    with pytest.raises(InvalidValue, match="amplitude"):
        Sway(-0.1, robot=robot)


@pytest.mark.parametrize("name", ["planar_4rrr", "jansen", "agile_eye", "hexa", "gripper", "biped"])
def test_what_the_motors_command_sways(name: str) -> None:
    """As many coordinates as they command, the first ones; the others stay at the reference."""
    robot = psp3.load(name)
    motion = Sway(robot=robot).check(TIMES)
    assert motion.positions.shape == (201, robot.commanded)
    start = robot.reference[: robot.commanded]
    np.testing.assert_allclose(motion.positions[0], start, atol=1e-15)
    assert np.ptp(motion.positions, axis=0).min() > 0.01
