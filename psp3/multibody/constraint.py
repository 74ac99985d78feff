"""Compiled closure equations of a tree at any configuration, for the search of a closed one."""

from __future__ import annotations

from fuzzy2.support.compiled import scalar
from psp3.checks import Array, Indices
from psp3.multibody.loops import jacobian, residual_of
from psp3.multibody.placement import place
from psp3.multibody.tree import (
    AT_CONFIGURATION,
    AT_DEPENDENT_V,
    AT_FACTORS,
    AT_GROUPS,
    AT_RESIDUAL,
    COORDINATES,
    ELEMENTS,
    FACTOR_AT,
    GROUP_COLUMN,
    GROUP_COLUMNS,
    GROUP_INTEGERS,
    GROUP_ROW,
    GROUP_ROWS,
    GROUPS,
    MEMBERS,
    ROWS,
    VELOCITIES,
)


@scalar
def closure_equations(tree: Indices, numbers: Array, memory: Array, q: Array, out: Array) -> None:
    """Write the residuals of all closures (m), and their derivative by dependent speeds (m · nv).

    They are written group by group, the derivative row by row and only if ``out`` has room for it.
    """
    rows_of_all = tree[ROWS]
    for i in range(rows_of_all, out.shape[0]):
        out[i] = 0.0
    for i in range(tree[COORDINATES]):
        memory[tree[AT_CONFIGURATION] + i] = q[i]
    place(tree, numbers, memory, tree[MEMBERS] - tree[ELEMENTS], tree[MEMBERS])
    for group in range(tree[GROUPS]):
        residual_of(tree, numbers, memory, group)
        if out.shape[0] == rows_of_all:
            continue
        jacobian(tree, numbers, memory, group)
        g = tree[AT_GROUPS] + GROUP_INTEGERS * group
        row, rows, column = tree[g + GROUP_ROW], tree[g + GROUP_ROWS], tree[g + GROUP_COLUMN]
        for k in range(tree[g + GROUP_COLUMNS]):
            velocity = tree[tree[AT_DEPENDENT_V] + column + k]
            at = tree[AT_FACTORS] + tree[g + FACTOR_AT] + rows * k
            for i in range(rows):
                out[rows_of_all + tree[VELOCITIES] * (row + i) + velocity] = memory[at + i]
    for i in range(rows_of_all):
        out[i] = memory[tree[AT_RESIDUAL] + i]
