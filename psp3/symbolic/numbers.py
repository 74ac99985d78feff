"""Arithmetic of kernels on known numbers and on CasADi symbols.

A known number remains a Python number, so that only expressions that depend on a symbol enter
CasADi's graph, because a robot's matrices are mostly zeros.
"""

from __future__ import annotations

import ast
import math
import operator
from collections.abc import Callable
from typing import Any

from psp3.errors import MissingPackage

try:
    import casadi as casadi
except ImportError as error:
    raise MissingPackage("casadi", "symbolic", error) from error

SX = casadi.SX

Number = Any
"""A Python number or truth value, or a symbol, which is a ``casadi.SX`` of one entry."""


def is_symbol(value: object) -> bool:
    """Tell whether a value depends on a symbol."""
    return type(value) is SX


def _settled(value: Number) -> Number:
    """Return a Python number if a value does not depend on a symbol."""
    return float(value) if value.is_constant() else value


def _add(a: Number, b: Number) -> Number:
    if type(a) is not SX and type(b) is not SX:
        return a + b
    # A call of CasADi takes ten times as long, and most entries are zero.
    if type(a) is not SX and a == 0.0:
        return b
    if type(b) is not SX and b == 0.0:
        return a
    return _settled(a + b)


def _subtract(a: Number, b: Number) -> Number:
    if type(a) is not SX and type(b) is not SX:
        return a - b
    if type(b) is not SX and b == 0.0:
        return a
    return _settled(a - b)


def _multiply(a: Number, b: Number) -> Number:
    if type(a) is not SX and type(b) is not SX:
        return a * b
    if type(a) is not SX and a in (0.0, 1.0):
        return 0.0 if a == 0.0 else b
    if type(b) is not SX and b in (0.0, 1.0):
        return 0.0 if b == 0.0 else a
    return _settled(a * b)


def _divide(a: Number, b: Number) -> Number:
    if type(a) is not SX and type(b) is not SX:
        if b == 0.0:
            # As in IEEE 754 and in the kernels.
            infinite = math.copysign(math.inf, a) * math.copysign(1.0, b)
            return math.nan if a == 0.0 or a != a else infinite
        return a / b
    if type(a) is not SX and a == 0.0:
        return 0.0
    return _settled(a / b)


def _compared(compare: Callable[[Any, Any], Any]) -> Callable[[Any, Any], Any]:
    def compared(a: Number, b: Number) -> Number:
        if type(a) is not SX and type(b) is not SX:
            return compare(a, b)
        found = compare(a, b)
        return bool(found) if found.is_constant() else found

    return compared


def _power(a: Number, b: Number) -> Number:
    return a**b if type(a) is not SX and type(b) is not SX else _settled(a**b)


BINARY: dict[type[ast.operator], Callable[[Number, Number], Number]] = {
    ast.Add: _add,
    ast.Sub: _subtract,
    ast.Mult: _multiply,
    ast.Div: _divide,
    ast.Pow: _power,
    ast.FloorDiv: operator.floordiv,
    ast.Mod: operator.mod,
}
"""The operators for two numbers."""

COMPARISONS: dict[type[ast.cmpop], Callable[[Number, Number], Number]] = {
    ast.Lt: _compared(operator.lt),
    ast.LtE: _compared(operator.le),
    ast.Gt: _compared(operator.gt),
    ast.GtE: _compared(operator.ge),
    ast.Eq: _compared(operator.eq),
    ast.NotEq: _compared(operator.ne),
}
"""The comparisons of two numbers. A symbol is equal to itself."""


def negated(value: Number) -> Number:
    """Return −x."""
    return -value


def opposite(value: Number) -> Number:
    """Return whether a condition is not true."""
    return casadi.logic_not(value) if type(value) is SX else not value


def _either(known: Callable[..., Any], symbolic: Callable[..., Any]) -> Callable[..., Number]:
    def function(*values: Number) -> Number:
        if any(type(value) is SX for value in values):
            return _settled(symbolic(*values))
        return known(*values)

    return function


def _root(x: float) -> float:
    return math.sqrt(x) if x >= 0.0 else math.nan


def _logarithm(x: float) -> float:
    if x > 0.0:
        return math.log(x)
    return -math.inf if x == 0.0 else math.nan


def _is_finite(value: Number) -> bool:
    """Tell whether a number is finite; a symbol is assumed to be."""
    return type(value) is SX or math.isfinite(value)


FUNCTIONS: dict[str, Callable[..., Number]] = {
    "atan": _either(math.atan, casadi.atan),
    "atan2": _either(math.atan2, casadi.atan2),
    "cos": _either(math.cos, casadi.cos),
    "exp": _either(math.exp, casadi.exp),
    "hypot": _either(math.hypot, lambda x, y: casadi.sqrt(x * x + y * y)),
    "isfinite": _is_finite,
    "log": _either(_logarithm, casadi.log),
    "sin": _either(math.sin, casadi.sin),
    "sqrt": _either(_root, casadi.sqrt),
    "tan": _either(math.tan, casadi.tan),
}
"""The functions of ``math`` that kernels call."""

_LEAST = _either(min, casadi.fmin)
_GREATEST = _either(max, casadi.fmax)


def least(first: Number, *others: Number) -> Number:
    """Return the least of numbers."""
    for other in others:
        first = _LEAST(first, other)
    return first


def greatest(first: Number, *others: Number) -> Number:
    """Return the greatest of numbers."""
    for other in others:
        first = _GREATEST(first, other)
    return first


def whole(value: Number) -> int:
    """Return the integer part of a number, which must be known.

    Raises
    ------
    TypeError
        If it depends on a symbol.
    """
    if type(value) is SX:
        raise TypeError("a whole number that depends on a symbol")
    return int(value)


def choice(condition: SX, one: Number, other: Number) -> Number:
    """Return one number if a condition is true, else the other; the unused one may be NaN."""
    if type(one) is SX and type(other) is SX and casadi.is_equal(one, other):
        return one
    if type(one) is not SX and type(other) is not SX and one == other:
        return one
    return _settled(casadi.if_else(condition, one, other))


CALLS: dict[str, Callable[..., Any]] = {
    "abs": _either(abs, casadi.fabs),
    "bool": lambda value: value if type(value) is SX else bool(value),
    "float": lambda value: value if type(value) is SX else float(value),
    "int": whole,
    "max": greatest,
    "min": least,
    "range": lambda *ends: range(*(whole(end) for end in ends)),
}
"""The built-in functions that kernels call."""
