"""General type-2 sets whose secondary memberships a function gives."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from fuzzy2.errors import InvalidValue
from fuzzy2.sets.derived import Truncated
from fuzzy2.sets.functional_type2 import FunctionalType2Set
from fuzzy2.sets.shapes import Gaussian
from fuzzy2.sets.type1 import Singleton
from tests.fuzzy2.sets.general_type2_sets import triangle_at


def test_what_a_secondary_function_gives_outside_of_the_unit_interval_is_cut_off() -> None:
    fuzzy_set = FunctionalType2Set(lambda x: Gaussian(0.1 * x, 0.2), 0.0, 5.0)
    assert fuzzy_set.secondary(1.0) == Truncated(Gaussian(0.1, 0.2), 0.0, 1.0)
    np.testing.assert_allclose(fuzzy_set.alpha_plane(0.5).lower(1.0), 0.0)
    assert fuzzy_set.secondary(5.1) == Singleton(0.0)


@pytest.mark.parametrize(
    "make",
    [
        lambda: FunctionalType2Set(triangle_at, 1.0, 0.0),
        lambda: FunctionalType2Set(triangle_at, -math.inf, math.inf),
    ],
)
def test_domains_that_are_none_are_refused(make: Callable[[], object]) -> None:
    with pytest.raises(InvalidValue, match="must be"):
        make()
