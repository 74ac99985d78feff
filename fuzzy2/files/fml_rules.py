"""The rules of an FML document."""

from __future__ import annotations

from fuzzy2.errors import NotExpressible
from fuzzy2.files.description import (
    SILENT,
    Constant,
    DescribedRule,
    LinearFunction,
    Variable,
    negated,
)
from fuzzy2.files.fml_elements import Element, FmlElements
from fuzzy2.files.fml_names import MODIFIERS, T_CONORMS, T_NORMS
from fuzzy2.systems.antecedents import And, Antecedent, Hedged, Is, Not, Or

Names = dict[str, list[str]]
"""Names of the terms of variables."""

_TSK = ("tskRule", "tskConsequent", "tskThen", "tskElse", "tskClause")
_MAMDANI = ("rule", "consequent", "then", "else", "clause")


class FmlRules:
    """The rules of one rule base, with the operators that they use."""

    def __init__(
        self,
        elements: FmlElements,
        base: Element,
        inputs: tuple[Variable, ...],
        outputs: tuple[Variable, ...],
    ) -> None:
        self._elements, self._base = elements, base
        self._inputs, self._outputs = inputs, outputs
        # A negation adds a term to its output, which is not in the document.
        self._known: Names = {
            variable.name: list(variable.terms) for variable in (*inputs, *outputs)
        }
        self._aggregated: dict[str, dict[str, Antecedent]] = {}
        self._both: dict[str, int] = {}
        self._either: dict[str, int] = {}
        self.clouds: list[int] = []
        """Number of the cloud of each rule of an AnYa rule base."""

    def operators(self) -> tuple[str, str]:
        """Return t-norm and t-conorm; all rules are read first, because they must agree on them."""
        found = []
        for used, attribute, default, known in (
            (self._both, "andMethod", "MIN", T_NORMS),
            (self._either, "orMethod", "MAX", T_CONORMS),
        ):
            own = self._elements.choice(self._base, attribute, default, known)
            if len(used) > 1:
                raise self._elements.refused(
                    max(used.values()),
                    f"another {attribute} than that of other rules",
                    "a system has one t-norm and one t-conorm; take the same for all rules",
                )
            found.append(next(iter(used), own))
        return found[0], found[1]

    def aggregate(self, variable: Element) -> None:
        """Add a variable whose terms are made from those of others."""
        elements = self._elements
        terms: dict[str, Antecedent] = {}
        for child in elements.children(variable, "aggregatedFuzzyTerm"):
            (tree,) = self._combined(child, 1)
            name = elements.attribute(child, "name")
            if name in terms:
                raise elements.malformed(child.line, f"the name {name!r} is given to two terms")
            terms[name] = tree
        name = elements.attribute(variable, "name")
        if name in self._aggregated or name in self._known:
            raise elements.malformed(variable.line, f"the name {name!r} is given to two variables")
        self._aggregated[name] = terms

    def _combined(self, element: Element, least: int) -> list[Antecedent]:
        elements, parts = self._elements, list[Antecedent]()
        for child in elements.children(element, "and", "or", "clause"):
            if child.name == "clause":
                parts.append(self._clause(child))
            elif child.name == "and":
                self._use(self._both, elements.choice(child, "t-norm", "MIN", T_NORMS), child)
                parts.append(And(tuple(self._combined(child, 2))))
            else:
                self._use(self._either, elements.choice(child, "t-conorm", "MAX", T_CONORMS), child)
                parts.append(Or(tuple(self._combined(child, 2))))
        if len(parts) < least or (least == 1 and len(parts) != 1):
            wanted = "one" if least == 1 else "two"
            raise elements.malformed(
                element.line, f"expected {wanted} in <{element.name}>, got {len(parts)}"
            )
        return parts

    @staticmethod
    def _use(used: dict[str, int], name: str, element: Element) -> None:
        used.setdefault(name, element.line)

    def rules(self) -> tuple[DescribedRule, ...]:
        """Return the rules; a rule with *else* becomes two."""
        base, elements = self._base, self._elements
        names = _TSK if base.name == "tskRuleBase" else _MAMDANI
        if base.name == "anYaRuleBase":
            numbers = any(isinstance(term, Constant) for term in self._outputs[0].terms.values())
            names = ("anYaRule", *(_TSK if numbers else _MAMDANI)[1:])
        rules: list[DescribedRule] = []
        for rule in elements.children(base, names[0]):
            rules += self._rule(rule, names)
        if not rules:
            raise elements.malformed(base.line, "there are no rules")
        return tuple(rules)

    def _rule(self, rule: Element, names: tuple[str, ...]) -> list[DescribedRule]:
        elements, (_, consequent, then, otherwise, clause) = self._elements, names
        condition = "anYaAntecedent" if rule.name == "anYaRule" else "antecedent"
        parts = {part.name: part for part in elements.children(rule, condition, consequent)}
        if len(parts) != 2 or len(rule.children) != 2:
            raise elements.malformed(
                rule.line, f"expected one <{condition}> and one <{consequent}>"
            )
        weight = elements.number(rule, elements.attribute(rule, "weight", "1.0"))
        if not 0.0 <= weight <= 1.0:
            raise elements.malformed(rule.line, f"expected a weight from 0 to 1, got {weight:g}")
        asked = self._asked(rule, parts[condition])
        found: list[DescribedRule] = []
        for branch in elements.children(parts[consequent], then, otherwise):
            said = self._said(branch, clause)
            if branch.name == otherwise and weight != 1.0:
                raise elements.refused(
                    branch.line, f"<{otherwise}> of a rule with a weight", "it fires by 1 - w f"
                )
            tree = Not(asked) if branch.name == otherwise else asked
            if any(number != SILENT for number in said):
                found.append(DescribedRule(tree, said, weight))
        if [branch.name for branch in parts[consequent].children].count(then) != 1 or not found:
            raise elements.malformed(
                parts[consequent].line, f"expected one <{then}> with a <{clause}>"
            )
        return found

    def _asked(self, rule: Element, antecedent: Element) -> Antecedent:
        elements = self._elements
        if antecedent.name == "anYaAntecedent":
            names = [variable.name for variable in self._inputs]
            cloud = elements.named(elements.only(antecedent, "dataCloudName"), names, "data cloud")
            self.clouds.append(names.index(cloud))
            return Is(len(self.clouds) - 1, 0)
        parts = tuple(self._clause(child) for child in elements.children(antecedent, "clause"))
        if not parts:
            raise elements.malformed(rule.line, "the rule has no antecedent")
        connector = elements.attribute(rule, "connector", "and").lower()
        if connector not in ("and", "or"):
            raise elements.malformed(
                rule.line, f"expected the connector and or or, got {connector!r}"
            )
        if len(parts) == 1:
            return parts[0]
        used, attribute, default, known = (
            (self._both, "andMethod", "MIN", T_NORMS)
            if connector == "and"
            else (self._either, "orMethod", "MAX", T_CONORMS)
        )
        own = self._elements.attribute(self._base, attribute, default)
        self._use(used, elements.choice(rule, attribute, own, known), rule)
        return And(parts) if connector == "and" else Or(parts)

    def _variable_and_term(
        self, clause: Element, variables: tuple[Variable, ...], role: str
    ) -> tuple[int, int]:
        """Return the numbers of the variable and of the term of a clause."""
        elements = self._elements
        variable, term = self._both_names(clause)
        names = [one.name for one in variables]
        name = elements.named(variable, names, role)
        known = self._known[name]
        found = elements.named(term, known, f"term of {name!r}")
        return names.index(name), known.index(found)

    def _both_names(self, clause: Element) -> tuple[Element, Element]:
        elements = self._elements
        named = {child.name: child for child in elements.children(clause, "variable", "term")}
        if len(named) != 2 or len(clause.children) != 2:
            raise elements.malformed(clause.line, "expected one <variable> and one <term>")
        return named["variable"], named["term"]

    def _clause(self, clause: Element) -> Antecedent:
        elements = self._elements
        variable, term = self._both_names(clause)
        tree: Antecedent
        if (name := variable.text.strip()) in self._aggregated:
            terms = self._aggregated[name]
            tree = terms[elements.named(term, terms, f"term of {name!r}")]
        else:
            tree = Is(*self._variable_and_term(clause, self._inputs, "input"))
        modifier = clause.attributes.get("modifier", "").lower()
        if modifier == "any" and isinstance(tree, Is):
            return Is(tree.variable, None)
        if modifier in MODIFIERS:
            return Hedged(MODIFIERS[modifier], tree)
        if modifier not in ("", "not"):
            raise elements.refused(
                clause.line,
                f"the modifier {modifier!r}",
                f"known are not, any, {', '.join(MODIFIERS)}",
            )
        return Not(tree) if modifier else tree

    def _said(self, branch: Element, kind: str) -> tuple[int, ...]:
        elements = self._elements
        numbers = [SILENT] * len(self._outputs)
        for clause in elements.children(branch, kind):
            place, number = self._variable_and_term(clause, self._outputs, "output")
            variable = self._outputs[place]
            if numbers[place] != SILENT:
                raise elements.refused(
                    clause.line,
                    f"two clauses about {variable.name!r}",
                    "a rule has one consequent for each output",
                )
            modifier = clause.attributes.get("modifier", "").lower()
            if modifier not in ("", "not"):
                raise elements.refused(
                    clause.line, f"the modifier {modifier!r} of an output", "known is not"
                )
            if modifier:
                if isinstance(list(variable.terms.values())[number], Constant | LinearFunction):
                    raise NotExpressible(
                        f"{elements.source}, line {clause.line}: the modifier 'not' of a function",
                        "fuzzy2",
                        "only sets have a complement",
                    )
                number = negated(variable, number)
            numbers[place] = number
        return tuple(numbers)
