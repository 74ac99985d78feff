"""Motions given by samples: waypoints in Python, and tables in CSV files."""

from __future__ import annotations

import csv
import io
import itertools
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from fuzzy2.support.bounded_files import LARGEST_NUMBERS, content_of, not_read, shortened
from psp3.checks import Array, checked_path, checked_robot, finite_rows
from psp3.description.xml import LONGEST_SHOWN, NUMBER
from psp3.errors import InvalidArray, InvalidTrajectoryFile, InvalidValue
from psp3.robots.robot import Robot
from psp3.trajectories.motion import finite_times
from psp3.trajectories.smoothing import LEAST_MEASUREMENTS, smoothed_motion
from psp3.trajectories.trajectory import Trajectory

LEAST_GAP = 1e-9
"""Times closer to each other than this share of the whole duration count as the same time."""

MOST_MISSED = 1e-9
"""Largest error of a spline at its points, as a share of the largest coordinate. With even times,
rounding leaves 1e-15. If some intervals are 1e6 times as long as others, the curve overshoots so
far that its numbers lose all digits.
"""

MOST_ROWS = 1_000_000
"""The largest number of rows of a file."""


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

    Attributes
    ----------
    duration : float
        The last of the times [s].

    Raises
    ------
    InvalidArray
        If an array is not finite or has another shape.
    InvalidValue
        If the times do not increase, or there is no finite curve because two times are too close or
        numbers too large.
    """

    def __init__(
        self,
        times: ArrayLike,
        points: ArrayLike,
        robot: Robot | None = None,
        space: str | None = None,
    ) -> None:
        super().__init__(robot, space)
        knots, values = _knots(times, points, self.width, minimum=2)
        self.duration: float = float(knots[-1])
        self._spline = _spline(knots, values, "clamped")

    def _shape(self) -> dict[str, Any]:
        return {"points": len(self._spline.x)}

    def _path(self, t: Array) -> tuple[Array, Array, Array]:
        return _spline_motion(self._spline, t)


class FromCSV(Trajectory):
    """A recorded motion from a CSV file, smoothed by a cubic spline through its rows.

    The first line names the columns: ``t,x,y,z`` for a path of the tip, or ``t`` and the names of
    the actuated joints, ``t,a1,a2,a3`` for nut heights; in seconds, meters and radians. Other
    columns are ignored. Before the first row and after the last row the robot rests.

    Parameters
    ----------
    path : path
        The file, with at least four rows of strictly increasing times.
    robot : Robot, optional
        See :class:`Trajectory`.

    Attributes
    ----------
    duration : float
        Time of the last row [s].
    space : str
        ``"tip"`` or ``"joints"``, depending on the columns of the file.

    Raises
    ------
    InvalidTrajectoryFile
        If the file is missing, lacks the columns, or has a row that is not as many finite numbers;
        the error names the line.
    """

    def __init__(self, path: str | Path, robot: Robot | None = None) -> None:
        super().__init__(robot)
        columns = {"tip": ("t", "x", "y", "z")} if self.space == "tip" else {}
        self.space, table = _read_table(
            checked_path("path", path), columns | {"joints": ("t", *self.robot.actuated)}
        )
        try:
            knots, values = _knots(table[:, 0], table[:, 1:], self.width, minimum=4)
            self._spline = _spline(knots, values, "not-a-knot")
        except (InvalidArray, InvalidValue) as error:
            raise InvalidTrajectoryFile(path, str(error)) from error
        self.duration: float = float(knots[-1])

    def _shape(self) -> dict[str, Any]:
        return {"rows": len(self._spline.x)}

    def _path(self, t: Array) -> tuple[Array, Array, Array]:
        return _spline_motion(self._spline, t)


class MeasuredMotion(NamedTuple):
    """Measured samples: times (N,), and for each motor the other quantities (N, n).

    ``t`` [s], ``positions`` [m or rad], ``speeds``, ``accelerations`` [per s, per s²] and
    ``forces`` [N or N m].
    """

    t: Array
    positions: Array
    speeds: Array
    accelerations: Array
    forces: Array


def measured_motion(path: str | Path, robot: Robot) -> MeasuredMotion:
    """Return the recorded motion and forces of a CSV file.

    The first line names the columns: ``t``, the motors and their forces, ``t,A,B,force_A,force_B``
    of motors A and B, or ``t,a1,a2,force1,force2`` as ``psp3 simulate --csv`` and ``psp3 torques
    --csv`` write; in seconds, meters, radians, N and N m. Other columns are ignored. Positions,
    speeds and accelerations are those of a smooth curve near the measured positions, which
    cross-validation selects (:mod:`psp3.trajectories.smoothing`). Forces are as measured.

    Parameters
    ----------
    path : path
        The file, with at least twelve rows of strictly increasing times.
    robot : Robot
        The robot that moves.

    Returns
    -------
    MeasuredMotion
        ``.t .positions .speeds .accelerations .forces``.

    Raises
    ------
    InvalidTrajectoryFile
        If the file is missing, lacks the columns, or has a row that is not as many finite numbers;
        the error names the line.
    """
    checked_robot(robot)
    names, numbers = robot.actuated, range(1, len(robot.actuated) + 1)
    own = "t", *names, *(f"force_{name}" for name in names)
    numbered = "t", *(f"a{k}" for k in numbers), *(f"force{k}" for k in numbers)
    _, table = _read_table(checked_path("path", path), {"names": own, "numbers": numbered})
    try:
        t, rows = _knots(table[:, 0], table[:, 1:], 2 * len(names), minimum=LEAST_MEASUREMENTS)
        positions, forces = np.split(rows, 2, axis=1)
        motion = smoothed_motion(t, positions)(t)
    except (InvalidArray, InvalidValue) as error:
        raise InvalidTrajectoryFile(path, str(error)) from error
    return MeasuredMotion(t, *motion, forces)


def _knots(times: ArrayLike, points: ArrayLike, width: int, minimum: int) -> tuple[Array, Array]:
    values = finite_rows("points", points, width)
    knots = finite_times(times)
    if values.ndim != 2 or knots.shape != values.shape[:1] or knots.size < minimum:
        raise InvalidArray(
            "times and points", f"(N,) and (N, {width}) with N of at least {minimum}", knots
        )
    late = np.flatnonzero(np.diff(knots) <= 0.0)
    if late.size:
        raise InvalidValue(
            "times",
            float(knots[late[0] + 1]),
            f"later than the one before it, {knots[late[0]]:.6g} s",
        )
    gaps = np.diff(knots)
    if not gaps.min() >= LEAST_GAP * gaps.sum():
        raise InvalidValue(
            "times",
            float(knots[1 + int(gaps.argmin())]),
            f"at least {LEAST_GAP:g} of the whole time after the one before it",
        )
    return knots, values


def _spline(knots: Array, values: Array, ends: str) -> Any:
    """Return the cubic spline through points; raise if its numbers are not all finite."""
    from scipy.interpolate import CubicSpline

    try:
        with np.errstate(all="ignore"):
            spline = CubicSpline(knots, values, bc_type=ends)
    except (ValueError, np.linalg.LinAlgError):
        spline = None
    if spline is None or not np.isfinite(spline.c).all():
        raise InvalidValue(
            "points",
            float(np.abs(values).max()),
            f"such that a smooth curve goes through them in {knots[-1] - knots[0]:.6g} s: its "
            "speeds or accelerations are not finite",
        )
    missed = _missed(spline, values)
    if missed.max() > MOST_MISSED * np.abs(values).max():
        late = int(missed.argmax()) + 1
        raise InvalidValue(
            "times",
            float(knots[late]),
            f"at more even distances: a cubic curve would miss the point at {knots[late]:.6g} s by "
            f"{missed.max():.2g}, since times before it are so much nearer to each other; put "
            "points between",
        )
    return spline


def _missed(spline: Any, values: Array) -> Array:
    """Return the error of each piece at its end point; at its start point it is exact."""
    length = np.diff(spline.x)[:, np.newaxis]
    ends = ((spline.c[0] * length + spline.c[1]) * length + spline.c[2]) * length + spline.c[3]
    return np.asarray(np.abs(ends - values[1:]).max(axis=1))


def _spline_motion(spline: object, t: Array) -> tuple[Array, Array, Array]:
    """Return the value and two derivatives of a spline, at rest outside its knots."""
    first, last = spline.x[0], spline.x[-1]  # type: ignore[attr-defined]
    moving = ((t >= first) & (t <= last))[..., np.newaxis]
    inside = np.clip(t, first, last)
    value, rate, curvature = (spline(inside, order) for order in range(3))  # type: ignore[operator]
    return value, np.where(moving, rate, 0.0), np.where(moving, curvature, 0.0)


def _read_table(path: Path, known: dict[str, tuple[str, ...]]) -> tuple[str, Array]:
    """Return which of the known sets of columns a trajectory file has, and its rows."""
    try:
        text = content_of(path, LARGEST_NUMBERS).decode("utf-8-sig")
        lines = csv.reader(io.StringIO(text, newline=""), strict=True)
        header = [name.strip() for name in next(lines, [])]
        space, columns = _known_columns(path, header, known)
        places = [header.index(name) for name in columns]
        rows = [
            _row(path, lines.line_num, cells, header, places)
            for cells in itertools.islice(lines, MOST_ROWS)
            if any(cell.strip() for cell in cells)
        ]
        if next(lines, None) is not None:
            raise InvalidTrajectoryFile(path, f"has more than {MOST_ROWS} rows: thin it out")
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise InvalidTrajectoryFile(path, not_read(error)) from error
    return space, np.array(rows).reshape(-1, len(columns))


def _known_columns(
    path: Path, header: list[str], known: dict[str, tuple[str, ...]]
) -> tuple[str, tuple[str, ...]]:
    """Return which of the known sets of columns a header has, each of them once."""
    matching = [space for space, columns in known.items() if set(columns) <= set(header)]
    if not matching:
        choices = " or ".join(map(",".join, known.values()))
        raise InvalidTrajectoryFile(
            path,
            f"the first line must name the columns {choices}; it has "
            f"{shortened(', '.join(header), 500) or 'nothing'}",
        )
    columns = known[matching[0]]
    twice = [name for name in columns if header.count(name) > 1]
    if twice:
        raise InvalidTrajectoryFile(
            path, f"the first line names {', '.join(twice)} twice: take one of the columns out"
        )
    return matching[0], columns


def _row(
    path: Path, line: int, cells: list[str], header: list[str], places: list[int]
) -> list[float]:
    """Return the numbers at some places of a row, which must have as many cells as the header."""
    written = ",".join(cells)[:LONGEST_SHOWN]
    if len(cells) != len(header):
        raise InvalidTrajectoryFile(
            path,
            f"line {line}: expected {len(header)} cells, as many as in the first line, got "
            f"{len(cells)}: {written!r}; numbers are written with a point, as 0.5",
        )
    words = [cells[place].strip() for place in places]
    if not all(map(NUMBER.fullmatch, words)):
        raise InvalidTrajectoryFile(
            path,
            f"line {line}: expected finite numbers for {', '.join(header[at] for at in places)}, "
            f"got {written!r}",
        )
    row = [float(word) for word in words]
    if not np.isfinite(row).all():
        raise InvalidTrajectoryFile(path, f"line {line}: a number is not finite: {written!r}")
    return row
