"""Closure equations written out for Pinocchio: derivatives, rates, and rounded loops."""

from __future__ import annotations

from typing import Any

import numpy as np
import pinocchio as pin
import pytest

import psp3
from psp3.dynamics.more_equations import JointElements, MoreEquations
from psp3.errors import InvalidValue
from psp3.multibody.equations import Coupling, Hinge, Spin
from tests.helpers import Array, derivative
from tests.psp3.closure.rounded import four_bar, four_bar_6d, jansen, spherical


def tree() -> pin.Model:
    """Return a tree with a ball between hinges and slides."""
    model, rng = pin.Model(), np.random.default_rng(0)
    kinds = (pin.JointModelRZ(), pin.JointModelSpherical(), pin.JointModelPX(), pin.JointModelRY())
    parent = 0
    for name, kind in zip("abcd", kinds, strict=True):
        place = pin.exp6(pin.Motion(rng.uniform(-1.0, 1.0, 6)))
        parent = model.addJoint(parent, kind, place, name)
        model.appendBodyToJoint(parent, pin.Inertia.Random(), pin.SE3.Identity())
    model.addJoint(0, pin.JointModelRX(), pin.SE3.Random(), "e")
    return model


def placed(rng: np.random.Generator) -> pin.SE3:
    return pin.exp6(pin.Motion(rng.uniform(-1.0, 1.0, 6)))


RNG = np.random.default_rng(1)
EQUATIONS: dict[str, Any] = {
    "coupling": Coupling("one", 4, 1, (0.1, -0.7, 0.4, 0.2, -0.3)),
    "hinge": Hinge("two", 3, placed(RNG), 5, placed(RNG)),
    "hinge at the base": Hinge("three", 4, placed(RNG), 0, placed(RNG)),
    "spin": Spin("four", 2, np.array([0.6, 0.0, 0.8]), np.array([0.1, 0.2, 0.3, 0.9273618495])),
}


@pytest.mark.parametrize("name", list(EQUATIONS))
def test_jacobian_and_rate_are_derivatives_of_the_residual(name: str) -> None:
    """In any pose, closed or not: of eighth-order differences, to 1e-9 of numbers near 1."""
    model, rng = tree(), np.random.default_rng(2)
    data, equations = model.createData(), MoreEquations(model, [EQUATIONS[name]])

    def at(q: Array) -> tuple[Array, Array]:
        pin.computeJointJacobians(model, data, q)
        return equations.at(data, q)

    still = model.copy()
    still.gravity = pin.Motion.Zero()
    for _ in range(5):
        q = pin.integrate(model, pin.neutral(model), rng.uniform(-1.0, 1.0, model.nv))
        v = rng.uniform(-1.0, 1.0, model.nv)

        def moved(t: float, q: Array = q, v: Array = v) -> tuple[Array, Array]:
            return at(pin.integrate(model, q, t * v))

        rate = derivative(lambda t: moved(t)[0], 1e-2)
        np.testing.assert_allclose(at(q)[1] @ v, rate, rtol=0.0, atol=1e-9)
        bend = derivative(lambda t, v=v: moved(t)[1] @ v, 1e-2)
        at(q)
        pin.rnea(still, data, q, v, np.zeros(model.nv))
        found = equations.accelerations(data, q, v)
        np.testing.assert_allclose(found, bend, rtol=0.0, atol=1e-9)


def test_elements_are_those_that_a_robot_says_it_has() -> None:
    model = tree()
    model.damping = np.arange(7.0)
    model.upperDryFrictionLimit = np.full(7, 0.5)
    q = pin.neutral(model)
    v = np.array([1.0, -2.0, 0.0, 3.0, -1.0, 2.0, -2.0])
    bare = JointElements(model, None)
    assert not bare.are_there
    np.testing.assert_array_equal(bare.resistance(q, v), np.zeros(7))
    full = JointElements(model, {"c": (10.0, 0.2)})
    expected = model.damping * v + 0.5 * np.sign(v)
    expected[4] -= 2.0
    np.testing.assert_allclose(full.resistance(q, v), expected, rtol=0.0, atol=1e-15)


@pytest.mark.parametrize("digits", [8, 5])
@pytest.mark.parametrize("builder", [four_bar, four_bar_6d, jansen, spherical])
def test_rounded_loops_are_closed_alike(builder: Any, digits: int) -> None:
    """50 states, each side by least squares of its own: configurations to 1e-11.

    Forces to 1e-10 where loops join points. Where they join directions, Pinocchio's Jacobian is not
    quite the derivative of the residual that stays, and they differ by a share of the mismatch;
    0.016 of it was seen.
    """
    parts = builder(digits)
    robot = psp3.ClosedLoopRobot(parts.model, parts.loops, parts.motors)
    assert robot.closure_mismatch.length > 1e-10
    other, rng = robot.dynamics("pinocchio"), np.random.default_rng(0)
    n = len(robot.coordinates_v)
    positions = robot.reference + rng.uniform(-0.1, 0.1, (50, n))
    speeds, accelerations = rng.uniform(-1.0, 1.0, (2, 50, n))
    assert np.abs(robot.configuration(positions) - other.configuration(positions)).max() < 1e-11
    ours, theirs = (
        one.inverse_dynamics(positions, speeds, accelerations) for one in (robot, other)
    )
    error = np.abs(ours - theirs).max() / np.abs(ours).max()
    joins_directions = any(loop.type == pin.ContactType.CONTACT_6D for loop in parts.loops)
    mismatch = max(robot.closure_mismatch.length, robot.closure_mismatch.angle)
    assert error < (0.05 * mismatch if joins_directions else 1e-10)
    with pytest.raises(InvalidValue, match="rounded loops"):
        other.inverse_dynamics_derivatives(positions[0], speeds[0], accelerations[0])
