"""Compiled control steps of the fuzzy computed-torque controller.

``p`` are the robot's parameters as :mod:`psp3.three_psp.closed_form` takes them.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from fuzzy2.support.compiled import compiled
from fuzzy2.systems.kernels import evaluate, evaluate_corollary, evaluate_planes
from psp3.checks import Array
from psp3.control.controller import steer
from psp3.three_psp.closed_form import equation_of_motion

INTERVAL, PLANES, COROLLARY, CENTROID = range(4)
"""Fuzzy controllers by what their estimates are: intervals, α-planes whose middles are weighted
before the torque is computed, Gaussian numbers, and α-planes that are carried on to the torque,
whose centroid is taken.
"""

CLAMP, CRISP = range(2)

OUTPUTS = 18
"""Estimated numbers: the upper triangle of M, C and G."""

STEP = 11
"""Numbers that ``fuzzy_torque`` writes: torque (3), left or mean (3), right or standard deviation
(3), covered, fell back.
"""

NOTHING_ADDED = np.empty((0, OUTPUTS))


def reported(steps: Array) -> dict[str, Any]:
    """Return what results report of steps (N, STEP), by its name."""
    return {
        "covered": steps[:, 9] > 0.0,
        "fell_back": steps[:, 10] > 0.0,
        "torque_interval": np.stack([steps[:, 3:6], steps[:, 6:9]], axis=-1),
    }


class Fuzzy(NamedTuple):
    """A trained controller.

    ``kind`` see above; gains ``kp`` and ``kv``; what to do ``outside``, ``CLAMP`` or ``CRISP``;
    whether grades are multiplied, 1 or 0; ``ranges`` (2, 4) lower and upper ends of the trained
    inputs; ``fallback`` (18,) numbers used where an estimate cannot be; ``planes`` (2, L) levels
    and widths, see ``fuzzy2.systems.kernels.evaluate_planes``; ``system`` the fuzzy system, see
    ``fuzzy2.systems.kernels``; ``moments`` (2, R, 18) middles and spreads, see
    ``fuzzy2.systems.kernels.evaluate_corollary``, of that kind only.
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


HEADER = 8
"""Numbers with which a packed controller begins: its scalars, then L, the size of the system, R."""


def packed(controller: Fuzzy) -> Array:
    """Return a controller as one array.

    Python hands over one array in less than a third of the time that five take, which single steps
    would feel; ``_unpacked`` reads it.
    """
    kind, kp, kv, outside, product, *arrays = controller
    header = [kind, kp, kv, outside, product]
    header += [controller.planes.shape[1], controller.system.size, controller.moments.shape[1]]
    return np.concatenate([header, *(array.ravel() for array in arrays)]).astype(np.float64)


@compiled
def _unpacked(array: Array) -> Fuzzy:
    """Return the controller that ``packed`` made one array of; its arrays are views."""
    levels, size, rules = int(array[5]), int(array[6]), int(array[7])
    ranges = HEADER
    fallback = ranges + 8
    planes = fallback + OUTPUTS
    system = planes + 2 * levels
    moments = system + size
    return Fuzzy(
        int(array[0]),
        array[1],
        array[2],
        int(array[3]),
        int(array[4]),
        array[ranges:fallback].reshape(2, 4),
        array[fallback:planes],
        array[planes:system].reshape(2, levels),
        array[system:moments],
        array[moments:].reshape(2, rules, OUTPUTS),
    )


class FuzzyRun(NamedTuple):
    """A trained controller in a loop: with the ``model`` that takes over where it is ``CRISP``.

    ``added`` (N, 18) is added to the estimates at each sample, or (0, 18).
    """

    controller: Fuzzy
    model: Array
    added: Array


@compiled
def is_positive_definite(m):
    """Whether M, given by its upper triangle, is finite and positive definite.

    By its leading minors.
    """
    m11, m12, m13, m22, m23, m33 = m[0], m[1], m[2], m[3], m[4], m[5]
    second = m11 * m22 - m12 * m12
    determinant = m33 * second - m11 * m23 * m23 + 2.0 * m12 * m13 * m23 - m22 * m13 * m13
    return m11 > 0.0 and second > 0.0 and determinant > 0.0 and math.isfinite(determinant)


@compiled
def _estimate(controller, x, numbers, crisp, middle, spread):
    """Write M, C and G estimated at the four differences.

    Crisp values, middles and half-widths, or means and standard deviations. ``numbers`` gets them
    as they are estimated: ends of the intervals, plane by plane, or means and standard deviations.
    """
    kind, planes = controller.kind, controller.planes.shape[1]
    if kind == COROLLARY:
        middles, spreads = controller.moments[0], controller.moments[1]
        product = controller.product > 0
        evaluate_corollary(controller.system, x, middles, spreads, product, numbers)
        for j in range(OUTPUTS):
            crisp[j] = middle[j] = numbers[2 * j]
            spread[j] = numbers[2 * j + 1]
        return
    if kind == INTERVAL:
        evaluate(controller.system, x, 0.0, False, numbers)
    else:
        evaluate_planes(controller.system, x, controller.planes[1], numbers)
    # What is shown of a general type-2 estimate is its lowest plane, the first.
    for j in range(OUTPUTS):
        middle[j], spread[j] = (
            0.5 * (numbers[2 * j] + numbers[2 * j + 1]),
            0.5 * (numbers[2 * j + 1] - numbers[2 * j]),
        )
        crisp[j] = middle[j]
    if kind != INTERVAL:
        total = 0.0
        for plane in range(planes):
            total += controller.planes[0, plane]
        for j in range(OUTPUTS):
            moment = 0.0
            for plane in range(planes):
                o = 2 * (plane * OUTPUTS + j)
                moment += controller.planes[0, plane] * (0.5 * (numbers[o] + numbers[o + 1]))
            crisp[j] = moment / total


@compiled
def apply_model(m, servo, speeds, out, o):
    """Write the force M servo + C speeds + G of eighteen numbers."""
    s1, s2, s3 = servo[0], servo[1], servo[2]
    out[o] = m[0] * s1 + m[1] * s2 + m[2] * s3
    out[o + 1] = m[1] * s1 + m[3] * s2 + m[4] * s3
    out[o + 2] = m[2] * s1 + m[4] * s2 + m[5] * s3
    for i in range(3):
        out[o + i] += (
            m[6 + 3 * i] * speeds[0]
            + m[7 + 3 * i] * speeds[1]
            + m[8 + 3 * i] * speeds[2]
            + m[15 + i]
        )


@compiled
def width_of_force(spread, servo, speeds, i, squares):
    """Spread of entry i of M servo + C speeds + G.

    Spreads add up (Theorem 1.4), or their squares (1.5, product grades).
    """
    width = spread[15 + i] * spread[15 + i] if squares else spread[15 + i]
    for j in range(3):
        a, b = min(i, j), max(i, j)
        one, two = (
            abs(servo[j]) * spread[a * (5 - a) // 2 + b],
            abs(speeds[j]) * spread[6 + 3 * i + j],
        )
        width += one * one + two * two if squares else one + two
    return math.sqrt(width) if squares else width


@compiled
def _centroid_of_force(controller, ends, added, servo, speeds, out):
    """Write the centroid (eq. 1.68) of the fuzzy force M servo + C speeds + G.

    ``ends`` are those of M, C and G, plane by plane. On every plane the force is an interval
    (Theorem 1.4), its α-cut. Between two planes the ends of the cut are linear in the level, and
    below the lowest plane they are those of the lowest: ``fuzzy2.reduction.general.cut_centroid``.
    """
    planes = controller.planes.shape[1]
    middle, spread = np.empty(OUTPUTS), np.empty(OUTPUTS)
    centers, widths = np.empty(3 * planes), np.empty(3 * planes)
    for plane in range(planes):
        for j in range(OUTPUTS):
            o = 2 * (plane * OUTPUTS + j)
            middle[j], spread[j] = 0.5 * (ends[o] + ends[o + 1]), 0.5 * (ends[o + 1] - ends[o])
        for j in range(added.size):
            middle[j] += added[j]
        apply_model(middle, servo, speeds, centers, 3 * plane)
        for i in range(3):
            widths[3 * plane + i] = width_of_force(spread, servo, speeds, i, False)
    for i in range(3):
        # About the middle of the lowest cut, so that a force far from zero keeps its digits.
        origin, area, moment = centers[i], controller.planes[0, 0] * widths[i], 0.0
        for plane in range(1, planes):
            o, step = 3 * plane + i, controller.planes[0, plane] - controller.planes[0, plane - 1]
            c0, c1, w0, w1 = centers[o - 3] - origin, centers[o] - origin, widths[o - 3], widths[o]
            area += step * 0.5 * (w0 + w1)
            moment += step * (c0 * (2.0 * w0 + w1) + c1 * (w0 + 2.0 * w1)) / 6.0
        out[i] = origin + moment / area if area > 0.0 else origin


@compiled
def exact_model(heights, speeds, p, full, m):
    """Write the exact eighteen numbers, or NaN where the pose is none of the machine's."""
    if equation_of_motion(heights, speeds, p, full) >= 0:
        full[:] = math.nan
    m[0], m[1], m[2], m[3], m[4], m[5] = full[0], full[1], full[2], full[4], full[5], full[8]
    for k in range(12):
        m[6 + k] = full[9 + k]


@compiled
def write_servo(controller, heights, speeds, desired, servo):
    """Write the acceleration that the servo asks for.

    ``desired`` holds heights, speeds and accelerations.
    """
    for i in range(3):
        servo[i] = (
            desired[6 + i]
            + controller.kv * (desired[3 + i] - speeds[i])
            + controller.kp * (desired[i] - heights[i])
        )


@compiled
def fuzzy_torque(
    controller: Fuzzy,
    p: Array,
    heights: Array,
    speeds: Array,
    desired: Array,
    added: Array,
    out: Array,
) -> bool:
    """Write one step of the fuzzy computed-torque controller, ``STEP`` numbers.

    Return whether the torque is finite.

    ``desired`` holds heights, speeds and accelerations; ``added`` is empty, or eighteen numbers
    that are added to the estimates.
    """
    x = np.empty(4)
    x[0], x[1], x[2], x[3] = (
        heights[0] - heights[1],
        heights[0] - heights[2],
        speeds[0] - speeds[1],
        speeds[0] - speeds[2],
    )
    clamp, covered = controller.outside == CLAMP, True
    for i in range(4):
        low, high = controller.ranges[0, i], controller.ranges[1, i]
        if not low <= x[i] <= high:
            covered = False
            if clamp:
                x[i] = min(max(x[i], low), high)
    crisp, middle, spread, servo = (
        np.empty(OUTPUTS),
        np.empty(OUTPUTS),
        np.zeros(OUTPUTS),
        np.empty(3),
    )
    numbers = np.empty(max(controller.planes.shape[1], 1) * 2 * OUTPUTS)
    fell_back, estimated = False, covered or clamp
    if estimated:
        total = x[0] + x[1] + x[2] + x[3]
        if math.isfinite(total):
            _estimate(controller, x, numbers, crisp, middle, spread)
            for j in range(added.size):
                crisp[j] += added[j]
                middle[j] += added[j]
            for j in range(OUTPUTS):
                total += crisp[j] + spread[j]
        if not (math.isfinite(total) and is_positive_definite(crisp)):
            fell_back = True
            for j in range(OUTPUTS):
                crisp[j] = middle[j] = controller.fallback[j]
                spread[j] = 0.0
    else:
        exact_model(heights, speeds, p, np.empty(21), crisp)
        for j in range(added.size):
            crisp[j] += added[j]
        middle[:] = crisp
    write_servo(controller, heights, speeds, desired, servo)
    apply_model(crisp, servo, speeds, out, 0)
    if controller.kind == CENTROID and estimated and not fell_back:
        _centroid_of_force(controller, numbers, added, servo, speeds, out)
    apply_model(middle, servo, speeds, out, 3)
    corollary = controller.kind == COROLLARY
    for i in range(3):
        width = width_of_force(spread, servo, speeds, i, corollary and controller.product > 0)
        if corollary:
            out[6 + i] = width
        else:
            out[3 + i], out[6 + i] = out[3 + i] - width, out[3 + i] + width
    out[9], out[10] = 1.0 if covered else 0.0, 1.0 if fell_back else 0.0
    return math.isfinite(out[0] + out[1] + out[2])


@compiled
def control_step(
    controller: Array,
    p: Array,
    heights: Array,
    speeds: Array,
    desired_heights: Array,
    desired_speeds: Array,
    desired_accelerations: Array,
    out: Array,
) -> int:
    """Do as ``fuzzy_torque`` for a packed controller and rows that come one by one.

    Return 1, 0 where the torque is not finite, or -1 for a row that is not of three.
    """
    if not (
        heights.size
        == speeds.size
        == desired_heights.size
        == desired_speeds.size
        == desired_accelerations.size
        == 3
    ):
        return -1
    desired = np.empty(9)
    for i in range(3):
        desired[i], desired[3 + i], desired[6 + i] = (
            desired_heights[i],
            desired_speeds[i],
            desired_accelerations[i],
        )
    return (
        1
        if fuzzy_torque(_unpacked(controller), p, heights, speeds, desired, np.empty(0), out)
        else 0
    )


@steer.register(FuzzyRun)
@compiled
def run_step(
    run: FuzzyRun,
    sample: int,
    t: float,
    heights: Array,
    speeds: Array,
    desired: Array,
    out: Array,
) -> bool:
    """Do as ``fuzzy_torque`` in a loop."""
    added = run.added[sample] if run.added.shape[0] > 0 else run.added[:0].reshape(0)
    done: bool = fuzzy_torque(run.controller, run.model, heights, speeds, desired, added, out)
    return done
