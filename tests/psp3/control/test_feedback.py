"""Feedback along coordinates is refused where motors act elsewhere, in a simulation and in C."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

import psp3
from psp3.control.feedback import check_feedback
from psp3.errors import InvalidValue
from psp3.export.face import c_code
from psp3.trajectories import Sway
from tests.psp3.export.robots_of_all_kinds import MAKERS

REMEDY = "model=robot"


@pytest.mark.parametrize("name", ["walker", "gripper", "rod"])
def test_motors_that_are_the_first_coordinates_take_forces_along_them(
    name: str, tmp_path: Path
) -> None:
    """Whatever the coordinates do that follow."""
    check_feedback(MAKERS[name](tmp_path), psp3.PD())


@pytest.mark.parametrize("name", ["planar_4rrr", "over_actuated", "standing"])
def test_forces_along_coordinates_are_none_of_more_motors(name: str, tmp_path: Path) -> None:
    robot: Any = MAKERS[name](tmp_path)
    for controller in (psp3.PD(), psp3.PID()):
        with pytest.raises(InvalidValue, match=REMEDY):
            check_feedback(robot, controller)
        with pytest.raises(InvalidValue, match=REMEDY):
            psp3.simulate(robot, controller, Sway(robot=robot), 0.1)
        with pytest.raises(InvalidValue, match=REMEDY):
            c_code(controller, robot=robot)
    check_feedback(robot, psp3.PD(model=robot))
