"""Every published or independently confirmed number.

Through the public functions, each to its own tolerance; see `vectors.py`.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from fuzzy2.numbers import GaussianNumber
from fuzzy2.operations.join_meet import join, meet
from fuzzy2.reduction.defuzzification import defuzzify_samples
from fuzzy2.reduction.general import (
    alpha_plane_centroid,
    alpha_plane_defuzzify,
    alpha_plane_reduction,
    exhaustive_centroid,
)
from fuzzy2.reduction.interval import METHODS, centroid, generalized_centroid
from fuzzy2.sets.general_type2 import SampledType2Set, ZSlices
from fuzzy2.sets.interval_type2 import (
    GaussianUncertainMean,
    GaussianUncertainSigma,
    IntervalType2Set,
)
from fuzzy2.sets.shapes import Gaussian, Interval, Trapezoidal, Triangular
from fuzzy2.sets.type1 import SampledSet
from tests.vectors import VECTORS, Vector

ELEVEN = np.arange(11.0)


def starting_with(*prefixes: str) -> list[str]:
    return [name for name in VECTORS if name.startswith(prefixes)]


MENDEL = starting_with("mendel2001_table9-1", "mendel2001_table9-2")
WORDS = starting_with("word_")
CONTINUOUS = starting_with("closed_form", "gauss_uncertain_mean_continuous")
DISCRETE = starting_with("discrete_")
TIPPER = starting_with("matlab_tipper")
SUMS = starting_with("gauss_sum")
SLICES = ["wagner_hagras2010_zslice_1/3", "wagner_hagras2010_zslice_1"]
OTHERS = [
    "wagner_hagras2010_zslice_crisp",
    "wagner_hagras2010_wavy_slice",
    "mendel_john2002_embedded_count",
    "wu_tutorial_4rules",
    "juzzy_java_single_rule",
]


def test_no_vector_is_left_out() -> None:
    assert sorted(
        MENDEL + WORDS + CONTINUOUS + DISCRETE + TIPPER + SUMS + SLICES + OTHERS
    ) == sorted(VECTORS)


def mendel_set(inputs: dict[str, Any]) -> IntervalType2Set:
    if "m1" in inputs:
        return GaussianUncertainMean(mean=(inputs["m1"], inputs["m2"]), sigma=inputs["sigma"])
    return GaussianUncertainSigma(mean=inputs["mean"], sigma=(inputs["s1"], inputs["s2"]))


def close(found: Any, vector: Vector, key: str, tolerance: str) -> None:
    np.testing.assert_allclose(
        found, vector.expected[key], rtol=0.0, atol=vector.tolerance[tolerance]
    )


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("name", MENDEL)
def test_centroids_of_mendels_book(name: str, method: str) -> None:
    vector = VECTORS[name]
    x, fuzzy_set = np.linspace(0.0, 10.0, 101), mendel_set(vector.inputs)
    found = centroid(x, fuzzy_set.lower(x), fuzzy_set.upper(x), method)
    close(found, vector, "exact_on_grid", "exact")
    printed = "published_4dp" if "published_4dp" in vector.expected else "quoted_5dp"
    close(found, vector, printed, printed.split("_")[0])


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("name", SLICES)
def test_centroids_of_wagner_and_hagras_zslices(name: str, method: str) -> None:
    """The printed right end of slice 1/3 (6.3333) has no tolerance.

    Enumeration does not reproduce it either.
    """
    vector = VECTORS[name]
    found = centroid(ELEVEN, vector.inputs["lower"], vector.inputs["upper"], method)
    close(found, vector, "exact_on_grid", "exact")
    if vector.tolerance["published"] is not None:
        close(found, vector, "published", "published")
    else:
        assert found[0] == pytest.approx(vector.expected["published"][0], abs=1e-4)
        assert abs(found[1] - vector.expected["published"][1]) > 0.06


def wagner_hagras_slices() -> tuple[list[float], list[np.ndarray], list[np.ndarray]]:
    crisp = VECTORS["wagner_hagras2010_zslice_crisp"].inputs
    first, last = (VECTORS[name].inputs for name in SLICES)
    return (
        crisp["z"],
        [
            np.array(lower, dtype=float)
            for lower in (first["lower"], crisp["lower_2/3"], last["lower"])
        ],
        [
            np.array(upper, dtype=float)
            for upper in (first["upper"], crisp["upper_2/3"], last["upper"])
        ],
    )


@pytest.mark.parametrize("method", METHODS)
def test_crisp_value_of_wagner_and_hagras_zslices(method: str) -> None:
    vector = VECTORS["wagner_hagras2010_zslice_crisp"]
    alphas, lower, upper = wagner_hagras_slices()
    reduced = alpha_plane_reduction(alphas, ELEVEN, np.stack([lower, upper], axis=-1), method)
    close(reduced.crisp, vector, "exact", "exact")
    planes = [
        IntervalType2Set(lower=SampledSet(ELEVEN, low), upper=SampledSet(ELEVEN, high))
        for low, high in zip(lower, upper, strict=True)
    ]
    as_set = alpha_plane_centroid(ZSlices(tuple(alphas), tuple(planes)), ELEVEN, alphas, method)
    close(as_set.crisp, vector, "exact", "exact")
    # What the paper prints follows from its own wrong end, 6.3333: ends of four digits move the
    # result by 1e-5 at most.
    wrong = reduced.intervals.copy()
    wrong[0, 1] = 6.3333
    assert alpha_plane_defuzzify(alphas, wrong) == pytest.approx(
        vector.expected["published"], abs=1e-5
    )


def test_wavy_slice_by_exhaustive_enumeration() -> None:
    vector = VECTORS["wagner_hagras2010_wavy_slice"]
    slices = vector.inputs["set"]
    fuzzy_set = SampledType2Set(
        [float(x) for x in slices],
        [
            SampledSet([float(u) for u in grades], list(grades.values()))
            for grades in slices.values()
        ],
    )
    reduced = exhaustive_centroid(fuzzy_set, "min")
    expected = vector.expected["centroid"]
    # The seven points are given with nine decimals.
    np.testing.assert_allclose(
        reduced.set.points,
        sorted(float(y) for y in expected),
        rtol=0.0,
        atol=vector.tolerance["exact"],
    )
    np.testing.assert_array_equal(reduced.set.grades, list(expected.values()))
    close(reduced.crisp, vector, "crisp", "exact")


def test_number_of_embedded_sets_of_mendel_and_john() -> None:
    vector = VECTORS["mendel_john2002_embedded_count"]
    counts = vector.inputs["M"]
    fuzzy_set = SampledType2Set(
        np.arange(len(counts)), [SampledSet(np.linspace(0.1, 0.9, m), np.ones(m)) for m in counts]
    )
    assert fuzzy_set.embedded_count() == vector.expected["count"]
    assert sum(1 for _ in fuzzy_set.embedded_sets()) == vector.expected["count"]


@pytest.mark.parametrize("method", METHODS)
def test_four_rules_by_center_of_sets(method: str) -> None:
    vector = VECTORS["wu_tutorial_4rules"]
    found = generalized_centroid(vector.inputs["consequents"], vector.inputs["firing"], method)
    for value, key in ((found[0], "y_l"), (found[1], "y_r"), (found.mean(), "y")):
        close(value, vector, key, "exact")


@pytest.mark.parametrize("name", TIPPER)
def test_tipper_of_matlab(name: str) -> None:
    """Mamdani with min and max.

    Poor or rancid -> cheap, good -> average, excellent or delicious -> generous.
    """
    vector = VECTORS[name]
    service, food = vector.inputs["service"], vector.inputs["food"]
    poor, good, excellent = (Gaussian(mean, 1.5)(service) for mean in (0.0, 5.0, 10.0))
    rancid, delicious = (
        Trapezoidal(-2.0, 0.0, 1.0, 3.0)(food),
        Trapezoidal(7.0, 9.0, 10.0, 12.0)(food),
    )
    tips = Triangular(0.0, 5.0, 10.0), Triangular(10.0, 15.0, 20.0), Triangular(20.0, 25.0, 30.0)
    x = np.linspace(0.0, 30.0, 101)
    firing = max(poor, rancid), good, max(excellent, delicious)
    output = np.max(
        [np.minimum(strength, tip(x)) for strength, tip in zip(firing, tips, strict=True)], axis=0
    )
    for found in (float(defuzzify_samples(x, output)), *centroid(x, output, output)):
        close(found, vector, "published", "published")
        assert found == pytest.approx(vector.expected["exact_on_grid"], abs=1e-9)


@pytest.mark.parametrize("method", METHODS)
def test_single_rule_of_juzzy(method: str) -> None:
    vector = VECTORS["juzzy_java_single_rule"]
    x = np.linspace(0.0, 24.0, 100)
    found = centroid(x, Gaussian(0.0, 4.0)(x), Gaussian(0.0, 6.0)(x), method)
    np.testing.assert_allclose(
        found, vector.expected["exact"], rtol=0.0, atol=vector.tolerance["java"]
    )
    close(found.mean(), vector, "java", "java")


def continuous_set(inputs: dict[str, Any]) -> IntervalType2Set:
    if "m1" in inputs:
        return GaussianUncertainMean(mean=(inputs["m1"], inputs["m2"]), sigma=inputs["sigma"])
    if "h" in inputs:
        return IntervalType2Set(
            lower=Triangular(-1.0, 0.0, 1.0, height=inputs["h"]), upper=Triangular(-1.0, 0.0, 1.0)
        )
    low = Trapezoidal(0.0, 0.0, 1.0, 1.0, height=inputs["lower"])
    return IntervalType2Set(lower=low, upper=Interval(0.0, 1.0))


@pytest.mark.parametrize("name", CONTINUOUS)
def test_centroids_on_the_continuous_domain(name: str) -> None:
    vector = VECTORS[name]
    left, right = continuous_set(vector.inputs).centroid()
    close(left, vector, "c_l", "exact")
    close(right, vector, "c_r", "exact")


@pytest.mark.parametrize("name", WORDS)
def test_centroids_of_the_word_codebook(name: str) -> None:
    vector = VECTORS[name]
    *corners, height = vector.inputs["lmf"]
    word = IntervalType2Set(
        lower=Trapezoidal(*corners, height=height), upper=Trapezoidal(*vector.inputs["umf"])
    )
    x = np.linspace(0.0, 10.0, 100001)
    close(centroid(x, word.lower(x), word.upper(x)), vector, "exact_on_grid", "exact")


@pytest.mark.parametrize("name", DISCRETE)
def test_joins_and_meets_of_discrete_sets(name: str) -> None:
    vector = VECTORS[name]
    f, g = (
        SampledSet([float(u) for u in vector.inputs[key]], list(vector.inputs[key].values()))
        for key in "FG"
    )
    grade_norm = {"min": "min", "prod": "product"}[vector.inputs["tnorm"]]
    found = {
        "join_max": lambda: join(f, g, t_norm="min", grade_t_norm=grade_norm),
        "meet_min": lambda: meet(f, g, t_norm="min", grade_t_norm=grade_norm),
        "meet_product": lambda: meet(f, g, t_norm="product", grade_t_norm=grade_norm),
    }[vector.inputs["op"]]()
    assert isinstance(found, SampledSet)
    grades = found.grades[found.grades > 0.0]
    tolerance = vector.tolerance["exact"]
    np.testing.assert_allclose(
        found.points[found.grades > 0.0],
        [float(u) for u in vector.expected],
        rtol=0.0,
        atol=tolerance,
    )
    np.testing.assert_allclose(grades, list(vector.expected.values()), rtol=0.0, atol=tolerance)


@pytest.mark.parametrize("name", SUMS)
def test_sums_of_gaussian_numbers(name: str) -> None:
    vector = VECTORS[name]
    inputs = vector.inputs
    mean, sigma = np.transpose([inputs["F"], inputs["G"]])
    total = (
        GaussianNumber(mean, sigma, inputs["tnorm"]) @ np.array(inputs["alpha"], dtype=float)
        + inputs["beta"]
    )
    close(total.mean, vector, "mean", "exact")
    close(total.sigma, vector, "sigma", "exact")
