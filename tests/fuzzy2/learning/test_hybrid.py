"""Hybrid learning: least squares inside, Gauss–Newton outside."""

from __future__ import annotations

import numpy as np
import pytest

from fuzzy2.learning.hybrid import Data, Learner
from fuzzy2.learning.premises import Premises

RULES = np.array([[0, 2], [0, 3], [1, 2], [1, 3]])
START = np.array([-1.0, 1.0, -1.0, 1.0, -0.2, 0.0, 0.1, -0.1])


def samples(count: int = 120) -> Data:
    rng = np.random.default_rng(3)
    X = rng.uniform(-1.5, 1.5, (count, 2))
    y = np.column_stack([np.sin(2.0 * X[:, 0]) * X[:, 1], np.abs(X[:, 0])])
    return Data(X, y, rng.uniform(0.5, 2.0, count))


def learner(reach: float = 0.0, ridge: float = 1e-6) -> Learner:
    premises = Premises(np.array([0, 0, 1, 1]), RULES, np.full(4, reach))
    return Learner(premises, samples(), ridge)


def test_consequents_are_those_of_weighted_ridge_regression() -> None:
    """Against the normal equations, whose condition takes six digits of sixteen."""
    learned, data = learner(), samples()
    state = learned.solved(START)
    means, sigmas = START[:4], np.exp(START[4:])
    grades = np.exp(-0.5 * ((data.X[:, [0, 0, 1, 1]] - means) / sigmas) ** 2)
    firing = grades[:, RULES[:, 0]] * grades[:, RULES[:, 1]]
    shares = firing / firing.sum(axis=1, keepdims=True)
    basis = (shares[:, :, None] * data.with_constant[:, None]).reshape(len(shares), -1)
    gram = basis.T @ (data.weights[:, None] * basis)
    gram += 1e-6 * data.weights.sum() * np.eye(len(gram))
    expected = np.linalg.solve(gram, basis.T @ (data.weights[:, None] * data.y))
    found = np.moveaxis(state.coefficients, 1, -1).reshape(12, 2)
    np.testing.assert_allclose(found, expected, rtol=1e-6, atol=1e-8)


@pytest.mark.parametrize("reach", [0.0, 0.1])
def test_the_objective_never_rises_and_ends_where_it_is_flat(reach: float) -> None:
    """Variable projection's gradient, by differences of the objective with consequents held.

    They are the best ones, so that by the envelope theorem theirs is no part of it. At the end it
    is a thousandth of what it was; an interval system has kinks and may end at one.
    """
    learned = learner(reach)
    start = learned.solved(START, np.zeros((4, 2, 3)))
    costs, state, damping = [start.cost], start, 1e-3
    while (found := learned._step(state, damping)) is not None and len(costs) < 200:
        state, damping = found
        costs.append(state.cost)
    assert (np.diff(costs) < 0.0).all()
    assert costs[-1] < 0.85 * costs[0]
    if reach == 0.0:
        slopes = [flatness(learned, at.parameters) for at in (start, state)]
        assert slopes[1] < 1e-3 * slopes[0]


def flatness(learned: Learner, parameters: np.ndarray) -> float:
    by_difference = []
    for k in range(len(parameters)):
        step = np.zeros(len(parameters))
        step[k] = 1e-5
        high, low = learned.solved(parameters + step), learned.solved(parameters - step)
        by_difference.append((high.cost - low.cost) / 2e-5)
    return float(np.abs(by_difference).max())


def test_descent_is_the_gradient_of_the_objective() -> None:
    """Half of it, with the sign turned; 1e-6 is the error of differences with a step of 1e-5."""
    learned = learner()
    state = learned.solved(START)
    descent = sum(
        (learned._root * learned.premises.slopes(START, state.grades, output.ends, output.z)).T
        @ output.residual
        for output in state.outputs
    )
    for k in range(len(START)):
        step = np.zeros(len(START))
        step[k] = 1e-5
        rise = learned.solved(START + step).cost - learned.solved(START - step).cost
        assert -2.0 * descent[k] == pytest.approx(rise / 2e-5, abs=1e-6 * state.cost)


def test_samples_held_back_choose_the_epoch() -> None:
    rng = np.random.default_rng(0)
    X = rng.uniform(-1.5, 1.5, (40, 2))
    noise = Data(X, rng.normal(size=(40, 1)), np.ones(40))
    fresh = Data(rng.uniform(-1.5, 1.5, (40, 2)), rng.normal(size=(40, 1)), np.ones(40))
    premises = Premises(np.array([0, 0, 1, 1]), RULES, np.zeros(4))
    learned = Learner(premises, noise, 1e-8)
    history = learned.learn(learned.solved(START), 100, fresh, 5)
    assert history.stopped_early
    assert history.validation_errors[history.best_epoch] == min(history.validation_errors)
    predicted = learned.predicted(history.state, fresh.X)
    assert fresh.error(predicted) == pytest.approx(min(history.validation_errors), rel=1e-12)
