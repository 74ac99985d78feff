"""Files of arrays, ``.npz``, whose sizes are checked before anything is read.

An ``.npz`` is a zip of arrays, each with a header that states its size. A file may come from
anywhere, so neither is trusted: a header of a hundred bytes can ask for terabytes, a compressed
megabyte can hold a gigabyte, and an array of objects can run any code.
"""

from __future__ import annotations

import io
import math
import struct
import zipfile
import zlib
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

LARGEST = 512 * 2**20
"""Default limit of the bytes of all arrays of a file together."""

MOST_MEMBERS = 100
"""Greatest number of arrays in a file."""

END = struct.Struct("<4s4H2LH")
"""The end record of a zip without a comment: mark, numbers of disks and members, size and place of
its table of contents.
"""

LONG_END = b"PK\x06\x07"
"""Mark before the end record in a zip of more than 4 GiB."""

ENCRYPTED = 1
"""Flag of a member with a password."""

MOST_DIMENSIONS = 8
"""Greatest number of dimensions of an array."""

PIECE = 2**20
"""Number of bytes that are read at a time."""

KINDS = "fbU"
"""Kinds of arrays: floating-point numbers, booleans and text."""


def arrays_of(path: str | Path, largest: int = LARGEST) -> Mapping[str, NDArray[np.generic]]:
    """Return the arrays of an ``.npz`` file by their names.

    Parameters
    ----------
    path : path
        The file, as :func:`numpy.savez` and :func:`numpy.savez_compressed` write them.
    largest : int
        Limit of the bytes of all arrays together.

    Raises
    ------
    OSError
        If the file cannot be read.
    ValueError
        If it is not such a file, is damaged, encrypted or compressed in another way, holds other
        kinds of arrays, or exceeds ``largest``.
    """
    with Path(path).open("rb") as file:
        _check_end(file)
        try:
            with zipfile.ZipFile(file) as archive:
                members = _checked_members(archive, largest)
                return {
                    member.filename.removesuffix(".npy"): _array(archive, member)
                    for member in members
                }
        except (zipfile.BadZipFile, zlib.error, EOFError, struct.error) as error:
            raise ValueError(str(error) or "it ends too early") from error
        except (NotImplementedError, RuntimeError, AttributeError) as error:
            raise ValueError(f"it is not a zip file of the usual kind: {error}") from error


def _check_end(file: io.BufferedReader) -> None:
    """Refuse a zip whose table of contents would fill the memory."""
    size = file.seek(0, io.SEEK_END)
    tail = 20 + END.size
    file.seek(max(0, size - tail))
    content = file.read(tail)
    if len(content) < END.size:
        raise ValueError("it is not a zip file")
    mark, _, _, _, members, table, _, comment = END.unpack(content[-END.size :])
    if mark != b"PK\x05\x06" or comment:
        raise ValueError("it is not a zip file, or has a comment")
    if content.startswith(LONG_END) or members > MOST_MEMBERS or table > 2**16:
        raise ValueError(f"it has more than {MOST_MEMBERS} members, or a long table of contents")
    file.seek(0)


def _checked_members(archive: zipfile.ZipFile, largest: int) -> list[zipfile.ZipInfo]:
    members = archive.infolist()
    if len({member.filename for member in members}) < len(members):
        raise ValueError("two of its members have one name")
    for member in members:
        if member.flag_bits & ENCRYPTED:
            raise ValueError("it is encrypted")
        if member.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
            raise ValueError("it is compressed in another way than NumPy's")
    total = sum(member.file_size for member in members)
    if total > largest:
        raise ValueError(
            f"its arrays have {total} bytes, and {largest} are read; if you trust the file, give "
            f"largest={total}"
        )
    return members


def _array(archive: zipfile.ZipFile, member: zipfile.ZipInfo) -> NDArray[np.generic]:
    """Return the array of a member, whose header must match its data."""
    with archive.open(member) as content:
        version = np.lib.format.read_magic(content)
        read_header = {
            (1, 0): np.lib.format.read_array_header_1_0,
            (2, 0): np.lib.format.read_array_header_2_0,
        }.get(version)
        if read_header is None:
            raise ValueError(f"{member.filename[:80]!r} is an array of another version")
        shape, by_columns, kind = read_header(content)
        if kind.kind not in KINDS or kind.hasobject or kind.subdtype is not None:
            raise ValueError(f"{member.filename[:80]!r} holds {str(kind)[:80]}")
        if any(length < 0 for length in shape) or len(shape) > MOST_DIMENSIONS:
            raise ValueError(f"{member.filename[:80]!r} has an impossible shape")
        size = member.file_size - content.tell()
        if math.prod(shape) * kind.itemsize != size:
            raise ValueError(
                f"{member.filename[:80]!r} says it holds {math.prod(shape)} entries, and has "
                f"{size} bytes"
            )
        data = np.empty(size, np.uint8)
        at = 0
        while piece := content.read(PIECE):
            data[at : at + len(piece)] = np.frombuffer(piece, np.uint8)
            at += len(piece)
        if at != size:
            raise ValueError(f"{member.filename[:80]!r} ends too early")
    # Booleans are bytes of 0 or 1; any other byte means a damaged file.
    if kind.kind == "b" and data.max(initial=0) > 1:
        raise ValueError(f"{member.filename[:80]!r} holds bytes that are not booleans")
    return data.view(kind).reshape(shape, order="F" if by_columns else "C")
