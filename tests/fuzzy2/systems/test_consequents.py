"""What rules conclude: intervals, linear functions and sets."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

import fuzzy2
from fuzzy2.errors import InvalidValue
from fuzzy2.systems import IntervalType2System, Linear
from fuzzy2.systems.consequents import Formulas, OutputOf
from tests.fuzzy2.systems.by_hand import (
    GRID_RULES,
    uncertain,
)

Array = NDArray[np.float64]


def test_interval_consequents_and_many_scales(X: Array) -> None:
    """Intervals as consequents, against the generalized centroid.

    With outputs from 1e-9 to 1e9 in one rule base.
    """
    rng = np.random.default_rng(5)
    scales = 10.0 ** np.arange(-9, 10, 3)
    z = np.sort(rng.normal(size=(8, scales.size, 2)), axis=-1) * scales[:, np.newaxis]
    system = IntervalType2System(uncertain(), GRID_RULES, z)
    firing = system.firing(X)
    for j, scale in enumerate(scales):
        expected = fuzzy2.generalized_centroid(z[:, j], firing, "scan")
        np.testing.assert_allclose(
            system.type_reduced(X)[:, j],
            expected,
            rtol=0.0,
            atol=1e-12 * scale * np.abs(z[:, j] / scale).max(),
        )


def test_symmetric_consequents_center_of_sets_is_height(X: Array) -> None:
    """For normal, convex, symmetric consequents both take the same points (after eq. 1.78).

    1e-10 is the centroid's quadrature.
    """
    sets = [fuzzy2.Gaussian(mean=m, sigma=0.3) for m in np.linspace(-2.0, 2.0, 8)]
    by_sets, by_height = (
        IntervalType2System(uncertain(), GRID_RULES, sets, type_reduction=name)
        for name in ("center_of_sets", "height")
    )
    np.testing.assert_allclose(by_sets.type_reduced(X), by_height.type_reduced(X), atol=1e-10)


def test_linear_consequents(X: Array) -> None:
    """TSK: with exact linear consequents that agree the output is that function.

    It is that linear function whatever fires; 1e-12.
    """
    slopes = np.array([[0.5, 1.0, -2.0, 0.25]])
    system = IntervalType2System(
        uncertain(), GRID_RULES, Linear(np.broadcast_to(slopes, (8, 1, 4)))
    )
    np.testing.assert_allclose(system(X)[:, 0], 0.5 + X @ [1.0, -2.0, 0.25], atol=1e-12)
    rng = np.random.default_rng(7)
    coefficients, spreads = rng.normal(size=(8, 2, 4)), 0.1 * rng.random((8, 2, 4))
    system = IntervalType2System(uncertain(), GRID_RULES, Linear(coefficients, spreads))
    x = X[0]
    firing = system.firing(x)
    for j in range(2):
        middle = coefficients[:, j] @ [1.0, *x]
        half = spreads[:, j] @ [1.0, *np.abs(x)]
        expected = fuzzy2.generalized_centroid(np.stack([middle - half, middle + half], -1), firing)
        np.testing.assert_allclose(system.type_reduced(x)[j], expected, atol=1e-12)


def formulas_by_hand(x: float, y: float) -> tuple[float, float]:
    """Return the outputs of the system below, worked out."""
    low, high = max(0.0, 1.0 - x / 2.0), max(0.0, min(1.0, x / 2.0))
    first = (low * math.sin(x * y) + high * 3.0) / (low + high)
    return first, (high * (x - y**2)) / high


def with_formulas() -> fuzzy2.Type1System:
    terms = [fuzzy2.Triangular(-2.0, 0.0, 2.0), fuzzy2.Triangular(0.0, 2.0, 4.0)]
    return fuzzy2.Type1System(
        [terms, []],
        [[0, -1], [1, -1]],
        Formulas([["sin(x*y)", "1/(x - x)"], ["3", "x - y^2"]], ("x", "y")),
        silent=[[False, True], [False, False]],
        input_names=["x", "y"],
        input_ranges=[(0.0, 2.0), (0.0, 2.0)],
    )


def test_formulas_against_numbers_by_hand() -> None:
    """What a silent rule would say, here nothing, has no part in the output."""
    system = with_formulas()
    for x, y in np.random.default_rng(0).uniform(0.1, 1.9, (50, 2)):
        np.testing.assert_allclose(system([x, y]), formulas_by_hand(x, y), rtol=1e-13)
    again = fuzzy2.from_json(fuzzy2.to_json(system))
    np.testing.assert_array_equal(again([0.5, 1.5]), system([0.5, 1.5]))
    assert "sin(x*y)" in str(system.explain([0.5, 1.5]))
    # By differences, for there is no formula for the derivatives of formulas.
    np.testing.assert_allclose(system.gradient([0.5, 1.5])[1], [1.0, -3.0], rtol=1e-5)


def test_a_formula_without_a_number_counts_only_if_its_rule_fires() -> None:
    terms = [fuzzy2.Interval(0.0, 1.0), fuzzy2.Interval(2.0, 3.0)]
    system = fuzzy2.Type1System(
        [terms], [[0], [1]], Formulas([["log(x - 1)"], ["1/(x - 2.5)"]], ["x"]), input_names=["x"]
    )
    got = system([[0.5], [2.0], [2.5]])[:, 0]
    assert math.isnan(got[0])
    assert got[1] == -2.0
    assert got[2] == math.inf


def test_a_formula_may_ask_for_the_output_of_another_system() -> None:
    first = with_formulas()
    terms = [[fuzzy2.Interval(0.0, 4.0)], []]
    asking = Formulas([["10*z + x"]], ("x", "y"), {"z": OutputOf(first, 1)})
    ranges = [(0.0, 4.0), (0.0, 4.0)]
    system = fuzzy2.Type1System(
        terms, [[0, -1]], asking, input_names=["x", "y"], input_ranges=ranges
    )
    expected = 10.0 * formulas_by_hand(0.5, 1.5)[1] + 0.5
    assert system([0.5, 1.5])[0] == pytest.approx(expected, rel=1e-14)
    again = fuzzy2.from_json(fuzzy2.to_json(system))
    assert again([0.5, 1.5])[0] == system([0.5, 1.5])[0]


def test_formulas_that_do_not_fit() -> None:
    with pytest.raises(InvalidValue, match="a name in a formula"):
        Formulas([["x + z"]], ["x"])
    with pytest.raises(InvalidValue, match="rows with a formula for each output"):
        Formulas([["x"], ["x", "1"]], ["x"])
    with pytest.raises(InvalidValue, match="formulas for 1 rules, and 1 names"):
        fuzzy2.Type1System([[fuzzy2.Interval(0.0, 1.0)]], [[0]], Formulas([["x"]], ["x", "y"]))
