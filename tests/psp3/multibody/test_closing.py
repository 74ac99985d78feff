"""Moving motors with all loops closed: assembly modes, refusals, and what may not be passed."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

import psp3
from psp3.errors import ClosureFailed, SingularConfiguration
from psp3.kinematics.task_driven import without_limits
from psp3.multibody.closing import (
    CLOSED,
    LARGEST_PREDICTED_STEP,
    LARGEST_REPAIR,
    MOST_ATTEMPTS,
    OPEN,
    SINGULAR,
    moved_to,
    newton,
    settled,
    spread,
)
from psp3.multibody.loops import residual_of
from psp3.multibody.tree import (
    AT_CONFIGURATION,
    AT_JOINT_SPEEDS,
    AT_REPORT,
    AT_RIGHT,
    AT_SIGNS,
    COORDINATES,
    DEPENDENT,
    GROUPS,
    ROWS,
)
from psp3.robots.closed_loop_robot import ClosedLoopRobot
from tests.helpers import Array, derivative, spatial_loop_closed_with_3d
from tests.psp3.closure.linkages import five_bar
from tests.psp3.multibody.flat import Flat, flat_of, independent_of
from tests.psp3.multibody.test_loops import whole_jacobian


def configuration(flat: Flat) -> Array:
    return flat.part(AT_CONFIGURATION, flat.count(COORDINATES))


def largest_gap(flat: Flat) -> float:
    return max(residual_of(*flat.all, group) for group in range(flat.count(GROUPS)))


def settle(flat: Flat, q: Array) -> int:
    configuration(flat)[:] = q
    return int(settled(*flat.all))


# Kernels


def test_a_guess_is_closed_with_its_independent_joints_fixed(parts: SimpleNamespace) -> None:
    flat, rng = flat_of(parts), np.random.default_rng(101)
    step = rng.uniform(-0.03, 0.03, parts.model.nv)
    motors = independent_of(parts)
    step[motors] = 0.0
    guess = pin.integrate(parts.model, parts.q0, step)
    assert settle(flat, guess) == CLOSED
    assert largest_gap(flat) < 1e-12
    for name in parts.actuated:
        at = parts.model.joints[parts.model.getJointId(name)].idx_q
        assert configuration(flat)[at] == guess[at]


def test_a_guess_that_closes_no_loop_is_refused_with_the_group_and_residual() -> None:
    robot = five_bar()
    flat = flat_of(robot)  # type: ignore[arg-type]
    # The elbows farther apart than both links reach.
    assert settle(flat, np.array([np.pi, 0.3, 0.0, 0.3])) != CLOSED
    share, residual, group = flat.part(AT_REPORT, 4)[:3]
    assert (share, group) == (0.0, 0.0)
    assert residual > 0.05
    # Closed only after its joints have moved by more than a guess may be off.
    assert settle(flat, robot.q0 + np.array([0.0, 1.5 * LARGEST_REPAIR, 0.0, 0.0])) != CLOSED


def test_newtons_method_stays_where_it_may_not_move(parts: SimpleNamespace) -> None:
    """With nearly no way allowed an open pose is no closed one."""
    flat, rng = flat_of(parts), np.random.default_rng(102)
    step = rng.uniform(-0.05, 0.05, parts.model.nv)
    step[independent_of(parts)] = 0.0
    q = pin.integrate(parts.model, parts.q0, step)
    flat.place(q)
    assert newton(*flat.all, 0, 1e-6, 1e-13, 0.0) == OPEN
    flat.place(q)
    assert newton(*flat.all, 0, 1.0, 1e-13, 0.0) == CLOSED
    assert largest_gap(flat) < 1e-13


def test_newtons_method_sees_the_sign_and_a_singular_pose() -> None:
    """Of two legs in line the determinant vanishes; the other way they have the other sign."""
    parts = spatial_loop_closed_with_3d()
    flat = flat_of(parts)
    flat.place(parts.q0)
    assert newton(*flat.all, 0, 1.0, 1e-13, 0.0) == CLOSED
    sign = float(flat.part(AT_SIGNS, 1)[0])
    for wanted, outcome in ((sign, CLOSED), (-sign, OPEN)):
        flat.place(parts.q0)
        assert newton(*flat.all, 0, 1.0, 1e-13, wanted) == outcome
    robot = five_bar()
    flat = flat_of(robot)  # type: ignore[arg-type]
    # Both far links on one line, along x.
    far, near, base = 0.35, 0.25, 0.3
    angle = np.arccos((far - 0.5 * base) / near)
    stretched = np.array([np.pi - angle, np.pi + angle, angle, np.pi - angle])
    flat.place(stretched)
    assert largest_gap(flat) < 1e-12
    assert newton(*flat.all, 0, 1.0, 1e-11, 0.0) == SINGULAR


def test_a_motion_ends_exactly_where_it_was_asked_to(parts: SimpleNamespace) -> None:
    """Independent coordinates to the bit, loops to 1e-13, and back again to 1e-12."""
    flat, rng = flat_of(parts), np.random.default_rng(103)
    assert settle(flat, parts.q0) == CLOSED
    start = configuration(flat).copy()
    at = [parts.model.joints[parts.model.getJointId(name)].idx_q for name in parts.actuated]
    goal = start[at] + rng.uniform(-0.2, 0.2, len(at))
    flat.aim(goal)
    assert moved_to(*flat.all) == CLOSED
    assert_array_equal(configuration(flat)[at], goal)
    assert largest_gap(flat) < 1e-13
    flat.aim(start[at])
    assert moved_to(*flat.all) == CLOSED
    assert_allclose(configuration(flat), start, rtol=0.0, atol=1e-12)
    before = flat.memory.copy()
    assert moved_to(*flat.all) == CLOSED
    assert_array_equal(configuration(flat), before[: len(start)])


def test_spread_puts_solutions_where_joints_are(
    parts: SimpleNamespace, flat: Flat, pose: Array
) -> None:
    """Dependent speeds z are found from J z, and put where they belong; 1e-11."""
    flat.close(pose)
    z = flat.part(AT_JOINT_SPEEDS, flat.nv)
    z[:] = 0.0
    dependent = np.setdiff1d(np.arange(flat.nv), independent_of(parts))
    wanted = np.random.default_rng(104).normal(size=flat.count(DEPENDENT))
    ours = whole_jacobian(flat, pose)[:, dependent]
    flat.close(pose)
    flat.part(AT_RIGHT, flat.count(ROWS))[:] = ours @ wanted
    spread(flat.tree, flat.memory, 0, flat.at(AT_JOINT_SPEEDS))
    assert_allclose(z[dependent], wanted, rtol=0.0, atol=1e-11)


# The robot's loops, against Pinocchio


def nearby(robot: ClosedLoopRobot, rng: np.random.Generator, size: float = 0.2) -> Array:
    position: Array = robot.reference + rng.uniform(-size, size, len(robot.actuated))
    return position


def test_complement_is_the_derivative_of_the_configuration(robot: ClosedLoopRobot) -> None:
    """In Pinocchio's tangent space, by differences of closures; 1e-8."""
    position = nearby(robot, np.random.default_rng(4))
    closure = robot.closure(position)
    for column, unit in enumerate(np.eye(len(robot.actuated))):

        def moved(t: float, unit: Array = unit) -> Array:
            q: Array = pin.difference(
                robot.model, closure.configuration, robot.configuration(position + t * unit)
            )
            return q

        assert_allclose(closure.complement[:, column], derivative(moved, 2e-3), rtol=0.0, atol=1e-8)


def test_dependent_inverse_solves_pinocchios_equations(robot: ClosedLoopRobot) -> None:
    """L's un-actuated rows are −(Φ^u)⁻¹ Φ^a; 1e-11. Its actuated rows are the identity."""
    closure = robot.closure(nearby(robot, np.random.default_rng(5)))
    jacobian = robot.constraint_jacobian(closure.configuration)
    assert_allclose(
        closure.complement[robot.dependent_v],
        -closure.dependent_inverse @ jacobian[:, robot.actuated_v],
        rtol=0.0,
        atol=1e-11,
    )
    assert np.abs(jacobian @ closure.complement).max() < 1e-12
    assert_array_equal(closure.complement[robot.actuated_v], np.eye(len(robot.actuated)))


def test_drift_is_the_rate_of_the_velocities_at_constant_actuated_speeds(
    robot: ClosedLoopRobot,
) -> None:
    """By differences of L along the motion; 1e-7 of accelerations of the order of 1."""
    rng = np.random.default_rng(6)
    for _ in range(5):
        position, speed = nearby(robot, rng), rng.uniform(-1.0, 1.0, len(robot.actuated))
        closure = robot.closure(position)
        rate = derivative(
            lambda t, p=position, s=speed: robot.closure(p + t * s).complement @ s, 2e-3
        )
        drift = robot.drift(closure.configuration, closure.complement @ speed)
        assert_allclose(drift, rate, rtol=0.0, atol=1e-7)


@pytest.fixture(scope="module")
def delta() -> Any:
    return psp3.load("delta")


@given(st.floats(-20.0, -8.0), st.integers(0, 2**32 - 1))
def test_steps_as_small_as_rounding_are_taken(delta: Any, exponent: float, seed: int) -> None:
    """An integrator that starts at rest asks for poses 1e-17 from the reference.

    A correction larger than the step is rounding there.
    """
    step = 10.0**exponent * np.random.default_rng(seed).normal(size=3)
    q = delta.configuration(delta.reference + step)
    assert_array_equal(q[delta.actuated_q], delta.reference + step)


# Assembly modes


def tip_of(angles: Array) -> Array:
    """Return the upper intersection of the circles around the elbows."""
    apart = _elbows(angles)
    half = 0.5 * np.linalg.norm(apart)
    normal = np.array([-apart[1], apart[0]]) / (2.0 * half)
    tip: Array = (
        0.25 * np.array([np.cos(angles[0]), np.sin(angles[0])])
        + 0.5 * apart
        + np.sqrt(0.35**2 - half**2) * normal
    )
    return tip


@pytest.mark.slow
def test_every_pose_is_closed_in_the_assembly_mode_of_the_reference_or_refused() -> None:
    """2000 poses over the whole turn of both motors.

    Wherever the straight way from the reference stays closed, the tip is the closed form's (1e-9);
    wherever it does not, the pose is refused. No pose ends on the other branch.
    """
    robot, rng = five_bar(), np.random.default_rng(10)
    start, outcomes = robot.reference, {"closed": 0, "refused": 0}
    for goal in rng.uniform(-np.pi, 2.0 * np.pi, size=(2000, 2)):
        way = start + np.linspace(0.0, 1.0, 2000)[:, np.newaxis] * (goal - start)
        clearance = 0.35 - 0.5 * np.linalg.norm(_elbows(way), axis=1).max()
        try:
            q = robot.configuration(goal)
        except (ClosureFailed, SingularConfiguration):
            # Within a hair of the fold either is right.
            assert clearance < 1e-6
            outcomes["refused"] += 1
            continue
        assert clearance > 0.0
        shoulder, elbow = q[0], q[1]
        tip = 0.25 * np.array([np.cos(shoulder), np.sin(shoulder)]) + 0.35 * np.array(
            [np.cos(shoulder + elbow), np.sin(shoulder + elbow)]
        )
        assert_allclose(tip, tip_of(goal), rtol=0.0, atol=1e-9)
        outcomes["closed"] += 1
    assert min(outcomes.values()) > 300


def _elbows(angles: Array) -> Array:
    """Return the vectors from one elbow to the other."""
    one, two = angles[..., 0], angles[..., 1]
    return np.stack(
        [0.3 + 0.25 * (np.cos(two) - np.cos(one)), 0.25 * (np.sin(two) - np.sin(one))], axis=-1
    )


def test_a_refusal_says_how_far_the_way_leads_and_how_open_the_loops_would_be() -> None:
    """The elbows are two far links apart where the way ends.

    At the goal they are 0.8 m apart, so at least 0.1 m are missing.
    """
    robot, goal = five_bar(), np.array([np.pi, 0.0])
    with pytest.raises(ClosureFailed) as caught:
        robot.configuration(goal)
    end = robot.reference + caught.value.reached * (goal - robot.reference)
    assert_allclose(np.linalg.norm(_elbows(end)), 0.7, rtol=0.0, atol=1e-4)
    assert 0.05 < caught.value.residual < 0.8


def test_a_way_that_is_too_long_is_given_up() -> None:
    """A crank that turns for ever: ten turns are made, and of a thousand million rad some 3000."""
    given = psp3.load("jansen")
    model, loops = without_limits(given.model), given.constraint_models
    robot = ClosedLoopRobot(model, loops, given.actuated, given.q0, equations=given.equations)
    turned = robot.configuration(robot.reference + 20.0 * np.pi)
    change = pin.difference(robot.model, robot.q0, turned)
    assert_allclose(np.sin(change), 0.0, atol=1e-9)
    with pytest.raises(ClosureFailed) as failed:
        robot.configuration(robot.reference + 1e9)
    assert 0.0 < failed.value.reached * 1e9 < MOST_ATTEMPTS * LARGEST_PREDICTED_STEP


def test_a_path_keeps_the_assembly_mode_it_is_entered_in() -> None:
    """The other mode, the tip below the elbows, entered by a guess and kept over a path.

    1e-9 against the mirrored closed form.
    """
    robot = five_bar()
    mirrored = []
    for leg, shoulder in enumerate(robot.reference):
        upper, elbow = (
            tip_of(robot.reference),
            0.25 * np.array([np.cos(shoulder), np.sin(shoulder)]) + [0.3 * leg, 0.0],
        )
        along = _elbows(robot.reference) / np.linalg.norm(_elbows(robot.reference))
        link = 2.0 * along * (along @ (upper - elbow)) - (upper - elbow)
        mirrored += [shoulder, np.arctan2(link[1], link[0]) - shoulder + 0.01]
    below = robot.configuration(robot.reference, guess=np.array(mirrored))
    path = robot.reference + 0.15 * np.column_stack(
        [np.sin(np.linspace(0, 6, 200)), 1.0 - np.cos(np.linspace(0, 6, 200))]
    )
    q = robot.configurations_along(path, guess=below)
    tips = np.column_stack(
        [0.25 * f(q[:, 0]) + 0.35 * f(q[:, 0] + q[:, 1]) for f in (np.cos, np.sin)]
    )
    for angles, tip in zip(path, tips, strict=True):
        upper = tip_of(angles)
        one, apart = 0.25 * np.array([np.cos(angles[0]), np.sin(angles[0])]), _elbows(angles)
        middle = one + 0.5 * apart
        assert_allclose(tip, 2.0 * middle - upper, rtol=0.0, atol=1e-9)


def test_configurations_along_a_path_are_those_of_single_poses(robot: ClosedLoopRobot) -> None:
    """Where the straight way from the reference does not fold; 1e-11."""
    rng = np.random.default_rng(11)
    path = robot.reference + np.cumsum(
        rng.uniform(-0.02, 0.02, size=(20, len(robot.actuated))), axis=0
    )
    along, single = robot.configurations_along(path), robot.configuration(path)
    for one, two in zip(along, single, strict=True):
        assert np.abs(pin.difference(robot.model, one, two)).max() < 1e-11


def test_a_fold_is_reported_as_what_it_is() -> None:
    """With both far links in line the motors do not hold the tip."""
    robot = five_bar()
    angle = np.arccos((0.35 - 0.15) / 0.25)
    stretched = np.array([np.pi - angle, angle])
    with pytest.raises((SingularConfiguration, ClosureFailed)):
        robot.closure(stretched)


def test_a_guess_may_be_read_only() -> None:
    robot = five_bar()
    guess = robot.q0.copy()
    guess.flags.writeable = False
    assert_allclose(
        robot.configuration(robot.reference, guess=guess), robot.q0, rtol=0.0, atol=1e-12
    )
