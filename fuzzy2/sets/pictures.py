"""Small pictures of sets of all types, for notebooks."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from fuzzy2.support.checks import Array
from fuzzy2.support.markup import Markup
from fuzzy2.support.quadrature import merged
from fuzzy2.support.shown import Curve, Shown, captioned, small_picture

POINTS = 61
"""Number of points of a curve besides those where it bends."""
TAIL = 3e-3
"""Grade below which the tail of an unbounded set is left out."""
LOWEST_PLANE = 0.01
"""The α-plane that represents a general type-2 set."""


def picture_of_sets(sets: Sequence[Any], name: str) -> Markup:
    """Return the membership functions of sets as SVG.

    A type-2 set shows its footprint of uncertainty; a general type-2 set shows its α-plane at 0.01.
    """
    ends = _ends(sets)
    bends = merged(*(np.asarray(item.landmarks, float) for item in sets))
    # Floats beside the bends are included because a set may jump there.
    points = merged(
        np.linspace(*ends, POINTS), bends, np.nextafter(bends, -np.inf), np.nextafter(bends, np.inf)
    )
    points = points[(points >= ends[0]) & (points <= ends[1])]
    return small_picture(ends, [_grades(item, points) for item in sets], points, name)


class ShownSet(Shown):
    """Set that shows its membership in notebooks."""

    def _repr_html_(self) -> Markup:
        text = repr(self)
        return captioned(picture_of_sets([self], text), text)


def _grades(item: Any, points: Array) -> Curve:
    if hasattr(item, "alpha_plane"):
        plane = item.alpha_plane(LOWEST_PLANE)
        return plane.lower(points), plane.upper(points)
    return item.lower(points), item.upper(points)


def _ends(sets: Sequence[Any]) -> tuple[float, float]:
    """Return the range in which the membership is visible, with a margin."""
    least, greatest = math.inf, -math.inf
    for item in sets:
        shown = item.principal if hasattr(item, "alpha_plane") else item.upper
        points = merged(np.asarray(item.landmarks, float), np.asarray(shown.landmarks, float))
        seen = points[shown(points) > TAIL * shown.height]
        seen = seen if seen.size else points
        left, right = item.support if hasattr(item, "alpha_plane") else shown.support
        least = min(least, left if math.isfinite(left) else float(seen[0]))
        greatest = max(greatest, right if math.isfinite(right) else float(seen[-1]))
    margin = 0.04 * (greatest - least) or 1.0
    return least - margin, greatest + margin
