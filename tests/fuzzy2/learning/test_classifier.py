"""The classifier of few rules: iris, its gradient and scikit-learn's conventions."""

from __future__ import annotations

import pickle
from typing import Any

import numpy as np
import pytest
from scipy.optimize import check_grad

from fuzzy2 import FuzzyClassifier
from fuzzy2.errors import InvalidValue, NotFitted
from fuzzy2.learning.classifier import _Likelihood


def clouds(count: int = 90) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(4)
    codes = rng.integers(0, 3, count)
    middles = np.array([[0.0, 0.0, 5.0], [2.0, 0.0, 5.0], [0.0, 2.0, 5.0]])
    return middles[codes] + 0.7 * rng.normal(size=(count, 3)), np.array(["a", "b", "c"])[codes]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "least", "rules"), [("iris", 0.94, 6), ("wine", 0.96, 6), ("breast_cancer", 0.94, 4)]
)
def test_classes_are_told_apart_as_well_as_by_a_forest(name: str, least: float, rules: int) -> None:
    """In ten folds within 2 points of a random forest, by rules of which there are few."""
    datasets = pytest.importorskip("sklearn.datasets")
    ensemble = pytest.importorskip("sklearn.ensemble")
    selection = pytest.importorskip("sklearn.model_selection")
    X, y = getattr(datasets, f"load_{name}")(return_X_y=True)
    folds = selection.StratifiedKFold(10, shuffle=True, random_state=0)
    ours, forest = (
        selection.cross_val_score(model, X, y, cv=folds).mean()
        for model in (FuzzyClassifier(), ensemble.RandomForestClassifier(random_state=0))
    )
    assert ours >= forest - 0.02
    assert ours >= least
    model = FuzzyClassifier().fit(X, y)
    assert len(model.rules_in_words()) == len(model.system_.rules) == rules


def test_gradient_is_that_of_finite_differences() -> None:
    """Scipy's one-sided differences are good for 1e-6 of numbers of order 1, in 90 parameters."""
    X, y = clouds(40)
    codes = np.unique(y, return_inverse=True)[1]
    weights = np.random.default_rng(0).uniform(0.5, 2.0, 40)
    problem = _Likelihood(X - [0.0, 0.0, 5.0], codes, weights, 2, 3.0, np.random.default_rng(0))
    parameters = problem.start + 0.1 * np.random.default_rng(1).normal(size=problem.start.size)
    error = check_grad(
        lambda at: problem(at)[0], lambda at: problem(at)[1], parameters, epsilon=1e-7
    )
    assert error < 1e-5
    assert np.linalg.norm(problem(parameters)[1]) > 0.1


def test_probabilities_are_the_outputs_of_the_system() -> None:
    """1e-12 is rounding; far away, where all firing underflows, they still add up to 1."""
    X, y = clouds()
    model = FuzzyClassifier().fit(X, y)
    likely = model.predict_proba(X)
    np.testing.assert_allclose(likely, model.system_(X), rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(likely.sum(axis=1), 1.0, rtol=1e-12)
    np.testing.assert_array_equal(model.predict(X), model.classes_[likely.argmax(axis=1)])
    assert model.score(X, y) == np.mean(model.predict(X) == y)
    assert model.score(X, y) > 0.85
    np.testing.assert_allclose(model.predict_proba([[1e6, 0.0, 0.0]]).sum(), 1.0, rtol=1e-12)
    again = pickle.loads(pickle.dumps(model))
    np.testing.assert_array_equal(again.predict_proba(X), likely)


def test_rules_say_what_they_ask_for_and_what_they_conclude() -> None:
    """The third input tells nothing apart, and every class has a rule of its own."""
    X, y = clouds()
    lines = FuzzyClassifier(n_rules=1).fit(X, y).rules_in_words()
    assert len(lines) == 3
    for line, label in zip(lines, "abc", strict=True):
        assert line.startswith("IF x1 is ")
        assert f"THEN {label} 0." in line
        assert "#" not in line
    assert "x1 is high" in lines[1]
    assert "x2 is high" in lines[2]


def test_weights_are_repetitions() -> None:
    """L-BFGS stops where the gradient is 1e-5; the probabilities differ by no more than 1e-3."""
    X, y = clouds()
    weights = np.random.default_rng(1).integers(0, 4, len(X))
    weighted = FuzzyClassifier().fit(X, y, sample_weight=weights)
    repeated = FuzzyClassifier().fit(np.repeat(X, weights, axis=0), np.repeat(y, weights))
    np.testing.assert_allclose(
        weighted.predict_proba(X), repeated.predict_proba(X), rtol=0.0, atol=1e-3
    )


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:Estimator FuzzyClassifier does not inherit:UserWarning")
def test_scikit_learn_finds_nothing_to_complain_about() -> None:
    checks = pytest.importorskip("sklearn.utils.estimator_checks")
    results = checks.check_estimator(FuzzyClassifier(), on_fail=None, on_skip=None)
    failed = {
        result["check_name"]: result["exception"]
        for result in results
        if result["status"] == "failed"
    }
    assert not failed
    assert sum(result["status"] == "passed" for result in results) >= 55


@pytest.mark.parametrize(
    ("options", "labels", "words"),
    [
        ({"n_rules": 0}, [0, 1, 1], "n_rules"),
        ({"ridge": 0.0}, [0, 1, 1], "ridge"),
        ({"most_epochs": -1}, [0, 1, 1], "most_epochs"),
        ({}, [1, 1, 1], "more than one class"),
        ({}, [0.5, 1.5, 2.5], "continuous"),
        ({}, [0, 1], "a label for each sample"),
        ({}, None, "labels"),
    ],
)
def test_what_cannot_be_meant_is_refused(options: dict[str, Any], labels: Any, words: str) -> None:
    with pytest.raises(InvalidValue, match=words):
        FuzzyClassifier(**options).fit([[0.0], [1.0], [2.0]], labels)


def test_asking_too_early_is_refused() -> None:
    with pytest.raises(NotFitted):
        FuzzyClassifier().predict([[1.0]])
