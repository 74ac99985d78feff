"""The functions of a robot's C code: the core's kernels, started from the caller's last pose.

These functions are translated to C, and also run in Python. Each takes the robot's tables, the
caller's state (the core's memory, the report, and whether the memory begins with a closed pose),
arguments and results. Each returns a code; unless it is ``DONE``, the results are NaN.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from psp3.checks import Array, Indices
from psp3.multibody.bodies import weigh
from psp3.multibody.closing import CLOSED, OPEN
from psp3.multibody.inertia import complement, mass_matrix
from psp3.multibody.motion import (
    CONFIGURATION,
    EQUATION_OF_MOTION,
    FORWARD_DYNAMICS,
    FRAME,
    INVERSE_DYNAMICS,
    NOT_FINITE,
    add_here,
    is_finite,
    move_with,
    place_frame,
    reach,
    row_answered,
    start_from,
)
from psp3.multibody.tree import (
    AT_MASS,
    AT_REPORT,
    AT_ROOM,
    AT_TARGET,
    INDEPENDENT,
    POSITIONS,
)
from psp3.robots.stepping import DrivenTables, forces_of_all, forces_of_first

DONE, UNREACHABLE = CLOSED, 5
"""Codes besides those of :mod:`psp3.multibody.motion`: done; the motors cannot produce the
motion."""

REPORT = 3
"""Length of the report: share of the way, residual [m, rad], group of loops."""


class CoreTables(NamedTuple):
    """A robot for translated kernels: the tree, its numbers, and the reference pose."""

    tree: Indices
    numbers: Array
    reference: Array


class MotorTables(NamedTuple):
    """Tables of motors that are not coordinates, see :class:`psp3.robots.stepping.DrivenTables`."""

    motors: Array
    rest: Array
    base: int
    dry: Array
    columns: Array
    elsewhere: Array
    follows: Indices
    along: Array


def reset(robot, memory, report, closed):
    """Reset the robot to its reference pose, from which the next pose is searched."""
    start_from(robot.tree, robot.reference, memory)
    closed[0] = 1
    for i in range(REPORT):
        report[i] = 0.0


def begin(robot, memory, closed, positions):
    """Start from the last pose, or from the reference if there is none, towards positions."""
    tree = robot.tree
    if closed[0] != 1:
        start_from(tree, robot.reference, memory)
    # The memory holds no closed pose until this call succeeds.
    closed[0] = 0
    for j in range(tree[POSITIONS]):
        memory[tree[AT_TARGET] + j] = positions[j]


def ended(outcome, robot, memory, report, closed, out):
    """Return a code; after a failure the report says how far the call came, and results are NaN."""
    report[0], report[1], report[2] = 1.0, 0.0, 0.0
    if outcome == DONE:
        closed[0] = 1
        return outcome
    if outcome == OPEN:
        for i in range(REPORT):
            report[i] = memory[robot.tree[AT_REPORT] + i]
    for i in range(out.size):
        out[i] = math.nan
    return outcome


def answered(question, robot, memory, report, closed, positions, second, third, out):
    """Write the results of a request to the core; return a code."""
    begin(robot, memory, closed, positions)
    outcome = row_answered(
        question, robot.tree, robot.numbers, memory, second, third, 0, out, out.size
    )
    return ended(outcome, robot, memory, report, closed, out)


def configuration(robot, memory, report, closed, positions, q):
    """Write the coordinates of all joints (nq)."""
    return answered(
        CONFIGURATION, robot, memory, report, closed, positions, positions, positions, q
    )


def inverse_dynamics(robot, memory, report, closed, positions, speeds, accelerations, forces):
    """Write the forces along the coordinates (n) for a motion."""
    return answered(
        INVERSE_DYNAMICS, robot, memory, report, closed, positions, speeds, accelerations, forces
    )


def forward_dynamics(robot, memory, report, closed, positions, speeds, forces, accelerations):
    """Write the accelerations (n) under forces along the coordinates."""
    return answered(
        FORWARD_DYNAMICS, robot, memory, report, closed, positions, speeds, forces, accelerations
    )


def equation_of_motion(robot, memory, report, closed, positions, speeds, M, C, G):
    """Write mass matrix (n, n), Coriolis matrix (n, n) and gravity (n)."""
    n = robot.tree[INDEPENDENT]
    out = np.empty(2 * n * n + n)
    outcome = answered(
        EQUATION_OF_MOTION, robot, memory, report, closed, positions, speeds, speeds, out
    )
    for i in range(n * n):
        M[i], C[i] = out[i], out[n * n + i]
    for i in range(n):
        G[i] = out[2 * n * n + i]
    return outcome


def mass(robot, memory, report, closed, positions, M):
    """Write the mass matrix (n, n), as :func:`equation_of_motion` does at rest."""
    tree, numbers, n = robot.tree, robot.numbers, robot.tree[INDEPENDENT]
    begin(robot, memory, closed, positions)
    outcome = reach(tree, numbers, memory, positions)
    if outcome == CLOSED:
        speeds = tree[AT_ROOM] + n
        for j in range(n):
            memory[speeds + j] = 0.0
        weigh(tree, numbers, memory)
        move_with(tree, memory, speeds)
        complement(tree, numbers, memory, 1.0)
        mass_matrix(tree, numbers, memory, tree[AT_MASS])
        for i in range(n * n):
            M[i] = memory[tree[AT_MASS] + i]
        if not is_finite(M, 0, n * n):
            outcome = NOT_FINITE
    return ended(outcome, robot, memory, report, closed, M)


def placement(robot, frame, memory, report, closed, positions, out):
    """Write the placement of a frame in the base: rotation, row by row (9), and position (3)."""
    begin(robot, memory, closed, positions)
    outcome = reach(robot.tree, robot.numbers, memory, positions)
    if outcome == CLOSED:
        if place_frame(robot.tree, memory, frame, 0, out, 0):
            add_here(robot.tree, memory, out, 0)
        if not is_finite(out, 0, 12):
            outcome = NOT_FINITE
    return ended(outcome, robot, memory, report, closed, out)


def jacobian(robot, frame, memory, report, closed, positions, J):
    """Write the Jacobian of a frame (6, n): linear and angular velocity in base axes."""
    n = robot.tree[INDEPENDENT]
    out = np.empty(12 + 6 * n)
    outcome = answered(FRAME, robot, memory, report, closed, positions, positions, frame, out)
    for i in range(6):
        for j in range(n):
            J[n * i + j] = out[12 + 6 * j + i]
    return outcome


def actuator_forces(
    robot, driven, memory, report, closed, positions, speeds, accelerations, forces
):
    """Write the shortest forces of the motors (m) for a motion."""
    begin(robot, memory, closed, positions)
    outcome = reach(robot.tree, robot.numbers, memory, positions)
    if outcome == CLOSED:
        tables = DrivenTables(
            robot.tree,
            robot.numbers,
            memory,
            driven.motors,
            driven.rest,
            driven.base,
            driven.dry,
            driven.columns,
            driven.elsewhere,
            driven.follows,
            driven.along,
        )
        if accelerations.size < speeds.size:
            done = forces_of_first(tables, positions, speeds, accelerations, forces)
        else:
            done = forces_of_all(tables, positions, speeds, accelerations, forces)
        if not done:
            outcome = UNREACHABLE
    return ended(outcome, robot, memory, report, closed, forces)
