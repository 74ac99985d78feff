"""Reading of a system's arguments: inputs, rules, consequents, names and ranges."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fuzzy2.errors import InvalidValue, NotApplicable
from fuzzy2.operations.set_operations import complement
from fuzzy2.support.checks import Array, listed, real, reals
from fuzzy2.systems.antecedents import check_numbers, rows_of
from fuzzy2.systems.consequents import (
    Formulas,
    FunctionsOfInputs,
    Linear,
    as_sets,
    centroid_interval,
)
from fuzzy2.systems.fuzzifiers import Fuzzifier, NonSingletonFuzzifier, SingletonFuzzifier
from fuzzy2.systems.hedges import Hedge
from fuzzy2.systems.rules import read_rule_base
from fuzzy2.systems.terms import AnySet


class RulesInWords(NamedTuple):
    """Rules in words, converted to the numbers that a system takes.

    ``consequents`` are rows of sets, or an array of intervals. ``weights`` is None if all weights
    are 1, and ``silent`` is None if every rule has a consequent for every output.
    """

    rules: Any
    consequents: Any
    silent: NDArray[np.bool_] | None
    weights: Array | None
    names: list[list[str]]
    output_names: list[str]
    output_terms: list[dict[str, Any]]
    of_sets: bool


class Consequents(NamedTuple):
    """Consequents of a system.

    It holds them as given, as sets if they are sets, as intervals of their centroids, and where
    rules have no consequent.
    """

    given: Any
    sets: tuple[tuple[Any, ...], ...] | None
    intervals: Array
    silent: NDArray[np.bool_] | None


def read_rules(
    rules: Any,
    outputs: Mapping[str, Mapping[str, Any]],
    input_names: Sequence[str] | None,
    term_names: Sequence[Sequence[str]] | None,
    hedges: Mapping[str, Hedge],
) -> RulesInWords:
    """Return rules in words as numbers, with the consequent of each rule and its names."""
    if input_names is None or term_names is None:
        raise InvalidValue(
            "inputs",
            None,
            "a mapping from names to terms by name, or go with input_names and term_names, for "
            "rules in words",
        )
    inputs = dict(zip(input_names, term_names, strict=True))
    base = read_rule_base(rules, inputs, outputs, hedges)
    meanings = [list(terms.values()) for terms in outputs.values()]
    words = [list(terms) for terms in outputs.values()]
    consequents: list[list[Any]] = []
    names: list[list[str]] = []
    for numbers, negated in zip(base.said.tolist(), base.negated.tolist(), strict=True):
        consequents.append([])
        names.append([])
        for j, (number, no) in enumerate(zip(numbers, negated, strict=True)):
            meaning = None if number < 0 else meanings[j][number]
            consequents[-1].append(_complement(meaning, words[j][number]) if no else meaning)
            names[-1].append(
                "" if number < 0 else f"not {words[j][number]}" if no else words[j][number]
            )
    silent = base.said < 0
    of_sets = any(isinstance(item, AnySet) for row in consequents for item in row)
    table: Any = consequents
    if not of_sets:
        table = np.array(
            [
                [np.broadcast_to(reals("a term", 0.0 if one is None else one), 2) for one in row]
                for row in consequents
            ]
        )
    return RulesInWords(
        base.trees,
        table,
        silent if silent.any() else None,
        base.weights if (base.weights != 1.0).any() else None,
        names,
        list(outputs),
        [dict(terms) for terms in outputs.values()],
        of_sets,
    )


def _complement(meaning: Any, word: str) -> Any:
    if not isinstance(meaning, AnySet):
        raise InvalidValue(f"the term {word!r}", meaning, "a set, to be negated")
    return complement(meaning)


def checked_names(what: str, given: Sequence[str] | None, count: int, stem: str) -> tuple[str, ...]:
    """Return different names for all things; by default a stem with a number."""
    if given is None:
        return tuple(f"{stem}{i + 1}" for i in range(count))
    names = listed(what, given, f"{count} different names")
    if (
        len(names) != count
        or not all(isinstance(name, str) and name for name in names)
        or len(set(names)) != count
    ):
        raise InvalidValue(what, names, f"{count} different names")
    return names


def names_of_consequents(
    given: Sequence[Sequence[str]] | None, count: int, outputs: int
) -> tuple[tuple[str, ...], ...] | None:
    """Return a name for each rule and output, or None if none are given."""
    if given is None:
        return None
    requirement = f"a list of {outputs} names for each of the {count} rules"
    names = tuple(
        listed("consequent_names", row, requirement)
        for row in listed("consequent_names", given, requirement)
    )
    if len(names) != count or not all(
        len(row) == outputs and all(isinstance(name, str) for name in row) for row in names
    ):
        raise InvalidValue("consequent_names", given, requirement)
    return names


def checked_ranges(
    what: str, given: ArrayLike | None, count: int
) -> tuple[tuple[float, float], ...] | None:
    """Return one pair of finite ends for each thing, or None if none are given."""
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


def checked_output_terms(
    given: Sequence[Mapping[str, Any]] | None, outputs: int
) -> tuple[dict[str, Any], ...] | None:
    """Return all terms of each output by name, or None if none are given."""
    if given is None:
        return None
    requirement = f"a mapping for each of the {outputs} outputs"
    terms = listed("output_terms", given, requirement)
    if len(terms) != outputs or not all(isinstance(one, Mapping) for one in terms):
        raise InvalidValue("output_terms", given, requirement)
    return tuple(dict(one) for one in terms)


def listed_terms(inputs: Sequence[Sequence[Any]]) -> tuple[tuple[Any, ...], ...]:
    """Return the terms of every input."""
    requirement = "a list of sets for each input"
    return tuple(
        listed("inputs", terms, requirement) for terms in listed("inputs", inputs, requirement)
    )


def check_inputs(
    inputs: Sequence[Sequence[Any]], kinds: tuple[type, ...], kind_names: str, ranged: bool
) -> None:
    """Refuse inputs without terms, and terms of a kind that the system does not accept.

    An input with a range needs no terms; then only linear consequents use it.
    """
    if not inputs or not (ranged or all(inputs)):
        raise InvalidValue(
            "inputs",
            inputs,
            "a list of at least one set for each of at least one input, or go with input_ranges",
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
    requirement = f"a fuzzifier, or one for each of the {count} inputs"
    each = (
        (given,) * count
        if isinstance(given, Fuzzifier)
        else listed("fuzzifier", given, requirement)
    )
    if len(each) != count or not all(isinstance(one, Fuzzifier) for one in each):
        raise InvalidValue("fuzzifier", given, requirement)
    for one in each:
        if isinstance(one, NonSingletonFuzzifier) and not isinstance(one.shape, kinds):
            raise InvalidValue("the shape of a fuzzifier", one.shape, kind_names)
    return None if all(isinstance(one, SingletonFuzzifier) for one in each) else each


def checked_rules(rules: Any, inputs: Sequence[Sequence[Any]]) -> Any:
    """Return rules (R, p) as numbers of terms, -1 for unused inputs, or as trees.

    Trees that are plain conjunctions are converted to numbers.
    """
    counts = [len(terms) for terms in inputs]
    if (
        isinstance(rules, list | tuple)
        and rules
        and not isinstance(rules[0], list | tuple | np.ndarray)
    ):
        for number, tree in enumerate(rules, start=1):
            check_numbers(tree, counts, number)
        rows = rows_of(rules, len(inputs))
        if rows is None:
            return tuple(rules)
        return _read_only(rows)
    requirement = f"whole numbers of shape (R, {len(inputs)}), a row for each rule"
    given = reals("rules", rules, requirement)
    whole = np.asarray(rules).dtype.kind in "iu"
    if given.ndim != 2 or given.shape[1] != len(inputs) or given.shape[0] == 0 or not whole:
        raise InvalidValue("rules", rules, requirement)
    bad = np.argwhere((given < -1) | (given >= np.array(counts)))
    if len(bad):
        row, column = (int(index) for index in bad[0])
        raise InvalidValue(
            f"rule {row + 1}, input {column + 1}",
            int(given[row, column]),
            f"the number of one of its {counts[column]} terms, from 0, or -1 for no part",
        )
    return _read_only(given.astype(np.int64))


def checked_consequents(
    consequents: Any,
    silent: ArrayLike | None,
    count: int,
    inputs: int,
    kinds: tuple[tuple[type, ...], str],
    averaged: bool,
) -> Consequents:
    """Return the consequents; values for missing consequents are ignored.

    If the sets are not ``averaged``, sets without a centroid get NaN.
    """
    if isinstance(consequents, FunctionsOfInputs):
        shape = consequents.shape
        if isinstance(consequents, Linear) and (
            shape[0] != count or consequents.coefficients.shape[2] != inputs + 1
        ):
            raise InvalidValue(
                "consequents",
                consequents.coefficients.shape,
                f"coefficients of shape ({count}, m, {inputs + 1})",
            )
        if isinstance(consequents, Formulas) and (
            shape[0] != count or len(consequents.names) != inputs
        ):
            raise InvalidValue(
                "consequents",
                (shape[0], consequents.names),
                f"formulas for {count} rules, and {inputs} names of inputs",
            )
        mask = _checked_silence(silent, shape)
        return Consequents(consequents, None, _read_only(np.zeros((*shape, 2))), mask)
    sets = as_sets(consequents)
    if sets is not None:
        return _of_sets(sets, silent, count, kinds, averaged)
    if not isinstance(consequents, np.ndarray):
        consequents, silent = _without_none(consequents, silent)
    requirement = f"numbers (R, m), intervals (R, m, 2) or sets, R = {count}"
    try:
        given = reals("consequents", consequents)
    except InvalidValue as error:
        raise InvalidValue("consequents", consequents, requirement) from error
    values = np.stack([given, given], axis=-1) if given.ndim == 2 else given
    if values.ndim != 3 or values.shape[0] != count or values.shape[1] == 0 or values.shape[2] != 2:
        raise InvalidValue("consequents", values, requirement)
    mask = _checked_silence(silent, values.shape[:2])
    spoken = np.ones(values.shape[:2], bool) if mask is None else ~mask
    said = values[spoken]
    if not np.isfinite(said).all() or (said[..., 0] > said[..., 1]).any():
        raise InvalidValue("consequents", values, "finite, with left ends not above right ends")
    if mask is not None:
        given, values = np.array(given), np.array(values)
        given[mask] = values[mask] = 0.0
    return Consequents(_read_only(np.array(given)), None, _read_only(np.array(values)), mask)


def _of_sets(
    sets: list[list[Any]],
    silent: ArrayLike | None,
    count: int,
    kinds: tuple[tuple[type, ...], str],
    averaged: bool,
) -> Consequents:
    if len(sets) != count or len({len(row) for row in sets}) != 1:
        raise InvalidValue(
            "consequents",
            len(sets),
            f"a set, or a list with a set for each output, for each of {count} rules",
        )
    none = np.array([[item is None for item in row] for row in sets])
    mask = _checked_silence(silent, none.shape)
    mask = none if mask is None else none | mask
    rows = tuple(
        tuple(None if no else item for item, no in zip(row, nos, strict=True))
        for row, nos in zip(sets, mask.tolist(), strict=True)
    )
    for row in rows:
        for item in row:
            if item is not None and not isinstance(item, kinds[0]):
                raise InvalidValue("a consequent", item, kinds[1])
    intervals = np.array(
        [
            [(0.0, 0.0) if item is None else _centroid(item, averaged) for item in row]
            for row in rows
        ]
    )
    return Consequents(
        rows,
        rows,
        _read_only(intervals),
        _checked_silence(mask, mask.shape) if mask.any() else None,
    )


def _centroid(item: Any, needed: bool) -> tuple[float, float]:
    """Return the centroid of a consequent, or NaN if it has none and none is needed."""
    try:
        return centroid_interval(item)
    except NotApplicable:
        if needed:
            raise
        return np.nan, np.nan


def _without_none(consequents: Any, silent: ArrayLike | None) -> tuple[Any, Any]:
    """Return consequents with 0 in place of None, and where None was given."""
    try:
        rows = [list(row) for row in consequents]
    except TypeError:
        return consequents, silent
    none = [[item is None for item in row] for row in rows]
    if not any(map(any, none)):
        return consequents, silent
    width = max((np.size(item) for row in rows for item in row if item is not None), default=1)
    blank: Any = 0.0 if width == 1 else (0.0, 0.0)
    filled = [[blank if item is None else item for item in row] for row in rows]
    given = False if silent is None else _truths(silent, np.shape(none))
    return filled, np.array(none) | given


def _truths(silent: ArrayLike, shape: tuple[int, ...]) -> NDArray[np.bool_]:
    """Return an array of booleans of a given shape."""
    try:
        mask = np.asarray(silent)
    except ValueError:  # the rows have different lengths
        mask = np.empty(0)
    if mask.dtype != bool or mask.shape != shape:
        raise InvalidValue("silent", silent, f"True or False, of shape {shape}")
    return mask


def _checked_silence(silent: ArrayLike | None, shape: tuple[int, ...]) -> NDArray[np.bool_] | None:
    """Return the missing consequents as a read-only array, or None if there are none."""
    if silent is None:
        return None
    reals("silent", silent, f"True or False, of shape {shape}")
    mask = _truths(silent, shape)
    mute = np.flatnonzero(mask.all(axis=1))
    if mute.size:
        raise InvalidValue(
            "silent", silent, f"False somewhere in each row: rule {mute[0] + 1} says nothing"
        )
    return _read_only(mask.copy()) if mask.any() else None


def checked_weights(weights: ArrayLike | None, count: int) -> Array | None:
    """Return the weights of the rules as a read-only array, or None if all are 1."""
    if weights is None:
        return None
    given = reals("weights", weights)
    if given.shape != (count,) or not ((given >= 0.0) & (given <= 1.0)).all():
        raise InvalidValue("weights", given, f"{count} numbers in [0, 1], one for each rule")
    return None if (given == 1.0).all() else _read_only(np.array(given))


def checked_defaults(given: Sequence[float | None] | None, outputs: int) -> Array | None:
    """Return the default outputs (m,), NaN for missing ones; None if there are none at all."""
    if given is None:
        return None
    requirement = f"{outputs} finite numbers, or None where there is none"
    values = [
        float("nan") if value is None else value
        for value in listed("default_outputs", given, requirement)
    ]
    defaults = reals("default_outputs", values)
    if defaults.shape != (outputs,) or np.isinf(defaults).any():
        raise InvalidValue("default_outputs", given, requirement)
    return None if np.isnan(defaults).all() else _read_only(defaults)


def checked_shares(given: Sequence[float]) -> tuple[float, float]:
    """Return the weights of the lower and of the upper average."""
    shares = tuple(real("shares", value) for value in listed("shares", given, "two numbers"))
    if len(shares) != 2:
        raise InvalidValue("shares", given, "two numbers")
    return shares[0], shares[1]


def checked_terms(
    given: Sequence[Sequence[str]] | None, inputs: Sequence[Sequence[Any]]
) -> tuple[tuple[str, ...], ...]:
    """Return the names of the terms of each input."""
    requirement = f"a list of names for each of the {len(inputs)} inputs"
    names = (None,) * len(inputs) if given is None else listed("term_names", given, requirement)
    if len(names) != len(inputs):
        raise InvalidValue("term_names", given, requirement)
    return tuple(
        checked_names("term_names", own, len(terms), "term")
        for own, terms in zip(names, inputs, strict=True)
    )


def _read_only(array: Any) -> Any:
    array.flags.writeable = False
    return array
