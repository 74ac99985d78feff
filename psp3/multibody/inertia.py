r"""Compiled mass matrix, Coriolis matrix, gravity and energies of a closed pose.

With :math:`X_j` the twists of all elements at unit speed of the independent coordinate j, the mass
matrix is :math:`\sum X_i^T I X_j`, and the matrix of Christoffel symbols

.. math:: C_{ij} = \sum X_i^T \big( I (\dot X_j - \tfrac12 V \times X_j)
          + \tfrac12 V \times^* I X_j + \tfrac12 X_j \times^* I V \big)
          + \sum L_i^T R \dot L_j

with R the inertias of the motors, which move with their joints. For a ball joint, :math:`\tfrac12
\omega \times L_j` is added to its rows of :math:`\dot L_j`, because its speeds are not rates of
coordinates. (The factor of a single body after S. Echeandia and P. M. Wensing, Numerical methods to
compute the Coriolis matrix and Christoffel symbols for rigid-body systems, Journal of Computational
and Nonlinear Dynamics 16, 2021, here in base axes.)
"""

from __future__ import annotations

import math

from fuzzy2.support.compiled import scalar
from psp3.multibody.bodies import momentum
from psp3.multibody.forces import (
    add_change,
    carried,
    change_of_joint_speeds,
    joint_speeds,
    twists,
)
from psp3.multibody.tree import (
    AT_ACCELERATIONS,
    AT_BODIES,
    AT_COMPLEMENT,
    AT_COMPLEMENT_RATES,
    AT_CONFIGURATION,
    AT_ELEMENTS,
    AT_FIELDS,
    AT_FORCES,
    AT_FREE_FALL,
    AT_HERE,
    AT_JOINT_SPEEDS,
    AT_JOINTS,
    AT_MASSIVE,
    AT_PLACEMENTS,
    AT_RATES,
    AT_RESTS,
    AT_ROOM,
    AT_VELOCITIES,
    BALL,
    BODIES,
    CENTER_AT,
    DAMPING,
    ELEMENT_INTEGERS,
    ELEMENT_NUMBERS,
    ELEMENTS,
    FREEDOMS,
    FRICTION,
    INDEPENDENT,
    INDEX_Q,
    INDEX_V,
    JOINT_NUMBERS,
    KIND,
    MASS_AT,
    SCREW,
    VELOCITIES,
)


@scalar
def complement(tree, numbers, memory, with_rates):
    """Write L, column by column, the twists of its columns, and the rates of change of both.

    The rates are written only if ``with_rates`` is 1.0; the memory must then hold the elements' own
    twists.
    """
    n, nv, elements = tree[INDEPENDENT], tree[VELOCITIES], tree[ELEMENTS]
    unit = tree[AT_ROOM]
    for j in range(n):
        memory[unit + j] = 0.0
    for j in range(n):
        column = tree[AT_COMPLEMENT] + nv * j
        memory[unit + j] = 1.0
        joint_speeds(tree, memory, unit, column)
        memory[unit + j] = 0.0
        X = tree[AT_FIELDS] + 6 * (elements + 1) * j
        rate = tree[AT_RATES] + 6 * (elements + 1) * j
        if with_rates == 0.0:
            twists(tree, memory, column, X)
        else:
            carried(tree, memory, column, X, rate)
            change = tree[AT_COMPLEMENT_RATES] + nv * j
            for velocity in range(nv):
                memory[change + velocity] = 0.0
            change_of_joint_speeds(tree, numbers, memory, column, X, rate, change)
            add_change(tree, memory, change, rate)


@scalar
def _power(tree, memory, X, P):
    """Return the sum over all elements of twists times wrenches."""
    value = 0.0
    for body in range(tree[BODIES]):
        e = tree[tree[AT_MASSIVE] + body]
        o, k = X + 6 * e, P + 6 * e
        value += (
            memory[o] * memory[k]
            + memory[o + 1] * memory[k + 1]
            + memory[o + 2] * memory[k + 2]
            + (
                memory[o + 3] * memory[k + 3]
                + memory[o + 4] * memory[k + 4]
                + memory[o + 5] * memory[k + 5]
            )
        )
    return value


@scalar
def _momenta(tree, memory, X, out):
    """Write the momenta of all elements that have mass."""
    for body in range(tree[BODIES]):
        e = tree[tree[AT_MASSIVE] + body]
        momentum(tree, memory, e, X + 6 * e, out + 6 * e)


@scalar
def mass_matrix(tree, numbers, memory, out):
    """Write the mass matrix (n²) from L and its twists; the elements' forces are overwritten."""
    n, nv, L = tree[INDEPENDENT], tree[VELOCITIES], tree[AT_COMPLEMENT]
    X, wide, P = tree[AT_FIELDS], 6 * (tree[ELEMENTS] + 1), tree[AT_FORCES]
    for j in range(n):
        _momenta(tree, memory, X + wide * j, P)
        for i in range(j + 1):
            value = _power(tree, memory, X + wide * i, P)
            for velocity in range(nv):
                motor = numbers[tree[AT_JOINTS] + JOINT_NUMBERS * velocity]
                if motor != 0.0:
                    value += motor * memory[L + nv * i + velocity] * memory[L + nv * j + velocity]
            memory[out + n * i + j] = value
            memory[out + n * j + i] = value


@scalar
def gravity(tree, numbers, memory, out):
    """Write the forces of gravity and of springs (n) from L and its twists."""
    n, nv, L = tree[INDEPENDENT], tree[VELOCITIES], tree[AT_COMPLEMENT]
    X, wide, P = tree[AT_FIELDS], 6 * (tree[ELEMENTS] + 1), tree[AT_FORCES]
    q, g = tree[AT_CONFIGURATION], tree[AT_FREE_FALL]
    for j in range(n):
        value = 0.0
        for body in range(tree[BODIES]):
            e = tree[tree[AT_MASSIVE] + body]
            momentum(tree, memory, e, X + wide * j + 6 * e, P)
            for i in range(3):
                value -= memory[P + i] * numbers[g + i]
        for e in range(tree[ELEMENTS]):
            row = tree[AT_ELEMENTS] + ELEMENT_INTEGERS * e
            if tree[row + KIND] == SCREW:
                velocity, at = tree[row + INDEX_V], tree[row + INDEX_Q]
                stiffness = numbers[tree[AT_JOINTS] + JOINT_NUMBERS * velocity + 2]
                stretch = memory[q + at] - numbers[tree[AT_RESTS] + at]
                value += memory[L + nv * j + velocity] * stiffness * stretch
        memory[out + j] = value


@scalar
def coriolis_matrix(tree, numbers, memory, out):
    """Write the matrix of Christoffel symbols (n²) from L, its twists and their rates.

    The elements' forces and accelerations are overwritten.
    """
    n, wide = tree[INDEPENDENT], 6 * (tree[ELEMENTS] + 1)
    X, rates, P = tree[AT_FIELDS], tree[AT_RATES], tree[AT_FORCES]
    H = tree[AT_ACCELERATIONS]
    _momenta(tree, memory, tree[AT_VELOCITIES], H)
    for j in range(n):
        for body in range(tree[BODIES]):
            e = tree[tree[AT_MASSIVE] + body]
            at = wide * j + 6 * e
            _coriolis_wrench(tree, memory, e, X + at, rates + at, H, P + 6 * e)
        for i in range(n):
            memory[out + n * i + j] = _power(tree, memory, X + wide * i, P)
    _add_motors(tree, numbers, memory, out)


@scalar
def _add_motors(tree, numbers, memory, out):
    """Add the contribution of the motor inertias to the matrix of Christoffel symbols."""
    n, nv = tree[INDEPENDENT], tree[VELOCITIES]
    L, rates, z = tree[AT_COMPLEMENT], tree[AT_COMPLEMENT_RATES], tree[AT_JOINT_SPEEDS]
    for e in range(tree[ELEMENTS]):
        row = tree[AT_ELEMENTS] + ELEMENT_INTEGERS * e
        first, kind = tree[row + INDEX_V], tree[row + KIND]
        for k in range(tree[row + FREEDOMS]):
            motor = numbers[tree[AT_JOINTS] + JOINT_NUMBERS * (first + k)]
            if motor == 0.0:
                continue
            # The two axes after this one, in cyclic order.
            one, two = first + (k + 1) % 3, first + (k + 2) % 3
            for j in range(n):
                column = L + nv * j
                rate = memory[rates + nv * j + first + k]
                if kind == BALL:
                    rate += 0.5 * (
                        memory[z + one] * memory[column + two]
                        - memory[z + two] * memory[column + one]
                    )
                for i in range(n):
                    memory[out + n * i + j] += motor * memory[L + nv * i + first + k] * rate


@scalar
def add_damping(tree, numbers, memory, out):
    r"""Add damping and dry friction to a matrix (n²), whose product with the speeds is a force.

    This adds :math:`L^T D L`, with D the joints' viscous damping and, if they slip, their dry
    friction divided by their speed.
    """
    n, nv, L = tree[INDEPENDENT], tree[VELOCITIES], tree[AT_COMPLEMENT]
    for velocity in range(nv):
        joint = tree[AT_JOINTS] + JOINT_NUMBERS * velocity
        damping, speed = numbers[joint + DAMPING], memory[tree[AT_JOINT_SPEEDS] + velocity]
        if speed != 0.0:
            damping += numbers[joint + FRICTION] / abs(speed)
        if damping != 0.0:
            for i in range(n):
                share = damping * memory[L + nv * i + velocity]
                for j in range(n):
                    memory[out + n * i + j] += share * memory[L + nv * j + velocity]


@scalar
def _coriolis_wrench(tree, memory, e, X, rate, H, out):
    """Write the wrench of one element for one column of the Coriolis matrix.

    H are the momenta of the elements; the base's place among them is overwritten.
    """
    v, h, at = tree[AT_VELOCITIES] + 6 * e, H + 6 * e, H + 6 * tree[ELEMENTS]
    v0, v1, v2 = memory[v], memory[v + 1], memory[v + 2]
    v3, v4, v5 = memory[v + 3], memory[v + 4], memory[v + 5]
    x0, x1, x2 = memory[X], memory[X + 1], memory[X + 2]
    x3, x4, x5 = memory[X + 3], memory[X + 4], memory[X + 5]
    h0, h1, h2 = memory[h], memory[h + 1], memory[h + 2]
    h3, h4, h5 = memory[h + 3], memory[h + 4], memory[h + 5]
    momentum(tree, memory, e, X, at)
    p0, p1, p2 = memory[at], memory[at + 1], memory[at + 2]
    p3, p4, p5 = memory[at + 3], memory[at + 4], memory[at + 5]
    memory[at] = memory[rate] - 0.5 * (v4 * x2 - v5 * x1 + v1 * x5 - v2 * x4)
    memory[at + 1] = memory[rate + 1] - 0.5 * (v5 * x0 - v3 * x2 + v2 * x3 - v0 * x5)
    memory[at + 2] = memory[rate + 2] - 0.5 * (v3 * x1 - v4 * x0 + v0 * x4 - v1 * x3)
    memory[at + 3] = memory[rate + 3] - 0.5 * (v4 * x5 - v5 * x4)
    memory[at + 4] = memory[rate + 4] - 0.5 * (v5 * x3 - v3 * x5)
    memory[at + 5] = memory[rate + 5] - 0.5 * (v3 * x4 - v4 * x3)
    momentum(tree, memory, e, at, out)
    memory[out] += 0.5 * (v4 * p2 - v5 * p1 + x4 * h2 - x5 * h1)
    memory[out + 1] += 0.5 * (v5 * p0 - v3 * p2 + x5 * h0 - x3 * h2)
    memory[out + 2] += 0.5 * (v3 * p1 - v4 * p0 + x3 * h1 - x4 * h0)
    memory[out + 3] += 0.5 * (v4 * p5 - v5 * p4 + v1 * p2 - v2 * p1)
    memory[out + 3] += 0.5 * (x4 * h5 - x5 * h4 + x1 * h2 - x2 * h1)
    memory[out + 4] += 0.5 * (v5 * p3 - v3 * p5 + v2 * p0 - v0 * p2)
    memory[out + 4] += 0.5 * (x5 * h3 - x3 * h5 + x2 * h0 - x0 * h2)
    memory[out + 5] += 0.5 * (v3 * p4 - v4 * p3 + v0 * p1 - v1 * p0)
    memory[out + 5] += 0.5 * (x3 * h4 - x4 * h3 + x0 * h1 - x1 * h0)


@scalar
def kinetic_energy(tree, numbers, memory):
    """Return the kinetic energy [J] of the elements' twists and of the motors' own inertia."""
    V, P = tree[AT_VELOCITIES], tree[AT_FORCES]
    _momenta(tree, memory, V, P)
    energy = 0.5 * _power(tree, memory, V, P)
    for velocity in range(tree[VELOCITIES]):
        speed = memory[tree[AT_JOINT_SPEEDS] + velocity]
        energy += 0.5 * numbers[tree[AT_JOINTS] + JOINT_NUMBERS * velocity] * speed * speed
    return energy


@scalar
def potential_energy(tree, numbers, memory):
    """Return the potential energy [J] of gravity, zero at the base's origin, and of springs."""
    energy, q, g = 0.0, tree[AT_CONFIGURATION], tree[AT_FREE_FALL]
    for e in range(tree[ELEMENTS]):
        row, o = tree[AT_ELEMENTS] + ELEMENT_INTEGERS * e, tree[AT_PLACEMENTS] + 12 * e
        m = tree[AT_BODIES] + ELEMENT_NUMBERS * e
        for i in range(3):
            center = memory[tree[AT_HERE] + i] + memory[o + 9 + i]
            for k in range(3):
                center += memory[o + 3 * i + k] * numbers[m + CENTER_AT + k]
            energy -= numbers[m + MASS_AT] * numbers[g + i] * center
        if tree[row + KIND] == SCREW:
            velocity, at = tree[row + INDEX_V], tree[row + INDEX_Q]
            stretch = memory[q + at] - numbers[tree[AT_RESTS] + at]
            stiffness = numbers[tree[AT_JOINTS] + JOINT_NUMBERS * velocity + 2]
            energy += 0.5 * stiffness * stretch * stretch
    return energy


@scalar
def factor_positive(memory, matrix, order):
    """Overwrite a symmetric matrix (n²) with Cholesky's factor.

    Return whether it is positive definite.
    """
    for k in range(order):
        d = matrix + order * k
        value = memory[d + k]
        for j in range(k):
            value -= memory[d + j] * memory[d + j]
        if not value > 0.0:
            return False
        value = math.sqrt(value)
        memory[d + k] = value
        for i in range(k + 1, order):
            c = matrix + order * i
            rest = memory[c + k]
            for j in range(k):
                rest -= memory[c + j] * memory[d + j]
            memory[c + k] = rest / value
    return True


@scalar
def solve_positive(memory, matrix, order, right):
    """Replace the right side by the solution of a system whose matrix is factored."""
    for k in range(order):
        d = matrix + order * k
        value = memory[right + k]
        for j in range(k):
            value -= memory[d + j] * memory[right + j]
        memory[right + k] = value / memory[d + k]
    for k in range(order - 1, -1, -1):
        value = memory[right + k]
        for i in range(k + 1, order):
            value -= memory[matrix + order * i + k] * memory[right + i]
        memory[right + k] = value / memory[matrix + order * k + k]
