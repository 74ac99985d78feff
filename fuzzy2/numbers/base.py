"""Common base of the kinds of fuzzy numbers: crisp operands and checks."""

from __future__ import annotations

from typing import Any, Literal

from fuzzy2.errors import InvalidValue
from fuzzy2.support.checks import Array, broadcast, real, reals

NumberTNorm = Literal["product", "min"]


class Number:
    """Common base of the kinds of fuzzy numbers, which distinguishes them from crisp operands."""

    # NumPy then leaves `array + number` and `array @ number` to the reflected methods of the
    # number.
    __array_ufunc__ = None


def crisp_operand(value: object) -> Array | None:
    """Return a crisp operand as an array, or None if it is not one."""
    if isinstance(value, Number):
        return None
    try:
        return reals("a crisp number", value)  # type: ignore[arg-type] # others are refused there
    except InvalidValue:
        return None


def fields_of_one_shape(names: tuple[str, str], location: Any, width: Any) -> tuple[Array, Array]:
    """Return both fields of fuzzy numbers with a common shape; widths must not be negative.

    NaN is accepted, because systems return it where no rule fires.
    """
    centers, widths = broadcast(
        " and ".join(names), reals(names[0], location), reals(names[1], width)
    )
    if (widths < 0.0).any():
        raise InvalidValue(names[1], widths, "at least 0")
    return centers, widths


def checked_level(alpha: float) -> float:
    """Return a level of α-cuts, which must be above 0 and at most 1."""
    requirement = "a level above 0 and at most 1"
    level = real("alpha", alpha, requirement)
    if not 0.0 < level <= 1.0:
        raise InvalidValue("alpha", alpha, requirement)
    return level
