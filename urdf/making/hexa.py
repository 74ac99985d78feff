"""Stewart platform driven by cranks; its rods have balls at both ends and can spin (6-RSS)."""

from __future__ import annotations

import numpy as np

from .mjcf import Assembly, Joint
from .solids import Solid, Z, around, ball, box, rod

BASE, PLATFORM, CRANK, ROD = 0.14, 0.10, 0.06, 0.20
"""Circles of the motors and of the platform's balls, and lengths [m]."""

NEAR_BASE, NEAR_PLATFORM = np.radians(18.0), np.radians(12.0)
"""Half the angle between neighbors [rad]."""


def hexa() -> Assembly:
    """Return six cranks, which turn in planes along the rim and are level at home, and rods."""
    robot = Assembly(
        "hexa", "Stewart platform with six cranks and ball-ended rods that spin (6-RSS)."
    )
    thirds = 2.0 * np.pi / 3.0
    feet, corners, along = [], [], []
    for pair in range(3):
        for side in (-1.0, 1.0):
            azimuth = thirds * pair + side * NEAR_BASE
            feet.append(around(azimuth, BASE))
            # The two cranks of a pair point away from each other.
            along.append(side * around(thirds * pair + 0.5 * np.pi, 1.0))
            corners.append(around(thirds * (pair + 0.5 * side) - side * NEAR_PLATFORM, PLATFORM))
    ends = [foot + CRANK * way for foot, way in zip(feet, along, strict=True)]
    # In the home pose all rods are equally steep.
    level = float(np.linalg.norm(corners[0] - ends[0]))
    lift = np.sqrt(ROD**2 - level**2) * Z
    floor = [
        rod(-0.07 * Z, -0.055 * Z, 0.18, "anodized"),
        rod(-0.08 * Z, -0.07 * Z, 0.17, "rubber"),
    ]
    for number, foot in enumerate(feet):
        azimuth = thirds * (number // 2)
        inward = -around(azimuth, 1.0)
        floor += [
            box((0.04, 0.03, 0.075), foot + 0.04 * inward - 0.02 * Z, "rubber", azimuth),
            rod(foot + 0.008 * inward, foot + 0.02 * inward, 0.008, "steel"),
        ]
    robot.base(floor)
    for number in range(6):
        leg, end, corner = f"leg{number + 1}", ends[number], corners[number] + lift
        axis = np.cross(along[number], Z)
        crank = [
            rod(feet[number], end, 0.006, "anodized"),
            rod(feet[number] - 0.007 * axis, feet[number] + 0.007 * axis, 0.011, "aluminum"),
            ball(0.008, end, "steel"),
        ]
        motor = {"range": (-1.2, 1.2), "actuatorfrcrange": (-3.0, 3.0)}
        turning = Joint(f"{leg}_motor", axis=tuple(axis), more=motor)
        robot.body(f"{leg}_crank", "world", feet[number], turning, crank)
        thin = [rod(end, corner, 0.004, "carbon")]
        robot.body(f"{leg}_rod", f"{leg}_crank", end, Joint(f"{leg}_ball", "ball"), thin)
        robot.motor(f"{leg}_motor", 3.0)
    robot.body(
        "platform",
        "leg1_rod",
        corners[0] + lift,
        Joint("platform_ball", "ball"),
        [
            rod(lift + 0.004 * Z, lift + 0.012 * Z, 0.11, "aluminum"),
            rod(lift + 0.012 * Z, lift + 0.06 * Z, 0.008, "accent"),
            *(_socket(corner + lift) for corner in corners),
        ],
    )
    robot.site("tip", "platform", lift)
    for number in range(1, 6):
        robot.connect(f"leg{number + 1}_rod", "platform", corners[number] + lift)
    return robot


def _socket(center: np.ndarray) -> Solid:
    return ball(0.008, center, "steel")
