"""Type-1 sets with smooth shapes that are not Gaussians."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fuzzy2.errors import InvalidValue, NotApplicable
from fuzzy2.sets.curves import (
    GAUSSIAN_SPREAD,
    GAUSSIAN_TAIL,
    gaussian_reach,
    mirrored,
    trapezoid,
    trapezoid_cut,
)
from fuzzy2.sets.shapes import Trapezoidal
from fuzzy2.sets.type1 import KernelRow, Type1Set, keep_nan, pair_of_numbers, set_fields
from fuzzy2.support.checks import Array, positive, real
from fuzzy2.support.quadrature import merged


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
        Exponent :math:`s`, above 0. Its area is finite for a slope above 1/2, and its centroid for
        one above 1.

    Raises
    ------
    InvalidValue
        If a parameter is outside its range.
    """

    center: float
    width: float
    slope: float

    def __post_init__(self) -> None:
        set_fields(
            self,
            center=real("center", self.center),
            width=positive("width", self.width),
            slope=positive("slope", self.slope),
        )

    def _grades(self, x: Array) -> Array:
        with np.errstate(over="ignore"):  # far out the power is infinite
            return np.asarray(
                1.0 / (1.0 + abs((x - self.center) / self.width) ** (2.0 * self.slope))
            )

    def _slopes(self, x: Array) -> Array:
        distance = abs(x - self.center) / self.width
        power = distance ** (2.0 * self.slope)
        # Only powers of numbers below 1 are taken: of the distance within the width, and of its
        # reciprocal beyond it.
        near = distance ** (2.0 * self.slope - 1.0) / (1.0 + power) ** 2
        far = 1.0 / (distance * power * (1.0 + 1.0 / power) ** 2)
        steepness = 2.0 * self.slope / self.width * np.where(distance <= 1.0, near, far)
        return np.where(x < self.center, steepness, -steepness)

    def _kernel_row(self) -> KernelRow:
        return 5.0, self.center, self.width, 2.0 * self.slope, 0.0, 0.0, 0.0, 0.0, 0.0

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
        return self.center + self.width * mirrored(
            np.array([0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 2.0, 4.0, 8.0])
        )

    def _quadrature_points(self, power: int) -> Array:
        # The integral beyond 2^k widths falls as 2^(-k decay), so 56 halvings reach double
        # precision.
        decay = 2.0 * self.slope - 1.0 - power
        octaves = 56.0 / decay if decay > 0.0 else math.inf
        if octaves > 1000.0 / (power + 1):
            what = "centroid" if power else "area"
            needed = 0.5 * (1.0 + power)
            raise NotApplicable(
                what,
                f"a bell has a finite {what} for a slope above {needed:g}, and one that "
                f"converges above {0.5 * (1.0 + power + 0.056 * (power + 1)):.3g}; got "
                f"{self.slope:.6g}",
            )
        tail = 2.0 ** np.arange(4.0, math.ceil(max(octaves, 4.0)) + 4.0)
        near = np.array([0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 2.0, 4.0, 8.0])
        return self.center + self.width * mirrored(np.concatenate([near, tail]))


@dataclass(frozen=True)
class PiShaped(Type1Set):
    r"""Trapezoid-like set with smooth sides.

    Each side consists of two parabolas, which meet the top and the zero line without a kink.

    .. math::
        \mu(x) = h \min\left(S\left(\frac{x - a}{b - a}\right),
        S\left(\frac{d - x}{d - c}\right)\right), \qquad
        S(t) = \begin{cases} 2 t^2 & 0 \le t \le 1/2 \\
        1 - 2 (1 - t)^2 & 1/2 \le t \le 1 \end{cases}

    with :math:`S` constant beyond 0 and 1. S-shaped sets are ``PiShaped(a, b, inf, inf)``, Z-shaped
    ones ``PiShaped(-inf, -inf, c, d)``.

    Parameters
    ----------
    a, b, c, d : float
        Foot, shoulder, shoulder and foot in ascending order, as for :class:`Trapezoidal`.
    height : float
        Greatest membership, in (0, 1].

    Raises
    ------
    InvalidValue
        If the points are not in order or the height is outside its range.
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
        """Return how far up the left and the right side the points are, each in [0, 1]."""
        return trapezoid(x, self.a, self.b, math.inf, math.inf, 1.0), trapezoid(
            x, -math.inf, -math.inf, self.c, self.d, 1.0
        )

    def _grades(self, x: Array) -> Array:
        share = np.minimum(*self._shares(x))
        return np.asarray(
            self.height * np.where(share < 0.5, 2.0 * share**2, 1.0 - 2.0 * (1.0 - share) ** 2)
        )

    def _slopes(self, x: Array) -> Array:
        slopes = np.zeros_like(x)
        for share, width in zip(self._shares(x), (self.b - self.a, self.c - self.d), strict=True):
            if math.isfinite(width) and width != 0.0:
                slopes += 4.0 * self.height * np.minimum(share, 1.0 - share) / width
        return keep_nan(x, slopes)

    def _kernel_row(self) -> KernelRow:
        return 7.0, self.a, self.b, self.c, self.d, self.height, 0.0, 0.0, 0.0

    def _support(self) -> tuple[float, float]:
        return self.a, self.d

    def _maxima(self) -> tuple[float, float]:
        return self.b, self.c

    def _cut(self, alpha: Array) -> tuple[Array, Array]:
        fraction = alpha / self.height
        share = np.where(
            fraction < 0.5,
            np.sqrt(0.5 * fraction),
            1.0 - np.sqrt(0.5 * np.maximum(1.0 - fraction, 0.0)),
        )
        return trapezoid_cut(share, self.a, self.b, self.c, self.d)

    def _landmarks(self) -> Array:
        points = np.array(
            [
                self.a,
                0.5 * self.a + 0.5 * self.b,
                self.b,
                self.c,
                0.5 * self.c + 0.5 * self.d,
                self.d,
            ]
        )
        finite = points[np.isfinite(points)]
        return merged(finite) if finite.size else np.zeros(1)


@dataclass(frozen=True)
class TwoSidedGaussian(Type1Set):
    r"""Gaussian with its own mean and standard deviation on each side.

    .. math:: \mu(x) = \exp\left(-\frac{\max(m_1 - x, 0)^2}{2 \sigma_1^2}
              - \frac{\max(x - m_2, 0)^2}{2 \sigma_2^2}\right)

    If the means are in ascending order, the membership between them is 1. Otherwise it stays below
    1.

    Parameters
    ----------
    mean : (m1, m2)
        Mean of the left side and of the right one.
    sigma : (s1, s2)
        Standard deviation of the left side and of the right one, above 0. If one is infinite, that
        side is a shoulder that never ends; its mean does not matter and is set to the other one.

    Raises
    ------
    InvalidValue
        If a parameter is outside its range, or if the means are in descending order and so far
        apart that the membership vanishes.
    """

    mean: tuple[float, float]
    sigma: tuple[float, float]

    def __post_init__(self) -> None:
        requirement = "two numbers above 0, at most one of them infinite"
        means, sigmas = (
            pair_of_numbers("mean", self.mean, "two finite numbers"),
            pair_of_numbers("sigma", self.sigma, requirement),
        )
        if not all(map(math.isfinite, means)):
            raise InvalidValue("mean", self.mean, "two finite numbers")
        if min(sigmas) <= 0.0 or all(map(math.isinf, sigmas)):
            raise InvalidValue("sigma", self.sigma, requirement)
        ends = [end for end, sigma in zip(means, sigmas, strict=True) if math.isfinite(sigma)]
        set_fields(self, mean=(ends[0], ends[-1]), sigma=sigmas)
        if self.height == 0.0:
            raise InvalidValue(
                "mean",
                self.mean,
                "so near to each other, or in such an order, that the membership is not 0 "
                "everywhere",
            )

    @property
    def height(self) -> float:
        """Greatest membership: 1 unless the left mean is to the right of the right one."""
        return (
            math.exp(
                -0.5 * min((self.mean[0] - self.mean[1]) / math.hypot(*self.sigma), 100.0) ** 2
            )
            if self._crossed
            else 1.0
        )

    @property
    def _crossed(self) -> bool:
        return self.mean[0] > self.mean[1]

    def _distances(self, x: Array) -> tuple[Array, Array]:
        """Return the distances of points from the two means, in standard deviations.

        The first is to the left of the left mean, the second to the right of the right mean; both
        are at least 0.
        """
        (left, right), (first, second) = self.mean, self.sigma
        none = np.where(np.isnan(x), np.nan, 0.0)
        return (
            np.maximum((left - x) / first, 0.0) if math.isfinite(first) else none,
            np.maximum((x - right) / second, 0.0) if math.isfinite(second) else none,
        )

    def _grades(self, x: Array) -> Array:
        left, right = self._distances(x)
        # far out the square overflows to infinity and the grade is 0
        with np.errstate(over="ignore", under="ignore"):
            return np.asarray(np.exp(-0.5 * (left**2 + right**2)))

    def _slopes(self, x: Array) -> Array:
        left, right = self._distances(x)
        grades = self._grades(x)
        with np.errstate(invalid="ignore"):  # 0 times infinity
            return np.where(
                grades == 0.0, 0.0, grades * (left / self.sigma[0] - right / self.sigma[1])
            )

    def _kernel_row(self) -> KernelRow:
        return 8.0, *self.mean, *self.sigma, 0.0, 0.0, 0.0, 0.0

    def _support(self) -> tuple[float, float]:
        return -math.inf, math.inf

    def _maxima(self) -> tuple[float, float]:
        (left, right), (first, second) = self.mean, self.sigma
        if self._crossed:
            share = 1.0 / (1.0 + (second / first) ** 2)
            peak = right * share + left * (1.0 - share)
            return peak, peak
        return left if math.isfinite(first) else -math.inf, right if math.isfinite(
            second
        ) else math.inf

    def _cut(self, alpha: Array) -> tuple[Array, Array]:
        (left, right), (first, second) = self.mean, self.sigma
        reach = gaussian_reach(alpha, 1.0)
        low = left - first * reach if math.isfinite(first) else np.full_like(reach, -math.inf)
        high = right + second * reach if math.isfinite(second) else np.full_like(reach, math.inf)
        if not self._crossed:
            return low, high
        # Between crossed means both sides contribute, and their product is a Gaussian as well.
        peak, _ = self._maxima()
        near = first * second / math.hypot(first, second) * gaussian_reach(alpha, 1.0, self.height)
        return np.where(peak - near >= right, peak - near, low), np.where(
            peak + near <= left, peak + near, high
        )

    def _points(self, spread: Array) -> Array:
        (left, right), (first, second) = self.mean, self.sigma
        distances = np.concatenate([[0.0], spread])
        sides = [left - first * distances] if math.isfinite(first) else []
        sides += [right + second * distances] if math.isfinite(second) else []
        return merged(*sides, [end for end in self._maxima() if math.isfinite(end)])

    def _landmarks(self) -> Array:
        return self._points(GAUSSIAN_SPREAD)

    def _quadrature_points(self, power: int) -> Array:
        if not all(map(math.isfinite, self.sigma)):
            raise NotApplicable(
                "centroid", f"the area of {self!r} is infinite: a shoulder never comes back to 0"
            )
        return self._points(np.concatenate([GAUSSIAN_SPREAD, GAUSSIAN_TAIL]))
