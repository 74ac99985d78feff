"""Vertical slices of general type-2 sets: staircases, maxima, and slices between two others."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fuzzy2.errors import InvalidValue, NotApplicable
from fuzzy2.sets.derived import Truncated
from fuzzy2.sets.functional_type2 import FunctionalType2Set
from fuzzy2.sets.general_type2 import SampledType2Set
from fuzzy2.sets.shapes import Trapezoidal, Triangular
from fuzzy2.sets.sigmoids import Sigmoid
from fuzzy2.sets.type1 import SampledSet, Singleton
from fuzzy2.sets.vertical_slices import Staircase


def test_between_two_points_cuts_are_interpolated() -> None:
    """Halfway between triangles lies the triangle of mean corners, exactly; a jump stays a jump."""
    fuzzy_set = SampledType2Set(
        [0.0, 1.0],
        [
            SampledSet([0.0, 0.2, 0.4], [0.0, 1.0, 0.0]),
            SampledSet([0.4, 0.5, 1.0], [0.0, 1.0, 0.0]),
        ],
    )
    halfway, expected = fuzzy_set.secondary(0.5), Triangular(0.2, 0.35, 0.7)
    u = np.linspace(0.0, 1.0, 101)
    np.testing.assert_allclose(halfway(u), expected(u), atol=1e-12)
    assert halfway.is_normal()
    np.testing.assert_allclose(
        fuzzy_set.alpha_plane(0.5).footprint(0.5), expected.alpha_cut(0.5), atol=1e-12
    )
    assert fuzzy_set.secondary(-0.1) == fuzzy_set.secondary(1.1) == Singleton(0.0)
    continuous = SampledType2Set([0.0, 1.0], [Triangular(0.0, 0.2, 0.4), Triangular(0.4, 0.5, 1.0)])
    np.testing.assert_allclose(continuous.secondary(0.5)(u), expected(u), atol=1e-12)


def test_a_secondary_that_never_reaches_its_maximum_has_no_principal_membership() -> None:
    slices = FunctionalType2Set(lambda _: Truncated(Triangular(0.0, 0.5, 1.0), 0.0, 1.0), 0.0, 1.0)
    assert slices.principal(0.5) == 0.5
    with pytest.raises(NotApplicable, match="never reaches"):
        SampledType2Set([0.0], [Unreached()]).principal(0.0)


class Unreached(Sigmoid):
    """A sigmoid that pretends to live in the unit interval."""

    def __init__(self) -> None:
        super().__init__(0.5, 1.0)

    def _support(self) -> tuple[float, float]:
        return 0.0, 1.0


def test_a_staircase_steps_at_the_ends_of_its_intervals() -> None:
    stairs = Staircase((0.25, 1.0), (0.1, 0.4), (0.9, 0.5))
    np.testing.assert_array_equal(
        stairs([0.05, 0.1, 0.39, 0.4, 0.5, 0.51, 0.9, 0.95, np.nan]),
        [0, 0.25, 0.25, 1, 1, 0.25, 0.25, 0, np.nan],
    )
    np.testing.assert_array_equal(
        stairs.alpha_cut([0.1, 0.25, 0.26, 1.0]), [[0.1, 0.1, 0.4, 0.4], [0.9, 0.9, 0.5, 0.5]]
    )
    assert stairs.core == (0.4, 0.5)
    # Area 0.25 (0.9 - 0.1) + 0.75 (0.5 - 0.4), by hand.
    assert stairs.centroid() == pytest.approx((0.2 * 0.5 + 0.075 * 0.45) / 0.275, rel=1e-9)


@settings(max_examples=100, deadline=None)
@given(data=st.data())
def test_interpolated_slices_of_random_trapezoids_agree_with_their_planes(
    data: st.DataObject,
) -> None:
    """Two ways to interpolate: cuts of the built slice, and interpolated cuts.

    1e-9 where an edge is steep.
    """
    slices = []
    for _ in range(2):
        corners = sorted(
            data.draw(st.lists(st.integers(0, 100), min_size=4, max_size=4, unique=True))
        )
        slices.append(
            Trapezoidal(*(corner / 100.0 for corner in corners)).sample(np.array(corners) / 100.0)
        )
    fuzzy_set = SampledType2Set([0.0, 1.0], slices)
    x, alpha = data.draw(st.floats(0.01, 0.99)), data.draw(st.floats(0.05, 1.0))
    np.testing.assert_allclose(
        fuzzy_set.secondary(x).alpha_cut(alpha),
        fuzzy_set.alpha_plane(alpha).footprint(x),
        atol=1e-9,
    )


@pytest.mark.parametrize(
    "make",
    [
        lambda: Staircase((0.5, 1.0), (0.1,), (0.2, 0.2)),
        lambda: Staircase((0.5, 1.0), (0.2, 0.1), (0.5, 0.5)),
        lambda: Staircase((0.5, 1.0), (0.1, 0.3), (0.5, 0.2)),
        lambda: Staircase((1.0, 0.5), (0.1, 0.1), (0.5, 0.5)),
    ],
)
def test_bad_stairs_are_refused(make: Callable[[], object]) -> None:
    with pytest.raises(InvalidValue, match="must be"):
        make()
