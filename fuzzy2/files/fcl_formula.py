"""Formulas of the Fuzzy Control Language (``FUNCTION``), linear or not."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence

import numpy as np
from lark import Token, Tree

from fuzzy2.errors import InvalidValue, NotExpressible
from fuzzy2.files.description import LinearFunction
from fuzzy2.files.functions import FormulaFunction
from fuzzy2.support.checks import Array
from fuzzy2.support.formula import Formula

_NAME = re.compile(r"\b[^\W\d]\w*\b(?P<call>\s*\()?")


def function_of(
    text: str, inputs: Sequence[str], outputs: Sequence[str], jfuzzylogic: bool
) -> LinearFunction | FormulaFunction:
    """Return the function of a formula, as a linear function if the formula is recognized as one.

    Parameters
    ----------
    text : str
        The formula, which is case-insensitive.
    inputs, outputs : sequence of str
        Names that it may use.
    jfuzzylogic : bool
        Whether ``log`` is the decimal logarithm, as in jFuzzyLogic.

    Raises
    ------
    NotExpressible
        If it contains ``log``, whose base the language does not define.
    InvalidValue
        If the text is not a formula, or uses an unknown name.
    """
    known = {name.lower(): name for name in (*inputs, *outputs)}

    def named(found: re.Match[str]) -> str:
        word = found[0].rstrip("( \t\r\n").lower()
        if not found["call"]:
            return known.get(word, found[0])
        if word == "log" and not jfuzzylogic:
            raise NotExpressible(
                "log in a formula",
                "fuzzy2",
                "it is natural in fuzzylite and decimal in jFuzzyLogic; write ln or log10",
            )
        own = {"ln": "log", "log": "log10"} if jfuzzylogic else {"ln": "log"}
        return f"{own.get(word, word)}("

    formula = Formula(_NAME.sub(named, text))
    for name in sorted(formula.names.difference(known.values())):
        raise InvalidValue("a name in a formula", name, f"one of {', '.join(known.values())}")
    values = _linear(formula.tree, list(inputs))
    if values is None:
        return FormulaFunction(formula.text)
    if not np.isfinite(values).all():
        raise InvalidValue("the formula", text, "finite")
    return LinearFunction(float(values[-1]), tuple(values[:-1].tolist()))


def _linear(tree: Tree[Token], inputs: list[str]) -> Array | None:
    """Return slopes and constant, or None; a stack is used because formulas may be long."""
    results: dict[int, Array | None] = {}
    for node in tree.iter_subtrees():  # from the leaves to the root
        parts = [results[id(part)] for part in node.children if isinstance(part, Tree)]
        known = [part for part in parts if part is not None]
        results[id(node)] = _combined(node, known, inputs) if len(known) == len(parts) else None
    return results[id(tree)]


def _combined(node: Tree[Token], parts: list[Array], inputs: list[str]) -> Array | None:
    value = np.zeros(len(inputs) + 1)
    match node.data:
        case "number":
            value[-1] = float(str(node.children[0]))
            return value
        case "name" if str(node.children[0]) in inputs:
            value[inputs.index(str(node.children[0]))] = 1.0
            return value
        case "whole" | "power":
            return parts[0]
        case "negative":
            return -parts[0]
        case "plus":
            return parts[0] + parts[1]
        case "minus":
            return parts[0] - parts[1]
        case "times" if not parts[1][:-1].any():
            return np.asarray(parts[0] * parts[1][-1])
        case "times" if not parts[0][:-1].any():
            return np.asarray(parts[1] * parts[0][-1])
        case "over" if not parts[1][:-1].any() and parts[1][-1] != 0.0:
            return np.asarray(parts[0] / parts[1][-1])
    return None


def formula(function: LinearFunction, inputs: Sequence[str]) -> str:
    """Return a linear function as a formula."""
    terms = [
        f"{name} * {slope!r}" if slope >= 0.0 else f"{name} * (0 - {-slope!r})"
        for name, slope in zip(inputs, function.slopes, strict=True)
        if slope != 0.0
    ]
    constant = function.constant
    if constant != 0.0 or not terms:
        terms.append(
            repr(constant) if math.copysign(1.0, constant) > 0.0 else f"(0 - {-constant!r})"
        )
    return " + ".join(terms)


def formula_text(text: str) -> str:
    """Return a formula in the syntax of the language, in which the natural logarithm is ``ln``."""
    return re.sub(r"\blog(?=\s*\()", "ln", text)
