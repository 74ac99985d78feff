"""Which coordinates a mechanism gets, by the stated rule."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pinocchio as pin
import pytest

import psp3
from psp3.closure import coordinates
from psp3.closure.coordinates import _alone, is_ball
from psp3.closure.rank import null_space
from psp3.errors import DependentCoordinates, MobilityMismatch, NoFiniteAnswer, UnknownName
from psp3.multibody.equations import Hinge
from tests.helpers import Array, derivative
from tests.psp3.closure.rounded import EXACT, four_bar

BODY = pin.Inertia(1.0, np.array([0.1, 0.02, 0.03]), np.diag([0.01, 0.012, 0.014]))


def chain(*joints: tuple[str, object]) -> pin.Model:
    """Return a chain of joints, each half a meter from the one before, obliquely."""
    model, parent = pin.Model(), 0
    for name, joint in joints:
        place = pin.SE3(pin.rpy.rpyToMatrix(0.2, -0.3, 0.4), np.array([0.1, 0.3, 0.4]))
        parent = model.addJoint(parent, joint, place, name)
        model.appendBodyToJoint(parent, BODY, pin.SE3.Identity())
    return model


def test_a_floating_or_planar_base_is_kept_and_comes_last() -> None:
    """RNEA in the order of the coordinates: motors, free joints, base; 1e-12."""
    rng = np.random.default_rng(1)
    for base in (pin.JointModelFreeFlyer(), pin.JointModelPlanar()):
        model = chain(("root", base), ("one", pin.JointModelRX()), ("two", pin.JointModelPY()))
        robot = psp3.ClosedLoopRobot(model, [], ("two",), free="keep")
        assert robot.coordinates == ("two", "one", "root")
        assert robot.locked == ()
        data = model.createData()
        for _ in range(5):
            q = pin.randomConfiguration(model, np.full(model.nq, -1.0), np.full(model.nq, 1.0))
            v, a = rng.normal(size=(2, model.nv))
            at = robot.coordinates_v
            forces = robot.inverse_dynamics(q[robot.coordinates_q], v[at], a[at])
            expected = pin.rnea(model, data, q, v, a)
            assert np.allclose(forces, expected[at], rtol=0.0, atol=1e-12)
            back = robot.forward_dynamics(q[robot.coordinates_q], v[at], forces)
            assert np.allclose(back, a[at], rtol=0.0, atol=1e-10)
            M, C, G = robot.equation_of_motion(q[robot.coordinates_q], v[at])
            assert np.allclose(M @ a[at] + C @ v[at] + G, forces, rtol=0.0, atol=1e-12)


def test_a_planar_joint_in_a_loop_moves_as_two_slides_and_a_hinge() -> None:
    """The table of a planar 3-RRR as one joint, or as three; accelerations to 1e-10."""

    def robot(table: list[tuple[str, object]]) -> psp3.ClosedLoopRobot:
        model, loops = pin.Model(), pin.StdVec_RigidConstraintModel()
        parent = 0
        for number, (name, joint) in enumerate(table):
            parent = model.addJoint(parent, joint, pin.SE3.Identity(), name)
            if number == len(table) - 1:
                model.appendBodyToJoint(parent, BODY, pin.SE3.Identity())
        for leg, angle in enumerate(np.array([0.5, 2.6, 4.7])):
            pole = np.array([np.cos(angle), np.sin(angle), 0.0])
            across = np.array([-pole[1], pole[0], 0.0])
            crank = model.addJoint(
                0, pin.JointModelRZ(), pin.SE3(np.eye(3), 0.9 * pole), f"crank{leg}"
            )
            rod = model.addJoint(
                crank, pin.JointModelRZ(), pin.SE3(np.eye(3), 0.4 * across), f"rod{leg}"
            )
            for joint in (crank, rod):
                model.appendBodyToJoint(joint, BODY, pin.SE3.Identity())
            end = pin.SE3(np.eye(3), 0.2 * pole - (0.9 * pole + 0.4 * across))
            loops.append(
                pin.RigidConstraintModel(
                    pin.ContactType.CONTACT_3D,
                    model,
                    rod,
                    end,
                    parent,
                    pin.SE3(np.eye(3), 0.2 * pole),
                    pin.ReferenceFrame.LOCAL,
                )
            )
        return psp3.ClosedLoopRobot(
            model, loops, [f"crank{leg}" for leg in range(3)], pin.neutral(model)
        )

    whole = robot([("table", pin.JointModelPlanar())])
    parts = robot(
        [("x", pin.JointModelPX()), ("y", pin.JointModelPY()), ("turn", pin.JointModelRZ())]
    )
    assert whole.mobility.degrees_of_freedom == parts.mobility.degrees_of_freedom == 3
    rng = np.random.default_rng(2)
    for _ in range(5):
        x, s, tau = rng.uniform(-0.05, 0.05, 3), rng.normal(size=3), rng.normal(size=3)
        ours, theirs = (one.forward_dynamics(x, s, tau) for one in (whole, parts))
        assert np.abs(ours - theirs).max() < 1e-10 * np.abs(theirs).max()
        q, other = whole.configuration(x), parts.configuration(x)
        assert np.allclose(q[:2], other[:2], rtol=0.0, atol=1e-12)
        assert np.arctan2(q[3], q[2]) == pytest.approx(other[2], abs=1e-12)


def test_a_foot_on_the_ground_makes_the_base_follow_the_legs() -> None:
    """A leg of six joints under a base: with its foot on the ground, a robot arm turned over.

    The same as the chain from the foot upward: the base moves with minus the leg's inverse motion.
    """
    joints = [(f"j{k}", pin.JointModelRX() if k % 2 else pin.JointModelRY()) for k in range(6)]
    model = chain(("base", pin.JointModelFreeFlyer()), *joints)
    model.addFrame(
        pin.Frame("foot", 7, 0, pin.SE3(np.eye(3), np.array([0, 0.1, 0.2])), pin.FrameType.OP_FRAME)
    )
    q0 = pin.neutral(model)
    q0[7:] = [0.3, -0.4, 0.5, 0.6, -0.3, 0.2]
    names = [name for name, _ in joints]
    robot = psp3.ClosedLoopRobot(model, [], names, q0, closures=[("foot", "world", "6d")])
    assert robot.coordinates == tuple(names)
    assert robot.mobility.degrees_of_freedom == 6
    data, rng = model.createData(), np.random.default_rng(3)
    pin.framesForwardKinematics(model, data, q0)
    foot = data.oMf[model.getFrameId("foot")].copy()
    for _ in range(5):
        positions = q0[7:] + rng.uniform(-0.2, 0.2, 6)
        placed = robot.frame_placement(positions, "foot")
        assert np.allclose(placed, foot.homogeneous, rtol=0.0, atol=1e-12)
        # The power of the motors is what kinetic and potential energy gain.
        speeds, forces = rng.normal(size=(2, 6))
        accelerations = robot.forward_dynamics(positions, speeds, forces)

        def energy(
            t: float, x: Array = positions, s: Array = speeds, a: Array = accelerations
        ) -> Array:
            at, moving = x + t * s + 0.5 * t * t * a, s + t * a
            return robot.kinetic_energy(at, moving) + robot.potential_energy(at)

        assert derivative(energy, 1e-3) == pytest.approx(forces @ speeds, rel=1e-7, abs=1e-7)


def test_what_floats_at_the_end_of_a_tree_is_kept_and_falls_freely() -> None:
    """As a link that a URDF lets float: the arm moves as without it, and it falls as anything."""
    model = chain(("arm", pin.JointModelRY()), ("fore", pin.JointModelRX()))
    alone = psp3.ClosedLoopRobot(model.copy(), [], ("arm", "fore"))
    leaf = model.addJoint(2, pin.JointModelFreeFlyer(), pin.SE3.Random(), "leaf")
    model.appendBodyToJoint(leaf, BODY, pin.SE3.Identity())
    place = pin.SE3(np.eye(3), BODY.lever)
    center = model.addFrame(pin.Frame("center", leaf, 0, place, pin.FrameType.OP_FRAME))
    robot = psp3.ClosedLoopRobot(model, [], ("arm", "fore"))
    assert robot.coordinates == ("arm", "fore", "leaf")
    assert not robot.locked
    rng, data = np.random.default_rng(0), model.createData()
    for _ in range(5):
        q = pin.integrate(model, robot.q0, rng.uniform(-1.0, 1.0, model.nv))
        speeds, forces = rng.uniform(-1.0, 1.0, (2, 8))
        forces[2:] = 0.0
        found = robot.forward_dynamics(q[robot.coordinates_q], speeds, forces)
        expected = alone.forward_dynamics(q[:2], speeds[:2], forces[:2])
        assert found[:2] == pytest.approx(expected, rel=1e-10)
        pin.forwardKinematics(model, data, q, speeds, found)
        motion = pin.getFrameClassicalAcceleration(model, data, center, pin.LOCAL_WORLD_ALIGNED)
        assert motion.linear == pytest.approx([0.0, 0.0, -9.81], abs=1e-9)


def test_a_second_body_that_floats_has_slides_and_hinges() -> None:
    model = chain(("arm", pin.JointModelRY()))
    for name in ("one", "two"):
        leaf = model.addJoint(1, pin.JointModelFreeFlyer(), pin.SE3.Identity(), name)
        model.appendBodyToJoint(leaf, BODY, pin.SE3.Identity())
    robot = psp3.ClosedLoopRobot(model, [], ("arm",))
    parts = tuple(f"two_{part}" for part in ("yaw", "pitch", "roll", "x", "y", "z"))
    assert robot.coordinates == ("arm", *parts, "one")
    assert robot.mobility.degrees_of_freedom == 13


def test_what_floats_without_mass_has_no_accelerations() -> None:
    model = chain(("arm", pin.JointModelRY()))
    model.addJoint(1, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "frame")
    robot = psp3.ClosedLoopRobot(model, [], ("arm",))
    rest = np.zeros(7)
    assert np.isfinite(robot.inverse_dynamics(robot.reference, rest, rest)).all()
    with pytest.raises(NoFiniteAnswer, match="some mass or inertia"):
        robot.forward_dynamics(robot.reference, rest, rest)


def test_closures_by_names_of_frames() -> None:
    """The four-bar, closed by frames instead of a constraint; hinge and point move it alike."""
    parts = four_bar(EXACT)
    loop, model = parts.loops[0], parts.model
    for name, joint, place in (
        ("tip", loop.joint1_id, loop.joint1_placement),
        ("pin", loop.joint2_id, loop.joint2_placement),
    ):
        model.addFrame(pin.Frame(name, joint, 0, place, pin.FrameType.OP_FRAME))
    expected = psp3.ClosedLoopRobot(model, parts.loops, parts.motors, np.zeros(3))
    for kind in ("3d", "hinge"):
        robot = psp3.ClosedLoopRobot(
            model, [], parts.motors, np.zeros(3), closures=[("tip", "pin", kind)]
        )
        assert isinstance(robot.equations[0], Hinge) if kind == "hinge" else not robot.equations
        assert robot.forward_dynamics([0.1], [0.5], [0.7]) == pytest.approx(
            expected.forward_dynamics([0.1], [0.5], [0.7]), rel=1e-10
        )
        force = robot.closure_forces([0.1], [0.5], [0.7]).loops[0]
        theirs = expected.closure_forces([0.1], [0.5], [0.7]).loops[0]
        assert force.name == "tip-pin"
        assert np.allclose(force.force, theirs.force, rtol=0.0, atol=1e-10)
    for wrong, known in ((("tip", "pin", "5d"), "hinge"), (("tip", "floor", "3d"), "world")):
        with pytest.raises(UnknownName, match=known):
            psp3.ClosedLoopRobot(model, [], parts.motors, np.zeros(3), closures=[wrong])


def test_a_ball_that_hangs_freely_is_held_in_all_its_directions() -> None:
    """A pendulum on a ball: locked it is as stiff as one body with the arm."""
    model = chain(("arm", pin.JointModelRY()), ("ball", pin.JointModelSpherical()))
    stiff = chain(("arm", pin.JointModelRY()))
    stiff.appendBodyToJoint(1, BODY, model.jointPlacements[2])
    robot = psp3.ClosedLoopRobot(model, [], ("arm",))
    assert [one.joint for one in robot.locked] == ["ball"] * 3
    other = psp3.ClosedLoopRobot(stiff, [], ("arm",))
    for position in (-0.5, 0.3):
        ours, theirs = (one.forward_dynamics([position], [0.7], [0.2]) for one in (robot, other))
        assert ours == pytest.approx(theirs, rel=1e-12)


def test_what_cannot_be_a_coordinate_is_said() -> None:
    model = chain(("one", pin.JointModelRX()), ("two", pin.JointModelRUBZ()))
    with pytest.raises(UnknownName, match="three"):
        psp3.ClosedLoopRobot(model, [], ("one",), coordinates=["three"])
    ball = chain(("one", pin.JointModelRX()), ("two", pin.JointModelSpherical()))
    with pytest.raises(DependentCoordinates, match="'two'"):
        psp3.ClosedLoopRobot(ball, [], ("one",), coordinates=["two"])
    assert psp3.ClosedLoopRobot(model, [], ("one",)).locked[0].joint == "two"
    with pytest.raises(MobilityMismatch):
        psp3.ClosedLoopRobot(model, [], ())
    assert psp3.ClosedLoopRobot(
        chain(("one", pin.JointModelRX())), [], (), free="keep"
    ).coordinates == ("one",)


def test_a_ball_is_told_from_a_planar_joint() -> None:
    model = chain(("ball", pin.JointModelSpherical()), ("table", pin.JointModelPlanar()))
    assert [is_ball(joint) for joint in list(model.joints)[1:]] == [True, False]


def test_robots_with_locks_and_equations_can_be_copied() -> None:
    model = chain(("arm", pin.JointModelRY()), ("ball", pin.JointModelSpherical()))
    robot = psp3.ClosedLoopRobot(model, [], ("arm",), springs={"arm": (3.0, 0.1)})
    expected = robot.inverse_dynamics([0.2], [0.3], [0.4])
    for again in (pickle.loads(pickle.dumps(robot)), copy.deepcopy(robot)):
        assert again.inverse_dynamics([0.2], [0.3], [0.4]) == pytest.approx(expected, rel=1e-15)


def test_motors_at_a_dead_point_are_no_coordinates_where_others_do() -> None:
    """At home, by symmetry, no arm length of the 3-PSP changes at first: the nuts must measure."""
    star = psp3.load("psp3")
    motors = ("b1", "b2", "b3", "a1", "a2", "a3")
    robot = psp3.ClosedLoopRobot(star.model, star.constraint_models, motors, star.q0)
    assert robot.coordinates == ("a1", "a2", "a3")
    positions = star.reference + np.array([0.01, 0.0, -0.02])
    forces = robot.actuator_forces(positions, np.zeros(3), np.zeros(3))
    alone = star.inverse_dynamics(positions, np.zeros(3), np.zeros(3))
    assert np.linalg.norm(forces) <= np.linalg.norm(alone)
    assert np.allclose(robot.actuation_matrix(positions) @ forces, alone, rtol=1e-9)


def test_motions_of_which_all_others_measure_nothing_are_those_of_null_spaces() -> None:
    """Where rows and motions are as many, and where they are not; 1e-12 for a condition of 1e2."""
    rng = np.random.default_rng(3)
    for rows, motions in ((5, 5), (4, 6), (6, 4)):
        measured = rng.normal(size=(rows, motions))
        found = list(_alone(measured, 3))
        assert len(found) == 3
        for number, left in enumerate(found):
            others = np.delete(measured, number, axis=0)
            expected = null_space(others, 1e-6, 1.0)
            assert np.abs(left @ left.T - expected @ expected.T).max() < 1e-12


def test_of_many_free_joints_none_is_looked_at_by_a_decomposition_of_its_own(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Else a tree takes the fourth power of its joints: 22 s for a hundred."""
    monkeypatch.setattr(coordinates, "null_space", lambda *_: pytest.fail("one by one"))
    model = chain(*((f"joint{k}", pin.JointModelRX()) for k in range(30)))
    robot = psp3.ClosedLoopRobot(model, [], (), free="keep")
    assert robot.coordinates == tuple(f"joint{k}" for k in range(30))
