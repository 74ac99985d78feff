"""Frames by their names, where a body, a frame and a joint have the same one."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest
from numpy.testing import assert_allclose

from psp3.errors import UnknownName
from psp3.multibody.named_frames import frame_number, frames_named
from psp3.robots.closed_loop_robot import ClosedLoopRobot

BODY_AT = np.array([0.3, 0.0, 0.1])


def pendulum() -> pin.Model:
    """Return a joint ``arm`` whose body ``arm`` stands elsewhere, and a frame ``tip``."""
    model = pin.Model()
    joint = model.addJoint(0, pin.JointModelRY(), pin.SE3.Identity(), "arm")
    model.appendBodyToJoint(
        joint, pin.Inertia(1.0, np.array([0.1, 0.0, 0.0]), 0.01 * np.eye(3)), pin.SE3.Identity()
    )
    model.addJointFrame(joint)
    model.addBodyFrame("arm", joint, pin.SE3(np.eye(3), BODY_AT), -1)
    model.addFrame(pin.Frame("tip", joint, 0, pin.SE3.Identity(), pin.FrameType.OP_FRAME))
    return model


def test_a_name_means_the_body_and_joint_means_the_joint() -> None:
    model = pendulum()
    types = [model.frames[number].type for number in frames_named(model, "arm")]
    assert types == [pin.FrameType.BODY, pin.FrameType.JOINT]
    assert model.frames[frame_number(model, "arm")].type == pin.FrameType.BODY
    assert model.frames[frame_number(model, "body:arm")].type == pin.FrameType.BODY
    assert model.frames[frame_number(model, "joint:arm")].type == pin.FrameType.JOINT
    assert frame_number(model, "tip") == frame_number(model, "frame:tip")


@pytest.mark.parametrize("name", ["leg", "joint:tip", "body:", "", "frame:arm", None])
def test_an_unknown_frame_is_told_with_the_known_ones(name: str) -> None:
    with pytest.raises(UnknownName, match="known are universe, arm, arm, tip"):
        frame_number(pendulum(), name)


def test_placements_and_jacobians_of_both() -> None:
    """A pendulum about y: its body goes round in a circle, its joint stays."""
    robot = ClosedLoopRobot(pendulum(), [], ["arm"])
    angle = 0.4
    turn = pin.rpy.rpyToMatrix(np.array([0.0, angle, 0.0]))
    body, joint = (robot.frame_placement([angle], name) for name in ("arm", "joint:arm"))
    assert_allclose(body[:3, 3], turn @ BODY_AT, rtol=0, atol=1e-15)
    assert_allclose(joint[:3, 3], 0.0, rtol=0, atol=1e-15)
    velocity = np.cross([0.0, 1.0, 0.0], turn @ BODY_AT)
    jacobian = robot.frame_jacobian([angle], "arm")
    assert_allclose(jacobian[:, 0], [*velocity, 0.0, 1.0, 0.0], rtol=0, atol=1e-15)
    assert_allclose(robot.frame_jacobian([angle], "joint:arm")[:3], 0.0, rtol=0, atol=1e-15)
