r"""Scores of the entries with intervals, and their order on the board.

A *cell* is a robot on a path under a reading of noise at a ratio. The error of a run is the root
mean square of the tip's distance from its desired position, but at most the extent of the path,
which is the largest distance between two of its points. A run that diverged counts as this extent,
so losing the robot is no better than never moving it. The score of a seed is the geometric mean of
the errors over all cells,

.. math:: s_k = \exp \frac{1}{C} \sum_c \ln \min(e_{ck}, d_c),

so every cell has the same weight, whatever its size. The score of an entry is the geometric mean
over the seeds, and entries are ordered by score. Two entries are compared seed by seed, because
runs of one seed have the same noise: the interval of the ratio is Student's, on logarithms
(:func:`psp3.study.statistics.ratio_of_geometric_means`). Each interval is for one comparison; of
twenty, one is expected to miss.

A run that does not depend on the seed is done once. Intervals and shares count it once, and only
the scores of the seeds use it for every seed.

An entry that raised an error in any trial has no score and no place.
"""

from __future__ import annotations

import math
import os
import platform
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from fuzzy2.support.described import Described
from fuzzy2.support.plain_data import plain
from psp3.benchmark.baselines import REFERENCE
from psp3.benchmark.entries import Entry
from psp3.benchmark.readings import NONE, READINGS
from psp3.benchmark.tasks import PATHS, SAMPLES, task
from psp3.benchmark.trial import Outcome, Trial, own_trial
from psp3.checks import Array, known_name
from psp3.errors import InvalidValue
from psp3.study.statistics import Estimate, ratio_of_geometric_means, share
from psp3.version import __version__

FORMAT = "psp3-benchmark-1"
"""Format mark of the numbers of a board."""


class Cell(NamedTuple):
    """A robot, a path, a reading of noise and its ratio [dB]."""

    robot: str
    path: str
    reading: str
    snr_db: float


class CellScore(NamedTuple):
    """An entry's result in a cell: its ``error`` [m], and the share of runs that ``diverged``."""

    error: Estimate
    diverged: Estimate


@dataclass(frozen=True)
class Score:
    """The result of an entry over all cells.

    Parameters
    ----------
    entry : Entry
        The entry.
    problem : str
        The first error that it raised, or that trials are missing; empty if it has a place.
    error : Estimate
        Geometric mean over all cells [m], see :mod:`psp3.benchmark.board`.
    to_best, to_reference : Estimate
        Ratio of its error to that of the best entry, and to that of exact computed torque.
    diverged : float
        Share of the runs of a cell that diverged, mean over the cells.
    replaced : float
        Share of estimates that the average of the samples replaced, because they were not finite or
        their M was not positive definite; over runs that did not diverge.
    step_time, training_time : float
        Medians over the trials [s].
    effort : float
        Geometric mean of the effort over that of exact computed torque, over runs that did not
        diverge.
    cells : dict of CellScore
        By cell.
    """

    entry: Entry
    problem: str
    error: Estimate
    to_best: Estimate
    to_reference: Estimate
    diverged: float
    replaced: float
    step_time: float
    training_time: float
    effort: float
    cells: dict[Cell, CellScore]


class Board(Described):
    """Scores of entries.

    Parameters
    ----------
    entries : tuple of Entry
        The entries that took part.
    outcomes : mapping of (str, Trial) to dict
        Outcomes by the name of the entry and its own trial
        (:func:`psp3.benchmark.trial.own_trial`), see :func:`psp3.benchmark.trial.execute`.
    robots : tuple of str
        Names of the robots.
    conditions : tuple of (str, float)
        Readings of noise with their ratios.
    seeds : int
        Number of seeds.
    duration, period : float
        Length of a run and control period [s].
    """

    def __init__(
        self,
        entries: tuple[Entry, ...],
        outcomes: Mapping[tuple[str, Trial], Outcome],
        robots: tuple[str, ...],
        conditions: tuple[tuple[str, float], ...],
        seeds: int,
        duration: float,
        period: float,
    ) -> None:
        self.entries, self.robots, self.conditions = entries, robots, conditions
        self.seeds, self.duration, self.period = seeds, duration, period
        self._outcomes = outcomes
        self._named = {entry.name: entry for entry in entries}
        self.cells = tuple(
            Cell(robot, path, *condition)
            for robot in robots
            for condition in conditions
            for path in PATHS
        )

    def _facts(self) -> dict[str, Any]:
        return {
            "entries": tuple(entry.name for entry in self.entries),
            "robots": self.robots,
            "seeds": self.seeds,
            "duration": f"{self.duration:g} s",
        }

    def extent(self, cell: Cell) -> float:
        """Return the largest error of a cell [m], with which a diverged run counts.

        Raises
        ------
        InvalidValue
            If it is not a cell of this board.
        """
        if not isinstance(cell, tuple) or cell not in self.cells:
            raise InvalidValue("cell", cell, "one of the cells of this board")
        return task(cell.robot).extent(cell.path, self.duration, self.period)

    @cached_property
    def scores(self) -> tuple[Score, ...]:
        """Scores in the order of their places, then those without a place."""
        by_seed = self._by_seed
        whole = [entry for entry in self.entries if np.isfinite(by_seed[entry.name]).all()]
        whole.sort(key=lambda entry: float(np.log(by_seed[entry.name]).mean()))
        others = [entry for entry in self.entries if entry not in whole]
        best = whole[0].name if whole else REFERENCE
        return tuple(self._score(entry, best) for entry in (*whole, *others))

    def ratio(self, name: str, other: str) -> Estimate:
        """Return the score of an entry over that of another one, paired by seed.

        It is NaN if one of the two did not do all trials.

        Raises
        ------
        UnknownName
            If there is no such entry.
        """
        for one in (name, other):
            known_name("entry", one, [REFERENCE, *(entry.name for entry in self.entries)])
        return ratio_of_geometric_means(self._whole(name), self._whole(other))

    def _whole(self, name: str) -> Array:
        """Return the scores of all seeds of an entry, NaN if one is missing."""
        found = self._by_seed.get(name)
        is_whole = found is not None and bool(np.isfinite(found).all())
        return found if found is not None and is_whole else np.full(self.seeds, np.nan)

    @cached_property
    def _all_errors(self) -> dict[str, dict[Cell, Array]]:
        return {entry.name: self._errors(entry.name) for entry in self.entries}

    @cached_property
    def _by_seed(self) -> dict[str, Array]:
        """Scores of the seeds of every entry, (N,) each [m]."""
        return {
            name: np.exp(np.mean([np.log(row) for row in rows.values()], axis=0))
            for name, rows in self._all_errors.items()
        }

    @property
    def ranked(self) -> tuple[Score, ...]:
        """Scores of the entries that have a place, best first."""
        return tuple(score for score in self.scores if not score.problem)

    def _trials(self, name: str, cell: Cell) -> list[Trial]:
        """Return the trial of each seed; the same one if it does not depend on the seed."""
        return [
            own_trial(
                self._named[name],
                Trial(cell.robot, cell.reading, cell.snr_db, seed, self.duration, self.period),
            )
            for seed in range(self.seeds)
        ]

    def _each_once(self, name: str, cell: Cell, by_seed: Array) -> Array:
        """Return the numbers of a cell's runs, without copies."""
        trials = self._trials(name, cell)
        return by_seed[[trials.index(trial) for trial in dict.fromkeys(trials)]]

    def _per_seed(self, name: str, cell: Cell, value: Callable[[dict[str, Any]], float]) -> Array:
        """Return a number of each seed's run, NaN if there is none."""
        if name not in self._named:
            return np.full(self.seeds, np.nan)
        found = (self._outcomes.get((name, trial)) for trial in self._trials(name, cell))
        return np.array(
            [
                math.nan
                if outcome is None or outcome["error"]
                else value(outcome["runs"][cell.path])
                for outcome in found
            ]
        )

    def _errors(self, name: str) -> dict[Cell, Array]:
        """Return the error of each seed in every cell [m]."""
        found = {}
        for cell in self.cells:
            most = self.extent(cell)
            found[cell] = self._per_seed(
                name,
                cell,
                lambda run, most=most: (  # type: ignore[misc]
                    most if run["diverged"] else min(run["rms_tip_error"], most)
                ),
            )
        return found

    def _score(self, entry: Entry, best: str) -> Score:
        name = entry.name
        lost = {
            cell: self._per_seed(name, cell, lambda run: float(run["diverged"]))
            for cell in self.cells
        }
        replaced = [
            self._per_seed(name, cell, lambda run: run.get("fallbacks", math.nan))
            for cell in self.cells
        ]
        efforts = [self._efforts(name, cell) for cell in self.cells]
        of_trials = [
            outcome
            for (who, _), outcome in self._outcomes.items()
            if who == name and not outcome["error"]
        ]
        own = self._whole(name)
        return Score(
            entry,
            self._problem(name, own),
            ratio_of_geometric_means(own, np.ones_like(own)),
            self.ratio(name, best),
            self.ratio(name, REFERENCE),
            _mean(np.concatenate(list(lost.values()))),
            _mean(np.concatenate(replaced)),
            _median([outcome["step_time"] for outcome in of_trials]),
            _median([outcome["training_time"] for outcome in of_trials]),
            float(np.exp(_mean(np.log(np.concatenate(efforts))))),
            {
                cell: self._cell_score(name, cell, row, lost[cell])
                for cell, row in self._all_errors[name].items()
            },
        )

    def _cell_score(self, name: str, cell: Cell, errors: Array, lost: Array) -> CellScore:
        error, diverged = (self._each_once(name, cell, row) for row in (errors, lost))
        return CellScore(
            ratio_of_geometric_means(error, np.ones_like(error)),
            share(diverged[np.isfinite(diverged)]),
        )

    def _efforts(self, name: str, cell: Cell) -> Array:
        """Return the effort of each seed over that of exact computed torque."""
        mine, exact = (
            self._per_seed(one, cell, lambda run: run.get("effort", math.nan))
            for one in (name, REFERENCE)
        )
        return mine / exact

    def _problem(self, name: str, by_seed: Array) -> str:
        if np.isfinite(by_seed).all():
            return ""
        for (who, trial), outcome in self._outcomes.items():
            if who == name and outcome["error"]:
                return f"{trial.robot}: {outcome['error']}"
        return "not all of its trials are done"

    def as_numbers(self) -> dict[str, Any]:
        """Return the board as data in the form of ``schema.json`` beside this module.

        Numbers that are missing or not finite are None.
        """
        content = {
            "format": FORMAT,
            "versions": {"psp3": __version__, "python": platform.python_version()},
            "machine": {"system": platform.platform(), "cores": os.cpu_count()},
            "settings": {
                "robots": self.robots,
                "paths": PATHS,
                "readings": {
                    name: READINGS[name].title for name, _ in self.conditions if name != NONE
                },
                "levels": [
                    {"reading": reading, "snr_db": snr_db} for reading, snr_db in self.conditions
                ],
                "seeds": self.seeds,
                "samples": SAMPLES,
                "duration": self.duration,
                "period": self.period,
            },
            "entries": [
                self._entry(place, score) for place, score in enumerate(self.scores, start=1)
            ],
        }
        found: dict[str, Any] = plain(content)
        return found

    def _entry(self, place: int, score: Score) -> dict[str, Any]:
        return {
            "place": None if score.problem else place,
            "name": score.entry.name,
            "knows": score.entry.knows,
            "problem": score.problem or None,
            "error": _as_numbers(score.error),
            "to_best": _as_numbers(score.to_best),
            "to_reference": _as_numbers(score.to_reference),
            "diverged": score.diverged,
            "replaced": score.replaced,
            "step_time": score.step_time,
            "training_time": score.training_time,
            "effort": score.effort,
            "cells": [
                {
                    **cell._asdict(),
                    "error": _as_numbers(one.error),
                    "diverged": _as_numbers(one.diverged),
                }
                for cell, one in score.cells.items()
            ],
        }


def _as_numbers(estimate: Estimate) -> dict[str, float | int]:
    return {
        "value": estimate.value,
        "low": estimate.low,
        "high": estimate.high,
        "seeds": estimate.count,
    }


def _mean(values: Array) -> float:
    finite = values[np.isfinite(values)]
    return float(finite.mean()) if len(finite) else math.nan


def _median(values: list[float]) -> float:
    return float(np.median(values)) if values else math.nan
