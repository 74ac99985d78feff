"""Run a folder of C code on an emulated Cortex-M, and measure what it needs there.

Debian's ``gcc-arm-none-eabi``, ``libnewlib-arm-none-eabi`` and ``qemu-system-arm`` are needed.
Instructions are not cycles: a Cortex-M4 takes about one to two cycles each, divisions and square
roots 14 to 30, a Cortex-M7 fewer.
"""

from __future__ import annotations

import os
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from fuzzy2.export.c_code import CCode, CFunction
from fuzzy2.export.project_calls import short_name, size_of
from tests.embedded.stack import read

HERE = Path(__file__).parent
COMPILER, SIZE, EMULATOR = "arm-none-eabi-gcc", "arm-none-eabi-size", "qemu-system-arm"
REQUIRED = "arm" in os.environ.get("REQUIRED_CLIENTS", "").split()

FLAGS = (
    *("-std=c99", "-O2", "-ffp-contract=off", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion"),
    *("-Werror", "-mthumb", "-mfloat-abi=hard", "-fno-trapping-math", "-fno-math-errno"),
    *("-ffunction-sections", "-fdata-sections"),
)
LINKING = ("-nostartfiles", "-Wl,--gc-sections", "-T", str(HERE / "board.ld"))

needs_arm = pytest.mark.skipif(
    not REQUIRED and any(shutil.which(tool) is None for tool in (COMPILER, EMULATOR)),
    reason="the compiler or the emulator is not installed (apt-get install gcc-arm-none-eabi "
    "libnewlib-arm-none-eabi qemu-system-arm)",
)


@dataclass(frozen=True)
class Board:
    """A processor, as the compiler and the emulator name it."""

    name: str
    options: tuple[str, ...]
    machine: str


M4 = Board("Cortex-M4", ("-mcpu=cortex-m4", "-mfpu=fpv4-sp-d16"), "mps2-an386")
M7 = Board("Cortex-M7", ("-mcpu=cortex-m7", "-mfpu=fpv5-d16"), "mps2-an500")
BOARDS = {"single": M4, "double": M7}


@dataclass(frozen=True)
class Needs:
    """What a function needs.

    Bytes of ``flash``, with the functions and tables of the C library that it calls; of the struct
    that is remembered (``state``); of ``stack``, the largest of all calls of the test. Instructions
    a call, the median and the most.
    """

    flash: int
    state: int
    stack: int
    most_stack: int
    instructions: int
    most: int


def run_cases(folder: Path, board: Board) -> str:
    """Run ``test.c`` of a folder, and return what it prints; another status than 0 is an error."""
    return _emulated(_linked(folder, board, "test.c", "calls.c", "cases.c"), board)


def measure(folder: Path, code: CCode, board: Board) -> dict[str, Needs]:
    """Return what each function of a folder needs, by its name without the prefix."""
    # It includes calls.c.
    image = _linked(folder, board, str(HERE / "measure.c"), "cases.c")
    rows = np.array([line.split() for line in _emulated(image, board).splitlines()], dtype=int)
    nothing = _flash(folder, board, code, None)
    instructions_of = read(image)
    # What is painted begins below main, with those that call the function there.
    callers = instructions_of.own("counts") + instructions_of.own("calls_call")
    needs = {}
    for number, function in enumerate(code.functions):
        _, instructions, stacks = rows[rows[:, 0] == number].T
        needs[short_name(code, function)] = Needs(
            flash=_flash(folder, board, code, function) - nothing,
            state=state_size(code),
            stack=int(stacks.max()) - callers,
            most_stack=instructions_of.bound(function.name),
            instructions=int(np.median(instructions)),
            most=int(instructions.max()),
        )
    return needs


def state_size(code: CCode) -> int:
    """Return the bytes of the struct that is remembered between two calls."""
    item = 8 if code.precision.name == "double" else 4
    states = {
        argument.name: size_of(argument) * (4 if argument.is_whole else item)
        for function in code.functions
        for argument in function.arguments
        if argument.role == "state"
    }
    return sum(states.values())


def _linked(folder: Path, board: Board, *sources: str) -> Path:
    """Return an image with the code of a folder that writes to the emulator's output."""
    code = next(path.stem for path in folder.glob("*.h") if path.stem not in ("calls", "cases"))
    image = folder / "image.elf"
    _link(folder, board, image, ("--specs=rdimon.specs",), *sources, _object(folder, board, code))
    return image


def _object(folder: Path, board: Board, code: str) -> str:
    """Return the name of the compiled code of a folder, which is linked with several programs."""
    compiled = f"{code}.{board.name}.o"
    if not (folder / compiled).exists():
        command = (COMPILER, *FLAGS, *board.options, "-c", "-o", compiled, f"{code}.c")
        _run(command, folder)
    return compiled


def _link(folder: Path, board: Board, image: Path, options: tuple[str, ...], *files: str) -> None:
    command = (COMPILER, *FLAGS, *board.options, *LINKING, *options, "-I", ".", "-o", str(image))
    _run((*command, *files, str(HERE / "startup.c"), "-lm"), folder)


def _run(command: tuple[str, ...], folder: Path) -> None:
    done = subprocess.run(command, cwd=folder, capture_output=True, encoding="utf-8")
    assert done.returncode == 0, done.stderr


def _emulated(image: Path, board: Board) -> str:
    """Return what an image prints."""
    done = subprocess.run(
        (
            *(EMULATOR, "-M", board.machine, "-kernel", str(image), "-nographic"),
            *("-icount", "shift=0", "-monitor", "none"),
            *("-semihosting-config", "enable=on,target=native"),
        ),
        capture_output=True,
        stdin=subprocess.DEVNULL,
        encoding="utf-8",
        timeout=600.0,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def _caller(code: CCode, function: CFunction | None) -> str:
    """Return a program that calls one function, or none."""
    item, lines, names = code.precision.type, [f'#include "{code.name}.h"'], []
    if function is not None:
        if function.has_state:
            lines.append(f"{code.name}_state state;")
            names.append("&state")
        for argument in function.visible:
            is_number = argument.size is None
            lines.append(f"{item} {argument.name}[{size_of(argument)}];")
            names.append(f"{argument.name}[0]" if is_number else argument.name)
        call = f"{function.name}({', '.join(names)})"
        lines += ["volatile int said;"] if function.result else []
        call = f"said = (int){call}" if function.result else call
    body = "" if function is None else f"{call};"
    return "\n".join([*lines, f"int main(void) {{ {body} return 0; }}", ""])


def _flash(folder: Path, board: Board, code: CCode, function: CFunction | None) -> int:
    """Return the bytes of flash of a program that calls a function, or none, and prints nothing."""
    (folder / "caller.c").write_text(_caller(code, function), encoding="utf-8")
    image, silent = folder / "caller.elf", ("--specs=nosys.specs", "-DSILENT")
    _link(folder, board, image, silent, "caller.c", _object(folder, board, code.name))
    said = subprocess.run((SIZE, str(image)), capture_output=True, encoding="utf-8", check=True)
    text, data = map(int, said.stdout.splitlines()[1].split()[:2])
    return text + data
