"""Trajectories.

Rates against finite differences, paths against their equations, and what is refused.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import psp3
from psp3 import trajectories
from psp3.errors import (
    ClosureFailed,
    InvalidArray,
    InvalidValue,
    StrokeExceeded,
    UnknownName,
)
from tests.helpers import four_bar_closed_with_6d
from tests.psp3.trajectories.points import HOME, NAMES, NEAR


@pytest.mark.parametrize("name", NAMES)
def test_rates_are_the_derivatives_of_the_heights(
    name: str, every_trajectory: dict[str, trajectories.Trajectory]
) -> None:
    """Five-point central differences, h = 1e-3 s.

    Truncation h⁴ times the fifth derivative (about 300 m/s⁵ here) stays below 1e-7.
    """
    trajectory = every_trajectory[name]
    # Times away from the knots of the splines, where the third derivative jumps.
    t, h = np.arange(0.055, 1.95, 0.1) + 0.003, 1e-3

    def slope(values: list[np.ndarray]) -> np.ndarray:
        return (8.0 * (values[2] - values[1]) - (values[3] - values[0])) / (12.0 * h)

    samples = [trajectory(t + shift) for shift in (-2 * h, -h, h, 2 * h)]
    motion = trajectory(t)
    np.testing.assert_allclose(slope([s.heights for s in samples]), motion.speeds, atol=1e-7)
    np.testing.assert_allclose(slope([s.speeds for s in samples]), motion.accelerations, atol=3e-6)


@pytest.mark.parametrize("name", NAMES)
def test_vectorized_in_time(
    name: str, every_trajectory: dict[str, trajectories.Trajectory]
) -> None:
    trajectory, t = every_trajectory[name], np.linspace(0.0, 2.0, 6)
    together, grid = trajectory(t), trajectory(t.reshape(2, 3))
    for field in trajectories.Motion._fields:
        alone = np.array([getattr(trajectory(float(now)), field) for now in t])
        assert getattr(trajectory(0.3), field).shape == (3,)
        np.testing.assert_array_equal(getattr(together, field), alone)
        np.testing.assert_array_equal(getattr(grid, field).reshape(6, 3), alone)


# Of the joints, and of any robot


@pytest.mark.parametrize("name", ["five_bar", "gough_stewart"])
def test_of_any_robot_the_joints_move(name: str, tmp_path: Path) -> None:
    """The same way as points, as a recording, and as its end.

    The tip is where closing the loops puts the frame, to 1e-12 m.
    """
    robot = psp3.load(name)
    n = len(robot.actuated)
    goal = robot.reference + np.linspace(-0.03, 0.05, n)
    path = trajectories.PointToPoint(robot.reference, goal, 1.0, robot)
    t = np.linspace(0.0, 1.0, 41)
    motion = path.check(t)
    assert motion.heights.shape == motion.speeds.shape == motion.accelerations.shape == (41, n)
    np.testing.assert_allclose(
        motion.tip, robot.frame_placement(motion.positions, "tip")[:, :3, 3], atol=1e-12
    )
    np.testing.assert_array_equal(
        trajectories.Hold(robot=robot)([0.0, 5.0]).positions, [robot.reference] * 2
    )
    np.testing.assert_allclose(trajectories.Hold(goal, robot)(0.0).tip, motion.tip[-1], atol=1e-12)
    header = ",".join(["t", *robot.actuated])
    np.savetxt(
        tmp_path / "motion.csv",
        np.column_stack([t, motion.positions]),
        delimiter=",",
        header=header,
        comments="",
        fmt="%.17g",
    )
    recorded = trajectories.FromCSV(tmp_path / "motion.csv", robot)
    np.testing.assert_allclose(recorded(t).positions, motion.positions, atol=1e-15)
    splined = trajectories.Waypoints(t, motion.positions, robot)
    # A cubic spline through samples 25 ms apart: h⁴/384 times the fourth derivative, 360 · way.
    np.testing.assert_allclose(
        splined(t[:-1] + 0.01).positions,
        path(t[:-1] + 0.01).positions,
        atol=0.025**4 / 384.0 * 360.0 * 0.05,
    )


def test_what_a_robot_cannot_do_is_refused() -> None:
    robot = psp3.load("five_bar")
    with pytest.raises(StrokeExceeded):
        trajectories.PointToPoint(robot.reference, [-1.6, 0.6], 1.0, robot).check(
            np.linspace(0.0, 1.0, 50)
        )
    with pytest.raises(ClosureFailed):
        trajectories.Hold([-2.5, 2.5], robot)(0.0)
    # Where there is no frame of that name there is no tip.
    loop = four_bar_closed_with_6d()
    linkage = psp3.ClosedLoopRobot(loop.model, loop.constraint_models, loop.actuated, loop.q0)
    assert np.isnan(trajectories.Hold(robot=linkage)(0.0).tip).all()
    for build in (
        lambda: trajectories.Helix(robot=robot),  # type: ignore[arg-type]
        lambda: trajectories.Line([0.0, 0.0], [0.1, 0.1], 1.0, robot, "tip"),
    ):
        with pytest.raises(InvalidValue, match="'joints'"):
            build()
    with pytest.raises(UnknownName, match="tip, joints"):
        trajectories.Hold(space="legs")
    with pytest.raises(InvalidArray):
        trajectories.Hold([0.0, 0.0, 0.0], robot)


@pytest.mark.parametrize(
    ("build", "error"),
    [
        (lambda: trajectories.Helix(radius=-0.01), InvalidValue),
        (lambda: trajectories.Helix(period=0.0), InvalidValue),
        (lambda: trajectories.Helix(rise=np.nan), InvalidValue),
        (lambda: trajectories.Circle(height=np.inf), InvalidValue),
        (lambda: trajectories.Line(HOME, NEAR, -1.0), InvalidValue),
        (lambda: trajectories.Line(HOME, [0.0, np.nan, 0.0], 1.0), InvalidArray),
        (lambda: trajectories.PointToPoint([0.0, 0.0], NEAR, 1.0), InvalidArray),
        (lambda: trajectories.Hold([[0.0, 0.0, 0.0]]), InvalidArray),
        (lambda: trajectories.Waypoints([0.0, 0.0, 1.0], [HOME, NEAR, HOME]), InvalidValue),
        (lambda: trajectories.Waypoints([0.0], [HOME]), InvalidArray),
        (lambda: trajectories.Waypoints([0.0, 1.0, 2.0], [HOME, NEAR]), InvalidArray),
        (lambda: trajectories.Helix()(np.nan), InvalidArray),
        (lambda: trajectories.Helix()("soon"), InvalidArray),
    ],
)
def test_malformed_trajectories_are_refused(build: object, error: type[Exception]) -> None:
    with pytest.raises(error) as caught:
        build()  # type: ignore[operator]
    assert isinstance(caught.value, psp3.PSP3Error)
