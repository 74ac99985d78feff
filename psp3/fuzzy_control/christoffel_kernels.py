r"""C as the derivative of a learned M, compiled.

With the Christoffel symbols of the first kind,

.. math:: C_{ij} = \tfrac12 \sum_k \left(\frac{\partial M_{ij}}{\partial a_k}
          + \frac{\partial M_{ik}}{\partial a_j} - \frac{\partial M_{jk}}{\partial a_i}\right)
          \dot a_k,

:math:`\dot M - 2 C` is skew-symmetric, as for a real robot. M is the estimate of type-1 rules with
Gaussian terms whose grades are multiplied,

.. math:: M = \sum_r \phi_r M_r, \qquad
          \phi_r \propto \exp\left(-\tfrac12 \sum_i \frac{(x_i - m_{ri})^2}{\sigma_{ri}^2}\right),
          \qquad \frac{\partial \phi_r}{\partial x_i}
          = \phi_r \Big(d_{ri} - \sum_s \phi_s d_{si}\Big), \quad
          d_{ri} = -\frac{x_i - m_{ri}}{\sigma_{ri}^2}.

The uncertainty of a type-2 system's terms is ignored, so C is crisp. An input that is clamped to
the end of its trained range counts as constant, so it adds nothing to the derivative of M.
"""

from __future__ import annotations

import math

import numpy as np

from fuzzy2.support.compiled import scalar
from psp3.checks import Array

DERIVED = 2
"""Length of the head of :func:`derived`'s array, which holds the numbers of rules and inputs."""


def derived(columns: Array, ranges: Array, means: Array, sigmas: Array, mass: Array) -> Array:
    """Return the data that C is computed from, as one array.

    Parameters
    ----------
    columns : (q,) ndarray of int
        Indices of M's inputs among all inputs.
    ranges : (2, q) ndarray
        Least and greatest values of these inputs; beyond them M is constant.
    means, sigmas : (R, q) ndarray
        Means and standard deviations of each rule's terms.
    mass : (R, n (n + 1) / 2) ndarray
        Upper triangle of each rule's M.
    """
    parts = (columns, ranges, means, 1.0 / sigmas**2, mass)
    return np.concatenate([[*means.shape], *(np.ravel(part) for part in parts)]).astype(np.float64)


@scalar
def write_basis(means, precisions, x, phi, slopes):
    """Write basis functions (R,) of type-1 rules at x (q,), and their slopes (R, q)."""
    rules, inputs = means.shape
    largest = -math.inf
    for r in range(rules):
        total = 0.0
        for i in range(inputs):
            gap = x[i] - means[r, i]
            total -= 0.5 * gap * gap * precisions[r, i]
        phi[r] = total
        largest = max(largest, total)
    total = 0.0
    for r in range(rules):
        phi[r] = math.exp(phi[r] - largest)
        total += phi[r]
    for r in range(rules):
        phi[r] /= total
    for i in range(inputs):
        mean = 0.0
        for r in range(rules):
            slopes[r, i] = -(x[i] - means[r, i]) * precisions[r, i]
            mean += phi[r] * slopes[r, i]
        for r in range(rules):
            slopes[r, i] = phi[r] * (slopes[r, i] - mean)


@scalar
def slopes_of_positions(places, columns, ranges, x, slopes, out):
    """Write the slopes (R, n) along the positions from those (R, q) along the inputs x (q,).

    ``places`` (2, p) are those of all inputs in positions and speeds, see
    ``psp3.fuzzy_control.kernels.Fuzzy``.
    """
    n = out.shape[1]
    for r in range(out.shape[0]):
        for k in range(n):
            out[r, k] = 0.0
    for i in range(columns.size):
        if not ranges[0, i] < x[i] < ranges[1, i]:
            continue
        for side in range(2):
            place = int(places[side, int(columns[i])])
            if 0 <= place < n:
                for r in range(out.shape[0]):
                    out[r, place] += slopes[r, i] if side == 0 else -slopes[r, i]


@scalar
def christoffel_room(data: Array, n: int) -> int:
    """Return the size of the scratch array of :func:`write_christoffel` for n joints."""
    rules, inputs = int(data[0]), int(data[1])
    return inputs + rules * (1 + inputs + n) + n * (n * (n + 1) // 2)


@scalar
def slopes_at(data: Array, places: Array, x: Array, room: Array, along: Array) -> None:
    """Write the slopes (R, n) of M's basis functions along the positions, at inputs x (p,).

    ``room`` is scratch space of at most the size of :func:`christoffel_room` without ``along``.
    """
    rules, inputs = int(data[0]), int(data[1])
    o = DERIVED
    columns = data[o : o + inputs]
    o += inputs
    ranges = data[o : o + 2 * inputs].reshape(2, inputs)
    o += 2 * inputs
    means = data[o : o + rules * inputs].reshape(rules, inputs)
    o += rules * inputs
    precisions = data[o : o + rules * inputs].reshape(rules, inputs)
    asked, o = room[:inputs], inputs
    phi, o = room[o : o + rules], o + rules
    slopes = room[o : o + rules * inputs].reshape(rules, inputs)
    for i in range(inputs):
        asked[i] = x[int(columns[i])]
    write_basis(means, precisions, asked, phi, slopes)
    slopes_of_positions(places, columns, ranges, asked, slopes, along)


@scalar
def write_coriolis(along: Array, mass: Array, speeds: Array, room: Array, numbers: Array) -> None:
    """Write C (n, n) from M's consequents (R, n (n + 1) / 2) to its places in the numbers.

    ``room`` is scratch space for n such rows.
    """
    n, entries = speeds.size, mass.shape[1]
    rates = room[: n * entries].reshape(n, entries)
    for k in range(n):
        for entry in range(entries):
            rates[k, entry] = 0.0
    for r in range(mass.shape[0]):
        row = mass[r]
        for k in range(n):
            slope = along[r, k]
            rate = rates[k]
            for entry in range(entries):
                rate[entry] += slope * row[entry]
    for i in range(n):
        for j in range(n):
            total = 0.0
            for k in range(n):
                a, b = min(i, j), max(i, j)
                c, d = min(i, k), max(i, k)
                e, f = min(j, k), max(j, k)
                total += speeds[k] * (
                    rates[k, a * (2 * n - 1 - a) // 2 + b]
                    + rates[j, c * (2 * n - 1 - c) // 2 + d]
                    - rates[i, e * (2 * n - 1 - e) // 2 + f]
                )
            numbers[entries + n * i + j] = 0.5 * total


@scalar
def write_christoffel(
    data: Array, places: Array, x: Array, speeds: Array, room: Array, numbers: Array
) -> None:
    """Write C (n, n) to its places in the numbers, at inputs x (p,) and speeds (n,).

    ``room`` (:func:`christoffel_room`,) is scratch space.
    """
    rules, inputs, n = int(data[0]), int(data[1]), speeds.size
    mass = data[DERIVED + 3 * inputs + 2 * rules * inputs :].reshape(rules, n * (n + 1) // 2)
    along, rest = room[: rules * n].reshape(rules, n), room[rules * n :]
    slopes_at(data, places, x, rest, along)
    write_coriolis(along, mass, speeds, rest, numbers)
