"""Rules of fuzzylite and IEC 61131-7, parsed by the grammar of rules in words, for an engine."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from fuzzy2.errors import InvalidRule
from fuzzy2.files.engine import EngineRule
from fuzzy2.systems.antecedents import Antecedent, Hedged, Is, Not, leaves, mapped
from fuzzy2.systems.hedges import Hedge
from fuzzy2.systems.rule_grammar import parsed_hedged
from fuzzy2.systems.rules import unknown_name

Names = Mapping[str, tuple[str, ...]]
"""Terms of variables by name."""


def rules_of(
    text: str,
    place: int,
    hedges: Mapping[str, Hedge],
    variables: tuple[Names, Names],
    operators: tuple[str | None, str | None, str | None],
    any_case: bool = False,
) -> list[EngineRule]:
    """Return the rules of a line: one rule for each conclusion.

    Parameters
    ----------
    text : str
        The rule.
    place : int
        Line number of the rule.
    hedges : mapping
        Hedges of the format.
    variables : pair of mappings
        Terms of the inputs and of the outputs.
    operators : (str, str, str)
        Conjunction, disjunction and implication of its block; None if it has none.
    any_case : bool
        Whether names are case-insensitive.

    Raises
    ------
    InvalidRule
        If the text is not a rule, or uses unknown names.
    """
    try:
        return _rules_of(text, place, hedges, variables, operators, any_case)
    except RecursionError:
        raise InvalidRule(1, text[:60], "is nested too deeply") from None


def _rules_of(
    text: str,
    place: int,
    hedges: Mapping[str, Hedge],
    variables: tuple[Names, Names],
    operators: tuple[str | None, str | None, str | None],
    any_case: bool,
) -> list[EngineRule]:
    tree, conclusions, weight = parsed_hedged(text.strip(), 1, hedges)
    inputs, outputs = variables
    both = {**inputs, **outputs}
    if any_case:
        tree = mapped(tree, lambda clause: Is(*_cased(str(clause.variable), clause.term, both)))
        cased = [(*_cased(variable, term, outputs), words) for variable, words, term in conclusions]
        conclusions = [(variable, words, str(term)) for variable, term, words in cased]

    def check(variable: str, term: str | None, known: Names, kind: str) -> None:
        if variable not in known:
            raise InvalidRule(1, text, f"refers to an {unknown_name(kind, variable, known)}")
        if term is not None and term not in known[variable]:
            names = known[variable]
            raise InvalidRule(
                1, text, f"refers to an {unknown_name(f'term of {variable}', term, names)}"
            )

    for clause in leaves(tree):
        term = None if clause.term is None else str(clause.term)
        check(str(clause.variable), term, both, "variable")
    for variable, words, said in conclusions:
        check(variable, said, outputs, "output")
        if words and weight != 1.0:
            raise InvalidRule(1, text, "has both a hedge in its conclusion and a weight")
    return concluded(tree, conclusions, hedges, place, weight, operators)


def concluded(
    tree: Antecedent,
    conclusions: Iterable[tuple[str, Sequence[str], str]],
    hedges: Mapping[str, Hedge],
    place: int,
    weight: float,
    operators: tuple[str | None, str | None, str | None],
) -> list[EngineRule]:
    """Return the rules of a condition and its conclusions (variables, hedges before, and terms).

    A hedge also applies to the following conclusions, as in fuzzylite.
    """
    passes: list[tuple[Antecedent, list[tuple[str, str]]]] = [(tree, [])]
    for variable, words, term in conclusions:
        for word in reversed(words):
            tree = Not(tree) if word == "not" else Hedged(hedges[word], tree)
        if words or any(variable == other for other, _ in passes[-1][1]):
            passes.append((tree, []))
        passes[-1][1].append((variable, term))
    return [
        EngineRule(place, asked, tuple(said), weight, *operators) for asked, said in passes if said
    ]


def _cased(variable: str, term: Any, known: Names) -> tuple[str, Any]:
    """Return known names for names in any case; unknown names are returned unchanged."""
    variable = next((one for one in known if one.lower() == variable.lower()), variable)
    if term is None or term in known.get(variable, ()):
        return variable, term
    return variable, next(
        (one for one in known.get(variable, ()) if one.lower() == str(term).lower()), term
    )
