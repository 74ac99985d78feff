"""What ``docs/concepts/kernels.md`` lists is translated, and everything else is refused by name.

Kernels here are text: many refused ones are no kernels that numba could compile, either.
"""

from __future__ import annotations

import importlib.util
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fuzzy2.errors import NotExportable
from fuzzy2.export.calls import FUNCTIONS, TESTS
from tests.fuzzy2.export.in_c import kernel_in_c, needs_gcc

pytestmark = needs_gcc

PAGE = Path(__file__).resolve().parents[2] / "docs" / "concepts" / "kernels.md"

HEAD = """import math
from typing import NamedTuple

import numpy as np

LIMIT = 3


class Pair(NamedTuple):
    first: float
    second: float


def both(a, b):
    return a + b, a * b


def chance(x, out):
    i, row, table = int(x[0]), x[1:3], x[0:4].reshape(2, 2)
"""
HEAD_LINES = HEAD.count("\n")

ACCEPTED = {
    "out[0] = 3 + LIMIT": 6.0,
    "out[0] = 2.5 if True else False": 2.5,
    "out[0] = x[1]": 1.5,
    "out[0] = table[1, 0]": -2.0,
    "out[0] = table[1][1]": 0.25,
    "out[0] = table[1, i]": 0.25,
    "out[0] = row[-1]": -2.0,
    "part = x[1:3]; out[0] = part[1]": -2.0,
    "part = x[i:]; out[0] = part[0]": 1.5,
    "out[0] = x.size + len(row)": 6.0,
    "n, m = table.shape; out[0] = n * 10 + m": 22.0,
    "out[0] = table.shape[0]": 2.0,
    "p = Pair(x[1], 2.0); out[0] = p.first * p.second": 3.0,
    "p = (1, x[1]); out[0] = p[1]": 1.5,
    "a, b = both(x[1], 2.0); out[0] = a * b": 10.5,
    "out[0] = (x[1] + 1.0 - 2.0) * 4.0 / 2.0": 1.0,
    "out[0] = x[1] ** 2 + x[1] ** -1 + 2 ** 3": 2.25 + 1.0 / 1.5 + 8.0,
    "out[0] = (i - 4) // 2 * 10 + (i - 4) % 2": -19.0,
    "out[0] = (x[1] - 2.0) % 2 + x[1] % -1.0": 1.0,
    "out[0] = 1.0 if 0 < i <= 2 and not i == 2 or False else 0.0": 1.0,
    "out[0] = 1.0 if i in (1, 2) and i not in (3, 4) else 0.0": 1.0,
    "out[0] = abs(-i) + abs(row[1])": 3.0,
    "out[0] = min(i, 2, 7) + max(0.5, row[0])": 2.5,
    "out[0] = int(row[0]) + int(row[1])": -1.0,
    "out[0] = round(row[0]) + round(2.5)": 4.0,
    "out[0] = float(i) + (1.0 if bool(row[0]) else 0.0)": 2.0,
    "out[0] = math.floor(row[0]) + math.ceil(row[0])": 3.0,
    "out[0] = 1.0 if math.isnan(math.nan) and not math.isinf(math.pi) else 0.0": 1.0,
    "out[0] = 1.0 if np.inf > math.e else 0.0": 1.0,
    "out[0] = out[1] = x[1]; out[0] += out[1]": 3.0,
    "out[0], out[1] = x[2], x[1]; out[0], out[1] = out[1], out[0]": 1.5,
    "out[0:2] = 4.0": 4.0,
    "out[0:2] = x[1:3]": 1.5,
    "a: float = x[1]; out[0] = a": 1.5,
    "for k in range(1, 7, 2): out[0] += k": 9.0,
    "for k in range(3, 0, -1): out[0] = k": 1.0,
    "for k in range(9):\n        if k == 3: break\n        out[0] = k": 2.0,
    "for k in range(3):\n        if k == 2: continue\n        out[0] = k": 1.0,
    "k = 5\n    while k > i: k -= 1\n    out[0] = k": 1.0,
    "pass\n    out[0] = 1.0\n    return": 1.0,
    "room = np.zeros((2, LIMIT)); out[0] = room.size + room[1, 2]": 6.0,
    "room = np.empty(2); room[1] = x[1]; out[0] = room[1]": 1.5,
}
"""Statements, and what they write to ``out[0]`` where x is (1, 1.5, -2, 0.25)."""

REFUSED = {
    # Kinds of values.
    "out[0] = 1j": "cannot contain this expression",
    "a = 'text'": "cannot contain this expression",
    "a = b'text'": "cannot contain this expression",
    "a = None": "cannot contain this expression",
    "a = [1.0, 2.0]": "cannot contain this expression",
    "a = {1: 2.0}": "cannot contain this expression",
    "a = {1, 2}": "cannot contain this expression",
    "a = [k for k in range(3)]": "cannot contain this expression",
    "a = f'{i}'": "cannot contain this expression",
    "a = lambda b: b": "cannot contain this expression",
    "out[0] = (a := x[0])": "cannot contain this expression",
    "a = 3000000000": "31 bits",
    "a = 65536 * 65536": "31 bits",
    "a = both": "both is not a number",
    # Operations.
    "out[0] = i << 2": "cannot contain this operation",
    "out[0] = i >> 2": "cannot contain this operation",
    "out[0] = i & 2": "cannot contain this operation",
    "out[0] = i | 2": "cannot contain this operation",
    "out[0] = i ^ 2": "cannot contain this operation",
    "out[0] = ~i": "cannot contain this operation",
    "out[0] = table @ table": "an operation on arrays",
    "out[0] = x[0] // x[1]": "need whole numbers",
    "out[0] = 2 ** i": "a power of whole numbers",
    "out[0] = x[0] ** i": "a whole exponent must be known",
    "a = row + row": "an operation on arrays",
    "a = -row": "an operation on arrays",
    "out[0] = x[0] or 1.0": "need conditions",
    "out[0] = 1.0 if x[0] is x[1] else 0.0": "cannot contain this comparison",
    "out[0] = 1.0 if i in row else 0.0": "cannot contain this comparison",
    "out[0] = 1.0 if 0.0 < both(x[0], x[1])[0] < 1.0 else 0.0": "evaluate a call twice",
    # Arrays.
    "out[0] = x[::2][0]": "no step",
    "out[0] = table[0:1][0]": "one dimension",
    "out[0] = x[0, 0]": "fewer dimensions than indices",
    "out[0] = x[9]": "index 9 of 4",
    "out[0] = x[-5]": "index -1 of 4",
    "a = x[3:9]": "entries 3 to 9 of 4",
    "out[0] = x[x[0]]": "must be a whole number",
    "out[0] = x.sum()": "this method of an array",
    "a = x.T": "not have this attribute",
    "a = x.reshape(-1)": "negative",
    "a = x.reshape(3, 3)": r"shape \(4,\) cannot have the shape \(3, 3\)",
    "a = x.reshape(2, 2, 1)": "at most two dimensions",
    "x[0] = 1.0": "read-only",
    "a = (1.0, 2.0)[i]": "must be known",
    "a = (1.0, 2.0)[2]": "does not have this entry",
    "a = (1.0, 2.0, 3.0)[1:]": "must begin with its first entry",
    "a, b = 1.0, 2.0, 3.0": "a different number of values",
    "a, b, c = both(1.0, x[0])": "a different number of values",
    "a = (1.0, x[0]) if i > 0 else (x[1],)": "different lengths",
    # Memory.
    "a = np.zeros(i)": "must be known",
    "a = np.zeros(-1)": "negative",
    "a = np.zeros((2, 2, 2))": "at most two dimensions",
    "a = np.zeros(2, np.int64)": "must hold floats",
    "a = np.ones(2)": "this function of NumPy",
    "a = np.array([1.0])": "this function of NumPy",
    # Calls.
    "out[0] = math.gamma(x[0])": "math.h does not have this function",
    "out[0] = math.sqrt(x[0], x[1])": "a different number of arguments",
    "out[0] = math.atan2(x[0])": "a different number of arguments",
    "out[0] = math.isnan()": "a different number of arguments",
    "out[0] = math.tau2": "math does not have this number",
    "out[0] = sum(x)": "an array is used where a number is expected",
    "out[0] = pow(x[0], 2.0)": "pow is not a kernel",
    "out[0] = round(x[0], 1)": "round is not a kernel",
    "out[0] = int(math.inf)": "must be finite",
    "print(i)": "print is not a kernel",
    "a = both(x[0])": "the number of arguments must be 2",
    "a = both(a=x[0], b=x[1])": "must be positional",
    "a = both(*row)": "their number known",
    "a = Pair(x[0])": "2 fields",
    # Statements.
    "a = 1.0; a = row": "different types",
    "for k in row: pass": "must count over range",
    "for k in range(3): pass\n    else: pass": "must count over range",
    "for k in range(0, 9, i): pass": "the step must be known",
    "while i > 0:\n        i -= 1\n    else: pass": "cannot have an else",
    "raise ValueError": "cannot contain this statement",
    "assert i > 0": "cannot contain this statement",
    "del i": "cannot contain this statement",
    "global LIMIT": "cannot contain this statement",
    "import math": "cannot contain this statement",
    "def inner(a): return a": "cannot contain this statement",
    "class Inner: pass": "cannot contain this statement",
    "with both: pass": "cannot contain this statement",
    "try: i = 0\n    finally: i = 1": "cannot contain this statement",
    "match i:\n        case 0: pass": "cannot contain this statement",
    "short = x[0]": "a word of C",
    "x.size = 2": "cannot be assigned",
}
"""Statements, and what their error says."""


def kernel_of(text: str, folder: Path) -> Any:
    path = folder / "subset.py"
    path.write_text(f"{HEAD}    {text}\n", encoding="utf-8")
    spec = importlib.util.spec_from_file_location("subset", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.chance


def test_what_is_listed_is_translated(tmp_path):
    """All at once: each statement is a function of its own."""
    for place, (text, value) in enumerate(ACCEPTED.items()):
        folder = tmp_path / str(place)
        folder.mkdir()
        kernel = kernel_of(text, folder)
        run, _ = kernel_in_c(kernel, 4, 2, folder)
        out, in_python = np.zeros(2), np.zeros(2)
        row = np.array([1.0, 1.5, -2.0, 0.25])
        run(row, out)
        kernel(row, in_python)
        assert out[0] == in_python[0] == value, text


@pytest.mark.parametrize("text", REFUSED)
def test_what_is_not_is_refused_with_file_line_and_construct(text, tmp_path):
    kernel = kernel_of(text, tmp_path)
    with pytest.raises(NotExportable, match=REFUSED[text]) as error:
        kernel_in_c(kernel, 4, 2, tmp_path)
    found = re.search(r"subset\.py, line (\d+), in chance: (.+) cannot be", str(error.value))
    assert found is not None
    lines = 1 + text.count("\n")
    if "a word of C" not in str(error.value):
        assert HEAD_LINES < int(found[1]) <= HEAD_LINES + lines
    assert "docs/concepts/kernels.md" in str(error.value)


def test_the_page_lists_the_functions():
    page = PAGE.read_text(encoding="utf-8")
    listed = re.search(r"`math\.` with `([a-z0-9 ]+)`", page)
    assert listed is not None
    assert set(listed[1].split()) == FUNCTIONS | TESTS
