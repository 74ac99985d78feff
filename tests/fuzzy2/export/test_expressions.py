"""Expressions mean in C what they mean in Python, to the last bit and the sign of zero."""

from __future__ import annotations

import itertools
import math
import re

import numpy as np
import pytest
from numba import njit

from fuzzy2.errors import NotExportable
from tests.fuzzy2.export.in_c import kernel_in_c, needs_gcc, same_as_python

SPECIAL = [0.0, -0.0, 1.0, -1.0, 2.5, -2.5, math.nan, math.inf, -math.inf, 1e308, 5e-324]
PAIRS = list(itertools.product(SPECIAL, SPECIAL))
WHOLE = [(a, b) for a in range(-7, 8) for b in (-3, -2, -1, 1, 2, 3, 7)]

pytestmark = needs_gcc


def extremes(x, out):
    out[0], out[1] = min(x[0], x[1]), max(x[0], x[1])
    out[2], out[3] = min(x[1], x[0], 1.0), max(0.0, x[0], x[1])
    out[4] = min(3, max(0 if math.isnan(x[0]) or math.isinf(x[0]) else 7, 2))


def comparisons(x, out):
    out[0] = 1.0 if x[0] < x[1] else 0.0
    out[1] = float(x[0] <= x[1]) + 2.0 * float(x[0] > x[1]) + 4.0 * float(x[0] >= x[1])
    out[2] = float(x[0] == x[1]) + 2.0 * float(x[0] != x[1])
    out[3] = float(-1.0 < x[0] <= x[1] < 3.0)
    out[4] = float(not x[0] < x[1])
    out[5] = float((x[0] < x[1] and x[1] > 0.0) or x[0] == 0.0)


def arithmetic(x, out):
    out[0], out[1], out[2] = x[0] + x[1], x[0] - x[1], x[0] * x[1]
    out[3] = -x[0] - (-x[1])
    out[4] = x[0] + 0
    out[5] = x[0] * 1
    out[6] = abs(x[0]) - abs(x[1])


def quotients(x, out):
    out[0] = x[0] / x[1]
    out[1] = 1 / x[1]


def powers(x, out):
    out[0], out[1], out[2] = x[0] ** 2, x[0] ** 3, x[0] ** 7
    out[3] = (x[0] + 1.0) ** 5
    out[4] = x[0] ** 0
    out[5] = 2**5


def whole_numbers(x, out):
    a, b = int(x[0]), int(x[1])
    out[0], out[1] = a // b, a % b
    out[2], out[3] = -7 // 2, -7 % 3
    out[4] = a * b - (a + b) * 2
    out[5] = a / b
    out[6] = (a - b) - (b - a)
    out[7] = float(a in (1, 2, 5)) + 2.0 * float(a not in (1, 2))


def functions(x, out):
    out[0] = math.sqrt(x[0]) + math.exp(-x[1])
    out[1] = math.sin(x[0]) * math.cos(x[1]) + math.atan2(x[0], x[1])
    out[2] = math.hypot(x[0], x[1]) + math.copysign(1.0, x[1])
    out[3] = float(math.isfinite(x[0])) + 2.0 * float(math.isnan(x[1]))
    out[4] = math.log(x[0]) + math.pi + math.tanh(x[1]) + x[0] ** x[1]
    out[5] = math.floor(x[0] * 3.0) + 0.0


def test_extremes(tmp_path):
    same_as_python(extremes, PAIRS, 5, tmp_path)


def test_comparisons(tmp_path):
    same_as_python(comparisons, PAIRS, 6, tmp_path)


def test_arithmetic(tmp_path):
    same_as_python(arithmetic, PAIRS, 7, tmp_path)


def test_quotients_divide_as_ieee_754_does(tmp_path):
    run, _ = kernel_in_c(quotients, 2, 2, tmp_path)
    for a, b in PAIRS:
        out, right = np.zeros(2), np.zeros(2)
        run(np.array([a, b]), out)
        with np.errstate(all="ignore"):
            right[:] = np.float64(a) / np.float64(b), 1.0 / np.float64(b)
        np.testing.assert_array_equal(out, right)
        assert (np.signbit(out) == np.signbit(right))[~np.isnan(out)].all()


def test_powers(tmp_path):
    # Numba multiplies by squares, Python calls pow: the code is that of the compiled kernel.
    run, _ = kernel_in_c(powers, 2, 6, tmp_path)
    compiled = njit(powers)
    for x in np.random.default_rng(0).normal(size=(200, 2)) * 3.0:
        out, right = np.zeros(6), np.zeros(6)
        run(x.copy(), out)
        compiled(x.copy(), right)
        assert out.tobytes() == right.tobytes()


def test_a_negative_exponent_is_the_reciprocal(tmp_path):
    def inverse(x, out):
        out[0] = x[0] ** -2

    run, _ = kernel_in_c(inverse, 1, 1, tmp_path)
    out = np.zeros(1)
    run(np.array([3.0]), out)
    assert out[0] == 1.0 / 9.0


def test_whole_numbers(tmp_path):
    same_as_python(whole_numbers, WHOLE, 8, tmp_path)


def test_functions(tmp_path):
    rows = np.random.default_rng(1).uniform(0.1, 3.0, (200, 2))
    same_as_python(functions, rows, 6, tmp_path)


def test_no_brackets_of_other_signs(tmp_path):
    def nested(x, out):
        out[0] = x[0] - (x[1] - (x[0] / (x[1] / x[0]))) - (-x[1])

    same_as_python(nested, [(2.0, 3.0), (-1.5, 0.25)], 1, tmp_path)


def of_text(x, out):
    out[0] = 0.0 if "a" == "b" else 1.0


def of_arrays(x, out):
    out[0] = x + x


def of_values(x, out):
    out[0] = x[0] or 1.0


def of_chains(x, out):
    out[0] = float(0.0 < math.sqrt(x[0]) < 1.0)


def of_unknown_powers(x, out):
    out[0] = x[0] ** int(x[1])


@pytest.mark.parametrize("kernel", [of_text, of_arrays, of_values, of_chains, of_unknown_powers])
def test_what_is_refused_is_named_by_file_and_line(kernel, tmp_path):
    with pytest.raises(NotExportable) as error:
        kernel_in_c(kernel, 2, 1, tmp_path)
    line = kernel.__code__.co_firstlineno + 1
    assert re.search(
        rf"test_expressions\.py, line {line}, in {kernel.__name__}: ", str(error.value)
    )
    assert "docs/concepts/kernels.md" in str(error.value)
