"""Trajectories.

Rates against finite differences, paths against their equations, and what is refused.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import psp3
from psp3 import trajectories
from psp3.errors import (
    ClosureFailed,
    CollisionFound,
    InvalidArray,
    InvalidTrajectoryFile,
    InvalidValue,
    StrokeExceeded,
    UnknownName,
    UnreachableTip,
)
from tests.helpers import four_bar_closed_with_6d

HOME = np.array([0.0, 0.0, 0.07])
NEAR = np.array([0.01, -0.012, 0.10])


def spline_file(path: Path, columns: str = "t,x,y,z") -> Path:
    times = np.linspace(0.0, 2.0, 21)
    table = np.column_stack(
        [times, 0.01 * np.sin(times), 0.01 * np.cos(times), 0.08 + 0.01 * times]
    )
    path.write_text(
        columns
        + "\n"
        + "\n".join(",".join(f"{value:.12g}" for value in row) for row in table)
        + "\n"
    )
    return path


@pytest.fixture(scope="module")
def every_trajectory(
    tmp_path_factory: pytest.TempPathFactory,
) -> dict[str, trajectories.Trajectory]:
    folder = tmp_path_factory.mktemp("csv")
    return {
        "helix": trajectories.Helix(),
        "circle": trajectories.Circle(radius=0.015),
        "line": trajectories.Line(HOME, NEAR, 2.0),
        "point to point": trajectories.PointToPoint(HOME, NEAR, 2.0),
        "hold": trajectories.Hold(NEAR),
        "waypoints": trajectories.Waypoints(
            [0.0, 0.7, 1.5, 2.0], [HOME, NEAR, 0.5 * (HOME + NEAR), HOME]
        ),
        "tip file": trajectories.FromCSV(spline_file(folder / "tip.csv")),
        "heights file": trajectories.FromCSV(spline_file(folder / "heights.csv", "t,a1,a2,a3")),
        "joints": trajectories.PointToPoint(
            [0.0, 0.02, -0.01], [0.05, 0.0, 0.03], 2.0, space="joints"
        ),
        "joint waypoints": trajectories.Waypoints(
            [0.0, 1.0, 2.0], [[0.0] * 3, [0.05, 0.0, 0.03], [0.01] * 3], space="joints"
        ),
        "joint hold": trajectories.Hold([0.05, 0.0, 0.03], space="joints"),
    }


NAMES = [
    "helix",
    "circle",
    "line",
    "point to point",
    "hold",
    "waypoints",
    "tip file",
    "heights file",
    "joints",
    "joint waypoints",
    "joint hold",
]


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
def test_tip_of_the_heights_is_the_tip_asked_for(
    name: str, every_trajectory: dict[str, trajectories.Trajectory]
) -> None:
    """Forward kinematics of what inverse kinematics returned; 1e-14 m is a few ulps."""
    t = np.linspace(-0.5, 3.0, 50)
    motion = every_trajectory[name](t)
    np.testing.assert_allclose(
        every_trajectory[name].robot.forward_kinematics(motion.heights).tip, motion.tip, atol=1e-14
    )


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


def test_helix_follows_its_equation() -> None:
    """The tip written with complex numbers, independently of the class."""
    helix = trajectories.Helix(radius=0.015, period=1.5, rise=0.02, height=0.09)
    t = np.linspace(0.0, 4.0, 41)
    tip = helix(t).tip
    np.testing.assert_allclose(
        tip[:, 0] + 1j * tip[:, 1], 0.015 * np.exp(2j * np.pi * t / 1.5), atol=1e-16
    )
    np.testing.assert_allclose(tip[:, 2], 0.09 + 0.02 * t, atol=1e-16)


def test_default_helix_is_the_one_of_the_comparison() -> None:
    helix = trajectories.Helix()
    assert (helix.radius, helix.period, helix.rise, helix.height) == (0.020, 2.0, 0.010, 0.070)


@given(share=st.floats(0.0, 1.0))
@settings(max_examples=30, deadline=None)
def test_quintic_is_symmetric_and_stays_on_the_line(share: float) -> None:
    """s(x) + s(1 − x) = 1 for the quintic; 1e-15 is rounding of numbers of size 0.1."""
    trajectory = trajectories.PointToPoint(HOME, NEAR, 2.0)
    forth, back = trajectory(2.0 * share).tip, trajectory(2.0 * (1.0 - share)).tip
    np.testing.assert_allclose(forth + back, HOME + NEAR, atol=1e-15)
    assert np.linalg.norm(np.cross(forth - HOME, NEAR - HOME)) < 1e-17


@pytest.mark.parametrize("kind", [trajectories.PointToPoint, trajectories.Waypoints])
def test_smooth_motions_start_and_end_at_rest(kind: type) -> None:
    trajectory = (
        kind(HOME, NEAR, 2.0)
        if kind is trajectories.PointToPoint
        else kind([0.0, 1.0, 2.0], [HOME, 0.7 * NEAR, NEAR])
    )
    motion = trajectory([0.0, 2.0, 5.0])
    np.testing.assert_allclose(motion.speeds, 0.0, atol=1e-15)
    np.testing.assert_allclose(motion.tip[1:], [NEAR, NEAR], atol=1e-16)


def test_waypoints_are_passed_at_their_times() -> None:
    times, points = [0.0, 0.4, 1.0], np.array([HOME, NEAR, [-0.005, 0.01, 0.12]])
    np.testing.assert_allclose(trajectories.Waypoints(times, points)(times).tip, points, atol=1e-15)


def test_a_file_of_heights_and_one_of_tips_tell_the_same_motion(tmp_path: Path) -> None:
    """A recorded helix, once as tips and once as heights.

    Splines through 10 ms samples differ by their error, about 1e-9 m.
    """
    t = np.arange(0.0, 2.0, 0.01)
    motion = trajectories.Helix()(t)
    for name, columns, values in (
        ("tip", "x,y,z", motion.tip),
        ("heights", "a1,a2,a3", motion.heights),
    ):
        rows = np.column_stack([t, values])
        np.savetxt(
            tmp_path / f"{name}.csv",
            rows,
            delimiter=",",
            header=f"t,{columns}",
            comments="",
            fmt="%.17g",
        )
    inside = np.linspace(0.05, 1.9, 300)
    by_tip = trajectories.FromCSV(tmp_path / "tip.csv")(inside)
    by_heights = trajectories.FromCSV(tmp_path / "heights.csv")(inside)
    np.testing.assert_allclose(by_tip.heights, by_heights.heights, atol=1e-7)
    np.testing.assert_allclose(by_tip.heights, trajectories.Helix()(inside).heights, atol=1e-7)


# Of the joints, and of any robot


def test_a_motion_of_the_joints_is_straight_in_them() -> None:
    """The quintic written out: halfway at half the time.

    There at 15/8 of the mean speed, without acceleration.
    """
    start, end = np.array([0.0, 0.02, -0.01]), np.array([0.05, 0.0, 0.03])
    middle = trajectories.PointToPoint(start, end, 2.0, space="joints")(1.0)
    np.testing.assert_allclose(middle.positions, 0.5 * (start + end), atol=1e-16)
    np.testing.assert_allclose(middle.speeds, 15.0 / 8.0 * (end - start) / 2.0, rtol=1e-14)
    np.testing.assert_allclose(middle.accelerations, 0.0, atol=1e-15)


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


def test_a_file_for_another_robot_is_refused(tmp_path: Path) -> None:
    with pytest.raises(
        InvalidTrajectoryFile, match=r"must name the columns t,\w+,\w+; it has t, a1, a2, a3"
    ):
        trajectories.FromCSV(
            spline_file(tmp_path / "heights.csv", "t,a1,a2,a3"), psp3.load("five_bar")
        )


def test_radius_beyond_the_fold_names_the_reach() -> None:
    with pytest.raises(UnreachableTip, match=r"23\.9 mm") as caught:
        trajectories.Helix(radius=0.030)(np.linspace(0.0, 2.0, 100))
    assert caught.value.reach == pytest.approx(np.hypot(0.07, 0.0905) - 0.0905, abs=1e-12)
    np.testing.assert_allclose(caught.value.tip[:2], [0.030, 0.0], atol=1e-15)


def test_leaving_the_stroke_names_the_time() -> None:
    helix = trajectories.Helix(rise=0.1)
    t = np.arange(0.0, 6.0, 0.01)
    with pytest.raises(StrokeExceeded) as caught:
        helix.check(t)
    late = t[(helix(t).heights > helix.robot.stroke[1]).any(axis=1)]
    assert caught.value.time == late[0]


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


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        ("", "nothing"),
        ("time,x,y,z\n0,0,0,0\n", "first line"),
        ("t,x,y,z\n0,0,0,0.1\n1,0,zero,0.1\n", "line 3"),
        ("t,x,y,z\n0,0,0,0.1\n1,0,0\n", "line 3"),
        ("t,x,y,z\n0,0,0,0.1\n1,0,0,nan\n", "line 3"),
        ("t,x,y,z\n0,0,0,0.1\n1,0,0,0.1\n", "at least 4"),
        ("t,x,y,z\n0,0,0,0.1\n1,0,0,0.1\n1,0,0,0.1\n2,0,0,0.1\n", "later"),
    ],
)
def test_broken_files_name_the_line(tmp_path: Path, content: str, reason: str) -> None:
    path = tmp_path / "motion.csv"
    path.write_text(content)
    with pytest.raises(InvalidTrajectoryFile, match=reason) as caught:
        trajectories.FromCSV(path)
    assert caught.value.path == path


def test_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(InvalidTrajectoryFile, match=r"none\.csv"):
        trajectories.FromCSV(tmp_path / "none.csv")


def test_a_motion_in_which_links_touch_is_refused_if_clearance_is_asked_for() -> None:
    """A lean of 45 degrees toward screw 1 is a contact.

    Bushing and frame touch at 35.594 degrees; it is within the arms' lengths.
    """
    robot = psp3.load("psp3")
    leaning = robot.inverse_kinematics(height=0.0, tilt=np.radians(45.0), azimuth=0.0)
    motion = trajectories.PointToPoint(np.zeros(3), leaning, 1.0, robot=robot, space="joints")
    t = np.linspace(0.0, 1.0, 51)
    motion.check(t)
    with pytest.raises(CollisionFound) as caught:
        motion.check(t, clearance=0.0)
    assert 0.5 < caught.value.time < 1.0
    with pytest.raises(CollisionFound):
        psp3.simulate(robot, psp3.ComputedTorque(robot), motion, 1.0, clearance=0.0)
