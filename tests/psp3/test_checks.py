"""Checks of arguments: what passes comes back as numbers, what does not is named."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from psp3.checks import checked_finite, finite_array
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
