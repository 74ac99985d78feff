"""Mutants of many readers, in processes that may hang or die of one."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]


@dataclass
class Tally:
    """What came of the mutants of one reader."""

    results: Counter[str] = field(default_factory=Counter)
    faults: list[dict[str, Any]] = field(default_factory=list)
    slowest: float = 0.0

    @property
    def tried(self) -> int:
        """How many were tried."""
        return self.results.total()


@dataclass
class Report:
    """What came of all mutants; memory in bytes, beyond what the process held before them."""

    tallies: dict[str, Tally]
    grown: int = 0

    @property
    def faults(self) -> list[str]:
        """What went wrong, a line for each."""
        return [
            f"{name} {one['number']} ({one.get('what', '')}): {one['fault']}"
            for name, tally in self.tallies.items()
            for one in tally.faults
        ]


def tried(
    shares: dict[str, range],
    worker: str = "tests.hostile.worker",
    done: Callable[[str, Tally], None] = lambda name, tally: None,
) -> Report:
    """Return what comes of the mutants of some numbers, by reader; one process after another.

    A process that dies of a mutant, or of the time it takes, is followed by another one that goes
    on behind it.

    Parameters
    ----------
    shares : dict
        Numbers of mutants by reader.
    worker : str
        The module of the process.
    done : callable
        Is told the name and the tally of each reader that is through.
    """
    report = Report({name: Tally() for name in shares})
    left = {name: numbers for name, numbers in shares.items() if len(numbers)}
    while left:
        at = _run(left, report, worker, done)
        if at is None:
            break
        names = list(left)
        left = {
            name: range(at[1] + 1, left[name].stop) if name == at[0] else left[name]
            for name in names[names.index(at[0]) :]
        }
        left = {name: numbers for name, numbers in left.items() if len(numbers)}
    return report


def _run(left: dict[str, range], report: Report, worker: str, done: Any) -> tuple[str, int] | None:
    """Run a process to its end, and return the reader and the mutant of which it died, if any."""
    words = [str(word) for name, own in left.items() for word in (name, own.start, own.stop)]
    process = subprocess.Popen(
        [sys.executable, "-m", worker, *words],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
        cwd=ROOT,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
    )
    assert process.stdout is not None
    at: tuple[str, int] | None = None
    for line in process.stdout:
        said = json.loads(line)
        if "number" in said:
            at = said["reader"], said["number"]
        elif "grown" in said:
            report.grown = max(report.grown, said["grown"])
            at = None
        elif at is not None:
            tally = report.tallies[at[0]]
            tally.results[said["result"]] += 1
            tally.slowest = max(tally.slowest, said["seconds"])
            if "fault" in said:
                tally.faults.append(said | {"number": at[1]})
            if at[1] + 1 == left[at[0]].stop:
                done(at[0], tally)
    process.stdout.close()
    code = process.wait()
    if code and at is None:
        raise RuntimeError(f"the worker ended with {code} before its first mutant")
    if at is not None:
        tally = report.tallies[at[0]]
        tally.results["died"] += 1
        reason = "it took too long" if code == -signal.SIGPROF else f"code {code}"
        fault = f"the process died ({reason})"
        tally.faults.append({"number": at[1], "fault": fault})
    return at
