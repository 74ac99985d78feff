"""Boards of outcomes that are made up, and entries that are exact or wrong on purpose."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from psp3.benchmark.board import Board
from psp3.benchmark.entries import SAMPLES, Course, Entry, of_regressor
from psp3.benchmark.readings import NONE
from psp3.benchmark.tasks import PATHS
from psp3.benchmark.trial import Outcome, Trial
from psp3.checks import Array
from psp3.control.controller import Controller
from psp3.fuzzy_control.numbers import pack

CONDITIONS = ((NONE, np.inf), ("outputs", 20.0))
DURATION, PERIOD = 0.4, 0.004


class Exact:
    """A regressor that knows M, C and G, of a robot whose inputs are told from their number."""

    def __init__(self, robot: Any) -> None:
        self.robot = robot

    def fit(self, X: Array, Y: Array) -> None:
        """Learn nothing."""

    def predict(self, X: Array) -> Array:
        """Return exact outputs: of the 3-PSP at a height of its first nut of 0."""
        n = len(self.robot.reference)
        positions, speeds = np.split(X, 2, axis=1)
        if positions.shape[1] < n:
            zero = np.zeros((len(X), 1))
            positions, speeds = (np.hstack([zero, -part]) for part in (positions, speeds))
        return pack(*self.robot.equation_of_motion(positions, speeds))


def entry_of(name: str, kind: Any, draws: bool = False) -> Entry:
    """Return an entry of a class of regressors that is made with the robot.

    One that ``draws`` has errors of its own for every seed, without noise, too.
    """

    def make(course: Course) -> Controller:
        return of_regressor(kind(course.task.robot), course, name)

    return Entry(name, SAMPLES, make, draws)


def run_of(error: float, fallbacks: float = 0.0) -> dict[str, Any]:
    """Return a run with an error of the tip [m], one that diverged for an infinite one."""
    if not np.isfinite(error):
        return {"diverged": True, "end_time": 0.1}
    return {
        "diverged": False,
        "end_time": DURATION,
        "rms_tip_error": error,
        "largest_tip_error": 2.0 * error,
        "rms_error": error,
        "effort": 3.0,
        "fallbacks": fallbacks,
    }


def outcome_of(errors: Mapping[str, float], fallbacks: float = 0.0) -> Outcome:
    """Return the outcome of a trial with these errors on the two paths [m]."""
    return {
        "error": None,
        "training_time": 0.5,
        "step_time": 2e-5,
        "runs": {path: run_of(error, fallbacks) for path, error in errors.items()},
    }


def board_of(
    errors: Mapping[str, Array],
    problem: tuple[str, str] | None = None,
    fallbacks: Mapping[str, float] | None = None,
) -> Board:
    """Return a board of the 3-PSP.

    ``errors`` holds for each entry errors [m] by condition, seed and path; ``problem`` is an entry
    and what it raised in the first trial; ``fallbacks`` are shares of estimates by entry.
    """
    seeds = next(iter(errors.values())).shape[1]
    outcomes: dict[tuple[str, Trial], Outcome] = {}
    for name, values in errors.items():
        for number, (reading, snr_db) in enumerate(CONDITIONS):
            for seed in range(seeds):
                trial = Trial("psp3", reading, snr_db, seed, DURATION, PERIOD)
                by_path = dict(zip(PATHS, values[number, seed].tolist(), strict=True))
                outcomes[name, trial] = outcome_of(by_path, (fallbacks or {}).get(name, 0.0))
    if problem is not None:
        first = Trial("psp3", *CONDITIONS[0], 0, DURATION, PERIOD)
        outcomes[problem[0], first] = {"error": problem[1]}
    entries = tuple(entry_of(name, Exact, True) for name in errors)
    return Board(entries, outcomes, ("psp3",), CONDITIONS, seeds, DURATION, PERIOD)
