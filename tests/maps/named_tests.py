"""Tests by the names that the maps give them."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path

TESTS = Path(__file__).resolve().parents[1]


@cache
def functions_of(file: str) -> frozenset[str]:
    """Return the names of the functions of a file below tests/, not of those within others."""
    text = (TESTS / file).read_text(encoding="utf-8")
    return frozenset(re.findall(r"^def (\w+)\(", text, flags=re.MULTILINE))
