"""What a trajectory returns, and what every trajectory checks."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from psp3.checks import Array, finite_array
from psp3.errors import StrokeExceeded
from psp3.robots.closed_loop_robot import ClosedLoopRobot


class Motion(NamedTuple):
    """Nut heights [m] with their speeds [m/s] and accelerations [m/s²], and the tip [m].

    All of shape (..., 3).

    Of another robot than the 3-PSP, positions, speeds and accelerations of its n actuated joints [m
    or rad], (..., n); the tip is its frame ``tip``, and NaN if it has none.
    """

    heights: Array
    speeds: Array
    accelerations: Array
    tip: Array

    @property
    def positions(self) -> Array:
        """The heights by the name that fits every robot.

        Positions of the actuated joints, (..., n).
        """
        return self.heights


def tip_of(robot: ClosedLoopRobot, positions: Array) -> Array:
    """Return the frame ``tip`` at actuated positions (..., n), in base axes (..., 3) [m].

    NaN if the robot has no such frame.
    """
    return robot.tip(positions)


def check_stroke(robot: ClosedLoopRobot, t: Array, motion: Motion) -> None:
    """Raise :class:`StrokeExceeded` where a motion leaves the limits.

    At the first time; the limits are those of the actuated joints.
    """
    lower, upper = robot.limits
    outside = ((motion.heights < lower) | (motion.heights > upper)).any(axis=-1)
    if outside.any():
        first = np.unravel_index(int(np.argmax(outside)), outside.shape)
        raise StrokeExceeded(
            float(np.broadcast_to(t, outside.shape)[first]), motion.heights[first], lower, upper
        )


def finite_times(t: ArrayLike) -> Array:
    """Return times as a float array of any shape.

    Raise :class:`InvalidArray` if one is not finite.
    """
    return finite_array("t", t)
