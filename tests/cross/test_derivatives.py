"""Derivatives in actuated coordinates against Pinocchio's.

Its own are those of constraintDynamics, in all joints of the tree.
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest
from numpy.testing import assert_allclose

import psp3
from psp3.description.parts import THESIS_ROBOTS
from psp3.dynamics.derivatives import forward_dynamics_derivatives
from psp3.robots.closed_loop_robot import ClosedLoopRobot
from tests.helpers import Array, derivative
from tests.psp3.dynamics.test_derivatives import ball_in_a_loop, build, free_platform


def closed_as_a_whole(robot: ClosedLoopRobot) -> bool:
    """Whether Pinocchio's derivatives hold.

    They are wrong for loops closed at a point, and need independent closures.
    """
    jacobian = robot.constraint_jacobian(robot.q0)
    independent = np.linalg.matrix_rank(jacobian, tol=1e-9) == len(jacobian)
    return independent and all(
        loop.type == pin.ContactType.CONTACT_6D for loop in robot.constraint_models
    )


ROBOTS_CLOSED_AS_A_WHOLE = {
    name: robot
    for name, robot in (
        ("ball in a loop", build(ball_in_a_loop())),
        ("free platform", build(free_platform())),
        *((name, psp3.load(name)) for name in THESIS_ROBOTS),
    )
    if closed_as_a_whole(robot)
}


def test_there_are_three_at_least() -> None:
    assert {"ball in a loop", "free platform", "psp3"} <= set(ROBOTS_CLOSED_AS_A_WHOLE)


@pytest.mark.parametrize("name", ROBOTS_CLOSED_AS_A_WHOLE)
def test_derivatives_are_those_of_pinocchio_along_the_closed_loops(name: str) -> None:
    r"""Pinocchio differentiates by the configuration with all joint velocities held.

    Those follow the loops here, by differences.

    1e-8 of the largest entry: differences of the velocities leave 1e-10, the proximal step of
    constraintDynamics 1e-9.
    """
    robot = ROBOTS_CLOSED_AS_A_WHOLE[name]
    rng, n = np.random.default_rng(21), len(robot.actuated)
    model, data = robot.model, robot.model.createData()
    loops = robot.constraint_models
    states = pin.StdVec_RigidConstraintData()
    for loop in loops:
        states.append(loop.createData())
    pin.initConstraintDynamics(model, data, loops, states)
    settings = pin.ProximalSettings(1e-12, 0.0, 1)
    for _ in range(3):
        a = robot.reference + rng.uniform(-0.05, 0.05, n)
        v, forces = rng.normal(size=(2, n))
        closure = robot.closure(a)
        q, L = closure.configuration, closure.complement
        tau = np.zeros(model.nv)
        tau[robot.actuated_v] = forces
        pin.constraintDynamics(model, data, q, L @ v, tau, loops, states, settings)
        pin.computeConstraintDynamicsDerivatives(model, data, loops, states, settings)
        velocities = np.stack(
            [
                derivative(lambda t, u=unit: robot.velocity(a + t * u, v), 2e-3)  # noqa: B023
                for unit in np.eye(n)
            ],
            axis=-1,
        )
        expected: tuple[Array, ...] = (
            (data.ddq_dq @ L + data.ddq_dv @ velocities)[robot.actuated_v],
            (data.ddq_dv @ L)[robot.actuated_v],
            data.ddq_dtau[np.ix_(robot.actuated_v, robot.actuated_v)],
        )
        for found, wanted in zip(
            forward_dynamics_derivatives(robot, a, v, forces), expected, strict=True
        ):
            assert_allclose(found, wanted, rtol=0, atol=1e-8 * np.abs(wanted).max())
