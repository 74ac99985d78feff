"""Type-1 sets made of others or of functions: functional, truncated and complement."""

from __future__ import annotations

import math

import numpy as np
import pytest

from fuzzy2.sets.derived import Complement, Truncated
from fuzzy2.sets.shapes import Gaussian, Interval, Trapezoidal, Triangular
from fuzzy2.sets.smooth_shapes import (
    PiShaped,
)
from fuzzy2.sets.type1 import Singleton, Type1Set
from tests.fuzzy2.sets.type1_sets import SETS


def test_cuts_of_the_functional_set_are_found_by_bisection() -> None:
    """sqrt(1 - alpha) in closed form; the bisection ends at neighboring floats."""
    alphas = np.array([0.1, 0.5, 0.99, 1.0])
    left, right = SETS["functional"].alpha_cut(alphas)
    # at 1 the membership is flat: sqrt(eps)
    np.testing.assert_allclose(right, np.sqrt(1.0 - alphas), atol=1e-7)
    np.testing.assert_allclose(right[:3], np.sqrt(1.0 - alphas[:3]), rtol=1e-13)
    np.testing.assert_allclose(left, -right, atol=1e-7)


def test_a_truncated_set_keeps_what_is_left_of_its_maximum() -> None:
    falling = Truncated(Gaussian(-1.0, 1.0), 0.0, 1.0)
    assert falling.height == pytest.approx(math.exp(-0.5), rel=1e-15)
    assert falling.maxima == (0.0, 0.0)
    assert falling.core is None
    np.testing.assert_allclose(
        falling.alpha_cut([0.3, falling.height]),
        [[0.0, 0.0], [math.sqrt(-2 * math.log(0.3)) - 1.0, 0.0]],
        atol=1e-9,
    )
    assert Truncated(Interval(0.0, 5.0), 1.0, 2.0).maxima == (1.0, 2.0)


@pytest.mark.parametrize(
    ("whole", "height", "maxima", "support"),
    [
        (Triangular(0.0, 1.0, 2.0), 1.0, (-math.inf, math.inf), (-math.inf, math.inf)),
        (PiShaped(0.0, 1.0, math.inf, math.inf), 1.0, (-math.inf, 0.0), (-math.inf, 1.0)),
        (Trapezoidal(-math.inf, -math.inf, 0.0, 1.0), 1.0, (1.0, math.inf), (0.0, math.inf)),
        (Gaussian(0.0, 1.0), 1.0, None, (-math.inf, math.inf)),
        (Trapezoidal(-math.inf, -math.inf, math.inf, math.inf), 0.0, None, (-math.inf, math.inf)),
    ],
)
def test_where_complements_are_highest(
    whole: Type1Set, height: float, maxima: tuple[float, float] | None, support: tuple[float, float]
) -> None:
    found = Complement(whole)
    assert (found.height, found.maxima, found.support) == (height, maxima, support)
    np.testing.assert_array_equal(
        found(np.linspace(-3.0, 3.0, 61)), 1.0 - whole(np.linspace(-3.0, 3.0, 61))
    )


@pytest.mark.parametrize(
    "whole",
    [
        Interval(0.0, 2.0),
        Singleton(1.0),
        Triangular(0.0, 0.0, 2.0),
        Trapezoidal(0.0, 0.0, 2.0, 2.0),
    ],
)
def test_landmarks_of_a_complement_reach_beyond_the_jumps_of_the_set(whole: Type1Set) -> None:
    """Something of the complement is between them, or the range of a variable would be empty."""
    found = Complement(whole)
    assert found(found.landmarks[[0, -1]]).tolist() == [1.0, 1.0]


def test_only_complements_of_shoulders_are_convex() -> None:
    assert not Complement(Gaussian(0.0, 1.0)).is_convex()
    assert not Complement(Triangular(0.0, 1.0, 2.0)).is_convex()
    shoulder = Complement(PiShaped(-math.inf, -math.inf, 0.0, 2.0, height=0.8))
    assert shoulder.is_convex()
    np.testing.assert_array_equal(
        shoulder.alpha_cut([0.1, 0.6, 1.0]), [[-math.inf, 1.0, 2.0], [math.inf] * 3]
    )
    twice = Complement(Complement(Gaussian(0.0, 1.0)))
    assert twice.is_convex()
    assert twice.height == 1.0
    np.testing.assert_allclose(twice.alpha_cut(0.5), Gaussian(0.0, 1.0).alpha_cut(0.5), rtol=1e-12)
