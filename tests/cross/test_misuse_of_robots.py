"""Misuse of everything that psp3 offers for robots: an error on purpose, or the right numbers.

Each public callable is called with one argument replaced by each of the things that people pass by
mistake, and by the same numbers in other forms; see :mod:`tests.misuse`, and
:mod:`tests.cross.misused_robots` for the good arguments.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import psp3
from tests.cross.misused_robots import rows
from tests.misuse import (
    Call,
    faults,
    parameters_of,
    public_callables,
    public_packages,
    sample,
)

ROOMS = "bounds closure collisions description drives dynamics identification kinematics loading"
ROOMS += " multibody robots simulation symbolic thesis three_psp trajectories"
HERE = tuple(f"psp3.{room}" for room in ROOMS.split())
"""Where what is tried here is defined; the rest of psp3 is tried elsewhere."""

RECORDS = {
    "Contact": "of a collision",
    "Identified": "what identify found",
    "MeasuredMotion": "what a file recorded",
    "Motion": "what a trajectory returns",
    "Pose": "what forward kinematics returns",
    "Report": "of collisions",
    "Result": "of a simulation",
}
"""They hold what the package puts into them; who takes one looks at what is in it."""

SAME = ("PSP3.from_urdf", "PSP3.from_mjcf", "PSP3.from_sdf")
"""Those of ClosedLoopRobot."""

WITHOUT_A_TIP = "ClosedLoopRobot.motion_of_tip"
"""Whatever its arguments are, it refuses."""


@pytest.fixture(scope="module")
def table(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Call]:
    return rows(tmp_path_factory.mktemp("misuse"))


def offered() -> dict[str, Any]:
    """Return what is offered here, without records and what is another's."""
    found = public_callables(public_packages(psp3))
    left_out = {*RECORDS, *SAME, WITHOUT_A_TIP}
    return {
        name: thing
        for name, thing in found.items()
        if name not in left_out and thing.__module__.startswith(HERE)
    }


def test_every_public_callable_has_good_arguments(table: dict[str, Call]) -> None:
    """All of its parameters have."""
    missing = {
        name: set(parameters_of(thing)) - set(table[name].arguments if name in table else ())
        for name, thing in offered().items()
    }
    assert not {name: names for name, names in missing.items() if names}


def test_no_mistake_passes(table: dict[str, Call]) -> None:
    found = [fault for name, call in table.items() for fault in faults(name, call)]
    assert not found, f"{len(found)} faults:\n" + "\n".join(found[:40])


def test_the_harness_sees_what_is_wrong() -> None:
    """Functions that check nothing have faults of every kind; one that checks has none."""
    good = {"row": np.array([0.1, 0.2])}

    def careless(row: Any) -> Any:
        if isinstance(row, list):
            return np.array(row) * np.float64(1.0 + 1e-12)
        return np.asarray(row, dtype=float)

    found = "\n".join(faults("careless", Call(careless, good), 1))
    for what in (
        "foreign ValueError",
        "foreign OverflowError",
        "foreign warning",
        "NaN entry: accepted",
        "as list: [[0.1",
    ):
        assert what in found

    def writing(row: Any) -> Any:
        checked = psp3.checks.one_row("row", row, 2)
        if isinstance(row, np.ndarray) and row.dtype == np.float32:
            row[0] = 0.0
        return checked

    assert faults("writing", Call(writing, good), 1) == ["writing: row as float32: wrote to row"]
    checked = Call(lambda row: psp3.checks.one_row("row", row, 2), good)
    assert not faults("checked", checked, 1)


def test_what_a_mistake_leaves_is_gone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A text that is taken for the name of a file names one in a folder of the call's own."""
    monkeypatch.chdir(tmp_path)
    seen = []

    def careless(path: Any) -> None:
        Path(str(path)).write_text("")
        seen.append(path)

    assert faults("careless", Call(careless, {"path": "good"}), 1)
    assert "no such thing" in seen
    assert list(tmp_path.iterdir()) == []


def test_a_sample_tries_every_argument() -> None:
    """Of few cases one is left at least; all of them where one part is all."""
    cases = [(name,) for name in "abcdefghijklmnopqrstuvwxyz"]
    for argument in "pq":
        chosen = list(sample(argument, cases, 8))
        assert 1 <= len(chosen) < len(cases)
        assert chosen == list(sample(argument, cases, 8))
        assert list(sample(argument, cases, 1)) == cases
    assert list(sample("p", cases[:1], 1000)) == cases[:1]
