"""The error above a robot: of its tip, or of the joint that is farthest off."""

from __future__ import annotations

import numpy as np
import pytest

import psp3
from psp3.visualize.animation import Frames
from psp3.visualize.tracking_error import TrackingError, tracking_error

ROBOT = psp3.load()
TIME = np.array([0.0, 1.0])
DESIRED = np.array([[0.0, 0.0, 0.0], [0.05, 0.05, 0.05]])


def test_error_is_the_distance_of_the_tips() -> None:
    tips = np.array([[0.0, 0.0, 0.1], [3e-3, 4e-3, 0.1]])
    wanted = np.array([[0.0, 0.0, 0.1]] * 2)
    error = tracking_error(ROBOT, Frames(TIME, DESIRED, tips, DESIRED, wanted))
    assert error is not None
    assert error.about == "tip error"
    np.testing.assert_allclose(error.millimeters, [0.0, 5.0], atol=1e-12)


def test_without_a_tip_it_is_that_of_the_joint_that_is_farthest_off() -> None:
    """All nuts are 20 mm low, and so are all joints; 1e-6 mm is far above rounding."""
    low = DESIRED - [[0.0, 0.0, 0.0], [0.02, 0.02, 0.02]]
    error = tracking_error(ROBOT, Frames(TIME, low, None, DESIRED, None))
    assert error is not None
    assert error.about == "largest error of a joint"
    np.testing.assert_allclose(error.millimeters, [0.0, 20.0], atol=1e-6)


@pytest.mark.parametrize(
    "frames", [Frames(TIME, DESIRED), Frames(TIME[:1], DESIRED[:1], None, DESIRED[1:])]
)
def test_where_nothing_is_desired_or_moves_there_is_none(frames: Frames) -> None:
    assert tracking_error(ROBOT, frames) is None


@pytest.mark.parametrize(
    ("largest", "digits"), [(0.0, 1), (123.4, 0), (86.6, 1), (0.4, 3), (1e-9, 6)]
)
def test_three_digits_are_shown_of_the_largest(largest: float, digits: int) -> None:
    command = TrackingError("tip error", np.array([0.0, largest])).as_command(2.0)
    assert (command["digits"], command["seconds"]) == (digits, 2.0)
