"""Expressions of kernels: numbers, operations, comparisons and choices."""

from __future__ import annotations

import ast
import math
import operator
import re
from abc import ABC
from collections.abc import Callable
from typing import Any

from fuzzy2.export.c_text import bare
from fuzzy2.export.calls import Calls
from fuzzy2.export.frame import Known
from fuzzy2.export.values import BOOL, INT, REAL, Record, Row, Scalar, Value

COMPARISONS: dict[type, tuple[str, Callable[[Any, Any], bool]]] = {
    ast.Lt: ("<", operator.lt),
    ast.LtE: ("<=", operator.le),
    ast.Gt: (">", operator.gt),
    ast.GtE: (">=", operator.ge),
    ast.Eq: ("==", operator.eq),
    ast.NotEq: ("!=", operator.ne),
}
SUMS: dict[type, str] = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*"}
NUMBERS = {"nan": math.nan, "inf": math.inf, "pi": math.pi, "e": math.e, "tau": math.tau}


class Expressions(Calls, ABC):
    """Translates expressions."""

    def expression(self, node: ast.expr, known: Known) -> Value:
        """Translate an expression."""
        match node:
            case ast.Constant(value=bool() | int() | float()):
                return self.program.precision.value_of("", node.value)
            case ast.Name(id=name):
                return self._variable(node, name, known)
            case ast.BinOp():
                return self._binary(node, known)
            case ast.UnaryOp(op=op, operand=operand):
                return self._unary(node, op, self.expression(operand, known))
            case ast.BoolOp():
                return self._logical(node, known)
            case ast.Compare():
                return self._comparison(node, known)
            case ast.IfExp():
                return self._choice(node, known)
            case ast.Subscript():
                return self.subscript(node, known)
            case ast.Attribute():
                return self._attribute(node, known)
            case ast.Call():
                return self.called(node, known)
            case ast.Tuple(elts=elts):
                parts = [self.expression(part, known) for part in elts]
                return self.record("tuple", [(f"f{i}", part) for i, part in enumerate(parts)])
        raise self.refused(node, "a kernel cannot contain this expression")

    def _variable(self, node: ast.AST, name: str, known: Known) -> Value:
        if name in known:
            return known[name]
        if name in self.variables:
            # The variable has a value in one of the branches that lead here.
            return self.unknown(node, name)
        thing = self.program.replaced.get(name, self.source.names.get(name))
        for kind, scalar in ((bool, BOOL), (int, INT), (float, REAL)):
            if isinstance(thing, kind):
                return self.program.precision.number(thing, scalar)
        if isinstance(thing, tuple) and hasattr(thing, "_fields"):
            return self.program.precision.value_of(name.lower(), thing)
        raise self.refused(node, f"{name} is not a number")

    def _attribute(self, node: ast.Attribute, known: Known) -> Value:
        if isinstance(node.value, ast.Name) and node.value.id not in known:
            module = self.source.names.get(node.value.id)
            if getattr(module, "__name__", "") in ("math", "numpy"):
                if node.attr not in NUMBERS:
                    raise self.refused(node, "math does not have this number")
                return self.program.precision.number(NUMBERS[node.attr], REAL)
        whole = self.expression(node.value, known)
        if isinstance(whole.type, Record):
            return self.field(whole, node.attr)
        if not isinstance(whole.type, Row):
            raise self.refused(node, "a number has no attributes")
        return self.shape(node, whole)

    # --------------------------------------------------------------------------------- numbers
    def _binary(self, node: ast.BinOp, known: Known) -> Value:
        left, right = self.expression(node.left, known), self.expression(node.right, known)
        if not (isinstance(left.type, Scalar) and isinstance(right.type, Scalar)):
            raise self.refused(node, "an operation on arrays must be a loop over their entries")
        if isinstance(node.op, ast.Pow):
            return self._power(node, left, right)
        if isinstance(node.op, ast.Div):
            left, right = self.cast(left, REAL), self.cast(right, REAL)
            return Value(REAL, f"({left.code} / {right.code})")
        if isinstance(node.op, ast.FloorDiv | ast.Mod):
            return self._whole_division(node, left, right)
        if type(node.op) not in SUMS:
            raise self.refused(node, "a kernel cannot contain this operation")
        sign = SUMS[type(node.op)]
        if REAL not in (left.type, right.type):
            return self.sum(sign, self.cast(left, INT), self.cast(right, INT))
        left, right = self.cast(left, REAL), self.cast(right, REAL)
        return Value(REAL, f"({left.code} {sign} {right.code})")

    def _whole_division(self, node: ast.BinOp, left: Value, right: Value) -> Value:
        if REAL in (left.type, right.type) and isinstance(node.op, ast.Mod):
            codes = bare(self.cast(left, REAL).code), bare(self.cast(right, REAL).code)
            return Value(REAL, f"{self.program.real_remainder()}({', '.join(codes)})")
        if REAL in (left.type, right.type):
            raise self.refused(node, "// and % need whole numbers")
        remainder = isinstance(node.op, ast.Mod)
        if left.known is not None and right.known:
            number = left.known % right.known if remainder else left.known // right.known
            return self.program.precision.number(number, INT)
        # C rounds toward zero, Python down.
        function = self.program.division("remainder" if remainder else "quotient")
        return Value(INT, f"{function}({left.code}, {right.code})")

    def _power(self, node: ast.BinOp, left: Value, right: Value) -> Value:
        exponent = right.known
        if left.type != REAL and right.type != REAL:
            if left.known is None or exponent is None or exponent < 0:
                raise self.refused(node, "a power of whole numbers must be known; take float(...)")
            return self.program.precision.number(left.known**exponent, INT)
        if right.type == REAL:
            return self._of_math("pow", [left, right])
        if exponent is None:
            raise self.refused(node, "a whole exponent must be known; take float(...)")
        code, factor, count = "", self.cast(left, REAL).code, abs(exponent)
        # Powers are computed by squaring, in the order in which numba multiplies.
        while count:
            if count & 1:
                code = f"({code} * {factor})" if code else factor
            count >>= 1
            if count:
                factor = f"({factor} * {factor})"
        one = self.program.precision.number(1.0, REAL)
        if exponent <= 0:
            return one if exponent == 0 else Value(REAL, f"({one.code} / {code})")
        return Value(REAL, code)

    def _unary(self, node: ast.AST, op: ast.unaryop, value: Value) -> Value:
        if not isinstance(value.type, Scalar):
            raise self.refused(node, "an operation on arrays must be a loop over their entries")
        if isinstance(op, ast.Not):
            if value.known is not None:
                return self.program.precision.number(not value.known, BOOL)
            return Value(BOOL, f"(!{value.code})")
        if isinstance(op, ast.UAdd):
            return value
        if not isinstance(op, ast.USub):
            raise self.refused(node, "a kernel cannot contain this operation")
        kind = REAL if value.type == REAL else INT
        if value.known is not None:
            return self.program.precision.number(-value.known, kind)
        return Value(kind, f"(-{value.code})")

    # ------------------------------------------------------------------------------- conditions
    def condition(self, node: ast.expr, known: Known) -> Value:
        """Translate a condition."""
        value = self.expression(node, known)
        if not isinstance(value.type, Scalar):
            raise self.refused(node, "a condition must be true or false")
        return self.truth(value)

    def _logical(self, node: ast.BoolOp, known: Known) -> Value:
        stops = isinstance(node.op, ast.Or)
        codes = []
        for part in node.values:
            value = self.expression(part, known)
            if value.type != BOOL:
                raise self.refused(node, "and and or need conditions, which are true or false")
            if value.known is None:
                codes.append(value.code)
            elif value.known == stops:
                # The lines before a comparison can be ignored, because it has no side effects.
                if not any(re.search(r"\w\(", code) for code in codes):
                    return self.program.precision.number(stops, BOOL)
                codes.append("1" if stops else "0")
                break
        if not codes:
            return self.program.precision.number(not stops, BOOL)
        if len(codes) == 1:
            return Value(BOOL, codes[0])
        return Value(BOOL, "(" + (" || " if stops else " && ").join(codes) + ")")

    def _comparison(self, node: ast.Compare, known: Known) -> Value:
        if isinstance(node.ops[0], ast.In | ast.NotIn):
            return self._membership(node, known)
        codes: list[str] = []
        left = self.expression(node.left, known)
        for i, (op, other) in enumerate(zip(node.ops, node.comparators, strict=True)):
            if type(op) not in COMPARISONS:
                raise self.refused(node, "a kernel cannot contain this comparison")
            sign, compare = COMPARISONS[type(op)]
            right = self.expression(other, known)
            if i + 1 < len(node.ops) and any(isinstance(n, ast.Call) for n in ast.walk(other)):
                raise self.refused(
                    node, "a chain would evaluate a call twice; give its value a name"
                )
            kind = self.common(node, left, right)
            if left.known is not None and right.known is not None:
                if not compare(left.known, right.known):
                    codes.append("0")
                    break
            elif sign == ">=" and right.known == math.inf and left.type == INT:
                # Whole numbers are always finite.
                codes.append("0")
                break
            else:
                codes.append(f"({self.cast(left, kind).code} {sign} {self.cast(right, kind).code})")
            left = right
        if not codes or codes[0] == "0":
            return self.program.precision.number(not codes, BOOL)
        return Value(BOOL, codes[0] if len(codes) == 1 else "(" + " && ".join(codes) + ")")

    def _membership(self, node: ast.Compare, known: Known) -> Value:
        """Translate ``a in (b, c)``, which is ``a == b or a == c``."""
        others = node.comparators[0]
        if not isinstance(others, ast.Tuple) or len(node.ops) > 1:
            raise self.refused(node, "a kernel cannot contain this comparison")
        equal: list[ast.expr] = [ast.Compare(node.left, [ast.Eq()], [one]) for one in others.elts]
        one_of: ast.expr = ast.BoolOp(ast.Or(), equal)
        if isinstance(node.ops[0], ast.NotIn):
            one_of = ast.UnaryOp(ast.Not(), one_of)
        return self.expression(ast.fix_missing_locations(ast.copy_location(one_of, node)), known)

    def _choice(self, node: ast.IfExp, known: Known) -> Value:
        test = self.condition(node.test, known)
        if test.known is not None:
            return self.expression(node.body if test.known else node.orelse, known)
        one, other = self.expression(node.body, known), self.expression(node.orelse, known)
        if isinstance(one.type, Row) and isinstance(other.type, Row):
            return self._chosen_row(node, test, one, other)
        if isinstance(node.body, ast.Tuple) and isinstance(node.orelse, ast.Tuple):
            if len(node.body.elts) != len(node.orelse.elts):
                raise self.refused(node, "tuples have different lengths")
            pairs = zip(node.body.elts, node.orelse.elts, strict=True)
            chosen = [self.expression(ast.IfExp(node.test, *pair), known) for pair in pairs]
            return self.record("tuple", [(f"f{i}", part) for i, part in enumerate(chosen)])
        kind = self.common(node, one, other)
        one, other = self.cast(one, kind), self.cast(other, kind)
        return Value(kind, f"({test.code} ? {one.code} : {other.code})")

    def _chosen_row(self, node: ast.IfExp, test: Value, one: Value, other: Value) -> Value:
        assert isinstance(one.type, Row)
        assert isinstance(other.type, Row)
        if one.type.item != other.type.item or len(one.type.shape) != len(other.type.shape):
            raise self.refused(node, "arrays have different types")
        same = tuple(
            a if a == b else None for a, b in zip(one.type.shape, other.type.shape, strict=True)
        )
        kind = Row(one.type.item, one.type.constant or other.type.constant, same)
        codes = [self.cast(self.handed(part), kind).code for part in (one, other)]
        return Value(kind, f"({test.code} ? {codes[0]} : {codes[1]})")
