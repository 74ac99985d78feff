"""Results of many runs as columns; shared values are stored once, so a row takes 0.1 kB."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any, overload

import numpy as np
from numpy.typing import NDArray

from psp3.checks import Array, as_floats, checked_count, known_name, listed
from psp3.errors import InvalidValue
from psp3.study.columns import RunColumns
from psp3.study.run import METRICS, Run, Value, contents, field_types, values_of_field

Row = dict[str, Any]


class Table(Sequence[Row]):
    """Fields and metrics of many runs, in the order of their settings and seeds.

    A row is a dictionary that is made on access; :meth:`column` gives a whole column.

    Parameters
    ----------
    settings : sequence of Run
        The different settings: runs with seed 0. They are kept as columns.
    setting : (N,) array_like of int
        Index of the setting of each row.
    seeds : (N,) array_like of int
        Seed of each row.
    metrics : (N, K) array_like
        Metrics of each row, in the order of :data:`psp3.simulation.metrics.METRICS`.
    """

    def __init__(self, settings: Sequence[Run], setting: Any, seeds: Any, metrics: Any) -> None:
        self.settings = RunColumns.of(settings)
        self.setting = np.asarray(setting, dtype=np.int32)
        self.seeds = np.asarray(seeds, dtype=np.int64)
        self.metrics = np.asarray(metrics, dtype=float).reshape(len(self.seeds), len(METRICS))

    @classmethod
    def of(cls, rows: Table | Iterable[Mapping[str, Any]]) -> Table:
        """Return a table from rows, mappings with a run's fields and metrics by name."""
        if isinstance(rows, Table):
            return rows
        places: dict[Run, int] = {}
        setting, seeds, metrics = [], [], []
        wanted = "a table, or a list of mappings with the fields of a run and its metrics"
        for row in listed("rows", rows, wanted):
            if not isinstance(row, Mapping) or not set(METRICS) <= row.keys():
                raise InvalidValue("rows", row, wanted)
            run = Run(**{name: row[name] for name in field_types() if name in row})
            setting.append(places.setdefault(replace(run, seed=0), len(places)))
            seeds.append(run.seed)
            metrics.append([row[name] for name in METRICS])
        return cls(tuple(places), setting, seeds, metrics)

    def in_order(self) -> Table:
        """Return the same rows in the order of their settings' fields and their seeds."""
        # Fields that do not differ need no comparison.
        columns = [
            [(value is not None, value) for value in column] if None in column else column
            for column in map(self.settings.columns.__getitem__, self.settings.differing)
        ]
        compared = list(zip(*columns, strict=True)) if columns else [()] * len(self.settings)
        order = sorted(range(len(self.settings)), key=compared.__getitem__)
        rank = np.empty(len(order), dtype=np.int32)
        rank[order] = np.arange(len(order), dtype=np.int32)
        setting = rank[self.setting]
        rows = np.lexsort((self.seeds, setting))
        settings = self.settings.taken(order) if order else self.settings
        return Table(settings, setting[rows], self.seeds[rows], self.metrics[rows])

    def __len__(self) -> int:
        return len(self.seeds)

    @overload
    def __getitem__(self, index: int) -> Row: ...

    @overload
    def __getitem__(self, index: slice) -> Table: ...

    def __getitem__(self, index: int | slice) -> Row | Table:
        if isinstance(index, slice):
            return self.taken(np.arange(len(self))[index])
        values = dict(zip(METRICS, self.metrics[index].tolist(), strict=True))
        return {**contents(self.run(index)), **values}

    def run(self, index: int) -> Run:
        """Return the run of a row; a negative row number counts from the end."""
        least = -len(self)
        if not least <= checked_count("index", index, least) < len(self):
            raise InvalidValue("index", index, f"that of one of the {len(self)} rows")
        setting: Run = self.settings[int(self.setting[index])]
        return replace(setting, seed=int(self.seeds[index]))

    def column(self, name: str) -> NDArray[Any]:
        """Return a field or a metric of all rows, (N,).

        Raises
        ------
        UnknownName
            If there is no such column.
        """
        known_name("column", name, (*field_types(), *METRICS))
        if name in METRICS:
            return np.asarray(self.metrics[:, METRICS.index(name)])
        if name == "seed":
            return self.seeds
        values = np.empty(len(self.settings), dtype=object)
        values[:] = self.settings.column(name)
        return np.asarray(values[self.setting])

    def select(self, **selection: Value | Iterable[Value]) -> Table:
        """Return the rows whose fields have the selected value, or one of the values.

        Raises
        ------
        UnknownName
            If a run has no such field.
        InvalidValue
            If a value is not of the type of its field.
        """
        keep = np.ones(len(self), dtype=bool)
        for name, given in selection.items():
            wanted = set(values_of_field(name, given))
            if name == "seed":
                keep &= np.isin(self.seeds, [seed for seed in wanted if isinstance(seed, int)])
            else:
                fits = np.array([value in wanted for value in self.settings.column(name)], bool)
                keep &= fits[self.setting]
        return self.taken(np.flatnonzero(keep))

    def groups(self) -> list[tuple[Run, NDArray[np.intp]]]:
        """Return each setting and the indices of its rows, in the order of the rows."""
        if not len(self):
            return []
        order = np.argsort(self.setting, kind="stable")
        numbers, first = np.unique(self.setting[order], return_index=True)
        parts = np.split(order, first[1:])
        found = sorted(zip(numbers, parts, strict=True), key=lambda pair: int(pair[1][0]))
        return [(self.settings[number], part) for number, part in found]

    def values(self, metric: str) -> Array:
        """Return a metric of all rows, (N,); NaN for rows that diverged.

        The metrics of a diverged run, such as its effort, cover a shorter time and are not
        comparable.
        """
        if metric == "diverged":
            return self.column(metric)
        return np.where(self.column("diverged") > 0.0, np.nan, self.column(metric))

    def taken(self, rows: NDArray[np.intp]) -> Table:
        """Return the rows with these indices.

        Raises
        ------
        InvalidValue
            If an index is not a whole number, or there is no such row.
        """
        given = as_floats("rows", rows, "(N,)")
        is_row = given.ndim == 1 and np.ndim(rows) == 1 and np.asarray(rows).dtype.kind in "iu"
        places = given.astype(np.intp) if is_row else given
        if not is_row or not ((places >= 0) & (places < len(self))).all():
            raise InvalidValue("rows", rows, f"a list of whole numbers from 0 to {len(self) - 1}")
        return Table(self.settings, self.setting[places], self.seeds[places], self.metrics[places])
