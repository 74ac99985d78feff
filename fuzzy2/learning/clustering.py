r"""Fuzzy c-means: clusters to which samples belong to a degree.

The centers :math:`v_k` and memberships :math:`u_{nk}` of N samples in K clusters minimize

.. math:: J = \sum_{n=1}^{N} \sum_{k=1}^{K} u_{nk}^m \lVert x_n - v_k \rVert^2, \qquad
          \sum_k u_{nk} = 1,

with the fuzzifier m > 1. The closer it is to 1, the crisper the clusters; the limit is k-means.
Distances are Euclidean, so scale columns with different units first.

Source: J. C. Bezdek, "Pattern Recognition with Fuzzy Objective Function Algorithms", Plenum Press,
1981.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from fuzzy2.errors import InvalidValue
from fuzzy2.learning.samples import weights_of
from fuzzy2.support.checks import (
    Array,
    binary_exponent,
    finite_rows,
    generator,
    real,
    reals,
    whole_number,
)

TOLERANCE = 1e-9
"""The iteration has converged if no membership changes by more than this."""

MOST_ITERATIONS = 1000
"""Greatest number of iterations of one start."""


@dataclass(frozen=True)
class Clusters:
    """Result of :func:`fuzzy_c_means`.

    Parameters
    ----------
    centers : (K, p) ndarray
        Centers of the clusters.
    memberships : (N, K) ndarray
        Degrees to which the samples belong to the clusters; each row adds up to 1.
    spreads : (K, p) ndarray
        Standard deviation of each cluster's samples along each column, about its center and
        weighted with the memberships to the power of the fuzzifier.
    fuzzifier : float
        The fuzzifier m in the objective.
    objectives : (iterations,) ndarray
        The objective after each iteration; it never increases.
    converged : bool
        Whether the memberships had converged when the iteration ended.
    unit : float
        Unit of length of the objectives: 1, unless the samples are so large or small that their
        squares would overflow or underflow.
    """

    centers: Array
    memberships: Array
    spreads: Array
    fuzzifier: float
    objectives: Array
    converged: bool
    unit: float = 1.0

    @property
    def partition_coefficient(self) -> float:
        r"""Partition coefficient, :math:`\frac{1}{N} \sum_{nk} u_{nk}^2` (Bezdek 1981).

        It ranges from 1/K (equal memberships in all clusters) to 1 (crisp clusters).
        """
        return float((self.memberships**2).sum() / len(self.memberships))

    @property
    def xie_beni(self) -> float:
        r"""Validity index of Xie and Beni: spread of the clusters relative to their distances.

        The index is :math:`J / (N \min_{j \ne k} \lVert v_j - v_k \rVert^2)`.

        The smaller, the better: choose the number of clusters with the smallest index. The index
        falls again as the number of clusters approaches that of the samples. It is infinite if
        centers coincide, and NaN for a single cluster. (X. L. Xie and G. Beni, "A validity measure
        for fuzzy clustering", IEEE Transactions on Pattern Analysis and Machine Intelligence 13(8),
        1991.)
        """
        centers = self.centers / self.unit
        apart = _squared_distances(centers, centers)[~np.eye(len(self.centers), dtype=bool)]
        if not apart.size:
            return float("nan")
        with np.errstate(divide="ignore"):
            return float(self.objectives[-1] / (len(self.memberships) * apart.min()))

    def membership(self, X: ArrayLike) -> Array:
        r"""Return the memberships of arbitrary points.

        .. math:: \frac{1}{u_{nk}} = \sum_j \left(\frac{\lVert x_n - v_k \rVert}
                  {\lVert x_n - v_j \rVert}\right)^{2/(m-1)}

        Parameters
        ----------
        X : (..., p) array_like
            Points.

        Returns
        -------
        (..., K) ndarray
            Memberships. At a center the membership in its cluster is 1; coinciding centers share it
            evenly.

        Raises
        ------
        InvalidValue
            If the points are not finite, or do not have as many columns as the centers.
        """
        points = reals("X", X)
        width = self.centers.shape[1]
        finite_rows("X", points, points.shape[-1:] == (width,), f"(..., {width})")
        # Points and centers are scaled by the larger of both, so that squares of distant points do
        # not overflow.
        scale = binary_exponent(np.concatenate([points.ravel(), self.centers.ravel()]))
        found = _memberships(
            _squared_distances(
                np.ldexp(points.reshape(-1, width), -scale), np.ldexp(self.centers, -scale)
            ),
            self.fuzzifier,
        )
        return found.reshape(*points.shape[:-1], len(self.centers))


def checked_fuzzifier(value: object) -> float:
    """Return a fuzzifier as a float; raise :class:`InvalidValue` if it is not above 1."""
    power = real("fuzzifier", value, "a finite number above 1")
    if power <= 1.0:
        raise InvalidValue("fuzzifier", value, "a finite number above 1")
    return power


def fuzzy_c_means(
    X: ArrayLike,
    n_clusters: int,
    fuzzifier: float = 2.0,
    rng: np.random.Generator | None = None,
    starts: int = 10,
    *,
    sample_weight: ArrayLike | None = None,
) -> Clusters:
    r"""Return the best clustering that alternating optimization finds from random starts.

    Each step minimizes the objective over the memberships or over the centers, with the other
    fixed. Neither step can increase it:

    .. math::

        \frac{1}{u_{nk}} = \sum_j \left(\frac{\lVert x_n - v_k \rVert}
        {\lVert x_n - v_j \rVert}\right)^{2/(m-1)}, \qquad
        v_k = \frac{\sum_n u_{nk}^m x_n}{\sum_n u_{nk}^m}

    Parameters
    ----------
    X : (N, p) array_like
        Samples.
    n_clusters : int
        Number K of clusters, at most the number of different samples.
    fuzzifier : float
        The fuzzifier m, above 1.
    rng : numpy.random.Generator, optional
        Chooses the samples where the centers start; seeded with 0 by default.
    starts : int
        Number of starts. A start may end in a local minimum, so the result with the smallest
        objective is returned.
    sample_weight : (N,) array_like, optional
        Weight of each sample, not negative; 1 by default.

    Returns
    -------
    Clusters
        Clusters in ascending order of the first coordinate of their centers.

    Raises
    ------
    InvalidValue
        If the samples are not a table of finite numbers, if there are fewer different samples than
        clusters, or if an argument is outside its range.
    """
    samples = reals("X", X)
    fits = samples.ndim == 2 and 0 not in samples.shape
    finite_rows("X", samples, fits, "(N, p), a row for each sample, and not empty")
    power = checked_fuzzifier(fuzzifier)
    whole_number("n_clusters", n_clusters, 1)
    whole_number("starts", starts, 1)
    source = np.random.default_rng(0) if rng is None else generator("rng", rng)
    counts = weights_of(sample_weight, len(samples))
    different = np.unique(samples[counts > 0.0], axis=0)
    if len(different) < n_clusters:
        raise InvalidValue(
            "n_clusters", n_clusters, f"at most {len(different)}, the number of different samples"
        )
    # Scaling by a power of two is exact.
    scale = binary_exponent(samples)
    samples, different = np.ldexp(samples, -scale), np.ldexp(different, -scale)
    # Coinciding centers would never separate again, so the centers start from different samples.
    runs = [
        _alternate(samples, source.choice(different, n_clusters, replace=False), power, counts)
        for _ in range(starts)
    ]
    best = min(runs, key=lambda run: run.objectives[-1])
    if scale == 0:
        return best
    return replace(
        best,
        centers=np.ldexp(best.centers, scale),
        spreads=np.ldexp(best.spreads, scale),
        unit=math.ldexp(1.0, scale),
    )


def _alternate(samples: Array, centers: Array, power: float, counts: Array) -> Clusters:
    """Return the result of alternating optimization from given centers."""
    objectives: list[float] = []
    squares = _squared_distances(samples, centers)
    memberships = _memberships(squares, power)
    converged = False
    for _ in range(MOST_ITERATIONS):
        weights = memberships**power * counts[:, np.newaxis]
        objectives.append(float((weights * squares).sum()))
        centers = _centers(samples, weights, centers)
        squares = _squared_distances(samples, centers)
        last, memberships = memberships, _memberships(squares, power)
        converged = bool(np.abs(memberships - last).max() <= TOLERANCE)
        if converged:
            break
    weights = memberships**power * counts[:, np.newaxis]
    objectives.append(float((weights * squares).sum()))
    order = np.lexsort(centers.T[::-1])
    centers, memberships, weights = centers[order], memberships[:, order], weights[:, order]
    # Moments are taken about the current center, which has moved by less than the tolerance since
    # it was the weighted mean.
    deviations = (samples[:, np.newaxis] - centers) ** 2
    mass = weights.sum(axis=0)[:, np.newaxis]
    spreads = np.sqrt(
        np.divide(
            np.einsum("nk,nkp->kp", weights, deviations),
            mass,
            out=np.zeros_like(centers),
            where=mass > 0.0,
        )
    )
    return Clusters(centers, memberships, spreads, power, np.array(objectives), converged)


def _squared_distances(points: Array, centers: Array) -> Array:
    """Return the squared distances (N, K), as sums of squares.

    Expanding the squares would cancel digits near the centers.
    """
    return np.asarray(((points[:, np.newaxis] - centers) ** 2).sum(axis=-1))


def _memberships(squares: Array, power: float) -> Array:
    """Return the memberships (N, K) that minimize the objective for given squared distances."""
    nearest = squares.min(axis=1, keepdims=True)
    # Relative to the nearest center, powers cannot overflow. A sample at a center gives 0/0 there,
    # and gets membership 1.
    with np.errstate(divide="ignore", invalid="ignore", under="ignore"):
        shares = np.where(squares == nearest, 1.0, (nearest / squares) ** (1.0 / (power - 1.0)))
    return np.asarray(shares / shares.sum(axis=1, keepdims=True))


def _centers(samples: Array, weights: Array, last: Array) -> Array:
    """Return the weighted means (K, p).

    If all memberships of a cluster underflow, its center does not move.
    """
    mass = weights.sum(axis=0)[:, np.newaxis]
    return np.where(
        mass > 0.0, (weights.T @ samples) / np.maximum(mass, np.finfo(float).tiny), last
    )
