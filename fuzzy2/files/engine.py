"""Contents of fuzzylite and IEC 61131-7 files, in which every output has its own operators.

An :class:`Engine` is the intermediate form between text and system, in both directions. Beyond
:mod:`fuzzy2.files.description` it has operators for each output and each block of rules, outputs in
conditions, formulas, and names instead of numbers. Consecutive outputs with the same operators
become one system. If there are several such systems, they become a :class:`fuzzy2.ParallelSystem`.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from fuzzy2.files.description import SUM, Constant, LinearFunction, numbers_of
from fuzzy2.files.functions import NUMBERS, FormulaFunction, formula_of
from fuzzy2.sets.type1 import Singleton
from fuzzy2.support.formula import Formula
from fuzzy2.systems.antecedents import And, Antecedent, Hedged, Is, Not, Or, leaves, mapped
from fuzzy2.systems.consequents import Formulas, OutputOf
from fuzzy2.systems.hedges import Hedge, Scaled
from fuzzy2.systems.operators import UNIONS
from fuzzy2.systems.parallel import ParallelSystem
from fuzzy2.systems.system import Type1System

AnySystem: TypeAlias = Type1System | ParallelSystem

_DEEPEST = 100
"""Greatest depth of a rule; people write about three levels."""
_MOST_CLAUSES = 1000
"""Greatest number of clauses of a rule, including those of the rules that replace its outputs."""


class Defuzzifier(NamedTuple):
    """Defuzzifier of an output: a type reduction, and the number of points that it sums over.

    ``resolution`` is None if the integral is exact or there is none.
    """

    reduction: str
    resolution: int | None = None
    integration: str = "midpoint"


@dataclass(frozen=True)
class Input:
    """An input: its range, which is None if it has no ends, and its terms by name."""

    name: str
    range: tuple[float, float] | None
    terms: dict[str, Any]


@dataclass(frozen=True)
class Output:
    """An output.

    Terms are sets, constants or functions by name. ``aggregation`` is None if none is given.
    ``default`` is the output where no rule fires, and NaN if there is no default.
    """

    name: str
    range: tuple[float, float] | None
    terms: dict[str, Any]
    defuzzifier: Defuzzifier
    aggregation: str | None = "max"
    default: float = math.nan


@dataclass(frozen=True)
class EngineRule:
    """A rule with names, its place in the file and the operators of its block."""

    place: int
    asked: Antecedent
    said: tuple[tuple[str, str], ...]
    weight: float = 1.0
    conjunction: str | None = "min"
    disjunction: str | None = "max"
    implication: str | None = "min"


@dataclass(frozen=True)
class Engine:
    """Inputs, outputs and rules, in the order of the file."""

    name: str
    inputs: tuple[Input, ...]
    outputs: tuple[Output, ...]
    rules: tuple[EngineRule, ...]


class _Spoken(NamedTuple):
    """A rule for an output: its tree without other outputs, and the operators that it uses."""

    rule: EngineRule
    tree: Antecedent
    term: str
    both: frozenset[str]
    either: frozenset[str]


def _joint(first: tuple[Any, ...], second: tuple[Any, ...]) -> tuple[Any, ...] | None:
    """Return operators that suit both of two outputs, or None; unused operators are None."""
    named = []
    for one, other in zip(first[0], second[0], strict=True):
        if None not in (one, other) and one != other:
            return None
        named.append(one or other)
    return (tuple(named), *first[1:]) if first[1:] == second[1:] else None


def _weighted(one: _Spoken) -> Antecedent:
    """Return a rule's tree, multiplied by its weight."""
    weight = one.rule.weight
    if weight == 1.0:
        return one.tree
    return Hedged(Hedge(f"with {weight:g}", function=Scaled(weight)), one.tree)


def depth_of(tree: Antecedent) -> int:
    """Return the number of levels of a tree."""
    deepest, level = 0, [tree]
    while level:
        deepest += 1
        level = _below(level)
    return deepest


def _below(level: Sequence[Antecedent]) -> list[Antecedent]:
    """Return the direct parts of trees."""
    parts: list[Antecedent] = []
    for one in level:
        if isinstance(one, And | Or):
            parts += one.parts
        elif isinstance(one, Not | Hedged):
            parts.append(one.part)
    return parts


class SystemMaker:
    """Makes the system of an engine.

    Parameters
    ----------
    engine : Engine
        Content of the file.
    refused : callable
        Takes the place in the file, the refused part and the reason, and returns the error.
    """

    def __init__(self, engine: Engine, refused: Any) -> None:
        self._engine, self._refused = engine, refused
        self._inputs = [one.name for one in engine.inputs]
        self._spoken: dict[str, list[_Spoken]] = {one.name: [] for one in engine.outputs}
        self._known: dict[str, OutputOf] = {}
        self._aggregations = {one.name: one.aggregation for one in engine.outputs}
        for rule in engine.rules:
            if depth_of(rule.asked) > _DEEPEST:
                raise refused(rule.place, "a rule nested this deeply", f"at most {_DEEPEST} levels")
            tree, both, either = self._resolved(rule)
            for output, term in rule.said:
                self._spoken[output].append(_Spoken(rule, tree, term, both, either))
        for one in engine.outputs:
            if one.defuzzifier.reduction == "center_of_sets" and one.aggregation is not None:
                self._merge(one)

    def _merge(self, output: Output) -> None:
        """Join the rules of an average that have the same consequent into one, with *or*."""
        merged: dict[str, _Spoken] = {}
        for one in self._spoken[output.name]:
            first = merged.setdefault(one.term, one)
            if first is one:
                continue
            parts = first.tree.parts if first.rule.place < 0 and isinstance(first.tree, Or) else ()
            tree = Or((*(parts or (_weighted(first),)), _weighted(one)))
            either = first.either | one.either | {str(output.aggregation)}
            rule = EngineRule(-1, tree, ((output.name, one.term),))
            merged[one.term] = _Spoken(rule, tree, one.term, first.both | one.both, either)
        self._spoken[output.name] = list(merged.values())

    def _resolved(self, rule: EngineRule) -> tuple[Antecedent, frozenset[str], frozenset[str]]:
        """Return a rule's tree, with outputs replaced by the earlier rules that conclude them."""
        both: set[str] = set()
        either: set[str] = set()
        for kind, name, found in (
            (And, rule.conjunction, both),
            (Or, rule.disjunction, either),
        ):
            if has_part(rule.asked, kind):
                if name is None:
                    word = "and" if kind is And else "or"
                    raise self._refused(
                        rule.place, f'a rule with "{word}"', "its block does not define it"
                    )
                found.add(name)

        def resolved(clause: Is) -> Antecedent:
            if clause.variable in self._inputs:
                return clause
            before = self._before(rule, str(clause.variable), clause.term)
            for one in before:
                both.update(one.both)
                either.update(one.either)
            if not before:
                # A term that no rule has concluded holds to the degree 0.
                return Not(Is(self._inputs[0], None))
            if len(before) == 1:
                return _weighted(before[0])
            either.add(self._aggregations[str(clause.variable)] or SUM)
            return Or(tuple(_weighted(one) for one in before))

        tree = mapped(rule.asked, resolved)
        # Counted only up to the limit, because every link of a chain of rules doubles the tree.
        many = sum(1 for _ in islice(leaves(tree), _MOST_CLAUSES + 1)) > _MOST_CLAUSES
        if many or depth_of(tree) > _DEEPEST:
            raise self._refused(
                rule.place, "a chain of rules this long", "outputs stand in for their rules"
            )
        return tree, frozenset(both), frozenset(either)

    def _before(self, rule: EngineRule, output: str, term: Any) -> list[_Spoken]:
        if term is None:
            return [_Spoken(rule, Is(self._inputs[0], None), "", frozenset(), frozenset())]
        return [one for one in self._spoken[output] if one.term == term]

    def system(self) -> AnySystem:
        """Return the system."""
        systems: list[Type1System] = []
        group: list[Output] = []
        shared: tuple[Any, ...] | None = None
        for operators, output in self._keyed():
            joint = None if shared is None else _joint(shared, operators)
            asked = self._asked_by(output)
            if shared is not None and (joint is None or asked & {one.name for one in group}):
                systems.append(self._made(shared, group))
                self._take(systems[-1])
                group, joint = [], None
            shared = operators if joint is None else joint
            group.append(output)
            self._check_asked(output, asked)
        assert shared is not None
        systems.append(self._made(shared, group))
        return systems[0] if len(systems) == 1 else ParallelSystem(systems)

    def _asked_by(self, output: Output) -> set[str]:
        """Return the other outputs that the formulas of an output use."""
        names = {one.name for one in self._engine.outputs}
        said = (output.terms[one.term] for one in self._spoken[output.name])
        formulas = (Formula(term.text) for term in said if isinstance(term, FormulaFunction))
        return {name for one in formulas for name in one.names if name in names}

    def _take(self, system: Type1System) -> None:
        for j, name in enumerate(system.output_names):
            self._known[name] = OutputOf(system, j)

    def _check_asked(self, output: Output, asked: set[str]) -> None:
        """Refuse formulas that use later outputs, or the output itself."""
        for name in sorted(asked.difference(self._known)):
            raise self._refused(
                self._spoken[output.name][0].rule.place,
                f"a formula of {output.name!r} that uses {name!r}",
                "a system does not remember its last outputs; those before it are known",
            )

    def _keyed(self) -> list[tuple[tuple[Any, ...], Output]]:
        """Return the outputs with their operators; one without rules takes those of another."""
        outputs = self._engine.outputs
        known = {one.name: self._operators(one) for one in outputs if self._spoken[one.name]}
        if not known:
            raise self._refused(1, "a system without rules", "no rule has a consequent")
        keyed, last = [], next(iter(known.values()))
        for output in outputs:
            last = known.get(output.name, last)
            keyed.append((last, output))
        return keyed

    def _operators(self, output: Output) -> tuple[Any, ...]:
        """Return what outputs of one system share: operators by name, and the kind of terms."""
        spoken = self._spoken[output.name]
        sets = [not isinstance(output.terms[one.term], NUMBERS) for one in spoken]
        united = output.defuzzifier.reduction in UNIONS
        first = spoken[0].rule.place
        if any(sets) != all(sets):
            raise self._refused(
                first, f"numbers and sets in {output.name!r}", "an output has one kind of terms"
            )
        one_by_name = {
            what: self._one(first, output.name, what, names)
            for what, names in (
                ("conjunction", {name for one in spoken for name in one.both}),
                ("disjunction", {name for one in spoken for name in one.either}),
                (
                    "implication",
                    {one.rule.implication for one in spoken} if united and any(sets) else set(),
                ),
            )
        }
        grouped = output.defuzzifier.reduction == "centroid" and not any(sets)
        if (united or grouped) and output.aggregation is None:
            raise self._refused(first, f"the output {output.name!r}", "it has no aggregation")
        if grouped:
            self._check_grouped(first, output)
        united = united or grouped
        unbounded = output.range is None or output.defuzzifier.reduction == "tsukamoto"
        return (
            tuple(one_by_name.values()),
            output.aggregation if united else "max",
            output.defuzzifier,
            any(sets),
            unbounded,
        )

    def _one(self, place: int, output: str, what: str, names: Iterable[Any]) -> str | None:
        known = sorted({name for name in names if name is not None})
        if what == "implication" and None in set(names):
            raise self._refused(place, f"the output {output!r}", "its rules have no implication")
        if what == "disjunction" and SUM in known:
            raise self._refused(place, f"a sum of rules of {output!r}", "its method unites rules")
        if len(known) > 1:
            raise self._refused(
                place,
                f"rules of {output!r} with different operators ({', '.join(known)})",
                f"an output has one {what}; let the blocks of its rules have the same",
            )
        return known[0] if known else None

    def _check_grouped(self, place: int, output: Output) -> None:
        """Refuse functions, which cannot be grouped by their values."""
        terms = {one.term: output.terms[one.term] for one in self._spoken[output.name]}
        if not all(isinstance(term, Constant) for term in terms.values()):
            raise self._refused(
                place,
                f"the aggregation of the functions of {output.name!r}",
                "rules with the same function are added up; write none",
            )

    def _made(self, operators: tuple[Any, ...], outputs: Sequence[Output]) -> Type1System:
        (both, either, implication), aggregation, defuzzifier, of_sets, unbounded = operators
        names = [output.name for output in outputs]
        spoken = [(j, one) for j, name in enumerate(names) for one in self._spoken[name]]
        order = {id(rule): r for r, rule in enumerate(self._engine.rules)}
        by_rule: dict[int, dict[int, _Spoken]] = {}
        for j, one in sorted(spoken, key=lambda pair: order.get(id(pair[1].rule), len(order))):
            by_rule.setdefault(id(one.rule), {})[j] = one
        rows = [(next(iter(own.values())), own) for own in by_rule.values()]
        said = [[own[j].term if j in own else None for j in range(len(names))] for _, own in rows]
        silent = np.array([[term is None for term in row] for row in said])
        grouped = defuzzifier.reduction == "centroid" and not of_sets
        consequents = self._consequents(said, outputs, of_sets, grouped)
        inputs = self._engine.inputs
        # The type of the argument does not mention trees, but they are accepted.
        trees: Any = tuple(self._numbered(first.tree) for first, _ in rows)
        weights = np.array([first.rule.weight for first, _ in rows])
        ranges = [one.range for one in inputs if one.range is not None]
        defaults = [None if math.isnan(one.default) else one.default for one in outputs]
        return Type1System(
            [list(one.terms.values()) for one in inputs],
            trees,
            consequents,
            t_norm=both or "min",
            type_reduction=defuzzifier.reduction,
            t_conorm=aggregation,
            disjunction=either or "max",
            implication=implication or "min",
            weights=weights if (weights != 1.0).any() else None,
            silent=silent if silent.any() else None,
            default_outputs=defaults if any(one is not None for one in defaults) else None,
            integration="exact" if defuzzifier.resolution is None else defuzzifier.integration,
            resolution=defuzzifier.resolution or 501,
            input_names=self._inputs,
            output_names=names,
            term_names=[list(one.terms) for one in inputs],
            consequent_names=[["" if term is None else term for term in row] for row in said],
            input_ranges=ranges if len(ranges) == len(inputs) else None,
            output_ranges=None if unbounded else [one.range or (0.0, 1.0) for one in outputs],
            output_terms=_all_terms(outputs, grouped),
        )

    def _numbered(self, tree: Antecedent) -> Antecedent:
        def numbered(clause: Is) -> Is:
            place = self._inputs.index(str(clause.variable))
            if clause.term is None:
                return Is(place, None)
            return Is(place, list(self._engine.inputs[place].terms).index(str(clause.term)))

        return mapped(tree, numbered)

    def _consequents(
        self,
        said: list[list[str | None]],
        outputs: Sequence[Output],
        of_sets: bool,
        grouped: bool,
    ) -> Any:
        terms = [
            [None if name is None else outputs[j].terms[name] for j, name in enumerate(row)]
            for row in said
        ]
        if of_sets:
            return terms
        if grouped:
            return [[None if one is None else Singleton(one.left) for one in row] for row in terms]
        if any(isinstance(one, FormulaFunction) for row in terms for one in row):
            texts = [[formula_of(one, self._inputs) for one in row] for row in terms]
            return Formulas(texts, self._inputs, self._known)
        return numbers_of(terms, len(self._inputs))


def has_part(tree: Antecedent, kind: type) -> bool:
    """Return whether a tree has a part of a given type."""
    level = [tree]
    while level:
        if any(isinstance(one, kind) for one in level):
            return True
        level = _below(level)
    return False


def _all_terms(outputs: Sequence[Output], grouped: bool) -> list[dict[str, Any]] | None:
    """Return the terms of outputs, or None if one is a function, which is not listed."""
    terms = [dict(one.terms) for one in outputs]
    functions = LinearFunction | FormulaFunction
    if any(isinstance(term, functions) for of in terms for term in of.values()):
        return None
    point = Singleton if grouped else float
    return [
        {name: point(one.left) if isinstance(one, Constant) else one for name, one in of.items()}
        for of in terms
    ]
