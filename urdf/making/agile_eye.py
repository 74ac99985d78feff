"""The Agile Eye, a spherical parallel wrist with neighboring axes at right angles."""

from __future__ import annotations

import itertools

import numpy as np

from .solids import Array, Solid, Z, at, ball, box, rod, turn_to
from .urdf import Robot

MOTOR, OUTER, INNER, PLATE = 0.13, 0.105, 0.085, 0.070
"""Distances from the center: motors, the two joints of a leg, and the platform's pins."""

DIGITS = 6
"""Number of digits, as from a CAD program: with rounded numbers the loops miss closure by
micrometers."""


def axes() -> Array:
    """Return the axes of the three motors as rows: at right angles, and equally steep.

    The azimuth of axis 1 is that of x.
    """
    azimuths = 2.0 * np.pi / 3.0 * np.arange(3)
    level = np.sqrt(2.0 / 3.0) * np.array([np.cos(azimuths), np.sin(azimuths)])
    return np.vstack([level, np.full(3, np.sqrt(1.0 / 3.0))]).T


def arc(first: Array, last: Array, radii: tuple[float, float], thick: float) -> list[Solid]:
    """Return a quarter ring from one axis to another, made of straight pieces."""
    angles = np.linspace(0.0, 0.5 * np.pi, 7)
    ring = np.cos(angles)[:, None] * first + np.sin(angles)[:, None] * last
    ring *= np.linspace(*radii, len(angles))[:, None]
    return [rod(a, b, thick, "aluminum") for a, b in itertools.pairwise(ring)]


def agile_eye() -> Robot:
    """Return three legs of two quarter rings each, whose nine axes meet in one point."""
    robot = Robot(
        "agile_eye",
        "Agile Eye, a spherical 3-RRR wrist around the origin, written with six digits.",
        "hinge",
        DIGITS,
    )
    axis = axes()
    floor = [rod(-0.22 * Z, -0.20 * Z, 0.17, "anodized"), rod(-0.23 * Z, -0.22 * Z, 0.15, "rubber")]
    for one in axis:
        floor += [
            rod(-(MOTOR + 0.005) * one, -(MOTOR + 0.06) * one, 0.024, "rubber"),
            box((0.03, 0.03, 0.14), -(MOTOR + 0.05) * one * [1.0, 1.0, 0.0] - 0.14 * Z, "anodized"),
        ]
    robot.base(floor)
    last = {"base": at()}

    def link(
        name: str, joint: str, parent: str, along: Array, distance: float, solids: list[Solid]
    ) -> None:
        """Add a link with a hinge on an axis through the center, where its solids are given."""
        world = at(distance * along, turn_to(along))
        inside = [solid._replace(placement=world.inverse() * solid.placement) for solid in solids]
        motor = (5.0, 30.0) if parent == "base" else None
        place = last[parent].inverse() * world
        robot.body(name, inside, joint, parent, place, "z", (-1.5, 1.5), 0.0, motor)
        last[name] = world

    for leg in (1, 2, 3):
        first, second, third = (axis[(leg - 1 + k) % 3] for k in (0, 2, 1))
        outer = [
            rod(-OUTER * first, -(MOTOR + 0.005) * first, 0.012, "steel"),
            *arc(-first, second, (OUTER, OUTER), 0.009),
            rod((INNER - 0.005) * second, (OUTER + 0.008) * second, 0.01, "anodized"),
        ]
        inner = [
            *arc(second, third, (INNER, PLATE + 0.008), 0.007),
            rod(PLATE * third, (PLATE + 0.014) * third, 0.009, "anodized"),
        ]
        link(f"leg{leg}_outer", f"leg{leg}_motor", "base", first, -MOTOR, outer)
        link(f"leg{leg}_inner", f"leg{leg}_elbow", f"leg{leg}_outer", second, OUTER, inner)
    pins = {leg: axis[leg % 3] for leg in (1, 2, 3)}
    plate = [
        *(rod(0.0 * Z, PLATE * pin, 0.008, "aluminum") for pin in pins.values()),
        ball(0.02, 0.0 * Z, "anodized"),
        rod(0.0 * Z, 0.1 * Z, 0.02, "accent"),
    ]
    link("platform", "platform_pin", "leg1_inner", pins[1], PLATE, plate)
    of_center = last["platform"].inverse()
    robot.frame("tip", "platform", of_center.translation, of_center.rotation)
    for leg in (2, 3):
        pin = at(PLATE * pins[leg], turn_to(pins[leg]))
        for name in (f"leg{leg}_inner", "platform"):
            place = last[name].inverse() * pin
            robot.frame(f"{name}_pin{leg}", name, place.translation, place.rotation)
        robot.close(f"platform_pin{leg}", f"leg{leg}_inner_pin{leg}")
    return robot
