"""Drafts: temporary files that will replace other files, and their removal after a crash.

The process that writes a draft holds a lock on it, which ends with the process, however it ends. So
an unlocked draft is abandoned, and the next process that saves a file in its folder removes it.
Neither times nor process numbers are used, because both could be misleading.
"""

from __future__ import annotations

import fcntl
import os
import re
from collections.abc import Callable
from contextlib import suppress
from typing import IO, Any

DRAFT = re.compile(r"\.fuzzy2-[0-9a-f]{16}\.part")
"""Pattern of the names of drafts, which are short so that they are never longer than allowed."""


def new_draft(folder: str, opened: Callable[[str], IO[Any]]) -> tuple[str, IO[Any]]:
    """Make a locked draft, and return its path and the open file.

    Parameters
    ----------
    folder : str
        Where.
    opened : callable
        Creates the file with a given path, which must not exist, and opens it.

    Raises
    ------
    OSError
        If the draft cannot be made.
    """
    while True:
        path = os.path.join(folder, f".fuzzy2-{os.urandom(8).hex()}.part")
        file = opened(path)
        if _is_locked(file) and _is_there(file, path):
            return path, file
        # Another process found the draft before it was locked, and removed it.
        file.close()
        with suppress(FileNotFoundError):
            os.unlink(path)


def is_draft(path: object) -> bool:
    """Return whether a path is that of a draft, by its name."""
    return isinstance(path, str) and DRAFT.fullmatch(os.path.basename(path)) is not None


def clear_drafts(folder: str) -> None:
    """Remove the abandoned drafts in a folder, as far as possible."""
    with suppress(OSError), os.scandir(folder or ".") as entries:
        for path in [entry.path for entry in entries if DRAFT.fullmatch(entry.name)]:
            with suppress(OSError):
                _remove_abandoned(path)


def _remove_abandoned(path: str) -> None:
    descriptor = os.open(path, os.O_RDWR | os.O_NOFOLLOW | os.O_NONBLOCK)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        # A draft that has just replaced its target no longer exists under this name.
        os.unlink(path)
    finally:
        os.close(descriptor)


def _is_locked(file: IO[Any]) -> bool:
    try:
        fcntl.flock(file.fileno(), fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:
        # On a file system without locks, no process removes drafts.
        return True
    return True


def _is_there(file: IO[Any], path: str) -> bool:
    try:
        return os.path.samestat(os.fstat(file.fileno()), os.stat(path))
    except FileNotFoundError:
        return False
