"""How much of an output each rule decides: its share in the average that the output is.

Center of sets and its kin are averages, and the share of a rule is its weight there; the shares
times what the rules say add up to the output. Of an interval system that is so at both ends, and
the share is the mean of both. Of united sets the share is that of the area: under a sum what the
rule's clipped set adds, under a t-conorm where the rule's set is the highest.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from fuzzy2.reduction.interval import generalized_centroid
from fuzzy2.support.checks import Array
from fuzzy2.systems.averages import height_weights
from fuzzy2.systems.consequents import FunctionsOfInputs
from fuzzy2.systems.explainable import Explainable
from fuzzy2.systems.operators import DIRECT_METHODS, SUM
from fuzzy2.systems.terms import domain_of

POINTS = 4001
"""Points of the output at which the highest set is looked for."""


def shares_of(system: Explainable, row: Array, firing: Array) -> Array:
    """Return the shares (R, m) of the rules; zero in an output for which no rule fires.

    Parameters
    ----------
    system : FuzzySystem
        A type-1 or interval type-2 system.
    row : (1, p) array
        The input.
    firing : (R, 2) array
        The firing intervals there.
    """
    shares = np.zeros((len(firing), system.n_outputs))
    for j in range(system.n_outputs):
        rules = np.arange(len(firing))
        if system.silent is not None:
            rules = np.flatnonzero(~system.silent[:, j])
        if firing[rules, 1].max(initial=0.0) > 0.0:
            shares[rules, j] = _of_output(system, row, rules, firing[rules], j)
    return shares


def _of_output(system: Explainable, row: Array, rules: Any, firing: Array, j: int) -> Array:
    kind = system.type_reduction
    sets = None
    if system.consequent_sets is not None:
        sets = [system.consequent_sets[int(r)][j] for r in rules]
    if sets is None or kind in ("center_of_sets", "weighted_sum", "tsukamoto"):
        points = points_of_rules(system, row, j)[rules]
        return in_average(points, firing, system.method, system.shares)
    if kind in ("height", "modified_height"):
        peaks, weights = height_weights(
            sets, firing[np.newaxis], system.implication, kind == "modified_height"
        )
        points = np.stack([peaks, peaks], axis=-1)
        return in_average(points, weights[0], system.method, system.shares)
    ends = None if system.output_ranges is None else system.output_ranges[j]
    summed = kind == "center_of_sums" or system.t_conorm is SUM
    return _in_union(system, sets, firing, ends, summed)


def points_of_rules(system: Explainable, row: Array, j: int) -> Array:
    """Return what the rules say of an output at an input (1, p), as intervals (R, 2)."""
    if isinstance(system.consequents, FunctionsOfInputs):
        return np.asarray(system.consequents.at(row)[0][:, j])
    return system.consequent_intervals[:, j]


def in_average(
    points: Array, weights: Array, method: str, shares: tuple[float, float] = (0.5, 0.5)
) -> Array:
    """Return the shares (R,) of weighted intervals (R, 2), averaged over both ends.

    At an end of the exact interval each weight is the upper or the lower one, by the side of the
    end on which its point lies.
    """
    # Relative to the greatest, for sums of tiny weights.
    low, high = (weights / weights[:, 1].max()).T
    if method in DIRECT_METHODS and method != "wu_mendel":
        if method == "nie_tan" or not low.any():
            return np.asarray((low + high) / (low + high).sum())
        both = shares[0] * low / low.sum() + shares[1] * high / high.sum()
        return np.asarray(both / sum(shares))
    ends = generalized_centroid(points, weights)
    taken = []
    for side, within in ((0, points[:, 0] <= ends[0]), (1, points[:, 1] >= ends[1])):
        weight = np.where(within, high, low)
        if not weight.any():
            # The end is a point that rounding puts beyond it.
            away = np.where(high > 0.0, np.abs(points[:, side] - ends[side]), np.inf)
            weight[np.argmin(away)] = 1.0
        taken.append(weight / weight.sum())
    return np.asarray(0.5 * (taken[0] + taken[1]))


def _in_union(
    system: Explainable,
    sets: Sequence[Any],
    firing: Array,
    ends: tuple[float, float] | None,
    summed: bool,
) -> Array:
    left, right = ends or domain_of(sets)
    points = np.unique(
        np.concatenate([np.linspace(left, right, POINTS), *(item.landmarks for item in sets)])
    )
    points = points[(points >= left) & (points <= right)]
    if all(item.upper.support[0] == item.upper.support[1] for item in sets):
        points = np.unique([item.upper.support[0] for item in sets])
        widths = np.ones(len(points))
    else:
        # Half of each gap to both sides, which is the trapezoid's rule.
        gaps = np.diff(points)
        widths = 0.5 * (np.append(gaps, 0.0) + np.insert(gaps, 0, 0.0))
    grades = np.array([[item.lower(points), item.upper(points)] for item in sets])
    clipped = system.implication(firing[:, :, np.newaxis], grades).mean(axis=1)
    if not summed:
        highest = clipped >= clipped.max(axis=0) * (1.0 - 1e-12)
        clipped = np.where(highest, clipped, 0.0) / highest.sum(axis=0)
    areas = clipped @ widths
    total = areas.sum()
    return np.asarray(areas / total if total > 0.0 else areas)
