"""HTML with small pictures, which notebooks show for sets, systems and learners."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from fuzzy2.sets.pictures import picture_of_sets
from fuzzy2.support.markup import Markup, element, joined
from fuzzy2.support.shown import COLORS, table
from fuzzy2.systems.explainable import Explainable
from fuzzy2.systems.words import rules_in_words

MOST_RULES = 20
"""Greatest number of rules that are shown."""


def html_of(system: Explainable) -> Markup:
    """Return the HTML of a system: its terms, and its first rules in words."""
    rows = [
        [name, _pictured(terms, name), ", ".join(words)]
        for name, terms, words in zip(
            system.input_names, system.inputs, system.term_names, strict=True
        )
    ]
    if system.consequent_sets is not None:
        for j, name in enumerate(system.output_names):
            said = [row[j] for row in system.consequent_sets if row[j] is not None]
            distinct = list(dict.fromkeys(map(id, said)))
            sets = [next(item for item in said if id(item) == one) for one in distinct]
            rows.append([name, _pictured(sets, name), "output"])
    rules = rules_in_words(system, MOST_RULES)
    more = len(system.rules) - len(rules)
    rest = element("p", f"and {more} more rules") if more else ""
    return joined([titled(system), table(rows), listed(rules), rest])


def titled(thing: Any) -> Markup:
    """Return the title above the HTML of an object."""
    return element("p", element("code", repr(thing)))


def listed(rules: Sequence[str]) -> Markup:
    """Return rules in words as a numbered list."""
    return element("ol", *(element("li", rule) for rule in rules))


def _pictured(sets: Sequence[Any], name: str) -> str:
    return picture_of_sets(sets, f"terms of {name}") if sets else ""


def bars(shares: Sequence[float]) -> list[Markup]:
    """Return shares as bars of HTML."""
    widths = (100.0 * float(np.clip(share, 0.0, 1.0)) for share in shares)
    style = f"background:{COLORS[0]};height:0.8em;width"
    return [element("div", style=f"{style}:{width:.0f}px") for width in widths]
