"""Dynamics of the 3-PSP at many states: the closed form with vector instructions.

States are processed in blocks. For each block, a scratch array stores numbers of one kind in a
contiguous column. The loop over the states of a block calls no function and never ends early, so
the compiler can use vector instructions. Every number is computed with the same operations in the
same order as in :mod:`psp3.three_psp.closed_form`, so all bits of the results are equal. The
kernels have the names, arguments and results of those in the closed form. :func:`first_refused_row`
computes a batch on all cores, with these kernels or, if there is none for a quantity, with that of
the closed form.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from fuzzy2.support import parallel_rows
from fuzzy2.support.compiled import compiled
from psp3.checks import Array
from psp3.three_psp import closed_form
from psp3.three_psp.closed_form import _equation, _solve, equation_is_finite, is_finite
from psp3.three_psp.few_states import are_few, kernel_of_closed_form

# Fewer rows do not fill an AVX-512 vector, and the closed form's own kernels are faster.
FEWEST = 8

# States in a block. Its columns take 25 kB, which fit into the first-level cache.
BLOCK = 128
# Columns: heights (3), speeds (3), M's upper triangle by rows (6), C by rows (9), G (3), validity.
# M, C and G are in the order in which ``_equation`` returns them.
HEIGHTS, SPEEDS, M, C, G, VALID, COLUMNS = (BLOCK * column for column in (0, 3, 6, 12, 21, 24, 25))


@compiled
def _write_columns(
    heights: Array, speeds: Array, first: int, count: int, p: Array, columns: Array
) -> None:
    """Write the equations of motion of ``count`` rows from ``first`` on into the columns."""
    for r in range(count):
        i = 3 * (first + r)
        columns[HEIGHTS + r] = heights[i]
        columns[HEIGHTS + BLOCK + r] = heights[i + 1]
        columns[HEIGHTS + 2 * BLOCK + r] = heights[i + 2]
        columns[SPEEDS + r] = speeds[i]
        columns[SPEEDS + BLOCK + r] = speeds[i + 1]
        columns[SPEEDS + 2 * BLOCK + r] = speeds[i + 2]
    for r in range(count):
        (
            valid,
            columns[M + r],
            columns[M + BLOCK + r],
            columns[M + 2 * BLOCK + r],
            columns[M + 3 * BLOCK + r],
            columns[M + 4 * BLOCK + r],
            columns[M + 5 * BLOCK + r],
            columns[C + r],
            columns[C + BLOCK + r],
            columns[C + 2 * BLOCK + r],
            columns[C + 3 * BLOCK + r],
            columns[C + 4 * BLOCK + r],
            columns[C + 5 * BLOCK + r],
            columns[C + 6 * BLOCK + r],
            columns[C + 7 * BLOCK + r],
            columns[C + 8 * BLOCK + r],
            columns[G + r],
            columns[G + BLOCK + r],
            columns[G + 2 * BLOCK + r],
        ) = _equation(
            columns[HEIGHTS + r],
            columns[HEIGHTS + BLOCK + r],
            columns[HEIGHTS + 2 * BLOCK + r],
            columns[SPEEDS + r],
            columns[SPEEDS + BLOCK + r],
            columns[SPEEDS + 2 * BLOCK + r],
            p,
        )
        columns[VALID + r] = 1.0 if valid else 0.0


@compiled
def equation_of_motion(heights: Array, speeds: Array, p: Array, out: Array) -> int:
    """Write M (9), C (9) and G (3) of every row, 21 numbers each (eq. 3.2–3.4)."""
    columns = np.empty(COLUMNS)
    rows = heights.size // 3
    for first in range(0, rows, BLOCK):
        count = min(BLOCK, rows - first)
        _write_columns(heights, speeds, first, count, p, columns)
        for r in range(count):
            if columns[VALID + r] == 0.0:
                return first + r
            o = 21 * (first + r)
            m12 = columns[M + BLOCK + r]
            m13 = columns[M + 2 * BLOCK + r]
            m23 = columns[M + 4 * BLOCK + r]
            out[o], out[o + 1], out[o + 2] = columns[M + r], m12, m13
            out[o + 3], out[o + 4], out[o + 5] = m12, columns[M + 3 * BLOCK + r], m23
            out[o + 6], out[o + 7], out[o + 8] = m13, m23, columns[M + 5 * BLOCK + r]
            for j in range(9):
                out[o + 9 + j] = columns[C + j * BLOCK + r]
            for j in range(3):
                out[o + 18 + j] = columns[G + j * BLOCK + r]
            if not equation_is_finite(out, o):
                return first + r
    return -1


@compiled
def inverse_dynamics(
    heights: Array, speeds: Array, accelerations: Array, p: Array, out: Array
) -> int:
    """Write the screw forces M a + C v + G of every row (eq. 3.1)."""
    columns = np.empty(COLUMNS)
    rows = heights.size // 3
    for first in range(0, rows, BLOCK):
        count = min(BLOCK, rows - first)
        _write_columns(heights, speeds, first, count, p, columns)
        for r in range(count):
            if columns[VALID + r] == 0.0:
                return first + r
            i = 3 * (first + r)
            a1, a2, a3 = accelerations[i], accelerations[i + 1], accelerations[i + 2]
            v1, v2, v3 = speeds[i], speeds[i + 1], speeds[i + 2]
            out[i] = (
                columns[M + r] * a1
                + columns[M + BLOCK + r] * a2
                + columns[M + 2 * BLOCK + r] * a3
                + columns[C + r] * v1
                + columns[C + BLOCK + r] * v2
                + columns[C + 2 * BLOCK + r] * v3
                + columns[G + r]
            )
            out[i + 1] = (
                columns[M + BLOCK + r] * a1
                + columns[M + 3 * BLOCK + r] * a2
                + columns[M + 4 * BLOCK + r] * a3
                + columns[C + 3 * BLOCK + r] * v1
                + columns[C + 4 * BLOCK + r] * v2
                + columns[C + 5 * BLOCK + r] * v3
                + columns[G + BLOCK + r]
            )
            out[i + 2] = (
                columns[M + 2 * BLOCK + r] * a1
                + columns[M + 4 * BLOCK + r] * a2
                + columns[M + 5 * BLOCK + r] * a3
                + columns[C + 6 * BLOCK + r] * v1
                + columns[C + 7 * BLOCK + r] * v2
                + columns[C + 8 * BLOCK + r] * v3
                + columns[G + 2 * BLOCK + r]
            )
            if not is_finite(out, i):
                return first + r
    return -1


@compiled
def forward_dynamics(heights: Array, speeds: Array, forces: Array, p: Array, out: Array) -> int:
    """Write the accelerations M⁻¹ (tau − C v − G) of every row."""
    columns = np.empty(COLUMNS)
    rows = heights.size // 3
    for first in range(0, rows, BLOCK):
        count = min(BLOCK, rows - first)
        _write_columns(heights, speeds, first, count, p, columns)
        # The solution replaces the heights, which are no longer needed.
        for r in range(count):
            i = 3 * (first + r)
            v1, v2, v3 = (
                columns[SPEEDS + r],
                columns[SPEEDS + BLOCK + r],
                columns[SPEEDS + 2 * BLOCK + r],
            )
            (
                columns[HEIGHTS + r],
                columns[HEIGHTS + BLOCK + r],
                columns[HEIGHTS + 2 * BLOCK + r],
            ) = _solve(
                columns[M + r],
                columns[M + BLOCK + r],
                columns[M + 2 * BLOCK + r],
                columns[M + 3 * BLOCK + r],
                columns[M + 4 * BLOCK + r],
                columns[M + 5 * BLOCK + r],
                forces[i]
                - columns[C + r] * v1
                - columns[C + BLOCK + r] * v2
                - columns[C + 2 * BLOCK + r] * v3
                - columns[G + r],
                forces[i + 1]
                - columns[C + 3 * BLOCK + r] * v1
                - columns[C + 4 * BLOCK + r] * v2
                - columns[C + 5 * BLOCK + r] * v3
                - columns[G + BLOCK + r],
                forces[i + 2]
                - columns[C + 6 * BLOCK + r] * v1
                - columns[C + 7 * BLOCK + r] * v2
                - columns[C + 8 * BLOCK + r] * v3
                - columns[G + 2 * BLOCK + r],
            )
        for r in range(count):
            i = 3 * (first + r)
            x1, x2, x3 = (
                columns[HEIGHTS + r],
                columns[HEIGHTS + BLOCK + r],
                columns[HEIGHTS + 2 * BLOCK + r],
            )
            if columns[VALID + r] == 0.0 or not math.isfinite(x1 + x2 + x3):
                return first + r
            out[i], out[i + 1], out[i + 2] = x1, x2, x3
    return -1


# Kernel of each quantity, and the number of rows that it computes in about 50 µs.
_KERNELS: dict[str, tuple[Callable[..., int], int]] = {
    "forward_kinematics": (closed_form.forward_kinematics, 2000),
    "configuration": (closed_form.configuration, 400),
    "inverse_kinematics_tip": (closed_form.inverse_kinematics_tip, 100),
    "tip_jacobian": (closed_form.tip_jacobian, 1000),
    "tip_rates": (closed_form.tip_rates, 800),
    "energies": (closed_form.energies, 700),
    "equation_of_motion": (equation_of_motion, 1500),
    "inverse_dynamics": (inverse_dynamics, 1500),
    "forward_dynamics": (forward_dynamics, 1000),
}


def first_refused_row(name: str, inputs: Sequence[Array], p: Array, *outs: Array) -> int:
    """Compute a quantity of the closed form at all rows; return the first that is refused, or -1.

    Parameters
    ----------
    name : str
        Name of the kernel in :mod:`psp3.three_psp.closed_form`.
    inputs : sequence of (..., 3) ndarray
        Its arguments before the parameters, contiguous and of one shape.
    p : ndarray
        The robot's parameters.
    *outs : (..., n) ndarray
        Arrays for its results, contiguous, with the leading dimensions of the inputs.
    """
    rows = inputs[0].size // 3
    before, after = [a.reshape(-1) for a in inputs], [a.reshape(-1) for a in outs]
    if rows < FEWEST or are_few(rows):
        row: int = kernel_of_closed_form(name)(*before, p, *after)
        return row
    kernel, grain = _KERNELS[name]
    widths = [a.size // rows for a in after]

    def part(first: int, last: int) -> int:
        return kernel(
            *[a[3 * first : 3 * last] for a in before],
            p,
            *[a[n * first : n * last] for a, n in zip(after, widths, strict=True)],
        )

    return parallel_rows.first_refused_row(part, rows, grain)
