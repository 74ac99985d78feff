"""Arrays of fuzzy numbers with an exact affine algebra.

`IntervalNumber` and `GaussianNumber` are closed under affine combinations (Theorems 1.4 and 1.5),
so a matrix of fuzzy numbers times a crisp vector costs two crisp products. `FuzzyNumber` does the
operations that are not affine: it holds the α-cuts of any convex fuzzy number and supports all four
arithmetic operations.

Operands are non-interactive, as usual in fuzzy arithmetic: ``a - a`` has the center 0 but twice the
spread.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from fuzzy2.errors import InvalidValue, NotApplicable
from fuzzy2.numbers.base import (
    Number,
    NumberTNorm,
    checked_level,
    crisp_operand,
    fields_of_one_shape,
)
from fuzzy2.support.checks import (
    Array,
    broadcast,
    known_name,
    reals,
    whole_number,
)


class AffineNumber(Number, ABC):
    """Array of fuzzy numbers that are described by two crisp arrays, of centers and of widths."""

    @property
    @abstractmethod
    def _location(self) -> Array: ...

    @property
    @abstractmethod
    def _width(self) -> Array: ...

    @abstractmethod
    def _with(self, location: Array, width: Array) -> Self:
        """Return numbers of the same kind with other centers and widths."""

    @abstractmethod
    def _combined_widths(self, widths: Array, coefficients: Array, subscripts: str) -> Array:
        """Return the widths of the sums of products that Einstein's subscripts describe."""

    @abstractmethod
    def _require_same_kind(self, other: AffineNumber, operation: str) -> None:
        """Raise if the sum with the other number is not closed within this kind."""

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the array of numbers."""
        return self._location.shape

    @property
    def ndim(self) -> int:
        """Number of axes."""
        return self._location.ndim

    def __len__(self) -> int:
        if not self.shape:
            raise TypeError("a single fuzzy number has no length")
        return self.shape[0]

    def __getitem__(self, index: Any) -> Self:
        return self._with(self._location[index], self._width[index])

    def reshape(self, *shape: int) -> Self:
        """Return the same numbers in another shape."""
        return self._with(self._location.reshape(*shape), self._width.reshape(*shape))

    def __eq__(self, other: object) -> bool:
        """Return whether all numbers are exactly equal."""
        if type(other) is not type(self):
            return NotImplemented
        return (
            np.array_equal(self._location, other._location)
            and np.array_equal(self._width, other._width)
            and getattr(self, "t_norm", None) == getattr(other, "t_norm", None)
        )

    __hash__ = None  # type: ignore[assignment]  # arrays are compared by value and have no hash

    def __neg__(self) -> Self:
        return self._with(-self._location, self._width)

    def __pos__(self) -> Self:
        return self

    def __add__(self, other: object) -> Self:
        crisp = crisp_operand(other)
        if crisp is not None:
            location = self._location + crisp
            return self._with(location, np.broadcast_to(self._width, location.shape).copy())
        if not isinstance(other, AffineNumber):
            return NotImplemented
        self._require_same_kind(other, "sum")
        location = self._location + other._location
        pairs = np.stack(
            [
                np.broadcast_to(self._width, location.shape),
                np.broadcast_to(other._width, location.shape),
            ]
        )
        return self._with(location, self._combined_widths(pairs, np.ones(2), "k...,k->..."))

    def __radd__(self, other: object) -> Self:
        return self + other

    def __sub__(self, other: object) -> Self:
        crisp = crisp_operand(other)
        if crisp is not None:
            return self + -crisp
        return self + -other if isinstance(other, AffineNumber) else NotImplemented

    def __rsub__(self, other: object) -> Self:
        return -self + other

    def __mul__(self, other: object) -> Self:
        crisp = crisp_operand(other)
        if crisp is not None:
            return self._with(self._location * crisp, self._width * np.abs(crisp))
        if isinstance(other, AffineNumber):
            raise NotApplicable(
                f"the exact algebra of {type(self).__name__}",
                "the product of two fuzzy numbers is not affine; use FuzzyNumber.of(...) * "
                "FuzzyNumber.of(...)",
            )
        return NotImplemented

    def __rmul__(self, other: object) -> Self:
        return self * other

    def __truediv__(self, other: object) -> Self:
        crisp = crisp_operand(other)
        if crisp is not None:
            if (crisp == 0.0).any():
                raise InvalidValue("the denominator", crisp, "different from 0")
            return self._with(self._location / crisp, self._width / np.abs(crisp))
        if isinstance(other, AffineNumber):
            raise NotApplicable(
                f"the exact algebra of {type(self).__name__}",
                "the quotient of two fuzzy numbers is not affine; use FuzzyNumber.of(...) / "
                "FuzzyNumber.of(...)",
            )
        return NotImplemented

    def __matmul__(self, vector: ArrayLike) -> Self:
        """Return the products of matrices of numbers and crisp vectors.

        (..., m, n) and (..., n) give (..., m), (n,) and (n,) give ().
        """
        crisp = crisp_operand(vector)
        if crisp is None:
            raise NotApplicable(
                "a product of matrices",
                "one factor must be crisp; the product of two fuzzy numbers is not affine",
            )
        _require_same_length(self.shape, crisp.shape)
        subscripts = "n,...n->..." if self.ndim == 1 else "...mn,...n->...m"
        location = np.einsum(subscripts, self._location, crisp)
        return self._with(location, self._combined_widths(self._width, crisp, subscripts))

    def __rmatmul__(self, matrix: ArrayLike) -> Self:
        """Return the products of crisp matrices and vectors of numbers.

        (..., m, n) and (..., n) give (..., m), (n,) and (n,) give ().
        """
        crisp = crisp_operand(matrix)
        if crisp is None:
            raise NotApplicable(
                "a product of matrices",
                "one factor must be crisp; the product of two fuzzy numbers is not affine",
            )
        _require_same_length(crisp.shape, self.shape)
        subscripts = "...n,n->..." if crisp.ndim == 1 else "...n,...mn->...m"
        location = np.einsum(subscripts, self._location, crisp)
        return self._with(location, self._combined_widths(self._width, crisp, subscripts))

    def sum(self, axis: int = -1) -> Self:
        """Return the sum along one axis."""
        if not -self.ndim <= whole_number("axis", axis, -self.ndim) < self.ndim:
            raise InvalidValue("axis", axis, f"one of the {self.ndim} axes")
        location, width = np.moveaxis(self._location, axis, -1), np.moveaxis(self._width, axis, -1)
        return self._with(
            location.sum(axis=-1),
            self._combined_widths(width, np.ones(width.shape[-1]), "...n,n->..."),
        )

    def defuzzify(self) -> Array:
        """Return the crisp centers, which are the centroids because the numbers are symmetric."""
        return self._location.copy()


def _require_same_length(matrix: tuple[int, ...], vector: tuple[int, ...]) -> None:
    if not matrix or not vector or matrix[-1] != vector[-1]:
        raise InvalidValue("the shapes of a product", (matrix, vector), "(..., m, n) and (..., n)")


def _checked_fields(
    location: ArrayLike, width: ArrayLike, names: tuple[str, str]
) -> tuple[Array, Array]:
    """Return both fields as read-only arrays of the same shape."""
    centers, widths = map(np.array, fields_of_one_shape(names, location, width))
    centers.setflags(write=False)
    widths.setflags(write=False)
    return centers, widths


@dataclass(frozen=True, eq=False)
class IntervalNumber(AffineNumber):
    r"""Interval fuzzy numbers: membership 1 on :math:`[c - s, c + s]` and 0 elsewhere.

    .. math:: \sum_i \alpha_i F_i + \beta = \Big[\text{center } \sum_i \alpha_i c_i + \beta,\
              \text{spread } \sum_i |\alpha_i| s_i\Big]

    is exact under any t-norm (Theorem 1.4, eq. 1.46-1.48).

    Parameters
    ----------
    center : (...) array_like
        Centers :math:`c`, of any shape.
    spread : (...) array_like
        Half-widths :math:`s`, at least 0, which are broadcast with the centers.

    Raises
    ------
    InvalidValue
        If a spread is negative.
    """

    center: Array
    spread: Array

    def __init__(self, center: ArrayLike, spread: ArrayLike) -> None:
        centers, spreads = _checked_fields(center, spread, ("center", "spread"))
        object.__setattr__(self, "center", centers)
        object.__setattr__(self, "spread", spreads)

    @classmethod
    def from_ends(cls, ends: ArrayLike) -> IntervalNumber:
        """Return the numbers with the given left and right ends (..., 2)."""
        pairs = reals("ends", ends)
        if pairs.shape[-1:] != (2,):
            raise InvalidValue("ends", pairs, "an array of shape (..., 2)")
        left, right = pairs[..., 0], pairs[..., 1]
        return cls(0.5 * (left + right), 0.5 * (right - left))

    @property
    def _location(self) -> Array:
        return self.center

    @property
    def _width(self) -> Array:
        return self.spread

    def _with(self, location: Array, width: Array) -> IntervalNumber:
        return IntervalNumber(location, width)

    def _combined_widths(self, widths: Array, coefficients: Array, subscripts: str) -> Array:
        return np.asarray(np.einsum(subscripts, widths, np.abs(coefficients)))

    def _require_same_kind(self, other: AffineNumber, operation: str) -> None:
        if not isinstance(other, IntervalNumber):
            raise NotApplicable(
                f"the exact {operation} of fuzzy numbers",
                f"{type(self).__name__} and {type(other).__name__} are of different kinds; use "
                "FuzzyNumber.of(...) for both",
            )

    def interval(self, alpha: float = 1.0) -> Array:
        """Return the ends (..., 2) of the α-cuts, which are the same for every level in (0, 1]."""
        checked_level(alpha)
        return np.stack([self.center - self.spread, self.center + self.spread], axis=-1)

    def __call__(self, x: ArrayLike) -> Array:
        """Return the memberships at x; see `membership`."""
        return self.membership(x)

    def membership(self, x: ArrayLike) -> Array:
        """Return the memberships at x; the shape of x broadcasts with that of the numbers.

        NaN gives NaN.
        """
        points, center = broadcast("x and the numbers", reals("x", x), self.center)
        distance = np.abs(points - center)
        return np.where(
            np.isnan(distance + self.spread), np.nan, (distance <= self.spread).astype(float)
        )


@dataclass(frozen=True, eq=False)
class GaussianNumber(AffineNumber):
    r"""Gaussian fuzzy numbers: membership :math:`\exp(-\tfrac12 ((x - m)/\sigma)^2)`.

    .. math::
        \sum_i \alpha_i F_i + \beta:\quad m = \sum_i \alpha_i m_i + \beta,\qquad
        \sigma = \begin{cases} \sqrt{\sum_i \alpha_i^2 \sigma_i^2} & \text{product t-norm} \\
        \sum_i |\alpha_i| \sigma_i & \text{minimum t-norm} \end{cases}

    is exact (Theorem 1.5, eq. 1.49-1.60).

    Parameters
    ----------
    mean : (...) array_like
        Means :math:`m`, of any shape.
    sigma : (...) array_like
        Standard deviations :math:`\sigma`, at least 0 (0 is a crisp number), which are broadcast
        with the means.
    t_norm : {"product", "min"}
        How the memberships of summands are combined.

    Raises
    ------
    InvalidValue
        If a standard deviation is negative.
    UnknownName
        If the t-norm is neither "product" nor "min".
    """

    mean: Array
    sigma: Array
    t_norm: NumberTNorm

    def __init__(self, mean: ArrayLike, sigma: ArrayLike, t_norm: NumberTNorm = "product") -> None:
        known_name("t-norm of Gaussian numbers", t_norm, ("product", "min"))
        means, sigmas = _checked_fields(mean, sigma, ("mean", "sigma"))
        object.__setattr__(self, "mean", means)
        object.__setattr__(self, "sigma", sigmas)
        object.__setattr__(self, "t_norm", t_norm)

    @property
    def _location(self) -> Array:
        return self.mean

    @property
    def _width(self) -> Array:
        return self.sigma

    def _with(self, location: Array, width: Array) -> GaussianNumber:
        return GaussianNumber(location, width, self.t_norm)

    def _combined_widths(self, widths: Array, coefficients: Array, subscripts: str) -> Array:
        if self.t_norm == "min":
            return np.asarray(np.einsum(subscripts, widths, np.abs(coefficients)))
        # Squares of widths below 1e-154 underflow and above 1e154 overflow; a common scale keeps
        # the root exact.
        scale = np.max(widths, initial=0.0) if np.isfinite(widths).all() else 0.0
        if scale == 0.0:
            scale = 1.0
        return np.asarray(
            scale * np.sqrt(np.einsum(subscripts, (widths / scale) ** 2, coefficients**2))
        )

    def _require_same_kind(self, other: AffineNumber, operation: str) -> None:
        if not isinstance(other, GaussianNumber):
            raise NotApplicable(
                f"the exact {operation} of fuzzy numbers",
                f"{type(self).__name__} and {type(other).__name__} are of different kinds; use "
                "FuzzyNumber.of(...) for both",
            )
        if other.t_norm != self.t_norm:
            raise NotApplicable(
                f"the exact {operation} of Gaussian numbers",
                f'their t-norms "{self.t_norm}" and "{other.t_norm}" differ (Theorem 1.5)',
            )

    def interval(self, alpha: float) -> Array:
        r"""Return the ends (..., 2) of the α-cuts, :math:`m \mp \sigma\sqrt{-2\ln\alpha}`.

        The level must satisfy :math:`0 < \alpha \le 1`.
        """
        reach = self.sigma * np.sqrt(-2.0 * np.log(checked_level(alpha)))
        return np.stack([self.mean - reach, self.mean + reach], axis=-1)

    def __call__(self, x: ArrayLike) -> Array:
        """Return the memberships at x; see `membership`."""
        return self.membership(x)

    def membership(self, x: ArrayLike) -> Array:
        """Return the memberships at x; the shape of x broadcasts with that of the numbers.

        NaN gives NaN.
        """
        points, mean = broadcast("x and the numbers", reals("x", x), self.mean)
        distance = points - mean
        crisp = self.sigma == 0.0
        with np.errstate(over="ignore", under="ignore"):  # far tails underflow to 0
            gaussian = np.exp(-0.5 * (distance / np.where(crisp, 1.0, self.sigma)) ** 2)
        return np.where(crisp & ~np.isnan(distance), (distance == 0.0).astype(float), gaussian)
