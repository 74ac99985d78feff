"""Compiled inertias, momenta and forces of the bodies of a pose.

All are about the base's origin, or about a floating base, in base axes.
"""

from __future__ import annotations

from fuzzy2.support.compiled import scalar
from psp3.multibody.tree import (
    AT_ACCELERATIONS,
    AT_BODIES,
    AT_FREE_FALL,
    AT_INERTIAS,
    AT_MASSIVE,
    AT_PLACEMENTS,
    AT_VELOCITIES,
    BODIES,
    CENTER_AT,
    ELEMENT_NUMBERS,
    INERTIA_AT,
    MASS_AT,
)


@scalar
def weigh(tree, numbers, memory):
    """Write the inertias of all elements about the base's origin, in base axes (10).

    The numbers are mass, mass times center of mass, and moments (xx, xy, xz, yy, yz, zz).
    """
    for body in range(tree[BODIES]):
        e = tree[tree[AT_MASSIVE] + body]
        o, m = tree[AT_PLACEMENTS] + 12 * e, tree[AT_BODIES] + ELEMENT_NUMBERS * e
        mass = numbers[m + MASS_AT]
        x, y, z = numbers[m + CENTER_AT], numbers[m + CENTER_AT + 1], numbers[m + CENTER_AT + 2]
        r0, r1, r2 = memory[o], memory[o + 1], memory[o + 2]
        r3, r4, r5 = memory[o + 3], memory[o + 4], memory[o + 5]
        r6, r7, r8 = memory[o + 6], memory[o + 7], memory[o + 8]
        cx = r0 * x + r1 * y + r2 * z + memory[o + 9]
        cy = r3 * x + r4 * y + r5 * z + memory[o + 10]
        cz = r6 * x + r7 * y + r8 * z + memory[o + 11]
        hx, hy, hz = mass * cx, mass * cy, mass * cz
        i = m + INERTIA_AT
        xx, xy, xz = numbers[i], numbers[i + 1], numbers[i + 2]
        yy, yz, zz = numbers[i + 3], numbers[i + 4], numbers[i + 5]
        ax, ay, az = (
            r0 * xx + r1 * xy + r2 * xz,
            r0 * xy + r1 * yy + r2 * yz,
            r0 * xz + r1 * yz + r2 * zz,
        )
        bx, by, bz = (
            r3 * xx + r4 * xy + r5 * xz,
            r3 * xy + r4 * yy + r5 * yz,
            r3 * xz + r4 * yz + r5 * zz,
        )
        dx, dy, dz = (
            r6 * xx + r7 * xy + r8 * xz,
            r6 * xy + r7 * yy + r8 * yz,
            r6 * xz + r7 * yz + r8 * zz,
        )
        k = tree[AT_INERTIAS] + 10 * e
        memory[k], memory[k + 1], memory[k + 2], memory[k + 3] = mass, hx, hy, hz
        memory[k + 4] = ax * r0 + ay * r1 + az * r2 + hy * cy + hz * cz
        memory[k + 5] = ax * r3 + ay * r4 + az * r5 - hx * cy
        memory[k + 6] = ax * r6 + ay * r7 + az * r8 - hx * cz
        memory[k + 7] = bx * r3 + by * r4 + bz * r5 + hx * cx + hz * cz
        memory[k + 8] = bx * r6 + by * r7 + bz * r8 - hy * cz
        memory[k + 9] = dx * r6 + dy * r7 + dz * r8 + hx * cx + hy * cy


@scalar
def momentum(tree, memory, e, X, out):
    """Write the momentum of an element that moves with a twist, and its moment about the base."""
    k = tree[AT_INERTIAS] + 10 * e
    mass, hx, hy, hz = memory[k], memory[k + 1], memory[k + 2], memory[k + 3]
    xx, xy, xz = memory[k + 4], memory[k + 5], memory[k + 6]
    yy, yz, zz = memory[k + 7], memory[k + 8], memory[k + 9]
    vx, vy, vz = memory[X], memory[X + 1], memory[X + 2]
    wx, wy, wz = memory[X + 3], memory[X + 4], memory[X + 5]
    memory[out] = mass * vx + wy * hz - wz * hy
    memory[out + 1] = mass * vy + wz * hx - wx * hz
    memory[out + 2] = mass * vz + wx * hy - wy * hx
    memory[out + 3] = xx * wx + xy * wy + xz * wz + hy * vz - hz * vy
    memory[out + 4] = xy * wx + yy * wy + yz * wz + hz * vx - hx * vz
    memory[out + 5] = xz * wx + yz * wy + zz * wz + hx * vy - hy * vx


@scalar
def wrench(tree, numbers, memory, e, out):
    """Write the force that moves an element and carries its weight, and its torque at the base.

    It is I A + V ×* I V, where the free fall is subtracted from A.
    """
    v, a = tree[AT_VELOCITIES] + 6 * e, tree[AT_ACCELERATIONS] + 6 * e
    g, k = tree[AT_FREE_FALL], tree[AT_INERTIAS] + 10 * e
    momentum(tree, memory, e, v, out)
    p0, p1, p2 = memory[out], memory[out + 1], memory[out + 2]
    p3, p4, p5 = memory[out + 3], memory[out + 4], memory[out + 5]
    v0, v1, v2 = memory[v], memory[v + 1], memory[v + 2]
    v3, v4, v5 = memory[v + 3], memory[v + 4], memory[v + 5]
    momentum(tree, memory, e, a, out)
    mass, hx, hy, hz = memory[k], memory[k + 1], memory[k + 2], memory[k + 3]
    g0, g1, g2 = numbers[g], numbers[g + 1], numbers[g + 2]
    memory[out] += v4 * p2 - v5 * p1 - mass * g0
    memory[out + 1] += v5 * p0 - v3 * p2 - mass * g1
    memory[out + 2] += v3 * p1 - v4 * p0 - mass * g2
    memory[out + 3] += v4 * p5 - v5 * p4 + v1 * p2 - v2 * p1 - (hy * g2 - hz * g1)
    memory[out + 4] += v5 * p3 - v3 * p5 + v2 * p0 - v0 * p2 - (hz * g0 - hx * g2)
    memory[out + 5] += v3 * p4 - v4 * p3 + v0 * p1 - v1 * p0 - (hx * g1 - hy * g0)
