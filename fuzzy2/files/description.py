"""Description of a system in the terms of other programs' files.

It consists of named variables with named terms, rules with numbers, and operators.

This module converts between descriptions and systems, in both directions and for every format.
Consequents that are sets (Mamdani) are reduced by type reductions that unite them, or by
Tsukamoto's; numbers and linear functions (Takagi, Sugeno, Kang) by averages. The writer of a format
refuses whatever the format cannot express.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from fuzzy2.errors import NotExpressible
from fuzzy2.files.operator_words import check_operators
from fuzzy2.operations.set_operations import complement
from fuzzy2.sets.derived import Truncated
from fuzzy2.sets.interval_type2 import IntervalType2Set
from fuzzy2.sets.type1 import Singleton, Type1Set
from fuzzy2.support.checks import Array
from fuzzy2.systems.antecedents import Antecedent, trees_of
from fuzzy2.systems.consequents import Linear
from fuzzy2.systems.operators import AGGREGATIONS, UNIONS
from fuzzy2.systems.system import FuzzySystem, IntervalType2System, Type1System
from fuzzy2.systems.terms import domain_of

SUM = "sum"
"""Name of the aggregation that adds the output sets of the rules instead of uniting them."""

SILENT = -1
"""Number of a missing term: the rule has no consequent for the output."""


class Constant(NamedTuple):
    """Consequent that is an interval, or a number if both ends are equal."""

    left: float
    right: float


class LinearFunction(NamedTuple):
    """Consequent that is a linear function of the inputs.

    ``spreads``, if given, are half-widths of the constant and of the slopes, as in
    :class:`fuzzy2.systems.consequents.Linear`.
    """

    constant: float
    slopes: tuple[float, ...]
    spreads: tuple[float, ...] = ()


class DescribedRule(NamedTuple):
    """Antecedent, consequents and weight of a rule.

    ``asked`` is the antecedent, a tree with numbers of inputs and terms. ``said`` holds the number
    of the term of each output, or ``SILENT``. ``weight`` is a factor of the firing.
    """

    asked: Antecedent
    said: tuple[int, ...]
    weight: float = 1.0


@dataclass(frozen=True)
class Variable:
    """An input or an output.

    Terms are sets by name; outputs of a Takagi-Sugeno-Kang system have constants and functions
    instead. ``default`` is the output where no rule fires; None stands for NaN.
    """

    name: str
    range: tuple[float, float]
    terms: dict[str, Any]
    default: float | None = None


@dataclass(frozen=True)
class Description:
    """A system as files describe it.

    Parameters
    ----------
    inputs, outputs : tuple of Variable
        The variables.
    rules : tuple of DescribedRule
        The rules, by number.
    t_norm, disjunction : str
        T-norm of *and* and t-conorm of *or*.
    mamdani : bool
        Whether consequents are sets; otherwise they are numbers and functions.
    implication : str, optional
        T-norm that clips or scales sets by the firing; ``t_norm`` by default.
    aggregation : str
        How sets are united; ``SUM`` adds them. For numbers, see ``reduction``.
    reduction : str, optional
        Type reduction, a name in :mod:`fuzzy2.systems.operators`. The default is ``"centroid"`` for
        sets and ``"center_of_sets"`` for numbers. ``"center_of_sums"`` is ``"centroid"`` with the
        aggregation ``SUM``.
    type2 : bool
        Whether it is an interval type-2 system.
    method, shares : str and (float, float)
        Method of type reduction, and the shares of ``"begian_melek_mendel"``.
    integration, resolution : str and int
        How centroids are computed, and the number of points of a sum.
    options : dict
        Other arguments of the system.
    """

    inputs: tuple[Variable, ...]
    outputs: tuple[Variable, ...]
    rules: tuple[DescribedRule, ...]
    t_norm: str
    mamdani: bool
    aggregation: str = "max"
    type2: bool = False
    method: str = "eiasc"
    options: dict[str, Any] = field(default_factory=dict)
    disjunction: str = "max"
    implication: str | None = None
    reduction: str | None = None
    shares: tuple[float, float] = (0.5, 0.5)
    integration: str = "sum"
    resolution: int = 501

    @property
    def reduced_by(self) -> str:
        """The type reduction; by default that for the kind of consequents."""
        return self.reduction or ("centroid" if self.mamdani else "center_of_sets")

    @property
    def implied_by(self) -> str:
        """The t-norm of the implication."""
        return self.implication or self.t_norm


def system_of(description: Description) -> FuzzySystem:
    """Return the system of a description.

    Output sets are cut off at the ends of their output's range, except for Tsukamoto's average,
    which may use points anywhere.
    """
    outputs = description.outputs
    anywhere = description.reduced_by == "tsukamoto"
    terms = [_meanings(output, description.mamdani and not anywhere) for output in outputs]
    silent = np.array(
        [[number == SILENT for number in rule.said] for rule in description.rules], dtype=bool
    )
    names = [
        [
            "" if number == SILENT else list(output.terms)[number]
            for output, number in zip(outputs, rule.said, strict=True)
        ]
        for rule in description.rules
    ]
    said = [
        [
            None if number == SILENT else list(of.values())[number]
            for of, number in zip(terms, rule.said, strict=True)
        ]
        for rule in description.rules
    ]
    consequents: Any = said
    if not description.mamdani:
        consequents = numbers_of(said, len(description.inputs))
    reduction, t_conorm = description.reduced_by, description.aggregation
    if reduction == "centroid" and t_conorm == SUM:
        reduction, t_conorm = "center_of_sums", "max"
    functions = any(isinstance(term, LinearFunction) for of in terms for term in of.values())
    defaults = [output.default for output in outputs]
    arguments: dict[str, Any] = {
        "t_norm": description.t_norm,
        "type_reduction": reduction,
        "method": description.method,
        "t_conorm": t_conorm,
        "disjunction": description.disjunction,
        "implication": description.implication,
        "weights": [rule.weight for rule in description.rules],
        "silent": silent if silent.any() else None,
        "default_outputs": None if all(value is None for value in defaults) else defaults,
        "shares": description.shares,
        "integration": description.integration,
        "resolution": description.resolution,
        "input_names": [variable.name for variable in description.inputs],
        "output_names": [variable.name for variable in outputs],
        "term_names": [list(variable.terms) for variable in description.inputs],
        "consequent_names": names,
        "input_ranges": [variable.range for variable in description.inputs],
        "output_ranges": None if anywhere else [variable.range for variable in outputs],
        "output_terms": None if functions else terms,
    }
    rules: Any = [rule.asked for rule in description.rules]
    return (IntervalType2System if description.type2 else Type1System)(
        [list(variable.terms.values()) for variable in description.inputs],
        rules,
        consequents,
        **{**arguments, **description.options},
    )


def _meanings(output: Variable, mamdani: bool) -> dict[str, Any]:
    if not mamdani:
        return output.terms
    return {name: _cut(term, output.range) for name, term in output.terms.items()}


def negated(variable: Variable, number: int) -> int:
    """Return the number of the complement of an output's term.

    If the complement does not exist yet, it is added as a term named *not* and the term's name.
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
    """Return the description of a system; ``where`` is the format that it is made for.

    Raises
    ------
    NotExpressible
        If the system has parts that no format can express.
    """
    if not isinstance(system, Type1System | IntervalType2System):
        raise NotExpressible(
            type(system).__name__, where, "only type-1 and interval type-2 systems can; use JSON"
        )
    if system.fuzzifier is not None:
        raise NotExpressible(
            f"the fuzzifier {system.fuzzifier!r}", where, "its inputs are numbers; use JSON"
        )
    check_operators(system, where)
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
    of_sets = system.consequent_sets is not None
    if of_sets and system.type_reduction not in (*UNIONS, "tsukamoto"):
        reason = (
            'output sets are united or summed there; take "centroid" or "center_of_sums", or '
            "numbers for consequents"
        )
        raise NotExpressible(f"type reduction {system.type_reduction!r}", where, reason)
    columns = _columns(system)
    outputs, said = [], []
    for j, column in enumerate(columns):
        variable, numbers = _output(system, j, column, where)
        outputs.append(variable)
        said.append(numbers)
    trees = system.rules if isinstance(system.rules, tuple) else trees_of(system.rules)
    weights = [1.0] * len(trees) if system.weights is None else system.weights.tolist()
    summed = system.type_reduction == "center_of_sums" or system.t_conorm is AGGREGATIONS[SUM]
    return Description(
        inputs,
        tuple(outputs),
        tuple(
            DescribedRule(tree, terms, weight)
            for tree, terms, weight in zip(trees, zip(*said, strict=True), weights, strict=True)
        ),
        system.t_norm.name,
        of_sets,
        SUM if summed else system.t_conorm.name,
        isinstance(system, IntervalType2System),
        system.method,
        disjunction=system.disjunction.name,
        implication=system.implication.name,
        reduction="centroid"
        if system.type_reduction == "center_of_sums"
        else (system.type_reduction),
        shares=system.shares,
        integration=system.integration,
        resolution=system.resolution,
    )


def _columns(system: FuzzySystem) -> list[tuple[tuple[float, float] | None, list[Any]]]:
    """Return the range and the consequents of each output; None where a rule has none."""
    ranges = system.output_ranges or (None,) * system.n_outputs
    if system.consequent_sets is not None:
        of_sets = system.consequent_sets
        return [_whole([row[j] for row in of_sets], ends) for j, ends in enumerate(ranges)]
    return [(ends, list(said_numbers(system, j))) for j, ends in enumerate(ranges)]


def said_numbers(system: FuzzySystem, j: int) -> list[Constant | LinearFunction | None]:
    """Return the consequents of an output of numbers or functions; None where a rule has none."""
    consequents, silent = system.consequents, system.silent
    said: list[Constant | LinearFunction]
    if isinstance(consequents, Linear):
        both = zip(
            consequents.coefficients[:, j].tolist(),
            consequents.spreads[:, j].tolist(),
            strict=True,
        )
        said = [
            LinearFunction(row[0], tuple(row[1:]), tuple(spreads) if any(spreads) else ())
            for row, spreads in both
        ]
    else:
        intervals = np.asarray(system.consequent_intervals)[:, j].astype(float)
        said = [Constant(*ends) for ends in intervals.tolist()]
    return [None if silent is not None and silent[r, j] else one for r, one in enumerate(said)]


def _output(
    system: FuzzySystem,
    j: int,
    found: tuple[tuple[float, float] | None, list[Any]],
    where: str,
) -> tuple[Variable, list[int]]:
    """Return an output, and the number of its term in each rule."""
    (ends, column), name = found, system.output_names[j]
    known = {} if system.output_terms is None else dict(system.output_terms[j])
    terms = {word: _described(meaning, ends) for word, meaning in known.items()}
    words = (
        _numbered(column)
        if system.consequent_names is None
        else [row[j] for row in system.consequent_names]
    )
    for word, term in zip(words, column, strict=True):
        if term is not None and terms.setdefault(word, term) != term:
            raise NotExpressible(
                f"the name {word!r} for two consequents of {name}",
                where,
                "a name stands for one term",
            )
    numbers = [
        SILENT if term is None else list(terms).index(word)
        for word, term in zip(words, column, strict=True)
    ]
    default = None if system.default_outputs is None else float(system.default_outputs[j])
    if default is not None and np.isnan(default):
        default = None
    return Variable(name, ends or _limits_of(terms.values()), terms, default), numbers


def _described(meaning: Any, ends: tuple[float, float] | None) -> Any:
    """Return a term of an output in the form of descriptions."""
    if isinstance(meaning, Type1Set | IntervalType2Set):
        return meaning if ends is None else _whole([meaning], ends)[1][0]
    left, right = np.broadcast_to(np.asarray(meaning, dtype=float), 2).tolist()
    return Constant(left, right)


def numbers_of(said: list[list[Any]], inputs: int) -> Linear | Array:
    """Return the consequents of a Takagi-Sugeno-Kang system, by rule and output.

    They have the simplest possible form, and are 0 where a rule has no consequent.
    """
    rows = [[Constant(0.0, 0.0) if term is None else term for term in row] for row in said]
    if any(isinstance(term, LinearFunction) for row in rows for term in row):
        functions = [[_as_function(term, inputs) for term in row] for row in rows]
        return Linear(
            [[(one.constant, *one.slopes) for one in row] for row in functions],
            [[one.spreads for one in row] for row in functions],
        )
    intervals = np.array(rows)
    return intervals[..., 0] if (intervals[..., 0] == intervals[..., 1]).all() else intervals


def _as_function(term: Constant | LinearFunction, inputs: int) -> LinearFunction:
    """Return a consequent as a function with spreads."""
    none = (0.0,) * inputs
    if isinstance(term, LinearFunction):
        return term if term.spreads else term._replace(spreads=(0.0, *none))
    middle = 0.5 * term.left + 0.5 * term.right
    return LinearFunction(middle, none, (0.5 * (term.right - term.left), *none))


def _limits(values: Any) -> tuple[float, float]:
    """Return the least and the greatest number; if they are equal, make them differ.

    All constants may be equal, but readers refuse a range without a width.
    """
    low, high = float(np.min(values)), float(np.max(values))
    margin = 0.0 if low < high else max(1.0, 0.5 * abs(low))
    return low - margin, high + margin


def _limits_of(terms: Iterable[Any]) -> tuple[float, float]:
    """Return the least and the greatest number of constants and functions."""
    values = [
        value
        for term in terms
        for value in ((term.constant, *term.slopes) if isinstance(term, LinearFunction) else term)
    ]
    return _limits(values) if values else (0.0, 1.0)


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
    """Return names for the terms of a column, numbered in order; equal terms share a name."""
    distinct: list[Any] = []
    for term in column:
        if term is not None and term not in distinct:
            distinct.append(term)
    return ["" if term is None else f"term{distinct.index(term) + 1}" for term in column]


def _whole(
    column: list[Any], given: tuple[float, float] | None
) -> tuple[tuple[float, float], list[Any]]:
    """Return the range on which output sets are evaluated, and the sets before they were cut off.

    Sets were cut off at the ends of the range when the system was read.
    """
    ends = given or domain_of([term for term in column if term is not None] or [Singleton(0.0)])

    def whole(term: Type1Set) -> Type1Set:
        if not isinstance(term, Truncated):
            return term
        left, right = term.whole.support
        # A set that was cut off inside the range is a different set on the range.
        inside = (term.left > ends[0] and term.left > left) or (
            term.right < ends[1] and term.right < right
        )
        return term if inside else term.whole

    sets: list[Any] = []
    for term in column:
        if term is None:
            sets.append(None)
        elif isinstance(term, IntervalType2Set):
            lower, upper = whole(term.lower), whole(term.upper)
            sets.append(
                term
                if (lower, upper) == (term.lower, term.upper)
                else IntervalType2Set(lower=lower, upper=upper)
            )
        else:
            sets.append(whole(term))
    return _limits(ends), sets


def check_crisp(term: LinearFunction, where: str) -> None:
    """Refuse a function with spreads.

    Raises
    ------
    NotExpressible
        If the function has spreads.
    """
    if term.spreads:
        raise NotExpressible(
            "linear consequents with spreads", where, "its linear functions are crisp; use JSON"
        )


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
