"""README.md: short, with contents that are whole, and badges that are true."""

from __future__ import annotations

import re
import runpy

import pytest

from tests.processes import ROOT

TEXT = (ROOT / "README.md").read_text(encoding="utf-8")
PICTURES = ROOT / "docs" / "pictures"
MADE = runpy.run_path(str(PICTURES / "make_badges.py"))


def test_it_is_short() -> None:
    assert len(TEXT.splitlines()) <= 120


def test_contents_name_every_section_in_order() -> None:
    (contents,) = re.findall(r"^\*\*Contents:\*\* (.*)$", TEXT, flags=re.MULTILINE)
    links = re.findall(r"\[([^\]]+)\]\(#([^)]+)\)", contents)
    sections = re.findall(r"^## (.*)$", TEXT, flags=re.MULTILINE)
    assert [name for name, _ in links] == sections
    assert [anchor for _, anchor in links] == [
        section.lower().replace(" ", "-") for section in sections
    ]


@pytest.mark.parametrize(("name", "value"), MADE["badges"]().items())
def test_badges_say_what_the_project_file_says(name: str, value: str) -> None:
    drawn = (PICTURES / f"badge_{name}.svg").read_text(encoding="utf-8")
    assert drawn == MADE["drawn"](name, value)
    assert f">{value}</text>" in drawn


def test_every_badge_is_drawn_by_us() -> None:
    shown = set(re.findall(r"docs/pictures/badge_(\w+)\.svg", TEXT))
    assert shown == set(MADE["badges"]())
