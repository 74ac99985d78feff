"""Fuzzy numbers.

Theorems 1.4 and 1.5 against the extension principle on grids, arrays against loops, α-cuts against
enumeration.
"""

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
from fuzzy2.numbers import (
    FuzzyNumber,
    GaussianNumber,
    IntervalNumber,
)
from fuzzy2.sets.shapes import Gaussian, Interval, Trapezoidal, Triangular

Array = NDArray[np.float64]

COEFFICIENTS = st.floats(-3.0, 3.0, allow_subnormal=False).map(lambda x: round(x, 2))


# --- published vectors ----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("t_norm", "sigma"),
    [("product", 0.7211102550927978), ("min", 1.0)],
    ids=["gauss_sum_product_tnorm", "gauss_sum_min_tnorm"],
)
def test_published_affine_combination_of_gaussians(t_norm: Any, sigma: float) -> None:
    """Karnik and Mendel (2001), Theorem 1.5 of the thesis; 1e-12 as given with the vectors."""
    F, G = GaussianNumber(1.0, 0.3, t_norm), GaussianNumber(2.0, 0.4, t_norm)
    found = 2.0 * F - G + 0.5
    assert float(found.mean) == pytest.approx(0.5, abs=1e-12)
    assert float(found.sigma) == pytest.approx(sigma, abs=1e-12)


# --- theorems 1.4 and 1.5 against the extension principle -----------------------------------------


@given(coefficients=st.lists(COEFFICIENTS, min_size=3, max_size=3))
@settings(max_examples=200, deadline=None)
def test_affine_combinations_of_intervals_have_the_ends_of_all_combinations(
    coefficients: list[float],
) -> None:
    a, b, beta = coefficients
    found = a * IntervalNumber(1.0, 0.5) + IntervalNumber(-2.0, 0.25) * b + beta
    corners = [a * v + b * w + beta for v in (0.5, 1.5) for w in (-2.25, -1.75)]
    np.testing.assert_allclose(found.interval(), [min(corners), max(corners)], rtol=0.0, atol=1e-14)


@pytest.mark.parametrize("t_norm", ["product", "min"])
@given(a=COEFFICIENTS, b=COEFFICIENTS, beta=COEFFICIENTS)
@settings(max_examples=100, deadline=None)
def test_affine_combinations_of_gaussians_against_sup_star_on_a_grid(
    t_norm: Any, a: float, b: float, beta: float
) -> None:
    """For given theta the best v is searched on a grid of step 1.5e-3.

    The grid misses it by half a step at most.
    """
    a, b = (x if abs(x) > 0.1 else 0.5 for x in (a, b))
    found = a * GaussianNumber(1.0, 0.3, t_norm) + b * GaussianNumber(2.0, 0.4, t_norm) + beta
    v = np.linspace(-2.0, 4.0, 4001)
    f = np.exp(-0.5 * ((v - 1.0) / 0.3) ** 2)
    theta = np.linspace(
        float(found.mean) - 2.5 * float(found.sigma),
        float(found.mean) + 2.5 * float(found.sigma),
        11,
    )
    w = (theta[:, None] - beta - a * v) / b
    g = np.exp(-0.5 * ((w - 2.0) / 0.4) ** 2)
    supremum = (f * g if t_norm == "product" else np.minimum(f, g)).max(axis=1)
    # Under the product the grade is flat at the best v, with half of (1.55) as its curvature; under
    # the minimum the best v is at a crossing, where the grade has a slope of at most 2.1 in v and
    # 1.6 in w.
    curvature = 1.0 / 0.3**2 + (a / b / 0.4) ** 2
    tolerance = (
        0.5 * curvature * 0.75e-3**2 if t_norm == "product" else 1.5e-3 * (2.1 + 1.6 * abs(a / b))
    )
    np.testing.assert_allclose(found(theta), supremum, rtol=0.0, atol=tolerance)
    assert (found(theta) >= supremum - 1e-12).all()


@pytest.mark.parametrize("t_norm", ["product", "min"])
def test_the_order_of_additions_does_not_matter(t_norm: Any) -> None:
    rng = np.random.default_rng(0)
    numbers = GaussianNumber(rng.normal(size=6), rng.uniform(0.1, 1.0, 6), t_norm)
    one_by_one = numbers[0] + numbers[1] + numbers[2] + numbers[3] + numbers[4] + numbers[5]
    at_once = numbers.sum()
    np.testing.assert_allclose(float(one_by_one.sigma), float(at_once.sigma), rtol=1e-15)
    np.testing.assert_allclose(float(one_by_one.mean), float(at_once.mean), atol=1e-15)


def test_operands_do_not_interact() -> None:
    a = IntervalNumber(1.0, 0.5)
    assert a - a == IntervalNumber(0.0, 1.0)
    g = GaussianNumber(1.0, 3.0)
    assert (g - g).sigma == pytest.approx(3.0 * math.sqrt(2.0), rel=1e-15)


# --- arrays ---------------------------------------------------------------------------------------

KINDS: dict[str, Callable[[Array, Array], Any]] = {
    "interval": IntervalNumber,
    "gaussian, product": lambda m, s: GaussianNumber(m, s, "product"),
    "gaussian, min": lambda m, s: GaussianNumber(m, s, "min"),
}

ALL_KINDS = pytest.mark.parametrize("make", KINDS.values(), ids=KINDS.keys())


def fields(number: Any) -> tuple[Array, Array]:
    return (
        (number.center, number.spread)
        if isinstance(number, IntervalNumber)
        else (number.mean, number.sigma)
    )


def assert_close(found: Any, expected: Any) -> None:
    """1e-14 is a few roundings of sums of three products of the order of 1."""
    assert found.shape == expected.shape
    for one, other in zip(fields(found), fields(expected), strict=True):
        np.testing.assert_allclose(one, other, rtol=0.0, atol=1e-14)


@ALL_KINDS
@pytest.mark.parametrize("batch", [(), (4,), (2, 5)])
def test_matrix_of_numbers_times_crisp_vector(
    make: Callable[[Array, Array], Any], batch: tuple[int, ...]
) -> None:
    rng = np.random.default_rng(1)
    A = make(rng.normal(size=(*batch, 2, 3)), rng.uniform(0.0, 1.0, (*batch, 2, 3)))
    v = rng.normal(size=(*batch, 3))
    found = A @ v
    assert found.shape == (*batch, 2)
    for index in np.ndindex(*batch):
        for row in range(2):
            element = (
                A[(*index, row, 0)] * v[(*index, 0)]
                + A[(*index, row, 1)] * v[(*index, 1)]
                + A[(*index, row, 2)] * v[(*index, 2)]
            )
            assert_close(found[(*index, row)], element)
    # One matrix for all vectors of the batch.
    assert_close(A[(0,) * len(batch)] @ v, make(*(one[(0,) * len(batch)] for one in fields(A))) @ v)


@ALL_KINDS
def test_crisp_matrix_times_vector_of_numbers(make: Callable[[Array, Array], Any]) -> None:
    rng = np.random.default_rng(2)
    z, B = make(rng.normal(size=(4, 3)), rng.uniform(0.0, 1.0, (4, 3))), rng.normal(size=(2, 3))
    found = B @ z
    assert found.shape == (4, 2)
    for k in range(4):
        for row in range(2):
            assert_close(found[k, row], (z[k] * B[row]).sum())
    assert_close(B[0] @ z[0], found[0, 0])
    assert_close(z[0] @ B[0], found[0, 0])
    assert_close(z @ B[1], found[:, 1])


@ALL_KINDS
def test_arithmetic_with_crisp_arrays_broadcasts(make: Callable[[Array, Array], Any]) -> None:
    rng = np.random.default_rng(3)
    z, crisp = make(rng.normal(size=3), rng.uniform(0.0, 1.0, 3)), rng.normal(size=(2, 3))
    centers, widths = fields(z)
    wide = np.broadcast_to(widths, (2, 3))
    assert_close(z + crisp, make(centers + crisp, wide))
    assert_close(crisp + z, make(centers + crisp, wide))
    assert_close(z - crisp, make(centers - crisp, wide))
    assert_close(crisp - z, make(crisp - centers, wide))
    assert_close(z * crisp, make(centers * crisp, widths * np.abs(crisp)))
    assert_close(crisp * z, make(centers * crisp, widths * np.abs(crisp)))
    assert_close(z / crisp, make(centers / crisp, widths / np.abs(crisp)))
    assert_close(-z, make(-centers, widths))
    assert +z is z
    assert_close(z.sum(), z[0] + z[1] + z[2])
    assert_close((z + crisp).sum(axis=0), (z + crisp)[0] + (z + crisp)[1])
    np.testing.assert_array_equal((z * crisp).defuzzify(), centers * crisp)
    assert (z + crisp).ndim == 2
    assert len(z + crisp) == 2
    assert z.reshape(3, 1).shape == (3, 1)
    assert z[..., :2].shape == (2,)
    assert z != z + 1.0
    assert z != 3
    with pytest.raises(TypeError, match="single"):
        len(z[0])
    with pytest.raises(TypeError, match="unhashable"):
        hash(z)
    for operation in (
        lambda: z + "a",
        lambda: z - "a",
        lambda: z * "a",
        lambda: z / "a",
        lambda: z + object(),
    ):
        with pytest.raises(TypeError):
            operation()


def test_tiny_and_huge_widths_keep_their_digits() -> None:
    """Squares of 1e-200 are 0 and those of 1e200 infinite."""
    for scale in (1e-200, 1e200):
        found = GaussianNumber([0.0, 0.0], [3.0 * scale, 4.0 * scale]).sum()
        assert float(found.sigma) == pytest.approx(5.0 * scale, rel=1e-15)
    assert float(GaussianNumber([1.0, 2.0], [0.0, 0.0]).sum().sigma) == 0.0


def test_nan_marks_numbers_that_no_rule_gave() -> None:
    number = IntervalNumber([np.nan, 1.0], [np.nan, 0.5]) + 1.0
    assert np.isnan(number.center[0])
    np.testing.assert_array_equal(number(np.array([0.0, 2.5])), [np.nan, 1.0])
    assert np.isnan(GaussianNumber([np.nan, 1.0], [np.nan, 0.5]).sum().sigma)


def test_cuts_and_memberships() -> None:
    interval = IntervalNumber([0.0, 1.0], [0.5, 0.0])
    np.testing.assert_array_equal(interval.interval(), [[-0.5, 0.5], [1.0, 1.0]])
    np.testing.assert_array_equal(interval(np.array([[0.5], [1.0]])), [[1.0, 0.0], [0.0, 1.0]])
    gaussian = GaussianNumber([0.0, 1.0], [0.5, 0.0])
    cut = gaussian.interval(0.3)
    np.testing.assert_allclose(gaussian[0](cut[0]), 0.3, rtol=1e-14)
    np.testing.assert_array_equal(cut[1], [1.0, 1.0])
    np.testing.assert_array_equal(gaussian[1](np.array([1.0, 1.1, np.nan])), [1.0, 0.0, np.nan])
    np.testing.assert_allclose(
        gaussian[0](np.linspace(-1, 1, 9)), Gaussian(0.0, 0.5)(np.linspace(-1, 1, 9)), rtol=1e-15
    )
    assert IntervalNumber.from_ends([[1.0, 2.0]]) == IntervalNumber([1.5], [0.5])


def test_what_is_refused() -> None:
    a, g = IntervalNumber(1.0, 0.5), GaussianNumber(1.0, 0.5)
    with pytest.raises(InvalidValue, match="spread"):
        IntervalNumber(1.0, -0.5)
    with pytest.raises(InvalidValue, match="sigma"):
        GaussianNumber(1.0, [-0.5])
    with pytest.raises(UnknownName, match="product, min"):
        GaussianNumber(1.0, 0.5, "hamacher")  # type: ignore[arg-type]
    with pytest.raises(InvalidValue, match="ends"):
        IntervalNumber.from_ends([1.0, 2.0, 3.0])
    with pytest.raises(InvalidValue, match="denominator"):
        _ = a / np.array([1.0, 0.0])
    for operation in (
        lambda: a * a,
        lambda: a / a,
        lambda: g * g,
        lambda: a + g,
        lambda: g - a,
        lambda: g + GaussianNumber(0.0, 1.0, "min"),
    ):
        with pytest.raises(NotApplicable):
            operation()
    for operation in (lambda: a @ a, lambda: g.__rmatmul__(g)):
        with pytest.raises(NotApplicable, match="crisp"):
            operation()
    for shape in ((2,), (4, 2)):
        with pytest.raises(InvalidValue, match="shapes"):
            _ = IntervalNumber(np.ones((2, 3)), 1.0) @ np.ones(shape)
    with pytest.raises(InvalidValue, match="shapes"):
        _ = np.ones((2, 3)) @ IntervalNumber(np.ones(2), 1.0)
    for alpha in (0.0, 1.5, math.nan):
        with pytest.raises(InvalidValue, match="level"):
            g.interval(alpha)
    with pytest.raises(ValueError, match="read-only"):
        a.center[...] = 3.0


# --- α-cuts ---------------------------------------------------------------------------------------


def test_defuzzifying_last_differs_from_defuzzifying_first() -> None:
    """The triangle (0, 0, 1) plus the interval [0, 1]: 7/9 against 5/6.

    The sum is a trapezoid with corners 0, 0, 1, 2, of area 3/2 and moment 7/6; its cuts are linear,
    so that only rounding is left.
    """
    triangle, interval = (
        FuzzyNumber.of(Triangular(0.0, 0.0, 1.0)),
        FuzzyNumber.of(Interval(0.0, 1.0)),
    )
    last = float((triangle + interval).defuzzify())
    first = float(triangle.defuzzify() + interval.defuzzify())
    assert last == pytest.approx(7.0 / 9.0, abs=1e-14)
    assert first == pytest.approx(5.0 / 6.0, abs=1e-14)
    x = np.linspace(-0.5, 2.5, 61)
    np.testing.assert_allclose(
        (triangle + interval)(x), Trapezoidal(0.0, 0.0, 1.0, 2.0)(x), rtol=0.0, atol=1e-14
    )


def test_for_affine_numbers_it_makes_no_difference() -> None:
    """Chapter 5 claims this for intervals only.

    It holds for Gaussian numbers as well (Theorem 1.5).
    """
    rng = np.random.default_rng(4)
    v = rng.normal(size=3)
    for t_norm in ("product", "min"):
        A = GaussianNumber(rng.normal(size=(3, 3)), rng.uniform(size=(3, 3)), t_norm)
        np.testing.assert_allclose(
            (A @ v + 1.0).defuzzify(), A.defuzzify() @ v + 1.0, rtol=0.0, atol=1e-15
        )
