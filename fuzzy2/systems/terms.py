"""Properties of terms that systems need: peak, range and spread."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from fuzzy2.errors import NotApplicable
from fuzzy2.sets.general_type2 import GeneralType2Set
from fuzzy2.sets.interval_type2 import IntervalType2Set
from fuzzy2.sets.type1 import Type1Set

AnySet = Type1Set | IntervalType2Set | GeneralType2Set


def highest_point(item: Any) -> float:
    """Return the middle of the points of greatest membership.

    It is that of the principal membership for general type-2 sets, and of the upper one for
    interval type-2 sets.
    """
    if isinstance(item, GeneralType2Set):
        item = item.principal
    elif isinstance(item, IntervalType2Set):
        item = item.upper
    maxima = item.maxima
    if maxima is None:
        # A sigmoid never reaches its height. Four times the width of its slope beyond its center it
        # reaches 0.98.
        points = item.landmarks
        near = points[item(points) > 0.95 * item.height]
        return float(near[np.argmin(item(near))])
    return 0.5 * (float(maxima[0]) + float(maxima[1]))


def range_of(terms: Sequence[Any]) -> tuple[float, float]:
    """Return the range from the lowest to the highest peak of the terms of an input.

    If all terms have the same peak, it is their domain.
    """
    peaks = [highest_point(term) for term in terms]
    return (min(peaks), max(peaks)) if max(peaks) > min(peaks) else domain_of(terms)


def domain_of(terms: Sequence[Any]) -> tuple[float, float]:
    """Return the range that sets cover.

    Each end is that of the support if it is finite, and otherwise the outermost landmark with a
    grade above exp(-12.5), which is 4 sigma away for a Gaussian.
    """
    left, right = np.inf, -np.inf
    for item in terms:
        upper = item.upper
        ends = upper.support
        if not np.isfinite(ends).all():
            points = item.landmarks
            grades = upper(points)
            inside = points[grades > np.exp(-12.5) * grades.max()]
            # A finite end of the support is used although the grade there is 0.
            ends = (
                ends[0] if np.isfinite(ends[0]) else float(inside.min()),
                ends[1] if np.isfinite(ends[1]) else float(inside.max()),
            )
        left, right = min(left, ends[0]), max(right, ends[1])
    return left, right


def spread(item: Any) -> float:
    """Return the width of a consequent, for the modified height reducer.

    It is half of the cut at exp(-1/2), which is the standard deviation of a Gaussian.
    """
    upper = item.principal if isinstance(item, GeneralType2Set) else item.upper
    left, right = upper.alpha_cut(np.exp(-0.5) * upper.height)
    if not right > left:
        raise NotApplicable(
            "modified height type reduction", f"the consequent {item!r} has no width to divide by"
        )
    return 0.5 * float(right - left)
