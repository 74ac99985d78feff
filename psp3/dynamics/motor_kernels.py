"""Which motor forces do what is wanted, compiled: as :func:`psp3.dynamics.motors.least_norm`."""

from __future__ import annotations

import math

import numpy as np

from fuzzy2.support.compiled import compiled
from psp3.checks import Array
from psp3.dynamics.motors import LEFT_OVER, RANK


@compiled
def _longest(rows: Array, is_taken: Array) -> int:
    """Return the longest of the rows that are not taken."""
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
    """Take from a row its parts along the units, and return the length that is left."""
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
    """Tell whether forces do what is wanted, to rounding."""
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
    """Write the shortest motor forces (m,) that do what is wanted, (k,); return whether they do.

    ``matrix`` (k, m) is what each motor does. Its rows are made square to one another, the longest
    that is left first (Gram and Schmidt, twice: B. N. Parlett, The Symmetric Eigenvalue Problem,
    1980, section 6.9), and each adds to the forces what it is short of. A row that adds less than
    ``RANK`` of the longest follows from the others, or cannot be done.
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
