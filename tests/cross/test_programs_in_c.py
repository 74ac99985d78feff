"""Programs of chance in the subset do in C what numba's code does, to the last bit.

Each example is a file of many kernels' worth of expressions or statements, compiled once by gcc and
once by numba, and run for rows of numbers that are hard: zeros of both signs, NaN, infinities, the
largest and the smallest number, and whole numbers of 31 bits.
"""

from __future__ import annotations

import importlib.util
import itertools
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st
from numba import njit

from tests.fuzzy2.export.in_c import kernel_in_c, needs_gcc

pytestmark = needs_gcc

SPECIAL = [0.0, -0.0, 1.0, -1.0, 2.5, -0.5, math.nan, math.inf, -math.inf, 1.7e308, 5e-324, 1e-9]
GREATEST = 2**31 - 1
WHOLE = [(0, 0), (7, -3), (-7, 3), (-7, -2), (6, 2), (GREATEST, -1), (-GREATEST, 7), (1, GREATEST)]
ROWS = [
    (*reals, *whole)
    for reals, whole in zip(
        [*itertools.product(SPECIAL, SPECIAL), (0.3, -1.7), (1e5, 3.0)],
        itertools.cycle(WHOLE),
        strict=False,
    )
]
OUTPUTS = 40

counts = itertools.count()


REAL, ROUNDED = st.sampled_from(["a", "b"]), st.sampled_from(["int", "round"])
# Numba computes with what is written down, and does not divide by a zero that is.
DIVISOR = st.sampled_from(["i", "j", "k", "n", "3", "-2", "(k - n)"])
FLOORED = st.sampled_from(["floor", "ceil"])

QUICK = settings(max_examples=8, phases=[Phase.explicit, Phase.generate])
"""To make an example smaller takes minutes of compilers; what fails says its line and numbers."""


# ---------------------------------------------------------------------------------- expressions
def whole_numbers(depth: int) -> st.SearchStrategy[str]:
    """Return expressions of whole numbers; i and j are of at most 31 bits, k and n are small."""
    if depth == 0:
        return st.sampled_from(["i", "j", "k", "n", "0", "1", "-3", "7", "2147483647"])
    one, truth = whole_numbers(depth - 1), truths(depth - 1)
    small = st.sampled_from(["k", "n", "2", "-5"])
    return st.one_of(
        st.builds("({} + {})".format, small, small),
        st.builds("({} - {} * {})".format, small, small, small),
        st.builds("({} {} {})".format, one, st.sampled_from(["//", "%"]), DIVISOR),
        st.builds("(-{})".format, one),
        st.builds("abs({})".format, one),
        st.builds("min({}, {})".format, one, one),
        st.builds("max({}, {}, {})".format, one, one, one),
        st.builds("({} if {} else {})".format, one, truth, one),
        st.builds("({0}({1}) if -9.0 < {1} < 9.0 else 2)".format, ROUNDED, REAL),
        st.builds("shape[{}]".format, st.sampled_from(["0", "1", "-1"])),
        st.sampled_from(["len(w)", "w.size", "table.shape[1]", "(2 ** 5)"]),
    )


def reals(depth: int) -> st.SearchStrategy[str]:
    """Return expressions of real numbers."""
    if depth == 0:
        return st.sampled_from(
            [
                "a",
                "b",
                "0.5",
                "-1.5",
                "0.0",
                "1e300",
                "math.inf",
                "math.nan",
                "math.pi",
                "w[k%3]",
                "table[1,n%2]",
                "part[1]",
                "row[-1]",
            ]
        )
    one, whole = reals(depth - 1), whole_numbers(depth - 1)
    either = st.one_of(one, whole)
    of_one = st.sampled_from(
        [
            "sqrt",
            "exp",
            "expm1",
            "log",
            "log1p",
            "sin",
            "cos",
            "tan",
            "asin",
            "acos",
            "atan",
            "sinh",
            "cosh",
            "tanh",
            "fabs",
        ]
    )
    # Of 0 to a negative whole power numba makes an error, and C infinity.
    of_two = st.sampled_from(["atan2", "hypot", "pow"])
    return st.one_of(
        st.builds("({} {} {})".format, one, st.sampled_from("+-*"), either),
        st.builds("({} / {})".format, either, DIVISOR),
        st.builds("({} / ({} + a))".format, either, either),
        st.builds("(-{})".format, one),
        st.builds("(+{})".format, one),
        st.builds("abs({})".format, one),
        st.builds("float({})".format, either),
        st.builds("min({}, {})".format, one, either),
        st.builds("max({}, {}, {})".format, one, one, one),
        st.builds("({} if {} else {})".format, one, truths(depth - 1), either),
        st.builds("(({} - b) ** {})".format, one, st.sampled_from(["2", "3", "5", "0.5", "b"])),
        st.builds("math.{}({})".format, of_one, one),
        st.builds("math.{}({}, {})".format, of_two, one, one),
        # Nobody says which sign a NaN has that was computed.
        st.builds("math.copysign({}, x[{}])".format, one, st.sampled_from("01")),
        st.builds("(math.{0}({1}) if -1e9 < {1} < 1e9 else 0.5)".format, FLOORED, REAL),
        st.builds("pair({}, {})[{}]".format, one, one, st.sampled_from("01")),
    )


def truths(depth: int) -> st.SearchStrategy[str]:
    """Return comparisons and what is made of them."""
    one, whole = reals(max(depth - 1, 0)), whole_numbers(max(depth - 1, 0))
    sign = st.sampled_from(["<", "<=", ">", ">=", "==", "!="])
    plain = st.one_of(
        st.builds("({} {} {})".format, one, sign, st.one_of(one, whole)),
        st.builds("({} {} {})".format, whole, sign, whole),
        st.builds("(-1.0 {} b {} {})".format, sign, sign, st.sampled_from(["a", "k", "3"])),
        st.builds("(k in (1, {}, n))".format, st.sampled_from("02")),
        st.builds("(n not in (0, {}))".format, st.sampled_from("12")),
        st.builds("math.{}({})".format, st.sampled_from(["isnan", "isinf", "isfinite"]), one),
        st.builds("bool({})".format, st.one_of(one, whole)),
    )
    if depth == 0:
        return plain
    less = truths(depth - 1)
    return st.one_of(
        plain,
        st.builds("({} and {})".format, less, less),
        st.builds("({} or {})".format, less, less),
        st.builds("(not {})".format, less),
    )


HEAD = '''"""Of chance."""
import math

import numpy as np


def pair(a, b):
    """Return a sum and the lesser."""
    return a + b, min(a, b)


def chance(x, out):
    """Be run."""
    a, b, i, j = x[0], x[1], int(x[2]), int(x[3])
    k, n = i % 5 - 2, j % 4
    memory = np.zeros(8)
    w, table = memory[:4], memory[2:].reshape(3, 2)
    for m in range(8):
        memory[m] = (a if m % 2 == 0 else b) * (m - 3)
    part, row, shape = w[1:4], table[2], table.shape
'''


def module_of(text: str, folder: Path) -> Any:
    """Return a module with a text, of a name of its own."""
    name = f"of_chance_{next(counts)}"
    path = folder / f"{name}.py"
    path.write_text(text, encoding="utf-8")
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    module.pair = njit(error_model="numpy")(module.pair)
    return module


def same_as_numba(text: str, folder: Path) -> None:
    """Check that a kernel does in C, to the last bit, what numba's code does."""
    module = module_of(text, folder)
    here = folder / module.__name__
    here.mkdir()
    # Chance compares numbers with themselves, and asks what it knows. Functions of numbers that are
    # written down are left to the library: gcc's own last digit is another one.
    run, _ = kernel_in_c(module.chance, 4, OUTPUTS, here, ("-w", "-fno-builtin"))
    compiled: Callable[..., Any] = njit(error_model="numpy")(module.chance)
    for values in ROWS:
        in_c, in_numba = np.zeros(OUTPUTS), np.zeros(OUTPUTS)
        row = np.array(values, dtype=float)
        run(row.copy(), in_c)
        compiled(row.copy(), in_numba)
        same = (in_c.view(np.int64) == in_numba.view(np.int64)) | (
            np.isnan(in_c) & np.isnan(in_numba)
        )
        for place in np.flatnonzero(~same):
            line = [one for one in text.splitlines() if f"out[{place}]" in one]
            raise AssertionError((values, line, in_c[place], in_numba[place]))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("chance")


@pytest.mark.slow
@QUICK
@given(
    expressions=st.lists(
        st.one_of(reals(3), whole_numbers(3), truths(2).map("(1.0 if {} else 0.0)".format)),
        min_size=OUTPUTS,
        max_size=OUTPUTS,
    )
)
def test_expressions(expressions: list[str], folder: Path) -> None:
    lines = [f"    out[{place}] = {text}" for place, text in enumerate(expressions)]
    same_as_numba(HEAD + "\n".join(lines) + "\n", folder)


# ----------------------------------------------------------------------------------- statements
def blocks(depth: int, in_loop: bool) -> st.SearchStrategy[list[str]]:
    """Return statements in a row, of variables that all have values."""
    return st.lists(statements(depth, in_loop), min_size=1, max_size=4).map(
        lambda parts: [line for part in parts for line in part]
    )


def indented(lines: list[str]) -> list[str]:
    return [f"    {line}" for line in lines]


def statements(depth: int, in_loop: bool) -> st.SearchStrategy[list[str]]:
    """Return the lines of a statement."""
    real, whole, truth = reals(1), whole_numbers(1), truths(1)
    variable, place = st.sampled_from(["a", "b", "c"]), st.sampled_from(["0", "k % 4", "n", "-1"])
    plain = [
        st.builds("{} = {}".format, variable, real),
        st.builds("{} {} {}".format, variable, st.sampled_from(["+=", "-=", "*="]), real),
        st.builds("k = ({}) % 7 - 3".format, whole),
        st.builds("n = ({}) % 4".format, whole),
        st.builds("a, b = {}, {}".format, real, real),
        st.builds("b, c = pair({}, {})".format, real, real),
        st.builds("{} = {} = {}".format, variable, variable, real),
        st.builds("w[{}] = {}".format, place, real),
        st.builds("w[0], w[{}] = w[{}], {}".format, place, place, real),
        st.builds("table[n % 3, {}] += {}".format, st.sampled_from("01"), real),
        st.builds("part[:] = {}".format, real),
        st.builds("w[:2] = row".format),
        st.builds("part, row = w[{}:], table[n % 3]".format, st.sampled_from("12")),
        st.builds("table = memory[{}:6].reshape({})".format, st.just("0"), st.just("3, 2")),
        st.builds("out[n + {}] = {}".format, st.integers(0, 36).map(str), real),
        st.builds("out[{}] += {}".format, st.integers(0, 39).map(str), st.one_of(real, whole)),
    ]
    if in_loop:
        plain += [
            st.builds("if {}: continue".format, truth),
            st.builds("if {}: break".format, truth),
        ]
    simple = st.one_of(*plain).map(lambda line: [line])
    if depth == 0:
        return simple
    inner, looped = blocks(depth - 1, in_loop), blocks(depth - 1, True)
    bounds = ["k", "n", "k, 5", "k, n, 2", "4, k, -1", "3", "n % 3, 9, 4"]
    return st.one_of(
        simple,
        st.builds(
            lambda test, one, other: [f"if {test}:", *indented(one), "else:", *indented(other)],
            truth,
            inner,
            inner,
        ),
        st.builds(lambda test, one: [f"if {test}:", *indented(one)], truth, inner),
        st.builds(
            lambda name, ends, body: [f"for {name} in range({ends}):", *indented(body)],
            st.sampled_from([f"t{depth}", "k"]),
            st.sampled_from(bounds),
            looped,
        ),
        st.builds(
            lambda test, body: [
                f"left{depth} = 4",
                f"while left{depth} > 0 and {test}:",
                f"    left{depth} -= 1",
                *indented(body),
            ],
            truth,
            looped,
        ),
    )


@st.composite
def programs(draw: st.DrawFn) -> str:
    """Return a program of statements, which tells at the end what its variables are."""
    body = draw(st.lists(statements(2, False), min_size=6, max_size=14))
    lines = ["c = 0.25", *(line for part in body for line in part)]
    lines += [f"out[{at}] = {name}" for at, name in enumerate(["a", "b", "c", "k", "n"])]
    lines += ["for m in range(8):", "    out[5 + m] = memory[m]"]
    lines += ["out[13], out[14] = part[0], row[1]"]
    return HEAD + "\n".join(indented(lines)) + "\n"


@pytest.mark.slow
@QUICK
@given(text=programs())
def test_statements(text: str, folder: Path) -> None:
    same_as_numba(text, folder)
