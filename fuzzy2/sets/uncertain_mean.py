"""The membership functions that bound a Gaussian with an uncertain mean."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fuzzy2.sets.curves import gaussian, gaussian_reach, gaussian_slopes
from fuzzy2.sets.shapes import Gaussian
from fuzzy2.sets.type1 import Type1Set, set_fields
from fuzzy2.support.checks import Array, ascending_pair, positive
from fuzzy2.support.quadrature import merged


@dataclass(frozen=True)
class NearestMeanGaussian(Type1Set):
    """Upper membership function of a Gaussian with an uncertain mean.

    It is 1 between the means and a Gaussian outside them.

    Parameters
    ----------
    mean : (float, float)
        Smallest and largest mean.
    sigma : float
        Standard deviation, above 0.
    """

    mean: tuple[float, float]
    sigma: float

    height = 1.0

    def __post_init__(self) -> None:
        set_fields(
            self, mean=ascending_pair("mean", self.mean), sigma=positive("sigma", self.sigma)
        )

    def _grades(self, x: Array) -> Array:
        return gaussian(x, np.clip(x, *self.mean), self.sigma)

    def _slopes(self, x: Array) -> Array:
        return gaussian_slopes(x, np.clip(x, *self.mean), self.sigma)

    def _support(self) -> tuple[float, float]:
        return -math.inf, math.inf

    def _maxima(self) -> tuple[float, float]:
        return self.mean

    def _cut(self, alpha: Array) -> tuple[Array, Array]:
        reach = gaussian_reach(alpha, self.sigma)
        return self.mean[0] - reach, self.mean[1] + reach

    def _landmarks(self) -> Array:
        left, right = (Gaussian(mean, self.sigma).landmarks for mean in self.mean)
        return merged(left[left <= self.mean[0]], right[right >= self.mean[1]])

    def _quadrature_points(self, power: int) -> Array:
        left, right = (Gaussian(mean, self.sigma).quadrature_points(power) for mean in self.mean)
        return merged(left[left <= self.mean[0]], right[right >= self.mean[1]])


@dataclass(frozen=True)
class FarthestMeanGaussian(Type1Set):
    """Lower membership function of a Gaussian with an uncertain mean.

    It is the smaller of the two Gaussians with the extreme means.

    Parameters
    ----------
    mean : (float, float)
        Smallest and largest mean.
    sigma : float
        Standard deviation, above 0.
    """

    mean: tuple[float, float]
    sigma: float

    def __post_init__(self) -> None:
        set_fields(
            self, mean=ascending_pair("mean", self.mean), sigma=positive("sigma", self.sigma)
        )

    @property
    def _middle(self) -> float:
        return 0.5 * self.mean[0] + 0.5 * self.mean[1]

    @property
    def height(self) -> float:
        """Membership midway between the means."""
        return float(self._grades(np.array(self._middle)))

    def _grades(self, x: Array) -> Array:
        return gaussian(x, np.where(x > self._middle, *self.mean), self.sigma)

    def _slopes(self, x: Array) -> Array:
        # Both Gaussians are equal midway between the means; to the right, the one with the smaller
        # mean is lower.
        return gaussian_slopes(x, np.where(x >= self._middle, *self.mean), self.sigma)

    def _support(self) -> tuple[float, float]:
        return -math.inf, math.inf

    def _maxima(self) -> tuple[float, float]:
        return self._middle, self._middle

    def _cut(self, alpha: Array) -> tuple[Array, Array]:
        reach = gaussian_reach(alpha, self.sigma)
        # If alpha is the height, both ends are the middle, and rounding must not swap them.
        return np.minimum(self.mean[1] - reach, self._middle), np.maximum(
            self.mean[0] + reach, self._middle
        )

    def _landmarks(self) -> Array:
        left, right = (Gaussian(mean, self.sigma).landmarks for mean in self.mean)
        return merged(left, right, self._middle)

    def _quadrature_points(self, power: int) -> Array:
        left, right = (Gaussian(mean, self.sigma).quadrature_points(power) for mean in self.mean)
        return merged(left, right, self._middle)
