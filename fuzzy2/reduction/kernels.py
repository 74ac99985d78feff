"""Compiled loops of type reduction, which :mod:`fuzzy2.reduction.interval` calls.

Type reduction works on one row of points, in ascending order, and on weights in the same order. The
left end takes upper weights up to the switch point and lower weights after it. The right end is
computed on the same points with the roles exchanged.

Whether point k lies below the average is decided without computing the average: it does if its
moment F relative to the points below it is smaller than its moment H relative to the points above
it,

    F(k) = sum of before[i] (z[k] - z[i]) over i < k,
    H(k) = sum of after[i] (z[i] - z[k]) over i > k.

Weight k itself does not enter. So a weight that exceeds all others by more digits than a float has
does not spoil the decision, as it would if z[k] were compared with an average that it dominates. F
never decreases with k and H never increases, so there is exactly one switch point.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from fuzzy2.support.checks import Array
from fuzzy2.support.compiled import compiled, scalar

KM, EKM, IASC, EIASC, SCAN = range(5)


@scalar
def _moments(z, before, after, below, above):
    """Write F and H of every point.

    All terms are positive and the sums only grow, so there is no cancellation.
    """
    n = z.size
    mass, moment = 0.0, 0.0
    for k in range(n):
        if k > 0:
            mass += before[k - 1]
            moment += mass * (z[k] - z[k - 1])
        below[k] = moment
    mass, moment = 0.0, 0.0
    for k in range(n - 1, -1, -1):
        if k < n - 1:
            mass += after[k + 1]
            moment += mass * (z[k + 1] - z[k])
        above[k] = moment


@scalar
def _average(z, before, after, k):
    """Return the average of the points, measured from the first point.

    ``before`` holds the weights of the first k points and ``after`` those of the others.
    """
    numerator, denominator = 0.0, 0.0
    for i in range(k):
        numerator += before[i] * (z[i] - z[0])
        denominator += before[i]
    for i in range(k, z.size):
        numerator += after[i] * (z[i] - z[0])
        denominator += after[i]
    return numerator / denominator


@scalar
def _switch_of(z, average):
    """Return how many points do not lie above the average, at least 1 and at most n - 1."""
    k = 1
    while k < z.size - 1 and z[k] - z[0] <= average:
        k += 1
    return k


@scalar
def end_of_interval(  # noqa: C901 (five methods in one compiled loop, for speed)
    z, before, after, left, method, below, above
):
    """Return one end of the interval: the extreme average over all switch points k.

    All points must have a positive upper weight.

    ``before`` are the weights of the first k points and ``after`` those of the others: upper and
    lower for the left end, lower and upper for the right end. The best k lies between 1 and n − 1,
    and there the point at the extreme end has its upper weight, so no sum of weights is ever zero.
    """
    n = z.size
    if n == 1:
        return z[0]
    if method == SCAN:
        best = _average(z, before, after, 1)
        mass_after, moment_after = 0.0, 0.0
        for k in range(n - 1, 0, -1):
            # The suffix sums go into the scratch arrays.
            mass_after += after[k]
            moment_after += after[k] * (z[k] - z[0])
            below[k], above[k] = mass_after, moment_after
        mass, moment = 0.0, 0.0
        for k in range(1, n):
            mass += before[k - 1]
            moment += before[k - 1] * (z[k - 1] - z[0])
            average = (moment + above[k]) / (mass + below[k])
            if (left and average < best) or (not left and average > best):
                best = average
        return z[0] + best
    _moments(z, before, after, below, above)
    k = 1
    if method == EIASC and not left:
        # The enhanced algorithm starts the right end from its own side, where its switch point is
        # nearer.
        k = n - 1
    elif method == EKM:
        k = min(max(round(n / 2.4 if left else n / 1.7), 1), n - 1)
    elif method == KM:
        numerator, denominator = 0.0, 0.0
        for i in range(n):
            numerator += (before[i] + after[i]) * (z[i] - z[0])
            denominator += before[i] + after[i]
        k = _switch_of(z, numerator / denominator)
    if method in (KM, EKM):
        # Karnik and Mendel's step from the average to a new switch point, as long as the average
        # moves outward.
        average = _average(z, before, after, k)
        while True:
            new = _switch_of(z, average)
            candidate = _average(z, before, after, new)
            if new == k or not (candidate < average if left else candidate > average):
                break
            k, average = new, candidate
    # The step with stop condition moves one point at a time. After Karnik and Mendel's steps it
    # only confirms the switch point, or corrects one that a dominant weight hid.
    while k < n - 1 and below[k] < above[k]:
        k += 1
    while k > 1 and below[k - 1] >= above[k - 1]:
        k -= 1
    return z[0] + _average(z, before, after, k)


@scalar
def _log_sum(a, b):
    """Return the logarithm of the sum of two numbers that are given by their logarithms."""
    least, most = min(a, b), max(a, b)
    return most if least == -math.inf else most + math.log1p(math.exp(least - most))


@scalar
def end_in_logarithms(z, before, after, below, above):
    """Do as ``end_of_interval`` with logarithms of weights, so that no ratio of weights underflows.

    An end takes upper weights on one side and lower weights on the other. If these differ greatly
    in size, the weights that decide may vanish relative to the greatest weight.
    """
    n = z.size
    if n == 1:
        return z[0]
    mass = moment = -math.inf
    for k in range(n):
        if k > 0:
            mass = _log_sum(mass, before[k - 1])
            if z[k] > z[k - 1]:
                moment = _log_sum(moment, mass + math.log(z[k] - z[k - 1]))
        below[k] = moment
    mass = moment = -math.inf
    for k in range(n - 1, -1, -1):
        if k < n - 1:
            mass = _log_sum(mass, after[k + 1])
            if z[k + 1] > z[k]:
                moment = _log_sum(moment, mass + math.log(z[k + 1] - z[k]))
        above[k] = moment
    k = 1
    while k < n - 1 and below[k] < above[k]:
        k += 1
    largest = -math.inf
    for i in range(n):
        largest = max(largest, before[i] if i < k else after[i])
    numerator, denominator = 0.0, 0.0
    for i in range(n):
        weight = math.exp((before[i] if i < k else after[i]) - largest)
        numerator += weight * (z[i] - z[0])
        denominator += weight
    return z[0] + numerator / denominator


# Points are scaled first if one is larger than this, or all are smaller, because their distances
# would overflow or underflow.
LARGEST, SMALLEST = 2.0**400, 2.0**-400


@compiled
def centroid_of_row(x: Array, lower: Array, upper: Array, method: int, out: Array) -> int:
    """Write left and right end of a set on ascending points (n,), with grades (n,).

    Return 1, or 0 if the general path must handle the set: if points are not in order or need
    scaling, if grades are invalid, or if array sizes differ.

    It is a fast path, which checks the arrays in a single pass.
    """
    n = x.size
    if n == 0 or lower.size != n or upper.size != n:
        return 0
    heaviest, farthest, before = 0.0, 0.0, -math.inf
    fine = True
    for i in range(n):
        least, most, at = lower[i], upper[i], x[i]
        # NaN fails every comparison.
        fine = fine and least >= 0.0 and least <= most and most < math.inf and before <= at
        heaviest, farthest, before = max(heaviest, most), max(farthest, abs(at)), at
    if not fine or not farthest < LARGEST or 0.0 < farthest < SMALLEST:
        return 0
    points, low, high = np.empty(n), np.empty(n), np.empty(n)
    below, above = np.empty(n), np.empty(n)
    count = 0
    for i in range(n):
        if upper[i] > 0.0:
            points[count] = x[i]
            low[count], high[count] = lower[i] / heaviest, upper[i] / heaviest
            count += 1
    if count == 0:
        out[0] = out[1] = math.nan
        return 1
    points, low, high = points[:count], low[:count], high[:count]
    left = end_of_interval(points, high, low, True, method, below, above)
    right = end_of_interval(points, low, high, False, method, below, above)
    out[0], out[1] = min(left, right), max(left, right)
    return 1


@compiled
def reduce_rows(z: Array, order: NDArray[np.int64], w: Array, method: int, out: Array) -> None:
    """Write left and right end of every row.

    ``z`` (rows or 1, n, 2) holds both ends of the points, with each column sorted. ``order`` holds
    the indices that sort them, ``w`` (rows, n, 2) the lower and upper weights in the original
    order, and ``out`` (rows, 2) the result.
    """
    n = w.shape[1]
    points, low, high = np.empty(n), np.empty(n), np.empty(n)
    below, above = np.empty(n), np.empty(n)
    for row in range(w.shape[0]):
        source = row if z.shape[0] > 1 else 0
        # Weights are taken relative to the largest, because products of tiny weights would
        # underflow.
        largest = w[row, :, 1].max()
        for end in range(2):
            # Points without a positive upper weight are left out, because the search could take
            # them for the switch point.
            count = 0
            for i in range(n):
                j = order[source, i, end]
                if w[row, j, 1] > 0.0:
                    points[count] = z[source, i, end]
                    low[count] = w[row, j, 0] / largest
                    high[count] = w[row, j, 1] / largest
                    count += 1
            if count == 0:
                out[row, end] = math.nan
            elif end == 0:
                out[row, end] = end_of_interval(
                    points[:count], high[:count], low[:count], True, method, below, above
                )
            else:
                out[row, end] = end_of_interval(
                    points[:count], low[:count], high[:count], False, method, below, above
                )
        if out[row, 0] > out[row, 1]:
            # The two ends are computed separately and may cross by rounding if the interval is a
            # point.
            out[row, 0], out[row, 1] = out[row, 1], out[row, 0]


@compiled
def reduce_rows_in_logarithms(
    z: Array, order: NDArray[np.int64], logarithms: Array, out: Array
) -> None:
    """Do as ``reduce_rows`` with logarithms of weights, which are -inf for weights of 0."""
    n = logarithms.shape[1]
    points, low, high = np.empty(n), np.empty(n), np.empty(n)
    below, above = np.empty(n), np.empty(n)
    for row in range(logarithms.shape[0]):
        source = row if z.shape[0] > 1 else 0
        for end in range(2):
            count = 0
            for i in range(n):
                j = order[source, i, end]
                if logarithms[row, j, 1] > -math.inf:
                    points[count] = z[source, i, end]
                    low[count], high[count] = logarithms[row, j, 0], logarithms[row, j, 1]
                    count += 1
            before, after = (high, low) if end == 0 else (low, high)
            if count == 0:
                out[row, end] = math.nan
            else:
                out[row, end] = end_in_logarithms(
                    points[:count], before[:count], after[:count], below, above
                )
        if out[row, 0] > out[row, 1]:
            out[row, 0], out[row, 1] = out[row, 1], out[row, 0]
