"""Compiled loops of inference, which :mod:`fuzzy2.systems` calls."""

from __future__ import annotations

import math

import numpy as np

from fuzzy2.reduction.kernels import EIASC, end_of_interval
from fuzzy2.support.checks import Array
from fuzzy2.support.compiled import compiled, scalar
from fuzzy2.systems.firing_kernels import (
    HEADER,
    SUPPLEMENT,
    TERM,
    VANISHED,
    _fire,
    _fire_block,
)
from fuzzy2.systems.log_firing_kernels import center_in_logarithms, log_fire, lost

# Comparisons closer than this, relative to the compared values, are left to the exact search, which
# rounding cannot mislead.
CLOSE = 1e-12
# Products of weights below this would lose digits to underflow. The exact search scales the weights
# first.
TINY = 1e-200


@scalar
def work_size(table: Array) -> int:
    """Return the size of the scratch space for one row: grades, firing strengths and searches."""
    size = 2 * int(table[1]) + 10 * int(table[2]) + 2 * int(table[3])
    return size + (2 * int(table[int(table[5]) + 3]) if table[5] > 0.0 else 0)


@scalar
def rooms(table, work):
    """Return the parts of the scratch space ``work`` (``work_size``,).

    Only functions that do not allocate memory may call it, because others would release these
    parts.

    The parts are grades (2 T,), lower and upper firing strengths (R,), their differences (R,),
    moments (2 m,), seven numbers per rule for searches, and the stack.
    """
    grades, rules = 2 * int(table[1]), int(table[2])
    moments = grades + 3 * rules
    search = moments + 2 * int(table[3])
    return (
        work[:grades],
        work[grades : grades + rules],
        work[grades + rules : grades + 2 * rules],
        work[grades + 2 * rules : moments],
        work[moments:search],
        work[search : search + 7 * rules],
        work[search + 7 * rules :],
    )


@scalar
def _exact_end(table, z, order, rules, low, high, room):
    """Return one end by the search of ``_end``, for firing strengths of very different sizes.

    The fast search falls back to it.
    """
    points, before, after = room[:rules], room[rules : 2 * rules], room[2 * rules : 3 * rules]
    below, above = room[3 * rules : 4 * rules], room[4 * rules : 5 * rules]
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
    return end_of_interval(points[:count], before[:count], after[:count], True, EIASC, below, above)


@scalar
def _center_of_spoken(table, low, high, room, out, oo, crisp):
    """Do as ``_center_of_sets`` for rules without some consequents, or outputs with defaults."""
    inputs, terms, rules, outputs = int(table[0]), int(table[1]), int(table[2]), int(table[3])
    extremes = HEADER + TERM * terms + rules * inputs + 2 * rules * outputs
    in_order = extremes + 2 * outputs
    orders = in_order + 2 * rules * outputs
    silent = int(table[5]) + SUPPLEMENT + rules
    defaults = silent + rules * outputs
    lower, upper = room[5 * rules : 6 * rules], room[6 * rules :]
    for j in range(outputs):
        spoken = 0.0
        for r in range(rules):
            speaks = table[silent + r * outputs + j] == 0.0
            lower[r] = low[r] if speaks else 0.0
            upper[r] = high[r] if speaks else 0.0
            spoken = max(spoken, upper[r])
        least = greatest = table[defaults + j]
        if spoken > 0.0:
            z = rules * j
            least = table[extremes + j] + _exact_end(
                table, in_order + z, orders + z, rules, lower, upper, room
            )
            z = rules * (j + outputs)
            greatest = table[extremes + outputs + j] - _exact_end(
                table, in_order + z, orders + z, rules, lower, upper, room
            )
        if crisp:
            out[oo + j] = 0.5 * (least + greatest)
        else:
            out[oo + 2 * j], out[oo + 2 * j + 1] = min(least, greatest), max(least, greatest)


@scalar
def _center_of_sets(  # noqa: C901 (both ends of all outputs in one compiled loop, for speed)
    table, low, high, extra, moments, room, out, oo, crisp
):
    """Write the type-reduced interval of every output, or its middle.

    It is NaN where no rule fires.
    """
    if table[5] > 0.0 and table[int(table[5]) + 2] > 0.0:
        _center_of_spoken(table, low, high, room, out, oo, crisp)
        return
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
        if low[r] > 0.0:
            # A slice shows the compiler a contiguous row, so that it adds several outputs at once.
            row = table[ends + 2 * outputs * r : ends + 2 * outputs * (r + 1)]
            for j in range(2 * outputs):
                moments[j] += weight * row[j]
    for j in range(outputs):
        least = greatest = math.nan
        # The left end is computed as it is, the right end on mirrored points. Distances grow from
        # the extreme point inward and take upper weights up to the switch point, so the sums only
        # grow. (One function for both would take a dozen arguments and twice the time.)
        for end in range(2):
            if not fires > 0.0:
                break
            z = in_order + rules * (j + outputs * end)
            order = orders + rules * (j + outputs * end)
            moment = moments[j + outputs * end]
            weight = mass
            settled = fires > TINY
            # Without uncertainty there is no switch point to search.
            i = 0 if uncertainty > 0.0 else rules
            while i < rules:
                distance = table[z + i]
                gap = distance * weight - moment
                # Before any weight is added there is no average to compare with.
                if weight > 0.0 and not gap < -CLOSE * moment:
                    settled = settled and (gap > CLOSE * moment or moment == 0.0)
                    break
                r = int(table[order + i])
                moment += extra[r] * distance
                weight += extra[r]
                i += 1
            if settled:
                nearest = moment / weight
            else:
                nearest = _exact_end(table, z, order, rules, low, high, room)
            if end == 0:
                least = table[extremes + j] + nearest
            else:
                greatest = table[extremes + outputs + j] - nearest
        if crisp:
            out[oo + j] = 0.5 * (least + greatest)
        else:
            # The two ends are computed separately and may cross by rounding if the interval is a
            # point.
            out[oo + 2 * j], out[oo + 2 * j + 1] = min(least, greatest), max(least, greatest)


@scalar
def evaluate_in(
    table: Array, x: Array, xo: int, width: float, crisp: bool, work: Array, out: Array, oo: int
) -> None:
    """Do as ``evaluate`` for the finite row at ``xo``; write the outputs from ``oo`` on.

    ``work`` (``work_size``,) is scratch space.
    """
    grades, low, high, extra, moments, room, stack = rooms(table, work)
    _fire(table, x, xo, width, grades, low, high, stack)
    _center_of_sets(table, low, high, extra, moments, room, out, oo, crisp)
    # Usually the first rule already rules out underflow.
    if (low[0] < VANISHED or table[5] > 0.0) and lost(table, low, high):
        log_fire(table, x, xo, width, grades, low, high, stack)
        center_in_logarithms(table, low, high, room, out, oo, crisp)


# Number of rows that are processed together: enough to hide the overhead of the loops, few enough
# to stay in the fastest cache.
LANES = 128


@compiled
def _nearest(distances, order, table, extra, mass, moment, weight, unsettled):
    """Search the switch points of one end for all rows of a block at once.

    ``moment`` holds the moment of the lower weights, and becomes the moment at the switch point.

    The rows of a block share the order of the rules, so each step is the same few operations on all
    rows. A row that has passed its switch point stays there, because the next distance is greater
    still.
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
def _evaluate_blocks(  # noqa: C901 (LANES rows in one compiled loop, for speed)
    table, x, width, crisp, out, rows
):
    """Do as ``evaluate`` for ``rows`` rows, a multiple of LANES, block by block.

    The results are the same bit for bit.
    """
    inputs, terms, rules, outputs = int(table[0]), int(table[1]), int(table[2]), int(table[3])
    ends = HEADER + TERM * terms + rules * inputs
    extremes = ends + 2 * rules * outputs
    in_order = extremes + 2 * outputs
    orders = in_order + 2 * rules * outputs
    grades = np.empty((2 * terms, LANES))
    one_low, one_high = np.empty(rules), np.empty(rules)
    low, extra = np.empty((rules, LANES)), np.empty((rules, LANES))
    mass, moment, weight = np.empty(LANES), np.empty(LANES), np.empty(LANES)
    unsettled, left = np.empty(LANES), np.empty(LANES)
    work = np.empty(work_size(table))
    for start in range(0, rows, LANES):
        uncertain = _fire_block(table, x, start, width, grades, one_low, one_high, low, extra)
        for lane in range(LANES):
            mass[lane] = unsettled[lane] = 0.0
        for r in range(rules):
            lower, upper = low[r], extra[r] if uncertain else low[r]
            for lane in range(LANES):
                mass[lane] += lower[lane]
                unsettled[lane] = max(unsettled[lane], upper[lane])
        for lane in range(LANES):
            # The greatest firing strength is replaced with a flag: whether weights are too small.
            settled = unsettled[lane] > TINY and mass[lane] >= rules * VANISHED
            unsettled[lane] = 0.0 if settled else 1.0
        for r in range(rules if uncertain else 0):
            lower, upper = low[r], extra[r]
            for lane in range(LANES):
                upper[lane] -= lower[lane]
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
                if uncertain:
                    first = in_order + rules * column
                    _nearest(
                        table[first : first + rules],
                        orders + rules * column,
                        table,
                        extra,
                        mass,
                        moment,
                        weight,
                        unsettled,
                    )
                else:
                    # No weight can change, so there is no switch point to search.
                    for lane in range(LANES):
                        weight[lane] = mass[lane]
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
                per_row = outputs if crisp else 2 * outputs
                evaluate_in(table, x, row * inputs, width, crisp, work, out, row * per_row)


@compiled
def evaluate(table: Array, x: Array, width: float, crisp: bool, out: Array) -> int:
    """Write the outputs (rows, m), or type-reduced intervals (rows, m, 2), of flat inputs.

    Return -1, or the number of the first row that is not finite.
    """
    inputs, outputs = int(table[0]), int(table[3])
    work = np.empty(work_size(table))
    per_row = outputs if crisp else 2 * outputs
    for i in range(x.size):
        if not math.isfinite(x[i]):
            return i // inputs
    rows = x.size // inputs
    in_blocks = rows - rows % LANES
    if table[5] > 0.0 and table[int(table[5]) + 2] > 0.0:
        in_blocks = 0
    if in_blocks > 0:
        _evaluate_blocks(table, x, width, crisp, out, in_blocks)
    for row in range(in_blocks, rows):
        evaluate_in(table, x, row * inputs, width, crisp, work, out, row * per_row)
    return -1


@compiled
def evaluate_row(table: Array, x: Array, out: Array) -> int:
    """Write the outputs (m,), or the type-reduced intervals (2 m,), of one row.

    Return 1, or 0 if it is not one finite row of inputs.

    It is a fast path with few arguments, because each argument costs a tenth of a microsecond.
    """
    if x.size != int(table[0]):
        return 0
    return 1 if evaluate(table, x, 0.0, out.size == int(table[3]), out) < 0 else 0


@scalar
def crisp_planes_in(
    table: Array,
    x: Array,
    xo: int,
    widths: Array,
    alphas: Array,
    work: Array,
    middles: Array,
    out: Array,
    oo: int,
) -> None:
    """Do as ``evaluate_crisp_planes`` for the finite row at ``xo``; write from ``oo`` on.

    ``work`` is as in ``evaluate_in``, and ``middles`` (m,) is scratch space for one plane's
    outputs.
    """
    total = 0.0
    for plane in range(alphas.size):
        total += alphas[plane]
    for j in range(middles.size):
        out[oo + j] = 0.0
    for plane in range(widths.size):
        evaluate_in(table, x, xo, widths[plane], True, work, middles, 0)
        for j in range(middles.size):
            out[oo + j] += alphas[plane] * middles[j]
    for j in range(middles.size):
        out[oo + j] /= total


@compiled
def evaluate_crisp_planes(table: Array, x: Array, widths: Array, alphas: Array, out: Array) -> int:
    """Write the crisp outputs (rows, m): averages of the α-planes' middles, weighted with α.

    Return as ``evaluate``.
    """
    inputs, outputs = int(table[0]), int(table[3])
    work, middles = np.empty(work_size(table)), np.empty(outputs)
    for i in range(x.size):
        if not math.isfinite(x[i]):
            return i // inputs
    for row in range(x.size // inputs):
        crisp_planes_in(table, x, row * inputs, widths, alphas, work, middles, out, row * outputs)
    return -1


@compiled
def evaluate_planes(table: Array, x: Array, widths: Array, out: Array) -> int:
    """Write the type-reduced intervals (rows, planes, m, 2) of the alpha-planes.

    ``widths`` are the half-widths of the planes. The return value is that of ``evaluate``.
    """
    inputs, outputs = int(table[0]), int(table[3])
    work = np.empty(work_size(table))
    for row in range(x.size // inputs):
        for i in range(inputs):
            if not math.isfinite(x[row * inputs + i]):
                return row
        for plane in range(widths.size):
            place = 2 * outputs * (row * widths.size + plane)
            evaluate_in(table, x, row * inputs, widths[plane], False, work, out, place)
    return -1


@scalar
def _firing_in(table, x, xo, width, work, out, oo):
    """Do as ``firing`` for the finite row at ``xo``."""
    grades, low, high, _, _, _, stack = rooms(table, work)
    _fire(table, x, xo, width, grades, low, high, stack)
    for r in range(low.size):
        out[oo + 2 * r], out[oo + 2 * r + 1] = low[r], high[r]


@compiled
def firing(table: Array, x: Array, width: float, out: Array) -> int:
    """Write the firing intervals (rows, R, 2) of flat inputs.

    Return -1, or the number of the first row that is not finite.
    """
    inputs, rules = int(table[0]), int(table[2])
    work = np.empty(work_size(table))
    for row in range(x.size // inputs):
        for i in range(inputs):
            if not math.isfinite(x[row * inputs + i]):
                return row
        _firing_in(table, x, row * inputs, width, work, out, 2 * row * rules)
    return -1
