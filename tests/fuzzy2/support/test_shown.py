"""How things show themselves."""

from __future__ import annotations

import numpy as np

import fuzzy2
from fuzzy2.support.markup import LEFT
from fuzzy2.support.shown import Shown, captioned, small_picture, table


class Thing(Shown):
    """Something whose name could be taken for HTML."""

    def __repr__(self) -> str:
        return "<script>&"


def test_names_are_escaped() -> None:
    assert Thing()._repr_html_() == "<code>&lt;script&gt;&amp;</code>"
    assert "<script>" not in captioned("", repr(Thing()))
    x = np.array([0.0, 1.0])
    assert "<script>" not in small_picture((0.0, 1.0), [(x, x)], x, repr(Thing()))


def test_a_table_has_its_cells() -> None:
    cells = "".join(f'<td style="{LEFT}">{text}</td>' for text in "ab")
    assert table([["a", "b"]]) == f"<table><tr>{cells}</tr></table>"


def test_things_are_drawn_by_the_facade() -> None:
    (panel,) = fuzzy2.Gaussian(0.0, 1.0).view()
    assert len(panel.lines) == 1
    assert fuzzy2.Gaussian(0.0, 1.0).view(panel) == (panel,)
    assert len(panel.lines) == 2
