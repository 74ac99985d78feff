"""Pinocchio's projected dynamics.

Against the closed form, and against what must hold for any robot.
"""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import psp3
from psp3.dynamics.derivatives import forward_dynamics_derivatives, inverse_dynamics_derivatives
from psp3.dynamics.projected import ProjectedDynamics
from psp3.errors import (
    ClosureFailed,
    DisorderedJoints,
    InvalidArray,
    InvalidValue,
    JointLimitExceeded,
    MobilityMismatch,
    SingularConfiguration,
    UnknownName,
)
from tests.helpers import (
    ROBOTS_WITH_LIE_GROUPS,
    ROBOTS_WITH_LOOPS,
    Array,
    derivative,
    free_body_carried_by_an_arm,
    random_states,
    relative_error,
)

STEP = 5e-3
"""Of eighth-order differences [m, rad], which leave 1e-10 or so here."""


class Case:
    """A robot with loops, and random states of it."""

    def __init__(self, robot: Any, positions: Array) -> None:
        rng, self.robot = np.random.default_rng(1), robot
        self.model, self.tree = robot.model, ProjectedDynamics(robot)
        self.positions = positions
        self.speeds, self.accelerations = rng.normal(size=(2, *positions.shape))


def star_case() -> Case:
    return Case(psp3.load("psp3"), random_states(np.random.default_rng(0), 8)[0])


def loop_case(builder: Any) -> Case:
    parts = builder()
    joints = [parts.model.joints[parts.model.getJointId(name)] for name in parts.actuated]
    home = parts.q0[[joint.idx_q for joint in joints]]
    shifts = np.random.default_rng(2).uniform(-0.15, 0.15, size=(8, home.size))
    return Case(parts, home + shifts)


@pytest.fixture(scope="module")
def star() -> Case:
    return star_case()


@pytest.fixture(
    scope="module",
    params=[star_case, *ROBOTS_WITH_LOOPS, *ROBOTS_WITH_LIE_GROUPS],
    ids=lambda case: str(case.__name__),
)
def case(request: pytest.FixtureRequest) -> Case:
    return star_case() if request.param is star_case else loop_case(request.param)


# Closing the loops


def gaps(case: Case, q: Array) -> Array:
    """How far the frames of the loops are apart, by placements alone."""
    data, found = case.model.createData(), []
    pin.forwardKinematics(case.model, data, q)
    for loop in case.robot.constraint_models:
        relative = (data.oMi[loop.joint1_id] * loop.joint1_placement).actInv(
            data.oMi[loop.joint2_id] * loop.joint2_placement
        )
        is_point = loop.type == pin.ContactType.CONTACT_3D
        found.append(relative.translation if is_point else pin.log6(relative).vector)
    return np.concatenate(found)


def test_loops_are_closed_with_the_motors_where_they_should_be(case: Case) -> None:
    """1e-13 m and rad: Newton's method ends at rounding."""
    places = [case.model.joints[case.model.getJointId(name)].idx_q for name in case.tree.actuated]
    found = case.tree.configuration(case.positions)
    assert_array_equal(found[:, places], case.positions)
    assert max(np.abs(gaps(case, q)).max() for q in found) < 1e-13


def test_configurations_are_those_of_the_closed_form(star: Case) -> None:
    """1e-12 m and rad: the closures' condition number is at most 300 here."""
    found = star.tree.configuration(star.positions)
    assert_allclose(found, star.robot.configuration(star.positions), rtol=0, atol=1e-12)


def test_complement_is_the_derivative_of_the_configuration(case: Case) -> None:
    """By differences in the tangent space, 1e-8; the rate of that times speeds is the drift."""
    for a, speed in zip(case.positions[:3], case.speeds, strict=False):
        q, L = case.tree.configuration(a), case.tree.complement(a)

        def way(t: float, a: Array = a, q: Array = q, speed: Array = speed) -> Array:
            return np.asarray(pin.difference(case.model, q, case.tree.configuration(a + t * speed)))

        assert_allclose(L @ speed, derivative(way, STEP), rtol=0, atol=1e-8)
        pose = case.tree.closure(a)
        assert_array_equal(pose.configuration, q)
        assert_array_equal(pose.complement, L)


def test_drift_is_the_rate_of_the_joint_velocities(case: Case) -> None:
    """Of a uniform motion of the motors, by differences; 1e-7 of what differences leave.

    The joints' velocities are compared in Pinocchio's own tangent coordinates, whose rates the
    joint accelerations are.
    """
    for a, speed in zip(case.positions[:3], case.speeds, strict=False):

        def velocity(t: float, a: Array = a, speed: Array = speed) -> Array:
            return np.asarray(case.tree.complement(a + t * speed) @ speed)

        found = case.tree.drift(case.tree.configuration(a), velocity(0.0))
        assert_allclose(found, derivative(velocity, STEP), rtol=0, atol=1e-7)
        assert_array_equal(found[case.tree.actuated_v], 0.0)


# Dynamics


def test_equation_of_motion_is_that_of_the_closed_form(star: Case) -> None:
    """1e-13 of the largest entry, and 6e-12 for C, which is worst where it is small."""
    expected = star.robot.equation_of_motion(star.positions, star.speeds)
    found = star.tree.equation_of_motion(star.positions, star.speeds)
    for one, other, tolerance in zip(found, expected, (1e-13, 6e-12, 1e-13), strict=True):
        assert relative_error(one, other) < tolerance


def test_power_is_the_rate_of_the_energy(case: Case) -> None:
    """Of Pinocchio's energies of the whole tree, along the motion, by differences.

    To 1e-7 of the largest term.
    """
    data = case.model.createData()
    for a, v, w in zip(case.positions[:4], case.speeds, case.accelerations, strict=False):

        def energy(t: float, a: Array = a, v: Array = v, w: Array = w) -> Array:
            at, speed = a + t * v + 0.5 * t * t * w, v + t * w
            q, velocity = case.tree.configuration(at), case.tree.complement(at) @ speed
            return np.asarray(
                pin.computeKineticEnergy(case.model, data, q, velocity)
                + pin.computePotentialEnergy(case.model, data, q)
            )

        forces = case.tree.inverse_dynamics(a, v, w)
        assert_allclose(
            forces @ v, derivative(energy, STEP), rtol=0, atol=1e-7 * np.abs(forces * v).max()
        )


def test_rate_of_the_mass_matrix_less_twice_coriolis_is_skew(case: Case) -> None:
    """dM/dt = C + C', by differences; 1e-7 of the largest entry of either."""
    for a, v in zip(case.positions[:4], case.speeds, strict=False):
        rate = derivative(lambda t, a=a, v=v: case.tree.mass_matrix(a + t * v), STEP)
        coriolis = case.tree.coriolis_matrix(a, v)
        size = max(np.abs(coriolis).max(), np.abs(rate).max())
        assert_allclose(coriolis + coriolis.T, rate, rtol=0, atol=1e-7 * size)


def test_coriolis_matrix_is_symmetric_in_two_velocities(case: Case) -> None:
    """C(v) w = C(w) v: of Christoffel symbols; 1e-12 is rounding of the polarization."""
    a, v, w = case.positions, case.speeds, case.accelerations
    one = np.einsum("nij,nj->ni", case.tree.coriolis_matrix(a, v), w)
    other = np.einsum("nij,nj->ni", case.tree.coriolis_matrix(a, w), v)
    assert_allclose(one, other, rtol=0, atol=1e-12 * max(1.0, np.abs(one).max()))


def test_forces_are_those_of_the_equation_of_motion(case: Case) -> None:
    """Which are projected apart; 1e-12 of the largest force is rounding."""
    mass, coriolis, gravity = case.tree.equation_of_motion(case.positions, case.speeds)
    expected = gravity + np.einsum("nij,nj->ni", mass, case.accelerations)
    expected += np.einsum("nij,nj->ni", coriolis, case.speeds)
    motion = case.positions, case.speeds, case.accelerations
    found = case.tree.inverse_dynamics(*motion)
    assert_allclose(found, expected, rtol=0, atol=1e-12 * max(1.0, np.abs(expected).max()))
    assert_array_equal(case.tree.actuator_forces(*motion), found)
    assert_array_equal(case.tree.gravity(case.positions), gravity)
    at_rest = case.tree.equation_of_motion(case.positions, np.zeros_like(case.speeds))
    assert_array_equal(at_rest[1], 0.0)


def test_forward_dynamics_undoes_inverse_dynamics(case: Case) -> None:
    """By projection, and by ``constraintDynamics`` on the whole tree.

    1e-10 of the largest acceleration that forces alone would give: the redundant closures' proximal
    iteration leaves 1e-11.
    """
    motion = case.positions, case.speeds, case.accelerations
    forces = case.tree.inverse_dynamics(*motion)
    found = case.tree.forward_dynamics(case.positions, case.speeds, forces)
    size = np.abs(np.linalg.solve(case.tree.mass_matrix(case.positions), forces[..., None])).max()
    assert_allclose(found, case.accelerations, rtol=0, atol=1e-11 * size)
    for (a, v, w), force in zip(zip(*motion, strict=True), forces, strict=True):
        q, L = case.tree.configuration(a), case.tree.complement(a)
        joints = case.tree.constrained_accelerations(q, L @ v, force)
        expected = L @ w + case.tree.drift(q, L @ v)
        assert_allclose(joints, expected, rtol=0, atol=1e-10 * max(size, np.abs(expected).max()))


def test_answers_do_not_depend_on_what_was_asked_before(case: Case) -> None:
    """Every algorithm in between the others, in new objects and in one; not a bit."""

    def answers(tree: ProjectedDynamics, k: int) -> list[Array]:
        a, v, w = case.positions[k], case.speeds[k], case.accelerations[k]
        q, velocity = tree.configuration(a), tree.complement(a) @ v
        return [
            tree.constrained_accelerations(q, velocity, w),
            tree.drift(q, velocity),
            tree.forward_dynamics(a, v, w),
            tree.constrained_accelerations(q, velocity, w),
            tree.inverse_dynamics(a, v, w),
            *tree.equation_of_motion(a, v),
        ]

    for k in range(3):
        alone = answers(ProjectedDynamics(case.robot), k)
        for one, other in zip(answers(case.tree, k), alone, strict=True):
            assert_array_equal(one, other)
        assert_array_equal(alone[0], alone[3])


def test_gravity_may_be_changed() -> None:
    """It is read from the model at every call, and velocity forces never have it."""
    parts = ROBOTS_WITH_LOOPS[2]()
    tree, rest = ProjectedDynamics(parts), np.zeros(2)
    home = parts.q0[:2]
    assert np.abs(tree.gravity(home)).max() > 0.1
    before = tree.coriolis_matrix(home, [1.0, 2.0])
    parts.model.gravity = pin.Motion.Zero()
    assert_array_equal(tree.gravity(home), rest)
    assert_array_equal(tree.inverse_dynamics(home, rest, rest), rest)
    assert_array_equal(tree.coriolis_matrix(home, [1.0, 2.0]), before)


def test_derivatives_of_it_are_those_of_the_robot(star: Case) -> None:
    """Derivatives take what closes its loops, whichever way; 1e-10 of the largest entry."""
    core = star.robot.dynamics("core")
    for function in (inverse_dynamics_derivatives, forward_dynamics_derivatives):
        for found, expected in zip(
            function(star.tree, star.positions, star.speeds, star.accelerations),
            function(core, star.positions, star.speeds, star.accelerations),
            strict=True,
        ):
            assert relative_error(found, expected) < 1e-10


# Trees in which branches alternate


def alternating(swapped: bool) -> SimpleNamespace:
    """Two arms of two hinges on a turntable, one after the other or joint by joint in turn."""
    model, rng = pin.Model(), np.random.default_rng(5)
    inertias = {}
    for name in ("table", "left1", "left2", "right1", "right2"):
        axes, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        inertias[name] = pin.Inertia(
            1.0, rng.uniform(-0.2, 0.2, 3), axes @ np.diag([0.02, 0.03, 0.04]) @ axes.T
        )
    order = [("table", None), ("left1", "table"), ("left2", "left1")]
    order += [("right1", "table"), ("right2", "right1")]
    if swapped:
        order = [order[i] for i in (0, 1, 3, 2, 4)]
    for name, parent in order:
        place = pin.SE3(pin.utils.rotate("x", 0.4), np.array([0.3, 0.1, 0.0]))
        joint = model.addJoint(
            model.getJointId(parent) if parent else 0, pin.JointModelRZ(), place, name
        )
        model.appendBodyToJoint(joint, inertias[name], pin.SE3.Identity())
    return SimpleNamespace(model=model, actuated=tuple(inertias))


def test_branches_may_alternate_where_crba_is_wrong() -> None:
    """The same robot with its joints in another order; 1e-13 is rounding.

    Its CRBA is off by more than 1 %, which is why it is not asked.
    """
    sorted_, mixed = (ProjectedDynamics(alternating(swapped)) for swapped in (False, True))
    rng = np.random.default_rng(6)
    a, v, w = rng.normal(size=(3, 5, 5))
    for found, expected in zip(
        mixed.equation_of_motion(a, v), sorted_.equation_of_motion(a, v), strict=True
    ):
        assert_allclose(found, expected, rtol=0, atol=1e-13 * np.abs(expected).max())
    assert_allclose(mixed.forward_dynamics(a, v, w), sorted_.forward_dynamics(a, v, w), rtol=1e-10)
    q = mixed.configuration(a[0])
    crba = pin.crba(mixed.model, mixed.data, q)
    crba = (np.triu(crba) + np.triu(crba, 1).T)[np.ix_(mixed.actuated_v, mixed.actuated_v)]
    assert np.abs(crba - mixed.mass_matrix(a[0])).max() > 0.01 * np.abs(crba).max()
    with pytest.raises(DisorderedJoints):
        mixed.constrained_accelerations(q, v[0], w[0])


# What is refused


def test_the_border_of_the_workspace_and_limits_of_joints_are_kept(star: Case) -> None:
    with pytest.raises(ClosureFailed):
        psp3.load("five_bar").dynamics("pinocchio").actuator_forces([-1.5, 1.5], *np.zeros((2, 2)))
    with pytest.raises(JointLimitExceeded) as caught:
        star.tree.configuration([0.0, -0.5, 0.5])
    assert caught.value.joint == "b1"


def test_a_home_that_is_none_is_refused_without_a_pose_too() -> None:
    """Elbows 0.60 m apart, and two rods of 0.28 m."""
    robot = psp3.load("five_bar")
    q0 = np.array(robot.q0)
    q0[robot.actuated_q] = [-1.5, 1.5]
    tree = ProjectedDynamics(
        SimpleNamespace(
            model=robot.model,
            constraint_models=robot.constraint_models,
            actuated=robot.actuated,
            q0=q0,
        )
    )
    with pytest.raises(ClosureFailed):
        tree.configuration(np.zeros((0, 2)))


@pytest.mark.parametrize(
    ("actuated", "error"),
    [
        (("j1",), SingularConfiguration),
        (("j1", "j2", "j3"), InvalidValue),
        (("j1", "elbow"), UnknownName),
    ],
)
def test_motors_that_do_not_fit_are_refused(actuated: tuple[str, ...], error: Any) -> None:
    """Too few; a free body as a motor; none of the tree."""
    parts = free_body_carried_by_an_arm()
    parts.actuated = actuated
    with pytest.raises(error):
        ProjectedDynamics(parts).configuration(np.zeros(len(actuated)))


def test_too_many_motors_are_refused() -> None:
    parts = ROBOTS_WITH_LOOPS[0]()
    parts.actuated = ("j1", "j2")
    with pytest.raises(MobilityMismatch):
        ProjectedDynamics(parts).configuration(parts.q0[:2])


def test_leading_dimensions_are_kept_and_malformed_arguments_refused(star: Case) -> None:
    tree, motion = star.tree, (star.positions, star.speeds, star.accelerations)
    single = tree.inverse_dynamics(*(part[5] for part in motion))
    found = tree.inverse_dynamics(*(part.reshape(2, 4, 3) for part in motion))
    assert found.shape == (2, 4, 3)
    assert_array_equal(found[1, 1], single)
    assert tree.complement(star.positions.reshape(2, 4, 3)).shape == (2, 4, 15, 3)
    empty = np.zeros((2, 0, 3))
    assert [part.shape for part in tree.equation_of_motion(empty, empty)] == [
        (2, 0, 3, 3),
        (2, 0, 3, 3),
        (2, 0, 3),
    ]
    for bad in ([0.0, np.nan, 0.0], np.zeros(2), "home", None, 1.0):
        with pytest.raises(InvalidArray):
            tree.configuration(bad)
        with pytest.raises(InvalidArray):
            tree.closure(bad)
        with pytest.raises(InvalidArray):
            tree.forward_dynamics(np.zeros(3), np.zeros(3), bad)
