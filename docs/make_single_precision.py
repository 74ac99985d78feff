"""Measure what single precision costs: every exported function against Python's double precision.

Each robot, controller and fuzzy system is exported in single precision with its test of 200 cases;
the functions are called in these, and their answers compared with those that came with the test.
What was measured is kept in ``docs/single_precision.json``, of which the page
``docs/single_precision.md`` is made; all or some are measured anew by::

    python docs/make_single_precision.py
    python docs/make_single_precision.py delta "CTC of delta"

A C compiler is needed, and a quarter of an hour of one core. Everything random has a seed.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
import warnings
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import psp3
from fuzzy2.errors import ApproximationWarning
from fuzzy2.export.project import export_project as export_system
from fuzzy2.export.project_calls import Call, calls_of, short_name, size_of
from psp3.checks import Array
from psp3.description.parts import ROBOTS
from psp3.export.project import export_project
from tests.fuzzy2.export.kinds import KINDS as SYSTEMS
from tests.fuzzy2.export.kinds import SLOW as SLOW_SYSTEMS
from tests.psp3.export import controllers_of_all_kinds as controllers

KEPT = Path(__file__).with_name("single_precision.json")
PAGE = KEPT.with_suffix(".md")

ROBOT, CONTROLLER, SYSTEM = "Robots", "Controllers", "Fuzzy systems"

ANSWERS = """
#include "calls.h"
#include "cases.h"

#include <stdio.h>
#include <string.h>

int main(void)
{
    static calls_number reads[CALLS_MOST_READ + 1], writes[CALLS_MOST_WRITTEN + 1];
    const double *number = cases_numbers;
    for (int call = 0; call < CASES_CALLS; call++) {
        const int k = cases_functions[call];
        for (int i = 0; i < calls_functions[k].reads; i++) {
            reads[i] = (calls_number)*number++;
        }
        memset(writes, 0, sizeof writes);
        calls_call(k, reads, writes);
        for (int i = 0; i < calls_functions[k].writes; i++) {
            printf("%d %d %.17g %.17g\\n", call, k, (double)writes[i], *number++);
        }
    }
    return 0;
}
"""
"""A program that writes for each number of each answer its call, its function, it, and Python's."""


class Thing(NamedTuple):
    """What is exported: under which heading it stands, how it is made, options of its export."""

    heading: str
    make: Callable[[], Any]
    robot: str | None = None


OF_ANY_ROBOT = (
    *("PD", "PD of matrices", "PID", "PD with gravity", "feed-forward", "CTC", "LQR"),
    "LQR along a path",
)
"""Controllers that are shown of a robot in closed form and of one whose loops are closed."""

NOT_SHOWN = ("gt2 last, crisp outside", "C of M, it2", "C of M, corollary")
"""What others that are shown are made of."""


def things() -> dict[str, Thing]:
    """Return everything that can be exported, by name."""
    found = {name: Thing(ROBOT, partial(psp3.load, name)) for name in ROBOTS}
    for name in ("psp3", "delta"):
        for kind in OF_ANY_ROBOT:
            found[f"{kind} of {name}"] = Thing(CONTROLLER, partial(_made, kind, name), name)
    for name in ("psp3", "five_bar"):
        for kind, one in controllers.FUZZY.items():
            if name in one.robots and kind not in NOT_SHOWN:
                make = partial(_made, kind, name)
                found[f"learned, {kind}, of {name}"] = Thing(CONTROLLER, make)
        found[f"adaptive of {name}"] = Thing(CONTROLLER, partial(_made, "adaptive, it2", name))
    for kind, make in (SYSTEMS | SLOW_SYSTEMS).items():
        found[kind] = Thing(SYSTEM, make)
    return found


def _made(kind: str, name: str) -> Any:
    """Return a controller of a kind, of a robot."""
    return controllers.KINDS[kind].make(controllers.robot_of(name))


def measured(thing: Thing, made: Any) -> list[dict[str, Any]]:
    """Return for each function how far its answers in single precision are from Python's."""
    export: Any = export_system if thing.heading == SYSTEM else export_project
    options = {} if thing.robot is None else {"robot": controllers.robot_of(thing.robot)}
    with tempfile.TemporaryDirectory() as name:
        code = export(made, name, precision="single", name="tried", **options)
        said = _answers(Path(name))
    rows = []
    for number, call in enumerate(calls_of(code)):
        if call.writes:
            function = {"function": short_name(code, call.function)}
            rows.append(function | _of_function(call, said[said[:, 1] == number]))
    return rows


def _answers(folder: Path) -> Array:
    """Return a row for each number of each answer: call, function, single, double."""
    (folder / "answers.c").write_text(ANSWERS, encoding="utf-8")
    command = ["gcc", "-std=c99", "-O2", "-ffp-contract=off", "-o", "answers"]
    sources = ["answers.c", "tried.c", "calls.c", "cases.c"]
    subprocess.run([*command, *sources, "-lm"], cwd=folder, check=True)
    done = subprocess.run(["./answers"], cwd=folder, check=True, capture_output=True)
    rows: Array = np.array(done.stdout.split(), dtype=float).reshape(-1, 4)
    return rows


def _of_function(call: Call, said: Array) -> dict[str, Any]:
    """Return cases, median and largest error, and in how many only one precision answers."""
    found, right = (said[:, column].reshape(-1, call.writes) for column in (2, 3))
    errors, lost, more = [], 0, 0
    scales = [_usual_size(right[:, part]) for part in _parts(call)]
    for one, other in zip(found, right, strict=True):
        numbers = np.concatenate([np.arange(call.writes)[part] for part in _parts(call)])
        a, b = np.isfinite(one[numbers]), np.isfinite(other[numbers])
        lost, more = lost + bool((b & ~a).any()), more + bool((a & ~b).any())
        if b.any() and np.array_equal(a, b):
            errors.append(max(_errors(call, one, other, scales)))
    return {
        "cases": len(found),
        "median": float(f"{np.median(errors) if errors else np.nan:.2e}"),
        "largest": float(f"{max(errors, default=np.nan):.2e}"),
        "lost": lost,
        "more": more,
    }


def _errors(call: Call, found: Array, right: Array, scales: list[float]) -> Iterator[float]:
    """Yield the error of each array of an answer: of the largest number in it, or usually in it."""
    for part, scale in zip(_parts(call), scales, strict=True):
        known = np.isfinite(right[part])
        if known.any():
            one, other = found[part][known], right[part][known]
            yield float(np.abs(one - other).max() / max(scale, np.abs(other).max()))


def _usual_size(rows: Array) -> float:
    """Return the median of the largest numbers of answers."""
    largest = np.abs(rows).max(axis=1)
    largest = largest[np.isfinite(largest) & (largest > 0.0)]
    return float(np.median(largest)) if largest.size else 1.0


def _parts(call: Call) -> list[slice]:
    """Return where the arrays of an answer are; codes and flags are no numbers."""
    function = call.function
    parts = [slice(0, 1)] if function.returns == "real" else []
    start = int(bool(function.result))
    for argument in call.written:
        if argument.name != "flags":
            parts.append(slice(start, start + size_of(argument)))
        start += size_of(argument)
    return parts


COLUMNS = "| {} | function | median | largest | cases with an answer in both, or in none |"


def page(kept: dict[str, Any]) -> str:
    """Return the page with the tables of what was measured."""
    text = [PAGE.read_text(encoding="utf-8").split("\n## ")[0]]
    for heading in dict.fromkeys(rows["heading"] for rows in kept.values()):
        title = COLUMNS.format(heading.lower())
        text += [f"## {heading}\n", title, "|" + "---|" * (title.count("|") - 1)]
        for name, thing in kept.items():
            if thing["heading"] == heading:
                text += [_row(name, row) for row in thing["functions"]]
        text.append("")
    return "\n".join(text)


def _row(name: str, row: dict[str, Any]) -> str:
    alike = f"{row['cases'] - row['lost'] - row['more']} of {row['cases']}"
    if row["lost"]:
        alike += f"; no answer in single in {row['lost']}"
    if row["more"]:
        alike += f"; only in single in {row['more']}"
    median, largest = (f"{row[of]:.0e}" for of in ("median", "largest"))
    return f"| {name} | `{row['function']}` | {median} | {largest} | {alike} |"


def main() -> None:
    """Measure what is named, or all, and write file and page."""
    warnings.simplefilter("ignore", ApproximationWarning)
    every = things()
    kept = json.loads(KEPT.read_text(encoding="utf-8")) if KEPT.is_file() else {}
    for name in sys.argv[1:] or every:
        thing = every[name]
        made = thing.make()
        kept[name] = {"heading": thing.heading, "functions": measured(thing, made)}
        # What is no longer exported is forgotten; the order is that of all things.
        kept = {known: kept[known] for known in every if known in kept}
        KEPT.write_text(json.dumps(kept, indent=1) + "\n", encoding="utf-8")
        PAGE.write_text(page(kept), encoding="utf-8")


if __name__ == "__main__":
    main()
