"""Poses of SDF files, compared with places that are multiplied out by hand."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from numpy.testing import assert_allclose

from psp3.description.parts import RobotParts
from psp3.description.sdf import read_sdf
from psp3.errors import InvalidRobotFile
from tests.helpers import Array

A, B, C, D = (
    (0.1, 0.2, 0.3, 0.4, -0.5, 0.6),
    (-0.3, 0.1, 0.2, 0.0, 0.3, -0.2),
    (0.2, 0.2, -0.1, 0.7, 0.1, 0.0),
    (0.5, -0.4, 0.3, -0.2, 0.4, 0.9),
)


def at(*poses: tuple[float, ...]) -> pin.SE3:
    """Return poses one after the other; the rotation is R_z(yaw) R_y(pitch) R_x(roll)."""
    place = pin.SE3.Identity()
    for x, y, z, roll, pitch, yaw in poses:
        turn = np.eye(3)
        for letter, angle in (("z", yaw), ("y", pitch), ("x", roll)):
            turn = turn @ pin.utils.rotate(letter, angle)
        place = place * pin.SE3(turn, np.array([x, y, z]))
    return place


def pose(numbers: tuple[float, ...], to: str = "", attribute: str = "relative_to") -> str:
    """Return a pose element."""
    frame = f' {attribute}="{to}"' if to else ""
    return f"<pose{frame}>{' '.join(map(str, numbers))}</pose>"


def hinge(
    name: str, parent: str, child: str, more: str = "", axis: str = "<xyz>0 0 1</xyz>"
) -> str:
    """Return a revolute joint."""
    return (
        f'<joint name="{name}" type="revolute"><parent>{parent}</parent><child>{child}</child>'
        f"{more}<axis>{axis}</axis></joint>"
    )


def read(directory: Path, content: str, version: str = "1.9") -> RobotParts:
    """Return what a text describes."""
    path = directory / "robot.sdf"
    path.write_text(f'<sdf version="{version}">{content}</sdf>', encoding="utf-8")
    return read_sdf(path, [])


def place(parts: RobotParts, name: str, kind: pin.FrameType | None = None) -> pin.SE3:
    """Return where a frame is in the pose of the file."""
    model, data = parts.model, parts.model.createData()
    pin.framesForwardKinematics(model, data, pin.neutral(model))
    number = model.getFrameId(name) if kind is None else model.getFrameId(name, kind)
    assert number < model.nframes, name
    return data.oMf[number]


def close(one: pin.SE3, two: pin.SE3) -> None:
    """Compare two places to rounding."""
    assert_allclose(one.homogeneous, two.homogeneous, atol=1e-14)


def axis(parts: RobotParts, name: str) -> Array:
    """Return the axis of a joint in the world."""
    model, data = parts.model, parts.model.createData()
    pin.computeJointJacobians(model, data, pin.neutral(model))
    index = model.getJointId(name)
    jacobian = pin.getJointJacobian(model, data, index, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED)
    column = model.joints[index].idx_v
    return np.asarray(jacobian.reshape(6, model.nv)[3:, column])


def test_poses_are_relative_to_links_joints_and_frames(tmp_path: Path) -> None:
    parts = read(
        tmp_path,
        f'<model name="m">{pose(A)}<link name="a">{pose(B)}</link>'
        f'<link name="b">{pose(C, "a")}</link>'
        f'<link name="c">{pose(D, "j")}</link>'
        f'<frame name="f" attached_to="b">{pose(B)}</frame>'
        f'<frame name="g">{pose(C, "f")}</frame>'
        f"{hinge('i', 'world', 'a')}{hinge('j', 'a', 'b', pose(A))}"
        f"{hinge('k', 'f', 'c', pose(B, 'g'))}</model>",
    )
    close(place(parts, "a"), at(A, B))
    close(place(parts, "b"), at(A, B, C))
    close(place(parts, "j"), at(A, B, C, A))
    close(place(parts, "c"), at(A, B, C, A, D))
    close(place(parts, "f"), at(A, B, C, B))
    close(place(parts, "g"), at(A, B, C, B, C))
    close(place(parts, "k"), at(A, B, C, B, C, B))
    # The parent of k is a frame on b; the frame g moves with the model, that is with link a.
    model = parts.model
    assert model.names[model.parents[model.getJointId("k")]] == "j"
    frame = model.frames[model.getFrameId("g")]
    assert model.names[frame.parentJoint] == "i"


@pytest.mark.parametrize(
    ("version", "said", "frames"),
    [
        ("1.9", '<xyz expressed_in="__model__">0 1 2</xyz>', (A,)),
        ("1.9", '<xyz expressed_in="a">0 1 2</xyz>', (A, B)),
        ("1.9", "<xyz>0 1 2</xyz>", (A, B, C, D)),
        ("1.6", "<xyz>0 1 2</xyz>", (A, B, C, D)),
        ("1.6", "<xyz>0 1 2</xyz><use_parent_model_frame>1</use_parent_model_frame>", (A,)),
        ("1.5", "<xyz>0 1 2</xyz><use_parent_model_frame>true</use_parent_model_frame>", (A,)),
        ("1.4", "<xyz>0 1 2</xyz>", (A,)),
    ],
)
def test_axes_are_in_the_frame_that_the_version_says(
    version: str, said: str, frames: tuple[tuple[float, ...], ...], tmp_path: Path
) -> None:
    below = pose(C, "a", "relative_to" if version == "1.9" else "frame")
    parts = read(
        tmp_path,
        f'<model name="m">{pose(A)}<link name="a">{pose(B)}</link><link name="b">{below}</link>'
        f"{hinge('i', 'world', 'a')}{hinge('j', 'a', 'b', pose(D), said)}</model>",
        version,
    )
    direction = np.array([0.0, 1.0, 2.0]) / np.sqrt(5.0)
    assert_allclose(axis(parts, "j"), at(*frames).rotation @ direction, atol=1e-14)


def test_nested_models_have_frames_of_their_own(tmp_path: Path) -> None:
    inner = (
        f'<model name="n">{pose(B)}<link name="a">{pose(C)}</link><link name="b"/>'
        f'<frame name="f">{pose(D)}</frame>{hinge("j", "a", "b")}</model>'
    )
    parts = read(
        tmp_path,
        f'<model name="m">{pose(A)}{inner}<link name="a">{pose(D, "n::b")}</link>'
        f"{hinge('i', 'world', 'n::a')}{hinge('j', 'n::b', 'a', pose(C, 'n::f'))}</model>",
    )
    close(place(parts, "n::a"), at(A, B, C))
    close(place(parts, "n::b"), at(A, B))
    close(place(parts, "a"), at(A, B, D))
    close(place(parts, "j"), at(A, B, D, C))
    assert list(parts.model.names)[1:] == ["i", "n::j", "j"]


def test_a_placement_frame_has_the_pose_of_its_model(tmp_path: Path) -> None:
    parts = read(
        tmp_path,
        f'<model name="m" placement_frame="f">{pose(A)}<link name="a">{pose(B)}</link>'
        f'<frame name="f" attached_to="a">{pose(C)}</frame>{hinge("j", "world", "a")}</model>',
    )
    close(place(parts, "f"), at(A))
    close(place(parts, "a"), at(A) * at(C).inverse())


def test_degrees_and_quaternions(tmp_path: Path) -> None:
    x, y, z, w = np.array([0.1, -0.2, 0.3, 0.9]) / np.linalg.norm([0.1, -0.2, 0.3, 0.9])
    degrees = " ".join(str(np.degrees(angle)) for angle in A[3:])
    parts = read(
        tmp_path,
        f'<model name="m"><link name="a"><pose degrees="true">0.1 0.2 0.3 {degrees}</pose></link>'
        '<link name="b"><pose rotation_format="quat_xyzw"> 1 2 3 0.1 -0.2 0.3 0.9\n</pose></link>'
        f"{hinge('i', 'world', 'a')}{hinge('j', 'a', 'b')}</model>",
    )
    close(place(parts, "a"), at(A))
    expected = pin.SE3(pin.Quaternion(w, x, y, z), np.array([1.0, 2.0, 3.0]))
    close(place(parts, "b"), expected)


@pytest.mark.parametrize("merge", [False, True])
def test_included_models_stand_where_they_are_put(merge: bool, tmp_path: Path) -> None:
    joint = hinge("j", "a", "b", axis='<xyz expressed_in="__model__">0 1 0</xyz>')
    (tmp_path / "arm").mkdir()
    (tmp_path / "arm" / "model.config").write_text(
        '<model><sdf version="1.4">old.sdf</sdf><sdf version="1.9">arm.sdf</sdf></model>',
        encoding="utf-8",
    )
    (tmp_path / "arm" / "arm.sdf").write_text(
        f'<sdf version="1.9"><model name="arm"><link name="a">{pose(B)}</link><link name="b"/>'
        f"{joint}</model></sdf>",
        encoding="utf-8",
    )
    word = ' merge="true"' if merge else ""
    prefix = "" if merge else "left::"
    uri = "arm" if merge else "model://arm"
    parts = read(
        tmp_path,
        f'<model name="m">{pose(D)}<link name="base"/><include{word}><uri>{uri}</uri>'
        f"<name>left</name>{pose(A)}</include>{hinge('i', 'base', prefix + 'a')}"
        f"{hinge('h', 'world', 'base')}</model>",
    )
    close(place(parts, f"{prefix}a"), at(D, A, B))
    close(place(parts, f"{prefix}b"), at(D, A))
    assert_allclose(axis(parts, f"{prefix}j"), at(D, A).rotation @ [0.0, 1.0, 0.0], atol=1e-14)


def test_a_world_holds_models_and_joints(tmp_path: Path) -> None:
    parts = read(
        tmp_path,
        '<world name="w"><model name="ground"><static>true</static><link name="a"/></model>'
        f'<model name="m">{pose(A)}<link name="a">{pose(B)}</link><link name="b"/>'
        f"{hinge('j', 'a', 'b')}</model>"
        f'<frame name="f">{pose(C)}</frame>{hinge("i", "ground::a", "m::a", pose(D, "f"))}</world>',
    )
    assert list(parts.model.names)[1:] == ["i", "j"]
    close(place(parts, "a"), at(A, B))
    close(place(parts, "i"), at(C, D))
    assert parts.model.frames[parts.model.getFrameId("ground::a")].parentJoint == 0


def test_a_model_that_nothing_holds_floats_from_its_canonical_link(tmp_path: Path) -> None:
    content = f'<link name="a">{pose(B)}</link><link name="b"/>{hinge("j", "a", "b")}</model>'
    for more, link, expected in (
        ("", "a", (A, B)),
        (' canonical_link="b"', "b", (A,)),
    ):
        parts = read(tmp_path, f'<model name="m"{more}>{pose(A)}{content}')
        assert list(parts.model.names)[1:] == ["root_joint", "j"]
        close(parts.model.jointPlacements[1], at(*expected))
        assert parts.model.frames[parts.model.getFrameId(link)].parentJoint == 1


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (
            f'<link name="a">{pose(A, "b")}</link><link name="b">{pose(A, "a")}</link>',
            "relative to each",
        ),
        (
            '<link name="a"/><frame name="f" attached_to="g"/><frame name="g" attached_to="f"/>'
            + hinge("j", "f", "a"),
            "attached to each",
        ),
        (f'<link name="a">{pose(A, "nowhere")}</link>', "no 'nowhere' in the model"),
        ('<link name="a"/><frame name="a"/>', "two of 'a'"),
        ('<link name="world"/>', "keeps for itself"),
        ('<link name="a"/><frame name="f" attached_to="world"/>', "<parent> of joints alone"),
        ('<link name="a"/>' + hinge("j", "a", "a"), "with itself"),
        ('<link name="a"/>' + hinge("j", "a", "world"), "<child> must be"),
        ('<link name="a"/><model name="n"><link/></model>', "a <link> has no name"),
        (
            '<link name="a"><inertial><pose relative_to="b">0 0 0 0 0 0</pose></inertial></link>',
            "relative to the link",
        ),
        ('<link name="a"><pose>0 0 0 0 0</pose></link>', "6 finite numbers"),
        ('<link name="a"><pose degrees="maybe">0 0 0 0 0 0</pose></link>', "true or false"),
        ('<link name="a"><pose rotation_format="matrix">1</pose></link>', "unknown format"),
        ("<model name='n'>" * 40 + "</model>" * 40, "nested deeper"),
    ],
)
def test_what_is_wrong_is_named(content: str, said: str, tmp_path: Path) -> None:
    with pytest.raises(InvalidRobotFile) as caught:
        read(tmp_path, f'<model name="m">{content}</model>')
    assert said in caught.value.reason
