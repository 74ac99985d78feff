"""Closing loops.

The compiled residual, Jacobian, complement and drift against Pinocchio and differences, and what is
refused.
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest
from numpy.testing import assert_allclose

from psp3.closure import NO_MOTORS, flattened
from psp3.errors import ClosureFailed, SingularConfiguration, UnsupportedJoint
from psp3.robots.closed_loop_robot import ClosedLoopRobot
from tests.helpers import Array
from tests.psp3.closure.linkages import five_bar

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


# Groups


def test_loops_that_share_no_joint_are_groups_of_their_own_even_on_one_motor() -> None:
    """Two rockers driven by one crank: the same configurations as each alone, 1e-12."""
    alone, both = _rockers(1), _rockers(2)
    assert [len(robot._table.group_elements) - 1 for robot in (alone, both)] == [1, 2]
    angles = np.linspace(0.0, 5.0, 30)[:, np.newaxis] + alone.reference
    for rocker in (0, 1):
        assert_allclose(
            both.configuration(angles)[:, [0, 1 + rocker, 3 + rocker]],
            alone.configuration(angles),
            rtol=0.0,
            atol=1e-12,
        )


def _rockers(count: int) -> ClosedLoopRobot:
    model, loops = pin.Model(), pin.StdVec_RigidConstraintModel()
    body = pin.Inertia(1.0, np.array([0.1, 0.0, 0.0]), 0.01 * np.eye(3))

    def hinge(parent: int, x: float, z: float, name: str) -> int:
        joint: int = model.addJoint(
            parent, pin.JointModelRZ(), pin.SE3(np.eye(3), np.array([x, 0.0, z])), name
        )
        model.appendBodyToJoint(joint, body, pin.SE3.Identity())
        return joint

    crank = hinge(0, 0.0, 0.0, "crank")
    couplers = [hinge(crank, 0.2, 0.1 * k, f"coupler{k}") for k in range(count)]
    rockers = [hinge(0, 0.45, 0.1 * k, f"rocker{k}") for k in range(count)]
    for coupler, rocker in zip(couplers, rockers, strict=True):
        ends = [pin.SE3(np.eye(3), np.array([x, 0.0, 0.0])) for x in (0.5, 0.4)]
        loops.append(
            pin.RigidConstraintModel(
                pin.ContactType.CONTACT_3D,
                model,
                coupler,
                ends[0],
                rocker,
                ends[1],
                pin.ReferenceFrame.LOCAL,
            )
        )
    return ClosedLoopRobot(
        model, loops, ("crank",), np.array([1.0] + count * [-0.55] + count * [1.3])
    )


def test_a_single_joint_is_a_robot_too() -> None:
    """A pendulum: Pinocchio returns its Jacobian as a vector. G = m g r sin φ, M = m r²."""
    model = pin.Model()
    joint = model.addJoint(0, pin.JointModelRY(), pin.SE3.Identity(), "pivot")
    model.appendBodyToJoint(
        joint, pin.Inertia(2.0, np.array([0.0, 0.0, -0.5]), np.zeros((3, 3))), pin.SE3.Identity()
    )
    model.addFrame(
        pin.Frame(
            "bob", joint, 0, pin.SE3(np.eye(3), np.array([0.0, 0.0, -0.5])), pin.FrameType.OP_FRAME
        )
    )
    robot = ClosedLoopRobot(model, [], ["pivot"])
    angle = np.array([[0.3], [-1.0]])
    assert_allclose(robot.gravity(angle), 2.0 * 9.81 * 0.5 * np.sin(angle), rtol=1e-12)
    assert_allclose(robot.mass_matrix(angle), np.full((2, 1, 1), 0.5), rtol=1e-12)
    assert_allclose(
        robot.frame_jacobian(angle, "bob")[:, 0, 0], -0.5 * np.cos(angle[:, 0]), rtol=1e-12
    )


def test_a_guess_may_be_read_only() -> None:
    robot = five_bar()
    guess = robot.q0.copy()
    guess.flags.writeable = False
    assert_allclose(
        robot.configuration(robot.reference, guess=guess), robot.q0, rtol=0.0, atol=1e-12
    )


# What is refused


@pytest.mark.parametrize("kind", [pin.JointModelPlanar])
def test_joints_that_are_not_understood_are_named(kind: type) -> None:
    model = pin.Model()
    model.addJoint(0, kind(), pin.SE3.Identity(), "glide")
    with pytest.raises(UnsupportedJoint, match="glide") as caught:
        flattened(model, [], NO_MOTORS)
    assert caught.value.kind == "JointModelPlanar"


def test_a_fold_is_reported_as_what_it_is() -> None:
    """With both far links in line the motors do not hold the tip."""
    robot = five_bar()
    angle = np.arccos((0.35 - 0.15) / 0.25)
    stretched = np.array([np.pi - angle, angle])
    with pytest.raises((SingularConfiguration, ClosureFailed)):
        robot.closure(stretched)
