"""HTML that is safe by construction: texts are escaped unless they are markup.

Every page and every picture in a notebook is built with these functions, because names of robots,
links, terms and rules come from foreign files. Only :class:`Markup` is inserted as it is, and all
functions that make it escape their arguments.
"""

from __future__ import annotations

import html
import json
import re
from collections.abc import Iterable, Mapping
from typing import Any

from fuzzy2.errors import printable

VOID = frozenset({"img", "meta"})
"""The used elements that have no content and no end tag."""

_MARK = re.compile(r"/\*([A-Z]+)\*/")

_LEFT_IN_DATA = str.maketrans(
    {mark: f"\\u{ord(mark):04x}" for mark in ("<", ">", "&", "\u2028", "\u2029")}
)
"""Characters that JSON only has in strings, where they can be replaced with escapes."""


class Markup(str):
    """Finished HTML; the constructor must only be called with texts of the program itself."""

    __slots__ = ()


def escaped(text: str) -> Markup:
    """Return a text as markup that shows it; markup is returned unchanged.

    Invisible characters are written as their numbers, see :func:`fuzzy2.errors.printable`.
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
        Name of the element, such as ``p``.
    content : str
        Texts, which are escaped, or markup.
    attributes : str
        Values by name, with ``_`` for ``-`` and a trailing ``_`` for keywords of Python, as in
        ``class_``. They are always escaped.
    """
    said = "".join(
        f' {name.rstrip("_").replace("_", "-")}="{escaped(str(value))}"'
        for name, value in attributes.items()
    )
    return Markup(f"<{tag}{said}>" + ("" if tag in VOID else f"{joined(content)}</{tag}>"))


def data(value: Any) -> Markup:
    """Return data as JSON that cannot end its ``<script type="application/json">``."""
    return data_from_json(json.dumps(value, separators=(",", ":")))


def data_from_json(text: str) -> Markup:
    """Return JSON text in the form that :func:`data` gives it."""
    return Markup(text.translate(_LEFT_IN_DATA))


def filled(template: str, parts: Mapping[str, str]) -> Markup:
    """Return a template whose placeholders, such as ``/*NAME*/``, are replaced by texts and markup.

    All placeholders are replaced at once, so placeholders in the inserted texts are ordinary text.
    """
    return Markup(_MARK.sub(lambda mark: escaped(parts[mark[1]]), template))
