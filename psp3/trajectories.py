"""Desired motions: of the tip along a path, turned into nut heights with their rates by inverse kinematics.

A trajectory is called with a time or an array of times and returns a :class:`Motion`. A path that the tip cannot follow is an
error of that call; :meth:`Trajectory.check` also looks at the stroke of the screws, and a simulation does so before it starts.
"""

from __future__ import annotations

import csv
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from psp3.arrays import Array, as_floats, checked_not_negative, checked_positive, finite_rows, one_row
from psp3.errors import InvalidArray, InvalidTrajectoryFile, InvalidValue, StrokeExceeded
from psp3.robot import PSP3


class Motion(NamedTuple):
    """Nut heights [m] with their speeds [m/s] and accelerations [m/s²], and the tip [m]; all of shape (..., 3)."""

    heights: Array
    speeds: Array
    accelerations: Array
    tip: Array


@cache
def _default_robot() -> PSP3:
    from psp3.loading import load

    return load("psp3")


class Trajectory:
    """Base of the trajectories: a path of the tip in time.

    A subclass gives ``_tip(t)``, the tip's position, velocity and acceleration. What moves otherwise overrides ``__call__``.

    Parameters
    ----------
    robot : PSP3, optional
        Whose inverse kinematics is used; ``psp3.load("psp3")`` by default.
    """

    duration: float | None = None
    """Time after which the tip rests, None if it never does [s]."""

    def __init__(self, robot: PSP3 | None = None) -> None:
        self.robot = _default_robot() if robot is None else robot

    def __call__(self, t: ArrayLike) -> Motion:
        r"""Return the desired motion at given times.

        .. math:: \dot a = J^{-1} \dot x, \qquad \ddot a = J^{-1} (\ddot x - \dot J \dot a)

        Parameters
        ----------
        t : (...,) array_like
            Times from the start [s].

        Returns
        -------
        Motion
            ``.heights .speeds .accelerations .tip``, each (..., 3).

        Raises
        ------
        InvalidArray
            If a time is not finite.
        UnreachableTip
            If the tip would have to leave its reach.
        """
        tip, velocity, acceleration = self._tip(finite_times(t))
        heights = self.robot.inverse_kinematics_tip(tip)
        speeds, accelerations = self.robot.rates_of_tip(heights, velocity, acceleration)
        return Motion(heights, speeds, accelerations, tip)

    def _tip(self, t: Array) -> tuple[Array, Array, Array]:
        raise NotImplementedError(f"{type(self).__name__} must return the tip's position, velocity and acceleration")

    def check(self, t: ArrayLike) -> Motion:
        """Return the motion at given times, provided that the robot can make it.

        Parameters
        ----------
        t : (N,) array_like
            Times [s].

        Returns
        -------
        Motion
            As from a call.

        Raises
        ------
        InvalidArray, UnreachableTip
            As from a call.
        StrokeExceeded
            If a nut would have to leave its screw.
        """
        motion = self(t)
        check_stroke(self.robot, np.asarray(t, dtype=float), motion)
        return motion


def check_stroke(robot: PSP3, t: Array, motion: Motion) -> None:
    """Raise :class:`StrokeExceeded` for the first time at which a motion leaves the stroke of the screws."""
    lower, upper = robot.stroke
    outside = ((motion.heights < lower) | (motion.heights > upper)).any(axis=-1)
    if outside.any():
        first = np.unravel_index(int(np.argmax(outside)), outside.shape)
        raise StrokeExceeded(float(np.broadcast_to(t, outside.shape)[first]), motion.heights[first], lower, upper)


def finite_times(t: ArrayLike) -> Array:
    """Return times as a float array of any shape; raise :class:`InvalidArray` if one is not finite."""
    times = as_floats("t", t, "(...,)").reshape(np.shape(t))
    if not np.isfinite(times).all():
        raise InvalidArray("t", "(...,)", times)
    return times


def _finite(name: str, value: float) -> float:
    if not np.isfinite(value):
        raise InvalidValue(name, value, "finite")
    return float(value)


class Helix(Trajectory):
    r"""A helix about the vertical axis, the thesis's trajectory.

    .. math:: x(t) = \big( r \cos\omega t,\; r \sin\omega t,\; z_0 + \dot z t \big), \qquad \omega = 2\pi / T

    Parameters
    ----------
    radius : float
        Radius r [m]. The tip's reach is least at the azimuths of the screws, 23.9 mm.
    period : float
        Time T for one turn [s].
    rise : float
        Vertical speed [m/s].
    height : float, optional
        Height of the tip at the start [m]; that of the home pose by default.
    robot : PSP3, optional
        See :class:`Trajectory`.

    Raises
    ------
    InvalidValue
        If the radius is negative, the period is not positive, or a number is not finite.
    """

    def __init__(
        self, radius: float = 0.020, period: float = 2.0, rise: float = 0.010, height: float | None = None, robot: PSP3 | None = None
    ) -> None:
        super().__init__(robot)
        self.radius = checked_not_negative("radius", radius)
        self.period = checked_positive("period", period)
        self.rise = _finite("rise", rise)
        self.height = self.robot.parameters.tool_length if height is None else _finite("height", height)

    def _tip(self, t: Array) -> tuple[Array, Array, Array]:
        omega = 2.0 * np.pi / self.period
        x, y = self.radius * np.cos(omega * t), self.radius * np.sin(omega * t)
        zero = np.zeros_like(t)
        return (
            np.stack([x, y, self.height + self.rise * t], axis=-1),
            np.stack([-omega * y, omega * x, zero + self.rise], axis=-1),
            np.stack([-(omega**2) * x, -(omega**2) * y, zero], axis=-1),
        )


class Circle(Helix):
    """A level circle about the vertical axis: a :class:`Helix` that does not rise.

    Parameters
    ----------
    radius, period, height, robot
        See :class:`Helix`.
    """

    def __init__(self, radius: float = 0.020, period: float = 2.0, height: float | None = None, robot: PSP3 | None = None) -> None:
        super().__init__(radius, period, 0.0, height, robot)


class Hold(Trajectory):
    """A tip that rests.

    Parameters
    ----------
    tip : (3,) array_like, optional
        Where [m]; the tip of the home pose by default.
    robot : PSP3, optional
        See :class:`Trajectory`.
    """

    duration = 0.0

    def __init__(self, tip: ArrayLike | None = None, robot: PSP3 | None = None) -> None:
        super().__init__(robot)
        self.tip = np.array([0.0, 0.0, self.robot.parameters.tool_length]) if tip is None else one_row("tip", tip, 3)

    def _tip(self, t: Array) -> tuple[Array, Array, Array]:
        tip = np.broadcast_to(self.tip, (*t.shape, 3)).copy()
        return tip, np.zeros_like(tip), np.zeros_like(tip)


class _Segment(Trajectory):
    """A straight path from one point to another, in a given time, at rest before and after."""

    def __init__(self, start: ArrayLike, end: ArrayLike, duration: float, robot: PSP3 | None = None) -> None:
        super().__init__(robot)
        self.start, self.end = one_row("start", start, 3), one_row("end", end, 3)
        self.duration: float = checked_positive("duration", duration)

    def _progress(self, x: Array) -> tuple[Array, Array, Array]:
        """Share of the way at the share x of the time, within [0, 1], with its first and second derivative."""
        raise NotImplementedError

    def _tip(self, t: Array) -> tuple[Array, Array, Array]:
        moving = (t >= 0.0) & (t <= self.duration)
        share, rate, curvature = self._progress(np.clip(t / self.duration, 0.0, 1.0))
        way = self.end - self.start
        return (
            self.start + share[..., np.newaxis] * way,
            np.where(moving, rate / self.duration, 0.0)[..., np.newaxis] * way,
            np.where(moving, curvature / self.duration**2, 0.0)[..., np.newaxis] * way,
        )


class Line(_Segment):
    r"""A straight line at constant speed: :math:`x(t) = x_0 + (x_1 - x_0)\, t/T`, at rest before and after.

    The speed jumps at both ends; :class:`PointToPoint` starts and stops smoothly.

    Parameters
    ----------
    start, end : (3,) array_like
        Tip at time 0 and at time ``duration`` [m].
    duration : float
        Time T for the way [s].
    robot : PSP3, optional
        See :class:`Trajectory`.
    """

    def _progress(self, x: Array) -> tuple[Array, Array, Array]:
        return x, np.ones_like(x), np.zeros_like(x)


class PointToPoint(_Segment):
    r"""A straight line from rest to rest with continuous acceleration: the quintic :math:`s = 10x^3 - 15x^4 + 6x^5`, :math:`x = t/T`.

    Parameters
    ----------
    start, end, duration, robot
        See :class:`Line`.
    """

    def _progress(self, x: Array) -> tuple[Array, Array, Array]:
        return (
            x**3 * (10.0 - 15.0 * x + 6.0 * x**2),
            30.0 * x**2 * (1.0 - x) ** 2,
            60.0 * x * (1.0 - x) * (1.0 - 2.0 * x),
        )


class Waypoints(Trajectory):
    """A smooth path through given points at given times: a cubic spline, from rest to rest.

    Parameters
    ----------
    times : (N,) array_like
        Strictly increasing times, at least two [s].
    points : (N, 3) array_like
        Tip at these times [m].
    robot : PSP3, optional
        See :class:`Trajectory`.

    Raises
    ------
    InvalidArray
        If an array is not finite or has another shape.
    InvalidValue
        If the times do not increase.
    """

    def __init__(self, times: ArrayLike, points: ArrayLike, robot: PSP3 | None = None) -> None:
        from scipy.interpolate import CubicSpline

        super().__init__(robot)
        knots, values = _knots(times, points, minimum=2)
        self.duration: float = float(knots[-1])
        self._spline = CubicSpline(knots, values, bc_type="clamped")

    def _tip(self, t: Array) -> tuple[Array, Array, Array]:
        return _spline_motion(self._spline, t)


class FromCSV(Trajectory):
    """A recorded motion from a CSV file, smoothed by a cubic spline through its rows.

    The first line names the columns: ``t,x,y,z`` for a path of the tip, or ``t,a1,a2,a3`` for nut heights; seconds and meters,
    other columns are ignored. Before the first and after the last row the robot rests there.

    Parameters
    ----------
    path : path
        The file, with at least four rows of strictly increasing times.
    robot : PSP3, optional
        See :class:`Trajectory`.

    Raises
    ------
    InvalidTrajectoryFile
        If the file is missing, lacks the columns, or has a row that is not four finite numbers; the error names the line.
    """

    def __init__(self, path: str | Path, robot: PSP3 | None = None) -> None:
        from scipy.interpolate import CubicSpline

        super().__init__(robot)
        columns, table = _read_table(Path(path))
        self._of_heights = columns == ("t", "a1", "a2", "a3")
        try:
            knots, values = _knots(table[:, 0], table[:, 1:], minimum=4)
        except (InvalidArray, InvalidValue) as error:
            raise InvalidTrajectoryFile(path, str(error)) from error
        self.duration: float = float(knots[-1])
        self._spline = CubicSpline(knots, values)

    def __call__(self, t: ArrayLike) -> Motion:
        """Return the desired motion at given times; see :meth:`Trajectory.__call__`."""
        if not self._of_heights:
            return super().__call__(t)
        heights, speeds, accelerations = _spline_motion(self._spline, finite_times(t))
        return Motion(heights, speeds, accelerations, self.robot.forward_kinematics(heights).tip)

    def _tip(self, t: Array) -> tuple[Array, Array, Array]:
        return _spline_motion(self._spline, t)


def _knots(times: ArrayLike, points: ArrayLike, minimum: int) -> tuple[Array, Array]:
    values = finite_rows("points", points, 3)
    knots = finite_times(times)
    if values.ndim != 2 or knots.shape != values.shape[:1] or knots.size < minimum:
        raise InvalidArray("times and points", f"(N,) and (N, 3) with N of at least {minimum}", knots)
    late = np.flatnonzero(np.diff(knots) <= 0.0)
    if late.size:
        raise InvalidValue("times", float(knots[late[0] + 1]), f"later than the one before it, {knots[late[0]]:.6g} s")
    return knots, values


def _spline_motion(spline: object, t: Array) -> tuple[Array, Array, Array]:
    """Value and two derivatives of a spline, at rest outside its knots."""
    first, last = spline.x[0], spline.x[-1]  # type: ignore[attr-defined]
    moving = ((t >= first) & (t <= last))[..., np.newaxis]
    inside = np.clip(t, first, last)
    value, rate, curvature = (spline(inside, order) for order in range(3))  # type: ignore[operator]
    return value, np.where(moving, rate, 0.0), np.where(moving, curvature, 0.0)


def _read_table(path: Path) -> tuple[tuple[str, ...], Array]:
    """Columns and rows of a trajectory file."""
    try:
        lines = list(csv.reader(path.read_text(encoding="utf-8").splitlines()))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise InvalidTrajectoryFile(path, f"cannot be read ({getattr(error, 'strerror', None) or error})") from error
    header = [name.strip() for name in lines[0]] if lines else []
    for columns in (("t", "x", "y", "z"), ("t", "a1", "a2", "a3")):
        if set(columns) <= set(header):
            break
    else:
        raise InvalidTrajectoryFile(
            path, f"the first line must name the columns t,x,y,z or t,a1,a2,a3; it has {', '.join(header) or 'nothing'}"
        )
    places = [header.index(name) for name in columns]
    rows = []
    for number, cells in enumerate(lines[1:], start=2):
        if not any(cell.strip() for cell in cells):
            continue
        try:
            row = [float(cells[place]) for place in places]
        except (IndexError, ValueError) as error:
            raise InvalidTrajectoryFile(
                path, f"line {number}: expected numbers for {', '.join(columns)}, got {','.join(cells)!r}"
            ) from error
        if not np.isfinite(row).all():
            raise InvalidTrajectoryFile(path, f"line {number}: a number is not finite: {','.join(cells)!r}")
        rows.append(row)
    return columns, np.array(rows).reshape(-1, 4)
