"""Ranks, null spaces, and the inverse for the un-actuated joints.

A matrix of computed numbers is never exactly singular, so each rank needs a tolerance below which a
singular value counts as zero. All tolerances are in this module, with their reasons. The core uses
pivots instead, see :mod:`psp3.multibody.least_squares`.
"""

from __future__ import annotations

import numpy as np

from psp3.checks import Array
from psp3.errors import SingularConfiguration

RANK_TOLERANCE = 1e-9
"""Singular values up to this share of the largest one count as zero. Rounding errors are about
1e-15 of it, and a condition number above 1e9 would leave too few correct digits.
"""

ASSEMBLED_RANK_TOLERANCE = 1e-7
"""As :data:`RANK_TOLERANCE`, for configurations that are only assembled. Their loops are open by up
to 1e-9, and redundant closure equations differ by as much.
"""


def numerical_rank(values: Array, tolerance: float = RANK_TOLERANCE) -> int:
    """Return how many singular values are above a share of the largest one.

    Parameters
    ----------
    values : (k,) ndarray
        Singular values.
    tolerance : float
        The share.

    Returns
    -------
    int
    """
    return int(np.count_nonzero(values > tolerance * values.max(initial=0.0)))


def null_space(matrix: Array, tolerance: float, size: float | None = None) -> Array:
    """Return an orthonormal basis of the directions in which a matrix is small.

    Parameters
    ----------
    matrix : (m, n) ndarray
        The matrix; if it has no rows, the basis has all directions.
    tolerance : float
        Singular values up to this share of ``size`` count as zero.
    size : float, optional
        The size with which they are compared; by default the largest singular value.

    Returns
    -------
    (n, k) ndarray
        The basis, in its columns.
    """
    if not matrix.size:
        return np.eye(matrix.shape[1])
    _, values, right = np.linalg.svd(matrix)
    limit = tolerance * (values[0] if size is None else size)
    return np.ascontiguousarray(right[np.count_nonzero(values > limit) :].T)


def dependent_solver(jacobian: Array) -> Array:
    r"""Return :math:`(\Phi^u)^{-1}`, or the pseudo-inverse if the closures are redundant.

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
    certain = _certain_inverse(jacobian)
    if certain is not None:
        return certain
    left, values, right = np.linalg.svd(jacobian, full_matrices=False)
    rank = numerical_rank(values)
    if rank < columns:
        condition = (
            values[0] / values[-1] if values.size == columns and values[-1] > 0.0 else np.inf
        )
        raise SingularConfiguration(rank, columns, float(condition))
    inverse: Array = (right.T / values) @ left.T
    return inverse


def _certain_inverse(matrix: Array) -> Array | None:
    """Return the (pseudo-)inverse if the columns are certainly independent, else None.

    This takes a third of the time of singular values, which decide the uncertain cases. The
    condition number is at most the product of the largest entries of the matrix and of its inverse,
    times the square of their width.
    """
    rows, columns = matrix.shape
    if rows < columns:
        return None
    left, square = (None, matrix) if rows == columns else np.linalg.qr(matrix)
    try:
        inverse: Array = np.linalg.inv(square)
    except np.linalg.LinAlgError:
        return None
    sizes = float(np.abs(square).max()) * float(np.abs(inverse).max())
    if not columns**2 * sizes * RANK_TOLERANCE < 1.0:
        return None
    return inverse if left is None else inverse @ left.T
