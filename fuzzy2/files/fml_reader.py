"""Reader of an FML document, which makes a description."""

from __future__ import annotations

import math
import re
from typing import Any

from fuzzy2.errors import Fuzzy2Error, MalformedFile, NotExpressible
from fuzzy2.files.description import Description, LinearFunction, Variable, system_of
from fuzzy2.files.fml_elements import Element, FmlElements
from fuzzy2.files.fml_names import (
    DEFUZZIFIERS,
    FIRING,
    RULE_BASES,
    SAMPLE_POINTS,
    T_CONORMS,
    T_NORMS,
)
from fuzzy2.files.fml_rules import FmlRules
from fuzzy2.files.fml_terms import FmlTerms
from fuzzy2.sets.type1 import Singleton
from fuzzy2.systems.anya import AnYaSystem
from fuzzy2.systems.operators import INTEGRATIONS
from fuzzy2.systems.system import FuzzySystem

_OUTPUTS = {"mamdani": "fuzzyVariable", "tsk": "tskVariable", "tsukamoto": "tsukamotoVariable"}


class FmlReader(FmlElements):
    """Reader of one document, which makes elements and then a description."""

    def system(self, text: str) -> FuzzySystem | AnYaSystem:
        """Return the system that the document describes."""
        root = self.root(text)
        base, rule_base = self._bases(root)
        of_clouds = RULE_BASES[rule_base.name] == "anya"
        kind = self._said_by(base) if of_clouds else RULE_BASES[rule_base.name]
        elements = [one for one in base.children if one.name != "aggregatedFuzzyVariable"]
        variables = [(element, *self._variable(element, kind, of_clouds)) for element in elements]
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
            self._check_functions(element, variable, is_output, None if of_clouds else len(inputs))
        of_outputs = [element for element, _, is_output in variables if is_output]
        operators = self._operators(rule_base, kind, of_outputs, outputs)
        rules = FmlRules(self, rule_base, inputs, outputs)
        for element in base.children:
            if element.name == "aggregatedFuzzyVariable":
                rules.aggregate(element)
        found = rules.rules()
        t_norm, disjunction = rules.operators()
        clouds = [self._cloud(one) for one in elements if one.name == "anYaDataCloud"]
        names = [variable.name for variable in inputs]
        if of_clouds:
            inputs = tuple(
                Variable(f"rule{i + 1}", (0.0, 1.0), {"fires": FIRING})
                for i in range(len(rules.clouds))
            )
        try:
            system = system_of(
                Description(
                    inputs,
                    outputs,
                    found,
                    t_norm,
                    kind != "tsk",
                    disjunction=disjunction,
                    **operators,
                )
            )
            return AnYaSystem(clouds, rules.clouds, system, names) if of_clouds else system
        except (MalformedFile, NotExpressible):
            raise
        except Fuzzy2Error as error:
            raise self.malformed(root.line, str(error)) from error

    def _bases(self, root: Element) -> tuple[Element, Element]:
        """Return the knowledge base and the rule base; a document must have one of each."""
        if root.name != "fuzzySystem":
            raise self.malformed(root.line, f"expected <fuzzySystem>, got <{root.name}>")
        parts = self.children(root, "knowledgeBase", *RULE_BASES)
        bases = [part for part in parts if part.name == "knowledgeBase"]
        rule_bases = [part for part in parts if part.name != "knowledgeBase"]
        if len(bases) != 1:
            raise self.malformed(root.line, f"expected one <knowledgeBase>, got {len(bases)}")
        if not rule_bases:
            raise self.malformed(root.line, "there is no rule base")
        if len(rule_bases) > 1:
            raise self.refused(rule_bases[1].line, "a second rule base", "a system has one")
        return bases[0], rule_bases[0]

    def _said_by(self, base: Element) -> str:
        """Return the kind of rule base that has the same consequents as an AnYa rule base."""
        found = {
            kind: variable.line
            for kind, name in _OUTPUTS.items()
            for variable in base.children
            if variable.name == name
        }
        if len(found) > 1:
            reason = "consequents of clouds are sets, numbers or sets of Tsukamoto; take one kind"
            raise self.refused(max(found.values()), "outputs of several kinds", reason)
        return next(iter(found), "mamdani")

    def _operators(
        self, rule_base: Element, kind: str, elements: list[Element], outputs: tuple[Variable, ...]
    ) -> dict[str, Any]:
        """Return the operators of a system, which must be the same for all its outputs."""
        if kind == "tsk":
            return {"options": {"output_ranges": None}}
        if kind == "tsukamoto":
            return {"reduction": "tsukamoto"}
        implication = self.choice(rule_base, "activationMethod", "MIN", T_NORMS)
        aggregation = self._common(elements, "accumulation", "MAX", T_CONORMS)
        reduction = self._common(elements, "defuzzifier", "COG", DEFUZZIFIERS)
        # Singletons between the points of a sum would be missed.
        narrow = any(isinstance(one, Singleton) for of in outputs for one in of.terms.values())
        return {
            "implication": implication,
            "aggregation": aggregation,
            "reduction": reduction,
            **self._integration("exact" if narrow or reduction != "centroid" else "sum"),
        }

    def _integration(self, default: str) -> dict[str, Any]:
        """Return how centroids are computed, as a document of this package says, or by default."""
        integration = self.own.get("integration", default)
        points = self.own.get("resolution", str(SAMPLE_POINTS))
        if integration not in INTEGRATIONS or not re.fullmatch(r"[0-9]{1,6}", points):
            raise self.malformed(
                1, f"expected an integration and points, got {integration!r} and {points!r}"
            )
        return {"integration": integration, "resolution": int(points)}

    def _common(
        self, elements: list[Element], attribute: str, default: str, known: dict[str, str]
    ) -> str:
        found = {self.choice(element, attribute, default, known): element for element in elements}
        if len(found) > 1:
            raise self.refused(
                list(found.values())[1].line,
                f"another {attribute}",
                "a system has one for all outputs; take the same, or a document for each",
            )
        return next(iter(found))

    def _variable(self, element: Element, kind: str, of_clouds: bool) -> tuple[Variable, bool]:
        """Return a variable, and whether it is an output."""
        if element.name == "anYaDataCloud" and not of_clouds:
            raise self.refused(
                element.line, f"<{element.name}>", "only an <anYaRuleBase> uses clouds"
            )
        name = self.attribute(element, "name")
        if element.name == "anYaDataCloud":
            return Variable(name, (0.0, 1.0), {}), False
        if element.name in ("tskVariable", "tsukamotoVariable"):
            if element.name != _OUTPUTS[kind]:
                base = "Mamdani" if kind == "mamdani" else kind
                raise self.malformed(element.line, f"a {base} rule base has no <{element.name}>")
            combination = self.attribute(element, "combination", "WA")
            if combination.upper() != "WA":
                raise self.refused(
                    element.line,
                    f"combination={combination!r}",
                    "known is WA, the weighted average",
                )
            if kind == "tsk":
                terms = FmlTerms(self).functions(element)
                return Variable(name, (0.0, 1.0), terms, self._default(element)), True
            ends = self._ends(element)
            terms = FmlTerms(self).sets(element, "tsukamotoTerm", ends)
            return Variable(name, ends, terms, self._default(element)), True
        if element.name != "fuzzyVariable":
            raise self.malformed(
                element.line, f"expected <fuzzyVariable> or <tskVariable>, got <{element.name}>"
            )
        role = self.attribute(element, "type", "input").lower()
        if role not in ("input", "output"):
            raise self.malformed(element.line, f"expected the type input or output, got {role!r}")
        if role == "input" and of_clouds:
            raise self.malformed(
                element.line, "an input of an AnYa rule base is an <anYaDataCloud>"
            )
        if role == "output" and kind != "mamdani":
            base = "TSK" if kind == "tsk" else "Tsukamoto"
            raise self.malformed(
                element.line, f"an output of a {base} rule base is a <{_OUTPUTS[kind]}>"
            )
        ends = self._ends(element)
        terms = FmlTerms(self).sets(element, "fuzzyTerm", ends)
        default = self._default(element) if role == "output" else None
        return Variable(name, ends, terms, default), role == "output"

    def _cloud(self, element: Element) -> list[float]:
        """Return the data of a cloud."""
        data = [self.number(one, one.text.strip()) for one in self.children(element, "datum")]
        if not data:
            raise self.malformed(element.line, "expected at least one <datum>")
        return data

    def _ends(self, element: Element) -> tuple[float, float]:
        low, high = (
            self.number(element, self.attribute(element, key))
            for key in ("domainleft", "domainright")
        )
        if not low < high:
            raise self.malformed(
                element.line, f"expected domainleft below domainright, got {low} and {high}"
            )
        return low, high

    def _default(self, element: Element) -> float | None:
        """Return the output where no rule fires; the schema's default is 0, and NaN gives None."""
        text = self.attribute(element, "defaultValue", "0").strip()
        if text.lower() == "nan":
            return None
        value = self.number(element, text)
        return value if math.isfinite(value) else None

    def _check_functions(
        self, element: Element, variable: Variable, is_output: bool, inputs: int | None
    ) -> None:
        """Refuse functions with a wrong number of inputs; clouds allow none (None)."""
        for term in variable.terms.values() if is_output else ():
            if isinstance(term, LinearFunction) and inputs is None:
                reason = "rules of clouds say numbers or sets; take order 0"
                raise self.refused(element.line, f"functions of {variable.name!r}", reason)
            if isinstance(term, LinearFunction) and len(term.slopes) != inputs:
                reason = (
                    f"expected the constant and a slope for each of the {inputs} inputs, got "
                    f"{len(term.slopes) + 1} values"
                )
                raise self.malformed(element.line, reason)
