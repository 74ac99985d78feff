"""Processing of a batch piece by piece, so that Ctrl-C is handled within a second.

Compiled code does not handle Ctrl-C; Python does, between two calls. The cost of a row is not known
in advance, so the duration of the last piece determines the size of the next one.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from time import perf_counter

from fuzzy2.support.checks import Array

FIRST = 128
"""Rows of the first piece; all pieces except the last are multiples of it."""

SHORT, LONG = 0.02, 0.1
"""Pieces that take less than the one grow, those that take more than the other shrink [s]. Calls
cost some microseconds each, so that nobody notices them.
"""

GROWTH = 4


def pieces(rows: int, first: int = FIRST) -> Iterator[slice]:
    """Yield consecutive slices of the rows; each follows after the work on the one before.

    Parameters
    ----------
    rows : int
        Number of rows.
    first : int
        Rows of the first piece; all pieces except the last are multiples of it.
    """
    start, size = 0, first
    while start < rows:
        end = min(start + size, rows)
        begun = perf_counter()
        yield slice(start, end)
        start, size = end, next_size(size, perf_counter() - begun, first)


def flat_pieces(*arrays: Array) -> Iterable[tuple[Array, ...]]:
    """Return consecutive pieces of contiguous arrays, flat; each array has one row per input."""
    rows = len(arrays[0])
    # One row, as in a control loop, must not take the time of a generator and of slices.
    if rows == 1:
        return (tuple([array.ravel() for array in arrays]),)
    return (tuple(array[part].ravel() for array in arrays) for part in pieces(rows))


def next_size(size: int, seconds: float, least: int) -> int:
    """Return the size of the next piece, given the size and the duration of the last one."""
    if seconds < SHORT:
        return size * GROWTH
    return max(size // GROWTH, least) if seconds > LONG else size
