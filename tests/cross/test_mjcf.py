"""The exported robot is the same robot: read back by Pinocchio, and computed by MuJoCo."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import psp3
from psp3.description.mjcf import read_mjcf
from psp3.description.parts import THESIS_ROBOTS
from psp3.errors import UnexportableJoint
from psp3.robots.mjcf_export import mujoco_state, to_mjcf
from tests.helpers import (
    ROBOTS_WITH_LOOPS,
    Array,
    free_body_carried_by_an_arm,
    relative_error,
    spatial_loop_closed_with_3d,
)

mujoco = pytest.importorskip("mujoco", reason="MuJoCo is in the extras mujoco and test")


def made(make: Callable[[], SimpleNamespace]) -> psp3.ClosedLoopRobot:
    parts = make()
    return psp3.ClosedLoopRobot(parts.model, parts.constraint_models, parts.actuated, parts.q0)


def universal_joint_with_a_cross_without_mass() -> SimpleNamespace:
    parts = spatial_loop_closed_with_3d()
    parts.model.inertias[3] = pin.Inertia.Zero()
    return parts


MADE = (*ROBOTS_WITH_LOOPS, free_body_carried_by_an_arm, universal_joint_with_a_cross_without_mass)
LOOPED = {name: psp3.load(name) for name in THESIS_ROBOTS} | {
    make.__name__: made(make) for make in MADE
}


@pytest.fixture(params=LOOPED)
def robot(request: pytest.FixtureRequest) -> psp3.ClosedLoopRobot:
    return LOOPED[request.param]


def states(robot: psp3.ClosedLoopRobot, count: int) -> tuple[Array, Array]:
    """Return positions near the reference and speeds of the order of 1, (count, n)."""
    rng = np.random.default_rng(0)
    n = len(robot.actuated)
    return robot.reference + rng.uniform(-0.04, 0.04, (count, n)), rng.normal(size=(count, n))


def assert_same_robot(found: psp3.ClosedLoopRobot, expected: psp3.ClosedLoopRobot) -> None:
    """M, C and G of 10 states to 1e-10 of the largest entry.

    Of products of a dozen rotations from 16 digits, some 1e-13 is lost.

    A robot that moves level feels no weight, so G is compared with that of its weight on an arm of
    1 m.
    """
    positions, speeds = states(expected, 10)
    ours = psp3.ClosedLoopRobot.equation_of_motion(expected, positions, speeds)
    theirs = found.equation_of_motion(positions, speeds)
    assert relative_error(theirs[0], ours[0]) < 1e-10
    assert relative_error(theirs[1], ours[1]) < 1e-10
    weight = 9.81 * pin.computeTotalMass(expected.model)
    assert_allclose(theirs[2], ours[2], rtol=0.0, atol=1e-10 * weight)


# Read back by Pinocchio


def test_reading_back_gives_the_same_robot(robot: psp3.ClosedLoopRobot, tmp_path: Path) -> None:
    path = tmp_path / "robot.xml"
    path.write_text(to_mjcf(robot), encoding="utf-8")
    parts = read_mjcf(path)
    assert parts.actuated == robot.actuated
    if robot.model.nq == robot.model.nv:
        assert list(parts.model.names) == list(robot.model.names)
        assert_array_equal(parts.q0, robot.q0)
    again = psp3.ClosedLoopRobot(*parts)
    assert_same_robot(again, robot)
    for mine, theirs in zip(again.limits, robot.limits, strict=True):
        assert_array_equal(mine, np.where(np.abs(theirs) < 1e10, theirs, mine))
    assert parts.visual_model.ngeoms == robot.visual_model.ngeoms


@pytest.mark.parametrize("name", THESIS_ROBOTS)
def test_plain_pinocchio_reads_it_too(name: str, tmp_path: Path) -> None:
    """Its own parser, with the joints in the same order.

    It does not read gravity, which is what it takes for granted here.
    """
    robot = psp3.load(name)
    path = tmp_path / "robot.xml"
    path.write_text(to_mjcf(robot), encoding="utf-8")
    model, closures = pin.buildModelAndLegacyConstraintsFromMJCF(str(path))
    assert list(model.names) == list(robot.model.names)
    again = psp3.ClosedLoopRobot(
        model, closures, robot.actuated, model.referenceConfigurations["home"]
    )
    assert_same_robot(again, robot)
    assert pin.buildGeomFromMJCF(model, str(path), pin.GeometryType.COLLISION).ngeoms == 0


def test_gravity_and_parameters_come_back(tmp_path: Path) -> None:
    """Table 5.1 has a gravity of its own, and an inertia whose axes are not those of the star."""
    robot = psp3.load("psp3", parameters="table_5_1")
    path = tmp_path / "robot.xml"
    path.write_text(to_mjcf(robot), encoding="utf-8")
    again = psp3.ClosedLoopRobot(*read_mjcf(path))
    assert again.model.gravity.linear[2] == -9.806
    assert_same_robot(again, robot)


# Computed by MuJoCo


def engine_of(robot: Any) -> tuple[Any, Any]:
    model = mujoco.MjModel.from_xml_string(to_mjcf(robot))
    model.opt.enableflags |= mujoco.mjtEnableBit.mjENBL_ENERGY
    return model, mujoco.MjData(model)


def test_mujoco_finds_the_loops_closed_and_the_same_energies(robot: psp3.ClosedLoopRobot) -> None:
    """In 10 states; rounding of a dozen rotations is 1e-12 m and 1e-12 of the energies.

    Of the potential one it is 1e-12 of the weight at 1 m.
    """
    model, data = engine_of(robot)
    positions, speeds = states(robot, 10)
    weight = 9.81 * pin.computeTotalMass(robot.model)
    for position, speed in zip(positions, speeds, strict=True):
        data.qpos[:], data.qvel[:] = mujoco_state(
            robot, robot.configuration(position), robot.velocity(position, speed)
        )
        mujoco.mj_forward(model, data)
        assert_allclose(data.efc_pos[: data.ne], 0.0, rtol=0.0, atol=1e-12)
        assert_allclose(data.efc_vel[: data.ne], 0.0, rtol=0.0, atol=1e-11)
        assert_allclose(data.energy[1], robot.kinetic_energy(position, speed), rtol=1e-12)
        assert_allclose(
            data.energy[0], robot.potential_energy(position), rtol=0.0, atol=1e-12 * weight
        )


def test_mujoco_starts_at_home_and_knows_the_frames(robot: psp3.ClosedLoopRobot) -> None:
    """Every site is where Pinocchio has the frame, to 1e-14 of coordinates of some meters.

    Rotations of a dozen joints.
    """
    model, data = engine_of(robot)
    mujoco.mj_resetDataKeyframe(
        model, data, mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_KEY, "home")
    )
    mujoco.mj_kinematics(model, data)
    ours = robot.model.createData()
    pin.framesForwardKinematics(robot.model, ours, robot.q0)
    for index in range(model.nsite):
        name = mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_SITE, index)
        if not robot.model.existFrame(name):
            continue
        frame = ours.oMf[robot.model.getFrameId(name)]
        assert_allclose(data.site_xpos[index], frame.translation, rtol=0.0, atol=1e-14)
        assert_allclose(data.site_xmat[index].reshape(3, 3), frame.rotation, rtol=0.0, atol=2e-14)


# Every joint that the export knows


def tree_of_every_joint() -> Any:
    """Return a tree of every joint, as the export sees a robot.

    Two of its bodies have no mass.
    """
    composite = pin.JointModelComposite()
    composite.addJoint(pin.JointModelRX(), pin.SE3.Identity())
    oblique = pin.JointModelPrismaticUnaligned(np.array([0.6, 0.0, 0.8]))
    composite.addJoint(oblique, pin.SE3(pin.utils.rotate("y", 0.4), np.array([0.1, 0.0, 0.2])))
    composite.addJoint(
        pin.JointModelRZ(), pin.SE3(pin.utils.rotate("x", -0.3), np.array([0.0, 0.2, 0.1]))
    )
    universal = pin.JointModelUniversal(np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0]))
    skewed = pin.JointModelRevoluteUnaligned(np.array([0.0, 0.6, 0.8]))
    endless = pin.JointModelRevoluteUnboundedUnaligned()
    endless.axis = np.array([0.6, 0.8, 0.0])
    # Parent, joint, whether the body has mass.
    joints = [
        (0, pin.JointModelFreeFlyer(), True),
        (1, skewed, True),
        (2, pin.JointModelSpherical(), True),
        (1, universal, True),
        (4, pin.JointModelSphericalZYX(), True),
        (0, pin.JointModelTranslation(), True),
        (6, pin.JointModelRUBY(), True),
        (7, composite, True),
        (8, pin.JointModelPY(), True),
        (0, pin.JointModelRX(), False),
        (10, pin.JointModelSpherical(), False),
        (11, pin.JointModelPZ(), True),
        (12, pin.JointModelFreeFlyer(), True),
        (13, endless, True),
    ]
    rng, model = np.random.default_rng(3), pin.Model()
    model.gravity = pin.Motion(np.array([1.0, -2.0, -9.0]), np.zeros(3))
    for number, (parent, joint, massive) in enumerate(joints, start=1):
        place = pin.SE3(pin.Quaternion(rng.normal(size=4)).normalized(), rng.uniform(-0.5, 0.5, 3))
        index = model.addJoint(parent, joint, place, f"j{number}")
        model.addFrame(pin.Frame(f"f{number}", index, 0, place.inverse(), pin.FrameType.OP_FRAME))
        if massive:
            axes, _ = np.linalg.qr(rng.normal(size=(3, 3)))
            inertia = pin.Inertia(
                rng.uniform(0.5, 2.0),
                rng.uniform(-0.3, 0.3, 3),
                axes @ np.diag([0.02, 0.03, 0.04]) @ axes.T,
            )
            model.appendBodyToJoint(index, inertia, pin.SE3.Identity())
    model.lowerPositionLimit, model.upperPositionLimit = (
        np.full(model.nq, -np.inf),
        np.full(model.nq, np.inf),
    )
    return SimpleNamespace(
        model=model,
        constraint_models=[],
        actuated=(),
        equations=(),
        locked=(),
        options={"springs": None, "tendons": None},
        q0=pin.neutral(model),
        visual_model=pin.GeometryModel(),
    )


def test_every_joint_moves_alike() -> None:
    """Random states: placements and velocities of all frames, and both energies.

    These do not depend on coordinates, and coordinates differ (quaternions, axes of velocities,
    several joints on one body). 1e-13 of sums of a dozen terms of the order of 1 to 10.
    """
    robot = tree_of_every_joint()
    model = robot.model
    engine, data = engine_of(robot)
    assert engine.nv == model.nv
    assert engine.nbody == 2 + sum(inertia.mass > 0.0 for inertia in model.inertias)
    ours, rng = model.createData(), np.random.default_rng(1)
    for _ in range(20):
        q = pin.integrate(model, pin.neutral(model), rng.normal(size=model.nv))
        v = rng.normal(size=model.nv)
        data.qpos[:], data.qvel[:] = mujoco_state(robot, q, v)
        mujoco.mj_forward(engine, data)
        pin.forwardKinematics(model, ours, q, v)
        pin.updateFramePlacements(model, ours)
        compared = 0
        for frame in range(model.nframes):
            site = mujoco.mj_name2id(engine, mujoco.mjtObj.mjOBJ_SITE, model.frames[frame].name)
            if site < 0:
                continue
            compared += 1
            assert_allclose(data.site_xpos[site], ours.oMf[frame].translation, rtol=0.0, atol=1e-13)
            assert_allclose(
                data.site_xmat[site].reshape(3, 3), ours.oMf[frame].rotation, rtol=0.0, atol=1e-13
            )
            velocity = np.empty(6)
            mujoco.mj_objectVelocity(engine, data, mujoco.mjtObj.mjOBJ_SITE, site, velocity, 0)
            expected = pin.getFrameVelocity(
                model, ours, frame, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
            )
            assert_allclose(velocity, [*expected.angular, *expected.linear], rtol=0.0, atol=1e-12)
        assert compared == 12
        potential, kinetic = data.energy
        assert_allclose(kinetic, pin.computeKineticEnergy(model, ours, q, v), rtol=1e-12)
        assert_allclose(
            potential, pin.computePotentialEnergy(model, ours, q), rtol=1e-12, atol=1e-12
        )


# How rigid MuJoCo's closures are


def acceleration_error(robot: psp3.ClosedLoopRobot, change: Callable[[Any], None]) -> float:
    """Largest error of MuJoCo's actuated accelerations in 20 states.

    Relative to the largest of ours; motors are not limited.
    """
    model, data = engine_of(robot)
    dofs = [
        model.jnt_dofadr[mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, name)]
        for name in robot.actuated
    ]
    model.actuator_ctrllimited[:] = model.jnt_actfrclimited[:] = 0
    change(model)
    positions, speeds = states(robot, 20)
    wanted = np.random.default_rng(2).normal(size=positions.shape)
    forces = robot.gravity(positions) + np.einsum(
        "nij,nj->ni", robot.mass_matrix(positions), wanted
    )
    ours, theirs = robot.forward_dynamics(positions, speeds, forces), []
    for position, speed, force in zip(positions, speeds, forces, strict=True):
        mujoco.mj_resetData(model, data)
        data.qpos[:], data.qvel[:] = mujoco_state(
            robot, robot.configuration(position), robot.velocity(position, speed)
        )
        data.ctrl[:] = force
        mujoco.mj_forward(model, data)
        theirs.append(data.qacc[dofs])
    return float(np.abs(ours - np.array(theirs)).max() / np.abs(ours).max())


def soft(model: Any) -> None:
    """MuJoCo's defaults."""
    model.eq_solref[:], model.eq_solimp[:] = (0.02, 1.0), (0.9, 0.95, 0.001, 0.5, 2.0)


def rigid(model: Any) -> None:
    """Divide by 10 000 what softness is proportional to; no document can say that."""
    model.body_invweight0 *= 1e-4


def test_default_closures_are_soft_and_exported_ones_are_not(robot: psp3.ClosedLoopRobot) -> None:
    """Softness is (1 − d)/d of the impedance d.

    0.11 by default, 1e-4 as exported, which is MuJoCo's limit.

    It multiplies a weight that MuJoCo estimates body by body, so errors relative to the
    acceleration differ from robot to robot: 0.03 to 2.3 by default, 3e-5 to 4e-3 as exported. With
    a ten-thousandth of that weight they are below 4e-7, which is the tolerance of MuJoCo's solver:
    softness is all that keeps the engines apart.
    """
    default, exported, stiffest = (
        acceleration_error(robot, change) for change in (soft, lambda model: None, rigid)
    )
    assert default > 0.02
    assert exported < 5e-3
    assert exported < 3e-3 * default
    assert stiffest < 1e-6


def test_forces_of_the_joints_come_back(tmp_path: Path) -> None:
    """Armature, damping, dry friction and springs of every joint of a five-bar, to 1e-12."""
    robot = psp3.load("five_bar")
    model, rng = robot.model.copy(), np.random.default_rng(8)
    model.armature[:] = rng.uniform(0.01, 0.1, model.nv)
    model.damping[:] = rng.uniform(0.1, 1.0, model.nv)
    model.upperDryFrictionLimit[:] = rng.uniform(0.1, 1.0, model.nv)
    springs = {"leg1_elbow": (3.0, 0.2), "leg2_shoulder": (2.0, -0.1)}
    given = psp3.ClosedLoopRobot(
        model, robot.constraint_models, robot.actuated, robot.q0, springs=springs
    )
    path = tmp_path / "robot.xml"
    path.write_text(to_mjcf(given), encoding="utf-8")
    again = psp3.ClosedLoopRobot.from_mjcf(path)
    positions, speeds = robot.reference + 0.1, np.array([0.5, -0.7])
    for ours, theirs in zip(
        again.equation_of_motion(positions, speeds),
        given.equation_of_motion(positions, speeds),
        strict=True,
    ):
        assert_allclose(ours, theirs, rtol=0, atol=1e-12)


def test_robots_that_cannot_be_written_whole_are_refused() -> None:
    """Such as one with a planar joint."""
    model = pin.Model()
    table = model.addJoint(0, pin.JointModelPlanar(), pin.SE3.Identity(), "table")
    arm = model.addJoint(table, pin.JointModelRX(), pin.SE3.Identity(), "arm")
    for joint in (table, arm):
        model.appendBodyToJoint(joint, pin.Inertia(1.0, np.zeros(3), np.eye(3)), pin.SE3.Identity())
    with pytest.raises(UnexportableJoint, match="planar"):
        to_mjcf(psp3.ClosedLoopRobot(model, [], ("arm",)))
