"""The result of a trajectory, and the checks of all trajectories."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from psp3.checks import Array, as_floats, checked_kind, checked_robot, finite_array
from psp3.errors import InvalidArray, InvalidValue, StrokeExceeded
from psp3.robots.robot import Robot


class Motion(NamedTuple):
    """Positions of the n actuated joints with their speeds and accelerations, and the tip.

    The first three are of shape (..., n) [m or rad, per s, per s²]; for the 3-PSP they are nut
    heights and their rates. The tip is of shape (..., 3) [m]; it is NaN if the robot has no frame
    ``tip``.
    """

    positions: Array
    speeds: Array
    accelerations: Array
    tip: Array

    @property
    def heights(self) -> Array:
        """The positions, under their name for the 3-PSP."""
        return self.positions


def tip_of(robot: Robot, positions: Array) -> Array:
    """Return the frame ``tip`` at actuated positions (..., n), in base axes (..., 3) [m].

    NaN if the robot has no such frame. Positions may be :func:`completed`.
    """
    checked_robot(robot)
    return robot.tip(completed(robot, finite_array("positions", positions)))


def completed(robot: Robot, positions: Array) -> Array:
    """Add the positions of coordinates that follow to (..., k); return (..., p).

    These have their positions in the reference pose.
    """
    k, p = np.shape(positions)[-1:], len(robot.reference)
    if k not in ((p,), (robot.commanded,)):
        raise InvalidArray("positions", f"(..., {robot.commanded})", positions)
    others = robot.reference[k[0] :]
    if not others.size:
        return positions
    shape = (*np.shape(positions)[:-1], others.size)
    return np.concatenate([positions, np.broadcast_to(others, shape)], axis=-1)


def check_stroke(robot: Robot, t: Array, motion: Motion) -> None:
    """Raise :class:`StrokeExceeded` if a motion leaves the limits.

    The error names the first time; the limits are those of the actuated joints.
    """
    checked_robot(robot)
    checked_kind("motion", motion, Motion, "what a trajectory returns, a Motion")
    t, k = finite_times(t), motion.positions.shape[-1]
    lower, upper = (limit[:k] for limit in robot.limits)
    outside = ((motion.positions < lower) | (motion.positions > upper)).any(axis=-1)
    if outside.any():
        first = np.unravel_index(int(np.argmax(outside)), outside.shape)
        raise StrokeExceeded(
            float(np.broadcast_to(t, outside.shape)[first]), motion.positions[first], lower, upper
        )


def motion_at(trajectory: Any, t: Array | NDArray[np.floating[Any]], width: int) -> Motion:
    """Return a trajectory's motion at times (N,), of ``width`` joints.

    Trajectories may be functions of the user's own, so what they return is checked.

    Raises
    ------
    InvalidValue, InvalidArray
        If it is not a :class:`Motion` with one row of finite numbers for each time, and of a tip,
        which may be NaN.
    """
    motion = trajectory(t)
    checked_kind(
        "what the trajectory returns",
        motion,
        Motion,
        "a psp3.trajectories.Motion of positions, speeds, accelerations and tip",
    )
    columns, parts = np.shape(as_floats("positions of the trajectory", motion[0], "(N, n)")), []
    if columns[1:] not in ((), (width,)):
        raise InvalidValue("trajectory", trajectory, f"a motion of {width} actuated joints")
    for field, values in zip(Motion._fields, motion, strict=True):
        name, shape = f"{field} of the trajectory", (len(t), 3 if field == "tip" else width)
        part = as_floats(name, values, str(shape))
        is_finite = field == "tip" or np.isfinite(part).all()
        if np.shape(values) != shape or not is_finite:
            raise InvalidArray(name, str(shape), values)
        parts.append(part)
    return Motion(*parts)


def finite_times(t: ArrayLike) -> Array:
    """Return times as a float array of any shape.

    Raise :class:`InvalidArray` if one is not finite.
    """
    return finite_array("t", t)
