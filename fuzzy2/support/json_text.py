"""JSON documents in which names are unique and numbers are finite."""

from __future__ import annotations

import json
import math
from typing import Any, NoReturn

from fuzzy2.errors import MalformedFile
from fuzzy2.support.bounded_files import MOST_PARTS


class _Repeated(dict[str, Any]):
    """Marker of an object with a repeated name, which ``json`` would silently accept."""

    name: str


def parse_json(text: str, source: str = "document") -> Any:
    """Return a JSON document: dictionaries, lists, strings, numbers, True, False and None.

    Parameters
    ----------
    text : str
        The document.
    source : str
        What error messages call it.

    Raises
    ------
    MalformedFile
        If it is not JSON (``place`` is the line and column), or is nested too deeply, has more than
        :data:`MOST_PARTS` lists, objects and names, a number that JSON cannot represent or that
        is too large for a float, a lone surrogate in a string, or a repeated name
        (``place`` is the path).
    """
    # The limit is checked before parsing, because each part takes some hundred bytes, however short
    # its text.
    if sum(map(text.count, "[{:")) > MOST_PARTS:
        raise MalformedFile(source, "$", f"has more than {MOST_PARTS} lists, objects and names")
    try:
        document = json.loads(
            text,
            object_pairs_hook=_without_repetition,
            parse_constant=_refuse_constant,
            parse_float=_finite,
        )
        repeated = _first_repeated(document, "$")
        if "\\ud" in text.lower():
            json.dumps(document, ensure_ascii=False).encode()
    except json.JSONDecodeError as error:
        raise MalformedFile(
            source, f"line {error.lineno}, column {error.colno}", error.msg
        ) from None
    except UnicodeEncodeError as error:
        reason = f"has half of a pair of characters, {error.object[error.start]!r}"
        raise MalformedFile(source, "$", reason) from None
    except RecursionError:
        raise MalformedFile(source, "$", "is nested too deeply") from None
    except ValueError as error:  # an integer of thousands of digits, or NaN
        raise MalformedFile(source, "$", str(error)) from None
    if repeated:
        raise MalformedFile(source, repeated, "is given twice")
    return document


def _refuse_constant(name: str) -> NoReturn:
    raise ValueError(f"{name} is not a number of JSON")


def _finite(text: str) -> float:
    number = float(text)
    if math.isinf(number):
        raise ValueError(f"{text[:40]} is too large for a number")
    return number


def _without_repetition(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found = dict(pairs)
    if len(found) == len(pairs):
        return found
    marked, seen = _Repeated(pairs), set()
    for name, _ in pairs:
        if name in seen:
            marked.name = name
            break
        seen.add(name)
    return marked


def _first_repeated(value: Any, path: str) -> str:
    """Return the path of the first repeated name, or nothing."""
    if isinstance(value, _Repeated):
        return f"{path}.{value.name}"
    if isinstance(value, dict):
        parts = [(f"{path}.{name}", one) for name, one in value.items()]
    elif isinstance(value, list) and any(isinstance(one, dict | list) for one in value):
        parts = [(f"{path}[{i}]", one) for i, one in enumerate(value)]
    else:
        return ""
    return next((found for name, one in parts if (found := _first_repeated(one, name))), "")
