"""Reduction of general type-2 sets.

Alpha-planes against enumeration, both against what is known in closed form, and what is refused.
"""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fuzzy2.errors import InvalidValue, NotApplicable, TooManyEmbeddedSets, UnknownName
from fuzzy2.numbers import FuzzyNumber, GaussianNumber
from fuzzy2.reduction.approximate import approximate_centroid
from fuzzy2.reduction.defuzzification import defuzzify_samples
from fuzzy2.reduction.general import (
    MOST_EMBEDDED_SETS,
    alpha_plane_centroid,
    alpha_plane_defuzzify,
    alpha_plane_reduction,
    cut_centroid,
    exhaustive_centroid,
    exhaustive_generalized_centroid,
)
from fuzzy2.reduction.interval import METHODS, centroid, generalized_centroid
from fuzzy2.sets.gaussian_type2 import GaussianType2Set
from fuzzy2.sets.general_type2 import SampledType2Set, ZSlices
from fuzzy2.sets.interval_type2 import GaussianUncertainMean
from fuzzy2.sets.shapes import Gaussian, Interval, Triangular
from fuzzy2.sets.sigmoids import Sigmoid
from fuzzy2.sets.type1 import SampledSet, Singleton

ALPHAS = np.array([0.2, 0.4, 0.6, 0.8, 1.0])


def enumerated(Z: list[SampledSet], W: list[SampledSet], t_norm: str) -> dict[float, float]:
    """Eq. 1.84 as it is written.

    Every combination, one after another, greatest grade of each average to 10 digits.
    """
    combine = min if t_norm == "min" else lambda a, b: a * b
    best: dict[float, float] = {}
    pairs = [list(zip(item.points, item.grades, strict=True)) for item in (*Z, *W)]
    for chosen in itertools.product(*pairs):
        z, w = chosen[: len(Z)], chosen[len(Z) :]
        mass = sum(value for value, _ in w)
        if mass > 0.0:
            grade = 1.0
            for _, single in chosen:
                grade = combine(grade, single)
            y = round(sum(a * b for (a, _), (b, _) in zip(z, w, strict=True)) / mass, 10)
            best[y] = max(best.get(y, 0.0), grade)
    return best


grades = st.sampled_from([0.25, 0.5, 0.75, 1.0])
weights = st.sampled_from([0.0, 0.1, 0.3, 0.5, 0.8, 1.0])


def discrete(points: st.SearchStrategy[float]) -> st.SearchStrategy[SampledSet]:
    pairs = st.lists(
        st.tuples(points, grades), min_size=1, max_size=3, unique_by=lambda pair: pair[0]
    )
    return pairs.map(
        lambda chosen: SampledSet([point for point, _ in chosen], [grade for _, grade in chosen])
    )


@pytest.mark.slow
@given(
    st.integers(1, 3).flatmap(
        lambda n: st.tuples(
            st.lists(
                discrete(st.sampled_from([-2.0, -0.5, 0.0, 1.0, 3.0])), min_size=n, max_size=n
            ),
            st.lists(discrete(weights), min_size=n, max_size=n),
        )
    ),
    st.sampled_from(["min", "product"]),
)
@settings(max_examples=200, deadline=None)
def test_enumeration_is_equation_1_84_term_by_term(
    sets: tuple[list[SampledSet], list[SampledSet]], t_norm: str
) -> None:
    expected = enumerated(*sets, t_norm)
    if not expected:
        with pytest.raises(NotApplicable, match="weight"):
            exhaustive_generalized_centroid(*sets, t_norm)
        return
    found = exhaustive_generalized_centroid(*sets, t_norm)
    # the oracle rounds to 1e-10
    np.testing.assert_allclose(found.set.points, sorted(expected), atol=1e-9)
    np.testing.assert_allclose(
        found.set.grades, [expected[y] for y in sorted(expected)], atol=1e-15
    )
    assert found.crisp == pytest.approx(
        float(defuzzify_samples(found.set.points, found.set.grades)), abs=1e-12
    )


@pytest.mark.parametrize("scale", [1e-9, 1.0, 1e9])
def test_scale_of_the_output(scale: float) -> None:
    """Sets of tiny outputs do not melt into one point."""
    W = [SampledSet([0.2, 0.5], [1.0, 0.5]), SampledSet([0.4, 0.9], [0.5, 1.0])]
    base, scaled = (
        exhaustive_generalized_centroid([1.0 * factor, 2.0 * factor], W) for factor in (1.0, scale)
    )
    assert len(base.set) == 4
    np.testing.assert_allclose(scaled.set.points, scale * base.set.points, rtol=1e-14)
    assert scaled.crisp == pytest.approx(scale * base.crisp, rel=1e-14)


def test_one_rule_fires() -> None:
    """Eq. 1.77: of one rule the height reducer gives a point, of grade 1.

    Eq. 1.82: center of sets gives its centroid.
    """
    firing, centroid_set = (
        SampledSet([0.2, 0.5, 0.7], [0.4, 1.0, 0.3]),
        SampledSet([1.0, 2.0, 4.0], [0.5, 1.0, 0.7]),
    )
    for t_norm in ("min", "product"):
        height = exhaustive_generalized_centroid([3.0], [firing], t_norm)
        np.testing.assert_allclose(
            [height.set.points, height.set.grades], [[3.0], [1.0]], atol=1e-15
        )
        # A rule that does not fire does not matter.
        for Z, W in (
            ([centroid_set], [firing]),
            ([centroid_set, 9.0], [firing, SampledSet([0.0], [1.0])]),
        ):
            found = exhaustive_generalized_centroid(Z, W, t_norm).set
            np.testing.assert_allclose(found.points, centroid_set.points, rtol=1e-15)
            np.testing.assert_array_equal(found.grades, centroid_set.grades)
    planes = alpha_plane_reduction(
        [0.5, 1.0], [[1.0, 4.0], [8.0, 9.0]], [[[0.2, 0.7], [0.0, 0.0]], [[0.5, 0.5], [0.0, 0.0]]]
    )
    np.testing.assert_array_equal(planes.intervals, [[1.0, 4.0], [1.0, 4.0]])


def test_symmetric_consequents_make_center_of_sets_the_height_reducer() -> None:
    """Text after eq. 1.78: centroids are the points of maximum membership.

    Consequents are convex, normal, symmetric type-1 sets.
    """
    consequents = [Triangular(0.0, 1.0, 2.0), Gaussian(2.5, 0.4), Triangular(3.0, 4.5, 6.0)]
    by_centroid = np.array([item.centroid() for item in consequents])
    by_height = np.array([item.maxima[0] for item in consequents])
    firing = np.array([[[0.1, 0.4], [0.3, 0.9], [0.2, 0.6]], [[0.2, 0.3], [0.5, 0.7], [0.4, 0.5]]])
    found, expected = (
        alpha_plane_reduction([0.5, 1.0], z, firing) for z in (by_centroid, by_height)
    )
    np.testing.assert_allclose(found.intervals, expected.intervals, atol=1e-12)


def test_planes_agree_with_enumeration_of_continuous_sets() -> None:
    """Under the minimum the cut of the type-reduced set is the reduction of the cuts.

    That is why alpha-planes are exact.

    Triangles sampled at 31 points have the ends of these four cuts among the samples, and the
    extreme averages take ends of cuts only.
    """
    Z, W = (
        [Triangular(0.0, 1.0, 2.0), Triangular(2.0, 3.0, 4.0)],
        [Triangular(0.1, 0.3, 0.5), Triangular(0.4, 0.6, 0.8)],
    )
    sampled = exhaustive_generalized_centroid(Z, W, samples=31)
    alphas = np.array([0.2, 0.4, 0.6, 0.8])
    z = np.array([[item.alpha_cut(alpha) for item in Z] for alpha in alphas])
    w = np.array([[item.alpha_cut(alpha) for item in W] for alpha in alphas])
    planes = alpha_plane_reduction(alphas, z, w)
    for alpha, interval in zip(alphas, planes.intervals, strict=True):
        reached = sampled.set.points[sampled.set.grades >= alpha - 1e-9]
        np.testing.assert_allclose([reached.min(), reached.max()], interval, atol=1e-12)


def test_centroid_by_planes_against_enumeration() -> None:
    """A discrete-membership set whose slices hold the ends of their own cuts at every level.

    Enumeration must reach the same ends.
    """
    x = np.array([1.0, 2.0, 4.0])
    lefts, rights = (
        np.array([[0.1, 0.3, 0.0], [0.2, 0.5, 0.1]]),
        np.array([[0.5, 0.9, 0.4], [0.3, 0.8, 0.2]]),
    )
    slices = [
        SampledSet([*lefts[:, i], *rights[:, i]], [0.5, 1.0, 0.5, 1.0]) for i in range(3)
    ]  # convex: grade 1 within the interval of grade 1/2
    by_sets = exhaustive_centroid(SampledType2Set(x, slices))
    planes = alpha_plane_reduction([0.5, 1.0], x, np.stack([lefts, rights], axis=-1))
    for alpha, interval in zip(planes.alphas, planes.intervals, strict=True):
        reached = by_sets.set.points[by_sets.set.grades >= alpha]
        np.testing.assert_allclose([reached.min(), reached.max()], interval, atol=1e-13)
    by_slices = alpha_plane_centroid(SampledType2Set(x, slices), x, [0.5, 1.0])
    np.testing.assert_allclose(by_slices.intervals, planes.intervals, atol=1e-13)


@pytest.mark.parametrize("method", METHODS)
def test_planes_are_one_exact_reduction_per_level(method: str) -> None:
    fuzzy_set, x = GaussianType2Set(Gaussian(2.0, 0.8), 0.1), np.linspace(0.0, 4.0, 41)
    found = alpha_plane_centroid(fuzzy_set, x, ALPHAS, method)
    for alpha, interval in zip(ALPHAS, found.intervals, strict=True):
        reach = 0.1 * np.sqrt(-2.0 * np.log(alpha))
        m = Gaussian(2.0, 0.8)(x)
        np.testing.assert_allclose(
            interval,
            centroid(x, np.maximum(m - reach, 0.0), np.minimum(m + reach, 1.0)),
            atol=1e-13,
        )
    assert (np.diff(found.intervals[:, 0]) >= 0.0).all()
    assert (np.diff(found.intervals[:, 1]) <= 0.0).all()


def test_gaussian_set_by_planes_and_by_the_corollary() -> None:
    """Narrow secondaries: the cuts are those of the Gaussian of eq. 1.112-1.113.

    But for terms of the second order in the validity.
    """
    x, sigma = np.linspace(0.0, 4.0, 41), 0.002
    fuzzy_set = GaussianType2Set(
        Gaussian(2.2, 0.8), lambda points: sigma * Gaussian(2.2, 0.8)(points)
    )
    exact = alpha_plane_centroid(fuzzy_set, x, ALPHAS)
    found = approximate_centroid(
        x, GaussianNumber(fuzzy_set.principal(x), fuzzy_set.spread(x), "min")
    )
    assert found.validity == pytest.approx(2.0 * sigma, abs=1e-15)
    cuts = np.stack([found.value.interval(alpha) for alpha in ALPHAS])
    # (1.8 sigma)² of the range at the lowest level; the cut there is 4e-3 wide.
    np.testing.assert_allclose(cuts, exact.intervals, atol=4.0 * (1.8 * sigma) ** 2)
    assert float(np.diff(exact.intervals[0])[0]) > 4e-3


def test_batches_and_layers_of_points() -> None:
    """A batch gives what its items give, with points that are shared, per level, and crisp."""
    rng = np.random.default_rng(0)
    center, half = rng.uniform(0.3, 0.7, (4, 3, 1, 6)), rng.uniform(0.0, 0.3, (4, 3, 1, 6))
    w = np.stack([center - half * [[1.0], [0.5]], center + half * [[1.0], [0.5]]], axis=-1)
    z = np.sort(rng.normal(size=(6, 2)), axis=-1)
    narrower = np.stack([z, z + [0.1, -0.1] * np.diff(z)])
    for points in (z, z[:, 0], narrower):
        found = alpha_plane_reduction([0.5, 1.0], points, w)
        assert found.intervals.shape == (4, 3, 2, 2)
        assert found.crisp.shape == (4, 3)
        for i, j in np.ndindex(4, 3):
            for k in range(2):
                expected = generalized_centroid(
                    points[k] if points.ndim == 3 else points, w[i, j, k]
                )
                np.testing.assert_allclose(found.intervals[i, j, k], expected, atol=1e-14)
            single = alpha_plane_reduction([0.5, 1.0], points, w[i, j])
            np.testing.assert_allclose(found.crisp[i, j], single.crisp, atol=1e-14)


def test_as_many_points_as_two_crisp_ones() -> None:
    """Two crisp points are points, and not one interval."""
    found = alpha_plane_reduction([1.0], [3.0, 1.0], [[[0.5, 0.5], [0.5, 0.5]]])
    np.testing.assert_array_equal(found.intervals, [[2.0, 2.0]])


def test_crisp_value_is_the_average_weighted_by_level() -> None:
    intervals = np.array([[1.0, 5.0], [2.0, 3.0]])
    assert alpha_plane_defuzzify([0.5, 1.0], intervals) == pytest.approx(
        (0.5 * 3.0 + 1.0 * 2.5) / 1.5, abs=1e-15
    )
    np.testing.assert_allclose(
        alpha_plane_defuzzify([0.5, 1.0], np.stack([intervals, intervals + 1.0])),
        [8.0 / 3.0, 11.0 / 3.0],
    )
    with pytest.raises(InvalidValue, match="one cut for each level"):
        alpha_plane_defuzzify([0.5, 1.0], intervals[:1])


def nested_cuts(rng: np.random.Generator, count: int, levels: int) -> np.ndarray:
    """Return random nested cuts (count, levels, 2), the lowest level first."""
    steps = rng.exponential(1.0, (count, levels, 2)) * rng.integers(0, 2, (count, levels, 2))
    left = rng.normal(0.0, 5.0, (count, 1)) + np.cumsum(steps[..., 0], axis=-1)
    width = rng.exponential(1.0, (count, 1)) * rng.integers(0, 2, (count, 1))
    right = left[:, -1:] + width + np.cumsum(steps[:, ::-1, 1], axis=-1)[:, ::-1]
    return np.stack([left, right], axis=-1)


def test_centroid_of_cuts_is_equation_1_69_on_a_fine_grid() -> None:
    """The membership is read off the cuts, point by point, by interpolation.

    Sides up to the lowest level are jumps, which 200 000 points see to within their distance: 1e-4
    of the support. Sets without width are their point.
    """
    levels = np.array([0.1, 0.3, 0.5, 0.9, 1.0])
    cuts = nested_cuts(np.random.default_rng(0), 200, levels.size)
    assert cut_centroid(levels, np.full((5, 2), 0.3)) == 0.3
    found = cut_centroid(levels, cuts)
    for (left, right), centroid_of_one in zip(np.moveaxis(cuts, -1, 1), found, strict=True):
        x = left[0] + (right[0] - left[0]) * (np.arange(200_000) + 0.5) / 200_000
        # Of equal ends, a jump, the highest level counts.
        rising = np.interp(x, left + 1e-12 * levels, levels)
        falling = np.interp(-x, -right + 1e-12 * levels, levels)
        expected = defuzzify_samples(x, np.minimum(rising, falling))
        assert centroid_of_one == pytest.approx(expected, abs=1e-4 * (right[0] - left[0]))


def test_centroid_of_cuts_is_that_of_sets_known_in_closed_form() -> None:
    """Sets with straight sides from the lowest level on are exact: 1e-12.

    The triangle (0, 0, 1) plus the interval [0, 1] has the cut [0, 2 − α] and the centroid 7/9; a
    triangle has the mean of its corners. A Gaussian cut off at 1e-6 and a symmetric one far from
    zero have their middles. Cuts of a fuzzy number are those of its own integral.
    """
    levels = np.array([1e-15, 0.25, 0.6, 1.0])
    sums = np.stack([0.0 * levels, 2.0 - levels], axis=-1)
    assert cut_centroid(levels, sums) == pytest.approx(7.0 / 9.0, abs=1e-12)
    triangle = np.stack(Triangular(-1.0, 0.0, 4.0).alpha_cut(levels), axis=-1)
    assert cut_centroid(levels, triangle) == pytest.approx(1.0, abs=1e-12)
    far = np.stack(Gaussian(1e9, 0.5).alpha_cut(np.array([0.2, 0.6, 1.0])), axis=-1)
    assert cut_centroid([0.2, 0.6, 1.0], far) == pytest.approx(1e9, abs=1e-6)
    cuts = nested_cuts(np.random.default_rng(1), 50, 4)
    from_zero = np.concatenate([cuts[:, :1], cuts], axis=1)
    numbers = FuzzyNumber(from_zero[..., 0], from_zero[..., 1], [0.0, 0.2, 0.3, 0.8, 1.0])
    np.testing.assert_allclose(
        cut_centroid([0.2, 0.3, 0.8, 1.0], cuts), numbers.defuzzify(), rtol=0.0, atol=1e-11
    )


def test_centroid_of_cuts_of_one_level_of_many_sets_and_of_nothing() -> None:
    """One cut is an interval, and shapes are kept.

    Where a cut is missing, so is the centroid, without a warning.
    """
    assert cut_centroid([1.0], [[1.0, 4.0]]) == 2.5
    cuts = nested_cuts(np.random.default_rng(2), 6, 5).reshape(2, 3, 5, 2)
    found = cut_centroid(ALPHAS, cuts)
    assert found.shape == (2, 3)
    assert found[1, 2] == cut_centroid(ALPHAS, cuts[1, 2])
    cuts[0, 1, 3] = np.nan
    np.testing.assert_array_equal(
        np.isnan(cut_centroid(ALPHAS, cuts)), [[False, True, False], [False] * 3]
    )
    with pytest.raises(InvalidValue, match="one cut for each level"):
        cut_centroid([0.5, 1.0], cuts)
    with pytest.raises(InvalidValue, match="ascending"):
        cut_centroid([1.0, 0.5], [[0.0, 1.0], [0.0, 1.0]])


def test_sees_the_uncertainty_that_the_corollary_does_not() -> None:
    """Errata on eq. 1.107: an asymmetric system moves with its uncertainty.

    The corollary's mean does not.
    """
    x = np.array([0.0, 1.0, 4.0])
    crisp = [
        float(
            alpha_plane_centroid(
                GaussianType2Set(SampledSet(x, [1.0, 0.5, 0.1]), s), x, ALPHAS
            ).crisp
        )
        for s in (0.0, 0.05, 0.2)
    ]
    assert crisp[0] == pytest.approx((0.5 + 0.4) / 1.6, abs=1e-14)
    assert crisp[0] < crisp[1] - 1e-3 < crisp[2] - 1e-2


def test_one_zslice_is_the_interval_set() -> None:
    fuzzy_set, x = GaussianUncertainMean(mean=(1.8, 2.2), sigma=0.7), np.linspace(0.0, 4.0, 81)
    found = alpha_plane_centroid(ZSlices((1.0,), (fuzzy_set,)), x, [1.0])
    np.testing.assert_array_equal(
        found.intervals[0], centroid(x, fuzzy_set.lower(x), fuzzy_set.upper(x))
    )


def test_nothing_has_weight() -> None:
    found = alpha_plane_reduction([0.5, 1.0], [1.0, 2.0], np.zeros((2, 2, 2)))
    assert np.isnan(found.intervals).all()
    assert np.isnan(found.crisp)
    with pytest.raises(NotApplicable, match="weight"):
        exhaustive_generalized_centroid([1.0, 2.0], [SampledSet([0.0], [1.0]), 0.0])


@pytest.mark.parametrize(
    ("alphas", "z", "w", "message"),
    [
        ([], [1.0], np.ones((0, 1, 2)), "levels"),
        ([0.0, 1.0], [1.0], np.ones((2, 1, 2)), "levels"),
        ([1.0, 0.5], [1.0], np.ones((2, 1, 2)), "ascending"),
        ([0.5, 1.1], [1.0], np.ones((2, 1, 2)), "levels"),
        ([np.nan], [1.0], np.ones((1, 1, 2)), "levels"),
        ([0.5, 1.0], [1.0], np.ones((3, 1, 2)), "one layer for each level"),
        ([0.5, 1.0], [1.0], np.ones((1, 2)), "one layer for each level"),
        ([0.5, 1.0], np.ones((3, 1, 2)), np.ones((2, 1, 2)), "z must be of shape"),
        ([0.5, 1.0], [1.0], [[[0.4, 0.6]], [[0.3, 0.6]]], "w must be nested"),
        ([0.5, 1.0], [[[1.0, 2.0]], [[1.0, 2.1]]], np.ones((2, 1, 2)), "z must be nested"),
    ],
)
def test_refused_planes(alphas: list[float], z: np.ndarray, w: np.ndarray, message: str) -> None:
    with pytest.raises(InvalidValue, match=message):
        alpha_plane_reduction(alphas, z, w)


def test_unknown_method() -> None:
    with pytest.raises(UnknownName, match="eiasc"):
        alpha_plane_reduction([1.0], [1.0], [[[0.5, 0.5]]], "newton")


def test_refuses_to_enumerate_too_much() -> None:
    W = [SampledSet(np.linspace(0.1, 1.0, 10), np.ones(10))] * 7
    with pytest.raises(TooManyEmbeddedSets, match="10,000,000 embedded sets") as caught:
        exhaustive_generalized_centroid(np.arange(7.0), W)
    assert (caught.value.count, caught.value.limit) == (10**7, MOST_EMBEDDED_SETS)
    with pytest.raises(TooManyEmbeddedSets):
        exhaustive_centroid(SampledType2Set(np.arange(2.0), W[:2]), limit=99)
    assert exhaustive_centroid(SampledType2Set(np.arange(2.0), W[:2]), limit=100).crisp > 0.0


def test_products_of_continuous_secondary_grades_are_refused() -> None:
    """The reason, first: under the product the result depends on the samples.

    Intervals have grades of 1 only, so they may.
    """
    W = [Triangular(0.2, 0.5, 0.8), Triangular(0.3, 0.6, 0.9)]
    with pytest.raises(NotApplicable, match="depends on the grid"):
        exhaustive_generalized_centroid([1.0, 2.0], W, "product", samples=5)
    with pytest.raises(NotApplicable, match="how many samples"):
        exhaustive_generalized_centroid([1.0, 2.0], W)
    intervals = [Interval(0.2, 0.4), Interval(0.5, 0.9)]
    by_norm = [
        exhaustive_generalized_centroid([1.0, 2.0], intervals, norm, samples=5).set
        for norm in ("min", "product")
    ]
    assert by_norm[0] == by_norm[1]
    expected = generalized_centroid([[1.0], [2.0]] @ np.ones((1, 2)), [[0.2, 0.4], [0.5, 0.9]])
    np.testing.assert_allclose(by_norm[0].support, expected, atol=1e-14)
    with pytest.raises(NotApplicable, match="does not fall to 0"):
        exhaustive_generalized_centroid([1.0], [Sigmoid(0.5, 10.0)], samples=5)


def test_crisp_numbers_and_singletons_are_discrete_sets() -> None:
    found = exhaustive_generalized_centroid([1.0, Singleton(2.0)], [Singleton(0.5), 0.25])
    assert (found.set.points.tolist(), found.crisp) == (
        pytest.approx([4.0 / 3.0]),
        pytest.approx(4.0 / 3.0),
    )


@pytest.mark.parametrize(
    ("Z", "W", "message"),
    [
        ([1.0, 2.0], [SampledSet([0.5], [1.0])], "as many points as weights"),
        ([], [], "at least one"),
        ([1.0], [SampledSet([-0.5], [1.0])], "not negative"),
        ([1.0], [-0.5], "not negative"),
        ([np.nan], [0.5], "finite"),
        (["a"], [0.5], "finite"),
    ],
)
def test_refused_enumerations(Z: list[float], W: list[SampledSet], message: str) -> None:
    with pytest.raises(InvalidValue, match=message):
        exhaustive_generalized_centroid(Z, W)
