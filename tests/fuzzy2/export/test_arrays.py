"""Arrays and their parts in C: entries, rows, slices, sizes and memory."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest

from fuzzy2.errors import NotExportable
from fuzzy2.export.c_code import Argument, CWriter, Known
from tests.fuzzy2.export.in_c import bind, build, kernel_in_c, needs_gcc, same_as_python

pytestmark = needs_gcc


def parts(x, out):
    out[:2] = x[1:3]
    out[2:] = 0.5
    out[3] = x[-1] + len(x) + x.size + x.shape[0]
    table = x.reshape(2, 2)
    out[4], out[5] = table[1, 0], table[-1, -1]
    row = table[1]
    out[6] = row[0] + row.size
    out[0:2] = out[0]
    middle = out[1:4]
    out[7] = middle[1] + middle[:2].size


def memory(x, out):
    room = np.empty(3)
    sums = np.zeros((2, 2))
    for i in range(3):
        room[i] = 2.0 * x[i]
    for i in range(2):
        own = np.zeros(2)
        own[i] += room[i]
        sums[i] = own
    out[0], out[1], out[2] = room[2], sums[0, 0] + sums[1, 0], sums[1, 1]


class Tables(NamedTuple):
    """Two tables, and a number."""

    numbers: np.ndarray
    places: np.ndarray
    scale: float


def looked_up(tables, x, out):
    for i in range(out.size):
        out[i] = tables.scale * tables.numbers[tables.places[i]] * x[0]
    first = tables.numbers[1:3]
    if x[0] > 0.0:
        first = tables.numbers[0:2]
    out[0] += first[1]


def of_unknown_size(x, out):
    out[0] = np.empty(int(x[0]))[0]


def every_second(x, out):
    out[0] = x[::2][1]


def by_a_number(x, out):
    out[0] = x[x[0]]


def test_parts(tmp_path):
    same_as_python(parts, [(1.0, 2.0, 3.0, 4.0), (-1.0, 0.5, 0.25, 9.0)], 8, tmp_path)


def test_memory_is_of_the_function_and_zeros_are_zeros_each_time(tmp_path):
    code = same_as_python(memory, [(1.0, 2.0, 3.0)], 3, tmp_path)
    assert "double memory_1[3];" in code.source


@pytest.mark.parametrize("x", [2.0, -2.0])
def test_tables_are_constants(x, tmp_path):
    tables = Tables(np.array([1.5, np.inf, -0.0, 2.0]), np.array([3, 0, 2]), 0.5)
    writer = CWriter("tried", "double", ["A table."])
    arguments = [Known("tables", tables), Argument("x", "in", 1), Argument("out", "out", 3, "out")]
    function = writer.add("run", "Run.", looked_up, arguments)
    code = writer.code()
    out, right = np.zeros(3), np.zeros(3)
    bind(build(code, tmp_path), code, function)(np.array([x]), out)
    looked_up(tables, np.array([x]), right)
    assert out.tobytes() == right.tobytes()
    assert "static const double tried_tables_numbers[4]" in code.source
    assert "static const int tried_tables_places[3]" in code.source


@pytest.mark.parametrize(
    ("kernel", "why"),
    [
        (of_unknown_size, "the size of memory must be known"),
        (every_second, "no step"),
        (by_a_number, "must be a whole number"),
    ],
)
def test_what_is_refused(kernel, why, tmp_path):
    with pytest.raises(NotExportable, match=why):
        kernel_in_c(kernel, 4, 1, tmp_path)


class Coded(NamedTuple):
    """Whole numbers and truths."""

    codes: np.ndarray
    most: int


def decoded(coded, x, out):
    for i in range(coded.codes.size):
        out[0] += coded.codes[i] * x[0]


def coded_in_c(coded, folder):
    writer = CWriter("coded", "double", ["Codes."])
    arguments = [Known("coded", coded), Argument("x", "in", 1), Argument("out", "out", 1, "out")]
    function = writer.add("run", "Run.", decoded, arguments)
    code = writer.code()
    return bind(build(code, folder), code, function)


def test_truths_are_whole_numbers(tmp_path):
    out = np.zeros(1)
    coded_in_c(Coded(np.array([True, False, True]), 1), tmp_path)(np.array([1.5]), out)
    assert out[0] == 3.0


@pytest.mark.parametrize(
    ("codes", "most", "named"),
    [([1, -(2**31)], 1, "coded_codes"), ([2**40], 1, "coded_codes"), ([1], 2**31, "coded_most")],
)
def test_numbers_of_more_than_31_bits_are_refused_by_name(codes, most, named, tmp_path):
    with pytest.raises(NotExportable, match=f"{named}.*31 bits"):
        coded_in_c(Coded(np.array(codes), most), tmp_path)
