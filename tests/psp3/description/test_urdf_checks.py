"""URDFs that say something wrong are refused with what and where.

Pinocchio's parser would take most of these.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from psp3.description.parts import ROBOT_FILES
from psp3.description.urdf_checks import check_urdf
from psp3.description.xml import read_xml
from psp3.errors import InvalidRobotFile

LINK = (
    "<link name='arm'><inertial><origin xyz='0 0 0.1'/>"
    "<mass value='2'/><inertia ixx='1' ixy='0' ixz='0' iyy='1' iyz='0' izz='1'/></inertial>"
    "<visual><geometry><box size='1 2 3'/></geometry></visual></link>"
)
LIMIT = "<limit lower='-1' upper='1' effort='5' velocity='3'/>"
JOINT = (
    "<joint name='j' type='revolute'><parent link='base'/><child link='arm'/><axis xyz='0 0 1'/>"
    f"{LIMIT}</joint>"
)
GOOD = f"<robot name='r'><link name='base'/>{LINK}{JOINT}</robot>"


def check(directory: Path, text: str) -> None:
    path = directory / "robot.urdf"
    path.write_text(text, encoding="utf-8")
    check_urdf(path, read_xml(path, "robot"))


def test_a_good_file_passes(tmp_path: Path) -> None:
    check(tmp_path, GOOD)


@pytest.mark.parametrize("path", sorted(ROBOT_FILES.rglob("*.urdf")), ids=lambda path: path.name)
def test_our_own_files_pass(path: Path) -> None:
    check_urdf(path, read_xml(path, "robot"))


@pytest.mark.parametrize(
    ("old", "new", "reason"),
    [
        (
            "<mass value='2'/>",
            "<mass value='nan'/>",
            "<link name='arm'>: <mass>: value must be 1 finite number, got 'nan'",
        ),
        ("<mass value='2'/>", "<mass value='inf'/>", "finite"),
        ("<mass value='2'/>", "<mass value='2 kg'/>", "'2 kg'"),
        ("<mass value='2'/>", "<mass value='2e50'/>", "value is larger than 1e+50"),
        ("<mass value='2'/>", "<mass/>", "<mass> lacks value"),
        ("<mass value='2'/>", "<mass value='-2'/>", "the mass -2 is negative"),
        ("<mass value='2'/>", "", "<inertial> needs <mass> and <inertia>"),
        ("ixx='1'", "ixx='nan'", "ixx must be 1 finite number"),
        ("ixx='1'", "", "<inertia> lacks ixx"),
        ("ixx='1'", "ixx='-1'", "a principal moment of inertia is negative, -1 kg"),
        ("ixy='0'", "ixy='3'", "a principal moment of inertia is negative, -2 kg"),
        ("xyz='0 0 0.1'", "xyz='0 0'", "xyz must be 3 finite numbers"),
        ("xyz='0 0 0.1'", "xyz='0 0 nan'", "xyz must be 3 finite numbers"),
        ("size='1 2 3'", "size='1 2'", "size must be 3 finite numbers"),
        ("size='1 2 3'", "", "<box> lacks size"),
        ("<box size='1 2 3'/>", "", "a <visual> needs a <geometry>"),
        ("<geometry><box size='1 2 3'/></geometry>", "", "a <visual> needs a <geometry>"),
        ("<axis xyz='0 0 1'/>", "<axis xyz='0 0 0'/>", "<joint name='j'>: the axis is zero"),
        ("<axis xyz='0 0 1'/>", "<axis xyz='0 nan 1'/>", "xyz must be 3 finite numbers"),
        ("<axis xyz='0 0 1'/>", "<axis/>", "<axis> lacks xyz"),
        ("<mass value='2'/>", "<mass value='2'/><mass value='3'/>", "has more than one <mass>"),
        ("<axis xyz='0 0 1'/>", "<axis xyz='0 0 1'/><axis xyz='1 0 0'/>", "more than one <axis>"),
        (
            "</visual></link>",
            "<inertial><mass value='1'/></inertial></visual></link>",
            "<visual>: <inertial> does not belong there",
        ),
        ("</joint>", "<link name='lost'/></joint>", "<link name='lost'> does not belong there"),
        ("<box size='1 2 3'/>", "<box size='1 2 3'/><sphere radius='1'/>", "a <visual> needs a"),
        ("type='revolute'", "type='screw'", "type 'screw' is unknown; known are revolute"),
        ("type='revolute'", "", "type None is unknown"),
        ("lower='-1'", "lower='2'", "its lower limit is above its upper one"),
        ("lower='-1'", "lower='nan'", "lower must be 1 finite number"),
        ("effort='5'", "", "<limit> lacks effort"),
        (LIMIT, "", "a revolute joint needs a <limit>"),
        (
            f"{JOINT}</robot>",
            f"{JOINT.replace('revolute', 'prismatic').replace(LIMIT, '')}</robot>",
            "a prismatic joint needs a <limit>",
        ),
        (
            "<parent link='base'/>",
            "<parent link='bass'/>",
            "its parent link 'bass' is not in the file",
        ),
        ("<child link='arm'/>", "<child link='leg'/>", "its child link 'leg' is not in the file"),
        ("<child link='arm'/>", "", "its child link '' is not in the file"),
        (
            "<link name='base'/>",
            "<link name='base'/><link name='base'/>",
            "there are two of <link name='base'>",
        ),
        ("<link name='base'/>", "<link name='base'/><link/>", "a <link> has no name"),
        (
            "<link name='base'/>",
            "<link name='base'/><link name='stray'/>",
            "2 have none: base, stray",
        ),
        ("</robot>", f"{JOINT}</robot>", "there are two of <joint name='j'>"),
        (
            "</robot>",
            JOINT.replace("'j'", "'k'") + "</robot>",
            "link 'arm' is the child of two joints",
        ),
    ],
)
def test_what_is_wrong_is_said(tmp_path: Path, old: str, new: str, reason: str) -> None:
    assert old in GOOD
    with pytest.raises(InvalidRobotFile) as caught:
        check(tmp_path, GOOD.replace(old, new))
    assert reason in caught.value.reason
    assert caught.value.path == tmp_path / "robot.urdf"


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("<geometry>", "<shade/><geometry>", "<shade> in <visual>"),
        ("lower='-1'", "lowwer='-1'", "lowwer of <limit>"),
        (
            "<link name='base'/>",
            "<link name='base'><origin xyz='0 0 1'/></link>",
            "<origin> in <link>",
        ),
        ("</robot>", "<loop_joint name='l'/></robot>", "<loop_joint> in <robot>"),
    ],
)
def test_what_is_not_read_is_told(
    tmp_path: Path, old: str, new: str, told: str, caplog: pytest.LogCaptureFixture
) -> None:
    assert old in GOOD
    with caplog.at_level("WARNING", "psp3"):
        check(tmp_path, GOOD.replace(old, new))
    assert [record.getMessage().partition(": ")[2] for record in caplog.records] == [
        f"this is not read: {told}"
    ]


def test_words_for_other_programs_are_no_news(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """Nor is the origin of zeros that onshape-to-robot gives to links."""
    with caplog.at_level("WARNING", "psp3"):
        check(
            tmp_path,
            GOOD.replace(
                "<link name='base'/>",
                "<link name='base'><origin xyz='0 0 0' rpy='0 -0 0'/><contact/></link><gazebo/>",
            ),
        )
    assert not caplog.records


def test_moments_of_rounding_are_not_negative(tmp_path: Path) -> None:
    """Of a body whose moments were left out, but for rounding: iCub's head."""
    zeros = "ixx='0' ixy='0' ixz='2.4e-35' iyy='0' iyz='0' izz='0'"
    check(tmp_path, GOOD.replace("ixx='1' ixy='0' ixz='0' iyy='1' iyz='0' izz='1'", zeros))


def test_links_in_a_circle_are_refused(tmp_path: Path) -> None:
    """With a root beside the circle, and without one."""

    def fixed(parent: str, child: str) -> str:
        return (
            f"<joint name='{child}' type='fixed'><parent link='{parent}'/><child "
            f"link='{child}'/></joint>"
        )

    circle = f"<link name='a'/><link name='b'/>{fixed('a', 'b')}{fixed('b', 'a')}"
    with pytest.raises(InvalidRobotFile, match="hangs on a circle of links"):
        check(tmp_path, f"<robot name='r'><link name='base'/>{circle}</robot>")
    with pytest.raises(InvalidRobotFile, match="but 0 have none: each is a child"):
        check(tmp_path, f"<robot name='r'>{circle}</robot>")


def test_a_file_without_links_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InvalidRobotFile, match="has no <link>"):
        check(tmp_path, "<robot name='r'/>")
