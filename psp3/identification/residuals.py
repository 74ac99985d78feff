"""Test whether the residuals of a fit are independent from sample to sample."""

from __future__ import annotations

import numpy as np

from psp3.checks import Array

LEAST_FREEDOM = 5
"""With fewer degrees of freedom, residuals carry no information about their correlation."""


def lag_one_correlation(residuals: Array) -> Array:
    """Return the correlation of residuals with those of the preceding sample, by column.

    Parameters
    ----------
    residuals : (N, n) ndarray
        In time order; their mean is assumed to be zero.

    Returns
    -------
    (n,) ndarray
        The correlations; 0 if all residuals are zero.
    """
    squares = np.sum(residuals**2, axis=0)
    products = np.sum(residuals[1:] * residuals[:-1], axis=0)
    correlations: Array = products / np.where(squares > 0.0, squares, 1.0)
    return correlations


def deviation_from_independence(residuals: Array, regressor: Array, shared: Array) -> float:
    r"""Return how far the correlation of neighboring residuals exceeds that of fitted noise.

    .. math:: r = \frac{e^T A e}{e^T e}, \qquad e \sim N(0, S), \quad
              S = \sigma^2 P + P K K^T P, \quad P = I - Q Q^T

    with Q an orthonormal basis of the regressor's columns, K the effects of errors that all samples
    share, and A a matrix with one half next to its diagonal, so that r is the correlation at lag
    one. Its moments are

    .. math:: \operatorname{E} r \approx \rho = \frac{\operatorname{tr} A S}{\operatorname{tr} S},
              \qquad \operatorname{var} r \approx 2\, \frac{\operatorname{tr} (A S)^2
              - 2 \rho \operatorname{tr} A S^2 + \rho^2 \operatorname{tr} S^2}
              {(\operatorname{tr} S)^2 + 2 \operatorname{tr} S^2},

    which are exact if K is zero. Otherwise they are first-order approximations, for which r - E r
    tends to be too small.

    Parameters
    ----------
    residuals : (N,) ndarray
        In time order. The regressor is projected out first, so components of it that a weighted fit
        has left do not matter.
    regressor : (N, k) ndarray
        The fitted regressor.
    shared : (N, q) ndarray
        K, the effects of q independent errors of standard deviation 1, such as those of the fitted
        motion: noise that is correlated without a flaw in the model.

    Returns
    -------
    float
        (r - E r) / sqrt(var r), which has nearly a standard normal distribution if the noise is
        independent; 0 if fewer than five degrees of freedom remain.

    Notes
    -----
    J. Durbin and G. S. Watson, Testing for serial correlation in least squares regression I,
    Biometrika, 37:409-428, 1950, for K = 0.
    """
    basis = _basis(regressor)
    count, taken = basis.shape
    freedom = count - taken
    if freedom < LEAST_FREEDOM:
        return 0.0
    remaining = residuals - basis @ (basis.T @ residuals)
    common = shared - basis @ (basis.T @ shared)
    beside_basis, beside_common = _beside(basis), _beside(common)
    inner, outer, gram = basis.T @ beside_basis, common.T @ beside_common, common.T @ common
    # The noise of a sample is best estimated outside the space of shared errors. If they fill the
    # space, it is estimated from the part that they do not explain on average.
    of_shared = _basis(common)
    alone = remaining - of_shared @ (of_shared.T @ remaining)
    free = freedom - of_shared.shape[1]
    noise = (
        float(alone @ alone) / free
        if free >= LEAST_FREEDOM
        else max(float(remaining @ remaining - np.trace(gram)) / freedom, 0.0)
    )
    # tr A² = (N - 1) / 2, since A holds 2 (N - 1) entries of one half.
    trace_of_square = (
        noise**2 * (0.5 * (count - 1) - 2.0 * np.sum(beside_basis**2) + np.sum(inner**2))
        + 2.0 * noise * (np.sum(beside_common**2) - np.sum((basis.T @ beside_common) ** 2))
        + np.sum(outer**2)
    )
    trace = -noise * np.trace(inner) + np.trace(outer)
    mixed = -(noise**2) * np.trace(inner) + 2.0 * noise * np.trace(outer) + np.sum(gram * outer)
    size = noise * freedom + np.trace(gram)
    square = noise**2 * freedom + 2.0 * noise * np.trace(gram) + np.sum(gram**2)
    expected = trace / size
    variance = 2.0 * (trace_of_square - 2.0 * expected * mixed + expected**2 * square)
    variance /= size**2 + 2.0 * square
    correlation = lag_one_correlation(remaining[:, np.newaxis])[0]
    return float((correlation - expected) / np.sqrt(variance))


def _basis(columns: Array) -> Array:
    """Return an orthonormal basis of the span of columns, independent of their units."""
    lengths = np.linalg.norm(columns, axis=0)
    left, sizes, _ = np.linalg.svd(
        columns / np.where(lengths > 0.0, lengths, 1.0), full_matrices=False
    )
    return left[:, sizes > 1e-10]


def _beside(columns: Array) -> Array:
    """Return A times columns: half the sum of the rows before and after each row."""
    result = np.zeros_like(columns)
    result[1:] += 0.5 * columns[:-1]
    result[:-1] += 0.5 * columns[1:]
    return result
