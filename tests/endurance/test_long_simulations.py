"""Simulations of many steps neither drift nor diverge.

Some thousand steps here; with ``STEPS=1000000`` in the environment a million, which takes minutes.
"""

from __future__ import annotations

import os
from typing import Any

import numpy as np
import pytest

import psp3
from psp3.trajectories import Circle, Sway

STEPS = int(os.environ.get("STEPS", "20000"))
PERIOD, ROUND = 0.002, 1000
"""Of control [s], and of the motions in its periods."""


def errors_by_round(robot: Any, way: Any, plant: Any = None) -> np.ndarray:
    """Return the largest error of tracking in each round of a motion; all numbers are finite."""
    controller = psp3.ComputedTorque(robot, 900.0, 60.0)
    result = psp3.simulate(robot, controller, way, PERIOD * STEPS, PERIOD, plant=plant)
    assert len(result.t) == STEPS + 1
    for numbers in (result.positions, result.speeds, result.torque):
        assert np.isfinite(numbers).all()
    errors = np.abs(result.positions - result.desired.positions)[1:]
    return np.asarray(errors.reshape(-1, ROUND * errors.shape[1]).max(axis=1))


@pytest.mark.slow
def test_the_last_round_is_tracked_as_the_second() -> None:
    """By then the start is forgotten. 1e-9 is what late times leave of their digits."""
    robot = psp3.load("psp3")
    errors = errors_by_round(robot, Circle(robot=robot))
    np.testing.assert_allclose(errors[2:], errors[2], rtol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["psp3", "five_bar"])
def test_loops_of_springs_open_no_further(name: str) -> None:
    """MuJoCo pulls loops together: it integrates all joints, of which errors could add up."""
    robot: Any = psp3.load(name)
    plant = psp3.MuJoCo(robot)
    way = Circle(robot=robot) if name == "psp3" else Sway(robot=robot)
    errors = errors_by_round(robot, way, plant)
    np.testing.assert_allclose(errors[2:], errors[2], rtol=1e-3)
    assert plant.gap < 1e-4
