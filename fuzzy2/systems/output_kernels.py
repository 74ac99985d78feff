"""Compiled loops from firing to averages; :mod:`fuzzy2.systems.outputs` is their face.

For systems that average points, by any method, and are more than a table of consequents: linear
functions of the inputs, highest points of sets, direct methods and weighted sums.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fuzzy2.reduction.kernels import EIASC, end_in_logarithms, end_of_interval
from fuzzy2.support.checks import Array
from fuzzy2.support.compiled import compiled, scalar
from fuzzy2.systems.firing_kernels import _both, _fire
from fuzzy2.systems.kernels import rooms, work_size
from fuzzy2.systems.log_firing_kernels import log_fire, lost

EXACT, NIE_TAN, WU_MENDEL, BEGIAN_MELEK_MENDEL, WEIGHTED_SUM = range(5)
"""Codes of the ways from weighted points to an interval."""


class Points(NamedTuple):
    """What a system averages.

    Parameters
    ----------
    table : (k,) ndarray
        For the firing, see :mod:`fuzzy2.systems.kernels`.
    ends : (m, R, 2) ndarray
        Ends of the points; of linear functions constants.
    slopes : (m, R, 2 p) ndarray
        Of linear functions what each input adds to the middle, then to the spread, and ``ends``
        are middle and spread; else of size 0.
    grades : (m, R, 2) ndarray
        Grades of sets at the points, which the implication combines with the firing; or of size 0.
    shares : (m, R) ndarray
        What weights are multiplied by; or of size 0.
    silent : (m, R) ndarray
        1 where a rule does not speak of an output, else 0.
    defaults : (m,) ndarray
        Outputs where no rule fires; NaN for none.
    codes : (3,) ndarray of int
        The way, the code of the implication, and whether nothing but ratios of weights matters.
    of_averages : (2,) ndarray
        Weights of the lower and the upper average in that of Begian, Melek and Mendel.
    """

    table: Array
    ends: Array
    slopes: Array
    grades: Array
    shares: Array
    silent: Array
    defaults: Array
    codes: NDArray[np.int64]
    of_averages: Array


@scalar
def _mean(points, weights, in_logarithms):
    """Return the average of points, NaN where all weights are 0."""
    greatest = weights[0]
    for i in range(weights.size):
        greatest = max(greatest, weights[i])
    if not (greatest > -math.inf if in_logarithms else greatest > 0.0):
        return math.nan
    moment, mass = 0.0, 0.0
    for i in range(weights.size):
        weight = math.exp(weights[i] - greatest) if in_logarithms else weights[i] / greatest
        moment += weight * (points[i] - points[0])
        mass += weight
    return points[0] + moment / mass


@scalar
def _log_or_sum(weights, in_logarithms):
    """Return the sum of weights, or the logarithm of their sum."""
    greatest, total = -math.inf, 0.0
    for i in range(weights.size):
        greatest = max(greatest, weights[i])
    if in_logarithms and greatest == -math.inf:
        return greatest
    for i in range(weights.size):
        total += math.exp(weights[i] - greatest) if in_logarithms else weights[i]
    return greatest + math.log(total) if in_logarithms else total


@scalar
def _bound(points, low, high, sign, in_logarithms):
    """Return the middle of Wu and Mendel's bounds of the left end, of points by a sign."""
    first, last = math.inf, -math.inf
    none = -math.inf if in_logarithms else 0.0
    for i in range(points.size):
        if high[i] > none:
            first, last = min(first, sign * points[i]), max(last, sign * points[i])
    by_low = sign * _mean(points, low, in_logarithms)
    by_high = sign * _mean(points, high, in_logarithms)
    if math.isnan(by_low):
        return sign * (0.5 * by_high + 0.5 * first)
    one, other = _log_or_sum(low, in_logarithms), _log_or_sum(high, in_logarithms)
    share = math.exp(one - other) if in_logarithms else one / other
    rise, fall = max(by_low - first, 0.0), max(last - by_high, 0.0)
    inner, gap = min(by_low, by_high), 0.0
    if rise > 0.0 and fall > 0.0:
        gap = (1.0 - share) * rise / (share * rise + fall) * fall
    return sign * (0.5 * inner + 0.5 * (inner - gap))


@scalar
def _sort(points, low, high):
    """Bring points with their weights in ascending order, equal ones as they were."""
    for i in range(1, points.size):
        point, lower, upper = points[i], low[i], high[i]
        k = i
        while k > 0 and points[k - 1] > point:
            points[k], low[k], high[k] = points[k - 1], low[k - 1], high[k - 1]
            k -= 1
        points[k], low[k], high[k] = point, lower, upper


@scalar
def _exact(points, low, high, left, in_logarithms, below, above):
    """Return an end of the exact interval of points that can all carry weight."""
    certain = True
    for i in range(points.size):
        certain = certain and low[i] == high[i]
    if certain:
        return _mean(points, high, in_logarithms)
    _sort(points, low, high)
    if in_logarithms:
        if left:
            return end_in_logarithms(points, high, low, below, above)
        return end_in_logarithms(points, low, high, below, above)
    largest = 0.0
    for i in range(points.size):
        largest = max(largest, high[i])
    for i in range(points.size):
        low[i], high[i] = low[i] / largest, high[i] / largest
    if left:
        return end_of_interval(points, high, low, True, EIASC, below, above)
    return end_of_interval(points, low, high, False, EIASC, below, above)


@scalar
def _said(system, x, xo, j, r, end):
    """Return an end of what a rule says of an output."""
    inputs, rules = int(system.table[0]), int(system.table[2])
    o = 2 * (j * rules + r)
    if system.slopes.size == 0:
        return system.ends[o + end]
    middle, spread = system.ends[o], system.ends[o + 1]
    for i in range(inputs):
        middle += system.slopes[inputs * o + i] * x[xo + i]
        spread += system.slopes[inputs * o + inputs + i] * abs(x[xo + i])
    return middle - spread if end == 0 else middle + spread


@scalar
def _weight(system, q, strength, end, in_logarithms):
    """Return the weight of a rule for an output, q counts both, of its firing strength."""
    weight = strength
    if system.grades.size > 0:
        grade = system.grades[2 * q + end]
        # Logarithms are those of products.
        weight = (
            weight + math.log(grade) if in_logarithms else _both(system.codes[1], weight, grade)
        )
    if system.shares.size > 0:
        share = system.shares[q]
        weight = weight + math.log(share) if in_logarithms else weight * share
    return weight


@scalar
def _gather(system, x, xo, j, end, fired, in_logarithms, points, low, high):
    """Write the points that can carry weight, and their weights; return how many they are."""
    rules = int(system.table[2])
    none = -math.inf if in_logarithms else 0.0
    count = 0
    for r in range(rules):
        q = j * rules + r
        if system.silent[q] > 0.0:
            continue
        upper = _weight(system, q, fired[rules + r], 1, in_logarithms)
        if upper > none:
            points[count] = _said(system, x, xo, j, r, end)
            lower = _weight(system, q, fired[r], 0, in_logarithms)
            low[count], high[count] = min(lower, upper), upper
            count += 1
    return count


@scalar
def _reduced(system, end, points, low, high, in_logarithms, below, above):
    """Return an end of the interval of points that can carry weight, at least one."""
    way = system.codes[0]
    if way == EXACT:
        return _exact(points, low, high, end == 0, in_logarithms, below, above)
    if way == WU_MENDEL:
        return _bound(points, low, high, 1.0 if end == 0 else -1.0, in_logarithms)
    if way == NIE_TAN:
        for i in range(points.size):
            least, most = low[i], high[i]
            if in_logarithms:
                low[i] = most + math.log1p(math.exp(least - most))
            else:
                low[i] = least + most
        return _mean(points, low, in_logarithms)
    by_low, by_high = _mean(points, low, in_logarithms), _mean(points, high, in_logarithms)
    if math.isnan(by_low):
        by_low = by_high
    return system.of_averages[0] * by_low + system.of_averages[1] * by_high


@scalar
def _sum(points, low, high, end):
    """Return an end of the sum of points, weighted with intervals; all of one end of points."""
    total = 0.0
    for i in range(points.size):
        one, other = low[i] * points[i], high[i] * points[i]
        total += min(one, other) if end == 0 else max(one, other)
    return total


@scalar
def average_in(system: Points, x: Array, xo: int, work: Array, out: Array, oo: int) -> None:
    """Write the type-reduced intervals (m, 2) of the finite row at ``xo``, from ``oo`` on.

    ``work`` (``work_size``,) is room for it.
    """
    rules, outputs = int(system.table[2]), int(system.table[3])
    grades, fired_low, fired_high, _, _, room, stack = rooms(system.table, work)
    _fire(system.table, x, xo, 0.0, grades, fired_low, fired_high, stack)
    fired = work[grades.size : grades.size + 2 * rules]
    in_logarithms = system.codes[2] == 1 and lost(system.table, fired_low, fired_high)
    if in_logarithms:
        log_fire(system.table, x, xo, 0.0, grades, fired_low, fired_high, stack)
    points, low, high = room[:rules], room[rules : 2 * rules], room[2 * rules : 3 * rules]
    below, above = room[3 * rules : 4 * rules], room[4 * rules : 5 * rules]
    for j in range(outputs):
        place = oo + 2 * j
        out[place] = out[place + 1] = system.defaults[j]
        for end in range(2):
            count = _gather(system, x, xo, j, end, fired, in_logarithms, points, low, high)
            if count == 0:
                continue
            if system.codes[0] == WEIGHTED_SUM:
                out[place + end] = _sum(points[:count], low[:count], high[:count], end)
            else:
                out[place + end] = _reduced(
                    system,
                    end,
                    points[:count],
                    low[:count],
                    high[:count],
                    in_logarithms,
                    below,
                    above,
                )
        if (
            system.codes[0] != EXACT
            and system.codes[0] != WU_MENDEL
            and system.codes[0] != WEIGHTED_SUM
        ):
            # Direct methods average the middles.
            out[place] = out[place + 1] = 0.5 * out[place] + 0.5 * out[place + 1]
        elif out[place] > out[place + 1]:
            out[place], out[place + 1] = out[place + 1], out[place]


@compiled
def averages(system: Points, x: Array, out: Array) -> int:
    """Write the type-reduced intervals (rows, m, 2) of flat inputs.

    Return -1 or the first row not finite.
    """
    inputs, outputs = int(system.table[0]), int(system.table[3])
    work = np.empty(work_size(system.table))
    for i in range(x.size):
        if not math.isfinite(x[i]):
            return i // inputs
    for row in range(x.size // inputs):
        average_in(system, x, row * inputs, work, out, 2 * outputs * row)
    return -1
