"""Checks of arguments that every module shares.

A real number in its range, or an error that says which.
"""

from __future__ import annotations

import itertools
import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fuzzy2.errors import InvalidValue

Array = NDArray[np.float64]


def real(name: str, value: object, requirement: str = "a finite number") -> float:
    """Return ``value`` as a float.

    Raise :class:`InvalidValue` if it is not a finite real number.
    """
    number = maybe_infinite(name, value, requirement)
    if math.isinf(number):
        raise InvalidValue(name, value, requirement)
    return number


def maybe_infinite(name: str, value: object, requirement: str = "a number") -> float:
    """Return ``value`` as a float that may be infinite.

    Raise :class:`InvalidValue` if it is not a real number.
    """
    if isinstance(value, str | bytes | bool | np.bool_):
        raise InvalidValue(name, value, requirement)
    try:
        number = float(value)  # type: ignore[arg-type] # whatever has no float is refused below
    except (TypeError, ValueError, OverflowError) as error:
        raise InvalidValue(name, value, requirement) from error
    if math.isnan(number):
        raise InvalidValue(name, value, requirement)
    return number


def positive(name: str, value: object) -> float:
    """Return ``value`` as a float.

    Raise :class:`InvalidValue` if it is not a finite number above 0.
    """
    number = real(name, value, "a finite number above 0")
    if number <= 0.0:
        raise InvalidValue(name, value, "a finite number above 0")
    return number


def grade(name: str, value: object) -> float:
    """Return ``value`` as a float; raise :class:`InvalidValue` if it is not in (0, 1]."""
    number = real(name, value, "above 0 and at most 1")
    if not 0.0 < number <= 1.0:
        raise InvalidValue(name, value, "above 0 and at most 1")
    return number


def ascending(name: str, values: tuple[float, ...]) -> None:
    """Raise :class:`InvalidValue` if a value is smaller than the one before it."""
    if any(after < before for before, after in itertools.pairwise(values)):
        raise InvalidValue(name, values, "in ascending order")


def reals(name: str, values: ArrayLike) -> Array:
    """Return ``values`` as an array of floats, which may be NaN.

    Raise :class:`InvalidValue` if they are not real numbers, or some of them are masked: what is
    under a mask is not meant to be computed with.
    """
    if isinstance(values, np.ma.MaskedArray):
        raise InvalidValue(name, values, "real numbers without a mask, such as values.filled(0.0)")
    try:
        array = np.asarray(values)
        # Of objects text would be read, which as an array of text is refused.
        if array.dtype.kind in "fiub" or (
            array.dtype.kind == "O"
            and not any(isinstance(value, str | bytes) for value in array.flat)
        ):
            return np.asarray(array, dtype=np.float64)
    except (TypeError, ValueError, OverflowError) as error:
        raise InvalidValue(name, values, "real numbers") from error
    raise InvalidValue(name, values, "real numbers")


def binary_exponent(values: Array) -> int:
    """Return n for which values divided by :math:`2^n` can be squared and added up.

    It is 0 unless the greatest is so large or small that squares leave the range of floats, so that
    ordinary results do not change by scaling.
    """
    greatest = float(np.max(np.abs(values), initial=0.0))
    exponent = math.frexp(greatest)[1] - 1
    return exponent if math.isfinite(greatest) and abs(exponent) > 400 else 0


def ascending_pair(name: str, values: ArrayLike) -> tuple[float, float]:
    """Return two finite numbers in ascending order; raise :class:`InvalidValue` if they are not."""
    pair = reals(name, values)
    if pair.shape != (2,) or not np.isfinite(pair).all() or pair[0] > pair[1]:
        raise InvalidValue(name, values, "two finite numbers in ascending order")
    return float(pair[0]), float(pair[1])
