r"""M, C and G of n joints as one row of numbers.

M is symmetric, so :math:`K = \tfrac12 n (n + 1) + n^2 + n` numbers hold all of them: the upper
triangle of M, row by row, then C, then G; the 3-PSP has eighteen.
"""

from __future__ import annotations

import math

import numpy as np

from psp3.checks import Array, Indices


def count_of_numbers(joints: int) -> int:
    """Return the count of numbers in M, C and G of n joints."""
    return joints * (joints + 1) // 2 + joints**2 + joints


def joints_of(numbers: int) -> int:
    """Return the number of joints n from the count of numbers in M, C and G."""
    return (math.isqrt(9 + 24 * numbers) - 3) // 6


def output_names(joints: int) -> tuple[str, ...]:
    """Return the names of the numbers, in order: M11, M12, ..., C11, ..., G1, ..."""
    every = range(1, joints + 1)
    between = "" if joints < 10 else ","
    return (
        *(f"M{i}{between}{j}" for i in every for j in every if i <= j),
        *(f"C{i}{between}{j}" for i in every for j in every),
        *(f"G{i}" for i in every),
    )


def places_of(entries: str, joints: int) -> Indices:
    """Return the indices of the numbers whose names begin with M, C or G."""
    names = output_names(joints)
    return np.array([k for k, name in enumerate(names) if name[0] in entries], dtype=np.int64)


def pack(M: Array, C: Array, G: Array) -> Array:
    """Return M (..., n, n), C (..., n, n) and G (..., n) as numbers (..., K)."""
    n = G.shape[-1]
    upper = np.triu_indices(n)
    return np.concatenate([M[..., upper[0], upper[1]], C.reshape(*C.shape[:-2], n * n), G], axis=-1)


def unpack(numbers: Array) -> tuple[Array, Array, Array]:
    """Return M (..., n, n), C (..., n, n) and G (..., n) from numbers (..., K).

    M is symmetric.
    """
    n = joints_of(numbers.shape[-1])
    upper, entries = np.triu_indices(n), n * (n + 1) // 2
    M = np.empty((*numbers.shape[:-1], n, n))
    M[..., upper[0], upper[1]] = M[..., upper[1], upper[0]] = numbers[..., :entries]
    C = numbers[..., entries : entries + n * n].reshape(*numbers.shape[:-1], n, n)
    return M, C, numbers[..., entries + n * n :]
