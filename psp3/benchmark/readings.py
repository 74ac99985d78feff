"""The readings of noise of the benchmark, which define "noise of S dB", by name.

The power of a signal can be defined in several ways, and noise can be on the record or on the
measurements at run time. The ranking of the entries depends on this choice
(:mod:`psp3.fuzzy_control.records` has the equation).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from psp3.benchmark.tasks import Task
from psp3.checks import Array
from psp3.fuzzy_control.records import RecordNoise


class Reading(NamedTuple):
    """A reading of noise.

    ``title`` describes it in words. ``noise`` defines a ratio on a record; it is None if records
    are exact and the noise is on measured positions and speeds at run time.
    """

    title: str
    noise: RecordNoise | None


READINGS = {
    "outputs": Reading("on M, C and G, against the mean square of each", RecordNoise()),
    "variance": Reading("on M, C and G, against the variance of each", RecordNoise("variance")),
    "unit": Reading("on M, C and G, against 1 in the unit of each (0 dBW)", RecordNoise("unit")),
    "gravity": Reading("on G alone, against its mean square", RecordNoise(entries="gravity")),
    "mass-coriolis": Reading(
        "on M and C alone, against the mean square of each", RecordNoise(entries="mass-coriolis")
    ),
    "inputs": Reading(
        "on the recorded inputs, against the mean square of each", RecordNoise(of_inputs=True)
    ),
    "measurement": Reading(
        "on positions and speeds at run time, against the variance of each", None
    ),
}
"""Readings of noise by name; the first one is the default."""

NONE = "none"
"""Name of the reading without noise."""

AT_RUN_TIME = RecordNoise("variance")
"""Definition of a ratio at run time. It uses the variance: the zero of positions is arbitrary, so
their mean square is not a signal power."""


class Lesson(NamedTuple):
    """Inputs (N, p) and outputs (N, m) that an entry learns from."""

    inputs: Array
    outputs: Array


def lesson(
    task: Task, reading: str, snr_db: float, rng: np.random.Generator, samples: int
) -> Lesson:
    """Return samples of a task's record, with the noise of a reading on them.

    Parameters
    ----------
    task : Task
        Task with the record.
    reading : str
        One of ``READINGS``, or ``NONE``.
    snr_db : float
        Signal-to-noise ratio [dB].
    rng : numpy.random.Generator
        Source of the noise.
    samples : int
        Number of samples, which cover the recorded inputs evenly.
    """
    chosen = task.recorded.sample(samples)
    noise = None if reading == NONE else READINGS[reading].noise
    if noise is None or not math.isfinite(snr_db):
        return Lesson(task.recorded.inputs[chosen], task.recorded.outputs[chosen])
    return Lesson(*noise.added(task.recorded, chosen, snr_db, rng))


def measured_noise(
    task: Task, reading: str, snr_db: float, count: int, rng: np.random.Generator
) -> Array | None:
    """Return the measurement noise on positions and speeds, (count, 2n), or None."""
    if reading == NONE or READINGS[reading].noise is not None or not math.isfinite(snr_db):
        return None
    recorded = task.recorded
    state = np.concatenate([recorded.positions, recorded.speeds], axis=1)
    amplitudes = 10.0 ** (-snr_db / 20.0) * AT_RUN_TIME.amplitudes(state)
    noise: Array = amplitudes * rng.standard_normal((count, state.shape[1]))
    return noise
