r"""Derivatives of the forces of a motion by positions and speeds, along closed loops, compiled.

With :math:`X_k` the twists of all elements at unit speed of the independent coordinate k, the
tangent of a motion needs no derivative of its own: along coordinate k a field that moves with its
element changes by :math:`X_k \times`, and beyond that velocities change by :math:`\dot X_k` and
accelerations by :math:`\ddot X_k + \dot X_k \times V`, the rates of :math:`X_k` *along the motion*,
because derivatives by two coordinates may be exchanged:
:math:`\partial_k X_i - \partial_i X_k = X_k \times X_i`. So

.. math::

    \frac{\partial \tau_i}{\partial a_k} &= \sum X_i^T \big( I (\ddot X_k + X_k \times g)
        + B \dot X_k + (X_k - X_k^p) \times^* F \big) + \dots, \\
    \frac{\partial \tau_i}{\partial \dot a_k} &= \sum X_i^T ( 2 I \dot X_k + B X_k ), \qquad
    B Z = I (Z \times V) + Z \times^* I V + V \times^* I Z,

where :math:`X_k^p` is the twist of the element's parent and F the wrench on all that an element
carries, with the forces in the loops. These make up for the change of L: with
:math:`J_u^T \mu = -f_u` the forces of the loops, :math:`\mu^T \partial_i J L_k` is all that is left
of it. Half of that are the screws of the joints, which move with their elements, and are in F; the
other half (the dots above) is the force at a closure that turns with it. Of a body B is the change
of twice the velocity: a force and a torque that depend on the turning of Z alone.

One solution of the loops' equations a coordinate gives :math:`\ddot L`. There are none for the
derivatives by speeds.
"""

from __future__ import annotations

from fuzzy2.support.compiled import compiled, inlined
from psp3.multibody.bodies import momentum
from psp3.multibody.closing import spread
from psp3.multibody.forces import add_change
from psp3.multibody.least_squares import solve_transposed
from psp3.multibody.loops import polynomial
from psp3.multibody.tree import (
    AT_ACCELERATIONS,
    AT_BRACKETS,
    AT_BY_POSITIONS,
    AT_BY_SPEEDS,
    AT_CLOSURE_FRAMES,
    AT_CLOSURES,
    AT_COLUMN_OF,
    AT_COMPLEMENT,
    AT_COMPLEMENT_RATES,
    AT_CONFIGURATION,
    AT_DEPENDENT_V,
    AT_ELEMENTS,
    AT_ENDS,
    AT_FACTORS,
    AT_FIELD_FORCES,
    AT_FIELDS,
    AT_FORCES,
    AT_FRAMES,
    AT_FREE_FALL,
    AT_GROUPS,
    AT_INERTIAS,
    AT_JOINT_ACCELERATIONS,
    AT_JOINT_FORCES,
    AT_JOINT_LOADS,
    AT_JOINT_SPEEDS,
    AT_JOINTS,
    AT_LOADS,
    AT_LOOP_FORCES,
    AT_MASS,
    AT_MASSIVE,
    AT_RATES,
    AT_REFLECTIONS,
    AT_RIGHT,
    AT_SCREWS,
    AT_SECOND_RATES,
    AT_SPINS,
    AT_VELOCITIES,
    BODIES,
    CLOSURE_INTEGERS,
    CLOSURE_KIND,
    CLOSURE_NUMBERS,
    COUPLED_SPEED,
    COUPLING,
    ELEMENT_INTEGERS,
    ELEMENTS,
    FACTOR_AT,
    FIRST_CLOSURE,
    FIRST_END,
    FIRST_ROW,
    FRAME,
    FREEDOMS,
    GROUP_COLUMN,
    GROUP_COLUMNS,
    GROUP_INTEGERS,
    GROUP_ROWS,
    GROUPS,
    HINGE,
    INDEPENDENT,
    INDEX_V,
    JOINT_NUMBERS,
    KIND,
    PARENT,
    POINT,
    SCREW,
    SECOND_END,
    UNBOUNDED,
    VELOCITIES,
)


@compiled
def differentiate(tree, numbers, memory, forces):
    """Write the derivatives of the independent forces by positions and by speeds, column by column.

    The memory has a motion with all its forces, those of independent joints at ``forces``, the mass
    matrix, L, its twists and their rates. The elements' forces are overwritten.
    """
    _load(tree, numbers, memory)
    _spin(tree, memory)
    n, nv = tree[INDEPENDENT], tree[VELOCITIES]
    for k in range(n):
        for i in range(n):
            memory[tree[AT_BY_POSITIONS] + n * k + i] = 0.0
            memory[tree[AT_BY_SPEEDS] + n * k + i] = 0.0
        _along_speed(tree, numbers, memory, k)
        _bring(tree, memory, tree[AT_BY_SPEEDS] + n * k)
        for velocity in range(nv):
            memory[tree[AT_JOINT_LOADS] + velocity] = 0.0
        _rates_again(tree, numbers, memory, k)
        _along_position(tree, numbers, memory, k)
        _bring(tree, memory, tree[AT_BY_POSITIONS] + n * k)
    _at_free_joints(tree, memory, forces)


@compiled
def _at_free_joints(tree, memory, forces):
    """Correct the derivatives by an independent ball or free flyer, whose speeds are no rates.

    Derivatives along two of these may not be exchanged: they differ by the one along their bracket.
    Those by positions are at constant speeds, in the joint's own axes, which turn.
    """
    n, M, column_of = tree[INDEPENDENT], tree[AT_MASS], tree[AT_COLUMN_OF]
    unit = tree[AT_BRACKETS]
    turned, faster, own, dual = unit + 6, unit + 12, unit + 18, unit + 24
    for e in range(tree[ELEMENTS]):
        row = tree[AT_ELEMENTS] + ELEMENT_INTEGERS * e
        first, count = tree[row + INDEX_V], tree[row + FREEDOMS]
        place = -1 - tree[column_of + first]
        # Dependent or locked
        if count == 1 or place < 0 or place >= n:
            continue
        for i in range(count):
            memory[own + i] = memory[forces - 1 - tree[column_of + first + i]]
        for part in range(2):
            for axis in range(count):
                for i in range(count):
                    memory[unit + i] = 1.0 if i == axis else 0.0
                _bracket(memory, tree[AT_JOINT_SPEEDS] + first, unit, count, turned)
                _bracket(memory, tree[AT_JOINT_ACCELERATIONS] + first, unit, count, faster)
                _dual_bracket(memory, unit, own, count, dual)
                k = -1 - tree[column_of + first + axis]
                by_speed = tree[AT_BY_SPEEDS] + n * k
                by_position = tree[AT_BY_POSITIONS] + n * k
                for i in range(count):
                    j = -1 - tree[column_of + first + i]
                    for f in range(n):
                        mass = memory[M + n * f + j]
                        if part == 0:
                            memory[by_speed + f] -= mass * memory[turned + i]
                        else:
                            slope = memory[tree[AT_BY_SPEEDS] + n * j + f]
                            memory[by_position + f] -= (
                                slope * memory[turned + i] + mass * memory[faster + i]
                            )
                    if part == 1:
                        memory[by_position + j] -= memory[dual + i]


@compiled
def _load(tree, numbers, memory):
    """Write the wrench on all that each element carries, with the forces in the loops."""
    elements, groups = tree[ELEMENTS], tree[AT_GROUPS]
    loads, loops, right = tree[AT_LOADS], tree[AT_LOOP_FORCES], tree[AT_RIGHT]
    for i in range(6 * elements):
        memory[loads + i] = 0.0
    for group in range(tree[GROUPS]):
        g = groups + GROUP_INTEGERS * group
        column = tree[g + GROUP_COLUMN]
        for k in range(tree[g + GROUP_COLUMNS]):
            memory[right + k] = -memory[
                tree[AT_JOINT_FORCES] + tree[tree[AT_DEPENDENT_V] + column + k]
            ]
        solve_transposed(
            tree,
            memory,
            tree[AT_ENDS] + column,
            tree[AT_FACTORS] + tree[g + FACTOR_AT],
            tree[AT_REFLECTIONS] + column,
            tree[g + GROUP_ROWS],
            tree[g + GROUP_COLUMNS],
            right,
        )
        for closure in range(tree[g + FIRST_CLOSURE], tree[g + GROUP_INTEGERS + FIRST_CLOSURE]):
            c = tree[AT_CLOSURES] + CLOSURE_INTEGERS * closure
            row, o = right + tree[c + FIRST_ROW], loops + 6 * closure
            kind, one, two = tree[c + CLOSURE_KIND], tree[c + FIRST_END], tree[c + SECOND_END]
            if kind == COUPLING:
                memory[o] = memory[row]
                continue
            _close(tree, memory, closure, kind, row, o)
            if one >= 0:
                _add_wrench(tree, memory, closure, kind, o, -1.0, loads + 6 * one)
            if two >= 0:
                _add_wrench(tree, memory, closure, kind, o, 1.0, loads + 6 * two)
    for e in range(elements - 1, -1, -1):
        parent = tree[tree[AT_ELEMENTS] + ELEMENT_INTEGERS * e + PARENT]
        for i in range(6):
            if parent >= 0:
                memory[loads + 6 * parent + i] += memory[loads + 6 * e + i]
            memory[loads + 6 * e + i] += memory[tree[AT_FORCES] + 6 * e + i]


@compiled
def _close(tree, memory, closure, kind, row, out):
    """Write what a closure's multipliers are in base axes: a force, and a vector of its turning."""
    f = tree[AT_FRAMES] + 24 * closure
    for i in range(3):
        k = f + 3 * i
        memory[out + i] = (
            memory[k] * memory[row]
            + memory[k + 1] * memory[row + 1]
            + memory[k + 2] * memory[row + 2]
        )
        memory[out + 3 + i] = 0.0
        if kind != POINT:
            memory[out + 3 + i] = memory[k] * memory[row + 3] + memory[k + 1] * memory[row + 4]
        if kind == FRAME:
            memory[out + 3 + i] += memory[k + 2] * memory[row + 5]


@compiled
def _add_wrench(tree, memory, closure, kind, force, sign, out):
    """Add the wrench of a closure's force to that of one of the elements that it joins."""
    f = tree[AT_FRAMES] + 24 * closure
    x, y, z = memory[f + 21], memory[f + 22], memory[f + 23]
    fx, fy, fz = sign * memory[force], sign * memory[force + 1], sign * memory[force + 2]
    mx, my, mz = sign * memory[force + 3], sign * memory[force + 4], sign * memory[force + 5]
    if kind == HINGE:
        ax, ay, az = memory[f + 14], memory[f + 17], memory[f + 20]
        mx, my, mz = ay * mz - az * my, az * mx - ax * mz, ax * my - ay * mx
    memory[out] += fx
    memory[out + 1] += fy
    memory[out + 2] += fz
    memory[out + 3] += mx + y * fz - z * fy
    memory[out + 4] += my + z * fx - x * fz
    memory[out + 5] += mz + x * fy - y * fx


@compiled
def _spin(tree, memory):
    r"""Write B of all bodies: twice the momentum (3), and the matrix of the torque (9).

    With x the places of a body's particles and v their velocities, B Z is the wrench of
    :math:`2 z \times v`, and the matrix :math:`2 \sum m ((x^T v) 1 - v x^T)`.
    """
    for body in range(tree[BODIES]):
        e = tree[tree[AT_MASSIVE] + body]
        i, v, o = tree[AT_INERTIAS] + 10 * e, tree[AT_VELOCITIES] + 6 * e, tree[AT_SPINS] + 12 * e
        mass, hx, hy, hz = memory[i], memory[i + 1], memory[i + 2], memory[i + 3]
        vx, vy, vz = 2.0 * memory[v], 2.0 * memory[v + 1], 2.0 * memory[v + 2]
        wx, wy, wz = 2.0 * memory[v + 3], 2.0 * memory[v + 4], 2.0 * memory[v + 5]
        memory[o] = mass * vx + wy * hz - wz * hy
        memory[o + 1] = mass * vy + wz * hx - wx * hz
        memory[o + 2] = mass * vz + wx * hy - wy * hx
        # Second moments of mass.
        half = 0.5 * (memory[i + 4] + memory[i + 7] + memory[i + 9])
        xx, yy, zz = half - memory[i + 4], half - memory[i + 7], half - memory[i + 9]
        xy, xz, yz = -memory[i + 5], -memory[i + 6], -memory[i + 8]
        trace = vx * hx + vy * hy + vz * hz
        memory[o + 3] = trace - vx * hx + wz * xy - wy * xz
        memory[o + 4] = -vx * hy + wz * yy - wy * yz
        memory[o + 5] = -vx * hz + wz * yz - wy * zz
        memory[o + 6] = -vy * hx - wz * xx + wx * xz
        memory[o + 7] = trace - vy * hy - wz * xy + wx * yz
        memory[o + 8] = -vy * hz - wz * xz + wx * zz
        memory[o + 9] = -vz * hx + wy * xx - wx * xy
        memory[o + 10] = -vz * hy + wy * xy - wx * yy
        memory[o + 11] = trace - vz * hz + wy * xz - wx * yz


@inlined
def _add_spin(tree, memory, e, Z, out):
    """Add B Z of a body."""
    o = tree[AT_SPINS] + 12 * e
    x, y, z = memory[Z + 3], memory[Z + 4], memory[Z + 5]
    px, py, pz = memory[o], memory[o + 1], memory[o + 2]
    memory[out] += y * pz - z * py
    memory[out + 1] += z * px - x * pz
    memory[out + 2] += x * py - y * px
    for i in range(3):
        k = o + 3 + 3 * i
        memory[out + 3 + i] += memory[k] * x + memory[k + 1] * y + memory[k + 2] * z


@compiled
def _along_speed(tree, numbers, memory, k):
    """Write how the wrenches of all elements and the loads of joints change with speed k."""
    wide, T, nv = 6 * (tree[ELEMENTS] + 1), tree[AT_FIELD_FORCES], tree[VELOCITIES]
    X, rates = tree[AT_FIELDS] + wide * k, tree[AT_RATES] + wide * k
    twice = T + 6 * tree[ELEMENTS]
    for i in range(6 * tree[ELEMENTS]):
        memory[T + i] = 0.0
    for body in range(tree[BODIES]):
        e = tree[tree[AT_MASSIVE] + body]
        for i in range(6):
            memory[twice + i] = 2.0 * memory[rates + 6 * e + i]
        momentum(tree, memory, e, twice, T + 6 * e)
        _add_spin(tree, memory, e, X + 6 * e, T + 6 * e)
    L, change = tree[AT_COMPLEMENT] + nv * k, tree[AT_COMPLEMENT_RATES] + nv * k
    for velocity in range(nv):
        joint = tree[AT_JOINTS] + JOINT_NUMBERS * velocity
        memory[tree[AT_JOINT_LOADS] + velocity] = (
            2.0 * numbers[joint] * memory[change + velocity]
            + numbers[joint + 1] * memory[L + velocity]
        )
    for e in range(tree[ELEMENTS]):
        row = tree[AT_ELEMENTS] + ELEMENT_INTEGERS * e
        if tree[row + KIND] > UNBOUNDED:
            first, count = tree[row + INDEX_V], tree[row + FREEDOMS]
            _add_bracket(
                tree, numbers, memory, 0, tree[AT_JOINT_SPEEDS] + first, L + first, first, count
            )


@inlined
def _bracket(memory, one, other, count, out):
    """Write the cross product of two twists of a joint, of which a ball's have no linear part."""
    s = count - 3
    wx, wy, wz = memory[one + s], memory[one + s + 1], memory[one + s + 2]
    x, y, z = memory[other + s], memory[other + s + 1], memory[other + s + 2]
    memory[out + s], memory[out + s + 1], memory[out + s + 2] = (
        wy * z - wz * y,
        wz * x - wx * z,
        wx * y - wy * x,
    )
    if s > 0:
        vx, vy, vz = memory[one], memory[one + 1], memory[one + 2]
        ux, uy, uz = memory[other], memory[other + 1], memory[other + 2]
        memory[out] = wy * uz - wz * uy + vy * z - vz * y
        memory[out + 1] = wz * ux - wx * uz + vz * x - vx * z
        memory[out + 2] = wx * uy - wy * ux + vx * y - vy * x


@inlined
def _dual_bracket(memory, one, force, count, out):
    """Write the cross product of a joint's twist with its force."""
    s = count - 3
    wx, wy, wz = memory[one + s], memory[one + s + 1], memory[one + s + 2]
    x, y, z = memory[force + s], memory[force + s + 1], memory[force + s + 2]
    memory[out + s], memory[out + s + 1], memory[out + s + 2] = (
        wy * z - wz * y,
        wz * x - wx * z,
        wx * y - wy * x,
    )
    if s > 0:
        vx, vy, vz = memory[one], memory[one + 1], memory[one + 2]
        x, y, z = memory[force], memory[force + 1], memory[force + 2]
        memory[out], memory[out + 1], memory[out + 2] = (
            wy * z - wz * y,
            wz * x - wx * z,
            wx * y - wy * x,
        )
        memory[out + 3] += vy * z - vz * y
        memory[out + 4] += vz * x - vx * z
        memory[out + 5] += vx * y - vy * x


@compiled
def _add_bracket(tree, numbers, memory, factor, one, other, first, count):
    """Add to the loads of a joint of many freedoms a factor of the joint times a bracket.

    The factor is its motors' inertia or its damping, 0 or 1.
    """
    out, loads = tree[AT_BRACKETS], tree[AT_JOINT_LOADS] + first
    _bracket(memory, one, other, count, out)
    for i in range(count):
        joint = tree[AT_JOINTS] + JOINT_NUMBERS * (first + i)
        memory[loads + i] += numbers[joint + factor] * memory[out + i]


@compiled
def _rates_again(tree, numbers, memory, k):
    """Write the second rates of the twists of column k of L, and that of the column to the loads.

    The elements' forces are overwritten.
    """
    elements, A, V = tree[ELEMENTS], tree[AT_ACCELERATIONS], tree[AT_VELOCITIES]
    X, rates = tree[AT_FIELDS] + 6 * (elements + 1) * k, tree[AT_RATES] + 6 * (elements + 1) * k
    second, right = tree[AT_SECOND_RATES], tree[AT_RIGHT]
    for i in range(6):
        memory[second + 6 * elements + i] = 0.0
    for e in range(elements):
        parent = tree[tree[AT_ELEMENTS] + ELEMENT_INTEGERS * e + PARENT]
        p = 6 * (parent if parent >= 0 else elements)
        o, v, a = 6 * e, V + 6 * e, A + 6 * e
        x0 = memory[X + o] - memory[X + p]
        x1 = memory[X + o + 1] - memory[X + p + 1]
        x2 = memory[X + o + 2] - memory[X + p + 2]
        x3 = memory[X + o + 3] - memory[X + p + 3]
        x4 = memory[X + o + 4] - memory[X + p + 4]
        x5 = memory[X + o + 5] - memory[X + p + 5]
        v0, v1, v2 = memory[v], memory[v + 1], memory[v + 2]
        v3, v4, v5 = memory[v + 3], memory[v + 4], memory[v + 5]
        # 2 Ẋ − V × X of the joint
        k0, k1 = rates + o, rates + p
        y0 = 2.0 * (memory[k0] - memory[k1]) - (v4 * x2 - v5 * x1 + v1 * x5 - v2 * x4)
        y1 = 2.0 * (memory[k0 + 1] - memory[k1 + 1]) - (v5 * x0 - v3 * x2 + v2 * x3 - v0 * x5)
        y2 = 2.0 * (memory[k0 + 2] - memory[k1 + 2]) - (v3 * x1 - v4 * x0 + v0 * x4 - v1 * x3)
        y3 = 2.0 * (memory[k0 + 3] - memory[k1 + 3]) - (v4 * x5 - v5 * x4)
        y4 = 2.0 * (memory[k0 + 4] - memory[k1 + 4]) - (v5 * x3 - v3 * x5)
        y5 = 2.0 * (memory[k0 + 5] - memory[k1 + 5]) - (v3 * x4 - v4 * x3)
        a0, a1, a2 = memory[a], memory[a + 1], memory[a + 2]
        a3, a4, a5 = memory[a + 3], memory[a + 4], memory[a + 5]
        o, p = second + o, second + p
        memory[o] = memory[p] + a4 * x2 - a5 * x1 + a1 * x5 - a2 * x4
        memory[o] += v4 * y2 - v5 * y1 + v1 * y5 - v2 * y4
        memory[o + 1] = memory[p + 1] + a5 * x0 - a3 * x2 + a2 * x3 - a0 * x5
        memory[o + 1] += v5 * y0 - v3 * y2 + v2 * y3 - v0 * y5
        memory[o + 2] = memory[p + 2] + a3 * x1 - a4 * x0 + a0 * x4 - a1 * x3
        memory[o + 2] += v3 * y1 - v4 * y0 + v0 * y4 - v1 * y3
        memory[o + 3] = memory[p + 3] + a4 * x5 - a5 * x4 + v4 * y5 - v5 * y4
        memory[o + 4] = memory[p + 4] + a5 * x3 - a3 * x5 + v5 * y3 - v3 * y5
        memory[o + 5] = memory[p + 5] + a3 * x4 - a4 * x3 + v3 * y4 - v4 * y3
    if tree[GROUPS] == 0:
        return
    for group in range(tree[GROUPS]):
        _accelerated_again(tree, numbers, memory, group, k)
        for i in range(tree[tree[AT_GROUPS] + GROUP_INTEGERS * group + GROUP_ROWS]):
            memory[right + i] = -memory[right + i]
        spread(tree, memory, group, tree[AT_JOINT_LOADS])
    add_change(tree, memory, tree[AT_JOINT_LOADS], second)


@compiled
def _accelerated_again(tree, numbers, memory, group, k):
    """Write the second rate of J z in a closed group, for z a column of L whose own is left out.

    J z is zero all the time, so that no rate of the axes of its rows matters.
    """
    base, nv = tree[ELEMENTS], tree[VELOCITIES]
    V, A, second = tree[AT_VELOCITIES], tree[AT_ACCELERATIONS], tree[AT_SECOND_RATES]
    X, rates = tree[AT_FIELDS] + 6 * (base + 1) * k, tree[AT_RATES] + 6 * (base + 1) * k
    g = tree[AT_GROUPS] + GROUP_INTEGERS * group
    for closure in range(tree[g + FIRST_CLOSURE], tree[g + GROUP_INTEGERS + FIRST_CLOSURE]):
        c, f = tree[AT_CLOSURES] + CLOSURE_INTEGERS * closure, tree[AT_FRAMES] + 24 * closure
        kind, row = tree[c + CLOSURE_KIND], tree[AT_RIGHT] + tree[c + FIRST_ROW]
        one, two = tree[c + FIRST_END], tree[c + SECOND_END]
        if kind == COUPLING:
            at = tree[AT_CLOSURE_FRAMES] + CLOSURE_NUMBERS * closure
            x, v = memory[tree[AT_CONFIGURATION] + two], tree[c + COUPLED_SPEED]
            speed = memory[tree[AT_JOINT_SPEEDS] + v]
            bend = polynomial(numbers, at, x, 2)
            change = polynomial(numbers, at, x, 3) * speed * speed
            change += bend * memory[tree[AT_JOINT_ACCELERATIONS] + v]
            memory[row] = -(
                change * memory[tree[AT_COMPLEMENT] + nv * k + v]
                + 2.0 * bend * speed * memory[tree[AT_COMPLEMENT_RATES] + nv * k + v]
            )
            continue
        a = 6 * (one if one >= 0 else base)
        b = 6 * (two if two >= 0 else base)
        # How the point moves, and how the second body turns against the first: X, Ẋ and Ẍ.
        x, y, z = memory[f + 21], memory[f + 22], memory[f + 23]
        wx, wy, wz = memory[V + b + 3], memory[V + b + 4], memory[V + b + 5]
        vx = memory[V + b] + wy * z - wz * y
        vy = memory[V + b + 1] + wz * x - wx * z
        vz = memory[V + b + 2] + wx * y - wy * x
        ex, ey, ez = memory[A + b + 3], memory[A + b + 4], memory[A + b + 5]
        ax = memory[A + b] + ey * z - ez * y + wy * vz - wz * vy
        ay = memory[A + b + 1] + ez * x - ex * z + wz * vx - wx * vz
        az = memory[A + b + 2] + ex * y - ey * x + wx * vy - wy * vx
        p, o = X + 3 + b, X + 3 + a
        tx, ty, tz = (
            memory[p] - memory[o],
            memory[p + 1] - memory[o + 1],
            memory[p + 2] - memory[o + 2],
        )
        p, o = rates + 3 + b, rates + 3 + a
        rx, ry, rz = (
            memory[p] - memory[o],
            memory[p + 1] - memory[o + 1],
            memory[p + 2] - memory[o + 2],
        )
        rx, ry, rz = 2.0 * rx, 2.0 * ry, 2.0 * rz
        p, o = second + b, second + a
        sx, sy, sz = (
            memory[p + 3] - memory[o + 3],
            memory[p + 4] - memory[o + 4],
            memory[p + 5] - memory[o + 5],
        )
        bx = memory[p] - memory[o] + sy * z - sz * y + ry * vz - rz * vy + ty * az - tz * ay
        by = memory[p + 1] - memory[o + 1] + sz * x - sx * z + rz * vx - rx * vz + tz * ax - tx * az
        bz = memory[p + 2] - memory[o + 2] + sx * y - sy * x + rx * vy - ry * vx + tx * ay - ty * ax
        for i in range(3):
            memory[row + i] = memory[f + i] * bx + memory[f + 3 + i] * by + memory[f + 6 + i] * bz
        if kind == POINT:
            continue
        bx, by, bz = sx, sy, sz
        if kind == HINGE:
            x, y, z = memory[f + 14], memory[f + 17], memory[f + 20]
            vx, vy, vz = wy * z - wz * y, wz * x - wx * z, wx * y - wy * x
            ax = ey * z - ez * y + wy * vz - wz * vy
            ay = ez * x - ex * z + wz * vx - wx * vz
            az = ex * y - ey * x + wx * vy - wy * vx
            bx = sy * z - sz * y + ry * vz - rz * vy + ty * az - tz * ay
            by = sz * x - sx * z + rz * vx - rx * vz + tz * ax - tx * az
            bz = sx * y - sy * x + rx * vy - ry * vx + tx * ay - ty * ax
        for i in range(3 if kind == FRAME else 2):
            memory[row + 3 + i] = (
                memory[f + i] * bx + memory[f + 3 + i] * by + memory[f + 6 + i] * bz
            )


@compiled
def _along_position(tree, numbers, memory, k):
    """Write how the wrenches of all elements and the loads of joints change with position k."""
    elements, T, nv = tree[ELEMENTS], tree[AT_FIELD_FORCES], tree[VELOCITIES]
    wide, second, loads = 6 * (elements + 1), tree[AT_SECOND_RATES], tree[AT_LOADS]
    X, rates = tree[AT_FIELDS] + wide * k, tree[AT_RATES] + wide * k
    L, change = tree[AT_COMPLEMENT] + nv * k, tree[AT_COMPLEMENT_RATES] + nv * k
    for i in range(6 * elements):
        memory[T + i] = 0.0
    _turn_weight(tree, numbers, memory, X)
    for body in range(tree[BODIES]):
        e = tree[tree[AT_MASSIVE] + body]
        momentum(tree, memory, e, second + 6 * e, T + 6 * e)
        _add_spin(tree, memory, e, rates + 6 * e, T + 6 * e)
    for e in range(elements):
        row = tree[AT_ELEMENTS] + ELEMENT_INTEGERS * e
        parent, first = tree[row + PARENT], tree[row + INDEX_V]
        p = 6 * (parent if parent >= 0 else elements)
        _add_moving(memory, X + 6 * e, X + p, loads + 6 * e, T + 6 * e)
        for velocity in range(first, first + tree[row + FREEDOMS]):
            joint, at = tree[AT_JOINTS] + JOINT_NUMBERS * velocity, tree[AT_JOINT_LOADS] + velocity
            # The loads begin with the second rate of L.
            memory[at] = (
                numbers[joint] * memory[at] + numbers[joint + 1] * memory[change + velocity]
            )
        if tree[row + KIND] == SCREW:
            joint = tree[AT_JOINTS] + JOINT_NUMBERS * first
            memory[tree[AT_JOINT_LOADS] + first] += numbers[joint + 2] * memory[L + first]
        elif tree[row + KIND] != UNBOUNDED:
            _turn_joint(tree, numbers, memory, k, first, tree[row + FREEDOMS])
    for group in range(tree[GROUPS]):
        _turn_closures(tree, numbers, memory, group, k)


@inlined
def _turn_weight(tree, numbers, memory, X):
    """Take the free fall, which does not turn with the elements, from the second rates."""
    g, second = tree[AT_FREE_FALL], tree[AT_SECOND_RATES]
    x, y, z = numbers[g], numbers[g + 1], numbers[g + 2]
    for body in range(tree[BODIES]):
        e = 6 * tree[tree[AT_MASSIVE] + body]
        wx, wy, wz = memory[X + e + 3], memory[X + e + 4], memory[X + e + 5]
        memory[second + e] += wy * z - wz * y
        memory[second + e + 1] += wz * x - wx * z
        memory[second + e + 2] += wx * y - wy * x


@inlined
def _add_moving(memory, X, parent, force, out):
    """Add the cross product of a joint's twist with the wrench that it carries."""
    x0, x1, x2 = (
        memory[X] - memory[parent],
        memory[X + 1] - memory[parent + 1],
        memory[X + 2] - memory[parent + 2],
    )
    x3, x4, x5 = (
        memory[X + 3] - memory[parent + 3],
        memory[X + 4] - memory[parent + 4],
        memory[X + 5] - memory[parent + 5],
    )
    f0, f1, f2 = memory[force], memory[force + 1], memory[force + 2]
    f3, f4, f5 = memory[force + 3], memory[force + 4], memory[force + 5]
    memory[out] += x4 * f2 - x5 * f1
    memory[out + 1] += x5 * f0 - x3 * f2
    memory[out + 2] += x3 * f1 - x4 * f0
    memory[out + 3] += x4 * f5 - x5 * f4 + x1 * f2 - x2 * f1
    memory[out + 4] += x5 * f3 - x3 * f5 + x2 * f0 - x0 * f2
    memory[out + 5] += x3 * f4 - x4 * f3 + x0 * f1 - x1 * f0


@compiled
def _turn_joint(tree, numbers, memory, k, first, count):
    """Add to the loads of a ball or a free flyer what its motors and damping do in its axes.

    Its axes turn: derivatives of its twists by two coordinates differ by their bracket, and so does
    the force that these twists meet.
    """
    nv = tree[VELOCITIES]
    L, change = tree[AT_COMPLEMENT] + nv * k + first, tree[AT_COMPLEMENT_RATES] + nv * k + first
    speed, faster = tree[AT_JOINT_SPEEDS] + first, tree[AT_JOINT_ACCELERATIONS] + first
    _add_bracket(tree, numbers, memory, 1, speed, L, first, count)
    _add_bracket(tree, numbers, memory, 0, faster, L, first, count)
    _add_bracket(tree, numbers, memory, 0, speed, change, first, count)
    force, turned = tree[AT_BRACKETS], tree[AT_BRACKETS] + 6
    for i in range(count):
        joint = tree[AT_JOINTS] + JOINT_NUMBERS * (first + i)
        memory[force + i] = (
            numbers[joint] * memory[faster + i] + numbers[joint + 1] * memory[speed + i]
        )
    _dual_bracket(memory, L, force, count, turned)
    for i in range(count):
        memory[tree[AT_JOINT_LOADS] + first + i] += memory[turned + i]


@compiled
def _turn_closures(tree, numbers, memory, group, k):
    """Add what the forces in a group's loops do because their closures turn and bend."""
    base, nv, T = tree[ELEMENTS], tree[VELOCITIES], tree[AT_FIELD_FORCES]
    X = tree[AT_FIELDS] + 6 * (base + 1) * k
    g = tree[AT_GROUPS] + GROUP_INTEGERS * group
    for closure in range(tree[g + FIRST_CLOSURE], tree[g + GROUP_INTEGERS + FIRST_CLOSURE]):
        c, f = tree[AT_CLOSURES] + CLOSURE_INTEGERS * closure, tree[AT_FRAMES] + 24 * closure
        kind, o = tree[c + CLOSURE_KIND], tree[AT_LOOP_FORCES] + 6 * closure
        one, two = tree[c + FIRST_END], tree[c + SECOND_END]
        if kind == COUPLING:
            at = tree[AT_CLOSURE_FRAMES] + CLOSURE_NUMBERS * closure
            x, v = memory[tree[AT_CONFIGURATION] + two], tree[c + COUPLED_SPEED]
            bend = polynomial(numbers, at, x, 2)
            memory[tree[AT_JOINT_LOADS] + v] -= (
                memory[o] * bend * memory[tree[AT_COMPLEMENT] + nv * k + v]
            )
            continue
        # Joined frames do not turn against each other, and the base does not move.
        if kind == FRAME or two < 0:
            continue
        a, b, out = X + 6 * (one if one >= 0 else base) + 3, X + 6 * two + 3, T + 6 * two
        wx, wy, wz = (
            memory[b] - memory[a],
            memory[b + 1] - memory[a + 1],
            memory[b + 2] - memory[a + 2],
        )
        x, y, z = memory[o], memory[o + 1], memory[o + 2]
        fx, fy, fz = y * wz - z * wy, z * wx - x * wz, x * wy - y * wx
        x, y, z = memory[f + 21], memory[f + 22], memory[f + 23]
        mx, my, mz = y * fz - z * fy, z * fx - x * fz, x * fy - y * fx
        if kind == HINGE:
            x, y, z = memory[o + 3], memory[o + 4], memory[o + 5]
            ux, uy, uz = y * wz - z * wy, z * wx - x * wz, x * wy - y * wx
            x, y, z = memory[f + 14], memory[f + 17], memory[f + 20]
            mx, my, mz = mx + y * uz - z * uy, my + z * ux - x * uz, mz + x * uy - y * ux
        memory[out] += fx
        memory[out + 1] += fy
        memory[out + 2] += fz
        memory[out + 3] += mx
        memory[out + 4] += my
        memory[out + 5] += mz


@compiled
def _bring(tree, memory, out):
    """Add to n independent forces what wrenches of all elements and loads of joints make of them.

    The wrenches are summed up over what each element carries.
    """
    n, nv, L = tree[INDEPENDENT], tree[VELOCITIES], tree[AT_COMPLEMENT]
    T, screws = tree[AT_FIELD_FORCES], tree[AT_SCREWS]
    for e in range(tree[ELEMENTS] - 1, -1, -1):
        row, o = tree[AT_ELEMENTS] + ELEMENT_INTEGERS * e, T + 6 * e
        parent, first = tree[row + PARENT], tree[row + INDEX_V]
        t0, t1, t2 = memory[o], memory[o + 1], memory[o + 2]
        t3, t4, t5 = memory[o + 3], memory[o + 4], memory[o + 5]
        for velocity in range(first, first + tree[row + FREEDOMS]):
            s = screws + 6 * velocity
            force = memory[tree[AT_JOINT_LOADS] + velocity] + (
                memory[s] * t0
                + memory[s + 1] * t1
                + memory[s + 2] * t2
                + (memory[s + 3] * t3 + memory[s + 4] * t4 + memory[s + 5] * t5)
            )
            for i in range(n):
                memory[out + i] += memory[L + nv * i + velocity] * force
        if parent >= 0:
            p = T + 6 * parent
            memory[p] += t0
            memory[p + 1] += t1
            memory[p + 2] += t2
            memory[p + 3] += t3
            memory[p + 4] += t4
            memory[p + 5] += t5
