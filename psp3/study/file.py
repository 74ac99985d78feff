"""Results of a study on disk: an SQLite file with one row per run.

What the file promises, and how:

* A row is there whole or not at all, and what was committed survives ``kill -9``, a full disk and a
  loss of power: a plain rollback journal with full synchronization. Not a write-ahead log, whose
  rows would live in a second file that a copy of the first forgets.
* A row is decided by its run alone. Its key is the run's content, it holds no times or worker
  names, and the table is stored in the order of its keys, so studies that were interrupted and
  studies that were not end with the same table.
* Numbers come back as they went in. Infinity is a number to SQLite; NaN is NULL there, and NULL is
  read as NaN, since no metric is ever absent.
* One study writes at a time. Its lock belongs to the process and ends with it, however it ends.
  Reading is always possible.
* A file of another program, another format, other fields, or runs of another length is refused with
  an error that says so. A file from before the fields in :data:`ADDED` is read as if its runs had
  their defaults, and gets their columns when it is extended.
"""

from __future__ import annotations

import fcntl
import json
import os
import socket
import sqlite3
import stat
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import fields
from functools import cache
from pathlib import Path
from typing import Any, get_args, get_type_hints

from psp3.errors import InvalidStudyFile, PSP3Error, StudyFileNotWritable, StudyInUse, StudyMismatch
from psp3.study.run import METRICS, Run

FORMAT = 1
"""Version of the file's layout (SQLite's ``user_version``); any other is refused."""

APPLICATION = int.from_bytes(b"PSP3", "big")
"""Mark of our files (SQLite's ``application_id``), by which ``file`` and we tell them from other
databases.
"""

SHARED = ("duration",)
"""Fields that are the same in all runs of a file: errors are summed over that time, and other sums
do not go into one table.
"""

ADDED = (("snr_reference", "noisy_entries"), ("defuzzify",))
"""Last fields of a run, in the groups in which they were added: files that were written before lack
one group or more. A run with their defaults is the run that it was before, and has the same key.
"""

PATIENCE = 30.0
"""How long to wait for another program that has locked the database for a moment [s]."""

Value = str | int | float | None
Row = dict[str, Any]


@cache
def field_types() -> dict[str, type[str] | type[int] | type[float]]:
    """Return the type of every field of :class:`~psp3.study.run.Run`, without None."""
    hints = get_type_hints(Run)
    return {
        field.name: next(iter(get_args(hints[field.name])), hints[field.name])
        for field in fields(Run)
    }


def contents(run: Run) -> dict[str, Value]:
    """Return the values of a run's fields, each in the type of its field.

    So 20 and 20.0 dB are one run.
    """
    values = ((name, kind, getattr(run, name)) for name, kind in field_types().items())
    # Adding zero makes 0.0 of -0.0.
    return {
        name: None if value is None else kind(value) + 0.0 if kind is float else kind(value)
        for name, kind, value in values
    }


def key(run: Run) -> str:
    """Return the text that identifies a run: its contents as JSON.

    Without the last groups of :data:`ADDED` of which all fields are at their defaults.
    """
    values, defaults = contents(run), _defaults_of_added()
    for group in reversed(ADDED):
        if any(values[name] != defaults[name] for name in group):
            break
        for name in group:
            del values[name]
    return json.dumps(list(values.values()), ensure_ascii=False)


@cache
def _defaults_of_added() -> dict[str, str]:
    added = {name for group in ADDED for name in group}
    return {field.name: str(field.default) for field in fields(Run) if field.name in added}


class StudyFile:
    """A file of results. Making this object writes nothing.

    It refuses a file that is there and is not of this kind.

    Parameters
    ----------
    path : path
        The file.
    shared : mapping, optional
        Values of the fields in :data:`SHARED` that the file must have.

    Raises
    ------
    InvalidStudyFile, StudyMismatch
        If the file exists and cannot be used.
    """

    def __init__(self, path: str | Path, shared: Mapping[str, Value] | None = None) -> None:
        # Resolved once: links to one file are one file, and a later change of directory changes
        # nothing.
        self.path = Path(path).resolve()
        self._shared = shared
        if self.path.exists():
            with self._reading() as connection:
                if not _is_empty(connection):
                    self._check(connection)

    def rows(self) -> dict[str, Row]:
        """Return fields and metrics of every run in the file by key, in the order of the fields.

        Raises
        ------
        InvalidStudyFile, StudyMismatch
            If there is no file or it cannot be used.
        """
        if not self.path.exists():
            raise InvalidStudyFile(self.path, "there is no such file")
        names = (*field_types(), *METRICS)
        order = ", ".join(map(_quoted, field_types()))
        with self._reading() as connection:
            if _is_empty(connection):
                raise InvalidStudyFile(self.path, "holds no results yet")
            self._check(connection)
            absent = self._lacks(connection)
            columns = ", ".join(
                f"{_text(_defaults_of_added()[name])} AS {_quoted(name)}"
                if name in absent
                else _quoted(name)
                for name in names
            )
            table = connection.execute(
                f"SELECT key, {columns} FROM runs ORDER BY {order}"
            ).fetchall()
        return {
            row[0]: {name: _read(name, value) for name, value in zip(names, row[1:], strict=True)}
            for row in table
        }

    @contextmanager
    def adding(self) -> Iterator[Additions]:
        """Open the file to add results, and keep every other study from doing so.

        Make it if it does not exist.

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
        with self._locked(), self._writing() as connection:
            with _transaction(connection):
                if _is_empty(connection) or _has_no_results(connection):
                    self._create(connection)
                else:
                    self._check(connection)
                    self._check_package(connection)
                    self._add_columns(connection)
                # A write that changes nothing: a disk that is full, or a directory that takes no
                # journal, is found out now.
                connection.execute("UPDATE meta SET value = value")
            yield Additions(connection, self)

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
            # Not read-only where it can be helped: what a killed study left half written must be
            # rolled back before anyone reads.
            with self._connected("rw") as connection:
                yield connection
        except sqlite3.Error as error:
            raise InvalidStudyFile(
                self.path, f"is not the file of a study, or cannot be read ({error})"
            ) from error

    @contextmanager
    def _writing(self) -> Iterator[sqlite3.Connection]:
        try:
            with self._connected("rwc") as connection:
                connection.execute("PRAGMA synchronous = FULL")
                yield connection
        except sqlite3.Error as error:
            raise self.translated(error) from error

    def translated(self, error: sqlite3.Error, kept: int = 0) -> PSP3Error:
        """Return our error for one of SQLite's while writing.

        ``kept`` is how many results are in the file.
        """
        # Extended codes carry the primary one in their low byte.
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
            # Root may write to all files; one that is marked read-only is nonetheless meant to stay
            # as it is.
            if path.exists() and not (
                os.access(path, os.W_OK) and stat.S_IMODE(path.stat().st_mode) & 0o222
            ):
                raise StudyFileNotWritable(
                    self.path,
                    f"{'it' if path == self.path else f'the directory {path}'} is read-only",
                )

    def _create(self, connection: sqlite3.Connection) -> None:
        from psp3.version import __version__

        sql_types = {str: "TEXT NOT NULL", int: "INTEGER NOT NULL", float: "REAL"}
        columns = [f"{_quoted(name)} {sql_types[kind]}" for name, kind in field_types().items()]
        columns += [f"{_quoted(name)} REAL" for name in METRICS]
        for table in ("runs", "meta"):
            connection.execute(f"DROP TABLE IF EXISTS {table}")
        connection.execute(
            f"CREATE TABLE runs (key TEXT PRIMARY KEY, {', '.join(columns)}) WITHOUT ROWID"
        )
        connection.execute(
            "CREATE TABLE meta (name TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID"
        )
        notes = {
            "package_version": __version__,
            **self._layout(),
            "shared": dict(self._shared or {}),
        }
        connection.executemany(
            "INSERT INTO meta VALUES (?, ?)",
            [(name, json.dumps(value)) for name, value in notes.items()],
        )
        connection.execute(f"PRAGMA application_id = {APPLICATION}")
        connection.execute(f"PRAGMA user_version = {FORMAT}")

    @staticmethod
    def _layout() -> dict[str, list[str]]:
        return {
            "fields": [f"{name}: {kind.__name__}" for name, kind in field_types().items()],
            "metrics": list(METRICS),
        }

    def _lacks(self, connection: sqlite3.Connection) -> tuple[str, ...]:
        """Return the fields that were added after the file was written: whole groups of them."""
        written = self._notes(connection)["fields"]
        layout = self._layout()["fields"]
        for first in range(len(ADDED)):
            absent = tuple(name for group in ADDED[first:] for name in group)
            if written == layout[: len(layout) - len(absent)]:
                return absent
        return ()

    def _add_columns(self, connection: sqlite3.Connection) -> None:
        """Give a file from before some fields their columns, with defaults in every row."""
        absent = self._lacks(connection)
        for name in absent:
            connection.execute(
                f"ALTER TABLE runs ADD COLUMN {_quoted(name)} TEXT NOT NULL "
                f"DEFAULT {_text(_defaults_of_added()[name])}"
            )
        if absent:
            connection.execute(
                "UPDATE meta SET value = ? WHERE name = 'fields'",
                (json.dumps(self._layout()["fields"]),),
            )

    @staticmethod
    def _notes(connection: sqlite3.Connection) -> dict[str, Any]:
        return {
            name: json.loads(value)
            for name, value in connection.execute("SELECT name, value FROM meta")
        }

    def _check(self, connection: sqlite3.Connection) -> None:
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
            raise StudyMismatch(self.path, "format version", version, FORMAT)
        notes = self._notes(connection)
        for name, expected in self._layout().items():
            if notes[name] != expected and not (name == "fields" and self._lacks(connection)):
                here, there = (
                    [entry for entry in one if entry not in other]
                    for one, other in ((expected, notes[name]), (notes[name], expected))
                )
                raise StudyMismatch(
                    self.path, f"list of {name}", there or notes[name], here or expected
                )
        if self._shared is not None and not _has_no_results(connection):
            for name, value in self._shared.items():
                if notes["shared"][name] != value:
                    raise StudyMismatch(self.path, f"{name} [s]", notes["shared"][name], value)

    def _check_package(self, connection: sqlite3.Connection) -> None:
        from psp3.version import __version__

        # Reading is fine, but numbers of two versions do not go into one table.
        version = self._notes(connection)["package_version"]
        if version != __version__:
            raise StudyMismatch(self.path, "version of psp3", version, __version__)

    @contextmanager
    def _locked(self) -> Iterator[None]:
        """Hold the lock, a file beside the results.

        SQLite's own locks on a database drop when any handle on it is closed.
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
            with suppress(FileNotFoundError):
                if os.path.samestat(os.fstat(handle), path.stat()):
                    break
            os.close(handle)
        try:
            # who holds it is for the reader of a message; the lock is what counts
            with suppress(OSError):
                os.ftruncate(handle, 0)
                os.write(handle, f"process {os.getpid()} on {socket.gethostname()}".encode())
            yield
        finally:
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

    Attributes
    ----------
    keys : set of str
        Keys of the runs that are in the file.
    """

    def __init__(self, connection: sqlite3.Connection, file: StudyFile) -> None:
        self._connection, self._file = connection, file
        self.keys = {str(name) for (name,) in connection.execute("SELECT key FROM runs")}

    def add(self, results: Iterable[tuple[Run, Mapping[str, float]]]) -> None:
        """Commit results, all of them or none.

        Those of runs that are in the file already change nothing.

        Raises
        ------
        StudyFileNotWritable
            If the disk is full, for example; everything committed before stays.
        """
        rows: dict[str, tuple[Value, ...]] = {}
        for run, metrics in results:
            rows[key(run)] = (*contents(run).values(), *(metrics[name] for name in METRICS))
        if not rows:
            return
        # By name, for a file that was extended by fields has them at its end.
        names = ("key", *field_types(), *METRICS)
        columns, places = ", ".join(map(_quoted, names)), ", ".join("?" * len(names))
        try:
            with _transaction(self._connection):
                self._connection.executemany(
                    f"INSERT OR IGNORE INTO runs ({columns}) VALUES ({places})",
                    [(name, *values) for name, values in rows.items()],
                )
        except sqlite3.Error as error:
            raise self._file.translated(error, len(self.keys)) from error
        self.keys.update(rows)


@contextmanager
def _transaction(connection: sqlite3.Connection) -> Iterator[None]:
    if connection.in_transaction:
        # Ctrl-C came in the moment after the transaction began, before anybody minded it.
        connection.execute("ROLLBACK")
    try:
        connection.execute("BEGIN IMMEDIATE")
        yield
        connection.execute("COMMIT")
    except BaseException:
        # SQLite has rolled back by itself when the disk is full.
        if connection.in_transaction:
            connection.execute("ROLLBACK")
        raise


def _is_empty(connection: sqlite3.Connection) -> bool:
    """Tell whether this is a database without anything.

    A study leaves such a one if it was killed before its first commit.
    """
    (tables,), (application,) = (
        connection.execute(q).fetchone()
        for q in ("SELECT count(*) FROM sqlite_master", "PRAGMA application_id")
    )
    return bool(tables == 0 and application == 0)


def _has_no_results(connection: sqlite3.Connection) -> bool:
    """Tell whether this is a study's file without a row.

    One that was stopped before its first result. It binds nobody.
    """
    (application,) = connection.execute("PRAGMA application_id").fetchone()
    return (
        bool(application == APPLICATION)
        and connection.execute("SELECT 1 FROM runs LIMIT 1").fetchone() is None
    )


def _quoted(name: str) -> str:
    return '"' + name.replace('"', '""') + '"'


def _text(value: str) -> str:
    return "'" + value.replace("'", "''") + "'"


def _read(name: str, value: Value) -> Value:
    return float("nan") if value is None and name in METRICS else value
