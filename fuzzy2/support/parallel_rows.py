"""Processing of the rows of a batch on all cores.

Compiled kernels release the interpreter lock, so threads of one process compute rows side by side.
The caller's thread takes part and does all the work if the others are late: a batch never waits for
a thread that has not started. The result equals that of a single thread, including the first
refused row.
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

# A part has at least as many rows as take about 50 µs. Handing rows to another thread takes about
# 40 µs of CPU time, however many they are. So each thread should get five such parts, and sharing a
# batch between two threads costs less than a tenth more.
PARTS_A_THREAD = 5
# The first part has at most this many times that number of rows. Later parts grow as long as they
# are short, because rows may take much longer than expected and Ctrl-C is only handled between two
# parts.
FIRST_PART = 20
# Limit of the size of short parts, so that a part ends within a second on a machine that is ten
# times slower.
LARGEST_PART = 1000


def first_refused_row(part: Callable[[int, int], int], rows: int, grain: int) -> int:
    """Process the rows of a batch part by part, on several threads if that pays.

    Parts are taken in ascending order, with large ones first, and Python handles Ctrl-C between two
    of them. After a refusal or an exception no further part is started. Parts that are running are
    waited for, so that nothing writes to the caller's arrays afterwards.

    Parameters
    ----------
    part : callable
        Takes the first row and the row after the last one. Returns -1, or the number of the first
        refused row, counted from the first row of the part. Rows must be independent. Several
        threads call it at the same time, and it should spend its time in a compiled kernel.
    rows : int
        Number of rows of the batch.
    grain : int
        Number of rows that take about 50 µs, which is the smallest part.

    Returns
    -------
    int
        -1, or the first refused row of the batch. Rows after it may or may not have been computed.

    Raises
    ------
    Exception
        An exception of ``part``, if no row before that part is refused.
    """
    threads, cores = max(1, rows // (PARTS_A_THREAD * grain)), 1
    if threads > 1:
        cores = len(os.sched_getaffinity(0))
        threads = min(threads, cores)
    parts = _Parts(part, rows, grain, threads)
    futures: list[Future[None]] = []
    try:
        # At the end of the interpreter, or if the system cannot start more threads, this thread
        # does everything.
        with contextlib.suppress(RuntimeError):
            for _ in range(threads - 1):
                # Parts are collected in order, because those before an error must be waited for.
                futures.append(_pool(os.getpid(), cores - 1).submit(parts.work))  # noqa: PERF401
        parts.work()
    finally:
        parts.stop()
        for future in futures:
            # A thread that has not started yet is no longer needed.
            if not future.cancel():
                future.result()
        # A thread that starts late finds no work, and must not keep the caller's arrays alive.
        del parts.part
    return parts.answer()


@functools.cache
def _pool(process: int, threads: int) -> ThreadPoolExecutor:
    """Return the threads of a process. A fork must not wait for its parent's threads.

    Threads are started when there is work, and end with the interpreter.
    """
    return ThreadPoolExecutor(threads, thread_name_prefix=f"rows-{process}")


class _Parts:
    """The remaining rows of a batch, and the first part that did not succeed."""

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
        """Process parts until none is left."""
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
        """Return the limits of the next part; half of the remaining rows are divided evenly."""
        with self.lock:
            first = self.next
            if first >= self.rows:
                return None
            size = (self.rows - first) // (2 * self.threads) if self.threads > 1 else self.rows
            size = min(max(size, self.grain), self.largest)
            self.next = min(first + size, self.rows)
            return first, self.next

    def fail(self, first: int, outcome: int | Exception) -> None:
        """Store the outcome of the foremost failed part; all parts before it have been started."""
        with self.lock:
            self.next = self.rows
            if first < self.failed_at:
                self.failed_at, self.outcome = first, outcome

    def stop(self) -> None:
        """Prevent further parts from starting."""
        with self.lock:
            self.next = self.rows

    def answer(self) -> int:
        """Return the first refused row or -1, or raise an exception that occurred before it."""
        if isinstance(self.outcome, Exception):
            raise self.outcome
        return self.outcome
