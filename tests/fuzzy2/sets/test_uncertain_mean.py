"""The membership functions of a Gaussian with uncertain mean."""

from __future__ import annotations

import math

import numpy as np
import pytest

from fuzzy2.sets.interval_type2 import GaussianUncertainMean

FIRST = GaussianUncertainMean(mean=(4.0, 6.0), sigma=1.0)


def test_membership_functions_of_an_uncertain_mean_are_type_1_sets() -> None:
    """Heights and cuts by hand: 2 ln 2 for alpha = 1/2."""
    reach = math.sqrt(2.0 * math.log(2.0))
    assert FIRST.upper.core == (4.0, 6.0)
    np.testing.assert_allclose(FIRST.upper.alpha_cut(0.5), (4.0 - reach, 6.0 + reach), rtol=1e-15)
    assert FIRST.lower.height == pytest.approx(math.exp(-0.5), rel=1e-15)
    assert FIRST.lower.maxima == (5.0, 5.0)
    np.testing.assert_allclose(FIRST.lower.alpha_cut(0.5), (6.0 - reach, 4.0 + reach), rtol=1e-15)
    np.testing.assert_allclose(FIRST.lower.alpha_cut(FIRST.lower.height), (5.0, 5.0), rtol=1e-15)
    assert FIRST.support == FIRST.lower.support == (-math.inf, math.inf)
    assert FIRST.lower.centroid() == pytest.approx(5.0, rel=1e-14)
    assert FIRST.upper.centroid() == pytest.approx(5.0, rel=1e-14)
