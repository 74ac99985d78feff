"""Compiled loops of the Gaussian corollary, which :mod:`fuzzy2.systems.general_type2` calls."""

from __future__ import annotations

import math

import numpy as np

from fuzzy2.support.checks import Array
from fuzzy2.support.compiled import compiled, scalar
from fuzzy2.systems.firing_kernels import HEADER, TERM, _grades
from fuzzy2.systems.kernels import rooms, work_size


@scalar
def corollary_in(
    table: Array,
    x: Array,
    xo: int,
    middles: Array,
    spreads: Array,
    product_grades: bool,
    work: Array,
    out: Array,
    oo: int,
) -> None:
    """Do as ``evaluate_corollary`` for the finite row at ``xo``; write the outputs from ``oo`` on.

    ``work`` is scratch space as in ``evaluate_in``.
    """
    inputs, terms, rules, outputs = int(table[0]), int(table[1]), int(table[2]), int(table[3])
    grades, mean, sigma, _, _, _, _ = rooms(table, work)
    for t in range(terms):
        o = HEADER + TERM * t
        grades[2 * t] = _grades(table, o, x[xo + int(table[o])], 0.0)[0]
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
        if not total > 0.0:
            out[oo + 2 * j] = out[oo + 2 * j + 1] = math.nan
            continue
        moment = 0.0
        for r in range(rules):
            moment += mean[r] * (middles[r * outputs + j] - middles[j])
        center = middles[j] + moment / total
        spread = 0.0
        for r in range(rules):
            q = r * outputs + j
            one, two = mean[r] * spreads[q], (middles[q] - center) * sigma[r]
            spread += one * one + two * two if product_grades else one + abs(two)
        out[oo + 2 * j] = center
        out[oo + 2 * j + 1] = (math.sqrt(spread) if product_grades else spread) / total


@compiled
def evaluate_corollary(
    table: Array, x: Array, middles: Array, spreads: Array, product_grades: bool, out: Array
) -> int:
    """Write mean and standard deviation (rows, m, 2) by the Gaussian corollary (eq. 1.107, 1.108).

    The return value is that of ``evaluate``.

    ``middles`` and ``spreads`` (R m,) are means and standard deviations of the consequents; firing
    strengths are Gaussian numbers with the moments of eq. 1.30.
    """
    inputs, outputs = int(table[0]), int(table[3])
    work = np.empty(work_size(table))
    for row in range(x.size // inputs):
        for i in range(inputs):
            if not math.isfinite(x[row * inputs + i]):
                return row
        place = 2 * outputs * row
        corollary_in(table, x, row * inputs, middles, spreads, product_grades, work, out, place)
    return -1
