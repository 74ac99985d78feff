"""Memory does not grow with the number of calls, nor of files that are read.

What is in use is counted to the byte, after some calls of each; what the system has given is looked
at by ``python -m tests.endurance.memory``, after many more.
"""

from __future__ import annotations

import gc
import subprocess
import sys
from multiprocessing.connection import Connection
from pathlib import Path

import pytest

from tests.endurance.memory import Use, calls, growth, loads
from tests.processes import PROCESSES, ROOT, answer_of, start

CALLS, LOADS = 50, 2
"""Calls and loads in a window, of which there are six."""

MOST_A_CALL = Use(16.0, 0.5)
"""The least that C can leak is 32 bytes, and Python a block: what is once in two calls is found."""

MOST_A_LOAD = Use(4096.0, 0.5)
"""A small robot is twenty times as large. MuJoCo and SQLite use up to 2.5 kB more or less after
each load; a thousand loads leave at most 61 bytes each.
"""


LEAKING = """
from tests.endurance.memory import slope
kept = []
print(slope(lambda: kept.append(bytes(100)), 200_000))
"""


def test_a_leak_is_found() -> None:
    kept: list[object] = []
    assert growth(lambda: kept.append(object()), 50).blocks == 1.0
    assert growth(lambda: kept.append(bytes(600)), 50).bytes > 600.0
    # In a process of its own: in one with much free memory, a leak fills that first.
    done = subprocess.run(
        [sys.executable, "-c", LEAKING], cwd=ROOT, capture_output=True, check=True, text=True
    )
    assert float(done.stdout) > 100.0


def measured(folder: Path, answers: Connection) -> None:
    # What is there before is not looked through again and again.
    gc.freeze()
    grown = {name: growth(call, CALLS) for name, call in calls().items()}
    loaded = {name: growth(call, LOADS) for name, call in loads(folder).items()}
    answers.send((grown, loaded))


@pytest.mark.slow
def test_memory_is_flat(tmp_path: Path) -> None:
    """In a process of its own, in which no other thread has objects that come and go."""
    ours, theirs = PROCESSES.Pipe(duplex=False)
    grown, loaded = answer_of(start(measured, tmp_path, theirs), ours)
    assert len(grown) + len(loaded) > 30
    for found, most in ((grown, MOST_A_CALL), (loaded, MOST_A_LOAD)):
        assert not {
            name: use
            for name, use in found.items()
            if use.bytes > most.bytes or use.blocks > most.blocks
        }
