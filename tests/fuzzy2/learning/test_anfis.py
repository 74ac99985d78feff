"""ANFIS: the published benchmark, its conventions and what it refuses."""

from __future__ import annotations

import dataclasses
import functools
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fuzzy2 import ANFIS, lagged
from fuzzy2.errors import Fuzzy2Error, InvalidValue, UnknownName
from fuzzy2.learning.fine_tuning import fine_tune
from fuzzy2.systems import IntervalType2System, Linear, Type1System
from tests import examples
from tests.fuzzy2.learning.mackey_glass import mackey_glass, ndei, published_series


@functools.cache
def benchmark() -> tuple[np.ndarray, np.ndarray]:
    """Return the 1000 samples of Jang's paper, x(118) to x(1117) being the present values."""
    return lagged(mackey_glass(1123)[100:], [18, 12, 6, 0], horizon=6)


def surface(count: int = 150, outputs: int = 1) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(5)
    X = rng.uniform([-1.0, 10.0], [1.0, 30.0], (count, 2))
    first = np.sin(3.0 * X[:, 0]) * (X[:, 1] - 20.0)
    return X, first if outputs == 1 else np.column_stack([first, X[:, 0] ** 2])


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 6])
def test_mackey_glass_with_16_rules(seed: int) -> None:
    """A test error of 0.011, and of type-2 1.2 times that with a footprint of 5 % of the range.

    Hybrid learning that has converged is known to give 0.0103 on this series, which is noise-free.
    With seed 6 learning from the type-1 system alone rested at 1.23 times its error.
    """
    X, y = benchmark()
    assert X.shape == (1000, 4)
    errors = []
    for kind in ("t1", "it2"):
        rng = np.random.default_rng(seed)
        model = ANFIS(kind=kind, rng=rng).fit(X[:500], y[:500])
        assert len(model.system_.rules) == 16
        errors.append(ndei(model.predict(X[500:]), y[500:]))
        if kind == "it2":
            for terms, width in zip(model.system_.inputs, np.ptp(X[:500], axis=0), strict=True):
                for term in terms:
                    assert term.mean[1] - term.mean[0] == pytest.approx(0.05 * width, rel=1e-9)
    assert errors[0] <= 0.011
    assert errors[1] <= 1.2 * errors[0]


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["t1", "it2"])
def test_mackey_glass_as_jang_published_it(kind: str) -> None:
    """His series, 500 samples to learn from and 500 to test with, 16 rules: he reports 0.007."""
    X, y = lagged(published_series(1123)[100:], [18, 12, 6, 0], horizon=6)
    model = ANFIS(kind=kind).fit(X[:500], y[:500])
    assert len(model.system_.rules) == 16
    assert ndei(model.predict(X[500:]), y[500:]) <= 0.007


@pytest.mark.slow
def test_mackey_glass_with_a_ridge_that_blocks_of_the_training_half_chose() -> None:
    """Of 36 settings the best over five blocks of 100 samples, each left out in its turn.

    The rule was written down before the test half was looked at, once; the error over the blocks
    is 0.0095.
    """
    X, y = benchmark()
    model = ANFIS(ridge=1e-7, validation_share=0.0, most_epochs=30).fit(X[:500], y[:500])
    assert ndei(model.predict(X[500:]), y[500:]) <= 0.011


@pytest.mark.parametrize("kind", ["t1", "it2"])
@pytest.mark.parametrize("partition", ["grid", "clusters"])
def test_a_plane_is_learned_exactly_by_any_rules(kind: str, partition: str) -> None:
    """Linear consequents that are all the same; 1e-4 of the outputs' deviation is the ridge."""
    X, _ = surface()
    y = np.column_stack([3.0 - 2.0 * X[:, 0] + 0.1 * X[:, 1], X[:, 0]])
    model = ANFIS(3, kind, partition, most_epochs=3).fit(X, y)
    assert (np.abs(model.predict(X) - y).max(axis=0) < 1e-4 * y.std(axis=0)).all()


@functools.cache
def narrow(kind: str) -> ANFIS:
    """Return a model with terms a tenth as wide as they were learned: there are holes between."""
    model = ANFIS(3, kind, most_epochs=3).fit(*surface())
    terms = [
        [dataclasses.replace(term, sigma=0.1 * term.sigma) for term in terms]
        for terms in model.system_.inputs
    ]
    model.system_ = model.system_.replace(inputs=terms)
    return model


@settings(max_examples=examples(100), deadline=None)
@given(
    kind=st.sampled_from(["t1", "it2"]),
    x=st.tuples(*[st.floats(-1e100, 1e100)] * 2),
    inside=st.booleans(),
)
def test_there_is_a_prediction_for_every_input(
    kind: str, x: tuple[float, float], inside: bool
) -> None:
    """One that some rule would give, or what lies between the rules."""
    model = narrow(kind)
    row = np.array(x)
    if inside:
        row = np.array([0.0, 20.0]) + [1.0, 10.0] * np.tanh(row)
    said = model.system_.consequents.at(row[np.newaxis])[0, :, 0]
    predicted = model.predict(row[np.newaxis])[0]
    margin = 1e-9 * np.abs(said).max()
    assert said.min() - margin <= predicted <= said.max() + margin


def test_learning_beats_least_squares_alone() -> None:
    X, y = surface()
    fresh, truth = surface(400)
    start, learned = (ANFIS(3, most_epochs=epochs).fit(X, y) for epochs in (0, 60))
    assert (start.n_iter_, len(start.training_errors_)) == (0, 1)
    assert learned.training_errors_[-1] < 0.2 * start.training_errors_[-1]
    assert 1.0 - learned.score(fresh, truth) < 0.5 * (1.0 - start.score(fresh, truth))
    assert len(learned.validation_errors_) > 1


def test_the_system_is_an_ordinary_one() -> None:
    X, y = surface(outputs=2)
    model = ANFIS([2, 3]).fit(X, y)
    system = model.system_
    assert isinstance(system, Type1System)
    assert isinstance(system.consequents, Linear)
    assert system.consequents.coefficients.shape == (6, 2, 3)
    assert system.term_names == (("Low", "High"), ("Low", "Mid", "High"))
    for terms in system.inputs:
        means = [term.mean for term in terms]
        assert means == sorted(means)
    np.testing.assert_array_equal(model.predict(X), system(X))
    # What was learned is what the learner said it was: the error in units of variances.
    error = np.mean(((model.predict(X) - y) / y.std(axis=0)) ** 2)
    assert error == pytest.approx(model.training_errors_[-1], rel=1e-6)
    assert isinstance(ANFIS(kind="it2").fit(X, y).system_, IntervalType2System)


def test_units_of_inputs_and_outputs_make_no_difference() -> None:
    """Up to rounding on the way, which learning magnifies: 1e-5 of the outputs' deviation."""
    X, y = surface()
    first = ANFIS(3, most_epochs=10).fit(X, y).predict(X)
    scaled = ANFIS(3, most_epochs=10).fit(X * [1e6, 1e-3] + [5.0, 7.0], 1e-4 * y - 3.0)
    again = (scaled.predict(X * [1e6, 1e-3] + [5.0, 7.0]) + 3.0) * 1e4
    np.testing.assert_allclose(again, first, rtol=0.0, atol=1e-5 * y.std())


def test_weights_are_repetitions() -> None:
    """The samples held back are the same, too; 1e-5 is rounding that learning magnifies."""
    X, y = surface(60)
    weights = np.random.default_rng(1).integers(0, 4, 60)
    weighted = ANFIS(most_epochs=10).fit(X, y, sample_weight=weights)
    repeated = ANFIS(most_epochs=10).fit(np.repeat(X, weights, axis=0), np.repeat(y, weights))
    np.testing.assert_allclose(
        weighted.predict(X), repeated.predict(X), rtol=0.0, atol=1e-5 * y.std()
    )


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:Estimator ANFIS does not inherit:UserWarning")
def test_scikit_learn_finds_nothing_to_complain_about() -> None:
    """With clusters: some checks have 30 inputs, for which no grid can be filled."""
    checks = pytest.importorskip("sklearn.utils.estimator_checks")
    model = ANFIS(3, partition="clusters", most_epochs=3, ridge=1e-3)
    results = checks.check_estimator(model, on_fail=None, on_skip=None)
    failed = {
        result["check_name"]: result["exception"]
        for result in results
        if result["status"] == "failed"
    }
    assert not failed
    assert sum(result["status"] == "passed" for result in results) >= 55


@pytest.mark.parametrize("kind", ["t1", "it2"])
def test_more_can_be_tuned_afterwards(kind: str) -> None:
    X, y = surface()
    model = ANFIS(kind=kind, ridge=0.1, most_epochs=0).fit(X, y)  # far from the best
    tuning = fine_tune(model.system_, X, y, np.random.default_rng(0), most_epochs=60)
    assert tuning.best_epoch > 0
    assert tuning.validation_errors[tuning.best_epoch] < tuning.validation_errors[0]
    assert isinstance(tuning.system.consequents, Linear)


@pytest.mark.parametrize(
    ("options", "error", "words"),
    [
        ({"kind": "gt2"}, UnknownName, "t1, it2"),
        ({"partition": "tree"}, UnknownName, "grid, clusters"),
        ({"n_terms": 0}, InvalidValue, "n_terms"),
        ({"n_terms": [2, 2, 2]}, InvalidValue, "each of the 2 inputs"),
        ({"n_terms": 100}, InvalidValue, "10,000; partition='clusters'"),
        ({"mean_variation": -1.0}, InvalidValue, "mean_variation"),
        ({"ridge": 0.0}, InvalidValue, "ridge"),
        ({"ridge": ()}, InvalidValue, "ridge"),
        ({"most_epochs": -1}, InvalidValue, "most_epochs"),
        ({"patience": 0}, InvalidValue, "patience"),
        ({"validation_share": 1.0}, InvalidValue, "validation_share"),
        ({"rng": 0}, InvalidValue, "rng"),
    ],
)
def test_parameters_that_cannot_be_meant_are_refused_by_fit(
    options: dict[str, Any], error: type[Fuzzy2Error], words: str
) -> None:
    with pytest.raises(error, match=words):
        ANFIS(**options).fit(*surface(20))


def test_data_frames_name_inputs_outputs_and_explanations() -> None:
    """Predictions are arrays, as scikit-learn's; the system's own answers are data frames."""
    pandas = pytest.importorskip("pandas")
    X, y = surface(40)
    frame, target = pandas.DataFrame(X, columns=["heat", "flow"]), pandas.Series(y, name="yield")
    model = ANFIS(most_epochs=2).fit(frame, target)
    plain = ANFIS(most_epochs=2).fit(X, y)
    assert model.system_.input_names == ("heat", "flow")
    assert model.system_.output_names == ("yield",)
    assert type(model.predict(frame)) is np.ndarray
    np.testing.assert_array_equal(model.predict(frame), plain.predict(X))
    answer = model.system_(frame[["flow", "heat"]])
    np.testing.assert_array_equal(answer["yield"].to_numpy(), plain.predict(X))
    assert str(model.explain(frame.iloc[3])) == str(model.explain(frame.iloc[[3]]))
