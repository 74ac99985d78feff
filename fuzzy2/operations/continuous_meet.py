"""Meets of type-1 sets under a t-norm other than the minimum."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fuzzy2.operations.joined_sets import HALVINGS, ROUNDING, cut_by_bisection, supremum
from fuzzy2.operations.t_norms import T_NORMS, TNorm
from fuzzy2.sets.type1 import SampledSet, Type1Set
from fuzzy2.support.checks import Array
from fuzzy2.support.quadrature import Moments, merged

# Intervals of memberships are widened by this relative amount, so that rounding does not exclude a
# closed end.
_EDGE = 4.0 * np.finfo(float).eps

# Search for the best factorization of a membership: nodes of the first grid, then the points and
# the number of the grids that close in on the best node. The last spacing is 2e-11 of the first
# interval.
_NODES, _CLOSER_NODES, _CLOSER_GRIDS = 64, 8, 14
_NODES_IF_NOT_CONVEX = 1024
_MOST_LANDMARKS = 32
_DEEPEST = 700.0  # exp(-700) is about the smallest normal number
# Largest error of the linear interpolation that replaces an intermediate result when three or more
# sets are met.
TABLE_TOLERANCE = 1e-7


@dataclass(frozen=True)
class ContinuousMeet(Type1Set):
    r"""Meet of secondary memberships under a t-norm other than the minimum.

    The t-norm must be continuous (eq. 1.31-1.34 are for the product).

    .. math:: \mu(\theta) = \sup_{v \star w = \theta} f(v) * g(w)

    For convex sets whose grades are combined by the minimum, the meet follows from its α-cuts: the
    ends of a cut are the t-norms of the ends of the sets' cuts. Otherwise the supremum is searched
    over v, between the best membership of the first set and the one that gives the best membership
    of the second. If there are three or more sets, all but the last are met first and tabulated.
    `meet` makes such sets.

    Parameters
    ----------
    operands : tuple of Type1Set
        The sets, within [0, 1].
    t_norm : TNorm
        How the memberships are combined.
    grade_t_norm : TNorm
        How the grades are combined.
    """

    operands: tuple[Type1Set, ...]
    t_norm: TNorm
    grade_t_norm: TNorm

    def __repr__(self) -> str:
        shown = ", ".join(map(repr, self.operands))
        return (
            f'meet({shown}, t_norm="{self.t_norm.name}", grade_t_norm="{self.grade_t_norm.name}")'
        )

    @property
    def height(self) -> float:
        """Supremum of the membership: the heights of all sets, combined by the grades' t-norm."""
        return float(self.grade_t_norm(*(operand.height for operand in self.operands)))

    @cached_property
    def _convex(self) -> bool:
        return all(operand.is_convex() for operand in self.operands)

    @cached_property
    def _pair(self) -> tuple[Type1Set, Type1Set]:
        """The last set, and the meet of all others (tabulated unless it is one set)."""
        *others, last = self.operands
        if len(others) == 1:
            return others[0], last
        return tabulated(ContinuousMeet(tuple(others), self.t_norm, self.grade_t_norm)), last

    def _grades(self, x: Array) -> Array:
        grades = np.zeros(x.size)
        theta = x.ravel()
        within = (theta >= 0.0) & (theta <= 1.0)
        if within.any():
            if self._convex and self.grade_t_norm is T_NORMS["min"]:
                grades[within] = self._grades_by_cuts(theta[within])
            else:
                grades[within] = _best_factorizations(
                    *self._pair, theta[within], self.t_norm, self.grade_t_norm
                )
        grades[np.isnan(theta)] = np.nan
        return grades.reshape(x.shape)

    def _grades_by_cuts(self, theta: Array) -> Array:
        """Return the highest level whose cut contains theta, by bisection of nested cuts."""

        def holds(level: Array) -> Array:
            left, right = self._cut(level)
            return np.asarray((left * (1.0 - _EDGE) <= theta) & (theta <= right * (1.0 + _EDGE)))

        # The level is h exp(-s), so halving s keeps the digits of tiny levels.
        inside, outside = np.full(theta.shape, _DEEPEST), np.zeros(theta.shape)
        found, top = holds(self.height * np.exp(-inside)), holds(np.full(theta.shape, self.height))
        for _ in range(HALVINGS):
            middle = 0.5 * (inside + outside)
            held = holds(self.height * np.exp(-middle))
            inside, outside = np.where(held, middle, inside), np.where(held, outside, middle)
        return np.where(top, self.height, np.where(found, self.height * np.exp(-inside), 0.0))

    def _ends(self, ends: Sequence[tuple[Array | float, Array | float]]) -> tuple[Array, Array]:
        return self.t_norm(*(left for left, _ in ends)), self.t_norm(*(right for _, right in ends))

    def _support(self) -> tuple[float, float]:
        left, right = self._ends([operand.support for operand in self.operands])
        return float(left), float(right)

    def _maxima(self) -> tuple[float, float]:
        if self.grade_t_norm is T_NORMS["min"] and self._convex:
            left, right = self._cut(np.asarray(self.height))
        else:
            # The sets are cut off at 0 and 1, so each of them reaches its height.
            left, right = self._ends(
                [operand.maxima or operand.support for operand in self.operands]
            )
        return float(left), float(right)

    def _landmarks(self) -> Array:
        first, last = self._support()
        kinks = self.operands[0].landmarks
        for operand in self.operands[1:]:
            if kinks.size * operand.landmarks.size > 4096:
                kinks = kinks[:: math.ceil(kinks.size / 64)]
            kinks = np.unique(self.t_norm(kinks[:, None], operand.landmarks))
        return merged(kinks[(kinks > first) & (kinks < last)], (first, last))

    def _cut(self, alpha: Array) -> tuple[Array, Array]:
        if self.grade_t_norm is T_NORMS["min"]:
            return self._ends([operand.alpha_cut(alpha) for operand in self.operands])
        return cut_by_bisection(self, alpha)

    @cached_property
    def _table(self) -> SampledSet:
        return tabulated(self)

    def moments(self, origin: float, power: int = 1) -> Moments:
        """Return area and first moment of the membership about ``origin``.

        They belong to a linear interpolation within 1e-7 of the membership.
        """
        return self._table.moments(origin, power)

    def centroid(self) -> float:
        """Return the centroid (eq. 1.68) by linear interpolation.

        The interpolation is within 1e-7 of the membership.
        """
        return self._table.centroid()

    def is_convex(self) -> bool:
        """Return whether the membership rises to its maximum and then falls.

        It does if the membership of every operand does.
        """
        return self._convex


def tabulated(fuzzy_set: Type1Set) -> SampledSet:
    """Return the set sampled densely enough for linear interpolation within 1e-7.

    The error of the interpolation is checked between all points.
    """
    first, last = fuzzy_set.support
    points = merged(np.linspace(first, last, 257), fuzzy_set.landmarks)
    points = points[(points >= first) & (points <= last)]
    grades = np.asarray(fuzzy_set(points))
    rough = np.arange(points.size - 1)
    # At a jump of the membership, halving stops once a sampled set would merge the points.
    while rough.size:
        left, right = points[rough], points[rough + 1]
        middle = 0.5 * (left + right)
        found = np.asarray(fuzzy_set(middle))
        bad = (np.abs(found - 0.5 * (grades[rough] + grades[rough + 1])) > TABLE_TOLERANCE) & (
            right - left > 4.0 * ROUNDING
        )
        inserted = rough[bad] + 1
        points = np.insert(points, inserted, middle[bad])
        grades = np.insert(grades, inserted, found[bad])
        new = inserted + np.arange(inserted.size)
        rough = np.sort(np.concatenate([new - 1, new]))
    if fuzzy_set.is_convex():  # the last digits of a search are not exact
        grades = np.minimum(
            np.maximum.accumulate(grades), np.maximum.accumulate(grades[::-1])[::-1]
        )
    return SampledSet(points, grades)


def _residuum(norm: TNorm, theta: Array, v: Array) -> Array:
    """Return the greatest w in [0, 1] with T(v, w) <= theta."""
    if norm is T_NORMS["product"]:
        return np.where(v > theta, theta / np.where(v > 0.0, v, 1.0), 1.0)
    low, high = (
        np.zeros(np.broadcast_shapes(theta.shape, v.shape)),
        np.ones(np.broadcast_shapes(theta.shape, v.shape)),
    )
    whole = norm(v, high) <= theta
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        below = norm(v, middle) <= theta
        low, high = np.where(below, middle, low), np.where(below, high, middle)
    return np.where(whole, 1.0, low)


def _least_factor(norm: TNorm, theta: Array, v: Array) -> Array:
    """Return the least w in [0, 1] with T(v, w) >= theta, for v >= theta."""
    if norm is T_NORMS["product"]:
        return np.where(theta > 0.0, np.minimum(theta / np.where(v > 0.0, v, 1.0), 1.0), 0.0)
    low, high = (
        np.zeros(np.broadcast_shapes(theta.shape, v.shape)),
        np.ones(np.broadcast_shapes(theta.shape, v.shape)),
    )
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        above = norm(v, middle) >= theta
        low, high = np.where(above, low, middle), np.where(above, middle, high)
    return np.where(theta > 0.0, high, 0.0)


def _best_factorizations(
    f: Type1Set, g: Type1Set, theta: Array, norm: TNorm, grade_norm: TNorm
) -> Array:
    """Return the supremum of f(v) combined with g(w) over all v, w with T(v, w) = theta (N,)."""
    chunk = 4096
    if theta.size > chunk:
        pieces = [
            _best_factorizations(f, g, theta[k : k + chunk], norm, grade_norm)
            for k in range(0, theta.size, chunk)
        ]
        return np.concatenate(pieces)
    target = theta[:, None]

    def value(v: Array) -> Array:
        # For most v there is one w. Where a t-norm is flat, or for theta = 0, there is an interval
        # of them.
        least, greatest = _least_factor(norm, target, v), _residuum(norm, target, v)
        best = supremum(g, least * (1.0 - _EDGE), greatest * (1.0 + _EDGE))
        return grade_norm(f(v), best)

    left, right = theta, np.ones(theta.shape)
    nodes = _NODES_IF_NOT_CONVEX
    if f.is_convex() and g.is_convex():
        # Beyond both best points the grades of both sets fall together, so the search stays between
        # them.
        own = np.clip((f.maxima or f.support)[0], theta, 1.0)
        others = np.clip(
            _residuum(norm, theta, np.full(theta.shape, (g.maxima or g.support)[0])), theta, 1.0
        )
        left, right = np.minimum(own, others), np.maximum(own, others)
        nodes = _NODES
    kinks = [_few(f), *([] if norm is not T_NORMS["product"] else [_few(g)])]
    candidates = [np.broadcast_to(np.clip(kinks[0], target, 1.0), (theta.size, kinks[0].size))]
    if len(kinks) > 1:
        candidates.append(np.clip(_residuum(norm, target, kinks[1][None, :]), target, 1.0))
    v = np.concatenate(
        [left[:, None] + (right - left)[:, None] * np.linspace(0.0, 1.0, nodes + 1), *candidates],
        axis=1,
    )
    rows = np.arange(theta.size)
    values = value(v)
    best = values.max(axis=1)
    center = v[rows, values.argmax(axis=1)]
    reach = (right - left) / nodes
    for _ in range(_CLOSER_GRIDS):
        v = np.clip(
            center[:, None] + reach[:, None] * np.linspace(-1.0, 1.0, _CLOSER_NODES + 1),
            target,
            1.0,
        )
        values = value(v)
        center = v[rows, values.argmax(axis=1)]
        best = np.maximum(best, values.max(axis=1))
        reach = reach * (2.0 / _CLOSER_NODES)
    return np.asarray(best)


def _few(operand: Type1Set) -> Array:
    """Return the points where a set may jump or bend.

    If there are very many, only the ends and the maxima are returned.
    """
    points = operand.landmarks
    if points.size > _MOST_LANDMARKS:
        points = np.unique([*operand.support, *(operand.maxima or ())])
    return points[(points >= 0.0) & (points <= 1.0)]
