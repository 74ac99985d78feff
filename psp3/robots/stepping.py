"""Compiled Runge–Kutta steps of any tree with loops: free, or with drives from event to event."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from fuzzy2.support.compiled import compiled
from psp3.checks import Array, Indices, checked_count
from psp3.drives.drive import Drive, drive_table
from psp3.drives.kernels import INERTIA, VISCOUS
from psp3.dynamics.compiled_robot import advance, balance, is_state, write_forces
from psp3.dynamics.driven_steps import advance_driven
from psp3.multibody.closing import CLOSED
from psp3.multibody.core import Core, Tables
from psp3.multibody.motion import balance_of_state, forces_of_motion, reach, runge_kutta
from psp3.multibody.tree import AT_MASS, AT_ROOM


class DrivenTables(NamedTuple):
    """A robot with drives: what takes much longer to compile than one without."""

    tree: Indices
    numbers: Array
    memory: Array


@balance.register(DrivenTables)
def _balance(
    robot: DrivenTables, state: Array, forces: Array, drives: Array, mass: Array, net: Array
) -> None:
    n, tree, memory = net.size, robot.tree, robot.memory
    is_state = balance_of_state(tree, robot.numbers, memory, state, forces)
    for i in range(n):
        net[i] = memory[tree[AT_ROOM] + 3 * n + i] - drives[i, VISCOUS] * state[n + i]
        for j in range(n):
            mass[i, j] = memory[tree[AT_MASS] + n * i + j] if is_state else math.nan
        mass[i, i] += drives[i, INERTIA]


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

    The memory begins with a pose near the state, or the reference. Return whether the state reached
    is finite and one of the robot's.
    """
    tree, numbers, memory = robot
    went = runge_kutta(tree, numbers, memory, state, forces, step, steps)
    arrived: bool = went and _is_state(tree, numbers, memory, state)
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


class CoreSteps:
    """A plant: any tree with loops, compiled.

    Parameters
    ----------
    core : Core
        The robot's core.
    steps : int
        Integration steps in a control period.
    drive : Drive or sequence of Drive
        Friction and motor inertia of all actuated joints, or of each.
    """

    def __init__(self, core: Core, steps: int, drive: Drive | Sequence[Drive]) -> None:
        self._core, self.steps = core, checked_count("steps", steps)
        self._joints = core.joints
        self.drives = drive_table(drive, self._joints)
        self._advance: Any = advance_driven if self.drives.any() else advance_free
        self.robot, self.state = self._tables(), np.zeros(2 * self._joints)

    def _tables(self) -> Tables | DrivenTables:
        tables = self._core.tables()
        return DrivenTables(*tables) if self.drives.any() else tables

    def start(self, positions: Array, speeds: Array) -> None:
        """Put the robot into a state.

        Positions [m, rad] and speeds of the actuated joints, each (n,).
        """
        self.robot, self.state = self._tables(), np.concatenate([positions, speeds])

    def advance(self, forces: Array, duration: float) -> tuple[Array, Array] | None:
        """Return positions and speeds, each (n,), after ``duration`` [s], or None."""
        step = duration / self.steps
        valid = self._advance(self.robot, self.state, forces, step, self.steps, self.drives)
        return (self.state[: self._joints], self.state[self._joints :]) if valid else None
