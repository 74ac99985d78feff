"""Solve for the un-actuated joints by rank.

Square, redundant and singular constraint Jacobians are told apart.
"""

from __future__ import annotations

import numpy as np

from psp3.checks import Array
from psp3.errors import SingularConfiguration

RANK_TOLERANCE = 1e-9
"""Singular values below this share of the largest one count as zero."""


def dependent_solver(jacobian: Array) -> Array:
    r"""Return :math:`(\Phi^u)^{-1}`, or the pseudo-inverse where the closures are redundant.

    Parameters
    ----------
    jacobian : (m, u) ndarray
        The columns :math:`\Phi^u` of a constraint Jacobian that belong to the un-actuated joints
        (eq. 3.21).

    Returns
    -------
    (u, m) ndarray
        The matrix that solves :math:`\Phi^u x = y` for every y that has a solution.

    Raises
    ------
    SingularConfiguration
        If the columns are not independent, so that the actuated joints do not determine the others.
    """
    columns = jacobian.shape[1]
    if columns == 0:
        return np.zeros((0, jacobian.shape[0]))
    if jacobian.shape[0] == 0:
        raise SingularConfiguration(0, columns, np.inf)
    left, values, right = np.linalg.svd(jacobian, full_matrices=False)
    rank = int(np.count_nonzero(values > RANK_TOLERANCE * values[0]))
    if rank < columns:
        condition = (
            values[0] / values[-1] if values.size == columns and values[-1] > 0.0 else np.inf
        )
        raise SingularConfiguration(rank, columns, float(condition))
    inverse: Array = (right.T / values) @ left.T
    return inverse
