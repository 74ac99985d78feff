"""Formulas of jFuzzyLogic (``FUNCTION``) that are linear functions of the inputs."""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence

import numpy as np
from lark import Lark, Token, Tree
from lark.exceptions import UnexpectedInput

from fuzzy2.errors import InvalidValue, NotExpressible
from fuzzy2.files.description import LinearFunction
from fuzzy2.support.checks import Array

_GRAMMAR = r"""
?sum: product | sum "+" product -> plus | sum "-" product -> minus
?product: one | product "*" one -> times | product "/" one -> over
?one: NUMBER -> number | NAME -> name | "(" sum ")" | "-" one -> negative
NUMBER: /(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?/
NAME: /[^\W\d]\w*/
%ignore /\s+/
"""
_LONGEST = 10_000


@functools.cache
def _parser() -> Lark:
    return Lark(_GRAMMAR, start="sum", parser="lalr")


def linear_function(text: str, inputs: Sequence[str]) -> LinearFunction:
    """Return the linear function that a formula is.

    Raises
    ------
    NotExpressible
        If it is none.
    InvalidValue
        If it speaks of no input.
    """
    reason = "formulas are sums of inputs times numbers"
    try:
        tree = _parser().parse(text)
    except UnexpectedInput:
        raise NotExpressible(f"the formula {text[:60]!r}", "fuzzy2", reason) from None
    if len(text) > _LONGEST or text.count("(") > 100:
        raise NotExpressible("a formula this long", "fuzzy2", reason)
    names = [name.lower() for name in inputs]
    values = _evaluated(tree, names, text)
    if not np.isfinite(values).all():
        raise InvalidValue("the formula", text, "finite")
    return LinearFunction(float(values[-1]), tuple(values[:-1].tolist()))


def _evaluated(tree: Tree[Token], names: list[str], text: str) -> Array:
    """Return the slopes and the constant, by a stack, for formulas may be long."""
    results: dict[int, Array] = {}
    for node in tree.iter_subtrees():  # from the leaves to the root
        parts = [results[id(part)] for part in node.children if isinstance(part, Tree)]
        results[id(node)] = _combined(node, parts, names, text)
    return results[id(tree)]


def _combined(node: Tree[Token], parts: list[Array], names: list[str], text: str) -> Array:
    value = np.zeros(len(names) + 1)
    if node.data == "number":
        value[-1] = float(str(node.children[0]))
        return value
    if node.data == "name":
        name = str(node.children[0]).lower()
        if name not in names:
            raise InvalidValue("a name in a formula", str(node.children[0]), "that of an input")
        value[names.index(name)] = 1.0
        return value
    if node.data == "negative":
        return -parts[0]
    if node.data in ("plus", "minus"):
        return parts[0] + (parts[1] if node.data == "plus" else -parts[1])
    first, second = parts
    if node.data == "times" and not second[:-1].any():
        return np.asarray(first * second[-1])
    if node.data == "times" and not first[:-1].any():
        return np.asarray(second * first[-1])
    if node.data == "over" and not second[:-1].any() and second[-1] != 0.0:
        return np.asarray(first / second[-1])
    shown = text if len(text) < 60 else f"{text[:57]}..."
    raise NotExpressible(f"the formula {shown!r}", "fuzzy2", "it is no linear function")


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
