"""Regressors of scikit-learn: what is done to inputs and outputs, and that they learn."""

from __future__ import annotations

import sys

import numpy as np
import pytest

from psp3.benchmark.regressors import (
    Standardized,
    gaussian_process,
    need_scikit_learn,
    neural_network,
    ridge,
)
from psp3.checks import Array
from psp3.errors import MissingPackage

RNG = np.random.default_rng(3)
X = RNG.uniform(-1.0, 1.0, (120, 2)) * [1e-3, 1e3] + [5.0, -7.0]
STANDARD = (X - X.mean(axis=0)) / X.std(axis=0)
Y = np.stack([STANDARD[:, 0] * STANDARD[:, 1], 1e4 + STANDARD[:, 0], 0.0 * X[:, 0] + 3.0], axis=1)


class Seen:
    """A regressor that remembers what it was given, and returns its inputs and zeros."""

    def fit(self, X: Array, Y: Array) -> None:
        """Remember."""
        self.X, self.Y = X, Y

    def predict(self, X: Array) -> Array:
        """Return the first two columns and a zero."""
        self.asked = X
        return np.hstack([X, np.zeros((len(X), 1))])


def test_inputs_and_outputs_have_mean_0_and_variance_1_and_inputs_stay_in_range() -> None:
    inner = Seen()
    wrapped = Standardized(inner).fit(X, Y)
    for values, deviations in ((inner.X, [1.0, 1.0]), (inner.Y, [1.0, 1.0, 0.0])):
        np.testing.assert_allclose(values.mean(axis=0), 0.0, atol=1e-9)
        np.testing.assert_allclose(values.std(axis=0), deviations, atol=1e-9)
    wrapped.predict(X.max(axis=0, keepdims=True) + np.array([1.0, 1e6]))
    np.testing.assert_allclose(inner.asked[0], inner.X.max(axis=0), rtol=1e-12)


def test_an_output_that_does_not_change_is_said_as_it_is() -> None:
    assert Standardized(Seen()).fit(X, Y).predict(X[:4])[:, 2].tolist() == [3.0] * 4


# Optimizers that stop early warn, and trials pass over that: what was found is what counts.
@pytest.mark.filterwarnings("ignore:.*:sklearn.exceptions.ConvergenceWarning")
@pytest.mark.slow
@pytest.mark.parametrize("make", [gaussian_process, neural_network, ridge])
def test_each_learns_a_product_of_its_inputs(make) -> None:  # type: ignore[no-untyped-def]
    """Of samples not learned from, to a tenth of what they vary by; a plane leaves all of it."""
    model = make(np.random.default_rng(0)).fit(X[:100], Y[:100, :2])
    error = model.predict(X[100:]) - Y[100:, :2]
    assert (error.std(axis=0) < 0.1 * Y[:, :2].std(axis=0)).all()


def test_without_scikit_learn_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "sklearn", None)
    with pytest.raises(MissingPackage, match=r"psp3\[benchmark\]"):
        need_scikit_learn()
