"""A study: many runs whose results are kept in a file.

A study is a set of runs (:class:`~psp3.study.run.Run`) and a file. Runs that are in the file are
not repeated, so the same lines begin a study, resume one after any interruption, and extend one
with more seeds::

    runs = psp3.grid(controller=["t1", "it2"], snr_db=[20, 15, 10], seed=range(30))
    study = psp3.Study("study.sqlite", runs)
    study.run()
    psp3.statistics.summarize(study.rows())

A run depends on its fields alone, seed included, so it does not matter which worker does it, or
when.

Workers are threads: a run spends nearly all its time in compiled loops that release the GIL. With
``scheduler`` the workers are those of a dask.distributed cluster; results still come back to this
process, which alone writes them. Runs are handed out a few at a time, so the memory of a study
grows only with its table.
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
"""A study stops handing out runs after this many have failed, because all are probably wrong."""

HANDED_OUT = 2
"""Runs handed out to each worker: the second is queued, so the worker stays busy while results are
written.
"""

LOOK_UP = 5.0
"""How long to wait for a result before checking that there still are workers [s]."""

Progress = Callable[[int, int, float], None]


class Study(Described):
    """A set of runs whose results are kept in a file.

    Parameters
    ----------
    path : path
        SQLite file of the results. It is made by :meth:`run`, and extended if it exists.
    runs : iterable of Run, optional
        The runs, see :func:`grid`; runs with the same canonical form count once. By default the
        study has the runs that are in the file.

    Attributes
    ----------
    path : Path
        The file.
    runs : sequence of Run or None
        The runs, each once and in canonical form; None if the study has the runs of the file.

    Raises
    ------
    InvalidStudyFile, StudyMismatch
        If the file exists and cannot be used.
    InvalidValue, UnknownName, PSP3Error
        If there are no runs, or one of them is invalid; see :meth:`psp3.study.run.Run.check`.
    """

    def __init__(self, path: str | Path, runs: Iterable[Run] | None = None) -> None:
        self.runs = None if runs is None else Runs(runs)
        self._file = StudyFile(path, None if self.runs is None else self.runs.shared)
        self.path = self._file.path

    def _facts(self) -> dict[str, Any]:
        # The number of finished runs is not shown, because that would mean to read the file.
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
        """Do the runs that are not in the file; each is on disk half a second after it is done.

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
            Number of runs that this call did.

        Raises
        ------
        InvalidValue
            If ``workers`` is not a positive integer, or is given together with a scheduler.
        StudyFileNotWritable, StudyInUse, StudyMismatch
            Before any work, if the file cannot be written to, or another study is writing to it.
            ``StudyFileNotWritable`` can also come later, when the disk is full. What is in the file
            stays.
        SchedulerUnavailable
            Before any work, if the scheduler or its workers cannot be used; later, if the
            connection is lost.
        RunsFailed
            At the end, if runs raised errors; the results of the others are kept.
        StudyInterrupted
            After Ctrl-C at any moment; it is a :class:`KeyboardInterrupt`. Runs that have begun are
            finished and kept.
        """
        if progress is not None:
            checked_function("progress", progress)
        _check_workers(workers, scheduler)
        if self.runs is None:
            raise InvalidValue(
                "runs",
                None,
                "given to a study that does runs; without them it only reads its file",
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
        """Return results ordered by their fields, as a table of rows and columns.

        Parameters
        ----------
        **selection
            Fields, each with one or more values to select: ``rows(controller="it2", snr_db=[20,
            10])``.

        Returns
        -------
        Table
            Fields and metrics of every finished run of this study: ``table[0]`` is a dictionary,
            ``table.column("rms_error")`` an array.

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
        """Write results to a CSV file and return its path.

        Numbers are written with enough digits to be read back exactly; infinity is ``inf``, NaN is
        ``nan``, and None is empty.

        Parameters
        ----------
        path : path
            The CSV file; an existing one is replaced only when the new one is complete.
        **selection
            As for :meth:`rows`.

        Raises
        ------
        InvalidValue
            If ``path`` is the study's own file.
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
        The runs; those with the same canonical form are done once.
    workers : int, optional
        Number of threads; by default the number of cores that this process may use. The result does
        not depend on it.

    Raises
    ------
    InvalidValue
        If ``workers`` is not a positive integer.
    PSP3Error
        Before any work, if a run is invalid; during the work, as soon as a run fails.
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
        raise InvalidValue("workers", workers, "left out with a scheduler, which has its own")
    if scheduler is not None:
        cluster.host_and_port(scheduler)


@contextmanager
def _workers(
    workers: int | None, scheduler: str | None, interrupts: Interrupts
) -> Iterator[tuple[Executor, Callable[[], int]]]:
    """Yield the executor, and a function that returns how many runs it does at a time."""
    with ExitStack() as stack:
        with interrupts.obeyed_at_once():
            them = _threads(workers) if scheduler is None else cluster.connected(scheduler)
            found = stack.enter_context(them)
        yield found


class _Session:
    """The state of one call of :meth:`Study.run`: runs to do, under way, done and failed."""

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
        """Number of the study's runs that are in the file or about to be committed."""
        now = self._additions.committed + self._additions.waiting - self._in_file_before
        return self._there_before + now

    def report(self) -> None:
        if self._progress is not None:
            now = self.done - self._there_before
            rate = now / (time.monotonic() - self._start) if now else 0.0
            # The caller's ``progress`` may take long or wait for something.
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
                # The wait is limited: dask does not always report that it has lost its scheduler,
                # but count_workers detects it.
                finished = self._under_way.finished(min(LOOK_UP, self._additions.due()))
                self._keep(finished)
                if finished:
                    self.report()
        except KeyboardInterrupt:
            # Runs that have begun on threads cannot be stopped, but they end soon and are kept.
            self._under_way.cancel()
            while self._under_way:
                self._keep(self._under_way.finished())
            raise
        finally:
            self._under_way.cancel()

    def _keep(self, finished: Iterable[Future[Mapping[str, float]]]) -> None:
        """Keep results: they are committed together with those that come soon after."""
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
        # Removed only now: after an interrupt, runs that are not committed must still be found
        # under way.
        for future in finished:
            self._under_way.take(future)
        if lost:
            raise CancelledError
