"""The compiled step of computed torque on a frame, against NumPy, Pinocchio and the step in Python.

That step takes its Jacobian and its accelerations from Pinocchio and singular values from LAPACK.
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest
from numpy.testing import assert_allclose

import psp3
from psp3.control.task_space import TaskSpaceComputedTorque
from psp3.control.task_space_kernels import make_orthogonal, write_rotation_between
from psp3.trajectories import Helix, Motion
from tests.helpers import Array
from tests.psp3.control.test_task_space import HEIGHT, ROBOT, TASKS
from tests.psp3.export.controller_in_c import CompiledStep

NO_TIP = np.full(3, np.nan)


def near_the_reference(
    robot: psp3.ClosedLoopRobot, rng: np.random.Generator
) -> tuple[Array, Array]:
    """Return positions and speeds of the coordinates, whose motors may be others."""
    n = len(robot.coordinates)
    return robot.reference + rng.uniform(-0.03, 0.03, n), rng.uniform(-0.3, 0.3, n)


@pytest.mark.parametrize("n", range(1, 7))
def test_singular_values_and_vectors_are_those_of_lapack(n: int) -> None:
    """Of full, nearly singular and badly scaled matrices; ten roundings of the largest value."""
    rng = np.random.default_rng(n)
    for scale in (1.0, 1e-8, 1e8):
        matrix = rng.normal(size=(n, n))
        matrix[:, -1] *= scale
        columns, right = np.ascontiguousarray(matrix.T), np.empty((n, n))
        make_orthogonal(columns, right)
        found = np.sort(np.linalg.norm(columns, axis=1))[::-1]
        expected = np.linalg.svd(matrix, compute_uv=False)
        assert_allclose(found, expected, rtol=0.0, atol=1e-14 * expected[0])
        assert_allclose(right @ right.T, np.eye(n), atol=1e-14)
        assert_allclose(matrix @ right.T, columns.T, atol=1e-14 * expected[0])
        assert np.linalg.det(right) == pytest.approx(1.0)


@pytest.mark.parametrize("angle", [0.0, 1e-12, 1e-5, 0.3, 2.0, 3.0, np.pi - 1e-7])
def test_the_rotation_between_two_frames_is_the_vector_that_it_was_made_of(angle: float) -> None:
    """About all axes: some roundings, of matrices whose entries are 1."""
    rng = np.random.default_rng(0)
    for axis in (*np.eye(3), *-np.eye(3), *rng.normal(size=(20, 3))):
        vector = angle * axis / np.linalg.norm(axis)
        found = pin.exp3(rng.normal(size=3))
        out = np.full(5, 7.0)
        write_rotation_between((pin.exp3(vector) @ found).ravel(), found.ravel(), out, 1)
        assert_allclose(out[1:4], vector, atol=3e-15)
        assert out[0] == out[4] == 7.0


@pytest.mark.parametrize("name", [*TASKS, "planar_4rrr"])
def test_forces_are_those_of_the_step_in_python(name: str) -> None:
    """At states where nothing is damped: loops are closed to 1e-11, forces are of some 100 N."""
    robot, rng = psp3.load(name), np.random.default_rng(1)
    task = TASKS.get(name, TASKS["planar_3rrr"])
    controller = TaskSpaceComputedTorque(robot, 25.0, 4.0, task=task)
    compiled = CompiledStep(controller, robot)
    for _ in range(20):
        (positions, speeds), (goal, rates) = (near_the_reference(robot, rng) for _ in range(2))
        desired = Motion(goal, rates, rng.normal(size=len(goal)), NO_TIP)
        expected = controller.torque(0.0, positions, speeds, desired)
        done, found = compiled.step(0.0, positions, speeds, np.concatenate(desired[:3]))
        assert done
        assert_allclose(found, expected, atol=1e-8 * np.abs(expected).max())


def test_forces_near_the_border_are_those_of_the_step_in_python() -> None:
    """On both sides of the fold, to and from it, at rest and at speed.

    Differences of differences over 1e-4 of the robot's length leave 8 of 16 digits, which the
    correction is of; forces are of some 100 N.
    """
    controller, rng = TaskSpaceComputedTorque(ROBOT, 100.0, 20.0), np.random.default_rng(2)
    compiled, damped = CompiledStep(controller, ROBOT), 0
    for tilt in np.radians(np.linspace(30.0, 40.0, 21)):
        for speed in (-0.5, 0.0, 0.5):
            positions, ahead = (
                ROBOT.inverse_kinematics(0.3, angle, 0.0) for angle in (tilt, tilt + 1e-4)
            )
            speeds = speed * (ahead - positions) / 1e-4
            goal = ROBOT.inverse_kinematics_tip([0.02, 0.001, HEIGHT])
            desired = Motion(goal, *rng.normal(0.0, 0.1, (2, 3)), NO_TIP)
            expected = controller.torque(0.0, positions, speeds, desired)
            done, found = compiled.step(0.0, positions, speeds, np.concatenate(desired[:3]))
            assert done
            assert_allclose(found, expected, atol=2e-5 * np.abs(expected).max())
            least = np.linalg.svd(ROBOT.tip_jacobian(positions), compute_uv=False)[-1]
            damped += least < controller.threshold
    assert 10 < damped < 63


def test_a_pose_out_of_reach_has_no_forces() -> None:
    robot = psp3.load("five_bar")
    compiled = CompiledStep(TaskSpaceComputedTorque(robot, task=TASKS["five_bar"]), robot)
    home, rest = robot.reference, np.zeros(2)
    far = np.concatenate([home + np.array([2.0, -2.0]), rest, rest])
    done, found = compiled.step(0.0, home, rest, far)
    assert not done
    assert np.isnan(found).all()


def test_the_compiled_run_is_the_run_in_python() -> None:
    """A class of one's own is steered in Python; a rounding grows little in 0.2 s."""

    class Own(TaskSpaceComputedTorque):
        pass

    helix = Helix(robot=ROBOT)
    runs = [
        psp3.simulate(ROBOT, kind(ROBOT, 100.0, 20.0), helix, 0.2)
        for kind in (TaskSpaceComputedTorque, Own)
    ]
    assert_allclose(runs[0].torque, runs[1].torque, atol=1e-8)
    assert Own(ROBOT).table(None, None) is None
