"""``psp3 workspace``: the map of the library, and where it ends."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import psp3
from tests.psp3.cli.answers import Run, words

ROBOT = psp3.load("psp3")


@pytest.mark.slow
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


@pytest.mark.slow
def test_workspace_of_another_robot(psp3_command: Run) -> None:
    """The five-bar's tip reaches as far as its two arms are long, to the ray's thousandth.

    Straight down they end at the same length: both arms stretched is a singularity of the end
    effector.
    """
    answer = psp3_command(
        "workspace", "five_bar", "--resolution", 9, "--figure", "map.pdf", "--json"
    )
    found = answer.json
    assert answer.err == ""
    assert Path("map.pdf").read_bytes().startswith(b"%PDF")
    assert found["task"] == ["x", "z"]
    assert np.shape(found["map"]["status"]) == (9, 9)
    left, right = (one["distance"] for one in found["reach"]["x"])
    assert left == pytest.approx(right, rel=1e-2)
    assert found["area"] > 0.0
    text = words(psp3_command("workspace", "five_bar", "--resolution", 5).out)
    assert "Reach of tip of five_bar" in text
    assert "usable" in text
