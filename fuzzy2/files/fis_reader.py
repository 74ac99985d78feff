"""Reader of the text of a ``.fis`` file, which makes a description."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from typing import Any

import numpy as np

from fuzzy2.errors import Fuzzy2Error, InvalidValue, NotExpressible
from fuzzy2.files.description import (
    Constant,
    DescribedRule,
    Description,
    LinearFunction,
    Variable,
    system_of,
)
from fuzzy2.files.fis_lines import PARAMETERS, QUOTED, VECTOR, FisLines, Line, Section, unlike
from fuzzy2.files.fis_names import (
    AGGREGATIONS,
    DEFUZZIFIERS,
    KINDS,
    SAMPLE_POINTS,
    T_CONORMS,
    T_NORMS,
    type_reduction,
)
from fuzzy2.files.fis_rules import FisRules
from fuzzy2.files.fis_shapes import (
    Crossing,
    inside_range,
    open_toolbox_shape,
    pair_of_sets,
    toolbox_shape,
)
from fuzzy2.sets.interval_type2 import IntervalType2Set
from fuzzy2.support.checks import Array
from fuzzy2.systems.antecedents import Antecedent, Is, mapped
from fuzzy2.systems.operators import MAXIMA
from fuzzy2.systems.system import FuzzySystem

_TERM = re.compile(
    rf"{QUOTED}\s*:\s*{QUOTED}\s*,\s*{PARAMETERS}(?:\s*,\s*{VECTOR}\s*,\s*{VECTOR})?\s*"
)


class FisReader(FisLines):
    """Reader of one text, which makes sections and then a description."""

    def system(self) -> FuzzySystem:
        """Return the system that the text describes."""
        section = self.sections["System"]
        kind = self._kind(section)
        self._check_counts(section)
        inputs = tuple(
            self._variable(f"Input{i + 1}", section, None)
            for i in range(self.count(section, "NumInputs"))
        )
        outputs = tuple(
            self._variable(f"Output{i + 1}", section, (kind != "sugeno", inputs))
            for i in range(self.count(section, "NumOutputs"))
        )
        method = self._method(section)
        terms = [
            term
            for variable in (*inputs, *(outputs if kind != "sugeno" else ()))
            for term in variable.terms.values()
        ]
        type2 = method is not None or any(isinstance(term, IntervalType2Set) for term in terms)
        rules = FisRules(self, inputs, outputs).rules(section)
        if any(isinstance(term, Crossing) for term in terms):
            inputs, rules = twice(inputs, rules)
            type2, method = False, None
        try:
            return system_of(
                Description(
                    inputs,
                    outputs,
                    rules,
                    mamdani=kind != "sugeno",
                    type2=type2,
                    resolution=SAMPLE_POINTS,
                    **self._operators(section, kind),
                    **(method or {}),
                )
            )
        except NotExpressible:
            raise
        except Fuzzy2Error as error:
            raise self.malformed(section.number, str(error)) from error

    @property
    def _reduces_by_nie_tan(self) -> bool:
        method = self._method(self.sections["System"]) or {}
        return method.get("method") == "nie_tan" and self._kind(self.sections["System"]) == "sugeno"

    def _kind(self, section: Section) -> str:
        kind, line = self.string(section, "Type"), self.entry(section, "Type").number
        if kind in ("hybrid", "inverse tsukamoto", "unknown"):
            raise self.refused(line, f"Type={kind!r}", f"known are {', '.join(KINDS)}")
        if kind not in KINDS:
            raise self.malformed(line, f"expected 'mamdani' or 'sugeno', got {kind!r}")
        return KINDS[kind]

    def _check_counts(self, section: Section) -> None:
        for stem, key in (("Input", "NumInputs"), ("Output", "NumOutputs")):
            count, line = self.count(section, key), section.entries[key].number
            if count == 0:
                raise self.malformed(line, f"a system needs at least one {stem.lower()}")
            for name, found in self.sections.items():
                if name.startswith(stem) and not 1 <= int(name[len(stem) :]) <= count:
                    raise self.malformed(
                        found.number,
                        f"{key} in line {line} is {count}, but there is a section [{name}]",
                    )

    def _operators(self, section: Section, kind: str) -> dict[str, Any]:
        """Return the operators of a system in the meaning of the dialect."""
        octave = self.dialect == "octave"
        found: dict[str, Any] = {
            "t_norm": self.choice(section, "AndMethod", T_NORMS, "min"),
            "disjunction": self.choice(section, "OrMethod", T_CONORMS, "max"),
        }
        known = DEFUZZIFIERS[kind, self.dialect]
        reduction = self.choice(section, "DefuzzMethod", known, next(iter(known)))
        if kind == "mamdani":
            found["implication"] = self.choice(section, "ImpMethod", T_NORMS, "min")
            found["aggregation"] = self.choice(section, "AggMethod", AGGREGATIONS, "max")
            # Octave integrates between the points, MATLAB adds them up.
            trapezoids = octave and reduction not in MAXIMA
            found["integration"] = "trapezoidal" if trapezoids else "sum"
        elif kind == "sugeno" and octave:
            found["aggregation"] = self.choice(section, "AggMethod", AGGREGATIONS, "max")
            if found["aggregation"] != "sum":
                reduction = reduction.replace("center_of_sets", "united_average").replace(
                    "weighted_sum", "united_sum"
                )
            else:
                found["aggregation"] = "max"
        return {**found, "reduction": reduction}

    def _method(self, section: Section) -> dict[str, Any] | None:
        """Return the method of type reduction, if the file names one."""
        for key in ("TypeReductionMethod", "TypeRedMethod"):
            if key in section.entries:
                line, name = section.entries[key].number, self.string(section, key)
                try:
                    return type_reduction(key, name)
                except NotExpressible as error:
                    raise self.refused(line, error.what, error.reason) from error
        return None

    def _variable(
        self, header: str, system: Section, output: tuple[bool, tuple[Variable, ...]] | None
    ) -> Variable:
        """Return a variable.

        For an output, the function needs the kind of its terms and the inputs.
        """
        if header not in self.sections:
            raise self.malformed(system.number, f"there is no section [{header}]")
        section = self.sections[header]
        line = self.entry(section, "Range")
        inside = re.fullmatch(VECTOR, line.value)
        ends = self.vector(line.number, inside[1]) if inside else []
        count = self.count(section, "NumMFs")
        of_sets = output is not None and output[0]
        if not of_sets and len(ends) == 2 and ends[0] == ends[1]:
            # The ends only matter to output sets, so an empty range is widened elsewhere.
            ends = [ends[0] - 1.0, ends[1] + 1.0]
        if len(ends) != 2 or not ends[0] < ends[1] or math.isinf(ends[1] - ends[0]):
            raise self.malformed(line.number, f"expected Range=[low high], got {line.value[:40]!r}")
        terms: dict[str, Any] = {}
        for number in range(1, count + 1):
            name, term = self._term(section, number, output, (ends[0], ends[1]))
            terms[unlike(name, terms)] = term
        for key, entry in section.entries.items():
            if key.startswith("MF") and int(key[2:].rstrip("UL")) not in range(1, count + 1):
                raise self.malformed(entry.number, f"NumMFs is {count}, but there is {key}")
        return Variable(self.string(section, "Name"), (ends[0], ends[1]), terms)

    def _term(
        self,
        section: Section,
        number: int,
        output: tuple[bool, tuple[Variable, ...]] | None,
        ends: tuple[float, float],
    ) -> tuple[str, Any]:
        if f"MF{number}U" not in section.entries:
            line = self.entry(section, f"MF{number}")
            sugeno = output is not None and not output[0]
            name, kind, parameters, lower = self._membership(line, sugeno)
            if output is not None and not output[0]:
                return name, self._constant(line.number, kind, parameters, output[1])
            return name, self._guarded(
                line.number, kind, lambda: toolbox_shape(kind, parameters, lower)
            )
        above, below = self.entry(section, f"MF{number}U"), self.entry(section, f"MF{number}L")
        (name, kind, parameters, _), (other, other_kind, other_parameters, _) = (
            self._membership(above),
            self._membership(below),
        )
        upper = self._guarded(above.number, kind, lambda: open_toolbox_shape(kind, parameters))
        lower_set = self._guarded(
            below.number, other_kind, lambda: open_toolbox_shape(other_kind, other_parameters)
        )
        # The toolbox's own files use the names mf1U and mf1L for the term mf1.
        common = name[:-1] if name[-1:] == "U" and other == f"{name[:-1]}L" and name[:-1] else name
        if lower_set == upper:
            return common, upper
        try:
            return common, pair_of_sets(inside_range(lower_set, upper, ends), upper)
        except InvalidValue as error:
            if self._reduces_by_nie_tan:
                return common, Crossing(lower_set, upper)
            raise self.malformed(below.number, f"the pair: {error}") from error

    def _membership(
        self, line: Line, sugeno: bool = False
    ) -> tuple[str, str, list[float], tuple[list[float], list[float]] | None]:
        found = _TERM.fullmatch(line.value)
        if found is None:
            raise self.malformed(
                line.number, f"expected '<name>':'<kind>',[parameters], got {line.value[:60]!r}"
            )
        name, kind = found[1].replace("''", "'"), found[2]
        if sugeno and kind not in ("constant", "linear"):
            raise self.refused(line.number, f"the output {kind!r}", "known are constant and linear")
        if not name:
            raise self.malformed(line.number, "the name of the membership function is empty")
        lower = (
            None
            if found[4] is None
            else (self.vector(line.number, found[4]), self.vector(line.number, found[5]))
        )
        return name, kind, self.vector(line.number, found[3].strip("[]")), lower

    def _guarded(self, line: int, kind: str, make: Callable[[], Any]) -> Any:
        """Make a set; an error of its class is reported with the line."""
        try:
            return make()
        except NotExpressible as error:
            raise self.refused(line, error.what, error.reason) from error
        except Fuzzy2Error as error:
            raise self.malformed(line, f"{kind}: {error}") from error

    def _constant(
        self, line: int, kind: str, parameters: list[float], variables: tuple[Variable, ...]
    ) -> Constant | LinearFunction:
        if not all(map(math.isfinite, parameters)):
            raise self.malformed(line, f"expected finite numbers, got {parameters}")
        inputs = len(variables)
        if kind == "constant":
            if len(parameters) > 2 and not any(parameters[1:]):
                parameters = parameters[:1]
            if len(parameters) not in (1, 2) or parameters[0] > parameters[-1]:
                raise self.malformed(
                    line, f"expected one number, or the ends of an interval, got {parameters}"
                )
            return Constant(parameters[0], parameters[-1])
        if kind == "linear":
            two_ends = self._method(self.sections["System"]) is not None
            # Files of version 1 pad short entries with zeros.
            if len(parameters) > inputs + 1 and not any(parameters[inputs + 1 :]) and not two_ends:
                parameters = parameters[: inputs + 1]
            if len(parameters) == 2 * (inputs + 1) and two_ends:
                return self._between(line, np.array(parameters).reshape(2, -1), variables)
            if len(parameters) != inputs + 1:
                raise self.malformed(
                    line,
                    f"expected {inputs + 1} numbers, a slope for each input and the constant, "
                    f"got {len(parameters)}",
                )
            return LinearFunction(parameters[-1], tuple(parameters[:-1]))
        raise self.refused(line, f"the output {kind!r}", "known are constant and linear")

    def _between(self, line: int, ends: Array, variables: tuple[Variable, ...]) -> LinearFunction:
        """Return a function whose values are the intervals between two other functions."""
        middle, half = ends.mean(axis=0), 0.5 * (ends[1] - ends[0])
        slopes, constant = tuple(middle[:-1].tolist()), float(middle[-1])
        if self._reduces_by_nie_tan:
            # This method averages the middles, so the ends may cross.
            return LinearFunction(constant, slopes)
        # Right of 0 the greater slope belongs to the upper end, left of 0 the smaller one.
        signs = [
            1.0 if low >= 0.0 else -1.0 if high <= 0.0 else math.nan
            for low, high in (variable.range for variable in variables)
        ]
        spreads = [
            float(half[-1]),
            *(s * h if h else 0.0 for s, h in zip(signs, half[:-1].tolist(), strict=True)),
        ]
        if not all(spread >= 0.0 for spread in spreads):
            raise self.refused(
                line,
                "a linear function for each end of an interval, which cross",
                "the second one must be above within the ranges of the inputs, and slopes differ "
                "for inputs on one side of 0 only; take TypeRedMethod='NT', or equal slopes",
            )
        return LinearFunction(constant, slopes, tuple(spreads) if any(spreads) else ())


def twice(
    inputs: tuple[Variable, ...], rules: tuple[DescribedRule, ...]
) -> tuple[tuple[Variable, ...], tuple[DescribedRule, ...]]:
    r"""Return inputs with both membership functions as separate terms, and each rule twice.

    The Nie-Tan average is that of a type-1 system in which every rule occurs twice, once for each
    membership function,

    .. math:: y = \frac{\sum_r (\underline f_r + \overline f_r) c_r}
                       {\sum_r (\underline f_r + \overline f_r)},

    so membership functions that cross can be used.
    """
    doubled = []
    for variable in inputs:
        terms: dict[str, Any] = {}
        for name, term in variable.terms.items():
            terms[unlike(name, terms)] = term.upper
            terms[unlike(f"{name}_lower", terms)] = term.lower
        doubled.append(Variable(variable.name, variable.range, terms))

    def moved(tree: Antecedent, below: int) -> Antecedent:
        def one(clause: Is) -> Is:
            term = None if clause.term is None else 2 * int(clause.term) + below
            return Is(clause.variable, term)

        return mapped(tree, one)

    both = tuple(
        rule._replace(asked=moved(rule.asked, below)) for rule in rules for below in (0, 1)
    )
    return tuple(doubled), both
