"""Memory of kernels on symbols: arrays whose parts share entries, and a journal to undo writes."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np

from psp3.symbolic.numbers import SX, Number, choice, whole

MISSING = object()
"""Placeholder for a variable that has no value yet."""

Answer = TypeVar("Answer")


@dataclass(frozen=True, eq=False)
class Piece:
    """A part of an array, row by row; entries may be symbols, and other parts may share them."""

    cells: list[Number]
    start: int
    shape: tuple[int, ...]

    def is_same(self, other: object) -> bool:
        """Tell whether another piece is the same part of the same array."""
        return (
            isinstance(other, Piece)
            and self.cells is other.cells
            and (self.start, self.shape) == (other.start, other.shape)
        )

    @property
    def size(self) -> int:
        """Number of entries."""
        return math.prod(self.shape)

    def numbers(self) -> list[Number]:
        """Return the entries, row by row."""
        return self.cells[self.start : self.start + self.size]

    def place(self, index: Any) -> int:
        """Return the index of an entry among the cells.

        Raises
        ------
        TypeError
            If the index depends on a symbol.
        IndexError
            If the index is beyond the shape.
        """
        numbers = index if isinstance(index, tuple) else (index,)
        at = 0
        for i, size in zip(numbers, self.shape, strict=True):
            k = whole(i)
            if not 0 <= k < size:
                raise IndexError(k, size)
            at = at * size + k
        return self.start + at

    def part(self, ends: slice) -> Piece:
        """Return a part of a row."""
        (size,) = self.shape
        a, b, _ = ends.indices(size)
        return Piece(self.cells, self.start + a, (max(b - a, 0),))

    def row(self, index: Number) -> Piece:
        """Return a row of a table."""
        rows, columns = self.shape
        k = whole(index)
        if not 0 <= k < rows:
            raise IndexError(k, rows)
        return Piece(self.cells, self.start + k * columns, (columns,))


def piece_of(array: Any) -> Piece:
    """Return a copy of an array of numbers for kernels on symbols."""
    values = np.asarray(array)
    return Piece(values.ravel().tolist(), 0, values.shape)


def piece_with(entries: Sequence[Number]) -> Piece:
    """Return a row of symbols and numbers."""
    return Piece(list(entries), 0, (len(entries),))


def symbols_in(vector: SX) -> Piece:
    """Return the entries of a symbolic matrix, row by row."""
    rows, columns = vector.shape
    entries = [vector[i, j] for i in range(rows) for j in range(columns)]
    return piece_with(entries)


def chosen(condition: SX, one: Any, other: Any) -> Any:
    """Return one value if a condition is true, else the other; both must be of one kind.

    Raises
    ------
    TypeError
        If they are neither numbers nor the same object.
    """
    if one is other:
        return one
    if isinstance(one, tuple) and isinstance(other, tuple):
        parts = [chosen(condition, a, b) for a, b in zip(one, other, strict=True)]
        return type(one)(*parts) if hasattr(one, "_fields") else tuple(parts)
    if isinstance(one, SX | bool | int | float) and isinstance(other, SX | bool | int | float):
        return choice(condition, one, other)
    if isinstance(one, Piece) and one.is_same(other):
        return one
    raise TypeError(f"either {type(one).__name__} or {type(other).__name__}, as a symbol says")


class Changes(dict[tuple[int, Any], tuple[Any, Any, Any]]):
    """Writes to lists and dictionaries, each with its container, its index and a value."""


class Journal:
    """Records writes, so that both ways of a branch can start from the same memory."""

    def __init__(self) -> None:
        self._before: Changes | None = None

    def write(self, container: Any, index: Any, value: Any) -> None:
        """Write an entry of a list or a variable."""
        if self._before is not None:
            key = id(container), index
            if key not in self._before:
                self._before[key] = container, index, _entry(container, index)
        container[index] = value

    def tried(self, run: Callable[[], Answer]) -> tuple[Answer, Changes]:
        """Return the result of a function and its changes, and undo the changes."""
        outer, self._before = self._before, Changes()
        try:
            answer = run()
            before = self._before
        finally:
            self._before = outer
        after = Changes()
        for key, (container, index, old) in before.items():
            after[key] = container, index, _entry(container, index)
            if old is MISSING:
                del container[index]
            else:
                container[index] = old
        return answer, after

    def redo(self, changes: Changes) -> None:
        """Repeat changes that were undone."""
        for container, index, value in changes.values():
            self.write(container, index, value)

    def merged(self, condition: SX, one: Changes, other: Changes) -> Changes:
        """Return the changes of one way if a condition is true, else those of the other."""
        both = Changes()
        for key in dict.fromkeys([*one, *other]):
            container, index, _ = one.get(key) or other[key]
            now = _entry(container, index)
            a = one[key][2] if key in one else now
            b = other[key][2] if key in other else now
            # A variable that only one way sets is not read after the other.
            value = b if a is MISSING else a if b is MISSING else chosen(condition, a, b)
            both[key] = container, index, value
        return both


def _entry(container: Any, index: Any) -> Any:
    return container.get(index, MISSING) if type(container) is dict else container[index]
