"""HTML that is safe by the way it is made: texts are escaped unless they are markup already.

Every page and every picture in a notebook is put together here, for names of robots, links, terms
and rules come from files of others. :class:`Markup` is the only text that is taken as it is, and
what makes it escapes what it is given.
"""

from __future__ import annotations

import html
import json
import re
from collections.abc import Iterable, Mapping
from typing import Any

from fuzzy2.errors import printable

VOID = frozenset({"img", "meta"})
"""Elements that hold nothing and have no end tag, of those that are used."""

_MARK = re.compile(r"/\*([A-Z]+)\*/")

_LEFT_IN_DATA = str.maketrans(
    {mark: f"\\u{ord(mark):04x}" for mark in ("<", ">", "&", "\u2028", "\u2029")}
)
"""JSON has these in texts only, where their numbers mean the same."""


class Markup(str):
    """Finished HTML, of which the constructor takes the program's own texts alone."""

    __slots__ = ()


def escaped(text: str) -> Markup:
    """Return a text as markup that shows it; what is markup already stays.

    What a reader cannot see is written as its number, see :func:`fuzzy2.errors.printable`.
    """
    return text if isinstance(text, Markup) else Markup(html.escape(printable(text)))


def joined(parts: Iterable[str]) -> Markup:
    """Return texts and markup one after another."""
    return Markup("".join(map(escaped, parts)))


LEFT = "text-align:left"
"""Style of a table's cells that hold words: JupyterLab sets what has none flush right."""


def element(tag: str, *content: str, **attributes: str) -> Markup:
    """Return an element of HTML or SVG.

    Parameters
    ----------
    tag : str
        What it is, such as ``p``.
    content : str
        Texts, which are escaped, and markup.
    attributes : str
        Values by name, with ``_`` for ``-`` and a ``_`` behind Python's own words: ``class_``.
        They are texts, whatever they hold.
    """
    said = "".join(
        f' {name.rstrip("_").replace("_", "-")}="{escaped(str(value))}"'
        for name, value in attributes.items()
    )
    return Markup(f"<{tag}{said}>" + ("" if tag in VOID else f"{joined(content)}</{tag}>"))


def data(value: Any) -> Markup:
    """Return plain data as JSON that ends no script, for ``<script type="application/json">``."""
    return data_from_json(json.dumps(value, separators=(",", ":")))


def data_from_json(text: str) -> Markup:
    """Return JSON as :func:`data` does."""
    return Markup(text.translate(_LEFT_IN_DATA))


def filled(template: str, parts: Mapping[str, str]) -> Markup:
    """Return a template with its marks, such as ``/*NAME*/``, replaced by texts and markup.

    All at once: a mark within what is filled in is text like any other.
    """
    return Markup(_MARK.sub(lambda mark: escaped(parts[mark[1]]), template))
