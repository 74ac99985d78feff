"""The robot's files.

URDF numbers are those of the parameter class, poses close the loops, names are known.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from numpy.testing import assert_allclose

import psp3
from psp3.description.parts import ROBOT_FILES, ROBOTS
from psp3.description.srdf import reference_poses
from psp3.description.urdf import read_tree
from psp3.errors import InvalidRobotFile, InvalidValue, UnknownName, UnknownRobot

LEGS = (1, 2, 3)


def test_load_returns_what_example_robot_data_returns_and_the_loops() -> None:
    robot = psp3.load("psp3")
    assert isinstance(robot, psp3.PSP3)
    assert (robot.model.nq, robot.model.nv) == (15, 15)
    assert isinstance(robot.data, pin.Data)
    assert isinstance(robot.visual_model, pin.GeometryModel)
    assert robot.visual_model.ngeoms > 0
    assert len(robot.constraint_models) == 2
    assert robot.actuated == ("a1", "a2", "a3")
    assert robot.parameters == psp3.Parameters()
    assert robot.q0.shape == (15,)


def test_default_arguments_load_the_default_robot() -> None:
    assert (
        psp3.load().parameters
        == psp3.load("psp3", parameters="default").parameters
        == psp3.PARAMETER_SETS["default"]
    )


def test_loads_do_not_share_what_can_be_changed() -> None:
    """One robot with a longer tool must leave the next one alone."""
    before = psp3.load("psp3").forward_kinematics(np.zeros(3)).tip[2]
    psp3.load("psp3", psp3.Parameters(tool_length=0.5))
    assert psp3.load("psp3").forward_kinematics(np.zeros(3)).tip[2] == before == 0.070


@pytest.mark.parametrize("name", ["psp4", "", "PSP3"])
def test_unknown_robot_is_refused_with_the_known_names(name: str) -> None:
    with pytest.raises(UnknownName, match="known are psp3, five_bar") as caught:
        psp3.load(name)
    assert caught.value.name == name
    assert caught.value.known == ROBOTS
    assert isinstance(caught.value, ValueError)


@pytest.mark.parametrize("parameters", ["table_9_9", ""])
def test_unknown_parameter_set_is_refused_with_the_known_names(parameters: str) -> None:
    with pytest.raises(UnknownName, match="default, table_3_1, table_5_1"):
        psp3.load("psp3", parameters)


@pytest.mark.parametrize("parameters", [["default"], {"screw_radius": 0.2}, None])
def test_parameters_of_a_wrong_kind_are_refused(parameters: object) -> None:
    with pytest.raises(psp3.PSP3Error):
        psp3.load("psp3", parameters)  # type: ignore[arg-type]


def test_no_name_is_refused() -> None:
    with pytest.raises(psp3.PSP3Error, match="name of a robot, or the path of its file, got None"):
        psp3.load(None)  # type: ignore[call-overload]


def test_reference_poses_close_the_loops_and_are_those_of_the_closed_form() -> None:
    """Every pose of the SRDF: loops and joint values to 1e-12.

    Loops are open by less, and joint values are those of the closed form.
    """
    robot = psp3.load("psp3")
    poses = reference_poses(robot.model, ROBOT_FILES / "psp3.srdf")
    assert set(poses) >= {"home", "tilted", "low", "high"}
    lower, upper = robot.stroke
    data = robot.model.createData()
    index = [robot.model.joints[robot.model.getJointId(name)].idx_q for name in robot.actuated]
    for q in poses.values():
        pin.framesForwardKinematics(robot.model, data, q)
        first, second, third = (
            data.oMf[robot.model.getFrameId(f"star{leg}_center")] for leg in LEGS
        )
        for other in (second, third):
            assert np.abs(pin.log6(first.actInv(other)).vector).max() < 1e-12
        assert_allclose(q, robot.configuration(q[index]), rtol=0, atol=1e-12)
        assert (lower <= q[index]).all()
        assert (q[index] <= upper).all()
        assert (robot.model.lowerPositionLimit <= q).all()
        assert (q <= robot.model.upperPositionLimit).all()
    assert_allclose(poses["home"], robot.q0, rtol=0, atol=1e-15)
    assert_allclose(
        robot.forward_kinematics(poses["tilted"][index]).rotation[2, 2],
        np.cos(np.radians(25)),
        rtol=1e-14,
    )


def test_reference_poses_fit_a_robot_of_other_lengths() -> None:
    """Poses that the model carries along are poses of this robot.

    Loops open by less than 1e-12 with screws farther apart.
    """
    robot = psp3.load("psp3", psp3.Parameters(screw_radius=0.25))
    noc = psp3.NaturalOrthogonalComplement(robot)
    for pose in robot.model.referenceConfigurations:
        assert np.abs(noc.constraint(pose.data())).max() < 1e-12, pose.key()


def test_the_files_load_without_the_parameter_class_too() -> None:
    """URDF, SRDF and loop file alone give the default robot's dynamics; 1e-12 relative."""
    from_files = psp3.ClosedLoopRobot.from_urdf(
        ROBOT_FILES / "psp3.urdf", ROBOT_FILES / "psp3.yaml", ROBOT_FILES / "psp3.srdf"
    )
    robot = psp3.load("psp3")
    heights, speeds = [0.05, -0.02, 0.1], [0.3, 0.1, -0.2]
    for found, expected in zip(
        from_files.equation_of_motion(heights, speeds),
        robot.equation_of_motion(heights, speeds),
        strict=True,
    ):
        assert_allclose(found, expected, rtol=0, atol=1e-12 * np.abs(expected).max())
    assert_allclose(from_files.q0, robot.q0, rtol=0, atol=1e-15)


def test_a_file_is_read_with_its_loops_and_poses_beside_it(tmp_path: Path) -> None:
    """As a path or a string, of any ending of a robot's; the same robot as by its name."""
    for ending in ("urdf", "yaml", "srdf"):
        text = (ROBOT_FILES / f"five_bar.{ending}").read_text()
        (tmp_path / f"mine.{ending}").write_text(text)
    expected = psp3.load("five_bar")
    (tmp_path / "mine.xml").write_text((tmp_path / "mine.urdf").read_text())
    for name in (tmp_path / "mine.urdf", str(tmp_path / "mine.urdf"), tmp_path / "mine.xml"):
        robot = psp3.load(name)
        assert robot.actuated == expected.actuated
        assert_allclose(robot.q0, expected.q0, rtol=0, atol=0)
    one = psp3.load(tmp_path / "mine.urdf", actuated=["leg1_shoulder"], free="keep")
    assert one.coordinates == ("leg1_shoulder", "leg1_elbow")
    other = tmp_path / "other.yaml"
    other.write_text((tmp_path / "mine.yaml").read_text().replace("leg2_shoulder", "leg2_elbow"))
    assert psp3.load(tmp_path / "mine.urdf", loops=other).actuated[1] == "leg2_elbow"


def test_a_file_is_read_as_its_outermost_element_says(tmp_path: Path) -> None:
    body = '<body name="arm"><joint name="hinge"/><geom size="0.1"/></body>'
    mjcf = f"<mujoco><worldbody>{body}</worldbody></mujoco>"
    for name in ("arm.xml", "arm.mjcf", "arm.urdf"):
        (tmp_path / name).write_text(mjcf)
        assert psp3.load(tmp_path / name, actuated=["hinge"]).actuated == ("hinge",)


@pytest.mark.parametrize("ending", ["sdf", "world"])
def test_an_sdf_is_read_as_its_library_reads_it(tmp_path: Path, ending: str) -> None:
    """Two dashes in a comment and a prefix that is not declared are no XML, and in public files."""
    (tmp_path / f"arm.{ending}").write_text(
        """<?xml version="1.0"?><sdf version="1.7"><model name="arm"><!-- a -- b -->
        <link name="upper"><inertial><mass>1</mass></inertial></link>
        <joint name="hinge" type="revolute"><parent>world</parent><child>upper</child>
        <drake:rotor_inertia>0</drake:rotor_inertia><axis><xyz>0 1 0</xyz></axis></joint>
        </model></sdf>"""
    )
    robot = psp3.load(tmp_path / f"arm.{ending}", actuated=["hinge"])
    assert robot.actuated == ("hinge",)
    (tmp_path / "page.sdf").write_text("<robot name='arm'/>")
    with pytest.raises(InvalidRobotFile, match="is a URDF: read it with from_urdf"):
        psp3.load(tmp_path / "page.sdf")


def test_what_is_no_robot_is_refused_with_what_to_do(tmp_path: Path) -> None:
    with pytest.raises(UnknownRobot, match=r"psp3\.load\('my_robot\.urdf'\)"):
        psp3.load("my_robot")
    with pytest.raises(InvalidRobotFile, match="no such file"):
        psp3.load("my_robot.urdf")
    (tmp_path / "page.xml").write_text("<html/>")
    with pytest.raises(InvalidRobotFile, match="<html>; robots are read from robot, mujoco, sdf"):
        psp3.load(tmp_path / "page.xml")
    with pytest.raises(InvalidRobotFile, match="xacro"):
        psp3.load("my_robot.urdf.xacro")
    with pytest.raises(InvalidValue, match="only 'psp3' has other sets"):
        psp3.load(tmp_path / "page.xml", parameters="table_3_1")
    with pytest.raises(InvalidValue, match="none for robot 'psp3'"):
        psp3.load("psp3", "default", free="keep")


def test_robot_files_are_installed_beside_the_code() -> None:
    for name in ("psp3.urdf", "psp3.srdf", "psp3.yaml"):
        assert (ROBOT_FILES / name).is_file()


@pytest.mark.parametrize("text", ["", "<robot", "<robot name='x'><link/></robot>"])
def test_urdf_that_pinocchio_cannot_read_is_refused(tmp_path: Path, text: str) -> None:
    path = tmp_path / "bad.urdf"
    path.write_text(text)
    with pytest.raises(InvalidRobotFile) as caught:
        read_tree(path)
    assert caught.value.path == path
