"""Compiled inference in logarithms, for firing strengths that underflow.

The ends of an interval depend only on ratios of firing strengths, and Gaussians fire everywhere. So
an input far from all terms has an answer even if its firing strengths underflow.
"""

from __future__ import annotations

import math

from fuzzy2.reduction.kernels import _log_sum, end_in_logarithms
from fuzzy2.support.checks import Array
from fuzzy2.support.compiled import compiled, scalar
from fuzzy2.systems.firing_kernels import HEADER, SUPPLEMENT, TERM, VANISHED, _hedged

LOG_2 = math.log(2.0)


@scalar
def lost(table, low, high):
    """Return whether an end may depend on firing strengths that underflow.

    A lower strength that has not underflowed outweighs all that have. If all upper strengths are
    normal floats, nothing is lost either, because an end uses some upper strength.
    """
    rules, outputs = low.size, int(table[3])
    silent = int(table[5]) + SUPPLEMENT + rules
    spoken = table[5] > 0.0 and table[int(table[5]) + 2] > 0.0
    for j in range(outputs if spoken else 1):
        least, held = math.inf, False
        for r in range(rules):
            if spoken and table[silent + r * outputs + j] > 0.0:
                continue
            if low[r] >= VANISHED:
                held = True
                break
            least = min(least, high[r])
        if not held and least < VANISHED:
            return True
    return False


@scalar
def _log_grades(row, o, x, width, low, high):
    """Return the logarithms of the grades ``low`` and ``high`` that ``_grades`` returned.

    For Gaussians they are parabolas, even where the grades themselves underflow.
    """
    kind = int(row[o + 1])
    if kind == 1 or kind > 2 or (kind == 2 and width * row[o + 8] > 0.0):
        return math.log(low), math.log(high)
    m1, m2, s_low, s_high = row[o + 2], row[o + 3], row[o + 4], row[o + 5]
    h_low, h_high = row[o + 6], row[o + 7]
    if kind == 2:
        h_low, s_low = h_high, s_high
    t = (x - max(min(x, m2), m1)) / s_high
    upper = math.log(h_high) - 0.5 * t * t
    t = (x - (m2 if x < 0.5 * (m1 + m2) else m1)) / s_low
    return min(math.log(h_low) - 0.5 * t * t, upper), upper


@scalar
def log_not(a):
    """Return the logarithm of the complement of a grade."""
    return math.log(-math.expm1(a)) if a > -0.5 else math.log1p(-math.exp(a))


@scalar
def log_both(norm, a, b):
    """Do as ``_both`` with logarithms of grades.

    Where a t-norm jumps, grades are compared as floats, as in ``_both``.
    """
    least, most = min(a, b), max(a, b)
    if norm == 0 or least == -math.inf:
        return least
    if norm == 1:
        return a + b
    if norm == 2:
        # The complement of the greater grade is subtracted from the smaller grade.
        missing = log_not(most) - least
        return least + log_not(missing) if missing < 0.0 else -math.inf
    if norm == 3:
        return -math.inf if math.exp(most) < 1.0 else least
    if norm == 4:
        zero = math.exp(most) < 1.0 and math.exp(least) <= -math.expm1(most)
        return -math.inf if zero else least
    if norm == 5:
        return a + b - log_either(1, a, b)
    return a + b - math.log1p(math.expm1(a) * math.expm1(b))


@scalar
def log_either(norm, a, b):
    """Do as ``_either`` with logarithms of grades."""
    least, most = min(a, b), max(a, b)
    if norm == 0 or least == -math.inf:
        return most
    if norm == 2:
        return min(_log_sum(a, b), 0.0)
    rest, ratio = -math.expm1(most), math.exp(least - most)
    if norm == 3:
        return 0.0
    if norm == 4:
        return 0.0 if math.exp(least) >= rest else most
    if not rest > 0.0:
        return most
    if norm == 5:
        ratio *= rest / -math.expm1(least + most)
    elif norm == 6:
        ratio *= (1.0 + math.exp(most)) / (1.0 + math.exp(least + most))
    return most + math.log1p(ratio * rest)


@scalar
def log_hedged(code, number, a):
    """Do as ``_hedged`` with the logarithm of a grade."""
    if code == -5:
        return number * a
    if code == -10:
        return math.log(number) + a
    if a >= -LOG_2:
        return math.log(_hedged(code, number, math.exp(a)))
    return LOG_2 + 2.0 * a if code == -8 else 0.5 * (a - LOG_2)


@compiled
def combine_logarithms(norm: int, either: bool, a: Array, b: Array, out: Array) -> None:
    """Write the t-norm or t-conorm of a code of logarithms of grades (n,)."""
    for i in range(out.size):
        out[i] = log_either(norm, a[i], b[i]) if either else log_both(norm, a[i], b[i])


@scalar
def log_fire(table, x, xo, width, grades, low, high, stack):
    """Write the logarithms of the firing strengths that ``_fire`` writes.

    ``grades`` are those that ``_fire`` left for the input that starts at ``xo``, and ``stack`` is
    the same scratch space.
    """
    inputs, terms, rules, norm = int(table[0]), int(table[1]), int(table[2]), int(table[4])
    start = int(table[5])
    for t in range(terms):
        o = HEADER + TERM * t
        grades[2 * t], grades[2 * t + 1] = _log_grades(
            table, o, x[xo + int(table[o])], width, grades[2 * t], grades[2 * t + 1]
        )
    if start > 0 and table[start + 1] > 0.0:
        _log_fire_trees(table, grades, low, high, stack)
    else:
        o = HEADER + TERM * terms
        for r in range(rules):
            lower, upper = 0.0, 0.0
            for _ in range(inputs):
                t = int(table[o])
                o += 1
                if t >= 0:
                    lower = log_both(norm, lower, grades[2 * t])
                    upper = log_both(norm, upper, grades[2 * t + 1])
            # The two ends are rounded differently, which must not swap them.
            low[r], high[r] = min(lower, upper), upper
    for r in range(rules if start > 0 else 0):
        weight = math.log(table[start + SUPPLEMENT + r])
        low[r], high[r] = low[r] + weight, high[r] + weight


@scalar
def _log_fire_trees(table, grades, low, high, stack):
    """Write the logarithms of the firing strengths of rules that are trees, without weights."""
    rules, outputs, norm = int(table[2]), int(table[3]), int(table[4])
    start = int(table[5])
    conorm, deepest = int(table[start]), int(table[start + 3])
    places = start + SUPPLEMENT + rules + rules * outputs + outputs
    lower, upper = stack[:deepest], stack[deepest : 2 * deepest]
    for r in range(rules):
        top = -1
        step, end = int(table[places + r]), int(table[places + r + 1])
        while step < end:
            code = int(table[step])
            step += 1
            if code >= -1:
                top += 1
                lower[top] = 0.0 if code < 0 else grades[2 * code]
                upper[top] = 0.0 if code < 0 else grades[2 * code + 1]
            elif code == -2 or code == -6:
                top -= 1
                chosen = norm if code == -2 else conorm
                lower[top] = log_both(chosen, lower[top], lower[top + 1])
                upper[top] = log_both(chosen, upper[top], upper[top + 1])
            elif code == -3 or code == -7:
                top -= 1
                chosen = conorm if code == -3 else norm
                lower[top] = log_either(chosen, lower[top], lower[top + 1])
                upper[top] = log_either(chosen, upper[top], upper[top + 1])
            elif code == -4:
                lower[top], upper[top] = log_not(upper[top]), log_not(lower[top])
            else:
                number = table[step]
                step += 1
                lower[top] = log_hedged(code, number, lower[top])
                upper[top] = log_hedged(code, number, upper[top])
        low[r], high[r] = min(lower[0], upper[0]), upper[0]


@scalar
def center_in_logarithms(table, low, high, room, out, oo, crisp):
    """Do as ``_center_of_sets`` with logarithms; ``room`` (5 R,) is scratch space."""
    inputs, terms, rules, outputs = int(table[0]), int(table[1]), int(table[2]), int(table[3])
    extremes = HEADER + TERM * terms + rules * inputs + 2 * rules * outputs
    in_order = extremes + 2 * outputs
    orders = in_order + 2 * rules * outputs
    spoken = table[5] > 0.0 and table[int(table[5]) + 2] > 0.0
    silent = int(table[5]) + SUPPLEMENT + rules
    defaults = silent + rules * outputs
    points, before, after = room[:rules], room[rules : 2 * rules], room[2 * rules : 3 * rules]
    below, above = room[3 * rules : 4 * rules], room[4 * rules : 5 * rules]
    for j in range(outputs):
        least = greatest = table[defaults + j] if spoken else math.nan
        for end in range(2):
            z = rules * (j + outputs * end)
            count = 0
            for i in range(rules):
                r = int(table[orders + z + i])
                speaks = not spoken or table[silent + r * outputs + j] == 0.0
                if speaks and high[r] > -math.inf:
                    points[count] = table[in_order + z + i]
                    before[count], after[count] = high[r], low[r]
                    count += 1
            if count == 0:
                continue
            # Distances are measured from the extreme point, so the right end is computed as a left
            # end.
            nearest = end_in_logarithms(points[:count], before[:count], after[:count], below, above)
            if end == 0:
                least = table[extremes + j] + nearest
            else:
                greatest = table[extremes + outputs + j] - nearest
        if crisp:
            out[oo + j] = 0.5 * (least + greatest)
        else:
            out[oo + 2 * j], out[oo + 2 * j + 1] = min(least, greatest), max(least, greatest)
