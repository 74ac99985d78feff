"""What a reader takes of a file, and what it shows of one."""

from __future__ import annotations

import errno
from pathlib import Path

import pytest

from fuzzy2.support.bounded_files import LONGEST_REASON, content_of, shortened


def test_a_file_is_read_up_to_so_many_bytes(tmp_path: Path) -> None:
    path = tmp_path / "file"
    path.write_bytes(b"1234")
    assert content_of(path, 4) == b"1234"
    with pytest.raises(OSError, match=r"larger than .* which is the most") as caught:
        content_of(path, 3)
    assert caught.value.errno == errno.EFBIG
    assert caught.value.filename == str(path)


def test_a_device_without_an_end_is_not_read_to_its_end() -> None:
    with pytest.raises(OSError, match="larger than"):
        content_of("/dev/zero", 10**6)


def test_a_long_text_keeps_its_begin_and_its_end() -> None:
    assert shortened("as it is") == "as it is"
    text = shortened("begin" + "x" * 10**6 + "remedy")
    assert len(text) < LONGEST_REASON + 10
    assert text.startswith("begin")
    assert text.endswith("remedy")
