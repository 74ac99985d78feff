r"""How well alarms tell that a robot has left what its rules were learned for.

False alarms, detections and delays, measured.

The question is whether the type-2 torque interval is a good monitor
(:mod:`psp3.fuzzy_control.monitor`). It is compared with signals that are as easily had; each has a
monitor of its own, with a threshold learned from the same training runs in the same way.

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

The rules are learned on a helix of 12 mm. Training and held-out runs are helices within that, of
random radius, speed, phase and initial error. After half of the time something happens in the other
runs: the robot is driven twice as fast, or out to 22 mm, within a second, so that it leaves the
region that was learned; or a payload is attached, with which it stays inside.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from psp3.checks import Array, checked_count, checked_positive
from psp3.drives.drive import NO_DRIVE
from psp3.fuzzy_control import adaptive_kernels
from psp3.fuzzy_control.adaptive import AdaptiveFuzzyComputedTorque
from psp3.fuzzy_control.computed_torque import FuzzyComputedTorque
from psp3.fuzzy_control.kernels import step_width
from psp3.fuzzy_control.monitor import Monitor, torque_width
from psp3.fuzzy_control.records import Record, differences, record
from psp3.loading import load
from psp3.simulation.kernels import WHOLE, Track
from psp3.simulation.loop import compiled_loop, new_track, unbounded
from psp3.study.mismatch import MEASUREMENT_NOISE, PERIOD, UNCERTAINTY_SNR
from psp3.study.run import mismatched
from psp3.study.statistics import Estimate, median, share
from psp3.three_psp.robot import PSP3
from psp3.three_psp.stepping import ClosedFormSteps
from psp3.trajectories.paths import Helix
from psp3.trajectories.trajectory import Trajectory

TRAINED_RADIUS = 0.012
"""Radius of the helix that the rules are learned on [m]."""

RADII, PERIODS = (0.007, TRAINED_RADIUS), (2.0, 3.0)
"""Ranges of the radius [m] and the time for a turn [s] of the runs; the rules are learned with the
largest and the shortest.
"""

INITIAL_ERRORS = (0.003, 0.02)
"""Standard deviations of the initial errors of height [m] and speed [m/s]."""

WIDE_RADIUS, FASTER = 0.022, 2.0
"""Where the radius goes [m], and by what the speed is multiplied, when the robot leaves the
region.
"""

DURATION, EVENT, CHANGE = 10.0, 5.0, 1.0
"""Length of the runs, time of the event, and time that a change of speed or radius takes [s]."""

GAINS = (100.0, 20.0)
"""Of the servo, critically damped: with the soft ones of Table 6.1 initial errors ring for longer
than these runs.
"""

RESIDUAL_LAG = 0.05
"""Time constant of the filter of the residual [s]."""


class DepartingHelix(Trajectory):
    r"""A helix whose speed and radius change smoothly from one value to another.

    .. math:: x = \big(r \cos\varphi,\; r \sin\varphi,\; z_0 + \dot z t\big), \qquad
              r = r_0 + (r_1 - r_0)\, b(t), \quad
              \dot\varphi = \tfrac{2\pi}{T} \big(1 + (q - 1)\, b(t)\big)

    with the smooth step b from 0 to 1 that has no speed and no acceleration at its ends,
    :math:`b(s) = 10 s^3 - 15 s^4 + 6 s^5`.

    Parameters
    ----------
    radius, period, phase : float
        Radius [m], time for a turn [s] and azimuth [rad] at the start.
    last_radius, speed_up : float
        Radius at the end [m], and factor q of the speed there.
    robot : PSP3
        See :class:`psp3.trajectories.trajectory.Trajectory`.

    Attributes
    ----------
    height : float
        Level :math:`z_0`, that of the tip in the home pose [m].
    """

    def __init__(
        self,
        radius: float,
        period: float,
        phase: float,
        last_radius: float,
        speed_up: float,
        robot: PSP3,
    ) -> None:
        super().__init__(robot, "tip")
        self.radius, self.period, self.phase = radius, period, phase
        self.last_radius, self.speed_up = last_radius, speed_up
        self.height = robot.parameters.tool_length

    def _path(self, t: Array) -> tuple[Array, Array, Array]:
        s = np.clip((t - EVENT) / CHANGE, 0.0, 1.0)
        # The step, its integral over time, and its derivatives.
        step, rate = s**3 * (10.0 - 15.0 * s + 6.0 * s**2), 30.0 * s**2 * (1.0 - s) ** 2 / CHANGE
        bend = 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s) / CHANGE**2
        area = CHANGE * s**4 * (2.5 - 3.0 * s + s**2) + np.maximum(t - EVENT - CHANGE, 0.0)
        omega, gain, growth = (
            2.0 * np.pi / self.period,
            self.speed_up - 1.0,
            self.last_radius - self.radius,
        )
        angle, turn, hurry = (
            self.phase + omega * (t + gain * area),
            omega * (1.0 + gain * step),
            omega * gain * rate,
        )
        r, out, push = self.radius + growth * step, growth * rate, growth * bend
        cosine, sine, zero = np.cos(angle), np.sin(angle), np.zeros_like(t)
        along, across = push - r * turn**2, 2.0 * out * turn + r * hurry
        return (
            np.stack([r * cosine, r * sine, self.height + 0.01 * t], axis=-1),
            np.stack(
                [out * cosine - r * turn * sine, out * sine + r * turn * cosine, zero + 0.01],
                axis=-1,
            ),
            np.stack(
                [along * cosine - across * sine, along * sine + across * cosine, zero], axis=-1
            ),
        )


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
    """Low-pass filter the vector before its length is taken.

    Noise of measurement would not average out of the length.
    """
    a, v = (0.5 * (x[1:] + x[:-1]) for x in (run.heights, run.speeds))
    M, C, G = controller.estimate(a, v)
    rise = np.diff(run.speeds, axis=0) / np.diff(run.t)[:, np.newaxis]
    missed = run.torque[:-1] - np.einsum("nij,nj->ni", M, rise) - np.einsum("nij,nj->ni", C, v) - G
    # Nothing is known before the first period is over, and zero is what is expected.
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
    """How well one signal did.

    Parameters
    ----------
    signal : str
        Name of the signal.
    threshold : float
        What its monitor learned, in the unit of the signal.
    false_alarms : Estimate
        Share of the held-out runs with an alarm, with its 95 % interval.
    detected : dict of str to Estimate
        By event, the share of runs in which an alarm came on after it.
    delay : dict of str to Estimate
        By event, the median time from it to the first alarm of these runs [s].
    excess : dict of str to float
        By event, the median over the runs of the greatest value of the filtered signal after it, in
        units of the threshold.
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
        Number of training runs, of held-out runs, and of runs with each event; all of them are
        different.
    payloads : sequence of float
        Masses that are attached, an event each [kg].
    kind, snr_db, learner, mean_variation
        Of the controller, see :class:`psp3.FuzzyComputedTorque`; the mean variation is by default
        that for records of 20 dB, or of ``snr_db`` if they are noisier.
    monitor : Monitor, optional
        What its parameters are taken from; those of ``Monitor()`` by default.
    workers : int, optional
        Number of threads; that of the processors by default. The result does not depend on it.

    Returns
    -------
    list of Detection
        One for each of :data:`SIGNALS`.

    Raises
    ------
    InvalidValue, UnknownName
        If an argument is not what it must be.
    """
    count = checked_count("seeds", seeds, 2)
    masses = [checked_positive("payloads", payload) for payload in payloads]
    like = Monitor() if monitor is None else monitor
    controller = trained_for_detection(kind, snr_db, learner, mean_variation)
    events: dict[str, tuple[float, float, float]] = {
        "faster": (0.0, FASTER, 0.0),
        "wider": (WIDE_RADIUS, 1.0, 0.0),
    }
    events |= {f"{mass:g} kg": (0.0, 1.0, mass) for mass in masses}
    kinds = {"training": (0.0, 1.0, 0.0), "held out": (0.0, 1.0, 0.0)} | events
    jobs = [
        (number, *event, seed)
        for number, event in enumerate(kinds.values())
        for seed in range(count)
    ]
    threads = checked_count("workers", (os.cpu_count() or 1) if workers is None else workers)
    with ThreadPoolExecutor(threads) as pool:
        watched = list(
            pool.map(lambda job: _signals(controller, watch_run(controller, *job)), jobs)
        )
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
    """Return a table of what :func:`detect` found.

    Shares of runs, and median delays of those in which it was detected.
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


def trained_for_detection(
    kind: str = "it2",
    snr_db: float = math.inf,
    learner: str = "strongest",
    mean_variation: float | None = None,
) -> FuzzyComputedTorque:
    """Return the controller that is watched, learned on the helix of 12 mm; see :func:`detect`."""
    from fuzzy2.learning.noise import mean_variation_from_snr

    variation = (
        float(mean_variation_from_snr(min(snr_db, UNCERTAINTY_SNR)))
        if mean_variation is None
        else mean_variation
    )
    kp, kv = GAINS
    controller = FuzzyComputedTorque(
        kind, _robot(), kp=kp, kv=kv, snr_db=snr_db, learner=learner, mean_variation=variation
    )
    return controller.learn(_record(), rng=np.random.default_rng(0))


def watch_run(
    controller: FuzzyComputedTorque,
    stream: int = 0,
    last_radius: float = 0.0,
    speed_up: float = 1.0,
    payload: float = 0.0,
    seed: int = 0,
) -> Watched:
    """Do a run, and return what the controller saw of it.

    Parameters
    ----------
    controller : FuzzyComputedTorque
        Type-1 or interval type-2, see :func:`trained_for_detection`.
    stream, seed : int
        Of the random numbers: path, initial errors and noise of measurement.
    last_radius : float
        Radius after the event [m]; 0 for that before it.
    speed_up : float
        Factor of the speed after the event.
    payload : float
        Mass that is attached by the event [kg].
    """
    rng, robot = np.random.default_rng([stream, seed]), _robot()
    radius, period, phase = (
        rng.uniform(*RADII),
        rng.uniform(*PERIODS),
        rng.uniform(0.0, 2.0 * np.pi),
    )
    path = DepartingHelix(radius, period, phase, last_radius or radius, speed_up, robot)
    t: Array = PERIOD * np.arange(round(DURATION / PERIOD) + 1, dtype=np.float64)
    motion = path(t)
    state = np.concatenate([motion.heights[0], motion.speeds[0]]) + rng.standard_normal(
        6
    ) * np.repeat(INITIAL_ERRORS, 3)
    noise = rng.standard_normal((len(t), 6)) * np.repeat(MEASUREMENT_NOISE, 3)
    adaptive = AdaptiveFuzzyComputedTorque(controller)
    table = adaptive_kernels.Adaptive(
        adaptive.settings._replace(memory=0.0),
        adaptive.rules,
        adaptive_kernels.new_memory(adaptive.rules.trained),
    )
    loaded = mismatched(robot.parameters, 0.0, payload, np.random.default_rng(0))
    wiring, middle = unbounded(PERIOD, np.zeros(3), noise=noise), round(EVENT / PERIOD)
    track = new_track(t, motion, step_width(3) - 3)
    before = Track(*(array[: middle + 1] for array in track))
    plant = ClosedFormSteps(robot.parameters.as_array(), 1, NO_DRIVE)
    ended = compiled_loop(table, plant, wiring, before, state)
    if ended.why == WHOLE:
        # The sample between both parts is done twice, from the same state.
        plant = ClosedFormSteps(loaded.as_array(), 1, NO_DRIVE)
        compiled_loop(table, plant, wiring, track, ended.state, middle)
    seen = track.states + noise
    interval = np.stack([track.wrote[:, 3:6], track.wrote[:, 6:9]], axis=-1)
    return Watched(t, seen[:, :3], seen[:, 3:], track.applied, interval, motion.heights)


def _signals(controller: FuzzyComputedTorque, run: Watched) -> tuple[Array, dict[str, Array]]:
    return run.t, {name: signal(controller, run) for name, signal in SIGNALS.items()}


def _delay(t: Array, alarm: NDArray[np.bool_]) -> float:
    """Return the time from the event to the first alarm after it.

    It is infinite if none comes on.
    """
    comes_on = alarm & ~np.concatenate([[False], alarm[:-1]]) & (t > EVENT)
    return float(t[np.argmax(comes_on)] - EVENT) if comes_on.any() else math.inf


def _greatest(t: Array, level: Array) -> float:
    return float(level[t > EVENT].max())


@lru_cache(maxsize=1)
def _robot() -> PSP3:
    return load("psp3")


@lru_cache(maxsize=1)
def _record() -> Record:
    kp, kv = GAINS
    return record(
        _robot(), Helix(radius=TRAINED_RADIUS, period=PERIODS[0], robot=_robot()), kp=kp, kv=kv
    )
