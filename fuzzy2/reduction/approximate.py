r"""Approximate type reduction.

It computes the generalized centroid of fuzzy numbers to first order in the uncertainty of the
weights.

Theorem 1.6 replaces the quotient with an affine combination, under which fuzzy numbers of one kind
are closed:

.. math:: Y \approx \sum_l \left[(Z_l - c_l) \frac{h_l}{\sum_i h_i}
          + (W_l - h_l) \frac{c_l - \xi}{\sum_i h_i}\right] + \xi,
    \qquad \xi = \frac{\sum_l h_l c_l}{\sum_l h_l}

(eq. 1.85-1.87; the thesis prints :math:`\xi` divided by :math:`h_l`). The neglected terms are of
the order of the validity measure

.. math:: \frac{\sum_l \Delta_l}{\sum_l h_l} \ll 1

(eq. 1.88), which every result includes. The result is exact if all weights are crisp (eq. 1.102),
however wide the :math:`Z_l` are. In practice the measure is rarely small: it is 1/3 for sets whose
footprints are half as high as the sets.

The center of the result is the output of the type-1 system in the middle of the footprints,
whatever the uncertainty. So defuzzifying the result discards the uncertainty. The exact reducers in
:mod:`fuzzy2.reduction.interval` and :mod:`fuzzy2.reduction.general` do not have this defect.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Generic, NamedTuple, TypeAlias, TypeVar, overload

import numpy as np
from numpy.typing import ArrayLike

from fuzzy2.errors import InvalidValue, NotApplicable
from fuzzy2.numbers.affine import GaussianNumber, IntervalNumber
from fuzzy2.numbers.base import NumberTNorm
from fuzzy2.numbers.fuzzy_number import FuzzyNumber
from fuzzy2.sets.type1 import Type1Set
from fuzzy2.support.checks import Array, known_name, reals

STANDARD_DEVIATIONS = 2.0
"""Half-width :math:`k` of a Gaussian weight in the validity measure, in standard deviations (eq.
1.109, 1.114)."""

VALIDITY_LIMIT = 0.1
"""Validity measure above which a system that uses the approximation warns at construction."""

Number = TypeVar("Number", IntervalNumber, GaussianNumber, FuzzyNumber)
AnyNumber: TypeAlias = IntervalNumber | GaussianNumber | FuzzyNumber
Operand: TypeAlias = IntervalNumber | GaussianNumber | FuzzyNumber | Sequence[Type1Set] | ArrayLike


class ApproximateReduction(NamedTuple, Generic[Number]):
    """Approximate type-reduced set, with a measure of its validity.

    Attributes
    ----------
    value : IntervalNumber, GaussianNumber or FuzzyNumber
        The type-reduced set, of shape (...,).
    validity : (...,) array
        Uncertainty of the weights relative to the weights (eq. 1.88, 1.104, 1.109, 1.114). It is 0
        where the result is exact, and the neglected terms are small where it is much smaller than
        1.
    """

    value: Number
    validity: Array


@overload
def approximate_generalized_centroid(
    Z: IntervalNumber | ArrayLike, W: IntervalNumber, t_norm: NumberTNorm | None = None
) -> ApproximateReduction[IntervalNumber]: ...
@overload
def approximate_generalized_centroid(
    Z: GaussianNumber | ArrayLike, W: GaussianNumber, t_norm: NumberTNorm | None = None
) -> ApproximateReduction[GaussianNumber]: ...
@overload
def approximate_generalized_centroid(
    Z: Operand, W: FuzzyNumber, t_norm: NumberTNorm | None = None
) -> ApproximateReduction[FuzzyNumber]: ...
@overload
def approximate_generalized_centroid(
    Z: Operand, W: Operand, t_norm: NumberTNorm | None = None
) -> (
    ApproximateReduction[IntervalNumber]
    | ApproximateReduction[GaussianNumber]
    | ApproximateReduction[FuzzyNumber]
): ...
def approximate_generalized_centroid(
    Z: Operand, W: Operand, t_norm: NumberTNorm | None = None
) -> (
    ApproximateReduction[IntervalNumber]
    | ApproximateReduction[GaussianNumber]
    | ApproximateReduction[FuzzyNumber]
):
    r"""Return the generalized centroid of fuzzy points with fuzzy weights (eq. 1.85).

    The result is correct to first order in the widths of the weights.

    Intervals :math:`[c_l \pm s_l]` with weights :math:`[h_l \pm \Delta_l]` have the center
    :math:`\xi` and the spread (eq. 1.103)

    .. math:: \kappa = \frac{\sum_l (h_l s_l + |c_l - \xi| \Delta_l)}{\sum_l h_l};

    Gaussians of means :math:`m_l, h_l` and standard deviations :math:`\sigma_l, \Delta_l` have the
    mean :math:`\varsigma = \sum_l h_l m_l / \sum_l h_l` (eq. 1.107) and the standard deviation
    (eq. 1.108)

    .. math::

        \Sigma = \frac{1}{\sum_l h_l} \begin{cases}
        \sqrt{\sum_l \left[(h_l \sigma_l)^2 + (m_l - \varsigma)^2 \Delta_l^2\right]}
        & \text{product t-norm} \\
        \sum_l \left[h_l \sigma_l + |m_l - \varsigma| \Delta_l\right] & \text{minimum t-norm}
        \end{cases}

    (the thesis prints the first line without the plus, and the second one with a factor :math:`k`
    that its proof does not have); other fuzzy numbers follow eq. 1.85 by arithmetic on their
    α-cuts, with :math:`c_l` and :math:`h_l` the middles of the supports.

    Parameters
    ----------
    Z : (..., N) fuzzy numbers, (..., N) array_like or N convex type-1 sets
        Points: crisp for the centroid and the height reducer, centroids of the consequents for
        center of sets.
    W : (..., N) fuzzy numbers, (..., N) array_like or N convex type-1 sets
        Weights: memberships or firing strengths, of the same kind as ``Z`` unless one of them is
        crisp. Numbers of different kinds are combined with their α-cuts.
    t_norm : {"product", "min"}, optional
        How Gaussian memberships are combined; by default, with the t-norm of the numbers. Intervals
        do not depend on it, and other fuzzy numbers only support the minimum.

    Returns
    -------
    ApproximateReduction
        ``.value``, a number of the kind of the operands (intervals, where all are crisp), and
        ``.validity``, both of shape (...,). The validity is :math:`\sum \Delta_l / \sum h_l` with
        half-widths :math:`\Delta_l`; those of Gaussians count as :math:`k = 2` standard deviations.
        Both are NaN where all weights are zero.

    Raises
    ------
    InvalidValue
        If the numbers of points and weights differ, a number is not finite or a weight has a
        negative center, or if all weights are zero and the numbers are held as α-cuts.
    NotApplicable
        If the t-norms of Gaussian numbers differ and none is given, or if the product is requested
        for numbers that are held as α-cuts.
    UnknownName
        If there is no such t-norm.

    Notes
    -----
    Karnik and Mendel, "Centroid of a type-2 fuzzy set", Information Sciences 132 (2001).
    """
    if t_norm is not None:
        known_name("t-norm of an approximate reduction", t_norm, ("product", "min"))
    points, weights = _number(Z, "Z"), _number(W, "W")
    if isinstance(points, _SPREAD_KINDS) and isinstance(weights, _SPREAD_KINDS):
        return _of_intervals(_interval(points), _interval(weights))
    if isinstance(points, _GAUSSIAN_KINDS) and isinstance(weights, _GAUSSIAN_KINDS):
        norm = t_norm or _common_norm(points, weights)
        return _of_gaussians(_gaussian(points), _gaussian(weights), norm)
    return _of_cuts(points, weights, t_norm)


def approximate_centroid(
    x: ArrayLike, memberships: IntervalNumber | GaussianNumber | FuzzyNumber | Sequence[Type1Set]
) -> (
    ApproximateReduction[IntervalNumber]
    | ApproximateReduction[GaussianNumber]
    | ApproximateReduction[FuzzyNumber]
):
    r"""Return the centroid of a type-2 set on sampled points.

    The result is correct to first order in the widths of the memberships, under the minimum.

    Intervals follow eq. 1.106, :math:`\kappa = \sum_l |x_l - \xi| \Delta_l / \sum_l h_l`, and
    Gaussians eq. 1.112-1.113,

    .. math:: \varsigma = \frac{\sum_l x_l\, m(x_l)}{\sum_l m(x_l)}, \qquad
        \Sigma = \frac{\sum_l |x_l - \varsigma|\, \sigma(x_l)}{\sum_l m(x_l)}

    (the thesis prints :math:`\Delta_l` for :math:`\sigma(x_l)`). Secondary grades are always
    combined by the minimum, even if the numbers have another t-norm: under the product the centroid
    would depend on the number of points and shrink to a crisp number as that number grows.

    Parameters
    ----------
    x : (..., N) array_like
        Points of the domain.
    memberships : (..., N) fuzzy numbers
        Secondary membership functions at the points.

    Returns
    -------
    ApproximateReduction
        See :func:`approximate_generalized_centroid`.

    Raises
    ------
    InvalidValue
        See :func:`approximate_generalized_centroid`.
    """
    return approximate_generalized_centroid(reals("x", x), memberships, "min")


class _Crisp(NamedTuple):
    """Crisp numbers among the operands, which take the kind of the other operand."""

    location: Array


_SPREAD_KINDS = (IntervalNumber, _Crisp)
_GAUSSIAN_KINDS = (GaussianNumber, _Crisp)


def _number(value: Operand, name: str) -> AnyNumber | _Crisp:
    """Return an operand as an array of fuzzy numbers with at least one along the last axis."""
    number: AnyNumber | _Crisp
    if isinstance(value, IntervalNumber | GaussianNumber | FuzzyNumber):
        number, shape = value, value.shape
    elif (
        isinstance(value, Sequence) and value and all(isinstance(item, Type1Set) for item in value)
    ):
        cuts = [FuzzyNumber.of(item) for item in value]
        number = FuzzyNumber(
            np.stack([cut.left for cut in cuts]), np.stack([cut.right for cut in cuts])
        )
        shape = number.shape
    else:
        # it refuses anything that is not an array
        number = _Crisp(reals(name, value))  # type: ignore[arg-type]
        shape = number.location.shape
    if not shape or shape[-1] == 0:
        raise InvalidValue(name, shape, "an array of at least one number along its last axis")
    return number


def _interval(number: IntervalNumber | _Crisp) -> tuple[Array, Array]:
    return (
        (number.center, number.spread)
        if isinstance(number, IntervalNumber)
        else (number.location, np.zeros(1))
    )


def _gaussian(number: GaussianNumber | _Crisp) -> tuple[Array, Array]:
    return (
        (number.mean, number.sigma)
        if isinstance(number, GaussianNumber)
        else (number.location, np.zeros(1))
    )


def _common_norm(points: GaussianNumber | _Crisp, weights: GaussianNumber | _Crisp) -> NumberTNorm:
    norms = [number.t_norm for number in (points, weights) if isinstance(number, GaussianNumber)]
    if len(set(norms)) > 1:
        raise NotApplicable(
            "the Gaussian corollary",
            f'points have the t-norm "{norms[0]}" and weights "{norms[1]}"; say which one counts',
        )
    return norms[0]


def _average(c: Array, h: Array) -> tuple[Array, Array, Array]:
    """Return the sum of the weights (..., 1), their shares (..., N) and the average (..., 1).

    The sum is NaN instead of 0. The average is the weighted average of the points.
    """
    if c.shape[-1] != h.shape[-1]:
        raise InvalidValue(
            "Z and W", (c.shape, h.shape), "as many points as weights, along the last axes"
        )
    if not np.isfinite(c).all():
        raise InvalidValue("Z", c, "finite")
    if not np.isfinite(h).all() or (h < 0.0).any():
        raise InvalidValue("W", h, "finite, with centers of at least 0")
    total = h.sum(axis=-1, keepdims=True)
    total = np.where(total > 0.0, total, np.nan)
    share = h / total
    # Moments are taken about the first point, so that points far from zero keep their digits.
    origin = c[..., :1]
    return total, share, origin + ((c - origin) * share).sum(axis=-1, keepdims=True)


def _of_intervals(
    points: tuple[Array, Array], weights: tuple[Array, Array]
) -> ApproximateReduction[IntervalNumber]:
    (c, s), (h, delta) = points, weights
    total, share, xi = _average(c, h)
    spread = (share * s + np.abs(c - xi) * (delta / total)).sum(axis=-1)
    return ApproximateReduction(
        IntervalNumber(xi[..., 0], spread), _validity(delta, total, spread.shape)
    )


def _of_gaussians(
    points: tuple[Array, Array], weights: tuple[Array, Array], norm: NumberTNorm
) -> ApproximateReduction[GaussianNumber]:
    (m, sigma), (h, delta) = points, weights
    total, share, mean = _average(m, h)
    from_points, from_weights = share * sigma, np.abs(m - mean) * (delta / total)
    # No squares are taken under the product, because those of tiny widths underflow.
    combined = np.add if norm == "min" else np.hypot
    width = combined.reduce(combined(from_points, from_weights), axis=-1)
    return ApproximateReduction(
        GaussianNumber(mean[..., 0], width, norm),
        _validity(STANDARD_DEVIATIONS * delta, total, width.shape),
    )


def _of_cuts(
    points: AnyNumber | _Crisp, weights: AnyNumber | _Crisp, norm: NumberTNorm | None
) -> ApproximateReduction[FuzzyNumber]:
    if norm == "product":
        raise NotApplicable(
            "the reduction by α-cuts",
            "its arithmetic is that of the minimum; only Gaussian numbers have the product",
        )
    z, w = (_cuts(number, norm) for number in (points, weights))
    c, h = (0.5 * (number.left[..., 0] + number.right[..., 0]) for number in (z, w))
    total, share, xi = _average(c, h)
    if np.isnan(total).any():
        raise InvalidValue(
            "W", h, "positive for at least one point: α-cuts cannot express that there is no output"
        )
    terms = (z - c) * share + (w - h) * ((c - xi) / total)
    value = (
        FuzzyNumber(terms.left.sum(axis=-2), terms.right.sum(axis=-2), terms.levels) + xi[..., 0]
    )
    return ApproximateReduction(
        value, _validity(0.5 * (w.right[..., 0] - w.left[..., 0]), total, xi.shape[:-1])
    )


def _cuts(number: AnyNumber | _Crisp, norm: NumberTNorm | None) -> FuzzyNumber:
    if isinstance(number, GaussianNumber) and norm == "min":
        number = GaussianNumber(number.mean, number.sigma, "min")
    return FuzzyNumber.of(number.location if isinstance(number, _Crisp) else number)


def _validity(half_width: Array, total: Array, shape: tuple[int, ...]) -> Array:
    # Broadcast before the sum, because the half-widths of crisp weights are a single zero.
    return np.asarray(np.broadcast_to((half_width / total).sum(axis=-1), shape)).copy()
