"""The thesis's natural orthogonal complement.

Every quantity against its definition, on the 3-PSP and on other robots with loops.
"""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import psp3
from psp3.errors import (
    InconsistentVelocity,
    InvalidArray,
    OpenLoops,
    PSP3Error,
    SingularConfiguration,
)
from tests.helpers import (
    ROBOTS_WITH_LOOPS,
    Array,
    cross_matrix,
    derivative,
    random_states,
    relative_error,
)

STEP = 5e-3
"""Eighth-order differences with this step [m, rad] are right to about 1e-10 here; the bar for every
derivative is 1e-7.
"""


class Case:
    """A robot with loops, its complement, and random closed states of it."""

    def __init__(self, robot: Any, positions: Array, seed: int) -> None:
        rng = np.random.default_rng(seed)
        self.robot, self.model = robot, robot.model
        self.noc = psp3.NaturalOrthogonalComplement(robot)
        self.positions = positions
        self.speeds = rng.normal(size=positions.shape)
        self.q = robot.configuration(positions)
        self.v = np.einsum("nij,nj->ni", self.noc.L(self.q), self.speeds)
        # Not closed at all: every joint is off by up to 0.1 m or rad.
        self.off = self.q + rng.uniform(-0.1, 0.1, size=self.q.shape)
        self.v_off = np.einsum("nij,nj->ni", self.noc.L(self.off), self.speeds)
        self.actuated = [
            self.model.joints[self.model.getJointId(name)].idx_v for name in robot.actuated
        ]
        self.dependent = np.setdiff1d(np.arange(self.model.nv), self.actuated)


def star_case(parameters: str = "default", count: int = 10) -> Case:
    heights, _ = random_states(np.random.default_rng(0), count)
    return Case(psp3.load("psp3", parameters), heights, 1)


def loop_case(builder: Any) -> Case:
    parts = builder()
    robot = psp3.ClosedLoopRobot(parts.model, parts.constraint_models, parts.actuated, parts.q0)
    home = [
        robot.q0[robot.model.joints[robot.model.getJointId(name)].idx_q] for name in robot.actuated
    ]
    return Case(
        robot,
        np.array(home) + np.random.default_rng(2).uniform(-0.15, 0.15, size=(10, len(home))),
        3,
    )


@pytest.fixture(scope="module")
def star() -> Case:
    return star_case()


@pytest.fixture(
    scope="module",
    params=[star_case, *ROBOTS_WITH_LOOPS],
    ids=["3-PSP", *(builder.__name__ for builder in ROBOTS_WITH_LOOPS)],
)
def case(request: pytest.FixtureRequest) -> Case:
    return star_case() if request.param is star_case else loop_case(request.param)


def tree_velocities(model: pin.Model, q: Array, v: Array) -> tuple[Array, Array, Array]:
    """Rotations, angular velocities and velocities of the centers of mass.

    In world axes, from Pinocchio's recursion over the bodies.
    """
    data = model.createData()
    pin.forwardKinematics(model, data, q, v)
    rotations, angular, linear = [], [], []
    for joint in range(1, model.njoints):
        rotation, twist = data.oMi[joint].rotation, data.v[joint]
        rotations.append(rotation)
        angular.append(rotation @ twist.angular)
        linear.append(
            rotation @ (twist.linear + np.cross(twist.angular, model.inertias[joint].lever))
        )
    return np.array(rotations), np.array(angular), np.array(linear)


# Constraints


def test_bodies_are_the_links_of_the_tree_in_order(star: Case) -> None:
    per_leg = ("nut", "ball_phi", "ball_theta", "ball_lambda", "star")
    assert star.noc.body_names == tuple(f"{name}{leg}" for leg in (1, 2, 3) for name in per_leg)


def test_constraint_is_zero_where_the_loops_are_closed(case: Case) -> None:
    """1e-13 is what Newton's method and the closed form leave."""
    assert np.abs(case.noc.constraint(case.q)).max() < 1e-13


def test_constraint_is_the_logarithm_of_the_relative_placement(star: Case) -> None:
    """Off closure, with the hub frames of the thirds placed by Pinocchio; 1e-14 is rounding."""
    data = star.model.createData()
    for q, found in zip(star.off, star.noc.constraint(star.off), strict=True):
        pin.framesForwardKinematics(star.model, data, q)
        first, second, third = (
            data.oMf[star.model.getFrameId(f"star{leg}_center")] for leg in (1, 2, 3)
        )
        expected = [pin.log6(first.actInv(other)).vector for other in (second, third)]
        assert_allclose(found, np.concatenate(expected), rtol=0, atol=1e-14)


def test_constraint_of_a_3d_loop_is_the_distance_of_its_points() -> None:
    """In axes of the first frame; 1e-15 is rounding."""
    case = loop_case(ROBOTS_WITH_LOOPS[2])
    (loop,) = case.robot.constraint_models
    data = case.model.createData()
    for q, found in zip(case.off, case.noc.constraint(case.off), strict=True):
        pin.forwardKinematics(case.model, data, q)
        first = data.oMi[loop.joint1_id] * loop.joint1_placement
        second = data.oMi[loop.joint2_id] * loop.joint2_placement
        assert_allclose(
            found, first.rotation.T @ (second.translation - first.translation), rtol=0, atol=1e-15
        )


@pytest.mark.parametrize("closed", [True, False], ids=["closed", "open"])
def test_constraint_jacobian_is_the_derivative_of_the_constraint(case: Case, closed: bool) -> None:
    """Column by column, at closed configurations and far off closure."""
    q = case.q if closed else case.off
    found = case.noc.constraint_jacobian(q)
    for j, unit in enumerate(np.eye(case.model.nv)):
        column = derivative(lambda t, unit=unit: case.noc.constraint(q + t * unit), STEP)
        assert_allclose(found[..., j], column, rtol=0, atol=1e-8)


def test_constraint_jacobian_is_minus_pinocchios_at_closure_only(star: Case) -> None:
    """The sign and the Jlog6 factor that Pinocchio's lacks; 1e-12 at closure."""
    data, constraints = star.model.createData(), star.robot.constraint_models
    constraint_data = pin.StdVec_RigidConstraintData()
    for constraint in constraints:
        constraint_data.append(constraint.createData())

    def pinocchios(q: Array) -> Array:
        pin.computeJointJacobians(star.model, data, q)
        for constraint, part in zip(constraints, constraint_data, strict=True):
            constraint.calc(star.model, data, part)
        return np.array(pin.getConstraintsJacobian(star.model, data, constraints, constraint_data))

    for q, found in zip(star.q, star.noc.constraint_jacobian(star.q), strict=True):
        assert_allclose(found, -pinocchios(q), rtol=0, atol=1e-12)
    assert np.abs(star.noc.constraint_jacobian(star.off[0]) + pinocchios(star.off[0])).max() > 1e-2


# The joint orthogonal complement L


def test_velocities_of_l_keep_the_loops_closed(case: Case) -> None:
    """Phi L = 0 and the actuated rows are the unit matrix, on and off closure for square closures.

    1e-12 relative.
    """
    for q in (case.q, case.off) if case.model.nv == 15 else (case.q,):
        complement, jacobian = case.noc.L(q), case.noc.constraint_jacobian(q)
        assert (
            np.abs(jacobian @ complement).max()
            < 1e-12 * np.abs(jacobian).max() * np.abs(complement).max()
        )
        assert_array_equal(
            complement[:, case.actuated],
            np.broadcast_to(np.eye(len(case.actuated)), (len(q), *[len(case.actuated)] * 2)),
        )


def test_l_is_the_derivative_of_the_closed_configuration(case: Case) -> None:
    for k, unit in enumerate(np.eye(len(case.actuated))):
        column = derivative(
            lambda t, unit=unit: case.robot.configuration(case.positions + t * unit), STEP
        )
        assert_allclose(
            case.noc.L(case.q)[..., k], column, rtol=0, atol=1e-8 * np.abs(column).max()
        )


def test_rates_are_the_derivatives_along_the_motion(case: Case) -> None:
    """L_dot, K_dot and T_dot against L, K and T along q + v t."""
    noc = case.noc
    for function, rate in ((noc.L, noc.L_dot), (noc.K, noc.K_dot), (noc.T, noc.T_dot)):
        expected = derivative(lambda t, function=function: function(case.q + t * case.v), 2e-3)
        assert_allclose(
            rate(case.q, case.v),
            expected,
            rtol=0,
            atol=1e-7 * max(1.0, np.abs(expected).max()),
            err_msg=function.__name__,
        )
        assert np.abs(expected).max() > 1e-3


def test_rates_are_the_derivatives_off_closure_too() -> None:
    """For velocities that leave the opening as it is.

    Closures of full rank only: redundant ones have no L off closure.
    """
    for case in (star_case(), loop_case(ROBOTS_WITH_LOOPS[2])):
        for name in ("L", "K", "T"):
            function = getattr(case.noc, name)
            expected = derivative(lambda t, f=function, c=case: f(c.off + t * c.v_off), 1e-3)
            found = getattr(case.noc, f"{name}_dot")(case.off, case.v_off)
            assert_allclose(
                found, expected, rtol=0, atol=1e-7 * max(1.0, np.abs(expected).max()), err_msg=name
            )


# Twists: K, T, Omega, M_total, w_g


def test_k_gives_the_twists_of_all_bodies(case: Case) -> None:
    """[omega; v] at the center of mass in world axes, for any joint velocity.

    Pinocchio's body recursion, 1e-12.
    """
    q, v = case.off[0], np.random.default_rng(4).normal(size=case.model.nv)
    _, angular, linear = tree_velocities(case.model, q, v)
    found = (case.noc.K(q) @ v).reshape(-1, 6)
    assert_allclose(found[:, :3], angular, rtol=0, atol=1e-12)
    assert_allclose(found[:, 3:], linear, rtol=0, atol=1e-12)


def test_k_has_the_joint_axes_as_columns(star: Case) -> None:
    """Eq. 3.29 as it should be printed.

    [e_j; e_j x r_j] for a revolute joint, [0; e_j] for a prismatic one, 0 off the path.
    """
    q = star.q[0]
    data = star.model.createData()
    pin.forwardKinematics(star.model, data, q)
    found = star.noc.K(q).reshape(15, 6, 15)
    local = {
        "a": [0, 0, 1],
        "phi": [0, 1, 0],
        "theta": [1, 0, 0],
        "lambda": [0, 0, 1],
        "b": [-1, 0, 0],
    }
    for body in range(1, 16):
        center = data.oMi[body].act(star.model.inertias[body].lever)
        path = list(star.model.supports[body])
        for joint in range(1, 16):
            name = star.model.names[joint]
            axis = data.oMi[joint].rotation @ np.array(local[name[:-1]])
            column = np.zeros(6)
            if joint in path:
                column = (
                    np.concatenate([np.zeros(3), axis])
                    if name[0] in "ab"
                    else np.concatenate(
                        [axis, np.cross(axis, center - data.oMi[joint].translation)]
                    )
                )
            assert_allclose(
                found[body - 1, :, star.model.joints[joint].idx_v], column, rtol=0, atol=1e-15
            )


def test_t_is_k_times_l(case: Case) -> None:
    """Eq. 3.32 against 3.33, put together from other products; 1e-12 relative."""
    expected = case.noc.K(case.q) @ case.noc.L(case.q)
    assert_allclose(case.noc.T(case.q), expected, rtol=0, atol=1e-12 * np.abs(expected).max())


def test_omega_holds_the_angular_velocities(case: Case) -> None:
    """Blocks diag(omega x, 0), nothing else; 1e-12 of Pinocchio's angular velocities."""
    q, v = case.q[0], case.v[0]
    _, angular, _ = tree_velocities(case.model, q, v)
    expected = np.zeros((6 * len(angular), 6 * len(angular)))
    for i, rate in enumerate(angular):
        expected[6 * i : 6 * i + 3, 6 * i : 6 * i + 3] = cross_matrix(rate)
    assert_allclose(
        case.noc.Omega(q, v), expected, rtol=0, atol=1e-12 * max(1.0, np.abs(expected).max())
    )


def test_m_total_holds_the_bodies_inertias_in_world_axes(case: Case) -> None:
    q = case.off[0]
    rotations, _, _ = tree_velocities(case.model, q, np.zeros(case.model.nv))
    expected = np.zeros((6 * len(rotations), 6 * len(rotations)))
    for i, rotation in enumerate(rotations):
        inertia = case.model.inertias[i + 1]
        expected[6 * i : 6 * i + 3, 6 * i : 6 * i + 3] = rotation @ inertia.inertia @ rotation.T
        expected[6 * i + 3 : 6 * i + 6, 6 * i + 3 : 6 * i + 6] = inertia.mass * np.eye(3)
    assert_allclose(case.noc.M_total(q), expected, rtol=0, atol=1e-15)


def test_twists_and_m_total_give_the_trees_kinetic_energy(case: Case) -> None:
    """Half t' M_total t against Pinocchio's sum; 1e-13 relative.

    Twists from all joints' velocities, which need not close the loops, and from the motors' speeds.
    """
    q, v = case.off[0], np.random.default_rng(5).normal(size=case.model.nv)
    twist = case.noc.K(q) @ v
    energy = pin.computeKineticEnergy(case.model, case.model.createData(), q, v)
    assert_allclose(0.5 * twist @ case.noc.M_total(q) @ twist, energy, rtol=1e-13)
    q, twist = case.q[0], case.noc.T(case.q[0]) @ case.speeds[0]
    energy = pin.computeKineticEnergy(case.model, case.model.createData(), q, case.v[0])
    assert_allclose(0.5 * twist @ case.noc.M_total(q) @ twist, energy, rtol=1e-12)


def test_weights_act_at_the_centers_of_mass(star: Case) -> None:
    """[0; m g] with g pointing down, 26.496 kg in sum; 1e-14 is rounding."""
    wrenches = star.noc.w_g().reshape(15, 6)
    assert_array_equal(wrenches[:, :5], 0.0)
    assert_allclose(
        wrenches[:, 5],
        [-9.81 * star.model.inertias[joint].mass for joint in range(1, 16)],
        rtol=1e-15,
    )
    assert_allclose(wrenches[:, 5].sum(), -9.81 * 26.496, rtol=1e-14)


@pytest.mark.parametrize("parameters", tuple(psp3.PARAMETER_SETS))
def test_merging_the_thirds_of_the_star_gives_the_thesis_with_13_bodies(parameters: str) -> None:
    """Where the loops are closed the three thirds move as one body.

    So T, M_total, Omega and w_g of 13 bodies give the same M, C, G.

    1e-12 relative; the twists of the thirds agree to 1e-12.
    """
    case = star_case(parameters, count=5)
    noc, bodies = case.noc, list(case.noc.body_names)
    thirds = [bodies.index(f"star{leg}") for leg in (1, 2, 3)]
    kept = [i for i in range(15) if i not in thirds[1:]]
    rows = np.concatenate([np.arange(6 * i, 6 * i + 6) for i in kept])
    star_rows = np.arange(6 * kept.index(thirds[0]), 6 * kept.index(thirds[0]) + 6)
    for q, v in zip(case.q, case.v, strict=True):
        natural, rate, total = noc.T(q), noc.T_dot(q, v), noc.M_total(q)
        twists = [natural[6 * i : 6 * i + 6] for i in thirds]
        assert_allclose(twists[1], twists[0], rtol=0, atol=1e-12)
        assert_allclose(twists[2], twists[0], rtol=0, atol=1e-12)
        merged = total[np.ix_(rows, rows)]
        merged[np.ix_(star_rows, star_rows)] = sum(
            total[6 * i : 6 * i + 6, 6 * i : 6 * i + 6] for i in thirds
        )
        # One rigid star with the inertia of the parameters, turned with it.
        rotation = case.robot.forward_kinematics(q[case.actuated]).rotation
        inertia = rotation @ np.diag(case.robot.parameters.star_inertia) @ rotation.T
        assert_allclose(merged[np.ix_(star_rows[:3], star_rows[:3])], inertia, rtol=0, atol=1e-13)
        assert_allclose(
            merged[np.ix_(star_rows[3:], star_rows[3:])], 1.758 * np.eye(3), rtol=0, atol=1e-15
        )
        weights = noc.w_g()[rows]
        weights[star_rows] = sum(noc.w_g()[6 * i : 6 * i + 6] for i in thirds)
        assert len(rows) == 6 * 13
        t, t_dot, omega = natural[rows], rate[rows], noc.Omega(q, v)[np.ix_(rows, rows)]
        for found, expected in (
            (t.T @ merged @ t, noc.mass_matrix(q)),
            (t.T @ merged @ t_dot + t.T @ omega @ merged @ t, noc.coriolis_matrix(q, v)),
            (-t.T @ weights, noc.gravity(q)),
        ):
            assert_allclose(found, expected, rtol=0, atol=1e-12 * np.abs(expected).max())


# Equation of motion on any robot with loops


def test_equation_of_motion_equals_constraint_dynamics(case: Case) -> None:
    """M a + C v + G = tau for Pinocchio's accelerations under random forces.

    The settings are the ones that hold for redundant closures too. C is not unique here, C v is.
    1e-9 of the forces.
    """
    rng = np.random.default_rng(6)
    settings = pin.ProximalSettings(1e-13, 1e-13, 1e-6, 100)
    constraints = case.robot.constraint_models
    constraint_data = pin.StdVec_RigidConstraintData()
    for constraint in constraints:
        constraint_data.append(constraint.createData())
    data = case.model.createData()
    for q, v, speeds in zip(case.q, case.v, case.speeds, strict=True):
        forces = rng.normal(scale=10.0, size=len(case.actuated))
        tau = np.zeros(case.model.nv)
        tau[case.actuated] = forces
        pin.initConstraintDynamics(case.model, data, constraints, constraint_data)
        joint_accelerations = pin.constraintDynamics(
            case.model, data, q, v, tau, constraints, constraint_data, settings
        )
        accelerations = joint_accelerations[case.actuated]
        noc = case.noc
        found = (
            noc.mass_matrix(q) @ accelerations + noc.coriolis_matrix(q, v) @ speeds + noc.gravity(q)
        )
        assert_allclose(found, forces, rtol=0, atol=1e-9 * np.abs(forces).max())
        assert_allclose(
            noc.inverse_dynamics(q, v, accelerations),
            forces,
            rtol=0,
            atol=1e-9 * np.abs(forces).max(),
        )


def test_equation_of_motion_equals_projected_rnea(case: Case) -> None:
    """L' RNEA(q, v, L a + L_dot s), with Pinocchio's recursion instead of twists of free bodies.

    1e-11 relative.
    """
    data = case.model.createData()
    rng = np.random.default_rng(7)
    for q, v, speeds in zip(case.q, case.v, case.speeds, strict=True):
        accelerations = rng.normal(size=len(case.actuated))
        complement, rate = case.noc.L(q), case.noc.L_dot(q, v)
        expected = complement.T @ pin.rnea(
            case.model, data, q, v, complement @ accelerations + rate @ speeds
        )
        assert_allclose(
            case.noc.inverse_dynamics(q, v, accelerations),
            expected,
            rtol=0,
            atol=1e-11 * np.abs(expected).max(),
        )
        mass = pin.crba(case.model, data, q)
        mass = np.triu(mass) + np.triu(mass, 1).T
        assert_allclose(
            case.noc.mass_matrix(q), complement.T @ mass @ complement, rtol=1e-11, atol=1e-11
        )
        gravity = complement.T @ pin.computeGeneralizedGravity(case.model, data, q)
        assert_allclose(case.noc.gravity(q), gravity, rtol=0, atol=1e-11 * np.abs(gravity).max())


def test_rate_of_the_mass_matrix_minus_twice_c_is_skew(case: Case) -> None:
    """Of any C of the form T'M(dT/dt) + T'Omega M T; rate of M by differences, 1e-8 relative."""
    rate = derivative(
        lambda t: case.noc.mass_matrix(case.robot.configuration(case.positions + t * case.speeds)),
        2e-3,
    )
    difference = rate - 2.0 * case.noc.coriolis_matrix(case.q, case.v)
    assert np.abs(difference + difference.swapaxes(-1, -2)).max() < 1e-8 * np.abs(rate).max()


def test_model_for_controllers_takes_positions_and_speeds(case: Case) -> None:
    """At the configuration that it closes itself, whatever ``robot.configuration`` says."""
    found = case.noc.equation_of_motion(case.positions, case.speeds)
    q = case.noc.configuration(case.positions)
    v = np.einsum("nij,nj->ni", case.noc.L(q), case.speeds)
    expected = (case.noc.mass_matrix(q), case.noc.coriolis_matrix(q, v), case.noc.gravity(q))
    for one, other in zip(found, expected, strict=True):
        assert_allclose(one, other, rtol=0, atol=1e-13 * np.abs(other).max())


class Astray(psp3.PSP3):
    """The 3-PSP with a closed form that takes the second nut for 10 mm higher than it is.

    Its configurations close the loops, so nothing is seen of it there.
    """

    def configuration(self, heights: Any, guess: Any = None) -> Array:
        """Return that of other heights."""
        return super().configuration(np.add(heights, [0.0, 0.010, 0.0]), guess)


def test_a_wrong_closed_form_is_not_followed(star: Case) -> None:
    """M, C and G stay those of the closed form that is right, to 1e-11 of the largest entry.

    That is the bar of the three implementations at one state; with the wrong configurations M is
    off by 1e-3 and more, which the last lines show.
    """
    robot = star.robot
    astray = Astray(
        robot.model,
        robot.constraint_models,
        robot.actuated,
        robot.q0,
        robot.visual_model,
        robot.parameters,
    )
    noc = astray.dynamics("noc")
    found = noc.equation_of_motion(star.positions, star.speeds)
    for one, other in zip(
        found, robot.equation_of_motion(star.positions, star.speeds), strict=True
    ):
        assert relative_error(one, other) < 1e-11
    wrong = astray.configuration(star.positions)
    assert np.abs(star.noc.constraint(wrong)).max() < 1e-13
    assert relative_error(star.noc.mass_matrix(wrong), found[0]) > 1e-3


def test_nothing_else_that_closes_loops_is_called(
    star: Case, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Neither the closed form nor the core, nor any of their kernels."""
    robot = psp3.load("psp3")
    noc = robot.dynamics("noc")

    def called(*arguments: Any, **more: Any) -> Any:
        raise AssertionError("another implementation was called")

    for name in (
        "configuration",
        "configurations_along",
        "closure",
        "_ask",
        "equation_of_motion",
    ):
        monkeypatch.setattr(robot, name, called)
    monkeypatch.setattr(robot, "_kernels", None)
    monkeypatch.setattr(robot, "_core", None)
    monkeypatch.setattr("psp3.multibody.core.answer", called)
    found = noc.equation_of_motion(star.positions, star.speeds)
    assert_array_equal(found[0], star.noc.equation_of_motion(star.positions, star.speeds)[0])
    forces = noc.actuator_forces(star.positions, star.speeds, np.zeros(3))
    assert (
        relative_error(
            forces, star.robot.inverse_dynamics(star.positions, star.speeds, np.zeros(3))
        )
        < 1e-11
    )
    with pytest.raises(AssertionError, match="another implementation"):
        robot.configuration(star.positions)


# Shapes


SHAPES = {
    "constraint": (False, (12,)),
    "constraint_jacobian": (False, (12, 15)),
    "L": (False, (15, 3)),
    "L_dot": (True, (15, 3)),
    "K": (False, (90, 15)),
    "K_dot": (True, (90, 15)),
    "T": (False, (90, 3)),
    "T_dot": (True, (90, 3)),
    "M_total": (False, (90, 90)),
    "Omega": (True, (90, 90)),
    "mass_matrix": (False, (3, 3)),
    "coriolis_matrix": (True, (3, 3)),
    "gravity": (False, (3,)),
}


@pytest.mark.parametrize("shape", [(), (4,), (2, 3)])
@pytest.mark.parametrize("method", SHAPES)
def test_batches_are_loops_of_singles(star: Case, method: str, shape: tuple[int, ...]) -> None:
    """Bit for bit, with all leading dimensions kept."""
    with_velocity, tail = SHAPES[method]
    count = int(np.prod(shape))
    q, v = (array[:count].reshape(*shape, 15) for array in (star.q, star.v))
    function = getattr(star.noc, method)
    result = function(q, v) if with_velocity else function(q)
    assert result.shape == (*shape, *tail)
    for index in np.ndindex(*shape):
        assert_array_equal(
            result[index], function(q[index], v[index]) if with_velocity else function(q[index])
        )


def test_an_empty_batch_keeps_its_shape(star: Case) -> None:
    empty = np.zeros((2, 0, 15))
    for method, (with_velocity, tail) in SHAPES.items():
        function = getattr(star.noc, method)
        assert (function(empty, empty) if with_velocity else function(empty)).shape == (
            2,
            0,
            *tail,
        ), method
    assert star.noc.inverse_dynamics(empty, empty, np.zeros(3)).shape == (2, 0, 3)
    assert [part.shape for part in star.noc.equation_of_motion(np.zeros((0, 3)), np.zeros(3))] == [
        (0, 3, 3),
        (0, 3, 3),
        (0, 3),
    ]


def test_one_configuration_goes_with_many_velocities(star: Case) -> None:
    q = star.q[0]
    v = star.noc.L(q) @ np.eye(3)
    result = star.noc.coriolis_matrix(q, v.T)
    assert result.shape == (3, 3, 3)
    assert_array_equal(result[1], star.noc.coriolis_matrix(q, v[:, 1]))
    assert star.noc.inverse_dynamics(q, v.T, np.zeros(3)).shape == (3, 3)


# What is refused


def gimbal(robot: psp3.PSP3) -> Array:
    """Return a configuration with a ball joint at 90 degrees, its outer axes in line.

    No closed one exists, so it is built by hand.
    """
    q = np.array(robot.configuration([0.0, 0.05, 0.1]))
    q[robot.model.joints[robot.model.getJointId("theta2")].idx_q] = 0.5 * np.pi
    return q


@pytest.mark.parametrize(
    "method", [psp3.NaturalOrthogonalComplement.L, psp3.NaturalOrthogonalComplement.T]
)
def test_a_gimbal_configuration_is_refused(star: Case, method: Any) -> None:
    with pytest.raises(SingularConfiguration, match="rank 11 of 12") as caught:
        method(star.noc, gimbal(star.robot))
    assert (caught.value.rank, caught.value.needed) == (11, 12)
    assert caught.value.condition > 1e9


@pytest.mark.parametrize("method", ["L_dot", "K_dot", "T_dot", "Omega"])
def test_a_gimbal_configuration_is_refused_with_a_velocity(star: Case, method: str) -> None:
    """Even one that would keep the loops as they are."""
    with pytest.raises(SingularConfiguration):
        getattr(star.noc, method)(gimbal(star.robot), np.zeros(15))


@pytest.mark.parametrize("method", ["mass_matrix", "gravity"])
def test_dynamics_of_a_gimbal_configuration_is_refused(star: Case, method: str) -> None:
    """It leaves the loops open, too; whichever is said, no number is returned."""
    with pytest.raises((SingularConfiguration, OpenLoops)):
        getattr(star.noc, method)(gimbal(star.robot))


@pytest.mark.parametrize("method", ["L_dot", "K_dot", "T_dot", "Omega", "coriolis_matrix"])
@pytest.mark.parametrize("size", [1.0, 1e-3, 1e-7])
def test_a_velocity_that_opens_the_loops_is_refused(star: Case, method: str, size: float) -> None:
    """A passive joint alone, or a good velocity with one entry off by a part in a million."""
    alone = size * np.eye(15)[1]
    disturbed = size * star.v[0] / np.abs(star.v[0]).max()
    disturbed[4] += 1e-6 * size
    for v in (alone, disturbed):
        with pytest.raises(InconsistentVelocity, match="L\\(q\\) @ speeds") as caught:
            getattr(star.noc, method)(star.q[0], v)
        assert caught.value.residual > caught.value.tolerance


def test_a_tiny_or_huge_velocity_of_the_right_kind_is_taken(star: Case) -> None:
    """C is linear in the speeds over eighteen decades; 1e-12 relative."""
    q, v = star.q[0], star.v[0]
    expected = star.noc.coriolis_matrix(q, v)
    for size in (1e-12, 1e6):
        assert_allclose(
            star.noc.coriolis_matrix(q, size * v) / size,
            expected,
            rtol=0,
            atol=1e-12 * np.abs(expected).max(),
        )


@pytest.mark.parametrize("method", ["mass_matrix", "gravity"])
def test_dynamics_with_open_loops_is_refused(star: Case, method: str) -> None:
    q = star.q[0].copy()
    q[4] += 1e-4
    with pytest.raises(OpenLoops, match=r"robot\.configuration") as caught:
        getattr(star.noc, method)(q)
    assert 1e-5 < caught.value.residual < 1e-3


def test_velocity_dynamics_with_open_loops_is_refused(star: Case) -> None:
    q = star.off[0]
    with pytest.raises(OpenLoops):
        star.noc.coriolis_matrix(q, star.v_off[0])
    with pytest.raises(OpenLoops):
        star.noc.inverse_dynamics(q, star.v_off[0], np.zeros(3))


@pytest.mark.parametrize(
    "bad", [np.zeros(3), np.full(15, np.nan), np.zeros((15, 1)), 1.0, None, "home"]
)
def test_malformed_vectors_are_refused_by_name(star: Case, bad: Any) -> None:
    for method in (
        "constraint",
        "constraint_jacobian",
        "L",
        "K",
        "T",
        "M_total",
        "mass_matrix",
        "gravity",
    ):
        with pytest.raises(InvalidArray, match="q must be"):
            getattr(star.noc, method)(bad)
    for method in ("L_dot", "K_dot", "T_dot", "Omega", "coriolis_matrix"):
        with pytest.raises(InvalidArray, match="v must be"):
            getattr(star.noc, method)(star.q[0], bad)


@pytest.mark.parametrize("bad", [np.zeros(15), [np.nan, 0.0, 0.0], None])
def test_malformed_accelerations_are_refused(star: Case, bad: Any) -> None:
    with pytest.raises(InvalidArray, match="accelerations"):
        star.noc.inverse_dynamics(star.q[0], star.v[0], bad)


def test_shapes_that_do_not_go_together_are_refused(star: Case) -> None:
    with pytest.raises(InvalidArray):
        star.noc.coriolis_matrix(star.q[:2], star.v[:5])
    with pytest.raises(InvalidArray):
        star.noc.equation_of_motion(star.positions[:2], star.speeds[:5])


def test_speeds_for_a_controllers_model_are_checked(star: Case) -> None:
    for bad in ([np.nan, 0.0, 0.0], np.zeros(2), "fast"):
        with pytest.raises(InvalidArray, match="speeds"):
            star.noc.equation_of_motion(np.zeros(3), bad)


def test_too_few_actuated_joints_are_refused(star: Case) -> None:
    """Two of three screws do not determine the robot."""
    robot = SimpleNamespace(
        model=star.model, constraint_models=star.robot.constraint_models, actuated=("a1", "a2")
    )
    with pytest.raises(PSP3Error):
        psp3.NaturalOrthogonalComplement(robot).L(star.q[0])


def test_too_many_actuated_joints_are_refused(star: Case) -> None:
    """Three screws and a slider cannot be driven independently.

    With four columns, L would open the loops without a word.
    """
    robot = SimpleNamespace(
        model=star.model,
        constraint_models=star.robot.constraint_models,
        actuated=("a1", "a2", "a3", "b1"),
    )
    with pytest.raises(PSP3Error):
        psp3.NaturalOrthogonalComplement(robot).mass_matrix(star.q[0])


def test_unknown_actuated_joint_is_refused(star: Case) -> None:
    robot = SimpleNamespace(
        model=star.model,
        constraint_models=star.robot.constraint_models,
        actuated=("a1", "a2", "a4"),
    )
    with pytest.raises(PSP3Error, match="a4"):
        psp3.NaturalOrthogonalComplement(robot)


def test_relative_errors_are_measured_at_all(star: Case) -> None:
    """The helper would hide every error if it returned 0."""
    assert relative_error(1.01 * star.q, star.q) == pytest.approx(0.01)
