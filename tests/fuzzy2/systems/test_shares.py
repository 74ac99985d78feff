"""Shares of rules in outputs: what they are shares of adds up to the output."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from numpy.typing import NDArray

import fuzzy2
from fuzzy2.systems.shares import in_average, shares_of
from tests.fuzzy2.systems.by_hand import GRID_RULES, gaussian, uncertain

Array = NDArray[np.float64]


def test_of_a_type_1_average_the_shares_are_the_weights(consequents: Array, X: Array) -> None:
    """Products of grades by hand; the outputs are what the shares add up to, to 1e-13."""
    system = fuzzy2.Type1System(gaussian(), GRID_RULES, consequents)
    for x in X[:20]:
        grades = [
            [float(term(value)) for term in terms]
            for value, terms in zip(x, gaussian(), strict=True)
        ]
        firing = np.array([np.prod([grades[i][t] for i, t in enumerate(r)]) for r in GRID_RULES])
        shares = system.explain(x).shares
        np.testing.assert_allclose(shares[:, 2], firing / firing.sum(), atol=1e-14)
        np.testing.assert_allclose((shares * consequents).sum(axis=0), system(x), atol=1e-13)


def test_at_both_ends_of_an_interval_system_they_are_the_best_of_all_choices(X: Array) -> None:
    """Enumerated: of all choices of lower and upper weights those of the least and greatest."""
    points = np.array([-1.0, 0.5, 2.0, 0.1])
    rng = np.random.default_rng(2)
    for _ in range(20):
        weights = np.sort(rng.random((4, 2)), axis=1)
        choices = [
            np.array([w[c] for w, c in zip(weights, choice, strict=True)])
            for choice in itertools.product((0, 1), repeat=4)
        ]
        shares = [one / one.sum() for one in choices]
        ends = [min(shares, key=lambda s: s @ points), max(shares, key=lambda s: s @ points)]
        found = in_average(np.stack([points, points], axis=1), np.log(weights), "eiasc")
        np.testing.assert_allclose(found, 0.5 * (ends[0] + ends[1]), atol=1e-14)
    system = fuzzy2.IntervalType2System(uncertain(), GRID_RULES, np.arange(8.0)[:, None])
    found = system.explain(X[0]).shares[:, 0]
    # Crisp consequents: the middle of both ends is the average by the mean shares.
    np.testing.assert_allclose(found @ np.arange(8.0), system(X[0])[0], atol=1e-13)


@pytest.mark.parametrize("method", ["nie_tan", "begian_melek_mendel"])
def test_of_direct_methods_they_are_the_weights_of_their_equations(
    method: str, consequents: Array, X: Array
) -> None:
    system = fuzzy2.IntervalType2System(
        uncertain(), GRID_RULES, consequents, method=method, shares=(0.3, 0.7)
    )
    for x in X[:10]:
        found = (system.explain(x).shares * consequents).sum(axis=0)
        np.testing.assert_allclose(found, system(x), atol=1e-13)


def test_where_all_lower_weights_are_zero_the_ends_are_single_points() -> None:
    weights = np.array([[0.0, 0.5], [0.0, 0.1], [0.0, 0.0]])
    points = np.array([[1.0, 1.0], [1.0 / 3.0, 1.0 / 3.0], [-5.0, -5.0]])
    with np.errstate(divide="ignore"):
        logarithms = np.log(weights)
    np.testing.assert_allclose(in_average(points, logarithms, "eiasc"), [0.5, 0.5, 0.0])


def two_triangles(reduction: str, aggregation: str) -> fuzzy2.Type1System:
    flat = fuzzy2.Trapezoidal(-1.0, 0.0, 1.0, 2.0)
    sets = [[fuzzy2.Triangular(0.0, 1.0, 2.0)], [fuzzy2.Triangular(1.0, 2.0, 3.0)]]
    return fuzzy2.Type1System(
        [[flat, flat]],
        [[0], [1]],
        sets,
        "product",
        type_reduction=reduction,
        t_conorm=aggregation,
        weights=[1.0, 0.5],
    )


def test_of_summed_sets_they_are_the_areas() -> None:
    """Areas 1 and 1/2; 1e-6 of the trapezoid's rule on 4000 steps."""
    system = two_triangles("centroid", "sum")
    shares = system.explain([0.5]).shares[:, 0]
    np.testing.assert_allclose(shares, [2.0 / 3.0, 1.0 / 3.0], atol=1e-6)
    np.testing.assert_allclose(shares @ [1.0, 2.0], system([0.5])[0], atol=1e-6)


def test_of_united_sets_they_are_the_areas_in_which_they_are_highest() -> None:
    """Sides 2 - x and (x - 1) / 2 meet at 5/3, where both are 1/3.

    The first has 1/2 before 1 and 1/2 - 1/18 from 1 to 5/3, the second 1/2 - 1/12 - ... by hand:
    from 5/3 to 2 the trapezoid 1/3 * (1/3 + 1/2) / 2 and then 1/4. To 1e-3 of the grid's step.
    """
    first, second = 0.5 + 0.5 - (1.0 / 3.0) ** 2 / 2.0, (1.0 / 3.0) * (5.0 / 6.0) / 2.0 + 0.25
    shares = two_triangles("centroid", "max").explain([0.5]).shares[:, 0]
    expected = np.array([first, second]) / (first + second)
    np.testing.assert_allclose(shares, expected, atol=1e-3)


def test_of_single_points_that_are_united_they_are_the_heights() -> None:
    flat = fuzzy2.Trapezoidal(-1.0, 0.0, 1.0, 2.0)
    system = fuzzy2.Type1System(
        [[flat, flat]],
        [[0], [1]],
        [[fuzzy2.Singleton(1.0)], [fuzzy2.Singleton(0.5)]],
        type_reduction="centroid",
        weights=[0.75, 0.25],
    )
    shares = shares_of(system, np.array([[0.5]]), np.log(system.firing([0.5])), False)
    np.testing.assert_allclose(shares[:, 0], [0.75, 0.25])


def test_rules_that_say_nothing_have_no_share() -> None:
    terms = {"Low": fuzzy2.Triangular(-1.0, 0.0, 1.0), "High": fuzzy2.Triangular(0.0, 1.0, 2.0)}
    system = fuzzy2.Type1System(
        {"a": terms},
        "IF a is Low THEN p is on\nIF a is High THEN p is off and q is on",
        {"p": {"on": 1.0, "off": 0.0}, "q": {"on": 1.0}},
    )
    np.testing.assert_allclose(system.explain([0.25]).shares, [[0.75, 0.0], [0.25, 1.0]])


def test_of_general_type_2_they_are_those_of_the_planes(X: Array) -> None:
    terms = [
        [fuzzy2.GaussianType2Set(fuzzy2.Gaussian(m, 0.7), 0.1) for m in (-1.0, 0.5)]
        for _ in range(3)
    ]
    said = np.arange(8.0)[:, None]
    system = fuzzy2.GeneralType2System(terms, GRID_RULES, said)
    shares = system.explain(X[0]).shares[:, 0]
    np.testing.assert_allclose(shares.sum(), 1.0, atol=1e-13)
    np.testing.assert_allclose(shares @ said[:, 0], system(X[0])[0], atol=1e-12)


def test_far_from_all_rules_the_shares_still_add_up(consequents: Array) -> None:
    """Grades are floats there, and their products are none."""
    system = fuzzy2.Type1System(gaussian(), GRID_RULES, consequents)
    explanation = system.explain([22.0, -22.0, 22.0])
    assert not explanation.firing.any()
    np.testing.assert_allclose(explanation.shares.sum(axis=0), 1.0, atol=1e-12)
