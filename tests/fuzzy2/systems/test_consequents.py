"""What rules conclude: intervals, linear functions and sets."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

import fuzzy2
from fuzzy2.systems import IntervalType2System, Linear
from tests.fuzzy2.systems.by_hand import (
    GRID_RULES,
    uncertain,
)

Array = NDArray[np.float64]


def test_interval_consequents_and_many_scales(X: Array) -> None:
    """Intervals as consequents, against the generalized centroid.

    With outputs from 1e-9 to 1e9 in one rule base.
    """
    rng = np.random.default_rng(5)
    scales = 10.0 ** np.arange(-9, 10, 3)
    z = np.sort(rng.normal(size=(8, scales.size, 2)), axis=-1) * scales[:, np.newaxis]
    system = IntervalType2System(uncertain(), GRID_RULES, z)
    firing = system.firing(X)
    for j, scale in enumerate(scales):
        expected = fuzzy2.generalized_centroid(z[:, j], firing, "scan")
        np.testing.assert_allclose(
            system.type_reduced(X)[:, j],
            expected,
            rtol=0.0,
            atol=1e-12 * scale * np.abs(z[:, j] / scale).max(),
        )


def test_symmetric_consequents_center_of_sets_is_height(X: Array) -> None:
    """For normal, convex, symmetric consequents both take the same points (after eq. 1.78).

    1e-10 is the centroid's quadrature.
    """
    sets = [fuzzy2.Gaussian(mean=m, sigma=0.3) for m in np.linspace(-2.0, 2.0, 8)]
    by_sets, by_height = (
        IntervalType2System(uncertain(), GRID_RULES, sets, type_reduction=name)
        for name in ("center_of_sets", "height")
    )
    np.testing.assert_allclose(by_sets.type_reduced(X), by_height.type_reduced(X), atol=1e-10)


def test_linear_consequents(X: Array) -> None:
    """TSK: with exact linear consequents that agree the output is that function.

    It is that linear function whatever fires; 1e-12.
    """
    slopes = np.array([[0.5, 1.0, -2.0, 0.25]])
    system = IntervalType2System(
        uncertain(), GRID_RULES, Linear(np.broadcast_to(slopes, (8, 1, 4)))
    )
    np.testing.assert_allclose(system(X)[:, 0], 0.5 + X @ [1.0, -2.0, 0.25], atol=1e-12)
    rng = np.random.default_rng(7)
    coefficients, spreads = rng.normal(size=(8, 2, 4)), 0.1 * rng.random((8, 2, 4))
    system = IntervalType2System(uncertain(), GRID_RULES, Linear(coefficients, spreads))
    x = X[0]
    firing = system.firing(x)
    for j in range(2):
        middle = coefficients[:, j] @ [1.0, *x]
        half = spreads[:, j] @ [1.0, *np.abs(x)]
        expected = fuzzy2.generalized_centroid(np.stack([middle - half, middle + half], -1), firing)
        np.testing.assert_allclose(system.type_reduced(x)[j], expected, atol=1e-12)
