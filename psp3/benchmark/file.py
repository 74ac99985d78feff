"""Outcomes of trials on disk: an SQLite file with one row for each trial of each entry.

A row is there whole or not at all. It is committed when its trial is done, and has a checksum that
is verified when it is read. A lost row is a trial that is not done, and the board says so. The key
of a row is everything that determines the outcome: entry, the mark of its file, the trial's fields
and the sources of the packages. So the same benchmark resumes where it was stopped. An entry whose
file was changed runs again, and all entries do if the packages were changed.
"""

from __future__ import annotations

import json
import math
import sqlite3
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path

from psp3.benchmark.entries import Entry
from psp3.benchmark.stamp import stamp
from psp3.benchmark.trial import Outcome, Trial
from psp3.errors import InvalidStudyFile, StudyFileNotWritable
from psp3.study.file import is_still, literal

APPLICATION = int.from_bytes(b"PSPB", "big")
"""Identifier of these files (SQLite's ``application_id``)."""

FORMAT = 2
"""Version of the layout; a file with any other is refused."""

PATIENCE = 30.0
"""How long to wait for another benchmark that writes to the file [s]."""


def key(entry: Entry, trial: Trial) -> str:
    """Return the text that identifies a trial of an entry."""
    fields = {name: "inf" if value == math.inf else value for name, value in asdict(trial).items()}
    # In ASCII, because a file's name, and thus an entry's, may hold bytes that are not characters.
    return json.dumps([stamp(), entry.name, entry.mark, fields])


class OutcomeFile:
    """A file of outcomes, which is made if it does not exist.

    Parameters
    ----------
    path : path
        The file.

    Raises
    ------
    InvalidStudyFile
        If it exists and is not the file of a benchmark.
    StudyFileNotWritable
        If it cannot be made.
    """

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path).resolve()
        with self._connected() as connection:
            ((application,),) = connection.execute("PRAGMA application_id").fetchall()
            ((version,),) = connection.execute("PRAGMA user_version").fetchall()
            ((tables,),) = connection.execute("SELECT count(*) FROM sqlite_master").fetchall()
            if tables == 0 and application == 0:
                with connection:
                    connection.execute("BEGIN IMMEDIATE")
                    connection.execute(
                        "CREATE TABLE IF NOT EXISTS outcomes "
                        "(key TEXT PRIMARY KEY, outcome TEXT NOT NULL, "
                        "checksum INTEGER NOT NULL) WITHOUT ROWID"
                    )
                    connection.execute(f"PRAGMA application_id = {APPLICATION}")
                    connection.execute(f"PRAGMA user_version = {FORMAT}")
            elif (application, version) != (APPLICATION, FORMAT):
                raise InvalidStudyFile(
                    self.path,
                    f"is not the file of a benchmark of this version: it has mark {application} "
                    f"and version {version}, and {APPLICATION} and {FORMAT} are read; give "
                    "another directory",
                )
        self._place = self.path.stat()

    def outcomes(self) -> dict[str, Outcome]:
        """Return all outcomes by key.

        Raises
        ------
        InvalidStudyFile
            If a row differs from what was written.
        """
        with self._connected() as connection:
            rows = connection.execute("SELECT key, outcome, checksum FROM outcomes").fetchall()
        for row in rows:
            if not _is_whole(*row):
                raise InvalidStudyFile(
                    self.path,
                    f"is damaged: the outcome of {str(row[0])[:200]} does not match its checksum; "
                    "delete such rows and run the benchmark again to repeat their trials (DELETE "
                    f"FROM outcomes WHERE checksum IS {literal(row[2])})",
                )
        return {name: json.loads(outcome) for name, outcome, _ in rows}

    def add(self, name: str, outcome: Outcome) -> None:
        """Commit an outcome; one with the same key is replaced.

        Raises
        ------
        StudyFileNotWritable
            If it cannot be written, or the file was moved or deleted.
        """
        if not is_still(self.path, self._place):
            raise StudyFileNotWritable(
                self.path,
                "it was deleted or replaced while the benchmark was running; put it back and run "
                "the benchmark again; otherwise it repeats all its trials",
            )
        # Outcomes hold finite numbers only, because a diverged run has a flag instead of errors.
        text = json.dumps(outcome, allow_nan=False)
        row = name, text, _checksum(name, text)
        with self._connected() as connection, connection:
            connection.execute("INSERT OR REPLACE INTO outcomes VALUES (?, ?, ?)", row)

    @contextmanager
    def _connected(self) -> Iterator[sqlite3.Connection]:
        try:
            connection = sqlite3.connect(self.path, isolation_level=None, timeout=PATIENCE)
        except sqlite3.Error as error:
            raise StudyFileNotWritable(self.path, str(error)) from error
        try:
            yield connection
        except (sqlite3.DatabaseError, UnicodeDecodeError) as error:
            # Full disks and locked files are operational errors; a file that is not a database is
            # not.
            if isinstance(error, sqlite3.OperationalError):
                raise StudyFileNotWritable(self.path, str(error)) from error
            raise InvalidStudyFile(
                self.path, f"is not the file of a benchmark, or is damaged ({error})"
            ) from error
        finally:
            connection.close()


def _checksum(name: str, outcome: str) -> int:
    return zlib.crc32(outcome.encode(), zlib.crc32(name.encode()))


def _is_whole(name: object, outcome: object, checksum: object) -> bool:
    return (
        isinstance(name, str)
        and isinstance(outcome, str)
        and type(checksum) is int
        and checksum == _checksum(name, outcome)
    )
