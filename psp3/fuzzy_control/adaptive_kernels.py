r"""Compiled loops of adaptive fuzzy computed torque.

They make single steps and whole runs of the controller.

A rule base of type-1 or interval type-2 is ``table``, see ``fuzzy2.systems.kernels``, with
consequents (36, R): left and right ends of the 18 estimated numbers in turn, for every rule. Only
those of M and G adapt, n = 9 R parameters.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fuzzy2.learning.adaptation_kernels import add, basis, forget, solve_within
from fuzzy2.support.compiled import compiled
from psp3.checks import Array
from psp3.control.controller import steer
from psp3.fuzzy_control.kernels import (
    apply_model,
    is_positive_definite,
    width_of_force,
    write_servo,
)

OUTPUTS = 18
"""Estimated numbers: the upper triangle of M, C and G."""

ADAPTED = 9
"""Estimated numbers that adapt: the upper triangle of M and G."""

TIME, SINCE_UPDATE, CALLED = range(3)

EARLY = 1e-9
"""Share of the time between updates by which an update may come early, because rounding could
otherwise delay it by a period.
"""


class Settings(NamedTuple):
    """Gains, and the times and the share that control the adaptation.

    With ``memory`` 0 nothing is learned. ``least_share`` is the least share of the trained M that
    the adapted one must have.
    """

    kp: float
    kv: float
    memory: float
    lag: float
    update_period: float
    least_share: float


class Rules(NamedTuple):
    """The trained rules, and how far adaptation may move from them.

    ``table`` is the system's, as its kernels take it, ``ranges`` (2, 4) are the ends of the trained
    inputs, ``trained`` are the consequents, ``prior`` (n,) their weights, ``reach`` (n,) the
    farthest that they may move up, and ``least`` (n,) the farthest down, negative.
    """

    table: Array
    ranges: Array
    trained: Array
    prior: Array
    reach: Array
    least: Array


class Memory(NamedTuple):
    """The state that changes from call to call.

    ``clock`` (3,), ``last`` (9,) heights, speeds and torque of the last call, ``rows`` (3, n) and
    ``residuals`` (3,) of the low-pass filter, the least-squares problem, ``information`` (n, n) and
    ``right`` (n,), with the scratch space ``factor`` (n, n) and ``trial`` (n,), how far the
    consequents are from the trained ones, ``delta`` (n,), and the ``consequents`` themselves with
    the ``orders`` that ``basis`` keeps of them.
    """

    clock: Array
    last: Array
    rows: Array
    residuals: Array
    information: Array
    right: Array
    factor: Array
    trial: Array
    delta: Array
    consequents: Array
    orders: NDArray[np.int64]


class Adaptive(NamedTuple):
    """An adaptive controller in a loop."""

    settings: Settings
    rules: Rules
    memory: Memory


def new_memory(trained: Array) -> Memory:
    """Return the memory of a controller that has not been called yet."""
    rules = trained.shape[1]
    size = ADAPTED * rules
    orders = np.tile(np.arange(rules, dtype=np.int64), (2 * OUTPUTS, 1))
    square = np.zeros((2, size, size))
    return Memory(
        np.zeros(3),
        np.zeros(9),
        np.zeros((3, size)),
        np.zeros(3),
        square[0],
        np.zeros(size),
        square[1],
        np.zeros(size),
        np.zeros(size),
        trained.copy(),
        orders,
    )


@compiled
def _place(j):
    """Index of output j among the adapting outputs, or −1."""
    return j if j < 6 else (j - 9 if j >= 15 else -1)


@compiled
def _inputs(ranges, heights, speeds, x):
    """Write the four differences, clamped to the trained ranges.

    Return whether they were within the ranges.
    """
    x[0], x[1], x[2], x[3] = (
        heights[0] - heights[1],
        heights[0] - heights[2],
        speeds[0] - speeds[1],
        speeds[0] - speeds[2],
    )
    covered = True
    for i in range(4):
        if not ranges[0, i] <= x[i] <= ranges[1, i]:
            covered = False
            x[i] = min(max(x[i], ranges[0, i]), ranges[1, i])
    return covered


@compiled
def _observe(settings, rules, memory, heights, speeds, period, x, strengths, phi):
    """Add the effect of the last period's torque to the least-squares problem."""
    count = rules.trained.shape[1]
    middle, rise = np.empty(6), np.empty(3)
    for i in range(3):
        middle[i], middle[3 + i] = (
            0.5 * (heights[i] + memory.last[i]),
            0.5 * (speeds[i] + memory.last[3 + i]),
        )
        # This is the exact mean acceleration of the period, not a numerical derivative.
        rise[i] = (speeds[i] - memory.last[3 + i]) / period
    _inputs(rules.ranges, middle[:3], middle[3:], x)
    if not basis(rules.table, x, memory.consequents, memory.orders, strengths, phi):
        return
    blend = -math.expm1(-period / settings.lag)
    forget(memory.information, memory.right, math.exp(-period / settings.memory))
    for i in range(3):
        row = memory.rows[i]
        for k in range(row.size):
            row[k] *= 1.0 - blend
        trained = 0.0
        for q in range(7):
            if q < 3:
                a, b = min(i, q), max(i, q)
                j, factor = a * (5 - a) // 2 + b, rise[q]
            elif q < 6:
                j, factor = 3 + 3 * i + q, middle[q]
            else:
                j, factor = 15 + i, 1.0
            place = _place(j)
            total = 0.0
            for r in range(count):
                low, high = phi[2 * j, r], phi[2 * j + 1, r]
                total += low * rules.trained[2 * j, r] + high * rules.trained[2 * j + 1, r]
                if place >= 0:
                    row[place * count + r] += blend * factor * 0.5 * (low + high)
            trained += 0.5 * total * factor
        memory.residuals[i] += blend * (memory.last[6 + i] - trained - memory.residuals[i])
        add(memory.information, memory.right, row, memory.residuals[i], period)
    memory.clock[SINCE_UPDATE] += period


@compiled
def _update(settings, rules, memory):
    """Solve the least-squares problem at intervals, within reach of the trained consequents."""
    if memory.clock[SINCE_UPDATE] < (1.0 - EARLY) * settings.update_period:
        return
    memory.clock[SINCE_UPDATE] = 0.0
    solve_within(
        memory.information,
        memory.right,
        rules.prior,
        rules.least,
        rules.reach,
        memory.factor,
        memory.trial,
        memory.delta,
    )
    count = rules.trained.shape[1]
    for j in range(OUTPUTS):
        place = _place(j)
        if place >= 0:
            for r in range(count):
                moved = memory.delta[place * count + r]
                memory.consequents[2 * j, r] = rules.trained[2 * j, r] + moved
                memory.consequents[2 * j + 1, r] = rules.trained[2 * j + 1, r] + moved


@compiled
def _estimate(phi, consequents, middle, spread):
    """Write the middles and half-widths of the eighteen numbers."""
    for j in range(OUTPUTS):
        low, high = 0.0, 0.0
        for r in range(consequents.shape[1]):
            low += phi[2 * j, r] * consequents[2 * j, r]
            high += phi[2 * j + 1, r] * consequents[2 * j + 1, r]
        middle[j], spread[j] = 0.5 * (low + high), max(0.5 * (high - low), 0.0)


@compiled
def adaptive_step(
    settings: Settings,
    rules: Rules,
    memory: Memory,
    t: float,
    heights: Array,
    speeds: Array,
    desired: Array,
    out: Array,
) -> bool:
    """Learn from the last period and write the next torque.

    The output is that of ``kernels.fuzzy_torque``. Return whether the torque is finite.

    ``fell back`` means that the trained consequents replaced the adapted ones, because those gave
    no usable M.
    """
    total = t
    for i in range(3):
        total += heights[i] + speeds[i]
    if not math.isfinite(total):
        out[:] = math.nan
        return False
    count = rules.trained.shape[1]
    x, strengths, phi = np.empty(4), np.empty(2 * count), np.empty((2 * OUTPUTS, count))
    period = t - memory.clock[TIME]
    if memory.clock[CALLED] > 0.0 and period > 0.0 and settings.memory > 0.0:
        _observe(settings, rules, memory, heights, speeds, period, x, strengths, phi)
        _update(settings, rules, memory)
    covered = _inputs(rules.ranges, heights, speeds, x)
    middle, spread = np.empty(OUTPUTS), np.zeros(OUTPUTS)
    middle[:] = math.nan
    fell_back = True
    if basis(rules.table, x, memory.consequents, memory.orders, strengths, phi):
        _estimate(phi, memory.consequents, middle, spread)
        trained, other, least = np.empty(OUTPUTS), np.empty(OUTPUTS), np.empty(OUTPUTS)
        _estimate(phi, rules.trained, trained, other)
        for j in range(OUTPUTS):
            least[j] = middle[j] - settings.least_share * trained[j]
        fell_back = not is_positive_definite(least, 3, np.empty(6))
        if fell_back:
            # The trained consequents are ordered differently from the adapted ones, so their switch
            # points differ.
            basis(rules.table, x, rules.trained, memory.orders, strengths, phi)
            _estimate(phi, rules.trained, middle, spread)
    servo = np.empty(3)
    write_servo(settings, heights, speeds, desired, servo)
    apply_model(middle, servo, speeds, out, 0)
    for i in range(3):
        width = width_of_force(spread, servo, speeds, i, False)
        out[3 + i], out[6 + i] = out[i] - width, out[i] + width
    out[9], out[10] = 1.0 if covered else 0.0, 1.0 if fell_back else 0.0
    memory.clock[TIME], memory.clock[CALLED] = t, 1.0
    for i in range(3):
        memory.last[i], memory.last[3 + i], memory.last[6 + i] = heights[i], speeds[i], out[i]
    return math.isfinite(out[0] + out[1] + out[2])


@steer.register(Adaptive)
@compiled
def run_step(
    run: Adaptive,
    sample: int,
    t: float,
    heights: Array,
    speeds: Array,
    desired: Array,
    out: Array,
) -> bool:
    """Do as ``adaptive_step`` in a loop."""
    done: bool = adaptive_step(
        run.settings, run.rules, run.memory, t, heights, speeds, desired, out
    )
    return done
