"""The map of chapter 3.

Every equation is on it, and every function and test that it names is there.
"""

from __future__ import annotations

import itertools
import pkgutil
import re

import numpy as np
import pytest

import psp3
from tests.helpers import thesis_chain
from tests.maps.named_tests import TESTS, functions_of

TEXT = (TESTS.parent / "docs" / "chapter3.md").read_text(encoding="utf-8")

# Equations in parts, by the labels of the thesis's text.
PARTS = {5: "abc", 26: "ab", 29: "ab", 30: "abc", 36: "abc"}
EQUATIONS = [f"3.{number}{part}" for number in range(1, 37) for part in PARTS.get(number, [""])]
ROWS = [
    [cell.strip() for cell in line.strip("|").split("|")]
    for line in TEXT.splitlines()
    if re.match(r"\| 3\.\d", line)
]
FUNCTIONS = sorted(set(re.findall(r"`(psp3\.[\w.]+)`", TEXT)))
NAMED_TESTS = sorted(set(re.findall(r"`([\w/]+\.py::test_\w+)`", TEXT)))
ERRATA = [int(number) for number in re.findall(r"^(\d+)\. \*\*", TEXT, flags=re.MULTILINE)]


def test_every_equation_is_on_the_map_once() -> None:
    """Twists and their rates, 3.24 to 3.26, are in two rows by what they are.

    Otherwise the order is that of the thesis.
    """
    found = [equation for row in ROWS for equation in row[0].split(", ")]
    assert sorted(found) == sorted(EQUATIONS)
    numbers = [int(re.findall(r"\d+", equation)[1]) for equation in found]
    assert all(later >= earlier - 1 for earlier, later in itertools.pairwise(numbers))


@pytest.mark.parametrize("row", ROWS, ids=[row[0] for row in ROWS])
def test_every_equation_has_a_function_and_a_test(row: list[str]) -> None:
    assert len(row) == 5
    assert re.fullmatch(r"`psp3\.[\w.]+`(, `psp3\.[\w.]+`)*", row[2])
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


def test_the_cayley_form_nears_its_singularity() -> None:
    """Determinant of 1 + R of the tip's frame, by the printed chain of the first arm.

    2 at home, and falling with the tilt.
    """
    robot = psp3.load("psp3")
    order = [
        robot.model.joints[robot.model.getJointId(f"{joint}1")].idx_q
        for joint in ("a", "phi", "theta", "lambda", "b")
    ]
    determinants = []
    for difference in (0.0, 0.15, 0.5):
        shapes = difference * np.array(
            [
                [0.0, 1.0, 0.0],
                [0.0, -1.0, 0.0],
                [1.0, 0.0, 0.0],
                [-1.0, 0.0, 0.0],
                [0.0, 0.0, 1.0],
                [0.0, 0.0, -1.0],
            ]
        )
        chains = [
            thesis_chain(0, robot.configuration(heights)[order], 0.181, 0.070) for heights in shapes
        ]
        determinants.append(min(np.linalg.det(np.eye(3) + chain[:3, :3]) for chain in chains))
    assert determinants[0] == pytest.approx(2.0, abs=1e-12)
    assert determinants[0] > determinants[1] > determinants[2] > 0.0
    assert determinants[2] < 0.1
