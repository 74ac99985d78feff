"""A description, written as an FML document."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NoReturn
from xml.etree import ElementTree

from fuzzy2.errors import NotExpressible
from fuzzy2.files.description import (
    SILENT,
    SUM,
    Constant,
    Description,
    LinearFunction,
    Variable,
    check_names,
    clauses_of_rule,
)
from fuzzy2.files.fml_names import NAMESPACE, T_CONORMS, T_NORMS, named_shape
from fuzzy2.sets.derived import Complement
from fuzzy2.sets.type1 import SampledSet, Type1Set


def document_of(description: Description, name: str) -> ElementTree.Element:
    """Return the document of a description."""
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
            accumulation = _known_as(description.aggregation, T_CONORMS)
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
    if term.height != 1.0:
        _refuse(f"{term!r}", "its membership functions reach 1")
    kind, parameters = named_shape(term) or _refuse(
        f"{term!r}", "it has no such shape; sample it first"
    )
    ElementTree.SubElement(
        element, kind, {f"param{i + 1}": _number(value) for i, value in enumerate(parameters)}
    )


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
    mamdani, t_norm = description.mamdani, _known_as(description.t_norm, T_NORMS)
    base_name, rule_name = ("mamdaniRuleBase", "rule") if mamdani else ("tskRuleBase", "tskRule")
    consequent_name, then_name, clause_name = (
        ("consequent", "then", "clause") if mamdani else ("tskConsequent", "tskThen", "tskClause")
    )
    methods = {"activationMethod": t_norm, "andMethod": t_norm, "orMethod": "MAX"}
    base = ElementTree.SubElement(root, base_name, {"name": "rules", **methods})
    for number, rule in enumerate(description.rules, start=1):
        flat = clauses_of_rule(rule.asked)
        if flat is None or flat[0] or rule.weight != 1.0 or SILENT in rule.said:
            _refuse("a rule with or, not, hedges, a weight or silence", "use JSON")
        asked, said = [-1] * len(description.inputs), rule.said
        for clause in flat[1]:
            asked[clause.input] = clause.term
        if max(asked) < 0:
            _refuse("a rule that asks for nothing", "a rule has at least one clause")
        # A rule's own andMethod is MIN if it does not say so.
        written = ElementTree.SubElement(
            base, rule_name, {"name": f"rule{number}", "andMethod": t_norm, "connector": "and"}
        )
        _write_clauses(
            ElementTree.SubElement(written, "antecedent"), "clause", description.inputs, asked
        )
        consequent = ElementTree.SubElement(written, consequent_name)
        _write_clauses(
            ElementTree.SubElement(consequent, then_name), clause_name, description.outputs, said
        )


def _write_clauses(
    parent: ElementTree.Element,
    kind: str,
    variables: tuple[Variable, ...],
    numbers: Sequence[int],
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
