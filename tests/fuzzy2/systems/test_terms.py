"""Where terms live."""

from __future__ import annotations

import math

import pytest

from fuzzy2 import Gaussian, NamedShape, PiShaped, Trapezoidal, Triangular, Type1System
from fuzzy2.systems.terms import domain_of

INF = math.inf


@pytest.mark.parametrize(
    ("term", "ends"),
    [
        (Triangular(1.0, 2.0, 4.0), (1.0, 4.0)),
        (Trapezoidal(0.0, 1.0, INF, INF), (0.0, 1.0)),
        (Trapezoidal(-INF, -INF, 2.0, 5.0), (2.0, 5.0)),
        (PiShaped(0.0, 3.0, INF, INF), (0.0, 3.0)),
        (NamedShape("arc", (0.0, 2.0)), (0.0, 2.0)),
        (Gaussian(1.0, 0.5), (-1.0, 3.0)),
    ],
)
def test_a_finite_end_is_that_of_the_support(term: object, ends: tuple[float, float]) -> None:
    """A shoulder was left out before, for its foot has the grade 0."""
    assert domain_of([term]) == ends


def test_two_shoulders_live_between_their_feet() -> None:
    low, high = Trapezoidal(-INF, -INF, 0.0, 3.0), Trapezoidal(1.0, 4.0, INF, INF)
    assert domain_of([low, high]) == (0.0, 4.0)
    # Of both together the centroid is that of what stands between 0 and 4, which is symmetric.
    system = Type1System(
        [[Triangular(-1.0, 0.0, 1.0)]], [[0], [0]], [[low], [high]], type_reduction="centroid"
    )
    assert system([0.0])[0] == pytest.approx(2.0, abs=1e-9)
