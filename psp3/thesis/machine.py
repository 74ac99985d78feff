"""A picture of the robot, drawn without a browser: its shapes in perspective, lit and labeled.

Faces are drawn from the farthest to the nearest (the painter's algorithm). Long faces are cut into
pieces, because this order needs one distance from the eye for each face.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import numpy as np
import pinocchio as pin
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from psp3.checks import Array
from psp3.plots.panels import Panels
from psp3.three_psp.robot import PSP3

HEIGHTS = (0.07, 0.0, 0.03)
"""Heights of the nuts in the picture [m]."""

EYE = np.array([-2.6, 0.75, 0.8])
"""Position of the eye [m]."""

LIGHT = np.array([-0.5, -0.3, 0.81])
"""Direction towards the light, a unit vector to within rounding."""

SIDES = 20
"""Number of sides that approximate a circle."""

LONGEST = 0.03
"""Greatest length of an edge; longer faces are cut [m]."""


def figure_of_machine(robot: PSP3, heights: ArrayLike = HEIGHTS) -> Panels:
    """Draw the robot with the names of its parts.

    Parameters
    ----------
    robot : PSP3
        The robot, made of boxes, cylinders and balls.
    heights : (3,) array_like
        Heights of the nuts [m].

    Returns
    -------
    tuple of Axes
        The one panel.
    """
    figure = Figure(figsize=(4.8, 5.2), layout="constrained")
    panel = figure.subplots()
    faces, colors = _faces_and_colors(robot, heights)
    drawn = PolyCollection(faces, facecolors=colors, edgecolors=colors, linewidths=0.3)
    # Rasterized, because thousands of faces make a large vector file.
    drawn.set_rasterized(True)
    panel.add_collection(drawn)
    panel.set_aspect("equal")
    panel.axis("off")
    everything = np.concatenate(faces)
    low, high = everything.min(axis=0), everything.max(axis=0)
    panel.set(xlim=(low[0] - 0.16, high[0] + 0.16), ylim=(low[1] - 0.02, high[1] + 0.02))
    _name_parts(panel, robot, heights)
    return (panel,)


def _name_parts(panel: Axes, robot: PSP3, heights: ArrayLike) -> None:
    pose = robot.forward_kinematics(heights)
    placements = _placements(robot, heights)
    nuts = [
        next(
            placement.translation
            for geometry, placement in placements
            if geometry.name == f"nut{leg}_0"
        )
        for leg in (1, 2, 3)
    ]
    end = next(place.translation for shape, place in placements if shape.name == "star2_2")
    screw = nuts[0] + [0.0, 0.0, 0.2]
    for words, point, side, height in (
        ("screw", screw, 1, 0.25),
        ("nut 1, at height $a_1$", nuts[0], 1, 0.13),
        ("nut 2, at height $a_2$", nuts[1], -1, -0.2),
        ("nut 3, at height $a_3$", nuts[2], 1, -0.2),
        ("star", end, -1, 0.1),
        ("tip of the tool", np.asarray(pose.tip), -1, 0.25),
    ):
        x, y = _projected(point[None])[0][0]
        left, right = panel.get_xlim()
        panel.annotate(
            words,
            (x, y),
            (right if side > 0 else left, height),
            ha="right" if side > 0 else "left",
            va="center",
            fontsize=9.0,
            arrowprops={"arrowstyle": "-", "linewidth": 0.7, "color": "0.25"},
            bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.85, "pad": 1.0},
        )


def _placements(robot: PSP3, heights: ArrayLike) -> list[tuple[pin.GeometryObject, pin.SE3]]:
    """Return every shape with its placement in base axes."""
    data = robot.visual_model.createData()
    pin.updateGeometryPlacements(
        robot.model,
        robot.model.createData(),
        robot.visual_model,
        data,
        robot.configuration(heights),
    )
    return list(zip(robot.visual_model.geometryObjects, data.oMg, strict=True))


def _faces_and_colors(robot: PSP3, heights: ArrayLike) -> tuple[list[Array], Array]:
    """Return the visible faces, (corners, 2) each, the nearest last, and their colors."""
    faces, colors, distances = [], [], []
    for shape, placement in _placements(robot, heights):
        for corners in _faces(shape.geometry):
            placed = corners @ placement.rotation.T + placement.translation
            normal = np.cross(placed[1] - placed[0], placed[-1] - placed[0])
            if normal @ (EYE - placed[0]) <= 0.0:
                continue
            flat, away = _projected(placed)
            light = max(float(normal @ LIGHT) / float(np.linalg.norm(normal)), 0.0)
            faces.append(flat)
            distances.append(away.mean())
            colors.append(np.clip(shape.meshColor[:3] * (0.55 + 0.5 * light) + 0.04, 0.0, 1.0))
    order = np.argsort(distances)[::-1]
    return [faces[k] for k in order], np.array(colors)[order]


def _projected(points: Array) -> tuple[Array, Array]:
    """Return the projections of points, (..., 2), and their distances along the line of sight."""
    view = -EYE / np.linalg.norm(EYE)
    right = np.cross(view, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    from_eye = points - EYE
    away = from_eye @ view
    flat = np.stack([from_eye @ right, from_eye @ np.cross(right, view)], axis=-1)
    return np.linalg.norm(EYE) * flat / away[:, None], away


def _faces(geometry: object) -> Iterator[Array]:
    """Return the faces of a shape in its own axes; corners run counterclockwise from outside."""
    kind = type(geometry).__name__
    if kind == "Box":
        yield from _faces_of_box(geometry.halfSide)  # type: ignore[attr-defined]
    elif kind == "Cylinder":
        radius, half = geometry.radius, geometry.halfLength  # type: ignore[attr-defined]
        heights = np.linspace(-half, half, 1 + int(np.ceil(2.0 * half / LONGEST)))
        yield from _faces_around(np.full(len(heights), radius), heights)
        ring = _ring(radius)
        yield np.column_stack([ring, np.full(SIDES, half)])
        yield np.column_stack([ring[::-1], np.full(SIDES, -half)])
    else:
        angles = np.linspace(-0.5 * np.pi, 0.5 * np.pi, SIDES // 2 + 1)
        radius = geometry.radius  # type: ignore[attr-defined]
        # The poles are cut off slightly, because a face of zero area has no normal.
        yield from _faces_around(radius * np.maximum(np.cos(angles), 1e-3), radius * np.sin(angles))


def _ring(radius: float) -> Array:
    turns = 2.0 * np.pi * np.arange(SIDES) / SIDES
    return radius * np.column_stack([np.cos(turns), np.sin(turns)])


def _faces_around(radii: Array, heights: Array) -> Iterator[Array]:
    """Return the faces of the surface that a line makes by turning about the z axis."""
    rings = [
        np.column_stack([_ring(radius), np.full(SIDES, height)])
        for radius, height in zip(radii, heights, strict=True)
    ]
    for below, above in pairwise(rings):
        for k in range(SIDES):
            after = (k + 1) % SIDES
            yield np.array([below[k], below[after], above[after], above[k]])


def _faces_of_box(half: Array) -> Iterator[Array]:
    for axis in range(3):
        one, other = (axis + 1) % 3, (axis + 2) % 3
        for side in (-1.0, 1.0):
            along = [
                np.linspace(-half[k], half[k], 1 + int(np.ceil(2.0 * half[k] / LONGEST)))
                for k in (one, other)
            ]
            for i in range(len(along[0]) - 1):
                for j in range(len(along[1]) - 1):
                    corners = np.empty((4, 3))
                    corners[:, axis] = side * half[axis]
                    corners[:, one] = along[0][[i, i + 1, i + 1, i]]
                    corners[:, other] = along[1][[j, j, j + 1, j + 1]]
                    yield corners if side > 0.0 else corners[::-1]
