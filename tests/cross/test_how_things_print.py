"""Objects print as what they are: a line without arrays, and a table that obeys no name."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import fuzzy2
import psp3
from psp3.benchmark import Benchmark
from psp3.kinematics.task_space import TaskSpace
from psp3.simulation.dormand_prince import DormandPrince
from psp3.trajectories import Circle, Helix, Hold, Line, Waypoints
from psp3.trajectories.motion import Motion

ROBOT = psp3.load("psp3")


def result() -> psp3.Result:
    """Return a run of ten seconds whose nuts are 1 mm below and whose tip is 2 mm off."""
    t, rest = np.linspace(0.0, 10.0, 1001), np.zeros((1001, 3))
    tip = rest + np.array([0.002, 0.0, 0.0])
    return psp3.Result(t, rest - 0.001, rest, Motion(rest, rest, rest, rest), rest + 50.0, tip)


def study() -> psp3.Study:
    return psp3.Study(
        "no/such/study.sqlite", psp3.grid(controller=["t1", "it2"], snr_db=20, seed=range(3))
    )


@pytest.mark.parametrize(
    ("thing", "line"),
    [
        (ROBOT, "PSP3(name=3-PSP robot, degrees_of_freedom=3, motors=a1, a2, a3, loops=2)"),
        (psp3.PD(), "PD(kp=1000, kv=100)"),
        (psp3.PID(kp=np.eye(3)), "PID(kp=array of 3 × 3, kv=100, ki=2000)"),
        (psp3.FeedForward(ROBOT), "FeedForward(model=3-PSP robot)"),
        (psp3.ComputedTorque(ROBOT), "ComputedTorque(model=3-PSP robot, kp=10, kv=1)"),
        (
            psp3.GravityCompensatedPD(ROBOT),
            "GravityCompensatedPD(model=3-PSP robot, kp=1000, kv=100)",
        ),
        (
            Helix(robot=ROBOT),
            "Helix(radius=0.02 m, period=2 s, rise=0.01 m/s, space=tip, robot=3-PSP robot)",
        ),
        (
            Circle(robot=ROBOT),
            "Circle(radius=0.02 m, period=2 s, rise=0 m/s, space=tip, robot=3-PSP robot)",
        ),
        (
            Line([0, 0, 0.07], [0, 0, 0.1], 2.0, ROBOT),
            "Line(start=[0, 0, 0.07], end=[0, 0, 0.1], duration=2 s, space=tip, robot=3-PSP robot)",
        ),
        (
            Hold([0, 0, 0.1], ROBOT),
            "Hold(point=[0, 0, 0.1], duration=0 s, space=tip, robot=3-PSP robot)",
        ),
        (
            Waypoints([0, 1, 3], np.full((3, 3), 0.01), ROBOT, "joints"),
            "Waypoints(points=3, duration=3 s, space=joints, robot=3-PSP robot)",
        ),
        (
            result(),
            "Result(duration=10 s, samples=1001, joints=3, largest_error_of_positions=0.001, "
            "rms_error_of_positions=0.001, largest_error_of_tip=0.002 m, largest_force=50)",
        ),
        (study(), "Study(file=study.sqlite, not made yet, runs=6)"),
        (psp3.Run("t1", snr_db=20.0, seed=3), "Run('t1', snr_db=20.0, seed=3)"),
        (
            psp3.Monitor(),
            "Monitor(threshold=not learned, quantile=0.999, hysteresis=0.05, time_constant=0.05 s)",
        ),
        (
            Benchmark("no/such", ["ctc", "pd-gravity"], seeds=2),
            "Benchmark(directory=such, entries=ctc, pd-gravity, robots=psp3, delta, gough_stewart, "
            "readings=outputs, levels=20 dB, seeds=2)",
        ),
        (TaskSpace(ROBOT), "TaskSpace(robot=3-PSP robot, frame=tip, task=x, y, z)"),
        (DormandPrince(ROBOT), "DormandPrince(robot=3-PSP robot)"),
        (
            fuzzy2.Linear(np.ones((2, 1, 4))),
            "Linear(rules=2, outputs=1, inputs=3, spreads=no)",
        ),
    ],
    ids=lambda value: type(value).__name__ if not isinstance(value, str) else "",
)
def test_a_line_says_what_it_is(thing: Any, line: str) -> None:
    assert repr(thing) == line
    html = thing._repr_html_()
    assert type(thing).__name__ in html
    assert "array(" not in html


def test_a_run_is_written_as_it_prints() -> None:
    run = psp3.Run("pd", payload=2.0, trajectory="circle")
    assert eval(repr(run), {"Run": psp3.Run}) == run
    assert repr(psp3.Run()) == "Run('it2')"


def test_names_from_files_are_texts() -> None:
    hostile = psp3.Study(Path("<script>\x1b.sqlite"))
    assert repr(hostile) == r"Study(file=<script>\x1b.sqlite, not made yet, runs=those of the file)"
    assert "<script>" not in hostile._repr_html_()
    assert "<script>" not in psp3.Run("<script>:Name")._repr_html_()


def test_a_result_without_samples_or_tip_prints() -> None:
    none, few = np.zeros((0, 3)), np.zeros((2, 3))
    empty = psp3.Result(np.zeros(0), none, none, Motion(none, none, none, none), none, none)
    assert repr(empty) == "Result(duration=0 s, samples=0, joints=3)"
    lost = np.full((2, 3), np.nan)
    found = psp3.Result(np.array([0.0, 1.0]), few, few, Motion(few, few, few, lost), few, lost)
    assert "tip" not in repr(found)
