"""Collisions along a motion.

The module finds the smallest distance between links, the first contact, and the links involved.

:mod:`psp3.collisions.model` holds the shapes and measures one pose; :mod:`psp3.collisions.pairs`
selects the pairs that are checked.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from psp3.checks import (
    Array,
    as_floats,
    checked_kind,
    checked_not_negative,
    checked_robot,
    finite_rows,
)
from psp3.collisions.model import CollisionModel, Nearest, collision_model
from psp3.errors import CollisionFound, InvalidArray
from psp3.robots.robot import Robot

BISECTIONS = 40
"""Number of bisections of the time between two samples in which links come too close; the remaining
interval is a trillionth.
"""


class Contact(NamedTuple):
    """Two links at one time: ``time`` [s], ``positions`` of the actuated joints (n,).

    ``nearest`` holds their distance.
    """

    time: float
    positions: Array
    nearest: Nearest


@dataclass(frozen=True)
class Report:
    """How near the links of a robot come to each other along a motion.

    Parameters
    ----------
    time : (N,) ndarray
        Times of the samples [s].
    distance : (N,) ndarray
        Distance of the two nearest links, negative if they overlap [m].
    pair : (N,) ndarray of int
        Index of these links in ``pairs``.
    pairs : tuple of (str, str)
        The pairs of links that were checked.
    clearance : float
        The required distance [m].
    nearest : Contact
        The sample at which links are nearest.
    first : Contact or None
        The first time at which two links come as close as the clearance, also between samples; None
        if they never do.
    """

    time: Array
    distance: Array
    pair: NDArray[np.int64]
    pairs: tuple[tuple[str, str], ...]
    clearance: float
    nearest: Contact
    first: Contact | None


def check(
    robot: Robot,
    positions: ArrayLike,
    time: ArrayLike | None = None,
    clearance: float = 0.0,
    model: CollisionModel | None = None,
) -> Report:
    """Return how near the links of a robot come to each other along a motion.

    Each pose is closed from the preceding one, so the assembly mode is kept. Between the two
    samples in which links come too close, the actuated joints are assumed to move at constant
    speed. A contact that begins and ends between two samples is not detected.

    Parameters
    ----------
    robot : Robot
        The robot.
    positions : (N, n) array_like
        Positions of the actuated joints [m or rad], such as ``trajectory(t).positions`` or
        ``result.positions``.
    time : (N,) array_like, optional
        Times of the samples, increasing [s]; by default their numbers.
    clearance : float
        Smallest allowed distance between links [m].
    model : CollisionModel, optional
        Shapes and pairs; by default those of the file that the robot was loaded from, see
        :func:`psp3.collisions.model.collision_model`.

    Returns
    -------
    Report

    Raises
    ------
    InvalidArray, InvalidValue
        If an argument is malformed.
    ClosureFailed, JointLimitExceeded
        If a pose is unreachable, see ``robot.configurations_along``.
    InvalidRobotFile, OverlappingShapes
        If the robot has no usable shapes, see :func:`psp3.collisions.model.collision_model`.
    """
    checked_robot(robot)
    wanted = "a CollisionModel, or None for that of the robot's file"
    checked_kind("model", model, (CollisionModel, type(None)), wanted)
    path = finite_rows("positions", positions, len(robot.reference))
    if path.ndim != 2 or not len(path):
        raise InvalidArray("positions", f"(N, {len(robot.reference)}) with N of at least 1", path)
    times = np.arange(float(len(path))) if time is None else as_floats("time", time, "(N,)")
    if (
        times.shape != path.shape[:1]
        or not np.isfinite(times).all()
        or (np.diff(times) <= 0.0).any()
    ):
        raise InvalidArray("time", f"({len(path)},), one for each sample and increasing", times)
    clearance = checked_not_negative("clearance", clearance)
    model = collision_model(robot) if model is None else model
    configurations = robot.configurations_along(path)
    distance, pair = model.least_distances(configurations)
    least = int(np.argmin(distance))
    return Report(
        time=times,
        distance=distance,
        pair=pair,
        pairs=model.pairs,
        clearance=clearance,
        nearest=Contact(float(times[least]), path[least], model.nearest_at(configurations[least])),
        first=_first_contact(model, path, times, configurations, distance, clearance),
    )


def check_clearance(
    robot: Robot,
    positions: ArrayLike,
    time: ArrayLike | None = None,
    clearance: float = 0.0,
    model: CollisionModel | None = None,
) -> None:
    """Raise :class:`psp3.errors.CollisionFound` if links come too close along a motion.

    The error is for the first time at which two links are as close as the clearance.

    Parameters
    ----------
    robot, positions, time, clearance, model
        See :func:`check`.

    Raises
    ------
    CollisionFound
        The error holds the time, the two links and their distance.
    InvalidArray, InvalidValue, ClosureFailed, JointLimitExceeded
        See :func:`check`.
    InvalidRobotFile, OverlappingShapes
        See :func:`check`.
    """
    report = check(robot, positions, time, clearance, model)
    if report.first is not None:
        nearest = report.nearest
        raise CollisionFound(
            report.first.time,
            report.first.nearest.links,
            report.first.nearest.distance,
            report.clearance,
            nearest.time,
            nearest.nearest.distance,
        )


def _first_contact(
    model: CollisionModel,
    path: Array,
    times: Array,
    configurations: Array,
    distance: Array,
    clearance: float,
) -> Contact | None:
    """Return the first contact at which two links are as close as the clearance."""
    near = np.flatnonzero(distance <= clearance)
    if not near.size:
        return None
    after = int(near[0])
    if after == 0:
        return Contact(float(times[0]), path[0], model.nearest_at(configurations[0]))
    before, apart, touching = after - 1, 0.0, 1.0
    positions, q = path[after], configurations[after]
    for _ in range(BISECTIONS):
        share = 0.5 * (apart + touching)
        middle = path[before] + share * (path[after] - path[before])
        closed = model.robot.configurations_along(middle[np.newaxis], configurations[before])[0]
        if model.nearest_at(closed).distance <= clearance:
            touching, positions, q = share, middle, closed
        else:
            apart = share
    return Contact(
        float(times[before] + touching * (times[after] - times[before])),
        positions,
        model.nearest_at(q),
    )
