"""What the learners put behind a rule: against plain loops and the sums they are said to be."""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fuzzy2.errors import (
    CompletedRules,
    UnsupportedRule,
)
from fuzzy2.learning import WangMendel
from tests.fuzzy2.learning.plain_loops import (
    corners_and_more,
    loops_fire,
    loops_partition,
    loops_strict,
    loops_strongest,
)


def as_dictionary(rules: np.ndarray, values: np.ndarray) -> dict[tuple[int, ...], np.ndarray]:
    return {tuple(cell): value for cell, value in zip(rules.tolist(), values, strict=True)}


@pytest.mark.parametrize("t_norm", ["product", "min"])
@pytest.mark.parametrize("counts", [[2, 2], [3, 2], [4, 5]])
def test_strongest_takes_the_samples_that_plain_loops_take(counts: list[int], t_norm: str) -> None:
    X, Y = corners_and_more()
    model = WangMendel(n_terms=counts, t_norm=t_norm).fit(X, Y)
    expected = loops_strongest(X, Y, counts, t_norm == "min")
    learned = as_dictionary(model.system_.rules, model.system_.consequents)
    assert learned.keys() == expected.keys()
    for cell, value in expected.items():
        np.testing.assert_array_equal(learned[cell], value)
    np.testing.assert_array_equal(Y[model.rule_samples_[:, 0]], model.system_.consequents)


@settings(max_examples=40)
@given(
    seed=st.integers(0, 2**32 - 1),
    inputs=st.integers(1, 3),
    count=st.integers(2, 40),
    output_count=st.sampled_from([None, 2, 5]),
)
def test_the_strict_procedure_is_that_of_plain_loops(
    seed: int, inputs: int, count: int, output_count: int | None
) -> None:
    rng = np.random.default_rng(seed)
    X, Y = rng.normal(size=(count, inputs)), rng.normal(size=(count, 2))
    counts = rng.integers(2, 5, size=inputs).tolist()
    model = WangMendel(
        n_terms=counts, learner="strict", completion="none", output_terms=output_count
    ).fit(X, Y)
    says = model.system_.consequents if output_count is None else model.output_rules_
    learned, expected = (
        as_dictionary(model.system_.rules, says),
        loops_strict(X, Y, counts, output_count),
    )
    assert learned.keys() == expected.keys()
    for cell, value in expected.items():
        np.testing.assert_array_equal(learned[cell], value)


def test_average_and_ridge_are_the_sums_they_are_said_to_be() -> None:
    """Ridge by a different route.

    One least-squares problem with the penalty as rows, by singular values; 1e-10 for its condition.
    """
    X, Y = corners_and_more(count=40)
    terms = [loops_partition(X[:, i], 2) for i in range(2)]
    cells = list(itertools.product(range(2), repeat=2))
    firing = np.array([[loops_fire(x, cell, terms) for cell in cells] for x in X])
    average = np.array([(firing[:, [r]] * Y).sum(axis=0) / firing[:, r].sum() for r in range(4)])
    np.testing.assert_allclose(
        WangMendel(learner="average").fit(X, Y).system_.consequents, average, rtol=1e-12
    )

    penalty = 0.02
    shares = firing / firing.sum(axis=1, keepdims=True)
    rows = np.concatenate([shares / math.sqrt(len(X)), math.sqrt(penalty) * np.eye(4)])
    right = np.concatenate([Y / math.sqrt(len(X)), math.sqrt(penalty) * average])
    expected = np.linalg.lstsq(rows, right, rcond=None)[0]
    np.testing.assert_allclose(
        WangMendel(learner="ridge", ridge=penalty).fit(X, Y).system_.consequents,
        expected,
        rtol=1e-10,
    )


def test_ridge_goes_from_least_squares_to_the_average() -> None:
    X, Y = corners_and_more(outputs=1)
    shares = [
        WangMendel(kind="t1", learner="ridge", ridge=ridge).fit(X, Y)
        for ridge in (1e-9, 1e-3, 1.0, 1e9)
    ]
    errors = [float(((model.predict(X) - Y) ** 2).sum()) for model in shares]
    assert errors == sorted(errors)
    average = WangMendel(learner="average").fit(X, Y).system_.consequents
    # A penalty of 1e9 leaves a billionth of the step to least squares.
    np.testing.assert_allclose(shares[-1].system_.consequents, average, atol=1e-7)
    # What the type-1 system can express is found: 1e-9 is the penalty, times steps of order 1 and
    # the condition of the problem.
    truth = WangMendel(kind="t1").fit(X, Y)
    again = WangMendel(kind="t1", learner="ridge", ridge=1e-12).fit(X, truth.predict(X))
    np.testing.assert_allclose(again.predict(X), truth.predict(X), atol=1e-8)


def test_doubling_the_samples_changes_no_learner() -> None:
    """The ridge penalty is weighed against a mean.

    So it does not fade with the number of samples; 1e-12 for the sums' order.
    """
    X, Y = corners_and_more()
    for learner in ("strongest", "strict", "average", "ridge"):
        once = WangMendel(learner=learner).fit(X, Y).system_.consequents
        twice = (
            WangMendel(learner=learner)
            .fit(np.concatenate([X, X]), np.concatenate([Y, Y]))
            .system_.consequents
        )
        np.testing.assert_allclose(twice, once, atol=1e-12)


L_SHAPE = np.array([[0.0, 0.0], [0.0, 1.0], [0.0, 2.0], [1.0, 0.0], [2.0, 0.0]])


def test_nearest_completion_copies_the_nearest_rule_of_the_highest_degree() -> None:
    """Four cells of a 3 x 3 grid have no sample.

    By hand: (1, 1) is one step from (0, 1) and (1, 0), both of degree 1 as it stands.
    """
    samples, values = L_SHAPE.copy(), np.array([10.0, 11.0, 12.0, 13.0, 14.0])
    model = WangMendel(n_terms=3, learner="strict", kind="t1").fit(samples, values)
    cells = as_dictionary(model.system_.rules, model.system_.consequents[:, 0])
    assert [cells[cell] for cell in ((0, 0), (0, 1), (0, 2), (1, 0), (2, 0))] == [
        10.0,
        11.0,
        12.0,
        13.0,
        14.0,
    ]
    assert cells[1, 2] == 12.0
    assert cells[2, 1] == 14.0
    # (0, 2) and (2, 0) are equally far and equally strong: the first one
    assert cells[2, 2] == 12.0
    assert cells[1, 1] == 11.0
    assert (model.rule_samples_ == -1).sum() == 4
    samples[1] = [0.0, 1.1]  # now the other neighbor of (1, 1) has the higher degree
    model = WangMendel(n_terms=3, learner="strict", kind="t1").fit(samples, values)
    assert as_dictionary(model.system_.rules, model.system_.consequents[:, 0])[1, 1] == 13.0


def test_average_completion_weighs_with_inverse_squares_of_distance() -> None:
    values = np.array([10.0, 11.0, 12.0, 13.0, 14.0])
    model = WangMendel(n_terms=3, learner="strict", completion="average", kind="t1").fit(
        L_SHAPE, values
    )
    cells = as_dictionary(model.system_.rules, model.system_.consequents[:, 0])
    # By hand, of cell (2, 2): squared distances 8, 5, 4, 5, 4 in grid steps, from the samples in
    # their order.
    weights = 1.0 / np.array([8.0, 5.0, 4.0, 5.0, 4.0])
    assert cells[2, 2] == pytest.approx(weights @ values / weights.sum(), rel=1e-14)
    assert cells[0, 1] == 11.0


@pytest.mark.parametrize("completion", ["nearest", "average"])
def test_distances_between_cells_are_shares_of_the_ranges(completion: str) -> None:
    """Two terms of one input and five of the other, so that steps of the grid are unlike shares.

    Of cell (0, 3) the rule at (0, 0) is three steps off but 0.75 of a range, that at (1, 4) 1.4
    steps but 1.03 of a range. Distances here are those of the terms' means.
    """
    samples, values = np.array([[0.0, -2.0], [5.0, 10.0]]), np.array([10.0, 20.0])
    model = WangMendel(n_terms=[2, 5], learner="strict", completion=completion, kind="t1").fit(
        samples, values
    )
    means = [np.array([term.mean for term in terms]) for terms in model.system_.inputs]
    shares = np.stack(
        [
            (means[i][model.system_.rules[:, i]] - samples[0, i]) / np.ptp(samples[:, i])
            for i in range(2)
        ],
        axis=1,
    )
    squares = ((shares[:, np.newaxis] - np.array([[0.0, 0.0], [1.0, 1.0]])) ** 2).sum(axis=-1)
    if completion == "nearest":
        expected = values[squares.argmin(axis=1)]
        tied = np.isclose(*squares.T)
        expected[tied] = values[0]  # equally near and equally strong: the first one
        assert as_dictionary(model.system_.rules, model.system_.consequents[:, 0])[0, 3] == 10.0
    else:
        weights = 1.0 / np.maximum(squares, 1e-300)  # its own rule is all that counts in a cell
        expected = weights @ values / weights.sum(axis=1)
    np.testing.assert_allclose(model.system_.consequents[:, 0], expected, rtol=1e-13)


def test_completion_with_output_terms() -> None:
    values = np.array([10.0, 11.0, 12.0, 13.0, 14.0])
    nearest = WangMendel(n_terms=3, learner="strict", output_terms=5).fit(L_SHAPE, values)
    assert (nearest.output_rules_ >= 0).all()
    averaged = WangMendel(n_terms=3, learner="strict", output_terms=5, completion="average").fit(
        L_SHAPE, values
    )
    empty = averaged.output_rules_[:, 0] < 0
    assert empty.sum() == 4
    np.testing.assert_array_equal(
        nearest.system_.consequents[~empty], averaged.system_.consequents[~empty]
    )
    assert (
        averaged.system_.consequents[empty, 0, 1] > averaged.system_.consequents[empty, 0, 0]
    ).all()
    assert averaged.system_.consequents[:, 0].min() >= nearest.system_.consequents.min()


def test_strict_fills_few_cells_of_a_curve_and_the_default_all() -> None:
    """A helix visits 6 of 16 cells when positions and speeds are the inputs.

    That is the reason for the default.
    """
    t = np.linspace(0.0, 2.0 * np.pi, 200)
    X = np.stack([np.sin(t), np.sin(t + 2.0), np.cos(t), np.cos(t + 2.0)], axis=1)
    strict = WangMendel(learner="strict", completion="none").fit(X, t)
    assert len(strict.system_.rules) < 16
    assert len(WangMendel(learner="strict").fit(X, t).system_.rules) == 16
    default = WangMendel().fit(X, t)
    assert len(default.system_.rules) == 16
    assert default.best_firing_.min() > 1e-3
    assert not default.system_.validate(domain=[[-1.0, 1.0]] * 4, points=7).unused_terms


def test_a_rule_that_no_sample_fires_is_named_with_its_firing() -> None:
    """Two corners of a 3 x 3 grid.

    Each of the other corners is two terms away in one input, which makes 16**-4 of 1 by hand.
    """
    with pytest.raises(
        UnsupportedRule, match=r"rule 3 \(IF x1 is Low and x2 is High\).*1.53e-05.*2 such rules"
    ) as caught:
        WangMendel(n_terms=3, completion="refuse").fit([[0.0, 0.0], [2.0, 2.0]], [1.0, 2.0])
    assert caught.value.firing == pytest.approx(16.0**-4, rel=1e-12)
    # With two terms a cell is one away, and 1/16 is enough.
    assert WangMendel().fit(
        [[0.0, 0.0], [2.0, 2.0]], [1.0, 2.0]
    ).best_firing_.min() == pytest.approx(1.0 / 16.0, rel=1e-12)


@pytest.mark.parametrize("learner", ["strongest", "average", "ridge"])
def test_rules_without_samples_are_completed_with_a_count(learner: str) -> None:
    """Two samples in opposite corners of a grid of nine: two corners are fired by 16**-4 of each.

    Both are equally near to rules of the edges, of which the first has the first sample.
    """
    X, y = [[0.0, 0.0], [2.0, 2.0]], [1.0, 2.0]
    with pytest.warns(CompletedRules, match=r"2 of 9 rules .*\(completion='nearest'") as caught:
        model = WangMendel(n_terms=3, learner=learner, kind="t1").fit(X, y)
    assert (caught[0].message.count, caught[0].message.total) == (2, 9)
    values = model.system_.consequents[:, 0]
    neighbors = [values[r] for r in (1, 5)]  # Low-Mid and Mid-High, beside Low-High
    nearby = 0.1 if learner == "ridge" else 1e-12
    assert min(abs(values[2] - value) for value in neighbors) < nearby
    with pytest.warns(CompletedRules, match="left out"):
        smaller = WangMendel(n_terms=3, learner=learner, completion="none").fit(X, y)
    assert len(smaller.system_.rules) == 7
    with pytest.warns(CompletedRules, match="'average'"):
        averaged = WangMendel(n_terms=3, learner=learner, completion="average").fit(X, y)
    assert 1.0 < averaged.system_.consequents[2, 0] < 2.0


def test_blocks_of_samples_change_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """1e-12: sums are added in another order."""
    X, Y = corners_and_more()
    options: list[dict[str, Any]] = [
        {"learner": name} for name in ("strongest", "strict", "average", "ridge")
    ]
    whole = [WangMendel(**option).fit(X, Y) for option in options]
    monkeypatch.setattr("fuzzy2.learning.consequents._BLOCK", 28)  # seven samples
    for option, before in zip(options, whole, strict=True):
        after = WangMendel(**option).fit(X, Y)
        np.testing.assert_allclose(
            after.system_.consequents, before.system_.consequents, rtol=0.0, atol=1e-12
        )
        np.testing.assert_array_equal(after.best_firing_, before.best_firing_)


def test_the_first_of_equally_strong_samples_stays_across_blocks(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The same two inputs four times over, with other outputs, one sample in a block."""
    X = np.tile([[0.0], [1.0]], (4, 1))
    y = np.arange(8.0)
    monkeypatch.setattr("fuzzy2.learning.consequents._BLOCK", 1)
    model = WangMendel(n_terms=2, learner="strongest", kind="t1").fit(X, y)
    np.testing.assert_array_equal(model.rule_samples_[:, 0], [0, 1])
    np.testing.assert_array_equal(model.system_.consequents[:, 0], [0.0, 1.0])
