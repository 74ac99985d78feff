"""``psp3 torques``: every motion, and the forces of the library."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

import psp3
from psp3.trajectories.screw_forces import screw_forces
from tests.psp3.cli.answers import Run

ROBOT = psp3.load("psp3")


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


def test_forces_of_another_robot(psp3_command: Run) -> None:
    """By the projected tree; what sways starts at rest in the reference pose."""
    robot = psp3.load("five_bar")
    found = psp3_command(
        "torques", "five_bar", "--duration", 0.2, "--figure", "t.pdf", "--json"
    ).json
    assert found["a1"][0] == pytest.approx(robot.reference[0])
    assert found["speed1"][0] == pytest.approx(0.0, abs=1e-15)
    states = (
        np.array([found[f"{name}{k}"] for k in (1, 2)]).T for name in ("a", "speed", "acceleration")
    )
    expected = robot.dynamics("pinocchio").inverse_dynamics(*states)
    forces = np.array([found["force1"], found["force2"]]).T
    np.testing.assert_allclose(forces, expected, atol=1e-10)
    assert Path("t.pdf").read_bytes().startswith(b"%PDF")
    assert "sway: 21 samples" in psp3_command("torques", "five_bar", "--duration", 0.2).out
