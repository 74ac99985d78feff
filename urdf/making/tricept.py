"""Tricept: three UPS legs and a UP leg."""

from __future__ import annotations

import numpy as np

from .extensible_leg import extensible_leg
from .solids import X, Y, Z, around, at, beams, box, columns, rod
from .urdf import Robot


def tricept() -> Robot:
    """Return three legs of adjustable length and a tube in the middle.

    The tube slides in a universal joint and carries platform and tool.
    """
    base, platform, depth, tool = 0.4, 0.16, 1.15, 0.25
    robot = Robot(
        "tricept",
        "Tricept: three legs of adjustable length (UPS) around a sliding central tube (UP).",
    )
    azimuths = {leg: 2.0 * np.pi / 3.0 * (leg - 1) for leg in (1, 2, 3)}
    feet = {leg: around(azimuth, base) for leg, azimuth in azimuths.items()}
    # A single column, outside of the tool's reach.
    stand = beams(0.47, 0.11, azimuths.values(), 0.08)
    stand += beams(1.3, 0.11, [azimuths[3]], 0.12) + columns(1.3, 0.11, -1.85, [azimuths[3]], 0.16)
    stand.append(rod(0.07 * Z, 0.15 * Z, 0.17, "anodized"))
    stand += [box((0.03, 0.08, 0.1), [x, 0.0, 0.03], "aluminum") for x in (-0.1, 0.1)]
    # A fork above each leg's universal joint, with its hinge perpendicular to the leg's azimuth.
    for azimuth, foot in zip(azimuths.values(), feet.values(), strict=True):
        sideways = around(azimuth + np.pi / 2.0, 0.055)
        stand += [
            box((0.08, 0.02, 0.1), foot + side * sideways + 0.03 * Z, "aluminum", azimuth)
            for side in (-1.0, 1.0)
        ]
    robot.base(stand)
    corners = {leg: around(azimuth, platform) for leg, azimuth in azimuths.items()}
    down = -depth * Z
    for leg in azimuths:
        extensible_leg(
            robot,
            f"leg{leg}",
            feet[leg],
            corners[leg] + down,
            (0.04, 0.8),
            (0.02, 0.85),
            (0.9, 1.55),
            (5000.0, 2.0),
        )
    ring = [rod(-0.05 * Y, 0.05 * Y, 0.02, "steel"), rod(-0.09 * X, 0.09 * X, 0.02, "steel")]
    sleeve = [rod(-0.08 * Z, 0.08 * Z, 0.06, "anodized", 0.045)]
    tube = [
        rod(0.0 * Z, 1.5 * Z, 0.045, "steel", 0.04),
        rod(-0.03 * Z, 0.0 * Z, 0.19, "anodized"),
        rod(-0.17 * Z, -0.03 * Z, 0.05, "aluminum"),
        rod(-tool * Z, -0.17 * Z, 0.012, "accent"),
        *(
            rod(corner - 0.02 * Z, corner + 0.01 * Z, 0.03, "aluminum")
            for corner in corners.values()
        ),
    ]
    robot.body("center_cross", ring, "center_universal_x", "base", at(), "x", (-0.7, 0.7))
    robot.body(
        "center_sleeve", sleeve, "center_universal_y", "center_cross", at(), "y", (-0.7, 0.7)
    )
    # The tube's coordinate is the distance from the universal joint down to the platform.
    robot.body(
        "platform", tube, "center_length", "center_sleeve", at(), "along -z", (0.8, 1.45), depth
    )
    robot.frame("tip", "platform", -tool * Z)
    for leg, corner in corners.items():
        robot.frame(f"leg{leg}_end", f"leg{leg}_rod")
        robot.frame(f"platform_corner{leg}", "platform", corner)
        robot.close(f"platform_corner{leg}", f"leg{leg}_end")
    return robot
