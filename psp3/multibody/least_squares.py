r"""Compiled least squares of a group's equations: Householder reflections without pivoting.

A matrix of m rows and u ≤ m columns is stored column by column. The equations of one leg have zeros
in the columns of the other legs. The columns are ordered so that reflections keep most of these
zeros.
"""

from __future__ import annotations

import math

from fuzzy2.support.compiled import scalar

SMALLEST_PIVOT = 1e-9
"""A column counts as dependent if its new component is smaller than this share of the largest one.
A condition number above 1e9 would leave too few correct digits.
"""


@scalar
def factor(tree, memory, ends, at, into, rows, columns):
    """Factor the matrix that begins at ``at`` in place, Q R; write reflection weights to ``into``.

    ``ends`` is the place in the whole numbers of the row below the last entry of each column.
    Return the smallest pivot, with the sign of the determinant if the matrix is square; 0 if its
    columns are not independent.
    """
    sign, largest, least = 1.0, 0.0, math.inf
    for k in range(columns):
        d, end = at + rows * k, tree[ends + k]
        square = 0.0
        for i in range(k + 1, end):
            square += memory[d + i] * memory[d + i]
        diagonal = memory[d + k]
        memory[into + k] = 0.0
        if square > 0.0:
            norm = math.sqrt(square + diagonal * diagonal)
            beta = -norm if diagonal > 0.0 else norm
            weight = (beta - diagonal) / beta
            memory[into + k] = weight
            scale = 1.0 / (diagonal - beta)
            for i in range(k + 1, end):
                memory[d + i] *= scale
            for j in range(k + 1, columns):
                c = at + rows * j
                dot = memory[c + k]
                for i in range(k + 1, end):
                    dot += memory[d + i] * memory[c + i]
                if dot != 0.0:
                    dot *= weight
                    memory[c + k] -= dot
                    for i in range(k + 1, end):
                        memory[c + i] -= dot * memory[d + i]
            # A reflection has the determinant −1.
            sign = -sign
            diagonal = beta
            memory[d + k] = beta
        size = abs(diagonal)
        sign = -sign if diagonal < 0.0 else sign
        largest = max(largest, size)
        # Written so that NaN counts as small.
        least = least if size >= least else size
    return sign * least if least > SMALLEST_PIVOT * largest else 0.0


@scalar
def reflect(tree, memory, ends, at, into, rows, k, row):
    """Apply the reflection of column k to the entries that begin at ``row``."""
    weight = memory[into + k]
    if weight != 0.0:
        d, end = at + rows * k, tree[ends + k]
        dot = memory[row + k]
        for i in range(k + 1, end):
            dot += memory[d + i] * memory[row + i]
        if dot != 0.0:
            dot *= weight
            memory[row + k] -= dot
            for i in range(k + 1, end):
                memory[row + i] -= dot * memory[d + i]


@scalar
def solve(tree, memory, ends, at, into, rows, columns, row):
    """Replace the right side, which begins at ``row``, by the least-squares solution.

    The solution takes the first entries.
    """
    for k in range(columns):
        reflect(tree, memory, ends, at, into, rows, k, row)
    for k in range(columns - 1, -1, -1):
        d = at + rows * k
        value = memory[row + k] / memory[d + k]
        memory[row + k] = value
        for i in range(k):
            memory[row + i] -= value * memory[d + i]


@scalar
def solve_transposed(tree, memory, ends, at, into, rows, columns, row):
    """Replace u entries by the shortest m entries that the transposed matrix maps to them."""
    for k in range(columns):
        d = at + rows * k
        value = memory[row + k]
        for i in range(k):
            value -= memory[d + i] * memory[row + i]
        memory[row + k] = value / memory[d + k]
    for k in range(columns, rows):
        memory[row + k] = 0.0
    for k in range(columns - 1, -1, -1):
        reflect(tree, memory, ends, at, into, rows, k, row)


@scalar
def orientation(memory, at, order):
    """Return the sign of the determinant of a square matrix, stored column by column.

    It is found by elimination; the matrix is overwritten.
    """
    sign = 1.0
    for k in range(order):
        d = at + order * k
        best = k
        for i in range(k + 1, order):
            if abs(memory[d + i]) > abs(memory[d + best]):
                best = i
        pivot = memory[d + best]
        if pivot == 0.0:
            return 0.0
        if best != k:
            sign = -sign
            for j in range(k, order):
                c = at + order * j
                memory[c + k], memory[c + best] = memory[c + best], memory[c + k]
        sign = -sign if pivot < 0.0 else sign
        for j in range(k + 1, order):
            c = at + order * j
            share = memory[c + k] / pivot
            if share != 0.0:
                for i in range(k + 1, order):
                    memory[c + i] -= share * memory[d + i]
    return sign
