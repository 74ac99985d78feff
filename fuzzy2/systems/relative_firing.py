"""Firing strengths that are too small for floats, relative to each other."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fuzzy2.support.checks import Array

VANISHED = 1e-280
"""Firing strengths below this one have lost digits, or all of them, to underflow."""


def log_grades(terms: Sequence[Any], x: Array, grades: Array) -> Array:
    """Return the logarithms of grades (n, terms, 2) of an input x (n,).

    Those of Gaussians are parabolas, also where the grades themselves underflow.
    """
    with np.errstate(divide="ignore", over="ignore"):
        found: Array = np.log(grades)
        for t, term in enumerate(terms):
            row = _gaussian_row(term)
            if row is not None:
                near, far = _distances(row, x)
                found[:, t, 1] = np.log(row[6]) - 0.5 * near**2
                found[:, t, 0] = np.minimum(np.log(row[5]) - 0.5 * far**2, found[:, t, 1])
    return found


def slopes_of_logarithms(terms: Sequence[Any], x: Array, grades: Array, slopes: Array) -> Array:
    """Return the derivatives by x of :func:`log_grades`, of grades with these slopes."""
    found: Array = np.divide(slopes, grades, out=np.zeros_like(grades), where=grades > 0.0)
    for t, term in enumerate(terms):
        row = _gaussian_row(term)
        if row is not None:
            near, far = _distances(row, x)
            found[:, t, 0], found[:, t, 1] = -far / row[3], -near / row[4]
    return found


def _gaussian_row(term: Any) -> tuple[float, ...] | None:
    """Return the kernel row of a Gaussian term, whose mean or deviation may be uncertain."""
    row: tuple[float, ...] | None = term.kernel_row()
    return row if row is not None and row[0] == 0.0 else None


def _distances(row: tuple[float, ...], x: Array) -> tuple[Array, Array]:
    """Return the distances, in standard deviations, from the nearest and the farthest mean."""
    _, first, last, s_low, s_high, *_ = row
    far = x - np.where(x < 0.5 * (first + last), last, first)
    return (x - np.clip(x, first, last)) / s_high, far / s_low


def relative_firing(
    logarithms: Sequence[Array],
    rules: NDArray[np.int64],
    weights: Array | None,
    minimum: bool = False,
) -> Array:
    """Return firing strengths, divided by the greatest of a row, through their logarithms.

    Parameters
    ----------
    logarithms : sequence of p (n, terms, 2) arrays
        Logarithms of each input's grades in its terms.
    rules : (R, p) array
        Number of the term of each input that a rule asks for, or -1.
    weights : (R,) array, optional
        Weights of the rules.
    minimum : bool
        Whether grades are combined by the minimum; by the product, else.

    Returns
    -------
    (n, R, 2) array
        Firing intervals; all 0 where no rule fires.
    """
    sums = np.zeros((len(logarithms[0]), len(rules), 2))
    for i, of_input in enumerate(logarithms):
        used = np.flatnonzero(rules[:, i] >= 0)
        own = of_input[:, rules[used, i]]
        sums[:, used] = np.minimum(sums[:, used], own) if minimum else sums[:, used] + own
    if weights is not None:
        with np.errstate(divide="ignore"):
            sums += np.log(weights)[:, np.newaxis]
    greatest = sums[..., 1].max(axis=1)[:, np.newaxis, np.newaxis]
    fires = np.isfinite(greatest)
    return np.where(fires, np.exp(sums - np.where(fires, greatest, 0.0)), 0.0)
