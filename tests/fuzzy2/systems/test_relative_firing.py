"""Firing strengths that underflow, beside exact products and decimals of any exponent."""

from __future__ import annotations

import itertools
from decimal import Decimal, localcontext
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import fuzzy2
from fuzzy2.systems import GeneralType2System, IntervalType2System, Type1System
from fuzzy2.systems.relative_firing import log_grades, relative_firing, slopes_of_logarithms
from tests import examples

INPUTS = 50
MANY = 300


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
        np.testing.assert_allclose(system(np.tile(x, (MANY, 1))), [[expected]] * MANY, rtol=1e-9)
        slow = system.replace(method="nie_tan")
        np.testing.assert_allclose(slow(x), [expected], rtol=1e-9)
        assert not system.firing(x).any()


def far_system(seed: int, norm: str, certain: bool) -> tuple[IntervalType2System, np.ndarray]:
    """Return a system of Gaussians, and an input so far away that single grades are 0."""
    rng = np.random.default_rng(seed)
    terms = []
    for _ in range(2):
        means, sigmas = np.sort(rng.normal(size=(2, 2))), np.sort(rng.uniform(0.1, 1.0, (2, 2)))
        middle = [float(one) for one in means[0]]
        if certain:
            terms.append(
                [fuzzy2.Gaussian(m, float(s)) for m, s in zip(middle, sigmas[0], strict=True)]
            )
            continue
        terms.append(
            [
                fuzzy2.GaussianUncertainMean(tuple(map(float, means[1])), float(sigmas[0, 0])),
                fuzzy2.GaussianUncertainSigma(middle[0], tuple(map(float, sigmas[1]))),
            ]
        )
    rules = [[0, 0], [0, 1], [1, -1], [1, 1]]
    weights = rng.uniform(0.1, 1.0, 4) if rng.random() < 0.5 else None
    system = IntervalType2System(terms, rules, rng.normal(size=(4, 1)), norm, weights=weights)
    return system, rng.choice([-1.0, 1.0], 2) * 10.0 ** rng.uniform(1.7, 5.0, 2)


def firing_in_decimals(system: IntervalType2System, x: np.ndarray) -> list[list[Decimal]]:
    """Return both ends of the firing strengths, by the formulas of the Gaussians."""

    def gauss(distance: Decimal, sigma: float) -> Decimal:
        return (-(distance * distance) / (2 * Decimal(sigma) ** 2)).exp()

    def grade(term: object, at: Decimal) -> tuple[Decimal, Decimal]:
        if isinstance(term, fuzzy2.GaussianUncertainMean):
            first, last = map(Decimal, term.mean)
            ends = sorted(abs(at - mean) for mean in (first, last))
            near = Decimal(0) if first <= at <= last else ends[0]
            return gauss(ends[1], term.sigma), gauss(near, term.sigma)
        sigmas = term.sigma if isinstance(term.sigma, tuple) else (term.sigma, term.sigma)
        return tuple(gauss(at - Decimal(term.mean), sigma) for sigma in sigmas)

    fired = []
    for r, rule in enumerate(system.rules):
        grades = [
            grade(system.inputs[i][t], Decimal(float(x[i]))) for i, t in enumerate(rule) if t >= 0
        ]
        both = [Decimal(1), Decimal(1)]
        for of_input in grades:
            both = [
                min(one, own) if system.t_norm.name == "min" else one * own
                for one, own in zip(both, of_input, strict=True)
            ]
        weight = Decimal(1 if system.weights is None else float(system.weights[r]))
        fired.append([weight * one for one in both])
    return fired


@settings(max_examples=examples(60), deadline=None)
@given(
    seed=st.integers(0, 2**32 - 1),
    norm=st.sampled_from(["product", "min"]),
    certain=st.booleans(),
)
def test_an_input_far_from_all_gaussians_fires_the_rules_as_decimals_do(
    seed: int, norm: str, certain: bool
) -> None:
    """Both ends over all choices of weights, from decimals with exponents of 17 digits.

    What is less than 1e-308 of the greatest strength counts for nothing. 1e-4: exponents of up to
    1e13 are rounded to 1e-3, which matters where two rules fire nearly equally.
    """
    system, x = far_system(seed, norm, certain)
    with localcontext() as context:
        context.prec, context.Emin = 40, -(10**17)
        fired = firing_in_decimals(system, x)
        greatest = max(both[1] for both in fired)
        relative = [[float(one / greatest) for one in both] for both in fired]
    averages = []
    for choice in itertools.product((0, 1), repeat=len(fired)):
        weights = np.array([both[end] for both, end in zip(relative, choice, strict=True)])
        if weights.any():
            averages.append(float(weights @ system.consequents[:, 0] / weights.sum()))
    expected = [min(averages), max(averages)]
    for found in (
        system.type_reduced(x)[0],
        system.type_reduced(np.tile(x, (MANY, 1)))[-1, 0],
        system._outputs(x[np.newaxis], system.relative_firing(x[np.newaxis]))[0, 0],
    ):
        np.testing.assert_allclose(found, expected, atol=1e-4)


def test_gradients_far_away_are_differences_of_the_call() -> None:
    """Central ones with a step of 1e-5: 1e-6 of the slopes is their error."""
    for seed, norm in itertools.product(range(20), ("product", "min")):
        system, _ = far_system(seed, norm, certain=False)
        rng = np.random.default_rng(seed)
        x = rng.choice([-1.0, 1.0], 2) * rng.uniform(50.0, 90.0, 2)
        assert not system.firing(x).any()
        found = system.gradient(x)[0]
        for i, step in enumerate(1e-5 * np.eye(2)):
            expected = (system(x + step) - system(x - step))[0] / 2e-5
            assert found[i] == pytest.approx(expected, rel=1e-5, abs=1e-6)


def test_planes_of_general_type_2_systems_answer_far_away() -> None:
    """Of crisp secondary grades, so that all planes are the type-1 system, whose answer it is."""
    terms = [[fuzzy2.Gaussian(0.0, 0.1), fuzzy2.Gaussian(1.0, 0.1)]]
    z = [[2.0], [5.0]]
    for x in (-300.0, 1e6):
        expected = Type1System(terms, [[0], [1]], z)([x])
        assert expected == (2.0 if x < 0 else 5.0)
        np.testing.assert_allclose(GeneralType2System(terms, [[0], [1]], z)([x]), expected)


def test_bounded_terms_do_not_fire_beyond_their_ends() -> None:
    terms = [[fuzzy2.Triangular(0.0, 1.0, 2.0)], [fuzzy2.Gaussian(0.0, 1.0)]]
    system = Type1System(terms, [[0, 0]], [[1.0]])
    assert np.isnan(system([3.0, 100.0]))
    assert system([1.5, 100.0]) == 1.0
    assert np.isnan(system([1.5, 1e200]))  # the square of the distance is no float


def test_logarithms_of_grades_are_those_of_the_grades() -> None:
    """Where these are numbers; slopes by central differences, 1e-6 with a step of 1e-5."""
    terms = [
        fuzzy2.Gaussian(0.3, 0.7, 0.8),
        fuzzy2.GaussianUncertainMean((-0.5, 0.4), 0.6),
        fuzzy2.GaussianUncertainSigma(0.1, (0.4, 0.9)),
        fuzzy2.Triangular(-3.0, 0.2, 3.0),
    ]
    x = np.random.default_rng(0).uniform(-2.5, 2.5, 50)

    def grades(at: np.ndarray, of: str = "membership") -> np.ndarray:
        pairs = [[getattr(end, of)(at) for end in (term.lower, term.upper)] for term in terms]
        return np.moveaxis(np.array(pairs), -1, 0)

    found = log_grades(terms, x, grades(x))
    np.testing.assert_allclose(np.exp(found), grades(x), rtol=1e-13)
    slopes = slopes_of_logarithms(terms, x, grades(x), grades(x, "derivative"))
    high, low = (np.log(grades(x + step)) for step in (1e-5, -1e-5))
    np.testing.assert_allclose(slopes, (high - low) / 2e-5, rtol=1e-6, atol=1e-6)


def test_weights_multiply_and_zeros_stay() -> None:
    with np.errstate(divide="ignore"):
        grades = [np.log([[[0.5, 1.0], [0.0, 0.0]]])]
    found = relative_firing(grades, np.array([[0], [0], [1]]), np.array([1.0, 0.5, 1.0]))
    np.testing.assert_allclose(found, [[[0.5, 1.0], [0.25, 0.5], [0.0, 0.0]]])
