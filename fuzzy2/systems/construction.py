"""How the arguments of a system are read: inputs, rules, consequents, names and ranges."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fuzzy2.errors import InvalidValue
from fuzzy2.support.checks import Array, reals
from fuzzy2.systems.consequents import Linear, as_sets, centroid_interval
from fuzzy2.systems.fuzzifiers import Fuzzifier, NonSingletonFuzzifier, SingletonFuzzifier
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


def check_inputs(inputs: Sequence[Sequence[Any]], kinds: tuple[type, ...], kind_names: str) -> None:
    """Refuse inputs without terms, and terms of a kind that the system does not take."""
    if not inputs or not all(inputs):
        raise InvalidValue(
            "inputs", inputs, "a list of at least one set for each of at least one input"
        )
    for number, terms in enumerate(inputs, start=1):
        for term in terms:
            if not isinstance(term, kinds):
                raise InvalidValue(f"a term of input {number}", term, kind_names)


def checked_fuzzifiers(
    given: Fuzzifier | Sequence[Fuzzifier] | None,
    count: int,
    kinds: tuple[type, ...],
    kind_names: str,
) -> tuple[Fuzzifier, ...] | None:
    """Return a fuzzifier for each input, or None if all are singleton."""
    if given is None:
        return None
    each = (given,) * count if isinstance(given, Fuzzifier) else tuple(given)
    if len(each) != count or not all(isinstance(one, Fuzzifier) for one in each):
        raise InvalidValue(
            "fuzzifier", given, f"a fuzzifier, or one for each of the {count} inputs"
        )
    for one in each:
        if isinstance(one, NonSingletonFuzzifier) and not isinstance(one.shape, kinds):
            raise InvalidValue("the shape of a fuzzifier", one.shape, kind_names)
    return None if all(isinstance(one, SingletonFuzzifier) for one in each) else each


def checked_rules(rules: Any, inputs: Sequence[Sequence[Any]]) -> NDArray[np.int64]:
    """Return rules (R, p) as numbers of terms, or -1 where an input plays no part."""
    given = np.asarray(rules)
    if (
        given.ndim != 2
        or given.shape[1] != len(inputs)
        or given.shape[0] == 0
        or given.dtype.kind not in "iu"
    ):
        raise InvalidValue(
            "rules",
            given,
            f"whole numbers of shape (R, {len(inputs)}), a row for each rule",
        )
    counts = np.array([len(terms) for terms in inputs])
    bad = np.argwhere((given < -1) | (given >= counts))
    if len(bad):
        row, column = (int(index) for index in bad[0])
        raise InvalidValue(
            f"rule {row + 1}, input {column + 1}",
            int(given[row, column]),
            f"the number of one of its {counts[column]} terms, from 0, or -1 for no part",
        )
    return given.astype(np.int64)


def checked_consequents(
    consequents: Any, count: int, inputs: int, kinds: tuple[type, ...], kind_names: str
) -> tuple[Any, list[list[Any]] | None, Array]:
    """Return the consequents as given, the sets if they are any, and intervals (R, m, 2)."""
    if isinstance(consequents, Linear):
        if (
            consequents.coefficients.shape[0] != count
            or consequents.coefficients.shape[2] != inputs + 1
        ):
            raise InvalidValue(
                "consequents",
                consequents.coefficients.shape,
                f"coefficients of shape ({count}, m, {inputs + 1})",
            )
        return consequents, None, np.zeros((*consequents.coefficients.shape[:2], 2))
    sets = as_sets(consequents)
    if sets is not None:
        if len(sets) != count or len({len(row) for row in sets}) != 1:
            raise InvalidValue(
                "consequents",
                len(sets),
                f"a set, or a list with a set for each output, for each of {count} rules",
            )
        for row in sets:
            for item in row:
                if not isinstance(item, kinds):
                    raise InvalidValue("a consequent", item, kind_names)
        return sets, sets, np.array([[centroid_interval(item) for item in row] for row in sets])
    try:
        values = np.asarray(consequents, dtype=float)
    except (TypeError, ValueError) as error:
        raise InvalidValue(
            "consequents",
            consequents,
            f"numbers (R, m), intervals (R, m, 2) or sets, R = {count}",
        ) from error
    if values.ndim == 2:
        values = np.stack([values, values], axis=-1)
    if values.ndim != 3 or values.shape[0] != count or values.shape[1] == 0 or values.shape[2] != 2:
        raise InvalidValue(
            "consequents", values, f"numbers (R, m), intervals (R, m, 2) or sets, R = {count}"
        )
    if not np.isfinite(values).all() or (values[..., 0] > values[..., 1]).any():
        raise InvalidValue("consequents", values, "finite, with left ends not above right ends")
    return (
        consequents
        if isinstance(consequents, np.ndarray)
        else np.asarray(consequents, dtype=float),
        None,
        values,
    )
