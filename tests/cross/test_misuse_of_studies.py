"""Misuse of what psp3 offers beside robots: an error on purpose, or the right numbers.

Controllers, what is learned, studies, statistics, the benchmark, exports, scenes and figures. Each
public callable is called with one argument replaced by each of the things that people pass by
mistake, and by the same numbers in other forms; see :mod:`tests.misuse`, and
:mod:`tests.cross.misused_studies` for the good arguments.
"""

from __future__ import annotations

import types
from typing import Any

import pytest

import psp3
from psp3.study import statistics
from tests.cross.misused_studies import rows
from tests.cross.test_misuse_of_robots import HERE
from tests.misuse import (
    Call,
    faults,
    parameters_of,
    public_callables,
    public_packages,
    without_arguments,
)

ASKED_BY_LOOPS = ("table", "take", "torque", "run_table")
"""What a simulation asks of a controller, thousands of times a second: it hands over what it has
checked, and refuses forces that are not finite.
"""

HOLD = {
    "Board": "what a benchmark found",
    "Entry": "a plug-in: what it names is checked by the benchmark that takes it",
    "Grid": "what psp3.grid returns",
    "Table": "what a study holds",
}
"""Their constructors are called by the package itself."""

SAME = {
    "Viewer.animate": "of a scene",
    "Viewer.show": "of a scene",
    "Viewer.write_html": "of a scene",
}

NO_CALLABLES = {
    "psp3": "PARAMETER_SETS grid statistics symbolic trajectories",
    "psp3.benchmark": "BASELINES",
    "psp3.closure": "ASSEMBLED CLOSURE_TOLERANCE NO_MOTORS",
    "psp3.drives": "NO_DRIVE",
    "psp3.identification": "CONFIDENCE",
    "psp3.study": "Progress grid",
    "psp3.trajectories": "SPACES",
}
"""Numbers, modules and types, which take no argument; and ``grid``, which takes fields of runs by
their names, and is tried with some.
"""


@pytest.fixture(scope="module")
def table(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Call]:
    return rows(tmp_path_factory.mktemp("misuse"))


def offered() -> dict[str, Any]:
    """Return what is offered here, without what only loops ask, and what is another's."""
    found = public_callables([*public_packages(psp3), _named(statistics)])
    return {
        name: thing
        for name, thing in found.items()
        if name not in HOLD
        and name not in SAME
        and name.rpartition(".")[2] not in ASKED_BY_LOOPS
        and not thing.__module__.startswith(HERE)
    }


def _named(module: types.ModuleType) -> types.ModuleType:
    """Return the functions of a module that is no package, as one of those that are offered."""
    own = types.ModuleType(module.__name__)
    for name, thing in vars(module).items():
        if isinstance(thing, types.FunctionType) and thing.__module__ == module.__name__:
            setattr(own, name, thing)
    own.__all__ = [name for name in vars(own) if not name.startswith("_")]  # type: ignore[attr-defined]
    return own


def test_every_public_callable_has_good_arguments(table: dict[str, Call]) -> None:
    """All of its parameters have."""
    missing = {
        name: set(parameters_of(thing)) - set(table[name].arguments if name in table else ())
        for name, thing in offered().items()
    }
    assert not {name: names for name, names in missing.items() if names}


def test_every_public_name_is_tried_or_takes_no_argument() -> None:
    """What a facade adds is in a table of good arguments, or in a list with a reason."""
    found = {package.__name__: without_arguments(package) for package in public_packages(psp3)}
    assert {name: " ".join(sorted(names)) for name, names in found.items() if names} == NO_CALLABLES


def test_no_mistake_passes(table: dict[str, Call]) -> None:
    found = [fault for name, call in table.items() for fault in faults(name, call)]
    assert not found, f"{len(found)} faults:\n" + "\n".join(found[:40])
