"""Type-1 sets with smooth shapes that are not Gaussians."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import NoReturn

import numpy as np

from fuzzy2.errors import InvalidValue, NotApplicable
from fuzzy2.sets.curves import (
    GAUSSIAN_SPREAD,
    GAUSSIAN_TAIL,
    gaussian_reach,
    logistic,
    mirrored,
    trapezoid,
    trapezoid_cut,
)
from fuzzy2.sets.derived import FunctionalSet
from fuzzy2.sets.shapes import EXPONENTIAL_SPREAD, Trapezoidal
from fuzzy2.sets.type1 import Type1Set, keep_nan, pair_of_numbers, set_fields
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
        If a parameter is outside of its range.
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
        with np.errstate(over="ignore"):  # far out the power is infinite and the grade 0
            return np.asarray(
                1.0 / (1.0 + abs((x - self.center) / self.width) ** (2.0 * self.slope))
            )

    def _slopes(self, x: Array) -> Array:
        distance = abs(x - self.center) / self.width
        power = distance ** (2.0 * self.slope)
        # Powers of less than 1 only: within the width that of the distance, beyond it that of its
        # reciprocal.
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
        return self.center + self.width * mirrored(
            np.array([0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 2.0, 4.0, 8.0])
        )

    def _quadrature_points(self, power: int) -> Array:
        # The integral beyond 2^k widths falls as 2^(-k decay). 56 halvings are double precision.
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
        set_fields(
            self,
            center=real("center", self.center),
            slope=real("slope", self.slope, "a finite number other than 0"),
        )
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
        return self.center + mirrored(np.array([1.0, 2.0, 4.0, 8.0, 16.0, 32.0])) / abs(self.slope)

    def _quadrature_points(self, power: int) -> NoReturn:
        raise NotApplicable(
            "centroid", f"the area of {self!r} is infinite: a sigmoid never comes back to 0"
        )


@dataclass(frozen=True)
class PiShaped(Type1Set):
    r"""Set with smooth shoulders.

    A trapezoid whose sides are two parabolas each, so that they meet the top and the zero without a
    kink.

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
    r"""Gaussian with a mean and a standard deviation of its own on each side.

    .. math:: \mu(x) = \exp\left(-\frac{\max(m_1 - x, 0)^2}{2 \sigma_1^2}
              - \frac{\max(x - m_2, 0)^2}{2 \sigma_2^2}\right)

    Between the means, if they are in ascending order, the membership is 1; if they are not, it
    stays below 1.

    Parameters
    ----------
    mean : (m1, m2)
        Mean of the left side and of the right one.
    sigma : (s1, s2)
        Standard deviation of the left side and of the right one, above 0. One may be infinite: a
        shoulder that never ends. Then the mean of that side does not matter, and becomes the other
        one.

    Raises
    ------
    InvalidValue
        If a parameter is outside of its range, or the means are so far apart in descending order
        that nothing is left.
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
        """Greatest membership: 1 unless the left mean is right of the right one."""
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
        """Return how far points are out on both sides, in standard deviations.

        On the left side and on the right one, at least 0.
        """
        (left, right), (first, second) = self.mean, self.sigma
        none = np.where(np.isnan(x), np.nan, 0.0)
        return (
            np.maximum((left - x) / first, 0.0) if math.isfinite(first) else none,
            np.maximum((x - right) / second, 0.0) if math.isfinite(second) else none,
        )

    def _grades(self, x: Array) -> Array:
        left, right = self._distances(x)
        # far out the square is infinite and the grade 0
        with np.errstate(over="ignore", under="ignore"):
            return np.asarray(np.exp(-0.5 * (left**2 + right**2)))

    def _slopes(self, x: Array) -> Array:
        left, right = self._distances(x)
        grades = self._grades(x)
        with np.errstate(invalid="ignore"):  # 0 times infinity
            return np.where(
                grades == 0.0, 0.0, grades * (left / self.sigma[0] - right / self.sigma[1])
            )

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
        # Between crossed means both sides count, and their product is a Gaussian, too.
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


class _TwoSigmoids(Type1Set):
    """What the combinations of two sigmoids share.

    What has no closed form is searched as of a :class:`FunctionalSet`.
    """

    center: tuple[float, float]
    slope: tuple[float, float]

    def _check(self) -> None:
        requirement = "two finite numbers other than 0"
        centers, slopes = (
            pair_of_numbers("center", self.center, "two finite numbers"),
            pair_of_numbers("slope", self.slope, requirement),
        )
        for name, given, wanted in (
            ("center", centers, "two finite numbers"),
            ("slope", slopes, requirement),
        ):
            if not all(map(math.isfinite, given)):
                raise InvalidValue(name, given, wanted)
        if 0.0 in slopes:
            raise InvalidValue("slope", slopes, requirement)
        set_fields(self, center=centers, slope=slopes)

    def _steps(self, x: Array) -> tuple[Array, Array]:
        """Return the exponents of both sigmoids at points; beyond 800 a sigmoid is 0 or 1."""
        with np.errstate(over="ignore"):
            first, second = (
                slope * (x - center) for center, slope in zip(self.center, self.slope, strict=True)
            )
        return np.clip(first, -800.0, 800.0), np.clip(second, -800.0, 800.0)

    @cached_property
    def _searched(self) -> FunctionalSet:
        return FunctionalSet(
            self._grades, -math.inf, math.inf, tuple(self._points(EXPONENTIAL_SPREAD).tolist())
        )

    def _support(self) -> tuple[float, float]:
        return -math.inf, math.inf

    def _cut(self, alpha: Array) -> tuple[Array, Array]:
        return self._searched._cut(alpha)

    def _points(self, spread: Array) -> Array:
        reaches = mirrored(spread)
        return merged(
            *(
                center + reaches / abs(slope)
                for center, slope in zip(self.center, self.slope, strict=True)
            )
        )

    def _landmarks(self) -> Array:
        return self._points(EXPONENTIAL_SPREAD[:6])

    def _quadrature_points(self, power: int) -> Array:
        return self._points(EXPONENTIAL_SPREAD)


@dataclass(frozen=True)
class SigmoidDifference(_TwoSigmoids):
    r"""Absolute difference of two sigmoids.

    One rises where the other has risen already, and between them the membership is near 1.

    .. math:: \mu(x) = \left| \frac{1}{1 + e^{-s_1 (x - c_1)}}
              - \frac{1}{1 + e^{-s_2 (x - c_2)}} \right|

    With slopes that differ the sigmoids cross, and there is a second, lower maximum beyond: then
    the set is not convex. With slopes of different signs it is a valley, with shoulders that never
    end.

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
            raise InvalidValue(
                "center",
                self.center,
                "different for equal slopes, or the membership is 0 everywhere",
            )

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
            raise NotApplicable(
                "centroid", f"the area of {self!r} is infinite: its shoulders never come back to 0"
            )
        return super()._quadrature_points(power)

    def _grades(self, x: Array) -> Array:
        # The difference as a product, which keeps its digits where both sigmoids are near 1.
        first, second = self._steps(x)
        return np.asarray(
            -np.expm1(-abs(first - second))
            * logistic(np.maximum(first, second))
            * logistic(-np.minimum(first, second))
        )

    def _slopes(self, x: Array) -> Array:
        first, second = self._steps(x)
        rates = (
            slope * logistic(steps) * logistic(-steps)
            for slope, steps in zip(self.slope, (first, second), strict=True)
        )
        # Where the sigmoids cross, the difference rises to the right.
        rise = np.subtract(*rates)
        return np.where(first == second, abs(rise), np.sign(first - second) * rise)

    def is_convex(self) -> bool:
        """Return whether the membership rises to its maximum and then falls, as sampled."""
        return self._searched.is_convex()


@dataclass(frozen=True)
class SigmoidProduct(_TwoSigmoids):
    r"""Product of two sigmoids, one rising and one falling.

    It is a bump with a slope of its own on each side.

    .. math:: \mu(x) = \frac{1}{1 + e^{-s_1 (x - c_1)}} \cdot \frac{1}{1 + e^{-s_2 (x - c_2)}}

    It is convex, because the logarithm of a sigmoid is concave.

    Parameters
    ----------
    center, slope : (float, float)
        Centers and slopes of the two sigmoids; the slopes not 0. With slopes of one sign the set is
        a shoulder.

    Raises
    ------
    InvalidValue
        If a parameter is not finite, a slope is 0, or the sigmoids are so far apart that nothing is
        left of their product.
    """

    center: tuple[float, float]
    slope: tuple[float, float]

    def __post_init__(self) -> None:
        self._check()
        if not self._end and not self._grades(self._points(EXPONENTIAL_SPREAD)).any():
            raise InvalidValue("center", self.center, "so that the product is not 0 everywhere")

    @property
    def _end(self) -> float:
        """Where the membership of a shoulder is 1: at the infinity of this sign.

        0 if the set is none.
        """
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
            return np.asarray(
                self._grades(x)
                * (self.slope[0] * logistic(-first) + self.slope[1] * logistic(-second))
            )

    def _maxima(self) -> tuple[float, float] | None:
        return None if self._end else self._searched._maxima()

    def _cut(self, alpha: Array) -> tuple[Array, Array]:
        left, right = self._searched._cut(alpha)
        end = np.full_like(left, self._end)
        return (left, right) if not self._end else (left, end) if self._end > 0.0 else (end, right)

    def _quadrature_points(self, power: int) -> Array:
        if self._end:
            raise NotApplicable(
                "centroid", f"the area of {self!r} is infinite: a shoulder never comes back to 0"
            )
        return super()._quadrature_points(power)
