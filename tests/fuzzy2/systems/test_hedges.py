"""Hedges by their definitions."""

from __future__ import annotations

import numpy as np
import pytest

import fuzzy2
from fuzzy2.errors import InvalidRule, InvalidValue
from fuzzy2.systems import Type1System
from fuzzy2.systems.hedges import HEDGES, Hedge, known_hedges


def test_known_hedges_are_zadehs_powers() -> None:
    for name, power in {"very": 2, "extremely": 3, "more or less": 0.5, "slightly": 1 / 3}.items():
        np.testing.assert_allclose(HEDGES[name](np.array([0.25])), 0.25**power)


def test_a_hedge_of_ones_own_in_a_rule() -> None:
    terms = {"x": {"low": fuzzy2.Triangular(-1.0, 0.0, 1.0)}}
    system = Type1System(
        terms,
        "IF x is indeed low THEN y is a\nIF x is not low THEN y is b",
        {"y": {"a": 0.0, "b": 1.0}},
        hedges={"indeed": lambda grades: np.minimum(2.0 * grades, 1.0)},
    )
    np.testing.assert_allclose(system.firing([0.75])[:, 0], [0.5, 0.75])
    np.testing.assert_allclose(system([0.75]), [0.6])
    with pytest.raises(InvalidRule, match="which is not a hedge"):
        Type1System(terms, "IF x is indeed low THEN y is a", {"y": {"a": 0.0}})


@pytest.mark.parametrize(
    ("hedges", "said"),
    [
        ({"not": lambda g: g}, "keywords"),
        ({"odd": lambda g: abs(2.0 * g - 1.0)}, "rising all the way"),
        ({"big": lambda g: 2.0 * g}, "grades in"),
        ({"number": 2.0}, "a Hedge"),
    ],
)
def test_what_is_no_hedge(hedges: dict[str, object], said: str) -> None:
    with pytest.raises(InvalidValue, match=said):
        known_hedges(hedges)  # type: ignore[arg-type]
    with pytest.raises(InvalidValue, match="one of both"):
        Hedge("very")
