"""Representations of objects: their class and settings, on one line or as a table in notebooks.

Nothing is computed for a representation, and long arrays are shown by their shape.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from fuzzy2.errors import printable
from fuzzy2.support.markup import LEFT, Markup, element

MOST_NUMBERS = 6
"""Greatest size of an array whose numbers are shown; longer arrays are shown by their shape."""


class Described:
    """Base of objects that print as their class and settings."""

    __slots__ = ()

    def _facts(self) -> Mapping[str, Any]:
        """Return the settings by name: numbers, texts, arrays, and None for unused ones."""
        raise NotImplementedError

    def __repr__(self) -> str:
        said = ", ".join(f"{name}={in_short(fact)}" for name, fact in _given(self._facts()).items())
        return f"{type(self).__name__}({said})"

    def _repr_html_(self) -> Markup:
        """Return the HTML that a notebook shows."""
        rows = (
            element(
                "tr",
                element("th", name.replace("_", " "), style=LEFT),
                element("td", in_short(fact), style=LEFT),
            )
            for name, fact in _given(self._facts()).items()
        )
        return element("table", element("caption", type(self).__name__), *rows)


def in_short(fact: Any) -> str:
    """Return a setting in a few words, without characters that control a terminal.

    Parameters
    ----------
    fact : object
        A text is shown as it is, a number with four digits, a short array with its numbers and a
        long one with its shape. Other objects, such as a robot, are named by their ``title`` or
        class.
    """
    if isinstance(fact, str):
        return printable(fact)
    if isinstance(fact, bool | np.bool_):
        return "yes" if fact else "no"
    if isinstance(fact, int | np.integer):
        return str(fact)
    if isinstance(fact, float | np.floating):
        return f"{fact:.4g}"
    if isinstance(fact, np.ndarray):
        if fact.ndim != 1 or fact.size > MOST_NUMBERS:
            return f"array of {' × '.join(map(str, fact.shape))}"
        return f"[{', '.join(map(in_short, fact))}]"
    if isinstance(fact, tuple | list):
        shown = [in_short(one) for one in fact[:MOST_NUMBERS]]
        rest = len(fact) - len(shown)
        return ", ".join(shown) + (f" and {rest} more" if rest else "")
    title = getattr(fact, "title", None)
    return printable(title) if isinstance(title, str) else type(fact).__name__


def _given(facts: Mapping[str, Any]) -> dict[str, Any]:
    return {name: fact for name, fact in facts.items() if fact is not None}
