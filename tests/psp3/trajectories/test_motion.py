"""Motions of the joints: their tips, and what a robot cannot do."""

from __future__ import annotations

import numpy as np
import pytest

import psp3
from psp3 import trajectories
from psp3.errors import (
    CollisionFound,
    StrokeExceeded,
)
from tests.psp3.trajectories.points import NAMES


@pytest.mark.parametrize("name", NAMES)
def test_tip_of_the_heights_is_the_tip_asked_for(
    name: str, every_trajectory: dict[str, trajectories.Trajectory]
) -> None:
    """Forward kinematics of what inverse kinematics returned; 1e-14 m is a few ulps."""
    t = np.linspace(-0.5, 3.0, 50)
    motion = every_trajectory[name](t)
    np.testing.assert_allclose(
        every_trajectory[name].robot.forward_kinematics(motion.heights).tip, motion.tip, atol=1e-14
    )


def test_leaving_the_stroke_names_the_time() -> None:
    helix = trajectories.Helix(rise=0.1)
    t = np.arange(0.0, 6.0, 0.01)
    with pytest.raises(StrokeExceeded) as caught:
        helix.check(t)
    late = t[(helix(t).heights > helix.robot.stroke[1]).any(axis=1)]
    assert caught.value.time == late[0]


def test_a_motion_in_which_links_touch_is_refused_if_clearance_is_asked_for() -> None:
    """A lean of 45 degrees toward screw 1 is a contact.

    Bushing and frame touch at 35.594 degrees; it is within the arms' lengths.
    """
    robot = psp3.load("psp3")
    leaning = robot.inverse_kinematics(height=0.0, tilt=np.radians(45.0), azimuth=0.0)
    motion = trajectories.PointToPoint(np.zeros(3), leaning, 1.0, robot=robot, space="joints")
    t = np.linspace(0.0, 1.0, 51)
    motion.check(t)
    with pytest.raises(CollisionFound) as caught:
        motion.check(t, clearance=0.0)
    assert 0.5 < caught.value.time < 1.0
    with pytest.raises(CollisionFound):
        psp3.simulate(robot, psp3.ComputedTorque(robot), motion, 1.0, clearance=0.0)
