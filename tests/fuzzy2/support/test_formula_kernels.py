"""Compiled formulas, beside NumPy's functions."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fuzzy2.support import formula_kernels
from fuzzy2.support.compiled import compiled
from fuzzy2.support.formula import _FUNCTIONS, Formula
from fuzzy2.support.formula_kernels import CODES, formula_at, left_out

SPECIAL = [0.0, -0.0, 1.0, -1.0, 0.5, -0.5, 1.5, 2.5, -2.5, 3.0, -0.3, 1e300, -1e300]
SPECIAL += [np.inf, -np.inf, np.nan]
PAIRS = np.array(
    [
        *((a, b) for a in SPECIAL for b in SPECIAL),
        *(3.0 * np.random.default_rng(0).normal(size=(300, 2))).tolist(),
    ]
)


@compiled
def run(program: Any, x: Any, stack: Any, out: Any) -> None:
    for i in range(out.size):
        out[i] = formula_at(program, 0, program.size, x, 2 * i, stack)


def both_ways(text: str) -> tuple[Any, Any]:
    """Return a formula at pairs by the loop, and by arrays."""
    formula = Formula(text)
    program, deepest = formula.program(["a", "b"])
    out = np.empty(len(PAIRS))
    run(np.array(program), PAIRS.ravel(), np.empty(deepest), out)
    right = formula.at({"a": PAIRS[:, 0], "b": PAIRS[:, 1]})
    return out, np.broadcast_to(right, out.shape)


def assert_alike(text: str) -> None:
    found, right = both_ways(text)
    # Libraries of mathematics round the last digit, or two, in their own ways.
    np.testing.assert_allclose(found, right, rtol=1e-15, atol=0.0, err_msg=text)


@pytest.mark.parametrize("name", [name for name, (count, _) in _FUNCTIONS.items() if count])
def test_functions_are_those_of_arrays(name: str) -> None:
    assert_alike(f"{name}(a)" if _FUNCTIONS[name][0] == 1 else f"{name}(a, b)")


@pytest.mark.parametrize(
    "text",
    [
        *("a + b", "a - b", "a * b", "a / b", "a % b", "a ^ b", "a and b", "a or b", "!a", "~a"),
        *("-a ^ 2", "2 * a ^ 2 - 3 * sin(b) / pi", "(a + b) * (a - b) / (1 + pow(a, 2))", "pi"),
    ],
)
def test_operators_are_those_of_arrays(text: str) -> None:
    assert_alike(text)


@pytest.mark.parametrize("name", ["round", "floor", "ceil"])
def test_whole_numbers_keep_the_sign_of_zero(name: str) -> None:
    found, right = both_ways(f"{name}(a)")
    number = ~np.isnan(right)
    np.testing.assert_array_equal(np.signbit(found[number]), np.signbit(right[number]))


texts = st.recursive(
    st.sampled_from(["a", "b", "2", "0.5", "pi"]),
    lambda below: st.one_of(
        st.tuples(below, st.sampled_from("+-*"), below).map(lambda t: f"({t[0]} {t[1]} {t[2]})"),
        st.tuples(st.sampled_from(["sin", "abs", "tanh", "floor"]), below).map(
            "{0[0]}({0[1]})".format
        ),
        st.tuples(below, below).map("max({0[0]}, {0[1]})".format),
    ),
    max_leaves=12,
)


@given(text=texts)
def test_random_formulas(text: str) -> None:
    inside = (abs(PAIRS) < 10.0).all(axis=1)
    found, right = (values[inside] for values in both_ways(text))
    # The floor of what rounding moves over a whole number.
    allowed = 1.0 if "floor" in text else 1e-9
    both = np.isfinite(found) & np.isfinite(right)
    assert both.mean() > 0.9
    size = max(abs(right[both]).max(), 1.0)
    assert abs(found - right)[both].max() <= allowed * size


def test_codes_are_in_order() -> None:
    for name, code in CODES.items():
        assert getattr(formula_kernels, name.upper()) == code
    assert len(CODES) == 43


def test_what_no_formula_needs_is_left_out() -> None:
    groups = ("_hyperbolic", "_trigonometric", "_exponential", "_power", "_compared")
    assert left_out([]) == groups
    assert "_trigonometric" not in left_out([Formula("sin(a)").program(["a"])[0]])
    # A number that happens to be a code is none.
    assert "_trigonometric" in left_out([Formula(f"a + {CODES['sin']}").program(["a"])[0]])
