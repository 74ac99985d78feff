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
from tests.misuse import Call, faults, parameters_of, public_callables, public_packages, tries

HERE = tuple(
    f"psp3.{name}"
    for name in [
        "bounds",
        "closure",
        "collisions",
        "description",
        "drives",
        "dynamics",
        "identification",
        "kinematics",
        "loading",
        "multibody",
        "robots",
        "simulation",
        "symbolic",
        "thesis",
        "three_psp",
        "trajectories",
    ]
)
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

INNER = ("ConformalIntervals.", "TrackingTube.")


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


def test_no_mistake_passes(
    table: dict[str, Call], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Some 20 000 calls; what one of them writes goes to an empty folder."""
    monkeypatch.chdir(tmp_path)
    found = [fault for name, call in table.items() for fault in faults(name, call)]
    assert not found, f"{len(found)} of {sum(map(tries, table.values()))}: " + "\n".join(found[:40])


def test_the_harness_sees_what_is_wrong() -> None:
    """A function that checks nothing has faults of every kind; one that checks has none."""

    def careless(row: Any) -> Any:
        array = np.asarray(row, dtype=float)
        if isinstance(row, np.ndarray) and row.flags.writeable and row.dtype.kind == "f":
            row[..., 0] = 0.0
        return array * np.float32(1.0) if isinstance(row, list) else 2.0 * array

    found = "\n".join(faults("careless", Call(careless, {"row": np.array([0.1, 0.2])})))
    for kind in (
        "wrote to row",
        "foreign ValueError",
        "foreign OverflowError",
        "accepted",
        "not [",
    ):
        assert kind in found

    def careful(row: Any) -> Any:
        return 2.0 * psp3.checks.one_row("row", row, 2)

    assert not faults("careful", Call(careful, {"row": np.array([0.1, 0.2])}))
