r"""Type reduction of general type-2 sets and systems, by α-planes and by enumerating embedded sets.

The generalized centroid (eq. 1.84, 1.115) of fuzzy points :math:`Z_l` with fuzzy weights
:math:`W_l`,

.. math::

    Y = \int_{z_1} \cdots \int_{z_N} \int_{w_1} \cdots \int_{w_N}
    \mathop{\mathcal T}_l \mu_{Z_l}(z_l) * \mathop{\mathcal T}_l \mu_{W_l}(w_l)
    \Big/ \frac{\sum_l w_l z_l}{\sum_l w_l},

is reduced in two ways. Under the minimum, the α-cut of :math:`Y` is the interval type reduction of
the α-cuts of its arguments, if those are intervals; this takes one exact reduction for each alpha.
For discrete sets, every combination of points is an embedded set, and the :math:`\prod_l M_l`
averages with their grades make up :math:`Y`. The enumeration is the reference for small cases.

Grades of continuous secondary sets are not multiplied, because the result would become narrower
with every point of the domain, and would depend on the sampling of the secondary sets.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from fuzzy2.errors import InvalidValue, NotApplicable, TooManyEmbeddedSets
from fuzzy2.operations.extension import bounded_support, discrete_points, is_discrete
from fuzzy2.operations.t_norms import BinaryFunction, TNorm
from fuzzy2.operations.t_norms import t_norm as norm_of
from fuzzy2.reduction.interval import generalized_centroid
from fuzzy2.sets.general_type2 import GeneralType2Set, SampledType2Set
from fuzzy2.sets.shapes import Interval
from fuzzy2.sets.type1 import ROUNDING, SampledSet, Type1Set
from fuzzy2.support.checks import Array, listed, of_kind, real, reals, whole_number
from fuzzy2.support.quadrature import merged

MOST_EMBEDDED_SETS = 1_000_000
"""Greatest number of embedded sets that are enumerated, which takes some seconds."""


class TypeReducedPlanes(NamedTuple):
    r"""Type-reduced set as nested intervals.

    Attributes
    ----------
    alphas : (L,) array
        Levels in (0, 1], ascending.
    intervals : (..., L, 2) array
        α-cuts of the type-reduced set; NaN where all weights are 0.
    crisp : (...,) array
        Average of the middles of the cuts, weighted with the levels, :math:`\sum_i \alpha_i\,
        (y_{l,i} + y_{r,i})/2 \,/ \sum_i \alpha_i`.
    """

    alphas: Array
    intervals: Array
    crisp: Array


class TypeReducedPoints(NamedTuple):
    r"""Type-reduced set of discrete sets.

    Attributes
    ----------
    set : SampledSet
        Discrete set of the averages of all embedded sets, with their grades.
    crisp : float
        Its centroid :math:`\sum_i y_i \mu_i / \sum_i \mu_i` (eq. 1.69).
    """

    set: SampledSet
    crisp: float


def alpha_plane_reduction(
    alphas: ArrayLike, z: ArrayLike, w: ArrayLike, method: str = "eiasc"
) -> TypeReducedPlanes:
    r"""Return the generalized centroid of points and weights that are given as α-cuts.

    The result is exact at each level.

    .. math:: Y_\alpha = \left[\min_{z_l \in (Z_l)_\alpha,\, w_l \in (W_l)_\alpha}
              \frac{\sum_l w_l z_l}{\sum_l w_l},\
        \max_{z_l \in (Z_l)_\alpha,\, w_l \in (W_l)_\alpha} \frac{\sum_l w_l z_l}{\sum_l w_l}\right]

    Parameters
    ----------
    alphas : (L,) array_like
        Levels in (0, 1], ascending.
    z : (N,), (N, 2) or (..., L, N, 2) array_like
        Points, intervals, or intervals at each level.
    w : (..., L, N, 2) array_like
        Weight intervals at each level, not negative.
    method : {"km", "ekm", "iasc", "eiasc", "scan"}
        See :func:`fuzzy2.reduction.interval.generalized_centroid`.

    Returns
    -------
    TypeReducedPlanes
        α-cuts of the type-reduced set, and its crisp value.

    Raises
    ------
    InvalidValue
        If the levels do not ascend in (0, 1], if shapes do not match, or if an interval of a higher
        level is not within the one of the level below.
    UnknownName
        If there is no such method.

    Notes
    -----
    Liu, "An efficient centroid type-reduction strategy for general type-2 fuzzy logic system",
    Information Sciences 178 (2008); Wagner and Hagras, "Toward general type-2 fuzzy logic systems
    based on zSlices", IEEE Transactions on Fuzzy Systems 18 (2010), whose worked example is among
    the tests.
    """
    levels, points, weights = _levels(alphas), reals("z", z), reals("w", w)
    if weights.ndim < 3 or weights.shape[-3] != levels.size or weights.shape[-1] != 2:
        raise InvalidValue(
            "w", weights.shape, f"of shape (..., {levels.size}, N, 2), one layer for each level"
        )
    _require_nested("w", weights)
    if points.ndim > 2:
        if points.shape[-3] != levels.size or points.shape[-1] != 2:
            raise InvalidValue(
                "z", points.shape, f"of shape (N,), (N, 2) or (..., {levels.size}, N, 2)"
            )
        _require_nested("z", points)
    elif points.ndim == 1:
        points = np.stack([points, points], axis=-1)
    intervals = generalized_centroid(points, weights, method)
    return TypeReducedPlanes(levels, intervals, alpha_plane_defuzzify(levels, intervals))


def alpha_plane_centroid(
    fuzzy_set: GeneralType2Set, x: ArrayLike, alphas: ArrayLike, method: str = "eiasc"
) -> TypeReducedPlanes:
    """Return the centroid of a general type-2 set on sampled points (eq. 1.70).

    The result holds under the minimum and is exact at each level.

    Parameters
    ----------
    fuzzy_set : GeneralType2Set
        The set, with convex secondary sets.
    x : (N,) array_like
        Points of the domain.
    alphas : (L,) array_like
        Levels in (0, 1], ascending. Equally spaced levels from 1/L to 1 are the zSlices of Wagner
        and Hagras.
    method : str
        See :func:`fuzzy2.reduction.interval.generalized_centroid`.

    Returns
    -------
    TypeReducedPlanes
        α-cuts of the centroid, and its crisp value.

    Raises
    ------
    InvalidValue, UnknownName
        See :func:`alpha_plane_reduction`.
    """
    of_kind("fuzzy_set", fuzzy_set, GeneralType2Set, "a general type-2 set")
    points = reals("x", x)
    planes = [
        fuzzy_set.alpha_plane(alpha) for alpha in _levels(np.atleast_1d(reals("alphas", alphas)))
    ]
    weights = np.stack(
        [np.stack([plane.lower(points), plane.upper(points)], axis=-1) for plane in planes]
    )
    return alpha_plane_reduction(alphas, points, weights, method)


def alpha_plane_defuzzify(alphas: ArrayLike, intervals: ArrayLike) -> Array:
    r"""Return the crisp value of a type-reduced set that is given as α-cuts.

    .. math:: y = \frac{\sum_i \alpha_i\, (y_{l,i} + y_{r,i}) / 2}{\sum_i \alpha_i}

    Parameters
    ----------
    alphas : (L,) array_like
        Levels in (0, 1], ascending.
    intervals : (..., L, 2) array_like
        Ends of the cuts.

    Returns
    -------
    (...,) array
        Crisp values; NaN where a cut is NaN.

    Raises
    ------
    InvalidValue
        If the levels do not ascend in (0, 1], or if there are not as many cuts as levels.

    Notes
    -----
    Wagner and Hagras, "Toward general type-2 fuzzy logic systems based on zSlices", IEEE
    Transactions on Fuzzy Systems 18 (2010).
    """
    levels, cuts = _leveled(alphas, intervals)
    return np.asarray(cuts.mean(axis=-1) @ (levels / levels.sum()))


def cut_centroid(alphas: ArrayLike, intervals: ArrayLike) -> Array:
    r"""Return the centroid (eq. 1.68) of a type-1 set that is given as α-cuts.

    .. math:: c = \frac{\int x\,\mu(x)\,dx}{\int \mu(x)\,dx}
              = \frac{\int_0^h \tfrac12 (y_l + y_r)(y_r - y_l)\,d\alpha}
                     {\int_0^h (y_r - y_l)\,d\alpha}

    Here wide cuts have more weight, whereas ``alpha_plane_defuzzify`` weights cuts with their
    levels only, however wide they are. The ends of the cuts :math:`y_l, y_r` are linear between two
    levels, as in :class:`fuzzy2.numbers.FuzzyNumber`, and the integrals are exact for such ends.
    Below the lowest level the ends of the lowest cut are used; h is the highest level.

    Parameters
    ----------
    alphas : (L,) array_like
        Levels in (0, 1], ascending.
    intervals : (..., L, 2) array_like
        Ends of the cuts.

    Returns
    -------
    (...,) array
        Centroids. For a set without width it is the middle of the lowest cut; NaN where a cut is
        NaN.

    Raises
    ------
    InvalidValue
        If the levels do not ascend in (0, 1], or if there are not as many cuts as levels.
    """
    levels, cuts = _leveled(alphas, intervals)
    middles, widths = cuts.mean(axis=-1), cuts[..., 1] - cuts[..., 0]
    # Moments are taken about the middle of the lowest cut, so that a set far from 0 keeps its
    # digits.
    origin = middles[..., 0]
    c, w, steps = middles - origin[..., None], widths, np.diff(levels)
    area = levels[0] * w[..., 0] + 0.5 * (w[..., 1:] + w[..., :-1]) @ steps
    moment = (
        c[..., :-1] * (2.0 * w[..., :-1] + w[..., 1:])
        + c[..., 1:] * (w[..., :-1] + 2.0 * w[..., 1:])
    ) @ (steps / 6.0)
    # A set with NaN must not be treated as a set without width.
    point = area == 0.0
    return np.asarray(origin + np.where(point, 0.0, moment / np.where(point, 1.0, area)))


def exhaustive_generalized_centroid(
    Z: Iterable[Type1Set | float],
    W: Iterable[Type1Set | float],
    t_norm: str | TNorm | BinaryFunction = "min",
    samples: int | None = None,
    limit: int = MOST_EMBEDDED_SETS,
) -> TypeReducedPoints:
    r"""Return the generalized centroid by enumeration of all embedded sets.

    See eq. 1.70, 1.76, 1.80 and 1.84.

    Combinations without a positive weight have no average and are left out. Averages within 1e-12
    of each other are merged and keep the greatest of their grades.

    Parameters
    ----------
    Z : N numbers or type-1 sets
        Points: crisp for the centroid and the height reducer, centroids of the consequents for
        center of sets.
    W : N type-1 sets or numbers
        Weights, not negative: secondary sets, or firing sets.
    t_norm : str, TNorm or callable
        How grades are combined. Continuous sets require the minimum, except for intervals, whose
        grades are all 1.
    samples : int, optional
        Number of points that replace each continuous set. They are spaced evenly over its support,
        limited to :math:`W \ge 0` for weights, and its maxima are added. The type-reduced set is
        then sampled, too, and its grades are lower bounds.
    limit : int
        Greatest number of embedded sets that are enumerated.

    Returns
    -------
    TypeReducedPoints
        The type-reduced set as a discrete set, and its crisp value.

    Raises
    ------
    NotApplicable
        If a set is continuous and either ``samples`` is missing or the t-norm is not the minimum,
        or if no combination has an average.
    InvalidValue
        If there are not as many weights as points, or if a weight is negative.
    TooManyEmbeddedSets
        If there are more embedded sets than ``limit``.
    """
    norm = norm_of(t_norm)
    if samples is not None:
        whole_number("samples", samples, 2)
    most = whole_number("limit", limit, 1, sys.maxsize)
    sets = "a list of type-1 sets or numbers"
    points = [_discretized("Z", item, norm, samples, -math.inf) for item in listed("Z", Z, sets)]
    weights = [_discretized("W", item, norm, samples, 0.0) for item in listed("W", W, sets)]
    if len(points) != len(weights) or not points:
        raise InvalidValue(
            "Z and W", (len(points), len(weights)), "as many points as weights, at least one"
        )
    count = math.prod(values.size for values, _ in (*points, *weights))
    if count > most:
        raise TooManyEmbeddedSets(count, most)
    # Averages are taken about one of the points, so that points far from zero keep their digits.
    origin = float(points[0][0][0])
    moment, mass, grade = np.zeros(1), np.zeros(1), np.ones(1)
    for (z, z_grades), (w, w_grades) in zip(points, weights, strict=True):
        moment = np.add.outer(moment, np.multiply.outer(z - origin, w)).ravel()
        mass = np.add.outer(mass, np.tile(w, z.size)).ravel()
        grade = norm(grade[:, None], norm(z_grades[:, None], w_grades).ravel()).ravel()
    has_average = mass > 0.0
    if not (grade[has_average] > 0.0).any():
        raise NotApplicable(
            "type reduction",
            "no embedded set with a positive grade has a positive weight to average with",
        )
    reduced = SampledSet(origin + moment[has_average] / mass[has_average], grade[has_average])
    crisp = origin + float((reduced.points - origin) @ reduced.grades) / float(reduced.grades.sum())
    return TypeReducedPoints(reduced, crisp)


def exhaustive_centroid(
    fuzzy_set: SampledType2Set,
    t_norm: str | TNorm | BinaryFunction = "min",
    limit: int = MOST_EMBEDDED_SETS,
) -> TypeReducedPoints:
    r"""Return the centroid of a discrete type-2 set by enumeration of all embedded sets (eq. 1.70).

    .. math:: C = \int_{\theta_1} \cdots \int_{\theta_N}
              \mu_{D_1}(\theta_1) * \cdots * \mu_{D_N}(\theta_N)
        \Big/ \frac{\sum_i x_i \theta_i}{\sum_i \theta_i}

    Parameters
    ----------
    fuzzy_set : SampledType2Set
        A set on finitely many points with discrete slices. ``sample`` makes one from any general
        type-2 set, but under a t-norm other than the minimum its centroid depends on the samples
        and shrinks to a point as their number grows.
    t_norm : str, TNorm or callable
        How secondary grades are combined.
    limit : int
        Greatest number of embedded sets that are enumerated.

    Returns
    -------
    TypeReducedPoints
        The centroid as a discrete set, and its crisp value.

    Raises
    ------
    NotApplicable
        If a slice is continuous.
    TooManyEmbeddedSets
        If there are more embedded sets than ``limit``.
    """
    of_kind("fuzzy_set", fuzzy_set, SampledType2Set, "a SampledType2Set, such as of sample()")
    return exhaustive_generalized_centroid(fuzzy_set.points, fuzzy_set.slices, t_norm, limit=limit)


def _levels(alphas: ArrayLike) -> Array:
    levels = reals("alphas", alphas)
    if (
        levels.ndim != 1
        or levels.size == 0
        or not ((levels > 0.0) & (levels <= 1.0)).all()
        or (np.diff(levels) <= 0.0).any()
    ):
        raise InvalidValue("alphas", alphas, "levels in (0, 1], ascending")
    return levels


def _leveled(alphas: ArrayLike, intervals: ArrayLike) -> tuple[Array, Array]:
    """Return the levels and the cuts, one for each level."""
    levels, cuts = _levels(alphas), reals("intervals", intervals)
    if cuts.ndim < 2 or cuts.shape[-2:] != (levels.size, 2):
        raise InvalidValue(
            "intervals", cuts.shape, f"of shape (..., {levels.size}, 2), one cut for each level"
        )
    return levels, cuts


def _require_nested(name: str, layers: Array) -> None:
    """Raise unless the intervals (..., L, N, 2) of each level lie within those of the level below.

    Rounding errors are tolerated.
    """
    rounding = ROUNDING * np.max(np.abs(layers), initial=0.0)
    inward = np.diff(layers, axis=-3)
    if (inward[..., 0] < -rounding).any() or (inward[..., 1] > rounding).any():
        raise InvalidValue(
            name, layers, "nested: the intervals of each level within those of the level before it"
        )


def _discretized(
    name: str, item: Type1Set | float, norm: TNorm, samples: int | None, least: float
) -> tuple[Array, Array]:
    """Return points and grades of a number, a discrete set, or a sampled continuous set."""
    if not isinstance(item, Type1Set):
        points, grades = np.array([real(name, item)]), np.ones(1)
    elif is_discrete(item):
        points, grades = discrete_points(item)
    else:
        what = f"enumeration of the continuous set {item!r}"
        if norm is not norm_of("min") and not isinstance(item, Interval):
            raise NotApplicable(
                what,
                f"with grades combined by {norm.name} the result depends on the grid; use the "
                "minimum",
            )
        if samples is None:
            raise NotApplicable(
                what, "say how many samples stand for it, or reduce by alpha-planes"
            )
        left, right = bounded_support(item, what)
        points = merged(np.linspace(max(left, least), right, samples), item.maxima or ())
        grades = item.membership(points)
    if (points < least).any():
        raise InvalidValue(name, item, "a set of numbers that are not negative")
    return points, grades
