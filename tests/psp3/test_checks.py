"""Checks of arguments: what passes comes back as numbers, what does not is named."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import psp3
from psp3.checks import checked_finite, finite_array, together
from psp3.errors import InvalidArray, InvalidValue


@pytest.mark.parametrize("value", [2, -1.5, np.float32(0.5), np.int64(3), 0.0])
def test_a_finite_number_comes_back_as_a_float(value: Any) -> None:
    number = checked_finite("rise", value)
    assert type(number) is float
    assert number == value


@pytest.mark.parametrize(
    "value", [math.nan, math.inf, -math.inf, "fast", None, [1.0, 2.0], 1j, True, 10**400]
)
def test_what_is_no_finite_number_is_refused(value: Any) -> None:
    with pytest.raises(InvalidValue, match=r"^rise must be a finite number, got"):
        checked_finite("rise", value)


@pytest.mark.parametrize("values", [3, [1, 2], [[0.5], [1.5]], np.zeros((2, 0, 3))])
def test_finite_numbers_keep_their_shape(values: Any) -> None:
    array = finite_array("t", values)
    assert (array.shape, array.dtype) == (np.shape(values), np.float64)
    np.testing.assert_array_equal(array, values)


@pytest.mark.parametrize(
    "values", [math.nan, [0.0, math.inf], "now", ["1", "2"], [[1.0], [1.0, 2.0]], [1j]]
)
def test_arrays_that_are_not_finite_numbers_are_refused(values: Any) -> None:
    with pytest.raises(InvalidArray, match=r"^t must be finite numbers of shape \(\.\.\.,\), got"):
        finite_array("t", values)


def test_a_row_that_is_repeated_stands_row_by_row() -> None:
    """Compiled code takes each row as it stands in memory."""
    many, one = together(positions=np.zeros((5, 3)), speeds=np.arange(3.0))
    assert one.flags.c_contiguous
    assert one.flags.writeable
    np.testing.assert_array_equal(one, [[0.0, 1.0, 2.0]] * len(many))


@pytest.mark.parametrize("count", [1, 64, 65, 449, 1601])
def test_a_batch_of_any_length_is_answered_with_one_row_for_all(count: int) -> None:
    """A last row of its own was refused with a TypeError where threads shared the others."""
    robot = psp3.load("five_bar")
    rows = np.tile(robot.reference, (count, 1))
    many = robot.inverse_dynamics(rows, np.ones(2), np.zeros(2))
    alone = robot.inverse_dynamics(robot.reference, np.ones(2), np.zeros(2))
    np.testing.assert_array_equal(many, np.tile(alone, (count, 1)))
