"""Subtractive clustering, against its equations by hand and in plain loops."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

import fuzzy2
from fuzzy2.errors import InvalidValue

Array = NDArray[np.float64]


def test_four_samples_by_hand() -> None:
    """Samples 0, 0.1, 0.9 and 1, of range 1 already, and a radius of 1/2: exp(-16 d^2).

    Of 0.1 the potential is 1 + exp(-0.16) + exp(-10.24) + exp(-12.96), as of 0.9; 0 and 1 have
    exp(-16) for the third term, so 0.1 is first. It subtracts exp(-4 d^2 / 0.5625) of its
    potential, which leaves more of 1.0, at the distance 0.9, than of 0.9.
    """
    near, far, farther, across = (math.exp(-16.0 * d * d) for d in (0.1, 0.8, 0.9, 1.0))
    inner, outer = 1.0 + near + far + farther, 1.0 + near + farther + across
    found = fuzzy2.subtractive_clustering([[0.0], [0.1], [0.9], [1.0]])
    np.testing.assert_array_equal(found.centers, [[0.1], [1.0]])
    second = outer - inner * math.exp(-4.0 * 0.81 / 0.75**2)
    assert second > inner - inner * math.exp(-4.0 * 0.64 / 0.75**2)
    np.testing.assert_allclose(found.potentials, [inner, second], rtol=1e-14)
    np.testing.assert_allclose(found.sigmas, [0.5 / math.sqrt(8.0)])


def in_plain_loops(X: Array, radius: float, squash: float) -> list[int]:
    """Chiu's algorithm as he writes it, with numbers one at a time."""
    low, high = X.min(axis=0), X.max(axis=0)
    units = [(row - low) / (high - low) for row in X]
    alpha, beta = 4.0 / radius**2, 4.0 / (squash * radius) ** 2

    def squared(a: Array, b: Array) -> float:
        return float(((a - b) ** 2).sum())

    potential = [sum(math.exp(-alpha * squared(a, b)) for b in units) for a in units]
    first, centers = max(potential), [int(np.argmax(potential))]

    def subtract(k: int) -> None:
        height = potential[k]
        for i, unit in enumerate(units):
            potential[i] -= height * math.exp(-beta * squared(unit, units[k]))

    subtract(centers[0])
    while True:
        k = int(np.argmax(potential))
        if potential[k] <= 0.15 * first:
            return centers
        nearest = min(math.sqrt(squared(units[k], units[c])) for c in centers)
        if potential[k] <= 0.5 * first and nearest / radius + potential[k] / first < 1.0:
            potential[k] = 0.0
            continue
        centers.append(k)
        subtract(k)


@pytest.mark.parametrize("radius", [0.2, 0.35, 0.5, 0.9])
@pytest.mark.parametrize("squash", [1.25, 1.5])
def test_the_centers_are_those_of_plain_loops(radius: float, squash: float) -> None:
    rng = np.random.default_rng(4)
    X = np.concatenate([rng.normal(m, 0.3, (30, 2)) for m in ((0, 0), (2, 1), (0, 3))]) * [1, 50]
    found = fuzzy2.subtractive_clustering(X, radius, squash)
    np.testing.assert_array_equal(found.centers, X[in_plain_loops(X, radius, squash)])


def test_three_clouds_are_three_clusters_at_any_scale() -> None:
    rng = np.random.default_rng(5)
    X = np.concatenate([rng.normal(m, 0.1, (40, 2)) for m in ((0, 0), (2, 1), (0, 3))])
    found = fuzzy2.subtractive_clustering(X)
    assert len(found.centers) == 3
    for scale in (1e-170, 1e170, 1.7e308 / np.abs(X).max()):
        scaled = fuzzy2.subtractive_clustering(scale * X)
        np.testing.assert_allclose(scaled.centers / scale, found.centers, atol=1e-14)
        np.testing.assert_allclose(scaled.sigmas / scale, found.sigmas, atol=1e-14)


def test_weights_count_samples() -> None:
    rng = np.random.default_rng(6)
    X = rng.random((20, 2))
    counts = rng.integers(1, 4, 20)
    once = fuzzy2.subtractive_clustering(X, 0.3, sample_weight=counts)
    each = fuzzy2.subtractive_clustering(np.repeat(X, counts, axis=0), 0.3)
    np.testing.assert_array_equal(once.centers, each.centers)
    np.testing.assert_allclose(once.potentials, each.potentials, rtol=1e-12)


def test_samples_that_are_all_equal_are_one_cluster() -> None:
    found = fuzzy2.subtractive_clustering(np.ones((5, 2)))
    np.testing.assert_array_equal(found.centers, [[1.0, 1.0]])
    np.testing.assert_array_equal(found.potentials, [5.0])


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        (([1.0, 2.0],), "X"),
        (([[math.nan]],), "X"),
        (([[1.0]], 0.0), "radius"),
        (([[1.0]], 0.5, -1.0), "squash"),
    ],
)
def test_what_cannot_be_clustered_is_refused(arguments: tuple[object, ...], named: str) -> None:
    with pytest.raises(InvalidValue, match=named):
        fuzzy2.subtractive_clustering(*arguments)  # type: ignore[arg-type]


def test_anfis_makes_a_rule_of_each_cluster() -> None:
    """Before learning its terms are the centers and widths, its consequents least squares."""
    rng = np.random.default_rng(7)
    X = rng.random((200, 2))
    y = np.sin(5.0 * X[:, 0]) + X[:, 1]
    model = fuzzy2.ANFIS(partition="subtractive", radius=0.4, most_epochs=0).fit(X, y)
    found = fuzzy2.subtractive_clustering(np.column_stack([X, y]), 0.4)
    assert len(model.system_.rules) == len(found.centers) > 2
    for i, terms in enumerate(model.system_.inputs):
        means = [term.mean for term in terms]
        np.testing.assert_allclose(means, np.sort(found.centers[:, i]), atol=1e-12)
        sigmas = [term.sigma for term in terms]
        np.testing.assert_allclose(sigmas, found.sigmas[i], rtol=1e-12)
    assert model.score(X, y) > 0.95
