r"""Compiled derivatives of the forces of a motion by positions and speeds, with closed loops.

Let :math:`X_k` be the twists of all elements at unit speed of the independent coordinate k. The
derivative along coordinate k of a field that moves with its element is :math:`X_k \times`. In
addition, velocities change by :math:`\dot X_k` and accelerations by :math:`\ddot X_k + \dot X_k
\times V`. These are rates of :math:`X_k` *along the motion*, because derivatives by two coordinates
can be exchanged: :math:`\partial_k X_i - \partial_i X_k = X_k \times X_i`. So no other derivatives
are needed:

.. math::

    \frac{\partial \tau_i}{\partial a_k} &= \sum X_i^T \big( I (\ddot X_k + X_k \times g)
        + B \dot X_k + (X_k - X_k^p) \times^* F \big) + \dots, \\
    \frac{\partial \tau_i}{\partial \dot a_k} &= \sum X_i^T ( 2 I \dot X_k + B X_k ), \qquad
    B Z = I (Z \times V) + Z \times^* I V + V \times^* I Z,

where :math:`X_k^p` is the twist of the element's parent and F the wrench on all that an element
carries, with the forces in the loops. These forces account for the change of L. With the forces of
the loops :math:`\mu` from :math:`J_u^T \mu = -f_u`, only :math:`\mu^T \partial_i J L_k` remains of
that change. Half of it is the motion of the joint screws with their elements, which F contains. The
other half (the dots above) is the rotation of the force at a closure with the closure. For a single
body, B describes the change of twice its velocity: a force and a torque that depend only on the
rotational part of Z.

The equations of the loops are solved once per coordinate to get :math:`\ddot L`, and not at all for
the derivatives by speeds.
"""

from __future__ import annotations

from fuzzy2.support.compiled import scalar
from psp3.multibody.bodies import momentum
from psp3.multibody.closing import spread
from psp3.multibody.forces import add_change
from psp3.multibody.least_squares import solve_transposed
from psp3.multibody.loops import polynomial, turned
from psp3.multibody.tree import (
    ARMATURE,
    AT_ACCELERATIONS,
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
    AT_VECTORS,
    AT_VELOCITIES,
    BALL,
    BODIES,
    CLOSURE_INTEGERS,
    CLOSURE_KIND,
    CLOSURE_NUMBERS,
    CLOSURES,
    COUPLED_SPEED,
    COUPLING,
    DAMPING,
    ELEMENT_INTEGERS,
    ELEMENTS,
    FACTOR_AT,
    FIRST_CLOSURE,
    FIRST_END,
    FIRST_ROW,
    FRAME,
    FREEDOMS,
    FRICTION,
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
    PLANAR,
    POINT,
    SCREW,
    SECOND_END,
    SPIN,
    STIFFNESS,
    UNBOUNDED,
    VELOCITIES,
)


@scalar
def _add_cross(memory, a, b, out):
    """Add the cross product of two vectors."""
    x, y, z = memory[a], memory[a + 1], memory[a + 2]
    u, v, w = memory[b], memory[b + 1], memory[b + 2]
    memory[out] += y * w - z * v
    memory[out + 1] += z * u - x * w
    memory[out + 2] += x * v - y * u


@scalar
def _add_product(memory, a, b, out):
    """Add the cross product of two twists."""
    _add_cross(memory, a + 3, b, out)
    _add_cross(memory, a, b + 3, out)
    _add_cross(memory, a + 3, b + 3, out + 3)


@scalar
def _add_dual_product(memory, a, force, out):
    """Add the cross product of a twist and a wrench."""
    _add_cross(memory, a + 3, force, out)
    _add_cross(memory, a + 3, force + 3, out + 3)
    _add_cross(memory, a, force, out + 3)


@scalar
def _subtract(memory, a, b, factor, out):
    """Write the difference of two twists, times a factor."""
    for i in range(6):
        memory[out + i] = factor * (memory[a + i] - memory[b + i])


@scalar
def _set(memory, at, count, value):
    """Write a number into ``count`` places."""
    for i in range(count):
        memory[at + i] = value


@scalar
def differentiate(tree, numbers, memory, forces):
    """Write the derivatives of the independent forces by positions and by speeds, column by column.

    The memory holds a motion with all its forces (those of independent joints at ``forces``), the
    mass matrix, L, its twists and their rates. The elements' forces are overwritten.
    """
    _load(tree, numbers, memory)
    _spins(tree, memory)
    n = tree[INDEPENDENT]
    _set(memory, tree[AT_BY_POSITIONS], n * n, 0.0)
    _set(memory, tree[AT_BY_SPEEDS], n * n, 0.0)
    for k in range(n):
        _along_speed(tree, numbers, memory, k)
        _bring(tree, memory, tree[AT_BY_SPEEDS] + n * k)
        _rates_again(tree, numbers, memory, k)
        _along_position(tree, numbers, memory, k)
        _bring(tree, memory, tree[AT_BY_POSITIONS] + n * k)
    _at_free_joints(tree, memory, forces)


@scalar
def _load(tree, numbers, memory):
    """Write the wrench on all that each element carries, with the forces in the loops."""
    elements, groups, bodies = tree[ELEMENTS], tree[AT_GROUPS], tree[AT_ELEMENTS]
    loads, loops, right = tree[AT_LOADS], tree[AT_LOOP_FORCES], tree[AT_RIGHT]
    _set(memory, loads, 6 * elements, 0.0)
    for group in range(tree[GROUPS]):
        g = groups + GROUP_INTEGERS * group
        column = tree[g + GROUP_COLUMN]
        for k in range(tree[g + GROUP_COLUMNS]):
            velocity = tree[tree[AT_DEPENDENT_V] + column + k]
            memory[right + k] = -memory[tree[AT_JOINT_FORCES] + velocity]
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
            if tree[c + CLOSURE_KIND] >= COUPLING:
                memory[o] = memory[row]
                continue
            wrench = _pull(tree, memory, closure, row, o)
            for side in range(2):
                end = tree[c + FIRST_END + side]
                if end >= 0:
                    for i in range(6):
                        pulled = memory[wrench + i] if side == 1 else -memory[wrench + i]
                        memory[loads + 6 * end + i] += pulled
    for e in range(elements - 1, -1, -1):
        parent = tree[bodies + ELEMENT_INTEGERS * e + PARENT]
        for i in range(6):
            if parent >= 0:
                memory[loads + 6 * parent + i] += memory[loads + 6 * e + i]
            memory[loads + 6 * e + i] += memory[tree[AT_FORCES] + 6 * e + i]


@scalar
def _pull(tree, memory, closure, row, out):
    """Write the multipliers of a closure in base axes; return the place of their wrench.

    It is a force (3) and a torque (3). For a hinge, a vector whose cross product with the axis is
    the torque replaces the torque.
    """
    f, axis = tree[AT_FRAMES] + 24 * closure, tree[AT_VECTORS]
    wrench, point = axis + 3, f + 21
    kind = tree[tree[AT_CLOSURES] + CLOSURE_INTEGERS * closure + CLOSURE_KIND]
    for i in range(3):
        memory[axis + i] = memory[f + 14 + 3 * i]
        force = turning = 0.0
        for k in range(3):
            force += memory[f + 3 * i + k] * memory[row + k]
            if kind == FRAME or (kind == HINGE and k < 2):
                turning += memory[f + 3 * i + k] * memory[row + 3 + k]
        memory[out + i] = memory[wrench + i] = force
        memory[out + 3 + i] = turning
        memory[wrench + 3 + i] = 0.0 if kind == HINGE else turning
    if kind == HINGE:
        _add_cross(memory, axis, out + 3, wrench + 3)
    _add_cross(memory, point, out, wrench + 3)
    return wrench


@scalar
def _spins(tree, memory):
    r"""Write B of all bodies: twice the momentum (3), and the matrix of the torque by columns (9).

    With x the positions of a body's particles and v their velocities, B Z is the wrench of :math:`2
    z \times v`, and the matrix :math:`2 \sum m ((x^T v) 1 - v x^T)`.
    """
    moments = tree[AT_VECTORS]
    for body in range(tree[BODIES]):
        e = tree[tree[AT_MASSIVE] + body]
        inertia, v, o = (
            tree[AT_INERTIAS] + 10 * e,
            tree[AT_VELOCITIES] + 6 * e,
            tree[AT_SPINS] + 12 * e,
        )
        trace = memory[inertia + 4] + memory[inertia + 7] + memory[inertia + 9]
        flow = 0.0
        for i in range(3):
            flow += 2.0 * memory[v + i] * memory[inertia + 1 + i]
            memory[o + i] = 2.0 * memory[inertia] * memory[v + i]
        for k in range(3):
            for i in range(3):
                # The six entries of a symmetric matrix are stored.
                at = inertia + 4 + i + k + (1 if i > 0 and k > 0 else 0)
                # Twice the second moments of mass.
                memory[moments + i] = (trace if i == k else 0.0) - 2.0 * memory[at]
                memory[o + 3 + 3 * k + i] = (flow if i == k else 0.0) - (
                    2.0 * memory[v + i] * memory[inertia + 1 + k]
                )
            _add_cross(memory, moments, v + 3, o + 3 + 3 * k)
        for i in range(3):
            memory[moments + i] = 2.0 * memory[inertia + 1 + i]
        _add_cross(memory, v + 3, moments, o)


@scalar
def _add_spinning(tree, memory, e, moved, Z, out):
    """Write I times a twist and B times another, Z, of a body."""
    momentum(tree, memory, e, moved, out)
    o = tree[AT_SPINS] + 12 * e
    _add_cross(memory, Z + 3, o, out)
    for k in range(3):
        for i in range(3):
            memory[out + 3 + i] += memory[o + 3 + 3 * k + i] * memory[Z + 3 + k]


@scalar
def _along_speed(tree, numbers, memory, k):
    """Write the derivatives by speed k of all elements' wrenches and of the joints' loads."""
    elements, T, nv = tree[ELEMENTS], tree[AT_FIELD_FORCES], tree[VELOCITIES]
    wide, twice = 6 * (elements + 1), T + 6 * elements
    X, rates = tree[AT_FIELDS] + wide * k, tree[AT_RATES] + wide * k
    _set(memory, T, wide, 0.0)
    for body in range(tree[BODIES]):
        e = tree[tree[AT_MASSIVE] + body]
        for i in range(6):
            memory[twice + i] = 2.0 * memory[rates + 6 * e + i]
        _add_spinning(tree, memory, e, twice, X + 6 * e, T + 6 * e)
    L, change = tree[AT_COMPLEMENT] + nv * k, tree[AT_COMPLEMENT_RATES] + nv * k
    for velocity in range(nv):
        joint = tree[AT_JOINTS] + JOINT_NUMBERS * velocity
        memory[tree[AT_JOINT_LOADS] + velocity] = (
            2.0 * numbers[joint + ARMATURE] * memory[change + velocity]
            + numbers[joint + DAMPING] * memory[L + velocity]
        )
    for e in range(elements):
        if tree[tree[AT_ELEMENTS] + ELEMENT_INTEGERS * e + KIND] > UNBOUNDED:
            _add_bracket(tree, numbers, memory, e, ARMATURE, tree[AT_JOINT_SPEEDS], L)


@scalar
def _axis_of(kind, number):
    """Return the place in its twist of a velocity of a joint with several degrees of freedom."""
    if kind == BALL:
        return 3 + number
    return 5 if kind == PLANAR and number == 2 else number


@scalar
def _lift(tree, memory, e, speeds, out):
    """Write the twist of a joint with several freedoms in its own axes, from all joint speeds."""
    row = tree[AT_ELEMENTS] + ELEMENT_INTEGERS * e
    _set(memory, out, 6, 0.0)
    for i in range(tree[row + FREEDOMS]):
        memory[out + _axis_of(tree[row + KIND], i)] = memory[speeds + tree[row + INDEX_V] + i]


@scalar
def _add_bracket(tree, numbers, memory, e, factor, one, other):
    """Add a factor times a cross product to the loads of a joint with several degrees of freedom.

    The product is that of two of its twists in its own axes; the factor is its inertia or damping.
    """
    row, a = tree[AT_ELEMENTS] + ELEMENT_INTEGERS * e, tree[AT_VECTORS]
    _lift(tree, memory, e, one, a)
    _lift(tree, memory, e, other, a + 6)
    _set(memory, a + 12, 6, 0.0)
    _add_product(memory, a, a + 6, a + 12)
    first, count = tree[row + INDEX_V], tree[row + FREEDOMS]
    for i in range(count):
        joint = tree[AT_JOINTS] + JOINT_NUMBERS * (first + i)
        memory[tree[AT_JOINT_LOADS] + first + i] += (
            numbers[joint + factor] * memory[a + 12 + _axis_of(tree[row + KIND], i)]
        )


@scalar
def _rates_again(tree, numbers, memory, k):
    """Write the second rates of the twists of column k of L; write that of the column to the loads.

    The elements' forces are overwritten.
    """
    elements, A, V = tree[ELEMENTS], tree[AT_ACCELERATIONS], tree[AT_VELOCITIES]
    X, rates = tree[AT_FIELDS] + 6 * (elements + 1) * k, tree[AT_RATES] + 6 * (elements + 1) * k
    second, right, x = tree[AT_SECOND_RATES], tree[AT_RIGHT], tree[AT_VECTORS]
    y = x + 6
    _set(memory, second + 6 * elements, 6, 0.0)
    for e in range(elements):
        parent = tree[tree[AT_ELEMENTS] + ELEMENT_INTEGERS * e + PARENT]
        p = 6 * (parent if parent >= 0 else elements)
        o = 6 * e
        _subtract(memory, X + o, X + p, 1.0, x)
        # 2 Ẋ − V × X of the joint
        _subtract(memory, rates + o, rates + p, 2.0, y)
        _add_product(memory, x, V + o, y)
        for i in range(6):
            memory[second + o + i] = memory[second + p + i]
        _add_product(memory, A + o, x, second + o)
        _add_product(memory, V + o, y, second + o)
    _set(memory, tree[AT_JOINT_LOADS], tree[VELOCITIES], 0.0)
    for group in range(tree[GROUPS]):
        _accelerated_again(tree, numbers, memory, group, k)
        for i in range(tree[tree[AT_GROUPS] + GROUP_INTEGERS * group + GROUP_ROWS]):
            memory[right + i] = -memory[right + i]
        spread(tree, memory, group, tree[AT_JOINT_LOADS])
    if tree[GROUPS] > 0:
        add_change(tree, memory, tree[AT_JOINT_LOADS], second)


@scalar
def _accelerated_again(tree, numbers, memory, group, k):
    """Write the second rate of J z in a closed group without the second rate of z, a column of L.

    J z is always zero, so the rates of the axes of its rows do not matter.
    """
    base, nv, x = tree[ELEMENTS], tree[VELOCITIES], tree[AT_VECTORS]
    g, wide, second = tree[AT_GROUPS] + GROUP_INTEGERS * group, 6 * (base + 1) * k, x + 12
    for closure in range(tree[g + FIRST_CLOSURE], tree[g + GROUP_INTEGERS + FIRST_CLOSURE]):
        c, f = tree[AT_CLOSURES] + CLOSURE_INTEGERS * closure, tree[AT_FRAMES] + 24 * closure
        kind, row = tree[c + CLOSURE_KIND], tree[AT_RIGHT] + tree[c + FIRST_ROW]
        one, two = tree[c + FIRST_END], tree[c + SECOND_END]
        if kind == COUPLING:
            at = tree[AT_CLOSURE_FRAMES] + CLOSURE_NUMBERS * closure
            value, v = memory[tree[AT_CONFIGURATION] + two], tree[c + COUPLED_SPEED]
            speed = memory[tree[AT_JOINT_SPEEDS] + v]
            bend = polynomial(numbers, at, value, 2)
            change = polynomial(numbers, at, value, 3) * speed * speed
            change += bend * memory[tree[AT_JOINT_ACCELERATIONS] + v]
            memory[row] = -(
                change * memory[tree[AT_COMPLEMENT] + nv * k + v]
                + 2.0 * bend * speed * memory[tree[AT_COMPLEMENT_RATES] + nv * k + v]
            )
            continue
        if kind == SPIN:
            _spin_again(tree, numbers, memory, closure, k)
            memory[row] = 0.0
            for i in range(3):
                memory[row] += memory[x + i] * memory[x + 9 + i]
            continue
        a = 6 * (one if one >= 0 else base)
        b = 6 * (two if two >= 0 else base)
        # Motion of the second body relative to the first: X, 2 Ẋ and Ẍ.
        _subtract(memory, tree[AT_FIELDS] + wide + b, tree[AT_FIELDS] + wide + a, 1.0, x)
        _subtract(memory, tree[AT_RATES] + wide + b, tree[AT_RATES] + wide + a, 2.0, x + 6)
        _subtract(memory, tree[AT_SECOND_RATES] + b, tree[AT_SECOND_RATES] + a, 1.0, second)
        # First of the point, then of a hinge's axis.
        for part in range(1 if kind == POINT else 2):
            for i in range(3):
                memory[x + 18 + i] = memory[f + 21 + i] if part == 0 else memory[f + 14 + 3 * i]
            if part == 0 or kind == HINGE:
                _swing(tree, memory, b, part)
            else:
                for i in range(3):
                    memory[x + 27 + i] = memory[second + 3 + i]
            for i in range(2 if part == 1 and kind == HINGE else 3):
                value = 0.0
                for j in range(3):
                    value += memory[f + 3 * j + i] * memory[x + 27 + j]
                memory[row + 3 * part + i] = value


@scalar
def _slope_of_spin(tree, numbers, memory, closure, out):
    """Write the derivative of a spin by the angular velocity of its ball (3)."""
    c = tree[AT_CLOSURES] + CLOSURE_INTEGERS * closure
    at = tree[AT_CLOSURE_FRAMES] + CLOSURE_NUMBERS * closure
    q = tree[AT_CONFIGURATION] + tree[c + FIRST_END]
    for i in range(3):
        memory[out + i] = turned(numbers, at, memory, q, i, 1)


@scalar
def _spin_again(tree, numbers, memory, closure, k):
    """Write a spin's derivative, and the component of its second rate along the derivative.

    The residual is linear in the quaternion Q of the ball joint. With the angular velocities ω of
    the motion and z of column k of L, the component is that of the product Q (¼ ω ω z + ½ ω' z + ω
    z'). A component along Q itself does not matter for a closed spin.
    """
    nv, x = tree[VELOCITIES], tree[AT_VECTORS]
    v = tree[tree[AT_CLOSURES] + CLOSURE_INTEGERS * closure + COUPLED_SPEED]
    speed, z = tree[AT_JOINT_SPEEDS] + v, tree[AT_COMPLEMENT] + nv * k + v
    change = tree[AT_COMPLEMENT_RATES] + nv * k + v
    _slope_of_spin(tree, numbers, memory, closure, x)
    square = 0.0
    for i in range(3):
        square += memory[speed + i] * memory[speed + i]
        memory[x + 3 + i] = 0.5 * memory[z + i]
    for i in range(3):
        memory[x + 9 + i] = -0.25 * square * memory[z + i]
    _add_cross(memory, tree[AT_JOINT_ACCELERATIONS] + v, x + 3, x + 9)
    _add_cross(memory, speed, change, x + 9)


@scalar
def _swing(tree, memory, b, part):
    """Write the second rate of the change that relative twists cause in a vector on a body.

    The vectors of the memory hold these twists (3 · 6) and the vector (3). They receive the
    vector's rate and second rate (6), and the result (3). Part 0 is a point, with the twists'
    linear parts, and 1 a direction.
    """
    V, A, x = tree[AT_VELOCITIES] + b, tree[AT_ACCELERATIONS] + b, tree[AT_VECTORS]
    u, rate, second, out = x + 18, x + 21, x + 24, x + 27
    for i in range(3):
        memory[rate + i] = memory[V + i] if part == 0 else 0.0
        memory[second + i] = memory[A + i] if part == 0 else 0.0
        memory[out + i] = memory[x + 12 + i] if part == 0 else 0.0
    _add_cross(memory, V + 3, u, rate)
    _add_cross(memory, A + 3, u, second)
    _add_cross(memory, V + 3, rate, second)
    _add_cross(memory, x + 15, u, out)
    _add_cross(memory, x + 9, rate, out)
    _add_cross(memory, x + 3, second, out)


@scalar
def _along_position(tree, numbers, memory, k):
    """Write the derivatives by position k of all elements' wrenches and of the joints' loads."""
    elements, T, nv = tree[ELEMENTS], tree[AT_FIELD_FORCES], tree[VELOCITIES]
    wide, second, x = 6 * (elements + 1), tree[AT_SECOND_RATES], tree[AT_VECTORS]
    X, rates = tree[AT_FIELDS] + wide * k, tree[AT_RATES] + wide * k
    L, change = tree[AT_COMPLEMENT] + nv * k, tree[AT_COMPLEMENT_RATES] + nv * k
    _set(memory, T, 6 * elements, 0.0)
    for i in range(3):
        memory[x + i] = numbers[tree[AT_FREE_FALL] + i]
    for body in range(tree[BODIES]):
        e = 6 * tree[tree[AT_MASSIVE] + body]
        # The acceleration of free fall does not rotate with the elements.
        _add_cross(memory, X + e + 3, x, second + e)
        _add_spinning(tree, memory, e // 6, second + e, rates + e, T + e)
    for e in range(elements):
        row = tree[AT_ELEMENTS] + ELEMENT_INTEGERS * e
        parent, first = tree[row + PARENT], tree[row + INDEX_V]
        _subtract(memory, X + 6 * e, X + 6 * (parent if parent >= 0 else elements), 1.0, x)
        _add_dual_product(memory, x, tree[AT_LOADS] + 6 * e, T + 6 * e)
        for velocity in range(first, first + tree[row + FREEDOMS]):
            joint, at = tree[AT_JOINTS] + JOINT_NUMBERS * velocity, tree[AT_JOINT_LOADS] + velocity
            # The loads begin with the second rate of L.
            memory[at] = (
                numbers[joint + ARMATURE] * memory[at]
                + numbers[joint + DAMPING] * memory[change + velocity]
            )
        if tree[row + KIND] == SCREW:
            joint = tree[AT_JOINTS] + JOINT_NUMBERS * first
            memory[tree[AT_JOINT_LOADS] + first] += numbers[joint + STIFFNESS] * memory[L + first]
        elif tree[row + KIND] != UNBOUNDED:
            _turn_joint(tree, numbers, memory, e, L, change)
    for closure in range(tree[CLOSURES]):
        _turn_closure(tree, numbers, memory, closure, k)


@scalar
def _turn_joint(tree, numbers, memory, e, L, change):
    """Add the effect of motors and damping to the loads of a joint with several degrees of freedom.

    Its axes rotate, so derivatives of its twists by two coordinates differ by their cross product,
    and so do the forces on these twists.
    """
    row = tree[AT_ELEMENTS] + ELEMENT_INTEGERS * e
    first, count = tree[row + INDEX_V], tree[row + FREEDOMS]
    speed, faster, a = tree[AT_JOINT_SPEEDS], tree[AT_JOINT_ACCELERATIONS], tree[AT_VECTORS]
    _add_bracket(tree, numbers, memory, e, DAMPING, speed, L)
    _add_bracket(tree, numbers, memory, e, ARMATURE, faster, L)
    _add_bracket(tree, numbers, memory, e, ARMATURE, speed, change)
    _lift(tree, memory, e, L, a)
    _set(memory, a + 6, 12, 0.0)
    for i in range(count):
        joint = tree[AT_JOINTS] + JOINT_NUMBERS * (first + i)
        friction, motion = numbers[joint + FRICTION], memory[speed + first + i]
        friction = friction if motion > 0.0 else -friction if motion < 0.0 else 0.0
        memory[a + 6 + _axis_of(tree[row + KIND], i)] = (
            numbers[joint + ARMATURE] * memory[faster + first + i]
            + numbers[joint + DAMPING] * motion
            + friction
        )
    _add_dual_product(memory, a, a + 6, a + 12)
    for i in range(count):
        memory[tree[AT_JOINT_LOADS] + first + i] += memory[a + 12 + _axis_of(tree[row + KIND], i)]


@scalar
def _turn_closure(tree, numbers, memory, closure, k):
    """Add the effect of the force in a loop when its closure rotates or bends."""
    base, nv, x = tree[ELEMENTS], tree[VELOCITIES], tree[AT_VECTORS]
    X, T = tree[AT_FIELDS] + 6 * (base + 1) * k, tree[AT_FIELD_FORCES]
    c, f = tree[AT_CLOSURES] + CLOSURE_INTEGERS * closure, tree[AT_FRAMES] + 24 * closure
    kind, o = tree[c + CLOSURE_KIND], tree[AT_LOOP_FORCES] + 6 * closure
    one, two = tree[c + FIRST_END], tree[c + SECOND_END]
    if kind == COUPLING:
        at = tree[AT_CLOSURE_FRAMES] + CLOSURE_NUMBERS * closure
        v = tree[c + COUPLED_SPEED]
        bend = polynomial(numbers, at, memory[tree[AT_CONFIGURATION] + two], 2)
        memory[tree[AT_JOINT_LOADS] + v] -= (
            memory[o] * bend * memory[tree[AT_COMPLEMENT] + nv * k + v]
        )
    elif kind == SPIN:
        v = tree[c + COUPLED_SPEED]
        _slope_of_spin(tree, numbers, memory, closure, x)
        for i in range(3):
            memory[x + i] *= 0.5 * memory[o]
        _add_cross(memory, tree[AT_COMPLEMENT] + nv * k + v, x, tree[AT_JOINT_LOADS] + v)
    elif kind != FRAME and two >= 0:
        # Joined frames do not rotate relative to each other, and the base does not move.
        _subtract(memory, X + 6 * two, X + 6 * (one if one >= 0 else base), 1.0, x)
        _set(memory, x + 6, 6, 0.0)
        _add_cross(memory, o, x + 3, x + 6)
        for i in range(3):
            memory[T + 6 * two + i] += memory[x + 6 + i]
        _add_cross(memory, f + 21, x + 6, T + 6 * two + 3)
        if kind == HINGE:
            _add_cross(memory, o + 3, x + 3, x + 9)
            for i in range(3):
                memory[x + i] = memory[f + 14 + 3 * i]
            _add_cross(memory, x, x + 9, T + 6 * two + 3)


@scalar
def _at_free_joints(tree, memory, forces):
    """Correct derivatives by independent joints whose speeds are not rates of coordinates.

    Derivatives along two such speeds cannot be exchanged: they differ by the derivative along the
    cross product. Derivatives by positions are at constant speeds in the joint's own axes, which
    rotate.
    """
    n, M, column_of = tree[INDEPENDENT], tree[AT_MASS], tree[AT_COLUMN_OF]
    unit, speeds = tree[AT_VECTORS], tree[AT_VECTORS] + 6
    for e in range(tree[ELEMENTS]):
        row = tree[AT_ELEMENTS] + ELEMENT_INTEGERS * e
        first, count = tree[row + INDEX_V], tree[row + FREEDOMS]
        place = -1 - tree[column_of + first]
        # Dependent or locked
        if count == 1 or place < 0 or place >= n:
            continue
        _lift(tree, memory, e, tree[AT_JOINT_SPEEDS], speeds)
        _lift(tree, memory, e, tree[AT_JOINT_ACCELERATIONS], speeds + 6)
        _set(memory, speeds + 12, 6, 0.0)
        for i in range(count):
            j = -1 - tree[column_of + first + i]
            memory[speeds + 12 + _axis_of(tree[row + KIND], i)] = memory[forces + j]
        for part in range(2):
            for axis in range(count):
                k = -1 - tree[column_of + first + axis]
                _set(memory, unit, 6, 0.0)
                memory[unit + _axis_of(tree[row + KIND], axis)] = 1.0
                # The apparent changes of velocity, acceleration and force.
                _set(memory, unit + 24, 18, 0.0)
                _add_product(memory, speeds, unit, unit + 24)
                _add_product(memory, speeds + 6, unit, unit + 30)
                _add_dual_product(memory, unit, speeds + 12, unit + 36)
                by_speed = tree[AT_BY_SPEEDS] + n * k
                by_position = tree[AT_BY_POSITIONS] + n * k
                for i in range(count):
                    j = -1 - tree[column_of + first + i]
                    at = unit + 24 + _axis_of(tree[row + KIND], i)
                    for f in range(n):
                        mass = memory[M + n * f + j]
                        if part == 0:
                            memory[by_speed + f] -= mass * memory[at]
                        else:
                            slope = memory[tree[AT_BY_SPEEDS] + n * j + f]
                            memory[by_position + f] -= slope * memory[at] + mass * memory[at + 6]
                    if part == 1:
                        memory[by_position + j] -= memory[at + 12]


@scalar
def _bring(tree, memory, out):
    """Add the wrenches of all elements and the loads of joints to n independent forces.

    The wrench of each element is replaced by the sum over all that it carries.
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
