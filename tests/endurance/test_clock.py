"""A clock that is set back changes nothing: no module of the packages looks at it.

What takes long is measured by clocks that only go forward, and nothing is older or newer than
something else by the times of files.
"""

from __future__ import annotations

import ast
import pathlib
import re
import time

import pytest

import psp3
from psp3.study import Study, grid
from tests.processes import ROOT
from tests.study_helpers import QUICK

SET_BACK = {"time", "time_ns", "localtime", "gmtime", "ctime", "strftime", "asctime", "mktime"}
"""Functions of the module time that a clock set back has a part in."""

TIMES_OF_FILES = {"st_mtime", "st_mtime_ns", "st_ctime", "st_ctime_ns", "getmtime", "getctime"}


WORDS = re.compile(r"\b(import time|from time|datetime|st_[mc]time\w*|get[mc]time)\b")


def looks_at_the_clock(source: str) -> list[str]:
    """Return what a module names of the clock of the day."""
    found = []
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.ImportFrom) and node.module in ("time", "datetime"):
            names = {one.name for one in node.names}
            found += sorted(names & SET_BACK if node.module == "time" else names)
        elif isinstance(node, ast.Import):
            found += [one.name for one in node.names if one.name == "datetime"]
        elif isinstance(node, ast.Attribute) and node.attr in TIMES_OF_FILES:
            found.append(node.attr)
        elif isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
            found += [node.attr] * (node.value.id == "time" and node.attr in SET_BACK)
    return found


def test_who_looks_at_the_clock_is_found() -> None:
    source = "import time\nfrom datetime import date\ntime.time()\nos.stat('a').st_mtime\n"
    assert sorted(looks_at_the_clock(source)) == ["date", "st_mtime", "time"]
    assert looks_at_the_clock("import time\ntime.monotonic()\ntime.perf_counter()\n") == []


@pytest.mark.parametrize("package", ["psp3", "fuzzy2"])
def test_no_module_looks_at_the_clock(package: str) -> None:
    sources = {path: path.read_text("utf-8") for path in (ROOT / package).rglob("*.py")}
    # What has none of the words need not be understood.
    sources = {path: source for path, source in sources.items() if WORDS.search(source)}
    assert sources
    assert {path: found for path in sources if (found := looks_at_the_clock(sources[path]))} == {}


def test_a_study_goes_on_while_the_clock_goes_back(
    tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By a minute at each look, in whatever the packages use besides themselves."""
    looks = iter(range(2_000_000_000, 0, -60))
    monkeypatch.setattr(time, "time", lambda: float(next(looks)))
    study = Study(tmp_path / "study.sqlite", grid(**QUICK, seed=range(2)))
    assert study.run(2) == len(study.runs or ())
    assert len(study.rows()) == len(study.runs or ())
    assert psp3.load("delta").reference.shape == (3,)
