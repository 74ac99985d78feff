"""Writer of an engine as a ``.fis`` file in fuzzylite's dialect."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import NoReturn

from fuzzy2.errors import NotExpressible
from fuzzy2.files.clauses import clauses_of_rule
from fuzzy2.files.engine import Engine, EngineRule, Input, Output, has_part
from fuzzy2.files.fis_engine import (
    HEDGES,
    INTEGRAL_WORDS,
    KINDS,
    RESOLUTIONS,
    WEIGHTED_WORDS,
)
from fuzzy2.files.fis_lines import quoted
from fuzzy2.files.fis_names import AGGREGATIONS, T_CONORMS, T_NORMS
from fuzzy2.files.fll_names import FLL_HEDGES, is_monotonic, text_of
from fuzzy2.files.functions import NUMBERS
from fuzzy2.files.operator_words import known_as
from fuzzy2.files.rule_writer import outer_words, word_of
from fuzzy2.systems.antecedents import And, Antecedent, Is, Or, mapped
from fuzzy2.systems.hedges import Hedge


class FisEngineWriter:
    """Writer of one engine, section by section."""

    def __init__(self, engine: Engine, where: str) -> None:
        self._engine, self._where = engine, where
        variables: list[Input | Output] = [*engine.inputs, *engine.outputs]
        for name in (name for one in variables for name in (one.name, *one.terms)):
            if not name.isprintable():
                self._refuse(f"the name {name!r}", "it has a character that cannot be printed")
        self._kinds = {KINDS[word][0]: word for word in KINDS}

    def _refuse(self, what: str, reason: str) -> NoReturn:
        raise NotExpressible(what, self._where, reason)

    def text(self) -> str:
        """Return the text."""
        engine = self._engine
        rules = [self._rule(rule) for rule in engine.rules]
        lines = ["# In the meaning of fuzzylite.", "[System]", f"Name={quoted(engine.name)}"]
        lines += [*self._system(), f"NumInputs={len(engine.inputs)}"]
        lines += [f"NumOutputs={len(engine.outputs)}", f"NumRules={len(rules)}", *self._methods()]
        for i, variable in enumerate(engine.inputs):
            lines += ["", f"[Input{i + 1}]", *self._variable(variable)]
        for i, output in enumerate(engine.outputs):
            lines += ["", f"[Output{i + 1}]", *self._variable(output)]
            if not math.isnan(output.default):
                lines.append(f"Default={_number(output.default)}")
        return "\n".join([*lines, "", "[Rules]", *rules]) + "\n"

    def _system(self) -> list[str]:
        kinds = {self._kind(output) for output in self._engine.outputs}
        kind = kinds.pop() if len(kinds) == 1 else "hybrid"
        return [f"Type='{kind}'", f"Version={self._version()}.0"]

    def _version(self) -> int:
        """Return the version of fuzzylite whose number of points the integrated outputs use."""
        pieces = {one.defuzzifier.resolution for one in self._engine.outputs} - {None}
        if len(pieces) > 1:
            counts = " and ".join(map(str, sorted(one for one in pieces if one is not None)))
            self._refuse(f"outputs integrated over {counts} points", "take the same for all")
        return next((version for version, own in RESOLUTIONS.items() if pieces == {own}), 6)

    def _kind(self, output: Output) -> str:
        if output.defuzzifier.reduction in WEIGHTED_WORDS.values():
            return "sugeno"
        return "tsukamoto" if output.defuzzifier.reduction == "tsukamoto" else "mamdani"

    def _methods(self) -> list[str]:
        """Return the operators, which must be the same for all rules and outputs."""
        rules, outputs = self._engine.rules, self._engine.outputs
        # An operator that no rule uses may have any value.
        joint = {one.conjunction for one in rules if has_part(one.asked, And)}
        chosen = {one.disjunction for one in rules if has_part(one.asked, Or)}
        both = self._one("t-norm", joint, "min")
        either = self._one("disjunction", chosen, "max")
        implied = self._one("implication", {one.implication for one in rules}, "min")
        of_sets = [one for one in outputs if self._kind(one) == "mamdani"]
        united = self._one("aggregation", {one.aggregation for one in of_sets}, "max")
        words = {self._defuzzifier(one) for one in outputs}
        kept = words - {"wtaver"} if of_sets else words
        if len(kept) > 1:
            self._refuse(f"outputs reduced by {', '.join(sorted(words))}", "a file has one word")
        word = kept.pop() if kept else "wtaver"
        return [
            f"AndMethod='{known_as(both, T_NORMS, 't-norm', self._where)}'",
            f"OrMethod='{known_as(either, T_CONORMS, 't-conorm', self._where)}'",
            f"ImpMethod='{known_as(implied, T_NORMS, 't-norm', self._where)}'",
            f"AggMethod='{known_as(united, AGGREGATIONS, 't-conorm', self._where)}'",
            f"DefuzzMethod='{word}'",
        ]

    def _one(self, what: str, names: Iterable[str | None], default: str) -> str:
        known = sorted({name for name in names if name is not None})
        if len(known) > 1:
            self._refuse(f"outputs with a {what} each", f"a file has one, not {', '.join(known)}")
        return known[0] if known else default

    def _defuzzifier(self, output: Output) -> str:
        reduction, resolution, integration = output.defuzzifier
        numbers = [isinstance(one, NUMBERS) for one in output.terms.values()]
        if reduction in WEIGHTED_WORDS.values():
            if output.aggregation is not None:
                self._refuse(f"the aggregation of {output.name!r}", "numbers add up there")
            return known_as(reduction, WEIGHTED_WORDS, "type reduction", self._where)
        if reduction == "tsukamoto":
            kinds = [text_of(one, self._where).split()[0] for one in output.terms.values()]
            if output.range is not None or not all(map(is_monotonic, kinds)):
                self._refuse(
                    f"Tsukamoto's average of {output.name!r}",
                    "its terms are monotonic, and points lie anywhere",
                )
            return "wtaver"
        if any(numbers):
            self._refuse(f"the union of numbers of {output.name!r}", "numbers add up there")
        if resolution not in RESOLUTIONS.values() or integration != "midpoint":
            versions = ", ".join(f"{own} in version {one}" for one, own in RESOLUTIONS.items())
            self._refuse(
                f"how {output.name!r} is integrated",
                'take replace(integration="midpoint", resolution=100): fuzzylite takes the '
                f"middles of as many pieces ({versions})",
            )
        return known_as(reduction, INTEGRAL_WORDS, "type reduction", self._where)

    def _variable(self, variable: Input | Output) -> list[str]:
        left, right = variable.range or (-math.inf, math.inf)
        lines = [
            f"Name={quoted(variable.name)}",
            f"Range=[{_number(left)} {_number(right)}]",
            f"NumMFs={len(variable.terms)}",
        ]
        for i, (name, term) in enumerate(variable.terms.items()):
            kind, *words = text_of(term, self._where).split()
            if kind == "Function":
                text = " ".join(words)
                if "," in text:
                    self._refuse(f"the formula {text[:60]!r}", "fuzzylite cuts it at its comma")
                lines.append(f"MF{i + 1}={quoted(name)}:'function',[{text}]")
                continue
            if kind not in self._kinds or (kind == "Constant" and not isinstance(term, NUMBERS)):
                self._refuse(f"the term {name!r}, {kind}", "it has no word for it")
            places = KINDS[self._kinds[kind]][1] or range(len(words))
            numbers = [*words[len(places) :]]
            ordered = [words[places.index(k)] for k in range(len(places))]
            values = " ".join(_number(float(word)) for word in (*ordered, *numbers))
            lines.append(f"MF{i + 1}={quoted(name)}:'{self._kinds[kind]}',[{values}]")
        return lines

    def _rule(self, rule: EngineRule) -> str:
        tree, words = outer_words(rule.asked, FLL_HEDGES, self._where)
        if not words or rule.weight != 1.0:
            tree, words = rule.asked, []
        inputs, outputs = self._engine.inputs, self._engine.outputs
        codes = ["0"] * len(inputs)
        flat = clauses_of_rule(mapped(tree, self._numbered))
        if flat is None:
            self._refuse("a rule with and and or, or with a negated group", "a rule has either")
        either, clauses = flat
        if not clauses and isinstance(tree, Is):
            codes[[one.name for one in inputs].index(str(tree.variable))] = "0.99"
        elif not clauses:
            self._refuse("a rule without an antecedent", "a rule has at least one clause")
        for clause in clauses:
            if codes[clause.input] != "0":
                self._refuse("a rule that asks about an input twice", "it has one number for each")
            changes = [self._word(change) for change in clause.changes]
            if len(clauses) == 1 and rule.weight == 1.0 and not words:
                words, changes = _shared(changes)
            codes[clause.input] = self._code(clause.term, changes)
        said = dict(rule.said)
        consequents = []
        for output in outputs:
            if output.name not in said:
                consequents.append("0")
                continue
            number = list(output.terms).index(said[output.name])
            # A hedge of the whole condition is written at the first conclusion, from which it
            # carries over to the others.
            consequents.append(self._code(number, words))
            words = []
        joint = 2 if either else 1
        weight = _number(rule.weight)
        return f"{' '.join(codes)}, {' '.join(consequents)} ({weight}) : {joint}"

    def _numbered(self, clause: Is) -> Antecedent:
        names = [one.name for one in self._engine.inputs]
        place = names.index(str(clause.variable))
        if clause.term is None:
            return Is(place, None)
        return Is(place, list(self._engine.inputs[place].terms).index(str(clause.term)))

    def _word(self, change: str | Hedge) -> str:
        return change if isinstance(change, str) else word_of(change, FLL_HEDGES, self._where)

    def _code(self, number: int, words: Sequence[str]) -> str:
        """Return the number of a term, counted from 0, with its hedges."""
        negated = words[:1] == ["not"]
        hedges = tuple(words[1:] if negated else words)
        hundredths = next((key for key, known in HEDGES.items() if known == hedges), None)
        if hedges and hundredths is None:
            self._refuse(f'"{" ".join(words)}" before a term', "its hedges are of one word")
        fraction = f".{hundredths:02d}" if hundredths is not None else ""
        return f"{'-' if negated else ''}{number + 1}{fraction}"


def _shared(words: list[str]) -> tuple[list[str], list[str]]:
    """Return the leading words that must be written at the conclusion, and the other words."""
    for cut in range(len(words) + 1):
        if all(_has_code(part) for part in (words[:cut], words[cut:])):
            return words[:cut], words[cut:]
    return [], words


def _has_code(words: Sequence[str]) -> bool:
    return tuple(words[1:] if words[:1] == ["not"] else words) in ((), *HEDGES.values())


def _number(value: float) -> str:
    return repr(float(value)).removesuffix(".0").replace("inf", "Inf")
