r"""What a robot with loops answers, compiled: one question about one state, or about many rows.

With L the natural orthogonal complement of the loops (thesis eq. 3.17), the equation of motion of
the tree :math:`f(q, \dot q, \ddot q)` becomes :math:`L^T f(q, L \dot q^a, L \ddot q^a + \dot L
\dot q^a) = \tau` (thesis eq. 3.37).

All questions go through one function, because every compiled function that Python can call costs
seconds to compile.
"""

from __future__ import annotations

import math

from fuzzy2.support.compiled import compiled
from psp3.multibody.bodies import weigh
from psp3.multibody.closing import CLOSED, SINGULAR, moved_to, settled
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
    add_joints,
    complement,
    coriolis_matrix,
    gravity,
    kinetic_energy,
    mass_matrix,
    potential_energy,
    solve_positive,
)
from psp3.multibody.tree import (
    AT_ACCELERATIONS,
    AT_BEFORE,
    AT_COMPLEMENT,
    AT_CONFIGURATION,
    AT_INDEPENDENT_Q,
    AT_JOINT_ACCELERATIONS,
    AT_JOINT_FORCES,
    AT_JOINT_SPEEDS,
    AT_LIMITS,
    AT_MASS,
    AT_REPORT,
    AT_ROOM,
    AT_TARGET,
    AT_VELOCITIES,
    COORDINATES,
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
) = range(7)
"""Questions, and what their answers are: q (nq); q and L, column by column (n · nv); forces of a
motion (n); accelerations under forces (n); M, C (n² each) and G (n); kinetic and potential energy;
configuration, velocities and accelerations of all joints.
"""

BEYOND_LIMIT, NOT_FINITE = 3, 4
"""What can become of a row besides what becomes of a closure: a dependent joint is beyond its
limits; there is no finite answer.
"""

NEAR = 0.1
"""A row starts from the pose of the row before where no independent coordinate is farther from it
than this [m, rad], and else from the reference: so its answer does not depend on other rows.
"""


@compiled
def start_from(tree, reference, memory):
    """Begin the memory with the reference pose."""
    for i in range(tree[AT_BEFORE]):
        memory[i] = reference[i]


@compiled
def assemble(tree, numbers, memory):
    """Close the loops from the guess with which the memory begins, independent joints fixed.

    Return what became of it. The memory then begins with a pose that can be a reference.
    """
    return settled(tree, numbers, memory)


@compiled
def _aim(tree, memory, positions, row):
    """Make a row of positions the target; return whether it is near the pose."""
    target, near = tree[AT_TARGET], True
    for j in range(tree[POSITIONS]):
        memory[target + j] = positions[row, j]
        at = memory[tree[AT_CONFIGURATION] + tree[tree[AT_INDEPENDENT_Q] + j]]
        near = near and abs(positions[row, j] - at) <= NEAR
    return near


@compiled
def _reach(tree, numbers, memory):
    """Move to the target, all loops closed; return what became of it."""
    outcome = moved_to(tree, numbers, memory)
    if outcome == CLOSED:
        q, limits = tree[AT_CONFIGURATION], tree[AT_LIMITS]
        for i in range(tree[COORDINATES]):
            k = limits + 2 * i
            if not numbers[k] <= memory[q + i] <= numbers[k + 1]:
                return BEYOND_LIMIT
    return outcome


@compiled
def _is_finite(out, row):
    """Tell whether all numbers of a row are finite."""
    for i in range(out.shape[1]):
        if not abs(out[row, i]) < math.inf:
            return False
    return True


@compiled
def _move_with(tree, memory, speeds):
    """Give all joints and elements the velocities of independent speeds."""
    z, V = tree[AT_JOINT_SPEEDS], tree[AT_VELOCITIES]
    joint_speeds(tree, memory, speeds, z)
    carried(tree, memory, z, V, tree[AT_ACCELERATIONS])


@compiled
def _forces_of(tree, numbers, memory, accelerations, out):
    """Write the independent forces of a motion, of which the velocities are there."""
    change, rate = tree[AT_JOINT_ACCELERATIONS], tree[AT_ACCELERATIONS]
    independent_speeds(tree, memory, accelerations, change)
    change_of_joint_speeds(
        tree, numbers, memory, tree[AT_JOINT_SPEEDS], tree[AT_VELOCITIES], rate, change
    )
    add_change(tree, memory, change, rate)
    joint_forces(tree, numbers, memory)
    projected(tree, memory, tree[AT_JOINT_FORCES], out)


@compiled
def accelerate(tree, numbers, memory, speeds, forces, out):
    """Write the accelerations of a closed pose under forces; return whether there are any."""
    n = tree[INDEPENDENT]
    for j in range(n):
        memory[out + j] = 0.0
    _move_with(tree, memory, speeds)
    _forces_of(tree, numbers, memory, out, out)
    for j in range(n):
        memory[out + j] = memory[forces + j] - memory[out + j]
    complement(tree, numbers, memory, 0)
    mass_matrix(tree, numbers, memory, tree[AT_MASS])
    return solve_positive(memory, tree[AT_MASS], n, out)


@compiled
def _take(tree, memory, values, row, at):
    """Copy a row of independent speeds, accelerations or forces into the memory."""
    for j in range(tree[INDEPENDENT]):
        memory[at + j] = values[row, j]


@compiled
def _copy(memory, at, count, out, row, column):
    """Copy numbers of the memory into a row, from a column on."""
    for i in range(count):
        out[row, column + i] = memory[at + i]


@compiled
def _answer(question, tree, numbers, memory, second, third, out, row):
    """Write one row of the answer to a question about the pose; return what became of it."""
    n, nv, nq, room = tree[INDEPENDENT], tree[VELOCITIES], tree[COORDINATES], tree[AT_ROOM]
    if question <= COMPLEMENT:
        _copy(memory, tree[AT_CONFIGURATION], nq, out, row, 0)
        if question == COMPLEMENT:
            complement(tree, numbers, memory, 0)
            _copy(memory, tree[AT_COMPLEMENT], n * nv, out, row, nq)
        return CLOSED
    # The first vector of the room is taken by the complement.
    speeds, others, result = room + n, room + 2 * n, room + 3 * n
    _take(tree, memory, second, row, speeds)
    weigh(tree, numbers, memory)
    if question == FORWARD_DYNAMICS:
        _take(tree, memory, third, row, others)
        if not accelerate(tree, numbers, memory, speeds, others, result):
            return SINGULAR
        _copy(memory, result, n, out, row, 0)
        return CLOSED
    _move_with(tree, memory, speeds)
    if question == EQUATION_OF_MOTION:
        complement(tree, numbers, memory, 1)
        mass_matrix(tree, numbers, memory, tree[AT_MASS])
        _copy(memory, tree[AT_MASS], n * n, out, row, 0)
        coriolis_matrix(tree, memory, tree[AT_MASS])
        add_joints(tree, numbers, memory, tree[AT_MASS])
        _copy(memory, tree[AT_MASS], n * n, out, row, n * n)
        gravity(tree, numbers, memory, result)
        _copy(memory, result, n, out, row, 2 * n * n)
    elif question == ENERGIES:
        out[row, 0] = kinetic_energy(tree, numbers, memory)
        out[row, 1] = potential_energy(tree, numbers, memory)
    else:
        _take(tree, memory, third, row, others)
        _forces_of(tree, numbers, memory, others, result)
        if question == INVERSE_DYNAMICS:
            _copy(memory, result, n, out, row, 0)
        else:
            _copy(memory, tree[AT_CONFIGURATION], nq, out, row, 0)
            _copy(memory, tree[AT_JOINT_SPEEDS], nv, out, row, nq)
            _copy(memory, tree[AT_JOINT_ACCELERATIONS], nv, out, row, nq + nv)
    return CLOSED


@compiled
def answer(
    question, tree, numbers, reference, memory, is_warm, is_path, positions, second, third, out
):
    """Write the answers to a question, row by row (N, w).

    Positions are (N, p); the second argument are speeds, the third accelerations or forces, both
    (N, n); where a question
    needs fewer, they are not looked at. With ``is_warm`` the memory begins with a pose from which
    the first row starts, and else that is the reference; the other rows start from it, too, but on
    a path from the row before. Return the first row that has no answer, or −1.
    """
    if is_warm == 0:
        start_from(tree, reference, memory)
    for row in range(positions.shape[0]):
        near = _aim(tree, memory, positions, row)
        if row > 0 and is_path == 0 and not near:
            start_from(tree, reference, memory)
        outcome = _reach(tree, numbers, memory)
        if outcome == CLOSED:
            outcome = _answer(question, tree, numbers, memory, second, third, out, row)
        if outcome == CLOSED and not _is_finite(out, row):
            outcome = NOT_FINITE
        if outcome != CLOSED:
            memory[tree[AT_REPORT] + 3] = float(outcome)
            return row
    return -1


@compiled
def runge_kutta(tree, numbers, memory, positions, speeds, forces, duration, steps, trace):
    """Take steps of the classical Runge–Kutta method under constant forces (n), in place.

    ``trace`` (steps, 2 n) gets the states. Return the step at which there was no answer, or −1.
    """
    n, h, target = tree[INDEPENDENT], duration, tree[AT_TARGET]
    # The first vector of the room is taken by the complement.
    u = tree[AT_ROOM] + n
    k, moved, changed, force = u + n, u + 2 * n, u + 3 * n, u + 4 * n
    for j in range(n):
        memory[force + j] = forces[j]
    for step in range(steps):
        for j in range(n):
            memory[target + j], memory[u + j] = positions[j], speeds[j]
            memory[moved + j] = memory[changed + j] = 0.0
        for stage in range(4):
            outcome = _reach(tree, numbers, memory)
            if outcome != CLOSED:
                memory[tree[AT_REPORT] + 3] = float(outcome)
                return step
            weigh(tree, numbers, memory)
            if not accelerate(tree, numbers, memory, u, force, k):
                memory[tree[AT_REPORT] + 3] = float(SINGULAR)
                return step
            weight = 1.0 if stage == 0 or stage == 3 else 2.0
            ahead = 0.5 * h if stage < 2 else h
            for j in range(n):
                memory[moved + j] += weight * memory[u + j]
                memory[changed + j] += weight * memory[k + j]
                if stage < 3:
                    memory[target + j] = positions[j] + ahead * memory[u + j]
                    memory[u + j] = speeds[j] + ahead * memory[k + j]
        for j in range(n):
            positions[j] += h / 6.0 * memory[moved + j]
            speeds[j] += h / 6.0 * memory[changed + j]
            trace[step, j], trace[step, n + j] = positions[j], speeds[j]
    return -1
