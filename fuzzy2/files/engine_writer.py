"""The engine of a system, for the formats whose outputs have operators of their own."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from fuzzy2.errors import NotExpressible
from fuzzy2.files.description import (
    SUM,
    Constant,
    LinearFunction,
    check_crisp,
    said_numbers,
)
from fuzzy2.files.engine import AnySystem, Defuzzifier, Engine, EngineRule, Input, Output
from fuzzy2.files.functions import FormulaFunction
from fuzzy2.files.operator_words import check_operators
from fuzzy2.sets.derived import Complement, Truncated
from fuzzy2.sets.type1 import Singleton
from fuzzy2.systems.antecedents import Antecedent, Is, Not, mapped, trees_of
from fuzzy2.systems.consequents import Formulas
from fuzzy2.systems.operators import UNIONS
from fuzzy2.systems.parallel import ParallelSystem
from fuzzy2.systems.system import FuzzySystem, Type1System
from fuzzy2.systems.terms import domain_of

_REDUCTIONS = (
    "center_of_sets",
    "weighted_sum",
    "tsukamoto",
    "centroid",
    "center_of_sums",
    "bisector",
    "smallest_of_maxima",
    "mean_of_maxima",
    "middle_of_maxima",
    "largest_of_maxima",
)


def engine_of(system: AnySystem, name: str, where: str) -> Engine:
    """Return the engine of a system; ``where`` is the format that it is made for.

    Raises
    ------
    NotExpressible
        If the system has parts that such a format cannot express.
    """
    systems = system.systems if isinstance(system, ParallelSystem) else (system,)
    writers = [_Part(_checked(one, where), where) for one in systems]
    inputs = writers[0].inputs()
    for other in writers[1:]:
        if other.inputs() != inputs:
            raise NotExpressible(
                "systems with different terms of an input", where, "an input has one set of terms"
            )
    rules = [rule for writer in writers for rule in writer.rules()]
    return _without_complements(
        Engine(
            name,
            inputs,
            tuple(output for writer in writers for output in writer.outputs()),
            tuple(rules),
        )
    )


def _checked(system: FuzzySystem, where: str) -> Type1System:
    """Return the system if it can be written as an engine."""
    if not isinstance(system, Type1System):
        raise NotExpressible(type(system).__name__, where, "only type-1 systems can; use JSON")
    if system.fuzzifier is not None:
        raise NotExpressible(f"the fuzzifier {system.fuzzifier!r}", where, "use JSON")
    if system.type_reduction not in _REDUCTIONS:
        raise NotExpressible(f"type reduction {system.type_reduction!r}", where, "use JSON")
    check_operators(system, where)
    return system


class _Part:
    """One system of an engine."""

    def __init__(self, system: Type1System, where: str) -> None:
        self._system, self._where = system, where
        self._terms = [self._terms_of(j) for j in range(system.n_outputs)]

    def inputs(self) -> tuple[Input, ...]:
        system = self._system
        ends = system.input_ranges or (None,) * len(system.inputs)
        return tuple(
            Input(name, end, dict(zip(names, terms, strict=True)))
            for name, end, names, terms in zip(
                system.input_names, ends, system.term_names, system.inputs, strict=True
            )
        )

    def outputs(self) -> tuple[Output, ...]:
        system = self._system
        kind = system.type_reduction
        united = kind in UNIONS
        summed = kind == "center_of_sums"
        resolution = None if not united or self._of_points() else self._resolution()
        defaults = system.default_outputs
        return tuple(
            Output(
                name,
                self._range(j),
                self._terms[j][0],
                Defuzzifier("centroid" if summed else kind, resolution, system.integration),
                SUM if summed else system.t_conorm.name if united else None,
                math.nan if defaults is None else float(defaults[j]),
            )
            for j, name in enumerate(system.output_names)
        )

    def _of_points(self) -> bool:
        sets = self._system.consequent_sets
        return sets is not None and all(
            item is None or isinstance(item, Singleton) for row in sets for item in row
        )

    def _resolution(self) -> int | None:
        if self._system.integration == "sum":
            raise NotExpressible(
                'integration="sum"',
                self._where,
                'take replace(integration="midpoint") for fuzzylite\'s, "exact" for IEC\'s',
            )
        return None if self._system.integration == "exact" else self._system.resolution

    def _range(self, j: int) -> tuple[float, float] | None:
        system = self._system
        if system.output_ranges is not None:
            return system.output_ranges[j]
        if system.type_reduction in UNIONS:
            assert system.consequent_sets is not None
            column = [row[j] for row in system.consequent_sets if row[j] is not None]
            left, right = domain_of(column)
            return float(left), float(right)
        return None

    def _terms_of(self, j: int) -> tuple[dict[str, Any], list[str | None]]:
        """Return all terms of an output by name, and the consequent of each rule."""
        system = self._system
        terms: dict[str, Any] = {}
        if system.output_terms is not None:
            terms = {name: self._plain(one, j) for name, one in system.output_terms[j].items()}
        words: list[str | None] = []
        for r, consequent in enumerate(self._column(j)):
            if consequent is None:
                words.append(None)
                continue
            given = None if system.consequent_names is None else system.consequent_names[r][j]
            known = next((name for name, one in terms.items() if one == consequent), None)
            word = given or known or f"term{len(terms) + 1}"
            if terms.setdefault(word, consequent) != consequent:
                raise NotExpressible(
                    f"the name {word!r} for two consequents of {system.output_names[j]}",
                    self._where,
                    "a name stands for one term",
                )
            words.append(word)
        return terms, words

    def _column(self, j: int) -> Sequence[Any]:
        system = self._system
        silent = system.silent
        spoken = [silent is None or not silent[r, j] for r in range(len(system.rules))]
        consequents = system.consequents
        if system.consequent_sets is not None:
            if system.type_reduction in ("center_of_sets", "weighted_sum"):
                raise NotExpressible(
                    f"type reduction {system.type_reduction!r} of sets",
                    self._where,
                    'take "centroid", or numbers for consequents',
                )
            return [
                self._plain(row[j], j) if speaks else None
                for row, speaks in zip(system.consequent_sets, spoken, strict=True)
            ]
        if isinstance(consequents, Formulas):
            if consequents.names != system.input_names:
                raise NotExpressible(
                    f"formulas of {', '.join(consequents.names)}",
                    self._where,
                    f"the inputs are {', '.join(system.input_names)}",
                )
            return [
                FormulaFunction(row[j]) if speaks else None
                for row, speaks in zip(consequents.formulas, spoken, strict=True)
            ]
        column = said_numbers(system, j)
        for one in column:
            if isinstance(one, LinearFunction):
                check_crisp(one, self._where)
            elif one is not None and one.left != one.right:
                raise NotExpressible(
                    "consequents that are intervals", self._where, "it has numbers"
                )
        return column

    def _plain(self, term: Any, j: int) -> Any:
        """Return a term without the cut at the ends of the range, which readers repeat anyway."""
        if isinstance(term, int | float):
            return Constant(float(term), float(term))
        if isinstance(term, Singleton):
            return Constant(term.point, term.point)
        ranges = self._system.output_ranges
        if isinstance(term, Truncated) and ranges is not None:
            left, right = ranges[j]
            if term.left <= left and term.right >= right:
                return term.whole
        return term

    def rules(self) -> list[EngineRule]:
        system = self._system
        trees = system.rules if isinstance(system.rules, tuple) else trees_of(system.rules)
        united = system.type_reduction in UNIONS
        weights = np.ones(len(trees)) if system.weights is None else system.weights
        found = []
        for r, tree in enumerate(trees):
            said = tuple(
                (name, word)
                for name, (_, words) in zip(system.output_names, self._terms, strict=True)
                if (word := words[r]) is not None
            )
            if said:
                found.append(
                    EngineRule(
                        r + 1,
                        mapped(tree, self._named),
                        said,
                        float(weights[r]),
                        system.t_norm.name,
                        system.disjunction.name,
                        system.implication.name if united and not self._of_points() else None,
                    )
                )
        return found

    def _named(self, clause: Is) -> Antecedent:
        system, place = self._system, int(clause.variable)
        name = system.input_names[place]
        if clause.term is None:
            return Is(name, None)
        number = int(clause.term)
        term = system.inputs[place][number]
        if isinstance(term, Complement) and term.whole in system.inputs[place]:
            whole = system.inputs[place].index(term.whole)
            return Not(Is(name, system.term_names[place][whole]))
        return Is(name, system.term_names[place][number])


def _without_complements(engine: Engine) -> Engine:
    """Return an engine without the input terms that are only complements of others."""
    inputs = tuple(
        Input(
            one.name,
            one.range,
            {
                name: term
                for name, term in one.terms.items()
                if not (isinstance(term, Complement) and term.whole in one.terms.values())
            },
        )
        for one in engine.inputs
    )
    return Engine(engine.name, inputs, engine.outputs, engine.rules)
