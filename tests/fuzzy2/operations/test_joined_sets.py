"""The sets that joins, meets and negations make: sets like any other."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fuzzy2.errors import NotApplicable
from fuzzy2.operations import join_meet, joined_sets, t_norms
from fuzzy2.operations.continuous_meet import tabulated
from fuzzy2.operations.join_meet import join, meet, negation
from fuzzy2.operations.joined_sets import ExtremumSet, NegatedSet, supremum
from fuzzy2.operations.t_norms import t_norm
from fuzzy2.sets import shapes, smooth_shapes
from fuzzy2.sets.shapes import Gaussian, Interval, Trapezoidal, Triangular
from fuzzy2.sets.sigmoids import Sigmoid
from fuzzy2.sets.type1 import SampledSet, Type1Set
from tests.fuzzy2.operations.any_sets import convex_functions, discrete_sets

RESULTS = {
    "join": lambda: join(Gaussian(0.3, 0.1), Triangular(0.2, 0.6, 0.9)),
    "meet": lambda: meet(Gaussian(0.3, 0.1), Triangular(0.2, 0.6, 0.9)),
    "join, product grades": lambda: join(
        Gaussian(0.3, 0.1), Triangular(0.2, 0.6, 0.9), t_norm="product"
    ),
    "meet, product grades": lambda: meet(
        Gaussian(0.3, 0.1), Trapezoidal(0.2, 0.4, 0.6, 0.9), grade_t_norm="product"
    ),
    "join, low": lambda: join(Gaussian(0.3, 0.1, 0.7), Triangular(0.2, 0.6, 0.9, 0.9)),
    "meet, low": lambda: meet(Gaussian(0.3, 0.1, 0.7), Triangular(0.2, 0.6, 0.9, 0.9)),
    "product meet": lambda: meet(Gaussian(0.3, 0.1), Triangular(0.2, 0.6, 0.9), t_norm="product"),
    "product meet, minimum grades": lambda: meet(
        Gaussian(0.3, 0.1, 0.8), Triangular(0.2, 0.6, 0.9), t_norm="product", grade_t_norm="min"
    ),
    "probabilistic join": lambda: join(
        Gaussian(0.3, 0.1), Triangular(0.2, 0.6, 0.9), t_conorm="probabilistic"
    ),
    "three": lambda: meet(
        Triangular(0.3, 0.4, 0.8),
        Triangular(0.2, 0.6, 0.9),
        Triangular(0.4, 0.6, 1.0),
        t_norm="product",
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", RESULTS)
def test_results_are_sets_like_any_other(name: str) -> None:
    """Height, maxima, support, cuts and centroid against 20001 samples of the membership.

    To 1e-3 of a set of unit size.
    """
    found = RESULTS[name]()
    u = np.linspace(-0.5, 1.5, 20001)
    grades = found(u)
    assert found.height == pytest.approx(grades.max(), abs=1e-3)
    assert found.is_convex()
    assert found.maxima is not None
    highest = u[grades >= found.height - 1e-9]
    assert found.maxima[0] == pytest.approx(highest[0], abs=1e-3)
    assert found.maxima[1] == pytest.approx(highest[-1], abs=1e-3)
    assert found.is_normal() == (found.height == 1.0)
    positive = u[grades > 1e-12]
    left, right = found.support
    assert left <= positive[0] + 1e-4
    assert right >= positive[-1] - 1e-4
    for alpha in (0.05, 0.3, 0.6):
        inside = u[grades >= alpha]
        np.testing.assert_allclose(found.alpha_cut(alpha), inside[[0, -1]], rtol=0.0, atol=2e-4)
    np.testing.assert_allclose(
        found.alpha_cut(np.array([0.2, 0.4]))[0], [found.alpha_cut(0.2)[0], found.alpha_cut(0.4)[0]]
    )
    assert found.centroid() == pytest.approx(float((u * grades).sum() / grades.sum()), abs=1e-3)
    assert found(0.5).shape == ()
    assert found(np.full((2, 3), 0.5)).shape == (2, 3)
    assert np.isnan(found(np.nan))
    assert found.landmarks.size >= 2
    again = RESULTS[name]()
    assert found == again
    assert hash(found) == hash(again)


@pytest.mark.parametrize("name", RESULTS)
def test_their_representation_rebuilds_them(name: str) -> None:
    found = RESULTS[name]()
    names = vars(join_meet) | vars(joined_sets) | vars(shapes) | vars(smooth_shapes) | vars(t_norms)
    assert eval(repr(found), names) == found


def test_sigmoids_that_never_reach_their_height() -> None:
    """A rising sigmoid is highest at infinity, so that a join with it is, too.

    A meet is highest where the other set is.
    """
    rising, bump = Sigmoid(0.5, 20.0), Triangular(0.2, 0.4, 0.6)
    theta = np.linspace(0.0, 1.0, 101)
    joined, met = join(rising, bump), meet(rising, bump)
    assert joined.maxima is None
    assert not joined.is_normal()
    expected = np.where(
        theta < 0.4,
        np.minimum(rising(theta), bump(theta)),
        np.maximum(rising(theta), np.minimum(rising(theta), bump(theta))),
    )
    np.testing.assert_allclose(joined(theta), expected, rtol=0.0, atol=1e-15)
    # w >= theta is always found where the sigmoid is 1, and the triangle is free to be at its peak.
    expected = np.maximum(
        np.where(theta <= 0.4, rising(theta), np.minimum(rising(theta), bump(theta))), bump(theta)
    )
    np.testing.assert_allclose(met(theta), expected, rtol=0.0, atol=1e-15)
    assert met.maxima == (0.4, 0.4)
    falling = join(Sigmoid(0.5, -20.0), bump)
    assert falling.maxima == (0.4, 0.4)
    assert falling.alpha_cut(0.5)[0] == pytest.approx(0.3, abs=1e-12)
    assert join(rising, bump, grade_t_norm="product").alpha_cut(0.5)[1] == math.inf
    with pytest.raises(NotApplicable):
        joined.centroid()
    product = meet(rising, Gaussian(0.5, 0.1), t_norm="product")
    assert product.height == pytest.approx(float(rising(1.0)), abs=1e-15)


@given(one=convex_functions(normal=False))
@settings(max_examples=100, deadline=None)
def test_negation_mirrors_a_set_and_undoes_itself(one: Type1Set) -> None:
    """Away from vertical edges by less than 1e-9 of the steepest slope.

    At these edges rounding of 1 - u decides.
    """
    mirrored = negation(one)
    u = np.linspace(-0.013, 1.011, 97)
    np.testing.assert_allclose(mirrored(u), one(1.0 - u), rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(negation(mirrored)(u), one(u), rtol=0.0, atol=1e-12)


def test_negation_of_any_set() -> None:
    assert negation(Gaussian(0.25, 0.1, 0.5)) == Gaussian(0.75, 0.1, 0.5)
    assert negation(Interval(0.25, 0.5)) == Interval(0.5, 0.75)
    assert negation(SampledSet([0.0, 0.25], [0.5, 1.0])) == SampledSet([0.75, 1.0], [1.0, 0.5])
    assert negation(Sigmoid(0.25, 3.0)) == Sigmoid(0.75, -3.0)
    original = join(Gaussian(0.3, 0.1), Triangular(0.2, 0.6, 0.9))
    mirrored = negation(original)
    assert isinstance(mirrored, NegatedSet)
    assert negation(mirrored) is original
    assert mirrored.height == 1.0
    assert mirrored.core == pytest.approx((0.4, 0.4))
    assert mirrored.centroid() == pytest.approx(1.0 - original.centroid(), abs=1e-10)
    np.testing.assert_allclose(
        mirrored.alpha_cut(0.5), 1.0 - np.array(original.alpha_cut(0.5))[::-1]
    )
    np.testing.assert_allclose(mirrored.landmarks, 1.0 - original.landmarks[::-1])
    rising = negation(join(Sigmoid(0.5, 20.0), Triangular(0.2, 0.4, 0.6)))
    assert rising.maxima is None


@given(
    one=st.one_of(discrete_sets(), convex_functions(normal=False)),
    ends=st.tuples(st.integers(-4, 24), st.integers(-4, 24)),
)
@settings(max_examples=300, deadline=None)
def test_supremum_over_an_interval(one: Type1Set, ends: tuple[int, int]) -> None:
    """All peaks and corners are twentieths, and the samples hold those."""
    left, right = ends[0] / 20.0, ends[1] / 20.0
    found = float(supremum(one, np.array([left]), np.array([right]))[0])
    # Of a cut Gaussian both ends are corners; samples between twentieths are not needed but do no
    # harm.
    samples = np.array([k / 20.0 for k in range(min(ends), max(ends) + 1)])
    expected = one(samples).max() if left <= right else 0.0
    assert found == pytest.approx(expected, abs=1e-15)


def test_table_is_within_its_tolerance_even_at_jumps() -> None:
    original = Trapezoidal(0.2, 0.2, 0.5, 0.9)
    table = tabulated(
        ExtremumSet("join", (original, Triangular(0.0, 0.1, 0.3)), t_norm("product"), True)
    )
    u = np.linspace(0.0, 1.0, 7001)
    far = np.abs(u - 0.2) > 1e-9
    expected = join(original, Triangular(0.0, 0.1, 0.3), t_norm="product")(u)
    np.testing.assert_allclose(table(u)[far], expected[far], rtol=0.0, atol=3e-7)
