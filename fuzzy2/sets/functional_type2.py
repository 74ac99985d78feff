"""General type-2 sets given by a function."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from fuzzy2.errors import InvalidValue
from fuzzy2.sets.derived import Truncated
from fuzzy2.sets.general_type2 import GeneralType2Set
from fuzzy2.sets.type1 import Singleton, Type1Set, set_fields
from fuzzy2.support.checks import Array, ascending, function, listed, maybe_infinite, real
from fuzzy2.support.quadrature import merged


@dataclass(frozen=True)
class FunctionalType2Set(GeneralType2Set):
    """General type-2 set given by an arbitrary function from points to vertical slices.

    Parameters
    ----------
    function : callable
        Maps a point to its vertical slice, a :class:`Type1Set`. The part of the slice outside [0,
        1] is cut off.
    left, right : float
        Ends of the domain; they may be infinite.
    knots : sequence of float
        Points where the shape changes. For an unbounded domain they also mark the range that
        matters.

    Raises
    ------
    InvalidValue
        If the ends are not in order, or if too few finite points locate the set.
    """

    function: Callable[[float], Type1Set]
    left: float
    right: float
    knots: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        function("function", self.function)
        left, right = maybe_infinite("left", self.left), maybe_infinite("right", self.right)
        ascending("left, right", (left, right))
        set_fields(
            self,
            left=left,
            right=right,
            knots=tuple(
                real("knots", knot) for knot in listed("knots", self.knots, "a list of numbers")
            ),
        )
        if self.landmarks.size < 2 and left != right:
            raise InvalidValue(
                "knots",
                self.knots,
                "at least two points when the domain is unbounded, to say where the set is",
            )

    @property
    def support(self) -> tuple[float, float]:
        """Ends of the domain."""
        return self.left, self.right

    @property
    def landmarks(self) -> Array:
        """Finite ends of the domain, and the knots within it."""
        ends = [end for end in (self.left, self.right) if math.isfinite(end)]
        return merged(ends, [knot for knot in self.knots if self.left <= knot <= self.right])

    def secondary(self, x: float) -> Type1Set:
        """Return the vertical slice at a point (eq. 1.3); outside the domain it is crisply 0."""
        point = real("x", x)
        if not self.left <= point <= self.right:
            return Singleton(0.0)
        whole = self.function(point)
        first, last = whole.support
        return whole if first >= 0.0 and last <= 1.0 else Truncated(whole, 0.0, 1.0)
