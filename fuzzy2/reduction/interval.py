r"""Exact type reduction of interval type-2 sets and systems.

It computes the generalized centroid (eq. 1.84, 1.115, 1.116).

.. math::

    y_l = \min_{z_i \in Z_i,\, w_i \in W_i} \frac{\sum_i w_i z_i}{\sum_i w_i}, \qquad
    y_r = \max_{z_i \in Z_i,\, w_i \in W_i} \frac{\sum_i w_i z_i}{\sum_i w_i}

Centroid, height and center of sets are special cases. The left end uses the left ends of all
:math:`Z_i` in ascending order. Up to a switch point k the weights are the upper ends of
:math:`W_i`, and after it the lower ends. For the right end the roles are exchanged. All methods
find the switch point exactly and differ only in their search; they stop when the switch point no
longer changes, never at a tolerance. Points whose upper weight is zero are left out first, equal
points need no special treatment, and each end of the result sorts the corresponding ends of the
:math:`Z_i`. (The thesis's procedure after eq. 1.116 lacks the sorting, the minimum, and ``w = h``
in its first step, and stops on equal floats.)

If no weight can be positive, there is no output and both ends are NaN.
"""

from __future__ import annotations

import functools
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from fuzzy2.errors import InvalidValue
from fuzzy2.support.checks import Array, binary_exponent, broadcast, known_name, real, reals
from fuzzy2.support.pieces import pieces

METHODS = ("km", "ekm", "iasc", "eiasc", "scan")
"""Names of the exact methods, see :func:`generalized_centroid`."""


class WuMendelBounds(NamedTuple):
    """Inner and outer bounds of both ends of a type-reduced set, each of shape (...,).

    The left end lies between ``left_lower`` and ``left_upper``, the right end between
    ``right_lower`` and ``right_upper``.
    """

    left_lower: Array
    left_upper: Array
    right_lower: Array
    right_upper: Array


def _code(method: str) -> int:
    return METHODS.index(known_name("type-reduction method", method, METHODS))


def _weights(w: ArrayLike) -> Array:
    weights = reals("w", w)
    if weights.ndim < 2 or weights.shape[-1] != 2 or weights.shape[-2] == 0:
        raise InvalidValue(
            "w", weights.shape, "an array of intervals, of shape (..., N, 2) with N of at least 1"
        )
    if (
        not np.isfinite(weights).all()
        or (weights < 0.0).any()
        or (weights[..., 0] > weights[..., 1]).any()
    ):
        raise InvalidValue("w", weights, "finite intervals with 0 <= lower <= upper")
    return weights


def _points(z: ArrayLike, count: int) -> Array:
    """Return points (..., N) or intervals (..., N, 2) as intervals."""
    points = reals("z", z)
    # A trailing axis of 2 means intervals, except for a single row of two crisp points.
    is_interval = points.ndim >= 2 and points.shape[-2:] == (count, 2)
    if not is_interval:
        if points.ndim < 1 or points.shape[-1] != count:
            raise InvalidValue(
                "z",
                points.shape,
                f"of shape (..., {count}) or (..., {count}, 2), to go with the weights",
            )
        points = np.stack([points, points], axis=-1)
    if not np.isfinite(points).all() or (points[..., 0] > points[..., 1]).any():
        raise InvalidValue("z", points, "finite numbers, or finite intervals with left <= right")
    return points


def _paired(z: ArrayLike, w: ArrayLike) -> tuple[Array, Array]:
    """Return points and weights as intervals whose leading dimensions broadcast."""
    weights = _weights(w)
    points = _points(z, weights.shape[-2])
    try:
        np.broadcast_shapes(points.shape[:-2], weights.shape[:-2])
    except ValueError as error:
        raise InvalidValue(
            "z and w", (points.shape, weights.shape), "arrays whose leading dimensions go together"
        ) from error
    return points, weights


def _scaled(z: ArrayLike, w: ArrayLike) -> tuple[Array, Array, int]:
    """Return points and weights scaled so that sums stay finite, and the points' exponent.

    Points are divided by two to that exponent. Only the ratios of the weights in each row matter.
    """
    points, weights = _paired(z, w)
    scale = binary_exponent(points)
    if scale:
        points = np.ldexp(points, -scale)
    if binary_exponent(weights):
        exponents = np.frexp(weights[..., 1].max(axis=-1))[1]
        weights = np.ldexp(weights, -exponents[..., np.newaxis, np.newaxis])
    return points, weights, scale


def _unscaled(values: Array, scale: int) -> Array:
    """Return a result for scaled points in the original scale; bounds may overflow."""
    with np.errstate(over="ignore"):
        return np.asarray(np.ldexp(values, scale))[()] if scale else values


@functools.cache
def _one_row() -> Any:
    """Return the compiled centroid of one set, which accepts only contiguous rows of floats."""
    from fuzzy2.reduction.kernels import centroid_of_row
    from fuzzy2.support.compiled import only_for

    return only_for(centroid_of_row, np.zeros(1), np.zeros(1), np.zeros(1), 0, np.zeros(2))


def generalized_centroid(z: ArrayLike, w: ArrayLike, method: str = "eiasc") -> Array:
    """Return the exact type-reduced interval of weighted points (eq. 1.116).

    Parameters
    ----------
    z : (..., N) or (..., N, 2) array_like
        Points, or intervals [left, right] of points. An ambiguous array, which is possible for N =
        2, is read as intervals. Pass domain points for the centroid, points of maximum membership
        for the height reducer, and centroids of the consequents for center of sets.
    w : (..., N, 2) array_like
        Weight intervals [lower, upper], not negative.
    method : {"km", "ekm", "iasc", "eiasc", "scan"}
        Karnik–Mendel, which starts with the middles of the weights; enhanced Karnik–Mendel, which
        starts at N/2.4 and N/1.7; the iterative algorithm with stop condition; its enhanced
        version; or a scan of all switch points. All give the same interval and differ only in
        speed.

    Returns
    -------
    (..., 2) ndarray
        Left and right end; NaN where all upper weights are zero. This is not a confidence interval:
        its coverage probability is not known.

    Raises
    ------
    InvalidValue
        If shapes do not match, a number is not finite, an interval is reversed or a weight is
        negative.
    UnknownName
        If there is no such method.
    """
    code = _code(method)
    points, weights = _paired(z, w)
    # The points are scaled first, because distances near the ends of the range of floats would
    # overflow or underflow.
    scale = binary_exponent(points)
    if scale:
        points = np.ldexp(points, -scale)
    count = weights.shape[-2]
    shape = np.broadcast_shapes(points.shape[:-2], weights.shape[:-2])
    from fuzzy2.reduction import kernels as reduction_kernels

    # Points that all items share are sorted only once.
    shared = points.ndim == 2
    flat_points = (
        points if shared else np.broadcast_to(points, (*shape, count, 2)).reshape(-1, count, 2)
    )
    flat_weights = np.ascontiguousarray(
        np.broadcast_to(weights, (*shape, count, 2)).reshape(-1, count, 2)
    )
    order = np.argsort(flat_points, axis=-2, kind="stable")
    in_order = np.ascontiguousarray(np.take_along_axis(flat_points, order, axis=-2))
    out = np.empty((flat_weights.shape[0], 2))
    in_order = in_order.reshape(-1, count, 2)
    order = np.ascontiguousarray(order.reshape(-1, count, 2))
    for part in pieces(len(out)):
        own = slice(None) if shared else part
        given = in_order[own], order[own], flat_weights[part]
        reduction_kernels.reduce_rows(*given, code, out[part])
    return np.ldexp(out, scale).reshape(*shape, 2) if scale else out.reshape(*shape, 2)


def centroid(x: ArrayLike, lower: ArrayLike, upper: ArrayLike, method: str = "eiasc") -> Array:
    """Return the exact centroid of an interval type-2 set on sampled points (eq. 1.70, 1.105).

    Parameters
    ----------
    x : (..., N) array_like
        Points of the domain, in any order.
    lower, upper : (..., N) array_like
        Lower and upper membership grades there, 0 <= lower <= upper.
    method : str
        See :func:`generalized_centroid`.

    Returns
    -------
    (..., 2) ndarray
        Left and right end of the centroid; NaN where the set is empty. The ``centroid()`` method of
        a set works on the continuous domain instead.

    Raises
    ------
    InvalidValue, UnknownName
        See :func:`generalized_centroid`.
    """
    if type(x) is type(lower) is type(upper) is np.ndarray:
        out = np.empty(2)
        try:
            done = _one_row()(x, lower, upper, _code(method), out)
        except TypeError:
            # The compiled function accepts only contiguous rows of floats. Several sets, whole
            # numbers and the like take the general path.
            done = 0
        if done:
            return out
    low, high = broadcast("lower and upper", reals("lower", lower), reals("upper", upper))
    points = reals("x", x)
    if points.ndim == 0 or low.ndim == 0 or points.shape[-1] != low.shape[-1]:
        raise InvalidValue(
            "x", points.shape, f"of shape (..., N) like the grades, which have {low.shape}"
        )
    return generalized_centroid(
        np.stack([points, points], axis=-1), np.stack([low, high], axis=-1), method
    )


def nie_tan(z: ArrayLike, w: ArrayLike) -> Array:
    r"""Return the Nie–Tan approximation of the defuzzified output.

    It is :math:`\sum z_i (w_i^l + w_i^u) / \sum (w_i^l + w_i^u)`.

    This approximation needs no sorting and differs from the middle of the exact interval. (M. Nie
    and W. W. Tan, "Towards an efficient type-reduction method for interval type-2 fuzzy logic
    systems", FUZZ-IEEE 2008.)

    Parameters
    ----------
    z : (..., N) or (..., N, 2) array_like
        Points, or intervals, which are replaced with their middles.
    w : (..., N, 2) array_like
        Weight intervals.

    Returns
    -------
    (...,) ndarray
        Crisp output; NaN where all upper weights are zero.

    Raises
    ------
    InvalidValue
        See :func:`generalized_centroid`.
    """
    points, weights, scale = _scaled(z, w)
    points = points.mean(axis=-1)
    ratio = _ratio((points * weights.sum(axis=-1)).sum(axis=-1), weights.sum(axis=(-1, -2)))
    return _unscaled(ratio, scale)


def begian_melek_mendel(z: ArrayLike, w: ArrayLike, m: float = 0.5, n: float = 0.5) -> Array:
    r"""Return the Begian–Melek–Mendel approximation of the defuzzified output.

    .. math:: y = m \frac{\sum_i w_i^l z_i}{\sum_i w_i^l} + n \frac{\sum_i w_i^u z_i}{\sum_i w_i^u}

    This approximation has the design parameters m and n. If all lower weights are zero, the first
    quotient is undefined and the second is used for both terms. (M. Begian, W. Melek, J. Mendel,
    "Stability analysis of type-2 fuzzy systems", FUZZ-IEEE 2008.)

    Parameters
    ----------
    z : (..., N) or (..., N, 2) array_like
        Points, or intervals, which are replaced with their middles.
    w : (..., N, 2) array_like
        Weight intervals.
    m, n : float
        Weights of the two terms; with m + n = 1 the output is an average.

    Returns
    -------
    (...,) ndarray
        Crisp output; NaN where all upper weights are zero.

    Raises
    ------
    InvalidValue
        See :func:`generalized_centroid`.
    """
    points, weights, scale = _scaled(z, w)
    points = points.mean(axis=-1)
    low, high = (
        _ratio((points * weights[..., end]).sum(axis=-1), weights[..., end].sum(axis=-1))
        for end in (0, 1)
    )
    lower, upper = real("m", m), real("n", n)
    return _unscaled(lower * np.where(np.isnan(low), high, low) + upper * high, scale)


def _ratio(numerator: Array, denominator: Array) -> Array:
    """Return the quotient, or NaN where the denominator is zero."""
    with np.errstate(invalid="ignore", divide="ignore"):
        ratio: Array = np.where(denominator > 0.0, numerator / denominator, np.nan)
    return ratio


def wu_mendel_bounds(z: ArrayLike, w: ArrayLike) -> WuMendelBounds:
    r"""Return the Wu–Mendel bounds of both ends of the type-reduced interval, without iteration.

    Let :math:`z` be sorted, and let :math:`y^{(0)}` and :math:`y^{(N)}` be the averages with all
    lower and with all upper weights. Then

    .. math::

        \bar y_l = \min(y_l^{(0)}, y_l^{(N)}), \qquad
        \underline y_l = \bar y_l - \frac{\sum_i (w_i^u - w_i^l)}{\sum_i w_i^u \sum_i w_i^l}\,
        \frac{\sum_i w_i^l (z_i - z_1)\, \sum_i w_i^u (z_N - z_i)}{\sum_i w_i^l (z_i - z_1)
        + \sum_i w_i^u (z_N - z_i)},

    and the bounds of the right end are the mirror image. (H. Wu and J. Mendel, "Uncertainty bounds
    and their use in the design of interval type-2 fuzzy logic systems", IEEE Transactions on Fuzzy
    Systems 10, 2002.)

    Parameters
    ----------
    z : (..., N) or (..., N, 2) array_like
        Points or intervals.
    w : (..., N, 2) array_like
        Weight intervals.

    Returns
    -------
    WuMendelBounds
        The bounds ``left_lower <= y_l <= left_upper`` and ``right_lower <= y_r <= right_upper``.
        Where all lower weights are zero, the outer bounds are the extreme points with a positive
        upper weight. All bounds are NaN where all upper weights are zero.

    Raises
    ------
    InvalidValue
        See :func:`generalized_centroid`.
    """
    *both, scale = _scaled(z, w)
    points, weights = np.broadcast_arrays(*both)
    low, high = weights[..., 0], weights[..., 1]
    sum_low, sum_high = low.sum(axis=-1), high.sum(axis=-1)
    fires = high > 0.0
    bounds = []
    # The right end is the left end of the mirrored points.
    for sign, end in ((1.0, 0), (-1.0, 1)):
        y = sign * points[..., end]
        first = np.where(fires, y, np.inf).min(axis=-1)
        last = np.where(fires, y, -np.inf).max(axis=-1)
        by_high = _ratio((high * y).sum(axis=-1), sum_high)
        by_low = _ratio((low * y).sum(axis=-1), sum_low)
        inner = np.fmin(by_low, by_high)
        first, last = (np.where(np.isfinite(edge), edge, 0.0) for edge in (first, last))
        # Weights are taken as shares of the sum of the upper weights, because products of tiny
        # weights would underflow.
        with np.errstate(invalid="ignore", divide="ignore"):
            low_share, high_share = (
                low / sum_high[..., np.newaxis],
                high / sum_high[..., np.newaxis],
            )
            share = low_share.sum(axis=-1)
            rise = (low_share * (y - first[..., np.newaxis]).clip(0.0)).sum(axis=-1)
            fall = (high_share * (last[..., np.newaxis] - y).clip(0.0)).sum(axis=-1)
            gap = (
                (1.0 - share)
                / share
                * np.where((rise > 0.0) & (fall > 0.0), rise / (rise + fall) * fall, 0.0)
            )
        outer = np.where(share > 0.0, inner - gap, first)
        outer = np.where(sum_high > 0.0, outer, np.nan)
        bounds.append((_unscaled(sign * outer, scale), _unscaled(sign * inner, scale)))
    (left_lower, left_upper), (right_upper, right_lower) = bounds
    return WuMendelBounds(left_lower, left_upper, right_lower, right_upper)
