"""Plain operations that are written down directly: the answers are those of numba.

Each function is compiled by numba alone, too, and the answers are compared to the last bit.
"""

from __future__ import annotations

import math
import operator
import re
from collections.abc import Callable
from typing import Any

import numba
import numpy as np
import pytest
from numpy.testing import assert_array_equal

from fuzzy2.support.compile_unit import Kernel
from fuzzy2.support.compiled import compiled
from fuzzy2.support.plain_lowering import PLAIN


def fresh(function: Callable[..., Any], scalar: bool) -> Callable[..., Any]:
    """Compile as ``scalar`` or ``compiled`` do, with nothing from the disk: there one is kept."""
    options = {"nopython": True, "error_model": "numpy"}
    return Kernel(function, targetoptions=options, twice=not scalar, scalar=scalar)


NUMBERS = [0.0, -0.0, 1.5, -2.25, 1e308, math.inf, -math.inf, math.nan, 3, 0, -7, 2**62, True]
ROUNDED = [0.1, 3.7, -2.2, 5.0, -1.4]


def combine(x, y):  # type: ignore[no-untyped-def]
    return x + y, x - y, x * y, x / y


def compare(x, y):  # type: ignore[no-untyped-def]
    return x < y, x <= y, x > y, x >= y, x == y, x != y


def with_constants(x, y):  # type: ignore[no-untyped-def]
    total = x + 2
    total *= 0.5
    total -= y * 3 - 1
    return total, 2 * x, x / 3, 1.0 - y, x > 0, y == 1


@pytest.mark.parametrize("function", [combine, compare, with_constants])
@pytest.mark.parametrize("scalar", [False, True])
def test_numbers_are_combined_as_by_numba(function: Callable[..., Any], scalar: bool) -> None:
    """Of all pairs of kinds: not a number, infinite, whole, too large, and truth values."""
    ours, theirs = fresh(function, scalar), numba.njit(error_model="numpy")(function)
    for x in NUMBERS:
        for y in NUMBERS:
            found, expected = ours(x, y), theirs(x, y)
            assert list(map(type, found)) == list(map(type, expected))
            assert_array_equal(np.array(found), np.array(expected), err_msg=f"{x}, {y}")
            # Zero has a sign.
            assert_array_equal(np.signbit(found), np.signbit(expected), err_msg=f"{x}, {y}")


def test_all_operations_that_are_written_down_are_tested() -> None:
    plain = {
        *(operator.add, operator.sub, operator.mul, operator.truediv),
        *(operator.lt, operator.le, operator.gt, operator.ge, operator.eq, operator.ne),
        *(operator.getitem, operator.setitem),
    }
    assert plain == PLAIN


def test_division_by_zero_is_an_error_where_the_function_says_so() -> None:
    divides = Kernel(lambda x, y: x / y, targetoptions={"nopython": True})
    assert divides(1.0, 4.0) == 0.25
    with pytest.raises(ZeroDivisionError):
        divides(1.0, 0.0)


def shuffle(values, places):  # type: ignore[no-untyped-def]
    """Read and write at indices from arrays, sums, constants and loops."""
    for i in range(places.shape[0]):
        k = places[i]
        values[k] = values[k] + 2 * values[i]
        places[i] = k + 1
    values[0] = places[1]
    values[1] = 7
    return values[values.shape[0] - 1]


@pytest.mark.parametrize("scalar", [False, True])
@pytest.mark.parametrize("kind", [np.float64, np.int64, np.float32])
def test_entries_are_read_and_written_as_by_numba(scalar: bool, kind: Any) -> None:
    ours, theirs = fresh(shuffle, scalar), numba.njit(shuffle)
    found, expected = (np.array(ROUNDED).astype(kind) for _ in range(2))
    places, others = (np.array([3, 0, 4, 3]) for _ in range(2))
    assert ours(found, places) == theirs(expected, others)
    assert_array_equal(found, expected)
    assert_array_equal(places, others)


def test_indices_count_from_the_end() -> None:
    """In functions that are not said to keep to what can be written in C."""

    @compiled
    def last_of(values, count):  # type: ignore[no-untyped-def]
        values[-2] = 5.0
        return values[-1] + values[-count]

    values = np.array([1.0, 2.0, 3.0])
    assert last_of(values, 3) == 4.0
    assert_array_equal(values, [1.0, 5.0, 3.0])


def test_every_second_entry_and_tables_go_numbas_way() -> None:
    @compiled
    def first_and_last(values, table):  # type: ignore[no-untyped-def]
        values[1] = table[1, 0]
        return values[0] + values[values.shape[0] - 1]

    entries = np.arange(6.0)
    assert first_and_last(entries[::2], np.array([[7.0], [9.0]])) == 4.0
    assert_array_equal(entries, [0, 1, 9, 3, 4, 5])


def test_an_argument_that_is_given_another_array_is_that_array() -> None:
    @compiled
    def switched(values, others, is_other):  # type: ignore[no-untyped-def]
        before = values[0]
        if is_other:
            values = others
        values[1] = 10.0
        return before + values[0]

    one, two = np.array([1.0, 2.0]), np.array([100.0, 200.0])
    assert switched(one, two, False) == 2.0
    assert switched(one, two, True) == 101.0
    assert_array_equal([one, two], [[1.0, 10.0], [100.0, 10.0]])


def add_entry(tree, values, out):  # type: ignore[no-untyped-def]
    for i in range(values.shape[0]):
        out[tree[0] + i] = values[i] + tree[1]


def test_scalar_functions_read_tables_of_whole_numbers_once() -> None:
    """What is written to an array of other numbers cannot have changed them."""
    counts = []
    for is_scalar in (True, False):
        kernel, out = fresh(add_entry, is_scalar), np.zeros(6)
        kernel(np.array([2, 10]), np.arange(3.0), out)
        assert_array_equal(out, [0, 0, 10, 11, 12, 0])
        (code,) = kernel.inspect_llvm().values()  # type: ignore[attr-defined]
        blocks = re.split(r"\n(?=\w[\w.]*:)", code)
        counts.append(min(one.count("load i64") for one in blocks if "fadd double" in one))
    assert counts == [0, 2]


def test_loops_over_rows_may_use_the_longest_vectors() -> None:
    """As the compiler is told by an attribute of the function."""
    found = []
    for is_scalar in (True, False):
        kernel = fresh(lambda values: values[0], is_scalar)
        kernel(np.zeros(1))
        (code,) = kernel.inspect_llvm().values()  # type: ignore[attr-defined]
        found.append('"prefer-vector-width"="512"' in code)
    assert found == [False, True]
