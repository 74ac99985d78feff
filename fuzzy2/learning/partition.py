"""Partitions of an input's range into terms, and names of terms."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fuzzy2.errors import InvalidValue
from fuzzy2.learning.clustering import Clusters
from fuzzy2.sets.gaussian_type2 import GaussianType2Set
from fuzzy2.sets.interval_type2 import GaussianUncertainMean
from fuzzy2.sets.shapes import Gaussian
from fuzzy2.support.checks import Array, known_name, of_kind, real, reals, whole_number

Term = Gaussian | GaussianUncertainMean | GaussianType2Set
Integers = NDArray[np.int64]

KINDS = ("t1", "it2", "gt2")
"""Kinds of systems: type-1, interval type-2, general type-2."""

# full width of a Gaussian at half its height, in standard deviations
_CROSSING = 2.0 * math.sqrt(2.0 * math.log(2.0))


def gaussian_partition(
    least: float, greatest: float, n_terms: int = 2, kind: str = "it2", mean_variation: float = 0.0
) -> tuple[Term, ...]:
    r"""Return Gaussian terms that partition a range evenly; neighbors cross at a membership of 1/2.

    .. math::

        m_k = a + k\,d, \quad d = \frac{b - a}{K - 1}, \quad
        \sigma = \frac{d}{2\sqrt{2\ln 2}}, \qquad
        k = 0, \dots, K - 1

    A single term has its mean in the middle of the range and membership 1/2 at both ends. With a
    crossing of 1/2 the memberships of two neighbors add up to between 1 and 17/16 everywhere
    between their means, so no part of the range has much more weight than another.

    Parameters
    ----------
    least, greatest : float
        Ends a < b of the range.
    n_terms : int
        Number K of terms, at least 1.
    kind : {"t1", "it2", "gt2"}
        Type-1 Gaussians; Gaussians with uncertain mean :math:`m_k \pm \nu (b - a)`; or Gaussian
        principal memberships with Gaussian secondary grades of standard deviation :math:`\nu (b -
        a)\, e^{-1/2} / (\sqrt{3}\,\sigma)`. To first order, this is the standard deviation that a
        mean distributed uniformly over that interval gives the membership where it is steepest.
    mean_variation : float
        Distance :math:`\nu` of the smallest and the largest mean from the middle, as a share of the
        range, at least 0; 0 makes type-1 terms. Ignored by "t1".

    Returns
    -------
    tuple of sets
        The terms in ascending order.

    Raises
    ------
    InvalidValue
        If the range has no width, or an argument is outside its range.
    UnknownName
        If the kind is unknown.
    """
    least, greatest = real("least", least), real("greatest", greatest)
    if not least < greatest:
        raise InvalidValue("greatest", greatest, f"above least, {least!r}")
    count = whole_number("n_terms", n_terms, 1)
    known_name("kind of system", kind, KINDS)
    variation = real("mean_variation", mean_variation)
    if variation < 0.0:
        raise InvalidValue("mean_variation", mean_variation, "at least 0")
    width = greatest - least
    means = (
        np.linspace(least, greatest, count)
        if count > 1
        else np.array([0.5 * least + 0.5 * greatest])
    )
    sigmas = np.full(count, width / max(count - 1, 1) / _CROSSING)
    return _gaussian_terms(means, sigmas, kind, variation * width)


def _gaussian_terms(means: Array, sigmas: Array, kind: str, reach: float) -> tuple[Term, ...]:
    """Return Gaussian terms whose means are uncertain by ``reach`` on both sides.

    See :func:`gaussian_partition`.
    """
    pairs = list(zip(means.tolist(), sigmas.tolist(), strict=True))
    if kind == "t1":
        return tuple(Gaussian(mean, sigma) for mean, sigma in pairs)
    if kind == "it2":
        return tuple(
            GaussianUncertainMean((mean - reach, mean + reach), sigma) for mean, sigma in pairs
        )
    return tuple(
        GaussianType2Set(Gaussian(mean, sigma), reach * math.exp(-0.5) / (math.sqrt(3.0) * sigma))
        for mean, sigma in pairs
    )


def cluster_partition(
    clusters: Clusters, widths: ArrayLike, kind: str = "it2", mean_variation: float = 0.0
) -> tuple[tuple[tuple[Term, ...], ...], Integers]:
    r"""Return the projections of clusters on the inputs as Gaussian terms, and a rule per cluster.

    The term of cluster k on input i has the center :math:`v_{ki}` as its mean, and as its standard
    deviation the spread of the cluster's samples along that input,

    .. math:: \sigma_{ki}^2 = \frac{\sum_n u_{nk}^m (x_{ni} - v_{ki})^2}{\sum_n u_{nk}^m},

    (M. Sugeno and T. Yasukawa, "A fuzzy-logic-based approach to qualitative modeling", IEEE
    Transactions on Fuzzy Systems 1(1), 1993, for rules by projection.)

    Parameters
    ----------
    clusters : Clusters
        K clusters of samples of p inputs, see :func:`fuzzy2.fuzzy_c_means`.
    widths : (p,) array_like
        Lengths to which the mean variation is relative, such as the inputs' ranges; above 0.
    kind, mean_variation
        See :func:`gaussian_partition`.

    Returns
    -------
    terms : tuple of p tuples of K sets
        The terms of every input in ascending order of their means.
    rules : (K, p) ndarray of int
        Number of each input's term for each cluster.

    Raises
    ------
    InvalidValue
        If all samples of a cluster have the same value of an input, so that its width there is 0,
        or if an argument is outside its range.
    UnknownName
        If the kind is unknown.
    """
    known_name("kind of system", kind, KINDS)
    variation = real("mean_variation", mean_variation)
    if variation < 0.0:
        raise InvalidValue("mean_variation", mean_variation, "at least 0")
    of_kind("clusters", clusters, Clusters, "clusters, as fuzzy_c_means returns them")
    centers, spreads = clusters.centers, clusters.spreads
    reaches = reals("widths", widths)
    if reaches.shape != centers.shape[1:] or not ((reaches > 0.0) & np.isfinite(reaches)).all():
        raise InvalidValue("widths", reaches, f"{centers.shape[1]} finite numbers above 0")
    flat = np.argwhere(~(spreads > 0.0))
    if len(flat):
        k, i = (int(index) for index in flat[0])
        wanted = (
            f"clusters with a width along every input; cluster {k + 1} has none along input "
            f"{i + 1}: take fewer clusters"
        )
        raise InvalidValue("clusters", spreads[k], wanted)
    return partition_of_centers(centers, spreads, variation * reaches, kind)


def partition_of_centers(
    centers: Array, spreads: Array, reaches: Array, kind: str
) -> tuple[tuple[tuple[Term, ...], ...], Integers]:
    """Return terms at the coordinates of centers (K, p), and a rule for each center.

    The terms have the standard deviations ``spreads`` (K, p), and their means are uncertain by
    ``reaches`` (p,).
    """
    order = np.argsort(centers, axis=0, kind="stable")
    terms = tuple(
        _gaussian_terms(centers[order[:, i], i], spreads[order[:, i], i], kind, float(reaches[i]))
        for i in range(len(reaches))
    )
    return terms, np.asarray(np.argsort(order, axis=0), dtype=np.int64)


def term_names(n_terms: int) -> tuple[str, ...]:
    """Return names for the terms of a partition in ascending order.

    Up to three terms are called Low, Mid and High; more terms have numbers.
    """
    known: dict[int, tuple[str, ...]] = {1: ("Any",), 2: ("Low", "High"), 3: ("Low", "Mid", "High")}
    count = whole_number("n_terms", n_terms, 1)
    return known.get(count) or tuple(f"Level{k + 1}" for k in range(count))


def principal_terms(least: float, greatest: float, n_terms: int) -> tuple[Gaussian, ...]:
    """Return the type-1 Gaussians that partition a range."""
    return gaussian_terms([gaussian_partition(least, greatest, n_terms, "t1")])[0]


def gaussian_terms(inputs: Sequence[tuple[Term, ...]]) -> list[tuple[Gaussian, ...]]:
    """Return the same terms with the type of type-1 Gaussians, which they are."""
    return [tuple(term for term in terms if isinstance(term, Gaussian)) for terms in inputs]


def grades_in(x: Array, terms: Sequence[Gaussian]) -> Array:
    """Return the memberships (N, K) of points (N,)."""
    return np.stack([term.membership(x) for term in terms], axis=1)


def centroid_of_term(term: Term) -> tuple[float, float]:
    """Return left and right end of the centroid of a term."""
    assert not isinstance(term, GaussianType2Set)
    if isinstance(term, Gaussian) or term.mean[0] == term.mean[1]:
        # The centroid of a Gaussian is its mean; quadrature would add rounding errors.
        mean = term.mean if isinstance(term, Gaussian) else term.mean[0]
        return mean, mean
    return term.centroid()


def terms_per_input(n_terms: int | Sequence[int], count: int) -> list[int]:
    """Return the number of terms of each input, given as one number or one per input."""
    requirement = f"one whole number, or one for each of the {count} inputs"
    if reals("n_terms", n_terms, requirement).ndim == 0:
        return [whole_number("n_terms", n_terms, 1)] * count
    numbers = [whole_number("n_terms", number, 1) for number in np.asarray(n_terms).ravel()]
    if len(numbers) != count:
        raise InvalidValue("n_terms", n_terms, requirement)
    return numbers
