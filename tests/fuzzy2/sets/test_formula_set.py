"""Sets by formula, against sets of other classes with the same membership."""

from __future__ import annotations

import numpy as np
import pytest

from fuzzy2 import Triangular
from fuzzy2.errors import InvalidValue
from fuzzy2.files.json_files import from_json, to_json
from fuzzy2.sets.formula_set import FormulaSet

ROOF = "max(0, 1 - fabs(x - 2)/0.5)"
X = np.linspace(-1.0, 5.0, 401)


def test_it_is_the_set_that_its_formula_says() -> None:
    made, other = FormulaSet(ROOF, 0.0, 4.0), Triangular(1.5, 2.0, 2.5)
    np.testing.assert_allclose(made(X), other(X), atol=1e-15)
    assert made.height == pytest.approx(1.0, abs=1e-9)
    np.testing.assert_allclose(made.maxima, (2.0, 2.0), atol=1e-8)
    np.testing.assert_allclose(made.alpha_cut(0.5), other.alpha_cut(0.5), atol=1e-12)
    assert made.is_convex()
    assert not made.is_cut
    assert from_json(to_json(made)) == made


def test_a_jump_at_a_number_of_the_formula_is_seen() -> None:
    """The formula is 1 only between two numbers that no grid of the range has in it."""
    narrow = FormulaSet("gt(x, 1.2345678)*lt(x, 1.2345679)", 0.0, 4.0)
    assert narrow.height == 1.0


def test_it_is_cut_off_at_0_and_1() -> None:
    made = FormulaSet("x", -1.0, 4.0)
    np.testing.assert_array_equal(made(X), np.clip(X, 0.0, 1.0))
    assert made.is_cut


@pytest.mark.parametrize(
    ("formula", "left", "right", "said"),
    [
        ("x*y", 0.0, 1.0, "x alone"),
        ("x +", 0.0, 1.0, "the formula"),
        ("1/x", -1.0, 1.0, "a number everywhere"),
        ("x", 1.0, 1.0, "two different numbers"),
        ("x", 2.0, 1.0, "ascending"),
    ],
)
def test_what_is_no_such_set(formula: str, left: float, right: float, said: str) -> None:
    with pytest.raises(InvalidValue, match=said):
        FormulaSet(formula, left, right)
