"""A study: many runs, kept in a file, whose statistics have confidence intervals.

A study is a set of runs (:class:`~psp3.study.run.Run`) and a file. Runs that are in the file are
not repeated, so the same lines begin a study, resume one that was stopped, however it was stopped,
and extend one with more seeds::

    runs = psp3.grid(controller=["t1", "it2"], snr_db=[20, 15, 10], seed=range(30))
    study = psp3.Study("study.sqlite", runs)
    study.run()
    psp3.statistics.summarize(study.rows())

Every run is decided by its fields alone, seed included, so it makes no difference which worker does
it, or when.

Workers are threads: a run spends nearly all its time in compiled loops that release the GIL. With
``scheduler`` they are those of a dask.distributed cluster; results still come back here and are
written by this process alone. Runs are handed out a few at a time, so the memory that a study takes
grows with its table and not with what is under way.
"""

from __future__ import annotations

import csv
import itertools
import os
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import CancelledError, Executor, Future, ThreadPoolExecutor
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

from fuzzy2.support.described import Described
from fuzzy2.support.one_thread import one_thread
from fuzzy2.support.text_files import written_whole
from psp3.checks import checked_count, checked_function, checked_path
from psp3.errors import InvalidValue, RunsFailed, SchedulerUnavailable, StudyInterrupted
from psp3.study import cluster
from psp3.study.execution import execute
from psp3.study.file import Additions, StudyFile
from psp3.study.interrupts import Interrupts, noted_interrupts
from psp3.study.keys import Runs
from psp3.study.run import METRICS, Run, Value, contents, field_types
from psp3.study.table import Table
from psp3.study.under_way import UnderWay

MOST_FAILURES = 10
"""After so many failed runs a study hands out no more: something is wrong with all of them."""

HANDED_OUT = 2
"""Runs under way for each worker: the second one waits, so that no worker waits while results are
written.
"""

LOOK_UP = 5.0
"""How long to wait for a result before looking whether there still is anybody who works [s]."""

Progress = Callable[[int, int, float], None]


class Study(Described):
    """A set of runs whose results are kept in a file.

    Parameters
    ----------
    path : path
        SQLite file of the results. It is made by :meth:`run`, and extended if it exists.
    runs : iterable of Run, optional
        The runs, see :func:`grid`; those that are equal in all that matters count once. Without
        them the study is what is in the file.

    Attributes
    ----------
    path : Path
        The file.
    runs : sequence of Run or None
        The runs, each once and in canonical form; None if they are those of the file.

    Raises
    ------
    InvalidStudyFile, StudyMismatch
        If the file exists and cannot be used.
    InvalidValue, UnknownName, PSP3Error
        If there are no runs, or one of them makes no sense; see :meth:`psp3.study.run.Run.check`.
    """

    def __init__(self, path: str | Path, runs: Iterable[Run] | None = None) -> None:
        self.runs = None if runs is None else Runs(runs)
        self._file = StudyFile(path, None if self.runs is None else self.runs.shared)
        self.path = self._file.path

    def _facts(self) -> dict[str, Any]:
        # How many are done only the file knows, which is not read for this.
        return {
            "file": self.path.name if self.path.exists() else f"{self.path.name}, not made yet",
            "runs": "those of the file" if self.runs is None else len(self.runs),
        }

    def run(
        self,
        workers: int | None = None,
        scheduler: str | None = None,
        progress: Progress | None = None,
    ) -> int:
        """Do the runs that are not yet in the file; each is on disk half a second after it is done.

        Parameters
        ----------
        workers : int, optional
            Number of threads; all cores of this process unless given.
        scheduler : str, optional
            Address ``tcp://host:port`` of a dask scheduler, whose workers then do the runs.
        progress : callable, optional
            Called with the number of runs in the file, the number of all runs, and the rate since
            the start [1/s].

        Returns
        -------
        int
            How many runs were done now.

        Raises
        ------
        InvalidValue
            If ``workers`` is not a positive integer, or is given together with a scheduler.
        StudyFileNotWritable, StudyInUse, StudyMismatch
            Before any work, if the file cannot be written to, or another study is writing to it;
            the first one also later, when the disk is full. What is in the file stays.
        SchedulerUnavailable
            Before any work, if the scheduler or its workers cannot be used; later, if the
            connection is lost.
        RunsFailed
            At the end, if runs raised errors; the results of the others are kept.
        StudyInterrupted
            After Ctrl-C, at whatever moment; a :class:`KeyboardInterrupt`. Runs that have begun
            are finished and kept.
        """
        if progress is not None:
            checked_function("progress", progress)
        _check_workers(workers, scheduler)
        if self.runs is None:
            raise InvalidValue(
                "runs",
                None,
                "given to the study that is to do them; without them it only reads its file",
            )
        under_way: UnderWay[Run, Mapping[str, float]] = UnderWay()
        session: _Session | None = None
        try:
            with (
                noted_interrupts(under_way.wake) as interrupts,
                self._file.adding() as additions,
            ):
                with interrupts.obeyed_at_once():
                    places = self.runs.missing(additions.keys)
                session = _Session(
                    additions, under_way, len(self.runs), len(places), progress, interrupts
                )
                session.report()
                if len(places):
                    missing = map(self.runs.__getitem__, places)
                    with _workers(workers, scheduler, interrupts) as (executor, count_workers):
                        session.work(missing, executor, count_workers)
        except KeyboardInterrupt:
            done = 0 if session is None else session.done
            raise StudyInterrupted(self.path, done, len(self.runs)) from None
        except CancelledError as error:
            done = 0 if session is None else session.done
            reason = (
                f"the connection was lost after {done} of {len(self.runs)} runs; they "
                f"are in {self.path}, run the study again"
            )
            raise SchedulerUnavailable(str(scheduler), reason) from error
        if session.failures:
            failures = [
                (run, f"{type(error).__name__}: {' '.join(str(error).split())}")
                for run, error in session.failures.items()
            ]
            not_started = session.total - session.done - len(failures)
            raise RunsFailed(self.path, failures, not_started) from next(
                iter(session.failures.values())
            )
        return len(places)

    def rows(self, **selection: Value | Iterable[Value]) -> Table:
        """Return results in the order of their fields, as a sequence of rows and as columns.

        Parameters
        ----------
        **selection
            Fields with the value, or the values, that are wanted:
            ``rows(controller="it2", snr_db=[20, 10])``.

        Returns
        -------
        Table
            Fields and metrics of every run of this study that is done: ``table[0]`` is a
            dictionary, ``table.column("rms_error")`` an array.

        Raises
        ------
        UnknownName
            If a run has no such field.
        InvalidStudyFile, StudyMismatch
            If there is no file, or it cannot be used.
        """
        rows = self._file.rows()
        if self.runs is not None:
            rows = self.runs.rows_of(rows)
        return rows.select(**selection)

    def export(self, path: str | Path, **selection: Value | Iterable[Value]) -> Path:
        """Write results to a CSV file, all at once, and return its path.

        Numbers are written so that reading gives the same numbers; ``inf`` and ``nan`` are words,
        None is empty.

        Parameters
        ----------
        path : path
            The file; an existing one is replaced only when the new one is complete.
        **selection
            As for :meth:`rows`.

        Raises
        ------
        InvalidValue
            If it is the study's own file.
        fuzzy2.errors.FileNotWritten
            If it cannot be written.
        """
        path = checked_path("path", path)
        if path.resolve() == self.path:
            raise InvalidValue(
                "path", str(path), "another file than that of the study, which it would replace"
            )
        rows = self.rows(**selection)
        with written_whole(path) as file:
            writer = csv.DictWriter(file, [*field_types(), *METRICS], lineterminator="\n")
            writer.writeheader()
            writer.writerows(rows)
        return path


def results_of(runs: Iterable[Run], workers: int | None = None) -> Table:
    """Do runs on threads and return their results, without a file.

    Parameters
    ----------
    runs : iterable of Run
        The runs; those that are equal in all that matters are done once.
    workers : int, optional
        Number of threads; all cores of this process unless given. The result does not depend on it.

    Raises
    ------
    InvalidValue
        If ``workers`` is not a positive integer.
    PSP3Error
        What is wrong with a run, before any work; what goes wrong with one, at once.
    """
    wanted = Runs(runs)
    count = len(os.sched_getaffinity(0)) if workers is None else checked_count("workers", workers)
    with one_thread(), ThreadPoolExecutor(count, thread_name_prefix="psp3-study") as pool:
        found = list(pool.map(execute, wanted))
    return Table.of(
        {**contents(run), **metrics} for run, metrics in zip(wanted, found, strict=True)
    ).in_order()


@contextmanager
def _threads(workers: int | None) -> Iterator[tuple[Executor, Callable[[], int]]]:
    count = workers or len(os.sched_getaffinity(0))
    with one_thread(), ThreadPoolExecutor(count, thread_name_prefix="psp3-study") as executor:
        yield executor, lambda: count


def _check_workers(workers: int | None, scheduler: str | None) -> None:
    if workers is not None:
        checked_count("workers", workers)
    if workers is not None and scheduler is not None:
        raise InvalidValue("workers", workers, "left out where a scheduler has its own")
    if scheduler is not None:
        cluster.host_and_port(scheduler)


@contextmanager
def _workers(
    workers: int | None, scheduler: str | None, interrupts: Interrupts
) -> Iterator[tuple[Executor, Callable[[], int]]]:
    """Yield who does the runs, and what tells how many of them at a time."""
    with ExitStack() as stack:
        with interrupts.obeyed_at_once():
            them = _threads(workers) if scheduler is None else cluster.connected(scheduler)
            found = stack.enter_context(them)
        yield found


class _Session:
    """One call of :meth:`Study.run`: what is to be done, under way, done, and failed."""

    def __init__(
        self,
        additions: Additions,
        under_way: UnderWay[Run, Mapping[str, float]],
        total: int,
        wanted: int,
        progress: Progress | None,
        interrupts: Interrupts,
    ) -> None:
        self.total = total
        self.failures: dict[Run, BaseException] = {}
        self._additions, self._under_way, self._progress = additions, under_way, progress
        self._interrupts = interrupts
        self._there_before, self._in_file_before = total - wanted, additions.committed
        self._start = time.monotonic()

    @property
    def done(self) -> int:
        """Number of runs of the study that are in the file, or will be in half a second."""
        now = self._additions.committed + self._additions.waiting - self._in_file_before
        return self._there_before + now

    def report(self) -> None:
        if self._progress is not None:
            now = self.done - self._there_before
            rate = now / (time.monotonic() - self._start) if now else 0.0
            # What others do with it may take long, or wait for somebody.
            with self._interrupts.obeyed_at_once():
                self._progress(self.done, self.total, rate)

    def work(
        self,
        missing: Iterator[Run],
        executor: Executor,
        count_workers: Callable[[], int],
    ) -> None:
        """Hand out runs and keep their results until none are left, or too many failed."""
        try:
            while True:
                with self._interrupts.obeyed_at_once():
                    workers = max(1, count_workers())
                room = (
                    HANDED_OUT * workers - len(self._under_way)
                    if len(self.failures) < MOST_FAILURES
                    else 0
                )
                for run in itertools.islice(missing, max(0, room)):
                    self._under_way.hand_out(executor, run, execute, run)
                if not self._under_way:
                    return
                # Not without end: with bad luck dask tells nobody that it has lost its scheduler,
                # and count_workers finds it out.
                finished = self._under_way.finished(min(LOOK_UP, self._additions.due()))
                self._keep(finished)
                if finished:
                    self.report()
        except KeyboardInterrupt:
            # What has begun here cannot be stopped, but is soon done, and is kept.
            self._under_way.cancel()
            while self._under_way:
                self._keep(self._under_way.finished())
            raise
        finally:
            self._under_way.cancel()

    def _keep(self, finished: Iterable[Future[Mapping[str, float]]]) -> None:
        """Keep results: they are committed with those that come soon after them."""
        results, lost = [], False
        for future in finished:
            run = self._under_way[future]
            if future.cancelled():
                lost = True
                continue
            error = future.exception()
            if error is None:
                results.append((run, future.result()))
            else:
                self.failures[run] = error
        self._additions.add(results)
        # Only now: what is not committed must be found under way, whatever comes between.
        for future in finished:
            self._under_way.take(future)
        if lost:
            raise CancelledError
