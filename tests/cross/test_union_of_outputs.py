"""Centroid and center of sums by brute force.

The rules' outputs united by hand on a grid (eq. 1.72, 1.124), all switch points tried.

No function of the library takes part but the sets' memberships where they are triangles; Gaussians
are written out.
"""

from __future__ import annotations

import functools
import itertools
import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

import fuzzy2
from fuzzy2.sets.shapes import Triangular
from fuzzy2.systems import GeneralType2System, IntervalType2System

Array = NDArray[np.float64]
CENTERS, SIGMAS, NOISE = (-1.0, 0.2, 1.1), (0.4, 0.9), (0.15, 0.35)
RULES = np.array([[0, 0], [1, 2], [2, 1], [0, -1], [2, 2]])
RESOLUTION = 61
NORMS = {"product": lambda a, b: a * b, "min": np.minimum}
CONORMS = {
    "max": np.maximum,
    "probabilistic": lambda a, b: a + b - a * b,
    "lukasiewicz": lambda a, b: np.minimum(a + b, 1.0),
}


def triangle(x: Array, left: float, peak: float, right: float, height: float) -> Array:
    return height * np.clip(
        np.minimum((x - left) / (peak - left), (right - x) / (right - peak)), 0.0, 1.0
    )


def bell(distance: Array | float, sigma: float) -> Array:
    return np.exp(-0.5 * (np.asarray(distance) / sigma) ** 2)


def all_switch_points(points: Array, low: Array, high: Array) -> tuple[float, float]:
    """Return the least and the greatest average over all switch points, with exactly rounded sums.

    NaN for an empty set.
    """
    averages: tuple[list[float], list[float]] = ([], [])
    for k in range(points.size + 1):
        for end, (first, second) in enumerate(((high, low), (low, high))):
            weights = np.concatenate([first[:k], second[k:]])
            mass = math.fsum(weights)
            if mass > 0.0:
                averages[end].append(math.fsum(weights * points) / mass)
    return (
        (min(averages[0]), max(averages[1]))
        if averages[0] and averages[1]
        else (math.nan, math.nan)
    )


def unite(firing: Array, shapes: Array, norm: str, reduction: str, conorm: str = "max") -> Array:
    """Return the footprint (2, N) of the joined outputs of rules.

    The rules have firing intervals (R, 2) and consequents (R, 2, N).
    """
    outputs = []
    for (low, high), (lower, upper) in zip(firing, shapes, strict=True):
        outputs.append(np.stack([NORMS[norm](low, lower), NORMS[norm](high, upper)]))
    return (
        sum(outputs[1:], outputs[0])
        if reduction == "center_of_sums"
        else functools.reduce(CONORMS[conorm], outputs)
    )


def combine(grades: list[Array], norm: str) -> Array:
    """Return firing intervals (R, 2) of grades (terms, 2) of each input."""
    firing = np.ones((len(RULES), 2))
    for r, i in itertools.product(range(len(RULES)), range(2)):
        if RULES[r, i] >= 0:
            firing[r] = NORMS[norm](firing[r], grades[i][RULES[r, i]])
    return firing


def matches(x: float, norm: str, fuzzifier: str) -> Array:
    """Return the grades (terms, 2) of a measurement.

    Of Gaussian terms of uncertain width, by the closed form of the supremum.

    Two Gaussians at a distance d match to exp(-d²/2/(s² + t²)) under the product, to exp(-d²/2/(s +
    t)²) under the minimum.
    """
    grades = np.empty((3, 2))
    for term, end in itertools.product(range(3), range(2)):
        noise = 0.0 if fuzzifier == "singleton" else NOISE[end]
        width = math.hypot(SIGMAS[end], noise) if norm == "product" else SIGMAS[end] + noise
        grades[term, end] = bell(x - CENTERS[term], width)
    return grades


def random_consequents(
    rng: np.random.Generator,
) -> tuple[list[Any], list[tuple[tuple[float, ...], tuple[float, ...]]]]:
    """Return interval triangles for the rules, as sets and as numbers.

    The numbers are corners and heights of both membership functions.
    """
    sets, corners = [], []
    for peak in rng.uniform(-2.0, 2.0, len(RULES)):
        (left, right), (further_left, further_right) = (
            rng.uniform(0.2, 0.8, 2),
            rng.uniform(0.8, 1.6, 2),
        )
        low = (peak - left, peak, peak + right, rng.uniform(0.3, 0.9))
        high = (peak - further_left, peak, peak + further_right, 1.0)
        corners.append((low, high))
        sets.append(fuzzy2.IntervalType2Set(lower=Triangular(*low), upper=Triangular(*high)))
    return sets, corners


def grid_and_shapes(
    corners: list[tuple[tuple[float, ...], tuple[float, ...]]],
) -> tuple[Array, Array]:
    grid = np.linspace(
        min(high[0] for _, high in corners), max(high[2] for _, high in corners), RESOLUTION
    )
    return grid, np.array([[triangle(grid, *low), triangle(grid, *high)] for low, high in corners])


@pytest.mark.slow
@pytest.mark.parametrize("fuzzifier", ["singleton", "noise within bounds"])
@pytest.mark.parametrize(
    ("reduction", "conorm"), [*(("centroid", name) for name in CONORMS), ("center_of_sums", "max")]
)
@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), norm=st.sampled_from(["product", "min"]))
def test_interval_outputs_are_joined_and_reduced(
    fuzzifier: str, reduction: str, conorm: str, seed: int, norm: str
) -> None:
    """To 1e-12, with interval terms and consequents, and noise known within bounds.

    One rule leaves out an input.
    """
    rng = np.random.default_rng(seed)
    sets, corners = random_consequents(rng)
    terms = [fuzzy2.GaussianUncertainSigma(mean=c, sigma=SIGMAS) for c in CENTERS]
    noise = fuzzy2.SingletonFuzzifier()
    if fuzzifier != "singleton":
        noise = fuzzy2.NonSingletonFuzzifier(fuzzy2.GaussianUncertainSigma(mean=0.0, sigma=NOISE))
    system = IntervalType2System(
        [terms, terms],
        RULES,
        sets,
        norm,
        reduction,
        t_conorm=conorm,
        fuzzifier=noise,
        resolution=RESOLUTION,
        integration="sum",
        method=str(rng.choice(["km", "ekm", "iasc", "eiasc", "scan"])),
    )
    X = rng.uniform(-2.0, 2.0, (3, 2))
    grid, shapes = grid_and_shapes(corners)
    found = system.type_reduced(X)
    for x, interval in zip(X, found, strict=True):
        firing = combine([matches(value, norm, fuzzifier) for value in x], norm)
        expected = all_switch_points(grid, *unite(firing, shapes, norm, reduction, conorm))
        np.testing.assert_allclose(interval[0], expected, rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(system(X), found.mean(axis=-1), atol=1e-14)


@pytest.mark.parametrize("reduction", ["centroid", "center_of_sums"])
def test_the_join_counts_an_overlap_once_and_the_sum_twice(reduction: str) -> None:
    """Two rules of the same consequent and one beside it.

    The join does not see the second, the sum does; by hand, 1e-12.
    """
    crisp = [[fuzzy2.Gaussian(0.0, 1.0)]]
    same = fuzzy2.IntervalType2Set(
        lower=Triangular(-1.0, 0.0, 1.0, 0.5), upper=Triangular(-1.0, 0.0, 1.0)
    )
    other = fuzzy2.IntervalType2Set(
        lower=Triangular(1.0, 2.0, 3.0, 0.5), upper=Triangular(1.0, 2.0, 3.0)
    )
    twice = IntervalType2System(
        crisp,
        [[0], [0], [0]],
        [same, same, other],
        "product",
        reduction,
        resolution=5,
        integration="sum",
    )
    # On the grid -1, 0, 1, 2, 3 only the peaks carry weight: [1/2, 1] at 0, once or twice, and
    # [1/2, 1] at 2.
    weight = 1.0 if reduction == "centroid" else 2.0
    left = 2.0 * 0.5 / (0.5 + weight)
    right = 2.0 * 1.0 / (1.0 + 0.5 * weight)
    np.testing.assert_allclose(twice.type_reduced([0.0]), [[left, right]], atol=1e-12)


def blurred_planes(grades: Array, spread: float, alpha: float) -> Array:
    """Return the ends (..., 2) of the cuts at alpha of Gaussian slices about grades.

    They are cut off at 0 and 1.
    """
    reach = spread * math.sqrt(-2.0 * math.log(alpha))
    return np.stack([np.maximum(grades - reach, 0.0), np.minimum(grades + reach, 1.0)], axis=-1)


def by_alpha_planes(
    x: Array, grades: Any, corners: Any, grid: Array, norm: str, reduction: str
) -> Array:
    """Return the cuts (L, 2) by brute force.

    That of the interval case on every plane, from grades of terms and shapes per alpha.
    """
    cuts = []
    for alpha in (0.25, 0.5, 0.75, 1.0):
        firing = combine([grades(value, alpha) for value in x], norm)
        cuts.append(all_switch_points(grid, *unite(firing, corners(alpha), norm, reduction)))
    return np.array(cuts)


@pytest.mark.slow
@pytest.mark.parametrize("reduction", ["centroid", "center_of_sums"])
@settings(max_examples=8, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), norm=st.sampled_from(["product", "min"]))
def test_general_outputs_are_joined_plane_by_plane(reduction: str, seed: int, norm: str) -> None:
    """Gaussian slices of terms and of consequents, on four planes.

    The crisp output is their average by alpha; 1e-12.
    """
    rng = np.random.default_rng(seed)
    spread, width = rng.uniform(0.02, 0.15, 2)
    peaks = rng.uniform(-2.0, 2.0, len(RULES))
    terms = [
        fuzzy2.GaussianType2Set(principal=fuzzy2.Gaussian(c, 0.7), sigma=spread) for c in CENTERS
    ]
    sets = [
        fuzzy2.GaussianType2Set(
            principal=Triangular(p - 0.8, p, p + 1.1), sigma=width, domain=(p - 1.0, p + 1.3)
        )
        for p in peaks
    ]
    system = GeneralType2System(
        [terms, terms],
        RULES,
        sets,
        norm,
        reduction,
        levels=4,
        integration="sum",
        resolution=RESOLUTION,
    )
    grid = np.linspace(peaks.min() - 1.0, peaks.max() + 1.3, RESOLUTION)

    def grades(value: float, alpha: float) -> Array:
        return blurred_planes(np.array([bell(value - c, 0.7) for c in CENTERS]), spread, alpha)

    def shapes(alpha: float) -> Array:
        return np.array(
            [
                np.where(
                    (grid >= p - 1.0) & (grid <= p + 1.3),
                    blurred_planes(triangle(grid, p - 0.8, p, p + 1.1, 1.0), width, alpha).T,
                    0.0,
                )
                for p in peaks
            ]
        )

    x = rng.uniform(-2.0, 2.0, 2)
    expected = by_alpha_planes(x, grades, shapes, grid, norm, reduction)
    np.testing.assert_allclose(system.alpha_cuts(x)[0], expected, rtol=0.0, atol=1e-12)
    assert system(x)[0] == pytest.approx(expected.mean(axis=1) @ [0.1, 0.2, 0.3, 0.4], abs=1e-12)


@pytest.mark.parametrize("reduction", ["centroid", "center_of_sums"])
@pytest.mark.parametrize("norm", ["product", "min"])
@pytest.mark.parametrize("fuzzifier", ["singleton", "noise within bounds"])
def test_zslices_as_consequents_are_joined_on_one_grid(
    reduction: str, norm: str, fuzzifier: str
) -> None:
    """Nested triangles with zSlices terms of uncertain width.

    The inner planes are narrower than the grid of the output; 1e-12.
    """
    rng = np.random.default_rng(11)
    outer = [fuzzy2.GaussianUncertainSigma(mean=c, sigma=SIGMAS) for c in CENTERS]
    inner = [fuzzy2.GaussianUncertainSigma(mean=c, sigma=(0.6, 0.7)) for c in CENTERS]
    terms = [fuzzy2.ZSlices((0.5, 1.0), planes) for planes in zip(outer, inner, strict=True)]
    _, corners = random_consequents(rng)
    narrower = [
        (
            (low[0], low[1], low[2], 0.5 + 0.5 * low[3]),
            (0.5 * (high[0] + low[0]), high[1], 0.5 * (high[2] + low[2]), 1.0),
        )
        for low, high in corners
    ]
    planes = [
        [
            fuzzy2.IntervalType2Set(lower=Triangular(*low), upper=Triangular(*high))
            for low, high in level
        ]
        for level in (corners, narrower)
    ]
    sets = [fuzzy2.ZSlices((0.5, 1.0), pair) for pair in zip(*planes, strict=True)]
    noise = fuzzy2.SingletonFuzzifier()
    if fuzzifier != "singleton":
        noise = fuzzy2.NonSingletonFuzzifier(fuzzy2.GaussianUncertainSigma(mean=0.0, sigma=NOISE))
    system = GeneralType2System(
        [terms, terms],
        RULES,
        sets,
        norm,
        reduction,
        fuzzifier=noise,
        levels=2,
        resolution=RESOLUTION,
        integration="sum",
    )
    grid, _ = grid_and_shapes(corners)
    for x in rng.uniform(-2.0, 2.0, (10, 2)):
        cuts = []
        for widths, level in ((SIGMAS, corners), ((0.6, 0.7), narrower)):
            grades = np.empty((2, 3, 2))
            for i, t, end in np.ndindex(2, 3, 2):
                added = 0.0 if fuzzifier == "singleton" else NOISE[end]
                width = math.hypot(widths[end], added) if norm == "product" else widths[end] + added
                grades[i, t, end] = bell(x[i] - CENTERS[t], width)
            shapes = np.array(
                [[triangle(grid, *low), triangle(grid, *high)] for low, high in level]
            )
            cuts.append(
                all_switch_points(
                    grid, *unite(combine(list(grades), norm), shapes, norm, reduction)
                )
            )
        np.testing.assert_allclose(system.alpha_cuts(x)[0], cuts, rtol=0.0, atol=1e-12)
        assert cuts[0][0] <= cuts[1][0]
        assert cuts[1][1] <= cuts[0][1]


@pytest.mark.slow
@pytest.mark.parametrize("norm", ["product", "min"])
def test_general_terms_and_fuzzy_inputs_plane_by_plane(norm: str) -> None:
    """Terms and noise of Gaussian slices, suprema on grids that close in on the best point.

    1e-9, as the library's search has it.
    """
    rng = np.random.default_rng(12)
    sets, corners = random_consequents(rng)
    grid, fixed = grid_and_shapes(corners)
    terms = [
        fuzzy2.GaussianType2Set(principal=fuzzy2.Gaussian(c, 0.7), sigma=0.06) for c in CENTERS
    ]
    noise = fuzzy2.GaussianType2Set(principal=fuzzy2.Gaussian(0.0, 0.3), sigma=0.04)
    system = GeneralType2System(
        [terms, terms],
        RULES,
        sets,
        norm,
        "centroid",
        fuzzifier=fuzzy2.NonSingletonFuzzifier(noise),
        levels=4,
        resolution=RESOLUTION,
        integration="sum",
    )

    def grades(value: float, alpha: float) -> Array:
        found = np.empty((3, 2))
        for t, end in np.ndindex(3, 2):
            left, right = -6.0, 6.0
            for _ in range(7):
                fine = np.linspace(left, right, 2001)
                shape, term = (
                    blurred_planes(bell(fine - m, s), d, alpha)[:, end]
                    for m, s, d in ((value, 0.3, 0.04), (CENTERS[t], 0.7, 0.06))
                )
                together = NORMS[norm](shape, term)
                best, step = fine[together.argmax()], fine[1] - fine[0]
                left, right = best - 2.0 * step, best + 2.0 * step
            found[t, end] = together.max()
        return found

    for x in rng.uniform(-1.5, 1.5, (3, 2)):
        expected = by_alpha_planes(x, grades, lambda alpha: fixed, grid, norm, "centroid")
        np.testing.assert_allclose(system.alpha_cuts(x)[0], expected, rtol=0.0, atol=1e-9)
