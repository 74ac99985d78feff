"""The file of a study.

What goes in comes out, what is committed stays, and what does not belong is refused.
"""

from __future__ import annotations

import json
import math
import os
import signal
import sqlite3
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import psp3
from psp3.errors import InvalidStudyFile, PSP3Error, StudyFileNotWritable, StudyInUse, StudyMismatch
from psp3.study import file as study_file
from psp3.study.file import FORMAT, StudyFile, contents, key
from psp3.study.run import METRICS, Run
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
    return file


def change(path: Path, *statements: str) -> None:
    connection = sqlite3.connect(path)
    with connection:
        for statement in statements:
            connection.execute(statement)
    connection.close()


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
    (row,) = StudyFile(path).rows().values()
    assert [row[name].hex() for name in METRICS] == [(value + 0.0).hex() for value in values]
    assert row["snr_db"].hex() == (snr + 0.0).hex()
    assert {name: row[name] for name in contents(run)} == contents(run)


def test_fields_come_back_in_their_types_and_none_as_none(path: Path) -> None:
    run = Run(controller="pd", snr_db=20, seed=7)
    (row,) = fill(path, [run]).rows().values()
    assert {name: (type(row[name]), row[name]) for name in contents(run)} == {
        n: (type(v), v) for n, v in contents(run).items()
    }
    assert row["mean_variation"] is None
    assert type(row["snr_db"]) is float
    assert type(row["seed"]) is int


def test_key_is_the_content_of_a_run() -> None:
    assert key(Run(snr_db=20)) == key(Run(snr_db=20.0))
    assert key(Run(payload=-0.0)) == key(Run(payload=0.0))
    runs = [
        Run(),
        Run("t1"),
        Run(seed=1),
        Run(mean_variation=0.0),
        Run(snr_reference="unit"),
        Run(noisy_entries="gravity"),
        Run(snr_reference="unit", noisy_entries="gravity"),
        Run(defuzzify="last"),
        Run(snr_reference="unit", defuzzify="last"),
        Run(snr_db=20.0),
        Run(snr_db=math.nextafter(20.0, 21.0)),
    ]
    assert len({key(run) for run in runs}) == len(runs)


def test_table_does_not_depend_on_the_order_in_which_runs_end(path: Path, tmp_path: Path) -> None:
    other = tmp_path / "other.sqlite"
    one = fill(path)
    fill(other, RUNS[::-1], one_by_one=True)
    assert list(one.rows().items()) == list(StudyFile(other).rows().items())

    def raw(file: Path) -> list[Any]:
        connection = sqlite3.connect(file)
        rows = connection.execute("SELECT * FROM runs").fetchall()
        connection.close()
        return rows

    assert raw(path) == raw(other)
    assert len(raw(path)) == len(RUNS)


def test_rows_come_in_the_order_of_their_fields_as_numbers(path: Path) -> None:
    """Not in that of their texts, in which 10 comes before 9."""
    runs = [
        Run(controller, snr_db=snr, seed=seed)
        for controller in ("ctc", "it2")
        for snr in (9.0, 10.0, 100.0)
        for seed in (2, 10)
    ]
    rows = fill(path, runs[::-1]).rows()
    assert list(rows) == [key(run) for run in runs]


def test_results_that_come_together_are_committed_together(path: Path) -> None:
    """The second result of the batch lacks a metric.

    So the first one must not be in the file either.
    """
    with StudyFile(path, SHARED).adding() as additions:
        additions.add([(RUNS[0], invented(RUNS[0]))])
        with pytest.raises(KeyError):
            additions.add([(RUNS[1], invented(RUNS[1])), (RUNS[2], {})])
        assert additions.keys == {key(RUNS[0])}
        assert list(StudyFile(path).rows()) == [key(RUNS[0])]


def test_interrupts_around_a_transaction_do_no_harm(path: Path) -> None:
    """Ctrl-C can come between any two lines.

    After a transaction has begun, and after it was committed but not yet noted.
    """
    batch = [(run, invented(run)) for run in RUNS]
    with StudyFile(path, SHARED).adding() as additions:
        additions._connection.execute("BEGIN IMMEDIATE")
        additions._connection.execute("DELETE FROM meta")
        additions.add(batch)
        additions.keys.clear()
        additions.add(batch)
        assert len(additions.keys) == len(RUNS)
    assert len(StudyFile(path, SHARED).rows()) == len(RUNS)


def test_file_can_be_read_while_results_are_added(path: Path) -> None:
    with StudyFile(path, SHARED).adding() as additions:
        for number, run in enumerate(RUNS, start=1):
            additions.add([(run, invented(run))])
            assert len(StudyFile(path).rows()) == number


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


def without_later_fields(path: Path, later: tuple[str, ...]) -> None:
    """Make of a file what was written before runs had some fields."""
    layout = [text for text in StudyFile._layout()["fields"] if text.split(":")[0] not in later]
    change(
        path,
        *(f"ALTER TABLE runs DROP COLUMN {name}" for name in later),
        f"UPDATE meta SET value = '{json.dumps(layout)}' WHERE name = 'fields'",
    )


ORDER = ("defuzzify",)
REFERENCE = ("snr_reference", "noisy_entries")


@pytest.mark.parametrize("later", [ORDER, (*REFERENCE, *ORDER)])
def test_file_from_before_some_fields_is_read_and_extended(
    path: Path, later: tuple[str, ...]
) -> None:
    """Its runs are those of the defaults: they are not done again, others are added."""
    before = fill(path).rows()
    without_later_fields(path, later)
    untouched = path.read_bytes()
    assert StudyFile(path, SHARED).rows() == before
    assert path.read_bytes() == untouched
    others = [
        Run(seed=5, snr_reference="unit"),
        Run(seed=5, noisy_entries="gravity"),
        Run("gt2", seed=5, defuzzify="last"),
    ]
    with StudyFile(path, SHARED).adding() as additions:
        assert additions.keys == set(before)
        assert {key(run) for run in RUNS} == additions.keys
        additions.add([(run, invented(run)) for run in [*others, RUNS[0]]])
    after = StudyFile(path, SHARED).rows()
    assert {name: after[name] for name in before} == before
    assert [tuple(after[key(run)][name] for name in (*REFERENCE, *ORDER)) for run in others] == [
        ("unit", "all", "first"),
        ("mean-square", "gravity", "first"),
        ("mean-square", "all", "last"),
    ]
    assert {name: after[key(others[0])][name] for name in METRICS} == invented(others[0])
    # What has the new columns, is a file like any other.
    fill(path, [Run(seed=6)])
    assert len(StudyFile(path, SHARED).rows()) == len(RUNS) + 4


def test_key_of_a_run_that_files_of_before_can_hold_is_the_one_they_have() -> None:
    """As an earlier version wrote it."""
    assert key(Run(snr_db=20.0, mean_variation=0.25)) == (
        '["it2", "parameters", 20.0, 0, "helix", "strongest", 2, 0.25, 5, "alpha_planes", '
        '"clamp", 1.0, 209, 0.0, 0.0, 0.0, 0.0, null, 0.0, 0, "default", 10.4, 0.002]'
    )
    assert key(Run(snr_db=20.0, mean_variation=0.25, noisy_entries="gravity")) == (
        '["it2", "parameters", 20.0, 0, "helix", "strongest", 2, 0.25, 5, "alpha_planes", '
        '"clamp", 1.0, 209, 0.0, 0.0, 0.0, 0.0, null, 0.0, 0, "default", 10.4, 0.002, '
        '"mean-square", "gravity"]'
    )


def test_file_that_lacks_a_field_between_others_is_refused(path: Path) -> None:
    """No version wrote one with the order of defuzzification, but without what came before."""
    fill(path)
    without_later_fields(path, REFERENCE)
    with pytest.raises(StudyMismatch, match="list of fields"):
        StudyFile(path)


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
    runs = [Run(seed=seed) for seed in range(200)]
    with (
        full_disk(monkeypatch, 8),
        pytest.raises(StudyFileNotWritable, match="disk is full") as refusal,
    ):
        fill(path, runs, one_by_one=True)
    kept = refusal.value.kept
    assert 0 < kept < len(runs)
    assert f"{kept} results" in str(refusal.value)
    assert set(StudyFile(path).rows()) == {key(run) for run in runs[:kept]}
    with StudyFile(path, SHARED).adding() as additions:
        additions.add([(run, invented(run)) for run in runs if key(run) not in additions.keys])
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
    assert list(StudyFile(path).rows()) == [key(Run(seed=1))]
    with StudyFile(path, SHARED).adding() as additions:
        assert additions.keys == {key(Run(seed=1))}
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
