"""Gough-Stewart platform (6-UPS)."""

from __future__ import annotations

import numpy as np

from .extensible_leg import extensible_leg
from .solids import Z, around, at, cross, moved, rod, turn_to
from .urdf import Robot


def gough_stewart() -> Robot:
    """Return six legs of adjustable length between a base and a platform.

    Each has a universal joint below and a ball above.
    """
    base, platform, height = 0.5, 0.3, 0.7
    robot = Robot("gough_stewart", "Gough-Stewart platform: six legs of adjustable length (6-UPS).")
    near = np.radians(10.0)
    feet = [
        around(2.0 * np.pi / 3.0 * k + sign * near, base)
        for k, sign in ((0, 1), (1, -1), (1, 1), (2, -1), (2, 1), (3, -1))
    ]
    corners = [
        around(np.pi / 3.0 + 2.0 * np.pi / 3.0 * k + sign * near, platform)
        for k, sign in ((0, -1), (0, 1), (1, -1), (1, 1), (2, -1), (2, 1))
    ]
    floor = [rod(-0.09 * Z, -0.06 * Z, 0.6, "anodized"), rod(-0.11 * Z, -0.09 * Z, 0.56, "rubber")]
    robot.base(
        [*floor, *(rod(foot - 0.06 * Z, foot - 0.02 * Z, 0.05, "aluminum") for foot in feet)]
    )
    lift = height * Z
    for leg, (foot, corner) in enumerate(zip(feet, corners, strict=True), start=1):
        extensible_leg(
            robot,
            f"leg{leg}",
            foot,
            corner + lift,
            (0.035, 0.5),
            (0.018, 0.55),
            (0.6, 0.95),
            (3000.0, 2.0),
        )
        if leg == 1:
            plate = [
                rod(0.02 * Z, 0.04 * Z, 0.32, "anodized"),
                rod(0.04 * Z, 0.1 * Z, 0.06, "aluminum"),
                rod(0.1 * Z, 0.16 * Z, 0.02, "accent"),
                *(rod(point, point + 0.02 * Z, 0.03, "aluminum") for point in corners),
            ]
            # In the home pose the ball's axes are those of the base.
            level = at(rotation=turn_to(corner + lift - foot).T)
            robot.body(
                "platform_cross1",
                cross(0.012, 0.06, "x", "y"),
                "platform_x",
                "leg1_rod",
                level,
                "x",
                (-1.5, 1.5),
            )
            robot.body(
                "platform_cross2",
                cross(0.012, 0.06, "y", "z"),
                "platform_y",
                "platform_cross1",
                at(),
                "y",
                (-1.5, 1.5),
            )
            robot.body(
                "platform",
                moved(plate, -corner),
                "platform_z",
                "platform_cross2",
                at(),
                "z",
                (-1.5, 1.5),
            )
            robot.frame("tip", "platform", -corner)
        else:
            robot.frame(f"leg{leg}_end", f"leg{leg}_rod")
            robot.frame(f"platform_corner{leg}", "platform", corner - corners[0])
            robot.close(f"platform_corner{leg}", f"leg{leg}_end")
    return robot
