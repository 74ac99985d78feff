r"""Close the loops of a tree, compiled.

Damped Newton's method with continuation, one group of loops after the other.

The tree comes flattened to *elements*: joints of one degree of freedom are constant screws
:math:`S`, of placement :math:`M_0 \exp(S q)`; ball joints and free flyers are elements of their
own. A *group* is a set of loops that share un-actuated joints; groups do not depend on one another,
so the cost grows with their number and not with its cube. Placements are relative to the body on
which all loops of the group stand.

With :math:`R_1, p_1, R_2, p_2` the two frames of a closure, its residual is
:math:`R_1^T (p_2 - p_1)`, followed, if the closure is of six dimensions, by :math:`\log R_1^T R_2`;
the Jacobian is the exact derivative of both, also away from closure.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from fuzzy2.support.compiled import compiled
from psp3.checks import Array, Indices
from psp3.closure.rank import PIVOT_TOLERANCE

SCREW, UNBOUNDED, BALL, FREE = range(4)
"""Kinds of elements: one degree of freedom in one coordinate; an angle as cosine and sine; a
quaternion; position and quaternion.
"""

CLOSED, OPEN, SINGULAR = range(3)
"""What became of a row: closed; stopped on the way; the actuated joints do not determine the
others.
"""

LARGEST_PREDICTED_STEP = 0.3
"""Continuation moves no joint by more than this between two closures [m, rad]."""

LARGEST_CORRECTION = 0.3
"""Newton's method may move a predicted configuration by this share of the predicted step; more
could be another assembly mode.
"""

SMALLEST_CORRECTION = 1e-9
"""A correction by less than this is rounding, however short the step was [m, rad]."""

LARGEST_REPAIR = 1.0
"""A guess that closes the loops only after its joints have moved by more than this is none [m,
rad].
"""

INTERMEDIATE_TOLERANCE = 1e-7
"""Residual with which continuation goes on [m, rad]; only the last closure is exact."""

SMALLEST_STEP = 1e-6
"""Continuation gives up where this share of the way is still too long a step."""


class Table(NamedTuple):
    """A flattened tree with loops.

    Indices into a group's elements are local to the group; −1 is the body it stands on.
    """

    group_elements: Indices
    """First element of each group, and the end of the last."""
    group_closures: Indices
    """First closure of each group, and the end of the last."""
    group_columns: Indices
    """First un-actuated degree of freedom of each group, and the end of the last."""
    group_actuated: Indices
    """First actuated joint of each group, and the end of the last."""
    group_coordinates: Indices
    """First coordinate of each group, and the end of the last."""
    columns: Indices
    """Velocity index of every un-actuated degree of freedom."""
    actuated: Indices
    """Number of every actuated joint among all actuated coordinates."""
    actuated_place: Indices
    """Place of every actuated joint among the coordinates of its group."""
    coordinates: Indices
    """Configuration index of every coordinate."""
    actuated_q: Indices
    """Configuration index of each actuated coordinate."""
    kind: Indices
    """Kind of every element: ``SCREW``, ``UNBOUNDED``, ``BALL`` or ``FREE``."""
    parent: Indices
    """Element of the group that carries an element."""
    index_q: Indices
    """Place of an element's first coordinate among those of its group."""
    index_v: Indices
    """Velocity index of an element's first degree of freedom."""
    column: Indices
    """Column of an element's first degree of freedom among the un-actuated ones of its group, or
    −1 − its place among the actuated.
    """
    placement: Array
    """Rotation, row by row, and position of every element in its parent, (e, 12)."""
    screw: Array
    """Linear and angular part of the screws, (e, 6)."""
    closure_elements: Indices
    """The two elements that each closure joins, (c, 2)."""
    closure_rows: Indices
    """Three or six."""
    closure_placement: Array
    """Placements of the two frames in their elements, (c, 2, 12)."""
    side: Indices
    """+1 for elements between the common body and a closure's second frame, −1 for its first, 0 for
    others: (c, most elements).
    """
    tolerance: Array
    """Residual below which a group counts as closed [m, rad]."""


@compiled
def _compose(a, b, out):
    """Placement a · b."""
    for i in range(3):
        for j in range(3):
            out[3 * i + j] = a[3 * i] * b[j] + a[3 * i + 1] * b[3 + j] + a[3 * i + 2] * b[6 + j]
        out[9 + i] = a[3 * i] * b[9] + a[3 * i + 1] * b[10] + a[3 * i + 2] * b[11] + a[9 + i]


@compiled
def _exponential(screw, amount, out):
    """Placement exp(screw · amount)."""
    vx, vy, vz = screw[0] * amount, screw[1] * amount, screw[2] * amount
    wx, wy, wz = screw[3] * amount, screw[4] * amount, screw[5] * amount
    square = wx * wx + wy * wy + wz * wz
    angle = math.sqrt(square)
    if angle > 1e-4:
        a = math.sin(angle) / angle
        b = (1.0 - math.cos(angle)) / square
        c = (1.0 - a) / square
    else:
        a, b, c = 1.0 - square / 6.0, 0.5 - square / 24.0, 1.0 / 6.0 - square / 120.0
    out[0], out[1], out[2] = (
        1.0 - b * (wy * wy + wz * wz),
        b * wx * wy - a * wz,
        b * wx * wz + a * wy,
    )
    out[3], out[4], out[5] = (
        b * wx * wy + a * wz,
        1.0 - b * (wx * wx + wz * wz),
        b * wy * wz - a * wx,
    )
    out[6], out[7], out[8] = (
        b * wx * wz - a * wy,
        b * wy * wz + a * wx,
        1.0 - b * (wx * wx + wy * wy),
    )
    cx, cy, cz = wy * vz - wz * vy, wz * vx - wx * vz, wx * vy - wy * vx
    out[9] = vx + b * cx + c * (wy * cz - wz * cy)
    out[10] = vy + b * cy + c * (wz * cx - wx * cz)
    out[11] = vz + b * cz + c * (wx * cy - wy * cx)


@compiled
def _turned(quaternion, out):
    """Rotation of a unit quaternion (x, y, z, w)."""
    x, y, z, w = quaternion[0], quaternion[1], quaternion[2], quaternion[3]
    out[0], out[1], out[2] = (
        1.0 - 2.0 * (y * y + z * z),
        2.0 * (x * y - z * w),
        2.0 * (x * z + y * w),
    )
    out[3], out[4], out[5] = (
        2.0 * (x * y + z * w),
        1.0 - 2.0 * (x * x + z * z),
        2.0 * (y * z - x * w),
    )
    out[6], out[7], out[8] = (
        2.0 * (x * z - y * w),
        2.0 * (y * z + x * w),
        1.0 - 2.0 * (x * x + y * y),
    )


@compiled
def _joint(table, e, q, out):
    """Placement of an element's joint itself."""
    kind, at = table.kind[e], table.index_q[e]
    if kind == SCREW:
        _exponential(table.screw[e], q[at], out)
    elif kind == UNBOUNDED:
        _exponential(table.screw[e], math.atan2(q[at + 1], q[at]), out)
    elif kind == BALL:
        _turned(q[at : at + 4], out)
        out[9], out[10], out[11] = 0.0, 0.0, 0.0
    else:
        _turned(q[at + 3 : at + 7], out)
        out[9], out[10], out[11] = q[at], q[at + 1], q[at + 2]


@compiled
def _freedoms(kind):
    return 3 if kind == BALL else 6 if kind == FREE else 1


@compiled
def _twist(table, e, k, world, out):
    """Twist of an element's k-th degree of freedom at unit speed.

    Velocity at the group's origin, and angular velocity.
    """
    kind = table.kind[e]
    if kind <= UNBOUNDED:
        for i in range(3):
            out[i] = (
                world[3 * i] * table.screw[e, 0]
                + world[3 * i + 1] * table.screw[e, 1]
                + world[3 * i + 2] * table.screw[e, 2]
            )
            out[3 + i] = (
                world[3 * i] * table.screw[e, 3]
                + world[3 * i + 1] * table.screw[e, 4]
                + world[3 * i + 2] * table.screw[e, 5]
            )
    else:
        linear = kind == FREE and k < 3
        axis = k % 3
        for i in range(3):
            along = world[3 * i + axis]
            out[i], out[3 + i] = (along, 0.0) if linear else (0.0, along)
    out[0] += world[10] * out[5] - world[11] * out[4]
    out[1] += world[11] * out[3] - world[9] * out[5]
    out[2] += world[9] * out[4] - world[10] * out[3]


@compiled
def _place(table, group, q, world):
    """Placements of a group's elements."""
    first, last = table.group_elements[group], table.group_elements[group + 1]
    joint, fixed = np.empty(12), np.empty(12)
    for e in range(first, last):
        _joint(table, e, q, joint)
        parent = table.parent[e]
        if parent < 0:
            _compose(table.placement[e], joint, world[e - first])
        else:
            _compose(world[parent], table.placement[e], fixed)
            _compose(fixed, joint, world[e - first])


@compiled
def _frames(table, first, closure, world, one, two):
    """Placements of the two frames of a closure."""
    for side in range(2):
        out = one if side == 0 else two
        element = table.closure_elements[closure, side]
        if element < 0:
            for i in range(12):
                out[i] = table.closure_placement[closure, side, i]
        else:
            _compose(world[element], table.closure_placement[closure, side], out)


@compiled
def _logarithm(one, two, out):
    """Rotation vector of R_1ᵀ R_2."""
    r = np.empty(9)
    for i in range(3):
        for j in range(3):
            r[3 * i + j] = one[i] * two[j] + one[3 + i] * two[3 + j] + one[6 + i] * two[6 + j]
    x, y, z = 0.5 * (r[7] - r[5]), 0.5 * (r[2] - r[6]), 0.5 * (r[3] - r[1])
    sine = math.sqrt(x * x + y * y + z * z)
    cosine = 0.5 * (r[0] + r[4] + r[8] - 1.0)
    angle = math.atan2(sine, cosine)
    if sine > 1e-7:
        factor = angle / sine
        out[0], out[1], out[2] = factor * x, factor * y, factor * z
    elif cosine > 0.0:
        out[0], out[1], out[2] = x, y, z
    else:
        # Half a turn: the axis is the column of R + 1 that is longest.
        best = 0
        for i in range(3):
            if r[4 * i] > r[4 * best]:
                best = i
        length = 0.0
        for i in range(3):
            out[i] = r[3 * i + best] + (1.0 if i == best else 0.0)
            length += out[i] * out[i]
        for i in range(3):
            out[i] *= angle / math.sqrt(length)


@compiled
def _inverse_of_right_jacobian(vector, out):
    """Write the derivative of the rotation vector by the angular velocity, (3, 3).

    The angular velocity is in its own axes.
    """
    x, y, z = vector[0], vector[1], vector[2]
    square = x * x + y * y + z * z
    angle = math.sqrt(square)
    factor = (
        1.0 / 12.0 + square / 720.0
        if angle < 1e-2
        else 1.0 / square - 0.5 / (angle * math.tan(0.5 * angle))
    )
    out[0, 0], out[1, 1], out[2, 2] = (
        1.0 - factor * (y * y + z * z),
        1.0 - factor * (x * x + z * z),
        1.0 - factor * (x * x + y * y),
    )
    out[0, 1], out[0, 2], out[1, 2] = (
        factor * x * y - 0.5 * z,
        factor * x * z + 0.5 * y,
        factor * y * z - 0.5 * x,
    )
    out[1, 0], out[2, 0], out[2, 1] = (
        factor * x * y + 0.5 * z,
        factor * x * z - 0.5 * y,
        factor * y * z + 0.5 * x,
    )


@compiled
def _residual(table, group, world, residual):
    """Residual of a group's closures, and its largest entry."""
    first = table.group_elements[group]
    one, two, row, largest = np.empty(12), np.empty(12), 0, 0.0
    for closure in range(table.group_closures[group], table.group_closures[group + 1]):
        _frames(table, first, closure, world, one, two)
        dx, dy, dz = two[9] - one[9], two[10] - one[10], two[11] - one[11]
        for i in range(3):
            residual[row + i] = one[i] * dx + one[3 + i] * dy + one[6 + i] * dz
        if table.closure_rows[closure] == 6:
            _logarithm(one, two, residual[row + 3 :])
        row += table.closure_rows[closure]
    for i in range(row):
        size = abs(residual[i])
        # Written so that NaN counts as large.
        largest = largest if size <= largest else size
    return largest


@compiled
def _jacobian(table, group, world, residual, dependent, driven):
    """Write the derivative of a group's residual by its joints.

    By the un-actuated and by the actuated ones.
    """
    first, last = table.group_elements[group], table.group_elements[group + 1]
    one, two, twist, turn, row = np.empty(12), np.empty(12), np.empty(6), np.empty((3, 3)), 0
    dependent[:] = 0.0
    driven[:] = 0.0
    for closure in range(table.group_closures[group], table.group_closures[group + 1]):
        _frames(table, first, closure, world, one, two)
        if table.closure_rows[closure] == 6:
            _inverse_of_right_jacobian(residual[row + 3 :], turn)
        for e in range(first, last):
            side = table.side[closure, e - first]
            if side == 0:
                continue
            for k in range(_freedoms(table.kind[e])):
                _twist(table, e, k, world[e - first], twist)
                column = table.column[e]
                into, at = (dependent, column + k) if column >= 0 else (driven, -1 - column)
                vx = side * (twist[0] + twist[4] * two[11] - twist[5] * two[10])
                vy = side * (twist[1] + twist[5] * two[9] - twist[3] * two[11])
                vz = side * (twist[2] + twist[3] * two[10] - twist[4] * two[9])
                for i in range(3):
                    into[row + i, at] = one[i] * vx + one[3 + i] * vy + one[6 + i] * vz
                if table.closure_rows[closure] == 6:
                    wx = side * (two[0] * twist[3] + two[3] * twist[4] + two[6] * twist[5])
                    wy = side * (two[1] * twist[3] + two[4] * twist[4] + two[7] * twist[5])
                    wz = side * (two[2] * twist[3] + two[5] * twist[4] + two[8] * twist[5])
                    for i in range(3):
                        into[row + 3 + i, at] = turn[i, 0] * wx + turn[i, 1] * wy + turn[i, 2] * wz
        row += table.closure_rows[closure]


@compiled
def _solve(matrix, right, solution):
    """Least-squares solution of ``matrix`` · solution = right.

    By Householder's reflections with pivoting; both are overwritten.

    Return 0 if the columns are not independent, and otherwise the sign of the determinant, if
    ``matrix`` is square.
    """
    rows, columns = matrix.shape
    sides = right.shape[1]
    order = np.arange(columns)
    largest, sign = 0.0, 1
    for k in range(columns):
        best, longest = k, -1.0
        for j in range(k, columns):
            length = 0.0
            for i in range(k, rows):
                length += matrix[i, j] * matrix[i, j]
            if length > longest:
                best, longest = j, length
        if best != k:
            order[k], order[best] = order[best], order[k]
            sign = -sign
            for i in range(rows):
                matrix[i, k], matrix[i, best] = matrix[i, best], matrix[i, k]
        norm = math.sqrt(max(longest, 0.0))
        if k == 0:
            largest = norm
        if k >= rows or not norm > PIVOT_TOLERANCE * largest:
            return 0
        diagonal = -norm if matrix[k, k] > 0.0 else norm
        # A reflection has the determinant −1.
        sign = sign if diagonal < 0.0 else -sign
        head = matrix[k, k] - diagonal
        # The reflection is 1 − v vᵀ / scale with v the column below the diagonal and its head.
        scale = -head * diagonal
        for j in range(k + 1, columns):
            dot = head * matrix[k, j]
            for i in range(k + 1, rows):
                dot += matrix[i, k] * matrix[i, j]
            dot /= scale
            matrix[k, j] -= dot * head
            for i in range(k + 1, rows):
                matrix[i, j] -= dot * matrix[i, k]
        for j in range(sides):
            dot = head * right[k, j]
            for i in range(k + 1, rows):
                dot += matrix[i, k] * right[i, j]
            dot /= scale
            right[k, j] -= dot * head
            for i in range(k + 1, rows):
                right[i, j] -= dot * matrix[i, k]
        matrix[k, k] = diagonal
    for j in range(sides):
        for k in range(columns - 1, -1, -1):
            value = right[k, j]
            for i in range(k + 1, columns):
                value -= matrix[k, i] * solution[order[i], j]
            solution[order[k], j] = value / matrix[k, k]
    return sign


@compiled
def _orientation(before, now):
    """Sign of the determinant of the motion between two Jacobians (m, u).

    The Jacobians have full rank, and the motion is in the space of their columns.
    """
    columns = now.shape[1]
    across, nothing = np.empty((columns, columns)), np.zeros((columns, 1))
    if _solve(before.copy(), now.copy(), across) == 0:
        return 0
    return _solve(across, nothing, np.empty((columns, 1)))


@compiled
def _multiply(a, b, out):
    """Product of two quaternions (x, y, z, w), normalized."""
    x = a[3] * b[0] + a[0] * b[3] + a[1] * b[2] - a[2] * b[1]
    y = a[3] * b[1] - a[0] * b[2] + a[1] * b[3] + a[2] * b[0]
    z = a[3] * b[2] + a[0] * b[1] - a[1] * b[0] + a[2] * b[3]
    w = a[3] * b[3] - a[0] * b[0] - a[1] * b[1] - a[2] * b[2]
    norm = math.sqrt(x * x + y * y + z * z + w * w)
    out[0], out[1], out[2], out[3] = x / norm, y / norm, z / norm, w / norm


@compiled
def _move(table, group, q, step, share, out):
    """Move a group's un-actuated joints by a share of a step; the rest of ``out`` stays."""
    quaternion, turn = np.empty(4), np.empty(12)
    for e in range(table.group_elements[group], table.group_elements[group + 1]):
        column, kind, at = table.column[e], table.kind[e], table.index_q[e]
        if column < 0:
            continue
        if kind == SCREW:
            out[at] = q[at] + share * step[column]
        elif kind == UNBOUNDED:
            c, s = math.cos(share * step[column]), math.sin(share * step[column])
            out[at], out[at + 1] = q[at] * c - q[at + 1] * s, q[at + 1] * c + q[at] * s
        else:
            if kind == FREE:
                _turned(q[at + 3 : at + 7], turn)
                for i in range(3):
                    along = (
                        turn[3 * i] * step[column]
                        + turn[3 * i + 1] * step[column + 1]
                        + turn[3 * i + 2] * step[column + 2]
                    )
                    out[at + i] = q[at + i] + share * along
                at += 3
                column += 3
            x, y, z = share * step[column], share * step[column + 1], share * step[column + 2]
            angle = math.sqrt(x * x + y * y + z * z)
            half = 0.5 - angle * angle / 48.0 if angle < 1e-3 else math.sin(0.5 * angle) / angle
            quaternion[0], quaternion[1], quaternion[2], quaternion[3] = (
                half * x,
                half * y,
                half * z,
                math.cos(0.5 * angle),
            )
            _multiply(q[at : at + 4], quaternion, out[at : at + 4])


@compiled
def _newton(table, group, q, enough, work):
    """Close a group's loops from ``q`` with its un-actuated joints, damped.

    Return the residual and how far the joints moved.

    Beyond ``enough`` no further precision is asked for. The movement is the largest sum of steps of
    any joint.
    """
    world, residual, dependent, driven, right, step, trial = work
    columns = dependent.shape[1]
    moved = np.zeros(columns)
    _place(table, group, q, world)
    size = _residual(table, group, world, residual)
    # Beyond machine precision a step moves nothing, so more steps than this are the sign of a pose
    # that does not exist.
    for _ in range(25):
        if size <= enough:
            break
        _jacobian(table, group, world, residual, dependent, driven)
        for i in range(residual.shape[0]):
            right[i, 0] = -residual[i]
        if _solve(dependent, right[:, :1], step[:, :1]) == 0:
            break
        share, better = 1.0, False
        for _ in range(4):
            trial[:] = q
            _move(table, group, q, step[:, 0], share, trial)
            _place(table, group, trial, world)
            smaller = _residual(table, group, world, residual)
            if smaller < size:
                better = True
                break
            if size <= table.tolerance[group]:
                break
            share *= 0.5
        if not better:
            break
        size = smaller
        q[:] = trial
        for i in range(columns):
            moved[i] += share * step[i, 0]
    largest = 0.0
    for i in range(columns):
        distance = abs(moved[i])
        largest = largest if distance <= largest else distance
    return size, largest


@compiled
def _complement(table, group, q, work, out, closing):
    """Velocities of a group's un-actuated joints per unit of its actuated ones.

    The Jacobian ``closing`` gives them, and is returned, too.

    Return 0 if they are not determined, and otherwise the sign of the determinant, if the Jacobian
    is square.
    """
    world, residual, dependent, driven, right, _, _ = work
    _place(table, group, q, world)
    _residual(table, group, world, residual)
    _jacobian(table, group, world, residual, dependent, driven)
    closing[:] = dependent
    for i in range(right.shape[0]):
        for j in range(right.shape[1]):
            right[i, j] = -driven[i, j] if j < driven.shape[1] else 0.0
    return _solve(dependent, right, out)


@compiled
def _follow(table, group, q, positions, work, complement, report):
    """Move a group's actuated joints to ``positions`` with its loops closed.

    Leave the velocities per unit in ``complement``.

    ``report`` becomes the share of the way and the residual.
    """
    first, last = table.group_actuated[group], table.group_actuated[group + 1]
    columns = complement.shape[0]
    tolerance = table.tolerance[group]
    report[0] = 0.0
    _place(table, group, q, work[0])
    report[1] = _residual(table, group, work[0], work[1])
    residual, moved = _newton(table, group, q, 0.0, work)
    if not residual <= tolerance or not moved <= LARGEST_REPAIR:
        return OPEN
    report[1] = residual
    closing = np.empty_like(work[2])
    sign = _complement(table, group, q, work, complement, closing)
    if sign == 0:
        return SINGULAR
    start, way = np.empty(last - first), np.empty(last - first)
    farthest = 0.0
    for j in range(last - first):
        start[j] = q[table.actuated_place[first + j]]
        way[j] = positions[table.actuated[first + j]] - start[j]
        farthest = max(farthest, abs(way[j]))
    if farthest == 0.0:
        report[0] = 1.0
        return CLOSED
    square = closing.shape[0] == columns
    speed, closed, next_complement, next_closing = (
        np.empty(columns),
        q.copy(),
        np.empty_like(complement),
        np.empty_like(closing),
    )
    done, step = 0.0, 1.0
    while done < 1.0:
        fastest = farthest
        for i in range(columns):
            speed[i] = 0.0
            for j in range(last - first):
                speed[i] += complement[i, j] * way[j]
            fastest = max(fastest, abs(speed[i]))
        step = min(step, 1.0 - done, LARGEST_PREDICTED_STEP / fastest)
        goal = 1.0 if done + step > 1.0 - 1e-12 else done + step
        q[:] = closed
        _move(table, group, closed, speed, goal - done, q)
        for j in range(last - first):
            # Exactly the positions asked for, at the end.
            at = table.actuated_place[first + j]
            q[at] = (
                positions[table.actuated[first + j]] if goal == 1.0 else start[j] + goal * way[j]
            )
        residual, moved = _newton(
            table, group, q, 0.0 if goal == 1.0 else INTERMEDIATE_TOLERANCE, work
        )
        good = residual <= (tolerance if goal == 1.0 else INTERMEDIATE_TOLERANCE)
        if good and moved <= LARGEST_CORRECTION * (goal - done) * fastest + SMALLEST_CORRECTION:
            next_sign = _complement(table, group, q, work, next_complement, next_closing)
            # Beyond a fold, and on the other branch before it, the determinant has the other sign.
            good = (
                next_sign == sign
                if square
                else next_sign != 0 and _orientation(closing, next_closing) > 0
            )
        else:
            good = False
        if good:
            closed[:], complement[:], closing[:] = q, next_complement, next_closing
            report[0], report[1] = goal, residual
            done, step = goal, 2.0 * (goal - done)
        else:
            step = 0.5 * (goal - done)
            if step < SMALLEST_STEP:
                # How far apart the frames would be if only the motors went on.
                for j in range(last - first):
                    closed[table.actuated_place[first + j]] = positions[table.actuated[first + j]]
                _place(table, group, closed, work[0])
                report[1] = _residual(table, group, work[0], work[1])
                return OPEN
    return CLOSED


@compiled
def _workspace(table, group):
    """Work arrays of a group."""
    elements = table.group_elements[group + 1] - table.group_elements[group]
    columns = table.group_columns[group + 1] - table.group_columns[group]
    driven = table.group_actuated[group + 1] - table.group_actuated[group]
    rows = 0
    for closure in range(table.group_closures[group], table.group_closures[group + 1]):
        rows += table.closure_rows[closure]
    sides = max(driven, 1)
    return (
        np.empty((elements, 12)),
        np.empty(rows),
        np.empty((rows, columns)),
        np.empty((rows, driven)),
        np.empty((rows, sides)),
        np.empty((columns, sides)),
        np.empty(table.group_coordinates[group + 1] - table.group_coordinates[group]),
        np.empty(table.group_coordinates[group + 1] - table.group_coordinates[group]),
    )


@compiled
def _gather(table, group, configuration, q):
    """Take a group's coordinates out of a configuration."""
    first = table.group_coordinates[group]
    for i in range(first, table.group_coordinates[group + 1]):
        q[i - first] = configuration[table.coordinates[i]]


@compiled
def close(
    table: Table,
    guess: Array,
    positions: Array,
    along: bool,
    configurations: Array,
    complements: Array,
    report: Array,
) -> int:
    """Close the loops at every row of positions (N, n).

    From ``guess`` or, ``along`` a path, from the row before.

    Write configurations (N, nq) and, unless that array is empty, complements L (N, nv, n). Return
    the first row that could not be closed, or −1; ``report`` says what became of it: kind, share of
    the way, residual, group.
    """
    groups = table.group_elements.shape[0] - 1
    start, progress = guess.copy(), np.empty(2)
    for row in range(positions.shape[0]):
        configuration = configurations[row]
        configuration[:] = start
        for group in range(groups):
            world, residual, dependent, driven, right, step, q, trial = _workspace(table, group)
            # A motor that drives two groups takes each of them along from the same place.
            _gather(table, group, start, q)
            complement = np.empty_like(step)
            outcome = _follow(
                table,
                group,
                q,
                positions[row],
                (world, residual, dependent, driven, right, step, trial),
                complement,
                progress,
            )
            first = table.group_coordinates[group]
            for i in range(q.shape[0]):
                configuration[table.coordinates[first + i]] = q[i]
            if outcome != CLOSED:
                report[0], report[1], report[2], report[3] = (
                    outcome,
                    progress[0],
                    progress[1],
                    group,
                )
                return row
            if complements.shape[0] > 0:
                for i in range(complement.shape[0]):
                    at = table.columns[table.group_columns[group] + i]
                    for j in range(table.group_actuated[group + 1] - table.group_actuated[group]):
                        complements[row, at, table.actuated[table.group_actuated[group] + j]] = (
                            complement[i, j]
                        )
        for j in range(table.actuated_q.shape[0]):
            # Those that no loop contains have not been moved yet.
            configuration[table.actuated_q[j]] = positions[row, j]
        if along:
            start[:] = configuration
    return -1


@compiled
def residuals(table: Table, q: Array, out: Array) -> None:
    """Write the residuals of all closures, group by group."""
    row = 0
    for group in range(table.group_elements.shape[0] - 1):
        world, residual, _, _, _, _, local, _ = _workspace(table, group)
        _gather(table, group, q, local)
        _place(table, group, local, world)
        _residual(table, group, world, residual)
        out[row : row + residual.shape[0]] = residual
        row += residual.shape[0]


@compiled
def jacobian(table: Table, q: Array, out: Array) -> None:
    """Write the derivative of all residuals by all un-actuated joints, (rows, nv).

    Group by group.
    """
    out[:] = 0.0
    above = 0
    for group in range(table.group_elements.shape[0] - 1):
        world, residual, dependent, driven, _, _, local, _ = _workspace(table, group)
        _gather(table, group, q, local)
        _place(table, group, local, world)
        _residual(table, group, world, residual)
        _jacobian(table, group, world, residual, dependent, driven)
        for j in range(dependent.shape[1]):
            at = table.columns[table.group_columns[group] + j]
            for i in range(dependent.shape[0]):
                out[above + i, at] = dependent[i, j]
        above += dependent.shape[0]


@compiled
def drift(table: Table, q: Array, v: Array, out: Array) -> bool:
    r"""Write the accelerations of the un-actuated joints at constant actuated speeds.

    Return whether they are determined.

    The accelerations of the two frames of every closure must agree: with :math:`A` their derivative
    with respect to the joint accelerations, :math:`A \ddot q = -b(q, v)`, where b are the
    accelerations that the velocities alone give.
    """
    twist, one, two = np.empty(6), np.empty(12), np.empty(12)
    for group in range(table.group_elements.shape[0] - 1):
        first, last = table.group_elements[group], table.group_elements[group + 1]
        world, residual, dependent, driven, right, step, local, _ = _workspace(table, group)
        _gather(table, group, q, local)
        _place(table, group, local, world)
        _residual(table, group, world, residual)
        _jacobian(table, group, world, residual, dependent, driven)
        velocity, acceleration = np.zeros((last - first + 1, 6)), np.zeros((last - first + 1, 6))
        # The last row stays zero: the body on which the group stands.
        for e in range(first, last):
            here, parent = e - first, table.parent[e] if table.parent[e] >= 0 else last - first
            own = np.zeros(6)
            for k in range(_freedoms(table.kind[e])):
                _twist(table, e, k, world[here], twist)
                for i in range(6):
                    own[i] += twist[i] * v[table.index_v[e] + k]
            for i in range(6):
                velocity[here, i] = velocity[parent, i] + own[i]
                acceleration[here, i] = acceleration[parent, i]
            V = velocity[here]
            for i in range(3):
                j, k = (i + 1) % 3, (i + 2) % 3
                acceleration[here, i] += (
                    V[3 + j] * own[k] - V[3 + k] * own[j] + V[j] * own[3 + k] - V[k] * own[3 + j]
                )
                acceleration[here, 3 + i] += V[3 + j] * own[3 + k] - V[3 + k] * own[3 + j]
        row = 0
        for closure in range(table.group_closures[group], table.group_closures[group + 1]):
            _frames(table, first, closure, world, one, two)
            point, relative = np.zeros(3), np.zeros(3)
            for side in range(2):
                element = table.closure_elements[closure, side]
                at = element if element >= 0 else last - first
                V, A, sign = velocity[at], acceleration[at], 2.0 * side - 1.0
                for i in range(3):
                    j, k = (i + 1) % 3, (i + 2) % 3
                    # Acceleration of the point: that of the body's point at the origin, and the two
                    # terms of its rotation.
                    vj = V[j] + V[3 + k] * two[9 + i] - V[3 + i] * two[9 + k]
                    vk = V[k] + V[3 + i] * two[9 + j] - V[3 + j] * two[9 + i]
                    point[i] += sign * (
                        A[i]
                        + A[3 + j] * two[9 + k]
                        - A[3 + k] * two[9 + j]
                        + V[3 + j] * vk
                        - V[3 + k] * vj
                    )
                    relative[i] += sign * A[3 + i]
            for i in range(3):
                right[row + i, 0] = -(
                    one[i] * point[0] + one[3 + i] * point[1] + one[6 + i] * point[2]
                )
            if table.closure_rows[closure] == 6:
                for i in range(3):
                    right[row + 3 + i, 0] = -(
                        two[i] * relative[0] + two[3 + i] * relative[1] + two[6 + i] * relative[2]
                    )
            row += table.closure_rows[closure]
        if _solve(dependent, right[:, :1], step[:, :1]) == 0:
            return False
        for i in range(step.shape[0]):
            out[table.columns[table.group_columns[group] + i]] = step[i, 0]
    return True
