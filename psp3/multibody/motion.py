r"""What a robot with loops answers, compiled: one function a question, of one state or of many rows.

With L the natural orthogonal complement of the loops (thesis eq. 3.17), the equation of motion of
the tree :math:`f(q, \dot q, \ddot q)` becomes :math:`L^T f(q, L \dot q^a, L \ddot q^a + \dot L
\dot q^a) = \tau` (thesis eq. 3.37).

Every function takes the arrays of a tree, the pose from which a row starts that is not near the row
before, and the memory, which begins with the pose from which the first row starts (see
:mod:`psp3.multibody.tree`). It writes its answers, and returns the first row that has none, or −1;
what became of that row is in the memory's report.
"""

from __future__ import annotations

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
    complement,
    coriolis_matrix,
    gravity,
    mass_matrix,
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
    AT_MASS,
    AT_REPORT,
    AT_ROOM,
    AT_TARGET,
    AT_VELOCITIES,
    COORDINATES,
    INDEPENDENT,
    VELOCITIES,
)

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
def _aim(tree, reference, memory, positions, row):
    """Make a row of positions the target, and choose the pose from which it is looked for."""
    target, near = tree[AT_TARGET], True
    for j in range(tree[INDEPENDENT]):
        memory[target + j] = positions[row, j]
        at = memory[tree[AT_CONFIGURATION] + tree[tree[AT_INDEPENDENT_Q] + j]]
        near = near and abs(positions[row, j] - at) <= NEAR
    if row > 0 and not near:
        start_from(tree, reference, memory)


@compiled
def _reach(tree, numbers, memory):
    """Move to the target; return whether it was reached."""
    outcome = moved_to(tree, numbers, memory)
    memory[tree[AT_REPORT] + 3] = float(outcome)
    if outcome == CLOSED:
        weigh(tree, numbers, memory)
    return outcome == CLOSED


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
def inverse_dynamics(tree, numbers, reference, memory, positions, speeds, accelerations, out):
    """Write the forces of motions, all (N, n)."""
    n, room = tree[INDEPENDENT], tree[AT_ROOM]
    for row in range(positions.shape[0]):
        _aim(tree, reference, memory, positions, row)
        if not _reach(tree, numbers, memory):
            return row
        _take(tree, memory, speeds, row, room)
        _move_with(tree, memory, room)
        _take(tree, memory, accelerations, row, room)
        _forces_of(tree, numbers, memory, room, room + n)
        for j in range(n):
            out[row, j] = memory[room + n + j]
    return -1


@compiled
def forward_dynamics(tree, numbers, reference, memory, positions, speeds, forces, out):
    """Write the accelerations under forces, all (N, n)."""
    n, room = tree[INDEPENDENT], tree[AT_ROOM] + tree[INDEPENDENT]
    for row in range(positions.shape[0]):
        _aim(tree, reference, memory, positions, row)
        if not _reach(tree, numbers, memory):
            return row
        _take(tree, memory, speeds, row, room)
        _take(tree, memory, forces, row, room + n)
        if not accelerate(tree, numbers, memory, room, room + n, room + 2 * n):
            memory[tree[AT_REPORT] + 3] = float(SINGULAR)
            return row
        for j in range(n):
            out[row, j] = memory[room + 2 * n + j]
    return -1


@compiled
def equation_of_motion(tree, numbers, reference, memory, positions, speeds, out):
    """Write M, C (n² each) and G (n), row by row."""
    n, room = tree[INDEPENDENT], tree[AT_ROOM]
    for row in range(positions.shape[0]):
        _aim(tree, reference, memory, positions, row)
        if not _reach(tree, numbers, memory):
            return row
        _take(tree, memory, speeds, row, room)
        _move_with(tree, memory, room)
        complement(tree, numbers, memory, 1)
        mass_matrix(tree, numbers, memory, tree[AT_MASS])
        for i in range(n * n):
            out[row, i] = memory[tree[AT_MASS] + i]
        coriolis_matrix(tree, memory, tree[AT_MASS])
        for i in range(n * n):
            out[row, n * n + i] = memory[tree[AT_MASS] + i]
        gravity(tree, numbers, memory, room)
        for j in range(n):
            out[row, 2 * n * n + j] = memory[room + j]
    return -1


@compiled
def configurations(tree, numbers, reference, memory, positions, along, out):
    """Write closed configurations (N, nq); ``along`` a path each starts from the one before."""
    for row in range(positions.shape[0]):
        if along:
            _take(tree, memory, positions, row, tree[AT_TARGET])
        else:
            _aim(tree, reference, memory, positions, row)
        closed = _reach(tree, numbers, memory)
        for i in range(tree[COORDINATES]):
            out[row, i] = memory[tree[AT_CONFIGURATION] + i]
        if not closed:
            return row
    return -1


@compiled
def complements(tree, numbers, reference, memory, positions, out):
    """Write L, column by column (N, n · nv)."""
    for row in range(positions.shape[0]):
        _aim(tree, reference, memory, positions, row)
        if not _reach(tree, numbers, memory):
            return row
        complement(tree, numbers, memory, 0)
        for i in range(tree[INDEPENDENT] * tree[VELOCITIES]):
            out[row, i] = memory[tree[AT_COMPLEMENT] + i]
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
            if not _reach(tree, numbers, memory):
                return step
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
