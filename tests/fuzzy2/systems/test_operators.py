"""Operators of systems by hand, with the values that users reported, and by their other names."""

from __future__ import annotations

import numpy as np
import pytest

import fuzzy2
from fuzzy2.errors import NotApplicable, UnknownName
from fuzzy2.systems import IntervalType2System, Type1System
from fuzzy2.systems.operators import ALIASES, METHODS, SUM, TYPE_REDUCTIONS, aggregation

T = fuzzy2.Triangular
QUALITY = {"poor": T(0, 0, 5), "average": T(0, 5, 10), "good": T(5, 10, 10)}
TIP = {"low": T(0, 0, 13), "medium": T(0, 13, 25), "high": T(13, 25, 25)}
RULES = """
    IF quality is poor or service is poor THEN tip is low
    IF service is average THEN tip is medium
    IF service is good or quality is good THEN tip is high
"""
SERVICE = {name: fuzzy2.Gaussian(c, 1.5) for name, c in (("poor", 0), ("good", 5), ("top", 10))}
FOOD = {
    "rancid": fuzzy2.Trapezoidal(-2, 0, 1, 3),
    "delicious": fuzzy2.Trapezoidal(7, 9, 10, 12),
}
TIPS = {"cheap": T(0, 5, 10), "average": T(10, 15, 20), "generous": T(20, 25, 30)}


def test_the_tipper_of_scikit_fuzzy_has_its_exact_centroid() -> None:
    """Their grid of 26 points gives 19.8767; the integral is 19.85776."""
    system = Type1System(
        {"quality": QUALITY, "service": QUALITY}, RULES, {"tip": TIP}, "min", "centroid",
        output_ranges=[(0, 25)],
    )  # fmt: skip
    np.testing.assert_allclose(system(quality=6.5, service=9.8), [19.85776], atol=1e-5)


def test_the_sugeno_tipper_with_or() -> None:
    """With one rule for each alternative it was 6.2950; constants are the published file's."""
    system = Type1System(
        {"service": SERVICE, "food": FOOD},
        """IF service is poor or food is rancid THEN tip is cheap
        IF service is good THEN tip is average
        IF service is top or food is delicious THEN tip is generous""",
        {"tip": {"cheap": 5.002, "average": 15.0, "generous": 24.998}},
    )
    np.testing.assert_allclose(system([2.0, 2.0]), [7.1317], atol=5e-5)
    assert system.table is not None


X = [[2.0, 7.0], [7.0, 8.0], [1.0, 1.0], [4.0, 2.0]]


@pytest.mark.parametrize(
    ("rules", "options", "right"),
    [
        (
            """IF service is poor or food is rancid THEN tip is cheap with 0.5
            IF service is good and food is not rancid THEN tip is average
            IF service is top or food is delicious THEN tip is generous""",
            {"type_reduction": "centroid"},
            [9.067988, 20.341567, 5.004001, 11.325582],
        ),
        (
            """IF service is poor or food is rancid THEN tip is cheap
            IF service is good THEN tip is average
            IF service is top or food is delicious THEN tip is generous""",
            {"type_reduction": "mom"},
            [4.95, 24.9, 5.1, 15.0],
        ),
        (
            """IF service is poor or food is rancid THEN tip is cheap
            IF service is good THEN tip is average
            IF service is top or food is delicious THEN tip is generous""",
            {"type_reduction": "centroid", "implication": "prod"},
            [7.48043, 20.48339, 5.28003, 11.163215],
        ),
    ],
)
def test_files_of_users_as_their_program_evaluates_them(
    rules: str, options: dict[str, str], right: list[float]
) -> None:
    """Weights, ``is not``, mean of maxima and another implication, summed over 101 points."""
    system = Type1System(
        {"service": SERVICE, "food": FOOD}, rules, {"tip": TIPS}, "min",
        integration="sum", resolution=101, output_ranges=[(0, 30)], **options,
    )  # fmt: skip
    found = system(X)[:, 0]
    np.testing.assert_allclose(found, right, atol=1e-6)


def test_weighted_sum_and_tsukamoto_by_hand() -> None:
    terms = {"x": {"low": T(-1, 0, 1), "high": T(0, 1, 2)}}
    rules = "IF x is low THEN y is a\nIF x is high THEN y is b"
    summed = Type1System(terms, rules, {"y": {"a": -2.0, "b": 4.0}}, type_reduction="wtsum")
    np.testing.assert_allclose(summed([0.25]), [0.75 * -2.0 + 0.25 * 4.0])
    assert np.isnan(summed([5.0])).all()
    # A set that rises on [0, 10] and one that falls: 0.75 and 0.25 are at 7.5 and 7.5.
    ramps = {"a": T(0, 10, 11), "b": T(-1, 0, 10)}
    tsukamoto = Type1System(
        terms, rules, {"y": ramps}, type_reduction="tsukamoto", output_ranges=[(0, 10)]
    )
    np.testing.assert_allclose(tsukamoto([[0.25], [1.0]]), [[7.5], [0.0]], atol=1e-9)
    with pytest.raises(NotApplicable, match="does not rise, or fall, all the way"):
        tsukamoto.replace(output_ranges=[(0, 11)])


def test_direct_methods_are_those_of_the_functions() -> None:
    terms = [[fuzzy2.GaussianUncertainSigma(c, (0.5, 1.0)) for c in (0.0, 1.0)]]
    system = IntervalType2System(terms, [[0], [1]], [[1.0], [3.0]])
    x, points = np.array([0.3]), np.array([1.0, 3.0])
    firing = system.firing(x)
    for method, expected in (
        ("nie_tan", fuzzy2.nie_tan(points, firing)),
        ("begian_melek_mendel", fuzzy2.begian_melek_mendel(points, firing, 0.3, 0.7)),
        ("wu_mendel", np.mean(fuzzy2.wu_mendel_bounds(points, firing))),
    ):
        found = system.replace(method=method, shares=(0.3, 0.7))(x)
        np.testing.assert_allclose(found, [expected], atol=1e-12)


def test_other_names_and_unknown_ones() -> None:
    sets = [T(0, 1, 2), T(1, 2, 3)]
    for name, known in ALIASES.items():
        if known == "center_of_sets" or known == "weighted_sum":
            continue
        assert Type1System([sets], [[0], [1]], sets, "min", name).type_reduction == known
    assert aggregation("sum") is SUM
    assert aggregation("probor").name == "probabilistic"
    with pytest.raises(UnknownName, match=TYPE_REDUCTIONS[-1]):
        Type1System([sets], [[0], [1]], sets, "min", "zentroid")
    with pytest.raises(UnknownName, match=METHODS[-1]):
        Type1System([sets], [[0], [1]], sets, method="kmm")
    with pytest.raises(NotApplicable, match="defined for type-1 systems"):
        IntervalType2System([sets], [[0], [1]], sets, "min", "bisector")


def test_rules_that_say_the_same_are_united_before_they_are_averaged() -> None:
    """As Octave does; two rules of 5 fire .6 and .8, one of 1 fires .4: written out."""
    terms = [fuzzy2.Triangular(-1.0, 0.0, 1.0), fuzzy2.Triangular(-4.0, 0.0, 4.0)]
    third = fuzzy2.Triangular(-2.0 / 3.0, 0.0, 2.0 / 3.0)
    for said, functions in (
        ([[5.0], [5.0], [1.0]], False),
        ([[[5.0, 0.0]], [[5.0, 0.0]], [[1.0, 0.0]]], True),
    ):
        for t_conorm, together in (("max", 0.8), ("probabilistic", 0.92), ("lukasiewicz", 1.0)):
            for reduction, divided in (("united_average", True), ("united_sum", False)):
                system = fuzzy2.Type1System(
                    [[*terms, third]],
                    [[0], [1], [2]],
                    fuzzy2.Linear(said) if functions else said,
                    type_reduction=reduction,
                    t_conorm=t_conorm,
                    weights=[0.75, 16.0 / 19.0, 1.0 / 1.75],
                )
                fired = system.firing([0.2])[:, 1]
                np.testing.assert_allclose(fired, [0.6, 0.8, 0.4], rtol=1e-12)
                expected = 5.0 * together + 0.4
                expected /= together + 0.4 if divided else 1.0
                np.testing.assert_allclose(system([0.2]), [expected], rtol=1e-12)


def test_trapezoids_between_points_count_the_ends_half() -> None:
    """Against NumPy's own, on the points of the grid."""
    low, high = fuzzy2.Trapezoidal(-1, 0, 2, 6), fuzzy2.Trapezoidal(3, 7, 10, 11)
    system = fuzzy2.Type1System(
        [[fuzzy2.Triangular(-1, 0, 1), fuzzy2.Triangular(0, 1, 2)]],
        [[0], [1]],
        [low, high],
        type_reduction="centroid",
        output_ranges=[(0.0, 10.0)],
        resolution=11,
        integration="trapezoidal",
    )
    y = np.linspace(0.0, 10.0, 11)
    united = np.maximum(0.7 * low(y), 0.3 * high(y))
    right = np.trapezoid(y * united, y) / np.trapezoid(united, y)
    np.testing.assert_allclose(system([0.3]), [right], rtol=1e-12)
    assert abs(system.replace(integration="sum")([0.3])[0] - right) > 1e-3
