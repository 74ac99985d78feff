"""Products of many small grades, beside exact rational products."""

from __future__ import annotations

from fractions import Fraction

import numpy as np

import fuzzy2
from fuzzy2.systems import IntervalType2System, Type1System
from fuzzy2.systems.relative_firing import relative_firing

INPUTS = 50


def test_products_that_underflow_still_have_ratios() -> None:
    """Grades of 1e-8 in fifty inputs: 1e-400, and the output is that of exact products."""
    rng = np.random.default_rng(0)
    terms = [[fuzzy2.Gaussian(0.0, 1.0), fuzzy2.Gaussian(0.05, 1.01)]] * INPUTS
    rules = rng.integers(0, 2, (6, INPUTS))
    consequents = rng.normal(size=(6, 1))
    x = rng.uniform(6.0, 6.2, INPUTS)
    products = []
    for rule in rules:
        product = Fraction(1)
        for i, t in enumerate(rule):
            product *= Fraction(float(terms[i][t](x[i])))
        products.append(product)
    assert float(max(products)) == 0.0
    exact = sum(p * Fraction(float(z)) for p, z in zip(products, consequents[:, 0], strict=True))
    expected = float(exact / sum(products))
    for kind in (Type1System, IntervalType2System):
        system = kind(terms, rules, consequents)
        np.testing.assert_allclose(system(x), [expected], rtol=1e-9)
        np.testing.assert_allclose(system(np.tile(x, (300, 1))), [[expected]] * 300, rtol=1e-9)
        slow = system.replace(method="nie_tan")
        np.testing.assert_allclose(slow(x), [expected], rtol=1e-9)
        assert not system.firing(x).any()


def test_weights_multiply_and_zeros_stay() -> None:
    grades = [np.array([[[0.5, 1.0], [0.0, 0.0]]])]
    found = relative_firing(grades, np.array([[0], [0], [1]]), np.array([1.0, 0.5, 1.0]))
    np.testing.assert_allclose(found, [[[0.5, 1.0], [0.25, 0.5], [0.0, 0.0]]])
