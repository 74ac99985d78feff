"""Text files: read with errors that name the line, written whole or not at all."""

from __future__ import annotations

import os
from pathlib import Path

from fuzzy2.errors import MalformedFile


def read_text(path: str | os.PathLike[str]) -> str:
    """Return the text of a file in UTF-8, with or without a byte order mark.

    Raises
    ------
    MalformedFile
        If it is not UTF-8; it names the line.
    OSError
        If it cannot be read.
    """
    content = Path(path).read_bytes()
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        raise MalformedFile(
            str(path),
            f"line {line}",
            f"byte 0x{content[error.start]:02x} is not UTF-8; save the file as UTF-8",
        ) from None


def write_text(text: str, path: str | os.PathLike[str]) -> None:
    """Write a file in UTF-8, as a whole.

    Whoever reads it at the same time, or after a crash, finds the old one or the new one, never a
    part.

    Raises
    ------
    OSError
        If it cannot be written; what was there before remains.
    """
    # Behind a symbolic link the file is replaced, not the link.
    target = Path(os.path.realpath(path))
    draft = target.with_name(f".{target.name}.{os.getpid()}.draft")
    try:
        with draft.open("x", encoding="utf-8", newline="\n") as file:
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
        draft.replace(target)
    except BaseException:
        draft.unlink(missing_ok=True)
        raise
