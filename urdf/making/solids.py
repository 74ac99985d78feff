"""Solids with shape and mass, the materials of all robots, and placements."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

MATERIALS = {
    "steel": ("0.78 0.80 0.82 1", 7850.0),
    "screw": ("0.48 0.50 0.53 1", 7850.0),
    "aluminum": ("0.62 0.65 0.68 1", 2700.0),
    "anodized": ("0.20 0.23 0.27 1", 2700.0),
    "accent": ("0.93 0.42 0.10 1", 2700.0),
    "brass": ("0.72 0.56 0.27 1", 8500.0),
    "carbon": ("0.10 0.10 0.11 1", 1600.0),
    "rubber": ("0.14 0.14 0.15 1", 1200.0),
    "pvc": ("0.91 0.83 0.55 1", 1400.0),
}
"""Color and density [kg/m³] of each material; anodized and accent are aluminum, screw is steel."""

X, Y, Z = np.eye(3)
"""Unit vectors."""


class Solid(NamedTuple):
    """A homogeneous solid, which is drawn and has mass.

    ``bore`` is the radius of the hole along a cylinder [m].
    """

    shape: str
    size: tuple[float, ...]
    material: str
    placement: pin.SE3
    bore: float = 0.0

    def inertia(self) -> pin.Inertia:
        """Return the mass, center of mass and moments of inertia, in the frame of the link."""
        density = MATERIALS[self.material][1]
        if self.shape == "box":
            body = pin.Inertia.FromBox(density * float(np.prod(self.size)), *self.size)
        elif self.shape == "sphere":
            body = pin.Inertia.FromSphere(
                density * 4.0 / 3.0 * np.pi * self.size[0] ** 3, *self.size
            )
        else:
            outer, length = self.size
            mass = density * np.pi * (outer**2 - self.bore**2) * length
            axial = 0.5 * mass * (outer**2 + self.bore**2)
            transverse = 0.5 * axial + mass * length**2 / 12.0
            body = pin.Inertia(mass, np.zeros(3), np.diag([transverse, transverse, axial]))
        return self.placement.act(body)


def box(
    size: tuple[float, float, float], center: ArrayLike, material: str, turn: float = 0.0
) -> Solid:
    """Return a box, rotated about the vertical through its center."""
    return Solid(
        "box", size, material, pin.SE3(pin.utils.rotate("z", turn), np.asarray(center, dtype=float))
    )


def ball(radius: float, center: ArrayLike, material: str) -> Solid:
    """Return a ball."""
    return Solid("sphere", (radius,), material, pin.SE3(np.eye(3), np.asarray(center, dtype=float)))


def rod(start: ArrayLike, end: ArrayLike, radius: float, material: str, bore: float = 0.0) -> Solid:
    """Return a cylinder between two points, or a tube."""
    first, last = np.asarray(start, dtype=float), np.asarray(end, dtype=float)
    placement = pin.SE3(turn_to(last - first), 0.5 * (first + last))
    return Solid(
        "cylinder", (radius, float(np.linalg.norm(last - first))), material, placement, bore
    )


def cross(radius: float, length: float, first: str, second: str) -> list[Solid]:
    """Return the two pins of a universal joint.

    They are along the axes ``x``, ``y`` or ``z`` of its two hinges.
    """
    axes = {"x": X, "y": Y, "z": Z}
    return [
        rod(-0.5 * length * axes[axis], 0.5 * length * axes[axis], radius, "steel")
        for axis in (first, second)
    ]


def moved(solids: Iterable[Solid], by: ArrayLike) -> list[Solid]:
    """Return solids given about another origin, at ``by`` in the frame of the link."""
    shift = pin.SE3(np.eye(3), np.asarray(by, dtype=float))
    return [solid._replace(placement=shift * solid.placement) for solid in solids]


def around(angle: float, radius: float, height: float = 0.0) -> Array:
    """Return the point at an azimuth and a distance from the vertical axis."""
    return np.array([radius * np.cos(angle), radius * np.sin(angle), height])


def turn_to(direction: Array) -> Array:
    """Return a rotation that takes z to a direction and keeps x horizontal."""
    z = direction / np.linalg.norm(direction)
    x = np.cross(Z, z)
    x = x / np.linalg.norm(x) if np.linalg.norm(x) > 1e-12 else X
    return np.column_stack([x, np.cross(z, x), z])


def at(position: ArrayLike = (0.0, 0.0, 0.0), rotation: ArrayLike | None = None) -> pin.SE3:
    """Return a placement; without a rotation the axes are parallel."""
    return pin.SE3(
        np.eye(3) if rotation is None else np.asarray(rotation), np.asarray(position, dtype=float)
    )


def turn(angle: float) -> Array:
    """Return the rotation about the vertical."""
    return np.asarray(pin.utils.rotate("z", angle))


def beams(radius: float, height: float, azimuths: Iterable[float], width: float) -> list[Solid]:
    """Return beams from the axis outward."""
    return [
        box((radius, width, width), around(azimuth, 0.5 * radius, height), "anodized", azimuth)
        for azimuth in azimuths
    ]


def columns(
    radius: float, top: float, floor: float, azimuths: Iterable[float], width: float
) -> list[Solid]:
    """Return columns at a distance from the axis, each with a foot."""
    solids = []
    for azimuth in azimuths:
        middle, foot = around(azimuth, radius, 0.5 * (top + floor)), around(azimuth, radius, floor)
        solids += [
            box((width, width, top - floor + width), middle, "anodized", azimuth),
            rod(foot - width * Z, foot - 0.5 * width * Z, 1.2 * width, "rubber"),
        ]
    return solids


def meet(first: Array, r1: float, second: Array, r2: float, side: float) -> Array:
    """Return the point at given distances from two others, left (1) or right of their line."""
    across = second - first
    distance = float(np.linalg.norm(across))
    along = (r1**2 - r2**2 + distance**2) / (2.0 * distance)
    x, z = across / distance
    return np.asarray(
        first + along * across / distance + side * np.sqrt(r1**2 - along**2) * np.array([-z, x])
    )
