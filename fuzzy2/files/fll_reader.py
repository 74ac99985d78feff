"""Reader of the text of a ``.fll`` file, which makes an engine."""

from __future__ import annotations

import functools
import math
import re
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from lark import Lark, Token, Tree
from lark.exceptions import UnexpectedCharacters, UnexpectedInput, UnexpectedToken

from fuzzy2.errors import Fuzzy2Error, InvalidRule, NotExpressible
from fuzzy2.files.description import SUM, Constant
from fuzzy2.files.engine import (
    AnySystem,
    Defuzzifier,
    Engine,
    EngineRule,
    Input,
    Output,
    SystemMaker,
)
from fuzzy2.files.fll_names import (
    FLL_HEDGES,
    INTEGRALS,
    RESOLUTION,
    S_NORMS,
    T_NORMS,
    clamped,
    is_monotonic,
    term_of,
)
from fuzzy2.files.functions import NUMBERS, FormulaFunction
from fuzzy2.files.rule_text import rules_of
from fuzzy2.files.source import Source
from fuzzy2.sets.formula_set import FormulaSet
from fuzzy2.support.formula import Formula
from fuzzy2.support.number_text import number_of
from fuzzy2.systems.rules import unknown_name

_GRAMMAR = r"""
file: _LINE? block*
block: HEAD VALUE? _LINE entry*
entry: KEY VALUE? _LINE

HEAD.2: /(Engine|InputVariable|OutputVariable|RuleBlock)[ \t]*:/
KEY: /[A-Za-z][\w-]*[ \t]*:/
VALUE: /[^\s#][^#\r\n]*/
_LINE: /([ \t]*(#[^\r\n]*)?(\r\n|\r|\n))+[ \t]*/
BLANK: /[ \t]+/
%ignore BLANK
"""

_KEYS = {
    "Engine": ("description",),
    "InputVariable": ("description", "enabled", "range", "lock-range", "term"),
    "OutputVariable": (
        "description",
        "enabled",
        "range",
        "lock-range",
        "aggregation",
        "accumulation",
        "defuzzifier",
        "default",
        "lock-previous",
        "lock-valid",
        "term",
    ),
    "RuleBlock": (
        "description",
        "enabled",
        "conjunction",
        "disjunction",
        "implication",
        "activation",
        "rule",
    ),
}
_MANY = ("term", "rule")


@functools.cache
def _parser() -> Lark:
    return Lark(_GRAMMAR, start="file", parser="lalr", propagate_positions=True)


class _Line(NamedTuple):
    number: int
    value: str


@dataclass
class _Block:
    """Lines after a heading: entries by key, and lists of terms or rules."""

    kind: str
    name: str
    number: int
    entries: dict[str, _Line] = field(default_factory=dict)
    many: list[_Line] = field(default_factory=list)


class FllReader(Source):
    """Reader of one text, which makes blocks and then an engine."""

    def __init__(self, text: str, source: str) -> None:
        super().__init__(source)
        self._kinds: dict[tuple[str, str], str] = {}
        self._blocks = self._parsed(text)

    def _parsed(self, text: str) -> list[_Block]:
        try:
            tree = _parser().parse(text + "\n")
        except UnexpectedInput as error:
            raise self._unexpected(text, error) from None
        return [self._block(one) for one in tree.children if isinstance(one, Tree)]

    def _unexpected(self, text: str, error: UnexpectedInput) -> Fuzzy2Error:
        line = max(int(getattr(error, "line", 1) or 1), 1)
        if isinstance(error, UnexpectedToken | UnexpectedCharacters):
            lines = text.splitlines()
            shown = lines[line - 1].strip()[:40] if line <= len(lines) else "the end"
            return self.malformed(
                line,
                "expected Engine:, InputVariable:, OutputVariable:, RuleBlock: or <key>: <value>, "
                f"got {shown!r}",
            )
        return self.malformed(line, str(error)[:80])

    def _block(self, tree: Tree[Token]) -> _Block:
        head, name = tree.children[0], ""
        assert isinstance(head, Token)
        block = _Block(str(head).rstrip(" \t:"), name, head.line or 1)
        for child in tree.children[1:]:
            if isinstance(child, Token):
                block.name = str(child).strip()
                continue
            key_token = child.children[0]
            assert isinstance(key_token, Token)
            key, number = str(key_token).rstrip(" \t:"), key_token.line or 1
            value = str(child.children[1]).strip() if len(child.children) > 1 else ""
            known = _KEYS[block.kind]
            if key not in known:
                headings = (*known, *_KEYS)
                raise self.malformed(number, unknown_name(f"key of {block.kind}", key, headings))
            if key in _MANY:
                block.many.append(_Line(number, value))
            elif key in block.entries:
                first = block.entries[key].number
                raise self.malformed(number, f"{key} occurs twice, first in line {first}")
            else:
                block.entries[key] = _Line(number, value)
        return block

    def system(self) -> AnySystem:
        """Return the system that the text describes."""
        engine = self._engine()
        try:
            return SystemMaker(engine, self.refused).system()
        except NotExpressible:
            raise
        except Fuzzy2Error as error:
            raise self.malformed(1, str(error)) from error

    def _engine(self) -> Engine:
        by_kind = {kind: [one for one in self._blocks if one.kind == kind] for kind in _KEYS}
        if len(by_kind["Engine"]) > 1:
            raise self.malformed(by_kind["Engine"][1].number, "there is a second engine")
        for kind in ("InputVariable", "OutputVariable", "RuleBlock"):
            if not by_kind[kind]:
                raise self.malformed(1, f"there is no {kind}")
        self._check_variables([*by_kind["InputVariable"], *by_kind["OutputVariable"]])
        linear = any(
            len(line.value.split()) > 1 and line.value.split()[1] == "Linear"
            for block in by_kind["OutputVariable"]
            for line in block.many
        )
        inputs = tuple(self._input(block, linear) for block in by_kind["InputVariable"])
        terms = [self._terms(block, len(inputs)) for block in by_kind["OutputVariable"]]
        names = {one.name: tuple(one.terms) for one in inputs}
        said = {
            block.name: tuple(own)
            for block, own in zip(by_kind["OutputVariable"], terms, strict=True)
        }
        rules = tuple(
            rule for block in by_kind["RuleBlock"] for rule in self._rules(block, names, said)
        )
        if not rules:
            raise self.malformed(by_kind["RuleBlock"][0].number, "there are no rules")
        outputs = tuple(
            self._output(block, own, rules)
            for block, own in zip(by_kind["OutputVariable"], terms, strict=True)
        )
        name = by_kind["Engine"][0].name if by_kind["Engine"] else ""
        return Engine(name, inputs, outputs, rules)

    def _check_variables(self, blocks: list[_Block]) -> None:
        seen: set[str] = set()
        for block in blocks:
            if not block.name or any(letter.isspace() for letter in block.name):
                raise self.malformed(block.number, f"expected a name, got {block.name[:40]!r}")
            if block.name in seen:
                raise self.malformed(block.number, f"there is a second variable {block.name!r}")
            seen.add(block.name)
            if self._truth(block, "enabled", True) is False:
                raise self.refused(
                    block.entries["enabled"].number, "a disabled variable", "leave it out"
                )

    def _truth(self, block: _Block, key: str, default: bool) -> bool:
        if key not in block.entries:
            return default
        number, value = block.entries[key]
        if value not in ("true", "false"):
            raise self.malformed(number, f"expected true or false, got {value[:40]!r}")
        return value == "true"

    def _numbers(self, number: int, words: list[str]) -> list[float]:
        found = []
        for word in words:
            found.append(number_of(word))
            if math.isnan(found[-1]):
                raise self.malformed(number, f"expected a number, got {word[:40]!r}")
        return found

    def _range(self, block: _Block) -> tuple[float, float] | None:
        if "range" not in block.entries:
            return None
        number, value = block.entries["range"]
        ends = self._numbers(number, value.split())
        if len(ends) != 2 or not ends[0] <= ends[1]:
            raise self.malformed(number, f"expected range: <low> <high>, got {value[:40]!r}")
        if not all(map(math.isfinite, ends)) or ends[0] == ends[1]:
            return None
        return ends[0], ends[1]

    def _input(self, block: _Block, linear: bool) -> Input:
        terms, ends = self._terms(block, None), self._range(block)
        if any(map(_is_cut, terms.values())):
            raise self.refused(
                block.number, f"formulas of {block.name!r} that leave [0, 1]", "grades lie in it"
            )
        if self._truth(block, "lock-range", False) and ends is not None:
            number = block.entries["lock-range"].number
            if linear:
                raise self.refused(
                    number, "lock-range beside linear functions", "they take inputs as they are"
                )
            terms = {
                name: self._guarded(number, name, lambda term=term: clamped(term, ends))
                for name, term in terms.items()
            }
        return Input(block.name, ends, terms)

    def _terms(self, block: _Block, inputs: int | None) -> dict[str, Any]:
        terms: dict[str, Any] = {}
        for number, value in block.many:
            words = value.split()
            if len(words) < 2:
                raise self.malformed(
                    number, f"expected term: <name> <kind> ..., got {value[:40]!r}"
                )
            name, kind = words[0], words[1]
            # If several terms have the same name, fuzzylite 8 uses the last one.
            terms[name] = self._term(block, number, words, inputs)
            self._kinds[block.name, name] = kind
        return terms

    def _term(self, block: _Block, number: int, words: list[str], inputs: int | None) -> Any:
        kind = words[1]
        if kind == "Function":
            text, ends = " ".join(words[2:]), self._range(block)
            weighted = "defuzzifier" in block.entries and block.entries[
                "defuzzifier"
            ].value.startswith("Weighted")
            if weighted:
                return self._guarded(number, kind, lambda: FormulaFunction(Formula(text).text))
            if ends is None:
                raise self.refused(number, "a membership by formula", "its variable has no range")
            return self._guarded(number, kind, lambda: FormulaSet(text, *ends))
        numbers = self._numbers(number, words[2:])
        return self._guarded(number, kind, lambda: term_of(kind, numbers, inputs))

    def _guarded(self, line: int, kind: str, make: Any) -> Any:
        """Make a term; an error of its class is reported with the line."""
        try:
            return make()
        except NotExpressible as error:
            raise self.refused(line, error.what, error.reason) from error
        except Fuzzy2Error as error:
            raise self.malformed(line, f"{kind}: {error}") from error

    def _norm(self, block: _Block, key: str, known: dict[str, str]) -> str | None:
        number, value = block.entries.get(key, _Line(0, "none"))
        if value in ("none", ""):
            return None
        if value not in known:
            raise self.refused(number, f"{key}: {value[:40]}", f"known are {', '.join(known)}")
        return known[value]

    def _rules(
        self,
        block: _Block,
        inputs: dict[str, tuple[str, ...]],
        outputs: dict[str, tuple[str, ...]],
    ) -> list[EngineRule]:
        if not self._truth(block, "enabled", True):
            return []
        number, activation = block.entries.get("activation", _Line(0, "General"))
        implication = self._norm(block, "implication", T_NORMS)
        if activation in T_NORMS:  # up to version 5
            implication = T_NORMS[activation]
        elif activation not in ("General", "none", ""):
            raise self.refused(number, f"activation: {activation[:40]}", "only General is known")
        operators = (
            self._norm(block, "conjunction", T_NORMS),
            self._norm(block, "disjunction", S_NORMS),
            implication,
        )
        found: list[EngineRule] = []
        for line, text in block.many:
            try:
                found += rules_of(text, line, FLL_HEDGES, (inputs, outputs), operators)
            except InvalidRule as error:
                raise self.malformed(line, f"the rule {error.reason}") from error
        return found

    def _output(
        self, block: _Block, terms: dict[str, Any], rules: tuple[EngineRule, ...]
    ) -> Output:
        ends, default = self._range(block), self._default(block)
        for key in ("lock-previous", "lock-valid"):
            # NaN where no rule fires means that there is no new value; the caller must keep the
            # last output.
            if self._truth(block, key, False) and not math.isnan(default):
                raise self.refused(
                    block.entries[key].number,
                    f"{key} beside a default",
                    "a system does not remember its last output; take default: nan",
                )
        key = "aggregation" if "aggregation" in block.entries else "accumulation"
        aggregation = self._norm(block, key, S_NORMS)
        said = [term for rule in rules for output, term in rule.said if output == block.name]
        number, value = block.entries.get("defuzzifier", _Line(block.number, "none"))
        words = value.split() or ["none"]
        if words[0] in INTEGRALS:
            resolution = self._resolution(number, words[1:])
            if ends is None:
                raise self.malformed(block.number, f"{words[0]} needs a range with ends")
            defuzzifier = Defuzzifier(INTEGRALS[words[0]], resolution)
            if any(isinstance(terms[name], NUMBERS) for name in said):
                raise self.refused(
                    number, f"{words[0]} of numbers", "WeightedAverage is what they go with"
                )
            self._check_grades(block, {terms[name] for name in said}, aggregation, rules)
        elif words[0] in ("WeightedAverage", "WeightedSum") and len(words) <= 2:
            defuzzifier = self._weighted(block, number, words, said, aggregation)
            self._check_values(block, defuzzifier, [terms[name] for name in set(said)])
        else:
            known = (*INTEGRALS, "WeightedAverage", "WeightedSum")
            raise self.refused(number, f"defuzzifier: {value[:40]}", f"known: {', '.join(known)}")
        if self._truth(block, "lock-range", False) and words[0] not in INTEGRALS:
            self._check_locked(block, ends, terms, default)
        if defuzzifier.reduction == "center_of_sets" and aggregation == SUM:
            aggregation = None
        return Output(block.name, ends, terms, defuzzifier, aggregation, default)

    def _check_grades(
        self,
        block: _Block,
        said: set[Any],
        aggregation: str | None,
        rules: tuple[EngineRule, ...],
    ) -> None:
        """Refuse formulas that leave [0, 1], unless limiting their grades has no effect."""
        implied = {
            one.implication for one in rules if any(name == block.name for name, _ in one.said)
        }
        if (implied, aggregation) != ({"min"}, "max") and any(map(_is_cut, said)):
            raise self.refused(
                block.number,
                f"formulas of {block.name!r} that leave [0, 1]",
                "they are cut off there, which is the same with Minimum and Maximum only",
            )

    def _resolution(self, number: int, words: list[str]) -> int:
        if not words:
            return RESOLUTION
        if (
            len(words) != 1
            or not re.fullmatch("[0-9]{1,7}", words[0])
            or not 2 <= int(words[0]) <= 1_000_000
        ):
            raise self.malformed(
                number, f"expected from 2 to 1000000 points, got {' '.join(words)[:40]!r}"
            )
        return int(words[0])

    def _default(self, block: _Block) -> float:
        number, value = block.entries.get("default", _Line(0, "nan"))
        if value.lower() == "nan":
            return math.nan
        (default,) = self._numbers(number, [value or "nothing"])
        if math.isinf(default):
            raise self.refused(number, f"default: {value}", "outputs are finite")
        return default

    def _weighted(
        self,
        block: _Block,
        number: int,
        words: list[str],
        said: list[str],
        aggregation: str | None,
    ) -> Defuzzifier:
        """Return a weighted defuzzifier, whose type fuzzylite infers from the terms."""
        kind = words[1] if len(words) > 1 else "Automatic"
        if kind not in ("Automatic", "TakagiSugeno", "Tsukamoto"):
            raise self.malformed(number, f"expected a type of {words[0]}, got {kind[:40]!r}")
        kinds = [self._kinds[block.name, name] for name in said]
        of_numbers = all(one in ("Constant", "Function", "Linear") for one in kinds)
        repeated = len(set(said)) < len(said) and aggregation not in (None, SUM)
        if not of_numbers:
            if (
                words[0] == "WeightedSum"
                or kind == "TakagiSugeno"
                or not all(map(is_monotonic, kinds))
            ):
                raise self.refused(
                    number,
                    f"{words[0]} of {', '.join(sorted(set(kinds)))}",
                    "numbers and linear functions are weighted, or monotonic terms averaged",
                )
        elif kind == "Tsukamoto":
            raise self.refused(number, f"{words[0]} Tsukamoto of numbers", "they have no grades")
        if repeated and (words[0] == "WeightedSum" or not of_numbers):
            raise self.refused(
                number, f"the aggregation of {block.name!r}", "rules that say the same add up there"
            )
        if words[0] == "WeightedSum":
            return Defuzzifier("weighted_sum")
        if not of_numbers:
            return Defuzzifier("tsukamoto")
        united = repeated and all(one == "Constant" for one in kinds)
        return Defuzzifier("centroid" if united else "center_of_sets")

    def _check_values(self, block: _Block, defuzzifier: Defuzzifier, terms: list[Any]) -> None:
        """Refuse equal numbers with different names, which fuzzylite does not aggregate."""
        if defuzzifier.reduction == "centroid" and len(set(terms)) < len(terms):
            raise self.refused(
                block.number, f"two terms of {block.name!r} with one value", "they have one place"
            )

    def _check_locked(
        self,
        block: _Block,
        ends: tuple[float, float] | None,
        terms: dict[str, Any],
        default: float,
    ) -> None:
        """Refuse a range limit that has an effect."""
        if ends is None:
            return
        numbers = [
            *(one.left if isinstance(one, Constant) else math.inf for one in terms.values()),
            *([] if math.isnan(default) else [default]),
        ]
        summed = block.entries["defuzzifier"].value.startswith("WeightedSum")
        if summed or not all(ends[0] <= one <= ends[1] for one in numbers):
            raise self.refused(
                block.entries["lock-range"].number,
                f"lock-range of {block.name!r}",
                "outputs are not held within their range",
            )


def _is_cut(term: Any) -> bool:
    """Return whether a term is a formula that leaves [0, 1]."""
    return isinstance(term, FormulaSet) and term.is_cut
