"""Files: errors in text name the line, and files are written completely or not at all."""

from __future__ import annotations

import errno
import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO, Any, Literal

from fuzzy2.errors import FileNotWritten, MalformedFile
from fuzzy2.support.bounded_files import LARGEST_NUMBERS, content_of
from fuzzy2.support.checks import named_path
from fuzzy2.support.drafts import clear_drafts, is_draft, new_draft

STANDARD_STREAMS = (1, 2)
"""Descriptors of standard output and standard error."""

NO_SYNC_OF_FOLDERS = (errno.EINVAL, errno.ENOTSUP, errno.EACCES)
"""Errors of file systems whose folders cannot be synchronized, or not with our permissions."""


def read_text(path: str | os.PathLike[str], most: int = LARGEST_NUMBERS) -> str:
    """Return the text of a UTF-8 file, whose size is limited.

    A byte order mark is removed.

    Raises
    ------
    MalformedFile
        If the file is not UTF-8; the message names the line.
    OSError
        If the file cannot be read or is too large.
    """
    content = content_of(path, most)
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
    """Write a text file completely or not at all, as :func:`written_whole` does."""
    with written_whole(path) as file:
        file.write(text)


@contextmanager
def written_whole(
    path: str | os.PathLike[str], mode: Literal["w", "wb"] = "w"
) -> Iterator[IO[Any]]:
    """Open a file for writing that replaces the existing file only when it is complete.

    A program that reads the file at the same time, or after a crash, finds the old file or the new
    file, never a part. Until it is complete, the new file has a random name in the same folder. An
    exception removes it; if the process is killed, the next process that saves a file in that
    folder removes it. A saved file survives a loss of power, because file and folder are
    synchronized.

    If the path is a symbolic link, its target is replaced, not the link. The new file has the
    permissions of the old one, and its owner if that is allowed. Pipes, devices and a file that is
    standard output cannot be replaced and are written directly.

    Parameters
    ----------
    path : path
        The file.
    mode : {"w", "wb"}
        Text in UTF-8 whose lines end with a line feed, or bytes.

    Yields
    ------
    file
        The open file.

    Raises
    ------
    InvalidValue
        If ``path`` is not a path.
    FileNotWritten
        If the file cannot be written or is marked read-only; an ``OSError``. The old file is kept.
    """
    name = os.fspath(named_path(path))
    target = os.path.realpath(name)
    try:
        status = _status(name)
        if status is None or _can_be_replaced(status):
            with _replacing(target, mode, status) as file:
                yield file
        else:
            with _opened(name, mode) as file:
                yield file
    except OSError as error:
        # Errors while writing to an open file do not name a file, and users do not know the draft.
        if error.errno is None or not (error.filename in (None, name) or is_draft(error.filename)):
            raise
        raise FileNotWritten(error.errno, error.strerror or "", name) from error


def made_folder(path: str | os.PathLike[str]) -> Path:
    """Return a folder, which is made, with its parents, if it does not exist.

    Raises
    ------
    InvalidValue
        If ``path`` is not a path.
    FileNotWritten
        If the folder cannot be made.
    """
    named_path(path)
    try:
        Path(path).mkdir(parents=True, exist_ok=True)
    except OSError as error:
        code = errno.ENOTDIR if isinstance(error, FileExistsError) else error.errno
        raise FileNotWritten(code or 0, os.strerror(code or 0), os.fspath(path)) from error
    return Path(path)


def _status(name: str) -> os.stat_result | None:
    """Return the status of a file, or None if it does not exist, as behind a dangling link."""
    try:
        status = os.stat(name)
    except FileNotFoundError:
        return None
    # Root can write to all files, and a folder's permissions allow replacing any file in it. A file
    # marked read-only is still meant to be kept.
    if not (status.st_mode & 0o222 and os.access(name, os.W_OK)):
        is_mounted_so = os.statvfs(name).f_flag & os.ST_RDONLY
        code = errno.EROFS if is_mounted_so else errno.EACCES
        raise OSError(code, os.strerror(code), name)
    return status


def _can_be_replaced(status: os.stat_result) -> bool:
    if not stat.S_ISREG(status.st_mode):
        return False
    for stream in STANDARD_STREAMS:
        with suppress(OSError):  # it is closed
            if os.path.samestat(os.fstat(stream), status):
                return False
    return True


@contextmanager
def _replacing(target: str, mode: str, status: os.stat_result | None) -> Iterator[IO[Any]]:
    folder = os.path.dirname(target)
    # Done first, because abandoned drafts may be what fills the disk.
    clear_drafts(folder)
    draft = None
    try:
        # The mode "x" creates the file with the permissions that the umask allows.
        draft, opened = new_draft(folder, lambda path: _opened(path, mode.replace("w", "x")))
        with opened as file:
            if status is not None:
                with suppress(PermissionError):
                    os.fchown(file.fileno(), status.st_uid, status.st_gid)
                os.fchmod(file.fileno(), stat.S_IMODE(status.st_mode))
            yield file
            file.flush()
            os.fsync(file.fileno())
            # The lock is held while the draft is open.
            os.replace(draft, target)
        _synchronize(folder)
    except BaseException:
        if draft is not None:
            with suppress(FileNotFoundError, NotADirectoryError):
                os.unlink(draft)
        raise


def _synchronize(folder: str) -> None:
    """Make the name of a new file, not only its content, survive a loss of power."""
    try:
        descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)
    except OSError as error:
        if error.errno not in NO_SYNC_OF_FOLDERS:
            raise OSError(error.errno, error.strerror) from error


def _opened(name: str, mode: str) -> IO[Any]:
    if "b" in mode:
        return open(name, mode)
    return open(name, mode, encoding="utf-8", newline="\n")
