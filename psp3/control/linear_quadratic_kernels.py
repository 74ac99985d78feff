"""Compiled steps of regulators for robots whose coordinates are not their motors."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from fuzzy2.support.compiled import compiled
from psp3.checks import Array
from psp3.control.controller import Widths, steer
from psp3.dynamics.compiled_robot import allocate, write_forces

POSITIONS, SPEEDS, WORK = range(3)


class Regulation(NamedTuple):
    """A regulator whose feedback is distributed to the motors at the robot's present pose.

    ``gains`` (S, 2 k n) at S samples of ``gain_period``, or one for all times; ``pose`` (n,) to
    which passive coordinates return; ``model`` the robot's table, whose forces are along the
    coordinates if the motors command all, and otherwise those of the motors; ``motors`` the table
    that distributes forces to the motors; ``memory`` (3, n) desired positions and speeds, and
    forces along the coordinates.
    """

    gains: Array
    gain_period: float
    pose: Array
    model: Any
    motors: Any
    memory: Array


def regulation(
    gains: Array, gain_period: float, pose: Array, model: Any, motors: Any, widths: Widths
) -> Regulation:
    """Return a regulator's table for compiled loops, see :class:`Regulation`."""
    k, n = widths.commanded, widths.speeds
    every = np.ascontiguousarray(gains.reshape(-1, 2 * k * n))
    return Regulation(every, float(gain_period), pose, model, motors, np.zeros((3, n)))


@compiled
def _write_feedback(
    controller: Regulation, t: float, positions: Array, speeds: Array, feedback: Array
) -> None:
    """Write the forces (k,) from gains and errors, with the desired motion in the memory."""
    gains, memory, n, sample = controller.gains, controller.memory, speeds.size, 0
    if gains.shape[0] > 1:
        # Limited before the conversion to an integer, which overflows for large times.
        sample = int(min(max(0.0, t / controller.gain_period + 1e-6), float(gains.shape[0] - 1)))
    for i in range(feedback.size):
        total = 0.0
        for j in range(n):
            at = 2 * n * i + j
            total += gains[sample, at] * (memory[POSITIONS, j] - positions[j])
            total += gains[sample, at + n] * (memory[SPEEDS, j] - speeds[j])
        feedback[i] = total


@steer.register(Regulation)
@compiled
def regulation_step(
    controller: Regulation,
    sample: int,
    t: float,
    positions: Array,
    speeds: Array,
    desired: Array,
    out: Array,
) -> bool:
    """Write the forces (m,) of a regulator; return whether they are finite."""
    k, n, memory = desired.size // 3, speeds.size, controller.memory
    for j in range(n):
        memory[POSITIONS, j] = desired[j] if j < k else controller.pose[j]
        memory[SPEEDS, j] = desired[k + j] if j < k else 0.0
    feedback = memory[WORK][:k]
    along = np.empty(k if k == n else out.size)
    done = write_forces(
        controller.model, memory[POSITIONS], memory[SPEEDS], desired[2 * k :], along
    )
    _write_feedback(controller, t, positions, speeds, feedback)
    if k == n:
        # Distributed to the motors in their present pose, not in the desired one.
        for i in range(k):
            feedback[i] += along[i]
    done = allocate(controller.motors, positions, feedback, out) and done
    total = 0.0
    for j in range(out.size):
        if k < n:
            out[j] += along[j]
        if not done:
            out[j] = math.nan
        total += out[j]
    return math.isfinite(total)
