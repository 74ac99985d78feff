"""Measures of type-1 and interval type-2 sets.

Closed forms, sums over a grid, all embedded sets of small samples, and what is refused.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fuzzy2 import cardinality, fuzziness, jaccard, rank
from fuzzy2.errors import InvalidValue, NotApplicable
from fuzzy2.operations.set_operations import union
from fuzzy2.sets.derived import FunctionalSet
from fuzzy2.sets.gaussian_type2 import GaussianType2Set
from fuzzy2.sets.interval_type2 import (
    GaussianUncertainMean,
    GaussianUncertainSigma,
    IntervalType2Set,
)
from fuzzy2.sets.shapes import Gaussian, Interval, Trapezoidal, Triangular
from fuzzy2.sets.sigmoids import Sigmoid, SigmoidProduct
from fuzzy2.sets.smooth_shapes import Bell
from fuzzy2.sets.type1 import SampledSet, Singleton, Type1Set

Footprint = Type1Set | IntervalType2Set

ROOT = math.sqrt(2.0 * math.pi)
TENT = IntervalType2Set(lower=Triangular(-1.0, 0.0, 1.0), upper=Triangular(-2.0, 0.0, 2.0))


def exactly(expected: float | tuple[float, float]) -> object:
    """Return what is equal within 1e-12.

    The quadrature is asked for 1e-13 of every piece, and kinks that it must find cost some of it.
    """
    return pytest.approx(expected, rel=1e-12, abs=1e-13)


numbers = st.floats(-5.0, 5.0)
widths = st.floats(0.1, 3.0)


@st.composite
def trapezoids(draw: st.DrawFn) -> IntervalType2Set:
    """Trapezoid within a trapezoid.

    Inner corners between outer ones, so that the lower membership is below the upper one.
    """
    a, b, c, d = np.cumsum([draw(numbers), *(draw(widths) for _ in range(3))]).tolist()
    share, height = draw(st.floats(0.0, 0.5)), draw(st.floats(0.2, 1.0))
    return IntervalType2Set(
        lower=Trapezoidal(a + share * (b - a), b, c, d - share * (d - c), height),
        upper=Trapezoidal(a, b, c, d),
    )


def uncertain_mean(mean: float, spread: float, sigma: float) -> IntervalType2Set:
    return GaussianUncertainMean(mean=(mean, mean + spread), sigma=sigma)


def uncertain_sigma(mean: float, spread: float, sigma: float) -> IntervalType2Set:
    return GaussianUncertainSigma(mean=mean, sigma=(sigma, sigma + spread))


footprints = st.one_of(
    trapezoids(),
    st.builds(uncertain_mean, numbers, widths, widths),
    st.builds(uncertain_sigma, numbers, widths, widths),
    st.builds(Gaussian, numbers, widths),
)


def moved(fuzzy_set: Footprint, shift: float) -> IntervalType2Set:
    """Return a bounded set, moved to the right, from its memberships alone."""

    def membership(whole: Type1Set) -> FunctionalSet:
        first, last = (end + shift for end in whole.support)
        return FunctionalSet(
            lambda x: whole(x - shift), first, last, tuple((whole.landmarks + shift).tolist())
        )

    return IntervalType2Set(lower=membership(fuzzy_set.lower), upper=membership(fuzzy_set.upper))


def grid_sum(
    integrand: Callable[[np.ndarray], np.ndarray],
    first: float = -60.0,
    last: float = 60.0,
    count: int = 240_000,
) -> float:
    """Midpoint rule: a kink costs at most an eighth of the square of the spacing.

    That is 2.5e-7, times the change of the slope.
    """
    edges = np.linspace(first, last, count + 1)
    return float(integrand(0.5 * (edges[1:] + edges[:-1])).sum() * (edges[1] - edges[0]))


@pytest.mark.parametrize(
    ("fuzzy_set", "left", "right"),
    [
        (Triangular(0.0, 1.0, 3.0), 1.5, 1.5),
        (Trapezoidal(0.0, 1.0, 2.0, 4.0, 0.5), 1.25, 1.25),
        (TENT, 1.0, 2.0),
        (Gaussian(3.0, 2.0, 0.5), ROOT, ROOT),
        (GaussianUncertainSigma(mean=-1.0, sigma=(0.5, 2.0)), 0.5 * ROOT, 2.0 * ROOT),
        (
            GaussianUncertainMean(mean=(-1.0, 1.0), sigma=0.5),
            0.5 * ROOT * math.erfc(math.sqrt(2.0)),
            0.5 * ROOT + 2.0,
        ),
        (
            Bell(0.0, 1.0, 2.0),
            math.pi / 2.0 / math.sin(math.pi / 4.0),
            math.pi / 2.0 / math.sin(math.pi / 4.0),
        ),
        (
            Bell(0.0, 1.0, 0.75),
            4.0 * math.pi / 3.0 / math.sin(2.0 * math.pi / 3.0),
            4.0 * math.pi / 3.0 / math.sin(2.0 * math.pi / 3.0),
        ),
        (Interval(2.0, 5.0), 3.0, 3.0),
        (Singleton(2.0), 0.0, 0.0),
        (IntervalType2Set(lower=Singleton(0.0), upper=Triangular(-1.0, 0.0, 1.0)), 0.0, 1.0),
        # Narrow beside the other: only its own corners tell the quadrature where it is.
        (
            IntervalType2Set(
                lower=Triangular(5.0, 5.0 + 2.0**-20, 5.0 + 2.0**-19),
                upper=Trapezoidal(0.0, 1.0, 99.0, 100.0),
            ),
            2.0**-20,
            99.0,
        ),
    ],
)
def test_cardinality_in_closed_form(fuzzy_set: Footprint, left: float, right: float) -> None:
    """Integrals of the formulas; the second bell has an area and no centroid."""
    assert cardinality(fuzzy_set) == exactly((left, right))


GAUSSIAN_FUZZINESS = 2.0 * (
    ROOT * math.erfc(math.sqrt(math.log(2.0))) + 2.0 * math.sqrt(2.0 * math.log(2.0))
)
GAUSSIAN_FUZZINESS -= 2.0 * ROOT * math.erf(math.sqrt(math.log(2.0)))


@pytest.mark.parametrize(
    ("fuzzy_set", "left", "right"),
    [
        # Over a slope the grade is uniform in [0, 1], and the mean of 2 min(u, 1 - u) is 1/2.
        (Triangular(0.0, 1.0, 3.0), 1.5, 1.5),
        (Trapezoidal(0.0, 1.0, 2.0, 4.0), 1.5, 1.5),
        # Right half: min(1 - x, x/2) has a third at its peak; min(x, 1/2, 1 - x/2) is 1/8 + 1/4 +
        # 1/4.
        (TENT, 2.0 / 3.0, 2.5),
        # Halves on both sides of the points of grade 1/2, at sigma sqrt(2 log 2).
        (Gaussian(4.0, 3.0), 3.0 * GAUSSIAN_FUZZINESS, 3.0 * GAUSSIAN_FUZZINESS),
        (Interval(2.0, 5.0), 0.0, 0.0),
        (Singleton(2.0), 0.0, 0.0),
        # Nothing is known of the grade: it may be crisp, and it may be 1/2 all along.
        (IntervalType2Set(lower=Singleton(0.0), upper=Interval(-1.0, 2.0)), 0.0, 3.0),
    ],
)
def test_fuzziness_in_closed_form(fuzzy_set: Footprint, left: float, right: float) -> None:
    assert fuzziness(fuzzy_set) == exactly((left, right))


@pytest.mark.parametrize(
    ("fuzzy_set", "expected"),
    [
        (SigmoidProduct((0.0, 200.0), (1.0, -1.0)), 8.0 * math.log(2.0)),
        (Triangular(-1e-9, 0.0, 1e-9), 1e-9),
        (Triangular(-1e9, 0.0, 1e9), 1e9),
    ],
)
def test_fuzziness_where_a_grade_is_1_but_for_rounding_and_on_any_scale(
    fuzzy_set: Type1Set, expected: float
) -> None:
    """Two sigmoids far apart have 2 log 2 on each side of each center.

    Rounding leaves 1e-13 of the cardinality, 200, of the first.
    """
    assert fuzziness(fuzzy_set)[0] == pytest.approx(expected, rel=1e-11)


def test_fuzziness_of_a_steep_bell_agrees_with_the_grid() -> None:
    """1 - u is below the rounding of u over most of its width.

    Spacing 1e-5; slopes of up to 5, curvature of up to 100.
    """
    steep = Bell(0.0, 1.0, 10.0)
    expected = grid_sum(
        lambda x: 2.0 * np.minimum(steep(x), 1.0 - steep(x)), -10.0, 10.0, 2_000_000
    )
    assert fuzziness(steep)[0] == pytest.approx(expected, abs=1e-8)


@pytest.mark.parametrize("shift", [0.0, 0.3, 1.0, 1.9, 2.0, 5.0])
def test_jaccard_of_shifted_sets_in_closed_form(shift: float) -> None:
    """Equal triangles meet in a smaller one, intervals in an interval, Gaussians in two tails."""
    common = max(2.0 - shift, 0.0) ** 2 / 4.0
    found = jaccard(Triangular(-1.0, 0.0, 1.0), Triangular(shift - 1.0, shift, shift + 1.0))
    assert found == exactly(common / (2.0 - common))
    common = max(2.0 - shift, 0.0)
    assert jaccard(Interval(0.0, 2.0), Interval(shift, shift + 2.0)) == exactly(
        common / (4.0 - common)
    )
    common = math.erfc(shift / 3.0 / math.sqrt(8.0))
    assert jaccard(Gaussian(0.0, 3.0), Gaussian(shift, 3.0)) == exactly(common / (2.0 - common))


def test_jaccard_of_nested_sets_is_the_ratio_of_their_areas() -> None:
    """Where one footprint is below the other, minima and maxima are the sets themselves.

    Below with both its bounds.
    """
    narrow, wide = (
        GaussianUncertainSigma(mean=1.0, sigma=(0.5, 1.0)),
        GaussianUncertainSigma(mean=1.0, sigma=(2.0, 3.0)),
    )
    assert jaccard(narrow, wide) == exactly(1.5 / 5.0)
    assert jaccard(Gaussian(1.0, 0.5), narrow) == exactly(1.0 / 1.5)
    assert jaccard(TENT, TENT.upper) == exactly(3.0 / 4.0)
    assert jaccard(Singleton(0.0), TENT) == 0.0


@settings(max_examples=25, deadline=None)
@given(first=footprints, second=footprints)
def test_all_measures_agree_with_a_grid(first: Footprint, second: Footprint) -> None:
    """The grid is within 1e-5.

    An eighth of the square of its spacing, times slopes of up to 20, at each of some ten kinks.
    """
    (low, high), (below, above) = (first.lower, first.upper), (second.lower, second.upper)
    assert cardinality(first) == pytest.approx((grid_sum(low), grid_sum(high)), abs=1e-5)

    def farthest(x: np.ndarray) -> np.ndarray:
        grades = np.stack([low(x), high(x)])
        return np.asarray(1.0 - 2.0 * abs(grades - 0.5).max(axis=0))

    def closest(x: np.ndarray) -> np.ndarray:
        return np.asarray(1.0 - 2.0 * abs(np.clip(0.5, low(x), high(x)) - 0.5))

    assert fuzziness(first) == pytest.approx((grid_sum(farthest), grid_sum(closest)), abs=1e-5)
    intersection = grid_sum(lambda x: np.minimum(high(x), above(x)) + np.minimum(low(x), below(x)))
    whole = grid_sum(lambda x: np.maximum(high(x), above(x)) + np.maximum(low(x), below(x)))
    assert jaccard(first, second) == pytest.approx(intersection / whole, abs=1e-5 / whole + 1e-5)


@settings(max_examples=25, deadline=None)
@given(first=footprints, second=footprints)
def test_jaccard_is_a_similarity(first: Footprint, second: Footprint) -> None:
    """In [0, 1], symmetric, and 1 for equal memberships only.

    Sets that differ by a thousandth on the grid are told apart.
    """
    found = jaccard(first, second)
    assert 0.0 <= found <= 1.0
    assert found == jaccard(second, first)
    assert jaccard(first, first) == 1.0
    x = np.linspace(-20.0, 20.0, 401)
    if (
        max(
            abs(first.lower(x) - second.lower(x)).max(), abs(first.upper(x) - second.upper(x)).max()
        )
        > 1e-3
    ):
        assert found < 1.0


@settings(max_examples=20, deadline=None)
@given(fuzzy_set=trapezoids(), shifts=st.tuples(widths, widths))
def test_jaccard_falls_as_a_set_is_shifted_away(
    fuzzy_set: IntervalType2Set, shifts: tuple[float, float]
) -> None:
    """Of convex sets; once they do not meet any more it stays 0."""
    near, far = (jaccard(fuzzy_set, moved(fuzzy_set, shift)) for shift in (shifts[0], sum(shifts)))
    assert near < 1.0
    assert near > far or near == far == 0.0


@settings(max_examples=20, deadline=None)
@given(first=trapezoids(), second=trapezoids(), shift=numbers, scale=st.floats(0.1, 1.0))
def test_cardinality_and_fuzziness_grow_with_the_set_and_stay_when_it_moves(
    first: IntervalType2Set, second: IntervalType2Set, shift: float, scale: float
) -> None:
    """A union is at least as large as each of its sets.

    1e-11 is for the kinks of unions, which are not known in advance.
    """
    both = union(first, second)
    assert isinstance(both, IntervalType2Set)
    for one in (first, second):
        for whole, part in zip(cardinality(both), cardinality(one), strict=True):
            assert whole >= part - 1e-11
    assert sum(cardinality(both)) <= sum(cardinality(first)) + sum(cardinality(second)) + 1e-11
    again = moved(first, shift)
    assert cardinality(again) == pytest.approx(cardinality(first), rel=1e-11)
    assert fuzziness(again) == pytest.approx(fuzziness(first), rel=1e-11, abs=1e-11)
    # Less is known of the grade: the interval of the fuzziness widens on both sides.
    wider = IntervalType2Set(
        lower=FunctionalSet(lambda x: scale * first.lower(x), *first.lower.support),
        upper=first.upper,
    )
    (left, right), (least, greatest) = fuzziness(first), fuzziness(wider)
    assert least <= left + 1e-11
    assert greatest >= right - 1e-11


@settings(max_examples=20, deadline=None)
@given(fuzzy_set=footprints, seed=st.integers(0, 1000))
def test_embedded_sets_lie_within_both_intervals(fuzzy_set: Footprint, seed: int) -> None:
    if isinstance(fuzzy_set, Type1Set):
        for left, right in (cardinality(fuzzy_set), fuzziness(fuzzy_set)):
            assert left == right
        return
    embedded = fuzzy_set.embedded(np.random.default_rng(seed))
    for measure in (cardinality, fuzziness):
        (left, right), (value, same) = measure(fuzzy_set), measure(embedded)
        assert value == same
        assert left - 1e-11 <= value <= right + 1e-11


grades = st.tuples(st.integers(0, 20), st.integers(0, 20)).map(
    lambda pair: (min(pair) / 20.0, max(pair) / 20.0)
)


@settings(max_examples=40, deadline=None)
@given(
    bounds=st.lists(grades, min_size=4, max_size=4),
    lengths=st.lists(widths, min_size=4, max_size=4),
)
def test_the_ends_are_those_of_all_embedded_sets_of_steps(
    bounds: list[tuple[float, float]], lengths: list[float]
) -> None:
    """Both memberships are constant on four intervals.

    On each the embedded sets take both grades, one half, and some grades between.

    Sums over all of their combinations know nothing of which sets are extreme. 1e-11 is for
    rounding.
    """
    edges = np.concatenate([[0.0], np.cumsum(lengths)])

    def steps(values: tuple[float, ...]) -> FunctionalSet:
        of_step = np.asarray(values)
        return FunctionalSet(
            lambda x: of_step[np.clip(np.searchsorted(edges, x, side="right") - 1, 0, 3)],
            0.0,
            float(edges[-1]),
            tuple(edges.tolist()),
        )

    fuzzy_set = IntervalType2Set(
        lower=steps(tuple(low for low, _ in bounds)), upper=steps(tuple(high for _, high in bounds))
    )
    choices = [np.arange(round(20 * low), round(20 * high) + 1) / 20.0 for low, high in bounds]
    # Every third twentieth besides the ends and the half: more would make no other extremes, only
    # more sums.
    choices = [np.unique([*some[::3], some[-1], *some[some == 0.5]]) for some in choices]
    chosen = np.array(list(itertools.product(*choices)))
    areas = chosen @ lengths
    indices = np.where(chosen < 0.5, 2.0 * chosen, 2.0 - 2.0 * chosen) @ lengths
    assert cardinality(fuzzy_set) == pytest.approx((areas.min(), areas.max()), abs=1e-11)
    assert fuzziness(fuzzy_set) == pytest.approx((indices.min(), indices.max()), abs=1e-11)


def test_rank_orders_by_the_middles_of_centroids() -> None:
    """The middle is neither that of the support, nor the centroid of the upper membership."""
    lopsided = IntervalType2Set(
        lower=Triangular(6.0, 7.0, 8.0), upper=Trapezoidal(0.0, 1.0, 7.0, 8.0)
    )
    x = np.linspace(0.0, 8.0, 8001)
    low, high = lopsided.lower(x), lopsided.upper(x)
    ends = [
        [np.where(x < c, *pair) @ x / np.where(x < c, *pair).sum() for c in x]
        for pair in ((high, low), (low, high))
    ]
    middle = 0.5 * (min(ends[0]) + max(ends[1]))
    assert abs(middle - 4.0) > 0.05
    below, above = (
        Gaussian(middle - 0.02, 1.0),
        GaussianUncertainMean(mean=(middle - 0.98, middle + 1.02), sigma=0.5),
    )
    sets: list[Footprint] = [above, lopsided, Singleton(9.0), below, Singleton(-3.0)]
    order = rank(sets)
    assert order.tolist() == [4, 3, 1, 0, 2]
    assert rank(tuple(sets[i] for i in order)).tolist() == [0, 1, 2, 3, 4]


# Words of amount from a survey, as trapezoids: corners of the upper membership, corners and height
# of the lower one, and the printed centroid. Centroids of the outermost words were computed on a
# grid that their steep shoulders make visible, so they are left out. (J. M. Mendel and D. Wu,
# "Perceptual Computing: Aiding People in Making Subjective Judgments", Wiley, 2010, Table 3.6.)
WORDS = {
    "none to very little": ((0.0, 0.0, 0.14, 1.97), (0.0, 0.0, 0.05, 0.66, 1.0), None),
    "a bit": ((0.59, 1.50, 2.00, 3.41), (0.79, 1.68, 1.68, 2.21, 0.74), (1.42, 2.08)),
    "low amount": ((0.09, 1.25, 2.50, 4.62), (1.67, 1.92, 1.92, 2.21, 0.30), (0.92, 3.46)),
    "small": ((0.09, 1.50, 3.00, 4.62), (1.79, 2.28, 2.28, 2.81, 0.40), (1.29, 3.34)),
    "somewhat small": ((0.59, 2.00, 3.25, 4.41), (2.29, 2.70, 2.70, 3.21, 0.42), (1.76, 3.43)),
    "some to moderate": ((1.17, 3.50, 5.50, 7.83), (4.09, 4.65, 4.65, 5.41, 0.40), (3.02, 6.11)),
    "moderate amount": ((2.59, 4.00, 5.50, 7.62), (4.29, 4.75, 4.75, 5.21, 0.38), (3.74, 6.16)),
    "fair amount": ((2.17, 4.25, 6.00, 7.83), (4.79, 5.29, 5.29, 6.02, 0.41), (3.85, 6.41)),
    "medium": ((3.59, 4.75, 5.50, 6.91), (4.86, 5.03, 5.03, 5.14, 0.27), (4.19, 6.19)),
    "modest amount": ((3.59, 4.75, 6.00, 7.41), (4.79, 5.30, 5.30, 5.71, 0.42), (4.57, 6.24)),
    "good amount": ((3.38, 5.50, 7.50, 9.62), (5.79, 6.50, 6.50, 7.21, 0.41), (5.11, 7.89)),
    "quite a bit": ((4.38, 6.50, 8.00, 9.41), (6.79, 7.38, 7.38, 8.21, 0.49), (6.17, 8.15)),
    "considerable amount": ((4.38, 6.50, 8.25, 9.62), (7.19, 7.58, 7.58, 8.21, 0.37), (5.97, 8.52)),
    "substantial amount": ((5.38, 7.50, 8.75, 9.81), (7.79, 8.22, 8.22, 8.81, 0.45), (6.95, 8.86)),
    "a lot": ((5.38, 7.50, 8.75, 9.83), (7.69, 8.19, 8.19, 8.81, 0.47), (6.99, 8.83)),
    "high amount": ((5.38, 7.50, 8.75, 9.81), (7.79, 8.30, 8.30, 9.21, 0.53), (7.19, 8.82)),
    "large": ((5.98, 7.75, 8.60, 9.52), (8.03, 8.36, 8.36, 9.17, 0.57), (7.50, 8.75)),
    "maximum amount": ((8.68, 9.91, 10.0, 10.0), (9.61, 9.97, 10.0, 10.0, 1.0), None),
}


def test_published_words_come_in_their_published_order() -> None:
    """Printed to two digits, of which the last may be off by half a unit.

    So may those of the corners; the table is in ascending order.
    """
    sets = [
        IntervalType2Set(lower=Trapezoidal(*lower), upper=Trapezoidal(*upper))
        for upper, lower, _ in WORDS.values()
    ]
    shuffled = np.random.default_rng(0).permutation(len(sets))
    np.testing.assert_array_equal(shuffled[rank([sets[i] for i in shuffled])], np.arange(len(sets)))
    for fuzzy_set, (_, _, printed) in zip(sets, WORDS.values(), strict=True):
        if printed is not None:
            assert fuzzy_set.centroid() == pytest.approx(printed, abs=0.006)


@settings(max_examples=20, deadline=None)
@given(means=st.permutations([-2.0, -1.0, 0.0, 1.0, 3.0]), spread=widths)
def test_rank_of_equal_shapes_is_the_order_of_their_places(
    means: list[float], spread: float
) -> None:
    sets = [GaussianUncertainMean(mean=(mean, mean + spread), sigma=0.5) for mean in means]
    assert rank(iter(sets)).tolist() == np.argsort(means).tolist()


def test_sets_of_one_middle_stay_in_their_order() -> None:
    """Centroids of sets about 0 are exactly symmetric."""
    assert rank(
        [Singleton(0.0), Interval(-1.0, 1.0), Triangular(-1.0, 0.0, 1.0), Singleton(-1.0)]
    ).tolist() == [3, 0, 1, 2]


@pytest.mark.parametrize(
    "shoulder", [Sigmoid(0.0, 1.0), Trapezoidal(0.0, 1.0, math.inf, math.inf), Bell(0.0, 1.0, 0.5)]
)
def test_sets_without_finite_area_are_refused(shoulder: Type1Set) -> None:
    """And each measure says which one it is, and how to go on."""
    above_something = IntervalType2Set(lower=Triangular(1.0, 2.0, 3.0, 0.1), upper=shoulder)
    calls: dict[str, Callable[[], object]] = {
        "cardinality": lambda: cardinality(shoulder),
        "fuzziness": lambda: fuzziness(above_something),
        "jaccard": lambda: jaccard(Triangular(-1.0, 0.0, 1.0), shoulder),
    }
    for name, call in calls.items():
        with pytest.raises(NotApplicable, match=rf"^{name} does not apply: .*sample\(\)"):
            call()
    with pytest.raises(NotApplicable, match="centroid"):
        rank([Singleton(0.0), shoulder])
    sampled = shoulder.sample(np.linspace(-5.0, 5.0, 11))
    assert 0.0 < 0.5 * fuzziness(sampled)[0] < cardinality(sampled)[0] < 10.0


def test_two_sets_without_area_have_no_similarity() -> None:
    with pytest.raises(NotApplicable, match=r"^jaccard does not apply: .*zero almost everywhere"):
        jaccard(Singleton(0.0), Singleton(0.0))
    with pytest.raises(NotApplicable, match="zero almost everywhere"):
        jaccard(Singleton(0.0), Singleton(1.0))


@pytest.mark.parametrize(
    "bad",
    [
        0.5,
        "tall",
        None,
        [Gaussian(0.0, 1.0)],
        GaussianType2Set(Gaussian(0.0, 1.0), 0.1),
        SampledSet,
    ],
)
def test_what_is_no_bounded_footprint_is_refused(bad: Any) -> None:
    calls: list[Callable[[], object]] = [
        lambda: cardinality(bad),
        lambda: fuzziness(bad),
        lambda: jaccard(bad, TENT),
        lambda: jaccard(TENT, bad),
        lambda: rank([TENT, bad]),
    ]
    for call in calls:
        with pytest.raises(InvalidValue, match="must be a type-1 or an interval type-2 set"):
            call()


def test_rank_wants_a_sequence_of_sets() -> None:
    with pytest.raises(InvalidValue, match="at least one"):
        rank([])
    with pytest.raises(InvalidValue, match="a sequence of fuzzy sets"):
        rank(TENT)  # type: ignore[arg-type]
