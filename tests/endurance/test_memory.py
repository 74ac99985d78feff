"""Memory does not grow with the number of calls, nor of files that are read.

A small budget of each, ``python -m tests.endurance.memory`` does many more. What is measured is the
memory that the process holds for itself after what can be freed is: a slope of some bytes is one
more page or fewer, and stands for no object.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.endurance.memory import slope
from tests.processes import ENVIRONMENT, ROOT

BUDGET = 400_000
"""Calls in all; loads are a ten-thousandth of that, each."""

MOST_A_CALL = 16.0
"""Bytes: a leaked float takes 24, and an array 112."""

MOST_A_LOAD = 8192.0
"""Bytes. A part of the allocator's, 256 KiB, more or less is that over the half of forty loads; a
small robot is twenty times as large.
"""


def test_a_leak_is_found() -> None:
    kept: list[bytes] = []
    assert slope(lambda: kept.append(bytes(100)), 20_000) > 100.0
    kept.clear()
    assert slope(lambda: kept.append(bytes(20_000)), 600) > 19_000.0


@pytest.mark.slow
def test_memory_is_flat(tmp_path: Path) -> None:
    """In a process of its own, which holds nothing else."""
    command = [sys.executable, "-m", "tests.endurance.memory", str(BUDGET)]
    environment = {**os.environ, **ENVIRONMENT}
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    rows = [line.split("\t") for line in done.stdout.splitlines()]
    grown = {name: (int(number), float(size.split()[0])) for name, number, size, _ in rows}
    assert len(grown) > 30
    assert not {
        name: found
        for name, found in grown.items()
        if found[1] > (MOST_A_CALL if found[0] > 1000 else MOST_A_LOAD)
    }
