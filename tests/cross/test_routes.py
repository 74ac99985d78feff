"""The routes of ``robot.dynamics(name)`` of every shipped robot against each other, and MuJoCo.

The natural orthogonal complement and Pinocchio's projection close the loops on constraints of their
own and share no compiled function with the robot.

All are compared relative to the largest entry of each state's array. Poses keep 5 % of home's
determinants, so that the closures' condition numbers are some hundreds at most: 1e-10 is rounding
times the square of that, which enters with the accelerations of the loops. 1e-12 is reached.
"""

from __future__ import annotations

import sys
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import psp3
from psp3.description.parts import THESIS_ROBOTS
from psp3.dynamics.projected import ProjectedDynamics
from psp3.errors import UnknownName
from psp3.robots.closed_loop_robot import ClosedLoopRobot
from tests.helpers import Array, relative_error
from tests.robot_samplers import random_poses

STATES = 500
TOLERANCE = 1e-10


class Case(NamedTuple):
    """A robot, random states of it, and what it says of them."""

    robot: ClosedLoopRobot
    positions: Array
    speeds: Array
    accelerations: Array
    matrices: tuple[Array, Array, Array]
    forces: Array

    @property
    def velocity_forces(self) -> Array:
        """C v."""
        return np.asarray(np.einsum("nij,nj->ni", self.matrices[1], self.speeds))


@pytest.fixture(scope="module", params=THESIS_ROBOTS)
def case(request: pytest.FixtureRequest) -> Case:
    robot: Any = psp3.load(str(request.param)).dynamics("core")
    # Tilted, so that the 3-RRR, which moves level, has a weight to carry as well.
    robot.model.gravity = pin.Motion(np.array([2.0, -5.0, -8.0]), np.zeros(3))
    rng = np.random.default_rng(13)
    positions = random_poses(str(request.param), STATES, rng)
    speeds, accelerations = rng.normal(size=(2, *positions.shape))
    return Case(
        robot,
        positions,
        speeds,
        accelerations,
        robot.equation_of_motion(positions, speeds),
        robot.inverse_dynamics(positions, speeds, accelerations),
    )


@pytest.mark.parametrize("name", ["pinocchio", "noc"])
def test_routes_agree(case: Case, name: str) -> None:
    """M, C v, G and the forces of a motion; C itself only where both are of Christoffel symbols."""
    model: Any = case.robot.dynamics(name)
    mass, coriolis, gravity = model.equation_of_motion(case.positions, case.speeds)
    expected_mass, expected_coriolis, expected_gravity = case.matrices
    assert relative_error(mass, expected_mass) < TOLERANCE
    assert relative_error(gravity, expected_gravity) < TOLERANCE
    velocity_forces = np.einsum("nij,nj->ni", coriolis, case.speeds)
    assert relative_error(velocity_forces, case.velocity_forces) < TOLERANCE
    if name == "pinocchio":
        assert relative_error(coriolis, expected_coriolis) < TOLERANCE
    forces = model.actuator_forces(case.positions, case.speeds, case.accelerations)
    assert relative_error(forces, case.forces) < TOLERANCE


@pytest.mark.parametrize("name", ["pinocchio", "noc"])
def test_configurations_agree(case: Case, name: str) -> None:
    """Every joint, to 1e-10 rad and m: none is in another assembly mode."""
    model: Any = case.robot.dynamics(name)
    found = model.configuration(case.positions)
    assert_allclose(found, case.robot.configuration(case.positions), rtol=0, atol=1e-10)


def test_accelerations_agree(case: Case) -> None:
    """By projection and by the whole tree's constraints, relative to what the forces alone do."""
    tree = ProjectedDynamics(case.robot)
    scale = np.abs(np.linalg.solve(case.matrices[0], case.forces[..., None])).max(axis=(1, 2))
    found = tree.forward_dynamics(case.positions, case.speeds, case.forces)
    assert (np.abs(found - case.accelerations).max(axis=1) / scale).max() < TOLERANCE
    velocities = case.robot.velocity(case.positions, case.speeds)
    for k, q in enumerate(case.robot.configuration(case.positions)):
        joints = tree.constrained_accelerations(q, velocities[k], case.forces[k])
        off = joints[tree.actuated_v] - case.accelerations[k]
        assert np.abs(off).max() < TOLERANCE * scale[k]


@pytest.mark.parametrize("name", THESIS_ROBOTS)
def test_routes_agree_with_mujoco(name: str) -> None:
    """M, C v and G of MuJoCo, projected with numpy alone, and all three routes."""
    from tests.mujoco_projection import Projection, engine

    robot: Any = psp3.load(name).dynamics("core")
    down = np.array([2.0, -5.0, -8.0])
    robot.model.gravity = pin.Motion(down, np.zeros(3))
    model = engine(name)
    model.opt.gravity[:] = down
    rng = np.random.default_rng(14)
    positions = random_poses(name, STATES, rng)
    speeds = rng.normal(size=positions.shape)
    projection, names = Projection(name, model), list(robot.model.names)[1:]
    places = [joint.idx_q for joint in list(robot.model.joints)[1:]]
    routes: list[Any] = [robot.dynamics(route) for route in ("pinocchio", "noc", "core")]
    answers = [route.equation_of_motion(positions, speeds) for route in routes]
    theirs = [
        projection.at(dict(zip(names, q[places], strict=True)), v)
        for q, v in zip(routes[0].configuration(positions), speeds, strict=True)
    ]
    assert max(state.gap for state in theirs) < 1e-10
    for mass, coriolis, gravity in answers:
        assert relative_error(mass, np.array([state.mass for state in theirs])) < TOLERANCE
        assert relative_error(gravity, np.array([state.gravity for state in theirs])) < TOLERANCE
        velocity_forces = np.einsum("nij,nj->ni", coriolis, speeds)
        expected = np.array([state.coriolis for state in theirs])
        assert relative_error(velocity_forces, expected) < TOLERANCE


def test_every_robot_has_the_routes_by_name(case: Case) -> None:
    """Each of a kind of its own, and made anew, so that two threads may each have one."""
    robot = case.robot
    assert robot.dynamics("core") is robot
    assert type(robot.dynamics("pinocchio")) is ProjectedDynamics
    assert type(robot.dynamics("noc")) is psp3.NaturalOrthogonalComplement
    assert robot.dynamics("pinocchio") is not robot.dynamics("pinocchio")
    with pytest.raises(UnknownName, match="core, pinocchio, noc"):
        robot.dynamics("closed_form")


@pytest.mark.parametrize("name", ["pinocchio", "noc"])
def test_nothing_compiled_is_called(case: Case, name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Not a bit changes where the robot cannot compute and every compiled function is gone."""
    model: Any = case.robot.dynamics(name)
    motion = case.positions[:3], case.speeds[:3], case.accelerations[:3]
    expected = model.actuator_forces(*motion)

    def called(*arguments: Any, **more: Any) -> Any:
        raise AssertionError("another implementation was called")

    replaced = 0
    for module in [module for path, module in sys.modules.items() if path.startswith("psp3")]:
        for function, value in list(vars(module).items()):
            if hasattr(value, "py_func"):
                monkeypatch.setattr(module, function, called)
                replaced += 1
    assert replaced > 10
    for method in ("configuration", "closure", "velocity", "equation_of_motion"):
        monkeypatch.setattr(case.robot, method, called)
    again: Any = case.robot.dynamics(name)
    assert_array_equal(again.actuator_forces(*motion), expected)
