r"""Defuzzifiers, which return one crisp number for a type-1 set.

The set is given by its membership function or by samples of it.

The thesis warns of one mistake (section on defuzzification). A type-reduced set of a general type-2
system often has a single point of membership 1, and the height defuzzifier and the maxima return
that point. But membership 1 means that all secondary grades involved are 1. So the point is the
output of the type-1 system with the principal membership functions, whatever the uncertainty, and
all the work of the type-2 system is lost. Use the centroid.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from types import MappingProxyType
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike

from fuzzy2.errors import InvalidValue, NotApplicable
from fuzzy2.sets.curves import refined
from fuzzy2.sets.type1 import ROUNDING, SampledSet, Type1Set
from fuzzy2.support.checks import Array, known_name, of_kind, reals

Rule = TypeVar("Rule")


def defuzzify(fuzzy_set: Type1Set, method: str = "centroid") -> float:
    """Return one crisp number for a type-1 set on the continuous domain.

    Parameters
    ----------
    fuzzy_set : Type1Set
        The set. A :class:`SampledSet` is interpolated. For a discrete set, such as a type-reduced
        set computed from embedded sets, use :func:`defuzzify_samples`.
    method : str
        The defuzzifier: ``"centroid"``, ``"bisector"``, ``"height"``, ``"smallest_of_maxima"``,
        ``"mean_of_maxima"`` or ``"largest_of_maxima"``. For a single set, the height defuzzifier
        returns the mean of maxima.

    Returns
    -------
    float
        The crisp number.

    Raises
    ------
    UnknownName
        If there is no such method; the message lists the known ones.
    NotApplicable
        If the set is unbounded and has no finite centroid or area, or never reaches its maximum.
    """
    of_kind("fuzzy_set", fuzzy_set, Type1Set, "a type-1 set; take a center of a type-2 set")
    return _named(method, _OF_SETS)(fuzzy_set)


def defuzzify_samples(points: ArrayLike, grades: ArrayLike, method: str = "centroid") -> Array:
    r"""Return crisp numbers for discrete sets on common points (eq. 1.69 for the centroid).

    .. math:: c = \frac{\sum_i x_i\,\mu(x_i)}{\sum_i \mu(x_i)}

    Parameters
    ----------
    points : (N,) array_like
        Points in ascending order.
    grades : (..., N) array_like
        Grades, not negative.
    method : str
        ``"centroid"``, ``"bisector"``, ``"height"``, ``"smallest_of_maxima"``, ``"mean_of_maxima"``
        or ``"largest_of_maxima"``. The bisector is the median of the points, weighted with their
        grades. Midway between two points is returned where both halve the weights.

    Returns
    -------
    (...,) array
        The crisp numbers; NaN where all grades are 0, or one is NaN.

    Raises
    ------
    UnknownName
        If there is no such method; the message lists the known ones.
    InvalidValue
        If the points are not finite and ascending, if a grade is negative, or if there are not as
        many grades as points.
    """
    rule = _named(method, _OF_SAMPLES)
    x, u = reals("points", points), reals("grades", grades)
    if x.ndim != 1 or x.size == 0 or not np.isfinite(x).all() or (np.diff(x) < 0.0).any():
        raise InvalidValue(
            "points",
            points,
            "finite numbers in ascending order, of shape (N,) with N of at least 1",
        )
    if u.shape[-1:] != x.shape or (u < 0.0).any() or np.isinf(u).any():
        raise InvalidValue("grades", grades, f"finite and not negative, of shape (..., {x.size})")
    height = u.max(axis=-1, keepdims=True)  # NaN for rows that contain NaN
    with np.errstate(invalid="ignore"):
        # scaled, so that sums of tiny grades keep their digits
        relative = u / np.where(height > 0.0, height, np.nan)
    return np.asarray(np.where(np.isnan(relative).any(axis=-1), np.nan, rule(x, relative)))[()]


def centroid(fuzzy_set: Type1Set) -> float:
    """Return the centroid of a type-1 set (eq. 1.68); see :meth:`Type1Set.centroid`."""
    return fuzzy_set.centroid()


def bisector(fuzzy_set: Type1Set) -> float:
    r"""Return the point that halves the area of a type-1 set.

    .. math:: \int_{-\infty}^{b} \mu(x)\,dx = \int_{b}^{\infty} \mu(x)\,dx

    Parameters
    ----------
    fuzzy_set : Type1Set
        The set.

    Returns
    -------
    float
        The point. If every point of an interval without membership halves the area, it is the
        middle of the interval.

    Raises
    ------
    NotApplicable
        If the area is infinite, or zero for a set that is not a single point.
    """
    points = fuzzy_set.quadrature_points(power=0)
    first, last = float(points[0]), float(points[-1])
    if first == last:
        return first
    moments = fuzzy_set.moments(0.5 * first + 0.5 * last, power=0)
    area = moments.total[0]
    if area == 0.0:
        raise NotApplicable(
            "bisector", f"the membership of {fuzzy_set!r} is zero almost everywhere"
        )
    # Two searches find both ends of a gap without membership. Its middle gives mirrored sets
    # mirrored answers.
    slack = 4.0 * np.finfo(float).eps * area
    return 0.5 * (
        moments.point_of_area(0.5 * area - slack) + moments.point_of_area(0.5 * area + slack)
    )


def height(fuzzy_sets: Type1Set | Sequence[Type1Set]) -> float:
    r"""Return the height defuzzification of the output sets of rules (eq. 1.73).

    .. math:: y_h = \frac{\sum_l \bar y^l \mu_{B^l}(\bar y^l)}{\sum_l \mu_{B^l}(\bar y^l)}

    Parameters
    ----------
    fuzzy_sets : Type1Set or sequence of M Type1Set
        Output sets :math:`B^l`. Each is replaced with a singleton of the same height at the mean of
        its maxima :math:`\bar y^l`.

    Returns
    -------
    float
        The crisp number; NaN if the height of all sets is 0. See the warning in the docstring of
        :mod:`fuzzy2.reduction.defuzzification`.

    Raises
    ------
    InvalidValue
        If there is no set.
    NotApplicable
        If a set never reaches its maximum.
    """
    sets = [fuzzy_sets] if isinstance(fuzzy_sets, Type1Set) else list(fuzzy_sets)
    if not sets:
        raise InvalidValue("fuzzy_sets", fuzzy_sets, "at least one set")
    peaks, heights = (
        np.array([mean_of_maxima(one) for one in sets]),
        np.array([one.height for one in sets]),
    )
    return float(heights @ peaks / heights.sum()) if heights.any() else float("nan")


def smallest_of_maxima(fuzzy_set: Type1Set) -> float:
    """Return the first point of the greatest membership.

    Raise :class:`NotApplicable` if it is never reached.
    """
    return _maxima(fuzzy_set)[0]


def largest_of_maxima(fuzzy_set: Type1Set) -> float:
    """Return the last point of the greatest membership.

    Raise :class:`NotApplicable` if it is never reached.
    """
    return _maxima(fuzzy_set)[1]


def mean_of_maxima(fuzzy_set: Type1Set) -> float:
    """Return the mean of all points of the greatest membership.

    Parameters
    ----------
    fuzzy_set : Type1Set
        The set.

    Returns
    -------
    float
        The mean over all plateaus, or over single points if there are no plateaus.

    Raises
    ------
    NotApplicable
        If the greatest membership is never reached, or a plateau never ends.
    """
    first, last = _maxima(fuzzy_set)
    if not np.isfinite([first, last]).all():
        raise NotApplicable("mean_of_maxima", f"the maximum of {fuzzy_set!r} has no end")
    if fuzzy_set.is_convex():
        return 0.5 * first + 0.5 * last
    sampled = (
        fuzzy_set
        if isinstance(fuzzy_set, SampledSet)
        else fuzzy_set.sample(refined(fuzzy_set.landmarks))
    )
    highest = sampled.grades >= sampled.height - ROUNDING
    lengths = np.where(highest[:-1] & highest[1:], np.diff(sampled.points), 0.0)
    middles = 0.5 * (sampled.points[:-1] + sampled.points[1:])
    return (
        float(lengths @ middles / lengths.sum())
        if lengths.any()
        else float(sampled.points[highest].mean())
    )


def _maxima(fuzzy_set: Type1Set) -> tuple[float, float]:
    maxima = fuzzy_set.maxima
    if maxima is None:
        raise NotApplicable(
            "a defuzzifier of maxima",
            f"{fuzzy_set!r} approaches its greatest membership but never reaches it",
        )
    return maxima


def _named(method: str, rules: MappingProxyType[str, Rule]) -> Rule:
    known_name("defuzzifier", method, rules)
    return rules[method]


def _centroids(x: Array, u: Array) -> Array:
    # Moments are taken about the middle point, so that a set far from 0 keeps its digits.
    origin = x[x.size // 2]
    return np.asarray(origin + (u @ (x - origin)) / u.sum(axis=-1))


def _bisectors(x: Array, u: Array) -> Array:
    total = np.cumsum(u, axis=-1)
    share = total / total[..., -1:]
    # The first point with half of the weight up to it, and the first with more than half. If they
    # differ, the result is midway between them.
    low, high = (np.argmax(share >= 0.5 + offset, axis=-1) for offset in (-ROUNDING, ROUNDING))
    return np.asarray(0.5 * (x[low] + x[high]))


def _first_maxima(x: Array, u: Array) -> Array:
    return np.asarray(x[np.argmax(u >= 1.0 - ROUNDING, axis=-1)])


def _last_maxima(x: Array, u: Array) -> Array:
    return np.asarray(x[x.size - 1 - np.argmax(u[..., ::-1] >= 1.0 - ROUNDING, axis=-1)])


def _mean_maxima(x: Array, u: Array) -> Array:
    return _centroids(
        x, np.where(np.isnan(u).any(axis=-1, keepdims=True), np.nan, u >= 1.0 - ROUNDING)
    )


_OF_SETS: MappingProxyType[str, Callable[[Type1Set], float]] = MappingProxyType(
    {
        "centroid": centroid,
        "bisector": bisector,
        "height": height,
        "smallest_of_maxima": smallest_of_maxima,
        "mean_of_maxima": mean_of_maxima,
        "largest_of_maxima": largest_of_maxima,
    }
)
_OF_SAMPLES: MappingProxyType[str, Callable[[Array, Array], Array]] = MappingProxyType(
    {
        "centroid": _centroids,
        "bisector": _bisectors,
        "height": _mean_maxima,
        "smallest_of_maxima": _first_maxima,
        "mean_of_maxima": _mean_maxima,
        "largest_of_maxima": _last_maxima,
    }
)
METHODS = tuple(_OF_SETS)
"""Names of the defuzzifiers, see :func:`defuzzify`."""
