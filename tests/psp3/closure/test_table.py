"""Closing loops.

The compiled residual, Jacobian, complement and drift against Pinocchio and differences, and what is
refused.
"""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace

import numpy as np
import pinocchio as pin
import pytest
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

import psp3
from psp3.closure import NO_MOTORS, assembled, flattened, residual
from psp3.closure.kernels import _solve, jacobian
from psp3.errors import ClosureFailed, SingularConfiguration, UnsupportedJoint
from psp3.robots.closed_loop_robot import ClosedLoopRobot
from tests.helpers import ROBOTS_WITH_LIE_GROUPS, ROBOTS_WITH_LOOPS, Array, derivative

Builder = Callable[[], SimpleNamespace]


@pytest.fixture(
    scope="module",
    params=ROBOTS_WITH_LOOPS + ROBOTS_WITH_LIE_GROUPS,
    ids=lambda builder: builder.__name__,
)
def parts(request: pytest.FixtureRequest) -> SimpleNamespace:
    builder: Builder = request.param
    return builder()


@pytest.fixture(scope="module")
def robot(parts: SimpleNamespace) -> ClosedLoopRobot:
    return ClosedLoopRobot(parts.model, parts.constraint_models, parts.actuated, parts.q0)


def away(parts: SimpleNamespace, rng: np.random.Generator) -> Array:
    """Return a configuration that leaves the loops open."""
    moved: Array = pin.integrate(parts.model, parts.q0, rng.uniform(-0.3, 0.3, parts.model.nv))
    return moved


def nearby(robot: ClosedLoopRobot, rng: np.random.Generator, size: float = 0.2) -> Array:
    position: Array = robot.reference + rng.uniform(-size, size, len(robot.actuated))
    return position


def test_residual_is_position_and_rotation_vector_of_the_second_frame_in_the_first(
    parts: SimpleNamespace,
) -> None:
    """From Pinocchio's placements and SciPy's rotation vectors, at open configurations.

    1e-14, rounding.
    """
    table = flattened(parts.model, parts.constraint_models, NO_MOTORS)
    data, rng = parts.model.createData(), np.random.default_rng(0)
    for _ in range(10):
        q = away(parts, rng)
        pin.forwardKinematics(parts.model, data, q)
        expected = []
        for loop in parts.constraint_models:
            relative = (data.oMi[loop.joint1_id] * loop.joint1_placement).actInv(
                data.oMi[loop.joint2_id] * loop.joint2_placement
            )
            expected.append(relative.translation)
            if loop.type == pin.ContactType.CONTACT_6D:
                expected.append(Rotation.from_matrix(relative.rotation).as_rotvec())
        assert_allclose(residual(table, q), np.concatenate(expected), rtol=0.0, atol=1e-14)


def test_rotation_residual_near_half_a_turn() -> None:
    """Where the sine vanishes the axis must still be found.

    1e-7, because an angle near π is known to the root of rounding only.
    """
    model = pin.Model()
    model.addJoint(0, pin.JointModelSpherical(), pin.SE3.Identity(), "ball")
    loops = pin.StdVec_RigidConstraintModel()
    loops.append(
        pin.RigidConstraintModel(
            pin.ContactType.CONTACT_6D,
            model,
            0,
            pin.SE3.Identity(),
            1,
            pin.SE3.Identity(),
            pin.ReferenceFrame.LOCAL,
        )
    )
    table, rng = flattened(model, loops, NO_MOTORS), np.random.default_rng(1)
    for off in (0.0, 1e-9, 1e-5):
        axis = rng.normal(size=3)
        turn = Rotation.from_rotvec((np.pi - off) * axis / np.linalg.norm(axis))
        found = residual(table, turn.as_quat())[3:]
        assert (Rotation.from_rotvec(found) * turn.inv()).magnitude() < 1e-7


def test_jacobian_is_the_derivative_of_the_residual_away_from_closure(
    parts: SimpleNamespace,
) -> None:
    """1e-9: eighth-order differences with steps of 1e-2 are that good.

    Pinocchio's own Jacobian is not this derivative here.
    """
    table = flattened(parts.model, parts.constraint_models, NO_MOTORS)
    found, rng = (
        np.zeros((residual(table, parts.q0).size, parts.model.nv)),
        np.random.default_rng(2),
    )
    for _ in range(5):
        q = away(parts, rng)
        jacobian(table, q, found)
        for column, unit in enumerate(np.eye(parts.model.nv)):
            expected = derivative(
                lambda t, u=unit, q=q: residual(table, pin.integrate(parts.model, q, t * u)), 1e-2
            )
            assert_allclose(found[:, column], expected, rtol=0.0, atol=1e-9)


def test_complement_spans_the_null_space_of_pinocchios_jacobian(robot: ClosedLoopRobot) -> None:
    """Φ L = 0 to 1e-12 with Pinocchio's Φ, and the actuated rows of L are the identity."""
    rng = np.random.default_rng(3)
    for _ in range(10):
        closure = robot.closure(nearby(robot, rng))
        assert (
            np.abs(robot.constraint_jacobian(closure.configuration) @ closure.complement).max()
            < 1e-12
        )
        assert_allclose(
            closure.complement[robot.actuated_v], np.eye(len(robot.actuated)), rtol=0.0, atol=0.0
        )


def test_complement_is_the_derivative_of_the_configuration(robot: ClosedLoopRobot) -> None:
    """In Pinocchio's tangent space, by differences of closures; 1e-8."""
    rng = np.random.default_rng(4)
    position = nearby(robot, rng)
    closure = robot.closure(position)
    for column, unit in enumerate(np.eye(len(robot.actuated))):

        def moved(t: float, unit: Array = unit) -> Array:
            q: Array = pin.difference(
                robot.model, closure.configuration, robot.configuration(position + t * unit)
            )
            return q

        assert_allclose(closure.complement[:, column], derivative(moved, 2e-3), rtol=0.0, atol=1e-8)


def test_dependent_inverse_solves_pinocchios_equations(robot: ClosedLoopRobot) -> None:
    """L's un-actuated rows are −(Φ^u)⁻¹ Φ^a; 1e-11."""
    closure = robot.closure(nearby(robot, np.random.default_rng(5)))
    actuated = robot.constraint_jacobian(closure.configuration)[:, robot.actuated_v]
    assert_allclose(
        closure.complement[robot.dependent_v],
        -closure.dependent_inverse @ actuated,
        rtol=0.0,
        atol=1e-11,
    )


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
        assert_allclose(
            robot.drift(closure.configuration, closure.complement @ speed),
            rate,
            rtol=0.0,
            atol=1e-7,
        )


def test_drift_satisfies_pinocchios_constraint_on_accelerations(robot: ClosedLoopRobot) -> None:
    """``constraintDynamics`` gives joint accelerations that keep the loops closed.

    So do L · (its actuated ones) + drift. 1e-8.
    """
    rng = np.random.default_rng(7)
    position, speed, force = (
        nearby(robot, rng),
        rng.uniform(-1.0, 1.0, len(robot.actuated)),
        rng.normal(size=len(robot.actuated)),
    )
    closure = robot.closure(position)
    v = closure.complement @ speed
    theirs = robot.constrained_accelerations(closure.configuration, v, force)
    ours = closure.complement @ theirs[robot.actuated_v] + robot.drift(closure.configuration, v)
    assert_allclose(ours, theirs, rtol=0.0, atol=1e-8)


@pytest.mark.parametrize("shape", [(3, 3), (6, 3), (12, 12), (5, 1), (1, 1)])
def test_householder_solution_is_that_of_least_squares(shape: tuple[int, int]) -> None:
    """Against numpy's; also with rows that repeat others.

    1e-10 for matrices of condition below 1e4.
    """
    rng = np.random.default_rng(8)
    matrix, right = rng.normal(size=shape), rng.normal(size=(shape[0], 2))
    solution = np.empty((shape[1], 2))
    expected = np.linalg.lstsq(matrix, right, rcond=None)[0]
    assert abs(_solve(matrix.copy(), right.copy(), solution)) == 1
    assert_allclose(solution, expected, rtol=1e-10, atol=1e-10)
    doubled, solution = np.concatenate([matrix, matrix]), np.empty((shape[1], 2))
    assert abs(_solve(doubled, np.concatenate([right, right]), solution)) == 1
    assert_allclose(solution, expected, rtol=1e-10, atol=1e-10)


def test_sign_of_the_determinant() -> None:
    """Against numpy's, for matrices of both signs."""
    rng, signs = np.random.default_rng(14), set()
    for _ in range(20):
        matrix = rng.normal(size=(5, 5))
        sign = np.sign(np.linalg.det(matrix))
        assert _solve(matrix.copy(), np.zeros((5, 1)), np.empty((5, 1))) == sign
        signs.add(sign)
    assert signs == {-1.0, 1.0}


def test_dependent_columns_are_seen() -> None:
    matrix = np.random.default_rng(9).normal(size=(6, 3))
    matrix[:, 2] = matrix[:, 0] - 2.0 * matrix[:, 1]
    assert not _solve(matrix, np.ones((6, 1)), np.empty((3, 1)))
    assert not _solve(np.ones((2, 3)), np.ones((2, 1)), np.empty((3, 1)))
    assert not _solve(np.full((3, 3), np.nan), np.ones((3, 1)), np.empty((3, 1)))


# Assembly modes


def five_bar(base: float = 0.3, near: float = 0.25, far: float = 0.35) -> ClosedLoopRobot:
    """Two legs in the plane, joined at a point."""
    model = pin.Model()
    loops, tips = pin.StdVec_RigidConstraintModel(), []
    for leg, x in enumerate((0.0, base)):
        shoulder = model.addJoint(
            0, pin.JointModelRZ(), pin.SE3(np.eye(3), np.array([x, 0.0, 0.0])), f"shoulder{leg}"
        )
        elbow = model.addJoint(
            shoulder,
            pin.JointModelRZ(),
            pin.SE3(np.eye(3), np.array([near, 0.0, 0.0])),
            f"elbow{leg}",
        )
        for joint in (shoulder, elbow):
            model.appendBodyToJoint(
                joint,
                pin.Inertia(1.0, np.array([0.1, 0.0, 0.0]), 0.01 * np.eye(3)),
                pin.SE3.Identity(),
            )
        tips.append((elbow, pin.SE3(np.eye(3), np.array([far, 0.0, 0.0]))))
    loops.append(
        pin.RigidConstraintModel(
            pin.ContactType.CONTACT_3D, model, *tips[0], *tips[1], pin.ReferenceFrame.LOCAL
        )
    )
    return ClosedLoopRobot(
        model, loops, ("shoulder0", "shoulder1"), np.array([2.3, -1.4, 0.8, 1.4])
    )


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


def test_steps_as_small_as_rounding_are_taken() -> None:
    """An integrator that starts at rest asks for poses 1e-17 from the reference.

    A correction larger than the step is rounding there.
    """
    robot, rng = psp3.load("delta"), np.random.default_rng(13)
    for size in 10.0 ** rng.uniform(-20.0, -8.0, 200):
        robot.closure(robot.reference + size * rng.normal(size=3))


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


# Assembling


def test_an_open_tree_is_assembled_within_its_joint_limits(parts: SimpleNamespace) -> None:
    """From configurations that leave the loops open by tenths.

    The residual falls below 1e-9 and limits hold.
    """
    table, rng = (
        flattened(parts.model, parts.constraint_models, NO_MOTORS),
        np.random.default_rng(12),
    )
    for _ in range(3):
        start = away(parts, rng)
        assert np.abs(residual(table, start)).max() > 1e-3
        assert np.abs(residual(table, assembled(parts.model, table, start))).max() < 1e-9


def test_a_robot_near_its_closure_is_assembled_without_the_optimizer(
    parts: SimpleNamespace, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Loading any robot asks for this, and the optimizer's import takes longer than the rest."""
    table, rng = (
        flattened(parts.model, parts.constraint_models, NO_MOTORS),
        np.random.default_rng(15),
    )
    monkeypatch.setattr(
        "scipy.optimize.least_squares", lambda *_, **__: pytest.fail("the optimizer was asked")
    )
    start = pin.integrate(parts.model, parts.q0, rng.uniform(-0.02, 0.02, parts.model.nv))
    closed = assembled(parts.model, table, start)
    assert np.abs(residual(table, closed)).max() < 1e-9
    # The shortest way: what the start was off by, and not more.
    assert np.linalg.norm(pin.difference(parts.model, start, closed)) <= 1.05 * np.linalg.norm(
        pin.difference(parts.model, start, parts.q0)
    )


def test_a_robot_without_a_reference_pose_is_assembled() -> None:
    """With all joints at zero the legs do not meet."""
    robot = five_bar()
    without = ClosedLoopRobot(robot.model, robot.constraint_models, robot.actuated)
    assert np.abs(residual(without._table, without.q0)).max() < 1e-13


def test_links_too_short_to_meet_are_refused_with_the_residual() -> None:
    robot = five_bar()
    loops = pin.StdVec_RigidConstraintModel()
    loop = pin.RigidConstraintModel(robot.constraint_models[0])
    # Five meters apart.
    loop.joint2_placement = pin.SE3(np.eye(3), np.array([0.0, 0.0, 5.0]))
    loops.append(loop)
    with pytest.raises(ClosureFailed) as caught:
        ClosedLoopRobot(robot.model, loops, robot.actuated)
    assert_allclose(caught.value.residual, 5.0, rtol=0.2)


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
