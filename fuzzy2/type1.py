r"""Type-1 fuzzy sets: a membership grade in [0, 1] for every point of the real line.

All sets are frozen and array-first: ``fuzzy_set(x)`` takes points of any shape and returns grades of that shape, NaN where the
point is NaN. A type-1 set is also a type-2 set without uncertainty: ``fuzzy_set.lower`` and ``fuzzy_set.upper`` are the
set itself, so that type-1 and type-2 terms mix.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import NoReturn

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fuzzy2.checks import Array, ascending, grade, maybe_infinite, positive, real, reals
from fuzzy2.errors import InvalidValue, NotApplicable
from fuzzy2.quadrature import Moments, merged

ROUNDING = 1e-12
"""Grades that differ by no more than this are the same."""

KernelRow = tuple[float, float, float, float, float, float, float, float, float]
"""What the compiled kernels know of a set: its kind, then eight numbers; see :meth:`Type1Set.kernel_row`."""

# Where a Gaussian is cut into pieces, in standard deviations: exp(-39²/2) is the last that is not zero in double precision.
_GAUSSIAN_SPREAD = np.array([0.5, 1.0, 2.0, 3.0, 4.0, 6.0, 8.0])
_GAUSSIAN_TAIL = np.array([12.0, 18.0, 26.0, 39.0])


def _mirrored(distances: Array) -> Array:
    return np.concatenate([-distances[::-1], [0.0], distances])


class Type1Set(ABC):
    """Base of the type-1 fuzzy sets.

    A subclass gives ``height`` and the private methods that do the work of the public ones here.
    """

    @property
    @abstractmethod
    def height(self) -> float:
        """Supremum of the membership."""

    @abstractmethod
    def _grades(self, x: Array) -> Array:
        """Return the membership of points (...,), NaN for NaN."""

    @abstractmethod
    def _support(self) -> tuple[float, float]: ...

    @abstractmethod
    def _maxima(self) -> tuple[float, float] | None: ...

    @abstractmethod
    def _landmarks(self) -> Array: ...

    @abstractmethod
    def _cut(self, alpha: Array) -> tuple[Array, Array]:
        """Return the ends of the cuts at grades (...,) from 0 to the height; what is returned for 0 does not matter."""

    def _quadrature_points(self, power: int) -> Array:
        first, last = self._support()
        if not (math.isfinite(first) and math.isfinite(last)):
            raise NotApplicable("centroid", f"the support of {repr(self)[:80]} is unbounded, and its area need not be finite")
        points = self._landmarks()
        return merged(points[(points > first) & (points < last)], (first, last))

    def _kernel_row(self) -> KernelRow | None:
        return None

    def _slopes(self, x: Array) -> Array:
        """Return the derivative of the membership at finite points (...,), from the right; what is returned for others does not matter."""
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
        r"""Return the derivative of the membership from the right, :math:`\lim_{h \downarrow 0} (\mu(x + h) - \mu(x + 0)) / h`.

        At a kink it is the slope of what follows. A jump counts for nothing: at a vertical edge, too, it is the slope of what follows.

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
        with np.errstate(all="ignore"):  # far out squares and powers are infinite, and the slope 0
            slopes = np.asarray(self._slopes(np.where(np.isfinite(points), points, 0.0)), dtype=float)
        return keep_nan(points, np.where(np.isinf(points), 0.0, slopes))[()]

    @property
    def lower(self) -> Type1Set:
        """Lower membership function: that of a type-1 set is the set itself."""
        return self

    @property
    def upper(self) -> Type1Set:
        """Upper membership function: that of a type-1 set is the set itself."""
        return self

    @property
    def principal(self) -> Type1Set:
        """Principal membership function: that of a type-1 set is the set itself."""
        return self

    def secondary(self, x: float) -> Singleton:
        """Return the membership at a point as a vertical slice without uncertainty (eq. 1.3)."""
        return Singleton(float(self.membership(real("x", x))))

    def alpha_plane(self, alpha: float) -> Type1Set:
        """Return the set itself: its secondary grades are all 1."""
        return self

    @property
    def support(self) -> tuple[float, float]:
        """Ends of the smallest closed interval outside of which the membership is 0; they may be infinite."""
        return self._support()

    @property
    def maxima(self) -> tuple[float, float] | None:
        """First and last point of the greatest membership; None if it is approached but never reached."""
        return self._maxima()

    @property
    def core(self) -> tuple[float, float] | None:
        """First and last point of membership 1; None if there is none."""
        return self._maxima() if self.height >= 1.0 - ROUNDING else None

    @property
    def landmarks(self) -> Array:
        """Ascending finite points between which the membership is smooth, and beyond which little happens."""
        return self._landmarks()

    def is_normal(self) -> bool:
        """Return whether some point has membership 1."""
        return self.core is not None

    def is_convex(self) -> bool:
        """Return whether every α-cut is an interval: the membership rises to its maximum and then falls."""
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
            If the set is not convex: its cuts are not intervals.
        """
        grades = reals("alpha", alpha)
        if not ((grades >= 0.0) & (grades <= self.height + ROUNDING)).all():
            raise InvalidValue("alpha", alpha, f"from 0 to the height of the set, {self.height:.12g}")
        if self._maxima() is None and (grades >= self.height).any():
            raise InvalidValue("alpha", alpha, f"below {self.height:.12g}, which the membership approaches but never reaches")
        if not self.is_convex():
            raise NotApplicable("alpha_cut", "the set is not convex, so that a cut need not be an interval")
        left, right = self._cut(np.minimum(grades, self.height))
        first, last = self._support()
        return np.where(grades > 0.0, left, first)[()], np.where(grades > 0.0, right, last)[()]

    def quadrature_points(self, power: int = 1) -> Array:
        r"""Return ascending points from end to end of the integral of :math:`|x|^{power} \mu(x)`, power 0 or 1.

        Raises
        ------
        NotApplicable
            If the integral diverges.
        """
        return self._quadrature_points(power)

    def moments(self, origin: float, power: int = 1) -> Moments:
        """Return area and first moment of the membership about ``origin``, whole and up to any point."""
        return Moments(self._grades, self._quadrature_points(power), origin)

    def centroid(self) -> float:
        r"""Return the centroid on the continuous domain, by quadrature (eq. 1.68).

        .. math:: c_A = \frac{\int x\, \mu_A(x)\, dx}{\int \mu_A(x)\, dx}

        Returns
        -------
        float
            The centroid; of a single point, the point.

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
        """Return the set as a row of numbers for the compiled kernels; None if only Python can evaluate it.

        Returns
        -------
        tuple of 9 floats or None
            ``(0, m1, m2, sigma_lower, sigma_upper, height_lower, height_upper, 0, 0)``: a pair of Gaussians, the upper one about
            the mean nearest to the point between m1 and m2, the lower one about the end that is farther from it.
            ``(1, a, b, c, d, height, 0, 0, 0)``: a trapezoid.
        """
        return self._kernel_row()


@dataclass(frozen=True)
class Gaussian(Type1Set):
    r"""Gaussian set.

    .. math:: \mu(x) = h \exp\left(-\frac{(x - m)^2}{2 \sigma^2}\right)

    Parameters
    ----------
    mean, sigma : float
        Mean and standard deviation, sigma above 0.
    height : float
        Greatest membership, in (0, 1].

    Raises
    ------
    InvalidValue
        If a parameter is outside of its range.
    """

    mean: float
    sigma: float
    height: float = 1.0

    def __post_init__(self) -> None:
        set_fields(self, mean=real("mean", self.mean), sigma=positive("sigma", self.sigma), height=grade("height", self.height))

    def _grades(self, x: Array) -> Array:
        return gaussian(x, self.mean, self.sigma, self.height)

    def _slopes(self, x: Array) -> Array:
        return gaussian_slopes(x, self.mean, self.sigma, self.height)

    def _support(self) -> tuple[float, float]:
        return -math.inf, math.inf

    def _maxima(self) -> tuple[float, float]:
        return self.mean, self.mean

    def _cut(self, alpha: Array) -> tuple[Array, Array]:
        reach = gaussian_reach(alpha, self.sigma, self.height)
        return self.mean - reach, self.mean + reach

    def _landmarks(self) -> Array:
        return self.mean + self.sigma * _mirrored(_GAUSSIAN_SPREAD)

    def _quadrature_points(self, power: int) -> Array:
        return self.mean + self.sigma * _mirrored(np.concatenate([_GAUSSIAN_SPREAD, _GAUSSIAN_TAIL]))

    def _kernel_row(self) -> KernelRow:
        return 0.0, self.mean, self.mean, self.sigma, self.sigma, self.height, self.height, 0.0, 0.0


@dataclass(frozen=True)
class Trapezoidal(Type1Set):
    r"""Trapezoidal set: 0 up to a, rising to the height at b, falling from c to 0 at d.

    .. math:: \mu(x) = h \max\left(0, \min\left(\frac{x - a}{b - a}, 1, \frac{d - x}{d - c}\right)\right)

    Parameters
    ----------
    a, b, c, d : float
        Corners in ascending order. Equal ones make an edge vertical; the edge belongs to the set. ``a = b = -inf`` and
        ``c = d = inf`` make a shoulder that never ends.
    height : float
        Greatest membership, in (0, 1].

    Raises
    ------
    InvalidValue
        If the corners are not in order or the height is outside of its range.
    """

    a: float
    b: float
    c: float
    d: float
    height: float = 1.0

    def __post_init__(self) -> None:
        a, b, c, d = (maybe_infinite(name, getattr(self, name)) for name in "abcd")
        ascending("a, b, c, d", (a, b, c, d))
        if (math.isinf(a) and (a, b) != (-math.inf, -math.inf)) or b == math.inf:
            raise InvalidValue("a, b", (a, b), "finite, or both -inf for a shoulder that never ends")
        if (math.isinf(d) and (c, d) != (math.inf, math.inf)) or c == -math.inf:
            raise InvalidValue("c, d", (c, d), "finite, or both inf for a shoulder that never ends")
        set_fields(self, a=a, b=b, c=c, d=d, height=grade("height", self.height))

    def _grades(self, x: Array) -> Array:
        return trapezoid(x, self.a, self.b, self.c, self.d, self.height)

    def _slopes(self, x: Array) -> Array:
        return trapezoid_slopes(x, self.a, self.b, self.c, self.d, self.height)

    def _support(self) -> tuple[float, float]:
        return self.a, self.d

    def _maxima(self) -> tuple[float, float]:
        return self.b, self.c

    def _cut(self, alpha: Array) -> tuple[Array, Array]:
        return trapezoid_cut(alpha / self.height, self.a, self.b, self.c, self.d)

    def _landmarks(self) -> Array:
        corners = np.array([self.a, self.b, self.c, self.d])
        finite = corners[np.isfinite(corners)]
        return merged(finite) if finite.size else np.zeros(1)

    def _kernel_row(self) -> KernelRow:
        return 1.0, self.a, self.b, self.c, self.d, self.height, 0.0, 0.0, 0.0


@dataclass(frozen=True)
class Triangular(Type1Set):
    r"""Triangular set.

    .. math:: \mu(x) = h \max\left(0, \min\left(\frac{x - l}{p - l}, \frac{r - x}{r - p}\right)\right)

    Parameters
    ----------
    left, peak, right : float
        Corners in ascending order; two equal ones make an edge vertical.
    height : float
        Greatest membership, in (0, 1].

    Raises
    ------
    InvalidValue
        If the corners are not finite and in order, or the height is outside of its range.
    """

    left: float
    peak: float
    right: float
    height: float = 1.0

    def __post_init__(self) -> None:
        corners = real("left", self.left), real("peak", self.peak), real("right", self.right)
        ascending("left, peak, right", corners)
        set_fields(self, left=corners[0], peak=corners[1], right=corners[2], height=grade("height", self.height))

    def _grades(self, x: Array) -> Array:
        return trapezoid(x, self.left, self.peak, self.peak, self.right, self.height)

    def _slopes(self, x: Array) -> Array:
        return trapezoid_slopes(x, self.left, self.peak, self.peak, self.right, self.height)

    def _support(self) -> tuple[float, float]:
        return self.left, self.right

    def _maxima(self) -> tuple[float, float]:
        return self.peak, self.peak

    def _cut(self, alpha: Array) -> tuple[Array, Array]:
        return trapezoid_cut(alpha / self.height, self.left, self.peak, self.peak, self.right)

    def _landmarks(self) -> Array:
        return merged((self.left, self.peak, self.right))

    def _kernel_row(self) -> KernelRow:
        return 1.0, self.left, self.peak, self.peak, self.right, self.height, 0.0, 0.0, 0.0


@dataclass(frozen=True)
class Interval(Type1Set):
    """Interval: membership 1 from ``left`` to ``right``, ends included, and 0 elsewhere.

    Parameters
    ----------
    left, right : float
        Ends in ascending order.

    Raises
    ------
    InvalidValue
        If the ends are not finite and in order.
    """

    left: float
    right: float

    def __post_init__(self) -> None:
        ends = real("left", self.left), real("right", self.right)
        ascending("left, right", ends)
        set_fields(self, left=ends[0], right=ends[1])

    def _grades(self, x: Array) -> Array:
        return keep_nan(x, (x >= self.left) & (x <= self.right))

    def _slopes(self, x: Array) -> Array:
        return np.zeros_like(x)

    def _support(self) -> tuple[float, float]:
        return self.left, self.right

    def _maxima(self) -> tuple[float, float]:
        return self.left, self.right

    height = 1.0

    def _cut(self, alpha: Array) -> tuple[Array, Array]:
        return np.full_like(alpha, self.left), np.full_like(alpha, self.right)

    def _landmarks(self) -> Array:
        return merged((self.left, self.right))

    def _kernel_row(self) -> KernelRow:
        return 1.0, self.left, self.left, self.right, self.right, 1.0, 0.0, 0.0, 0.0


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


@dataclass(frozen=True)
class Bell(Type1Set):
    r"""Generalized bell.

    .. math:: \mu(x) = \frac{1}{1 + \left|\frac{x - c}{w}\right|^{2 s}}

    Parameters
    ----------
    center : float
        Point :math:`c` of membership 1.
    width : float
        Distance :math:`w` from the center at which the membership is 1/2; above 0.
    slope : float
        Exponent :math:`s`, above 0. Its area is finite for a slope above 1/2, and its centroid for one above 1.

    Raises
    ------
    InvalidValue
        If a parameter is outside of its range.
    """

    center: float
    width: float
    slope: float

    def __post_init__(self) -> None:
        set_fields(self, center=real("center", self.center), width=positive("width", self.width), slope=positive("slope", self.slope))

    def _grades(self, x: Array) -> Array:
        with np.errstate(over="ignore"):  # far out the power is infinite and the grade 0
            return np.asarray(1.0 / (1.0 + abs((x - self.center) / self.width) ** (2.0 * self.slope)))

    def _slopes(self, x: Array) -> Array:
        distance = abs(x - self.center) / self.width
        power = distance ** (2.0 * self.slope)
        # Powers of less than 1 only: within the width that of the distance, beyond it that of its reciprocal.
        near = distance ** (2.0 * self.slope - 1.0) / (1.0 + power) ** 2
        far = 1.0 / (distance * power * (1.0 + 1.0 / power) ** 2)
        steepness = 2.0 * self.slope / self.width * np.where(distance <= 1.0, near, far)
        return np.where(x < self.center, steepness, -steepness)

    def _support(self) -> tuple[float, float]:
        return -math.inf, math.inf

    def _maxima(self) -> tuple[float, float]:
        return self.center, self.center

    height = 1.0

    def _cut(self, alpha: Array) -> tuple[Array, Array]:
        with np.errstate(divide="ignore", over="ignore"):
            reach = self.width * (1.0 / alpha - 1.0) ** (0.5 / self.slope)
        return self.center - reach, self.center + reach

    def _landmarks(self) -> Array:
        return self.center + self.width * _mirrored(np.array([0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 2.0, 4.0, 8.0]))

    def _quadrature_points(self, power: int) -> Array:
        # The integral beyond 2^k widths falls as 2^(-k decay). 56 halvings are double precision.
        decay = 2.0 * self.slope - 1.0 - power
        octaves = 56.0 / decay if decay > 0.0 else math.inf
        if octaves > 1000.0 / (power + 1):
            what = "centroid" if power else "area"
            needed = 0.5 * (1.0 + power)
            raise NotApplicable(
                what,
                f"a bell has a finite {what} for a slope above {needed:g}, and one that converges above "
                f"{0.5 * (1.0 + power + 0.056 * (power + 1)):.3g}; got {self.slope:.6g}",
            )
        tail = 2.0 ** np.arange(4.0, math.ceil(max(octaves, 4.0)) + 4.0)
        near = np.array([0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 2.0, 4.0, 8.0])
        return self.center + self.width * _mirrored(np.concatenate([near, tail]))


@dataclass(frozen=True)
class Sigmoid(Type1Set):
    r"""Sigmoid: a shoulder that rises with a positive slope and falls with a negative one.

    .. math:: \mu(x) = \frac{1}{1 + e^{-s (x - c)}}

    Parameters
    ----------
    center : float
        Point :math:`c` of membership 1/2.
    slope : float
        Slope :math:`s`, not 0.

    Raises
    ------
    InvalidValue
        If a parameter is not finite, or the slope is 0.
    """

    center: float
    slope: float

    def __post_init__(self) -> None:
        set_fields(self, center=real("center", self.center), slope=real("slope", self.slope, "a finite number other than 0"))
        if self.slope == 0.0:
            raise InvalidValue("slope", self.slope, "a finite number other than 0")

    def _grades(self, x: Array) -> Array:
        steps = self.slope * (x - self.center)
        tail = np.exp(-abs(steps))
        return np.where(steps < 0.0, tail, 1.0) / (1.0 + tail)

    def _slopes(self, x: Array) -> Array:
        tail = np.exp(-abs(self.slope * (x - self.center)))
        return self.slope * tail / (1.0 + tail) ** 2

    def _support(self) -> tuple[float, float]:
        return -math.inf, math.inf

    def _maxima(self) -> None:
        return None

    height = 1.0

    def _cut(self, alpha: Array) -> tuple[Array, Array]:
        with np.errstate(divide="ignore"):
            edge = self.center + (np.log(alpha) - np.log1p(-alpha)) / self.slope
        end = np.full_like(edge, math.copysign(math.inf, self.slope))
        return (edge, end) if self.slope > 0.0 else (end, edge)

    def _landmarks(self) -> Array:
        return self.center + _mirrored(np.array([1.0, 2.0, 4.0, 8.0, 16.0, 32.0])) / abs(self.slope)

    def _quadrature_points(self, power: int) -> NoReturn:
        raise NotApplicable("centroid", f"the area of {self!r} is infinite: a sigmoid never comes back to 0")


@dataclass(frozen=True)
class FunctionalSet(Type1Set):
    """Set given by any function of the points.

    What is not known of the function (height, maxima, cuts, convexity) is read from samples: at the landmarks, and at 64 points
    between each two of them. It is as accurate as that grid.

    Parameters
    ----------
    function : callable
        From points (...,) to grades (...,) in [0, 1].
    left, right : float
        Ends of the support; the membership is 0 outside, whatever the function says. They may be infinite; then there is no centroid.
    knots : sequence of float
        Points where the function has kinks or narrow peaks, and for an unbounded support the range that matters.
    slope : callable, optional
        Derivative of the function, from points (...,) to derivatives (...,); at a kink from the right. Without it the set has none.

    Raises
    ------
    InvalidValue
        If the ends are not in order, or nothing finite says where the set is.
    """

    function: Callable[[Array], Array]
    left: float
    right: float
    knots: tuple[float, ...] = ()
    slope: Callable[[Array], Array] | None = None

    def __post_init__(self) -> None:
        left, right = maybe_infinite("left", self.left), maybe_infinite("right", self.right)
        ascending("left, right", (left, right))
        set_fields(self, left=left, right=right, knots=tuple(real("knots", knot) for knot in self.knots))
        if self._landmarks().size < 2 and left != right:
            raise InvalidValue("knots", self.knots, "at least two points when the support is unbounded, to say where the set is")

    @property
    def height(self) -> float:
        """Supremum of the membership, as sampled."""
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
        """Return where the membership first reaches alpha (...,) on the way through samples: bisection between two of them."""
        after = np.minimum(np.searchsorted(np.maximum.accumulate(grades), alpha, side="left"), len(points) - 1)
        below, reached = points[np.maximum(after - 1, 0)], points[after]
        for _ in range(60):
            middle = 0.5 * (below + reached)
            enough = self._grades(middle) >= alpha
            below, reached = np.where(enough, below, middle), np.where(enough, middle, reached)
        return np.asarray(reached)

    def is_convex(self) -> bool:
        """Return whether the membership rises to its maximum and then falls, as sampled."""
        return self._sampled.is_convex()


@dataclass(frozen=True)
class Truncated(Type1Set):
    """Set cut off outside of an interval: its membership there is 0.

    Parameters
    ----------
    whole : Type1Set
        The set before it is cut.
    left, right : float
        Ends of the interval, which must meet the support of the set.

    Raises
    ------
    InvalidValue
        If the ends are not finite and in order, or nothing of the set is left.
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
            raise InvalidValue("left, right", ends, f"ends of an interval that meets the support {(first, last)}")

    @property
    def height(self) -> float:
        """Supremum of the membership within the interval."""
        return float(self._highest[0])

    @cached_property
    def _highest(self) -> tuple[float, float, float]:
        """Height, and first and last point of it."""
        first, last = self._support()
        if not self.whole.is_convex():
            sampled = self._sampled
            return sampled.height, *sampled._maxima()
        maxima = self.whole.maxima
        # A convex set cut off beside its maximum is highest at the cut; one that never reaches it, at the higher end.
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
        """Return whether the whole set is convex, or what is left of it."""
        return self.whole.is_convex() or self._sampled.is_convex()


@dataclass(frozen=True, eq=False)
class SampledSet(Type1Set):
    """Set given by points and their grades: a discrete set, or samples of a continuous one.

    Between the points the membership is interpolated linearly, outside of them it is 0. As a discrete set it is ``.points`` with
    ``.grades``; joins, meets and embedded sets read it so.

    Parameters
    ----------
    points : (N,) array_like
        Points, in any order. Those within 1e-12 of each other (less, relatively, for points below 1e-6) are one, of the greatest
        of their grades.
    grades : (N,) array_like
        Grades in [0, 1], not all of them 0.

    Raises
    ------
    InvalidValue
        If the points are not finite, or the grades not in [0, 1], or their numbers differ or are 0.
    """

    points: Array
    grades: Array

    def __init__(self, points: ArrayLike, grades: ArrayLike) -> None:
        x, u = reals("points", points), reals("grades", grades)
        if x.ndim != 1 or x.size == 0 or not np.isfinite(x).all():
            raise InvalidValue("points", points, "finite numbers of shape (N,) with N of at least 1")
        if u.shape != x.shape or not ((u >= 0.0) & (u <= 1.0 + ROUNDING)).all():
            raise InvalidValue("grades", grades, f"in [0, 1], one for each of the {x.size} points")
        order = np.argsort(x, kind="stable")
        x, u = x[order], np.minimum(u[order], 1.0)
        # The distance at which points merge is absolute in the unit interval, and must not swallow whole sets of tiny numbers.
        apart = min(ROUNDING, 1e-6 * max(-float(x[0]), float(x[-1])))
        starts = np.flatnonzero(np.concatenate([[True], np.diff(x) > apart]))
        x, u = x[starts], np.maximum.reduceat(u, starts)
        x.flags.writeable = u.flags.writeable = False
        set_fields(self, points=x, grades=u)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, SampledSet):
            return NotImplemented
        return np.array_equal(self.points, other.points) and np.array_equal(self.grades, other.grades)

    def __hash__(self) -> int:
        # Zeros of both signs are equal, so they must hash alike.
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
        # Nothing before the first point, the slopes between the points, nothing from the last point on.
        slopes = np.concatenate([[0.0], np.diff(self.grades) / np.diff(self.points), [0.0]])
        return np.asarray(slopes[np.searchsorted(self.points, x, side="right")])

    def _support(self) -> tuple[float, float]:
        positive_ones = np.flatnonzero(self.grades > 0.0)
        if positive_ones.size == 0:
            return float(self.points[0]), float(self.points[-1])
        first, last = max(int(positive_ones[0]) - 1, 0), min(int(positive_ones[-1]) + 1, self.points.size - 1)
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
        """Return whether the grades rise to their maximum and then fall, up to rounding."""
        envelope = np.minimum(np.maximum.accumulate(self.grades), np.maximum.accumulate(self.grades[::-1])[::-1])
        return bool((self.grades >= envelope - ROUNDING).all())


def gaussian(x: Array, mean: ArrayLike, sigma: ArrayLike, height: ArrayLike = 1.0) -> Array:
    r"""Return :math:`h\,e^{-(x - m)^2 / (2 \sigma^2)}`; all arguments broadcast."""
    with np.errstate(over="ignore", under="ignore"):  # far out the square is infinite and the grade 0
        return np.asarray(height * np.exp(-0.5 * np.square((x - np.asarray(mean)) / sigma)))


def gaussian_slopes(x: Array, mean: ArrayLike, sigma: float, height: float = 1.0) -> Array:
    r"""Return the derivative of a Gaussian, :math:`-\mu(x)\,(x - m)/\sigma^2`; points and means broadcast."""
    grades = gaussian(x, mean, sigma, height)
    return np.where(grades > 0.0, (np.asarray(mean) - x) / sigma * grades / sigma, 0.0)


def gaussian_reach(alpha: Array, sigma: ArrayLike, height: ArrayLike = 1.0) -> Array:
    r"""Return the distance from the mean at which a Gaussian falls to alpha, :math:`\sigma\sqrt{2 \ln(h/\alpha)}`."""
    with np.errstate(divide="ignore", invalid="ignore"):
        reach = np.sqrt(2.0 * np.maximum(np.log(np.divide(height, alpha)), 0.0))
    return np.asarray(np.multiply(sigma, reach))


def trapezoid(x: Array, a: float, b: float, c: float, d: float, height: float) -> Array:
    """Return the membership of a trapezoid with corners in ascending order; vertical edges belong to it."""
    with np.errstate(over="ignore"):  # edges of almost no width
        rise = (x - a) / (b - a) if b > a else np.where(x >= a, 1.0, 0.0)
        fall = (d - x) / (d - c) if d > c else np.where(x <= d, 1.0, 0.0)
    return keep_nan(x, height * np.clip(np.minimum(rise, fall), 0.0, 1.0))


def trapezoid_slopes(x: Array, a: float, b: float, c: float, d: float, height: float) -> Array:
    """Return the derivative of the membership of a trapezoid from the right: at a corner that of the edge behind it."""
    rising, falling = (x >= a) & (x < b), (x >= c) & (x < d)
    rise = height / (b - a) if b > a else 0.0
    fall = height / (d - c) if d > c else 0.0
    return np.where(rising, rise, np.where(falling, -fall, 0.0))


def trapezoid_cut(fraction: Array, a: float, b: float, c: float, d: float) -> tuple[Array, Array]:
    """Return the ends of the cut of a trapezoid at a fraction (...,) of its height."""
    left = a + fraction * (b - a) if b > a else np.full_like(fraction, a)
    right = d - fraction * (d - c) if d > c else np.full_like(fraction, d)
    return left, right


def refined(landmarks: Array, count: int = 64) -> Array:
    """Return landmarks (P,) with ``count`` points between each two of them, and the floats on both sides of each: it may be a jump."""
    steps = np.arange(1, count + 1) / (count + 1)
    between = landmarks[:-1, None] + np.diff(landmarks)[:, None] * steps
    return merged(between, landmarks, np.nextafter(landmarks, -np.inf), np.nextafter(landmarks, np.inf))


def _first_reach(alpha: Array, points: Array, grades: Array) -> Array:
    """Return the first point at which grades interpolated between ascending points reach alpha (...,)."""
    envelope = np.maximum.accumulate(grades)
    after = np.minimum(np.searchsorted(envelope, alpha - ROUNDING, side="left"), len(points) - 1)
    before = np.maximum(after - 1, 0)
    rise = envelope[after] - envelope[before]
    with np.errstate(invalid="ignore", divide="ignore"):
        fraction = np.where(rise > 0.0, np.clip((alpha - envelope[before]) / rise, 0.0, 1.0), 1.0)
    return np.asarray(points[before] + fraction * (points[after] - points[before]))


def sampled_closely(fuzzy_set: Type1Set) -> SampledSet:
    """Return a set sampled between its landmarks, and ever closer around its maximum, on which cuts and normality hang."""
    points = np.clip(refined(fuzzy_set.landmarks), *fuzzy_set.support)
    for _ in range(6):  # 2^-30 of a step is enough where the membership is flat
        points = merged(points)
        best = int(np.argmax(fuzzy_set(points)))
        points = np.concatenate([points, np.linspace(points[max(best - 1, 0)], points[min(best + 1, len(points) - 1)], 65)])
    return fuzzy_set.sample(points)


def keep_nan(x: Array, grades: Array | NDArray[np.bool_]) -> Array:
    """Return grades as floats, NaN where the point is NaN."""
    return np.where(np.isnan(x), np.nan, grades)


def set_fields(frozen: object, **fields: object) -> None:
    """Set fields of a frozen dataclass while it is being made."""
    for name, value in fields.items():
        object.__setattr__(frozen, name, value)


@dataclass(frozen=True)
class PiShaped(Type1Set):
    r"""Set with smooth shoulders: a trapezoid whose sides are two parabolas each, so that they meet the top and the zero without a kink.

    .. math::
        \mu(x) = h \min\left(S\left(\frac{x - a}{b - a}\right), S\left(\frac{d - x}{d - c}\right)\right), \qquad
        S(t) = \begin{cases} 2 t^2 & 0 \le t \le 1/2 \\ 1 - 2 (1 - t)^2 & 1/2 \le t \le 1 \end{cases}

    with :math:`S` constant beyond 0 and 1. S-shaped sets are ``PiShaped(a, b, inf, inf)``, Z-shaped ones ``PiShaped(-inf, -inf, c, d)``.

    Parameters
    ----------
    a, b, c, d : float
        Foot, shoulder, shoulder and foot in ascending order, as of a :class:`Trapezoidal`.
    height : float
        Greatest membership, in (0, 1].

    Raises
    ------
    InvalidValue
        If the points are not in order or the height is outside of its range.
    """

    a: float
    b: float
    c: float
    d: float
    height: float = 1.0

    def __post_init__(self) -> None:
        checked = Trapezoidal(self.a, self.b, self.c, self.d, self.height)
        set_fields(self, a=checked.a, b=checked.b, c=checked.c, d=checked.d, height=checked.height)

    def _shares(self, x: Array) -> tuple[Array, Array]:
        """Return how far points are up the left side and the right one, each in [0, 1]."""
        return trapezoid(x, self.a, self.b, math.inf, math.inf, 1.0), trapezoid(x, -math.inf, -math.inf, self.c, self.d, 1.0)

    def _grades(self, x: Array) -> Array:
        share = np.minimum(*self._shares(x))
        return np.asarray(self.height * np.where(share < 0.5, 2.0 * share**2, 1.0 - 2.0 * (1.0 - share) ** 2))

    def _slopes(self, x: Array) -> Array:
        slopes = np.zeros_like(x)
        for share, width in zip(self._shares(x), (self.b - self.a, self.c - self.d), strict=True):
            if math.isfinite(width) and width != 0.0:
                slopes += 4.0 * self.height * np.minimum(share, 1.0 - share) / width
        return keep_nan(x, slopes)

    def _support(self) -> tuple[float, float]:
        return self.a, self.d

    def _maxima(self) -> tuple[float, float]:
        return self.b, self.c

    def _cut(self, alpha: Array) -> tuple[Array, Array]:
        fraction = alpha / self.height
        share = np.where(fraction < 0.5, np.sqrt(0.5 * fraction), 1.0 - np.sqrt(0.5 * np.maximum(1.0 - fraction, 0.0)))
        return trapezoid_cut(share, self.a, self.b, self.c, self.d)

    def _landmarks(self) -> Array:
        points = np.array([self.a, 0.5 * self.a + 0.5 * self.b, self.b, self.c, 0.5 * self.c + 0.5 * self.d, self.d])
        finite = points[np.isfinite(points)]
        return merged(finite) if finite.size else np.zeros(1)


@dataclass(frozen=True)
class TwoSidedGaussian(Type1Set):
    r"""Gaussian with a mean and a standard deviation of its own on each side.

    .. math:: \mu(x) = \exp\left(-\frac{\max(m_1 - x, 0)^2}{2 \sigma_1^2} - \frac{\max(x - m_2, 0)^2}{2 \sigma_2^2}\right)

    Between the means, if they are in ascending order, the membership is 1; if they are not, it stays below 1.

    Parameters
    ----------
    mean : (m1, m2)
        Mean of the left side and of the right one.
    sigma : (s1, s2)
        Standard deviation of the left side and of the right one, above 0. One may be infinite: a shoulder that never ends. Then the
        mean of that side does not matter, and becomes the other one.

    Raises
    ------
    InvalidValue
        If a parameter is outside of its range, or the means are so far apart in descending order that nothing is left.
    """

    mean: tuple[float, float]
    sigma: tuple[float, float]

    def __post_init__(self) -> None:
        requirement = "two numbers above 0, at most one of them infinite"
        means, sigmas = _two("mean", self.mean, "two finite numbers"), _two("sigma", self.sigma, requirement)
        if not all(map(math.isfinite, means)):
            raise InvalidValue("mean", self.mean, "two finite numbers")
        if min(sigmas) <= 0.0 or all(map(math.isinf, sigmas)):
            raise InvalidValue("sigma", self.sigma, requirement)
        ends = [end for end, sigma in zip(means, sigmas, strict=True) if math.isfinite(sigma)]
        set_fields(self, mean=(ends[0], ends[-1]), sigma=sigmas)
        if self.height == 0.0:
            raise InvalidValue("mean", self.mean, "so near to each other, or in such an order, that the membership is not 0 everywhere")

    @property
    def height(self) -> float:
        """Greatest membership: 1 unless the left mean is right of the right one."""
        return math.exp(-0.5 * min((self.mean[0] - self.mean[1]) / math.hypot(*self.sigma), 100.0) ** 2) if self._crossed else 1.0

    @property
    def _crossed(self) -> bool:
        return self.mean[0] > self.mean[1]

    def _distances(self, x: Array) -> tuple[Array, Array]:
        """Return how far points are out on the left side and on the right one, in standard deviations, at least 0."""
        (left, right), (first, second) = self.mean, self.sigma
        none = np.where(np.isnan(x), np.nan, 0.0)
        return (
            np.maximum((left - x) / first, 0.0) if math.isfinite(first) else none,
            np.maximum((x - right) / second, 0.0) if math.isfinite(second) else none,
        )

    def _grades(self, x: Array) -> Array:
        left, right = self._distances(x)
        with np.errstate(over="ignore", under="ignore"):  # far out the square is infinite and the grade 0
            return np.asarray(np.exp(-0.5 * (left**2 + right**2)))

    def _slopes(self, x: Array) -> Array:
        left, right = self._distances(x)
        grades = self._grades(x)
        with np.errstate(invalid="ignore"):  # 0 times infinity
            return np.where(grades == 0.0, 0.0, grades * (left / self.sigma[0] - right / self.sigma[1]))

    def _support(self) -> tuple[float, float]:
        return -math.inf, math.inf

    def _maxima(self) -> tuple[float, float]:
        (left, right), (first, second) = self.mean, self.sigma
        if self._crossed:
            share = 1.0 / (1.0 + (second / first) ** 2)
            peak = right * share + left * (1.0 - share)
            return peak, peak
        return left if math.isfinite(first) else -math.inf, right if math.isfinite(second) else math.inf

    def _cut(self, alpha: Array) -> tuple[Array, Array]:
        (left, right), (first, second) = self.mean, self.sigma
        reach = gaussian_reach(alpha, 1.0)
        low = left - first * reach if math.isfinite(first) else np.full_like(reach, -math.inf)
        high = right + second * reach if math.isfinite(second) else np.full_like(reach, math.inf)
        if not self._crossed:
            return low, high
        # Between crossed means both sides count, and their product is a Gaussian, too.
        peak, _ = self._maxima()
        near = first * second / math.hypot(first, second) * gaussian_reach(alpha, 1.0, self.height)
        return np.where(peak - near >= right, peak - near, low), np.where(peak + near <= left, peak + near, high)

    def _points(self, spread: Array) -> Array:
        (left, right), (first, second) = self.mean, self.sigma
        distances = np.concatenate([[0.0], spread])
        sides = [left - first * distances] if math.isfinite(first) else []
        sides += [right + second * distances] if math.isfinite(second) else []
        return merged(*sides, [end for end in self._maxima() if math.isfinite(end)])

    def _landmarks(self) -> Array:
        return self._points(_GAUSSIAN_SPREAD)

    def _quadrature_points(self, power: int) -> Array:
        if not all(map(math.isfinite, self.sigma)):
            raise NotApplicable("centroid", f"the area of {self!r} is infinite: a shoulder never comes back to 0")
        return self._points(np.concatenate([_GAUSSIAN_SPREAD, _GAUSSIAN_TAIL]))


class _TwoSigmoids(Type1Set):
    """What the combinations of two sigmoids share; what has no closed form is searched as of a :class:`FunctionalSet`."""

    center: tuple[float, float]
    slope: tuple[float, float]

    def _check(self) -> None:
        requirement = "two finite numbers other than 0"
        centers, slopes = _two("center", self.center, "two finite numbers"), _two("slope", self.slope, requirement)
        for name, given, wanted in (("center", centers, "two finite numbers"), ("slope", slopes, requirement)):
            if not all(map(math.isfinite, given)):
                raise InvalidValue(name, given, wanted)
        if 0.0 in slopes:
            raise InvalidValue("slope", slopes, requirement)
        set_fields(self, center=centers, slope=slopes)

    def _steps(self, x: Array) -> tuple[Array, Array]:
        """Return the exponents of both sigmoids at points; beyond 800 a sigmoid is 0 or 1."""
        with np.errstate(over="ignore"):
            first, second = (slope * (x - center) for center, slope in zip(self.center, self.slope, strict=True))
        return np.clip(first, -800.0, 800.0), np.clip(second, -800.0, 800.0)

    @cached_property
    def _searched(self) -> FunctionalSet:
        return FunctionalSet(self._grades, -math.inf, math.inf, tuple(self._points(_EXPONENTIAL_SPREAD).tolist()))

    def _support(self) -> tuple[float, float]:
        return -math.inf, math.inf

    def _cut(self, alpha: Array) -> tuple[Array, Array]:
        return self._searched._cut(alpha)

    def _points(self, spread: Array) -> Array:
        reaches = _mirrored(spread)
        return merged(*(center + reaches / abs(slope) for center, slope in zip(self.center, self.slope, strict=True)))

    def _landmarks(self) -> Array:
        return self._points(_EXPONENTIAL_SPREAD[:6])

    def _quadrature_points(self, power: int) -> Array:
        return self._points(_EXPONENTIAL_SPREAD)


@dataclass(frozen=True)
class SigmoidDifference(_TwoSigmoids):
    r"""Absolute difference of two sigmoids: one rises where the other has risen already, and between them the membership is near 1.

    .. math:: \mu(x) = \left| \frac{1}{1 + e^{-s_1 (x - c_1)}} - \frac{1}{1 + e^{-s_2 (x - c_2)}} \right|

    With slopes that differ the sigmoids cross, and there is a second, lower maximum beyond: then the set is not convex. With slopes of
    different signs it is a valley, with shoulders that never end.

    Parameters
    ----------
    center, slope : (float, float)
        Centers and slopes of the two sigmoids; the slopes not 0, and the sigmoids not the same.

    Raises
    ------
    InvalidValue
        If a parameter is outside of its range.
    """

    center: tuple[float, float]
    slope: tuple[float, float]

    def __post_init__(self) -> None:
        self._check()
        if self.slope[0] == self.slope[1] and self.center[0] == self.center[1]:
            raise InvalidValue("center", self.center, "different for equal slopes, or the membership is 0 everywhere")

    @property
    def _valley(self) -> bool:
        return (self.slope[0] > 0.0) != (self.slope[1] > 0.0)

    @property
    def height(self) -> float:
        """Supremum of the membership."""
        return 1.0 if self._valley else self._searched.height

    def _maxima(self) -> tuple[float, float] | None:
        return None if self._valley else self._searched._maxima()

    def _quadrature_points(self, power: int) -> Array:
        if self._valley:
            raise NotApplicable("centroid", f"the area of {self!r} is infinite: its shoulders never come back to 0")
        return super()._quadrature_points(power)

    def _grades(self, x: Array) -> Array:
        # The difference as a product, which keeps its digits where both sigmoids are near 1.
        first, second = self._steps(x)
        return np.asarray(-np.expm1(-abs(first - second)) * logistic(np.maximum(first, second)) * logistic(-np.minimum(first, second)))

    def _slopes(self, x: Array) -> Array:
        first, second = self._steps(x)
        rates = (slope * logistic(steps) * logistic(-steps) for slope, steps in zip(self.slope, (first, second), strict=True))
        # Where the sigmoids cross, the difference rises to the right.
        rise = np.subtract(*rates)
        return np.where(first == second, abs(rise), np.sign(first - second) * rise)

    def is_convex(self) -> bool:
        """Return whether the membership rises to its maximum and then falls, as sampled."""
        return self._searched.is_convex()


@dataclass(frozen=True)
class SigmoidProduct(_TwoSigmoids):
    r"""Product of two sigmoids: of a rising and a falling one, a bump with a slope of its own on each side.

    .. math:: \mu(x) = \frac{1}{1 + e^{-s_1 (x - c_1)}} \cdot \frac{1}{1 + e^{-s_2 (x - c_2)}}

    It is convex, because the logarithm of a sigmoid is concave.

    Parameters
    ----------
    center, slope : (float, float)
        Centers and slopes of the two sigmoids; the slopes not 0. With slopes of one sign the set is a shoulder.

    Raises
    ------
    InvalidValue
        If a parameter is not finite, a slope is 0, or the sigmoids are so far apart that nothing is left of their product.
    """

    center: tuple[float, float]
    slope: tuple[float, float]

    def __post_init__(self) -> None:
        self._check()
        if not self._end and not self._grades(self._points(_EXPONENTIAL_SPREAD)).any():
            raise InvalidValue("center", self.center, "so that the product is not 0 everywhere")

    @property
    def _end(self) -> float:
        """Where the membership is 1 of a shoulder: at the infinity of this sign; 0 if the set is none."""
        rising = [slope > 0.0 for slope in self.slope]
        return 0.0 if rising[0] != rising[1] else math.inf if rising[0] else -math.inf

    @property
    def height(self) -> float:
        """Supremum of the membership."""
        return 1.0 if self._end else self._searched.height

    def _grades(self, x: Array) -> Array:
        first, second = self._steps(x)
        with np.errstate(under="ignore"):
            return np.asarray(logistic(first) * logistic(second))

    def _slopes(self, x: Array) -> Array:
        first, second = self._steps(x)
        with np.errstate(under="ignore"):
            return np.asarray(self._grades(x) * (self.slope[0] * logistic(-first) + self.slope[1] * logistic(-second)))

    def _maxima(self) -> tuple[float, float] | None:
        return None if self._end else self._searched._maxima()

    def _cut(self, alpha: Array) -> tuple[Array, Array]:
        left, right = self._searched._cut(alpha)
        end = np.full_like(left, self._end)
        return (left, right) if not self._end else (left, end) if self._end > 0.0 else (end, right)

    def _quadrature_points(self, power: int) -> Array:
        if self._end:
            raise NotApplicable("centroid", f"the area of {self!r} is infinite: a shoulder never comes back to 0")
        return super()._quadrature_points(power)


@dataclass(frozen=True)
class Complement(Type1Set):
    r"""Complement of a set (eq. 1.11), as a rule says *is not*.

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
        """Least membership of the set, as sampled, and the first and the last point of it."""
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
        # Of everything the complement is nothing, and nothing has no ends.
        return (left, right) if left <= right else (-math.inf, math.inf)

    def _maxima(self) -> tuple[float, float] | None:
        first, last = self.whole.support
        if math.isfinite(first) or math.isfinite(last):
            return -math.inf if math.isfinite(first) else last, math.inf if math.isfinite(last) else first
        _, first, last = self._least
        # What a set with tails comes down to at infinity is never reached.
        return None if math.isinf(first) or math.isinf(last) else (first, last)

    def _landmarks(self) -> Array:
        points, (first, last) = self.whole.landmarks, self.whole.support
        width = float(points[-1] - points[0]) or 1.0
        # Where the set ends with a jump, the complement begins beyond it.
        jumps = [end + side * width for end, side in ((first, -1.0), (last, 1.0)) if math.isfinite(end) and self.whole(end) > 0.0]
        points = merged(points, jumps)
        return points if points.size > 1 else merged(points, points - 1.0, points + 1.0)

    @cached_property
    def _searched(self) -> FunctionalSet:
        return FunctionalSet(self._grades, *self._support(), tuple(self._landmarks().tolist()))

    @property
    def _falls(self) -> float:
        """The infinity towards which a convex set rises without end, so that its complement falls; 0 if there is none."""
        ends = self.whole(np.array([-math.inf, math.inf]))
        return 0.0 if ends.max() < self.whole.height - ROUNDING else -math.inf if ends[0] > ends[1] else math.inf

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
        """Return whether the membership rises to its maximum and then falls: the set is a shoulder, or, as sampled, has a valley."""
        return (self.whole.is_convex() and self._falls != 0.0) or self._searched.is_convex()


# Where a set with exponential tails is cut into pieces: exp(-745) is the last that is not zero in double precision.
_EXPONENTIAL_SPREAD = np.array([1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0, 128.0, 256.0, 512.0, 745.0])


def logistic(steps: Array) -> Array:
    """Return 1 / (1 + exp(-steps)) without overflow, and without losing digits on either tail."""
    tail = np.exp(-abs(steps))
    return np.asarray(np.where(steps < 0.0, tail, 1.0) / (1.0 + tail))


def _two(name: str, values: object, requirement: str) -> tuple[float, float]:
    """Return a pair of numbers, which may be infinite; raise :class:`InvalidValue` if it is none."""
    try:
        first, second = list(values)  # type: ignore[call-overload] # whatever is no pair is refused below
    except (TypeError, ValueError) as error:
        raise InvalidValue(name, values, requirement) from error
    return maybe_infinite(name, first, requirement), maybe_infinite(name, second, requirement)
