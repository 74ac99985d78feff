r"""Ridge least squares with the ridge chosen by generalized cross-validation.

The coefficients c of a design :math:`\Phi` (N, R) minimize

.. math:: \lVert y - \Phi c \rVert^2 + \lambda \lVert c \rVert^2,

and the ridge :math:`\lambda` of each target minimizes

.. math:: V(\lambda) = \frac{N \lVert (I - H) y \rVert^2}{\operatorname{tr}(I - H)^2}, \qquad
          H = \Phi (\Phi^T \Phi + \lambda I)^{-1} \Phi^T,

which is the error of leave-one-out cross-validation if all samples have the same leverage. Without
noise the coefficients are hardly shrunk; more noise shrinks them more.

Source: G. H. Golub, M. Heath and G. Wahba, "Generalized cross-validation as a method for choosing a
good ridge parameter", Technometrics 21(2), 1979.
"""

from __future__ import annotations

import numpy as np

from fuzzy2.support.checks import Array

RIDGES = np.logspace(-10.0, 2.0, 49)
"""Ridges that are tried, as shares of the largest squared singular value of the design."""


def ridge_by_cross_validation(
    design: Array, targets: Array, count: int | None = None
) -> tuple[Array, Array]:
    r"""Return the coefficients of ridge least squares, and the ridges.

    Parameters
    ----------
    design : (N, R) ndarray
        The design :math:`\Phi`.
    targets : (N, m) ndarray
        The values to be predicted, with one column for each target.
    count : int, optional
        Number N of samples, if design and targets come from a triangular factor of longer ones,
        which leads to the same coefficients. By default it is the length of the design.

    Returns
    -------
    coefficients : (R, m) ndarray
        Coefficients c of each target.
    ridges : (m,) ndarray
        Ridge :math:`\lambda` of each target.
    """
    left, sizes, right = np.linalg.svd(design, full_matrices=False)
    squares = sizes**2
    along = left.T @ targets
    # The residual outside the range of the design is summed directly, because a subtraction would
    # lose its digits.
    beyond = ((targets - left @ along) ** 2).sum(axis=0)
    tried = RIDGES * (squares[0] if squares.size and squares[0] > 0.0 else 1.0)
    left_over = tried[:, np.newaxis] / (squares + tried[:, np.newaxis])
    missed = left_over**2 @ along**2 + beyond
    freedom = (len(targets) if count is None else count) - squares.size + left_over.sum(axis=1)
    chosen = np.argmin(missed / freedom[:, np.newaxis] ** 2, axis=0)
    ridges = tried[chosen]
    coefficients = right.T @ (sizes[:, np.newaxis] * along / (squares[:, np.newaxis] + ridges))
    return coefficients, ridges
