"""Pieces of a batch: all rows once, in order, and as many at a time as take no time."""

from __future__ import annotations

import itertools

import pytest

from fuzzy2.support import pieces as module
from fuzzy2.support.pieces import FIRST, pieces


@pytest.mark.parametrize("rows", [0, 1, FIRST - 1, FIRST, FIRST + 1, 100_000])
def test_every_row_is_in_one_piece(rows: int) -> None:
    ends = [(part.start, part.stop) for part in pieces(rows)]
    assert [row for start, stop in ends for row in range(start, stop)] == list(range(rows))
    assert all((stop - start) % FIRST == 0 for start, stop in ends[:-1])


@pytest.mark.parametrize(
    ("seconds", "sizes"),
    [
        (0.0, [10, 40, 160, 640]),  # short: each is larger
        (0.05, [10, 10, 10, 10]),
        (5.0, [10, 10, 10, 10]),  # long, and none is smaller than the first one
    ],
)
def test_the_time_of_one_piece_says_how_large_the_next_one_is(
    seconds: float, sizes: list[int], monkeypatch: pytest.MonkeyPatch
) -> None:
    clock = itertools.count()
    monkeypatch.setattr(module, "perf_counter", lambda: seconds * next(clock))
    found = [part.stop - part.start for part in itertools.islice(pieces(10**6, 10), 4)]
    assert found == sizes


def test_pieces_shrink_where_rows_become_dear(monkeypatch: pytest.MonkeyPatch) -> None:
    now = [0.0]
    monkeypatch.setattr(module, "perf_counter", lambda: now[0])
    found = []
    for part in itertools.islice(pieces(10**9, 10), 9):
        found.append(part.stop - part.start)
        # From row 10,000 on a millisecond a row.
        now[0] += 1e-3 * (part.stop - part.start) if part.start > 10_000 else 0.0
    assert found[:6] == [10, 40, 160, 640, 2560, 10240]
    assert found[6:] == [40_960, 10_240, 2560]
