"""Interval type-2 sets.

Published and closed-form centroids, brute force over all switch points, embedded sets, and what is
refused.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fuzzy2.errors import InvalidValue, NotApplicable
from fuzzy2.sets import interval_type2
from fuzzy2.sets.derived import FunctionalSet, Truncated
from fuzzy2.sets.interval_type2 import (
    EmbeddedSet,
    GaussianUncertainMean,
    GaussianUncertainSigma,
    IntervalType2Set,
)
from fuzzy2.sets.shapes import Gaussian, Interval, Trapezoidal, Triangular
from fuzzy2.sets.sigmoids import Sigmoid
from fuzzy2.sets.smooth_shapes import Bell
from fuzzy2.sets.type1 import SampledSet, Singleton


def brute_force_centroid(
    x: np.ndarray, lower: np.ndarray, upper: np.ndarray
) -> tuple[float, float]:
    """Smallest and largest weighted mean over all switch points."""
    before = np.tri(len(x) + 1, len(x), -1, dtype=bool)
    rising, falling = np.where(before, upper, lower), np.where(before, lower, upper)
    return float(np.min(rising @ x / rising.sum(axis=1))), float(
        np.max(falling @ x / falling.sum(axis=1))
    )


GRID = np.linspace(0.0, 10.0, 101)

# Mendel, Uncertain Rule-Based Fuzzy Logic Systems (2001), Table 9-1, p. 261, sigma = 1: printed to
# four digits, and exact on the grid.
TABLE_9_1 = [
    ((5.0, 5.0), (5.0, 5.0), (4.999999999999998, 5.000000000000001)),
    ((4.875, 5.125), (4.875, 5.125), (4.874976892607403, 5.125023107392598)),
    ((4.75, 5.25), (4.7495, 5.2505), (4.7495227136366776, 5.2504772863633224)),
    ((4.625, 5.375), (4.6226, 5.3774), (4.6226465066392075, 5.377353493360793)),
    ((4.5, 5.5), (4.4928, 5.5072), (4.492848159665463, 5.507151840334537)),
    ((4.0, 6.0), (3.907, 6.093), (3.906968685315566, 6.093031314684435)),
    ((3.75, 6.25), (3.5519, 6.4481), (3.5519382396186745, 6.448061760381325)),
    ((3.5, 6.5), (3.1505, 6.8495), (3.1505338400824456, 6.849466159917555)),
]
# Same book, set-up of Table 9-2, pp. 261-262, mean = 5: values quoted to five digits, and exact on
# the grid.
TABLE_9_2 = [
    ((1.0, 1.0), (5.0, 5.0), (4.999999999999998, 5.000000000000001)),
    ((0.875, 1.125), (4.80054, 5.19946), (4.800538905831928, 5.19946109416807)),
    ((0.75, 1.25), (4.60079, 5.39921), (4.600785600368773, 5.399214399631227)),
    ((0.5, 1.5), (4.18488, 5.81512), (4.184879402990295, 5.815120597009705)),
    ((0.375, 1.625), (3.93441, 6.06559), (3.9344051996608655, 6.0655948003391345)),
    ((0.25, 1.75), (3.59388, 6.40612), (3.5938779205359457, 6.406122079464053)),
]


@pytest.mark.parametrize(("mean", "published", "exact"), TABLE_9_1)
def test_table_9_1_from_the_memberships(
    mean: tuple[float, float], published: tuple[float, float], exact: tuple[float, float]
) -> None:
    """Printed values are off by up to 1e-4 (4.4928 for 4.49285).

    1e-9 is the vectors' own tolerance.
    """
    fuzzy_set = GaussianUncertainMean(mean=mean, sigma=1.0)
    found = brute_force_centroid(GRID, fuzzy_set.lower(GRID), fuzzy_set.upper(GRID))
    np.testing.assert_allclose(found, exact, atol=1e-9)
    np.testing.assert_allclose(found, published, atol=1.01e-4)


@pytest.mark.parametrize(("sigma", "quoted", "exact"), TABLE_9_2)
def test_table_9_2_from_the_memberships(
    sigma: tuple[float, float], quoted: tuple[float, float], exact: tuple[float, float]
) -> None:
    """The quoted values are from a grid that stops at 3e-5 of the exact ones."""
    fuzzy_set = GaussianUncertainSigma(mean=5.0, sigma=sigma)
    found = brute_force_centroid(GRID, fuzzy_set.lower(GRID), fuzzy_set.upper(GRID))
    np.testing.assert_allclose(found, exact, atol=1e-9)
    np.testing.assert_allclose(found, quoted, atol=3e-5)


def between(lower: float, upper: float) -> IntervalType2Set:
    return IntervalType2Set(
        lower=Trapezoidal(0.0, 0.0, 1.0, 1.0, lower), upper=Trapezoidal(0.0, 0.0, 1.0, 1.0, upper)
    )


@pytest.mark.parametrize("h", [1e-12, 0.04, 0.25, 0.5, 0.81, 1.0])
def test_centroid_of_a_constant_footprint(h: float) -> None:
    """sqrt(h) / (1 + sqrt(h)) in closed form; 1e-13 is rounding.

    The vectors hold 1/6, 1/3, 0.4142... and 0.4737...
    """
    left, right = between(h, 1.0).centroid()
    assert left == pytest.approx(math.sqrt(h) / (1.0 + math.sqrt(h)), rel=1e-13)
    assert right == pytest.approx(1.0 / (1.0 + math.sqrt(h)), rel=1e-13)


@pytest.mark.parametrize(("h", "right"), [(0.25, 0.2290830029407519), (0.75, 0.047942150319381725)])
def test_centroid_of_a_scaled_triangle(h: float, right: float) -> None:
    """Root of (1 - h)(1 + c)³ = -6 h c; 1e-13 is rounding."""
    left, found = IntervalType2Set(
        lower=Triangular(-1.0, 0.0, 1.0, h), upper=Triangular(-1.0, 0.0, 1.0)
    ).centroid()
    assert found == pytest.approx(right, abs=1e-13)
    assert left == pytest.approx(-right, abs=1e-13)
    assert (1.0 - h) * (1.0 + left) ** 3 == pytest.approx(-6.0 * h * left, abs=1e-13)


@pytest.mark.parametrize(
    ("mean", "sigma", "expected"),
    [
        ((4.0, 6.0), 1.0, (3.9060137570053928, 6.093986242994609)),
        ((-0.1, 0.1), 0.8, (-0.10002573052908137, 0.10002573052908142)),
        ((-0.5, 0.5), 1.0, (-0.5074013356646513, 0.5074013356646513)),
    ],
)
def test_continuous_centroid_of_a_gaussian_with_uncertain_mean(
    mean: tuple[float, float], sigma: float, expected: tuple[float, float]
) -> None:
    """The vectors' values, to 1e-12 of the width."""
    np.testing.assert_allclose(
        GaussianUncertainMean(mean, sigma).centroid(), expected, atol=2e-14 * 10, rtol=1e-14
    )


@pytest.mark.parametrize("scale", [1e-9, 1.0, 1e9])
@pytest.mark.parametrize("shift", [0.0, 100.0])
def test_centroids_move_and_scale_with_the_set(scale: float, shift: float) -> None:
    """1e-13 of the largest number."""
    reference = np.array(GaussianUncertainMean((4.0, 6.0), 1.0).centroid())
    moved = GaussianUncertainMean(((4.0 + shift) * scale, (6.0 + shift) * scale), scale).centroid()
    np.testing.assert_allclose(np.array(moved) / scale, reference + shift, rtol=1e-13)


# Upper and lower trapezoids of words in a codebook of 15 (parameters quoted in the vectors), exact
# on a grid of 100 001 points.
WORDS = [
    ((0, 0, 0.46, 2.63), (0, 0, 0.06, 0.92, 1), (0.302238411013326, 0.9940598998607022)),
    (
        (0.38, 1.63, 3.0, 4.62),
        (1.9, 2.24, 2.24, 2.51, 0.31),
        (1.2589847841122968, 3.549925354342756),
    ),
    (
        (0.98, 2.75, 4.0, 5.46),
        (2.79, 3.3, 3.3, 3.71, 0.42),
        (2.2554400372190098, 4.267828953176894),
    ),
    (
        (0.17, 2.73, 4.8, 7.91),
        (3.29, 3.75, 3.75, 4.21, 0.31),
        (1.7941186376193103, 6.074391205250622),
    ),
    ((4.38, 6.25, 8, 9.62), (6.9, 7.21, 7.21, 7.6, 0.29), (5.608524318363281, 8.534199138300991)),
    ((5.59, 6.75, 8, 9.56), (6.79, 7.3, 7.3, 7.71, 0.42), (6.568957130328154, 8.320284505577668)),
    ((6.05, 9.36, 10, 10), (8.71, 9.91, 10, 10, 1), (8.497829108271459, 9.575601079285768)),
]


@pytest.mark.parametrize(("upper", "lower", "expected"), WORDS)
def test_centroids_of_words(
    upper: tuple[float, ...], lower: tuple[float, ...], expected: tuple[float, float]
) -> None:
    """Grid step 1e-4: 1e-8 for the rounded off interior.

    Up to 5e-5 where a shoulder ends at full membership at an end of the grid.
    """
    centroid = IntervalType2Set(lower=Trapezoidal(*lower), upper=Trapezoidal(*upper)).centroid()
    np.testing.assert_allclose(
        centroid, expected, atol=5e-5 if upper[0] == upper[1] or upper[2] == upper[3] else 1e-8
    )


@settings(max_examples=60, deadline=None)
@given(
    corners=st.lists(st.floats(0.0, 10.0), min_size=8, max_size=8),
    height=st.floats(0.05, 1.0),
)
def test_centroids_of_trapezoids_against_enumeration_on_a_fine_grid(
    corners: list[float], height: float
) -> None:
    """Midpoint sums over 4000 cells: the mean of 1e-6 relative errors.

    Steep edges count for a cell, 10/4000.
    """
    a, b, c, d = sorted(corners[:4])
    d = max(d, a + 1.0)
    c = min(max(c, b), d)
    inner = np.sort(np.interp(corners[4:], [0.0, 10.0], [b, c]))
    fuzzy_set = IntervalType2Set(
        lower=Trapezoidal(*inner, height=height), upper=Trapezoidal(a, b, c, d)
    )
    middles = a + (d - a) * (np.arange(4000) + 0.5) / 4000.0
    found = np.array(fuzzy_set.centroid())
    lower, upper = fuzzy_set.lower(middles), fuzzy_set.upper(middles)
    if lower.sum() > 40.0:  # otherwise the grid does not see the lower set
        # All switch points through cumulative sums: the same enumeration, with less memory.
        def means(before: np.ndarray, after: np.ndarray) -> np.ndarray:
            weight = np.append(0.0, np.cumsum(before)) + np.append(
                np.cumsum(after[::-1])[::-1], 0.0
            )
            moment = np.append(0.0, np.cumsum(before * middles)) + np.append(
                np.cumsum((after * middles)[::-1])[::-1], 0.0
            )
            return moment / weight

        np.testing.assert_allclose(
            found, [means(upper, lower).min(), means(lower, upper).max()], atol=2e-3 * (d - a)
        )


@pytest.mark.slow
@settings(max_examples=60, deadline=None)
@given(mean=st.tuples(st.floats(-5.0, 5.0), st.floats(0.0, 4.0)), sigma=st.floats(0.2, 3.0))
def test_the_ends_of_the_centroid_are_centroids_of_embedded_sets_that_switch_there(
    mean: tuple[float, float], sigma: float
) -> None:
    """The fixed point of the definition.

    No other switch point or random embedded set goes further; 1e-12 relative.
    """
    fuzzy_set = GaussianUncertainMean((mean[0], mean[0] + mean[1]), sigma)
    left, right = fuzzy_set.centroid()
    slack = 1e-12 * (1.0 + abs(left) + abs(right))
    assert fuzzy_set.embedded(left).centroid() == pytest.approx(left, abs=slack)
    assert fuzzy_set.embedded(right, upper_first=False).centroid() == pytest.approx(
        right, abs=slack
    )
    for switch in np.linspace(left - sigma, right + sigma, 5):
        assert fuzzy_set.embedded(float(switch)).centroid() >= left - slack
        assert fuzzy_set.embedded(float(switch), upper_first=False).centroid() <= right + slack
    assert left - slack <= fuzzy_set.embedded(np.random.default_rng(0)).centroid() <= right + slack


def test_a_lower_membership_of_almost_nothing_moves_the_centroid_far_out_and_symmetrically() -> (
    None
):
    """The end c solves ∫_{-inf}^{c} (c - x) U dx = -h ∫_c^inf (x - c) U dx.

    Left side about exp(-c²/2)/c². 1e-9 for the tail's rounding.
    """
    for h in (1e-6, 1e-30, 1e-300):
        left, right = IntervalType2Set(
            lower=Gaussian(0.0, 1.0, h), upper=Gaussian(0.0, 1.0)
        ).centroid()
        assert right == pytest.approx(-left, rel=1e-12)
        density, area = (
            math.exp(-0.5 * right**2),
            math.sqrt(0.5 * math.pi) * math.erfc(right / math.sqrt(2.0)),
        )
        # Balance of moments about the right end: (1 - h)(∫_c U (x - c)) = h c sqrt(2 pi).
        assert (1.0 - h) * (density - right * area) == pytest.approx(
            h * right * math.sqrt(2.0 * math.pi), rel=1e-9
        )


def test_centroids_without_uncertainty_are_those_of_the_type_1_set() -> None:
    """1e-14: the same quadrature, and a root of it."""
    for lower, fuzzy_set in (
        (Gaussian(3.0, 0.5), GaussianUncertainMean((3.0, 3.0), 0.5)),
        (Gaussian(3.0, 0.5), GaussianUncertainSigma(3.0, (0.5, 0.5))),
        (
            Triangular(0.0, 0.2, 1.0),
            IntervalType2Set(lower=Triangular(0.0, 0.2, 1.0), upper=Triangular(0.0, 0.2, 1.0)),
        ),
        (Singleton(0.5), IntervalType2Set(lower=Singleton(0.5), upper=Singleton(0.5))),
    ):
        np.testing.assert_allclose(fuzzy_set.centroid(), lower.centroid(), rtol=1e-14)
        np.testing.assert_array_equal(fuzzy_set.lower([2.0, 2.9]), lower([2.0, 2.9]))
        np.testing.assert_array_equal(fuzzy_set.upper([2.0, 2.9]), lower([2.0, 2.9]))


def test_centroid_where_the_lower_membership_has_no_area_is_the_support() -> None:
    assert IntervalType2Set(lower=Singleton(0.5), upper=Interval(0.0, 1.0)).centroid() == (0.0, 1.0)


@pytest.mark.parametrize(
    ("lower", "upper", "reason"),
    [
        (Singleton(0.0), Gaussian(0.0, 1.0), "no area, and its support is unbounded"),
        (Gaussian(0.0, 0.5), Bell(0.0, 2.0, 0.9), "slope above 1"),
        (
            Gaussian(0.0, 1.0, 0.1),
            FunctionalSet(lambda x: 1.0 / (1.0 + 0.0 * x), -math.inf, math.inf, (-1.0, 1.0)),
            "unbounded",
        ),
        (
            FunctionalSet(lambda x: 0.0 * x, 0.0, 1.0),
            FunctionalSet(lambda x: 0.0 * x, 0.0, 1.0),
            "zero almost everywhere",
        ),
    ],
)
def test_sets_without_a_finite_centroid_are_refused(
    lower: object, upper: object, reason: str
) -> None:
    with pytest.raises(NotApplicable, match=reason):
        IntervalType2Set(lower=lower, upper=upper).centroid()  # type: ignore[arg-type]


def test_heavy_tails_are_integrated_to_their_end() -> None:
    """Bells of slope 3/2 fall as 1/|x|³.

    Scipy's rule for infinite ranges, at the root, knows no panels or cutoffs. 1e-9: its own.
    """
    from scipy.integrate import quad

    fuzzy_set = IntervalType2Set(lower=Bell(0.0, 1.0, 1.5), upper=Bell(0.0, 2.0, 1.5))
    left, right = fuzzy_set.centroid()

    def moment(bell: Callable[[float], float], low: float, high: float) -> float:
        return float(
            quad(lambda x: (x - left) * bell(x), low, high, epsabs=1e-12, epsrel=1e-12, limit=500)[
                0
            ]
        )

    assert moment(fuzzy_set.upper, -math.inf, left) + moment(
        fuzzy_set.lower, left, math.inf
    ) == pytest.approx(0.0, abs=1e-9)
    assert right == pytest.approx(-left, rel=1e-12)


@pytest.mark.parametrize("x", [-3.0, 4.0, 4.9, 5.0, 5.1, 6.0, 8.5])
def test_uncertain_mean_is_the_envelope_of_all_gaussians_between(x: float) -> None:
    """Extremes over 2001 means, the ends and the nearest one among them.

    1e-6 for the middle ones that are missed.
    """
    fuzzy_set = GaussianUncertainMean((4.0, 6.0), 1.2)
    means = np.linspace(4.0, 6.0, 2001)
    grades = np.exp(-0.5 * ((x - means) / 1.2) ** 2)
    np.testing.assert_allclose(fuzzy_set.footprint(x), [grades.min(), grades.max()], atol=1e-6)


@pytest.mark.parametrize("x", [-3.0, 4.0, 5.0, 6.5])
def test_uncertain_sigma_is_the_envelope_of_all_gaussians_between(x: float) -> None:
    """Extremes are at the ends, so 1e-15."""
    grades = np.exp(-0.5 * ((x - 5.0) / np.linspace(0.5, 1.5, 101)) ** 2)
    np.testing.assert_allclose(
        GaussianUncertainSigma(5.0, (0.5, 1.5)).footprint(x),
        [grades.min(), grades.max()],
        rtol=1e-14,
    )


@settings(max_examples=200)
@given(
    mean=st.tuples(st.floats(-5.0, 5.0), st.floats(0.0, 4.0)),
    sigma=st.tuples(st.floats(0.2, 2.0), st.floats(0.0, 2.0)),
    x=st.floats(-20.0, 20.0),
)
def test_lower_is_at_most_upper_and_kernel_rows_say_the_same(
    mean: tuple[float, float], sigma: tuple[float, float], x: float
) -> None:
    """The row's formula, written out; 1e-14 relative is one rounding of the exponent."""
    for fuzzy_set in (
        GaussianUncertainMean((mean[0], mean[0] + mean[1]), sigma[0]),
        GaussianUncertainSigma(mean[0], (sigma[0], sigma[0] + sigma[1])),
    ):
        kind, m1, m2, s_low, s_high, h_low, h_high, *rest = fuzzy_set.kernel_row()
        assert (kind, *rest) == (0.0, 0.0, 0.0)
        farther = m1 if abs(x - m1) > abs(x - m2) else m2
        low = h_low * math.exp(-0.5 * ((x - farther) / s_low) ** 2)
        high = h_high * math.exp(-0.5 * ((x - min(max(x, m1), m2)) / s_high) ** 2)
        np.testing.assert_allclose(fuzzy_set.footprint(x), [low, high], rtol=1e-13)
        assert fuzzy_set.lower(x) <= fuzzy_set.upper(x)


def test_rows_of_pairs_of_type_1_sets() -> None:
    assert IntervalType2Set(Gaussian(1.0, 0.5, 0.4), Gaussian(1.0, 0.7)).kernel_row() == (
        0,
        1,
        1,
        0.5,
        0.7,
        0.4,
        1,
        0,
        0,
    )
    same = Triangular(0.0, 1.0, 2.0)
    assert IntervalType2Set(same, same).kernel_row() == same.kernel_row()
    assert IntervalType2Set(Triangular(0.0, 1.0, 2.0, 0.5), same).kernel_row() is None


FIRST = GaussianUncertainMean(mean=(4.0, 6.0), sigma=1.0)


@pytest.mark.parametrize(
    "fuzzy_set",
    [
        FIRST,
        GaussianUncertainSigma(5.0, (0.5, 1.0)),
        between(0.1, 1.0),
        FIRST.lower,
        FIRST.upper,
        FIRST.embedded(4.0),
    ],
)
def test_repr_rebuilds_the_set_and_equal_sets_hash_alike(fuzzy_set: object) -> None:
    copy = eval(repr(fuzzy_set), vars(interval_type2) | {"Trapezoidal": Trapezoidal})
    assert copy == fuzzy_set
    assert hash(copy) == hash(fuzzy_set)
    with pytest.raises(AttributeError):
        fuzzy_set.mean = 3.0  # type: ignore[attr-defined]


def test_shapes_and_nan() -> None:
    points = np.array([[4.0, np.nan], [np.inf, 5.0]])
    footprint = FIRST.footprint(points)
    assert footprint.shape == (2, 2, 2)
    assert np.isnan(footprint[0, 1]).all()
    assert (footprint[1, 0] == 0.0).all()
    assert np.isnan(FIRST.embedded(5.0)(np.nan))


def test_vertical_slices_are_intervals_and_the_set_is_its_own_alpha_plane() -> None:
    low, high = FIRST.footprint(4.5)
    assert FIRST.secondary(4.5) == Interval(low, high)
    assert FIRST.alpha_plane(0.3) is FIRST
    assert FIRST.principal(4.5) == pytest.approx(0.5 * (low + high), rel=1e-15)


def test_embedded_sets_lie_in_the_footprint_and_differ_with_the_seed() -> None:
    grid = np.linspace(-2.0, 12.0, 1001)
    first, second = (
        FIRST.embedded(np.random.default_rng(1)),
        FIRST.embedded(np.random.default_rng(2)),
    )
    assert first != second
    for embedded in (first, second, FIRST.embedded(4.0)):
        grades = embedded(grid)
        assert (grades >= FIRST.lower(grid) - 1e-15).all()
        assert (grades <= FIRST.upper(grid) + 1e-15).all()
    switched = FIRST.embedded(4.5)
    np.testing.assert_array_equal(
        switched([4.4, 4.5, 5.0]), [FIRST.upper(4.4), FIRST.lower(4.5), FIRST.lower(5.0)]
    )
    assert not first.is_convex()
    assert switched.height == pytest.approx(1.0, abs=1e-12)
    assert switched.maxima[0] == pytest.approx(4.0, rel=1e-15)
    # it falls at the switch point, and rises again with the lower membership
    assert not switched.is_convex()
    with pytest.raises(NotApplicable, match="not convex"):
        switched.alpha_cut(0.5)
    # Shares that do not jump leave the shape of the footprint, here halfway between two triangles.
    halves = IntervalType2Set(Triangular(0.0, 1.0, 2.0, 0.5), Triangular(0.0, 1.0, 2.0)).principal
    np.testing.assert_allclose(halves.alpha_cut(0.375), (0.5, 1.5), atol=1e-9)


def test_sampling_gives_sampled_bounds() -> None:
    sampled = FIRST.sample(GRID)
    assert sampled.lower == SampledSet(GRID, FIRST.lower(GRID))
    assert sampled.upper == SampledSet(GRID, FIRST.upper(GRID))


def test_a_truncated_pair_has_the_centroid_of_the_domain() -> None:
    """Table 9-2's widest set on [0, 10]: enumeration on 20 001 points of the trapezoidal rule.

    1e-6 is its step squared.
    """
    fuzzy_set = GaussianUncertainSigma(5.0, (0.25, 1.75))
    cut = IntervalType2Set(
        lower=Truncated(fuzzy_set.lower, 0.0, 10.0), upper=Truncated(fuzzy_set.upper, 0.0, 10.0)
    )
    left, right = cut.centroid()
    # the coarse grid of the table has a step of 0.1
    assert left == pytest.approx(TABLE_9_2[-1][2][0], abs=2e-3)
    assert right == pytest.approx(10.0 - left, rel=1e-13)
    x = np.linspace(0.0, 10.0, 20_001)
    before = np.where(x <= left, cut.upper(x), cut.lower(x))
    assert np.trapezoid(before * x, x) / np.trapezoid(before, x) == pytest.approx(left, abs=1e-4)


@pytest.mark.parametrize(
    ("lower", "upper", "where"),
    [
        (Triangular(0.0, 1.0, 2.0), Triangular(0.0, 1.0, 2.0, 0.9), r"x = 1 they are 1 and 0\.9"),
        (Interval(-1e-9, 1.0), Interval(0.0, 1.0), r"x = -1e-09"),
        (Gaussian(0.0, 1.0), Gaussian(0.5, 1.0), "they are"),
        (Gaussian(0.0, 1.0), Triangular(-5.0, 0.0, 5.0), "they are"),
        (Gaussian(0.0, 2.0, 0.01), Gaussian(0.0, 1.0), "they are"),
        (Sigmoid(0.0, 1.0), Gaussian(0.0, 50.0), "they are"),
        (
            SampledSet([0.0, 1.0, 2.0], [0.0, 0.8, 0.0]),
            SampledSet([0.0, 0.5, 2.0], [0.0, 1.0, 0.0]),
            r"x = 1 they are 0\.8 and 0\.6",
        ),
    ],
)
def test_a_lower_membership_above_the_upper_is_refused_and_the_error_says_where(
    lower: object, upper: object, where: str
) -> None:
    with pytest.raises(InvalidValue, match=where):
        IntervalType2Set(lower=lower, upper=upper)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "make",
    [
        lambda: GaussianUncertainMean((6.0, 4.0), 1.0),
        lambda: GaussianUncertainMean((4.0, 6.0), 0.0),
        lambda: GaussianUncertainMean((4.0, math.nan), 1.0),
        lambda: GaussianUncertainMean(4.0, 1.0),
        lambda: GaussianUncertainMean((4.0, 5.0, 6.0), 1.0),
        lambda: GaussianUncertainMean("ab", 1.0),
        lambda: GaussianUncertainSigma(0.0, (1.0, 0.5)),
        lambda: GaussianUncertainSigma(0.0, (0.0, 0.5)),
        lambda: GaussianUncertainSigma(math.inf, (0.4, 0.5)),
        lambda: IntervalType2Set(lower=0.5, upper=Gaussian(0.0, 1.0)),
        lambda: IntervalType2Set(lower=Gaussian(0.0, 1.0), upper=None),
        lambda: EmbeddedSet(FIRST, (1.0, 0.0), (0.0, 0.0, 0.0)),
        lambda: EmbeddedSet(FIRST, (0.0,), (0.0,)),
        lambda: EmbeddedSet(FIRST, (0.0,), (0.0, 1.1)),
        lambda: FIRST.embedded(math.nan),
        lambda: FIRST.footprint("a"),
    ],
)
def test_bad_parameters_are_refused(make: Callable[[], object]) -> None:
    with pytest.raises(InvalidValue, match="must be"):
        make()
