"""Delta robot with six rods."""

from __future__ import annotations

import numpy as np

from .solids import Y, Z, around, at, ball, beams, box, columns, cross, moved, rod, turn
from .urdf import Robot


def delta() -> Robot:
    """Return three arms, each with two parallel rods to a platform that cannot rotate."""
    base, arm, rod_length, platform, spacing = 0.12, 0.2, 0.4, 0.05, 0.09
    robot = Robot("delta", "Delta robot: three driven arms, six rods.")
    azimuths = {leg: 2.0 * np.pi / 3.0 * (leg - 1) for leg in (1, 2, 3)}
    # The beams are above the arms, clear of their whole swing.
    stand = beams(0.46, 0.3, azimuths.values(), 0.04) + columns(
        0.46, 0.3, -0.62, azimuths.values(), 0.04
    )
    stand += [rod(0.05 * Z, 0.09 * Z, 0.16, "anodized"), rod(0.09 * Z, 0.3 * Z, 0.06, "anodized")]
    for azimuth in azimuths.values():
        sideways, shoulder = around(azimuth + np.pi / 2.0, 1.0), around(azimuth, base)
        stand += [
            box((0.05, 0.05, 0.06), shoulder + 0.055 * sideways + 0.022 * Z, "aluminum", azimuth),
            rod(shoulder + 0.03 * sideways, shoulder + 0.13 * sideways, 0.026, "rubber"),
        ]
    robot.base(stand)
    # At home the arms are level, and each rod leans inward by this angle.
    lean = np.arcsin((base + arm - platform) / rod_length)
    link = [
        rod([0.02, 0.0, 0.0], [arm, 0.0, 0.0], 0.014, "carbon", 0.012),
        rod(-0.03 * Y, 0.03 * Y, 0.024, "aluminum"),
        rod([arm, -0.5 * spacing, 0.0], [arm, 0.5 * spacing, 0.0], 0.008, "steel"),
    ]
    thin = [
        rod(-0.012 * Z, (0.012 - rod_length) * Z, 0.006, "carbon", 0.004),
        rod(-0.018 * Z, 0.0 * Z, 0.009, "anodized"),
        ball(0.01, -rod_length * Z, "steel"),
    ]
    for leg, azimuth in azimuths.items():
        placement = at(around(azimuth, base), turn(azimuth))
        robot.body(
            f"leg{leg}_arm",
            link,
            f"leg{leg}_shoulder",
            "base",
            placement,
            "y",
            (-1.0, 1.5),
            0.0,
            (30.0, 20.0),
        )
        for number, side in ((1, 1.0), (2, -1.0)):
            name = f"leg{leg}_rod{number}"
            hinge = at([arm, 0.5 * side * spacing, 0.0])
            robot.body(
                f"{name}_cross",
                cross(0.005, 0.024, "y", "x"),
                f"{name}_pitch",
                f"leg{leg}_arm",
                hinge,
                "y",
                (-1.5, 2.6),
                lean,
            )
            robot.body(name, thin, f"{name}_swing", f"{name}_cross", at(), "x", (-1.2, 1.2))
    ends = {
        (leg, number): around(azimuth, platform)
        + 0.5 * side * spacing * around(azimuth + np.pi / 2.0, 1.0)
        for leg, azimuth in azimuths.items()
        for number, side in ((1, 1.0), (2, -1.0))
    }
    plate = [
        rod(-0.012 * Z, 0.0 * Z, 0.045, "anodized"),
        rod(-0.05 * Z, -0.012 * Z, 0.012, "accent"),
        *(rod(ends[leg, 1], ends[leg, 2], 0.007, "steel") for leg in azimuths),
    ]
    # A ball joint at the lower end of the first rod of leg 1 carries the platform. It cancels the
    # swing and pitch of the rod, so its middle angle is always 0, far from its singularity.
    lower = at(-rod_length * Z)
    robot.body(
        "platform_cross1",
        cross(0.004, 0.02, "x", "z"),
        "platform_x",
        "leg1_rod1",
        lower,
        "x",
        (-1.2, 1.2),
    )
    robot.body(
        "platform_cross2",
        cross(0.004, 0.02, "z", "y"),
        "platform_z",
        "platform_cross1",
        at(),
        "z",
        (-1.2, 1.2),
    )
    robot.body(
        "platform",
        moved(plate, -ends[1, 1]),
        "platform_y",
        "platform_cross2",
        at(),
        "y",
        (-2.6, 2.6),
        -lean,
    )
    robot.frame("tip", "platform", -ends[1, 1])
    for (leg, number), end in ends.items():
        if (leg, number) != (1, 1):
            robot.frame(f"leg{leg}_rod{number}_end", f"leg{leg}_rod{number}", -rod_length * Z)
            robot.frame(f"platform_leg{leg}_rod{number}", "platform", end - ends[1, 1])
            robot.close(f"platform_leg{leg}_rod{number}", f"leg{leg}_rod{number}_end")
    return robot
