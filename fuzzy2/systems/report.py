"""Findings of ``validate`` about a system."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fuzzy2.support.checks import Array
from fuzzy2.systems.antecedents import Antecedent, leaves


@dataclass(frozen=True)
class Report:
    """Findings of :meth:`FuzzySystem.validate`; ``ok`` is true if there are none.

    Parameters
    ----------
    uncovered : (k, p) ndarray
        Points of a grid over the inputs' domains, and points between them, where no rule fires
        above the threshold.
    coverage : float
        Covered share of the domain, estimated from the points between those of the grid.
    unused_terms : list of (input, term)
        Terms that no rule uses.
    duplicate_rules : list of (rule, rule)
        Rules with the same antecedents and the same consequents.
    conflicting_rules : list of (rule, rule)
        Rules with the same antecedents and different consequents.
    """

    uncovered: Array
    coverage: float
    unused_terms: list[tuple[str, str]]
    duplicate_rules: list[tuple[int, int]]
    conflicting_rules: list[tuple[int, int]]

    @property
    def ok(self) -> bool:
        """Whether there are no findings."""
        return not (
            len(self.uncovered)
            or self.unused_terms
            or self.duplicate_rules
            or self.conflicting_rules
        )

    def __str__(self) -> str:
        if self.ok:
            return (
                "every region is covered, every term is used, no rules repeat or contradict each "
                "other"
            )
        lines = []
        if len(self.uncovered) and self.coverage == 1.0:
            first = ", ".join(f"{value:.4g}" for value in self.uncovered[0])
            more = len(self.uncovered) - 1
            also = f" and {more} other single point{'s' if more > 1 else ''}" if more else ""
            lines.append(f"no rule fires at the point ({first}){also}")
        elif len(self.uncovered):
            low, high = self.uncovered.min(axis=0), self.uncovered.max(axis=0)
            box = " x ".join(f"[{a:.4g}, {b:.4g}]" for a, b in zip(low, high, strict=True))
            lines.append(
                f"no rule fires on {100.0 * (1.0 - self.coverage):.1f} % of the input space, all "
                f"of it within {box}"
            )
        lines += [f"no rule asks whether {name} is {term}" for name, term in self.unused_terms]
        lines += [f"rules {a + 1} and {b + 1} are the same" for a, b in self.duplicate_rules]
        lines += [
            f"rules {a + 1} and {b + 1} have the same antecedent and different consequents"
            for a, b in self.conflicting_rules
        ]
        return "; ".join(lines)


def grid_over(ranges: Array, points: int) -> Array:
    """Return a grid over ranges (p, 2), as rows (n, p).

    If the grid has more than 100 000 points, a seeded sample of that size is drawn with
    replacement.
    """
    axes = [np.linspace(low, high, points) for low, high in ranges]
    if points ** len(axes) <= 100_000:
        return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(axes))
    rng = np.random.default_rng(0)
    return np.stack([rng.choice(axis, 100_000) for axis in axes], axis=-1)


def repeated_rules(
    rules: Sequence[Hashable], agree: Callable[[int, int], bool | None]
) -> tuple[list[tuple[int, int]], list[tuple[int, int]]]:
    """Return pairs of rules with the same antecedent: those that agree, and those that conflict.

    Pairs for which ``agree`` returns None are in neither list, because their outputs differ.
    """
    duplicates: list[tuple[int, int]] = []
    conflicts: list[tuple[int, int]] = []
    first: dict[Hashable, int] = {}
    for r, rule in enumerate(rules):
        if rule not in first:
            first[rule] = r
            continue
        same = agree(first[rule], r)
        if same is not None:
            (duplicates if same else conflicts).append((first[rule], r))
    return duplicates, conflicts


def found_in(
    covers: Callable[[Array], NDArray[np.bool_]],
    ranges: Array,
    points: int,
    trees: Sequence[Antecedent],
    names: tuple[Sequence[str], Sequence[Sequence[str]]],
    agree: Callable[[int, int], bool | None],
) -> Report:
    """Return the findings about a system.

    Parameters
    ----------
    covers : callable
        Tells for inputs (n, p) whether some rule fires.
    ranges : (p, 2) array
        Ranges of the inputs to check.
    points : int
        Grid points per input.
    trees : sequence of R antecedents
        Antecedents of the rules, by numbers.
    names : pair
        Names of the inputs, and of the terms of each.
    agree : callable
        See :func:`repeated_rules`.
    """
    grid = grid_over(ranges, points)
    # Points between those of the grid are checked as well: where terms touch at their feet, no rule
    # fires, but only at that point.
    step = (ranges[:, 1] - ranges[:, 0]) / (2 * (points - 1))
    between = grid_over(np.stack([ranges[:, 0] + step, ranges[:, 1] - step], axis=1), points - 1)
    covered, also = (
        np.concatenate(
            [covers(where[start : start + 4096]) for start in range(0, len(where), 4096)]
        )
        for where in (grid, between)
    )
    uncovered = grid[~covered]
    if not also.all():
        uncovered = np.concatenate([uncovered, between[~also]])
    asked = {(leaf.variable, leaf.term) for tree in trees for leaf in leaves(tree)}
    unused = [
        (name, term)
        for i, (name, terms) in enumerate(zip(*names, strict=True))
        for t, term in enumerate(terms)
        if (i, t) not in asked
    ]
    duplicates, conflicts = repeated_rules(trees, agree)
    return Report(uncovered, float(also.mean()), unused, duplicates, conflicts)
