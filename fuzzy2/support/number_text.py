"""Numbers in text, in the one way that every program reads alike."""

from __future__ import annotations

import math
import re

NUMBER = re.compile(
    r"[+-]?(?:(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?|inf(?:inity)?)", re.IGNORECASE
)
"""A number, which may be infinite.

Not ``1_0`` or digits of other scripts, which Python reads and other programs do not.
"""


def number_of(text: str) -> float:
    """Return the number that a text is, NaN if it is none; there are no blanks around it."""
    return float(text) if NUMBER.fullmatch(text) else math.nan
