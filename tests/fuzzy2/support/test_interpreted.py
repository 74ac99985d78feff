"""Compiled functions run by Python itself, with the same bits and nothing compiled."""

from __future__ import annotations

import math
import sys

import numpy as np
from numpy.testing import assert_array_equal

from fuzzy2.support.compiled import compiled, scalar
from fuzzy2.support.interpreted import are_few_calls, few_calls, is_ready, twin_of, twins_of

SCALE = 3.0


@scalar
def inner(x):
    return math.sqrt(x) / SCALE


@compiled
def outer(values, out):
    for i in range(values.size):
        out[i] = 1.0 / inner(values[i]) + values[i] * values[i]


def test_a_twin_has_the_bits_of_compiled_code_and_compiles_nothing() -> None:
    """Where Python alone would raise, too: a division by zero, a root of a negative number."""
    values = np.array([0.0, -1.0, 2.0, 1e308, math.inf, math.nan])
    found, expected = np.empty(6), np.empty(6)
    assert not is_ready(outer)
    twin_of(outer)(values, found)
    assert not is_ready(outer)
    assert not is_ready(inner)
    outer(values, expected)
    assert is_ready(outer)
    # Which of the many NaN it is the processor may choose.
    assert np.isnan(found[[1, 5]]).all()
    assert_array_equal(found, expected)
    assert_array_equal(np.signbit(found[[0, 2, 3, 4]]), np.signbit(expected[[0, 2, 3, 4]]))


def test_twins_of_a_module_are_those_of_its_compiled_functions() -> None:
    twins = vars(twins_of(sys.modules[__name__]))
    assert set(twins) == {"inner", "outer"}
    assert twins["inner"](9.0) == 1.0


def test_few_calls_are_said_for_a_while() -> None:
    assert not are_few_calls()
    with few_calls():
        with few_calls():
            assert are_few_calls()
        assert are_few_calls()
    assert not are_few_calls()
