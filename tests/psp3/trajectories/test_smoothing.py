"""Splines through measured positions: against polynomials, sines and what noise must do."""

from __future__ import annotations

import numpy as np

from psp3.trajectories.smoothing import LEAST_MEASUREMENTS, smoothed_motion


def test_a_polynomial_of_the_splines_degree_comes_back_with_its_derivatives() -> None:
    """Times far from 0 and uneven; 1e-8 of numbers near 30 is rounding, differentiated twice."""
    t = 50.0 + np.sort(np.random.default_rng(0).uniform(0.0, 2.0, LEAST_MEASUREMENTS))
    x = t - 51.0
    positions = np.stack([x**5 - x, 2.0 * x**2 + 1.0], axis=-1)
    value, rate, curvature = smoothed_motion(t, positions)(t)
    np.testing.assert_allclose(value, positions, atol=1e-10)
    np.testing.assert_allclose(rate, np.stack([5.0 * x**4 - 1.0, 4.0 * x], axis=-1), atol=1e-8)
    np.testing.assert_allclose(
        curvature, np.stack([20.0 * x**3, 4.0 + 0.0 * x], axis=-1), atol=1e-7
    )


def test_each_coordinate_has_as_many_pieces_as_its_own_noise_allows() -> None:
    """A noisy line beside an exact sine: neither is smoothed as the other.

    A line takes six coefficients of 400 measurements, which leave the standard deviation of the
    noise times the root of 6 / 400, or little more.
    """
    t = np.linspace(0.0, 3.0, 400)
    noise = 1e-3 * np.random.default_rng(1).normal(size=t.size)
    value, _, curvature = smoothed_motion(t, np.stack([np.sin(9.0 * t), t + noise], axis=-1))(t)
    np.testing.assert_allclose(curvature[:, 0], -81.0 * np.sin(9.0 * t), atol=1e-5 * 81.0)
    assert np.sqrt(((value[:, 1] - t) ** 2).mean()) < 2.0 * 1e-3 * np.sqrt(6 / 400)
