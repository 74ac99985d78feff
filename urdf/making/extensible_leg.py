"""Leg of adjustable length, on a universal joint."""

from __future__ import annotations

import numpy as np

from .solids import Array, Z, at, ball, cross, rod, turn_to
from .urdf import Robot


def extensible_leg(
    robot: Robot,
    name: str,
    foot: Array,
    end: Array,
    tube: tuple[float, float],
    piston: tuple[float, float],
    stroke: tuple[float, float],
    motor: tuple[float, float],
) -> None:
    """Add a universal joint at ``foot`` and a slider.

    The slider's coordinate is the distance to the leg's end.

    At home the leg points to ``end`` and its universal joint is straight: the leg's frame has z
    along the leg and x horizontal. ``tube`` and ``piston`` hold radius and length.
    """
    placement = at(foot, turn_to(end - foot))
    body = [
        rod(0.0 * Z, tube[1] * Z, tube[0], "aluminum", 0.8 * tube[0]),
        rod((tube[1] - 0.03) * Z, (tube[1] + 0.01) * Z, 1.25 * tube[0], "anodized", 0.8 * tube[0]),
        rod(0.03 * Z, 0.15 * Z, 1.25 * tube[0], "anodized", 0.8 * tube[0]),
    ]
    slider = [
        rod(-piston[1] * Z, 0.0 * Z, piston[0], "screw", 0.7 * piston[0]),
        ball(1.5 * piston[0], np.zeros(3), "steel"),
    ]
    length = float(np.linalg.norm(end - foot))
    robot.body(
        f"{name}_cross",
        cross(0.4 * tube[0], 2.6 * tube[0], "x", "y"),
        f"{name}_universal_x",
        "base",
        placement,
        "x",
        (-1.2, 1.2),
    )
    robot.body(f"{name}_tube", body, f"{name}_universal_y", f"{name}_cross", at(), "y", (-1.2, 1.2))
    robot.body(
        f"{name}_rod",
        slider,
        f"{name}_length",
        f"{name}_tube",
        at(),
        "along z",
        stroke,
        length,
        motor,
    )
