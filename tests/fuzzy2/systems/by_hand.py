"""Systems of two inputs, and what they give worked out by hand."""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import NDArray

import fuzzy2

Array = NDArray[np.float64]

GRID_RULES = np.array(list(itertools.product(range(2), repeat=3)))

CENTERS = (-1.0, 1.0)


def uncertain(width: float = 0.2) -> list[list[fuzzy2.GaussianUncertainMean]]:
    return [
        [fuzzy2.GaussianUncertainMean(mean=(c - width, c + width), sigma=0.8) for c in CENTERS]
        for _ in range(3)
    ]


def gaussian() -> list[list[fuzzy2.Gaussian]]:
    return [[fuzzy2.Gaussian(mean=c, sigma=0.8) for c in CENTERS] for _ in range(3)]


def principal(sigma: float = 0.05) -> list[list[fuzzy2.GaussianType2Set]]:
    return [
        [
            fuzzy2.GaussianType2Set(principal=fuzzy2.Gaussian(mean=c, sigma=0.8), sigma=sigma)
            for c in CENTERS
        ]
        for _ in range(3)
    ]


def strengths_by_hand(
    inputs: list[list[fuzzy2.GaussianUncertainMean]], rules: Array, x: Array, norm: str
) -> Array:
    """Return firing intervals (R, 2) from the sets' own membership functions."""
    strengths = []
    for rule in rules:
        ends = []
        for end in ("lower", "upper"):
            grades = [float(getattr(inputs[i][t], end)(x[i])) for i, t in enumerate(rule) if t >= 0]
            ends.append(min(grades, default=1.0) if norm == "min" else float(np.prod(grades)))
        strengths.append(ends)
    return np.array(strengths)


def by_hand(
    inputs: list[list[fuzzy2.GaussianUncertainMean]], rules: Array, z: Array, x: Array, norm: str
) -> Array:
    """Type-reduced intervals by enumeration of all switch points."""
    low, high = strengths_by_hand(inputs, rules, x, norm).T
    intervals = []
    for j in range(z.shape[1]):
        order = np.argsort(z[:, j])
        points, averages = z[order, j], ([], [])
        for k in range(len(points) + 1):
            for end, (first, second) in enumerate(((high, low), (low, high))):
                weights = np.concatenate([first[order][:k], second[order][k:]])
                averages[end].append(weights @ points / weights.sum())
        intervals.append((min(averages[0]), max(averages[1])))
    return np.array(intervals)
