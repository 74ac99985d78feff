"""T-norms and t-conorms: their laws, their known values, and what is refused."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from fuzzy2.errors import InvalidValue, NotApplicable, UnknownName
from fuzzy2.operations.t_norms import MINIMUM, PRODUCT, T_CONORMS, T_NORMS, TNorm, t_conorm, t_norm
from tests import examples

Array = NDArray[np.float64]

# Sixty-fourths: sums and differences of them are exact, so that a + b = 1 is hit often and jumps
# are on the right side.
GRADES = st.integers(0, 64).map(lambda k: k / 64.0)
NORMS = pytest.mark.parametrize("name", tuple(T_NORMS))
CONORMS = pytest.mark.parametrize("name", tuple(T_CONORMS))

# Written out once more, as scalar formulas in the way of the literature.
FORMULAS: dict[str, Callable[[float, float], float]] = {
    "min": min,
    "product": lambda a, b: a * b,
    "lukasiewicz": lambda a, b: max(a + b - 1.0, 0.0),
    "drastic": lambda a, b: min(a, b) if max(a, b) == 1.0 else 0.0,
    "nilpotent": lambda a, b: min(a, b) if a + b > 1.0 else 0.0,
    "hamacher": lambda a, b: 0.0 if a == b == 0.0 else a * b / (a + b - a * b),
    "einstein": lambda a, b: a * b / (2.0 - (a + b - a * b)),
}


@NORMS
@given(a=GRADES, b=GRADES, c=GRADES)
@settings(max_examples=examples(300, of=7))
def test_the_four_laws_of_t_norms_hold(name: str, a: float, b: float, c: float) -> None:
    """1e-14 is some tens of ulps, the rounding of at most four operations on numbers up to 1."""
    norm = t_norm(name)
    assert norm(a, 1.0) == a
    assert norm(1.0, a) == a
    assert norm(a, b) == norm(b, a)
    assert float(norm(norm(a, b), c)) == pytest.approx(float(norm(a, norm(b, c))), abs=1e-14)
    assert norm(a, b) <= norm(a, max(b, c)) + 1e-15
    assert norm(a, b) == pytest.approx(FORMULAS[name](a, b), abs=1e-15)


@CONORMS
@given(a=GRADES, b=GRADES, c=GRADES)
@settings(max_examples=examples(300, of=7))
def test_t_conorms_obey_their_laws_and_are_dual(name: str, a: float, b: float, c: float) -> None:
    conorm = t_conorm(name)
    assert conorm(a, 0.0) == a
    assert conorm(a, b) == conorm(b, a)
    assert float(conorm(conorm(a, b), c)) == pytest.approx(
        float(conorm(a, conorm(b, c))), abs=1e-14
    )
    assert conorm(a, b) <= conorm(a, max(b, c)) + 1e-15
    assert float(conorm(a, b)) == pytest.approx(
        1.0 - float(conorm.dual(1.0 - a, 1.0 - b)), abs=1e-14
    )


@NORMS
def test_every_t_norm_lies_between_the_drastic_one_and_the_minimum(name: str) -> None:
    a, b = np.meshgrid(np.linspace(0.0, 1.0, 65), np.linspace(0.0, 1.0, 65))
    assert (t_norm(name)(a, b) <= np.minimum(a, b) + 1e-16).all()
    assert (t_norm(name)(a, b) >= t_norm("drastic")(a, b) - 1e-16).all()


@NORMS
def test_identity_is_exact_for_tiny_grades(name: str) -> None:
    """A formula such as a + b - 1 would lose them."""
    tiny = np.array([5e-324, 1e-300, 1e-17])
    np.testing.assert_array_equal(t_norm(name)(tiny, 1.0), tiny)


@pytest.mark.parametrize("name", [*T_NORMS, *T_CONORMS])
def test_nan_stays_nan_and_shapes_broadcast(name: str) -> None:
    norm = T_NORMS.get(name) or t_conorm(name)
    combined = norm(np.array([[0.2], [np.nan], [1.0], [0.0]]), np.array([0.0, 0.3, 1.0]))
    assert combined.shape == (4, 3)
    assert np.isnan(combined[1]).all()
    assert np.isfinite(combined[[0, 2, 3]]).all()
    assert np.isnan(norm(1.0, np.nan))


def test_any_number_of_grades_is_combined() -> None:
    grades = np.array([[0.5, 0.25], [0.5, 1.0], [0.5, 0.5]])
    np.testing.assert_array_equal(t_norm("product")(*grades), [0.125, 0.125])
    np.testing.assert_array_equal(t_norm("product").reduce(grades, axis=0), [0.125, 0.125])
    np.testing.assert_array_equal(t_norm("min").reduce(grades), [0.25, 0.5, 0.5])
    assert t_norm("min")(0.25) == 0.25
    with pytest.raises(InvalidValue, match="at least one"):
        t_norm("min")()
    with pytest.raises(InvalidValue, match="at least one"):
        t_norm("min").reduce(np.empty((3, 0)))


def test_codes_of_the_kernels() -> None:
    assert t_norm("min").code == MINIMUM
    assert t_norm("product").code == PRODUCT
    with pytest.raises(NotApplicable, match="kernels know"):
        _ = t_norm("hamacher").code


@pytest.mark.parametrize("wrong", ["minimum!", 3, None])
def test_unknown_names_are_refused_with_the_known_ones(wrong: Any) -> None:
    with pytest.raises(UnknownName, match="lukasiewicz"):
        t_norm(wrong)
    with pytest.raises(UnknownName, match="probabilistic"):
        t_conorm(wrong)


def yager(a: Array, b: Array) -> Array:
    """Yager's t-norm of exponent 2."""
    return np.maximum(0.0, 1.0 - np.hypot(1.0 - a, 1.0 - b))


def test_a_function_that_is_a_t_norm_is_taken() -> None:
    norm = t_norm(yager)
    assert norm.name == "yager"
    assert norm.continuous
    assert norm(0.8, 0.7) == 1.0 - math.hypot(0.2, 0.3)
    assert t_norm(norm) is norm
    assert not TNorm("jumpy", yager, continuous=False).continuous


def test_a_function_that_is_a_t_conorm_is_taken_with_its_dual() -> None:
    conorm = t_conorm(lambda a, b: np.minimum(1.0, np.hypot(a, b)))
    assert t_conorm(conorm) is conorm
    assert conorm.dual(0.8, 0.7) == pytest.approx(1.0 - math.hypot(0.2, 0.3), abs=1e-15)


@pytest.mark.parametrize(
    ("function", "law"),
    [
        (lambda a, b: 0.5 * (a + b), "returns a for"),
        (lambda a, b: np.where(b == 1.0, a, np.where(a == 1.0, b, a * a * b)), "commutative"),
        (lambda a, b: np.where(np.maximum(a, b) == 1.0, np.minimum(a, b), 1.0), "non-decreasing"),
        (lambda a, b: a * b * (1.0 + 0.5 * (1.0 - a) * (1.0 - b)), "associative"),
        (lambda a, b: np.float64(0.0), "shape"),
        (lambda a, b: np.full(np.shape(a), np.nan), "returns a for"),
    ],
)
def test_a_function_that_is_no_t_norm_is_refused_with_the_law_it_breaks(
    function: Any, law: str
) -> None:
    with pytest.raises(InvalidValue, match=law):
        t_norm(function)


def test_a_function_that_is_no_t_conorm_is_refused() -> None:
    with pytest.raises(InvalidValue, match=r"\(a, 0\)"):
        t_conorm(np.multiply)


def test_hamachers_product_of_tiny_grades_is_half_of_them() -> None:
    """Their product is no float; 1/a and 1/b add up."""
    hamacher = T_NORMS["hamacher"]
    np.testing.assert_allclose(
        hamacher([1e-200, 1e-200, 0.0], [1e-200, 3e-200, 0.0]),
        [0.5e-200, 0.75e-200, 0.0],
        rtol=1e-15,
    )
