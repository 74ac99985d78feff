"""Outputs that are averages over the rules of a system."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from fuzzy2.errors import NotApplicable
from fuzzy2.operations.t_norms import T_NORMS, TNorm
from fuzzy2.reduction.interval import (
    begian_melek_mendel,
    generalized_centroid,
    nie_tan,
    wu_mendel_bounds,
)
from fuzzy2.reduction.logarithms import (
    average_in_logarithms,
    bounds_in_logarithms,
    centroid_in_logarithms,
)
from fuzzy2.sets.sigmoids import Sigmoid
from fuzzy2.support.checks import Array
from fuzzy2.support.quadrature import merged
from fuzzy2.systems.operators import DIRECT_METHODS
from fuzzy2.systems.terms import highest_point, spread

_HALVINGS = 100
_BEYOND = 1e6
"""Distance, in widths of a set, within which consequents without a range are searched."""


def averaged(
    points: Array, weights: Array, method: str, shares: tuple[float, float] = (0.5, 0.5)
) -> Array:
    """Return the type-reduced intervals (..., 2) of weighted points.

    Parameters
    ----------
    points : (..., R) or (..., R, 2) array
        Points, or intervals.
    weights : (..., R, 2) array
        Weight intervals.
    method : str
        An exact method, or one of ``DIRECT_METHODS``, which returns the same number for both ends.
        For the Wu-Mendel bounds, the middles of the bounds are returned.
    shares : (float, float)
        Weights of the lower and the upper average in the Begian-Melek-Mendel method.
    """
    if method not in DIRECT_METHODS:
        return generalized_centroid(points, weights, method)
    if method == "wu_mendel":
        bounds = wu_mendel_bounds(points, weights)
        left = 0.5 * bounds.left_lower + 0.5 * bounds.left_upper
        right = 0.5 * bounds.right_lower + 0.5 * bounds.right_upper
        return np.stack([left, right], axis=-1)
    if method == "nie_tan":
        middle = nie_tan(points, weights)
    else:
        middle = begian_melek_mendel(points, weights, *shares)
    return np.stack([middle, middle], axis=-1)


def averaged_in_logarithms(
    points: Array, logarithms: Array, method: str, shares: tuple[float, float] = (0.5, 0.5)
) -> Array:
    """Do as :func:`averaged`, with points (R, 2) or (n, R, 2) and logarithms of weights."""
    if method not in DIRECT_METHODS:
        return centroid_in_logarithms(points, logarithms)
    if method == "wu_mendel":
        return bounds_in_logarithms(points, logarithms)
    middles = points.mean(axis=-1)
    if method == "nie_tan":
        # The weight of a rule is the sum of its lower and upper weight.
        both = np.logaddexp(logarithms[..., 0], logarithms[..., 1])
        middle = average_in_logarithms(middles, both)
    else:
        low, high = (average_in_logarithms(middles, logarithms[..., end]) for end in (0, 1))
        middle = shares[0] * np.where(np.isnan(low), high, low) + shares[1] * high
    return np.stack([middle, middle], axis=-1)


def heights(sets: Sequence[Any]) -> tuple[Array, Array]:
    """Return the points of greatest membership (R,) of sets, and the grades there (R, 2)."""
    points = np.array([highest_point(item) for item in sets])
    both = zip(sets, points, strict=True)
    return points, np.array([[float(item.lower(at)), float(item.upper(at))] for item, at in both])


def height_weights(
    sets: Sequence[Any], strengths: Array, implication: TNorm, modified: bool
) -> tuple[Array, Array]:
    """Return points (R,) and weights (n, R, 2) of the height reducer, or of the modified one."""
    points, grades = heights(sets)
    weights = implication(strengths, grades)
    if modified:
        weights = weights / np.array([spread(item) for item in sets])[:, np.newaxis] ** 2
    return points, weights


def log_height_weights(
    sets: Sequence[Any], logarithms: Array, modified: bool
) -> tuple[Array, Array]:
    """Return the points (R, 2) and logarithms of weights (n, R, 2) under the product."""
    points, factors = height_weights(sets, np.ones((1, len(sets), 2)), T_NORMS["product"], modified)
    with np.errstate(divide="ignore"):
        return np.stack([points, points], axis=-1), logarithms + np.log(factors)


def weighted_sum(intervals: Array, strengths: Array) -> Array:
    """Return the sums (n, 2) of intervals (n or 1, R, 2) with weights (n, R, 2).

    A sum is NaN where no rule fires.
    """
    products = strengths[..., :, np.newaxis] * intervals[..., np.newaxis, :]
    ends = products.reshape(*products.shape[:-2], 4)
    sums = np.stack([ends.min(axis=-1).sum(axis=-1), ends.max(axis=-1).sum(axis=-1)], axis=-1)
    fires = strengths[..., 1].max(axis=-1, keepdims=True) > 0.0
    return np.where(fires, sums, np.nan)


class Monotonic:
    """Monotonic consequents for Tsukamoto's average of the points where they have given grades.

    Parameters
    ----------
    sets : sequence of R type-1 sets
        Sets that are monotonic within the range.
    ends : (float, float), optional
        Range of the output. If a set does not reach a grade within the range, the end with the
        nearest grade is used. Without a range, points anywhere on the line are used.

    Raises
    ------
    NotApplicable
        If a set is not monotonic at 257 points and its landmarks.
    """

    def __init__(self, sets: Sequence[Any], ends: tuple[float, float] | None) -> None:
        self._sets = list(sets)
        bounded = ends is not None
        if ends is None:
            points = merged(*(item.landmarks for item in self._sets))
            ends = float(points[0]), float(points[-1])
        self.is_bounded = bounded
        width = 0.0 if bounded else _BEYOND * (ends[1] - ends[0])
        self.ends = ends[0] - width, ends[1] + width
        self.rising = []
        for item in self._sets:
            inside = item.landmarks[(item.landmarks > ends[0]) & (item.landmarks < ends[1])]
            grades = item(np.sort(np.concatenate([np.linspace(*ends, 257), inside])))
            steps = np.diff(grades)
            if (steps > 0.0).any() == (steps < 0.0).any():
                raise NotApplicable(
                    "type reduction 'tsukamoto'",
                    f"{repr(item)[:80]} does not rise, or fall, all the way on [{ends[0]:.6g}, "
                    f"{ends[1]:.6g}]",
                )
            self.rising.append(bool((steps > 0.0).any()))

    def points(self, strengths: Array) -> Array:
        """Return the points (n, R) at which the sets have the grades (n, R)."""
        found = np.empty_like(strengths)
        for r, (item, rising) in enumerate(zip(self._sets, self.rising, strict=True)):
            if isinstance(item, Sigmoid):
                found[:, r] = self._of_sigmoid(item, strengths[:, r])
                continue
            low = np.full(len(strengths), self.ends[0])
            high = np.full(len(strengths), self.ends[1])
            for _ in range(_HALVINGS):
                middle = 0.5 * (low + high)
                before = (item(middle) < strengths[:, r]) == rising
                low, high = np.where(before, middle, low), np.where(before, high, middle)
            found[:, r] = 0.5 * (low + high)
            if not self.is_bounded:
                # A grade that is approached but never reached, such as 1 for a sigmoid, is at
                # infinity.
                fires = strengths[:, r] > 0.0
                found[fires & (high == self.ends[1]), r] = np.inf
                found[fires & (low == self.ends[0]), r] = -np.inf
        return found

    def _of_sigmoid(self, item: Sigmoid, grades: Array) -> Array:
        """Return the points of grades with the formula, which alone resolves grades near 1."""
        with np.errstate(divide="ignore"):
            points = item.center - np.log((1.0 - grades) / grades) / item.slope
        if self.is_bounded:
            return np.clip(points, *self.ends)
        # The point of a rule that does not fire has weight 0, wherever it is.
        return np.where(grades > 0.0, points, item.center)
