"""The report as a browser and a reader get it."""

from __future__ import annotations

import base64
import re
from html.parser import HTMLParser
from pathlib import Path

import pytest
from selenium import webdriver

from psp3.thesis.findings import Drawing, Reproduction, Table
from psp3.thesis.report import write_report
from tests.page_helpers import DESKTOP, PHONE, SIZES, set_size, sticking_out

SVG = (
    "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 900 300'><path d='M0 0 L900 300' "
    "stroke='black'/></svg>"
)


class Page(HTMLParser):
    """Tags with their attributes, and the text of each."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.order: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Keep a tag."""
        self.tags.append((tag, dict(attrs)))

    def handle_data(self, data: str) -> None:
        """Keep a text."""
        self.order.append(data)

    def all(self, tag: str) -> list[dict[str, str | None]]:
        """Return the attributes of every tag of a name."""
        return [attributes for name, attributes in self.tags if name == tag]


def drawing(directory: Path, name: str) -> Drawing:
    path = directory / f"{name}.svg"
    path.write_text(SVG, encoding="utf-8")
    return Drawing(path, f"Caption of {name} <&'\">", f"What {name} shows.")


@pytest.fixture
def outcome(tmp_path: Path) -> Reproduction:
    wide = Table(
        "A wide table",
        [f"column {number} with a heading" for number in range(12)],
        [["1.234 (1.000 to 2.000)"] * 12] * 3,
        "A note & more.",
        figures=("figure_64",),
        detail=True,
    )
    found = Reproduction(
        tables=[wide, Table("A table with <tags> in it", ["a"], [["<b>"]])],
        answer=["The answer, in plain words.", "Another sentence."],
    )
    found.drawings += [drawing(tmp_path, name) for name in ("figure_49", "figure_64")]
    found.numbers["versions"] = {"python": "3.11", "psp3": "0.1"}
    return found


def test_the_report_opens_with_a_sentence_two_pictures_and_the_verdicts(
    outcome: Reproduction, tmp_path: Path
) -> None:
    """All else is folded, and only there: each title is seen, and each table is there once."""
    outcome.sentence = "One plain sentence."
    outcome.drawings += [drawing(tmp_path, name) for name in ("result", "machine")]
    outcome.tables.append(Table("The opening", ["a"], [["cell of it"]], opening=True))
    page = Page(write_report(outcome, tmp_path / "opening.html").read_text("utf-8"))
    opened = [tag for tag, _ in page.tags].index("details")
    assert [attributes["alt"] for tag, attributes in page.tags[:opened] if tag == "img"] == [
        f"Caption of {name} <&'\"> What {name} shows." for name in ("machine", "result")
    ]
    assert sum(tag == "table" for tag, _ in page.tags[:opened]) == 1
    assert len(page.all("table")) == 3
    assert len(page.all("details")) == len(page.all("summary")) == 2 + len(outcome.tables) - 1
    places = [page.order.index(text) for text in ("One plain sentence.", "cell of it")]
    assert places == sorted(places)
    assert not any("open" in attributes for attributes in page.all("details"))


def test_the_answer_comes_before_the_tables_that_are_folded(
    outcome: Reproduction, tmp_path: Path
) -> None:
    outcome.tables.append(Table("The opening", ["a"], [["cell of it"]], opening=True))
    order = Page(write_report(outcome, tmp_path / "opening.html").read_text("utf-8")).order
    places = [order.index(text) for text in ("cell of it", "The answer, in plain words.", "<b>")]
    assert places == sorted(places)
    assert [order.count(text) for text in ("cell of it", "<b>")] == [1, 1]


@pytest.fixture
def page(outcome: Reproduction, tmp_path: Path) -> Page:
    return Page(write_report(outcome, tmp_path / "report.html").read_text(encoding="utf-8"))


def test_nothing_comes_from_elsewhere(page: Page) -> None:
    for _, attributes in page.tags:
        for name in ("src", "href", "srcset", "data", "action"):
            target = attributes.get(name)
            assert target is None or target.startswith(("data:", "#"))
    assert not page.all("script")
    assert not page.all("link")
    assert not re.search(r"@import|url\(", " ".join(page.order))


def test_animation_is_linked_if_it_was_written(outcome: Reproduction, tmp_path: Path) -> None:
    outcome.files.append(tmp_path / "animation.html")
    page = Page(write_report(outcome, tmp_path / "report.html").read_text(encoding="utf-8"))
    assert {link["href"] for link in page.all("a")} == {"animation.html"}


def test_answer_comes_first(page: Page) -> None:
    text = [piece for piece in page.order if piece.strip()]
    assert text.index("The answer, in plain words.") < text.index("A wide table")
    headings = [tag for tag, _ in page.tags]
    assert headings.index("li") < headings.index("table")


def test_every_figure_is_in_the_page_with_words_for_those_who_cannot_see_it(page: Page) -> None:
    images = page.all("img")
    assert [image["alt"] for image in images] == [
        f"Caption of {name} <&'\"> What {name} shows." for name in ("figure_64", "figure_49")
    ]  # that of the table stands with it
    for image in images:
        source = image["src"]
        assert source is not None
        kind, content = source.split(",", 1)
        assert kind == "data:image/svg+xml;base64"
        assert base64.b64decode(content).decode() == SVG


def test_text_is_text_and_links_have_targets(page: Page) -> None:
    assert "<b>" in page.order
    assert not page.all("b")
    targets = {f"#{attributes['id']}" for _, attributes in page.tags if "id" in attributes}
    assert {link["href"] for link in page.all("a")} <= targets


def test_cells_wrap_between_words_and_keep_intervals_and_rows_of_numbers(
    outcome: Reproduction, tmp_path: Path
) -> None:
    cells = ["0.473 (0.296 to 0.755), 30 % diverged", " 1.0000  -0.5000", "5 of 30, no difference"]
    outcome.tables.append(Table("Cells", ["a", "b", "c"], [cells]))
    page = Page(write_report(outcome, tmp_path / "cells.html").read_text(encoding="utf-8"))
    unbroken = "0.473 (0.296~to~0.755), 30~% diverged".replace("~", "\N{NO-BREAK SPACE}")
    place = page.order.index(unbroken)
    assert page.order[place + 1] == cells[1]
    assert page.order[place + 2] == cells[2].replace("5 of 30", "5~of~30").replace(
        "~", "\N{NO-BREAK SPACE}"
    )
    shown = page.all("td")[-3:]
    assert [cell.get("class") for cell in shown] == [None, "numbers", None]
    assert [cell["data-heading"] for cell in shown] == ["a", "b", "c"]


def long_table() -> Table:
    """Return cells as long as those of the comparison under every definition of the noise."""
    cells = [
        "mean square, on the recorded inputs",
        "10",
        "29.2, 30 % diverged",
        "5.6517",
        "0.473 (0.296 to 0.755)",
        "0.440 (0.290 to 0.668)",
        "10 of 10",
        "1.000 at 0.02",
        "no difference shown; no difference shown",
    ]
    return Table("Long", [f"heading {k} of two" for k in range(9)], [cells], opening=True)


def test_on_a_desktop_intervals_are_not_broken_and_words_are(
    outcome: Reproduction, tmp_path: Path, browser: webdriver.Chrome
) -> None:
    outcome.tables = [long_table()]
    set_size(browser, *DESKTOP)
    browser.get(write_report(outcome, tmp_path / "report.html").as_uri())
    lines = browser.execute_script(
        "const range = document.createRange();"
        "return [...document.querySelectorAll('td')].map(cell => {"
        "range.selectNodeContents(cell); return range.getClientRects().length})"
    )
    # A ratio and its interval below it.
    assert max(lines[4:6]) <= 2
    assert lines[-1] >= 2


@pytest.mark.parametrize("size", SIZES, ids=str)
def test_no_column_is_hidden_at_any_width(
    outcome: Reproduction, tmp_path: Path, browser: webdriver.Chrome, size: tuple[int, int]
) -> None:
    """Twelve columns, rows of numbers that are not broken, and one word that is too long."""
    numbers = "  ".join(["-10.0161"] * 3)
    outcome.sentence = "One plain sentence."
    outcome.drawings += [drawing(tmp_path, name) for name in ("result", "machine")]
    outcome.tables += [
        long_table(),
        Table("Numbers", ["", "printed", "computed", "verdict"], [["C", numbers, numbers, "so"]]),
        Table("A word", ["a", "b"], [["x" * 80, "y"]]),
    ]
    set_size(browser, *size)
    browser.get(write_report(outcome, tmp_path / "report.html").as_uri())
    assert not sticking_out(browser)


def test_text_on_a_phone_is_large_enough(
    outcome: Reproduction, tmp_path: Path, browser: webdriver.Chrome
) -> None:
    set_size(browser, *PHONE)
    browser.get(write_report(outcome, tmp_path / "report.html").as_uri())
    size = browser.execute_script(
        "return parseFloat(getComputedStyle(document.querySelector('.answer li')).fontSize)"
    )
    assert size >= 16.0
