"""Relations of the three kinds.

Products and compositions against loops, and against each other where they must agree.
"""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from fuzzy2.errors import InvalidValue
from fuzzy2.operations import relations
from fuzzy2.operations.join_meet import join, meet, negation
from fuzzy2.operations.relations import (
    cartesian_product,
    compose,
    relation_complement,
    relation_intersection,
    relation_union,
)
from fuzzy2.operations.t_norms import t_norm
from fuzzy2.sets.shapes import Gaussian, Interval, Triangular
from fuzzy2.sets.type1 import SampledSet, Singleton, Type1Set

Array = NDArray[np.float64]
NAMES = ("min", "product", "lukasiewicz", "drastic")


@st.composite
def pairs_of_relations(draw: st.DrawFn) -> tuple[Array, Array]:
    u, v, w = (draw(st.integers(1, 4)) for _ in range(3))
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    return rng.integers(0, 17, (u, v)) / 16.0, rng.integers(0, 17, (v, w)) / 16.0


@given(pair=pairs_of_relations(), name=st.sampled_from(NAMES))
@settings(max_examples=300, deadline=None)
def test_sup_star_composition_is_the_loop_of_1_62(pair: tuple[Array, Array], name: str) -> None:
    R, S = pair
    norm = t_norm(name)
    expected = [
        [max(float(norm(R[u, v], S[v, w])) for v in range(len(S))) for w in range(S.shape[1])]
        for u in range(len(R))
    ]
    np.testing.assert_array_equal(compose(R, S, t_norm=name), expected)
    np.testing.assert_array_equal(compose(R[0], S, t_norm=name), expected[0])


def test_crisp_relations_compose_as_in_1_61() -> None:
    """A Boolean matrix product."""
    rng = np.random.default_rng(0)
    R, S = rng.integers(0, 2, (5, 6)), rng.integers(0, 2, (6, 7))
    for name in NAMES:
        np.testing.assert_array_equal(compose(R, S, t_norm=name), (R @ S > 0).astype(float))


def test_large_relations_are_composed_in_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(0)
    R, S = rng.uniform(size=(23, 5)), rng.uniform(size=(5, 4))
    at_once = compose(R, S)
    monkeypatch.setattr(relations, "_CHUNK", 60)
    np.testing.assert_array_equal(compose(R, S), at_once)


@given(pair=pairs_of_relations(), name=st.sampled_from(("min", "product", "lukasiewicz")))
@settings(max_examples=100, deadline=None)
def test_interval_composition_is_the_extended_one_of_interval_secondaries(
    pair: tuple[Array, Array], name: str
) -> None:
    """The interval theorem (1.29) against join and meet of the secondaries.

    1e-15 is one rounding.
    """
    widened = [
        np.stack([np.minimum(one, one[::-1]), np.maximum(one, one[::-1])], axis=-1) for one in pair
    ]
    general = [as_sets(one) for one in widened]
    found, extended = (
        compose(widened[0], widened[1], t_norm=name),
        compose(general[0], general[1], t_norm=name),
    )
    np.testing.assert_allclose(
        found, [[one.support for one in row] for row in extended], rtol=0.0, atol=1e-15
    )
    # The ends of what embedded type-1 relations give bound it.
    rng = np.random.default_rng(0)
    for _ in range(5):
        embedded = [
            one[..., 0] + rng.uniform(size=one.shape[:2]) * (one[..., 1] - one[..., 0])
            for one in widened
        ]
        inside = compose(embedded[0], embedded[1], t_norm=name)
        assert (inside >= found[..., 0] - 1e-15).all()
        assert (inside <= found[..., 1] + 1e-15).all()


def as_sets(intervals: Array) -> NDArray[Any]:
    result = np.empty(intervals.shape[:2], dtype=object)
    for index in np.ndindex(result.shape):
        result[index] = Interval(*intervals[index])
    return result


@pytest.mark.parametrize(("name", "grades"), [("min", None), ("product", None), ("product", "min")])
def test_extended_composition_of_discrete_secondaries_is_enumerated(
    name: str, grades: str | None
) -> None:
    """All embedded choices of primary memberships at once.

    The extension principle over all entries that take part.

    With one v there is one meet and no join, so the enumeration of pairs is exact; with two the
    join takes all pairs of the meets.
    """
    rng = np.random.default_rng(3)

    def secondary() -> SampledSet:
        return SampledSet(rng.choice(9, 3, replace=False) / 8.0, rng.integers(1, 9, 3) / 8.0)

    R, S = [[secondary(), secondary()]], [[secondary()], [secondary()]]
    found = compose(R, S, t_norm=name, grade_t_norm=grades)[0, 0]
    member, grade = t_norm(name), t_norm(grades or name)
    expected: dict[float, float] = {}
    entries = [R[0][0], S[0][0], R[0][1], S[1][0]]
    for index in np.ndindex(3, 3, 3, 3):
        u = [entry.points[k] for entry, k in zip(entries, index, strict=True)]
        g = [entry.grades[k] for entry, k in zip(entries, index, strict=True)]
        point = round(float(max(member(u[0], u[1]), member(u[2], u[3]))), 12)
        expected[point] = max(expected.get(point, 0.0), float(grade(*g)))
    assert isinstance(found, SampledSet)
    np.testing.assert_allclose(found.points, sorted(expected), atol=1e-12)
    np.testing.assert_allclose(
        found.grades, [expected[point] for point in sorted(expected)], atol=1e-15
    )


def random_secondaries(rng: np.random.Generator, shape: tuple[int, int]) -> NDArray[Any]:
    """Return a relation of normal discrete secondaries of two or three memberships."""
    result = np.empty(shape, dtype=object)
    for index in np.ndindex(shape):
        size = int(rng.integers(2, 4))
        grades = rng.integers(1, 9, size) / 8.0
        grades[rng.integers(size)] = 1.0
        result[index] = SampledSet(np.sort(rng.choice(9, size, replace=False)) / 8.0, grades)
    return result


@pytest.mark.parametrize(("name", "grades"), [("min", "min"), ("product", "product")])
@pytest.mark.parametrize("seed", range(3))
def test_extended_composition_is_that_of_all_embedded_relations(
    seed: int, name: str, grades: str
) -> None:
    """Eq. 1.62b: one primary membership chosen for every entry of both relations, in all ways.

    Each choice makes two type-1 relations, which are composed by loops and count with the grades of
    all entries, combined; those that take no part have a grade of 1 in some choice, since
    secondaries are normal. At the memberships that come out the best choice counts.
    """
    rng = np.random.default_rng(seed)
    R, S = random_secondaries(rng, (1, 3)), random_secondaries(rng, (3, 2))
    found = compose(R, S, t_norm=name, grade_t_norm=grades)
    entries = [*R.ravel(), *S.ravel()]
    member, combine = t_norm(name), t_norm(grades)
    expected: list[dict[float, float]] = [{}, {}]
    for choice in itertools.product(*(range(len(entry.points)) for entry in entries)):
        picked = [float(entry.points[k]) for entry, k in zip(entries, choice, strict=True)]
        grade = 1.0
        for entry, k in zip(entries, choice, strict=True):
            grade = float(combine(grade, entry.grades[k]))
        for w in range(2):
            value = max(float(member(picked[v], picked[3 + 2 * v + w])) for v in range(3))
            expected[w][value] = max(expected[w].get(value, 0.0), grade)
    for w in range(2):
        points = sorted(expected[w])
        assert isinstance(found[0, w], SampledSet)
        np.testing.assert_allclose(found[0, w].points, points, rtol=0.0, atol=1e-15)
        np.testing.assert_allclose(
            found[0, w].grades, [expected[w][point] for point in points], rtol=0.0, atol=1e-15
        )


def test_general_composition_with_functional_secondaries_and_a_set() -> None:
    A = [Gaussian(0.6, 0.1), Triangular(0.1, 0.2, 0.5)]
    S = [[Gaussian(0.5, 0.2), Singleton(1.0)], [Gaussian(0.8, 0.1), Singleton(0.0)]]
    found = compose(A, S)
    assert found.shape == (2,)
    u = np.linspace(0.0, 1.0, 51)
    for w in range(2):
        expected = join(meet(A[0], S[0][w]), meet(A[1], S[1][w]))
        np.testing.assert_array_equal(found[w](u), expected(u))


@given(sizes=st.lists(st.integers(1, 4), min_size=1, max_size=3), name=st.sampled_from(NAMES))
@settings(max_examples=60, deadline=None)
def test_cartesian_products(sizes: list[int], name: str) -> None:
    rng = np.random.default_rng(sum(sizes))
    grades = [rng.uniform(size=n) for n in sizes]
    found = cartesian_product(*grades, t_norm=name)
    assert found.shape == tuple(sizes)
    for index in np.ndindex(*sizes):
        assert found[index] == t_norm(name)(*(one[k] for one, k in zip(grades, index, strict=True)))
    # A type-1 set among interval sets is an interval without width.
    intervals = cartesian_product(
        np.stack([0.5 * grades[0], grades[0]], axis=-1), *grades[1:], t_norm=name
    )
    assert intervals.shape == (*sizes, 2)
    np.testing.assert_array_equal(intervals[..., 1], found)


def test_cartesian_product_of_general_sets_and_of_mixed_ones() -> None:
    secondaries = [Gaussian(0.5, 0.1), Triangular(0.0, 0.5, 1.0)]
    found = cartesian_product(
        secondaries, [[0.2, 0.4]], [0.7, 0.9, 1.0], t_norm="product", grade_t_norm="min"
    )
    assert found.shape == (2, 1, 3)
    expected = meet(
        secondaries[1], Interval(0.2, 0.4), Singleton(0.9), t_norm="product", grade_t_norm="min"
    )
    u = np.linspace(0.0, 1.0, 33)
    np.testing.assert_array_equal(found[1, 0, 1](u), expected(u))


def test_union_intersection_and_complement_of_relations() -> None:
    rng = np.random.default_rng(5)
    R, S = rng.uniform(size=(2, 3, 4))
    np.testing.assert_array_equal(relation_union(R, S), np.maximum(R, S))
    np.testing.assert_allclose(
        relation_union(R, S, t_conorm="probabilistic"), R + S - R * S, atol=1e-15
    )
    np.testing.assert_array_equal(relation_intersection(R, S, t_norm="product"), R * S)
    np.testing.assert_array_equal(relation_complement(R), 1.0 - R)
    wide = np.stack([0.5 * R, R], axis=-1)
    np.testing.assert_array_equal(
        relation_complement(wide), np.stack([1.0 - R, 1.0 - 0.5 * R], axis=-1)
    )
    np.testing.assert_array_equal(
        relation_intersection(wide, S),
        np.stack([np.minimum(0.5 * R, S), np.minimum(R, S)], axis=-1),
    )
    a, b = SampledSet([0.1, 0.4], [0.5, 1.0]), SampledSet([0.2, 0.3], [1.0, 0.5])
    assert relation_union([[a]], [[b]], grade_t_norm="product")[0, 0] == join(
        a, b, grade_t_norm="product"
    )
    assert relation_intersection([[a]], [[b]], t_norm="product")[0, 0] == meet(
        a, b, t_norm="product"
    )
    assert relation_complement([[a, b]])[0, 1] == negation(b)
    mixed: Type1Set = relation_union([[a]], [[[0.2, 0.3]]])[0, 0]
    assert mixed(0.25) == join(a, Interval(0.2, 0.3))(0.25)


@pytest.mark.parametrize(
    ("R", "S"),
    [
        ([[0.5, 1.5]], [[0.5], [0.5]]),
        ([[0.5, np.nan]], [[0.5], [0.5]]),
        ([[[0.5, 0.4]]], [[[0.5, 0.6]]]),
        ([[0.5, 0.5]], [[0.5]]),
        ([[0.5]], [[[0.1, 0.2]]]),
        ([[0.5]], [["a"]]),
        ([["a"]], [[0.5]]),
        ([[0.5, 0.5], [0.5]], [[0.5]]),
        ([[Singleton(0.5)]], [[0.5]]),
        (Singleton(0.5), [[Singleton(0.5)]]),
        ([[Singleton(0.5)], [Singleton(0.5), Singleton(0.5)]], [[Singleton(0.5)]]),
        (np.empty((0, 2)), [[0.5], [0.5]]),
    ],
)
def test_what_is_no_relation_is_refused(R: Any, S: Any) -> None:
    with pytest.raises(InvalidValue):
        compose(R, S)


def test_unequal_universes_and_nothing_at_all_are_refused() -> None:
    with pytest.raises(InvalidValue, match="same universes"):
        relation_union([[0.5]], [[0.5, 0.5]])
    with pytest.raises(InvalidValue, match="at least one"):
        relation_intersection()
    with pytest.raises(InvalidValue, match="at least one"):
        cartesian_product()
    with pytest.raises(InvalidValue, match="a set"):
        cartesian_product(0.5)
