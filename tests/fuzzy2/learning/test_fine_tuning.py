"""Gradient fine-tuning: what it achieves, where it stops and what it refuses."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from fuzzy2.errors import InvalidValue, NotApplicable
from fuzzy2.learning import WangMendel
from fuzzy2.learning.fine_tuning import fine_tune
from fuzzy2.learning.tunable_system import TunableSystem
from fuzzy2.sets.interval_type2 import GaussianUncertainMean, GaussianUncertainSigma
from fuzzy2.sets.shapes import Gaussian, Triangular
from fuzzy2.systems import FuzzySystem, Type1System
from fuzzy2.systems.fuzzifiers import NonSingletonFuzzifier
from tests.fuzzy2.learning.tunable import samples, systems


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["t1", "it2"])
@pytest.mark.parametrize("output_terms", [None, 5])
def test_tuning_lowers_the_error_of_a_learned_system(kind: str, output_terms: int | None) -> None:
    """On fresh samples, and by more than half.

    Table look-up with 9 rules is far from what 9 rules can do.
    """
    rng = np.random.default_rng(2)
    X, Y = samples(rng, 300)
    learned = WangMendel(n_terms=3, kind=kind, output_terms=output_terms).fit(X, Y)
    before = learned.system_(X)
    tuning = fine_tune(learned.system_, X, Y, np.random.default_rng(0), most_epochs=200)
    fresh_X, fresh_Y = samples(rng, 500)
    errors = [
        np.mean(((system(fresh_X) - fresh_Y) / Y.std(axis=0)) ** 2)
        for system in (learned.system_, tuning.system)
    ]
    assert errors[1] < 0.5 * errors[0]
    np.testing.assert_array_equal(learned.system_(X), before)  # the given system is as it was
    assert tuning.system.term_names == learned.system_.term_names
    assert tuning.training_errors.shape == tuning.validation_errors.shape
    assert tuning.validation_errors[tuning.best_epoch] == tuning.validation_errors.min()


@pytest.mark.slow
def test_tuning_finds_back_a_system_from_nearby() -> None:
    """Samples without noise of a system, tuned from one with everything shifted.

    The error must fall by a factor of 100.
    """
    rng = np.random.default_rng(4)
    truth = systems(rng, "product")["type-1"]
    X, _ = samples(rng, 400)
    Y = truth(X)
    tunable = TunableSystem(truth, [4.0, 60.0], Y.std(axis=0))
    shifted = tunable.system(tunable.parameters + 0.1 * rng.normal(size=tunable.parameters.size))
    tuning = fine_tune(shifted, X, Y, np.random.default_rng(0), most_epochs=600, patience=200)
    assert tuning.training_errors[tuning.best_epoch] < 0.01 * tuning.training_errors[0]


def test_history_starts_with_the_given_system_and_follows_the_generator() -> None:
    rng = np.random.default_rng(2)
    X, Y = samples(rng, 50)
    system = systems(rng, "product")["interval type-2"]
    first, same, other = (
        fine_tune(system, X, Y, np.random.default_rng(seed), most_epochs=5) for seed in (0, 0, 1)
    )
    np.testing.assert_array_equal(first.training_errors, same.training_errors)
    np.testing.assert_array_equal(first.system(X), same.system(X))
    assert first.training_errors[0] != other.training_errors[0]
    # 40 samples and 10: their errors, weighed with their numbers, are the error over all; 1e-12 is
    # rounding.
    whole = np.mean(((system(X) - Y) / Y.std(axis=0)) ** 2)
    assert 0.8 * first.training_errors[0] + 0.2 * first.validation_errors[0] == pytest.approx(
        whole, rel=1e-12
    )
    assert len(first.training_errors) == 6
    assert not first.stopped_early


def test_it_stops_when_validation_gets_worse() -> None:
    """Outputs that are nothing but noise can only be learned by heart."""
    rng = np.random.default_rng(0)
    X, _ = samples(rng, 30)
    noise = rng.normal(size=(30, 2)) * 0.1
    learned = WangMendel(n_terms=3, learner="average").fit(X, noise)
    tuning = fine_tune(
        learned.system_,
        X,
        noise,
        np.random.default_rng(1),
        learning_rate=0.05,
        most_epochs=2000,
        patience=20,
    )
    assert tuning.stopped_early
    assert len(tuning.training_errors) - 1 == tuning.best_epoch + 20
    assert tuning.validation_errors[tuning.best_epoch] <= tuning.validation_errors[0]
    assert tuning.training_errors[-1] < tuning.training_errors[0]


def test_a_step_after_which_no_rule_fires_ends_the_tuning(monkeypatch: pytest.MonkeyPatch) -> None:
    """Such a step is made by hand in the seventh epoch: all terms leave the samples.

    What comes back is the best system before it.
    """
    X, Y = samples(np.random.default_rng(0))
    system = systems(np.random.default_rng(0), "product")["type-1"]
    expected = fine_tune(system, X, Y, np.random.default_rng(0), most_epochs=6)
    admissible, calls = TunableSystem.admissible, iter(range(100))

    def leave(self: TunableSystem, parameters: np.ndarray) -> np.ndarray:
        if next(calls) < 6:
            return admissible(self, parameters)
        away = parameters.copy()
        away[:10] = 1e200
        away[1:10:2] = 0.0  # logarithms of the standard deviations
        return away

    monkeypatch.setattr(TunableSystem, "admissible", leave)
    tuning = fine_tune(system, X, Y, np.random.default_rng(0))
    assert tuning.stopped_early
    np.testing.assert_array_equal(tuning.training_errors, expected.training_errors)
    np.testing.assert_array_equal(tuning.system(X), expected.system(X))


def test_type_1_terms_and_numbers_stay_what_they_are() -> None:
    rng = np.random.default_rng(0)
    X, Y = samples(rng)
    tuned = fine_tune(
        systems(rng, "product")["interval type-2"], X, Y, np.random.default_rng(0), most_epochs=30
    ).system
    kinds = [[type(term) for term in terms] for terms in tuned.inputs]
    assert kinds == [
        [GaussianUncertainMean, GaussianUncertainSigma, Gaussian],
        [GaussianUncertainMean, GaussianUncertainMean],
    ]
    assert np.ndim(tuned.consequents) == 2


def test_one_output_and_a_constant_one_can_be_tuned() -> None:
    rng = np.random.default_rng(0)
    X, Y = samples(rng)
    system = Type1System(
        [[Gaussian(-1.0, 1.0), Gaussian(1.0, 1.0)], [Gaussian(0.0, 20.0)]],
        [[0, 0], [1, 0]],
        [[0.0], [1.0]],
    )
    assert fine_tune(system, X, Y[:, 0], np.random.default_rng(0), most_epochs=20).best_epoch > 0
    constant = fine_tune(system, X, np.ones(len(X)), np.random.default_rng(0), most_epochs=50)
    assert constant.validation_errors[constant.best_epoch] < constant.validation_errors[0]


LOW_HIGH = [[Gaussian(0.0, 1.0), Gaussian(1.0, 1.0)]]


@pytest.mark.parametrize(
    ("system", "words"),
    [
        (Type1System([[Triangular(0.0, 1.0, 2.0)]], [[0]], [[1.0]]), "is not a Gaussian"),
        (
            Type1System(LOW_HIGH, [[0], [1]], [Gaussian(0.0, 1.0), Gaussian(1.0, 1.0)]),
            "numbers, intervals or linear functions",
        ),
        (Type1System(LOW_HIGH, [[0], [1]], [[0.0], [1.0]], "lukasiewicz"), "t-norm"),
        (
            Type1System(
                LOW_HIGH,
                [[0], [1]],
                [[0.0], [1.0]],
                fuzzifier=NonSingletonFuzzifier(Gaussian(0.0, 0.1)),
            ),
            "fuzzifier",
        ),
        (
            WangMendel(kind="gt2").fit([[0.0], [1.0]], [0.0, 1.0]).system_,
            "type-1 or an interval type-2 system",
        ),
    ],
)
def test_systems_that_cannot_be_tuned_are_refused_with_a_reason(
    system: FuzzySystem, words: str
) -> None:
    with pytest.raises(NotApplicable, match=words):
        fine_tune(system, [[0.0], [1.0]], [0.0, 1.0], np.random.default_rng(0))


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"X": np.zeros((4, 2))}, "X"),
        ({"X": [[0.0], [1.0], [np.nan], [2.0]]}, "X"),
        ({"y": np.zeros(3)}, "y"),
        ({"y": np.full(4, np.inf)}, "y"),
        ({"X": [[0.0]], "y": [0.0]}, "at least 2 samples"),
        ({"X": [[0.0], [1.0], [1e200], [2.0]]}, r"X\[2\].*where some rule fires"),
        ({"learning_rate": 0.0}, "learning_rate"),
        ({"learning_rate": 2.0}, "learning_rate"),
        ({"most_epochs": 0}, "most_epochs"),
        ({"patience": 1.5}, "patience"),
        ({"validation_share": 1.0}, "validation_share"),
        ({"rng": 0}, "rng"),
    ],
)
def test_arguments_that_cannot_be_meant_are_refused(changes: dict[str, Any], words: str) -> None:
    arguments: dict[str, Any] = {
        "X": [[0.0], [0.5], [1.0], [2.0]],
        "y": np.arange(4.0),
        "rng": np.random.default_rng(0),
    }
    with pytest.raises(InvalidValue, match=words):
        fine_tune(Type1System(LOW_HIGH, [[0], [1]], [[0.0], [1.0]]), **(arguments | changes))


def test_columns_of_a_frame_are_matched_by_name() -> None:
    pandas = pytest.importorskip("pandas")
    rng = np.random.default_rng(2)
    X, Y = samples(rng, 30)
    system = systems(rng, "product")["type-1"].replace(
        input_names=["a", "b"], output_names=["p", "q"]
    )
    inputs = pandas.DataFrame(X, columns=["a", "b"])
    outputs = pandas.DataFrame(Y, columns=["p", "q"], index=inputs.index)

    def tuned(X: Any, y: Any, given: FuzzySystem = system) -> Any:
        return fine_tune(given, X, y, np.random.default_rng(0), most_epochs=3).system.consequents

    expected = tuned(X, Y)
    np.testing.assert_array_equal(tuned(inputs[["b", "a"]], outputs[["q", "p"]]), expected)
    np.testing.assert_array_equal(tuned({"b": X[:, 1], "a": X[:, 0]}, Y), expected)
    for frame in (inputs.rename(columns={"a": "c"}), inputs[["a"]]):
        with pytest.raises(InvalidValue, match="X must be values of all inputs") as caught:
            tuned(frame, Y)
        with pytest.raises(InvalidValue) as of_system:
            system(frame)
        assert str(caught.value) == str(of_system.value)
    # The index of a Series, or the name of a single column, may be any.
    single = system.replace(consequents=np.asarray(system.consequents)[:, :1], output_names=["p"])
    column = outputs["q"].set_axis([f"sample {i}" for i in range(len(Y))])
    expected = tuned(X, Y[:, 1], single)
    np.testing.assert_array_equal(tuned(inputs, column, single), expected)
    np.testing.assert_array_equal(tuned(inputs, outputs[["q"]], single), expected)


def test_samples_of_a_wrong_shape_are_refused_with_their_shape() -> None:
    rng = np.random.default_rng(2)
    X, Y = samples(rng, 30)
    system, source = systems(rng, "product")["type-1"], np.random.default_rng(0)
    for bad_X, bad_y, said in (
        (X, Y[:4], r"y must be of shape \(30, 2\), one row for each of X, got \(4, 2\)"),
        (X[:, :1], Y, r"X must be of shape \(N, 2\), got \(30, 1\)"),
        (X, np.where(Y[3] == Y, np.nan, Y), r"y\[3\] must be finite, got \[nan nan\]"),
        (np.zeros((0, 2)), np.zeros((0, 2)), r"X must be at least 2 samples.* got \(0, 2\)"),
    ):
        with pytest.raises(InvalidValue, match=said):
            fine_tune(system, bad_X, bad_y, source)
