"""Grids: every combination of values of a run's fields, made one at a time."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Sequence
from typing import Any, overload

from psp3.errors import InvalidValue
from psp3.study.columns import AT_A_TIME, RunColumns
from psp3.study.run import Run, Value, values_of_field


class Grid(Sequence[Run]):
    """The runs of every combination of values; made with :func:`grid`.

    A run is made on access, so a million of them take no memory.

    Parameters
    ----------
    choices : dict of list
        The values of each field; the last field varies fastest.
    """

    def __init__(self, choices: dict[str, list[Value]]) -> None:
        self.choices = choices

    def __len__(self) -> int:
        return math.prod(len(values) for values in self.choices.values())

    def __iter__(self) -> Iterator[Run]:
        names = tuple(self.choices)
        for combination in itertools.product(*self.choices.values()):
            yield Run(**dict(zip(names, combination, strict=True)))  # type: ignore[arg-type]

    @overload
    def __getitem__(self, index: int) -> Run: ...

    @overload
    def __getitem__(self, index: slice) -> tuple[Run, ...]: ...

    def __getitem__(self, index: int | slice) -> Run | tuple[Run, ...]:
        if isinstance(index, slice):
            return tuple(self[k] for k in range(*index.indices(len(self))))
        place = index + len(self) if index < 0 else index
        if not 0 <= place < len(self):
            raise IndexError(index)
        chosen: dict[str, Any] = {}
        for name, values in reversed(self.choices.items()):
            place, k = divmod(place, len(values))
            chosen[name] = values[k]
        return Run(**chosen)

    def blocks(self) -> Iterator[RunColumns]:
        """Return the runs as columns, some at a time, without making ``Run`` objects."""
        combinations = itertools.product(*self.choices.values())
        while rows := list(itertools.islice(combinations, AT_A_TIME)):
            columns = zip(*rows, strict=True) if self.choices else ()
            yield RunColumns(dict(zip(self.choices, columns, strict=True)), len(rows))

    def __add__(self, other: Iterable[Run]) -> tuple[Run, ...]:
        return (*self, *other)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Sequence) or isinstance(other, str):
            return NotImplemented
        return len(self) == len(other) and all(map(Run.__eq__, self, other))

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.choices!r})"


def grid(**values: Value | Iterable[Value]) -> Grid:
    """Return the runs of every combination of values of fields.

    Seeds vary slowest, so a study that was stopped holds complete comparisons with fewer seeds.

    Parameters
    ----------
    **values
        One or more values for each field of :class:`~psp3.study.run.Run` that differs from its
        default: ``grid(controller=["t1", "it2"], snr_db=20, seed=range(30))``.

    Returns
    -------
    Grid
        A sequence of runs, one for every combination. :class:`psp3.Study` does equivalent runs,
        which must have the same results, only once.

    Raises
    ------
    UnknownName
        If a run has no such field.
    InvalidValue
        If a field is given no value, or a value of the wrong type.
    """
    choices: dict[str, list[Value]] = {}
    for name in sorted(values, key=lambda name: name != "seed"):
        choices[name] = values_of_field(name, values[name])
        if not choices[name]:
            raise InvalidValue(name, [], "at least one value")
    return Grid(choices)
