"""Compiled Runge–Kutta steps of the 3-PSP: without drives, or with drives from event to event."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from fuzzy2.support.compiled import compiled
from psp3.checks import Array, checked_steps
from psp3.drives.drive import Drive, drive_table
from psp3.drives.kernels import INERTIA, VISCOUS
from psp3.dynamics.compiled_robot import advance as advance_any
from psp3.dynamics.compiled_robot import allocate, balance, is_state, write_forces, write_rates
from psp3.dynamics.driven_steps import advance_driven as advance_any_driven
from psp3.three_psp.closed_form import (
    RADIUS,
    accelerations_of_state,
    cosine_of_tilt,
    equation_of_motion,
    forward_kinematics,
    inverse_dynamics,
    is_finite,
    is_valid_pose,
    slope_of_nuts,
)


class ClosedForm(NamedTuple):
    """The table of the 3-PSP for compiled loops: its numbers, and scratch space for six."""

    parameters: Array
    scratch: Array


def closed_form_table(parameters: Array) -> ClosedForm:
    """Return a table for a compiled loop; loops that run at the same time need separate tables."""
    return ClosedForm(parameters, np.empty(6))


@balance.register(ClosedForm)
def _balance(
    robot: ClosedForm, state: Array, forces: Array, drives: Array, mass: Array, net: Array
) -> None:
    """Write M + J and the remaining forces; NaN if the robot cannot take the pose."""
    full = np.empty(21)
    if equation_of_motion(state[:3], state[3:], robot.parameters, full) >= 0:
        full[:] = math.nan
    for i in range(3):
        net[i] = forces[i] - full[18 + i] - drives[i, VISCOUS] * state[3 + i]
        for j in range(3):
            mass[i, j] = full[3 * i + j]
            net[i] -= full[9 + 3 * i + j] * state[3 + j]
        mass[i, i] += drives[i, INERTIA]


@write_rates.register(ClosedForm)
def _write_rates(robot: ClosedForm, state: Array, rates: Array) -> None:
    for i in range(3):
        rates[i] = state[3 + i]


@is_state.register(ClosedForm)
def _is_state(robot: ClosedForm, state: Array) -> bool:
    total = state[3] + state[4] + state[5]
    pose = np.empty(18)
    valid: bool = math.isfinite(total) and forward_kinematics(state[:3], robot.parameters, pose) < 0
    return valid


@compiled
def advance_driven(
    state: Array, forces: Array, step: float, steps: int, p: Array, drives: Array
) -> bool:
    """Do as ``advance`` for a robot with drives, an array (3, 3)."""
    valid: bool = advance_any_driven(ClosedForm(p, p), state, forces, step, steps, drives)
    return valid


@compiled
def runge_kutta_step(state: Array, forces: Array, step: float, p: Array, mid: Array) -> None:
    """Advance ``state`` (heights, speeds) in place by one Runge–Kutta step.

    The method is the classical one, under constant forces.

    ``mid`` is scratch space of 6 numbers.
    """
    f0, f1, f2 = forces[0], forces[1], forces[2]
    v0, v1, v2 = state[3], state[4], state[5]
    a0, a1, a2 = accelerations_of_state(state, 0, state, 3, f0, f1, f2, p)
    half = 0.5 * step
    mid[0], mid[1], mid[2] = state[0] + half * v0, state[1] + half * v1, state[2] + half * v2
    mid[3], mid[4], mid[5] = v0 + half * a0, v1 + half * a1, v2 + half * a2
    p0, p1, p2 = mid[3], mid[4], mid[5]
    b0, b1, b2 = accelerations_of_state(mid, 0, mid, 3, f0, f1, f2, p)
    mid[0], mid[1], mid[2] = state[0] + half * p0, state[1] + half * p1, state[2] + half * p2
    mid[3], mid[4], mid[5] = v0 + half * b0, v1 + half * b1, v2 + half * b2
    q0, q1, q2 = mid[3], mid[4], mid[5]
    c0, c1, c2 = accelerations_of_state(mid, 0, mid, 3, f0, f1, f2, p)
    mid[0], mid[1], mid[2] = state[0] + step * q0, state[1] + step * q1, state[2] + step * q2
    mid[3], mid[4], mid[5] = v0 + step * c0, v1 + step * c1, v2 + step * c2
    r0, r1, r2 = mid[3], mid[4], mid[5]
    d0, d1, d2 = accelerations_of_state(mid, 0, mid, 3, f0, f1, f2, p)
    sixth = step / 6.0
    state[0] += sixth * (v0 + 2.0 * (p0 + q0) + r0)
    state[1] += sixth * (v1 + 2.0 * (p1 + q1) + r1)
    state[2] += sixth * (v2 + 2.0 * (p2 + q2) + r2)
    state[3] += sixth * (a0 + 2.0 * (b0 + c0) + d0)
    state[4] += sixth * (a1 + 2.0 * (b1 + c1) + d1)
    state[5] += sixth * (a2 + 2.0 * (b2 + c2) + d2)


@compiled
def advance(state: Array, forces: Array, step: float, steps: int, p: Array, mid: Array) -> bool:
    """Take Runge–Kutta steps under constant forces.

    Return whether the final state is finite and the robot can be in it.
    """
    for _ in range(steps):
        runge_kutta_step(state, forces, step, p, mid)
    u, v, _ = slope_of_nuts(state[0], state[1], state[2], p[RADIUS])
    c, k = cosine_of_tilt(u, v)
    valid: bool = is_valid_pose(u, v, c, k, p[RADIUS]) and is_finite(state, 3)
    return valid


@advance_any.register(ClosedForm)
@compiled
def advance_closed_form(
    robot: ClosedForm, state: Array, forces: Array, step: float, steps: int, drives: Array
) -> bool:
    """Take steps with drives (3, 3), or (0, 3) for none; see ``advance``."""
    if drives.shape[0] > 0:
        valid: bool = advance_driven(state, forces, step, steps, robot.parameters, drives)
    else:
        valid = advance(state, forces, step, steps, robot.parameters, robot.scratch)
    return valid


@write_forces.register(ClosedForm)
def _write_forces(
    robot: ClosedForm, positions: Array, speeds: Array, accelerations: Array, out: Array
) -> bool:
    row: int = inverse_dynamics(positions, speeds, accelerations, robot.parameters, out)
    return row < 0


@allocate.register(ClosedForm)
def _allocate(robot: ClosedForm, positions: Array, forces: Array, out: Array) -> bool:
    for i in range(3):
        out[i] = forces[i]
    return True


class ClosedFormSteps:
    """A plant: the 3-PSP in closed form, compiled.

    Parameters
    ----------
    parameters : ndarray
        The robot's numbers, :meth:`psp3.three_psp.parameters.Parameters.as_array`.
    steps : int
        Integration steps in a control period.
    drive : Drive or sequence of Drive
        Friction and motor inertia of all screws, or of each.
    """

    def __init__(self, parameters: Array, steps: int, drive: Drive | Sequence[Drive]) -> None:
        self.robot, self.steps = closed_form_table(parameters), checked_steps(steps)
        drives = drive_table(drive, 3)
        self.drives = drives if drives.any() else drives[:0]
        self.state = np.zeros(6)

    def start(self, heights: Array, speeds: Array) -> None:
        """Set the state: nut heights [m] and speeds [m/s], each (3,)."""
        self.state = np.concatenate([heights, speeds])

    def advance(self, forces: Array, duration: float) -> tuple[Array, Array] | None:
        """Return heights and speeds, each (3,), after ``duration`` [s], or None."""
        step, (p, scratch) = duration / self.steps, self.robot
        if self.drives.size:
            valid = advance_driven(self.state, forces, step, self.steps, p, self.drives)
        else:
            valid = advance(self.state, forces, step, self.steps, p, scratch)
        return (self.state[:3], self.state[3:]) if valid else None
