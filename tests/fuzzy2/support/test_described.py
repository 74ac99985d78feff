"""How things print."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from fuzzy2.support.described import Described, in_short
from fuzzy2.support.markup import LEFT


class Thing(Described):
    """Something that a file of others may have named."""

    title = "<script>\x1b[31m"

    def _facts(self) -> dict[str, Any]:
        return {"whose": self, "largest_gain": 10.0, "nothing": None}


def test_a_line_and_a_table_have_the_same_facts_and_obey_no_name() -> None:
    assert repr(Thing()) == r"Thing(whose=<script>\x1b[31m, largest_gain=10)"
    html = Thing()._repr_html_()
    assert ">&lt;script&gt;\\x1b[31m</td>" in html
    assert f'<th style="{LEFT}">largest gain</th><td style="{LEFT}">10</td>' in html
    assert "nothing" not in html


@pytest.mark.parametrize(
    ("fact", "text"),
    [
        (0.123456, "0.1235"),
        (True, "yes"),
        (12345, "12345"),
        (np.array([1.0, 2.5]), "[1, 2.5]"),
        (np.zeros(7), "array of 7"),
        (np.zeros((2, 3)), "array of 2 × 3"),
        (tuple("abcdefgh"), "a, b, c, d, e, f and 2 more"),
        (object(), "object"),
    ],
)
def test_facts_are_short(fact: Any, text: str) -> None:
    assert in_short(fact) == text
