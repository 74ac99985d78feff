"""Inertias of links that fixed joints join: judged as one body."""

from __future__ import annotations

import logging
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

import psp3
from psp3.errors import InvalidRobotFile


def arm(folder: Path, moments: str, joint: str = "fixed", upper: str = "revolute") -> Path:
    """Write an arm of 2 kg with a hand of 0.1 kg, whose moments are given."""
    path = folder / "arm.urdf"
    path.write_text(
        f"""<robot name="arm"><link name="base"/>
        <link name="upper"><inertial><origin xyz="0 0 .1" rpy=".1 .2 .3"/><mass value="2"/>
        <inertia ixx=".1" ixy="0" ixz="0" iyy=".1" iyz="0" izz=".1"/></inertial></link>
        <link name="hand"><inertial><origin xyz=".1 .2 0" rpy=".4 .5 .6"/><mass value=".1"/>
        <inertia {moments}/></inertial></link>
        <joint name="hinge" type="{upper}"><parent link="base"/><child link="upper"/>
        <axis xyz="0 1 0"/><limit effort="1" velocity="1" lower="-1" upper="1"/></joint>
        <joint name="wrist" type="{joint}"><parent link="upper"/><child link="hand"/>
        <origin xyz=".3 .4 .5" rpy=".7 .8 .9"/><axis xyz="0 0 1"/>
        <limit effort="1" velocity="1" lower="-1" upper="1"/></joint></robot>""",
        encoding="utf-8",
    )
    return path


SLIGHTLY = 'ixx="1e-3" ixy="2e-3" ixz="0" iyy="1e-3" iyz="0" izz="1e-3"'
"""Principal moments −1, 1 and 3 g m²."""


def test_a_part_that_is_no_body_is_told_where_the_whole_is_one(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """The sum is Pinocchio's of the same file, by another way."""
    with caplog.at_level(logging.WARNING):
        robot = psp3.load(arm(tmp_path, SLIGHTLY))
    assert "can be a body, and is taken as one: hand" in caplog.text
    hand = np.array([[1e-3, 2e-3, 0.0], [2e-3, 1e-3, 0.0], [0.0, 0.0, 1e-3]])
    turn = pin.rpy.rpyToMatrix(0.7, 0.8, 0.9)
    inside = turn @ pin.rpy.rpyToMatrix(0.4, 0.5, 0.6)
    center = np.array([0.3, 0.4, 0.5]) + turn @ np.array([0.1, 0.2, 0.0])
    about = inside @ hand @ inside.T - 0.1 * pin.skewSquare(center, center)
    up = np.array([0.0, 0.0, 0.1])
    expected = about + 0.1 * np.eye(3) - 2.0 * pin.skewSquare(up, up)
    inertia = robot.model.inertias[1]
    assert inertia.mass == pytest.approx(2.1)
    found = inertia.inertia - 2.1 * pin.skewSquare(inertia.lever, inertia.lever)
    assert np.allclose(found, expected, rtol=0.0, atol=1e-12)


def test_what_moves_by_itself_must_be_a_body(tmp_path: Path) -> None:
    with pytest.raises(InvalidRobotFile, match=r"name='hand'>: .* is negative, -0\.001 kg m²$"):
        psp3.load(arm(tmp_path, SLIGHTLY, "revolute"))
    much = SLIGHTLY.replace("2e-3", "2")
    with pytest.raises(InvalidRobotFile, match="and with all that is fixed to it, -1"):
        psp3.load(arm(tmp_path, much))


def test_what_stands_still_need_be_none(tmp_path: Path) -> None:
    """Fixed to the base of the tree, whose inertia nobody asks for."""
    path = arm(tmp_path, SLIGHTLY.replace("2e-3", "2"), "fixed", "fixed")
    text = path.read_text(encoding="utf-8").replace(
        "</robot>",
        """<link name="tool"><inertial><mass value="1"/>
        <inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
        <joint name="turn" type="continuous"><parent link="hand"/><child link="tool"/>
        <axis xyz="0 0 1"/></joint></robot>""",
    )
    path.write_text(text, encoding="utf-8")
    robot = psp3.load(path)
    assert robot.coordinates == ("turn",)
    assert robot.inverse_dynamics([0.3], [0.0], [1.0]) == pytest.approx([1.0])
