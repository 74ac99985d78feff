"""Files of trained controllers of any robot; those of the 3-PSP are with its controller."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import psp3
from psp3.errors import InvalidControllerFile
from psp3.fuzzy_control.computed_torque import FuzzyComputedTorque
from psp3.trajectories.sway import Sway

ROBOTS = {name: psp3.load(name) for name in ("five_bar", "delta", "gough_stewart")}


def learned(name: str, coriolis: str = "rules") -> FuzzyComputedTorque:
    robot = ROBOTS[name]
    controller = FuzzyComputedTorque(
        "it2", robot, kp=900.0, kv=60.0, mean_variation=0.02, coriolis=coriolis, rules=8
    )
    return controller.fit(Sway(robot=robot), 2.0)


@pytest.mark.parametrize("name", ROBOTS)
@pytest.mark.parametrize("coriolis", ["rules", "mass"])
def test_controllers_of_any_robot_come_back_from_a_file(
    name: str, coriolis: str, tmp_path: Path
) -> None:
    controller = learned(name, coriolis=coriolis)
    path = controller.save(tmp_path / "controller.json")
    for robot in (None, ROBOTS[name]):
        again = FuzzyComputedTorque.load(path, robot)
        for one, other in zip(again.controller, controller.controller, strict=True):
            np.testing.assert_array_equal(one, other)
    again.save(tmp_path / "again.json")
    assert (tmp_path / "again.json").read_bytes() == path.read_bytes()


def test_files_for_another_robot_are_refused_by_name(tmp_path: Path) -> None:
    path = learned("five_bar").save(tmp_path / "controller.json")
    with pytest.raises(InvalidControllerFile, match=r"five_bar .* yours is delta"):
        FuzzyComputedTorque.load(path, ROBOTS["delta"])
    with pytest.raises(InvalidControllerFile, match="yours is 3-PSP robot"):
        FuzzyComputedTorque.load(path, psp3.load("psp3"))
    content = json.loads(path.read_text())
    content["robot"]["numbers_at_reference"][0] *= 1.01
    path.write_text(json.dumps(content))
    with pytest.raises(InvalidControllerFile, match="another mass or weight"):
        FuzzyComputedTorque.load(path)
    misspelled = content | {"defuzzifys": "last"}
    path.write_text(json.dumps(misspelled))
    with pytest.raises(InvalidControllerFile, match="has defuzzifys, which no controller has"):
        FuzzyComputedTorque.load(path)
    content["robot"]["name"] = "mine"
    path.write_text(json.dumps(content))
    with pytest.raises(InvalidControllerFile, match="give robot="):
        FuzzyComputedTorque.load(path)
