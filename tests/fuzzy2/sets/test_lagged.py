"""Sets scaled and begun later, as MATLAB's documentation describes lower membership functions."""

from __future__ import annotations

import numpy as np
import pytest

from fuzzy2.errors import InvalidValue
from fuzzy2.sets.derived import FunctionalSet
from fuzzy2.sets.lagged import Lagged
from fuzzy2.sets.shapes import Gaussian, Trapezoidal, Triangular
from fuzzy2.sets.sigmoids import Sigmoid
from fuzzy2.sets.smooth_shapes import Bell, PiShaped
from fuzzy2.sets.type1 import Type1Set

X = np.linspace(-4.0, 4.0, 321)


@pytest.mark.parametrize(
    ("whole", "middle"),
    [
        (Gaussian(0.5, 1.0), 0.5),
        (Bell(0.5, 1.0, 2.0), 0.5),
        (PiShaped(-2.0, 0.0, 1.0, 3.0), 0.5),
        (Triangular(-2.0, 0.5, 3.0), 0.5),
        (Sigmoid(0.0, 2.0), np.inf),
        (Sigmoid(0.0, -2.0), -np.inf),
    ],
)
def test_the_formula_of_the_documentation(whole: Type1Set, middle: float) -> None:
    """Scale (upper - lag) / (1 - lag), not below 0, with the lag of either side."""
    made = Lagged(whole, (0.2, 0.5), 0.8)
    lag = np.where(middle > X, 0.2, 0.5)
    expected = 0.8 * np.maximum((whole(X) - lag) / (1.0 - lag), 0.0)
    np.testing.assert_allclose(made(X), expected, rtol=1e-14, atol=1e-15)
    steps = 1e-6
    inside = (made(X - steps) > 1e-3) & (made(X) < 0.79)
    slopes = (made(X + steps) - made(X - steps)) / (2 * steps)
    kinks = np.isin(X, whole.landmarks)
    check = inside & ~kinks
    np.testing.assert_allclose(made.derivative(X)[check], slopes[check], atol=1e-6)


def test_a_triangle_lagged_is_a_narrower_triangle() -> None:
    """Straight sides keep the two readings of a lag apart from nothing: they are the same."""
    made, narrow = (
        Lagged(Triangular(-1.0, 0.0, 2.0), (0.25, 0.5), 0.6),
        Triangular(-0.75, 0.0, 1.0, 0.6),
    )
    np.testing.assert_allclose(made(X), narrow(X), atol=1e-15)
    assert made.support == narrow.support
    assert (made.height, made.maxima) == (narrow.height, narrow.maxima)
    alphas = np.linspace(0.05, 0.6, 12)
    np.testing.assert_allclose(made.alpha_cut(alphas), narrow.alpha_cut(alphas), atol=1e-12)


def test_a_lag_of_one_leaves_the_core() -> None:
    made = Lagged(Trapezoidal(0.0, 1.0, 2.0, 3.0), (1.0, 0.0))
    np.testing.assert_array_equal(made([0.5, 0.99, 1.0, 1.2, 2.5]), [0.0, 0.0, 1.0, 1.0, 0.5])


@pytest.mark.parametrize(
    ("whole", "lags", "scale", "said"),
    [
        (3.0, (0.0, 0.0), 1.0, "a type-1 set"),
        (Gaussian(0, 1), (0.0, 1.5), 1.0, "two numbers in"),
        (Gaussian(0, 1), (0.0,), 1.0, "two numbers in"),
        (Gaussian(0, 1), (0.0, 0.0), 0.0, "above 0, and at most 1"),
        (Gaussian(0, 1, 0.5), (0.5, 0.0), 1.0, "below the set's height"),
        (FunctionalSet(lambda x: x**2, -1.0, 1.0), (0.5, 0.0), 1.0, "a convex set"),
    ],
)
def test_what_is_refused(whole: Type1Set, lags: tuple[float, ...], scale: float, said: str) -> None:
    with pytest.raises(InvalidValue, match=said):
        Lagged(whole, lags, scale)
