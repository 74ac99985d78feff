r"""Compiled steps of Slotine and Li's adaptive law on rule bases, for any robot.

Rule bases are those of a trained controller, :class:`psp3.fuzzy_control.kernels.Fuzzy`. The
consequents of all bases are one row: for each base (m, 2, R), left and right ends by output and
rule. Their movement, and everything else that both ends share, is (m, R) in the same order, P
numbers.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fuzzy2.learning.adaptation_kernels import basis
from fuzzy2.support.compiled import compiled
from psp3.checks import Array
from psp3.control.controller import steer
from psp3.fuzzy_control.christoffel_kernels import christoffel_room, slopes_at, write_coriolis
from psp3.fuzzy_control.kernels import BASE, Fuzzy, apply_model, width_of_force, write_inputs

TIME, CALLED = range(2)


class Settings(NamedTuple):
    """Slope λ of the sliding variable [1/s], and the rate at which learned changes fade [1/s]."""

    slope: float
    fading: float


class Rules(NamedTuple):
    """The trained rules, and how they adapt.

    The trained ``controller``, the ``damping`` K (n, n), the ``trained`` consequents (2 P,), the
    adaptation gains ``rates`` (P,) and the ``reach`` (P,), the farthest that consequents may move.
    """

    controller: Fuzzy
    damping: Array
    trained: Array
    rates: Array
    reach: Array


class Memory(NamedTuple):
    """The state that changes from call to call.

    ``clock`` (2,), ``gradient`` (P,) :math:`Y^T s` of the last call, how far the consequents are
    from the trained ones, ``delta`` (P,), and the ``consequents`` (2 P,) themselves with the
    ``orders`` that ``basis`` keeps of them.
    """

    clock: Array
    gradient: Array
    delta: Array
    consequents: Array
    orders: NDArray[np.int64]


class SlotineLi(NamedTuple):
    """An adaptive controller in a loop."""

    settings: Settings
    rules: Rules
    memory: Memory


def new_memory(rules: Rules, orders: NDArray[np.int64]) -> Memory:
    """Return the memory of a controller that has not been called yet, with any ``orders``."""
    size = rules.rates.size
    gradient, delta = np.zeros((2, size))
    return Memory(np.zeros(2), gradient, delta, rules.trained.copy(), orders.copy())


@compiled
def _write_errors(slope, positions, speeds, desired, sliding, v, w):
    """Write the sliding variable, and the reference speeds and accelerations."""
    n = positions.size
    for i in range(n):
        rate = desired[n + i] - speeds[i]
        v[i] = desired[n + i] + slope * (desired[i] - positions[i])
        w[i] = desired[2 * n + i] + slope * rate
        sliding[i] = v[i] - speeds[i]


@compiled
def _learn(settings, rules, memory, period):
    """Move the consequents along the last call's gradient, and clamp them to their box."""
    kept, bases, o, start = math.exp(-period * settings.fading), rules.controller.bases, 1, 0
    for _ in range(int(bases[0])):
        count, inputs, outputs = int(bases[o + 3]), int(bases[o + 4]), int(bases[o + 5])
        for j in range(outputs):
            first = start + j * count
            for k in range(first, first + count):
                moved = kept * memory.delta[k] + period * rules.rates[k] * memory.gradient[k]
                moved = min(max(moved, -rules.reach[k]), rules.reach[k])
                memory.delta[k] = moved
                left, right = first + k, first + count + k
                memory.consequents[left] = rules.trained[left] + moved
                memory.consequents[right] = rules.trained[right] + moved
        start += outputs * count
        o += BASE + inputs + outputs


@compiled
def _write_basis(rules, memory, x, phi):
    """Write the basis functions (2 P,) of all bases; return whether rules of each fire."""
    controller, o, start = rules.controller, 1, 0
    bases = controller.bases
    for _ in range(int(bases[0])):
        count, inputs, outputs = int(bases[o + 3]), int(bases[o + 4]), int(bases[o + 5])
        table = controller.system[int(bases[o]) : int(bases[o]) + int(bases[o + 1])]
        asked = np.empty(inputs)
        for i in range(inputs):
            asked[i] = x[int(bases[o + BASE + i])]
        end = start + 2 * outputs * count
        if not basis(
            table,
            asked,
            memory.consequents[start:end].reshape(2 * outputs, count),
            memory.orders[start:end].reshape(2 * outputs, count),
            np.empty(2 * count),
            phi[start:end].reshape(2 * outputs, count),
        ):
            return False
        start = end
        o += BASE + inputs + outputs
    return True


@compiled
def _estimate(rules, memory, phi, middle, spread):
    """Write middles and half-widths of the numbers that have rules."""
    bases, o, start = rules.controller.bases, 1, 0
    for _ in range(int(bases[0])):
        count, inputs, outputs = int(bases[o + 3]), int(bases[o + 4]), int(bases[o + 5])
        for j in range(outputs):
            place, low, high = int(bases[o + BASE + inputs + j]), 0.0, 0.0
            for k in range(start, start + count):
                low += phi[k] * memory.consequents[k]
                high += phi[count + k] * memory.consequents[count + k]
            middle[place], spread[place] = 0.5 * (low + high), max(0.5 * (high - low), 0.0)
            start += 2 * count
        o += BASE + inputs + outputs


@compiled
def _write_mass(memory, mass):
    """Write the upper triangles (R, n (n + 1) / 2) of M's consequents, the first outputs of all."""
    count, entries = mass.shape
    for entry in range(entries):
        for r in range(count):
            mass[r, entry] = memory.consequents[2 * entry * count + r]


@compiled
def _both(a, b, i, j):
    """Return the factor of entry (i, j) of a symmetric matrix M in aᵀ M b."""
    return a[i] * b[j] + a[j] * b[i] if i != j else a[i] * b[i]


@compiled
def _write_gradient(rules, phi, sliding, v, w, gradient):
    """Write Yᵀ s of M w + C v + G by the consequents that have rules."""
    n = sliding.size
    factors, place = np.empty(rules.controller.fallback.size), 0
    for i in range(n):
        for j in range(i, n):
            factors[place] = _both(sliding, w, i, j)
            place += 1
    for i in range(n):
        for j in range(n):
            factors[place] = sliding[i] * v[j]
            place += 1
    for i in range(n):
        factors[place + i] = sliding[i]
    bases, o, start = rules.controller.bases, 1, 0
    for _ in range(int(bases[0])):
        count, inputs, outputs = int(bases[o + 3]), int(bases[o + 4]), int(bases[o + 5])
        for j in range(outputs):
            factor, first = factors[int(bases[o + BASE + inputs + j])], start + j * count
            for k in range(first, first + count):
                gradient[k] = factor * (0.5 * (phi[first + k] + phi[first + count + k]))
        start += outputs * count
        o += BASE + inputs + outputs


@compiled
def _add_derived_gradient(along, sliding, speeds, v, gradient):
    """Add the gradient of sᵀ C v by M's consequents, if C is derived from M."""
    count, n = along.shape
    for r in range(count):
        by_speed, by_reference, by_sliding = 0.0, 0.0, 0.0
        for i in range(n):
            by_speed += along[r, i] * speeds[i]
            by_reference += along[r, i] * v[i]
            by_sliding += along[r, i] * sliding[i]
        entry = 0
        for i in range(n):
            for j in range(i, n):
                gradient[entry * count + r] += 0.5 * (
                    by_speed * _both(sliding, v, i, j)
                    + by_reference * _both(sliding, speeds, i, j)
                    - by_sliding * _both(speeds, v, i, j)
                )
                entry += 1


@compiled
def slotine_li_step(
    settings: Settings,
    rules: Rules,
    memory: Memory,
    t: float,
    positions: Array,
    speeds: Array,
    desired: Array,
    out: Array,
) -> bool:
    """Learn from the last period and write the next forces, as ``kernels.fuzzy_torque`` does.

    Return whether they are finite. ``fell back`` means that no rule fired, and the trained average
    replaced an estimate.
    """
    n, controller = positions.size, rules.controller
    total = t
    for i in range(n):
        total += positions[i] + speeds[i] + desired[i] + desired[n + i] + desired[2 * n + i]
    if not math.isfinite(total):
        out[:] = math.nan
        return False
    period = t - memory.clock[TIME]
    if memory.clock[CALLED] > 0.0 and period > 0.0:
        _learn(settings, rules, memory, period)
    memory.clock[TIME], memory.clock[CALLED] = t, 1.0
    x, count = np.empty(controller.inputs.shape[1]), controller.fallback.size
    covered = write_inputs(controller.inputs, controller.ranges, True, positions, speeds, x)
    sliding, v, w = np.empty(n), np.empty(n), np.empty(n)
    _write_errors(settings.slope, positions, speeds, desired, sliding, v, w)
    middle, spread, phi = np.empty(count), np.zeros(count), np.empty(rules.trained.size)
    for j in range(count):
        middle[j] = controller.fallback[j]
    fires = _write_basis(rules, memory, x, phi)
    if fires:
        _estimate(rules, memory, phi, middle, spread)
        _write_gradient(rules, phi, sliding, v, w, memory.gradient)
        if controller.derived.size > 0:
            count_of_rules = int(controller.bases[4])
            along = np.empty((count_of_rules, n))
            mass = np.empty((count_of_rules, n * (n + 1) // 2))
            room = np.empty(christoffel_room(controller.derived, n))
            slopes_at(controller.derived, controller.inputs, x, room, along)
            _write_mass(memory, mass)
            write_coriolis(along, mass, speeds, room, middle)
            _add_derived_gradient(along, sliding, speeds, v, memory.gradient)
    else:
        memory.gradient[:] = 0.0
    apply_model(middle, w, v, out, 0)
    finite = True
    for i in range(n):
        for j in range(n):
            out[i] += rules.damping[i, j] * sliding[j]
        width = width_of_force(spread, w, v, i, False)
        out[n + i], out[2 * n + i] = out[i] - width, out[i] + width
        finite = finite and math.isfinite(out[i])
    out[3 * n], out[3 * n + 1] = 1.0 if covered else 0.0, 0.0 if fires else 1.0
    return finite


@steer.register(SlotineLi)
@compiled
def run_step(
    run: SlotineLi,
    sample: int,
    t: float,
    positions: Array,
    speeds: Array,
    desired: Array,
    out: Array,
) -> bool:
    """Do as ``slotine_li_step`` in a loop."""
    done: bool = slotine_li_step(
        run.settings, run.rules, run.memory, t, positions, speeds, desired, out
    )
    return done
