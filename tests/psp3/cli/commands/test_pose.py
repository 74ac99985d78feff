"""``psp3 pose``: the library's numbers."""

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


def test_pose_of_any_robot(psp3_command: Run) -> None:
    """Loops are closed, and the tip is where the robot says; it stands at its reference by default.

    The Delta's platform does not turn.
    """
    delta = psp3.load("delta")
    found = psp3_command("pose", "delta", "--positions", "0.2,0.1,-0.1", "--json").json
    np.testing.assert_array_equal(
        found["frames"]["tip"], delta.frame_placement([0.2, 0.1, -0.1], "tip")
    )
    np.testing.assert_allclose(np.array(found["frames"]["tip"])[:3, :3], np.eye(3), atol=1e-12)
    assert found["joints"]["leg2_shoulder"] == [0.1]
    assert found["within_limits"] is True
    at_rest = words(psp3_command("pose", "delta", "--frame", "leg1_rod2_end").out)
    assert "leg1_shoulder 0.000000 rad motor" in at_rest
    assert "leg1_rod2_end: origin" in at_rest
    assert "tip: origin" not in at_rest


def test_pose_beyond_a_limit_says_so(psp3_command: Run) -> None:
    answer = psp3_command("pose", "five_bar", "--positions=1.55,1.4")
    assert "Outside the limits of leg1_shoulder" in words(answer.out)


def test_frame_that_does_not_exist(psp3_command: Run) -> None:
    answer = psp3_command("pose", "delta", "--frame", "toe")
    assert answer.status == 2
    assert "toe" in answer.err
