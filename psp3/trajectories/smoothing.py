r"""Speeds and accelerations from noisy measured positions: a smoothing quintic spline.

The spline s with p coefficients minimizes the sum of squared errors at N measurements y of a
coordinate. The number p minimizes an estimate of the errors at measurements that are left out one
at a time (generalized cross-validation),

.. math:: V(p) = \frac{N \sum_i (y_i - s(t_i))^2}{(N - p)^2}.

The second derivative of a quintic spline is a cubic spline, so accelerations are smooth, too.

Source: P. Craven and G. Wahba, "Smoothing noisy data with spline functions", Numerische Mathematik
31, 1979, for the criterion; P. H. C. Eilers and B. D. Marx, "Flexible smoothing with B-splines and
penalties", Statistical Science 11(2), 1996, for its use with few coefficients.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from psp3.checks import Array
from psp3.errors import InvalidValue

DEGREE = 5
"""Degree of the spline."""

LEAST_MEASUREMENTS = 2 * (DEGREE + 1)
"""The smallest number of measurements that distinguishes a polynomial of that degree from noise."""

TRIED = 24
"""How many numbers of pieces are tried, from one piece to a coefficient for every other
measurement.
"""


def smoothed_motion(t: Array, positions: Array) -> Callable[[Array], tuple[Array, Array, Array]]:
    """Return a function for positions, speeds and accelerations (M, n) at times (M,).

    Parameters
    ----------
    t : (N,) ndarray
        Increasing times of the measurements, at least :data:`LEAST_MEASUREMENTS` [s].
    positions : (N, n) ndarray
        Measured positions [m or rad], whose errors are assumed to be independent.

    Raises
    ------
    InvalidValue
        If no curve with finite speeds and accelerations is near them.
    """
    from scipy.interpolate import make_lsq_spline

    count, n = positions.shape
    # Lengths and times are scaled to about 1, so that a spline of degree 5 loses no digits.
    start, length = t[0], t[-1] - t[0]
    knots_at = (t - start) / length
    best = np.full(n, np.inf)
    chosen: list[Any] = [None] * n
    for pieces in np.unique(np.geomspace(1, count // 2 - DEGREE, TRIED).round().astype(int)):
        # All pieces have the same number of measurements, so that all coefficients are determined.
        inner = np.interp(
            np.arange(1, pieces) * (count - 1) / pieces, np.arange(float(count)), knots_at
        )
        knots = np.concatenate([np.zeros(DEGREE + 1), inner, np.ones(DEGREE + 1)])
        try:
            spline = make_lsq_spline(knots_at, positions, knots, DEGREE)
        except (ValueError, np.linalg.LinAlgError):  # too few different times in a piece
            continue
        with np.errstate(over="ignore", invalid="ignore"):
            missed = ((positions - spline(knots_at)) ** 2).sum(axis=0)
        score = missed / (count - pieces - DEGREE) ** 2
        for joint in np.flatnonzero(score < best):
            best[joint], chosen[joint] = score[joint], spline

    with np.errstate(over="ignore", invalid="ignore"):
        largest = [
            float(np.abs(spline.c).max()) / min(length**2, 1.0)
            for spline in chosen
            if spline is not None
        ]
    if len(largest) < n or not np.isfinite(largest).all():
        raise InvalidValue(
            "positions",
            float(np.abs(positions).max()),
            f"such that a smooth curve goes near them in {length:.6g} s: its speeds or "
            "accelerations are not finite",
        )

    def motion(times: Array) -> tuple[Array, Array, Array]:
        at = (times - start) / length
        value, rate, curvature = (
            np.stack(
                [spline(at, order)[:, j] / length**order for j, spline in enumerate(chosen)],
                axis=-1,
            )
            for order in range(3)
        )
        return value, rate, curvature

    return motion
