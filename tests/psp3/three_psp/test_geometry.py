"""Geometry off the hot path: heights of a tilt, arm lengths, reach of the tip."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from unittest.mock import Mock

import numpy as np
import pytest
import scipy.optimize
from hypothesis import given
from hypothesis import strategies as st

from psp3.errors import InvalidArray, InvalidValue, UnreachablePose
from psp3.three_psp import geometry
from psp3.three_psp.geometry import SCREW_AZIMUTHS, arm_lengths, heights_of_tilt, tip_reach
from tests.helpers import Array, random_heights

D, H = 0.181, 0.070


def nut_points(heights: Array, radius: float = D) -> Array:
    x, y = radius * np.cos(SCREW_AZIMUTHS), radius * np.sin(SCREW_AZIMUTHS)
    return np.stack(np.broadcast_arrays(x, y, heights), axis=-1)


def fermat_points(nuts: Array) -> Array:
    """Fermat points of triangles (n, 3, 3) by damped fixed-point iteration.

    To be refined by nothing but the definition.
    """
    center = nuts.mean(axis=1)
    for _ in range(400):
        weights = 1.0 / np.linalg.norm(nuts - center[:, np.newaxis], axis=-1, keepdims=True)
        center = (weights * nuts).sum(axis=1) / weights.sum(axis=1)
    return center


def test_arm_lengths_are_the_distances_to_the_fermat_point() -> None:
    """Weiszfeld's iteration for the least sum of distances, which knows no angles.

    It converges linearly, to about 1e-14 m here.
    """
    nuts = nut_points(heights := random_heights(np.random.default_rng(1), 200))
    expected = np.linalg.norm(nuts - fermat_points(nuts)[:, np.newaxis], axis=-1)
    np.testing.assert_allclose(arm_lengths(heights, D), expected, rtol=0, atol=1e-12)


def test_arm_length_is_negative_where_the_fermat_point_leaves_the_triangle() -> None:
    """A triangle with an angle above 120 degrees: nut 1 lies between the others, far apart."""
    arms = arm_lengths([0.0, -0.5, 0.5], D)
    assert arms[0] < 0.0 < arms[1]
    np.testing.assert_allclose(arms[1], arms[2], rtol=1e-14)


@given(
    tilt=st.floats(0.0, np.radians(70.5)),
    azimuth=st.floats(-10.0, 10.0),
    height=st.floats(-1.0, 1.0),
    radius=st.floats(0.05, 2.0),
)
def test_heights_of_tilt_give_that_plane_and_that_fermat_point(
    tilt: float, azimuth: float, height: float, radius: float
) -> None:
    """Round trip through the cross product of two edges and the sides of the nut triangle.

    1e-12 relative: tan(70.5 degrees) and the distance of heights that may be 10 times the radius
    cost a digit each.
    """
    heights = heights_of_tilt(height, tilt, azimuth, radius)
    nuts = nut_points(heights, radius)
    normal = np.cross(nuts[1] - nuts[0], nuts[2] - nuts[0])
    normal /= np.linalg.norm(normal)
    expected = [np.sin(tilt) * np.cos(azimuth), np.sin(tilt) * np.sin(azimuth), np.cos(tilt)]
    np.testing.assert_allclose(normal, expected, rtol=0, atol=1e-12)
    # The center, measured along arm 1 from its nut, is at the height that was asked for.
    arms = arm_lengths(heights, radius)
    arms_by_tilt = (
        radius
        * (1 + np.cos(tilt))
        / (2 * np.cos(tilt))
        * (1 + 2 * np.tan(tilt / 2) ** 2 * np.cos(2 * azimuth + SCREW_AZIMUTHS))
    )
    np.testing.assert_allclose(arms, arms_by_tilt, rtol=0, atol=1e-11 * radius)


def test_level_star_has_equal_heights_and_arms_of_the_screw_radius() -> None:
    np.testing.assert_array_equal(heights_of_tilt(0.25, 0.0, 1.0, D), np.full(3, 0.25))
    np.testing.assert_allclose(arm_lengths(np.full(3, 0.25), D), D, rtol=1e-15)


def test_heights_of_tilt_broadcasts() -> None:
    assert heights_of_tilt(0.0, 0.1, 0.2, D).shape == (3,)
    assert heights_of_tilt(0.0, np.zeros((4, 1)), np.zeros(5), D).shape == (4, 5, 3)
    assert heights_of_tilt(np.zeros(0), 0.1, 0.2, D).shape == (0, 3)


def test_every_azimuth_is_safe_below_the_tilt_of_70_53_degrees_and_not_above() -> None:
    """b_k > 0 needs 2 tan²(tilt/2) < 1 at the worst azimuth: cos(tilt) > 1/3."""
    limit = np.arccos(1.0 / 3.0)
    azimuths = np.linspace(0.0, 2.0 * np.pi, 361)
    assert np.isfinite(heights_of_tilt(0.0, limit - 1e-6, azimuths, D)).all()
    # At 2 phi + alpha_1 = pi arm 1 shrinks to nothing.
    with pytest.raises(UnreachablePose, match=r"70\.53") as caught:
        heights_of_tilt(0.0, limit + 1e-6, 0.5 * np.pi, D)
    assert caught.value.arms[0] < 0.0
    # Toward a screw no arm is short.
    assert (arm_lengths(heights_of_tilt(0.0, np.radians(85), 0.0, D), D) > 0.0).all()


def test_unreachable_tilt_in_a_batch_names_its_own_heights_and_arms() -> None:
    tilts = np.array([[0.1, 0.2], [np.radians(75), 0.3]])
    with pytest.raises(UnreachablePose) as caught:
        heights_of_tilt(0.0, tilts, 0.5 * np.pi, D)
    theta = np.radians(75)
    assert caught.value.heights.shape == (3,)
    expected = D * (1 + np.cos(theta)) / (2 * np.cos(theta)) * (1 - 2 * np.tan(theta / 2) ** 2)
    np.testing.assert_allclose(caught.value.arms[0], expected, rtol=1e-12)


@pytest.mark.parametrize("tilt", [0.5 * np.pi, -0.5 * np.pi, 2.0, 100.0])
def test_tilt_of_90_degrees_or_more_is_refused(tilt: float) -> None:
    with pytest.raises(InvalidValue, match=r"tilt.*90 degrees") as caught:
        heights_of_tilt(0.0, [0.1, tilt], 0.0, D)
    assert caught.value.name == "tilt"
    assert caught.value.value == abs(tilt)


@pytest.mark.parametrize("name", ["height", "tilt", "azimuth"])
@pytest.mark.parametrize("value", [np.nan, np.inf, [0.0, np.nan], None, "steep"])
def test_arguments_that_are_not_finite_numbers_are_refused_by_name(
    name: str, value: object
) -> None:
    arguments: dict[str, object] = {"height": 0.0, "tilt": 0.1, "azimuth": 0.2, name: value}
    with pytest.raises(InvalidArray, match=name) as caught:
        heights_of_tilt(**arguments, screw_radius=D)  # type: ignore[arg-type]
    assert caught.value.name == name


def test_arguments_of_shapes_that_do_not_go_together_are_refused() -> None:
    with pytest.raises(InvalidArray):
        heights_of_tilt(np.zeros(2), np.zeros(5), 0.0, D)


@pytest.mark.parametrize(
    "heights",
    [1.0, np.zeros(4), np.zeros((3, 1)), [0.0, 0.0, np.nan], "abc", None, [[1, 2, 3], [1, 2]]],
)
def test_arm_lengths_refuses_what_is_not_heights(heights: object) -> None:
    with pytest.raises(InvalidArray, match="heights"):
        arm_lengths(heights, D)  # type: ignore[arg-type]


def test_reach_at_the_azimuth_of_a_screw_is_exact() -> None:
    """sqrt(h² + d²/4) − d/2, 23.9 mm.

    1e-13 m because the root finder stops at 1e-14 of the slope.
    """
    exact = np.sqrt(H**2 + D**2 / 4) - D / 2
    assert round(1e3 * exact, 1) == 23.9
    np.testing.assert_allclose(tip_reach(SCREW_AZIMUTHS, D, H), exact, rtol=0, atol=1e-13)


@given(d=st.floats(0.05, 1.0), ratio=st.floats(0.05, 0.86))
def test_reach_at_azimuth_0_is_exact_for_every_robot(d: float, ratio: float) -> None:
    """The fold lies at the tilt arctan(2 h / d).

    Within the 60 degrees that are searched up to h = 0.866 d; 1e-11 is the root finder's.
    """
    h = ratio * d
    np.testing.assert_allclose(tip_reach(0.0, d, h), np.sqrt(h**2 + d**2 / 4) - d / 2, rtol=1e-11)


def test_reach_is_the_least_at_the_screws_symmetric_and_periodic() -> None:
    """The symmetries of the machine; the root finder leaves 1e-12 m."""
    azimuths = np.linspace(0.0, 2.0 * np.pi / 3.0, 25)
    reach = tip_reach(azimuths, D, H)
    assert reach.shape == (25,)
    assert (reach[1:-1] > reach[0]).all()
    np.testing.assert_allclose(reach, reach[::-1], rtol=0, atol=1e-12)
    np.testing.assert_allclose(
        tip_reach(azimuths - 2.0 * np.pi / 3.0, D, H), reach, rtol=0, atol=1e-12
    )
    np.testing.assert_allclose(tip_reach(-azimuths, D, H), reach, rtol=0, atol=1e-12)
    # It grows up to the cusp opposite to a screw.
    assert (np.diff(reach[:13]) > 0.0).all()


@given(d=st.floats(1e-3, 100.0), ratio=st.floats(1e-4, 10.0), azimuth=st.floats(-7.0, 7.0))
def test_reach_is_what_brent_finds(d: float, ratio: float, azimuth: float) -> None:
    """With the root finder of SciPy instead of ours; both stop at 1e-14 of the slope."""
    found = tip_reach(azimuth, d, ratio * d)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(
            geometry, "_root", functools.partial(scipy.optimize.brentq, xtol=1e-15, rtol=1e-14)
        )
        np.testing.assert_allclose(found, tip_reach(azimuth, d, ratio * d), rtol=1e-11)


@pytest.mark.parametrize(
    ("function", "root", "most"),
    [
        (lambda x: math.cos(x) - 0.3, math.acos(0.3), 10),
        (lambda x: (x - 0.7) ** 9, 0.7, 110),
        (lambda x: math.copysign(1.0, x - 0.3), 0.3, 110),
        (lambda x: math.exp(50.0 * x) - 1e30, math.log(1e30) / 50.0, 20),
        (lambda x: math.nan, None, 110),
    ],
    ids=["smooth", "flat", "step", "steep", "no number"],
)
def test_a_root_is_found_in_a_bounded_number_of_steps(
    function: Callable[[float], float], root: float | None, most: int
) -> None:
    """Smooth functions take a few steps; hard ones at most twice as many as halving does."""
    counted = Mock(side_effect=function)
    found = geometry._root(counted, 0.0, math.sqrt(3.0))
    assert counted.call_count <= most
    assert root is None or abs(found - root) <= 1e-13


def test_reach_keeps_the_shape_of_its_argument() -> None:
    assert np.shape(tip_reach(0.3, D, H)) == ()
    assert tip_reach(np.zeros((2, 3)), D, H).shape == (2, 3)
    assert tip_reach(np.zeros(0), D, H).shape == (0,)


@pytest.mark.parametrize("azimuth", [np.nan, np.inf, None, "north"])
def test_reach_at_no_azimuth_is_refused(azimuth: object) -> None:
    with pytest.raises(InvalidArray, match="azimuth"):
        tip_reach(azimuth, D, H)  # type: ignore[arg-type]
