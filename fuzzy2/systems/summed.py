"""Union of all consequents of one output, on a grid of points.

:mod:`fuzzy2.systems.united` computes it without a grid.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fuzzy2.operations.t_norms import TConorm, TNorm
from fuzzy2.reduction.defuzzification import defuzzify_samples
from fuzzy2.sets.type1 import Type1Set
from fuzzy2.support.checks import Array
from fuzzy2.systems.averages import averaged
from fuzzy2.systems.maxima import maximum
from fuzzy2.systems.operators import MAXIMA
from fuzzy2.systems.terms import domain_of

_BLOCK, _GRADES = 64, 2**22
"""Greatest number of inputs whose united sets are in memory at a time, and of their grades."""


class Summed:
    """The output sets of all rules on a grid, prepared for any firing strengths.

    Parameters
    ----------
    sets : sequence of R sets of type 1 or interval type-2 sets
        Consequent of each rule.
    implication : TNorm
        T-norm that combines a rule's firing strength with its output set.
    aggregation : TConorm, or None
        T-conorm that unites the rules' sets; None adds them up.
    ends : (float, float), optional
        Range of the output; by default the range that the sets cover (``terms.domain_of``).
    integration : {"sum", "trapezoidal", "midpoint", "left"}
        Placement of the points, see :class:`fuzzy2.FuzzySystem`.
    resolution : int
        Number of points.
    """

    def __init__(
        self,
        sets: Sequence[Any],
        implication: TNorm,
        aggregation: TConorm | None,
        ends: tuple[float, float] | None,
        integration: str,
        resolution: int,
    ) -> None:
        self._implication, self._aggregation = implication, aggregation
        self._integration = integration
        self.crisp = all(isinstance(item, Type1Set) for item in sets)
        distinct: list[Any] = []
        for item in sets:
            if item not in distinct:
                distinct.append(item)
        self._number = np.array([distinct.index(item) for item in sets])
        self._points = _grid(*(ends or domain_of(sets)), integration, resolution)
        self._grades = np.array(
            [[item.lower(self._points), item.upper(self._points)] for item in distinct]
        )

    @property
    def sampled(self) -> tuple[Array, Array, NDArray[np.int64]]:
        """Points (N,), grades of the different sets there (K, 2, N), and the set of each rule."""
        return self._points, self._grades, self._number

    @property
    def halves_ends(self) -> bool:
        """Whether the first and the last point have half weight."""
        return self._integration == "trapezoidal"

    @property
    def has_middles(self) -> bool:
        """Whether the points are middles of pieces."""
        return self._integration == "midpoint"

    def reduced(
        self, kind: str, strengths: Array, method: str, shares: tuple[float, float]
    ) -> Array:
        """Return the type-reduced intervals (n, 2) of unions for firing intervals (n, R, 2)."""
        reduced = np.empty((len(strengths), 2))
        size = max(1, min(_BLOCK, _GRADES // (len(self._number) * len(self._points))))
        for start in range(0, len(strengths), size):
            # Inputs are processed in blocks, so memory does not grow with their number.
            block = slice(start, start + size)
            united = self._united(strengths[block])
            if kind in ("centroid", "center_of_sums"):
                weights = np.moveaxis(united, 1, 2)
                if self.halves_ends:
                    half = np.where([1, *[0] * (len(self._points) - 2), 1], 0.5, 1.0)
                    weights = weights * half[:, None]
                reduced[block] = averaged(self._points, weights, method, shares)
                continue
            grades = united[:, 1]
            if kind in MAXIMA:
                found = maximum(self._points, grades, kind)
            elif self.has_middles:
                found = middle_of_area(self._points, grades)
            else:
                found = defuzzify_samples(self._points, grades, "bisector")
            reduced[block] = np.stack([found, found], axis=-1)
        return reduced

    def _united(self, strengths: Array) -> Array:
        """Return the lower and upper grades (n, 2, N) of unions."""
        shapes = self._grades[self._number]
        clipped = self._implication(strengths[..., np.newaxis], shapes[np.newaxis])
        if self._aggregation is None:
            return np.asarray(clipped.sum(axis=1))
        return clipped[:, 0] if clipped.shape[1] == 1 else self._aggregation.reduce(clipped, axis=1)


def _grid(left: float, right: float, integration: str, count: int) -> Array:
    """Return the grid points over an output's range."""
    step = (right - left) / count
    if integration == "midpoint":
        return np.asarray(left + step * (np.arange(count) + 0.5))
    if integration == "left":
        # Points are accumulated step by step, because rounding decides whether a set of one point
        # is hit.
        steps: Array = np.full(count, step)
        steps[0] = left
        return np.asarray(np.cumsum(steps))
    return np.asarray(np.linspace(left, right, count), dtype=np.float64)


def middle_of_area(grid: Array, grades: Array) -> Array:
    """Return the points (n,) up to which grades (n, N) sum up to nearly half of their total.

    If several are equally near, their mean is returned, as fuzzylite's bisector does. It is NaN
    where all grades are 0.
    """
    areas = np.cumsum(grades, axis=1)
    total = areas[:, -1:]
    with np.errstate(invalid="ignore"):
        off = np.abs(areas / total - 0.5)
        nearest = off == off.min(axis=1, keepdims=True)
        return np.asarray((grid * nearest).sum(axis=1) / nearest.sum(axis=1))
