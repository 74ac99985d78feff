"""What validating a system finds."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from numpy.typing import NDArray

import fuzzy2
from fuzzy2.errors import ApproximationWarning, InvalidValue
from fuzzy2.systems import GeneralType2System, IntervalType2System, Type1System
from tests.fuzzy2.systems.by_hand import (
    GRID_RULES,
    principal,
    uncertain,
)

Array = NDArray[np.float64]


def test_one_warning_at_construction_and_none_per_call(consequents: Array, X: Array) -> None:
    with pytest.warns(ApproximationWarning) as caught:
        system = GeneralType2System(principal(0.05), GRID_RULES, consequents, reduction="gaussian")
    assert len(caught) == 1
    system(X)
    GeneralType2System(principal(0.001), GRID_RULES, consequents, reduction="gaussian")


def test_no_rule_fires_is_nan_and_validate_says_where() -> None:
    terms = [[fuzzy2.Triangular(0.0, 1.0, 2.0), fuzzy2.Triangular(4.0, 5.0, 6.0)]]
    system = Type1System(terms, [[0], [1]], [[1.0], [2.0]])
    assert np.isnan(system([[3.0]])).all()
    assert np.isnan(system.type_reduced([3.0])).all()
    assert np.isnan(system.validity([3.0]))
    report = system.validate(points=41)
    assert not report.ok
    np.testing.assert_allclose(
        [report.uncovered.min(), report.uncovered.max()], [2.0, 4.0], atol=0.1
    )
    assert "no rule fires on" in str(report)


def test_validate_finds_unused_terms_duplicates_and_conflicts() -> None:
    rules = [[0, 0], [0, 0], [0, 0], [1, 0]]
    system = IntervalType2System(
        uncertain()[:2],
        rules,
        [[1.0], [1.0], [2.0], [3.0]],
        input_names=["e", "de"],
        term_names=[["N", "P"]] * 2,
    )
    report = system.validate()
    assert report.unused_terms == [("de", "P")]
    assert report.duplicate_rules == [(0, 1)]
    assert report.conflicting_rules == [(0, 2)]
    assert IntervalType2System(uncertain(), GRID_RULES, np.ones((8, 1))).validate().ok


@pytest.mark.parametrize("points", [1, 2.5, True, [[-3.0, 3.0]], None])
def test_validate_takes_a_number_of_points(points: object, consequents: Array) -> None:
    with pytest.raises(InvalidValue, match="points"):
        IntervalType2System(
            uncertain(),
            GRID_RULES,
            consequents,  # type: ignore[arg-type]
        ).validate(points)


@pytest.mark.parametrize(
    ("feet", "said"),
    [
        ([-4.0, 0.0, 4.0], "no rule fires at the point (0)"),
        ([-4.0, -1.0, 1.0, 4.0], "no rule fires at the point (-1) and 1 other single point"),
    ],
)
def test_single_points_are_no_share_of_the_input_space(feet: list[float], said: str) -> None:
    """Triangles that touch at their feet leave a point of the grid out, and no length."""
    terms = [fuzzy2.Triangular(a, 0.5 * (a + b), b) for a, b in itertools.pairwise(feet)]
    rules = np.arange(len(terms))[:, np.newaxis]
    report = Type1System([terms], rules, np.ones((len(terms), 1))).validate(5, 0.0, [(-2.0, 2.0)])
    assert report.coverage == 1.0
    assert not report.ok
    assert str(report) == said
