"""Vertical slices of general type-2 sets: maxima, cuts, and interpolation between two slices."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fuzzy2.errors import InvalidValue, NotApplicable
from fuzzy2.sets.type1 import ROUNDING, SampledSet, Type1Set, keep_nan, set_fields
from fuzzy2.support.checks import Array, ascending, grade
from fuzzy2.support.quadrature import merged

# number of α-cuts that are interpolated between two continuous vertical slices
LEVELS_BETWEEN_SLICES = 257


@dataclass(frozen=True)
class Staircase(Type1Set):
    """Convex set of stacked intervals, each with the grade of its level.

    It is the vertical slice of a set of zSlices.

    Parameters
    ----------
    levels : sequence of K floats
        Grades in (0, 1], ascending.
    lefts, rights : sequences of K floats
        Ends of the intervals. Each interval lies within the one before it, up to rounding errors.

    Raises
    ------
    InvalidValue
        If the levels are not ascending grades, or the intervals are not nested.
    """

    levels: tuple[float, ...]
    lefts: tuple[float, ...]
    rights: tuple[float, ...]

    def __post_init__(self) -> None:
        levels = tuple(grade("levels", level) for level in self.levels)
        ascending("levels", levels)
        lefts, rights = np.asarray(self.lefts, dtype=float), np.asarray(self.rights, dtype=float)
        if lefts.shape != (len(levels),) or rights.shape != (len(levels),):
            raise InvalidValue(
                "lefts, rights",
                (self.lefts, self.rights),
                f"{len(levels)} ends each, one for each level",
            )
        # Rounding may swap the ends of nested planes where they touch.
        tidy_lefts, tidy_rights = np.maximum.accumulate(lefts), np.minimum.accumulate(rights)
        strays = np.max(tidy_lefts - lefts) > ROUNDING or np.max(rights - tidy_rights) > ROUNDING
        if strays or (tidy_lefts > tidy_rights + 2.0 * ROUNDING).any():
            raise InvalidValue(
                "lefts, rights",
                (self.lefts, self.rights),
                "ends of intervals, each within the one before it",
            )
        tidy_rights = np.maximum(tidy_lefts, tidy_rights)
        set_fields(
            self,
            levels=levels,
            lefts=tuple(tidy_lefts.tolist()),
            rights=tuple(tidy_rights.tolist()),
        )

    @property
    def height(self) -> float:
        """Highest level."""
        return self.levels[-1]

    def _grades(self, x: Array) -> Array:
        # The ends may be rounded differently from the evaluated points.
        inside = (x[..., None] >= np.array(self.lefts) - ROUNDING) & (
            x[..., None] <= np.array(self.rights) + ROUNDING
        )
        return keep_nan(x, np.max(np.where(inside, self.levels, 0.0), axis=-1))

    def _slopes(self, x: Array) -> Array:
        return np.zeros_like(x)

    def _support(self) -> tuple[float, float]:
        return self.lefts[0], self.rights[0]

    def _maxima(self) -> tuple[float, float]:
        return self.lefts[-1], self.rights[-1]

    def _landmarks(self) -> Array:
        return merged(self.lefts, self.rights)

    def _cut(self, alpha: Array) -> tuple[Array, Array]:
        i = np.minimum(np.searchsorted(self.levels, alpha - ROUNDING), len(self.levels) - 1)
        return np.array(self.lefts)[i], np.array(self.rights)[i]


def maxima_of(vertical_slice: Type1Set) -> tuple[float, float]:
    """Return the first and last membership of greatest grade; refuse a slice that has none."""
    maxima = vertical_slice.maxima
    if maxima is None:
        raise NotApplicable(
            "principal",
            f"the secondary membership {vertical_slice!r} never reaches its greatest grade",
        )
    return maxima


def cuts_of(
    slices: Sequence[Type1Set], alpha: float, shape: tuple[int, ...]
) -> tuple[Array, Array]:
    """Return the ends of the α-cuts of vertical slices; 0 where a slice stays below alpha."""
    ends = np.zeros((len(slices), 2))
    for i, vertical_slice in enumerate(slices):
        if alpha == 0.0:
            ends[i] = vertical_slice.support
        elif alpha <= vertical_slice.height + ROUNDING:
            ends[i] = vertical_slice.alpha_cut(min(alpha, vertical_slice.height))
    return ends[:, 0].reshape(shape), ends[:, 1].reshape(shape)


def slice_between(before: Type1Set, after: Type1Set, share: float) -> SampledSet:
    """Return the slice that lies a given share of the way from one slice to another.

    Its α-cuts are interpolated with the same share.
    """
    highest = min(before.height, after.height)
    if isinstance(before, SampledSet) and isinstance(after, SampledSet):
        # both sides of both slices are straight between the levels
        levels = merged(before.grades, after.grades, highest)
    else:
        # Levels are denser toward both ends, where a rounded slice opens as a square root of the
        # level.
        levels = highest * np.sin(np.linspace(0.0, 0.5 * np.pi, LEVELS_BETWEEN_SLICES)) ** 2
    levels = levels[levels <= highest]
    (left0, right0), (left1, right1) = before.alpha_cut(levels), after.alpha_cut(levels)
    left, right = left0 + share * (left1 - left0), right0 + share * (right1 - right0)
    return SampledSet(np.concatenate([left, right]), np.concatenate([levels, levels]))
