"""What ``validate`` found out about a system."""

from __future__ import annotations

from dataclasses import dataclass

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
