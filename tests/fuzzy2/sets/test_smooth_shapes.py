"""Smooth type-1 sets against the formulas that the Fuzzy Logic Toolbox documents."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from fuzzy2.sets.smooth_shapes import PiShaped, TwoSidedGaussian
from fuzzy2.sets.type1 import Type1Set
from tests.fuzzy2.sets.type1_sets import SETS


# Parameters are those of the examples in MathWorks' documentation of each function (smf [1 8], zmf
# [3 7], pimf [1 4 5 10], gauss2mf with [2 4 1 8], [2 5 1 8] and so on), and the references are
# its formulas, piece by piece.
def documented_s(x: float, a: float, b: float) -> float:
    if x <= a:
        return 0.0
    if x <= (a + b) / 2:
        return 2 * ((x - a) / (b - a)) ** 2
    return 1 - 2 * ((x - b) / (b - a)) ** 2 if x <= b else 1.0


def documented_z(x: float, a: float, b: float) -> float:
    if x <= a:
        return 1.0
    if x <= (a + b) / 2:
        return 1 - 2 * ((x - a) / (b - a)) ** 2
    return 2 * ((x - b) / (b - a)) ** 2 if x <= b else 0.0


def documented_gauss2(x: float, sigma1: float, c1: float, sigma2: float, c2: float) -> float:
    left = math.exp(-((x - c1) ** 2) / (2 * sigma1**2)) if x <= c1 else 1.0
    return left * (math.exp(-((x - c2) ** 2) / (2 * sigma2**2)) if x >= c2 else 1.0)


@pytest.mark.parametrize(
    ("fuzzy_set", "documented"),
    [
        (PiShaped(1.0, 8.0, math.inf, math.inf), lambda x: documented_s(x, 1, 8)),
        (PiShaped(-math.inf, -math.inf, 3.0, 7.0), lambda x: documented_z(x, 3, 7)),
        (PiShaped(1.0, 4.0, 5.0, 10.0), lambda x: documented_s(x, 1, 4) * documented_z(x, 5, 10)),
        (TwoSidedGaussian((4.0, 8.0), (2.0, 1.0)), lambda x: documented_gauss2(x, 2, 4, 1, 8)),
        (TwoSidedGaussian((8.0, 4.0), (2.0, 1.0)), lambda x: documented_gauss2(x, 2, 8, 1, 4)),
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


SMOOTH = [
    "pi",
    "low s",
    "z",
    "two-sided gaussian",
    "crossed gaussian",
    "gaussian shoulder",
    "sigmoid difference",
    "sigmoid product",
]


@pytest.mark.parametrize("name", [*SMOOTH, "rising sigmoid product", "not z", "not rising sigmoid"])
def test_derivatives_of_smooth_sets_are_those_of_differences(name: str) -> None:
    """Central differences of step 1e-6.

    Rounding 1e-10, truncation 1e-12 of third derivatives, and 5e-6 next to a jump of the second.
    """
    fuzzy_set, x, h = SETS[name], np.linspace(-4.0, 4.0, 999), 1e-6
    np.testing.assert_allclose(
        fuzzy_set.derivative(x), (fuzzy_set(x + h) - fuzzy_set(x - h)) / (2 * h), atol=1e-5
    )
    assert np.isnan(fuzzy_set.derivative(np.nan))


def test_the_height_of_a_two_sided_gaussian_whose_means_cross() -> None:
    """Between the means the product of two Gaussians is one about their precision-weighted mean."""
    crossed = TwoSidedGaussian(mean=(1.0, 0.0), sigma=(0.5, 1.5))
    precisions = np.array([1 / 0.25, 1 / 2.25])
    peak = precisions @ [1.0, 0.0] / precisions.sum()
    assert crossed.maxima == pytest.approx((peak, peak), rel=1e-14)
    assert crossed.height == pytest.approx(float(crossed(peak)), rel=1e-14)
    grid = np.linspace(-3.0, 3.0, 10_001)
    assert crossed(grid).max() <= crossed.height
    alphas = np.array([0.05, 0.3, 0.7, 0.8]) * crossed.height
    for ends in crossed.alpha_cut(alphas):
        np.testing.assert_allclose(crossed(ends), alphas, rtol=1e-13)
