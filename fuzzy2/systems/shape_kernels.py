"""Compiled grades of sampled sets, and of shapes that are neither Gaussian nor trapezoidal.

The second number of a term's table row is its kind. The kinds continue those of ``firing_kernels``:
0 is a Gaussian with an uncertain mean or standard deviation, 1 a trapezoid, and 2 a Gaussian with
Gaussian secondary grades.
"""

from __future__ import annotations

import math

from fuzzy2.support.compiled import scalar

SAMPLES, PAIR, BELL, SIGMOID, PI_SHAPED, TWO_SIDED, DIFFERENCE, PRODUCT = range(3, 11)

# A Gaussian and a trapezoid whose grades are shifted by the row's last number and limited to [0,
# 1]. They are the bounds of an α-plane of a set with Gaussian secondary grades.
MOVED = 11


@scalar
def _trapezoid(x, a, b, c, d):
    """Return the grade of x in a trapezoid of height 1."""
    if x < a or x > d:
        return 0.0
    if x < b:
        return (x - a) / (b - a)
    return (d - x) / (d - c) if x > c else 1.0


@scalar
def _between(table, start, count, x):
    """Return the grade of x in samples: ``count`` points from ``start`` on, then their grades."""
    if x < table[start] or x > table[start + count - 1]:
        return 0.0
    low, high = 0, count - 1
    # Binary search for the greatest point that is not above x.
    while high - low > 1:
        middle = (low + high) // 2
        if table[start + middle] <= x:
            low = middle
        else:
            high = middle
    if x == table[start + high]:
        return table[start + count + high]
    o = start + low
    left, grade = table[o], table[o + count]
    return (table[o + count + 1] - grade) / (table[o + 1] - left) * (x - left) + grade


@scalar
def _logistic(steps):
    """Return 1 / (1 + exp(-steps)) without losing digits in either tail."""
    tail = math.exp(-abs(steps))
    return (tail if steps < 0.0 else 1.0) / (1.0 + tail)


@scalar
def _side(distance, sigma):
    """Return the distance of x beyond one side, in standard deviations; 0 for a shoulder."""
    return 0.0 if sigma == math.inf else max(distance / sigma, 0.0)


@scalar
def _pi_shaped(x, row, o):
    """Return the grade of x in a pi-shaped set."""
    share = _trapezoid(x, row[o + 2], row[o + 3], row[o + 4], row[o + 5])
    if share < 0.5:
        return row[o + 6] * (2.0 * share * share)
    return row[o + 6] * (1.0 - 2.0 * (1.0 - share) * (1.0 - share))


@scalar
def _two_sigmoids(kind, x, row, o):
    """Return the grade of x in the absolute difference, or the product, of two sigmoids."""
    first = min(max(row[o + 3] * (x - row[o + 2]), -800.0), 800.0)
    second = min(max(row[o + 5] * (x - row[o + 4]), -800.0), 800.0)
    if kind == PRODUCT:
        return _logistic(first) * _logistic(second)
    # The difference is written as a product, which keeps its digits where both sigmoids are near 1.
    apart = -math.expm1(-abs(first - second))
    return apart * _logistic(max(first, second)) * _logistic(-min(first, second))


@scalar
def _gaussian_or_trapezoid(kind, row, o, x):
    """Return the grade of x in a Gaussian, kind 0, or a trapezoid."""
    if kind == 0:
        t = (x - row[o + 2]) / row[o + 5]
        return row[o + 7] * math.exp(-0.5 * t * t)
    return row[o + 6] * _trapezoid(x, row[o + 2], row[o + 3], row[o + 4], row[o + 5])


@scalar
def grade_of_shape(row, o, x):
    """Return the grade of x in the type-1 set whose table row starts at o."""
    kind = int(row[o + 1])
    if kind <= 1:
        return _gaussian_or_trapezoid(kind, row, o, x)
    if kind >= MOVED:
        return min(max(_gaussian_or_trapezoid(kind - MOVED, row, o, x) + row[o + 9], 0.0), 1.0)
    a, b = row[o + 2], row[o + 3]
    if kind == SAMPLES:
        return _between(row, int(a), int(b), x)
    if kind == BELL:
        return 1.0 / (1.0 + abs((x - a) / b) ** row[o + 4])
    if kind == SIGMOID:
        return _logistic(b * (x - a))
    if kind == PI_SHAPED:
        return _pi_shaped(x, row, o)
    if kind == TWO_SIDED:
        left, right = _side(a - x, row[o + 4]), _side(x - b, row[o + 5])
        return math.exp(-0.5 * (left * left + right * right))
    return _two_sigmoids(kind, x, row, o)
