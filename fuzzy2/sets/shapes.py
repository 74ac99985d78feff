r"""Type-1 fuzzy sets: a membership grade in [0, 1] for every point of the real line.

All sets are immutable and vectorized: ``fuzzy_set(x)`` takes points of any shape and returns grades
of that shape, NaN where the point is NaN. A type-1 set is also a type-2 set without uncertainty:
``fuzzy_set.lower`` and ``fuzzy_set.upper`` are the set itself, so type-1 and type-2 terms can be
mixed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fuzzy2.errors import InvalidValue
from fuzzy2.sets.curves import (
    GAUSSIAN_SPREAD,
    GAUSSIAN_TAIL,
    gaussian,
    gaussian_reach,
    gaussian_slopes,
    mirrored,
    trapezoid,
    trapezoid_cut,
    trapezoid_slopes,
)
from fuzzy2.sets.type1 import KernelRow, Type1Set, keep_nan, set_fields
from fuzzy2.support.checks import Array, ascending, grade, maybe_infinite, positive, real
from fuzzy2.support.quadrature import merged


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
        If a parameter is outside its range.
    """

    mean: float
    sigma: float
    height: float = 1.0

    def __post_init__(self) -> None:
        set_fields(
            self,
            mean=real("mean", self.mean),
            sigma=positive("sigma", self.sigma),
            height=grade("height", self.height),
        )

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
        return self.mean + self.sigma * mirrored(GAUSSIAN_SPREAD)

    def _quadrature_points(self, power: int) -> Array:
        return self.mean + self.sigma * mirrored(np.concatenate([GAUSSIAN_SPREAD, GAUSSIAN_TAIL]))

    def _kernel_row(self) -> KernelRow:
        return 0.0, self.mean, self.mean, self.sigma, self.sigma, self.height, self.height, 0.0, 0.0


@dataclass(frozen=True)
class Trapezoidal(Type1Set):
    r"""Trapezoidal set: 0 up to a, rising to the height at b, falling from c to 0 at d.

    .. math:: \mu(x) = h \max\left(0,
              \min\left(\frac{x - a}{b - a}, 1, \frac{d - x}{d - c}\right)\right)

    Parameters
    ----------
    a, b, c, d : float
        Corners in ascending order. Equal ones make an edge vertical; the edge belongs to the set.
        ``a = b = -inf`` and ``c = d = inf`` make a shoulder that never ends.
    height : float
        Greatest membership, in (0, 1].

    Raises
    ------
    InvalidValue
        If the corners are not in order or the height is outside its range.
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
            raise InvalidValue(
                "a, b", (a, b), "finite, or both -inf for a shoulder that never ends"
            )
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

    .. math:: \mu(x) = h \max\left(0,
              \min\left(\frac{x - l}{p - l}, \frac{r - x}{r - p}\right)\right)

    Parameters
    ----------
    left, peak, right : float
        Corners in ascending order; two equal ones make an edge vertical.
    height : float
        Greatest membership, in (0, 1].

    Raises
    ------
    InvalidValue
        If the corners are not finite and in order, or the height is outside its range.
    """

    left: float
    peak: float
    right: float
    height: float = 1.0

    def __post_init__(self) -> None:
        corners = real("left", self.left), real("peak", self.peak), real("right", self.right)
        ascending("left, peak, right", corners)
        set_fields(
            self,
            left=corners[0],
            peak=corners[1],
            right=corners[2],
            height=grade("height", self.height),
        )

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


# Distances at which a set with exponential tails is cut into pieces. exp(-745) is the last value
# that is not zero in double precision.
EXPONENTIAL_SPREAD = np.array([1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0, 128.0, 256.0, 512.0, 745.0])
