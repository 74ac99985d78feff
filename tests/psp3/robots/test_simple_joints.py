"""Hinges in place of balls, slides and hinges in place of bases: the same motions as MuJoCo's.

MuJoCo keeps the ball and the floating base; states and accelerations go from one description to the
other through Pinocchio's kinematics.
"""

from __future__ import annotations

import logging
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

import psp3
from psp3.closure.coordinates import bases, floating_base
from psp3.errors import InvalidRobotFile, UnsupportedJoint
from psp3.robots.simple_joints import base_in_loop, parts_of_base
from psp3.simulation.runge_kutta import RungeKutta
from tests.helpers import Array, derivative
from tests.mujoco_null_space import NullSpace, biped, rod

LEGS = ("l_hip", "l_motor", "r_hip", "r_motor")
DAMPED_BALL = '<joint type="ball" name="ball" damping=".1"/>'


def loaded(path: Path, text: str, **options: object) -> psp3.ClosedLoopRobot:
    file = path / "robot.xml"
    file.write_text(text, encoding="utf-8")
    return psp3.ClosedLoopRobot.from_mjcf(file, **options)


def as_given(
    robot: psp3.ClosedLoopRobot, given: pin.Model, q: Array, v: Array, a: Array
) -> tuple[Array, Array, Array]:
    """Return a motion of the robot's model as one of the model that was given."""
    model, data = robot.model, robot.model.createData()
    pin.forwardKinematics(model, data, q, v, a)
    motion = np.zeros(given.nq), np.zeros(given.nv), np.zeros(given.nv)
    for index in range(1, given.njoints):
        name, joint = given.names[index], given.joints[index]
        at, own = (
            slice(joint.idx_q, joint.idx_q + joint.nq),
            slice(joint.idx_v, joint.idx_v + joint.nv),
        )
        if model.existJointName(name):
            same = model.joints[model.getJointId(name)]
            for out, place, values, first in zip(
                motion, (at, own, own), (q, v, a), (same.idx_q, same.idx_v, same.idx_v), strict=True
            ):
                out[place] = values[first : first + place.stop - place.start]
            continue
        parts = [k for k in range(model.njoints) if str(model.names[k]).startswith(f"{name}_")]
        last, parent = parts[-1], model.parents[parts[0]]
        way = data.oMi[parent].actInv(data.oMi[last])
        turn = way.inverse()
        carried = turn.act(data.v[parent])
        relative = data.v[last] - carried
        rate = data.a[last] - turn.act(data.a[parent]) + relative.cross(carried)
        numbers = pin.SE3ToXYZQUAT(given.jointPlacements[index].actInv(way))
        three = slice(3, None) if joint.nq == 4 else slice(None)
        motion[0][at] = numbers[three]
        motion[1][own], motion[2][own] = relative.vector[three], rate.vector[three]
    return motion


def largest_difference(
    robot: psp3.ClosedLoopRobot,
    given: psp3.ClosedLoopRobot,
    text: str,
    states: int,
    foot_speeds: int = 0,
) -> float:
    """Return the largest relative difference of accelerations from MuJoCo's projected ones.

    So many speeds of the left foot are held: the first three are of its origin.
    """
    engine, rng, worst = NullSpace(text, given.model), np.random.default_rng(0), 0.0
    n, data = len(robot.coordinates_v), given.model.createData()

    def held(q: Array) -> Array:
        if foot_speeds == 0:
            return np.zeros((0, given.model.nv))
        axes = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        index = given.model.getFrameId("l_shank")
        rows = pin.computeFrameJacobian(given.model, data, q, index, axes)
        return np.array(rows[:foot_speeds])

    for _ in range(states):
        positions = robot.reference + rng.uniform(-0.1, 0.1, n)
        speeds, forces = rng.uniform(-1.0, 1.0, n), rng.uniform(-1.0, 1.0, len(robot.actuated))
        along = robot.actuation_matrix(positions) @ forces
        found = robot.forward_dynamics(positions, speeds, along)
        q, v = robot.configuration(positions), robot.velocity(positions, speeds)
        a = robot.drift(q, v) + robot.velocity(positions, found)
        at, moving, ours = as_given(robot, given.model, q, v, a)
        rates = derivative(
            lambda t, at=at, moving=moving: (
                held(pin.integrate(given.model, at, t * moving)) @ moving
            ),
            1e-2,
        )
        expected, gap, opening = engine.accelerations(
            at, moving, given.motors @ forces, held(at), rates
        )
        assert gap < 1e-10
        assert opening < 1e-10
        worst = max(worst, float(np.abs(ours - expected).max() / np.abs(expected).max()))
    return worst


@pytest.mark.parametrize("moments", [".01 .012 .014", ".002 .02 .02"])
def test_a_rod_between_balls_spins_freely(moments: str, tmp_path: Path) -> None:
    """500 states to 1e-8; where the rod is after two turns is where it was, in all but its spin."""
    text = rod(moments)
    robot, given = loaded(tmp_path, text, free="keep"), loaded(tmp_path, text)
    assert robot.coordinates == ("crank", "ball_spin")
    assert not robot.locked
    assert robot.commanded == 1
    assert largest_difference(robot, given, text, 500) < 1e-8
    # The reference is that of the file.
    still = np.zeros(robot.model.nv)
    at, _, _ = as_given(robot, given.model, robot.q0, still, still)
    np.testing.assert_allclose(at, given.q0, rtol=0.0, atol=1e-12)
    # A turn of the spin moves neither the crank nor the rocker.
    positions = robot.reference + np.array([0.1, 0.0])
    turned = positions + np.array([0.0, 4.0 * np.pi])
    before, after = robot.configuration(positions), robot.configuration(turned)
    spin = robot.model.joints[robot.model.getJointId("ball_spin")].idx_q
    others = np.delete(np.arange(robot.model.nq), spin)
    np.testing.assert_allclose(after[others], before[others], rtol=0.0, atol=1e-10)


def test_a_spinning_rod_keeps_its_energy_and_its_spin(tmp_path: Path) -> None:
    """A rod that is round about its line, without weight: the spin and the crank do not meet.

    So its spin is uniform as seen along the rod, and the energy is kept, to 1e-9 over 0.5 s.
    """
    text = rod().replace('gravity="0 -3 -9"', 'gravity="0 0 0"')
    robot = loaded(tmp_path, text, free="keep")
    plant = RungeKutta(robot)
    plant.start(robot.reference, np.array([0.5, 6.0]))
    energies = []
    for _ in range(250):
        state = plant.advance(np.zeros(1), 0.002)
        assert state is not None
        energies.append(float(robot.kinetic_energy(*state)))
    assert np.ptp(energies) < 1e-8 * energies[0]


def test_a_ball_with_damping_stays_held(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    """Damping of each hinge would be another than that of the ball."""
    text = rod().replace('type="ball" name="ball"', 'type="ball" name="ball" damping=".1"')
    robot = loaded(tmp_path, text, free="keep")
    assert robot.coordinates == ("crank",)
    assert [one.joint for one in robot.locked] == ["ball"]
    with caplog.at_level(logging.WARNING):
        assert "the spin of ball" in str(robot.locked[0])


def test_a_name_that_is_taken_is_told(tmp_path: Path) -> None:
    text = rod().replace('name="rocker" axis', 'name="ball_spin" axis')
    with pytest.raises(InvalidRobotFile, match="ball_spin"):
        loaded(tmp_path, text, free="keep")


def test_a_robot_on_a_fixed_foot_has_its_motors_for_coordinates(tmp_path: Path) -> None:
    """Its base follows; 200 states against MuJoCo with the foot's six speeds held, to 1e-8."""
    text = biped(*LEGS)
    robot = loaded(tmp_path, text, closures=[("l_shank", "world", "6d")])
    assert robot.coordinates == LEGS
    assert not robot.locked
    assert largest_difference(robot, loaded(tmp_path, text), text, 200, 6) < 1e-8
    # On both feet it has more motors than freedoms, and one that is least of all stands still.
    both = [("l_shank", "world", "6d"), ("r_shank", "world", "6d")]
    stands = loaded(tmp_path, text, closures=both)
    assert stands.coordinates == LEGS[:2]
    rest = np.zeros(2)
    forces = stands.actuator_forces(stands.reference, rest, rest)
    assert forces.shape == (4,)
    plant = RungeKutta(stands)
    plant.start(stands.reference, rest)
    state = plant.advance(forces, 0.05)
    assert state is not None
    np.testing.assert_allclose(state[0], stands.reference, rtol=0.0, atol=1e-10)


def test_a_robot_on_the_point_of_a_foot_can_turn_about_it(tmp_path: Path) -> None:
    """Its base keeps three motions, whatever becomes of free ones; 200 states to 1e-8.

    On a hinge it is one motion.
    """
    text = biped(*LEGS)
    for kind, angles in (
        ("3d", ("root_yaw", "root_pitch", "root_roll")),
        ("hinge", ("root_yaw",)),
    ):
        robot = loaded(tmp_path, text, closures=[("l_shank", "world", kind)])
        assert robot.coordinates == (*LEGS, *angles)
        assert not robot.locked
        assert robot.commanded == 4
    given = loaded(tmp_path, text)
    robot = loaded(tmp_path, text, closures=[("l_shank", "world", "3d")])
    assert largest_difference(robot, given, text, 200, 3) < 1e-8


def test_which_bases_loops_contain() -> None:
    model = pin.Model()
    model.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "root")
    model.addJoint(1, pin.JointModelRX(), pin.SE3.Identity(), "leg")
    model.addJoint(0, pin.JointModelPlanar(), pin.SE3.Identity(), "cart")
    assert [joint.id for joint in bases(model)] == [1, 3]
    local, unit = pin.ReferenceFrame.LOCAL, pin.SE3.Identity()
    foot = pin.RigidConstraintModel(pin.ContactType.CONTACT_3D, model, 2, unit, 0, unit, local)
    assert base_in_loop(model, []) == 3
    assert floating_base(model, [foot]).id == 3
    assert base_in_loop(model, [foot]) == 1
    assert parts_of_base(model, 1)[:3] == ["root_yaw", "root_pitch", "root_roll"]
    assert parts_of_base(model, 3) == ["cart_yaw", "cart_x", "cart_y"]


def test_only_held_motions_that_something_feels_are_told(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """Round rods may turn or not; a ball with damping would need hinges that have it, too."""
    caplog.set_level(logging.WARNING)
    robot = psp3.load("hexa")
    assert len(robot.locked) == 6
    assert not caplog.records
    psp3.load("hexa", free="lock")
    assert 'free="keep" makes them coordinates' in caplog.text
    caplog.clear()
    damped = rod().replace('<joint type="ball" name="ball"/>', DAMPED_BALL)
    assert loaded(tmp_path, damped, free="keep").locked
    assert "no hinges can replace it" in caplog.text


def several(offset: float = 0.0) -> pin.Model:
    """Return an arm on joints of two and three freedoms, and an angle in two coordinates."""
    pair = pin.JointModelComposite()
    pair.addJoint(pin.JointModelRY())
    pair.addJoint(pin.JointModelPZ())
    pair.addJoint(pin.JointModelRX(), pin.SE3(np.eye(3), np.array([offset, 0.0, 0.0])))
    kinds = {
        "base": pin.JointModelRZ(),
        "universal": pin.JointModelUniversal(np.eye(3)[0], np.eye(3)[1]),
        "turning": pin.JointModelRUBY(),
        "angles": pin.JointModelSphericalZYX(),
        "slides": pin.JointModelTranslation(),
        "pair": pair,
    }
    model, parent = pin.Model(), 0
    for number, (name, joint) in enumerate(kinds.items(), start=1):
        place = pin.SE3(pin.rpy.rpyToMatrix(0.2, -0.3, 0.4), np.array([0.1, 0.3, 0.4]))
        parent = model.addJoint(parent, joint, place, name)
        inertia = pin.Inertia(1.0 + number, np.array([0.1, 0.05, -0.1]), 0.1 * np.eye(3))
        model.appendBodyToJoint(parent, inertia, pin.SE3.Identity())
    model.damping[:] = np.linspace(0.1, 0.5, model.nv)
    return model


def test_parts_of_a_joint_are_coordinates_by_their_own_names() -> None:
    """All freedoms kept: RNEA of the tree as it was given, with damping joint by joint. 1e-12."""
    model, rng = several(), np.random.default_rng(4)
    robot = psp3.ClosedLoopRobot(model, [], ("base", "turning"), free="keep")
    assert robot.coordinates == (
        *("base", "turning", "universal_1", "universal_2", "angles_1", "angles_2", "angles_3"),
        *("slides_1", "slides_2", "slides_3", "pair_1", "pair_2", "pair_3"),
    )
    order = [robot.model.joints[robot.model.getJointId(name)].idx_v for name in robot.coordinates]
    data = model.createData()
    for _ in range(5):
        q, v, a = rng.uniform(-0.7, 0.7, (3, model.nv))
        forces = robot.inverse_dynamics(q[order], v[order], a[order])
        given = np.concatenate([q[:3], [np.cos(q[3]), np.sin(q[3])], q[4:]])
        expected = pin.rnea(model, data, given, v, a) + model.damping * v
        np.testing.assert_allclose(
            forces, expected[order], rtol=0.0, atol=1e-12 * np.abs(expected).max()
        )


def test_parts_of_a_joint_are_held_by_their_own_names() -> None:
    robot = psp3.ClosedLoopRobot(several(), [], ("base",))
    names = [one.joint for one in robot.locked]
    assert len(names) == len(set(names)) == 12
    other = robot.dynamics("pinocchio")
    for ours, theirs in zip(
        robot.equation_of_motion([0.3], [0.2]),
        other.equation_of_motion([0.3], [0.2]),
        strict=True,
    ):
        np.testing.assert_allclose(ours, theirs, rtol=1e-10, atol=1e-10)


def test_a_chain_whose_joints_are_apart_is_told() -> None:
    with pytest.raises(UnsupportedJoint, match="pair"):
        psp3.ClosedLoopRobot(several(0.2), [], ("base",), free="keep")
