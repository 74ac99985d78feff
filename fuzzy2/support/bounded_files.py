"""What a reader takes: so many bytes of a file, so much in it, and no more.

A file from elsewhere may be made to fill the memory or to take hours. So every reader of both
packages looks at these bounds before it makes anything of a file. Files that people write are far
below them; ``docs/robot_files.md`` says them in words, with those of single formats.
"""

from __future__ import annotations

import errno
import os

from fuzzy2.support.checks import named_path

LARGEST_TEXT = 16 * 2**20
"""Bytes of a file that is text."""

LARGEST_NUMBERS = 64 * 2**20
"""Bytes of a file of numbers in words: a table, a mesh, a map, a controller."""

DEEPEST = 200
"""So many elements, lists or objects may be in each other."""

MOST_ELEMENTS = 100_000
"""Elements of an XML file, those that it includes and copies among them."""

MOST_PARTS = 1_000_000
"""Lists, objects and keys of a JSON file."""

LONGEST_REASON = 2000
"""Characters of an error message about a file, whatever stands in the file."""


def content_of(path: str | os.PathLike[str], most: int = LARGEST_TEXT) -> bytes:
    """Return the bytes of a file that has at most so many.

    Raises
    ------
    InvalidValue
        If it is no path.
    OSError
        If the file cannot be read, or has more; ``strerror`` says so.
    """
    with open(named_path(path), "rb") as file:
        content = file.read(most + 1)
    if len(content) > most:
        reason = f"larger than {most / 2**20:g} MiB, which is the most that is read of such a file"
        raise OSError(errno.EFBIG, reason, os.fspath(path))
    return content


def shortened(text: str, most: int = LONGEST_REASON) -> str:
    """Return a text, or its begin and its end, where the remedy stands, if it is longer."""
    if len(text) <= most:
        return text
    return f"{text[: 2 * most // 3]} [...] {text[-most // 3 :]}"
