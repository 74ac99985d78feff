"""How the arguments of a system are read: rules, names, ranges and norms."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fuzzy2.errors import InvalidValue
from fuzzy2.support.checks import reals
from fuzzy2.systems.rules import parse_rules
from fuzzy2.systems.terms import AnySet


def read_rules(
    rules: Any,
    outputs: Mapping[str, Mapping[str, Any]],
    input_names: Sequence[str] | None,
    term_names: Sequence[Sequence[str]] | None,
) -> tuple[NDArray[np.int64], Any, list[str], list[list[str]]]:
    """Return rules in words as numbers of terms, consequents and names.

    That is the consequent of each rule, and the names of the outputs and of the consequents.
    """
    if input_names is None or term_names is None:
        raise InvalidValue(
            "inputs",
            None,
            "a mapping from names to terms by name, or go with input_names and term_names, for "
            "rules in words",
        )
    antecedents, numbers = parse_rules(
        rules, dict(zip(input_names, term_names, strict=True)), outputs
    )
    meanings = [list(terms.values()) for terms in outputs.values()]
    consequents = [[meanings[j][t] for j, t in enumerate(row)] for row in numbers]
    words = [list(terms) for terms in outputs.values()]
    names = [[words[j][t] for j, t in enumerate(row)] for row in numbers]
    if not any(isinstance(item, AnySet) for row in consequents for item in row):
        intervals = [
            [tuple(np.broadcast_to(np.asarray(item, dtype=float), 2)) for item in row]
            for row in consequents
        ]
        return antecedents, np.array(intervals), list(outputs), names
    return antecedents, consequents, list(outputs), names


def checked_names(what: str, given: Sequence[str] | None, count: int, stem: str) -> tuple[str, ...]:
    """Return a name for each thing, all different; a stem and a number where none are given."""
    if given is None:
        return tuple(f"{stem}{i + 1}" for i in range(count))
    names = tuple(given)
    if (
        len(names) != count
        or len(set(names)) != count
        or not all(isinstance(name, str) and name for name in names)
    ):
        raise InvalidValue(what, names, f"{count} different names")
    return names


def names_of_consequents(
    given: Sequence[Sequence[str]] | None, count: int, outputs: int
) -> tuple[tuple[str, ...], ...] | None:
    """Return a name for each rule and output, or None where none are given."""
    if given is None:
        return None
    names = tuple(tuple(row) for row in given)
    if len(names) != count or not all(
        len(row) == outputs and all(isinstance(name, str) for name in row) for row in names
    ):
        raise InvalidValue(
            "consequent_names", given, f"a list of {outputs} names for each of the {count} rules"
        )
    return names


def checked_ranges(
    what: str, given: ArrayLike | None, count: int
) -> tuple[tuple[float, float], ...] | None:
    """Return as many pairs of finite ends as there are things, or None where none are given."""
    if given is None:
        return None
    ends = reals(what, given)
    if (
        ends.shape != (count, 2)
        or not np.isfinite(ends).all()
        or not (ends[:, 0] < ends[:, 1]).all()
    ):
        raise InvalidValue(what, given, f"{count} pairs of finite numbers in ascending order")
    return tuple((float(low), float(high)) for low, high in ends)
