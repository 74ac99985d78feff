"""Kinds of values in JSON documents, with their readers and writers."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterable, Mapping
from typing import Any, Final, NamedTuple

import numpy as np

from fuzzy2.errors import MalformedFile, NotExpressible, in_words
from fuzzy2.systems.rules import unknown_name

LARGEST_INTEGER: Final = 2**31 - 1
"""Largest whole number that is read; no rule base or grid is that large."""

Json = Any
"""Values that ``json`` returns: dictionaries, lists, strings, numbers, True, False and None.
"""


class Kind(NamedTuple):
    """Reader and writer of one kind of value at a path of the document."""

    write: Callable[[Any, str], Json]
    read: Callable[[Json, str], Any]


def malformed(path: str, reason: str) -> MalformedFile:
    """Return the error of a document that is wrong at a path."""
    return MalformedFile("document", path, reason)


def at(path: str) -> str:
    """Return where a part of a saved object is, as messages say it; the object itself is nowhere.

    The ``$`` of a path stands for the document, which somebody who saves an object has not seen.
    """
    return "" if path == "$" else f" at {path.removeprefix('$').removeprefix('.')}"


def shown(value: Json) -> str:
    """Return a value as messages show it, cut off after 60 characters."""
    try:
        text = json.dumps(value, ensure_ascii=False, default=repr)
    except (TypeError, ValueError, RecursionError):  # e.g. numbers of thousands of digits
        text = in_words(value)
    return text if len(text) <= 60 else f"{text[:57]}..."


def _write_number(value: Any, path: str) -> Json:
    number = float(value)
    if math.isnan(number):
        raise NotExpressible(f"NaN{at(path)}", "JSON", "it is not a number")
    return number if math.isfinite(number) else "inf" if number > 0.0 else "-inf"


def _read_number(value: Json, path: str) -> float:
    if isinstance(value, int | float) and not isinstance(value, bool):
        try:
            number = float(value)
        except OverflowError:
            number = math.inf
        if math.isfinite(number):
            return number
    raise malformed(path, f"expected a finite number, got {shown(value)}")


def _read_any_number(value: Json, path: str) -> float:
    if value in ("inf", "-inf"):
        return float(value)
    return _read_number(value, path)


def or_none(kind: Kind) -> Kind:
    """Return the kind of optional values of another kind; a missing value is written as null."""
    return Kind(
        lambda value, path: None if value is None else kind.write(value, path),
        lambda value, path: None if value is None else kind.read(value, path),
    )


def read_list(value: Json, path: str) -> list[Json]:
    """Return a list unchanged; refuse anything else."""
    if not isinstance(value, list):
        raise malformed(path, f"expected a list, got {shown(value)}")
    return value


def list_of(kind: Kind) -> Kind:
    """Return the kind of lists of values of one kind."""
    return Kind(
        lambda values, path: [kind.write(value, f"{path}[{i}]") for i, value in enumerate(values)],
        lambda values, path: [
            kind.read(value, f"{path}[{i}]") for i, value in enumerate(read_list(values, path))
        ],
    )


def mapping_of(kind: Kind, what: str) -> Kind:
    """Return the kind of objects with values of one kind by name."""

    def read(value: Json, path: str) -> dict[str, Any]:
        if not isinstance(value, dict):
            raise malformed(path, f"expected an object of {what} by name, got {shown(value)}")
        return {name: kind.read(one, f"{path}.{name}") for name, one in value.items()}

    return Kind(
        lambda values, path: {name: kind.write(values[name], f"{path}.{name}") for name in values},
        read,
    )


def pair_of(kind: Kind) -> Kind:
    """Return the kind of lists of two values of one kind."""
    listed = list_of(kind)

    def read(values: Json, path: str) -> Any:
        if len(read_list(values, path)) != 2:
            raise malformed(path, f"expected two, got {len(values)}")
        return listed.read(values, path)

    return Kind(listed.write, read)


def _read_integer(value: Json, path: str) -> int:
    if not isinstance(value, int) or isinstance(value, bool) or abs(value) > LARGEST_INTEGER:
        raise malformed(path, f"expected a whole number, got {shown(value)}")
    return value


def _depth(value: Json) -> int:
    return 1 + _depth(value[0]) if isinstance(value, list) and value else 0


def table_of(of: Kind, name: str, *dimensions: int) -> Kind:
    """Return the kind of nested lists whose rows have equal lengths.

    The number of dimensions must be one of the given numbers.
    """

    def write(values: Any, path: str) -> Json:
        kind = of
        for _ in np.shape(values):
            kind = list_of(kind)
        return kind.write(np.asarray(values).tolist(), path)

    def read(value: Json, path: str) -> Any:
        depth = _depth(read_list(value, path))
        if depth not in dimensions:
            raise malformed(path, f"expected {name}, got {shown(value)}")
        kind = of
        for _ in range(depth):
            kind = list_of(kind)
        rows = kind.read(value, path)
        try:
            np.array(rows)
        except ValueError:
            raise malformed(
                path, f"expected {name}, but its rows are of different lengths"
            ) from None
        return rows

    return Kind(write, read)


def choice_of(known: Iterable[str], name: str) -> Kind:
    """Return the kind of strings that are among the given ones."""

    def read(value: Json, path: str) -> str:
        if _read_text(value, path) not in known:
            raise malformed(path, f"{unknown_name(name, value, known)} (known: {', '.join(known)})")
        return str(value)

    return Kind(lambda value, path: value, read)


def norm_of(known: Mapping[str, Any], name: str) -> Kind:
    """Return the kind of norms, which are written by name."""

    def write(value: Any, path: str) -> Json:
        written = value.name
        if known.get(written) is not value:
            raise NotExpressible(
                f"the {name} {written!r}{at(path)}",
                "JSON",
                f"only {', '.join(known)} have names; it is a function",
            )
        return written

    return Kind(write, choice_of(known, name).read)


def _read_truth(value: Json, path: str) -> bool:
    if not isinstance(value, bool):
        raise malformed(path, f"expected true or false, got {shown(value)}")
    return value


def _read_text(value: Json, path: str) -> str:
    if not isinstance(value, str):
        raise malformed(path, f"expected a string, got {shown(value)}")
    return value


NUMBER = Kind(_write_number, _read_number)
"""Finite numbers."""

ANY_NUMBER = Kind(_write_number, _read_any_number)
"""Numbers, which may be infinite."""

INTEGER = Kind(lambda value, path: value, _read_integer)
TRUTH = Kind(lambda value, path: bool(value), _read_truth)
TEXT = Kind(lambda value, path: value, _read_text)
