"""Readings of noise: what is noisy, and by how much."""

from __future__ import annotations

import numpy as np
import pytest

from psp3.benchmark.readings import NONE, READINGS, lesson, measured_noise
from psp3.benchmark.tasks import task
from psp3.fuzzy_control.numbers import places_of

SNR = 20.0
MANY = 4000


def parts(reading: str) -> tuple[np.ndarray, np.ndarray]:
    """Return what a reading adds to inputs and outputs of many samples of the 3-PSP."""
    exact = lesson(task("psp3"), NONE, np.inf, np.random.default_rng(0), MANY)
    noisy = lesson(task("psp3"), reading, SNR, np.random.default_rng(0), MANY)
    return noisy.inputs - exact.inputs, noisy.outputs - exact.outputs


@pytest.mark.parametrize(
    ("reading", "entries"),
    [
        ("outputs", "MCG"),
        ("variance", "MCG"),
        ("unit", "MCG"),
        ("gravity", "G"),
        ("mass-coriolis", "MC"),
        ("inputs", ""),
        ("measurement", ""),
    ],
)
def test_noise_is_where_the_reading_says_and_nowhere_else(reading: str, entries: str) -> None:
    of_inputs, of_outputs = parts(reading)
    noisy = np.flatnonzero(of_outputs.any(axis=0))
    assert set(noisy) == set(places_of(entries, 3).tolist() if entries else [])
    assert of_inputs.any() == (reading == "inputs")


@pytest.mark.parametrize(
    ("reading", "power"),
    [
        ("outputs", lambda y: (y**2).mean(axis=0)),
        ("variance", lambda y: y.var(axis=0)),
        ("unit", lambda y: np.ones(y.shape[1])),
    ],
)
def test_power_of_the_noise_is_a_hundredth_of_that_of_the_reference(reading, power) -> None:  # type: ignore[no-untyped-def]
    """20 dB; four thousand draws know a variance to 2.2 %, of which five are taken."""
    _, added = parts(reading)
    expected = power(task("psp3").recorded.outputs) * 10.0 ** (-SNR / 10.0)
    np.testing.assert_allclose(added.var(axis=0), expected, rtol=0.12)


def test_noise_of_measurement_is_against_what_each_signal_varies_by() -> None:
    of_robot = task("delta")
    added = measured_noise(of_robot, "measurement", SNR, MANY, np.random.default_rng(1))
    assert added is not None
    state = np.hstack([of_robot.recorded.positions, of_robot.recorded.speeds])
    np.testing.assert_allclose(added.std(axis=0), 0.1 * state.std(axis=0), rtol=0.06)


@pytest.mark.parametrize("reading", [NONE, *(name for name in READINGS if name != "measurement")])
def test_other_readings_add_nothing_at_run_time(reading: str) -> None:
    assert measured_noise(task("delta"), reading, SNR, 5, np.random.default_rng(1)) is None
