"""Compiled runs: the loop of controller and plant for the 3-PSP, one for each kind of controller.

Classical and fuzzy controllers, adaptive ones, computed torque with an integral, linear feedback.
"""

from __future__ import annotations

import math

import numpy as np

from fuzzy2.support.compiled import compiled
from psp3.checks import Array
from psp3.fuzzy_control.adaptive_kernels import Memory, Rules, adaptive_step
from psp3.fuzzy_control.kernels import (
    COMPUTED_TORQUE,
    FEED_FORWARD,
    GRAVITY_COMPENSATED_PD,
    INTERVAL,
    OUTPUTS,
    PD,
    STEP,
    apply_model,
    exact_model,
    fuzzy_torque,
    write_servo,
)
from psp3.three_psp.closed_form import equation_of_motion
from psp3.three_psp.stepping import advance, advance_driven


@compiled
def _measure(state, k, period, resolution, measured, seen, last):
    """Write what the controller sees of a state.

    With noise, and counted by encoders, whose speeds are differences.
    """
    for i in range(6):
        seen[i] = state[i] + (measured[k, i] if measured.shape[0] > 0 else 0.0)
    if resolution > 0.0:
        for i in range(3):
            seen[i] = resolution * math.floor(seen[i] / resolution + 0.5)
            seen[3 + i] = (seen[i] - last[i]) / period if k > 0 else 0.0
            last[i] = seen[i]


@compiled
def run(
    controller: Array,
    model: Array,
    plant: Array,
    drives: Array,
    desired: Array,
    state: Array,
    period: float,
    resolution: float,
    delay: int,
    measured: Array,
    added: Array,
    samples: Array,
) -> int:
    """Let a controller steer the robot; return the number of samples written.

    ``model`` and ``plant`` are parameters as the controller knows them and as they are; ``drives``
    (3, 3) see :mod:`psp3.drives.kernels`, or (0, 3) for none; ``desired`` (N, 9) heights, speeds
    and accelerations; ``state`` (6,) where the robot starts, changed in place; ``resolution`` of
    the encoders, 0 for perfect ones; ``delay`` in periods; ``measured`` (N, 6) or (0, 6) what
    measurement adds to heights and speeds; ``added`` (N, 18) or (0, 18) what is added to the
    model's M, C and G. ``samples`` (N, 11) gets heights, speeds, torque applied, covered and fell
    back. Fewer than N samples are written if the robot leaves the poses it can take.
    """
    kind = int(controller[0])
    seen, last, step, values = np.empty(6), np.empty(3), np.zeros(STEP), np.empty(OUTPUTS)
    full, servo, scratch, none = np.empty(21), np.empty(3), np.empty(6), np.empty(0)
    # Forces asked for, of which the last ones have not arrived.
    asked, applied = np.empty((min(delay, desired.shape[0]) + 1, 3)), np.empty(3)
    for k in range(desired.shape[0]):
        _measure(state, k, period, resolution, measured, seen, last)
        heights, speeds, wanted = seen[:3], seen[3:], desired[k]
        step[9], step[10] = 1.0, 0.0
        if kind >= INTERVAL:
            fuzzy_torque(
                controller,
                model,
                heights,
                speeds,
                wanted,
                added[k] if added.shape[0] > 0 else none,
                step,
            )
        else:
            if kind == FEED_FORWARD:
                exact_model(wanted[:3], wanted[3:6], model, full, values)
            elif kind != PD:
                exact_model(heights, speeds, model, full, values)
            if kind != PD and added.shape[0] > 0:
                for j in range(OUTPUTS):
                    values[j] += added[k, j]
            if kind == FEED_FORWARD:
                apply_model(values, wanted[6:], wanted[3:6], step, 0)
            elif kind == COMPUTED_TORQUE:
                write_servo(controller, heights, speeds, wanted, servo)
                apply_model(values, servo, speeds, step, 0)
            else:
                for i in range(3):
                    step[i] = controller[1] * (wanted[i] - heights[i]) + controller[2] * (
                        wanted[3 + i] - speeds[i]
                    )
                    if kind == GRAVITY_COMPENSATED_PD:
                        step[i] += values[15 + i]
        place, arriving = k % asked.shape[0], max(k - delay, 0) % asked.shape[0]
        for i in range(3):
            asked[place, i] = step[i]
            applied[i] = asked[arriving, i]
        for i in range(6):
            samples[k, i] = state[i]
        for i in range(3):
            samples[k, 6 + i] = applied[i]
        samples[k, 9], samples[k, 10] = step[9], step[10]
        if not math.isfinite(step[0] + step[1] + step[2]):
            # What is not a force is not applied later either; it is shown in its place.
            for i in range(3):
                samples[k, 6 + i] = step[i]
            return k
        if k + 1 < desired.shape[0]:
            if drives.shape[0] > 0:
                inside = advance_driven(state, applied, period, 1, plant, drives)
            else:
                inside = advance(state, applied, period, 1, plant, scratch)
            if not inside:
                return k + 1
    return int(desired.shape[0])


@compiled
def move(
    state: Array, forces: Array, period: float, plant: Array, drives: Array, scratch: Array
) -> bool:
    """Move the robot for a period, with drives (3, 3) unless all of them are zero.

    Return whether it is still a pose of the machine.
    """
    if not drives.any():
        return advance(state, forces, period, 1, plant, scratch)
    return advance_driven(state, forces, period, 1, plant, drives)


@compiled
def adaptive_run(
    settings: Array,
    rules: Rules,
    memory: Memory,
    plant: Array,
    drives: Array,
    desired: Array,
    state: Array,
    start: float,
    period: float,
    measured: Array,
    samples: Array,
) -> int:
    """Let the controller steer the robot; return the number of samples written.

    ``plant`` are the parameters of the robot as they are, ``drives`` as for ``drive_kernels``;
    ``desired`` (N, 9) heights, speeds and accelerations; ``state`` (6,) where the robot is at the
    time ``start``, changed in place to the last sample; ``measured`` (N, 6) or (0, 6) what
    measurement adds to heights and speeds. ``samples`` (N, 6 + STEP) gets heights, speeds, and what
    ``adaptive_step`` writes. Fewer than N samples are written if the robot leaves the poses it can
    take.
    """
    seen, step, scratch = np.empty(6), np.zeros(STEP), np.empty(6)
    for k in range(desired.shape[0]):
        for i in range(6):
            samples[k, i] = state[i]
            seen[i] = state[i] + (measured[k, i] if measured.shape[0] > 0 else 0.0)
        is_finite = adaptive_step(
            settings, rules, memory, start + k * period, seen[:3], seen[3:], desired[k], step
        )
        for i in range(STEP):
            samples[k, 6 + i] = step[i]
        if not is_finite:
            return k
        if k + 1 < desired.shape[0] and not move(state, step[:3], period, plant, drives, scratch):
            return k + 1
    return int(desired.shape[0])


@compiled
def computed_torque(model: Array, heights: Array, speeds: Array, wanted: Array, out: Array) -> bool:
    """Write the forces M wanted + C speeds + G (3,) of the model.

    Return whether the pose is one of the machine's.
    """
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
    gains: Array,
    model: Array,
    plant: Array,
    drives: Array,
    desired: Array,
    state: Array,
    period: float,
    measured: Array,
    samples: Array,
) -> int:
    """Let computed torque with gains (kp, kv, ki) steer the robot.

    Samples (N, 9) are heights, speeds and torque.

    The integral of the error is the trapezoidal rule's; all else as in
    ``adaptive_kernels.adaptive_run``.
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
            servo[i] = (
                desired[k, 6 + i]
                + gains[1] * (desired[k, 3 + i] - seen[3 + i])
                + gains[0] * error
                + gains[2] * integral[i]
            )
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
    K: Array,
    forces: Array,
    plant: Array,
    drives: Array,
    desired: Array,
    state: Array,
    period: float,
    measured: Array,
    samples: Array,
) -> int:
    """Let forces (N, 3) with linear feedback K (3, 6) steer the robot.

    The feedback is of the errors of heights and speeds. See the other run.
    """
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
