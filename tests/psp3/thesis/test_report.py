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


def test_the_report_opens_with_the_opening_table(outcome: Reproduction, tmp_path: Path) -> None:
    """Before the answer; the others come after it, and each of them once."""
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
    assert {link["href"] for link in page.all("a")} - {
        f"#table-{number}" for number in range(2)
    } == {"animation.html", "#figures"}


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
    assert [cell.get("class") for cell in page.all("td")[-3:]] == [None, "numbers", None]


def opening_table() -> Table:
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
    return Table("The opening", [f"heading {k} of two" for k in range(9)], [cells], opening=True)


def test_on_a_desktop_the_opening_table_shows_its_verdict_without_scrolling(
    outcome: Reproduction, tmp_path: Path, browser: webdriver.Chrome
) -> None:
    """1200 px wide. Intervals are not broken, and the words of the verdict are."""
    outcome.tables.append(opening_table())
    browser.set_window_size(1200, 900)
    browser.get(write_report(outcome, tmp_path / "report.html").as_uri())
    inner, outer, lines = browser.execute_script(
        "const box = document.querySelector('.wide'), range = document.createRange();"
        "return [box.scrollWidth, box.clientWidth, [...box.querySelectorAll('td')].map(cell => {"
        "range.selectNodeContents(cell); return range.getClientRects().length})]"
    )
    assert inner <= outer
    # A ratio and its interval below it.
    assert lines[4:6] == [2, 2]
    assert lines[-1] >= 2


def test_on_a_phone_the_page_does_not_scroll_sideways_and_wide_tables_do(
    outcome: Reproduction, tmp_path: Path, browser: webdriver.Chrome
) -> None:
    """390 by 844 is the screen of a common phone."""
    path = write_report(outcome, tmp_path / "report.html")
    browser.execute_cdp_cmd(
        "Emulation.setDeviceMetricsOverride",
        {"width": 390, "height": 844, "deviceScaleFactor": 2, "mobile": True},
    )
    try:
        browser.get(path.as_uri())
        page, screen = browser.execute_script(
            "return [document.documentElement.scrollWidth, window.innerWidth]"
        )
        assert page <= screen == 390
        boxes = browser.execute_script(
            "return [...document.querySelectorAll('.wide')].map(box => [box.scrollWidth, "
            "box.clientWidth, getComputedStyle(box).overflowX])"
        )
        assert boxes[0][0] > boxes[0][1]
        assert {overflow for _, _, overflow in boxes} == {"auto"}
        size = browser.execute_script(
            "return parseFloat(getComputedStyle(document.querySelector('.answer li')).fontSize)"
        )
        assert size >= 16.0
    finally:
        browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
