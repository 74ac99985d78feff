"""What ``validate`` found out about a system."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fuzzy2.support.checks import Array
from fuzzy2.systems.antecedents import Antecedent, leaves


@dataclass(frozen=True)
class Report:
    """What :meth:`FuzzySystem.validate` found; ``ok`` if nothing.

    Parameters
    ----------
    uncovered : (k, p) ndarray
        Points of a grid over the inputs' domains, and between them, where no rule fires by more
        than the threshold.
    coverage : float
        Share of the domain that is covered, by the points between those of the grid.
    unused_terms : list of (input, term)
        Terms that no rule asks for.
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
        """Whether nothing was found."""
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
            f"rules {a + 1} and {b + 1} ask for the same and say different things"
            for a, b in self.conflicting_rules
        ]
        return "; ".join(lines)


def grid_over(ranges: Array, points: int) -> Array:
    """Return a grid over ranges (p, 2), as rows (n, p).

    Of more than 100 000 points a seeded sample of so many, drawn with repetition.
    """
    axes = [np.linspace(low, high, points) for low, high in ranges]
    if points ** len(axes) <= 100_000:
        return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(axes))
    rng = np.random.default_rng(0)
    return np.stack([rng.choice(axis, 100_000) for axis in axes], axis=-1)


def repeated_rules(
    rules: Sequence[Hashable], agree: Callable[[int, int], bool | None]
) -> tuple[list[tuple[int, int]], list[tuple[int, int]]]:
    """Return pairs of rules that ask for the same: those that agree, and those that do not.

    Rules that ``agree`` says None of are neither: they speak of different outputs.
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
    """Return what is found out about a system.

    Parameters
    ----------
    covers : callable
        From inputs (n, p) to whether some rule fires.
    ranges : (p, 2) array
        Where to look.
    points : int
        Grid points per input.
    trees : sequence of R antecedents
        What the rules ask for, by number.
    names : pair
        Names of the inputs, and of the terms of each.
    agree : callable
        See :func:`repeated_rules`.
    """
    grid = grid_over(ranges, points)
    # Between its points, too: where terms touch at their feet no rule fires, but only there.
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
