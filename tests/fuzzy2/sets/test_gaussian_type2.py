"""General type-2 sets whose vertical slices are Gaussians."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fuzzy2.errors import InvalidValue, NotApplicable
from fuzzy2.sets.derived import Truncated
from fuzzy2.sets.gaussian_type2 import GaussianType2Set
from fuzzy2.sets.shapes import Gaussian, Triangular
from fuzzy2.sets.type1 import Singleton
from tests.fuzzy2.sets.general_type2_sets import SETS

BLURRED = GaussianType2Set(principal=Gaussian(mean=0.0, sigma=1.0), sigma=0.1, domain=(-4.0, 4.0))

PROPORTIONAL = GaussianType2Set(
    principal=Gaussian(0.0, 1.0), sigma=lambda x: 0.2 * np.exp(-0.5 * x**2), domain=(-6.0, 6.0)
)


@settings(max_examples=200)
@given(x=st.floats(-4.0, 4.0), u=st.floats(0.0, 1.0), sigma=st.floats(0.01, 1.0))
def test_gaussian_slices_by_formula(x: float, u: float, sigma: float) -> None:
    """One exponential of rounded arguments: 1e-12 relative to the greatest grade."""
    fuzzy_set = GaussianType2Set(Gaussian(0.5, 2.0), sigma)
    principal = math.exp(-((x - 0.5) ** 2) / 8.0)
    expected = math.exp(-((u - principal) ** 2) / (2.0 * sigma**2))
    assert fuzzy_set.secondary_grade(x, u) == pytest.approx(expected, abs=1e-12)
    assert float(fuzzy_set.secondary(x)(u)) == pytest.approx(expected, abs=1e-12)
    assert fuzzy_set.principal(x) == pytest.approx(principal, abs=1e-15)
    assert fuzzy_set.secondary_grade(x, -0.1) == fuzzy_set.secondary_grade(x, 1.1) == 0.0


def test_the_footprint_of_gaussian_slices_is_the_whole_unit_interval() -> None:
    np.testing.assert_array_equal(BLURRED.footprint([-1.0, 0.0, 3.9]), [[0.0, 1.0]] * 3)
    np.testing.assert_array_equal(BLURRED.footprint([-4.1, 5.0]), [[0.0, 0.0]] * 2)
    crisp = SETS["crisp gaussian"]
    np.testing.assert_array_equal(crisp.footprint(1.0), [math.exp(-0.5)] * 2)
    assert crisp.secondary(1.0) == Singleton(math.exp(-0.5))
    assert crisp.secondary_grade(1.0, math.exp(-0.5)) == 1.0
    assert GaussianType2Set(Triangular(0.0, 1.0, 2.0), 0.0, (0.5, 9.0)).support == (0.5, 2.0)


def test_sigma_may_vary_and_a_bad_one_is_refused_where_it_is_evaluated() -> None:
    np.testing.assert_allclose(
        PROPORTIONAL.spread([0.0, 1.0]), [0.2, 0.2 * math.exp(-0.5)], rtol=1e-15
    )
    assert PROPORTIONAL.secondary(1.0) == Truncated(
        Gaussian(math.exp(-0.5), float(PROPORTIONAL.spread(1.0))), 0.0, 1.0
    )
    for bad in (lambda x: -0.1 + 0.0 * x, lambda x: np.nan + x):
        with pytest.raises(InvalidValue, match="sigma must be finite numbers of at least 0"):
            GaussianType2Set(Gaussian(0.0, 1.0), bad).upper(0.0)


@pytest.mark.parametrize("alpha", [0.05, 0.5, 0.9, 1.0])
def test_centroids_of_gaussian_planes_against_enumeration(alpha: float) -> None:
    """Trapezoidal rule on 20 001 points with all switch points.

    1e-3 is its step; at alpha = 1 the plane is the principal set.
    """
    plane = PROPORTIONAL.alpha_plane(alpha)
    left, right = plane.centroid()
    x = np.linspace(-6.0, 6.0, 20_001)
    lower, upper = plane.lower(x), plane.upper(x)
    weight = np.append(0.0, np.cumsum(upper)) + np.append(np.cumsum(lower[::-1])[::-1], 0.0)
    moment = np.append(0.0, np.cumsum(upper * x)) + np.append(
        np.cumsum((lower * x)[::-1])[::-1], 0.0
    )
    assert left == pytest.approx((moment / weight).min(), abs=1e-6)
    assert right == pytest.approx(-left, abs=1e-10)
    if alpha == 1.0:
        assert left == pytest.approx(0.0, abs=1e-12)


def test_a_constant_blur_on_an_unbounded_domain_has_no_centroid() -> None:
    with pytest.raises(NotApplicable, match="unbounded"):
        GaussianType2Set(Gaussian(0.0, 1.0), 0.1).alpha_plane(0.5).centroid()
