"""Compiled runs of the controllers that adaptive ones are compared with: computed torque with an integral, and linear feedback."""

from __future__ import annotations

import math

import numpy as np

from fuzzy2.compiled import compiled
from psp3.adaptive_kernels import move
from psp3.arrays import Array
from psp3.closed_form import equation_of_motion


@compiled
def computed_torque(model: Array, heights: Array, speeds: Array, wanted: Array, out: Array) -> bool:
    """Write the forces M wanted + C speeds + G (3,) of the model; return whether the pose is one of the machine's."""
    full = np.empty(21)
    if equation_of_motion(heights, speeds, model, full) >= 0:
        return False
    for i in range(3):
        out[i] = full[18 + i]
        for j in range(3):
            out[i] += full[3 * i + j] * wanted[j] + full[9 + 3 * i + j] * speeds[j]
    return True


@compiled
def computed_torque_run(
    gains: Array, model: Array, plant: Array, drives: Array, desired: Array, state: Array, period: float, measured: Array, samples: Array
) -> int:
    """Let computed torque with gains (kp, kv, ki) steer the robot; samples (N, 9) are heights, speeds and torque.

    The integral of the error is the trapezoidal rule's; all else as in ``adaptive_kernels.adaptive_run``.
    """
    seen, servo, torque, scratch = np.empty(6), np.empty(3), np.empty(3), np.empty(6)
    integral, last = np.zeros(3), np.zeros(3)
    for k in range(desired.shape[0]):
        for i in range(6):
            samples[k, i] = state[i]
            seen[i] = state[i] + (measured[k, i] if measured.shape[0] > 0 else 0.0)
        for i in range(3):
            error = desired[k, i] - seen[i]
            if k > 0:
                integral[i] += 0.5 * period * (error + last[i])
            last[i] = error
            servo[i] = desired[k, 6 + i] + gains[1] * (desired[k, 3 + i] - seen[3 + i]) + gains[0] * error + gains[2] * integral[i]
        if not computed_torque(model, seen[:3], seen[3:], servo, torque):
            return k
        for i in range(3):
            samples[k, 6 + i] = torque[i]
        if not math.isfinite(torque[0] + torque[1] + torque[2]):
            return k
        if k + 1 < desired.shape[0] and not move(state, torque, period, plant, drives, scratch):
            return k + 1
    return int(desired.shape[0])


@compiled
def feedback_run(
    K: Array, forces: Array, plant: Array, drives: Array, desired: Array, state: Array, period: float, measured: Array, samples: Array
) -> int:
    """Let forces (N, 3) with linear feedback K (3, 6) of the errors of heights and speeds steer the robot; see the other run."""
    error, torque, scratch = np.empty(6), np.empty(3), np.empty(6)
    for k in range(desired.shape[0]):
        for i in range(6):
            samples[k, i] = state[i]
            error[i] = desired[k, i] - state[i] - (measured[k, i] if measured.shape[0] > 0 else 0.0)
        for i in range(3):
            torque[i] = forces[k, i]
            for j in range(6):
                torque[i] += K[i, j] * error[j]
            samples[k, 6 + i] = torque[i]
        if not math.isfinite(torque[0] + torque[1] + torque[2]):
            return k
        if k + 1 < desired.shape[0] and not move(state, torque, period, plant, drives, scratch):
            return k + 1
    return int(desired.shape[0])
