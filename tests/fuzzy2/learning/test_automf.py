"""Partitions by name."""

from __future__ import annotations

import numpy as np
import pytest

import fuzzy2
from fuzzy2.errors import InvalidValue


def test_three_terms_are_those_of_scikit_fuzzy() -> None:
    """Its ``automf(3)`` on 0 to 10: triangles (-5, 0, 5), (0, 5, 10) and (5, 10, 15)."""
    assert fuzzy2.automf(0.0, 10.0) == {
        "poor": fuzzy2.Triangular(-5.0, 0.0, 5.0),
        "average": fuzzy2.Triangular(0.0, 5.0, 10.0),
        "good": fuzzy2.Triangular(5.0, 10.0, 15.0),
    }


@pytest.mark.parametrize("terms", [2, 4, 5, 7, ["cold", "mild", "hot"]])
def test_grades_add_up_to_1(terms: int | list[str]) -> None:
    made = fuzzy2.automf(-2.0, 5.0, terms)
    x = np.linspace(-2.0, 5.0, 101)
    np.testing.assert_allclose(sum(term(x) for term in made.values()), 1.0, atol=1e-14)
    assert len(made) == (terms if isinstance(terms, int) else 3)


def test_names_are_those_that_are_known_or_given() -> None:
    assert list(fuzzy2.automf(0, 1, 7)) == [
        "dismal",
        "poor",
        "mediocre",
        "average",
        "decent",
        "good",
        "excellent",
    ]
    assert list(fuzzy2.automf(0, 1, 4)) == ["term1", "term2", "term3", "term4"]
    assert list(fuzzy2.automf(0, 1, ("cold", "hot"))) == ["cold", "hot"]


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        ((1.0, 1.0), "greatest"),
        ((0.0, 1.0, 1), "terms"),
        ((0.0, 1.0, ["one"]), "terms"),
        ((0.0, 1.0, ["one", "one"]), "terms"),
        ((0.0, 1.0, "one"), "terms"),
        ((0.0, 1.0, 2.5), "terms"),
    ],
)
def test_what_is_no_partition_is_refused(arguments: tuple[object, ...], named: str) -> None:
    with pytest.raises(InvalidValue, match=named):
        fuzzy2.automf(*arguments)  # type: ignore[arg-type]
