r"""Union, intersection and complement of fuzzy sets of every type (eq. 1.9-1.11).

.. math::
    \mu_{\tilde A \cup \tilde B}(x) = \mu_{\tilde A}(x) \sqcup \mu_{\tilde B}(x), \qquad
    \mu_{\tilde A \cap \tilde B}(x) = \mu_{\tilde A}(x) \sqcap \mu_{\tilde B}(x), \qquad
    \mu_{\overline{\tilde A}}(x) = \neg \mu_{\tilde A}(x)

For type-1 sets the grades themselves are combined. For interval type-2 sets the lower grades are
combined with each other, and so are the upper grades (1.29). The result has the most general type
among the operands.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import TypeAlias

import numpy as np

from fuzzy2.errors import InvalidValue
from fuzzy2.operations.join_meet import TConormLike, TNormLike, join, meet, negation
from fuzzy2.operations.t_norms import t_conorm as as_t_conorm
from fuzzy2.operations.t_norms import t_norm as as_t_norm
from fuzzy2.sets.derived import Complement, FunctionalSet
from fuzzy2.sets.functional_type2 import FunctionalType2Set
from fuzzy2.sets.general_type2 import GeneralType2Set, SampledType2Set
from fuzzy2.sets.interval_type2 import IntervalType2Set
from fuzzy2.sets.type1 import Singleton, Type1Set
from fuzzy2.support.checks import Array
from fuzzy2.support.quadrature import merged

FuzzySet: TypeAlias = Type1Set | IntervalType2Set | GeneralType2Set
Slices: TypeAlias = Callable[[Sequence[Type1Set]], Type1Set]
Grades: TypeAlias = Callable[..., Array]


def union(
    *sets: FuzzySet,
    t_norm: TNormLike = "min",
    grade_t_norm: TNormLike | None = None,
    t_conorm: TConormLike = "max",
) -> FuzzySet:
    """Return the union of fuzzy sets (eq. 1.9).

    Parameters
    ----------
    *sets : Type1Set, IntervalType2Set or GeneralType2Set
        The sets, of any types.
    t_norm, grade_t_norm, t_conorm : str, norm or callable
        As in `fuzzy2.join`; the first two are used for general type-2 sets only.

    Returns
    -------
    Type1Set, IntervalType2Set or GeneralType2Set
        The union, of the most general type among the sets.

    Raises
    ------
    InvalidValue
        If an argument is not a fuzzy set.
    """
    # Not every kind of set uses all of them, but a misspelled name should raise at once.
    as_t_norm(t_norm if grade_t_norm is None else grade_t_norm)
    as_t_norm(t_norm)
    supports = _supports(sets)
    domain = min(left for left, _ in supports), max(right for _, right in supports)
    return _combined(
        sets,
        domain,
        as_t_conorm(t_conorm),
        lambda slices: join(*slices, t_norm=t_norm, grade_t_norm=grade_t_norm, t_conorm=t_conorm),
    )


def intersection(
    *sets: FuzzySet, t_norm: TNormLike = "min", grade_t_norm: TNormLike | None = None
) -> FuzzySet:
    """Return the intersection of fuzzy sets (eq. 1.10).

    Parameters
    ----------
    *sets : Type1Set, IntervalType2Set or GeneralType2Set
        The sets, of any types.
    t_norm, grade_t_norm : str, TNorm or callable
        As in `fuzzy2.meet`; the second is used for general type-2 sets only.

    Returns
    -------
    Type1Set, IntervalType2Set or GeneralType2Set
        The intersection, of the most general type among the sets.

    Raises
    ------
    InvalidValue
        If an argument is not a fuzzy set.
    """
    as_t_norm(t_norm if grade_t_norm is None else grade_t_norm)
    supports = _supports(sets)
    left, right = max(left for left, _ in supports), min(right for _, right in supports)
    # If the sets do not overlap, the intersection is empty, and a point between them serves as its
    # domain.
    domain = (left, right) if left <= right else (0.5 * (left + right),) * 2
    return _combined(
        sets,
        domain,
        as_t_norm(t_norm),
        lambda slices: meet(*slices, t_norm=t_norm, grade_t_norm=grade_t_norm),
    )


def complement(fuzzy_set: FuzzySet) -> FuzzySet:
    """Return the complement of a fuzzy set (eq. 1.11), whose support is unbounded.

    Parameters
    ----------
    fuzzy_set : Type1Set, IntervalType2Set or GeneralType2Set
        The set. The complement of a `SampledType2Set` is sampled at the same points.

    Returns
    -------
    Type1Set, IntervalType2Set or GeneralType2Set
        The complement, of the same type. The complement of a complement is the original set.

    Raises
    ------
    InvalidValue
        If the argument is not a fuzzy set.
    """
    _supports([fuzzy_set])
    if isinstance(fuzzy_set, SampledType2Set):
        return SampledType2Set(
            np.array(fuzzy_set.points), [negation(one) for one in fuzzy_set.slices]
        )
    if isinstance(fuzzy_set, Type1Set):
        return _complement(fuzzy_set)
    if isinstance(fuzzy_set, IntervalType2Set):
        return IntervalType2Set(
            lower=_complement(fuzzy_set.upper), upper=_complement(fuzzy_set.lower)
        )
    return FunctionalType2Set(
        lambda x: negation(fuzzy_set.secondary(x)),
        -math.inf,
        math.inf,
        _two_knots(fuzzy_set.landmarks),
    )


def _complement(fuzzy_set: Type1Set) -> Type1Set:
    return fuzzy_set.whole if isinstance(fuzzy_set, Complement) else Complement(fuzzy_set)


def _two_knots(landmarks: Array) -> tuple[float, ...]:
    """Return the landmarks, or two points beside the landmark if there is only one.

    An unbounded set needs at least two points that locate it.
    """
    if landmarks.size == 1:
        landmarks = landmarks[0] + np.array([-1.0, 0.0, 1.0])
    return tuple(landmarks.tolist())


def _supports(sets: Sequence[FuzzySet]) -> list[tuple[float, float]]:
    if not sets:
        raise InvalidValue("sets", sets, "at least one fuzzy set")
    for one in sets:
        if not isinstance(one, Type1Set | IntervalType2Set | GeneralType2Set):
            raise InvalidValue("sets", one, "fuzzy sets (give t-norms by keyword)")
    return [one.support for one in sets]


def _combined(
    sets: Sequence[FuzzySet], domain: tuple[float, float], combine: Grades, combine_slices: Slices
) -> FuzzySet:
    landmarks = merged(*(one.landmarks for one in sets))
    knots = _two_knots(
        landmarks[(landmarks >= domain[0]) & (landmarks <= domain[1])]
        if domain[0] < domain[1]
        else landmarks
    )

    def of_type_1(operands: Sequence[Type1Set]) -> Type1Set:
        return FunctionalSet(
            lambda x: combine(*(operand(x) for operand in operands)), *domain, knots
        )

    type_1 = [one for one in sets if isinstance(one, Type1Set)]
    if len(type_1) == len(sets):
        return of_type_1(type_1)
    bounded = [one for one in sets if not isinstance(one, GeneralType2Set)]
    if len(bounded) == len(sets):
        return IntervalType2Set(
            lower=of_type_1([one.lower for one in bounded]),
            upper=of_type_1([one.upper for one in bounded]),
        )
    sampled = [one for one in sets if isinstance(one, SampledType2Set)]
    if len(sampled) == len(sets) and all(one.points == sampled[0].points for one in sampled):
        slices = [
            combine_slices(column) for column in zip(*(one.slices for one in sampled), strict=True)
        ]
        return SampledType2Set(np.array(sampled[0].points), slices)
    return FunctionalType2Set(
        lambda x: combine_slices([_slice(one, x) for one in sets]), *domain, knots
    )


def _slice(fuzzy_set: FuzzySet, x: float) -> Type1Set:
    return (
        Singleton(float(fuzzy_set(x)))
        if isinstance(fuzzy_set, Type1Set)
        else fuzzy_set.secondary(x)
    )
