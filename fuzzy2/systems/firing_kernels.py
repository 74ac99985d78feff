"""Compiled firing of rules; :mod:`fuzzy2.systems.kernels` reduces the consequents."""

from __future__ import annotations

import math

import numpy as np

from fuzzy2.support.compiled import compiled, scalar
from fuzzy2.systems.shape_kernels import PAIR, SAMPLES, grade_of_shape

# Inference. A system is one array of floats, so that a call passes one table instead of seven
# arrays. It begins with the number of inputs p, terms T, rules R and outputs m, the code of the
# t-norm, the place of the supplement (0 if there is none), and how exponents are added, see
# ``_fire_by_exponents``. Then follow
#   terms       T rows of 10: number of the input, then the result of kernel_row()
#   rules       R rows of p: number of the term, or -1 if the rule does not use the input
#   ends        R rows of 2 m: distances of the left ends of the consequents above the least of
#               their output, then distances of the right ends below the greatest
#   least, greatest   m numbers each
#   sorted      2 m rows of R: these distances in ascending order
#   orders      2 m rows of R: the rules in that order
#   supplement  of systems that need one, see ``fuzzy2.systems.table.supplement_of``: four numbers
#               (code of the t-conorm, whether rules are trees, whether a rule has no consequent for
#               an output or an output has a default, deepest stack), R weights, R rows of m:
#               whether a rule has no consequent, m defaults or NaN, R + 1 places where the steps
#               of the rules begin, and the steps of ``fuzzy2.systems.antecedents``
HEADER = 7
TERM = 10
SUPPLEMENT = 4


@scalar
def _grades(row, o, x, width):
    """Return the lower and upper grade of x in the term whose table row starts at o.

    The rows are described in ``kernel_row`` of the sets.

    ``width`` is the half-width, in standard deviations of the secondary grades, of the alpha-plane
    of a Gaussian type-2 set.
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
    if kind >= SAMPLES:
        if kind == PAIR:
            upper = grade_of_shape(row, int(row[o + 3]), x)
            return min(grade_of_shape(row, int(row[o + 2]), x), upper), upper
        grade = grade_of_shape(row, o, x)
        return grade, grade
    m1, m2, s_low, s_high, h_low, h_high, secondary = (
        row[o + 2],
        row[o + 3],
        row[o + 4],
        row[o + 5],
        row[o + 6],
        row[o + 7],
        row[o + 8],
    )
    if kind == 2:
        # A Gaussian principal membership with Gaussian secondary grades.
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


@scalar
def _both(norm, a, b):
    """Combine two grades by the t-norm of a code, see ``fuzzy2.systems.table.NORMS``."""
    least, most = min(a, b), max(a, b)
    if norm == 0:
        return least
    if norm == 1:
        return a * b
    if norm == 2:
        # a + b - 1 would lose a tiny grade beside 1 by rounding.
        return least if most == 1.0 else max(a + b - 1.0, 0.0)
    if norm == 3:
        return 0.0 if most < 1.0 else least
    if norm == 4:
        return 0.0 if least <= 1.0 - most else least
    if norm == 5:
        united = most + least * (1.0 - most)
        # The product of two tiny grades underflows, but the result is at least half of the smaller
        # one.
        return least * (most / united) if united > 0.0 else 0.0
    return a * b / (1.0 + (1.0 - a) * (1.0 - b))


@scalar
def _either(norm, a, b):
    """Combine two grades by the t-conorm of a code, which is dual to the t-norm of ``_both``."""
    least, most = min(a, b), max(a, b)
    if norm == 0:
        return most
    if norm == 1:
        return most + least * (1.0 - most)
    if norm == 2:
        return min(a + b, 1.0)
    if norm == 3:
        return 1.0 if least > 0.0 else most
    if norm == 4:
        return 1.0 if least >= 1.0 - most else most
    if most == 1.0:
        return 1.0
    if norm == 5:
        return most + least * (1.0 - most) ** 2 / (1.0 - least * most)
    return most + least * (1.0 - most) * (1.0 + most) / (1.0 + least * most)


@scalar
def _hedged(code, number, grade):
    """Return a hedged grade; the codes of hedges are those of ``fuzzy2.systems.antecedents``."""
    if code == -5:
        return grade**number
    if code == -8:
        rest = 1.0 - grade
        return 2.0 * (grade * grade) if grade <= 0.5 else 1.0 - 2.0 * (rest * rest)
    if code == -9:
        if grade <= 0.5:
            return math.sqrt(0.5 * grade)
        return 1.0 - math.sqrt(0.5 * (1.0 - grade))
    return number * grade


@scalar
def _fire(table, x, xo, width, grades, low, high, stack):
    """Write lower and upper firing strengths of all rules for the input that starts at ``xo``.

    ``stack`` is scratch space for two numbers at each level of the deepest tree.
    """
    if table[6] > 0.0:
        _fire_by_exponents(table, x, xo, low, high)
        return
    inputs, terms, rules, norm = int(table[0]), int(table[1]), int(table[2]), int(table[4])
    uncertain = False
    for t in range(terms):
        o = HEADER + TERM * t
        grades[2 * t], grades[2 * t + 1] = _grades(table, o, x[xo + int(table[o])], width)
        uncertain = uncertain or grades[2 * t] != grades[2 * t + 1]
    o = HEADER + TERM * terms
    # If both ends of all grades are equal, so are the ends of the firing strengths.
    for r in range(0 if uncertain else rules):
        both = 1.0
        for _ in range(inputs):
            t = int(table[o])
            o += 1
            if t < 0:
                continue
            if norm == 1:
                both *= grades[2 * t]
            else:
                both = _both(norm, both, grades[2 * t])
        low[r] = high[r] = both
    for r in range(rules if uncertain else 0):
        lower, upper = 1.0, 1.0
        for _ in range(inputs):
            t = int(table[o])
            o += 1
            if t < 0:
                continue
            if norm == 1:
                lower *= grades[2 * t]
                upper *= grades[2 * t + 1]
            else:
                lower = _both(norm, lower, grades[2 * t])
                upper = _both(norm, upper, grades[2 * t + 1])
        # The two ends are rounded differently, which must not swap them.
        low[r], high[r] = min(lower, upper), upper
    if table[5] > 0.0:
        _supplement_firing(table, grades, low, high, stack)


@scalar
def _away(value, m1, m2, sigma):
    """Return the squared distance to the nearest possible mean of a Gaussian."""
    away = (value - max(min(value, m2), m1)) / sigma
    return away * away


@scalar
def _farther(value, m1, m2, sigma):
    """Return the squared distance from the farther mean."""
    away = (value - (m2 if value < 0.5 * (m1 + m2) else m1)) / sigma
    return away * away


@scalar
def _fire_by_exponents(table, x, xo, low, high):
    """Do as ``_fire`` for rules without trees whose terms are Gaussians under the product.

    The exponents of a product add up. That takes one exponential for each end of a rule instead of
    one for each term, which is faster if rules hardly share terms. ``table[6]`` is 1 if all terms
    are type-1, so that both ends are equal, and 2 otherwise.
    """
    inputs, rules, certain = int(table[0]), int(table[2]), table[6] == 1.0
    o = HEADER + TERM * int(table[1])
    for r in range(rules):
        nearer, farther, least, greatest = 0.0, 0.0, 1.0, 1.0
        for _ in range(inputs):
            t = HEADER + TERM * int(table[o])
            o += 1
            if t < HEADER:
                continue
            value, m1, m2 = x[xo + int(table[t])], table[t + 2], table[t + 3]
            nearer += _away(value, m1, m2, table[t + 5])
            greatest *= table[t + 7]
            if not certain:
                farther += _farther(value, m1, m2, table[t + 4])
                least *= table[t + 6]
        low[r] = high[r] = greatest * math.exp(-0.5 * nearer)
        if not certain:
            low[r] = min(least * math.exp(-0.5 * farther), high[r])


@compiled
def _fire_lanes_by_exponents(table, x, start, low, high):
    """Do as ``_fire_by_exponents``, bit for bit, for LANES rows from ``start`` on, side by side."""
    inputs, rules, certain = int(table[0]), int(table[2]), table[6] == 1.0
    lanes = low.shape[1]
    o = HEADER + TERM * int(table[1])
    for r in range(rules):
        nearer, farther, least, greatest = high[r], low[r], 1.0, 1.0
        for lane in range(lanes):
            nearer[lane] = farther[lane] = 0.0
        for _ in range(inputs):
            t = HEADER + TERM * int(table[o])
            o += 1
            if t < HEADER:
                continue
            first, m1, m2 = start * inputs + int(table[t]), table[t + 2], table[t + 3]
            sigma = table[t + 5]
            greatest *= table[t + 7]
            for lane in range(lanes):
                nearer[lane] += _away(x[first + lane * inputs], m1, m2, sigma)
            if not certain:
                sigma = table[t + 4]
                least *= table[t + 6]
                for lane in range(lanes):
                    farther[lane] += _farther(x[first + lane * inputs], m1, m2, sigma)
        for lane in range(lanes):
            nearer[lane] = greatest * math.exp(-0.5 * nearer[lane])
        for lane in range(lanes):
            if certain:
                farther[lane] = nearer[lane]
            else:
                farther[lane] = min(least * math.exp(-0.5 * farther[lane]), nearer[lane])


@compiled
def _grade_lanes(table, x, start, width, grades):
    """Write the grades (2 T, lanes) of rows from ``start`` on, side by side.

    Return whether lower and upper grades may differ.
    """
    inputs, terms = int(table[0]), int(table[1])
    lanes = grades.shape[1]
    uncertain = False
    for t in range(terms):
        o = HEADER + TERM * t
        first = start * inputs + int(table[o])
        mean, sigma, height = table[o + 2], table[o + 5], table[o + 7]
        certain = mean == table[o + 3] and sigma == table[o + 4] and height == table[o + 6]
        if table[o + 1] == 0.0 and certain:
            # The Gaussian of ``_grades`` without its branches, which processors cannot predict.
            for lane in range(lanes):
                away = (x[first + lane * inputs] - mean) / sigma
                grade = height * math.exp(-0.5 * away * away)
                grades[2 * t, lane] = grades[2 * t + 1, lane] = grade
            continue
        for lane in range(lanes):
            lower, upper = _grades(table, o, x[first + lane * inputs], width)
            grades[2 * t, lane], grades[2 * t + 1, lane] = lower, upper
            uncertain = uncertain or lower != upper
    return uncertain


@compiled
def _fire_lanes(table, grades, end, firing):
    """Write the lower (0) or upper (1) firing strengths (R, lanes) of rules without trees.

    They equal those of ``_fire`` bit for bit.
    """
    inputs, rules, norm = int(table[0]), int(table[2]), int(table[4])
    lanes = grades.shape[1]
    o = HEADER + TERM * int(table[1])
    for r in range(rules):
        combined = firing[r]
        for lane in range(lanes):
            combined[lane] = 1.0
        for _ in range(inputs):
            t = int(table[o])
            o += 1
            if t < 0:
                continue
            own = grades[2 * t + end]
            if norm == 0:
                for lane in range(lanes):
                    combined[lane] = min(combined[lane], own[lane])
            elif norm == 1:
                for lane in range(lanes):
                    combined[lane] *= own[lane]
            else:
                for lane in range(lanes):
                    combined[lane] = _both(norm, combined[lane], own[lane])


@scalar
def _supplement_firing(table, grades, low, high, stack):
    """Fire the rules that are trees, and multiply the firing strengths by the rules' weights."""
    rules, outputs, norm = int(table[2]), int(table[3]), int(table[4])
    start = int(table[5])
    conorm, trees, deepest = int(table[start]), table[start + 1] > 0.0, int(table[start + 3])
    weights = start + SUPPLEMENT
    places = weights + rules + rules * outputs + outputs
    if trees:
        lower, upper = stack[:deepest], stack[deepest : 2 * deepest]
        for r in range(rules):
            top = -1
            step, end = int(table[places + r]), int(table[places + r + 1])
            while step < end:
                code = int(table[step])
                step += 1
                if code >= -1:
                    top += 1
                    lower[top] = 1.0 if code < 0 else grades[2 * code]
                    upper[top] = 1.0 if code < 0 else grades[2 * code + 1]
                elif code == -2 or code == -6:
                    top -= 1
                    chosen = norm if code == -2 else conorm
                    lower[top] = _both(chosen, lower[top], lower[top + 1])
                    upper[top] = _both(chosen, upper[top], upper[top + 1])
                elif code == -3 or code == -7:
                    top -= 1
                    chosen = conorm if code == -3 else norm
                    lower[top] = _either(chosen, lower[top], lower[top + 1])
                    upper[top] = _either(chosen, upper[top], upper[top + 1])
                elif code == -4:
                    lower[top], upper[top] = 1.0 - upper[top], 1.0 - lower[top]
                else:
                    number = table[step]
                    step += 1
                    lower[top] = _hedged(code, number, lower[top])
                    upper[top] = _hedged(code, number, upper[top])
            # The two ends are rounded differently, which must not swap them.
            low[r], high[r] = min(lower[0], upper[0]), upper[0]
    for r in range(rules):
        low[r] *= table[weights + r]
        high[r] *= table[weights + r]


@compiled
def _fire_block(table, x, start, width, grades, one_low, one_high, low, high):
    """Write the firing strengths (R, lanes) of rows from ``start`` on, side by side.

    They equal those of ``_fire`` bit for bit. Return whether lower and upper strengths may differ;
    if not, only the lower ones are written.
    """
    rules, lanes = low.shape
    if table[5] > 0.0:
        one_grades = np.empty(grades.shape[0])
        stack = np.empty(2 * int(table[int(table[5]) + 3]))
        for lane in range(lanes):
            first = (start + lane) * int(table[0])
            _fire(table, x, first, width, one_grades, one_low, one_high, stack)
            for r in range(rules):
                low[r, lane], high[r, lane] = one_low[r], one_high[r]
        return True
    if table[6] > 0.0:
        _fire_lanes_by_exponents(table, x, start, low, high)
        return table[6] > 1.0
    if not _grade_lanes(table, x, start, width, grades):
        _fire_lanes(table, grades, 0, low)
        return False
    _fire_lanes(table, grades, 0, low)
    _fire_lanes(table, grades, 1, high)
    for r in range(rules):
        lower, upper = low[r], high[r]
        for lane in range(lanes):
            lower[lane] = min(lower[lane], upper[lane])
    return True


# Firing strengths below this threshold have lost digits to underflow, or are 0.
VANISHED = 1e-280
