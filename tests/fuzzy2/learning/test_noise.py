"""Noise and mean variation."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fuzzy2.errors import InvalidValue
from fuzzy2.learning.noise import (
    GREATEST_MEAN_VARIATION,
    add_noise,
    mean_variation_from_snr,
    snr_from_mean_variation,
)


def test_no_noise_asks_for_no_mean_variation() -> None:
    """Infinite ratios make the type-1 system, exactly."""
    assert mean_variation_from_snr(math.inf) == 0.0
    assert snr_from_mean_variation(0.0) == math.inf
    assert mean_variation_from_snr(-math.inf) == GREATEST_MEAN_VARIATION
    assert snr_from_mean_variation(GREATEST_MEAN_VARIATION) == -math.inf
    assert mean_variation_from_snr(1e6) == 0.0


def test_noise_levels_of_table_6_3_get_the_documented_variations() -> None:
    """By hand: 0.4/(1 + 10**-0.5), 0.4/(1 + 10**-0.75), 0.4/(1 + 10**-1); 1e-15 is rounding."""
    by_hand = [0.4 / (1.0 + 0.31622776601683794), 0.4 / (1.0 + 0.1778279410038923), 0.4 / 1.1]
    np.testing.assert_allclose(mean_variation_from_snr([20.0, 15.0, 10.0]), by_hand, rtol=1e-15)
    assert all(0.3 <= variation <= 0.4 for variation in by_hand)


def test_weak_noise_asks_in_proportion_to_its_amplitude() -> None:
    """20 dB more are a tenth of the amplitude.

    At 100 dB the law is off by the ratio to the amplitude at 30 dB, 10**-3.5.
    """
    ratio = mean_variation_from_snr(100.0) / mean_variation_from_snr(120.0)
    assert ratio == pytest.approx(10.0, rel=4e-4)


@given(st.floats(-100.0, 200.0))
def test_the_inverse_undoes_the_rule(snr_db: float) -> None:
    """Near 0.4 the inverse loses what 0.4/ν - 1 cancels.

    At worst that is eps/10**(-130/20) of 20/ln 10 dB, 6e-9 dB.
    """
    assert snr_from_mean_variation(mean_variation_from_snr(snr_db)) == pytest.approx(
        snr_db, abs=1e-8
    )


def test_the_rule_falls_with_the_ratio_and_keeps_shapes() -> None:
    ratios = np.linspace(-40.0, 120.0, 60).reshape(3, 4, 5)
    variations = mean_variation_from_snr(ratios)
    assert variations.shape == ratios.shape
    assert (np.diff(variations.ravel()) < 0.0).all()


@pytest.mark.parametrize("variation", [-0.1, 0.41, math.nan])
def test_variations_that_no_ratio_gives_are_refused(variation: float) -> None:
    with pytest.raises(InvalidValue, match="mean_variation"):
        snr_from_mean_variation(variation)


def test_a_ratio_that_is_no_number_is_refused() -> None:
    with pytest.raises(InvalidValue, match="snr_db"):
        mean_variation_from_snr(math.nan)


@pytest.mark.parametrize("snr_db", [0.0, 10.0, 20.0])
def test_noise_has_the_power_asked_for_column_by_column(snr_db: float) -> None:
    """Sample power of 200 000 normal numbers has a relative spread of sqrt(2/N) = 0.003.

    Five of them are 0.016.
    """
    time = np.linspace(0.0, 1.0, 200_000)
    # A large mean: with the variance for power, the noise of the second column would be 30 times
    # too weak.
    signal = np.stack([np.sin(20.0 * time), 9.0 + 0.3 * np.sin(20.0 * time)], axis=-1)
    noise = add_noise(signal, snr_db, np.random.default_rng(1)) - signal
    measured = 10.0 * np.log10((signal**2).mean(axis=0) / (noise**2).mean(axis=0))
    np.testing.assert_allclose(measured, snr_db, atol=10.0 * math.log10(1.016))
    # White: neighbors and columns are uncorrelated, to five standard deviations 1/sqrt(N).
    assert abs(np.corrcoef(noise[1:, 0], noise[:-1, 0])[0, 1]) < 5.0 / math.sqrt(time.size)
    assert abs(np.corrcoef(noise.T)[0, 1]) < 5.0 / math.sqrt(time.size)


def test_infinite_ratio_adds_nothing_and_ratios_share_their_random_numbers() -> None:
    signal = np.random.default_rng(0).normal(size=(50, 3))
    quiet = add_noise(signal, math.inf, np.random.default_rng(7))
    np.testing.assert_array_equal(quiet, signal)
    assert quiet is not signal
    rng = np.random.default_rng(7)
    add_noise(signal, math.inf, rng)
    after_infinite = rng.standard_normal()
    rng = np.random.default_rng(7)
    loud = add_noise(signal, 20.0, rng)
    assert rng.standard_normal() == after_infinite
    louder = add_noise(signal, 0.0, np.random.default_rng(7))
    # The same numbers, ten times the amplitude; rounding of the sums is 1e-15 of order 1.
    np.testing.assert_allclose(louder - signal, 10.0 * (loud - signal), rtol=1e-11, atol=1e-14)


def test_arguments_that_cannot_be_meant_are_refused() -> None:
    rng = np.random.default_rng(0)
    with pytest.raises(InvalidValue, match="signal"):
        add_noise([1.0, math.nan], 10.0, rng)
    with pytest.raises(InvalidValue, match="signal"):
        add_noise([], 10.0, rng)
    with pytest.raises(InvalidValue, match="snr_db"):
        add_noise([1.0], -math.inf, rng)
    with pytest.raises(InvalidValue, match="rng"):
        add_noise([1.0], 10.0, 0)  # type: ignore[arg-type] # that is the point


@pytest.mark.parametrize("scale", [1e-170, 1e170])
def test_noise_goes_with_a_signal_of_any_scale(scale: float) -> None:
    """To 1e-14 of the signal, the rounding of the scaled signal itself."""
    signal = np.sin(np.linspace(0.0, 20.0, 1000))
    noisy = add_noise(signal, 10.0, np.random.default_rng(3))
    scaled = add_noise(scale * signal, 10.0, np.random.default_rng(3))
    np.testing.assert_allclose(scaled / scale, noisy, rtol=0.0, atol=1e-14)


def test_a_signal_at_the_end_of_the_floats_takes_noise_that_fits() -> None:
    """At 200 dB the noise is 1e-10 of the signal, and at 0 dB it would be no float."""
    signal = np.array([1.7e308, -1.7e308, 1.0e308, 0.0] * 50)
    noise = add_noise(signal, 200.0, np.random.default_rng(3)) / 1.7e308 - signal / 1.7e308
    assert 0.5e-10 < noise.std() < 1.5e-10
    with pytest.raises(InvalidValue, match="so small that it is finite with the noise"):
        add_noise(signal, 0.0, np.random.default_rng(3))
