r"""Compiled answers about a robot with loops: one question about one state, or about many rows.

With L the natural orthogonal complement of the loops (thesis eq. 3.17), the equation of motion of
the tree :math:`f(q, \dot q, \ddot q)` becomes :math:`L^T f(q, L \dot q^a, L \ddot q^a + \dot L
\dot q^a) = \tau` (thesis eq. 3.37).

All questions go through one function, because each compiled function that Python can call takes
seconds to compile.
"""

from __future__ import annotations

import math

from fuzzy2.support.compiled import scalar
from psp3.checks import Array, Indices
from psp3.multibody.bodies import weigh
from psp3.multibody.closing import CLOSED, SINGULAR, moved_to, settled
from psp3.multibody.constraint import closure_equations
from psp3.multibody.derivatives import differentiate
from psp3.multibody.forces import (
    add_change,
    carried,
    change_of_joint_speeds,
    independent_speeds,
    joint_forces,
    joint_speeds,
    projected,
)
from psp3.multibody.inertia import (
    add_damping,
    complement,
    coriolis_matrix,
    factor_positive,
    gravity,
    kinetic_energy,
    mass_matrix,
    potential_energy,
    solve_positive,
)
from psp3.multibody.placement import compose
from psp3.multibody.tree import (
    AT_ACCELERATIONS,
    AT_BEFORE,
    AT_BY_POSITIONS,
    AT_BY_SPEEDS,
    AT_COMPLEMENT,
    AT_CONFIGURATION,
    AT_FIELDS,
    AT_FREE_FALL,
    AT_HERE,
    AT_JOINT_ACCELERATIONS,
    AT_JOINT_FORCES,
    AT_JOINT_SPEEDS,
    AT_LIMITS,
    AT_MASS,
    AT_PLACEMENTS,
    AT_REPORT,
    AT_ROOM,
    AT_TARGET,
    AT_VELOCITIES,
    COORDINATES,
    ELEMENTS,
    INDEPENDENT,
    POSITIONS,
    VELOCITIES,
)

(
    CONFIGURATION,
    COMPLEMENT,
    INVERSE_DYNAMICS,
    FORWARD_DYNAMICS,
    EQUATION_OF_MOTION,
    ENERGIES,
    MOTION,
    FRAME,
    INVERSE_DERIVATIVES,
    FORWARD_DERIVATIVES,
    EQUATIONS,
    ASSEMBLY,
) = range(12)
"""The questions, in the order of their answers: q (nq); q and L, column by column (n · nv); forces
of a motion (n); accelerations under forces (n); M, C (n² each) and G (n); kinetic and potential
energy; configuration, velocities and accelerations of all joints; placement of a frame in the base
(12) and its Jacobian, column by column (6n); derivatives of the forces of a motion by positions,
speeds and accelerations (n² each); derivatives of the accelerations under forces by positions,
speeds and forces (n² each).

Two more questions do not need a closed pose. One asks for the residuals of all closures at a
configuration, with their derivative if the answer has room for it; see
:mod:`psp3.multibody.constraint`. The other asks whether the loops can be closed with fixed
independent joints, from the guess at the beginning of the memory. It returns the outcome, and the
memory then begins with a pose that can be the reference.
"""

FRAME_NUMBERS = 13
"""Numbers that describe a frame: the element that carries it, or −1, and its placement there (12).
"""


BEYOND_LIMIT, NOT_FINITE = 3, 4
"""Outcomes of a row in addition to those of a closure: a dependent joint is beyond its limits;
there is no finite answer.
"""

BLOCK = 64
"""After this many rows, one always starts from the reference, so that answers do not depend on the
number of threads.
"""

NEAR = 0.003
"""A row starts from the pose of the preceding row if none of its independent coordinates is farther
than this [m, rad] from the last row that started from the reference. So answers do not depend on
other rows, to rounding, unless a singular pose lies between the two nearby paths.
"""


@scalar
def start_from(tree, reference, memory):
    """Begin the memory with the reference pose."""
    for i in range(tree[AT_BEFORE]):
        memory[i] = reference[i]


@scalar
def _aim(tree, memory, positions, row, anchor):
    """Set a row of positions as the target; return whether it is near another row."""
    target, near, p = tree[AT_TARGET], True, tree[POSITIONS]
    for j in range(p):
        memory[target + j] = positions[p * row + j]
        near = near and abs(memory[target + j] - positions[p * anchor + j]) <= NEAR
    return near


@scalar
def _reach(tree, numbers, memory):
    """Move to the target with closed loops; return the outcome."""
    outcome = moved_to(tree, numbers, memory)
    if outcome == CLOSED:
        q, limits = tree[AT_CONFIGURATION], tree[AT_LIMITS]
        for i in range(tree[COORDINATES]):
            k = limits + 2 * i
            if not numbers[k] <= memory[q + i] <= numbers[k + 1]:
                return BEYOND_LIMIT
    return outcome


@scalar
def is_finite(out, first, end):
    """Tell whether all numbers from the first to the end are finite."""
    finite = True
    for i in range(first, end):
        finite = finite and abs(out[i]) < math.inf
    return finite


@scalar
def move_with(tree, memory, speeds):
    """Write the velocities of all joints and elements for independent speeds."""
    z, V = tree[AT_JOINT_SPEEDS], tree[AT_VELOCITIES]
    joint_speeds(tree, memory, speeds, z)
    carried(tree, memory, z, V, tree[AT_ACCELERATIONS])


@scalar
def accelerate_with(tree, numbers, memory, accelerations):
    """Write the accelerations of all joints and elements; the memory holds their velocities."""
    change, rate = tree[AT_JOINT_ACCELERATIONS], tree[AT_ACCELERATIONS]
    independent_speeds(tree, memory, accelerations, change)
    change_of_joint_speeds(
        tree, numbers, memory, tree[AT_JOINT_SPEEDS], tree[AT_VELOCITIES], rate, change
    )
    add_change(tree, memory, change, rate)


@scalar
def _forces_of(tree, numbers, memory, accelerations, out):
    """Write the independent forces of a motion; the memory holds its velocities."""
    accelerate_with(tree, numbers, memory, accelerations)
    joint_forces(tree, numbers, memory)
    projected(tree, memory, tree[AT_JOINT_FORCES], out)


@scalar
def balance(tree, numbers, memory, speeds, forces, out):
    """Write the mass matrix of a closed pose, and the forces that remain for accelerations."""
    n = tree[INDEPENDENT]
    for j in range(n):
        memory[out + j] = 0.0
    move_with(tree, memory, speeds)
    _forces_of(tree, numbers, memory, out, out)
    for j in range(n):
        memory[out + j] = memory[forces + j] - memory[out + j]
    complement(tree, numbers, memory, 0.0)
    mass_matrix(tree, numbers, memory, tree[AT_MASS])


@scalar
def accelerate(tree, numbers, memory, speeds, forces, out):
    """Write the accelerations of a closed pose under forces; return whether there are any.

    The memory then holds L, as :func:`complement` writes it.
    """
    n = tree[INDEPENDENT]
    balance(tree, numbers, memory, speeds, forces, out)
    if not factor_positive(memory, tree[AT_MASS], n):
        return False
    solve_positive(memory, tree[AT_MASS], n, out)
    return True


@scalar
def _take(tree, memory, values, row, at):
    """Copy a row of independent speeds, accelerations or forces into the memory."""
    n = tree[INDEPENDENT]
    for j in range(n):
        memory[at + j] = values[n * row + j]


@scalar
def _copy(memory, at, count, out, into):
    """Copy numbers of the memory into an answer."""
    for i in range(count):
        out[into + i] = memory[at + i]


@scalar
def _differentiate_forward(tree, memory, out, into):
    """Write derivatives of accelerations from those of forces and the factored mass matrix."""
    n, column = tree[INDEPENDENT], tree[AT_ROOM]
    for part in range(3):
        at = tree[AT_BY_POSITIONS] if part == 0 else tree[AT_BY_SPEEDS]
        for k in range(n):
            for i in range(n):
                unit = 1.0 if i == k else 0.0
                memory[column + i] = unit if part == 2 else -memory[at + n * k + i]
            solve_positive(memory, tree[AT_MASS], n, column)
            for i in range(n):
                out[into + n * (n * part + i) + k] = memory[column + i]


@scalar
def _differentiated(question, tree, numbers, memory, forces, out, into):
    """Write the derivatives of a motion; return the outcome."""
    n = tree[INDEPENDENT]
    differentiate(tree, numbers, memory, forces)
    if question == FORWARD_DERIVATIVES:
        if not factor_positive(memory, tree[AT_MASS], n):
            return SINGULAR
        _differentiate_forward(tree, memory, out, into)
        return CLOSED
    for k in range(n):
        for i in range(n):
            out[into + n * i + k] = memory[tree[AT_BY_POSITIONS] + n * k + i]
            out[into + n * (n + i) + k] = memory[tree[AT_BY_SPEEDS] + n * k + i]
    _copy(memory, tree[AT_MASS], n * n, out, into + 2 * n * n)
    return CLOSED


@scalar
def place_frame(tree, memory, frames, row, out, into):
    """Write the placement of a frame in base axes, relative to the floating base, if any.

    Return whether an element carries it.
    """
    at = FRAME_NUMBERS * row
    e = int(frames[at])
    if e < 0:
        for i in range(12):
            out[into + i] = frames[at + 1 + i]
        return False
    compose(memory, tree[AT_PLACEMENTS] + 12 * e, frames, at + 1, out, into)
    return True


@scalar
def add_here(tree, memory, out, into):
    """Add the position of the floating base to the placement of a frame on an element."""
    for i in range(3):
        out[into + 9 + i] += memory[tree[AT_HERE] + i]


@scalar
def write_frame(tree, memory, frames, row, out, into):
    """Write the placement of a frame in the base, and its twist for each independent speed."""
    n, wide = tree[INDEPENDENT], 6 * (tree[ELEMENTS] + 1)
    if not place_frame(tree, memory, frames, row, out, into):
        for i in range(12, 12 + 6 * n):
            out[into + i] = 0.0
        return
    e = int(frames[FRAME_NUMBERS * row])
    x, y, z = out[into + 9], out[into + 10], out[into + 11]
    for j in range(n):
        X, o = tree[AT_FIELDS] + wide * j + 6 * e, into + 12 + 6 * j
        wx, wy, wz = memory[X + 3], memory[X + 4], memory[X + 5]
        out[o] = memory[X] + wy * z - wz * y
        out[o + 1] = memory[X + 1] + wz * x - wx * z
        out[o + 2] = memory[X + 2] + wx * y - wy * x
        out[o + 3], out[o + 4], out[o + 5] = wx, wy, wz
    add_here(tree, memory, out, into)


@scalar
def answer_of_pose(question, tree, numbers, memory, second, third, row, out, into):
    """Write one row of the answer to a question about the pose; return the outcome."""
    n, nv, nq, room = tree[INDEPENDENT], tree[VELOCITIES], tree[COORDINATES], tree[AT_ROOM]
    if question == FRAME:
        complement(tree, numbers, memory, 0.0)
        write_frame(tree, memory, third, row, out, into)
        return CLOSED
    if question <= COMPLEMENT:
        _copy(memory, tree[AT_CONFIGURATION], nq, out, into)
        if question == COMPLEMENT:
            complement(tree, numbers, memory, 0.0)
            _copy(memory, tree[AT_COMPLEMENT], n * nv, out, into + nq)
        return CLOSED
    # The first vector of the room is taken by the complement.
    speeds, others, result = room + n, room + 2 * n, room + 3 * n
    _take(tree, memory, second, row, speeds)
    weigh(tree, numbers, memory)
    _take(tree, memory, third, row, others)
    if question == FORWARD_DYNAMICS:
        if not accelerate(tree, numbers, memory, speeds, others, result):
            return SINGULAR
        _copy(memory, result, n, out, into)
        return CLOSED
    move_with(tree, memory, speeds)
    if question == EQUATION_OF_MOTION:
        complement(tree, numbers, memory, 1.0)
        mass_matrix(tree, numbers, memory, tree[AT_MASS])
        _copy(memory, tree[AT_MASS], n * n, out, into)
        coriolis_matrix(tree, numbers, memory, tree[AT_MASS])
        add_damping(tree, numbers, memory, tree[AT_MASS])
        _copy(memory, tree[AT_MASS], n * n, out, into + n * n)
        gravity(tree, numbers, memory, result)
        _copy(memory, result, n, out, into + 2 * n * n)
    elif question == ENERGIES:
        out[into] = kinetic_energy(tree, numbers, memory)
        out[into + 1] = potential_energy(tree, numbers, memory)
    else:
        _forces_of(tree, numbers, memory, others, result)
        if question == INVERSE_DYNAMICS:
            _copy(memory, result, n, out, into)
        else:
            _copy(memory, tree[AT_CONFIGURATION], nq, out, into)
            _copy(memory, tree[AT_JOINT_SPEEDS], nv, out, into + nq)
            _copy(memory, tree[AT_JOINT_ACCELERATIONS], nv, out, into + nq + nv)
    return CLOSED


@scalar
def row_answered(question, tree, numbers, memory, second, third, row, out, width):
    """Move to the target, and write a row of the answer there; return the outcome."""
    outcome = _reach(tree, numbers, memory)
    if outcome == CLOSED:
        into = width * row
        outcome = answer_of_pose(question, tree, numbers, memory, second, third, row, out, into)
        if outcome == CLOSED and not is_finite(out, into, into + width):
            outcome = NOT_FINITE
    if outcome != CLOSED:
        memory[tree[AT_REPORT] + 3] = float(outcome)
    return outcome


@scalar
def derivatives(question: int, tree: Indices, numbers: Array, memory: Array, out: Array) -> int:
    """Write the derivatives of the last answer; return the outcome.

    That answer was to ``INVERSE_DYNAMICS`` for ``INVERSE_DERIVATIVES``, and to ``FORWARD_DYNAMICS``
    for ``FORWARD_DERIVATIVES``. This is a separate function because it takes long to compile and is
    seldom needed.
    """
    n, room = tree[INDEPENDENT], tree[AT_ROOM]
    speeds, others, result = room + n, room + 2 * n, room + 3 * n
    if question == FORWARD_DERIVATIVES:
        for j in range(n):
            memory[others + j] = memory[result + j]
    move_with(tree, memory, speeds)
    complement(tree, numbers, memory, 1.0)
    mass_matrix(tree, numbers, memory, tree[AT_MASS])
    _forces_of(tree, numbers, memory, others, result)
    outcome: int = _differentiated(question, tree, numbers, memory, result, out, 0)
    if outcome == CLOSED and not is_finite(out, 0, out.shape[0]):
        outcome = NOT_FINITE
    memory[tree[AT_REPORT] + 3] = float(outcome)
    return outcome


@scalar
def answer(
    question: int,
    rows: int,
    is_warm: int,
    is_path: int,
    tree: Indices,
    numbers: Array,
    free_fall: Array,
    reference: Array,
    memory: Array,
    positions: Array,
    second: Array,
    third: Array,
    out: Array,
) -> int:
    """Write the answers to a question, row by row.

    ``free_fall`` is the acceleration of gravity (3). Positions are rows · p numbers, speeds
    (second), and accelerations or forces (third) rows · n each; arguments that a question does not
    need are ignored. (For a frame, ``third`` holds rows of ``FRAME_NUMBERS``.) The first row starts
    from the pose at the beginning of the memory if ``is_warm``, and otherwise from the reference.
    The other rows start from the same pose, or, on a path, from the preceding row. Return the first
    row that has no answer, −1 if all have one, or −2 if an argument has another size.
    """
    if question == EQUATIONS:
        closure_equations(tree, numbers, memory, positions, out)
        return -1
    if question == ASSEMBLY:
        became: int = settled(tree, numbers, memory)
        return became
    size, width = rows * tree[INDEPENDENT], out.shape[0] // max(rows, 1)
    if positions.shape[0] != rows * tree[POSITIONS] or second.shape[0] != size:
        return -2
    if third.shape[0] != (rows * FRAME_NUMBERS if question == FRAME else size):
        return -2
    for i in range(3):
        numbers[tree[AT_FREE_FALL] + i] = free_fall[i]
    if is_warm == 0:
        start_from(tree, reference, memory)
    # The last row that started from the reference.
    anchor = 0
    for row in range(rows):
        near = _aim(tree, memory, positions, row, anchor)
        if row > 0 and is_path == 0 and (not near or row % BLOCK == 0):
            start_from(tree, reference, memory)
            anchor = row
        if row_answered(question, tree, numbers, memory, second, third, row, out, width) != CLOSED:
            return row
    return -1


@scalar
def reach(tree, numbers, memory, positions):
    """Move to positions (p, or more) with closed loops; return the outcome."""
    for j in range(tree[POSITIONS]):
        memory[tree[AT_TARGET] + j] = positions[j]
    return _reach(tree, numbers, memory)


@scalar
def forces_of_motion(tree, numbers, memory, positions, speeds, accelerations, out):
    """Write the independent forces of a motion (n); return whether there are any."""
    n = tree[INDEPENDENT]
    if reach(tree, numbers, memory, positions) != CLOSED:
        return False
    # The first vector of the room is taken by the complement.
    at, others, result = tree[AT_ROOM] + n, tree[AT_ROOM] + 2 * n, tree[AT_ROOM] + 3 * n
    _take(tree, memory, speeds, 0, at)
    _take(tree, memory, accelerations, 0, others)
    weigh(tree, numbers, memory)
    move_with(tree, memory, at)
    _forces_of(tree, numbers, memory, others, result)
    _copy(memory, result, n, out, 0)
    return is_finite(out, 0, n)


@scalar
def balance_of_state(tree, numbers, memory, state, forces):
    """Write the mass matrix (n²), and in the room's fourth vector the forces for accelerations.

    The state is positions and speeds (p + n). Return whether the robot can be in it.
    """
    n, p = tree[INDEPENDENT], tree[POSITIONS]
    if reach(tree, numbers, memory, state) != CLOSED:
        return False
    # The first vector of the room is taken by the complement.
    speeds, others, result = tree[AT_ROOM] + n, tree[AT_ROOM] + 2 * n, tree[AT_ROOM] + 3 * n
    for j in range(n):
        memory[speeds + j] = state[p + j]
    _take(tree, memory, forces, 0, others)
    weigh(tree, numbers, memory)
    balance(tree, numbers, memory, speeds, others, result)
    return True


@scalar
def runge_kutta(tree, numbers, memory, state, forces, step, steps):
    """Take steps of the classical Runge–Kutta method under constant forces (n), in place.

    The state is positions and speeds (2n). Return whether the robot could take all poses on the
    way. The final pose is not checked.
    """
    n, target = tree[INDEPENDENT], tree[AT_TARGET]
    # The first vector of the room is taken by the complement.
    u = tree[AT_ROOM] + n
    k, moved, changed, force = u + n, u + 2 * n, u + 3 * n, u + 4 * n
    _take(tree, memory, forces, 0, force)
    for _ in range(steps):
        for j in range(n):
            memory[target + j], memory[u + j] = state[j], state[n + j]
            memory[moved + j] = memory[changed + j] = 0.0
        for stage in range(4):
            if _reach(tree, numbers, memory) != CLOSED:
                return False
            weigh(tree, numbers, memory)
            if not accelerate(tree, numbers, memory, u, force, k):
                return False
            weight = 1.0 if stage == 0 or stage == 3 else 2.0
            ahead = 0.5 * step if stage < 2 else step
            for j in range(n):
                memory[moved + j] += weight * memory[u + j]
                memory[changed + j] += weight * memory[k + j]
                if stage < 3:
                    memory[target + j] = state[j] + ahead * memory[u + j]
                    memory[u + j] = state[n + j] + ahead * memory[k + j]
        for j in range(n):
            state[j] += step / 6.0 * memory[moved + j]
            state[n + j] += step / 6.0 * memory[changed + j]
    return True
