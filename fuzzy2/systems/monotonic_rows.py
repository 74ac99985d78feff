"""Compiled loops of Tsukamoto's averages, which :mod:`fuzzy2.systems.outputs` calls."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fuzzy2.support.checks import Array
from fuzzy2.support.compiled import compiled, scalar
from fuzzy2.systems.firing_kernels import HEADER, TERM, _fire, _grades
from fuzzy2.systems.kernels import rooms, work_size
from fuzzy2.systems.output_kernels import _mean
from fuzzy2.systems.shape_kernels import SIGMOID

HALVINGS = 100


class Monotonics(NamedTuple):
    """Monotonic consequents; each contributes the point where its grade is the firing.

    Parameters
    ----------
    table : (k,) ndarray
        Table of the firing, see :mod:`fuzzy2.systems.kernels`.
    sets : ndarray
        A table of the sets, see :class:`fuzzy2.systems.term_rows.TermRows`.
    set_of : (m, R) ndarray of int
        Number of the set that a rule fires; -1 if it has no consequent for the output.
    is_rising : (m, R) ndarray of int
        1 for a rising set, 0 for a falling one.
    ends : (m, 2) ndarray
        Ends of the outputs, between which points are searched.
    defaults : (m,) ndarray
        Outputs where no rule fires; NaN for none.
    is_bounded : int
        1 if points are limited to the ends, 0 if a point at an end counts as infinite.
    """

    table: Array
    sets: Array
    set_of: NDArray[np.int64]
    is_rising: NDArray[np.int64]
    ends: Array
    defaults: Array
    is_bounded: int


@scalar
def _point_of(system, q, left, right, grade):
    """Return where a set has a grade above 0; q counts rules and outputs together."""
    o = HEADER + TERM * system.set_of[q]
    if int(system.sets[o + 1]) == SIGMOID:
        # Near 1 only the formula resolves grades.
        point = system.sets[o + 2] - math.log((1.0 - grade) / grade) / system.sets[o + 3]
        return min(max(point, left), right) if system.is_bounded == 1 else point
    rising = system.is_rising[q] == 1
    low, high = left, right
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        _, own = _grades(system.sets, o, middle, 0.0)
        if (own < grade) == rising:
            low = middle
        else:
            high = middle
    if system.is_bounded == 0:
        # A grade that is approached but never reached, such as 1 for a sigmoid, is at infinity.
        if low == left:
            return -math.inf
        if high == right:
            return math.inf
    return 0.5 * (low + high)


@scalar
def points_in(system: Monotonics, x: Array, xo: int, work: Array, out: Array, oo: int) -> None:
    """Write the outputs (m,) of the finite row at ``xo`` from ``oo`` on.

    ``work`` (``work_size``,) is scratch space.
    """
    rules, outputs = int(system.table[2]), int(system.table[3])
    grades, low, high, _, _, room, stack = rooms(system.table, work)
    _fire(system.table, x, xo, 0.0, grades, low, high, stack)
    points, weights = room[:rules], room[rules : 2 * rules]
    for j in range(outputs):
        count, beyond = 0, 0.0
        for r in range(rules):
            if system.set_of[j * rules + r] >= 0 and high[r] > 0.0:
                point = _point_of(
                    system, j * rules + r, system.ends[2 * j], system.ends[2 * j + 1], high[r]
                )
                # An average with one infinity is infinite; with both infinities it is NaN.
                if not math.isfinite(point):
                    beyond += point
                    point = 0.0
                points[count], weights[count] = point, high[r]
                count += 1
        out[oo + j] = math.nan
        if count > 0:
            out[oo + j] = _mean(points[:count], weights[:count], False) + beyond
        if math.isnan(out[oo + j]):
            out[oo + j] = system.defaults[j]


@compiled
def monotonic_points(system: Monotonics, x: Array, out: Array) -> None:
    """Write the outputs (rows, m) of finite flat inputs."""
    inputs, outputs = int(system.table[0]), int(system.table[3])
    work = np.empty(work_size(system.table))
    for row in range(x.size // inputs):
        points_in(system, x, row * inputs, work, out, outputs * row)
