"""The map of chapter 1.

Every equation is on it, and every function, test and number that it names is there.
"""

from __future__ import annotations

import pkgutil
import re

import pytest

import fuzzy2
from tests.maps.named_tests import TESTS, functions_of

MAP = TESTS.parent / "docs" / "chapter1.md"
TEXT = MAP.read_text(encoding="utf-8")

# Equations in parts, by the labels of the thesis's text.
PARTS = {8: "ab", 18: "ab", 20: "ab", 22: "ab", 29: "ab", 62: "ab", 86: "ab", 111: "ab"}
EQUATIONS = [f"1.{number}{part}" for number in range(1, 125) for part in PARTS.get(number, [""])]
ROWS = [
    [cell.strip() for cell in line.strip("|").split("|")]
    for line in TEXT.splitlines()
    if re.match(r"\| 1\.\d", line)
]
FUNCTIONS = sorted(set(re.findall(r"`(fuzzy2\.[\w.]+)`", TEXT)))
NAMED_TESTS = sorted(set(re.findall(r"`([\w/]+\.py::test_\w+)`", TEXT)))
ERRATA = [int(number) for number in re.findall(r"^(\d+)\. \*\*", TEXT, flags=re.MULTILINE)]


def test_every_equation_is_on_the_map_once_and_in_order() -> None:
    found = [equation for row in ROWS for equation in row[0].split(", ")]
    assert found == EQUATIONS


@pytest.mark.parametrize("row", ROWS, ids=[row[0] for row in ROWS])
def test_every_equation_has_a_function_and_a_test(row: list[str]) -> None:
    assert len(row) == 5
    assert re.fullmatch(r"`fuzzy2\.[\w.]+`(, `fuzzy2\.[\w.]+`)*", row[2])
    assert re.fullmatch(r"`[\w/]+\.py::test_\w+`(, `[\w/]+\.py::test_\w+`)*", row[3])
    assert all(int(number) in ERRATA for number in row[4].split(", ") if number)


@pytest.mark.parametrize("name", FUNCTIONS)
def test_every_function_named_is_there(name: str) -> None:
    assert pkgutil.resolve_name(name) is not None


@pytest.mark.parametrize("name", NAMED_TESTS)
def test_every_test_named_is_there(name: str) -> None:
    file, function = name.split("::")
    assert function in functions_of(file)


def test_errata_are_numbered_through_and_each_is_referred_to() -> None:
    assert list(range(1, len(ERRATA) + 1)) == ERRATA
    assert {int(number) for row in ROWS for number in row[4].split(", ") if number} == set(ERRATA)


def test_errors_of_the_gaussian_meet_are_as_tabulated() -> None:
    """To the three digits that the table has."""
    table = re.findall(r"^\| ([\d., ]+) \| ([\d., ]+) \| (0\.\d{3}) \|$", TEXT, flags=re.MULTILINE)
    assert len(table) == 6
    for means, sigmas, error in table:
        found = fuzzy2.gaussian_meet_error(
            *([float(number) for number in numbers.split(", ")] for numbers in (means, sigmas))
        )
        assert abs(found - float(error)) < 5.5e-4
