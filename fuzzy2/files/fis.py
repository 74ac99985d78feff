"""Systems as files of MATLAB's Fuzzy Logic Toolbox (``.fis``), type-1 and interval type-2.

Three layouts are known by what is in them:

* type-1 (version 2): ``MF1='poor':'gaussmf',[1.5 0]``;
* type-2 of the Fuzzy Logic Toolbox (version 3): ``MF1='low':'trimf',[0 1 2],[0.8],[0.1 0.1]``, the
  upper membership function with the scale of the lower one and its lags on both sides, the grades
  of the upper one at which the lower one begins;
* type-2 of the open IT2-FLS toolbox by Taskin and Kumbasar (``.t2fis``):
  ``MF1U='low':'trimf',[0 1 2 1]`` and ``MF1L=...``, any two membership functions, with a height
  after their parameters.

A system takes one t-norm for *and* and for the implication. A rule with *or* becomes one rule for
each alternative, where that is the same: under the maximum. A term that a rule negates has its
complement as a term beside it, called *not* with its name, and is written as such a negation.
Weights and defuzzifiers other than the centroid are refused. MATLAB takes 101 points of an output's
range, and so does a system that is read.

Not kept are terms of outputs, and complements, that no rule mentions.
"""

from __future__ import annotations

import dataclasses
import math
import os
import re
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, NamedTuple, NoReturn

from fuzzy2.errors import Fuzzy2Error, InvalidValue, MalformedFile, NotExpressible
from fuzzy2.files.description import (
    SUM,
    Constant,
    Description,
    LinearFunction,
    Variable,
    alternatives,
    check_names,
    description_of,
    negated,
    system_of,
)
from fuzzy2.operations.set_operations import complement
from fuzzy2.sets.derived import Complement
from fuzzy2.sets.interval_type2 import GaussianUncertainSigma, IntervalType2Set, NearestMeanGaussian
from fuzzy2.sets.shapes import Gaussian, Interval, Trapezoidal, Triangular
from fuzzy2.sets.smooth_shapes import (
    Bell,
    PiShaped,
    Sigmoid,
    SigmoidDifference,
    SigmoidProduct,
    TwoSidedGaussian,
)
from fuzzy2.sets.type1 import Singleton, Type1Set
from fuzzy2.support.text_files import read_text, write_text
from fuzzy2.systems.rules import nearest_name
from fuzzy2.systems.system import FuzzySystem

SAMPLE_POINTS = 101
"""Points of an output's range that MATLAB takes for the centroid, unless it is told otherwise."""

OPEN_TOOLBOX_SUFFIX = ".t2fis"

_T_NORMS = {"min": "min", "prod": "product"}
_AGGREGATIONS = {"max": "max", "probor": "probabilistic", "sum": SUM}
_REDUCERS = {"karnikmendel": "km", "ekm": "ekm", "iasc": "iasc", "eiasc": "eiasc"}
_OPEN_TOOLBOX_REDUCERS = {
    "KM": "km",
    "Karnik-Mendel": "km",
    "EKM": "ekm",
    "IASC": "iasc",
    "EIASC": "eiasc",
}

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


def _gaussian_combination(
    sigma1: float, mean1: float, sigma2: float, mean2: float, height: float
) -> Type1Set:
    if abs(sigma1) == abs(sigma2) and mean1 <= mean2:
        return _unscaled(NearestMeanGaussian((mean1, mean2), abs(sigma1)), height)
    return _unscaled(TwoSidedGaussian((mean1, mean2), (abs(sigma1), abs(sigma2))), height)


def _pi(a: float, b: float, c: float, d: float, height: float) -> Type1Set:
    # Where the foot is not left of the shoulder, there is a step midway between them.
    if math.isfinite(a) and a >= b:
        a = b = 0.5 * a + 0.5 * b
    if math.isfinite(d) and c >= d:
        c = d = 0.5 * c + 0.5 * d
    if b > c:
        raise NotExpressible(
            "pimf with shoulders that cross",
            "fuzzy2",
            "the second shoulder must not be left of the first one",
        )
    return PiShaped(a, b, c, d, height)


def _unscaled(made: Type1Set, height: float) -> Type1Set:
    if height != 1.0:
        raise NotExpressible(f"a height of {height:g}", "fuzzy2", f"{type(made).__name__} has none")
    return made


_SHAPES: dict[str, tuple[int, Callable[..., Type1Set]]] = {
    "trimf": (3, Triangular),
    "trapmf": (4, Trapezoidal),
    "linsmf": (2, lambda a, b, height: Trapezoidal(a, b, math.inf, math.inf, height)),
    "linzmf": (2, lambda a, b, height: Trapezoidal(-math.inf, -math.inf, a, b, height)),
    "smf": (2, lambda a, b, height: _pi(a, b, math.inf, math.inf, height)),
    "zmf": (2, lambda a, b, height: _pi(-math.inf, -math.inf, a, b, height)),
    "pimf": (4, _pi),
    "gaussmf": (2, lambda sigma, mean, height: Gaussian(mean, abs(sigma), height)),
    "gauss2mf": (4, _gaussian_combination),
    "gbellmf": (
        3,
        lambda width, slope, center, height: _unscaled(Bell(center, abs(width), slope), height),
    ),
    "sigmf": (2, lambda slope, center, height: _unscaled(Sigmoid(center, slope), height)),
    "dsigmf": (
        4,
        lambda s1, c1, s2, c2, height: _unscaled(SigmoidDifference((c1, c2), (s1, s2)), height),
    ),
    "psigmf": (
        4,
        lambda s1, c1, s2, c2, height: _unscaled(SigmoidProduct((c1, c2), (s1, s2)), height),
    ),
}
"""Shapes with the number of their parameters; what makes them takes the height last."""


def parse_fis(text: str, source: str = "text") -> FuzzySystem:
    """Return the system that the text of a ``.fis`` file describes; see :func:`read_fis`.

    Parameters
    ----------
    text : str
        The text.
    source : str
        What error messages call it.

    Returns
    -------
    Type1System or IntervalType2System
        The system.

    Raises
    ------
    MalformedFile
        If the text is no such file; ``place`` is the line.
    NotExpressible
        If it describes what a system here cannot be; it names the line.
    """
    return _Reader(text, source).system()


def read_fis(path: str | os.PathLike[str]) -> FuzzySystem:
    """Return the system of a MATLAB ``.fis`` file, or of a ``.t2fis`` file of the IT2-FLS toolbox.

    Parameters
    ----------
    path : str or path-like
        The file.

    Returns
    -------
    Type1System or IntervalType2System
        Mamdani systems with the reducer ``"centroid"`` (``"center_of_sums"`` if the file sums), on
        101 points; Sugeno systems with ``"center_of_sets"``.

    Raises
    ------
    MalformedFile
        If it is no such file; ``place`` is the line.
    NotExpressible
        If it describes what a system here cannot be; it names the line.
    OSError
        If it cannot be read.
    """
    return parse_fis(read_text(path), str(path))


def format_fis(system: FuzzySystem, name: str = "system", open_toolbox: bool = False) -> str:
    """Return a system as the text of a ``.fis`` file; see :func:`write_fis`.

    Parameters
    ----------
    system : Type1System or IntervalType2System
        The system.
    name : str
        Its name in the file.
    open_toolbox : bool
        Whether type-2 sets are written for the IT2-FLS toolbox (``.t2fis``).

    Returns
    -------
    str
        The text.

    Raises
    ------
    NotExpressible
        If the format has no way to write the system.
    """
    where = OPEN_TOOLBOX_SUFFIX if open_toolbox else ".fis"
    return _Writer(description_of(system, where), name, where).text()


def write_fis(system: FuzzySystem, path: str | os.PathLike[str]) -> None:
    """Write a system to a MATLAB ``.fis`` file, or to a ``.t2fis`` file.

    The latter is the IT2-FLS toolbox's, and taken if the name ends so.

    MATLAB's own type-2 files hold only lower membership functions that are the upper one, scaled
    and, if it is a triangle or a trapezoid, with feet further in. The other ones hold any pair, but
    only Sugeno systems.

    Parameters
    ----------
    system : Type1System or IntervalType2System
        The system.
    path : str or path-like
        The file; one that exists is replaced whole.

    Raises
    ------
    NotExpressible
        If the format has no way to write the system.
    OSError
        If the file cannot be written; what was there before remains.
    """
    target = Path(path)
    write_text(format_fis(system, target.stem, target.suffix == OPEN_TOOLBOX_SUFFIX), path)


class _Reader:
    """One text, read into sections and then into a description."""

    def __init__(self, text: str, source: str) -> None:
        self.source = source
        self.sections = self._sections(text)

    def malformed(self, line: int, reason: str) -> MalformedFile:
        return MalformedFile(self.source, f"line {line}", reason)

    def refused(self, line: int, what: str, reason: str) -> NotExpressible:
        return NotExpressible(f"{self.source}, line {line}: {what}", "fuzzy2", reason)

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
            suggestion = nearest_name(key, known)
            raise self.malformed(
                number,
                f"unknown key {key!r}{f'; did you mean {suggestion!r}?' if suggestion else ''}",
            )
        if key in section.entries:
            raise self.malformed(
                number, f"{key} is there twice, first in line {section.entries[key].number}"
            )
        section.entries[key] = _Line(number, entry[2])

    def entry(self, section: _Section, key: str) -> _Line:
        if key not in section.entries:
            raise self.malformed(section.number, f"the section [{section.name}] has no {key}")
        return section.entries[key]

    def string(self, section: _Section, key: str) -> str:
        line = self.entry(section, key)
        quoted = re.fullmatch(_QUOTED, line.value)
        if quoted is None:
            raise self.malformed(line.number, f"expected {key}='...', got {line.value[:40]!r}")
        return quoted[1].replace("''", "'")

    def count(self, section: _Section, key: str) -> int:
        line = self.entry(section, key)
        if not re.fullmatch(r"\d{1,9}", line.value):
            raise self.malformed(
                line.number, f"expected a whole number for {key}, got {line.value[:40]!r}"
            )
        return int(line.value)

    def vector(self, number: int, text: str) -> list[float]:
        words = re.split(r"[\s,]+", text.strip()) if text.strip() else []
        wrong = next((word for word in words if not re.fullmatch(_NUMBER, word)), None)
        if wrong is not None:
            raise self.malformed(number, f"expected a number, got {wrong[:40]!r}")
        return [float(word) for word in words]

    def choice(self, section: _Section, key: str, known: dict[str, str]) -> str:
        name = self.string(section, key)
        if name not in known:
            line = section.entries[key].number
            raise self.refused(line, f"{key}={name!r}", f"known are {', '.join(known)}")
        return known[name]

    def system(self) -> FuzzySystem:
        section = self.sections["System"]
        kind = self.string(section, "Type")
        if kind not in ("mamdani", "sugeno"):
            raise self.malformed(
                section.entries["Type"].number, f"expected 'mamdani' or 'sugeno', got {kind!r}"
            )
        mamdani = kind == "mamdani"
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
        t_norm = self._t_norm(section, mamdani)
        inputs = tuple(
            self._variable(f"Input{i + 1}", section, None)
            for i in range(self.count(section, "NumInputs"))
        )
        outputs = tuple(
            self._variable(f"Output{i + 1}", section, (mamdani, len(inputs)))
            for i in range(self.count(section, "NumOutputs"))
        )
        aggregation = self.choice(section, "AggMethod", _AGGREGATIONS) if mamdani else "max"
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
        t_norm = self.choice(section, "AndMethod", _T_NORMS)
        defuzzifier, known = (
            self.string(section, "DefuzzMethod"),
            "centroid" if mamdani else "wtaver",
        )
        if defuzzifier != known:
            raise self.refused(
                section.entries["DefuzzMethod"].number,
                f"DefuzzMethod={defuzzifier!r}",
                f"known is {known}",
            )
        if mamdani and self.choice(section, "ImpMethod", _T_NORMS) != t_norm:
            line = section.entries["ImpMethod"].number
            raise self.refused(
                line, "another ImpMethod than AndMethod", "a system has one t-norm for both"
            )
        return t_norm

    def _reducer(self, section: _Section) -> str | None:
        for key, known in (
            ("TypeReductionMethod", _REDUCERS),
            ("TypeRedMethod", _OPEN_TOOLBOX_REDUCERS),
        ):
            if key in section.entries:
                return self.choice(section, key, known)
        return None

    def _variable(self, header: str, system: _Section, output: tuple[bool, int] | None) -> Variable:
        """Return a variable.

        Of an output it matters whether it is Mamdani's, and how many inputs there are.
        """
        if header not in self.sections:
            raise self.malformed(system.number, f"there is no section [{header}]")
        section = self.sections[header]
        line = self.entry(section, "Range")
        inside = re.fullmatch(_VECTOR, line.value)
        ends = self.vector(line.number, inside[1]) if inside else []
        if len(ends) != 2 or not ends[0] < ends[1] or math.isinf(ends[1] - ends[0]):
            raise self.malformed(line.number, f"expected Range=[low high], got {line.value[:40]!r}")
        count = self.count(section, "NumMFs")
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
        return Variable(self.string(section, "Name"), (ends[0], ends[1]), terms)

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
            line = self.entry(section, f"MF{number}")
            name, kind, parameters, lower = self._membership(line)
            if output is not None and not output[0]:
                return name, self._constant(line.number, kind, parameters, output[1])
            return name, self._guarded(line.number, kind, lambda: _shape(kind, parameters, lower))
        above, below = self.entry(section, f"MF{number}U"), self.entry(section, f"MF{number}L")
        (name, kind, parameters, _), (other, other_kind, other_parameters, _) = (
            self._membership(above),
            self._membership(below),
        )
        upper = self._guarded(above.number, kind, lambda: _shape_with_height(kind, parameters))
        lower_set = self._guarded(
            below.number, other_kind, lambda: _shape_with_height(other_kind, other_parameters)
        )
        # The toolbox's own names are mf1U and mf1L for the term mf1.
        common = name[:-1] if name[-1:] == "U" and other == f"{name[:-1]}L" and name[:-1] else name
        return common, upper if lower_set == upper else self._guarded(
            below.number, "the pair", lambda: _pair(lower_set, upper)
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
            else (self.vector(line.number, found[4]), self.vector(line.number, found[5]))
        )
        return name, kind, self.vector(line.number, found[3]), lower

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
    ) -> tuple[tuple[tuple[int, ...], tuple[int, ...]], ...]:
        if "Rules" not in self.sections or not self.sections["Rules"].rules:
            raise self.malformed(system.number, "there are no rules")
        section = self.sections["Rules"]
        count = self.count(system, "NumRules")
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
            if not mamdani or aggregation != "max" or self.string(system, "OrMethod") != "max":
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


def _shape(
    kind: str, parameters: list[float], lower: tuple[list[float], list[float]] | None
) -> Any:
    """Return a set of the Fuzzy Logic Toolbox.

    ``lower`` is the scale and the lags of a type-2 set.
    """
    upper = _named_shape(kind, parameters, 1.0)
    if lower is None:
        return upper
    scale, lag = lower
    if (
        len(scale) != 1
        or len(lag) not in (1, 2)
        or not all(0.0 <= value <= 1.0 for value in (*scale, *lag))
    ):
        raise InvalidValue("[scale],[lags]", (scale, lag), "one number and one or two, in [0, 1]")
    height, (left, right) = scale[0], (lag[0], lag[-1])
    if height == 1.0 and left == right == 0.0:
        return upper
    if left == right == 0.0:
        return _pair(_named_shape(kind, parameters, height), upper)
    if not isinstance(upper, Triangular | Trapezoidal):
        raise NotExpressible(
            f"a lag of {kind!r}", "fuzzy2", "what it means where sides are curved is not documented"
        )
    return _pair(_lagged(upper, left, right, height), upper)


def _lagged(upper: Triangular | Trapezoidal, left: float, right: float, height: float) -> Type1Set:
    if isinstance(upper, Triangular):
        foot, other_foot = (
            upper.left + left * (upper.peak - upper.left),
            upper.right - right * (upper.right - upper.peak),
        )
        return Triangular(min(foot, upper.peak), upper.peak, max(other_foot, upper.peak), height)
    a = upper.a if math.isinf(upper.a) else min(upper.a + left * (upper.b - upper.a), upper.b)
    d = upper.d if math.isinf(upper.d) else max(upper.d - right * (upper.d - upper.c), upper.c)
    return Trapezoidal(a, upper.b, upper.c, d, height)


def _shape_with_height(kind: str, parameters: list[float]) -> Type1Set:
    """Return a set of the open toolbox, whose height may follow its parameters."""
    count = _SHAPES[kind][0] if kind in _SHAPES else 0
    return (
        _named_shape(kind, parameters[:count], parameters[count])
        if len(parameters) == count + 1
        else _named_shape(kind, parameters, 1.0)
    )


def _named_shape(kind: str, parameters: list[float], height: float) -> Type1Set:
    if kind not in _SHAPES:
        raise NotExpressible(
            f"the membership function {kind!r}", "fuzzy2", f"known are {', '.join(_SHAPES)}"
        )
    count, make = _SHAPES[kind]
    if len(parameters) != count:
        raise InvalidValue("the parameters", parameters, f"{count} numbers")
    return make(*parameters, height)


def _pair(lower: Type1Set, upper: Type1Set) -> IntervalType2Set:
    if (
        isinstance(lower, Gaussian)
        and isinstance(upper, Gaussian)
        and lower.mean == upper.mean
        and lower.height == upper.height == 1.0
    ):
        return (
            GaussianUncertainSigma(lower.mean, (lower.sigma, upper.sigma))
            if lower.sigma <= upper.sigma
            else IntervalType2Set(lower, upper)
        )
    return IntervalType2Set(lower=lower, upper=upper)


class _Writer:
    """One description, written line by line."""

    def __init__(self, description: Description, name: str, where: str) -> None:
        self.description, self.where = description, where
        self.open_toolbox = where == OPEN_TOOLBOX_SUFFIX
        check_names(description, where)
        self.name = name if name.isprintable() else "system"

    def refuse(self, what: str, reason: str) -> NoReturn:
        raise NotExpressible(what, self.where, reason)

    def text(self) -> str:
        described = self.description
        if self.open_toolbox and described.mamdani:
            self.refuse(
                "a system whose consequents are sets",
                "that toolbox has Sugeno systems only; write .fis",
            )
        if self.open_toolbox and not described.type2:
            self.refuse("a type-1 system", "that toolbox has type-2 systems only; write .fis")
        lines = ["[System]", f"Name={_quote(self.name)}", *self._system(), ""]
        inputs, outputs = (
            [_without_complements(variable) for variable in of]
            for of in (described.inputs, described.outputs)
        )
        for i, (variable, _) in enumerate(inputs):
            lines += [f"[Input{i + 1}]", *self._variable(variable, True), ""]
        for i, (variable, _) in enumerate(outputs):
            lines += [f"[Output{i + 1}]", *self._variable(variable, described.mamdani), ""]
        lines.append("[Rules]")
        for asked, said in described.rules:
            if max(asked) < 0:
                self.refuse(
                    "a rule that asks for nothing", "it cannot be told from one that never fires"
                )
            sides = (
                " ".join(
                    str(numbers[term] if term >= 0 else 0)
                    for term, (_, numbers) in zip(terms, variables, strict=True)
                )
                for terms, variables in ((asked, inputs), (said, outputs))
            )
            lines.append(f"{', '.join(sides)} (1) : 1")
        return "\n".join(lines) + "\n"

    def _system(self) -> list[str]:
        described = self.description
        version = "3.0" if described.type2 and not self.open_toolbox else "2.0"
        t_norm = _known_as(described.t_norm, _T_NORMS) or self.refuse(
            f"the t-norm {described.t_norm!r}", "it has min and prod only"
        )
        if described.mamdani:
            aggregation = _known_as(described.aggregation, _AGGREGATIONS)
            if aggregation is None:
                self.refuse(
                    f"the t-conorm {described.aggregation!r}", "it has max, probor and sum only"
                )
            kind, methods = "mamdani", ("max", t_norm, aggregation, "centroid")
        else:
            kind, methods = "sugeno", ("probor", "prod", "sum", "wtaver")
        lines = [
            f"Type='{kind}'",
            f"Version={version}",
            f"NumInputs={len(described.inputs)}",
            f"NumOutputs={len(described.outputs)}",
        ]
        lines += [f"NumRules={len(described.rules)}", f"AndMethod='{t_norm}'"]
        lines += [
            f"{key}='{method}'"
            for key, method in zip(
                ("OrMethod", "ImpMethod", "AggMethod", "DefuzzMethod"), methods, strict=True
            )
        ]
        if described.type2:
            # A method that MATLAB has not is as exact as the one that it is exchanged for.
            known, key = (
                (_OPEN_TOOLBOX_REDUCERS, "TypeRedMethod")
                if self.open_toolbox
                else (_REDUCERS, "TypeReductionMethod")
            )
            lines.append(
                f"{key}='{_known_as(described.method, known) or _known_as('eiasc', known)}'"
            )
        return lines

    def _variable(self, variable: Variable, of_sets: bool) -> list[str]:
        low, high = variable.range
        if not low < high:
            # A range of no width is not read; constants may all be one.
            margin = max(1.0, 0.5 * abs(low))
            low, high = low - margin, high + margin
        lines = [
            f"Name={_quote(variable.name)}",
            f"Range={_vector((low, high))}",
            f"NumMFs={len(variable.terms)}",
        ]
        for i, (name, term) in enumerate(variable.terms.items()):
            if of_sets:
                lines += self._term(f"MF{i + 1}", name, term)
            elif isinstance(term, LinearFunction):
                lines.append(
                    f"MF{i + 1}={_quote(name)}:'linear',{_vector((*term.slopes, term.constant))}"
                )
            elif self.open_toolbox:
                lines.append(f"MF{i + 1}={_quote(name)}:'constant',{_vector(term)}")
            elif term.left == term.right:
                lines.append(f"MF{i + 1}={_quote(name)}:'constant',{_vector(term[:1])}")
            else:
                self.refuse(
                    f"the interval {list(term)} as a consequent",
                    "its constants are crisp; write .t2fis",
                )
        return lines

    def _term(self, key: str, name: str, term: Any) -> list[str]:
        lower, upper = (
            (term.lower, term.upper) if isinstance(term, IntervalType2Set) else (term, term)
        )
        if self.open_toolbox:
            both = [(side, *self._shape(one)) for side, one in (("U", upper), ("L", lower))]
            return [
                f"{key}{side}={_quote(name)}:'{kind}',{_vector((*values, height))}"
                for side, kind, values, height in both
            ]
        kind, values, height = self._shape(upper)
        if height != 1.0:
            self.refuse(f"{upper!r}", "its membership functions reach 1")
        if not self.description.type2:
            return [f"{key}={_quote(name)}:'{kind}',{_vector(values)}"]
        scale, lags = self._scale_and_lags(term, lower, upper)
        return [
            f"{key}={_quote(name)}:'{kind}',{_vector(values)},{_vector([scale])},{_vector(lags)}"
        ]

    def _scale_and_lags(
        self, term: Any, lower: Type1Set, upper: Type1Set
    ) -> tuple[float, tuple[float, float]]:
        if lower == upper:
            return 1.0, (0.0, 0.0)
        if (
            isinstance(lower, Gaussian | PiShaped)
            and dataclasses.replace(lower, height=1.0) == upper
        ):
            return lower.height, (0.0, 0.0)
        below, above = _corners(lower), _corners(upper)
        if below is None or above is None or below[1:3] != above[1:3]:
            self.refuse(
                f"{term!r}",
                "the lower membership function is not the upper one, scaled and lagged; write "
                ".t2fis or JSON",
            )
        return lower.height, (
            _lag(above[0], below[0], above[1]),
            _lag(above[3], below[3], above[2]),
        )

    def _shape(self, one: Type1Set) -> tuple[str, tuple[float, ...], float]:
        if isinstance(one, Trapezoidal) and math.isinf(one.a) and math.isfinite(one.d):
            return "linzmf", (one.c, one.d), one.height
        if isinstance(one, Trapezoidal) and math.isinf(one.d) and math.isfinite(one.a):
            return "linsmf", (one.a, one.b), one.height
        corners = _corners(one)
        if corners is not None and all(map(math.isfinite, corners)):
            return (
                ("trimf", (corners[0], *corners[2:]), one.height)
                if isinstance(one, Triangular)
                else ("trapmf", corners, one.height)
            )
        if isinstance(one, Gaussian):
            return "gaussmf", (one.sigma, one.mean), one.height
        if isinstance(one, NearestMeanGaussian):
            return "gauss2mf", (one.sigma, one.mean[0], one.sigma, one.mean[1]), 1.0
        if isinstance(one, PiShaped) and (math.isfinite(one.a) or math.isfinite(one.d)):
            corners = one.a, one.b, one.c, one.d
            kind = "zmf" if math.isinf(one.a) else "smf" if math.isinf(one.d) else "pimf"
            return kind, tuple(filter(math.isfinite, corners)), one.height
        if isinstance(one, TwoSidedGaussian):
            return "gauss2mf", (one.sigma[0], one.mean[0], one.sigma[1], one.mean[1]), 1.0
        if isinstance(one, SigmoidDifference | SigmoidProduct):
            (c1, c2), (s1, s2) = one.center, one.slope
            return (
                "dsigmf" if isinstance(one, SigmoidDifference) else "psigmf",
                (s1, c1, s2, c2),
                1.0,
            )
        if isinstance(one, Bell):
            return "gbellmf", (one.width, one.slope, one.center), 1.0
        if isinstance(one, Sigmoid):
            return "sigmf", (one.slope, one.center), 1.0
        raise NotExpressible(f"{one!r}", self.where, "it has no membership function of that shape")


def _corners(one: Type1Set) -> tuple[float, float, float, float] | None:
    """Return the corners of a set with straight sides as a trapezoid."""
    if isinstance(one, Trapezoidal):
        return one.a, one.b, one.c, one.d
    if isinstance(one, Triangular):
        return one.left, one.peak, one.peak, one.right
    if isinstance(one, Interval):
        return one.left, one.left, one.right, one.right
    return (one.point,) * 4 if isinstance(one, Singleton) else None


def _without_complements(variable: Variable) -> tuple[Variable, list[int]]:
    """Return a variable without its complements, and the number of each term.

    Numbers count from 1 and are negative for a complement.
    """
    terms = {name: term for name, term in variable.terms.items() if not _is_complement(term)}
    numbers = []
    for name, term in variable.terms.items():
        sign, one = (-1, complement(term)) if _is_complement(term) else (1, term)
        if name not in terms and one not in terms.values():
            own = name.removeprefix("not ") or name
            while own in variable.terms or own in terms:
                own = f"not {own}"
            terms[own] = one
        place = list(terms).index(name) if sign > 0 else list(terms.values()).index(one)
        numbers.append(sign * (place + 1))
    return Variable(variable.name, variable.range, terms), numbers


def _is_complement(term: Any) -> bool:
    if isinstance(term, IntervalType2Set):
        return isinstance(term.lower, Complement) and isinstance(term.upper, Complement)
    return isinstance(term, Complement)


def _lag(foot: float, lower_foot: float, shoulder: float) -> float:
    """Return the grade of the upper membership function at the foot of the lower one."""
    return (
        0.0 if foot == lower_foot else min(max((lower_foot - foot) / (shoulder - foot), 0.0), 1.0)
    )


def _known_as(name: str, known: dict[str, str]) -> str | None:
    return next((theirs for theirs, ours in known.items() if ours == name), None)


def _quote(name: str) -> str:
    return "'" + name.replace("'", "''") + "'"


def _vector(values: Iterable[float]) -> str:
    # The digits that give back the same float.
    return (
        "["
        + " ".join(repr(float(value)).removesuffix(".0").replace("inf", "Inf") for value in values)
        + "]"
    )
