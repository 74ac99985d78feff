r"""Compiled objective of fine-tuning with its gradient, for :mod:`fuzzy2.learning.tunable_system`.

The samples are processed one at a time. The logarithm of a rule's firing strength is the sum of the
logarithms of its grades under the product, and the logarithm of the smallest grade under the
minimum. So

.. math:: \frac{\partial y}{\partial \log \mu_{ri}} = w_r \frac{\partial y}{\partial w_r},

Only ratios of firing strengths matter, so strengths that would underflow are taken relative to the
greatest.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fuzzy2.support.checks import Array
from fuzzy2.support.compiled import compiled
from fuzzy2.systems.firing_kernels import VANISHED

CERTAIN, UNCERTAIN_MEAN, UNCERTAIN_SIGMA = 0, 1, 2
NUMBERS, INTERVALS, LINEAR = 0, 1, 2


class Layout(NamedTuple):
    """The parts of a system that are not tuned, and the places of the parameters."""

    owners: NDArray[np.int64]
    """Input of each term, (T,)."""
    kinds: NDArray[np.int64]
    """Which parameter of each term is uncertain, (T,)."""
    starts: NDArray[np.int64]
    """Place where the parameters of each term begin, (T,)."""
    log_heights: Array
    """Logarithms of the terms' heights, (T,)."""
    rules: NDArray[np.int64]
    """Number of each input's term in each rule, among all terms, or -1, (R, p)."""
    input_scales: Array
    """Units of the inputs, (p,)."""
    spreads: Array
    """Half-widths of linear consequents in units of the outputs, (R, m, p + 1)."""
    certain: int
    """Whether both ends of every average are equal, 0 or 1."""
    minimum: int
    """Whether grades are combined by the minimum, 0 or 1."""
    consequents: int
    """Kind of the consequents: numbers, intervals or linear functions."""
    first: int
    """Place where the parameters of the consequents begin."""


@compiled
def _log_grades(layout, parameters, x, distances, logs):
    """Write the distances (2 T,) in standard deviations, and the logarithms of the grades.

    Those of the lower membership come first.
    """
    for t in range(layout.owners.size):
        i, start, kind = layout.owners[t], layout.starts[t], layout.kinds[t]
        scale = layout.input_scales[i]
        first = last = scale * parameters[start]
        start += 1
        if kind == UNCERTAIN_MEAN:
            last = scale * parameters[start]
            start += 1
        s_low = s_high = math.exp(parameters[start])
        if kind == UNCERTAIN_SIGMA:
            s_high = math.exp(parameters[start + 1])
        far = (x[i] - (first if x[i] > 0.5 * first + 0.5 * last else last)) / s_low
        near = (x[i] - min(max(x[i], first), last)) / s_high
        distances[2 * t], distances[2 * t + 1] = far, near
        logs[2 * t] = layout.log_heights[t] - 0.5 * far * far
        logs[2 * t + 1] = layout.log_heights[t] - 0.5 * near * near


@compiled
def _fire(layout, logs, grades, firing):
    """Write the firing strengths (2 R,), relative to the greatest if they underflow.

    Return whether some rule fires.
    """
    rules, inputs = layout.rules.shape
    for t in range(logs.size):
        grades[t] = math.exp(logs[t])
    fires = 0.0
    for r in range(rules):
        low, high = 1.0, 1.0
        for i in range(inputs):
            t = layout.rules[r, i]
            if t < 0:
                continue
            if layout.minimum > 0:
                low, high = min(low, grades[2 * t]), min(high, grades[2 * t + 1])
            else:
                low *= grades[2 * t]
                high *= grades[2 * t + 1]
        firing[2 * r], firing[2 * r + 1] = low, high
        fires = max(fires, high)
    if fires > VANISHED:
        return True
    greatest = -math.inf
    for r in range(rules):
        low, high = 0.0, 0.0
        for i in range(inputs):
            t = layout.rules[r, i]
            if t < 0:
                continue
            if layout.minimum > 0:
                low, high = min(low, logs[2 * t]), min(high, logs[2 * t + 1])
            else:
                low += logs[2 * t]
                high += logs[2 * t + 1]
        firing[2 * r], firing[2 * r + 1] = low, high
        greatest = max(greatest, high)
    for k in range(firing.size):
        firing[k] = math.exp(firing[k] - greatest)
    return greatest > -math.inf


@compiled
def _consequents(layout, parameters, scaled, outputs, j, z):
    """Write both ends (2 R,) of the rules' consequents for an output."""
    rules = layout.rules.shape[0]
    columns = scaled.size
    for r in range(rules):
        o = layout.first + r * outputs + j
        if layout.consequents == LINEAR:
            o = layout.first + (r * outputs + j) * columns
            middle, spread = 0.0, 0.0
            for k in range(columns):
                middle += parameters[o + k] * scaled[k]
                spread += layout.spreads[r, j, k] * abs(scaled[k])
            z[2 * r], z[2 * r + 1] = middle - spread, middle + spread
        else:
            z[2 * r] = z[2 * r + 1] = parameters[o]
            if layout.consequents == INTERVALS:
                z[2 * r + 1] = parameters[o + rules * outputs]


@compiled
def _end_of(z, firing, end):
    """Return the left (0) or the right end (1) of the average of points with uncertain weights.

    It is the Karnik-Mendel iteration, which is Newton's iteration for the zero of a convex function
    and converges from one side.
    """
    rules = z.size // 2
    sign = 1.0 if end == 0 else -1.0
    mass, moment = 0.0, 0.0
    for r in range(rules):
        mass += firing[2 * r + 1]
        moment += firing[2 * r + 1] * z[2 * r + end]
    y = moment / mass
    # There are as many steps as switch points, and some more for rounding.
    for _ in range(rules + 20):
        mass, moment = 0.0, 0.0
        for r in range(rules):
            away = sign * (z[2 * r + end] - y)
            weight = firing[2 * r + 1] if away < 0.0 else firing[2 * r]
            mass += weight
            moment += weight * away
        if not (mass > 0.0 and moment < 0.0):
            break
        y += sign * moment / mass
    return y


@compiled
def _add_end(z, firing, end, y, slope, by_z, by_log):
    """Add the derivatives with respect to consequents and to logarithms of firing strengths.

    Both are (2 R,). ``slope`` is the derivative of the objective with respect to this end y.
    """
    rules = z.size // 2
    total = 0.0
    for r in range(rules):
        away = z[2 * r + end] - y
        takes_upper = away < 0.0 if end == 0 else away > 0.0
        total += firing[2 * r + 1] if takes_upper else firing[2 * r]
    # If a single rule fires and its lower firing is 0, its point is the end, and its whole weight
    # is the upper one.
    alone = not total > 0.0
    if alone:
        for r in range(rules):
            total += firing[2 * r + 1] if z[2 * r + end] == y else 0.0
    for r in range(rules):
        away = z[2 * r + end] - y
        takes_upper = away < 0.0 if end == 0 else away > 0.0
        k = 2 * r + 1 if takes_upper or (alone and away == 0.0) else 2 * r
        share = slope * firing[k] / total
        by_z[2 * r + end] += share
        by_log[k] += share * away


@compiled
def _add_premises(layout, parameters, x, distances, logs, by_log, along, gradient):
    """Add the derivatives with respect to means and logarithms of standard deviations.

    They follow from those with respect to logarithms of firing strengths (2 R,).
    """
    rules, inputs = layout.rules.shape
    along[:] = 0.0
    for r in range(rules):
        if layout.minimum > 0:
            for end in range(2):
                least, lowest = -1, math.inf
                for i in range(inputs):
                    t = layout.rules[r, i]
                    if t >= 0 and logs[2 * t + end] < lowest:
                        least, lowest = t, logs[2 * t + end]
                if least >= 0:
                    along[2 * least + end] += by_log[2 * r + end]
            continue
        for i in range(inputs):
            t = layout.rules[r, i]
            if t >= 0:
                along[2 * t] += by_log[2 * r]
                along[2 * t + 1] += by_log[2 * r + 1]
    for t in range(layout.owners.size):
        i, start, kind = layout.owners[t], layout.starts[t], layout.kinds[t]
        scale = layout.input_scales[i]
        far, near, low, high = (
            distances[2 * t],
            distances[2 * t + 1],
            along[2 * t],
            along[2 * t + 1],
        )
        if kind == UNCERTAIN_MEAN:
            sigma = math.exp(parameters[start + 2])
            first, last = scale * parameters[start], scale * parameters[start + 1]
            beyond = 0 if x[i] > 0.5 * first + 0.5 * last else 1
            gradient[start + beyond] += scale * low * far / sigma
            # Between the means the distance is 0, so the upper grade is constantly 1.
            gradient[start + (1 if x[i] > last else 0)] += scale * high * near / sigma
            gradient[start + 2] += low * far * far + high * near * near
            continue
        s_low = s_high = math.exp(parameters[start + 1])
        if kind == UNCERTAIN_SIGMA:
            s_high = math.exp(parameters[start + 2])
        gradient[start] += scale * (low * far / s_low + high * near / s_high)
        gradient[start + 1] += low * far * far
        gradient[start + (2 if kind == UNCERTAIN_SIGMA else 1)] += high * near * near


@compiled
def _add_consequents(layout, scaled, outputs, j, by_z, gradient):
    """Add the derivatives with respect to the parameters of an output's consequents."""
    rules = layout.rules.shape[0]
    columns = scaled.size
    for r in range(rules):
        both = by_z[2 * r] + by_z[2 * r + 1]
        o = layout.first + r * outputs + j
        if layout.consequents == LINEAR:
            o = layout.first + (r * outputs + j) * columns
            for k in range(columns):
                gradient[o + k] += both * scaled[k]
        elif layout.consequents == INTERVALS:
            gradient[o] += by_z[2 * r]
            gradient[o + rules * outputs] += by_z[2 * r + 1]
        else:
            gradient[o] += both


@compiled
def add_squares(
    layout: Layout,
    parameters: Array,
    X: Array,
    y: Array,
    slopes: bool,
    gradient: Array,
    total: float,
) -> tuple[float, int]:
    """Add up squared errors; return also -1, or the first sample at which no rule fires.

    Parameters
    ----------
    layout : Layout
        The system.
    parameters : (P,) ndarray
        Parameters with their pairs in order.
    X : (N, p) ndarray
        Inputs.
    y : (N, m) ndarray
        Outputs in their units.
    slopes : bool
        Whether to add the derivatives of the sum to ``gradient``.
    gradient : (P,) ndarray
        Receives the derivatives, which are added to it.
    total : float
        Sum over the previous samples.
    """
    terms, (rules, inputs), outputs = layout.owners.size, layout.rules.shape, y.shape[1]
    distances, logs, grades = np.empty(2 * terms), np.empty(2 * terms), np.empty(2 * terms)
    along = np.empty(2 * terms)
    firing, z = np.empty(2 * rules), np.empty(2 * rules)
    by_log, by_z = np.empty(2 * rules), np.empty(2 * rules)
    scaled = np.ones(inputs + 1)
    for n in range(X.shape[0]):
        x = X[n]
        for i in range(inputs):
            scaled[1 + i] = x[i] / layout.input_scales[i]
        _log_grades(layout, parameters, x, distances, logs)
        if not _fire(layout, logs, grades, firing):
            return total, n
        by_log[:] = 0.0
        for j in range(outputs):
            _consequents(layout, parameters, scaled, outputs, j, z)
            left = _end_of(z, firing, 0)
            right = left if layout.certain > 0 else _end_of(z, firing, 1)
            residual = 0.5 * (left + right) - y[n, j]
            total += residual * residual
            if slopes:
                by_z[:] = 0.0
                if layout.certain > 0:
                    _add_end(z, firing, 0, left, 2.0 * residual, by_z, by_log)
                else:
                    _add_end(z, firing, 0, left, residual, by_z, by_log)
                    _add_end(z, firing, 1, right, residual, by_z, by_log)
                _add_consequents(layout, scaled, outputs, j, by_z, gradient)
        if slopes:
            _add_premises(layout, parameters, x, distances, logs, by_log, along, gradient)
    return total, -1
