"""Robots from MJCF files: what is read, what is drawn, and what is refused.

Against MuJoCo: tests/cross/test_mjcf_files.py.
"""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from psp3.description.mjcf import read_mjcf
from psp3.description.parts import RobotParts
from psp3.errors import InvalidRobotFile
from psp3.robots.closed_loop_robot import ClosedLoopRobot
from tests.psp3.description.test_urdf import STL

INERTIA = '<inertial pos="0.1 0.02 -0.03" mass="2" diaginertia="0.02 0.03 0.04"/>'
GOOD = f"""<mujoco model="four_bar">
  <compiler angle="radian"/>
  <option gravity="1 -7 -3"/>
  <default><joint damping="0.1"/><default class="thin"><geom type="capsule"/></default></default>
  <worldbody>
    <body name="crank" pos="0 0 0.1"><joint name="crank" range="-3 3"/>{INERTIA}
      <body name="coupler" pos="0.2 0 0">\
<joint name="coupler"/>{INERTIA}<site name="tip" pos="0.35 0 0.01"/></body>
    </body>
    <body name="rocker" pos="0.45 0 0.1"><joint name="rocker"/>{INERTIA}
      <body name="end" pos="0.4 0 0.01"><joint name="pin"/>{INERTIA}<site name="top"/></body>
    </body>
  </worldbody>
  <equality><weld name="loop" site1="tip" site2="top"/></equality>
  <actuator><motor joint="crank"/></actuator>
  <keyframe><key name="home" qpos="1 -0.6 1.2 -0.8"/></keyframe>
</mujoco>"""


def read(directory: Path, text: str, actuated: list[str] | None = None) -> RobotParts:
    path = directory / "robot.xml"
    path.write_text(text, encoding="utf-8")
    return read_mjcf(path, actuated)


def by_hand() -> ClosedLoopRobot:
    """Return the linkage of the file, built joint by joint."""
    model = pin.Model()
    model.gravity = pin.Motion(np.array([1.0, -7.0, -3.0]), np.zeros(3))
    parent = 0
    for name, position in (
        ("crank", [0, 0, 0.1]),
        ("coupler", [0.2, 0, 0]),
        ("rocker", [0.45, 0, 0.1]),
        ("pin", [0.4, 0, 0.01]),
    ):
        parent = 0 if name == "rocker" else parent
        parent = model.addJoint(
            parent, pin.JointModelRZ(), pin.SE3(np.eye(3), np.array(position, dtype=float)), name
        )
        model.appendBodyToJoint(
            parent,
            pin.Inertia(2.0, np.array([0.1, 0.02, -0.03]), np.diag([0.02, 0.03, 0.04])),
            pin.SE3.Identity(),
        )
    model.damping[:] = 0.1
    tip = pin.SE3(np.eye(3), np.array([0.35, 0.0, 0.01]))
    loop = pin.RigidConstraintModel(
        pin.ContactType.CONTACT_6D, model, 2, tip, 4, pin.SE3.Identity(), pin.ReferenceFrame.LOCAL
    )
    return ClosedLoopRobot(model, [loop], ["crank"], [1.0, -0.6, 1.2, -0.8])


def test_a_robot_is_that_of_a_tree_built_by_hand(tmp_path: Path) -> None:
    """Names, and M, C and G to 1e-12: both are the same numbers, and close the loop to 1e-14."""
    parts = read(tmp_path, GOOD)
    assert parts.model.name == "four_bar"
    assert list(parts.model.names)[1:] == ["crank", "coupler", "rocker", "pin"]
    assert parts.actuated == ("crank",)
    assert [loop.name for loop in parts.constraint_models] == ["loop"]
    assert parts.q0 is not None
    assert_array_equal(parts.q0, [1.0, -0.6, 1.2, -0.8])
    assert {"world", "crank", "end", "tip", "top"} <= {frame.name for frame in parts.model.frames}
    assert_array_equal(parts.model.damping, np.full(4, 0.1))
    assert (parts.model.lowerPositionLimit[0], parts.model.upperPositionLimit[0]) == (-3.0, 3.0)
    found, expected = ClosedLoopRobot(*parts), by_hand()
    for angle in ([0.7], [1.0], [1.4]):
        for ours, theirs in zip(
            found.equation_of_motion(angle, [2.0]),
            expected.equation_of_motion(angle, [2.0]),
            strict=True,
        ):
            assert_allclose(ours, theirs, rtol=1e-12, atol=1e-12)


def test_actuated_joints_are_those_of_the_file_or_of_the_caller(tmp_path: Path) -> None:
    """Two servos on one joint are one actuated joint; the order is that of the file."""
    servos = (
        '<actuator><position joint="pin"/><velocity joint="pin"/><general '
        'jointinparent="crank"/></actuator>'
    )
    text = GOOD.replace('<actuator><motor joint="crank"/></actuator>', servos)
    assert read(tmp_path, text).actuated == ("pin", "crank")
    assert read(tmp_path, text, ["rocker"]).actuated == ("rocker",)
    tendon = '<actuator><motor tendon="t"/></actuator>'
    assert read(tmp_path, text.replace(servos, tendon), ["rocker"]).actuated == ("rocker",)


def test_without_a_key_frame_named_home_there_is_no_home_pose(tmp_path: Path) -> None:
    assert read(tmp_path, GOOD.replace('name="home"', 'name="park"')).q0 is None
    assert read(tmp_path, GOOD.replace('<key name="home"', "<key")).q0 is None
    assert read(tmp_path, GOOD.replace(' qpos="1 -0.6 1.2 -0.8"', "")).q0 is None


def test_unnamed_bodies_and_joints_get_names(tmp_path: Path) -> None:
    bodies = f"<body><joint/>{INERTIA}<body><joint/><joint/>{INERTIA}</body></body>"
    parts = read(tmp_path, f"<mujoco><worldbody>{bodies}</worldbody></mujoco>", [])
    assert list(parts.model.names)[1:] == ["body_1_joint_1", "body_2_joint_2", "body_2_joint_3"]
    assert parts.model.name == "MuJoCo Model"


def test_shapes_are_drawn_where_they_are(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    """Primitives, meshes and colors, on bodies with and without joints and on the world.

    Not planes, nor what is for collisions only.
    """
    (tmp_path / "assets").mkdir()
    (tmp_path / "assets" / "arm.stl").write_text(STL)
    text = f"""<mujoco model="m"><compiler meshdir="assets" angle="radian"/>
      <asset><material name="red" rgba="1 0 0 1"/><mesh name="arm" file="arm.stl" scale="2 2 2"/>\
<mesh file="lost.stl"/></asset>
      <worldbody><geom type="plane" size="1 1 1"/><geom type="box" size="0.1 0.2 0.3" pos="1 2 3"/>
        <body name="a" pos="1 0 0"><geom type="sphere" size="0.5" material="red"/>
          <body name="b" pos="0 1 0"><joint name="j" pos="0.1 0 0"/>{INERTIA}
            <geom type="mesh" mesh="arm" pos="0 0 1" rgba="0 1 0 1" material="red"/>\
<geom type="mesh" mesh="lost"/>
            <geom type="cylinder" size="0.1" fromto="0 0 0 0 0 2"/><geom size="3" group="3"/>\
</body></body></worldbody></mujoco>"""
    parts = read(tmp_path, text, [])
    shapes = list(parts.visual_model.geometryObjects)
    assert [type(shape.geometry).__name__ for shape in shapes] == [
        "Box",
        "Sphere",
        "BVHModelOBBRSS",
        "Cylinder",
    ]
    data, placed = parts.model.createData(), parts.visual_model.createData()
    pin.updateGeometryPlacements(
        parts.model, data, parts.visual_model, placed, pin.neutral(parts.model)
    )
    centers = [place.translation for place in placed.oMg]
    assert_allclose(centers, [[1, 2, 3], [1, 0, 0], [1, 1, 1], [1, 1, 1]], rtol=0, atol=1e-15)
    assert_array_equal(shapes[1].meshColor, [1, 0, 0, 1])
    assert_array_equal(shapes[2].meshColor, [0, 1, 0, 1])
    assert_array_equal(shapes[2].meshScale, [2, 2, 2])
    assert_array_equal(shapes[0].geometry.halfSide, [0.1, 0.2, 0.3])
    assert shapes[3].geometry.halfLength == 1.0
    assert "lost.stl cannot be read and is not drawn" in caplog.text


BAD = [
    # Files and sections
    ("<mujoco model", "<robot model", "cannot be read as XML"),
    ("</mujoco>", "", "cannot be read as XML"),
    ("<worldbody>", "<world>", "cannot be read as XML"),
    (
        '<compiler angle="radian"/>',
        '<compiler coordinate="global"/>',
        "<compiler coordinate='global'> is not read, as MuJoCo does not any more; let MuJoCo write",
    ),
    (
        '<compiler angle="radian"/>',
        '<compiler settotalmass="much"/>',
        "settotalmass must be 1 finite number",
    ),
    (
        '<compiler angle="radian"/>',
        '<compiler angle="radian" autolimits="false"/>',
        "<joint name='crank'> has range but not limited, and the compiler's autolimits is false",
    ),
    (
        '<compiler angle="radian"/>',
        '<compiler eulerseq="xy"/>',
        "eulerseq must be three of the letters",
    ),
    (
        '<compiler angle="radian"/>',
        '<compiler eulerseq="xyw"/>',
        "eulerseq must be three of the letters",
    ),
    (
        '<compiler angle="radian"/>',
        '<compiler boundmass="nan"/>',
        "boundmass must be 1 finite number",
    ),
    (
        '<compiler angle="radian"/>',
        '<compiler balanceinertia="maybe"/>',
        "balanceinertia must be true or false",
    ),
    ('<compiler angle="radian"/>', '<include file="no.xml"/>', "no such file"),
    ('<compiler angle="radian"/>', '<include file="robot.xml"/>', "robot.xml is included twice"),
    ("1 -7 -3", "1 -7", "<option>: gravity must be 3 finite numbers"),
    ("1 -7 -3", "1 nan -3", "<option>: gravity must be 3 finite numbers"),
    ('<default class="thin">', "<default>", "a nested class needs a name of its own, got None"),
    (
        '<default class="thin">',
        '<default class="main">',
        "a nested class needs a name of its own, got 'main'",
    ),
    # Bodies
    ('<body name="end"', '<body name="crank"', "there are two bodies 'crank'"),
    ('<body name="end"', '<body name="world"', "there are two bodies 'world'"),
    (
        'pos="0.4 0 0.01"',
        'pos="0.4 nan 0.01"',
        "<body name='end'>: pos must be 3 finite numbers, got '0.4 nan 0.01'",
    ),
    ('pos="0.4 0 0.01"', 'pos="0.4 0.01"', "pos must be 3 finite numbers"),
    ('pos="0.4 0 0.01"', 'quat="0 0 0 0"', "quat '0 0 0 0' gives no direction"),
    ('pos="0.4 0 0.01"', 'quat="1 0 0"', "quat must be 4 finite numbers"),
    ('pos="0.4 0 0.01"', 'euler="0 0 inf"', "euler must be 3 finite numbers"),
    ('pos="0.4 0 0.01"', 'xyaxes="1 0 0 2 0 0"', "gives no direction"),
    (
        'pos="0.4 0 0.01"',
        'quat="1 0 0 0" euler="0 0 0"',
        "<body name='end'> has several orientations: quat, euler",
    ),
    (
        '<site name="top"/>',
        "<flexcomp/>",
        "<flexcomp> in body 'end' is not read; let MuJoCo write the model out (mj_saveLastXML)",
    ),
    (
        '<site name="top"/>',
        '<replicate count="1.5"/>',
        "count must be a whole number up to 100000, got '1.5'",
    ),
    ('<site name="top"/>', "<replicate/>", "count must be a whole number up to 100000, got None"),
    (
        '<site name="top"/>',
        '<replicate count="1000"><replicate count="1000"><site/></replicate></replicate>',
        "expands to more than 100000 elements",
    ),
    ('<site name="top"/>', '<frame childclass="no"><site/></frame>', "no default class 'no'"),
    (
        '<site name="top"/>',
        '<attach model="arm" body="b" prefix="x"/>',
        "<attach>: there is no model 'arm'; those of <asset> are none",
    ),
    ('<site name="top"/>', '<attach prefix="x"/>', "<attach> needs a model, a body or a frame"),
    ('<site name="top"/>', '<attach body="b" prefix="x"/>', "there is no body 'b' to attach"),
    ('<site name="top"/>', '<attach body="end" prefix="x"/>', "body 'end' would attach itself"),
    (
        "<worldbody>",
        '<asset><model file="robot.xml"/></asset><worldbody>',
        "<model>: robot.xml attaches itself",
    ),
    (
        "<worldbody>",
        '<asset><model file="../arm.xml"/></asset><worldbody>',
        "<model>: '../arm.xml' is outside of the file's folder",
    ),
    (
        '<compiler angle="radian"/>',
        '<include file="../arm.xml"/>',
        "<include>: '../arm.xml' is outside of the file's folder",
    ),
    ('<compiler angle="radian"/>', "<include/>", "<include> has no file"),
    ('<site name="top"/>', '<site name="tip"/>', "there are two sites 'tip'"),
    (
        '<site name="top"/>',
        '<site name="top" fromto="0 0 0 0 0 0"/>',
        "the two ends in fromto are the same point",
    ),
    ('<site name="top"/>', '<site name="top" class="fat"/>', "there is no default class 'fat'"),
    # Inertias
    (' mass="2"', "", "<body name='crank'>: <inertial> needs a mass"),
    (' mass="2"', ' mass="-2"', "<body name='crank'>: the mass -2 is negative"),
    (' mass="2"', ' mass="nan"', "mass must be 1 finite number, got 'nan'"),
    (
        'diaginertia="0.02 0.03 0.04"',
        "",
        "<body name='crank'>: <inertial> needs either diaginertia or fullinertia",
    ),
    (
        'diaginertia="0.02 0.03 0.04"',
        'diaginertia="0.02 0.03"',
        "diaginertia must be 3 finite numbers",
    ),
    (
        'diaginertia="0.02 0.03 0.04"',
        'diaginertia="0.02 -0.03 0.04"',
        "a principal moment of inertia is negative, -0.03",
    ),
    (
        'diaginertia="0.02 0.03 0.04"',
        'fullinertia="1 1 1 2 0 0"',
        "a principal moment of inertia is negative, -1",
    ),
    (
        INERTIA,
        '<geom type="mesh"/>',
        "the inertia of a mesh is not computed here; give the body an <inertial>",
    ),
    (
        INERTIA,
        '<geom type="box" size="1 1 1" shellinertia="true"/>',
        "the inertia of the shell of a box is not computed here",
    ),
    (INERTIA, '<geom type="box" size="1 1"/>', "a box needs 3 positive sizes, got '1 1'"),
    (INERTIA, '<geom type="sphere" size="-1"/>', "a sphere needs 1 positive sizes"),
    (INERTIA, '<geom type="sphere" size="nan"/>', "size must be 1 or 2 or 3 finite numbers"),
    (
        INERTIA,
        '<geom type="sphere" size="1" fromto="0 0 0 0 0 1"/>',
        "a sphere cannot be given by its ends",
    ),
    (INERTIA, '<geom type="sphere" size="1" mass="-1"/>', "negative mass or density"),
    (INERTIA, '<geom type="sphere" size="1" density="-1"/>', "negative mass or density"),
    (INERTIA, '<geom type="blob" size="1"/>', "blob"),
    # Joints
    ('<joint name="pin"/>', '<joint name="rocker"/>', "there are two joints 'rocker'"),
    (
        '<joint name="pin"/>',
        '<joint name="pin" type="screw"/>',
        "type 'screw' is unknown; known are hinge, slide, ball and free",
    ),
    (
        '<joint name="pin"/>',
        '<joint name="pin" axis="0 0 0"/>',
        "<joint name='pin'>: the axis is zero",
    ),
    ('<joint name="pin"/>', '<joint name="pin" axis="0 nan 1"/>', "axis must be 3 finite numbers"),
    (
        '<joint name="pin"/>',
        '<joint name="pin" range="1 -1"/>',
        "range must be two numbers, the smaller one first, got '1 -1'",
    ),
    ('<joint name="pin"/>', '<joint name="pin" limited="true"/>', "range must be two numbers"),
    (
        '<joint name="pin"/>',
        '<joint name="pin" limited="maybe"/>',
        "limited must be true, false or auto",
    ),
    (
        '<joint name="pin"/>',
        '<joint name="pin" springdamper="1 1"/>',
        "<joint name='pin'>: springdamper, whose stiffness depends on the inertia of the whole",
    ),
    ('<joint name="pin"/>', '<joint name="pin" damping="nan"/>', "damping must be 1 finite number"),
    ('<joint name="pin"/>', '<joint name="pin" class="fat"/>', "there is no default class 'fat'"),
    (
        '<joint name="pin"/>',
        "<freejoint/>",
        "a free joint must be the only one of a body right in the <worldbody>",
    ),
    (
        '<joint name="rocker"/>',
        '<joint name="rocker"/><joint type="free"/>',
        "a free joint must be the only one",
    ),
    ("<worldbody>", "<worldbody><joint/>", "<joint> is in the <worldbody>, which cannot move"),
    # Loops
    ('site1="tip"', 'site1="tap"', "equality: <weld name='loop'>: site1 'tap' is not in the file"),
    ('site1="tip"', "", "equality: <weld name='loop'>: site1 None is not in the file"),
    (
        'site1="tip" site2="top"',
        'body1="hand" body2="end"',
        "body1 'hand' is not in the file; its bodies are world, crank, coupler",
    ),
    ('site1="tip" site2="top"', 'body1="crank" body2="hand"', "body2 'hand' is not in the file"),
    ('site1="tip" site2="top"', 'body2="end"', "body1 '' is not in the file"),
    (
        'site1="tip" site2="top"',
        'body1="end" body2="end"',
        "joins 'end' and 'end', which do not move against each other",
    ),
    (
        'site1="tip" site2="top"',
        'body1="crank" body2="end" relpose="1 2 3"',
        "relpose must be 7 finite numbers",
    ),
    (
        'site1="tip" site2="top"',
        'body1="crank" body2="end" relpose="1 2 3 nan 0 0 0"',
        "relpose must be 7 finite numbers",
    ),
    (
        'weld name="loop" site1="tip" site2="top"',
        'connect body1="crank" body2="end"',
        "lacks anchor",
    ),
    (
        'weld name="loop" site1="tip" site2="top"',
        'connect body1="crank" body2="end" anchor="0 nan 0"',
        "anchor must be 3 finite numbers",
    ),
    (
        'weld name="loop" site1="tip" site2="top"',
        'tendon tendon1="t"',
        "an active <tendon> is not read; only connect, weld and joint",
    ),
    ('weld name="loop"', 'weld name="loop" active="perhaps"', "active must be true or false"),
    # Motors and poses
    (
        '<motor joint="crank"/>',
        "",
        "has no <actuator> that drives a joint; say which joints are actuated (actuated=[...])",
    ),
    (
        '<motor joint="crank"/>',
        '<motor joint="knob"/>',
        "drives joint 'knob', which is not in the file",
    ),
    (
        '<motor joint="crank"/>',
        '<motor name="m" tendon="t"/>',
        "actuator: <motor name='m'> drives tendon 't', which is not a fixed tendon",
    ),
    ("1 -0.6 1.2 -0.8", "1 -0.6 1.2", "<key name='home'>: qpos must hold 4 numbers, got 3"),
    ("1 -0.6 1.2 -0.8", "1 -0.6 nan -0.8", "qpos must be finite numbers"),
]


@pytest.mark.parametrize(("old", "new", "reason"), BAD)
def test_what_is_wrong_is_said(tmp_path: Path, old: str, new: str, reason: str) -> None:
    assert old in GOOD
    with pytest.raises(InvalidRobotFile) as caught:
        read(tmp_path, GOOD.replace(old, new))
    assert reason in caught.value.reason
    assert caught.value.path.parent == tmp_path


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("", "cannot be read as XML"),
        ("<robot/>", "must be <mujoco>, not <robot>"),
        ("<mujoco/>", "has no <body> in its <worldbody>"),
        (
            "<mujoco><worldbody><geom size='1'/></worldbody></mujoco>",
            "has no <body> in its <worldbody>",
        ),
        (
            "<mujoco><worldbody><frame><site/></frame></worldbody></mujoco>",
            "has no <body> in its <worldbody>",
        ),
    ],
)
def test_files_without_a_robot_are_refused(tmp_path: Path, text: str, reason: str) -> None:
    with pytest.raises(InvalidRobotFile, match=reason):
        read(tmp_path, text)


def test_a_missing_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InvalidRobotFile, match="no such file") as caught:
        read_mjcf(tmp_path / "no.xml")
    assert caught.value.path == tmp_path / "no.xml"


@pytest.mark.parametrize(
    ("actuated", "reason"),
    [
        (["knob"], "actuated: the robot has no joint 'knob'; its joints are crank"),
        (["crank", "crank"], "actuated names a joint twice: crank"),
        (["universe"], "no joint 'universe'"),
    ],
)
def test_actuated_joints_of_the_caller_must_exist(
    tmp_path: Path, actuated: list[str], reason: str
) -> None:
    with pytest.raises(InvalidRobotFile) as caught:
        read(tmp_path, GOOD, actuated)
    assert reason in caught.value.reason


def test_a_motor_on_a_ball_joint_is_refused(tmp_path: Path) -> None:
    text = GOOD.replace('<joint name="pin"/>', '<joint name="pin" type="ball"/>').replace(
        'motor joint="crank"', 'motor joint="pin"'
    )
    with pytest.raises(
        InvalidRobotFile, match="actuator: joint 'pin' has 3 degrees of freedom in 4 coordinates"
    ):
        read(tmp_path, text.replace("1.2 -0.8", "1.2 1 0 0 0"))


def test_a_key_frame_with_a_quaternion_of_zeros_is_refused(tmp_path: Path) -> None:
    text = GOOD.replace('<joint name="pin"/>', '<joint name="pin" type="ball"/>').replace(
        "1.2 -0.8", "1.2 0 0 0 0"
    )
    with pytest.raises(InvalidRobotFile, match="gives joint 'pin' a quaternion of zeros"):
        read(tmp_path, text)


def test_a_loop_between_bodies_that_pinocchio_alone_would_not_read_is_read(tmp_path: Path) -> None:
    """Its own parser reads the first body of the world only.

    It dies of a weld by sites of another one.
    """
    parts = read(tmp_path, GOOD)
    assert [(loop.joint1_id, loop.joint2_id) for loop in parts.constraint_models] == [(2, 4)]


def test_what_mujoco_moves_from_outside_stays(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    target = '<body name="target" mocap="true" pos="1 2 3"><geom size="1"/></body>'
    model = read(tmp_path, GOOD.replace("<worldbody>", f"<worldbody>{target}")).model
    frame = model.frames[model.getFrameId("target", pin.FrameType.BODY)]
    assert frame.parentJoint == 0
    assert_array_equal(frame.placement.translation, [1.0, 2.0, 3.0])
    assert "body target, which MuJoCo lets its user move (mocap), stays where it is" in caplog.text


def test_a_mesh_that_cannot_be_read_is_told(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """Such as one of which only a pointer to its store is there; others are drawn."""
    (tmp_path / "arm.stl").write_text(STL)
    (tmp_path / "far.stl").write_text("version https://git-lfs.github.com/spec/v1")
    geoms = '<geom type="mesh" mesh="far"/><geom type="mesh" mesh="arm"/>'
    text = GOOD.replace(INERTIA, INERTIA + geoms, 1).replace(
        "<worldbody>", '<asset><mesh file="arm.stl"/><mesh file="far.stl"/></asset><worldbody>'
    )
    assert read(tmp_path, text).visual_model.ngeoms == 1
    assert "far.stl cannot be read and is not drawn" in caplog.text


@pytest.mark.parametrize("before", ["\n \t", "\ufeff"])
def test_blanks_and_marks_before_the_declaration(tmp_path: Path, before: str) -> None:
    text = f'{before}<?xml version="1.0" encoding="utf-8"?>{GOOD}'
    assert read(tmp_path, text).actuated == ("crank",)


@pytest.mark.parametrize("number", ["0_1", "0x1", "\uff11", "1.", ".5e0"])
def test_numbers_are_those_that_mujoco_reads(tmp_path: Path, number: str) -> None:
    text = GOOD.replace('mass="2"', f'mass="{number}"', 1)
    if number in ("1.", ".5e0"):
        assert read(tmp_path, text).model.inertias[1].mass == float(number)
        return
    with pytest.raises(InvalidRobotFile, match="mass must be 1 finite number"):
        read(tmp_path, text)


def test_entities_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InvalidRobotFile, match="<!DOCTYPE>"):
        read(tmp_path, f'<!DOCTYPE mujoco [<!ENTITY m "2">]>{GOOD}')


def test_joints_of_the_caller_are_replaced(tmp_path: Path) -> None:
    """A pin that stands for a ball: home turns it about its axis, as the hinge did."""
    path = tmp_path / "robot.xml"
    path.write_text(GOOD)
    parts = read_mjcf(path, None, {"pin": "SPHERICAL"})
    joint = parts.model.joints[parts.model.getJointId("pin")]
    assert parts.q0 is not None
    turn = parts.q0[joint.idx_q : joint.idx_q + 4]
    assert_allclose(turn, [0.0, 0.0, np.sin(-0.4), np.cos(-0.4)], rtol=0, atol=1e-15)
    assert ClosedLoopRobot.from_mjcf(path, joint_type={"pin": "SPHERICAL"}).model.nq == 7
    assert read_mjcf(path, None, {"pin": "FIXED"}).model.nq == 3
    with pytest.raises(InvalidRobotFile, match="the robot has no joint 'knob'"):
        read_mjcf(path, None, {"knob": "FIXED"})


MANY = "<geom a{}='1'/>"

ONE_JOINT = (
    "<mujoco>{}<worldbody><body><joint name='j'/><geom type='box' size='1 1 1'/></body>{}"
    "</worldbody><actuator><motor joint='j'/></actuator></mujoco>"
)


@pytest.mark.parametrize(
    ("before", "inside", "words"),
    [
        ("", "<replicate count='90000'><replicate count='90000'/></replicate>", "100000 elements"),
        (
            "",
            "<replicate count='400'><replicate count='400'><site/></replicate></replicate>",
            "100000",
        ),
        ("", "<replicate count='3000'><geom size='1'/></replicate>", "has 3001 geoms to draw"),
        (
            "",
            "<replicate count='200'><body><joint/><geom size='1'/></body></replicate>",
            "201 joint",
        ),
        (
            "",
            "<body><joint type='ball'/><geom size='1'/></body>" * 60,
            "has 181 speeds, and at most 150 are read",
        ),
        (
            "",
            f"<replicate count='9' sep='{'x' * 2000}'><site name='s'/></replicate>",
            "has a name of",
        ),
        ("<compiler inertiagrouprange='a b'/>", "", "inertiagrouprange must be 2 finite numbers"),
        ("<compiler inertiagrouprange='1'/>", "", "inertiagrouprange must be 2 finite numbers"),
        (
            f"<default>{''.join(map(MANY.format, range(90)))}</default>"
            f"<default>{''.join(map(MANY.format, range(90, 180)))}</default>",
            "",
            "<geom> has more than 100 attributes",
        ),
    ],
    ids=range(9),
)
def test_a_few_words_that_stand_for_far_too_much_are_refused_at_once(
    tmp_path: Path, before: str, inside: str, words: str
) -> None:
    begun = time.process_time()
    with pytest.raises(InvalidRobotFile, match=words):
        read(tmp_path, ONE_JOINT.format(before, inside))
    assert time.process_time() - begun < 5.0


def test_files_that_attach_two_of_each_other_are_counted(tmp_path: Path) -> None:
    """Thirty files, of which each attaches the next one twice, are a billion."""
    for number in range(30):
        models = "".join(f"<model name='{k}' file='{number + 1}.xml'/>" for k in "ab")
        text = ONE_JOINT.format(f"<asset>{models}</asset>" if number < 29 else "", "")
        (tmp_path / f"{number}.xml").write_text(text)
    with pytest.raises(InvalidRobotFile, match="includes and attaches more than 200 files"):
        read_mjcf(tmp_path / "0.xml")


def test_a_model_may_be_attached_many_times(tmp_path: Path) -> None:
    """What is counted is what is there in the end."""
    finger = "<mujoco><worldbody><body name='f'>{}</body></worldbody></mujoco>"
    (tmp_path / "finger.xml").write_text(finger.format("<site/>" * 50))
    copies = "".join(f"<attach model='m' body='f' prefix='{k}-'/>" for k in range(300))
    asset = "<asset><model name='m' file='finger.xml'/></asset>"
    assert read(tmp_path, ONE_JOINT.format(asset, copies)).model.nv == 1


@pytest.mark.parametrize("file", ["/dev/zero", "/etc/hostname", "folder.stl"])
def test_of_files_that_a_robot_names_only_meshes_are_opened(
    tmp_path: Path, caplog: pytest.LogCaptureFixture, file: str
) -> None:
    (tmp_path / "folder.stl").mkdir()
    asset = f"<asset><mesh name='m' file='{file}'/></asset>"
    drawn = "<geom type='mesh' mesh='m' mass='0'/>"
    with caplog.at_level("WARNING", "psp3"):
        assert read(tmp_path, ONE_JOINT.format(asset, drawn)).visual_model.ngeoms == 1
    assert "cannot be read and is not drawn" in caplog.text
