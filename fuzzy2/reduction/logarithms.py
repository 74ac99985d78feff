r"""Type reduction of weights that are given by their logarithms, however small the weights are.

Type reduction depends only on ratios of weights. But an end of the interval takes upper weights on
one side of its switch point and lower weights on the other. So it may depend on weights that
underflow relative to the greatest weight, such as :math:`e^{-900}` and :math:`e^{-1200}` where
others are 1. Therefore logarithms are kept until the final average.
"""

from __future__ import annotations

import numpy as np

from fuzzy2.support.checks import Array, binary_exponent
from fuzzy2.support.pieces import pieces

STEP = 40.0
"""Gap between logarithms beyond which the smaller weight is below the rounding of the greater."""
DEEPEST = 700.0
"""Gap between logarithms beyond which the smaller weight underflows."""


def centroid_in_logarithms(points: Array, logarithms: Array) -> Array:
    """Return the type-reduced intervals (n, 2); see :func:`fuzzy2.generalized_centroid`.

    Parameters
    ----------
    points : (R, 2) or (n, R, 2) array
        Intervals.
    logarithms : (n, R, 2) array
        Logarithms of weight intervals, -inf for weights of 0.
    """
    from fuzzy2.reduction import kernels

    scale = binary_exponent(points)
    scaled = np.ldexp(points, -scale) if scale else points
    order = np.argsort(scaled, axis=-2, kind="stable")
    in_order = np.take_along_axis(scaled, order, axis=-2)
    count = logarithms.shape[-2]
    out = np.empty((len(logarithms), 2))
    in_order = np.ascontiguousarray(in_order.reshape(-1, count, 2))
    order = np.ascontiguousarray(order.reshape(-1, count, 2))
    weights = np.ascontiguousarray(logarithms)
    for part in pieces(len(out)):
        own = slice(None) if points.ndim == 2 else part
        kernels.reduce_rows_in_logarithms(in_order[own], order[own], weights[part], out[part])
    return np.ldexp(out, scale) if scale else out


def average_in_logarithms(points: Array, logarithms: Array) -> Array:
    """Return the averages (n,) of points (R,) or (n, R), with weights given as logarithms (n, R).

    An average is NaN where all weights are 0.
    """
    weights = relative(logarithms)
    with np.errstate(invalid="ignore"):
        return np.asarray(((weights / weights.sum(axis=-1, keepdims=True)) * points).sum(axis=-1))


def relative(logarithms: Array) -> Array:
    """Return the weights (..., R) relative to the greatest; all are 0 where the greatest is 0."""
    greatest = logarithms.max(axis=-1, keepdims=True)
    return np.exp(logarithms - np.where(np.isfinite(greatest), greatest, 0.0))


def bounds_in_logarithms(points: Array, logarithms: Array) -> Array:
    """Return the middles (n, 2) of the Wu-Mendel bounds of both ends.

    The parameters are those of :func:`centroid_in_logarithms`, and the bounds those of
    :func:`fuzzy2.wu_mendel_bounds`. Here the gap between the bounds is written with both averages,
    so that no product of weights is formed.
    """
    low, high = logarithms[..., 0], logarithms[..., 1]
    fires = high > -np.inf
    with np.errstate(invalid="ignore"):
        share = np.exp(_log_sums(low) - _log_sums(high))
    middles = []
    for sign, end in ((1.0, 0), (-1.0, 1)):
        y = np.broadcast_to(sign * points[..., end], low.shape)
        first = np.where(fires, y, np.inf).min(axis=-1)
        last = np.where(fires, y, -np.inf).max(axis=-1)
        by_low, by_high = average_in_logarithms(y, low), average_in_logarithms(y, high)
        inner = np.fmin(by_low, by_high)
        with np.errstate(invalid="ignore", divide="ignore"):
            rise, fall = (by_low - first).clip(0.0), (last - by_high).clip(0.0)
            some = (rise > 0.0) & (fall > 0.0)
            gap = np.where(some, (1.0 - share) * rise / (share * rise + fall) * fall, 0.0)
            outer = np.where(np.isnan(by_low), first, inner - gap)
        middles.append(sign * np.where(fires.any(axis=-1), 0.5 * inner + 0.5 * outer, np.nan))
    return np.stack(middles, axis=-1)


def _log_sums(logarithms: Array) -> Array:
    """Return the logarithms of the sums (n,) of weights with logarithms (n, R)."""
    return np.asarray(np.logaddexp.reduce(logarithms, axis=-1))


def as_floats(logarithms: Array) -> Array:
    """Return weights (n, R, 2) that have the ratios of the given logarithms, as far as floats can.

    Gaps between consecutive logarithms that exceed the precision of floats are narrowed, so that
    the weights of up to nine rules with the widest gaps remain positive floats. Weights that are
    still too small become 0.
    """
    flat = logarithms.reshape(len(logarithms), -1)
    order = np.argsort(-flat, axis=-1)
    falling = np.take_along_axis(flat, order, axis=-1)
    with np.errstate(invalid="ignore"):
        gaps = np.minimum(falling[:, :-1] - falling[:, 1:], STEP)
    depths = np.zeros_like(flat)
    depths[:, 1:] = np.where(falling[:, 1:] > -np.inf, gaps, np.inf).cumsum(axis=-1)
    depths[falling == -np.inf] = np.inf
    depths[depths > DEEPEST] = np.inf
    weights = np.empty_like(flat)
    np.put_along_axis(weights, order, np.exp(-depths), axis=-1)
    return weights.reshape(logarithms.shape)
