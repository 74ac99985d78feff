r"""Cardinality, fuzziness, similarity and order of type-1 and interval type-2 sets.

All measures are taken on the continuous domain.

Every measure of a type-1 set extends to the footprint of uncertainty: it becomes the interval of
the values of all embedded type-1 sets. Its ends belong to two embedded sets that are known in
closed form. A type-1 set is a footprint without width, so its intervals are points.

The integrals are computed by quadrature, as for the centroid. They are not normalized by the length
of the domain, which is infinite for Gaussians: cardinality and fuzziness are lengths in the unit of
the points. (D. Wu and J. M. Mendel, "Uncertainty measures for interval type-2 fuzzy sets",
Information Sciences 177, 2007; "A comparative study of ranking methods, similarity measures and
uncertainty measures for interval type-2 fuzzy sets", Information Sciences 179, 2009.)
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from fuzzy2.errors import InvalidValue, NotApplicable
from fuzzy2.sets.interval_type2 import IntervalType2Set
from fuzzy2.sets.type1 import Type1Set
from fuzzy2.support.checks import Array, listed
from fuzzy2.support.quadrature import Moments, merged

Footprint: TypeAlias = Type1Set | IntervalType2Set
"""A set with a lower and an upper membership function; for a type-1 set both are the set itself."""


def cardinality(fuzzy_set: Footprint) -> tuple[float, float]:
    r"""Return the cardinality: the interval of the areas of all embedded sets (Wu and Mendel 2007).

    .. math:: p(\tilde A) = \left[\int \underline\mu(x)\,dx,\ \int \overline\mu(x)\,dx\right]

    Parameters
    ----------
    fuzzy_set : Type1Set or IntervalType2Set
        The set.

    Returns
    -------
    left, right : float
        Ends of the interval, in the unit of the points; equal for a type-1 set, and 0 for a single
        point.

    Raises
    ------
    InvalidValue
        If the argument is not a type-1 or interval type-2 set.
    NotApplicable
        If the area of the upper membership is infinite.
    """
    points = _domain("cardinality", fuzzy_set)
    return _area(fuzzy_set.lower, points), _area(fuzzy_set.upper, points)


def fuzziness(fuzzy_set: Footprint) -> tuple[float, float]:
    r"""Return the fuzziness (entropy).

    It is the interval of the linear indices of fuzziness of all embedded type-1 sets.

    The linear index of fuzziness is twice the distance to the nearest crisp set. A grade of 0 or 1
    contributes 0, and a grade of 1/2 contributes 1. It is the simplest index that satisfies the
    axioms of De Luca and Termini:

    .. math:: f(A) = 2 \int \min(\mu(x),\ 1 - \mu(x))\,dx

    The least fuzzy embedded set takes, at every point, the grade of the footprint that is farthest
    from 1/2, and the fuzziest embedded set the grade that is closest to 1/2 (Wu and Mendel 2007):

    .. math::

        f(\tilde A) = \left[2 \int \min\left(\underline\mu(x),\ 1 - \overline\mu(x)\right) dx,\
                            2 \int \min\left(\overline\mu(x),\ 1 - \underline\mu(x),\
                            \tfrac{1}{2}\right) dx\right]

    (A. Kaufmann, "Introduction to the Theory of Fuzzy Subsets", Academic Press, 1975, for the
    index; A. De Luca and S. Termini, "A definition of a nonprobabilistic entropy in the setting of
    fuzzy sets theory", Information and Control 20, 1972, for the axioms.)

    Parameters
    ----------
    fuzzy_set : Type1Set or IntervalType2Set
        The set.

    Returns
    -------
    left, right : float
        Ends of the interval, in the unit of the points; equal for a type-1 set, and 0 for a crisp
        one.

    Raises
    ------
    InvalidValue
        If the argument is not a type-1 or interval type-2 set.
    NotApplicable
        If the area of the upper membership is infinite.
    """
    points = _domain("fuzziness", fuzzy_set)
    lower, upper = fuzzy_set.lower, fuzzy_set.upper

    # Near the top 1 - u is the rounding error of u, which quadrature relative to the integral
    # cannot resolve. So u is integrated along with it.
    def with_least(x: Array) -> Array:
        low, high = lower(x), upper(x)
        return high + np.minimum(low, 1.0 - high)

    def with_greatest(x: Array) -> Array:
        low, high = lower(x), upper(x)
        return high + np.minimum(np.minimum(high, 1.0 - low), 0.5)

    area = _area(upper, points)
    left, right = (
        2.0 * max(_area(integrand, points) - area, 0.0) for integrand in (with_least, with_greatest)
    )
    return left, right


def jaccard(first: Footprint, second: Footprint) -> float:
    r"""Return the Jaccard similarity of two sets (Wu and Mendel 2009).

    It is the area of their intersection divided by the area of their union.

    .. math::

        s(\tilde A, \tilde B) = \frac{\int \min(\overline\mu_A, \overline\mu_B)\,dx
            + \int \min(\underline\mu_A, \underline\mu_B)\,dx}
                                     {\int \max(\overline\mu_A, \overline\mu_B)\,dx
                                         + \int \max(\underline\mu_A, \underline\mu_B)\,dx}

    Parameters
    ----------
    first, second : Type1Set or IntervalType2Set
        The sets, of any of these types.

    Returns
    -------
    float
        The similarity, in [0, 1]: 1 only for equal memberships, 0 if the sets do not overlap. It
        does not depend on the order of the sets.

    Raises
    ------
    InvalidValue
        If an argument is not a type-1 or interval type-2 set.
    NotApplicable
        If the area of an upper membership is infinite, or both areas are zero.
    """
    points = _domain("jaccard", first, second)

    def intersection(x: Array) -> Array:
        return np.minimum(first.upper(x), second.upper(x)) + np.minimum(
            first.lower(x), second.lower(x)
        )

    def union(x: Array) -> Array:
        return np.maximum(first.upper(x), second.upper(x)) + np.maximum(
            first.lower(x), second.lower(x)
        )

    whole = _area(union, points)
    if whole == 0.0:
        raise NotApplicable(
            "jaccard", f"the memberships of {first!r} and {second!r} are zero almost everywhere"
        )
    # Each integral has its own rounding error, which must not make nearly equal sets more similar
    # than equal ones.
    return min(_area(intersection, points) / whole, 1.0)


def rank(sets: Iterable[Footprint]) -> NDArray[np.intp]:
    r"""Return the order of sets by the middle of their centroids (Wu and Mendel 2009).

    .. math:: c(\tilde A) = \tfrac{1}{2} \left(c_l(\tilde A) + c_r(\tilde A)\right)

    Parameters
    ----------
    sets : sequence of N Type1Set or IntervalType2Set
        The sets, of any of these types.

    Returns
    -------
    (N,) array of int
        Indices of the sets, from the smallest middle to the greatest, so ``[sets[i] for i in
        rank(sets)]`` is sorted. Sets with the same middle keep their order.

    Raises
    ------
    InvalidValue
        If there are no sets, or if one is not a type-1 or interval type-2 set.
    NotApplicable
        If a set has no finite centroid.
    """
    footprints = listed("sets", sets, "a sequence of fuzzy sets")
    if not footprints:
        raise InvalidValue("sets", sets, "at least one fuzzy set")
    _check(*footprints)
    return np.argsort([_middle(one) for one in footprints], kind="stable")


def _middle(fuzzy_set: Footprint) -> float:
    if isinstance(fuzzy_set, Type1Set):
        return fuzzy_set.centroid()
    left, right = fuzzy_set.centroid()
    return 0.5 * left + 0.5 * right


def _check(*sets: Footprint) -> None:
    for one in sets:
        if not isinstance(one, Type1Set | IntervalType2Set):
            raise InvalidValue(
                "fuzzy_set",
                one,
                "a type-1 or an interval type-2 set (of a general one take an alpha-plane)",
            )


def _domain(measure: str, *sets: Footprint) -> Array:
    """Return ascending points from end to end of all upper memberships.

    They include every known kink of the lower memberships.
    """
    _check(*sets)
    try:
        points = merged(*(one.upper.quadrature_points(power=0) for one in sets))
    except NotApplicable as error:
        raise NotApplicable(
            measure, f"{error.reason}; sample() the set on the domain that matters"
        ) from error
    kinks = merged(*(membership.landmarks for one in sets for membership in (one.lower, one.upper)))
    return merged(points, kinks[(kinks > points[0]) & (kinks < points[-1])])


def _area(integrand: Callable[[Array], Array], points: Array) -> float:
    """Return the integral from the first to the last point, 0 for a single point."""
    return (
        Moments(integrand, points, 0.5 * float(points[0]) + 0.5 * float(points[-1])).total[0]
        if points.size > 1
        else 0.0
    )
