"""Workers that run trials: processes of this machine, or of a dask cluster."""

from __future__ import annotations

import itertools
import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import CancelledError, Executor, Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager

from psp3.benchmark.entries import Entry, said
from psp3.benchmark.trial import Outcome, Trial, execute
from psp3.study.interrupts import noted_interrupts
from psp3.study.study import HANDED_OUT, LOOK_UP
from psp3.study.under_way import UnderWay

ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
"""Environment variables that keep a worker to one core, because times are compared and matrices are
small."""

_ONE_AT_A_TIME = threading.Lock()


@contextmanager
def processes(count: int) -> Iterator[tuple[Executor, Callable[[], int]]]:
    """Yield an executor of new processes with one thread each, and their number."""
    before = {name: os.environ.get(name) for name in ONE_THREAD}
    os.environ.update(dict.fromkeys(ONE_THREAD, "1"))
    try:
        with ProcessPoolExecutor(
            count, multiprocessing.get_context("spawn"), _leave_interrupts_to_the_parent
        ) as pool:
            yield pool, lambda: count
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


def _leave_interrupts_to_the_parent() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def done_by(
    executor: Executor,
    count_workers: Callable[[], int],
    missing: Mapping[str, tuple[Trial, Entry]],
    keep: Callable[[str, Outcome], None],
    report: Callable[[], None],
) -> None:
    """Hand out trials, a few at a time, and keep each outcome when it comes back.

    If one trial makes its worker fail, for example because the entry repeatedly ends the process,
    this failure is the outcome of the trial.

    Parameters
    ----------
    executor : concurrent.futures.Executor
        Executor that does the trials.
    count_workers : callable
        Returns how many trials it does at a time.
    missing : mapping
        Trials with their entries, by key.
    keep : callable
        Called with key and outcome.
    report : callable
        Called when outcomes have been kept.

    Raises
    ------
    BrokenProcessPool, CancelledError
        If all workers are lost.
    KeyboardInterrupt
        After Ctrl-C; what had begun is kept, if it still comes back.
    """
    waiting = iter(missing.items())
    under_way: UnderWay[str, Outcome] = UnderWay()
    with noted_interrupts(under_way.wake) as interrupts:
        try:
            while True:
                with interrupts.obeyed_at_once():
                    workers = max(1, count_workers())
                for name, work in itertools.islice(
                    waiting, max(0, HANDED_OUT * workers - len(under_way))
                ):
                    under_way.hand_out(executor, name, _execute_alone, *work)
                if not under_way:
                    return
                # The wait is limited, because count_workers detects a lost cluster that dask does
                # not report.
                if _keep(under_way, LOOK_UP, keep):
                    report()
        except KeyboardInterrupt:
            # Trials that have begun end soon, and are kept.
            under_way.cancel()
            while under_way:
                _keep(under_way, None, keep)
            raise
        finally:
            under_way.cancel()


def _keep(
    under_way: UnderWay[str, Outcome],
    patience: float | None,
    keep: Callable[[str, Outcome], None],
) -> int:
    """Keep outcomes that come back, return their number, and raise the error that lost others."""
    lost: BrokenProcessPool | CancelledError | None = None
    finished = under_way.finished(patience)
    for future in finished:
        try:
            keep(under_way.take(future), _outcome(future))
        except (BrokenProcessPool, CancelledError) as error:
            # The others that came back are kept first.
            lost = error
    if lost is not None:
        raise lost
    return len(finished)


def _outcome(future: Future[Outcome]) -> Outcome:
    try:
        return future.result()
    except (BrokenProcessPool, CancelledError):
        raise
    except Exception as error:
        return {"error": said(error)}


def _execute_alone(trial: Trial, entry: Entry) -> Outcome:
    """Do a trial, one at a time, because steps are timed and robots are not safe for threads."""
    with _ONE_AT_A_TIME:
        return execute(trial, entry)
