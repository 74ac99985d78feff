"""Points of greatest grade, of samples or of a sampled function."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from fuzzy2.support.checks import Array

_SAME = 1e-12
"""Relative difference below which grades are equal to the greatest."""
_CLOSER_POINTS, _CLOSER_GRIDS = 17, 16


def maximum(
    points: Array, grades: Array, kind: str, function: Callable[[Array], Array] | None = None
) -> Array:
    """Return points (n,) of greatest grade.

    Parameters
    ----------
    points : (N,) or (n, N) array
        Ascending points.
    grades : (n, N) array
        Grades at the points.
    kind : str
        One of ``operators.MAXIMA``.
    function : callable, optional
        Maps points (n, q) to grades (n, q). With it, the points are samples of a continuous
        function whose maxima are refined. Without it, the points are a discrete set.

    Returns
    -------
    (n,) array
        The points; NaN where all grades are 0.
    """
    x = np.broadcast_to(points, grades.shape)
    rows = np.arange(len(x))
    if function is not None:
        x, grades = _with_peaks(x, grades, function)
    greatest = grades.max(axis=1, keepdims=True)
    high = np.logical_and(grades >= greatest * (1.0 - _SAME), greatest > 0.0)
    first, last = np.argmax(high, axis=1), x.shape[1] - 1 - np.argmax(high[:, ::-1], axis=1)
    left, right = x[rows, first], x[rows, last]
    if kind == "smallest_of_maxima":
        found = left
    elif kind == "largest_of_maxima":
        found = right
    elif kind == "middle_of_maxima":
        found = 0.5 * left + 0.5 * right
    elif kind == "mean_of_maxima":
        found = _mean(x, high, function is not None)
    elif kind == "largest_absolute_maximum":
        far = np.where(high, np.abs(x), -1.0).argmax(axis=1)
        found = x[rows, far]
    else:
        near = np.where(high, np.abs(x), np.inf).argmin(axis=1)
        found = x[rows, near]
        if function is not None:
            both = high[:, :-1] & high[:, 1:] & (x[:, :-1] <= 0.0) & (x[:, 1:] >= 0.0)
            found = np.where(both.any(axis=1), 0.0, found)
    return np.where(high.any(axis=1), found, np.nan)


def _mean(x: Array, high: NDArray[np.bool_], continuous: bool) -> Array:
    """Return the mean over the plateaus if there are any, otherwise over the points."""
    count = high.sum(axis=1)
    means = np.where(high, x, 0.0).sum(axis=1) / np.maximum(count, 1)
    if not continuous:
        return np.asarray(means)
    lengths = np.where(high[:, :-1] & high[:, 1:], np.diff(x, axis=1), 0.0)
    total = lengths.sum(axis=1)
    moments = (lengths * 0.5 * (x[:, :-1] + x[:, 1:])).sum(axis=1)
    # Plateaus no wider than a rounding error are points.
    wide = total > 1e-9 * (x[:, -1] - x[:, 0])
    return np.asarray(np.where(wide, moments / np.where(wide, total, 1.0), means))


def _with_peaks(x: Array, grades: Array, function: Callable[[Array], Array]) -> tuple[Array, Array]:
    """Return samples that include the first and the last maximum, up to rounding."""
    rows = np.arange(len(x))
    added, heights = [], []
    for side in (0, 1):
        best = (
            np.argmax(grades, axis=1)
            if side == 0
            else x.shape[1] - 1 - np.argmax(grades[:, ::-1], axis=1)
        )
        low = x[rows, np.maximum(best - 1, 0)]
        high = x[rows, np.minimum(best + 1, x.shape[1] - 1)]
        for _ in range(_CLOSER_GRIDS):
            grid = low[:, np.newaxis] + (high - low)[:, np.newaxis] * np.linspace(
                0.0, 1.0, _CLOSER_POINTS
            )
            values = function(grid)
            place = (
                np.argmax(values, axis=1)
                if side == 0
                else _CLOSER_POINTS - 1 - np.argmax(values[:, ::-1], axis=1)
            )
            low = grid[rows, np.maximum(place - 1, 0)]
            high = grid[rows, np.minimum(place + 1, _CLOSER_POINTS - 1)]
        added.append(grid[rows, place])
        heights.append(values[rows, place])
    points = np.concatenate([x, np.stack(added, axis=1)], axis=1)
    order = np.argsort(points, axis=1, kind="stable")
    joined = np.concatenate([grades, np.stack(heights, axis=1)], axis=1)
    return np.take_along_axis(points, order, axis=1), np.take_along_axis(joined, order, axis=1)
