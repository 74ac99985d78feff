"""Calls in kernels: of other kernels, functions of ``math`` and built-in functions of Python."""

from __future__ import annotations

import ast
import math
from abc import ABC

from fuzzy2.export.arrays import Arrays
from fuzzy2.export.c_text import bare
from fuzzy2.export.frame import Known
from fuzzy2.export.values import BOOL, INT, REAL, Row, Scalar, Value

FUNCTIONS = frozenset(
    {
        *("sqrt", "exp", "expm1", "log", "log1p", "sin", "cos", "tan", "asin", "acos", "atan"),
        *("atan2", "sinh", "cosh", "tanh", "asinh", "acosh", "atanh", "hypot", "log10"),
        *("floor", "ceil", "copysign", "fabs", "pow"),
    }
)
"""Functions of ``math`` that have the same name in ``math.h``."""
TESTS = frozenset(("isfinite", "isnan", "isinf"))
OF_TWO = frozenset(("atan2", "hypot", "copysign", "pow"))
"""Functions of two numbers; all others take one number."""
TO_WHOLE = frozenset(("floor", "ceil"))
"""Functions that return whole numbers in Python, where zero has no sign."""


class Calls(Arrays, ABC):
    """Translates calls."""

    def called(self, node: ast.Call, known: Known) -> Value:
        """Translate a call."""
        if node.keywords or any(isinstance(argument, ast.Starred) for argument in node.args):
            raise self.refused(node, "arguments must be positional, and their number known")
        if isinstance(node.func, ast.Attribute):
            return self._method(node, node.func, known)
        if not isinstance(node.func, ast.Name):
            raise self.refused(node, "a kernel cannot make this call")
        name = node.func.id
        arguments = [self.expression(argument, known) for argument in node.args]
        function = self.source.names.get(name)
        if function is None:
            return self._built_in(node, name, arguments)
        if isinstance(function, type) and hasattr(function, "_fields"):
            if len(function._fields) != len(arguments):
                raise self.refused(node, f"{name} has {len(function._fields)} fields")
            pairs = zip(function._fields, arguments, strict=True)
            return self.record(function.__name__, list(pairs))
        if not callable(function) or isinstance(function, type):
            raise self.refused(node, f"{name} is not a kernel")
        code = getattr(getattr(function, "py_func", function), "__code__", None)
        # A function that is chosen by table checks its arguments itself.
        if code and not hasattr(function, "bodies") and code.co_argcount != len(arguments):
            raise self.refused(node, f"the number of arguments must be {code.co_argcount}")
        handed = [part if part.is_known else self.handed(part) for part in arguments]
        return self.program.call(function, handed)

    def _built_in(self, node: ast.Call, name: str, values: list[Value]) -> Value:
        if name in ("min", "max") and len(values) > 1:
            return self._extreme(node, name, values)
        if len(values) != 1:
            raise self.refused(node, f"{name} is not a kernel")
        value, number = values[0], self.program.precision.number
        if name == "len" and isinstance(value.type, Row):
            return self.size(value, 0)
        if not isinstance(value.type, Scalar):
            raise self.refused(node, "an array is used where a number is expected")
        if name == "abs":
            if value.type == REAL:
                return self._of_math("fabs", [value])
            if value.known is not None:
                return number(abs(value.known), INT)
            return Value(INT, f"{self.program.absolute()}({bare(value.code)})")
        if name in ("int", "round"):
            return self._whole(node, name, value)
        if name == "float":
            return self.cast(value, REAL)
        if name == "bool":
            return self.truth(value)
        raise self.refused(node, f"{name} is not a kernel")

    def _whole(self, node: ast.Call, name: str, value: Value) -> Value:
        """Translate ``int``, which truncates, and ``round``."""
        if value.known is not None:
            if not math.isfinite(value.known):
                raise self.refused(node, "a whole number must be finite")
            return self.program.precision.number(
                int(value.known) if name == "int" else round(value.known), INT
            )
        if value.type != REAL:
            return Value(INT, value.code)
        # Rounds to nearest, and to even in a tie, unless the program changes the rounding mode.
        code = value.code if name == "int" else self._of_math("rint", [value]).code
        return Value(INT, f"((int){code})")

    def truth(self, value: Value) -> Value:
        """Return whether a number differs from 0."""
        if value.type == BOOL:
            return value
        if value.known is not None:
            return self.program.precision.number(bool(value.known), BOOL)
        zero = self.cast(self.program.precision.number(0, INT), value.type)
        return Value(BOOL, f"({value.code} != {zero.code})")

    def _extreme(self, node: ast.Call, name: str, values: list[Value]) -> Value:
        """Translate ``min`` and ``max``, two numbers at a time, with Python's treatment of NaN."""
        best = values[0]
        for value in values[1:]:
            kind = self.common(node, best, value)
            if best.known is not None and value.known is not None and kind != REAL:
                chosen = min if name == "min" else max
                best = self.program.precision.number(chosen(best.known, value.known), INT)
                continue
            which = "real" if kind == REAL else "int"
            codes = ", ".join(bare(self.cast(part, kind).code) for part in (best, value))
            kind = REAL if kind == REAL else INT
            best = Value(kind, f"{self.program.extreme(name, which)}({codes})")
        return best

    def _method(self, node: ast.Call, function: ast.Attribute, known: Known) -> Value:
        if isinstance(function.value, ast.Name) and function.value.id not in known:
            module = self.source.names.get(function.value.id)
            if module is math:
                return self._mathematics(node, function.attr, known)
            if getattr(module, "__name__", "") == "numpy":
                if function.attr in ("empty", "zeros"):
                    return self.memory(node, function.attr == "zeros", known)
                raise self.refused(node, "a kernel cannot call this function of NumPy")
        whole = self.expression(function.value, known)
        if function.attr == "reshape" and isinstance(whole.type, Row):
            return self.reshaped(node, whole, known)
        raise self.refused(node, "a kernel cannot call this method of an array")

    def _mathematics(self, node: ast.Call, name: str, known: Known) -> Value:
        """Translate a function of ``math``."""
        values = [self.expression(argument, known) for argument in node.args]
        if name not in FUNCTIONS | TESTS:
            raise self.refused(node, "math.h does not have this function")
        if len(values) != (2 if name in OF_TWO else 1):
            raise self.refused(node, "the function has a different number of arguments")
        if name in TESTS:
            code = bare(self.cast(values[0], REAL).code)
            return Value(BOOL, f"({name}({code}) != 0)")
        found = self._of_math(name, values)
        if name in TO_WHOLE:
            zero = self.program.precision.number(0.0, REAL)
            return Value(REAL, f"({found.code} + {zero.code})")
        return found

    def _of_math(self, name: str, values: list[Value]) -> Value:
        codes = ", ".join(bare(self.cast(value, REAL).code) for value in values)
        return Value(REAL, f"{self.program.precision.function(name)}({codes})")
