"""Motions through points, and from files of them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import psp3
from psp3 import trajectories
from psp3.errors import InvalidTrajectoryFile, InvalidValue
from tests.psp3.trajectories.points import HOME, NEAR, spline_file


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


def test_a_recorded_motion_moves_at_both_of_its_ends_and_rests_beyond(tmp_path: Path) -> None:
    """The spline of a straight line: 10 mm/s from the first row to the last, both included."""
    times = np.linspace(1.0, 2.0, 11)
    rows = "".join(f"{t:.1f},{0.01 * (t - 1.0):.6f},0,0.08\n" for t in times)
    (tmp_path / "line.csv").write_text(f"t,x,y,z\n{rows}")
    recorded = trajectories.FromCSV(tmp_path / "line.csv")
    robot = psp3.load("psp3")
    motion = recorded([0.9, 1.0, 1.5, 2.0, 2.1])
    speeds = np.einsum("nij,nj->ni", robot.tip_jacobian(motion.heights), motion.speeds)
    np.testing.assert_allclose(speeds[:, 0], [0.0, 0.01, 0.01, 0.01, 0.0], atol=1e-12)


def test_a_file_for_another_robot_is_refused(tmp_path: Path) -> None:
    with pytest.raises(
        InvalidTrajectoryFile, match=r"must name the columns t,\w+,\w+; it has t, a1, a2, a3"
    ):
        trajectories.FromCSV(
            spline_file(tmp_path / "heights.csv", "t,a1,a2,a3"), psp3.load("five_bar")
        )


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
        ("t,x,y,z\n0,0,0,0,0,0,0,2\n", "line 2: expected 4 cells, .* got 8.* with a point"),
        ("t,x,y,z\n0,0,0,0.1,\n", "line 2: expected 4 cells"),
        ("t,x,y,z,x\n0,0,0,0.1,5\n", "names x twice"),
        ("t,x,y,z\n0,0,0,1_0\n", "line 2: expected finite numbers"),
        ("t,x,y,z\n0,0,0,１\n", "line 2: expected finite numbers"),
        ("t,x,y,z\n0,0,0,1e999\n", "line 2: a number is not finite"),
        ('t,x,y,z\n0,0,0,"1', "cannot be read"),
        ("t,x,y,z\n0,0,0,.2\n1e-300,0,1e-3,.2\n2e-300,0,0,.2\n3,0,0,.2\n", "1e-09 of the whole"),
        ("t,x,y,z\n0,0,0,1e308\n1,0,0,-1e308\n2,0,0,1e308\n3,0,0,-1e308\n", "smooth curve"),
    ],
)
def test_broken_files_name_the_line(tmp_path: Path, content: str, reason: str) -> None:
    path = tmp_path / "motion.csv"
    path.write_text(content, encoding="utf-8")
    with pytest.raises(InvalidTrajectoryFile, match=reason) as caught:
        trajectories.FromCSV(path)
    assert caught.value.path == path


@pytest.mark.parametrize("start", ["", "\ufeff"])
@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_files_of_other_programs_are_read(tmp_path: Path, start: str, end: str) -> None:
    """With a byte order mark, lines of Windows, quotes, blanks and empty lines."""
    path = tmp_path / "motion.csv"
    rows = ['"t", x ,y,z,"a, b"', *(f'{k},"0", 0 ,.2,word' for k in range(4)), "", ",,,,", ""]
    path.write_bytes((start + end.join(rows)).encode())
    np.testing.assert_allclose(trajectories.FromCSV(path)(1.0).tip, [0.0, 0.0, 0.2], atol=1e-12)


def test_waypoints_too_near_to_each_other_are_refused() -> None:
    points = [[0.0, 0.0, 0.2], [0.0, 1e-3, 0.2], [0.0, 0.0, 0.2], [0.0, 0.0, 0.2]]
    with pytest.raises(InvalidValue, match="1e-09 of the whole time"):
        trajectories.Waypoints([0.0, 1e-300, 2e-300, 3.0], points)


def test_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(InvalidTrajectoryFile, match=r"none\.csv"):
        trajectories.FromCSV(tmp_path / "none.csv")


def motion_file(path: Path, robot: psp3.Robot, header: str, noise: float = 0.0) -> np.ndarray:
    """Write positions and forces along a sway; return speeds and accelerations of it."""
    t = np.arange(0.0, 2.0, 0.005)
    a, v, w = trajectories.Sway(robot=robot).joints(t)
    forces = robot.inverse_dynamics(a, v, w)
    a = a + noise * np.random.default_rng(0).normal(size=a.shape)
    rows = np.column_stack([t, forces, a])
    np.savetxt(path, rows, delimiter=",", header=header, comments="", fmt="%.17g")
    return np.stack([v, w, forces])


@pytest.mark.parametrize("name", ["five_bar", "delta", "gough_stewart"])
@pytest.mark.parametrize("numbered", [False, True])
def test_a_record_of_positions_and_forces_tells_speeds_and_accelerations(
    tmp_path: Path, name: str, numbered: bool
) -> None:
    """Without noise to the error of a quintic spline through samples 5 ms apart.

    Columns are found by name, whatever their order.
    """
    robot = psp3.load(name)
    n = len(robot.actuated)
    motors = [f"a{k + 1}" for k in range(n)] if numbered else list(robot.actuated)
    of_forces = [f"force{k + 1}" for k in range(n)] if numbered else [f"force_{m}" for m in motors]
    file = tmp_path / "record.csv"
    v, w, forces = motion_file(file, robot, ",".join(["t", *of_forces, *motors]))
    found = trajectories.measured_motion(file, robot)
    np.testing.assert_array_equal(found.forces, forces)
    np.testing.assert_allclose(found.speeds, v, atol=1e-6 * np.abs(v).max())
    np.testing.assert_allclose(found.accelerations, w, atol=1e-4 * np.abs(w).max())


def test_noise_of_encoders_hardly_reaches_the_accelerations(tmp_path: Path) -> None:
    """Central differences of 0.01 mrad of noise would miss by 1.6 times their root mean square.

    What is between, 30 times less, is what smoothing gives.
    """
    robot, file = psp3.load("five_bar"), tmp_path / "record.csv"
    header = ",".join(["t", *(f"force_{m}" for m in robot.actuated), *robot.actuated])
    _, w, _ = motion_file(file, robot, header, 1e-5)
    found = trajectories.measured_motion(file, robot)
    missed = np.sqrt(((found.accelerations - w) ** 2).mean() / (w**2).mean())
    raw = np.diff(np.loadtxt(file, delimiter=",", skiprows=1)[:, 3:], 2, axis=0) / 0.005**2
    by_differences = np.sqrt(((raw - w[1:-1]) ** 2).mean() / (w**2).mean())
    assert missed < by_differences / 30.0


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("t,shoulder,elbow\n", "t,left_motor,right_motor,force_left_motor"),
        (
            "t,a1,a2,force1,force2\n0,1,2,3\n",
            "line 2: expected 5 cells, as many as in the first line, got 4",
        ),
        ("t,a1,a2,force1,force2\n0,1,2,3,nan\n", "line 2: expected finite numbers for t, a1, a2"),
        (
            "t,a1,a2,force1,force2\n" + "".join(f"{k},1e308,{k},3,4\n" for k in range(12)),
            "smooth curve",
        ),
        ("t,a1,a2,force1,force2\n0,1,2,3,4\n1,1,2,3,4\n", "N of at least 12"),
        ("t,a1,a2,force1,force2\n" + 12 * "0,1,2,3,4\n", "later than the one before it"),
    ],
)
def test_a_record_that_cannot_be_used_is_refused(tmp_path: Path, text: str, words: str) -> None:
    robot, file = psp3.load("five_bar"), tmp_path / "record.csv"
    words = words.replace("left_motor", robot.actuated[0]).replace("right_motor", robot.actuated[1])
    file.write_text(text)
    with pytest.raises(InvalidTrajectoryFile, match=words):
        trajectories.measured_motion(file, robot)


@pytest.mark.parametrize("late", [2.0**20, 2.0**31])
def test_a_curve_that_would_miss_its_own_points_is_refused(tmp_path: Path, late: float) -> None:
    """Three rows in seconds and one after weeks: the cubic piece between swings out by 1e9 m."""
    path = tmp_path / "motion.csv"
    rows = ["t,a1,a2,a3", "0,0.1,0.2,0.2", "3,0.3,0.2,0.2", "6,0.1,0.2,0.2", f"{late},0.2,0.2,0.2"]
    path.write_text("\n".join(rows))
    with pytest.raises(InvalidTrajectoryFile, match=r"times must be at more even distances.*miss"):
        trajectories.FromCSV(path)


def test_times_since_1970_are_times_as_any(tmp_path: Path) -> None:
    """Differences of such times are exact, so that points are, too."""
    path, t = tmp_path / "motion.csv", 2.0**31 + np.arange(8) / 64.0
    heights = 0.2 + 0.01 * np.sin(np.arange(24.0)).reshape(8, 3)
    np.savetxt(
        path,
        np.column_stack([t, heights]),
        fmt="%.17g",
        delimiter=",",
        header="t,a1,a2,a3",
        comments="",
    )
    found = trajectories.FromCSV(path)(t).positions
    np.testing.assert_allclose(found, heights, rtol=0.0, atol=1e-15)
