"""Universal and cylindrical joints in loops: of URDF, of loop files and of MJCF.

The same closed linkage comes in two ways, and both are compared with MuJoCo's numbers projected on
the null space of its equalities.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

import psp3
from tests.helpers import Array
from tests.mujoco_null_space import NullSpace, body, document, hinge, inertial, motors

UNIVERSAL = hinge("bend_X", "1 0 0") + hinge("bend_Y", "0 1 0")
CYLINDER = '<joint name="slide" type="slide" axis="0 0 1"/>' + hinge("turn", "0 0 1")


def linkage(second: str) -> str:
    """Return a crank, a rod on a joint of several freedoms, and a ball at a slider."""
    rod = body("rod", ".2 0 0", second, "", inertial(".1 .02 .15", 0.8))
    return document(
        body("crank", "0 0 0", hinge("crank", ".2 .1 1"), rod)
        + body("block", ".25 .1 .4", '<joint name="block" type="slide" axis="1 .2 .1"/>'),
        '<connect body1="rod" body2="block" anchor=".05 .1 .4"/>',
        motors("crank"),
    )


MECHANISMS = {
    # With their coordinates.
    "universal": (linkage(UNIVERSAL), ("crank",)),
    "cylindrical": (linkage(CYLINDER + hinge("bend_X", "1 0 0")), ("crank", "turn")),
    "cylindrical and universal": (linkage(CYLINDER + UNIVERSAL), ("crank", "turn", "bend_X")),
}


@pytest.mark.parametrize("name", list(MECHANISMS))
def test_composed_joints_move_as_those_of_mujoco(name: str, tmp_path: Path) -> None:
    """500 states to 1e-8, and the other route to 1e-10."""
    text, coordinates = MECHANISMS[name]
    file = tmp_path / "robot.xml"
    file.write_text(text, encoding="utf-8")
    robot = psp3.ClosedLoopRobot.from_mjcf(file, free="keep")
    engine, rng = NullSpace(text, robot.model), np.random.default_rng(0)
    n, none = len(robot.coordinates_v), np.zeros((0, robot.model.nv))
    assert n == robot.mobility.degrees_of_freedom
    assert robot.coordinates == coordinates
    positions = robot.reference + rng.uniform(-0.05, 0.05, (500, n))
    speeds, forces = rng.uniform(-1.0, 1.0, (2, 500, n))
    found = robot.forward_dynamics(positions, speeds, forces)
    for k in range(500):
        q, v = robot.configuration(positions[k]), robot.velocity(positions[k], speeds[k])
        at_joints = np.zeros(robot.model.nv)
        at_joints[robot.coordinates_v] = forces[k]
        expected, gap, opening = engine.accelerations(q, v, at_joints, none, np.zeros(0))
        assert gap < 1e-11
        assert opening < 1e-11
        size = np.abs(expected).max()
        assert np.abs(found[k] - expected[robot.coordinates_v]).max() < 1e-8 * size
    other = robot.dynamics("pinocchio").forward_dynamics(positions, speeds, forces)
    assert (np.abs(other - found).max(axis=1) < 1e-10 * np.abs(found).max(axis=1)).all()


def link(name: str, joint: str, parent: str, place: str, axis: str, kind: str = "revolute") -> str:
    """Return a joint of a URDF and its link, with the inertia of the MJCF's rod or the others."""
    is_rod = name == "rod"
    com, mass = (".1 .02 .15", 0.8) if is_rod else (".1 0 .02", 1.0)
    return f"""<joint name="{joint}" type="{kind}"><parent link="{parent}"/><child link="{name}"/>
      <origin xyz="{place}"/><axis xyz="{axis}"/>
      <limit lower="-3" upper="3" effort="9" velocity="9"/></joint>
    <link name="{name}"><inertial><origin xyz="{com}"/><mass value="{mass}"/>
      <inertia ixx=".01" iyy=".012" izz=".014" ixy="0" ixz="0" iyz="0"/></inertial></link>"""


def test_a_universal_joint_of_a_loop_file_is_the_composed_one(tmp_path: Path) -> None:
    """``UJOINT_XY`` makes two revolutes of one: the same linkage as the MJCF's, to 1e-10."""
    tips = "".join(
        f'''<joint name="{name}_fix" type="fixed"><parent link="{parent}"/>
        <child link="{name}"/><origin xyz="{place}"/></joint><link name="{name}"/>'''
        for name, parent, place in (
            ("rod_tip", "rod", ".05 .1 .4"),
            ("block_tip", "block", "0 0 0"),
        )
    )
    axes = (np.array([0.2, 0.1, 1.0]), np.array([1.0, 0.2, 0.1]))
    crank, block = (" ".join(map(str, axis / np.linalg.norm(axis))) for axis in axes)
    urdf = (
        '<robot name="linkage"><link name="base"/>'
        + link("crank", "crank", "base", "0 0 0", crank)
        + link("rod", "bend", "crank", ".2 0 0", "1 0 0")
        + link("block", "block", "base", ".25 .1 .4", block, "prismatic")
        + tips
        + "</robot>"
    )
    (tmp_path / "robot.urdf").write_text(urdf, encoding="utf-8")
    (tmp_path / "robot.yaml").write_text(
        "closed_loop: [[rod_tip, block_tip]]\ntype: [3d]\nname_mot: [crank]\n"
        "joint_name: [bend]\njoint_type: [UJOINT_XY]\n",
        encoding="utf-8",
    )
    robot = psp3.ClosedLoopRobot.from_urdf(tmp_path / "robot.urdf", tmp_path / "robot.yaml")
    robot.model.gravity = pin.Motion(np.array([0.0, -3.0, -9.0]), np.zeros(3))
    (tmp_path / "robot.xml").write_text(MECHANISMS["universal"][0], encoding="utf-8")
    composed = psp3.ClosedLoopRobot.from_mjcf(tmp_path / "robot.xml")
    rng = np.random.default_rng(0)
    assert robot.coordinates == composed.coordinates == ("crank",)
    states: Array = rng.uniform(-0.1, 0.1, (3, 100, 1))
    ours, theirs = (one.inverse_dynamics(*states) for one in (robot, composed))
    np.testing.assert_allclose(ours, theirs, rtol=0.0, atol=1e-10 * np.abs(theirs).max())
