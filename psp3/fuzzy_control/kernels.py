"""Compiled control steps of the fuzzy computed-torque controller, of any robot.

M, C and G of n joints are one row of numbers: the upper triangle of M, C and G, see
:mod:`psp3.fuzzy_control.numbers`. One or several rule bases estimate them.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from fuzzy2.support.compiled import compiled, scalar
from fuzzy2.systems.corollary_kernels import corollary_in
from fuzzy2.systems.kernels import evaluate_in, work_size
from psp3.checks import Array
from psp3.control.controller import steer
from psp3.control.kernels import add_force
from psp3.dynamics.compiled_robot import write_forces
from psp3.fuzzy_control.christoffel_kernels import christoffel_room, write_christoffel

INTERVAL, PLANES, COROLLARY, CENTROID = range(4)
"""Kinds of fuzzy controllers. Their estimates are intervals, α-planes whose middles are averaged
before the torque is computed, Gaussian numbers, or α-planes that are kept up to the torque, which
is defuzzified with its centroid.
"""

CLAMP, CRISP = range(2)


def step_width(joints: int) -> int:
    """Return how many numbers ``fuzzy_torque`` writes for n joints.

    They are torque (n), left or mean (n), right or standard deviation (n), covered, fell back.
    """
    return 3 * joints + 2


def nothing_added(numbers: int) -> Array:
    """Return the empty array that stands for no addition to estimates."""
    return np.empty((0, numbers))


def reported(steps: Array) -> dict[str, Any]:
    """Return the reports of results, by name, from the numbers of steps (N, 3n + 2)."""
    n = (steps.shape[1] - 2) // 3
    return {
        "covered": steps[:, 3 * n] > 0.0,
        "fell_back": steps[:, 3 * n + 1] > 0.0,
        "torque_interval": np.stack([steps[:, n : 2 * n], steps[:, 2 * n : 3 * n]], axis=-1),
    }


class NoModel(NamedTuple):
    """Placeholder for a robot's table, for a controller that never uses the exact forces."""

    nothing: float


NO_MODEL = NoModel(0.0)


@write_forces.register(NoModel)
def _write_no_forces(
    robot: NoModel, positions: Array, speeds: Array, accelerations: Array, out: Array
) -> bool:
    return False


class Fuzzy(NamedTuple):
    """A trained controller.

    ``kind`` see above; gains ``kp`` and ``kv``; what to do ``outside``, ``CLAMP`` or ``CRISP``;
    whether grades are multiplied, 1 or 0; ``ranges`` (2, p) lower and upper ends of the trained
    inputs; ``fallback`` (K,) numbers that replace an unusable estimate; ``planes`` (2, L) levels
    and widths, see ``fuzzy2.systems.kernels.evaluate_planes``; ``system`` the fuzzy systems of all
    rule bases one after the other, see ``fuzzy2.systems.kernels``; ``moments`` middles and spreads
    (2, R, m) of each, flat, for Gaussian numbers only, see
    ``fuzzy2.systems.corollary_kernels.evaluate_corollary``. ``inputs`` (2, p) are the indices of
    each input in positions and speeds, and of the subtracted one, or -1. ``bases`` holds the number
    of rule bases. For each base it has ``BASE`` numbers, see ``base_row``, the indices of its
    inputs among all and those of its outputs among the numbers. ``derived`` holds the data that C
    is computed from as M's derivative, see :mod:`psp3.fuzzy_control.christoffel_kernels`, or empty.
    """

    kind: int
    kp: float
    kv: float
    outside: int
    product: int
    ranges: Array
    fallback: Array
    planes: Array
    system: Array
    moments: Array
    inputs: Array
    bases: Array
    derived: Array


BASE = 6
"""Length of the head of a rule base: start and size of its system, start of its moments, and the
numbers of its rules, inputs and outputs.
"""

HEADER = 11
"""Length of the head of a packed controller: its scalars, then the sizes of its arrays."""


def packed(controller: Fuzzy) -> Array:
    """Return a controller as one array.

    Passing one array from Python takes less than a third of the time of five arrays, which matters
    for single steps. ``_unpacked`` reads it.
    """
    scalars, arrays = controller[:5], controller[5:]
    sizes = [controller.inputs.shape[1], controller.fallback.size, controller.planes.shape[1]]
    sizes += [controller.system.size, controller.moments.size, controller.bases.size]
    return np.concatenate([[*scalars, *sizes], *(array.ravel() for array in arrays)]).astype(
        np.float64
    )


@compiled
def _unpacked(array: Array) -> Fuzzy:
    """Return the controller from the array that ``packed`` made; its arrays are views."""
    inputs, levels = int(array[5]), int(array[7])
    ranges = HEADER
    fallback = ranges + 2 * inputs
    planes = fallback + int(array[6])
    system = planes + 2 * levels
    moments = system + int(array[8])
    places = moments + int(array[9])
    bases = places + 2 * inputs
    derived = bases + int(array[10])
    return Fuzzy(
        int(array[0]),
        array[1],
        array[2],
        int(array[3]),
        int(array[4]),
        array[ranges:fallback].reshape(2, inputs),
        array[fallback:planes],
        array[planes:system].reshape(2, levels),
        array[system:moments],
        array[moments:places],
        array[places:bases].reshape(2, inputs),
        array[bases:derived],
        array[derived:],
    )


class FuzzyRun(NamedTuple):
    """A trained controller in a loop, with the ``model`` that takes over if it is ``CRISP``.

    The model is a robot's table, or ``NO_MODEL``. ``added`` (N, K), or (0, K) for nothing, is added
    to the estimates at each sample.
    """

    controller: Fuzzy
    model: Any
    added: Array


@scalar
def is_positive_definite(m, n, room):
    """Whether M (n, n), given by its upper triangle, is positive definite.

    The test is on the pivots of elimination, with scratch space ``room`` of the size of M. A number
    that is not finite fails it, too.
    """
    for place in range(n * (n + 1) // 2):
        room[place] = m[place]
    row = 0
    for k in range(n):
        pivot = room[row]
        if not 0.0 < pivot < math.inf:
            return False
        below = row + n - k
        place = below
        for i in range(k + 1, n):
            factor = room[row + i - k] / pivot
            for j in range(i, n):
                room[place] -= factor * room[row + j - k]
                place += 1
        row = below
    return True


@scalar
def write_inputs(places, ranges, clamp, positions, speeds, x):
    """Write the inputs, clamped to the trained ranges if the controller does so.

    Return whether they were within the ranges.
    """
    n, covered = positions.size, True
    for i in range(x.size):
        plus, minus = int(places[0, i]), int(places[1, i])
        value = positions[plus] if plus < n else speeds[plus - n]
        if minus >= 0:
            value -= positions[minus] if minus < n else speeds[minus - n]
        low, high = ranges[0, i], ranges[1, i]
        if not low <= value <= high:
            covered = False
            if clamp:
                value = min(max(value, low), high)
        x[i] = value
    return covered


class Estimate(NamedTuple):
    """The rules' estimate of K numbers in a step.

    ``crisp`` (K,) values, ``middle`` (K,) and half-widths ``spread`` (K,), or means and standard
    deviations; ``numbers`` as they are estimated: ends of the intervals, plane by plane, or means
    and standard deviations; ``said`` and ``asked`` are outputs and inputs of one rule base;
    ``room`` is its scratch space.
    """

    crisp: Array
    middle: Array
    spread: Array
    numbers: Array
    said: Array
    asked: Array
    room: Array


@scalar
def _step_room(controller, n):
    """Return the size of a step's scratch array; a step allocates no memory."""
    count, inputs = controller.fallback.size, controller.inputs.shape[1]
    planes = max(controller.planes.shape[1], 1)
    bases, o, most = controller.bases, 1, n * (n + 1) // 2
    for _ in range(int(bases[0])):
        table = controller.system[int(bases[o]) :]
        most = max(most, work_size(table))
        o += BASE + int(bases[o + 4]) + int(bases[o + 5])
    if controller.derived.size > 0:
        most = max(most, christoffel_room(controller.derived, n))
    if controller.kind == CENTROID:
        most = max(most, 2 * count + 2 * n * planes)
    return n + 2 * inputs + (4 * planes + 3) * count + most


@scalar
def _new_estimate(controller, work):
    """Return an estimate whose arrays are parts of ``work``."""
    count, inputs = controller.fallback.size, controller.inputs.shape[1]
    numbers = 3 * count
    said = numbers + max(controller.planes.shape[1], 1) * 2 * count
    asked = 2 * said - numbers
    return Estimate(
        work[:count],
        work[count : 2 * count],
        work[2 * count : numbers],
        work[numbers:said],
        work[said:asked],
        work[asked : asked + inputs],
        work[asked + inputs :],
    )


@scalar
def _estimate_of_base(controller, o, x, estimate):
    """Do as ``_estimate`` for the rule base whose numbers begin at ``o``."""
    crisp, middle, spread, numbers, said, asked, room = estimate
    kind, planes, bases = controller.kind, controller.planes.shape[1], controller.bases
    start, first, rules = int(bases[o]), int(bases[o + 2]), int(bases[o + 3])
    inputs, outputs, count = int(bases[o + 4]), int(bases[o + 5]), crisp.size
    table = controller.system[start : start + int(bases[o + 1])]
    places = o + BASE + inputs
    for i in range(inputs):
        asked[i] = x[int(bases[o + BASE + i])]
    if kind == COROLLARY:
        size = rules * outputs
        middles = controller.moments[first : first + size]
        spreads = controller.moments[first + size : first + 2 * size]
        corollary_in(table, asked, 0, middles, spreads, controller.product > 0, room, said, 0)
        for k in range(outputs):
            j = int(bases[places + k])
            crisp[j] = middle[j] = numbers[2 * j] = said[2 * k]
            spread[j] = numbers[2 * j + 1] = said[2 * k + 1]
        return
    if kind == INTERVAL:
        evaluate_in(table, asked, 0, 0.0, False, room, said, 0)
    for plane in range(planes):
        width = controller.planes[1, plane]
        evaluate_in(table, asked, 0, width, False, room, said, 2 * outputs * plane)
    total = 0.0
    for plane in range(planes):
        total += controller.planes[0, plane]
    for k in range(outputs):
        j = int(bases[places + k])
        # The interval that is shown of a general type-2 estimate is that of its lowest plane, the
        # first.
        left, right = said[2 * k], said[2 * k + 1]
        crisp[j] = middle[j] = 0.5 * (left + right)
        spread[j] = 0.5 * (right - left)
        numbers[2 * j], numbers[2 * j + 1] = left, right
        if kind == INTERVAL:
            continue
        moment = 0.0
        for plane in range(planes):
            left = said[2 * (plane * outputs + k)]
            right = said[2 * (plane * outputs + k) + 1]
            numbers[2 * (plane * count + j)], numbers[2 * (plane * count + j) + 1] = left, right
            moment += controller.planes[0, plane] * (0.5 * (left + right))
        crisp[j] = moment / total


@scalar
def _estimate(controller, x, speeds, estimate):
    """Write the estimates of M, C and G at the inputs."""
    bases, o = controller.bases, 1
    for _ in range(int(bases[0])):
        _estimate_of_base(controller, o, x, estimate)
        o += BASE + int(bases[o + 4]) + int(bases[o + 5])
    if controller.derived.size > 0:
        crisp, numbers = estimate.crisp, estimate.numbers
        n = speeds.size
        first = n * (n + 1) // 2
        room = estimate.room
        write_christoffel(controller.derived, controller.inputs, x, speeds, room, crisp)
        for j in range(first, first + n * n):
            estimate.middle[j] = crisp[j]
            mean = controller.kind == COROLLARY
            for plane in range(max(controller.planes.shape[1], 1)):
                q = 2 * (plane * crisp.size + j)
                numbers[q], numbers[q + 1] = crisp[j], 0.0 if mean else crisp[j]


@scalar
def apply_model(m, servo, speeds, out, o):
    """Write the force M servo + C speeds + G from the numbers of n joints."""
    n = servo.size
    coriolis = n * (n + 1) // 2
    gravity = coriolis + n * n
    for i in range(n):
        force = 0.0
        for j in range(n):
            a, b = min(i, j), max(i, j)
            product = m[a * (2 * n - 1 - a) // 2 + b] * servo[j]
            force = product if j == 0 else force + product
        other = m[coriolis + n * i] * speeds[0]
        for j in range(1, n):
            other += m[coriolis + n * i + j] * speeds[j]
        out[o + i] = force + (other + m[gravity + i])


@scalar
def width_of_force(spread, servo, speeds, i, squares):
    """Return the spread of entry i of M servo + C speeds + G.

    Spreads add up (Theorem 1.4), or their squares do (Theorem 1.5, product grades).
    """
    n = servo.size
    coriolis = n * (n + 1) // 2
    gravity = coriolis + n * n
    width = spread[gravity + i] * spread[gravity + i] if squares else spread[gravity + i]
    for j in range(n):
        a, b = min(i, j), max(i, j)
        one, two = (
            abs(servo[j]) * spread[a * (2 * n - 1 - a) // 2 + b],
            abs(speeds[j]) * spread[coriolis + n * i + j],
        )
        width += one * one + two * two if squares else one + two
    return math.sqrt(width) if squares else width


@scalar
def _centroid_of_force(controller, ends, added, servo, speeds, room, out):
    """Write the centroid (eq. 1.68) of the fuzzy force M servo + C speeds + G.

    ``ends`` are those of M, C and G, plane by plane. On every plane the force is an interval
    (Theorem 1.4), its α-cut. Between two planes the ends of the cut are linear in the level, and
    below the lowest plane they are those of the lowest: ``fuzzy2.reduction.general.cut_centroid``.
    """
    planes, n, count = controller.planes.shape[1], servo.size, controller.fallback.size
    middle, spread, ready = room[:count], room[count : 2 * count], 2 * count
    centers, widths = room[ready : ready + n * planes], room[ready + n * planes :]
    for plane in range(planes):
        for j in range(count):
            o = 2 * (plane * count + j)
            middle[j], spread[j] = 0.5 * (ends[o] + ends[o + 1]), 0.5 * (ends[o + 1] - ends[o])
        for j in range(added.size):
            middle[j] += added[j]
        apply_model(middle, servo, speeds, centers, n * plane)
        for i in range(n):
            widths[n * plane + i] = width_of_force(spread, servo, speeds, i, False)
    for i in range(n):
        # Relative to the middle of the lowest cut, so a large force keeps its digits.
        origin, area, moment = centers[i], controller.planes[0, 0] * widths[i], 0.0
        for plane in range(1, planes):
            o, step = n * plane + i, controller.planes[0, plane] - controller.planes[0, plane - 1]
            c0, c1, w0, w1 = centers[o - n] - origin, centers[o] - origin, widths[o - n], widths[o]
            area += step * 0.5 * (w0 + w1)
            moment += step * (c0 * (2.0 * w0 + w1) + c1 * (w0 + 2.0 * w1)) / 6.0
        out[i] = origin + moment / area if area > 0.0 else origin


@scalar
def write_servo(controller, positions, speeds, desired, servo):
    """Write the servo's acceleration command.

    ``desired`` holds positions, speeds and accelerations.
    """
    n = servo.size
    for i in range(n):
        servo[i] = (
            desired[2 * n + i]
            + controller.kv * (desired[n + i] - speeds[i])
            + controller.kp * (desired[i] - positions[i])
        )


@scalar
def _usable(controller, x, speeds, added, estimate):
    """Write the rules' estimate; return whether it is usable."""
    crisp, middle, spread = estimate.crisp, estimate.middle, estimate.spread
    total, count = 0.0, crisp.size
    for i in range(x.size):
        total += x[i]
    for i in range(speeds.size):
        total += speeds[i]
    if not math.isfinite(total):
        return False
    for j in range(count):
        spread[j] = 0.0
    _estimate(controller, x, speeds, estimate)
    for j in range(added.size):
        crisp[j] += added[j]
        middle[j] += added[j]
    for j in range(count):
        total += crisp[j] + spread[j]
    return math.isfinite(total) and is_positive_definite(crisp, speeds.size, estimate.room)


@compiled
def _exact_torque(model, positions, speeds, servo, added, out):
    """Write a step of the exact forces, which take over; NaN if there are none."""
    n = servo.size
    force = out[:n]
    if not write_forces(model, positions, speeds, servo, force):
        force[:] = math.nan
    if added.size > 0:
        add_force(added, servo, speeds, force)
    for i in range(n):
        out[n + i] = out[2 * n + i] = out[i]


@scalar
def _learned_step(controller, positions, speeds, desired, added, work, out):
    """Write a step of the estimated forces, unless the exact ones take over.

    Return whether the torque is finite, 1 or 0, or -1 if the exact forces take over: then only the
    servo's command is written, the first n numbers of ``work``.
    """
    n, inputs = positions.size, controller.inputs.shape[1]
    servo, x = work[:n], work[n : n + inputs]
    estimate = _new_estimate(controller, work[n + inputs :])
    crisp, middle, spread = estimate.crisp, estimate.middle, estimate.spread
    count, corollary = crisp.size, controller.kind == COROLLARY
    clamp = controller.outside == CLAMP
    covered = write_inputs(controller.inputs, controller.ranges, clamp, positions, speeds, x)
    write_servo(controller, positions, speeds, desired, servo)
    out[3 * n] = 1.0 if covered else 0.0
    if not (covered or clamp):
        return -1
    usable = _usable(controller, x, speeds, added, estimate)
    out[3 * n + 1] = 0.0 if usable else 1.0
    if not usable:
        for j in range(count):
            crisp[j] = middle[j] = controller.fallback[j]
            spread[j] = 0.0
    apply_model(crisp, servo, speeds, out, 0)
    if controller.kind == CENTROID and usable:
        _centroid_of_force(controller, estimate.numbers, added, servo, speeds, estimate.room, out)
    apply_model(middle, servo, speeds, out, n)
    total = 0.0
    for i in range(n):
        width = width_of_force(spread, servo, speeds, i, corollary and controller.product > 0)
        if corollary:
            out[2 * n + i] = width
        else:
            out[n + i], out[2 * n + i] = out[n + i] - width, out[n + i] + width
        total += out[i]
    return 1 if math.isfinite(total) else 0


@compiled
def fuzzy_torque(
    controller: Fuzzy,
    model: Any,
    positions: Array,
    speeds: Array,
    desired: Array,
    added: Array,
    out: Array,
) -> bool:
    """Write one step of the fuzzy computed-torque controller, see ``step_width``.

    Return whether the torque is finite.

    ``desired`` holds positions, speeds and accelerations; ``added`` is empty, or the numbers that
    are added to the estimates.
    """
    work = np.empty(_step_room(controller, positions.size))
    done: int = _learned_step(controller, positions, speeds, desired, added, work, out)
    if controller.outside == CRISP and done < 0:
        n = positions.size
        _exact_torque(model, positions, speeds, work[:n], added, out)
        out[3 * n + 1] = 0.0
        if controller.kind == COROLLARY:
            out[2 * n : 3 * n] = 0.0
        total = 0.0
        for i in range(n):
            total += out[i]
        return math.isfinite(total)
    return done == 1


@compiled
def control_step(
    controller: Array,
    model: Any,
    positions: Array,
    speeds: Array,
    desired_positions: Array,
    desired_speeds: Array,
    desired_accelerations: Array,
    out: Array,
) -> int:
    """Do as ``fuzzy_torque`` for a packed controller and rows that come one by one.

    Return 1, 0 if the torque is not finite, or -1 if a row does not have n numbers.
    """
    n = (out.size - 2) // 3
    if not (
        positions.size
        == speeds.size
        == desired_positions.size
        == desired_speeds.size
        == desired_accelerations.size
        == n
    ):
        return -1
    desired = np.empty(3 * n)
    for i in range(n):
        desired[i], desired[n + i], desired[2 * n + i] = (
            desired_positions[i],
            desired_speeds[i],
            desired_accelerations[i],
        )
    unpacked = _unpacked(controller)
    return 1 if fuzzy_torque(unpacked, model, positions, speeds, desired, np.empty(0), out) else 0


@compiled
def clamped_step(
    controller: Array,
    positions: Array,
    speeds: Array,
    desired_positions: Array,
    desired_speeds: Array,
    desired_accelerations: Array,
    out: Array,
) -> int:
    """Do as ``control_step`` without a model; passing a table takes as long as five rows."""
    done: int = control_step(
        controller,
        NO_MODEL,
        positions,
        speeds,
        desired_positions,
        desired_speeds,
        desired_accelerations,
        out,
    )
    return done


@steer.register(FuzzyRun)
@compiled
def run_step(
    run: FuzzyRun,
    sample: int,
    t: float,
    positions: Array,
    speeds: Array,
    desired: Array,
    out: Array,
) -> bool:
    """Do as ``fuzzy_torque`` in a loop."""
    count, width = run.added.shape
    # A slice of one row, which is empty if there are no rows.
    width = width if count > 0 else 0
    added = run.added.reshape(run.added.size)[sample * width : sample * width + width]
    done: bool = fuzzy_torque(run.controller, run.model, positions, speeds, desired, added, out)
    return done
