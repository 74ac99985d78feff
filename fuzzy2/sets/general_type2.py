r"""General type-2 fuzzy sets.

The membership at a point is itself a type-1 set over [0, 1], which is called the vertical slice
(eq. 1.1-1.3).

A set is defined by a principal membership with Gaussian secondary memberships
(:class:`GaussianType2Set`), by any function from points to vertical slices
(:class:`FunctionalType2Set`), by slices at sampled points (:class:`SampledType2Set`), or by
α-planes (:class:`ZSlices`). All these classes have the same methods.
"""

from __future__ import annotations

import itertools
import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from fuzzy2.errors import InvalidValue, NotApplicable
from fuzzy2.sets.derived import FunctionalSet
from fuzzy2.sets.interval_type2 import IntervalType2Set, check_below
from fuzzy2.sets.pictures import ShownSet
from fuzzy2.sets.type1 import ROUNDING, SampledSet, Singleton, Type1Set, keep_nan, set_fields
from fuzzy2.sets.vertical_slices import Staircase, cuts_of, maxima_of, slice_between
from fuzzy2.support.checks import Array, broadcast, grade, listed, of_kind, real, reals, share
from fuzzy2.support.quadrature import merged


class EmbeddedType2Set(NamedTuple):
    """Type-2 set embedded in a discrete type-2 set (eq. 1.6).

    It has one primary membership at every point, with its secondary grade.
    """

    points: Array
    """Points, (N,)."""
    memberships: Array
    """Chosen primary memberships, (N,)."""
    grades: Array
    """Their secondary grades, (N,)."""

    @property
    def type1(self) -> SampledSet:
        """Embedded type-1 set (eq. 1.7): the primary memberships without their secondary grades."""
        return SampledSet(self.points, self.memberships)


@dataclass(frozen=True)
class AlphaPlane(IntervalType2Set):
    """α-plane of a general type-2 set.

    It holds the primary memberships whose secondary grade is at least ``alpha``.

    At points where no secondary grade reaches ``alpha``, both memberships are 0.
    """

    alpha: float

    def __post_init__(self) -> None:
        # The ends of an α-cut are in order already; checking them would cost more than making the
        # plane.
        set_fields(self, alpha=float(self.alpha))


class GeneralType2Set(ShownSet, ABC):
    """Base of the general type-2 fuzzy sets.

    A subclass defines ``secondary``, ``support`` and ``landmarks``. It overrides the private
    methods where it has a faster way than slice by slice.
    """

    @property
    @abstractmethod
    def support(self) -> tuple[float, float]:
        """Ends of the domain, which may be infinite; the membership outside is crisply 0."""

    @property
    @abstractmethod
    def landmarks(self) -> Array:
        """Ascending finite points that locate the set and mark where its shape changes."""

    @abstractmethod
    def secondary(self, x: float) -> Type1Set:
        """Return the vertical slice at a point.

        It is the secondary membership function over [0, 1] (eq. 1.3).

        Parameters
        ----------
        x : float
            The point.

        Returns
        -------
        Type1Set
            Secondary grades of the primary memberships.
        """

    def _cut(self, x: Array, alpha: float) -> tuple[Array, Array]:
        """Return the ends of the α-cuts of the vertical slices at points (...,)."""
        return cuts_of([self.secondary(float(point)) for point in x.ravel()], alpha, x.shape)

    def _principal(self, x: Array) -> Array:
        """Return the primary memberships with the greatest secondary grade at points (...,)."""
        middles = [0.5 * sum(maxima_of(self.secondary(float(point)))) for point in x.ravel()]
        return np.array(middles, dtype=float).reshape(x.shape)

    def _secondary_grades(self, x: Array, u: Array) -> Array:
        """Return the secondary grades of points and primary memberships, both (...,)."""
        pairs = zip(x.ravel(), u.ravel(), strict=True)
        return np.array(
            [self.secondary(float(point))(membership) for point, membership in pairs], dtype=float
        ).reshape(x.shape)

    def _bound(self, x: Array, alpha: float, end: int) -> Array:
        missing = np.isnan(x)
        return keep_nan(x, self._cut(np.where(missing, self.landmarks[0], x), alpha)[end])

    def _slope_of_bound(self, alpha: float, end: int) -> Callable[[Array], Array] | None:
        """Return the right-hand derivative of a membership function of an α-plane.

        ``end`` is 0 for the lower function and 1 for the upper one. The result is None if no
        formula is known.
        """
        return None

    def _kinks_of_bound(self, alpha: float, end: int) -> Array:
        """Return the kinks (K,) of that membership function other than the landmarks."""
        return np.empty(0)

    def _functional(self, function: Callable[[Array], Array]) -> FunctionalSet:
        return FunctionalSet(function, *self.support, knots=tuple(self.landmarks.tolist()))

    def _bound_set(self, alpha: float, end: int) -> FunctionalSet:
        function, slope = (
            partial(self._bound, alpha=alpha, end=end),
            self._slope_of_bound(alpha, end),
        )
        knots = merged(self.landmarks, self._kinks_of_bound(alpha, end))
        return FunctionalSet(function, *self.support, knots=tuple(knots.tolist()), slope=slope)

    @cached_property
    def lower(self) -> Type1Set:
        """Lower membership function of the footprint of uncertainty."""
        return self._bound_set(0.0, 0)

    @cached_property
    def upper(self) -> Type1Set:
        """Upper membership function of the footprint of uncertainty."""
        return self._bound_set(0.0, 1)

    @cached_property
    def principal(self) -> Type1Set:
        """Principal membership function.

        It is the primary membership with the greatest secondary grade, or the middle if several
        have it.
        """
        return self._functional(
            lambda x: keep_nan(x, self._principal(np.where(np.isnan(x), self.landmarks[0], x)))
        )

    def footprint(self, x: ArrayLike) -> Array:
        r"""Return the ends of the primary membership :math:`J_x` at points (eq. 1.4).

        Parameters
        ----------
        x : (...,) array_like
            Points.

        Returns
        -------
        (..., 2) array
            Lower and upper ends of the support of the vertical slices.
        """
        return np.stack([self.lower(x), self.upper(x)], axis=-1)

    def secondary_grade(self, x: ArrayLike, u: ArrayLike) -> Array:
        r"""Return the secondary grades :math:`\mu(x, u)` (eq. 1.1).

        Parameters
        ----------
        x, u : (...,) array_like
            Points and primary memberships, which are broadcast.

        Returns
        -------
        (...,) array
            Secondary grades, NaN where an argument is.
        """
        points, memberships = broadcast("x and u", reals("x", x), reals("u", u))
        missing = np.isnan(points) | np.isnan(memberships)
        grades = self._secondary_grades(
            np.where(missing, self.landmarks[0], points), np.where(missing, 0.0, memberships)
        )
        return np.where(missing, np.nan, grades)[()]

    def alpha_plane(self, alpha: float) -> IntervalType2Set:
        r"""Return the α-plane, :math:`\{(x, u) : \mu(x, u) \ge \alpha\}`.

        For alpha = 0 it is the footprint of uncertainty.

        Parameters
        ----------
        alpha : float
            Secondary grade in [0, 1].

        Returns
        -------
        IntervalType2Set
            The plane, with ``.lower(x)`` and ``.upper(x)``; both are 0 where no secondary grade
            reaches alpha.

        Raises
        ------
        InvalidValue
            If alpha is not in [0, 1].
        NotApplicable
            If a vertical slice is not convex. The error is raised when the plane is evaluated
            there.
        """
        level = share("alpha", alpha)
        return AlphaPlane(self._bound_set(level, 0), self._bound_set(level, 1), level)

    def zslices(self, alphas: Sequence[float]) -> ZSlices:
        """Return the set as zSlices.

        The result is a staircase of α-planes at the given ascending grades in (0, 1].
        """
        levels = listed("alphas", alphas, "a list of grades")
        return ZSlices(levels, tuple(self.alpha_plane(level) for level in levels))

    def sample(self, x: ArrayLike, u: ArrayLike) -> SampledType2Set:
        """Return the set sampled in both directions: a discrete-membership type-2 set.

        Parameters
        ----------
        x : (N,) array_like
            Points.
        u : (M,) array_like
            Primary memberships in [0, 1]. Each slice keeps those with a positive secondary grade
            and adds its principal membership.

        Returns
        -------
        SampledType2Set
            The sampled set; its slices have at most M + 1 primary memberships.
        """
        points, given = reals("x", x), reals("u", u)
        if not ((given >= 0.0) & (given <= 1.0)).all():
            raise InvalidValue("u", u, "primary memberships in [0, 1]")
        memberships = np.append(given, np.nan)
        slices = []
        for point in points.ravel():
            memberships[-1] = self._principal(np.array(point))
            grades = self._secondary_grades(np.full_like(memberships, point), memberships)
            kept = grades > 0.0
            slices.append(SampledSet(memberships[kept], grades[kept]))
        return SampledType2Set(points, slices)

    def embedded_count(self) -> int:
        """Return the number of embedded type-2 sets of a discrete set."""
        raise NotApplicable(
            "embedded_count",
            "a set on a continuous domain has infinitely many embedded sets; sample it first",
        )

    def embedded_sets(self) -> Iterator[EmbeddedType2Set]:
        """Return all embedded type-2 sets of a discrete set, one after another."""
        raise NotApplicable(
            "embedded_sets",
            "a set on a continuous domain has infinitely many embedded sets; sample it first",
        )

    def kernel_row(self) -> None:
        """Return None, because the compiled kernels read secondary grades in other ways."""
        return


@dataclass(frozen=True)
class SampledType2Set(GeneralType2Set):
    """General type-2 set given by vertical slices at sampled points.

    With :class:`SampledSet` slices it is a discrete-membership type-2 set, and its embedded sets
    can be counted and listed; with others it is partially discrete. Between two points the α-cuts
    of their slices are interpolated, which requires convex slices. Outside the points the
    membership is crisply 0.

    Parameters
    ----------
    points : (N,) array_like
        Distinct points, in any order.
    slices : sequence of N Type1Set
        Vertical slices, with supports in [0, 1].

    Raises
    ------
    InvalidValue
        If the points are not finite and distinct, if there are not as many slices as points, or if
        a slice leaves [0, 1].
    """

    points: tuple[float, ...]
    slices: tuple[Type1Set, ...]

    def __init__(self, points: ArrayLike, slices: Sequence[Type1Set]) -> None:
        x = reals("points", points)
        if x.ndim != 1 or x.size == 0 or not np.isfinite(x).all() or np.unique(x).size != x.size:
            raise InvalidValue(
                "points", points, "finite, distinct numbers of shape (N,) with N of at least 1"
            )
        slices = listed("slices", slices, "a list of type-1 sets")
        if len(slices) != x.size:
            raise InvalidValue("slices", len(slices), f"one for each of the {x.size} points")
        for one in slices:
            of_kind("slices", one, Type1Set, "type-1 sets")
        for point, vertical_slice in zip(x, slices, strict=True):
            first, last = vertical_slice.support
            if first < -ROUNDING or last > 1.0 + ROUNDING:
                raise InvalidValue(f"slice at {point:.12g}", vertical_slice, "a set over [0, 1]")
        order = np.argsort(x)
        set_fields(self, points=tuple(x[order].tolist()), slices=tuple(slices[i] for i in order))

    @property
    def support(self) -> tuple[float, float]:
        """First and last point."""
        return self.points[0], self.points[-1]

    @property
    def landmarks(self) -> Array:
        """All points."""
        return np.array(self.points)

    def is_discrete(self) -> bool:
        """Return whether all slices are discrete.

        Then it is a discrete-membership type-2 set; otherwise it is partially discrete.
        """
        return all(isinstance(vertical_slice, SampledSet) for vertical_slice in self.slices)

    def secondary(self, x: float) -> Type1Set:
        """Return the vertical slice at a point.

        Between two sampled points the slice has interpolated α-cuts (eq. 1.3).

        Raises
        ------
        NotApplicable
            If the point lies between two sampled points whose slices are not both convex.
        """
        point = real("x", x)
        if not self.points[0] <= point <= self.points[-1]:
            return Singleton(0.0)
        after = int(np.searchsorted(self.points, point))
        if self.points[after] == point:
            return self.slices[after]
        share = (point - self.points[after - 1]) / (self.points[after] - self.points[after - 1])
        return slice_between(self.slices[after - 1], self.slices[after], share)

    def _cut(self, x: Array, alpha: float) -> tuple[Array, Array]:
        left, right = cuts_of(self.slices, alpha, (len(self.slices),))
        interpolated = (
            np.interp(x, self.points, end, left=0.0, right=0.0) for end in (left, right)
        )
        return next(interpolated), next(interpolated)

    def _discrete_slices(self, what: str) -> list[SampledSet]:
        slices = [
            vertical_slice
            for vertical_slice in self.slices
            if isinstance(vertical_slice, SampledSet)
        ]
        if len(slices) < len(self.slices):
            raise NotApplicable(
                what,
                "the set is partially discrete: a continuous slice has infinitely many "
                "memberships; sample it first",
            )
        return slices

    def embedded_count(self) -> int:
        r"""Return the number of embedded type-2 sets, :math:`\prod_i M_i` (after eq. 1.6).

        Raises
        ------
        NotApplicable
            If a slice is not a :class:`SampledSet`.
        """
        return math.prod(
            len(vertical_slice) for vertical_slice in self._discrete_slices("embedded_count")
        )

    def embedded_sets(self) -> Iterator[EmbeddedType2Set]:
        """Return all embedded type-2 sets, one after another.

        The memberships of the last slice vary fastest (eq. 1.6, 1.7).

        Raises
        ------
        NotApplicable
            If a slice is not a :class:`SampledSet`.
        """
        slices = self._discrete_slices("embedded_sets")
        return self._enumerate(slices)

    def _enumerate(self, slices: list[SampledSet]) -> Iterator[EmbeddedType2Set]:
        points = self.landmarks
        for chosen in itertools.product(*(range(len(vertical_slice)) for vertical_slice in slices)):
            pairs = [(one.points[i], one.grades[i]) for one, i in zip(slices, chosen, strict=True)]
            memberships, grades = np.array(pairs).T
            yield EmbeddedType2Set(points, memberships, grades)


@dataclass(frozen=True)
class ZSlices(GeneralType2Set):
    r"""General type-2 set made of zSlices.

    A zSlice is an interval type-2 set with the secondary grade of its level.

    .. math:: \mu(x, u) = \max \{\alpha_i : \underline\mu_i(x) \le u \le \overline\mu_i(x)\}

    Parameters
    ----------
    alphas : sequence of K floats
        Levels in (0, 1], ascending, no two of them equal.
    planes : sequence of K IntervalType2Set
        Planes, each within the one before it. A type-1 set is a plane of zero width.

    Raises
    ------
    InvalidValue
        If the levels are not in order, if there are not as many planes as levels, or if a plane
        leaves the one before it; the message says where.
    """

    alphas: tuple[float, ...]
    planes: tuple[IntervalType2Set | Type1Set, ...]

    def __post_init__(self) -> None:
        levels = listed("alphas", self.alphas, "a list of grades")
        alphas = tuple(grade("alphas", alpha) for alpha in levels)
        if not alphas or any(after <= before for before, after in itertools.pairwise(alphas)):
            raise InvalidValue(
                "alphas", self.alphas, "at least one level, and each above the one before it"
            )
        planes = listed("planes", self.planes, "a list of interval type-2 sets")
        for plane in planes:
            of_kind("planes", plane, (IntervalType2Set, Type1Set), "interval type-2 sets")
        if len(planes) != len(alphas):
            raise InvalidValue("planes", len(planes), f"one for each of the {len(alphas)} levels")
        for i, (outer, inner) in enumerate(itertools.pairwise(planes)):
            check_below(f"planes[{i}].lower", outer.lower, f"planes[{i + 1}].lower", inner.lower)
            check_below(f"planes[{i + 1}].upper", inner.upper, f"planes[{i}].upper", outer.upper)
        set_fields(self, alphas=alphas, planes=planes)

    @property
    def support(self) -> tuple[float, float]:
        """Support of the lowest plane."""
        return self.planes[0].support

    @property
    def landmarks(self) -> Array:
        """Landmarks of all planes."""
        return merged(*(plane.landmarks for plane in self.planes))

    def secondary(self, x: float) -> Staircase:
        """Return the vertical slice at a point: a staircase (eq. 1.3)."""
        point = real("x", x)
        lefts, rights = (tuple(float(end(point)) for end in ends) for ends in self._ends)
        return Staircase(self.alphas, lefts, rights)

    @property
    def _ends(self) -> tuple[list[Type1Set], list[Type1Set]]:
        return [plane.lower for plane in self.planes], [plane.upper for plane in self.planes]

    def alpha_plane(self, alpha: float) -> IntervalType2Set:
        """Return the plane of the lowest level that is not below alpha.

        See :meth:`GeneralType2Set.alpha_plane`.
        """
        general = super().alpha_plane(alpha)
        i = int(np.searchsorted(np.array(self.alphas), alpha - ROUNDING))
        if i == len(self.planes):
            return general
        return AlphaPlane(self.planes[i].lower, self.planes[i].upper, float(alpha))

    def _cut(self, x: Array, alpha: float) -> tuple[Array, Array]:
        i = int(np.searchsorted(np.array(self.alphas), alpha - ROUNDING))
        return (
            (np.zeros_like(x), np.zeros_like(x))
            if i == len(self.planes)
            else (self.planes[i].lower(x), self.planes[i].upper(x))
        )

    def _principal(self, x: Array) -> Array:
        return np.asarray(0.5 * (self.planes[-1].lower(x) + self.planes[-1].upper(x)))

    def _secondary_grades(self, x: Array, u: Array) -> Array:
        grades = np.zeros_like(x)
        for alpha, plane in zip(self.alphas, self.planes, strict=True):
            grades = np.where(
                (u >= plane.lower(x) - ROUNDING) & (u <= plane.upper(x) + ROUNDING), alpha, grades
            )
        return grades
