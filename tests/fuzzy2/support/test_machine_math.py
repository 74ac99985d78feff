"""Functions of ``math`` as compiled code has them."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from fuzzy2.support import machine_math
from fuzzy2.support.compiled import compiled

VALUES = [-math.inf, -2.5, -0.0, 0.0, 1e-300, 0.7, 1e200, math.inf, math.nan]


@compiled
def of_one(x, out):
    out[0], out[1], out[2] = math.sqrt(x), math.sin(x), math.cos(x)
    out[3], out[4] = math.tan(x), math.atan(x)


@compiled
def of_two(x, y, out):
    out[0], out[1] = math.atan2(x, y), math.hypot(x, y)


@pytest.mark.parametrize("x", VALUES)
def test_every_number_has_the_answer_of_compiled_code(x: float) -> None:
    """To the last bit, also where Python's own raise an error."""
    functions = ("sqrt", "sin", "cos", "tan", "atan")
    expected = np.empty(5)
    of_one(x, expected)
    assert_array_equal([getattr(machine_math, name)(x) for name in functions], expected)
    rng = np.random.default_rng(0)
    for y in [*VALUES, *rng.normal(size=20)]:
        expected = np.empty(2)
        of_two(x, y, expected)
        assert_array_equal([machine_math.atan2(x, y), machine_math.hypot(x, y)], expected)


def test_answers_can_be_divided_by_zero() -> None:
    with np.errstate(divide="ignore"):
        assert 1.0 / machine_math.sqrt(0.0) == math.inf
