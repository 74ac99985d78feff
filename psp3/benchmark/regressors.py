"""Regressors of scikit-learn as entries: a Gaussian process, a neural network, ridge.

None is given the noise level: each estimates it from the samples, by likelihood or with held-out
samples. Inputs and outputs are standardized to mean 0 and variance 1, and inputs are clamped to the
trained range.
"""

from __future__ import annotations

from typing import Any, Self

import numpy as np

from psp3.checks import Array
from psp3.errors import MissingPackage
from psp3.study.entries import scale_of

PENALTIES = tuple(10.0 ** np.arange(-6.0, 4.0))
"""Candidate penalties of ridge."""

DECAYS = (1e-3, 1e-1, 1e1)
"""Candidate weight decays of the neural network."""


class Standardized:
    """A regressor on standardized inputs and outputs, with inputs clamped to their range.

    Parameters
    ----------
    regressor : regressor
        Anything with ``fit`` and ``predict``.
    """

    def __init__(self, regressor: Any) -> None:
        self.regressor = regressor

    def fit(self, X: Array, Y: Array) -> Self:
        """Learn from inputs (N, p) and outputs (N, m)."""
        self._low, self._high = X.min(axis=0), X.max(axis=0)
        self._x, self._y = scale_of(X), scale_of(Y)
        self.regressor.fit((X - self._x[0]) / self._x[1], (Y - self._y[0]) / self._y[1])
        return self

    def predict(self, X: Array) -> Array:
        """Return outputs (K, m) at inputs (K, p)."""
        inputs = (np.clip(X, self._low, self._high) - self._x[0]) / self._x[1]
        return np.asarray(self.regressor.predict(inputs) * self._y[1] + self._y[0])


def gaussian_process(rng: np.random.Generator) -> Standardized:
    """Return a Gaussian process with one width and one noise, both of greatest likelihood."""
    need_scikit_learn()
    from sklearn.gaussian_process import GaussianProcessRegressor
    from sklearn.gaussian_process.kernels import RBF, ConstantKernel, WhiteKernel

    kernel = ConstantKernel(1.0) * RBF(2.0) + WhiteKernel(0.1, (1e-8, 1e1))
    return Standardized(GaussianProcessRegressor(kernel))


def neural_network(rng: np.random.Generator) -> Standardized:
    """Return a network of 32 hidden units; a held-out third of samples sets its weight decay."""
    need_scikit_learn()
    from sklearn.model_selection import GridSearchCV
    from sklearn.neural_network import MLPRegressor

    network = MLPRegressor(
        hidden_layer_sizes=(32,),
        solver="lbfgs",
        max_iter=300,
        random_state=int(rng.integers(2**31)),
    )
    return Standardized(GridSearchCV(network, {"alpha": DECAYS}, cv=3))


def ridge(rng: np.random.Generator) -> Standardized:
    """Return ridge regression on all products of two inputs; leave-one-out sets the penalty."""
    need_scikit_learn()
    from sklearn.linear_model import RidgeCV
    from sklearn.pipeline import make_pipeline
    from sklearn.preprocessing import PolynomialFeatures

    penalized = RidgeCV(PENALTIES, alpha_per_target=True)
    return Standardized(make_pipeline(PolynomialFeatures(2), penalized))


def need_scikit_learn() -> None:
    """Raise :class:`MissingPackage` if scikit-learn cannot be imported."""
    try:
        import sklearn  # noqa: F401
    except ImportError as error:
        raise MissingPackage("scikit-learn", "benchmark", error) from error
