"""What systems need of a term: its peak and its support."""

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
    """Middle of the points of greatest membership.

    Of the principal membership for general type-2 and the upper one for interval sets.
    """
    if isinstance(item, GeneralType2Set):
        item = item.principal
    elif isinstance(item, IntervalType2Set):
        item = item.upper
    maxima = item.maxima
    if maxima is None:
        # A sigmoid never reaches its height; four times the width of its slope behind its center it
        # is at 0.98 of it.
        points = item.landmarks
        near = points[item(points) > 0.95 * item.height]
        return float(near[np.argmin(item(near))])
    return 0.5 * (float(maxima[0]) + float(maxima[1]))


def range_of(terms: Sequence[Any]) -> tuple[float, float]:
    """Range from the lowest to the highest peak of the terms of an input.

    That of the domain if they have one peak.
    """
    peaks = [highest_point(term) for term in terms]
    return (min(peaks), max(peaks)) if max(peaks) > min(peaks) else domain_of(terms)


def domain_of(terms: Sequence[Any]) -> tuple[float, float]:
    """Range on which sets live.

    Either end is that of the support if it is finite, else the outermost landmark above exp(-12.5),
    of a Gaussian 4 sigma away.
    """
    left, right = np.inf, -np.inf
    for item in terms:
        upper = item.upper
        ends = upper.support
        if not np.isfinite(ends).all():
            points = item.landmarks
            grades = upper(points)
            inside = points[grades > np.exp(-12.5) * grades.max()]
            # An end that is finite is one, though the grade is 0 there.
            ends = (
                ends[0] if np.isfinite(ends[0]) else float(inside.min()),
                ends[1] if np.isfinite(ends[1]) else float(inside.max()),
            )
        left, right = min(left, ends[0]), max(right, ends[1])
    return left, right


def spread(item: Any) -> float:
    """Width of a consequent, for the modified height reducer.

    Half of its cut at exp(-1/2), a Gaussian's standard deviation.
    """
    upper = item.principal if isinstance(item, GeneralType2Set) else item.upper
    left, right = upper.alpha_cut(np.exp(-0.5) * upper.height)
    if not right > left:
        raise NotApplicable(
            "modified height type reduction", f"the consequent {item!r} has no width to divide by"
        )
    return 0.5 * float(right - left)
