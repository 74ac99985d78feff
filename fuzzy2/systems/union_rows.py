"""Compiled loops from inputs to centroids of united sets, with one union for each output.

:mod:`fuzzy2.systems.united_kernels` integrates the unions, and :mod:`fuzzy2.systems.outputs` calls
these loops.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fuzzy2.reduction.logarithms import DEEPEST, STEP
from fuzzy2.support.checks import Array
from fuzzy2.support.compiled import compiled, scalar
from fuzzy2.systems.crisp_unions import BISECTOR, CENTROID, bisector_of_union, maximum_of_union
from fuzzy2.systems.firing_kernels import TERM, _fire
from fuzzy2.systems.kernels import rooms, work_size
from fuzzy2.systems.log_firing_kernels import log_fire, lost
from fuzzy2.systems.shape_kernels import PAIR
from fuzzy2.systems.united_kernels import (
    ROOM,
    USUAL_PIECES,
    _nodes_of,
    _pieces_of,
    centroid_of_union,
)

EXACT, NIE_TAN, BEGIAN_MELEK_MENDEL = 0, 1, 3


class Unions(NamedTuple):
    """The output sets of a system, for unions that are integrated.

    Parameters
    ----------
    table : (k,) ndarray
        Table of the firing, see :mod:`fuzzy2.systems.kernels`.
    rows : ndarray
        Two rows of TERM numbers for each set, output by output.
    first_set : (m + 1,) ndarray of int
        Place where the sets of each output begin.
    kinks : ndarray
        Ascending points between which the sets of an output are smooth, output by output.
    first_kink : (m + 1,) ndarray of int
        Place where the kinks of each output begin.
    set_of : (m, R) ndarray of int
        Number, among the sets of the output, of the set that a rule fires; -1 if it has no
        consequent for the output.
    defaults : (m,) ndarray
        Outputs where no rule fires; NaN for none.
    codes : (6,) ndarray of int
        Whether firing and set are multiplied, whether sets are added up, whether only ratios of the
        firing matter, whether all sets are type-1, method of the centroid, and code of the quantity
        that is computed, see :mod:`fuzzy2.systems.crisp_unions`.
    of_averages : (2,) ndarray
        Weights of the lower and the upper centroid in the Begian-Melek-Mendel method.
    gauss : (2 n,) ndarray
        Nodes and weights of the quadrature rule on [-1, 1].
    tolerance : float
        Share of the area by which two quadrature rules may differ.
    """

    table: Array
    rows: Array
    first_set: NDArray[np.int64]
    kinks: Array
    first_kink: NDArray[np.int64]
    set_of: NDArray[np.int64]
    defaults: Array
    codes: NDArray[np.int64]
    of_averages: Array
    gauss: Array
    tolerance: float


@scalar
def _pieces(system: Unions) -> int:
    """Return how many pieces of a union fit into memory; a type-1 union is one piece."""
    certain = system.codes[3] == 1 and system.codes[4] == EXACT and _is_type_1(system.table)
    return 1 if certain else USUAL_PIECES


@scalar
def _is_type_1(table):
    """Return whether all terms of the inputs have equal lower and upper grades."""
    for t in range(int(table[1])):
        o = 7 + TERM * t
        alike = table[o + 2] == table[o + 3] and table[o + 4] == table[o + 5]
        kind = int(table[o + 1])
        if (
            kind == 2
            or kind == PAIR
            or (kind == 0 and not (alike and table[o + 6] == table[o + 7]))
        ):
            return False
    return True


@scalar
def _most(first):
    """Return the greatest distance between two neighbors."""
    most = 0
    for j in range(first.size - 1):
        most = max(most, first[j + 1] - first[j])
    return most


@scalar
def room_size(system: Unions) -> int:
    """Return the size of the scratch space of ``unite_in`` besides ``work_size``."""
    sets, rules = _most(system.first_set), int(system.table[2])
    kinks, pieces = _most(system.first_kink), _pieces(system)
    return int(ROOM + 4 * rules + 6 * sets + kinks + 6 * pieces)


@scalar
def _as_floats(logarithms, falling):
    """Convert logarithms to weights, see :func:`fuzzy2.reduction.logarithms.as_floats`.

    ``falling`` is scratch space of the same size.
    """
    for i in range(logarithms.size):
        k = i
        while k > 0 and falling[k - 1] < logarithms[i]:
            falling[k] = falling[k - 1]
            k -= 1
        falling[k] = logarithms[i]
    for i in range(logarithms.size):
        own, depth, k = logarithms[i], 0.0, 0
        # Gaps between logarithms that exceed the precision of floats are narrowed.
        while k + 1 < falling.size and falling[k] > own:
            depth += min(falling[k] - falling[k + 1], STEP)
            k += 1
        logarithms[i] = math.exp(-depth) if own > -math.inf and depth <= DEEPEST else 0.0


@scalar
def _set_weights(system, j, fired, in_logarithms, firing, falling, weights):
    """Write the greatest lower and upper firing of each set of an output; return the greatest."""
    rules = int(system.table[2])
    sets = weights.size // 2
    count = 0
    for r in range(rules):
        if system.set_of[j * rules + r] >= 0:
            firing[2 * count], firing[2 * count + 1] = fired[r], fired[rules + r]
            count += 1
    if in_logarithms:
        _as_floats(firing[: 2 * count], falling[: 2 * count])
    for k in range(2 * sets):
        weights[k] = 0.0
    highest, count = 0.0, 0
    for r in range(rules):
        k = system.set_of[j * rules + r]
        if k >= 0:
            for end in range(2):
                weights[end * sets + k] = max(weights[end * sets + k], firing[2 * count + end])
            highest = max(highest, firing[2 * count + 1])
            count += 1
    return highest


@scalar
def _directly(system, sums, pieces, origin):
    """Return the centroid of the memberships' mean, or the mean of their centroids."""
    low, low_moment, high, high_moment = 0.0, 0.0, 0.0, 0.0
    for p in range(pieces):
        low += sums[4 * p]
        low_moment += sums[4 * p + 1]
        high += sums[4 * p + 2]
        high_moment += sums[4 * p + 3]
    if not high > 0.0:
        return math.nan
    if system.codes[4] == NIE_TAN:
        return origin + (low_moment + high_moment) / (low + high)
    upper = origin + high_moment / high
    lower = origin + low_moment / low if low > 0.0 else upper
    return system.of_averages[0] * lower + system.of_averages[1] * upper


@scalar
def _one_union(system, rows, kinks, weights, crisp, nodes, edges, sums, room, out, o):
    """Write the centroid of a union; return whether the memory for its pieces was sufficient."""
    sets, product, total = weights.size // 2, system.codes[0] == 1, system.codes[1] == 1
    if system.codes[5] == BISECTOR:
        out[o] = out[o + 1] = bisector_of_union(
            rows, weights, sets, product, total, kinks, system.gauss, system.tolerance,
            nodes, edges, sums, room,
        )  # fmt: skip
        return True
    if system.codes[5] != CENTROID:
        out[o] = out[o + 1] = maximum_of_union(
            system.codes[5], rows, weights, sets, product, kinks, nodes
        )
        return True
    if system.codes[4] == EXACT:
        return centroid_of_union(
            rows, weights, sets, product, total, crisp, kinks, system.gauss, system.tolerance,
            nodes, edges, sums, room, out, o,
        )  # fmt: skip
    origin = 0.5 * kinks[0] + 0.5 * kinks[kinks.size - 1]
    count = _nodes_of(rows, weights, sets, product, crisp, kinks, nodes)
    pieces = _pieces_of(
        rows, weights, sets, product, total, crisp, system.gauss,
        nodes, count, origin, system.tolerance, edges, sums, room,
    )  # fmt: skip
    if pieces >= 0:
        out[o] = out[o + 1] = _directly(system, sums, pieces, origin)
    return pieces >= 0


@scalar
def unite_in(
    system: Unions, x: Array, xo: int, work: Array, room: Array, out: Array, oo: int
) -> bool:
    """Write the type-reduced intervals (m, 2) of the finite row at ``xo`` from ``oo`` on.

    ``work`` (``work_size``,) and ``room`` (``room_size``,) are scratch space. Return whether it was
    sufficient for all pieces.
    """
    rules, outputs, most = int(system.table[2]), int(system.table[3]), _pieces(system)
    grades, low, high, _, _, _, stack = rooms(system.table, work)
    _fire(system.table, x, xo, 0.0, grades, low, high, stack)
    fired = work[grades.size : grades.size + 2 * rules]
    in_logarithms = system.codes[2] == 1 and lost(system.table, low, high)
    if in_logarithms:
        log_fire(system.table, x, xo, 0.0, grades, low, high, stack)
    crisp = system.codes[3] == 1 and system.codes[4] == EXACT
    for r in range(rules):
        crisp = crisp and low[r] == high[r]
    o = ROOM
    firing, falling = room[o : o + 2 * rules], room[o + 2 * rules : o + 4 * rules]
    o += 4 * rules
    edges, sums = room[o : o + 2 * most], room[o + 2 * most : o + 6 * most]
    o += 6 * most
    for j in range(outputs):
        sets = system.first_set[j + 1] - system.first_set[j]
        place = oo + 2 * j
        out[place] = out[place + 1] = math.nan
        if sets > 0:
            weights = room[o : o + 2 * sets]
            highest = _set_weights(system, j, fired, in_logarithms, firing, falling, weights)
            if highest > 0.0:
                done = _one_union(
                    system,
                    system.rows[
                        2 * TERM * system.first_set[j] : 2 * TERM * system.first_set[j + 1]
                    ],
                    system.kinks[system.first_kink[j] : system.first_kink[j + 1]],
                    weights,
                    crisp,
                    room[o + 2 * sets :],
                    edges,
                    sums,
                    room,
                    out,
                    place,
                )
                if not done:
                    return False
        for end in range(2):
            if math.isnan(out[place + end]):
                out[place + end] = system.defaults[j]
    return True


@compiled
def unions(system: Unions, x: Array, out: Array, refused: NDArray[np.bool_]) -> int:
    """Write the type-reduced intervals (rows, m, 2) of finite flat inputs.

    Return the number of rows for which a union needs more pieces than fit into memory; ``refused``
    (rows,) marks them.
    """
    inputs, outputs = int(system.table[0]), int(system.table[3])
    work, room = np.empty(work_size(system.table)), np.empty(room_size(system))
    count = 0
    for row in range(x.size // inputs):
        done = unite_in(system, x, row * inputs, work, room, out, 2 * outputs * row)
        refused[row] = not done
        count += 0 if done else 1
    return count
