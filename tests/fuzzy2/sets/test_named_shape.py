"""Shapes by name: their grades by other formulas, and what all sets must do."""

from __future__ import annotations

import math
import pickle

import numpy as np
import pytest

from fuzzy2 import NamedShape, from_json, to_json
from fuzzy2.errors import InvalidValue, UnknownName
from fuzzy2.sets.named_shape import SHAPES

X = np.linspace(-3.0, 9.0, 1201)


def sigmoid(x: np.ndarray, center: float, slope: float) -> np.ndarray:
    return 0.5 * (1.0 + np.tanh(0.5 * slope * (x - center)))


def circle(x: np.ndarray, center: float, radius: float) -> np.ndarray:
    """Return the height of a half circle over x, by the angle; 0 outside."""
    inside = np.abs(x - center) <= radius
    return np.where(inside, np.sin(np.arccos(np.clip((x - center) / radius, -1.0, 1.0))), 0.0)


CASES = {
    "arc": ((1.0, 4.0), np.where(X >= 4.0, 1.0, np.where(X >= 1.0, circle(X, 4.0, 3.0), 0.0))),
    "bell": ((2.0, 1.5, 2.0), 1.0 / (1.0 + ((X - 2.0) / 1.5) ** 4)),
    "binary": ((2.0, -math.inf), (X <= 2.0).astype(float)),
    "concave": ((2.0, 5.0), 1.0 / (1.0 + np.maximum(5.0 - X, 0.0) / 3.0)),
    "constant": ((0.25,), np.full_like(X, 0.25)),
    "cosine": ((3.0, 4.0), np.where(np.abs(X - 3.0) <= 2.0, np.cos(np.pi * (X - 3.0) / 4) ** 2, 0)),
    "discrete": (
        (1.0, 0.2, 3.0, 1.0, 4.0, 0.0),
        np.clip(np.minimum(0.2 + 0.4 * (np.maximum(X, 1.0) - 1.0), 4.0 - X), 0.0, 1.0),
    ),
    "gaussian_product": (
        (1.0, 0.5, 4.0, 2.0),
        np.exp(-2.0 * np.minimum(X - 1.0, 0.0) ** 2 - np.maximum(X - 4.0, 0.0) ** 2 / 8.0),
    ),
    "semi_ellipse": ((1.0, 5.0), circle(X, 3.0, 2.0)),
    "sigmoid": ((2.0, -3.0), sigmoid(X, 2.0, -3.0)),
    "sigmoid_difference": (
        (1.0, 4.0, 2.0, 5.0),
        np.abs(sigmoid(X, 1.0, 4.0) - sigmoid(X, 5.0, 2.0)),
    ),
    "sigmoid_product": ((1.0, 4.0, -2.0, 5.0), sigmoid(X, 1.0, 4.0) * sigmoid(X, 5.0, -2.0)),
    "spike": ((2.0, 4.0), np.exp(-2.5 * np.abs(X - 2.0))),
}


def test_every_shape_has_a_case() -> None:
    assert set(CASES) == set(SHAPES)


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("scale", [1.0, 0.5])
def test_grades(shape: str, scale: float) -> None:
    parameters, grades = CASES[shape]
    made = NamedShape(shape, parameters, scale)
    np.testing.assert_allclose(made(X), scale * grades, atol=1e-12)
    assert math.isnan(made(math.nan))
    left, right = made.support
    assert not made(X[(left > X) | (right < X)]).any()
    assert made.height == pytest.approx(scale * grades.max(), abs=2e-3)


@pytest.mark.parametrize("shape", SHAPES)
def test_they_are_kept_whole(shape: str) -> None:
    made = NamedShape(shape, CASES[shape][0], 0.5)
    made(X)
    for copy in (pickle.loads(pickle.dumps(made)), from_json(to_json(made))):
        assert copy == made
        np.testing.assert_array_equal(copy(X), made(X))


def test_what_is_refused() -> None:
    with pytest.raises(UnknownName, match="arc"):
        NamedShape("ark", (0.0, 1.0))
    for shape in SHAPES:
        with pytest.raises(InvalidValue):
            NamedShape(shape, (math.nan,))
        with pytest.raises(InvalidValue):
            NamedShape(shape, ())
        with pytest.raises(InvalidValue, match="scale"):
            NamedShape(shape, CASES[shape][0], 1.5)
