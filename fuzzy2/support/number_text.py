"""Numbers in text, in a form that all programs read in the same way."""

from __future__ import annotations

import math
import re

NUMBER = re.compile(
    r"[+-]?(?:(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?|inf(?:inity)?)", re.IGNORECASE
)
"""A number, which may be infinite.

``1_0`` and digits of other scripts are excluded, because only Python reads them.
"""


def number_of(text: str) -> float:
    """Return the number that a text represents, or NaN; blanks around it are not allowed."""
    return float(text) if NUMBER.fullmatch(text) else math.nan
