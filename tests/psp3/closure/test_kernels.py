"""Compiled closures of loops against Pinocchio, differences and least squares."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pinocchio as pin
import pytest
from numpy.testing import assert_allclose
from psp3.closure.kernels import _solve, jacobian
from scipy.spatial.transform import Rotation

import psp3
from psp3.closure import NO_MOTORS, flattened, residual
from psp3.robots.closed_loop_robot import ClosedLoopRobot
from tests.helpers import Array, derivative
from tests.psp3.closure.linkages import away


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


def test_steps_as_small_as_rounding_are_taken() -> None:
    """An integrator that starts at rest asks for poses 1e-17 from the reference.

    A correction larger than the step is rounding there.
    """
    robot, rng = psp3.load("delta"), np.random.default_rng(13)
    for size in 10.0 ** rng.uniform(-20.0, -8.0, 200):
        robot.closure(robot.reference + size * rng.normal(size=3))
