"""An FML document, read into a description."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import Any
from xml.parsers import expat

from fuzzy2.errors import Fuzzy2Error, MalformedFile, NotExpressible
from fuzzy2.files.description import (
    Constant,
    DescribedRule,
    Description,
    LinearFunction,
    Variable,
    negated,
    system_of,
)
from fuzzy2.files.fml_names import NAMESPACE, SHAPES, T_CONORMS, T_NORMS
from fuzzy2.files.source import Source
from fuzzy2.sets.derived import Complement
from fuzzy2.sets.type1 import SampledSet, Type1Set
from fuzzy2.systems.antecedents import And, Is, Or
from fuzzy2.systems.rules import unknown_name
from fuzzy2.systems.system import FuzzySystem

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


class FmlReader(Source):
    """One document, read into elements and then into a description."""

    def _root(self, text: str) -> _Element:
        # The text is decoded already, so what it declares of its encoding is past.
        parser = expat.ParserCreate("utf-8", namespace_separator="}")
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

    def _attribute(self, element: _Element, name: str, default: str | None = None) -> str:
        value = element.attributes.get(name, default)
        if value is None:
            raise self.malformed(element.line, f"<{element.name}> has no attribute {name!r}")
        return value

    def _number(self, element: _Element, text: str) -> float:
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            raise self.malformed(element.line, f"expected a finite number, got {text[:40]!r}")
        return value

    def _children(self, element: _Element, *names: str) -> list[_Element]:
        """Return the children, which must have one of some names."""
        for child in element.children:
            if child.name not in names:
                wanted = " or ".join(f"<{name}>" for name in names)
                raise self.malformed(
                    child.line, f"expected {wanted} in <{element.name}>, got <{child.name}>"
                )
        return element.children

    def _only(self, element: _Element, *names: str) -> _Element:
        children = self._children(element, *names)
        if len(children) != 1:
            wanted = " or ".join(f"<{name}>" for name in names)
            raise self.malformed(
                element.line, f"expected one {wanted} in <{element.name}>, got {len(children)}"
            )
        return children[0]

    def _choice(
        self, element: _Element, attribute: str, default: str, known: dict[str, str]
    ) -> str:
        name = self._attribute(element, attribute, default)
        if name not in known:
            raise self.refused(
                element.line, f"{attribute}={name!r}", f"known are {', '.join(known)}"
            )
        return known[name]

    def system(self, text: str) -> FuzzySystem:
        """Return the system that the document describes."""
        root = self._root(text)
        base, rule_base = self._bases(root)
        mamdani = rule_base.name == "mamdaniRuleBase"
        variables = [(element, *self._variable(element, mamdani)) for element in base.children]
        inputs = tuple(variable for _, variable, is_output in variables if not is_output)
        outputs = tuple(variable for _, variable, is_output in variables if is_output)
        names = [variable.name for _, variable, _ in variables]
        for i, (element, variable, _) in enumerate(variables):
            if variable.name in names[:i]:
                raise self.malformed(
                    element.line, f"the name {variable.name!r} is given to two variables"
                )
        if not inputs or not outputs:
            raise self.malformed(base.line, "a system needs at least one input and one output")
        for element, variable, is_output in variables:
            self._check_functions(element, variable, is_output, len(inputs))
        t_norm = self._t_norm(rule_base, mamdani)
        of_sets = [element for element, _, is_output in variables if is_output and mamdani]
        aggregation = self._aggregation(of_sets)
        rules = self._rules(rule_base, inputs, outputs, t_norm, mamdani and aggregation == "max")
        try:
            options = {} if mamdani else {"output_ranges": None}
            return system_of(
                Description(inputs, outputs, rules, t_norm, mamdani, aggregation, options=options)
            )
        except Fuzzy2Error as error:
            raise self.malformed(root.line, str(error)) from error

    def _bases(self, root: _Element) -> tuple[_Element, _Element]:
        """Return the knowledge base and the rule base, one of each."""
        if root.name != "fuzzySystem":
            raise self.malformed(root.line, f"expected <fuzzySystem>, got <{root.name}>")
        known = ("knowledgeBase", "mamdaniRuleBase", "tskRuleBase", *_OTHER_RULE_BASES)
        parts = self._children(root, *known)
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
        return bases[0], rule_bases[0]

    def _t_norm(self, rule_base: _Element, mamdani: bool) -> str:
        t_norm = self._choice(rule_base, "andMethod", "MIN", T_NORMS)
        if mamdani and self._choice(rule_base, "activationMethod", "MIN", T_NORMS) != t_norm:
            raise self.refused(
                rule_base.line,
                "another activationMethod than andMethod",
                "a system has one t-norm for both",
            )
        return t_norm

    def _aggregation(self, outputs: list[_Element]) -> str:
        """Return the t-conorm that unites what rules say of every output."""
        aggregations = {
            self._choice(element, "accumulation", "MAX", T_CONORMS): element for element in outputs
        }
        if len(aggregations) > 1:
            raise self.refused(
                list(aggregations.values())[1].line,
                "another accumulation",
                "a system has one for all outputs",
            )
        return next(iter(aggregations), "max")

    def _variable(self, element: _Element, mamdani: bool) -> tuple[Variable, bool]:
        """Return a variable, and whether it is an output."""
        if element.name in _OTHER_VARIABLES:
            raise self.refused(
                element.line, f"<{element.name}>", "variables are fuzzy, or outputs of TSK"
            )
        name = self._attribute(element, "name")
        if element.name == "tskVariable":
            if mamdani:
                raise self.malformed(element.line, "a Mamdani rule base has no <tskVariable>")
            combination = self._attribute(element, "combination", "WA")
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
        kind = self._attribute(element, "type", "input").lower()
        if kind not in ("input", "output"):
            raise self.malformed(element.line, f"expected the type input or output, got {kind!r}")
        if kind == "output":
            if not mamdani:
                raise self.malformed(
                    element.line, "an output of a TSK rule base is a <tskVariable>"
                )
            defuzzifier = self._attribute(element, "defuzzifier", "COG")
            if defuzzifier != "COG":
                raise self.refused(
                    element.line,
                    f"defuzzifier={defuzzifier!r}",
                    "known is COG, the center of gravity",
                )
        low, high = (
            self._number(element, self._attribute(element, key))
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
        for child in self._children(element, kind):
            name = self._attribute(child, "name")
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
            self._number(child, child.text.strip()) for child in self._children(element, "tskValue")
        ]
        order = self._attribute(element, "order")
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
        negation = self._attribute(element, "complement", "false")
        if negation.lower() not in ("true", "false"):
            raise self.malformed(
                element.line, f"expected complement true or false, got {negation!r}"
            )
        shape = self._only(element, *SHAPES, "pointSetShape", *_SHAPES_WITHOUT_CLASS)
        if shape.name in _SHAPES_WITHOUT_CLASS:
            raise self.refused(shape.line, f"<{shape.name}>", "no class here has its shape")
        one = self._shape(shape, domain)
        return Complement(one) if negation.lower() == "true" else one

    def _shape(self, shape: _Element, domain: tuple[float, float]) -> Type1Set:
        try:
            if shape.name == "pointSetShape":
                return self._points(shape, domain)
            count, make = SHAPES[shape.name]
            return make(
                *(
                    self._number(shape, self._attribute(shape, f"param{i + 1}"))
                    for i in range(count)
                )
            )
        except (MalformedFile, NotExpressible):
            raise
        except Fuzzy2Error as error:
            raise self.malformed(shape.line, f"{shape.name}: {error}") from error

    def _points(self, shape: _Element, domain: tuple[float, float]) -> SampledSet:
        method = self._attribute(shape, "interpolationMethod", "linear")
        if method != "linear":
            raise self.refused(
                shape.line, f"interpolationMethod={method!r}", "points are interpolated linearly"
            )
        pairs = sorted(
            (self._number(p, self._attribute(p, "x")), self._number(p, self._attribute(p, "y")))
            for p in self._children(shape, "point")
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
    ) -> tuple[DescribedRule, ...]:
        mamdani = rule_base.name == "mamdaniRuleBase"
        rules = []
        # A negation adds a term to its variable, which the document does not know.
        known_inputs, known_outputs = (
            [list(variable.terms) for variable in variables] for variables in (inputs, outputs)
        )
        then, consequent, clause = (
            ("then", "consequent", "clause")
            if mamdani
            else ("tskThen", "tskConsequent", "tskClause")
        )
        for rule in self._children(rule_base, "rule" if mamdani else "tskRule"):
            antecedent, said_by = self._sides(rule, consequent)
            asked = self._clauses(antecedent, "clause", inputs, known_inputs, "input")
            said = self._clauses(
                self._only(said_by, then), clause, outputs, known_outputs, "output"
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
            or_method = self._attribute(rule_base, "orMethod", "MAX")
            either = self._asks_for_either(rule, asked, t_norm, or_method if splits else "")
            parts = tuple(Is(i, term) for i, term in enumerate(asked) if term >= 0)
            rules.append(DescribedRule(Or(parts) if either else And(parts), said))
        if not rules:
            raise self.malformed(rule_base.line, "there are no rules")
        return tuple(rules)

    def _sides(self, rule: _Element, consequent: str) -> tuple[_Element, _Element]:
        """Return the antecedent and the consequent of a rule without a weight and without else."""
        parts = {part.name: part for part in self._children(rule, "antecedent", consequent)}
        if len(parts) != 2 or len(rule.children) != 2:
            raise self.malformed(rule.line, f"expected one <antecedent> and one <{consequent}>")
        weight = self._number(rule, self._attribute(rule, "weight", "1.0"))
        if weight != 1.0:
            raise self.refused(rule.line, f"the weight {weight:g}", "rules have no weights")
        for branch in parts[consequent].children:
            if branch.name in ("else", "tskElse"):
                raise self.refused(
                    branch.line,
                    f"<{branch.name}>",
                    "a rule says nothing where it does not fire",
                )
        return parts["antecedent"], parts[consequent]

    def _asks_for_either(
        self, rule: _Element, asked: tuple[int, ...], t_norm: str, or_method: str
    ) -> bool:
        """Return whether a rule is one rule for each of its alternatives.

        ``or_method`` is that of the rule base, and empty if such a rule cannot be split.
        """
        connector = self._attribute(rule, "connector", "and").lower()
        if connector not in ("and", "or"):
            raise self.malformed(rule.line, f"expected the connector and or or, got {connector!r}")
        if sum(term >= 0 for term in asked) == 1:
            return False
        if connector == "and":
            own = self._choice(rule, "andMethod", "", {**T_NORMS, "": t_norm})
            if own != t_norm:
                raise self.refused(
                    rule.line,
                    "another andMethod than that of the rule base",
                    "a system has one t-norm",
                )
            return False
        if not or_method or self._attribute(rule, "orMethod", or_method) != "MAX":
            reason = (
                "only in a Mamdani rule base with orMethod and accumulation MAX it is "
                "the same as one rule for each alternative"
            )
            raise self.refused(rule.line, "a rule with or", reason)
        return True

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
        for clause in self._children(element, kind):
            modifier = clause.attributes.get("modifier")
            if modifier not in (None, "not"):
                raise self.refused(
                    clause.line,
                    f"the modifier {modifier!r}",
                    "known is not; make what it means a term of its own",
                )
            named = {child.name: child for child in self._children(clause, "variable", "term")}
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
        raise self.malformed(element.line, unknown_name(kind, name, known))
