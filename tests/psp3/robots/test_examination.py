"""What is said about a robot: counts that are known, and faults that were put in."""

from __future__ import annotations

import logging
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

import psp3
from psp3.description.parts import ROBOTS
from psp3.robots import examination
from psp3.robots.examination import examine
from psp3.robots.second_opinion import Opinion
from tests.psp3.closure.rounded import EXACT, Parts, flat_triangle, four_bar, short_lever

FIVE_BAR = psp3.load("five_bar")


def changed(**options: object) -> psp3.ClosedLoopRobot:
    """Return the five-bar with another model or other motors."""
    given = {"model": FIVE_BAR.model, "actuated": FIVE_BAR.actuated} | options
    model, motors = given["model"], given["actuated"]
    return psp3.ClosedLoopRobot(model, FIVE_BAR.constraint_models, motors, FIVE_BAR.q0)  # type: ignore[arg-type]


def test_a_sound_robot_has_no_findings() -> None:
    found = examine(FIVE_BAR)
    assert (found.bodies, found.motors, found.redundant_equations) == (4, FIVE_BAR.actuated, 1)
    assert found.loops == (("tip-leg2_end", "3d"),)
    assert found.mass == pytest.approx(
        sum(inertia.mass for inertia in list(FIVE_BAR.model.inertias)[1:])
    )
    assert found.findings == ()


def test_motors_that_are_missing_or_too_many_are_told() -> None:
    (held,) = examine(changed(actuated=["leg1_shoulder"])).findings
    assert "no motor commands" in held.what
    (more,) = examine(changed(actuated=[*FIVE_BAR.actuated, "leg1_elbow"])).findings
    assert more.what.startswith("1 more motor than freedoms")


def test_motions_that_are_held_are_one_finding_of_a_kind() -> None:
    (spins,) = examine(psp3.load("hexa")).findings
    balls = ", ".join(f"leg{leg}_ball" for leg in range(1, 7))
    assert spins.what == f"no motor commands the spin of {balls}: held at home"
    whats = [one.what for one in examine(psp3.load("biped", free="lock")).findings]
    assert len(whats) == 2
    assert whats[0].startswith("no motor commands left_")
    assert "the spin of" in whats[1]


def test_a_home_beyond_its_limits_is_told() -> None:
    model = FIVE_BAR.model.copy()
    at = model.joints[model.getJointId("leg1_elbow")].idx_q
    model.upperPositionLimit[at] = FIVE_BAR.q0[at] - 0.1
    (found,) = examine(changed(model=model)).findings
    assert f"leg1_elbow at {FIVE_BAR.q0[at]:.6g}, above" in found.what


def test_what_mujoco_reads_otherwise_is_told() -> None:
    robot = psp3.load("five_bar")
    assert float(examine(robot).mujoco.removeprefix("agrees to ")) < 1e-9
    robot.model.inertias[2] = robot.model.inertias[2] + robot.model.inertias[2]
    found = examine(robot)
    assert found.mujoco.startswith("disagrees: the mass that hangs on leg")
    assert "MuJoCo reads" in found.findings[-1].what


@pytest.mark.parametrize(("count", "words"), [(1, "1 number"), (2, "2 numbers")])
def test_what_mujoco_reads_otherwise_is_counted(
    count: int, words: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    opinion = Opinion("disagrees", ("a mass",) * count)
    monkeypatch.setattr(examination, "mujoco_opinion", lambda robot: opinion)
    (found,) = examine(FIVE_BAR).findings
    assert found.what == f"MuJoCo reads {words} of this file otherwise"


@pytest.mark.parametrize("excess", [1e-3, 0.5])
def test_inertia_that_no_body_has_is_told_with_its_size(excess: float) -> None:
    """Moments 1, 1 and 2 are a thin disk's, the border of what can be."""
    model = FIVE_BAR.model.copy()
    moments = 1e-3 * np.diag([1.0, 1.0, 2.0 * (1.0 + excess)])
    model.inertias[2] = pin.Inertia(0.1, np.zeros(3), moments)
    (found,) = examine(changed(model=model)).findings
    share = 100.0 * excess / (1.0 + excess)
    assert f"exceeds the sum of the other two by {share:.2g} %" in found.what
    assert ("rounding may have done it" in found.what) == (excess == 1e-3)


def test_coordinate_that_moves_nothing_is_told() -> None:
    model = FIVE_BAR.model.copy()
    for k in range(1, model.njoints):
        model.inertias[k] = pin.Inertia(1e-14, np.zeros(3), 1e-16 * np.eye(3))
    model.inertias[1] = pin.Inertia(1.0, np.zeros(3), np.eye(3))
    whats = [found.what for found in examine(changed(model=model)).findings]
    assert any("moves next to nothing" in what for what in whats)


ARM = {
    "urdf": """<robot name="r"><link name="base"/><link name="arm"/><link name="tool">{mass}</link>
<link name="tip"/><joint name="hinge" type="continuous"><parent link="base"/><child link="arm"/>
<axis xyz="0 1 0"/></joint><joint name="slide" type="prismatic"><parent link="arm"/>
<child link="tool"/><axis xyz="1 0 0"/><limit lower="-1" upper="1" effort="1" velocity="1"/>
</joint><joint name="weld" type="fixed">
<parent link="{welded}"/><child link="tip"/><origin xyz="1 0 0"/></joint></robot>""",
    "xml": """<mujoco model="r"><worldbody><body name="arm"><joint name="hinge" axis="0 1 0"/>
<geom size=".1" mass="0"/><body name="tool"><joint name="slide" type="slide" axis="1 0 0"/>
{mass}</body></body></worldbody></mujoco>""",
    "sdf": """<sdf version="1.9"><model name="r"><link name="base"/><link name="arm">
<inertial><mass>0</mass><inertia><ixx>0</ixx><iyy>0</iyy><izz>0</izz></inertia></inertial></link>
<link name="tool">{mass}</link><joint name="weld" type="fixed"><parent>world</parent>
<child>base</child></joint><joint name="hinge" type="revolute"><parent>base</parent>
<child>arm</child><axis><xyz>0 1 0</xyz></axis></joint><joint name="slide" type="prismatic">
<parent>arm</parent><child>tool</child><axis><xyz>1 0 0</xyz></axis></joint></model></sdf>""",
}
"""An arm without mass, on which a tool slides."""

MASS = {
    "urdf": """<inertial><origin xyz="1 0 0"/><mass value="1"/>
<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>""",
    "xml": '<geom size=".1" pos="1 0 0"/>',
    "sdf": "",
}
"""The tool's mass."""


@pytest.mark.parametrize("kind", ARM)
def test_a_moving_link_without_mass_is_told(kind: str, tmp_path: Path) -> None:
    """It has no effect on forces here, because its coordinate carries the tool, too."""
    path = tmp_path / f"robot.{kind}"
    path.write_text(ARM[kind].format(mass=MASS[kind], welded="tool"))
    (found,) = examine(psp3.load(path, actuated=["hinge", "slide"])).findings
    assert found.what == "the moving link arm has no mass"


def test_links_without_mass_are_told_once_for_all_that_is_fixed_to_them(tmp_path: Path) -> None:
    path = tmp_path / "robot.urdf"
    path.write_text(ARM["urdf"].format(mass=MASS["urdf"], welded="arm"))
    assert "link arm has" in examine(psp3.load(path)).findings[0].what
    model = psp3.load(path).model
    model.inertias[2] = pin.Inertia.Zero()
    model.armature[:] = 1.0
    (found,) = examine(psp3.ClosedLoopRobot(model, [], ["hinge", "slide"])).findings
    assert found.what == "the moving links arm, tool have no mass"


UNIVERSAL = {
    "urdf": """<robot name="r"><link name="base"/><link name="arm">{mass}</link>
<joint name="hinge" type="continuous"><parent link="base"/><child link="arm"/><axis xyz="0 1 0"/>
</joint></robot>""",
    "xml": """<mujoco model="r"><worldbody><body name="arm"><joint name="hinge_X" axis="1 0 0"/>
<joint name="hinge_Y" axis="0 1 0"/>{mass}</body></worldbody></mujoco>""",
    "sdf": """<sdf version="1.9"><model name="r"><link name="base"/><link name="arm">{mass}</link>
<joint name="weld" type="fixed"><parent>world</parent><child>base</child></joint>
<joint name="hinge" type="universal"><parent>base</parent><child>arm</child>
<axis><xyz>1 0 0</xyz></axis><axis2><xyz>0 1 0</xyz></axis2></joint></model></sdf>""",
}


@pytest.mark.parametrize("kind", UNIVERSAL)
def test_what_is_between_two_joints_of_a_body_needs_no_mass(kind: str, tmp_path: Path) -> None:
    """Neither in a universal joint nor in a body of two hinges."""
    path, loops = tmp_path / f"robot.{kind}", tmp_path / "loops.yaml"
    path.write_text(UNIVERSAL[kind].format(mass=MASS[kind]))
    if kind == "urdf":
        replaced = "joint_name: [hinge]\njoint_type: [UJOINT_XY]"
        loops.write_text(f"closed_loop: []\ntype: []\nname_mot: [hinge_X, hinge_Y]\n{replaced}")
        robot = psp3.ClosedLoopRobot.from_urdf(path, loops)
    else:
        names = ("X", "Y") if kind == "xml" else ("axis", "axis2")
        robot = psp3.load(path, actuated=[f"hinge_{name}" for name in names])
    assert robot.model.inertias[1].mass == 0.0
    assert examine(robot).findings == ()


@pytest.mark.parametrize("name", ROBOTS)
def test_no_link_of_our_robots_lacks_mass(name: str) -> None:
    whats = [found.what for found in examine(psp3.load(name)).findings]
    assert not any("no mass" in what for what in whats)


@pytest.mark.parametrize(
    "parts",
    [
        short_lever(7e-4, turntable=False),
        short_lever(7e-4, turntable=True),
        flat_triangle(0.0),
        four_bar(4),
    ],
)
def test_doubts_about_loops_are_those_of_the_warning(
    parts: Parts, caplog: pytest.LogCaptureFixture
) -> None:
    """Rounded loops, short levers that may be rounded, and a home that nothing leaves."""
    with caplog.at_level(logging.WARNING):
        robot = psp3.ClosedLoopRobot(
            parts.model, parts.loops, parts.motors, np.zeros(parts.model.nq)
        )
    told = [f"{robot.title}: {one.what}: {one.remedy}" for one in examine(robot).findings]
    assert caplog.messages[0] in told


def test_a_home_that_was_not_moved_is_not_told_of() -> None:
    """Where no home is given, the one that is found closes the loops as well as they can be."""
    for home, is_moved in ((np.zeros(3), True), (None, False)):
        parts = four_bar(4)
        robot = psp3.ClosedLoopRobot(parts.model, parts.loops, parts.motors, home)
        (found,) = examine(robot).findings
        assert ("home was moved by" in found.what) == is_moved
    exact = four_bar(EXACT)
    assert not examine(psp3.ClosedLoopRobot(*exact, np.zeros(3))).findings
