"""Defuzzifiers against closed forms and published systems.

And the thesis's caution about the height of type-reduced sets.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fuzzy2.errors import InvalidValue, NotApplicable, UnknownName
from fuzzy2.reduction.defuzzification import (
    METHODS,
    bisector,
    defuzzify,
    defuzzify_samples,
    height,
    largest_of_maxima,
    mean_of_maxima,
)
from fuzzy2.sets.derived import FunctionalSet
from fuzzy2.sets.general_type2 import SampledType2Set
from fuzzy2.sets.shapes import Gaussian, Interval, Trapezoidal, Triangular
from fuzzy2.sets.sigmoids import Sigmoid
from fuzzy2.sets.smooth_shapes import Bell
from fuzzy2.sets.type1 import SampledSet, Singleton, Type1Set

TRAPEZOID = Trapezoidal(0.0, 1.0, 2.0, 4.0, 0.5)


@pytest.mark.parametrize(
    ("method", "fuzzy_set", "expected"),
    [
        ("centroid", TRAPEZOID, (0.5 * 2 / 3 + 1.5 + 2 + 2 / 3) / 2.5),
        ("bisector", TRAPEZOID, 1.75),
        ("height", TRAPEZOID, 1.5),
        ("smallest_of_maxima", TRAPEZOID, 1.0),
        ("mean_of_maxima", TRAPEZOID, 1.5),
        ("largest_of_maxima", TRAPEZOID, 2.0),
        ("bisector", Triangular(0.0, 0.2, 1.0), 1.0 - math.sqrt(0.4)),
        ("bisector", Gaussian(3.0, 0.1), 3.0),
        ("bisector", Bell(3.0, 0.1, 1.0), 3.0),  # it has an area, but no centroid
        (
            "bisector",
            SampledSet([0.0, 1.0, 2.0, 3.0, 4.0, 5.0], [0.0, 1.0, 0.0, 0.0, 1.0, 0.0]),
            2.5,
        ),
        (
            "mean_of_maxima",
            SampledSet([0.0, 1.0, 2.0, 6.0, 8.0], [1.0, 1.0, 0.0, 1.0, 1.0]),
            (0.5 * 1 + 7.0 * 2) / 3,
        ),
        ("mean_of_maxima", SampledSet([0.0, 1.0, 3.0, 5.0], [1.0, 0.0, 1.0, 0.0]), 1.5),
        (
            "mean_of_maxima",
            FunctionalSet(
                lambda x: np.where((x <= 1.0) | (x >= 3.0), 1.0, 0.0), 0.0, 4.0, (1.0, 3.0)
            ),
            2.0,
        ),
        *[(method, Singleton(2.5), 2.5) for method in METHODS],
        *[
            (method, Interval(0.0, 1.0), 0.5)
            for method in ("centroid", "bisector", "height", "mean_of_maxima")
        ],
    ],
)
def test_continuous_sets_in_closed_form(method: str, fuzzy_set: Type1Set, expected: float) -> None:
    """By hand, to the square root of rounding.

    The bisector is sought where the membership vanishes.
    """
    assert defuzzify(fuzzy_set, method) == pytest.approx(
        expected, abs=1e-8 if method == "bisector" else 1e-12
    )


@settings(max_examples=60, deadline=None)
@given(corners=st.lists(st.integers(0, 1000), min_size=4, max_size=4, unique=True))
def test_the_bisector_halves_the_area(corners: list[int]) -> None:
    """Area on both sides by scipy, 1e-9 relative."""
    from scipy.integrate import quad

    a, b, c, d = sorted(corners)
    fuzzy_set = Trapezoidal(a, b, c, d)
    point = bisector(fuzzy_set)
    sides = [
        quad(fuzzy_set, low, high, points=(b, c), limit=200)[0]
        for low, high in ((a, point), (point, d))
    ]
    assert sides[0] == pytest.approx(sides[1], rel=1e-9)


@settings(max_examples=100)
@given(
    grades=st.lists(st.floats(0.0, 1.0), min_size=1, max_size=12),
    shift=st.floats(-100.0, 100.0),
    data=st.data(),
)
def test_samples_move_and_mirror_with_their_points(
    grades: list[float], shift: float, data: st.DataObject
) -> None:
    """All defuzzifiers are equivariant; 1e-9 for the rounding of shifted points."""
    points = np.array(
        sorted(
            data.draw(
                st.lists(
                    st.integers(-50, 50), min_size=len(grades), max_size=len(grades), unique=True
                )
            )
        ),
        dtype=float,
    )
    mirrored = {
        "smallest_of_maxima": "largest_of_maxima",
        "largest_of_maxima": "smallest_of_maxima",
    }
    for method in METHODS:
        found = defuzzify_samples(points, grades, method)
        np.testing.assert_allclose(
            defuzzify_samples(points + shift, grades, method), found + shift, atol=1e-9
        )
        np.testing.assert_allclose(
            defuzzify_samples(-points[::-1], grades[::-1], mirrored.get(method, method)),
            -found,
            atol=1e-9,
        )
        if max(grades) > 0.0:
            assert points[0] - 1e-9 <= found <= points[-1] + 1e-9
        else:
            assert np.isnan(found)


def test_samples_by_hand_in_any_shape() -> None:
    """Two sets, one without membership and one with NaN: 1.69 for the centroid."""
    points = [0.0, 1.0, 3.0, 4.0]
    grades = np.array(
        [
            [[0.2, 0.8, 0.8, 0.2], [0.0, 1.0, 1.0, 1.0]],
            [[0.0, 0.0, 0.0, 0.0], [0.5, math.nan, 0.5, 0.5]],
        ]
    )
    expected = {
        "centroid": (2.0, 8.0 / 3.0),
        "bisector": (2.0, 3.0),
        "height": (2.0, 8.0 / 3.0),
        "smallest_of_maxima": (1.0, 1.0),
        "mean_of_maxima": (2.0, 8.0 / 3.0),
        "largest_of_maxima": (3.0, 4.0),
    }
    for method in METHODS:
        found = defuzzify_samples(points, grades, method)
        assert found.shape == (2, 2)
        np.testing.assert_allclose(found[0], expected[method], rtol=1e-15)
        assert np.isnan(found[1]).all()


def test_tiny_grades_keep_their_digits() -> None:
    assert defuzzify_samples([0.0, 1.0], [1e-310, 3e-310]) == pytest.approx(0.75, rel=1e-10)


@pytest.mark.parametrize(
    ("service", "food", "published"), [(2.0, 1.0, 7.0169), (7.0, 8.0, 20.3414)]
)
def test_the_tip_of_mathworks(service: float, food: float, published: float) -> None:
    """MathWorks, documentation of evalfis (readfis('tipper')).

    Minimum and maximum, centroid on 101 points; printed to 5e-5.
    """
    poor, good, excellent = (Gaussian(center, 1.5)(service) for center in (0.0, 5.0, 10.0))
    rancid, delicious = (
        Trapezoidal(-2.0, 0.0, 1.0, 3.0)(food),
        Trapezoidal(7.0, 9.0, 10.0, 12.0)(food),
    )
    tip = np.linspace(0.0, 30.0, 101)
    cheap, average, generous = (
        Triangular(*corners)(tip) for corners in ((0, 5, 10), (10, 15, 20), (20, 25, 30))
    )
    fired = [
        np.minimum(max(poor, rancid), cheap),
        np.minimum(good, average),
        np.minimum(max(excellent, delicious), generous),
    ]
    assert defuzzify_samples(tip, np.max(fired, axis=0)) == pytest.approx(published, abs=5e-5)


def test_height_weighs_the_peaks_of_the_output_sets_of_rules() -> None:
    """Eq. 1.73 by hand; a plateau counts with its middle."""
    outputs = [Triangular(0.0, 1.0, 2.0, 0.25), TRAPEZOID, Gaussian(4.0, 1.0, 0.75)]
    assert height(outputs) == pytest.approx((1.0 * 0.25 + 1.5 * 0.5 + 4.0 * 0.75) / 1.5, rel=1e-15)
    assert height(TRAPEZOID) == 1.5
    assert math.isnan(height([SampledSet([1.0, 2.0], [0.0, 0.0])]))
    with pytest.raises(InvalidValue, match="at least one set"):
        height([])


def type_reduced(fuzzy_set: SampledType2Set) -> SampledSet:
    """Centroids of all embedded sets (eq. 1.70, minimum t-norm).

    Each has the smallest of its secondary grades.
    """
    embedded = [one for one in fuzzy_set.embedded_sets() if one.memberships.any()]
    return SampledSet(
        [np.average(one.points, weights=one.memberships) for one in embedded],
        [one.grades.min() for one in embedded],
    )


def blurred(below: float, above: float) -> SampledType2Set:
    """Return a principal set with triangular secondaries.

    They reach ``below`` and ``above`` it, the more the farther to the right.
    """
    points, principal = np.arange(5.0), np.array([0.2, 0.6, 0.8, 0.5, 0.3])
    slices = []
    for x, membership in zip(points, principal, strict=True):
        ends = membership - below * x, membership + above * x
        slices.append(
            SampledSet(
                [
                    ends[0],
                    0.5 * (ends[0] + membership),
                    membership,
                    0.5 * (membership + ends[1]),
                    ends[1],
                ],
                [0.1, 0.5, 1, 0.5, 0.1],
            )
        )
    return SampledType2Set(points, slices)


def test_height_of_a_type_reduced_set_throws_all_uncertainty_away() -> None:
    """The thesis's caution: the point of membership 1 is the type-1 centroid.

    It is so whatever the secondaries; the centroid defuzzifier sees them.

    1e-12: both are averages of five points.
    """
    points, principal = np.arange(5.0), [0.2, 0.6, 0.8, 0.5, 0.3]
    type1_output = np.average(points, weights=principal)
    outputs = []
    for below, above in ((0.0, 0.02), (0.0, 0.08), (0.05, 0.05), (0.07, 0.01)):
        reduced = type_reduced(blurred(below, above))
        assert len(reduced) > 50
        for method in ("height", "smallest_of_maxima", "mean_of_maxima", "largest_of_maxima"):
            assert defuzzify_samples(reduced.points, reduced.grades, method) == pytest.approx(
                type1_output, rel=1e-12
            )
        outputs.append(float(defuzzify_samples(reduced.points, reduced.grades)))
    # More membership to the right moves the centroid to the right, and less of it to the left.
    assert outputs[1] > outputs[0] > type1_output > outputs[3]
    assert outputs[1] - type1_output > 0.05


@pytest.mark.parametrize("method", METHODS)
def test_sets_that_have_no_such_number_are_refused(method: str) -> None:
    with pytest.raises(NotApplicable):
        defuzzify(Sigmoid(0.0, 1.0), method)


def test_maxima_without_an_end_have_no_mean() -> None:
    shoulder = Trapezoidal(0.0, 1.0, math.inf, math.inf)
    assert largest_of_maxima(shoulder) == math.inf
    with pytest.raises(NotApplicable, match="no end"):
        mean_of_maxima(shoulder)
    with pytest.raises(NotApplicable, match="zero almost everywhere"):
        bisector(FunctionalSet(lambda x: 0.0 * x, 0.0, 1.0))


def test_an_unknown_name_is_refused_and_the_known_ones_are_listed() -> None:
    for call in (
        lambda: defuzzify(TRAPEZOID, "mom"),
        lambda: defuzzify_samples([0.0], [1.0], "mom"),
    ):
        with pytest.raises(
            UnknownName,
            match=(
                "unknown defuzzifier 'mom'; known are centroid, bisector, height, "
                "smallest_of_maxima"
            ),
        ):
            call()


@pytest.mark.parametrize(
    ("points", "grades"),
    [
        ([], []),
        ([0.0, math.nan], [1.0, 1.0]),
        ([1.0, 0.0], [1.0, 1.0]),
        ([0.0, 1.0], [1.0]),
        ([0.0, 1.0], [1.0, -0.1]),
        ([0.0, 1.0], [1.0, math.inf]),
        ([[0.0, 1.0]], [1.0, 1.0]),
        ("ab", [1.0, 1.0]),
    ],
)
def test_bad_samples_are_refused(points: object, grades: object) -> None:
    with pytest.raises(InvalidValue, match="must be"):
        defuzzify_samples(points, grades)  # type: ignore[arg-type]
