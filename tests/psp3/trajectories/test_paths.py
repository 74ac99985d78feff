"""Helices, lines and motions from point to point against their equations."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from psp3 import trajectories
from psp3.errors import (
    UnreachableTip,
)
from tests.psp3.trajectories.points import HOME, NEAR


def test_helix_follows_its_equation() -> None:
    """The tip written with complex numbers, independently of the class."""
    helix = trajectories.Helix(radius=0.015, period=1.5, rise=0.02, height=0.09)
    t = np.linspace(0.0, 4.0, 41)
    tip = helix(t).tip
    np.testing.assert_allclose(
        tip[:, 0] + 1j * tip[:, 1], 0.015 * np.exp(2j * np.pi * t / 1.5), atol=1e-16
    )
    np.testing.assert_allclose(tip[:, 2], 0.09 + 0.02 * t, atol=1e-16)


def test_default_helix_is_the_one_of_the_comparison() -> None:
    helix = trajectories.Helix()
    assert (helix.radius, helix.period, helix.rise, helix.height) == (0.020, 2.0, 0.010, 0.070)


@given(share=st.floats(0.0, 1.0))
@settings(max_examples=30, deadline=None)
def test_quintic_is_symmetric_and_stays_on_the_line(share: float) -> None:
    """s(x) + s(1 − x) = 1 for the quintic; 1e-15 is rounding of numbers of size 0.1."""
    trajectory = trajectories.PointToPoint(HOME, NEAR, 2.0)
    forth, back = trajectory(2.0 * share).tip, trajectory(2.0 * (1.0 - share)).tip
    np.testing.assert_allclose(forth + back, HOME + NEAR, atol=1e-15)
    assert np.linalg.norm(np.cross(forth - HOME, NEAR - HOME)) < 1e-17


@pytest.mark.parametrize("kind", [trajectories.PointToPoint, trajectories.Waypoints])
def test_smooth_motions_start_and_end_at_rest(kind: type) -> None:
    trajectory = (
        kind(HOME, NEAR, 2.0)
        if kind is trajectories.PointToPoint
        else kind([0.0, 1.0, 2.0], [HOME, 0.7 * NEAR, NEAR])
    )
    motion = trajectory([0.0, 2.0, 5.0])
    np.testing.assert_allclose(motion.speeds, 0.0, atol=1e-15)
    np.testing.assert_allclose(motion.tip[1:], [NEAR, NEAR], atol=1e-16)


def test_a_motion_of_the_joints_is_straight_in_them() -> None:
    """The quintic written out: halfway at half the time.

    There at 15/8 of the mean speed, without acceleration.
    """
    start, end = np.array([0.0, 0.02, -0.01]), np.array([0.05, 0.0, 0.03])
    middle = trajectories.PointToPoint(start, end, 2.0, space="joints")(1.0)
    np.testing.assert_allclose(middle.positions, 0.5 * (start + end), atol=1e-16)
    np.testing.assert_allclose(middle.speeds, 15.0 / 8.0 * (end - start) / 2.0, rtol=1e-14)
    np.testing.assert_allclose(middle.accelerations, 0.0, atol=1e-15)


def test_radius_beyond_the_fold_names_the_reach() -> None:
    with pytest.raises(UnreachableTip, match=r"23\.9 mm") as caught:
        trajectories.Helix(radius=0.030)(np.linspace(0.0, 2.0, 100))
    assert caught.value.reach == pytest.approx(np.hypot(0.07, 0.0905) - 0.0905, abs=1e-12)
    np.testing.assert_allclose(caught.value.tip[:2], [0.030, 0.0], atol=1e-15)
