"""Type-reduced outputs from the firing of the rules, by any type reduction."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fuzzy2.errors import NotApplicable
from fuzzy2.operations.t_norms import T_CONORMS, T_NORMS, TConorm, TNorm
from fuzzy2.reduction.logarithms import as_floats
from fuzzy2.support.checks import Array
from fuzzy2.systems.averages import (
    Monotonic,
    averaged,
    averaged_in_logarithms,
    height_weights,
    log_height_weights,
    weighted_sum,
)
from fuzzy2.systems.consequents import FunctionsOfInputs
from fuzzy2.systems.operators import DIRECT_METHODS, HEIGHTS, POINTS, SUM, UNIONS
from fuzzy2.systems.summed import Summed
from fuzzy2.systems.united import United


@dataclass(frozen=True)
class Operators:
    """Operators that turn the firing of rules into outputs; see :class:`fuzzy2.FuzzySystem`."""

    type_reduction: str
    method: str
    shares: tuple[float, float]
    implication: TNorm
    aggregation: TConorm
    integration: str
    resolution: int


def hangs_on_ratios(operators: Operators) -> bool:
    """Return whether the output depends only on ratios of firing strengths."""
    kind = operators.type_reduction
    return kind == "center_of_sets" or (
        kind in (*HEIGHTS, "centroid", "center_of_sums")
        and operators.implication == T_NORMS["product"]
        and operators.aggregation in (T_CONORMS["max"], SUM)
    )


class Outputs:
    """The consequents of a system, prepared for any firing.

    Parameters
    ----------
    operators : Operators
        Operators that reduce them.
    consequents : FunctionsOfInputs, or anything
        Functions of the inputs. Otherwise ``sets`` or ``intervals`` are used.
    sets : list of lists of sets, or None
        Consequents that are sets, by rule and output; None where a rule has no consequent for an
        output.
    intervals : (R, m, 2) ndarray
        Consequents, or their centroids.
    silent : (R, m) ndarray of bool, or None
        Where a rule has no consequent for an output.
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
        self.operators, self.consequents = operators, consequents
        self.intervals, self.silent = intervals, silent
        count = intervals.shape[1]
        self.ranges = ranges or (None,) * count
        self.speaking = [
            np.arange(len(intervals)) if silent is None else np.flatnonzero(~silent[:, j])
            for j in range(count)
        ]
        kind = operators.type_reduction
        self.sets: list[list[Any]] = []
        if sets is not None and kind not in POINTS:
            self.sets = [[sets[int(r)][j] for r in rules] for j, rules in enumerate(self.speaking)]
        self.same = (
            [self._groups(sets, j) for j in range(count)] if kind.startswith("united") else []
        )
        self.united: list[United | None] = [None] * count
        self.summed: list[Summed | None] = [None] * count
        self.monotonic: list[Monotonic | None] = [None] * count
        for j, ends in enumerate(self.ranges):
            if not self.speaking[j].size:
                continue
            if kind == "tsukamoto":
                self.monotonic[j] = Monotonic(self.sets[j], ends)
            if kind in UNIONS and operators.integration == "exact":
                self.united[j] = self._union(j, ends)
            elif kind in UNIONS:
                self.summed[j] = Summed(
                    self.sets[j],
                    operators.implication,
                    self.aggregation,
                    ends,
                    operators.integration,
                    operators.resolution,
                )

    def _union(self, j: int, ends: tuple[float, float] | None) -> United:
        own = self.operators
        if own.method == "wu_mendel":
            raise NotApplicable(
                "method 'wu_mendel'", "its bounds need points; take integration='sum'"
            )
        return United(self.sets[j], own.implication, self.aggregation, ends)

    @property
    def aggregation(self) -> TConorm | None:
        """Aggregation of the rules' sets; None adds them up."""
        own = self.operators
        summed = own.type_reduction == "center_of_sums" or own.aggregation is SUM
        return None if summed else own.aggregation

    def __call__(self, rows: Array, strengths: Array) -> Array:
        """Return the type-reduced intervals (n, m, 2) of inputs and firing intervals (n, R, 2)."""
        own = self.operators
        if own.type_reduction in POINTS:
            return self._of_points(rows, strengths)
        outputs = []
        for j, rules in enumerate(self.speaking):
            if rules.size:
                outputs.append(self._of_sets(j, strengths[:, rules]))
            else:
                outputs.append(np.full((len(strengths), 2), np.nan))
        return np.stack(outputs, axis=1)

    def in_logarithms(self, rows: Array, logarithms: Array) -> Array:
        """Do as ``__call__`` with logarithms of firing intervals (n, R, 2).

        :func:`hangs_on_ratios` must be true for the type reduction.
        """
        own = self.operators
        found = np.full((len(rows), len(self.speaking), 2), np.nan)
        for j, rules in enumerate(self.speaking):
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
                points, weights = log_height_weights(self.sets[j], weights, modified)
                found[:, j] = averaged_in_logarithms(points, weights, own.method, own.shares)
            else:
                found[:, j] = self._of_sets(j, as_floats(weights))
        return found

    def _points_of(self, rows: Array, j: int, logarithms: Array) -> tuple[Array, Array | float]:
        """Return the consequents for an output, with 0 for infinite ones, and the sum of those."""
        rules = self.speaking[j]
        if not isinstance(self.consequents, FunctionsOfInputs):
            return self.intervals[rules, j], 0.0
        points = self.consequents.at(rows)[:, rules, j]
        finite = np.isfinite(points)
        with np.errstate(invalid="ignore"):
            said = ~finite & (logarithms[..., 1:] > -np.inf)
            beyond = np.where(said, points, 0.0).sum(axis=-2)
        return np.where(finite, points, 0.0), beyond

    def _of_points(self, rows: Array, strengths: Array) -> Array:
        own = self.operators
        weights = strengths[:, np.newaxis]
        if self.silent is not None:
            weights = np.where(self.silent.T[np.newaxis, ..., np.newaxis], 0.0, weights)
        beyond: Array | float = 0.0
        if isinstance(self.consequents, FunctionsOfInputs):
            intervals = np.moveaxis(self.consequents.at(rows), 2, 1)
            finite = np.isfinite(intervals)
            if not finite.all():
                # A function value that is not a number only matters if its rule fires.
                said = ~finite & (weights[..., 1:] > 0.0)
                with np.errstate(invalid="ignore"):
                    beyond = np.where(said, intervals, 0.0).sum(axis=-2)
                intervals = np.where(finite, intervals, 0.0)
        else:
            intervals = np.moveaxis(self.intervals, 1, 0)[np.newaxis]
        if self.same:
            n, _, rules, _ = weights.shape
            weights = np.array(np.broadcast_to(weights, (n, len(self.same), rules, 2)))
        for j, groups in enumerate(self.same):
            self._unite(weights[:, j], groups)
        if own.type_reduction in ("weighted_sum", "united_sum"):
            return weighted_sum(intervals, weights) + beyond
        return averaged(intervals, weights, own.method, own.shares) + beyond

    def _groups(self, sets: Sequence[Sequence[Any]] | None, j: int) -> list[list[int]]:
        """Return groups of rules that have the same consequent for an output."""
        if isinstance(self.consequents, FunctionsOfInputs):
            functions = self.consequents
            said: list[Any] = [functions.said(r, j) for r in range(len(self.intervals))]
        elif sets is not None:
            said = [row[j] for row in sets]
        else:
            said = [row.tobytes() for row in self.intervals[:, j] + 0.0]
        first = [said.index(one) for one in said]
        speaking = self.speaking[j].tolist()
        groups = [[r for r in speaking if first[r] == one] for one in sorted(set(first))]
        return [group for group in groups if len(group) > 1]

    def _unite(self, weights: Array, groups: list[list[int]]) -> None:
        """Assign the united firing of rules (n, R, 2) with one consequent to the first of them."""
        for group in groups:
            together = self.operators.aggregation.reduce(weights[:, group], axis=1)
            weights[:, group] = 0.0
            weights[:, group[0]] = together

    def _of_sets(self, j: int, strengths: Array) -> Array:
        own, sets = self.operators, self.sets[j]
        kind = own.type_reduction
        if kind in HEIGHTS:
            points, weights = height_weights(
                sets, strengths, own.implication, kind == "modified_height"
            )
            return averaged(points, weights, own.method, own.shares)
        monotonic = self.monotonic[j]
        if monotonic is not None:
            points = monotonic.points(strengths[..., 1])
            finite = np.isfinite(points)
            found = averaged(
                np.stack([np.where(finite, points, 0.0)] * 2, axis=-1), strengths, "eiasc"
            )
            # An average with one infinity is infinite; with both infinities it is NaN.
            with np.errstate(invalid="ignore"):
                beyond = np.where(finite, 0.0, points).sum(axis=-1, keepdims=True)
            return np.asarray(found + beyond)
        united = self.united[j]
        summed = self.summed[j]
        if summed is not None:
            return summed.reduced(kind, strengths, own.method, own.shares)
        assert united is not None
        if kind in ("centroid", "center_of_sums"):
            if own.method in DIRECT_METHODS:
                return united.average(strengths, own.method, own.shares)
            return united.centroids(strengths)
        found = (
            united.bisectors(strengths) if kind == "bisector" else united.maxima(strengths, kind)
        )
        return np.stack([found, found], axis=-1)
