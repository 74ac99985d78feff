"""Forces in loops and joints: what a passive joint must not feel, and what a body weighs."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

import psp3
from psp3.robots.loop_forces import forces_of_motion
from tests.cross.test_mujoco_structures import ROBOTS, loaded, random_states


@pytest.mark.parametrize("name", ["five-bar, three motors", "doubled hinge, kept"])
def test_forces_of_loops_leave_passive_joints_alone(name: str, tmp_path: Path) -> None:
    """A joint's reaction along its own axis is its motor's force, and nothing at others.

    The reactions come from Pinocchio's RNEA of the open tree with the loops' forces outside.
    """
    robot = loaded(tmp_path, *ROBOTS[name][:2])
    rng = np.random.default_rng(4)
    n = len(robot.coordinates_v)
    for positions, speeds in zip(*random_states(robot, rng, 5), strict=True):
        forces = rng.uniform(-1.0, 1.0, n)
        found = robot.closure_forces(positions, speeds, forces)
        assert [one.name for one in found.joints] == list(robot.model.names)[1:]
        assert len(found.loops) == 1
        assert np.abs(found.loops[0].force).max() > 1e-3
        for one in found.joints:
            expected = 0.0
            if one.name in robot.coordinates:
                expected = forces[robot.coordinates.index(one.name)]
            # All hinges are about z.
            assert one.torque[2] == pytest.approx(expected, abs=1e-9)


def test_what_holds_a_plate_on_three_sides_is_its_weight() -> None:
    """A plate that slides up, held by a loop to the world: all of its weight is in the loop.

    And nothing in the slide; a weight of 2 kg.
    """
    model = pin.Model()
    plate = model.addJoint(0, pin.JointModelPZ(), pin.SE3.Identity(), "lift")
    model.appendBodyToJoint(
        plate, pin.Inertia(2.0, np.zeros(3), 0.1 * np.eye(3)), pin.SE3.Identity()
    )
    loop = pin.RigidConstraintModel(
        pin.ContactType.CONTACT_3D,
        model,
        0,
        pin.SE3.Identity(),
        plate,
        pin.SE3.Identity(),
        pin.ReferenceFrame.LOCAL,
    )
    rest = np.zeros(1)
    loops, joints = forces_of_motion(model, [loop], (), (rest, rest, rest), rest)
    assert np.allclose(loops[0].force, [0.0, 0.0, 2.0 * 9.81], rtol=1e-12)
    assert joints[0].force[2] == pytest.approx(0.0, abs=1e-12)


def test_a_frame_transmits_what_a_joint_in_its_place_does() -> None:
    """A pendulum cut in the middle and closed again by a frame: force and torque of a weld."""
    model = pin.Model()
    body = pin.Inertia(1.0, np.array([0.1, 0.0, 0.2]), 0.01 * np.eye(3))
    upper = model.addJoint(0, pin.JointModelRY(), pin.SE3.Identity(), "turn")
    model.appendBodyToJoint(upper, body, pin.SE3.Identity())
    place = pin.SE3(pin.rpy.rpyToMatrix(0.3, 0.1, 0.2), np.array([0.1, 0.2, -0.4]))
    whole = model.copy()
    welded = whole.addJoint(upper, pin.JointModelRX(), place, "weld")
    whole.appendBodyToJoint(welded, body, pin.SE3.Identity())
    lower = model.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "lower")
    model.appendBodyToJoint(lower, body, pin.SE3.Identity())
    loop = pin.RigidConstraintModel(
        pin.ContactType.CONTACT_6D,
        model,
        upper,
        place,
        lower,
        pin.SE3.Identity(),
        pin.ReferenceFrame.LOCAL,
    )
    q0 = np.concatenate(
        [[0.3], pin.SE3ToXYZQUAT(pin.SE3(pin.exp3(np.array([0, 0.3, 0])), np.zeros(3)) * place)]
    )
    robot = psp3.ClosedLoopRobot(model, [loop], ("turn",), q0)
    found = robot.closure_forces([0.3], [0.7], [0.4]).loops[0]
    acceleration = robot.forward_dynamics([0.3], [0.7], [0.4])[0]
    data = whole.createData()
    pin.rnea(whole, data, np.array([0.3, 0.0]), np.array([0.7, 0.0]), np.array([acceleration, 0.0]))
    assert np.allclose(found.force, data.f[welded].linear, rtol=0.0, atol=1e-10)
    assert np.allclose(found.torque, data.f[welded].angular, rtol=0.0, atol=1e-10)
