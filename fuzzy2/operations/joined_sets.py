"""Joins of type-1 sets and meets by the minimum, as sets that are evaluated on demand."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from fuzzy2.operations.t_norms import T_NORMS, TNorm
from fuzzy2.sets.type1 import Type1Set
from fuzzy2.support.checks import Array
from fuzzy2.support.quadrature import merged

ROUNDING = 1e-12
HALVINGS = 60
"""Steps of a bisection from an interval of length 1 to full precision."""


def best_of_pairs(own: Sequence[Array], reached: Sequence[Array], grade_norm: TNorm) -> Array:
    """Return the maximum, over i, of the grade of set i combined with the suprema of all others."""
    n = len(own)
    if n == 1:
        return own[0]
    # Combine the suprema of the sets before i and after i, which takes n combinations instead of
    # n². The order of the factors is kept, so that the results commute.
    before = [reached[0]]
    after = [reached[-1]]
    for k in range(1, n - 1):
        before.append(grade_norm(before[-1], reached[k]))
        after.append(grade_norm(reached[n - 1 - k], after[-1]))
    after.reverse()
    best = np.maximum(grade_norm(own[0], after[0]), grade_norm(before[-1], own[-1]))
    for i in range(1, n - 1):
        best = np.maximum(best, grade_norm(grade_norm(before[i - 1], own[i]), after[i]))
    return np.asarray(best)


def brief(operand: Type1Set) -> str:
    """Return the representation of a set, shortened to one line."""
    shown = repr(operand)
    return shown if len(shown) <= 120 else f"{shown[:117]}..."


def extremum_of_grades(
    kind: str, theta: Array, peaks: Array, grades: Array, grade_norm: TNorm
) -> Array:
    """Return eq. 1.14 and 1.28 for a join, or eq. 1.15 for a meet, at theta (...,).

    ``grades`` (n, ...) are those of the sets at theta, and ``peaks`` (n,) their points of grade 1.
    """
    order = np.argsort(peaks, kind="stable")
    if kind == "meet":  # the meet is the join of the mirrored sets
        order, theta, peaks = order[::-1], -theta, -peaks
    result = np.full(theta.shape, np.nan)
    sorted_peaks = peaks[order]
    tail = grades[order[-1]]
    # From the last set to the first: between v_k and v_(k+1) only the sets after k contribute.
    for k in range(len(order) - 1, 0, -1):
        result = np.where((sorted_peaks[k - 1] <= theta) & (theta < sorted_peaks[k]), tail, result)
        tail = grade_norm(grades[order[k - 1]], tail)
    result = np.where(theta < sorted_peaks[0], tail, result)
    return np.where(theta >= sorted_peaks[-1], grades.max(axis=0), result)


def peaks_of(kind: str, sets: Sequence[Type1Set]) -> Array:
    """Return one point of membership 1 of each set: the first for a join, the last for a meet."""
    return np.array(
        [(operand.core or (np.nan, np.nan))[0 if kind == "join" else 1] for operand in sets]
    )


# --- functions ------------------------------------------------------------------------------------


def supremum(operand: Type1Set, left: Array, right: Array) -> Array:
    """Return the supremum (...,) of the membership over closed intervals.

    Ends may be infinite. The supremum over an empty interval is 0.
    """
    if operand.is_convex():
        maxima = operand.maxima
        if maxima is None:  # a sigmoid: the end toward its supremum is the better one
            far_left, far_right = (
                np.where(np.isneginf(left), -1e300, left),
                np.where(np.isposinf(right), 1e300, right),
            )
            best = np.maximum(operand(far_left), operand(far_right))
        else:
            first, last = maxima
            # Take the point of the interval that is nearest to the maxima. On the maxima themselves
            # return the height, which rounding could miss.
            nearest = np.where(right < first, right, np.where(left > last, left, first))
            best = np.where((left <= last) & (right >= first), operand.height, operand(nearest))
        return np.where(left <= right, best, np.where(np.isnan(left + right), np.nan, 0.0))
    points = operand.landmarks
    grades = operand(points)
    ends = np.maximum(operand(np.maximum(left, points[0])), operand(np.minimum(right, points[-1])))
    ends = np.where((right >= points[0]) & (left <= points[-1]), ends, 0.0)
    inside = _range_maxima(
        grades,
        np.searchsorted(points, left, side="left"),
        np.searchsorted(points, right, side="right"),
    )
    return np.where(
        left <= right, np.maximum(ends, inside), np.where(np.isnan(left + right), np.nan, 0.0)
    )


def _range_maxima(grades: Array, first: NDArray[np.intp], last: NDArray[np.intp]) -> Array:
    """Return the maxima of grades[first:last] for arrays of ends; 0 where a range is empty.

    It uses a table of maxima over ranges whose lengths are powers of two.
    """
    table = [grades]
    while 2 ** len(table) <= grades.size:
        half = 2 ** (len(table) - 1)
        table.append(np.maximum(table[-1][:-half], table[-1][half:]))
    length = np.maximum(last - first, 1)
    power = np.floor(np.log2(length)).astype(np.int64)
    result = np.zeros(np.shape(first))
    for exponent, maxima in enumerate(table):
        here = (power == exponent) & (last > first)
        if here.any():
            low, high = first[here], last[here] - 2**exponent
            result[here] = np.maximum(maxima[low], maxima[high])
    return result


@dataclass(frozen=True)
class ExtremumSet(Type1Set):
    r"""Join by the maximum, or meet by the minimum, of secondary memberships.

    At least one operand is a function.

    The membership is exact under any t-norm of the grades. It follows eq. 1.14, 1.15 and 1.28 for
    normal convex sets, and otherwise

    .. math:: \mu(\theta) = \max_i \Big( f_i(\theta) * \mathop{*}_{j \ne i}
              \sup_{w \le \theta} f_j(w) \Big)

    for a join (1.17), with :math:`w \ge \theta` for a meet. `join` and `meet` make such sets.

    Parameters
    ----------
    kind : {"join", "meet"}
        Which of the two.
    operands : tuple of Type1Set
        The sets.
    grade_t_norm : TNorm
        How the grades are combined.
    by_theorem : bool
        Whether Theorem 1.1 is used. Its conditions have been checked before.
    """

    kind: Literal["join", "meet"]
    operands: tuple[Type1Set, ...]
    grade_t_norm: TNorm
    by_theorem: bool

    def __repr__(self) -> str:
        shown = ", ".join(map(repr, self.operands))
        method = "" if self.by_theorem else ', method="general"'
        return f'{self.kind}({shown}, grade_t_norm="{self.grade_t_norm.name}"{method})'

    @property
    def height(self) -> float:
        """Supremum of the membership: the heights of all sets, combined by the grades' t-norm."""
        return float(self.grade_t_norm(*(operand.height for operand in self.operands)))

    @property
    def _outer(self) -> Callable[..., Array]:
        return np.maximum if self.kind == "join" else np.minimum

    def _grades(self, x: Array) -> Array:
        own = [np.asarray(operand(x)) for operand in self.operands]
        if self.by_theorem:
            grades = extremum_of_grades(
                self.kind, x, peaks_of(self.kind, self.operands), np.stack(own), self.grade_t_norm
            )
        else:
            left, right = (
                (np.full(x.shape, -np.inf), x)
                if self.kind == "join"
                else (x, np.full(x.shape, np.inf))
            )
            grades = best_of_pairs(
                own,
                [supremum(operand, left, right) for operand in self.operands],
                self.grade_t_norm,
            )
        return np.where(np.isnan(x), np.nan, grades)

    def _support(self) -> tuple[float, float]:
        ends = np.array([operand.support for operand in self.operands])
        left, right = self._outer.reduce(ends, axis=0)  # type: ignore[attr-defined] # a ufunc
        return float(left), float(right)

    def _maxima(self) -> tuple[float, float] | None:
        ends = []
        for operand in self.operands:
            maxima = operand.maxima
            if maxima is None:  # a sigmoid is highest at infinity
                end = math.inf if operand(1e300) > operand(-1e300) else -math.inf
                maxima = end, end
            elif (
                self.grade_t_norm is T_NORMS["min"]
                and operand.height > self.height
                and operand.is_convex()
            ):
                # The minimum of the heights is attained wherever this set is at least as high as
                # the lowest set.
                cut = operand.alpha_cut(self.height)
                maxima = float(cut[0]), float(cut[1])
            ends.append(maxima)
        left, right = (
            float(end)
            for end in self._outer.reduce(np.array(ends), axis=0)  # type: ignore[attr-defined]
        )
        return (left, right) if math.isfinite(left) and math.isfinite(right) else None

    def _landmarks(self) -> Array:
        return merged(*(operand.landmarks for operand in self.operands))

    def _cut(self, alpha: Array) -> tuple[Array, Array]:
        if self.grade_t_norm is not T_NORMS["min"]:
            return cut_by_bisection(self, alpha)
        # A sigmoid never reaches its height, so its cut at that grade is at infinity.
        cuts = [operand._cut(np.minimum(alpha, operand.height)) for operand in self.operands]
        left, right = (
            self._outer.reduce(np.array(ends), axis=0)  # type: ignore[attr-defined]
            for ends in zip(*cuts, strict=True)
        )
        return left, right

    def _quadrature_points(self, power: int) -> Array:
        if all(math.isfinite(end) for end in self._support()):
            return super()._quadrature_points(power)
        return merged(*(operand.quadrature_points(power) for operand in self.operands))

    def is_convex(self) -> bool:
        """Return whether the membership rises to its maximum and then falls.

        It does if the membership of every operand does.
        """
        return all(operand.is_convex() for operand in self.operands)


@dataclass(frozen=True)
class NegatedSet(Type1Set):
    """Negation of a secondary membership: the set mirrored at 1/2. `negation` makes it.

    Parameters
    ----------
    original : Type1Set
        The set that is negated.
    """

    original: Type1Set

    @property
    def height(self) -> float:
        """Supremum of the membership."""
        return self.original.height

    def _grades(self, x: Array) -> Array:
        return np.asarray(self.original(1.0 - x))

    def _support(self) -> tuple[float, float]:
        left, right = self.original.support
        return 1.0 - right, 1.0 - left

    def _maxima(self) -> tuple[float, float] | None:
        maxima = self.original.maxima
        return None if maxima is None else (1.0 - maxima[1], 1.0 - maxima[0])

    def _landmarks(self) -> Array:
        return 1.0 - self.original.landmarks[::-1]

    def _cut(self, alpha: Array) -> tuple[Array, Array]:
        left, right = self.original._cut(alpha)
        return 1.0 - right, 1.0 - left

    def _quadrature_points(self, power: int) -> Array:
        return 1.0 - self.original.quadrature_points(power)[::-1]

    def is_convex(self) -> bool:
        """Return whether the original set is convex."""
        return self.original.is_convex()


def cut_by_bisection(convex_set: Type1Set, alpha: Array) -> tuple[Array, Array]:
    """Return the ends of the α-cuts of a convex set, from its membership alone.

    The outermost points are found by bisection between the support and the maxima.
    """
    maxima, points = convex_set.maxima, convex_set.landmarks
    first, last = (float(points[0]), float(points[-1])) if maxima is None else maxima
    ends = []
    for inner, outer, side in (
        (first, convex_set.support[0], -1.0),
        (last, convex_set.support[1], 1.0),
    ):
        inside = np.full(alpha.shape, inner)
        if math.isfinite(outer):
            outside = np.full(alpha.shape, outer)
        else:
            reach = max(float(np.ptp(points)), 1e-6)
            outside = inside + side * reach
            for _ in range(1000):
                low = convex_set(outside) >= alpha
                if not low.any() or reach > 1e290:
                    break
                reach *= 2.0
                outside = np.where(low, inner + side * reach, outside)
        found = convex_set(outside) >= alpha
        for _ in range(2 * HALVINGS):
            middle = 0.5 * (inside + outside)
            reached = convex_set(middle) >= alpha
            inside, outside = np.where(reached, middle, inside), np.where(reached, outside, middle)
        ends.append(np.where(found, outer, inside))
    return ends[0], ends[1]
