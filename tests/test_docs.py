"""The pages in Markdown.

What they say is what happens, links lead somewhere, and pictures are described.

Every block marked ``python`` is run; blocks of one page share their names. Behind a ``print`` a
comment may say what is printed, and so may a ``text`` block right after the code; numbers are
compared to the digits given. Code of other libraries is marked ``py`` and not run.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import NamedTuple

import pytest

ROOT = Path(__file__).resolve().parents[1]
DOCS = sorted(page for page in (ROOT / "docs").rglob("*.md") if "_build" not in page.parts)
PAGES = [
    *(ROOT / name for name in ("README.md", "DESCRIPTION.md", "CHANGELOG.md")),
    *(ROOT / folder / "README.md" for folder in ("urdf", "examples")),
    *DOCS,
]
# The recipe for plain Pinocchio in urdf/README.md is run by test_urdf_visuals.py, beside its files.
WITH_CODE = [
    page
    for page in (ROOT / "README.md", ROOT / "DESCRIPTION.md", *DOCS)
    if "```python\n" in page.read_text(encoding="utf-8")
]

NUMBER = re.compile(r"(?<![\w.])[-+]?(?:\d+\.?\d*(?:e[-+]?\d+)?|nan|inf)(?![\w])", re.IGNORECASE)
DECIMAL = re.compile(r"(?<![\w.])[-+]?\d+\.\d+(?:e[-+]?\d+)?")
FENCE = re.compile(r"^(`{3,})([^\n]*)\n(.*?)^\1`*[ \t]*$", flags=re.DOTALL | re.MULTILINE)
PRINT = re.compile(r" *print\(.*\)  # (.*)")


def name(page: Path) -> str:
    return str(page.relative_to(ROOT))


class Block(NamedTuple):
    """A block of code: its language, its text, its line.

    And what lies between it and the block before.
    """

    language: str
    text: str
    line: int
    before: str


def blocks(page: Path) -> list[Block]:
    text, found, end = page.read_text(encoding="utf-8"), [], 0
    for fence in FENCE.finditer(text):
        found.append(
            Block(
                fence[2].strip(),
                fence[3],
                text.count("\n", 0, fence.start(3)),
                text[end : fence.start()],
            )
        )
        end = fence.end()
    return found


def without_code(page: Path) -> str:
    return re.sub(r"`[^`\n]+`", "", FENCE.sub("", page.read_text(encoding="utf-8")))


def assert_same(promised: str, printed: str, where: str) -> None:
    """Words are the same.

    Numbers differ by less than one unit of the last digit that is promised.
    """
    assert NUMBER.sub("#", promised).split() == NUMBER.sub("#", printed).split(), (
        f"{where}\n{printed}"
    )
    for text, value in zip(NUMBER.findall(promised), NUMBER.findall(printed), strict=True):
        digits, _, exponent = text.lower().partition("e")
        unit = 10.0 ** (int(exponent or 0) - len(digits.partition(".")[2]))
        assert float(value) == pytest.approx(
            float(text), rel=0.0, abs=1.0001 * unit, nan_ok=True
        ), f"{where}\n{printed}"


@pytest.mark.slow
@pytest.mark.parametrize("page", WITH_CODE, ids=name)
def test_code_prints_what_the_page_says(
    page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Pages promise numbers only to the digits that every machine gives.

    Files that the code writes go to a directory of its own.
    """
    monkeypatch.chdir(tmp_path)
    printed: dict[int, str] = {}

    def record(*values: object) -> None:
        line = sys._getframe(1).f_lineno
        printed[line] = printed.get(line, "") + " ".join(map(str, values)) + "\n"

    names: dict[str, object] = {"__name__": "__main__", "print": record}
    has_output = False
    for block in blocks(page):
        where = f"{name(page)}, line {block.line}"
        if block.language == "python":
            printed.clear()
            exec(compile("\n" * block.line + block.text, str(page), "exec"), names)
            for number, line in enumerate(block.text.splitlines(), start=block.line + 1):
                if (promise := PRINT.match(line)) and (promised := DECIMAL.findall(promise[1])):
                    assert_same(
                        " ".join(promised),
                        " ".join(DECIMAL.findall(printed[number])),
                        f"{name(page)}, line {number}",
                    )
            has_output = True
        elif block.language == "text" and has_output and not block.before.strip():
            assert_same(block.text, "".join(printed.values()), where)
        else:
            has_output = False


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_every_block_says_what_it_is(page: Path) -> None:
    """Code of ours is ``python``, and run.

    Code of others is ``py``, and says in its first line whose it is.
    """
    for block in blocks(page):
        language = block.language.strip("{}").split()[0] if block.language else ""
        assert language, f"{name(page)}, line {block.line}: a block without a language"
        if language == "py":
            assert re.match(r"# \w", block.text), (
                f"{name(page)}, line {block.line}: whose code is it?"
            )


def anchors(page: Path) -> set[str]:
    """Return the anchors of a page's headings, as GitHub and MyST make them."""
    headings = re.findall(
        r"^#+ +(.*)$", FENCE.sub("", page.read_text(encoding="utf-8")), flags=re.MULTILINE
    )
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_links_lead_somewhere(page: Path) -> None:
    """Files are in the repository, and headings on the page.

    What lies elsewhere must be an https address; no network is used.
    """
    for link in re.findall(r"\]\(<?([^)\s>]+)>?\)", without_code(page)):
        if link.startswith("https://"):
            continue
        assert ":" not in link, f"{name(page)}: {link}"
        path, _, anchor = link.partition("#")
        target = (page.parent / path).resolve() if path else page
        assert target.exists(), f"{name(page)}: {link}"
        assert target.is_relative_to(ROOT), f"{name(page)}: {link}"
        if anchor and target.suffix == ".md":
            assert anchor in anchors(target), f"{name(page)}: {link}"


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_pictures_are_there_and_described(page: Path) -> None:
    """Of pictures in Markdown and in HTML. A description is a sentence or so, not a file name."""
    text = without_code(page)
    pictures = re.findall(r"!\[([^\]]*)\]\(([^)\s]+)\)", text)
    for tag in re.findall(r"<img\b[^>]*>", text, flags=re.DOTALL):
        attributes = dict(re.findall(r'(\w+)="([^"]*)"', tag))
        pictures.append((attributes.get("alt", ""), attributes["src"]))
    for description, path in pictures:
        assert (page.parent / path).is_file(), f"{name(page)}: {path}"
        assert len(description) >= 40, (
            f"{name(page)}: {path} needs a description, not {description!r}"
        )
        assert "." not in description.rstrip(".")[-5:], (
            f"{name(page)}: {description!r} is a file name"
        )


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_equations_can_be_read_on_a_phone(page: Path) -> None:
    """Longest line of an equation in characters of its source.

    A wider one should be broken or said in words.
    """
    for equation in re.findall(r"\$\$(.*?)\$\$", without_code(page), flags=re.DOTALL):
        assert max(len(line) for line in equation.split(r"\\")) <= 150, f"{name(page)}: {equation}"
