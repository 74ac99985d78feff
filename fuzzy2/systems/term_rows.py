"""Terms of a system as rows of numbers, and the data that does not fit into a row."""

from __future__ import annotations

from typing import Any

import numpy as np

from fuzzy2.sets.interval_type2 import IntervalType2Set
from fuzzy2.sets.type1 import SampledSet
from fuzzy2.support.checks import Array
from fuzzy2.systems.firing_kernels import HEADER, TERM
from fuzzy2.systems.shape_kernels import PAIR, SAMPLES


class TermRows:
    """Rows of the terms of a system, in order; the table of the system begins with them.

    Samples, and the two membership functions of a pair, are appended at the end of the table. A row
    holds their places, see :mod:`fuzzy2.systems.shape_kernels`.
    """

    def __init__(self) -> None:
        self.rows: list[tuple[float, ...]] = []
        self._behind: list[float] = []
        # Places that are relative to the beginning of the appended data, in rows and in the
        # appended data.
        self._in_rows: list[tuple[int, int]] = []
        self._in_behind: list[int] = []

    def add(self, number: int, term: Any, row: tuple[float, ...] | None) -> bool:
        """Add a term of an input with its kernel row, if known; return whether there is a row."""
        if row is None and isinstance(term, SampledSet):
            row = self._sampled(term)
            self._in_rows.append((len(self.rows), 2))
        elif row is None and isinstance(term, IntervalType2Set):
            places = [self._function(part) for part in (term.lower, term.upper)]
            if None in places:
                return False
            row = (float(PAIR), *map(float, places), *[0.0] * 6)  # type: ignore[arg-type]
            self._in_rows += [(len(self.rows), 2), (len(self.rows), 3)]
        if row is None:
            return False
        self.rows.append((float(number), *row))
        return True

    def _sampled(self, item: SampledSet) -> tuple[float, ...]:
        start = len(self._behind)
        self._behind += [*item.points.tolist(), *item.grades.tolist()]
        return (float(SAMPLES), float(start), float(len(item)), *[0.0] * 6)

    def _function(self, item: Any) -> int | None:
        """Append a membership function and return its place; None if it has no row."""
        row = item.kernel_row()
        refers = row is None and isinstance(item, SampledSet)
        if refers:
            row = self._sampled(item)
        if row is None or (row[0] == 0.0 and row[1] != row[2]):
            return None
        place = len(self._behind)
        self._behind += [0.0, *row]
        if refers:
            self._in_behind.append(place + 2)
        return place

    def appended(self, table: Array) -> Array:
        """Return a table that begins with these rows, followed by the appended data."""
        if not self._behind:
            return table
        behind = np.array(self._behind)
        behind[self._in_behind] += table.size
        table = table.copy()
        for t, column in self._in_rows:
            table[HEADER + TERM * t + column] += table.size
        return np.concatenate([table, behind])
