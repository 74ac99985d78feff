"""Files on which readers once failed, made as small as they go; each is refused, or read right.

A file lies in the folder of its reader. What is to be read, and not refused, has ``read_`` before
its name.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.hostile.mutant import Mutant
from tests.hostile.reader import Reader
from tests.hostile.worker import all_readers

CORPUS = Path(__file__).parent / "corpus"
FILES = sorted(path for path in CORPUS.rglob("*") if path.is_file())


@pytest.mark.parametrize("path", FILES, ids=[str(path.relative_to(CORPUS)) for path in FILES])
def test_what_once_failed(path: Path, tmp_path: Path) -> None:
    reader = all_readers()[path.parent.name]
    assert isinstance(reader, Reader)
    trial = reader.of(Mutant(0, path.name, path.read_bytes()), tmp_path / "file")
    assert trial.fault == ""
    expected = ("read", "told") if path.name.startswith("read_") else ("refused",)
    assert trial.result in expected
