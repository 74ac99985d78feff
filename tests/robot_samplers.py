"""Random reachable poses of the shipped robots.

Found without closing a loop, by closed-form inverse kinematics of the end effector.

A pose counts as reachable if its actuated joints and elbows are within the limits of the URDF, its
legs bend as at home, and it is in the assembly mode of home: the determinants that vanish where the
actuators lose hold of the end effector have the signs that they have at home, and at least 5 % of
their sizes, so that a tolerance of 1e-10 means something.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from tests.closed_form_kinematics import (
    Delta,
    FiveBar,
    GoughStewart,
    PlanarThreeRRR,
    Tricept,
    around,
    rotation_xyz,
)
from tests.helpers import Array, random_heights

HOLD = 0.05
"""Least share of home's determinants."""


class Reachable(NamedTuple):
    """Poses (count, k) of the end effector and actuated positions (count, n).

    Poses are in the coordinates of :data:`WORKSPACES`.
    """

    poses: Array
    positions: Array


class Workspace(NamedTuple):
    """A box of end-effector poses, the limits of the actuated joints.

    And what tells which poses in the box are reachable.
    """

    lower: Array
    upper: Array
    limits: tuple[float, float]
    home: Array
    inverse: Callable[[Array], Array]
    determinants: Callable[[Array], Array]
    bends: Callable[[Array], Array] = lambda poses: np.zeros(len(poses))
    largest_bend: float = np.inf


def _unit(vectors: Array) -> Array:
    return np.asarray(vectors / np.linalg.norm(vectors, axis=-1, keepdims=True))


def _bends(first: float, second: float, distance: Array) -> Array:
    """Angles by which two links of given lengths are bent when their ends have a distance."""
    with np.errstate(invalid="ignore"):
        return np.pi - np.arccos((first**2 + second**2 - distance**2) / (2.0 * first * second))


def _five_bar() -> Workspace:
    robot = FiveBar()

    def determinants(tip: Array) -> Array:
        return np.asarray(np.linalg.det(_unit(tip[:, None] - robot.elbows(robot.inverse(tip)))))

    def bends(tip: Array) -> Array:
        return _bends(
            robot.crank, robot.rod, np.linalg.norm(tip[:, None] - robot.shafts, axis=-1)
        ).max(axis=1)

    home = np.array([0.0, -0.1])
    home[1] = robot.forward([-0.6, 0.6])[1]
    return Workspace(
        np.array([-0.4, -0.5]),
        np.array([0.4, 0.1]),
        (-1.5, 1.5),
        home,
        robot.inverse,
        determinants,
        bends,
        largest_bend=2.6,
    )


def _planar_3rrr() -> Workspace:
    robot = PlanarThreeRRR()

    def determinants(poses: Array) -> Array:
        matrix, _ = robot.rates(poses)
        return np.asarray(
            np.linalg.det(matrix / [robot.rod, robot.rod, robot.rod * robot.platform])
        )

    def bends(poses: Array) -> Array:
        return _bends(
            robot.crank,
            robot.rod,
            np.linalg.norm(robot.placed_corners(poses) - robot.shafts, axis=-1),
        ).max(axis=1)

    box = np.array([0.25, 0.25, 1.6])
    return Workspace(
        -box, box, (-1.0, 2.2), np.zeros(3), robot.inverse, determinants, bends, largest_bend=2.7
    )


def _delta() -> Workspace:
    robot = Delta()

    def determinants(tip: Array) -> Array:
        # The rods hold the platform's center; each pair, a parallelogram, also keeps it from
        # turning about the normal of its plane.
        rods = _unit(tip[:, None] - robot.elbows(robot.inverse(tip)))
        normals = np.cross(around(robot.azimuths + np.pi / 2.0, 1.0), rods)
        return np.stack([np.linalg.det(rods), np.linalg.det(normals)], axis=-1)

    home = robot.forward(np.zeros(3))
    return Workspace(
        np.array([-0.4, -0.4, -0.6]),
        np.array([0.4, 0.4, 0.0]),
        (-1.0, 1.5),
        home,
        robot.inverse,
        determinants,
    )


def _gough_stewart() -> Workspace:
    robot = GoughStewart()

    def pose(poses: Array) -> tuple[Array, Array]:
        return poses[:, :3], rotation_xyz(poses[:, 3:])

    def inverse(poses: Array) -> Array:
        return robot.lengths(*pose(poses))

    def determinants(poses: Array) -> Array:
        return np.asarray(np.linalg.det(robot.rates(*pose(poses))))

    box = np.array([0.35, 0.35, 0.25, 0.6, 0.6, 0.6])
    home = np.append(robot.home, np.zeros(3))
    return Workspace(home - box, home + box, (0.6, 0.95), home, inverse, determinants)


def _tricept() -> Workspace:
    robot = Tricept()

    def determinants(tip: Array) -> Array:
        # Of the inverse Jacobian, so that it vanishes where the legs lose hold of the platform.
        return np.asarray(1.0 / np.linalg.det(robot.jacobian(tip)))

    lower, upper = np.array([-1.2, -1.2, -1.75]), np.array([1.2, 1.2, -0.7])

    def inverse(tip: Array) -> Array:
        # The central leg has limits, too, though no motor.
        angles, length = robot.central_leg(tip)
        within = (length >= 0.8) & (length <= 1.45) & (np.abs(angles) <= 0.7).all(axis=1)
        return np.where(within[:, None], robot.inverse(tip), np.nan)

    return Workspace(lower, upper, (0.9, 1.55), robot.home, inverse, determinants)


WORKSPACES = {
    "five_bar": _five_bar(),  # x, z
    "planar_3rrr": _planar_3rrr(),  # x, y, angle
    "delta": _delta(),  # x, y, z
    "gough_stewart": _gough_stewart(),  # x, y, z, three angles about x, y and z
    "tricept": _tricept(),  # x, y, z of the tool's point
}


def reachable(name: str, count: int, rng: np.random.Generator) -> Reachable:
    """Return random reachable poses of a robot, evenly distributed over its workspace."""
    space = WORKSPACES[name]
    at_home = space.determinants(space.home[None])
    poses = np.zeros((0, space.home.size))
    while len(poses) < count:
        drawn = rng.uniform(space.lower, space.upper, size=(4 * count + 100, space.home.size))
        positions = space.inverse(drawn)
        drawn = drawn[((positions >= space.limits[0]) & (positions <= space.limits[1])).all(axis=1)]
        drawn = drawn[
            (space.determinants(drawn) / at_home >= HOLD).reshape(len(drawn), -1).all(axis=1)
        ]
        poses = np.concatenate([poses, drawn[space.bends(drawn) <= space.largest_bend]])
    return Reachable(poses[:count], space.inverse(poses[:count]))


def random_poses(name: str, count: int, rng: np.random.Generator) -> Array:
    """Return actuated positions (count, n) of random reachable poses of a shipped robot."""
    return random_heights(rng, count) if name == "psp3" else reachable(name, count, rng).positions
