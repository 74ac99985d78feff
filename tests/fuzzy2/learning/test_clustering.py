"""Fuzzy c-means.

Against plain loops, a general minimizer, conditions at a minimum, and k-means in its limit.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fuzzy2.errors import InvalidValue
from fuzzy2.learning.clustering import Clusters, fuzzy_c_means

ANGLES = np.array([0.3, 2.5, 4.4])


def blobs(count: int = 40, spread: float = 0.3, seed: int = 0) -> np.ndarray:
    """Return three clouds on a circle of radius 3."""
    rng = np.random.default_rng(seed)
    middles = 3.0 * np.stack([np.cos(ANGLES), np.sin(ANGLES)], axis=1)
    return np.concatenate([rng.normal(middle, spread, (count, 2)) for middle in middles])


def loops_membership(x: np.ndarray, centers: np.ndarray, power: float) -> list[float]:
    distances = [math.dist(x, center) for center in centers]
    return [
        1.0 / sum((d / other) ** (2.0 / (power - 1.0)) for other in distances) for d in distances
    ]


def loops_objective(X: np.ndarray, centers: np.ndarray, power: float) -> float:
    """Return the objective with the best memberships for the centers."""
    total = 0.0
    for x in X:
        for u, center in zip(loops_membership(x, centers, power), centers, strict=True):
            total += u**power * math.dist(x, center) ** 2
    return total


@settings(max_examples=30, deadline=None)
@given(
    seed=st.integers(0, 2**32 - 1),
    count=st.integers(2, 5),
    inputs=st.integers(1, 3),
    power=st.floats(1.2, 4.0),
)
def test_the_objective_never_rises_and_is_at_a_minimum(
    seed: int, count: int, inputs: int, power: float
) -> None:
    """Rounding of a sum of 30 terms is 1e-14 of it.

    The gradient is by differences of 1e-5: their error is 1e-10 times a third derivative of some
    1000, and rounding of 1e-14 over 1e-5. The iteration stops while memberships still change by
    1e-9, which can be far from the end where it converges slowly.
    """
    X = np.random.default_rng(seed).normal(size=(30, inputs))
    clusters = fuzzy_c_means(X, count, power, np.random.default_rng(seed), starts=2)
    assert (np.diff(clusters.objectives) <= 1e-13 * clusters.objectives[0]).all()
    np.testing.assert_allclose(clusters.memberships.sum(axis=1), 1.0, rtol=1e-14)
    assert clusters.objectives[-1] == pytest.approx(
        loops_objective(X, clusters.centers, power), rel=1e-12
    )
    if clusters.converged:
        step = 1e-5
        for index in np.ndindex(clusters.centers.shape):
            shift = np.zeros_like(clusters.centers)
            shift[index] = step
            rise = loops_objective(X, clusters.centers + shift, power) - loops_objective(
                X, clusters.centers - shift, power
            )
            assert abs(rise / (2.0 * step)) < 1e-4


@pytest.mark.slow
@pytest.mark.parametrize("power", [1.3, 2.0, 3.0])
def test_no_other_centers_are_better_on_small_data(power: float) -> None:
    """Brute force: two centers at any two points of a fine grid.

    Then a general minimizer from the best twenty pairs; 1e-6 is its own.
    """
    optimize = pytest.importorskip("scipy.optimize")
    x = np.array([0.0, 0.2, 0.3, 1.0, 1.1, 1.7, 4.0])
    found = fuzzy_c_means(x[:, np.newaxis], 2, power)
    # A little off the samples, where distances are zero.
    grid = np.linspace(-0.5, 4.5, 121) + 1.7e-3
    pairs = [
        (loops_objective(x[:, np.newaxis], np.array([[a], [b]]), power), a, b)
        for a in grid
        for b in grid
        if a < b
    ]
    best = math.inf
    for _, *start in sorted(pairs)[:20]:
        result = optimize.minimize(
            lambda c: loops_objective(x[:, np.newaxis], c[:, np.newaxis], power),
            start,
            method="Nelder-Mead",
        )
        best = min(best, result.fun)
    assert found.objectives[-1] == pytest.approx(best, rel=1e-6)
    assert found.objectives[-1] <= min(pairs)[0]


@pytest.mark.slow
def test_a_fuzzifier_near_1_is_k_means() -> None:
    """The clouds are 15 of their widths apart, so memberships are crisp to the last digit.

    (1/15)**(2/0.05) is 1e-47.
    """
    cluster = pytest.importorskip("sklearn.cluster")
    X = blobs()
    clusters = fuzzy_c_means(X, 3, 1.05)
    means = cluster.KMeans(3, n_init=10, random_state=0).fit(X)
    order = np.argsort(means.cluster_centers_[:, 0])
    np.testing.assert_allclose(clusters.centers, means.cluster_centers_[order], atol=1e-12)
    np.testing.assert_array_equal(
        clusters.memberships.argmax(axis=1), np.argsort(order)[means.labels_]
    )
    assert clusters.objectives[-1] == pytest.approx(means.inertia_, rel=1e-12)
    assert clusters.partition_coefficient == pytest.approx(1.0, abs=1e-12)
    for k in range(3):
        of_cluster = X[means.labels_ == order[k]]
        np.testing.assert_allclose(clusters.spreads[k], of_cluster.std(axis=0), rtol=1e-12)


def test_clusters_are_the_fuzzier_the_greater_the_fuzzifier() -> None:
    shares = [
        fuzzy_c_means(blobs(), 3, power).partition_coefficient
        for power in (1.1, 1.5, 2.0, 3.0, 5.0)
    ]
    assert shares == sorted(shares, reverse=True)
    assert shares[0] > 0.999
    assert shares[-1] > 1.0 / 3.0


def test_spreads_and_validity_are_the_sums_they_are_said_to_be() -> None:
    X = blobs(10)
    clusters = fuzzy_c_means(X, 3, 1.7)
    for k, center in enumerate(clusters.centers):
        weights = [loops_membership(x, clusters.centers, 1.7)[k] ** 1.7 for x in X]
        for i in range(2):
            squares = sum(w * (x[i] - center[i]) ** 2 for w, x in zip(weights, X, strict=True))
            assert clusters.spreads[k, i] == pytest.approx(
                math.sqrt(squares / sum(weights)), rel=1e-12
            )
    nearest = min(
        math.dist(a, b)
        for a in clusters.centers
        for b in clusters.centers
        if a is not b and math.dist(a, b) > 0.0
    )
    assert clusters.xie_beni == pytest.approx(
        loops_objective(X, clusters.centers, 1.7) / (30 * nearest**2), rel=1e-12
    )
    shares = sum(sum(u * u for u in loops_membership(x, clusters.centers, 1.7)) for x in X) / 30
    assert clusters.partition_coefficient == pytest.approx(shares, rel=1e-12)


def test_both_measures_of_validity_find_the_three_clouds() -> None:
    X = blobs()
    found = {count: fuzzy_c_means(X, count) for count in range(2, 8)}
    assert min(found, key=lambda count: found[count].xie_beni) == 3
    assert max(found, key=lambda count: found[count].partition_coefficient) == 3
    one = fuzzy_c_means(X, 1)
    np.testing.assert_allclose(one.centers[0], X.mean(axis=0), rtol=1e-12)
    assert math.isnan(one.xie_beni)


def test_membership_of_other_points() -> None:
    X = blobs(10)
    clusters = fuzzy_c_means(X, 3)
    np.testing.assert_allclose(clusters.membership(X), clusters.memberships, atol=1e-15)
    points = np.random.default_rng(1).normal(size=(2, 5, 2))
    expected = [[loops_membership(x, clusters.centers, 2.0) for x in row] for row in points]
    np.testing.assert_allclose(clusters.membership(points), expected, rtol=1e-12)
    np.testing.assert_array_equal(clusters.membership(clusters.centers), np.eye(3))
    two = Clusters(
        np.array([[1.0], [1.0], [2.0]]), np.empty((0, 3)), np.zeros((3, 1)), 2.0, np.zeros(1), True
    )
    np.testing.assert_array_equal(two.membership([1.0]), [0.5, 0.5, 0.0])


@settings(max_examples=20, deadline=None)
@given(
    seed=st.integers(0, 1000), scale=st.sampled_from([1e-9, 1.0, 1e9]), shift=st.floats(-10.0, 10.0)
)
def test_clusters_move_and_grow_with_the_samples(seed: int, scale: float, shift: float) -> None:
    """From the same starts, up to rounding.

    The iteration can multiply rounding by the factor at which it converges.
    """
    X = blobs(10, seed=seed)
    here, there = fuzzy_c_means(X, 3, starts=1), fuzzy_c_means(scale * (X + shift), 3, starts=1)
    np.testing.assert_allclose(
        there.centers, scale * (here.centers + shift), rtol=0.0, atol=1e-6 * scale
    )
    np.testing.assert_allclose(there.spreads, scale * here.spreads, rtol=1e-6)


@pytest.mark.parametrize("scale", [1e-170, 1e170, 1.7e308])
def test_samples_of_any_scale_are_clustered_as_ordinary_ones(scale: float) -> None:
    """To 1e-9, at which the iteration ends."""
    X = blobs(10, seed=4)
    X = X / np.abs(X).max()
    here, there = fuzzy_c_means(X, 3), fuzzy_c_means(scale * X, 3)
    np.testing.assert_allclose(there.centers / scale, here.centers, rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(there.spreads / scale, here.spreads, rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(there.memberships, here.memberships, rtol=0.0, atol=1e-8)
    points = X[:5] * scale
    np.testing.assert_allclose(there.membership(points), here.membership(X[:5]), atol=1e-8)
    np.testing.assert_allclose(there.xie_beni, here.xie_beni, rtol=1e-7)


def test_every_sample_can_be_a_cluster_and_repeated_ones_are_no_more() -> None:
    X = np.array([[0.0], [5.0], [1.0], [5.0]])
    clusters = fuzzy_c_means(X, 3)
    np.testing.assert_array_equal(clusters.centers, [[0.0], [1.0], [5.0]])
    np.testing.assert_array_equal(clusters.memberships, np.eye(3)[[0, 2, 1, 2]])
    assert clusters.objectives[-1] == 0.0
    with pytest.raises(InvalidValue, match="at most 3, the number of different samples"):
        fuzzy_c_means(X, 4)


def test_random_numbers_are_the_caller_s() -> None:
    """The same by default at every call; more starts are never worse, and a generator goes on."""
    X = np.random.default_rng(3).normal(size=(60, 2))
    np.testing.assert_array_equal(fuzzy_c_means(X, 6).centers, fuzzy_c_means(X, 6).centers)
    rng = np.random.default_rng(0)
    np.testing.assert_array_equal(fuzzy_c_means(X, 6, rng=rng).centers, fuzzy_c_means(X, 6).centers)
    state = rng.bit_generator.state
    fuzzy_c_means(X, 6, rng=rng)
    assert rng.bit_generator.state != state
    assert (
        fuzzy_c_means(X, 6, starts=20).objectives[-1]
        <= fuzzy_c_means(X, 6, starts=1).objectives[-1]
    )


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (([[0.0], [math.nan]], 1), r"X\[1\] must be finite"),
        (([0.0, 1.0], 1), "a row for each sample"),
        ((np.empty((0, 2)), 1), "a row for each sample"),
        (([["a"], ["b"]], 1), "real numbers"),
        (([[0.0], [1.0]], 0), "n_clusters"),
        (([[0.0], [1.0]], 1.0), "n_clusters"),
        (([[0.0], [1.0]], True), "n_clusters"),
        (([[0.0], [1.0]], 3), "at most 2"),
        (([[0.0], [1.0]], 1, 1.0), "fuzzifier"),
        (([[0.0], [1.0]], 1, math.inf), "fuzzifier"),
        (([[0.0], [1.0]], 1, 2.0, 0), "rng"),
        (([[0.0], [1.0]], 1, 2.0, None, 0), "starts"),
    ],
)
def test_what_cannot_be_clustered_is_refused(arguments: tuple[Any, ...], words: str) -> None:
    with pytest.raises(InvalidValue, match=words):
        fuzzy_c_means(*arguments)


@pytest.mark.parametrize("points", [[1.0, math.nan], [1.0], 1.0, [[1.0, 2.0, 3.0]]])
def test_points_of_another_kind_have_no_membership(points: Any) -> None:
    with pytest.raises(InvalidValue, match=r"X must be (finite|of shape \(\.\.\., 2\))"):
        fuzzy_c_means(blobs(5), 2).membership(points)


def test_memberships_of_points_that_are_much_smaller_than_the_centers() -> None:
    """They are all at the origin, compared with the centers; nothing overflows."""
    X = np.random.default_rng(0).normal(size=(30, 2))
    clusters = fuzzy_c_means(X, 2)
    tiny = clusters.membership(np.full((1, 2), 1e-320))
    np.testing.assert_allclose(tiny, clusters.membership(np.zeros((1, 2))), rtol=1e-15)
