"""Firing strengths that are too small for floats, relative to each other."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fuzzy2.support.checks import Array

VANISHED = 1e-280
"""Products of grades below this one have lost digits, or all of them, to underflow."""


def relative_firing(grades: list[Array], rules: NDArray[np.int64], weights: Array | None) -> Array:
    """Return products of grades, divided by the greatest of a row, through their logarithms.

    Parameters
    ----------
    grades : list of p (n, terms, 2) arrays
        Grades of each input in its terms.
    rules : (R, p) array
        Number of the term of each input that a rule asks for, or -1.
    weights : (R,) array, optional
        Weights of the rules.

    Returns
    -------
    (n, R, 2) array
        Firing intervals; all 0 where no rule fires.
    """
    sums = np.zeros((len(grades[0]), len(rules), 2))
    with np.errstate(divide="ignore"):
        if weights is not None:
            sums += np.log(weights)[:, np.newaxis]
        for i, of_input in enumerate(grades):
            used = np.flatnonzero(rules[:, i] >= 0)
            sums[:, used] += np.log(of_input)[:, rules[used, i]]
    greatest = sums[..., 1].max(axis=1)[:, np.newaxis, np.newaxis]
    fires = np.isfinite(greatest)
    return np.where(fires, np.exp(sums - np.where(fires, greatest, 0.0)), 0.0)
