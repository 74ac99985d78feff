"""Numbers in C, in double or single precision."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from fuzzy2.errors import NotExportable
from fuzzy2.export.values import BOOL, INT, REAL, Record, Row, Scalar, Table, Value
from fuzzy2.support.checks import known_name

GREATEST_SINGLE, LEAST_SINGLE = 3.4028234663852886e38, 1.1754943508222875e-38
GREATEST_WHOLE = 2**31 - 1
TOO_LARGE = "a whole number of more than 31 bits"

SINGLE = {"UNION_ROUNDING": 5e-7, "UNION_INSET": 1e-4}
"""Constants of the kernels' modules that have other values in single precision."""


@dataclass(frozen=True)
class Precision:
    """Double or single precision.

    Parameters
    ----------
    name : {"double", "single"}
        Name of the precision.
    """

    name: str

    def __post_init__(self) -> None:
        known_name("precision", self.name, ("double", "single"))

    @property
    def type(self) -> str:
        """The type of a number in C."""
        return "double" if self.name == "double" else "float"

    @property
    def constants(self) -> dict[str, float]:
        """Constants of the kernels' modules, by name, that have other values in this precision."""
        return dict(SINGLE) if self.name == "single" else {}

    def function(self, name: str) -> str:
        """Return the name of a function of ``math.h``."""
        return name if self.name == "double" else name + "f"

    def literal(self, number: float) -> str:
        """Return a number as a C literal that gives back every bit."""
        if math.isnan(number):
            return "NAN"
        if self.name == "single":
            # Smaller and larger numbers do not exist in single precision.
            if 0.0 < abs(number) < LEAST_SINGLE:
                number = math.copysign(LEAST_SINGLE, number)
            if abs(number) > GREATEST_SINGLE:
                number = math.copysign(math.inf, number)
        if math.isinf(number):
            return "INFINITY" if number > 0.0 else "-INFINITY"
        text = repr(float(number))
        if "e" not in text and "." not in text:
            text += ".0"
        return text if self.name == "double" else text + "f"

    def number(self, number: Any, kind: Scalar) -> Value:
        """Return the value of a known number.

        Raises
        ------
        OverflowError
            If it is a whole number of more than 31 bits.
        """
        if kind == BOOL:
            return Value(BOOL, "1" if number else "0", bool(number))
        if kind == INT:
            if abs(int(number)) > GREATEST_WHOLE:
                raise OverflowError(f"{TOO_LARGE}, {number}")
            return Value(INT, str(int(number)), int(number))
        text = self.literal(float(number))
        return Value(REAL, f"({text})" if text.startswith("-") else text, float(number))

    def value_of(self, code: str, thing: Any) -> Value:
        """Return the value of a known Python object that is an argument of a kernel.

        Tables in NamedTuples are named after their fields, with the prefix ``code``.
        """
        for types, kind in (
            ((bool, np.bool_), BOOL),
            ((int, np.integer), INT),
            ((float, np.floating), REAL),
        ):
            if isinstance(thing, types):
                if code and kind == INT and abs(int(thing)) > GREATEST_WHOLE:
                    raise NotExportable(f"{code}, {thing}", TOO_LARGE, "a smaller one")
                return self.number(thing, kind)
        if isinstance(thing, np.ndarray):
            item = INT if thing.dtype.kind in "iub" else REAL
            flat = np.ascontiguousarray(thing).ravel()
            if item == INT and any(abs(int(n)) > GREATEST_WHOLE for n in flat):
                raise NotExportable(code, TOO_LARGE, "smaller ones")
            return Value(Row(item, True, thing.shape), code, Table(code, flat))
        if not hasattr(thing, "_fields"):
            raise NotExportable(
                f"{code}, a {type(thing).__name__}",
                "it is not a number, an array or a NamedTuple of these",
                "one of these",
            )
        fields = {name: self.value_of(f"{code}_{name}", part) for name, part in _parts(thing)}
        record = Record(
            type(thing).__name__,
            tuple((name, v.type) for name, v in fields.items()),
            type(thing),
        )
        return Value(record, code, fields)


def _parts(thing: Any) -> list[tuple[str, Any]]:
    return [(name, getattr(thing, name)) for name in thing._fields]
