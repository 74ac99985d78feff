"""Drafts: files under way to the place of another one, and what is left of them after a kill.

A draft is locked by the process that writes it, and the lock ends with the process, however it
ends. So a draft that nobody holds is nobody's, and whoever saves next in its folder removes it. No
clock and no number of a process is asked, which could both be those of another.
"""

from __future__ import annotations

import fcntl
import os
import re
from collections.abc import Callable
from contextlib import suppress
from typing import IO, Any

DRAFT = re.compile(r"\.fuzzy2-[0-9a-f]{16}\.part")
"""Names of drafts: short, so that there is room wherever there is room for the target's name."""


def new_draft(folder: str, opened: Callable[[str], IO[Any]]) -> tuple[str, IO[Any]]:
    """Make a draft that is locked, and return its path with the open file.

    Parameters
    ----------
    folder : str
        Where.
    opened : callable
        Makes the file of a path, which must not exist, and opens it.

    Raises
    ------
    OSError
        If it cannot be made.
    """
    while True:
        path = os.path.join(folder, f".fuzzy2-{os.urandom(8).hex()}.part")
        file = opened(path)
        if _is_locked(file) and _is_there(file, path):
            return path, file
        # Somebody who clears away has found it in the moment before it was locked.
        file.close()
        with suppress(FileNotFoundError):
            os.unlink(path)


def is_draft(path: object) -> bool:
    """Tell whether this is the path of a draft, by its name."""
    return isinstance(path, str) and DRAFT.fullmatch(os.path.basename(path)) is not None


def clear_drafts(folder: str) -> None:
    """Remove the drafts in a folder that nobody writes any more, where that is possible."""
    with suppress(OSError), os.scandir(folder or ".") as entries:
        for path in [entry.path for entry in entries if DRAFT.fullmatch(entry.name)]:
            with suppress(OSError):
                _remove_abandoned(path)


def _remove_abandoned(path: str) -> None:
    descriptor = os.open(path, os.O_RDWR | os.O_NOFOLLOW | os.O_NONBLOCK)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        # A draft that has just taken its place has no such name any more.
        os.unlink(path)
    finally:
        os.close(descriptor)


def _is_locked(file: IO[Any]) -> bool:
    try:
        fcntl.flock(file.fileno(), fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:
        # A file system without locks: there nobody clears away either.
        return True
    return True


def _is_there(file: IO[Any], path: str) -> bool:
    try:
        return os.path.samestat(os.fstat(file.fileno()), os.stat(path))
    except FileNotFoundError:
        return False
