"""A payload against the definition of its energies.

Against the closed form's star, and against weighing the robot.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pinocchio as pin
import pytest

import psp3
from psp3.errors import InvalidArray, InvalidValue, UnknownName
from psp3.robots.payloads import with_payload
from psp3.simulation.runge_kutta import RungeKutta
from tests.helpers import random_heights

ROBOT = psp3.load("psp3")
MOMENTS = np.array([0.01, 0.02, 0.025])


def states(count: int) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(3)
    return random_heights(rng, count), rng.normal(size=(count, 3))


def test_energies_are_those_of_robot_and_payload() -> None:
    """Tip Jacobian, rotation and height from the closed form, energies written out.

    1e-12 relative is the closure's rounding.
    """
    heavy = with_payload(ROBOT, 2.5, MOMENTS)
    heights, speeds = states(20)
    pose, jacobian = ROBOT.forward_kinematics(heights), ROBOT.tip_jacobian(heights)
    spin = ROBOT.dynamics(
        "core"
    ).frame_jacobian(  # type: ignore[attr-defined]
        heights, "tip"
    )[:, 3:]
    velocity, rate = (np.einsum("nij,nj->ni", one, speeds) for one in (jacobian, spin))
    own = np.einsum("nji,nj->ni", pose.rotation, rate)
    kinetic = (
        ROBOT.kinetic_energy(heights, speeds)
        + 0.5 * 2.5 * (velocity**2).sum(axis=1)
        + 0.5 * (own**2) @ MOMENTS
    )
    potential = ROBOT.potential_energy(heights) + 2.5 * 9.81 * pose.tip[:, 2]
    np.testing.assert_allclose(heavy.kinetic_energy(heights, speeds), kinetic, rtol=1e-12)
    np.testing.assert_allclose(heavy.potential_energy(heights), potential, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(
        heavy.gravity(heights).sum(axis=1), (ROBOT.parameters.total_mass + 2.5) * 9.81, rtol=1e-12
    )


def test_at_the_stars_center_it_is_a_heavier_star() -> None:
    """M, C and G of the closed form with other parameters, to 1e-9.

    Both ways agree to that without a payload.
    """
    inertia = tuple((np.array(ROBOT.parameters.star_inertia) + MOMENTS).tolist())
    star = psp3.load("psp3", psp3.Parameters(star_mass=1.758 + 2.5, star_inertia=inertia))
    heights, speeds = states(20)
    # The star's first arm is at home along base x, so the frame's axes are the star's.
    found = with_payload(ROBOT, 2.5, MOMENTS, "star1_center").equation_of_motion(heights, speeds)
    for one, other in zip(found, star.equation_of_motion(heights, speeds), strict=True):
        np.testing.assert_allclose(one, other, rtol=0.0, atol=1e-9 * np.abs(other).max())


def test_a_controller_that_does_not_know_of_it_sags() -> None:
    """PD with the model's gravity, at rest.

    Every screw by a third of the payload's weight over kp; 1e-6 m of motion are left at 4 s.
    """
    plant = RungeKutta(with_payload(ROBOT, 3.0))
    hold = psp3.trajectories.Hold(robot=ROBOT)
    result = psp3.simulate(
        ROBOT, psp3.GravityCompensatedPD(ROBOT, 1000.0, 300.0), hold, 4.0, 0.01, plant=plant
    )
    np.testing.assert_allclose(
        result.heights[-1], hold(0.0).heights - 3.0 * 9.81 / 3.0 / 1000.0, atol=1e-6
    )


def test_the_robot_itself_stays_as_it_is() -> None:
    before = ROBOT.dynamics("pinocchio").gravity(np.zeros(3))  # type: ignore[attr-defined]
    with_payload(ROBOT, 5.0)
    np.testing.assert_array_equal(
        ROBOT.dynamics("pinocchio").gravity(np.zeros(3)),  # type: ignore[attr-defined]
        before,
    )


@pytest.mark.parametrize("name", ["five_bar", "gough_stewart"])
def test_other_robots_carry_payloads(name: str) -> None:
    """Gravity is the gradient of the potential energy: J' m g on top of the robot's own.

    1e-11 relative.
    """
    robot = psp3.load(name)
    positions = robot.reference + 0.01
    weight = 4.0 * -robot.model.gravity.linear
    expected = robot.gravity(positions) + robot.frame_jacobian(positions, "tip")[:3].T @ weight
    np.testing.assert_allclose(
        with_payload(robot, 4.0).gravity(positions), expected, rtol=1e-11, atol=1e-11
    )


def test_moments_are_along_the_axes_of_the_frame() -> None:
    """A frame that is turned in its body: M grows by the formula, with R of the frame in the base.

    The Jacobian and the rotation are Pinocchio's. 1e-11 of the largest entry is rounding.
    """
    robot = psp3.load("gough_stewart")
    model = robot.model.copy()
    tip = model.frames[model.getFrameId("tip")]
    turned = pin.SE3(pin.utils.rpyToMatrix(0.4, -0.9, 1.3), np.array([0.02, -0.03, 0.05]))
    model.addFrame(
        pin.Frame("gripper", tip.parentJoint, tip.placement * turned, pin.FrameType.OP_FRAME)
    )
    held = psp3.ClosedLoopRobot(model, robot.constraint_models, robot.actuated, robot.q0)
    moments, mass = np.array([0.1, 0.2, 0.29]), 1.5
    positions = held.reference + 0.01 * np.arange(6)
    data = model.createData()
    pin.framesForwardKinematics(model, data, held.configuration(positions))
    rotation = data.oMf[model.getFrameId("gripper")].rotation
    jacobian = held.frame_jacobian(positions, "gripper")
    inertia = rotation @ np.diag(moments) @ rotation.T
    expected = (
        held.mass_matrix(positions)
        + mass * jacobian[:3].T @ jacobian[:3]
        + jacobian[3:].T @ inertia @ jacobian[3:]
    )
    found = with_payload(held, mass, moments, "gripper").mass_matrix(positions)
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-11 * np.abs(expected).max())
    # Along other axes it would be another matrix, by far.
    as_the_body = jacobian[3:].T @ (inertia - np.diag(moments)) @ jacobian[3:]
    assert np.abs(as_the_body).max() > 1e-3 * np.abs(expected).max()


@pytest.mark.parametrize(
    ("arguments", "error"),
    [
        ({"mass": -1.0}, InvalidValue),
        ({"mass": np.nan}, InvalidValue),
        ({"mass": 1.0, "inertia": [1.0, 1.0]}, InvalidArray),
        ({"mass": 1.0, "inertia": [-0.1, 0.1, 0.1]}, InvalidValue),
        ({"mass": 1.0, "inertia": [0.1, 0.1, 0.3]}, InvalidValue),
        ({"mass": 1.0, "frame": "hand"}, UnknownName),
        ({"mass": 1.0, "frame": "universe"}, InvalidValue),
    ],
)
def test_bad_payloads_are_refused(arguments: dict[str, Any], error: type[Exception]) -> None:
    with pytest.raises(error):
        with_payload(ROBOT, **arguments)
