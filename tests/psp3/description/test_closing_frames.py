"""Loops that are told by the names of frames, as onshape-to-robot and PlaCo name them."""

from __future__ import annotations

from pathlib import Path

import pytest
from numpy.testing import assert_allclose

from psp3.description.closing_frames import closing_frames
from psp3.description.urdf import read_tree
from psp3.errors import InvalidRobotFile, InvalidValue
from psp3.robots.closed_loop_robot import ClosedLoopRobot
from tests.psp3.description.written import HINGES, home, joint, link, loop_file, written


def five_links(directory: Path, *ends: tuple[str, str, str]) -> Path:
    """Write crank, coupler and rocker, with frames of some names at places on some links."""
    joints = [
        joint("crank", "base", "one", xyz=HINGES["crank"]),
        joint("coupler", "one", "two", xyz=HINGES["coupler"], limit="lower='-99' upper='99'"),
        joint("rocker", "base", "three", xyz=HINGES["rocker"]),
    ]
    frames = [f"<link name='{name}'/>" for name, _, _ in ends]
    frames += [joint(f"{name}_frame", on, name, "fixed", xyz) for name, on, xyz in ends]
    names = ("base", "one", "two", "three")
    return written(directory / "mates.urdf", *map(link, names), *joints, *frames)


POINT = (("closing_top_1", "two", "0.35 0 0"), ("closing_top_2", "three", "0.4 0 0"))
AXIS = (("closing_top_1_z", "two", "0.35 0 0.1"), ("closing_top_2_z", "three", "0.4 0 0.1"))


def test_two_frames_of_a_mate_are_a_point_and_with_two_more_a_hinge(tmp_path: Path) -> None:
    for ends, kind in ((POINT, "3d"), (POINT + AXIS, "hinge"), (POINT + AXIS[:1], "3d")):
        path = five_links(tmp_path, *ends)
        model, _ = read_tree(path)
        assert closing_frames(path, model) == [("closing_top_1", "closing_top_2", kind)]
        assert closing_frames(path, model, [("closing_top_1", "closing_top_2", "6d")]) == []


@pytest.mark.parametrize("ends", [POINT, POINT + AXIS], ids=["point", "hinge"])
def test_such_a_robot_moves_as_with_a_loop_file(
    tmp_path: Path, ends: tuple[tuple[str, str, str], ...]
) -> None:
    """The same linkage, joined at a point; 1e-10 relative, as loops are closed to 1e-13."""
    urdf, poses = five_links(tmp_path, *ends), home(tmp_path, tip=False)
    loops = tmp_path / "loops.yaml"
    loops.write_text(
        loop_file(tmp_path, "3d").read_text().replace("end, other", "closing_top_1, closing_top_2")
    )
    robot = ClosedLoopRobot.from_urdf(urdf, srdf=poses, actuated=["crank"])
    expected = ClosedLoopRobot.from_urdf(urdf, loops, poses)
    assert robot.mobility.degrees_of_freedom == 1
    for ours, theirs in zip(
        robot.equation_of_motion([1.3], [2.0]),
        expected.equation_of_motion([1.3], [2.0]),
        strict=True,
    ):
        assert_allclose(ours, theirs, rtol=1e-10, atol=1e-10)


def test_a_loop_in_python_is_taken_instead_of_that_by_name(tmp_path: Path) -> None:
    urdf = five_links(tmp_path, *POINT)
    closures = [("closing_top_1", "closing_top_2", "hinge")]
    robot = ClosedLoopRobot.from_urdf(
        urdf, srdf=home(tmp_path, tip=False), actuated=["crank"], closures=closures
    )
    assert (len(robot.constraint_models), len(robot.equations)) == (0, 1)


def test_the_motors_of_such_a_robot_must_be_named(tmp_path: Path) -> None:
    with pytest.raises(InvalidValue, match="out of crank, coupler, rocker"):
        ClosedLoopRobot.from_urdf(five_links(tmp_path, *POINT))
    with pytest.raises(InvalidRobotFile, match="actuated: the robot has no joint 'elbow'"):
        ClosedLoopRobot.from_urdf(five_links(tmp_path, *POINT), actuated=["elbow"])


def test_a_frame_without_the_other_one_is_refused(tmp_path: Path) -> None:
    path = five_links(tmp_path, POINT[0], ("closing_tip_2", "three", "0.4 0 0"))
    with pytest.raises(
        InvalidRobotFile, match="'closing_top_1' closes a loop with 'closing_top_2'"
    ):
        ClosedLoopRobot.from_urdf(path, actuated=["crank"])
    # Said in another way it is joined.
    model, _ = read_tree(path)
    assert closing_frames(path, model, [("closing_top_1", "closing_tip_2", "3d")]) == []
