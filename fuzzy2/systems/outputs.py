"""From the firing of the rules to type-reduced outputs, by any of the type reductions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fuzzy2.errors import NotApplicable
from fuzzy2.operations.t_norms import T_CONORMS, T_NORMS, TConorm, TNorm
from fuzzy2.reduction.defuzzification import defuzzify_samples
from fuzzy2.reduction.logarithms import as_floats
from fuzzy2.support.checks import Array, binary_exponent
from fuzzy2.systems.averages import (
    Monotonic,
    averaged,
    averaged_in_logarithms,
    height_weights,
    heights,
    log_height_weights,
    weighted_sum,
)
from fuzzy2.systems.consequents import FunctionsOfInputs, Linear
from fuzzy2.systems.maxima import maximum
from fuzzy2.systems.operators import DIRECT_METHODS, MAXIMA, POINTS, SUM, UNIONS
from fuzzy2.systems.table import NORMS
from fuzzy2.systems.terms import domain_of, spread
from fuzzy2.systems.united import GAUSS, TOLERANCE, United

_BLOCK, _GRADES = 64, 2**22
"""Inputs whose united sets are held at a time on a grid, and the most grades of them."""


@dataclass(frozen=True)
class Operators:
    """How the firing of rules becomes outputs; see :class:`fuzzy2.FuzzySystem`."""

    type_reduction: str
    method: str
    shares: tuple[float, float]
    implication: TNorm
    aggregation: TConorm
    integration: str
    resolution: int


WAYS = {"nie_tan": 1, "wu_mendel": 2, "begian_melek_mendel": 3}
"""Codes of the direct methods in :mod:`fuzzy2.systems.output_kernels`."""

TERM_SIZE = 10
"""Numbers of a set for the compiled loop: an input, and its kernel row."""

HEIGHTS = ("height", "modified_height")
"""Type reductions that average highest points."""


def hangs_on_ratios(operators: Operators) -> bool:
    """Return whether nothing but ratios of firing strengths matters."""
    kind = operators.type_reduction
    return kind == "center_of_sets" or (
        kind in (*HEIGHTS, "centroid", "center_of_sums")
        and operators.implication == T_NORMS["product"]
        and operators.aggregation in (T_CONORMS["max"], SUM)
    )


class Outputs:
    """The consequents of a system, ready for any firing.

    Parameters
    ----------
    operators : Operators
        How they are reduced.
    consequents : FunctionsOfInputs, or anything
        Functions; of others the sets or the intervals count.
    sets : list of lists of sets, or None
        Consequents that are sets, by rule and output; None for an output of which a rule says
        nothing.
    intervals : (R, m, 2) ndarray
        Consequents, or their centroids.
    silent : (R, m) ndarray of bool, or None
        Where a rule says nothing of an output.
    ranges : sequence of pairs, or None
        Ranges of the outputs.
    """

    def __init__(
        self,
        operators: Operators,
        consequents: Any,
        sets: Sequence[Sequence[Any]] | None,
        intervals: Array,
        silent: NDArray[np.bool_] | None,
        ranges: Sequence[tuple[float, float]] | None,
    ) -> None:
        self._operators, self._consequents = operators, consequents
        self._intervals, self._silent = intervals, silent
        count = intervals.shape[1]
        self._ranges = ranges or (None,) * count
        self._speaking = [
            np.arange(len(intervals)) if silent is None else np.flatnonzero(~silent[:, j])
            for j in range(count)
        ]
        kind = operators.type_reduction
        self._sets: list[list[Any]] = []
        if sets is not None and kind not in POINTS:
            self._sets = [
                [sets[int(r)][j] for r in rules] for j, rules in enumerate(self._speaking)
            ]
        self._same = (
            [self._groups(sets, j) for j in range(count)] if kind.startswith("united") else []
        )
        self._united: list[United | None] = [None] * count
        self._monotonic: list[Monotonic | None] = [None] * count
        for j, ends in enumerate(self._ranges):
            if not self._speaking[j].size:
                continue
            if kind == "tsukamoto":
                self._monotonic[j] = Monotonic(self._sets[j], ends)
            if kind in UNIONS and operators.integration == "exact":
                self._united[j] = self._union(j, ends)

    def _union(self, j: int, ends: tuple[float, float] | None) -> United:
        own = self._operators
        summed = own.type_reduction == "center_of_sums" or own.aggregation is SUM
        if own.method == "wu_mendel":
            raise NotApplicable(
                "method 'wu_mendel'", "its bounds need points; take integration='sum'"
            )
        return United(self._sets[j], own.implication, None if summed else own.aggregation, ends)

    def __call__(self, rows: Array, strengths: Array) -> Array:
        """Return the type-reduced intervals (n, m, 2) of inputs and firing intervals (n, R, 2)."""
        own = self._operators
        if own.type_reduction in POINTS:
            return self._of_points(rows, strengths)
        outputs = []
        for j, rules in enumerate(self._speaking):
            if rules.size:
                outputs.append(self._of_sets(j, strengths[:, rules]))
            else:
                outputs.append(np.full((len(strengths), 2), np.nan))
        return np.stack(outputs, axis=1)

    def points(self, table: Array, defaults: Array | None) -> Any:
        """Return what the compiled loop averages, or None if it cannot.

        Parameters
        ----------
        table : (k,) ndarray
            The system's, see :mod:`fuzzy2.systems.table`.
        defaults : (m,) ndarray, or None
            Outputs where no rule fires.
        """
        from fuzzy2.systems.output_kernels import Points

        own, count = self._operators, self._intervals.shape[1]
        codes = [WAYS.get(own.method, 0), 0, int(hangs_on_ratios(own))]
        ends, slopes = np.moveaxis(self._intervals, 0, 1), np.empty(0)
        grades, shares = np.empty(0), np.empty(0)
        if own.type_reduction in HEIGHTS:
            found = self._heights(ends.shape)
            if found is None:
                return None
            ends, grades, shares = found
            codes[1] = NORMS.index(own.implication.name)
        elif own.type_reduction == "weighted_sum":
            codes[0] = 4
        elif own.type_reduction != "center_of_sets":
            return None
        if isinstance(self._consequents, Linear):
            ends, slopes = self._consequents.by_input()
        elif isinstance(self._consequents, FunctionsOfInputs):
            return None
        if binary_exponent(np.concatenate([ends.ravel(), slopes.ravel()])):
            return None
        silent = np.zeros(ends.shape[1::-1]) if self._silent is None else self._silent
        return Points(
            table,
            np.ravel(ends),
            np.ravel(slopes),
            grades,
            shares,
            np.ascontiguousarray(silent.T, dtype=float).ravel(),
            np.full(count, np.nan) if defaults is None else np.array(defaults),
            np.array(codes),
            np.array(own.shares),
        )

    def unions(self, table: Array, defaults: Array | None) -> Any:
        """Return what the compiled loop unites and integrates, or None if it cannot.

        Parameters
        ----------
        table : (k,) ndarray
            The system's, see :mod:`fuzzy2.systems.table`.
        defaults : (m,) ndarray, or None
            Outputs where no rule fires.
        """
        from fuzzy2.systems.union_rows import Unions

        own, count = self._operators, self._intervals.shape[1]
        if own.type_reduction not in ("centroid", "center_of_sums"):
            return None
        rows, kinks = [np.empty(0)] * count, [np.empty(0)] * count
        set_of = np.full((count, len(self._intervals)), -1)
        crisp = True
        for j, united in enumerate(self._united):
            if not self._speaking[j].size:
                continue
            known = None if united is None else united.compiled_sets
            if united is None or known is None:
                return None
            rows[j], set_of[j, self._speaking[j]], kinks[j] = known
            crisp = crisp and united.crisp
        summed = own.type_reduction == "center_of_sums" or own.aggregation is SUM
        codes = [own.implication.name == "product", summed, hangs_on_ratios(own), crisp]
        return Unions(
            table,
            np.concatenate(rows),
            np.cumsum([0, *(one.size // (2 * TERM_SIZE) for one in rows)]),
            np.concatenate(kinks),
            np.cumsum([0, *(one.size for one in kinks)]),
            set_of.ravel(),
            np.full(count, np.nan) if defaults is None else np.array(defaults),
            np.array([*codes, WAYS.get(own.method, 0)], dtype=np.int64),
            np.array(own.shares),
            GAUSS,
            TOLERANCE,
        )

    def _heights(self, shape: tuple[int, ...]) -> tuple[Array, Array, Array] | None:
        """Return points (m, R, 2), grades (m R 2,) and shares (m R,) of the height reducers."""
        own = self._operators
        if own.implication != T_NORMS.get(own.implication.name):
            return None
        ends, grades, shares = np.zeros(shape), np.zeros(shape), np.ones(shape[:2])
        modified = own.type_reduction == "modified_height"
        for j, rules in enumerate(self._speaking):
            if not rules.size:
                continue
            points, at = heights(self._sets[j])
            ends[j, rules], grades[j, rules] = points[:, np.newaxis], at
            if modified:
                shares[j, rules] = [1.0 / spread(item) ** 2 for item in self._sets[j]]
        return ends, grades.ravel(), shares.ravel() if modified else np.empty(0)

    def in_logarithms(self, rows: Array, logarithms: Array) -> Array:
        """Do as a call for logarithms of firing intervals (n, R, 2).

        For the type reductions of which :func:`hangs_on_ratios` is true.
        """
        own = self._operators
        found = np.full((len(rows), len(self._speaking), 2), np.nan)
        for j, rules in enumerate(self._speaking):
            weights = logarithms[:, rules]
            if not rules.size:
                continue
            if own.type_reduction == "center_of_sets":
                points, beyond = self._points_of(rows, j, weights)
                found[:, j] = beyond + averaged_in_logarithms(
                    points, weights, own.method, own.shares
                )
            elif own.type_reduction in HEIGHTS:
                modified = own.type_reduction == "modified_height"
                points, weights = log_height_weights(self._sets[j], weights, modified)
                found[:, j] = averaged_in_logarithms(points, weights, own.method, own.shares)
            else:
                found[:, j] = self._of_sets(j, as_floats(weights))
        return found

    def _points_of(self, rows: Array, j: int, logarithms: Array) -> tuple[Array, Array | float]:
        """Return what the rules that speak of an output say, and what of it is not finite."""
        rules = self._speaking[j]
        if not isinstance(self._consequents, FunctionsOfInputs):
            return self._intervals[rules, j], 0.0
        points = self._consequents.at(rows)[:, rules, j]
        finite = np.isfinite(points)
        with np.errstate(invalid="ignore"):
            said = ~finite & (logarithms[..., 1:] > -np.inf)
            beyond = np.where(said, points, 0.0).sum(axis=-2)
        return np.where(finite, points, 0.0), beyond

    def _of_points(self, rows: Array, strengths: Array) -> Array:
        own = self._operators
        weights = strengths[:, np.newaxis]
        if self._silent is not None:
            weights = np.where(self._silent.T[np.newaxis, ..., np.newaxis], 0.0, weights)
        beyond: Array | float = 0.0
        if isinstance(self._consequents, FunctionsOfInputs):
            intervals = np.moveaxis(self._consequents.at(rows), 2, 1)
            finite = np.isfinite(intervals)
            if not finite.all():
                # What a function says where it has no number counts only if its rule fires.
                said = ~finite & (weights[..., 1:] > 0.0)
                with np.errstate(invalid="ignore"):
                    beyond = np.where(said, intervals, 0.0).sum(axis=-2)
                intervals = np.where(finite, intervals, 0.0)
        else:
            intervals = np.moveaxis(self._intervals, 1, 0)[np.newaxis]
        if self._same:
            n, _, rules, _ = weights.shape
            weights = np.array(np.broadcast_to(weights, (n, len(self._same), rules, 2)))
        for j, groups in enumerate(self._same):
            self._unite(weights[:, j], groups)
        if own.type_reduction in ("weighted_sum", "united_sum"):
            return weighted_sum(intervals, weights) + beyond
        return averaged(intervals, weights, own.method, own.shares) + beyond

    def _groups(self, sets: Sequence[Sequence[Any]] | None, j: int) -> list[list[int]]:
        """Return the rules that say the same of an output, of several that do."""
        if isinstance(self._consequents, FunctionsOfInputs):
            functions = self._consequents
            said: list[Any] = [functions.said(r, j) for r in range(len(self._intervals))]
        elif sets is not None:
            said = [row[j] for row in sets]
        else:
            said = [row.tobytes() for row in self._intervals[:, j] + 0.0]
        first = [said.index(one) for one in said]
        speaking = self._speaking[j].tolist()
        groups = [[r for r in speaking if first[r] == one] for one in sorted(set(first))]
        return [group for group in groups if len(group) > 1]

    def _unite(self, weights: Array, groups: list[list[int]]) -> None:
        """Give what rules (n, R, 2) that say the same fire together to the first of them."""
        for group in groups:
            together = self._operators.aggregation.reduce(weights[:, group], axis=1)
            weights[:, group] = 0.0
            weights[:, group[0]] = together

    def _of_sets(self, j: int, strengths: Array) -> Array:
        own, sets = self._operators, self._sets[j]
        kind = own.type_reduction
        if kind in HEIGHTS:
            points, weights = height_weights(
                sets, strengths, own.implication, kind == "modified_height"
            )
            return averaged(points, weights, own.method, own.shares)
        monotonic = self._monotonic[j]
        if monotonic is not None:
            points = monotonic.points(strengths[..., 1])
            finite = np.isfinite(points)
            found = averaged(
                np.stack([np.where(finite, points, 0.0)] * 2, axis=-1), strengths, "eiasc"
            )
            # An average with infinity is infinite, or of both infinities nothing.
            with np.errstate(invalid="ignore"):
                beyond = np.where(finite, 0.0, points).sum(axis=-1, keepdims=True)
            return np.asarray(found + beyond)
        united = self._united[j]
        if united is None:
            return self._summed(sets, self._ranges[j], strengths)
        if kind in ("centroid", "center_of_sums"):
            if own.method in DIRECT_METHODS:
                return united.average(strengths, own.method, own.shares)
            return united.centroids(strengths)
        found = (
            united.bisectors(strengths) if kind == "bisector" else united.maxima(strengths, kind)
        )
        return np.stack([found, found], axis=-1)

    def _summed(self, sets: list[Any], ends: tuple[float, float] | None, strengths: Array) -> Array:
        """Return the intervals (n, 2) of one output from points of its range."""
        own = self._operators
        kind = own.type_reduction
        grid = self._grid(*(ends or domain_of(sets)))
        shapes = np.array([[item.lower(grid), item.upper(grid)] for item in sets])
        reduced = np.empty((len(strengths), 2))
        size = max(1, min(_BLOCK, _GRADES // (len(sets) * own.resolution)))
        for start in range(0, len(strengths), size):
            # A block at a time, so that memory stays that of a block however many inputs there are.
            block = slice(start, start + size)
            clipped = own.implication(strengths[block][..., np.newaxis], shapes[np.newaxis])
            if kind == "center_of_sums" or own.aggregation is SUM:
                united = clipped.sum(axis=1)
            elif clipped.shape[1] > 1:
                united = own.aggregation.reduce(clipped, axis=1)
            else:
                united = clipped[:, 0]
            if kind in ("centroid", "center_of_sums"):
                weights = np.moveaxis(united, 1, 2)
                if own.integration == "trapezoidal":
                    weights = weights * np.where([1, *[0] * (len(grid) - 2), 1], 0.5, 1.0)[:, None]
                reduced[block] = averaged(grid, weights, own.method, own.shares)
                continue
            grades = united[:, 1]
            if kind in MAXIMA:
                found = maximum(grid, grades, kind)
            elif own.integration == "midpoint":
                found = middle_of_area(grid, grades)
            else:
                found = defuzzify_samples(grid, grades, "bisector")
            reduced[block] = np.stack([found, found], axis=-1)
        return reduced

    def _grid(self, left: float, right: float) -> Array:
        """Return the points of an output's range that are summed over."""
        count = self._operators.resolution
        step = (right - left) / count
        if self._operators.integration == "midpoint":
            return np.asarray(left + step * (np.arange(count) + 0.5))
        if self._operators.integration == "left":
            # Step by step, for rounding decides whether a set of one point is seen.
            steps: Array = np.full(count, step)
            steps[0] = left
            return np.asarray(np.cumsum(steps))
        return np.asarray(np.linspace(left, right, count), dtype=np.float64)


def middle_of_area(grid: Array, grades: Array) -> Array:
    """Return the points (n,) up to which grades (n, N) sum up to nearly half of their sum.

    Of several that are equally near their mean, as fuzzylite's bisector does; NaN where all grades
    are 0.
    """
    areas = np.cumsum(grades, axis=1)
    total = areas[:, -1:]
    with np.errstate(invalid="ignore"):
        off = np.abs(areas / total - 0.5)
        nearest = off == off.min(axis=1, keepdims=True)
        return np.asarray((grid * nearest).sum(axis=1) / nearest.sum(axis=1))
