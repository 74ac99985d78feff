"""Poses by name, and pairs of links that are left out, from SRDF files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import psp3
from psp3.description.srdf import excluded_by_srdf, reference_poses
from psp3.description.urdf import read_robot, read_tree
from psp3.errors import InvalidRobotFile
from tests.psp3.description.written import (
    HOME,
    four_bar,
    home,
    joint,
    link,
    loop_file,
    written,
)


@pytest.fixture
def two_joints(tmp_path: Path) -> pin.Model:
    path = written(
        tmp_path / "two.urdf",
        link("a"),
        link("b"),
        link("c"),
        joint("wheel", "a", "b", "continuous"),
        joint("slide", "b", "c", "prismatic"),
    )
    return read_tree(path)[0]


def test_poses_by_name(tmp_path: Path, two_joints: pin.Model) -> None:
    """A joint of unlimited angle is given by its angle."""
    states = (
        "<group_state name='home' group='g'><joint name='wheel' value='0.5'/><joint name='slide' "
        "value='-0.2'/></group_state>"
    )
    poses = reference_poses(
        two_joints, written(tmp_path / "r.srdf", states, "<group_state name='other' group='g'/>")
    )
    assert set(poses) == {"home", "other"}
    assert_allclose(poses["home"], [np.cos(0.5), np.sin(0.5), -0.2], rtol=0, atol=1e-15)
    assert_array_equal(poses["other"], [1.0, 0.0, 0.0])
    assert {item.key() for item in two_joints.referenceConfigurations} == {"home", "other"}


def test_poses_are_those_of_the_file_read_last(tmp_path: Path, two_joints: pin.Model) -> None:
    """Pinocchio's own reader keeps a pose that it has by the same name."""
    for position in (0.1, 0.3):
        state = (
            "<group_state name='home' group='g'><joint name='slide' "
            f"value='{position}'/></group_state>"
        )
        assert (
            reference_poses(two_joints, written(tmp_path / "r.srdf", state))["home"][2] == position
        )
        assert two_joints.referenceConfigurations["home"][2] == position


@pytest.mark.parametrize(
    ("states", "reason"),
    [
        (
            "<group_state name='home'><joint name='slide' value='nan'/></group_state>",
            "value must be 1 finite number, got 'nan'",
        ),
        (
            "<group_state name='home'><joint name='slide' value='1 2'/></group_state>",
            "value must be 1 finite number",
        ),
        (
            "<group_state name='home'><joint name='wheel' value='1 0'/></group_state>",
            "value must be 1 finite number",
        ),
        (
            "<group_state name='home'><joint name='slide' value='up'/></group_state>",
            "value must be 1 finite number",
        ),
        (
            "<group_state name='home'><joint name='slide'/></group_state>",
            "<joint name='slide'> has no value",
        ),
        ("<group_state name='home'><joint value='1'/></group_state>", "a <joint> has no name"),
        (
            "<group_state name='home'><joint name='elbow' value='1'/></group_state>",
            "the robot has no joint 'elbow'",
        ),
        (
            "<group_state name='home'><joint name='universe' value='1'/></group_state>",
            "the robot has no joint 'universe'",
        ),
        ("<group_state/>", "a <group_state> has no name"),
        (
            "<group_state name='home'/><group_state name='home'/>",
            "two of <group_state name='home'>",
        ),
    ],
)
def test_poses_that_pinocchio_would_pass_over_are_refused(
    tmp_path: Path, two_joints: pin.Model, states: str, reason: str
) -> None:
    path = written(tmp_path / "r.srdf", states)
    with pytest.raises(InvalidRobotFile) as caught:
        reference_poses(two_joints, path)
    assert reason in caught.value.reason
    assert caught.value.path == path


def test_a_ball_joint_needs_a_unit_quaternion(tmp_path: Path) -> None:
    model = pin.Model()
    model.addJoint(0, pin.JointModelSpherical(), pin.SE3.Identity(), "ball")
    pose = "<group_state name='home' group='g'><joint name='ball' value='{}'/></group_state>"
    good = reference_poses(model, written(tmp_path / "good.srdf", pose.format("0.6 0 0 0.8")))
    assert_array_equal(good["home"], [0.6, 0.0, 0.0, 0.8])
    rounded = "0.60000001 0 0 0.8"
    assert reference_poses(model, written(tmp_path / "good.srdf", pose.format(rounded)))
    for bad in ("1 0 0 0.8", "0.6001 0 0 0.8"):
        with pytest.raises(InvalidRobotFile, match="not a unit quaternion"):
            reference_poses(model, written(tmp_path / "bad.srdf", pose.format(bad)))


def test_poses_name_the_joints_of_a_universal_joint(tmp_path: Path) -> None:
    """After the replacement ``tip`` is no joint any more."""
    urdf, loops = four_bar(tmp_path, hinge="revolute"), loop_file(tmp_path, tip="UJOINT_ZY")
    with pytest.raises(InvalidRobotFile, match="no joint 'tip'"):
        read_robot(urdf, loops, home(tmp_path))
    pose = written(tmp_path / "u.srdf", f"{HOME}<joint name='tip_Z' value='0.8'/></group_state>")
    q0 = read_robot(urdf, loops, pose).q0
    assert q0 is not None
    assert_array_equal(q0, [1.0, -0.6, 0.8, 0.0, 0.0])


ROBOT = psp3.load()


def test_what_is_not_read_of_a_pose_is_told(
    tmp_path: Path, two_joints: pin.Model, caplog: pytest.LogCaptureFixture
) -> None:
    """A joint that is misspelt stays where it is, but not in silence."""
    path = tmp_path / "r.srdf"
    joints = f"<joint name='{two_joints.names[1]}' value='0' vlaue='1'/><joints name='x'/>"
    path.write_text(f"<robot name='r'><group_state name='home'>{joints}</group_state></robot>")
    with caplog.at_level("WARNING", "psp3"):
        reference_poses(two_joints, path)
    assert "this is not read: <joints>, vlaue of <joint" in caplog.text


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("<group_states name='home'/>", "<group_states name='home'>"),
        ("<group><group_state name='home'/></group>", "<group_state name='home'> in <group>"),
        ("<group name='a'><disable_collisions/></group>", "<disable_collisions> in <group>"),
        ("<group_state name='home' GROUP='a'/>", "GROUP of <group_state name='home'>"),
    ],
)
def test_what_no_srdf_has_is_told(
    tmp_path: Path,
    two_joints: pin.Model,
    caplog: pytest.LogCaptureFixture,
    text: str,
    told: str,
) -> None:
    """A pose or a pair that is misspelt, or in a wrong place, is not lost in silence."""
    path = tmp_path / "r.srdf"
    path.write_text(f"<robot name='r'><group name='legs'/><virtual_joint/>{text}</robot>")
    with caplog.at_level("WARNING", "psp3"):
        reference_poses(two_joints, path)
        excluded_by_srdf(path)
    assert told in caplog.text.replace('"', "'")
    assert "virtual_joint" not in caplog.text


def test_the_srdf_of_the_package_is_read_as_pinocchio_reads_it() -> None:
    """Pinocchio removes the same pairs; at present there is none to remove."""
    srdf = Path(psp3.__file__).parent / "urdf" / "psp3.srdf"
    geometry = pin.buildGeomFromUrdf(
        ROBOT.model, str(srdf.with_suffix(".urdf")), pin.GeometryType.COLLISION
    )
    geometry.addAllCollisionPairs()
    before = len(geometry.collisionPairs)
    pin.removeCollisionPairs(ROBOT.model, geometry, str(srdf))
    assert (before == len(geometry.collisionPairs)) == (excluded_by_srdf(srdf) == [])


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ('<robot><disable_collisions link1="a"/></robot>', "two links"),
        ('<robot><disable_collisions link1="a" link2="a"/></robot>', "two links"),
        ("<robot><disable_collisions", "XML"),
        ("<sdf/>", "robot"),
    ],
)
def test_a_malformed_srdf_is_refused(tmp_path: Path, text: str, words: str) -> None:
    srdf = tmp_path / "some.srdf"
    srdf.write_text(text)
    with pytest.raises(InvalidRobotFile, match=words):
        excluded_by_srdf(srdf)


def test_a_missing_srdf_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InvalidRobotFile, match="no such file"):
        excluded_by_srdf(tmp_path / "none.srdf")
