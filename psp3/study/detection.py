r"""A grid of runs: how well alarms detect that a robot has left its training conditions.

False alarms, detections and delays, measured.

The question is whether the type-2 torque interval is a good monitor
(:mod:`psp3.fuzzy_control.monitor`). It is compared with other signals that are just as easy to
compute. Each signal has its own monitor, whose threshold is learned in the same way from the same
training runs.

========  ==========================================================================================
signal    what it is
========  ==========================================================================================
interval  width of the torque interval, added up over the screws [N]
range     how far the farthest input is outside of its trained range, as a share of that; 0 inside
          (``covered``)
firing    1 less the upper firing strength of the rule that fires most
error     distance of heights and desired heights [m]
residual  force of the last period that the rules do not explain by the motion that it made,
          low-pass filtered [N]
========  ==========================================================================================

The rules are learned on a helix of 12 mm radius. Training and held-out runs follow helices within
it, of random radius, speed, phase and initial error. The other runs have an event at half time. In
two of the events the robot leaves the learned region: within a second it is driven twice as fast,
or out to 22 mm. In the others a payload is attached, and the robot stays inside the region.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fuzzy2.support.one_thread import one_thread
from psp3.checks import Array, checked_count, checked_positive
from psp3.errors import UnknownName
from psp3.fuzzy_control.computed_torque import FuzzyComputedTorque
from psp3.fuzzy_control.monitor import Monitor, torque_width
from psp3.fuzzy_control.records import differences
from psp3.study.controllers import robot_named, trained
from psp3.study.execution import simulate_run
from psp3.study.mismatch import MEASUREMENT_NOISE, uncertainty
from psp3.study.paths import EVENT as EVENT
from psp3.study.paths import NARROW
from psp3.study.run import Run
from psp3.study.statistics import Estimate, median, share

INITIAL_ERRORS = (0.003, 0.02)
"""Standard deviations of the initial errors of height [m] and speed [m/s]."""

DURATION = 10.0
"""Length of the runs [s]."""

GAINS = (100.0, 20.0)
"""Servo gains, critically damped: with the soft gains of Table 6.1 initial errors ring for longer
than these runs last.
"""

RESIDUAL_LAG = 0.05
"""Time constant of the filter of the residual [s]."""

TRAINING, HELD_OUT, FASTER, WIDER = "training", "held out", "faster", "wider"
"""Purposes of runs: to learn thresholds, to count false alarms, and two departures from the
conditions that the rules were learned under.
"""

PATHS = {
    TRAINING: "drawn-helix",
    HELD_OUT: "drawn-helix",
    FASTER: "drawn-helix-faster",
    WIDER: "drawn-helix-wider",
}


class Watched(NamedTuple):
    """A run as the controller saw it.

    Times ``t`` (N,) [s], ``heights`` [m], ``speeds`` [m/s] and ``torque`` [N] (N, 3), the torque's
    ``interval`` (N, 3, 2) [N], ``desired`` heights (N, 3) [m].
    """

    t: Array
    heights: Array
    speeds: Array
    torque: Array
    interval: Array
    desired: Array


def _interval(controller: FuzzyComputedTorque, run: Watched) -> Array:
    return torque_width(run.interval)


def _range(controller: FuzzyComputedTorque, run: Watched) -> Array:
    inputs, (low, high) = differences(run.heights, run.speeds), controller.ranges_
    outside = np.maximum(np.maximum(low - inputs, inputs - high), 0.0) / (high - low)
    return np.asarray(outside.max(axis=1))


def _firing(controller: FuzzyComputedTorque, run: Watched) -> Array:
    return np.asarray(
        1.0 - controller.system_.firing(differences(run.heights, run.speeds))[..., 1].max(axis=1)
    )


def _error(controller: FuzzyComputedTorque, run: Watched) -> Array:
    return np.asarray(np.linalg.norm(run.desired - run.heights, axis=1))


def _residual(controller: FuzzyComputedTorque, run: Watched) -> Array:
    """Return the length of the low-pass filtered residual.

    The vector is filtered before its length is taken, because measurement noise does not average
    out of a length.
    """
    a, v = (0.5 * (x[1:] + x[:-1]) for x in (run.heights, run.speeds))
    M, C, G = controller.estimate(a, v)
    rise = np.diff(run.speeds, axis=0) / np.diff(run.t)[:, np.newaxis]
    missed = run.torque[:-1] - np.einsum("nij,nj->ni", M, rise) - np.einsum("nij,nj->ni", C, v) - G
    # There is no measurement before the first period is over, so the residual starts at its
    # expected value, zero.
    missed = np.concatenate([np.zeros((1, 3)), missed])
    lowpass = Monitor(time_constant=RESIDUAL_LAG)
    return np.asarray(
        np.linalg.norm([lowpass.filtered(run.t, column) for column in missed.T], axis=0)
    )


SIGNALS: dict[str, Callable[[FuzzyComputedTorque, Watched], Array]] = {
    "interval": _interval,
    "range": _range,
    "firing": _firing,
    "error": _error,
    "residual": _residual,
}
"""Signals by name."""


@dataclass(frozen=True)
class Detection:
    """How well one signal detects the events.

    Parameters
    ----------
    signal : str
        Name of the signal.
    threshold : float
        Threshold that its monitor learned, in the unit of the signal.
    false_alarms : Estimate
        Share of the held-out runs with an alarm, with its 95 % interval.
    detected : dict of str to Estimate
        By event, the share of runs with an alarm after the event.
    delay : dict of str to Estimate
        By event, the median time from the event to the first alarm in these runs [s].
    excess : dict of str to float
        By event, the greatest value of the filtered signal after the event, in units of the
        threshold; the median over the runs.
    """

    signal: str
    threshold: float
    false_alarms: Estimate
    detected: dict[str, Estimate]
    delay: dict[str, Estimate]
    excess: dict[str, float]


def detect(
    seeds: int = 20,
    payloads: Sequence[float] = (1.0, 2.0, 5.0),
    kind: str = "it2",
    snr_db: float = math.inf,
    learner: str = "strongest",
    mean_variation: float | None = None,
    monitor: Monitor | None = None,
    workers: int | None = None,
) -> list[Detection]:
    """Measure false alarms, detections and delays of every signal.

    Parameters
    ----------
    seeds : int
        Number of training runs, of held-out runs, and of runs with each event; no two runs share a
        seed.
    payloads : sequence of float
        Masses that are attached, one event each [kg].
    kind, snr_db, learner, mean_variation
        Parameters of the controller, see :class:`psp3.FuzzyComputedTorque`. The default mean
        variation is the one for records of 20 dB, or of ``snr_db`` if that is noisier.
    monitor : Monitor, optional
        Monitor whose parameters are used; ``Monitor()`` by default.
    workers : int, optional
        Number of threads; the number of processors by default. The result does not depend on it.

    Returns
    -------
    list of Detection
        One for each of :data:`SIGNALS`.

    Raises
    ------
    InvalidValue, UnknownName
        If an argument is invalid.
    """
    count = checked_count("seeds", seeds, 2)
    masses = [checked_positive("payloads", payload) for payload in payloads]
    like = Monitor() if monitor is None else monitor
    events: dict[str, str | float] = {FASTER: FASTER, WIDER: WIDER}
    events |= {f"{mass:g} kg": mass for mass in masses}
    kinds = {TRAINING: TRAINING, HELD_OUT: HELD_OUT} | events
    # Every run has a seed of its own.
    jobs = [
        watched_run(what, number * count + seed, kind, snr_db, learner, mean_variation)
        for number, what in enumerate(kinds.values())
        for seed in range(count)
    ]
    for job in jobs:
        job.check()
    controller = watched_controller(jobs[0])
    threads = checked_count("workers", (os.cpu_count() or 1) if workers is None else workers)
    with one_thread(), ThreadPoolExecutor(threads) as pool:
        watched = list(pool.map(lambda job: _signals(controller, watch(job)), jobs))
    runs = {name: watched[i * count : (i + 1) * count] for i, name in enumerate(kinds)}
    found = []
    for signal in SIGNALS:
        one = Monitor(like.quantile, like.hysteresis, like.time_constant).learn(
            (t, values[signal]) for t, values in runs["training"]
        )
        false = [float(one.watch(t, values[signal]).any()) for t, values in runs["held out"]]
        delays = {
            name: np.array([_delay(t, one.watch(t, values[signal])) for t, values in runs[name]])
            for name in events
        }
        excess = {
            name: float(
                np.median(
                    [_greatest(t, one.filtered(t, values[signal])) for t, values in runs[name]]
                )
            )
            / one.threshold_
            if one.threshold_ > 0.0
            else math.nan
            for name in events
        }
        detected = {name: share(np.isfinite(rows).astype(float)) for name, rows in delays.items()}
        delay = {name: median(rows[np.isfinite(rows)]) for name, rows in delays.items()}
        found.append(Detection(signal, one.threshold_, share(false), detected, delay, excess))
    return found


def markdown(found: Sequence[Detection]) -> str:
    """Return the results of :func:`detect` as a Markdown table.

    The cells are shares of runs, and the median delay of the runs in which the event was detected.
    """
    events = list(found[0].detected)
    lines = [
        "| signal | threshold | false alarms | " + " | ".join(events) + " |",
        "|---" * (len(events) + 3) + "|",
    ]
    for one in found:
        cells = [
            f"{100.0 * one.detected[name].value:.0f} %{_after(one.delay[name])}" for name in events
        ]
        false = one.false_alarms
        shares = (
            f"{100.0 * false.value:.0f} % ({100.0 * false.low:.0f} to {100.0 * false.high:.0f})"
        )
        lines.append(
            f"| {one.signal} | {one.threshold:.3g} | {shares} | " + " | ".join(cells) + " |"
        )
    return "\n".join(lines)


def _after(delay: Estimate) -> str:
    return f" after {delay.value:.2f} s" if delay.count else ""


def watched_run(
    what: str | float = TRAINING,
    seed: int = 0,
    kind: str = "it2",
    snr_db: float = math.inf,
    learner: str = "strongest",
    mean_variation: float | None = None,
) -> Run:
    """Return a run for the monitors to watch.

    Parameters
    ----------
    what : str or float
        Purpose of the run: ``"training"``, ``"held out"``, ``"faster"`` or ``"wider"``, or the mass
        that is attached to the star [kg].
    seed : int
        Seed of the path, the initial errors and the measurement noise.
    kind, snr_db, learner, mean_variation
        Parameters of the controller, which is the same in all runs, see :func:`detect`.

    Raises
    ------
    UnknownName
        If there is no such event.
    """
    is_payload = not isinstance(what, str)
    if not is_payload and what not in PATHS:
        raise UnknownName("event", what, tuple(PATHS))
    variation = uncertainty(snr_db) if mean_variation is None else mean_variation
    kp, kv = GAINS
    position_noise, speed_noise = MEASUREMENT_NOISE
    initial_error, initial_speed_error = INITIAL_ERRORS
    return Run(
        kind,
        snr_db=snr_db,
        seed=seed,
        trajectory=PATHS[TRAINING if is_payload else str(what)],
        learner=learner,
        mean_variation=variation,
        payload=float(what) if is_payload else 0.0,
        payload_from=EVENT,
        duration=DURATION,
        kp=kp,
        kv=kv,
        learned_on=NARROW,
        learning_seed=0,
        position_noise=position_noise,
        speed_noise=speed_noise,
        initial_error=initial_error,
        initial_speed_error=initial_speed_error,
    )


def watch(run: Run) -> Watched:
    """Do a run, and return what its controller saw."""
    samples = simulate_run(run)
    result, n = samples.result, samples.result.positions.shape[1]
    seen = np.concatenate([result.positions, result.speeds], axis=1)
    if samples.noise is not None:
        seen = seen + samples.noise[: len(seen)]
    assert result.torque_interval is not None
    return Watched(
        result.t,
        seen[:, :n],
        seen[:, n:],
        result.torque,
        result.torque_interval,
        result.desired.positions,
    )


def watched_controller(run: Run) -> FuzzyComputedTorque:
    """Return the trained controller of a watched run."""
    robot = robot_named(run.robot, run.parameters)
    return trained(run, robot, np.random.default_rng([run.learning_seed or 0, 0]))


def _signals(controller: FuzzyComputedTorque, run: Watched) -> tuple[Array, dict[str, Array]]:
    return run.t, {name: signal(controller, run) for name, signal in SIGNALS.items()}


def _delay(t: Array, alarm: NDArray[np.bool_]) -> float:
    """Return the time from the event to the first alarm after it.

    It is infinite if there is no alarm.
    """
    comes_on = alarm & ~np.concatenate([[False], alarm[:-1]]) & (t > EVENT)
    return float(t[np.argmax(comes_on)] - EVENT) if comes_on.any() else math.inf


def _greatest(t: Array, level: Array) -> float:
    return float(level[t > EVENT].max())
