"""A reader of files, with whole files to change, and what tells that one was read right."""

from __future__ import annotations

import functools
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple, Protocol

import numpy as np

from tests.hostile.mutant import OTHER, SAME, Mutant, Outcome, faults, outcome


class Trial(NamedTuple):
    """What came of one mutant."""

    mutant: Mutant
    result: str
    """``read``, ``told`` (read, with a warning) or ``refused``."""
    fault: str
    """What is wrong with that; nothing if all is well."""
    seconds: float


class Readable(Protocol):
    """What a campaign asks of a reader."""

    name: str

    def trial(self, number: int, path: Path) -> Trial:
        """Return what comes of the mutant of a number, written to a path without a suffix."""


@dataclass(frozen=True)
class Reader:
    """A reader whose mutants are made here.

    Parameters
    ----------
    name, suffix : str
        What it is called, and how its files end.
    refusals : type
        Base of its errors.
    seeds : sequence of bytes
        Whole files, without comments in which a number stands.
    change : callable
        Takes a seed and a generator, and returns a mutant.
    read : callable
        Takes a path, and returns what was read. It is all that the file says, in values that can be
        compared, so that two files that say the same have equal ones.
    second : callable
        Takes the content and what was read, and says what another reading finds otherwise.
    """

    name: str
    suffix: str
    refusals: type[Exception]
    seeds: Sequence[bytes]
    change: Callable[[bytes, np.random.Generator], Mutant]
    read: Callable[[Path], Any]
    second: Callable[[bytes, Any], str] = field(default=lambda content, value: "")

    def trial(self, number: int, path: Path) -> Trial:
        """Return what comes of the mutant of a number."""
        seed = self.seeds[number % len(self.seeds)]
        mutant = self.change(seed, np.random.default_rng([len(self.name), number]))
        return self.of(mutant._replace(number=number), path, seed)

    def of(self, mutant: Mutant, path: Path, seed: bytes | None = None) -> Trial:
        """Return what comes of a mutant of a seed."""
        found = outcome(mutant, path.with_suffix(self.suffix), self.read, self.refusals)
        result = "refused" if found.value is None else "told" if found.told else "read"
        fault = faults(found)
        if not fault and found.value is not None:
            fault = self._judged(found, seed)
        return Trial(mutant, result, fault, found.seconds)

    def _judged(self, found: Outcome, seed: bytes | None) -> str:
        mutant, original = found.mutant, None if seed is None else self.original(seed)
        if mutant.claim == SAME and found.value != original and not found.told:
            return "what has no meaning changed what was read"
        if mutant.claim == OTHER and found.value == original and not found.told:
            return "another number was passed over"
        return self.second(mutant.content, found.value)

    def original(self, seed: bytes) -> Any:
        """Return what a whole file says."""
        return _original(self.read, self.suffix, seed)


@functools.cache
def _original(read: Callable[[Path], Any], suffix: str, seed: bytes) -> Any:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "seed").with_suffix(suffix)
        path.write_bytes(seed)
        return read(path)
