"""Results of a study on disk: an SQLite file with one row per run.

What the file promises, and how:

* Results are committed in groups. A result is on disk within :data:`GROUP`, half a second, after it
  came back, and then survives ``kill -9``, a full disk and a loss of power. The file uses a plain
  rollback journal with full synchronization. It does not use a write-ahead log, because that keeps
  rows in a second file, which is missed when only the first one is copied. At worst half a second
  of work is lost and done again.
* A row is there whole or not at all. It has a checksum of its setting, seed and metrics, which is
  verified when the row is read: a bit that flipped on the disk gives an error that names the run.
* The file stores its number of rows, which its own triggers maintain, so a lost or duplicated page
  is an error, too.
* A file that is deleted or replaced while a study writes to it ends the study.
* A row depends on its run alone: no times or worker names are stored, so a study ends with the same
  rows whether it was interrupted or not. Settings, which are all fields of a run but the seed, have
  a table of their own. The view ``results`` joins both tables.
* Numbers are read exactly as they were written. SQLite stores infinity as a number and NaN as NULL;
  NULL is read as NaN, because no metric is ever absent.
* One study writes at a time. Its lock belongs to the process and is released when the process ends,
  for whatever reason. Reading is always possible.
* A file of another program, another format, other fields, or runs of another length is refused,
  with an error that gives the reason.
"""

from __future__ import annotations

import fcntl
import itertools
import json
import math
import os
import socket
import sqlite3
import stat
import time
import zlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from psp3.checks import Array, checked_path
from psp3.errors import InvalidStudyFile, PSP3Error, StudyFileNotWritable, StudyInUse, StudyMismatch
from psp3.study.columns import AT_A_TIME, RunColumns
from psp3.study.keys import (
    SEED_BYTES,
    Keys,
    as_keys,
    is_seed,
    setting_key,
    setting_keys,
    setting_names,
    setting_values,
)
from psp3.study.run import METRICS, Run, Value, field_types
from psp3.study.table import Table

FORMAT = 3
"""Version of the file's layout (SQLite's ``user_version``); a file with any other is refused."""

APPLICATION = int.from_bytes(b"PSP3", "big")
"""Identifier of our files (SQLite's ``application_id``); the tool ``file`` and this module
recognize them by it.
"""

GROUP = 0.5
"""Time within which results are on disk [s]. They are committed after half of it, which leaves the
other half for the disk.
"""

PATIENCE = 30.0
"""How long to wait for another program that has locked the database for a moment [s]."""

_NOTES = {"package_version": str, "fields": list, "metrics": list, "shared": dict, "runs": int}
"""Names of the notes on the whole file in the table ``meta``, and their types."""

_TRIGGERS = {"added": ("INSERT", "+"), "removed": ("DELETE", "-")}
"""Triggers that maintain the number of rows, also when a user deletes one with SQLite's own
tools."""

_ANEW = "restore a copy, or use another file, in which the runs are done again"

_ROW = np.dtype([("seed", "<i8"), ("metrics", "<f8", (len(METRICS),))])
"""Layout of the data that a checksum covers, after the setting's key."""


def checksums(settings: Iterable[bytes], seeds: Any, metrics: Any) -> list[int]:
    """Return each row's CRC-32 checksum of the key of its setting, its seed and its metrics."""
    numbers = np.array(metrics, dtype=float)
    content = np.empty(len(numbers), dtype=_ROW)
    # One zero and one NaN, because SQLite keeps neither the sign of zero nor the bits of a NaN.
    content["seed"], content["metrics"] = seeds, numbers + 0.0
    content["metrics"][np.isnan(numbers)] = math.nan
    text, size, crc = content.tobytes(), _ROW.itemsize, zlib.crc32
    ends = range(size, len(text) + 1, size)
    return [
        crc(text[end - size : end], crc(setting))
        for setting, end in zip(settings, ends, strict=True)
    ]


class StudyFile:
    """A file of results. Making this object writes nothing.

    It refuses an existing file that is not the file of a study.

    Parameters
    ----------
    path : path
        The file.
    shared : mapping, optional
        Values of the fields in :data:`psp3.study.keys.SHARED` that the file must have.

    Raises
    ------
    InvalidStudyFile, StudyMismatch
        If the file exists and cannot be used.
    """

    def __init__(self, path: str | Path, shared: Mapping[str, Value] | None = None) -> None:
        # Resolved once: links to one file are one file, and a later change of directory changes
        # nothing.
        self.path = checked_path("path", path).resolve()
        self._shared = shared
        if self.path.exists():
            with self._reading() as connection:
                if not _is_empty(connection):
                    self._check(connection)

    def rows(self) -> Table:
        """Return the fields and metrics of every run in the file, ordered by the fields.

        Raises
        ------
        InvalidStudyFile, StudyMismatch
            If there is no file, it cannot be used, or a row differs from what was written.
        """
        if not self.path.exists():
            raise InvalidStudyFile(self.path, "there is no such file")
        with self._reading() as connection:
            if _is_empty(connection):
                raise InvalidStudyFile(self.path, "holds no results yet")
            count = self._check(connection)["runs"]
            identities, keys, settings = self._settings(connection)
            whole, metrics = self._columns(connection, identities, settings)
        number_of = {identity: k for k, identity in enumerate(identities)}
        try:
            setting = [number_of[identity] for identity in whole[:, 0].tolist()]
        except KeyError as error:
            raise InvalidStudyFile(
                self.path,
                f"is damaged: rows refer to the setting {error}, which is missing; delete them "
                f"and run the study again (DELETE FROM runs WHERE setting = {error})",
            ) from None
        found = checksums(map(keys.__getitem__, setting), whole[:, 1], metrics)
        table = Table(settings, setting, whole[:, 1], metrics)
        wrong = np.flatnonzero(np.array(found, dtype=np.int64) != whole[:, 2])
        if wrong.size:
            raise self._damaged(table.run(int(wrong[0])), whole[wrong[0]], len(wrong))
        if not _are_in_order(whole[:, 0], whole[:, 1]):
            reason = f"is damaged: rows are duplicated or out of order; {_ANEW}"
            raise InvalidStudyFile(self.path, reason)
        self.check_count(len(whole), count)
        return table.in_order()

    def _settings(
        self, connection: sqlite3.Connection
    ) -> tuple[list[int], list[bytes], RunColumns]:
        """Return the numbers, keys and values of the settings, after verifying each."""
        names = ", ".join(map(_quoted, setting_names()))
        cursor = connection.execute(f"SELECT id, key, {names} FROM settings")
        identities: list[int] = []
        keys: list[bytes] = []
        blocks: list[RunColumns] = []
        while rows := cursor.fetchmany(AT_A_TIME):
            own, theirs, *columns = zip(*rows, strict=True)
            block = RunColumns(dict(zip(setting_names(), columns, strict=True)), len(rows))
            for identity, key, expected, place in zip(
                own, theirs, setting_keys(block), range(len(rows)), strict=True
            ):
                if key != expected:
                    raise self._wrong_setting(identity, block[place])
            identities += own
            keys += theirs
            blocks.append(block)
        return identities, keys, RunColumns.joined(blocks)

    def _columns(
        self, connection: sqlite3.Connection, identities: list[int], settings: RunColumns
    ) -> tuple[NDArray[np.int64], Array]:
        """Return numbers of settings, seeds and checksums (N, 3), and metrics (N, K)."""
        columns = ", ".join(map(_quoted, METRICS))
        cursor = connection.execute(f"SELECT setting, seed, checksum, {columns} FROM runs")
        whole, metrics = [np.empty((0, 3), np.int64)], [np.empty((0, len(METRICS)))]
        while rows := cursor.fetchmany(AT_A_TIME):
            if not _are_numbers(rows):
                row = next(row for row in rows if not _are_numbers([row]))
                raise self._no_numbers(row, dict(zip(identities, settings, strict=True)))
            whole.append(np.array([row[:3] for row in rows], dtype=np.int64))
            metrics.append(np.array([row[3:] for row in rows], dtype=float))
        return np.concatenate(whole), np.concatenate(metrics)

    def _wrong_setting(self, identity: int, run: Run) -> InvalidStudyFile:
        return InvalidStudyFile(
            self.path,
            f"is damaged: setting {identity}, {run}, differs from what was written; delete its "
            f"runs and run the study again (DELETE FROM runs WHERE setting = {identity}; "
            f"DELETE FROM settings WHERE id = {identity})",
        )

    def _no_numbers(self, row: tuple[Any, ...], settings: Mapping[int, Run]) -> InvalidStudyFile:
        setting, seed = row[:2]
        name = f"setting {setting} and seed {seed}"
        if setting in settings and is_seed(seed):
            name = str(replace(settings[setting], seed=seed))
        return InvalidStudyFile(
            self.path,
            f"is damaged: the row of {name} holds values that are not numbers; delete it and run "
            f"the study again to repeat that run (DELETE FROM runs WHERE setting IS "
            f"{literal(setting)} AND seed IS {literal(seed)})",
        )

    def _damaged(self, run: Run, whole: NDArray[np.int64], count: int) -> InvalidStudyFile:
        more = f", and {count - 1} more rows are damaged" if count > 1 else ""
        return InvalidStudyFile(
            self.path,
            f"is damaged: the row of {run} does not match its checksum{more}; delete it and run "
            f"the study again to repeat that run (DELETE FROM runs WHERE setting = {whole[0]} "
            f"AND seed = {whole[1]})",
        )

    def check_count(self, found: int, written: int) -> None:
        """Raise InvalidStudyFile if a file does not hold as many rows as were written."""
        if found != written:
            raise InvalidStudyFile(
                self.path,
                f"is damaged: it holds {found} rows, but {written} were written; {_ANEW}, or "
                f"accept these rows and run the study again to repeat the lost ones "
                f"(UPDATE meta SET value = {found} WHERE name = 'runs')",
            )

    @contextmanager
    def adding(self) -> Iterator[Additions]:
        """Open the file to add results, and lock it against other studies that would do so.

        The file is made if it does not exist.

        Raises
        ------
        StudyInUse
            If another study, in this process or another one, is adding results.
        StudyFileNotWritable
            If directory, file or disk do not allow it.
        InvalidStudyFile, StudyMismatch
            If the file cannot be used.
        """
        self._check_permissions()
        with self._locked() as lock, self._writing() as connection:
            with _transaction(connection):
                if _is_empty(connection) or _has_no_results(connection):
                    self._create(connection)
                else:
                    self._check(connection)
                    self._check_package(connection)
                # A write that changes nothing shows now whether the disk is full or the directory
                # takes no journal.
                connection.execute("UPDATE meta SET value = value")
            additions = Additions(connection, self, {**lock, self.path: self.path.stat()})
            try:
                yield additions
            finally:
                # Results that came back are kept if possible, however the work ends.
                additions.commit()

    @contextmanager
    def _connected(self, mode: str) -> Iterator[sqlite3.Connection]:
        connection = sqlite3.connect(
            f"{self.path.as_uri()}?mode={mode}", uri=True, isolation_level=None, timeout=PATIENCE
        )
        try:
            yield connection
        finally:
            connection.close()

    @contextmanager
    def _reading(self) -> Iterator[sqlite3.Connection]:
        if self.path.is_dir():
            raise InvalidStudyFile(self.path, "is a directory")
        try:
            # Opened for writing if possible: a transaction that a killed study left unfinished must
            # be rolled back before the file is read.
            with self._connected("rw") as connection:
                # A transaction, so that all reads see the file at one moment while others add to
                # it.
                connection.execute("BEGIN")
                yield connection
        except (sqlite3.Error, UnicodeDecodeError) as error:
            raise InvalidStudyFile(
                self.path, f"is not the file of a study, or cannot be read ({error})"
            ) from error

    @contextmanager
    def _writing(self) -> Iterator[sqlite3.Connection]:
        try:
            with self._connected("rwc") as connection:
                connection.execute("PRAGMA synchronous = FULL")
                yield connection
        except (sqlite3.Error, UnicodeDecodeError) as error:
            raise self.translated(error) from error

    def translated(self, error: Exception, kept: int = 0) -> PSP3Error:
        """Return our error for an SQLite error while writing.

        ``kept`` is how many results are in the file.
        """
        # The low byte of an extended error code is the primary code.
        code = getattr(error, "sqlite_errorcode", sqlite3.SQLITE_CORRUPT) & 0xFF
        reasons = {
            sqlite3.SQLITE_FULL: "the disk is full",
            sqlite3.SQLITE_READONLY: "the file or its file system is read-only",
            sqlite3.SQLITE_BUSY: f"another program has kept it locked for {PATIENCE:g} s",
            sqlite3.SQLITE_IOERR: (
                f"the disk failed ({error}, {getattr(error, 'sqlite_errorname', '')})"
            ),
            sqlite3.SQLITE_CANTOPEN: f"SQLite cannot open it, or its journal beside it ({error})",
        }
        if code in reasons:
            return StudyFileNotWritable(self.path, reasons[code], kept)
        return InvalidStudyFile(self.path, f"is not the file of a study, or is damaged ({error})")

    def _check_permissions(self) -> None:
        directory = self.path.parent
        if not directory.is_dir():
            raise StudyFileNotWritable(self.path, f"there is no directory {directory}")
        for path in (directory, self.path):
            # Root may write to any file, but a file marked read-only is meant to stay as it is.
            if path.exists() and not (
                os.access(path, os.W_OK) and stat.S_IMODE(path.stat().st_mode) & 0o222
            ):
                raise StudyFileNotWritable(
                    self.path,
                    f"{'it' if path == self.path else f'the directory {path}'} is read-only",
                )

    def _create(self, connection: sqlite3.Connection) -> None:
        from psp3.version import __version__

        sql_types = {str: "TEXT", int: "INTEGER", float: "REAL"}
        types = field_types()
        of_setting = [f"{_quoted(name)} {sql_types[types[name]]}" for name in setting_names()]
        of_run = [f"{_quoted(name)} REAL" for name in METRICS]
        connection.execute("DROP VIEW IF EXISTS results")
        for table in ("runs", "settings", "meta"):
            connection.execute(f"DROP TABLE IF EXISTS {table}")
        connection.execute(
            "CREATE TABLE settings (id INTEGER PRIMARY KEY, key BLOB NOT NULL UNIQUE, "
            f"{', '.join(of_setting)})"
        )
        connection.execute(
            "CREATE TABLE runs (setting INTEGER NOT NULL, seed INTEGER NOT NULL, "
            f"{', '.join(of_run)}, checksum INTEGER NOT NULL, PRIMARY KEY (setting, seed)) "
            "WITHOUT ROWID"
        )
        columns = ", ".join(map(_quoted, (*types, *METRICS)))
        connection.execute(
            f"CREATE VIEW results AS SELECT {columns} FROM runs JOIN settings ON setting = id"
        )
        connection.execute(
            "CREATE TABLE meta (name TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID"
        )
        notes = {
            "package_version": __version__,
            **self._layout(),
            "shared": dict(self._shared or {}),
            "runs": 0,
        }
        connection.executemany(
            "INSERT INTO meta VALUES (?, ?)",
            [(name, json.dumps(value)) for name, value in notes.items()],
        )
        for name, (event, sign) in _TRIGGERS.items():
            connection.execute(
                f"CREATE TRIGGER {name} AFTER {event} ON runs BEGIN "
                f"UPDATE meta SET value = value {sign} 1 WHERE name = 'runs'; END"
            )
        connection.execute(f"PRAGMA application_id = {APPLICATION}")
        connection.execute(f"PRAGMA user_version = {FORMAT}")

    @staticmethod
    def _layout() -> dict[str, list[str]]:
        return {
            "fields": [f"{name}: {kind.__name__}" for name, kind in field_types().items()],
            "metrics": list(METRICS),
        }

    def _notes(self, connection: sqlite3.Connection) -> dict[str, Any]:
        notes = {}
        for name, value in connection.execute("SELECT name, value FROM meta"):
            with suppress(TypeError, ValueError, RecursionError):
                notes[name] = json.loads(value)
        for name, kind in _NOTES.items():
            if type(notes.get(name)) is not kind:
                raise InvalidStudyFile(
                    self.path,
                    f"is damaged: its note of {name} differs from what was written; {_ANEW}",
                )
        return notes

    def _check(self, connection: sqlite3.Connection) -> dict[str, Any]:
        """Return the notes of a file after checking that it is a study's."""
        (application,), (version,) = (
            connection.execute(f"PRAGMA {name}").fetchone()
            for name in ("application_id", "user_version")
        )
        if application != APPLICATION:
            raise InvalidStudyFile(
                self.path,
                f"is not the file of a study, but of a program that marks its files {application}",
            )
        if version != FORMAT:
            raise StudyMismatch(
                self.path,
                "format version",
                version,
                FORMAT,
                f"read it with the psp3 that wrote it, psp3.Study({self.path.name!r}).export(...), "
                "or use another file, in which the runs are done again; this one stays as it is",
            )
        notes = self._notes(connection)
        for name, expected in self._layout().items():
            if notes[name] != expected:
                here, there = (
                    [entry for entry in one if entry not in other]
                    for one, other in ((expected, notes[name]), (notes[name], expected))
                )
                raise StudyMismatch(
                    self.path, f"list of {name}", there or notes[name], here or expected
                )
        if self._shared is not None and not _has_no_results(connection):
            for name, value in self._shared.items():
                if notes["shared"].get(name) != value:
                    found = notes["shared"].get(name)
                    raise StudyMismatch(self.path, f"{name} [s]", found, value)
        return notes

    def _check_package(self, connection: sqlite3.Connection) -> None:
        from psp3.version import __version__

        # Reading is fine, but results of two versions must not be mixed in one table.
        version = self._notes(connection)["package_version"]
        if version != __version__:
            raise StudyMismatch(self.path, "version of psp3", version, __version__)

    @contextmanager
    def _locked(self) -> Iterator[dict[Path, os.stat_result]]:
        """Hold the lock, a file beside the results, and yield its path and identity.

        SQLite's own locks do not suffice: they are released when any handle on the database is
        closed.
        """
        path = self.path.with_name(self.path.name + ".lock")
        while True:
            try:
                handle = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
            except OSError as error:
                raise StudyFileNotWritable(
                    self.path, f"its lock {path.name} cannot be made ({error.strerror})"
                ) from error
            try:
                fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                holder = os.read(handle, 200).decode(errors="replace") or "another process"
                os.close(handle)
                raise StudyInUse(self.path, holder) from None
            # Between our opening and locking it, its holder may have ended and removed it.
            if is_still(path, os.fstat(handle)):
                break
            os.close(handle)
        try:
            # this text only tells the reader of an error message who holds the lock
            with suppress(OSError):
                os.ftruncate(handle, 0)
                os.write(handle, f"process {os.getpid()} on {socket.gethostname()}".encode())
            yield {path: os.fstat(handle)}
        finally:
            if is_still(path, os.fstat(handle)):
                path.unlink(missing_ok=True)
            os.close(handle)


class Additions:
    """A study's file while results are added; :meth:`StudyFile.adding` gives it.

    Parameters
    ----------
    connection : sqlite3.Connection
        Connection in autocommit mode.
    file : StudyFile
        What it belongs to.
    held : mapping of Path to os.stat_result
        Which files must stay where they are: this one and its lock.

    Attributes
    ----------
    keys : (N,) ndarray of bytes
        Keys of the runs that were in the file.
    committed : int
        Number of runs that are in it.
    """

    def __init__(
        self,
        connection: sqlite3.Connection,
        file: StudyFile,
        held: Mapping[Path, os.stat_result],
    ) -> None:
        self._connection, self._file, self._held = connection, file, held
        self.keys, self._numbers = _read_keys(connection)
        self.committed = len(self.keys)
        file.check_count(self.committed, _count(connection))
        self._waiting: list[tuple[Run, tuple[float, ...]]] = []
        self._since = math.inf

    @property
    def waiting(self) -> int:
        """Number of results that came back but are not committed yet."""
        return len(self._waiting)

    def due(self) -> float:
        """Return the time until waiting results must be committed [s]; infinite without any."""
        return max(0.0, self._since + 0.5 * GROUP - time.monotonic())

    def add(self, results: Iterable[tuple[Run, Mapping[str, float]]]) -> None:
        """Take results, and commit all that wait once the first has waited long enough.

        Results of runs that are already in the file change nothing.

        Raises
        ------
        StudyFileNotWritable
            If the disk is full, for example, or the file was moved or deleted. Everything committed
            before stays.
        """
        self._check_place()
        for run, found in results:
            self._waiting.append((run, tuple(found[name] for name in METRICS)))
        if self._waiting and self._since == math.inf:
            self._since = time.monotonic()
        if self.due() == 0.0:
            self.commit()

    def commit(self) -> None:
        """Commit all waiting results, or none of them.

        Raises
        ------
        StudyFileNotWritable
            As from :meth:`add`; the waiting results are then lost.
        """
        if not self._waiting:
            return
        self._check_place()
        # An interrupt may come at any line, so waiting results are dropped only after their commit;
        # committing a result twice does no harm.
        results = list(self._waiting)
        settings = [setting_values(run) for run, _ in results]
        keys = [setting_key(values) for values in settings]
        metrics = [values for _, values in results]
        sums = checksums(keys, [run.seed for run, _ in results], metrics)
        try:
            with _transaction(self._connection):
                numbers = self._numbered(dict(zip(keys, settings, strict=True)))
                places = ", ".join("?" * (len(METRICS) + 3))
                self._connection.executemany(
                    f"INSERT OR IGNORE INTO runs VALUES ({places})",
                    [
                        (numbers[name], run.seed, *values, checksum)
                        for name, (run, values), checksum in zip(keys, results, sums, strict=True)
                    ],
                )
                committed = _count(self._connection)
        except sqlite3.Error as error:
            self._forget(len(results))
            # SQLite reports a deleted file as read-only.
            self._check_place()
            raise self._file.translated(error, self.committed) from error
        self.committed = committed
        self._numbers = numbers
        self._forget(len(results))
        # Checked again, because an open file still accepts rows after it was deleted.
        self._check_place()

    def _check_place(self) -> None:
        for path, status in self._held.items():
            if not is_still(path, status):
                # Rows written to a deleted file are lost when it is closed.
                self._forget(len(self._waiting))
                raise StudyFileNotWritable(
                    self._file.path,
                    f"{path.name} was deleted or replaced while the study was running; put it back "
                    "and run the study again; otherwise it repeats all its runs",
                )

    def _forget(self, count: int) -> None:
        del self._waiting[:count]
        self._since = time.monotonic() if self._waiting else math.inf

    def _numbered(self, settings: Mapping[bytes, tuple[Value, ...]]) -> dict[bytes, int]:
        """Return the numbers of all settings by key, after adding settings that are new."""
        new = [name for name in settings if name not in self._numbers]
        if not new:
            return self._numbers
        numbers = dict(self._numbers)
        places = ", ".join("?" * (len(setting_names()) + 2))
        last = max(numbers.values(), default=0)
        for number, name in enumerate(new, start=last + 1):
            numbers[name] = number
            self._connection.execute(
                f"INSERT INTO settings VALUES ({places})", (number, name, *settings[name])
            )
        return numbers


def _read_keys(connection: sqlite3.Connection) -> tuple[Keys, dict[bytes, int]]:
    """Return the keys of the runs in a file, and the numbers of its settings by their keys."""
    by_number = dict(connection.execute("SELECT id, key FROM settings"))
    content = bytearray()
    try:
        for number, seed in connection.execute("SELECT setting, seed FROM runs"):
            content += by_number[number] + seed.to_bytes(SEED_BYTES, "big")
    except (KeyError, AttributeError, OverflowError) as error:
        raise sqlite3.DatabaseError(f"a row has no setting or seed: {error!r}") from error
    return as_keys(content), {name: number for number, name in by_number.items()}


def _count(connection: sqlite3.Connection) -> int:
    """Return the number of rows that a file's note states."""
    (text,) = connection.execute("SELECT value FROM meta WHERE name = 'runs'").fetchone()
    return int(text)


def _are_numbers(rows: Sequence[tuple[object, ...]]) -> bool:
    """Return whether each row is three integers followed by numbers or NULL."""
    columns = tuple(zip(*rows, strict=True))
    of_whole, of_metrics = (
        set(map(type, itertools.chain.from_iterable(part))) for part in (columns[:3], columns[3:])
    )
    return of_whole <= {int} and of_metrics <= {int, float, type(None)}


def _are_in_order(settings: NDArray[np.int64], seeds: NDArray[np.int64]) -> bool:
    """Return whether rows are ordered by setting and seed without duplicates, as in their table."""
    further = settings[1:] > settings[:-1]
    same = settings[1:] == settings[:-1]
    return bool((further | (same & (seeds[1:] > seeds[:-1]))).all())


def literal(value: object) -> str:
    """Return a value of a damaged file as an SQL literal."""
    if isinstance(value, bytes):
        return f"x'{value.hex()}'"
    if isinstance(value, str):
        return "'" + value.replace("'", "''") + "'"
    return "NULL" if value is None else repr(value).replace("inf", "9e999")


def is_still(path: Path, status: os.stat_result) -> bool:
    """Return whether a path still leads to this file."""
    try:
        return os.path.samestat(path.stat(), status)
    except OSError:
        return False


@contextmanager
def _transaction(connection: sqlite3.Connection) -> Iterator[None]:
    if connection.in_transaction:
        # Ctrl-C came just after the transaction began, before the ``try`` below was entered.
        connection.execute("ROLLBACK")
    try:
        connection.execute("BEGIN IMMEDIATE")
        yield
        connection.execute("COMMIT")
    except BaseException:
        # When the disk is full SQLite has already rolled back by itself.
        if connection.in_transaction:
            connection.execute("ROLLBACK")
        raise


def _is_empty(connection: sqlite3.Connection) -> bool:
    """Return whether a database is empty.

    A study that is killed before its first commit leaves an empty database.
    """
    (tables,), (application,) = (
        connection.execute(q).fetchone()
        for q in ("SELECT count(*) FROM sqlite_master", "PRAGMA application_id")
    )
    return bool(tables == 0 and application == 0)


def _has_no_results(connection: sqlite3.Connection) -> bool:
    """Return whether a study's file has no rows.

    A study that was stopped before its first result leaves such a file. It may be used for other
    runs.
    """
    (application,) = connection.execute("PRAGMA application_id").fetchone()
    return (
        bool(application == APPLICATION)
        and connection.execute("SELECT 1 FROM runs LIMIT 1").fetchone() is None
    )


def _quoted(name: str) -> str:
    return '"' + name.replace('"', '""') + '"'
