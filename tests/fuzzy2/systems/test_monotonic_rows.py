"""Tsukamoto's averages, beside inverses in closed form."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import fuzzy2

STRENGTHS = np.random.default_rng(4).uniform(0.01, 0.99, (30, 2))


def system(sets: list[Any], **options: Any) -> Any:
    terms = [[fuzzy2.Trapezoidal(0.0, 1.0, np.inf, np.inf)] for _ in sets]
    rules = np.where(np.eye(len(sets), dtype=bool), 0, -1)
    made = fuzzy2.Type1System(
        terms, rules, [[item] for item in sets], type_reduction="tsukamoto", **options
    )
    assert type(made.reducer).__name__ == "Monotonics"
    return made


def test_ramps_are_inverted() -> None:
    rising = fuzzy2.Trapezoidal(1.0, 3.0, np.inf, np.inf)
    falling = fuzzy2.Trapezoidal(-np.inf, -np.inf, 4.0, 8.0)
    made = system([rising, falling])
    points = np.stack([1.0 + 2.0 * STRENGTHS[:, 0], 8.0 - 4.0 * STRENGTHS[:, 1]], axis=1)
    right = (points * STRENGTHS).sum(axis=1) / STRENGTHS.sum(axis=1)
    np.testing.assert_allclose(made(STRENGTHS)[:, 0], right, rtol=1e-12)


def test_sigmoids_are_inverted_also_near_1() -> None:
    made = system([fuzzy2.Sigmoid(2.0, 3.0)])
    for strength in (1e-12, 0.3, 1.0 - 1e-12):
        right = 2.0 + np.log(strength / (1.0 - strength)) / 3.0
        np.testing.assert_allclose(made([strength]), [right], rtol=1e-12)
    assert made([1.0])[0] == np.inf
    assert np.isnan(made([0.0])[0])


def test_samples_and_shapes_are_asked_too() -> None:
    points = np.linspace(0.0, 4.0, 9)
    sampled = fuzzy2.SampledSet(points, points / 4.0)
    smooth = fuzzy2.PiShaped(0.0, 2.0, np.inf, np.inf)
    made = system([sampled, smooth], output_ranges=[(0.0, 4.0)])
    found = made(STRENGTHS)[:, 0]
    low = STRENGTHS[:, 1] <= 0.5
    second = np.where(
        low, 2.0 * np.sqrt(STRENGTHS[:, 1] / 2), 2.0 - np.sqrt(2.0 - 2.0 * STRENGTHS[:, 1])
    )
    points = np.stack([4.0 * STRENGTHS[:, 0], second], axis=1)
    right = (points * STRENGTHS).sum(axis=1) / STRENGTHS.sum(axis=1)
    np.testing.assert_allclose(found, right, rtol=1e-9)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_grade_that_is_not_reached_within_the_range_is_taken_at_its_end(sign: float) -> None:
    made = system([fuzzy2.Sigmoid(0.0, sign)], output_ranges=[(-1.0, 1.0)])
    np.testing.assert_array_equal(made([[0.999], [0.001]]), [[sign], [-sign]])
