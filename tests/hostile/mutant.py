"""A changed file, what it must come to, and what came of it."""

from __future__ import annotations

import logging
import time
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

MOST_SECONDS = 5.0
"""So much processor time a file may take."""

SAME = "same"
"""What was changed has no meaning: whoever reads the file at all reads what it said before."""
OTHER = "other"
"""A number has another value, which must not be passed over."""
LOST = "lost"
"""Something is where no reader looks for it, or is called what nobody knows."""
NONE = "none"
"""What stands for a number, or for a name, is none."""


class Mutant(NamedTuple):
    """A changed file."""

    number: int
    what: str
    """What was changed."""
    content: bytes
    claim: str = ""
    """``SAME``, ``OTHER``, ``LOST`` or ``NONE``; empty where only a second reading tells."""


class Outcome(NamedTuple):
    """What became of a mutant."""

    mutant: Mutant
    value: Any
    """What the reader returned; None of a refusal."""
    refused: Exception | None
    failed: BaseException | None
    """Any other exception."""
    told: str
    """What was logged, or warned of."""
    seconds: float
    """Processor time."""


def outcome(
    mutant: Mutant, path: Path, read: Callable[[Path], Any], refusals: type[Exception]
) -> Outcome:
    """Write a mutant to a path, read it, and return what became of it."""
    path.write_bytes(mutant.content)
    told = _Told()
    loggers = [logging.getLogger(name) for name in ("psp3", "fuzzy2")]
    for logger in loggers:
        logger.addHandler(told)
    begun = time.process_time()
    value, refused, failed = None, None, None
    try:
        with warnings.catch_warnings(record=True) as warned:
            warnings.simplefilter("always")
            value = read(path)
    except refusals as error:
        refused = error
    except Exception as error:
        failed = error
    finally:
        for logger in loggers:
            logger.removeHandler(told)
    seconds = time.process_time() - begun
    messages = [*told.messages, *(str(one.message) for one in warned)]
    return Outcome(mutant, value, refused, failed, "; ".join(messages), seconds)


def faults(found: Outcome) -> str:
    """Say what is wrong with an outcome, whatever the format; nothing if it is as it should be."""
    if found.failed is not None:
        return f"{type(found.failed).__name__}: {found.failed}"
    if found.refused is not None and not str(found.refused).strip():
        return "refused without a word"
    if found.seconds > MOST_SECONDS:
        return f"took {found.seconds:.1f} s"
    if found.mutant.claim in (LOST, NONE) and found.refused is None and not found.told:
        return "lost without a word" if found.mutant.claim == LOST else "read, though it is none"
    return ""


class _Told(logging.Handler):
    """Keeps what is logged."""

    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self.messages: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        self.messages.append(record.getMessage())
