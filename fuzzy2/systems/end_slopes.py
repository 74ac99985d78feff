"""Derivatives of the ends of a type-reduced interval, by the envelope theorem.

See :mod:`fuzzy2.systems.gradients` for the equation.
"""

from __future__ import annotations

import numpy as np

from fuzzy2.reduction.logarithms import relative
from fuzzy2.support.checks import Array

TIE = 1e-13
"""A consequent equals the output if they differ by less than this, relative to the largest
consequent, which is some rounding errors."""


def left_end(points: Array, rises: Array, y: Array, weights: Array, rates: Array) -> Array:
    r"""Return the right-hand derivatives (n, m, p) of left ends y (n, m).

    Left ends are the least averages of points whose weights lie in intervals.

    Points are (n or 1, m, R), and their derivatives ``rises`` (n, m, R, p), or 1 along any axis.
    Weights are (n, R, 2), and their derivatives ``rates`` (n, R, 2, p). A point that equals y may
    have any weight without changing y, but the derivative depends on that weight.
    """
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        # Weights are taken relative to the largest, because products of tiny weights would
        # underflow.
        largest = weights[..., 1].max(axis=1)[:, np.newaxis, np.newaxis]
        weights, rates = weights / largest, rates / largest[..., np.newaxis]
        away = points - y[..., np.newaxis]
        tied = np.abs(away) <= TIE * np.abs(points).max(axis=-1, keepdims=True)
        below, above = (away < 0.0) & ~tied, (away > 0.0) & ~tied
        moment = (
            np.where(below, away, 0.0) @ rates[:, :, 1]
            + np.where(above, away, 0.0) @ rates[:, :, 0]
        )
        weight = np.where(
            below, weights[:, np.newaxis, :, 1], np.where(above, weights[:, np.newaxis, :, 0], 0.0)
        )
        mass = weight.sum(axis=-1)[..., np.newaxis]
        if rises.any():
            moment = moment + np.einsum(
                "nmr,nmrp->nmp", weight, np.broadcast_to(rises, (*away.shape, moment.shape[-1]))
            )
        slopes = moment / mass
        some = tied.any(axis=-1)
        if some.any():
            item, output = np.nonzero(some)
            low, high = np.moveaxis(
                np.where(tied[some][..., np.newaxis], weights[item], 0.0), -1, 0
            )
            theirs = np.broadcast_to(rises, (*away.shape, moment.shape[-1]))[item, output]
            slopes[some] = _least_slope(
                moment[some], mass[some], theirs, low[..., np.newaxis], high[..., np.newaxis]
            )
    return np.asarray(slopes)


def _least_slope(moment: Array, mass: Array, rises: Array, low: Array, high: Array) -> Array:
    """Return the derivatives (k, p) of ends that equal points.

    The points that equal the end may have any weight from ``low`` to ``high`` (k, R, 1).

    By Danskin's theorem the derivative is that of the choice which falls fastest. This is again a
    generalized centroid, of the derivatives of the points (k, R, p), and it is found by the
    Karnik-Mendel iteration.
    """
    least: Array = (moment + (high * rises).sum(axis=1)) / (mass + high.sum(axis=1))
    while True:
        chosen = np.where(rises <= least[:, np.newaxis], high, low)
        candidate = (moment + (chosen * rises).sum(axis=1)) / (mass + chosen.sum(axis=1))
        less = candidate < least
        if not less.any():
            return least
        least = np.where(less, candidate, least)


def scaled_for(points: Array, y: Array, logarithms: Array) -> Array:
    """Return weights (n, R, 2) relative to the greatest one used by a left end y (n, 1)."""
    low, high = logarithms[..., 0], logarithms[..., 1]
    away = points - y
    reach = TIE * np.abs(points).max(axis=-1, keepdims=True)
    tied = np.abs(away) <= reach
    others = np.where(tied, -np.inf, np.where(away > 0.0, low, high))
    weights = relative(others)
    # A point may equal the end because it outweighs the others. Its weight is then decided by the
    # side to which the others pull the average.
    pull = (weights * away).sum(axis=-1, keepdims=True)
    free = np.abs(pull) <= reach * weights.sum(axis=-1, keepdims=True)
    own = np.where(pull < 0.0, low, high)
    decided = (tied & ~free)[..., np.newaxis]
    scaled = np.where(decided, own[..., np.newaxis], logarithms)
    greatest = np.where(tied, scaled[..., 1], others).max(axis=1)[:, np.newaxis, np.newaxis]
    # Weights that the end does not use may be greater; they are ignored.
    return np.asarray(np.exp(np.minimum(scaled - greatest, 0.0)))
