r"""Ridge least squares whose ridge is chosen by generalized cross-validation.

The coefficients c of a design :math:`\Phi` (N, R) minimize

.. math:: \lVert y - \Phi c \rVert^2 + \lambda \lVert c \rVert^2,

and the ridge :math:`\lambda` of each target minimizes

.. math:: V(\lambda) = \frac{N \lVert (I - H) y \rVert^2}{\operatorname{tr}(I - H)^2}, \qquad
          H = \Phi (\Phi^T \Phi + \lambda I)^{-1} \Phi^T,

what leaving out one sample after the other would miss, were all of the same leverage. Without noise
next to nothing is shrunk; the more noise, the more is.

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
        :math:`\Phi`.
    targets : (N, m) ndarray
        What is to be said, a column for each target.
    count : int, optional
        N, where design and targets are those of a triangular factor of longer ones, which have the
        same coefficients; their own length by default.

    Returns
    -------
    coefficients : (R, m) ndarray
        c of each target.
    ridges : (m,) ndarray
        :math:`\lambda` of each.
    """
    left, sizes, right = np.linalg.svd(design, full_matrices=False)
    squares = sizes**2
    along = left.T @ targets
    # What no coefficients can say, summed up rather than subtracted, which keeps its digits.
    beyond = ((targets - left @ along) ** 2).sum(axis=0)
    tried = RIDGES * (squares[0] if squares.size and squares[0] > 0.0 else 1.0)
    left_over = tried[:, np.newaxis] / (squares + tried[:, np.newaxis])
    missed = left_over**2 @ along**2 + beyond
    freedom = (len(targets) if count is None else count) - squares.size + left_over.sum(axis=1)
    chosen = np.argmin(missed / freedom[:, np.newaxis] ** 2, axis=0)
    ridges = tried[chosen]
    coefficients = right.T @ (sizes[:, np.newaxis] * along / (squares[:, np.newaxis] + ridges))
    return coefficients, ridges
