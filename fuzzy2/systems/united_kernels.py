"""Compiled loops that integrate unions of output sets, which :mod:`fuzzy2.systems.united` calls.

Each set has two rows, one for the lower and one for the upper membership function. They are laid
out like the terms of a system's table (``fuzzy2.systems.kernels``): the number of an input, which
is ignored, then the result of ``kernel_row()``.
"""

from __future__ import annotations

import math

import numpy as np

from fuzzy2.support.checks import Array
from fuzzy2.support.compiled import compiled, scalar
from fuzzy2.systems.firing_kernels import TERM, _grades

MOST_PIECES = 4096
USUAL_PIECES = 256
"""Number of pieces that fit into memory at first; allocating more would dominate a single call."""
STACK = 64
MOST_TURNS = 2 * MOST_PIECES
"""Greatest number of pieces that are evaluated, because halving does not make noise smoother."""
ROOM = 6 * STACK + 8
"""Size of the scratch space for integrating a union, besides its nodes and pieces."""
UNION_ROUNDING = 1e-15
"""Effect of rounding errors on a number of size 1."""
UNION_INSET = 1e-9
"""Distance from the ends of a piece at which it is evaluated and split, as a share of the piece."""


@scalar
def _one_grade(row, o, end, x):
    """Return the lower or upper grade of x in a term; both would cost two exponentials."""
    if int(row[o + 1]) != 0:
        lower, upper = _grades(row, o, x, 0.0)
        return upper if end == 1 else lower
    m1, m2 = row[o + 2], row[o + 3]
    if end == 1 or (m1 == m2 and row[o + 4] == row[o + 5] and row[o + 6] == row[o + 7]):
        away = min(x - m1, 0.0) + max(x - m2, 0.0)
        sigma, height = row[o + 5], row[o + 7]
    else:
        away = x - (m2 if x < 0.5 * (m1 + m2) else m1)
        sigma, height = row[o + 4], row[o + 6]
    t = away / sigma
    return height * math.exp(-0.5 * t * t)


@scalar
def _union(rows, weights, sets, product, total, end, x):
    """Return the grade of the lower or upper union at a point, for weights (2, sets), flat."""
    united = 0.0
    for k in range(sets):
        weight = weights[end * sets + k]
        # Grades are at most 1, so under the maximum a weight that is not greater than the result
        # adds nothing.
        if weight == 0.0 or (not total and weight <= united):
            continue
        grade = _one_grade(rows, TERM * (2 * k + end), end, x)
        grade = weight * grade if product else min(weight, grade)
        united = united + grade if total else max(united, grade)
    return united


@scalar
def _rule(rows, weights, sets, product, total, crisp, nodes, left, right, origin, out, o):
    """Write areas and moments of the lower and the upper union over a piece.

    For a type-1 union both are equal.
    """
    half, middle = 0.5 * (right - left), 0.5 * (left + right)
    for i in range(4):
        out[o + i] = 0.0
    count = nodes.size // 2
    for i in range(count):
        x = middle + half * nodes[i]
        weight = half * nodes[count + i]
        upper = weight * _union(rows, weights, sets, product, total, 1, x)
        out[o + 2] += upper
        out[o + 3] += upper * (x - origin)
        if not crisp:
            lower = weight * _union(rows, weights, sets, product, total, 0, x)
            out[o] += lower
            out[o + 1] += lower * (x - origin)
    if crisp:
        out[o], out[o + 1] = out[o + 2], out[o + 3]


@scalar
def _cuts(rows, o, end, level, nodes, count):
    """Add the points where a membership function has a given grade; return the number of nodes.

    Points on other branches of the formula are added as well, which does no harm.
    """
    if not 0.0 < level < 1.0:
        return count
    if int(rows[o + 1]) == 1:
        a, b, c, d, height = rows[o + 2], rows[o + 3], rows[o + 4], rows[o + 5], rows[o + 6]
        if level < height:
            # A shoulder that never ends has no such point on that side.
            nodes[count] = a + (b - a) * level / height if b > a else b
            nodes[count + 1] = d - (d - c) * level / height if d > c else c
            return count + 2
        return count
    sigma = rows[o + 5] if end == 1 else rows[o + 4]
    height = rows[o + 7] if end == 1 else rows[o + 6]
    if level < height:
        reach = sigma * math.sqrt(2.0 * math.log(height / level))
        first, second = (rows[o + 2], rows[o + 3]) if end == 1 else (rows[o + 3], rows[o + 2])
        nodes[count], nodes[count + 1] = first - reach, second + reach
        return count + 2
    return count


@scalar
def _nodes_of(rows, weights, sets, product, crisp, kinks, nodes):
    """Write the ascending nodes of a union; return their number."""
    count = kinks.size
    for i in range(count):
        nodes[i] = kinks[i]
    if not product:
        for k in range(sets):
            for end in range(1 if crisp else 0, 2):
                o = TERM * (2 * k + end)
                count = _cuts(rows, o, end, weights[end * sets + k], nodes, count)
    first, last = kinks[0], kinks[kinks.size - 1]
    # Kinks are in ascending order; the points added after them are inserted in order.
    for i in range(count):
        node = min(max(nodes[i], first), last)
        k = i
        while k > 0 and nodes[k - 1] > node:
            nodes[k] = nodes[k - 1]
            k -= 1
        nodes[k] = node
    return count


@scalar
def _grade_of(rows, weights, sets, product, k, end, x):
    """Return the grade of a rule's output set at a point, after the implication."""
    grade = _one_grade(rows, TERM * (2 * k + end), end, x)
    weight = weights[end * sets + k]
    return weight * grade if product else min(weight, grade)


@scalar
def _highest(rows, weights, sets, product, end, x):
    """Return the number of the highest set at a point."""
    best, most = -1, 0.0
    for k in range(sets):
        grade = _grade_of(rows, weights, sets, product, k, end, x)
        if grade > most:
            best, most = k, grade
    return best


@scalar
def _split(rows, weights, sets, product, total, crisp, left, right):
    """Return where another set becomes the highest within a piece, or its left end if none does."""
    if total:
        return left
    inset = UNION_INSET * (right - left)
    for end in range(1, -1 if not crisp else 0, -1):
        a, b = left + inset, right - inset
        first = _highest(rows, weights, sets, product, end, a)
        second = _highest(rows, weights, sets, product, end, b)
        if first == second or first < 0 or second < 0:
            continue
        above = _grade_of(rows, weights, sets, product, first, end, a) - _grade_of(
            rows, weights, sets, product, second, end, a
        )
        below = _grade_of(rows, weights, sets, product, first, end, b) - _grade_of(
            rows, weights, sets, product, second, end, b
        )
        x = 0.5 * (a + b)
        # False position with half the weight for an end that does not move (Illinois method).
        for _ in range(20):
            if not above > below:
                break
            x = a + (b - a) * above / (above - below)
            gap = _grade_of(rows, weights, sets, product, first, end, x) - _grade_of(
                rows, weights, sets, product, second, end, x
            )
            if abs(gap) <= UNION_ROUNDING:
                break
            if gap > 0.0:
                a, above = x, gap
                below *= 0.5
            else:
                b, below = x, gap
                above *= 0.5
        if left + inset < x < right - inset:
            return x
    return left


@scalar
def _pieces_of(  # noqa: C901, PLR0913 (one compiled loop over pieces and their halves, for speed)
    rows,
    weights,
    sets,
    product,
    total,
    crisp,
    gauss,
    nodes,
    count,
    origin,
    tolerance,
    edges,
    sums,
    room,
):
    """Write the ascending pieces, (P, 2) and (P, 4), flat; return their number, or -1 if too many.

    For a type-1 union the result is one piece, the whole range. ``room`` (ROOM,) is scratch space
    for sums.
    """
    stack = room[: 2 * STACK]
    found = room[2 * STACK : 6 * STACK]
    one = room[6 * STACK : 6 * STACK + 8]
    reach = nodes[count - 1] - nodes[0]
    scale = 0.0
    if crisp:
        for i in range(count - 1):
            if nodes[i + 1] > nodes[i]:
                _rule(
                    rows, weights, sets, product, total, crisp, gauss,
                    nodes[i], nodes[i + 1], origin, one, 0,
                )  # fmt: skip
                scale += one[2]
    pieces, turns = 0, 0
    for i in range(4):
        sums[i] = 0.0
    for i in range(count - 1):
        if not nodes[i + 1] > nodes[i]:
            continue
        stack[0], stack[1] = nodes[i], nodes[i + 1]
        _rule(
            rows, weights, sets, product, total, crisp, gauss,
            nodes[i], nodes[i + 1], origin, found, 0,
        )  # fmt: skip
        depth = 1
        while depth > 0:
            depth -= 1
            left, right = stack[2 * depth], stack[2 * depth + 1]
            middle = left
            if right - left > UNION_INSET * reach:
                middle = _split(rows, weights, sets, product, total, crisp, left, right)
            rough = middle > left
            if not rough:
                middle = 0.5 * (left + right)
            for half in range(2):
                _rule(
                    rows, weights, sets, product, total, crisp, gauss,
                    middle if half == 1 else left, right if half == 1 else middle,
                    origin, one, 4 * half,
                )  # fmt: skip
            for end in range(2):
                for power in range(2):
                    j = 2 * end + power
                    both = one[j] + one[4 + j]
                    size = scale if crisp else one[2 * end] + one[4 + 2 * end]
                    # Points are themselves rounded, which is noticeable in narrow pieces.
                    noise = UNION_ROUNDING * max(abs(left), abs(right)) / (right - left)
                    allowed = ((tolerance + noise) * size + 1e-280) * (reach if power == 1 else 1.0)
                    rough = rough or abs(found[4 * depth + j] - both) > allowed
            turns += 1
            rough = rough and turns < MOST_TURNS
            if rough and left < middle and middle < right and depth + 2 < STACK:
                # The left half is on top of the stack, so pieces come in ascending order.
                stack[2 * depth], stack[2 * depth + 1] = middle, right
                stack[2 * depth + 2], stack[2 * depth + 3] = left, middle
                for j in range(4):
                    found[4 * depth + j] = one[4 + j]
                    found[4 * depth + 4 + j] = one[j]
                depth += 2
                continue
            if crisp:
                for j in range(4):
                    sums[j] += one[j] + one[4 + j]
                continue
            if 2 * pieces == edges.size:
                return -1
            edges[2 * pieces], edges[2 * pieces + 1] = left, right
            for j in range(4):
                sums[4 * pieces + j] = one[j] + one[4 + j]
            pieces += 1
    return 1 if crisp else pieces


@scalar
def _end_of(rows, weights, sets, product, total, gauss, edges, sums, pieces, origin, left_end, one):
    """Return the left or the right end of the centroid of an interval type-2 union, or NaN.

    The right end is the left end of the mirrored union. ``one`` (4,) is scratch space for sums.
    """
    sign = 1.0 if left_end else -1.0
    after_area, after_moment = 0.0, 0.0
    for p in range(pieces):
        after_area += sums[4 * p]
        after_moment += sign * sums[4 * p + 1]
    no_lower = after_area <= 0.0
    area, moment = 0.0, 0.0
    for q in range(pieces):
        p = q if left_end else pieces - 1 - q
        near, far = (
            (edges[2 * p], edges[2 * p + 1]) if left_end else (edges[2 * p + 1], edges[2 * p])
        )
        after_area -= sums[4 * p]
        after_moment -= sign * sums[4 * p + 1]
        before_area, before_moment = area, moment
        area += sums[4 * p + 2]
        moment += sign * sums[4 * p + 3]
        if not area > 0.0:
            continue
        if no_lower:
            return near
        x = sign * (far - origin)
        if x * area - moment + x * after_area - after_moment < 0.0 and q < pieces - 1:
            continue
        least = UNION_ROUNDING * (edges[2 * pieces - 1] - edges[0])
        c = far
        for _ in range(100):
            _rule(
                rows, weights, sets, product, total, False, gauss,
                min(near, c), max(near, c), origin, one, 0,
            )  # fmt: skip
            mass = before_area + one[2]
            error = sign * (c - origin) * mass - (before_moment + sign * one[3])
            _rule(
                rows, weights, sets, product, total, False, gauss,
                min(far, c), max(far, c), origin, one, 0,
            )  # fmt: skip
            rest = after_area + one[0]
            error += sign * (c - origin) * rest - (after_moment + sign * one[1])
            slope = mass + rest
            if not slope > 0.0:
                break
            new = c - sign * error / slope
            new = min(max(new, min(near, far)), max(near, far))
            moved = abs(new - c)
            c = new
            if moved <= least:
                break
        return c
    return math.nan


@scalar
def centroid_of_union(  # noqa: PLR0913 (memory is handed over, piece by piece)
    rows,
    weights,
    sets,
    product,
    total,
    crisp,
    kinks,
    gauss,
    tolerance,
    nodes,
    edges,
    sums,
    room,
    out,
    o,
):
    """Write the two ends of the centroid of a union fired by (2, sets), flat.

    ``nodes`` (kinks + 4 sets,), ``edges`` (2 P,), ``sums`` (4 P,) and ``room`` (ROOM,) are scratch
    space; P is 1 for type-1 unions. Return whether P pieces are enough.
    """
    origin = 0.5 * kinks[0] + 0.5 * kinks[kinks.size - 1]
    count = _nodes_of(rows, weights, sets, product, crisp, kinks, nodes)
    pieces = _pieces_of(
        rows, weights, sets, product, total, crisp, gauss,
        nodes, count, origin, tolerance, edges, sums, room,
    )  # fmt: skip
    if pieces < 0:
        return False
    if crisp:
        out[o] = out[o + 1] = origin + sums[3] / sums[2] if sums[2] > 0.0 else math.nan
        return True
    for end in range(2):
        out[o + end] = _end_of(
            rows, weights, sets, product, total, gauss,
            edges, sums, pieces, origin, end == 0, room,
        )  # fmt: skip
    if out[o] > out[o + 1]:
        out[o], out[o + 1] = out[o + 1], out[o]
    return True


@compiled
def centroids_of_unions(
    rows: Array,
    strengths: Array,
    product: bool,
    total: bool,
    crisp: bool,
    kinks: Array,
    gauss: Array,
    tolerance: float,
    out: Array,
) -> int:
    """Write the centroids (n, 2) of unions fired by (n, 2, sets); return -1 or a refused row.

    Unions that need too many pieces are refused. If ``total`` is true, sets are added up; otherwise
    they are united by the maximum. ``gauss`` holds the nodes and then the weights of the quadrature
    rule on [-1, 1].
    """
    sets = strengths.shape[2]
    flat, found = strengths.ravel(), out.ravel()
    nodes, room = np.empty(kinks.size + 4 * sets), np.empty(ROOM)
    most = 1 if crisp else USUAL_PIECES
    edges, sums = np.empty(2 * most), np.empty(4 * most)
    for row in range(strengths.shape[0]):
        weights = flat[2 * sets * row : 2 * sets * (row + 1)]
        enough = False
        while not enough:
            enough = centroid_of_union(
                rows, weights, sets, product, total, crisp, kinks, gauss, tolerance,
                nodes, edges, sums, room, found, 2 * row,
            )  # fmt: skip
            if not enough and most == MOST_PIECES:
                return row
            if not enough:
                most = MOST_PIECES
                edges, sums = np.empty(2 * most), np.empty(4 * most)
    return -1
