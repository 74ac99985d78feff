"""Writer of a description as an FML document."""

from __future__ import annotations

from dataclasses import replace
from typing import NoReturn
from xml.etree import ElementTree

from fuzzy2.errors import NotExpressible
from fuzzy2.files.clauses import clauses_of_rule
from fuzzy2.files.description import (
    SILENT,
    SUM,
    Constant,
    Description,
    LinearFunction,
    Variable,
    check_crisp,
    check_names,
)
from fuzzy2.files.fml_clouds import check_clouds, write_cloud_rules, write_clouds
from fuzzy2.files.fml_names import (
    DEFUZZIFIERS,
    MODIFIERS,
    NAMESPACE,
    RULE_BASES,
    T_CONORMS,
    T_NORMS,
    named_shape,
)
from fuzzy2.files.operator_words import known_as
from fuzzy2.sets.derived import Complement
from fuzzy2.sets.type1 import SampledSet, Type1Set
from fuzzy2.systems.anya import AnYaSystem
from fuzzy2.systems.hedges import Hedge


def document_of(
    description: Description, name: str, clouds: AnYaSystem | None = None
) -> ElementTree.Element:
    """Return the document of a description, or of the consequents of data clouds."""
    if description.type2:
        _refuse("an interval type-2 system", "the standard has type-1 sets only; use JSON or .fis")
    if description.aggregation == SUM and description.mamdani:
        _refuse("center of sums", "its accumulation unites; use .fis, or the reducer centroid")
    reduction = description.reduced_by
    kind = "tsukamoto" if reduction == "tsukamoto" else "mamdani" if description.mamdani else "tsk"
    if kind == "tsk" and reduction != "center_of_sets":
        _refuse(f"the type reduction {reduction!r}", "it has weighted averages only")
    inputs = _inputs(description, clouds)
    check_names(replace(description, inputs=inputs), "FML")
    names = [variable.name for variable in (*inputs, *description.outputs)]
    if len(set(names)) < len(names):
        _refuse("an input and an output of one name", "variables are known by their names")
    root = ElementTree.Element("fuzzySystem", {"xmlns": NAMESPACE, "name": name})
    base = ElementTree.SubElement(root, "knowledgeBase")
    for variable in inputs if clouds is None else ():
        _write_sets(base, variable, ("fuzzyVariable", "fuzzyTerm"), {"type": "input"})
    if clouds is not None:
        write_clouds(base, clouds)
    for variable in description.outputs:
        default = {"defaultValue": _number(variable.default, "NaN")}
        if kind == "mamdani":
            words = {
                "type": "output",
                "accumulation": known_as(description.aggregation, T_CONORMS, "t-conorm", "FML"),
                "defuzzifier": _defuzzifier(reduction),
            }
            _write_sets(base, variable, ("fuzzyVariable", "fuzzyTerm"), {**words, **default})
        elif kind == "tsukamoto":
            words = {"type": "output", "combination": "WA", **default}
            _write_sets(base, variable, ("tsukamotoVariable", "tsukamotoTerm"), words)
        else:
            _write_functions(base, variable, default)
    if clouds is None:
        _write_rules(root, description, kind)
    else:
        write_cloud_rules(root, description, clouds)
    return root


def _inputs(description: Description, clouds: AnYaSystem | None) -> tuple[Variable, ...]:
    """Return the inputs of the document; clouds have no terms."""
    if clouds is None:
        return description.inputs
    check_clouds(description, clouds)
    return tuple(Variable(name, (0.0, 1.0), {}) for name in clouds.input_names)


def _defuzzifier(reduction: str) -> str:
    return known_as(reduction, DEFUZZIFIERS, "type reduction", "FML")


def _refuse(what: str, reason: str) -> NoReturn:
    raise NotExpressible(what, "FML", reason)


def _write_sets(
    base: ElementTree.Element,
    variable: Variable,
    names: tuple[str, str],
    attributes: dict[str, str],
) -> None:
    low, high = variable.range
    ends = {
        "domainleft": _number(low),
        "domainright": _number(high),
    }
    element = ElementTree.SubElement(base, names[0], {"name": variable.name, **ends, **attributes})
    if not variable.terms:
        _refuse(f"the variable {variable.name!r} without terms", "a variable has at least one")
    for name, term in variable.terms.items():
        _write_set(ElementTree.SubElement(element, names[1], {"name": name}), term, variable.range)


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


def _write_functions(
    base: ElementTree.Element, variable: Variable, default: dict[str, str]
) -> None:
    attributes = {"name": variable.name, "type": "output", "combination": "WA", **default}
    element = ElementTree.SubElement(base, "tskVariable", attributes)
    if not variable.terms:
        _refuse(f"the variable {variable.name!r} without terms", "a variable has at least one")
    for name, term in variable.terms.items():
        if isinstance(term, Constant) and term.left != term.right:
            _refuse(f"the interval {list(term)} as a consequent", "its constants are crisp")
        if isinstance(term, LinearFunction):
            check_crisp(term, "FML")
        order, values = (
            ("1", (term.constant, *term.slopes))
            if isinstance(term, LinearFunction)
            else ("0", (term.left,))
        )
        written = ElementTree.SubElement(element, "tskTerm", {"name": name, "order": order})
        for value in values:
            ElementTree.SubElement(written, "tskValue").text = _number(value)


def _write_rules(root: ElementTree.Element, description: Description, kind: str) -> None:
    tsk = kind == "tsk"
    rule_name, consequent_name, then_name, clause_name = (
        ("tskRule", "tskConsequent", "tskThen", "tskClause")
        if tsk
        else ("rule", "consequent", "then", "clause")
    )
    base_name = next(word for word, known in RULE_BASES.items() if known == kind)
    both = known_as(description.t_norm, T_NORMS, "t-norm", "FML")
    either = known_as(description.disjunction, T_CONORMS, "t-conorm", "FML")
    implied = known_as(description.implied_by, T_NORMS, "implication", "FML")
    methods = {"activationMethod": implied, "andMethod": both, "orMethod": either}
    base = ElementTree.SubElement(root, base_name, {"name": "rules", **methods})
    for number, rule in enumerate(description.rules, start=1):
        flat = clauses_of_rule(rule.asked)
        if flat is None:
            _refuse("a rule with and and or, or with a negated group", "a rule has either")
        if not flat[1]:
            _refuse("a rule without an antecedent", "a rule has at least one clause")
        # The default of a rule's andMethod is MIN, and that of its orMethod is MAX.
        words = {"andMethod": both, "orMethod": either, "connector": "or" if flat[0] else "and"}
        weight = {} if rule.weight == 1.0 else {"weight": _number(rule.weight)}
        written = ElementTree.SubElement(
            base, rule_name, {"name": f"rule{number}", **words, **weight}
        )
        antecedent = ElementTree.SubElement(written, "antecedent")
        for clause in flat[1]:
            asked = _write_clause(
                antecedent, "clause", description.inputs[clause.input], clause.term
            )
            if clause.changes:
                asked.set("modifier", _modifier(clause.changes))
        consequent = ElementTree.SubElement(written, consequent_name)
        then = ElementTree.SubElement(consequent, then_name)
        for variable, term in zip(description.outputs, rule.said, strict=True):
            if term != SILENT:
                _write_clause(then, clause_name, variable, term)


def _write_clause(
    parent: ElementTree.Element, kind: str, variable: Variable, number: int
) -> ElementTree.Element:
    clause = ElementTree.SubElement(parent, kind)
    ElementTree.SubElement(clause, "variable").text = variable.name
    ElementTree.SubElement(clause, "term").text = list(variable.terms)[number]
    return clause


def _modifier(changes: tuple[str | Hedge, ...]) -> str:
    change = changes[0]
    if len(changes) > 1:
        _refuse("several hedges and negations of one clause", "a clause has one modifier")
    if isinstance(change, str):
        return change
    for word, hedge in MODIFIERS.items():
        if hedge == change or (change.power is not None and hedge.power == change.power):
            return word
    _refuse(f"the hedge {change.name!r}", f"it has {', '.join(MODIFIERS)} only")


def _number(value: float | None, missing: str = "") -> str:
    # Enough digits to read back the same float.
    return missing if value is None else repr(float(value))
