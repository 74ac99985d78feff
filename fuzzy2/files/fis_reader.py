"""The text of a ``.fis`` file, read into a description."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from typing import Any, NamedTuple

from fuzzy2.errors import Fuzzy2Error, NotExpressible
from fuzzy2.files.description import (
    Constant,
    Description,
    LinearFunction,
    Rules,
    Variable,
    alternatives,
    negated,
    system_of,
)
from fuzzy2.files.fis_names import (
    AGGREGATIONS,
    OPEN_TOOLBOX_REDUCERS,
    REDUCERS,
    SAMPLE_POINTS,
    T_NORMS,
    open_toolbox_shape,
    pair_of_sets,
    toolbox_shape,
)
from fuzzy2.files.source import Source
from fuzzy2.sets.interval_type2 import IntervalType2Set
from fuzzy2.systems.rules import unknown_name
from fuzzy2.systems.system import FuzzySystem

_KEYS_OF_SYSTEM = (
    "Name",
    "Type",
    "Version",
    "NumInputs",
    "NumOutputs",
    "NumRules",
    "AndMethod",
    "OrMethod",
    "ImpMethod",
    "AggMethod",
    "DefuzzMethod",
    "TypeReductionMethod",
    "TypeRedMethod",
    "outputType",
    "CrispInterval",
)

_KEYS_OF_VARIABLE = ("Name", "Range", "NumMFs", "CrispInterval")

_NUMBER = r"[+-]?(?:\d+\.?\d*(?:[eE][+-]?\d+)?|\.\d+(?:[eE][+-]?\d+)?|[iI]nf)"
_QUOTED = r"'((?:[^']|'')*)'"
_VECTOR = r"\[([^\]']*)\]"
_TERM = re.compile(
    rf"{_QUOTED}\s*:\s*{_QUOTED}\s*,\s*{_VECTOR}(?:\s*,\s*{_VECTOR}\s*,\s*{_VECTOR})?\s*"
)

_RULE = re.compile(rf"([^,():]*),([^,():]*)\(\s*({_NUMBER})\s*\)\s*:\s*(\d+)\s*")


class _Line(NamedTuple):
    number: int
    value: str


class _Section(NamedTuple):
    name: str
    number: int
    entries: dict[str, _Line]
    rules: list[_Line]


class FisReader(Source):
    """One text, read into sections and then into a description."""

    def __init__(self, text: str, source: str) -> None:
        super().__init__(source)
        self.sections = self._sections(text)

    def _sections(self, text: str) -> dict[str, _Section]:
        sections: dict[str, _Section] = {}
        current = None
        for number, line in enumerate(re.split(r"\r\n|\r|\n", text), start=1):
            stripped = line.strip()
            if not stripped or stripped.startswith("%"):
                continue
            if header := re.fullmatch(r"\[(System|Rules|(?:Input|Output)\d+)\]", stripped):
                if header[1] in sections:
                    raise self.malformed(number, f"the section [{header[1]}] is there twice")
                current = sections[header[1]] = _Section(header[1], number, {}, [])
            elif current is None:
                raise self.malformed(number, f"expected [System], got {stripped[:40]!r}")
            elif current.name == "Rules":
                current.rules.append(_Line(number, stripped))
            else:
                self._add_entry(current, number, stripped)
        if "System" not in sections:
            raise self.malformed(1, "there is no section [System]")
        return sections

    def _add_entry(self, section: _Section, number: int, line: str) -> None:
        entry = re.fullmatch(r"(\w+)\s*=\s*(.*)", line)
        if entry is None:
            raise self.malformed(number, f"expected <key>=<value>, got {line[:40]!r}")
        key, known = entry[1], _KEYS_OF_SYSTEM if section.name == "System" else _KEYS_OF_VARIABLE
        if key not in known and (section.name == "System" or not re.fullmatch(r"MF\d+[UL]?", key)):
            raise self.malformed(number, unknown_name("key", key, known))
        if key in section.entries:
            raise self.malformed(
                number, f"{key} is there twice, first in line {section.entries[key].number}"
            )
        section.entries[key] = _Line(number, entry[2])

    def _entry(self, section: _Section, key: str) -> _Line:
        if key not in section.entries:
            raise self.malformed(section.number, f"the section [{section.name}] has no {key}")
        return section.entries[key]

    def _string(self, section: _Section, key: str) -> str:
        line = self._entry(section, key)
        quoted = re.fullmatch(_QUOTED, line.value)
        if quoted is None:
            raise self.malformed(line.number, f"expected {key}='...', got {line.value[:40]!r}")
        return quoted[1].replace("''", "'")

    def _count(self, section: _Section, key: str) -> int:
        line = self._entry(section, key)
        if not re.fullmatch(r"\d{1,9}", line.value):
            raise self.malformed(
                line.number, f"expected a whole number for {key}, got {line.value[:40]!r}"
            )
        return int(line.value)

    def _vector(self, number: int, text: str) -> list[float]:
        words = re.split(r"[\s,]+", text.strip()) if text.strip() else []
        wrong = next((word for word in words if not re.fullmatch(_NUMBER, word)), None)
        if wrong is not None:
            raise self.malformed(number, f"expected a number, got {wrong[:40]!r}")
        return [float(word) for word in words]

    def _choice(self, section: _Section, key: str, known: dict[str, str]) -> str:
        name = self._string(section, key)
        if name not in known:
            line = section.entries[key].number
            raise self.refused(line, f"{key}={name!r}", f"known are {', '.join(known)}")
        return known[name]

    def system(self) -> FuzzySystem:
        """Return the system that the text describes."""
        section = self.sections["System"]
        kind = self._string(section, "Type")
        if kind not in ("mamdani", "sugeno"):
            raise self.malformed(
                section.entries["Type"].number, f"expected 'mamdani' or 'sugeno', got {kind!r}"
            )
        mamdani = kind == "mamdani"
        for stem, key in (("Input", "NumInputs"), ("Output", "NumOutputs")):
            count, line = self._count(section, key), section.entries[key].number
            if count == 0:
                raise self.malformed(line, f"a system needs at least one {stem.lower()}")
            for name, found in self.sections.items():
                if name.startswith(stem) and not 1 <= int(name[len(stem) :]) <= count:
                    raise self.malformed(
                        found.number,
                        f"{key} in line {line} is {count}, but there is a section [{name}]",
                    )
        t_norm = self._t_norm(section, mamdani)
        inputs = tuple(
            self._variable(f"Input{i + 1}", section, None)
            for i in range(self._count(section, "NumInputs"))
        )
        outputs = tuple(
            self._variable(f"Output{i + 1}", section, (mamdani, len(inputs)))
            for i in range(self._count(section, "NumOutputs"))
        )
        aggregation = self._choice(section, "AggMethod", AGGREGATIONS) if mamdani else "max"
        reducer = self._reducer(section)
        terms = [
            term
            for variable in (*inputs, *(outputs if mamdani else ()))
            for term in variable.terms.values()
        ]
        type2 = reducer is not None or any(isinstance(term, IntervalType2Set) for term in terms)
        description = Description(
            inputs,
            outputs,
            self._rules(section, inputs, outputs, mamdani, aggregation),
            t_norm,
            mamdani,
            aggregation,
            type2,
            reducer or "eiasc",
            {"resolution": SAMPLE_POINTS} if mamdani else {},
        )
        try:
            return system_of(description)
        except Fuzzy2Error as error:
            raise self.malformed(section.number, str(error)) from error

    def _t_norm(self, section: _Section, mamdani: bool) -> str:
        t_norm = self._choice(section, "AndMethod", T_NORMS)
        defuzzifier, known = (
            self._string(section, "DefuzzMethod"),
            "centroid" if mamdani else "wtaver",
        )
        if defuzzifier != known:
            raise self.refused(
                section.entries["DefuzzMethod"].number,
                f"DefuzzMethod={defuzzifier!r}",
                f"known is {known}",
            )
        if mamdani and self._choice(section, "ImpMethod", T_NORMS) != t_norm:
            line = section.entries["ImpMethod"].number
            raise self.refused(
                line, "another ImpMethod than AndMethod", "a system has one t-norm for both"
            )
        return t_norm

    def _reducer(self, section: _Section) -> str | None:
        for key, known in (
            ("TypeReductionMethod", REDUCERS),
            ("TypeRedMethod", OPEN_TOOLBOX_REDUCERS),
        ):
            if key in section.entries:
                return self._choice(section, key, known)
        return None

    def _variable(self, header: str, system: _Section, output: tuple[bool, int] | None) -> Variable:
        """Return a variable.

        Of an output it matters whether it is Mamdani's, and how many inputs there are.
        """
        if header not in self.sections:
            raise self.malformed(system.number, f"there is no section [{header}]")
        section = self.sections[header]
        line = self._entry(section, "Range")
        inside = re.fullmatch(_VECTOR, line.value)
        ends = self._vector(line.number, inside[1]) if inside else []
        if len(ends) != 2 or not ends[0] < ends[1] or math.isinf(ends[1] - ends[0]):
            raise self.malformed(line.number, f"expected Range=[low high], got {line.value[:40]!r}")
        count = self._count(section, "NumMFs")
        terms: dict[str, Any] = {}
        for number in range(1, count + 1):
            name, term = self._term(section, number, output)
            if name in terms:
                raise self.malformed(
                    self._line_of(section, number),
                    f"the name {name!r} is given to two membership functions",
                )
            terms[name] = term
        if not terms:
            raise self.malformed(
                section.entries["NumMFs"].number,
                "a variable needs at least one membership function",
            )
        for key, entry in section.entries.items():
            if key.startswith("MF") and int(key[2:].rstrip("UL")) not in range(1, count + 1):
                raise self.malformed(entry.number, f"NumMFs is {count}, but there is {key}")
        return Variable(self._string(section, "Name"), (ends[0], ends[1]), terms)

    def _line_of(self, section: _Section, number: int) -> int:
        return next(
            section.entries[key].number
            for key in (f"MF{number}", f"MF{number}U")
            if key in section.entries
        )

    def _term(
        self, section: _Section, number: int, output: tuple[bool, int] | None
    ) -> tuple[str, Any]:
        if f"MF{number}U" not in section.entries:
            line = self._entry(section, f"MF{number}")
            name, kind, parameters, lower = self._membership(line)
            if output is not None and not output[0]:
                return name, self._constant(line.number, kind, parameters, output[1])
            return name, self._guarded(
                line.number, kind, lambda: toolbox_shape(kind, parameters, lower)
            )
        above, below = self._entry(section, f"MF{number}U"), self._entry(section, f"MF{number}L")
        (name, kind, parameters, _), (other, other_kind, other_parameters, _) = (
            self._membership(above),
            self._membership(below),
        )
        upper = self._guarded(above.number, kind, lambda: open_toolbox_shape(kind, parameters))
        lower_set = self._guarded(
            below.number, other_kind, lambda: open_toolbox_shape(other_kind, other_parameters)
        )
        # The toolbox's own names are mf1U and mf1L for the term mf1.
        common = name[:-1] if name[-1:] == "U" and other == f"{name[:-1]}L" and name[:-1] else name
        return common, upper if lower_set == upper else self._guarded(
            below.number, "the pair", lambda: pair_of_sets(lower_set, upper)
        )

    def _membership(
        self, line: _Line
    ) -> tuple[str, str, list[float], tuple[list[float], list[float]] | None]:
        found = _TERM.fullmatch(line.value)
        if found is None:
            raise self.malformed(
                line.number, f"expected '<name>':'<kind>',[parameters], got {line.value[:60]!r}"
            )
        name, kind = found[1].replace("''", "'"), found[2]
        if not name:
            raise self.malformed(line.number, "the name of the membership function is empty")
        lower = (
            None
            if found[4] is None
            else (self._vector(line.number, found[4]), self._vector(line.number, found[5]))
        )
        return name, kind, self._vector(line.number, found[3]), lower

    def _guarded(self, line: int, kind: str, make: Callable[[], Any]) -> Any:
        """Make a set; what its class says against it is said of the line."""
        try:
            return make()
        except NotExpressible as error:
            raise self.refused(line, error.what, error.reason) from error
        except Fuzzy2Error as error:
            raise self.malformed(line, f"{kind}: {error}") from error

    def _constant(
        self, line: int, kind: str, parameters: list[float], inputs: int
    ) -> Constant | LinearFunction:
        if not all(map(math.isfinite, parameters)):
            raise self.malformed(line, f"expected finite numbers, got {parameters}")
        if kind == "constant":
            if len(parameters) not in (1, 2) or parameters[0] > parameters[-1]:
                raise self.malformed(
                    line, f"expected one number, or the ends of an interval, got {parameters}"
                )
            return Constant(parameters[0], parameters[-1])
        if kind == "linear":
            if len(parameters) == 2 * (inputs + 1):
                raise self.refused(
                    line,
                    "a linear function with intervals",
                    "how their ends are listed is not documented",
                )
            if len(parameters) != inputs + 1:
                raise self.malformed(
                    line,
                    f"expected {inputs + 1} numbers, a slope for each input and the constant, "
                    f"got {len(parameters)}",
                )
            return LinearFunction(parameters[-1], tuple(parameters[:-1]))
        raise self.refused(line, f"the output {kind!r}", "known are constant and linear")

    def _rules(
        self,
        system: _Section,
        inputs: tuple[Variable, ...],
        outputs: tuple[Variable, ...],
        mamdani: bool,
        aggregation: str,
    ) -> Rules:
        if "Rules" not in self.sections or not self.sections["Rules"].rules:
            raise self.malformed(system.number, "there are no rules")
        section = self.sections["Rules"]
        count = self._count(system, "NumRules")
        if count != len(section.rules):
            raise self.malformed(
                system.entries["NumRules"].number,
                f"NumRules is {count}, but there are {len(section.rules)} rules",
            )
        rules = []
        # A negation adds a term to its variable, which the numbers of the file do not count.
        input_counts, output_counts = (
            [len(variable.terms) for variable in variables] for variables in (inputs, outputs)
        )
        for line in section.rules:
            found = _RULE.fullmatch(line.value)
            if found is None:
                raise self.malformed(
                    line.number,
                    "expected '<inputs>, <outputs> (<weight>) : <1 or 2>', got "
                    f"{line.value[:60]!r}",
                )
            asked = self._numbers(line.number, found[1], inputs, input_counts, "input")
            said = self._numbers(line.number, found[2], outputs, output_counts, "output")
            if float(found[3]) != 1.0:
                raise self.refused(line.number, f"the weight {found[3]}", "rules have no weights")
            if found[4] not in ("1", "2"):
                raise self.malformed(
                    line.number, f"expected 1 (and) or 2 (or) at the end, got {found[4]}"
                )
            used = [term for term in asked if term >= 0]
            if not used:
                raise self.malformed(line.number, "the rule asks for nothing")
            if found[4] == "1" or len(used) == 1:
                rules.append((asked, said))
                continue
            if not mamdani or aggregation != "max" or self._string(system, "OrMethod") != "max":
                reason = (
                    "only with AggMethod='max' and OrMethod='max' it is the same as one rule for "
                    "each alternative"
                )
                raise self.refused(line.number, "a rule with or", reason)
            rules += [(alternative, said) for alternative in alternatives(asked)]
        return tuple(rules)

    def _numbers(
        self, line: int, text: str, variables: tuple[Variable, ...], counts: list[int], kind: str
    ) -> tuple[int, ...]:
        words = text.split()
        if len(words) != len(variables):
            raise self.malformed(
                line, f"expected {len(variables)} numbers for the {kind}s, got {len(words)}"
            )
        numbers = []
        for word, variable, count in zip(words, variables, counts, strict=True):
            if not re.fullmatch(r"-?\d{1,9}", word) or abs(int(word)) > count:
                raise self.malformed(
                    line, f"{variable.name} has membership functions 1 to {count}, got {word!r}"
                )
            if kind == "output" and int(word) == 0:
                raise self.refused(
                    line,
                    f"a rule that says nothing about {variable.name}",
                    "each rule gives every output a term",
                )
            number = abs(int(word)) - 1
            if int(word) < 0:
                if isinstance(list(variable.terms.values())[number], Constant | LinearFunction):
                    raise self.refused(line, f"the negation {word}", "only sets have a complement")
                number = negated(variable, number)
            numbers.append(number)
        return tuple(numbers)
