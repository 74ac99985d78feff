"""Models that controllers take: the four of the 3-PSP, those of other robots, and users' own."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import psp3
from psp3.description.parts import THESIS_ROBOTS
from psp3.dynamics.dynamics_model import (
    DynamicsModel,
    ForcesOfMotions,
    equation_of_motion_of,
)
from psp3.errors import ClosureFailed, InvalidArray, InvalidValue
from psp3.robots import dynamics_model as first_path
from psp3.three_psp.robot import DYNAMICS_MODELS
from tests.helpers import random_states

STAR = psp3.load("psp3")


@pytest.mark.parametrize("name", DYNAMICS_MODELS)
def test_forces_of_the_four_paths_agree(name: str) -> None:
    """With the closed form's M, C and G multiplied out; 1e-10 N of some 100 N is rounding."""
    rng = np.random.default_rng(3)
    heights, speeds = random_states(rng, 20)
    accelerations = rng.normal(size=(20, 3))
    M, C, G = STAR.equation_of_motion(heights, speeds)
    expected = np.einsum("...ij,...j->...i", M, accelerations) + G
    expected += np.einsum("...ij,...j->...i", C, speeds)
    model = STAR.dynamics(name)
    assert isinstance(model, DynamicsModel)
    found = model.actuator_forces(heights, speeds, accelerations)
    assert_allclose(found, expected, rtol=0.0, atol=1e-10)
    one = model.actuator_forces(heights[0], speeds[0], accelerations[0])
    assert one.shape == (3,)
    assert_allclose(one, found[0], rtol=0.0, atol=1e-12)


@pytest.mark.parametrize("name", [name for name in THESIS_ROBOTS if name != "psp3"])
def test_forces_of_other_robots_agree(name: str) -> None:
    """By RNEA in two ways, and by the thesis's matrices; 1e-10 of the largest force is rounding."""
    robot = psp3.load(name)
    rng, n = np.random.default_rng(4), len(robot.actuated)
    positions = robot.reference + rng.uniform(-0.02, 0.02, (5, n))
    speeds, accelerations = rng.normal(size=(2, 5, n))
    found = robot.actuator_forces(positions, speeds, accelerations)
    for other in ("pinocchio", "noc"):
        model = robot.dynamics(other)
        assert isinstance(model, DynamicsModel)
        expected = model.actuator_forces(positions, speeds, accelerations)
        assert_allclose(found, expected, rtol=0.0, atol=1e-10 * np.abs(expected).max())
    assert_array_equal(found, robot.inverse_dynamics(positions, speeds, accelerations))


@pytest.mark.parametrize("name", DYNAMICS_MODELS)
def test_malformed_motions_are_refused(name: str) -> None:
    with pytest.raises(InvalidArray):
        STAR.dynamics(name).actuator_forces(np.zeros(2), np.zeros(3), np.zeros(3))
    with pytest.raises(InvalidArray, match="accelerations"):
        STAR.dynamics(name).actuator_forces(np.zeros(3), np.zeros(3), np.full(3, np.nan))


class OfThreeMethods:
    """A user's model, as from a library that has no common call."""

    def mass_matrix(self, positions: Any) -> np.ndarray:
        """Return M."""
        return np.eye(2)

    def coriolis_matrix(self, positions: Any, speeds: Any) -> np.ndarray:
        """Return C."""
        return 2.0 * np.eye(2)

    def gravity(self, positions: Any) -> np.ndarray:
        """Return G."""
        return np.full(2, 3.0)


def test_a_model_of_three_methods_will_do() -> None:
    M, C, G = equation_of_motion_of(OfThreeMethods())(np.zeros(2), np.zeros(2))  # type: ignore[arg-type]
    assert (M[0, 0], C[0, 0], G[0]) == (1.0, 2.0, 3.0)


def test_the_path_by_which_the_names_were_public_first_still_leads_to_them() -> None:
    assert first_path.DynamicsModel is DynamicsModel
    assert first_path.equation_of_motion_of is equation_of_motion_of


def test_what_is_no_model_is_refused() -> None:
    with pytest.raises(InvalidValue, match="a model with equation_of_motion"):
        equation_of_motion_of(object())  # type: ignore[arg-type]


# One state after the other


def test_forces_of_motions_of_a_users_model_are_m_a_plus_c_v_plus_g() -> None:
    forces = ForcesOfMotions(OfThreeMethods())  # type: ignore[arg-type]
    speeds, accelerations = np.array([1.0, -2.0]), np.array([0.5, 4.0])
    assert_allclose(forces(np.zeros(2), speeds, accelerations), [5.5, 3.0], rtol=1e-15)


def test_forces_of_motions_from_the_last_pose_are_those_from_the_reference() -> None:
    """Four threads share one caller, each on a walk of its own; loops are closed to rounding."""
    robot = psp3.load("five_bar")
    forces = ForcesOfMotions(robot)

    def walk(thread: int) -> float:
        rng, worst = np.random.default_rng(thread), 0.0
        a = robot.reference.copy()
        for _ in range(200):
            a += rng.uniform(-0.01, 0.01, 2)
            v, w = rng.normal(size=(2, 2))
            expected = robot.inverse_dynamics(a, v, w)
            worst = max(worst, float(np.abs(forces(a, v, w) / expected - 1.0).max()))
        return worst

    with ThreadPoolExecutor(4) as pool:
        assert max(pool.map(walk, range(4))) < 1e-9


def test_a_refused_state_does_not_spoil_the_next() -> None:
    robot = psp3.load("five_bar")
    forces, rest = ForcesOfMotions(robot), np.zeros(2)
    before = forces(robot.reference, rest, rest)
    with pytest.raises(ClosureFailed):
        forces(robot.reference + np.array([3.0, -3.0]), rest, rest)
    assert_allclose(forces(robot.reference, rest, rest), before, rtol=1e-12)


@pytest.mark.parametrize("name", ["pinocchio", "noc"])
def test_forces_of_more_motors_than_coordinates_agree(name: str) -> None:
    """Of least norm in every path, also where accelerations of the first coordinates are asked."""
    robot, rng = psp3.load("planar_4rrr"), np.random.default_rng(5)
    positions = robot.reference[:3] + rng.uniform(-0.02, 0.02, (4, 3))
    speeds, accelerations = rng.normal(size=(2, 4, 3))
    for wanted in (accelerations, accelerations[:, :2]):
        expected = robot.actuator_forces(positions, speeds, wanted)
        found = robot.dynamics(name).actuator_forces(positions, speeds, wanted)
        assert found.shape == (4, 4)
        assert_allclose(found, expected, rtol=0.0, atol=1e-10 * np.abs(expected).max())
