"""Misuse of everything that fuzzy2 offers: an error on purpose, or the right numbers.

Each public callable is called with one argument replaced by each of the things that people pass by
mistake, and by the same numbers in other forms; see :mod:`tests.misuse`, and
:mod:`tests.cross.misused_fuzzy` for the good arguments.
"""

from __future__ import annotations

import inspect
from typing import Any

import pytest

import fuzzy2
from tests.cross.misused_fuzzy import NOT_FOR_USERS, REFUSE, rows
from tests.misuse import (
    Call,
    faults,
    parameters_of,
    public_callables,
    public_packages,
    without_arguments,
)

RECORDS = {
    "Clusters": "what fuzzy_c_means returns",
    "FineTuning": "what fine_tune returns",
    "Report": "what validate returns",
}
"""They hold what the package puts into them."""


NO_CALLABLES = {
    "fuzzy2.learning": "COMPLETIONS KINDS LEARNERS PARTITIONS",
    "fuzzy2.plots": "ACROSS POINTS REACH VISIBLE",
    "fuzzy2.systems": "AnySet",
}
"""Numbers, names and types, which take no argument."""


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
        if name not in REFUSE
        and name.partition(".")[0] not in {*RECORDS, *bases}
        and name.rpartition(".")[2] not in NOT_FOR_USERS
    }


def test_every_public_callable_has_good_arguments(table: dict[str, Call]) -> None:
    """All of its parameters have."""
    missing = {
        name: set(parameters_of(thing)) - set(table[name].arguments if name in table else ())
        for name, thing in offered().items()
    }
    assert not {name: names for name, names in missing.items() if names}


def test_every_public_name_is_tried_or_takes_no_argument() -> None:
    """What a facade adds is in a table of good arguments, or in a list with a reason."""
    found = {package.__name__: without_arguments(package) for package in public_packages(fuzzy2)}
    assert {name: " ".join(sorted(names)) for name, names in found.items() if names} == NO_CALLABLES


def test_no_mistake_passes(table: dict[str, Call]) -> None:
    found = [fault for name, call in table.items() for fault in faults(name, call)]
    assert not found, f"{len(found)} faults:\n" + "\n".join(found[:40])
