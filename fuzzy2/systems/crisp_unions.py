"""Compiled bisectors and maxima of type-1 unions, without a grid.

Sets are rows as in :mod:`fuzzy2.systems.united_kernels`. Each set rises to a plateau, usually a
point, and then falls. So under the maximum the union has its greatest grade on the plateau of one
or several sets, where they are highest or clipped.
"""

from __future__ import annotations

import math

from fuzzy2.support.compiled import scalar
from fuzzy2.systems.firing_kernels import TERM
from fuzzy2.systems.united_kernels import _cuts, _nodes_of, _one_grade, _pieces_of

(
    CENTROID,
    BISECTOR,
    MIDDLE_OF_AREA,
    SMALLEST,
    MIDDLE,
    MEAN,
    LARGEST,
    SMALLEST_ABSOLUTE,
    LARGEST_ABSOLUTE,
) = range(9)
"""Codes of the quantities of a union; ``MIDDLE_OF_AREA`` is fuzzylite's bisector of samples."""
SAME = 1e-12
"""Relative difference below which grades are equal to the greatest."""
NARROW = 1e-9
"""Share of the range below which plateaus are treated as points."""
HALVINGS = 60


@scalar
def _area(  # noqa: PLR0913 (memory is handed over, piece by piece)
    rows, weights, sets, product, total, gauss, tolerance, left, right, pair, edges, sums, room
):
    """Return the area of a union between two points; ``pair`` (2,) is scratch space."""
    pair[0], pair[1] = left, right
    _pieces_of(
        rows, weights, sets, product, total, True, gauss,
        pair, 2, left, tolerance, edges, sums, room,
    )  # fmt: skip
    return sums[2]


@scalar
def bisector_of_union(
    rows, weights, sets, product, total, kinks, gauss, tolerance, nodes, edges, sums, room
):
    """Return the bisector of a union fired by (2, sets), flat; NaN if nothing fires.

    The scratch arrays are those of ``centroid_of_union`` for one piece.
    """
    count = _nodes_of(rows, weights, sets, product, True, kinks, nodes)
    pair = nodes[count : count + 2]
    _pieces_of(
        rows, weights, sets, product, total, True, gauss,
        nodes, count, nodes[0], tolerance, edges, sums, room,
    )  # fmt: skip
    half, before = 0.5 * sums[2], 0.0
    if not half > 0.0:
        return math.nan
    for i in range(count - 1):
        low, high = nodes[i], nodes[i + 1]
        if not high > low:
            continue
        own = _area(
            rows, weights, sets, product, total, gauss, tolerance, low, high,
            pair, edges, sums, room,
        )  # fmt: skip
        if not (own > 0.0 and before + own >= half):
            before += own
            continue
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            if not low < middle < high:
                break
            own = _area(
                rows, weights, sets, product, total, gauss, tolerance, low, middle,
                pair, edges, sums, room,
            )  # fmt: skip
            if before + own < half:
                before += own
                low = middle
            else:
                high = middle
        return 0.5 * (low + high)
    return nodes[count - 1]


@scalar
def _plateau(rows, o, weight, product, first, last, ends):
    """Write the plateau of a fired set between two points; return its height.

    ``ends`` (4,) is scratch space, whose first two numbers become the ends of the plateau.
    """
    gaussian = int(rows[o + 1]) == 0
    left, right = (rows[o + 2], rows[o + 3]) if gaussian else (rows[o + 3], rows[o + 4])
    ends[0], ends[1] = min(max(left, first), last), max(min(right, last), first)
    grade = _one_grade(rows, o, 1, ends[0])
    if product:
        return weight * grade
    if weight < grade and _cuts(rows, o, 1, weight, ends, 2) == 4:
        ends[0], ends[1] = min(max(ends[2], first), last), max(min(ends[3], last), first)
    return min(weight, grade)


@scalar
def _joined(plateaus, count, asked, reach):
    """Return the mean of ascending plateaus, or their point nearest to or farthest from 0."""
    near, far = plateaus[0], plateaus[0]
    length, moment, points, different, reached = 0.0, 0.0, 0.0, 0, -math.inf
    for i in range(count):
        left, right = plateaus[2 * i], plateaus[2 * i + 1]
        nearest = min(max(0.0, left), right)
        near = nearest if abs(nearest) < abs(near) else near
        for end in range(2):
            at = plateaus[2 * i + end]
            far = at if abs(at) > abs(far) else far
        if left > reached:
            points += 0.5 * (left + right)
            different += 1
        left = max(left, reached)
        if right > left:
            length += right - left
            moment += (right - left) * 0.5 * (left + right)
        reached = max(reached, right)
    if asked == SMALLEST_ABSOLUTE:
        return near
    if asked == LARGEST_ABSOLUTE:
        return far
    return moment / length if length > NARROW * reach else points / different


@scalar
def maximum_of_union(asked, rows, weights, sets, product, kinks, room):
    """Return a point of greatest grade of a union under the maximum; one set must fire.

    ``room`` (2 sets + 4,) is scratch space. ``operators.MAXIMA`` lists the kinds of points.
    """
    first, last = kinks[0], kinks[kinks.size - 1]
    ends, greatest = room[2 * sets :], 0.0
    for k in range(sets):
        o = TERM * (2 * k + 1)
        greatest = max(greatest, _plateau(rows, o, weights[sets + k], product, first, last, ends))
    if not greatest > 0.0:
        return math.nan
    count, highest = 0, first
    for k in range(sets):
        o = TERM * (2 * k + 1)
        level = _plateau(rows, o, weights[sets + k], product, first, last, ends)
        if level >= greatest * (1.0 - SAME):
            i = count
            while i > 0 and room[2 * i - 2] > ends[0]:
                room[2 * i], room[2 * i + 1] = room[2 * i - 2], room[2 * i - 1]
                i -= 1
            room[2 * i], room[2 * i + 1] = ends[0], ends[1]
            highest = max(highest, ends[1])
            count += 1
    if asked == SMALLEST:
        return room[0]
    if asked == LARGEST:
        return highest
    if asked == MIDDLE:
        return 0.5 * room[0] + 0.5 * highest
    return _joined(room, count, asked, last - first)
