"""Compiled loops from firing to averages, which :mod:`fuzzy2.systems.outputs` calls.

They serve systems that average points, by any method, and need more than a table of constant
consequents: linear functions of the inputs, highest points of sets, direct methods and weighted
sums.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fuzzy2.reduction.kernels import EIASC, end_in_logarithms, end_of_interval
from fuzzy2.support.checks import Array
from fuzzy2.support.compiled import compiled, scalar
from fuzzy2.support.formula_kernels import formula_at
from fuzzy2.systems.firing_kernels import _both, _either, _fire
from fuzzy2.systems.kernels import rooms, work_size
from fuzzy2.systems.log_firing_kernels import log_fire, lost

EXACT, NIE_TAN, WU_MENDEL, BEGIAN_MELEK_MENDEL, WEIGHTED_SUM = range(5)
"""Codes of the methods that reduce weighted points to an interval."""
SUMMED = -1
"""Code of the sum among the codes of t-conorms."""


class Points(NamedTuple):
    """Tables of the points that a system averages.

    Parameters
    ----------
    table : (k,) ndarray
        Table of the firing, see :mod:`fuzzy2.systems.kernels`.
    ends : (m, R, 2) ndarray
        Ends of the points; for linear functions, the constants.
    slopes : (m, R, 2 p) ndarray
        For linear functions, the slopes of the middle and then of the spread; ``ends`` then holds
        middle and spread. Otherwise of size 0.
    grades : (m, R, 2) ndarray
        Grades of sets at the points, which the implication combines with the firing; or empty.
    shares : (m, R) ndarray
        Factors of the weights; or empty.
    silent : (m, R) ndarray
        1 where a rule has no consequent for an output, 0 elsewhere.
    defaults : (m,) ndarray
        Outputs where no rule fires; NaN for none.
    codes : (5,) ndarray of int
        Code of the method, code of the implication, whether only ratios of weights matter, code of
        the t-conorm for rules with the same consequent, and depth of the formulas' stack.
    leaders : (m, R) ndarray of int
        Number of the first rule with the same consequent, which takes the united weight of all of
        them; or empty.
    programs : ndarray
        Steps of the formulas of the points, see :mod:`fuzzy2.support.formula_kernels`; or empty.
    places : (m R + 1,) ndarray of int
        Place where the steps of each formula begin.
    of_averages : (2,) ndarray
        Weights of the lower and the upper average in the Begian-Melek-Mendel method.
    """

    table: Array
    ends: Array
    slopes: Array
    grades: Array
    shares: Array
    silent: Array
    defaults: Array
    codes: NDArray[np.int64]
    leaders: NDArray[np.int64]
    programs: Array
    places: NDArray[np.int64]
    of_averages: Array


@scalar
def points_room_size(system: Points) -> int:
    """Return the size of the scratch space for one row."""
    return work_size(system.table) + int(system.codes[4])


@scalar
def _mean(points, weights, in_logarithms):
    """Return the average of points; NaN if all weights are 0."""
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
    """Return the sum of weights, or the logarithm of the sum if the weights are logarithms."""
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
    """Return the middle of the Wu-Mendel bounds of the left end; ``sign`` mirrors the points."""
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
    """Sort points with their weights in ascending order; equal points keep their order."""
    for i in range(1, points.size):
        point, lower, upper = points[i], low[i], high[i]
        k = i
        while k > 0 and points[k - 1] > point:
            points[k], low[k], high[k] = points[k - 1], low[k - 1], high[k - 1]
            k -= 1
        points[k], low[k], high[k] = point, lower, upper


@scalar
def _exact(points, low, high, left, in_logarithms, below, above):
    """Return an end of the exact interval of points with positive upper weights."""
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
    """Return an end of a rule's consequent for an output."""
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
    """Return the weight of a rule for its firing strength; q counts outputs and rules together."""
    weight = strength
    if system.grades.size > 0:
        grade = system.grades[2 * q + end]
        # Logarithms are only used with the product.
        weight = (
            weight + math.log(grade) if in_logarithms else _both(system.codes[1], weight, grade)
        )
    if system.shares.size > 0:
        share = system.shares[q]
        weight = weight + math.log(share) if in_logarithms else weight * share
    return weight


@scalar
def _fired_together(system, j, r, end, fired):
    """Return the united firing of all rules that have the same consequent as rule r."""
    rules = int(system.table[2])
    together = 0.0
    for other in range(r, rules):
        if system.leaders[j * rules + other] == r and not system.silent[j * rules + other] > 0.0:
            strength = fired[end * rules + other]
            if system.codes[3] == SUMMED:
                together += strength
            else:
                together = _either(system.codes[3], together, strength)
    return together


@scalar
def _gather(system, x, xo, j, end, fired, in_logarithms, said, points, low, high):
    """Write the points with positive upper weights, and their weights.

    ``said`` (R,) holds the values of formulas. Return the number of points, and the sum of the
    points that are not finite, which are replaced with 0.
    """
    rules = int(system.table[2])
    none = -math.inf if in_logarithms else 0.0
    count, beyond = 0, 0.0
    for r in range(rules):
        q = j * rules + r
        if system.silent[q] > 0.0 or (system.leaders.size > 0 and system.leaders[q] != r):
            continue
        if system.leaders.size > 0:
            least = _fired_together(system, j, r, 0, fired)
            most = _fired_together(system, j, r, 1, fired)
        else:
            least, most = fired[r], fired[rules + r]
        upper = _weight(system, q, most, 1, in_logarithms)
        if upper > none:
            if system.programs.size > 0:
                points[count] = said[r]
                if not math.isfinite(said[r]):
                    beyond += said[r]
                    points[count] = 0.0
            else:
                points[count] = _said(system, x, xo, j, r, end)
            lower = _weight(system, q, least, 0, in_logarithms)
            low[count], high[count] = min(lower, upper), upper
            count += 1
    return count, beyond


@scalar
def reduced_by(way, of_averages, end, points, low, high, in_logarithms, below, above):
    """Return an end of the interval of points with positive upper weights, at least one."""
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
    return of_averages[0] * by_low + of_averages[1] * by_high


@scalar
def _sum(points, low, high, end):
    """Return an end of the sum of ``points``, one end each, weighted with intervals."""
    total = 0.0
    for i in range(points.size):
        one, other = low[i] * points[i], high[i] * points[i]
        total += min(one, other) if end == 0 else max(one, other)
    return total


@scalar
def _evaluate_formulas(system, j, x, xo, stack, said):
    """Write the values (R,) of the formulas of an output."""
    for r in range(said.size):
        q = j * said.size + r
        said[r] = formula_at(system.programs, system.places[q], system.places[q + 1], x, xo, stack)


@scalar
def average_in(system: Points, x: Array, xo: int, work: Array, out: Array, oo: int) -> None:
    """Write the type-reduced intervals (m, 2) of the finite row at ``xo`` from ``oo`` on.

    ``work`` (``points_room_size``,) is scratch space.
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
    said = room[5 * rules : 6 * rules]
    for j in range(outputs):
        place = oo + 2 * j
        out[place] = out[place + 1] = math.nan
        if system.programs.size > 0:
            _evaluate_formulas(system, j, x, xo, stack, said)
        for end in range(2):
            count, beyond = _gather(
                system, x, xo, j, end, fired, in_logarithms, said, points, low, high
            )
            if count == 0:
                continue
            if system.codes[0] == WEIGHTED_SUM:
                out[place + end] = _sum(points[:count], low[:count], high[:count], end)
            else:
                out[place + end] = reduced_by(
                    system.codes[0],
                    system.of_averages,
                    end,
                    points[:count],
                    low[:count],
                    high[:count],
                    in_logarithms,
                    below,
                    above,
                )
            if system.programs.size > 0:
                out[place + end] += beyond
        if (
            system.codes[0] != EXACT
            and system.codes[0] != WU_MENDEL
            and system.codes[0] != WEIGHTED_SUM
        ):
            # Direct methods average the middles of the points.
            out[place] = out[place + 1] = 0.5 * out[place] + 0.5 * out[place + 1]
        elif out[place] > out[place + 1]:
            out[place], out[place + 1] = out[place + 1], out[place]
        for end in range(2):
            if math.isnan(out[place + end]):
                out[place + end] = system.defaults[j]


@compiled
def averages(system: Points, x: Array, out: Array) -> int:
    """Write the type-reduced intervals (rows, m, 2) of flat inputs.

    Return -1, or the number of the first row that is not finite.
    """
    inputs, outputs = int(system.table[0]), int(system.table[3])
    work = np.empty(points_room_size(system))
    for i in range(x.size):
        if not math.isfinite(x[i]):
            return i // inputs
    for row in range(x.size // inputs):
        average_in(system, x, row * inputs, work, out, 2 * outputs * row)
    return -1
