"""Compiled Runge–Kutta steps of any tree with loops: without drives, or from event to event."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from fuzzy2.support.compiled import compiled
from psp3.checks import Array, Indices, checked_steps
from psp3.drives.drive import Drive, drive_table
from psp3.drives.kernels import DRY, INERTIA, VISCOUS
from psp3.dynamics.compiled_robot import (
    advance,
    allocate,
    balance,
    is_state,
    write_forces,
    write_rates,
)
from psp3.dynamics.driven_steps import advance_driven
from psp3.dynamics.motor_kernels import shortest
from psp3.dynamics.motors import Driven, Motors
from psp3.multibody.closing import CLOSED
from psp3.multibody.core import Core, Tables
from psp3.multibody.inertia import complement, factor_positive, solve_positive
from psp3.multibody.motion import balance_of_state, forces_of_motion, reach, runge_kutta
from psp3.multibody.tree import (
    AT_COMPLEMENT,
    AT_JOINT_ACCELERATIONS,
    AT_JOINTS,
    AT_MASS,
    AT_ROOM,
    FRICTION,
    JOINT_NUMBERS,
    POSITIONS,
    VELOCITIES,
)

LEAST_LEVER = 1e-200
"""Smallest lever arm of another joint's friction at a coordinate. At a dead center of that joint
the friction must not become zero, because a coordinate without friction counts as slipping.
"""

PLANAR_COORDINATES = 4
"""Number of coordinates of a planar base: position, and the cosine and sine of its angle."""


class DrivenTables(NamedTuple):
    """A robot with drives, or whose coordinates are not its motors.

    It takes much longer to compile than a robot without drives. ``motors`` (nv, m) are the joint
    velocities that each motor drives; ``rest`` (n,) is zeros; ``base`` is the number of coordinates
    of a floating base, which come last: 7, or 4 in a plane, or none. ``dry`` (n,) is the dry
    friction at the coordinates; ``columns`` (nv, w), ``elsewhere`` (w, 3) and ``follows`` (w,) are
    drives elsewhere, see :class:`psp3.dynamics.motors.Driven`; and ``along`` (n,) is scratch space.
    """

    tree: Indices
    numbers: Array
    memory: Array
    motors: Array
    rest: Array
    base: int
    dry: Array
    columns: Array
    elsewhere: Array
    follows: Indices
    along: Array


@balance.register(DrivenTables)
def _balance(
    robot: DrivenTables, state: Array, forces: Array, drives: Array, mass: Array, net: Array
) -> None:
    n, tree, memory, motors = net.size, robot.tree, robot.memory, robot.motors
    nv, p = tree[VELOCITIES], tree[POSITIONS]
    is_state = balance_of_state(tree, robot.numbers, memory, state, robot.rest)
    for i in range(n):
        net[i] = memory[tree[AT_ROOM] + 3 * n + i] - drives[i, VISCOUS] * state[p + i]
    # The motors' forces along the coordinates, L^T B τ.
    for v in range(nv):
        force = 0.0
        for j in range(forces.size):
            force += motors[v, j] * forces[j]
        if force != 0.0:
            for i in range(n):
                net[i] += memory[tree[AT_COMPLEMENT] + nv * i + v] * force
    for i in range(n):
        for j in range(n):
            mass[i, j] = memory[tree[AT_MASS] + n * i + j] if is_state else math.nan
        mass[i, i] += drives[i, INERTIA]
    if robot.follows.size > 0:
        _add_elsewhere(robot, state, drives, mass, net)


@compiled
def _add_elsewhere(
    robot: DrivenTables, state: Array, drives: Array, mass: Array, net: Array
) -> None:
    """Add the effect of drives elsewhere to a balance whose L and drift are known.

    The dry friction of a drive that follows a single coordinate is added to that of the coordinate.
    """
    n, tree, memory, columns = net.size, robot.tree, robot.memory, robot.columns
    nv, p, along = tree[VELOCITIES], tree[POSITIONS], robot.along
    L, drift = tree[AT_COMPLEMENT], tree[AT_JOINT_ACCELERATIONS]
    for i in range(n):
        drives[i, DRY] = robot.dry[i]
    for w in range(robot.follows.size):
        inertia, viscous = robot.elsewhere[w, INERTIA], robot.elsewhere[w, VISCOUS]
        dry, speed, change = robot.elsewhere[w, DRY], 0.0, 0.0
        for i in range(n):
            along[i] = 0.0
            for v in range(nv):
                along[i] += memory[L + nv * i + v] * columns[v, w]
            speed += along[i] * state[p + i]
        for v in range(nv):
            change += columns[v, w] * memory[drift + v]
        force, follows = inertia * change + viscous * speed, robot.follows[w]
        if follows >= 0:
            drives[follows, DRY] += dry * (abs(along[follows]) + LEAST_LEVER)
        elif speed != 0.0:
            force += dry if speed > 0.0 else -dry
        for i in range(n):
            net[i] -= along[i] * force
            for j in range(n):
                mass[i, j] += inertia * along[i] * along[j]


@compiled
def _is_state(tree: Indices, numbers: Array, memory: Array, state: Array) -> bool:
    total = 0.0
    for i in range(state.size):
        total += abs(state[i])
    arrived: bool = total < math.inf and reach(tree, numbers, memory, state) == CLOSED
    return arrived


@advance.register(Tables)
@compiled
def advance_free(
    robot: Tables, state: Array, forces: Array, step: float, steps: int, drives: Array
) -> bool:
    """Take Runge–Kutta steps under constant forces (n,), in place, without drives.

    The memory begins with a pose near the state, or the reference. Return whether the final state
    is finite and the robot can be in it.
    """
    tree, numbers, memory = robot
    went = runge_kutta(tree, numbers, memory, state, forces, step, steps)
    arrived: bool = went and _is_state(tree, numbers, memory, state)
    return arrived


@write_rates.register(DrivenTables)
def _write_rates(robot: DrivenTables, state: Array, rates: Array) -> None:
    p = robot.tree[POSITIONS]
    base, n = p - robot.base, state.size - p
    for i in range(base):
        rates[i] = state[p + i]
    if robot.base == PLANAR_COORDINATES:
        _write_rates_in_plane(state, base, p + n - 3, rates)
    elif robot.base > 0:
        _write_rates_of_flyer(state, base, p + n - 6, rates)


@compiled
def _write_rates_in_plane(state: Array, q: int, u: int, rates: Array) -> None:
    """Write the rates of a planar base's coordinates at q, from its speeds in its own axes at u.

    Cosine and sine are first normalized.
    """
    size = math.hypot(state[q + 2], state[q + 3])
    c, s = state[q + 2] / size, state[q + 3] / size
    state[q + 2], state[q + 3] = c, s
    rates[q], rates[q + 1] = c * state[u] - s * state[u + 1], s * state[u] + c * state[u + 1]
    rates[q + 2], rates[q + 3] = -s * state[u + 2], c * state[u + 2]


@compiled
def _write_rates_of_flyer(state: Array, q: int, u: int, rates: Array) -> None:
    """Write the rates of a floating base's coordinates at q, from its speeds in its own axes at u.

    The quaternion (x, y, z, w) is first normalized.
    """
    x, y, z, w = state[q + 3], state[q + 4], state[q + 5], state[q + 6]
    size = math.sqrt(x * x + y * y + z * z + w * w)
    x, y, z, w = x / size, y / size, z / size, w / size
    state[q + 3], state[q + 4], state[q + 5], state[q + 6] = x, y, z, w
    a, b, c = state[u + 3], state[u + 4], state[u + 5]
    rates[q + 3] = 0.5 * (w * a + y * c - z * b)
    rates[q + 4] = 0.5 * (w * b + z * a - x * c)
    rates[q + 5] = 0.5 * (w * c + x * b - y * a)
    rates[q + 6] = -0.5 * (x * a + y * b + z * c)
    a, b, c = state[u], state[u + 1], state[u + 2]
    # Twice the cross product of the quaternion's vector with the velocity.
    d, e, f = 2.0 * (y * c - z * b), 2.0 * (z * a - x * c), 2.0 * (x * b - y * a)
    rates[q] = a + w * d + y * f - z * e
    rates[q + 1] = b + w * e + z * d - x * f
    rates[q + 2] = c + w * f + x * e - y * d


@is_state.register(Tables)
def _is_free_state(robot: Tables, state: Array) -> bool:
    arrived: bool = _is_state(robot.tree, robot.numbers, robot.memory, state)
    return arrived


@is_state.register(DrivenTables)
def _is_driven_state(robot: DrivenTables, state: Array) -> bool:
    arrived: bool = _is_state(robot.tree, robot.numbers, robot.memory, state)
    return arrived


@advance.register(DrivenTables)
def _advance_driven(
    robot: DrivenTables, state: Array, forces: Array, step: float, steps: int, drives: Array
) -> bool:
    valid: bool = advance_driven(robot, state, forces, step, steps, drives)
    return valid


@write_forces.register(Tables)
def _write_forces(
    robot: Tables, positions: Array, speeds: Array, accelerations: Array, out: Array
) -> bool:
    tree, numbers, memory = robot
    done: bool = forces_of_motion(tree, numbers, memory, positions, speeds, accelerations, out)
    return done


@allocate.register(Tables)
def _allocate(robot: Tables, positions: Array, forces: Array, out: Array) -> bool:
    # The forces are along the motors' own coordinates.
    for i in range(forces.size):
        out[i] = forces[i]
    return True


@compiled
def _write_actuation(robot: DrivenTables, out: Array) -> None:
    """Write the force of each motor along the first coordinates, (k, m), for a pose with its L."""
    tree, memory, motors = robot.tree, robot.memory, robot.motors
    nv = tree[VELOCITIES]
    k, m = out.shape
    for i in range(k):
        for j in range(m):
            total = 0.0
            for v in range(nv):
                total += memory[tree[AT_COMPLEMENT] + nv * i + v] * motors[v, j]
            out[i, j] = total


@compiled
def forces_of_all(
    robot: DrivenTables, positions: Array, speeds: Array, accelerations: Array, out: Array
) -> bool:
    """Write the shortest motor forces (m,) for accelerations of all coordinates."""
    n, tree, numbers, memory = speeds.size, robot.tree, robot.numbers, robot.memory
    along, actuation = np.empty(n), np.empty((n, out.size))
    if not forces_of_motion(tree, numbers, memory, positions, speeds, accelerations, along):
        return False
    complement(tree, numbers, memory, 0.0)
    _write_actuation(robot, actuation)
    done: bool = shortest(actuation, along, out)
    return done


@compiled
def forces_of_first(
    robot: DrivenTables, positions: Array, speeds: Array, accelerations: Array, out: Array
) -> bool:
    """Write the shortest motor forces (m,) for accelerations of the first coordinates (k,).

    The method is that of :func:`psp3.dynamics.motors.partly_linearizing`.
    """
    p, n, k, m = positions.size, speeds.size, accelerations.size, out.size
    tree, numbers, memory, state = robot.tree, robot.numbers, robot.memory, np.empty(p + n)
    for i in range(p):
        state[i] = positions[i]
    for i in range(n):
        state[p + i] = speeds[i]
    if not balance_of_state(tree, numbers, memory, state, robot.rest):
        return False
    actuation, made, wanted = np.empty((n, m)), np.empty((k, m)), np.empty(k)
    _write_actuation(robot, actuation)
    # The room's fourth vector holds the forces for accelerations, and the fifth is free.
    mass, left, column = tree[AT_MASS], tree[AT_ROOM] + 3 * n, tree[AT_ROOM] + 4 * n
    if not factor_positive(memory, mass, n):
        return False
    solve_positive(memory, mass, n, left)
    for i in range(k):
        wanted[i] = accelerations[i] - memory[left + i]
    for j in range(m):
        for i in range(n):
            memory[column + i] = actuation[i, j]
        solve_positive(memory, mass, n, column)
        for i in range(k):
            made[i, j] = memory[column + i]
    done: bool = shortest(made, wanted, out)
    return done


@write_forces.register(DrivenTables)
def _write_forces_of_motors(
    robot: DrivenTables, positions: Array, speeds: Array, accelerations: Array, out: Array
) -> bool:
    if accelerations.size < speeds.size:
        done: bool = forces_of_first(robot, positions, speeds, accelerations, out)
    else:
        done = forces_of_all(robot, positions, speeds, accelerations, out)
    return done


@compiled
def shared_among_motors(robot: DrivenTables, positions: Array, forces: Array, out: Array) -> bool:
    """Write the shortest motor forces (m,) for forces along the first coordinates (k,)."""
    tree, numbers, memory = robot.tree, robot.numbers, robot.memory
    if reach(tree, numbers, memory, positions) != CLOSED:
        return False
    complement(tree, numbers, memory, 0.0)
    actuation = np.empty((forces.size, out.size))
    _write_actuation(robot, actuation)
    done: bool = shortest(actuation, forces, out)
    return done


@allocate.register(DrivenTables)
def _allocate_to_motors(robot: DrivenTables, positions: Array, forces: Array, out: Array) -> bool:
    done: bool = shared_among_motors(robot, positions, forces, out)
    return done


def tables_of_motors(core: Core, motors: Motors, driven: Driven | None = None) -> DrivenTables:
    """Return the table of a robot with drives, or whose coordinates are not its motors."""
    tables, rest = core.tables(), np.zeros(len(motors.speeds))
    driven = motors.without_drives() if driven is None else driven
    return DrivenTables(
        *(*tables, motors.matrix, rest, motors.base_coordinates),
        np.ascontiguousarray(driven.coordinates[:, DRY]),
        *(driven.columns, driven.elsewhere, driven.follows, np.zeros(len(rest))),
    )


class CoreSteps:
    """A plant: any tree with loops, compiled.

    Its state is positions and speeds of the coordinates, (p,) and (n,); its forces are those of the
    motors, (m,). A floating base's position and quaternion also take classical Runge–Kutta steps,
    and the quaternion is normalized after each step, which preserves the order of the method. Dry
    friction, of the joint itself or of its drive, can hold a joint that is a coordinate or follows
    a single coordinate.

    Parameters
    ----------
    core : Core
        The robot's core.
    motors : Motors
        What the motors drive.
    steps : int
        Integration steps in a control period.
    drive : Drive or sequence of Drive
        Friction and motor inertia of all actuated joints, or of each.
    """

    def __init__(
        self, core: Core, motors: Motors, steps: int, drive: Drive | Sequence[Drive]
    ) -> None:
        self._core, self._motors, self.steps = core, motors, checked_steps(steps)
        self._driven = driven = motors.driven(drive_table(drive, len(motors.names)))
        self.drives = driven.coordinates.copy()
        is_elsewhere = driven.follows[driven.elsewhere[:, DRY] > 0.0]
        # The amount of friction depends on the pose, but not whether there is any.
        self.drives[is_elsewhere[is_elsewhere >= 0], DRY] += LEAST_LEVER
        self._is_driven = (
            bool(self.drives.any()) or bool(driven.follows.size) or not motors.are_coordinates
        )
        self._advance: Any = advance_driven if self._is_driven else advance_free
        self._positions = int(core.tree[POSITIONS])
        self.robot, self.state = self._tables(), np.zeros(self._positions + len(motors.speeds))

    def _tables(self) -> Tables | DrivenTables:
        if not self._is_driven:
            return self._core.tables()
        tables = tables_of_motors(self._core, self._motors, self._driven)
        numbers = tables.numbers.copy()
        # The integrator handles friction that can hold a joint at rest.
        for velocity in self._driven.joints:
            numbers[tables.tree[AT_JOINTS] + JOINT_NUMBERS * velocity + FRICTION] = 0.0
        return tables._replace(numbers=numbers)

    def start(self, positions: Array, speeds: Array) -> None:
        """Put the robot into a state.

        The state is positions (p,) [m, rad] and speeds (n,) of the coordinates.
        """
        self.robot, self.state = self._tables(), np.concatenate([positions, speeds])

    def advance(self, forces: Array, duration: float) -> tuple[Array, Array] | None:
        """Return positions (p,) and speeds (n,) after ``duration`` [s], or None."""
        step, p = duration / self.steps, self._positions
        valid = self._advance(self.robot, self.state, forces, step, self.steps, self.drives)
        return (self.state[:p], self.state[p:]) if valid else None
