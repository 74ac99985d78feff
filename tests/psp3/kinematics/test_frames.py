"""Velocities and accelerations of points and frames of a robot."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pinocchio as pin
import pytest
from numpy.testing import assert_allclose

import psp3
from psp3.description.parts import THESIS_ROBOTS
from psp3.errors import InvalidArray
from psp3.kinematics.frames import FrameMotion, frame_motion, point_motion
from tests.closed_form_kinematics import Delta
from tests.helpers import Array, derivative, random_states
from tests.psp3.kinematics.motions import swing

ROBOT = psp3.load()


def turning(placements: Callable[[float], Array], step: float) -> Array:
    """Angular velocity at time 0, in base axes, from differences of a rotation.

    The skew part of dR/dt R'.
    """
    spin = derivative(lambda t: placements(t)[:3, :3], step) @ placements(0.0)[:3, :3].T
    return np.array([spin[2, 1], spin[0, 2], spin[1, 0]])


@pytest.mark.parametrize("name", THESIS_ROBOTS)
def test_velocity_is_the_rate_of_the_placement(name: str) -> None:
    """Eighth-order differences: 1e-11 of rounding in closed loops (1e-13 m over a step of 0.02 s).

    1e-9 is asked for.
    """
    robot = psp3.load(name)
    motion = swing(robot)

    def placement(t: float) -> Array:
        return robot.frame_placement(motion(t)[0], "tip")

    found = frame_motion(robot, *motion(0.0))
    assert_allclose(found.placement, placement(0.0), atol=1e-12)
    assert_allclose(found.velocity[:3], derivative(placement, 0.02)[:3, 3], atol=1e-9)
    assert_allclose(found.velocity[3:], turning(placement, 0.02), atol=1e-9)
    assert np.abs(found.velocity[:3]).max() > 1e-3


@pytest.mark.parametrize("name", THESIS_ROBOTS)
def test_acceleration_is_the_rate_of_the_velocity(name: str) -> None:
    """Differences of the velocities that the test before has checked.

    1e-8 of accelerations of about 1.
    """
    robot = psp3.load(name)
    motion = swing(robot, 1)
    rate = derivative(lambda t: frame_motion(robot, *motion(t)).velocity, 0.02)
    found = frame_motion(robot, *motion(0.0)).acceleration
    assert_allclose(found, rate, atol=1e-8)
    assert np.abs(found).max() > 1e-2


def test_acceleration_is_classical() -> None:
    """Second differences of positions from the closed form, so without any velocity of ours.

    1e-6: rounding over the step squared.
    """
    motion = swing(ROBOT, 2)

    def tip(t: float) -> Array:
        return ROBOT.forward_kinematics(motion(t)[0]).tip

    found = frame_motion(ROBOT, *motion(0.0)).acceleration[:3]
    assert_allclose(
        found, derivative(lambda t: derivative(lambda s: tip(t + s), 0.02), 0.02), atol=1e-9
    )


def test_tip_of_the_3_psp_is_that_of_the_closed_form() -> None:
    """Forward by Pinocchio, back by the compiled kernel.

    1e-9 of speeds of about 1, at poses up to 48 degrees of tilt, fold or not.
    """
    heights, speeds = random_states(np.random.default_rng(0), 50)
    heights -= heights.mean(axis=1, keepdims=True)
    accelerations = np.random.default_rng(1).normal(size=(50, 3))
    motion = frame_motion(ROBOT, heights, speeds, accelerations)
    assert_allclose(
        motion.velocity[:, :3],
        np.einsum("nij,nj->ni", ROBOT.tip_jacobian(heights), speeds),
        atol=1e-11,
    )
    back = ROBOT.rates_of_tip(heights, motion.velocity[:, :3], motion.acceleration[:, :3])
    # The way back divides by the determinant of the Jacobian.
    condition = np.linalg.cond(ROBOT.tip_jacobian(heights)).max()
    assert_allclose(back[0], speeds, atol=1e-11 * condition)
    assert_allclose(back[1], accelerations, atol=1e-9 * condition)


def test_tip_of_the_delta_is_that_of_three_spheres() -> None:
    """Closed form of another kind, its derivatives by differences: 1e-9 and, twice, 1e-8."""
    robot, closed = psp3.load("delta"), Delta()
    motion = swing(robot, 3)
    found = frame_motion(robot, *motion(0.0))
    assert_allclose(
        found.velocity[:3], derivative(lambda t: closed.forward(motion(t)[0]), 0.02), atol=1e-9
    )
    twice = derivative(lambda t: derivative(lambda s: closed.forward(motion(t + s)[0]), 0.02), 0.02)
    assert_allclose(found.acceleration[:3], twice, atol=1e-8)
    # The platform of a Delta does not turn.
    assert_allclose(found.velocity[3:], 0.0, atol=1e-11)


@pytest.mark.parametrize("shape", [(), (4,), (2, 3)])
def test_shapes(shape: tuple[int, ...]) -> None:
    """Leading dimensions as given, broadcast against each other."""
    heights = np.zeros((*shape, 3))
    motion = frame_motion(ROBOT, heights, np.ones(3), np.zeros(3))
    assert (motion.placement.shape, motion.velocity.shape, motion.acceleration.shape) == (
        (*shape, 4, 4),
        (*shape, 6),
        (*shape, 6),
    )
    assert_allclose(
        motion.velocity, np.broadcast_to([0.0, 0.0, 1.0, 0.0, 0.0, 0.0], (*shape, 6)), atol=1e-13
    )
    point = point_motion(heights, np.ones(3))
    assert (point.placement.shape, point.velocity.shape) == ((*shape, 4, 4), (*shape, 6))


def test_a_robot_of_a_single_degree_of_freedom() -> None:
    """A crank of 0.5 m, for whose model Pinocchio returns Jacobians as vectors: r w and -r w²."""
    model = pin.Model()
    crank = model.addJoint(0, pin.JointModelRZ(), pin.SE3.Identity(), "crank")
    place = pin.SE3(np.eye(3), np.array([0.5, 0.0, 0.0]))
    model.addFrame(pin.Frame("tip", crank, 0, place, pin.FrameType.OP_FRAME))
    robot = psp3.ClosedLoopRobot(model, [], ("crank",))
    motion = frame_motion(robot, [0.7], [3.0], [2.0])
    out, along = np.array([np.cos(0.7), np.sin(0.7), 0.0]), np.array([-np.sin(0.7), np.cos(0.7), 0])
    assert_allclose(motion.placement[:3, 3], 0.5 * out, atol=1e-15)
    assert_allclose(motion.velocity, [*(1.5 * along), 0.0, 0.0, 3.0], atol=1e-14)
    assert_allclose(motion.acceleration, [*(1.0 * along - 4.5 * out), 0.0, 0.0, 2.0], atol=1e-14)
    assert_allclose(robot.frame_jacobian([0.7], "tip")[:, 0], [*(0.5 * along), 0, 0, 1], atol=1e-14)


def test_a_point_does_not_turn() -> None:
    point = point_motion([0.1, 0.2, 0.3], [1.0, 2.0, 3.0], [4.0, 5.0, 6.0])
    assert_allclose(point.placement, [[1, 0, 0, 0.1], [0, 1, 0, 0.2], [0, 0, 1, 0.3], [0, 0, 0, 1]])
    assert_allclose(point.velocity, [1, 2, 3, 0, 0, 0])
    assert_allclose(point.acceleration, [4, 5, 6, 0, 0, 0])
    assert isinstance(point, FrameMotion)


@pytest.mark.parametrize(
    "arguments",
    [
        ([0.0, 0.0], [0.0] * 3, [0.0] * 3),
        ([0.0] * 3, [np.nan] * 3, [0.0] * 3),
        ([0.0] * 3, [0.0] * 3, "x"),
    ],
)
def test_bad_motions_are_refused(arguments: tuple[object, ...]) -> None:
    with pytest.raises(InvalidArray):
        frame_motion(ROBOT, *arguments)
    with pytest.raises(InvalidArray):
        point_motion(*arguments)
