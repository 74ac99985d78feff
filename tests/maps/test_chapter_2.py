"""Spatial descriptions of chapter 2: frames of robots, and points and vectors in them."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

import psp3
from psp3.kinematics.frames import frame_motion
from tests.helpers import Array

POINT = np.array([0.03, -0.05, 0.11])
"""A point as the tip's frame sees it [m]."""


def with_points(name: str) -> psp3.ClosedLoopRobot:
    """Return a robot with frames at a point, and at the ends of the tip's axes, of its platform."""
    robot = psp3.load(name)
    model = robot.model.copy()
    tip = model.frames[model.getFrameId("tip")]
    for label, place in (("point", POINT), *zip("xyz", np.eye(3), strict=True)):
        model.addFrame(
            pin.Frame(
                label,
                tip.parentJoint,
                tip.placement * pin.SE3(np.eye(3), place),
                pin.FrameType.OP_FRAME,
            )
        )
    return psp3.ClosedLoopRobot(model, robot.constraint_models, robot.actuated, robot.q0)


def placement(robot: psp3.ClosedLoopRobot, frame: str) -> Array:
    positions = robot.reference + 0.02 * np.cos(np.arange(len(robot.actuated)))
    still = np.zeros_like(positions)
    return frame_motion(robot, positions, still, still, frame).placement


@pytest.mark.parametrize("name", ["gough_stewart", "tricept"])
def test_columns_are_the_axes_of_the_frame_and_rows_those_of_the_base(name: str) -> None:
    """Eq. 2.1: columns from the ends of the axes; seen from the frame the base has the rows."""
    robot = with_points(name)
    tip = placement(robot, "tip")
    for axis, column in zip("xyz", tip[:3, :3].T, strict=True):
        np.testing.assert_allclose(placement(robot, axis)[:3, 3] - tip[:3, 3], column, atol=1e-14)
    back = np.linalg.inv(tip)
    np.testing.assert_allclose(back[:3, :3].T, tip[:3, :3], atol=1e-14)
    assert np.linalg.det(tip[:3, :3]) == pytest.approx(1.0, abs=1e-14)
    assert np.abs(tip[:3, :3] - np.eye(3)).max() > 0.02


@pytest.mark.parametrize("name", ["gough_stewart", "tricept"])
def test_points_go_from_frame_to_frame(name: str) -> None:
    """Eq. 2.2 by rotation and origin, and eq. 2.3 by the homogeneous transform."""
    robot = with_points(name)
    tip, point = placement(robot, "tip"), placement(robot, "point")[:3, 3]
    np.testing.assert_allclose(tip[:3, :3] @ POINT + tip[:3, 3], point, atol=1e-14)
    np.testing.assert_allclose(tip @ [*POINT, 1.0], [*point, 1.0], atol=1e-14)
    np.testing.assert_array_equal(tip[3], [0.0, 0.0, 0.0, 1.0])


def test_the_transform_of_a_frame_is_the_operator_that_moves_a_vector() -> None:
    """Eq. 2.4: a hinge at 30 degrees turns vectors by 30 and not by -30 degrees.

    As complex numbers do, with a multiplication.
    """
    model = pin.Model()
    hinge = model.addJoint(0, pin.JointModelRZ(), pin.SE3.Identity(), "hinge")
    model.addFrame(pin.Frame("tip", hinge, 0, pin.SE3.Identity(), pin.FrameType.OP_FRAME))
    robot = psp3.ClosedLoopRobot(model, [], ("hinge",))
    angle = np.radians(30.0)
    turned = frame_motion(robot, [angle], [0.0], [0.0]).placement @ [2.0, 1.0, 0.5, 1.0]
    expected = (2.0 + 1.0j) * np.exp(1.0j * angle)
    np.testing.assert_allclose(turned, [expected.real, expected.imag, 0.5, 1.0], atol=1e-15)
