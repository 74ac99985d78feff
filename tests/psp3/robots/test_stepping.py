"""Compiled steps of any robot against the same steps in Python."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import psp3
from psp3.description.parts import THESIS_ROBOTS
from psp3.drives import NO_DRIVE, Drive
from psp3.robots.stepping import CoreSteps
from psp3.simulation.constraint_dynamics import ConstraintDynamics
from psp3.simulation.dormand_prince import DormandPrince
from psp3.simulation.plant import Plant
from psp3.simulation.runge_kutta import FixedSteps
from tests.mujoco_null_space import five_bar, gripper

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
    compiled = walk(CoreSteps(tree._core, tree._motors, 2, DRIVES[drive]), tree)
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


def with_friction(path: Path, *driven: str, crank: str = "", elbow: str = "") -> Any:
    """Return a five-bar with attributes of the joints m1 and p1."""
    text = five_bar(*driven, spring=elbow).replace('name="m1"', f'name="m1" {crank}', 1)
    file = path / "robot.xml"
    file.write_text(text, encoding="utf-8")
    return psp3.ClosedLoopRobot.from_mjcf(file, free="keep")


def test_a_joints_own_friction_is_that_of_a_drive(tmp_path: Path) -> None:
    """Of a motor's joint, from rest to motion and back: the same steps, to rounding.

    In the compiled plant, and in the two in Python.
    """
    plain = with_friction(tmp_path, "m1", "m2")
    robot = with_friction(tmp_path, "m1", "m2", crank='frictionloss="1.5"')
    drives = (Drive(coulomb_friction=1.5), NO_DRIVE)
    expected = walk(plain.compiled_steps(2, drives), plain)
    assert (expected[:, 2] == 0.0).any()
    assert (expected[:, 2] != 0.0).any()
    found = walk(robot.compiled_steps(2, NO_DRIVE), robot)
    assert_allclose(found, expected, rtol=0.0, atol=1e-12)
    in_python = walk(FixedSteps(robot, 2, NO_DRIVE), robot)
    assert_allclose(in_python, expected, rtol=0.0, atol=1e-11)
    reference = walk(DormandPrince(robot), robot)
    assert_allclose(reference, expected, rtol=0.0, atol=1e-5)


def test_friction_holds_a_free_coordinate_until_it_is_exceeded(tmp_path: Path) -> None:
    """An elbow without a motor, of friction F: it rests to the last bit while F can hold it.

    And begins to move with what the force leaves over F, which is found by hand.
    """
    weak, strong = (
        with_friction(tmp_path, "m1", elbow=f'frictionloss="{most}"') for most in (0.5, 30.0)
    )
    assert weak.coordinates == ("m1", "p1")
    rest = np.zeros(2)
    hold = strong.inverse_dynamics(strong.reference, rest, rest)
    assert 0.5 < abs(hold[1]) < 30.0
    plant = strong.compiled_steps(1, NO_DRIVE)
    plant.start(strong.reference, rest)
    for _ in range(50):
        state = plant.advance(hold[:1], 0.002)
    assert_array_equal(state[0][1], strong.reference[1])
    assert_array_equal(state[1][1], 0.0)
    plant = weak.compiled_steps(1, NO_DRIVE)
    plant.start(weak.reference, rest)
    state = plant.advance(hold[:1], 1e-5)
    mass = weak.mass_matrix(weak.reference)
    pulls = np.array([0.0, -hold[1] + 0.5 * np.sign(hold[1])])
    assert_allclose(state[1], 1e-5 * np.linalg.solve(mass, pulls), rtol=1e-4)


def test_drives_do_not_depend_on_which_joints_are_coordinates() -> None:
    """A five-bar with geared motors, in their coordinates and in those of the elbows.

    Over 40 ms in steps of 0.25 ms, while both motors slip: 1e-8 of some 0.1 rad and 1 rad/s.
    """
    motors = psp3.load("five_bar")
    elbows = psp3.ClosedLoopRobot(
        *(motors.model, motors.constraint_models, motors.actuated, motors.q0),
        coordinates=["leg1_elbow", "leg2_elbow"],
    )
    drives = [Drive(0.02, 0.05, 1e-4, 1.0), Drive(0.03, 0.02, 3e-4, 1.0)]
    speeds, forces = np.array([1.0, 0.8]), np.array([0.4, 0.3])
    ends = []
    for robot in (motors, elbows):
        assert robot.drives_coordinates == (robot is motors)
        plant = robot.compiled_steps(8, drives)
        start = motors.velocity(motors.reference, speeds)[robot.coordinates_v]
        plant.start(robot.reference, start)
        for _ in range(20):
            state = plant.advance(forces, 0.002)
            assert state is not None
        at, moving = robot.configuration(state[0]), robot.velocity(*state)
        ends.append(np.concatenate([at, moving]))
        assert (moving[motors.coordinates_v] > 0.1).all()
    assert_allclose(ends[1], ends[0], rtol=0.0, atol=1e-8)
    assert np.abs(ends[0][:4] - motors.q0).max() > 0.03


def test_power_goes_into_energy_rotors_and_friction(tmp_path: Path) -> None:
    """Of a finger's tendon, which moves two joints that follow others.

    The motor's work is the energy gained, with that of its rotor, and what its friction and the
    damping of the joints took, which is integrated by the trapezoidal rule over 1600 periods: 1e-8
    of 0.03 J.
    """
    file = tmp_path / "robot.xml"
    file.write_text(gripper(), encoding="utf-8")
    robot = psp3.ClosedLoopRobot.from_mjcf(file, free="keep")
    drive = Drive(viscous_friction=0.4, motor_inertia=2e-3, lead=1.0)
    assert_array_equal(robot.drives_of_coordinates(drive).follows, [-1])
    plant, force, period = robot.compiled_steps(1, drive), np.array([2.0]), 2.5e-5
    states = [(robot.reference, np.zeros(len(robot.coordinates)))]
    plant.start(*states[0])
    for _ in range(1600):
        state = plant.advance(force, period)
        assert state is not None
        states.append((state[0].copy(), state[1].copy()))
    positions, speeds = (np.array(rows) for rows in zip(*states, strict=True))
    every = robot.velocity(positions, speeds)
    turning = (every @ robot.motors)[:, 0]
    energy = robot.kinetic_energy(positions, speeds) + robot.potential_energy(positions)
    energy += 0.5 * drive.reflected_inertia * turning**2
    power = force[0] * turning - 0.4 * turning**2 - every**2 @ robot.model.damping
    work = period * (power.sum() - 0.5 * (power[0] + power[-1]))
    assert_allclose(energy[-1] - energy[0], work, rtol=0.0, atol=1e-8)
    braked = 0.4 * period * (turning**2).sum()
    assert 0.5 * drive.reflected_inertia * turning[-1] ** 2 > 1e-3
    assert braked > 1e-3


def swinging(planar: bool) -> psp3.ClosedLoopRobot:
    """Return a pendulum with a motor on a cart that slides and turns, in one joint or in three."""
    model, unit = pin.Model(), pin.SE3.Identity()
    kinds = (
        [("cart", pin.JointModelPlanar())]
        if planar
        else [("x", pin.JointModelPX()), ("y", pin.JointModelPY()), ("yaw", pin.JointModelRZ())]
    )
    parent = 0
    for name, kind in kinds:
        parent = model.addJoint(parent, kind, unit, name)
    inertia = pin.Inertia(2.0, np.array([0.1, 0.2, 0.0]), np.diag([0.1, 0.2, 0.3]))
    model.appendBodyToJoint(parent, inertia, unit)
    arm = model.addJoint(parent, pin.JointModelRZ(), pin.SE3(np.eye(3), np.ones(3)), "arm")
    model.appendBodyToJoint(arm, inertia, unit)
    model.gravity = pin.Motion(np.array([1.0, -9.0, 0.0]), np.zeros(3))
    return psp3.ClosedLoopRobot(model, [], ["arm"], free="keep")


def test_a_planar_base_moves_as_two_slides_and_a_hinge() -> None:
    """Whose coordinates are other functions of time: over 0.5 s in steps of 1 ms to 1e-9.

    The cart's own speeds are in its axes, which turn by more than a radian.
    """
    planar, composed = swinging(True), swinging(False)
    assert planar.coordinates == ("arm", "cart")
    assert set(composed.coordinates) == {"arm", "x", "y", "yaw"}
    names = list(composed.coordinates)
    order = [names.index(name) for name in ("arm", "x", "y", "yaw")]
    plants = [robot.compiled_steps(1, NO_DRIVE) for robot in (planar, composed)]
    speeds = np.array([1.0, 0.5, -0.3, 2.5])
    plants[0].start(planar.reference, speeds)
    mixed = np.zeros(4)
    mixed[order] = speeds
    plants[1].start(composed.reference, mixed)
    for _ in range(500):
        first, second = (plant.advance(np.array([0.4]), 0.001) for plant in plants)
    arm, x, y, yaw = second[0][order]
    expected = [arm, x, y, np.cos(yaw), np.sin(yaw)]
    assert_allclose(first[0], expected, rtol=0.0, atol=1e-9)
    assert abs(yaw) > 1.0
    rates = second[1][order]
    turn = np.array([[np.cos(yaw), np.sin(yaw)], [-np.sin(yaw), np.cos(yaw)]])
    assert_allclose(first[1], [rates[0], *(turn @ rates[1:3]), rates[3]], rtol=0.0, atol=1e-9)


def test_a_motion_does_not_depend_on_where_the_floating_base_is() -> None:
    """A biped with swinging legs falls for 0.4 s: bit for bit the same at home and far away.

    But for where its base is. Seen from an origin 160 m away, the loops were lost in rounding.
    """
    robot = psp3.load("biped")
    rng, n = np.random.default_rng(5), len(robot.coordinates_v)
    speeds, forces = 0.2 * rng.normal(size=n), np.zeros(len(robot.actuated))
    base = len(robot.reference) - 7
    ends = []
    for away in (0.0, 1e5):
        plant, positions = robot.compiled_steps(1, NO_DRIVE), robot.reference.copy()
        positions[base : base + 3] += away
        plant.start(positions, speeds)
        for _ in range(200):
            state = plant.advance(forces, 0.002)
            assert state is not None
        ends.append([np.delete(state[0], range(base, base + 3)), state[1]])
    for home, far in zip(*ends, strict=True):
        assert_array_equal(home, far)


def test_answers_do_not_depend_on_where_the_floating_base_is() -> None:
    """Forces, masses and accelerations of a biped 1e6 m away, bit for bit; frames to rounding.

    Kinetic energy, too; potential energy by the weight times the height.
    """
    robot, rng, away = psp3.load("biped"), np.random.default_rng(6), np.array([1e6, -2e6, 3e6])
    n, base = len(robot.coordinates_v), len(robot.reference) - 7
    here = robot.reference.copy()
    here[:base] += rng.uniform(-0.05, 0.05, base)
    there = here.copy()
    there[base : base + 3] += away
    v, a = rng.normal(size=(2, n))
    for answer in (robot.inverse_dynamics, robot.forward_dynamics):
        assert_array_equal(answer(there, v, a), answer(here, v, a))
    for one, other in zip(
        robot.equation_of_motion(there, v), robot.equation_of_motion(here, v), strict=True
    ):
        assert_array_equal(one, other)
    assert_array_equal(robot.kinetic_energy(there, v), robot.kinetic_energy(here, v))
    mass = sum(inertia.mass for inertia in robot.model.inertias)
    lifted = robot.potential_energy(there) - robot.potential_energy(here)
    assert_allclose(lifted, -mass * robot.model.gravity.linear @ away, rtol=1e-12)
    moved = robot.frame_placement(there, "left_foot") - robot.frame_placement(here, "left_foot")
    assert_allclose(moved[:3, 3], away, rtol=0.0, atol=1e-9)
    assert_array_equal(moved[:, :3], 0.0)
    assert_array_equal(
        robot.frame_jacobian(there, "left_foot"), robot.frame_jacobian(here, "left_foot")
    )


def rough_elbows(*coordinates: str, gravity: float = 9.81) -> psp3.ClosedLoopRobot:
    """Return the five-bar with dry friction in its elbows, which its motors do not drive."""
    smooth = psp3.load("five_bar")
    model, friction = smooth.model.copy(), np.zeros(smooth.model.nv)
    friction[[model.joints[model.getJointId(f"leg{leg}_elbow")].idx_v for leg in (1, 2)]] = 0.6
    model.upperDryFrictionLimit, model.lowerDryFrictionLimit = friction, -friction
    model.gravity.linear = np.array([0.0, 0.0, -gravity])
    return psp3.ClosedLoopRobot(
        model,
        smooth.constraint_models,
        smooth.actuated,
        smooth.q0,
        coordinates=coordinates or None,
    )


def energies(robot: psp3.ClosedLoopRobot, speeds: list[float], steps: int) -> tuple[Any, Any]:
    """Return positions and energy of 200 periods without motor forces."""
    plant, rows, energy = robot.compiled_steps(steps, NO_DRIVE), [], []
    plant.start(robot.reference, np.array(speeds))
    for _ in range(200):
        state = plant.advance(np.zeros(2), 0.002)
        assert state is not None
        rows.append(state[0].copy())
        energy.append(float(robot.kinetic_energy(*state) + robot.potential_energy(state[0])))
    return np.array(rows), np.array(energy)


def test_dry_friction_of_coordinates_holds_and_that_of_joints_that_follow_two_trembles() -> None:
    """Friction of 0.6 N m in the elbows of a five-bar carries its weight, of 0.4 N m at its motors.

    As coordinates the elbows hold it, and not a bit moves. As joints that follow both motors they
    have the sign of the speed: what creeps is of the first order in the step, so that half the
    step leaves half of it, here within a fifth.
    """
    held = rough_elbows("leg1_elbow", "leg2_elbow")
    rows, energy = energies(held, [0.0, 0.0], 1)
    assert_array_equal(rows, np.broadcast_to(held.reference, rows.shape))
    assert (energy == energy[0]).all()
    trembling = rough_elbows()
    crept = [
        np.abs(energies(trembling, [0.0, 0.0], steps)[0][-1] - trembling.reference).max()
        for steps in (4, 8, 16)
    ]
    assert 0.0 < crept[2] < crept[1] < crept[0] < 0.05
    assert_allclose(np.divide(crept[:2], crept[1:]), 2.0, rtol=0.2)


def rough_leg(friction: float, *coordinates: str) -> psp3.ClosedLoopRobot:
    """Return Jansen's leg, which one crank moves, with dry friction in all seven joints."""
    smooth = psp3.load("jansen")
    model = smooth.model.copy()
    every = np.full(model.nv, friction)
    model.upperDryFrictionLimit, model.lowerDryFrictionLimit = every, -every
    return psp3.ClosedLoopRobot(
        *(model, smooth.constraint_models, smooth.actuated, smooth.q0),
        coordinates=coordinates or None,
    )


def test_friction_of_joints_that_follow_one_coordinate_holds_it() -> None:
    """Each by its lever: up to the weight at rest to the last bit, and beyond with what is left.

    The levers are how fast the joints turn per turn of the crank, and weight and mass those of the
    leg without friction.
    """
    smooth = psp3.load("jansen")
    start, rest = smooth.reference, np.zeros(1)
    levers = np.abs(smooth.velocity(start, [1.0])).sum()
    weight, mass = smooth.gravity(start)[0], smooth.mass_matrix(start)[0, 0]
    for share, holds in ((0.999, False), (1.001, True)):
        friction = share * weight / levers
        plant = rough_leg(friction).compiled_steps(1, NO_DRIVE)
        plant.start(start, rest)
        for _ in range(50):
            state = plant.advance(rest, 1e-5)
        if holds:
            assert_array_equal(np.concatenate(state), [*start, 0.0])
        else:
            left = weight - friction * levers
            assert_allclose(state[1], -50e-5 * left / mass, rtol=1e-3)


def test_stick_and_slip_do_not_depend_on_which_joint_is_the_coordinate() -> None:
    """Jansen's leg, rubbing in all joints, swung by its crank, a motor that has friction, too.

    The rocker, which is the coordinate of the second, follows the crank without a dead center here.
    Both stick in the same periods, to the last bit, and the two plants in Python with them; motions
    are the same to 1e-9 of 0.5 rad and 3 rad/s.
    """
    crank, drive = rough_leg(0.05), Drive(0.02, 0.01, 1e-5, 1.0)
    rocker = rough_leg(0.05, "rocker_c_joint")
    assert_array_equal(crank.drives_of_coordinates(drive).follows, np.zeros(6))
    assert_array_equal(rocker.drives_of_coordinates(drive).follows, np.zeros(7))
    motions = []
    for robot, plant in (
        (crank, crank.compiled_steps(8, drive)),
        (rocker, rocker.compiled_steps(8, drive)),
        (rocker, FixedSteps(rocker, 8, drive)),
        (rocker, DormandPrince(rocker, drive=drive)),
        (rocker, ConstraintDynamics(rocker, steps=8, drive=drive)),
    ):
        plant.start(robot.reference, np.zeros(1))
        rows = []
        for k in range(150):
            state = plant.advance(np.array([0.9 * np.sin(0.018 * k)]), 0.002)
            assert state is not None
            row = robot.configuration(state[0])[0], robot.velocity(*state)[0]
            rows.append(row)
        motions.append(np.array(rows))
    stuck = motions[0][:, 1] == 0.0
    assert 0 < stuck.sum() < 100
    assert np.ptp(motions[0][:, 0]) > 0.2
    for motion in motions[1:]:
        assert_allclose(motion, motions[0], rtol=0.0, atol=1e-9)
        assert_array_equal(motion[:, 1] == 0.0, stuck)


@pytest.mark.parametrize("coordinates", [(), ("leg1_elbow", "leg2_elbow")])
def test_energy_never_grows_under_friction(coordinates: tuple[str, ...]) -> None:
    """Of a five-bar thrown without weight, whichever its coordinates are: 1e-10 of 6 mJ at first.

    Where the elbows follow, a step in which a speed turns round may add what friction does in it.
    """
    robot, motors = rough_elbows(*coordinates, gravity=0.0), rough_elbows(gravity=0.0)
    # The same motion, in whatever coordinates.
    assert_allclose(robot.q0, motors.q0, rtol=0.0, atol=1e-12)
    speeds = motors.velocity(motors.reference, [1.0, -0.5])[robot.coordinates_v]
    _, energy = energies(robot, speeds.tolist(), 16)
    assert 1e-3 < energy[0] < 1e-2
    assert np.diff(energy).max() < 1e-10
    assert energy[-1] < 1e-3 * energy[0]
