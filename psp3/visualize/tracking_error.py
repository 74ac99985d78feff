"""How far a robot is from where it should be, for the label above it."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin

from psp3.checks import Array
from psp3.robots.robot import Robot
from psp3.visualize.animation import Frames

MOST_DIGITS = 6
"""Behind the point: a nanometer."""


class TrackingError(NamedTuple):
    """An error at the frames of an animation: what it is of, and ``millimeters`` (n,)."""

    about: str
    millimeters: Array

    def as_command(self, seconds: float) -> dict[str, Any]:
        """Return what the page needs to follow it through an animation of so many seconds."""
        return {
            "about": self.about,
            "seconds": seconds,
            "digits": _digits(float(self.millimeters.max())),
            "millimeters": self.millimeters.round(MOST_DIGITS),
        }


def tracking_error(robot: Robot, frames: Frames) -> TrackingError | None:
    """Return how far the tip is from the desired tip at each frame.

    Of a robot without a tip, how far the joint is that is farthest from its place in the desired
    pose.

    Parameters
    ----------
    robot : Robot
        Whose frames they are.
    frames : Frames
        What is seen.

    Returns
    -------
    TrackingError or None
        None where nothing is desired, or nothing moves.
    """
    if frames.desired_positions is None or len(frames.time) == 1:
        return None
    if frames.tip is not None and frames.desired_tip is not None:
        return TrackingError("tip error", _millimeters(frames.tip, frames.desired_tip))
    actual, desired = (
        _joints(robot, positions) for positions in (frames.positions, frames.desired_positions)
    )
    return TrackingError("largest error of a joint", _millimeters(actual, desired).max(axis=1))


def _millimeters(actual: Array, desired: Array) -> Array:
    error: Array = 1e3 * np.linalg.norm(actual - desired, axis=-1)
    return error


def _joints(robot: Robot, positions: Array) -> Array:
    """Return the origins of all joints, (n, joints, 3) [m]."""
    data = robot.model.createData()
    places = []
    for q in robot.configuration(positions):
        pin.forwardKinematics(robot.model, data, q)
        places.append([placement.translation.copy() for placement in list(data.oMi)[1:]])
    return np.array(places)


def _digits(largest: float) -> int:
    """Return the digits behind the point with which the largest number has three in all."""
    if largest <= 0.0:
        return 1
    return int(np.clip(2 - np.floor(np.log10(largest)), 0, MOST_DIGITS))
