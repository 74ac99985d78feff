"""Misuse of everything that fuzzy2 offers: an error on purpose, or the right numbers.

Each public callable is called with one argument replaced by each of the things that people pass by
mistake, and by the same numbers in other forms; see :mod:`tests.misuse`, and
:mod:`tests.cross.misused_fuzzy` for the good arguments.
"""

from __future__ import annotations

import inspect
from pathlib import Path
from typing import Any

import pytest

import fuzzy2
from tests.cross.misused_fuzzy import NOT_FOR_USERS, rows
from tests.misuse import Call, faults, public_callables, public_packages, tries

RECORDS = {"FineTuning": "what fine_tune returns", "Report": "what validate returns"}
"""They hold what the package puts into them."""


@pytest.fixture(scope="module")
def table(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Call]:
    return rows(tmp_path_factory.mktemp("misuse"))


def offered() -> dict[str, Any]:
    """Return what is offered, without records, and without what only subclasses are asked for."""
    found = public_callables(public_packages(fuzzy2))
    bases = {name for name in fuzzy2.__all__ if inspect.isabstract(getattr(fuzzy2, name))}
    bases |= {"FuzzySystem"}
    return {
        name: thing
        for name, thing in found.items()
        if name.split(".")[0] not in {*RECORDS, *bases} and name.split(".")[-1] not in NOT_FOR_USERS
    }


def test_every_public_callable_has_good_arguments(table: dict[str, Call]) -> None:
    assert sorted(set(offered()) - set(table)) == []


def test_no_mistake_passes(
    table: dict[str, Call], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What one of the calls writes goes to an empty folder."""
    monkeypatch.chdir(tmp_path)
    found = [fault for name, call in table.items() for fault in faults(name, call)]
    assert not found, f"{len(found)} of {sum(map(tries, table.values()))}: " + "\n".join(found[:40])
