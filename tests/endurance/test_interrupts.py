"""Ctrl-C ends whatever takes long within a second of computing.

Each of these would take minutes. The time is that of the process, so that a busy machine is no
failure; where two threads compute, both count.
"""

from __future__ import annotations

import os
import signal
import sys
import threading
import time
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from psp3.errors import StudyInterrupted
from tests.endurance.long_work import LONG_WORK
from tests.processes import PROCESSES, answer_of, computed, start

MOST = 1.0
"""Seconds of computing of one thread after the signal."""


def interrupt() -> None:
    os.kill(os.getpid(), signal.SIGINT)


def press_again(dropped: Any) -> None:
    """Stand in for who presses Ctrl-C once more: Python drops what is raised in a finalizer."""
    if isinstance(dropped.exc_value, KeyboardInterrupt):
        threading.Timer(0.05, interrupt).start()


def work_until_interrupted(name: str, folder: Path, answers: Connection) -> None:
    """Prepare some work, say so, do it, and tell how much was computed until it ended."""
    os.chdir(folder)
    sys.unraisablehook = press_again
    work = LONG_WORK[name]()
    try:
        answers.send("begun")
        work()
        answers.send("done")
    except (KeyboardInterrupt, StudyInterrupted):
        answers.send(time.process_time())


@pytest.mark.slow
@pytest.mark.parametrize("name", LONG_WORK)
def test_ctrl_c_ends_long_work_within_a_second(name: str, tmp_path: Path) -> None:
    ours, theirs = PROCESSES.Pipe(duplex=False)
    process = start(work_until_interrupted, name, tmp_path, theirs)
    theirs.close()
    pid = process.pid or 0
    assert answer_of(process, ours) == "begun"
    # The same moments each time; what is called for the first time may still be loaded.
    until = computed(pid) + np.random.default_rng(len(name)).uniform(0.1, 0.6)
    while process.is_alive() and computed(pid) < until:
        time.sleep(0.01)
    before = computed(pid)
    os.kill(pid, signal.SIGINT)
    after = answer_of(process, ours)
    process.join()
    assert after != "done"
    assert after - before < MOST * len(os.sched_getaffinity(0))
