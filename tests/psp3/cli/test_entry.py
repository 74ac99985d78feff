"""The command line as a user meets it.

What it prints and writes, what it refuses and how, and what it leaves unloaded.
"""

from __future__ import annotations

import csv
import json
import os
import signal
import subprocess
import sys
import urllib.request
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple, NoReturn

import numpy as np
import pytest
import typer

import psp3
from psp3 import published
from psp3.cli import app, options
from psp3.cli import entry as cli
from psp3.description.parts import ROBOTS
from psp3.simulation import metrics
from psp3.trajectories.screw_forces import screw_forces

ROBOT = psp3.load("psp3")
COMMANDS = (
    "reproduce",
    "simulate",
    "train",
    "study",
    "torques",
    "pose",
    "dynamics",
    "workspace",
    "view",
    "info",
)
HEAVY = {"numpy", "scipy", "numba", "matplotlib", "pinocchio", "meshcat", "coal", "yaml"}
ROOT = Path(__file__).parents[3]
PROGRAM = [sys.executable, "-m", "psp3.cli.entry"]
ENVIRONMENT = {
    **os.environ,
    "PYTHONPATH": str(ROOT),
    "COLUMNS": "80",
    "NO_COLOR": "1",
    "TERM": "dumb",
}


class Answer(NamedTuple):
    """What a command gave back."""

    status: int
    out: str
    err: str

    @property
    def json(self) -> Any:
        """Standard output, which must be strict JSON and nothing else."""
        return json.loads(self.out, parse_constant=self._refuse)

    @staticmethod
    def _refuse(constant: str) -> NoReturn:
        raise AssertionError(f"{constant} is not JSON")


Run = Callable[..., Answer]


@pytest.fixture
def psp3_command(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> Run:
    """Run the command line in this process, in an empty directory, in 80 columns."""
    monkeypatch.chdir(tmp_path)
    for name in ("COLUMNS", "NO_COLOR", "TERM"):
        monkeypatch.setenv(name, ENVIRONMENT[name])

    def run(*arguments: object) -> Answer:
        monkeypatch.setattr(sys, "argv", ["psp3", *map(str, arguments)])
        with pytest.raises(SystemExit) as end:
            cli.main()
        assert isinstance(end.value.code, int)
        return Answer(end.value.code, *capsys.readouterr())

    return run


def words(text: str) -> str:
    """Return a text as one line, however it was broken."""
    return " ".join(text.split())


# Help, and what it costs


@pytest.mark.parametrize("command", [(), *((name,) for name in COMMANDS)])
def test_help_loads_nothing_heavy_and_fits_80_columns(command: tuple[str, ...]) -> None:
    code = f"""
import sys
from psp3.cli import entry as cli
sys.argv = ["psp3", *{command!r}, "--help"]
try:
    cli.main()
except SystemExit as end:
    assert end.code == 0, end.code
print("loaded:", *sorted({HEAVY!r} & set(sys.modules)), file=sys.stderr)
"""
    done = subprocess.run(
        [sys.executable, "-c", code],
        env=ENVIRONMENT,
        capture_output=True,
        text=True,
        timeout=60,
        check=True,
    )
    assert done.stderr.split() == ["loaded:"]
    assert max(map(len, done.stdout.splitlines())) <= 80
    assert "Usage: psp3" in done.stdout


def test_help_lists_every_command(psp3_command: Run) -> None:
    answer = psp3_command("--help")
    assert answer.status == 0
    assert all(f" {name} " in answer.out for name in COMMANDS)


def test_no_command_is_wrong_usage_with_the_help(psp3_command: Run) -> None:
    answer = psp3_command()
    assert answer.status == 2
    assert "Commands" in answer.out


def test_version(psp3_command: Run) -> None:
    assert psp3_command("--version") == (0, f"psp3 {psp3.__version__}\n", "")


def test_every_option_says_what_it_is_and_in_which_unit() -> None:
    """Angle options are called DEGREES, and rich swallows text in square brackets.

    Neither may lose a unit.
    """
    units = {
        "M": "(m)",
        "S": "(s)",
        "M/S": "(m/s)",
        "N": "(N)",
        "X,Y,Z": "(m)",
        "A1,A2,A3": "(m)",
        "V1,V2,V3": "(m/s)",
        "W1,W2,W3": "(m/s²)",
    }
    units |= {"DEGREES": "(degrees)"}
    group: Any = typer.main.get_command(app.app)
    assert set(group.commands) == set(COMMANDS)
    checked = 0
    for command in group.commands.values():
        for option in command.params:
            assert option.help, f"{command.name} {option.name} has no help"
            assert "[" not in option.help
            # The workspace's N is a number of poses.
            if option.metavar in units and option.name != "resolution":
                assert units[option.metavar] in option.help, (
                    f"{command.name} {option.name}: {option.help}"
                )
                checked += 1
    assert checked > 20


# pose


def test_forward_kinematics_of_negative_heights(psp3_command: Run) -> None:
    heights = [-0.01, 0.0, 0.02]
    found, expected = (
        psp3_command("pose", "--heights", "-0.01,0,0.02", "--json").json,
        ROBOT.forward_kinematics(heights),
    )
    for name in ("center", "rotation", "arms", "tip"):
        np.testing.assert_array_equal(found[name], getattr(expected, name))
    assert found["heights"] == heights
    assert found["tilt"] == pytest.approx(np.degrees(np.arccos(expected.rotation[2, 2])), abs=1e-9)
    assert found["within_stroke"] is True


def test_inverse_kinematics_in_degrees(psp3_command: Run) -> None:
    """Back to the tilt and azimuth that were asked for, to rounding."""
    found = psp3_command("pose", "--tilt", 20, "--azimuth", -30, "--height", -0.05, "--json").json
    np.testing.assert_array_equal(
        found["heights"], ROBOT.inverse_kinematics(-0.05, np.radians(20.0), np.radians(-30.0))
    )
    assert found["tilt"] == pytest.approx(20.0, abs=1e-12)
    assert found["azimuth"] == pytest.approx(-30.0, abs=1e-12)
    assert found["center"][2] == pytest.approx(-0.05, abs=1e-15)


def test_inverse_kinematics_of_a_tip_and_back(psp3_command: Run) -> None:
    tip = [-0.015, -0.005, 0.05]
    heights = psp3_command("pose", "--tip", "-0.015,-0.005,0.05", "--json").json["heights"]
    again = psp3_command("pose", f"--heights={','.join(map(repr, heights))}", "--json").json
    np.testing.assert_allclose(again["tip"], tip, atol=1e-14)


def test_pose_as_a_table(psp3_command: Run) -> None:
    answer = psp3_command("pose", "--heights", "0,0,0")
    assert (answer.status, answer.err) == (0, "")
    for text in (
        "nut heights 0.000000 0.000000 0.000000 m",
        "tip 0.000000 0.000000 0.070000 m",
        "tilt 0 degrees",
        "0.181000",
    ):
        assert text in words(answer.out)
    assert "-0.0" not in answer.out
    assert "Outside the stroke" not in answer.out
    assert "Outside the stroke" in psp3_command("pose", "--height", 0.5).out


# dynamics


@pytest.mark.parametrize("parameters", ["default", "table_5_1"])
def test_dynamics_agrees_with_the_projected_tree(psp3_command: Run, parameters: str) -> None:
    """Another implementation; the bar between the two is 1e-9 of the largest entry."""
    a, v, w = [0.15, 0.25, 0.15], [-0.1, 0.2, 0.3], [1.0, -2.0, 0.5]
    options = (
        "--heights",
        "0.15,0.25,0.15",
        "--speeds",
        "-0.1,0.2,0.3",
        "--accelerations",
        "1,-2,0.5",
        "--parameters",
        parameters,
    )
    found = psp3_command("dynamics", *options, "--json").json
    M, C, G = (
        psp3.load("psp3", parameters=parameters).dynamics("pinocchio").equation_of_motion(a, v)
    )
    for name, expected in (("M", M), ("C", C), ("G", G), ("forces", M @ w + C @ v + G)):
        np.testing.assert_allclose(
            found[name], expected, rtol=0.0, atol=1e-9 * np.abs(expected).max()
        )
    assert "kg/s" in psp3_command("dynamics", *options).out


def test_dynamics_rests_unless_told_otherwise(psp3_command: Run) -> None:
    found = psp3_command("dynamics", "--heights", "0.1,0,-0.1", "--json").json
    np.testing.assert_array_equal(found["forces"], found["G"])
    np.testing.assert_array_equal(np.abs(found["C"]), 0.0)


# simulate


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


def test_every_trajectory_and_its_options(psp3_command: Run) -> None:
    recorded = Path("recorded.csv")
    assert (
        psp3_command(
            "torques",
            "--trajectory",
            "circle",
            "--radius",
            0.005,
            "--turn-time",
            0.5,
            "--csv",
            recorded,
        ).status
        == 0
    )
    for given, expected in (
        (
            ("helix", "--radius", 0.01, "--turn-time", 1, "--rise", -0.02, "--start-height", 0.1),
            ([0.01, 0.0, 0.1], [-0.01, 0.0, 0.09]),
        ),
        (("circle", "--radius", 0.01, "--turn-time", 1), ([0.01, 0.0, 0.07], [-0.01, 0.0, 0.07])),
        (
            ("line", "--start", "-0.01,0,0.06", "--end", "0.01,0,0.07", "--travel-time", 1),
            ([-0.01, 0.0, 0.06], [0.0, 0.0, 0.065]),
        ),
        (
            (
                "point-to-point",
                "--start",
                "-0.01,0,0.06",
                "--end",
                "0.01,0,0.07",
                "--travel-time",
                1,
            ),
            ([-0.01, 0.0, 0.06], [0.0, 0.0, 0.065]),
        ),
        (("hold", "--tip", "0.01,-0.01,0.05"), ([0.01, -0.01, 0.05], [0.01, -0.01, 0.05])),
        ((f"csv:{recorded}",), ([0.005, 0.0, 0.07], [0.005, 0.0, 0.07])),
    ):
        trajectory, *others = given
        found = psp3_command(
            "torques",
            "--trajectory",
            trajectory,
            *others,
            "--duration",
            0.5,
            "--sampling-period",
            0.25,
            "--json",
        ).json
        assert found["t"] == [0.0, 0.25, 0.5]
        tip = np.transpose([found[name] for name in "xyz"])
        np.testing.assert_allclose(tip[[0, 2]], expected, atol=1e-8)


def test_duration_is_that_of_the_motion_unless_given(psp3_command: Run) -> None:
    segment = (
        "--trajectory",
        "point-to-point",
        "--start",
        "0,0,0.07",
        "--end",
        "0.01,0,0.07",
        "--travel-time",
        0.3,
    )
    assert psp3_command("torques", *segment, "--json").json["t"][-1] == pytest.approx(0.3)
    assert psp3_command("torques", "--trajectory", "hold", "--sampling-period", 0.1, "--json").json[
        "t"
    ][-1] == pytest.approx(10.4)


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


# torques


def test_torques_are_those_of_the_library(psp3_command: Run) -> None:
    expected = screw_forces(psp3.trajectories.Helix(robot=ROBOT), 0.01 * np.arange(51)).columns()
    found = psp3_command("torques", "--duration", 0.5, "--json").json
    rows = list(
        csv.DictReader(psp3_command("torques", "--duration", 0.5, "--csv", "-").out.splitlines())
    )
    for name, values in expected.items():
        np.testing.assert_array_equal(found[name], values)
        np.testing.assert_array_equal([float(row[name]) for row in rows], values)
    other = psp3_command("torques", "--duration", 0.5, "--model", "noc", "--json").json
    np.testing.assert_allclose(other["force1"], expected["force1"], rtol=1e-9)


def test_torques_write_and_print(psp3_command: Run) -> None:
    answer = psp3_command(
        "torques", "--duration", 1, "--csv", "forces.csv", "--figure", "forces.png"
    )
    assert answer.out.splitlines()[-2:] == ["forces.csv", "forces.png"]
    assert Path("forces.png").read_bytes().startswith(b"\x89PNG")
    heights = 1e3 * ROBOT.inverse_kinematics_tip([0.02, 0.0, 0.07])
    assert f"{heights[0]:.2f}" in answer.out
    assert max(map(len, answer.out.splitlines())) <= 80


# workspace


@pytest.mark.parametrize("over", ["tilt", "tip"])
def test_map_of_the_workspace(psp3_command: Run, over: str) -> None:
    answer = psp3_command(
        "workspace", "--over", over, "--resolution", 5, "--figure", "map.pdf", "--json"
    )
    found = answer.json
    assert answer.err == ""
    assert Path("map.pdf").read_bytes().startswith(b"%PDF")
    assert {
        np.shape(found["map"][name])
        for name in ("tilt", "azimuth", "parasitic_motion", "tip_condition")
    } == {(5, 11)}
    pose = ROBOT.forward_kinematics(found["map"]["heights"][3][4])
    np.testing.assert_allclose(found["map"]["tip"][3][4], pose.tip, atol=1e-15)
    assert found["map"]["parasitic_motion"][3][4] == pytest.approx(
        np.hypot(*pose.center[:2]), abs=1e-15
    )
    assert np.cos(np.radians(found["map"]["tilt"][3][4])) == pytest.approx(
        pose.rotation[2, 2], abs=1e-14
    )
    assert found["reach"]["least"] == pytest.approx(ROBOT.tip_reach(0.0), rel=1e-12)
    assert found["reach"]["greatest"] == pytest.approx(ROBOT.tip_reach(np.pi), rel=1e-12)
    assert min(found["border"]["largest_tilt"]) == pytest.approx(np.degrees(np.arccos(1.0 / 3.0)))


def test_poses_that_do_not_exist_are_null(psp3_command: Run) -> None:
    found = psp3_command("workspace", "--largest-tilt", 80, "--resolution", 5, "--json").json["map"]
    # The second direction of a map of 11 is 36 degrees from −x, near −150 where an arm vanishes at
    # 70.53 degrees.
    assert found["travel"][-1][1] is None
    assert found["arms"][-1][1] == [None, None, None]
    assert found["tilt"][-1][1] == pytest.approx(80.0)


def test_workspace_as_a_table(psp3_command: Run) -> None:
    text = words(psp3_command("workspace", "--resolution", 10).out)
    assert "reach of the tip 23.91 53.25 mm" in text
    assert "arm vanishes 70.53 90.00 degrees" in text
    assert "tip folds 33.28 37.72 degrees" in text
    assert "condition of the tip Jacobian 1.828 ∞" in text
    assert "∞" not in psp3_command("workspace", "--largest-tilt", 20).out


# view


def test_recorded_page_holds_the_pose_or_the_motion(psp3_command: Run) -> None:
    for name in ("pd", "ctc"):
        psp3_command("simulate", "--controller", name, "--duration", 0.2, "--out", f"{name}.npz")
    assert psp3_command("view", "--heights", "-0.05,0,0.05", "--record", "pose.html") == (
        0,
        "pose.html\n",
        "",
    )
    assert (
        psp3_command(
            "view", "--result", "pd.npz", "--result", "ctc.npz", "--record", "motion.html"
        ).status
        == 0
    )
    still, moving = (
        Path(name).read_text(encoding="utf-8") for name in ("pose.html", "motion.html")
    )
    assert len(moving) > len(still) > 500_000
    # Robots that stand side by side carry their names.
    assert all(f'"text":"{name}"' in moving for name in ("pd", "ctc"))


def test_recorded_page_holds_the_controllers_or_the_trajectory(psp3_command: Run) -> None:
    """Two robots under their names, ghosts and forces.

    A trajectory alone has neither ghost nor force.
    """
    psp3_command("train", "learned.json", "--kind", "t1")
    options = (
        "--controller",
        "pd",
        "--controller",
        "it2",
        "--trained",
        "learned.json",
        "--radius",
        0.01,
        "--duration",
        0.2,
    )
    assert psp3_command("view", *options, "--record", "controllers.html") == (
        0,
        "controllers.html\n",
        "",
    )
    assert (
        psp3_command(
            "view", "--trajectory", "circle", "--duration", 0.2, "--record", "circle.html"
        ).status
        == 0
    )
    simulated, desired = (
        Path(name).read_text(encoding="utf-8") for name in ("controllers.html", "circle.html")
    )
    assert all(
        f'"text":"{name}"' in simulated for name in ("pd", "it2", "learned.json", "desired pose")
    )
    assert "/meshcat/robots/2/ghost/" in simulated
    assert all(f"/meshcat/robots/0/{part}" in desired for part in ("actual", "visuals/a1"))
    assert "/ghost/" not in desired
    assert "force/head" not in desired


def heed_interrupts() -> None:
    """Undo what a shell does to jobs in the background.

    They ignore interrupts, and so would what they start.
    """
    signal.signal(signal.SIGINT, signal.SIG_DFL)


@pytest.mark.parametrize("options", [(), ("--heights", "0.02,0,-0.02")])
def test_viewer_serves_until_interrupted(options: tuple[str, ...]) -> None:
    process = subprocess.Popen(
        [*PROGRAM, "view", "--port", "7310", *options],
        env=ENVIRONMENT,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=heed_interrupts,
    )
    try:
        assert process.stdout is not None
        url = process.stdout.readline().split()[0]
        assert url.startswith("http://127.0.0.1:73")
        with urllib.request.urlopen(url, timeout=10) as page:
            assert b"<html" in page.read()[:200]
        process.send_signal(signal.SIGINT)
        _, err = process.communicate(timeout=20)
    finally:
        process.kill()
        process.wait()
    assert process.returncode == 0
    assert err.strip() == ""


# info


def test_info_names_what_the_robot_is_made_of(psp3_command: Run) -> None:
    found, text = psp3_command("info", "--json").json, words(psp3_command("info").out)
    assert [joint["name"] for joint in found["joints"]] == list(ROBOT.model.names)[1:]
    assert [joint["name"] for joint in found["joints"] if joint["actuated"]] == ["a1", "a2", "a3"]
    assert set(found["parameters"]) == set(psp3.PARAMETER_SETS)
    assert found["parameters"]["default"]["total_mass"] == pytest.approx(26.496)
    assert found["stroke"] == {"lower": -0.4, "upper": 0.4}
    assert found["loops"][0]["frames"] == ["star1_center", "star2_center"]
    assert found["versions"]["psp3"] == psp3.__version__
    assert found["robots"] == list(ROBOTS)
    for part in (
        "gough_stewart",
        "23.9 mm at azimuth 0°",
        "a1, a2, a3",
        "26.496",
        "0.4 m",
        "table_5_1",
    ):
        assert part in text


# reproduce


def test_reproduce_prints_the_tables_and_the_files(psp3_command: Run) -> None:
    answer = psp3_command("reproduce", "--quick", "--out", "deep/results")
    assert answer.status == 0
    assert f"{published.TABLE_6_3['PD']:.4f}" in answer.out
    files = [Path(line) for line in answer.out.splitlines() if line.startswith("deep")]
    assert {"report.html", "results.json"} <= {path.name for path in files}
    assert all(path.exists() for path in files)
    assert max(map(len, answer.out.splitlines())) <= 80
    # Words and numbers are never cut in two: every heading and every verdict is there.
    assert all(
        word in words(answer.out)
        for word in ("controller", "largest", "reproduced", "10.0161 -0.5288 -0.6026")
    )
    steps = answer.err.splitlines()
    assert steps[0].startswith("[1/")
    assert len(steps) == int(steps[0].split("/")[1].split("]")[0])


# What is refused, and how


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ("nosuch", "No such command 'nosuch'"),
        ("simulat", "No such command 'simulat'"),
        ("--nosuch", "No such option: --nosuch"),
        ("pose", "psp3 pose: give one of --heights, --tip, or --height"),
        ("pose --heights 0,0,0 --tip 0,0,0.07", "give one of"),
        ("pose --heights 0,0,0 --azimuth 0", "give one of"),
        ("pose --heights 1,2", "'--heights': '1,2' has 2 numbers"),
        ("pose --heights a,b,c", "'a,b,c' is not a list of numbers"),
        ("pose --heights 0,nan,0", "nan"),
        ("pose --heights -0.6,0,0.6", "arm lengths"),
        ("pose --tip 0.03,0,0.07", "robot reaches 23.9 mm"),
        ("pose --tilt 90", "--tilt must be less than 90 degrees, got 90"),
        ("pose --tilt nan", "got nan"),
        ("pose --tilt 75 --azimuth 30", "70.53"),
        ("dynamics", "Missing option '--heights'"),
        ("dynamics --heights 0,0,0 --speeds 0,0,inf", "speeds"),
        (
            "dynamics --heights 0,0,0 --parameters mine",
            "'mine' is not one of 'default', 'table_3_1', 'table_5_1'",
        ),
        ("simulate --controller fuzzy", "'fuzzy' is not one of 'pd'"),
        ("simulate --ki 3", "--ki does not apply to --controller ctc, which takes --kp and --kv"),
        (
            "simulate --controller feed-forward --kp 3",
            "--kp does not apply to --controller feed-forward",
        ),
        ("simulate --controller pd --model noc", "--model does not apply to --controller pd"),
        ("simulate --kp -1", "kp must be finite and not negative, got -1.0"),
        ("simulate --radius 0.03", "tip [0.03"),
        ("simulate --radius -0.01", "radius must be"),
        ("simulate --start-height 0.5", "outside the stroke"),
        ("simulate --period 0", "period must be finite and positive, got 0.0"),
        ("simulate --period two", "'--period'"),
        ("simulate --duration -1", "duration must be finite and positive, got -1.0"),
        ("simulate --duration 1e15", "memory"),
        ("simulate --torque-limit 0", "'0' is not one positive number or three"),
        ("simulate --torque-limit 1,2", "'1,2' is not one positive number or three"),
        ("simulate --trajectory spiral", "--trajectory must be helix, circle"),
        ("simulate --trajectory helix:3", "--trajectory must be helix, circle"),
        ("simulate --trajectory line", "--trajectory line needs --start and --end"),
        (
            "simulate --trajectory hold --radius 0.01",
            "--radius does not apply to --trajectory hold, which takes --tip",
        ),
        (
            "simulate --trajectory circle --rise 0.01",
            "--rise does not apply to --trajectory circle",
        ),
        ("simulate --trajectory csv", "csv:FILE"),
        ("simulate --trajectory csv:none.csv", "none.csv: cannot be read"),
        (
            "simulate --trajectory csv:here.csv --radius 1",
            "--radius does not apply to --trajectory csv",
        ),
        ("simulate --out none/run.npz", "none/run.npz: there is no directory none"),
        ("simulate --out .", ". is a directory"),
        ("simulate --figure run.gif", "must end in .pdf, .png, .svg"),
        ("simulate --json --csv -", "both want standard output"),
        ("simulate more", "(more)"),
        ("torques --sampling-period 0", "sampling period must be finite and positive, got 0.0"),
        ("torques --duration inf", "duration must be finite and positive, got inf"),
        ("torques --trajectory hold --tip 0,0,nan", "nan"),
        (
            "workspace --largest-tilt 90",
            "--largest-tilt must be positive and less than 90 degrees, got 90",
        ),
        ("workspace --over tip --largest-tilt 10", "--largest-tilt does not apply to --over tip"),
        ("workspace --resolution 1", "'--resolution'"),
        ("view --result none.npz --record page.html", "none.npz"),
        ("view --heights 0,0,0 --result run.npz", "give --heights or --result, not both"),
        ("view --port 0", "'--port'"),
        (
            "view --radius 0.01",
            "--radius does not apply to a view without --trajectory, --controller or --trained",
        ),
        ("view --heights 0,0,0 --controller pd", "--heights is for a robot at rest"),
        (
            "view --result run.npz --trajectory helix",
            "--trajectory does not apply to --result, which has its own",
        ),
        ("view --controller none", "'--controller'"),
        ("view --trained none.json --duration 0.1 --record page.html", "none.json"),
        ("reproduce --out here.csv", "here.csv"),
        ("reproduce --out here.csv/results", "here.csv"),
    ],
)
def test_wrong_input_is_one_line_and_status_2(
    psp3_command: Run, arguments: str, message: str
) -> None:
    Path("here.csv").write_text("t,x,y,z\n0,0,0,0.07\n")
    answer = psp3_command(*arguments.split())
    assert (answer.status, answer.out) == (2, "")
    assert message in answer.err
    assert answer.err.count("\n") == 1
    assert answer.err.startswith("psp3")
    # Only what was there before is there now: nothing is half written.
    assert [path.name for path in Path.cwd().iterdir()] == ["here.csv"]


def test_output_that_fails_while_it_is_written_is_one_line_and_status_2(
    psp3_command: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(_: int) -> NoReturn:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.fsync", full)
    assert psp3_command("torques", "--duration", 0.1, "--csv", "run.csv") == (
        2,
        "",
        "psp3: run.csv: No space left on device\n",
    )


def test_errors_of_the_program_itself_are_not_hidden(monkeypatch: pytest.MonkeyPatch) -> None:
    """A defect needs its traceback: only what a user can mend becomes one line."""

    def broken(*_: object) -> NoReturn:
        raise RuntimeError("a defect")

    monkeypatch.setattr("psp3.cli.commands.robot.load_robot", broken)
    monkeypatch.setattr(sys, "argv", ["psp3", "pose", "--heights", "0,0,0"])
    monkeypatch.setattr(sys, "excepthook", sys.excepthook)
    with pytest.raises(RuntimeError, match="a defect"):
        cli.main()


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
def test_full_disk_at_standard_output() -> None:
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(
            [*PROGRAM, "info", "--json"],
            env=ENVIRONMENT,
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
            timeout=60,
        )
    assert (done.returncode, done.stderr) == (2, "psp3: No space left on device\n")


@pytest.mark.parametrize(
    "arguments",
    [
        ("workspace", "--resolution", "60", "--json"),
        ("info",),
        ("torques", "--csv", "-"),
        ("--help",),
    ],
)
def test_reader_that_leaves_early_is_no_error_to_speak_of(arguments: tuple[str, ...]) -> None:
    process = subprocess.Popen(
        [*PROGRAM, *arguments],
        env=ENVIRONMENT,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None
    assert process.stderr is not None
    process.stdout.close()
    err = process.stderr.read()
    process.stderr.close()
    assert process.wait(timeout=60) == 1
    assert err == ""


def test_interrupt_is_one_line_and_status_130(
    psp3_command: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(*_: object, **__: object) -> NoReturn:
        raise KeyboardInterrupt

    monkeypatch.setattr("psp3.simulation.tracking.simulate", interrupted)
    assert psp3_command("simulate") == (130, "", "psp3: interrupted\n")


def test_terminal_without_greek_gets_replacements_instead_of_an_error() -> None:
    environment = ENVIRONMENT | {"PYTHONIOENCODING": "ascii"}
    done = subprocess.run(
        [*PROGRAM, "info"], env=environment, capture_output=True, text=True, timeout=60, check=True
    )
    assert "kg m?" in done.stdout


def test_progress_goes_to_standard_error_of_a_terminal_only(psp3_command: Run) -> None:
    assert psp3_command("simulate", "--model", "pinocchio", "--duration", 0.1).err == ""


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
        (("train", "a.json", "--terms", "3"), "fired by no sample"),
        (("train", "a.json", "--snr", "nan"), "snr_db"),
        (("train", "a.json", "--trajectory", "hold"), "every difference input changes"),
        (("train", "missing/a.json"), "no directory"),
        (
            ("simulate", "--trained", "missing.json"),
            "missing.json: cannot be read (No such file or directory)",
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


def test_a_page_is_not_written_under_the_name_of_a_picture(psp3_command: Run) -> None:
    answer = psp3_command("view", "--record", "page.png")
    assert answer.status == options.USAGE
    assert "must end in .html" in answer.err
    assert not Path("page.png").exists()
