"""Join, meet and negation against brute force.

The theorems in their corrected form, and the counterexamples to their misuse.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import reduce
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from fuzzy2.errors import InvalidValue, NotApplicable, UnknownName
from fuzzy2.operations.continuous_meet import ContinuousMeet
from fuzzy2.operations.join_meet import METHODS, join, meet, negation
from fuzzy2.operations.t_norms import T_NORMS, t_conorm, t_norm
from fuzzy2.sets.shapes import Gaussian, Interval, Trapezoidal, Triangular
from fuzzy2.sets.sigmoids import Sigmoid
from fuzzy2.sets.smooth_shapes import Bell
from fuzzy2.sets.type1 import SampledSet, Singleton, Type1Set
from tests import examples
from tests.fuzzy2.operations.any_sets import convex_functions, discrete_sets

Array = NDArray[np.float64]

THETA = np.arange(201) / 200.0  # holds twentieths to the last digit, which linspace does not

OPERATIONS: dict[str, Callable[..., Type1Set]] = {"join": join, "meet": meet}

BOTH = pytest.mark.parametrize("kind", ["join", "meet"])

GRADE_NORMS = pytest.mark.parametrize("grades", ["min", "product", "lukasiewicz"])


def brute_force(
    first: SampledSet, second: SampledSet, combine: Callable[[float, float], Any], grades: str
) -> dict[float, float]:
    """Enumerate all pairs.

    Points that agree to nine digits are one (the test sets have coarse points).
    """
    norm = t_norm(grades)
    result: dict[float, float] = {}
    for u, f in zip(first.points, first.grades, strict=True):
        for w, g in zip(second.points, second.grades, strict=True):
            point = round(float(combine(float(u), float(w))), 9)
            result[point] = max(result.get(point, 0.0), float(norm(f, g)))
    return result


def assert_same(found: Type1Set, expected: dict[float, float], tolerance: float = 1e-15) -> None:
    assert isinstance(found, SampledSet)
    order = sorted(expected)
    np.testing.assert_allclose(found.points, order, rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(
        found.grades, [expected[point] for point in order], rtol=0.0, atol=tolerance
    )


@st.composite
def unimodal_sets(draw: st.DrawFn, normal: bool = True) -> SampledSet:
    """Convex sets on the same eleven points; normal unless allowed to be lower."""
    top = 16 if normal else draw(st.integers(1, 16))
    before = sorted(draw(st.lists(st.integers(0, top), max_size=10)))
    after = sorted(
        draw(st.lists(st.integers(0, top), min_size=10 - len(before), max_size=10 - len(before))),
        reverse=True,
    )
    return SampledSet(np.arange(11) / 10.0, np.array([*before, top, *after]) / 16.0)


# --- published vectors ----------------------------------------------------------------------------


# Operands from carmelgafa/type2fuzzy_papers, "approach_type2fuzzy_arithmetic"; results by
# enumeration of all nine pairs.
F = SampledSet([0.0, 0.1, 0.2], [0.5, 0.7, 0.3])

G = SampledSet([0.1, 0.2, 0.3], [0.9, 0.7, 0.6])


@pytest.mark.parametrize(
    ("found", "expected"),
    [
        (join(F, G, t_norm="min"), {0.1: 0.7, 0.2: 0.7, 0.3: 0.6}),
        (meet(F, G, t_norm="min"), {0.0: 0.5, 0.1: 0.7, 0.2: 0.3}),
        (meet(F, G, t_norm="min", grade_t_norm="product"), {0.0: 0.45, 0.1: 0.63, 0.2: 0.21}),
        (
            meet(F, G, t_norm="product", grade_t_norm="min"),
            {0.0: 0.5, 0.01: 0.7, 0.02: 0.7, 0.03: 0.6, 0.04: 0.3, 0.06: 0.3},
        ),
    ],
    ids=[
        "discrete_join_max_tmin",
        "discrete_meet_min_tmin",
        "discrete_meet_min_tprod",
        "discrete_meet_product_tmin",
    ],
)
def test_published_discrete_joins_and_meets(found: Type1Set, expected: dict[float, float]) -> None:
    assert_same(found, expected, 1e-12)


# --- discrete sets --------------------------------------------------------------------------------


@BOTH
@GRADE_NORMS
@given(first=discrete_sets(), second=discrete_sets())
@settings(max_examples=examples(250, of=6))
def test_discrete_extremum_is_that_of_all_pairs(
    kind: str, grades: str, first: SampledSet, second: SampledSet
) -> None:
    found = OPERATIONS[kind](first, second, grade_t_norm=grades)
    assert_same(found, brute_force(first, second, max if kind == "join" else min, grades))


@GRADE_NORMS
@pytest.mark.parametrize("name", ["product", "lukasiewicz", "hamacher", "drastic"])
@given(first=discrete_sets(), second=discrete_sets())
@settings(max_examples=examples(100, of=12))
def test_discrete_meet_and_join_by_any_norm_are_those_of_all_pairs(
    grades: str, name: str, first: SampledSet, second: SampledSet
) -> None:
    assert_same(
        meet(first, second, t_norm=name, grade_t_norm=grades),
        brute_force(first, second, t_norm(name), grades),
    )
    conorm = {"product": "probabilistic"}.get(name, name)
    found = join(first, second, t_conorm=conorm, grade_t_norm=grades)
    assert_same(found, brute_force(first, second, t_conorm(conorm), grades))


@BOTH
@pytest.mark.parametrize("name", ["min", "product"])
@GRADE_NORMS
@given(sets=st.lists(discrete_sets(), min_size=3, max_size=4), data=st.data())
@settings(max_examples=examples(60, of=12))
def test_many_sets_at_once_in_any_order_are_pairs_in_turn(
    kind: str, name: str, grades: str, sets: list[SampledSet], data: st.DataObject
) -> None:
    """Commutative and associative up to rounding.

    1e-14 is some ulps of products of four grades, 1e-12 where points merge.
    """
    operation: Callable[..., Any] = OPERATIONS[kind]
    options = {"t_norm": name, "grade_t_norm": grades}
    at_once = operation(*sets, **options)
    in_turn = reduce(lambda a, b: operation(a, b, **options), data.draw(st.permutations(sets)))
    assert isinstance(at_once, SampledSet)
    assert isinstance(in_turn, SampledSet)
    np.testing.assert_allclose(at_once.points, in_turn.points, rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(at_once.grades, in_turn.grades, rtol=0.0, atol=1e-14)


def test_without_a_grade_t_norm_the_grades_take_the_same_one() -> None:
    assert meet(F, G, t_norm="product") == meet(F, G, t_norm="product", grade_t_norm="product")
    assert join(F, G, t_norm="product") == join(F, G, grade_t_norm="product")
    assert join(F, G, t_norm="product") != join(F, G)


def test_points_within_1e_12_merge_by_the_maximum() -> None:
    first, second = SampledSet([0.3], [0.4]), SampledSet([0.1 + 0.2, 0.1], [0.9, 1.0])
    assert second.points[1] != first.points[0]
    assert join(first, second) == SampledSet([0.3], [0.4])
    found = meet(
        SampledSet([0.5, 0.25], [1.0, 0.75]), SampledSet([0.5, 1.0], [0.5, 1.0]), t_norm="product"
    )
    # 0.25 is 0.5 · 0.5 (grade 0.5) and 0.25 · 1 (0.75)
    assert found == SampledSet([0.125, 0.25, 0.5], [0.375, 0.75, 1.0])


@given(first=discrete_sets(), second=discrete_sets())
@settings(max_examples=examples(300, of=6))
def test_de_morgan_for_the_minimum_and_for_dual_pairs(
    first: SampledSet, second: SampledSet
) -> None:
    """Points are twentieths, whose complements round to 1e-16; the grades are the same numbers."""
    for norm, conorm in (
        ("min", "max"),
        ("product", "probabilistic"),
        ("lukasiewicz", "lukasiewicz"),
    ):
        for grades in ("min", "product"):
            left = negation(join(first, second, t_conorm=conorm, grade_t_norm=grades))
            right = meet(negation(first), negation(second), t_norm=norm, grade_t_norm=grades)
            assert isinstance(left, SampledSet)
            assert isinstance(right, SampledSet)
            np.testing.assert_allclose(left.points, right.points, rtol=0.0, atol=1e-12)
            np.testing.assert_array_equal(left.grades, right.grades)


@pytest.mark.slow
@given(first=unimodal_sets(), second=unimodal_sets(), third=unimodal_sets())
@settings(max_examples=300, deadline=None)
def test_absorption_and_the_rest_of_a_lattice_for_convex_normal_sets_under_the_minimum(
    first: SampledSet, second: SampledSet, third: SampledSet
) -> None:
    """Grades under minimum and maximum are never computed with, so they are equal, not close."""
    assert join(first, first) == first
    assert meet(first, first) == first

    def equal(a: Type1Set, b: Type1Set) -> bool:
        # Where a join or meet cannot reach a point, the point is left out; its grade is 0.
        grid = first.points
        return np.array_equal(on_grid(a, grid), on_grid(b, grid))

    assert equal(join(first, meet(first, second)), first)
    assert equal(meet(first, join(first, second)), first)
    assert equal(meet(first, join(second, third)), join(meet(first, second), meet(first, third)))
    assert equal(join(first, meet(second, third)), meet(join(first, second), join(first, third)))


def on_grid(discrete: Type1Set, grid: Array) -> Array:
    """Return grades at the points of a grid, 0 where the discrete set has no point."""
    assert isinstance(discrete, SampledSet)
    result = np.zeros(grid.size)
    result[np.searchsorted(grid, discrete.points - 1e-9)] = discrete.grades
    return result


def test_what_fails_under_the_product() -> None:
    """The counterexamples of the errata."""
    # De Morgan: the right side has a second way to 0.5, which the left one has not. The gap is
    # 0.75.
    first, second = SampledSet([0.5], [1.0]), SampledSet([0.0, 0.5], [0.25, 1.0])
    left = negation(join(first, second, t_norm="product"))
    right = meet(negation(first), negation(second), t_norm="product")
    assert left == SampledSet([0.5], [1.0])
    assert right == SampledSet([0.25, 0.5], [1.0, 0.25])
    assert abs(left(0.5) - right(0.5)) == 0.75
    # The join is not idempotent: on the rising side grades are squared, by up to 0.25.
    triangle = Triangular(0.0, 0.5, 1.0)
    gap = np.abs(join(triangle, triangle, t_norm="product")(THETA) - triangle(THETA))
    assert gap.max() == pytest.approx(0.25, abs=1e-15)
    # Absorption fails for the same reason.
    absorbed = meet(triangle, join(triangle, triangle, t_norm="product"), t_norm="product")
    assert np.abs(absorbed(THETA) - triangle(THETA)).max() > 0.2


def test_meet_does_not_distribute_over_join_under_the_product() -> None:
    a, b, c = (
        SampledSet([0.2, 0.5], [0.6, 1.0]),
        SampledSet([0.3, 0.6], [1.0, 0.8]),
        SampledSet([0.4, 0.7], [0.9, 1.0]),
    )
    left = meet(a, join(b, c, t_norm="product"), t_norm="product")
    right = join(meet(a, b, t_norm="product"), meet(a, c, t_norm="product"), t_norm="product")
    assert left != right


def test_lukasiewicz_grades_may_leave_nothing() -> None:
    assert meet(
        SampledSet([0.3], [0.4]), SampledSet([0.5], [0.5]), grade_t_norm="lukasiewicz"
    ) == SampledSet([0.3], [0.0])


# --- theorem 1.1 ----------------------------------------------------------------------------------


def pairs_on_the_grid(kind: str, sets: list[Type1Set], grades: str) -> Array:
    """Return the join or meet on THETA by enumeration of pairs of grid points, set after set."""
    norm = t_norm(grades)
    result = sets[0](THETA)
    for other in sets[1:]:
        table = norm(result[:, None], other(THETA)[None, :])
        outer = np.maximum if kind == "join" else np.minimum
        target = outer(np.arange(THETA.size)[:, None], np.arange(THETA.size)[None, :])
        combined = np.zeros(THETA.size)
        np.maximum.at(combined, target, table)
        result = combined
    return result


@BOTH
@GRADE_NORMS
@given(sets=st.lists(convex_functions(), min_size=2, max_size=4))
@settings(max_examples=examples(150, of=6))
def test_theorem_1_1_agrees_with_all_pairs_and_with_the_general_formula(
    kind: str, grades: str, sets: list[Type1Set]
) -> None:
    """Peaks are on the grid, where the suprema are attained, so only rounding is left.

    1e-14 for products of four grades.

    Beyond the grid the sets have nothing that counts on it: for a join what lies below 0 is lower
    than what lies at 0.
    """
    operation = OPERATIONS[kind]
    assume(all(operand.is_normal() for operand in sets))
    expected = pairs_on_the_grid(kind, sets, grades)
    for method in ("auto", "theorem_1_1", "general"):
        found = operation(*sets, grade_t_norm=grades, method=method)
        np.testing.assert_allclose(found(THETA), expected, rtol=0.0, atol=1e-14)


@pytest.mark.slow
@BOTH
@GRADE_NORMS
@given(sets=st.lists(convex_functions(normal=False), min_size=2, max_size=4))
@settings(max_examples=examples(150, of=6))
def test_without_normality_the_general_formula_still_agrees_with_all_pairs(
    kind: str, grades: str, sets: list[Type1Set]
) -> None:
    found = OPERATIONS[kind](*sets, grade_t_norm=grades)
    np.testing.assert_allclose(
        found(THETA), pairs_on_the_grid(kind, sets, grades), rtol=0.0, atol=1e-14
    )


@BOTH
@GRADE_NORMS
@given(sets=st.lists(unimodal_sets(), min_size=2, max_size=4))
@settings(max_examples=examples(100, of=6))
def test_theorem_1_1_for_discrete_sets_at_the_same_points(
    kind: str, grades: str, sets: list[SampledSet]
) -> None:
    by_theorem = OPERATIONS[kind](*sets, grade_t_norm=grades, method="theorem_1_1")
    general = OPERATIONS[kind](*sets, grade_t_norm=grades, method="general")
    np.testing.assert_allclose(
        on_grid(by_theorem, sets[0].points), on_grid(general, sets[0].points), rtol=0.0, atol=1e-15
    )


def test_first_row_of_1_15_is_a_maximum_and_of_1_14_a_minimum() -> None:
    """The proof prints them the wrong way round in 1.19; an error of 0.85 for these two sets."""
    low, high = Gaussian(0.4, 0.1), Gaussian(0.6, 0.2)
    theta = np.linspace(0.0, 0.39, 40)
    np.testing.assert_array_equal(join(low, high)(theta), np.minimum(low(theta), high(theta)))
    np.testing.assert_array_equal(meet(low, high)(theta), np.maximum(low(theta), high(theta)))
    theta = np.linspace(0.6, 1.0, 40)
    np.testing.assert_array_equal(join(low, high)(theta), np.maximum(low(theta), high(theta)))
    np.testing.assert_array_equal(meet(low, high)(theta), np.minimum(low(theta), high(theta)))


@BOTH
def test_theorem_1_1_is_refused_where_it_would_be_wrong(kind: str) -> None:
    operation = OPERATIONS[kind]
    low = Triangular(0.0, 0.3, 0.6, height=0.8)
    normal = Triangular(0.2, 0.5, 1.0)
    two_peaks = SampledSet([0.0, 0.3, 0.5, 0.8, 1.0], [0.0, 1.0, 0.0, 1.0, 0.0])
    with pytest.raises(NotApplicable, match=r"not normal: its height is 0\.8"):
        operation(low, normal, method="theorem_1_1")
    with pytest.raises(NotApplicable, match="is not convex"):
        operation(two_peaks, normal, method="theorem_1_1")
    with pytest.raises(NotApplicable, match="same points"):
        operation(SampledSet([0.1], [1.0]), SampledSet([0.2], [1.0]), method="theorem_1_1")
    with pytest.raises(NotApplicable, match="never reaches"):
        operation(Sigmoid(0.5, 10.0), normal, method="theorem_1_1")
    # What is refused is done right instead, also automatically. The theorem would be off by 0.2 and
    # 1.0.
    np.testing.assert_allclose(
        operation(low, normal)(THETA), pairs_on_the_grid(kind, [low, normal], "min"), atol=1e-15
    )
    found = operation(two_peaks, normal)(THETA)
    np.testing.assert_allclose(
        found, pairs_on_the_grid(kind, [two_peaks, normal], "min"), atol=1e-15
    )


@pytest.mark.parametrize("method", ["theorem_1_1", "shift", "intervals"])
def test_theorems_of_the_minimum_are_refused_for_the_product_meet(method: Any) -> None:
    with pytest.raises(NotApplicable, match=r"t-norm product|not all sets"):
        meet(Gaussian(0.5, 0.1), Gaussian(0.6, 0.1), t_norm="product", method=method)


# --- shift corollary and interval theorem ---------------------------------------------------------


@BOTH
@pytest.mark.parametrize(
    "shape",
    [
        lambda k: Gaussian(0.2 + k, 0.1),
        lambda k: Triangular(k, 0.2 + k, 0.3 + k),
        lambda k: Trapezoidal(k, 0.1 + k, 0.15 + k, 0.3 + k),
        lambda k: Bell(0.2 + k, 0.1, 2.0),
    ],
)
def test_shifted_sets_join_to_the_last_and_meet_to_the_first(
    kind: str, shape: Callable[[float], Type1Set]
) -> None:
    sets = [shape(k) for k in (0.3, 0.0, 0.5, 0.1)]
    expected = sets[2] if kind == "join" else sets[1]
    assert OPERATIONS[kind](*sets) == expected
    assert OPERATIONS[kind](*sets, method="shift") == expected
    general = OPERATIONS[kind](*sets, method="general")(THETA)
    np.testing.assert_allclose(general, expected(THETA), rtol=0.0, atol=1e-12)


@BOTH
def test_the_shift_corollary_is_refused_where_it_does_not_hold(kind: str) -> None:
    operation = OPERATIONS[kind]
    with pytest.raises(NotApplicable, match="minimum only"):
        operation(Gaussian(0.2, 0.1), Gaussian(0.5, 0.1), grade_t_norm="product", method="shift")
    with pytest.raises(NotApplicable, match="shifted"):
        operation(Gaussian(0.2, 0.1), Gaussian(0.5, 0.2), method="shift")
    with pytest.raises(NotApplicable, match="shifted"):
        operation(Gaussian(0.2, 0.1), Triangular(0.0, 0.2, 0.4), method="shift")
    with pytest.raises(NotApplicable, match="normal"):
        operation(Gaussian(0.2, 0.1, 0.9), Gaussian(0.5, 0.1, 0.9), method="shift")
    with pytest.raises(NotApplicable, match="no parameters"):
        operation(
            SampledSet([0.1, 0.2], [1.0, 0.5]), SampledSet([0.2, 0.3], [1.0, 0.5]), method="shift"
        )
    # Under product grades the join of a Gaussian with its shifted self is another set: left of
    # both, f1 f2 instead of f2.
    found = join(Gaussian(0.4, 0.1), Gaussian(0.5, 0.1), grade_t_norm="product")(THETA)
    assert np.abs(found - Gaussian(0.5, 0.1)(THETA)).max() == pytest.approx(0.0548, abs=1e-4)


@given(
    ends=st.lists(st.tuples(st.integers(0, 10), st.integers(0, 10)), min_size=1, max_size=4),
    name=st.sampled_from(tuple(T_NORMS)),
)
@settings(max_examples=200, deadline=None)
def test_intervals_meet_and_join_end_by_end(ends: list[tuple[int, int]], name: str) -> None:
    sets = [Interval(min(pair) / 10.0, max(pair) / 10.0) for pair in ends]
    norm = t_norm(name)
    if not norm.continuous:
        with pytest.raises(NotApplicable, match="gaps"):
            meet(*sets, t_norm=name)
        return
    lefts, rights = [one.left for one in sets], [one.right for one in sets]
    found = meet(*sets, t_norm=name)
    assert found == Interval(float(norm(*lefts)), float(norm(*rights)))
    assert meet(*sets, t_norm=name, method="intervals") == found
    assert join(*sets, t_norm=name) == Interval(max(lefts), max(rights))
    conorm = t_conorm({"min": "max", "product": "probabilistic"}.get(name, name))
    assert join(*sets, t_conorm=conorm) == Interval(float(conorm(*lefts)), float(conorm(*rights)))


def test_the_interval_theorem_agrees_with_the_general_way_and_is_refused_for_other_sets() -> None:
    a, b = Interval(0.2, 0.5), Interval(0.4, 0.75)
    for operation in (join, meet):
        np.testing.assert_array_equal(
            operation(a, b, method="general")(THETA), operation(a, b)(THETA)
        )
        with pytest.raises(NotApplicable, match="not all sets are intervals"):
            operation(a, Gaussian(0.5, 0.1), method="intervals")
    by_search = meet(a, b, t_norm="product", method="general")
    by_cuts = meet(a, b, t_norm="product", grade_t_norm="min", method="general")
    for found in (by_search, by_cuts):
        theta = np.array([0.0, 0.0799999, 0.08, 0.2, 0.375, 0.3750001, 1.0, np.nan])
        np.testing.assert_array_equal(found(theta), [0.0, 0.0, 1.0, 1.0, 1.0, 0.0, 0.0, np.nan])
    with pytest.raises(InvalidValue, match=r"\[0, 1\]"):
        meet(Interval(0.0, 2.0), a, t_norm="product")


def test_singletons_are_crisp_grades() -> None:
    assert join(Singleton(0.3), Singleton(0.6)) == Singleton(0.6)
    assert meet(Singleton(0.3), Singleton(0.6), Singleton(0.5), t_norm="product") == Singleton(
        0.3 * 0.6 * 0.5
    )
    assert meet(Singleton(0.3), Singleton(0.6), t_norm="drastic") == Singleton(0.0)
    assert join(Singleton(0.3), Singleton(0.6), method="general") == Singleton(0.6)
    assert meet(Singleton(0.5), Singleton(0.5), t_norm="product", method="general") == Singleton(
        0.25
    )
    assert negation(Singleton(0.25)) == Singleton(0.75)
    # A singleton with a function scales it under the product.
    scaled = meet(Singleton(0.5), Triangular(0.2, 0.4, 0.8), t_norm="product")
    np.testing.assert_allclose(
        scaled(THETA), Triangular(0.1, 0.2, 0.4)(THETA), rtol=0.0, atol=1e-12
    )


# --- meets under other t-norms --------------------------------------------------------------------


def test_a_sampled_set_among_functions_counts_by_its_linear_interpolation() -> None:
    corners = SampledSet([0.2, 0.4, 0.8], [0.0, 1.0, 0.0])
    triangle, other = Triangular(0.2, 0.4, 0.8), Gaussian(0.5, 0.1)
    for name in ("min", "product"):
        for operation in (join, meet):
            found = operation(corners, other, t_norm=name)(THETA)
            np.testing.assert_allclose(
                found, operation(triangle, other, t_norm=name)(THETA), rtol=0.0, atol=1e-9
            )


def test_t_norms_with_jumps_are_refused_for_functions() -> None:
    with pytest.raises(NotApplicable, match="continuous"):
        meet(Gaussian(0.5, 0.1), Gaussian(0.6, 0.1), t_norm="drastic")
    with pytest.raises(NotApplicable, match="continuous"):
        join(Gaussian(0.5, 0.1), Gaussian(0.6, 0.1), t_conorm="nilpotent")
    for one in (SampledSet([0.5, 1.5], [1.0, 1.0]), SampledSet([-0.5, 0.5], [1.0, 1.0])):
        with pytest.raises(InvalidValue, match=r"\[0, 1\]"):
            meet(one, one, t_norm="product")
        with pytest.raises(InvalidValue, match=r"\[0, 1\]"):
            meet(one, Gaussian(0.5, 0.1), t_norm="product")


# --- parts ----------------------------------------------------------------------------------------


def test_wrong_arguments_are_refused() -> None:
    with pytest.raises(InvalidValue, match="at least one"):
        join()
    with pytest.raises(InvalidValue, match="by keyword"):
        meet(Gaussian(0.5, 0.1), Gaussian(0.6, 0.1), "product")  # type: ignore[arg-type]
    with pytest.raises(UnknownName, match="theorem_1_1"):
        meet(Gaussian(0.5, 0.1), Gaussian(0.6, 0.1), method="fast")  # type: ignore[arg-type]
    with pytest.raises(UnknownName, match="theorem_1_1"):
        meet(
            Gaussian(0.5, 0.1),
            Gaussian(0.6, 0.1),
            t_norm="product",
            method="fast",  # type: ignore[arg-type]
        )
    with pytest.raises(UnknownName, match="lukasiewicz"):
        meet(F, G, t_norm="multiply")
    assert "auto" in METHODS


def test_a_single_set_is_its_own_join_and_meet() -> None:
    for name in ("min", "product"):
        assert meet(Gaussian(0.5, 0.1), t_norm=name) == Gaussian(0.5, 0.1)
        assert join(F, t_norm=name) == F
        assert meet(F, t_norm=name) == F
    assert ContinuousMeet((Gaussian(0.5, 0.1),), t_norm("product"), t_norm("min")).operands == (
        Gaussian(0.5, 0.1),
    )
