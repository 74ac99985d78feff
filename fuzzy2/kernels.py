"""Compiled loops of type reduction and inference; :mod:`fuzzy2.type_reduction` and :mod:`fuzzy2.systems` are their faces.

Type reduction works on one row: points sorted in ascending order, and the weights in that order. The left end takes upper weights up
to the switch point and lower ones after it; the right end is computed on the same points with the roles exchanged.

Whether point k lies below the average is decided without the average: it does if its moment from the points below is smaller
than that from the points above,

    F(k) = sum of before[i] (z[k] - z[i]) over i < k   <   H(k) = sum of after[i] (z[i] - z[k]) over i > k.

Weight k itself takes no part, so a weight that outweighs all others by more digits than a float has cannot hide the answer, as it
does when z[k] is compared with an average that it dominates. F never falls with k and H never rises, so there is one switch point.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from fuzzy2.compiled import compiled

Array = NDArray[np.float64]

KM, EKM, IASC, EIASC, SCAN = range(5)


@compiled
def _moments(z, before, after, below, above):
    """Write F and H of every point. All terms are positive and sums are only added to, so nothing cancels."""
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


@compiled
def _average(z, before, after, k):
    """Average of the points, measured from the first one, with ``before`` for the first k weights and ``after`` for the others."""
    numerator, denominator = 0.0, 0.0
    for i in range(k):
        numerator += before[i] * (z[i] - z[0])
        denominator += before[i]
    for i in range(k, z.size):
        numerator += after[i] * (z[i] - z[0])
        denominator += after[i]
    return numerator / denominator


@compiled
def _switch_of(z, average):
    """Return the number of points that do not lie above the average, at least 1 and at most n − 1."""
    k = 1
    while k < z.size - 1 and z[k] - z[0] <= average:
        k += 1
    return k


@compiled
def _end(z, before, after, left, method, below, above):
    """One end of the interval: the extreme average over all switch points k, for points that can all carry weight.

    ``before`` are the weights of the first k points and ``after`` those of the others: upper and lower for the left end, lower and
    upper for the right end. The best k lies between 1 and n − 1, and there the point at the extreme end has its upper weight, so no
    sum of weights is ever zero.
    """
    n = z.size
    if n == 1:
        return z[0]
    if method == SCAN:
        best = _average(z, before, after, 1)
        mass_after, moment_after = 0.0, 0.0
        for k in range(n - 1, 0, -1):
            # Suffix sums, into the scratch arrays.
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
        # Enhanced: the right end starts from its own side, where its switch point is nearer.
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
        # Karnik and Mendel's step from average to switch point, while it leads outward.
        average = _average(z, before, after, k)
        while True:
            new = _switch_of(z, average)
            candidate = _average(z, before, after, new)
            if new == k or not (candidate < average if left else candidate > average):
                break
            k, average = new, candidate
    # The step with stop condition, one point at a time; after Karnik and Mendel's it only confirms, or settles a hidden switch point.
    while k < n - 1 and below[k] < above[k]:
        k += 1
    while k > 1 and below[k - 1] >= above[k - 1]:
        k -= 1
    return z[0] + _average(z, before, after, k)


@compiled
def reduce_rows(z: Array, order: NDArray[np.int64], w: Array, method: int, out: Array) -> None:
    """Write left and right end of every row.

    ``z`` (rows or 1, n, 2) holds both ends of the points, each column sorted, ``order`` the indices that sort them, ``w``
    (rows, n, 2) lower and upper weights in the original order, ``out`` (rows, 2).
    """
    n = w.shape[1]
    points, low, high = np.empty(n), np.empty(n), np.empty(n)
    below, above = np.empty(n), np.empty(n)
    for row in range(w.shape[0]):
        source = row if z.shape[0] > 1 else 0
        # Weights relative to the largest: products of tiny ones would underflow.
        largest = w[row, :, 1].max()
        for end in range(2):
            # Points that cannot carry weight take no part: they could stand where the switch point is looked for.
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
                out[row, end] = _end(points[:count], high[:count], low[:count], True, method, below, above)
            else:
                out[row, end] = _end(points[:count], low[:count], high[:count], False, method, below, above)
        if out[row, 0] > out[row, 1]:
            # The ends of a point come from two sides, and can miss each other by rounding.
            out[row, 0], out[row, 1] = out[row, 1], out[row, 0]


# Inference. A system is one array of floats, so that a call hands over one table and not seven arrays. It starts with
# (inputs p, terms T, rules R, outputs m, t-norm code, consequents are crisp), then follow
#   terms       T rows of 10: index of the input, then what kernel_row() gives
#   rules       R rows of p: index of the term, or -1 where the input plays no part
#   ends        R rows of 2 m: left ends of the consequents, above the least of their output, then right ends, below the greatest
#   least, greatest   m numbers each
#   sorted      2 m rows of R: these distances in ascending order
#   orders      2 m rows of R: the rules in that order
HEADER = 6
TERM = 10


@compiled
def _grades(row, o, x, width):
    """Lower and upper grade of x in the term whose table row starts at o; see ``kernel_row`` of the sets.

    ``width`` is the half-width, in standard deviations of the secondary grades, of the alpha-plane of a Gaussian type-2 set.
    """
    kind = int(row[o + 1])
    if kind == 1:
        a, b, c, d, height = row[o + 2], row[o + 3], row[o + 4], row[o + 5], row[o + 6]
        if x < a or x > d:
            grade = 0.0
        elif x < b:
            grade = height * (x - a) / (b - a)
        elif x > c:
            grade = height * (d - x) / (d - c)
        else:
            grade = height
        return grade, grade
    m1, m2, s_low, s_high, h_low, h_high, secondary = (
        row[o + 2], row[o + 3], row[o + 4], row[o + 5], row[o + 6], row[o + 7], row[o + 8],
    )  # fmt: skip
    if kind == 2:
        # Gaussian secondary grades about a Gaussian principal membership function.
        t = (x - m1) / s_high
        principal = h_high * math.exp(-0.5 * t * t)
        return max(principal - width * secondary, 0.0), min(principal + width * secondary, 1.0)
    if x < m1:
        t = (x - m1) / s_high
        upper = h_high * math.exp(-0.5 * t * t)
    elif x > m2:
        t = (x - m2) / s_high
        upper = h_high * math.exp(-0.5 * t * t)
    else:
        upper = h_high
    if m1 == m2 and s_low == s_high and h_low == h_high:
        return upper, upper
    t = (x - (m2 if x < 0.5 * (m1 + m2) else m1)) / s_low
    return h_low * math.exp(-0.5 * t * t), upper


@compiled
def _fire(table, x, xo, width, grades, low, high):
    """Write lower and upper firing strength of every rule for the input that starts at ``xo``."""
    inputs, terms, rules, norm = int(table[0]), int(table[1]), int(table[2]), int(table[4])
    for t in range(terms):
        o = HEADER + TERM * t
        grades[2 * t], grades[2 * t + 1] = _grades(table, o, x[xo + int(table[o])], width)
    o = HEADER + TERM * terms
    for r in range(rules):
        lower, upper = 1.0, 1.0
        for _ in range(inputs):
            t = int(table[o])
            o += 1
            if t < 0:
                continue
            if norm == 0:
                lower, upper = min(lower, grades[2 * t]), min(upper, grades[2 * t + 1])
            else:
                lower *= grades[2 * t]
                upper *= grades[2 * t + 1]
        low[r], high[r] = lower, upper


# Comparisons closer than this, relative to what is compared, are left to the search that rounding cannot mislead.
CLOSE = 1e-12
# Products of weights below this one would lose digits to underflow; that search makes them relative first.
TINY = 1e-200


@compiled
def _exact_end(table, z, order, rules, low, high):
    """One end by the search of ``_end``, for firing strengths of very different size; the fast search hands over to it."""
    points, before, after = np.empty(rules), np.empty(rules), np.empty(rules)
    largest = 0.0
    for r in range(rules):
        largest = max(largest, high[r])
    count = 0
    for i in range(rules):
        r = int(table[order + i])
        if high[r] > 0.0:
            points[count] = table[z + i]
            before[count], after[count] = high[r] / largest, low[r] / largest
            count += 1
    return _end(points[:count], before[:count], after[:count], True, EIASC, np.empty(rules), np.empty(rules))


@compiled
def _center_of_sets(table, low, high, extra, moments, out, oo, crisp):
    """Write the type-reduced interval, or its middle, of every output; return nothing. NaN where no rule fires."""
    inputs, terms, rules, outputs = int(table[0]), int(table[1]), int(table[2]), int(table[3])
    ends = HEADER + TERM * terms + rules * inputs
    extremes = ends + 2 * rules * outputs
    in_order = extremes + 2 * outputs
    orders = in_order + 2 * rules * outputs
    mass, fires, uncertainty = 0.0, 0.0, 0.0
    for j in range(2 * outputs):
        moments[j] = 0.0
    for r in range(rules):
        weight = low[r]
        mass += weight
        fires = max(fires, high[r])
        extra[r] = high[r] - weight
        uncertainty = max(uncertainty, extra[r])
        if weight > 0.0:
            # A slice, so that the compiler sees a plain row and adds several outputs at once.
            row = table[ends + 2 * outputs * r : ends + 2 * outputs * (r + 1)]
            for j in range(2 * outputs):
                moments[j] += weight * row[j]
    for j in range(outputs):
        least = greatest = math.nan
        # The left end as it is, then the right end mirrored: distances grow from the extreme point inward and take upper weights up to
        # the switch point, so sums are only added to. (One function for both would be called with a dozen arguments, and cost twice.)
        for end in range(2):
            if not fires > 0.0:
                break
            z = in_order + rules * (j + outputs * end)
            order = orders + rules * (j + outputs * end)
            moment = moments[j + outputs * end]
            weight = mass
            settled = fires > TINY
            # Without uncertainty there is nothing to search: no weight can change.
            i = 0 if uncertainty > 0.0 else rules
            while i < rules and not weight > 0.0:
                r = int(table[order + i])
                moment += extra[r] * table[z + i]
                weight += extra[r]
                i += 1
            while i < rules:
                distance = table[z + i]
                gap = distance * weight - moment
                if not gap < -CLOSE * moment:
                    settled = settled and (gap > CLOSE * moment or moment == 0.0)
                    break
                r = int(table[order + i])
                moment += extra[r] * distance
                weight += extra[r]
                i += 1
            nearest = moment / weight if settled else _exact_end(table, z, order, rules, low, high)
            if end == 0:
                least = table[extremes + j] + nearest
            else:
                greatest = table[extremes + outputs + j] - nearest
        if crisp:
            out[oo + j] = 0.5 * (least + greatest)
        else:
            # The ends of a point come from two sides, and can miss each other by rounding.
            out[oo + 2 * j], out[oo + 2 * j + 1] = min(least, greatest), max(least, greatest)


# Rows that are carried together where there are many: enough to hide the loops' own cost, few enough to stay in the fastest memory.
LANES = 128


@compiled
def _nearest(distances, order, table, extra, mass, moment, weight, unsettled):
    """Search one end of all rows of a block at once: ``moment`` holds that of the lower weights, and becomes that at the switch point.

    The rows of a block share the order of the rules, so each step is the same few operations on rows side by side; a row that has
    passed its switch point stays there, for the next distance is greater still.
    """
    for row in range(LANES):
        weight[row] = mass[row]
    for i in range(distances.size):
        distance = distances[i]
        added = extra[int(table[order + i])]
        for row in range(LANES):
            gap = distance * weight[row] - moment[row]
            step = added[row] if gap < 0.0 or weight[row] == 0.0 else 0.0
            close = abs(gap) <= CLOSE * moment[row] and moment[row] > 0.0
            unsettled[row] += 1.0 if close else 0.0
            moment[row] += step * distance
            weight[row] += step


@compiled
def _evaluate_blocks(table, x, width, crisp, out, rows):
    """Do as ``evaluate`` for ``rows`` rows, a multiple of LANES, all outputs of a block at a time; to the last bit the same."""
    inputs, terms, rules, outputs = int(table[0]), int(table[1]), int(table[2]), int(table[3])
    ends = HEADER + TERM * terms + rules * inputs
    extremes = ends + 2 * rules * outputs
    in_order = extremes + 2 * outputs
    orders = in_order + 2 * rules * outputs
    grades = np.empty(2 * terms)
    one_low, one_high = np.empty(rules), np.empty(rules)
    low, extra = np.empty((rules, LANES)), np.empty((rules, LANES))
    mass, moment, weight = np.empty(LANES), np.empty(LANES), np.empty(LANES)
    unsettled, left = np.empty(LANES), np.empty(LANES)
    moments = np.empty(2 * outputs)
    one_extra = np.empty(rules)
    for start in range(0, rows, LANES):
        for lane in range(LANES):
            _fire(table, x, (start + lane) * inputs, width, grades, one_low, one_high)
            total, fires = 0.0, 0.0
            for r in range(rules):
                low[r, lane] = one_low[r]
                extra[r, lane] = one_high[r] - one_low[r]
                total += one_low[r]
                fires = max(fires, one_high[r])
            mass[lane] = total
            unsettled[lane] = 0.0 if fires > TINY else 1.0
        for j in range(outputs):
            for end in range(2):
                column = j + outputs * end
                for lane in range(LANES):
                    moment[lane] = 0.0
                for r in range(rules):
                    distance = table[ends + 2 * outputs * r + column]
                    weights = low[r]
                    for lane in range(LANES):
                        moment[lane] += weights[lane] * distance
                first = in_order + rules * column
                _nearest(table[first : first + rules], orders + rules * column, table, extra, mass, moment, weight, unsettled)
                extreme = table[extremes + column]
                for lane in range(LANES):
                    o = (start + lane) * outputs + j
                    if end == 0:
                        left[lane] = extreme + moment[lane] / weight[lane]
                    elif crisp:
                        out[o] = 0.5 * (left[lane] + (extreme - moment[lane] / weight[lane]))
                    else:
                        right = extreme - moment[lane] / weight[lane]
                        out[2 * o], out[2 * o + 1] = min(left[lane], right), max(left[lane], right)
        for lane in range(LANES):
            if unsettled[lane] > 0.0:
                row = start + lane
                _fire(table, x, row * inputs, width, grades, one_low, one_high)
                _center_of_sets(table, one_low, one_high, one_extra, moments, out, row * (outputs if crisp else 2 * outputs), crisp)


@compiled
def evaluate(table: Array, x: Array, width: float, crisp: bool, out: Array) -> int:
    """Write the outputs (rows, m), or type-reduced intervals (rows, m, 2), of flat inputs; return -1 or the first row not finite."""
    inputs, terms, rules, outputs = int(table[0]), int(table[1]), int(table[2]), int(table[3])
    grades = np.empty(2 * terms)
    low, high = np.empty(rules), np.empty(rules)
    moments = np.empty(2 * outputs)
    extra = np.empty(rules)
    per_row = outputs if crisp else 2 * outputs
    for i in range(x.size):
        if not math.isfinite(x[i]):
            return i // inputs
    rows = x.size // inputs
    in_blocks = rows - rows % LANES
    if in_blocks > 0:
        _evaluate_blocks(table, x, width, crisp, out, in_blocks)
    for row in range(in_blocks, rows):
        _fire(table, x, row * inputs, width, grades, low, high)
        _center_of_sets(table, low, high, extra, moments, out, row * per_row, crisp)
    return -1


@compiled
def evaluate_row(table: Array, x: Array, out: Array) -> int:
    """Write the outputs (m,), or the type-reduced intervals (2 m,), of one row; return 1, or 0 if it is not one finite row of inputs.

    For callers in a hurry: every argument costs a tenth of a microsecond.
    """
    if x.size != int(table[0]):
        return 0
    return 1 if evaluate(table, x, 0.0, out.size == int(table[3]), out) < 0 else 0


@compiled
def evaluate_crisp_planes(table: Array, x: Array, widths: Array, alphas: Array, out: Array) -> int:
    """Write the crisp outputs (rows, m), the middles on the alpha-planes weighted with alpha; return as ``evaluate``."""
    inputs, terms, rules, outputs = int(table[0]), int(table[1]), int(table[2]), int(table[3])
    grades = np.empty(2 * terms)
    low, high = np.empty(rules), np.empty(rules)
    moments, middles = np.empty(2 * outputs), np.empty(outputs)
    extra = np.empty(rules)
    total = 0.0
    for plane in range(alphas.size):
        total += alphas[plane]
    for i in range(x.size):
        if not math.isfinite(x[i]):
            return i // inputs
    for row in range(x.size // inputs):
        for j in range(outputs):
            out[row * outputs + j] = 0.0
        for plane in range(widths.size):
            _fire(table, x, row * inputs, widths[plane], grades, low, high)
            _center_of_sets(table, low, high, extra, moments, middles, 0, True)
            for j in range(outputs):
                out[row * outputs + j] += alphas[plane] * middles[j]
        for j in range(outputs):
            out[row * outputs + j] /= total
    return -1


@compiled
def evaluate_planes(table: Array, x: Array, widths: Array, out: Array) -> int:
    """Write the type-reduced intervals (rows, planes, m, 2) of the alpha-planes of half-widths ``widths``; return as ``evaluate``."""
    inputs, terms, rules, outputs = int(table[0]), int(table[1]), int(table[2]), int(table[3])
    grades = np.empty(2 * terms)
    low, high = np.empty(rules), np.empty(rules)
    moments = np.empty(2 * outputs)
    extra = np.empty(rules)
    for row in range(x.size // inputs):
        for i in range(inputs):
            if not math.isfinite(x[row * inputs + i]):
                return row
        for plane in range(widths.size):
            _fire(table, x, row * inputs, widths[plane], grades, low, high)
            _center_of_sets(table, low, high, extra, moments, out, 2 * outputs * (row * widths.size + plane), False)
    return -1


@compiled
def evaluate_corollary(table: Array, x: Array, middles: Array, spreads: Array, product_grades: bool, out: Array) -> int:
    """Write mean and standard deviation (rows, m, 2) by the Gaussian corollary (eq. 1.107, 1.108); return as ``evaluate``.

    ``middles`` and ``spreads`` (R, m) are means and standard deviations of the consequents; firing strengths are Gaussian numbers
    with the moments of eq. 1.30.
    """
    inputs, terms, rules, outputs = int(table[0]), int(table[1]), int(table[2]), int(table[3])
    grades = np.empty(2 * terms)
    mean, sigma = np.empty(rules), np.empty(rules)
    for row in range(x.size // inputs):
        for i in range(inputs):
            if not math.isfinite(x[row * inputs + i]):
                return row
        for t in range(terms):
            o = HEADER + TERM * t
            grades[2 * t], _ = _grades(table, o, x[row * inputs + int(table[o])], 0.0)
            grades[2 * t + 1] = table[o + 8] if int(table[o + 1]) == 2 else 0.0
        o = HEADER + TERM * terms
        total = 0.0
        for r in range(rules):
            m, variance = 1.0, 0.0
            for _ in range(inputs):
                t = int(table[o])
                o += 1
                if t >= 0:
                    g, s = grades[2 * t], grades[2 * t + 1]
                    variance = variance * g * g + m * m * s * s
                    m *= g
            mean[r], sigma[r] = m, math.sqrt(variance)
            total += m
        for j in range(outputs):
            q = 2 * (row * outputs + j)
            if not total > 0.0:
                out[q] = out[q + 1] = math.nan
                continue
            moment = 0.0
            for r in range(rules):
                moment += mean[r] * (middles[r, j] - middles[0, j])
            center = middles[0, j] + moment / total
            spread = 0.0
            for r in range(rules):
                one, two = mean[r] * spreads[r, j], (middles[r, j] - center) * sigma[r]
                spread += one * one + two * two if product_grades else one + abs(two)
            out[q] = center
            out[q + 1] = (math.sqrt(spread) if product_grades else spread) / total
    return -1


@compiled
def firing(table: Array, x: Array, width: float, out: Array) -> int:
    """Write the firing intervals (rows, R, 2) of flat inputs; return -1 or the first row that is not finite."""
    inputs, terms, rules = int(table[0]), int(table[1]), int(table[2])
    grades = np.empty(2 * terms)
    low, high = np.empty(rules), np.empty(rules)
    for row in range(x.size // inputs):
        for i in range(inputs):
            if not math.isfinite(x[row * inputs + i]):
                return row
        _fire(table, x, row * inputs, width, grades, low, high)
        for r in range(rules):
            out[2 * (row * rules + r)], out[2 * (row * rules + r) + 1] = low[r], high[r]
    return -1


@compiled
def reduce_firing(table: Array, strengths: Array, crisp: bool, out: Array) -> None:
    """Write outputs for firing intervals (rows, R, 2) that were computed elsewhere."""
    rules, outputs = int(table[2]), int(table[3])
    low, high = np.empty(rules), np.empty(rules)
    moments = np.empty(2 * outputs)
    extra = np.empty(rules)
    per_row = outputs if crisp else 2 * outputs
    for row in range(strengths.size // (2 * rules)):
        for r in range(rules):
            low[r], high[r] = strengths[2 * (row * rules + r)], strengths[2 * (row * rules + r) + 1]
        _center_of_sets(table, low, high, extra, moments, out, row * per_row, crisp)
