"""Desired motions by name: that they are smooth, and go where they are said to go."""

from __future__ import annotations

import numpy as np
import pytest

import psp3
from psp3.study.paths import (
    DRAWN,
    EVENT,
    FAST_SWAY,
    TRAJECTORIES_OF_OTHERS,
    DepartingHelix,
    names_of_paths,
    path_named,
)
from psp3.trajectories import Sway
from tests.helpers import derivative


def test_the_path_is_smooth_and_goes_where_it_is_said_to_go() -> None:
    """Speeds and accelerations by differences of eighth order.

    1e-9 of numbers of order 1, with steps that resolve a second.
    """
    path = DepartingHelix(0.01, 2.5, 0.4, 0.022, 2.0, psp3.load("psp3"))
    for t in (1.0, EVENT + 0.1, EVENT + 0.5, EVENT + 0.93, EVENT + 3.0):
        point, velocity, acceleration = path._path(np.array(t))
        np.testing.assert_allclose(
            velocity, derivative(lambda s, t=t: path._path(np.array(t + s))[0], 2e-3), atol=1e-9
        )
        np.testing.assert_allclose(
            acceleration, derivative(lambda s, t=t: path._path(np.array(t + s))[1], 2e-3), atol=1e-8
        )
        if t <= EVENT:
            assert np.hypot(*point[:2]) == pytest.approx(0.01)
            assert np.hypot(*velocity[:2]) == pytest.approx(0.01 * 2.0 * np.pi / 2.5)
        if t > EVENT + 1.0:
            assert np.hypot(*point[:2]) == pytest.approx(0.022)
            assert np.hypot(*velocity[:2]) == pytest.approx(0.022 * 4.0 * np.pi / 2.5)
    before, after = (path._path(np.array(EVENT + end * 1e-9)) for end in (-1.0, 1.0))
    for one, other in zip(before, after, strict=True):
        np.testing.assert_allclose(one, other, atol=1e-7)


@pytest.mark.parametrize("robot", ["psp3", "five_bar", "delta"])
def test_every_name_is_a_motion_that_the_robot_can_make(robot: str) -> None:
    """Its speeds are the derivatives of its positions, by differences of eighth order."""
    which = psp3.load(robot)
    for name in names_of_paths(robot):
        path = path_named(name, robot, which, np.random.default_rng(2))
        for t in (0.3, 1.1):
            motion = path.check(np.array([t]))
            np.testing.assert_allclose(
                motion.speeds[0],
                derivative(lambda s, t=t, path=path: path(t + s).positions, 2e-3),
                atol=1e-8,
            )


def test_drawn_paths_are_those_of_the_generator() -> None:
    robot = psp3.load("psp3")
    for name in DRAWN:
        one, same, other = (
            path_named(name, "psp3", robot, np.random.default_rng(seed)) for seed in (1, 1, 2)
        )
        np.testing.assert_array_equal(one(1.0).tip, same(1.0).tip)
        assert np.abs(one(1.0).tip - other(1.0).tip).max() > 1e-4


def test_small_and_fast_sway_are_what_they_are_called() -> None:
    robot = psp3.load("delta")
    sway, small, fast = (
        TRAJECTORIES_OF_OTHERS[name](robot) for name in ("sway", "small-sway", "fast-sway")
    )
    t = np.linspace(0.0, 2.0, 50)
    home = robot.reference
    np.testing.assert_allclose(
        small(t).positions - home, 0.5 * (sway(t).positions - home), rtol=0.0, atol=1e-15
    )
    assert isinstance(sway, Sway)
    np.testing.assert_allclose(
        fast(t * FAST_SWAY / sway.period).positions, sway(t).positions, atol=1e-14
    )
