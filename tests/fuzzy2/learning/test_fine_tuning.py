"""Gradient fine-tuning.

The analytic gradient against finite differences of the system itself, and what tuning achieves.
"""

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
from fuzzy2.systems import FuzzySystem, IntervalType2System, Type1System
from fuzzy2.systems.fuzzifiers import NonSingletonFuzzifier

RULES = np.array([[0, 0], [0, 1], [1, 0], [1, 1], [2, -1]])


def systems(rng: np.random.Generator, t_norm: str) -> dict[str, FuzzySystem]:
    """Systems with every kind of term that can be tuned.

    One rule does not use an input, and consequents are numbers or intervals.
    """
    numbers = rng.normal(size=(5, 2)) * [1.0, 40.0]
    intervals = np.stack(
        [numbers - rng.uniform(0.1, 0.5, (5, 2)), numbers + rng.uniform(0.1, 0.5, (5, 2))], axis=-1
    )
    type1 = [
        [Gaussian(-1.0, 0.8), Gaussian(1.0, 0.9), Gaussian(0.2, 1.5, height=0.7)],
        [Gaussian(-20.0, 12.0), Gaussian(15.0, 14.0)],
    ]
    mixed: list[list[Any]] = [
        [
            GaussianUncertainMean((-1.3, -0.8), 0.8),
            GaussianUncertainSigma(1.0, (0.6, 1.1)),
            Gaussian(0.2, 1.5),
        ],
        [GaussianUncertainMean((-24.0, -18.0), 12.0), GaussianUncertainMean((12.0, 19.0), 14.0)],
    ]
    return {
        "type-1": Type1System(type1, RULES, numbers, t_norm),
        "type-1, intervals": Type1System(type1, RULES, intervals, t_norm),
        "interval type-2": IntervalType2System(mixed, RULES, numbers, t_norm),
        "interval type-2, intervals": IntervalType2System(mixed, RULES, intervals, t_norm),
    }


def samples(rng: np.random.Generator, count: int = 40) -> tuple[np.ndarray, np.ndarray]:
    X = rng.uniform([-2.0, -30.0], [2.0, 30.0], (count, 2))
    return X, np.stack([np.sin(X[:, 0]), X[:, 1] + 5.0 * X[:, 0] ** 2], axis=1)


@pytest.mark.parametrize("t_norm", ["product", "min"])
@pytest.mark.parametrize(
    "name", ["type-1", "type-1, intervals", "interval type-2", "interval type-2, intervals"]
)
def test_gradient_is_that_of_finite_differences_of_the_system(name: str, t_norm: str) -> None:
    """Central differences of the error of the compiled system, evaluated anew for every parameter.

    With a step of 1e-6 truncation is 1e-12 and rounding 1e-10 of an error of order 1, so 1e-7 is
    generous; the samples are drawn so that none lies within a step of a kink (a change of switch
    point, of the smallest grade or of the nearer mean).
    """
    rng = np.random.default_rng(3)
    system = systems(rng, t_norm)[name]
    X, Y = samples(rng)
    scales = np.array([0.9, 25.0])
    tunable = TunableSystem(system, [4.0, 60.0], scales)

    def error(parameters: np.ndarray) -> float:
        return float(np.mean(((tunable.system(parameters)(X) - Y) / scales) ** 2))

    value, gradient = tunable.objective(tunable.parameters, X, Y)
    assert value == pytest.approx(error(tunable.parameters), rel=1e-12)
    expected = np.empty_like(gradient)
    for k in range(gradient.size):
        step = np.zeros(gradient.size)
        step[k] = 1e-6
        expected[k] = (error(tunable.parameters + step) - error(tunable.parameters - step)) / 2e-6
    np.testing.assert_allclose(gradient, expected, rtol=1e-6, atol=1e-7)
    # Every parameter matters somewhere among the samples, so that a gradient of zeros would not
    # pass.
    assert (np.abs(gradient) > 1e-6).mean() > 0.9


@pytest.mark.parametrize("name", ["type-1", "interval type-2, intervals"])
def test_parameters_there_and_back_are_the_same_system(name: str) -> None:
    """Scales, logarithms and back: a few ulps, 1e-13 relative."""
    system = systems(np.random.default_rng(0), "product")[name]
    tunable = TunableSystem(system, [4.0, 60.0], [2.0, 3.0])
    again = tunable.system(tunable.parameters)
    X, _ = samples(np.random.default_rng(1))
    np.testing.assert_allclose(
        again.type_reduced(X), system.type_reduced(X), rtol=1e-11, atol=1e-13
    )
    assert type(again) is type(system)
    assert again.inputs[0][2].height == system.inputs[0][2].height
    np.testing.assert_array_equal(again.rules, system.rules)


def test_blocks_of_samples_change_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """1e-12: sums are added in another order."""
    rng = np.random.default_rng(0)
    system = systems(rng, "product")["interval type-2"]
    X, Y = samples(rng)
    tunable = TunableSystem(system, [1.0, 1.0], [1.0, 1.0])
    whole = tunable.objective(tunable.parameters, X, Y)
    monkeypatch.setattr("fuzzy2.learning.tunable_system._BLOCK", 70)  # seven samples
    blocks = tunable.objective(tunable.parameters, X, Y)
    assert blocks[0] == pytest.approx(whole[0], rel=1e-12)
    np.testing.assert_allclose(blocks[1], whole[1], rtol=1e-12, atol=1e-12)


def test_crossed_pairs_meet_in_their_middle() -> None:
    system = systems(np.random.default_rng(0), "product")["interval type-2, intervals"]
    tunable = TunableSystem(system, [1.0, 1.0], [1.0, 1.0])
    parameters = tunable.parameters.copy()
    parameters[0], parameters[1] = 0.5, -0.5
    corrected = tunable.admissible(parameters)
    np.testing.assert_array_equal(corrected[:2], [0.0, 0.0])
    np.testing.assert_array_equal(corrected[2:], parameters[2:])
    assert tunable.system(corrected).inputs[0][0].mean == (0.0, 0.0)


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
        away[:10] = 1e5
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


def test_a_single_rule_without_lower_firing_has_a_gradient() -> None:
    """The lower membership is 0 as a float 40 sigma from the far mean.

    Both ends are the one consequent, and move with it one to one.
    """
    term = GaussianUncertainMean((0.0, 100.0), 1.0)
    tunable = TunableSystem(IntervalType2System([[term]], [[0]], [[3.0]]), [1.0], [1.0])
    error, gradient = tunable.objective(tunable.parameters, np.array([[50.0]]), np.array([[1.0]]))
    assert error == 4.0
    np.testing.assert_array_equal(gradient, [0.0, 0.0, 0.0, 4.0])


LOW_HIGH = [[Gaussian(0.0, 1.0), Gaussian(1.0, 1.0)]]


@pytest.mark.parametrize(
    ("system", "words"),
    [
        (Type1System([[Triangular(0.0, 1.0, 2.0)]], [[0]], [[1.0]]), "is no Gaussian"),
        (
            Type1System(LOW_HIGH, [[0], [1]], [Gaussian(0.0, 1.0), Gaussian(1.0, 1.0)]),
            "neither numbers nor intervals",
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
        ({"X": [[0.0], [1.0], [1e6], [2.0]]}, r"X\[2\].*where some rule fires"),
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
