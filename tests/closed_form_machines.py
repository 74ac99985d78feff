"""Closed forms of the robots that people build, from the literature.

Independent of Pinocchio, of the files and of the package: lengths stand here a second time, as
urdf/README.md states them. All functions take and return stacks unless they say otherwise.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from tests.closed_form_kinematics import PlanarThreeRRR, around
from tests.helpers import Array


class PlanarFourRRR(PlanarThreeRRR):
    """Planar 4-RRR robot: as the 3-RRR, with a leg more, so that rods can work against each other.

    J. Wu, J. Wang and Z. You, "A comparison study on the dynamics of planar 3-DOF 4-RRR, 3-RRR and
    2-RRR parallel manipulators", Robotics and Computer-Integrated Manufacturing 27 (2011) 150-156.
    """

    azimuths = np.pi / 4.0 + np.pi / 2.0 * np.arange(4)
    shafts = around(azimuths, 0.3)[:, :2]
    corners = around(azimuths, 0.08)[:, :2]

    def preload(self, poses: ArrayLike) -> Array:
        """Crank torques (..., 4) that move nothing, of norm 1.

        Forces f along the four rods balance on the platform where f A = 0; a crank feels its rod
        by the rate of the rod's length, B.
        """
        forward, inverse = self.rates(poses)
        forces = np.linalg.svd(np.swapaxes(forward, -1, -2))[2][..., -1, :]
        torques = forces * inverse
        return np.asarray(torques / np.linalg.norm(torques, axis=-1, keepdims=True))


class JansenLeg:
    """Jansen's leg by triangles, in complex numbers.

    The thirteen lengths are in T. Jansen, "The Great Pretender", 010 Publishers, Rotterdam (2007).
    """

    a, b, c, d, e, f, g = 0.38, 0.415, 0.393, 0.401, 0.558, 0.394, 0.367
    h, i, j, k, lift, m = 0.657, 0.49, 0.5, 0.619, 0.078, 0.15

    @staticmethod
    def apex(start: Array, first: float, end: Array, last: float, side: int) -> Array:
        """Return the third corner of a triangle by the law of cosines; left of the way is 1."""
        way = end - start
        length = np.abs(way)
        angle = np.arccos((length**2 + first**2 - last**2) / (2.0 * length * first))
        return np.asarray(start + first * way / length * np.exp(1j * side * angle))

    def foot(self, crank: ArrayLike) -> Array:
        """Foot (..., 2), x forward and z up, seen from the crank's shaft."""
        angle = np.asarray(crank, dtype=float)
        hip = np.full(angle.shape, -self.a - 1j * self.lift)
        pin = self.m * np.exp(1j * angle)
        top = self.apex(hip, self.b, pin, self.j, 1)
        back = self.apex(hip, self.d, top, self.e, 1)
        knee = self.apex(hip, self.c, pin, self.k, -1)
        heel = self.apex(back, self.f, knee, self.g, -1)
        foot = self.apex(heel, self.h, knee, self.i, -1)
        return np.stack([foot.real, foot.imag], axis=-1)


class AgileEye:
    """Spherical 3-RRR wrist whose neighboring axes are at right angles.

    C. M. Gosselin and J.-F. Hamel, "The agile eye: a high-performance three-degree-of-freedom
    camera-orienting device", IEEE ICRA (1994) 781-786; I. A. Bonev, D. Chablat and P. Wenger,
    "Working and assembly modes of the Agile Eye", IEEE ICRA (2006) 2317-2322.
    """

    azimuths = 2.0 * np.pi / 3.0 * np.arange(3)
    axes = np.column_stack(
        [
            np.sqrt(2.0 / 3.0) * np.cos(azimuths),
            np.sqrt(2.0 / 3.0) * np.sin(azimuths),
            np.full(3, np.sqrt(1.0 / 3.0)),
        ]
    )
    """Of the motors, one a row; the platform's are the same at home, each leg's the next one."""

    def angles(self, rotation: Array) -> Array:
        """Angles of the motors (..., 3) at a rotation (..., 3, 3) of the platform.

        The axis between, which turns with the motor, is at right angles to the platform's: its
        tangent is a quotient of two direction cosines.
        """
        along = self.axes @ rotation @ self.axes.T
        found = []
        for leg in range(3):
            pin, side = (leg + 1) % 3, (leg + 2) % 3
            found.append(np.arctan2(along[..., side, pin], along[..., pin, pin]))
        return np.stack(found, axis=-1)

    def rates(self, rotation: Array) -> Array:
        """Speeds of the motors per angular velocity of the platform, (..., 3, 3)."""
        rows = []
        for leg, angle in enumerate(np.moveaxis(self.angles(rotation), -1, 0)):
            axis, pin, side = (self.axes[(leg + k) % 3] for k in range(3))
            between = np.cos(angle)[..., None] * side - np.sin(angle)[..., None] * pin
            platform = rotation @ pin
            # d/dt of between . platform = 0
            sweep = (np.cross(axis, between) * platform).sum(-1, keepdims=True)
            rows.append(np.cross(between, platform) / sweep)
        return np.stack(rows, axis=-2)


class Hexa:
    """Stewart platform with cranks: inverse kinematics crank by crank.

    F. Pierrot, P. Dauchez and A. Fournier, "HEXA: a fast six-DOF fully-parallel robot", 5th
    International Conference on Advanced Robotics (1991) 1158-1163.
    """

    crank, rod = 0.06, 0.2
    pairs = np.repeat(2.0 * np.pi / 3.0 * np.arange(3), 2)
    sides = np.tile([-1.0, 1.0], 3)
    feet = around(pairs + sides * np.radians(18.0), 0.14)
    corners = around(pairs + sides * (np.pi / 3.0 - np.radians(12.0)), 0.10)
    along = sides[:, None] * around(pairs + 0.5 * np.pi, 1.0)

    @property
    def home(self) -> Array:
        """Center of the platform where the cranks are level."""
        level = np.linalg.norm(self.corners[0] - self.feet[0] - self.crank * self.along[0])
        return np.array([0.0, 0.0, np.sqrt(self.rod**2 - level**2)])

    def angles(self, position: Array, rotation: Array) -> Array:
        """Angles (..., 6), upward, of the solution with level cranks at home.

        e cos + f sin = g, of the rod's length, is one sine of a sum.
        """
        legs = position[..., None, :] + self.corners @ np.swapaxes(rotation, -1, -2) - self.feet
        e, f = (legs * self.along).sum(-1), legs[..., 2]
        g = ((legs**2).sum(-1) + self.crank**2 - self.rod**2) / (2.0 * self.crank)
        return np.asarray(np.arcsin(g / np.hypot(e, f)) - np.arctan2(e, f))


class Finger:
    """A finger of the gripper as a five-bar in its plane, in complex numbers (out, up).

    Lengths of the Robotiq 2F-85, whose pads open by 85 mm.
    """

    driver_pin, spring_pin = 0.0306 + 0.0549j, 0.0132 + 0.0609j
    driver_arm, spring_arm = 0.0315 - 0.0041j, 0.0370 + 0.0440j
    tip_pin = 0.0180 - 0.0065j
    pad = 0.0427 + (0.0609 + 0.0440 - 0.0065 + 0.032) * 1j

    def angle(self, driver: ArrayLike, spring: ArrayLike) -> Array:
        """Return the angle of the fingertip, 0 where the finger is open."""
        knuckle = self.spring_pin + self.spring_arm * np.exp(1j * np.asarray(spring))
        knee = self.driver_pin + self.driver_arm * np.exp(1j * np.asarray(driver))
        length = abs(
            self.spring_pin + self.spring_arm + self.tip_pin - self.driver_pin - self.driver_arm
        )
        way = knee - knuckle
        arm, distance = abs(self.tip_pin), np.abs(way)
        between = np.arccos((distance**2 + arm**2 - length**2) / (2.0 * distance * arm))
        return np.asarray(np.angle(way) + between - np.angle(self.tip_pin))

    def place(self, driver: ArrayLike, spring: ArrayLike) -> Array:
        """Return the middle of the pad (..., 2): its distance from the middle, and its height."""
        start = self.spring_pin + self.spring_arm
        knuckle = self.spring_pin + self.spring_arm * np.exp(1j * np.asarray(spring))
        point = knuckle + (self.pad - start) * np.exp(1j * self.angle(driver, spring))
        return np.stack([point.real, point.imag], axis=-1)


class CassieLeg:
    """A leg of the biped in its plane, in complex numbers (down, forward).

    Lengths of Agility Robotics' Cassie as published in Oregon State University's cassie-mujoco-sim
    and in MuJoCo Menagerie.
    """

    thigh, knee, shin = 0.12 + 0j, 0.0607 + 0.0474j, 0.4348 + 0.02j
    heel, spring = -0.0127 - 0.0306j, -0.1054 + 0.0568j
    beside = 0.045 - 0.009
    crank, ankle = 0.058 - 0.034j, 0.408 - 0.04j
    crank_arm, horn = 0.055, 0.0551 + 0.006j
    achilles, plantar = 0.5012, 0.3501

    def achilles_length(
        self, knee: ArrayLike, shin: ArrayLike, tarsus: ArrayLike, heel: ArrayLike
    ) -> Array:
        """Distance of the Achilles rod's ends at angles of the joints, springs at rest at 0."""
        upper = np.exp(1j * np.asarray(knee))
        lower = upper * np.exp(1j * np.asarray(shin))
        foot = lower * np.exp(1j * np.asarray(tarsus))
        end = self.thigh + self.knee * upper + self.shin * lower
        end = end + (self.heel + self.spring * np.exp(1j * np.asarray(heel))) * foot
        return np.asarray(np.hypot(np.abs(end), self.beside))

    def plantar_length(self, crank: ArrayLike, foot: ArrayLike) -> Array:
        """Distance of the plantar rod's ends; the crank's angle is that of its arm."""
        end = self.crank + self.crank_arm * np.exp(1j * np.asarray(crank))
        return np.asarray(np.abs(self.ankle + self.horn * np.exp(1j * np.asarray(foot)) - end))
