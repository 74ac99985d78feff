"""Sets whose membership is a formula, as fuzzylite allows."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fuzzy2.errors import InvalidValue
from fuzzy2.sets.curves import refined
from fuzzy2.sets.derived import FunctionalSet
from fuzzy2.sets.type1 import Type1Set, set_fields
from fuzzy2.support.checks import Array, ascending, real
from fuzzy2.support.formula import Formula


@dataclass(frozen=True)
class FormulaSet(Type1Set):
    r"""Set whose membership is a formula of x, limited to [0, 1].

    .. math:: \mu(x) = \min(1, \max(0, f(x)))

    Parameters
    ----------
    formula : str
        The formula :math:`f` of ``x``; see :mod:`fuzzy2.support.formula`.
    left, right : float
        Ends of the range that matters. The membership continues beyond them, but height, maxima and
        cuts are sampled in this range. Samples are dense near the numbers that occur in the
        formula, because jumps and kinks usually lie there.

    Raises
    ------
    InvalidValue
        If the text is not a formula, uses names other than x, or gives NaN somewhere in the range.
    """

    formula: str
    left: float
    right: float

    def __post_init__(self) -> None:
        ends = real("left", self.left), real("right", self.right)
        ascending("left, right", ends)
        if ends[0] == ends[1]:
            raise InvalidValue("left, right", ends, "two different numbers")
        parsed = Formula(self.formula)
        set_fields(self, formula=parsed.text, left=ends[0], right=ends[1])
        if parsed.names - {"x"}:
            raise InvalidValue("the names in a formula", sorted(parsed.names), "x alone")
        if not np.isfinite(self._raw()).all():
            raise InvalidValue("the formula", parsed.text, f"a number everywhere on {ends}")

    @cached_property
    def _parsed(self) -> Formula:
        return Formula(self.formula)

    def _raw(self) -> Array:
        """Return the values of the formula at many points of the range."""
        return self._parsed(np.clip(refined(np.array(self._knots)), self.left, self.right))

    @property
    def _knots(self) -> tuple[float, ...]:
        inner = [point for point in self._parsed.numbers if self.left < point < self.right]
        return tuple(sorted({*inner, *np.linspace(self.left, self.right, 33).tolist()}))

    @property
    def is_cut(self) -> bool:
        """Whether the sampled formula leaves [0, 1] within the range."""
        grades = self._raw()
        return bool(((grades < 0.0) | (grades > 1.0)).any())

    def _clipped(self, x: Array) -> Array:
        return np.clip(self._parsed(x), 0.0, 1.0)

    @cached_property
    def _whole(self) -> FunctionalSet:
        return FunctionalSet(self._clipped, -np.inf, np.inf, self._knots)

    @property
    def height(self) -> float:
        """Supremum of the sampled membership."""
        return self._whole.height

    def _grades(self, x: Array) -> Array:
        return self._whole._grades(x)

    def _support(self) -> tuple[float, float]:
        return self._whole._support()

    def _maxima(self) -> tuple[float, float]:
        return self._whole._maxima()

    def _landmarks(self) -> Array:
        return self._whole._landmarks()

    def _cut(self, alpha: Array) -> tuple[Array, Array]:
        return self._whole._cut(alpha)

    def is_convex(self) -> bool:
        """Return whether the sampled membership rises to its maximum and then falls."""
        return self._whole.is_convex()
