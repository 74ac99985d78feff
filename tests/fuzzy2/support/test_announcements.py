"""Who compiles says so."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, NamedTuple

import numpy as np
import pytest

from fuzzy2.support import announcements
from fuzzy2.support.announcements import Compilation, announced_by, size_of_code
from fuzzy2.support.compiled import chosen_by_table, compiled


def some_code(x):
    return x + 1.0


part = compiled(some_code)


def twice(x):
    return part(part(x))


class Table(NamedTuple):
    """What a body is chosen by."""

    values: Any


@chosen_by_table
def chosen(table: Table) -> float:
    """Return something of a table."""
    raise NotImplementedError


@chosen.register(Table)
def _of_table(table):
    return part(table.values[0])


def calling(table):
    return chosen(table)


def bytes_of(function: Any) -> int:
    return len(function.__code__.co_code)


def test_all_that_a_function_calls_counts_once() -> None:
    assert size_of_code(twice) == bytes_of(twice) + bytes_of(some_code)


def test_of_what_a_table_chooses_the_body_for_it_counts() -> None:
    assert size_of_code(calling) == bytes_of(calling)
    with_body = sum(map(bytes_of, (calling, _of_table, some_code)))
    assert size_of_code(calling, frozenset({Table})) == with_body


def test_what_takes_long_is_logged_or_shown(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    """And what does not is not."""
    shown: list[Compilation] = []

    @contextmanager
    def show(coming: Compilation) -> Iterator[None]:
        shown.append(coming)
        yield

    def logged() -> list[str]:
        # Threads that other tests have left may log, too.
        return [one.getMessage() for one in caplog.records if one.name == announcements.__name__]

    # Of the suite nothing is told, see tests/conftest.py.
    monkeypatch.setattr(announcements, "TOLD", 2.0)
    with caplog.at_level(logging.WARNING):
        compiled(lambda x: x + 2.0)(1.0)
        assert not logged()
        monkeypatch.setattr(announcements, "RATE", 1.0)
        compiled(lambda table: chosen(table))(Table(np.ones(1)))
        (message,) = logged()
        with announced_by(show):
            compiled(lambda x: part(x) + 3.0)(1.0)
    assert message.startswith("compiling once, about ")
    (one,) = shown
    assert one.name == f"{__name__}.<lambda>"
    assert one.seconds > bytes_of(some_code)
    assert len(logged()) == 1
