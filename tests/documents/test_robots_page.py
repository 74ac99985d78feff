"""The page of robots: it lists what is shipped, and quotes messages that are really raised."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

import psp3
from psp3.description.parts import ROBOTS
from psp3.robots.examination import examine

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "robots.md").read_text(encoding="utf-8")


def rows(heading: str) -> list[list[str]]:
    """Return the cells of the first table below a heading."""
    lines = PAGE.split(heading, 1)[1].splitlines()
    start = next(k for k, line in enumerate(lines) if line.startswith("|---"))
    table = []
    for line in lines[start + 1 :]:
        if not line.startswith("|"):
            break
        table.append([cell.strip() for cell in line.strip("|").split("|")])
    return table


def words_of_the_package() -> str:
    """Return every text of the sources in one line, with a mark where a value stands."""
    texts = []
    for path in sorted((ROOT / "psp3").rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.JoinedStr):
                pieces = (one for one in node.values if isinstance(one, ast.Constant))
                texts.append("".join(str(one.value) for one in pieces))
            elif isinstance(node, ast.Constant) and isinstance(node.value, str):
                texts.append(node.value)
    return re.sub(r"\s+", " ", "\n".join(texts))


def test_gallery_lists_every_robot_in_order() -> None:
    assert [row[0].strip("`") for row in rows("## Gallery")] == list(ROBOTS)


@pytest.mark.parametrize("row", rows("## Gallery"), ids=lambda row: row[0])
def test_gallery_counts_freedoms_motors_and_loops(row: list[str]) -> None:
    found = examine(psp3.load(row[0].strip("`")))
    freedoms, motors, loops = (
        sum(map(int, re.findall(r"\d+", cell.replace("a coupling", "1")))) for cell in row[2:5]
    )
    degrees = int(re.findall(r"\d+", found.mobility)[0])
    assert (freedoms, motors, loops) == (degrees, len(found.motors), len(found.loops))


@pytest.mark.parametrize("row", rows('## "My robot is refused"'), ids=lambda row: row[0])
def test_messages_are_quoted_as_they_are(row: list[str]) -> None:
    """Each part of a quotation between its dots is in a text of the package."""
    words = words_of_the_package()
    for quoted in re.findall(r"`([^`]+)`", row[0]):
        for part in filter(None, (part.strip(" ;,") for part in quoted.split("…"))):
            assert part in words, part
