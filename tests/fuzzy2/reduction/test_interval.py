"""Exact type reduction against enumeration of all switch points.

At any scale, and the approximations against their equations.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

import fuzzy2
from fuzzy2.errors import InvalidValue, UnknownName
from fuzzy2.reduction.interval import (
    METHODS,
    begian_melek_mendel,
    centroid,
    generalized_centroid,
    nie_tan,
    wu_mendel_bounds,
)

Array = NDArray[np.float64]


def enumerate_switch_points(z: Array, w: Array) -> tuple[float, float]:
    """All switch points of both ends, with exactly rounded sums.

    NaN where no weight can be positive.
    """
    ends = []
    for end, best in ((0, min), (1, max)):
        order = np.argsort(z[:, end], kind="stable")
        points, low, high = z[order, end], w[order, 0], w[order, 1]
        averages = []
        for k in range(len(points) + 1):
            weights = np.concatenate([high[:k], low[k:]] if end == 0 else [low[:k], high[k:]])
            mass = math.fsum(weights)
            if mass > 0.0:
                averages.append(math.fsum(weights * points) / mass)
        ends.append(best(averages) if averages else math.nan)
    return ends[0], ends[1]


def random_case(rng: np.random.Generator) -> tuple[Array, Array]:
    """Points and weights of every kind that has broken a library: see the comments."""
    n = int(rng.integers(1, 13))
    z = rng.normal(size=n)
    if rng.random() < 0.3:
        z = np.round(z)  # equal points
    if rng.random() < 0.2:
        z = z + 100.0  # far from zero
    # interval points in half of the cases
    z = z[:, np.newaxis] + [0.0, 1.0] * (rng.random((n, 1)) * (rng.random() < 0.5))
    z = z * 10.0 ** int(rng.integers(-9, 10))
    w = np.sort(rng.random((n, 2)), axis=1)
    if rng.random() < 0.4:
        w[rng.random(n) < 0.5, 0] = 0.0  # zero lower weights
    if rng.random() < 0.3:
        w[rng.random(n) < 0.4] = 0.0  # rules that do not fire
    if rng.random() < 0.3:
        # weights that outweigh others by more than a float's digits
        w *= 10.0 ** rng.integers(-200, 1, size=(n, 1))
    if rng.random() < 0.1:
        w[:, 0] = w[:, 1]  # no uncertainty
    return z, w


@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS)
def test_every_method_agrees_with_enumeration(method: str) -> None:
    """3000 cases; 1e-12 of the largest point is the project's bar, 1e-15 is what is reached."""
    rng = np.random.default_rng(11)
    for _ in range(3000):
        z, w = random_case(rng)
        found, expected = generalized_centroid(z, w, method), enumerate_switch_points(z, w)
        np.testing.assert_allclose(
            found, expected, rtol=0.0, atol=1e-12 * max(float(np.abs(z).max()), 1e-300)
        )


def iterated_maximum(c: Array, s: Array, h: Array, delta: Array) -> float:
    """Return what the procedure after eq. 1.116 finds, word by word, with w = h to begin with.

    It takes the first k between whose ends the value lies; where there is none it stops.
    """
    points, value = c + s, float(((c + s) * h).sum() / h.sum())
    for _ in range(2 * len(c)):
        between = (points[:-1] <= value) & (value <= points[1:])
        if not between.any():
            break
        k = int(np.argmax(between)) + 1
        weights = np.concatenate([(h - delta)[:k], (h + delta)[k:]])
        value = float((points * weights).sum() / weights.sum())
    return value


def test_without_sorting_the_iterative_procedure_goes_wrong() -> None:
    """In more than nine of ten random cases of eight points; sorted by c + s, in none.

    Sorted it is exact but for rounding, 1e-12.
    """
    rng = np.random.default_rng(5)
    wrong = {"as printed": 0, "sorted": 0}
    for _ in range(2000):
        c, s, h = rng.normal(size=8), rng.random(8), rng.uniform(0.1, 1.0, 8)
        delta = h * rng.random(8)
        z, w = np.column_stack([c - s, c + s]), np.column_stack([h - delta, h + delta])
        expected = enumerate_switch_points(z, w)[1]
        order = np.argsort(c + s)
        for name, numbers in (
            ("as printed", (c, s, h, delta)),
            ("sorted", (c[order], s[order], h[order], delta[order])),
        ):
            wrong[name] += abs(iterated_maximum(*numbers) - expected) > 1e-12
        assert generalized_centroid(z, w)[1] == pytest.approx(expected, abs=1e-12)
    assert wrong["as printed"] > 0.9 * 2000
    assert wrong["sorted"] == 0


@given(
    z=st.lists(st.floats(-1e6, 1e6), min_size=1, max_size=8),
    seed=st.integers(0, 2**32 - 1),
)
@settings(max_examples=300)
def test_interval_lies_between_the_extremes_and_does_not_depend_on_order(
    z: list[float], seed: int
) -> None:
    """1e-12 of the largest point, as for every method.

    An end near 0 between large points is a difference of large sums.
    """
    rng = np.random.default_rng(seed)
    points = np.array(z)
    w = np.sort(rng.random((len(z), 2)), axis=1)
    left, right = generalized_centroid(points, w)
    assert points.min() - 1e-9 <= left <= right + 1e-9 <= points.max() + 2e-9
    order = rng.permutation(len(z))
    tolerance = 1e-12 * max(float(np.abs(points).max()), 1e-300)
    np.testing.assert_allclose(
        generalized_centroid(points[order], w[order]), [left, right], rtol=0.0, atol=tolerance
    )


@given(
    scale=st.sampled_from([1e-9, 1e-6, 1.0, 1e6, 1e9]),
    shift=st.floats(-10.0, 10.0),
    seed=st.integers(0, 1000),
)
def test_affine_in_the_points(scale: float, shift: float, seed: int) -> None:
    """Scaling and shifting the points scales and shifts the interval.

    To 1e-12 of the size of the numbers.
    """
    z, w = random_case(np.random.default_rng(seed))
    z = z / max(np.abs(z).max(), 1e-300)
    base, moved = generalized_centroid(z, w), generalized_centroid(scale * (z + shift), w)
    np.testing.assert_allclose(
        moved, scale * (base + shift), atol=1e-12 * scale * (1.0 + abs(shift)), rtol=0.0
    )


def test_a_weight_that_outweighs_all_others_does_not_hide_the_switch_point() -> None:
    """The middle point has all the weight that a float sees.

    But its lower weight is 0, so the left end can do without it.
    """
    z, w = (
        np.array([0.0, 1.0, 2.0, 3.0]),
        np.array([[0.0, 1e-120], [0.0, 1e-17], [0.0, 1e-60], [1e-130, 1e-90]]),
    )
    for method in METHODS:
        np.testing.assert_allclose(generalized_centroid(z, w, method), [0.0, 3.0], atol=1e-9)


@pytest.mark.parametrize("method", METHODS)
def test_one_rule_two_equal_rules_and_no_rule(method: str) -> None:
    np.testing.assert_array_equal(
        generalized_centroid([[2.0, 3.0]], [[0.0, 0.5]], method), [2.0, 3.0]
    )
    np.testing.assert_array_equal(
        generalized_centroid([5.0, 5.0], [[0.1, 0.5], [0.2, 0.3]], method), [5.0, 5.0]
    )
    assert np.isnan(generalized_centroid([1.0, 2.0], np.zeros((2, 2)), method)).all()


@pytest.mark.parametrize("method", METHODS)
def test_batches_equal_single_calls(method: str) -> None:
    rng = np.random.default_rng(2)
    z, w = rng.normal(size=(3, 4, 6)), np.sort(rng.random((3, 4, 6, 2)), axis=-1)
    together = generalized_centroid(z, w, method)
    assert together.shape == (3, 4, 2)
    for index in np.ndindex(3, 4):
        np.testing.assert_array_equal(
            together[index], generalized_centroid(z[index], w[index], method)
        )
    shared = generalized_centroid(z[0, 0], w, method)
    np.testing.assert_array_equal(shared[1, 2], generalized_centroid(z[0, 0], w[1, 2], method))


@pytest.mark.parametrize("count", [100, 100_000])
def test_centroid_of_a_large_grid(count: int) -> None:
    """Closed form for a constant footprint on [0, 1]: sqrt(h)/(1 + sqrt(h)).

    The grid's error is 1/N.
    """
    x = np.linspace(0.0, 1.0, count)
    for method in METHODS:
        left, right = centroid(x, np.full(count, 0.25), np.ones(count), method)
        np.testing.assert_allclose([left, right], [1.0 / 3.0, 2.0 / 3.0], atol=1.0 / count)


def test_nie_tan_and_begian_melek_mendel_are_their_equations() -> None:
    rng = np.random.default_rng(3)
    z, w = rng.normal(size=5), np.sort(rng.random((5, 2)), axis=1)
    middle = sum(z[i] * (w[i, 0] + w[i, 1]) for i in range(5)) / w.sum()
    assert nie_tan(z, w) == pytest.approx(middle, rel=1e-14)
    low, high = (np.average(z, weights=w[:, end]) for end in (0, 1))
    assert begian_melek_mendel(z, w, 0.3, 0.7) == pytest.approx(0.3 * low + 0.7 * high, rel=1e-14)
    w[:, 0] = 0.0
    assert begian_melek_mendel(z, w) == pytest.approx(high, rel=1e-14)
    assert np.isnan(nie_tan(z, np.zeros((5, 2))))
    assert np.isnan(begian_melek_mendel(z, np.zeros((5, 2))))


def test_wu_mendel_bounds_bound_both_ends() -> None:
    """2000 cases, to rounding; and at zero uncertainty all four are the average."""
    rng = np.random.default_rng(4)
    for _ in range(2000):
        z, w = random_case(rng)
        left, right = enumerate_switch_points(z, w)
        bounds = wu_mendel_bounds(z, w)
        if math.isnan(left):
            assert np.isnan(bounds).all()
            continue
        slack = 1e-12 * max(float(np.abs(z).max()), 1e-300)
        assert bounds.left_lower - slack <= left <= bounds.left_upper + slack
        assert bounds.right_lower - slack <= right <= bounds.right_upper + slack
    z, weights = rng.normal(size=6), rng.random(6)
    exact = wu_mendel_bounds(z, np.stack([weights, weights], axis=1))
    np.testing.assert_allclose(exact, np.average(z, weights=weights), rtol=1e-13)


@pytest.mark.parametrize(
    ("z", "w"),
    [
        ([1.0, 2.0], [[0.1, 0.2]]),
        ([1.0, np.nan], [[0.1, 0.2], [0.1, 0.2]]),
        ([1.0, 2.0], [[0.2, 0.1], [0.1, 0.2]]),
        ([1.0, 2.0], [[-0.1, 0.1], [0.1, 0.2]]),
        ([[2.0, 1.0], [1.0, 2.0]], [[0.1, 0.2], [0.1, 0.2]]),
        ([], np.zeros((0, 2))),
        (np.zeros((3, 2)), np.zeros((5, 2, 2))),
        ([1.0, 2.0], [0.1, 0.2]),
    ],
)
def test_malformed_arguments_are_refused(z: object, w: object) -> None:
    for function in (generalized_centroid, nie_tan, begian_melek_mendel, wu_mendel_bounds):
        with pytest.raises(InvalidValue):
            function(z, w)  # type: ignore[operator]


def test_malformed_centroids_and_unknown_methods_are_refused() -> None:
    with pytest.raises(InvalidValue):
        centroid([0.0, 1.0], [0.1, 0.2, 0.3], [0.5, 0.5])
    with pytest.raises(InvalidValue):
        centroid(1.0, [0.1], [0.2])
    with pytest.raises(UnknownName, match="eiasc"):
        centroid([0.0, 1.0], [0.1, 0.2], [0.5, 0.5], method="karnik")


@pytest.mark.parametrize("scale", [1e-170, 1e170, 1.7e308])
def test_numbers_of_any_scale_are_reduced_as_ordinary_ones(scale: float) -> None:
    """To 1e-14 of the scale, a few roundings of sums of ten numbers; warnings are errors here."""
    rng = np.random.default_rng(3)
    z = rng.uniform(-1.0, 1.0, 10)
    z[:2] = -1.0, 1.0
    w = np.sort(rng.random((10, 2)), axis=-1)
    heaviest = w / w.max()
    for reduced in (generalized_centroid, nie_tan, begian_melek_mendel, wu_mendel_bounds):
        expected = np.asarray(reduced(z, w))
        found = np.asarray(reduced(scale * z, w)) / scale
        np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-14)
        found = np.asarray(reduced(z, scale * heaviest))
        np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-14)


def test_rows_of_floats_go_a_shorter_way_to_the_same_centroid() -> None:
    """To the last digits; it is longer out of order, as lists, of other scales and in batches."""
    rng = np.random.default_rng(8)
    for count in (1, 2, 7, 100):
        x = np.sort(rng.normal(size=count))
        grades = np.sort(rng.random((2, count)) * (rng.random(count) < 0.8), axis=0)
        grades[1, 0] = 1.0
        mixed = rng.permutation(count)
        for method in METHODS:
            found = centroid(x, *grades, method)
            for other in (
                centroid(x.tolist(), *grades.tolist(), method),
                centroid(x[mixed], *grades[:, mixed], method),
                centroid(x[np.newaxis], *grades[:, np.newaxis], method)[0],
                centroid(2.0**500 * x, *grades, method) / 2.0**500,
            ):
                np.testing.assert_allclose(other, found, rtol=0.0, atol=1e-14)
    assert np.isnan(centroid(x, np.zeros(100), np.zeros(100))).all()


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("which", [0, 1, 2])
def test_the_shorter_way_refuses_what_the_longer_one_does(bad: float, which: int) -> None:
    rows = [np.linspace(0.0, 1.0, 5), np.full(5, 0.2), np.full(5, 0.7)]
    rows[which][2] = bad
    with pytest.raises(InvalidValue):
        centroid(*rows)
    with pytest.raises(InvalidValue):
        centroid(np.zeros(5), np.full(5, 0.7), np.full(5, 0.2))
    with pytest.raises(InvalidValue):
        centroid(np.zeros(5), np.full(4, 0.2), np.full(4, 0.7))
    with pytest.raises(fuzzy2.Fuzzy2Error, match="method"):
        centroid(np.zeros(5), np.full(5, 0.2), np.full(5, 0.7), "no such")
