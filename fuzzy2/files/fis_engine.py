"""Reader of ``.fis`` files in fuzzylite's dialect, which makes an engine.

The file has a single entry for the defuzzifier, although fuzzylite's outputs may have different
ones. For *hybrid* systems it is that of the sets; numbers are averaged without aggregation. A rule
without an antecedent, which remains of a rule about an output, never fires in fuzzylite and is left
out.
"""

from __future__ import annotations

import math
import re
from typing import Any

from fuzzy2.errors import Fuzzy2Error, NotExpressible
from fuzzy2.files.description import Constant
from fuzzy2.files.engine import (
    AnySystem,
    Defuzzifier,
    Engine,
    EngineRule,
    Input,
    Output,
    SystemMaker,
)
from fuzzy2.files.fis_lines import NUMBER, QUOTED, FisLines, Line, Section, unlike
from fuzzy2.files.fis_names import AGGREGATIONS, T_CONORMS, T_NORMS
from fuzzy2.files.fll_names import FLL_HEDGES, INTEGRALS, is_monotonic, term_of
from fuzzy2.files.functions import NUMBERS, FormulaFunction
from fuzzy2.files.rule_text import concluded
from fuzzy2.sets.formula_set import FormulaSet
from fuzzy2.support.formula import Formula
from fuzzy2.systems.antecedents import And, Antecedent, Hedged, Is, Not, Or

FUZZYLITE = ".fis of fuzzylite"
"""Name of fuzzylite's dialect in error messages."""

KINDS = {
    "binarymf": ("Binary", (0, 1)),
    "concavemf": ("Concave", (0, 1)),
    "constant": ("Constant", (0,)),
    "cosinemf": ("Cosine", (0, 1)),
    "discretemf": ("Discrete", None),
    "dsigmf": ("SigmoidDifference", (1, 0, 2, 3)),
    "gauss2mf": ("GaussianProduct", (1, 0, 3, 2)),
    "gaussmf": ("Gaussian", (1, 0)),
    "gbellmf": ("Bell", (2, 0, 1)),
    "linear": ("Linear", None),
    "pimf": ("PiShape", (0, 1, 2, 3)),
    "psigmf": ("SigmoidProduct", (1, 0, 2, 3)),
    "rampmf": ("Ramp", (0, 1)),
    "rectmf": ("Rectangle", (0, 1)),
    "sigmf": ("Sigmoid", (1, 0)),
    "smf": ("SShape", (0, 1)),
    "spikemf": ("Spike", (0, 1)),
    "trapmf": ("Trapezoid", (0, 1, 2, 3)),
    "trimf": ("Triangle", (0, 1, 2)),
    "zmf": ("ZShape", (0, 1)),
}
"""fuzzylite's terms, and the places of their parameters in the file."""

RESOLUTIONS = {5: 200, 6: 100, 7: 1000}
"""Number of pieces over which each version of fuzzylite integrates; its files do not contain it."""

_TYPES = ("mamdani", "larsen", "sugeno", "tsukamoto", "hybrid")
WEIGHTED_WORDS = {"wtaver": "center_of_sets", "wtsum": "weighted_sum"}
INTEGRAL_WORDS = {
    "centroid": INTEGRALS["Centroid"],
    "bisector": INTEGRALS["Bisector"],
    "lom": INTEGRALS["LargestOfMaximum"],
    "mom": INTEGRALS["MeanOfMaximum"],
    "som": INTEGRALS["SmallestOfMaximum"],
}
HEDGES = {1: ("seldom",), 5: ("somewhat",), 20: ("very",), 30: ("extremely",), 40: ("very",) * 2}
"""Hedges by the hundredths of a term's number; 99 is *any*."""

_TERM = re.compile(rf"{QUOTED}\s*:\s*'(\w+)'?\s*,\s*\[([^\]']*)\]\s*")
_RULE = re.compile(rf"([^,():]*),([^,():]*)\(\s*({NUMBER})\s*\)\s*:\s*([0-9]+)\s*")
_WORDS = re.compile(
    r"^\s*(?:#.*\bfuzzylite\b|(?:Enabled|Lock\w+)\s*=|Type\s*=\s*'(?:larsen|tsukamoto|hybrid)'"
    r"|MF[0-9]+\s*=\s*'(?:[^']|'')*'\s*:\s*'(?:binarymf|concavemf|cosinemf|spikemf|function)\b)",
    re.MULTILINE,
)


_VERSIONS = (
    re.compile(r"^\s*#.*\bfuzzylite\s+([0-9]+)\.", re.MULTILINE),
    re.compile(r"^\s*Version\s*=\s*([4-9])\.", re.MULTILINE),
)
_OF_VERSION_5 = re.compile(r"^\s*(?:Enabled|Lock\w+)\s*=", re.MULTILINE)


def version_of(text: str) -> int:
    """Return the version of fuzzylite, 5, 6 or 7, whose integration the file uses.

    Version 6 names itself in a comment and after ``Version=``. Version 5 does not, but has keys of
    its own. All other files are read as those of version 6, the last released version that reads
    such files.
    """
    found = next((one[1] for known in _VERSIONS if (one := known.search(text))), None)
    if found is None:
        return 5 if _OF_VERSION_5.search(text) else 6
    return min(max(int(found), 5), 7)


def is_of_fuzzylite(text: str) -> bool:
    """Return whether a file names fuzzylite, or uses features that only fuzzylite has."""
    return _WORDS.search(text) is not None


class FisEngineReader(FisLines):
    """Reader of one text, which makes sections and then an engine."""

    def __init__(self, text: str, source: str) -> None:
        super().__init__(text, source, "fuzzylite")
        self._resolution = RESOLUTIONS[version_of(text)]
        self._kinds: dict[tuple[str, str], str] = {}

    def system(self) -> AnySystem:
        """Return the system that the text describes."""
        section = self.sections["System"]
        kind = self.string(section, "Type")
        if kind not in _TYPES:
            line = self.entry(section, "Type").number
            raise self.refused(line, f"Type={kind!r}", f"known are {', '.join(_TYPES)}")
        engine = self._engine(section, kind)
        try:
            return SystemMaker(engine, self.refused).system()
        except NotExpressible:
            raise
        except Fuzzy2Error as error:
            raise self.malformed(section.number, str(error)) from error

    def _engine(self, section: Section, kind: str) -> Engine:
        counts = {key: self.count(section, key) for key in ("NumInputs", "NumOutputs")}
        for key, count in counts.items():
            if count == 0:
                line = section.entries[key].number
                raise self.malformed(line, f"a system needs at least one {key[3:-1].lower()}")
        inputs = tuple(self._input(f"Input{i + 1}") for i in range(counts["NumInputs"]))
        weighted = self.string(section, "DefuzzMethod", "centroid") in WEIGHTED_WORDS
        terms = [
            self._terms(f"Output{i + 1}", len(inputs), weighted)
            for i in range(counts["NumOutputs"])
        ]
        names = [self._name(f"Output{i + 1}") for i in range(len(terms))]
        known = {name: tuple(own) for name, own in zip(names, terms, strict=True)}
        rules = self._rules(section, inputs, known)
        outputs = tuple(
            self._output(f"Output{i + 1}", section, kind, own, rules) for i, own in enumerate(terms)
        )
        return Engine(self.string(section, "Name", "system"), inputs, outputs, rules)

    def _section(self, header: str) -> Section:
        if header not in self.sections:
            raise self.malformed(self.sections["System"].number, f"there is no section [{header}]")
        section = self.sections[header]
        if section.entries.get("Enabled", Line(0, "1")).value not in ("1", "1.0", "1.000"):
            raise self.refused(
                section.entries["Enabled"].number, "a disabled variable", "leave it out"
            )
        return section

    def _name(self, header: str) -> str:
        return self.string(self._section(header), "Name")

    def _range(self, section: Section) -> tuple[float, float] | None:
        line = self.entry(section, "Range")
        inside = re.fullmatch(r"\[([^\]']*)\]", line.value)
        ends = self.vector(line.number, inside[1]) if inside else []
        if len(ends) != 2 or not ends[0] <= ends[1]:
            raise self.malformed(line.number, f"expected Range=[low high], got {line.value[:40]!r}")
        return (ends[0], ends[1]) if ends[0] < ends[1] and all(map(math.isfinite, ends)) else None

    def _input(self, header: str) -> Input:
        section = self._section(header)
        return Input(self._name(header), self._range(section), self._terms(header, None, False))

    def _terms(self, header: str, inputs: int | None, weighted: bool) -> dict[str, Any]:
        section, terms = self._section(header), dict[str, Any]()
        # By their order, because fuzzylite checks neither their numbers nor their count.
        for line in (line for key, line in section.entries.items() if key.startswith("MF")):
            found = _TERM.fullmatch(line.value)
            if found is None or not found[1]:
                raise self.malformed(
                    line.number, f"expected '<name>':'<kind>',[parameters], got {line.value[:60]!r}"
                )
            name, kind = found[1].replace("''", "'"), found[2]
            name = unlike(name, terms)
            terms[name] = self._term(line.number, kind, found[3], inputs, section, weighted)
            self._kinds[self._name(header), name] = kind
        return terms

    def _term(
        self,
        line: int,
        kind: str,
        text: str,
        inputs: int | None,
        section: Section,
        weighted: bool,
    ) -> Any:
        try:
            if kind == "function":
                return self._function(line, text, section, weighted)
            if kind not in KINDS:
                raise self.refused(
                    line,
                    f"the membership function {kind!r}",
                    f"known are {', '.join((*KINDS, 'function'))}",
                )
            name, places = KINDS[kind]
            numbers = self.vector(line, text)
            if places is not None and len(numbers) >= len(places):
                numbers = [*(numbers[k] for k in places), *numbers[len(places) :]]
            return term_of(name, numbers, inputs)
        except NotExpressible as error:
            if error.what.startswith(self.source):
                raise
            raise self.refused(line, error.what, error.reason) from error
        except Fuzzy2Error as error:
            raise self.malformed(line, f"{kind}: {error}") from error

    def _function(self, line: int, text: str, section: Section, weighted: bool) -> Any:
        if weighted:
            return FormulaFunction(Formula(text).text)
        ends = self._range(section)
        if ends is None:
            raise self.refused(line, "a membership by formula", "its variable has no range")
        made = FormulaSet(text, *ends)
        if made.is_cut:
            raise self.refused(line, "a formula that leaves [0, 1]", "grades lie in it")
        return made

    def _output(
        self,
        header: str,
        system: Section,
        kind: str,
        terms: dict[str, Any],
        rules: tuple[EngineRule, ...],
    ) -> Output:
        section, name = self._section(header), self._name(header)
        said = [term for rule in rules for output, term in rule.said if output == name]
        numbers = [isinstance(terms[term], NUMBERS) for term in said]
        method = self.string(system, "DefuzzMethod", "centroid") or "centroid"
        line = self.entry(section, "Name").number
        if method not in (*WEIGHTED_WORDS, *INTEGRAL_WORDS):
            known = ", ".join((*WEIGHTED_WORDS, *INTEGRAL_WORDS))
            raise self.refused(
                system.entries["DefuzzMethod"].number, f"DefuzzMethod={method!r}", f"known: {known}"
            )
        if numbers and all(numbers) and (method in WEIGHTED_WORDS or kind == "hybrid"):
            defuzzifier = Defuzzifier(WEIGHTED_WORDS.get(method, "center_of_sets"))
            return self._made(section, name, terms, defuzzifier, None)
        if any(numbers):
            raise self.refused(line, f"{method} of numbers", "wtaver is what they go with")
        if method not in WEIGHTED_WORDS:
            aggregation = self.choice(system, "AggMethod", AGGREGATIONS, "max")
            defuzzifier = Defuzzifier(INTEGRAL_WORDS[method], self._resolution)
            return self._made(section, name, terms, defuzzifier, aggregation)
        kinds = sorted({self._kinds[name, term] for term in said})
        if method == "wtsum" or not all(is_monotonic(KINDS[one][0]) for one in kinds):
            raise self.refused(
                line, f"{method} of {', '.join(kinds)}", "averaged are numbers and monotonic terms"
            )
        return self._made(section, name, terms, Defuzzifier("tsukamoto"), None)

    def _made(
        self,
        section: Section,
        name: str,
        terms: dict[str, Any],
        defuzzifier: Defuzzifier,
        aggregation: str | None,
    ) -> Output:
        """Return an output; limits of its values are refused if they would have an effect."""
        ends, default = self._range(section), self._value(section, "Default", math.nan)
        if self._value(section, "LockPrevious", 0.0) and not math.isnan(default):
            raise self.refused(
                section.entries["LockPrevious"].number,
                "LockPrevious with a default",
                "a system does not remember its last output; take Default=nan",
            )
        held = self._value(section, "LockRange", 0.0) and defuzzifier.resolution is None
        if held and ends is not None:
            inside = all(
                isinstance(one, Constant) and ends[0] <= one.left <= ends[1]
                for one in terms.values()
            )
            if not inside or defuzzifier.reduction != "center_of_sets":
                raise self.refused(
                    section.entries["LockRange"].number,
                    f"LockRange of {name!r}",
                    "outputs are not held within their range",
                )
        if defuzzifier.resolution is not None and ends is None:
            raise self.malformed(section.number, f"{name!r} needs a range with ends")
        return Output(name, ends, terms, defuzzifier, aggregation, default)

    def _value(self, section: Section, key: str, default: float) -> float:
        line = section.entries.get(key)
        if line is None or line.value.lower() == "nan":
            return default
        (value,) = self.vector(line.number, line.value) or [math.nan]
        return value

    def _rules(
        self, system: Section, inputs: tuple[Input, ...], outputs: dict[str, tuple[str, ...]]
    ) -> tuple[EngineRule, ...]:
        if "Rules" not in self.sections or not self.sections["Rules"].rules:
            raise self.malformed(system.number, "there are no rules")
        operators = (
            self.choice(system, "AndMethod", T_NORMS, "min"),
            self.choice(system, "OrMethod", T_CONORMS, "max"),
            self.choice(system, "ImpMethod", T_NORMS, "min"),
        )
        asked = {one.name: tuple(one.terms) for one in inputs}
        found: list[EngineRule] = []
        for line in self.sections["Rules"].rules:
            found += self._rule(line, asked, outputs, operators)
        return tuple(found)

    def _rule(
        self,
        line: Line,
        inputs: dict[str, tuple[str, ...]],
        outputs: dict[str, tuple[str, ...]],
        operators: tuple[str, str, str],
    ) -> list[EngineRule]:
        found = _RULE.fullmatch(line.value)
        if found is None or found[4] not in ("1", "2"):
            raise self.malformed(
                line.number,
                f"expected '<inputs>, <outputs> (<weight>) : <1 or 2>', got {line.value[:60]!r}",
            )
        asked = self._clauses(line.number, found[1], inputs)
        said = self._clauses(line.number, found[2], outputs)
        weight = float(found[3])
        if not 0.0 <= weight <= 1.0:
            raise self.malformed(line.number, f"expected a weight from 0 to 1, got {found[3]}")
        if not asked or not said:
            return []
        parts: list[Antecedent] = []
        for variable, words, term in asked:
            part: Antecedent = Is(variable, term)
            for word in reversed(words):
                part = Not(part) if word == "not" else Hedged(FLL_HEDGES[word], part)
            parts.append(part)
        joint = tuple(parts)
        tree = parts[0] if len(parts) == 1 else Or(joint) if found[4] == "2" else And(joint)
        if weight != 1.0 and any(words for _, words, _ in said):
            raise self.refused(line.number, "a hedge of an output in a rule with a weight", "use 1")
        conclusions = [(name, words, str(term)) for name, words, term in said]
        return concluded(tree, conclusions, FLL_HEDGES, line.number, weight, operators)

    def _clauses(
        self, line: int, text: str, variables: dict[str, tuple[str, ...]]
    ) -> list[tuple[str, list[str], str | None]]:
        """Return the clauses: hedges and *not* from left to right, and the term."""
        codes = self.vector(line, text)
        if len(codes) != len(variables):
            raise self.malformed(line, f"expected {len(variables)} numbers, got {text.strip()!r}")
        found: list[tuple[str, list[str], str | None]] = []
        for code, (name, terms) in zip(codes, variables.items(), strict=True):
            # Values above 1e9 are cut off; no term has that number either.
            total = round(100.0 * min(abs(code), 1e9))
            number, hundredths = divmod(total, 100)
            is_code = math.isclose(abs(code), 0.01 * total, rel_tol=1e-12)
            if not is_code or number > len(terms) or hundredths not in (0, 99, *HEDGES):
                raise self.malformed(
                    line, f"{name} has membership functions 1 to {len(terms)}, got {code:.12g}"
                )
            if code == 0.0:
                continue
            words = [*(["not"] if code < 0.0 else []), *HEDGES.get(hundredths, ())]
            if hundredths == 99:
                found.append((name, words, None))
            elif number == 0:
                raise self.malformed(line, f"{code:g} is a hedge of no term of {name}")
            else:
                found.append((name, words, terms[number - 1]))
        return found
