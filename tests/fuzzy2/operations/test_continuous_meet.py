"""Meets and joins of functions by any continuous t-norm.

Against dense factorizations, Newton's method and closed forms.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from numpy.typing import NDArray

from fuzzy2.errors import NotApplicable
from fuzzy2.operations.join_meet import join, meet
from fuzzy2.operations.t_norms import t_conorm, t_norm
from fuzzy2.sets.derived import Truncated
from fuzzy2.sets.shapes import Gaussian, Interval, Trapezoidal, Triangular
from fuzzy2.sets.type1 import SampledSet, Type1Set
from tests.fuzzy2.operations.any_sets import convex_functions

Array = NDArray[np.float64]


def dense_meet(f: Type1Set, g: Type1Set, name: str, grades: str, theta: Array) -> Array:
    """Return a lower bound of the product meet.

    The best of 4001 factorizations, and (1.33) at 0.
    """
    norm = t_norm(grades)
    v = np.linspace(1e-9, 1.0, 4001)
    rows = []
    for target in theta:
        w = target / v
        rows.append(norm(f(v), np.where(w <= 1.0, g(np.minimum(w, 1.0)), 0.0)).max())
    expected = np.array(rows)
    f_0, g_0 = float(f(0.0)), float(g(0.0))
    u = np.linspace(0.0, 1.0, 4001)
    expected[theta == 0.0] = max(float(norm(f_0, g(u).max())), float(norm(f(u).max(), g_0)))
    return expected


@pytest.mark.slow
@pytest.mark.parametrize("grades", ["min", "product"])
@given(f=convex_functions(normal=False), g=convex_functions(normal=False))
@settings(max_examples=100, deadline=None)
def test_product_meet_of_functions_is_the_supremum_over_factorizations(
    grades: str, f: Type1Set, g: Type1Set
) -> None:
    """The dense search is a lower bound.

    It lags by the slope of the sets (up to 20) times its step of 2.5e-4.

    At vertical edges it may lag by anything, so there only the bound is checked.
    """
    theta = np.linspace(0.0, 1.0, 21)
    exact = meet(f, g, t_norm="product", grade_t_norm=grades, method="general")(theta)
    bound = dense_meet(f, g, "product", grades, theta)
    assert (exact >= bound - 1e-9).all()
    steep = any(
        isinstance(one, Interval | Truncated)
        or (isinstance(one, Triangular | Trapezoidal) and not slopes(one))
        for one in (f, g)
    )
    if not steep:
        assert (exact <= bound + 8e-3).all()


def slopes(polygon: Triangular | Trapezoidal) -> bool:
    a, b, c, d = (
        (polygon.left, polygon.peak, polygon.peak, polygon.right)
        if isinstance(polygon, Triangular)
        else (polygon.a, polygon.b, polygon.c, polygon.d)
    )
    return a < b and c < d


def test_product_meet_of_gaussians_against_newtons_method() -> None:
    """Equation 1.36: J(v) of (1.37) is minimized to 1e-13 by Newton's method from the peak of 1.40.

    The search promises 1e-8.
    """
    m1, s1, m2, s2 = 0.5, 0.06, 0.7, 0.05
    for theta in np.linspace(0.2, 0.55, 15):
        v = (theta * m2 * s1**2 + m1 * m1**2 * s2**2) / (m2**2 * s1**2 + m1**2 * s2**2)
        for _ in range(60):
            first = 2 * (v - m1) / s1**2 - 2 * (theta / v - m2) * theta / v**2 / s2**2
            second = (
                2 / s1**2
                + 2 * theta**2 / v**4 / s2**2
                + 4 * (theta / v - m2) * theta / v**3 / s2**2
            )
            v -= first / second
        expected = math.exp(-0.5 * (((v - m1) / s1) ** 2 + ((theta / v - m2) / s2) ** 2))
        found = meet(Gaussian(m1, s1), Gaussian(m2, s2), t_norm="product")(theta)
        assert found == pytest.approx(expected, abs=1e-12)


def test_product_meet_at_zero_and_outside_the_unit_interval() -> None:
    """Equations 1.33 and 1.35; memberships beyond [0, 1] do not exist."""
    found = meet(Gaussian(0.1, 0.1), Gaussian(0.2, 0.15), t_norm="product")
    assert found(0.0) == pytest.approx(
        max(math.exp(-0.5), math.exp(-0.5 * (0.2 / 0.15) ** 2)), abs=1e-15
    )
    np.testing.assert_array_equal(found(np.array([-0.1, 1.1, np.nan])), [0.0, 0.0, np.nan])
    assert found.support == (0.0, 1.0)
    beyond = meet(Gaussian(1.2, 0.1), Gaussian(1.0, 0.1), t_norm="product")
    assert beyond.height == pytest.approx(math.exp(-2.0), abs=1e-15)
    assert beyond(1.0) == pytest.approx(math.exp(-2.0), abs=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("grades", ["min", "product"])
@pytest.mark.parametrize("name", ["product", "lukasiewicz", "hamacher", "einstein"])
def test_meets_and_joins_by_other_norms_against_a_grid(name: str, grades: str) -> None:
    """All pairs of a grid of 801 x 801, in cells of 0.01.

    A step at the slope of 5 is 6.25e-3, which the grid may miss.
    """
    f, g = Triangular(0.2, 0.6, 0.8), Gaussian(0.7, 0.15)
    u = np.linspace(0.0, 1.0, 801)
    conorm = t_conorm({"product": "probabilistic"}.get(name, name))
    for found, combined in (
        (meet(f, g, t_norm=name, grade_t_norm=grades), t_norm(name)(u[:, None], u[None, :])),
        (join(f, g, t_conorm=conorm, grade_t_norm=grades), conorm(u[:, None], u[None, :])),
    ):
        cells = np.zeros(101)
        np.maximum.at(
            cells,
            np.rint(combined * 100.0).astype(int),
            t_norm(grades)(f(u)[:, None], g(u)[None, :]),
        )
        theta = np.arange(101) / 100.0
        best_near = np.max(
            [found(np.clip(theta + shift, 0.0, 1.0)) for shift in np.linspace(-0.005, 0.005, 11)],
            axis=0,
        )
        np.testing.assert_allclose(cells, best_near, rtol=0.0, atol=0.0064)


def test_three_sets_in_any_order_and_against_equal_thirds() -> None:
    """The intermediate table is within 1e-7, so two orders differ by less than 4e-7."""
    sets = [Gaussian(0.5, 0.05), Gaussian(0.7, 0.05), Gaussian(0.9, 0.05)]
    theta = np.linspace(0.0, 1.0, 101)
    results = [
        meet(*(sets[k] for k in order), t_norm="product")(theta)
        for order in ((0, 1, 2), (2, 1, 0), (1, 2, 0))
    ]
    np.testing.assert_allclose(results[0], results[1], rtol=0.0, atol=4e-7)
    np.testing.assert_allclose(results[0], results[2], rtol=0.0, atol=4e-7)
    # Three equal sets: near their peak the best factors are equal by symmetry.
    same = meet(*[Gaussian(0.8, 0.1)] * 3, t_norm="product")
    near = np.linspace(0.4, 0.6, 9)
    np.testing.assert_allclose(
        same(near), Gaussian(0.8, 0.1)(np.cbrt(near)) ** 3, rtol=0.0, atol=4e-7
    )
    # Under minimum grades it holds everywhere, and the cuts give it to rounding.
    lowest = meet(*[Gaussian(0.8, 0.1)] * 3, t_norm="product", grade_t_norm="min")
    theta = theta[theta > 0.01]
    np.testing.assert_allclose(
        lowest(theta), Gaussian(0.8, 0.1)(np.cbrt(theta)), rtol=0.0, atol=1e-12
    )


@pytest.mark.parametrize("grades", ["min", "product"])
def test_a_set_with_two_peaks_among_functions(grades: str) -> None:
    """Dense factorizations as the reference; slopes of 10 and their step give 5e-3."""
    two_peaks = SampledSet([0.0, 0.3, 0.5, 0.8, 1.0], [0.0, 1.0, 0.25, 0.75, 0.0])
    other = Gaussian(0.7, 0.1)
    found = meet(two_peaks, other, t_norm="product", grade_t_norm=grades)
    theta = np.linspace(0.0, 1.0, 41)
    bound = dense_meet(two_peaks, other, "product", grades, theta)
    assert (found(theta) >= bound - 1e-9).all()
    assert (found(theta) <= bound + 5e-3).all()
    assert not found.is_convex()
    assert found.height == 1.0
    with pytest.raises(NotApplicable, match="convex"):
        found.alpha_cut(0.5)
