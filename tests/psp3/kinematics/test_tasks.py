"""Tasks: which joints turn, and the length by which turns are compared with shifts."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from psp3.errors import InvalidValue
from psp3.kinematics.tasks import characteristic_length, rotating
from psp3.robots.closed_loop_robot import ClosedLoopRobot
from tests.closed_form_kinematics import (
    FiveBar,
)
from tests.helpers import ROBOTS_WITH_LIE_GROUPS, ROBOTS_WITH_LOOPS
from tests.psp3.kinematics.robots import built, scales


def test_characteristic_length_of_the_five_bar(robots: dict[str, ClosedLoopRobot]) -> None:
    """Two shafts and two elbows, from the closed form."""
    places = np.concatenate([FiveBar().shafts, FiveBar().elbows(robots["five_bar"].reference)])
    expected = np.sqrt(((places - places.mean(axis=0)) ** 2).sum() / 4.0)
    assert_allclose(characteristic_length(robots["five_bar"]), expected, rtol=1e-12)


def test_robot_whose_joints_are_in_one_place_needs_a_length() -> None:
    model = pin.Model()
    first = model.addJoint(0, pin.JointModelRZ(), pin.SE3.Identity(), "pan")
    model.addJoint(first, pin.JointModelRY(), pin.SE3.Identity(), "tilt")
    with pytest.raises(InvalidValue, match="length"):
        characteristic_length(ClosedLoopRobot(model, [], ("pan", "tilt")))


def test_screws_and_balls_turn_and_sliders_do_not() -> None:
    for parts in (*ROBOTS_WITH_LOOPS, *ROBOTS_WITH_LIE_GROUPS):
        robot = built(parts())
        assert_array_equal(np.where(rotating(robot.model), 0.3, 1.0), scales(robot, 0.3))
