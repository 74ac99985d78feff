"""Robots driven at their end effector.

Against closed-form inverse kinematics, and the transformed equation of motion.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import psp3
from psp3.errors import ClosureFailed, InvalidArray, InvalidValue, UnknownName
from psp3.kinematics.task_driven import TaskDrivenRobot, without_limits
from psp3.kinematics.tasks import TASK_COORDINATES
from psp3.robots.closed_loop_robot import ClosedLoopRobot
from tests.closed_form_kinematics import FiveBar, GoughStewart
from tests.helpers import Array
from tests.robot_samplers import WORKSPACES, reachable

TASKS = {
    "five_bar": ("x", "z"),
    "planar_3rrr": ("x", "y", "rz"),
    "delta": ("x", "y", "z"),
    "gough_stewart": TASK_COORDINATES,
    "tricept": ("x", "y", "z"),
}


@pytest.fixture(scope="module")
def robots() -> dict[str, ClosedLoopRobot]:
    return {name: psp3.load(name) for name in TASKS}


@pytest.fixture(scope="module")
def driven(robots: dict[str, ClosedLoopRobot]) -> dict[str, ClosedLoopRobot]:
    return {name: TaskDrivenRobot(robot, "tip", TASKS[name]) for name, robot in robots.items()}


def turned_about_base_axes(angles: Array) -> Array:
    """Rotations about x first, then y, then z, by Pinocchio's elementary ones."""
    return np.array(
        [
            pin.utils.rotate("z", c) @ pin.utils.rotate("y", b) @ pin.utils.rotate("x", a)
            for a, b, c in angles
        ]
    )


@pytest.mark.parametrize("name", [name for name in TASKS if name != "gough_stewart"])
def test_motors_are_where_closed_form_inverse_kinematics_puts_them(
    name: str, robots: dict[str, ClosedLoopRobot], driven: dict[str, ClosedLoopRobot]
) -> None:
    """From the reference pose, in its working mode, to 50 poses of the sampler.

    1e-10: Newton's 1e-13 and the robots' conditions.
    """
    sample = reachable(name, 50, np.random.default_rng(4))
    q = driven[name].configuration(sample.poses)
    assert_allclose(q[:, robots[name].actuated_q], sample.positions, atol=1e-10)


def test_legs_of_the_gough_stewart_platform(
    robots: dict[str, ClosedLoopRobot], driven: dict[str, ClosedLoopRobot]
) -> None:
    """Its angles are not those of the sampler, so the lengths are computed from the rotation.

    Tolerance as above.
    """
    rng = np.random.default_rng(6)
    poses = driven["gough_stewart"].reference + rng.uniform(-1.0, 1.0, size=(50, 6)) * [
        0.1,
        0.1,
        0.1,
        0.4,
        0.4,
        0.6,
    ]
    lengths = GoughStewart().lengths(poses[:, :3], turned_about_base_axes(poses[:, 3:]))
    q = driven["gough_stewart"].configuration(poses)
    assert_allclose(q[:, robots["gough_stewart"].actuated_q], lengths, atol=1e-10)


@pytest.mark.parametrize("name", TASKS)
def test_configurations_hold_the_robots_own_and_the_frames_coordinates(
    name: str, robots: dict[str, ClosedLoopRobot], driven: dict[str, ClosedLoopRobot]
) -> None:
    robot, other = robots[name], driven[name]
    assert_allclose(other.q0[: robot.model.nq], robot.q0, atol=1e-13)
    assert other.actuated == tuple(f"task_{coordinate}" for coordinate in TASKS[name])
    q = other.configuration(
        other.reference
        + np.random.default_rng(8).uniform(-0.02, 0.02, size=(3, other.reference.size))
    )
    assert_allclose(other.completed(q[:, : robot.model.nq]), q, atol=1e-11)
    # Going back by the motors, in the assembly mode of the reference.
    assert_allclose(robot.configuration(q[:, robot.actuated_q]), q[:, : robot.model.nq], atol=1e-9)


def test_angles_are_about_fixed_axes() -> None:
    """About the fixed x, then the fixed y.

    The star's axis has the height that the two rotations give it.

    What the star needs of a turn about z, to be without torsion, comes last and does not change
    that. Rounding.
    """
    robot = psp3.load("psp3")
    q = TaskDrivenRobot(robot, "tip", ("rx", "ry", "z")).configuration([0.3, -0.2, 0.1])
    pose = robot.forward_kinematics(q[robot.actuated_q])
    assert_allclose(
        pose.rotation[2], (pin.utils.rotate("y", -0.2) @ pin.utils.rotate("x", 0.3))[2], atol=1e-11
    )
    assert_allclose(pose.tip[2], 0.1, atol=1e-11)


@pytest.mark.parametrize("name", ["five_bar", "planar_3rrr", "delta", "tricept"])
def test_dynamics_are_those_of_the_robot_seen_from_the_frame(
    name: str, robots: dict[str, ClosedLoopRobot], driven: dict[str, ClosedLoopRobot]
) -> None:
    """O. Khatib's inertia J^-T M J^-1 and forces J^-T G: two robots, two sets of loops.

    1e-9 for the conditions of J.
    """
    robot, other = robots[name], driven[name]
    target = other.reference + np.random.default_rng(9).uniform(-0.02, 0.02, other.reference.size)
    positions = other.configuration(target)[robot.actuated_q]
    rows = [TASK_COORDINATES.index(one) for one in TASKS[name]]
    inverse = np.linalg.inv(robot.frame_jacobian(positions, "tip")[rows])
    mass = inverse.T @ robot.mass_matrix(positions) @ inverse
    assert_allclose(other.mass_matrix(target), mass, atol=1e-9 * np.abs(mass).max())
    weight = inverse.T @ robot.gravity(positions)
    assert_allclose(other.gravity(target), weight, atol=1e-9 * max(np.abs(weight).max(), 1.0))


def test_it_goes_through_singularities_of_actuation(
    robots: dict[str, ClosedLoopRobot], driven: dict[str, ClosedLoopRobot]
) -> None:
    """The point of the five-bar is lifted through the line of its rods.

    From below both elbows to above, with the closed form's cranks.
    """
    path = np.column_stack([np.zeros(60), np.linspace(-0.3, 0.3, 60)])
    robot = robots["five_bar"]
    positions = driven["five_bar"].configurations_along(path)[:, robot.actuated_q]
    assert_allclose(np.cos(positions - FiveBar().inverse(path)), 1.0, atol=1e-12)
    height = FiveBar().elbows(positions)[..., 1] - path[:, 1:]
    assert (height[0] > 0.0).all()
    assert (height[-1] < 0.0).all()


@pytest.mark.parametrize(("task", "order"), [(("x", "z", "rx"), "xzy"), (("y", "z", "ry"), "yzx")])
def test_a_single_angle_is_the_last_turn_about_its_fixed_axis(
    task: tuple[str, ...], order: str
) -> None:
    """So it is the first hinge from the base, and the other two follow.

    The rotation away from the reference is the product of the three in that order, and in another
    order it is another rotation by far.
    """
    star = psp3.load("psp3")
    driven = TaskDrivenRobot(star, "tip", task)
    q = star.configuration([0.06, -0.05, 0.02])
    whole = driven.completed(q)
    angle = {
        axis: whole[driven.model.joints[driven.model.getJointId(f"task_r{axis}")].idx_q]
        for axis in "xyz"
    }
    hinges = [pin.utils.rotate(axis, float(angle[axis])) for axis in order]
    data = star.model.createData()
    rotations = []
    for configuration in (q, star.q0):
        pin.framesForwardKinematics(star.model, data, configuration)
        rotations.append(data.oMf[star.model.getFrameId("tip")].rotation.copy())
    away = rotations[0] @ rotations[1].T
    assert_allclose(hinges[0] @ hinges[1] @ hinges[2], away, atol=1e-12)
    assert np.abs(hinges[2] @ hinges[1] @ hinges[0] - away).max() > 1e-2


def test_tip_of_the_3_psp_as_in_closed_form() -> None:
    """Against the inverse kinematics of the tip, on the branch of home."""
    robot = psp3.load("psp3")
    rng = np.random.default_rng(10)
    angle, radius = rng.uniform(-np.pi, np.pi, 30), rng.uniform(0.0, 0.02, 30)
    tips = np.column_stack(
        [radius * np.cos(angle), radius * np.sin(angle), rng.uniform(0.0, 0.2, 30)]
    )
    q = TaskDrivenRobot(robot, "tip", ("x", "y", "z")).configuration(tips)
    assert_allclose(q[:, robot.actuated_q], robot.inverse_kinematics_tip(tips), atol=1e-10)


def test_without_limits_leaves_the_model_alone(robots: dict[str, ClosedLoopRobot]) -> None:
    model = robots["five_bar"].model
    before = model.lowerPositionLimit.copy()
    free = without_limits(model)
    assert (free.upperPositionLimit - free.lowerPositionLimit == np.inf).all()
    assert_array_equal(model.lowerPositionLimit, before)


@pytest.mark.parametrize(
    ("task", "frame", "error", "match"),
    [
        (("x", "z", "rx"), "tip", InvalidValue, "as many coordinates"),
        (("x",), "tip", InvalidValue, "as many coordinates"),
        (("x", "y"), "tip", InvalidValue, "can still move"),
        (("x", "z"), "moon", UnknownName, "moon"),
        (("x", "height"), "tip", UnknownName, "height"),
        (("x", "x"), "tip", InvalidValue, "each once"),
        (("x", "z"), "universe", InvalidValue, "can still move"),
    ],
)
def test_tasks_that_do_not_drive_the_robot_are_refused(
    task: tuple[str, ...],
    frame: str,
    error: type[Exception],
    match: str,
    robots: dict[str, ClosedLoopRobot],
) -> None:
    with pytest.raises(error, match=match):
        TaskDrivenRobot(robots["five_bar"], frame, task)


@pytest.mark.parametrize(
    ("call", "error"),
    [
        (lambda robot: robot.completed([0.0]), InvalidArray),
        (lambda robot: robot.completed(np.full(4, np.inf)), InvalidArray),
        (lambda robot: robot.configuration([0.0, -0.6]), ClosureFailed),
    ],
)
def test_bad_input_is_refused(
    call: Callable[[Any], object], error: type[Exception], driven: dict[str, ClosedLoopRobot]
) -> None:
    with pytest.raises(error):
        call(driven["five_bar"])


def test_every_sampler_has_the_coordinates_of_its_task() -> None:
    assert {name: space.home.size for name, space in WORKSPACES.items()} == {
        name: len(task) for name, task in TASKS.items()
    }
