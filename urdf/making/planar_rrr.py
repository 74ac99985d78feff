"""Planar robots with legs of a crank and a rod: 3-RRR and 4-RRR."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from .solids import Z, around, at, box, moved, rod, turn
from .urdf import Robot

BASE, PLATFORM, CRANK, COUPLER = 0.3, 0.08, 0.16, 0.18


def planar_3rrr() -> Robot:
    """Return a triangle carried by three legs of a crank and a rod each, in a horizontal plane."""
    azimuths = {leg: np.pi / 2.0 + 2.0 * np.pi / 3.0 * (leg - 1) for leg in (1, 2, 3)}
    return _planar(Robot("planar_3rrr", "Planar 3-RRR robot in the plane z = 0."), azimuths)


def planar_4rrr() -> Robot:
    """Return a square carried by four such legs: four motors for three freedoms."""
    azimuths = {leg: np.pi / 4.0 + np.pi / 2.0 * (leg - 1) for leg in (1, 2, 3, 4)}
    title = "Planar 4-RRR robot in the plane z = 0: four motors for three degrees of freedom."
    return _planar(Robot("planar_4rrr", title), azimuths)


def _planar(robot: Robot, azimuths: Mapping[int, float]) -> Robot:
    table = [rod(-0.10 * Z, -0.08 * Z, 0.36, "anodized"), rod(-0.11 * Z, -0.10 * Z, 0.33, "rubber")]
    for azimuth in azimuths.values():
        shaft = around(azimuth, BASE)
        table += [
            rod(shaft - 0.08 * Z, shaft - 0.025 * Z, 0.034, "rubber"),
            rod(shaft - 0.025 * Z, shaft - 0.008 * Z, 0.02, "steel"),
        ]
    robot.base(table)
    # In the home pose the platform is centered and not rotated. The angles follow from the law of
    # cosines in the triangle of shaft, elbow and wrist.
    reach = BASE - PLATFORM
    swing = np.arccos((reach**2 + CRANK**2 - COUPLER**2) / (2.0 * reach * CRANK))
    bend = np.pi - np.arccos((CRANK**2 + COUPLER**2 - reach**2) / (2.0 * CRANK * COUPLER))
    for leg, azimuth in azimuths.items():
        upper = [
            box((CRANK, 0.024, 0.008), [0.5 * CRANK, 0.0, 0.0], "aluminum"),
            rod(-0.008 * Z, 0.01 * Z, 0.02, "anodized"),
            rod([CRANK, 0.0, -0.006], [CRANK, 0.0, 0.01], 0.015, "anodized"),
        ]
        lower = [
            box((COUPLER, 0.016, 0.006), [0.5 * COUPLER, 0.0, 0.016], "carbon"),
            rod(0.01 * Z, 0.022 * Z, 0.012, "steel"),
            rod([COUPLER, 0.0, 0.012], [COUPLER, 0.0, 0.022], 0.012, "steel"),
        ]
        # The crank's angle is measured from the direction to the middle.
        placement = at(around(azimuth, BASE), turn(azimuth + np.pi))
        robot.body(
            f"leg{leg}_crank",
            upper,
            f"leg{leg}_shoulder",
            "base",
            placement,
            "z",
            (-1.0, 2.2),
            swing,
            (10.0, 20.0),
        )
        robot.body(
            f"leg{leg}_rod",
            lower,
            f"leg{leg}_elbow",
            f"leg{leg}_crank",
            at([CRANK, 0.0, 0.0]),
            "z",
            (-2.7, 2.7),
            -bend,
        )
    corners = {leg: around(azimuth, PLATFORM) for leg, azimuth in azimuths.items()}
    plate = [rod(0.022 * Z, 0.034 * Z, 0.03, "anodized"), rod(0.034 * Z, 0.07 * Z, 0.008, "accent")]
    for corner, azimuth in zip(corners.values(), azimuths.values(), strict=True):
        plate += [
            box((PLATFORM, 0.022, 0.008), 0.5 * corner + 0.028 * Z, "aluminum", azimuth),
            rod(corner + 0.022 * Z, corner + 0.036 * Z, 0.014, "anodized"),
        ]
    # In the home pose the platform's axes are the base's. The rod of leg 1 is then rotated by the
    # azimuth of its frame, the swing and the bend.
    rod_direction = azimuths[1] + np.pi + swing - bend
    robot.body(
        "platform",
        moved(plate, -corners[1]),
        "leg1_wrist",
        "leg1_rod",
        at([COUPLER, 0.0, 0.0], turn(-rod_direction)),
        "z",
        (-2.7, 2.7),
    )
    robot.frame("tip", "platform", -corners[1])
    for leg in list(azimuths)[1:]:
        robot.frame(f"leg{leg}_end", f"leg{leg}_rod", [COUPLER, 0.0, 0.0])
        robot.frame(f"platform_corner{leg}", "platform", corners[leg] - corners[1])
        robot.close(f"platform_corner{leg}", f"leg{leg}_end")
    return robot
