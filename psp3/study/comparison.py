"""Compare controllers in several cases, seed by seed."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from psp3.checks import Array
from psp3.errors import InvalidValue
from psp3.study.run import Run
from psp3.study.statistics import Estimate, check_metric, mean, ratio_of_means, share
from psp3.study.table import Table


@dataclass(frozen=True)
class Row:
    """Statistics of one case under one controller, over its seeds.

    Parameters
    ----------
    case : Run
        The case.
    controller : str
        Name of the controller.
    mean : Estimate
        Mean of the metric over the seeds that did not diverge, with its 95 % interval.
    diverged : Estimate
        Share of the runs that diverged.
    """

    case: Run
    controller: str
    mean: Estimate
    diverged: Estimate


class Comparison:
    """Results of controllers in cases.

    Parameters
    ----------
    cases : sequence of Run
        What runs of different controllers and seeds have in common: runs whose controller and seed
        are ignored.
    controllers : sequence of str
        Names of the controllers.
    seeds : int
        Number of seeds, from 0 on.
    table : Table
        Results of all runs in canonical form; a run that does not depend on the seed is there once.
    """

    def __init__(
        self, cases: Sequence[Run], controllers: Sequence[str], seeds: int, table: Table
    ) -> None:
        self.cases, self.controllers, self.seeds = tuple(cases), tuple(controllers), seeds
        self.table = table
        self._rows = {
            (setting, int(seed)): int(place)
            for setting, places in table.groups()
            for place, seed in zip(places, table.seeds[places], strict=True)
        }

    def values(self, case: Run, controller: str, metric: str = "sum_of_squared_errors") -> Array:
        """Return a metric for all seeds, (seeds,); NaN where a run diverged.

        Raises
        ------
        UnknownName
            If there is no such metric.
        InvalidValue
            If the case or the controller is not part of this comparison.
        """
        check_metric(metric)
        runs = (
            replace(case, controller=controller, seed=seed).canonical()
            for seed in range(self.seeds)
        )
        try:
            places = [self._rows[replace(run, seed=0), run.seed] for run in runs]
        except KeyError:
            raise InvalidValue(
                "case and controller", (str(case), controller), "one that was compared"
            ) from None
        found: Array = self.table.values(metric)[places]
        return found

    def rows(self, metric: str = "sum_of_squared_errors") -> list[Row]:
        """Return a row for every case and controller."""
        return [
            Row(
                case,
                name,
                mean(self.values(case, name, metric)),
                share(self.values(case, name, "diverged")),
            )
            for case, name in itertools.product(self.cases, self.controllers)
        ]

    def ratio(
        self, case: Run, controller: str, baseline: str, metric: str = "sum_of_squared_errors"
    ) -> Estimate:
        """Return the ratio of a controller's mean to that of another one.

        The interval pairs the runs of equal seed.
        """
        return ratio_of_means(
            self.values(case, controller, metric), self.values(case, baseline, metric)
        )

    def best(self, case: Run, metric: str = "sum_of_squared_errors") -> tuple[str, ...]:
        """Return the controller with the smallest mean, and those not shown to be worse.

        Controllers that diverged in any run are left out.
        """
        safe = [name for name in self.controllers if not self.values(case, name, "diverged").any()]
        if not safe:
            return ()
        first = min(safe, key=lambda name: float(self.values(case, name, metric).mean()))
        return first, *(
            name
            for name in safe
            if name != first and not self.ratio(case, name, first, metric).low > 1.0
        )

    def markdown(self, metric: str = "settled_error", scale: float = 1e3) -> str:
        """Return a table of means, a line for each case and a column for each controller.

        The :meth:`best` controllers are bold.
        """
        lines = self._heading(self.controllers)
        for case in self.cases:
            best, cells = self.best(case, metric), []
            for name in self.controllers:
                text = f"{scale * mean(self.values(case, name, metric)).value:.3g}"
                lost = int(self.values(case, name, "diverged").sum())
                cells.append(
                    (f"**{text}**" if name in best else text)
                    + (f", {lost} diverged" if lost else "")
                )
            lines.append(self._line(case, cells))
        return "\n".join(lines)

    def ratios(self, pairs: Sequence[tuple[str, str]], metric: str = "settled_error") -> str:
        """Return a table of :meth:`ratio` with its intervals.

        A line for each case and a column for each pair of controllers.
        """
        lines = self._heading([f"{controller} / {baseline}" for controller, baseline in pairs])
        for case in self.cases:
            found = (
                self.ratio(case, controller, baseline, metric) for controller, baseline in pairs
            )
            cells = [f"{one.value:.3g} ({one.low:.3g} to {one.high:.3g})" for one in found]
            lines.append(self._line(case, cells))
        return "\n".join(lines)

    def in_words(self, case: Run) -> str:
        """Describe a case in words."""
        driven = ", driven" if case.coulomb_friction or case.viscous_friction else ""
        words = f"{case.payload:g} kg, {_path(case)}, {records_in_words(case)}{driven}"
        return words if self._one_robot else f"{case.robot}, {words}"

    @property
    def _one_robot(self) -> bool:
        return len({case.robot for case in self.cases}) == 1

    def _heading(self, columns: Sequence[str]) -> list[str]:
        names = ["kg", "path", "records", *columns]
        if not self._one_robot:
            names.insert(0, "robot")
        return ["| " + " | ".join(names) + " |", "|---" * len(names) + "|"]

    def _line(self, case: Run, cells: Sequence[str]) -> str:
        records = "exact" if case.snr_db == math.inf else f"{case.snr_db:g} dB"
        names = [f"{case.payload:g}", _path(case), records, *cells]
        if not self._one_robot:
            names.insert(0, case.robot)
        return "| " + " | ".join(names) + " |"


def records_in_words(case: Run) -> str:
    """Describe in words the records that the rules of a case are learned from."""
    return "exact records" if case.snr_db == math.inf else f"records of {case.snr_db:g} dB"


def _path(case: Run) -> str:
    return str(case.canonical().trajectory)
