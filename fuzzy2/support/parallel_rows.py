"""Rows of a batch on all cores.

Compiled kernels release the interpreter lock, so threads of one process compute rows side by side.
The caller's thread takes part, and does all where the others are late: a batch never waits for a
thread that has not begun. The answer is that of one thread, the first refused row included.
"""

from __future__ import annotations

import contextlib
import functools
import os
import threading
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from time import perf_counter

from fuzzy2.support.pieces import next_size

# A part has at least as many rows as take about 50 µs. To hand rows to another thread takes about
# 40 µs of CPU time, however many they are. So each thread should have five such parts: a batch that
# two threads share costs less than a tenth more.
PARTS_A_THREAD = 5
# The first part has at most this many times as many rows. Those after it have more as long as they
# are short: rows may take much longer than expected, and Ctrl-C is heard between two parts.
FIRST_PART = 20
# However short parts are, they end within a second on a machine that is ten times slower.
LARGEST_PART = 1000


def first_refused_row(part: Callable[[int, int], int], rows: int, grain: int) -> int:
    """Compute the rows of a batch part by part, on several threads where that pays.

    Parts are taken in ascending order, large ones first, and between two of them Python hears
    Ctrl-C. After a refusal or an exception no part is begun; those that are under way are waited
    for, so that nothing writes to the caller's arrays afterwards.

    Parameters
    ----------
    part : callable
        From the first row and the row after the last one to -1, or to the number of the first row
        that was refused, counted from the first of the part. Rows must not depend on one another.
        It is called by several threads at a time, and should spend its time in a compiled kernel.
    rows : int
        Number of rows of the batch.
    grain : int
        Number of rows that take about 50 µs, the least that a part has.

    Returns
    -------
    int
        -1, or the first refused row of the batch. Rows after it may have been computed or not.

    Raises
    ------
    Exception
        What ``part`` raises, where no row before that part is refused.
    """
    threads, cores = max(1, rows // (PARTS_A_THREAD * grain)), 1
    if threads > 1:
        cores = len(os.sched_getaffinity(0))
        threads = min(threads, cores)
    parts = _Parts(part, rows, grain, threads)
    futures: list[Future[None]] = []
    try:
        # At the interpreter's end, or where the system gives no more threads, this one does it all.
        with contextlib.suppress(RuntimeError):
            for _ in range(threads - 1):
                # One by one: those before an error are waited for.
                futures.append(_pool(os.getpid(), cores - 1).submit(parts.work))  # noqa: PERF401
        parts.work()
    finally:
        parts.stop()
        for future in futures:
            # A thread that has not begun need not begin.
            if not future.cancel():
                future.result()
        # One that comes late finds nothing to do, and must not keep the caller's arrays alive.
        del parts.part
    return parts.answer()


@functools.cache
def _pool(process: int, threads: int) -> ThreadPoolExecutor:
    """Return the threads of a process. A fork has no threads, and must not wait for its parent's.

    They are started when there is work for them, and end with the interpreter.
    """
    return ThreadPoolExecutor(threads, thread_name_prefix=f"rows-{process}")


class _Parts:
    """What is left to do of a batch, and the first part that did not succeed."""

    def __init__(
        self, part: Callable[[int, int], int], rows: int, grain: int, threads: int
    ) -> None:
        self.part, self.rows, self.grain, self.threads = part, rows, grain, threads
        self.lock = threading.Lock()
        self.next = 0
        self.largest = FIRST_PART * grain
        self.failed_at = rows
        self.outcome: int | Exception = -1

    def work(self) -> None:
        """Take parts until none is left."""
        while (limits := self.take()) is not None:
            first, last = limits
            begun = perf_counter()
            outcome: int | Exception
            try:
                row = self.part(first, last)
                outcome = -1 if row < 0 else first + row
            except Exception as error:
                outcome = error
            if outcome != -1:
                self.fail(first, outcome)
            elif last - first == self.largest:
                size = next_size(self.largest, perf_counter() - begun, self.grain)
                self.largest = min(size, LARGEST_PART * self.grain)

    def take(self) -> tuple[int, int] | None:
        """Return the limits of the next part; half of what is left is shared evenly."""
        with self.lock:
            first = self.next
            if first >= self.rows:
                return None
            size = (self.rows - first) // (2 * self.threads) if self.threads > 1 else self.rows
            size = min(max(size, self.grain), self.largest)
            self.next = min(first + size, self.rows)
            return first, self.next

    def fail(self, first: int, outcome: int | Exception) -> None:
        """Keep the outcome of the foremost part that failed: all before it have been taken."""
        with self.lock:
            self.next = self.rows
            if first < self.failed_at:
                self.failed_at, self.outcome = first, outcome

    def stop(self) -> None:
        """Let no other part begin."""
        with self.lock:
            self.next = self.rows

    def answer(self) -> int:
        """Return the first refused row or -1, or raise what was raised before it."""
        if isinstance(self.outcome, Exception):
            raise self.outcome
        return self.outcome
