"""Figures of merit against sums written out by hand."""

from __future__ import annotations

import numpy as np
import pytest

from psp3.errors import InvalidValue
from psp3.simulation import Result
from psp3.simulation.metrics import (
    integral_of_squared_error,
    largest_tip_error,
    rms_error,
    sum_of_squared_errors,
)
from psp3.trajectories import Motion


def made_up() -> Result:
    """Return a run with an error of (t, 2t, −2t), so that its square is 9 t².

    A tip that is 3 t away.
    """
    t = np.arange(0.0, 1.0 + 1e-9, 0.01)
    zero = np.zeros((t.size, 3))
    error = t[:, np.newaxis] * [1.0, 2.0, -2.0]
    desired = Motion(zero, zero, zero, zero)
    return Result(t, -error, zero, desired, zero, error)


def test_sum_counts_one_sample_per_sampling_period() -> None:
    expected = sum(9.0 * (0.05 * k) ** 2 for k in range(21))
    assert sum_of_squared_errors(made_up()) == pytest.approx(expected, rel=1e-12)
    assert sum_of_squared_errors(made_up(), 0.5) == pytest.approx(9.0 * (0.25 + 1.0), rel=1e-12)


def test_the_first_sample_counts() -> None:
    """An error of (1, 0, 0) at the start and none after."""
    t = np.arange(0.0, 0.2 + 1e-9, 0.01)
    zero, positions = np.zeros((t.size, 3)), np.zeros((t.size, 3))
    positions[0, 0] = -1.0
    run = Result(t, positions, zero, Motion(zero, zero, zero, zero), zero, zero)
    assert sum_of_squared_errors(run) == 1.0


def test_integral_is_that_of_nine_t_squared() -> None:
    """3 exactly; the trapezoidal rule adds 9 h²/6 = 1.5e-4."""
    assert integral_of_squared_error(made_up()) == pytest.approx(3.0 + 1.5e-4, rel=1e-9)


def test_rms_and_largest_tip_error() -> None:
    t = made_up().t
    assert rms_error(made_up()) == pytest.approx(3.0 * np.sqrt(np.mean(t**2)), rel=1e-12)
    assert largest_tip_error(made_up()) == pytest.approx(3.0, rel=1e-12)


@pytest.mark.parametrize("period", [0.015, 0.0, -0.05, 0.001])
def test_a_sampling_period_must_be_a_multiple_of_the_control_period(period: float) -> None:
    with pytest.raises(InvalidValue, match="multiple"):
        sum_of_squared_errors(made_up(), period)
