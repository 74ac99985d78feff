"""Pinocchio's visualizer for a robot with loops.

Bodies that a loop joins share a node, and a ghost is inside its robot.
"""

from __future__ import annotations

import json

import coal
import numpy as np
import pinocchio as pin
import pytest

import psp3
from psp3.description.parts import ROBOTS, THESIS_ROBOTS
from psp3.visualize import Scene
from psp3.visualize.commands import DrawingCommands
from psp3.visualize.robot_visualizer import GHOST_MARGIN, RobotVisualizer
from psp3.visualize.shapes import meshcat

ROBOT = psp3.load()
HEIGHTS = ROBOT.inverse_kinematics(height=0.05, tilt=np.radians(25.0), azimuth=1.0)


def drawn(
    ghost: str | None = None, robot: psp3.ClosedLoopRobot = ROBOT, positions: np.ndarray = HEIGHTS
) -> tuple[RobotVisualizer, dict[str, np.ndarray]]:
    commands = DrawingCommands()
    visualizer = RobotVisualizer(robot, meshcat.Visualizer(window=commands), "robot", ghost)
    visualizer.display(robot.configuration(positions))
    sent = json.loads(commands.as_json())
    return visualizer, {
        one["path"]: np.reshape(one["matrix"], (4, 4)).T
        for one in sent
        if one["type"] == "set_transform"
    }


@pytest.mark.parametrize("ghost", [None, "#0b7285"])
def test_every_shape_is_where_pinocchio_puts_it(ghost: str | None) -> None:
    """Node of the body times shape in the body, against Pinocchio's own placements of all shapes.

    The loops close to 1e-12.
    """
    visualizer, placements = drawn(ghost)
    data = visualizer.visual_model.createData()
    pin.updateGeometryPlacements(
        ROBOT.model,
        ROBOT.model.createData(),
        visualizer.visual_model,
        data,
        ROBOT.configuration(HEIGHTS),
    )
    assert visualizer.visual_model.ngeoms > 30
    for shape, expected in zip(visualizer.visual_model.geometryObjects, data.oMg, strict=True):
        body = f"/meshcat/{visualizer.joint_node(shape.parentJoint)}"
        np.testing.assert_allclose(
            placements[body] @ placements[f"{body}/{shape.name}"], expected.homogeneous, atol=1e-9
        )


@pytest.mark.parametrize("name", ROBOTS[len(THESIS_ROBOTS) :])
def test_every_shape_of_what_people_build_is_there(name: str) -> None:
    """Balls, floating bases and the bodies of an MJCF too, at home."""
    robot = psp3.load(name)
    visualizer, placements = drawn(robot=robot, positions=robot.reference)
    data = visualizer.visual_model.createData()
    pin.updateGeometryPlacements(
        robot.model, robot.model.createData(), visualizer.visual_model, data, robot.q0
    )
    assert visualizer.visual_model.ngeoms == robot.visual_model.ngeoms > 20
    for shape, expected in zip(visualizer.visual_model.geometryObjects, data.oMg, strict=True):
        body = f"/meshcat/{visualizer.joint_node(shape.parentJoint)}"
        np.testing.assert_allclose(
            placements[body] @ placements[f"{body}/{shape.name}"], expected.homogeneous, atol=1e-9
        )
    assert "MeshCat" in Scene(robot).show(robot.reference).html()


def test_the_thirds_of_the_star_are_one_body() -> None:
    """Base, three nuts, three balls, one star."""
    visualizer, _ = drawn()
    assert [ROBOT.model.names[joint] for joint in visualizer.joints] == [
        "universe",
        "a1",
        "lambda1",
        "b1",
        "a2",
        "lambda2",
        "a3",
        "lambda3",
    ]


def test_a_ghost_is_the_moving_parts_thinner_all_around() -> None:
    ghost, _ = drawn("#0b7285")
    whole = {shape.name: shape for shape in ROBOT.visual_model.geometryObjects}
    assert {
        ROBOT.model.names[shape.parentJoint][:-1] for shape in ghost.visual_model.geometryObjects
    } == {"a", "lambda", "b"}
    for shape in ghost.visual_model.geometryObjects:
        for form in (shape.geometry, whole[shape.name].geometry):
            form.computeLocalAABB()
        assert type(shape.geometry) in (coal.Box, coal.Cylinder, coal.Sphere)
        np.testing.assert_allclose(
            whole[shape.name].geometry.aabb_local.max_ - shape.geometry.aabb_local.max_,
            GHOST_MARGIN,
            atol=1e-12,
        )


def test_rotations_take_the_short_way_between_frames() -> None:
    """Along a turn of the helix no two successive quaternions are more than a right angle apart."""
    visualizer, _ = drawn()
    desired = psp3.trajectories.Helix(robot=ROBOT)(np.linspace(0.0, 2.0, 61))
    clips = visualizer.clips(ROBOT.configuration(desired.heights), np.linspace(0.0, 2.0, 61))
    rotations = [
        track for one in clips for track in one["clip"]["tracks"] if track["type"] == "quaternion"
    ]
    assert len(rotations) == 4
    for track in rotations:
        q = np.reshape(track["values"], (-1, 4))
        assert ((q[1:] * q[:-1]).sum(axis=1) > 0.7).all()
