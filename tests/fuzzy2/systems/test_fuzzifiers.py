"""Fuzzifiers.

Closed forms against dense grids, joins over the input against `join` and `meet`, limits, and what
is refused.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fuzzy2.errors import InvalidValue, NotApplicable, UnknownName
from fuzzy2.operations.join_meet import join, meet
from fuzzy2.operations.t_norms import t_norm
from fuzzy2.sets.derived import FunctionalSet, Truncated
from fuzzy2.sets.gaussian_type2 import GaussianType2Set
from fuzzy2.sets.general_type2 import ZSlices
from fuzzy2.sets.interval_type2 import (
    GaussianUncertainMean,
    GaussianUncertainSigma,
    IntervalType2Set,
)
from fuzzy2.sets.shapes import Gaussian, Interval, Trapezoidal, Triangular
from fuzzy2.sets.sigmoids import Sigmoid
from fuzzy2.sets.smooth_shapes import Bell
from fuzzy2.sets.type1 import SampledSet, Singleton, Type1Set
from fuzzy2.sets.uncertain_mean import FarthestMeanGaussian, NearestMeanGaussian
from fuzzy2.systems.fuzzifiers import NonSingletonFuzzifier, SingletonFuzzifier, sup_star

NORMS = ("product", "min")
INPUTS = np.array([-1.3, 0.0, 0.6, 1.05, 2.7])

SHAPES: list[Type1Set] = [
    Gaussian(0.0, 0.3),
    Gaussian(0.1, 0.4, 0.8),
    NearestMeanGaussian((-0.2, 0.5), 0.3),
    FarthestMeanGaussian((-0.2, 0.5), 0.6),
    Triangular(-1.0, 0.0, 0.5),
    Interval(-0.3, 0.2),
    Bell(0.0, 0.5, 2.0),
    Trapezoidal(-0.5, -0.5, 0.1, 0.3),
    SampledSet([-1.0, -0.5, 0.0, 0.5, 1.0], [0.0, 0.8, 0.3, 1.0, 0.0]),
    Truncated(Gaussian(0.0, 0.5), -0.4, 0.6),
]
TERMS: list[Type1Set] = [
    Gaussian(1.0, 0.5),
    Gaussian(1.0, 0.5, 0.6),
    NearestMeanGaussian((0.3, 1.2), 0.5),
    FarthestMeanGaussian((0.3, 1.5), 0.5),
    Triangular(0.0, 1.0, 1.5),
    Trapezoidal(0.0, 0.5, 0.8, 2.0, 0.7),
    Sigmoid(1.0, 3.0),
    Sigmoid(1.0, -3.0),
    Bell(1.0, 0.4, 1.5),
    Trapezoidal(1.0, 2.0, math.inf, math.inf),
    SampledSet([0.0, 0.5, 1.0, 1.5, 2.0], [0.0, 0.8, 0.3, 1.0, 0.0]),
    FunctionalSet(lambda x: np.exp(-np.abs(x - 1.0)), -math.inf, math.inf, (0.0, 1.0, 2.0)),
]


def on_a_grid(shape: Type1Set, term: Type1Set, x: float, name: str) -> float:
    """Greatest grade at 40 001 points.

    A lower bound of the supremum, at most a step's slope below it.
    """
    points = np.concatenate([np.linspace(-4.5, 5.5, 40_001), shape.landmarks + x, term.landmarks])
    return float(t_norm(name)(shape(points - x), term(points)).max())


@pytest.mark.slow
@pytest.mark.parametrize("name", [*NORMS, "lukasiewicz"])
@pytest.mark.parametrize("shape", SHAPES, ids=repr)
def test_supremum_of_any_two_sets(shape: Type1Set, name: str) -> None:
    """Never below what a grid of step 2.5e-4 finds.

    Above by no more than a step's slope (steepest: 2 per unit on either side).
    """
    for term in TERMS:
        found = sup_star(shape, term, INPUTS, name)
        expected = np.array([on_a_grid(shape, term, x, name) for x in INPUTS])
        assert (found >= expected - 1e-9).all(), term
        assert (found <= expected + 4.0 * 2.5e-4).all(), term


GAUSSIANS = st.tuples(st.floats(-3.0, 3.0), st.floats(0.05, 2.0))


@given(GAUSSIANS, GAUSSIANS, st.floats(-5.0, 5.0))
@settings(max_examples=300, deadline=None)
def test_closed_forms_of_gaussians(
    first: tuple[float, float], second: tuple[float, float], x: float
) -> None:
    """The product and the minimum at the stated points are the stated grades.

    No neighboring point is better.
    """
    shape, term = Gaussian(*first), Gaussian(*second)
    (m1, s1), (m2, s2) = first, second
    distance = x + m1 - m2
    best = (s2**2 * (x + m1) + s1**2 * m2) / (s1**2 + s2**2)
    crossing = (s2 * (x + m1) + s1 * m2) / (s1 + s2)
    product, minimum = (float(sup_star(shape, term, x, name)) for name in NORMS)
    assert product == pytest.approx(
        math.exp(-0.5 * distance**2 / (s1**2 + s2**2)), rel=1e-10, abs=1e-300
    )
    assert minimum == pytest.approx(
        math.exp(-0.5 * (distance / (s1 + s2)) ** 2), rel=1e-10, abs=1e-300
    )
    assert product == pytest.approx(float(shape(best - x) * term(best)), rel=1e-10, abs=1e-300)
    assert minimum == pytest.approx(
        float(min(shape(crossing - x), term(crossing))), rel=1e-10, abs=1e-300
    )
    around = np.linspace(-8.0, 8.0, 1601)
    assert (shape(around - x) * term(around) <= product * (1.0 + 1e-10)).all()
    assert (np.minimum(shape(around - x), term(around)) <= minimum * (1.0 + 1e-10)).all()


@given(
    st.tuples(st.floats(-1.0, 1.0), st.floats(0.0, 1.5), st.floats(0.1, 1.0)),
    st.tuples(st.floats(-1.0, 1.0), st.floats(0.0, 1.5), st.floats(0.1, 1.0)),
    st.floats(-4.0, 4.0),
    st.sampled_from(NORMS),
)
@settings(max_examples=300, deadline=None)
def test_closed_forms_of_uncertain_means_against_the_search(
    first: tuple[float, float, float], second: tuple[float, float, float], x: float, name: str
) -> None:
    """The same sets as plain functions go through the search, which knows no Gaussians.

    It is good to 1e-9.
    """
    for kind_of_shape in (NearestMeanGaussian, FarthestMeanGaussian):
        for kind_of_term in (NearestMeanGaussian, FarthestMeanGaussian):
            shape, term = (
                kind((left, left + width), sigma)
                for kind, (left, width, sigma) in ((kind_of_shape, first), (kind_of_term, second))
            )
            points = np.sort(
                np.concatenate([np.linspace(-8.0, 8.0, 4001), shape.landmarks + x, term.landmarks])
            )
            grid = t_norm(name)(shape(points - x), term(points))
            found = float(sup_star(shape, term, x, name))
            assert found >= grid.max() - 1e-12
            # Steps of 4e-3; the slope of a Gaussian is at most 0.61 / sigma, twice that under the
            # product.
            assert found <= grid.max() + 4e-3 * 1.22 * max(1.0 / first[2], 1.0 / second[2])


def test_singleton_is_the_membership_itself() -> None:
    """Eq. 1.122, 1.123; a non-singleton of no width is the same, for every kind of term."""
    x = np.array([[0.2, 1.1], [2.0, np.nan]])
    for term in (
        *TERMS,
        GaussianUncertainMean(mean=(0.8, 1.2), sigma=0.4),
        GaussianUncertainSigma(mean=1.0, sigma=(0.3, 0.5)),
    ):
        expected = np.stack([term.lower(x), term.upper(x)], axis=-1)
        for name in NORMS:
            np.testing.assert_array_equal(SingletonFuzzifier().firing(term, x, name), expected)
            np.testing.assert_array_equal(
                NonSingletonFuzzifier(Singleton(0.0)).firing(term, x, name), expected
            )
    np.testing.assert_allclose(
        NonSingletonFuzzifier(Gaussian(0.0, 1e-9)).firing(TERMS[0], x, "product"),
        expected_of(TERMS[0], x),
        atol=1e-8,
    )


def expected_of(term: Type1Set, x: np.ndarray) -> np.ndarray:
    return np.stack([term(x), term(x)], axis=-1)


def test_a_singleton_term_reads_the_input_set() -> None:
    shape = Triangular(-1.0, 0.0, 0.5)
    np.testing.assert_allclose(
        sup_star(shape, Singleton(1.0), [0.5, 1.2, 3.0]), [0.0, 0.8, 0.0], atol=1e-15
    )


def test_interval_noise_reads_the_term_within_it() -> None:
    """Eq. 1.29: of a crisp interval the firing set is the greatest membership within it."""
    fuzzifier = NonSingletonFuzzifier(Interval(-0.5, 0.25))
    term = Triangular(0.0, 1.0, 2.0)
    np.testing.assert_allclose(
        fuzzifier.firing(term, [0.5, 1.2, 2.6], "min")[..., 0], [0.75, 1.0, 0.0], atol=1e-14
    )
    np.testing.assert_allclose(
        fuzzifier.firing(term, [0.5, 1.2, 2.4], "product")[..., 0], [0.75, 1.0, 0.1], atol=1e-14
    )


@pytest.mark.parametrize("name", NORMS)
def test_joins_over_a_discrete_input(name: str) -> None:
    """Eq. 1.120 literally, with `join` and `meet` of intervals at 4001 points.

    Against the supremum of the ends.
    """
    noise = GaussianUncertainSigma(mean=0.0, sigma=(0.2, 0.4))
    term = GaussianUncertainMean(mean=(0.8, 1.3), sigma=0.5)
    x = 0.3
    points = np.linspace(-3.0, 4.0, 4001)
    met = [
        meet(Interval(*noise.footprint(point - x)), Interval(*term.footprint(point)), t_norm=name)
        for point in points
    ]
    joined = join(*met)
    assert isinstance(joined, Interval)
    found = NonSingletonFuzzifier(noise).firing(term, x, name)
    # The maximum is flat for the product; it is a crossing of slope 3 at most for the minimum, and
    # the step is 1.75e-3.
    np.testing.assert_allclose(
        found, [joined.left, joined.right], atol=6e-3 if name == "min" else 1e-5
    )


@pytest.mark.parametrize("name", NORMS)
def test_no_uncertainty_is_the_type_1_fuzzifier(name: str) -> None:
    """All kinds of sets, made crisp in their secondaries, give the type-1 firing set."""
    x = np.linspace(-1.0, 3.0, 9)
    noise, term = Gaussian(0.0, 0.3), Gaussian(1.0, 0.5)
    expected = NonSingletonFuzzifier(noise).firing(term, x, name)
    for same_noise in (
        GaussianUncertainSigma(mean=0.0, sigma=(0.3, 0.3)),
        GaussianUncertainMean(mean=(0.0, 0.0), sigma=0.3),
    ):
        for same_term in (
            GaussianUncertainSigma(mean=1.0, sigma=(0.5, 0.5)),
            IntervalType2Set(lower=term, upper=term),
        ):
            np.testing.assert_allclose(
                NonSingletonFuzzifier(same_noise).firing(same_term, x, name), expected, rtol=1e-12
            )
    crisp = GaussianType2Set(term, 0.0)
    for alpha_cut in np.moveaxis(
        NonSingletonFuzzifier(noise).firing_planes(crisp, x, [0.3, 1.0], name), -2, 0
    ):
        # the search, not the closed form
        np.testing.assert_allclose(alpha_cut, expected, atol=1e-9)


def test_noise_raises_the_firing_of_far_terms() -> None:
    """Wider noise fires at least as much, and lower never exceeds upper."""
    x = np.linspace(-3.0, 5.0, 41)
    term = GaussianUncertainMean(mean=(0.8, 1.2), sigma=0.4)
    for name in NORMS:
        previous = SingletonFuzzifier().firing(term, x, name)
        for sigma in (0.05, 0.2, 0.8):
            firing = NonSingletonFuzzifier(Gaussian(0.0, sigma)).firing(term, x, name)
            assert (firing >= previous - 1e-14).all()
            assert (firing[..., 0] <= firing[..., 1]).all()
            previous = firing


@pytest.mark.parametrize("name", NORMS)
def test_general_sets_go_plane_by_plane(name: str) -> None:
    """Slices of Gaussians: each plane is an interval type-2 set.

    Its firing interval is known on its own.
    """
    planes = tuple(GaussianUncertainMean(mean=(1.0 - w, 1.0 + w), sigma=0.4) for w in (0.3, 0.1))
    noises = tuple(GaussianUncertainSigma(mean=0.0, sigma=(0.2 - w, 0.2 + w)) for w in (0.1, 0.05))
    x, alphas = np.array([0.1, 1.3, np.nan]), [0.5, 1.0]
    found = NonSingletonFuzzifier(ZSlices((0.5, 1.0), noises)).firing_planes(
        ZSlices((0.5, 1.0), planes), x, alphas, name
    )
    assert found.shape == (3, 2, 2)
    for k in range(2):
        np.testing.assert_allclose(
            found[:, k], NonSingletonFuzzifier(noises[k]).firing(planes[k], x, name), rtol=1e-13
        )
    # Type-1 noise, and a term without planes of its own.
    mixed = NonSingletonFuzzifier(noises[0]).firing_planes(
        ZSlices((0.5, 1.0), planes), x, alphas, name
    )
    np.testing.assert_allclose(
        mixed[:, 1], NonSingletonFuzzifier(noises[0]).firing(planes[1], x, name), rtol=1e-13
    )
    plain = NonSingletonFuzzifier(noises[0]).firing_planes(planes[0], x, alphas, name)
    np.testing.assert_array_equal(
        plain, np.stack([NonSingletonFuzzifier(noises[0]).firing(planes[0], x, name)] * 2, axis=-2)
    )


def test_planes_of_a_gaussian_type_2_term() -> None:
    """A dense grid of each plane, cuts nested.

    1e-7 is the grid's: its maxima are flat, or crossings within 2e-4 / 2 of a point.
    """
    term, noise = GaussianType2Set(Gaussian(1.0, 0.5), 0.1), Gaussian(0.0, 0.2)
    x, alphas = np.array([0.0, 0.7, 2.5]), [0.2, 0.6, 1.0]
    found = NonSingletonFuzzifier(noise).firing_planes(term, x, alphas, "product")
    points = np.linspace(-3.0, 5.0, 400_001)
    for k, alpha in enumerate(alphas):
        reach = 0.1 * math.sqrt(-2.0 * math.log(alpha))
        m = Gaussian(1.0, 0.5)(points)
        for i, measured in enumerate(x):
            ends = [
                (noise(points - measured) * grades).max()
                for grades in (np.maximum(m - reach, 0.0), np.minimum(m + reach, 1.0))
            ]
            np.testing.assert_allclose(found[i, k], ends, atol=1e-7)
    assert (np.diff(found[..., 0], axis=-1) >= -1e-9).all()
    assert (np.diff(found[..., 1], axis=-1) <= 1e-9).all()
    singleton = SingletonFuzzifier().firing_planes(term, x, alphas, "product")
    np.testing.assert_allclose(singleton[:, 2, 0], Gaussian(1.0, 0.5)(x), atol=1e-15)


def test_products_of_secondary_grades_are_refused() -> None:
    """Errata on eq. 1.120: the width falls with every refinement of the grid.

    It is .18, .14 and .09, so there is nothing to return.
    """
    term, noise = (
        GaussianType2Set(Gaussian(1.0, 0.5), 0.1),
        GaussianType2Set(Gaussian(0.0, 0.2), 0.1),
    )
    for shape, fuzzified in (
        (Gaussian(0.0, 0.2), term),
        (noise, Gaussian(1.0, 0.5)),
        (noise, term),
    ):
        with pytest.raises(NotApplicable, match="depends on how finely the input is sampled"):
            NonSingletonFuzzifier(shape).firing_planes(
                fuzzified, 0.5, [0.5, 1.0], grade_t_norm="product"
            )
    # Grades of 1 are 1 under any t-norm, and a singleton joins nothing.
    interval = GaussianUncertainMean(mean=(0.8, 1.2), sigma=0.5)
    assert NonSingletonFuzzifier(Gaussian(0.0, 0.2)).firing_planes(
        interval, 0.5, [0.5], grade_t_norm="product"
    ).shape == (1, 2)
    assert SingletonFuzzifier().firing_planes(term, 0.5, [0.5], grade_t_norm="product").shape == (
        1,
        2,
    )


def test_join_under_products_depends_on_the_grid() -> None:
    """The effect itself: the join of eq. 1.120 over N points with product grades.

    It is as wide as its cut at 1/2.
    """
    widths = []
    for count in (5, 9, 17):
        slices = [
            SampledSet(
                u := np.linspace(0.0, 1.0, 201),
                np.exp(-0.5 * ((u - float(Gaussian(0.0, 1.0)(point))) / 0.1) ** 2),
            )
            for point in np.linspace(-0.5, 0.5, count)
        ]
        joined = join(*slices, grade_t_norm="product")
        inside = joined.points[joined.grades >= 0.5 * joined.grades.max()]
        widths.append(inside.max() - inside.min())
    assert widths[0] > widths[1] > widths[2]


def test_edges_that_touch() -> None:
    """Vertical edges belong to their sets.

    An interval that just reaches a shoulder meets it fully.
    """
    shape, term = Interval(-0.1, 0.1), Interval(1.0, 2.0)
    for name in NORMS:
        np.testing.assert_array_equal(
            sup_star(shape, term, [0.9 - 1e-9, 1.5, 2.1 + 1e-9], name), [0.0, 1.0, 0.0]
        )
        assert sup_star(Interval(-0.25, 0.25), term, 0.75, name) == 1.0


def test_two_sigmoids() -> None:
    """One rises and one falls: they cross in the middle.

    Both rising reach 1 together far out, to 1e-13 of it.
    """
    assert sup_star(Sigmoid(0.0, -4.0), Sigmoid(2.0, 4.0), 0.0, "min") == pytest.approx(
        float(Sigmoid(2.0, 4.0)(1.0)), rel=1e-12
    )
    assert sup_star(Sigmoid(0.0, 4.0), Sigmoid(2.0, 4.0), 0.0, "product") == pytest.approx(
        1.0, abs=1e-13
    )


def test_sets_that_only_approach_their_maxima() -> None:
    """Two sigmoids joined: the supremum with a Gaussian between their edges.

    Against a grid (slopes of 1, steps of 2e-4).
    """
    term = join(Sigmoid(2.0, 4.0), Sigmoid(-2.0, -4.0))
    assert isinstance(term, Type1Set)
    shape, points = Gaussian(0.0, 0.6), np.linspace(-10.0, 10.0, 100_001)
    for name in NORMS:
        for x in (-0.4, 0.0, 1.5):
            expected = float(t_norm(name)(shape(points - x), term(points)).max())
            assert float(sup_star(shape, term, x, name)) == pytest.approx(expected, abs=2e-4)


def test_any_shape_and_nan() -> None:
    fuzzifier = NonSingletonFuzzifier(Triangular(-0.1, 0.0, 0.1))
    for shape in ((), (3,), (2, 0), (2, 3)):
        assert fuzzifier.firing(Gaussian(0.0, 1.0), np.zeros(shape)).shape == (*shape, 2)
        assert fuzzifier.firing_planes(
            GaussianType2Set(Gaussian(0.0, 1.0), 0.1), np.zeros(shape), [0.5, 1.0]
        ).shape == (*shape, 2, 2)
    found = fuzzifier.firing(Gaussian(0.0, 1.0), [0.0, np.nan])
    np.testing.assert_array_equal(np.isnan(found), [[False, False], [True, True]])


def test_many_rows_are_searched_in_pieces(monkeypatch: pytest.MonkeyPatch) -> None:
    """Chunks bound the memory and change nothing."""
    x = np.linspace(-2.0, 3.0, 57)
    whole = sup_star(SHAPES[4], TERMS[0], x)
    monkeypatch.setattr("fuzzy2.systems.fuzzifiers._CHUNK", 4096)
    np.testing.assert_array_equal(sup_star(SHAPES[4], TERMS[0], x), whole)


def test_refused_arguments() -> None:
    fuzzifier = NonSingletonFuzzifier(Gaussian(0.0, 0.1))
    for any_fuzzifier in (fuzzifier, SingletonFuzzifier()):
        with pytest.raises(InvalidValue, match="finite measured inputs"):
            any_fuzzifier.firing(Gaussian(0.0, 1.0), [0.0, math.inf])
        with pytest.raises(UnknownName, match="lukasiewicz"):
            any_fuzzifier.firing(Gaussian(0.0, 1.0), 0.0, "mean")
        for alphas in ([], [1.5], 0.5, [np.nan]):
            with pytest.raises(InvalidValue, match="levels in"):
                any_fuzzifier.firing_planes(GaussianType2Set(Gaussian(0.0, 1.0), 0.1), 0.0, alphas)
    with pytest.raises(InvalidValue, match="shape must be a type-1"):
        NonSingletonFuzzifier(0.1)
    assert (
        repr(fuzzifier) == "NonSingletonFuzzifier(shape=Gaussian(mean=0.0, sigma=0.1, height=1.0))"
    )
