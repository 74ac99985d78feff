"""What ``validate`` found out about a system."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fuzzy2.support.checks import Array


@dataclass(frozen=True)
class Report:
    """What :meth:`FuzzySystem.validate` found; ``ok`` if nothing.

    Parameters
    ----------
    uncovered : (k, p) ndarray
        Points of a grid over the inputs' domains where no rule fires by more than the threshold.
    coverage : float
        Share of the grid that is covered.
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
        if len(self.uncovered):
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
    rules: NDArray[np.int64], agree: Callable[[int, int], bool]
) -> tuple[list[tuple[int, int]], list[tuple[int, int]]]:
    """Return pairs of rules that ask for the same: those that agree, and those that do not."""
    duplicates, conflicts = [], []
    first: dict[tuple[int, ...], int] = {}
    for r, rule in enumerate(map(tuple, rules.tolist())):
        if rule not in first:
            first[rule] = r
        elif agree(first[rule], r):
            duplicates.append((first[rule], r))
        else:
            conflicts.append((first[rule], r))
    return duplicates, conflicts
