"""The closure equations of a tree at any configuration, compiled: for what looks for one."""

from __future__ import annotations

from fuzzy2.support.compiled import compiled
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


@compiled
def closure_equations(
    tree: Indices, numbers: Array, memory: Array, q: Array, residual: Array, slope: Array
) -> None:
    """Write the residuals of all closures (m), and their derivative by dependent speeds (m · nv).

    Group by group, the derivative row by row, and only if ``slope`` has room for it.
    """
    for i in range(tree[COORDINATES]):
        memory[tree[AT_CONFIGURATION] + i] = q[i]
    place(tree, numbers, memory, tree[MEMBERS] - tree[ELEMENTS], tree[MEMBERS])
    for group in range(tree[GROUPS]):
        residual_of(tree, numbers, memory, group)
        if slope.shape[0] == 0:
            continue
        jacobian(tree, numbers, memory, group)
        g = tree[AT_GROUPS] + GROUP_INTEGERS * group
        row, rows, column = tree[g + GROUP_ROW], tree[g + GROUP_ROWS], tree[g + GROUP_COLUMN]
        for k in range(tree[g + GROUP_COLUMNS]):
            velocity = tree[tree[AT_DEPENDENT_V] + column + k]
            at = tree[AT_FACTORS] + tree[g + FACTOR_AT] + rows * k
            for i in range(rows):
                slope[tree[VELOCITIES] * (row + i) + velocity] = memory[at + i]
    for i in range(tree[ROWS]):
        residual[i] = memory[tree[AT_RESIDUAL] + i]
