"""JSON documents whose values and structure are changed at random; YAML reads them, too."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any

import numpy as np

from tests.hostile.byte_mutants import damaged
from tests.hostile.mutant import NONE, OTHER, SAME, Mutant


class Members(list[tuple[str, Any]]):
    """Members of an object in their order, of which two may have one name."""


class Verbatim(str):
    """Text of a document as it is."""


_VALUES: dict[str, Any] = {
    "null": None,
    "true": True,
    "text": "text",
    "empty text": "",
    "number as text": "0.5",
    "list": [],
    "object": Members(),
    "list of lists": [[0.5, 1.0], [2.0]],
    "zero": 0,
    "minus one": -1,
    "half": 0.5,
    "huge": 1e300,
    "tiny": 1e-320,
    "too large": Verbatim("1e999"),
    "not a number": Verbatim("NaN"),
    "infinite": Verbatim("-Infinity"),
    "infinite as text": "inf",
    "2**31": 2**31,
    "2**31 - 1": 2**31 - 1,
    "a million": 1_000_000,
    "2**63": 2**63,
    "many digits": Verbatim("1" * 5000),
    "zero before": Verbatim("01"),
    "lone surrogate": Verbatim('"\\ud800"'),
    "zero byte": "a\0b",
    "long text": "long " * 20_000,
    "deep": Verbatim("[" * 3000 + "]" * 3000),
    "very deep": Verbatim('{"a":' * 100_000 + "1" + "}" * 100_000),
    "path": "../../etc/passwd",
    "markup": "<script>alert(1)</script>",
}
"""What stands in place of a value."""


def parsed(content: bytes) -> Any:
    """Return a document, its objects with their order."""
    return json.loads(content, object_pairs_hook=Members)


def dumped(value: Any, blank: str = " ") -> str:
    """Return a document as text."""
    if isinstance(value, Verbatim):
        return str(value)
    if isinstance(value, Members):
        inside = f",{blank}".join(
            f"{json.dumps(name, ensure_ascii=False)}:{blank}{dumped(one, blank)}"
            for name, one in value
        )
        return f"{{{inside}}}"
    if isinstance(value, list):
        return f"[{f',{blank}'.join(dumped(one, blank) for one in value)}]"
    return json.dumps(value, ensure_ascii=False)


def _places(value: Any) -> Iterator[tuple[Any, int]]:
    """Yield all objects and lists of a document, each with the number of one of its parts."""
    parts = [one for _, one in value] if isinstance(value, Members) else value
    if isinstance(value, list):
        for k, part in enumerate(parts):
            yield value, k
            yield from _places(part)


def changed(content: bytes, rng: np.random.Generator, tells_numbers: bool = True) -> Mutant:
    """Return a document that was changed.

    ``tells_numbers`` says that each number must count.
    """
    if rng.random() < 0.15:
        return damaged(content, rng)
    if rng.random() < 0.1:
        return _lookalike(content, rng)
    root = parsed(content)
    places = list(_places(root))
    within, k = places[int(rng.integers(len(places)))]
    what, claim = (_member if isinstance(within, Members) and rng.random() < 0.4 else _value)(
        within, k, rng
    )
    if not tells_numbers and claim == OTHER:
        claim = ""
    return Mutant(0, what, dumped(root).encode("utf-8", "surrogatepass"), claim)


def _member(within: Members, k: int, rng: np.random.Generator) -> tuple[str, str]:
    """Remove, double, rename or add a member of an object."""
    name, value = within[k]
    what = ("remove", "double", "misspell", "case", "add", "first")[int(rng.integers(6))]
    if what == "remove":
        del within[k]
        return f"remove {name}", ""
    if what == "double":
        within.insert(int(rng.integers(len(within) + 1)), (name, 0.5))
        return f"{name} twice", NONE
    if what == "add":
        within.append(("extra", 1.0))
        return f"add beside {name}", ""
    if what == "first":
        within.insert(0, within.pop(k))
        return f"{name} first", ""
    within[k] = (f"{name}s" if what == "misspell" else name.swapcase(), value)
    return f"{what} {name}", ""


def _value(within: Any, k: int, rng: np.random.Generator) -> tuple[str, str]:
    """Put another value in the place of one, or take it out of its list."""
    old = within[k][1] if isinstance(within, Members) else within[k]
    name = within[k][0] if isinstance(within, Members) else str(k)
    if not isinstance(within, Members) and rng.random() < 0.3:
        if rng.random() < 0.5:
            del within[k]
            return f"remove item {k}", ""
        within.insert(k, old)
        return f"double item {k}", ""
    claim = ""
    if isinstance(old, int | float) and not isinstance(old, bool) and rng.random() < 0.4:
        what, new, claim = "another value", 1.25 * old + (0.375 if old >= 0.0 else -0.375), OTHER
    elif isinstance(old, str) and rng.random() < 0.5:
        what, new = "another text", f"{old}s"
    else:
        what = list(_VALUES)[int(rng.integers(len(_VALUES)))]
        new = _VALUES[what]
    within[k] = (name, new) if isinstance(within, Members) else new
    return f"{what} for {name}", claim


def _lookalike(content: bytes, rng: np.random.Generator) -> Mutant:
    """Write a document in another way."""
    root = parsed(content)
    ways = {
        "no blanks": dumped(root, ""),
        "lines": dumped(root, "\n"),
        "tabs": dumped(root, "\t"),
        "blanks around": f" \n{dumped(root)}\r\n ",
        "mark of UTF-8": f"\ufeff{dumped(root)}",
        "escapes": json.dumps(json.loads(content), ensure_ascii=True),
    }
    what = list(ways)[int(rng.integers(len(ways)))]
    return Mutant(0, what, ways[what].encode(), SAME)
