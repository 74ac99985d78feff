"""Scaled and lagged sets: the lower membership functions of MATLAB's type-2 sets."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fuzzy2.errors import InvalidValue
from fuzzy2.sets.type1 import Type1Set, keep_nan, set_fields
from fuzzy2.support.checks import Array, real
from fuzzy2.support.quadrature import merged


@dataclass(frozen=True)
class Lagged(Type1Set):
    r"""Scaled set that begins where another set has reached a given grade.

    .. math:: \mu(x) = s \, \max\!\left(0, \frac{\mu_A(x) - l}{1 - l}\right)

    with one lag :math:`l` left of the maximum of :math:`A` and another right of it. A lag of 1
    leaves only the points where :math:`A` is 1.

    Parameters
    ----------
    whole : Type1Set
        The set :math:`A`, convex unless both lags are 0.
    lags : (float, float)
        Lags of the left and the right side, in [0, 1].
    scale : float
        The scale :math:`s`, above 0 and at most 1.

    Raises
    ------
    InvalidValue
        If an argument is outside its range, or nothing of the set is left.
    """

    whole: Type1Set
    lags: tuple[float, float]
    scale: float = 1.0

    def __post_init__(self) -> None:
        if not isinstance(self.whole, Type1Set):
            raise InvalidValue("whole", self.whole, "a type-1 set")
        lags = tuple(real("lags", lag) for lag in self.lags)
        if len(lags) != 2 or not all(0.0 <= lag <= 1.0 for lag in lags):
            raise InvalidValue("lags", self.lags, "two numbers in [0, 1]")
        scale = real("scale", self.scale)
        if not 0.0 < scale <= 1.0:
            raise InvalidValue("scale", scale, "above 0, and at most 1")
        set_fields(self, lags=lags, scale=scale)
        if any(lags) and not self.whole.is_convex():
            raise InvalidValue("whole", self.whole, "a convex set, because it is lagged")
        if any(self.whole.height <= lag < 1.0 or self.whole.height < lag for lag in lags):
            raise InvalidValue("lags", lags, f"below the set's height, {self.whole.height:g}")

    @property
    def height(self) -> float:
        """Supremum of the membership."""
        return float(self._of(np.array(self.whole.height), np.array(max(self.lags))))

    def _of(self, grades: Array, lag: Array) -> Array:
        """Return the membership for given grades (...,) of the whole set, at a lag."""
        left = np.where(lag < 1.0, 1.0 - lag, 1.0)
        begun = np.where(lag < 1.0, (grades - lag) / left, np.where(grades >= 1.0, 1.0, 0.0))
        return np.asarray(self.scale * np.clip(begun, 0.0, 1.0))

    def _lag_at(self, x: Array) -> Array:
        maxima = self.whole.maxima
        if maxima is not None:
            turn = (
                0.5 * maxima[0] + 0.5 * maxima[1]
                if np.isfinite(maxima).all()
                else (maxima[1] if math.isinf(maxima[0]) else maxima[0])
            )
        else:
            ends = self.whole.landmarks
            turn = math.inf if self.whole(ends[0]) < self.whole(ends[-1]) else -math.inf
        return np.where(x < turn, *self.lags)

    def _grades(self, x: Array) -> Array:
        return keep_nan(x, self._of(np.asarray(self.whole(x)), self._lag_at(x)))

    def _slopes(self, x: Array) -> Array:
        lag = self._lag_at(x)
        inside = (np.asarray(self.whole(x)) >= lag) & (lag < 1.0)
        factor = np.where(inside, self.scale / np.where(lag < 1.0, 1.0 - lag, 1.0), 0.0)
        return np.asarray(factor * self.whole.derivative(x))

    def _support(self) -> tuple[float, float]:
        first, last = self.whole.support
        if self.lags[0] > 0.0:
            first = float(self.whole.alpha_cut(self.lags[0])[0])
        if self.lags[1] > 0.0:
            last = float(self.whole.alpha_cut(self.lags[1])[1])
        return first, last

    def _maxima(self) -> tuple[float, float] | None:
        return self.whole.maxima

    def _landmarks(self) -> Array:
        first, last = self._support()
        points = self.whole.landmarks
        ends = [end for end in (first, last) if math.isfinite(end)]
        return merged(points[(points >= first) & (points <= last)], ends)

    def _cut(self, alpha: Array) -> tuple[Array, Array]:
        share = np.asarray(alpha) / self.scale
        # Rounding must not produce a grade above the height of the set.
        left, right = (
            np.minimum(lag + (1.0 - lag) * share, self.whole.height) for lag in self.lags
        )
        return self.whole.alpha_cut(left)[0], self.whole.alpha_cut(right)[1]

    def is_convex(self) -> bool:
        """Return whether the whole set is convex."""
        return self.whole.is_convex()
