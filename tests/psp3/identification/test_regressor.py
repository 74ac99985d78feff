"""The regressor: forces are linear in the standard parameters, of every shipped robot."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

import psp3
from psp3.description.parts import THESIS_ROBOTS
from psp3.errors import InvalidArray
from psp3.identification.regressor import (
    PARAMETERS_OF_A_BODY,
    parameter_names,
    regressor,
    standard_parameters,
)
from tests.helpers import Array
from tests.robot_samplers import random_poses


def random_motions(name: str, count: int, seed: int = 0) -> tuple[Array, Array, Array]:
    rng = np.random.default_rng(seed)
    positions = random_poses(name, count, rng)
    return positions, rng.normal(size=positions.shape), 5.0 * rng.normal(size=positions.shape)


@pytest.mark.parametrize("name", THESIS_ROBOTS)
def test_times_the_parameters_is_the_inverse_dynamics(name: str) -> None:
    """Independent route: RNEA, and the closed form of the 3-PSP.

    To 1e-10 of the largest force, which is some hundred ulps.
    """
    robot = psp3.load(name)
    motion = random_motions(name, 20)
    forces = regressor(robot, *motion) @ standard_parameters(robot)
    expected = robot.inverse_dynamics(*motion)
    np.testing.assert_allclose(
        forces, expected, rtol=0.0, atol=1e-10 * max(1.0, float(np.abs(expected).max()))
    )


@pytest.mark.parametrize("name", ["five_bar", "tricept"])
def test_each_column_is_the_force_that_its_parameter_makes(name: str) -> None:
    """Brute force: one parameter of one body is changed in a copy of the model.

    The copy's RNEA shares no regressor.
    """
    robot = psp3.load(name)
    motion = random_motions(name, 3)
    columns = regressor(robot, *motion)
    before = robot.inverse_dynamics(*motion)
    rng = np.random.default_rng(1)
    for index in rng.choice(columns.shape[-1], 12, replace=False):
        body, parameter = int(1 + index // 10), int(index % 10)
        model = robot.model.copy()
        changed = np.array(model.inertias[body].toDynamicParameters())
        # A body without mass can have no first moments in Pinocchio; those drawn here have mass.
        step = 0.5
        changed[parameter] += step
        model.inertias[body] = pin.Inertia.FromDynamicParameters(changed)
        other = psp3.ClosedLoopRobot(model, robot.constraint_models, robot.actuated, robot.q0)
        difference = (other.inverse_dynamics(*motion) - before) / step
        np.testing.assert_allclose(
            columns[..., index], difference, atol=1e-10 * max(1.0, float(np.abs(before).max()))
        )


def test_names_follow_the_joints_and_the_order_of_pinocchio() -> None:
    robot = psp3.load("psp3")
    names, values = parameter_names(robot), standard_parameters(robot)
    assert len(names) == len(values) == 150
    assert names[:3] == ("m(a1)", "mx(a1)", "my(a1)")
    assert len(PARAMETERS_OF_A_BODY) == 10
    known = dict(zip(names, values, strict=True))
    p = robot.parameters
    assert known["m(a2)"] == p.nut_mass
    assert known["m(theta3)"] == p.ball_mass
    # The star's third is a body at the end of the arm: its inertia about the slider's origin is in
    # star axes about the center otherwise.
    center = robot.model.frames[robot.model.getFrameId("star1_center")].placement.translation
    assert known["mx(b1)"] == pytest.approx(p.star_mass / 3.0 * center[0], abs=1e-15)
    for name, index in (("Ixx(phi1)", 0), ("Iyy(phi1)", 1), ("Izz(phi1)", 2)):
        assert (
            known[name]
            == [p.ball_transverse_inertia, p.ball_axial_inertia, p.ball_transverse_inertia][index]
        )


def test_shapes_broadcast() -> None:
    robot = psp3.load("five_bar")
    motion = random_motions("five_bar", 6)
    whole = regressor(
        robot, motion[0].reshape(2, 3, 2), motion[1].reshape(2, 3, 2), motion[2].reshape(2, 3, 2)
    )
    assert whole.shape == (2, 3, 2, 40)
    np.testing.assert_array_equal(whole[1, 2], regressor(robot, *(part[5] for part in motion)))
    still = regressor(robot, motion[0], np.zeros(2), np.zeros(2))
    assert still.shape == (6, 2, 40)


@pytest.mark.parametrize("bad", [np.array([0.0, np.nan]), np.zeros(3), "text", 0.0])
@pytest.mark.parametrize("which", [0, 1, 2])
def test_bad_motions_are_refused(which: int, bad: object) -> None:
    robot = psp3.load("five_bar")
    arguments: list[object] = [robot.reference, np.zeros(2), np.zeros(2)]
    arguments[which] = bad
    with pytest.raises(InvalidArray):
        regressor(robot, *arguments)  # type: ignore[arg-type]
