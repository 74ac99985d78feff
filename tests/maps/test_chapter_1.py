"""What the map of chapter 1 says in numbers beside its rows."""

from __future__ import annotations

import re

import fuzzy2
from tests.maps.named_tests import TESTS

TEXT = (TESTS.parent / "docs" / "chapter1.md").read_text(encoding="utf-8")


def test_errors_of_the_gaussian_meet_are_as_tabulated() -> None:
    """To the three digits that the table has."""
    table = re.findall(r"^\| ([\d., ]+) \| ([\d., ]+) \| (0\.\d{3}) \|$", TEXT, flags=re.MULTILINE)
    assert len(table) == 6
    for means, sigmas, error in table:
        found = fuzzy2.gaussian_meet_error(
            *([float(number) for number in numbers.split(", ")] for numbers in (means, sigmas))
        )
        assert abs(found - float(error)) < 5.5e-4
