"""C code compiled and called from tests: arrays in, arrays and the code out."""

from __future__ import annotations

import ctypes
import os
import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import numpy as np

from fuzzy2.export.c_code import CCode, CFunction
from tests.helpers import Array

WARNINGS = ["-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Werror"]
FLAGS = ["-std=c99", "-O2", "-ffp-contract=off", *WARNINGS]
COMPILERS = [name for name in ("gcc", "clang") if shutil.which(name)]

STATES = int(os.environ.get("EXPORT_STATES", "500"))
"""In how many states a robot or a controller in C is compared with Python: 10,000 by ``make
export-states``, before a release.
"""

BEFORE_A_RELEASE = STATES >= 10_000
"""Whether code of which the like is checked anyway is checked, too."""

PRECISIONS: tuple[Any, ...] = ("double", "single") if BEFORE_A_RELEASE else ("double",)
"""In which precisions code runs under the sanitizers: in both before a release."""


def optimization(is_first: bool) -> str:
    """Return how far a compiler goes: not at all with code of which the like was optimized before.

    Optimization takes most of its time; before a release all code is optimized.
    """
    return "-O2" if is_first or BEFORE_A_RELEASE else "-O0"


def compiled(code: CCode, folder: Path, compiler: str = "gcc", *more: str) -> Path:
    """Write the code, and compile it to a shared library."""
    code.write(folder)
    library = folder / f"{code.name}.{compiler}.so"
    command = [compiler, *FLAGS, *more, "-shared", "-fPIC", "-o", str(library)]
    done = subprocess.run(
        [*command, str(folder / f"{code.name}.c"), "-lm"], capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr[:4000]
    return library


def warnings_of(compiler: str, folder: Path) -> str:
    """Return what a compiler says of all C files of a folder, without making code of them."""
    files = sorted(path.name for path in folder.glob("*.c"))
    done = subprocess.run(
        [compiler, *FLAGS, "-fsyntax-only", *files], cwd=folder, capture_output=True, text=True
    )
    return done.stderr


MAIN = """#include "{name}.c"
#include <stdio.h>
{arrays}
static unsigned long long seed = 1;
static double chance(void)
{{
    seed = seed * 6364136223846793005ULL + 1442695040888963407ULL;
    return (double)(seed >> 40) / 8388608.0 - 1.0;
}}
int main(void)
{{
    int round, i, done = 0;
    for (round = 0; round < {rounds}; round++) {{
        double scale = round % 3 == 0 ? 0.01 : round % 3 == 1 ? 0.2 : 2.0;
        scale = round % 20 == 7 ? NAN : round % 20 == 14 ? 1e30 : scale;
{calls}
    }}
    printf("%d\\n", done);
    return 0;
}}
"""


def checked_at_run_time(
    code: CCode,
    folder: Path,
    compiler: str,
    centers: dict[str, Array],
    rounds: int = 300,
) -> None:
    """Call all functions with random numbers, with the sanitizers of addresses and of the rest.

    They see every step of code that is not optimized, and that takes a seventh of the time.

    Arguments are about their centers, or about zero; some are huge or no numbers. Each array has
    exactly its size. Warnings are errors.
    """
    code.write(folder)
    item, arrays, calls = code.precision.type, [], []
    if any(one.has_state for one in code.functions):
        arrays.append(f"static {code.name}_state state;")
    for one in code.functions:
        handed = ["&state"] if one.has_state else []
        for argument in one.visible:
            name = f"{one.name}_{argument.name}"
            handed.append(name)
            size = argument.size or 1
            arrays.append(f"static {item} {name}[{size}];")
            if argument.role == "in":
                middle = np.broadcast_to(centers.get(argument.name, np.zeros(1)), size)
                center = ", ".join(repr(float(x)) for x in middle)
                arrays.append(f"static const double {name}_at[{size}] = {{{center}}};")
                calls.append(
                    f"for (i = 0; i < {size}; i++) "
                    f"{name}[i] = ({item})({name}_at[i] + scale * chance());"
                )
        call = f"{one.name}({', '.join(handed)});"
        calls.append(f"done += !{call}" if one.result else f"if (round % 10 == 0) {call}")
    main = folder / "main.c"
    main.write_text(
        MAIN.format(
            name=code.name,
            arrays="\n".join(arrays),
            rounds=rounds,
            calls="\n".join(f"        {call}" for call in calls),
        ),
        encoding="utf-8",
    )
    program = folder / f"main.{compiler}"
    sanitizers = "-fsanitize=address,undefined,float-cast-overflow"
    command = [compiler, *FLAGS, "-O0", "-g", sanitizers, "-fno-sanitize-recover=all"]
    made = subprocess.run(
        [*command, "-o", str(program), str(main), "-lm"], capture_output=True, text=True
    )
    assert made.returncode == 0, made.stderr[:4000]
    ran = subprocess.run([str(program)], capture_output=True, text=True)
    assert ran.returncode == 0, ran.stderr[:4000]
    assert int(ran.stdout) > 0


def functions_of(code: CCode) -> set[str]:
    """Return the names of a code's own functions.

    One that is written several times, for what is known of its arguments, has one name.
    """
    names = re.findall(r"^static .*?(\w+)\([^;]*\)$", code.source, re.M)
    return {re.sub(r"_\d+$", "", name.removeprefix(f"{code.name}_")) for name in names}


class Library:
    """Functions of compiled code with a state of their own."""

    def __init__(self, code: CCode, path: Path) -> None:
        self.code, self._library = code, ctypes.CDLL(str(path))
        single = code.precision.name == "single"
        self.item = np.dtype(np.float32 if single else np.float64)
        self._number: Any = ctypes.c_float if single else ctypes.c_double
        self._functions = {one.name.removeprefix(f"{code.name}_"): one for one in code.functions}
        parts = {
            part.name: (part.name, "i4" if part.is_whole else self.item, part.size)
            for one in code.functions
            for part in one.arguments
            if part.role == "state"
        }
        self.state = np.zeros(1, np.dtype(list(parts.values()), align=True))

    def part(self, name: str) -> Array:
        """Return a part of the struct."""
        part: Array = self.state[name][0]
        return part

    def call(self, name: str, *arguments: Any) -> tuple[int, list[Array]]:
        """Return what a function returns, and what it wrote, in order."""
        function: CFunction = self._functions[name]
        pointer = ctypes.POINTER(self._number)
        given, handed, written = iter(arguments), [], []
        kept = []
        if function.has_state:
            handed.append(self.state.ctypes.data_as(ctypes.c_void_p))
        for argument in function.visible:
            if argument.role == "out":
                array = np.full(argument.size or 1, 1234.5, self.item)
                written.append(array)
            else:
                array = np.ascontiguousarray(next(given), self.item)
                assert array.size == argument.size
            kept.append(array)
            handed.append(array.ctypes.data_as(pointer))
        code = self._library[function.name](*handed)
        return code, written


def same(one: Any, other: Any) -> bool:
    """Tell whether numbers are the same to the last bit, any NaN like any other."""
    a, b = np.ravel(np.asarray(one, float)), np.ravel(np.asarray(other, float))
    return a.size == b.size and bool(
        np.all((a.view(np.int64) == b.view(np.int64)) | (np.isnan(a) & np.isnan(b)))
    )
