"""The rules of a system in words, however the system was made."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from fuzzy2.errors import InvalidValue
from fuzzy2.systems.antecedents import Antecedent, Is, mapped, trees_of
from fuzzy2.systems.consequents import Formulas, Linear
from fuzzy2.systems.explainable import Explainable
from fuzzy2.systems.rules import antecedent_in_words, quoted


def rules_in_words(
    system: Explainable, most: int | None = None, asks: Callable[[Is], Antecedent] | None = None
) -> list[str]:
    """Return the text of each rule, with names if there are names, otherwise with numbers or sets.

    Parameters
    ----------
    system : FuzzySystem
        The system.
    most : int, optional
        Greatest number of rules, from the first on; all by default.
    asks : callable, optional
        Converts a clause ``input is term`` from numbers to words; by default with the names of the
        system.
    """
    trees = system.rules if isinstance(system.rules, tuple) else trees_of(system.rules)
    count = len(trees) if most is None else min(most, len(trees))
    named = asks or (lambda leaf: _by_names(system, leaf))
    return [_rule(system, r, mapped(trees[r], named)) for r in range(count)]


def _rule(system: Explainable, r: int, tree: Antecedent) -> str:
    said = " and ".join(
        f"{quoted(name)} is {_said(system, r, j)}"
        for j, name in enumerate(system.output_names)
        if system.silent is None or not system.silent[r, j]
    )
    text = f"IF {_asked(tree)} THEN {said}"
    weight = 1.0 if system.weights is None else float(system.weights[r])
    return text if weight == 1.0 else f"{text} with {weight:.6g}"


def _by_names(system: Explainable, leaf: Is) -> Antecedent:
    i = int(leaf.variable)
    term = None if leaf.term is None else system.term_names[i][int(leaf.term)]
    return Is(system.input_names[i], term)


def _asked(tree: Antecedent) -> str:
    try:
        return antecedent_in_words(tree)
    except InvalidValue:
        # A hedge of a group, which rules in words cannot express.
        return str(tree)


def _said(system: Explainable, r: int, j: int) -> str:
    names = system.consequent_names
    if names is not None and names[r][j]:
        return quoted(names[r][j])
    if system.consequent_sets is not None:
        return repr(system.consequent_sets[r][j])
    if isinstance(system.consequents, Linear):
        return _linear(system.consequents.coefficients[r, j], system.input_names)
    if isinstance(system.consequents, Formulas):
        return system.consequents.said(r, j)
    left, right = system.consequent_intervals[r, j]
    return f"{left:.6g}" if left == right else f"[{left:.6g}, {right:.6g}]"


def _linear(coefficients: Any, names: tuple[str, ...]) -> str:
    text = f"{coefficients[0]:.6g}"
    for value, name in zip(coefficients[1:], names, strict=True):
        if value != 0.0:
            sign = "-" if np.signbit(value) else "+"
            text += f" {sign} {abs(value):.6g} {quoted(name)}"
    return text
