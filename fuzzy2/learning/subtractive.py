r"""Subtractive clustering, in which the number of clusters follows from their radius.

Every sample is a possible center, and its potential measures the density of samples around it,

.. math:: P_i = \sum_j e^{-4 \lVert x_i - x_j \rVert^2 / r_a^2},

with columns divided by their ranges. The sample with the greatest potential becomes a center, and
its influence is subtracted from all others, :math:`P_i \leftarrow P_i - P_1 e^{-4 \lVert x_i - x_1
\rVert^2 / r_b^2}`. This is repeated. A sample becomes a center if its potential is above 0.5 of the
first one, and the search ends below 0.15. In between it becomes a center if :math:`d / r_a + P /
P_1 \ge 1`, where d is the distance to the nearest center.

Source: S. L. Chiu, "Fuzzy model identification based on cluster estimation", Journal of Intelligent
and Fuzzy Systems 2(3), 1994.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from fuzzy2.errors import InvalidValue
from fuzzy2.learning.samples import LEAST_RANGE, weights_of
from fuzzy2.support.checks import Array, binary_exponent, finite_rows, positive, reals

ACCEPTED, REJECTED = 0.5, 0.15
"""Potentials relative to the first one; above them a sample is a center, below it is not."""

BLOCK = 2**21
"""Distances that are held in memory at a time."""


@dataclass(frozen=True)
class SubtractiveClusters:
    r"""Result of :func:`subtractive_clustering`.

    Parameters
    ----------
    centers : (K, p) ndarray
        Samples that are centers, in the order in which they were chosen.
    sigmas : (p,) ndarray
        Standard deviation along each column of a Gaussian with the width of the potential,
        :math:`r_a / \sqrt 8` of the column's range.
    potentials : (K,) ndarray
        Potentials of the centers when they were chosen.
    """

    centers: Array
    sigmas: Array
    potentials: Array


def subtractive_clustering(
    X: ArrayLike,
    radius: float = 0.5,
    squash: float = 1.5,
    *,
    sample_weight: ArrayLike | None = None,
) -> SubtractiveClusters:
    r"""Return clusters of samples; their number follows from a radius (Chiu 1994).

    Parameters
    ----------
    X : (N, p) array_like
        Samples.
    radius : float
        Radius :math:`r_a` of a cluster, as a share of the range of each column; above 0.
    squash : float
        Ratio :math:`r_b / r_a` of the radius that keeps other centers away; above 0. MATLAB's
        ``subclust`` uses 1.25.
    sample_weight : (N,) array_like, optional
        Weight of each sample, not negative; 1 by default.

    Returns
    -------
    SubtractiveClusters
        Centers, widths and potentials.

    Raises
    ------
    InvalidValue
        If the samples are not a table of finite numbers, or if an argument is outside its range.
    """
    samples = reals("X", X)
    fits = samples.ndim == 2 and 0 not in samples.shape
    finite_rows("X", samples, fits, "(N, p), a row for each sample, and not empty")
    reach, wider = positive("radius", radius), positive("squash", squash)
    # The lengths are divided by them and then squared.
    for name, length in (
        ("radius", reach),
        ("squash", wider),
        ("radius times squash", reach * wider),
    ):
        if not LEAST_RANGE <= length <= 1.0 / LEAST_RANGE:
            wanted = f"from {LEAST_RANGE:.0e} to {1.0 / LEAST_RANGE:.0e}"
            raise InvalidValue(name, length, wanted)
    counts = weights_of(sample_weight, len(samples))
    scaled = np.ldexp(samples, -binary_exponent(samples))
    widths = np.ptp(scaled, axis=0)
    units = (scaled - scaled.min(axis=0)) / np.where(widths > 0.0, widths, 1.0)
    potentials = np.where(counts > 0.0, _potentials(units / reach, counts), 0.0)
    chosen: list[int] = []
    found: list[float] = []
    while True:
        best = int(np.argmax(potentials))
        height = float(potentials[best])
        if not _is_center(units, chosen, best, height, found, reach):
            if height <= REJECTED * found[0]:
                break
            potentials[best] = 0.0
            continue
        chosen.append(best)
        found.append(height)
        squares = ((units - units[best]) ** 2).sum(axis=1) / (wider * reach) ** 2
        potentials = potentials - height * np.exp(-4.0 * squares)
        # Set to exactly 0, because rounding must not make it a center again.
        potentials[best] = 0.0
    ranges = np.ptp(0.5 * samples, axis=0)
    sigmas = reach / np.sqrt(8.0) * 2.0 * ranges
    return SubtractiveClusters(samples[chosen], sigmas, np.array(found))


def _is_center(
    units: Array, chosen: list[int], best: int, height: float, found: list[float], reach: float
) -> bool:
    if not chosen or height > ACCEPTED * found[0]:
        return True
    if height <= REJECTED * found[0]:
        return False
    nearest = np.sqrt(((units[chosen] - units[best]) ** 2).sum(axis=1).min())
    return bool(nearest / reach + height / found[0] >= 1.0)


def _potentials(points: Array, counts: Array) -> Array:
    """Return the potentials (N,) of points in units of the radius."""
    rows = max(BLOCK // points.size, 1)
    parts = []
    for start in range(0, len(points), rows):
        apart = points[start : start + rows, np.newaxis] - points
        parts.append(np.exp(-4.0 * (apart**2).sum(axis=-1)) @ counts)
    return np.concatenate(parts)
