"""Motions through points, and from files of them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import psp3
from psp3 import trajectories
from psp3.errors import (
    InvalidTrajectoryFile,
)
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
