"""The meet of Gaussian numbers, approximated by a Gaussian number."""

from __future__ import annotations

import math

import numpy as np
import pytest

from fuzzy2.errors import InvalidValue
from fuzzy2.numbers import (
    GaussianNumber,
    gaussian_meet,
    gaussian_meet_error,
)
from fuzzy2.operations.join_meet import meet
from fuzzy2.sets.shapes import Gaussian


def test_gaussian_meet_is_equation_1_30() -> None:
    m, s = np.array([0.5, 0.7, 0.9]), np.array([0.05, 0.06, 0.07])
    found = gaussian_meet(m, s)
    assert float(found.mean) == pytest.approx(0.5 * 0.7 * 0.9, rel=1e-15)
    variance = (0.05 * 0.7 * 0.9) ** 2 + (0.06 * 0.5 * 0.9) ** 2 + (0.07 * 0.5 * 0.7) ** 2
    assert float(found.sigma) == pytest.approx(math.sqrt(variance), rel=1e-14)
    batch = gaussian_meet(np.stack([m, m[::-1]]), 0.05)
    assert batch.shape == (2,)
    assert float(batch.sigma[0]) == pytest.approx(
        float(gaussian_meet(m, [0.05] * 3).sigma), rel=1e-15
    )
    # A mean of 0 must not divide.
    assert float(gaussian_meet([0.0, 0.5], [0.1, 0.2]).sigma) == pytest.approx(0.05, rel=1e-15)
    assert gaussian_meet([0.4], [0.1]) == GaussianNumber(0.4, 0.1)


@pytest.mark.parametrize(
    ("means", "sigmas", "error"),
    [([0.5, 0.7], [0.05, 0.05], 0.033), ([0.1, 0.2], [0.1, 0.15], 0.234)],
)
def test_gaussian_meet_is_an_approximation_of_known_error(
    means: list[float], sigmas: list[float], error: float
) -> None:
    """The errors of the errata, to the three digits given there.

    The exact meet is searched here once more, densely.
    """
    assert gaussian_meet_error(means, sigmas) == pytest.approx(error, abs=5e-4)
    theta = np.linspace(0.0, 1.0, 101)[1:]
    v = np.linspace(1e-6, 1.0, 20001)
    w = theta[:, None] / v
    f, g = Gaussian(means[0], sigmas[0]), Gaussian(means[1], sigmas[1])
    exact = np.where(w <= 1.0, f(v) * g(np.minimum(w, 1.0)), 0.0).max(axis=1)
    np.testing.assert_allclose(meet(f, g, t_norm="product")(theta), exact, rtol=0.0, atol=1e-5)
    assert np.abs(gaussian_meet(means, sigmas)(theta) - exact).max() == pytest.approx(
        error, abs=0.02
    )


def test_gaussian_meet_refuses_nonsense() -> None:
    for means, sigmas in (([], []), (0.5, 0.1), ([0.5], [-0.1])):
        with pytest.raises(InvalidValue):
            gaussian_meet(means, sigmas)
