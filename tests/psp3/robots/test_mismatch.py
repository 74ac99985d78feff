"""What is allowed, refused and told of a robot that is made of its parts."""

from __future__ import annotations

import logging

import numpy as np
import pinocchio as pin
import pytest

import psp3
from psp3.errors import MobilityMismatch
from psp3.robots.closed_loop_robot import ClosedLoopRobot
from psp3.robots.mismatch import ALLOWED_MISMATCH
from tests.psp3.closure.rounded import Parts, flat_triangle, short_lever


def out_of_plane(by: float) -> ClosedLoopRobot:
    """Return the five-bar, one end of whose loop is off its plane, across which nothing moves."""
    exact = psp3.load("five_bar")
    loop = pin.RigidConstraintModel(exact.constraint_models[0])
    loop.joint1_placement = loop.joint1_placement * pin.SE3(np.eye(3), np.array([0.0, by, 0.0]))
    return ClosedLoopRobot(exact.model, [loop], exact.actuated, exact.q0)


def test_rounded_loops_are_told_and_may_stay_open_by_what_they_contradict(
    caplog: pytest.LogCaptureFixture,
) -> None:
    """By 1e-5 m at home, which is told; elsewhere by no more than ten times that."""
    with caplog.at_level(logging.WARNING):
        robot = out_of_plane(1e-5)
    (told,) = caplog.messages
    assert told.startswith("five_bar: redundant loops contradict each other by 1e-05 m and 0 rad")
    assert robot.closure_mismatch.length == pytest.approx(1e-5, rel=1e-6)
    data, (loop,) = robot.model.createData(), robot.constraint_models
    for q in robot.configuration(robot.reference + np.array([[0.1, -0.1], [0.2, 0.1]])):
        pin.forwardKinematics(robot.model, data, q)
        gap = (data.oMi[loop.joint1_id] * loop.joint1_placement).actInv(
            data.oMi[loop.joint2_id] * loop.joint2_placement
        )
        assert np.abs(gap.translation).max() <= ALLOWED_MISMATCH * 1e-5


def made(parts: Parts) -> ClosedLoopRobot:
    return ClosedLoopRobot(parts.model, parts.loops, parts.motors, np.zeros(parts.model.nq))


def test_what_is_rounded_or_a_short_lever_is_told_with_a_remedy_that_helps(
    caplog: pytest.LogCaptureFixture,
) -> None:
    parts = short_lever(7e-4, turntable=False)
    with caplog.at_level(logging.WARNING):
        made(parts)
    told = caplog.messages[0]
    assert "if its numbers are exact, it has 1 instead of 2 degrees of freedom" in told
    assert told.endswith("make x, y, plate fixed, because they cannot move then")
    caplog.clear()
    model = pin.buildReducedModel(parts.model, [2, 3, 4], np.zeros(4))
    with caplog.at_level(logging.WARNING):
        ClosedLoopRobot(model, [], ["arm"])
    assert not caplog.messages


def test_a_short_lever_that_moves_with_others_is_told_what_would_be_enough(
    caplog: pytest.LogCaptureFixture,
) -> None:
    with caplog.at_level(logging.WARNING):
        made(short_lever(7e-4, turntable=True))
    assert "1 instead of 2 degrees of freedom" in caplog.messages[0]
    assert caplog.messages[0].endswith("longer, until they hold with 1e-03 of the strongest")
    caplog.clear()
    with caplog.at_level(logging.WARNING):
        assert made(short_lever(7e-3, turntable=True)).mobility.degrees_of_freedom == 1
    assert not caplog.messages


def test_bars_that_are_stretched_are_told_and_stay_closed(caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.WARNING):
        robot = made(flat_triangle(0.0))
    told = caplog.messages[0]
    assert "home is a singular pose that the loops do not leave" in told
    assert "a motion of near, far counts as free (3 degrees of freedom)" in told
    assert max(robot.closure_mismatch) < 1e-11
    q = robot.configuration(robot.reference + np.array([0.1, -0.1]))
    np.testing.assert_array_equal(q[:2], 0.0)


def test_free_motions_are_refused_where_that_is_asked_for() -> None:
    with pytest.raises(MobilityMismatch):
        psp3.load("gripper", free="refuse")


def test_a_floating_base_is_kept_where_free_motions_are_refused() -> None:
    """It is no motion that motors forgot, and a doubled hinge beside it is one."""
    model = pin.Model()
    for name, kind in (("root", pin.JointModelFreeFlyer()), ("hip", pin.JointModelRX())):
        joint = model.addJoint(model.njoints - 1, kind, pin.SE3.Identity(), name)
        model.appendBodyToJoint(joint, pin.Inertia.Random(), pin.SE3.Identity())
    assert ClosedLoopRobot(model, [], ["hip"], free="refuse").coordinates == ("hip", "root")
    joint = model.addJoint(joint, pin.JointModelRX(), pin.SE3.Identity(), "double")
    model.appendBodyToJoint(joint, pin.Inertia.Random(), pin.SE3.Identity())
    with pytest.raises(MobilityMismatch, match="double"):
        ClosedLoopRobot(model, [], ["hip"], free="refuse")
