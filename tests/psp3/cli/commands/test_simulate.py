"""``psp3 simulate`` and ``psp3 train``: the library's numbers, and files of them."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest

import psp3
from psp3.cli import options
from psp3.control.default_gains import default_gains
from psp3.simulation import metrics
from tests.psp3.cli.answers import Run, words

ROBOT = psp3.load("psp3")


def test_simulation_is_that_of_the_library(psp3_command: Run) -> None:
    answer = psp3_command(
        "simulate",
        "--duration",
        1,
        "--out",
        "run.npz",
        "--csv",
        "run.csv",
        "--figure",
        "run.svg",
        "--json",
    )
    expected = psp3.simulate(
        ROBOT, psp3.ComputedTorque(ROBOT), psp3.trajectories.Helix(robot=ROBOT), 1.0
    )
    found = answer.json
    assert found["metrics"]["sum_of_squared_errors"] == metrics.sum_of_squared_errors(expected)
    assert found["metrics"]["largest_tip_error"] == metrics.largest_tip_error(expected)
    assert (found["controller"], found["model"], found["gains"]) == (
        "ctc",
        "closed_form",
        {"kp": 10.0, "kv": 1.0},
    )
    saved = psp3.load_result("run.npz")
    np.testing.assert_array_equal(saved.heights, expected.heights)
    with Path("run.csv").open() as file:
        rows = list(csv.DictReader(file))
    for column, values in (
        ("t", expected.t),
        ("a3", expected.heights[:, 2]),
        ("force1", expected.torque[:, 0]),
    ):
        np.testing.assert_array_equal([float(row[column]) for row in rows], values)
    np.testing.assert_array_equal(
        [float(row["desired_y"]) for row in rows], expected.desired.tip[:, 1]
    )
    assert Path("run.svg").read_text().startswith("<?xml")
    assert found["files"] == {"result": "run.npz", "csv": "run.csv", "figure": "run.svg"}
    assert answer.err == ""


def test_start_on_the_path_leaves_nothing_to_correct(psp3_command: Run) -> None:
    """Computed torque on a path that it is on errs by what the held force misses, some 1e-5 m.

    From rest by 10 mm.
    """
    options = ("simulate", "--duration", 1, "--json")
    assert (
        psp3_command(*options, "--initial-speed", "path").json["metrics"]["largest_tip_error"]
        < 2e-4
    )
    assert psp3_command(*options).json["metrics"]["largest_tip_error"] > 5e-3


@pytest.mark.parametrize(
    ("options", "controller"),
    [
        (("--controller", "pd", "--kp", "3000"), psp3.PD(kp=3000.0)),
        (("--controller", "pd-gravity", "--kv", "300"), psp3.GravityCompensatedPD(ROBOT, kv=300.0)),
        (("--controller", "pid", "--ki", "500"), psp3.PID(ki=500.0)),
        (("--controller", "feed-forward"), psp3.FeedForward(ROBOT)),
        (
            ("--controller", "ctc", "--model", "noc", "--kp", "40"),
            psp3.ComputedTorque(ROBOT, kp=40.0),
        ),
        (("--controller", "ctc", "--model", "pinocchio"), psp3.ComputedTorque(ROBOT)),
    ],
)
def test_every_controller_and_its_gains(
    psp3_command: Run, options: tuple[str, ...], controller: Any
) -> None:
    """The other models drive computed torque to the same place, 1e-9 m over 50 periods."""
    assert psp3_command("simulate", *options, "--duration", 0.1, "--out", "run.npz").status == 0
    expected = psp3.simulate(ROBOT, controller, psp3.trajectories.Helix(robot=ROBOT), 0.1)
    np.testing.assert_allclose(
        psp3.load_result("run.npz").heights, expected.heights, rtol=0.0, atol=1e-9
    )


def test_torque_limits(psp3_command: Run) -> None:
    for limit, expected in (("90", (90.0, 90.0, 90.0)), ("90,95,1000", (90.0, 95.0, 1000.0))):
        found = psp3_command("simulate", "--duration", 0.4, "--torque-limit", limit, "--json").json
        assert (np.array(found["metrics"]["largest_forces"]) <= expected).all()
        assert found["metrics"]["largest_forces"][0] == 90.0


def test_simulation_as_a_table(psp3_command: Run) -> None:
    answer = psp3_command("simulate", "--duration", 0.5, "--out", "run.npz")
    assert "root mean square of the error" in answer.out
    assert answer.out.splitlines()[-1] == "run.npz"
    # 7 ms do not divide 0.05 s.
    assert "per 0.05 s – m²" in words(
        psp3_command("simulate", "--duration", 0.07, "--period", 0.007).out
    )


def test_part_of_a_stopped_simulation_is_kept(psp3_command: Run) -> None:
    answer = psp3_command(
        "simulate", "--torque-limit", 50, "--out", "part.npz", "--csv", "part.csv"
    )
    assert (answer.status, answer.out, answer.err.count("\n")) == (2, "", 1)
    assert answer.err.startswith("psp3: a nut ran off its screw at t = ")
    assert "part.npz and part.csv" in answer.err
    part = psp3.load_result("part.npz")
    assert 0.1 < part.t[-1] < 1.0
    assert len(Path("part.csv").read_text().splitlines()) == part.t.size + 1


def test_rules_that_adapt_track_what_they_learned_from(psp3_command: Run) -> None:
    """Of another robot with its own gains, and as the library has it; 1e-12 of micrometers."""
    options = ("--controller", "adaptive-t1", "--duration", 0.5, "--json")
    found = psp3_command("simulate", "five_bar", *options).json
    robot = psp3.load("five_bar")
    path, gains = psp3.trajectories.Sway(robot=robot), default_gains(robot, "ctc")
    base = psp3.FuzzyComputedTorque("t1", robot, **gains).fit(path, 2.0 * path.period)
    expected = psp3.simulate(robot, psp3.AdaptiveFuzzyComputedTorque(base), path, 0.5)
    assert (found["controller"], found["model"], found["gains"]) == (
        "adaptive-t1",
        "learned",
        gains,
    )
    largest = abs(expected.desired.positions - expected.positions).max(axis=0)
    assert found["metrics"]["largest_errors"] == pytest.approx(largest, abs=1e-12)


def test_a_trained_controller_goes_to_a_file_and_back(psp3_command: Run, tmp_path: Path) -> None:
    """The same numbers as from Python: the file holds the controller to the last bit."""
    answer = psp3_command("train", "it2.json", "--learner", "average", "--snr", 15, "--seed", 3)
    assert answer.status == 0
    assert "16 rules" in answer.out
    controller = psp3.FuzzyComputedTorque("it2", ROBOT, learner="average", snr_db=15.0)
    controller.fit(psp3.trajectories.Helix(robot=ROBOT), rng=np.random.default_rng(3))
    expected = psp3.simulate(ROBOT, controller, psp3.trajectories.Helix(robot=ROBOT), 1.0)
    found = psp3_command("simulate", "--trained", "it2.json", "--duration", 1, "--json").json
    assert found["controller"] == "it2"
    assert found["metrics"]["integral_of_squared_error"] == metrics.integral_of_squared_error(
        expected
    )


def test_the_order_of_defuzzification_is_trained(psp3_command: Run) -> None:
    options = ("--kind", "gt2", "--snr", 20)
    for order in ("first", "last"):
        assert psp3_command("train", f"{order}.json", *options, "--defuzzify", order).status == 0
    found = {
        order: psp3.FuzzyComputedTorque.load(f"{order}.json", ROBOT) for order in ("first", "last")
    }
    assert {order: controller.order for order, controller in found.items()} == {
        "first": "first",
        "last": "last",
    }
    assert psp3_command("train", "default.json", *options).status == 0
    assert Path("default.json").read_bytes() == Path("first.json").read_bytes()


def test_leaving_the_trained_range_shows_in_every_output(psp3_command: Run) -> None:
    options = (
        "simulate",
        "--controller",
        "it2",
        "--radius",
        0.0202,
        "--duration",
        1,
        "--csv",
        "run.csv",
        "--json",
    )
    found = psp3_command(*options).json["metrics"]
    controller = psp3.FuzzyComputedTorque("it2", ROBOT).fit(psp3.trajectories.Helix(robot=ROBOT))
    expected = psp3.simulate(
        ROBOT, controller, psp3.trajectories.Helix(radius=0.0202, robot=ROBOT), 1.0
    )
    assert expected.covered is not None
    assert 0.0 < expected.covered.mean() < 1.0
    assert (found["coverage"], found["fallbacks"]) == (expected.covered.mean(), 0.0)
    with Path("run.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["covered"] == "1" for row in rows] == expected.covered.tolist()
    assert {row["fell_back"] for row in rows} == {"0"}
    table = psp3_command(*options[:-3]).out
    assert f"{100.0 * expected.covered.mean():.4g}" in next(
        line for line in table.splitlines() if "trained range" in line
    )
    assert "trained range" not in psp3_command("simulate", "--duration", 0.1).out


def test_fuzzy_controllers_learn_where_they_are_asked_for(psp3_command: Run) -> None:
    found = psp3_command("simulate", "--controller", "t1", "--duration", 1, "--json").json
    controller = psp3.FuzzyComputedTorque("t1", ROBOT).fit(psp3.trajectories.Helix(robot=ROBOT))
    expected = psp3.simulate(ROBOT, controller, psp3.trajectories.Helix(robot=ROBOT), 1.0)
    assert found["metrics"]["integral_of_squared_error"] == metrics.integral_of_squared_error(
        expected
    )


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("train", "a.json", "--kind", "t3"), "unknown kind of controller 't3'"),
        (("train", "a.json", "--terms", "3"), "no sample fires rule"),
        (("train", "a.json", "--defuzzify", "middle"), "unknown order of defuzzification 'middle'"),
        (("train", "a.json", "--snr", "nan"), "--snr must be"),
        (("train", "a.json", "--trajectory", "hold"), "every difference input changes"),
        (("train", "missing/a.json"), "no directory"),
        (
            ("simulate", "--trained", "missing.json"),
            "missing.json: no such file",
        ),
        (
            ("simulate", "--trained", "missing.json", "--kp", "3"),
            "--kp does not apply to --trained",
        ),
        (
            ("simulate", "--trained", "missing.json", "--controller", "pd"),
            "--controller does not apply to --trained",
        ),
        (("simulate", "--controller", "t1", "--model", "noc"), "--model does not apply"),
    ],
)
def test_what_cannot_be_trained_or_read_is_refused(
    psp3_command: Run, arguments: tuple[str, ...], words: str
) -> None:
    answer = psp3_command(*arguments)
    assert answer.status == options.USAGE
    assert words in answer.err
    assert "Traceback" not in answer.err
    assert not Path("a.json").exists()


@pytest.mark.parametrize("controller", ["pd", "pd-gravity", "pid", "ctc"])
def test_another_robot_is_tracked_with_gains_of_its_own(psp3_command: Run, controller: str) -> None:
    """Critically damped in the reference pose: of computed torque only the hold's error is left.

    That of the others is what gravity and acceleration leave, a small share of the way, which is
    0.27 rad.
    """
    answer = psp3_command(
        "simulate", "five_bar", "--controller", controller, "--figure", "s.pdf", "--json"
    )
    metrics = answer.json["metrics"]
    assert answer.json["robot"] == "five_bar"
    assert max(metrics["largest_errors"]) < (1e-3 if controller == "ctc" else 0.1)
    assert metrics["largest_tip_error"] > 0.0
    assert Path("s.pdf").read_bytes().startswith(b"%PDF")


def test_another_robot_between_points_of_its_motors(psp3_command: Run) -> None:
    answer = psp3_command(
        *("simulate", "five_bar", "--trajectory", "point-to-point", "--end=-0.3,0.1"),
        *("--csv", "-"),
    )
    last = [float(cell) for cell in answer.out.splitlines()[-1].split(",")]
    names = answer.out.splitlines()[0].split(",")
    assert [last[names.index(f"desired_a{k}")] for k in (1, 2)] == pytest.approx([-0.3, 0.1])
    assert last[names.index("a1")] == pytest.approx(-0.3, abs=1e-3)
    held = psp3_command(
        *("simulate", "five_bar", "--trajectory", "hold", "--at=-0.3,0.1", "--duration", "0.1")
    )
    assert "hold" in held.out


def test_more_motors_than_coordinates_are_tracked_by_the_coordinates(psp3_command: Run) -> None:
    """Forces of four motors, errors of three coordinates; feedback is shared out among the four."""
    for name in ("pd", "ctc"):
        answer = psp3_command(
            *("simulate", "planar_4rrr", "--controller", name, "--duration", "0.2", "--json")
        )
        metrics = answer.json["metrics"]
        assert answer.json["coordinates"] == ["leg1_shoulder", "leg2_shoulder", "leg3_shoulder"]
        assert len(metrics["largest_forces"]) == 4
        assert max(metrics["largest_errors"]) < (1e-4 if name == "ctc" else 0.1)
    text = words(psp3_command("simulate", "planar_4rrr", "--duration", "0.02").out)
    assert "Forces of the motors" in text
    assert "leg4_shoulder" in text


def test_a_floating_robot_falls_while_its_motors_track(psp3_command: Run) -> None:
    """The center of mass falls g t²/2, whatever the motors do; nothing is desired of the tip."""
    answer = psp3_command("simulate", "biped", "--duration", "0.2", "--out", "r.npz", "--json")
    metrics = answer.json["metrics"]
    assert metrics["largest_tip_error"] is None
    assert max(metrics["largest_errors"]) < 1e-3
    robot, result = psp3.load("biped"), psp3.load_result("r.npz")
    heights = [
        pin.centerOfMass(robot.model, robot.data, robot.configuration(row))[2]
        for row in result.positions[[0, -1]]
    ]
    assert heights[1] - heights[0] == pytest.approx(-0.5 * 9.81 * 0.2**2, abs=1e-9)
    assert psp3_command("simulate", "biped", "--json").json["duration"] == pytest.approx(2.0)
    told = psp3_command("simulate", "biped", "--duration", "0.01", "--initial-speed", "path").out
    assert "root floats: nothing holds the robot up" in words(told)


def test_springs_that_nothing_holds_stop_a_run_and_can_be_held(psp3_command: Run) -> None:
    """The gripper's springs press its fingertips against what they hold; without, they fly off."""
    answer = psp3_command("simulate", "gripper", "--duration", "0.5")
    assert answer.status == options.USAGE
    assert "no motor commands right_spring, left_spring, which follow (--free lock" in answer.err
    held = psp3_command("simulate", "gripper", "--free", "lock", "--duration", "0.5", "--json")
    assert max(held.json["metrics"]["largest_errors"]) < 1e-4


def test_between_points_of_the_commanded_coordinates(psp3_command: Run) -> None:
    answer = psp3_command(
        *("simulate", "gripper", "--free", "lock", "--trajectory", "point-to-point"),
        *("--end", "0.5", "--travel-time", "0.1", "--csv", "-"),
    )
    names, *_, last = answer.out.splitlines()
    row = dict(zip(names.split(","), map(float, last.split(",")), strict=True))
    assert row["a1"] == pytest.approx(0.5, abs=1e-3)
