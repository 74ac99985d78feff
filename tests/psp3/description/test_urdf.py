"""Robots from their files.

Trees with and without limits and meshes, reference poses, replaced joints, and what is refused.
"""

from __future__ import annotations

import logging
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from psp3.description.parts import ROBOT_FILES
from psp3.description.urdf import read_robot, read_tree
from psp3.errors import InvalidRobotFile, MobilityMismatch
from psp3.robots.closed_loop_robot import ClosedLoopRobot
from tests.psp3.description.written import (
    HINGES,
    four_bar,
    home,
    joint,
    link,
    loop_file,
    written,
)

STL = (
    "solid s\n facet normal 0 0 1\n  outer loop\n   vertex 0 0 0\n   vertex 1 0 0\n"
    "   vertex 0 1 0\n  endloop\n endfacet\n"
    " facet normal 0 1 0\n  outer loop\n   vertex 0 0 0\n   vertex 0 0 1\n   vertex 1 0 0\n"
    "  endloop\n endfacet\nendsolid s\n"
)


# Limits


def test_joints_without_lower_and_upper_limits_have_none(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """To the letter both would be 0, and the joint could not move.

    One limit alone leaves the other at 0, as the format says.
    """
    links = [link(name) for name in "abcde"]
    joints = [
        joint("free", "a", "b", limit=" "),
        joint("slide", "b", "c", "prismatic", limit=" "),
        joint("half", "c", "d", limit="upper='2'"),
        joint("locked", "d", "e", limit="lower='0' upper='0'"),
    ]
    with caplog.at_level(logging.WARNING, "psp3"):
        model, _ = read_tree(written(tmp_path / "r.urdf", *links, *joints))
    assert_array_equal(model.lowerPositionLimit, [-np.inf, -np.inf, 0.0, 0.0])
    assert_array_equal(model.upperPositionLimit, [np.inf, np.inf, 2.0, 0.0])
    assert [record.getMessage().partition(": ")[2] for record in caplog.records] == [
        "without lower and upper limits, taken as unlimited: free, slide"
    ]


def test_many_joints_without_limits_are_not_all_listed(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    joints = [joint(f"j{k}", f"l{k}", f"l{k + 1}", limit=" ") for k in range(6)]
    read_tree(written(tmp_path / "r.urdf", *(link(f"l{k}") for k in range(7)), *joints))
    assert "unlimited: j0, j1, j2 and 3 more" in caplog.text


# Meshes


def test_meshes_are_found_as_their_package_or_relative_to_the_file(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """In the layout that most packages have; from another directory than the file's."""
    package = tmp_path / "some_robot"
    (package / "meshes").mkdir(parents=True)
    (package / "meshes" / "arm.stl").write_text(STL)
    (package / "urdf").mkdir()
    (package / "urdf" / "arm.stl").write_text(STL)
    absolute = (package / "meshes" / "arm.stl").as_posix()
    names = [
        "package://some_robot/meshes/arm.stl",
        "package://meshes/arm.stl",
        "../meshes/arm.stl",
        "package:///arm.stl",
        absolute,
    ]
    model, shapes = read_tree(
        written(
            package / "urdf" / "r.urdf",
            link("a", *(f"<mesh filename='{name}'/>" for name in names)),
        )
    )
    assert model.nq == 0
    assert [Path(shape.meshPath).name for shape in shapes.geometryObjects] == ["arm.stl"] * len(
        names
    )
    assert not caplog.records


def test_meshes_that_cannot_be_read_are_not_drawn_and_the_rest_is(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """Missing in three ways, and broken.

    The model and all other shapes are there, and a warning for each file.
    """
    (tmp_path / "good.stl").write_text(STL)
    (tmp_path / "broken.stl").write_text("solid nothing")
    box, sphere = "<box size='1 1 1'/>", "<sphere radius='1'/>"
    bad = [
        f"<mesh filename='{name}'/>"
        for name in ("package://no_robot/a.stl", "file:///no/a.stl", "a.stl", "broken.stl")
    ]
    good = "<mesh filename='good.stl' scale='2 2 2'/>"
    path = written(
        tmp_path / "r.urdf",
        link("a", box, *bad, good),
        link("b", bad[0], sphere),
        joint("j", "a", "b"),
    )
    model, shapes = read_tree(path)
    assert model.njoints == 2
    assert [(shape.parentJoint, Path(shape.meshPath).name) for shape in shapes.geometryObjects] == [
        (0, "BOX"),
        (0, "good.stl"),
        (1, "SPHERE"),
    ]
    assert_array_equal(shapes.geometryObjects[1].meshScale, [2.0, 2.0, 2.0])
    assert [record.levelname for record in caplog.records] == ["WARNING"] * 4
    for name in ("package://no_robot/a.stl", "file:///no/a.stl", "/a.stl", "broken.stl"):
        assert f"{name} cannot be read and is not drawn" in caplog.text


def test_meshes_change_nothing_about_the_motion(tmp_path: Path) -> None:
    bare = written(tmp_path / "bare.urdf", link("a"), link("b"), joint("j", "a", "b"))
    drawn = written(
        tmp_path / "drawn.urdf",
        link("a", "<mesh filename='no.stl'/>"),
        link("b"),
        joint("j", "a", "b"),
    )
    assert read_tree(bare)[0] == read_tree(drawn)[0]


# Whole robots


def test_a_robot_has_what_its_files_say(tmp_path: Path) -> None:
    parts = read_robot(four_bar(tmp_path, hinge="revolute"), loop_file(tmp_path), home(tmp_path))
    assert list(parts.model.names)[1:] == ["crank", "coupler", "tip", "rocker"]
    assert parts.actuated == ("crank",)
    assert [model.name for model in parts.constraint_models] == ["end-other"]
    assert parts.q0 is not None
    assert_array_equal(parts.q0, [1.0, -0.6, 0.8, 1.2])
    assert read_robot(four_bar(tmp_path, hinge="revolute"), loop_file(tmp_path)).q0 is None


@pytest.mark.parametrize(
    "replaced",
    [
        # Each leaves the linkage one degree of freedom and no play: what else the joint could do,
        # the weld holds.
        {"tip": "SPHERICAL"},
        {"tip": "UJOINT_ZY"},
        {"tip": "UJOINT_XZ"},
        {"coupler": "SPHERICAL"},
    ],
    ids=str,
)
def test_a_planar_linkage_moves_the_same_with_a_ball_or_universal_joint_in_place_of_a_hinge(
    tmp_path: Path, replaced: dict[str, str]
) -> None:
    """Mass, Coriolis and gravity terms of the linkage as written.

    1e-10 relative, as the loops are closed to 1e-13.
    """
    urdf = four_bar(tmp_path, hinge="revolute")
    expected = ClosedLoopRobot(*read_robot(urdf, loop_file(tmp_path), home(tmp_path)))
    parts = read_robot(urdf, loop_file(tmp_path, **replaced))
    start = pin.neutral(parts.model)
    for name, angle in {"crank": 1.0, "coupler": -0.6, "rocker": 1.2, "tip": 0.8}.items():
        if parts.model.existJointName(name) and name not in replaced:
            start[parts.model.joints[parts.model.getJointId(name)].idx_q] = angle
        elif replaced.get(name) == "SPHERICAL":
            first = parts.model.joints[parts.model.getJointId(name)].idx_q
            start[first : first + 4] = [0.0, 0.0, np.sin(angle / 2), np.cos(angle / 2)]
        else:
            start[parts.model.joints[parts.model.getJointId(f"{name}_Z")].idx_q] = angle
    found = ClosedLoopRobot(*parts._replace(q0=start))
    angles = np.array([[1.0], [1.3], [0.8]])
    speeds = np.array([[0.7], [-1.0], [2.0]])
    for ours, theirs in zip(
        found.equation_of_motion(angles, speeds),
        expected.equation_of_motion(angles, speeds),
        strict=True,
    ):
        assert_allclose(ours, theirs, rtol=1e-10, atol=1e-10)


def test_a_hinge_that_is_fixed_leaves_a_linkage_that_a_point_closes(tmp_path: Path) -> None:
    """The usual repair of a hinge that is there twice.

    FIXED, and the loop closed in position only.
    """
    urdf = four_bar(tmp_path, hinge="revolute")
    expected = ClosedLoopRobot(
        *read_robot(
            four_bar(tmp_path / "fixed", hinge="fixed"),
            loop_file(tmp_path, "3d"),
            home(tmp_path, tip=False),
        )
    )
    found = ClosedLoopRobot(
        *read_robot(urdf, loop_file(tmp_path, "3d", tip="FIXED"), home(tmp_path, tip=False))
    )
    assert list(found.model.names)[1:] == ["crank", "coupler", "rocker"]
    for ours, theirs in zip(
        found.equation_of_motion([1.3], [2.0]),
        expected.equation_of_motion([1.3], [2.0]),
        strict=True,
    ):
        assert_allclose(ours, theirs, rtol=1e-12, atol=1e-12)


# Two defects that are common in files of others: joints that move by themselves


def closed_with_two_hinges(directory: Path) -> Path:
    """Write the linkage with the hinge that closes it at both ends of the loop.

    So what is between the two can spin.
    """
    names = ("base", "one", "two", "three", "end", "other")
    joints = [
        joint("crank", "base", "one", xyz=HINGES["crank"]),
        joint("coupler", "one", "two", xyz=HINGES["coupler"]),
        joint("rocker", "base", "three", xyz=HINGES["rocker"]),
        joint("tip", "two", "end", xyz="0.35 0 0"),
        joint("top", "three", "other", xyz="0.4 0 0"),
    ]
    return written(directory / "two_hinges.urdf", *map(link, names), *joints)


def test_a_hinge_that_is_there_twice_is_named_and_can_be_fixed(tmp_path: Path) -> None:
    """Fixed in the loop file, either of the two leaves the motion of the linkage with one.

    1e-10 relative.

    The masses of the links at the end, which are the same, change hands with the hinge.
    """
    urdf = closed_with_two_hinges(tmp_path)
    with pytest.raises(MobilityMismatch, match="2 degrees of freedom") as caught:
        ClosedLoopRobot(*read_robot(urdf, loop_file(tmp_path), home(tmp_path)), free="refuse")
    assert set(caught.value.mobility.free_joints) == {"tip", "top"}
    assert caught.value.mobility.under_actuation == 1
    whole = ClosedLoopRobot(
        *read_robot(four_bar(tmp_path, hinge="revolute"), loop_file(tmp_path), home(tmp_path))
    )
    fixed = ClosedLoopRobot(*read_robot(urdf, loop_file(tmp_path, top="FIXED"), home(tmp_path)))
    for ours, theirs in zip(
        fixed.equation_of_motion([1.3], [2.0]), whole.equation_of_motion([1.3], [2.0]), strict=True
    ):
        assert_allclose(ours, theirs, rtol=1e-10, atol=1e-10)
    assert (
        ClosedLoopRobot(
            *read_robot(urdf, loop_file(tmp_path, tip="FIXED"))
        ).mobility.degrees_of_freedom
        == 1
    )


def rod_between_two_balls(directory: Path) -> Path:
    """Write crank, rod and rocker on crossed axes.

    The rod stands on the crank, and a hinge stands for its ball joint there.
    """
    joints = [
        joint("crank", "base", "one"),
        joint("foot", "one", "rod", xyz="0.1 0 0"),
        joint("rocker", "base", "two", xyz="0.3 0 0.2", axis="0 1 0"),
        joint("end", "rod", "rod_end", "fixed", "0.35 0 0"),
        joint("top", "two", "rocker_end", "fixed", "0 0 0.25"),
    ]
    return written(
        directory / "rod.urdf",
        *map(link, ("base", "one", "rod", "two", "rod_end", "rocker_end")),
        *joints,
    )


ROD = (
    "closed_loop: [[rod_end, rocker_end]]\ntype: ['3d']\nname_mot: [crank]\njoint_name: [foot]\n"
    "joint_type: [{}]\n"
)


def test_a_rod_between_two_ball_joints_spins_and_a_universal_joint_holds_it(tmp_path: Path) -> None:
    """The rod lies along x of the frame at its foot.

    A universal joint about the two other axes leaves it no spin.
    """
    urdf, loops = rod_between_two_balls(tmp_path), tmp_path / "rod.yaml"
    loops.write_text(ROD.format("SPHERICAL"))
    with pytest.raises(MobilityMismatch, match="2 degrees of freedom") as caught:
        ClosedLoopRobot(*read_robot(urdf, loops), free="refuse")
    assert caught.value.mobility.free_joints == ("foot",)
    loops.write_text(ROD.format("UJOINT_ZY"))
    robot = ClosedLoopRobot(*read_robot(urdf, loops))
    assert robot.mobility.degrees_of_freedom == 1
    q = robot.configuration(robot.reference + np.array([[0.05], [-0.05]]))
    data = robot.model.createData()
    for row in q:
        pin.framesForwardKinematics(robot.model, data, row)
        ends = [
            data.oMf[robot.model.getFrameId(name)].translation for name in ("rod_end", "rocker_end")
        ]
        assert_allclose(ends[0], ends[1], rtol=0, atol=1e-12)


def test_a_continuous_motor_drives_an_angle_without_limits(tmp_path: Path) -> None:
    """The same robot as with a revolute one, and again after two turns of the crank.

    1e-10 relative, as the loop is closed to 1e-13.
    """
    angles = np.array([[1.0], [1.0 + 4.0 * np.pi]])
    parts = read_robot(
        four_bar(tmp_path, hinge="revolute", crank="continuous"),
        loop_file(tmp_path),
        home(tmp_path),
    )
    expected = ClosedLoopRobot(
        *read_robot(four_bar(tmp_path, hinge="revolute"), loop_file(tmp_path), home(tmp_path))
    )
    index = parts.model.joints[parts.model.getJointId("crank")].idx_q
    assert (parts.model.lowerPositionLimit[index], parts.model.upperPositionLimit[index]) == (
        -np.inf,
        np.inf,
    )
    mass = ClosedLoopRobot(*parts).mass_matrix(angles)
    assert_allclose(mass, expected.mass_matrix([[1.0], [1.0]]), rtol=1e-10)


def test_the_file_at_fault_is_named(tmp_path: Path) -> None:
    urdf, loops, poses = four_bar(tmp_path, hinge="revolute"), loop_file(tmp_path), home(tmp_path)
    files = {"urdf": urdf, "loops": loops, "srdf": poses}
    for which in files:
        missing = tmp_path / f"no.{which}"
        with pytest.raises(InvalidRobotFile) as caught:
            read_robot(**(files | {which: missing}))
        assert caught.value.path == missing
    for bad, reason in (
        ({"elbow": "FIXED"}, "no joint 'elbow'"),
        ({"top": "FIXED"}, "no joint 'top'"),
    ):
        with pytest.raises(InvalidRobotFile, match=reason) as caught:
            read_robot(urdf, loop_file(tmp_path, **bad))
        assert caught.value.path == loops


@pytest.mark.parametrize("name", ["psp3", "five_bar"])
def test_our_own_robots_read_without_a_warning(name: str, caplog: pytest.LogCaptureFixture) -> None:
    parts = read_robot(*(ROBOT_FILES / f"{name}.{end}" for end in ("urdf", "yaml", "srdf")))
    assert parts.q0 is not None
    assert parts.visual_model.ngeoms > 0
    assert not caplog.records


def test_a_mimic_joint_follows_by_its_multiplier_and_offset(tmp_path: Path) -> None:
    """A pendulum whose second joint turns by −2 times the first, and 0.1.

    Its motor feels the tree's forces by the chain rule, f1 − 2 f2.
    """
    body = '<inertial><origin xyz="0.1 0 0"/><mass value="1"/>' + (
        '<inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>'
    )
    urdf, loops = tmp_path / "gears.urdf", tmp_path / "gears.yaml"
    for kind in ("revolute", "continuous"):
        limit = '<limit effort="1" velocity="1"/>'
        urdf.write_text(
            f"""<robot name="gears"><link name="base"/><link name="a">{body}</link>
            <link name="b">{body}</link>
            <joint name="one" type="{kind}"><parent link="base"/><child link="a"/>
             <axis xyz="0 1 0"/>{limit}</joint>
            <joint name="two" type="{kind}"><parent link="a"/><child link="b"/>
             <origin xyz="0.2 0 0"/><axis xyz="0 1 0"/>{limit}
             <mimic joint="one" multiplier="-2" offset="0.1"/></joint></robot>"""
        )
        loops.write_text("closed_loop: []\ntype: []\nname_mot: [one]\n")
        robot = ClosedLoopRobot.from_urdf(urdf, loops)
        q = robot.configuration([0.3])
        assert_allclose(q, [0.3, 0.1 - 0.6], rtol=0, atol=1e-15)
        v, a = np.array([0.5, -1.0]), np.array([0.7, -1.4])
        tree = pin.rnea(robot.model, robot.model.createData(), q, v, a)
        assert_allclose(
            robot.inverse_dynamics([0.3], [0.5], [0.7]), [tree[0] - 2.0 * tree[1]], rtol=1e-13
        )


def gears(directory: Path, *mimics: str, kinds: str = "rrrr") -> Path:
    """Write a chain of pendulums, each with what it mimics, if anything."""
    words = {"r": "revolute", "c": "continuous", "f": "fixed"}
    names = ["base", *(f"l{k}" for k in range(len(mimics)))]
    joints = [
        joint(f"j{k}", names[k], names[k + 1], words[kinds[k]], "0.3 0 0", "0 1 0")
        .replace("lower='-3' upper='3'", "lower='-99' upper='99'")
        .replace("</joint>", f"{mimic}</joint>")
        for k, mimic in enumerate(mimics)
    ]
    return written(directory / "gears.urdf", *map(link, names), *joints)


def test_a_joint_mimics_one_that_mimics_another(tmp_path: Path) -> None:
    """Twice the second, which is −0.5 + 3 times the first; and forces by the chain rule."""
    urdf = gears(
        tmp_path,
        "",
        "<mimic joint='j0' multiplier='3' offset='-0.5'/>",
        "<mimic joint='j1' multiplier='2'/>",
    )
    robot = ClosedLoopRobot.from_urdf(urdf)
    assert robot.actuated == ("j0",)
    q = np.array([0.2, 0.1, 0.2])
    assert_allclose(robot.configuration([0.2]), q, rtol=0, atol=1e-14)
    ratio = np.array([1.0, 3.0, 6.0])
    tree = pin.rnea(robot.model, robot.model.createData(), q, 0.4 * ratio, -0.7 * ratio)
    forces = robot.inverse_dynamics([0.2], [0.4], [-0.7])
    assert_allclose(forces, [ratio @ tree], rtol=1e-12)


def test_a_motor_may_drive_the_joint_that_mimics(tmp_path: Path) -> None:
    """Where the follower is the coordinate, the leader turns by the reciprocal."""
    urdf = gears(tmp_path, "", "<mimic joint='j0' multiplier='-2' offset='0.1'/>", kinds="cc")
    robot = ClosedLoopRobot.from_urdf(urdf, actuated=["j1"])
    assert robot.coordinates == ("j1",)
    assert_allclose(robot.configuration([0.5]), [-0.2, 0.5], rtol=0, atol=1e-14)
    both = ClosedLoopRobot.from_urdf(urdf, actuated=["j0", "j1"])
    assert both.coordinates == ("j0",)
    assert both.mobility.over_actuation == 1


@pytest.mark.parametrize(
    ("mimics", "reason"),
    [
        (("<mimic joint='j1'/>", "<mimic joint='j0'/>"), "in a circle: j0, j1"),
        (("<mimic joint='j0'/>", ""), "in a circle: j0"),
        (("<mimic joint='j7'/>", ""), "'j0' mimics 'j7', which is not in the file"),
        (("<mimic/>", ""), "<mimic> lacks joint"),
        (("<mimic joint='j1'/><mimic joint='j1'/>", ""), "more than one <mimic>"),
    ],
)
def test_joints_that_mimic_in_vain_are_refused(
    tmp_path: Path, mimics: tuple[str, ...], reason: str
) -> None:
    with pytest.raises(InvalidRobotFile, match=reason):
        ClosedLoopRobot.from_urdf(gears(tmp_path, *mimics))


def test_a_joint_that_mimics_inside_a_loop_takes_a_freedom(tmp_path: Path) -> None:
    """A five-bar whose second crank turns by −1 times the first is a linkage of one freedom."""
    text = (ROBOT_FILES / "five_bar.urdf").read_text()
    start = text.index('name="leg2_shoulder"')
    end = text.index("</joint>", start)
    urdf = tmp_path / "geared.urdf"
    urdf.write_text(text[:end] + '<mimic joint="leg1_shoulder" multiplier="-1"/>' + text[end:])
    files = (ROBOT_FILES / f"five_bar.{ending}" for ending in ("yaml", "srdf"))
    free = ClosedLoopRobot.from_urdf(ROBOT_FILES / "five_bar.urdf", *files)
    geared = ClosedLoopRobot.from_urdf(
        urdf, ROBOT_FILES / "five_bar.yaml", actuated=["leg1_shoulder"]
    )
    assert geared.mobility.degrees_of_freedom == 1
    angle, speed, acceleration = geared.reference + 0.05, np.array([0.4]), np.array([0.9])
    q = geared.configuration(angle)
    index = [free.model.joints[free.model.getJointId(name)].idx_q for name in free.actuated]
    assert_allclose(q[index[1]], -q[index[0]], rtol=0, atol=1e-12)
    ratio = np.array([1.0, -1.0])
    guess = free.configuration(q[index], guess=q)
    forces = free.inverse_dynamics(q[index], ratio * speed, ratio * acceleration, guess=guess)
    # The gear hands on what the second motor would do; loops are closed to 1e-13.
    assert_allclose(
        geared.inverse_dynamics(angle, speed, acceleration), [ratio @ forces], rtol=1e-10
    )


def test_a_urdf_alone_is_a_tree_whose_joints_are_motors(tmp_path: Path) -> None:
    """All of Pinocchio's dynamics of the tree; 1e-13 relative, sums in another order."""
    urdf = gears(tmp_path, "", "", "", "", kinds="rcfr")
    robot = ClosedLoopRobot.from_urdf(urdf)
    assert robot.actuated == robot.coordinates == ("j0", "j1", "j3")
    q, v, a = np.array([0.3, 7.0, -0.4]), np.array([1.0, -2.0, 0.5]), np.array([0.2, 0.7, -3.0])
    data = robot.model.createData()
    tau = pin.rnea(robot.model, data, q, v, a)
    assert_allclose(robot.inverse_dynamics(q, v, a), tau, rtol=1e-13)
    assert_allclose(robot.forward_dynamics(q, v, tau), a, rtol=1e-12)
    mass = np.triu(pin.crba(robot.model, data, q))
    assert_allclose(np.triu(robot.mass_matrix(q)), mass, rtol=1e-13)
    for name in ("noc", "pinocchio"):
        theirs = robot.dynamics(name).equation_of_motion(q, v)
        for ours, other in zip(robot.equation_of_motion(q, v), theirs, strict=True):
            assert_allclose(ours, other, rtol=0, atol=1e-12)
    two = ClosedLoopRobot.from_urdf(urdf, actuated=["j3", "j0"])
    assert two.coordinates == ("j3", "j0")
    assert [one.joint for one in two.locked] == ["j1"]


def test_loops_are_given_in_python_without_a_loop_file(tmp_path: Path) -> None:
    urdf, poses = four_bar(tmp_path, hinge="revolute"), home(tmp_path)
    expected = ClosedLoopRobot.from_urdf(urdf, loop_file(tmp_path), poses)
    robot = ClosedLoopRobot.from_urdf(
        urdf, srdf=poses, actuated=["crank"], closures=[("end", "other", "6d")]
    )
    for ours, theirs in zip(
        robot.equation_of_motion([1.3], [2.0]),
        expected.equation_of_motion([1.3], [2.0]),
        strict=True,
    ):
        assert_allclose(ours, theirs, rtol=1e-12, atol=1e-12)


def test_a_urdf_in_which_nothing_moves_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InvalidRobotFile, match="has no joint that can move"):
        ClosedLoopRobot.from_urdf(written(tmp_path / "r.urdf", link("base")))


def test_a_mimic_joint_of_no_joint_is_refused(tmp_path: Path) -> None:
    urdf, loops = tmp_path / "gears.urdf", tmp_path / "gears.yaml"
    urdf.write_text(
        """<robot name="gears"><link name="base"/><link name="a"/>
        <joint name="one" type="revolute"><parent link="base"/><child link="a"/>
         <axis xyz="0 1 0"/><limit effort="1" velocity="1"/>
         <mimic joint="three"/></joint></robot>"""
    )
    loops.write_text("closed_loop: []\ntype: []\nname_mot: [one]\n")
    with pytest.raises(InvalidRobotFile, match="three"):
        ClosedLoopRobot.from_urdf(urdf, loops)
