r"""The comparison of controllers on robots that are not what they believe.

Adaptation against exact models, integrals and regulators.

Every controller believes in the robot as drawn. The robot that it steers carries a payload, its
masses and inertias are off by random factors, and what is measured is noisy; the fuzzy controllers
were trained on the robot as drawn, from records that are exact or noisy.

=================  =================================================================================
controller         what it is
=================  =================================================================================
ctc                computed torque with the exact model of the robot as drawn, gains of Table 6.1
ctc-integral       the same with an integral of the error
lqr                the forces of the desired motion and a linear-quadratic regulator as stiff as
                   computed torque is
lqr-stiff          the same, ten times as stiff
t1, it2            fuzzy computed torque as trained, :class:`psp3.FuzzyComputedTorque`
adaptive-t1, -it2  the same with rules that adapt, :class:`psp3.AdaptiveFuzzyComputedTorque`
=================  =================================================================================

Runs of one seed see the same robot, the same noise and the same records, whatever the controller:
they are compared in pairs.
"""

from __future__ import annotations

import itertools
import math
import os
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from fuzzy2.learning.noise import mean_variation_from_snr
from psp3.checks import Array, checked_count, checked_not_negative, checked_positive
from psp3.control.controller import Widths
from psp3.control.kernels import COMPUTED_TORQUE, FEED_FORWARD, Classical, classical
from psp3.control.linear_quadratic_regulator import LinearQuadraticRegulator
from psp3.drives.drive import NO_DRIVE, Drive
from psp3.errors import InvalidValue, UnknownName
from psp3.fuzzy_control import adaptive_kernels
from psp3.fuzzy_control.adaptive import AdaptiveFuzzyComputedTorque
from psp3.fuzzy_control.computed_torque import FuzzyComputedTorque, checked_snr
from psp3.fuzzy_control.kernels import step_width
from psp3.fuzzy_control.records import Record, record
from psp3.loading import load
from psp3.published import DURATION, TABLE_6_1, THESIS_SAMPLING_PERIOD
from psp3.simulation.loop import compiled_loop, new_track, unbounded
from psp3.study.run import FIRST_TRAJECTORY, TRAJECTORIES, mismatched
from psp3.study.statistics import Estimate, mean, ratio_of_means, share
from psp3.three_psp.robot import PSP3
from psp3.three_psp.stepping import ClosedFormSteps, closed_form_table
from psp3.trajectories.motion import Motion, check_stroke

FUZZY = ("t1", "it2", "adaptive-t1", "adaptive-it2")
CONTROLLERS = ("ctc", "ctc-integral", "lqr", "lqr-stiff", *FUZZY)
"""Names of the controllers."""

PAIRS = (
    ("adaptive-t1", "ctc-integral"),
    ("adaptive-t1", "lqr-stiff"),
    ("adaptive-it2", "adaptive-t1"),
    ("it2", "t1"),
)
"""Pairs whose ratios are shown by default."""

METRICS = ("error", "settled", "effort")
"""Names of what is measured, see :class:`Outcome`."""

PERIOD = 0.002
"""Control period [s]."""

INTEGRAL_GAIN = 3.0
"""Of ``ctc-integral`` [1/s³]; with the other gains of Table 6.1 the loop is stable below 10."""

ACCEPTABLE_ERROR, ACCEPTABLE_SPEED_ERROR = 0.01, 0.1
"""Errors that the regulators weigh like ``REGULATOR_FORCES`` (Bryson's rule) [m, m/s]."""

REGULATOR_FORCES = {"lqr": 1.0, "lqr-stiff": 10.0}
"""Forces that the regulators weigh like these errors [N]. The first makes a stiffness of 99 N/m,
and computed torque has 93 N/m.
"""

MEASUREMENT_NOISE = (1e-5, 1e-3)
"""Standard deviations of white noise on measured heights [m] and speeds [m/s]."""

MASS_MISMATCH = 0.05
"""Masses and inertias are off by factors exp(0.05 ε), and 0.25 kg · abs(ε) ride on the star besides
the payload; ε is normal.
"""

UNCERTAINTY_SNR = 20.0
"""Signal-to-noise ratio [dB] for whose mean variation the type-2 terms are made if the records are
exact.
"""


@dataclass(frozen=True)
class Case:
    """What runs of different seeds have in common.

    Parameters
    ----------
    payload : float
        Mass on the star that no controller knows of [kg].
    trajectory : str
        One of :data:`psp3.study.run.TRAJECTORIES`; the rules are learned on the first.
    snr_db : float
        Signal-to-noise ratio of the records that the rules are learned from [dB]; infinite for
        exact ones.
    drive : Drive
        Friction and motor inertia of the screws, which no controller knows of either.
    """

    payload: float = 0.0
    trajectory: str = FIRST_TRAJECTORY
    snr_db: float = math.inf
    drive: Drive = NO_DRIVE

    def check(self) -> None:
        """Raise what :func:`run` would raise.

        Raises
        ------
        InvalidValue, UnknownName
            If a field is not what it must be.
        """
        checked_not_negative("payload", self.payload)
        checked_snr(self.snr_db)
        if self.trajectory not in TRAJECTORIES:
            raise UnknownName("trajectory", self.trajectory, tuple(TRAJECTORIES))
        if not isinstance(self.drive, Drive):
            raise InvalidValue("drive", self.drive, "a psp3.drives.Drive")

    def __str__(self) -> str:
        records = "exact records" if self.snr_db == math.inf else f"records of {self.snr_db:g} dB"
        return (
            f"{self.payload:g} kg, {self.trajectory}, "
            f"{records}{'' if self.drive == NO_DRIVE else ', driven'}"
        )


@dataclass(frozen=True)
class Outcome:
    """What a run gave.

    Parameters
    ----------
    error : float
        Sum of squared errors as Table 6.3 counts it [m²]; NaN if the run diverged.
    settled : float
        Root mean square of the error over the second half of the run [m]; NaN if it diverged.
    effort : float
        Mean square of the torque [N²]; NaN if it diverged.
    diverged : bool
        Whether the robot left the poses it can take.
    """

    error: float
    settled: float
    effort: float
    diverged: bool


@dataclass(frozen=True)
class Row:
    """What the seeds of one case gave under one controller.

    Parameters
    ----------
    case, controller
        What was compared.
    error, settled, effort : Estimate
        Means of the fields of :class:`Outcome` over the seeds, with 95 % intervals.
    diverged : Estimate
        Share of the runs that diverged.
    """

    case: Case
    controller: str
    error: Estimate
    settled: Estimate
    effort: Estimate
    diverged: Estimate


@dataclass(frozen=True)
class Comparison:
    """Results of :func:`compare`.

    Parameters
    ----------
    cases : tuple of Case
    controllers : tuple of str
    outcomes : dict
        By case and controller, the outcomes of seeds 0, 1, ...
    """

    cases: tuple[Case, ...]
    controllers: tuple[str, ...]
    outcomes: dict[tuple[Case, str], tuple[Outcome, ...]]

    def values(self, case: Case, controller: str, metric: str = "error") -> Array:
        """Return a metric of all seeds, (seeds,); NaN where a run diverged."""
        if metric not in METRICS:
            raise UnknownName("metric", metric, METRICS)
        if (case, controller) not in self.outcomes:
            raise InvalidValue(
                "case and controller", (str(case), controller), "one that was compared"
            )
        return np.array([getattr(outcome, metric) for outcome in self.outcomes[case, controller]])

    def rows(self) -> list[Row]:
        """Return a row for every case and controller."""
        rows = []
        for case, controller in itertools.product(self.cases, self.controllers):
            error, settled, effort = (
                mean(self.values(case, controller, metric)) for metric in METRICS
            )
            diverged = share(
                [float(outcome.diverged) for outcome in self.outcomes[case, controller]]
            )
            rows.append(Row(case, controller, error, settled, effort, diverged))
        return rows

    def ratio(self, case: Case, controller: str, baseline: str, metric: str = "error") -> Estimate:
        """Return by what factor a controller's mean is that of another one.

        With its interval from seeds in pairs.
        """
        return ratio_of_means(
            self.values(case, controller, metric), self.values(case, baseline, metric)
        )

    def best(self, case: Case, metric: str = "error") -> tuple[str, ...]:
        """Return the controller of the least mean, and those not shown to be worse.

        None that ever diverged.
        """
        safe = [
            name
            for name in self.controllers
            if not any(outcome.diverged for outcome in self.outcomes[case, name])
        ]
        if not safe:
            return ()
        first = min(safe, key=lambda name: float(self.values(case, name, metric).mean()))
        return first, *(
            name
            for name in safe
            if name != first and not self.ratio(case, name, first, metric).low > 1.0
        )

    def markdown(self, metric: str = "settled", scale: float = 1e3) -> str:
        """Return a table of means, a line for each case and a column for each controller.

        The :meth:`best` are bold.
        """
        lines = _heading(self.controllers)
        for case in self.cases:
            best, cells = self.best(case, metric), []
            for name in self.controllers:
                text = f"{scale * mean(self.values(case, name, metric)).value:.3g}"
                lost = sum(outcome.diverged for outcome in self.outcomes[case, name])
                cells.append(
                    (f"**{text}**" if name in best else text)
                    + (f", {lost} diverged" if lost else "")
                )
            lines.append(_line(case, cells))
        return "\n".join(lines)

    def ratios(self, pairs: Sequence[tuple[str, str]] = PAIRS, metric: str = "settled") -> str:
        """Return a table of :meth:`ratio` with its intervals.

        A line for each case and a column for each pair of controllers.
        """
        lines = _heading([f"{controller} / {baseline}" for controller, baseline in pairs])
        for case in self.cases:
            found = (
                self.ratio(case, controller, baseline, metric) for controller, baseline in pairs
            )
            lines.append(
                _line(case, [f"{one.value:.3g} ({one.low:.3g} to {one.high:.3g})" for one in found])
            )
        return "\n".join(lines)


def _heading(columns: Sequence[str]) -> list[str]:
    return [
        "| kg | path | records | " + " | ".join(columns) + " |",
        "|---" * (len(columns) + 3) + "|",
    ]


def _line(case: Case, cells: Sequence[str]) -> str:
    records = "exact" if case.snr_db == math.inf else f"{case.snr_db:g} dB"
    return f"| {case.payload:g} | {case.trajectory} | {records} | " + " | ".join(cells) + " |"


def compare(
    payloads: Sequence[float] = (0.0, 1.0, 2.0, 5.0),
    trajectories: Sequence[str] = ("helix", "waypoints", "fast-helix"),
    snrs_db: Sequence[float] = (math.inf, 20.0),
    seeds: int = 8,
    controllers: Sequence[str] = CONTROLLERS,
    duration: float = DURATION,
    drive: Drive = NO_DRIVE,
    workers: int | None = None,
) -> Comparison:
    """Run all controllers in all cases with all seeds.

    Parameters
    ----------
    payloads, trajectories, snrs_db : sequence
        Fields of the cases, of which there is one for every combination.
    seeds : int
        Number of seeds, at least 2.
    controllers : sequence of str
        Of :data:`CONTROLLERS`.
    duration : float
        Length of the runs [s].
    drive : Drive
        Field of all cases.
    workers : int, optional
        Number of threads; that of the processors by default. The result does not depend on it.

    Returns
    -------
    Comparison

    Raises
    ------
    InvalidValue, UnknownName
        If an argument is not what it must be.
    StrokeExceeded
        If a trajectory leaves the screws in the duration.
    """
    cases = tuple(
        Case(*fields, drive) for fields in itertools.product(payloads, trajectories, snrs_db)
    )
    names = tuple(controllers)
    for name in names:
        _check_controller(name)
    for case in cases:
        case.check()
        _desired(case.trajectory, checked_positive("duration", duration))
    count = checked_count("seeds", seeds, 2)
    threads = checked_count("workers", (os.cpu_count() or 1) if workers is None else workers)
    # Controllers without rules do not see the records; their runs are the same for all of them, and
    # are done once.
    wanted = {(_seen(case, name), name) for case, name in itertools.product(cases, names)}
    jobs = [(case, name, seed) for case, name in sorted(wanted, key=str) for seed in range(count)]
    with ThreadPoolExecutor(threads) as pool:
        done = dict(
            zip(
                jobs, pool.map(lambda job: run(job[0], job[1], job[2], duration), jobs), strict=True
            )
        )
    outcomes = {
        (case, name): tuple(done[_seen(case, name), name, seed] for seed in range(count))
        for case, name in itertools.product(cases, names)
    }
    return Comparison(cases, names, outcomes)


def run(case: Case, controller: str, seed: int = 0, duration: float = DURATION) -> Outcome:
    """Do one run; the loop is compiled and holds no interpreter lock.

    Parameters
    ----------
    case : Case
        The case.
    controller : str
        One of :data:`CONTROLLERS`.
    seed : int
        Of the robot's mismatch, the noise of measurement and that of the records.
    duration : float
        Length of the run [s].

    Returns
    -------
    Outcome

    Raises
    ------
    InvalidValue, UnknownName, StrokeExceeded
        As from :func:`compare`.
    """
    return _measured(simulate_run(case, controller, seed, duration), case, duration)


def simulate_run(case: Case, controller: str, seed: int = 0, duration: float = DURATION) -> Array:
    """Do a run as :func:`run` does, and return heights, speeds and torque of its samples, (N, 9).

    Fewer if it diverged.
    """
    case.check()
    _check_controller(controller)
    seed = checked_count("seed", seed, 0)
    t, motion = _desired(case.trajectory, checked_positive("duration", duration))
    # One stream for each use of noise, so that runs of one seed can be paired whatever else they
    # draw.
    records, plants, measurements = (np.random.default_rng([seed, use]) for use in range(3))
    robot = _robot()
    plant = mismatched(robot.parameters, MASS_MISMATCH, case.payload, plants).as_array()
    measured = measurements.standard_normal((len(t), 6)) * np.repeat(MEASUREMENT_NOISE, 3)
    wiring = unbounded(PERIOD, np.zeros(3), noise=measured)
    if controller in FUZZY:
        table: NamedTuple = _fuzzy(controller, case.snr_db, records)
    else:
        table = _classical(controller)
    said = step_width(3) - 3 if controller in FUZZY else 0
    track, steps = new_track(t, motion, said), ClosedFormSteps(plant, 1, case.drive)
    state = np.concatenate([motion.heights[0], np.zeros(3)])
    done = compiled_loop(table, steps, wiring, track, state).samples
    return np.concatenate([track.states[:done], track.applied[:done]], axis=1)


def _classical(controller: str) -> Classical:
    """Return a controller without rules as loops take it."""
    model = closed_form_table(_robot().parameters.as_array())
    if controller in REGULATOR_FORCES:
        K = _regulator(controller)
        return classical(FEED_FORWARD, K[:, :3], K[:, 3:], model, Widths.of_motors(3))
    kp, kv = TABLE_6_1["CTC"]
    ki = INTEGRAL_GAIN if controller == "ctc-integral" else 0.0
    return classical(COMPUTED_TORQUE, kp, kv, model, Widths.of_motors(3), ki)


def _measured(samples: Array, case: Case, duration: float) -> Outcome:
    t, motion = _desired(case.trajectory, duration)
    if len(samples) < len(t):
        return Outcome(math.nan, math.nan, math.nan, True)
    squares = ((motion.heights - samples[:, :3]) ** 2).sum(axis=1)
    every = round(THESIS_SAMPLING_PERIOD / PERIOD)
    settled = math.sqrt(float(squares[len(t) // 2 :].mean()))
    return Outcome(
        float(squares[::every].sum()),
        settled,
        float((samples[:, 6:] ** 2).sum(axis=1).mean()),
        False,
    )


def _seen(case: Case, controller: str) -> Case:
    """Return the case as far as it matters to a controller."""
    return (
        case if controller in FUZZY else Case(case.payload, case.trajectory, math.inf, case.drive)
    )


def _check_controller(name: str) -> None:
    if name not in CONTROLLERS:
        raise UnknownName("controller", name, CONTROLLERS)


def _fuzzy(controller: str, snr_db: float, rng: np.random.Generator) -> adaptive_kernels.Adaptive:
    """Return a fuzzy controller as loops take it, trained and not called yet."""
    kp, kv = TABLE_6_1["CTC"]
    variation = float(mean_variation_from_snr(min(snr_db, UNCERTAINTY_SNR)))
    base = FuzzyComputedTorque(
        controller.removeprefix("adaptive-"),
        _robot(),
        kp=kp,
        kv=kv,
        snr_db=snr_db,
        mean_variation=variation,
    )
    adaptive = AdaptiveFuzzyComputedTorque(base.learn(_record(), rng=rng))
    memory = adaptive.settings.memory if controller.startswith("adaptive-") else 0.0
    return adaptive_kernels.Adaptive(
        adaptive.settings._replace(memory=memory),
        adaptive.rules,
        adaptive_kernels.new_memory(adaptive.rules.trained),
    )


# The same for all runs, and more costly than a run.


@lru_cache(maxsize=1)
def _robot() -> PSP3:
    return load("psp3")


@lru_cache(maxsize=1)
def _record() -> Record:
    robot = _robot()
    return record(robot, TRAJECTORIES[FIRST_TRAJECTORY](robot))


@lru_cache(maxsize=8)
def _regulator(controller: str) -> Array:
    state = np.repeat([1.0 / ACCEPTABLE_ERROR**2, 1.0 / ACCEPTABLE_SPEED_ERROR**2], 3)
    force = np.full(3, 1.0 / REGULATOR_FORCES[controller] ** 2)
    return np.ascontiguousarray(
        LinearQuadraticRegulator(_robot(), np.diag(state), np.diag(force), PERIOD).regulator.K
    )


@lru_cache(maxsize=16)
def _desired(trajectory: str, duration: float) -> tuple[Array, Motion]:
    """Return times and the desired motion."""
    robot = _robot()
    t = PERIOD * np.arange(int(duration / PERIOD * (1.0 + 1e-12) + 1e-9) + 1, dtype=np.float64)
    if len(t) < 3:
        raise InvalidValue("duration", duration, f"at least two periods of {PERIOD} s")
    motion = TRAJECTORIES[trajectory](robot)(t)
    check_stroke(robot, t, motion)
    return t, motion
