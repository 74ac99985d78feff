"""The page on single precision says what was measured, of everything that can be exported."""

from __future__ import annotations

import importlib.util
import json
import re
from types import ModuleType
from typing import Any

import pytest

from tests.processes import ROOT

MADE_BY = ROOT / "docs" / "make_single_precision.py"


@pytest.fixture(scope="module")
def script() -> ModuleType:
    spec = importlib.util.spec_from_file_location("make_single_precision", MADE_BY)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def kept(script: ModuleType) -> Any:
    return json.loads(script.KEPT.read_text(encoding="utf-8"))


def test_the_page_is_that_of_the_file(script: ModuleType, kept: Any) -> None:
    assert script.PAGE.read_text(encoding="utf-8") == script.page(kept)


def test_everything_that_can_be_exported_was_measured(script: ModuleType, kept: Any) -> None:
    missing = [name for name in script.things() if name not in kept]
    assert not missing, f"python docs/make_single_precision.py {' '.join(map(repr, missing))}"
    assert kept.keys() == script.things().keys()


def test_the_largest_errors_are_those_of_the_page_on_export(kept: Any) -> None:
    """Rounded up to a digit, in one sentence."""
    page = (ROOT / "docs" / "how_to" / "export.md").read_text(encoding="utf-8")
    said = re.search(
        r"at most (\S+) in the median of the cases of a test, and (\S+) in the worst", page
    )
    assert said is not None
    rows = [row for thing in kept.values() for row in thing["functions"]]
    for number, column in zip(said.groups(), ("median", "largest"), strict=True):
        most = max(row[column] for row in rows)
        assert 0.5 * float(number) < most <= float(number), (column, most)


@pytest.mark.slow
def test_measured_anew_it_is_the_same(script: ModuleType, kept: Any) -> None:
    """Of a system: the same compiler, or another, rounds some numbers otherwise."""
    thing = script.things()["interval"]
    rows = zip(script.measured(thing, thing.make()), kept["interval"]["functions"], strict=True)
    for row, right in rows:
        for column in ("cases", "lost", "more"):
            assert row[column] == right[column]
        for column in ("median", "largest"):
            assert row[column] == pytest.approx(right[column], rel=0.5)
