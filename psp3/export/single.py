"""A robot's numbers in single precision, with tolerances that can be met.

In double precision, tolerances of residuals and steps are a few rounding errors of 2e-16, which
numbers of seven digits never meet. Such tolerances become as many of the larger rounding errors.
Tolerances that distinguish rounding from a mistake, or detect a singular matrix, leave three digits
instead of seven.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from fuzzy2.errors import NotExportable
from psp3.checks import Array
from psp3.multibody.flatten import CLOSURE_TOLERANCE
from psp3.multibody.tree import (
    AT_FACTORS,
    AT_GROUPS,
    AT_TOLERANCES,
    FACTOR_AT,
    GROUP_COLUMNS,
    GROUP_INTEGERS,
    GROUP_NUMBERS,
    GROUP_ROWS,
    GROUPS,
)

CLOSED_TO = 1e-7
"""Residual at which loops count as closed, per meter of robot [m, rad]: one rounding error. With a
few rounding errors, as in double precision, joints of links of centimeters would keep only four
digits.
"""

LARGEST_RESIDUAL = 1e-5
"""Residual that is accepted if Newton's method makes no more progress, per meter of robot [m, rad].
"""

CONSTANTS: dict[str, float] = {
    "ALL_OF_THE_WAY": 1.0 - 1e-6,
    "EARLY": 1e-2,
    "FIRST_DIFFERENCE": 5e-3,
    "LEFT_OVER": 1e-4,
    "ORTHOGONAL": 1e-6,
    "RANK": 1e-4,
    "SECOND_DIFFERENCE": 2e-2,
    "SMALLEST_CORRECTION": 1e-5,
    "SMALLEST_PIVOT": 1e-4,
    "SMALLEST_STEP": 1e-4,
    "STILL": 1e-5,
}
"""Constants of the kernels' modules that differ in single precision. Steps of finite differences
are slightly more than the third and the fourth root of a rounding error; the derivatives keep five
and three digits.
"""


def numbers_of(table: Any, title: str) -> Array:
    """Return a robot's numbers with the tolerances of single precision.

    Parameters
    ----------
    table : Tables or DrivenTables
        The robot, in its reference pose.
    title : str
        Its name in an error message.

    Raises
    ------
    NotExportable
        If the equations of a loop are so nearly dependent in the reference pose that seven digits
        do not suffice.
    """
    tree, numbers = table.tree, np.array(table.numbers)
    for group in range(int(tree[GROUPS])):
        pivot = _smallest_pivot(table, group)
        if pivot <= CONSTANTS["SMALLEST_PIVOT"]:
            raise NotExportable(
                f"{title} in single precision",
                f"the smallest pivot of its loops is {pivot:.1g} of the largest in the reference "
                f"pose, and {CONSTANTS['SMALLEST_PIVOT']:g} counts as none",
                'precision="double"',
            )
        at = int(tree[AT_TOLERANCES]) + GROUP_NUMBERS * group
        size = numbers[at + 1] / CLOSURE_TOLERANCE
        numbers[at], numbers[at + 1] = LARGEST_RESIDUAL * size, CLOSED_TO * size
    return numbers


def _smallest_pivot(table: Any, group: int) -> float:
    """Return the smallest pivot of a group in the reference pose, as a share of the largest."""
    tree, g = table.tree, int(table.tree[AT_GROUPS]) + GROUP_INTEGERS * group
    rows, columns = int(tree[g + GROUP_ROWS]), int(tree[g + GROUP_COLUMNS])
    at = int(tree[AT_FACTORS]) + int(tree[g + FACTOR_AT])
    pivots = np.abs(table.memory[at + (rows + 1) * np.arange(columns)])
    return float(pivots.min(initial=np.inf) / pivots.max(initial=0.0)) if columns else 1.0
