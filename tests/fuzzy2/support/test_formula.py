"""Formulas: what they are worth, how their parts bind, and what is no formula."""

from __future__ import annotations

import math
import pickle

import numpy as np
import pytest

from fuzzy2.errors import InvalidValue
from fuzzy2.support.formula import Formula

X = np.array([-1.5, 0.25, 0.5, 2.0, 7.0])
Y = np.array([3.0, -2.0, 0.5, 1.0, 0.125])

# Python's own operators and the mathematics library say what is right.
WORTH = [
    ("x - y - 1", lambda x, y: (x - y) - 1.0),
    ("x / y / 2", lambda x, y: (x / y) / 2.0),
    ("x+y*2", lambda x, y: x + y * 2.0),
    ("(x+y)*2e-1", lambda x, y: (x + y) * 0.2),
    ("2^3^0.5*x", lambda x, y: 2.0 ** (3.0**0.5) * x),
    ("~x^2", lambda x, y: (-x) ** 2),
    ("-x^2", lambda x, y: -(x**2)),
    (".-x**2 + .+y", lambda x, y: -(x**2) + y),
    ("2 * -x", lambda x, y: -2.0 * x),
    ("2^~x", lambda x, y: 2.0**-x),
    ("x % 2", lambda x, y: x % 2.0),
    ("fmod(x, 2)", lambda x, y: math.fmod(x, 2.0)),
    ("sin(x)/x", lambda x, y: math.sin(x) / x),
    ("pow(abs(x), y) + atan2(y, x)", lambda x, y: abs(x) ** y + math.atan2(y, x)),
    ("min(x, y) + 10 * max(x, y)", lambda x, y: min(x, y) + 10.0 * max(x, y)),
    ("lt(x, 0.5)+2*le(x, 0.5)", lambda x, y: (x < 0.5) + 2 * (x <= 0.5)),
    ("gt(x, 0.5)+2*ge(x, 0.5)", lambda x, y: (x > 0.5) + 2 * (x >= 0.5)),
    ("eq(x, 0.5)+2*neq(x, 0.5)", lambda x, y: (x == 0.5) + 2 * (x != 0.5)),
    ("lt(x, 1) and lt(y, 1) or gt(x, 5)", lambda x, y: float((x < 1.0 and y < 1.0) or x > 5.0)),
    ("!lt(x, 1) + 1", lambda x, y: float(x >= 1.0) + 1.0),
    ("exp(x)*pi", lambda x, y: math.exp(x) * math.pi),
    ("floor(x) + 10*ceil(x)", lambda x, y: math.floor(x) + 10 * math.ceil(x)),
    ("round(x)", lambda x, y: round(x)),
]


@pytest.mark.parametrize(("text", "by_hand"), WORTH, ids=[text for text, _ in WORTH])
def test_a_formula_is_worth_what_python_makes_of_it(text: str, by_hand: object) -> None:
    assert callable(by_hand)
    expected = [float(by_hand(x, y)) for x, y in zip(X.tolist(), Y.tolist(), strict=True)]
    np.testing.assert_allclose(Formula(text).at({"x": X, "y": Y}), expected, rtol=1e-14, atol=1e-15)


@pytest.mark.parametrize(
    "name",
    [
        *("acos", "acosh", "asin", "asinh", "atan", "atanh", "cos", "cosh", "exp", "fabs"),
        *("log", "log10", "log1p", "sin", "sinh", "sqrt", "tan", "tanh"),
    ],
)
def test_functions_of_one_number_are_those_of_mathematics(name: str) -> None:
    points = [1.25, 2.0, 3.5] if name == "acosh" else [0.125, 0.5, 0.875]
    expected = [getattr(math, name)(x) for x in points]
    np.testing.assert_allclose(Formula(f"{name}(x)")(np.array(points)), expected, rtol=1e-14)


def test_where_it_has_no_number_it_is_nan_or_infinite() -> None:
    assert np.isnan(Formula("sin(x)/x")(np.array([0.0]))).all()
    assert np.isnan(Formula("log(x)")(np.array([-1.0]))).all()
    assert np.isinf(Formula("1/x")(np.array([0.0]))).all()


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "at its end|near column"),
        ("x +", "numbers, names"),
        ("x y", "near column 3"),
        ("(x", "numbers, names"),
        ("x.__class__", "near column 2"),
        ("'x'", "near column 1"),
        ("eval(x)", "a function in a formula"),
        ("sin(x, 2)", "the arguments of sin"),
        ("pow(x)", "the arguments of pow"),
        ("1" * 10_001, "at most 10000 characters"),
    ],
)
def test_what_is_no_formula_is_refused(text: str, said: str) -> None:
    with pytest.raises(InvalidValue, match=said):
        Formula(text)


def test_a_name_without_a_value_is_refused() -> None:
    with pytest.raises(InvalidValue, match="one of x"):
        Formula("x + z").at({"x": X})


def test_names_and_numbers_and_equality() -> None:
    one = Formula("max(alpha,  2.5) * pi - 2.5e0/beta")
    assert one.names == {"alpha", "beta"}
    assert one.numbers == (2.5,)
    assert one == Formula("max(alpha, 2.5) * pi - 2.5e0/beta")
    assert pickle.loads(pickle.dumps(one)) == one


def test_a_deep_formula_needs_no_deep_stack() -> None:
    """4000 parentheses, more than Python's calls would bear; and it can be pickled."""
    deep = Formula("(" * 4000 + "x" + ")" * 4000)
    long = Formula("-" * 4000 + "x")
    for one in (deep, long, pickle.loads(pickle.dumps(long))):
        np.testing.assert_array_equal(one(X), X)
