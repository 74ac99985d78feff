"""The natural orthogonal complement on robots without loops.

There Pinocchio's CRBA and RNEA give the answer directly.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import psp3
from tests.helpers import Array

robots = pytest.importorskip(
    "example_robot_data", reason="example-robot-data-loaders is in the extras test and notebooks"
)

NAMES = {
    "panda": "seven axes and a gripper of two sliders",
    "ur5": "six axes",
    "solo12": "a quadruped with a free-floating base: four branches, quaternion coordinates",
}


@pytest.fixture(scope="module", params=NAMES)
def robot(request: pytest.FixtureRequest) -> Any:
    return robots.load(request.param)


def random_state(model: pin.Model, rng: np.random.Generator) -> tuple[Array, Array, Array]:
    """Return a random configuration, a velocity and an acceleration.

    The configuration is about 1 rad per joint away from neutral.
    """
    q = pin.integrate(model, pin.neutral(model), rng.normal(size=model.nv))
    return q, rng.normal(size=model.nv), rng.normal(size=model.nv)


def test_dynamics_equal_crba_rnea_and_gravity(robot: Any) -> None:
    """Twenty random states; 1e-10 relative. C is not unique, C v is."""
    model, data = robot.model, robot.model.createData()
    noc = psp3.NaturalOrthogonalComplement(robot)
    rng = np.random.default_rng(0)
    for _ in range(20):
        q, v, a = random_state(model, rng)
        mass = pin.crba(model, data, q)
        mass = np.triu(mass) + np.triu(mass, 1).T
        gravity = np.array(pin.computeGeneralizedGravity(model, data, q))
        coriolis = pin.nonLinearEffects(model, data, q, v) - gravity
        forces = pin.rnea(model, data, q, v, a)
        assert_allclose(noc.mass_matrix(q), mass, rtol=0, atol=1e-10 * np.abs(mass).max())
        assert_allclose(
            noc.coriolis_matrix(q, v) @ v, coriolis, rtol=0, atol=1e-10 * np.abs(coriolis).max()
        )
        assert_allclose(noc.gravity(q), gravity, rtol=0, atol=1e-10 * np.abs(gravity).max())
        assert_allclose(
            noc.inverse_dynamics(q, v, a), forces, rtol=0, atol=1e-10 * np.abs(forces).max()
        )


def test_without_loops_every_joint_is_independent(robot: Any) -> None:
    """No constraints, L the unit matrix and constant, T the same as K; any velocity is taken."""
    model = robot.model
    noc = psp3.NaturalOrthogonalComplement(robot)
    q, v, _ = random_state(model, np.random.default_rng(1))
    assert noc.constraint(q).shape == (0,)
    assert noc.constraint_jacobian(q).shape == (0, model.nv)
    assert_array_equal(noc.L(q), np.eye(model.nv))
    assert_array_equal(noc.L_dot(q, v), np.zeros((model.nv, model.nv)))
    assert_array_equal(noc.T(q), noc.K(q))
    assert_array_equal(noc.T_dot(q, v), noc.K_dot(q, v))
    assert len(noc.body_names) == model.njoints - 1


def test_rate_of_the_mass_matrix_minus_twice_c_is_skew(robot: Any) -> None:
    """With dM/dt by central differences of second order along q + v t on the manifold.

    1e-6 relative at steps of 1e-5.
    """
    model = robot.model
    noc = psp3.NaturalOrthogonalComplement(robot)
    q, v, _ = random_state(model, np.random.default_rng(2))
    step = 1e-5
    rate = (
        noc.mass_matrix(pin.integrate(model, q, step * v))
        - noc.mass_matrix(pin.integrate(model, q, -step * v))
    ) / (2 * step)
    difference = rate - 2.0 * noc.coriolis_matrix(q, v)
    assert np.abs(difference + difference.T).max() < 1e-6 * np.abs(rate).max()


def test_closed_loop_robot_takes_an_arm_too() -> None:
    """The Pinocchio path without loops; 1e-10 relative."""
    model = robots.load("ur5").model
    arm = psp3.ClosedLoopRobot(model, [], list(model.names)[1:])
    q, v, a = random_state(model, np.random.default_rng(3))
    forces = pin.rnea(model, model.createData(), q, v, a)
    assert_allclose(
        arm.inverse_dynamics(q, v, a), forces, rtol=0, atol=1e-10 * np.abs(forces).max()
    )
    assert_allclose(arm.forward_dynamics(q, v, forces), a, rtol=0, atol=1e-10 * np.abs(a).max())
