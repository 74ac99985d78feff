"""Shares of the rules in an output.

Center of sets and similar type reductions are averages. The share of a rule is its relative weight
in the average, so the sum of shares times consequents is the output. An interval system has shares
at both ends, and their mean is returned. For united sets it is the share of the area: under a sum,
the area of the rule's clipped set, and under a t-conorm, the area where the rule's set is the
highest.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from fuzzy2.reduction.logarithms import as_floats, centroid_in_logarithms, relative
from fuzzy2.support.checks import Array
from fuzzy2.systems.averages import height_weights, log_height_weights
from fuzzy2.systems.consequents import FunctionsOfInputs
from fuzzy2.systems.explainable import Explainable
from fuzzy2.systems.operators import DIRECT_METHODS, SUM
from fuzzy2.systems.terms import domain_of

POINTS = 4001
"""Number of points of the output at which the highest set is determined."""
ROUNDING = 1e-13
"""Distance of a point from an end, relative to the largest point, below which they are equal."""


def shares_of(system: Explainable, row: Array, logarithms: Array, far: bool) -> Array:
    """Return the shares (R, m) of the rules; 0 in an output for which no rule fires.

    Parameters
    ----------
    system : FuzzySystem
        A type-1 or interval type-2 system.
    row : (1, p) array
        The input.
    logarithms : (R, 2) array
        Logarithms of the firing intervals at the input.
    far : bool
        Whether the firing intervals underflow.
    """
    shares = np.zeros((len(logarithms), system.n_outputs))
    for j in range(system.n_outputs):
        rules = np.arange(len(logarithms))
        if system.silent is not None:
            rules = np.flatnonzero(~system.silent[:, j])
        if logarithms[rules, 1].max(initial=-np.inf) > -np.inf:
            shares[rules, j] = _of_output(system, row, rules, (logarithms[rules], far), j)
    return shares


def _of_output(
    system: Explainable, row: Array, rules: Any, fired: tuple[Array, bool], j: int
) -> Array:
    logarithms, far = fired
    kind = system.type_reduction
    sets = None
    if system.consequent_sets is not None:
        sets = [system.consequent_sets[int(r)][j] for r in rules]
    if sets is None or kind in ("center_of_sets", "weighted_sum", "tsukamoto"):
        points = points_of_rules(system, row, j)[rules]
        return in_average(points, logarithms, system.method, system.shares)
    firing = as_floats(logarithms[np.newaxis])[0] if far else np.exp(logarithms)
    if kind in ("height", "modified_height"):
        modified = kind == "modified_height"
        if far:
            points, weights = log_height_weights(sets, logarithms[np.newaxis], modified)
        else:
            peaks, clipped = height_weights(sets, firing[np.newaxis], system.implication, modified)
            points = np.stack([peaks, peaks], axis=-1)
            with np.errstate(divide="ignore"):
                weights = np.log(clipped)
        return in_average(points, weights[0], system.method, system.shares)
    ends = None if system.output_ranges is None else system.output_ranges[j]
    summed = kind == "center_of_sums" or system.t_conorm is SUM
    return _in_union(system, sets, firing, ends, summed)


def points_of_rules(system: Explainable, row: Array, j: int) -> Array:
    """Return the consequents for an output at an input (1, p), as intervals (R, 2)."""
    if isinstance(system.consequents, FunctionsOfInputs):
        return np.asarray(system.consequents.at(row)[0][:, j])
    return system.consequent_intervals[:, j]


def in_average(
    points: Array, logarithms: Array, method: str, shares: tuple[float, float] = (0.5, 0.5)
) -> Array:
    """Return the shares (R,) of intervals (R, 2) weighted by logarithms, averaged over both ends.

    At an end of the exact interval, each weight is the upper or the lower one, depending on the
    side of the end on which its point lies.
    """
    low, high = logarithms.T
    if method in DIRECT_METHODS and method != "wu_mendel":
        if method == "nie_tan" or not low.max() > -np.inf:
            return _normalized(np.logaddexp(low, high))
        both = shares[0] * _normalized(low) + shares[1] * _normalized(high)
        return np.asarray(both / sum(shares))
    ends = centroid_in_logarithms(points, logarithms[np.newaxis])[0]
    # A point that equals the end, up to rounding, may have any weight, or outweighs the others.
    reach = ROUNDING * np.abs(points).max()
    sides = points[:, 0] <= ends[0] + reach, points[:, 1] >= ends[1] - reach
    left, right = (_normalized(np.where(within, high, low)) for within in sides)
    return np.asarray(0.5 * (left + right))


def _normalized(logarithms: Array) -> Array:
    """Return weights, given as logarithms, divided by their sum."""
    weights = relative(logarithms)
    return np.asarray(weights / weights.sum())


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
        # Each point takes half of the gap on both sides, as in the trapezoidal rule.
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
