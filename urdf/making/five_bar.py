"""Planar five-bar linkage."""

from __future__ import annotations

import numpy as np

from .solids import X, Y, Z, at, box, rod
from .urdf import Robot


def five_bar() -> Robot:
    """Return two motors side by side, two cranks, and two rods that meet in a point.

    All are in a vertical plane, seen from the y direction.
    """
    spacing, crank, coupler, swing = 0.2, 0.2, 0.28, 0.6
    robot = Robot("five_bar", "Planar five-bar linkage in the plane y = 0.")
    shafts = {1: 0.5 * spacing * X, 2: -0.5 * spacing * X}
    posts = [box((0.03, 0.03, 0.66), [x, -0.075, -0.29], "anodized") for x in (-0.17, 0.17)]
    motors = [rod(shaft - 0.06 * Y, shaft - 0.15 * Y, 0.032, "rubber") for shaft in shafts.values()]
    bearings = [
        rod(shaft - 0.012 * Y, shaft - 0.05 * Y, 0.022, "steel") for shaft in shafts.values()
    ]
    foot = box((0.46, 0.24, 0.02), [0.0, -0.06, -0.63], "anodized")
    robot.base(
        [box((0.40, 0.03, 0.10), [0.0, -0.05, 0.0], "aluminum"), *posts, foot, *motors, *bearings]
    )
    # The home pose is symmetric, with the point below the middle: each rod leans toward it by this
    # angle.
    lean = np.arcsin((0.5 * spacing + crank * np.sin(swing)) / coupler)
    elbow = -crank * Z
    end = -coupler * Z
    for leg, side in ((1, -1.0), (2, 1.0)):
        # The rods are in front of the cranks, in separate layers.
        depth = (0.018 if leg == 1 else 0.028) * Y
        upper = [
            box((0.026, 0.008, crank), 0.5 * elbow, "aluminum"),
            rod(-0.012 * Y, 0.01 * Y, 0.02, "anodized"),
            rod(elbow - 0.008 * Y, elbow + 0.01 * Y, 0.016, "anodized"),
        ]
        lower = [
            box((0.018, 0.006, coupler), depth + 0.5 * end, "carbon"),
            rod(0.01 * Y, depth + 0.005 * Y, 0.012, "steel"),
            rod(end + depth - 0.004 * Y, end + depth + 0.004 * Y, 0.013, "steel"),
        ]
        if leg == 1:
            lower.append(rod(end + 0.01 * Y, end + 0.055 * Y, 0.006, "accent"))
        shoulder, limits = at(shafts[leg]), (-1.5, 1.5)
        robot.body(
            f"leg{leg}_crank",
            upper,
            f"leg{leg}_shoulder",
            "base",
            shoulder,
            "y",
            limits,
            side * swing,
            (20.0, 20.0),
        )
        bend = -side * (lean + swing)
        robot.body(
            f"leg{leg}_rod",
            lower,
            f"leg{leg}_elbow",
            f"leg{leg}_crank",
            at(elbow),
            "y",
            (-2.6, 2.6),
            bend,
        )
    robot.frame("tip", "leg1_rod", end)
    robot.frame("leg2_end", "leg2_rod", end)
    robot.close("tip", "leg2_end")
    return robot
