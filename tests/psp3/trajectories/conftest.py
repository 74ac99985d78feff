"""What tests of trajectories share."""

from __future__ import annotations

import pytest

from psp3 import trajectories
from tests.psp3.trajectories.points import HOME, NEAR, spline_file


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
