"""Bisectors and greatest grades of unions, beside what a fine grid and closed forms say."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import fuzzy2

FINE = np.linspace(-6.0, 6.0, 1_200_001)


def united(sets: list[Any], strengths: list[float], reduction: str, **options: Any) -> float:
    """Return what a system says whose rules fire as told."""
    terms = [[fuzzy2.Trapezoidal(0.0, 1.0, np.inf, np.inf)] for _ in sets]
    rules = np.where(np.eye(len(sets), dtype=bool), 0, -1)
    options.setdefault("output_ranges", [(-6.0, 6.0)])
    system = fuzzy2.Type1System(
        terms, rules, [[item] for item in sets], type_reduction=reduction, **options
    )
    assert type(system.reducer).__name__ == "Unions"
    return float(system(strengths)[0])


def grades(sets: list[Any], strengths: list[float], product: bool) -> Any:
    each = [
        strength * item(FINE) if product else np.minimum(strength, item(FINE))
        for item, strength in zip(sets, strengths, strict=True)
    ]
    return np.max(each, axis=0)


SETS = {
    "triangles": [fuzzy2.Triangular(-3.0, -2.0, 0.0), fuzzy2.Triangular(0.5, 2.0, 3.0)],
    "Gaussians": [fuzzy2.Gaussian(-2.0, 0.5), fuzzy2.Gaussian(1.5, 0.8, 0.9)],
    "trapezoids": [
        fuzzy2.Trapezoidal(-4.0, -3.5, -2.0, -1.0),
        fuzzy2.Trapezoidal(-2.5, -1.5, 1.0, 2.0, 0.8),
        fuzzy2.Trapezoidal(3.0, 4.0, np.inf, np.inf),
    ],
}


@pytest.mark.parametrize("norm", ["min", "product"])
@pytest.mark.parametrize("kind", SETS)
def test_points_of_a_fine_grid(kind: str, norm: str) -> None:
    rng = np.random.default_rng(len(kind))
    sets = SETS[kind]
    step = FINE[1] - FINE[0]
    for _ in range(10):
        strengths = rng.uniform(0.05, 1.0, len(sets)).tolist()
        union = grades(sets, strengths, norm == "product")
        area = np.cumsum(union)
        half = FINE[np.searchsorted(area, 0.5 * area[-1])]
        assert united(sets, strengths, "bisector", t_norm=norm) == pytest.approx(half, abs=2 * step)
        high = FINE[union >= union.max() * (1.0 - 1e-12)]
        for name, right in {
            "smallest_of_maxima": high[0],
            "largest_of_maxima": high[-1],
            "middle_of_maxima": 0.5 * (high[0] + high[-1]),
            "mean_of_maxima": high.mean(),
            "smallest_absolute_maximum": high[np.argmin(abs(high))],
        }.items():
            found = united(sets, strengths, name, t_norm=norm)
            # Beside a Gaussian's peak grades differ from it by less than rounding of 1e-12.
            assert found == pytest.approx(right, abs=2 * step), name


def test_plateaus_of_one_height_are_taken_together() -> None:
    sets = [fuzzy2.Trapezoidal(-4, -3, -1, 0), fuzzy2.Trapezoidal(2, 2.5, 3, 4)]
    strengths = [0.5, 0.5]
    # Cut at 1/2 they are 3 and 1.25 wide: from -3.5 to -0.5, and from 2.25 to 3.5.
    assert united(sets, strengths, "smallest_of_maxima", t_norm="min") == -3.5
    assert united(sets, strengths, "largest_of_maxima", t_norm="min") == 3.5
    assert united(sets, strengths, "middle_of_maxima", t_norm="min") == 0.0
    mean = (3.0 * -2.0 + 1.25 * 2.875) / 4.25
    assert united(sets, strengths, "mean_of_maxima", t_norm="min") == pytest.approx(mean, rel=1e-15)
    assert united(sets, strengths, "smallest_absolute_maximum", t_norm="min") == -0.5
    assert abs(united(sets, strengths, "largest_absolute_maximum", t_norm="min")) == 3.5


def test_plateaus_that_overlap_count_once() -> None:
    sets = [fuzzy2.Trapezoidal(-2, -1, 1, 2), fuzzy2.Trapezoidal(-1, 0, 3, 4)]
    assert united(sets, [1.0, 1.0], "mean_of_maxima", t_norm="min") == 1.0
    assert united(sets, [1.0, 1.0], "smallest_absolute_maximum", t_norm="min") == 0.0


def test_peaks_of_one_height_are_points() -> None:
    sets = [fuzzy2.Triangular(-2, -1, 0), fuzzy2.Triangular(1, 2, 3)]
    assert united(sets, [0.5, 0.5], "mean_of_maxima", t_norm="product") == 0.5
    assert united(sets, [0.5, 0.5], "middle_of_maxima", t_norm="product") == 0.5


def test_what_is_beyond_the_range_counts_for_nothing() -> None:
    """The peak at 2 is beyond the end at 1, where the slope has the grade 1/2."""
    sets = [fuzzy2.Triangular(0.0, 2.0, 4.0)]
    ends = [(-6.0, 1.0)]
    for strength in (1.0, 0.75, 0.25):
        found = united(sets, [strength], "smallest_of_maxima", t_norm="min", output_ranges=ends)
        assert found == (1.0 if strength > 0.5 else 0.5)
        assert united(sets, [strength], "largest_of_maxima", t_norm="min", output_ranges=ends) == 1


def test_however_little_a_set_fires_its_bisector_is_its_middle() -> None:
    sets = [fuzzy2.Triangular(1.0, 2.0, 3.0), fuzzy2.Triangular(-3.0, -2.0, -1.0)]
    for strength in (1.0, 1e-3, 1e-9, 1e-100):
        for norm in ("min", "product"):
            found = united(sets, [strength, 0.0], "bisector", t_norm=norm)
            assert found == pytest.approx(2.0, abs=1e-9)


def test_nothing_fires() -> None:
    sets = SETS["triangles"]
    for reduction in ("bisector", "mean_of_maxima"):
        assert np.isnan(united(sets, [0.0, 0.0], reduction))
        assert united(sets, [0.0, 0.0], reduction, default_outputs=[7.0]) == 7.0
