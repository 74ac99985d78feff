"""Compiled motor forces with a wanted effect, as :func:`psp3.dynamics.motors.least_norm`."""

from __future__ import annotations

import math

import numpy as np

from fuzzy2.support.compiled import compiled
from psp3.checks import Array
from psp3.dynamics.motors import LEFT_OVER, RANK


@compiled
def _longest(rows: Array, is_taken: Array) -> int:
    """Return the longest row that has not been used."""
    best, largest = 0, -1.0
    for row in range(rows.shape[0]):
        square = 0.0
        for j in range(rows.shape[1]):
            square += rows[row, j] * rows[row, j]
        if is_taken[row] == 0.0 and square > largest:
            best, largest = row, square
    return best


@compiled
def _made_square(rows: Array, row: int, units: Array, count: int) -> float:
    """Subtract a row's components along the unit vectors, and return the remaining length."""
    square = 0.0
    for unit in range(count):
        along = 0.0
        for j in range(rows.shape[1]):
            along += rows[row, j] * units[unit, j]
        for j in range(rows.shape[1]):
            rows[row, j] -= along * units[unit, j]
    for j in range(rows.shape[1]):
        square += rows[row, j] * rows[row, j]
    return math.sqrt(square)


@compiled
def _is_done(matrix: Array, wanted: Array, forces: Array) -> bool:
    """Tell whether forces have the wanted effect, to rounding."""
    largest, missed = 0.0, 0.0
    for row in range(wanted.size):
        rest = wanted[row]
        largest = max(largest, abs(rest))
        for j in range(forces.size):
            rest -= matrix[row, j] * forces[j]
        # Written so that NaN counts as missed.
        missed = missed if abs(rest) <= missed else abs(rest)
    done: bool = missed <= LEFT_OVER * (1.0 + largest)
    return done


@compiled
def shortest(matrix: Array, wanted: Array, out: Array) -> bool:
    """Write the shortest motor forces (m,) with a wanted effect (k,); return whether they have it.

    ``matrix`` (k, m) is the effect of each motor. Its rows are made orthogonal, the longest
    remaining row first (Gram–Schmidt, applied twice: B. N. Parlett, The Symmetric Eigenvalue
    Problem, 1980, section 6.9). Each row adds its missing effect to the forces. A row whose
    remaining length is less than ``RANK`` of the longest follows from the others, or its effect
    cannot be reached.
    """
    k, m = matrix.shape
    rows, units, is_taken = np.empty((k, m)), np.empty((min(k, m), m)), np.zeros(k)
    for row in range(k):
        for j in range(m):
            rows[row, j] = matrix[row, j]
    first = 0.0
    out[:] = 0.0
    for unit in range(min(k, m)):
        row = _longest(rows, is_taken)
        _made_square(rows, row, units, unit)
        length = _made_square(rows, row, units, unit)
        first = max(first, length)
        if not length > RANK * first:
            break
        is_taken[row], rest = 1.0, wanted[row]
        for j in range(m):
            units[unit, j] = rows[row, j] / length
            rest -= matrix[row, j] * out[j]
        for j in range(m):
            out[j] += rest / length * units[unit, j]
        for other in range(k):
            _made_square(rows, other, units, unit + 1)
    done: bool = _is_done(matrix, wanted, out)
    return done
