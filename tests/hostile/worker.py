"""A process that reads mutants within bounds, and says what comes of them.

``python -m tests.hostile.worker READER FIRST LAST [READER FIRST LAST ...]`` writes a line of JSON
before each mutant, its reader and number, and one behind it, what came of it. It may take a GiB
more than it has when it begins. A mutant that takes :data:`KILLED` seconds of processor time, or
waits for something for :data:`SILENT` seconds, ends the process, wherever it is; who has started it
knows from the last line which one it was.
"""

from __future__ import annotations

import faulthandler
import json
import os
import resource
import signal
import sys
import tempfile
from pathlib import Path

from tests.hostile.fuzzy_readers import fuzzy_readers
from tests.hostile.reader import Readable, Reader
from tests.hostile.robot_readers import robot_readers

MEMORY = 1 << 30
"""So much more than it has at the beginning may the process take [bytes]."""

KILLED = 20.0
"""Processor time after which a mutant is not waited for any longer [s]."""

SILENT = 900.0
"""Time after which neither is one that computes nothing, but waits for something [s]."""


def all_readers() -> dict[str, Readable]:
    """Return the readers of both packages by name."""
    return {one.name: one for one in (*fuzzy_readers(), *robot_readers())}


def work(name: str, numbers: range, folder: Path) -> None:
    """Read mutants, and write what comes of each."""
    reader = all_readers()[name]
    for number in numbers:
        _say({"reader": name, "number": number})
        signal.setitimer(signal.ITIMER_PROF, KILLED)
        faulthandler.dump_traceback_later(SILENT, exit=True)
        trial = reader.trial(number, folder / "mutant")
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        said = {"result": trial.result, "seconds": trial.seconds}
        if trial.fault:
            content = trial.mutant.content.hex() if len(trial.mutant.content) < 100_000 else ""
            said |= {"fault": trial.fault[:2000], "what": trial.mutant.what, "content": content}
        _say(said)


def _say(something: dict[str, object]) -> None:
    print(json.dumps(something), flush=True)


BEYOND = 10**9
"""Mutants from this number on are read before all others, so that code is compiled by then."""

WARMING = 40
"""So many of each reader."""


def _prepare(names: list[str], folder: Path) -> None:
    """Read every whole file once, and a few mutants, and bound the memory."""
    faulthandler.dump_traceback_later(SILENT, exit=True)
    for name in names:
        reader = all_readers()[name]
        if isinstance(reader, Reader):
            for seed in reader.seeds:
                reader.original(seed)
            for number in range(BEYOND, BEYOND + WARMING):
                reader.trial(number, folder / "mutant")
    pages = int(Path("/proc/self/statm").read_text().split()[0])
    limit = pages * os.sysconf("SC_PAGE_SIZE") + MEMORY
    resource.setrlimit(resource.RLIMIT_AS, (limit, limit))


def main(arguments: list[str]) -> None:
    """Do what the command line says."""
    names, firsts, lasts = arguments[::3], arguments[1::3], arguments[2::3]
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)  # MuJoCo writes its warnings into a file where it runs
        _prepare(names, Path(folder))
        before = _peak()
        for name, first, last in zip(names, firsts, lasts, strict=True):
            work(name, range(int(first), int(last)), Path(folder))
    _say({"grown": _peak() - before, "peak": _peak()})


def _peak() -> int:
    """Return the most memory that this process has held [bytes]."""
    return 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


if __name__ == "__main__":
    main(sys.argv[1:])
