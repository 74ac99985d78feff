"""The scripts of ``examples/``: short, told of on their page, and each does what it says."""

from __future__ import annotations

import re
import runpy
from pathlib import Path

import pytest

FOLDER = Path(__file__).resolve().parents[1] / "examples"
SCRIPTS = sorted(FOLDER.glob("*.py"))
LONGEST = 30
WRITTEN = re.compile(r"\b[\w/]+\.(?:c|csv|fis|fml|html|json|png)\b")


def test_there_are_ten_that_are_told_of_in_order() -> None:
    page = (FOLDER / "README.md").read_text(encoding="utf-8")
    told = re.findall(r"\[`(\w+\.py)`\]\((\w+\.py)\)", page)
    assert sorted(told) == [(path.name, path.name) for path in SCRIPTS]
    assert len(SCRIPTS) == 10


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda path: path.stem)
def test_an_example_is_short_and_does_what_it_says(
    script: Path,
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """From an empty folder. What it names as written is there; what is there it has named."""
    assert len(script.read_text(encoding="utf-8").splitlines()) <= LONGEST
    monkeypatch.chdir(tmp_path)
    runpy.run_path(str(script), run_name="__main__")
    said = capsys.readouterr().out
    assert len(said.splitlines()) >= 3
    for name in WRITTEN.findall(said):
        assert (tmp_path / name).stat().st_size > 0, name
    there = {path.name for path in tmp_path.iterdir()}
    assert [name for name in there if name not in said] == []
