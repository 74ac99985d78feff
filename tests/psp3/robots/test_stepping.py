"""Compiled steps of any robot against the same steps in Python."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import psp3
from psp3.description.parts import THESIS_ROBOTS
from psp3.drives import NO_DRIVE, Drive
from psp3.robots.stepping import CoreSteps
from psp3.simulation.plant import Plant
from psp3.simulation.runge_kutta import FixedSteps

DRIVES = {
    "free": NO_DRIVE,
    "motors": Drive(viscous_friction=0.1, motor_inertia=1e-5, lead=0.01),
    "dry friction": Drive(coulomb_friction=0.4, viscous_friction=0.1),
}


def walk(plant: Plant, robot: psp3.ClosedLoopRobot) -> np.ndarray:
    """Return the states of 40 periods of 2 ms under random forces about the weight."""
    rng, rest = np.random.default_rng(0), np.zeros(len(robot.actuated))
    hold = robot.inverse_dynamics(robot.reference, rest, rest)
    plant.start(robot.reference, rest)
    states = []
    for _ in range(40):
        state = plant.advance(hold + rng.normal(size=len(rest)), 0.002)
        assert state is not None
        states.append(np.concatenate(state))
    return np.array(states)


@pytest.mark.parametrize("drive", DRIVES)
@pytest.mark.parametrize("name", THESIS_ROBOTS)
def test_steps_are_those_in_python(name: str, drive: str) -> None:
    """To rounding, which grows along the motion: 1e-12 of some 0.1 rad, m and 1 rad/s, m/s.

    Where friction acts, some joint sticks at times, and moves at others.
    """
    robot = psp3.load(name)
    tree = psp3.ClosedLoopRobot(robot.model, robot.constraint_models, robot.actuated, robot.q0)
    compiled = walk(CoreSteps(tree._core, 2, DRIVES[drive]), tree)
    expected = walk(FixedSteps(tree, 2, DRIVES[drive]), tree)
    assert_allclose(compiled, expected, rtol=0.0, atol=1e-12)
    if drive == "dry friction":
        speeds = compiled[:, len(tree.actuated) :]
        assert (speeds == 0.0).any()
        assert (speeds != 0.0).any()


def test_a_second_start_forgets_the_first() -> None:
    robot = psp3.load("gough_stewart")
    plant = robot.compiled_steps(1, NO_DRIVE)
    assert_array_equal(walk(plant, robot), walk(plant, robot))


@pytest.mark.parametrize("drive", [NO_DRIVE, Drive(coulomb_friction=0.1)])
def test_a_motion_out_of_reach_ends(drive: Drive) -> None:
    """The cranks of the five-bar are thrown apart until its rods cannot meet any more."""
    robot = psp3.load("five_bar")
    plants = [robot.compiled_steps(1, drive), FixedSteps(robot, 1, drive)]
    periods = []
    for plant in plants:
        plant.start(robot.reference, np.zeros(2))
        count = 0
        while plant.advance(np.array([-20.0, 20.0]), 0.002) is not None:
            count += 1
            assert count < 2000
        periods.append(count)
    assert periods[0] == periods[1]


def test_what_a_motor_and_gravity_do_is_energy() -> None:
    """Under constant torques the energy grows by their work; RK4 of 0.2 ms errs by 1e-10 J."""
    robot, forces = psp3.load("five_bar"), np.array([0.3, -0.2])
    plant = robot.compiled_steps(10, NO_DRIVE)
    start, rest = robot.reference, np.zeros(2)
    plant.start(start, rest)
    for _ in range(50):
        state = plant.advance(forces, 0.002)
        assert state is not None
    positions, speeds = state
    gained = robot.kinetic_energy(positions, speeds) + robot.potential_energy(positions)
    gained -= robot.potential_energy(start)
    assert_allclose(gained, forces @ (positions - start), rtol=0.0, atol=1e-9)
