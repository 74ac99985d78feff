"""The runs that the replication of chapter 6 needs, and their outcomes in words."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from psp3.checks import Array
from psp3.study import statistics
from psp3.study.grids import grid
from psp3.study.intervals import coverage_in_words
from psp3.study.paths import TRAJECTORIES
from psp3.study.run import Run
from psp3.study.statistics import Estimate
from psp3.study.table import Row, Table
from psp3.thesis.findings import with_interval

LABELS = {
    "feed-forward": "feed-forward",
    "pd": "PD",
    "pd-gravity": "PD with gravity",
    "ctc": "CTC",
    "t1": "type-1",
    "it2": "type-2",
    "gt2": "general type-2",
}
"""Controllers as tables name them."""

FUZZY = ("t1", "it2", "gt2")

LEARNERS = {
    "strongest": "strongest sample",
    "average": "weighted average",
    "strict": "table look-up of Wang and Mendel",
    "ridge": "ridge",
}
"""Learners as tables name them; the first is the default, the third is the one that the thesis
cites.
"""

DEFINITIONS: dict[str, dict[str, str]] = {
    "mean square of each entry (taken here)": {},
    "variance of each entry": {"snr_reference": "variance"},
    "1 in each unit (0 dBW)": {"snr_reference": "unit"},
    "mean square, on the recorded inputs": {"reading": "inputs"},
    "mean square, on G alone": {"noisy_entries": "gravity"},
    "mean square, on M and C alone": {"noisy_entries": "mass-coriolis"},
}
"""Definitions of the power that "noise of S dB" refers to, as tables name them, with their fields
of a run; the first is the default.
"""

READINGS = {
    "measurement": "noise on measured heights and speeds",
    "online": "noise on M, C and G at run time",
    "plant": "masses and inertias off, unknown payload",
}
"""The other readings of noise besides the default one, as tables name them."""

NOISY = (20.0, 15.0, 10.0)
"""Finite signal-to-noise ratios of Table 6.3 [dB]."""

NOISIER = (5.0, 0.0)
"""Signal-to-noise ratios below those of the thesis [dB], at which controllers may break."""

MOST_SWEEP_SEEDS = 10
"""Seeds of the comparisons that the thesis never showed."""

ERROR = "sum_of_squared_errors"


@dataclass(frozen=True)
class Plan:
    """The choice of runs.

    Parameters
    ----------
    seeds : int
        Seeds of Table 6.3 and of the comparison of learners.
    sweep_seeds : int
        Seeds of everything else.
    sweep_levels : tuple of float
        Signal-to-noise ratios of everything else [dB], besides none.
    variations : tuple of float
        Mean variations that are tried, as shares of each input's range.
    terms : tuple of int
        Numbers of terms of each input that are tried.
    widths : tuple of float
        Factors of the standard deviation of type-1 terms that are tried.
    suited : tuple of float
        Mean variations from which each definition of the noise gets its best one.
    trajectories : tuple of str
        Names of the trajectories, that of the training first.
    """

    seeds: int
    sweep_seeds: int
    sweep_levels: tuple[float, ...] = NOISY
    variations: tuple[float, ...] = (0.05, 0.1, 0.2, 0.3, 0.4, 0.6)
    terms: tuple[int, ...] = (2, 3, 4)
    widths: tuple[float, ...] = (1.5, 2.0, 3.0)
    suited: tuple[float, ...] = (0.02, 0.05, 0.2, 0.4, 0.6)
    trajectories: tuple[str, ...] = tuple(TRAJECTORIES)

    @classmethod
    def of(cls, seeds: int, quick: bool = False) -> Plan:
        """Return the full plan, or a short one that only checks that everything works.

        The short one takes seconds.
        """
        if quick:
            few = min(seeds, 2)
            return cls(
                few,
                few,
                sweep_levels=(20.0,),
                variations=(0.1, 0.4),
                terms=(2, 3),
                widths=(2.0,),
                suited=(0.05, 0.2),
                trajectories=("helix", "circle"),
            )
        return cls(seeds, min(seeds, MOST_SWEEP_SEEDS))

    def runs(self) -> tuple[Run, ...]:
        """Return all runs; the study does runs with the same canonical form once."""
        all_seeds, seeds = range(self.seeds), range(self.sweep_seeds)
        levels, classical = (math.inf, *self.sweep_levels), ("pd", "pd-gravity", "ctc")
        return (
            *grid(controller=classical),
            *grid(controller=FUZZY, snr_db=(math.inf, *NOISY), seed=all_seeds),
            *grid(controller=FUZZY, learner=LEARNERS, snr_db=levels, seed=all_seeds),
            *grid(controller=FUZZY, learner=("strongest", "average"), snr_db=NOISIER, seed=seeds),
            *grid(
                controller=(*classical, *FUZZY),
                reading=READINGS,
                snr_db=self.sweep_levels,
                seed=seeds,
            ),
            *self.of_definitions(),
            *grid(controller="t1", term_width=self.widths, snr_db=levels, seed=all_seeds),
            *grid(
                controller="t1",
                learner="average",
                term_width=self.widths,
                snr_db=levels,
                seed=seeds,
            ),
            *grid(controller="it2", mean_variation=self.variations, snr_db=levels, seed=seeds),
            *grid(
                controller=("t1", "it2"),
                learner="strict",
                n_terms=self.terms,
                snr_db=levels,
                seed=seeds,
            ),
            *grid(controller=("feed-forward", *classical, *FUZZY), trajectory=self.trajectories),
            *grid(controller="t1", trajectory=self.trajectories, learner="ridge"),
            *grid(controller=("t1", "it2"), trajectory=self.trajectories, snr_db=20.0, seed=seeds),
        )

    def seeds_of(self, definition: str) -> int:
        """Return the seeds of a definition of the noise: all of them for the default one."""
        return self.seeds if not DEFINITIONS[definition] else self.sweep_seeds

    def of_definitions(self) -> tuple[Run, ...]:
        """Return the runs of type-1 and type-2 under every definition of the noise."""
        runs: list[Run] = []
        for label, fields in DEFINITIONS.items():
            of_all: dict[str, Any] = {"snr_db": self.sweep_levels, **fields}
            runs += grid(controller=("t1", "it2"), seed=range(self.seeds_of(label)), **of_all)
            runs += grid(
                controller="it2",
                mean_variation=self.suited,
                seed=range(self.sweep_seeds),
                **of_all,
            )
        return tuple(runs)


class Outcomes:
    """Results of the study by run.

    Parameters
    ----------
    rows : Table or iterable of Row
        From :meth:`psp3.Study.rows`.
    """

    def __init__(self, rows: Table | Iterable[Row]) -> None:
        self._table = Table.of(rows)
        self._places = {
            (setting, seed): place
            for setting, places in self._table.groups()
            for place, seed in zip(places.tolist(), self._table.seeds[places].tolist(), strict=True)
        }

    def values(self, run: Run, seeds: int, metric: str = ERROR) -> Array:
        """Return the values of a run's metric, one for each seed.

        A run without noise does not depend on the seed and has one value.
        """
        if run.canonical().snr_db == math.inf:
            seeds = 1
        places = []
        for seed in range(seeds):
            one = replace(run, seed=seed).canonical()
            places.append(self._places[replace(one, seed=0), one.seed])
        found: Array = self._table.column(metric)[places]
        return found

    def mean(self, run: Run, seeds: int, metric: str = ERROR) -> Estimate:
        """Return the mean over the seeds that did not diverge."""
        return statistics.mean(self.values(run, seeds, metric))

    def average(self, run: Run, seeds: int, metric: str = "diverged") -> float:
        """Return the average over all seeds; for a metric that is 0 or 1, this is the share."""
        return float(self.values(run, seeds, metric).mean())

    def difference(self, run: Run, controller: str, seeds: int) -> Estimate:
        """Return the mean difference of the errors by seed, controller minus type-1."""
        return statistics.paired_difference(*self._pair(run, controller, seeds))

    def ratio(self, run: Run, controller: str, seeds: int, inverse: bool = False) -> Estimate:
        """Return the ratio of the mean errors over the same seeds.

        It is that of the controller over type-1, or the inverse.
        """
        pair = self._pair(run, controller, seeds)
        return statistics.ratio_of_means(*(pair[::-1] if inverse else pair))

    def typical_ratio(self, run: Run, controller: str, seeds: int) -> Estimate:
        """Return the ratio of the geometric means over the same seeds, for typical runs."""
        return statistics.ratio_of_geometric_means(*self._pair(run, controller, seeds))

    def spread(self, run: Run, seeds: int) -> tuple[float, float]:
        """Return the 2.5 and 97.5 % points of single runs' errors, of those that did not diverge.

        A printed number is a single run, so it is compared with this spread.
        """
        return _spread(self.values(run, seeds))

    def spread_of_ratios(self, run: Run, controller: str, seeds: int) -> tuple[float, float]:
        """Return the 2.5 and 97.5 % points of the controller's error over type-1's by seed."""
        first, second = self._pair(run, controller, seeds)
        return _spread(first / second)

    def wins(self, run: Run, other: Run, seeds: int) -> tuple[int, int]:
        """Return the number of seeds with which a run has less error than another, and of how many.

        Seeds with which either diverged are not counted.
        """
        first, second = self.values(run, seeds), self.values(other, seeds)
        both = np.isfinite(first) & np.isfinite(second)
        return int((first[both] < second[both]).sum()), int(both.sum())

    def shown(self, run: Run, seeds: int) -> str:
        """Return the mean error with its interval, as tables show it.

        If runs diverged, their share is added.
        """
        return with_share(self.mean(run, seeds), self.average(run, seeds))

    def _pair(self, run: Run, controller: str, seeds: int) -> tuple[Array, Array]:
        return tuple(
            self.values(replace(run, controller=name), seeds) for name in (controller, "t1")
        )  # type: ignore[return-value]


def _spread(values: Array) -> tuple[float, float]:
    finite = values[np.isfinite(values)]
    if len(finite) < 2:
        return math.nan, math.nan
    low, high = np.percentile(finite, (2.5, 97.5))
    return float(low), float(high)


def won(wins: int, of: int) -> str:
    """Return the number and share of seeds that a controller won, as tables show it."""
    return f"{wins} of {of}, {percent(wins / of)}" if of else "–"


def decibels(snr_db: float) -> str:
    """Return a signal-to-noise ratio as tables show it."""
    return "∞" if math.isinf(snr_db) else f"{snr_db:g}"


def count(seeds: int) -> str:
    """Return the number of seeds in words."""
    return f"{seeds} seed{'' if seeds == 1 else 's'}"


def listed(words: Sequence[str]) -> str:
    """Return words as a list in a sentence."""
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}"


def percent(share: float) -> str:
    """Return a share in percent."""
    return f"{100.0 * share:.0f} %"


def with_share(average: Estimate, diverged: float) -> str:
    """Return an estimate with its interval, and the share of runs that diverged."""
    return with_interval(average) + share_diverged(diverged)


def in_brackets(seeds: Iterable[int], *estimands: str) -> str:
    """Return the note below a table with intervals: their estimands and measured coverage.

    The coverage depends on the number of seeds, of which there may be several.
    """
    held = dict.fromkeys(coverage_in_words(*estimands, seeds=one) for one in seeds)
    return f"In brackets 95 % intervals; {'; '.join(held)}."


def share_diverged(share: float) -> str:
    """Return the share of runs that diverged, in words; nothing if none did."""
    return f", {percent(share)} diverged" if share > 0.0 else ""


Series = dict[str, dict[float, tuple[float, float, float]]]
