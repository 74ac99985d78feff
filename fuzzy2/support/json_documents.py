"""JSON of files that may come from anywhere: what every reader of it refuses alike.

Python's own parser takes the last of two values of one key, makes infinity of ``1e999``, and reads
``NaN``, which is no JSON.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from typing import Any, NoReturn

from fuzzy2.support.bounded_files import MOST_PARTS


def json_document(text: str) -> Any:
    """Return what a text in JSON says.

    Raises
    ------
    ValueError
        If it is no JSON (:class:`json.JSONDecodeError`), has a key twice in one object, a number
        that is none of a computer, more than :data:`MOST_PARTS` lists, objects and keys, or more
        of them in each other than Python can follow.
    """
    # Before anything is made of them: each takes some hundred bytes, however short it is written.
    if sum(map(text.count, "[{:")) > MOST_PARTS:
        raise ValueError(f"it has more than {MOST_PARTS} lists, objects and keys")
    try:
        return json.loads(
            text,
            object_pairs_hook=_without_repetition,
            parse_constant=_refused,
            parse_float=_finite,
        )
    except RecursionError:
        raise ValueError("it is nested too deeply") from None


def _without_repetition(pairs: Sequence[tuple[str, Any]]) -> dict[str, Any]:
    found = dict(pairs)
    if len(found) < len(pairs):
        seen: set[str] = set()
        twice = next(key for key, _ in pairs if key in seen or seen.add(key))  # type: ignore[func-returns-value]
        raise ValueError(f"the key {twice[:80]!r} is there twice in one object")
    return found


def _refused(name: str) -> NoReturn:
    raise ValueError(f"{name} is not a number of JSON")


def _finite(text: str) -> float:
    number = float(text)
    if math.isinf(number):
        raise ValueError(f"{text[:40]} is too large for a number")
    return number
