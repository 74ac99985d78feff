"""Fourier series: derivatives, and the series through noisy measurements of a periodic motion."""

from __future__ import annotations

import numpy as np
import pytest

import psp3
from psp3.errors import InvalidArray, InvalidValue, PoorExcitation
from psp3.trajectories.fourier_series import FourierSeries, fit_fourier_series, fourier_terms
from tests.helpers import Array, derivative

ROBOT = psp3.load("five_bar")


def series(seed: int = 0, harmonics: int = 3, period: float = 2.5) -> FourierSeries:
    rng = np.random.default_rng(seed)
    sines, cosines = 0.05 * rng.normal(size=(2, harmonics, 2))
    return FourierSeries(ROBOT.reference, sines, cosines, period, ROBOT)


def test_speeds_and_accelerations_are_derivatives() -> None:
    """Against eighth-order differences; 1e-9 is their rounding."""
    motion = series()
    t = np.linspace(-1.0, 4.0, 17)
    found = motion(t)
    np.testing.assert_allclose(
        found.speeds, derivative(lambda h: motion(t + h).positions, 1e-2), atol=1e-9
    )
    np.testing.assert_allclose(
        found.accelerations, derivative(lambda h: motion(t + h).speeds, 1e-2), atol=1e-9
    )


def test_it_repeats_after_a_period_and_is_a_sum_of_sines() -> None:
    """Written out by hand; 1e-14 is a few ulps."""
    motion = series()
    t = np.linspace(0.0, 2.5, 11)
    np.testing.assert_allclose(motion(t + 2.5).positions, motion(t).positions, atol=1e-14)
    assert motion.harmonics == 3
    omega = 2.0 * np.pi / 2.5
    by_hand = sum(
        motion.sines[k, 1] * np.sin((k + 1) * omega * t)
        + motion.cosines[k, 1] * np.cos((k + 1) * omega * t)
        for k in range(3)
    )
    np.testing.assert_allclose(motion(t).positions[:, 1], motion.center[1] + by_hand, atol=1e-14)
    assert motion(0.3).positions.shape == (2,)


def test_a_fit_finds_a_series_again() -> None:
    """Without noise to rounding, at uneven times too."""
    motion = series()
    t = np.sort(np.random.default_rng(1).uniform(0.0, 5.0, 40))
    fitted = fit_fourier_series(t, motion(t).positions, 2.5, 3, ROBOT)
    np.testing.assert_allclose(fitted.motion.sines, motion.sines, atol=1e-13)
    np.testing.assert_allclose(fitted.motion.cosines, motion.cosines, atol=1e-13)
    np.testing.assert_allclose(fitted.motion.center, motion.center, atol=1e-13)
    assert fitted.noise.max() < 1e-13


@pytest.mark.slow
def test_noise_and_covariance_of_a_fit_are_those_of_many_fits() -> None:
    """1000 seeds: a standard deviation is uncertain by 1/sqrt(2000).

    That is 2.2 %, so 10 % is more than four of these.
    """
    motion, size = series(), 1e-3
    t = np.linspace(0.0, 4.0, 30)
    coefficients, noises = [], []
    for seed in range(1000):
        rng = np.random.default_rng(seed)
        fitted = fit_fourier_series(
            t, motion(t).positions + size * rng.normal(size=(30, 2)), 2.5, 3, ROBOT
        )
        coefficients.append(
            np.concatenate(
                [fitted.motion.center[:1], fitted.motion.sines[:, 0], fitted.motion.cosines[:, 0]]
            )
        )
        noises.append(fitted.noise[0])
    expected = size * np.sqrt(np.diag(fitted.covariance))
    np.testing.assert_allclose(np.std(coefficients, axis=0), expected, rtol=0.1)
    assert np.sqrt(np.mean(np.square(noises))) == pytest.approx(size, rel=0.03)
    truth = np.concatenate([motion.center[:1], motion.sines[:, 0], motion.cosines[:, 0]])
    assert (np.abs(np.mean(coefficients, axis=0) - truth) < 4.0 * expected / np.sqrt(1000)).all()


def test_a_fit_differentiates_better_than_differences() -> None:
    """The reason to have it: noise of 0.1 mrad at 100 samples a second.

    Central differences of it are some thousand times worse.
    """
    motion, rng = series(), np.random.default_rng(2)
    t = np.arange(500) / 100.0
    noisy = motion(t).positions + 1e-4 * rng.normal(size=(500, 2))
    exact = motion(t).accelerations
    fitted = fit_fourier_series(t, noisy, 2.5, 3, ROBOT).motion(t).accelerations
    differences = (noisy[2:] - 2.0 * noisy[1:-1] + noisy[:-2]) * 100.0**2
    assert np.abs(fitted - exact).max() < 2e-3
    assert np.sqrt(np.mean((differences - exact[1:-1]) ** 2)) > 1.0


def test_terms_are_orthogonal_over_a_period() -> None:
    """The discrete Fourier transform; to rounding."""
    terms, _, _ = fourier_terms(np.arange(20) / 20.0, 1.0, 4)
    np.testing.assert_allclose(terms.T @ terms, np.diag([20.0, *[10.0] * 8]), atol=1e-12)


@pytest.mark.parametrize(
    ("change", "error"),
    [
        ({"center": np.zeros(3)}, InvalidArray),
        ({"sines": np.full((3, 2), np.nan)}, InvalidArray),
        ({"sines": np.zeros((2, 2))}, InvalidArray),
        ({"sines": np.zeros((0, 2)), "cosines": np.zeros((0, 2))}, InvalidArray),
        ({"cosines": np.zeros(2), "sines": np.zeros(2)}, InvalidArray),
        ({"period": 0.0}, InvalidValue),
        ({"period": np.inf}, InvalidValue),
    ],
)
def test_bad_series_are_refused(change: dict[str, object], error: type[Exception]) -> None:
    arguments: dict[str, object] = {
        "center": np.zeros(2),
        "sines": np.zeros((3, 2)),
        "cosines": np.zeros((3, 2)),
        "period": 1.0,
    }
    with pytest.raises(error):
        FourierSeries(**(arguments | change), robot=ROBOT)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("change", "error"),
    [
        ({"t": np.zeros(20)}, PoorExcitation),
        ({"t": np.arange(7.0), "positions": np.zeros((7, 2))}, PoorExcitation),
        ({"t": np.full(20, np.nan)}, InvalidArray),
        ({"t": np.arange(19.0)}, InvalidArray),
        ({"positions": np.zeros((20, 3))}, InvalidArray),
        ({"positions": np.zeros(2)}, InvalidArray),
        ({"period": -1.0}, InvalidValue),
        ({"harmonics": 0}, InvalidValue),
        ({"harmonics": 2.5}, InvalidValue),
    ],
)
def test_bad_measurements_are_refused(change: dict[str, object], error: type[Exception]) -> None:
    t: Array = np.arange(20) * 0.13
    arguments: dict[str, object] = {
        "t": t,
        "positions": np.zeros((20, 2)),
        "period": 2.6,
        "harmonics": 3,
    }
    with pytest.raises(error):
        fit_fourier_series(**(arguments | change), robot=ROBOT)  # type: ignore[arg-type]
