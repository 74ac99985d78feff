"""Files of results that were damaged on the disk: what is read is what was written, or is refused.

Bits and bytes fall over, sectors are zero, files end too early, pages are those of others. As a
program::

    python -m tests.hostile.damaged_files 10000

damages each kind of file so often, and prints the counts.
"""

from __future__ import annotations

import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from psp3.benchmark.file import OutcomeFile
from psp3.errors import PSP3Error
from psp3.simulation.result import Result, load_result
from psp3.study import Study
from psp3.study.file import StudyFile
from psp3.study.run import Run
from psp3.trajectories.motion import Motion
from tests.study_helpers import SHARED, invented

SECTOR, PAGE = 512, 4096
"""Bytes that a disk, and SQLite, write at a time."""

PATIENCE = 5.0
"""How long reading may take [s]."""


def damaged(content: bytes, rng: np.random.Generator) -> tuple[str, bytes]:
    """Return a kind of damage, and a file that has suffered it."""
    data, at = bytearray(content), int(rng.integers(len(content)))
    kind = str(rng.choice(["bit", "byte", "sector", "end", "page"], p=[0.5, 0.3, 0.1, 0.05, 0.05]))
    if kind == "bit":
        data[at] ^= 1 << int(rng.integers(8))
    elif kind == "byte":
        data[at] = int(rng.integers(256))
    elif kind == "sector":
        begin = at // SECTOR * SECTOR
        data[begin : begin + SECTOR] = bytes(len(data[begin : begin + SECTOR]))
    elif kind == "end":
        del data[at // PAGE * PAGE if rng.random() < 0.5 else at :]
    else:
        begin, other = at // PAGE * PAGE, int(rng.integers(len(content))) // PAGE * PAGE
        data[begin : begin + PAGE] = content[other : other + PAGE]
    return kind, bytes(data)


def write_study(path: Path) -> None:
    """Write a study of 72 runs and six settings."""
    runs = [
        Run(controller, snr_db=snr, seed=seed)
        for controller in ("t1", "it2", "ctc")
        for snr in (20.0, 10.0)
        for seed in range(12)
    ]
    with StudyFile(path, SHARED).adding() as additions:
        additions.add([(run, invented(run)) for run in runs])


def read_study(path: Path) -> object:
    """Return the rows of a study."""
    return list(Study(path).rows())


def write_outcomes(path: Path) -> None:
    """Write outcomes of a benchmark."""
    file = OutcomeFile(path)
    for number in range(60):
        file.add(f'["stamp", {number}]', {"error": None, "score": 0.1 * number})


def read_outcomes(path: Path) -> object:
    """Return the outcomes of a benchmark by key."""
    return OutcomeFile(path).outcomes()


def write_result(path: Path) -> None:
    """Write samples of a simulation."""
    rng = np.random.default_rng(0)
    t, a, b, c, d, e, tips, f = np.arange(50.0), *rng.normal(size=(7, 50, 3))
    Result(t, a, b, Motion(c, d, e, tips), f, tips).save(path)


def read_result(path: Path) -> object:
    """Return the samples of a simulation, bit for bit."""
    result = load_result(path)
    arrays = (result.t, result.positions, result.speeds, *result.desired, result.torque, result.tip)
    return [array.tobytes() for array in arrays]


KINDS: dict[str, tuple[Callable[[Path], None], Callable[[Path], object]]] = {
    "study": (write_study, read_study),
    "outcomes": (write_outcomes, read_outcomes),
    "result": (write_result, read_result),
}


def verdict(kind: str, read: Any, whole: Any) -> str:
    """Say what was read: what was written, less of it, or something else."""
    if read == whole:
        return "equal"
    # A trial that is lost is one that is not done, which the board says.
    is_part = kind == "outcomes" and all(whole.get(key) == read[key] for key in read)
    return "fewer" if is_part else "wrong"


def campaign(kind: str, count: int, seed: int) -> Counter[tuple[str, str]]:
    """Damage a file so often; return how often which damage led to what."""
    write, reads = KINDS[kind]
    rng, counts = np.random.default_rng(seed), Counter[tuple[str, str]]()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "file")
        write(path)
        content, whole = path.read_bytes(), reads(path)
        for _ in range(count):
            damage, changed = damaged(content, rng)
            path.write_bytes(changed)
            begun = time.monotonic()
            try:
                answer = verdict(kind, reads(path), whole)
            except PSP3Error:
                answer = "refused"
            except Exception as error:
                answer = type(error).__name__
            if time.monotonic() - begun > PATIENCE:
                answer = "slow"
            counts[damage, answer] += 1
    return counts


def main() -> None:
    """Print the counts of a campaign."""
    for kind in KINDS:
        for (damage, answer), number in sorted(campaign(kind, int(sys.argv[1]), 0).items()):
            sys.stdout.write(f"{kind:10} {damage:8} {answer:12} {number}\n")


if __name__ == "__main__":
    main()
