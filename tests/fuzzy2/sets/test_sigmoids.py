"""Sigmoids, and differences and products of two."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from fuzzy2.errors import InvalidValue
from fuzzy2.sets.sigmoids import SigmoidDifference, SigmoidProduct
from fuzzy2.sets.type1 import Type1Set
from tests.fuzzy2.sets.type1_sets import SETS


def test_a_sigmoid_approaches_1_but_is_not_normal() -> None:
    rising = SETS["rising sigmoid"]
    assert rising.height == 1.0
    assert rising.core is None
    assert not rising.is_normal()
    assert rising.alpha_cut(0.5) == (1.0, math.inf)
    assert SETS["falling sigmoid"].alpha_cut(0.5) == (-math.inf, 1.0)
    with pytest.raises(InvalidValue, match="never reaches"):
        rising.alpha_cut(1.0)


# Parameters are those of the examples in MathWorks' documentation (dsigmf [5 2 5 7], psigmf [2 3 -5
# 8]), and the references are its formulas.
def documented_sig(x: float, a: float, c: float) -> float:
    return 1 / (1 + math.exp(-a * (x - c)))


@pytest.mark.parametrize(
    ("fuzzy_set", "documented"),
    [
        (
            SigmoidDifference((2.0, 7.0), (5.0, 5.0)),
            lambda x: documented_sig(x, 5, 2) - documented_sig(x, 5, 7),
        ),
        (
            SigmoidProduct((3.0, 8.0), (2.0, -5.0)),
            lambda x: documented_sig(x, 2, 3) * documented_sig(x, -5, 8),
        ),
    ],
)
def test_memberships_are_those_of_the_toolbox_formulas(
    fuzzy_set: Type1Set, documented: Callable[[float], float]
) -> None:
    """On the 101 points of the documentation's plots; 1e-15 is the rounding of the differences."""
    x = np.linspace(0.0, 10.0, 101)
    np.testing.assert_allclose(
        fuzzy_set(x), [documented(point) for point in x], rtol=1e-13, atol=1e-15
    )


def test_the_maximum_of_a_symmetric_difference_of_sigmoids() -> None:
    """tanh(s (c2 - c1) / 4), midway.

    The place of a flat maximum is known to the square root of its height's rounding.
    """
    bump = SigmoidDifference(center=(2.0, 3.0), slope=(5.0, 5.0))
    assert bump.height == pytest.approx(math.tanh(1.25), rel=1e-15)
    assert bump.maxima == pytest.approx((2.5, 2.5), abs=1e-5)
    left, right = bump.alpha_cut([1e-6, 0.3, 0.6])
    np.testing.assert_allclose(bump(left), [1e-6, 0.3, 0.6], rtol=1e-11)
    np.testing.assert_allclose(left + right, 5.0, rtol=1e-12)


def test_sigmoids_of_different_slopes_cross_and_their_difference_has_two_bumps() -> None:
    two_bumps = SigmoidDifference(center=(2.0, 3.0), slope=(5.0, 2.0))
    assert two_bumps(4.0 / 3.0) == pytest.approx(0.0, abs=1e-15)  # where 5 (x - 2) = 2 (x - 3)
    assert not two_bumps.is_convex()
    valley = SigmoidDifference(center=(2.0, 3.0), slope=(5.0, -5.0))
    assert (valley.maxima, valley.height, valley.is_convex()) == (None, 1.0, False)
    np.testing.assert_allclose(valley([-np.inf, 2.5, np.inf]), [1.0, 0.0, 1.0], atol=1e-15)
