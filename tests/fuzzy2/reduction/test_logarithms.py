"""Reduction by logarithms of weights, beside that by weights, and where these are no floats."""

from __future__ import annotations

import numpy as np
import pytest

import fuzzy2
from fuzzy2.reduction.logarithms import (
    as_floats,
    average_in_logarithms,
    bounds_in_logarithms,
    centroid_in_logarithms,
    relative,
)


def weighted(seed: int, rules: int = 7, rows: int = 40) -> tuple[np.ndarray, np.ndarray]:
    """Return intervals of points, some equal, and weight intervals, some 0."""
    rng = np.random.default_rng(seed)
    points = np.sort(np.round(rng.normal(size=(rules, 2)), 1), axis=-1)
    weights = np.sort(rng.random((rows, rules, 2)) ** 3, axis=-1)
    weights[rng.random((rows, rules)) < 0.2] = 0.0
    weights[rng.random((rows, rules)) < 0.3, 0] = 0.0
    weights[0] = 0.0
    return points, weights


@pytest.mark.parametrize("seed", range(10))
def test_where_weights_are_floats_it_is_the_same(seed: int) -> None:
    """1e-13 of a point: logarithms of weights up to 1e-9 are rounded to 1e-15."""
    points, weights = weighted(seed)
    with np.errstate(divide="ignore"):
        logarithms = np.log(weights)
    found = centroid_in_logarithms(points, logarithms)
    np.testing.assert_allclose(found, fuzzy2.generalized_centroid(points, weights), atol=1e-13)
    assert np.isnan(found[0]).all()
    shifted = centroid_in_logarithms(points, logarithms - 5000.0)
    np.testing.assert_allclose(shifted, found, atol=1e-11)
    many = np.broadcast_to(points, (len(weights), *points.shape))
    np.testing.assert_array_equal(centroid_in_logarithms(many, logarithms), found)
    large = centroid_in_logarithms(1e300 * points, logarithms)
    np.testing.assert_allclose(1e-300 * large, found, atol=1e-13)
    bounds = fuzzy2.wu_mendel_bounds(points, weights)
    middles = [bounds.left_lower + bounds.left_upper, bounds.right_lower + bounds.right_upper]
    np.testing.assert_allclose(
        bounds_in_logarithms(points, logarithms), 0.5 * np.stack(middles, axis=-1), atol=1e-12
    )
    np.testing.assert_allclose(
        fuzzy2.generalized_centroid(points, as_floats(logarithms)), found, atol=1e-13
    )


def test_an_end_that_hangs_on_tiny_weights() -> None:
    """One of two rules may outweigh the other by e^1000 either way, beside a point that says 0.

    That one fires surely in the second row, where the others do not matter.
    """
    points = np.array([[-1.0, -1.0], [2.0, 2.0], [0.0, 0.0]])
    logarithms = np.array(
        [
            [[-5000.0, -2000.0], [-6000.0, -1000.0], [-9000.0, -8000.0]],
            [[-5000.0, -2000.0], [-6000.0, -1000.0], [-1.0, 0.0]],
        ]
    )
    found = centroid_in_logarithms(points, logarithms)
    np.testing.assert_array_equal(found, [[-1.0, 2.0], [0.0, 0.0]])
    floats = as_floats(logarithms)
    assert (floats > 0.0).all()
    np.testing.assert_allclose(fuzzy2.generalized_centroid(points, floats), found, atol=1e-12)
    assert average_in_logarithms(points[:, 0], logarithms[..., 1]).tolist() == [2.0, 0.0]


def test_weights_relative_to_the_greatest() -> None:
    found = relative(np.array([[-3000.0, -3000.0 + np.log(0.5)], [-np.inf, -np.inf]]))
    np.testing.assert_allclose(found, [[1.0, 0.5], [0.0, 0.0]], rtol=1e-12)
    assert np.isnan(average_in_logarithms(np.ones(2), np.full((1, 2), -np.inf)))
