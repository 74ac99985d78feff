"""Kinematics of the robots of urdf/ in closed form, from the literature.

Independent of Pinocchio, of the URDF and of the package.

Each class holds the lengths of its machine a second time, as urdf/README.md states them. Positions
are those of the actuated joints, in the order of the loop file; all functions take and return
stacks. Branches of square roots are those of the pose ``home``.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from tests.helpers import Array


def around(angles: ArrayLike, radius: float) -> Array:
    """Points (..., 3) in the plane z = 0 at azimuths (...,) and a distance from the axis."""
    angles = np.asarray(angles, dtype=float)
    return radius * np.stack([np.cos(angles), np.sin(angles), np.zeros_like(angles)], axis=-1)


def rotation_xyz(angles: ArrayLike) -> Array:
    """Rotations Rx(a) Ry(b) Rz(c), written out, (..., 3) to (..., 3, 3)."""
    a, b, c = np.moveaxis(np.asarray(angles, dtype=float), -1, 0)
    (sa, sb, sc), (ca, cb, cc) = np.sin([a, b, c]), np.cos([a, b, c])
    rows = [
        [cb * cc, -cb * sc, sb],
        [ca * sc + sa * sb * cc, ca * cc - sa * sb * sc, -sa * cb],
        [sa * sc - ca * sb * cc, sa * cc + ca * sb * sc, ca * cb],
    ]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))


def lower_intersection_of_circles(first: Array, second: Array, radius: float) -> Array:
    """Return the point (..., 2) at the same distance from two others.

    It is to the right when going from the first to the second.
    """
    middle, across = 0.5 * (first + second), second - first
    half = 0.5 * np.linalg.norm(across, axis=-1, keepdims=True)
    rightward = np.stack([across[..., 1], -across[..., 0]], axis=-1) / (2.0 * half)
    return middle + np.sqrt(radius**2 - half**2) * rightward


def lower_intersection_of_spheres(centers: Array, radius: float) -> Array:
    """Return the point (..., 3) equally far from three others (..., 3, 3), below their plane.

    It is above or below the circumcenter of the three, which is found in the plane by its
    barycentric coordinates.
    """
    a, b, c = np.moveaxis(centers, -2, 0)
    sides = np.stack(
        [((b - c) ** 2).sum(-1), ((c - a) ** 2).sum(-1), ((a - b) ** 2).sum(-1)], axis=-1
    )
    weights = sides * (sides.sum(-1, keepdims=True) - 2.0 * sides)
    center = np.einsum("...k,...ki->...i", weights / weights.sum(-1, keepdims=True), centers)
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    normal *= -np.sign(normal[..., 2:])
    return center + np.sqrt(radius**2 - ((a - center) ** 2).sum(-1))[..., None] * normal


class FiveBar:
    """Planar five-bar linkage.

    Forward kinematics by intersecting two circles, inverse by the law of cosines in each leg.

    Everybody's textbook example; e.g. X.-J. Liu, J. Wang and G. Pritschow, "Kinematics, singularity
    and workspace of planar 5R symmetrical parallel mechanisms", Mechanism and Machine Theory 41
    (2006) 145-169.
    """

    shafts = np.array([[0.1, 0.0], [-0.1, 0.0]])  # (x, z)
    crank, rod = 0.2, 0.28
    outward = np.array([-1.0, 1.0])  # sign of a crank's angle that swings it away from the other

    def elbows(self, positions: ArrayLike) -> Array:
        """Elbows (..., 2, 2) in (x, z); a positive angle turns a hanging crank toward -x."""
        angles = np.asarray(positions, dtype=float)
        return self.shafts - self.crank * np.stack([np.sin(angles), np.cos(angles)], axis=-1)

    def forward(self, positions: ArrayLike) -> Array:
        """Point (..., 2) in (x, z)."""
        elbows = self.elbows(positions)
        return lower_intersection_of_circles(elbows[..., 1, :], elbows[..., 0, :], self.rod)

    def inverse(self, tip: ArrayLike) -> Array:
        """Angles (..., 2) of the cranks, elbows outward; NaN out of reach."""
        to_tip = np.asarray(tip, dtype=float)[..., None, :] - self.shafts
        distance = np.linalg.norm(to_tip, axis=-1)
        with np.errstate(invalid="ignore"):
            swing = np.arccos(
                (distance**2 + self.crank**2 - self.rod**2) / (2.0 * distance * self.crank)
            )
        return np.arctan2(-to_tip[..., 0], -to_tip[..., 1]) + self.outward * swing

    def jacobian(self, positions: ArrayLike) -> Array:
        """Velocity of the point per unit of crank speed, (..., 2, 2).

        The rods keep their lengths.
        """
        angles, elbows = np.asarray(positions, dtype=float), self.elbows(positions)
        rods = self.forward(positions)[..., None, :] - elbows
        sweep = -self.crank * np.stack([np.cos(angles), -np.sin(angles)], axis=-1)
        return np.linalg.solve(
            rods, np.einsum("...ki,...ki->...k", rods, sweep)[..., None] * np.eye(2)
        )


class PlanarThreeRRR:
    """Planar 3-RRR robot: inverse kinematics leg by leg.

    C. M. Gosselin and J. Angeles, "The optimum kinematic design of a planar three-degree-of-freedom
    parallel manipulator", Journal of Mechanisms, Transmissions, and Automation in Design 110 (1988)
    35-41.
    """

    azimuths = np.pi / 2.0 + 2.0 * np.pi / 3.0 * np.arange(3)
    base, platform, crank, rod = 0.3, 0.08, 0.16, 0.18
    shafts = around(azimuths, base)[:, :2]
    corners = around(azimuths, platform)[:, :2]

    def placed_corners(self, poses: ArrayLike) -> Array:
        """Corners (..., 3, 2) of the platform at poses (x, y, angle)."""
        x, y, angle = np.moveaxis(np.asarray(poses, dtype=float), -1, 0)
        return (
            np.stack([x, y], axis=-1)[..., None, :]
            + around(self.azimuths + angle[..., None], self.platform)[..., :2]
        )

    def inverse(self, poses: ArrayLike) -> Array:
        """Crank angles (..., 3), counted from the direction to the middle; NaN out of reach.

        With the vector (x, y) from shaft to corner, the constant length of the rod gives a
        quadratic in tan(angle / 2), or directly x cos(angle) + y sin(angle) = (x² + y² + crank² -
        rod²) / (2 crank).
        """
        x, y = np.moveaxis(self.placed_corners(poses) - self.shafts, -1, 0)
        right = (x**2 + y**2 + self.crank**2 - self.rod**2) / (2.0 * self.crank)
        with np.errstate(invalid="ignore"):
            angles = np.arctan2(y, x) + np.arccos(right / np.hypot(x, y))
        return np.mod(angles - self.azimuths - np.pi + np.pi, 2.0 * np.pi) - np.pi

    def elbows(self, positions: ArrayLike) -> Array:
        """Elbows (..., 3, 2)."""
        return (
            self.shafts
            + around(np.asarray(positions, dtype=float) + self.azimuths + np.pi, self.crank)[
                ..., :2
            ]
        )

    def rates(self, poses: ArrayLike) -> tuple[Array, Array]:
        """Matrices A (..., 3, 3) and B (..., 3) of the rods' constant lengths.

        A (x, y, angle)' = B * (crank speeds).
        """
        corners, positions = self.placed_corners(poses), self.inverse(poses)
        rods = corners - self.elbows(positions)
        arms = corners - np.asarray(poses, dtype=float)[..., None, :2]
        sweep = around(positions + self.azimuths + 1.5 * np.pi, self.crank)[..., :2]
        moment = arms[..., 0] * rods[..., 1] - arms[..., 1] * rods[..., 0]
        return np.concatenate([rods, moment[..., None]], axis=-1), (rods * sweep).sum(-1)

    def jacobian(self, poses: ArrayLike) -> Array:
        """Velocity (x, y, angle)' per unit of crank speed, (..., 3, 3)."""
        forward, inverse = self.rates(poses)
        return np.linalg.solve(forward, inverse[..., None] * np.eye(3))


class Delta:
    """Delta robot: forward kinematics by intersecting three spheres, inverse arm by arm.

    R. Clavel, "Delta, a fast robot with parallel geometry", 18th International Symposium on
    Industrial Robots (1988) 91-100; F. Pierrot, C. Reynaud and A. Fournier, "DELTA: a simple and
    efficient parallel robot", Robotica 8 (1990) 105-109.
    """

    azimuths = 2.0 * np.pi / 3.0 * np.arange(3)
    base, arm, rod, platform = 0.12, 0.2, 0.4, 0.05

    def inverse(self, tip: ArrayLike) -> Array:
        """Arm angles (..., 3), downward, elbows outward; NaN out of reach."""
        tip = np.asarray(tip, dtype=float)
        outward = tip @ around(self.azimuths, 1.0).T + self.platform - self.base
        sideways = tip @ around(self.azimuths + np.pi / 2.0, 1.0).T
        down = -tip[..., 2:]
        right = (outward**2 + sideways**2 + down**2 + self.arm**2 - self.rod**2) / (2.0 * self.arm)
        with np.errstate(invalid="ignore"):
            return np.arctan2(down, outward) - np.arccos(right / np.hypot(outward, down))

    def elbows(self, positions: ArrayLike) -> Array:
        """Elbows (..., 3, 3), moved inward by the platform's radius.

        So all rods end in its center.
        """
        angles = np.asarray(positions, dtype=float)
        elbows = (self.base - self.platform + self.arm * np.cos(angles))[..., None] * around(
            self.azimuths, 1.0
        )
        elbows[..., 2] = -self.arm * np.sin(angles)
        return elbows

    def forward(self, positions: ArrayLike) -> Array:
        """Center (..., 3) of the platform."""
        return lower_intersection_of_spheres(self.elbows(positions), self.rod)

    def jacobian(self, positions: ArrayLike) -> Array:
        """Velocity of the platform per unit of arm speed, (..., 3, 3)."""
        angles = np.asarray(positions, dtype=float)
        rods = self.forward(positions)[..., None, :] - self.elbows(positions)
        sweep = -self.arm * np.sin(angles)[..., None] * around(self.azimuths, 1.0)
        sweep[..., 2] = -self.arm * np.cos(angles)
        return np.linalg.solve(rods, (rods * sweep).sum(-1)[..., None] * np.eye(3))


class ExtensibleLegs:
    """Legs from fixed feet to the corners of a body, as in both robots below.

    Lengths and their rates.
    """

    feet: Array
    corners: Array

    def legs(self, position: Array, rotation: Array) -> tuple[Array, Array]:
        """Vectors to corners, (..., k, 3), from feet and from the body's origin."""
        arms = np.einsum("...ij,kj->...ki", rotation, self.corners)
        return position[..., None, :] + arms - self.feet, arms

    def lengths(self, position: Array, rotation: Array) -> Array:
        """Lengths (..., k), the distances |p + R b - a|."""
        return np.linalg.norm(self.legs(position, rotation)[0], axis=-1)

    def rates(self, position: Array, rotation: Array) -> Array:
        """Leg rates per twist [v; ω] of the body, (..., k, 6).

        Rows are [n, (R b) × n] with n along the leg.
        """
        legs, arms = self.legs(position, rotation)
        directions = legs / np.linalg.norm(legs, axis=-1, keepdims=True)
        return np.concatenate([directions, np.cross(arms, directions)], axis=-1)


class GoughStewart(ExtensibleLegs):
    """Gough-Stewart platform: a pose gives the leg lengths.

    V. E. Gough, contribution to a discussion, Proceedings of the Automobile Division, Institution
    of Mechanical Engineers (1956) 392-394; D. Stewart, "A platform with six degrees of freedom",
    Proceedings of the Institution of Mechanical Engineers 180 (1965) 371-386.
    """

    feet = around(np.radians([10.0, 110.0, 130.0, 230.0, 250.0, 350.0]), 0.5)
    corners = around(np.radians([50.0, 70.0, 170.0, 190.0, 290.0, 310.0]), 0.3)
    home = np.array([0.0, 0.0, 0.7])


class Tricept(ExtensibleLegs):
    """Tricept: the tool's point gives the central leg, and this the three others.

    B. Siciliano, "The Tricept robot: inverse kinematics, manipulability analysis and closed-loop
    direct kinematics algorithm", Robotica 17 (1999) 437-445.
    """

    feet = around(2.0 * np.pi / 3.0 * np.arange(3), 0.4)
    corners = around(2.0 * np.pi / 3.0 * np.arange(3), 0.16)
    tool = 0.25
    home = np.array([0.0, 0.0, -1.4])

    def central_leg(self, tip: ArrayLike) -> tuple[Array, Array]:
        """Angles (..., 2) and length (...,) of the central leg.

        They put the tool's point at ``tip``; the angles are those of the central universal joint.

        The tool is on the central leg's line, so with d the distance to the tip: tip / d = -(sin b,
        -sin a cos b, cos a cos b).
        """
        tip = np.asarray(tip, dtype=float)
        distance = np.linalg.norm(tip, axis=-1)
        angles = np.stack(
            [np.arctan2(tip[..., 1], -tip[..., 2]), np.arcsin(-tip[..., 0] / distance)], axis=-1
        )
        return angles, distance - self.tool

    def platform(self, tip: ArrayLike) -> tuple[Array, Array]:
        """Center (..., 3) and rotation (..., 3, 3) of the platform."""
        angles, length = self.central_leg(tip)
        rotation = rotation_xyz(np.concatenate([angles, np.zeros((*length.shape, 1))], axis=-1))
        return -length[..., None] * rotation[..., 2], rotation

    def inverse(self, tip: ArrayLike) -> Array:
        """Leg lengths (..., 3)."""
        return self.lengths(*self.platform(tip))

    def jacobian(self, tip: ArrayLike) -> Array:
        """Velocity of the tool's point per unit of leg rate, (..., 3, 3)."""
        (position, rotation), (angles, length) = self.platform(tip), self.central_leg(tip)
        # Twist of the platform about its center per unit of the central leg's rates: the axes are
        # x, then y turned by the first angle.
        first = np.broadcast_to([1.0, 0.0, 0.0], position.shape)
        second = np.stack(
            [np.zeros_like(length), np.cos(angles[..., 0]), np.sin(angles[..., 0])], axis=-1
        )
        along = -rotation[..., 2]
        zero = np.zeros_like(along)

        def twists(reach: Array) -> Array:
            columns = [
                (np.cross(axis, reach[..., None] * along), axis) for axis in (first, second)
            ] + [(along, zero)]
            return np.stack([np.concatenate(column, axis=-1) for column in columns], axis=-1)

        legs = self.rates(position, rotation) @ twists(length)
        return np.linalg.solve(
            np.swapaxes(legs, -1, -2), np.swapaxes(twists(length + self.tool)[..., :3, :], -1, -2)
        ).swapaxes(-1, -2)
