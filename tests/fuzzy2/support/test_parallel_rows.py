"""Batches on several threads answer as one thread does, whatever happens on the way.

Parts are Python here, so that they can wait for one another; the number of cores is pretended.
"""

from __future__ import annotations

import gc
import itertools
import os
import signal
import subprocess
import sys
import threading
import time
import weakref
from collections.abc import Callable
from concurrent.futures import Future
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fuzzy2.support import parallel_rows
from fuzzy2.support.parallel_rows import LARGEST_PART, PARTS_A_THREAD, first_refused_row

ROOT = Path(__file__).resolve().parents[3]
# Whoever waits for another thread as long as this [s] has found a mistake.
FAR_TOO_LONG = 600.0


@pytest.fixture
def cores(monkeypatch: pytest.MonkeyPatch) -> Callable[[int], None]:
    """Return a function that sets the number of cores."""

    def pretend(count: int) -> None:
        monkeypatch.setattr(os, "sched_getaffinity", lambda process: set(range(count)))

    return pretend


def wait_for(event: threading.Event) -> None:
    assert event.wait(FAR_TOO_LONG)


class Batch:
    """Rows that are counted when they are computed, some of which are refused or raise."""

    def __init__(self, rows: int, refused: set[int], raising: set[int]) -> None:
        self.counts = np.zeros(rows, dtype=int)
        self.refused, self.raising = refused, raising

    def part(self, first: int, last: int) -> int:
        """Compute rows up to the first bad one."""
        for row in range(first, last):
            if row in self.raising:
                raise ArithmeticError(row)
            if row in self.refused:
                return row - first
            self.counts[row] += 1
            if row % 7 == 0:
                time.sleep(0)  # lets the other threads have a turn
        return -1


@given(
    rows=st.integers(0, 400),
    grain=st.integers(1, 30),
    threads=st.integers(1, 5),
    refused=st.sets(st.integers(0, 400), max_size=4),
    raising=st.sets(st.integers(0, 400), max_size=2),
)
def test_the_answer_is_that_of_one_row_after_the_other(
    rows: int, grain: int, threads: int, refused: set[int], raising: set[int]
) -> None:
    """The first row that is refused or raises decides; all before it are computed once.

    Where one raises, that part's rows before it are computed, too.
    """
    batch = Batch(rows, refused, raising)
    first = min((row for row in refused | raising if row < rows), default=rows)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(os, "sched_getaffinity", lambda process: set(range(threads)))
        if first in raising and first < rows:
            with pytest.raises(ArithmeticError, match=f"^{first}$"):
                first_refused_row(batch.part, rows, grain)
        else:
            assert first_refused_row(batch.part, rows, grain) == (first if first < rows else -1)
    assert (batch.counts[:first] == 1).all()
    assert (batch.counts <= 1).all()


@pytest.mark.parametrize("later", ["refuses", "raises"])
@pytest.mark.parametrize("earlier", ["refuses", "raises"])
def test_an_earlier_part_decides_though_a_later_one_is_done_first(
    cores: Callable[[int], None], earlier: str, later: str
) -> None:
    cores(2)
    later_is_done, begun = threading.Event(), []

    def part(first: int, last: int) -> int:
        begun.append(first)
        if first == 0:
            wait_for(later_is_done)
            if earlier == "raises":
                raise ArithmeticError("earlier")
            return 3
        if later_is_done.is_set():
            return -1
        later_is_done.set()
        if later == "raises":
            raise ArithmeticError("later")
        return 0

    if earlier == "raises":
        with pytest.raises(ArithmeticError, match="earlier"):
            first_refused_row(part, 1000, 10)
    else:
        assert first_refused_row(part, 1000, 10) == 3
    # What came after was given up: of a thousand rows in parts of ten, two parts were begun.
    assert len(begun) == 2


@pytest.mark.parametrize("count", [2, 3])
def test_parts_are_computed_side_by_side(cores: Callable[[int], None], count: int) -> None:
    """Each thread waits in its first part until all are there."""
    cores(count)
    together, been = threading.Barrier(count), threading.local()
    threads = set()

    def part(first: int, last: int) -> int:
        if not hasattr(been, "here"):
            been.here = True
            together.wait(FAR_TOO_LONG)
        threads.add(threading.get_ident())
        return -1

    assert first_refused_row(part, 1000, 10) == -1
    assert len(threads) == count
    assert threading.get_ident() in threads


@pytest.mark.parametrize(("count", "rows"), [(1, 100_000), (4, 2 * PARTS_A_THREAD * 10 - 1)])
def test_one_core_and_short_batches_stay_in_the_thread_of_the_caller(
    cores: Callable[[int], None], count: int, rows: int
) -> None:
    cores(count)
    parts = []

    def part(first: int, last: int) -> int:
        parts.append((threading.get_ident(), first, last))
        return -1

    assert first_refused_row(part, rows, 10) == -1
    assert {thread for thread, _, _ in parts} == {threading.get_ident()}
    limits = [0, *(last for _, _, last in parts)]
    assert [first for _, first, _ in parts] == limits[:-1]
    assert limits[-1] == rows
    assert max(np.diff(limits)) <= LARGEST_PART * 10


@pytest.mark.parametrize(
    ("seconds", "sizes"),
    [(0.0, [200, 800, 3200, 10_000, 10_000]), (0.05, [200] * 5), (2.0, [200, 50, 12, 10, 10])],
)
def test_parts_are_as_large_as_can_be_while_ctrl_c_is_heard(
    cores: Callable[[int], None],
    monkeypatch: pytest.MonkeyPatch,
    seconds: float,
    sizes: list[int],
) -> None:
    """Rows may take longer than expected: large parts of such rows would be a minute's."""
    cores(1)
    clock = itertools.count()
    monkeypatch.setattr(parallel_rows, "perf_counter", lambda: seconds * next(clock))
    found = []

    def part(first: int, last: int) -> int:
        found.append(last - first)
        return -1

    assert first_refused_row(part, 100_000, 10) == -1
    assert found[:5] == sizes
    assert sum(found) == 100_000


@pytest.mark.parametrize(("parts", "threads"), [(9, 1), (10, 2), (29, 5), (1000, 64)])
def test_as_many_threads_as_the_rows_are_worth_and_no_more(
    cores: Callable[[int], None], monkeypatch: pytest.MonkeyPatch, parts: int, threads: int
) -> None:
    """On a machine of 64 cores; no thread is started here."""
    cores(64)
    asked = []

    class Pool:
        def submit(self, work: Callable[[], None]) -> Future[None]:
            asked.append(work)
            return Future()

    monkeypatch.setattr(parallel_rows, "_pool", lambda process, threads: Pool())
    assert first_refused_row(lambda first, last: -1, parts * 10, 10) == -1
    assert len(asked) == threads - 1


def test_a_batch_does_not_wait_for_a_thread_that_has_not_begun_nor_leaves_it_its_arrays(
    cores: Callable[[int], None],
) -> None:
    """All threads of the pool are busy with something else until the batch is done."""
    cores(2)
    busy, done = threading.Event(), threading.Event()

    def occupy() -> None:
        busy.set()
        wait_for(done)

    class Rows:
        def part(self, first: int, last: int) -> int:
            return -1

    occupied = parallel_rows._pool(os.getpid(), 1).submit(occupy)
    wait_for(busy)
    try:
        rows = Rows()
        forgotten = weakref.ref(rows)
        assert first_refused_row(rows.part, 1000, 10) == -1
        del rows
        gc.collect()
        assert forgotten() is None
    finally:
        done.set()
        occupied.result()


def test_a_batch_within_a_batch(cores: Callable[[int], None]) -> None:
    cores(2)
    inner = threading.Lock()
    answers = []

    def part(first: int, last: int) -> int:
        batch = Batch(100, {50}, set())
        row = first_refused_row(batch.part, 100, 5)
        with inner:
            answers.append(row)
        return -1

    assert first_refused_row(part, 200, 10) == -1
    assert set(answers) == {50}


def test_batches_of_several_threads_at_once(cores: Callable[[int], None]) -> None:
    cores(3)
    answers: dict[int, int] = {}

    def run(number: int) -> None:
        batch = Batch(500, {300 + number}, set())
        answers[number] = first_refused_row(batch.part, 500, 5)

    callers = [threading.Thread(target=run, args=(number,)) for number in range(8)]
    for caller in callers:
        caller.start()
    for caller in callers:
        caller.join()
    assert answers == {number: 300 + number for number in range(8)}


def test_where_there_are_no_more_threads_the_caller_does_all(
    cores: Callable[[int], None], monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*arguments: Any) -> None:
        raise RuntimeError("can't start new thread")

    cores(4)
    monkeypatch.setattr(parallel_rows.ThreadPoolExecutor, "submit", refuse)
    batch = Batch(1000, {900}, set())
    assert first_refused_row(batch.part, 1000, 10) == 900


def test_after_ctrl_c_nothing_is_begun_and_nothing_goes_on(cores: Callable[[int], None]) -> None:
    """A real signal to this thread, while another thread is in its part."""
    cores(2)
    other_is_here, interrupted = threading.Event(), threading.Event()
    begun, ended = [], []

    def part(first: int, last: int) -> int:
        begun.append(first)
        if threading.current_thread() is threading.main_thread():
            wait_for(other_is_here)
            try:
                signal.raise_signal(signal.SIGINT)
            finally:
                interrupted.set()
        else:
            other_is_here.set()
            wait_for(interrupted)
            time.sleep(0.01)
        ended.append(first)
        return -1

    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with pytest.raises(KeyboardInterrupt):
            first_refused_row(part, 1000, 10)
    finally:
        signal.signal(signal.SIGINT, before)
    assert len(begun) == 2
    assert len(ended) == 1


def test_a_fork_has_threads_of_its_own() -> None:
    """A pool has been used, and its thread waits, when the process forks.

    In both processes two threads must meet in their parts before one goes on.
    """
    program = f"""
import os, sys, threading
from fuzzy2.support.parallel_rows import first_refused_row
os.sched_getaffinity = lambda process: {{0, 1}}
def batch():
    together, been = threading.Barrier(2), threading.local()
    def part(first, last):
        if not hasattr(been, "here"):
            been.here = True
            together.wait({FAR_TOO_LONG})
        return 704 - first if first <= 704 < last else -1
    return first_refused_row(part, 1000, 10)
before = batch()
child = os.fork()
if child == 0:
    row = batch()
    os._exit(0 if row == before else 1)
_, status = os.waitpid(child, 0)
sys.exit(os.waitstatus_to_exitcode(status) or (0 if batch() == before == 704 else 2))
"""
    done = subprocess.run(
        # Python 3.12 and later warn of any fork of a process with threads.
        [sys.executable, "-W", "ignore::DeprecationWarning", "-c", program],
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
    )
    assert (done.returncode, done.stderr) == (0, "")
