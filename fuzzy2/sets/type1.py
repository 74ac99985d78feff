"""Type-1 sets: their base class, singletons and sampled sets."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fuzzy2.errors import InvalidValue, NotApplicable
from fuzzy2.sets.pictures import ShownSet
from fuzzy2.support.checks import Array, maybe_infinite, real, reals, share, whole_number
from fuzzy2.support.quadrature import Moments, merged

ROUNDING = 1e-12
"""Grades that differ by no more than this are considered equal."""

KernelRow = tuple[float, float, float, float, float, float, float, float, float]
"""Row of a set for the compiled kernels: its kind, then eight numbers; see
:meth:`Type1Set.kernel_row`."""


class Type1Set(ShownSet, ABC):
    """Base of the type-1 fuzzy sets.

    A subclass defines ``height`` and the private methods that the public methods here call.
    """

    @property
    @abstractmethod
    def height(self) -> float:
        """Supremum of the membership."""

    @abstractmethod
    def _grades(self, x: Array) -> Array:
        """Return the membership at points (...,), NaN for NaN."""

    @abstractmethod
    def _support(self) -> tuple[float, float]: ...

    @abstractmethod
    def _maxima(self) -> tuple[float, float] | None: ...

    @abstractmethod
    def _landmarks(self) -> Array: ...

    @abstractmethod
    def _cut(self, alpha: Array) -> tuple[Array, Array]:
        """Return the ends of the cuts at grades (...,) between 0 and the height.

        The value for grade 0 is not used.
        """

    def _quadrature_points(self, power: int) -> Array:
        first, last = self._support()
        if not (math.isfinite(first) and math.isfinite(last)):
            raise NotApplicable(
                "centroid",
                f"the support of {repr(self)[:80]} is unbounded, and its area need not be finite",
            )
        points = self._landmarks()
        return merged(points[(points > first) & (points < last)], (first, last))

    def _kernel_row(self) -> KernelRow | None:
        return None

    def _slopes(self, x: Array) -> Array:
        """Return the right-hand derivative of the membership at finite points (...,).

        The values at other points are not used.
        """
        raise NotApplicable("derivative", f"no formula is known for that of {repr(self)[:80]}")

    def membership(self, x: ArrayLike) -> Array:
        """Return the membership grades of points.

        Parameters
        ----------
        x : (...,) array_like
            Points.

        Returns
        -------
        (...,) array
            Grades in [0, 1]; NaN where the point is NaN.

        Raises
        ------
        InvalidValue
            If the points are not real numbers.
        """
        return self._grades(reals("x", x))[()]

    def __call__(self, x: ArrayLike) -> Array:
        """Return the membership grades of points; see :meth:`membership`."""
        return self._grades(reals("x", x))[()]

    def derivative(self, x: ArrayLike) -> Array:
        r"""Return the right-hand derivative of the membership.

        It is :math:`\lim_{h \downarrow 0} (\mu(x + h) - \mu(x + 0)) / h`.

        At a kink it is the slope to the right. Jumps are ignored: at a vertical edge, too, it is
        the slope to the right.

        Parameters
        ----------
        x : (...,) array_like
            Points.

        Returns
        -------
        (...,) array
            Derivatives; NaN where the point is NaN, 0 at infinity.

        Raises
        ------
        InvalidValue
            If the points are not real numbers.
        NotApplicable
            If the membership is a function whose derivative is not known.
        """
        points = reals("x", x)
        with np.errstate(all="ignore"):  # far out squares and powers are infinite
            slopes = np.asarray(
                self._slopes(np.where(np.isfinite(points), points, 0.0)), dtype=float
            )
        return keep_nan(points, np.where(np.isinf(points), 0.0, slopes))[()]

    @property
    def lower(self) -> Type1Set:
        """Lower membership function: for a type-1 set, the set itself."""
        return self

    @property
    def upper(self) -> Type1Set:
        """Upper membership function: for a type-1 set, the set itself."""
        return self

    @property
    def principal(self) -> Type1Set:
        """Principal membership function: for a type-1 set, the set itself."""
        return self

    def secondary(self, x: float) -> Singleton:
        """Return the membership at a point as a vertical slice without uncertainty (eq. 1.3)."""
        return Singleton(float(self.membership(real("x", x))))

    def alpha_plane(self, alpha: float) -> Type1Set:
        """Return the set itself, because its secondary grades are all 1."""
        share("alpha", alpha)
        return self

    @property
    def support(self) -> tuple[float, float]:
        """Ends of the smallest closed interval outside which the membership is 0.

        They may be infinite.
        """
        return self._support()

    @property
    def maxima(self) -> tuple[float, float] | None:
        """First and last point of the greatest membership.

        It is None if the greatest membership is approached but never reached.
        """
        return self._maxima()

    @property
    def core(self) -> tuple[float, float] | None:
        """First and last point of membership 1, or None if there is none."""
        return self._maxima() if self.height >= 1.0 - ROUNDING else None

    @property
    def landmarks(self) -> Array:
        """Ascending finite points between which the membership is smooth.

        Beyond them the membership hardly changes.
        """
        return self._landmarks()

    def is_normal(self) -> bool:
        """Return whether some point has membership 1."""
        return self.core is not None

    def is_convex(self) -> bool:
        """Return whether every α-cut is an interval.

        Equivalently, the membership rises to its maximum and then falls.
        """
        return True

    def alpha_cut(self, alpha: ArrayLike) -> tuple[Array, Array]:
        r"""Return the points whose membership is at least alpha, :math:`\{x : \mu(x) \ge \alpha\}`.

        Parameters
        ----------
        alpha : (...,) array_like
            Grades from 0 to the height of the set. The cut at 0 is the support.

        Returns
        -------
        left, right : (...,) arrays
            Ends of the cuts.

        Raises
        ------
        InvalidValue
            If a grade is negative or above the height.
        NotApplicable
            If the set is not convex, because its cuts are then not intervals.
        """
        grades = reals("alpha", alpha)
        if not ((grades >= 0.0) & (grades <= self.height + ROUNDING)).all():
            raise InvalidValue(
                "alpha", alpha, f"from 0 to the height of the set, {self.height:.12g}"
            )
        if self._maxima() is None and (grades >= self.height).any():
            raise InvalidValue(
                "alpha",
                alpha,
                f"below {self.height:.12g}, which the membership approaches but never reaches",
            )
        if not self.is_convex():
            raise NotApplicable(
                "alpha_cut", "the set is not convex, so that a cut need not be an interval"
            )
        left, right = self._cut(np.minimum(grades, self.height))
        first, last = self._support()
        return np.where(grades > 0.0, left, first)[()], np.where(grades > 0.0, right, last)[()]

    def quadrature_points(self, power: int = 1) -> Array:
        r"""Return ascending points over which to integrate :math:`|x|^{power} \mu(x)`.

        They span the whole domain. The power is 0 or 1.

        Raises
        ------
        NotApplicable
            If the integral diverges.
        """
        return self._quadrature_points(power)

    def moments(self, origin: float, power: int = 1) -> Moments:
        """Return area and first moment of the membership about ``origin``.

        They are available for the whole domain and up to any point. The power is 0 if only the area
        is needed, which may be finite even if the moment is not.
        """
        about = real("origin", origin)
        if whole_number("power", power, 0) > 1:
            raise InvalidValue("power", power, "0 or 1")
        return Moments(self._grades, self._quadrature_points(power), about)

    def centroid(self) -> float:
        r"""Return the centroid on the continuous domain, by quadrature (eq. 1.68).

        .. math:: c_A = \frac{\int x\, \mu_A(x)\, dx}{\int \mu_A(x)\, dx}

        Returns
        -------
        float
            The centroid; for a singleton, its point.

        Raises
        ------
        NotApplicable
            If the set is unbounded and has no finite centroid, or has no area.
        """
        points = self._quadrature_points(1)
        first, last = float(points[0]), float(points[-1])
        if first == last:
            return first
        origin = 0.5 * first + 0.5 * last
        area, moment = Moments(self._grades, points, origin).total
        if area == 0.0:
            raise NotApplicable("centroid", f"the membership of {self!r} is zero almost everywhere")
        return origin + moment / area

    def sample(self, x: ArrayLike) -> SampledSet:
        """Return the set sampled at points.

        Parameters
        ----------
        x : (N,) array_like
            Points.

        Returns
        -------
        SampledSet
            The points with their grades.
        """
        return SampledSet(x, self.membership(x))

    def kernel_row(self) -> KernelRow | None:
        """Return the set as a row of numbers for the compiled kernels.

        It is None if only Python can evaluate the set.

        Returns
        -------
        tuple of 9 floats or None
            ``(0, m1, m2, sigma_lower, sigma_upper, height_lower, height_upper, 0, 0)`` is a pair of
            Gaussians. The upper one has the mean in [m1, m2] that is nearest to the point, the
            lower one has m1 or m2, whichever is farther. ``(1, a, b, c, d, height, 0, 0, 0)`` is a
            trapezoid. :mod:`fuzzy2.systems.shape_kernels` lists the other kinds.
        """
        return self._kernel_row()


@dataclass(frozen=True)
class Singleton(Type1Set):
    """Singleton: membership 1 at one point and 0 elsewhere.

    Parameters
    ----------
    point : float
        The point.

    Raises
    ------
    InvalidValue
        If the point is not a finite number.
    """

    point: float

    def __post_init__(self) -> None:
        set_fields(self, point=real("point", self.point))

    def _grades(self, x: Array) -> Array:
        return keep_nan(x, np.equal(x, self.point))

    def _slopes(self, x: Array) -> Array:
        return np.zeros_like(x)

    def _support(self) -> tuple[float, float]:
        return self.point, self.point

    def _maxima(self) -> tuple[float, float]:
        return self.point, self.point

    height = 1.0

    def _cut(self, alpha: Array) -> tuple[Array, Array]:
        return np.full_like(alpha, self.point), np.full_like(alpha, self.point)

    def _landmarks(self) -> Array:
        return np.array([self.point])


@dataclass(frozen=True, eq=False)
class SampledSet(Type1Set):
    """Set given by points and their grades: a discrete set, or samples of a continuous one.

    Between the points the membership is interpolated linearly; outside them it is 0. As a discrete
    set it consists of ``.points`` with ``.grades``, which is how joins, meets and embedded sets
    read it.

    Parameters
    ----------
    points : (N,) array_like
        Points, in any order. Points within 1e-12 of each other (for points below 1e-6, within a
        relative distance) are merged and keep the greatest of their grades.
    grades : (N,) array_like
        Grades in [0, 1], not all of them 0.

    Raises
    ------
    InvalidValue
        If the points are not finite, if the grades are not in [0, 1], or if there are no points or
        not as many grades as points.
    """

    points: Array
    grades: Array

    def __init__(self, points: ArrayLike, grades: ArrayLike) -> None:
        x, u = reals("points", points), reals("grades", grades)
        if x.ndim != 1 or x.size == 0 or not np.isfinite(x).all():
            raise InvalidValue(
                "points", points, "finite numbers of shape (N,) with N of at least 1"
            )
        if u.shape != x.shape or not ((u >= 0.0) & (u <= 1.0 + ROUNDING)).all():
            raise InvalidValue("grades", grades, f"in [0, 1], one for each of the {x.size} points")
        order = np.argsort(x, kind="stable")
        x, u = x[order], np.minimum(u[order], 1.0)
        # The merging distance is absolute in the unit interval, but must not merge whole sets of
        # tiny numbers.
        apart = min(ROUNDING, 1e-6 * max(-float(x[0]), float(x[-1])))
        starts = np.flatnonzero(np.concatenate([[True], np.diff(x) > apart]))
        x, u = x[starts], np.maximum.reduceat(u, starts)
        x.flags.writeable = u.flags.writeable = False
        set_fields(self, points=x, grades=u)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, SampledSet):
            return NotImplemented
        return np.array_equal(self.points, other.points) and np.array_equal(
            self.grades, other.grades
        )

    def __hash__(self) -> int:
        # Both signed zeros are equal, so they must have the same hash.
        return hash(((self.points + 0.0).tobytes(), (self.grades + 0.0).tobytes()))

    def __len__(self) -> int:
        return self.points.size

    def __repr__(self) -> str:
        return f"SampledSet(points={self.points.tolist()}, grades={self.grades.tolist()})"

    @property
    def height(self) -> float:
        """Greatest grade."""
        return float(self.grades.max())

    def _grades(self, x: Array) -> Array:
        return np.interp(x, self.points, self.grades, left=0.0, right=0.0)

    def _slopes(self, x: Array) -> Array:
        # The slope is 0 before the first point and from the last point on.
        slopes = np.concatenate([[0.0], np.diff(self.grades) / np.diff(self.points), [0.0]])
        return np.asarray(slopes[np.searchsorted(self.points, x, side="right")])

    def _support(self) -> tuple[float, float]:
        positive_ones = np.flatnonzero(self.grades > 0.0)
        if positive_ones.size == 0:
            return float(self.points[0]), float(self.points[-1])
        first, last = (
            max(int(positive_ones[0]) - 1, 0),
            min(int(positive_ones[-1]) + 1, self.points.size - 1),
        )
        return float(self.points[first]), float(self.points[last])

    def _maxima(self) -> tuple[float, float]:
        highest = self.points[self.grades >= self.height - ROUNDING]
        return float(highest[0]), float(highest[-1])

    def _landmarks(self) -> Array:
        return self.points

    def _cut(self, alpha: Array) -> tuple[Array, Array]:
        left = _first_reach(alpha, self.points, self.grades)
        right = -_first_reach(alpha, -self.points[::-1], self.grades[::-1])
        return left, right

    def is_convex(self) -> bool:
        """Return whether the grades rise to their maximum and then fall, up to rounding errors."""
        envelope = np.minimum(
            np.maximum.accumulate(self.grades), np.maximum.accumulate(self.grades[::-1])[::-1]
        )
        return bool((self.grades >= envelope - ROUNDING).all())


def _first_reach(alpha: Array, points: Array, grades: Array) -> Array:
    """Return the first points at which interpolated grades reach alpha (...,).

    Points are ascending, and grades between them are interpolated.
    """
    envelope = np.maximum.accumulate(grades)
    after = np.minimum(np.searchsorted(envelope, alpha - ROUNDING, side="left"), len(points) - 1)
    before = np.maximum(after - 1, 0)
    rise = envelope[after] - envelope[before]
    with np.errstate(invalid="ignore", divide="ignore"):
        fraction = np.where(rise > 0.0, np.clip((alpha - envelope[before]) / rise, 0.0, 1.0), 1.0)
    return np.asarray(points[before] + fraction * (points[after] - points[before]))


def keep_nan(x: Array, grades: Array | NDArray[np.bool_]) -> Array:
    """Return grades as floats, NaN where the point is NaN."""
    return np.where(np.isnan(x), np.nan, grades)


def set_fields(frozen: object, **fields: object) -> None:
    """Set fields of a frozen dataclass while it is being made."""
    for name, value in fields.items():
        object.__setattr__(frozen, name, value)


def pair_of_numbers(name: str, values: object, requirement: str) -> tuple[float, float]:
    """Return a pair of numbers, which may be infinite.

    Raise :class:`InvalidValue` if it is not a pair.
    """
    try:
        # anything that is not a pair is refused below
        first, second = list(values)  # type: ignore[call-overload]
    except (TypeError, ValueError) as error:
        raise InvalidValue(name, values, requirement) from error
    return maybe_infinite(name, first, requirement), maybe_infinite(name, second, requirement)
