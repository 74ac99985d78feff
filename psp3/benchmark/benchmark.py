"""The benchmark: entries times robots, noises and seeds, done in processes and kept in a file."""

from __future__ import annotations

import itertools
import math
import multiprocessing
import os
import signal
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from pathlib import Path

from psp3.benchmark.baselines import BASELINES, NEED_SCIKIT_LEARN, REFERENCE
from psp3.benchmark.board import Board
from psp3.benchmark.entries import Entry, load_entry
from psp3.benchmark.file import OutcomeFile, key
from psp3.benchmark.readings import NONE, READINGS
from psp3.benchmark.regressors import need_scikit_learn
from psp3.benchmark.tasks import ROBOTS
from psp3.benchmark.trial import Outcome, Trial, execute
from psp3.checks import checked_count
from psp3.errors import InvalidValue, StudyInterrupted, UnknownName, WorkersLost

ALL = "all"
"""Stands for all entries that come with the package."""

FILE, PAGE, NUMBERS = "benchmark.sqlite", "benchmark.html", "benchmark.json"
"""Names of the files of a benchmark in its directory."""

HANDED_OUT = 2
"""Trials under way for each worker, so that none waits."""

ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
"""What keeps a worker to one core: times are compared, and matrices are small."""

Progress = Callable[[int, int, float], None]


class Benchmark:
    """Entries, and what they are asked to do.

    Without noise an entry runs once, unless it draws random numbers; what sees no noise of a
    reading runs as without.

    Parameters
    ----------
    directory : path
        Where outcomes are kept; made by :meth:`run` if it is not there.
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
        Number of seeds, from 0 on.
    duration, period : float
        Length of each run and control period [s].

    Raises
    ------
    UnknownName, InvalidValue, InvalidEntry
        If a name is unknown, a number is outside of what it can be, a file is no entry, or two
        entries have one name.
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
        self.directory = Path(directory)
        self._sources: dict[str, str | Entry] = {}
        self.entries: dict[str, Entry] = {}
        for source in (REFERENCE, *entries):
            for one in BASELINES if source == ALL else (source,):
                self._enter(one)
        if set(NEED_SCIKIT_LEARN) & set(self._sources.values()):
            need_scikit_learn()
        self.robots, self.readings = tuple(dict.fromkeys(robots)), tuple(dict.fromkeys(readings))
        self.levels = tuple(dict.fromkeys(map(float, levels)))
        self.seeds = checked_count("seeds", seeds)
        self.duration, self.period = duration, period
        if not self.robots:
            raise InvalidValue("robots", robots, f"at least one of {', '.join(ROBOTS)}")
        for reading in self.readings:
            if reading not in READINGS:
                raise UnknownName("reading of noise", reading, tuple(READINGS))
        for level in self.levels:
            if not math.isfinite(level):
                wanted = "finite ratios [dB]; runs without noise are always done, too"
                raise InvalidValue("levels", level, wanted)
        for trial in self.trials(seeds=1):
            trial.check()

    def _enter(self, source: str | Entry) -> None:
        if isinstance(source, Entry):
            entry = source
        elif source in BASELINES:
            entry = BASELINES[source]
        elif source.endswith(".py"):
            entry = load_entry(source)
        else:
            known = (ALL, *BASELINES, "or a file that ends in .py")
            raise UnknownName("entry", source, known)
        before = self._sources.setdefault(entry.name, source)
        if before != source:
            raise InvalidValue(
                "entries", entry.name, f"of different names; {before} and {source} have the same"
            )
        self.entries[entry.name] = entry

    @property
    def conditions(self) -> tuple[tuple[str, float], ...]:
        """Readings with their ratios, first none."""
        return ((NONE, math.inf), *itertools.product(self.readings, self.levels))

    def trials(self, seeds: int | None = None) -> Iterator[Trial]:
        """Yield the trials of an entry whose every outcome depends on the seed.

        Seeds vary slowest, so that what was stopped holds whole comparisons.
        """
        for seed in range(self.seeds if seeds is None else seeds):
            for robot in self.robots:
                for reading, snr_db in self.conditions:
                    yield Trial(robot, reading, snr_db, seed, self.duration, self.period)

    def own(self, entry: Entry, trial: Trial) -> Trial:
        """Return the trial whose outcome is that of an entry's trial.

        It is the same one, but for noise that the entry does not see and seeds without meaning.
        """
        is_measured = trial.reading != NONE and READINGS[trial.reading].noise is None
        if not (is_measured or entry.learns):
            trial = Trial(trial.robot, NONE, math.inf, trial.seed, trial.duration, trial.period)
        if trial.reading != NONE or entry.draws:
            return trial
        return Trial(trial.robot, NONE, math.inf, 0, trial.duration, trial.period)

    def run(self, workers: int | None = None, progress: Progress | None = None) -> int:
        """Do the trials that are not yet in the file; each is kept when it is done.

        What an entry raised is tried again.

        Parameters
        ----------
        workers : int, optional
            Number of processes, all cores of this process unless given; 1 is this process.
        progress : callable, optional
            Called with the number of trials that are done, the number of all, and the rate since
            the start [1/s].

        Returns
        -------
        int
            How many trials were done now.

        Raises
        ------
        InvalidValue
            If ``workers`` is not a positive integer.
        InvalidStudyFile, StudyFileNotWritable
            If the file cannot be used.
        WorkersLost
            If a process ended before its time.
        StudyInterrupted
            After Ctrl-C; what was done stays.
        """
        count = (
            len(os.sched_getaffinity(0)) if workers is None else checked_count("workers", workers)
        )
        self.directory.mkdir(parents=True, exist_ok=True)
        file = OutcomeFile(self.directory / FILE)
        wanted: dict[str, tuple[Entry, Trial]] = {}
        for trial in self.trials():
            for entry in self.entries.values():
                one = self.own(entry, trial)
                wanted.setdefault(key(entry, one), (entry, one))
        there = {name for name, outcome in file.outcomes().items() if outcome["error"] is None}
        missing = {name: work for name, work in wanted.items() if name not in there}
        session = _Session(file, len(wanted), len(wanted) - len(missing), progress)
        session.report()
        try:
            if count == 1:
                for name, (entry, trial) in missing.items():
                    session.keep(name, execute(trial, entry))
            elif missing:
                self._in_processes(missing, count, session)
        except KeyboardInterrupt:
            raise StudyInterrupted(file.path, session.done, session.total) from None
        except BrokenProcessPool as error:
            raise WorkersLost(file.path, session.done, session.total) from error
        return len(missing)

    def _in_processes(
        self, missing: dict[str, tuple[Entry, Trial]], count: int, session: _Session
    ) -> None:
        waiting = iter(missing.items())
        under_way: dict[Future[Outcome], str] = {}
        with _pool(count) as pool:
            try:
                while True:
                    room = HANDED_OUT * count - len(under_way)
                    for name, (entry, trial) in itertools.islice(waiting, room):
                        source = self._sources[entry.name]
                        under_way[pool.submit(_execute_from, source, trial)] = name
                    if not under_way:
                        return
                    for future in wait(under_way, return_when=FIRST_COMPLETED).done:
                        session.keep(under_way[future], future.result())
                        del under_way[future]
            except KeyboardInterrupt:
                # What has begun is soon done, and is kept.
                kept = [future for future in under_way if not future.cancel()]
                for future in wait(kept).done:
                    session.keep(under_way[future], future.result())
                raise

    def board(self) -> Board:
        """Return the scores of what is in the file."""
        there = OutcomeFile(self.directory / FILE).outcomes()
        found = {
            (entry.name, trial): there.get(key(entry, self.own(entry, trial)))
            for entry in self.entries.values()
            for trial in self.trials()
        }
        return Board(
            tuple(self.entries.values()),
            {place: outcome for place, outcome in found.items() if outcome is not None},
            self.robots,
            self.conditions,
            self.seeds,
            self.duration,
            self.period,
        )


class _Session:
    """One call of :meth:`Benchmark.run`: what is done, and how fast."""

    def __init__(
        self, file: OutcomeFile, total: int, there: int, progress: Progress | None
    ) -> None:
        self.total, self.done = total, there
        self._file, self._there, self._progress = file, there, progress
        self._start = time.monotonic()

    def keep(self, name: str, outcome: Outcome) -> None:
        self._file.add(name, outcome)
        self.done += 1
        self.report()

    def report(self) -> None:
        if self._progress is not None:
            now, passed = self.done - self._there, time.monotonic() - self._start
            self._progress(self.done, self.total, now / passed if now else 0.0)


@contextmanager
def _pool(count: int) -> Iterator[ProcessPoolExecutor]:
    """Yield new processes, each with one thread for its linear algebra."""
    before = {name: os.environ.get(name) for name in ONE_THREAD}
    os.environ.update(dict.fromkeys(ONE_THREAD, "1"))
    try:
        with ProcessPoolExecutor(
            count, multiprocessing.get_context("spawn"), _leave_interrupts_to_the_parent
        ) as pool:
            yield pool
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


def _leave_interrupts_to_the_parent() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def _execute_from(source: str | Entry, trial: Trial) -> Outcome:
    """Do a trial of an entry that a process finds by its name or file."""
    if isinstance(source, Entry):
        return execute(trial, source)
    return execute(trial, BASELINES[source] if source in BASELINES else load_entry(source))
