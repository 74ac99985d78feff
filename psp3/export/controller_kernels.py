"""The exported functions of a controller: a step and a reset, around the kernels of loops.

They are plain Python that is translated to C. Only the kernels that they call are compiled in
Python.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from psp3.checks import Array
from psp3.control.controller import steer
from psp3.fuzzy_control.kernels import BASE
from psp3.simulation.kernels import limited, read_encoders


class Wires(NamedTuple):
    """The parts between an exported controller and the robot.

    ``resolution`` (k,) of the encoders, 0 for a perfect one, or (0,), and their ``last`` positions;
    ``limit`` (m,) of the forces, or (0,); ``queue`` (d, m) of the forces that are delayed by d
    periods; the ``period`` [s]; whether there have been ``calls`` (1,); and ``is_guarded``, whether
    the controller has a memory that numbers which are not finite would spoil.
    """

    resolution: Array
    limit: Array
    queue: Array
    last: Array
    calls: Array
    period: float
    is_guarded: bool


def _are_finite(values: Array) -> bool:
    """Return whether all numbers are finite."""
    rest = 0.0
    for i in range(values.size):
        rest += values[i] - values[i]
    return rest == 0.0


def _copied(source: Array, target: Array) -> None:
    """Copy numbers."""
    for i in range(source.size):
        target[i] = source[i]


def _zeroed(target: Array) -> None:
    """Write zeros."""
    for i in range(target.size):
        target[i] = 0.0


def _zeroed_rows(target: Array) -> None:
    """Write zeros into a table."""
    for row in range(target.shape[0]):
        _zeroed(target[row])


def _come_late(queue: Array, is_first: bool, torque: Array) -> None:
    """Write the torque of d steps ago; the first one acts until the second arrives."""
    late, m = queue.shape
    for j in range(m):
        asked = torque[j]
        if is_first:
            for row in range(late):
                queue[row, j] = asked
        torque[j] = queue[0, j]
        for row in range(1, late):
            queue[row - 1, j] = queue[row, j]
        queue[late - 1, j] = asked


def _seen_step(
    controller: Any,
    wires: Wires,
    t: float,
    positions: Array,
    speeds: Array,
    desired: Array,
    out: Array,
) -> bool:
    """Write a step of a controller that sees encoder readings."""
    if wires.resolution.size == 0:
        done: bool = steer(controller, 0, t, positions, speeds, desired, out)
    else:
        seen, rates = np.empty(positions.size), np.empty(speeds.size)
        _copied(positions, seen)
        _copied(speeds, rates)
        is_first = wires.calls[0] == 0.0
        read_encoders(wires.resolution, wires.last, is_first, wires.period, seen, rates)
        done = steer(controller, 0, t, seen, rates, desired, out)
    return done


def _write_step(
    controller: Any,
    wires: Wires,
    reference: Array,
    t: float,
    positions: Array,
    speeds: Array,
    desired: Array,
    out: Array,
) -> int:
    """Write a step, the forces first; return 1, or 0 if these are not finite.

    Numbers that are not finite do not change the controller's memory. A model that could not reach
    the pose starts from its reference pose in the next step.
    """
    if wires.is_guarded and not (
        math.isfinite(t) and _are_finite(positions) and _are_finite(speeds) and _are_finite(desired)
    ):
        for i in range(out.size):
            out[i] = math.nan
        return 0
    if not _seen_step(controller, wires, t, positions, speeds, desired, out):
        if reference.size > 0:
            _copied(reference, controller.model.memory)
        return 0
    for i in range(wires.limit.size):
        out[i] = limited(out[i], wires.limit[i])
    if wires.queue.size > 0:
        _come_late(wires.queue, wires.calls[0] == 0.0, out)
    if wires.calls.size > 0:
        wires.calls[0] = 1.0
    return 1


def step(
    controller: Any,
    wires: Wires,
    reference: Array,
    t: float,
    positions: Array,
    speeds: Array,
    desired: Array,
    torque: Array,
) -> int:
    """Write the torque of a step; return 1, or 0 if it is not finite."""
    return _write_step(controller, wires, reference, t, positions, speeds, desired, torque)


def learned_step(
    controller: Any,
    wires: Wires,
    reference: Array,
    t: float,
    positions: Array,
    speeds: Array,
    desired: Array,
    torque: Array,
    interval: Array,
    flags: Array,
) -> int:
    """Write the torque of a step of a learned controller, and its reports.

    Return 1, or 0 if the torque is not finite.
    """
    n = torque.size
    out = np.empty(3 * n + 2)
    done = _write_step(controller, wires, reference, t, positions, speeds, desired, out)
    for i in range(n):
        torque[i] = out[i]
    for i in range(2 * n):
        interval[i] = out[n + i]
    flags[0], flags[1] = out[3 * n], out[3 * n + 1]
    return done


def _reset_wires(wires: Wires) -> None:
    """Forget the encoder readings and the delayed forces."""
    _zeroed(wires.calls)
    _zeroed(wires.last)
    _zeroed_rows(wires.queue)


def reset_classical(controller: Any, wires: Wires, reference: Array) -> None:
    """Forget the integral, and start in the reference pose if a model has loops to close."""
    _reset_wires(wires)
    _zeroed_rows(controller.memory)
    _zeroed(controller.clock)
    if reference.size > 0:
        _copied(reference, controller.model.memory)


def reset_regulation(controller: Any, wires: Wires, reference: Array) -> None:
    """Start in the reference pose."""
    _reset_wires(wires)
    _zeroed_rows(controller.memory)
    _copied(reference, controller.model.memory)


def reset_model(controller: Any, wires: Wires, reference: Array) -> None:
    """Start in the reference pose if a model has loops to close; there is no other memory."""
    _reset_wires(wires)
    if reference.size > 0:
        _copied(reference, controller.model.memory)


def reset_adaptive(controller: Any, wires: Wires, reference: Array) -> None:
    """Return to the trained rules, and forget all samples."""
    _reset_wires(wires)
    memory, trained = controller.memory, controller.rules.trained
    _zeroed(memory.clock)
    _zeroed(memory.last)
    _zeroed_rows(memory.rows)
    _zeroed(memory.residuals)
    _zeroed_rows(memory.information)
    _zeroed(memory.right)
    _zeroed(memory.delta)
    for row in range(trained.shape[0]):
        for r in range(trained.shape[1]):
            memory.consequents[row, r] = trained[row, r]
            memory.orders[row, r] = r


def reset_slotine_li(controller: Any, wires: Wires, reference: Array) -> None:
    """Return to the trained rules."""
    _reset_wires(wires)
    memory, bases = controller.memory, controller.rules.controller.bases
    _zeroed(memory.clock)
    _zeroed(memory.gradient)
    _zeroed(memory.delta)
    _copied(controller.rules.trained, memory.consequents)
    o, first = 1, 0
    for _ in range(int(bases[0])):
        count, inputs, outputs = int(bases[o + 3]), int(bases[o + 4]), int(bases[o + 5])
        for row in range(2 * outputs):
            for r in range(count):
                memory.orders[first + row * count + r] = r
        first += 2 * outputs * count
        o += BASE + inputs + outputs
