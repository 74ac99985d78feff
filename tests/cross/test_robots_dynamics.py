"""Dynamics of the shipped robots against what must hold for any: energy, power, symmetry.

And one implementation against another.
"""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

import psp3
from psp3.description.parts import THESIS_ROBOTS
from psp3.dynamics.natural_orthogonal_complement import NaturalOrthogonalComplement
from psp3.robots.closed_loop_robot import ClosedLoopRobot
from psp3.simulation.constraint_dynamics import ConstraintDynamics
from psp3.simulation.dormand_prince import DormandPrince
from psp3.simulation.runge_kutta import RungeKutta
from tests.helpers import Array, derivative, relative_error
from tests.robot_samplers import random_poses

NAMES = THESIS_ROBOTS[1:]
STEP = 3e-4
"""Of eighth-order differences [m, rad]: truncation and rounding are both below 1e-8 near the
singularities, where both are worst.
"""


@pytest.fixture(scope="module", params=NAMES)
def robot(request: pytest.FixtureRequest) -> ClosedLoopRobot:
    return psp3.load(str(request.param))


def states(robot: ClosedLoopRobot, count: int) -> tuple[Array, Array]:
    """Random reachable positions and speeds of the order of 1 m/s and 1 rad/s."""
    rng = np.random.default_rng(0)
    positions = random_poses(robot.model.name, count, rng)
    return positions, rng.normal(size=positions.shape)


def test_mass_matrix_is_symmetric_and_positive_definite(robot: ClosedLoopRobot) -> None:
    """1e-13 is rounding. An eigenvalue below 1e-4 of the largest would be a body without mass."""
    mass = robot.mass_matrix(states(robot, 100)[0])
    assert relative_error(mass.swapaxes(1, 2), mass) < 1e-13
    values = np.linalg.eigvalsh(mass)
    assert (values[:, 0] > 1e-4 * values[:, -1]).all()


def test_kinetic_energy_is_half_the_square_of_the_speeds_in_the_mass_matrix(
    robot: ClosedLoopRobot,
) -> None:
    """Pinocchio's sum over the bodies of the tree; 1e-12 is rounding."""
    positions, speeds = states(robot, 20)
    half = 0.5 * np.einsum("ni,nij,nj->n", speeds, robot.mass_matrix(positions), speeds)
    assert_allclose(half, robot.kinetic_energy(positions, speeds), rtol=1e-12)


def test_gravity_is_the_slope_of_the_potential_energy(robot: ClosedLoopRobot) -> None:
    """1e-8 of the weight's largest force; the 3-RRR moves level and has none."""
    positions, _ = states(robot, 10)
    gravity = robot.gravity(positions)
    slopes = [
        derivative(lambda t, unit=unit: robot.potential_energy(positions + t * unit), STEP)
        for unit in np.eye(positions.shape[1])
    ]
    assert_allclose(
        gravity,
        np.stack(slopes, axis=-1),
        rtol=0,
        atol=1e-8 * max(float(np.abs(gravity).max()), 1e-4),
    )
    assert (np.abs(gravity).max() > 0.1) == (robot.model.name != "planar_3rrr")


def test_rate_of_the_mass_matrix_less_twice_coriolis_is_skew(robot: ClosedLoopRobot) -> None:
    """dM/dt = C + C' is the same as x'(dM/dt - 2C)x = 0 for every x.

    To 1e-7 of the largest entry of dM/dt, which differences give.
    """
    positions, speeds = states(robot, 10)
    rate = derivative(lambda t: robot.mass_matrix(positions + t * speeds), STEP)
    coriolis = robot.coriolis_matrix(positions, speeds)
    assert relative_error(coriolis + coriolis.swapaxes(1, 2), rate) < 1e-7


def test_forward_dynamics_undoes_inverse_dynamics(robot: ClosedLoopRobot) -> None:
    """Pinocchio's constraintDynamics on the whole tree against projected RNEA.

    And M a + C v + G; 1e-13 is reached.
    """
    positions, speeds = states(robot, 60)
    accelerations = np.random.default_rng(1).normal(size=positions.shape)
    forces = robot.inverse_dynamics(positions, speeds, accelerations)
    mass, coriolis, gravity = robot.equation_of_motion(positions, speeds)
    assembled = (
        np.einsum("nij,nj->ni", mass, accelerations)
        + np.einsum("nij,nj->ni", coriolis, speeds)
        + gravity
    )
    assert relative_error(assembled, forces) < 1e-11
    found = robot.forward_dynamics(positions, speeds, forces)
    # Relative to what the forces alone would give: they mostly carry the weight.
    scale = np.abs(np.linalg.solve(mass, forces[..., None])).max(axis=1)
    assert (np.abs(found - accelerations) / scale).max() < 1e-11


def test_natural_orthogonal_complement_agrees(robot: ClosedLoopRobot) -> None:
    """The thesis's equations, body by body, on redundant closures, too; C is not unique, C v is.

    1e-13 is reached.
    """
    positions, speeds = states(robot, 20)
    noc = NaturalOrthogonalComplement(robot)
    mass, coriolis, gravity = robot.equation_of_motion(positions, speeds)
    their_mass, their_coriolis, their_gravity = noc.equation_of_motion(positions, speeds)
    assert relative_error(their_mass, mass) < 1e-10
    assert (
        relative_error(
            np.einsum("nij,nj->ni", their_coriolis, speeds),
            np.einsum("nij,nj->ni", coriolis, speeds),
        )
        < 1e-10
    )
    assert_allclose(
        their_gravity, gravity, rtol=0, atol=1e-10 * max(float(np.abs(gravity).max()), 1e-3)
    )


def falling(robot: ClosedLoopRobot) -> tuple[Array, Array]:
    """State from which the robot is let go: at home, moving slowly."""
    return robot.reference, 0.3 * np.random.default_rng(2).normal(size=len(robot.actuated))


def test_energy_is_kept_in_free_motion(robot: ClosedLoopRobot) -> None:
    """Motors off, 0.1 s of fall, integrated by DOP853 to 1e-12.

    The sum of kinetic and potential energy stays, here to 1e-13 J or so.
    """
    plant = DormandPrince(robot)
    positions, speeds = falling(robot)
    plant.start(positions, speeds)
    energy = [robot.kinetic_energy(positions, speeds) + robot.potential_energy(positions)]
    kinetic = []
    for _ in range(5):
        after = plant.advance(np.zeros(len(positions)), 0.02)
        assert after is not None
        kinetic.append(robot.kinetic_energy(*after))
        energy.append(kinetic[-1] + robot.potential_energy(after[0]))
    assert np.ptp(energy) < 1e-11 * np.max(kinetic)


def test_plants_agree(robot: ClosedLoopRobot) -> None:
    """Runge-Kutta steps of 1 ms and the whole tree.

    Under Pinocchio's constraintDynamics, after 50 ms of fall.
    """
    ends = []
    for plant in (DormandPrince(robot), RungeKutta(robot), ConstraintDynamics(robot)):
        plant.start(*falling(robot))
        for _ in range(50):
            after = plant.advance(np.zeros(len(robot.actuated)), 1e-3)
        assert after is not None
        ends.append(np.concatenate(after))
    assert_allclose(ends[1], ends[0], rtol=0, atol=1e-8)
    assert_allclose(ends[2], ends[0], rtol=0, atol=1e-8)
