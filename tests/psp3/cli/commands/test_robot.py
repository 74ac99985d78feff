"""``psp3`` torques, pose, dynamics, workspace and info: what they print and write."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

import psp3
from psp3.description.parts import ROBOTS
from psp3.trajectories.screw_forces import screw_forces
from tests.psp3.cli.answers import Run, words

ROBOT = psp3.load("psp3")


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
