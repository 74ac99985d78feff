"""The maps of the chapters: every equation is there, with functions, and tests that call them.

A row of a map is an equation, a table or a definition: what it says, functions, tests, errata.
"""

from __future__ import annotations

import itertools
import pkgutil
import re
from typing import NamedTuple

import pytest

from tests.maps.named_tests import TESTS, calls, functions_of

LAST = {1: 124, 2: 4, 3: 36, 4: 18, 5: 1, 6: 0}
"""Number of the last equation by chapter."""

# Equations in parts, by the labels of the thesis's text.
PARTS: dict[int, dict[int, str]] = {
    1: {8: "ab", 18: "ab", 20: "ab", 22: "ab", 29: "ab", 62: "ab", 86: "ab", 111: "ab"},
    3: {5: "abc", 26: "ab", 29: "ab", 30: "abc", 36: "abc"},
    4: {2: "ab", 5: "ab", 12: "ab"},
}
FUNCTION, TEST = r"`(?:fuzzy2|psp3)\.[\w.]+`", r"`[\w/]+\.py::test_\w+`"


class Row(NamedTuple):
    """A row of a map."""

    chapter: int
    what: str
    functions: tuple[str, ...]
    tests: tuple[str, ...]
    errata: tuple[int, ...]

    def __str__(self) -> str:
        return f"chapter {self.chapter}: {self.what}"


def page(chapter: int) -> str:
    return (TESTS.parent / "docs" / f"chapter{chapter}.md").read_text(encoding="utf-8")


def rows_of(chapter: int) -> list[Row]:
    """Return the rows of a map, each of which must have the form of one."""
    rows = []
    for line in page(chapter).splitlines():
        if "::test_" not in line or not line.startswith("|"):
            continue
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        assert len(cells) == 5, line
        assert re.fullmatch(rf"{FUNCTION}(, {FUNCTION})*", cells[2]), line
        assert re.fullmatch(rf"{TEST}(, {TEST})*", cells[3]), line
        rows.append(
            Row(
                chapter,
                cells[0],
                *(tuple(re.findall(r"`([^`]+)`", cell)) for cell in cells[2:4]),
                tuple(int(number) for number in cells[4].split(", ") if number),
            )
        )
    return rows


def errata_of(chapter: int) -> list[int]:
    return [int(number) for number in re.findall(r"^(\d+)\. ", page(chapter), flags=re.MULTILINE)]


CHAPTERS = sorted(LAST)
ROWS = [row for chapter in CHAPTERS for row in rows_of(chapter)]
NAMED_TESTS = sorted(
    {name for chapter in CHAPTERS for name in re.findall(rf"{TEST}", page(chapter))}
)


@pytest.mark.parametrize("chapter", CHAPTERS)
def test_every_equation_is_on_its_map_once_and_in_order(chapter: int) -> None:
    """But for chapter 3: twists and their rates, 3.24 to 3.26, are in two rows by what they are."""
    expected = [
        f"{chapter}.{number}{part}"
        for number in range(1, LAST[chapter] + 1)
        for part in PARTS.get(chapter, {}).get(number, [""])
    ]
    found = [
        equation
        for row in ROWS
        if row.chapter == chapter
        for equation in row.what.split(", ")
        if re.fullmatch(r"\d\.\d+[a-c]?", equation)
    ]
    assert sorted(found) == sorted(expected)
    if chapter == 3:
        numbers = [int(re.findall(r"\d+", equation)[1]) for equation in found]
        assert all(later >= earlier - 1 for earlier, later in itertools.pairwise(numbers))
    else:
        assert found == expected


@pytest.mark.parametrize("row", ROWS, ids=str)
def test_every_test_calls_a_function_of_its_row_and_every_function_is_called(row: Row) -> None:
    for function in row.functions:
        assert pkgutil.resolve_name(function) is not None
    for test in row.tests:
        file, name = test.split("::")
        assert name in functions_of(file), test
    idle = [test for test in row.tests if not any(calls(test, name) for name in row.functions)]
    assert not idle, f"call none of {row.functions}"
    uncalled = [name for name in row.functions if not any(calls(test, name) for test in row.tests)]
    assert not uncalled, f"called by none of {row.tests}"


@pytest.mark.parametrize("name", NAMED_TESTS)
def test_every_test_that_a_page_names_is_there(name: str) -> None:
    file, function = name.strip("`").split("::")
    assert function in functions_of(file)


@pytest.mark.parametrize("chapter", CHAPTERS)
def test_errata_are_numbered_through_and_each_is_referred_to(chapter: int) -> None:
    errata = errata_of(chapter)
    assert errata == list(range(1, len(errata) + 1))
    assert {number for row in rows_of(chapter) for number in row.errata} == set(errata)


# The helper itself: what it takes for a call, and what not.

BETWEEN = "cross/test_derivations.py::test_1_20_between_the_peaks"


@pytest.mark.parametrize(
    ("test", "function", "called"),
    [
        # through a helper of the same file
        (BETWEEN, "fuzzy2.operations.joined_sets.supremum", True),
        # imported there, and used by other tests only
        (BETWEEN, "fuzzy2.numbers.gaussian_meet", False),
        # a class by its constructor, and a property by reading it
        (
            "cross/test_derivations.py::test_1_54_and_1_55_the_objective_is_convex",
            "fuzzy2.numbers.GaussianNumber",
            True,
        ),
        (
            "psp3/thesis/test_chapter_4_systems.py"
            "::test_critical_damping_is_recognized_in_spite_of_rounding",
            "psp3.thesis.chapter_4_systems.MassSpringDamper.damping_case",
            True,
        ),
        # through a fixture, and not by a word in a docstring
        (
            "psp3/closure/test_mobility.py::test_robots_know_their_mobility",
            "psp3.loading.load",
            True,
        ),
        (
            "psp3/closure/test_mobility.py::test_too_many_motors_are_named",
            "psp3.closure.mobility.mobility",
            True,
        ),
        (
            "psp3/closure/test_mobility.py::test_too_many_motors_are_named",
            "psp3.closure.rank.null_space",
            False,
        ),
    ],
)
def test_what_counts_as_a_call(test: str, function: str, called: bool) -> None:
    assert calls(test, function) is called
