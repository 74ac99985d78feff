r"""Join, meet and negation of secondary memberships, which stand for *or*, *and* and *not*.

See eq. 1.9-1.15, 1.28 and 1.29.

.. math:: F \sqcup G = \int_u \int_w \frac{f(u) * g(w)}{u \vee w}, \qquad
    F \sqcap G = \int_u \int_w \frac{f(u) * g(w)}{u \star w}, \qquad
    \neg F = \int_u \frac{f(u)}{1 - u}

Two t-norms are involved. The memberships u and w are combined by ``t_norm`` in a meet and by
``t_conorm`` in a join. The grades f(u) and g(w) are combined by ``grade_t_norm``, which is
``t_norm`` by default. As in the thesis, the join takes the maximum of memberships under every
t-norm unless another t-conorm is given.

If all sets are discrete (`SampledSet`, `Singleton`), the result is an exact discrete set. If at
least one set is a function, the result is a function, which is evaluated on demand; sampled sets
among the operands are then interpolated linearly.

Both operations are commutative, and associative up to rounding errors. De Morgan's laws hold for
the maximum with the minimum and for any other dual pair, but not for the maximum with the product.
Absorption, idempotence and distributivity hold for convex normal sets under the minimum (for
memberships and for grades) only.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import reduce
from typing import Literal, TypeAlias

import numpy as np

from fuzzy2.errors import InvalidValue, NotApplicable
from fuzzy2.operations.continuous_meet import ContinuousMeet
from fuzzy2.operations.extension import discrete_points, enumerated, is_discrete, require_sets
from fuzzy2.operations.joined_sets import (
    ROUNDING,
    ExtremumSet,
    NegatedSet,
    best_of_pairs,
    brief,
    extremum_of_grades,
    peaks_of,
)
from fuzzy2.operations.t_norms import T_CONORMS, T_NORMS, BinaryFunction, TConorm, TNorm
from fuzzy2.operations.t_norms import t_conorm as as_t_conorm
from fuzzy2.operations.t_norms import t_norm as as_t_norm
from fuzzy2.sets.derived import Truncated
from fuzzy2.sets.shapes import Gaussian, Interval, Trapezoidal, Triangular
from fuzzy2.sets.sigmoids import Sigmoid
from fuzzy2.sets.smooth_shapes import Bell
from fuzzy2.sets.type1 import SampledSet, Singleton, Type1Set
from fuzzy2.support.checks import Array, known_name

TNormLike: TypeAlias = str | TNorm | BinaryFunction
TConormLike: TypeAlias = str | TConorm | BinaryFunction
Method: TypeAlias = Literal["auto", "theorem_1_1", "intervals", "shift", "general"]

METHODS = ("auto", "theorem_1_1", "intervals", "shift", "general")


def join(
    *sets: Type1Set,
    t_norm: TNormLike = "min",
    grade_t_norm: TNormLike | None = None,
    t_conorm: TConormLike = "max",
    method: Method = "auto",
) -> Type1Set:
    r"""Return the join of secondary memberships (eq. 1.9; the second 1.12).

    Parameters
    ----------
    *sets : Type1Set
        Two or more secondary memberships.
    t_norm : str, TNorm or callable
        The t-norm of the logic; a join uses it only as the default of ``grade_t_norm``.
    grade_t_norm : str, TNorm or callable, optional
        How the grades are combined.
    t_conorm : str, TConorm or callable
        How the memberships are combined.
    method : {"auto", "theorem_1_1", "intervals", "shift", "general"}
        Theorem 1.1 (eq. 1.14, or 1.28 if grades are not combined by the minimum), the interval
        theorem (1.29), the shift corollary, or the general method, which has no conditions. "auto"
        takes the first that applies of "intervals", "shift", "theorem_1_1" and "general". All
        methods give the same set.

    Returns
    -------
    Type1Set
        `SampledSet` or `Singleton` if all sets are discrete; `Interval` if all are intervals; else
        a function. Its values are exact up to rounding for the maximum, and otherwise as accurate
        as those of `meet`.

    Raises
    ------
    NotApplicable
        If the conditions of the requested method do not hold, or if the t-conorm is not continuous
        and a set is not discrete.
    InvalidValue
        If a t-conorm other than the maximum is applied to memberships outside [0, 1].
    """
    require_sets(sets)
    conorm = as_t_conorm(t_conorm)
    as_t_norm(t_norm)
    grade_norm = as_t_norm(t_norm if grade_t_norm is None else grade_t_norm)
    if conorm is T_CONORMS["max"]:
        return _extremum("join", sets, grade_norm, method)
    what = f"the join by the t-conorm {conorm.name}"
    # The join is computed by duality, so intervals and functions need no formulas of their own.
    # Negating them costs one rounding.
    if all(isinstance(operand, Interval | Singleton) for operand in sets) and method in (
        "auto",
        "intervals",
    ):
        return _interval_theorem(sets, conorm, conorm.dual.continuous, what)
    _require_general(method, what)
    if all(is_discrete(operand) for operand in sets):
        return _enumerated(sets, conorm, grade_norm)
    return negation(
        _continuous_meet([negation(operand) for operand in sets], conorm.dual, grade_norm)
    )


def meet(
    *sets: Type1Set,
    t_norm: TNormLike = "min",
    grade_t_norm: TNormLike | None = None,
    method: Method = "auto",
) -> Type1Set:
    r"""Return the meet of secondary memberships (eq. 1.10; the first 1.12).

    Parameters
    ----------
    *sets : Type1Set
        Two or more secondary memberships.
    t_norm : str, TNorm or callable
        How the memberships are combined.
    grade_t_norm : str, TNorm or callable, optional
        How the grades are combined; the same t-norm by default.
    method : {"auto", "theorem_1_1", "intervals", "shift", "general"}
        Theorem 1.1 (eq. 1.15, only for the minimum of memberships), the interval theorem (1.29),
        the shift corollary, or the general method, which has no conditions. "auto" takes the first
        that applies of "intervals", "shift", "theorem_1_1" and "general". All methods give the same
        set.

    Returns
    -------
    Type1Set
        `SampledSet` or `Singleton` if all sets are discrete; `Interval` if all are intervals; else
        a function. Under the minimum of memberships its values are exact up to rounding. Under
        another t-norm it is 0 outside [0, 1], where the sets are cut off. Its values are then
        accurate to 1e-12 for convex sets and the minimum of grades, and to 1e-8 otherwise (1e-7
        times the number of sets if there are three or more), provided that the features of the sets
        are wider than 1/1000.

    Raises
    ------
    NotApplicable
        If the conditions of the requested method do not hold, or if the t-norm is not continuous
        and a set is not discrete.
    InvalidValue
        If a t-norm other than the minimum is applied to memberships outside [0, 1].

    See Also
    --------
    fuzzy2.gaussian_meet : the closed form (1.30) for Gaussian sets under the product,
        which is an approximation.
    """
    require_sets(sets)
    norm = as_t_norm(t_norm)
    grade_norm = norm if grade_t_norm is None else as_t_norm(grade_t_norm)
    if norm is T_NORMS["min"]:
        return _extremum("meet", sets, grade_norm, method)
    what = f"the meet by the t-norm {norm.name}"
    if all(isinstance(operand, Interval | Singleton) for operand in sets) and method in (
        "auto",
        "intervals",
    ):
        return _interval_theorem(sets, norm, norm.continuous, what)
    _require_general(method, what)
    if all(is_discrete(operand) for operand in sets):
        return _enumerated(sets, norm, grade_norm)
    return _continuous_meet(sets, norm, grade_norm)


def negation(fuzzy_set: Type1Set) -> Type1Set:
    r"""Return the negation of a secondary membership (eq. 1.11).

    It has the same class as the set if the class is closed under negation.

    .. math:: \neg F = \int_u f(u) / (1 - u)

    Parameters
    ----------
    fuzzy_set : Type1Set
        The secondary membership.

    Returns
    -------
    Type1Set
        The set mirrored at 1/2.
    """
    require_sets([fuzzy_set])
    match fuzzy_set:
        case Gaussian(mean=mean):
            return replace(fuzzy_set, mean=1.0 - mean)
        case Triangular(left=left, peak=peak, right=right):
            return replace(fuzzy_set, left=1.0 - right, peak=1.0 - peak, right=1.0 - left)
        case Trapezoidal(a=a, b=b, c=c, d=d):
            return replace(fuzzy_set, a=1.0 - d, b=1.0 - c, c=1.0 - b, d=1.0 - a)
        case Interval(left=left, right=right):
            return Interval(1.0 - right, 1.0 - left)
        case Singleton(point=point):
            return Singleton(1.0 - point)
        case Bell(center=center):
            return replace(fuzzy_set, center=1.0 - center)
        case Sigmoid(center=center, slope=slope):
            return Sigmoid(1.0 - center, -slope)
        case SampledSet(points=points, grades=grades):
            return SampledSet(1.0 - points, grades)
        case NegatedSet(original=original):
            return original
        case _:
            return NegatedSet(fuzzy_set)


# --- discrete sets --------------------------------------------------------------------------------


def _as_discrete(sets: Sequence[Type1Set], result: SampledSet) -> Type1Set:
    """Return a discrete set as a `Singleton` if all operands are singletons."""
    return (
        Singleton(float(result.points[0]))
        if all(isinstance(operand, Singleton) for operand in sets)
        else result
    )


def _enumerated(sets: Sequence[Type1Set], combine: TNorm | TConorm, grade_norm: TNorm) -> Type1Set:
    """Return the join or meet of discrete sets under any norm, by enumerating pairs.

    Equal points are merged after each operand, which keeps the number of points small.
    """
    operands = [discrete_points(operand) for operand in sets]
    for points, _ in operands:
        if points[0] < 0.0 or points[-1] > 1.0:
            raise InvalidValue(
                "the memberships of a set",
                points[[0, -1]],
                f"in [0, 1], where the norm {combine.name} is defined",
            )

    def paired(first: SampledSet, second: tuple[Array, Array]) -> SampledSet:
        return enumerated(combine, [(first.points, first.grades), second], grade_norm)

    return _as_discrete(sets, reduce(paired, operands[1:], SampledSet(*operands[0])))


def _discrete_extremum(kind: str, sets: Sequence[Type1Set], grade_norm: TNorm) -> Type1Set:
    r"""Return the join by the maximum, or the meet by the minimum, of discrete sets.

    The sets may have any shape; the cost is O(N log N).

    The maximum of a pair is :math:`\theta` if one member is :math:`\theta` and the other is not
    greater. So eq. 1.17,

    .. math:: \mu(\theta) = \max_i \Big( f_i(\theta) * \mathop{*}_{j \ne i}
              \sup_{w \le \theta} f_j(w) \Big)

    needs no enumeration of pairs under any t-norm of the grades.
    """
    sign = 1.0 if kind == "join" else -1.0
    operands = []
    for operand in sets:
        points, grades = discrete_points(operand)
        order = slice(None) if sign > 0.0 else slice(None, None, -1)
        operands.append((sign * points[order], grades[order]))
    theta = np.unique(np.concatenate([points for points, _ in operands]))
    theta = theta[theta >= max(points[0] for points, _ in operands)]
    own, reached = [], []
    for points, grades in operands:
        place = np.searchsorted(points, theta, side="right") - 1
        own.append(np.where(points[place] == theta, grades[place], 0.0))
        reached.append(np.maximum.accumulate(grades)[place])
    return _as_discrete(sets, SampledSet(sign * theta, best_of_pairs(own, reached, grade_norm)))


# --- fast paths -----------------------------------------------------------------------------------


def _require_known(method: str) -> None:
    known_name("method", method, METHODS)


def _require_general(method: str, what: str) -> None:
    _require_known(method)
    if method == "theorem_1_1":
        raise NotApplicable(
            "Theorem 1.1",
            f"it holds for the minimum and the maximum of memberships, and this is {what}",
        )
    if method == "shift":
        raise NotApplicable(
            "the shift corollary", f"it holds for the minimum only, and this is {what}"
        )
    if method == "intervals":
        raise NotApplicable("the interval theorem (1.29)", "not all sets are intervals")


def _interval_theorem(
    sets: Sequence[Type1Set], combine: TNorm | TConorm, continuous: bool, what: str
) -> Type1Set:
    """Return the interval between the combined left and the combined right ends (1.29)."""
    if not all(isinstance(operand, Interval | Singleton) for operand in sets):
        raise NotApplicable("the interval theorem (1.29)", "not all sets are intervals")
    ends = np.array([operand.support for operand in sets])
    if (
        combine not in (T_NORMS["min"], T_CONORMS["max"])
        and not ((ends >= 0.0) & (ends <= 1.0)).all()
    ):
        raise InvalidValue(
            "the ends of the intervals",
            ends,
            f"in [0, 1], where the norm {combine.name} is defined",
        )
    left, right = (float(end) for end in combine.reduce(ends, axis=0))
    if all(isinstance(operand, Singleton) for operand in sets):
        return Singleton(left)
    if not continuous:
        raise NotApplicable(
            "the interval theorem (1.29)",
            f"{what} is not continuous and may leave gaps; sample the intervals",
        )
    # Rounding may swap the ends of a narrow interval.
    return Interval(min(left, right), max(left, right))


def _extremum(
    kind: Literal["join", "meet"], sets: Sequence[Type1Set], grade_norm: TNorm, method: Method
) -> Type1Set:
    """Return the join by the maximum or the meet by the minimum."""
    _require_known(method)
    if len(sets) == 1:
        return sets[0]
    if method == "intervals" or (
        method == "auto" and all(isinstance(operand, Interval | Singleton) for operand in sets)
    ):
        return _interval_theorem(
            sets, T_CONORMS["max"] if kind == "join" else T_NORMS["min"], True, f"the {kind}"
        )
    if method in ("auto", "shift"):
        reason = _why_no_shift(sets, grade_norm)
        if reason is None:
            return (max if kind == "join" else min)(
                sets, key=lambda operand: operand.maxima or (0.0, 0.0)
            )
        if method == "shift":
            raise NotApplicable("the shift corollary", reason)
    discrete = all(is_discrete(operand) for operand in sets)
    if method == "theorem_1_1":
        reason = _why_no_theorem(sets)
        if reason is not None:
            raise NotApplicable("Theorem 1.1", reason)
        if discrete:
            return _discrete_theorem(kind, sets, grade_norm)
    if discrete:
        return _discrete_extremum(kind, sets, grade_norm)
    by_theorem = method != "general" and _why_no_theorem(sets) is None
    return ExtremumSet(kind, tuple(sets), grade_norm, by_theorem)


def _shape_of(operand: Type1Set) -> tuple[object, ...] | None:
    """Return the parameters of a set that a shift does not change, or None if it has none."""
    match operand:
        case Gaussian(sigma=sigma, height=height):
            return Gaussian, sigma, height
        case Triangular(left=left, peak=peak, right=right, height=height):
            return Triangular, left - peak, right - peak, height
        case Trapezoidal(a=a, b=b, c=c, d=d, height=height) if math.isfinite(a) and math.isfinite(
            d
        ):
            return Trapezoidal, a - b, c - b, d - b, height
        case Bell(width=width, slope=slope):
            return Bell, width, slope
        case _:
            return None


def _why_no_shift(sets: Sequence[Type1Set], grade_norm: TNorm) -> str | None:
    """Return why the shift corollary does not hold, or None if it does."""
    if grade_norm is not T_NORMS["min"]:
        return f"it holds for the minimum only, and the grades are combined by {grade_norm.name}"
    if not all(operand.is_normal() for operand in sets):
        return "not all sets are normal"
    shapes = [_shape_of(operand) for operand in sets]
    first = shapes[0]
    for operand, shape in zip(sets, shapes, strict=True):
        if first is None or shape is None:
            return f"{brief(operand)} has no parameters that tell its shape from its place"
        if shape[0] is not first[0] or not np.allclose(
            np.array(shape[1:], dtype=float),
            np.array(first[1:], dtype=float),
            rtol=0.0,
            atol=ROUNDING,
        ):
            return f"{brief(operand)} is not {brief(sets[0])} shifted"
    return None


def _why_no_theorem(sets: Sequence[Type1Set]) -> str | None:
    """Return why Theorem 1.1 does not hold, or None if it does."""
    for operand in sets:
        if operand.core is None:
            why = (
                f"its height is {operand.height:g}"
                if operand.maxima
                else "it approaches its height but never reaches it"
            )
            return f"{brief(operand)} is not normal: {why}"
        if not operand.is_convex():
            return f"{brief(operand)} is not convex"
    if all(is_discrete(operand) for operand in sets):
        points = [discrete_points(operand)[0] for operand in sets]
        if any(other.size != points[0].size or (other != points[0]).any() for other in points[1:]):
            return (
                "the discrete sets are not given at the same points, so that at a point of one "
                "the others are 0, which is not convex"
            )
    return None


def _discrete_theorem(kind: str, sets: Sequence[Type1Set], grade_norm: TNorm) -> Type1Set:
    points = discrete_points(sets[0])[0]
    grades = np.stack([discrete_points(operand)[1] for operand in sets])
    return _as_discrete(
        sets,
        SampledSet(
            points, extremum_of_grades(kind, points, peaks_of(kind, sets), grades, grade_norm)
        ),
    )


# --- meets under t-norms other than the minimum ---------------------------------------------------


def _continuous_meet(sets: Sequence[Type1Set], norm: TNorm, grade_norm: TNorm) -> Type1Set:
    if not norm.continuous:
        raise NotApplicable(
            f"the meet of functions by the t-norm {norm.name}",
            "it is not continuous, so that the result has jumps everywhere; sample the sets",
        )
    if len(sets) == 1:
        return sets[0]
    return ContinuousMeet(
        tuple(_on_the_unit_interval(operand) for operand in sets), norm, grade_norm
    )


def _on_the_unit_interval(operand: Type1Set) -> Type1Set:
    """Return a secondary membership cut off outside [0, 1], where t-norms are not defined."""
    left, right = operand.support
    if left >= 0.0 and right <= 1.0:
        return operand
    if isinstance(operand, SampledSet | Singleton | Interval):
        raise InvalidValue(
            "the memberships of a set", (left, right), "in [0, 1], where t-norms are defined"
        )
    return Truncated(operand, 0.0, 1.0)
