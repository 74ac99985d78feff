"""Files of arrays: what NumPy writes is read bit for bit, and what would harm is refused."""

from __future__ import annotations

import io
import struct
import zipfile
from pathlib import Path

import numpy as np
import pytest

from psp3.simulation.array_files import arrays_of

ARRAYS = {
    "t": np.linspace(0.0, 1.0, 7),
    "matrix": np.asfortranarray(np.arange(12.0).reshape(3, 4)),
    "flags": np.array([True, False]),
    "text": np.array("psp3-result-2"),
    "none": np.zeros((0, 3)),
    "single": np.float32([1.5]),
}


def header(shape: tuple[int, ...], kind: str = "<f8") -> bytes:
    content = io.BytesIO()
    entries = {"descr": kind, "fortran_order": False, "shape": shape}
    np.lib.format.write_array_header_1_0(content, entries)
    return content.getvalue()


def archive(path: Path, *members: tuple[str, bytes], how: int = zipfile.ZIP_STORED) -> Path:
    with zipfile.ZipFile(path, "w", how) as file:
        for name, content in members:
            file.writestr(name, content)
    return path


@pytest.mark.parametrize("save", [np.savez, np.savez_compressed])
def test_what_numpy_writes_is_read_bit_for_bit(tmp_path: Path, save: object) -> None:
    save(tmp_path / "a.npz", **ARRAYS)  # type: ignore[operator]
    found = arrays_of(tmp_path / "a.npz")
    assert list(found) == list(ARRAYS)
    for name, array in ARRAYS.items():
        assert found[name].dtype == array.dtype
        np.testing.assert_array_equal(found[name], array, strict=True)
        assert found[name].flags.writeable


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (header((10**12,)), "says it holds 1000000000000 entries, and has 0 bytes"),
        (header((10**30,)), "says it holds 10+ entries"),
        (header((2**32, 2**32)), "says it holds"),
        (header((2,)) + bytes(8), "says it holds 2 entries, and has 8 bytes"),
        (header((1,)) + bytes(16), "says it holds 1 entries, and has 16 bytes"),
        (header((-1, -1)) + bytes(8), "impossible shape"),
        (header((1,) * 20) + bytes(8), "impossible shape"),
        (header((1,), "|O") + b"\x80\x04N.", "holds object"),
        (header((1,), "|b1") + b"\x02", "not booleans"),
        (header((1,), "<M8[s]") + bytes(8), "holds datetime64"),
        (b"\x93NUMPY\x09\x00", "another version"),
        (b"nothing", "magic"),
        (b"", "EOF"),
    ],
)
def test_a_header_that_says_something_else_than_is_there_is_refused(
    tmp_path: Path, content: bytes, words: str
) -> None:
    with pytest.raises(ValueError, match=words):
        arrays_of(archive(tmp_path / "a.npz", ("t.npy", content)))


def test_a_compressed_file_is_read_up_to_so_many_bytes(tmp_path: Path) -> None:
    """What would be a thousand times the file's size is not taken into memory."""
    path = tmp_path / "a.npz"
    np.savez_compressed(path, t=np.zeros(10**6))
    assert path.stat().st_size < 20_000
    with pytest.raises(ValueError, match=r"8000128 bytes, and 1000000 are read.*largest=8000128"):
        arrays_of(path, 10**6)
    assert arrays_of(path, 8000128)["t"].size == 10**6


def test_archives_of_other_kinds_are_refused(tmp_path: Path) -> None:
    good = header((1,)) + bytes(8)
    path = archive(tmp_path / "a.npz", ("t.npy", good), how=zipfile.ZIP_LZMA)
    with pytest.raises(ValueError, match="compressed in another way"):
        arrays_of(path)
    with pytest.warns(UserWarning, match="Duplicate"):
        path = archive(tmp_path / "b.npz", ("t.npy", good), ("t.npy", good))
    with pytest.raises(ValueError, match="one name"):
        arrays_of(path)
    path = archive(tmp_path / "c.npz", *((f"{k}.npy", good) for k in range(101)))
    with pytest.raises(ValueError, match="more than 100 members"):
        arrays_of(path)
    content = bytearray(archive(tmp_path / "d.npz", ("t.npy", good)).read_bytes())
    for mark, place in ((b"PK\x03\x04", 6), (b"PK\x01\x02", 8)):
        content[content.index(mark) + place] |= 1
    (tmp_path / "d.npz").write_bytes(content)
    with pytest.raises(ValueError, match="encrypted"):
        arrays_of(tmp_path / "d.npz")


def test_a_changed_byte_of_the_numbers_is_noticed(tmp_path: Path) -> None:
    path = archive(tmp_path / "a.npz", ("t.npy", header((4,)) + np.arange(4.0).tobytes()))
    content = bytearray(path.read_bytes())
    content[content.index(struct.pack("<d", 3.0)) + 7] ^= 1
    path.write_bytes(content)
    with pytest.raises(ValueError, match="CRC"):
        arrays_of(path)


@pytest.mark.parametrize("content", [b"", b"PK", bytes(22), b"PK\x05\x06" + bytes(17) + b"\1"])
def test_what_is_no_zip_is_refused(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "a.npz"
    path.write_bytes(content)
    with pytest.raises(ValueError, match="not a zip file"):
        arrays_of(path)
    with pytest.raises(FileNotFoundError):
        arrays_of(tmp_path / "none.npz")
