"""Sigmoids, and products and differences of two of them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import NoReturn

import numpy as np

from fuzzy2.errors import InvalidValue, NotApplicable
from fuzzy2.sets.curves import logistic, mirrored
from fuzzy2.sets.derived import FunctionalSet
from fuzzy2.sets.shapes import EXPONENTIAL_SPREAD
from fuzzy2.sets.type1 import KernelRow, Type1Set, pair_of_numbers, set_fields
from fuzzy2.support.checks import Array, real
from fuzzy2.support.quadrature import merged

LEAST_SLOPE = 1e-300
"""With a smaller slope a sigmoid extends beyond the range of floats."""

SLOPE = f"a finite number, {LEAST_SLOPE:g} or more from 0"


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
        If a parameter is not finite, or if the slope is 0 or so small that derived points overflow.
    """

    center: float
    slope: float

    def __post_init__(self) -> None:
        set_fields(
            self,
            center=real("center", self.center),
            slope=real("slope", self.slope, SLOPE),
        )
        if abs(self.slope) < LEAST_SLOPE:
            raise InvalidValue("slope", self.slope, SLOPE)

    def _grades(self, x: Array) -> Array:
        with np.errstate(over="ignore"):  # far out the exponent is infinite and the grade is 0 or 1
            steps = self.slope * (x - self.center)
        tail = np.exp(-abs(steps))
        return np.where(steps < 0.0, tail, 1.0) / (1.0 + tail)

    def _slopes(self, x: Array) -> Array:
        tail = np.exp(-abs(self.slope * (x - self.center)))
        return self.slope * tail / (1.0 + tail) ** 2

    def _kernel_row(self) -> KernelRow:
        return 6.0, self.center, self.slope, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0

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


class _TwoSigmoids(Type1Set):
    """Base of the combinations of two sigmoids.

    Properties without a closed form are found by sampling, as for a :class:`FunctionalSet`.
    """

    center: tuple[float, float]
    slope: tuple[float, float]

    def _check(self) -> None:
        requirement = f"two finite numbers, {LEAST_SLOPE:g} or more from 0"
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
        if min(map(abs, slopes)) < LEAST_SLOPE:
            raise InvalidValue("slope", slopes, requirement)
        set_fields(self, center=centers, slope=slopes)

    def _steps(self, x: Array) -> tuple[Array, Array]:
        """Return the exponents of both sigmoids, limited to ±800, where a sigmoid is 0 or 1."""
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

    def _row(self, kind: float) -> KernelRow:
        (first, second), (one, other) = self.center, self.slope
        return kind, first, one, second, other, 0.0, 0.0, 0.0, 0.0

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

    If both slopes have the same sign, the membership is near 1 between the two centers.

    .. math:: \mu(x) = \left| \frac{1}{1 + e^{-s_1 (x - c_1)}}
              - \frac{1}{1 + e^{-s_2 (x - c_2)}} \right|

    If the slopes differ, the sigmoids cross and there is a second, lower maximum beyond the
    crossing, so the set is not convex. If the slopes have different signs, the set is a valley with
    shoulders that never end.

    Parameters
    ----------
    center, slope : (float, float)
        Centers and slopes of the two sigmoids. The slopes must not be 0, and the sigmoids must
        differ.

    Raises
    ------
    InvalidValue
        If a parameter is outside its range.
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

    def _kernel_row(self) -> KernelRow:
        return self._row(9.0)

    def _grades(self, x: Array) -> Array:
        # The difference is written as a product, which keeps its digits where both sigmoids are
        # near 1.
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
        # Where the sigmoids cross, the absolute difference has a kink and rises to the right.
        rise = np.subtract(*rates)
        return np.where(first == second, abs(rise), np.sign(first - second) * rise)

    def is_convex(self) -> bool:
        """Return whether the sampled membership rises to its maximum and then falls."""
        return self._searched.is_convex()


@dataclass(frozen=True)
class SigmoidProduct(_TwoSigmoids):
    r"""Product of two sigmoids, for instance of a rising and a falling one.

    A rising and a falling sigmoid give a bump with its own slope on each side.

    .. math:: \mu(x) = \frac{1}{1 + e^{-s_1 (x - c_1)}} \cdot \frac{1}{1 + e^{-s_2 (x - c_2)}}

    It is convex, because the logarithm of a sigmoid is concave.

    Parameters
    ----------
    center, slope : (float, float)
        Centers and slopes of the two sigmoids. The slopes must not be 0. If they have the same
        sign, the set is a shoulder.

    Raises
    ------
    InvalidValue
        If a parameter is not finite, a slope is 0, or the sigmoids are so far apart that their
        product vanishes.
    """

    center: tuple[float, float]
    slope: tuple[float, float]

    def __post_init__(self) -> None:
        self._check()
        if not self._end and not self._grades(self._points(EXPONENTIAL_SPREAD)).any():
            raise InvalidValue("center", self.center, "so that the product is not 0 everywhere")

    @property
    def _end(self) -> float:
        """Infinity at which the membership of a shoulder is 1.

        It is 0 if the set is not a shoulder.
        """
        rising = [slope > 0.0 for slope in self.slope]
        return 0.0 if rising[0] != rising[1] else math.inf if rising[0] else -math.inf

    @property
    def height(self) -> float:
        """Supremum of the membership."""
        return 1.0 if self._end else self._searched.height

    def _kernel_row(self) -> KernelRow:
        return self._row(10.0)

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
