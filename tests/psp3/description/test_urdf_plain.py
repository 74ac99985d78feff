"""A URDF in plain words: what Pinocchio is given is what was read, whatever the file's spelling."""

from __future__ import annotations

import logging
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from numpy.testing import assert_allclose

from psp3.description.urdf import read_tree
from psp3.description.urdf_plain import make_meshes_absolute, plain_urdf
from psp3.errors import InvalidRobotFile
from psp3.robots.closed_loop_robot import ClosedLoopRobot
from tests.psp3.description.written import joint, link, written

PENDULUM = (
    "<link name='base'/><link name='arm'><inertial><origin xyz='0.2 0 0'/><mass value='0.22'/>"
    "<inertia ixx='0.001' ixy='0' ixz='0' iyy='0.002' iyz='0' izz='0.0019'/></inertial></link>"
    "<joint name='j' type='revolute'><origin xyz='0 0 1' rpy='0 0 0.5'/><parent link='base'/>"
    "<child link='arm'/><axis xyz='0 0 1'/><limit lower='-1' upper='1' effort='5' velocity='3'/>"
    "<dynamics damping='0.1' friction='0.2'/></joint>"
)
"""A pendulum whose M11 is 0.0019 + 0.22 · 0.2² = 0.0107 kg m²."""


def mass_of(path: Path) -> float:
    robot = ClosedLoopRobot.from_urdf(path)
    return float(robot.mass_matrix([0.0])[0, 0])


@pytest.mark.parametrize("value", ["0.22", "0.22 ", " 0.22", "\n0.22\t", "+.22", "22e-2", "0.220"])
def test_a_mass_keeps_its_inertia_however_it_is_written(tmp_path: Path, value: str) -> None:
    """A blank behind it once cost the link its whole inertia; 1e-15 as M11 is a sum of two."""
    path = written(tmp_path / "r.urdf", PENDULUM.replace("value='0.22'", f"value='{value}'"))
    assert mass_of(path) == pytest.approx(0.0019 + 0.22 * 0.2**2, rel=1e-15)


@pytest.mark.parametrize(
    "value", ["0.2_2", "0x0.38", "０.２２", "0,22", "inf", "nan", "0.22 kg", ""]
)
@pytest.mark.parametrize(
    ("attribute", "number"),
    [
        ("value", "0.22"),
        ("iyy", "0.002"),
        ("lower", "-1"),
        ("effort", "5"),
        ("damping", "0.1"),
        ("friction", "0.2"),
    ],
)
def test_what_only_one_parser_reads_is_refused(
    tmp_path: Path, attribute: str, number: str, value: str
) -> None:
    old = f"{attribute}='{number}'"
    assert old in PENDULUM
    path = written(tmp_path / "r.urdf", PENDULUM.replace(old, f"{attribute}='{value}'"))
    with pytest.raises(InvalidRobotFile, match=f"{attribute} must be 1 finite number"):
        plain_urdf(path)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("xyz='0.2 0 0'", "xyz='0_2 0 0'"),
        ("xyz='0 0 1' rpy", "xyz='0 0 1_0' rpy"),
        ("rpy='0 0 0.5'", "rpy='0 0 ０.5'"),
        ("<axis xyz='0 0 1'/>", "<axis xyz='0 0 0x1'/>"),
        ("</joint>", "<mimic joint='j' multiplier='1_0'/></joint>"),
        ("</joint>", "<mimic joint='j' offset='inf'/></joint>"),
        (
            "</link><joint",
            "<visual><geometry><box size='1 1 1_0'/></geometry></visual></link><joint",
        ),
        (
            "</link><joint",
            "<visual><geometry><sphere radius='1d0'/></geometry></visual></link><joint",
        ),
    ],
)
def test_every_other_number_is_read_as_strictly(tmp_path: Path, old: str, new: str) -> None:
    assert old in PENDULUM
    with pytest.raises(InvalidRobotFile, match=r"must be \d finite number"):
        plain_urdf(written(tmp_path / "r.urdf", PENDULUM.replace(old, new)))


def test_an_entity_is_refused_and_a_character_reference_is_read(tmp_path: Path) -> None:
    path = tmp_path / "r.urdf"
    body = f"<robot name='r'>{PENDULUM}</robot>"
    path.write_text("<!DOCTYPE robot [<!ENTITY m '0.22'>]>" + body.replace("0.22", "&m;"))
    with pytest.raises(InvalidRobotFile, match="DOCTYPE"):
        mass_of(path)
    path.write_text(body.replace("0.22", "0&#46;22"))
    assert mass_of(path) == pytest.approx(0.0107, rel=1e-15)


def test_an_axis_of_any_length_is_a_direction(tmp_path: Path) -> None:
    """Pinocchio alone makes of 1e200 no axis, and of 1e-200 one of that length."""
    for text, direction in (
        ("1e200 0 0", [1.0, 0.0, 0.0]),
        ("0 -1e-200 0", [0.0, -1.0, 0.0]),
        ("3e-170 4e-170 0", [0.6, 0.8, 0.0]),
        ("0 3 4", [0.0, 0.6, 0.8]),
    ):
        new = PENDULUM.replace("<axis xyz='0 0 1'/>", f"<axis xyz='{text}'/>")
        model, _ = read_tree(written(tmp_path / "r.urdf", new))
        data = model.joints[1].createData()
        model.joints[1].calc(data, np.zeros(1))
        assert_allclose(np.asarray(data.S).ravel()[3:], direction, rtol=0, atol=1e-15)


@pytest.mark.parametrize(
    ("axis", "normal"),
    [
        ("", [1.0, 0.0, 0.0]),
        ("<axis xyz='0 0 2'/>", [0.0, 0.0, 1.0]),
        ("<axis xyz='0 1 0'/>", [0.0, 1.0, 0.0]),
        ("<axis xyz='0 0 -1'/>", [0.0, 0.0, -1.0]),
        ("<axis xyz='3 0 4'/>", [0.6, 0.0, 0.8]),
    ],
)
def test_a_planar_joint_moves_in_the_plane_of_its_axis(
    tmp_path: Path, axis: str, normal: list[float]
) -> None:
    """Pinocchio alone takes the plane z = 0. At rest the link is where the joint's origin is."""
    text = PENDULUM.replace("type='revolute'", "type='planar'")
    text = text.replace("<axis xyz='0 0 1'/>", axis)
    model, _ = read_tree(written(tmp_path / "r.urdf", text))
    assert model.joints[1].shortname() == "JointModelPlanar"
    arm = model.getFrameId("arm", pin.FrameType.BODY)
    turn = pin.rpy.rpyToMatrix(np.array([0.0, 0.0, 0.5]))
    data = model.createData()
    pin.framesForwardKinematics(model, data, pin.neutral(model))
    assert_allclose(data.oMf[arm].rotation, turn, rtol=0, atol=1e-15)
    assert_allclose(data.oMf[arm].translation, [0.0, 0.0, 1.0], rtol=0, atol=1e-15)
    for motion in np.eye(3)[:2]:
        pin.framesForwardKinematics(model, data, pin.integrate(model, pin.neutral(model), motion))
        moved = data.oMf[arm].translation - [0.0, 0.0, 1.0]
        assert_allclose(np.linalg.norm(moved), 1.0, rtol=1e-14)
        assert abs(moved @ turn @ np.array(normal)) < 1e-14
    spun = pin.integrate(model, pin.neutral(model), np.array([0.0, 0.0, 0.3]))
    pin.framesForwardKinematics(model, data, spun)
    about = pin.log3(turn.T @ data.oMf[arm].rotation)
    assert_allclose(about, 0.3 * np.array(normal), rtol=0, atol=1e-14)


def test_only_what_was_checked_is_handed_on(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """Elements of other programs are passed over, others are told of."""
    gazebo = "<gazebo><link name='x'/></gazebo><transmission><joint name='j'/></transmission>"
    path = written(
        tmp_path / "r.urdf",
        PENDULUM.replace("</joint>", "<spring stiffness='3'/></joint>"),
        gazebo,
    )
    with caplog.at_level(logging.WARNING, "psp3"):
        plain = plain_urdf(path)
    assert [element.tag for element in plain] == ["link", "link", "joint"]
    assert [element.tag for element in plain[2]] == [
        "origin",
        "parent",
        "child",
        "axis",
        "limit",
        "dynamics",
    ]
    assert [record.getMessage().partition(": ")[2] for record in caplog.records] == [
        "this is not read: <spring> in <joint>"
    ]


def test_a_robot_without_a_name_is_called_as_its_file(tmp_path: Path) -> None:
    path = tmp_path / "walker.urdf"
    path.write_text(f"<robot>{PENDULUM}</robot>")
    assert plain_urdf(path).get("name") == "walker"


def test_a_fixed_joint_mimics_nothing(tmp_path: Path) -> None:
    """As exporters leave it when they fix a finger."""
    fixed = joint("k", "arm", "tip", "fixed").replace("</joint>", "<mimic joint='j'/></joint>")
    plain = plain_urdf(written(tmp_path / "r.urdf", PENDULUM, link("tip"), fixed))
    assert plain.find("joint/mimic") is None


def test_meshes_are_named_from_the_root(tmp_path: Path) -> None:
    root = ElementTree.fromstring(
        "<robot><mesh filename='a/b.stl'/><mesh filename='package://x/c.stl'/></robot>"
    )
    make_meshes_absolute(tmp_path / "r.urdf", root)
    assert [mesh.get("filename") for mesh in root] == [
        str(tmp_path.resolve() / "a/b.stl"),
        "package://x/c.stl",
    ]
