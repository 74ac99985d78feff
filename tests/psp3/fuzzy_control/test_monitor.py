"""The monitor, against a closed form, loops over samples, and what its quantile promises."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from psp3.errors import InvalidArray, InvalidValue, NoThreshold
from psp3.fuzzy_control.monitor import Monitor, torque_width

PERIOD = 0.002


def times(count: int) -> np.ndarray:
    return PERIOD * np.arange(count)


def test_width_of_a_torque_is_the_sum_over_the_screws() -> None:
    interval = np.array(
        [[[1.0, 2.0], [-1.0, 3.0], [5.0, 5.0]], [[0.0, 0.5], [0.0, 0.0], [0.0, 0.25]]]
    )
    np.testing.assert_array_equal(torque_width(interval), [5.0, 0.75])
    assert torque_width(interval[0]) == 5.0


def test_the_filter_answers_a_step_as_the_closed_form_does() -> None:
    """For a signal held over each period the recursion is exact, whatever the period.

    1 - exp(-t/T), to rounding.
    """
    signal = np.ones(400)
    signal[0] = 0.0
    t = np.cumsum(np.random.default_rng(0).uniform(0.001, 0.02, 400))
    found = Monitor(time_constant=0.1).filtered(t, signal)
    np.testing.assert_allclose(found, 1.0 - np.exp(-(t - t[0]) / 0.1), atol=1e-13)


@settings(max_examples=50, deadline=None)
@given(
    signal=st.lists(st.floats(-2.0, 2.0), min_size=1, max_size=60),
    hysteresis=st.floats(0.0, 0.9),
    threshold=st.floats(-1.0, 1.0),
    time_constant=st.floats(1e-4, 0.05),
)
def test_alarms_are_those_of_a_loop_online_and_afterwards(
    signal: list[float], hysteresis: float, threshold: float, time_constant: float
) -> None:
    monitor = Monitor(1.0, hysteresis, time_constant).learn([([0.0], [threshold])])
    assert monitor.threshold_ == threshold
    level, alarm, expected = signal[0], False, []
    for k, value in enumerate(signal):
        if k > 0:
            level += (1.0 - math.exp(-PERIOD / time_constant)) * (value - level)
        if (
            abs(level - threshold) < 1e-12
            or abs(level - threshold + hysteresis * abs(threshold)) < 1e-12
        ):
            return  # rounding would decide
        alarm = level > threshold - (hysteresis * abs(threshold) if alarm else 0.0)
        expected.append(alarm)
    assert monitor.watch(times(len(signal)), signal).tolist() == expected
    assert [monitor.update(PERIOD * k, value) for k, value in enumerate(signal)] == expected
    monitor.reset()
    assert [monitor.update(PERIOD * k, value) for k, value in enumerate(signal)] == expected


@pytest.mark.parametrize(
    ("threshold", "hysteresis", "signal", "expected"),
    [
        # Without hysteresis the alarm is off at the threshold itself, before and after.
        (1.0, 0.0, [1.0, 2.0, 1.0, 1.0], [False, True, False, False]),
        # With it, off at the lower threshold itself, and on between the two.
        (1.0, 0.25, [0.9, 2.0, 0.9, 0.75, 0.9], [False, True, True, False, False]),
        # The lower threshold of a negative one is below it, too.
        (-1.0, 0.25, [-1.1, 0.0, -1.1, -1.25, -1.1], [False, True, True, False, False]),
    ],
)
def test_alarms_at_the_thresholds_themselves(
    threshold: float, hysteresis: float, signal: list[float], expected: list[bool]
) -> None:
    """A time constant so short that the filtered signal is the signal to the last digit."""
    monitor = Monitor(1.0, hysteresis, 1e-6).learn([([0.0], [threshold])])
    assert monitor.watch(np.arange(len(signal)), signal).tolist() == expected
    assert [monitor.update(k, value) for k, value in enumerate(signal)] == expected


def test_an_alarm_does_not_flutter() -> None:
    """A signal that swings by 4 % about the threshold raises one alarm.

    Without hysteresis it raises one in every swing.
    """
    t = times(2000)
    signal = 1.0 + 0.04 * np.sin(40.0 * t)
    alarms = {}
    for hysteresis in (0.0, 0.05):
        alarm = Monitor(1.0, hysteresis, 1e-4).learn([([0.0], [1.0])]).watch(t, signal)
        alarms[hysteresis] = int((alarm[1:] & ~alarm[:-1]).sum())
    assert alarms[0.05] == 1
    assert alarms[0.0] > 20


def test_the_threshold_leaves_the_stated_share_of_the_training_below() -> None:
    rng = np.random.default_rng(0)
    runs = [(times(1000), rng.normal(size=1000)) for _ in range(5)]
    monitor = Monitor(0.99, 0.0, 0.01).learn(runs)
    levels = np.concatenate([monitor.filtered(*run) for run in runs])
    assert np.mean(levels <= monitor.threshold_) == pytest.approx(0.99, abs=1.0 / 5000.0)
    alarms = np.concatenate([monitor.watch(*run) for run in runs])
    assert alarms.mean() == pytest.approx(0.01, abs=1.0 / 5000.0)
    assert Monitor(1.0).learn(runs).threshold_ == max(
        Monitor(1.0).filtered(*run).max() for run in runs
    )


def test_asking_before_learning_is_an_error() -> None:
    with pytest.raises(NoThreshold, match="call learn"):
        Monitor().update(0.0, 1.0)
    with pytest.raises(NoThreshold, match="Monitor has no threshold"):
        Monitor().watch([0.0], [1.0])


@pytest.mark.parametrize(
    ("t", "signal"),
    [
        ([0.0, 0.0], [1.0, 1.0]),
        ([1.0, 0.0], [1.0, 1.0]),
        ([0.0, math.nan], [1.0, 1.0]),
        ([0.0, 1.0], [1.0, math.nan]),
        ([0.0, 1.0], [1.0]),
        ([], []),
        (0.0, 1.0),
        ([[0.0]], [[1.0]]),
        ("ab", [1.0, 1.0]),
    ],
)
def test_signals_that_are_no_rows_of_numbers_are_refused(t: Any, signal: Any) -> None:
    with pytest.raises(InvalidArray):
        Monitor().learn([(t, signal)])
    monitor = Monitor().learn([([0.0], [1.0])])
    with pytest.raises(InvalidArray):
        monitor.watch(t, signal)
    assert monitor.threshold_ == 1.0


def test_values_that_do_not_go_on_are_refused_and_forgotten() -> None:
    monitor = Monitor().learn([([0.0], [1.0])])
    assert not monitor.update(0.0, 0.5)
    for t, value in (
        (0.0, 0.5),
        (-1.0, 0.5),
        (math.nan, 0.5),
        (math.inf, 0.5),
        (1.0, math.nan),
        (1.0, math.inf),
        (1.0, "high"),
    ):
        with pytest.raises(InvalidValue):
            monitor.update(t, value)  # type: ignore[arg-type]
    assert monitor.update(1.0, 2.0)
    with pytest.raises(InvalidValue, match="at least one run"):
        monitor.learn([])


@pytest.mark.parametrize(
    "options",
    [
        {"quantile": 0.0},
        {"quantile": 1.1},
        {"quantile": math.nan},
        {"hysteresis": -0.1},
        {"hysteresis": 1.0},
        {"time_constant": 0.0},
    ],
)
def test_parameters_that_cannot_be_meant_are_refused(options: dict[str, float]) -> None:
    with pytest.raises(InvalidValue):
        Monitor(**options)


@pytest.mark.parametrize(
    "interval", [[1.0, 2.0], [[2.0, 1.0]], [[1.0, math.nan]], [[1.0, 2.0, 3.0]], 1.0, "ab"]
)
def test_what_is_no_interval_has_no_width(interval: Any) -> None:
    with pytest.raises(InvalidArray):
        torque_width(interval)
