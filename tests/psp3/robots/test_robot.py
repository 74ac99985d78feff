"""Every shipped robot answers what general code asks of a robot, and answers it alike."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import psp3
from psp3.description.parts import THESIS_ROBOTS
from psp3.errors import InvalidValue, UnreachableTip
from psp3.robots.robot import Robot
from psp3.simulation.runge_kutta import RungeKutta


@pytest.fixture(scope="module", params=THESIS_ROBOTS)
def robot(request: pytest.FixtureRequest) -> psp3.ClosedLoopRobot:
    return psp3.load(request.param)


def near_reference(robot: psp3.ClosedLoopRobot, count: int) -> np.ndarray:
    """Positions near the reference, within the limits of every shipped robot."""
    steps = np.random.default_rng(0).uniform(-0.02, 0.02, (count, len(robot.actuated)))
    return np.asarray(robot.reference + steps)


def test_it_is_a_robot(robot: psp3.ClosedLoopRobot) -> None:
    assert isinstance(robot, Robot)
    assert not isinstance(robot.model, Robot)


def test_the_tip_is_where_its_frame_is(robot: psp3.ClosedLoopRobot) -> None:
    """For the 3-PSP the closed form against Pinocchio's tree; 1e-12 m is rounding."""
    positions = near_reference(robot, 5)
    expected = (
        robot.frame_placement(positions, "tip")[..., :3, 3]
        if robot.model.existFrame("tip")
        else np.full((5, 3), np.nan)
    )
    assert_allclose(robot.tip(positions), expected, rtol=0.0, atol=1e-12)


def test_the_jacobian_of_a_position_is_the_upper_part_of_that_of_a_frame(
    robot: psp3.ClosedLoopRobot,
) -> None:
    frame = "tip" if robot.model.existFrame("tip") else robot.model.frames[-1].name
    positions = near_reference(robot, 5)
    found, whole = robot.position_jacobian(positions, frame), robot.frame_jacobian(positions, frame)
    assert_allclose(found, whole[..., :3, :], rtol=0.0, atol=1e-12)


def test_a_motion_of_the_tip_is_one_of_the_joints_or_refused(robot: psp3.ClosedLoopRobot) -> None:
    point, velocity, acceleration = np.array([[0.002, 0.001, 0.07]]), np.ones((1, 3)), np.ones(3)
    if not robot.has_inverse_of_tip:
        with pytest.raises(
            InvalidValue, match=r"inverse kinematics of its tip.*path of the joints"
        ):
            robot.motion_of_tip(point, velocity, acceleration)
        with pytest.raises(InvalidValue, match="'joints': only the tip of the 3-PSP"):
            psp3.trajectories.Hold(point[0], robot, "tip")
        return
    positions, speeds, _ = robot.motion_of_tip(point, velocity, acceleration)
    assert_allclose(robot.tip(positions), point, rtol=0.0, atol=1e-12)
    jacobian = robot.position_jacobian(positions, "tip")
    assert_allclose(jacobian @ speeds[..., None], velocity[..., None], rtol=0.0, atol=1e-12)
    with pytest.raises(UnreachableTip):
        robot.motion_of_tip(np.array([0.1, 0.0, 0.07]), np.zeros(3), np.zeros(3))


def test_compiled_steps_are_those_of_the_plant(robot: psp3.ClosedLoopRobot) -> None:
    """Not a bit of difference; and the motion is that of the forces."""
    rest = np.zeros(len(robot.actuated))
    forces = robot.inverse_dynamics(robot.reference, rest, rest + 0.1)
    plant = RungeKutta(robot, steps=2)
    plant.start(robot.reference, rest)
    state = plant.advance(forces, 0.01)
    assert state is not None
    own = robot.compiled_steps(2, psp3.Drive())
    own.start(robot.reference, rest)
    assert_array_equal(own.advance(forces, 0.01), state)
    # Uniform acceleration to first order: the forces are those of 0.1 at the start.
    assert_allclose(state[0] - robot.reference, 0.5 * 0.1 * 0.01**2, rtol=0.05)


def test_what_a_robot_is_called_and_what_is_said_at_its_limits() -> None:
    star, linkage = psp3.load("psp3"), psp3.load("five_bar")
    assert (star.title, linkage.title) == ("3-PSP robot", "five_bar")
    assert star.limit_message == "a nut ran off its screw"
    assert linkage.limit_message == "an actuated joint left its limits"
    assert_array_equal(linkage.point_of_force, np.zeros(3))
