"""The shipped robots in MuJoCo.

Mass matrix, bias and gravity projected on the closures' null space, engine against engine.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pinocchio as pin
import pytest

import psp3
from psp3.description.parts import THESIS_ROBOTS
from tests.helpers import Array, relative_error
from tests.mujoco_projection import Projection, State, engine
from tests.robot_samplers import random_poses

STATES = 60

TOLERANCE = 1e-10
"""Of each matrix, relative to its largest entry. M and G reach 3e-14, C v 1e-11."""


def both(name: str, gravity: Array) -> tuple[tuple[Array, Array, Array], Array, list[State]]:
    """M, C and G of random states from the robot, the speeds, and the same states from MuJoCo."""
    robot: Any = psp3.load(name)
    robot.model.gravity = pin.Motion(gravity, np.zeros(3))
    model = engine(name)
    model.opt.gravity[:] = gravity
    rng = np.random.default_rng(0)
    positions = random_poses(name, STATES, rng)
    speeds = rng.normal(size=positions.shape)
    projection, names = Projection(name, model), list(robot.model.names)[1:]
    indices = [joint.idx_q for joint in list(robot.model.joints)[1:]]
    theirs = [
        projection.at(dict(zip(names, q[indices], strict=True)), v)
        for q, v in zip(robot.configuration(positions), speeds, strict=True)
    ]
    return robot.equation_of_motion(positions, speeds), speeds, theirs


@pytest.mark.parametrize("name", THESIS_ROBOTS)
def test_projected_dynamics_agree(name: str) -> None:
    """M, C v and G of 60 random states.

    MuJoCo agrees that the loops are closed there, to 1e-10 m.
    """
    (mass, coriolis, gravity), speeds, theirs = both(name, np.array([0.0, 0.0, -9.81]))
    assert max(state.gap for state in theirs) < 1e-10
    assert relative_error(mass, np.array([state.mass for state in theirs])) < TOLERANCE
    assert (
        relative_error(
            np.einsum("nij,nj->ni", coriolis, speeds),
            np.array([state.coriolis for state in theirs]),
        )
        < TOLERANCE
    )
    if name == "planar_3rrr":
        # It moves level: 1e-12 N m of a weight of 11 N.
        assert np.abs(gravity).max() < 1e-12
        assert max(np.abs(state.gravity).max() for state in theirs) < 1e-12
    else:
        assert relative_error(gravity, np.array([state.gravity for state in theirs])) < TOLERANCE


def test_planar_robot_agrees_on_a_slope() -> None:
    """Gravity along no axis of the robot."""
    (_, _, gravity), _, theirs = both("planar_3rrr", np.array([2.0, -5.0, -8.0]))
    assert relative_error(gravity, np.array([state.gravity for state in theirs])) < TOLERANCE
