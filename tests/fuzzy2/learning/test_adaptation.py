"""Online adaptation of consequents.

Against batch least squares, differences of the output, and plain recursive least squares.
"""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fuzzy2.errors import InvalidValue, NotApplicable
from fuzzy2.learning.adaptation import AdaptiveConsequents
from fuzzy2.learning.adaptation_kernels import basis
from fuzzy2.sets.derived import FunctionalSet
from fuzzy2.sets.gaussian_type2 import GaussianType2Set
from fuzzy2.sets.interval_type2 import GaussianUncertainMean, GaussianUncertainSigma
from fuzzy2.sets.shapes import Gaussian, Triangular
from fuzzy2.systems import FuzzySystem, GeneralType2System, IntervalType2System, Linear, Type1System
from fuzzy2.systems.fuzzifiers import NonSingletonFuzzifier

GRID = list(itertools.product(range(2), range(3)))


def type1(seed: int = 0, outputs: int = 2) -> Type1System:
    terms = [
        [Gaussian(-1.0, 0.8), Gaussian(1.0, 0.9)],
        [Gaussian(-2.0, 1.0), Gaussian(0.0, 0.7), Gaussian(2.0, 1.1)],
    ]
    return Type1System(terms, GRID, np.random.default_rng(seed).normal(size=(6, outputs)))


def type2(seed: int = 0, outputs: int = 2, intervals: bool = False) -> IntervalType2System:
    first = [GaussianUncertainMean((center - 0.4, center + 0.3), 0.8) for center in (-1.0, 1.0)]
    second = [GaussianUncertainSigma(center, (0.6, 1.1)) for center in (-2.0, 0.0, 2.0)]
    consequents = np.random.default_rng(seed).normal(
        size=(6, outputs, 2) if intervals else (6, outputs)
    )
    return IntervalType2System(
        [first, second], GRID, np.sort(consequents, axis=-1) if intervals else consequents
    )


def samples(count: int, outputs: int = 2, seed: int = 1) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    return rng.uniform(-3.0, 3.0, (count, 2)), rng.normal(size=(count, outputs))


def all_switch_points(firing: np.ndarray, points: np.ndarray, left: bool) -> np.ndarray:
    """Return the weights, adding up to 1, of the best of all switch points.

    The definition of the ends.
    """
    order = np.argsort(points, kind="stable")
    best: tuple[float, np.ndarray] | None = None
    for k in range(len(points) + 1):
        weights = np.empty(len(points))
        weights[order[:k]] = firing[order[:k], 1 if left else 0]
        weights[order[k:]] = firing[order[k:], 0 if left else 1]
        value = weights @ points / weights.sum()
        if best is None or (value < best[0] if left else value > best[0]):
            best = (value, weights / weights.sum())
    assert best is not None
    return best[1]


def rows_of(system: FuzzySystem, x: np.ndarray, consequents: np.ndarray) -> np.ndarray:
    """Return the derivatives (m, n) of the crisp outputs by consequents.

    By enumeration.
    """
    firing = system.firing(x)
    ends = np.stack([consequents, consequents], axis=-1) if consequents.ndim == 2 else consequents
    left, right = (
        np.array(
            [all_switch_points(firing, ends[:, j, end], end == 0) for j in range(ends.shape[1])]
        )
        for end in (0, 1)
    )
    return (
        0.5 * (left + right)
        if consequents.ndim == 2
        else 0.5 * np.concatenate([left, right], axis=1)
    )


@pytest.mark.parametrize(
    "system", [type1(), type2(), type2(intervals=True)], ids=["type-1", "type-2", "intervals"]
)
@pytest.mark.parametrize(("forgetting", "trust"), [(1.0, 0.1), (0.9, 0.1), (0.97, 5.0)])
def test_what_is_learned_is_batch_weighted_least_squares(
    system: FuzzySystem, forgetting: float, trust: float
) -> None:
    """After every sample, to 1e-10, by singular values of all weighted rows and those of the prior.

    Rows of a type-2 system are those of the switch points at their time, found by enumeration with
    the consequents of that time. Where least squares let the ends of an interval cross, they are
    put on their middle.
    """
    X, Y = samples(40)
    adaptive = AdaptiveConsequents(system, forgetting, trust)
    trained = np.asarray(system.consequents)
    # (m, n)
    flat = (
        trained.T
        if trained.ndim == 2
        else np.concatenate([trained[..., 0].T, trained[..., 1].T], axis=1)
    )
    rows: list[np.ndarray] = []
    for n, (x, y) in enumerate(zip(X, Y, strict=True), start=1):
        rows.append(rows_of(system, x, adaptive.consequents))
        adaptive.update(x, y)
        weights = np.sqrt(forgetting ** np.arange(n - 1, -1, -1))
        for j in range(2):
            phi = np.array([row[j] for row in rows])
            matrix = np.concatenate(
                [weights[:, np.newaxis] * phi, math.sqrt(trust) * np.eye(flat.shape[1])]
            )
            right = np.concatenate([weights * (Y[:n, j] - phi @ flat[j]), np.zeros(flat.shape[1])])
            expected = flat[j] + np.linalg.lstsq(matrix, right, rcond=None)[0]
            if trained.ndim == 3:
                ends = np.stack([expected[:6], expected[6:]], axis=1)
                crossed = ends[:, 0] > ends[:, 1]
                ends[crossed] = ends[crossed].mean(axis=1, keepdims=True)
                np.testing.assert_allclose(adaptive.consequents[:, j], ends, rtol=0.0, atol=1e-10)
            else:
                np.testing.assert_allclose(
                    adaptive.consequents[:, j], expected, rtol=0.0, atol=1e-10
                )
            covariance = np.linalg.inv(matrix.T @ matrix)
            np.testing.assert_allclose(
                adaptive.covariance[j], covariance, rtol=0.0, atol=1e-10 / trust
            )


@settings(max_examples=50, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), intervals=st.booleans())
def test_basis_functions_make_the_ends_of_the_system(seed: int, intervals: bool) -> None:
    """They add up to 1 and give the type-reduced interval to rounding, 1e-13.

    Equal consequents are ties, and any order will do.
    """
    rng = np.random.default_rng(seed)
    system = type2(seed, 3, intervals)
    consequents = np.array(system.consequents)
    consequents[2] = consequents[4]
    system = IntervalType2System(system.inputs, system.rules, consequents)
    ends = np.stack([consequents, consequents], axis=-1) if consequents.ndim == 2 else consequents
    by_output = np.moveaxis(ends, 0, -1).reshape(6, 6)
    orders = np.tile(rng.permutation(6), (6, 1))
    phi, strengths = np.empty((6, 6)), np.empty(12)
    assert system.table is not None
    for x in rng.uniform(-4.0, 4.0, (5, 2)):
        assert basis(system.table, x, by_output, orders, strengths, phi)
        np.testing.assert_allclose(phi.sum(axis=-1), 1.0, rtol=1e-14)
        np.testing.assert_allclose(
            (phi * by_output).sum(axis=-1).reshape(3, 2),
            system.type_reduced(x),
            rtol=0.0,
            atol=1e-13,
        )
        assert (np.diff(np.take_along_axis(by_output, orders, axis=-1), axis=-1) >= 0.0).all()


def test_basis_functions_are_derivatives_with_respect_to_the_consequents() -> None:
    """By central differences, which are exact where the output is linear.

    1e-9 is rounding over the step.
    """
    system, step = type2(5), 1e-6
    consequents = np.asarray(system.consequents)
    for x in np.random.default_rng(0).uniform(-3.0, 3.0, (10, 2)):
        rows = rows_of(system, x, consequents)
        for r, j in itertools.product(range(6), range(2)):
            shift = np.zeros_like(consequents)
            shift[r, j] = step
            up, down = (
                IntervalType2System(system.inputs, system.rules, consequents + sign * shift)(x)
                for sign in (1.0, -1.0)
            )
            assert (up[j] - down[j]) / (2.0 * step) == pytest.approx(rows[j, r], abs=1e-9)


def test_tiny_firing_strengths_lose_nothing() -> None:
    """Thirty standard deviations off all firing is below 1e-190, and its products underflow.

    Its shares are as good as anywhere.
    """
    system = type1()
    adaptive = AdaptiveConsequents(system)
    x = [30.0, 2.0]
    assert system.firing(x).max() < 1e-190
    np.testing.assert_allclose(adaptive(x), system(x), rtol=1e-12)
    adaptive.update(x, [5.0, 5.0])
    assert np.isfinite(adaptive.consequents).all()


def test_a_system_in_reach_is_found_and_a_drift_is_followed() -> None:
    """Consequents of the truth turn slowly.

    Memory of 50 samples follows them to a tenth of what a memory without end misses.
    """
    truth = type1(7)
    X, _ = samples(3000)
    for system in (type1(3), type2(3)):
        same = type(system)(system.inputs, system.rules, np.asarray(truth.consequents))
        adaptive = AdaptiveConsequents(system, 1.0, 1e-6)
        adaptive.update(X, same(X))
        # switch points were others on the way there
        tolerance = 1e-4 if isinstance(system, Type1System) else 0.05
        np.testing.assert_allclose(adaptive.consequents, truth.consequents, atol=tolerance)
    first, second = np.asarray(type1(7).consequents), np.asarray(type1(8).consequents)
    angles = np.linspace(0.0, math.pi, len(X))
    moving = np.array(
        [
            Type1System(truth.inputs, truth.rules, math.cos(a) * first + math.sin(a) * second)(x)
            for x, a in zip(X, angles, strict=True)
        ]
    )
    missed = {}
    for forgetting in (0.98, 1.0):
        adaptive = AdaptiveConsequents(
            Type1System(truth.inputs, truth.rules, first), forgetting, 1e-3
        )
        missed[forgetting] = np.sqrt(np.mean(adaptive.update(X, moving)[500:] ** 2))
    frozen = np.sqrt(
        np.mean((moving - Type1System(truth.inputs, truth.rules, first)(X))[500:] ** 2)
    )
    assert missed[0.98] < 0.1 * missed[1.0] < 0.1 * frozen


def test_without_excitation_nothing_winds_up() -> None:
    """Twenty thousand samples at one place.

    Plain forgetting loses count within them, and the bounded one does not.

    Its covariance never exceeds 1/trust, and rules that did not fire say what they said. Then a
    single sample with noise comes in at another place: it moves the bounded consequents by its
    noise at most.
    """
    system = type1(outputs=1)
    trust, forgetting = 0.1, 0.99
    adaptive = AdaptiveConsequents(system, forgetting, trust)
    x, y = np.array([-1.0, -2.0]), np.array([3.0])
    adaptive.update(np.tile(x, (20_000, 1)), np.tile(y, (20_000, 1)))
    assert np.linalg.eigvalsh(adaptive.covariance[0]).max() <= (1.0 + 1e-12) / trust
    # One sample's worth of trust against a hundred remembered samples; the basis function there is
    # 0.9.
    assert adaptive(x)[0] == pytest.approx(3.0, abs=0.01)
    np.testing.assert_allclose(adaptive.consequents[-1], system.consequents[-1], atol=1e-3)

    phi = rows_of(system, x, np.asarray(system.consequents))[0]
    plain = np.eye(6) / trust
    for _ in range(20_000):
        gain = plain @ phi / (forgetting + phi @ plain @ phi)
        plain = (plain - np.outer(gain, phi @ plain)) / forgetting
        plain = 0.5 * (plain + plain.T)
        if np.abs(plain).max() > 1e12:
            break
    assert np.abs(plain).max() > 1e12

    elsewhere, noise = np.array([1.0, 2.0]), 0.5
    before = adaptive.consequents
    adaptive.update(elsewhere, system(elsewhere) + noise)
    assert np.abs(adaptive.consequents - before).max() <= noise


def test_rules_that_do_not_fire_any_more_go_back_to_what_was_trained() -> None:
    system = type1(outputs=1)
    adaptive = AdaptiveConsequents(system, 0.9, 0.1)
    adaptive.update(np.tile([1.0, 2.0], (100, 1)), np.full((100, 1), 9.0))
    assert abs(adaptive.consequents[-1, 0] - system.consequents[-1, 0]) > 5.0
    adaptive.update(np.tile([-1.0, -2.0], (300, 1)), np.tile(system([-1.0, -2.0]), (300, 1)))
    # The memory of the first hundred has faded by 0.9**300 = 2e-14.
    np.testing.assert_allclose(adaptive.consequents[-1], system.consequents[-1], atol=1e-3)


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), intervals=st.booleans(), reach=st.floats(0.0, 2.0))
def test_consequents_stay_within_their_bounds_and_in_order(
    seed: int, intervals: bool, reach: float
) -> None:
    """Whatever comes in: samples a thousand times larger than the consequents."""
    system = type2(seed, 2, intervals)
    trained = np.asarray(system.consequents)
    adaptive = AdaptiveConsequents(system, 0.8, 1e-3, (trained - reach, trained + reach))
    X, Y = samples(30, seed=seed)
    for x, y in zip(X, 1e3 * Y, strict=True):
        adaptive.update(x, y)
        assert (np.abs(adaptive.consequents - trained) <= reach + 1e-12).all()
        if intervals:
            assert (adaptive.consequents[..., 0] <= adaptive.consequents[..., 1]).all()
    bound_for_all = AdaptiveConsequents(type1(), bounds=(-10.0, 10.0))
    bound_for_all.update(X, 1e4 * Y)
    assert np.abs(bound_for_all.consequents).max() <= 10.0


def test_within_bounds_it_is_the_least_squares_within_them() -> None:
    """By SciPy's bounded solver.

    Ten sweeps a sample from the last solution keep within 1e-6 of numbers of order 1.
    """
    optimize = pytest.importorskip("scipy.optimize")
    system, forgetting, trust, reach = type1(outputs=1), 0.98, 0.05, 0.4
    X, Y = samples(150, outputs=1)
    trained = np.asarray(system.consequents)
    adaptive = AdaptiveConsequents(system, forgetting, trust, (trained - reach, trained + reach))
    adaptive.update(X, 2.0 * Y)
    phi = np.array([rows_of(system, x, trained)[0] for x in X])
    weights = np.sqrt(forgetting ** np.arange(len(X) - 1, -1, -1))
    matrix = np.concatenate([weights[:, np.newaxis] * phi, math.sqrt(trust) * np.eye(6)])
    right = np.concatenate([weights * (2.0 * Y[:, 0] - phi @ trained[:, 0]), np.zeros(6)])
    expected = optimize.lsq_linear(matrix, right, (-reach, reach), method="bvls", tol=1e-14).x
    assert (np.abs(expected) > reach - 1e-9).any()
    assert (np.abs(expected) < reach - 1e-3).any()
    np.testing.assert_allclose(
        adaptive.consequents[:, 0] - trained[:, 0], expected, rtol=0.0, atol=1e-6
    )


@pytest.mark.parametrize(
    "system", [type1(), type2(), type2(intervals=True)], ids=["type-1", "type-2", "intervals"]
)
def test_one_by_one_or_all_at_once_and_what_is_given_stays(system: FuzzySystem) -> None:
    X, Y = samples(12)
    trained = np.array(system.consequents)
    one, other = AdaptiveConsequents(system), AdaptiveConsequents(system)
    errors = np.array([one.update(x, y) for x, y in zip(X, Y, strict=True)])
    np.testing.assert_array_equal(
        other.update(X.reshape(3, 4, 2), Y.reshape(3, 4, 2)), errors.reshape(3, 4, 2)
    )
    np.testing.assert_array_equal(one.consequents, other.consequents)
    np.testing.assert_allclose(errors[0], Y[0] - system(X[0]), atol=1e-13)
    np.testing.assert_array_equal(system.consequents, trained)
    # The system that is handed out is the same function; ends of sums differ by rounding.
    np.testing.assert_allclose(one.system(X), one(X), atol=1e-13)
    assert one(X[0]).shape == (2,)
    assert one.system.input_names == system.input_names
    one.reset()
    np.testing.assert_array_equal(one.consequents, trained)
    np.testing.assert_array_equal(one.update(X[0], Y[0]), errors[0])


def test_a_sample_that_fires_no_rule_is_passed_over() -> None:
    terms = [
        [Triangular(-3.0, -1.0, 1.0), Triangular(-1.0, 1.0, 3.0)],
        [Gaussian(-2.0, 1.0), Gaussian(0.0, 0.7), Gaussian(2.0, 1.1)],
    ]
    system = Type1System(terms, GRID, type1().consequents)
    adaptive = AdaptiveConsequents(system)
    far = [1e3, 0.0]
    assert np.isnan(system(far)).all()
    assert np.isnan(adaptive(far)).all()
    assert np.isnan(adaptive.update(far, [1.0, 1.0])).all()
    np.testing.assert_array_equal(adaptive.consequents, system.consequents)
    np.testing.assert_array_equal(adaptive.covariance, np.tile(np.eye(6), (2, 1, 1)))


@pytest.mark.parametrize(
    "system", [type1(), type2(), type2(intervals=True)], ids=["type-1", "type-2", "intervals"]
)
@pytest.mark.parametrize("x", [[1e3, 0.0], [1e6, -1e6], [-40.0, 3.0], [27.0, -27.0]])
def test_far_from_all_terms_it_learns_as_the_system_answers(
    system: FuzzySystem, x: list[float]
) -> None:
    """By logarithms, as firing strengths underflow: one sample against its least squares."""
    assert system.firing(x)[:, 0].max() < 1e-280
    adaptive = AdaptiveConsequents(system, trust=0.5)
    before = system(x)
    np.testing.assert_allclose(adaptive(x), before, rtol=1e-12)
    errors = adaptive.update(x, [3.0, -2.0])
    np.testing.assert_allclose(errors, [3.0, -2.0] - before, rtol=1e-12)
    np.testing.assert_allclose(adaptive(x), adaptive.system(x), rtol=1e-12)
    # The error shrinks by κ / (κ + φφ), and φφ is 1/4 at least, as each end adds up to 1.
    assert (np.abs([3.0, -2.0] - adaptive(x)) < 0.99 * np.abs(errors)).all()


@settings(max_examples=50, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), intervals=st.booleans())
def test_near_and_far_the_outputs_are_those_of_the_system(seed: int, intervals: bool) -> None:
    rng = np.random.default_rng(seed)
    system = type2(seed, 3, intervals)
    X = rng.normal(size=(20, 2)) * 10.0 ** rng.uniform(0.0, 6.0, (20, 2))
    np.testing.assert_allclose(AdaptiveConsequents(system)(X), system(X), rtol=0.0, atol=1e-10)


def test_columns_of_a_frame_are_matched_by_name() -> None:
    pandas = pytest.importorskip("pandas")
    system = type1().replace(input_names=["a", "b"], output_names=["p", "q"])
    X, Y = samples(20)
    inputs, outputs = (
        pandas.DataFrame(X, columns=["a", "b"]),
        pandas.DataFrame(Y, columns=["p", "q"]),
    )
    one, other = AdaptiveConsequents(system), AdaptiveConsequents(system)
    errors = one.update(X, Y)
    np.testing.assert_array_equal(other.update(inputs[["b", "a"]], outputs[["q", "p"]]), errors)
    np.testing.assert_array_equal(other.consequents, one.consequents)
    np.testing.assert_array_equal(other(inputs[["b", "a"]]), one(X))
    np.testing.assert_array_equal(
        other.update({"b": X[0, 1], "a": X[0, 0]}, outputs.loc[0, ["q", "p"]]),
        one.update(X[0], Y[0]),
    )
    with pytest.raises(InvalidValue, match=r"X must .* a has none, got \['c', 'b'\]"):
        other.update(inputs.rename(columns={"a": "c"}), outputs)
    with pytest.raises(InvalidValue, match=r"y must .* outputs, and p has none, got \['r', 'q'\]"):
        other.update(inputs, outputs.rename(columns={"p": "r"}))


def test_without_samples_there_is_nothing_to_learn_and_nothing_to_answer() -> None:
    adaptive = AdaptiveConsequents(type1())
    with pytest.raises(InvalidValue, match=r"X must be at least one sample, got \(0, 2\)"):
        adaptive.update(np.zeros((0, 2)), np.zeros((0, 2)))
    assert adaptive(np.zeros((3, 0, 2))).shape == (3, 0, 2)


@pytest.mark.parametrize(
    ("X", "y", "words"),
    [
        ([0.0, math.nan], [0.0, 0.0], "X must be finite"),
        ([0.0, 0.0], [0.0, math.nan], "y must be finite"),
        ([0.0, 0.0], [math.inf, 0.0], "y must be finite"),
        ([[0.0, 0.0], [math.nan, 0.0]], [[1.0, 1.0], [1.0, 1.0]], r"X\[1\] must be finite"),
        ([0.0], [0.0, 0.0], r"X must be of shape \(\.\.\., 2\), got \(1,\)"),
        ([0.0, 0.0], [0.0], r"y must be of shape \(\.\.\., 2\), got \(1,\)"),
        ([[0.0, 0.0]], [0.0, 0.0], r"one row for each of X, got \(2,\)"),
        (["a", "b"], [0.0, 0.0], "real numbers"),
    ],
)
def test_samples_that_are_no_numbers_are_refused_before_any_is_learned(
    X: Any, y: Any, words: str
) -> None:
    system = type1()
    adaptive = AdaptiveConsequents(system)
    with pytest.raises(InvalidValue, match=words):
        adaptive.update(X, y)
    np.testing.assert_array_equal(adaptive.consequents, system.consequents)
    with pytest.raises(InvalidValue, match="X must be finite"):
        adaptive([math.nan, 0.0])


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"forgetting": 0.0}, "forgetting"),
        ({"forgetting": 1.001}, "forgetting"),
        ({"forgetting": math.nan}, "forgetting"),
        ({"trust": 0.0}, "trust"),
        ({"trust": math.inf}, "trust"),
        ({"bounds": (0.0, 1.0)}, "around the trained consequents"),
        ({"bounds": (math.nan, 1.0)}, "around the trained consequents"),
        ({"bounds": (np.zeros(3), np.ones(3))}, "broadcast"),
        ({"bounds": 1.0}, "bounds"),
    ],
)
def test_parameters_that_cannot_be_meant_are_refused(options: dict[str, Any], words: str) -> None:
    with pytest.raises(InvalidValue, match=words):
        AdaptiveConsequents(type1(), **options)


def test_systems_whose_output_is_of_another_form_are_refused() -> None:
    terms: list[list[Any]] = [[Gaussian(-1.0, 1.0), Gaussian(1.0, 1.0)]]
    rules, numbers = [[0], [1]], [[0.0], [1.0]]
    sets = [Triangular(-1.0, 0.0, 1.0), Triangular(0.0, 1.0, 2.0)]
    systems = [
        GeneralType2System([[GaussianType2Set(term, 0.1) for term in terms[0]]], rules, numbers),
        Type1System(terms, rules, Linear([[[0.0, 1.0]], [[1.0, 1.0]]])),
        Type1System(terms, rules, sets),
        Type1System(terms, rules, sets, type_reduction="centroid"),
        Type1System(terms, rules, numbers, lambda a, b: a * b),
        Type1System(terms, rules, numbers, fuzzifier=NonSingletonFuzzifier(Gaussian(0.0, 0.1))),
        Type1System([[FunctionalSet(np.cos, -1.0, 1.0)] * 2], rules, numbers),
    ]
    for system in systems:
        with pytest.raises(
            NotApplicable, match=r"^adaptation of consequents does not apply: it (takes|needs)"
        ):
            AdaptiveConsequents(system)
