"""A worker whose readers do what no reader may, to see that a campaign notices.

It is started as :mod:`tests.hostile.worker` is.
"""

from __future__ import annotations

import os
import sys
from dataclasses import dataclass
from pathlib import Path

from tests.hostile import worker
from tests.hostile.mutant import Mutant
from tests.hostile.reader import Reader, Trial


@dataclass
class Hanging:
    """A reader that computes for ever at its second mutant."""

    name: str = "hanging"

    def trial(self, number: int, path: Path) -> Trial:
        """Return what comes of a mutant, but for one."""
        while number == 1:
            pass
        return Trial(Mutant(number, "", b""), "read", "", 0.0)


@dataclass
class Dying:
    """A reader that takes the process with it at its second mutant."""

    name: str = "dying"

    def trial(self, number: int, path: Path) -> Trial:
        """Return what comes of a mutant, but for one."""
        if number == 1:
            os.abort()
        return Trial(Mutant(number, "", b""), "read", "", 0.0)


def _greedy(path: Path) -> str:
    return str(len(bytearray(4 << 30)))


BAD = (
    Hanging(),
    Dying(),
    Reader("greedy", ".txt", LookupError, (b"",), lambda seed, rng: Mutant(0, "", b""), _greedy),
)

if __name__ == "__main__":
    worker.KILLED, worker.WARMING = 0.5, 0
    worker.all_readers = lambda: {one.name: one for one in BAD}
    Reader.original = lambda self, seed: None
    worker.main(sys.argv[1:])
