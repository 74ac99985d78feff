"""The distance of a robot from its desired position, for the label above it."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin

from psp3.checks import Array
from psp3.robots.robot import Robot
from psp3.visualize.animation import Frames

MOST_DIGITS = 6
"""Greatest number of decimals, for a nanometer."""


class TrackingError(NamedTuple):
    """An error at the frames of an animation: its description, and ``millimeters`` (n,)."""

    about: str
    millimeters: Array

    def as_command(self, seconds: float) -> dict[str, Any]:
        """Return the command that shows the error during an animation of a given time."""
        return {
            "about": self.about,
            "seconds": seconds,
            "digits": _digits(float(self.millimeters.max())),
            "millimeters": self.millimeters.round(MOST_DIGITS),
        }


def tracking_error(robot: Robot, frames: Frames) -> TrackingError | None:
    """Return the distance of the tip from the desired tip at each frame.

    For a robot without a tip it is the greatest distance of a joint from its position in the
    desired pose.

    Parameters
    ----------
    robot : Robot
        Robot of the frames.
    frames : Frames
        Frames of the animation.

    Returns
    -------
    TrackingError or None
        None if there is no desired motion, or no motion at all.
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
    """Return the number of decimals that gives the largest number three digits."""
    if largest <= 0.0:
        return 1
    return int(np.clip(2 - np.floor(np.log10(largest)), 0, MOST_DIGITS))
