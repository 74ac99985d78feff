"""Compile exported code, and call it from Python."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fuzzy2.export.c_code import Argument, CCode, CFunction, CWriter

STRICT = ["-std=c99", "-O2", "-ffp-contract=off", "-Wall", "-Wextra", "-Wpedantic"]
STRICT += ["-Wconversion", "-Werror"]
COMPILERS = [name for name in ("gcc", "clang") if shutil.which(name)]
needs_gcc = pytest.mark.skipif("gcc" not in COMPILERS, reason="no gcc on this machine")


def build(
    code: CCode, folder: Path, compiler: str = "gcc", flags: tuple[str, ...] = ()
) -> ctypes.CDLL:
    """Compile without a warning, and load."""
    _, source = code.write(folder)
    library = folder / f"{code.name}_{compiler}.so"
    command = [
        compiler,
        *STRICT,
        *flags,
        "-shared",
        "-fPIC",
        "-o",
        str(library),
        str(source),
        "-lm",
    ]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[:2000]
    return ctypes.CDLL(str(library))


def bind(library: ctypes.CDLL, code: CCode, function: CFunction) -> Callable[..., Any]:
    """Return a function of C that takes arrays and numbers in the order of its description."""
    item = ctypes.c_double if code.precision.name == "double" else ctypes.c_float
    called = getattr(library, function.name)
    called.restype = {"int": ctypes.c_int, "real": item, "void": None}[function.returns]
    kinds = [
        item if argument.size is None else ctypes.POINTER(item) for argument in function.visible
    ]
    called.argtypes = kinds

    def call(*arguments: Any) -> Any:
        given = zip(arguments, kinds, strict=True)
        return called(*(a if kind is item else a.ctypes.data_as(kind) for a, kind in given))

    return call


def kernel_in_c(
    kernel: Callable[..., Any],
    inputs: int,
    outputs: int,
    folder: Path,
    flags: tuple[str, ...] = (),
    **options: Any,
) -> tuple[Callable[..., Any], CCode]:
    """Compile a kernel ``(x, out)``; return it, and its code."""
    writer = CWriter("tried", "double", ["A kernel of a test."], **options)
    arguments = [Argument("x", "in", inputs), Argument("out", "out", outputs, "out")]
    function = writer.add("run", "Run.", kernel, list(arguments))
    code = writer.code()
    return bind(build(code, folder, flags=flags), code, function), code


def same_as_python(
    kernel: Callable[..., Any], rows: Any, outputs: int, folder: Path, **options: Any
) -> CCode:
    """Check that a kernel does in C, to the last bit and sign of zero, what it does in Python."""
    rows = np.array(rows, dtype=float)
    run, code = kernel_in_c(kernel, rows.shape[1], outputs, folder, **options)
    for row in rows:
        in_python, in_c = np.zeros(outputs), np.zeros(outputs)
        with np.errstate(all="ignore"):
            kernel(row.copy(), in_python)
        run(row.copy(), in_c)
        assert in_python.tobytes() == in_c.tobytes() or _alike(in_python, in_c), (row, in_c)
    return code


def _alike(one: Any, other: Any) -> bool:
    """Whether all is equal but the bits of NaN, of which there are many."""
    numbers = ~np.isnan(one)
    return (
        np.array_equal(np.isnan(one), np.isnan(other))
        and one[numbers].tobytes() == other[numbers].tobytes()
    )
