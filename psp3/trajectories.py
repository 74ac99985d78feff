"""Desired motions: of the tip along a path, turned into nut heights with their rates by inverse kinematics, or of the joints.

A trajectory is called with a time or an array of times and returns a :class:`Motion`. The tip's are those of the 3-PSP, whose inverse
kinematics is known; motions of the actuated joints are those of any robot. A path that the robot cannot follow is an error of that call;
:meth:`Trajectory.check` also looks at the limits of the actuated joints, and a simulation does so before it starts.
"""

from __future__ import annotations

import csv
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from psp3.arrays import Array, as_floats, checked_not_negative, checked_positive, finite_rows, one_row
from psp3.closed_loop_robot import ClosedLoopRobot
from psp3.collisions import check_clearance
from psp3.errors import InvalidArray, InvalidTrajectoryFile, InvalidValue, StrokeExceeded, UnknownName
from psp3.robot import PSP3

SPACES = ("tip", "joints")
"""Names of the spaces in which a path can be given."""


class Motion(NamedTuple):
    """Nut heights [m] with their speeds [m/s] and accelerations [m/s²], and the tip [m]; all of shape (..., 3).

    Of another robot than the 3-PSP, positions, speeds and accelerations of its n actuated joints [m or rad], (..., n); the tip is its
    frame ``tip``, and NaN if it has none.
    """

    heights: Array
    speeds: Array
    accelerations: Array
    tip: Array

    @property
    def positions(self) -> Array:
        """The heights by the name that fits every robot: positions of the actuated joints, (..., n)."""
        return self.heights


@cache
def _default_robot() -> PSP3:
    from psp3.loading import load

    return load("psp3")


class Trajectory:
    """Base of the trajectories: a path in time, of the tip or of the actuated joints.

    A subclass gives ``_path(t)``, the position on the path with its velocity and acceleration. What moves otherwise overrides
    ``__call__``.

    Parameters
    ----------
    robot : ClosedLoopRobot, optional
        Whose motion it is; ``psp3.load("psp3")`` by default.
    space : str, optional
        ``"tip"``, a path of the tip in base axes [m], or ``"joints"``, of the n actuated joints [m or rad]. By default the tip of a 3-PSP,
        and the joints of any other robot.

    Raises
    ------
    UnknownName
        If there is no such space.
    InvalidValue
        If the path is to be one of the tip, and the robot is not a 3-PSP.
    """

    duration: float | None = None
    """Time after which the robot rests, None if it never does [s]."""

    def __init__(self, robot: ClosedLoopRobot | None = None, space: str | None = None) -> None:
        self.robot: ClosedLoopRobot = _default_robot() if robot is None else robot
        has_inverse = isinstance(self.robot, PSP3)
        self.space = ("tip" if has_inverse else "joints") if space is None else space
        if self.space not in SPACES:
            raise UnknownName("space", space, SPACES)
        if self.space == "tip" and not has_inverse:
            raise InvalidValue("space", "tip", "'joints' for another robot than the 3-PSP, whose tip has an inverse kinematics")

    @property
    def width(self) -> int:
        """Number of coordinates of a point on the path."""
        return 3 if self.space == "tip" else len(self.robot.actuated)

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
            ``.heights .speeds .accelerations``, each (..., n), and ``.tip`` (..., 3).

        Raises
        ------
        InvalidArray
            If a time is not finite.
        UnreachableTip
            If the tip would have to leave its reach.
        UnreachablePose, ClosureFailed, JointLimitExceeded
            If the joints lead to a pose that the robot cannot take.
        """
        point, velocity, acceleration = self._path(finite_times(t))
        if self.space == "joints" or not isinstance(self.robot, PSP3):
            return Motion(point, velocity, acceleration, tip_of(self.robot, point))
        heights = self.robot.inverse_kinematics_tip(point)
        speeds, accelerations = self.robot.rates_of_tip(heights, velocity, acceleration)
        return Motion(heights, speeds, accelerations, point)

    def _path(self, t: Array) -> tuple[Array, Array, Array]:
        raise NotImplementedError(f"{type(self).__name__} must return a position with its velocity and acceleration")

    def check(self, t: ArrayLike, clearance: float | None = None) -> Motion:
        """Return the motion at given times, provided that the robot can make it.

        Parameters
        ----------
        t : (N,) array_like
            Times [s].
        clearance : float, optional
            Least distance that links must keep from each other [m]; not looked at by default.

        Returns
        -------
        Motion
            As from a call.

        Raises
        ------
        InvalidArray, UnreachableTip, UnreachablePose, ClosureFailed, JointLimitExceeded
            As from a call.
        StrokeExceeded
            If a nut would have to leave its screw, or another actuated joint its limits.
        CollisionFound
            If two links would come nearer to each other than ``clearance``.
        """
        motion = self(t)
        check_stroke(self.robot, np.asarray(t, dtype=float), motion)
        if clearance is not None:
            check_clearance(self.robot, motion.heights, t, clearance)
        return motion


def tip_of(robot: ClosedLoopRobot, positions: Array) -> Array:
    """Return the frame ``tip`` at actuated positions (..., n), in base axes (..., 3) [m]; NaN if the robot has no such frame."""
    if isinstance(robot, PSP3):
        return robot.forward_kinematics(positions).tip
    if robot.model.existFrame("tip"):
        return robot.frame_placement(positions, "tip")[..., :3, 3]
    # A pose that is none is refused without a tip, too.
    robot.configuration(positions)
    return np.full((*positions.shape[:-1], 3), np.nan)


def check_stroke(robot: ClosedLoopRobot, t: Array, motion: Motion) -> None:
    """Raise :class:`StrokeExceeded` for the first time at which a motion leaves the limits of the actuated joints."""
    lower, upper = robot.limits
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


def _home(robot: ClosedLoopRobot) -> Array:
    """Tip of a 3-PSP in its home pose."""
    assert isinstance(robot, PSP3)
    return np.array([0.0, 0.0, robot.parameters.tool_length])


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
        If the radius is negative, the period is not positive, a number is not finite, or the robot is not a 3-PSP.
    """

    def __init__(
        self, radius: float = 0.020, period: float = 2.0, rise: float = 0.010, height: float | None = None, robot: PSP3 | None = None
    ) -> None:
        super().__init__(robot, "tip")
        self.radius = checked_not_negative("radius", radius)
        self.period = checked_positive("period", period)
        self.rise = _finite("rise", rise)
        self.height = float(_home(self.robot)[2]) if height is None else _finite("height", height)

    def _path(self, t: Array) -> tuple[Array, Array, Array]:
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
    """A robot that rests.

    Parameters
    ----------
    point : array_like, optional
        Where the tip is, (3,) [m], or the actuated joints are, (n,) [m or rad]; by default those of the home or reference pose.
    robot, space
        See :class:`Trajectory`.
    """

    duration = 0.0

    def __init__(self, point: ArrayLike | None = None, robot: ClosedLoopRobot | None = None, space: str | None = None) -> None:
        super().__init__(robot, space)
        if point is None:
            self.point = _home(self.robot) if self.space == "tip" else self.robot.reference
        else:
            self.point = one_row("point", point, self.width)

    def _path(self, t: Array) -> tuple[Array, Array, Array]:
        point = np.broadcast_to(self.point, (*t.shape, self.width)).copy()
        return point, np.zeros_like(point), np.zeros_like(point)


class _Segment(Trajectory):
    """A straight path from one point to another, in a given time, at rest before and after."""

    def __init__(
        self, start: ArrayLike, end: ArrayLike, duration: float, robot: ClosedLoopRobot | None = None, space: str | None = None
    ) -> None:
        super().__init__(robot, space)
        self.start, self.end = one_row("start", start, self.width), one_row("end", end, self.width)
        self.duration: float = checked_positive("duration", duration)

    def _progress(self, x: Array) -> tuple[Array, Array, Array]:
        """Share of the way at the share x of the time, within [0, 1], with its first and second derivative."""
        raise NotImplementedError

    def _path(self, t: Array) -> tuple[Array, Array, Array]:
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
    start, end : array_like
        Tip, (3,) [m], or actuated joints, (n,) [m or rad], at time 0 and at time ``duration``.
    duration : float
        Time T for the way [s].
    robot, space
        See :class:`Trajectory`.
    """

    def _progress(self, x: Array) -> tuple[Array, Array, Array]:
        return x, np.ones_like(x), np.zeros_like(x)


class PointToPoint(_Segment):
    r"""A straight line from rest to rest with continuous acceleration: the quintic :math:`s = 10x^3 - 15x^4 + 6x^5`, :math:`x = t/T`.

    Parameters
    ----------
    start, end, duration, robot, space
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
    points : (N, k) array_like
        Tip, k = 3 [m], or actuated joints, k = n [m or rad], at these times.
    robot, space
        See :class:`Trajectory`.

    Raises
    ------
    InvalidArray
        If an array is not finite or has another shape.
    InvalidValue
        If the times do not increase.
    """

    def __init__(self, times: ArrayLike, points: ArrayLike, robot: ClosedLoopRobot | None = None, space: str | None = None) -> None:
        from scipy.interpolate import CubicSpline

        super().__init__(robot, space)
        knots, values = _knots(times, points, self.width, minimum=2)
        self.duration: float = float(knots[-1])
        self._spline = CubicSpline(knots, values, bc_type="clamped")

    def _path(self, t: Array) -> tuple[Array, Array, Array]:
        return _spline_motion(self._spline, t)


class FromCSV(Trajectory):
    """A recorded motion from a CSV file, smoothed by a cubic spline through its rows.

    The first line names the columns: ``t,x,y,z`` for a path of the tip, or ``t`` and the names of the actuated joints, ``t,a1,a2,a3``
    for nut heights; seconds, meters and radians, other columns are ignored. Before the first and after the last row the robot rests
    there.

    Parameters
    ----------
    path : path
        The file, with at least four rows of strictly increasing times.
    robot : ClosedLoopRobot, optional
        See :class:`Trajectory`.

    Raises
    ------
    InvalidTrajectoryFile
        If the file is missing, lacks the columns, or has a row that is not as many finite numbers; the error names the line.
    """

    def __init__(self, path: str | Path, robot: ClosedLoopRobot | None = None) -> None:
        from scipy.interpolate import CubicSpline

        super().__init__(robot)
        columns = {"tip": ("t", "x", "y", "z")} if self.space == "tip" else {}
        self.space, table = _read_table(Path(path), columns | {"joints": ("t", *self.robot.actuated)})
        try:
            knots, values = _knots(table[:, 0], table[:, 1:], self.width, minimum=4)
        except (InvalidArray, InvalidValue) as error:
            raise InvalidTrajectoryFile(path, str(error)) from error
        self.duration: float = float(knots[-1])
        self._spline = CubicSpline(knots, values)

    def _path(self, t: Array) -> tuple[Array, Array, Array]:
        return _spline_motion(self._spline, t)


def _knots(times: ArrayLike, points: ArrayLike, width: int, minimum: int) -> tuple[Array, Array]:
    values = finite_rows("points", points, width)
    knots = finite_times(times)
    if values.ndim != 2 or knots.shape != values.shape[:1] or knots.size < minimum:
        raise InvalidArray("times and points", f"(N,) and (N, {width}) with N of at least {minimum}", knots)
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


def _read_table(path: Path, known: dict[str, tuple[str, ...]]) -> tuple[str, Array]:
    """Which of the known sets of columns a trajectory file has, and its rows."""
    try:
        lines = list(csv.reader(path.read_text(encoding="utf-8").splitlines()))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise InvalidTrajectoryFile(path, f"cannot be read ({getattr(error, 'strerror', None) or error})") from error
    header = [name.strip() for name in lines[0]] if lines else []
    matching = [space for space, columns in known.items() if set(columns) <= set(header)]
    if not matching:
        choices = " or ".join(map(",".join, known.values()))
        raise InvalidTrajectoryFile(path, f"the first line must name the columns {choices}; it has {', '.join(header) or 'nothing'}")
    columns = known[matching[0]]
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
    return matching[0], np.array(rows).reshape(-1, len(columns))
