"""The bound of the stack is what GCC says of its own functions, and what has none is refused."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import pytest

from psp3.export.project import export_project
from tests.embedded.board import BOARDS, COMPILER, FLAGS, LINKING, M7, Board, needs_arm
from tests.embedded.stack import Image, NoBound, read
from tests.embedded.things import THINGS
from tests.processes import ROOT

pytestmark = needs_arm

PAGE = (ROOT / "docs" / "how_to" / "export.md").read_text(encoding="utf-8")

KEPT = "__attribute__((noinline, noclone, used))"


def image_of(source: str, folder: Path, board: Board = M7, *more: str) -> Image:
    """Return the instructions of a program."""
    (folder / "tried.c").write_text(source, encoding="utf-8")
    startup = str(Path(__file__).with_name("startup.c"))
    command = [COMPILER, *FLAGS, *board.options, *LINKING, "--specs=nosys.specs", "-DSILENT"]
    files = ["-fstack-usage", *more, "-o", "tried.elf", "tried.c", startup, "-lm"]
    done = subprocess.run([*command, *files], cwd=folder, capture_output=True, encoding="utf-8")
    assert done.returncode == 0, done.stderr
    return read(folder / "tried.elf")


def test_calls_add_up(tmp_path: Path) -> None:
    """400 bytes in one, and 80 in the deeper of two that it calls; a jump by a table between."""
    image = image_of(
        f"""
static volatile int zero;
{KEPT} static void shallow(void) {{ volatile char room[40]; room[zero] = 1; zero = room[0]; }}
{KEPT} static void deep(void) {{ volatile char room[80]; room[zero] = 1; zero = room[0]; }}
{KEPT} static int chosen(int k)
{{
    volatile char room[400];
    room[zero] = 1;
    switch (k) {{
    case 0: zero = 7; break;
    case 1: deep(); zero = 1; break;
    case 2: zero = 3 * k; shallow(); break;
    case 3: zero = -4; shallow(); zero = 2; break;
    case 4: zero += 5; break;
    case 5: zero /= 9; break;
    default: break;
    }}
    return room[zero];
}}
int main(void) {{ return chosen(zero); }}
""",
        tmp_path,
    )
    assert any(one.what in ("tbb", "tbh") for one in image.instructions.values())
    alone = image.own("chosen")
    assert 400 <= alone < 440
    assert 80 <= image.bound("deep") < 100
    assert image.bound("chosen") == alone + image.bound("deep")


REFUSED = {
    "calls itself": f"{KEPT} static int one(int n)\n"
    "{ return n < 2 ? n : one(n - 1) * one(n / 2); }",
    "a register holds": "static int two(int n) { return n; }\n"
    "static int (*volatile chosen)(int) = two;\n"
    f"{KEPT} static int one(int n) {{ return chosen(n) + 1; }}",
    "sp": f"{KEPT} static int one(int n) {{ volatile int a[n]; a[n - 1] = 1; return a[n - 1]; }}",
}


@pytest.mark.parametrize("why", REFUSED)
def test_what_has_no_bound_is_refused(why: str, tmp_path: Path) -> None:
    program = f"{REFUSED[why]}\nint main(void) {{ volatile int n = 9; return one(n); }}\n"
    with pytest.raises(NoBound, match=why):
        image_of(program, tmp_path).bound("one")


ONE = ("sqrt", "exp", "expm1", "log", "log1p", "sin", "cos", "tan", "asin", "acos", "atan")
ONE += ("sinh", "cosh", "tanh", "floor", "ceil", "fabs")
TWO = ("atan2", "hypot", "copysign", "pow")


@pytest.mark.parametrize("precision", BOARDS)
def test_the_c_library_takes_no_more_than_the_page_says(precision: str, tmp_path: Path) -> None:
    """Every function of ``math.h`` that a kernel may use."""
    suffix, item = ("f", "float") if precision == "single" else ("", "double")
    calls = [f"x = {name}{suffix}(x);" for name in ONE] + [f"x = {n}{suffix}(x, x);" for n in TWO]
    program = f"#include <math.h>\nvolatile {item} x;\nint main(void)\n{{ {' '.join(calls)} }}\n"
    image = image_of(program, tmp_path, BOARDS[precision], "-fno-builtin")
    found = {name: image.bound(f"{name}{suffix}") for name in (*ONE, *TWO)}
    said = re.search(
        r"take at most (\d+) bytes in single and (\d+) in double precision, powers (\d+) and (\d+)",
        " ".join(PAGE.split()),
    )
    assert said is not None
    most, powers = (int(number) for number in said.groups()[precision == "double" :: 2])
    turning = {found.pop(name) for name in ("sin", "cos", "tan")}
    assert 0.8 * most < max(turning) <= most
    assert 0.8 * powers < found["pow"] <= powers
    assert max(found.values()) == found["pow"]


@pytest.mark.slow
@pytest.mark.parametrize("precision", BOARDS)
@pytest.mark.parametrize("name", ["planes", "delta"])
def test_frames_are_those_that_the_compiler_says(name: str, precision: str, tmp_path: Path) -> None:
    """Of every function of the code, those that only it can call included."""
    export_project(THINGS[name].make(), tmp_path, precision=precision, name="code")  # type: ignore[arg-type]
    code = (tmp_path / "code.c").read_text(encoding="utf-8")
    functions = re.findall(r"^\w+ (code_\w+)\([^;]*\)\n\{", code, re.M)
    calls = "\n".join(f"    *place = (void *){one};" for one in functions)
    program = f"{code}\nvoid *volatile *place;\nint main(void)\n{{\n{calls}\n    return 0;\n}}\n"
    image = image_of(program, tmp_path, BOARDS[precision], "-Wno-pedantic", "-Wno-error")
    said = (tmp_path / "tried.elf-tried.su").read_text(encoding="utf-8")
    compared = 0
    for name_, size, kind in re.findall(r":([^:\s]+)\t(\d+)\t(\w+)", said):
        assert kind == "static"
        clones = [own for own in image.symbols if re.sub(r"\.\d+", "", own) == name_]
        if name_ != "main" and len(clones) == 1:
            assert image.own(clones[0]) == int(size), name_
            compared += 1
    assert compared >= len(functions)
