"""The benchmark: entries times robots, noises and seeds, done by workers and kept in a file."""

from __future__ import annotations

import itertools
import math
import os
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import CancelledError, Executor
from concurrent.futures.process import BrokenProcessPool
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

from fuzzy2.support.described import Described
from fuzzy2.support.text_files import made_folder
from psp3.benchmark.baselines import BASELINES, NEED_SCIKIT_LEARN, REFERENCE
from psp3.benchmark.board import Board
from psp3.benchmark.entries import Entry, load_entry
from psp3.benchmark.file import OutcomeFile, key
from psp3.benchmark.readings import NONE, READINGS
from psp3.benchmark.regressors import need_scikit_learn
from psp3.benchmark.stamp import stamp
from psp3.benchmark.tasks import ROBOTS
from psp3.benchmark.trial import Outcome, Trial, execute, own_trial
from psp3.benchmark.workers import done_by, processes
from psp3.checks import (
    MOST_SEEDS,
    checked_count,
    checked_function,
    checked_names,
    checked_number,
    checked_path,
    checked_positive,
    known_name,
    listed,
)
from psp3.errors import (
    InvalidValue,
    SchedulerUnavailable,
    StudyInterrupted,
    UnknownName,
    WorkersLost,
)
from psp3.study import cluster
from psp3.study.interrupts import Interrupts, noted_interrupts

ALL = "all"
"""Name that stands for all entries of the package."""

FILE, PAGE, NUMBERS = "benchmark.sqlite", "benchmark.html", "benchmark.json"
"""Names of the files of a benchmark in its directory."""

Progress = Callable[[int, int, float], None]


class Benchmark(Described):
    """Entries, and the trials that they do.

    Without noise an entry runs once, unless it draws random numbers. An entry that does not see the
    noise of a reading runs as without noise.

    Parameters
    ----------
    directory : path
        Directory of the outcomes; :meth:`run` makes it if it does not exist.
    entries : sequence of str or Entry
        Names of :data:`psp3.benchmark.baselines.BASELINES`, ``"all"`` for all of them, files of
        entries (they end in ``.py``), or entries. Exact computed torque always takes part.
    robots : sequence of str
        Names of :data:`psp3.benchmark.tasks.ROBOTS`.
    readings : sequence of str
        Names of :data:`psp3.benchmark.readings.READINGS`; runs without noise are always done, too.
    levels : sequence of float
        Signal-to-noise ratios of each reading [dB].
    seeds : int
        Number of seeds, counted from 0.
    duration, period : float
        Length of each run and control period [s].

    Raises
    ------
    UnknownName, InvalidValue, InvalidEntry
        If a name is unknown, a number is out of range, a file is not an entry, or two entries have
        the same name.
    MissingPackage
        If an entry needs scikit-learn, and it is not installed.
    """

    def __init__(
        self,
        directory: str | Path,
        entries: Sequence[str | Entry] = (ALL,),
        robots: Sequence[str] = ROBOTS,
        readings: Sequence[str] = (next(iter(READINGS)),),
        levels: Sequence[float] = (20.0,),
        seeds: int = 10,
        duration: float = 5.0,
        period: float = 0.004,
    ) -> None:
        self.directory = checked_path("directory", directory)
        self.entries: dict[str, Entry] = {}
        for source in (REFERENCE, *listed("entries", entries, "a list of names or entries")):
            for one in BASELINES if source == ALL else (source,):
                self._enter(one)
        if any(self.entries.get(name) is BASELINES[name] for name in NEED_SCIKIT_LEARN):
            need_scikit_learn()
        self.robots = tuple(dict.fromkeys(checked_names("robots", robots)))
        self.readings = tuple(dict.fromkeys(checked_names("readings", readings)))
        wanted = "a list of finite ratios [dB]; runs without noise are always done, too"
        ratios = [checked_number("levels", one, wanted) for one in listed("levels", levels, wanted)]
        for ratio in ratios:
            if math.isinf(ratio):
                raise InvalidValue("levels", ratio, wanted)
        self.levels = tuple(dict.fromkeys(ratios))
        self.seeds = checked_count("seeds", seeds, 1, MOST_SEEDS)
        self.duration = checked_positive("duration", duration)
        self.period = checked_positive("period", period)
        if not self.robots:
            raise InvalidValue("robots", robots, f"at least one of {', '.join(ROBOTS)}")
        for reading in self.readings:
            known_name("reading of noise", reading, READINGS)
        for trial in self.trials(seeds=1):
            trial.check()

    def _facts(self) -> dict[str, Any]:
        return {
            "directory": self.directory.name,
            "entries": tuple(self.entries),
            "robots": self.robots,
            "readings": self.readings,
            "levels": tuple(f"{level:g} dB" for level in self.levels),
            "seeds": self.seeds,
        }

    def _enter(self, source: str | Entry) -> None:
        if isinstance(source, Entry):
            entry = source
        elif isinstance(source, str) and source in BASELINES:
            entry = BASELINES[source]
        elif isinstance(source, str) and source.endswith(".py"):
            entry = load_entry(source)
        else:
            known = (ALL, *BASELINES, "or a file that ends in .py")
            raise UnknownName("entry", source, known)
        if self.entries.setdefault(entry.name, entry) != entry:
            raise InvalidValue(
                "entries", entry.name, "of different names, and two of these have this one"
            )

    @property
    def conditions(self) -> tuple[tuple[str, float], ...]:
        """Readings with their ratios; the first is no noise."""
        return ((NONE, math.inf), *itertools.product(self.readings, self.levels))

    def trials(self, seeds: int | None = None) -> Iterator[Trial]:
        """Yield the trials of an entry, as if every outcome depended on the seed.

        Seeds vary slowest, so a benchmark that was stopped holds complete comparisons.

        Raises
        ------
        InvalidValue
            If the number of seeds is invalid.
        """
        count = self.seeds if seeds is None else checked_count("seeds", seeds, 1, MOST_SEEDS)
        for seed in range(count):
            for robot in self.robots:
                for reading, snr_db in self.conditions:
                    yield Trial(robot, reading, snr_db, seed, self.duration, self.period)

    def run(
        self,
        workers: int | None = None,
        scheduler: str | None = None,
        progress: Progress | None = None,
    ) -> int:
        """Do the trials that are not in the file; each is kept when it is done.

        Trials in which an entry raised an error are repeated.

        Parameters
        ----------
        workers : int, optional
            Number of processes; by default the number of cores of this process. With 1 this process
            does the trials.
        scheduler : str, optional
            Address ``tcp://host:port`` of a dask scheduler, whose workers then do the trials. They
            must have one thread each (``dask worker --nthreads 1``), because steps are timed.
        progress : callable, optional
            Called with the number of finished trials, the number of all trials, and the rate since
            the start [1/s].

        Returns
        -------
        int
            Number of trials that this call did.

        Raises
        ------
        InvalidValue
            If ``workers`` is not a positive integer, or is given together with a scheduler.
        InvalidStudyFile, StudyFileNotWritable
            If the file cannot be used.
        WorkersLost
            If a worker process ended early.
        SchedulerUnavailable
            Before any work, if the scheduler or its workers cannot be used; later, if the
            connection is lost.
        StudyInterrupted
            After Ctrl-C at any moment; finished trials are kept.
        """
        if workers is not None and scheduler is not None:
            raise InvalidValue("workers", workers, "left out with a scheduler, which has its own")
        if scheduler is not None:
            cluster.host_and_port(scheduler)
        if progress is not None:
            checked_function("progress", progress)
        count = (
            len(os.sched_getaffinity(0)) if workers is None else checked_count("workers", workers)
        )
        path, session = (self.directory / FILE).resolve(), None
        try:
            with noted_interrupts() as interrupts:
                file = OutcomeFile(made_folder(self.directory) / FILE)
                wanted = self._wanted()
                there = {
                    name for name, outcome in file.outcomes().items() if outcome["error"] is None
                }
                missing = {name: work for name, work in wanted.items() if name not in there}
                there_before = len(wanted) - len(missing)
                session = _Session(file, len(wanted), there_before, progress, interrupts)
                session.report()
                if scheduler is None and count == 1:
                    for name, work in missing.items():
                        with interrupts.obeyed_at_once():
                            outcome = execute(*work)
                        session.keep(name, outcome)
                        session.report()
                elif missing:
                    with _workers(count, scheduler) as pool:
                        done_by(*pool, missing, session.keep, session.report)
        except KeyboardInterrupt:
            done, total = (session.done, session.total) if session else (0, len(self._wanted()))
            raise StudyInterrupted(path, done, total) from None
        except BrokenProcessPool as error:
            assert session is not None
            if interrupts.came:
                # Ctrl-C in a terminal reaches new processes before they have been set to ignore it.
                raise StudyInterrupted(path, session.done, session.total) from None
            raise WorkersLost(path, session.done, session.total) from error
        except CancelledError as error:
            assert session is not None
            reason = (
                f"the connection was lost after {session.done} of {session.total} trials; they "
                f"are in {path}, run the benchmark again"
            )
            raise SchedulerUnavailable(str(scheduler), reason) from error
        return len(missing)

    def _wanted(self) -> dict[str, tuple[Trial, Entry]]:
        """Return trials with their entries by key, each once."""
        wanted: dict[str, tuple[Trial, Entry]] = {}
        for trial in self.trials():
            for entry in self.entries.values():
                one = own_trial(entry, trial)
                wanted.setdefault(key(entry, one), (one, entry))
        return wanted

    def board(self) -> Board:
        """Return the scores of the outcomes in the file."""
        there = OutcomeFile(self.directory / FILE).outcomes()
        own = {
            (entry, own_trial(entry, trial))
            for entry in self.entries.values()
            for trial in self.trials()
        }
        found = {(entry.name, trial): there.get(key(entry, trial)) for entry, trial in own}
        return Board(
            tuple(self.entries.values()),
            {place: outcome for place, outcome in found.items() if outcome is not None},
            self.robots,
            self.conditions,
            self.seeds,
            self.duration,
            self.period,
        )


def _workers(
    count: int, scheduler: str | None
) -> AbstractContextManager[tuple[Executor, Callable[[], int]]]:
    if scheduler is None:
        return processes(count)
    return cluster.connected(scheduler, stamp, one_thread=True)


class _Session:
    """The progress of one call of :meth:`Benchmark.run`."""

    def __init__(
        self,
        file: OutcomeFile,
        total: int,
        there: int,
        progress: Progress | None,
        interrupts: Interrupts,
    ) -> None:
        self.total, self.done = total, there
        self._file, self._there, self._progress = file, there, progress
        self._interrupts = interrupts
        self._start = time.monotonic()

    def keep(self, name: str, outcome: Outcome) -> None:
        self._file.add(name, outcome)
        self.done += 1

    def report(self) -> None:
        if self._progress is not None:
            now, passed = self.done - self._there, time.monotonic() - self._start
            # The caller's ``progress`` may take long or wait for something.
            with self._interrupts.obeyed_at_once():
                self._progress(self.done, self.total, now / passed if now else 0.0)
