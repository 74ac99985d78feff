"""Type-1 systems that a type-2 system contains."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fuzzy2.systems import IntervalType2System
from fuzzy2.systems.embedded import embedded_averages
from tests.fuzzy2.systems.by_hand import (
    GRID_RULES,
    uncertain,
)

Array = NDArray[np.float64]


def test_embedded_type_1_systems_fill_the_interval(consequents: Array, X: Array) -> None:
    """Fig. 7: all within the type-reduced interval.

    Its ends are among them for the first output; 1e-12.
    """
    system = IntervalType2System(uncertain(), GRID_RULES, consequents)
    outputs = np.array(list(system.embedded_outputs(X[0], 500, np.random.default_rng(3))))
    interval = system.type_reduced(X[0])
    assert (outputs >= interval[:, 0] - 1e-12).all()
    assert (outputs <= interval[:, 1] + 1e-12).all()
    np.testing.assert_allclose([outputs[:, 0].min(), outputs[:, 0].max()], interval[0], atol=1e-12)


def test_a_single_rule_that_may_not_fire_has_both_ends_of_its_consequent() -> None:
    """With no weight at all there is no average; with any weight it is an end."""
    found = list(
        embedded_averages(
            np.array([[0.0, 0.5]]), np.array([[[1.0, 3.0]]]), 0, np.random.default_rng(0)
        )
    )
    np.testing.assert_array_equal(found, [[1.0], [3.0]])
