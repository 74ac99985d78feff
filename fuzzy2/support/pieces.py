"""Rows of a batch piece by piece, so that Ctrl-C is heard within a second.

Compiled code does not hear it: Python does, between two calls. What a row costs depends on what is
asked of it, so the time that the last piece took says how large the next one is.
"""

from __future__ import annotations

from collections.abc import Iterator
from time import perf_counter

FIRST = 128
"""Rows of the first piece; all pieces are multiples of it, but the last one."""

SHORT, LONG = 0.02, 0.1
"""Pieces that take less than the one grow, those that take more than the other shrink [s]. Calls
cost some microseconds each, so that nobody notices them.
"""

GROWTH = 4


def pieces(rows: int, first: int = FIRST) -> Iterator[slice]:
    """Yield slices of so many rows, in order, each after what is done with the one before.

    Parameters
    ----------
    rows : int
        Number of rows.
    first : int
        Rows of the first piece; all are multiples of it, but the last one.
    """
    start, size = 0, first
    while start < rows:
        end = min(start + size, rows)
        begun = perf_counter()
        yield slice(start, end)
        start, size = end, next_size(size, perf_counter() - begun, first)


def next_size(size: int, seconds: float, least: int) -> int:
    """Return how large a piece should be after one of a size took so long."""
    if seconds < SHORT:
        return size * GROWTH
    return max(size // GROWTH, least) if seconds > LONG else size
