"""Fuzzy numbers held as α-cuts, with the arithmetic of the extension principle."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from fuzzy2.errors import InvalidValue, NotApplicable
from fuzzy2.numbers.affine import AffineNumber, GaussianNumber, IntervalNumber
from fuzzy2.numbers.base import Number, crisp_operand
from fuzzy2.operations.extension import LOWEST_LEVEL_OF_UNBOUNDED_SETS
from fuzzy2.sets.type1 import Type1Set
from fuzzy2.support.checks import Array, broadcast, reals, share


def _default_levels() -> Array:
    # The levels are dense near 0 and 1, where the cuts of smooth sets move fastest, and include 0
    # and 1.
    return np.asarray(0.5 * (1.0 - np.cos(np.linspace(0.0, np.pi, 129))))


Convertible: TypeAlias = "FuzzyNumber | IntervalNumber | GaussianNumber | Type1Set | ArrayLike"


@dataclass(frozen=True, eq=False)
class FuzzyNumber(Number):
    r"""Convex, normal fuzzy numbers of any shape, held as α-cuts.

    All four arithmetic operations are defined under the minimum t-norm.

    The α-cut of a result follows from the α-cuts of the operands by interval arithmetic (eq. 1.43
    with :math:`* = \wedge`),

    .. math:: (F \otimes G)_\alpha = \{v \otimes w : v \in F_\alpha, w \in G_\alpha\}

    This is exact at the stored levels; between two levels the ends are interpolated linearly. A set
    with unbounded support is cut off where its membership is 1e-6.

    Parameters
    ----------
    left, right : (..., L) array_like
        Ends of the cuts; the last axis runs over the levels.
    levels : (L,) array_like
        Levels, ascending from 0 to 1. The default holds 129, dense near 0 and near 1.

    Raises
    ------
    InvalidValue
        If the levels do not ascend from 0 to 1, the ends are not finite, or the cuts are not
        nested.

    Notes
    -----
    Nguyen, "A note on the extension principle for fuzzy sets" (1978).
    """

    left: Array
    right: Array
    levels: Array

    __hash__ = None  # type: ignore[assignment]  # arrays are compared by value and have no hash

    def __init__(self, left: ArrayLike, right: ArrayLike, levels: ArrayLike | None = None) -> None:
        heights = _default_levels() if levels is None else np.array(reals("levels", levels))
        if (
            heights.ndim != 1
            or heights.size < 2
            or heights[0] != 0.0
            or heights[-1] != 1.0
            or not (np.diff(heights) > 0.0).all()
        ):
            raise InvalidValue("levels", heights, "ascending from 0 to 1")
        lower, upper = (
            np.array(end)
            for end in broadcast("left and right", reals("left", left), reals("right", right))
        )
        if lower.shape[-1:] != heights.shape:
            raise InvalidValue(
                "the last axis of left and right",
                lower.shape,
                f"as long as the {heights.size} levels",
            )
        if not (np.isfinite(lower).all() and np.isfinite(upper).all()):
            raise InvalidValue("left and right", np.stack([lower, upper]), "finite")
        if (
            (lower > upper).any()
            or (np.diff(lower, axis=-1) < 0.0).any()
            or (np.diff(upper, axis=-1) > 0.0).any()
        ):
            raise InvalidValue(
                "left and right",
                np.stack([lower, upper]),
                "nested: each cut within those of lower levels",
            )
        for name, value in (("left", lower), ("right", upper), ("levels", heights)):
            value.setflags(write=False)
            object.__setattr__(self, name, value)

    @classmethod
    def of(
        cls,
        value: FuzzyNumber | IntervalNumber | GaussianNumber | Type1Set | ArrayLike,
        levels: ArrayLike | None = None,
    ) -> FuzzyNumber:
        """Return a fuzzy number with the α-cuts of a set or of other numbers.

        The value may be a convex type-1 set, interval or Gaussian numbers, or crisp numbers.

        Parameters
        ----------
        value : type-1 set, IntervalNumber, GaussianNumber or array_like
            What to convert.
        levels : (L,) array_like, optional
            Levels, ascending from 0 to 1.

        Raises
        ------
        NotApplicable
            If the set is not convex or not normal, if its cuts are unbounded, or if a Gaussian
            number has the product t-norm, for which α-cuts do not give the arithmetic.
        """
        if isinstance(value, FuzzyNumber):
            return value if levels is None else value.at_levels(levels)
        heights = _default_levels() if levels is None else reals("levels", levels)
        crisp = crisp_operand(value)
        if crisp is not None:
            ends = np.repeat(crisp[..., None], heights.size, axis=-1)
            return cls(ends, ends, heights)
        if isinstance(value, IntervalNumber):
            left, right = np.moveaxis(value.interval(), -1, 0)[..., None] * np.ones(heights.size)
            return cls(left, right, heights)
        if isinstance(value, GaussianNumber):
            if value.t_norm != "min":
                reason = (
                    'it uses the minimum; make the Gaussian numbers with t_norm="min" if that is '
                    "meant"
                )
                raise NotApplicable("arithmetic by α-cuts", reason)
            cut = np.stack(
                [
                    value.interval(max(float(level), LOWEST_LEVEL_OF_UNBOUNDED_SETS))
                    for level in heights
                ],
                axis=-2,
            )
            return cls(cut[..., 0], cut[..., 1], heights)
        if not isinstance(value, Type1Set):
            raise InvalidValue(
                "value", value, "a convex type-1 set, fuzzy numbers or crisp numbers"
            )
        return cls._of_set(value, heights)

    @classmethod
    def _of_set(cls, convex_set: Type1Set, heights: Array) -> FuzzyNumber:
        if not convex_set.is_normal():
            raise NotApplicable(
                "arithmetic by α-cuts",
                f"{convex_set!r} does not reach the membership 1, as a fuzzy number must",
            )
        lowest = 0.0 if np.isfinite(convex_set.support).all() else LOWEST_LEVEL_OF_UNBOUNDED_SETS
        # Rounding may leave the height slightly below 1.
        left, right = convex_set.alpha_cut(np.clip(heights, lowest, convex_set.height))
        if not (np.isfinite(left).all() and np.isfinite(right).all()):
            raise NotApplicable("arithmetic by α-cuts", f"the cuts of {convex_set!r} are unbounded")
        return cls(*_nested(left, right), heights)

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the array of numbers."""
        return self.left.shape[:-1]

    def __getitem__(self, index: Any) -> FuzzyNumber:
        keys = index if isinstance(index, tuple) else (index,)
        if any(key is Ellipsis for key in keys):
            return FuzzyNumber(
                self.left[(*keys, slice(None))], self.right[(*keys, slice(None))], self.levels
            )
        return FuzzyNumber(
            self.left[(*keys, ..., slice(None))], self.right[(*keys, ..., slice(None))], self.levels
        )

    def __eq__(self, other: object) -> bool:
        """Return whether all cuts are exactly equal."""
        if not isinstance(other, FuzzyNumber):
            return NotImplemented
        return all(
            np.array_equal(getattr(self, name), getattr(other, name))
            for name in ("left", "right", "levels")
        )

    def at_levels(self, levels: ArrayLike) -> FuzzyNumber:
        """Return the same numbers with their cuts interpolated linearly at other levels."""
        heights = reals("levels", levels)
        if heights.ndim != 1 or not ((heights >= 0.0) & (heights <= 1.0)).all():
            raise InvalidValue("levels", levels, "ascending from 0 to 1")
        if np.array_equal(heights, self.levels):
            return self
        return FuzzyNumber(
            *_nested(self._ends_at(self.left, heights), self._ends_at(self.right, heights)), heights
        )

    def _ends_at(self, ends: Array, heights: Array) -> Array:
        segment = np.clip(
            np.searchsorted(self.levels, heights, side="right") - 1, 0, self.levels.size - 2
        )
        fraction = (heights - self.levels[segment]) / (
            self.levels[segment + 1] - self.levels[segment]
        )
        return np.asarray(
            ends[..., segment] + fraction * (ends[..., segment + 1] - ends[..., segment])
        )

    def interval(self, alpha: float) -> Array:
        """Return the ends (..., 2) of the α-cuts, for 0 <= alpha <= 1."""
        heights = np.array([share("alpha", alpha, "a level from 0 to 1")])
        return np.concatenate(
            [self._ends_at(self.left, heights), self._ends_at(self.right, heights)], axis=-1
        )

    def __call__(self, x: ArrayLike) -> Array:
        """Return the memberships at x; see `membership`."""
        return self.membership(x)

    def membership(self, x: ArrayLike) -> Array:
        """Return the memberships at x; the shape of x broadcasts with that of the numbers.

        NaN gives NaN.
        """
        points, _ = broadcast("x and the numbers", reals("x", x), self.left[..., 0])
        shape = points.shape
        left, right = (
            np.broadcast_to(end, (*shape, self.levels.size)) for end in (self.left, self.right)
        )
        grades = np.minimum(
            _level_reached(left, points, self.levels), _level_reached(-right, -points, self.levels)
        )
        return np.where(np.isnan(points), np.nan, grades)

    def defuzzify(self) -> Array:
        r"""Return the centroids (...).

        They are exact if the ends :math:`l, r` of the cuts are linear between levels.

        .. math:: \frac{\int_0^1 (r^2 - l^2)\,d\alpha}{2 \int_0^1 (r - l)\,d\alpha}

        The centroid of a number without width is its only point.
        """
        # Moments are taken about the middle of the support, where the squares cancel least.
        origin = 0.5 * (self.left[..., :1] + self.right[..., :1])
        left, right = self.left - origin, self.right - origin
        area = _integral_of_linear(right - left, self.levels)
        moment = 0.5 * (
            _integral_of_square(right, self.levels) - _integral_of_square(left, self.levels)
        )
        wide = area > 0.0
        return np.asarray(origin[..., 0] + np.where(wide, moment / np.where(wide, area, 1.0), 0.0))

    def _paired(self, other: object) -> tuple[FuzzyNumber, FuzzyNumber] | None:
        """Return both operands at all levels of both, or None if one is not a number."""
        if (
            not isinstance(other, (FuzzyNumber, AffineNumber, Type1Set))
            and crisp_operand(other) is None
        ):
            return None
        second = (
            other
            if isinstance(other, FuzzyNumber)
            else FuzzyNumber.of(
                other,  # type: ignore[arg-type]
                self.levels,
            )
        )
        if np.array_equal(self.levels, second.levels):
            return self, second
        common = np.union1d(self.levels, second.levels)
        return self.at_levels(common), second.at_levels(common)

    def _combined(
        self, other: object, ends: Callable[[FuzzyNumber, FuzzyNumber], tuple[Array, Array]]
    ) -> FuzzyNumber:
        pair = self._paired(other)
        return NotImplemented if pair is None else FuzzyNumber(*ends(*pair), pair[0].levels)

    def __neg__(self) -> FuzzyNumber:
        return FuzzyNumber(-self.right, -self.left, self.levels)

    def __add__(self, other: object) -> FuzzyNumber:
        return self._combined(other, lambda a, b: (a.left + b.left, a.right + b.right))

    def __radd__(self, other: object) -> FuzzyNumber:
        return self + other

    def __sub__(self, other: object) -> FuzzyNumber:
        return self._combined(other, lambda a, b: (a.left - b.right, a.right - b.left))

    def __rsub__(self, other: object) -> FuzzyNumber:
        return -self + other

    def __mul__(self, other: object) -> FuzzyNumber:
        return self._combined(other, _product_of_cuts)

    def __rmul__(self, other: object) -> FuzzyNumber:
        return self * other

    def __truediv__(self, other: object) -> FuzzyNumber:
        return self._combined(other, _quotient_of_cuts)

    def __rtruediv__(self, other: object) -> FuzzyNumber:
        pair = self._paired(other)
        return (
            NotImplemented
            if pair is None
            else FuzzyNumber(*_quotient_of_cuts(pair[1], pair[0]), pair[0].levels)
        )


def _nested(left: Array, right: Array) -> tuple[Array, Array]:
    """Return the cuts made exactly nested, because rounding in their formulas may cross them."""
    middle = 0.5 * (left[..., -1:] + right[..., -1:])
    return (
        np.minimum(np.maximum.accumulate(left, axis=-1), middle),
        np.maximum(np.minimum.accumulate(right, axis=-1), middle),
    )


def _product_of_cuts(a: FuzzyNumber, b: FuzzyNumber) -> tuple[Array, Array]:
    corners = np.stack(
        np.broadcast_arrays(a.left * b.left, a.left * b.right, a.right * b.left, a.right * b.right)
    )
    return corners.min(axis=0), corners.max(axis=0)


def _quotient_of_cuts(a: FuzzyNumber, b: FuzzyNumber) -> tuple[Array, Array]:
    contains_zero = (b.left[..., 0] <= 0.0) & (b.right[..., 0] >= 0.0)
    if contains_zero.any():
        supports = np.stack([b.left[..., 0], b.right[..., 0]], axis=-1)[contains_zero]
        raise InvalidValue(
            "the denominator", supports, "a fuzzy number whose support does not contain 0"
        )
    corners = np.stack(
        np.broadcast_arrays(a.left / b.left, a.left / b.right, a.right / b.left, a.right / b.right)
    )
    return corners.min(axis=0), corners.max(axis=0)


def _level_reached(left: Array, points: Array, levels: Array) -> Array:
    """Return the highest level whose left end is not to the right of the point.

    It is interpolated between levels, and 0 to the left of all ends.
    """
    # Ends repeat where the membership jumps, so the last end that the point has passed is used.
    passed = (left <= points[..., None]).sum(axis=-1)
    segment = np.clip(passed - 1, 0, levels.size - 2)
    start = np.take_along_axis(left, segment[..., None], axis=-1)[..., 0]
    width = np.take_along_axis(left, segment[..., None] + 1, axis=-1)[..., 0] - start
    fraction = np.clip(
        np.where(width > 0.0, (points - start) / np.where(width > 0.0, width, 1.0), 1.0), 0.0, 1.0
    )
    reached = levels[segment] * (1.0 - fraction) + levels[segment + 1] * fraction
    return np.asarray(np.where(passed == 0, 0.0, np.where(passed == levels.size, 1.0, reached)))


def _integral_of_linear(values: Array, levels: Array) -> Array:
    return np.asarray((0.5 * (values[..., 1:] + values[..., :-1]) * np.diff(levels)).sum(axis=-1))


def _integral_of_square(values: Array, levels: Array) -> Array:
    start, end = values[..., :-1], values[..., 1:]
    return np.asarray(((start**2 + start * end + end**2) / 3.0 * np.diff(levels)).sum(axis=-1))
