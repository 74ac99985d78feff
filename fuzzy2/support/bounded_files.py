"""Limits of what a reader accepts: the size of a file and the number of its elements.

A malicious file could fill the memory or take hours to read. So every reader of both packages
checks these limits before it processes a file. Ordinary files are far below them.
``docs/robot_files.md`` lists them, together with the limits of single formats.
"""

from __future__ import annotations

import errno
import os

from fuzzy2.support.checks import named_path

LARGEST_TEXT = 16 * 2**20
"""Greatest size of a text file, in bytes."""

LARGEST_NUMBERS = 64 * 2**20
"""Greatest size of a file of numbers in text form, such as a table, mesh, map or controller, in
bytes."""

DEEPEST = 200
"""Greatest depth of nested elements, lists or objects."""

MOST_ELEMENTS = 100_000
"""Greatest number of elements of an XML file, including included and copied ones."""

MOST_PARTS = 1_000_000
"""Greatest number of lists, objects and keys of a JSON file."""

LONGEST_REASON = 2000
"""Greatest length of an error message about a file, whatever the file contains."""


def content_of(path: str | os.PathLike[str], most: int = LARGEST_TEXT) -> bytes:
    """Return the bytes of a file, whose size is limited.

    Raises
    ------
    InvalidValue
        If ``path`` is not a path.
    OSError
        If the file cannot be read or is too large; ``strerror`` says which.
    """
    with open(named_path(path), "rb") as file:
        content = file.read(most + 1)
    if len(content) > most:
        reason = f"larger than {most / 2**20:g} MiB, which is the most that is read of such a file"
        raise OSError(errno.EFBIG, reason, os.fspath(path))
    return content


def not_read(error: Exception, otherwise: str = "cannot be read") -> str:
    """Return why a file cannot be used, as a person would say it.

    A file that is missing is called that, and not one that is malformed.
    """
    if isinstance(error, FileNotFoundError):
        return "no such file"
    if isinstance(error, IsADirectoryError):
        return "is a directory"
    return f"{otherwise} ({getattr(error, 'strerror', None) or error})"


def shortened(text: str, most: int = LONGEST_REASON) -> str:
    """Return a text, or its beginning and its end, which holds the remedy, if it is too long."""
    if len(text) <= most:
        return text
    return f"{text[: 2 * most // 3]} [...] {text[-most // 3 :]}"
