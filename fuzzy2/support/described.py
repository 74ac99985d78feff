"""How objects print: their class and their settings, in a line or as a table in notebooks.

Nothing is computed for it, and no array is printed that is longer than a line.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from fuzzy2.errors import printable
from fuzzy2.support.markup import LEFT, Markup, element

MOST_NUMBERS = 6
"""Numbers of an array that are shown; of longer ones the shape is."""


class Described:
    """What prints as its class and its facts."""

    __slots__ = ()

    def _facts(self) -> Mapping[str, Any]:
        """Return what decides this, by name: numbers, texts, arrays, and None for what is not."""
        raise NotImplementedError

    def __repr__(self) -> str:
        said = ", ".join(f"{name}={in_short(fact)}" for name, fact in _given(self._facts()).items())
        return f"{type(self).__name__}({said})"

    def _repr_html_(self) -> Markup:
        """Return what a notebook shows."""
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
    """Return a fact in a few words, of which a terminal obeys nothing.

    Parameters
    ----------
    fact : object
        A text is taken as it is, a number has four digits, a short array its numbers and a long one
        its shape. What else there is, such as a robot, is named by its ``title`` or its class.
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
