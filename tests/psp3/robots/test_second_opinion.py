"""What MuJoCo makes of files: it agrees with ours, and tells what was changed."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

import psp3
from psp3.description.parts import MJCF_ROBOTS, ROBOTS
from psp3.robots.second_opinion import mujoco_opinion

pytest.importorskip("mujoco")

INERTIA = '<inertia ixx="{0}" iyy="{1}" izz="{2}" ixy="0" ixz="0" iyz="0"/>'


def arm(folder: Path, middle: str = "", moments: tuple[float, ...] = (0.01, 0.02, 0.025)) -> Path:
    """Write an arm of two hinges and a slide; what is between the hinges is given."""
    inertial = (
        '<inertial><origin xyz=".1 .02 .03" rpy=".1 .2 .3"/><mass value="0.7"/>'
        + INERTIA.format(*moments)
        + "</inertial>"
    )
    mesh = '<geometry><mesh filename="nowhere.stl"/></geometry>'
    joint = """<joint name="{0}" type="{1}"><parent link="{2}"/><child link="{3}"/>
        <origin xyz=".3 0 .1" rpy=".4 .5 .6"/><axis xyz="0 .6 .8"/>
        <limit lower="-2" upper="2" effort="1" velocity="1"/></joint>"""
    path = folder / "arm.urdf"
    path.write_text(
        f"""<robot name="arm"><link name="base"/><link name="one">{middle}
        <visual>{mesh}</visual></link><link name="two">{inertial}</link>
        <link name="three">{inertial}</link>
        {joint.format("a", "revolute", "base", "one")}
        {joint.format("b", "continuous", "one", "two")}
        {joint.format("c", "prismatic", "two", "three")}</robot>""",
        encoding="utf-8",
    )
    return path


@pytest.mark.parametrize("name", ROBOTS)
def test_it_agrees_about_our_robots(name: str) -> None:
    """Two readers of the same numbers differ by rounding: 4e-11 of light joints was seen."""
    found = mujoco_opinion(psp3.load(name))
    assert found.disagreements == ()
    share = float(found.summary.removeprefix("agrees to "))
    assert share <= (1e-6 if name in MJCF_ROBOTS else 1e-9)


def test_meshes_that_are_missing_and_bodies_without_mass_do_not_matter(tmp_path: Path) -> None:
    found = mujoco_opinion(psp3.load(arm(tmp_path)))
    assert float(found.summary.removeprefix("agrees to ")) < 1e-9


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (pin.Inertia(0.2, np.zeros(3), np.zeros((3, 3))), "the mass that hangs on c: 0.9 here"),
        (pin.Inertia(0.0, np.zeros(3), np.diag([1e-5, 2e-5, 2e-5])), "the mass matrix at b"),
    ],
)
def test_what_was_changed_is_named(tmp_path: Path, change: pin.Inertia, told: str) -> None:
    robot = psp3.load(arm(tmp_path))
    robot.model.inertias[3] += change
    found = mujoco_opinion(robot)
    assert found.summary.startswith("disagrees: ")
    assert any(told in one for one in found.disagreements)
    assert re.search(r"; \d+ more$", found.summary)


def test_a_center_of_mass_that_is_elsewhere_is_seen_in_the_weight(tmp_path: Path) -> None:
    robot = psp3.load(arm(tmp_path))
    lever = np.array([0.0, 1e-4, 0.0])
    robot.model.inertias[2] = pin.SE3(np.eye(3), lever).act(robot.model.inertias[2])
    assert any("gravity and speeds at b" in one for one in mujoco_opinion(robot).disagreements)


def test_what_it_refuses_and_that_it_is_missing_is_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    robot = psp3.load(arm(tmp_path, moments=(0.01, 0.02, 0.05)))
    assert "A + B >= C" in mujoco_opinion(robot).summary
    monkeypatch.setitem(sys.modules, "mujoco", None)
    for one in (robot, psp3.load("gripper")):
        assert mujoco_opinion(one).summary == "not installed"


def test_an_mjcf_that_it_refuses_has_no_numbers_to_compare(tmp_path: Path) -> None:
    """A moving body without mass, which is allowed here, as in a URDF."""
    path = tmp_path / "arm.xml"
    path.write_text(
        """<mujoco><worldbody><body name="arm"><joint name="hinge" axis="0 1 0"/>
<geom size=".1" mass="0"/><body name="tool"><joint name="slide" type="slide" axis="1 0 0"/>
<geom size=".1" pos="1 0 0"/></body></body></worldbody></mujoco>"""
    )
    found = mujoco_opinion(psp3.load(path, actuated=["hinge", "slide"]))
    assert found.summary.startswith("refuses the file: Error: mass and inertia of moving bodies")
    assert "mjMINVAL" in found.summary
    assert found.disagreements == ()


def test_a_robot_of_no_file_has_no_opinion() -> None:
    robot = psp3.load("five_bar")
    made = psp3.ClosedLoopRobot(robot.model, robot.constraint_models, robot.actuated, robot.q0)
    assert mujoco_opinion(made).summary == ""
