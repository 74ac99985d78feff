"""Compiled functions and their parts: what is compiled, how often, and that the answers are right.

Numba's own compilation of the same functions is what they are compared with.
"""

from __future__ import annotations

import contextlib
import math
import os
import pickle
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numba
import numpy as np
import pytest
from numba.core.errors import NumbaError

from fuzzy2.support import compile_unit
from fuzzy2.support.compile_unit import Kernel, _PartLibrary
from fuzzy2.support.compiled import compiled, inlined, scalar


def cubed(x, shift):  # type: ignore[no-untyped-def]
    return x * x * x + shift


cubed_part = compiled(cubed)
cubed_by_numba = numba.njit(cubed)


@scalar
def sum_of_entries(values, count):  # type: ignore[no-untyped-def]
    total = 0.0
    for i in range(count):
        total += math.sin(values[i]) / (1.0 + abs(values[i]))
    return total


@compiled
def twice(values):  # type: ignore[no-untyped-def]
    """Call one part in three ways, and one that has a part of its own."""
    return cubed_part(values[0], 0) + cubed_part(values[1], 7) + middle(values)


@inlined
def middle(values):  # type: ignore[no-untyped-def]
    return cubed_part(values[2], 9) - sum_of_entries(values, 3)


@compiled
def refuses(x):  # type: ignore[no-untyped-def]
    if x < 0.0:
        raise ValueError("below zero")
    return math.sqrt(x)


@compiled
def root_of_all(values):  # type: ignore[no-untyped-def]
    total = 0.0
    for i in range(values.size):
        total += refuses(values[i])
    return total


VALUES = np.array([0.3, -1.2, 2.5])


def test_the_answers_are_those_of_numba_to_the_last_bit() -> None:
    def by_numba(values):  # type: ignore[no-untyped-def]
        total = 0.0
        for i in range(3):
            total += math.sin(values[i]) / (1.0 + abs(values[i]))
        x, y, z = values[0], values[1], values[2]
        last = cubed_by_numba(z, 9) - total
        return cubed_by_numba(x, 0) + cubed_by_numba(y, 7) + last

    assert twice(VALUES) == numba.njit(error_model="numpy")(by_numba)(VALUES)


def test_ctrl_c_waits_for_the_compiler(monkeypatch: pytest.MonkeyPatch) -> None:
    """It comes while the code is made, and is raised when it is there."""

    @contextlib.contextmanager
    def interrupted(*_: object) -> Iterator[None]:
        signal.raise_signal(signal.SIGINT)
        yield

    kernel = Kernel(cubed, targetoptions={"nopython": True})
    monkeypatch.setattr(compile_unit, "announced", interrupted)
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with pytest.raises(KeyboardInterrupt):
            kernel(0.5, 1)
    finally:
        signal.signal(signal.SIGINT, before)
    assert len(kernel.overloads) == 1
    assert kernel(0.5, 1) == 1.125


def test_a_part_is_translated_once_and_never_made_machine_code() -> None:
    """Of functions that are not kept on disk, from where they would come whole."""
    inner = Kernel(cubed, targetoptions={"nopython": True})

    def thrice(x):  # type: ignore[no-untyped-def]
        return inner(x, 0) + inner(x, 7) + inner(x, 9)

    outer = Kernel(thrice, targetoptions={"nopython": True})
    assert outer(0.5) == 3 * 0.125 + 16.0
    # Three calls with three whole numbers.
    (result,) = inner._part.overloads.values()
    assert isinstance(result.library, _PartLibrary)
    assert not result.library.codegen._engine.is_symbol_defined(result.fndesc.mangled_name)
    # Nothing that Python could call was made of it, until Python calls it.
    assert not inner.overloads
    assert inner(0.5, 1) == 1.125
    assert len(inner.overloads) == 1


def none_above(values):  # type: ignore[no-untyped-def]
    count = 0
    for i in range(values.size):
        if values[i] > 0.0:
            count += 1
    return count == 0


def test_a_counter_is_no_written_number_for_good(monkeypatch: pytest.MonkeyPatch) -> None:
    """Also where this comparison is the first one that is compiled in the process.

    Numba first takes the counter for the number 0, and compares that with 0 once and for all; of
    centroids whose kernel was compiled first that made NaN.
    """
    monkeypatch.setattr(compile_unit, "_SIGNATURES", {})
    options = {"nopython": True, "error_model": "numpy"}
    for values in (np.array([1.0, -2.0]), np.array([-1.0])):
        kernel = Kernel(none_above, targetoptions=options)
        assert kernel(values) == none_above(values)


def test_parts_raise() -> None:
    assert root_of_all(np.array([4.0, 9.0])) == 5.0
    with pytest.raises(ValueError, match="below zero"):
        root_of_all(np.array([4.0, -9.0]))


def test_functions_that_numba_compiles_by_itself_call_them() -> None:
    assert numba.njit(lambda values: 2.0 * twice(values))(VALUES) == 2.0 * twice(VALUES)


def test_scalar_functions_make_no_arrays() -> None:
    @scalar
    def makes(n):  # type: ignore[no-untyped-def]
        return np.zeros(n)

    with pytest.raises(NumbaError, match="Only accept returning of array"):
        makes(3)


def test_they_are_pickled() -> None:
    assert pickle.loads(pickle.dumps(twice))(VALUES) == twice(VALUES)


def test_another_process_loads_what_one_has_compiled(tmp_path: Path) -> None:
    """Parts are in the file of the function that was called, with what they raise."""
    (tmp_path / "kept.py").write_text(
        "from fuzzy2.support.compiled import compiled\n"
        "@compiled\ndef inner(x):\n"
        "    if x < 0.0:\n        raise ValueError('below zero')\n    return x + 1.0\n"
        "@compiled\ndef outer(x):\n    return 2.0 * inner(x)\n"
        "print(outer(2.0), sum(outer.stats.cache_hits.values()))\n"
        "try:\n    outer(-1.0)\nexcept ValueError as error:\n    print(error)\n"
    )
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    for hits in (0, 1):
        done = subprocess.run(
            [sys.executable, tmp_path / "kept.py"],
            capture_output=True,
            text=True,
            check=True,
            env={**environment, "PYTHONPATH": os.pathsep.join(map(str, sys.path))},
        )
        assert done.stdout.split("\n")[:2] == [f"6.0 {hits}", "below zero"]
