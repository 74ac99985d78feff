"""Files of NumPy's arrays (``.npz``) whose bytes, arrays and archive are changed at random."""

from __future__ import annotations

import functools
import io
import warnings
import zipfile
import zlib
from collections.abc import Callable

import numpy as np

from tests.hostile.byte_mutants import damaged
from tests.hostile.mutant import LOST, NONE, OTHER, SAME, Mutant

Members = dict[str, bytes]

HEADERS: dict[str, Callable[[str], str]] = {
    "1e12 numbers": lambda head: _shaped(head, "(1000000000000,)"),
    "1e30 numbers": lambda head: _shaped(head, f"({10**30},)"),
    "2**62 numbers": lambda head: _shaped(head, f"({2**62}, 4)"),
    "fewer than none": lambda head: _shaped(head, "(-1,)"),
    "one more": lambda head: _shaped(head, "(1000001,)"),
    "no numbers": lambda head: _shaped(head, "(0,)"),
    "many dimensions": lambda head: _shaped(head, "(" + "1, " * 70 + ")"),
    "objects": lambda head: head.replace("<f8", "|O"),
    "texts": lambda head: head.replace("<f8", "<U2"),
    "complex": lambda head: head.replace("<f8", "<c8"),
    "other bytes first": lambda head: head.replace("<f8", ">f8"),
    "integers": lambda head: head.replace("<f8", "<i8"),
    "halves": lambda head: head.replace("<f8", "<f4"),
    "unknown type": lambda head: head.replace("<f8", "<q9"),
    "long type": lambda head: head.replace("<f8", "<U999999999"),
    "expression": lambda head: head.replace("False", "__import__('os')"),
    "nested": lambda head: head.replace("False", "(" * 2000 + ")" * 2000),
    "nothing": lambda head: "",
}
"""What an array's header says instead."""


def _shaped(head: str, shape: str) -> str:
    begin = head.index("'shape': ") + len("'shape': ")
    return f"{head[:begin]}{shape}{head[head.index(')', begin) + 1 :]}"


def _headed(content: bytes, change: Callable[[str], str]) -> bytes:
    """Return an array's file with another header."""
    length = int.from_bytes(content[8:10], "little")
    head = change(content[10 : 10 + length].decode("latin1")).encode("latin1")
    return content[:8] + (len(head) % 65536).to_bytes(2, "little") + head + content[10 + length :]


def members(archive: bytes) -> Members:
    """Return the files of an archive by name."""
    with zipfile.ZipFile(io.BytesIO(archive)) as file:
        return {name: file.read(name) for name in file.namelist()}


def packed(pairs: list[tuple[str, bytes]], kind: int = zipfile.ZIP_DEFLATED) -> bytes:
    """Return an archive of files, of which two may have one name."""
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", kind) as file:
        for name, content in pairs:
            # The same moment, so that the same files make the same archive.
            entry = zipfile.ZipInfo(name)
            entry.compress_type = kind
            with warnings.catch_warnings():
                # A name may be there twice on purpose.
                warnings.simplefilter("ignore", UserWarning)
                file.writestr(entry, content)
    return out.getvalue()


@functools.cache
def _bomb(size: int = 1 << 29) -> bytes:
    """Return a file of zeros that is small in an archive, half a GiB outside."""
    squeeze = zlib.compressobj(9, zlib.DEFLATED, -15)
    block = bytes(1 << 20)
    parts = [squeeze.compress(block) for _ in range(size >> 20)]
    return b"".join([*parts, squeeze.flush()])


def changed(archive: bytes, rng: np.random.Generator) -> Mutant:
    """Return an archive that was changed."""
    # Archives have checksums: whoever reads changed bytes at all reads what was there.
    if rng.random() < 0.3:
        return damaged(archive, rng, SAME)
    files = members(archive)
    names = list(files)
    name = names[int(rng.integers(len(names)))]
    if rng.random() < 0.5:
        return _array(files, name, rng)
    return _archive(archive, files, name, rng)


def _array(files: Members, name: str, rng: np.random.Generator) -> Mutant:
    """Change an array."""
    content, claim = files[name], ""
    kind = int(rng.integers(4))
    if kind == 0 and b"<f8" in content[:128]:
        numbers = np.lib.format.read_array(io.BytesIO(content)).copy()
        flat = numbers.reshape(-1)
        if flat.size:
            place = int(rng.integers(flat.size))
            old, new = flat[place], (1.25 * flat[place] + 0.375, np.nan, np.inf, 5e-324)
            flat[place] = new[int(rng.integers(4))]
            claim = OTHER if flat[place] != old and np.isfinite(flat[place]) else ""
        out = io.BytesIO()
        np.lib.format.write_array(out, numbers)
        what, files[name] = "another number", out.getvalue()
    elif kind == 1:
        what, files[name] = "cut", content[: int(rng.integers(len(content)))]
    elif kind == 2:
        what, files[name], claim = "numbers behind", content + bytes(8), LOST
    else:
        what = list(HEADERS)[int(rng.integers(len(HEADERS)))]
        try:
            files[name] = _headed(content, HEADERS[what])
        except ValueError:
            files[name] = b""
    return Mutant(0, f"{what} in {name}", packed(list(files.items())), claim)


def _archive(archive: bytes, files: Members, name: str, rng: np.random.Generator) -> Mutant:
    """Change what is in the archive, or how it is packed."""
    what = (
        "stored",
        "removed",
        "added",
        "twice",
        "renamed",
        "in a folder",
        "encrypted",
        "method",
        "bomb",
        "size",
        "comment",
        "junk before",
    )[int(rng.integers(12))]
    pairs, claim = list(files.items()), ""
    if what == "stored":
        return Mutant(0, what, packed(pairs, zipfile.ZIP_STORED), SAME)
    if what == "removed":
        del files[name]
        pairs = list(files.items())
    elif what == "added":
        pairs.append(("extra.npy", files[name]))
        claim = LOST
    elif what == "twice":
        pairs.append((name, next(one for other, one in pairs if other != name)))
        claim = NONE
    elif what in ("renamed", "in a folder"):
        del files[name]
        pairs = [*files.items(), (f"../{name}" if what == "in a folder" else f"x{name}", b"")]
    changed = bytearray(packed(pairs))
    entry = changed.rindex(b"PK\x01\x02")
    if what == "encrypted":
        changed[entry + 8] |= 1
    elif what == "method":
        changed[entry + 10] = 99
    elif what == "size":
        changed[entry + 24 : entry + 28] = (2**31).to_bytes(4, "little")
    elif what == "comment":
        changed[-2:] = (4).to_bytes(2, "little")
        changed += b"text"
    elif what == "junk before":
        changed = bytearray(b"#!/bin/sh\n") + changed
    elif what == "bomb":
        changed = bytearray(_exploding(name, files[name]))
    return Mutant(0, f"{what} {name}", bytes(changed), claim)


def _exploding(name: str, array: bytes) -> bytes:
    """Return an archive of an array that unpacks to half a GiB."""
    size = 1 << 29
    head = _headed(array, lambda one: _shaped(one, f"({size // 8},)"))[: 10 + 118]
    data = _bomb(size)
    squeezed = zlib.compressobj(9, zlib.DEFLATED, -15)
    body = squeezed.compress(head) + squeezed.flush(zlib.Z_FULL_FLUSH) + data
    crc = zlib.crc32(bytes(size), zlib.crc32(head))
    encoded = name.encode()
    whole = len(head) + size
    common = (8).to_bytes(2, "little") + bytes(4) + crc.to_bytes(4, "little")
    common += len(body).to_bytes(4, "little") + whole.to_bytes(4, "little")
    common += len(encoded).to_bytes(2, "little") + bytes(2)
    local = b"PK\x03\x04\x14\x00\x00\x00" + common + encoded + body
    central = b"PK\x01\x02\x14\x00\x14\x00\x00\x00" + common + bytes(14 - 4) + bytes(4) + encoded
    end = b"PK\x05\x06" + bytes(4) + (1).to_bytes(2, "little") * 2
    end += len(central).to_bytes(4, "little") + len(local).to_bytes(4, "little") + bytes(2)
    return local + central + end
