"""What the tests of studies share.

Quick runs, runs without a simulation, and what is done in processes that are killed.
"""

from __future__ import annotations

import os
import resource
import signal
import sqlite3
import time
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from psp3.errors import StudyFileNotWritable
from psp3.study import Study, grid, study
from psp3.study import file as study_file
from psp3.study.file import StudyFile
from psp3.study.run import METRICS, Run

QUICK: dict[str, Any] = {"controller": ("t1", "it2", "pd"), "snr_db": (20.0, 10.0), "duration": 0.3}
"""Fields of runs that take milliseconds; PD sees no noise under the default reading, so it is one
run.
"""

SHARED = {"duration": Run().duration}


def invented(run: Run) -> dict[str, float]:
    """Stand in for :func:`psp3.study.execution.execute` where the simulation does not matter.

    The metrics depend on seed and name alone.
    """
    return {name: run.seed + 0.1 * number for number, name in enumerate(METRICS)}


def count_rows(path: Path) -> int:
    """Return how many results are in a file that may not be there yet."""
    return len(Study(path).rows()) if path.exists() and path.stat().st_size else 0


# What is done in processes that are killed


def die() -> None:
    """End as by ``kill -9``: no handlers, no clean-up."""
    os.kill(os.getpid(), signal.SIGKILL)


def die_within_a_transaction(path: Path) -> None:
    with StudyFile(path, SHARED).adding() as additions:
        additions.add([(Run(seed=1), invented(Run(seed=1)))])
        additions.commit()
        # No room in the cache, so that what is not committed is in the file already.
        additions._connection.execute("PRAGMA cache_size = 1")
        additions._connection.execute("BEGIN IMMEDIATE")
        # As the first row, but with other seeds.
        columns = [
            row[1]
            for row in additions._connection.execute("PRAGMA table_info(runs)")
            if row[1] not in ("setting", "seed")
        ]
        for number in range(1000, 1300):
            additions._connection.execute(
                f"INSERT INTO runs SELECT setting, {number}, {', '.join(columns)} FROM runs LIMIT 1"
            )
        die()


def die_while_the_file_is_made(path: Path) -> None:
    file = StudyFile(path, SHARED)
    create = file._create

    def create_and_die(connection: sqlite3.Connection) -> None:
        connection.execute("PRAGMA cache_size = 1")
        create(connection)
        connection.executemany(
            "INSERT INTO meta VALUES (?, 'x')", [(100 * str(number),) for number in range(300)]
        )
        die()

    file._create = create_and_die  # type: ignore[method-assign]
    with file.adding():
        pass


def hold_the_lock(path: Path, parent: Connection) -> None:
    """Hold it until killed, or until the parent is gone."""
    with StudyFile(path, SHARED).adding():
        parent.send(True)
        parent.recv()


def run_with_small_files(path: Path, kept: Connection) -> None:
    resource.setrlimit(resource.RLIMIT_FSIZE, (80_000, 80_000))
    study_file.GROUP = 0.0
    study.execute = invented  # type: ignore[attr-defined]
    try:
        Study(path, grid(snr_db=20.0, seed=range(500))).run()
    except StudyFileNotWritable as error:
        kept.send(error.kept)


def run_until(
    path: Path, runs: tuple[Run, ...], workers: int, rows: int, parent: Connection
) -> None:
    """Do a study; from so many rows on, report each time and go on when the parent says so.

    Every result is committed at once, so that what is reported is in the file.
    """
    study_file.GROUP = 0.0

    def hold(done: int, total: int, rate: float) -> None:
        if done >= rows:
            parent.send(done)
            parent.recv()

    Study(path, runs).run(workers, progress=hold)


def run_and_tell(path: Path, runs: int, parent: Connection) -> None:
    """Do quick runs, and tell at what time how many of them had come back."""

    def slowly(run: Run) -> dict[str, float]:
        time.sleep(0.002)
        return invented(run)

    study.execute = slowly  # type: ignore[attr-defined]
    Study(path, grid(snr_db=20.0, seed=range(runs))).run(
        1, progress=lambda done, total, rate: parent.send((time.monotonic(), done))
    )
