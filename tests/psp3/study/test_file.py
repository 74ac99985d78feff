"""The file of a study.

What goes in comes out, what is committed stays, and what does not belong is refused.
"""

from __future__ import annotations

import json
import math
import os
import signal
import sqlite3
import struct
import time
from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import psp3
from psp3.errors import InvalidStudyFile, PSP3Error, StudyFileNotWritable, StudyInUse, StudyMismatch
from psp3.study import file as study_file
from psp3.study.file import APPLICATION, FORMAT, GROUP, Additions, StudyFile, checksums
from psp3.study.keys import Runs, key, setting_key, setting_values
from psp3.study.run import METRICS, Run, contents
from psp3.study.table import Table
from tests.processes import PROCESSES, answer_of, start
from tests.study_helpers import (
    SHARED,
    die_while_the_file_is_made,
    die_within_a_transaction,
    hold_the_lock,
    invented,
    run_with_small_files,
)

RUNS = [
    Run(controller=controller, snr_db=snr, seed=seed)
    for controller in ("t1", "it2")
    for snr in (20.0, math.inf)
    for seed in range(3)
]


@pytest.fixture
def path(tmp_path: Path) -> Path:
    """Name a file that does not exist yet.

    It has characters that mean something in the addresses that SQLite takes.
    """
    return tmp_path / "study of 100% ?a=b#c.sqlite"


def fill(path: Path, runs: Sequence[Run] = RUNS, one_by_one: bool = False) -> StudyFile:
    file = StudyFile(path, SHARED)
    with file.adding() as additions:
        for batch in [[run] for run in runs] if one_by_one else [runs]:
            additions.add([(run, invented(run)) for run in batch])
            additions.commit()
    return file


def change(path: Path, *statements: str) -> None:
    with closing(sqlite3.connect(path)) as connection, connection:
        for statement in statements:
            connection.execute(statement)


def keys_of(table: Table) -> list[bytes]:
    return [key(table.run(k)) for k in range(len(table))]


class Failing:
    """A connection whose second row of so many numbers cannot be written."""

    def __init__(self, connection: sqlite3.Connection, numbers: int) -> None:
        self._connection, self._numbers = connection, numbers

    def __getattr__(self, name: str) -> Any:
        return getattr(self._connection, name)

    def executemany(self, statement: str, rows: Sequence[tuple[Any, ...]]) -> None:
        """Write the first row, and fail at the second."""
        assert len(rows[0]) == self._numbers
        self._connection.execute(statement, rows[0])
        raise sqlite3.OperationalError("no room")


@contextmanager
def patched(owner: object, name: str, value: object) -> Iterator[None]:
    before = getattr(owner, name)
    setattr(owner, name, value)
    yield
    setattr(owner, name, before)


# What goes in comes out


@settings(
    max_examples=25,
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
@given(
    values=st.lists(st.floats(), min_size=len(METRICS), max_size=len(METRICS)),
    snr=st.floats(allow_nan=False),
)
def test_numbers_come_back_bit_for_bit(tmp_path: Path, values: list[float], snr: float) -> None:
    """Infinite, tiny and NaN included.

    Every NaN is one NaN, and SQLite writes zero without its sign; all else by its bits.
    """
    path = tmp_path / "numbers.sqlite"
    path.unlink(missing_ok=True)
    run = Run(snr_db=snr, mean_variation=0.1)
    with StudyFile(path).adding() as additions:
        additions.add([(run, dict(zip(METRICS, values, strict=True)))])
    (row,) = StudyFile(path).rows()
    assert [row[name].hex() for name in METRICS] == [(value + 0.0).hex() for value in values]
    assert row["snr_db"].hex() == (snr + 0.0).hex()
    assert {name: row[name] for name in contents(run)} == contents(run)


def test_fields_come_back_in_their_types_and_none_as_none(path: Path) -> None:
    run = Run(controller="pd", snr_db=20, seed=7)
    (row,) = fill(path, [run]).rows()
    assert {name: (type(row[name]), row[name]) for name in contents(run)} == {
        n: (type(v), v) for n, v in contents(run).items()
    }
    assert row["mean_variation"] is None
    assert type(row["snr_db"]) is float
    assert type(row["seed"]) is int


def test_table_does_not_depend_on_the_order_in_which_runs_end(path: Path, tmp_path: Path) -> None:
    other = tmp_path / "other.sqlite"
    one = fill(path)
    fill(other, RUNS[::-1], one_by_one=True)
    assert list(one.rows()) == list(StudyFile(other).rows())

    def raw(file: Path) -> list[Any]:
        connection = sqlite3.connect(file)
        rows = connection.execute("SELECT * FROM results").fetchall()
        connection.close()
        return sorted(rows)

    assert raw(path) == raw(other)
    assert len(raw(path)) == len(RUNS)
    for row in one.rows():
        assert tuple(row.values()) in raw(path), "what others read of the file with SQL"


def test_rows_come_in_the_order_of_their_fields_as_numbers(path: Path) -> None:
    """Not in that of their texts, in which 10 comes before 9."""
    runs = [
        Run(controller, snr_db=snr, seed=seed)
        for controller in ("ctc", "it2")
        for snr in (9.0, 10.0, 100.0)
        for seed in (2, 10)
    ]
    rows = fill(path, runs[::-1]).rows()
    assert keys_of(rows) == [key(run) for run in runs]


def test_results_that_come_together_are_committed_together(path: Path) -> None:
    """The second result of the batch cannot be written.

    So the first one must not be in the file either.
    """
    with StudyFile(path, SHARED).adding() as additions:
        additions.add([(RUNS[0], invented(RUNS[0]))])
        additions.commit()
        number = len(METRICS) + 3
        with patched(additions, "_connection", Failing(additions._connection, number)):
            additions.add([(run, invented(run)) for run in RUNS[1:3]])
            with pytest.raises(InvalidStudyFile, match="no room"):
                additions.commit()
        assert additions.committed == 1
        assert keys_of(StudyFile(path).rows()) == [key(RUNS[0])]


def test_interrupts_around_a_transaction_do_no_harm(path: Path) -> None:
    """Ctrl-C can come between any two lines.

    After a transaction has begun, and after it was committed but not yet noted.
    """
    batch = [(run, invented(run)) for run in RUNS]
    with StudyFile(path, SHARED).adding() as additions:
        additions._connection.execute("BEGIN IMMEDIATE")
        additions._connection.execute("DELETE FROM meta")
        additions.add(batch)
        additions.commit()
        additions.add(batch)
        additions.commit()
        assert additions.committed == len(RUNS)
    assert len(StudyFile(path, SHARED).rows()) == len(RUNS)


def test_file_can_be_read_while_results_are_added(path: Path) -> None:
    with StudyFile(path, SHARED).adding() as additions:
        for number, run in enumerate(RUNS, start=1):
            additions.add([(run, invented(run))])
            additions.commit()
            assert len(StudyFile(path).rows()) == number


# Groups of commits


def test_what_is_read_is_of_one_moment(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A row that came between settings and rows would have a setting that is not there."""
    settings = StudyFile._settings
    locked = []

    def and_somebody_writes(file: StudyFile, connection: sqlite3.Connection) -> Any:
        found = settings(file, connection)
        other = sqlite3.connect(path, timeout=0.0)
        try:
            other.execute("DELETE FROM runs")
            other.commit()
        except sqlite3.OperationalError as error:
            locked.append(str(error))
        other.close()
        return found

    fill(path)
    before = StudyFile(path).rows()
    monkeypatch.setattr(StudyFile, "_settings", and_somebody_writes)
    assert len(StudyFile(path).rows()) == len(before)
    assert locked == ["database is locked"]


def test_results_are_committed_within_half_a_second(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By a clock of ours: nothing at first, and all when the first has waited half of it."""
    now = [100.0]
    monkeypatch.setattr(study_file.time, "monotonic", lambda: now[0])
    with StudyFile(path, SHARED).adding() as additions:
        assert additions.due() == math.inf
        for number, run in enumerate(RUNS[:3]):
            now[0] = 100.0 + 0.1 * GROUP * number
            additions.add([(run, invented(run))])
        assert (additions.committed, additions.waiting) == (0, 3)
        assert additions.due() == pytest.approx(0.3 * GROUP)
        assert StudyFile(path).rows().column("seed").size == 0
        now[0] = 100.0 + 0.5 * GROUP
        assert additions.due() == 0.0
        additions.add([])
        assert (additions.committed, additions.waiting) == (3, 0)
        assert len(StudyFile(path).rows()) == 3
        assert additions.due() == math.inf
        additions.add([(RUNS[3], invented(RUNS[3]))])
    assert len(StudyFile(path).rows()) == 4, "what waits at the end is committed"


def test_many_results_cost_few_commits(path: Path) -> None:
    """As many as there are groups: SQLite counts changes of the file in its header."""
    runs = [Run(seed=seed) for seed in range(500)]

    def changes() -> int:
        return int.from_bytes(path.read_bytes()[24:28], "big")

    with StudyFile(path, SHARED).adding() as additions:
        before = changes()
        start = time.monotonic()
        for run in runs:
            additions.add([(run, invented(run))])
        took = time.monotonic() - start
    assert changes() - before <= 2 + took / (0.5 * GROUP)
    assert len(StudyFile(path).rows()) == len(runs)


# Checksums


def test_checksum_is_that_of_setting_seed_and_metrics() -> None:
    """CRC-32 by the table of its polynomial, of the bytes as they are described."""
    table = []
    for byte in range(256):
        remainder = byte
        for _ in range(8):
            remainder = remainder >> 1 ^ (0xEDB88320 if remainder & 1 else 0)
        table.append(remainder)
    run, values = Run(seed=7), [float(k) for k in range(len(METRICS) - 2)] + [-0.0, -math.nan]
    content = setting_key(setting_values(run)) + struct.pack("<q", 7)
    content += struct.pack(f"<{len(METRICS)}d", *values[:-2], 0.0, math.nan)
    crc = 0xFFFFFFFF
    for byte in content:
        crc = crc >> 8 ^ table[(crc ^ byte) & 0xFF]
    found = checksums([setting_key(setting_values(run))], [7], [values])
    assert found == [crc ^ 0xFFFFFFFF]


@pytest.mark.parametrize(
    "statement",
    [
        "UPDATE runs SET rms_error = rms_error + 1e-15 WHERE seed = 1 AND setting = 2",
        "UPDATE runs SET coverage = NULL WHERE seed = 1 AND setting = 2",
        "UPDATE runs SET seed = 100 WHERE seed = 1 AND setting = 2",
        "UPDATE runs SET checksum = checksum + 1 WHERE seed = 1 AND setting = 2",
        "UPDATE runs SET setting = 1, seed = 100 WHERE seed = 1 AND setting = 2",
    ],
)
def test_row_that_is_not_what_was_written_is_named(path: Path, statement: str) -> None:
    fill(path)
    change(path, statement)
    with pytest.raises(InvalidStudyFile, match=r"checksum.*run the study again") as refusal:
        StudyFile(path).rows()
    assert "Run(controller='t1'" in str(refusal.value)
    remedy = str(refusal.value).split("(")[-1].rstrip(")")
    change(path, remedy)
    assert len(StudyFile(path).rows()) == len(RUNS) - 1, "and what the message says helps"


def test_setting_that_is_not_what_was_written_is_named(path: Path) -> None:
    fill(path)
    change(path, "UPDATE settings SET payload = 1.0 WHERE id = 3")
    with pytest.raises(InvalidStudyFile, match=r"setting 3, Run.*payload=1.0") as refusal:
        StudyFile(path).rows()
    change(path, *str(refusal.value).split("(")[-1].rstrip(")").split("; "))
    assert len(StudyFile(path).rows()) == len(RUNS) - 3
    assert len(fill(path).rows()) == len(RUNS), "numbers of settings are not given twice"


@pytest.mark.parametrize("bit", [0, 23, 51, 52, 62, 63])
def test_bit_that_fell_over_on_the_disk_is_named(path: Path, bit: int) -> None:
    """In the file itself, in a number that it holds once, most significant byte first."""
    run, number = Run("ctc", "plant", 20.0, seed=5), 0.1234567890123
    with StudyFile(path, SHARED).adding() as additions:
        additions.add([(run, {**invented(run), "rms_error": number})])
    content = bytearray(path.read_bytes())
    packed = struct.pack(">d", number)
    assert content.count(packed) == 1
    content[content.index(packed) + 7 - bit // 8] ^= 1 << bit % 8
    path.write_bytes(content)
    with pytest.raises(InvalidStudyFile, match="does not match its checksum") as refusal:
        StudyFile(path).rows()
    assert str(run) in str(refusal.value)


@pytest.mark.parametrize("value", ["'much'", "x'3132'", "x''"])
@pytest.mark.parametrize("column", ["rms_error", "checksum"])
def test_row_of_what_is_no_number_is_named(path: Path, column: str, value: str) -> None:
    fill(path)
    change(path, f"UPDATE runs SET {column} = {value} WHERE seed = 1 AND setting = 2")
    with pytest.raises(InvalidStudyFile, match="values that are not numbers") as refusal:
        StudyFile(path).rows()
    assert "the row of Run(controller='t1'" in str(refusal.value)
    assert "seed=1)" in str(refusal.value)
    change(path, str(refusal.value).split("(")[-1].rstrip(")"))
    assert len(StudyFile(path).rows()) == len(RUNS) - 1


@pytest.mark.parametrize("seed", ["'one''s'", "x'00ff'", "9e999", "-9e999", "1.5"])
def test_row_whose_seed_is_no_number_is_named(path: Path, seed: str) -> None:
    fill(path)
    change(path, f"UPDATE runs SET seed = {seed} WHERE seed = 1 AND setting = 2")
    with pytest.raises(InvalidStudyFile, match="row of setting 2 and seed ") as refusal:
        StudyFile(path).rows()
    change(path, str(refusal.value).split("(")[-1].rstrip(")"))
    assert len(StudyFile(path).rows()) == len(RUNS) - 1


def test_row_without_its_setting_is_named(path: Path) -> None:
    fill(path)
    change(path, "UPDATE runs SET setting = 99 WHERE seed = 1 AND setting = 2")
    with pytest.raises(InvalidStudyFile, match="has no setting"):
        fill(path)
    with pytest.raises(InvalidStudyFile, match="setting 99, which is missing") as refusal:
        StudyFile(path).rows()
    change(path, str(refusal.value).split("(")[-1].rstrip(")"))
    assert len(StudyFile(path).rows()) == len(RUNS) - 1


# Every damage is noticed


VALUES = ("'abc'", "x'00'", "NULL", "1.5", "-1", "9e999", "''")


@pytest.mark.parametrize("value", VALUES)
def test_any_value_in_any_column_is_what_was_written_or_refused(path: Path, value: str) -> None:
    """Of each of both tables; what equals the value that was there is no damage."""
    fill(path, RUNS[1:2])
    before, content = list(StudyFile(path).rows()), path.read_bytes()
    refusals = 0
    columns = [
        (table, column)
        for table in ("runs", "settings")
        for column in columns_of(path, table)
        if not (column == "id" and value in ("'abc'", "x'00'", "NULL", "1.5", "9e999", "''"))
    ]
    assert len(columns) >= len(METRICS) + len(contents(RUNS[0])) + 2
    for table, column in columns:
        path.write_bytes(content)
        with suppress(sqlite3.IntegrityError):
            change(path, f'UPDATE {table} SET "{column}" = {value}')
        try:
            assert list(StudyFile(path).rows()) == before
        except InvalidStudyFile:
            refusals += 1
    assert refusals > len(columns) // 2


def columns_of(path: Path, table: str) -> list[str]:
    connection = sqlite3.connect(path)
    names = [row[1] for row in connection.execute(f"PRAGMA table_info({table})")]
    connection.close()
    return names


@pytest.mark.parametrize("value", ["[1", "", "null", "1.5", '"\\ud800', "[" * 5000])
@pytest.mark.parametrize("note", ["package_version", "fields", "metrics", "shared", "runs"])
def test_note_that_is_not_what_was_written_is_named(path: Path, note: str, value: str) -> None:
    file = fill(path)
    change(path, f"UPDATE meta SET value = '{value}' WHERE name = '{note}'")
    message = f"its note of {note} differs from what was written"
    for read in (file.rows, lambda: StudyFile(path), file.adding().__enter__):
        with pytest.raises(InvalidStudyFile, match=message):
            read()
    change(path, f"DELETE FROM meta WHERE name = '{note}'")
    with pytest.raises(InvalidStudyFile, match=message):
        file.rows()


def test_rows_that_are_lost_are_noticed_and_done_anew(path: Path) -> None:
    """As when a page of the disk is one of before: the table is whole, and shorter."""
    fill(path)
    change(path, "DROP TRIGGER removed", "DELETE FROM runs WHERE seed = 1")
    count = len(RUNS) - len([run for run in RUNS if run.seed == 1])
    message = f"holds {count} rows, but {len(RUNS)} were written"
    with pytest.raises(InvalidStudyFile, match=message) as refusal:
        StudyFile(path).rows()
    with pytest.raises(InvalidStudyFile, match=message):
        fill(path)
    change(path, str(refusal.value).split("(")[-1].rstrip(")"))
    assert len(StudyFile(path).rows()) == count
    assert len(fill(path).rows()) == len(RUNS)


def test_rows_deleted_with_other_tools_are_not_missed(path: Path) -> None:
    fill(path)
    change(path, "DELETE FROM runs WHERE seed = 1")
    assert {row["seed"] for row in StudyFile(path).rows()} == {0, 2}
    assert len(fill(path).rows()) == len(RUNS)


@pytest.mark.parametrize("lost", ["{name}", "{name}.lock"])
@pytest.mark.parametrize("how", ["deleted", "replaced"])
def test_file_that_goes_away_while_results_are_added_is_noticed(
    path: Path, lost: str, how: str
) -> None:
    place = path.with_name(lost.format(name=path.name))

    def add() -> None:
        with StudyFile(path, SHARED).adding() as additions:
            additions.add([(RUNS[0], invented(RUNS[0]))])
            additions.commit()
            content = place.read_bytes()
            place.rename(path.with_name("elsewhere"))
            if how == "replaced":
                place.write_bytes(content)
            additions.add([])

    with pytest.raises(StudyFileNotWritable, match=r"deleted or replaced .* run the study again"):
        add()
    assert place.exists() == (how == "replaced"), "what is there now is somebody else's"


def test_file_that_goes_away_within_the_last_commit_is_noticed(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    numbered = Additions._numbered

    def gone(*arguments: Any) -> Any:
        path.rename(path.with_name("elsewhere"))
        return numbered(*arguments)

    monkeypatch.setattr(Additions, "_numbered", gone)
    with pytest.raises(StudyFileNotWritable, match="deleted or replaced"):
        fill(path)


# What does not belong is refused


def test_no_file_and_no_results_yet(path: Path) -> None:
    with pytest.raises(InvalidStudyFile, match="no such file"):
        StudyFile(path).rows()
    path.touch()
    with pytest.raises(InvalidStudyFile, match="no results yet"):
        StudyFile(path).rows()
    assert len(fill(path).rows()) == len(RUNS), (
        "an empty file is what a study leaves that was killed at once"
    )


@pytest.mark.parametrize(
    "content",
    [
        b"controller,reading\n",
        b"SQLite format 3\x00" + bytes(200),
        np.random.default_rng(0).bytes(5000),
    ],
)
def test_what_is_no_database_is_refused_and_left_alone(path: Path, content: bytes) -> None:
    path.write_bytes(content)
    with pytest.raises(InvalidStudyFile, match="not the file of a study") as refusal:
        StudyFile(path)
    assert refusal.value.path == path.resolve()
    assert path.read_bytes() == content


def test_database_of_another_program_is_refused_and_left_alone(path: Path) -> None:
    change(path, "CREATE TABLE runs (key TEXT)")
    before = path.read_bytes()
    with pytest.raises(InvalidStudyFile, match="marks its files 0"):
        StudyFile(path)
    change(path, "PRAGMA application_id = 252006673")
    with pytest.raises(InvalidStudyFile, match="252006673"):
        StudyFile(path)
    change(path, "PRAGMA application_id = 0")
    assert len(path.read_bytes()) == len(before)


def test_other_format_is_refused(path: Path) -> None:
    fill(path)
    change(path, f"PRAGMA user_version = {FORMAT + 1}")
    with pytest.raises(StudyMismatch, match="format version") as refusal:
        StudyFile(path)
    assert (refusal.value.found, refusal.value.expected) == (FORMAT + 1, FORMAT)


@pytest.mark.parametrize(("note", "text"), [("fields", "friction: float"), ("metrics", "jerk")])
def test_other_fields_and_metrics_are_refused(path: Path, note: str, text: str) -> None:
    """As a file of a version would have whose runs have one thing more."""
    fill(path)
    layout = [*StudyFile._layout()[note], text]
    change(path, f"UPDATE meta SET value = '{json.dumps(layout)}' WHERE name = '{note}'")
    with pytest.raises(StudyMismatch, match=f"list of {note}") as refusal:
        StudyFile(path)
    assert refusal.value.found == [text]


def test_file_of_the_first_format_is_refused_with_what_to_do(path: Path) -> None:
    """As it was written before checksums: a table with a key of text, and nothing of settings."""
    change(
        path,
        "CREATE TABLE runs (key TEXT PRIMARY KEY, controller TEXT) WITHOUT ROWID",
        "CREATE TABLE meta (name TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID",
        "INSERT INTO runs VALUES ('[]', 't1')",
        f"PRAGMA application_id = {APPLICATION}",
        "PRAGMA user_version = 1",
    )
    before = path.read_bytes()
    with pytest.raises(StudyMismatch, match=r"psp3 that wrote it.*another file.*done again"):
        StudyFile(path, SHARED)
    assert path.read_bytes() == before


def test_study_of_other_duration_is_refused(path: Path) -> None:
    fill(path)
    with pytest.raises(StudyMismatch, match=r"duration \[s\] is 10.4, not 5.0") as refusal:
        StudyFile(path, {"duration": 5.0})
    assert (refusal.value.found, refusal.value.expected) == (10.4, 5.0)


def test_file_without_results_binds_nobody(path: Path) -> None:
    """A study that found no scheduler leaves one.

    The next study, of another duration, makes it its own.
    """
    with StudyFile(path, {"duration": 5.0}).adding():
        pass
    fill(path)
    assert len(StudyFile(path, SHARED).rows()) == len(RUNS)
    with pytest.raises(StudyMismatch):
        StudyFile(path, {"duration": 5.0})


def test_results_of_another_version_can_be_read_but_not_extended(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = fill(path)
    made_by = psp3.__version__
    monkeypatch.setattr("psp3.version.__version__", "99.0")
    assert len(StudyFile(path).rows()) == len(RUNS)
    with pytest.raises(StudyMismatch, match="version of psp3") as refusal, file.adding():
        pass
    assert (refusal.value.found, refusal.value.expected) == (made_by, "99.0")


def test_damaged_file_is_refused(path: Path) -> None:
    fill(path)
    with path.open("r+b") as database:
        database.seek(4096)
        database.write(np.random.default_rng(0).bytes(path.stat().st_size - 4096))
    with pytest.raises(InvalidStudyFile, match="cannot be read"):
        StudyFile(path).rows()
    with pytest.raises(InvalidStudyFile, match="cannot be read"):
        StudyFile(path, SHARED)


# Where nothing can be written


def refused(path: Path) -> StudyFileNotWritable:
    with pytest.raises(StudyFileNotWritable) as refusal, StudyFile(path, SHARED).adding():
        pass
    assert refusal.value.path == path.resolve()
    return refusal.value


def test_missing_directory(tmp_path: Path) -> None:
    assert "there is no directory" in str(refused(tmp_path / "nowhere" / "study.sqlite"))


def test_directory_in_place_of_the_file(tmp_path: Path) -> None:
    with pytest.raises(InvalidStudyFile, match="is a directory"):
        StudyFile(tmp_path)


def test_file_marked_read_only_stays_as_it_is_even_for_root(path: Path) -> None:
    fill(path)
    path.chmod(0o444)
    before = path.read_bytes()
    assert refused(path).reason == "it is read-only"
    assert path.read_bytes() == before
    assert len(StudyFile(path).rows()) == len(RUNS)


def test_directory_marked_read_only(path: Path) -> None:
    """SQLite keeps its journal beside the file, so the directory must take files too."""
    fill(path)
    path.parent.chmod(0o555)
    try:
        assert "the directory" in refused(path).reason
        assert len(StudyFile(path).rows()) == len(RUNS)
    finally:
        path.parent.chmod(0o755)


@contextmanager
def full_disk(monkeypatch: pytest.MonkeyPatch, pages: int) -> Iterator[None]:
    """Let databases grow to so many pages and no further.

    SQLite then says what it says when the disk is full.
    """
    connect: Any = sqlite3.connect

    def limited(*arguments: Any, **options: Any) -> Any:
        connection = connect(*arguments, **options)
        connection.execute(f"PRAGMA max_page_count = {pages}")
        return connection

    with monkeypatch.context() as patch:
        patch.setattr(sqlite3, "connect", limited)
        yield


def test_full_disk_keeps_what_was_committed_and_goes_on_when_there_is_room(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    wanted = Runs(Run(snr_db=20.0, seed=seed) for seed in range(200))
    runs = list(wanted)
    with (
        full_disk(monkeypatch, 8),
        pytest.raises(StudyFileNotWritable, match="disk is full") as refusal,
    ):
        fill(path, runs, one_by_one=True)
    kept = refusal.value.kept
    assert 0 < kept < len(runs)
    assert f"{kept} results" in str(refusal.value)
    assert set(keys_of(StudyFile(path).rows())) == {key(run) for run in runs[:kept]}
    with StudyFile(path, SHARED).adding() as additions:
        there = wanted.missing(additions.keys)
        assert there.tolist() == list(range(kept, len(runs)))
        additions.add([(runs[k], invented(runs[k])) for k in there])
    assert len(StudyFile(path).rows()) == len(runs)


def test_disk_that_is_full_from_the_start_is_found_out_before_any_work(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with full_disk(monkeypatch, 2):
        assert refused(path).reason == "the disk is full"
    assert len(fill(path).rows()) == len(RUNS)


def test_file_size_limit_of_the_system_is_as_good_as_a_full_disk(path: Path) -> None:
    """Here the operating system refuses, not SQLite."""
    ours, theirs = PROCESSES.Pipe()
    child = start(run_with_small_files, path, theirs)
    kept = answer_of(child, ours)
    child.join()
    assert len(StudyFile(path).rows()) == kept > 0


# Kill -9


def test_killed_within_a_transaction(path: Path) -> None:
    """What was committed is there, what was not is gone.

    The lock is free and the lock's file is no obstacle.
    """
    child = start(die_within_a_transaction, path)
    child.join()
    assert child.exitcode == -signal.SIGKILL
    assert path.with_name(path.name + "-journal").stat().st_size > 0
    assert keys_of(StudyFile(path).rows()) == [key(Run(seed=1))]
    with StudyFile(path, SHARED).adding() as additions:
        assert additions.keys.tolist() == [key(Run(seed=1))]
    assert [entry.name for entry in path.parent.iterdir()] == [path.name]


def test_killed_while_the_file_is_made(path: Path) -> None:
    child = start(die_while_the_file_is_made, path)
    child.join()
    assert child.exitcode == -signal.SIGKILL
    assert path.stat().st_size > 0
    assert len(fill(path).rows()) == len(RUNS)


# One study at a time


def test_second_study_is_refused_while_the_first_one_writes(path: Path) -> None:
    with StudyFile(path, SHARED).adding() as additions:
        link = path.with_name("link.sqlite")
        link.symlink_to(path)
        for name in (path, link):
            with (
                pytest.raises(StudyInUse, match=f"process {os.getpid()} on ") as refusal,
                StudyFile(name, SHARED).adding(),
            ):
                pass
            assert refusal.value.path == path.resolve()
        additions.add([(RUNS[0], invented(RUNS[0]))])
    assert len(fill(path, RUNS[1:]).rows()) == len(RUNS)
    assert not path.with_name(path.name + ".lock").exists()


def test_lock_is_held_across_processes_and_ends_with_its_holder(path: Path) -> None:
    ours, theirs = PROCESSES.Pipe()
    child = start(hold_the_lock, path, theirs)
    assert answer_of(child, ours)
    with (
        pytest.raises(StudyInUse, match=f"process {child.pid} on "),
        StudyFile(path, SHARED).adding(),
    ):
        pass
    child.kill()
    child.join()
    assert len(fill(path).rows()) == len(RUNS)


def test_lock_is_free_after_an_error(path: Path) -> None:
    with pytest.raises(ZeroDivisionError), StudyFile(path, SHARED).adding():
        _ = 1 / 0
    fill(path)


def test_foreign_writer_is_waited_for_and_then_reported(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Somebody who edits the file by hand, say."""
    file = fill(path)
    monkeypatch.setattr(study_file, "PATIENCE", 0.05)
    other = sqlite3.connect(path)
    other.execute("BEGIN EXCLUSIVE")
    with pytest.raises(PSP3Error, match="locked"), file.adding():
        pass
    other.rollback()
    other.close()
