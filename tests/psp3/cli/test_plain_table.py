"""Tables and lines of the command line: names in them are neither markup nor obeyed."""

from __future__ import annotations

import contextlib
import io
import json
import logging
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from fuzzy2.errors import printable
from psp3.cli.output import (
    new_table,
    print_json,
    say,
    show,
    show_narrow,
    show_text,
    write_csv,
)
from psp3.description.urdf import logger
from psp3.errors import UnknownName
from tests.hostile.names import HOSTILE


class Terminal(io.StringIO):
    """Standard output that says it is a terminal."""

    def isatty(self) -> bool:
        """Say so."""
        return True


@pytest.fixture(autouse=True)
def wide(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "400")


def printed(action: Callable[[], object], to: io.StringIO | None = None) -> str:
    """Return what an action prints, without colors unless it is to a terminal."""
    shown = to or io.StringIO()
    with contextlib.redirect_stdout(shown), contextlib.redirect_stderr(shown):
        action()
    return shown.getvalue()


def check(text: str, *names: str) -> None:
    """Check that names are there letter by letter, and nothing that a terminal would obey."""
    assert printable(text) == text
    for name in names:
        assert printable(name) in text


@pytest.mark.parametrize("name", HOSTILE)
def test_names_in_tables(name: str) -> None:
    table = new_table(f"1{name}", f"2{name}", "value", note=f"3{name}")
    table.add_row(f"4{name}", f"5{name}")
    check(printed(lambda: show(table)), *(place + name for place in "12345"))


@pytest.mark.parametrize("name", HOSTILE)
def test_names_in_narrow_tables_and_sentences(name: str) -> None:
    rows = [["x", f"4{name}"]]
    check(printed(lambda: show_narrow(f"1{name}", ["x", "3"], rows, f"5{name}")), "1" + name)
    check(printed(lambda: show_narrow("", [f"2{name}", "3"], rows)))
    check(printed(lambda: show_text(f"6{name}")), f"6{name}")
    assert printed(lambda: say(f"7{name}")) == f"7{printable(name)}\n"


@pytest.mark.parametrize("name", HOSTILE)
def test_json_is_printable_and_holds_the_name_itself(name: str) -> None:
    content = {name: [name, "\U000e0041"]}
    text = printed(lambda: print_json(content))
    check(text)
    assert json.loads(text) == content


def test_csv_is_the_name_to_a_program_and_printable_to_a_person() -> None:
    columns = {"a\x1b[2J": np.zeros(1)}
    assert printed(lambda: write_csv(Path("-"), columns), Terminal()) == "a\\x1b[2J\n0.0\n"
    assert printed(lambda: write_csv(Path("-"), columns)) == "a\x1b[2J\n0.0\n"


@pytest.mark.parametrize("name", HOSTILE)
def test_errors_and_what_is_logged_are_printable(name: str) -> None:
    check(str(UnknownName("joint", name, [name])), name)
    terminal = Terminal()
    handler = logging.StreamHandler(terminal)
    logger.addHandler(handler)
    try:
        logger.warning("%s: mesh %s", "file", name)
    finally:
        logger.removeHandler(handler)
    check(terminal.getvalue(), name)
