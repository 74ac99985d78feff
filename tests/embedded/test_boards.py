"""Exported code runs on an emulated Cortex-M, gives Python's numbers, and keeps to its bounds.

In double precision the C library there is newlib, whose ``exp``, ``sin`` and ``cos`` may round the
last bit otherwise: the tolerance is that of the folder's own test, 1e-12, and 1e-3 in single
precision.
"""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest

from fuzzy2.export.project import write_project
from psp3.export.project import export_project
from tests.embedded.board import BOARDS, M7, measure, needs_arm, run_cases
from tests.embedded.things import THINGS
from tests.fuzzy2.export.test_project import INPUTS, code_with_a_state

pytestmark = [
    needs_arm,
    pytest.mark.slow,
    pytest.mark.filterwarnings("ignore:the Gaussian corollary:fuzzy2.ApproximationWarning"),
]


@pytest.fixture(scope="module", params=THINGS)
def thing(request: pytest.FixtureRequest) -> tuple[str, Any]:
    """Return name and object of what is exported."""
    return request.param, THINGS[request.param].make()


@pytest.mark.parametrize("precision", BOARDS)
def test_cases_are_right_on_the_processor(
    thing: tuple[str, Any], precision: Any, tmp_path: Path
) -> None:
    export_project(thing[1], tmp_path, precision=precision, name=thing[0])
    assert "passed: 0 differ" in run_cases(tmp_path, BOARDS[precision])


def test_flash_and_instructions_keep_to_their_bounds(
    thing: tuple[str, Any], tmp_path: Path
) -> None:
    """In double precision on a Cortex-M7; and the stack is what an interrupt may have, 64 kB."""
    name, made = thing
    code = export_project(made, tmp_path, name=name)
    needs = measure(tmp_path, code, M7)[THINGS[name].function]
    assert 0 < needs.flash <= (THINGS[name].flash or 1_000_000)
    assert 0 < needs.instructions <= (THINGS[name].instructions or 1_000_000)
    assert 0 < needs.stack < 60_000


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
    assert 800 <= needs["add"].stack <= 900
    assert needs["read"].stack <= 60
    assert needs["read"].state == 24
    assert 8 <= needs["read"].flash <= 100


def test_make_arm_says_size_and_stack(tmp_path: Path) -> None:
    export_project(THINGS["type1"].make(), tmp_path, precision="single", name="rules")
    done = subprocess.run(
        ["make", "-C", str(tmp_path), "arm"], capture_output=True, encoding="utf-8", check=True
    )
    assert "text" in done.stdout
    assert "stack [bytes] of a function:" in done.stdout
    assert shutil.which("arm-none-eabi-gcc") is not None
