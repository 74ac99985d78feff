"""Compiled steps of the classical controllers, of any robot."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from fuzzy2.support.compiled import compiled
from psp3.checks import Array
from psp3.control.controller import Widths, steer
from psp3.dynamics.compiled_robot import allocate, write_forces
from psp3.errors import InvalidArray

FEED_FORWARD, PD, GRAVITY_COMPENSATED_PD, COMPUTED_TORQUE = range(4)
"""Kinds of controllers by the model's part: the forces of the desired motion; nothing; gravity at
the present pose; the forces for the servo's accelerations.
"""

LAST_ERROR, INTEGRAL, FEEDBACK, REST = range(4)
TIME, CALLED = range(2)


class Classical(NamedTuple):
    """A classical controller.

    ``kind`` see above; gains ``kp`` and ``kv`` (S, k²), at S samples of the period ``gain_period``
    or for all times, ``ki`` of the integral; ``is_allocated``, whether the model converts the
    feedback, forces along the first k coordinates, to motor forces; ``model``, the robot's table in
    the controller; ``memory`` (4, n) last error, integral of the error, feedback, and zeros;
    ``clock`` (2,) time of the last call, and whether there was one; ``added`` (N, w), or (0, w),
    noise on the model's numbers at each sample: the upper triangle of M, C and G.
    """

    kind: int
    kp: Array
    kv: Array
    ki: float
    gain_period: float
    is_allocated: bool
    model: Any
    memory: Array
    clock: Array
    added: Array


def classical(
    kind: int,
    kp: ArrayLike,
    kv: ArrayLike,
    model: Any,
    widths: Widths,
    ki: float = 0.0,
    gain_period: float = 1.0,
    added: Array | None = None,
    is_allocated: bool = False,
) -> Classical:
    """Return a controller that has not been called yet.

    Parameters
    ----------
    kind : int
        One of the above.
    kp, kv : float, (k, k) or (S, k, k) array_like
        Gains.
    model : NamedTuple
        A robot's table.
    widths : Widths
        Sizes of its inputs and outputs.
    ki, gain_period, added, is_allocated
        See :class:`Classical`.
    """
    wanted, n = widths.commanded, widths.speeds
    unit = np.eye(wanted)

    def gains(gain: ArrayLike) -> Array:
        full = np.asarray(gain, dtype=np.float64)
        full = full * unit if full.ndim == 0 else full
        if full.shape[-2:] != (wanted, wanted):
            raise InvalidArray("gain", f"({wanted}, {wanted}) of {wanted} commanded", gain)
        return np.ascontiguousarray(full.reshape(-1, wanted * wanted))

    none = np.empty((0, (n * (n + 1)) // 2 + n * n + n))
    return Classical(
        kind,
        gains(kp),
        gains(kv),
        float(ki),
        float(gain_period),
        is_allocated,
        model,
        np.zeros((4, n)),
        np.zeros(2),
        none if added is None else added,
    )


@compiled
def _write_feedback(
    controller: Classical, t: float, positions: Array, speeds: Array, desired: Array
) -> None:
    """Write the feedback of the servo: forces, or accelerations for computed torque."""
    n, memory, clock, ki = desired.size // 3, controller.memory, controller.clock, controller.ki
    kp, kv, is_servo = controller.kp, controller.kv, controller.kind == COMPUTED_TORQUE
    sample = 0
    if kp.shape[0] > 1:
        # Limited before the conversion to an integer, which overflows for large times.
        sample = int(min(max(0.0, t / controller.gain_period + 1e-6), float(kp.shape[0] - 1)))
    for i in range(n):
        total = desired[2 * n + i] if is_servo else 0.0
        damping, stiffness = 0.0, 0.0
        for j in range(n):
            damping += kv[sample, n * i + j] * (desired[n + j] - speeds[j])
            stiffness += kp[sample, n * i + j] * (desired[j] - positions[j])
        total = total + damping + stiffness
        if ki != 0.0:
            error = desired[i] - positions[i]
            if clock[CALLED] > 0.0:
                step = 0.5 * (t - clock[TIME])
                memory[INTEGRAL, i] += step * (error + memory[LAST_ERROR, i])
            memory[LAST_ERROR, i] = error
            total += ki * memory[INTEGRAL, i]
        memory[FEEDBACK, i] = total
    clock[TIME], clock[CALLED] = t, 1.0


@compiled
def add_force(added: Array, accelerations: Array, speeds: Array, out: Array) -> None:
    """Add the force M a + C v + G from numbers: the upper triangle of M, C and G."""
    n = out.size
    coriolis = (n * (n + 1)) // 2
    gravity, place = coriolis + n * n, 0
    for i in range(n):
        for j in range(i, n):
            out[i] += added[place] * accelerations[j]
            if j > i:
                out[j] += added[place] * accelerations[i]
            place += 1
    for i in range(n):
        for j in range(n):
            out[i] += added[coriolis + n * i + j] * speeds[j]
        out[i] += added[gravity + i]


@compiled
def _write_desired(desired: Array, positions: Array, speeds: Array, a: Array, v: Array) -> None:
    """Write the desired positions and speeds; passive coordinates keep their present values."""
    k = desired.size // 3
    for i in range(k):
        a[i], v[i] = desired[i], desired[k + i]
    for i in range(k, a.size):
        a[i] = positions[i]
    for i in range(k, v.size):
        v[i] = speeds[i]


@compiled
def _add_feedback(controller: Classical, positions: Array, feedback: Array, out: Array) -> bool:
    """Add the feedback (k,) to the motor forces; return whether the motors can produce it."""
    if not controller.is_allocated:
        for i in range(feedback.size):
            out[i] += feedback[i]
        return True
    shared = np.empty(out.size)
    done: bool = allocate(controller.model, positions, feedback, shared)
    for i in range(out.size):
        out[i] += shared[i]
    return done


@steer.register(Classical)
@compiled
def classical_step(
    controller: Classical,
    sample: int,
    t: float,
    positions: Array,
    speeds: Array,
    desired: Array,
    out: Array,
) -> bool:
    """Write the forces (m,) of a classical controller; return whether they are finite."""
    k, kind, model = desired.size // 3, controller.kind, controller.model
    rest = controller.memory[REST]
    feedback, still = controller.memory[FEEDBACK][:k], rest[:k]
    _write_feedback(controller, t, positions, speeds, desired)
    for j in range(out.size):
        out[j] = 0.0
    if kind != PD:
        # A single call site, because each one is slow to compile.
        a, v, w = positions, rest, still
        if kind == FEED_FORWARD:
            w = desired[2 * k :]
            if k == speeds.size and k == positions.size:
                a, v = desired[:k], desired[k : 2 * k]
            else:
                whole, rates = np.empty(positions.size), np.empty(speeds.size)
                _write_desired(desired, positions, speeds, whole, rates)
                a, v = whole, rates
        elif kind == COMPUTED_TORQUE:
            v, w = speeds, feedback
        if not write_forces(model, a, v, w, out):
            out[:] = math.nan
            return False
        if controller.added.shape[0] > 0:
            add_force(controller.added[sample], w, v, out)
    if kind != COMPUTED_TORQUE and not _add_feedback(controller, positions, feedback, out):
        out[:] = math.nan
        return False
    total = 0.0
    for j in range(out.size):
        total += out[j]
    return math.isfinite(total)
