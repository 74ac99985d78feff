"""The compiled loops of systems, against the same in numpy and row by row."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import fuzzy2
from fuzzy2.operations.t_norms import T_CONORMS, T_NORMS
from fuzzy2.systems import IntervalType2System, Type1System
from fuzzy2.systems.firing_kernels import _both, _either
from fuzzy2.systems.kernels import LANES
from fuzzy2.systems.table import CONORMS, NORMS
from tests.fuzzy2.systems.by_hand import (
    CENTERS,
    GRID_RULES,
    by_hand,
    gaussian,
    uncertain,
)

Array = NDArray[np.float64]

MANY = LANES + 7
"""More rows than the compiled loop takes at a time, and some that are left over."""


@pytest.mark.parametrize(
    "terms",
    [
        uncertain(),
        gaussian(),
        [
            [fuzzy2.GaussianUncertainSigma(mean=c, sigma=(0.5, 0.9)) for c in CENTERS]
            for _ in range(3)
        ],
        [[fuzzy2.Triangular(c - 2.5, c, c + 2.5) for c in CENTERS] for _ in range(3)],
        [
            [fuzzy2.Trapezoidal(c - 2.5, c - 0.5, c + 0.5, c + 2.5, height=0.9) for c in CENTERS]
            for _ in range(3)
        ],
        [
            [
                fuzzy2.Gaussian(mean=-1.0, sigma=1.0),
                fuzzy2.GaussianUncertainMean(mean=(0.5, 1.0), sigma=0.7),
            ]
            for _ in range(3)
        ],
    ],
)
@pytest.mark.parametrize("norm", NORMS)
def test_compiled_loop_and_numpy_agree(
    terms: list[list[object]], norm: str, consequents: Array, X: Array
) -> None:
    """The same system by the compiled loop and by the sets themselves, to 1e-13.

    The sets are used because a fuzzifier's detour is forced.
    """
    fast = IntervalType2System(terms, GRID_RULES, consequents, t_norm=norm)
    slow = IntervalType2System(terms, GRID_RULES, consequents, t_norm=norm)
    assert fast._fast
    slow._table, slow._fast = None, False
    np.testing.assert_allclose(fast.firing(X), slow.firing(X), atol=1e-15)
    np.testing.assert_allclose(fast.type_reduced(X), slow.type_reduced(X), atol=1e-13)


@pytest.mark.parametrize("norm", NORMS)
@pytest.mark.parametrize("crisp", [True, False])
def test_many_rows_give_what_each_row_gives(norm: str, crisp: bool) -> None:
    """To the last bit: rows side by side take the steps of a single row in the same order.

    The rows reach far out, where lower firing strengths vanish, firing strengths differ by more
    digits than a float has or all of them underflow, and consequents repeat, so that comparisons
    tie.
    """
    generator = np.random.default_rng(5)
    z = np.round(generator.normal(size=(8, 4)), 1)
    z[:, 1] = 1.0
    intervals = np.stack([z, z + np.abs(np.round(generator.normal(size=z.shape), 1))], axis=-1)
    X = np.concatenate(
        [
            generator.uniform(-2.0, 2.0, (200, 3)),
            generator.uniform(-40.0, 40.0, (150, 3)),
            np.zeros((5, 3)),
        ]
    )
    for consequents in (z, intervals):
        system = IntervalType2System(uncertain(), GRID_RULES, consequents, t_norm=norm)
        evaluate = system if crisp else system.type_reduced
        assert not system.firing(X)[..., 1].any(axis=1).all()
        np.testing.assert_array_equal(evaluate(X), np.array([evaluate(x) for x in X]))


def own_terms(kind: str, generator: np.random.Generator) -> list[list[Any]]:
    """Return six terms of each of three inputs, for rules that share none."""
    means, sigmas = generator.normal(size=(3, 6)), generator.uniform(0.4, 1.2, (3, 6))
    pairs = [list(zip(*rows, strict=True)) for rows in zip(means, sigmas, strict=True)]
    return [
        [
            fuzzy2.Gaussian(mean=m, sigma=s)
            if kind == "type-1" or (kind == "both" and s > 0.8)
            else fuzzy2.GaussianUncertainSigma(mean=m, sigma=(s, 1.5 * s))
            if kind == "sigma"
            else fuzzy2.GaussianUncertainMean(mean=(m, m + 0.2), sigma=s)
            for m, s in row
        ]
        for row in pairs
    ]


@pytest.mark.parametrize("kind", ["type-1", "mean", "sigma", "both"])
def test_rules_of_their_own_terms_fire_as_products_of_grades(kind: str) -> None:
    """The compiled loop adds exponents, the sets multiply grades: 1e-14 of a firing strength.

    Some rules leave inputs out, and far rows underflow; there, an exponential's error is that of
    its exponent. Many rows give to the last bit what each row gives.
    """
    generator = np.random.default_rng(8)
    terms, z = own_terms(kind, generator), generator.normal(size=(6, 4))
    rules = np.tile(np.arange(6)[:, np.newaxis], 3)
    rules[1, 0] = rules[4, 2] = -1
    X = np.concatenate(
        [generator.uniform(-2.0, 2.0, (MANY, 3)), generator.uniform(-60.0, 60.0, (MANY, 3))]
    )
    fast, slow = (IntervalType2System(terms, rules, z) for _ in range(2))
    assert fast._table is not None
    assert fast._table[6] == (1.0 if kind == "type-1" else 2.0)
    slow._table, slow._fast = None, False
    np.testing.assert_allclose(fast.firing(X), slow.firing(X), rtol=1e-14 * 60**2, atol=1e-300)
    near = X[:MANY]
    np.testing.assert_allclose(fast.firing(near), slow.firing(near), rtol=1e-14)
    np.testing.assert_allclose(fast.type_reduced(near), slow.type_reduced(near), atol=1e-13)
    for evaluate in (fast, fast.type_reduced):
        np.testing.assert_array_equal(evaluate(X), np.array([evaluate(x) for x in X]))


def test_grades_are_multiplied_where_rules_share_terms_or_a_term_is_no_gaussian() -> None:
    z = np.random.default_rng(9).normal(size=(6, 1))
    shared = Type1System(gaussian(), GRID_RULES, np.ones((len(GRID_RULES), 1)))
    terms = own_terms("type-1", np.random.default_rng(8))
    rules = np.tile(np.arange(6)[:, np.newaxis], 3)
    least = Type1System(terms, rules, z, t_norm="min")
    terms[1][2] = fuzzy2.Triangular(-1.0, 0.0, 1.0)
    for system in (shared, least, Type1System(terms, rules, z)):
        assert system.table is not None
        assert system.table[6] == 0.0


def test_many_rows_of_rules_with_weights_give_what_each_row_gives(consequents: Array) -> None:
    """To the last bit; they are not fired side by side."""
    weights = np.random.default_rng(2).uniform(0.1, 1.0, len(consequents))
    system = IntervalType2System(uncertain(), GRID_RULES, consequents, weights=weights)
    X = np.random.default_rng(6).uniform(-2.0, 2.0, (MANY, 3))
    expected = np.array([system.type_reduced(x) for x in X])
    np.testing.assert_array_equal(system.type_reduced(X), expected)


def test_compiled_norms_are_those_of_their_names() -> None:
    """To a few ulps, at grades where formulas divide 0 by 0, round or change their branch."""
    assert tuple(T_NORMS) == NORMS
    assert tuple(T_CONORMS) == CONORMS
    special = [0.0, 5e-324, 1e-300, 1e-17, 0.3, 0.5, 0.7, 1.0 - 2**-53, 1.0]
    grades = np.concatenate([special, np.random.default_rng(0).uniform(size=30)])
    for known, compiled in ((T_NORMS, _both), (T_CONORMS, _either)):
        for code, norm in enumerate(known.values()):
            expected = norm(grades[:, np.newaxis], grades)
            found = [[compiled(code, a, b) for b in grades.tolist()] for a in grades.tolist()]
            np.testing.assert_allclose(found, expected, rtol=4e-16, atol=0.0)


def test_a_function_with_the_name_of_a_norm_is_itself() -> None:
    def min(a: Array, b: Array) -> Array:
        return a * b

    terms = [[fuzzy2.Gaussian(0.0, 1.0)]] * 2
    system = Type1System(terms, [[0, 0]], [[1.0]], t_norm=min)
    assert system.firing([1.0, 1.0])[0, 0] == pytest.approx(np.exp(-1.0), rel=1e-15)


def test_many_rows_whose_lower_firing_strengths_all_vanish(consequents: Array) -> None:
    """Means so uncertain that every lower grade underflows to 0.

    Each end is that of the extreme consequent alone, exactly.

    Upper grades are 1 everywhere, so a rule may take any weight from 0 to 1.
    """
    system = IntervalType2System(uncertain(width=60.0), GRID_RULES, consequents)
    X = np.random.default_rng(6).uniform(-2.0, 2.0, (MANY, 3))
    assert (system.firing(X) == [0.0, 1.0]).all()
    extremes = np.stack([consequents.min(axis=0), consequents.max(axis=0)], axis=-1)
    np.testing.assert_array_equal(system.type_reduced(X), np.broadcast_to(extremes, (MANY, 4, 2)))


def test_many_rows_whose_end_is_a_consequent_itself() -> None:
    """One consequent lies on the end that all others make.

    So the comparison that finds the switch point ties, up to rounding.

    Many rows give to the last bit what one gives, and 1e-12 is the bar of exact reduction.
    """
    generator = np.random.default_rng(7)
    for x in generator.uniform(-2.0, 2.0, (20, 3)):
        z, k = generator.normal(size=(8, 1)), int(generator.integers(8))
        strengths, others = (
            IntervalType2System(uncertain(), GRID_RULES, z).firing(x),
            np.arange(8) != k,
        )
        z[k] = fuzzy2.generalized_centroid(z[others, 0], strengths[others])[0]
        system = IntervalType2System(uncertain(), GRID_RULES, z)
        found = system.type_reduced(np.tile(x, (MANY, 1)))
        np.testing.assert_array_equal(found, np.broadcast_to(system.type_reduced(x), found.shape))
        np.testing.assert_allclose(
            found[0], by_hand(uncertain(), GRID_RULES, z, x, "product"), rtol=0.0, atol=1e-12
        )
