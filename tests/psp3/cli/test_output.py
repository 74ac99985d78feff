"""Tables on a terminal: nothing is cut off, whatever their width."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from psp3.cli.output import (
    _least_width,
    _parts,
    _room_of,
    _widened,
    cell_text,
    error_message,
    show_narrow,
)
from psp3.errors import InvalidRobotFile

WORDS = ["strongest", "sample", "(0.000254", "to", "37260)", "reproduced", "-10.1", "20"]
CELL = st.lists(st.sampled_from(WORDS), min_size=1, max_size=6).map(" ".join)


def test_what_is_not_there_is_a_dash_and_what_is_infinite_a_sign() -> None:
    assert [cell_text(value) for value in (None, float("nan"), float("inf"), 20.0, "t1")] == [
        "–",
        "–",
        "∞",
        "20",
        "t1",
    ]


def test_a_table_that_is_too_wide_is_divided_between_columns(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The first two columns are in each part, the others once."""
    monkeypatch.setenv("COLUMNS", "44")
    headings = ["rules", "level", "difference", "comparison", "verdict"]
    show_narrow("Title", headings, [["one", "20", "0.123", "45.6", "neither is better"]], "Note.")
    out = capsys.readouterr().out
    assert max(map(len, out.splitlines())) <= 44
    words = out.split()
    assert [words.count(word) for word in headings] == [2, 2, 1, 1, 1]
    assert [words.count(word) for word in ("one", "20", "0.123", "45.6")] == [2, 2, 1, 1]
    assert "neither is better" in " ".join(words)
    monkeypatch.setenv("COLUMNS", "100")
    show_narrow("Title", headings, [["one", "20", "0.123", "45.6", "neither is better"]])
    assert capsys.readouterr().out.split().count("rules") == 1


@given(
    table=st.integers(3, 12).flatmap(
        lambda count: st.lists(
            st.lists(CELL, min_size=count, max_size=count), min_size=1, max_size=4
        )
    ),
    room=st.integers(60, 120),
)
def test_every_part_fits_and_no_word_is_broken(table: list[list[str]], room: int) -> None:
    """In room for the first two columns and any other, which is what a part has at least."""
    columns = list(zip(*table, strict=True))
    least = [_least_width("heading", column) for column in columns]
    room = max(room, _room_of([*least[:2], max(least)]))
    parts = _parts(least, room)
    assert sorted({k for part in parts for k in part}) == list(range(len(columns)))
    assert sum(len(part) - 2 for part in parts) == len(columns) - 2
    for part in parts:
        assert part[:2] == [0, 1]
        narrowest = [least[k] for k in part]
        widths = _widened(narrowest, [columns[k] for k in part], room)
        assert _room_of(widths) <= room
        assert all(width >= one for width, one in zip(widths, narrowest, strict=True))


def test_remedies_are_told_in_words_of_the_command_line() -> None:
    told = error_message(InvalidRobotFile("a.xml", 'name motors (actuated=[...], free="keep")'))
    assert told == "psp3: a.xml: name motors (--actuated NAME,NAME, --free keep)"
