"""What the files of other programs say of a system.

Named variables with named terms, rules by number, and the operators.

Both ways between such a description and a system, for every format. Consequents that are sets
(Mamdani) go with the reducers on a grid, ``"centroid"`` and ``"center_of_sums"``; numbers and
linear functions (Takagi, Sugeno, Kang) with ``"center_of_sets"``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from fuzzy2.errors import NotExpressible
from fuzzy2.operations.set_operations import complement
from fuzzy2.operations.t_norms import T_CONORMS, T_NORMS
from fuzzy2.sets.derived import Truncated
from fuzzy2.sets.interval_type2 import IntervalType2Set
from fuzzy2.sets.type1 import Type1Set
from fuzzy2.support.checks import Array
from fuzzy2.systems.consequents import Linear
from fuzzy2.systems.operators import AGGREGATIONS, DIRECT_METHODS
from fuzzy2.systems.system import FuzzySystem, IntervalType2System, Type1System
from fuzzy2.systems.terms import domain_of

Rules: TypeAlias = tuple[tuple[tuple[int, ...], tuple[int, ...]], ...]
"""Pairs of numbers of terms: of all inputs, -1 for any, and of all outputs."""

SUM = "sum"
"""Name of the aggregation that adds the output sets of the rules instead of uniting them."""


class Constant(NamedTuple):
    """Consequent that is an interval, or a number if its ends are equal."""

    left: float
    right: float


class LinearFunction(NamedTuple):
    """Consequent that is a linear function of the inputs."""

    constant: float
    slopes: tuple[float, ...]


@dataclass(frozen=True)
class Variable:
    """An input or an output.

    Terms are sets by name, or for the outputs of a Takagi-Sugeno-Kang system constants and
    functions.
    """

    name: str
    range: tuple[float, float]
    terms: dict[str, Any]


@dataclass(frozen=True)
class Description:
    """A system as files describe it.

    ``rules`` are pairs of numbers of terms, of all inputs (-1: any) and of all outputs.
    """

    inputs: tuple[Variable, ...]
    outputs: tuple[Variable, ...]
    rules: Rules
    t_norm: str
    mamdani: bool
    aggregation: str = "max"
    type2: bool = False
    method: str = "eiasc"
    options: dict[str, Any] = field(default_factory=dict)


def system_of(description: Description) -> FuzzySystem:
    """Return the system that a description is of.

    Output sets are cut off at the ends of the range of their output.
    """
    consequents: Any
    names = [list(output.terms) for output in description.outputs]
    if description.mamdani:
        cut = [
            [_cut(term, output.range) for term in output.terms.values()]
            for output in description.outputs
        ]
        consequents = [
            [cut[j][term] for j, term in enumerate(said)] for _, said in description.rules
        ]
        reduction = "center_of_sums" if description.aggregation == SUM else "centroid"
    else:
        terms = [list(output.terms.values()) for output in description.outputs]
        said_by_rule = [
            [terms[j][term] for j, term in enumerate(said)] for _, said in description.rules
        ]
        consequents, reduction = _numbers(said_by_rule, len(description.inputs)), "center_of_sets"
    return (IntervalType2System if description.type2 else Type1System)(
        [list(variable.terms.values()) for variable in description.inputs],
        np.array([asked for asked, _ in description.rules]),
        consequents,
        t_norm=description.t_norm,
        type_reduction=reduction,
        method=description.method,
        t_conorm="max" if description.aggregation == SUM else description.aggregation,
        input_names=[variable.name for variable in description.inputs],
        output_names=[variable.name for variable in description.outputs],
        term_names=[list(variable.terms) for variable in description.inputs],
        consequent_names=[
            [names[j][term] for j, term in enumerate(said)] for _, said in description.rules
        ],
        input_ranges=[variable.range for variable in description.inputs],
        integration="sum",
        **{
            "output_ranges": [variable.range for variable in description.outputs],
            **description.options,
        },
    )


def negated(variable: Variable, number: int) -> int:
    """Return the number of the complement of a term.

    If it is none yet, it becomes a term of its own, *not* with its name.
    """
    name = list(variable.terms)[number]
    opposite = complement(variable.terms[name])
    for other, term in enumerate(variable.terms.values()):
        if term == opposite:
            return other
    while name in variable.terms:
        name = f"not {name}"
    variable.terms[name] = opposite
    return len(variable.terms) - 1


def description_of(system: FuzzySystem, where: str) -> Description:
    """Return the description of a system; ``where`` is the format for which it is made.

    Raises
    ------
    NotExpressible
        If the system has parts for which no format has a word.
    """
    if not isinstance(system, Type1System | IntervalType2System):
        raise NotExpressible(
            type(system).__name__, where, "only type-1 and interval type-2 systems can; use JSON"
        )
    if system.fuzzifier is not None:
        raise NotExpressible(
            f"the fuzzifier {system.fuzzifier!r}", where, "its inputs are numbers; use JSON"
        )
    _check_operators(system, where)
    inputs = tuple(
        Variable(name, ends or _limits(domain_of(terms)), dict(zip(names, terms, strict=True)))
        for name, ends, names, terms in zip(
            system.input_names,
            system.input_ranges or (None,) * len(system.inputs),
            system.term_names,
            system.inputs,
            strict=True,
        )
    )
    ranges = system.output_ranges or (None,) * system.n_outputs
    consequents = system.consequents
    if system.consequent_sets is not None:
        columns = [_whole([row[j] for row in consequents], ends) for j, ends in enumerate(ranges)]
        if system.type_reduction not in ("centroid", "center_of_sums"):
            reason = (
                'output sets are united or summed there; take "centroid" or "center_of_sums", or '
                "numbers for consequents"
            )
            raise NotExpressible(f"type reduction {system.type_reduction!r}", where, reason)
    elif isinstance(consequents, Linear):
        if consequents.spreads.any():
            raise NotExpressible(
                "linear consequents with spreads", where, "its linear functions are crisp"
            )
        functions = np.moveaxis(consequents.coefficients, 1, 0).tolist()
        columns = [
            (_limits(column), [LinearFunction(row[0], tuple(row[1:])) for row in column])
            for column in functions
        ]
    else:
        values = (
            np.stack([consequents, consequents], axis=-1) if consequents.ndim == 2 else consequents
        )
        intervals = np.moveaxis(values, 1, 0).astype(float).tolist()
        columns = [(_limits(column), [Constant(*row) for row in column]) for column in intervals]
    outputs, said = [], []
    for j, (name, (limits, column)) in enumerate(zip(system.output_names, columns, strict=True)):
        words = (
            _numbered(column)
            if system.consequent_names is None
            else [row[j] for row in system.consequent_names]
        )
        terms: dict[str, Any] = {}
        for word, term in zip(words, column, strict=True):
            if terms.setdefault(word, term) != term:
                raise NotExpressible(
                    f"the name {word!r} for two consequents of {name}",
                    where,
                    "a name stands for one term",
                )
        outputs.append(Variable(name, ranges[j] or limits, terms))
        said.append([list(terms).index(word) for word in words])
    return Description(
        inputs,
        tuple(outputs),
        tuple(
            (tuple(asked), tuple(terms))
            for asked, terms in zip(system.rules.tolist(), zip(*said, strict=True), strict=True)
        ),
        system.t_norm.name,
        system.consequent_sets is not None,
        SUM if system.type_reduction == "center_of_sums" else system.t_conorm.name,
        isinstance(system, IntervalType2System),
        system.method,
    )


def _check_operators(system: FuzzySystem, where: str) -> None:
    """Refuse what no format is written with."""
    if isinstance(system.rules, tuple):
        raise NotExpressible("a rule with or, not or hedges", where, "use JSON")
    for what, value in (
        ("rule weights", system.weights),
        ("rules that leave outputs out", system.silent),
        ("default outputs", system.default_outputs),
    ):
        if value is not None:
            raise NotExpressible(what, where, "use JSON")
    if system.implication is not system.t_norm:
        raise NotExpressible("another implication than the t-norm", where, "use JSON")
    if system.t_conorm is AGGREGATIONS["sum"] or system.method in DIRECT_METHODS:
        raise NotExpressible(f"the method {system.method!r} or the sum", where, "use JSON")
    for kind, norm, known in (
        ("t-norm", system.t_norm, T_NORMS),
        ("t-conorm", system.t_conorm, T_CONORMS),
    ):
        if known.get(norm.name) is not norm:
            raise NotExpressible(f"the {kind} {norm.name!r}", where, "it is a Python function")


def alternatives(asked: Sequence[int]) -> list[tuple[int, ...]]:
    """Return one rule for each antecedent of a rule that joins them by *or*.

    Under the maximum, of *or* and of the aggregation, the rules together do what the one does:
    t-norms distribute over it.
    """
    return [
        tuple(term if i == j else -1 for i, term in enumerate(asked))
        for j, used in enumerate(asked)
        if used >= 0
    ]


def _numbers(said: list[list[Constant | LinearFunction]], inputs: int) -> Linear | Array:
    """Return the consequents of a Takagi-Sugeno-Kang system, by rule and output.

    In the simplest form that holds them.
    """
    if any(isinstance(term, LinearFunction) for row in said for term in row):
        none = (0.0,) * inputs
        functions = [
            [
                (*term, 0.0)
                if isinstance(term, LinearFunction)
                else (0.5 * term.left + 0.5 * term.right, none, 0.5 * (term.right - term.left))
                for term in row
            ]
            for row in said
        ]
        coefficients = [[(constant, *slopes) for constant, slopes, _ in row] for row in functions]
        return Linear(
            coefficients, [[(spread, *none) for _, _, spread in row] for row in functions]
        )
    intervals = np.array(said)
    return intervals[..., 0] if (intervals[..., 0] == intervals[..., 1]).all() else intervals


def _limits(values: Any) -> tuple[float, float]:
    return float(np.min(values)), float(np.max(values))


def _cut(term: Any, ends: tuple[float, float]) -> Any:
    if isinstance(term, IntervalType2Set):
        lower, upper = _cut(term.lower, ends), _cut(term.upper, ends)
        return (
            term
            if (lower, upper) == (term.lower, term.upper)
            else IntervalType2Set(lower=lower, upper=upper)
        )
    left, right = term.support
    return term if ends[0] <= left and right <= ends[1] else Truncated(term, *ends)


def _numbered(column: list[Any]) -> list[str]:
    """Return names for the terms of a column, numbered as they come; equal terms have one name."""
    distinct: list[Any] = []
    for term in column:
        if term not in distinct:
            distinct.append(term)
    return [f"term{distinct.index(term) + 1}" for term in column]


def _whole(
    column: list[Any], given: tuple[float, float] | None
) -> tuple[tuple[float, float], list[Any]]:
    """Return the range on which output sets are evaluated, and the uncut sets.

    The sets are those before they were cut off at the ends of the range.
    """
    ends = given or domain_of(column)

    def whole(term: Type1Set) -> Type1Set:
        if not isinstance(term, Truncated):
            return term
        left, right = term.whole.support
        # A set that was cut off further in is another one on the range.
        inside = (term.left > ends[0] and term.left > left) or (
            term.right < ends[1] and term.right < right
        )
        return term if inside else term.whole

    sets: list[Any] = []
    for term in column:
        if isinstance(term, IntervalType2Set):
            lower, upper = whole(term.lower), whole(term.upper)
            sets.append(
                term
                if (lower, upper) == (term.lower, term.upper)
                else IntervalType2Set(lower=lower, upper=upper)
            )
        else:
            sets.append(whole(term))
    return (float(ends[0]), float(ends[1])), sets


def check_names(description: Description, where: str) -> None:
    """Refuse names that a line of text cannot hold.

    Raises
    ------
    NotExpressible
        If a name has a line break or another control character in it.
    """
    for variable in (*description.inputs, *description.outputs):
        for name in (variable.name, *variable.terms):
            if not name.isprintable():
                raise NotExpressible(
                    f"the name {name!r}", where, "it has a character in it that cannot be printed"
                )
