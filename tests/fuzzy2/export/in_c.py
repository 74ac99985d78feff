"""Compile exported code, and call it from Python."""

from __future__ import annotations

import ctypes
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fuzzy2.export.c_code import Argument, CCode, CFunction, CWriter
from tests.c_code import COMPILERS, FLAGS, compiled

needs_gcc = pytest.mark.skipif("gcc" not in COMPILERS, reason="no gcc on this machine")


def build(
    code: CCode, folder: Path, compiler: str = "gcc", flags: tuple[str, ...] = ()
) -> ctypes.CDLL:
    """Compile without a warning, and load."""
    return ctypes.CDLL(str(compiled(code, folder, compiler, *flags)))


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


ROWS = """
void {function}_rows(int count, const {item} *given, {item} *written, int *codes);
void {function}_rows(int count, const {item} *given, {item} *written, int *codes)
{{
    int i;
    for (i = 0; i < count; i++) {{
        codes[i] = {function}(given + {reads} * i, written + {writes} * i);
    }}
}}
"""


def calls_of_rows(code: CCode) -> str:
    """Return C code that calls each function ``int f(x, out)`` with many rows.

    A call from Python takes longer than what most functions do.
    """
    texts = [
        ROWS.format(
            function=function.name,
            item=code.precision.type,
            reads=function.visible[0].size,
            writes=function.visible[1].size,
        )
        for function in code.functions
    ]
    return "\n".join([f'#include "{code.name}.h"', *texts])


class InC:
    """Functions ``int f(x, out)`` of exported code, compiled without a warning, for many rows.

    Parameters
    ----------
    code : CCode
        The code.
    folder : Path
        Where it is written and compiled, to ``{name}.o`` among others.
    optimized : str
        How far gcc goes.
    """

    def __init__(self, code: CCode, folder: Path, optimized: str = "-O2") -> None:
        self.code, self.folder = code, folder
        code.write(folder)
        (folder / f"{code.name}_rows.c").write_text(calls_of_rows(code), encoding="utf-8")
        names = (code.name, f"{code.name}_rows")
        _run(["gcc", *FLAGS, optimized, "-fPIC", "-c", *(f"{name}.c" for name in names)], folder)
        files = [f"{name}.o" for name in names]
        _run(["gcc", "-shared", "-o", f"{code.name}.so", *files, "-lm"], folder)
        self._library = ctypes.CDLL(str(folder / f"{code.name}.so"))

    def rows(self, number: int, X: Any) -> tuple[Any, Any]:
        """Return what a function writes and returns for each row."""
        function = self.code.functions[number]
        given, written = (argument.size or 1 for argument in function.visible)
        kind = np.float64 if self.code.precision.name == "double" else np.float32
        X = np.ascontiguousarray(X, kind)
        assert X.shape[1] == given
        out, codes = np.full((len(X), written), -7.0, kind), np.full(len(X), -7, np.int32)
        pointers = [a.ctypes.data_as(ctypes.c_void_p) for a in (X, out, codes)]
        self._library[f"{function.name}_rows"](len(X), *pointers)
        return out, codes


def _run(command: list[str], folder: Path) -> None:
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[:2000]


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
