"""Premises as parameters: against systems that say the same, and finite differences."""

from __future__ import annotations

import numpy as np
import pytest

from fuzzy2.learning.premises import Premises
from fuzzy2.sets.interval_type2 import GaussianUncertainMean
from fuzzy2.systems import IntervalType2System, Linear

OWNERS = np.array([0, 0, 0, 1, 1])
RULES = np.array([[0, 3], [1, 3], [1, 4], [2, 4]])


def problem(reach: float) -> tuple[Premises, np.ndarray, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(7)
    premises = Premises(OWNERS, RULES, np.full(5, reach))
    parameters = np.concatenate([[-1.0, 0.1, 0.9, -0.8, 0.7], rng.normal(-0.5, 0.2, 5)])
    return premises, parameters, rng.uniform(-1.5, 1.5, (60, 2)), rng.normal(size=(4, 3))


def output(premises: Premises, parameters: np.ndarray, X: np.ndarray, c: np.ndarray) -> np.ndarray:
    constant = np.column_stack([np.ones(len(X)), X])
    ends = premises.ends(premises.grades(parameters, X), constant @ c.T)
    return premises.basis(ends, constant) @ c.ravel()


@pytest.mark.parametrize("reach", [0.0, 0.15])
def test_output_is_that_of_a_system(reach: float) -> None:
    """Compiled exact reduction of a few numbers of order 1; 1e-12 is rounding."""
    premises, parameters, X, c = problem(reach)
    means, sigmas = parameters[:5], np.exp(parameters[5:])
    terms = [
        [GaussianUncertainMean((means[t] - reach, means[t] + reach), sigmas[t]) for t in own]
        for own in ([0, 1, 2], [3, 4])
    ]
    system = IntervalType2System(terms, RULES - [0, 3], Linear(c[:, np.newaxis]))
    np.testing.assert_allclose(
        output(premises, parameters, X, c), system(X)[:, 0], rtol=0.0, atol=1e-12
    )


@pytest.mark.parametrize("reach", [0.0, 0.15])
def test_slopes_are_those_of_finite_differences(reach: float) -> None:
    """Central differences with a step of 1e-6: 1e-9 of truncation and rounding, times 100.

    No sample lies within a step of a kink.
    """
    premises, parameters, X, c = problem(reach)
    z = np.column_stack([np.ones(len(X)), X]) @ c.T
    grades = premises.grades(parameters, X)
    slopes = premises.slopes(parameters, grades, premises.ends(grades, z), z)
    for k in range(len(parameters)):
        step = np.zeros(len(parameters))
        step[k] = 1e-6
        difference = output(premises, parameters + step, X, c) - output(
            premises, parameters - step, X, c
        )
        np.testing.assert_allclose(slopes[:, k], difference / 2e-6, rtol=0.0, atol=1e-7)
    assert (np.abs(slopes).max(axis=0) > 1e-3).all()


@pytest.mark.parametrize("reach", [0.0, 0.15])
def test_far_away_the_nearest_rule_decides(reach: float) -> None:
    """All firing underflows there: a hundred standard deviations off."""
    premises, parameters, _, c = problem(reach)
    parameters[5:] = 0.0
    far = np.array([[-200.0, -200.0]])
    expected = c[0] @ [1.0, -200.0, -200.0]
    assert output(premises, parameters, far, c)[0] == pytest.approx(expected, rel=1e-12)
