"""Terms of outputs that are numbers or functions of the inputs, for an engine."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

from fuzzy2.files.description import Constant, LinearFunction


class FormulaFunction(NamedTuple):
    """Consequent that is a formula of the inputs and of other outputs."""

    text: str


NUMBERS = Constant | LinearFunction | FormulaFunction
"""Terms that are numbers or functions."""


def formula_of(term: Any, inputs: Sequence[str]) -> str:
    """Return a consequent as a formula; 0 for a missing consequent (None)."""
    match term:
        case None:
            return "0"
        case FormulaFunction(text):
            return text
        case LinearFunction(constant, slopes):
            parts = [f"{_number(slope)}*{name}" for slope, name in zip(slopes, inputs, strict=True)]
            return " + ".join([*parts, _number(constant)])
    return _number(term.left)


def _number(value: float) -> str:
    return repr(value) if math.copysign(1.0, value) > 0.0 else f"(0 - {-value!r})"
