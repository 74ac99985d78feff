"""Type-1 sets.

Memberships against their definitions, cuts against memberships, centroids against closed forms, and
what is refused.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import fuzzy2
from fuzzy2.errors import InvalidValue, NotApplicable
from fuzzy2.sets.derived import Complement, FunctionalSet, Truncated
from fuzzy2.sets.lagged import Lagged
from fuzzy2.sets.shapes import Gaussian, Interval, Trapezoidal, Triangular
from fuzzy2.sets.sigmoids import Sigmoid, SigmoidDifference, SigmoidProduct
from fuzzy2.sets.smooth_shapes import Bell, PiShaped, TwoSidedGaussian
from fuzzy2.sets.type1 import SampledSet, Singleton, Type1Set
from tests.fuzzy2.sets.type1_sets import SETS, parabola

ANALYTIC = {name: fuzzy_set for name, fuzzy_set in SETS.items() if name != "functional"}

finite = st.floats(-1e6, 1e6, allow_nan=False)

widths = st.floats(1e-3, 1e3)

heights = st.floats(0.01, 1.0)


@st.composite
def parametric_sets(draw: st.DrawFn) -> Type1Set:
    a, b, c, d = sorted(draw(st.lists(st.floats(-100.0, 100.0), min_size=4, max_size=4)))
    center, width = draw(st.floats(-100.0, 100.0)), draw(widths)
    return draw(
        st.sampled_from(
            [
                Gaussian(center, width, draw(heights)),
                Triangular(a, b, c, draw(heights)),
                Trapezoidal(a, b, c, d, draw(heights)),
                Interval(a, b),
                Singleton(a),
                Bell(center, width, draw(st.floats(0.6, 10.0))),
                Sigmoid(center, draw(st.sampled_from([-1.0, 1.0])) / width),
                PiShaped(a, b, c, d, draw(heights)),
                PiShaped(-math.inf, -math.inf, c, d),
                PiShaped(a, b, math.inf, math.inf),
                TwoSidedGaussian((b, c), (width, draw(widths))),
                TwoSidedGaussian(
                    (center + 2.0 * width, center), (width, draw(st.floats(0.5, 5.0)) * width)
                ),
                SigmoidProduct(
                    (center, center + draw(st.floats(-2.0, 9.0)) * width),
                    (2.0 / width, -draw(st.floats(0.5, 5.0)) / width),
                ),
                SigmoidProduct((center, center + width), (1.0 / width, 2.0 / width)),
                Complement(Sigmoid(center, -1.0 / width)),
                Complement(PiShaped(a, b, math.inf, math.inf)),
            ]
        )
    )


@pytest.mark.parametrize(
    ("fuzzy_set", "points", "grades"),
    [
        (
            Gaussian(1.0, 2.0, 0.5),
            [1.0, 3.0, -1.0],
            [0.5, 0.5 * math.exp(-0.5), 0.5 * math.exp(-0.5)],
        ),
        (
            Triangular(0.0, 1.0, 3.0),
            [-1.0, 0.0, 0.5, 1.0, 2.0, 3.0, 4.0],
            [0.0, 0.0, 0.5, 1.0, 0.5, 0.0, 0.0],
        ),
        (
            Trapezoidal(0.0, 1.0, 2.0, 4.0, 0.5),
            [0.5, 1.0, 1.5, 2.0, 3.0, 5.0],
            [0.25, 0.5, 0.5, 0.5, 0.25, 0.0],
        ),
        (Trapezoidal(0.0, 0.0, 2.0, 2.0), [-1e-9, 0.0, 2.0, 2.0 + 1e-9], [0.0, 1.0, 1.0, 0.0]),
        (
            Trapezoidal(-math.inf, -math.inf, 0.0, 1.0),
            [-math.inf, -1e300, 0.0, 0.5, math.inf],
            [1.0, 1.0, 1.0, 0.5, 0.0],
        ),
        (Bell(1.0, 2.0, 3.0), [1.0, 3.0, -1.0, 5.0], [1.0, 0.5, 0.5, 1.0 / 65.0]),
        (
            Sigmoid(1.0, 2.0),
            [1.0, 2.0, 0.0, 1e4, -1e4],
            [0.5, 1 / (1 + math.exp(-2)), 1 / (1 + math.exp(2)), 1.0, 0.0],
        ),
        (Singleton(2.0), [2.0, np.nextafter(2.0, 3.0)], [1.0, 0.0]),
        (Interval(0.0, 1.0), [0.0, 1.0, -0.1, 1.1], [1.0, 1.0, 0.0, 0.0]),
        (SampledSet([0.0, 2.0], [0.2, 1.0]), [-0.1, 0.0, 1.0, 2.0, 2.1], [0.0, 0.2, 0.6, 1.0, 0.0]),
        (
            Truncated(Gaussian(0.0, 1.0), 0.0, 1.0),
            [-0.1, 0.0, 1.0, 1.1],
            [0.0, 1.0, math.exp(-0.5), 0.0],
        ),
        (FunctionalSet(parabola, -1.0, 0.5), [0.0, 0.5, 0.6], [1.0, 0.75, 0.0]),
        (PiShaped(0.0, 0.0, 2.0, 2.0), [-1e-9, 0.0, 2.0, 2.0 + 1e-9], [0.0, 1.0, 1.0, 0.0]),
        (
            PiShaped(0.0, 4.0, 4.0, 8.0, 0.5),
            [1.0, 2.0, 3.0, 4.0, 7.0],
            [0.0625, 0.25, 0.4375, 0.5, 0.0625],
        ),
        (
            TwoSidedGaussian((1.0, 2.0), (1.0, 3.0)),
            [0.0, 1.0, 1.5, 2.0, 5.0],
            [math.exp(-0.5), 1.0, 1.0, 1.0, math.exp(-0.5)],
        ),
        (
            TwoSidedGaussian((9.0, 2.0), (math.inf, 3.0)),
            [-math.inf, 2.0, 5.0, math.inf],
            [1.0, 1.0, math.exp(-0.5), 0.0],
        ),
        (
            SigmoidDifference((0.0, 1.0), (2.0, 2.0)),
            [0.0, 0.5],
            [0.5 - 1 / (1 + math.exp(2)), math.tanh(0.5)],
        ),
        # The difference keeps its digits where both sigmoids are 1 but for rounding.
        (
            SigmoidDifference((0.0, 1.0), (2.0, 2.0)),
            [50.0, -50.0],
            [math.exp(-98) - math.exp(-100), math.exp(-100) - math.exp(-102)],
        ),
        (
            SigmoidProduct((0.0, 0.0), (2.0, -2.0)),
            [0.0, 1.0, 1e4],
            [0.25, 1 / (1 + math.exp(2)) / (1 + math.exp(-2)), 0.0],
        ),
        (Complement(Triangular(0.0, 1.0, 3.0, 0.5)), [-1.0, 0.5, 1.0, 3.0], [1.0, 0.75, 0.5, 1.0]),
    ],
)
def test_memberships_are_those_of_the_definition(
    fuzzy_set: Type1Set, points: list[float], grades: list[float]
) -> None:
    """By hand; 1e-15 is the rounding of one formula."""
    np.testing.assert_allclose(fuzzy_set(points), grades, rtol=1e-14, atol=1e-15)


@pytest.mark.parametrize("name", SETS)
def test_points_of_any_shape_give_grades_of_that_shape_and_nan_stays(name: str) -> None:
    fuzzy_set = SETS[name]
    points = np.array([[0.1, np.nan, 1.5], [-np.inf, np.inf, 0.25]])
    grades = fuzzy_set.membership(points)
    assert grades.shape == points.shape
    assert (np.isnan(grades) == np.isnan(points)).all()
    assert isinstance(fuzzy_set(0.3), np.float64)
    assert np.isnan(fuzzy_set(np.nan))
    assert fuzzy_set(np.zeros((0, 3))).shape == (0, 3)
    for x in (0.1, 1.5, 0.25):
        assert fuzzy_set(x) == fuzzy_set([x, x])[1]


@pytest.mark.parametrize("name", ANALYTIC)
def test_repr_rebuilds_the_set_and_equal_sets_hash_alike(name: str) -> None:
    fuzzy_set = ANALYTIC[name]
    copy = eval(
        repr(fuzzy_set),
        {name: getattr(fuzzy2, name) for name in fuzzy2.__all__}
        | {"Truncated": Truncated, "Lagged": Lagged, "inf": math.inf},
    )
    assert copy == fuzzy_set
    assert hash(copy) == hash(fuzzy_set)
    assert copy != Singleton(99.0)


@pytest.mark.parametrize("name", SETS)
def test_sets_are_frozen_and_type_2_sets_without_uncertainty(name: str) -> None:
    fuzzy_set = SETS[name]
    with pytest.raises(AttributeError):
        fuzzy_set.support = (0.0, 1.0)  # type: ignore[misc]
    assert (
        fuzzy_set.lower
        is fuzzy_set.upper
        is fuzzy_set.principal
        is fuzzy_set.alpha_plane(0.5)
        is fuzzy_set
    )
    assert fuzzy_set.secondary(0.25) == Singleton(float(fuzzy_set(0.25)))


@pytest.mark.parametrize("name", [name for name in SETS if SETS[name].maxima])
def test_height_maxima_core_and_support_agree_with_the_membership(name: str) -> None:
    """Between the ends of the maxima nothing is higher.

    1e-9 for the functional set, whose maximum is searched.
    """
    fuzzy_set = SETS[name]
    first, last = fuzzy_set.maxima
    grid = np.linspace(-5.0, 5.0, 20_001)
    assert fuzzy_set(grid).max() <= fuzzy_set.height + 1e-12
    for end in (first, last):
        assert not math.isfinite(end) or fuzzy_set(end) == pytest.approx(fuzzy_set.height, abs=1e-9)
    assert fuzzy_set.is_normal() == (fuzzy_set.core is not None) == (fuzzy_set.height > 1.0 - 1e-9)
    left, right = fuzzy_set.support
    assert (fuzzy_set(grid[(grid < left) | (grid > right)]) == 0.0).all()
    assert fuzzy_set.is_convex()


@pytest.mark.slow
@settings(max_examples=300)
@given(fuzzy_set=parametric_sets(), share=st.floats(0.01, 0.99))
def test_the_ends_of_a_cut_have_its_grade_and_what_is_outside_is_lower(
    fuzzy_set: Type1Set, share: float
) -> None:
    """Membership at the ends, and just inside and outside.

    1e-6 of the set's width moves away from rounding.
    """
    alpha = share * fuzzy_set.height
    left, right = fuzzy_set.alpha_cut(alpha)
    assert left <= right
    finite_ends = [end for end in (left, right) if np.isfinite(end)]
    scale = max(1e-9, *(abs(end) for end in finite_ends)) if finite_ends else 1.0
    for end, outward in ((left, -1.0), (right, 1.0)):
        if np.isfinite(end):
            nudge = 1e-9 * scale
            assert (
                fuzzy_set(end - outward * min(nudge, 0.5 * (right - left)))
                >= alpha * (1.0 - 1e-3) - 1e-6
                or right - left < nudge
            )
            assert fuzzy_set(end + outward * nudge) <= alpha * (1.0 + 1e-3) + 1e-6


@settings(max_examples=200)
@given(fuzzy_set=parametric_sets(), low=st.floats(0.01, 0.98), high=st.floats(0.01, 0.98))
def test_cuts_are_nested(fuzzy_set: Type1Set, low: float, high: float) -> None:
    low, high = sorted((low, high))
    lefts, rights = fuzzy_set.alpha_cut(np.array([0.0, low, high]) * fuzzy_set.height)
    assert (lefts[:-1] <= lefts[1:]).all()
    assert (rights[:-1] >= rights[1:]).all()
    assert (lefts[0], rights[0]) == fuzzy_set.support


@pytest.mark.parametrize(
    ("fuzzy_set", "expected"),
    [
        (Gaussian(0.3, 0.7), 0.3),
        (Gaussian(1e9, 2e-3, 0.5), 1e9),
        (Triangular(0.0, 0.3, 1.0), 1.3 / 3.0),
        (Triangular(0.0, 0.3, 1.0, 0.2), 1.3 / 3.0),
        (Trapezoidal(0.0, 1.0, 2.0, 4.0), (0.5 * 2 / 3 + 1.0 * 1.5 + 1.0 * (2 + 2 / 3)) / 2.5),
        (Bell(1.0, 2.0, 1.5), 1.0),
        # A side of width w has the area w / 2 and the moment 17 w^2 / 48 about its foot.
        (PiShaped(0.0, 2.0, 3.0, 7.0), (17 / 48 * 4.0 + 2.5 + 2.0 * 7.0 - 17 / 48 * 16.0) / 4.0),
        (
            TwoSidedGaussian((0.0, 1.0), (2.0, 3.0)),
            (-4.0 + 0.5 + math.sqrt(math.pi / 2.0) * 3.0 + 9.0)
            / (math.sqrt(math.pi / 2.0) * 5.0 + 1.0),
        ),
        (SigmoidDifference((2.0, 7.0), (5.0, 5.0)), 4.5),
        # A sigmoid of slope s that rises at c instead of 0 moves the moment by c^2 / 2 + pi^2 / (6
        # s^2).
        (
            SigmoidDifference((0.0, 20.0), (5.0, 3.0)),
            (200.0 + math.pi**2 / 6.0 * (1.0 / 9.0 - 1.0 / 25.0)) / 20.0,
        ),
        (SigmoidProduct((-3.0, 3.0), (2.0, -2.0)), 0.0),
        (Interval(-1.0, 2.0), 0.5),
        (Interval(3.0, 3.0), 3.0),
        (Singleton(4.0), 4.0),
        (SampledSet([0.0, 1.0, 3.0], [0.0, 1.0, 0.0]), 4.0 / 3.0),
        (SampledSet([7.0], [0.4]), 7.0),
        (
            Truncated(Gaussian(0.0, 1.0), 0.0, 1.0),
            (1.0 - math.exp(-0.5)) / (math.sqrt(math.pi / 2.0) * math.erf(math.sqrt(0.5))),
        ),
        (
            FunctionalSet(lambda x: np.where(x < 0.1234, 0.2, 1.0), 0.0, 1.0),
            (0.1 * 0.1234**2 + 0.5 * (1 - 0.1234**2)) / (1 - 0.8 * 0.1234),
        ),
        # A jump at 0, where floats are so dense that halving would never end.
        (
            FunctionalSet(lambda x: np.where(x < 0.0, 0.2, 1.0), -1.0, 1.7),
            (0.5 * 1.7**2 - 0.1) / 1.9,
        ),
    ],
)
def test_centroids_on_the_continuous_domain(fuzzy_set: Type1Set, expected: float) -> None:
    """Closed forms of eq. 1.68; 1e-13 is a few hundred rounded terms."""
    assert fuzzy_set.centroid() == pytest.approx(expected, rel=1e-13, abs=1e-13)


@pytest.mark.parametrize("scale", [1e-9, 1.0, 1e9])
def test_centroids_scale_with_the_points(scale: float) -> None:
    corners = np.array([0.0, 0.7, 1.0, 3.0]) * scale
    assert Trapezoidal(*corners).centroid() / scale == pytest.approx(
        Trapezoidal(0.0, 0.7, 1.0, 3.0).centroid(), rel=1e-14
    )


@settings(max_examples=100)
@given(points=st.lists(st.integers(0, 1000), min_size=2, max_size=20, unique=True), data=st.data())
def test_the_centroid_of_samples_is_that_of_straight_lines_between_them(
    points: list[int], data: st.DataObject
) -> None:
    """Areas and moments of trapezoids by formula; 1e-12 for sums over at most 20 of them."""
    grades = np.array(data.draw(st.lists(heights, min_size=len(points), max_size=len(points))))
    x, u = np.array(sorted(points), dtype=float), grades
    h = np.diff(x)
    area = h * (u[1:] + u[:-1]) / 2.0
    moment = h * (x[:-1] * (2 * u[:-1] + u[1:]) + x[1:] * (u[:-1] + 2 * u[1:])) / 6.0
    assert SampledSet(x, u).centroid() == pytest.approx(moment.sum() / area.sum(), rel=1e-12)


@pytest.mark.parametrize(
    ("fuzzy_set", "reason"),
    [
        (SETS["rising sigmoid"], "never comes back to 0"),
        (SETS["endless shoulder"], "unbounded"),
        (SETS["z"], "unbounded"),
        (SETS["gaussian shoulder"], "a shoulder never comes back to 0"),
        (SETS["rising sigmoid product"], "a shoulder never comes back to 0"),
        (SigmoidDifference((0.0, 1.0), (1.0, -1.0)), "never come back to 0"),
        (Complement(Gaussian(0.0, 1.0)), "unbounded"),
        (Bell(0.0, 1.0, 1.0), "slope above 1"),
        (Bell(0.0, 1.0, 0.4), "slope above 1"),
        (FunctionalSet(lambda x: 0.0 * x, 0.0, 1.0), "zero almost everywhere"),
        (FunctionalSet(lambda x: np.exp(-(x**2)), -math.inf, math.inf, (-1.0, 1.0)), "unbounded"),
        (FunctionalSet(lambda x: np.modf(abs(np.sin(1e9 * x)) * 1e6)[0], 0.0, 1.0), "too rough"),
    ],
)
def test_sets_without_a_finite_centroid_are_refused(fuzzy_set: Type1Set, reason: str) -> None:
    with pytest.raises(NotApplicable, match=reason):
        fuzzy_set.centroid()


def test_samples_are_sorted_and_points_within_1e_12_merge_to_the_greatest_grade() -> None:
    merged = SampledSet([0.3, 0.1 + 0.2, 0.3 + 5e-13, 0.1, 0.3 + 5e-12], [0.5, 0.9, 0.6, 0.2, 0.4])
    np.testing.assert_array_equal(merged.points, [0.1, 0.3, 0.3 + 5e-12])
    np.testing.assert_array_equal(merged.grades, [0.2, 0.9, 0.4])
    assert len(merged) == 3
    with pytest.raises(ValueError, match="read-only"):
        merged.grades[0] = 1.0


def test_the_distance_at_which_points_merge_does_not_swallow_sets_of_tiny_numbers() -> None:
    assert len(SampledSet(np.linspace(0.0, 1e-9, 1001), np.ones(1001))) == 1001


def test_zeros_of_both_signs_are_one_set() -> None:
    assert SampledSet([0.0], [1.0]) == SampledSet([-0.0], [1.0])
    assert hash(SampledSet([0.0], [1.0])) == hash(SampledSet([-0.0], [1.0]))


def test_a_set_with_two_peaks_is_not_convex_and_has_no_cuts() -> None:
    two_peaks = SampledSet([0.0, 1.0, 2.0, 3.0, 4.0], [0.0, 1.0, 0.5, 1.0, 0.0])
    assert not two_peaks.is_convex()
    assert two_peaks.core == (1.0, 3.0)
    with pytest.raises(NotApplicable, match="not convex"):
        two_peaks.alpha_cut(0.7)
    waves = FunctionalSet(lambda x: np.sin(x) ** 2, 0.0, 6.0)
    assert not waves.is_convex()
    assert waves.height == pytest.approx(1.0, abs=1e-12)
    assert not Truncated(waves, 0.5, 5.0).is_convex()
    one_wave = Truncated(waves, 0.5, 2.0)
    assert one_wave.is_convex()
    assert one_wave.height == pytest.approx(1.0, abs=1e-12)
    # as sampled
    np.testing.assert_allclose(one_wave.alpha_cut(0.5), (math.pi / 4.0, 2.0), atol=1e-4)


def test_the_support_of_samples_reaches_to_the_next_zero() -> None:
    assert SampledSet([0.0, 1.0, 2.0, 3.0, 4.0], [0.0, 0.0, 1.0, 0.0, 0.0]).support == (1.0, 3.0)
    assert SampledSet([0.0, 1.0], [0.5, 1.0]).support == (0.0, 1.0)
    assert SampledSet([0.0, 1.0], [0.0, 0.0]).support == (0.0, 1.0)


def test_cuts_of_samples_jump_where_the_grades_do() -> None:
    steps = SampledSet([0.0, 1.0, 2.0, 4.0], [0.4, 1.0, 1.0, 0.2])
    lefts, rights = steps.alpha_cut([0.2, 0.4, 0.7, 1.0])
    np.testing.assert_allclose(lefts, [0.0, 0.0, 0.5, 1.0], atol=1e-12)
    np.testing.assert_allclose(rights, [4.0, 3.5, 2.75, 2.0], atol=1e-12)


def test_sampling_keeps_the_grades() -> None:
    points = np.linspace(-1.0, 1.0, 11)
    sampled = Gaussian(0.0, 1.0).sample(points)
    np.testing.assert_array_equal(sampled.grades, Gaussian(0.0, 1.0)(points))


ROWS: list[tuple[Type1Set, tuple[float, ...]]] = [
    (Gaussian(1.0, 2.0, 0.5), (0, 1, 1, 2, 2, 0.5, 0.5, 0, 0)),
    (Triangular(0.0, 1.0, 3.0, 0.5), (1, 0, 1, 1, 3, 0.5, 0, 0, 0)),
    (Trapezoidal(0.0, 1.0, 2.0, 4.0), (1, 0, 1, 2, 4, 1, 0, 0, 0)),
    (Interval(-1.0, 2.0), (1, -1, -1, 2, 2, 1, 0, 0, 0)),
]


@pytest.mark.parametrize(("fuzzy_set", "row"), ROWS)
def test_kernel_rows(fuzzy_set: Type1Set, row: tuple[float, ...]) -> None:
    assert fuzzy_set.kernel_row() == row


@pytest.mark.parametrize(
    "name",
    ["singleton", "sampled", "functional", "truncated", "not z"],
)
def test_sets_that_only_python_can_evaluate_have_no_kernel_row(name: str) -> None:
    assert SETS[name].kernel_row() is None


@pytest.mark.parametrize(
    "make",
    [
        lambda: Gaussian(math.nan, 1.0),
        lambda: Gaussian(0.0, 0.0),
        lambda: Gaussian(0.0, -1.0),
        lambda: Gaussian(0.0, math.inf),
        lambda: Gaussian(0.0, 1.0, 0.0),
        lambda: Gaussian(0.0, 1.0, 1.1),
        lambda: Gaussian("0", 1.0),
        lambda: Gaussian(1j, 1.0),
        lambda: Gaussian(True, 1.0),
        lambda: Gaussian(None, 1.0),
        lambda: Triangular(0.0, 2.0, 1.0),
        lambda: Triangular(-math.inf, 2.0, 1.0),
        lambda: Trapezoidal(0.0, 2.0, 1.0, 3.0),
        lambda: Trapezoidal(-math.inf, 0.0, 1.0, 3.0),
        lambda: Trapezoidal(0.0, 1.0, 2.0, math.inf),
        lambda: Trapezoidal(math.inf, math.inf, math.inf, math.inf),
        lambda: Trapezoidal(-math.inf, -math.inf, -math.inf, -math.inf),
        lambda: Interval(1.0, 0.0),
        lambda: Interval(0.0, math.inf),
        lambda: Singleton(math.nan),
        lambda: Bell(0.0, 0.0, 1.0),
        lambda: Bell(0.0, 1.0, -1.0),
        lambda: Sigmoid(0.0, 0.0),
        lambda: SampledSet([], []),
        lambda: SampledSet([0.0, 1.0], [1.0]),
        lambda: SampledSet([[0.0, 1.0]], [[1.0, 1.0]]),
        lambda: SampledSet([0.0, math.nan], [1.0, 1.0]),
        lambda: SampledSet([0.0, 1.0], [1.0, math.nan]),
        lambda: SampledSet([0.0, 1.0], [1.0, 1.1]),
        lambda: SampledSet([0.0, 1.0], [1.0, -0.1]),
        lambda: SampledSet(["a", "b"], [1.0, 1.0]),
        lambda: FunctionalSet(parabola, 1.0, 0.0),
        lambda: FunctionalSet(parabola, -math.inf, math.inf),
        lambda: Truncated(Interval(0.0, 1.0), 2.0, 3.0),
        lambda: Truncated(Interval(0.0, 1.0), 1.0, 0.0),
        lambda: PiShaped(0.0, 2.0, 1.0, 3.0),
        lambda: PiShaped(0.0, 1.0, 2.0, 3.0, 1.5),
        lambda: TwoSidedGaussian((0.0, 1.0), (0.0, 1.0)),
        lambda: TwoSidedGaussian((0.0, 1.0), (math.inf, math.inf)),
        lambda: TwoSidedGaussian((0.0, math.inf), (1.0, 1.0)),
        lambda: TwoSidedGaussian(0.0, (1.0, 1.0)),  # type: ignore[arg-type]
        lambda: TwoSidedGaussian((100.0, 0.0), (1.0, 1.0)),
        lambda: SigmoidDifference((0.0, 1.0), (0.0, 1.0)),
        lambda: SigmoidDifference((0.0, 0.0), (2.0, 2.0)),
        lambda: SigmoidDifference((0.0, math.inf), (2.0, 2.0)),
        lambda: SigmoidProduct((0.0, 1.0, 2.0), (2.0, 2.0)),  # type: ignore[arg-type]
        lambda: SigmoidProduct((0.0, -1e6), (2.0, -2.0)),
        lambda: Complement(0.5),  # type: ignore[arg-type]
    ],
)
def test_bad_parameters_are_refused(make: Callable[[], Type1Set]) -> None:
    with pytest.raises(InvalidValue, match="must be"):
        make()


@pytest.mark.parametrize("alpha", [-0.1, 0.7, math.nan, [0.1, 0.7]])
def test_grades_outside_of_the_set_have_no_cut(alpha: float) -> None:
    with pytest.raises(InvalidValue, match=r"alpha must be from 0 to the height of the set, 0\.6"):
        SETS["low gaussian"].alpha_cut(alpha)


@pytest.mark.parametrize("points", ["a", [1j], [[0.0], [1.0, 2.0]]])
def test_points_that_are_not_real_numbers_are_refused(points: object) -> None:
    with pytest.raises(InvalidValue, match="x must be real numbers"):
        Gaussian(0.0, 1.0)(points)  # type: ignore[arg-type]


@settings(max_examples=100)
@given(center=st.floats(-10.0, 10.0), sigma=widths, level=st.floats(-6.0, 6.0))
def test_moments_up_to_a_point_are_those_of_the_normal_distribution(
    center: float, sigma: float, level: float
) -> None:
    """Area by the error function and moment by the density; 1e-13 of the whole area."""
    moments = Gaussian(center, sigma).moments(origin=center)
    area, moment = moments.up_to(center + level * sigma)
    whole = math.sqrt(2.0 * math.pi) * sigma
    assert area == pytest.approx(
        0.5 * whole * math.erfc(-level / math.sqrt(2.0)), rel=1e-11, abs=1e-13 * whole
    )
    assert moment == pytest.approx(
        -(sigma**2) * math.exp(-0.5 * level**2), rel=1e-11, abs=1e-12 * sigma**2
    )
    assert np.add(moments.beyond(center + level * sigma), (area, moment)) == pytest.approx(
        moments.total, abs=1e-12 * max(whole, sigma**2)
    )


def test_areas_far_out_on_a_tail_keep_their_digits() -> None:
    """erfc(20 / sqrt 2) is 5.5e-89 and must not drown in the area of the rest.

    1e-11 allows for the points' own rounding.
    """
    area, _ = Gaussian(0.0, 1.0).moments(origin=0.0).beyond(20.0)
    assert area == pytest.approx(
        math.sqrt(0.5 * math.pi) * math.erfc(20.0 / math.sqrt(2.0)), rel=1e-11
    )


@given(fuzzy_set=parametric_sets(), x=finite)
def test_grades_are_between_0_and_the_height(fuzzy_set: Type1Set, x: float) -> None:
    assume(math.isfinite(x))
    assert 0.0 <= fuzzy_set(x) <= fuzzy_set.height
