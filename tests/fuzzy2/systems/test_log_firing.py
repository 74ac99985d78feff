"""Firing strengths that underflow, beside exact products and decimals of any exponent."""

from __future__ import annotations

import itertools
from decimal import Context, Decimal, localcontext
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import fuzzy2
from fuzzy2.operations.t_norms import T_CONORMS, T_NORMS
from fuzzy2.systems import GeneralType2System, IntervalType2System, Type1System
from fuzzy2.systems.antecedents import And, Hedged, Is, Not, Or
from fuzzy2.systems.hedges import Hedge, Scaled, intensify, relax
from fuzzy2.systems.log_firing import (
    log_firing,
    log_grades,
    log_norms,
    lost,
    slopes_of_logarithms,
)
from fuzzy2.systems.table import CONORMS, NORMS
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
    """Both ends over all choices of weights, in decimals with exponents of 17 digits.

    1e-4: exponents of up to 1e13 are rounded to 1e-3, which matters where two rules fire nearly
    equally.
    """
    system, x = far_system(seed, norm, certain)
    with wide_decimals():
        expected = ends_in_decimals(firing_in_decimals(system, x), system.consequents[:, 0])
    for found in all_ways(system, x):
        np.testing.assert_allclose(found, expected, atol=1e-4)


def wide_decimals() -> Any:
    """Return a context of decimals with 40 digits and exponents of 17."""
    return localcontext(Context(prec=40, Emin=-(10**17)))


def ends_in_decimals(fired: list[list[Decimal]], z: np.ndarray) -> list[float]:
    """Return the least and the greatest average over all choices of lower and upper weights."""
    averages = []
    for choice in itertools.product((0, 1), repeat=len(fired)):
        weights = [both[end] for both, end in zip(fired, choice, strict=True)]
        if any(weights):
            moments = (w * Decimal(float(at)) for w, at in zip(weights, z, strict=True))
            averages.append(sum(moments) / sum(weights))
    return [float(min(averages)), float(max(averages))]


def all_ways(system: IntervalType2System, x: np.ndarray) -> list[np.ndarray]:
    """Return the type-reduced interval of the only output, by a row, many rows, and arrays."""
    slow = system.replace()
    slow._table, slow._fast = None, False
    return [
        system.type_reduced(x)[0],
        system.type_reduced(np.tile(x, (MANY, 1)))[-1, 0],
        slow.type_reduced(x)[0],
    ]


@settings(max_examples=examples(100), deadline=None)
@given(seed=st.integers(0, 2**32 - 1), norm=st.sampled_from(["product", "min"]))
def test_ends_hang_on_lower_strengths_that_vanish_beside_upper_ones(seed: int, norm: str) -> None:
    """From where single lower strengths vanish to where all do: the answer is that of decimals.

    Exponents are below 1e6 there, rounded to 1e-10; 1e-8 is room for ties of two rules.
    """
    system, x = far_system(seed, norm, certain=False)
    x = x / np.abs(x) * np.random.default_rng(seed).uniform(3.0, 90.0, 2)
    with wide_decimals():
        expected = ends_in_decimals(firing_in_decimals(system, x), system.consequents[:, 0])
    for found in all_ways(system, x):
        np.testing.assert_allclose(found, expected, atol=1e-8)


def test_an_end_by_hand_where_only_ratios_of_what_vanishes_decide() -> None:
    """Sixty deviations away each of two rules may outweigh the other by far: all is possible.

    One fires between exp(-7200) and exp(-1800), the other between exp(-20000) and exp(-1250).
    """
    terms = [
        [
            fuzzy2.GaussianUncertainSigma(0.0, (0.5, 1.0)),
            fuzzy2.GaussianUncertainSigma(10.0, (0.25, 1.0)),
        ]
    ]
    system = IntervalType2System(terms, [[0], [1]], [[-3.0], [7.0]])
    for found in all_ways(system, np.array([60.0])):
        np.testing.assert_array_equal(found, [-3.0, 7.0])
    # Rules that say the same leave no doubt, and what never fires has no say.
    same = IntervalType2System(terms, [[0], [1]], [[7.0], [7.0]])
    np.testing.assert_array_equal(same.type_reduced([60.0]), [[7.0, 7.0]])
    silenced = system.replace(weights=[0.0, 1.0])
    for found in all_ways(silenced, np.array([60.0])):
        np.testing.assert_array_equal(found, [7.0, 7.0])


NORMS_OF_DECIMALS: dict[str, tuple[Any, Any]] = {
    "product": (lambda a, b: a * b, lambda a, b: a + b - a * b),
    "min": (min, max),
    "hamacher": (
        lambda a, b: a * b / (a + b - a * b) if a or b else Decimal(0),
        lambda a, b: (a + b - 2 * a * b) / (1 - a * b) if a * b != 1 else Decimal(1),
    ),
    "einstein": (
        lambda a, b: a * b / (1 + (1 - a) * (1 - b)),
        lambda a, b: (a + b) / (1 + a * b),
    ),
    "lukasiewicz": (lambda a, b: max(a + b - 1, Decimal(0)), lambda a, b: min(a + b, Decimal(1))),
}
DUALS = dict(zip(CONORMS, NORMS, strict=True))


def tree_in_decimals(tree: Any, grades: Any, both: str, either: str) -> list[list[Decimal]]:
    """Return the grades of a tree at both ends, each with its complement.

    No number of digits holds 1 - (1 - g) of a tiny g, so what is not is carried beside what is.
    """

    def of(part: Any) -> list[list[Decimal]]:
        return tree_in_decimals(part, grades, both, either)

    if isinstance(tree, Is):
        return [[one, 1 - one] for one in grades[tree.variable][tree.term]]
    if isinstance(tree, Not):
        return [end[::-1] for end in of(tree.part)[::-1]]
    if isinstance(tree, Hedged):
        powers = [one ** Decimal(tree.hedge.power) for one, _ in of(tree.part)]
        return [[one, 1 - one] for one in powers]
    conjunction, disjunction = NORMS_OF_DECIMALS[both if isinstance(tree, And) else DUALS[either]]
    if isinstance(tree, Or):
        conjunction, disjunction = disjunction, conjunction
    first, *others = (of(part) for part in tree.parts)
    for other in others:
        first = [
            [conjunction(a, b), disjunction(c, d)]
            for (a, c), (b, d) in zip(first, other, strict=True)
        ]
    return first


TREES = (
    Or((Is(0, 0), And((Is(0, 1), Is(1, 0))))),
    And((Not(Is(0, 0)), Hedged(Hedge("very", 2.0), Is(1, 1)))),
    And((Or((Is(0, 0), Is(1, 0), Is(1, 1))), Is(0, 1))),
    And((Is(1, 1), Not(Or((Is(0, 1), Not(Is(1, 0))))))),
)


@settings(max_examples=examples(100), deadline=None)
@given(
    seed=st.integers(0, 2**32 - 1),
    norm=st.sampled_from(["product", "min", "hamacher", "einstein"]),
    conorm=st.sampled_from(["max", "probabilistic", "lukasiewicz", "hamacher", "einstein"]),
)
def test_rules_that_are_trees_fire_far_away_as_decimals_do(
    seed: int, norm: str, conorm: str
) -> None:
    """1e-8: exponents below 1e6 are rounded to 1e-10, and two rules may tie.

    Łukasiewicz's *or* under two negations takes a tiny grade from another, of which one is known as
    1 less that; it is left out.
    """
    trees = TREES if conorm != "lukasiewicz" else (*TREES[:3], Or((Is(1, 0), Is(1, 1))))
    rng = np.random.default_rng(seed)
    plain, x = far_system(seed, "product", certain=bool(rng.random() < 0.3))
    x = x / np.abs(x) * rng.uniform(10.0, 90.0, 2)
    system = IntervalType2System(
        plain.inputs,
        trees,
        plain.consequents,
        norm,
        disjunction=conorm,
        weights=plain.weights,
    )
    assert system.firing(x).max() < 1e-3
    with wide_decimals() as context:
        context.prec = 60
        one_by_one = [
            plain.replace(rules=[rule], consequents=[[0.0]], weights=None)
            for rule in ([0, -1], [1, -1], [-1, 0], [-1, 1])
        ]
        found = [tuple(firing_in_decimals(one, x)[0]) for one in one_by_one]
        grades = [found[:2], found[2:]]
        fired = []
        for r, tree in enumerate(trees):
            weight = Decimal(1 if plain.weights is None else float(plain.weights[r]))
            ends = tree_in_decimals(tree, grades, norm, conorm)
            fired.append([weight * one for one, _ in ends])
        expected = ends_in_decimals(fired, system.consequents[:, 0])
    for answer in all_ways(system, x):
        np.testing.assert_allclose(answer, expected, atol=1e-8)


def test_an_output_of_its_own_rules_answers_where_those_of_another_fire_well() -> None:
    """The second output's rules are far away; they need no default, which is for no rule at all."""
    terms = [[fuzzy2.Gaussian(0.0, 1.0), fuzzy2.Gaussian(90.0, 1.0), fuzzy2.Gaussian(100.0, 1.0)]]
    silent = [[False, True], [True, False], [True, False]]
    z = [[1.0, 0.0], [0.0, 2.0], [0.0, 3.0]]
    system = Type1System(terms, [[0], [1], [2]], z, silent=silent, default_outputs=[None, 9.0])
    slow = system.replace()
    slow._table, slow._fast = None, False
    for one in (system, slow):
        np.testing.assert_array_equal(one([0.5]), [1.0, 2.0])
        np.testing.assert_array_equal(one([[200.0]]), [[1.0, 3.0]])
    bounded = system.replace(
        inputs=[[terms[0][0], *(fuzzy2.Triangular(m - 1, m, m + 1) for m in (90.0, 100.0))]]
    )
    np.testing.assert_array_equal(bounded([0.5]), [1.0, 9.0])


def test_nothing_fires_where_that_is_so_by_the_formula() -> None:
    """Half-lines, and Łukasiewicz's product of two tiny grades, are 0, not too small."""
    terms = [[fuzzy2.Triangular(0.0, 1.0, 2.0)], [fuzzy2.Gaussian(0.0, 1.0)]]
    trees = (Or((Is(0, 0), And((Is(0, 0), Is(1, 0))))),)
    assert np.isnan(Type1System(terms, trees, [[1.0]])([3.0, 100.0]))
    far = [[fuzzy2.Gaussian(0.0, 1.0)]] * 2
    for norm in ("lukasiewicz", "drastic", "nilpotent"):
        assert np.isnan(Type1System(far, [[0, 0]], [[1.0]], norm)([100.0, 100.0]))
    assert np.isnan(Type1System(far, (Not(Is(0, 0)),), [[1.0]])([0.0, 0.0]))
    assert Type1System(far, (Not(Is(0, 0)),), [[1.0]])([1e-10, 0.0]) == 1.0


def test_logarithms_of_norms_are_those_of_their_values() -> None:
    """Of grades that are floats; 1e-12 of a logarithm, and zeros are zeros."""
    special = [0.0, 1e-300, 1e-17, 0.3, 0.5, 0.7, 1.0 - 2**-53, 1.0]
    grades = np.concatenate([special, np.random.default_rng(0).uniform(size=30)])
    with np.errstate(divide="ignore"):
        logarithms = np.log(grades)
        for names, known, chosen in (
            (NORMS, T_NORMS, lambda name: log_norms(name, "max").both),
            (CONORMS, T_CONORMS, lambda name: log_norms("min", name).either),
        ):
            for name in names:
                expected = np.log(known[name](grades[:, np.newaxis], grades))
                found = chosen(name)(logarithms[:, np.newaxis], logarithms)
                # Łukasiewicz's a + b - 1 cancels.
                np.testing.assert_allclose(np.exp(found), np.exp(expected), rtol=1e-12, atol=1e-15)
                # Products of the smallest grades are no floats.
                held = (expected > -690.0) & (name != "lukasiewicz")
                np.testing.assert_allclose(found[held], expected[held], rtol=1e-12, atol=1e-15)


def test_hedges_of_logarithms() -> None:
    """Where grades are floats, and of those that are not by hand."""
    grades = np.linspace(0.01, 1.0, 50)
    hedges = [
        Hedge("very", 2.0),
        Hedge("a", function=intensify),
        Hedge("b", function=relax),
        Hedge("c", function=Scaled(0.3)),
        Hedge("d", function=lambda grades: grades**3),
        Hedge("e", function=Scaled(0.0)),
    ]
    for hedge in hedges[:-1]:
        found = np.exp(hedge.of_logarithms(np.log(grades)))
        np.testing.assert_allclose(found, hedge(grades), rtol=1e-13)
    tiny = np.array([-2000.0])
    expected = [-4000.0, np.log(2.0) - 4000.0, -1000.0 - 0.5 * np.log(2.0), np.log(0.3) - 2000.0]
    for hedge, one in zip(hedges, [*expected, -np.inf, -np.inf], strict=True):
        np.testing.assert_allclose(hedge.of_logarithms(tiny), one, rtol=1e-15)


@pytest.mark.parametrize("kind", ["height", "modified_height", "centroid", "center_of_sums"])
def test_sets_as_consequents_far_away(kind: str) -> None:
    """Both rules fire between e^-7200 and e^-1250: the ends are those of the sets alone."""
    terms = [
        [
            fuzzy2.GaussianUncertainSigma(0.0, (0.5, 1.0)),
            fuzzy2.GaussianUncertainSigma(10.0, (0.25, 1.0)),
        ]
    ]
    sets = [[fuzzy2.Triangular(0.0, 1.0, 2.0)], [fuzzy2.Triangular(6.0, 7.0, 8.0)]]
    system = IntervalType2System(
        terms, [[0], [1]], sets, type_reduction=kind, implication="product", t_conorm="max"
    )
    expected = [1.0, 7.0] if "height" in kind else [0.0, 8.0]
    # A centroid's end comes as near to the end of a set as upper and lower strengths differ.
    np.testing.assert_allclose(system.type_reduced([60.0]), [expected], atol=1e-5)


def test_direct_methods_far_away() -> None:
    """One rule is the strongest in lower strengths, another in upper ones.

    Wu and Mendel's bounds are those of decimals.
    """
    terms = [
        [
            fuzzy2.GaussianUncertainSigma(0.0, (0.5, 1.0)),
            fuzzy2.GaussianUncertainSigma(10.0, (0.25, 1.0)),
        ]
    ]
    z = np.array([-3.0, 7.0])
    system = IntervalType2System(terms, [[0], [1]], z[:, np.newaxis], method="nie_tan")
    assert system([60.0]) == 7.0
    blended = system.replace(method="begian_melek_mendel", shares=(0.3, 0.7))
    assert blended([60.0])[0] == pytest.approx(0.3 * -3.0 + 0.7 * 7.0, rel=1e-15)
    x = np.array([60.0])
    with wide_decimals():
        fired = firing_in_decimals(system, x)
        expected = wu_mendel_in_decimals(fired, z)
    bounded = system.replace(method="wu_mendel")
    np.testing.assert_allclose(bounded.type_reduced(x)[0], expected, rtol=1e-12)


def wu_mendel_in_decimals(fired: list[list[Decimal]], z: np.ndarray) -> list[float]:
    """Return the middles of both bounds, by their formula."""
    middles = []
    for sign in (1, -1):
        y = [sign * Decimal(float(at)) for at in z]
        low, high = (sum(both[end] for both in fired) for end in (0, 1))
        averages = [
            sum(both[end] * at for both, at in zip(fired, y, strict=True)) / total
            for end, total in ((0, low), (1, high))
        ]
        rise = sum(both[0] * (at - min(y)) for both, at in zip(fired, y, strict=True))
        fall = sum(both[1] * (max(y) - at) for both, at in zip(fired, y, strict=True))
        gap = Decimal(0)
        if rise and fall:
            gap = (high - low) / (high * low) * rise * fall / (rise + fall)
        middles.append(float(sign * (min(averages) - gap / 2)))
    return middles


def test_explanations_far_away_add_up_to_the_output() -> None:
    """Shares times what rules say is the middle of the interval, to rounding."""
    for seed in range(30):
        system, _ = far_system(seed, "product", certain=False)
        rng = np.random.default_rng(seed)
        x = rng.choice([-1.0, 1.0], 2) * rng.uniform(50.0, 90.0, 2)
        shares = system.explain(x).shares[:, 0]
        np.testing.assert_allclose(shares @ system.consequents[:, 0], system(x)[0], atol=1e-12)
        assert shares.sum() == pytest.approx(1.0, rel=1e-14)


def test_what_is_lost() -> None:
    """A lower strength that is a float holds all; so do upper ones that all are."""
    rows = np.array(
        [
            [[1e-300, 1e-300], [0.5, 0.6]],
            [[0.0, 0.5], [1e-300, 0.6]],
            [[0.0, 0.5], [1e-300, 1e-290]],
            [[0.0, 0.0], [0.0, 0.0]],
        ]
    )
    np.testing.assert_array_equal(lost(rows, None), [False, False, True, True])
    silent = np.array([[False, True], [True, False]])
    np.testing.assert_array_equal(lost(rows, silent), [True, False, True, True])


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
    rules, weights = np.array([[0], [0], [1]]), np.array([1.0, 0.5, 1.0])
    found = np.exp(log_firing(grades, rules, weights, log_norms("product", "max")))
    np.testing.assert_allclose(found, [[[0.5, 1.0], [0.25, 0.5], [0.0, 0.0]]])
