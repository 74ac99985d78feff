r"""Compiled motion and forces of a closed pose: velocities, accelerations, RNEA, projection.

All twists and wrenches are in base axes, about the base's origin or about a floating base. So the
force of a joint is the product of its screw and the total wrench on the elements that it carries
(recursive Newton–Euler algorithm, RNEA: J. Y. S. Luh, M. W. Walker and R. P. C. Paul, 1980). The
loops then project the forces of dependent joints onto the independent ones, :math:`\tau = L^T f`
(thesis eq. 3.37).
"""

from __future__ import annotations

from fuzzy2.support.compiled import scalar
from psp3.multibody.bodies import wrench
from psp3.multibody.closing import spread
from psp3.multibody.least_squares import solve_transposed
from psp3.multibody.loops import accelerated
from psp3.multibody.tree import (
    ARMATURE,
    AT_CONFIGURATION,
    AT_DEPENDENT_V,
    AT_DRIVEN,
    AT_DRIVERS,
    AT_ELEMENTS,
    AT_ENDS,
    AT_FACTORS,
    AT_FORCES,
    AT_GROUPS,
    AT_INDEPENDENT_V,
    AT_JOINT_ACCELERATIONS,
    AT_JOINT_FORCES,
    AT_JOINT_SPEEDS,
    AT_JOINTS,
    AT_MASSIVE,
    AT_REFLECTIONS,
    AT_RESTS,
    AT_RIGHT,
    AT_SCREWS,
    AT_VELOCITIES,
    BODIES,
    DAMPING,
    DRIVEN_AT,
    ELEMENT_INTEGERS,
    ELEMENTS,
    FACTOR_AT,
    FIRST_DRIVER,
    FREEDOMS,
    FRICTION,
    GROUP_COLUMN,
    GROUP_COLUMNS,
    GROUP_DRIVERS,
    GROUP_INTEGERS,
    GROUP_ROWS,
    GROUPS,
    INDEPENDENT,
    INDEX_Q,
    INDEX_V,
    JOINT_NUMBERS,
    KIND,
    PARENT,
    SCREW,
    STIFFNESS,
    VELOCITIES,
)


@scalar
def independent_speeds(tree, memory, speeds, out):
    """Copy independent speeds to their places among all velocities; set the others to zero."""
    independent_v = tree[AT_INDEPENDENT_V]
    for velocity in range(tree[VELOCITIES]):
        memory[out + velocity] = 0.0
    for j in range(tree[INDEPENDENT]):
        memory[out + tree[independent_v + j]] = memory[speeds + j]


@scalar
def _driven_by(tree, memory, group, speeds):
    """Subtract the effect of independent speeds from the right side of a group's equations."""
    right, drivers, independent_v = tree[AT_RIGHT], tree[AT_DRIVERS], tree[AT_INDEPENDENT_V]
    g = tree[AT_GROUPS] + GROUP_INTEGERS * group
    rows = tree[g + GROUP_ROWS]
    for j in range(tree[g + GROUP_DRIVERS]):
        driver = tree[drivers + tree[g + FIRST_DRIVER] + j]
        speed = memory[speeds + tree[independent_v + driver]]
        if speed != 0.0:
            d = tree[AT_DRIVEN] + tree[g + DRIVEN_AT] + rows * j
            for i in range(rows):
                memory[right + i] -= memory[d + i] * speed


@scalar
def joint_speeds(tree, memory, speeds, out):
    r"""Write the velocities of all joints, :math:`L \dot q^a` (thesis eq. 3.16)."""
    right, groups = tree[AT_RIGHT], tree[AT_GROUPS]
    independent_speeds(tree, memory, speeds, out)
    for group in range(tree[GROUPS]):
        for i in range(tree[groups + GROUP_INTEGERS * group + GROUP_ROWS]):
            memory[right + i] = 0.0
        _driven_by(tree, memory, group, out)
        spread(tree, memory, group, out)


@scalar
def twists(tree, memory, speeds, X):
    """Write the twists of all elements for joint speeds."""
    elements, screws = tree[ELEMENTS], tree[AT_SCREWS]
    for i in range(6):
        memory[X + 6 * elements + i] = 0.0
    for e in range(elements):
        row = tree[AT_ELEMENTS] + ELEMENT_INTEGERS * e
        parent, first = tree[row + PARENT], tree[row + INDEX_V]
        p, o = X + 6 * (parent if parent >= 0 else elements), X + 6 * e
        for i in range(6):
            memory[o + i] = memory[p + i]
        for velocity in range(first, first + tree[row + FREEDOMS]):
            s, speed = screws + 6 * velocity, memory[speeds + velocity]
            for i in range(6):
                memory[o + i] += memory[s + i] * speed


@scalar
def carried(tree, memory, speeds, X, rate):
    """Write the twists of all elements for joint speeds, and their rates of change at constant L.

    The twists go to X, the rates to ``rate``. The elements move with their velocities, which may be
    X itself.
    """
    elements, V, screws = tree[ELEMENTS], tree[AT_VELOCITIES], tree[AT_SCREWS]
    for i in range(6):
        memory[X + 6 * elements + i] = 0.0
        memory[rate + 6 * elements + i] = 0.0
    for e in range(elements):
        row = tree[AT_ELEMENTS] + ELEMENT_INTEGERS * e
        parent, first = tree[row + PARENT], tree[row + INDEX_V]
        p = 6 * (parent if parent >= 0 else elements)
        x0 = x1 = x2 = x3 = x4 = x5 = 0.0
        for velocity in range(first, first + tree[row + FREEDOMS]):
            s, speed = screws + 6 * velocity, memory[speeds + velocity]
            x0 += memory[s] * speed
            x1 += memory[s + 1] * speed
            x2 += memory[s + 2] * speed
            x3 += memory[s + 3] * speed
            x4 += memory[s + 4] * speed
            x5 += memory[s + 5] * speed
        o, k = X + 6 * e, X + p
        memory[o] = memory[k] + x0
        memory[o + 1] = memory[k + 1] + x1
        memory[o + 2] = memory[k + 2] + x2
        memory[o + 3] = memory[k + 3] + x3
        memory[o + 4] = memory[k + 4] + x4
        memory[o + 5] = memory[k + 5] + x5
        o, k = rate + 6 * e, V + 6 * e
        p += rate
        v0, v1, v2 = memory[k], memory[k + 1], memory[k + 2]
        v3, v4, v5 = memory[k + 3], memory[k + 4], memory[k + 5]
        memory[o] = memory[p] + v4 * x2 - v5 * x1 + v1 * x5 - v2 * x4
        memory[o + 1] = memory[p + 1] + v5 * x0 - v3 * x2 + v2 * x3 - v0 * x5
        memory[o + 2] = memory[p + 2] + v3 * x1 - v4 * x0 + v0 * x4 - v1 * x3
        memory[o + 3] = memory[p + 3] + v4 * x5 - v5 * x4
        memory[o + 4] = memory[p + 4] + v5 * x3 - v3 * x5
        memory[o + 5] = memory[p + 5] + v3 * x4 - v4 * x3


@scalar
def change_of_joint_speeds(tree, numbers, memory, speeds, X, rate, out):
    r"""Write the rates of change of the dependent joint speeds of twists X, :math:`\dot L`.

    ``out`` already holds the rates of the independent ones.
    """
    right, groups = tree[AT_RIGHT], tree[AT_GROUPS]
    for group in range(tree[GROUPS]):
        accelerated(tree, numbers, memory, group, speeds, X, rate)
        for i in range(tree[groups + GROUP_INTEGERS * group + GROUP_ROWS]):
            memory[right + i] = -memory[right + i]
        _driven_by(tree, memory, group, out)
        spread(tree, memory, group, out)


@scalar
def add_change(tree, memory, change, rate):
    """Add the contribution of the joint accelerations to the accelerations of all elements.

    The forces of the elements are overwritten.
    """
    elements, screws, added = tree[ELEMENTS], tree[AT_SCREWS], tree[AT_FORCES]
    for e in range(elements):
        row = tree[AT_ELEMENTS] + ELEMENT_INTEGERS * e
        parent, first = tree[row + PARENT], tree[row + INDEX_V]
        for i in range(6):
            value = memory[added + 6 * parent + i] if parent >= 0 else 0.0
            for velocity in range(first, first + tree[row + FREEDOMS]):
                value += memory[screws + 6 * velocity + i] * memory[change + velocity]
            memory[added + 6 * e + i] = value
            memory[rate + 6 * e + i] += value


@scalar
def joint_forces(tree, numbers, memory):
    """Write the forces of all joints of the open tree: RNEA, motor inertia, springs and damping.

    The velocities and accelerations of the joints and elements are in the memory.
    """
    elements, screws, forces = tree[ELEMENTS], tree[AT_SCREWS], tree[AT_FORCES]
    q, rests = tree[AT_CONFIGURATION], tree[AT_RESTS]
    for i in range(6 * elements):
        memory[forces + i] = 0.0
    for body in range(tree[BODIES]):
        e = tree[tree[AT_MASSIVE] + body]
        wrench(tree, numbers, memory, e, forces + 6 * e)
    for e in range(elements - 1, -1, -1):
        row = tree[AT_ELEMENTS] + ELEMENT_INTEGERS * e
        parent, first, o = tree[row + PARENT], tree[row + INDEX_V], forces + 6 * e
        for velocity in range(first, first + tree[row + FREEDOMS]):
            s, joint = screws + 6 * velocity, tree[AT_JOINTS] + JOINT_NUMBERS * velocity
            memory[tree[AT_JOINT_FORCES] + velocity] = (
                memory[s] * memory[o]
                + memory[s + 1] * memory[o + 1]
                + memory[s + 2] * memory[o + 2]
                + memory[s + 3] * memory[o + 3]
                + memory[s + 4] * memory[o + 4]
                + memory[s + 5] * memory[o + 5]
                + numbers[joint + ARMATURE] * memory[tree[AT_JOINT_ACCELERATIONS] + velocity]
                + numbers[joint + DAMPING] * memory[tree[AT_JOINT_SPEEDS] + velocity]
            )
            friction, speed = numbers[joint + FRICTION], memory[tree[AT_JOINT_SPEEDS] + velocity]
            if friction != 0.0 and speed != 0.0:
                memory[tree[AT_JOINT_FORCES] + velocity] += friction if speed > 0.0 else -friction
        if tree[row + KIND] == SCREW:
            at, joint = tree[row + INDEX_Q], tree[AT_JOINTS] + JOINT_NUMBERS * first
            stretch = memory[q + at] - numbers[rests + at]
            memory[tree[AT_JOINT_FORCES] + first] += numbers[joint + STIFFNESS] * stretch
        if parent >= 0:
            for i in range(6):
                memory[forces + 6 * parent + i] += memory[o + i]


@scalar
def projected(tree, memory, forces, out):
    r"""Project forces of all joints onto the independent ones, :math:`L^T f` (thesis eq. 3.37)."""
    right, dependent_v, drivers = tree[AT_RIGHT], tree[AT_DEPENDENT_V], tree[AT_DRIVERS]
    for j in range(tree[INDEPENDENT]):
        memory[out + j] = memory[forces + tree[tree[AT_INDEPENDENT_V] + j]]
    for group in range(tree[GROUPS]):
        g = tree[AT_GROUPS] + GROUP_INTEGERS * group
        rows, columns = tree[g + GROUP_ROWS], tree[g + GROUP_COLUMNS]
        column = tree[g + GROUP_COLUMN]
        for k in range(columns):
            memory[right + k] = memory[forces + tree[dependent_v + column + k]]
        solve_transposed(
            tree,
            memory,
            tree[AT_ENDS] + column,
            tree[AT_FACTORS] + tree[g + FACTOR_AT],
            tree[AT_REFLECTIONS] + column,
            rows,
            columns,
            right,
        )
        for j in range(tree[g + GROUP_DRIVERS]):
            d = tree[AT_DRIVEN] + tree[g + DRIVEN_AT] + rows * j
            value = 0.0
            for i in range(rows):
                value += memory[d + i] * memory[right + i]
            memory[out + tree[drivers + tree[g + FIRST_DRIVER] + j]] -= value
