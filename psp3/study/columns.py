"""Runs as columns: values that many runs share are stored once."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator, Mapping, Sequence
from operator import itemgetter
from typing import Any, overload

from psp3.study.run import DEFAULTS, Run, Value, field_types, values_of

AT_A_TIME = 10_000
"""Number of runs that are turned into columns at a time."""

Column = Sequence[Value]


class RunColumns(Sequence[Run]):
    """Many runs, stored field by field; a ``Run`` object is made on access.

    Parameters
    ----------
    columns : mapping of str to sequence
        Values of each field in the order of the runs, or the one value that all runs share. Fields
        that are left out have their defaults.
    count : int
        Number of runs N.

    Attributes
    ----------
    columns : dict of str to sequence
        For every field, N values or one.
    """

    def __init__(self, columns: Mapping[str, Column], count: int) -> None:
        self.columns = {
            name: _shared(columns[name]) if name in columns else (DEFAULTS[name],)
            for name in field_types()
        }
        self._count = count

    @classmethod
    def of(cls, runs: Iterable[Run]) -> RunColumns:
        """Return runs as columns."""
        if isinstance(runs, RunColumns):
            return runs
        rows = list(map(values_of, runs))
        return cls(dict(zip(field_types(), zip(*rows, strict=True), strict=bool(rows))), len(rows))

    @classmethod
    def joined(cls, parts: Sequence[RunColumns]) -> RunColumns:
        """Return the runs of all parts in order; equal values share one object."""
        columns: dict[str, Column] = {}
        for name in field_types():
            firsts = [part.columns[name][:2] for part in parts]
            if parts and all(len(first) == 1 and first == firsts[0] for first in firsts):
                columns[name] = firsts[0]
                continue
            known: dict[Value, Value] = {}
            columns[name] = [
                known.setdefault(value, value) for part in parts for value in part.column(name)
            ]
        return cls(columns, sum(map(len, parts)))

    @property
    def differing(self) -> tuple[str, ...]:
        """Names of the fields whose values differ between runs."""
        return tuple(name for name, column in self.columns.items() if len(column) > 1)

    def column(self, name: str) -> Column:
        """Return the values of a field, (N,)."""
        column = self.columns[name]
        return column if len(column) == self._count else list(column) * self._count

    def taken(self, places: Sequence[int]) -> RunColumns:
        """Return the runs with these indices."""
        taken: dict[str, Column] = dict(self.columns)
        for name in self.differing:
            found: Any = itemgetter(*places)(self.columns[name])
            taken[name] = found if len(places) > 1 else (found,)
        return RunColumns(taken, len(places))

    def changed(self, columns: Mapping[str, Column]) -> RunColumns:
        """Return the same runs with other values of some fields."""
        return RunColumns({**self.columns, **columns}, self._count)

    def __len__(self) -> int:
        return self._count

    def __iter__(self) -> Iterator[Run]:
        columns = (
            itertools.repeat(column[0], self._count) if len(column) == 1 else column
            for column in self.columns.values()
        )
        return itertools.starmap(Run, zip(*columns, strict=True))

    @overload
    def __getitem__(self, index: int) -> Run: ...

    @overload
    def __getitem__(self, index: slice) -> RunColumns: ...

    def __getitem__(self, index: int | slice) -> Run | RunColumns:
        places = range(self._count)[index]
        if isinstance(places, range):
            return self.taken(places)
        values: Any = (
            column[0] if len(column) == 1 else column[places] for column in self.columns.values()
        )
        return Run(*values)


def blocks_of(runs: Iterable[Run]) -> Iterator[RunColumns]:
    """Return runs as columns, :data:`AT_A_TIME` at a time."""
    waiting = iter(runs)
    while block := list(itertools.islice(waiting, AT_A_TIME)):
        yield RunColumns.of(block)


def _shared(column: Column) -> Column:
    """Return the common value of a column if all values are equal, otherwise the column."""
    if len(column) < 2:
        return column
    first = column[0]
    is_one = column.count(first) == len(column) and len(set(map(type, column))) == 1
    return (first,) if is_one else column
