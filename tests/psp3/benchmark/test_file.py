"""The file of outcomes: rows come back, other files are refused."""

from __future__ import annotations

import os
import sqlite3
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import pytest

from psp3.benchmark import file
from psp3.benchmark.file import OutcomeFile, key
from psp3.benchmark.trial import Trial
from psp3.errors import InvalidStudyFile, StudyFileNotWritable
from tests.psp3.benchmark.made import Exact, entry_of, outcome_of

OUTCOME = outcome_of({"trained": 0.1 + 0.2, "untrained": float("inf")})


def test_outcomes_come_back_as_they_were_and_later_ones_replace_them(tmp_path: Path) -> None:
    some = OutcomeFile(tmp_path / "some.sqlite")
    some.add("one", {"error": "ValueError: <no>"})
    some.add("two", OUTCOME)
    some.add("one", OUTCOME)
    assert OutcomeFile(tmp_path / "some.sqlite").outcomes() == {"one": OUTCOME, "two": OUTCOME}


def test_keys_differ_by_entry_text_every_field_of_a_trial_and_the_sources(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    entry, trial = entry_of("one", Exact), Trial("psp3")
    trials = [
        trial,
        replace(trial, robot="delta"),
        replace(trial, reading="inputs", snr_db=20.0),
        replace(trial, reading="inputs", snr_db=10.0),
        replace(trial, seed=1),
        replace(trial, duration=1.0),
        replace(trial, period=0.002),
    ]
    entries = [entry, replace(entry, name="two"), replace(entry, mark="other")]
    keys = {key(one, other) for one in entries for other in trials}
    assert len(keys) == len(entries) * len(trials)
    monkeypatch.setattr(file, "stamp", lambda: "other sources")
    assert key(entry, trial) not in keys


def test_an_entry_is_called_what_a_file_may_be_called(tmp_path: Path) -> None:
    """Names of files hold bytes, some of which are no characters."""
    own = key(entry_of(os.fsdecode(b"not\xffutf8\n"), Exact), Trial("psp3"))
    some = OutcomeFile(tmp_path / "some.sqlite")
    some.add(own, OUTCOME)
    assert some.outcomes() == {own: OUTCOME}


@pytest.mark.parametrize("content", [b"no database", None])
def test_files_of_others_are_refused_and_stay(tmp_path: Path, content: bytes | None) -> None:
    path = tmp_path / "other.sqlite"
    if content is None:
        with closing(sqlite3.connect(path)) as connection, connection:
            connection.execute("CREATE TABLE mine (x)")
        connection.close()
    else:
        path.write_bytes(content)
    before = path.read_bytes()
    with pytest.raises(InvalidStudyFile, match="is not the file of a benchmark"):
        OutcomeFile(path)
    assert path.read_bytes() == before


def test_another_version_is_refused_with_what_it_is_and_what_to_do(tmp_path: Path) -> None:
    path = tmp_path / "some.sqlite"
    OutcomeFile(path)
    with closing(sqlite3.connect(path)) as connection, connection:
        connection.execute("PRAGMA user_version = 99")
    connection.close()
    with pytest.raises(InvalidStudyFile, match=r"version 99, .* another directory"):
        OutcomeFile(path)


def test_where_no_file_can_be_made_the_error_says_so(tmp_path: Path) -> None:
    with pytest.raises(StudyFileNotWritable):
        OutcomeFile(tmp_path / "absent" / "some.sqlite")


VALUES = ("'abc'", "x'00'", "1.5", "-1", "9e999", "''", """'{"error": null}'""")


@pytest.mark.parametrize("value", VALUES)
@pytest.mark.parametrize("column", ["key", "outcome", "checksum"])
def test_outcome_that_is_not_what_was_written_is_named_and_can_be_done_anew(
    tmp_path: Path, column: str, value: str
) -> None:
    path = tmp_path / "some.sqlite"
    some = OutcomeFile(path)
    some.add("one", OUTCOME)
    some.add("two", OUTCOME)
    change(path, f"UPDATE outcomes SET {column} = {value} WHERE key = 'one'")
    with pytest.raises(InvalidStudyFile, match="does not match its checksum") as refusal:
        some.outcomes()
    change(path, str(refusal.value).split("(")[-1].rstrip(")"))
    assert some.outcomes() == {"two": OUTCOME}


def change(path: Path, statement: str) -> None:
    with closing(sqlite3.connect(path)) as connection, connection:
        connection.execute(statement)
    connection.close()


@pytest.mark.parametrize("how", ["deleted", "replaced"])
def test_file_that_goes_away_is_noticed(tmp_path: Path, how: str) -> None:
    path = tmp_path / "some.sqlite"
    some = OutcomeFile(path)
    some.add("one", OUTCOME)
    path.rename(tmp_path / "elsewhere")
    if how == "replaced":
        OutcomeFile(path)
    with pytest.raises(StudyFileNotWritable, match="deleted or replaced"):
        some.add("two", OUTCOME)
    assert OutcomeFile(tmp_path / "elsewhere").outcomes() == {"one": OUTCOME}
