r"""Compiled loops of online adaptation: fuzzy basis functions, and least squares with forgetting.

:mod:`fuzzy2.learning.adaptation` calls them.

The least-squares problem is stored as its information matrix :math:`\Lambda` and right side
:math:`s`. New rows are added to them, and old ones fade. The weight of the prior is added when the
problem is solved. It never fades, so it bounds the inverted matrix from below, however little the
rows excite the system.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from fuzzy2.support.checks import Array
from fuzzy2.support.compiled import compiled
from fuzzy2.systems.firing_kernels import VANISHED, _fire
from fuzzy2.systems.kernels import firing
from fuzzy2.systems.log_firing_kernels import log_fire

SWEEPS = 10
"""Sweeps of coordinate descent for each solution with active bounds."""


@compiled
def _sort(values, order):
    """Sort the indices in ``order`` by ascending values.

    It takes few steps if the order was nearly right before.
    """
    for i in range(1, order.size):
        index = order[i]
        j = i - 1
        while j >= 0 and values[order[j]] > values[index]:
            order[j + 1] = order[j]
            j -= 1
        order[j + 1] = index


@compiled
def _end(points, order, strengths, largest, left, out):
    """Write the weights of the left or right end of the generalized centroid.

    The weights add up to 1, and the end is the average of the points with these weights.
    """
    rules = points.size
    mass, moment = 0.0, 0.0
    first = points[order[0]] if left else points[order[rules - 1]]
    for r in range(rules):
        out[r] = strengths[2 * r] / largest
        mass += out[r]
        moment += out[r] * abs(points[r] - first)
    # From the extreme point inward, weights become upper ones as long as that moves the average
    # outward.
    for i in range(rules):
        r = order[i] if left else order[rules - 1 - i]
        distance = abs(points[r] - first)
        if mass > 0.0 and distance * mass >= moment:
            break
        more = (strengths[2 * r + 1] - strengths[2 * r]) / largest
        out[r] += more
        mass += more
        moment += more * distance
    for r in range(rules):
        out[r] /= mass


@compiled
def _is_crisp(strengths):
    """Return whether firing strengths are crisp, as for type-1 rules."""
    crisp = True
    for r in range(strengths.size // 2):
        crisp = crisp and strengths[2 * r] == strengths[2 * r + 1]
    return crisp


@compiled
def basis(
    table: Array,
    x: Array,
    consequents: Array,
    orders: NDArray[np.int64],
    strengths: Array,
    out: Array,
) -> bool:
    """Write the fuzzy basis functions (2 m, R) of both ends for consequents (2 m, R).

    Return False where no rule fires.

    For each output the row of left ends comes first. Only the antecedents of the system in
    ``table`` are used. ``orders`` (2 m, R) holds any order of the rules, and receives the order of
    the consequents where it is needed. ``strengths`` (2 R,) receives the firing intervals.
    """
    firing(table, x, 0.0, strengths)
    ends, rules = consequents.shape
    largest = 0.0
    for r in range(rules):
        largest = max(largest, strengths[2 * r + 1])
    if not largest > 0.0:
        return False
    if _is_crisp(strengths):
        # If firing is crisp, all ends of all outputs have the same weights, whatever the order.
        first = out[0]
        _end(consequents[0], orders[0], strengths, largest, True, first)
        for row in range(ends):
            for r in range(rules):
                out[row, r] = first[r]
        return True
    for row in range(ends):
        points, order = consequents[row], orders[row]
        _sort(points, order)
        _end(points, order, strengths, largest, row % 2 == 0, out[row])
    return True


@compiled
def _is_lost(strengths):
    """Return whether an end may depend on firing strengths (2 R,) that underflow.

    It decides as ``fuzzy2.systems.log_firing_kernels.lost``.
    """
    least = math.inf
    for r in range(strengths.size // 2):
        if strengths[2 * r] >= VANISHED:
            return False
        least = min(least, strengths[2 * r + 1])
    return least < VANISHED


@compiled
def _far_end(points, order, low, high, left, used, out):
    """Do as ``_end`` with logarithms of firing strengths, so that no ratio of them underflows.

    At least one upper strength must be above 0. The weights are those of the first switch point
    after which the average moves inward.
    """
    rules, count = points.size, 0
    for i in range(rules):
        r = order[i] if left else order[rules - 1 - i]
        out[r] = 0.0
        if high[r] > -math.inf:
            used[count] = r
            count += 1
    first, best, switch = points[used[0]], math.inf, 1
    for k in range(1, count + 1):
        largest, mass, moment = -math.inf, 0.0, 0.0
        for i in range(count):
            largest = max(largest, high[used[i]] if i < k else low[used[i]])
        for i in range(count):
            weight = math.exp((high[used[i]] if i < k else low[used[i]]) - largest)
            mass += weight
            moment += weight * abs(points[used[i]] - first)
        if moment / mass > best:
            break
        if moment / mass < best:
            best, switch = moment / mass, k
    largest, mass = -math.inf, 0.0
    for i in range(count):
        largest = max(largest, high[used[i]] if i < switch else low[used[i]])
    for i in range(count):
        out[used[i]] = math.exp((high[used[i]] if i < switch else low[used[i]]) - largest)
        mass += out[used[i]]
    for i in range(count):
        out[used[i]] /= mass


@compiled
def _far_basis(table, x, consequents, orders, out):
    """Do as ``basis`` where firing strengths underflow, with their logarithms.

    Controllers that adapt call ``basis`` alone: so far from all terms they trust no rule.
    """
    rules, fires = int(table[2]), False
    deepest = int(table[int(table[5]) + 3]) if table[5] > 0.0 else 0
    grades, stack = np.empty(2 * int(table[1])), np.empty(2 * deepest)
    low, high, used = np.empty(rules), np.empty(rules), np.empty(rules, np.int64)
    _fire(table, x, 0, 0.0, grades, low, high, stack)
    log_fire(table, x, 0, 0.0, grades, low, high, stack)
    for r in range(rules):
        fires = fires or high[r] > -math.inf
    for row in range(consequents.shape[0] if fires else 0):
        _sort(consequents[row], orders[row])
        _far_end(consequents[row], orders[row], low, high, row % 2 == 0, used, out[row])
    return fires


@compiled
def _any_basis(table, x, consequents, orders, strengths, out):
    """Do as ``basis``, as far from all terms as the system itself answers."""
    fires = basis(table, x, consequents, orders, strengths, out)
    return _far_basis(table, x, consequents, orders, out) if _is_lost(strengths) else fires


@compiled
def forget(information: Array, right: Array, factor: float) -> None:
    """Multiply the information (n, n) and the right side (n,) by a factor.

    Only the upper triangle of the information is stored.
    """
    n = right.size
    for i in range(n):
        right[i] *= factor
        row = information[i][i:]
        for j in range(n - i):
            row[j] *= factor


@compiled
def add(information: Array, right: Array, row: Array, residual: float, weight: float) -> None:
    """Add a row (n,) with its residual, multiplied by a weight."""
    n = right.size
    for i in range(n):
        scaled = weight * row[i]
        if scaled != 0.0:
            right[i] += scaled * residual
            target, other = information[i][i:], row[i:]
            for j in range(n - i):
                target[j] += scaled * other[j]


@compiled
def solve(information: Array, right: Array, prior: Array, factor: Array, out: Array) -> bool:
    """Solve (information + diag(prior)) out = right by Cholesky's method.

    ``factor`` (n, n) receives the upper factor.

    Return whether the matrix is positive definite. It is unless numbers overflow, because the prior
    (n,) is positive.
    """
    n = right.size
    for i in range(n):
        source, target = information[i][i:], factor[i][i:]
        for j in range(n - i):
            target[j] = source[j]
        target[0] += prior[i]
        out[i] = right[i]
    # Each row is subtracted from those below it, because the compiler vectorizes only along rows.
    for k in range(n):
        pivot = factor[k, k]
        if not 0.0 < pivot < math.inf:
            return False
        scale = 1.0 / math.sqrt(pivot)
        above = factor[k][k:]
        for j in range(n - k):
            above[j] *= scale
        out[k] *= scale
        for i in range(k + 1, n):
            share = above[i - k]
            if share != 0.0:
                target, source = factor[i][i:], factor[k][i:]
                for j in range(n - i):
                    target[j] -= share * source[j]
                out[i] -= share * out[k]
    for i in range(n - 1, -1, -1):
        total = out[i]
        row = factor[i]
        for j in range(i + 1, n):
            total -= row[j] * out[j]
        out[i] = total / row[i]
    return True


@compiled
def settle(
    information: Array,
    right: Array,
    prior: Array,
    lower: Array,
    upper: Array,
    sweeps: int,
    whole: Array,
    gradient: Array,
    out: Array,
) -> None:
    """Improve ``out`` within the box, toward the least-squares solution within the box.

    It uses sweeps of coordinate descent.

    No step leaves the box or increases the sum of squares; each step goes to the best point on its
    line. ``whole`` (n, n) and ``gradient`` (n,) are scratch space.
    """
    n = right.size
    for i in range(n):
        source = information[i][i:]
        for j in range(n - i):
            whole[i, i + j] = source[j]
        for j in range(i):
            whole[i, j] = whole[j, i]
        whole[i, i] += prior[i]
    for i in range(n):
        row = whole[i]
        total = -right[i]
        for j in range(n):
            total += row[j] * out[j]
        gradient[i] = total
    for _ in range(sweeps):
        moved = False
        for i in range(n):
            row = whole[i]
            best = min(max(out[i] - gradient[i] / row[i], lower[i]), upper[i])
            step = best - out[i]
            if step != 0.0:
                moved = True
                out[i] = best
                for j in range(n):
                    gradient[j] += step * row[j]
        if not moved:
            return


@compiled
def _write(row, phi, is_interval):
    """Write the derivatives (R,) or (2 R,) of a crisp output with respect to the consequents.

    Consequents are numbers or intervals.
    """
    rules = phi.shape[1]
    for r in range(rules):
        if is_interval:
            row[r], row[rules + r] = 0.5 * phi[0, r], 0.5 * phi[1, r]
        else:
            row[r] = 0.5 * (phi[0, r] + phi[1, r])


@compiled
def solve_within(
    information: Array,
    right: Array,
    prior: Array,
    lower: Array,
    upper: Array,
    factor: Array,
    trial: Array,
    out: Array,
) -> None:
    """Solve the least-squares problem within the box, starting from ``out`` if bounds are active.

    ``factor`` (n, n) and ``trial`` (n,) are scratch space. The problem changes little between two
    samples, so a few sweeps from the last solution suffice.
    """
    if not solve(information, right, prior, factor, trial):
        return
    is_inside = True
    for i in range(trial.size):
        is_inside = is_inside and lower[i] <= trial[i] <= upper[i]
    if is_inside:
        out[:] = trial
    else:
        settle(information, right, prior, lower, upper, SWEEPS, factor, trial, out)


@compiled
def _by_end(ends):
    """Return numbers (m, 2, R) as rows (2 m, R)."""
    return ends.reshape(2 * ends.shape[0], ends.shape[2])


@compiled
def learn(  # noqa: PLR0913 (compiled: plain arrays and numbers, no object)
    table: Array,
    x: Array,
    y: Array,
    trained: Array,
    lower: Array,
    upper: Array,
    prior: Array,
    forgetting: float,
    information: Array,
    right: Array,
    moved: Array,
    consequents: Array,
    orders: NDArray[np.int64],
    errors: Array,
) -> None:
    """Learn from samples x (N, p), y (N, m) one after the other.

    Write the errors before learning from each sample, (N, m).

    ``trained`` and ``consequents`` are (m, 2, R), ``information`` (m, n, n) and ``right`` (m, n)
    with n = R for consequents that are numbers and 2 R for intervals. ``moved`` (m, n) are the
    differences to the trained consequents, between ``lower`` and ``upper``; ``prior`` is (n,).
    """
    outputs, rules = consequents.shape[0], consequents.shape[2]
    size = right.shape[1]
    strengths, phi = np.empty(2 * rules), np.empty((2 * outputs, rules))
    row, trial, factor = np.empty(size), np.empty(size), np.empty((size, size))
    for n in range(x.shape[0]):
        if not _any_basis(table, x[n], _by_end(consequents), _by_end(orders), strengths, phi):
            errors[n, :] = math.nan
            continue
        for j in range(outputs):
            before, now = 0.0, 0.0
            for r in range(rules):
                for end in range(2):
                    before += 0.5 * phi[2 * j + end, r] * trained[j, end, r]
                    now += 0.5 * phi[2 * j + end, r] * consequents[j, end, r]
            errors[n, j] = y[n, j] - now
            _write(row, phi[2 * j : 2 * j + 2], size == 2 * rules)
            forget(information[j], right[j], forgetting)
            add(information[j], right[j], row, y[n, j] - before, 1.0)
            solve_within(
                information[j], right[j], prior, lower[j], upper[j], factor, trial, moved[j]
            )
            for r in range(rules):
                low = trained[j, 0, r] + moved[j, r]
                high = trained[j, 1, r] + moved[j, rules + r if size == 2 * rules else r]
                if low > high:
                    low = high = 0.5 * (low + high)
                consequents[j, 0, r], consequents[j, 1, r] = low, high


@compiled
def evaluate(
    table: Array, x: Array, consequents: Array, orders: NDArray[np.int64], out: Array
) -> None:
    """Write the crisp outputs (N, m) at inputs (N, p); NaN where no rule fires."""
    outputs, rules = consequents.shape[0], consequents.shape[2]
    strengths, phi = np.empty(2 * rules), np.empty((2 * outputs, rules))
    for n in range(x.shape[0]):
        fires = _any_basis(table, x[n], _by_end(consequents), _by_end(orders), strengths, phi)
        for j in range(outputs):
            total = 0.0
            for r in range(rules):
                low = phi[2 * j, r] * consequents[j, 0, r]
                total += low + phi[2 * j + 1, r] * consequents[j, 1, r]
            out[n, j] = 0.5 * total if fires else math.nan
