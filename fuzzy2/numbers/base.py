"""What the kinds of fuzzy numbers share: crisp operands, and checks."""

from __future__ import annotations

from typing import Literal

import numpy as np

from fuzzy2.errors import InvalidValue
from fuzzy2.support.checks import Array

NumberTNorm = Literal["product", "min"]


class Number:
    """Common base of the kinds of fuzzy numbers, by which they are told from crisp operands."""

    # NumPy leaves `array + number` and `array @ number` to the reflected methods of the number.
    __array_ufunc__ = None


def crisp_operand(value: object) -> Array | None:
    """Return a crisp operand as an array, or None if it is not one."""
    if isinstance(value, Number):
        return None
    try:
        array = np.asarray(value)
        return array.astype(float) if array.dtype.kind in "biuf" else None
    except (TypeError, ValueError):
        return None


def checked_level(alpha: float) -> float:
    """Return a level of α-cuts that is above 0 and at most 1; refuse others."""
    if not 0.0 < alpha <= 1.0:
        raise InvalidValue("alpha", alpha, "a level above 0 and at most 1")
    return float(alpha)
