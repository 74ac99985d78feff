"""Other ways to write a number, and what each must come to."""

from __future__ import annotations

import re
from collections.abc import Callable

import numpy as np

from tests.hostile.mutant import NONE, OTHER, SAME

NUMBER = re.compile(r"(?<![\w.])[-+]?(?:\d+(?:\.(?!\.)\d*)?|\.\d+)(?:[eE][-+]?\d+)?(?![\w.]*\w)")
"""A number that stands alone, not the end of a name."""

FULL_WIDTH = str.maketrans("0123456789", "０１２３４５６７８９")
ARABIC = str.maketrans("0123456789", "٠١٢٣٤٥٦٧٨٩")


def _another(text: str) -> str:
    return f"{1.25 * float(text) + (0.375 if float(text) >= 0.0 else -0.375):.9g}"


SPELLINGS: dict[str, tuple[Callable[[str], str], str]] = {
    "another value": (_another, OTHER),
    "one more": (lambda text: str(int(text) + 1) if text.isdigit() else _another(text), OTHER),
    "slightly more": (lambda text: repr(float(text) + 1e-9 * (abs(float(text)) + 1.0)), OTHER),
    "capital": (lambda text: f"{text}E0" if "e" not in text.lower() else text, SAME),
    "point": (lambda text: f"{text}." if text.isdigit() else text, SAME),
    "more digits": (
        lambda text: f"{text}000000" if "." in text and "e" not in text.lower() else text,
        SAME,
    ),
    "zero before": (lambda text: f"0{text}" if text.isdigit() else text, SAME),
    "plus": (lambda text: text if text[:1] in "+-" else f"+{text}", SAME),
    "underscore": (lambda text: f"{text}_0", NONE),
    "underscore in it": (lambda text: f"1_0{text.lstrip('+-')}", NONE),
    "hexadecimal": (lambda text: "0x1p-2", NONE),
    "full width": (lambda text: text.translate(FULL_WIDTH), NONE),
    "Arabic": (lambda text: text.translate(ARABIC), NONE),
    "superscript": (lambda text: f"{text}²", NONE),
    "other blanks": (lambda text: f"\u00a0{text}\u2003", ""),
    "Fortran": (lambda text: f"{text}d0", NONE),
    "unit": (lambda text: f"{text}mm", NONE),
    "two points": (lambda text: f"{text}.0.0", NONE),
    "comma": (lambda text: text.replace(".", ","), ""),
    "not a number": (lambda text: "nan", ""),
    "infinite": (lambda text: "-inf", ""),
    "too large": (lambda text: "1e999", ""),
    "huge": (lambda text: "1e300", ""),
    "tiny": (lambda text: "1e-320", ""),
    "zero": (lambda text: "0", ""),
    "minus zero": (lambda text: "-0.0", ""),
    "other sign": (lambda text: text[1:] if text.startswith("-") else f"-{text}", ""),
    "twice": (lambda text: f"{text} {text}", ""),
    "none": (lambda text: "", ""),
    "long": (lambda text: "9" * 400, ""),
    "very long": (lambda text: "1" * 5000, ""),
    "2**31": (lambda text: str(2**31), ""),
    "2**31 - 1": (lambda text: str(2**31 - 1), ""),
    "a million": (lambda text: "1000000", ""),
}
"""Ways, each with what it must come to."""


def respelled(text: str, rng: np.random.Generator) -> tuple[str, str, str]:
    """Return how a number is written instead, the name of the way, and what it must come to."""
    name = list(SPELLINGS)[int(rng.integers(len(SPELLINGS)))]
    function, claim = SPELLINGS[name]
    return function(text), name, claim
