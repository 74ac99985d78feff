"""Compiled placements of the elements of a tree, and screws of their joints."""

from __future__ import annotations

import math

from fuzzy2.support.compiled import scalar
from psp3.multibody.tree import (
    AT_BODIES,
    AT_COLUMN_OF,
    AT_CONFIGURATION,
    AT_ELEMENTS,
    AT_HERE,
    AT_MEMBERS,
    AT_PLACEMENTS,
    AT_SCREWS,
    BALL,
    ELEMENT_INTEGERS,
    ELEMENT_NUMBERS,
    FLOATING,
    FREE,
    INDEX_Q,
    INDEX_V,
    KIND,
    PARENT,
    PLANAR,
    SCREW_AT,
    UNBOUNDED,
)


@scalar
def compose(a, i, b, j, out, k):
    """Write the product of two placements, which begin at entry i of a and at entry j of b."""
    for row in range(3):
        x, y, z = a[i + 3 * row], a[i + 3 * row + 1], a[i + 3 * row + 2]
        for column in range(3):
            out[k + 3 * row + column] = (
                x * b[j + column] + y * b[j + 3 + column] + z * b[j + 6 + column]
            )
        out[k + 9 + row] = x * b[j + 9] + y * b[j + 10] + z * b[j + 11] + a[i + 9 + row]


@scalar
def _turn_by_screw(numbers, at, amount, memory, o, s):
    """Move an element along its screw, which is of unit length or without rotation.

    The memory holds the fixed placement at o, which the result replaces; the screw is written to s.
    """
    a = at + SCREW_AT
    vx, vy, vz = numbers[a], numbers[a + 1], numbers[a + 2]
    wx, wy, wz = numbers[a + 3], numbers[a + 4], numbers[a + 5]
    r0, r1, r2 = memory[o], memory[o + 1], memory[o + 2]
    r3, r4, r5 = memory[o + 3], memory[o + 4], memory[o + 5]
    r6, r7, r8 = memory[o + 6], memory[o + 7], memory[o + 8]
    px, py, pz = memory[o + 9], memory[o + 10], memory[o + 11]
    Vx = r0 * vx + r1 * vy + r2 * vz
    Vy = r3 * vx + r4 * vy + r5 * vz
    Vz = r6 * vx + r7 * vy + r8 * vz
    if wx == 0.0 and wy == 0.0 and wz == 0.0:
        memory[o + 9], memory[o + 10], memory[o + 11] = (
            px + Vx * amount,
            py + Vy * amount,
            pz + Vz * amount,
        )
        memory[s], memory[s + 1], memory[s + 2] = Vx, Vy, Vz
        memory[s + 3], memory[s + 4], memory[s + 5] = 0.0, 0.0, 0.0
        return
    # The motion of the joint does not change its axis and a point on it.
    Wx = r0 * wx + r1 * wy + r2 * wz
    Wy = r3 * wx + r4 * wy + r5 * wz
    Wz = r6 * wx + r7 * wy + r8 * wz
    memory[s] = Vx + py * Wz - pz * Wy
    memory[s + 1] = Vy + pz * Wx - px * Wz
    memory[s + 2] = Vz + px * Wy - py * Wx
    memory[s + 3], memory[s + 4], memory[s + 5] = Wx, Wy, Wz
    sine, cosine = math.sin(amount), math.cos(amount)
    left = 1.0 - cosine
    t0, t1, t2 = cosine + left * wx * wx, left * wx * wy - sine * wz, left * wx * wz + sine * wy
    t3, t4, t5 = left * wx * wy + sine * wz, cosine + left * wy * wy, left * wy * wz - sine * wx
    t6, t7, t8 = left * wx * wz - sine * wy, left * wy * wz + sine * wx, cosine + left * wz * wz
    memory[o] = r0 * t0 + r1 * t3 + r2 * t6
    memory[o + 1] = r0 * t1 + r1 * t4 + r2 * t7
    memory[o + 2] = r0 * t2 + r1 * t5 + r2 * t8
    memory[o + 3] = r3 * t0 + r4 * t3 + r5 * t6
    memory[o + 4] = r3 * t1 + r4 * t4 + r5 * t7
    memory[o + 5] = r3 * t2 + r4 * t5 + r5 * t8
    memory[o + 6] = r6 * t0 + r7 * t3 + r8 * t6
    memory[o + 7] = r6 * t1 + r7 * t4 + r8 * t7
    memory[o + 8] = r6 * t2 + r7 * t5 + r8 * t8
    if vx != 0.0 or vy != 0.0 or vz != 0.0:
        # v amount + (1 − cos) w × v + (amount − sin) w × (w × v)
        cx, cy, cz = wy * vz - wz * vy, wz * vx - wx * vz, wx * vy - wy * vx
        rest = amount - sine
        ux = vx * amount + left * cx + rest * (wy * cz - wz * cy)
        uy = vy * amount + left * cy + rest * (wz * cx - wx * cz)
        uz = vz * amount + left * cz + rest * (wx * cy - wy * cx)
        memory[o + 9] = px + r0 * ux + r1 * uy + r2 * uz
        memory[o + 10] = py + r3 * ux + r4 * uy + r5 * uz
        memory[o + 11] = pz + r6 * ux + r7 * uy + r8 * uz


@scalar
def _turn_by_quaternion(memory, at, o):
    """Turn a placement by a unit quaternion (x, y, z, w) about its own origin."""
    x, y, z, w = memory[at], memory[at + 1], memory[at + 2], memory[at + 3]
    t0, t1, t2 = 1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)
    t3, t4, t5 = 2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)
    t6, t7, t8 = 2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)
    for i in range(3):
        k = o + 3 * i
        r0, r1, r2 = memory[k], memory[k + 1], memory[k + 2]
        memory[k] = r0 * t0 + r1 * t3 + r2 * t6
        memory[k + 1] = r0 * t1 + r1 * t4 + r2 * t7
        memory[k + 2] = r0 * t2 + r1 * t5 + r2 * t8


@scalar
def _spin_screws(memory, o, s):
    """Write the screws of the three rotations of a ball about its own axes."""
    px, py, pz = memory[o + 9], memory[o + 10], memory[o + 11]
    for axis in range(3):
        x, y, z = memory[o + axis], memory[o + 3 + axis], memory[o + 6 + axis]
        k = s + 6 * axis
        memory[k], memory[k + 1], memory[k + 2] = py * z - pz * y, pz * x - px * z, px * y - py * x
        memory[k + 3], memory[k + 4], memory[k + 5] = x, y, z


@scalar
def _shift(memory, q, count, o):
    """Translate a placement by the coordinates, along its first axes."""
    for i in range(3):
        way = 0.0
        for k in range(count):
            way += memory[o + 3 * i + k] * memory[q + k]
        memory[o + 9 + i] += way


@scalar
def _glide(memory, q, o, s):
    """Rotate a translated placement in its own x-y plane; write the three screws."""
    c, t = memory[q + 2], memory[q + 3]
    for i in range(3):
        k = o + 3 * i
        r0, r1 = memory[k], memory[k + 1]
        memory[k], memory[k + 1] = r0 * c + r1 * t, r1 * c - r0 * t
    for axis in range(2):
        for i in range(3):
            memory[s + 6 * axis + i] = memory[o + 3 * i + axis]
            memory[s + 6 * axis + 3 + i] = 0.0
    px, py, pz = memory[o + 9], memory[o + 10], memory[o + 11]
    x, y, z = memory[o + 2], memory[o + 5], memory[o + 8]
    k = s + 12
    memory[k], memory[k + 1], memory[k + 2] = py * z - pz * y, pz * x - px * z, px * y - py * x
    memory[k + 3], memory[k + 4], memory[k + 5] = x, y, z


@scalar
def _find_base(tree, numbers, memory):
    """Write the position of the floating base; zeros if there is none."""
    here, e = tree[AT_HERE], tree[FLOATING]
    for i in range(3):
        memory[here + i] = 0.0
    if e >= 0:
        row, at = tree[AT_ELEMENTS] + ELEMENT_INTEGERS * e, tree[AT_BODIES] + ELEMENT_NUMBERS * e
        q = tree[AT_CONFIGURATION] + tree[row + INDEX_Q]
        for i in range(3):
            memory[here + i] = numbers[at + 9 + i]
            for k in range(2 if tree[row + KIND] == PLANAR else 3):
                memory[here + i] += numbers[at + 3 * i + k] * memory[q + k]


@scalar
def place(tree, numbers, memory, first, last):
    """Place the members from ``first`` to ``last``; their parents come before them.

    Positions are relative to a floating base, so that no digits are lost if it is far away.
    """
    here, floating = tree[AT_HERE], tree[FLOATING]
    _find_base(tree, numbers, memory)
    configuration = tree[AT_CONFIGURATION]
    placements = tree[AT_PLACEMENTS]
    screws = tree[AT_SCREWS]
    bodies = tree[AT_BODIES]
    elements = tree[AT_ELEMENTS]
    members = tree[AT_MEMBERS]
    for member in range(first, last):
        e = tree[members + member]
        row, at, o = (
            elements + ELEMENT_INTEGERS * e,
            bodies + ELEMENT_NUMBERS * e,
            placements + 12 * e,
        )
        parent, kind = tree[row + PARENT], tree[row + KIND]
        q, s = configuration + tree[row + INDEX_Q], screws + 6 * tree[row + INDEX_V]
        if parent < 0:
            for i in range(9):
                memory[o + i] = numbers[at + i]
            for i in range(3):
                # The position of the base itself is exactly zero.
                away = numbers[at + 9 + i] - memory[here + i]
                memory[o + 9 + i] = 0.0 if e == floating else away
        else:
            compose(memory, placements + 12 * parent, numbers, at, memory, o)
        if kind <= UNBOUNDED:
            amount = math.atan2(memory[q + 1], memory[q]) if kind == UNBOUNDED else memory[q]
            _turn_by_screw(numbers, at, amount, memory, o, s)
        elif kind == PLANAR:
            if e != floating:
                _shift(memory, q, 2, o)
            _glide(memory, q, o, s)
        elif kind == BALL:
            _turn_by_quaternion(memory, q, o)
            _spin_screws(memory, o, s)
        else:
            if e != floating:
                _shift(memory, q, 3, o)
            _turn_by_quaternion(memory, q + 3, o)
            for axis in range(3):
                for i in range(3):
                    memory[s + 6 * axis + i] = memory[o + 3 * i + axis]
                    memory[s + 6 * axis + 3 + i] = 0.0
            _spin_screws(memory, o, s + 18)


@scalar
def move(tree, memory, first, last, start, step, column, share):
    """Move the dependent joints of members by a share of a step.

    The memory holds the initial configuration at ``start``, and at ``step`` the step, which begins
    with dependent speed number ``column``.
    """
    configuration = tree[AT_CONFIGURATION]
    column_of = tree[AT_COLUMN_OF]
    elements = tree[AT_ELEMENTS]
    members = tree[AT_MEMBERS]
    for member in range(first, last):
        row = elements + ELEMENT_INTEGERS * tree[members + member]
        k = tree[column_of + tree[row + INDEX_V]] - column
        if k + column < 0:
            continue
        kind, at = tree[row + KIND], tree[row + INDEX_Q]
        if kind <= UNBOUNDED:
            amount = share * memory[step + k]
            if kind == UNBOUNDED:
                c, s = math.cos(amount), math.sin(amount)
                x, y = memory[start + at], memory[start + at + 1]
                q = configuration + at
                memory[q], memory[q + 1] = x * c - y * s, y * c + x * s
            else:
                memory[configuration + at] = memory[start + at] + amount
        elif kind == PLANAR:
            k += step
            q, p = configuration + at, start + at
            vx, vy = share * memory[k], share * memory[k + 1]
            x, y = memory[p + 2], memory[p + 3]
            memory[q] = memory[p] + x * vx - y * vy
            memory[q + 1] = memory[p + 1] + y * vx + x * vy
            c, s = math.cos(share * memory[k + 2]), math.sin(share * memory[k + 2])
            memory[q + 2], memory[q + 3] = x * c - y * s, y * c + x * s
        else:
            k += step
            if kind == FREE:
                _slide(memory, start + at, k, share, configuration + at)
                at += 3
                k += 3
            _spin(memory, start + at, k, share, configuration + at)


@scalar
def _slide(memory, start, step, share, q):
    """Move the position of a free flyer by a share of a step in its own axes."""
    x, y, z, w = memory[start + 3], memory[start + 4], memory[start + 5], memory[start + 6]
    vx, vy, vz = share * memory[step], share * memory[step + 1], share * memory[step + 2]
    # v + 2 w (u × v) + 2 u × (u × v), with u the vector of the quaternion
    cx, cy, cz = 2.0 * (y * vz - z * vy), 2.0 * (z * vx - x * vz), 2.0 * (x * vy - y * vx)
    memory[q] = memory[start] + vx + w * cx + y * cz - z * cy
    memory[q + 1] = memory[start + 1] + vy + w * cy + z * cx - x * cz
    memory[q + 2] = memory[start + 2] + vz + w * cz + x * cy - y * cx


@scalar
def _spin(memory, start, step, share, q):
    """Turn a quaternion by a share of a rotation vector in its own axes."""
    x, y, z = share * memory[step], share * memory[step + 1], share * memory[step + 2]
    square = x * x + y * y + z * z
    angle = math.sqrt(square)
    half = 0.5 - square / 48.0 if angle < 1e-3 else math.sin(0.5 * angle) / angle
    bx, by, bz, bw = half * x, half * y, half * z, math.cos(0.5 * angle)
    ax, ay, az, aw = memory[start], memory[start + 1], memory[start + 2], memory[start + 3]
    cx = aw * bx + ax * bw + ay * bz - az * by
    cy = aw * by - ax * bz + ay * bw + az * bx
    cz = aw * bz + ax * by - ay * bx + az * bw
    cw = aw * bw - ax * bx - ay * by - az * bz
    norm = math.sqrt(cx * cx + cy * cy + cz * cz + cw * cw)
    memory[q], memory[q + 1] = cx / norm, cy / norm
    memory[q + 2], memory[q + 3] = cz / norm, cw / norm
