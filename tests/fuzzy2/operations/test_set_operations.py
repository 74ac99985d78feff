"""Union, intersection and complement of sets of all types, point by point and slice by slice."""

from __future__ import annotations

import numpy as np
import pytest

from fuzzy2.errors import InvalidValue
from fuzzy2.operations.join_meet import join, meet, negation
from fuzzy2.operations.set_operations import complement, intersection, union
from fuzzy2.sets.gaussian_type2 import GaussianType2Set
from fuzzy2.sets.general_type2 import GeneralType2Set, SampledType2Set
from fuzzy2.sets.interval_type2 import GaussianUncertainMean, IntervalType2Set
from fuzzy2.sets.shapes import Gaussian, Triangular
from fuzzy2.sets.type1 import SampledSet, Singleton, Type1Set

X = np.linspace(-4.0, 6.0, 101)
LOW, HIGH = Triangular(-1.0, 0.0, 2.0), Triangular(1.0, 2.0, 4.0)
FIRST, SECOND = (
    GaussianUncertainMean(mean=(0.0, 1.0), sigma=0.5),
    GaussianUncertainMean(mean=(2.0, 2.5), sigma=1.0),
)


def test_type_1_sets_combine_their_grades() -> None:
    found = union(LOW, HIGH)
    assert isinstance(found, Type1Set)
    np.testing.assert_array_equal(found(X), np.maximum(LOW(X), HIGH(X)))
    assert found.support == (-1.0, 4.0)
    found = intersection(LOW, HIGH, t_norm="product")
    assert isinstance(found, Type1Set)
    np.testing.assert_array_equal(found(X), LOW(X) * HIGH(X))
    assert found.support == (1.0, 2.0)
    found = union(LOW, Gaussian(0.0, 1.0), HIGH, t_conorm="probabilistic")
    assert isinstance(found, Type1Set)
    np.testing.assert_allclose(
        found(X), 1.0 - (1.0 - LOW(X)) * (1.0 - Gaussian(0.0, 1.0)(X)) * (1.0 - HIGH(X)), atol=1e-15
    )


def test_the_intersection_of_sets_that_do_not_meet_is_empty() -> None:
    found = intersection(Triangular(0.0, 1.0, 2.0), Triangular(3.0, 4.0, 5.0))
    assert isinstance(found, Type1Set)
    np.testing.assert_array_equal(found(X), 0.0)


def test_interval_sets_combine_lower_with_lower_and_upper_with_upper() -> None:
    found = union(FIRST, SECOND, LOW)
    assert isinstance(found, IntervalType2Set)
    np.testing.assert_array_equal(
        found.lower(X), np.maximum.reduce([FIRST.lower(X), SECOND.lower(X), LOW(X)])
    )
    np.testing.assert_array_equal(
        found.upper(X), np.maximum.reduce([FIRST.upper(X), SECOND.upper(X), LOW(X)])
    )
    found = intersection(FIRST, SECOND, t_norm="product")
    assert isinstance(found, IntervalType2Set)
    np.testing.assert_array_equal(found.lower(X), FIRST.lower(X) * SECOND.lower(X))
    found = complement(FIRST)
    assert isinstance(found, IntervalType2Set)
    np.testing.assert_array_equal(found.lower(X), 1.0 - FIRST.upper(X))
    np.testing.assert_array_equal(found.upper(X), 1.0 - FIRST.lower(X))


def test_complements_of_type_1_sets() -> None:
    for one in (LOW, Singleton(0.5), Gaussian(0.0, 1.0)):
        found = complement(one)
        assert complement(found) is one
        assert isinstance(found, Type1Set)
        np.testing.assert_array_equal(found(X), 1.0 - one(X))


def test_general_sets_combine_their_vertical_slices() -> None:
    first, second = (
        GaussianType2Set(principal=LOW, sigma=0.1),
        GaussianType2Set(principal=HIGH, sigma=0.2),
    )
    u = np.linspace(0.0, 1.0, 41)
    for found, operation in (
        (union(first, second, FIRST, LOW), join),
        (intersection(first, second, FIRST, LOW), meet),
    ):
        assert isinstance(found, GeneralType2Set)
        for x in (0.5, 1.5):
            expected = operation(
                first.secondary(x),
                second.secondary(x),
                FIRST.secondary(x),
                Singleton(float(LOW(x))),
            )
            np.testing.assert_array_equal(found.secondary(x)(u), expected(u))
    found = complement(first)
    assert isinstance(found, GeneralType2Set)
    np.testing.assert_allclose(found.secondary(0.5)(u), first.secondary(0.5)(1.0 - u), atol=1e-12)
    np.testing.assert_allclose(
        found.principal(np.array([0.5, 1.0])), 1.0 - LOW(np.array([0.5, 1.0])), atol=1e-12
    )


def test_sets_sampled_at_the_same_points_stay_sampled() -> None:
    slices = [SampledSet([0.1, 0.4], [0.5, 1.0]), SampledSet([0.3, 0.6], [1.0, 0.5])]
    first, second = SampledType2Set([0.0, 1.0], slices), SampledType2Set([0.0, 1.0], slices[::-1])
    found = union(first, second, t_norm="product")
    assert isinstance(found, SampledType2Set)
    assert found.points == (0.0, 1.0)
    assert found.slices[0] == join(*slices, t_norm="product")
    found = complement(first)
    assert isinstance(found, SampledType2Set)
    assert found.slices[1] == negation(slices[1])


def test_what_is_no_set_is_refused() -> None:
    with pytest.raises(InvalidValue, match="by keyword"):
        union(LOW, "product")  # type: ignore[arg-type]
    with pytest.raises(InvalidValue, match="at least one"):
        intersection()
    with pytest.raises(InvalidValue, match="fuzzy sets"):
        complement(0.5)  # type: ignore[arg-type]
