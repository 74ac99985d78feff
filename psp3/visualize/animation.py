"""The frames of an animation.

They are the visible data of a result or a trajectory at even times, and MeshCat's tracks of them.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from psp3.checks import Array, check_periods
from psp3.errors import InvalidValue
from psp3.simulation.result import Result
from psp3.trajectories.trajectory import Trajectory

FRAME_RATE = 30.0
"""Frames per second of an animation; the browser interpolates between them."""

MOST_FRAMES = 10**6
"""Greatest number of frames, nine hours; a page cannot hold more."""

_TRACK_TYPES = {"position": "vector3", "quaternion": "quaternion", "scale": "vector3"}


class Frames(NamedTuple):
    """The visible data, frame by frame.

    ``time`` (n,) [s]; ``positions`` (n, k), positions of the actuated joints [m]; the others may be
    missing: ``tip`` (n, 3), ``desired_positions`` (n, k) and ``desired_tip`` (n, 3) [m], ``force``
    (n, 3) [N].
    """

    time: Array
    positions: Array
    tip: Array | None = None
    desired_positions: Array | None = None
    desired_tip: Array | None = None
    force: Array | None = None


def frames_of(motion: Result | Trajectory, duration: float | None = None) -> Frames:
    """Return the frames of a result, or of a trajectory.

    A result is shown in simulated time, a trajectory as its desired motion.

    Parameters
    ----------
    motion : Result or Trajectory
        What to show.
    duration : float, optional
        Time to follow a trajectory [s]; by default until it rests.

    Raises
    ------
    InvalidValue
        If a trajectory never rests and there is no duration.
    """
    if isinstance(motion, Trajectory):
        seconds = motion.duration if duration is None else duration
        if seconds is None or not (np.isfinite(seconds) and seconds > 0.0):
            raise InvalidValue(
                "duration",
                seconds,
                f"a positive time in seconds, since this {type(motion).__name__} never rests",
            )
        time = _even_times(0.0, seconds)
        desired = motion(time)
        return Frames(time, desired.positions, desired.tip)
    time = _even_times(motion.t[0], motion.t[-1])

    def at_frames(values: Array) -> Array:
        return np.stack([np.interp(time, motion.t, column) for column in values.T], axis=-1)

    return Frames(
        time,
        *map(
            at_frames,
            (
                motion.positions,
                motion.tip,
                motion.desired.positions,
                motion.desired.tip,
                motion.torque,
            ),
        ),
    )


def _even_times(start: float, end: float) -> Array:
    check_periods(end - start, 1.0 / FRAME_RATE, MOST_FRAMES)
    times: Array = np.linspace(start, end, max(2, round((end - start) * FRAME_RATE) + 1))
    return times


def clip(path: str, seconds: Array, tracks: Mapping[str, Array]) -> dict[str, Any]:
    """Return MeshCat's animation of a node.

    Parameters
    ----------
    path : str
        The node.
    seconds : (n,) ndarray
        Times of the frames [s].
    tracks : mapping of (n, 3) or (n, 4) ndarray
        ``"position"`` [m], ``"quaternion"`` (x, y, z, w) and ``"scale"``. To keep files small,
        constant tracks are left out, and a position or scale that changes along one axis has only
        this axis.
    """
    moving = []
    for name, values in tracks.items():
        axes = [
            axis for axis, column in zip("xyzw", values.T, strict=False) if np.ptp(column) > 1e-6
        ]
        if not axes:
            continue
        if len(axes) == 1 and name != "quaternion":
            track, kind, values = f".{name}[{axes[0]}]", "number", values[:, "xyz".index(axes[0])]
        else:
            track, kind = f".{name}", _TRACK_TYPES[name]
        moving.append(
            {
                "name": track,
                "type": kind,
                "times": seconds.round(4),
                "values": values.ravel().round(5),
            }
        )
    return {"path": path, "clip": {"name": "default", "fps": 1, "tracks": moving}}
