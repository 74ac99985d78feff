"""How independent residuals are: against dense matrices, and against many draws."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import norm

from psp3.identification.residuals import deviation_from_independence, lag_one_correlation
from tests.helpers import Array

COUNT = 40


def autoregressive(correlation: float, count: int, rng: np.random.Generator) -> Array:
    """Return noise of standard deviation 1 with this correlation from sample to sample."""
    noise = rng.standard_normal(count)
    for k in range(1, count):
        noise[k] = correlation * noise[k - 1] + np.sqrt(1.0 - correlation**2) * noise[k]
    return noise


@pytest.fixture(scope="module")
def regressor() -> Array:
    """Columns that vary slowly, as those of a motion do."""
    return np.cumsum(np.random.default_rng(0).standard_normal((COUNT, 3)), axis=0)


@pytest.fixture(scope="module")
def shared() -> Array:
    """Slow errors which together are as large as the noise of a sample."""
    phase = 2.0 * np.pi * np.arange(COUNT)[:, np.newaxis] / COUNT * np.arange(1, 4)
    return 0.5 * np.concatenate([np.sin(phase), np.cos(phase)], axis=1)


def test_lag_one_correlation_is_that_of_numpy() -> None:
    """10 000 samples about zero: what the ends and the mean do is below 1e-3."""
    noise = autoregressive(0.8, 10_000, np.random.default_rng(1))
    expected = np.corrcoef(noise[1:], noise[:-1])[0, 1]
    np.testing.assert_allclose(
        lag_one_correlation(np.stack([noise, -3.0 * noise], axis=1)), expected, atol=1e-3
    )
    assert lag_one_correlation(np.zeros((5, 1)))[0] == 0.0


def test_moments_are_those_of_dense_matrices(regressor: Array, shared: Array) -> None:
    """By the formulas of the docstring with all matrices written out, to rounding."""
    residuals = np.random.default_rng(2).standard_normal(COUNT) + shared @ np.ones(6)
    projector = np.eye(COUNT) - regressor @ np.linalg.pinv(regressor)
    beside = 0.5 * (np.eye(COUNT, k=1) + np.eye(COUNT, k=-1))
    remaining = projector @ residuals
    of_shared = projector @ shared @ shared.T @ projector
    both = np.concatenate([regressor, shared], axis=1)
    noise = np.linalg.lstsq(both, residuals, rcond=None)[1][0] / (COUNT - 9)
    spread = noise * projector + of_shared
    expected = np.trace(beside @ spread) / np.trace(spread)
    centered = (beside - expected * np.eye(COUNT)) @ spread
    variance = 2.0 * np.trace(centered @ centered)
    variance /= np.trace(spread) ** 2 + 2.0 * np.trace(spread @ spread)
    correlation = (remaining @ beside @ remaining) / (remaining @ remaining)
    assert deviation_from_independence(residuals, regressor, shared) == pytest.approx(
        (correlation - expected) / np.sqrt(variance), rel=1e-10
    )


@pytest.mark.parametrize("size", [0.0, 1.0, 5.0])
def test_independent_noise_deviates_as_often_as_a_normal_law_says(
    regressor: Array, shared: Array, size: float
) -> None:
    """4000 draws, with shared errors that are nothing, as large as the noise, and most of it.

    Without them the moments are exact: the mean is uncertain by 0.016, the standard deviation by
    0.011 and a share of 1 % by 0.16 %. With them moments are those of first order in few errors,
    which must err to the side of silence.
    """
    rng = np.random.default_rng(3)
    deviations = np.array(
        [
            deviation_from_independence(
                rng.standard_normal(COUNT)
                + size * shared @ rng.standard_normal(6)
                + regressor @ rng.standard_normal(3),
                regressor,
                size * shared,
            )
            for _ in range(4000)
        ]
    )
    beyond = np.mean(deviations > norm.ppf(0.99))
    if size == 0.0:
        assert abs(deviations.mean()) < 0.065
        assert abs(deviations.std() - 1.0) < 0.045
        assert 0.005 < beyond < 0.016
    else:
        assert deviations.mean() < 0.065
        assert beyond < 0.016


def test_correlated_noise_is_seen(regressor: Array, shared: Array) -> None:
    """Correlation 0.8 in 95 % of 200 sets of 40 samples, of one joint.

    And with negative correlation never: of a slow motion it makes no interval too narrow, see the
    tests of least squares.
    """
    rng = np.random.default_rng(4)
    for correlation, least, most in ((0.8, 0.95, 1.0), (-0.8, 0.0, 0.0)):
        deviations = [
            deviation_from_independence(
                autoregressive(correlation, COUNT, rng), regressor, 0.01 * shared
            )
            for _ in range(200)
        ]
        assert least <= np.mean(np.array(deviations) > norm.ppf(0.99)) <= most


def test_correlation_that_shared_errors_explain_is_no_flaw(regressor: Array, shared: Array) -> None:
    """The same residuals deviate if their slow part is not known, and not if it is."""
    rng = np.random.default_rng(5)
    residuals = 0.1 * rng.standard_normal(COUNT) + shared @ rng.standard_normal(6)
    assert deviation_from_independence(residuals, regressor, 0.0 * shared) > 3.0
    assert abs(deviation_from_independence(residuals, regressor, shared)) < 2.0


def test_shared_errors_of_as_many_directions_as_samples(regressor: Array) -> None:
    """Then the noise is what they leave on average; errors of a tenth of it change little."""
    rng = np.random.default_rng(7)
    everywhere = 0.1 * rng.standard_normal((COUNT, COUNT)) / np.sqrt(COUNT)
    for correlation, seen in ((0.0, 0.01), (0.8, 0.97)):
        deviations = [
            deviation_from_independence(
                autoregressive(correlation, COUNT, rng), regressor, everywhere
            )
            for _ in range(200)
        ]
        # Three standard deviations of a share of 200.
        share = np.mean(np.array(deviations) > norm.ppf(0.99))
        assert abs(share - seen) <= 3.0 * np.sqrt(seen * (1.0 - seen) / 200)


def test_too_few_samples_tell_nothing() -> None:
    """Four degrees of freedom are too few, five are not."""
    rng = np.random.default_rng(6)
    for count, told in ((7, False), (8, True)):
        columns = rng.standard_normal((count, 3))
        slow = np.linspace(1.0, 2.0, count)
        assert (deviation_from_independence(slow, columns, np.zeros((count, 1))) != 0.0) == told
    # A column of nothing, and one that is there twice, take nothing.
    columns = np.stack([np.zeros(8), *[np.linspace(0.0, 1.0, 8)] * 2], axis=1)
    assert deviation_from_independence(
        rng.standard_normal(8), columns, np.zeros((8, 1))
    ) != pytest.approx(0.0)
