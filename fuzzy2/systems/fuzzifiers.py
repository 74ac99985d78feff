r"""Fuzzifiers, which turn measured numbers into fuzzy inputs.

They also compute the firing set of a term for a fuzzy input.

The firing set of a term :math:`\tilde F` for the fuzzy input :math:`\tilde X` of a measured
:math:`x'` is (the brackets of eq. 1.121)

.. math:: \coprod_{x} \mu_{\tilde X}(x) \sqcap \mu_{\tilde F}(x),

It is :math:`\mu_{\tilde F}(x')` for a singleton (eq. 1.122, 1.123). If all secondary sets are
intervals, joins and meets are computed end by end (eq. 1.29), and the ends of the firing set are

.. math:: \sup_x \underline\mu_{\tilde X}(x) * \underline\mu_{\tilde F}(x), \qquad
    \sup_x \overline\mu_{\tilde X}(x) * \overline\mu_{\tilde F}(x),

They are equal for type-1 sets. General type-2 sets are computed α-plane by α-plane, which is exact
for the minimum of secondary grades. Products of secondary grades are refused, because the join over
a continuous domain would then depend on how finely the domain is sampled, and eq. 1.121, which
takes it input by input, would differ from eq. 1.120.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fuzzy2.errors import InvalidValue, NotApplicable
from fuzzy2.operations.t_norms import BinaryFunction, TNorm
from fuzzy2.operations.t_norms import t_norm as norm_of
from fuzzy2.sets.general_type2 import GeneralType2Set
from fuzzy2.sets.interval_type2 import IntervalType2Set
from fuzzy2.sets.shapes import Gaussian
from fuzzy2.sets.sigmoids import Sigmoid
from fuzzy2.sets.type1 import Singleton, Type1Set
from fuzzy2.sets.uncertain_mean import FarthestMeanGaussian, NearestMeanGaussian
from fuzzy2.support.checks import Array, of_kind, reals

AnySet: TypeAlias = Type1Set | IntervalType2Set | GeneralType2Set
TNormLike: TypeAlias = str | TNorm | BinaryFunction

# Search for a supremum without a closed form: number of points between two landmarks, for sets that
# rise and fall once and for others; then grids of 17 points around the highest four peaks, each an
# eighth as wide as the one before.
_BETWEEN, _BETWEEN_IF_NOT_CONVEX = 32, 128
_PEAKS, _CLOSER_POINTS, _CLOSER_GRIDS = 4, 17, 12
_HALVINGS = 80
# Grades that are held in memory at once: 32 MiB per array.
_CHUNK = 1 << 22


class Fuzzifier(ABC):
    """Base of the fuzzifiers."""

    @abstractmethod
    def firing(self, term: AnySet, x: ArrayLike, t_norm: TNormLike = "product") -> Array:
        """Return the firing intervals of a term for measured inputs.

        Parameters
        ----------
        term : type-1, interval or general type-2 set
            Term of an input. For a general type-2 set the footprint of uncertainty is used.
        x : (...,) array_like
            Measured inputs.
        t_norm : str, TNorm or callable
            T-norm that combines the memberships of input and term.

        Returns
        -------
        (..., 2) array
            Lower and upper ends; NaN where the input is NaN. They are equal if input and term are
            type-1 sets.

        Raises
        ------
        InvalidValue
            If an input is infinite.
        """

    @abstractmethod
    def firing_planes(
        self,
        term: AnySet,
        x: ArrayLike,
        alphas: ArrayLike,
        t_norm: TNormLike = "product",
        grade_t_norm: TNormLike = "min",
    ) -> Array:
        """Return the α-cuts of the firing sets of a term for measured inputs.

        Parameters
        ----------
        term : type-1, interval or general type-2 set
            Term of an input.
        x : (...,) array_like
            Measured inputs.
        alphas : (L,) array_like
            Levels of the secondary grades, in [0, 1].
        t_norm : str, TNorm or callable
            T-norm that combines the memberships of input and term.
        grade_t_norm : str, TNorm or callable
            T-norm of the secondary grades; the minimum, unless they are all 1.

        Returns
        -------
        (..., L, 2) array
            Lower and upper ends at each level; NaN where the input is NaN.

        Raises
        ------
        NotApplicable
            If a fuzzy input or its term is a general type-2 set, and the secondary grades are not
            combined by the minimum.
        InvalidValue
            If an input is infinite, or a level is not in [0, 1].
        """


@dataclass(frozen=True)
class SingletonFuzzifier(Fuzzifier):
    """Fuzzifier that takes the measured input as it is (eq. 1.122)."""

    def firing(self, term: AnySet, x: ArrayLike, t_norm: TNormLike = "product") -> Array:
        """Return the memberships of the inputs in the term; see :meth:`Fuzzifier.firing`."""
        # checked although it is not used, so that a misspelled name is found at once
        norm_of(t_norm)
        check_set("term", term)
        points = _measured(x)
        return np.stack([term.lower(points), term.upper(points)], axis=-1)

    def firing_planes(
        self,
        term: AnySet,
        x: ArrayLike,
        alphas: ArrayLike,
        t_norm: TNormLike = "product",
        grade_t_norm: TNormLike = "min",
    ) -> Array:
        """Return the α-cuts of the memberships of the inputs in the term.

        See :meth:`Fuzzifier.firing_planes`.
        """
        norm_of(grade_t_norm)
        return np.stack(
            [self.firing(_plane(term, alpha), x, t_norm) for alpha in _levels(alphas)], axis=-2
        )


@dataclass(frozen=True)
class NonSingletonFuzzifier(Fuzzifier):
    r"""Fuzzifier that replaces the measured input with a fuzzy set around it (eq. 1.120, 1.121).

    .. math:: \mu_{\tilde X}(x) = \mu_{\text{shape}}(x - x')

    Parameters
    ----------
    shape : type-1, interval or general type-2 set
        Fuzzy set of the input for a measurement of 0. Take ``Gaussian(0, s)`` for a sensor with
        noise of standard deviation s, and an interval type-2 set if only bounds of the noise are
        known. Its upper membership should reach 1 at 0, because otherwise no term can fire fully.
    """

    shape: AnySet

    def __post_init__(self) -> None:
        check_set("shape", self.shape)

    def firing(self, term: AnySet, x: ArrayLike, t_norm: TNormLike = "product") -> Array:
        """Return the firing intervals of the term for the fuzzy inputs.

        See :meth:`Fuzzifier.firing` and :func:`sup_star`.
        """
        check_set("term", term)
        points, norm = _measured(x), norm_of(t_norm)
        lower = sup_star(self.shape.lower, term.lower, points, norm)
        if isinstance(self.shape, Type1Set) and isinstance(term, Type1Set):
            return np.stack([lower, lower], axis=-1)
        return np.stack([lower, sup_star(self.shape.upper, term.upper, points, norm)], axis=-1)

    def firing_planes(
        self,
        term: AnySet,
        x: ArrayLike,
        alphas: ArrayLike,
        t_norm: TNormLike = "product",
        grade_t_norm: TNormLike = "min",
    ) -> Array:
        """Return the α-cuts of the firing sets of the term for the fuzzy inputs.

        See :meth:`Fuzzifier.firing_planes`.
        """
        norm, grade_norm = norm_of(t_norm), norm_of(grade_t_norm)
        if grade_norm is not norm_of("min") and (
            isinstance(self.shape, GeneralType2Set) or isinstance(term, GeneralType2Set)
        ):
            raise NotApplicable(
                "non-singleton fuzzification",
                f"with secondary grades combined by {grade_norm.name} the firing set depends on "
                "how finely the input is sampled; use the minimum",
            )
        if not isinstance(self.shape, GeneralType2Set) and not isinstance(term, GeneralType2Set):
            return np.stack([self.firing(term, x, norm)] * len(_levels(alphas)), axis=-2)
        planes = [
            NonSingletonFuzzifier(_plane(self.shape, alpha)).firing(_plane(term, alpha), x, norm)
            for alpha in _levels(alphas)
        ]
        return np.stack(planes, axis=-2)


def sup_star(
    shape: Type1Set, term: Type1Set, x: ArrayLike = 0.0, t_norm: TNormLike = "product"
) -> Array:
    r"""Return the sup-star match of a fuzzy input and a term (eq. 1.62).

    It is :math:`\sup_x \mu_{\text{shape}}(x - x') * \mu_{\text{term}}(x)`.

    For Gaussians of means :math:`x' + m_1, m_2` and standard deviations :math:`\sigma_1, \sigma_2`
    it has a closed form,

    .. math::

        h_1 h_2 \exp\left(-\frac{(x' + m_1 - m_2)^2}{2(\sigma_1^2 + \sigma_2^2)}\right)
        \text{ (product)}, \qquad
        \exp\left(-\frac{(x' + m_1 - m_2)^2}{2(\sigma_1 + \sigma_2)^2}\right)
        \text{ (minimum, equal heights 1)},

    attained at :math:`x^* = (\sigma_2^2 (x' + m_1) + \sigma_1^2 m_2) / (\sigma_1^2 + \sigma_2^2)`
    and at the crossing :math:`(\sigma_2 (x' + m_1) + \sigma_1 m_2) / (\sigma_1 + \sigma_2)`. Both
    bounds of a Gaussian with an uncertain mean are handled alike, with :math:`x^*` limited by their
    kinks. Under the minimum, convex sets cross once between their maxima, and the crossing is found
    up to rounding. Other suprema are searched on a grid that closes in on its best points, only
    between the maxima if both sets are convex. The search is accurate to 1e-9 for sets without
    features narrower than 1/32 of the distance between two landmarks.

    Parameters
    ----------
    shape : Type1Set
        Fuzzy set of the input for a measurement of 0.
    term : Type1Set
        Term of the input.
    x : (...,) array_like
        Measured inputs :math:`x'`.
    t_norm : str, TNorm or callable
        T-norm that combines both memberships.

    Returns
    -------
    (...,) array
        Grades; NaN where the input is NaN.

    Raises
    ------
    InvalidValue
        If an input is infinite.

    Notes
    -----
    Mouzouris and Mendel, "Nonsingleton fuzzy logic systems: theory and application", IEEE
    Transactions on Fuzzy Systems 5 (1997).
    """
    points, norm = _measured(x), norm_of(t_norm)
    missing = np.isnan(points)
    shifts = np.where(missing, 0.0, points)
    if isinstance(shape, Singleton):
        grades = term.membership(shifts + shape.point)
    elif isinstance(term, Singleton):
        grades = shape.membership(term.point - shifts)
    else:
        first, second = _bell_of(shape), _bell_of(term)
        if first and second and norm is norm_of("product"):
            grades = _gaussian_match(first, second, shifts, by_product=True)
        elif first and second and norm is norm_of("min") and first.height == second.height:
            grades = _gaussian_match(first, second, shifts, by_product=False)
        else:
            grades = _searched(shape, term, shifts, norm)
    return np.where(missing, np.nan, grades)[()]


def check_set(name: str, value: object) -> None:
    """Raise :class:`InvalidValue` if a value is not a fuzzy set."""
    kinds = (Type1Set, IntervalType2Set, GeneralType2Set)
    of_kind(name, value, kinds, "a type-1, interval type-2 or general type-2 set")


def _measured(x: ArrayLike) -> Array:
    points = reals("x", x)
    if np.isinf(points).any():
        raise InvalidValue("x", points, "finite measured inputs, or NaN where there is none")
    return points


def _levels(alphas: ArrayLike) -> list[float]:
    levels = reals("alphas", alphas)
    if levels.ndim != 1 or levels.size == 0 or not ((levels >= 0.0) & (levels <= 1.0)).all():
        raise InvalidValue("alphas", alphas, "levels in [0, 1], at least one")
    return [float(level) for level in levels]


def _plane(any_set: AnySet, alpha: float) -> Type1Set | IntervalType2Set:
    return any_set.alpha_plane(alpha) if isinstance(any_set, GeneralType2Set) else any_set


class _GaussianBell(NamedTuple):
    r"""Gaussian of the distance :math:`\max(0, |x - c| + o)`.

    It is an ordinary Gaussian for the offset o = 0, and has a flat top for o < 0 and a kink for o >
    0.
    """

    center: float
    offset: float
    sigma: float
    height: float


def _bell_of(membership: Type1Set) -> _GaussianBell | None:
    match membership:
        case Gaussian(mean=mean, sigma=sigma, height=height):
            return _GaussianBell(mean, 0.0, sigma, height)
        case NearestMeanGaussian(mean=(left, right), sigma=sigma):
            return _GaussianBell(0.5 * left + 0.5 * right, -0.5 * (right - left), sigma, 1.0)
        case FarthestMeanGaussian(mean=(left, right), sigma=sigma):
            # The height belongs to the Gaussian, and a positive offset keeps the membership below
            # it.
            return _GaussianBell(0.5 * left + 0.5 * right, 0.5 * (right - left), sigma, 1.0)
    return None


def _gaussian_match(
    first: _GaussianBell, second: _GaussianBell, shifts: Array, by_product: bool
) -> Array:
    """Return the supremum of two Gaussians of distances, which lies between their centers."""
    gap = np.abs(shifts + first.center - second.center)
    a, b = (first.sigma**2, second.sigma**2) if by_product else (first.sigma, second.sigma)
    # Distance from the first center toward the second. Both distances are convex in it, so the
    # optimum only has to be kept within its bounds.
    way = np.clip((a * (gap + second.offset) - b * first.offset) / (a + b), 0.0, gap)
    u = np.maximum(way + first.offset, 0.0) / first.sigma
    v = np.maximum(gap - way + second.offset, 0.0) / second.sigma
    # far apart the squares are infinite and the grade is 0
    with np.errstate(under="ignore", over="ignore"):
        if by_product:
            return np.asarray(first.height * second.height * np.exp(-0.5 * (u * u + v * v)))
        return np.asarray(first.height * np.exp(-0.5 * np.maximum(u, v) ** 2))


def _searched(shape: Type1Set, term: Type1Set, shifts: Array, norm: TNorm) -> Array:
    """Return the supremum, found by search, for shifts (...,)."""
    own_maxima, other_maxima = _maxima(shape), _maxima(term)
    convex = (
        own_maxima is not None
        and other_maxima is not None
        and shape.is_convex()
        and term.is_convex()
    )
    own, other = shape.landmarks, term.landmarks
    per_row = (own.size + other.size + 1) * (_BETWEEN if convex else _BETWEEN_IF_NOT_CONVEX)
    rows = max(1, _CHUNK // per_row)
    flat = shifts.ravel()
    grades = np.empty(flat.size)
    for start in range(0, flat.size, rows):
        shift = flat[start : start + rows]
        # Landmarks are evaluated at their own places, not after two roundings, because an edge may
        # be vertical.
        at_own = norm(shape.membership(own), term.membership(own + shift[:, None]))
        at_other = norm(shape.membership(other - shift[:, None]), term.membership(other))
        best = np.maximum(at_own.max(axis=-1), at_other.max(axis=-1))
        if convex and own_maxima and other_maxima:
            found = _between_maxima(shape, term, shift, norm, own_maxima, other_maxima)
        else:
            everywhere = np.concatenate(
                [own + shift[:, None], np.broadcast_to(other, (shift.size, other.size))], axis=-1
            )
            found = _closing_in(
                shape,
                term,
                shift,
                norm,
                everywhere.min(axis=-1),
                everywhere.max(axis=-1),
                _BETWEEN_IF_NOT_CONVEX,
            )
        grades[start : start + rows] = np.maximum(best, found)
    return grades.reshape(shifts.shape)


def _maxima(membership: Type1Set) -> tuple[float, float] | None:
    """Return the first and the last point of the greatest membership.

    It is None if the supremum is approached but not reached. For a sigmoid it is the range in which
    the membership is within 1e-14 of 1.
    """
    if not isinstance(membership, Sigmoid):
        return membership.maxima
    points = membership.landmarks
    return (
        (float(points[-1]), math.inf) if membership.slope > 0.0 else (-math.inf, float(points[0]))
    )


def _between_maxima(
    shape: Type1Set,
    term: Type1Set,
    shift: Array,
    norm: TNorm,
    own_maxima: tuple[float, float],
    other_maxima: tuple[float, float],
) -> Array:
    """Return the supremum of the match of two convex sets.

    It lies between their maxima, where one set falls and the other one rises.
    """
    (own_first, own_last), (other_first, other_last) = own_maxima, other_maxima
    own_is_left = own_last + shift < other_first
    apart = own_is_left | (other_last < own_first + shift)
    together = norm(shape.height, term.height)
    left = np.where(own_is_left, own_last + shift, other_last)
    right = np.where(own_is_left, other_first, own_first + shift)
    left, right = np.where(apart, left, 0.0), np.where(apart, right, 0.0)
    if norm is not norm_of("min"):
        return np.where(
            apart, _closing_in(shape, term, shift, norm, left, right, _BETWEEN), together
        )
    sign = np.where(own_is_left, 1.0, -1.0)
    for _ in range(_HALVINGS):
        middle = 0.5 * (left + right)
        falling_is_above = sign * (shape.membership(middle - shift) - term.membership(middle)) > 0.0
        left, right = (
            np.where(falling_is_above, middle, left),
            np.where(falling_is_above, right, middle),
        )
    crossing = np.maximum(
        *(norm(shape.membership(end - shift), term.membership(end)) for end in (left, right))
    )
    return np.where(apart, crossing, together)


def _closing_in(
    shape: Type1Set,
    term: Type1Set,
    shift: Array,
    norm: TNorm,
    left: Array,
    right: Array,
    between: int,
) -> Array:
    """Return the greatest grade (rows,) between ``left`` and ``right`` (rows,).

    The search uses grids that close in on the best points.
    """
    own = shape.landmarks + shift[:, None]
    other = np.broadcast_to(term.landmarks, (shift.size, term.landmarks.size))
    edges = np.concatenate([own, other, left[:, None], right[:, None]], axis=-1)
    edges = np.sort(np.clip(edges, left[:, None], right[:, None]), axis=-1)
    steps = np.arange(between) / between
    points = (edges[:, :-1, None] + np.diff(edges, axis=-1)[:, :, None] * steps).reshape(
        shift.size, -1
    )
    points = np.concatenate([points, edges[:, -1:]], axis=-1)
    grades = norm(shape.membership(points - shift[:, None]), term.membership(points))
    padded = np.pad(grades, ((0, 0), (1, 1)), constant_values=-1.0)
    # Only the first of several equal neighbors is taken, because a plateau is one peak.
    peaks = np.where((grades > padded[:, :-2]) & (grades >= padded[:, 2:]), grades, -1.0)
    highest = np.argpartition(peaks, -min(_PEAKS, peaks.shape[1]), axis=-1)[:, -_PEAKS:]
    best = grades.max(axis=-1)
    for place in highest.T:
        best = np.maximum(best, _climbed(shape, term, shift, norm, points, place))
    return np.asarray(best)


def _climbed(
    shape: Type1Set,
    term: Type1Set,
    shift: Array,
    norm: TNorm,
    points: Array,
    place: NDArray[np.intp],
) -> Array:
    """Return the greatest grade (rows,) near one of the points (rows, P) in each row."""
    best = np.zeros(shift.size)
    rows = np.arange(shift.size)
    for _ in range(_CLOSER_GRIDS):
        center = points[rows, place][:, None]
        # Equal points lie side by side where landmarks were cut off, so the neighbors are the
        # nearest different points.
        before = np.where(points < center, points, -np.inf).max(axis=-1, keepdims=True)
        after = np.where(points > center, points, np.inf).min(axis=-1, keepdims=True)
        before, after = (
            np.where(np.isfinite(before), before, center),
            np.where(np.isfinite(after), after, center),
        )
        points = before + (after - before) * np.linspace(0.0, 1.0, _CLOSER_POINTS)
        grades = norm(shape.membership(points - shift[:, None]), term.membership(points))
        place = grades.argmax(axis=-1)
        best = np.maximum(best, grades[rows, place])
    return best
