"""Biped on a floating base, with rod-driven legs and leaf springs after Cassie's."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .mjcf import Assembly, Joint, More
from .solids import Array, Solid, Z, ball, box, rod

PELVIS_HEIGHT = 1.0
"""Height of the floating base in the home pose [m]."""

HIP_ROLL, HIP_YAW, HIP_PITCH = (0.021, 0.135, 0.0), (-0.049, 0.135, 0.0), (-0.049, 0.135, -0.09)
"""Positions of the left leg's motors in the pelvis [m]."""

THIGH, KNEE, SHIN = (0.12, 0.0), (0.0607, 0.0474), (0.4348, 0.02)
"""From hip to knee, from knee to the shin's spring, and from there to the tarsus: components down
and forward at angle zero of each body [m].
"""

HEEL, CRANK_PIN, ANKLE = (-0.0127, -0.0306), (0.058, -0.034), (0.408, -0.04)
"""Positions on the tarsus: pins of the heel spring, of the toe's crank, and of the foot."""

HEEL_SPRING, TOE_CRANK, TOE_HORN = (-0.1054, 0.0568), (0.055, 0.0), (0.0551, 0.006)
"""From the heel's pin to the Achilles rod, from the crank's pin to the plantar rod, and from the
ankle to the other end of that rod, in axes of the tarsus with all angles zero.
"""

ACHILLES, PLANTAR = 0.5012, 0.3501
"""Lengths of the rods [m]."""

ACHILLES_HIP, ACHILLES_HEEL = 0.045, 0.009
"""Distances of the Achilles rod's ends from the plane of the leg, toward the middle [m]."""

SHIN_STIFFNESS, HEEL_STIFFNESS = 1500.0, 1250.0
"""Stiffness of the leaf springs [N m/rad]."""

PITCH, KNEE_ANGLE, FOOT_ANGLE = 0.5, -1.2, -1.6
"""Angles of hip, knee and foot in the home pose [rad]; the Achilles rod determines the tarsus."""

MOTORS = {
    "hip_roll": ((-0.26, 0.39), 112.5, 0.0381),
    "hip_yaw": ((-0.39, 0.39), 112.5, 0.0381),
    "hip_pitch": ((-1.37, 0.89), 195.2, 0.0934),
    "knee": ((-1.66, 0.55), 195.2, 0.0934),
    "toe": ((-0.9, 0.9), 45.0, 0.0123),
}
"""Range from the home pose [rad], largest torque [N m] and inertia of the rotor at the joint [kg
m²]."""


class Pins(NamedTuple):
    """Points of a leg in its plane, down and forward from the hip."""

    hip: Array
    knee: Array
    shin: Array
    tarsus: Array
    heel: Array
    rod: Array
    crank: Array
    plantar: Array
    ankle: Array
    horn: Array
    heel_of_foot: Array
    toe: Array


def turned(angle: float, vector: tuple[float, float]) -> Array:
    """Return a vector of the plane, rotated from down to forward."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([c * vector[0] - s * vector[1], s * vector[0] + c * vector[1]])


def tarsus_angle() -> float:
    """Return the tarsus angle for the Achilles rod's length, with springs at rest."""
    across = ACHILLES_HIP - ACHILLES_HEEL
    level = np.sqrt(ACHILLES**2 - across**2)
    pivot = np.add(THIGH, turned(KNEE_ANGLE, tuple(np.add(KNEE, SHIN))))
    reach = np.add(HEEL, HEEL_SPRING)
    # |pivot + R(angle) reach| = level
    distance, arm = np.linalg.norm(pivot), np.linalg.norm(reach)
    between = np.arccos((level**2 - distance**2 - arm**2) / (2.0 * distance * arm))
    direction = np.arctan2(pivot[1], pivot[0]) - between
    found = direction - np.arctan2(reach[1], reach[0]) - KNEE_ANGLE
    return float((found + np.pi) % (2.0 * np.pi) - np.pi)


def pins() -> Pins:
    """Return the positions of all pins in the home pose."""
    knee_at, tarsus_at = PITCH + KNEE_ANGLE, PITCH + KNEE_ANGLE + tarsus_angle()
    hip = np.zeros(2)
    knee = hip + turned(PITCH, THIGH)
    shin = knee + turned(knee_at, KNEE)
    tarsus = shin + turned(knee_at, SHIN)
    heel = tarsus + turned(tarsus_at, HEEL)
    end = heel + turned(tarsus_at, HEEL_SPRING)
    crank = tarsus + turned(tarsus_at, CRANK_PIN)
    ankle = tarsus + turned(tarsus_at, ANKLE)
    foot_at = tarsus_at + FOOT_ANGLE
    horn = ankle + turned(foot_at, TOE_HORN)
    # The plantar rod's length is the distance of the crank's end from the horn.
    across = horn - crank
    distance, arm = np.linalg.norm(across), np.hypot(*TOE_CRANK)
    between = np.arccos((distance**2 + arm**2 - PLANTAR**2) / (2.0 * distance * arm))
    plantar = crank + turned(np.arctan2(across[1], across[0]) - between, (float(arm), 0.0))
    sole = [ankle + turned(foot_at, end) for end in ((-0.053, 0.093), (0.070, -0.010))]
    return Pins(hip, knee, shin, tarsus, heel, end, crank, plantar, ankle, horn, sole[0], sole[1])


def biped() -> Assembly:
    """Return a pelvis with two legs; all motors except those of the toes are at hip and knee."""
    robot = Assembly("biped", "Biped on a floating base with rod-driven legs and springs.")
    up = PELVIS_HEIGHT * Z
    near, far = np.array([-0.02, 0.10, 0.0]), np.array([-0.02, 0.17, 0.0])
    trunk = [
        box((0.16, 0.17, 0.13), up + np.array([0.03, 0.0, 0.05]), "anodized"),
        box((0.05, 0.12, 0.09), up + np.array([0.10, 0.0, 0.16]), "rubber"),
        *(rod(up + near * [1, s, 1], up + far * [1, s, 1], 0.03, "anodized") for s in (-1.0, 1.0)),
    ]
    robot.body("pelvis", "world", up, Joint("root", "free"), trunk)
    robot.site("tip", "pelvis", up)
    for name, side in (("left", 1.0), ("right", -1.0)):
        _leg(robot, name, side)
    return robot


def _leg(robot: Assembly, name: str, side: float) -> None:
    at_pin = pins()
    hip = PELVIS_HEIGHT * Z + np.array([HIP_PITCH[0], side * HIP_PITCH[1], HIP_PITCH[2]])

    def place(point: Array, inward: float = 0.0) -> Array:
        """Return the world position of a point in the leg's plane, or beside it."""
        return np.asarray(hip + np.array([point[1], -side * inward, -point[0]]))

    def bar(first: Array, last: Array, radius: float, material: str = "carbon") -> Solid:
        return rod(first, last, radius, material, 0.75 * radius)

    def motor(joint: str, axis: tuple[float, float, float]) -> Joint:
        limits, torque, rotor = MOTORS[joint]
        low, high = limits
        if joint == "hip_roll" and side < 0.0:
            low, high = -high, -low
        robot.motor(f"{name}_{joint}", torque)
        more: More = {
            "range": (low, high),
            "actuatorfrcrange": (-torque, torque),
            "armature": rotor,
        }
        return Joint(f"{name}_{joint}", axis=axis, more=more)

    def add(body: str, parent: str, where: Array, joint: Joint, solids: list[Solid]) -> None:
        robot.body(f"{name}_{body}", parent and f"{name}_{parent}", where, joint, solids)

    pitch = (0.0, -1.0, 0.0)
    roll, yaw = (PELVIS_HEIGHT * Z + np.array([x, side * y, z]) for x, y, z in (HIP_ROLL, HIP_YAW))
    forward = np.array([1.0, 0.0, 0.0])
    robot.body(
        f"{name}_hip_roll",
        "pelvis",
        roll,
        motor("hip_roll", (1.0, 0.0, 0.0)),
        [rod(roll - 0.075 * forward, roll - 0.005 * forward, 0.05, "aluminum")],
    )
    add(
        "hip_yaw",
        "hip_roll",
        yaw,
        motor("hip_yaw", (0.0, 0.0, 1.0)),
        [rod(yaw - 0.065 * Z, yaw - 0.005 * Z, 0.045, "aluminum")],
    )
    knee, shin, tarsus = (place(p) for p in (at_pin.knee, at_pin.shin, at_pin.tarsus))
    outward = np.array([0.0, side, 0.0])
    add(
        "thigh",
        "hip_yaw",
        hip,
        motor("hip_pitch", pitch),
        [
            rod(hip - 0.02 * outward, hip + 0.06 * outward, 0.06, "aluminum"),
            rod(knee - 0.02 * outward, knee + 0.06 * outward, 0.05, "aluminum"),
            rod(hip - 0.05 * outward, hip - 0.02 * outward, 0.02, "anodized"),
        ],
    )
    add("knee", "thigh", knee, motor("knee", pitch), [rod(knee, shin, 0.022, "anodized")])
    sprung: More = {"range": (-0.35, 0.35), "stiffness": SHIN_STIFFNESS}
    add(
        "shin",
        "knee",
        shin,
        Joint(f"{name}_shin", axis=pitch, more=sprung),
        [bar(shin, tarsus, 0.025), ball(0.018, tarsus, "aluminum")],
    )
    ankle, heel = place(at_pin.ankle), place(at_pin.heel)
    crank = place(at_pin.crank)
    add(
        "tarsus",
        "shin",
        tarsus,
        Joint(f"{name}_tarsus", axis=pitch, more={"range": (-1.2, 1.2)}),
        [bar(tarsus, ankle, 0.02), rod(crank - 0.03 * outward, crank, 0.025, "anodized")],
    )
    end = place(at_pin.rod, ACHILLES_HEEL)
    heel_beside = place(at_pin.heel, ACHILLES_HEEL)
    add(
        "heel_spring",
        "tarsus",
        heel,
        Joint(f"{name}_heel_spring", axis=pitch, more={"stiffness": HEEL_STIFFNESS}),
        [rod(heel_beside, end, 0.007, "steel")],
    )
    start = place(at_pin.hip, ACHILLES_HIP)
    add(
        "achilles_rod",
        "thigh",
        start,
        Joint(f"{name}_achilles", "ball"),
        [bar(start, end, 0.008)],
    )
    plantar, horn = (place(p, -0.023) for p in (at_pin.plantar, at_pin.horn))
    crank_beside = place(at_pin.crank, -0.023)
    add(
        "toe_crank",
        "tarsus",
        crank,
        motor("toe", pitch),
        [rod(crank_beside, plantar, 0.01, "steel")],
    )
    add(
        "plantar_rod",
        "toe_crank",
        plantar,
        Joint(f"{name}_plantar", axis=pitch),
        [bar(plantar, horn, 0.006)],
    )
    back, toe = place(at_pin.heel_of_foot), place(at_pin.toe)
    add(
        "foot",
        "tarsus",
        ankle,
        Joint(f"{name}_foot", axis=pitch, more={"range": (-0.9, 0.9)}),
        [rod(back, toe, 0.018, "rubber"), rod(ankle, place(at_pin.horn), 0.01, "aluminum")],
    )
    robot.site(f"{name}_sole", f"{name}_foot", 0.5 * (back + toe))
    robot.connect(f"{name}_achilles_rod", f"{name}_heel_spring", end)
    robot.connect(f"{name}_plantar_rod", f"{name}_foot", horn)
