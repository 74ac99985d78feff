"""Membership curves with their slopes and α-cuts, for arrays."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from fuzzy2.sets.type1 import keep_nan
from fuzzy2.support.checks import Array
from fuzzy2.support.quadrature import merged

# Distances, in standard deviations, at which a Gaussian is cut into pieces. exp(-39²/2) is the last
# value that is not zero in double precision.
GAUSSIAN_SPREAD = np.array([0.5, 1.0, 2.0, 3.0, 4.0, 6.0, 8.0])
GAUSSIAN_TAIL = np.array([12.0, 18.0, 26.0, 39.0])


def mirrored(distances: Array) -> Array:
    """Return the distances with both signs, and 0."""
    return np.concatenate([-distances[::-1], [0.0], distances])


def gaussian(x: Array, mean: ArrayLike, sigma: ArrayLike, height: ArrayLike = 1.0) -> Array:
    r"""Return :math:`h\,e^{-(x - m)^2 / (2 \sigma^2)}`; all arguments broadcast."""
    # far out the square overflows to infinity and the grade is 0
    with np.errstate(over="ignore", under="ignore"):
        return np.asarray(height * np.exp(-0.5 * np.square((x - np.asarray(mean)) / sigma)))


def gaussian_slopes(x: Array, mean: ArrayLike, sigma: float, height: float = 1.0) -> Array:
    r"""Return the derivative of a Gaussian, :math:`-\mu(x)\,(x - m)/\sigma^2`.

    Points and means are broadcast.
    """
    grades = gaussian(x, mean, sigma, height)
    return np.where(grades > 0.0, (np.asarray(mean) - x) / sigma * grades / sigma, 0.0)


def gaussian_reach(alpha: Array, sigma: ArrayLike, height: ArrayLike = 1.0) -> Array:
    r"""Return the distance from the mean at which a Gaussian falls to alpha.

    It is :math:`\sigma\sqrt{2 \ln(h/\alpha)}`.
    """
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        logarithm = np.log(np.divide(height, alpha))
        # The quotient overflows long before its logarithm would.
        logarithm = np.where(np.isinf(logarithm), np.log(height) - np.log(alpha), logarithm)
        reach = np.sqrt(2.0 * np.maximum(logarithm, 0.0))
    return np.asarray(np.multiply(sigma, reach))


def trapezoid(x: Array, a: float, b: float, c: float, d: float, height: float) -> Array:
    """Return the membership of a trapezoid whose corners are in ascending order.

    Vertical edges belong to the set.
    """
    with np.errstate(over="ignore"):  # nearly vertical edges
        rise = (x - a) / (b - a) if b > a else np.where(x >= a, 1.0, 0.0)
        fall = (d - x) / (d - c) if d > c else np.where(x <= d, 1.0, 0.0)
    return keep_nan(x, height * np.clip(np.minimum(rise, fall), 0.0, 1.0))


def trapezoid_slopes(x: Array, a: float, b: float, c: float, d: float, height: float) -> Array:
    """Return the right-hand derivative of the membership of a trapezoid.

    At a corner it is the slope of the edge to the right.
    """
    rising, falling = (x >= a) & (x < b), (x >= c) & (x < d)
    rise = height / (b - a) if b > a else 0.0
    fall = height / (d - c) if d > c else 0.0
    return np.where(rising, rise, np.where(falling, -fall, 0.0))


def trapezoid_cut(fraction: Array, a: float, b: float, c: float, d: float) -> tuple[Array, Array]:
    """Return the ends of the cuts of a trapezoid at fractions (...,) of its height."""
    left = a + fraction * (b - a) if b > a else np.full_like(fraction, a)
    right = d - fraction * (d - c) if d > c else np.full_like(fraction, d)
    return left, right


def refined(landmarks: Array, count: int = 64) -> Array:
    """Return landmarks (P,) and ``count`` points between each two neighbors.

    The floats on both sides of each landmark are included, because the landmark may be a jump.
    """
    steps = np.arange(1, count + 1) / (count + 1)
    between = landmarks[:-1, None] + np.diff(landmarks)[:, None] * steps
    return merged(
        between, landmarks, np.nextafter(landmarks, -np.inf), np.nextafter(landmarks, np.inf)
    )


def logistic(steps: Array) -> Array:
    """Return 1 / (1 + exp(-steps)) without overflow and without loss of digits in either tail."""
    tail = np.exp(-abs(steps))
    return np.asarray(np.where(steps < 0.0, tail, 1.0) / (1.0 + tail))
