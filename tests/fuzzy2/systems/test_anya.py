"""Rules that ask how dense clouds of data are about an input, by hand and as JFML answers."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pandas as pd
import pytest

from fuzzy2 import AnYaSystem, Gaussian, Trapezoidal, Triangular, Type1System, from_json, to_json
from fuzzy2.errors import InvalidValue, ReadOnly
from fuzzy2.systems.antecedents import Is, Not

FIRING = Trapezoidal(0.0, 1.0, math.inf, math.inf)
CLOUDS = ([1.0, 1.7, 4.0, 3.2], [6.0, 5.7, 7.0], [8.0])
ASKED = (0, 1, 2, 1)
SETS = (Triangular(0.0, 5.0, 10.0), Triangular(5.0, 10.0, 15.0), Triangular(10.0, 15.0, 20.0))


def consequents(**options: Any) -> Type1System:
    """Return rules of four firings, the last of which is asked for with *else*, too."""
    rules: Any = [Is(0, 0), Is(1, 0), Is(2, 0), Is(3, 0), Not(Is(3, 0))]
    said = [[SETS[i]] for i in (0, 1, 2, 2, 0)]
    # Where and how a sum of 2001 points from 0 to 20 is taken.
    chosen = {"integration": "sum", "resolution": 2001, "type_reduction": "centroid", **options}
    return Type1System(
        [[FIRING]] * 4, rules, said, output_names=["tip"], output_ranges=[(0.0, 20.0)], **chosen
    )


def by_hand(x: Any, weights: tuple[float, ...], product: bool) -> float:
    """Return the output, one rule and one point after the other."""
    densities = []
    for cloud in ASKED:
        distance = 0.0
        for datum in CLOUDS[cloud]:
            distance += abs(datum - x[cloud])
        densities.append(len(CLOUDS[cloud]) / (len(CLOUDS[cloud]) + distance))
    fired = [w * d / sum(densities) for w, d in zip(weights, densities, strict=True)]
    pairs = [*zip(fired, (0, 1, 2, 2), strict=True), (1.0 - fired[3], 0)]
    moment = area = 0.0
    for k in range(2001):
        at, grade = 20.0 * k / 2000, 0.0
        for firing, number in pairs:
            peak = (5.0, 10.0, 15.0)[number]
            membership = max(0.0, 1.0 - abs(at - peak) / 5.0)
            grade = max(grade, firing * membership if product else min(firing, membership))
        moment, area = moment + at * grade, area + grade
    return moment / area


@pytest.mark.parametrize("product", [False, True])
@pytest.mark.parametrize("weights", [(1.0, 1.0, 1.0, 1.0), (0.3, 1.0, 0.7, 1.0)])
def test_firing_and_output_by_hand(product: bool, weights: tuple[float, ...]) -> None:
    system = AnYaSystem(
        CLOUDS,
        ASKED,
        consequents(implication="product" if product else "min", weights=[*weights, 1.0]),
    )
    X = np.random.default_rng(0).uniform(-5.0, 15.0, (12, 3))
    expected = [by_hand(x, weights, product) for x in X.tolist()]
    np.testing.assert_allclose(system(X)[:, 0], expected, rtol=1e-12)
    shares = system.relative_densities(X.reshape(3, 4, 3))
    assert shares.shape == (3, 4, 4)
    np.testing.assert_allclose(shares.sum(axis=-1), 1.0, rtol=1e-14)
    np.testing.assert_array_equal(from_json(to_json(system))(X), system(X))


def test_inputs_by_name() -> None:
    system = AnYaSystem(CLOUDS, ASKED, consequents(), ["food", "service", "quality"])
    x = [2.0, 5.0, 7.0]
    np.testing.assert_array_equal(system(service=5.0, quality=7.0, food=2.0), system(x))
    frame = pd.DataFrame([x[::-1]], columns=["quality", "service", "food"], index=[7])
    answer: Any = system(frame)
    assert (list(answer.columns), list(answer.index)) == (["tip"], [7])
    assert answer["tip"][7] == system(x)[0]
    assert system.output_names == ("tip",)
    assert repr(system).startswith("AnYaSystem(3 clouds, Type1System(4 inputs")
    assert from_json(to_json(system)).input_names == system.input_names


def test_what_is_refused() -> None:
    wrong: list[tuple[Any, ...]] = [
        ([[1.0], []], ASKED, consequents()),
        ([[1.0], [math.nan]], ASKED, consequents()),
        (CLOUDS, (0, 1, 2, 3), consequents()),
        (CLOUDS, (0, 1), consequents()),
        (CLOUDS, ASKED, 3),
        (CLOUDS, ASKED, consequents(), ["x", "x", "y"]),
    ]
    for arguments in wrong:
        with pytest.raises(InvalidValue):
            AnYaSystem(*arguments)
    data = np.array([1.0, 2.0])
    one = AnYaSystem([data], [0], Type1System([[FIRING]], [[0]], [Gaussian(0.0, 1.0)]))
    data[0] = 5.0
    assert one.clouds[0][0] == 1.0
    for x in ([1.0, 2.0], [math.inf], 3.0):
        with pytest.raises(InvalidValue):
            one(x)
    with pytest.raises(InvalidValue, match="left out"):
        one([1.0], x1=1.0)
    with pytest.raises(ReadOnly):
        one.asked = (1,)


def linear_and_plain() -> list[AnYaSystem]:
    """Return systems whose consequents have a derivative by formula, and one that has none."""
    formula = [
        Type1System([[FIRING]] * 4, [Is(i, 0) for i in range(4)], [[2.0], [5.0], [-1.0], [3.0]]),
        Type1System(
            [[FIRING]] * 4,
            np.where(np.eye(4) > 0.0, 0, -1),
            [[SETS[i]] for i in (0, 1, 2, 2)],
            type_reduction="height",
        ),
    ]
    return [AnYaSystem(CLOUDS, ASKED, one) for one in [*formula, consequents(integration="exact")]]


@pytest.mark.parametrize("number", range(3))
def test_gradient_is_that_of_differences(number: int) -> None:
    """Central differences of the call away from data; 1e-6 is what a step of 1e-5 leaves."""
    system = linear_and_plain()[number]
    X = np.random.default_rng(1).uniform(-5.0, 15.0, (10, 3)) + 1e-3
    found = system.gradient(X)
    assert found.shape == (10, 1, 3)
    for j, step in enumerate(1e-5 * np.eye(3)):
        expected = (system(X + step) - system(X - step)) / 2e-5
        np.testing.assert_allclose(found[..., j], expected, atol=1e-6)
    np.testing.assert_array_equal(system.gradient(X[0]), found[0])
    assert system.gradient(X[:0]).shape == (0, 1, 3)


def test_gradient_at_a_datum_is_that_of_the_right_side() -> None:
    system = linear_and_plain()[1]
    x = np.array([1.7, 7.0, 8.0])
    for j, step in enumerate(1e-7 * np.eye(3)):
        expected = (system(x + step) - system(x)) / 1e-7
        np.testing.assert_allclose(system.gradient(x)[:, j], expected, atol=1e-5)


def test_explanation_names_inputs_and_adds_up() -> None:
    system = AnYaSystem(CLOUDS, ASKED, linear_and_plain()[1].consequents, ["food", "fun", "price"])
    x = [2.0, 5.0, 7.0]
    why = system.explain(x)
    np.testing.assert_allclose(why.shares[:, 0], system.relative_densities(x), rtol=1e-13)
    np.testing.assert_array_equal(why.outputs, system(x))
    np.testing.assert_array_equal(why.firing, system.firing(x))
    np.testing.assert_array_equal(why.reduced, system.type_reduced(x))
    said = str(why)
    assert "at food = 2, fun = 5, price = 7" in said
    assert "IF food is dense THEN y1 is Triangular" in said
    assert (np.diff(why.shares[why.ranking(), 0]) <= 0.0).all()
    assert why.pictured.x.tolist() == system.relative_densities(x).tolist()
    assert "<li>IF fun is dense" in system._repr_html_()
    with_else = AnYaSystem(CLOUDS, ASKED, consequents(), ["food", "fun", "price"])
    assert with_else.rules_in_words()[-1].startswith("IF fun is not dense THEN tip is")
    with pytest.raises(InvalidValue, match="one input"):
        system.explain([x, x])


def test_densities_hold_at_any_scale() -> None:
    """Twice the distance is half the density, whatever the unit; none is NaN."""
    two = Type1System([[FIRING]] * 2, [[0, -1], [-1, 0]], [[0.0], [1.0]])
    system = AnYaSystem([[0.0], [0.0]], [0, 1], two)
    for unit in (1e20, 1e300, 5e307):
        np.testing.assert_allclose(
            system.relative_densities([unit, 2.0 * unit]), [2.0 / 3.0, 1.0 / 3.0], rtol=1e-15
        )
    far = AnYaSystem([[-1.7e308]], [0], Type1System([[FIRING]], [[0]], [[1.0]]))
    assert far.relative_densities([1.7e308]) == 1.0
