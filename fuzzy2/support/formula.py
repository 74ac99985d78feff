r"""Formulas as text, for fuzzylite's terms and the Fuzzy Control Language.

A formula consists of numbers, names and operators. The operators are, from the strongest to the
weakest: parentheses and calls; ``!`` (not) and ``~`` (minus); ``^`` and ``**``, from right to left,
with the prefixes ``.-``, ``.+`` and ``-``; ``*``, ``/`` and ``%``; ``+`` and ``-``; ``and``;
``or``. Every number except 0 is true, and the value of true is 1.

Source: the operators and functions of fuzzylite 8. A grammar parses a formula into a tree of the
functions listed here; the text is never executed by Python.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np
from lark import Lark, Token, Tree
from lark.exceptions import UnexpectedInput
from numpy.typing import NDArray

from fuzzy2.errors import InvalidValue
from fuzzy2.support.checks import Array

_GRAMMAR = r"""
?start: either
?either: both | either "or" both -> either
?both: sum | both "and" sum -> both
?sum: product | sum "+" product -> plus | sum "-" product -> minus
?product: power | product "*" power -> times | product "/" power -> over
    | product "%" power -> remainder
?power: one | one ("^" | "**") power -> raised | (".-" | "-") power -> negative | ".+" power
?one: NUMBER -> number | NAME -> name | NAME "(" [either ("," either)*] ")" -> call
    | "(" either ")" | "!" one -> opposite | "~" one -> negative
NUMBER: /([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?/
NAME: /(?!(and|or)\b)[^\W\d]\w*/
%ignore /\s+/
"""
_LONGEST = 10_000


def _truth(function: Callable[..., Any]) -> Callable[..., Array]:
    """Return a function whose values are converted to 1 and 0."""
    return lambda *parts: np.asarray(function(*parts), dtype=float)


def _equal(a: Array, b: Array) -> NDArray[np.bool_]:
    return np.equal(a, b) | (np.isnan(a) & np.isnan(b))


_OPERATORS: dict[str, Callable[..., Array]] = {
    "either": _truth(np.logical_or),
    "both": _truth(np.logical_and),
    "plus": np.add,
    "minus": np.subtract,
    "times": np.multiply,
    "over": np.true_divide,
    "remainder": np.remainder,
    "raised": np.float_power,
    "negative": np.negative,
    "opposite": _truth(np.logical_not),
}

_FUNCTIONS: Mapping[str, tuple[int, Callable[..., Array]]] = MappingProxyType(
    {
        "abs": (1, np.fabs),
        "acos": (1, np.arccos),
        "acosh": (1, np.arccosh),
        "asin": (1, np.arcsin),
        "asinh": (1, np.arcsinh),
        "atan": (1, np.arctan),
        "atan2": (2, np.arctan2),
        "atanh": (1, np.arctanh),
        "ceil": (1, np.ceil),
        "cos": (1, np.cos),
        "cosh": (1, np.cosh),
        "eq": (2, _truth(_equal)),
        "exp": (1, np.exp),
        "fabs": (1, np.fabs),
        "floor": (1, np.floor),
        "fmod": (2, np.fmod),
        "ge": (2, _truth(lambda a, b: (a > b) | _equal(a, b))),
        "gt": (2, _truth(np.greater)),
        "le": (2, _truth(lambda a, b: (a < b) | _equal(a, b))),
        "log": (1, np.log),
        "log10": (1, np.log10),
        "log1p": (1, np.log1p),
        "lt": (2, _truth(np.less)),
        "max": (2, np.maximum),
        "min": (2, np.minimum),
        "neq": (2, _truth(lambda a, b: ~_equal(a, b))),
        "pi": (0, lambda: np.asarray(math.pi)),
        "pow": (2, np.float_power),
        "round": (1, np.round),
        "sin": (1, np.sin),
        "sinh": (1, np.sinh),
        "sqrt": (1, np.sqrt),
        "tan": (1, np.tan),
        "tanh": (1, np.tanh),
    }
)
"""Functions, each with the number of its arguments."""


@functools.cache
def _parser() -> Lark:
    return Lark(_GRAMMAR, parser="lalr")


@dataclass(frozen=True)
class Formula:
    """Formula of named numbers.

    Parameters
    ----------
    text : str
        The formula; see :mod:`fuzzy2.support.formula`.

    Raises
    ------
    InvalidValue
        If the text is not a formula, is longer than 10 000 characters, or calls an unknown
        function.
    """

    text: str

    def __post_init__(self) -> None:
        text = self.text
        if not isinstance(text, str) or len(text) > _LONGEST:
            raise InvalidValue("the formula", text, f"a text of at most {_LONGEST} characters")
        object.__setattr__(self, "text", " ".join(text.split()))
        for node in self.tree.iter_subtrees():
            if node.data == "call":
                self._check_call(node)

    @functools.cached_property
    def tree(self) -> Tree[Token]:
        """The parsed formula as a tree, within a root node."""
        try:
            tree = _parser().parse(self.text)
        except UnexpectedInput as error:
            column = getattr(error, "column", -1)
            where = f"near column {column}" if column > 0 else "at its end"
            raise InvalidValue(
                "the formula", self._shown, f"numbers, names, operators and calls, {where}"
            ) from None
        return Tree("whole", [tree])

    @property
    def _shown(self) -> str:
        return self.text if len(self.text) < 60 else f"{self.text[:57]}..."

    def _check_call(self, node: Tree[Token]) -> None:
        name = str(node.children[0])
        count, _ = _FUNCTIONS.get(name, (0, None))
        if name not in _FUNCTIONS:
            raise InvalidValue("a function in a formula", name, f"one of {', '.join(_FUNCTIONS)}")
        if sum(part is not None for part in node.children[1:]) != count:
            raise InvalidValue(f"the arguments of {name}", self._shown, f"{count} of them")

    def __reduce__(self) -> tuple[type[Formula], tuple[str]]:
        # Pickled without its tree, which may be nested too deeply for pickle.
        return Formula, (self.text,)

    @functools.cached_property
    def names(self) -> frozenset[str]:
        """Names that the formula uses."""
        found = {str(node.children[0]) for node in self.tree.find_data("name")}
        return frozenset(found - {"pi"})

    @functools.cached_property
    def numbers(self) -> tuple[float, ...]:
        """Numbers in the formula, in ascending order."""
        return tuple(sorted({float(str(n.children[0])) for n in self.tree.find_data("number")}))

    def at(self, values: Mapping[str, Array]) -> Array:
        """Return the formula (...,) at values (...,) by name; NaN where it is undefined.

        Raises
        ------
        InvalidValue
            If a name has no value.
        """
        found: dict[int, Array] = {}
        # A stack goes from the leaves to the root, because formulas may be too long for recursion.
        with np.errstate(all="ignore"):
            for node in self.tree.iter_subtrees():
                parts = [found[id(part)] for part in node.children if isinstance(part, Tree)]
                found[id(node)] = _evaluated(node, parts, values)
        return found[id(self.tree)]

    def program(self, names: Sequence[str]) -> tuple[list[float], int]:
        """Return the steps for :mod:`fuzzy2.support.formula_kernels`, and the depth of their stack.

        ``names`` are those of the inputs, in order, and include all names of the formula.
        """
        from fuzzy2.support.formula_kernels import INPUT, NUMBER

        steps: list[float] = []
        depth = deepest = 0
        for node in self._leaves_first():
            if node.data == "number":
                steps += [NUMBER, float(str(node.children[0]))]
            elif node.data == "name" and str(node.children[0]) == "pi":
                steps += [NUMBER, math.pi]
            elif node.data == "name":
                steps += [INPUT, float(names.index(str(node.children[0])))]
            else:
                self._add_step(node, steps)
            parts = sum(isinstance(part, Tree) for part in node.children)
            depth += 1 - parts
            deepest = max(deepest, depth)
        return steps, deepest

    def _leaves_first(self) -> list[Tree[Token]]:
        """Return the nodes so that each follows its parts, directly after the last one."""
        waiting, found = [self.tree], []
        while waiting:
            node = waiting.pop()
            found.append(node)
            waiting += [part for part in node.children if isinstance(part, Tree)]
        return found[::-1]

    @staticmethod
    def _add_step(node: Tree[Token], steps: list[float]) -> None:
        from fuzzy2.support.formula_kernels import CODES, NUMBER

        if node.data == "call" and str(node.children[0]) == "pi":
            steps += [NUMBER, math.pi]
        elif node.data == "call":
            steps.append(float(CODES[str(node.children[0])]))
        elif node.data not in ("whole", "power"):
            steps.append(float(CODES[node.data]))

    def __call__(self, x: Array) -> Array:
        """Return the formula at points (...,) of x, its only name."""
        return np.broadcast_to(self.at({"x": x}), np.shape(x))


def _evaluated(node: Tree[Token], parts: list[Array], values: Mapping[str, Array]) -> Array:
    if node.data == "number":
        return np.asarray(float(str(node.children[0])))
    if node.data == "name":
        name = str(node.children[0])
        if name == "pi":
            return np.asarray(math.pi)
        if name not in values:
            raise InvalidValue("a name in a formula", name, f"one of {', '.join(values)}")
        return np.asarray(values[name], dtype=float)
    if node.data == "call":
        return np.asarray(_FUNCTIONS[str(node.children[0])][1](*parts), dtype=float)
    if node.data in ("whole", "power"):
        return parts[0]
    return np.asarray(_OPERATORS[node.data](*parts), dtype=float)
