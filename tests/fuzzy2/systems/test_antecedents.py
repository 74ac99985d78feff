"""Rules that are trees: compiled, by NumPy, and by hand."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import fuzzy2
from fuzzy2.errors import InvalidValue
from fuzzy2.systems import GeneralType2System, IntervalType2System, Type1System
from fuzzy2.systems.antecedents import And, Antecedent, Hedged, Is, Not, Or, rows_of, trees_of
from fuzzy2.systems.hedges import HEDGES

TERMS = [[fuzzy2.GaussianUncertainSigma(c, (0.6, 0.9)) for c in (-1.0, 1.0)]] * 2
BOTH = {
    "product": lambda a, b: a * b,
    "min": min,
    "lukasiewicz": lambda a, b: max(a + b - 1.0, 0.0),
    "hamacher": lambda a, b: a * b / (a + b - a * b) if a + b > 0.0 else 0.0,
    "einstein": lambda a, b: a * b / (2.0 - (a + b - a * b)),
}
EITHER = {
    "max": max,
    "probabilistic": lambda a, b: a + b - a * b,
    "lukasiewicz": lambda a, b: min(a + b, 1.0),
    "drastic": lambda a, b: 1.0 if min(a, b) > 0.0 else max(a, b),
    "einstein": lambda a, b: (a + b) / (1.0 + a * b),
}

_leaves = st.builds(Is, st.integers(0, 1), st.none() | st.integers(0, 1))
_trees = st.recursive(
    _leaves,
    lambda parts: (
        st.builds(lambda some: And(tuple(some)), st.lists(parts, min_size=1, max_size=3))
        | st.builds(lambda some: Or(tuple(some)), st.lists(parts, min_size=1, max_size=3))
        | st.builds(Not, parts)
        | st.builds(Hedged, st.sampled_from(list(HEDGES.values())), parts)
    ),
    max_leaves=8,
)


def by_hand(tree: Antecedent, x: np.ndarray, norm: str, conorm: str) -> tuple[float, float]:
    match tree:
        case Is(variable, term):
            if term is None:
                return 1.0, 1.0
            item = TERMS[int(variable)][int(term)]
            return float(item.lower(x[variable])), float(item.upper(x[variable]))
        case Not(part):
            low, high = by_hand(part, x, norm, conorm)
            return 1.0 - high, 1.0 - low
        case Hedged(hedge, part):
            low, high = by_hand(part, x, norm, conorm)
            return low**hedge.power, high**hedge.power
    combine = BOTH[norm] if isinstance(tree, And) else EITHER[conorm]
    ends = [by_hand(part, x, norm, conorm) for part in tree.parts]
    low, high = ends[0]
    for other in ends[1:]:
        low, high = combine(low, other[0]), combine(high, other[1])
    return low, high


@settings(deadline=None)
@given(
    trees=st.lists(_trees, min_size=2, max_size=4),
    norm=st.sampled_from(sorted(BOTH)),
    conorm=st.sampled_from(sorted(EITHER)),
    seed=st.integers(0, 1000),
)
def test_trees_fire_as_by_hand_compiled_and_not(
    trees: list[Antecedent], norm: str, conorm: str, seed: int
) -> None:
    """To 1e-12, with weights, silence and default outputs; both loops give one answer."""
    rng = np.random.default_rng(seed)
    count = len(trees)
    silent = rng.random((count, 2)) < 0.4
    silent[silent.all(axis=1), 0] = False
    weights = rng.choice([0.0, 0.3, 1.0], count)
    system = IntervalType2System(
        TERMS,
        tuple(trees),
        rng.normal(size=(count, 2)),
        norm,
        disjunction=conorm,
        weights=weights,
        silent=silent,
        default_outputs=[7.0, None],
    )
    X = rng.normal(size=(4, 2))
    expected = np.array([[by_hand(tree, x, norm, conorm) for tree in trees] for x in X])
    firing = np.sort(expected * weights[:, np.newaxis])
    np.testing.assert_allclose(system.firing(X), firing, atol=1e-12)
    assert system.table is not None
    for x, strengths, found in zip(X, firing, system.type_reduced(X), strict=True):
        for j in range(2):
            said = np.where(silent[:, [j]], 0.0, strengths)
            if 0.0 < said.max() < 1e-12:
                # What rounding leaves of 1 - 1, by hand or in the loop.
                continue
            if not said.any():
                ends = np.full(2, [7.0, np.nan][j])
            else:
                ends = fuzzy2.generalized_centroid(system.consequents[:, j], said)
            np.testing.assert_allclose(found[j], ends, atol=1e-9)
        np.testing.assert_allclose(system(x), found.mean(axis=-1), atol=1e-12)
    slow = system.replace()
    slow._table, slow._fast = None, False
    np.testing.assert_allclose(slow.type_reduced(X), system.type_reduced(X), atol=1e-9)


def test_conjunctions_are_numbers_of_terms() -> None:
    rules = np.array([[0, 1], [-1, 0]])
    np.testing.assert_array_equal(rows_of(trees_of(rules), 2), rules)
    system = Type1System([[fuzzy2.Gaussian(0, 1)]] * 2, trees_of(np.array([[0, -1]])), [[1.0]])
    np.testing.assert_array_equal(system.rules, [[0, -1]])
    assert rows_of([Not(Is(0, 0))], 1) is None


@pytest.mark.parametrize("tree", [Is(2, 0), Is(0, 5), And(()), "x is Low", Not(Is(0, -1))])
def test_trees_that_ask_for_nothing_there_is_are_refused(tree: object) -> None:
    with pytest.raises(InvalidValue, match="rule 1"):
        Type1System([[fuzzy2.Gaussian(0, 1)]] * 2, [tree], [[1.0]])


def test_general_type_2_systems_take_trees_plane_by_plane() -> None:
    sets = [
        [fuzzy2.GaussianType2Set(principal=fuzzy2.Gaussian(c, 0.7), sigma=0.05) for c in (-1, 1)]
    ]
    rules = (Or((Is(0, 0), Not(Is(0, 1)))), Hedged(HEDGES["very"], Is(0, 1)))
    options = {"weights": [0.5, 1.0], "levels": 3}
    system = GeneralType2System(sets, rules, [[0.0], [1.0]], **options)
    X = np.linspace(-2.0, 2.0, 5)[:, np.newaxis]
    cuts = []
    for alpha in system.alphas:
        planes = [[term.alpha_plane(alpha) for term in sets[0]]]
        plane = IntervalType2System(planes, rules, [[0.0], [1.0]], weights=[0.5, 1.0])
        cuts.append(plane.type_reduced(X))
    np.testing.assert_allclose(system.alpha_cuts(X), np.stack(cuts, axis=2), atol=1e-12)
