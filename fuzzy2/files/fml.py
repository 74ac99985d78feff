"""Systems in the Fuzzy Markup Language of IEEE Std 1855-2016 (FML).

Type-1 systems of Mamdani, and of Takagi, Sugeno and Kang.

The shapes that have a class here are read and written: triangles, trapezoids, shoulders (right and
left linear), Gaussians, rectangles, singletons, linearly interpolated points, Gaussian shoulders,
and S-, Z- and pi-shaped sets. The standard gives a pi shape two parameters and does not say which;
here, as in its reference implementation JFML, they are the left foot and the top, and the right
side mirrors the left one. Complements of all these are kept, and what the modifier ``not`` makes of
a term becomes a term of its own.

One t-norm serves for *and* and for the activation. A rule with *or* becomes one rule for each
alternative, where that is the same: under the maximum. Weights, other modifiers, *else*, other
defuzzifiers than the center of gravity, and the rule bases of Tsukamoto and AnYa are refused with
their line.

Where no rule fires a system answers NaN; so ``defaultValue`` is written ``NaN``, and that of a file
is not used. Terms of outputs that no rule mentions are not kept. A document type declaration is
refused: it could make a small file expand without end, or read other files.

The schema of the standard names the t-norms of Lukasiewicz and the drastic one ``BSUM`` and
``DRS``, like their t-conorms, its text ``BDIF`` and ``DRP``: written are the names of the schema,
read are both.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NoReturn
from xml.etree import ElementTree
from xml.parsers import expat

from fuzzy2.errors import Fuzzy2Error, MalformedFile, NotExpressible
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
from fuzzy2.sets.derived import Complement
from fuzzy2.sets.shapes import Gaussian, Interval, Trapezoidal, Triangular
from fuzzy2.sets.smooth_shapes import PiShaped, TwoSidedGaussian
from fuzzy2.sets.type1 import SampledSet, Singleton, Type1Set
from fuzzy2.support.text_files import read_text, write_text
from fuzzy2.systems.rules import nearest_name
from fuzzy2.systems.system import FuzzySystem

NAMESPACE = "http://www.ieee1855.org"

_T_NORMS = {
    "MIN": "min",
    "PROD": "product",
    "BSUM": "lukasiewicz",
    "BDIF": "lukasiewicz",
    "DRS": "drastic",
    "DRP": "drastic",
    "EPROD": "einstein",
    "HPROD": "hamacher",
    "NILMIN": "nilpotent",
}
_T_CONORMS = {
    "MAX": "max",
    "PROBOR": "probabilistic",
    "BSUM": "lukasiewicz",
    "DRS": "drastic",
    "ESUM": "einstein",
    "HSUM": "hamacher",
    "NILMAX": "nilpotent",
}

_SHAPES: dict[str, tuple[int, Callable[..., Type1Set]]] = {
    "triangularShape": (3, Triangular),
    "trapezoidShape": (4, Trapezoidal),
    "gaussianShape": (2, Gaussian),
    "rectangularShape": (2, Interval),
    "singletonShape": (1, Singleton),
    "rightLinearShape": (2, lambda a, b: Trapezoidal(a, b, math.inf, math.inf)),
    "leftLinearShape": (2, lambda a, b: Trapezoidal(-math.inf, -math.inf, a, b)),
    "rightGaussianShape": (
        2,
        lambda mean, sigma: TwoSidedGaussian((mean, mean), (sigma, math.inf)),
    ),
    "leftGaussianShape": (2, lambda mean, sigma: TwoSidedGaussian((mean, mean), (math.inf, sigma))),
    "sShape": (2, lambda a, b: PiShaped(a, b, math.inf, math.inf)),
    "zShape": (2, lambda a, b: PiShaped(-math.inf, -math.inf, a, b)),
    "piShape": (2, lambda foot, top: PiShaped(foot, top, top, top + (top - foot))),
}
"""Shapes with the number of their parameters."""

_SHAPES_WITHOUT_CLASS = ("circularDefinition", "customShape")
_OTHER_RULE_BASES = ("tsukamotoRuleBase", "anYaRuleBase")
_OTHER_VARIABLES = ("tsukamotoVariable", "aggregatedFuzzyVariable", "anYaDataCloud")


@dataclass
class _Element:
    """Element of a document that remembers its line."""

    name: str
    attributes: dict[str, str]
    line: int
    children: list[_Element] = field(default_factory=list)
    text: str = ""


def parse_fml(text: str, source: str = "text") -> FuzzySystem:
    """Return the system that an FML document describes; see :func:`read_fml`.

    Parameters
    ----------
    text : str
        The document.
    source : str
        What error messages call it.

    Returns
    -------
    Type1System
        The system.

    Raises
    ------
    MalformedFile
        If the text is no such document; ``place`` is the line.
    NotExpressible
        If it describes what a system here cannot be; it names the line.
    """
    return _Reader(source).system(text)


def read_fml(path: str | os.PathLike[str]) -> FuzzySystem:
    """Return the system of an FML file.

    Parameters
    ----------
    path : str or path-like
        The file.

    Returns
    -------
    Type1System
        A Mamdani system with the reducer ``"centroid"``, or a Takagi-Sugeno-Kang system with
        ``"center_of_sets"``.

    Raises
    ------
    MalformedFile
        If it is no such file; ``place`` is the line.
    NotExpressible
        If it describes what a system here cannot be; it names the line.
    OSError
        If it cannot be read.
    """
    return parse_fml(read_text(path), str(path))


def format_fml(system: FuzzySystem, name: str = "system") -> str:
    """Return a system as an FML document; see :func:`write_fml`.

    Parameters
    ----------
    system : Type1System
        The system.
    name : str
        Its name in the document.

    Returns
    -------
    str
        The document.

    Raises
    ------
    NotExpressible
        If FML has no way to write the system.
    """
    root = _written(description_of(system, "FML"), name if name.isprintable() else "system")
    ElementTree.indent(root)
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        + ElementTree.tostring(root, encoding="unicode")
        + "\n"
    )


def write_fml(system: FuzzySystem, path: str | os.PathLike[str]) -> None:
    """Write a system to an FML file.

    Parameters
    ----------
    system : Type1System
        The system.
    path : str or path-like
        The file; one that exists is replaced whole.

    Raises
    ------
    NotExpressible
        If FML has no way to write the system.
    OSError
        If the file cannot be written; what was there before remains.
    """
    write_text(format_fml(system, Path(path).stem), path)


class _Reader:
    """One document, read into elements and then into a description."""

    def __init__(self, source: str) -> None:
        self.source = source

    def malformed(self, line: int, reason: str) -> MalformedFile:
        return MalformedFile(self.source, f"line {line}", reason)

    def refused(self, line: int, what: str, reason: str) -> NotExpressible:
        return NotExpressible(f"{self.source}, line {line}: {what}", "fuzzy2", reason)

    def _root(self, text: str) -> _Element:
        parser = expat.ParserCreate(namespace_separator="}")
        holder = _Element("", {}, 0)
        open_elements = [holder]

        def start(name: str, attributes: dict[str, str]) -> None:
            namespace, _, local = name.rpartition("}")
            if namespace not in ("", NAMESPACE):
                raise self.malformed(
                    parser.CurrentLineNumber,
                    f"expected elements of {NAMESPACE}, got one of {namespace}",
                )
            element = _Element(local, attributes, parser.CurrentLineNumber)
            open_elements[-1].children.append(element)
            open_elements.append(element)

        def end(name: str) -> None:
            open_elements.pop()

        def characters(text: str) -> None:
            open_elements[-1].text += text

        def doctype(*_: object) -> None:
            raise self.malformed(
                parser.CurrentLineNumber, "a document type declaration is not allowed"
            )

        parser.StartElementHandler, parser.EndElementHandler, parser.CharacterDataHandler = (
            start,
            end,
            characters,
        )
        parser.StartDoctypeDeclHandler = doctype
        try:
            parser.Parse(text.encode("utf-8", "surrogatepass"), True)
        except expat.ExpatError as error:
            reason = expat.errors.messages[error.code]
            raise MalformedFile(
                self.source, f"line {error.lineno}, column {error.offset + 1}", reason
            ) from None
        return holder.children[0]

    def attribute(self, element: _Element, name: str, default: str | None = None) -> str:
        value = element.attributes.get(name, default)
        if value is None:
            raise self.malformed(element.line, f"<{element.name}> has no attribute {name!r}")
        return value

    def number(self, element: _Element, text: str) -> float:
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            raise self.malformed(element.line, f"expected a finite number, got {text[:40]!r}")
        return value

    def children(self, element: _Element, *names: str) -> list[_Element]:
        """Return the children, which must have one of some names."""
        for child in element.children:
            if child.name not in names:
                wanted = " or ".join(f"<{name}>" for name in names)
                raise self.malformed(
                    child.line, f"expected {wanted} in <{element.name}>, got <{child.name}>"
                )
        return element.children

    def only(self, element: _Element, *names: str) -> _Element:
        children = self.children(element, *names)
        if len(children) != 1:
            wanted = " or ".join(f"<{name}>" for name in names)
            raise self.malformed(
                element.line, f"expected one {wanted} in <{element.name}>, got {len(children)}"
            )
        return children[0]

    def choice(self, element: _Element, attribute: str, default: str, known: dict[str, str]) -> str:
        name = self.attribute(element, attribute, default)
        if name not in known:
            raise self.refused(
                element.line, f"{attribute}={name!r}", f"known are {', '.join(known)}"
            )
        return known[name]

    def system(self, text: str) -> FuzzySystem:
        root = self._root(text)
        if root.name != "fuzzySystem":
            raise self.malformed(root.line, f"expected <fuzzySystem>, got <{root.name}>")
        known = ("knowledgeBase", "mamdaniRuleBase", "tskRuleBase", *_OTHER_RULE_BASES)
        parts = self.children(root, *known)
        bases = [part for part in parts if part.name == "knowledgeBase"]
        rule_bases = [part for part in parts if part.name != "knowledgeBase"]
        if len(bases) != 1:
            raise self.malformed(root.line, f"expected one <knowledgeBase>, got {len(bases)}")
        if not rule_bases:
            raise self.malformed(root.line, "there is no rule base")
        for other in rule_bases:
            if other.name in _OTHER_RULE_BASES:
                raise self.refused(
                    other.line, f"<{other.name}>", "rule bases are of Mamdani or TSK"
                )
        if len(rule_bases) > 1:
            raise self.refused(rule_bases[1].line, "a second rule base", "a system has one")
        rule_base = rule_bases[0]
        mamdani = rule_base.name == "mamdaniRuleBase"
        variables = [(element, *self._variable(element, mamdani)) for element in bases[0].children]
        inputs = tuple(variable for _, variable, is_output in variables if not is_output)
        outputs = tuple(variable for _, variable, is_output in variables if is_output)
        names = [variable.name for _, variable, _ in variables]
        for i, (element, variable, _) in enumerate(variables):
            if variable.name in names[:i]:
                raise self.malformed(
                    element.line, f"the name {variable.name!r} is given to two variables"
                )
        if not inputs or not outputs:
            raise self.malformed(bases[0].line, "a system needs at least one input and one output")
        for element, variable, is_output in variables:
            self._check_functions(element, variable, is_output, len(inputs))
        t_norm = self.choice(rule_base, "andMethod", "MIN", _T_NORMS)
        if mamdani and self.choice(rule_base, "activationMethod", "MIN", _T_NORMS) != t_norm:
            raise self.refused(
                rule_base.line,
                "another activationMethod than andMethod",
                "a system has one t-norm for both",
            )
        aggregations = {
            self.choice(element, "accumulation", "MAX", _T_CONORMS): element
            for element, _, is_output in variables
            if is_output and mamdani
        }
        if len(aggregations) > 1:
            raise self.refused(
                list(aggregations.values())[1].line,
                "another accumulation",
                "a system has one for all outputs",
            )
        aggregation = next(iter(aggregations), "max")
        rules = self._rules(rule_base, inputs, outputs, t_norm, mamdani and aggregation == "max")
        try:
            options = {} if mamdani else {"output_ranges": None}
            return system_of(
                Description(inputs, outputs, rules, t_norm, mamdani, aggregation, options=options)
            )
        except Fuzzy2Error as error:
            raise self.malformed(root.line, str(error)) from error

    def _variable(self, element: _Element, mamdani: bool) -> tuple[Variable, bool]:
        """Return a variable, and whether it is an output."""
        if element.name in _OTHER_VARIABLES:
            raise self.refused(
                element.line, f"<{element.name}>", "variables are fuzzy, or outputs of TSK"
            )
        name = self.attribute(element, "name")
        if element.name == "tskVariable":
            if mamdani:
                raise self.malformed(element.line, "a Mamdani rule base has no <tskVariable>")
            combination = self.attribute(element, "combination", "WA")
            if combination != "WA":
                raise self.refused(
                    element.line,
                    f"combination={combination!r}",
                    "known is WA, the weighted average",
                )
            return Variable(name, (0.0, 1.0), self._terms(element, "tskTerm", self._function)), True
        if element.name != "fuzzyVariable":
            raise self.malformed(
                element.line, f"expected <fuzzyVariable> or <tskVariable>, got <{element.name}>"
            )
        kind = self.attribute(element, "type", "input").lower()
        if kind not in ("input", "output"):
            raise self.malformed(element.line, f"expected the type input or output, got {kind!r}")
        if kind == "output":
            if not mamdani:
                raise self.malformed(
                    element.line, "an output of a TSK rule base is a <tskVariable>"
                )
            defuzzifier = self.attribute(element, "defuzzifier", "COG")
            if defuzzifier != "COG":
                raise self.refused(
                    element.line,
                    f"defuzzifier={defuzzifier!r}",
                    "known is COG, the center of gravity",
                )
        low, high = (
            self.number(element, self.attribute(element, key))
            for key in ("domainleft", "domainright")
        )
        if not low < high:
            raise self.malformed(
                element.line, f"expected domainleft below domainright, got {low} and {high}"
            )
        terms = self._terms(element, "fuzzyTerm", lambda term: self._set(term, (low, high)))
        return Variable(name, (low, high), terms), kind == "output"

    def _terms(
        self, element: _Element, kind: str, read: Callable[[_Element], Any]
    ) -> dict[str, Any]:
        terms: dict[str, Any] = {}
        for child in self.children(element, kind):
            name = self.attribute(child, "name")
            if name in terms:
                raise self.malformed(child.line, f"the name {name!r} is given to two terms")
            terms[name] = read(child)
        if not terms:
            raise self.malformed(
                element.line, f"expected at least one <{kind}> in <{element.name}>"
            )
        return terms

    def _function(self, element: _Element) -> Constant | LinearFunction:
        values = [
            self.number(child, child.text.strip()) for child in self.children(element, "tskValue")
        ]
        order = self.attribute(element, "order")
        if order == "0" and len(values) == 1:
            return Constant(values[0], values[0])
        if order == "1" and len(values) > 1:
            return LinearFunction(values[0], tuple(values[1:]))
        raise self.malformed(
            element.line,
            f"expected one value of order 0, or several of order 1, got {len(values)} of order "
            f"{order!r}",
        )

    def _check_functions(
        self, element: _Element, variable: Variable, is_output: bool, inputs: int
    ) -> None:
        for term in variable.terms.values() if is_output else ():
            if isinstance(term, LinearFunction) and len(term.slopes) != inputs:
                reason = (
                    f"expected the constant and a slope for each of the {inputs} inputs, got "
                    f"{len(term.slopes) + 1} values"
                )
                raise self.malformed(element.line, reason)

    def _set(self, element: _Element, domain: tuple[float, float]) -> Type1Set:
        negation = self.attribute(element, "complement", "false")
        if negation.lower() not in ("true", "false"):
            raise self.malformed(
                element.line, f"expected complement true or false, got {negation!r}"
            )
        shape = self.only(element, *_SHAPES, "pointSetShape", *_SHAPES_WITHOUT_CLASS)
        if shape.name in _SHAPES_WITHOUT_CLASS:
            raise self.refused(shape.line, f"<{shape.name}>", "no class here has its shape")
        one = self._shape(shape, domain)
        return Complement(one) if negation.lower() == "true" else one

    def _shape(self, shape: _Element, domain: tuple[float, float]) -> Type1Set:
        try:
            if shape.name == "pointSetShape":
                return self._points(shape, domain)
            count, make = _SHAPES[shape.name]
            return make(
                *(self.number(shape, self.attribute(shape, f"param{i + 1}")) for i in range(count))
            )
        except (MalformedFile, NotExpressible):
            raise
        except Fuzzy2Error as error:
            raise self.malformed(shape.line, f"{shape.name}: {error}") from error

    def _points(self, shape: _Element, domain: tuple[float, float]) -> SampledSet:
        method = self.attribute(shape, "interpolationMethod", "linear")
        if method != "linear":
            raise self.refused(
                shape.line, f"interpolationMethod={method!r}", "points are interpolated linearly"
            )
        pairs = sorted(
            (self.number(p, self.attribute(p, "x")), self.number(p, self.attribute(p, "y")))
            for p in self.children(shape, "point")
        )
        if not pairs:
            raise self.malformed(shape.line, "expected at least one <point>")
        # Beyond its points such a shape keeps the first and the last grade, a sampled set has the
        # grade 0.
        if pairs[0][0] > domain[0] and pairs[0][1] != 0.0:
            pairs.insert(0, (domain[0], pairs[0][1]))
        if pairs[-1][0] < domain[1] and pairs[-1][1] != 0.0:
            pairs.append((domain[1], pairs[-1][1]))
        return SampledSet([x for x, _ in pairs], [y for _, y in pairs])

    def _rules(
        self,
        rule_base: _Element,
        inputs: tuple[Variable, ...],
        outputs: tuple[Variable, ...],
        t_norm: str,
        splits: bool,
    ) -> tuple[tuple[tuple[int, ...], tuple[int, ...]], ...]:
        mamdani = rule_base.name == "mamdaniRuleBase"
        rules = []
        # A negation adds a term to its variable, which the document does not know.
        known_inputs, known_outputs = (
            [list(variable.terms) for variable in variables] for variables in (inputs, outputs)
        )
        for rule in self.children(rule_base, "rule" if mamdani else "tskRule"):
            then, consequent, clause = (
                ("then", "consequent", "clause")
                if mamdani
                else ("tskThen", "tskConsequent", "tskClause")
            )
            parts = {part.name: part for part in self.children(rule, "antecedent", consequent)}
            if len(parts) != 2 or len(rule.children) != 2:
                raise self.malformed(rule.line, f"expected one <antecedent> and one <{consequent}>")
            weight = self.number(rule, self.attribute(rule, "weight", "1.0"))
            if weight != 1.0:
                raise self.refused(rule.line, f"the weight {weight:g}", "rules have no weights")
            for branch in parts[consequent].children:
                if branch.name in ("else", "tskElse"):
                    raise self.refused(
                        branch.line,
                        f"<{branch.name}>",
                        "a rule says nothing where it does not fire",
                    )
            asked = self._clauses(parts["antecedent"], "clause", inputs, known_inputs, "input")
            said = self._clauses(
                self.only(parts[consequent], then), clause, outputs, known_outputs, "output"
            )
            if min(said) < 0:
                silent = outputs[said.index(-1)].name
                raise self.refused(
                    rule.line,
                    f"a rule that says nothing about {silent}",
                    "each rule gives every output a term",
                )
            if max(asked) < 0:
                raise self.malformed(rule.line, "the rule asks for nothing")
            connector = self.attribute(rule, "connector", "and").lower()
            if connector not in ("and", "or"):
                raise self.malformed(
                    rule.line, f"expected the connector and or or, got {connector!r}"
                )
            if sum(term >= 0 for term in asked) == 1:
                rules.append((asked, said))
            elif connector == "and":
                own = self.choice(rule, "andMethod", "", {**_T_NORMS, "": t_norm})
                if own != t_norm:
                    raise self.refused(
                        rule.line,
                        "another andMethod than that of the rule base",
                        "a system has one t-norm",
                    )
                rules.append((asked, said))
            else:
                if (
                    not splits
                    or self.attribute(
                        rule, "orMethod", self.attribute(rule_base, "orMethod", "MAX")
                    )
                    != "MAX"
                ):
                    reason = (
                        "only in a Mamdani rule base with orMethod and accumulation MAX it is "
                        "the same as one rule for each alternative"
                    )
                    raise self.refused(rule.line, "a rule with or", reason)
                rules += [(alternative, said) for alternative in alternatives(asked)]
        if not rules:
            raise self.malformed(rule_base.line, "there are no rules")
        return tuple(rules)

    def _clauses(
        self,
        element: _Element,
        kind: str,
        variables: tuple[Variable, ...],
        known: list[list[str]],
        role: str,
    ) -> tuple[int, ...]:
        places = {variable.name: place for place, variable in enumerate(variables)}
        numbers = [-1] * len(variables)
        for clause in self.children(element, kind):
            modifier = clause.attributes.get("modifier")
            if modifier not in (None, "not"):
                raise self.refused(
                    clause.line,
                    f"the modifier {modifier!r}",
                    "known is not; make what it means a term of its own",
                )
            named = {child.name: child for child in self.children(clause, "variable", "term")}
            if len(named) != 2 or len(clause.children) != 2:
                raise self.malformed(clause.line, "expected one <variable> and one <term>")
            variable = self._named(named["variable"], places, role)
            place = places[variable]
            if numbers[place] >= 0:
                raise self.refused(
                    clause.line,
                    f"two clauses about {variable!r}",
                    "a rule asks once about each variable",
                )
            name = self._named(named["term"], known[place], f"term of {variable!r}")
            number = known[place].index(name)
            if modifier is not None:
                if isinstance(variables[place].terms[name], Constant | LinearFunction):
                    raise self.refused(
                        clause.line,
                        "the modifier 'not' of a function",
                        "only sets have a complement",
                    )
                number = negated(variables[place], number)
            numbers[place] = number
        return tuple(numbers)

    def _named(self, element: _Element, known: Iterable[str], kind: str) -> str:
        for name in (element.text, element.text.strip()):
            if name in known:
                return name
        suggestion = nearest_name(name, known)
        raise self.malformed(
            element.line,
            f"unknown {kind} {name!r}{f'; did you mean {suggestion!r}?' if suggestion else ''}",
        )


def _written(description: Description, name: str) -> ElementTree.Element:
    if description.type2:
        _refuse("an interval type-2 system", "the standard has type-1 sets only; use JSON or .fis")
    if description.aggregation == SUM:
        _refuse("center of sums", "its accumulation unites; use .fis, or the reducer centroid")
    check_names(description, "FML")
    names = [variable.name for variable in (*description.inputs, *description.outputs)]
    if len(set(names)) < len(names):
        _refuse("an input and an output of one name", "variables are known by their names")
    root = ElementTree.Element("fuzzySystem", {"xmlns": NAMESPACE, "name": name})
    base = ElementTree.SubElement(root, "knowledgeBase")
    for variable in description.inputs:
        _write_fuzzy_variable(base, variable, {"type": "input"})
    for variable in description.outputs:
        if description.mamdani:
            accumulation = _known_as(description.aggregation, _T_CONORMS)
            attributes = {
                "type": "output",
                "accumulation": accumulation,
                "defuzzifier": "COG",
                "defaultValue": "NaN",
            }
            _write_fuzzy_variable(base, variable, attributes)
        else:
            _write_functions(base, variable, len(description.inputs))
    _write_rules(root, description)
    return root


def _refuse(what: str, reason: str) -> NoReturn:
    raise NotExpressible(what, "FML", reason)


def _write_fuzzy_variable(
    base: ElementTree.Element, variable: Variable, attributes: dict[str, str]
) -> None:
    low, high = variable.range
    ends = {
        "domainleft": _number(low),
        "domainright": _number(high if low < high else low + max(1.0, 0.5 * abs(low))),
    }
    element = ElementTree.SubElement(
        base, "fuzzyVariable", {"name": variable.name, **ends, **attributes}
    )
    for name, term in variable.terms.items():
        _write_set(
            ElementTree.SubElement(element, "fuzzyTerm", {"name": name}), term, variable.range
        )


def _write_set(element: ElementTree.Element, term: Type1Set, domain: tuple[float, float]) -> None:
    if isinstance(term, Complement):
        element.set("complement", "true")
        term = term.whole
    if isinstance(term, SampledSet):
        low, high = float(term.points[0]), float(term.points[-1])
        if (term.grades[0] > 0.0 and low > domain[0]) or (
            term.grades[-1] > 0.0 and high < domain[1]
        ):
            _refuse(
                f"{term!r}",
                "beyond its points it would keep their grade there; let its first and last grade "
                "be 0",
            )
        shape = ElementTree.SubElement(element, "pointSetShape", {"interpolationMethod": "linear"})
        for x, y in zip(term.points.tolist(), term.grades.tolist(), strict=True):
            ElementTree.SubElement(shape, "point", {"x": _number(x), "y": _number(y)})
        return
    kind, parameters = _shape(term)
    ElementTree.SubElement(
        element, kind, {f"param{i + 1}": _number(value) for i, value in enumerate(parameters)}
    )


def _shape(term: Type1Set) -> tuple[str, tuple[float, ...]]:
    if term.height != 1.0:
        _refuse(f"{term!r}", "its membership functions reach 1")
    if isinstance(term, Triangular):
        return "triangularShape", (term.left, term.peak, term.right)
    if isinstance(term, Gaussian):
        return "gaussianShape", (term.mean, term.sigma)
    if isinstance(term, Interval):
        return "rectangularShape", (term.left, term.right)
    if isinstance(term, Singleton):
        return "singletonShape", (term.point,)
    if isinstance(term, Trapezoidal):
        if math.isfinite(term.a) and math.isfinite(term.d):
            return "trapezoidShape", (term.a, term.b, term.c, term.d)
        if math.isfinite(term.a):
            return "rightLinearShape", (term.a, term.b)
        if math.isfinite(term.d):
            return "leftLinearShape", (term.c, term.d)
    if isinstance(term, TwoSidedGaussian):
        if math.isinf(term.sigma[0]):
            return "leftGaussianShape", (term.mean[1], term.sigma[1])
        if math.isinf(term.sigma[1]):
            return "rightGaussianShape", (term.mean[0], term.sigma[0])
    if isinstance(term, PiShaped):
        if math.isinf(term.d) and math.isfinite(term.a):
            return "sShape", (term.a, term.b)
        if math.isinf(term.a) and math.isfinite(term.d):
            return "zShape", (term.c, term.d)
        if term.b == term.c and term.d == term.b + (term.b - term.a):
            return "piShape", (term.a, term.b)
    _refuse(f"{term!r}", "it has no such shape; sample it first")


def _write_functions(base: ElementTree.Element, variable: Variable, inputs: int) -> None:
    attributes = {
        "name": variable.name,
        "type": "output",
        "combination": "WA",
        "defaultValue": "NaN",
    }
    element = ElementTree.SubElement(base, "tskVariable", attributes)
    for name, term in variable.terms.items():
        if isinstance(term, Constant) and term.left != term.right:
            _refuse(f"the interval {list(term)} as a consequent", "its constants are crisp")
        order, values = (
            ("1", (term.constant, *term.slopes))
            if isinstance(term, LinearFunction)
            else ("0", (term.left,))
        )
        written = ElementTree.SubElement(element, "tskTerm", {"name": name, "order": order})
        for value in values:
            ElementTree.SubElement(written, "tskValue").text = _number(value)


def _write_rules(root: ElementTree.Element, description: Description) -> None:
    mamdani, t_norm = description.mamdani, _known_as(description.t_norm, _T_NORMS)
    base_name, rule_name = ("mamdaniRuleBase", "rule") if mamdani else ("tskRuleBase", "tskRule")
    consequent_name, then_name, clause_name = (
        ("consequent", "then", "clause") if mamdani else ("tskConsequent", "tskThen", "tskClause")
    )
    methods = {"activationMethod": t_norm, "andMethod": t_norm, "orMethod": "MAX"}
    base = ElementTree.SubElement(root, base_name, {"name": "rules", **methods})
    for number, (asked, said) in enumerate(description.rules, start=1):
        if max(asked) < 0:
            _refuse("a rule that asks for nothing", "a rule has at least one clause")
        # A rule's own andMethod is MIN if it does not say so.
        rule = ElementTree.SubElement(
            base, rule_name, {"name": f"rule{number}", "andMethod": t_norm, "connector": "and"}
        )
        _write_clauses(
            ElementTree.SubElement(rule, "antecedent"), "clause", description.inputs, asked
        )
        consequent = ElementTree.SubElement(rule, consequent_name)
        _write_clauses(
            ElementTree.SubElement(consequent, then_name), clause_name, description.outputs, said
        )


def _write_clauses(
    parent: ElementTree.Element,
    kind: str,
    variables: tuple[Variable, ...],
    numbers: tuple[int, ...],
) -> None:
    for variable, number in zip(variables, numbers, strict=True):
        if number >= 0:
            clause = ElementTree.SubElement(parent, kind)
            ElementTree.SubElement(clause, "variable").text = variable.name
            ElementTree.SubElement(clause, "term").text = list(variable.terms)[number]


def _known_as(name: str, known: dict[str, str]) -> str:
    return next(theirs for theirs, ours in known.items() if ours == name)


def _number(value: float) -> str:
    # The digits that give back the same float.
    return repr(float(value))
