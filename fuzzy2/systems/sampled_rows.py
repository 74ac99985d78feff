"""Compiled loops from inputs to outputs of united sets that are sampled on a grid.

The loops only use the grades of the sets on the grid of their output, so they serve any sets.
:mod:`fuzzy2.systems.outputs` calls them.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fuzzy2.support.checks import Array
from fuzzy2.support.compiled import compiled, scalar
from fuzzy2.systems.crisp_unions import (
    BISECTOR,
    CENTROID,
    LARGEST,
    MEAN,
    MIDDLE,
    MIDDLE_OF_AREA,
    SAME,
    SMALLEST,
    SMALLEST_ABSOLUTE,
)
from fuzzy2.systems.firing_kernels import _both, _either, _fire
from fuzzy2.systems.kernels import rooms, work_size
from fuzzy2.systems.log_firing_kernels import log_fire, lost
from fuzzy2.systems.output_kernels import EXACT, SUMMED, WU_MENDEL, _mean, reduced_by
from fuzzy2.systems.union_rows import _as_floats, _most

CERTAIN = 4
"""Code of the centroid of unions that have a single membership function."""


class Sampled(NamedTuple):
    """The output sets of a system as grades on a grid.

    Parameters
    ----------
    table : (k,) ndarray
        Table of the firing, see :mod:`fuzzy2.systems.kernels`.
    points : ndarray
        Ascending points, output by output.
    first_point : (m + 1,) ndarray of int
        Place where each output begins.
    grades : ndarray
        Grades of the sets of each output at its points, set by set: first of the lower and then of
        the upper membership function. Type-1 sets have one row of grades.
    first_grade : (m + 1,) ndarray of int
        Place where each output begins.
    set_of : (m, R) ndarray of int
        Number, among the sets of the output, of the set that a rule fires; -1 if it has no
        consequent for the output.
    defaults : (m,) ndarray
        Outputs where no rule fires; NaN for none.
    codes : (7,) ndarray of int
        Implication, aggregation, whether only ratios of the firing matter, whether all sets are
        type-1, which quantity of the union is computed, method of the centroid, and whether the
        ends of the grid have half weight.
    of_averages : (2,) ndarray
        Weights of the lower and the upper centroid in the Begian-Melek-Mendel method.
    """

    table: Array
    points: Array
    first_point: NDArray[np.int64]
    grades: Array
    first_grade: NDArray[np.int64]
    set_of: NDArray[np.int64]
    defaults: Array
    codes: NDArray[np.int64]
    of_averages: Array


@scalar
def sampled_room_size(system: Sampled) -> int:
    """Return the size of the scratch space of ``sample_in`` besides ``work_size``."""
    asked, way = system.codes[4], system.codes[5]
    arrays = 1
    if asked == CENTROID:
        arrays = 5 if way == EXACT else 2 if way == CERTAIN else 3
    return int(4 * int(system.table[2]) + arrays * _most(system.first_point))


@scalar
def _grade_at(system, j, i, end, weights):
    """Return the grade of the lower or upper union of an output at its point i."""
    rules = int(system.table[2])
    count = system.first_point[j + 1] - system.first_point[j]
    certain = system.codes[3] == 1
    start = system.first_grade[j] + i + (0 if certain or end == 0 else count)
    united = 0.0
    for r in range(rules):
        weight = weights[2 * r + end]
        # A rule that does not fire adds nothing, whatever the t-norm and the t-conorm.
        if weight > 0.0:
            k = system.set_of[j * rules + r]
            grade = system.grades[start + (count if certain else 2 * count) * k]
            clipped = _both(system.codes[0], weight, grade)
            if system.codes[1] == SUMMED:
                united += clipped
            else:
                united = _either(system.codes[1], united, clipped)
    return united


@scalar
def _weights_of(system, j, fired, in_logarithms, weights, falling):
    """Write the lower and upper weight of each rule for an output, 0 if it has no consequent."""
    rules = int(system.table[2])
    for r in range(rules):
        speaks = system.set_of[j * rules + r] >= 0
        none = -math.inf if in_logarithms else 0.0
        weights[2 * r] = fired[r] if speaks else none
        weights[2 * r + 1] = fired[rules + r] if speaks else none
    if in_logarithms:
        _as_floats(weights, falling)


@scalar
def _centroid_in(system, j, weights, points, low, high, below, above, out, o):
    """Write the ends of the centroid of a union."""
    way, first = system.codes[5], system.first_point[j]
    size = system.first_point[j + 1] - first
    count = 0
    for i in range(size):
        upper = _grade_at(system, j, i, 1, weights)
        if upper > 0.0:
            lower = upper if way == CERTAIN else _grade_at(system, j, i, 0, weights)
            if system.codes[6] == 1 and (i == 0 or i == size - 1):
                lower, upper = 0.5 * lower, 0.5 * upper
            points[count] = system.points[first + i]
            low[count], high[count] = min(lower, upper), upper
            count += 1
    if count == 0:
        return
    if way == CERTAIN:
        out[o] = out[o + 1] = _mean(points[:count], high[:count], False)
        return
    for end in range(2 if way in (EXACT, WU_MENDEL) else 1):
        out[o + end] = reduced_by(
            way,
            system.of_averages,
            end,
            points[:count],
            low[:count],
            high[:count],
            False,
            below,
            above,
        )
    if way not in (EXACT, WU_MENDEL):
        out[o + 1] = out[o]
    elif out[o] > out[o + 1]:
        out[o], out[o + 1] = out[o + 1], out[o]


@scalar
def _bisector(points, grades):
    """Return the median of points weighted with their grades, at least one of which is not 0."""
    greatest, total = 0.0, 0.0
    for i in range(grades.size):
        greatest = max(greatest, grades[i])
    for i in range(grades.size):
        total += grades[i] / greatest
    # The first point with half of the weight up to it, and the first with more than half. If they
    # differ, the result is midway between them.
    low, high, running = -1, -1, 0.0
    for i in range(grades.size):
        running += grades[i] / greatest
        if low < 0 and running / total >= 0.5 - SAME:
            low = i
        if high < 0 and running / total >= 0.5 + SAME:
            high = i
    return 0.5 * (points[max(low, 0)] + points[max(high, 0)])


@scalar
def _middle_of_area(points, grades):
    """Return the mean of the points where the running sum of grades is nearest to half."""
    total = 0.0
    for i in range(grades.size):
        total += grades[i]
    least, running, moment, count = math.inf, 0.0, 0.0, 0
    for i in range(grades.size):
        running += grades[i]
        off = abs(running / total - 0.5)
        if off < least:
            least, moment, count = off, 0.0, 0
        if off == least:
            moment += points[i]
            count += 1
    return moment / count


@scalar
def _maximum(asked, points, grades):
    """Return a point of greatest grade, which is not 0; see ``operators.MAXIMA``."""
    greatest = 0.0
    for i in range(grades.size):
        greatest = max(greatest, grades[i])
    first, last, near, far, moment, count = -1, 0, 0, 0, 0.0, 0
    for i in range(grades.size):
        if grades[i] >= greatest * (1.0 - SAME):
            if first < 0:
                first = near = far = i
            last = i
            near = i if abs(points[i]) < abs(points[near]) else near
            far = i if abs(points[i]) > abs(points[far]) else far
            moment += points[i]
            count += 1
    if asked == SMALLEST:
        return points[first]
    if asked == LARGEST:
        return points[last]
    if asked == MIDDLE:
        return 0.5 * points[first] + 0.5 * points[last]
    if asked == MEAN:
        return moment / count
    return points[near] if asked == SMALLEST_ABSOLUTE else points[far]


@scalar
def sample_in(
    system: Sampled, x: Array, xo: int, work: Array, room: Array, out: Array, oo: int
) -> None:
    """Write the type-reduced intervals (m, 2) of the finite row at ``xo`` from ``oo`` on.

    ``work`` (``work_size``,) and ``room`` (``sampled_room_size``,) are scratch space.
    """
    rules, outputs, asked = int(system.table[2]), int(system.table[3]), system.codes[4]
    grades, fired_low, fired_high, _, _, _, stack = rooms(system.table, work)
    _fire(system.table, x, xo, 0.0, grades, fired_low, fired_high, stack)
    fired = work[grades.size : grades.size + 2 * rules]
    in_logarithms = system.codes[2] == 1 and lost(system.table, fired_low, fired_high)
    if in_logarithms:
        log_fire(system.table, x, xo, 0.0, grades, fired_low, fired_high, stack)
    weights, falling = room[: 2 * rules], room[2 * rules : 4 * rules]
    arrays, most = room[4 * rules :], _most(system.first_point)
    for j in range(outputs):
        place, first = oo + 2 * j, system.first_point[j]
        size = system.first_point[j + 1] - first
        out[place] = out[place + 1] = math.nan
        if size > 0:
            _weights_of(system, j, fired, in_logarithms, weights, falling)
            if asked == CENTROID:
                # Scratch arrays that the method does not need overlap with others.
                low = most if system.codes[5] == CERTAIN else 2 * most
                below = 3 * most if system.codes[5] == EXACT else 0
                above = 4 * most if system.codes[5] == EXACT else 0
                _centroid_in(
                    system,
                    j,
                    weights,
                    arrays[:most],
                    arrays[low : low + most],
                    arrays[most : 2 * most],
                    arrays[below : below + most],
                    arrays[above : above + most],
                    out,
                    place,
                )
            else:
                greatest = 0.0
                for i in range(size):
                    arrays[i] = _grade_at(system, j, i, 1, weights)
                    greatest = max(greatest, arrays[i])
                points = system.points[first : first + size]
                if greatest > 0.0 and asked == BISECTOR:
                    out[place] = _bisector(points, arrays[:size])
                elif greatest > 0.0 and asked == MIDDLE_OF_AREA:
                    out[place] = _middle_of_area(points, arrays[:size])
                elif greatest > 0.0:
                    out[place] = _maximum(asked, points, arrays[:size])
                out[place + 1] = out[place]
        for end in range(2):
            if math.isnan(out[place + end]):
                out[place + end] = system.defaults[j]


@compiled
def samples(system: Sampled, x: Array, out: Array) -> None:
    """Write the type-reduced intervals (rows, m, 2) of finite flat inputs."""
    inputs, outputs = int(system.table[0]), int(system.table[3])
    work, room = np.empty(work_size(system.table)), np.empty(sampled_room_size(system))
    for row in range(x.size // inputs):
        sample_in(system, x, row * inputs, work, room, out, 2 * outputs * row)
