"""Unions on grids, beside sums that are written out."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import fuzzy2

SETS = [fuzzy2.Triangular(0.0, 1.0, 3.0), fuzzy2.Gaussian(4.0, 0.7), fuzzy2.Bell(2.0, 0.5, 2.0)]
T_NORMS: dict[str, Any] = {
    "min": np.minimum,
    "product": np.multiply,
    "hamacher": lambda a, b: a * b / (a + b - a * b + 1e-300),
    "einstein": lambda a, b: a * b / (2.0 - (a + b - a * b)),
}
T_CONORMS: dict[str, Any] = {
    "max": np.maximum,
    "sum": np.add,
    "probabilistic": lambda a, b: a + b - a * b,
    "lukasiewicz": lambda a, b: np.minimum(a + b, 1.0),
}
STRENGTHS = np.random.default_rng(2).uniform(0.02, 1.0, (20, 3))


def system(kind: type = fuzzy2.Type1System, sets: Any = None, **options: Any) -> Any:
    terms = [[fuzzy2.Trapezoidal(0.0, 1.0, np.inf, np.inf)] for _ in range(3)]
    rules = np.where(np.eye(3, dtype=bool), 0, -1)
    options = {"type_reduction": "centroid", "integration": "sum", "resolution": 61} | options
    made = kind(
        terms, rules, [[item] for item in sets or SETS], output_ranges=[(0.0, 6.0)], **options
    )
    assert type(made.reducer).__name__ == "Sampled"
    return made


def union(points: Any, strengths: Any, norm: str, conorm: str) -> Any:
    each = [T_NORMS[norm](w, item(points)) for w, item in zip(strengths, SETS, strict=True)]
    return T_CONORMS[conorm](T_CONORMS[conorm](each[0], each[1]), each[2])


GRIDS: dict[str, Any] = {
    "sum": np.linspace(0.0, 6.0, 61),
    "trapezoidal": np.linspace(0.0, 6.0, 61),
    "midpoint": (np.arange(61) + 0.5) * 6.0 / 61.0,
    "left": np.arange(61) * 6.0 / 61.0,
}


@pytest.mark.parametrize("integration", GRIDS)
@pytest.mark.parametrize("norm", T_NORMS)
@pytest.mark.parametrize("conorm", T_CONORMS)
def test_centroids_are_sums(integration: str, norm: str, conorm: str) -> None:
    made = system(t_norm=norm, t_conorm=conorm, integration=integration)
    points = GRIDS[integration]
    for strengths in STRENGTHS:
        weights = union(points, strengths, norm, conorm)
        if integration == "trapezoidal":
            weights[[0, -1]] *= 0.5
        right = points @ weights / weights.sum()
        np.testing.assert_allclose(made(strengths), [right], rtol=1e-12)


@pytest.mark.parametrize("conorm", T_CONORMS)
def test_points_of_the_greatest_grade(conorm: str) -> None:
    points = GRIDS["sum"]
    for strengths in STRENGTHS:
        grades = union(points, strengths, "min", conorm)
        high = points[grades >= grades.max() * (1.0 - 1e-12)]
        for name, right in {
            "smallest_of_maxima": high[0],
            "middle_of_maxima": 0.5 * (high[0] + high[-1]),
            "mean_of_maxima": high.mean(),
            "largest_of_maxima": high[-1],
            "smallest_absolute_maximum": high[0],
            "largest_absolute_maximum": high[-1],
        }.items():
            found = system(t_norm="min", t_conorm=conorm, type_reduction=name)(strengths)
            np.testing.assert_allclose(found, [right], rtol=1e-14, err_msg=name)


@pytest.mark.parametrize("integration", ["sum", "left", "midpoint"])
def test_bisectors_have_half_of_the_weight_on_either_side(integration: str) -> None:
    points = GRIDS[integration]
    for strengths in STRENGTHS:
        weights = union(points, strengths, "min", "max")
        share = np.cumsum(weights) / weights.sum()
        nearest = (
            np.argmin(abs(share - 0.5)) if integration == "midpoint" else np.argmax(share >= 0.5)
        )
        found = system(t_norm="min", type_reduction="bisector", integration=integration)(strengths)
        np.testing.assert_allclose(found, [points[nearest]], rtol=1e-14)


@pytest.mark.parametrize("method", ["eiasc", "nie_tan", "wu_mendel", "begian_melek_mendel"])
def test_interval_type_2_sets_are_reduced_as_points(method: str) -> None:
    pairs = [fuzzy2.GaussianUncertainMean((m, m + 0.4), 0.6) for m in (1.0, 3.0, 5.0)]
    options = {"t_norm": "min", "method": method, "shares": (0.3, 0.7)}
    made = system(fuzzy2.IntervalType2System, pairs, **options)
    points = GRIDS["sum"]
    for strengths in STRENGTHS:
        low, high = (
            np.max(
                [
                    np.minimum(w, getattr(item, end)(points))
                    for w, item in zip(strengths, pairs, strict=True)
                ],
                axis=0,
            )
            for end in ("lower", "upper")
        )
        found = made.type_reduced(strengths)[0]
        weights = np.stack([low, high], axis=-1)
        if method == "nie_tan":
            right = fuzzy2.nie_tan(points, weights)
        elif method == "begian_melek_mendel":
            right = fuzzy2.begian_melek_mendel(points, weights, 0.3, 0.7)
        elif method == "wu_mendel":
            bounds = fuzzy2.wu_mendel_bounds(points, weights)
            left = 0.5 * (bounds.left_lower + bounds.left_upper)
            right = [left, 0.5 * (bounds.right_lower + bounds.right_upper)]
        else:
            right = fuzzy2.generalized_centroid(points, weights)
        np.testing.assert_allclose(found, np.broadcast_to(right, 2), rtol=1e-11)


def test_far_away_the_nearest_rule_answers_under_the_product() -> None:
    terms = [[fuzzy2.Gaussian(-1.0, 0.2), fuzzy2.Gaussian(1.0, 0.2)]]
    made = fuzzy2.Type1System(
        terms,
        [[0], [1]],
        [[SETS[0]], [SETS[1]]],
        type_reduction="centroid",
        integration="sum",
        output_ranges=[(0.0, 6.0)],
    )
    points = np.linspace(0.0, 6.0, 501)
    grades = SETS[1](points)
    assert made.coverage([[60.0]])[0] == 0.0
    np.testing.assert_allclose(made([[60.0]]), [[points @ grades / grades.sum()]], rtol=1e-12)
