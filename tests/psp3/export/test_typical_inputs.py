"""Inputs of tests are states that the robots can be in, and some that they cannot."""

from __future__ import annotations

import numpy as np
import pytest

import psp3
from psp3.errors import PSP3Error
from psp3.export import typical_inputs

ROBOTS = ("psp3", "five_bar", "delta", "gough_stewart")


@pytest.mark.parametrize("name", ROBOTS)
def test_most_states_of_a_robot_have_an_answer(name: str) -> None:
    """Loops close, and forces that such motions take come out no larger than those drawn, by 3."""
    robot = psp3.load(name)
    inputs = typical_inputs.of_robot(robot)
    names = ("positions", "speeds", "accelerations", "forces")
    rows = np.stack([inputs[key] for key in names])
    rows = rows[:, np.isfinite(rows).all(axis=(0, 2))]
    answered, largest = 0, 0.0
    for positions, speeds, accelerations, _ in rows.swapaxes(0, 1):
        try:
            forces = robot.inverse_dynamics(positions, speeds, accelerations)
        except PSP3Error:
            continue
        answered += 1
        largest = max(largest, float(np.median(np.abs(forces))))
    assert answered >= 0.8 * rows.shape[1]
    assert rows.shape[1] >= 180
    assert largest <= 30.0 * np.abs(rows[3]).max()


@pytest.mark.parametrize("name", ROBOTS)
def test_states_of_a_controller_are_near_the_motion_that_is_wanted(name: str) -> None:
    robot = psp3.load(name)
    inputs = typical_inputs.of_controller(robot)
    n = len(robot.reference)
    errors = inputs["positions"] - inputs["desired"][:, :n]
    reach = np.ptp(inputs["desired"][:, :n], axis=0).max()
    finite = errors[np.isfinite(errors)]
    assert 0.0 < np.abs(finite).max() <= 0.1 * reach
    assert np.isnan(errors).any()
    assert np.isfinite(inputs["desired"]).all()
    np.testing.assert_allclose(np.diff(inputs["t"][:, 0]), typical_inputs.PERIOD, rtol=1e-9)
    # Speeds are the slopes of positions, to the error of differences over 0.1 s.
    wanted = inputs["desired"][:, :n]
    slopes = (wanted[2:] - wanted[:-2]) / (2.0 * typical_inputs.PERIOD)
    speeds = inputs["desired"][1:-1, n : 2 * n]
    assert np.abs(slopes - speeds).max() <= 0.1 * np.abs(speeds).max()


def test_coordinates_that_follow_stay_where_they_are() -> None:
    """The orientation of a floating base is a quaternion of length 1."""
    robot = psp3.load("biped")
    positions = typical_inputs.of_robot(robot)["positions"]
    positions = positions[np.isfinite(positions).all(axis=1)]
    moved = np.flatnonzero(np.abs(positions - robot.reference).max(axis=0) > 1e-12)
    assert moved.size <= robot.commanded
