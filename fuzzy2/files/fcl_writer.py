"""Writer of an engine as the text of a ``.fcl`` file."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Iterator, Sequence

from fuzzy2.errors import NotExpressible
from fuzzy2.files.description import LinearFunction
from fuzzy2.files.engine import Engine, EngineRule, Input, Output
from fuzzy2.files.fcl_formula import formula, formula_text
from fuzzy2.files.fcl_names import ACCUMULATIONS, METHODS, S_NORMS, T_NORMS, term_text
from fuzzy2.files.fll_names import FLL_HEDGES, number
from fuzzy2.files.functions import FormulaFunction
from fuzzy2.files.rule_writer import written

_NAME = re.compile(r"[^\W\d]\w*")
_KEYWORDS = (
    *("if", "is", "then", "and", "or", "with", "not", "any", "rule", "term", "range", "default"),
    *("method", "accu", "act", "lock", "function", "fuzzify", "defuzzify", "ruleblock"),
    *("var_input", "var_output", "end_var", "end_fuzzify", "end_defuzzify", "end_ruleblock"),
    *("function_block", "end_function_block", "inf", "nan", "nc", "singletons", *FLL_HEDGES),
)


class FclWriter:
    """Writer of one engine, section by section."""

    def __init__(self, engine: Engine, where: str) -> None:
        self._engine, self._where = engine, where
        self._t_norms = {own: name for name, own in reversed(T_NORMS.items())}
        self._s_norms = {own: name for name, own in reversed(S_NORMS.items())}
        self._accumulations = {own: name for name, own in reversed(ACCUMULATIONS.items())}
        variables: list[Input | Output] = [*engine.inputs, *engine.outputs]
        self._check([variable.name for variable in variables])
        for variable in variables:
            self._check(list(variable.terms))

    def _check(self, names: Sequence[str]) -> None:
        for name in names:
            if not _NAME.fullmatch(name) or name.lower() in _KEYWORDS:
                raise NotExpressible(f"the name {name!r}", self._where, "names are single words")
        if len({name.lower() for name in names}) < len(names):
            raise NotExpressible(
                f"the names {list(names)}", self._where, "case makes no difference"
            )

    def text(self) -> str:
        """Return the text."""
        engine = self._engine
        name = re.sub(r"\W", "_", engine.name)
        name = name if _NAME.fullmatch(name) and name.lower() not in _KEYWORDS else f"b_{name}"
        lines = [f"FUNCTION_BLOCK {name}", "", "VAR_INPUT"]
        lines += [f"  {one.name} : REAL;" for one in engine.inputs]
        lines += ["END_VAR", "", "VAR_OUTPUT"]
        lines += [f"  {one.name} : REAL;" for one in engine.outputs]
        lines += ["END_VAR", ""]
        for variable in engine.inputs:
            lines += [f"FUZZIFY {variable.name}", *self._body(variable), "END_FUZZIFY", ""]
        for output in engine.outputs:
            lines += self._output(output)
        numbers = itertools.count(1)
        blocks: list[list[EngineRule]] = []
        for rule in engine.rules:
            if not blocks or _operators(blocks[-1][0]) != _operators(rule):
                blocks.append([])
            blocks[-1].append(rule)
        for block, rules in enumerate(blocks, start=1):
            lines += self._block(block, rules, numbers)
        return "\n".join([*lines, "END_FUNCTION_BLOCK"]) + "\n"

    def _body(self, variable: Input | Output) -> list[str]:
        lines = []
        if variable.range is not None:
            left, right = variable.range
            lines.append(f"  RANGE := ({number(left)} .. {number(right)});")
        names = [one.name for one in self._engine.inputs]
        for name, term in variable.terms.items():
            match term:
                case LinearFunction():
                    text = f"FUNCTION {formula(term, names)}"
                case FormulaFunction(said):
                    text = f"FUNCTION {formula_text(said)}"
                case _:
                    text = term_text(term, self._where)
            lines.append(f"  TERM {name} := {text};")
        return lines

    def _output(self, output: Output) -> list[str]:
        lines = [f"DEFUZZIFY {output.name}", *self._body(output)]
        lines.append(f"  METHOD : {self._method(output)};")
        if output.aggregation is not None:
            lines.append(f"  ACCU : {self._accumulations[output.aggregation]};")
        default = "NC" if math.isnan(output.default) else number(output.default)
        return [*lines, f"  DEFAULT := {default};", "END_DEFUZZIFY", ""]

    def _method(self, output: Output) -> str:
        reduction, resolution, _ = output.defuzzifier
        texts = [
            "FUNCTION"
            if isinstance(one, LinearFunction | FormulaFunction)
            else term_text(one, self._where)
            for one in output.terms.values()
        ]
        of_functions = "FUNCTION" in texts
        of_numbers = not any(" " in one for one in texts)
        if reduction == "center_of_sets":
            return "COGF" if of_functions else "COGS"
        if reduction == "centroid" and of_numbers and not of_functions:
            return "COGS"
        if reduction == "weighted_sum":
            return "COGSS"
        if reduction == "tsukamoto" and output.range is None:
            return "COGS"
        name = next((name for name, own in METHODS.items() if own == reduction), None)
        if name is None:
            known = ", ".join(METHODS.values())
            raise NotExpressible(f"type reduction {reduction!r}", self._where, f"known are {known}")
        if resolution is not None:
            raise NotExpressible(
                'an integration other than "exact"',
                self._where,
                'IEC 61131-7 integrates; take replace(integration="exact")',
            )
        return name

    def _block(self, block: int, rules: list[EngineRule], numbers: Iterator[int]) -> list[str]:
        first = rules[0]
        lines = [f"RULEBLOCK No{block}"]
        if first.conjunction is not None:
            lines.append(f"  AND : {self._t_norms[first.conjunction]};")
        if first.disjunction is not None:
            lines.append(f"  OR : {self._s_norms[first.disjunction]};")
        if first.implication is not None:
            lines.append(f"  ACT : {self._t_norms[first.implication]};")
        lines += [f"  RULE {next(numbers)} : {self._rule(rule)};" for rule in rules]
        return [*lines, "END_RULEBLOCK", ""]

    def _rule(self, rule: EngineRule) -> str:
        asked = written(rule.asked, FLL_HEDGES, self._clause, self._where, negation=True)
        said = " AND ".join(f"{output} IS {term}" for output, term in rule.said)
        weight = "" if rule.weight == 1.0 else f" WITH {number(rule.weight)}"
        return f"IF {asked} THEN {said}{weight}"

    @staticmethod
    def _clause(variable: str, words: list[str], term: str | None) -> str:
        return " ".join([variable, "IS", *words, "any" if term is None else term])


def _operators(rule: EngineRule) -> tuple[str | None, str | None, str | None]:
    return rule.conjunction, rule.disjunction, rule.implication
