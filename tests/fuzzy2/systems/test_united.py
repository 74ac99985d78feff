"""Centroids of united sets against exact rational integration, and quadrature split at kinks."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad

import fuzzy2
from fuzzy2.errors import InvalidValue, NotApplicable
from fuzzy2.operations.t_norms import t_conorm, t_norm
from fuzzy2.systems.united import United
from tests import examples

Corners = tuple[Fraction, Fraction, Fraction, Fraction]
Function = Callable[[Fraction], Fraction]
RANGE = (Fraction(-100), Fraction(100))
ALLOWED = Fraction(1, 10**6) * (RANGE[1] - RANGE[0])
"""The bar: 1e-6 of the range."""


def trapezoid(corners: Corners, x: Fraction) -> Fraction:
    a, b, c, d = corners
    if x < a or x > d:
        return Fraction(0)
    if x < b:
        return (x - a) / (b - a)
    return (d - x) / (d - c) if x > c else Fraction(1)


def clipped(corners: Corners, weight: Fraction, product: bool) -> Function:
    if product:
        return lambda x: weight * trapezoid(corners, x)
    return lambda x: min(weight, trapezoid(corners, x))


def nodes_of(sets: list[Corners], weights: list[Fraction]) -> list[Fraction]:
    """Return the corners, and where the sets are clipped, in the range."""
    points = set(RANGE)
    for (a, b, c, d), w in zip(sets, weights, strict=True):
        points |= {a, b, c, d, a + (b - a) * w, d - (d - c) * w}
    return sorted(x for x in points if RANGE[0] <= x <= RANGE[1])


def pieces_of(
    functions: list[Function], nodes: list[Fraction], total: bool
) -> list[tuple[Fraction, Fraction, Fraction, Fraction]]:
    """Return the linear pieces (left, right, grade, grade) of a union.

    Between nodes every function is linear, which the grades at two points within say whole; edges
    may be vertical.
    """
    pieces = []
    for left, right in itertools.pairwise(nodes):
        third = (right - left) / 3
        lines = []
        for function in functions:
            first, second = function(left + third), function(right - third)
            slope = (second - first) / third
            lines.append((first - slope * third, slope))
        cuts = {Fraction(0), right - left}
        if not total:
            for (a, s), (b, t) in itertools.combinations(lines, 2):
                if s != t and 0 < (b - a) / (s - t) < right - left:
                    cuts.add((b - a) / (s - t))
        for near, far in itertools.pairwise(sorted(cuts)):
            ends = [(sum if total else max)(a + s * at for a, s in lines) for at in (near, far)]
            pieces.append((left + near, left + far, ends[0], ends[1]))
    return pieces


def area_and_moment(
    pieces: list[tuple[Fraction, Fraction, Fraction, Fraction]],
) -> tuple[Fraction, Fraction]:
    area = moment = Fraction(0)
    for left, right, first, last in pieces:
        area += (right - left) * (first + last) / 2
        moment += (right - left) * (left * (2 * first + last) + right * (first + 2 * last)) / 6
    return area, moment


def random_corners(rng: np.random.Generator) -> Corners:
    """Return trapezoids from wide to 1e-4 of the range, also triangles and vertical edges."""
    width = 10.0 ** rng.uniform(-2.0, 2.0)
    widths = rng.uniform(0.0, width, 3) * (rng.random(3) < 0.7)
    if not widths.any():
        widths[0] = width
    steps = [Fraction(round(float(value) * 10**6), 10**6) for value in widths]
    start = Fraction(round(float(rng.uniform(-99.0, 99.0)) * 100), 100)
    b = start + steps[0]
    return start, b, b + steps[1], b + steps[1] + steps[2]


def as_set(corners: Corners) -> fuzzy2.Trapezoidal:
    return fuzzy2.Trapezoidal(*map(float, corners))


def dyadic(corners: Corners) -> Corners:
    """Return the corners as the floats that the library has them in."""
    return tuple(Fraction(float(value)) for value in corners)  # type: ignore[return-value]


@pytest.mark.parametrize("norm", ["min", "product"])
@pytest.mark.parametrize("conorm", ["max", None])
def test_type_1_unions_have_the_centroid_of_exact_integration(norm: str, conorm: Any) -> None:
    """With ``HYPOTHESIS_PROFILE=thorough`` 10 000 of them, in all four cases together."""
    rng = np.random.default_rng(5)
    for _ in range(examples(2500, of=40)):
        sets = [dyadic(random_corners(rng)) for _ in range(rng.integers(1, 5))]
        weights = [Fraction(float(w)) for w in rng.random(len(sets))]
        united = United(
            [as_set(one) for one in sets],
            t_norm(norm),
            None if conorm is None else t_conorm(conorm),
            (-100.0, 100.0),
        )
        strengths = np.array([[[float(w)] * 2 for w in weights]])
        functions = [
            clipped(one, w, norm == "product") for one, w in zip(sets, weights, strict=True)
        ]
        area, moment = area_and_moment(
            pieces_of(functions, nodes_of(sets, weights), conorm is None)
        )
        found = united.centroids(strengths)[0]
        assert area > 0
        assert abs(Fraction(float(found[0])) - moment / area) <= ALLOWED
        assert found[0] == found[1]
        united._rows = None
        assert abs(Fraction(float(united.centroids(strengths)[0, 0])) - moment / area) <= ALLOWED


@pytest.mark.parametrize("norm", ["min", "product"])
def test_both_ends_of_interval_unions_are_the_zeros_of_exact_integrals(norm: str) -> None:
    """F is negative a millionth of the range before an end, and positive as far behind it."""
    rng = np.random.default_rng(6)
    product = norm == "product"
    for _ in range(25):
        upper = [dyadic(random_corners(rng)) for _ in range(rng.integers(1, 4))]
        lower = [(a + (b - a) / 2, b, c, d - (d - c) / 2) for a, b, c, d in upper]
        lower = [dyadic(one) for one in lower]
        sets = [
            fuzzy2.IntervalType2Set(as_set(low), as_set(high))
            for low, high in zip(lower, upper, strict=True)
        ]
        firing = np.sort(rng.random((len(sets), 2)), axis=1)
        united = United(sets, t_norm(norm), t_conorm("max"), (-100.0, 100.0))
        ends = []
        for corners, column in ((lower, 0), (upper, 1)):
            weights = [Fraction(float(w)) for w in firing[:, column]]
            functions = [clipped(o, w, product) for o, w in zip(corners, weights, strict=True)]
            ends.append((functions, nodes_of(corners, weights)))

        def excess(c: Fraction, left: bool, ends: Any = ends) -> Fraction:
            (low, low_nodes), (high, high_nodes) = ends
            first, second = (
                ((high, high_nodes), (low, low_nodes))
                if left
                else ((low, low_nodes), (high, high_nodes))
            )
            before = area_and_moment(
                pieces_of(first[0], [x for x in first[1] if x < c] + [c], False)
            )
            after = area_and_moment(
                pieces_of(second[0], [c] + [x for x in second[1] if x > c], False)
            )
            return c * before[0] - before[1] + c * after[0] - after[1]

        for compiled in (True, False):
            if not compiled:
                united._rows = None
            found = united.centroids(firing[np.newaxis])[0]
            for end, left in zip(found, (True, False), strict=True):
                at = Fraction(float(end))
                assert excess(max(at - ALLOWED, RANGE[0]), left) <= 0
                assert excess(min(at + ALLOWED, RANGE[1]), left) >= 0


@pytest.mark.parametrize("conorm", ["max", "probabilistic", "lukasiewicz", "einstein"])
@pytest.mark.parametrize("norm", ["min", "product", "hamacher", "lukasiewicz"])
def test_smooth_sets_have_the_centroid_of_quadrature(norm: str, conorm: str) -> None:
    """Split at centers, clips and ends; 1e-6 of the range of 12."""
    rng = np.random.default_rng(7)
    sets = [
        fuzzy2.Gaussian(-1.0, 0.3),
        fuzzy2.Bell(1.0, 0.8, 3.0),
        fuzzy2.Triangular(2.0, 2.1, 5.0),
    ]
    united = United(sets, t_norm(norm), t_conorm(conorm), (-6.0, 6.0))
    weights = rng.uniform(0.3, 1.0, 3)

    def union(x: float) -> float:
        parts = [t_norm(norm)(w, item(x)) for w, item in zip(weights, sets, strict=True)]
        return float(t_conorm(conorm)(*parts))

    kinks = np.sort(np.concatenate([np.linspace(-6.0, 6.0, 97), [2.1]]))
    pieces = list(itertools.pairwise(kinks))
    area = sum(quad(union, a, b, limit=200)[0] for a, b in pieces)
    moment = sum(quad(lambda x: x * union(x), a, b, limit=200)[0] for a, b in pieces)
    found = united.centroids(np.repeat(weights[np.newaxis, :, np.newaxis], 2, axis=2))
    np.testing.assert_allclose(found[0], moment / area, atol=12e-6, rtol=0.0)


def fired(*weights: float) -> Any:
    return np.repeat(np.array(weights)[np.newaxis, :, np.newaxis], 2, axis=2)


def test_points_have_the_average_of_their_heights_exactly() -> None:
    """Single points anywhere, in rationals: none is lost, however near to another one."""
    rng = np.random.default_rng(9)
    for _ in range(examples(2500, of=40)):
        at = np.round(rng.uniform(-99.0, 99.0, rng.integers(1, 6)), int(rng.integers(0, 7)))
        at = np.unique(at)
        weights = rng.random(at.size)
        united = United(
            [fuzzy2.Singleton(float(x)) for x in at],
            t_norm("min"),
            t_conorm("max"),
            (-100.0, 100.0),
        )
        exact = [(Fraction(float(w)), Fraction(float(x))) for w, x in zip(weights, at, strict=True)]
        expected = sum(w * x for w, x in exact) / sum(w for w, _ in exact)
        assert abs(Fraction(float(united.centroids(fired(*weights))[0, 0])) - expected) <= ALLOWED


def test_points_are_averaged_by_their_heights() -> None:
    united = United(
        [fuzzy2.Singleton(1.0), fuzzy2.Singleton(0.5)], t_norm("min"), t_conorm("max"), (-1.0, 2.0)
    )
    np.testing.assert_allclose(united.centroids(fired(0.75, 0.25)), [[0.875, 0.875]])
    np.testing.assert_array_equal(united.centroids(fired(1.0, 0.0)), [[1.0, 1.0]])
    assert np.isnan(united.centroids(fired(0.0, 0.0))).all()
    np.testing.assert_array_equal(united.bisectors(fired(0.75, 0.25)), [1.0])
    np.testing.assert_array_equal(united.maxima(fired(0.75, 0.25), "mean_of_maxima"), [1.0])


def test_points_beside_areas_are_refused_and_not_lost() -> None:
    sets = [fuzzy2.Singleton(1.0), fuzzy2.Triangular(0.0, 1.0, 2.0)]
    with pytest.raises(NotApplicable, match="is a single point, which has no area"):
        United(sets, t_norm("min"), t_conorm("max"), None)
    with pytest.raises(InvalidValue, match="output_ranges"):
        United([fuzzy2.Triangular(3.0, 4.0, 5.0)], t_norm("min"), t_conorm("max"), (0.0, 1.0))


def test_without_a_lower_membership_the_ends_are_those_of_the_support() -> None:
    sets = [fuzzy2.IntervalType2Set(fuzzy2.Triangular(-1, 0, 1, 0.5), fuzzy2.Triangular(-2, 0, 3))]
    united = United(sets, t_norm("min"), t_conorm("max"), None)
    for _ in range(2):
        found = united.centroids(np.array([[[0.0, 0.5]]]))
        np.testing.assert_allclose(found, [[-2.0, 3.0]], atol=1e-12)
        united._rows = None


def test_bisector_and_maxima_by_hand() -> None:
    """A trapezoid of 0.5 on [0, 4], from a triangle of width 4, and a triangle of 1/4 beside it."""
    sets = [fuzzy2.Triangular(0.0, 2.0, 4.0), fuzzy2.Triangular(4.0, 5.0, 6.0)]
    united = United(sets, t_norm("min"), t_conorm("max"), (-1.0, 6.0))
    weights = fired(0.5, 0.25)
    # Areas: 1.5, and 0.4375; half of both is reached where 0.25 + (x - 1) / 2 = 0.96875.
    np.testing.assert_allclose(united.bisectors(weights), [2.4375], atol=1e-9)
    expected = {
        "smallest_of_maxima": 1.0,
        "middle_of_maxima": 2.0,
        "mean_of_maxima": 2.0,
        "largest_of_maxima": 3.0,
        "smallest_absolute_maximum": 1.0,
        "largest_absolute_maximum": 3.0,
    }
    for kind, value in expected.items():
        np.testing.assert_allclose(united.maxima(weights, kind), [value], atol=1e-9)


def test_direct_methods_by_hand() -> None:
    """Lower triangle of half the height and width 2 about 0, upper one of width 4 about 1/2."""
    low, high = fuzzy2.Triangular(-1.0, 0.0, 1.0, 0.5), fuzzy2.Triangular(-1.0, 0.0, 3.0)
    sets = [fuzzy2.IntervalType2Set(low, high)]
    united = United(sets, t_norm("product"), t_conorm("max"), None)
    one = np.array([[[1.0, 1.0]]])
    centers, areas = np.array([0.0, 2.0 / 3.0]), np.array([0.5, 2.0])
    found = united.average(one, "nie_tan", (0.5, 0.5))
    np.testing.assert_allclose(found, np.full((1, 2), centers @ areas / areas.sum()), atol=1e-9)
    found = united.average(one, "begian_melek_mendel", (0.25, 0.75))
    np.testing.assert_allclose(found, np.full((1, 2), 0.5), atol=1e-9)


@pytest.mark.parametrize("reduction", ["centroid", "center_of_sums"])
def test_terms_narrower_than_the_step_of_a_grid_are_not_lost(reduction: str) -> None:
    """Half-widths 0.1 at -80.2 and 80 on [-100, 100] under firing 0.75 and 0.25.

    By hand: a triangle of area 0.1 clipped at w has the area 0.1 (1 - (1 - w)^2), 0.09375 and
    0.04375, so (-80.2 * 0.09375 + 80 * 0.04375) / 0.1375 = -29.2273. A grid gave 80.
    """
    flat = fuzzy2.Trapezoidal(-1.0, 0.0, 1.0, 2.0)
    narrow = [[fuzzy2.Triangular(c - 0.1, c, c + 0.1)] for c in (-80.2, 80.0)]
    expected = (-80.2 * 0.09375 + 80.0 * 0.04375) / 0.1375
    assert round(expected, 4) == -29.2273
    for aggregation in ("max", "sum"):
        system = fuzzy2.Type1System(
            [[flat, flat]],
            [[0], [1]],
            narrow,
            "min",
            type_reduction=reduction,
            t_conorm=aggregation,
            output_ranges=[(-100.0, 100.0)],
        )
        # Firing is by the two rules' weights, which multiply 1.
        fired = system.replace(weights=[0.75, 0.25])
        np.testing.assert_allclose(fired([0.5]), [expected], rtol=0.0, atol=1e-6)


def far_apart() -> Iterator[fuzzy2.Type1System | fuzzy2.IntervalType2System]:
    """Yield systems without a compiled loop, whose rules fire by 1e-40 at 9 and by 1 at 0."""
    mean, sigma = fuzzy2.GaussianUncertainMean, fuzzy2.GaussianUncertainSigma
    rules = "IF x is low THEN y is a\nIF x is high THEN y is b"
    options: dict[str, Any] = {"output_ranges": [(-3.0, 3.0)], "t_conorm": "probabilistic"}
    for kind in ("centroid", "center_of_sums"):
        yield fuzzy2.IntervalType2System(
            {"x": {"low": mean((-0.1, 0.1), 1.0), "high": mean((0.9, 1.1), 1.0)}},
            rules,
            {"y": {"a": sigma(0.3, (0.2, 0.5)), "b": sigma(-0.9, (0.5, 1.2))}},
            type_reduction=kind,
            **options,
        )
    crisp = {"x": {"low": fuzzy2.Gaussian(0.0, 1.0), "high": fuzzy2.Gaussian(1.0, 1.0)}}
    for other in (fuzzy2.Bell(-0.9, 0.5, 2.0), fuzzy2.PiShaped(-2.0, -1.0, -0.5, 0.0)):
        for kind in ("centroid", "bisector"):
            sets = {"y": {"a": fuzzy2.Gaussian(0.3, 0.4), "b": other}}
            yield fuzzy2.Type1System(crisp, rules, sets, type_reduction=kind, **options)


@pytest.mark.parametrize("number", range(6))
def test_a_row_does_not_depend_on_those_beside_it(number: int) -> None:
    """Their areas are 1e-40 beside 1. 1e-12, because sums of a block run in another order."""
    system = list(far_apart())[number]
    inputs = np.array([[0.5], [9.0], [0.0], [10.0], [-9.0], [1.0]])
    alone = np.array([system(x) for x in inputs])
    assert np.isfinite(alone).all()
    np.testing.assert_allclose(system(inputs), alone, rtol=0, atol=1e-12)
    reduced = np.array([system.type_reduced(x) for x in inputs])
    np.testing.assert_allclose(system.type_reduced(inputs), reduced, rtol=0, atol=1e-12)
    slopes = np.array([system.gradient(x) for x in inputs])
    np.testing.assert_allclose(system.gradient(inputs), slopes, rtol=0, atol=1e-6)


def test_a_bisector_far_out_is_that_of_the_union_on_a_fine_grid() -> None:
    """At 9 the rules fire by 3e-18 and 1e-14; half a cell of the grid is 1e-5."""
    system = list(far_apart())[3]
    y = np.linspace(-3.0, 3.0, 300_001)
    for x in (0.5, 7.9, 9.0):
        fired = np.exp(-0.5 * (x - np.array([0.0, 1.0])) ** 2)
        sets = np.exp(-0.5 * ((y - 0.3) / 0.4) ** 2), 1.0 / (1.0 + ((y + 0.9) / 0.5) ** 4)
        one, other = fired[0] * sets[0], fired[1] * sets[1]
        areas = np.cumsum(one + other - one * other)
        expected = y[np.searchsorted(areas, 0.5 * areas[-1])]
        assert abs(float(system([[0.0], [x]])[1, 0]) - expected) < 4e-5
