"""Exported code runs on an emulated Cortex-M, gives Python's numbers, and keeps to its bounds.

In double precision the C library there is newlib, whose ``exp``, ``sin`` and ``cos`` may round the
last bit otherwise: the tolerance is that of the folder's own test, 1e-12, and 1e-3 in single
precision.
"""

from __future__ import annotations

import functools
import re
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from fuzzy2.export.c_code import CCode
from fuzzy2.export.project import write_project
from psp3.export.project import export_project
from tests.embedded.board import BOARDS, M7, Board, measure, needs_arm, run_cases
from tests.embedded.things import THINGS
from tests.fuzzy2.export.test_project import INPUTS, code_with_a_state
from tests.processes import ROOT

PAGE = (ROOT / "docs" / "how_to" / "export.md").read_text(encoding="utf-8")

MOST_OF_THE_LIBRARY = 480
"""Bytes of stack of newlib's sinf and cosf with all that they call."""

pytestmark = [
    needs_arm,
    pytest.mark.slow,
    pytest.mark.filterwarnings("ignore:the Gaussian corollary:fuzzy2.ApproximationWarning"),
]


@pytest.fixture(scope="module", params=THINGS)
def thing(request: pytest.FixtureRequest) -> tuple[str, Any]:
    """Return name and object of what is exported."""
    return request.param, THINGS[request.param].make()


class Project(NamedTuple):
    """A folder of a thing in a precision, and the code in it."""

    folder: Path
    code: CCode


@pytest.fixture(scope="module")
def projects(
    thing: tuple[str, Any], tmp_path_factory: pytest.TempPathFactory
) -> Callable[[str], Project]:
    """Return a function that exports the thing in a precision, once."""

    @functools.cache
    def project(precision: Any) -> Project:
        name, made = thing
        folder = tmp_path_factory.mktemp(name)
        return Project(folder, export_project(made, folder, precision=precision, name=name))

    return project


@pytest.mark.parametrize("precision", BOARDS)
def test_cases_are_right_on_the_processor(projects: Any, precision: str) -> None:
    assert "passed: 0 differ" in run_cases(projects(precision).folder, BOARDS[precision])


def _row_of_the_page(about: str, board: Board, precision: str) -> list[float]:
    """Return the numbers of a row of the table on export."""
    (row,) = re.findall(
        rf"^\| {re.escape(about)} \| {board.name}, {precision} \|(.*)\|$", PAGE, re.M
    )
    return [float(number) for number in row.split("|")]


@pytest.mark.parametrize("precision", BOARDS)
def test_needs_keep_to_their_bounds(thing: tuple[str, Any], projects: Any, precision: str) -> None:
    """No call takes more stack than its bound; that is what an interrupt may have, 64 kB.

    Flash and instructions have bounds in double precision on a Cortex-M7.
    """
    name, (folder, code) = thing[0], projects(precision)
    found = measure(folder, code, BOARDS[precision])
    for function, needs in found.items():
        assert 0 <= needs.stack <= needs.most_stack < 60_000, function
    needs = found[THINGS[name].function]
    numbers = (needs.flash / 1000.0, needs.state, needs.stack, needs.most_stack)
    right = (*numbers, needs.instructions, needs.most)
    said = _row_of_the_page(THINGS[name].about, BOARDS[precision], precision)
    # Another version of the compiler, or of the machine's arithmetic in training, moves a little.
    assert said == pytest.approx(right, rel=0.1), f"python docs/make_embedded.py {name}"
    if precision == "double":
        assert needs.flash <= (THINGS[name].flash or 1_000_000)
        assert needs.instructions <= (THINGS[name].instructions or 1_000_000)


def test_measured_instructions_are_those_of_a_loop_that_is_known(tmp_path: Path) -> None:
    """100 additions that each wait for the one before: a loop of 3 or 4 instructions a turn."""
    code = code_with_a_state()
    write_project(code, tmp_path, INPUTS)
    (tmp_path / "sums.c").write_text(
        '#include "sums.h"\n'
        "void sums_begin(sums_state *state) { (void)state; }\n"
        "int sums_add(sums_state *state, const double step[2], double number, double out[2])\n"
        "{\n    volatile double deep[100];\n    (void)state; (void)step; out[0] = number;\n"
        "    for (int i = 0; i < 100; i++) {\n"
        '        __asm volatile("nop\\n nop\\n nop\\n nop\\n nop\\n nop\\n nop");\n    }\n'
        "    deep[0] = number; out[1] = deep[0];\n    return 0;\n}\n"
        "void sums_read(sums_state *state, double out[2]) { (void)state; out[0] = 0.0; }\n",
        encoding="utf-8",
    )
    needs = measure(tmp_path, code, M7)
    assert 900 <= needs["add"].instructions <= 1100
    assert needs["read"].instructions <= 80
    assert 800 <= needs["add"].stack == needs["add"].most_stack <= 840
    assert needs["read"].stack == needs["read"].most_stack == 0
    assert needs["read"].state == 24
    assert 8 <= needs["read"].flash <= 100


@pytest.mark.parametrize("name", ["planes", "delta"])
def test_make_arm_says_size_and_stack(name: str, tmp_path: Path) -> None:
    """By the compiler's call graph; the C library, which is not in it, takes the rest."""
    code = export_project(THINGS[name].make(), tmp_path, precision="single", name=name)
    done = subprocess.run(
        ["make", "-C", str(tmp_path), "arm"], capture_output=True, encoding="utf-8", check=True
    )
    assert "text" in done.stdout
    found = measure(tmp_path, code, BOARDS["single"])
    said = re.findall(r"^stack \[bytes\] at most: (\d+) (\w+)(.*)$", done.stdout, re.M)
    assert {name for _, name, _ in said} == {function.name for function in code.functions}
    for most, function, beside in said:
        bound = found[function.removeprefix(f"{name}_")].most_stack
        assert beside.startswith(", and what these take: ") or int(most) == bound
        assert int(most) <= bound <= int(most) + (MOST_OF_THE_LIBRARY if beside else 0)


def test_the_time_of_the_page_is_that_of_its_table() -> None:
    said = re.search(r"At (\d+) MHz and two cycles an instruction .* about (\S+) ms", PAGE)
    assert said is not None
    row = _row_of_the_page(THINGS["controller"].about, BOARDS["single"], "single")
    assert float(said[2]) == pytest.approx(2.0 * row[4] / (1e3 * float(said[1])), abs=0.005)
