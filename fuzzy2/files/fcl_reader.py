"""Reader of the text of a ``.fcl`` file, which makes an engine."""

from __future__ import annotations

import functools
import math
import re
from dataclasses import replace
from typing import Any, NamedTuple

from lark import Lark, Token, Tree
from lark.exceptions import UnexpectedInput

from fuzzy2.errors import (
    Fuzzy2Error,
    InvalidRule,
    InvalidValue,
    NotApplicable,
    NotExpressible,
    UnknownName,
)
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
from fuzzy2.files.fcl_formula import function_of
from fuzzy2.files.fcl_names import (
    ACCUMULATIONS,
    DUALS,
    METHODS,
    S_NORMS,
    T_NORMS,
    points_of,
    shape_of,
    universe,
)
from fuzzy2.files.fll_names import FLL_HEDGES
from fuzzy2.files.functions import NUMBERS
from fuzzy2.files.rule_text import rules_of
from fuzzy2.files.source import Source
from fuzzy2.sets.type1 import Singleton
from fuzzy2.support.checks import known_name
from fuzzy2.systems.averages import Monotonic

_GRAMMAR = r"""
file: block+
block: "FUNCTION_BLOCK"i (NAME | BLOCK)? _declaration* "END_FUNCTION_BLOCK"i
_declaration: inputs | outputs | fuzzify | defuzzify | rules
inputs: "VAR_INPUT"i variable* "END_VAR"i
outputs: "VAR_OUTPUT"i variable* "END_VAR"i
variable: NAME ":" NAME ";" range?
fuzzify: "FUZZIFY"i NAME (term | range)* "END_FUZZIFY"i
defuzzify: "DEFUZZIFY"i NAME (term | range | option | default)* "END_DEFUZZIFY"i
range: "RANGE"i ":=" "(" _number ".." _number ")" ";"
term: "TERM"i NAME ":=" _shape ";"
_shape: points | number | named | FORMULA
points: point+
point: "(" (NUMBER | NAME) "," (NUMBER | NAME) ")"
number: NUMBER
named: NAME (NUMBER | NAME | point)*
_number: NUMBER | NAME
option: (METHOD | ACCU | LOCK) ":" NAME ";"
default: "DEFAULT"i (":=" | "=") (NUMBER | NAME) ("|" NAME)? ";"?
rules: "RULEBLOCK"i NAME? (operator | RULE ";"?)* "END_RULEBLOCK"i
operator: (AND | OR | ACT | ACCU) ":" NAME ";"

METHOD.2: /METHOD\b/i
ACCU.2: /ACCU\b/i
LOCK.2: /LOCK\b/i
AND.2: /AND\b/i
OR.2: /OR\b/i
ACT.2: /ACT\b/i
FORMULA.3: /FUNCTION\b[^;]*/i
RULE.3: /RULE\s+[\w.]+\s*:[^;]*?(?=;|\bRULE\s+[\w.]+\s*:|\bEND_RULEBLOCK\b)/is
NUMBER: /[+-]?(([0-9]+(\.(?!\.)[0-9]*)?|\.[0-9]+)([eE][+-]?[0-9]+)?|inf\b)/i
BLOCK: /[^\W\d]\w*(-\w+)+/i
NAME: /[^\W\d]\w*/i
%ignore /\s+/
"""

DIALECTS = ("iec", "jfuzzylogic")
"""Dialects: exact integrals as in IEC 61131-7, or sums as in jFuzzyLogic."""

_JFUZZYLOGIC_POINTS = 1000
_COMMENT = re.compile(r"\(\*.*?\*\)|/\*.*?\*/|//[^\r\n]*", re.DOTALL)
_RULE_HEAD = re.compile(r"RULE\s+[\w.]+\s*:", re.IGNORECASE)
_THEN = re.compile(r"\bTHEN\b", re.IGNORECASE)


@functools.cache
def _parser() -> Lark:
    return Lark(_GRAMMAR, start="file", parser="lalr", propagate_positions=True)


class _Operators(NamedTuple):
    """Operators of a block of rules; the accumulation is None if none is given."""

    conjunction: str
    disjunction: str
    implication: str
    accumulation: str | None


class FclReader(Source):
    """Reader of one text, which makes an engine from one function block."""

    def __init__(
        self, text: str, source: str, block: str | None = None, dialect: str = "iec"
    ) -> None:
        super().__init__(source)
        self._dialect = known_name("dialect", dialect, DIALECTS)
        tree = self._parsed(text)
        blocks = [one for one in tree.children if isinstance(one, Tree)]
        self._tree = self._chosen(blocks, block)
        self._kinds: dict[tuple[str, str], str] = {}

    def _parsed(self, text: str) -> Tree[Token]:
        blank = _COMMENT.sub(lambda found: re.sub(r"[^\r\n]", " ", found[0]), text)
        if opened := re.search(r"\(\*|/\*", blank):
            end = {"(*": "*)", "/*": "*/"}[opened[0]]
            line = len(re.findall(r"\r\n|\r|\n", blank[: opened.start()])) + 1
            raise self.malformed(line, f"the comment {opened[0]} has no end; close it with {end}")
        try:
            return _parser().parse(blank)
        except UnexpectedInput as error:
            line = max(int(getattr(error, "line", 1) or 1), 1)
            lines = blank.split("\n")
            shown = lines[line - 1].strip()[:40] if line <= len(lines) else ""
            expected = sorted(
                str(name)
                for name in (
                    getattr(error, "accepts", None)
                    or getattr(error, "expected", None)
                    or getattr(error, "allowed", None)
                    or ()
                )
                if not str(name).startswith("__")
            )
            raise self.malformed(
                line, f"got {shown or 'the end'!r}, expected {', '.join(expected[:12])}"
            ) from None

    def _chosen(self, blocks: list[Tree[Token]], name: str | None) -> Tree[Token]:
        names = [self._name_of(block) for block in blocks]
        if name is None and len(blocks) == 1:
            return blocks[0]
        if name is None:
            raise InvalidValue("block", name, f"the name of one of {', '.join(names)}")
        if name.lower() not in [one.lower() for one in names]:
            raise UnknownName("function block", name, names)
        return blocks[[one.lower() for one in names].index(name.lower())]

    @staticmethod
    def _name_of(block: Tree[Token]) -> str:
        first = block.children[0] if block.children else None
        return str(first) if isinstance(first, Token) else ""

    def system(self) -> AnySystem:
        """Return the system that the text describes."""
        engine = self._engine()
        try:
            return SystemMaker(engine, self.refused).system()
        except NotExpressible:
            raise
        except Fuzzy2Error as error:
            raise self.malformed(self._line(self._tree), str(error)) from error

    @staticmethod
    def _line(tree: Tree[Token]) -> int:
        return int(getattr(tree.meta, "line", 1))

    def _parts(self, kind: str) -> list[Tree[Token]]:
        return [one for one in self._tree.children if isinstance(one, Tree) and one.data == kind]

    def _engine(self) -> Engine:
        inputs, outputs = self._declared("inputs"), self._declared("outputs")
        for kind, names in (("VAR_INPUT", inputs), ("VAR_OUTPUT", outputs)):
            if not names:
                raise self.malformed(self._line(self._tree), f"{kind} declares nothing")
        both = [*inputs, *outputs]
        if len({name.lower() for name in both}) < len(both):
            raise self.malformed(self._line(self._tree), "a variable is declared twice")
        found = tuple(
            Input(name, self._range(name, ends, "fuzzify"), self._terms(name, "fuzzify", None))
            for name, ends in inputs.items()
        )
        terms = {
            name: self._terms(name, "defuzzify", (list(inputs), list(outputs))) for name in outputs
        }
        rules = self._rules(
            {one.name: tuple(one.terms) for one in found},
            {name: tuple(own) for name, own in terms.items()},
        )
        if not rules:
            raise self.malformed(self._line(self._tree), "there are no rules")
        made = tuple(self._output(name, ends, terms[name], rules) for name, ends in outputs.items())
        return Engine(
            self._name_of(self._tree),
            found,
            made,
            tuple(self._by_value(rule, terms) for rule, _ in rules),
        )

    @staticmethod
    def _by_value(rule: EngineRule, terms: dict[str, dict[str, Any]]) -> EngineRule:
        """Return a rule with the first of several equal terms, which accumulate as one."""
        said = tuple(
            (
                output,
                next(name for name, one in terms[output].items() if one == terms[output][term]),
            )
            for output, term in rule.said
        )
        return replace(rule, said=said)

    def _declared(self, kind: str) -> dict[str, tuple[float, float] | None]:
        found: dict[str, tuple[float, float] | None] = {}
        for part in self._parts(kind):
            for variable in part.children:
                assert isinstance(variable, Tree)
                ranges = [one for one in variable.children if isinstance(one, Tree)]
                name = str(variable.children[0])
                if name in found:
                    raise self.malformed(self._line(variable), f"{name!r} is declared twice")
                found[name] = self._ends(ranges[0]) if ranges else None
        return found

    def _number(self, token: Any) -> float:
        value = float(str(token)) if token.type == "NUMBER" else math.nan
        if math.isnan(value):
            reason = "numbers that another variable gives are not known"
            raise self.refused(token.line or 1, f"{str(token)!r} for a number", reason)
        return value

    def _ends(self, tree: Tree[Token]) -> tuple[float, float] | None:
        low, high = (self._number(token) for token in tree.children)
        if low > high:
            raise self.malformed(self._line(tree), f"the range from {low} to {high} is empty")
        return (low, high) if low < high and math.isfinite(high - low) else None

    def _of(self, name: str, kind: str) -> list[Tree[Token]]:
        """Return the sections of a variable."""
        sections = [
            one for one in self._parts(kind) if str(one.children[0]).lower() == name.lower()
        ]
        return [part for one in sections for part in one.children[1:] if isinstance(part, Tree)]

    def _range(
        self, name: str, declared: tuple[float, float] | None, kind: str
    ) -> tuple[float, float] | None:
        given = [self._ends(part) for part in self._of(name, kind) if part.data == "range"]
        return given[0] if given else declared

    def _terms(
        self, name: str, kind: str, variables: tuple[list[str], list[str]] | None
    ) -> dict[str, Any]:
        terms: dict[str, Any] = {}
        for part in self._of(name, kind):
            if part.data != "term":
                continue
            word, line = str(part.children[0]), self._line(part)
            # If several terms have the same name, the last one is used, as in jFuzzyLogic and
            # fuzzylite 8.
            try:
                terms[word] = self._shape(part.children[1], variables)
            except NotExpressible as error:
                if error.where != "fuzzy2" or " line " in error.what:
                    raise
                raise self.refused(line, error.what, error.reason) from error
            except Fuzzy2Error as error:
                raise self.malformed(line, str(error)) from error
        return terms

    def _shape(self, tree: Any, variables: tuple[list[str], list[str]] | None) -> Any:
        if isinstance(tree, Token):
            if variables is None:
                raise NotExpressible("FUNCTION of an input", "fuzzy2", "it is not a set")
            return function_of(
                str(tree)[len("FUNCTION") :], *variables, self._dialect == "jfuzzylogic"
            )
        if tree.data == "number":
            value = self._number(tree.children[0])
            return Singleton(value) if variables is None else Constant(value, value)
        if tree.data == "points":
            return points_of([self._point(point) for point in tree.children])
        kind, *rest = tree.children
        if str(kind).lower() == "singletons":
            raise NotExpressible("SINGLETONS", "fuzzy2", "a term is one point; write one for each")
        if any(isinstance(one, Tree) for one in rest):
            raise self.malformed(self._line(tree), f"{kind} takes numbers, not points")
        return shape_of(
            str(kind),
            [self._number(token) for token in rest],
            None if variables is None else len(variables[0]),
            self._dialect == "jfuzzylogic",
        )

    def _point(self, tree: Tree[Token]) -> tuple[float, float]:
        x, grade = tree.children
        return self._number(x), self._number(grade)

    def _rules(
        self, inputs: dict[str, tuple[str, ...]], outputs: dict[str, tuple[str, ...]]
    ) -> list[tuple[EngineRule, _Operators]]:
        found: list[tuple[EngineRule, _Operators]] = []
        for part in self._parts("rules"):
            operators = self._operators(part)
            for token in part.children:
                if isinstance(token, Token) and token.type == "RULE":
                    line = token.line or 1
                    text = _RULE_HEAD.sub("", str(token), count=1)
                    pieces = _THEN.split(text, maxsplit=1)
                    # A comma between conclusions means "and".
                    text = " THEN ".join(
                        [pieces[0], *(p.replace(",", " and ") for p in pieces[1:])]
                    )
                    try:
                        rules = rules_of(
                            text, line, FLL_HEDGES, (inputs, outputs), operators[:3], any_case=True
                        )
                    except InvalidRule as error:
                        raise self.malformed(line, f"the rule {error.reason}") from error
                    found += [(rule, operators) for rule in rules]
        return found

    def _operators(self, block: Tree[Token]) -> _Operators:
        given: dict[str, str] = {}
        for part in block.children:
            if isinstance(part, Tree):
                key, value = part.children
                assert isinstance(key, Token)
                known = {"AND": T_NORMS, "OR": S_NORMS, "ACT": T_NORMS, "ACCU": ACCUMULATIONS}
                name = str(key).upper()
                given[name] = self._choice(name, value, known[name])
        both = given.get("AND")
        either = given.get("OR")
        if both is None:
            pairs = {own: dual for dual, own in reversed(DUALS.items())}
            both = "min" if either is None else pairs.get(either, "min")
        return _Operators(both, either or DUALS[both], given.get("ACT", "min"), given.get("ACCU"))

    def _choice(self, key: str, token: Any, known: dict[str, str]) -> str:
        value = str(token).upper()
        if value not in known:
            raise self.refused(token.line or 1, f"{key} : {token}", f"known are {', '.join(known)}")
        return known[value]

    def _output(
        self,
        name: str,
        declared: tuple[float, float] | None,
        terms: dict[str, Any],
        rules: list[tuple[EngineRule, _Operators]],
    ) -> Output:
        options: dict[str, Any] = {}
        default = math.nan
        for part in self._of(name, "defuzzify"):
            if part.data == "option":
                options[str(part.children[0]).upper()] = part.children[1]
            elif part.data == "default":
                default = self._default(*part.children)
        if "LOCK" in options:
            reason = "a system does not remember; leave it out, or take DEFAULT := NC, which is NaN"
            raise self.refused(options["LOCK"].line or 1, "LOCK", reason)
        speaking = [
            (rule, own, term) for rule, own in rules for output, term in rule.said if output == name
        ]
        line = self._line(self._tree)
        if not speaking:
            return Output(name, None, terms, Defuzzifier("centroid"), "max", default)
        accumulations = {own.accumulation for _, own, _ in speaking}
        if "ACCU" in options:
            accumulations = {self._choice("ACCU", options["ACCU"], ACCUMULATIONS)}
        if len(accumulations) > 1:
            reason = "its rules accumulate differently; say ACCU in its DEFUZZIFY"
            raise self.refused(line, f"the output {name!r}", reason)
        aggregation = accumulations.pop()
        said = [terms[term] for _, _, term in speaking]
        given = options.get("METHOD")
        method = "COG" if given is None else str(given).upper()
        if method in METHODS:
            if any(isinstance(one, NUMBERS) for one in said):
                return self._of_points(name, method, said, terms, aggregation, default)
            ends = self._range(name, declared, "defuzzify") or universe(list(terms.values()))
            if ends is None:
                raise self.malformed(line, f"{name!r} has no range, and its terms no width")
            return Output(
                name, ends, terms, self._integral(given, method), aggregation or "max", default
            )
        if method not in ("COGS", "COGF", "COGSS"):
            known = ", ".join((*METHODS, "COGS", "COGF"))
            raise self.refused(getattr(given, "line", 1), f"METHOD : {given}", f"known are {known}")
        return self._weighted(name, (method, declared, default), said, terms, aggregation)

    def _integral(self, given: Any, method: str) -> Defuzzifier:
        """Return a method for sets, exact or with jFuzzyLogic's points."""
        if self._dialect == "iec":
            return Defuzzifier(METHODS[method])
        if method == "COA":
            reason = "its points are found from both ends; take dialect 'iec'"
            raise self.refused(given.line or 1, "METHOD : COA of jFuzzyLogic", reason)
        return Defuzzifier(METHODS[method], _JFUZZYLOGIC_POINTS, "left")

    def _of_points(
        self,
        name: str,
        method: str,
        said: list[Any],
        terms: dict[str, Any],
        aggregation: str | None,
        default: float,
    ) -> Output:
        """Return an output of singletons for a method for sets; COG serves for both."""
        if method != "COG" or not all(isinstance(one, Constant) for one in said):
            raise self.refused(
                self._line(self._tree), f"METHOD : {method} of numbers", "take COGS, or COGF"
            )
        return Output(name, None, terms, Defuzzifier("centroid"), aggregation or "max", default)

    def _weighted(
        self,
        name: str,
        given: tuple[str, tuple[float, float] | None, float],
        said: list[Any],
        terms: dict[str, Any],
        aggregation: str | None,
    ) -> Output:
        """Return an output that is an average or a sum of points."""
        method, declared, default = given
        ends = self._range(name, declared, "defuzzify")
        numbers = [isinstance(one, NUMBERS) for one in said]
        if any(numbers) != all(numbers):
            raise self.refused(
                self._line(self._tree), f"numbers and sets in {name!r}", "take one kind of terms"
            )
        if not all(numbers):
            self._check_monotonic(name, said)
            return Output(name, ends, terms, Defuzzifier("tsukamoto"), None, default)
        if method == "COGSS":
            return Output(name, ends, terms, Defuzzifier("weighted_sum"), None, default)
        united = (
            aggregation not in (None, SUM)
            and len(set(said)) < len(said)
            and all(isinstance(one, Constant) for one in said)
        )
        defuzzifier = Defuzzifier("centroid" if united else "center_of_sets")
        joint = None if aggregation == SUM else aggregation
        return Output(name, ends, terms, defuzzifier, joint, default)

    def _check_monotonic(self, name: str, said: list[Any]) -> None:
        """Refuse sets that an average of points cannot take, at the line of the method."""
        method = next(
            part.children[1]
            for part in reversed(self._of(name, "defuzzify"))
            if part.data == "option" and str(part.children[0]).upper() == "METHOD"
        )
        assert isinstance(method, Token)
        try:
            Monotonic(said, None)
        except NotApplicable as error:
            raise self.malformed(
                method.line or 1,
                f"METHOD : {method} of {name!r} averages numbers, or sets that only rise or only "
                f"fall, and {error.reason}; take COG for other sets",
            ) from error

    def _default(self, token: Any, otherwise: Any = None) -> float:
        if otherwise is not None and str(token).upper() not in ("NC", "NAN"):
            reason = (
                "a system does not remember its last output; take the number alone, or NC, which "
                "is NaN: there is nothing new"
            )
            raise self.refused(token.line or 1, f"DEFAULT := {token} | {otherwise}", reason)
        if token.type == "NAME":
            if str(token).upper() not in ("NC", "NAN"):
                raise self.malformed(token.line or 1, f"expected a number or NC, got {token!s:.40}")
            return math.nan
        value = self._number(token)
        if not math.isfinite(value):
            raise self.malformed(token.line or 1, "expected a finite number")
        return value
