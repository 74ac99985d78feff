"""Fuzzy numbers of any shape by their cuts, against pairs of points and closed forms."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fuzzy2.errors import InvalidValue, NotApplicable
from fuzzy2.numbers import (
    FuzzyNumber,
    GaussianNumber,
    IntervalNumber,
)
from fuzzy2.sets.shapes import Gaussian, Interval, Trapezoidal, Triangular
from fuzzy2.sets.sigmoids import Sigmoid
from fuzzy2.sets.smooth_shapes import Bell
from fuzzy2.sets.type1 import SampledSet
from tests import examples


@st.composite
def triangles(draw: st.DrawFn, positive: bool = False) -> Triangular:
    corners = sorted(draw(st.lists(st.integers(1 if positive else -8, 8), min_size=3, max_size=3)))
    return Triangular(*(k / 4.0 for k in corners))


OPERATIONS: dict[str, Callable[[Any, Any], Any]] = {
    "+": lambda a, b: a + b,
    "-": lambda a, b: a - b,
    "*": lambda a, b: a * b,
    "/": lambda a, b: a / b,
}


@pytest.mark.parametrize("sign", OPERATIONS)
@given(data=st.data())
@settings(max_examples=examples(150, of=4))
def test_cuts_of_results_hold_the_results_of_all_points_of_the_cuts(
    sign: str, data: st.DataObject
) -> None:
    """Both signs. 41 x 41 points of the cuts hold their corners, where the operations are extreme.

    The rest is rounding.
    """
    a = data.draw(triangles())
    b = data.draw(triangles(positive=sign == "/"))
    operation = OPERATIONS[sign]
    found = operation(FuzzyNumber.of(a), FuzzyNumber.of(b))
    for level in found.levels[[0, 30, 64, 100, 128]]:
        points = [np.linspace(*one.alpha_cut(level), 41) for one in (a, b)]
        images = operation(points[0][:, None], points[1][None, :])
        cut = found.interval(float(level))
        np.testing.assert_allclose(cut, [images.min(), images.max()], rtol=0.0, atol=1e-12)


@pytest.mark.parametrize("sign", OPERATIONS)
def test_memberships_against_sup_min_on_a_grid(sign: str) -> None:
    """The supremum over 2001 x 2001 pairs in cells of 0.01.

    There the steepest membership (3) moves by 0.03; twice that for steps.
    """
    a, b = Triangular(-1.0, 0.5, 2.0), Trapezoidal(1.0, 1.5, 2.0, 4.0)
    operation = OPERATIONS[sign]
    u, w = np.linspace(-1.0, 2.0, 2001), np.linspace(1.0, 4.0, 2001)
    images, grades = operation(u[:, None], w[None, :]), np.minimum(a(u)[:, None], b(w)[None, :])
    first = math.floor(images.min() * 100)
    cells = np.zeros(math.ceil(images.max() * 100) - first + 2)
    np.maximum.at(cells, np.rint(images * 100.0).astype(int) - first, grades)
    x = (first + np.arange(cells.size)) / 100.0
    found = operation(FuzzyNumber.of(a), FuzzyNumber.of(b))
    near = np.max([found(x + shift) for shift in np.linspace(-0.005, 0.005, 5)], axis=0)
    np.testing.assert_allclose(cells, near, rtol=0.0, atol=0.02)


@pytest.mark.parametrize(
    "denominator",
    [Triangular(-1.0, 0.5, 2.0), Triangular(0.0, 1.0, 2.0), Triangular(-2.0, -1.0, 0.0)],
)
def test_a_denominator_that_contains_zero_is_refused(denominator: Triangular) -> None:
    number = FuzzyNumber.of(Interval(1.0, 2.0))
    with pytest.raises(InvalidValue, match="does not contain 0"):
        _ = number / FuzzyNumber.of(denominator)
    with pytest.raises(InvalidValue, match="does not contain 0"):
        _ = 1.0 / FuzzyNumber.of(denominator)


def test_mixed_operands() -> None:
    number = FuzzyNumber.of(Triangular(1.0, 2.0, 4.0))
    x = np.linspace(-5.0, 10.0, 151)
    for found, expected in (
        (number + 1.0, Triangular(2.0, 3.0, 5.0)),
        (1.0 + number, Triangular(2.0, 3.0, 5.0)),
        (5.0 - number, Triangular(1.0, 3.0, 4.0)),
        (-2.0 * number, Triangular(-8.0, -4.0, -2.0)),
        (number / 2.0, Triangular(0.5, 1.0, 2.0)),
        (number - 1.0, Triangular(0.0, 1.0, 3.0)),
        (-number, Triangular(-4.0, -2.0, -1.0)),
        (number + IntervalNumber(1.5, 0.5), Trapezoidal(2.0, 3.0, 4.0, 6.0)),
        (number + Triangular(0.0, 1.0, 2.0), Triangular(1.0, 3.0, 6.0)),
    ):
        np.testing.assert_allclose(found(x), expected(x), rtol=0.0, atol=1e-12)
    reciprocal = 1.0 / number
    np.testing.assert_allclose(reciprocal.interval(0.0), [0.25, 1.0], rtol=1e-15)
    finer = number + FuzzyNumber.of(Triangular(0.0, 1.0, 2.0), levels=np.linspace(0.0, 1.0, 7))
    np.testing.assert_allclose(finer(x), Triangular(1.0, 3.0, 6.0)(x), rtol=0.0, atol=1e-12)
    for operation in OPERATIONS.values():
        with pytest.raises(TypeError):
            operation(number, "a")
        with pytest.raises(TypeError):
            operation("a", number)


def test_arrays_of_fuzzy_numbers() -> None:
    numbers = FuzzyNumber.of(IntervalNumber([[0.0], [4.0]], [1.0, 0.5, 0.0]))
    assert numbers.shape == (2, 3)
    assert (numbers * np.arange(3.0)).shape == (2, 3)
    np.testing.assert_allclose(numbers.defuzzify(), [[0.0] * 3, [4.0] * 3], atol=1e-15)
    np.testing.assert_allclose((numbers * numbers)[1, 0].interval(0.5), [9.0, 25.0])
    assert numbers[..., 0].shape == (2,)
    assert numbers[0].shape == (3,)
    assert numbers(np.zeros((5, 1, 1))).shape == (5, 2, 3)
    assert FuzzyNumber.of([1.0, 2.0]).shape == (2,)
    np.testing.assert_array_equal(FuzzyNumber.of([1.0, 2.0]).defuzzify(), [1.0, 2.0])
    np.testing.assert_array_equal(
        FuzzyNumber.of(2.0)(np.array([1.9, 2.0, np.nan])), [0.0, 1.0, np.nan]
    )
    assert numbers == FuzzyNumber(numbers.left, numbers.right, numbers.levels)
    assert numbers != numbers + 1.0
    assert numbers != 3.0


def test_gaussian_numbers_by_cuts_agree_with_theorem_1_5_for_the_minimum() -> None:
    """Between 129 levels the cuts are interpolated: within 2e-3 of the grade."""
    a, b = GaussianNumber(1.0, 0.3, "min"), GaussianNumber(2.0, 0.4, "min")
    exact = a - 2.0 * b
    by_cuts = FuzzyNumber.of(a) - 2.0 * FuzzyNumber.of(b)
    x = np.linspace(-6.0, 0.0, 601)
    np.testing.assert_allclose(by_cuts(x), exact(x), rtol=0.0, atol=2e-3)
    for level in by_cuts.levels[[5, 64, 120]]:
        np.testing.assert_allclose(
            by_cuts.interval(float(level)), exact.interval(float(level)), rtol=1e-13
        )
    assert float(by_cuts.defuzzify()) == pytest.approx(-3.0, abs=1e-13)
    with pytest.raises(NotApplicable, match="t_norm"):
        FuzzyNumber.of(GaussianNumber(1.0, 0.3))


@pytest.mark.parametrize(
    "one",
    [
        Gaussian(1.0, 0.4),
        Bell(1.0, 0.5, 4.0),
        Trapezoidal(0.0, 1.0, 1.5, 4.0),
        SampledSet([0, 1, 3], [0, 1, 0]),
    ],
)
def test_centroids_of_numbers_are_those_of_their_sets(one: Any) -> None:
    """Quadrature on the continuous domain against 129 cuts.

    Of these the lowest cut of an unbounded set is at 1e-6.
    """
    assert float(FuzzyNumber.of(one).defuzzify()) == pytest.approx(one.centroid(), abs=1e-3)


def test_what_is_no_fuzzy_number_is_refused() -> None:
    with pytest.raises(NotApplicable, match="does not reach"):
        FuzzyNumber.of(Triangular(0.0, 1.0, 2.0, height=0.5))
    with pytest.raises(NotApplicable, match="convex"):
        FuzzyNumber.of(SampledSet([0.0, 1.0, 2.0, 3.0, 4.0], [0.0, 1.0, 0.0, 1.0, 0.0]))
    with pytest.raises(NotApplicable, match="does not reach"):
        FuzzyNumber.of(Sigmoid(0.0, 1.0))
    with pytest.raises(NotApplicable, match="unbounded"):
        FuzzyNumber.of(Trapezoidal(-np.inf, -np.inf, 0.0, 1.0))
    with pytest.raises(InvalidValue, match="convex type-1 set"):
        FuzzyNumber.of("about 3")
    with pytest.raises(InvalidValue, match="nested"):
        FuzzyNumber([0.0, -1.0], [1.0, 1.0], [0.0, 1.0])
    with pytest.raises(InvalidValue, match="nested"):
        FuzzyNumber([0.0, 2.0], [3.0, 1.0], [0.0, 1.0])
    with pytest.raises(InvalidValue, match="ascending"):
        FuzzyNumber([0.0, 1.0], [3.0, 1.0], [0.5, 1.0])
    with pytest.raises(InvalidValue, match="as long as"):
        FuzzyNumber([0.0, 1.0], [3.0, 1.0])
    with pytest.raises(InvalidValue, match="finite"):
        FuzzyNumber([-np.inf, 1.0], [3.0, 1.0], [0.0, 1.0])
    with pytest.raises(InvalidValue, match="from 0 to 1"):
        FuzzyNumber.of(1.0).interval(1.5)
