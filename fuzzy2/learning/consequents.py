"""Learning of consequents: one rule from each sample, or each rule from all samples."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import numpy as np

from fuzzy2.errors import UnsupportedRule
from fuzzy2.learning.cross_validation import ridge_by_cross_validation
from fuzzy2.learning.partition import (
    Integers,
    centroid_of_term,
    gaussian_partition,
    grades_in,
    principal_terms,
)
from fuzzy2.support.checks import Array

COMPLETIONS = ("nearest", "average", "none", "refuse")
"""Names of the ways to complete cells without a sample."""

LEAST_FIRING = 1e-3
"""Firing below which a sample is not used for a rule."""
_BLOCK = 2**22  # firing strengths held in memory at once
_FAST = 2**16  # firing strengths that fit into the cache
_ROWS = 512  # least samples of a block if memory allows, because sums over blocks cost, too


class Learned(NamedTuple):
    """Rules with consequents: values, intervals or numbers of output terms.

    ``rules`` (R, p) are the numbers of the inputs' terms. ``best_firing`` (R,) is the greatest
    firing of each rule by a sample. The consequents are ``values``, (R, m) or intervals (R, m, 2),
    or the numbers of output ``terms`` (R, m). ``samples`` (R, m) are the numbers of the samples
    that determine the consequents, if each comes from a single sample.
    """

    rules: Integers
    best_firing: Array
    values: Array | None
    terms: Integers | None
    samples: Integers | None

    def point_values(self) -> Array:
        """Return the consequents as numbers, (R, m)."""
        assert self.values is not None
        return self.values

    def consequents(self, quantizer: Quantizer | None) -> Array:
        """Return the consequents as numbers, or as output terms if there is a quantizer."""
        if self.values is not None:
            return self.values
        assert self.terms is not None
        assert quantizer is not None
        return quantizer.intervals(self.terms)


class Quantizer:
    """Output terms: the term that is nearest to a value, and the centroids of the terms."""

    def __init__(
        self, ranges: list[tuple[float, float]], n_terms: int, kind: str, mean_variation: float
    ) -> None:
        self.terms = tuple(
            gaussian_partition(*ends, n_terms, kind, mean_variation) for ends in ranges
        )
        self.principal = [principal_terms(*ends, n_terms) for ends in ranges]
        self.means = np.array([[term.mean for term in row] for row in self.principal])
        self.centroids = np.array([[centroid_of_term(term) for term in row] for row in self.terms])

    def nearest(self, values: Array) -> Integers:
        """Return the numbers (N, m) of the terms nearest to the values (N, m).

        The nearest term is the one with the nearest mean, where the value has its greatest
        membership.
        """
        return np.asarray(
            np.abs(values[..., np.newaxis] - self.means).argmin(axis=-1), dtype=np.int64
        )

    def memberships(self, values: Array, numbers: Integers) -> Array:
        """Return the memberships (N, m) of the values in the principal terms (N, m)."""
        columns = (grades_in(values[:, j], self.principal[j]) for j in range(values.shape[1]))
        return np.stack(
            [
                np.take_along_axis(grades, numbers[:, [j]], axis=1)[:, 0]
                for j, grades in enumerate(columns)
            ],
            axis=1,
        )

    def intervals(self, numbers: Integers) -> Array:
        """Return the centroids (R, m, 2) of terms (R, m)."""
        return np.asarray(self.centroids[np.arange(len(self.terms)), numbers])


def rules_from_all(
    grades: list[Array],
    outputs: Array,
    combine: Callable[..., Array],
    given: Integers | None,
    learner: str,
    ridge: float | None,
    completion: str = "refuse",
    weights: Array | None = None,
) -> Learned:
    """Learn the consequent of every rule, given or on the grid, from all samples.

    Rules that no sample fires are completed. A ``ridge`` of None is chosen by generalized
    cross-validation, separately for every output. ``weights`` (N,) are those of the samples; where
    a single sample determines a rule, they have no effect.
    """
    shape = [of_input.shape[1] for of_input in grades]
    rules = _all_cells(shape) if given is None else given
    share = np.ones(len(outputs)) if weights is None else weights
    best, sample = np.full(len(rules), -1.0), np.zeros(len(rules), dtype=np.int64)
    weight, moment = np.zeros(len(rules)), np.zeros((len(rules), outputs.shape[1]))
    for rows, firing in _firing_blocks(grades, combine, given):
        winner = firing.argmax(axis=0)
        strength = firing[winner, np.arange(len(rules))]
        stronger = strength > best  # not >=, so that the first of equally strong samples is kept
        best, sample = (
            np.where(stronger, strength, best),
            np.where(stronger, winner + rows.start, sample),
        )
        firing = firing * share[rows, np.newaxis]
        weight += firing.sum(axis=0)
        moment += firing.T @ outputs[rows]
    empty = np.flatnonzero(best < LEAST_FIRING)
    if completion == "refuse" or len(empty) == len(rules):
        empty = empty[:0]  # refused later, or there is nothing to complete from
    if completion == "none" and len(empty):
        kept = np.delete(np.arange(len(rules)), empty)
        rules, best, sample = rules[kept], best[kept], sample[kept]
        weight, moment = weight[kept], moment[kept]
        given, empty = rules, empty[:0]
    if learner == "strongest":
        samples = np.repeat(sample[:, np.newaxis], outputs.shape[1], axis=1)
        samples[empty] = -1
        values = _completed(outputs[sample], rules, empty, best, shape, completion)
        return Learned(rules, best, values, None, samples)
    # A rule that no sample fires is refused later; a warning must not come before the error.
    average = moment / np.maximum(weight, np.finfo(float).tiny)[:, np.newaxis]
    average = _completed(average, rules, empty, best, shape, completion)
    if learner == "average":
        return Learned(rules, best, average, None, None)
    if ridge is None:
        design = np.concatenate(
            [
                firing / firing.sum(axis=1, keepdims=True)
                for _, firing in _firing_blocks(grades, combine, given)
            ]
        )
        roots = np.sqrt(share)[:, np.newaxis]
        moved, _ = ridge_by_cross_validation(roots * design, roots * (outputs - design @ average))
        return Learned(rules, best, average + moved, None, None)
    gram, right_side = np.zeros((len(rules), len(rules))), np.zeros_like(moment)
    for rows, firing in _firing_blocks(grades, combine, given):
        shares = firing / firing.sum(axis=1, keepdims=True)
        weighted = shares * share[rows, np.newaxis]
        gram += weighted.T @ shares
        right_side += weighted.T @ (outputs[rows] - shares @ average)
    gram = gram / share.sum() + ridge * np.eye(len(rules))
    return Learned(
        rules, best, average + np.linalg.solve(gram, right_side / share.sum()), None, None
    )


def _completed(
    values: Array,
    rules: Integers,
    empty: Integers,
    best: Array,
    shape: Sequence[int],
    completion: str,
) -> Array:
    """Return consequents (R, m) in which those of the empty rules follow from the others.

    They are copied from the nearest rule, or the one fired most among equally near rules, or
    averaged over all rules with the inverse squares of the distances as weights.
    """
    if not len(empty):
        return values
    others = np.delete(np.arange(len(rules)), empty)
    others = others[np.argsort(-best[others], kind="stable")]
    scale = np.maximum(np.array(shape) - 1.0, 1.0)
    completed = values.copy()
    for r in empty:
        distance = _squared_distances(rules[others], rules[r], scale)
        if completion == "nearest":
            near = distance <= distance.min() * (1.0 + 1e-12)
            completed[r] = values[others[int(near.argmax())]]
        else:
            completed[r] = (1.0 / distance) @ values[others] / (1.0 / distance).sum()
    return completed


def strict_rules(
    grades: list[Array],
    outputs: Array,
    combine: Callable[..., Array],
    quantizer: Quantizer | None,
    completion: str,
) -> Learned:
    """Make a rule of every sample, resolve conflicts by degree, and complete empty cells.

    Empty cells are those without a rule.
    """
    own = np.stack([of_input.argmax(axis=1) for of_input in grades], axis=1)
    antecedent = _reduced(combine, [of_input.max(axis=1) for of_input in grades])
    degree = np.repeat(antecedent[:, np.newaxis], outputs.shape[1], axis=1)
    numbers = None
    if quantizer is not None:
        numbers = quantizer.nearest(outputs)
        degree = combine(degree, quantizer.memberships(outputs, numbers))
    shape = tuple(of_input.shape[1] for of_input in grades)
    covered, cell = _different(own, shape)
    samples = np.empty((len(covered), outputs.shape[1]), dtype=np.int64)
    for j in range(outputs.shape[1]):
        # The sort is stable, so that the first of equal degrees comes first. The assignment runs
        # backward, so that the first in order is written last and stays.
        order = np.argsort(-degree[:, j], kind="stable")[::-1]
        samples[cell[order], j] = order
    columns = np.arange(outputs.shape[1])
    degrees = degree[samples, columns]
    best = np.zeros(len(covered))
    np.maximum.at(best, cell, antecedent)
    if completion == "none":
        values = outputs[samples, columns] if numbers is None else None
        return Learned(
            covered, best, values, None if numbers is None else numbers[samples, columns], samples
        )

    rules = _all_cells(shape)
    position = np.ravel_multi_index(tuple(covered.T), shape)
    has_rule = np.zeros(len(rules), dtype=bool)
    has_rule[position] = True
    empty = np.flatnonzero(~has_rule)
    full_samples = np.full((len(rules), outputs.shape[1]), -1, dtype=np.int64)
    full_samples[position] = samples
    firing = np.zeros(len(rules))
    for _, block in _firing_blocks(grades, combine):
        firing = np.maximum(firing, block.max(axis=0))
    scale = np.maximum(np.array(shape) - 1.0, 1.0)
    if completion == "nearest":
        donors = full_samples.copy()
        for c in empty:
            distance = _squared_distances(covered, rules[c], scale)
            # These are squares of sums of shares, so equal distances may differ by rounding.
            near = distance <= distance.min() * (1.0 + 1e-12)
            donors[c] = samples[
                np.where(near[:, np.newaxis], degrees, -1.0).argmax(axis=0), columns
            ]
        values = outputs[donors, columns] if numbers is None else None
        return Learned(
            rules,
            firing,
            values,
            None if numbers is None else numbers[donors, columns],
            full_samples,
        )
    consequents = (
        outputs[samples, columns]
        if quantizer is None or numbers is None
        else quantizer.intervals(numbers[samples, columns])
    )
    values = np.empty((len(rules), *consequents.shape[1:]))
    values[position] = consequents
    for c in empty:
        share = 1.0 / _squared_distances(covered, rules[c], scale)
        values[c] = np.tensordot(share / share.sum(), consequents, axes=1)
    terms = None
    if numbers is not None:
        terms = np.full((len(rules), outputs.shape[1]), -1, dtype=np.int64)
        terms[position] = numbers[samples, columns]
    return Learned(rules, firing, values, terms, full_samples)


def _different(cells: Integers, shape: tuple[int, ...]) -> tuple[Integers, Integers]:
    """Return the different cells in order, and the place of each cell among them."""
    if math.prod(shape) >= 2**62:
        different, place = np.unique(cells, axis=0, return_inverse=True)
        return different, place.reshape(-1)
    # One number per cell is sorted faster than rows.
    numbers, place = np.unique(np.ravel_multi_index(tuple(cells.T), shape), return_inverse=True)
    return np.stack(np.unravel_index(numbers, shape), axis=1), place


def _squared_distances(cells: Integers, cell: Integers, scale: Array) -> Array:
    return np.asarray((((cells - cell) / scale) ** 2).sum(axis=1))


def check_support(learned: Learned, names: Sequence[str], words: Sequence[Sequence[str]]) -> None:
    """Refuse the samples if none of them fires a rule enough to determine it."""
    weakest = int(np.argmin(learned.best_firing))
    firing = float(learned.best_firing[weakest])
    if firing < LEAST_FIRING:
        clauses = (
            f"{name} is {of_input[k]}"
            for name, of_input, k in zip(names, words, learned.rules[weakest], strict=True)
        )
        raise UnsupportedRule(
            weakest + 1,
            " and ".join(clauses),
            firing,
            LEAST_FIRING,
            int((learned.best_firing < LEAST_FIRING).sum()),
        )


def _all_cells(shape: Sequence[int]) -> Integers:
    """Return the grid's cells (R, p); the last input varies fastest."""
    return np.array(list(itertools.product(*map(range, shape))), dtype=np.int64)


def _firing_blocks(
    grades: list[Array], combine: Callable[..., Array], rules: Integers | None = None
) -> Iterator[tuple[slice, Array]]:
    """Yield blocks of samples with their firing strengths (n, R) of the rules.

    The rules are those of :func:`_all_cells` by default.
    """
    count, size = (
        len(grades[0]),
        math.prod(of_input.shape[1] for of_input in grades) if rules is None else len(rules),
    )
    step = max(1, min(_BLOCK // size, max(_FAST // size, _ROWS)))
    for start in range(0, count, step):
        rows = slice(start, min(start + step, count))
        if rules is not None:
            yield (
                rows,
                _reduced(
                    combine,
                    [
                        of_input[rows][:, asked]
                        for of_input, asked in zip(grades, rules.T, strict=True)
                    ],
                ),
            )
            continue
        firing = grades[0][rows]
        for of_input in grades[1:]:
            firing = combine(firing[:, :, np.newaxis], of_input[rows, np.newaxis, :]).reshape(
                len(firing), -1
            )
        yield rows, firing


def _reduced(combine: Callable[..., Array], arrays: list[Array]) -> Array:
    result = arrays[0]
    for array in arrays[1:]:
        result = combine(result, array)
    return result
