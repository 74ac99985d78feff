"""Writer of an engine as the text of a ``.fll`` file."""

from __future__ import annotations

import math
import re
from itertools import groupby

from fuzzy2.errors import NotExpressible
from fuzzy2.files.description import LinearFunction
from fuzzy2.files.engine import Engine, EngineRule, Input, Output
from fuzzy2.files.fll_names import (
    FLL_HEDGES,
    INTEGRALS,
    S_NORMS,
    T_NORMS,
    is_monotonic,
    number,
    text_of,
)
from fuzzy2.files.functions import FormulaFunction
from fuzzy2.files.rule_writer import outer_words, written

_NAMES = re.compile(r"[^\s#\"()]+")
_KEYWORDS = ("if", "is", "then", "and", "or", "with", "not", "any", *FLL_HEDGES)


class FllWriter:
    """Writer of one engine, section by section."""

    def __init__(self, engine: Engine, where: str) -> None:
        self._engine, self._where = engine, where
        self._t_norms = {own: name for name, own in reversed(T_NORMS.items())}
        self._s_norms = {own: name for name, own in reversed(S_NORMS.items())}
        variables: list[Input | Output] = [*engine.inputs, *engine.outputs]
        for variable in variables:
            for name in (variable.name, *variable.terms):
                if not _NAMES.fullmatch(name) or name.lower() in _KEYWORDS:
                    raise NotExpressible(f"the name {name!r}", where, "names are single words")

    def text(self) -> str:
        """Return the text."""
        engine = self._engine
        name = " ".join(engine.name.split()).replace("#", "")
        lines = [f"Engine: {name}"]
        for variable in engine.inputs:
            lines += self._input(variable)
        for output in engine.outputs:
            lines += self._output(output)
        for operators, rules in groupby(
            engine.rules, key=lambda rule: (rule.conjunction, rule.disjunction, rule.implication)
        ):
            lines += self._block(operators, list(rules))
        return "\n".join(lines) + "\n"

    def _head(self, kind: str, variable: Input | Output) -> list[str]:
        ends = variable.range or (-math.inf, math.inf)
        return [
            f"{kind}: {variable.name}",
            "  enabled: true",
            f"  range: {number(ends[0])} {number(ends[1])}",
            "  lock-range: false",
        ]

    def _terms(self, variable: Input | Output) -> list[str]:
        return [
            f"  term: {name} {text_of(term, self._where)}" for name, term in variable.terms.items()
        ]

    def _input(self, variable: Input) -> list[str]:
        return [*self._head("InputVariable", variable), *self._terms(variable)]

    def _output(self, output: Output) -> list[str]:
        aggregation = "none" if output.aggregation is None else self._s_norms[output.aggregation]
        return [
            *self._head("OutputVariable", output),
            f"  aggregation: {aggregation}",
            f"  defuzzifier: {self._defuzzifier(output)}",
            f"  default: {number(output.default)}",
            "  lock-previous: false",
            *self._terms(output),
        ]

    def _defuzzifier(self, output: Output) -> str:
        reduction, resolution, integration = output.defuzzifier
        numbers = [text_of(one, self._where).split()[0] for one in output.terms.values()]
        formulas = any(isinstance(one, FormulaFunction) for one in output.terms.values())
        of_numbers = formulas or all(kind in ("Constant", "Linear") for kind in numbers)
        if reduction == "weighted_sum":
            return "WeightedSum TakagiSugeno"
        if reduction == "center_of_sets" or (reduction == "centroid" and of_numbers):
            if reduction == "centroid" and any(
                isinstance(one, LinearFunction | FormulaFunction) for one in output.terms.values()
            ):
                raise NotExpressible("united functions", self._where, "they have no places")
            return "WeightedAverage TakagiSugeno"
        if reduction == "tsukamoto":
            return self._tsukamoto(output, numbers)
        name = next((name for name, own in INTEGRALS.items() if own == reduction), None)
        if name is None or of_numbers:
            raise NotExpressible(
                f"type reduction {reduction!r}", self._where, f"known are {', '.join(INTEGRALS)}"
            )
        if resolution is None or integration != "midpoint":
            raise NotExpressible(
                f'integration="{"exact" if resolution is None else integration}"',
                self._where,
                'fuzzylite sums over points; take replace(integration="midpoint")',
            )
        return f"{name} {resolution}"

    def _tsukamoto(self, output: Output, kinds: list[str]) -> str:
        if not all(map(is_monotonic, kinds)):
            raise NotExpressible(
                f"Tsukamoto's average of {', '.join(sorted(set(kinds)))}",
                self._where,
                "Ramp, Sigmoid, SShape, ZShape, Arc and Concave have points of a grade there",
            )
        if output.range is not None:
            raise NotExpressible(
                "Tsukamoto's average within a range",
                self._where,
                "points may lie outside there; take replace(output_ranges=None)",
            )
        return "WeightedAverage Tsukamoto"

    def _block(
        self, operators: tuple[str | None, str | None, str | None], rules: list[EngineRule]
    ) -> list[str]:
        both, either, implication = operators
        return [
            "RuleBlock:",
            "  enabled: true",
            f"  conjunction: {'none' if both is None else self._t_norms[both]}",
            f"  disjunction: {'none' if either is None else self._s_norms[either]}",
            f"  implication: {'none' if implication is None else self._t_norms[implication]}",
            "  activation: General",
            *(f"  rule: {self._rule(rule)}" for rule in rules),
        ]

    def _rule(self, rule: EngineRule) -> str:
        tree, words = outer_words(rule.asked, FLL_HEDGES, self._where)
        if not words or rule.weight != 1.0:
            tree, words = rule.asked, []
        asked = written(tree, FLL_HEDGES, self._clause, self._where, negation=False)
        # A hedge of the whole condition is written at the first conclusion, from which it carries
        # over to the others.
        before = "".join(f"{word} " for word in words)
        said = " and ".join(
            f"{output} is {'' if i else before}{term}" for i, (output, term) in enumerate(rule.said)
        )
        weight = "" if rule.weight == 1.0 else f" with {number(rule.weight)}"
        return f"if {asked} then {said}{weight}"

    @staticmethod
    def _clause(variable: str, words: list[str], term: str | None) -> str:
        return " ".join([variable, "is", *words, "any" if term is None else term])
