"""Theorem 1.6 and its corollaries (1.85 to 1.114) by brute force: corners, grids, embedded sets.

Affine functions, and averages with positive weights, are extreme at corners of boxes; so where
intervals are meant, all corners are tried. Where Gaussians are meant, the supremum of the extension
principle is taken over a grid.
"""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from fuzzy2.numbers import GaussianNumber, IntervalNumber
from fuzzy2.reduction.approximate import approximate_centroid, approximate_generalized_centroid
from fuzzy2.reduction.interval import generalized_centroid
from fuzzy2.sets.interval_type2 import GaussianUncertainMean
from tests.helpers import Array


def box(seed: int, n: int, width: float) -> tuple[Array, Array, Array, Array]:
    """Return points c with half-widths s, and weights h with half-widths that are shares of h."""
    rng = np.random.default_rng(seed)
    h = rng.uniform(0.2, 1.0, n)
    return rng.normal(size=n), rng.uniform(0.0, 0.4, n), h, width * rng.uniform(0.3, 1.0, n) * h


def corners(s: Array, delta: Array) -> tuple[Array, Array]:
    """Return slacks of points and of weights (4^n, n) at all corners of their intervals."""
    signs = np.array(list(itertools.product((-1.0, 1.0), repeat=2 * len(s))))
    return signs[:, : len(s)] * s, signs[:, len(s) :] * delta


def affine(c: Array, h: Array, gamma: Array, delta: Array) -> Array:
    """Eq. 1.98, with the center of eq. 1.87 as corrected."""
    total = h.sum()
    xi = (h * c).sum() / total
    return np.asarray((gamma * h / total + delta * (c - xi) / total).sum(axis=-1) + xi)


def averages(c: Array, h: Array, gamma: Array, delta: Array) -> Array:
    """Eq. 1.89: what is approximated."""
    return np.asarray(((c + gamma) * (h + delta)).sum(axis=-1) / (h + delta).sum(axis=-1))


def ends(values: Array) -> Array:
    return np.array([values.min(), values.max()])


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("n", [1, 2, 3, 5])
def test_intervals_have_the_ends_of_all_corners(n: int, seed: int) -> None:
    """Eq. 1.87 and 1.103: center and spread; 1e-13 is rounding."""
    c, s, h, delta = box(seed, n, 0.3)
    found = approximate_generalized_centroid(IntervalNumber(c, s), IntervalNumber(h, delta))
    expected = ends(affine(c, h, *corners(s, delta)))
    np.testing.assert_allclose(found.value.interval(), expected, atol=1e-13)
    assert float(found.value.center) == pytest.approx(expected.mean(), abs=1e-13)


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("width", [0.02, 0.1, 0.3])
def test_what_is_left_out_is_bounded_by_the_validity(width: float, seed: int) -> None:
    """Eq. 1.88 and 1.104: ends of the averages over all corners, against the approximation.

    The average is the center and (gamma h + delta (c - xi) + delta gamma)/(sum h) over 1 + r. So it
    differs from eq. 1.98 by no more than max s V for the product of slacks, and by V/(1 - V) of all
    that is above 1 + r; with V the validity, |r| ≤ V.
    """
    c, s, h, delta = box(seed, 4, width)
    found = approximate_generalized_centroid(IntervalNumber(c, s), IntervalNumber(h, delta))
    validity = float(found.validity)
    assert validity == pytest.approx(delta.sum() / h.sum(), rel=1e-14)
    exact = ends(averages(c, h, *corners(s, delta)))
    intervals = IntervalNumber(c, s).interval(), IntervalNumber(h, delta).interval()
    np.testing.assert_allclose(generalized_centroid(*intervals), exact, atol=1e-13)
    left_out = np.abs(found.value.interval() - exact)
    above = float(found.value.spread) + s.max() * validity
    assert (left_out <= s.max() * validity + validity / (1.0 - validity) * above).all()
    assert (left_out > 0.0).all()


@pytest.mark.parametrize("seed", range(5))
def test_the_bounds_hold_at_every_corner_and_the_printed_ones_do_not(seed: int) -> None:
    """Eq. 1.95 to 1.97 with the sum of half-widths; |sum of delta|, as printed, bounds nothing."""
    c, s, h, delta = box(seed, 4, 0.2)
    gamma, away = corners(s, delta)
    validity = float(
        approximate_generalized_centroid(IntervalNumber(c, s), IntervalNumber(h, delta)).validity
    )
    total, r = h.sum(), away.sum(axis=-1) / h.sum()
    product = np.abs((away * gamma).sum(axis=-1)) / total
    slack = np.abs((h * gamma).sum(axis=-1)) / total
    both = np.abs(-r * (h * gamma).sum(axis=-1) / total + (away * gamma).sum(axis=-1) / total)
    assert product.max() == pytest.approx((delta * s).sum() / total, rel=1e-13)
    assert (product <= s.max() * validity * (1.0 + 1e-14)).all()
    assert (slack <= s.max()).all()
    assert (both <= 2.0 * s.max() * validity).all()
    assert (product > s.max() * np.abs(r)).any()
    assert (both > 2.0 * s.max() * np.abs(r)).any()


@pytest.mark.parametrize("t_norm", ["product", "min"])
def test_affine_combination_of_gaussians_is_the_supremum_over_a_grid(t_norm: str) -> None:
    """Eq. 1.85 and 1.108: two points with two weights, over three slacks; the fourth follows.

    Steps are 0.1 standard deviations. Under the product the best grid point is within half a step
    in each of three directions, and the exponent is quadratic there with a curvature of less than
    20 in these units, so 20 · 3 · 0.05² / 2 = 0.075 of the grade is more than can be lost. Under
    the minimum it is a crossing: half a step of the largest slack, at two standard deviations, is
    0.05 · 2 of the grade.
    """
    m, sigma = np.array([1.0, 2.0]), np.array([0.2, 0.3])
    h, delta = np.array([0.6, 0.8]), np.array([0.06, 0.05])
    found = approximate_generalized_centroid(
        GaussianNumber(m, sigma, t_norm), GaussianNumber(h, delta, t_norm)
    ).value
    total = h.sum()
    xi = (h * m).sum() / total
    slopes = np.concatenate([sigma * h, delta * (m - xi)]) / total
    steps = np.linspace(-3.0, 3.0, 61)
    u = np.stack(np.meshgrid(steps, steps, steps, indexing="ij"))
    combine = np.add if t_norm == "product" else np.maximum
    for deviation in (-1.5, -0.5, 0.0, 1.0, 2.0):
        y = float(found.mean) + deviation * float(found.sigma)
        # The steepest of the slacks follows, so that the grid is finest in effect.
        last = (y - xi - slopes[0] * u[0] - slopes[2] * u[1] - slopes[3] * u[2]) / slopes[1]
        squares = combine(combine(combine(u[0] ** 2, u[1] ** 2), u[2] ** 2), last**2)
        supremum = float(np.exp(-0.5 * squares.min()))
        grade = float(found.membership(y))
        assert grade >= supremum - 1e-12
        assert grade == pytest.approx(supremum, rel=0.075 if t_norm == "product" else 0.1)


def test_centroid_of_an_interval_set_is_that_of_all_embedded_sets() -> None:
    """Eq. 1.105 and 1.106: 2^13 embedded sets of 13 points, for narrow and for wide footprints.

    Embedded sets take one end of the footprint at every point. The approximation is off by the
    bound that follows from eq. 1.91, v²/(1 - v) of the range of the points.
    """
    x = np.linspace(0.0, 10.0, 13)
    choices = np.array(list(itertools.product((0, 1), repeat=13)))
    for half_width in (0.02, 0.3, 1.0):
        footprint = GaussianUncertainMean(mean=(5.2 - half_width, 5.2 + half_width), sigma=1.4)
        ends_at = footprint.footprint(x)
        embedded = np.take_along_axis(ends_at[np.newaxis], choices[..., np.newaxis], axis=2)[..., 0]
        expected = ends((embedded * x).sum(axis=1) / embedded.sum(axis=1))
        np.testing.assert_allclose(generalized_centroid(x, ends_at), expected, atol=1e-13)
        weights = IntervalNumber(ends_at.mean(axis=1), 0.5 * np.diff(ends_at)[:, 0])
        found = approximate_centroid(x, weights)
        v = float(found.validity)
        assert v == pytest.approx(np.diff(ends_at).sum() / ends_at.sum(), rel=1e-13)
        if v < 1.0:
            bound = v**2 / (1.0 - v) * np.ptp(x)
            assert (np.abs(found.value.interval() - expected) <= bound + 1e-13).all()
        # To the first order it is the extreme of an affine function of the memberships.
        xi = (weights.center * x).sum() / weights.center.sum()
        first = xi + ((embedded - weights.center) * (x - xi)).sum(axis=1) / weights.center.sum()
        np.testing.assert_allclose(found.value.interval(), ends(first), atol=1e-12)


def test_centroid_of_a_gaussian_type_2_set_level_by_level() -> None:
    """Eq. 1.112 to 1.114: under the minimum a cut is that of the cuts of the memberships.

    All corners of these, at three levels, and the exact averages within the bound of v²/(1 - v) of
    the range of the points, with v the half-widths of the cut over the sum of the means.
    """
    x = np.array([0.0, 0.7, 1.5, 2.0, 3.1, 4.0])
    m, sigma = (
        np.array([0.1, 0.5, 0.9, 1.0, 0.6, 0.2]),
        np.array([5.0, 8.0, 3.0, 2.0, 9.0, 4.0]) / 400,
    )
    found = approximate_centroid(x, GaussianNumber(m, sigma))
    assert float(found.validity) == pytest.approx(2.0 * sigma.sum() / m.sum(), rel=1e-14)
    signs = np.array(list(itertools.product((-1.0, 1.0), repeat=6)))
    for deviations in (0.5, 1.0, 2.0):
        away = deviations * sigma * signs
        alpha = float(np.exp(-0.5 * deviations**2))
        cut = found.value.interval(alpha)
        np.testing.assert_allclose(cut, ends(affine(x, m, np.zeros(6), away)), atol=1e-13)
        exact = ends(averages(x, m, np.zeros(6), away))
        v = deviations * sigma.sum() / m.sum()
        assert (np.abs(cut - exact) <= v**2 / (1.0 - v) * np.ptp(x)).all()
        np.testing.assert_array_less(0.0, np.abs(cut - exact))
