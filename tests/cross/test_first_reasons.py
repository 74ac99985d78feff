"""Why public files did not load at first: each reason once, in a small file through psp3.load.

What must come of a file was counted by hand. Other files compare the same kinds with MuJoCo in
depth; a tree whose joints are not chain by chain comes of no file and is in
``tests/psp3/robots/test_closed_loop_robot.py``.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

import psp3
from psp3.errors import InvalidRobotFile, LoopsDoNotClose, PSP3Error, UnknownName
from psp3.robots.second_opinion import mujoco_opinion
from tests.helpers import Array
from tests.mujoco_null_space import (
    biped,
    body,
    document,
    doubled,
    five_bar,
    gripper,
    hinge,
    motors,
    rod,
)


class Case(NamedTuple):
    """A file, how it is loaded, and what must come of it."""

    ending: str
    text: str
    freedoms: int
    coordinates: tuple[str, ...]
    held: tuple[str, ...] = ()
    options: dict[str, Any] = {}  # noqa: RUF012 # never changed


def link(name: str) -> str:
    """Return a link of a URDF."""
    return f"""<link name="{name}"><inertial><origin xyz=".1 .02 .03"/><mass value="1"/>
        <inertia ixx=".01" ixy="0" ixz="0" iyy=".012" iyz="0" izz=".014"/></inertial></link>"""


def joint(name: str, parent: str, child: str, place: str, kind: str, more: str = "") -> str:
    """Return a joint of a URDF about z, or in the plane across it."""
    return f"""<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>
        <origin {place}/><axis xyz="0 0 1"/>
        <limit lower="-3" upper="3" effort="1" velocity="1"/>{more}</joint>"""


def urdf(inside: str) -> str:
    """Return a URDF with a base."""
    return f'<?xml version="1.0"?><robot name="robot"><link name="base"/>{inside}</robot>'


def frame(name: str, parent: str, place: str) -> str:
    """Return a frame, as exporters write it: a link that is fixed, and nothing."""
    fixed = joint(f"{name}_frame", parent, name, place, "fixed")
    return f'<link name="{name}"/>{fixed}'


TURN = 'rpy="1.5708 0 0"'
"""Upright, but for 3.7e-6."""

ROUNDED = urdf(
    link("crank")
    + link("coupler")
    + link("rocker")
    + joint("turn", "base", "crank", f'xyz="0 0 0" {TURN}', "revolute")
    + joint("pin", "crank", "coupler", 'xyz=".12 .16 0"', "revolute")
    # What TURN does to y, by hand: z, to six digits.
    + joint("swing", "base", "rocker", 'xyz=".45 0 0" rpy="1.57079 0 0"', "revolute")
    + frame("closing_a_1", "coupler", 'xyz=".4 .14 0"')
    + frame("closing_a_2", "rocker", 'xyz=".07 .3 0"')
)

FOUR_BAR_SDF = """<sdf version="1.9"><model name="four_bar"><link name="crank"/>
    <link name="coupler"><pose>.2 0 .3 0 0 0</pose></link><link name="rocker">
    <pose>.8 0 0 0 0 0</pose></link>
    <joint name="turn" type="revolute"><parent>world</parent><child>crank</child>
     <axis><xyz>0 1 0</xyz></axis></joint>
    <joint name="pin" type="revolute"><parent>crank</parent><child>coupler</child>
     <axis><xyz>0 1 0</xyz></axis></joint>
    <joint name="swing" type="revolute"><parent>world</parent><child>rocker</child>
     <axis><xyz>0 1 0</xyz></axis></joint>
    <joint name="last" type="revolute"><pose relative_to="rocker">.1 0 .4 0 0 0</pose>
     <parent>rocker</parent><child>coupler</child><axis><xyz>0 1 0</xyz></axis></joint>
    </model></sdf>"""

SPRING = 'stiffness="30" springref=".2" damping=".3"'
COUPLED = '<joint joint1="m2" joint2="m1" polycoef="0 -1 .5 0 .2"/>'
BLOCK = "0 0 0  .2 0 0  0 .1 0  0 0 .1  .2 .1 0"
MESH = f"""<mujoco><asset><mesh name="block" vertex="{BLOCK}"/></asset><worldbody>
    <body><joint name="hinge"/><geom type="mesh" mesh="block"/></body></worldbody>
    <actuator><motor joint="hinge"/></actuator></mujoco>"""
COPIES = """<mujoco><worldbody><replicate count="3" offset=".5 0 0" euler="0 0 10"><body name="arm">
    <joint name="hinge" axis="0 1 0"/><geom size=".1" pos=".1 0 0"/></body></replicate></worldbody>
    <actuator/></mujoco>"""
FEET = ("l_hip", "l_motor", "r_hip", "r_motor")

CASES = {
    "a rod that spins": Case("xml", rod(), 2, ("crank",), ("ball",)),
    "a hinge that is there twice": Case("xml", doubled(), 2, ("crank",), ("pin1",)),
    "a floating base": Case("xml", biped(*FEET), 10, (*FEET, "root")),
    "a spring that nobody drives": Case("xml", five_bar("m1", spring=SPRING), 2, ("m1",), ("p1",)),
    "the inertia of a mesh": Case("xml", MESH, 1, ("hinge",)),
    "no actuators": Case("xml", five_bar(), 2, ("m1", "m2"), (), {"actuated": ["m1", "m2"]}),
    "rounded numbers": Case("urdf", ROUNDED, 1, ("turn",), (), {"actuated": ["turn"]}),
    "a motor on a tendon": Case("xml", gripper(), 3, ("l_driver",), ("l_spring", "r_spring")),
    "a joint that follows": Case("xml", five_bar("m1", more=COUPLED), 1, ("m1",)),
    "copies": Case(
        "xml", COPIES, 3, ("hinge0", "hinge1"), ("hinge2",), {"actuated": ["hinge0", "hinge1"]}
    ),
    "a joint that mimics": Case(
        "urdf",
        urdf(
            link("one")
            + link("two")
            + joint("a", "base", "one", 'xyz="0 0 .1"', "revolute")
            + joint(
                "b", "one", "two", 'xyz=".3 0 0"', "revolute", '<mimic joint="a" multiplier="-2"/>'
            )
        ),
        1,
        ("a",),
    ),
    "blanks before the declaration": Case(
        "urdf",
        "\n  " + urdf(link("one") + joint("a", "base", "one", 'xyz="0 0 .1"', "continuous")),
        1,
        ("a",),
    ),
    "more motors than freedoms": Case("xml", five_bar("m1", "m2", "p1"), 2, ("m1", "m2")),
    "a planar joint": Case(
        "urdf",
        urdf(
            link("cart")
            + link("arm")
            + joint("plane", "base", "cart", 'xyz="0 0 .1"', "planar")
            + joint("a", "cart", "arm", 'xyz=".3 0 0" rpy="1 0 0"', "revolute")
        ),
        4,
        ("a", "plane"),
    ),
    "SDF": Case("sdf", FOUR_BAR_SDF, 1, ("turn",), (), {"actuated": ["turn"]}),
}


def written(folder: Path, case: Case) -> Path:
    path = folder / f"robot.{case.ending}"
    path.write_text(case.text, encoding="utf-8")
    return path


def state(robot: psp3.ClosedLoopRobot) -> tuple[Array, Array, Array]:
    """Return home with speeds and accelerations."""
    speeds, accelerations = np.random.default_rng(0).uniform(
        -0.5, 0.5, (2, len(robot.coordinates_v))
    )
    return robot.reference, speeds, accelerations


@pytest.mark.parametrize("name", list(CASES))
def test_it_loads_and_moves(name: str, tmp_path: Path) -> None:
    """Freedoms, coordinates and what is held; forward dynamics undoes the inverse, to 1e-8."""
    case = CASES[name]
    robot = psp3.load(written(tmp_path, case), **case.options)
    assert robot.mobility.degrees_of_freedom == case.freedoms
    assert robot.coordinates == case.coordinates
    assert tuple(one.joint for one in robot.locked) == case.held
    positions, speeds, accelerations = state(robot)
    forces = robot.inverse_dynamics(positions, speeds, accelerations)
    found = robot.forward_dynamics(positions, speeds, forces)
    assert found == pytest.approx(accelerations, abs=1e-8)
    assert mujoco_opinion(robot).disagreements == ()


def test_rounded_numbers_are_told_and_small(tmp_path: Path) -> None:
    robot = psp3.load(written(tmp_path, CASES["rounded numbers"]), actuated=["turn"])
    assert 1e-8 < robot.closure_mismatch.length < 1e-5


REFUSED: dict[str, tuple[str, str, type[PSP3Error], str]] = {
    "loops that do not close": (
        "xml",
        document(
            body("arm", "0 0 0", hinge("m1"), '<site name="tip" pos=".2 0 0"/>')
            + body("far", "3 0 0", hinge("m2"), '<site name="end" pos=".2 0 0"/>'),
            '<connect name="loop" site1="tip" site2="end"/>',
            motors("m1"),
        ),
        LoopsDoNotClose,
        r"loop 'loop' stays open by at least 2\.",
    ),
    "a link that is misspelt": (
        "urdf",
        urdf(link("arm") + joint("a", "base", "amr", 'xyz="0 0 0"', "continuous")),
        InvalidRobotFile,
        "child link 'amr' is not in the file",
    ),
    "a motor that is misspelt": ("xml", five_bar("m11"), PSP3Error, "m11"),
}


@pytest.mark.parametrize("name", list(REFUSED))
def test_what_is_the_files_own_fault_is_named(name: str, tmp_path: Path) -> None:
    ending, text, error, told = REFUSED[name]
    with pytest.raises(error, match=told):
        psp3.load(written(tmp_path, Case(ending, text, 0, ())))


def test_a_motor_of_the_caller_that_is_misspelt_is_named(tmp_path: Path) -> None:
    case = CASES["no actuators"]
    with pytest.raises((UnknownName, InvalidRobotFile), match="m12"):
        psp3.load(written(tmp_path, case), actuated=["m12"])
