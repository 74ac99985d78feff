"""What dynamics must keep, of robots that hypothesis makes up.

Each robot is asked at a few states near home. Where the package refuses a robot or a state that is
no example; it may not answer wrongly.

Numbers are compared relative to the terms of which they are sums. Where a loop is near a singular
pose, small differences of joints become large ones, so that poses are left out where a joint moves
more than twenty times as fast as the coordinates.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import HealthCheck, assume, event, given, settings
from hypothesis import strategies as st
from numpy.polynomial import Polynomial

from psp3.closure.structure import TOLD_MISMATCH
from psp3.errors import (
    ClosureFailed,
    DependentCoordinates,
    MobilityMismatch,
    NoFiniteAnswer,
    RoundedLoops,
    SingularConfiguration,
    UncertainRank,
)
from psp3.multibody.equations import Coupling, Hinge
from psp3.robots.closed_loop_robot import ClosedLoopRobot
from psp3.robots.implementations import unknown_to_the_thesis
from psp3.simulation.dormand_prince import DormandPrince
from tests import examples
from tests.helpers import Array, derivative
from tests.strategies.robots import Parts, moved, robots

pytestmark = pytest.mark.slow

NO_ROBOT = (MobilityMismatch, RoundedLoops, UncertainRank, DependentCoordinates)
"""What is refused: nothing moves, whether it moves cannot be told, or what is left free is a joint
that cannot be a coordinate.
"""
NO_POSE = (ClosureFailed, SingularConfiguration)

FASTEST = 20.0
"""Most that a joint may move as fast as the coordinates."""

OF_ROBOTS = settings(
    max_examples=examples(1000, of=25),
    suppress_health_check=[HealthCheck.filter_too_much, HealthCheck.too_slow],
)
SEEDS = st.integers(0, 2**32 - 1)


class State(NamedTuple):
    """A robot somewhere near home, and what is asked of it."""

    robot: ClosedLoopRobot
    positions: Array
    speeds: Array
    accelerations: Array
    q: Array
    complement: Array

    def at(self, way: Array) -> Array:
        """Return the positions after a step along the coordinates."""
        return after(self.robot, self.q, way)

    @property
    def size(self) -> float:
        """The size of the terms of a force: these may cancel, but not their rounding."""
        M, C, G = map(np.abs, self.robot.equation_of_motion(self.positions, self.speeds))
        terms = M @ np.abs(self.accelerations) + C @ np.abs(self.speeds) + G
        return float(terms.max() + M.max())


def after(robot: ClosedLoopRobot, q: Array, way: Array) -> Array:
    """Return the positions of a configuration after a step along the coordinates."""
    step = np.zeros(robot.model.nv)
    step[robot.coordinates_v] = way
    found: Array = pin.integrate(robot.model, q, step)[robot.coordinates_q]
    return found


def made(parts: Parts) -> ClosedLoopRobot:
    """Return the robot, where it is one, and where its loops are not told to be rounded.

    All loops here are exact; but one with a short lever may be rounded as well, and is told to be.
    """
    try:
        robot = parts.robot()
    except NO_ROBOT as error:
        event(f"no robot: {type(error).__name__}")
        assume(False)
        raise
    mismatch = max(robot.closure_mismatch.length, robot.closure_mismatch.angle)
    if mismatch > TOLD_MISMATCH:
        event("told: loops are rounded")
        assume(False)
    return robot


def somewhere(robot: ClosedLoopRobot, seed: int, reach: float = 0.05) -> State:
    """Return a state near home, where there is one and no joint races."""
    rng, n = np.random.default_rng(seed), len(robot.coordinates_v)
    positions = after(robot, robot.q0, rng.uniform(-reach, reach, n))
    try:
        pose = robot.closure(positions)
    except NO_POSE as error:
        event(f"no pose: {type(error).__name__}")
        assume(False)
        raise
    assume(np.abs(pose.complement).max() < FASTEST)
    speeds, accelerations = rng.uniform(-1.0, 1.0, (2, n))
    return State(robot, positions, speeds, accelerations, pose.configuration, pose.complement)


def differences(function: Callable[[Array], Array], n: int, step: float = 2e-4) -> Array:
    """Return the derivatives by each of n numbers, in columns, around zero."""
    units = np.eye(n)
    return np.stack(
        [derivative(lambda t, u=unit: function(t * u), step) for unit in units], axis=-1
    )


def gaps(robot: ClosedLoopRobot, q: Array) -> list[float]:
    """Return by how much each closure is open, from Pinocchio's placements [m, rad]."""
    model, data = robot.model, robot.model.createData()
    pin.forwardKinematics(model, data, q)
    found = []
    for one in [*robot.constraint_models, *robot.equations]:
        if isinstance(one, Coupling):
            y, x = (q[model.joints[number].idx_q] for number in (one.y, one.x))
            found.append(abs(y - Polynomial(one.coefficients)(x)))
            continue
        first = data.oMi[one.joint1_id] * one.joint1_placement
        gap = first.actInv(data.oMi[one.joint2_id] * one.joint2_placement)
        found.append(np.abs(gap.translation).max())
        if isinstance(one, Hinge):
            found.append(np.abs(gap.rotation[:, 2] - [0.0, 0.0, 1.0]).max())
        elif one.type == pin.ContactType.CONTACT_6D:
            found.append(np.abs(pin.log3(gap.rotation)).max())
    return found


@OF_ROBOTS
@given(robots(), SEEDS)
def test_loops_are_closed(parts: Parts, seed: int) -> None:
    """To 1e-10 m and rad at home and elsewhere, and the speeds L v keep them so: 1e-9."""
    robot = made(parts)
    state = somewhere(robot, seed, 0.1)
    assert max(gaps(robot, robot.q0), default=0.0) < 1e-10
    assert max(gaps(robot, state.q), default=0.0) < 1e-10
    v = state.complement @ state.speeds
    np.testing.assert_allclose(robot.velocity(state.positions, state.speeds), v, atol=1e-12)
    for t in (-1e-6, 1e-6):
        opened = gaps(robot, pin.integrate(robot.model, state.q, t * v))
        assert max(opened, default=0.0) < 1e-9


@OF_ROBOTS
@given(robots(damping=False), SEEDS)
def test_mass_coriolis_and_gravity(parts: Parts, seed: int) -> None:
    """M is symmetric and positive definite, and Ṁ − 2C skew.

    Ṁ by differences, 1e-7 of what is subtracted. Damping would be in C, too.
    """
    state = somewhere(made(parts), seed)
    robot, v = state.robot, state.speeds
    M, C, _ = robot.equation_of_motion(state.positions, v)
    np.testing.assert_array_equal(M, M.T)
    assert np.linalg.eigvalsh(M)[0] > 0.0
    rate = derivative(lambda t: robot.mass_matrix(state.at(t * v)), 1e-3)
    skew = rate - 2.0 * C
    floats = len(robot.reference) > len(v)
    if floats:
        # Speeds of a floating base are no rates of coordinates: only the power is kept.
        assert abs(v @ skew @ v) < 1e-7 * (1.0 + np.abs(rate).max() + state.size)
    else:
        assert np.abs(skew + skew.T).max() < 1e-7 * (1.0 + np.abs(rate).max() + state.size)


@OF_ROBOTS
@given(robots(), SEEDS)
def test_forward_dynamics_turns_inverse_dynamics_around(parts: Parts, seed: int) -> None:
    """1e-12 of the terms times the condition of M; and M a + C v + G are the forces, too."""
    state = somewhere(made(parts), seed)
    robot, x, v, a = state.robot, state.positions, state.speeds, state.accelerations
    forces = robot.inverse_dynamics(x, v, a)
    M, C, G = robot.equation_of_motion(x, v)
    assert np.abs(M @ a + C @ v + G - forces).max() < 1e-10 * state.size
    found = robot.forward_dynamics(x, v, forces)
    least = np.linalg.eigvalsh(M)[0]
    assert np.abs(found - a).max() < 1e-12 * (1.0 + state.size / least)


@OF_ROBOTS
@given(robots(damping=False), SEEDS)
def test_power_is_the_rate_of_the_energy(parts: Parts, seed: int) -> None:
    """By differences of both energies along the motion; 1e-7 of the terms."""
    state = somewhere(made(parts), seed)
    robot, v, a = state.robot, state.speeds, state.accelerations
    forces = robot.inverse_dynamics(state.positions, v, a)

    def energy(t: float) -> Array:
        at = state.at(t * v + 0.5 * t**2 * a)
        return robot.kinetic_energy(at, v + t * a) + robot.potential_energy(at)

    assert abs(forces @ v - derivative(energy, 1e-3)) < 1e-7 * (1.0 + len(v) * state.size)


@OF_ROBOTS
@given(robots(damping=False), SEEDS)
def test_energy_is_kept_without_forces(parts: Parts, seed: int) -> None:
    """Over 30 ms with DOP853 to 1e-11: 1e-8 of what there is and what turns over."""
    state = somewhere(made(parts), seed)
    robot = state.robot
    plant = DormandPrince(robot, 1e-11)
    plant.start(state.positions.copy(), 0.3 * state.speeds)
    before = robot.kinetic_energy(state.positions, 0.3 * state.speeds)
    before += robot.potential_energy(state.positions)
    try:
        end = plant.advance(np.zeros(len(robot.actuated)), 0.03)
    except NO_POSE:
        assume(False)
        raise
    assume(end is not None)
    kinetic, potential = robot.kinetic_energy(*end), robot.potential_energy(end[0])
    assert abs(kinetic + potential - before) < 1e-8 * (1.0 + kinetic + state.size)


@OF_ROBOTS
@given(robots(), SEEDS)
def test_every_route_gives_the_same(parts: Parts, seed: int) -> None:
    """The projected tree of NumPy, and where it knows the robot the complement of the thesis.

    1e-9 of the terms, each closing its own loops.
    """
    state = somewhere(made(parts), seed)
    robot, x, v = state.robot, state.positions, state.speeds
    M, C, G = robot.equation_of_motion(x, v)
    for name in ("pinocchio", "noc"):
        if name == "noc" and unknown_to_the_thesis(robot):
            event("unknown to noc")
            continue
        route = robot.dynamics(name)
        event(f"by {name}")
        mass, coriolis, gravity = route.equation_of_motion(x, v)
        for ours, theirs in ((M, mass), (C @ v, coriolis @ v), (G, gravity)):
            assert np.abs(ours - theirs).max() < 1e-9 * state.size


@OF_ROBOTS
@given(robots(), SEEDS)
def test_derivatives_are_differences(parts: Parts, seed: int) -> None:
    """Of forces, and of where the last body is; 1e-6 of the terms."""
    state = somewhere(made(parts), seed)
    robot, v, a, n = state.robot, state.speeds, state.accelerations, len(state.speeds)
    slopes = robot.inverse_dynamics_derivatives(state.positions, v, a)
    expected = (
        differences(lambda w: robot.inverse_dynamics(state.at(w), v, a), n),
        differences(lambda w: robot.inverse_dynamics(state.positions, v + w, a), n, 1e-2),
    )
    for ours, theirs in zip(slopes, expected, strict=False):
        assert np.abs(ours - theirs).max() < 1e-6 * (1.0 + state.size + np.abs(theirs).max())
    frame = f"b{parts.model.njoints - 1}"
    place = robot.frame_placement(state.positions, frame)
    jacobian = robot.frame_jacobian(state.positions, frame)
    turn = place[:3, :3]

    def twist(way: Array) -> Array:
        there = robot.frame_placement(state.at(way), frame)
        apart = pin.SE3(place).actInv(pin.SE3(there))
        return np.concatenate([turn @ apart.translation, turn @ pin.log3(apart.rotation)])

    assert np.abs(differences(twist, n) - jacobian).max() < 1e-7 * (1.0 + np.abs(jacobian).max())


@OF_ROBOTS
@given(robots(), SEEDS)
def test_another_base_changes_nothing(parts: Parts, seed: int) -> None:
    """The robot and its gravity turned and carried elsewhere: 1e-9 of the terms.

    A ball of which more than one direction of spin is free has no directions of its own.
    """
    state = somewhere(made(parts), seed)
    assume(all("_spin" not in name for name in state.robot.coordinates))
    balls = [one.joint for one in state.robot.locked if one.spin is not None]
    assume(len(balls) == len(set(balls)))
    robot, x, v = state.robot, state.positions, state.speeds
    place = pin.SE3(pin.exp3(np.array([0.3, -1.0, 0.5])), np.array([1.0, -0.5, 0.3]))
    elsewhere = moved(parts, place).robot()
    assert elsewhere.coordinates == robot.coordinates
    assert [one.joint for one in elsewhere.locked] == [one.joint for one in robot.locked]
    for ours, theirs in zip(
        robot.equation_of_motion(x, v), elsewhere.equation_of_motion(x, v), strict=True
    ):
        assert np.abs(ours - theirs).max() < 1e-9 * state.size


@OF_ROBOTS
@given(robots(), SEEDS)
def test_rows_are_single_states(parts: Parts, seed: int) -> None:
    """1e-10 of the terms: a row may start where the one before ended."""
    state = somewhere(made(parts), seed)
    robot, v, a = state.robot, state.speeds, state.accelerations
    ways = [state.at(k * 0.01 * v) for k in range(-2, 3)]
    try:
        rows = robot.inverse_dynamics(np.array(ways), np.tile(v, (5, 1)), np.tile(a, (5, 1)))
        single = [robot.inverse_dynamics(way, v, a) for way in ways]
    except (*NO_POSE, NoFiniteAnswer):
        assume(False)
        raise
    assert np.abs(rows - single).max() < 1e-10 * state.size
