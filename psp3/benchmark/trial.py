"""One trial: an entry learns one robot from one draw of the noise, and runs on both paths."""

from __future__ import annotations

import math
import time
import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np

from fuzzy2.support.one_thread import one_thread
from psp3.benchmark.entries import Course, Entry, said
from psp3.benchmark.readings import NONE, READINGS, lesson, measured_noise
from psp3.benchmark.tasks import PATHS, ROBOTS, SAMPLES, Task, task
from psp3.checks import Array, checked_count, checked_positive, known_name
from psp3.control.controller import Controller
from psp3.errors import InvalidTorque, InvalidValue, SimulationDiverged
from psp3.simulation.metrics import largest_tip_error, rms_error
from psp3.simulation.result import Result
from psp3.simulation.tracking import simulate
from psp3.study.latency import step_times
from psp3.trajectories.motion import Motion

TIMED = 200
"""Number of timed steps of the controller, after the warm-up."""

NOISE, MEASUREMENT, ENTRY = 0, 1, 2
"""Streams of random numbers of a seed: noise on samples, noise at run time, and numbers that an
entry draws. Separate streams give all entries of a seed the same noise.
"""

Outcome = dict[str, Any]


@dataclass(frozen=True)
class Trial:
    """Everything that determines a trial, except the entry.

    Parameters
    ----------
    robot : str
        One of :data:`psp3.benchmark.tasks.ROBOTS`.
    reading : str
        One of :data:`psp3.benchmark.readings.READINGS`, or ``"none"``.
    snr_db : float
        Signal-to-noise ratio [dB]; infinite for none.
    seed : int
        Seed of the noise, and of the numbers that an entry draws.
    duration, period : float
        Length of each run and control period [s].
    """

    robot: str
    reading: str = NONE
    snr_db: float = math.inf
    seed: int = 0
    duration: float = 5.0
    period: float = 0.004

    def check(self) -> None:
        """Raise an error if a field is invalid.

        Raises
        ------
        UnknownName, InvalidValue
            If a name is unknown, or a number is out of range.
        """
        for what, name, known in (
            ("robot of the benchmark", self.robot, ROBOTS),
            ("reading of noise", self.reading, (NONE, *READINGS)),
        ):
            known_name(what, name, known)
        checked_count("seed", self.seed, 0)
        for number in ("duration", "period"):
            checked_positive(number, getattr(self, number))
        if self.duration < self.period:
            raise InvalidValue("duration", self.duration, f"at least a period of {self.period} s")
        if math.isnan(self.snr_db) or (self.snr_db == math.inf) != (self.reading == NONE):
            raise InvalidValue("snr_db", self.snr_db, "finite, and infinite without noise")


def own_trial(entry: Entry, trial: Trial) -> Trial:
    """Return the simplest trial with the same outcome for an entry.

    It differs in noise that the entry does not see, and in a seed that has no effect.
    """
    is_measured = trial.reading != NONE and READINGS[trial.reading].noise is None
    if not (is_measured or entry.learns):
        trial = Trial(trial.robot, NONE, math.inf, trial.seed, trial.duration, trial.period)
    if trial.reading != NONE or entry.draws:
        return trial
    return Trial(trial.robot, NONE, math.inf, 0, trial.duration, trial.period)


class Noisy:
    """A controller that sees noisy positions and speeds.

    Parameters
    ----------
    controller : Controller
        The controller that gets the noisy values.
    noise : (N, 2n) ndarray
        The noise of each call.
    """

    def __init__(self, controller: Controller, noise: Array) -> None:
        self._controller, self._noise, self._calls = controller, noise, 0

    def reset(self) -> None:
        """Start again with the first noise."""
        self._calls = 0
        self._controller.reset()

    def torque(self, t: float, positions: Array, speeds: Array, desired: Motion) -> Array:
        """Return the controller's torque for the noisy values."""
        added, n = self._noise[self._calls], len(positions)
        self._calls += 1
        return self._controller.torque(t, positions + added[:n], speeds + added[n:], desired)


def execute(trial: Trial, entry: Entry) -> Outcome:
    r"""Do a trial.

    Parameters
    ----------
    trial : Trial
        The trial.
    entry : Entry
        The entry that does it.

    Returns
    -------
    dict
        ``error``, None or the error that the entry raised, in one line and then the only key;
        ``training_time``, CPU time of making and training the controller [s]; ``step_time``, median
        time of one step on the trained path, called from Python [s]; ``runs``, for each path a
        dictionary of ``diverged``, ``end_time`` [s], and for runs that did not diverge
        ``rms_tip_error``, ``largest_tip_error`` [m], ``rms_error`` of the positions [m or rad],
        ``effort`` :math:`\int \lVert\tau\rVert^2 dt`, and ``fallbacks``, the share of steps whose
        estimate was replaced.
    """
    trial.check()
    of_robot = task(trial.robot)
    try:
        with one_thread(), warnings.catch_warnings():
            # Warnings of an entry's libraries, for example of a search that has not converged, are
            # ignored, because the score shows their effect.
            warnings.simplefilter("ignore")
            return _done(trial, entry, of_robot)
    except (Exception, SystemExit) as error:
        # An entry is foreign code, so an error that it raises is a result.
        return {"error": said(error)}


def _done(trial: Trial, entry: Entry, of_robot: Task) -> Outcome:
    noise = (trial.seed, NOISE)
    taught = lesson(of_robot, trial.reading, trial.snr_db, np.random.default_rng(noise), SAMPLES)
    own = np.random.default_rng((trial.seed, ENTRY))
    course = Course(of_robot, taught, trial.reading, trial.snr_db, noise, own, trial.period)
    begin = time.process_time()
    controller = entry.make(course)
    training_time = time.process_time() - begin
    t, motion = of_robot.desired(PATHS[0], trial.duration, trial.period)
    some = np.linspace(0, len(t) - 1, TIMED).round().astype(int)
    wanted = Motion(*(array[some] for array in motion))
    steps = step_times(controller, t[some], wanted.positions, wanted.speeds, wanted)
    return {
        "error": None,
        "training_time": training_time,
        "step_time": float(np.median(steps)),
        "runs": {path: _run(trial, controller, of_robot, path) for path in PATHS},
    }


def _run(trial: Trial, controller: Controller, of_robot: Task, path: str) -> Outcome:
    """Let a trained controller track a path; losing the robot is a valid result."""
    t, motion = of_robot.desired(path, trial.duration, trial.period)
    rng = np.random.default_rng((trial.seed, MEASUREMENT))
    noise = measured_noise(of_robot, trial.reading, trial.snr_db, len(t), rng)
    try:
        result = simulate(
            of_robot.robot,
            controller if noise is None else Noisy(controller, noise),
            of_robot.paths[path],
            trial.duration,
            trial.period,
            initial_speeds=motion.speeds[0],
        )
    except SimulationDiverged as end:
        return {"diverged": True, "end_time": end.time}
    except InvalidTorque as end:
        if np.shape(end.torque) != (of_robot.joints,):
            raise
        # Some controllers lose a robot with forces that overflow.
        return {"diverged": True, "end_time": end.time}
    measured = _measured(result)
    # A run whose errors or efforts overflow counts as diverged, even if the robot still has a pose.
    diverged = not np.isfinite(list(measured.values())).all()
    return {
        "diverged": diverged,
        "end_time": float(result.t[-1]),
        **({} if diverged else measured),
    }


def _measured(result: Result) -> dict[str, float]:
    tip = np.linalg.norm(result.desired.tip - result.tip, axis=1)
    return {
        "rms_tip_error": float(np.sqrt((tip**2).mean())),
        "largest_tip_error": largest_tip_error(result),
        "rms_error": rms_error(result),
        "effort": float(np.trapezoid((result.torque**2).sum(axis=1), result.t)),
        "fallbacks": 0.0 if result.fell_back is None else float(result.fell_back.mean()),
    }
