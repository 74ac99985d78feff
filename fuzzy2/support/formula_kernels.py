"""Compiled formulas: programs for a stack machine, from :mod:`fuzzy2.support.formula`."""

from __future__ import annotations

import math

from fuzzy2.support.compiled import scalar

NUMBER, INPUT = 0, 1
"""Steps that push a number: the next number of the program, or the input with that number."""

ONE = (
    *("negative", "opposite", "abs", "fabs", "ceil", "floor", "round", "sqrt"),
    *("exp", "log", "log10", "log1p"),
    *("sin", "cos", "tan", "asin", "acos", "atan"),
    *("sinh", "cosh", "tanh", "asinh", "acosh", "atanh"),
)
"""Functions of one number in the order of their codes, the first of which is 2."""
TWO = (
    *("plus", "minus", "times", "over", "either", "both", "remainder", "raised", "fmod", "atan2"),
    *("max", "min", "eq", "neq", "ge", "gt", "le", "lt", "pow"),
)
"""Functions of two numbers in the order of their codes, which follow those of one."""
CODES = {name: code for code, name in enumerate((*ONE, *TWO), start=2)}
"""Codes of functions by name."""

(NEGATIVE, OPPOSITE, ABS, FABS, CEIL, FLOOR, ROUND, SQRT) = range(2, 10)
(EXP, LOG, LOG10, LOG1P, SIN, COS, TAN, ASIN, ACOS, ATAN) = range(10, 20)
(SINH, COSH, TANH, ASINH, ACOSH, ATANH, PLUS, MINUS, TIMES, OVER) = range(20, 30)
(EITHER, BOTH, REMAINDER, RAISED, FMOD, ATAN2, MAX, MIN, EQ, NEQ) = range(30, 40)
(GE, GT, LE, LT, POW) = range(40, 45)


@scalar
def truncated(a):
    """Return a number without its fraction; numba's own function returns 64-bit integers."""
    return math.copysign(abs(a) - abs(a) % 1.0, a) if math.isfinite(a) else a


@scalar
def floored(a):
    """Return the greatest whole number that is not above a number."""
    whole = truncated(a)
    return whole - 1.0 if whole > a else whole


@scalar
def rounded(a):
    """Return the nearest whole number, and the even one of two."""
    whole = truncated(a)
    rest = abs(a - whole)
    if rest > 0.5 or (rest == 0.5 and abs(whole) % 2.0 != 0.0):
        whole += math.copysign(1.0, a)
    return whole


@scalar
def _whole(code, a):
    """Evaluate functions that every processor has."""
    if code == NEGATIVE:
        return -a
    if code == OPPOSITE:
        return 1.0 if a == 0.0 else 0.0
    if code == CEIL:
        return -floored(-a)
    if code == FLOOR:
        return floored(a)
    if code == ROUND:
        return rounded(a)
    return math.sqrt(a) if code == SQRT else abs(a)


@scalar
def _exponential(code, a):
    """Evaluate the exponential function and logarithms."""
    if code == EXP:
        return math.exp(a)
    if code == LOG:
        return math.log(a)
    return math.log10(a) if code == LOG10 else math.log1p(a)


@scalar
def _trigonometric(code, a):
    """Evaluate trigonometric functions."""
    if code == SIN:
        return math.sin(a)
    if code == COS:
        return math.cos(a)
    if code == TAN:
        return math.tan(a)
    if code == ASIN:
        return math.asin(a)
    return math.acos(a) if code == ACOS else math.atan(a)


@scalar
def _hyperbolic(code, a):
    """Evaluate hyperbolic functions."""
    if code == SINH:
        return math.sinh(a)
    if code == COSH:
        return math.cosh(a)
    if code == TANH:
        return math.tanh(a)
    if code == ASINH:
        return math.asinh(a)
    return math.acosh(a) if code == ACOSH else math.atanh(a)


@scalar
def _compared(code, a, b):
    """Evaluate comparisons, in which NaN equals itself."""
    equal = a == b or (a != a and b != b)
    if code == EQ:
        return 1.0 if equal else 0.0
    if code == NEQ:
        return 0.0 if equal else 1.0
    if code == GE:
        return 1.0 if a > b or equal else 0.0
    if code == GT:
        return 1.0 if a > b else 0.0
    if code == LE:
        return 1.0 if a < b or equal else 0.0
    return 1.0 if a < b else 0.0


@scalar
def _power(code, a, b):
    """Evaluate powers, angles of points, and remainders."""
    if code == ATAN2:
        return math.atan2(a, b)
    if code == REMAINDER:
        return a % b if b != 0.0 else math.nan
    if code == FMOD:
        return math.copysign(abs(a) % abs(b), a) if b != 0.0 else math.nan
    return math.pow(a, b)


@scalar
def _of_two(code, a, b):
    """Evaluate functions of two numbers."""
    if code == PLUS:
        return a + b
    if code == MINUS:
        return a - b
    if code == TIMES:
        return a * b
    if code == OVER:
        return a / b
    if code == EITHER:
        return 1.0 if a != 0.0 or b != 0.0 else 0.0
    if code == BOTH:
        return 1.0 if a != 0.0 and b != 0.0 else 0.0
    if code == MAX:
        return a if a >= b or a != a else b
    if code == MIN:
        return a if a <= b or a != a else b
    if EQ <= code <= LT:
        return _compared(code, a, b)
    return _power(code, a, b)


@scalar
def formula_at(program, start, stop, x, xo, stack):
    """Return the result of the steps from ``start`` to ``stop`` for the inputs from ``xo`` on."""
    top, step = -1, start
    while step < stop:
        code = int(program[step])
        step += 1
        if code == NUMBER:
            top += 1
            stack[top] = program[step]
            step += 1
        elif code == INPUT:
            top += 1
            stack[top] = x[xo + int(program[step])]
            step += 1
        elif code >= PLUS:
            top -= 1
            stack[top] = _of_two(code, stack[top], stack[top + 1])
        elif code >= SINH:
            stack[top] = _hyperbolic(code, stack[top])
        elif code >= SIN:
            stack[top] = _trigonometric(code, stack[top])
        elif code >= EXP:
            stack[top] = _exponential(code, stack[top])
        else:
            stack[top] = _whole(code, stack[top])
    return stack[0]


def left_out(programs: list[list[float]]) -> tuple[str, ...]:
    """Return the names of the functions in this module that no program needs."""
    used: set[int] = set()
    for program in programs:
        step = 0
        while step < len(program):
            used.add(int(program[step]))
            step += 2 if program[step] <= INPUT else 1
    groups = {
        "_hyperbolic": range(SINH, PLUS),
        "_trigonometric": range(SIN, SINH),
        "_exponential": range(EXP, SIN),
        "_power": (REMAINDER, RAISED, FMOD, ATAN2, POW),
        "_compared": range(EQ, POW),
    }
    return tuple(name for name, codes in groups.items() if used.isdisjoint(codes))
