"""Derivatives of sets and systems against differences of what they are derivatives of.

Between kinks and from the right at them.
"""

from __future__ import annotations

import itertools
import math
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.optimize import brentq

import fuzzy2
from fuzzy2.errors import InvalidValue, NotApplicable
from fuzzy2.sets.derived import Complement, FunctionalSet, Truncated
from fuzzy2.sets.interval_type2 import EmbeddedSet
from fuzzy2.sets.shapes import Interval, Trapezoidal, Triangular
from fuzzy2.sets.sigmoids import Sigmoid, SigmoidDifference, SigmoidProduct
from fuzzy2.sets.smooth_shapes import Bell, PiShaped, TwoSidedGaussian
from fuzzy2.sets.type1 import Singleton
from fuzzy2.sets.vertical_slices import Staircase
from fuzzy2.systems import FuzzySystem, GeneralType2System, IntervalType2System, Linear, Type1System
from fuzzy2.systems.gradients import analytic_gradient, gradient_by_differences
from tests import examples
from tests.helpers import derivative

Array = NDArray[np.float64]
CONTINUOUS = ("product", "min", "lukasiewicz", "hamacher", "einstein")

UNCERTAIN = fuzzy2.GaussianUncertainMean(mean=(-0.3, 0.5), sigma=0.7)
BLURRED = fuzzy2.GaussianType2Set(principal=fuzzy2.Gaussian(0.2, 0.6), sigma=0.08)
BLURRED_TRIANGLE = fuzzy2.GaussianType2Set(
    principal=Triangular(-1.0, 0.2, 1.5), sigma=0.1, domain=(-2.0, 2.0)
)
SETS = [
    fuzzy2.Gaussian(0.3, 0.6, 0.8),
    Trapezoidal(-1.0, -0.4, 0.3, 1.2, 0.7),
    Trapezoidal(-math.inf, -math.inf, 0.3, 1.2),
    Trapezoidal(-1.0, -1.0, 0.3, 0.3),
    Triangular(-1.0, 0.2, 1.5, 0.9),
    Triangular(-1.0, -1.0, 1.5),
    Interval(-0.5, 0.7),
    Singleton(0.1),
    Bell(0.1, 0.6, 2.3),
    Bell(0.1, 0.6, 0.5),
    Sigmoid(0.2, 3.0),
    Sigmoid(0.2, -3.0),
    fuzzy2.SampledSet([-1.0, -0.2, 0.5, 1.0], [0.2, 1.0, 0.4, 0.6]),
    fuzzy2.SampledSet([0.3], [1.0]),
    PiShaped(-1.0, -0.4, 0.3, 1.2, 0.7),
    PiShaped(-math.inf, -math.inf, 0.3, 1.2),
    TwoSidedGaussian((-0.3, 0.5), (0.6, 0.9)),
    TwoSidedGaussian((0.5, -0.3), (0.6, 0.9)),
    SigmoidDifference((-0.5, 0.6), (4.0, 3.0)),
    SigmoidProduct((-0.5, 0.6), (4.0, -3.0)),
    Complement(Triangular(-1.0, 0.2, 1.5)),
    FunctionalSet(lambda x: np.cos(x) ** 2, -1.0, 1.2, slope=lambda x: -np.sin(2.0 * x)),
    Truncated(fuzzy2.Gaussian(0.3, 0.6), -0.5, 0.8),
    UNCERTAIN.lower,
    UNCERTAIN.upper,
    fuzzy2.GaussianUncertainSigma(mean=0.1, sigma=(0.4, 0.8)).lower,
    EmbeddedSet(UNCERTAIN, (-0.4, 0.6), (0.2, 1.0, 0.5)),
    Staircase((0.3, 0.7), (-1.0, 0.2), (1.0, 0.6)),
    fuzzy2.ZSlices((0.5, 1.0), (UNCERTAIN, fuzzy2.Gaussian(0.1, 0.7))).alpha_plane(0.4).lower,
    *(
        end
        for alpha in (0.0, 0.2, 1.0)
        for end in (BLURRED.alpha_plane(alpha).lower, BLURRED.alpha_plane(alpha).upper)
    ),
    *(
        end
        for alpha in (0.4, 1.0)
        for end in (
            BLURRED_TRIANGLE.alpha_plane(alpha).lower,
            BLURRED_TRIANGLE.alpha_plane(alpha).upper,
        )
    ),
    fuzzy2.GaussianType2Set(principal=Triangular(-1.0, 0.2, 1.5), sigma=0.0).alpha_plane(0.5).lower,
]


def from_the_right(curve: Callable[[float], Array], step: float) -> Array:
    """Return the derivative at 0 of a curve by forward differences of sixth order.

    What lies before 0 is not looked at.
    """
    weights = (-49.0 / 20.0, 6.0, -15.0 / 2.0, 20.0 / 3.0, -15.0 / 4.0, 6.0 / 5.0, -1.0 / 6.0)
    return sum(weight * curve(k * step) for k, weight in enumerate(weights)) / step


@pytest.mark.parametrize("fuzzy_set", SETS, ids=lambda one: type(one).__name__)
def test_derivatives_of_sets_between_kinks(fuzzy_set: Any) -> None:
    """Eighth-order differences with a step of 1e-3: 1e-10 is their rounding and truncation.

    Points next to a kink are left out.
    """
    x = np.random.default_rng(1).uniform(-2.5, 2.5, 400)
    wide, narrow = (derivative(lambda t: fuzzy_set(x + t), step) for step in (1e-3, 5e-4))
    smooth = np.abs(wide - narrow) < 1e-10
    assert smooth.mean() > 0.9
    np.testing.assert_allclose(fuzzy_set.derivative(x)[smooth], narrow[smooth], atol=1e-10)


@pytest.mark.parametrize("fuzzy_set", SETS, ids=lambda one: type(one).__name__)
def test_derivatives_of_sets_at_kinks_are_from_the_right(fuzzy_set: Any) -> None:
    """At every landmark: forward differences from 1e-10 behind it.

    So a vertical edge is passed; 1e-8 is their rounding.
    """
    kinks = fuzzy_set.landmarks + 1e-10
    expected = from_the_right(lambda t: fuzzy_set(kinks + t), 1e-4)
    # Points where an α-plane is cut off are roots, and may be rounded to the left.
    at = kinks if isinstance(fuzzy_set, FunctionalSet) else fuzzy_set.landmarks
    np.testing.assert_allclose(fuzzy_set.derivative(at), expected, atol=1e-8)


@pytest.mark.parametrize("fuzzy_set", SETS, ids=lambda one: type(one).__name__)
def test_derivatives_keep_shape_and_nan_and_vanish_far_out(fuzzy_set: Any) -> None:
    slopes = fuzzy_set.derivative(np.array([[np.nan, np.inf, -np.inf], [0.0, 1e300, -1e300]]))
    assert slopes.shape == (2, 3)
    assert np.isnan(slopes[0, 0])
    np.testing.assert_array_equal(slopes[:, 1:], 0.0)
    assert np.ndim(fuzzy_set.derivative(0.0)) == 0
    with pytest.raises(InvalidValue):
        fuzzy_set.derivative("here")


def test_a_narrow_bell_has_a_cusp() -> None:
    """With a slope below 1/2 it falls infinitely fast from its center.

    Away from it by its formula; 1e-12.
    """
    bell = Bell(0.0, 1.0, 0.3)
    assert bell.derivative(0.0) == -math.inf
    np.testing.assert_allclose(
        bell.derivative([-0.5, 0.5]),
        np.array([1.0, -1.0]) * 0.6 * 0.5**-0.4 * bell(0.5) ** 2,
        rtol=1e-12,
    )


def test_functions_without_a_derivative_say_so() -> None:
    """A function of one's own, and α-planes whose width is one."""
    wavy = fuzzy2.GaussianType2Set(
        principal=fuzzy2.Gaussian(0.0, 1.0), sigma=lambda x: 0.05 + 0.01 * np.cos(x)
    )
    for without in (FunctionalSet(np.cos, -1.0, 1.0), wavy.alpha_plane(0.5).lower, wavy.upper):
        with pytest.raises(NotApplicable, match="derivative"):
            without.derivative(0.0)


# Systems


def random_type1(rng: np.random.Generator, center: float) -> Any:
    width = rng.uniform(0.5, 1.5)
    choice = rng.integers(6)
    if choice == 0:
        return Triangular(center - width, center, center + rng.uniform(0.5, 1.5))
    if choice == 1:
        return Trapezoidal(
            center - 1.5 * width,
            center - 0.3,
            center + 0.3,
            center + 1.5 * width,
            rng.uniform(0.5, 1.0),
        )
    if choice == 2:
        return Bell(center, width, rng.uniform(1.2, 3.0))
    if choice == 3:
        return Sigmoid(center, rng.choice([-1.0, 1.0]) * rng.uniform(1.0, 4.0))
    return fuzzy2.Gaussian(center, width, rng.uniform(0.6, 1.0))


def random_interval(rng: np.random.Generator, center: float) -> Any:
    choice = rng.integers(4)
    if choice == 0:
        means = center - rng.uniform(0.0, 0.3), center + rng.uniform(0.0, 0.3)
        return fuzzy2.GaussianUncertainMean(mean=means, sigma=rng.uniform(0.4, 1.0))
    if choice == 1:
        return fuzzy2.GaussianUncertainSigma(
            mean=center, sigma=tuple(np.sort(rng.uniform(0.4, 1.2, 2)))
        )
    if choice == 2:
        inner, outer = rng.uniform(0.3, 1.0, 2), rng.uniform(1.0, 2.0, 2)
        lower = Triangular(center - inner[0], center, center + inner[1], rng.uniform(0.4, 1.0))
        return fuzzy2.IntervalType2Set(
            lower=lower, upper=Triangular(center - outer[0], center, center + outer[1])
        )
    return random_type1(rng, center)


def random_general(rng: np.random.Generator, center: float) -> Any:
    if rng.integers(3) == 0:
        return random_interval(rng, center)
    return fuzzy2.GaussianType2Set(principal=random_type1(rng, center), sigma=rng.uniform(0.0, 0.1))


TERMS = {
    Type1System: random_type1,
    IntervalType2System: random_interval,
    GeneralType2System: random_general,
}


def random_system(seed: int, kind: type[FuzzySystem], norm: str, reduction: str) -> FuzzySystem:
    """Return a system of up to three inputs, three terms each and two outputs.

    It has eight rules, some of which do not ask for every input.
    """
    rng = np.random.default_rng(seed)
    count, outputs, n_rules = rng.integers(1, 4), rng.integers(1, 3), rng.integers(1, 9)
    inputs = [
        [TERMS[kind](rng, center) for center in np.linspace(-1.2, 1.2, rng.integers(2, 4))]
        for _ in range(count)
    ]
    rules = np.stack([rng.integers(-1, len(terms), n_rules) for terms in inputs], axis=1)
    consequents: Any
    if reduction in ("height", "modified_height"):
        consequents = [
            [random_interval(rng, rng.normal()) for _ in range(outputs)] for _ in range(n_rules)
        ]
        if kind is Type1System:
            consequents = [
                [fuzzy2.Gaussian(rng.normal(), 0.4, 0.7) for _ in range(outputs)]
                for _ in range(n_rules)
            ]
        for row in consequents:  # a sigmoid has no highest point and no centroid
            row[:] = [
                fuzzy2.Gaussian(0.5, 0.3) if isinstance(item, Sigmoid) else item for item in row
            ]
        reduction_name = reduction
    else:
        reduction_name = "center_of_sets"
        if reduction == "linear":
            shape = (n_rules, outputs, count + 1)
            consequents = Linear(
                rng.normal(size=shape), rng.integers(0, 2) * 0.2 * rng.random(shape)
            )
        elif rng.integers(2):
            consequents = rng.normal(size=(n_rules, outputs))
        else:
            consequents = np.sort(rng.normal(size=(n_rules, outputs, 2)), axis=-1)
    options = {"levels": 3} if kind is GeneralType2System else {}
    return kind(inputs, rules, consequents, t_norm=norm, type_reduction=reduction_name, **options)


def differences(system: FuzzySystem, x: Array, step: float) -> Array:
    """Return the derivatives (m, p) of the crisp output by eighth-order differences.

    In one call of the system.
    """
    multiples = [sign * k for k in range(1, 5) for sign in (1, -1)]
    shifted = [x + k * step * np.eye(x.size) for k in multiples]
    outputs = dict(zip(multiples, system(np.array(shifted)), strict=True))
    return derivative(lambda t: outputs[round(t / step)], step).T


@pytest.mark.slow
@pytest.mark.parametrize("kind", TERMS, ids=lambda kind: kind.__name__)
@pytest.mark.parametrize("reduction", ["numbers", "linear", "height", "modified_height"])
@settings(max_examples=examples(60, of=12))
@given(seed=st.integers(0, 2**32 - 1), norm=st.sampled_from(CONTINUOUS))
def test_gradients_of_random_systems(
    kind: type[FuzzySystem], reduction: str, seed: int, norm: str
) -> None:
    """1e-8 of the slopes' size.

    Eighth-order differences of the call, where two steps agree to that; elsewhere there is a kink
    between.
    """
    system = random_system(seed, kind, norm, reduction)
    x = np.random.default_rng(seed + 1).uniform(-1.5, 1.5, len(system.inputs))
    found = system.gradient(x)
    silent = np.isnan(system(x))
    np.testing.assert_array_equal(
        np.isnan(found), np.broadcast_to(silent[:, np.newaxis], found.shape)
    )
    if silent.any():
        return
    assert found.shape == (system.n_outputs, len(system.inputs))
    np.testing.assert_array_equal(found, analytic_gradient(system, x[np.newaxis])[0])
    wide, narrow = (differences(system, x, step) for step in (5e-4, 2.5e-4))
    bound = 1e-8 * (1.0 + np.abs(narrow).max())
    assume(np.isfinite(wide).all() and np.abs(wide - narrow).max() < bound)
    np.testing.assert_allclose(found, narrow, atol=bound)


@settings(max_examples=100, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), norm=st.sampled_from(["product", "min"]))
def test_gradients_at_kinks_of_random_systems_are_from_the_right(seed: int, norm: str) -> None:
    """At corners of memberships, of equal terms under the minimum, and at 0 for spreads.

    Forward differences, good to 1e-6.
    """
    rng = np.random.default_rng(seed)
    corners = [-1.5, 0.0, 1.5]
    terms = [
        [Triangular(c - 2.0, c, c + 2.0) for c in corners],
        [Triangular(c - 2.0, c, c + 2.0, 0.8) for c in corners],
    ]
    lower = [[Triangular(c - 1.0, c, c + 1.0, 0.6) for c in corners]] * 2
    inputs = [
        [fuzzy2.IntervalType2Set(lower=low, upper=high) for low, high in zip(*pair, strict=True)]
        for pair in zip(lower, terms, strict=True)
    ]
    rules = np.array(list(itertools.product(range(3), repeat=2)))
    consequents: Any = rng.normal(size=(9, 2))
    if rng.integers(2):
        consequents = Linear(rng.normal(size=(9, 2, 3)), 0.3 * rng.random((9, 2, 3)))
    system = IntervalType2System(inputs, rules, consequents, t_norm=norm)
    x = rng.choice([-1.5, -0.5, 0.0, 0.5, 1.5], 2)
    wide, narrow = (from_the_right(lambda t: system(x + t * np.eye(2)), h).T for h in (2e-5, 1e-5))
    assume(np.abs(wide - narrow).max() < 1e-6)  # else a switch point passes just behind x
    np.testing.assert_allclose(system.gradient(x), narrow, atol=1e-6)


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("end", [0, 1])
def test_where_a_switch_point_passes_it_is_the_slope_behind_it(sign: float, end: int) -> None:
    """The end of the output is made equal to a consequent by a root.

    The slopes on both sides differ, and the right one is found; 1e-6.
    """
    inputs = [
        [
            fuzzy2.GaussianUncertainMean(mean=(sign * c - 0.2, sign * c + 0.2), sigma=0.8)
            for c in (-1.5, 0.0, 1.5)
        ]
    ]
    system = IntervalType2System(inputs, [[0], [1], [2]], [[-1.0], [0.1], [1.0]])
    passing = brentq(lambda t: float(system.type_reduced([t])[0, end]) - 0.1, -1.4, 1.4, xtol=1e-15)
    x = np.array([passing])
    behind = from_the_right(lambda t: system(x + t), 1e-4)[0]
    before = -from_the_right(lambda t: system(x - t), 1e-4)[0]
    assert abs(behind - before) > 0.01
    assert system.gradient(x)[0, 0] == pytest.approx(behind, abs=1e-6)


def test_linear_consequents_that_cross_at_the_output() -> None:
    """All consequents are 0 at x = 0 with different slopes.

    The ends of the output take the best weights of the side x > 0, exactly.
    """
    inputs = [
        [
            fuzzy2.GaussianUncertainSigma(mean=0.0, sigma=(0.5, 1.0)),
            fuzzy2.GaussianUncertainMean(mean=(-0.5, 0.5), sigma=0.6),
        ]
    ]
    slopes = np.array([1.0, -2.0])
    system = IntervalType2System(inputs, [[0], [1]], Linear([[[0.0, 1.0]], [[0.0, -2.0]]]))
    expected = fuzzy2.generalized_centroid(slopes, system.firing([0.0])).mean()
    assert system.gradient([0.0])[0, 0] == pytest.approx(expected, rel=1e-13)
    agreeing = IntervalType2System(inputs, [[0], [1]], Linear([[[0.5, 3.0]], [[0.5, 3.0]]]))
    np.testing.assert_allclose(agreeing.gradient([[0.0], [0.7]])[:, 0, 0], 3.0, rtol=1e-13)


def test_type_1_gradient_by_the_quotient_rule() -> None:
    """Written out for Gaussian terms; 1e-13."""
    centers, rules = np.array([-1.0, 1.0]), np.array(list(itertools.product(range(2), repeat=3)))
    consequents, X = (
        np.random.default_rng(0).normal(size=(8, 4)),
        np.random.default_rng(1).uniform(-2.0, 2.0, (2, 20, 3)),
    )
    system = Type1System([[fuzzy2.Gaussian(c, 0.8) for c in centers]] * 3, rules, consequents)
    found = system.gradient(X)
    assert found.shape == (2, 20, 4, 3)
    for place in np.ndindex(2, 20):
        firing = np.exp(-((X[place] - centers[rules]) ** 2).sum(axis=1) / (2.0 * 0.8**2))
        rates = firing[:, np.newaxis] * (centers[rules] - X[place]) / 0.8**2
        y = firing @ consequents / firing.sum()
        np.testing.assert_allclose(
            found[place], (consequents - y).T @ rates / firing.sum(), atol=1e-13
        )
    assert system.gradient(X[0, :0]).shape == (0, 4, 3)


def test_far_from_all_rules_the_gradient_stays_exact() -> None:
    """Firing strengths of 1e-150 and one term twice as far.

    Two Gaussians make a logistic function of the input; 1e-12 relative.
    """
    system = Type1System(
        [[fuzzy2.Gaussian(-0.05, 1.0), fuzzy2.Gaussian(0.05, 1.0)]], [[0], [1]], [[0.0], [1.0]]
    )
    x = np.array([[-26.0], [-3.0], [26.0]])
    share = 1.0 / (1.0 + np.exp(-0.1 * x[:, 0]))
    np.testing.assert_allclose(system.gradient(x)[:, 0, 0], 0.1 * share * (1.0 - share), rtol=1e-12)


@pytest.mark.parametrize("grades", ["min", "product"])
def test_gradient_of_the_corollary_is_that_of_the_principal_system(grades: str) -> None:
    """Its crisp output is the type-1 system of the principal memberships (eq. 1.107).

    Interval consequents count by their middles.
    """
    rng = np.random.default_rng(4)
    principal = [
        [fuzzy2.Gaussian(-1.0, 0.8), Triangular(-1.0, 1.0, 3.0)],
        [Bell(-1.0, 1.0, 2.0), Sigmoid(0.0, 2.0)],
    ]
    blurred = [
        [fuzzy2.GaussianType2Set(principal=term, sigma=0.03) for term in terms]
        for terms in principal
    ]
    blurred[1][1] = principal[1][1]
    rules, z, X = (
        [[0, 0], [0, 1], [1, -1]],
        np.sort(rng.normal(size=(3, 2, 2)), axis=-1),
        rng.uniform(-1.5, 1.5, (30, 2)),
    )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", fuzzy2.errors.ApproximationWarning)
        system = GeneralType2System(blurred, rules, z, reduction="gaussian", grade_t_norm=grades)
    crisp = Type1System(principal, rules, z.mean(axis=-1))
    np.testing.assert_allclose(system.gradient(X), crisp.gradient(X), atol=1e-12)
    np.testing.assert_array_equal(system.gradient(X), analytic_gradient(system, X))
    np.testing.assert_allclose(system.gradient(X[0]), differences(system, X[0], 1e-3), atol=1e-9)


def test_no_rule_fires_is_nan() -> None:
    terms = [[Triangular(0.0, 1.0, 2.0), Triangular(4.0, 5.0, 6.0)]]
    for kind in (Type1System, IntervalType2System, GeneralType2System):
        system = kind(terms, [[0], [1]], [[1.0], [2.0]])
        slopes = system.gradient([[3.0], [2.0], [4.0], [1.0]])[:, 0, 0]
        np.testing.assert_array_equal(slopes, [np.nan, np.nan, np.nan, 0.0])


def test_blocks_of_inputs_are_put_together(monkeypatch: pytest.MonkeyPatch) -> None:
    system = random_system(5, IntervalType2System, "product", "linear")
    X = np.random.default_rng(6).uniform(-1.0, 1.0, (23, len(system.inputs)))
    whole = system.gradient(X)
    monkeypatch.setattr(fuzzy2.systems.gradients, "_BLOCK", 8 * system.rules.size)
    np.testing.assert_array_equal(system.gradient(X), whole)


GAUSSIANS = [[fuzzy2.Gaussian(c, 0.8) for c in (-1.0, 0.0, 1.0)]] * 2
WAVY = [
    [fuzzy2.GaussianType2Set(principal=t, sigma=lambda x: 0.05 + 0.01 * np.cos(x)) for t in terms]
    for terms in GAUSSIANS
]
BUMPS = [
    [
        FunctionalSet(
            lambda x, c=c: np.exp(-((x - c) ** 2)), -math.inf, math.inf, (c - 3.0, c + 3.0)
        )
        for c in (-1.0, 0.0, 1.0)
    ]
] * 2
OUTPUTS = [fuzzy2.Gaussian(z, 0.5) for z in (-1.0, 0.3, 1.0)]


@pytest.mark.parametrize(
    ("kind", "inputs", "options"),
    [
        (
            Type1System,
            GAUSSIANS,
            {"type_reduction": "centroid", "resolution": 101, "t_conorm": "probabilistic"},
        ),
        (Type1System, GAUSSIANS, {"type_reduction": "center_of_sums", "resolution": 101}),
        (Type1System, GAUSSIANS, {"t_norm": lambda a, b: a * b}),
        (
            Type1System,
            GAUSSIANS,
            {"fuzzifier": fuzzy2.NonSingletonFuzzifier(fuzzy2.Gaussian(0.0, 0.3))},
        ),
        (Type1System, BUMPS, {}),
        (GeneralType2System, WAVY, {"levels": 1}),
    ],
)
def test_what_has_no_formula_goes_by_differences(
    kind: type[FuzzySystem], inputs: Any, options: dict[str, Any]
) -> None:
    """Sixth-order differences against those of eighth order with another step, on smooth systems.

    1e-8.
    """
    system = kind(inputs, [[0, 0], [1, -1], [2, 2]], OUTPUTS, **options)
    X = np.random.default_rng(7).uniform(-1.0, 1.0, (4, 2))
    with pytest.raises(NotApplicable):
        analytic_gradient(system, X)
    found = system.gradient(X)
    np.testing.assert_array_equal(found, gradient_by_differences(system, X))
    for x, slopes in zip(X, found, strict=True):
        np.testing.assert_allclose(slopes, differences(system, x, 1e-2), atol=1e-8)


@pytest.mark.parametrize("bad", [[0.0], [0.0, np.nan], [0.0, np.inf], 1.0, "far"])
def test_malformed_inputs_are_refused(bad: object) -> None:
    with pytest.raises(InvalidValue, match="X"):
        Type1System(GAUSSIANS, [[0, 0]], [[1.0]]).gradient(bad)  # type: ignore[arg-type]
