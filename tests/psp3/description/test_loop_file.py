"""Loop files: what is read from them, and what is refused."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

import psp3
from psp3.description.loop_file import LARGEST, Loops, constraint_models, read_loops
from psp3.description.parts import ROBOT_FILES
from psp3.errors import InvalidRobotFile

GOOD = "closed_loop: [[A, B], [A, C]]\ntype: ['6d', '3D']\nname_mot: [x, y]\n"


def written(directory: Path, text: str) -> Path:
    path = directory / "robot.yaml"
    path.write_text(text, encoding="utf-8")
    return path


def test_reads_pairs_kinds_and_motors(tmp_path: Path) -> None:
    """toolbox-parallel-robots writes kinds in both cases."""
    assert read_loops(written(tmp_path, GOOD)) == Loops(
        (("A", "B"), ("A", "C")), ("6d", "3d"), ("x", "y")
    )


def test_reads_a_path_given_as_text(tmp_path: Path) -> None:
    assert read_loops(str(written(tmp_path, GOOD))).actuated == ("x", "y")


def test_a_robot_without_loops_has_empty_lists(tmp_path: Path) -> None:
    assert read_loops(written(tmp_path, "closed_loop: []\ntype: []\nname_mot: [x]\n")) == Loops(
        (), (), ("x",)
    )


def test_reads_what_replaces_joints(tmp_path: Path) -> None:
    """In either case; keys of toolbox-parallel-robots may be empty lists, or left out."""
    text = GOOD + "joint_name: [ball, cross]\njoint_type: [spherical, UJOINT_ZY]\n"
    assert read_loops(written(tmp_path, text)).replaced == (
        ("ball", "SPHERICAL"),
        ("cross", "UJOINT_ZY"),
    )
    assert read_loops(written(tmp_path, GOOD + "joint_name: []\njoint_type: []\n")).replaced == ()
    assert read_loops(written(tmp_path, GOOD)).replaced == ()


def test_keys_of_other_tools_are_left_alone_and_told(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """Files of toolbox-parallel-robots hold more keys than the five that are read.

    So does one in which a key is misspelt.
    """
    text = GOOD + "rotation: [0, 0]\njoint_nmae: [y]\n"
    with caplog.at_level("WARNING", "psp3"):
        assert read_loops(written(tmp_path, text)).kinds == ("6d", "3d")
    assert "these keys are not read: 'rotation', 'joint_nmae'" in caplog.text


def test_files_that_would_fill_the_memory_or_the_stack_are_refused(tmp_path: Path) -> None:
    """Lists in lists, and a list of nine of the one before, nine times: 9⁹ names if written out."""
    lists = "".join(
        f"{b}: &{b} [{', '.join([f'*{a}'] * 9)}]\n" for a, b in itertools.pairwise("abcdefghi")
    )
    bomb = f"a: &a [x, x]\n{lists}closed_loop: *i\ntype: []\nname_mot: []\n"
    for text in ("[" * 20000, bomb):
        with pytest.raises(InvalidRobotFile) as caught:
            read_loops(written(tmp_path, text))
        assert len(caught.value.reason) < 600


@pytest.mark.parametrize(
    "value",
    [
        "2001-99-99",
        "!!int ''",
        "!!bool 'abc'",
        "!!float x",
        "!!binary '!'",
        "!own {a: 1}",
        "&r [*r]",
    ],
)
def test_what_stands_under_keys_of_other_tools_is_never_made(tmp_path: Path, value: str) -> None:
    """A date that is none would be an error of Python's, and a tag may ask for any object."""
    assert read_loops(written(tmp_path, GOOD + f"other: {value}\n")).actuated == ("x", "y")


def test_a_repeated_list_stays_one_list(tmp_path: Path) -> None:
    """Programs that write the same list twice write an alias, as PyYAML does."""
    text = "closed_loop: [&a [A, B], *a]\ntype: ['6d', '3d']\nname_mot: [x]\n"
    assert read_loops(written(tmp_path, text)).frames == (("A", "B"), ("A", "B"))


def test_larger_files_than_any_robot_needs_are_not_read(tmp_path: Path) -> None:
    with pytest.raises(InvalidRobotFile, match=r"larger than 0\.25 MiB"):
        read_loops(written(tmp_path, GOOD + "#" * LARGEST))


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("", "closed_loop, type and name_mot"),
        ("just text", "closed_loop, type and name_mot"),
        ("closed_loop: [[A, B]\n", "cannot be read as YAML"),
        ("closed_loop: [[A, B]]\nname_mot: [x]\n", "lacks the key type"),
        ("type: ['6d']\n", "lacks the key closed_loop, name_mot"),
        ("closed_loop: A\ntype: ['6d']\nname_mot: [x]\n", "list of frame pairs"),
        ("closed_loop: [A, B]\ntype: ['6d', '6d']\nname_mot: [x]\n", "list of names"),
        ("closed_loop: [[A, 5]]\ntype: ['6d']\nname_mot: [x]\n", "list of names"),
        ("closed_loop: [[A, B, C]]\ntype: ['6d']\nname_mot: [x]\n", "joins two frames"),
        ("closed_loop: [[A]]\ntype: ['6d']\nname_mot: [x]\n", "joins two frames"),
        (
            "closed_loop: [[A, B]]\ntype: ['6d', '6d']\nname_mot: [x]\n",
            "for each of the 1 closed loops",
        ),
        ("closed_loop: [[A, B]]\ntype: []\nname_mot: [x]\n", "for each of the 1 closed loops"),
        ("closed_loop: [[A, B]]\ntype: ['2d']\nname_mot: [x]\n", "'6d', '3d' or 'hinge'"),
        ("closed_loop: [[A, B]]\ntype: 6d\nname_mot: [x]\n", "'type' must hold a list of names"),
        (
            "closed_loop: [[A, B]]\ntype: ['6d']\nname_mot: x\n",
            "'name_mot' must hold a list of names",
        ),
        (
            "closed_loop: [[A, B]]\ntype: ['6d']\nname_mot: [1]\n",
            "'name_mot' must hold a list of names",
        ),
        ("!!python/object/apply:os.getcwd []\n", "closed_loop, type and name_mot"),
        (GOOD + "type: ['6d', '6d']\n", "the file names a key twice: type"),
        (GOOD.replace("[x, y]", "!!python/tuple [x, y]"), "'name_mot' must hold a list of names"),
        (GOOD.replace("[x, y]", "!own [x, y]"), "'name_mot' must hold a list of names"),
        (GOOD.replace("[x, y]", "[x, 2001-12-14]"), "got ['x', 2001-12-14]"),
        (GOOD.replace("[x, y]", "{x: y}"), "'name_mot' must hold a list of names"),
        ("closed_loop: [[A, A]]\ntype: ['6d']\nname_mot: [x]\n", "joins a frame with itself"),
        ("closed_loop: []\ntype: []\nname_mot: [x, y, x]\n", "name_mot names a joint twice: x"),
        (
            GOOD + "joint_name: [a, a]\njoint_type: [FIXED, FIXED]\n",
            "joint_name names a joint twice: a",
        ),
        (GOOD + "joint_name: [a]\n", "'joint_type' must give a type for each of the 1 joints"),
        (GOOD + "joint_type: [FIXED]\n", "'joint_type' must give a type for each of the 0 joints"),
        (GOOD + "joint_name: a\njoint_type: [FIXED]\n", "'joint_name' must hold a list of names"),
        (GOOD + "joint_name: [a]\njoint_type:\n", "'joint_type' must hold a list of names"),
        (
            GOOD + "joint_name: [a]\njoint_type: [UNIVERSAL]\n",
            "'UNIVERSAL' for joint 'a' is unknown; known are SPHERICAL, UJOINT_XY",
        ),
        (
            GOOD + "joint_name: [x]\njoint_type: [SPHERICAL]\n",
            "'x' is actuated (name_mot) and cannot be replaced by SPHERICAL",
        ),
        (
            GOOD + "joint_name: [y]\njoint_type: [FIXED]\n",
            "'y' is actuated (name_mot) and cannot be replaced by FIXED",
        ),
    ],
)
def test_malformed_files_are_refused_with_path_and_reason(
    tmp_path: Path, text: str, reason: str
) -> None:
    """The last file would run code with an unsafe YAML loader."""
    path = written(tmp_path, text)
    with pytest.raises(InvalidRobotFile) as caught:
        read_loops(path)
    assert caught.value.path == path
    assert reason in caught.value.reason
    assert str(path) in str(caught.value)
    assert isinstance(caught.value, ValueError)
    assert isinstance(caught.value, psp3.PSP3Error)


def test_missing_file_directory_and_binary_file_are_refused(tmp_path: Path) -> None:
    binary = tmp_path / "binary.yaml"
    binary.write_bytes(b"\xff\xfe\x00\xd8")
    for path, reason in (
        (tmp_path / "no.yaml", "no such file$"),
        (tmp_path, "is a directory$"),
        (binary, "cannot be read as YAML"),
    ):
        with pytest.raises(InvalidRobotFile, match=reason) as caught:
            read_loops(path)
        assert caught.value.path == path


@pytest.fixture(scope="module")
def tree() -> pin.Model:
    return pin.buildModelFromUrdf(str(ROBOT_FILES / "psp3.urdf"))


def test_the_robots_own_file_names_its_two_loops_and_three_motors(tree: pin.Model) -> None:
    loops = read_loops(ROBOT_FILES / "psp3.yaml")
    assert loops.actuated == ("a1", "a2", "a3")
    models = constraint_models(tree, loops, "psp3.yaml")
    assert [model.type for model in models] == [pin.ContactType.CONTACT_6D] * 2
    assert [model.reference_frame for model in models] == [pin.ReferenceFrame.LOCAL] * 2


def test_constraint_models_join_the_frames_where_they_sit_on_their_bodies(tree: pin.Model) -> None:
    """The frames tip and star2_center sit away from their joints.

    Equality, because placements are copied.
    """
    (model,) = constraint_models(
        tree, Loops((("tip", "star2_center"),), ("3d",), ("a1",)), "x.yaml"
    )
    assert model.type == pin.ContactType.CONTACT_3D
    assert (model.joint1_id, model.joint2_id) == (tree.getJointId("b1"), tree.getJointId("b2"))
    np.testing.assert_array_equal(
        model.joint1_placement.homogeneous,
        tree.frames[tree.getFrameId("tip")].placement.homogeneous,
    )
    np.testing.assert_array_equal(
        model.joint2_placement.homogeneous,
        tree.frames[tree.getFrameId("star2_center")].placement.homogeneous,
    )


@pytest.mark.parametrize(
    ("loops", "reason"),
    [
        (Loops((("star1_center", "star9_center"),), ("6d",), ("a1",)), "no frame 'star9_center'"),
        (Loops((("nowhere", "star2_center"),), ("6d",), ("a1",)), "no frame 'nowhere'"),
        (Loops((), (), ("a1", "a4")), "no joint 'a4'"),
        # A fixed joint is a frame of the model, but nothing that a motor can drive.
        (Loops((), (), ("tip_joint",)), "no joint 'tip_joint'"),
        (Loops((), (), ("a1", "a1")), "twice"),
        # Pinocchio counts the world among its joints.
        (Loops((), (), ("universe",)), "universe"),
        # Both sit on the third of the star at the end of the first leg.
        (Loops((("star1_center", "tip"),), ("6d",), ("a1",)), "both frames are on the same body"),
    ],
)
def test_names_that_are_not_in_the_model_are_refused(
    tree: pin.Model, loops: Loops, reason: str
) -> None:
    with pytest.raises(InvalidRobotFile) as caught:
        constraint_models(tree, loops, "some.yaml")
    assert caught.value.path == Path("some.yaml")
    assert reason in caught.value.reason


def test_a_joint_with_several_degrees_of_freedom_cannot_be_actuated() -> None:
    model = pin.Model()
    model.addJoint(0, pin.JointModelSpherical(), pin.SE3.Identity(), "ball")
    with pytest.raises(InvalidRobotFile, match="'ball' has 3 degrees of freedom"):
        constraint_models(model, Loops((), (), ("ball",)), "some.yaml")


def test_a_joint_and_its_link_may_have_the_same_name() -> None:
    """A URDF allows it; their frames coincide, so a loop that names them is clear."""
    text = (
        "<robot name='r'><link name='a'/><link name='b'/><link name='c'/>"
        "<joint name='b' type='continuous'><parent link='a'/><child link='b'/></joint>"
        "<joint name='c' type='continuous'><parent link='a'/><child link='c'/></joint></robot>"
    )
    model = pin.buildModelFromXML(text)
    assert [frame.name for frame in model.frames].count("b") == 2
    (found,) = constraint_models(model, Loops((("b", "c"),), ("6d",), ()), "some.yaml")
    assert (found.joint1_id, found.joint2_id) == (model.getJointId("b"), model.getJointId("c"))


def test_two_frames_of_one_name_in_different_places_are_refused(tree: pin.Model) -> None:
    model = tree.copy()
    model.addFrame(
        pin.Frame("tip", model.getJointId("b2"), pin.SE3.Identity(), pin.FrameType.SENSOR)
    )
    with pytest.raises(InvalidRobotFile, match="several frames 'tip'; say which, 'body:tip'"):
        constraint_models(model, Loops((("tip", "star3_center"),), ("3d",), ("a1",)), "some.yaml")
    (found,) = constraint_models(
        model, Loops((("frame:tip", "star3_center"),), ("3d",), ("a1",)), "some.yaml"
    )
    assert found.joint1_id == model.getJointId("b2")
