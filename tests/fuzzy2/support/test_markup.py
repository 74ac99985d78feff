"""HTML that is put together: texts stay texts, wherever they stand."""

from __future__ import annotations

import ast
import json
import re
from html.parser import HTMLParser
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fuzzy2.errors import printable
from fuzzy2.support.markup import Markup, data, element, escaped, filled, joined
from tests.hostile.names import HOSTILE

ROOT = Path(__file__).resolve().parents[3]
SOURCES = [path for root in ("fuzzy2", "psp3") for path in sorted((ROOT / root).rglob("*.py"))]
TEXT = st.text(st.characters(codec="utf-8")) | st.sampled_from(HOSTILE)


TAG = re.compile(
    "</[a-z]|<(a|b|code|div|figure|h[1-6]|head|html|iframe|img|li|meta|ol|p|path|script|span|style"
    "|svg|table|tbody|td|th|thead|title|tr|ul)[ >]",
    flags=re.IGNORECASE,
)
"""Elements of pages; files of robots and fuzzy systems have others, which messages name."""


class Read(HTMLParser):
    """What a browser would find: tags, attributes and texts."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.found: list[tuple[str, str, str]] = []
        self.text = ""
        self.feed(text)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Keep a tag."""
        self.found += [(tag, name, value or "") for name, value in attrs] or [(tag, "", "")]

    def handle_data(self, data: str) -> None:
        """Keep a text."""
        self.text += data


@given(text=TEXT, value=TEXT)
def test_a_text_is_one_text_and_a_value_one_value(text: str, value: str) -> None:
    """The standard library's parser is the other opinion."""
    found = Read(element("p", text, class_=value))
    assert found.found == [("p", "class", printable(value))]
    assert found.text == printable(text)


@given(text=TEXT)
def test_what_is_markup_is_not_escaped_again_but_as_a_value(text: str) -> None:
    inner = element("b", text)
    assert escaped(inner) is inner
    assert joined([inner, inner]) == inner + inner
    assert Read(element("p", inner, title=inner)).found[0] == ("p", "title", inner)


def test_what_is_put_together_by_hand_is_no_markup() -> None:
    """So it is escaped: forgetting the function is ugly, not dangerous."""
    assert type(element("b", "x") + "<i>") is str
    assert element("p", element("b", "x") + "<i>") == "<p>&lt;b&gt;x&lt;/b&gt;&lt;i&gt;</p>"


def test_elements_that_hold_nothing_have_no_end() -> None:
    assert element("img", alt="a", aria_label="b") == '<img alt="a" aria-label="b">'


@given(value=st.recursive(TEXT, lambda inner: st.lists(inner) | st.dictionaries(TEXT, inner)))
def test_data_ends_no_script_and_is_the_same_data(value: object) -> None:
    text = data(value)
    assert not set("<>&\u2028\u2029") & set(text)
    assert json.loads(text) == value


def test_marks_are_filled_at_once() -> None:
    """A name that looks like a mark is a name."""
    text = filled("<p>/*NAME*/</p>/*CODE*/", {"NAME": "/*CODE*/<", "CODE": Markup("<b>/*NAME*/")})
    assert text == "<p>/*CODE*/&lt;</p><b>/*NAME*/"
    with pytest.raises(KeyError):
        filled("/*OTHER*/", {})


def made_by_hand(source: str) -> list[str]:
    """Return the texts of a module that begin or end an element of HTML, docstrings aside."""
    tree = ast.parse(source)
    documented = {
        id(node.body[0].value)
        for node in ast.walk(tree)
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef)
        and node.body
        and isinstance(node.body[0], ast.Expr)
    }
    texts = [
        node.value
        for node in ast.walk(tree)
        if isinstance(node, ast.Constant)
        and isinstance(node.value, str)
        and id(node) not in documented
    ]
    return [text for text in texts if TAG.search(text)]


@pytest.mark.parametrize("path", SOURCES, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_no_other_module_writes_html(path: Path) -> None:
    source = path.read_text(encoding="utf-8")
    if path.name == "markup.py":
        assert "html.escape" in source
        return
    assert not re.search(r"^(import|from) html\b", source, flags=re.MULTILINE)
    assert made_by_hand(source) == []


def test_html_by_hand_would_be_found() -> None:
    assert made_by_hand('x = f"<td class=x>{name}"') == ["<td class=x>"]
    assert made_by_hand('x = "text</td>"') == ["text</td>"]
    assert made_by_hand('"""<td>."""') == []
