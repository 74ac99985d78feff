"""What sets, systems and learners show of themselves in notebooks: HTML with small pictures."""

from __future__ import annotations

import html
from collections.abc import Sequence
from typing import Any

import numpy as np

from fuzzy2.sets.pictures import picture_of_sets
from fuzzy2.support.shown import COLORS, table
from fuzzy2.systems.explainable import Explainable
from fuzzy2.systems.words import rules_in_words

MOST_RULES = 20
"""Rules that are shown."""


def html_of(system: Explainable) -> str:
    """Return what a notebook shows of a system: its terms, and its first rules in words."""
    rows = [
        [html.escape(name), _pictured(terms, name), html.escape(", ".join(words))]
        for name, terms, words in zip(
            system.input_names, system.inputs, system.term_names, strict=True
        )
    ]
    if system.consequent_sets is not None:
        for j, name in enumerate(system.output_names):
            said = [row[j] for row in system.consequent_sets if row[j] is not None]
            distinct = list(dict.fromkeys(map(id, said)))
            sets = [next(item for item in said if id(item) == one) for one in distinct]
            rows.append([html.escape(name), _pictured(sets, name), "output"])
    rules = rules_in_words(system, MOST_RULES)
    more = len(system.rules) - len(rules)
    listed = "".join(f"<li>{html.escape(rule)}</li>" for rule in rules)
    rest = f"<p>and {more} more rules</p>" if more else ""
    return f"<p><code>{html.escape(repr(system))}</code></p>{table(rows)}<ol>{listed}</ol>{rest}"


def _pictured(sets: Sequence[Any], name: str) -> str:
    return picture_of_sets(sets, f"terms of {name}") if sets else ""


def bars(shares: Sequence[float]) -> list[str]:
    """Return shares as bars of HTML."""
    widths = (100.0 * float(np.clip(share, 0.0, 1.0)) for share in shares)
    style = f"background:{COLORS[0]};height:0.8em;width"
    return [f'<div style="{style}:{width:.0f}px"></div>' for width in widths]
