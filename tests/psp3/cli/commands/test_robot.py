"""``psp3`` pose and dynamics: the library's numbers."""

from __future__ import annotations

import numpy as np
import pytest

import psp3
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
