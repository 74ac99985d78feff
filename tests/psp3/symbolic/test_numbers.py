"""Arithmetic on numbers and symbols; and what is said where CasADi is missing."""

from __future__ import annotations

import ast
import importlib
import math
import sys

import casadi
import numpy as np
import pytest

import psp3.symbolic
from psp3.errors import MissingPackage
from psp3.symbolic.numbers import BINARY, CALLS, COMPARISONS, FUNCTIONS, choice, is_symbol

X = casadi.SX.sym("x")


def value(entry: object, at: float) -> float:
    return float(casadi.Function("f", [X], [entry])(at))


@pytest.mark.parametrize("sign", [ast.Add, ast.Sub, ast.Mult, ast.Div])
@pytest.mark.parametrize("number", [0.0, 1.0, -2.5])
def test_symbols_combine_as_numbers_do(sign: type[ast.operator], number: float) -> None:
    combine = BINARY[sign]
    assert value(combine(X, 3.0), 0.7) == combine(0.7, 3.0)
    assert value(combine(number, X), 0.7) == combine(number, 0.7)
    if number != 0.0:
        assert value(combine(X, number), 0.7) == combine(0.7, number)


def test_what_depends_on_no_symbol_is_known() -> None:
    for known in (
        BINARY[ast.Mult](0.0, X),
        BINARY[ast.Sub](X, X),
        COMPARISONS[ast.Eq](X, X),
        CALLS["max"](1.0, 2.0),
    ):
        assert not is_symbol(known)
    assert COMPARISONS[ast.NotEq](X, X) is False
    assert BINARY[ast.Add](0.0, X) is X


def test_division_by_zero_is_that_of_the_kernels() -> None:
    divide = BINARY[ast.Div]
    assert divide(1.0, 0.0) == math.inf
    assert divide(1.0, -0.0) == -math.inf
    assert math.isnan(divide(0.0, 0.0))
    assert math.isnan(FUNCTIONS["sqrt"](-1.0))
    assert FUNCTIONS["log"](0.0) == -math.inf


@pytest.mark.parametrize("name", sorted(set(FUNCTIONS) - {"isfinite", "atan2", "hypot"}))
def test_functions_are_those_of_math(name: str) -> None:
    assert value(FUNCTIONS[name](X), 0.6) == pytest.approx(getattr(math, name)(0.6), rel=1e-15)


def test_the_least_of_numbers_and_symbols() -> None:
    assert value(CALLS["min"](X, 0.5, 2.0), 1.0) == 0.5
    assert value(CALLS["max"](X, 0.5), 1.0) == 1.0
    assert value(CALLS["abs"](X), -1.5) == 1.5
    with pytest.raises(TypeError, match="symbol"):
        CALLS["int"](X)
    with pytest.raises(TypeError, match="symbol"):
        CALLS["range"](X)


def test_what_is_not_chosen_may_be_anything() -> None:
    found = choice(X > 0.0, math.nan, X)
    assert value(found, -2.0) == -2.0
    assert np.isnan(value(found, 2.0))
    assert choice(X > 0.0, 3.0, 3.0) == 3.0


def test_without_casadi_the_error_says_how_to_get_it(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in [name for name in sys.modules if name.startswith("psp3.symbolic.")]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "casadi", None)
    with pytest.raises(
        MissingPackage, match=r"casadi cannot be imported.*pip install 'psp3\[symbolic\]'"
    ):
        psp3.symbolic.SymbolicRobot  # noqa: B018 (imported when it is asked for)
    with pytest.raises(MissingPackage):
        importlib.import_module("psp3.symbolic.controller")
