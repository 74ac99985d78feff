"""Terms of every shape are the same for the compiled loop as in Python."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import fuzzy2
from fuzzy2.systems.firing_kernels import HEADER, TERM

POINTS = np.linspace(-1.5, 1.5, 13)
SHAPES: list[Any] = [
    fuzzy2.Gaussian(0.2, 0.5).sample(POINTS),
    fuzzy2.SampledSet([0.0], [0.7]),
    fuzzy2.Bell(0.1, 0.4, 2.5),
    fuzzy2.Sigmoid(-0.3, 4.0),
    fuzzy2.Sigmoid(0.3, -6.0),
    fuzzy2.PiShaped(-1.0, -0.2, 0.3, 1.4),
    fuzzy2.PiShaped(0.0, 0.5, np.inf, np.inf),
    fuzzy2.TwoSidedGaussian((-0.2, 0.3), (0.3, 0.6)),
    fuzzy2.TwoSidedGaussian((-0.2, 0.3), (0.3, np.inf)),
    fuzzy2.SigmoidDifference((-0.5, 0.5), (5.0, 6.0)),
    fuzzy2.SigmoidProduct((-0.5, 0.5), (5.0, -6.0)),
    fuzzy2.IntervalType2Set(fuzzy2.Triangular(-0.5, 0.0, 0.5, 0.8), fuzzy2.Triangular(-1, 0, 1)),
    fuzzy2.IntervalType2Set(fuzzy2.Bell(0.0, 0.3, 2.0), fuzzy2.Bell(0.0, 0.5, 2.0)),
    fuzzy2.IntervalType2Set(fuzzy2.Triangular(-0.5, 0.0, 0.5), fuzzy2.Triangular(-1, 0, 1)).sample(
        POINTS
    ),
]


@pytest.mark.parametrize("shape", SHAPES, ids=lambda shape: repr(shape)[:40])
def test_grades_of_the_loop_are_those_of_the_set(shape):
    other = fuzzy2.Trapezoidal(-9.0, -9.0, 9.0, 9.0)
    system = fuzzy2.IntervalType2System([[shape, other]], [[0], [1]], [[1.0], [2.0]])
    assert system.table is not None
    x = np.concatenate([np.linspace(-3.0, 3.0, 601), POINTS, [60.0, -1e4]])
    firing = system.firing(x[:, np.newaxis])[:, 0]
    right = np.stack([shape.lower(x), shape.upper(x)], axis=-1)
    # NumPy's exponentials and powers may be off by a rounding, and sigmoids take two of them.
    np.testing.assert_allclose(firing, right, rtol=4e-15, atol=1e-300)


PRINCIPALS = [
    fuzzy2.Gaussian(0.2, 0.5),
    fuzzy2.Gaussian(-0.3, 0.4, 0.7),
    fuzzy2.Triangular(-1.0, 0.0, 1.5),
    fuzzy2.Trapezoidal(-np.inf, -np.inf, 0.0, 1.0, 0.9),
]


@pytest.mark.parametrize("alpha", [0.0, 0.01, 0.6, 1.0])
@pytest.mark.parametrize("sigma", [0.0, 0.05, 0.4])
@pytest.mark.parametrize("principal", PRINCIPALS, ids=lambda item: type(item).__name__)
def test_planes_of_gaussian_type_2_sets_are_rows(principal, sigma, alpha):
    """Bounds are differences of numbers up to 1, of which each may be off by a rounding."""
    shape = fuzzy2.GaussianType2Set(principal, sigma).alpha_plane(alpha)
    system = fuzzy2.IntervalType2System([[shape]], [[0]], [[1.0]])
    assert system.table is not None
    x = np.concatenate([np.linspace(-3.0, 3.0, 601), [60.0, -1e4]])
    firing = system.firing(x[:, np.newaxis])[:, 0]
    right = np.stack([shape.lower(x), shape.upper(x)], axis=-1)
    np.testing.assert_allclose(firing, right, rtol=0.0, atol=3e-16)
    if sigma > 0.0 and alpha > 0.0:
        # By the equation, and not by the set itself.
        reach = sigma * np.sqrt(-2.0 * np.log(alpha))
        want = np.clip(principal(x)[:, np.newaxis] + [-reach, reach], 0.0, 1.0)
        np.testing.assert_allclose(firing, want, rtol=0.0, atol=3e-16)


def test_samples_stand_behind_the_table():
    system = fuzzy2.Type1System(
        [[SHAPES[0], fuzzy2.Gaussian(1.0, 0.3)]], [[0], [1]], [[1.0], [2.0]]
    )
    row = system.table[HEADER : HEADER + TERM]
    start, count = int(row[2]), int(row[3])
    np.testing.assert_array_equal(system.table[start : start + count], POINTS)
    assert start + 2 * count == len(system.table)
