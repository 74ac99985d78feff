"""Place names beside points so that they do not overlap."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.transforms import Bbox

from psp3.checks import Array

SIZE = 8.0
"""Size of the letters [points]."""

STEP = 5.0
"""Distance from a point to its name, and then between rings of candidate places [points]."""

RINGS = 40
"""Number of rings of candidate places."""

DIRECTIONS = np.deg2rad([20.0, -20.0, 160.0, 200.0, 90.0, -90.0, 50.0, -50.0, 130.0, 230.0])
"""Directions of a name from its point, with preference for the right."""

ROOM = 1.0
"""Margin around points and names [points]."""


def label_points(
    axes: Axes, points: Sequence[tuple[float, float]], names: Sequence[str], colors: Sequence[Any]
) -> None:
    """Write names beside points of axes whose limits are final.

    Each name, in the order given, takes the nearest place within the axes where it overlaps neither
    a point nor a name, or else the least overlap. A thin line leads to a name that is not beside
    its point. Names are not parsed as formulas.

    Parameters
    ----------
    axes : Axes
        Where the points are.
    points : sequence of (float, float)
        Coordinates in the units of the axes.
    names : sequence of str
        A name for each.
    colors : sequence
        Their colors.
    """
    figure: Any = axes.get_figure(root=True)
    # The layout moves the axes, so it must be done before sizes are measured.
    figure.draw_without_rendering()
    pixels = figure.dpi / 72.0
    places = axes.transData.transform(np.reshape(points, (-1, 2)))
    taken = [_box(place, np.full(2, 2.0 * ROOM + SIZE / 2) * pixels) for place in places]
    for place, point, name, color in zip(places, points, names, colors, strict=True):
        size = _size(axes, name) + 2.0 * ROOM * pixels
        ring, center = _free_place(place, size, STEP * pixels, axes.bbox, taken)
        taken.append(_box(center, size))
        axes.annotate(
            name,
            point,
            xytext=tuple((center - place) / pixels),
            textcoords="offset points",
            fontsize=SIZE,
            ha="center",
            va="center",
            arrowprops={"arrowstyle": "-", "color": color, "linewidth": 0.5} if ring else None,
        )


def _size(axes: Axes, name: str) -> Array:
    """Return width and height of a name [pixels]."""
    text = axes.text(0.5, 0.5, name, fontsize=SIZE, transform=axes.transAxes)
    size = np.array(text.get_window_extent().size)
    text.remove()
    return size


def _box(center: Array, size: Array) -> Bbox:
    return Bbox([center - 0.5 * size, center + 0.5 * size])


def _free_place(
    place: Array, size: Array, step: float, frame: Any, taken: Sequence[Bbox]
) -> tuple[int, Array]:
    """Return ring and center of the first place where a name overlaps nothing, or least."""
    least, best = np.inf, (0, place)
    for ring, direction in itertools.product(range(RINGS), DIRECTIONS):
        toward = np.array([np.cos(direction), np.sin(direction)])
        # An edge or a corner of the name is on the ring; above and below the point it is centered.
        center = place + (ring + 1) * step * toward + 0.5 * size * np.clip(1.5 * toward, -1.0, 1.0)
        box = _box(center, size)
        covered = sum(_common(box, other) for other in taken)
        covered += size[0] * size[1] - _common(box, frame)
        if covered < least:
            least, best = covered, (ring, center)
        # Small overlaps are rounding errors of sums of pixels.
        if least <= 1e-6 * size[0] * size[1]:
            break
    return best


def _common(one: Bbox, other: Any) -> float:
    """Return the area of the overlap of two boxes."""
    both = Bbox.intersection(one, other)
    return 0.0 if both is None else float(both.width * both.height)
