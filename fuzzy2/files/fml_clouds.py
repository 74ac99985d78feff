"""Writer of data clouds and their rules, in an FML document."""

from __future__ import annotations

from xml.etree import ElementTree

from fuzzy2.errors import NotExpressible
from fuzzy2.files.description import (
    SILENT,
    DescribedRule,
    Description,
    LinearFunction,
)
from fuzzy2.files.fml_names import FIRING, T_NORMS
from fuzzy2.files.operator_words import known_as
from fuzzy2.systems.antecedents import Is, Not
from fuzzy2.systems.anya import AnYaSystem


def check_clouds(description: Description, clouds: AnYaSystem) -> None:
    """Refuse consequents that an AnYa rule base cannot have.

    Raises
    ------
    NotExpressible
        If they are functions, or if a rule uses more than one firing or its complement.
    """
    if any(
        isinstance(term, LinearFunction)
        for output in description.outputs
        for term in output.terms.values()
    ):
        reason = "its clouds have numbers or sets for consequents; use JSON"
        raise NotExpressible("functions of firings", "FML", reason)
    branches = [_branches(description, i) for i in range(len(clouds.asked))]
    count = sum(len(then) + len(otherwise) for then, otherwise in branches)
    if count < len(description.rules) or any(
        list(firing.terms.values()) != [FIRING] for firing in description.inputs
    ):
        reason = "its rules of clouds use the firing itself; use JSON"
        raise NotExpressible("a rule that uses more than one firing", "FML", reason)
    for then, otherwise in branches:
        if len(then) != 1 or len(otherwise) > 1:
            raise NotExpressible(
                f"{len(then)} rules for a firing and {len(otherwise)} against it",
                "FML",
                "its rules of clouds have one then and at most one else; use JSON",
            )
        if otherwise and {then[0].weight, otherwise[0].weight} != {1.0}:
            reason = "its else fires by 1 - w f; use JSON"
            raise NotExpressible("else of a rule of clouds with a weight", "FML", reason)


def _branches(
    description: Description, firing: int
) -> tuple[list[DescribedRule], list[DescribedRule]]:
    """Return the rules that use a firing, and those that use its complement."""
    asked = Is(firing, 0)
    return (
        [rule for rule in description.rules if rule.asked == asked],
        [rule for rule in description.rules if rule.asked == Not(asked)],
    )


def write_clouds(base: ElementTree.Element, clouds: AnYaSystem) -> None:
    """Write the data of the clouds."""
    for name, data in zip(clouds.input_names, clouds.clouds, strict=True):
        cloud = ElementTree.SubElement(base, "anYaDataCloud", {"name": name})
        for value in data:
            ElementTree.SubElement(cloud, "datum").text = repr(float(value))


def write_cloud_rules(
    root: ElementTree.Element, description: Description, clouds: AnYaSystem
) -> None:
    """Write a rule for each firing, with *then* and possibly *else*."""
    implied = known_as(description.implied_by, T_NORMS, "implication", "FML")
    words = {"name": "rules", "activationMethod": implied}
    base = ElementTree.SubElement(root, "anYaRuleBase", words)
    names = ("consequent", "then", "else", "clause")
    if not description.mamdani:
        names = ("tskConsequent", "tskThen", "tskElse", "tskClause")
    for i, cloud in enumerate(clouds.asked):
        then, otherwise = _branches(description, i)
        weight = {} if then[0].weight == 1.0 else {"weight": repr(float(then[0].weight))}
        rule = ElementTree.SubElement(base, "anYaRule", {"name": f"rule{i + 1}", **weight})
        antecedent = ElementTree.SubElement(rule, "anYaAntecedent")
        ElementTree.SubElement(antecedent, "dataCloudName").text = clouds.input_names[cloud]
        consequent = ElementTree.SubElement(rule, names[0])
        for word, rules in ((names[1], then), (names[2], otherwise)):
            for one in rules:
                branch = ElementTree.SubElement(consequent, word)
                for variable, term in zip(description.outputs, one.said, strict=True):
                    if term != SILENT:
                        clause = ElementTree.SubElement(branch, names[3])
                        ElementTree.SubElement(clause, "variable").text = variable.name
                        ElementTree.SubElement(clause, "term").text = list(variable.terms)[term]
