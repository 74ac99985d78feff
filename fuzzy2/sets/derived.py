"""Type-1 sets made from functions and from other sets."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fuzzy2.errors import InvalidValue
from fuzzy2.sets.curves import refined
from fuzzy2.sets.type1 import ROUNDING, SampledSet, Type1Set, keep_nan, set_fields
from fuzzy2.support.checks import Array, ascending, function, listed, maybe_infinite, real
from fuzzy2.support.quadrature import merged


@dataclass(frozen=True)
class FunctionalSet(Type1Set):
    """Set given by an arbitrary function of the points.

    Height, maxima, cuts and convexity are found by sampling the function at the landmarks and at 64
    points between each two of them. They are as accurate as that grid.

    Parameters
    ----------
    function : callable
        Maps points (...,) to grades (...,) in [0, 1].
    left, right : float
        Ends of the support. The membership is 0 outside, whatever the function returns there. If an
        end is infinite, the set has no centroid.
    knots : sequence of float
        Points where the function has kinks or narrow peaks. For an unbounded support they also mark
        the range that matters.
    slope : callable, optional
        Derivative of the function, which maps points (...,) to derivatives (...,); at a kink, the
        derivative from the right. Without it the set has no derivative.

    Raises
    ------
    InvalidValue
        If the ends are not in order, or neither an end nor a knot is finite enough to locate the
        set.
    """

    function: Callable[[Array], Array]
    left: float
    right: float
    knots: tuple[float, ...] = ()
    slope: Callable[[Array], Array] | None = None

    def __post_init__(self) -> None:
        function("function", self.function)
        if self.slope is not None:
            function("slope", self.slope)
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
        if self._landmarks().size < 2 and left != right:
            raise InvalidValue(
                "knots",
                self.knots,
                "at least two points when the support is unbounded, to say where the set is",
            )

    @property
    def height(self) -> float:
        """Supremum of the sampled membership."""
        return self._sampled.height

    @cached_property
    def _sampled(self) -> SampledSet:
        return sampled_closely(self)

    def _grades(self, x: Array) -> Array:
        grades = np.asarray(self.function(x), dtype=float)
        return keep_nan(x, np.where((x >= self.left) & (x <= self.right), grades, 0.0))

    def _slopes(self, x: Array) -> Array:
        if self.slope is None:
            return super()._slopes(x)
        return np.where((x >= self.left) & (x < self.right), self.slope(x), 0.0)

    def _support(self) -> tuple[float, float]:
        return self.left, self.right

    def _maxima(self) -> tuple[float, float]:
        return self._sampled._maxima()

    def _landmarks(self) -> Array:
        ends = [end for end in (self.left, self.right) if math.isfinite(end)]
        return merged(ends, [knot for knot in self.knots if self.left <= knot <= self.right])

    def _cut(self, alpha: Array) -> tuple[Array, Array]:
        points, grades = self._sampled.points, self._sampled.grades
        return self._reach(alpha, points, grades), self._reach(alpha, points[::-1], grades[::-1])

    def _reach(self, alpha: Array, points: Array, grades: Array) -> Array:
        """Return where the membership first reaches alpha (...,) along the samples.

        The point is found by bisection between two samples.
        """
        after = np.minimum(
            np.searchsorted(np.maximum.accumulate(grades), alpha, side="left"), len(points) - 1
        )
        below, reached = points[np.maximum(after - 1, 0)], points[after]
        for _ in range(60):
            middle = 0.5 * (below + reached)
            enough = self._grades(middle) >= alpha
            below, reached = np.where(enough, below, middle), np.where(enough, middle, reached)
        return np.asarray(reached)

    def is_convex(self) -> bool:
        """Return whether the sampled membership rises to its maximum and then falls."""
        return self._sampled.is_convex()


@dataclass(frozen=True)
class Truncated(Type1Set):
    """Set cut off outside an interval, where its membership is 0.

    Parameters
    ----------
    whole : Type1Set
        The set before it is cut.
    left, right : float
        Ends of the interval, which must meet the support of the set.

    Raises
    ------
    InvalidValue
        If the ends are not finite and in order, or the interval does not meet the set.
    """

    whole: Type1Set
    left: float
    right: float

    def __post_init__(self) -> None:
        ends = real("left", self.left), real("right", self.right)
        ascending("left, right", ends)
        set_fields(self, left=ends[0], right=ends[1])
        first, last = self.whole.support
        if first > self.right or last < self.left:
            raise InvalidValue(
                "left, right", ends, f"ends of an interval that meets the support {(first, last)}"
            )

    @property
    def height(self) -> float:
        """Supremum of the membership within the interval."""
        return float(self._highest[0])

    @cached_property
    def _highest(self) -> tuple[float, float, float]:
        """Height of the set, and the first and the last point that reach it."""
        first, last = self._support()
        if not self.whole.is_convex():
            sampled = self._sampled
            return sampled.height, *sampled._maxima()
        maxima = self.whole.maxima
        # A convex set that is cut off beside its maximum is highest at the cut. One that never
        # reaches its maximum is highest at the higher end.
        points = np.array([first, last] if maxima is None else np.clip(maxima, first, last))
        highest = float(self.whole(points).max())
        left, right = self.whole.alpha_cut(highest)
        return highest, *np.clip((left, right), first, last).tolist()

    @cached_property
    def _sampled(self) -> SampledSet:
        return sampled_closely(self)

    def _grades(self, x: Array) -> Array:
        return keep_nan(x, np.where((x >= self.left) & (x <= self.right), self.whole(x), 0.0))

    def _slopes(self, x: Array) -> Array:
        return np.where((x >= self.left) & (x < self.right), self.whole.derivative(x), 0.0)

    def _support(self) -> tuple[float, float]:
        first, last = self.whole.support
        return max(first, self.left), min(last, self.right)

    def _maxima(self) -> tuple[float, float]:
        return self._highest[1:]

    def _landmarks(self) -> Array:
        points = self.whole.landmarks
        first, last = self._support()
        return merged(points[(points > first) & (points < last)], (first, last))

    def _cut(self, alpha: Array) -> tuple[Array, Array]:
        left, right = (self.whole if self.whole.is_convex() else self._sampled).alpha_cut(alpha)
        return np.clip(left, self.left, self.right), np.clip(right, self.left, self.right)

    def is_convex(self) -> bool:
        """Return whether the whole set is convex, or at least its part within the interval."""
        return self.whole.is_convex() or self._sampled.is_convex()


def sampled_closely(fuzzy_set: Type1Set) -> SampledSet:
    """Return a set sampled between its landmarks, more densely toward its maximum.

    Cuts and normality depend on the samples near the maximum.
    """
    points = np.clip(refined(fuzzy_set.landmarks), *fuzzy_set.support)
    for _ in range(6):  # 2^-30 of a step is enough because the membership is flat there
        points = merged(points)
        best = int(np.argmax(fuzzy_set(points)))
        points = np.concatenate(
            [
                points,
                np.linspace(points[max(best - 1, 0)], points[min(best + 1, len(points) - 1)], 65),
            ]
        )
    return fuzzy_set.sample(points)


@dataclass(frozen=True)
class Complement(Type1Set):
    r"""Complement of a set (eq. 1.11), for *is not* in a rule.

    .. math:: \mu(x) = 1 - \mu_A(x)

    Parameters
    ----------
    whole : Type1Set
        The set :math:`A`.

    Raises
    ------
    InvalidValue
        If it is not a type-1 set.
    """

    whole: Type1Set

    def __post_init__(self) -> None:
        if not isinstance(self.whole, Type1Set):
            raise InvalidValue("whole", self.whole, "a type-1 set")

    def _grades(self, x: Array) -> Array:
        return np.asarray(1.0 - self.whole(x))

    def _slopes(self, x: Array) -> Array:
        return np.asarray(-self.whole.derivative(x))

    @cached_property
    def _least(self) -> tuple[float, float, float]:
        """Smallest sampled membership of the set, and the first and the last point that have it."""
        points = np.concatenate([[-math.inf], refined(self.whole.landmarks), [math.inf]])
        grades = self.whole(points)
        least = points[grades <= grades.min() + ROUNDING]
        return float(grades.min()), float(least[0]), float(least[-1])

    @property
    def height(self) -> float:
        """Supremum of the membership."""
        return 1.0 if any(map(math.isfinite, self.whole.support)) else 1.0 - self._least[0]

    def _support(self) -> tuple[float, float]:
        first, last = self.whole.core or (math.inf, -math.inf)
        left = last if first == -math.inf else -math.inf
        right = first if last == math.inf else math.inf
        # The complement of the whole line is empty, and an empty set has no ends.
        return (left, right) if left <= right else (-math.inf, math.inf)

    def _maxima(self) -> tuple[float, float] | None:
        first, last = self.whole.support
        if math.isfinite(first) or math.isfinite(last):
            return -math.inf if math.isfinite(first) else last, math.inf if math.isfinite(
                last
            ) else first
        _, first, last = self._least
        # A set with tails reaches its infimum only at infinity.
        return None if math.isinf(first) or math.isinf(last) else (first, last)

    def _landmarks(self) -> Array:
        points, (first, last) = self.whole.landmarks, self.whole.support
        width = float(points[-1] - points[0]) or 1.0
        # If the set ends with a jump, the complement begins just beyond it.
        jumps = [
            end + side * width
            for end, side in ((first, -1.0), (last, 1.0))
            if math.isfinite(end) and self.whole(end) > 0.0
        ]
        points = merged(points, jumps)
        return points if points.size > 1 else merged(points, points - 1.0, points + 1.0)

    @cached_property
    def _searched(self) -> FunctionalSet:
        return FunctionalSet(self._grades, *self._support(), tuple(self._landmarks().tolist()))

    @property
    def _falls(self) -> float:
        """Infinity toward which a convex set keeps rising, so that its complement falls.

        It is 0 if there is none.
        """
        ends = self.whole(np.array([-math.inf, math.inf]))
        return (
            0.0
            if ends.max() < self.whole.height - ROUNDING
            else -math.inf
            if ends[0] > ends[1]
            else math.inf
        )

    def _cut(self, alpha: Array) -> tuple[Array, Array]:
        falls = self._falls if self.whole.is_convex() else 0.0
        if not falls:
            return self._searched._cut(alpha)
        beyond = 1.0 - alpha
        reached = self.whole._cut(np.clip(beyond, 0.0, self.whole.height))[0 if falls > 0.0 else 1]
        edge = np.where(beyond > 0.0, reached, self.whole.support[0 if falls > 0.0 else 1])
        edge = np.where(beyond > self.whole.height, falls, edge)
        end = np.full_like(edge, -falls)
        return (end, edge) if falls > 0.0 else (edge, end)

    def is_convex(self) -> bool:
        """Return whether the membership rises to its maximum and then falls.

        That holds if the set is a shoulder, or if its samples form a valley.
        """
        return (self.whole.is_convex() and self._falls != 0.0) or self._searched.is_convex()
