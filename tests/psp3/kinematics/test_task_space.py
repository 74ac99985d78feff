"""Motion of a frame: against differences of its placement, closed forms, and rotations of SciPy."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

import psp3
from psp3.errors import InvalidValue, UnknownName
from psp3.kinematics.frames import frame_motion
from psp3.kinematics.task_space import TaskSpace, square_task
from tests.helpers import random_states
from tests.psp3.kinematics.motions import swing

ROBOT = psp3.load()


def test_state_has_the_rows_of_the_task() -> None:
    """J speeds is the velocity, and drift the acceleration at constant speeds.

    In the order that is asked for.
    """
    robot = psp3.load("gough_stewart")
    positions, speeds, _ = swing(robot)(0.0)
    state = TaskSpace(robot, "tip", ("rz", "x")).state(positions, speeds)
    motion = frame_motion(robot, positions, speeds, np.zeros(6))
    assert_allclose(state.velocity, motion.velocity[[5, 0]], atol=1e-13)
    assert_allclose(state.drift, motion.acceleration[[5, 0]], atol=1e-13)
    assert_allclose(state.jacobian @ speeds, state.velocity, atol=1e-12)
    assert_allclose(state.jacobian, robot.frame_jacobian(positions, "tip")[[5, 0]], atol=1e-12)


@pytest.mark.parametrize("task", [("x", "y", "z"), ("z", "x"), ("y", "rx")])
def test_jacobian_of_the_3_psp_does_not_depend_on_the_way_it_is_found(
    task: tuple[str, ...],
) -> None:
    """Positions of the tip have a closed form, angles go through the tree; 1e-11."""
    heights, _ = random_states(np.random.default_rng(3), 5)
    rows = [("x", "y", "z", "rx", "ry", "rz").index(name) for name in task]
    for row in heights:
        assert_allclose(
            TaskSpace(ROBOT, "tip", task).jacobian(row),
            ROBOT.frame_jacobian(row, "tip")[rows],
            atol=1e-11,
        )


def test_error_is_a_distance_and_the_turn_that_is_left() -> None:
    """SciPy's rotation vectors; applied to the actual orientation the turn gives the desired one.

    To 1e-12.
    """
    space = TaskSpace(ROBOT, "tip", ("x", "y", "z", "rx", "ry", "rz"))
    rng = np.random.default_rng(0)
    for _ in range(20):
        desired, actual = np.eye(4), np.eye(4)
        desired[:3, 3], actual[:3, 3] = rng.normal(size=(2, 3))
        turns = Rotation.from_rotvec(rng.normal(size=(2, 3)))
        desired[:3, :3], actual[:3, :3] = turns.as_matrix()
        error = space.error(desired, actual)
        assert_allclose(error[:3], desired[:3, 3] - actual[:3, 3])
        assert_allclose(error[3:], (turns[0] * turns[1].inv()).as_rotvec(), atol=1e-12)
        assert_allclose(
            Rotation.from_rotvec(error[3:]).as_matrix() @ actual[:3, :3],
            desired[:3, :3],
            atol=1e-12,
        )


# What is refused


def test_unknown_names_are_refused() -> None:
    with pytest.raises(UnknownName, match="'tipp'"):
        frame_motion(ROBOT, np.zeros(3), np.zeros(3), np.zeros(3), "tipp")
    with pytest.raises(UnknownName, match="'w'"):
        TaskSpace(ROBOT, "tip", ("x", "w"))
    with pytest.raises(InvalidValue, match="each once"):
        TaskSpace(ROBOT, "tip", ("x", "x"))
    with pytest.raises(InvalidValue, match="as many coordinates"):
        square_task(ROBOT, "tip", ("x", "y"))
