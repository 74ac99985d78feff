"""General type-2 sets.

Slices and planes against their definitions and each other, embedded sets counted and listed, what
is refused.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable

import numpy as np
import pytest

import fuzzy2
from fuzzy2.errors import InvalidValue, NotApplicable
from fuzzy2.sets import general_type2, vertical_slices
from fuzzy2.sets.derived import Truncated
from fuzzy2.sets.gaussian_type2 import GaussianType2Set
from fuzzy2.sets.general_type2 import SampledType2Set, ZSlices
from fuzzy2.sets.interval_type2 import (
    GaussianUncertainMean,
    GaussianUncertainSigma,
    IntervalType2Set,
)
from fuzzy2.sets.shapes import Gaussian, Interval
from fuzzy2.sets.type1 import SampledSet, Singleton
from fuzzy2.sets.vertical_slices import Staircase
from tests.fuzzy2.sets.general_type2_sets import DISCRETE, SETS, SLICED, TRIANGLES

BLURRED = GaussianType2Set(principal=Gaussian(mean=0.0, sigma=1.0), sigma=0.1, domain=(-4.0, 4.0))


@pytest.mark.parametrize("name", SETS)
def test_planes_slices_and_grades_say_the_same(name: str) -> None:
    """Three ways to the same set.

    1e-9 is the bisection's accuracy, 1e-5 that of the levels between two continuous slices.
    """
    fuzzy_set, accuracy = SETS[name], 1e-5 if name == "partially discrete" else 1e-9
    for x in (0.0, 0.3, 1.0, 4.5):
        vertical_slice = fuzzy_set.secondary(x)
        if fuzzy_set.support[0] <= x <= fuzzy_set.support[1]:
            np.testing.assert_allclose(fuzzy_set.footprint(x), vertical_slice.support, atol=1e-12)
        for alpha in (0.2, 0.5, 1.0):
            plane = fuzzy_set.alpha_plane(alpha)
            if alpha <= vertical_slice.height:
                np.testing.assert_allclose(
                    plane.footprint(x), vertical_slice.alpha_cut(alpha), atol=accuracy
                )
            else:
                assert (plane.footprint(x) == 0.0).all()
        u = np.linspace(0.0, 1.0, 21)
        np.testing.assert_allclose(fuzzy_set.secondary_grade(x, u), vertical_slice(u), atol=1e-12)
        if fuzzy_set.support[0] <= x <= fuzzy_set.support[1]:
            assert fuzzy_set.principal(x) == pytest.approx(
                0.5 * sum(vertical_slice.maxima), abs=1e-9
            )


@pytest.mark.parametrize("name", SETS)
def test_shapes_and_nan(name: str) -> None:
    fuzzy_set = SETS[name]
    points = np.array([[0.1, np.nan, 1.5], [0.0, 5.0, -2.0]])
    plane = fuzzy_set.alpha_plane(0.5)
    for membership in (
        fuzzy_set.lower,
        fuzzy_set.upper,
        fuzzy_set.principal,
        plane.lower,
        plane.upper,
    ):
        grades = membership(points)
        assert grades.shape == points.shape
        assert (np.isnan(grades) == np.isnan(points)).all()
        assert ((grades >= 0.0) & (grades <= 1.0))[~np.isnan(points)].all()
    assert fuzzy_set.footprint(points).shape == (2, 3, 2)
    grades = fuzzy_set.secondary_grade(points[:, :, None], [0.3, np.nan])
    assert grades.shape == (2, 3, 2)
    np.testing.assert_array_equal(np.isnan(grades), np.isnan(points)[:, :, None] | [False, True])
    assert isinstance(fuzzy_set.secondary_grade(0.1, 0.5), np.float64)
    assert fuzzy_set.kernel_row() is None


@pytest.mark.parametrize("name", ["gaussian", "gaussian of varying sigma", "functional", "sampled"])
def test_planes_are_nested_and_make_zslices(name: str) -> None:
    """A staircase below the true grade, and less than a level below; levels are 0.25 apart."""
    fuzzy_set = SETS[name]
    sliced = fuzzy_set.zslices([0.25, 0.5, 0.75, 1.0] if name != "sampled" else [0.25, 0.5, 0.7])
    for x in (0.0, 0.4, 1.0):
        u = np.linspace(0.005, 0.995, 100)
        true, stairs = fuzzy_set.secondary_grade(x, u), sliced.secondary_grade(x, u)
        assert (stairs <= true + 1e-9).all()
        if name != "sampled":
            assert (true - stairs < 0.25 + 1e-9).all()
        np.testing.assert_array_equal(stairs, sliced.secondary(x)(u))
    np.testing.assert_allclose(
        sliced.alpha_plane(0.3).footprint(0.4),
        fuzzy_set.alpha_plane(0.5).footprint(0.4),
        atol=1e-12,
    )
    assert sliced.support == fuzzy_set.support


def test_wagner_and_hagras_slices_are_found_again() -> None:
    """Wagner and Hagras, IEEE TFS 18(4) 2010, slices 1/3 and 1.

    Centroids [3.8656, 6.3953] and 5.3343.
    """
    x = np.arange(11.0)
    top = [0, 0, 0, 0.33, 0.67, 1, 0.75, 0.5, 0.25, 0, 0]
    low, high = (
        [0, 0, 0, 0, 0, 1, 0.33, 0, 0, 0, 0],
        [0, 0.2, 0.4, 0.6, 0.8, 1, 0.8, 0.6, 0.4, 0.2, 0],
    )
    # The published slices are not nested at x = 5 to 8, up to 0.08 of grade: the outer one is
    # widened to hold the inner.
    outer = IntervalType2Set(
        SampledSet(x, np.minimum(low, top)), SampledSet(x, np.maximum(high, top))
    )
    inner = IntervalType2Set(SampledSet(x, top), SampledSet(x, top))
    sliced = ZSlices((1.0 / 3.0, 1.0), (outer, inner))
    np.testing.assert_array_equal(sliced.alpha_plane(1.0).lower(x), top)
    np.testing.assert_array_equal(sliced.alpha_plane(0.2).upper(x), np.maximum(high, top))
    assert sliced.principal(5.0) == 1.0
    # The published slice itself, over all switch points.
    published = IntervalType2Set(SampledSet(x, low), SampledSet(x, high))
    before = np.tri(12, 11, -1, dtype=bool)
    left = [
        np.average(x, weights=weights)
        for weights in np.where(before, published.upper(x), published.lower(x))
    ]
    right = [
        np.average(x, weights=weights)
        for weights in np.where(before, published.lower(x), published.upper(x))
    ]
    np.testing.assert_allclose(
        [min(left), max(right)], [3.8656126482213438, 6.395256916996047], atol=1e-9
    )
    assert np.average(x, weights=sliced.principal(x)) == pytest.approx(5.334285714285714, abs=1e-9)
    assert (sliced.zslices([0.2]).alpha_plane(0.9).footprint(x) == 0.0).all()


def test_embedded_sets_are_counted_as_mendel_and_john_count_them() -> None:
    """Mendel and John, Type-2 fuzzy sets made simple, IEEE TFS 10(2) 2002, Example 2.

    M = (5, 5, 2, 5, 5) gives 1250.
    """
    slices = [SampledSet(np.linspace(0.0, 1.0, m), np.ones(m)) for m in (5, 5, 2, 5, 5)]
    fuzzy_set = SampledType2Set(range(5), slices)
    assert fuzzy_set.embedded_count() == 1250
    found = {tuple(one.memberships) for one in fuzzy_set.embedded_sets()}
    assert len(found) == 1250


def test_embedded_sets_are_all_choices_of_one_membership_at_every_point() -> None:
    """By hand: eq. 1.5 to 1.7 for three points."""
    assert DISCRETE.is_discrete()
    assert DISCRETE.embedded_count() == 12
    found = list(DISCRETE.embedded_sets())
    choices = itertools.product(
        [(0.2, 0.5), (0.4, 1.0), (0.6, 0.5)], [(0.8, 0.7), (1.0, 1.0)], [(0.0, 1.0), (0.5, 0.4)]
    )
    for one, choice in zip(found, choices, strict=True):
        np.testing.assert_array_equal(one.points, [0.0, 1.0, 2.0])
        np.testing.assert_array_equal(np.column_stack([one.memberships, one.grades]), choice)
        assert one.type1 == SampledSet(one.points, one.memberships)
        np.testing.assert_allclose(
            one.grades, DISCRETE.secondary_grade(one.points, one.memberships)
        )


def test_huge_counts_are_exact_and_the_list_is_lazy() -> None:
    fuzzy_set = SampledType2Set(
        range(100), [SampledSet(np.linspace(0.0, 1.0, 10), np.ones(10))] * 100
    )
    assert fuzzy_set.embedded_count() == 10**100
    assert (next(fuzzy_set.embedded_sets()).memberships == 0.0).all()


@pytest.mark.parametrize("name", [name for name in SETS if name != "sampled"])
def test_continuous_sets_have_no_list_of_embedded_sets(name: str) -> None:
    for method in ("embedded_count", "embedded_sets"):
        with pytest.raises(NotApplicable, match="sample it first"):
            getattr(SETS[name], method)()
    assert not getattr(SETS[name], "is_discrete", lambda: False)()


@pytest.mark.parametrize("name", SETS)
def test_samples_have_the_grades_of_the_set_and_stay_normal_with_it(name: str) -> None:
    points = [0.0, 0.25, 1.0]
    sampled = SETS[name].sample(points, np.linspace(0.0, 1.0, 7))
    assert sampled.is_discrete()
    for x, vertical_slice in zip(points, sampled.slices, strict=True):
        assert isinstance(vertical_slice, SampledSet)
        np.testing.assert_allclose(
            vertical_slice.grades, SETS[name].secondary_grade(x, vertical_slice.points), atol=1e-12
        )
        assert vertical_slice.height == pytest.approx(SETS[name].secondary(x).height, abs=1e-9)
        assert (vertical_slice.grades > 0.0).all()


def test_slices_of_two_peaks_are_kept_at_their_points_but_not_interpolated() -> None:
    two_peaks = SampledSet([0.0, 0.5, 1.0], [1.0, 0.2, 1.0])
    fuzzy_set = SampledType2Set([0.0, 1.0], [two_peaks, two_peaks])
    assert fuzzy_set.secondary(0.0) == two_peaks
    np.testing.assert_array_equal(fuzzy_set.footprint(0.0), [0.0, 1.0])
    with pytest.raises(NotApplicable, match="not convex"):
        fuzzy_set.secondary(0.5)
    with pytest.raises(NotApplicable, match="not convex"):
        fuzzy_set.alpha_plane(0.5).lower(0.0)


def test_type_1_and_interval_planes_make_zslices() -> None:
    mixed = ZSlices(
        (0.4, 1.0), (GaussianUncertainMean((4.0, 6.0), 1.0), GaussianUncertainMean((5.0, 5.0), 1.0))
    )
    assert mixed.secondary(5.0) == Staircase((0.4, 1.0), (math.exp(-0.5), 1.0), (1.0, 1.0))
    crisp = ZSlices((1.0,), (Gaussian(0.0, 1.0),))
    assert crisp.secondary_grade(0.0, 1.0) == 1.0
    assert crisp.secondary_grade(0.0, 0.9) == 0.0


@pytest.mark.parametrize(
    "fuzzy_set", [BLURRED, SLICED, DISCRETE, SLICED.secondary(5.5), SETS["partially discrete"]]
)
def test_repr_rebuilds_the_set_and_equal_sets_hash_alike(fuzzy_set: object) -> None:
    copy = eval(
        repr(fuzzy_set),
        {name: getattr(fuzzy2, name) for name in fuzzy2.__all__}
        | vars(general_type2)
        | vars(vertical_slices)
        | {"Truncated": Truncated},
    )
    assert copy == fuzzy_set
    assert hash(copy) == hash(fuzzy_set)
    with pytest.raises(AttributeError):
        fuzzy_set.alphas = ()  # type: ignore[attr-defined]


@pytest.mark.parametrize("alpha", [-0.1, 1.1, math.nan, "a"])
def test_planes_outside_of_the_grades_are_refused(alpha: float) -> None:
    for fuzzy_set in (BLURRED, SLICED):
        with pytest.raises(InvalidValue, match=r"alpha must be in \[0, 1\]"):
            fuzzy_set.alpha_plane(alpha)


def test_planes_that_are_not_nested_are_refused_and_the_error_says_where() -> None:
    with pytest.raises(
        InvalidValue,
        match=r"planes\[0\]\.lower must be at most planes\[1\]\.lower everywhere, but at x = ",
    ):
        ZSlices(
            (0.5, 1.0),
            (GaussianUncertainSigma(5.0, (0.8, 1.5)), GaussianUncertainSigma(5.0, (0.5, 1.2))),
        )
    with pytest.raises(
        InvalidValue,
        match=r"planes\[1\]\.upper must be at most planes\[0\]\.upper everywhere, but at x = ",
    ):
        ZSlices(
            (0.5, 1.0),
            (GaussianUncertainSigma(5.0, (0.5, 1.1)), GaussianUncertainSigma(5.0, (0.8, 1.2))),
        )


@pytest.mark.parametrize(
    "make",
    [
        lambda: GaussianType2Set(0.5, 0.1),
        lambda: GaussianType2Set(Gaussian(0.0, 1.0), -0.1),
        lambda: GaussianType2Set(Gaussian(0.0, 1.0), math.nan),
        lambda: GaussianType2Set(Gaussian(0.0, 1.0), 0.1, (1.0, 0.0)),
        lambda: GaussianType2Set(Interval(0.0, 1.0), 0.1, (2.0, 3.0)),
        lambda: SampledType2Set([], []),
        lambda: SampledType2Set([0.0, 0.0], [Singleton(0.5)] * 2),
        lambda: SampledType2Set([0.0, math.nan], [Singleton(0.5)] * 2),
        lambda: SampledType2Set([0.0, 1.0], [Singleton(0.5)]),
        lambda: SampledType2Set([0.0], [Singleton(1.5)]),
        lambda: SampledType2Set([0.0], [Gaussian(0.5, 0.1)]),
        lambda: ZSlices((), ()),
        lambda: ZSlices((1.0, 0.5), SLICED.planes),
        lambda: ZSlices((0.5, 0.5), SLICED.planes),
        lambda: ZSlices((0.0, 0.5), SLICED.planes),
        lambda: ZSlices((0.5,), SLICED.planes),
        lambda: BLURRED.secondary(math.nan),
        lambda: TRIANGLES.secondary(math.nan),
        lambda: SLICED.secondary(math.inf),
        lambda: DISCRETE.secondary("a"),
    ],
)
def test_bad_parameters_are_refused(make: Callable[[], object]) -> None:
    with pytest.raises(InvalidValue, match="must be"):
        make()
