"""The page as a browser gets it: complete, of itself alone, and without the markup of others."""

from __future__ import annotations

import base64
import json
import os
import re
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from selenium import webdriver

from fuzzy2.errors import printable
from psp3.benchmark import page as page_of_board
from psp3.benchmark.board import Board
from psp3.benchmark.page import (
    COLUMNS,
    SHORT_COLUMNS,
    board_rows,
    short_rows,
    summary,
    write_numbers,
    write_page,
)
from psp3.study.statistics import Estimate
from tests.page_helpers import SIZES, set_size, sticking_out
from tests.psp3.benchmark.made import board_of

HOSTILE = "\"><script>alert(1)</script><img src=x onerror='alert(2)'>&amp;"
RNG = np.random.default_rng(2)
ERRORS = {
    "ctc": np.full((2, 4, 2), 1e-4),
    HOSTILE: 1e-3 * RNG.lognormal(0.0, 0.3, (2, 4, 2)),
    "near": 1e-3 * RNG.lognormal(0.0, 0.3, (2, 4, 2)),
    "lost": np.full((2, 4, 2), np.inf),
    "raises": np.full((2, 4, 2), 1e-3),
}


class Page(HTMLParser):
    """Tags with their attributes, and all texts."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.texts: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Keep a tag."""
        self.tags.append((tag, dict(attrs)))

    def handle_data(self, data: str) -> None:
        """Keep a text."""
        self.texts.append(data)


@pytest.fixture(scope="module")
def board() -> Board:
    return board_of(ERRORS, ("raises", f"ValueError: {HOSTILE}"))


@pytest.fixture(scope="module")
def page(board: Board, tmp_path_factory: pytest.TempPathFactory) -> Page:
    path = write_page(board, tmp_path_factory.mktemp("page") / "benchmark.html")
    return Page(path.read_text(encoding="utf-8"))


def test_names_and_messages_are_text_and_nothing_else(page: Page) -> None:
    assert HOSTILE in page.texts
    assert any(f"ValueError: {HOSTILE}" in text for text in page.texts)
    assert "script" not in {tag for tag, _ in page.tags}
    for tag, attributes in page.tags:
        assert not [name for name in attributes if name.startswith("on")]
        for name in ("src", "href"):
            value = attributes.get(name)
            assert value is None or value.startswith(("#", "data:image/svg+xml;base64,")), tag


def test_pictures_are_in_the_page_and_hold_no_markup_of_others(page: Page) -> None:
    images = [attributes for tag, attributes in page.tags if tag == "img"]
    assert len(images) == 2
    for image in images:
        assert image["alt"]
        content = base64.b64decode((image["src"] or "").partition(",")[2]).decode()
        assert re.match(r"<\?xml", content)
        assert "<script" not in content


def test_links_have_targets_and_every_robot_has_its_table(page: Page, board: Board) -> None:
    targets = {f"#{attributes['id']}" for _, attributes in page.tags if "id" in attributes}
    links = {attributes["href"] for tag, attributes in page.tags if tag == "a"}
    assert links == targets == {"#board", *(f"#robot-{robot}" for robot in board.robots)}


def test_the_board_has_a_row_for_every_entry_in_order_with_its_numbers(board: Board) -> None:
    rows = board_rows(board)
    assert [row[1] for row in rows] == [score.entry.name for score in board.scores]
    assert [row[0] for row in rows] == ["1", "2", "3", "4", "–"]
    assert {len(row) for row in rows} == {len(COLUMNS)}
    assert {len(row) for row in short_rows(board)} == {len(SHORT_COLUMNS)}
    first = rows[0]
    assert first[3:] == ["0.100", "1.00", "1.00", "0 %", "20.0", "0.500", "1.00"]
    lost = rows[3]
    assert (lost[1], lost[6], lost[9]) == ("lost", "100 %", "–")


@pytest.mark.parametrize(
    ("width", "text"), [(1e-16, "0.0907"), (1e-2, "0.0907 (0.0898 to 0.0916)")]
)
def test_what_is_the_same_with_every_seed_has_no_interval(width: float, text: str) -> None:
    error = 9.067e-5
    estimate = Estimate(error, error * (1.0 - width), error * (1.0 + width), 10)
    assert page_of_board._millimeters(estimate) == text


def test_sentences_say_who_is_first_who_is_not_worse_and_who_has_no_place(board: Board) -> None:
    said = summary(board)
    assert said[0] == "First of all is ctc, 0.100 mm."
    second, third = (score.entry.name for score in board.ranked[1:3])
    assert said[1].startswith("1 of 3 robots (psp3)"), "all know samples: the first is said once"
    tie = board.ratio(third, second)
    assert tie.low <= 1.0, "drawn from one law, they are not told apart"
    assert said[-1] == f"Without a place: raises, psp3: ValueError: {HOSTILE}"


def test_estimates_that_the_average_stood_in_for_are_said_and_only_these() -> None:
    lost = {"ctc": np.full((2, 4, 2), 1e-4), "lost": np.full((2, 4, 2), 1e-3)}
    board = board_of(lost, fallbacks={"lost": 0.25})
    (said,) = [sentence for sentence in summary(board) if "the average" in sentence]
    assert said.endswith("of the samples replaced: lost 25.0 %.")
    entries = {one["name"]: one["replaced"] for one in board.as_numbers()["entries"]}
    assert entries == {"ctc": 0.0, "lost": 0.25}


def test_without_such_estimates_nothing_is_said_of_them(board: Board) -> None:
    assert not [sentence for sentence in summary(board) if "the average" in sentence]


def test_numbers_are_written_as_strict_json(board: Board, tmp_path: Path) -> None:
    path = write_numbers(board, tmp_path / "benchmark.json")
    found = json.loads(path.read_text("utf-8"), parse_constant=pytest.fail)
    assert found == json.loads(json.dumps(board.as_numbers()))


def test_names_that_are_no_characters_are_written(tmp_path: Path) -> None:
    """As a file's name may be; the page shows the byte, and the numbers have it as it is."""
    name = os.fsdecode(b"not\xffutf8")
    board = board_of({"ctc": np.full((2, 2, 2), 1e-4), name: np.full((2, 2, 2), 1e-3)})
    text = write_page(board, tmp_path / "page.html").read_text("utf-8")
    assert printable(name) in text
    found = json.loads(write_numbers(board, tmp_path / "benchmark.json").read_text("utf-8"))
    assert [one["name"] for one in found["entries"]] == ["ctc", name]


def test_a_board_without_any_place_is_a_page_too(tmp_path: Path) -> None:
    board = board_of({"ctc": np.full((2, 2, 2), 1e-4)}, ("ctc", "OSError: gone"))
    page = Page(write_page(board, tmp_path / "page.html").read_text("utf-8"))
    assert "img" not in {tag for tag, _ in page.tags}
    assert any("OSError: gone" in text for text in page.texts)


@pytest.mark.parametrize("size", SIZES, ids=str)
def test_no_column_is_hidden_at_any_width(
    board: Board, tmp_path: Path, browser: webdriver.Chrome, size: tuple[int, int]
) -> None:
    """With the name of an entry that is one long word, as names of classes in modules are."""
    path = write_page(board, tmp_path / "benchmark.html")
    set_size(browser, *size)
    browser.get(path.as_uri())
    assert not sticking_out(browser)
    assert not browser.execute_script("return document.querySelectorAll('script').length")
