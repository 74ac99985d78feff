"""The extension principle against enumeration, and against what is known in closed form."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fuzzy2.errors import InvalidValue, NotApplicable
from fuzzy2.operations import extension
from fuzzy2.operations.extension import discrete_points, enumerated, extend
from fuzzy2.operations.t_norms import t_norm
from fuzzy2.sets.shapes import Gaussian, Interval, Trapezoidal, Triangular
from fuzzy2.sets.sigmoids import Sigmoid
from fuzzy2.sets.type1 import SampledSet, Singleton
from tests import examples


@st.composite
def integer_sets(draw: st.DrawFn) -> SampledSet:
    """Small integers as points, sixteenths as grades.

    Images are integers, so that equal ones are equal.
    """
    points = draw(st.lists(st.integers(-6, 6), min_size=1, max_size=6, unique=True))
    return SampledSet(points, [draw(st.integers(0, 16)) / 16.0 for _ in points])


FUNCTIONS: dict[str, Callable[..., Any]] = {
    "sum": lambda *x: sum(x),
    "greatest": lambda *x: np.maximum.reduce(x) if isinstance(x[0], np.ndarray) else max(x),
    "polynomial": lambda *x: x[0] ** 2 - sum(x[1:]) * x[0],
}


@pytest.mark.parametrize("name", FUNCTIONS)
@pytest.mark.parametrize("grades", ["min", "product", "lukasiewicz"])
@given(sets=st.lists(integer_sets(), min_size=1, max_size=3))
@settings(max_examples=examples(100, of=9))
def test_discrete_sets_are_enumerated(name: str, grades: str, sets: list[SampledSet]) -> None:
    f, norm = FUNCTIONS[name], t_norm(grades)
    expected: dict[float, float] = {}
    for pairs in itertools.product(
        *(list(zip(one.points, one.grades, strict=True)) for one in sets)
    ):
        image = float(f(*(float(point) for point, _ in pairs)))
        expected[image] = max(expected.get(image, 0.0), float(norm(*(grade for _, grade in pairs))))
    found = extend(f, *sets, t_norm=grades)
    np.testing.assert_array_equal(found.points, sorted(expected))
    np.testing.assert_array_equal(found.grades, [expected[point] for point in sorted(expected)])


def test_equation_1_8_maximizes_over_all_preimages() -> None:
    assert extend(
        np.square, SampledSet([-2.0, -1.0, 1.0, 2.0], [0.3, 1.0, 0.6, 0.8])
    ) == SampledSet([1.0, 4.0], [1.0, 0.8])


def test_singletons_are_crisp_arguments() -> None:
    assert extend(np.multiply, Singleton(2.0), SampledSet([1.0, 3.0], [0.5, 1.0])) == SampledSet(
        [2.0, 6.0], [0.5, 1.0]
    )


def test_images_within_1e_12_are_one() -> None:
    found = extend(np.add, SampledSet([0.1, 0.15], [0.4, 1.0]), SampledSet([0.2, 0.15], [0.5, 0.3]))
    assert found.points.size == 3  # 0.25, 0.3 in two ways that differ by rounding, 0.35
    np.testing.assert_array_equal(found.grades, [0.3, 0.4, 0.5])


def test_large_enumerations_are_done_in_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(1)
    operands = [(np.arange(30.0) * scale, rng.uniform(size=30)) for scale in (1.0, 2.0, 3.0)]
    at_once = enumerated(lambda a, b, c: a + b - c, operands, t_norm("product"))
    monkeypatch.setattr(extension, "CHUNK", 2000)
    assert enumerated(lambda a, b, c: a + b - c, operands, t_norm("product")) == at_once


def gaussian_sum_error(grades: str, sigma: float) -> float:
    """Return the error of the sum of Gaussian sets (1, 0.3) and (2, 0.4) by Theorem 1.5."""
    found = extend(np.add, Gaussian(1.0, 0.3), Gaussian(2.0, 0.4), t_norm=grades)
    x = np.linspace(1.5, 4.5, 501)
    return float(np.abs(found(x) - Gaussian(3.0, sigma)(x)).max())


def test_sum_of_gaussians_under_both_t_norms() -> None:
    """Theorem 1.5. Interpolating 257 cuts costs h²μ''/8 < 5e-5.

    Sampling on 1024 x 1024 pairs about 1e-3, and the lower bound holds.
    """
    assert gaussian_sum_error("min", 0.7) < 5e-5
    assert gaussian_sum_error("product", 0.5) < 1e-3


def test_a_function_that_is_not_monotone_under_the_minimum() -> None:
    """The square of a triangle on [-1, 2].

    The cut at a is the square of [2a/2 - 1, 2 - 3a/2], known in closed form.
    """
    found = extend(np.square, Triangular(-1.0, 0.5, 2.0))
    levels = np.linspace(0.05, 0.95, 19)
    left, right = -1.0 + 1.5 * levels, 2.0 - 1.5 * levels
    inner = np.where(left < 0.0, 0.0, left**2)
    cut = found.alpha_cut(levels)
    np.testing.assert_allclose(cut[0], inner, rtol=0.0, atol=1e-4)
    np.testing.assert_allclose(cut[1], np.maximum(left**2, right**2), rtol=0.0, atol=1e-4)


def test_extrema_inside_the_box_are_found() -> None:
    """Rosenbrock's valley: the least value 0 at (1, 1) lies off the grid of the first search.

    Its images reach from 0 to the corner.
    """
    found = extend(
        lambda x, y: (1.0 - x) ** 2 + 100.0 * (y - x**2) ** 2,
        Interval(0.31, 1.57),
        Interval(-0.12, 1.93),
    )
    assert found.points[0] == pytest.approx(0.0, abs=1e-3)
    corners = [(1 - x) ** 2 + 100 * (y - x * x) ** 2 for x in (0.31, 1.57) for y in (-0.12, 1.93)]
    assert found.points[-1] == pytest.approx(max(corners), rel=1e-12)


@pytest.mark.parametrize("count", [1, 3, 4])
def test_other_numbers_of_functions(count: int) -> None:
    """Sums of equal triangles under the minimum are a triangle.

    Linear cuts are exact at every level.
    """
    found = extend(lambda *x: sum(x), *[Triangular(0.0, 1.0, 3.0)] * count)
    u = np.linspace(0.0, 3.0 * count, 97)
    np.testing.assert_allclose(
        found(u), Triangular(0.0, count, 3.0 * count)(u), rtol=0.0, atol=1e-9
    )


def test_sets_below_height_one_and_sets_that_are_not_convex() -> None:
    low = extend(lambda x: 2.0 * x, Triangular(0.0, 0.5, 1.0, height=0.5))
    assert low.height == 0.5
    two_peaks = SampledSet([0.0, 1.0, 2.0, 3.0, 4.0], [0.0, 1.0, 0.0, 0.5, 0.0])
    # a point of the sampled set, blurred a little
    mixed = extend(np.add, two_peaks, Gaussian(10.0, 0.01))
    for point, expected in ((11.0, 1.0), (12.0, 0.0), (13.0, 0.5), (11.5, 0.0)):
        assert mixed(point) == pytest.approx(expected, abs=0.05)


def test_an_interval_and_a_function_under_the_product() -> None:
    found = extend(np.add, Interval(0.0, 1.0), Triangular(0.0, 1.0, 2.0), t_norm="product")
    u = np.linspace(0.0, 3.0, 61)
    np.testing.assert_allclose(found(u), Trapezoidal(0.0, 1.0, 2.0, 3.0)(u), rtol=0.0, atol=0.012)


def test_what_cannot_be_extended_is_refused() -> None:
    with pytest.raises(InvalidValue, match="finite on the supports"):
        extend(lambda x: 1.0 / x, SampledSet([0.0, 1.0], [1.0, 1.0]))
    with pytest.raises(InvalidValue, match="returns their shape"):
        extend(lambda x: np.zeros(2), SampledSet([0.0, 1.0, 2.0], [1.0, 1.0, 1.0]))
    with pytest.raises(NotApplicable, match="does not fall to 0"):
        extend(np.square, Sigmoid(0.0, 1.0))
    with pytest.raises(InvalidValue, match="at least one"):
        extend(np.square)
    with pytest.raises(InvalidValue, match="type-1 sets"):
        extend(np.add, SampledSet([0.0], [1.0]), 3.0)  # type: ignore[arg-type]
    with pytest.raises(NotApplicable, match="not discrete"):
        discrete_points(Gaussian(0.0, 1.0))


def test_an_unbounded_set_counts_down_to_1e_6() -> None:
    found = extend(lambda x: x, Gaussian(0.0, 1.0))
    np.testing.assert_allclose(
        found.points[[0, -1]], np.array([-1, 1]) * math.sqrt(-2.0 * math.log(1e-6)), rtol=1e-12
    )
