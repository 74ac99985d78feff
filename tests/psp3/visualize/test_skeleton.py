"""Robots without shapes are drawn as bars between their joints, and balls at them."""

from __future__ import annotations

import copy

import coal
import numpy as np
import pinocchio as pin
import pytest

import psp3
from psp3.description.parts import ROBOTS
from psp3.visualize import Scene
from psp3.visualize.commands import DrawingCommands
from psp3.visualize.robot_visualizer import GHOST_MARGIN, RobotVisualizer
from psp3.visualize.shapes import meshcat
from psp3.visualize.skeleton import BAR_COLOR, drawn_shapes
from tests.helpers import Array


def without_shapes(name: str, fixed: bool = False) -> psp3.ClosedLoopRobot:
    """Return a shipped robot without shapes, or with one that does not move."""
    robot = copy.copy(psp3.load(name))
    robot.visual_model = pin.GeometryModel()
    if fixed:
        box = pin.GeometryObject("floor", 0, pin.SE3.Identity(), coal.Box(1.0, 1.0, 0.01))
        robot.visual_model.addGeometryObject(box)
    return robot


def ends_of_bars(robot: psp3.ClosedLoopRobot, q: Array) -> Array:
    """Return both ends of all bars in base axes, (n, 2, 3)."""
    model, shapes = robot.model, drawn_shapes(robot)
    data, placed = model.createData(), shapes.createData()
    pin.forwardKinematics(model, data, q)
    pin.updateGeometryPlacements(model, data, shapes, placed)
    ends = []
    for shape, place in zip(shapes.geometryObjects, placed.oMg, strict=True):
        if isinstance(shape.geometry, coal.Cylinder):
            half = np.array([0.0, 0.0, shape.geometry.halfLength])
            ends.append([place.act(-half), place.act(half)])
    return np.array(ends)


@pytest.mark.parametrize("name", ROBOTS)
def test_bars_lead_from_joint_to_joint_and_meet_where_loops_close(name: str) -> None:
    """Each begins at a joint, or at the base, and ends at one or where another one ends.

    1e-5 m, as the loops of the Agile Eye contradict each other by a tenth of that.
    """
    robot = without_shapes(name)
    q = robot.configuration(robot.reference)
    data = robot.model.createData()
    pin.forwardKinematics(robot.model, data, q)
    joints = np.array([place.translation for place in data.oMi])
    starts, ends = ends_of_bars(robot, q).transpose(1, 0, 2)
    assert len(starts) >= len(robot.constraint_models)
    for point in starts:
        assert np.linalg.norm(joints - point, axis=1).min() < 1e-9
    for number, point in enumerate(ends):
        others = np.concatenate([joints, np.delete(ends, number, axis=0)])
        assert np.linalg.norm(others - point, axis=1).min() < 1e-5


def test_a_robot_with_shapes_is_drawn_as_it_is() -> None:
    robot = psp3.load("delta")
    assert drawn_shapes(robot) is robot.visual_model


@pytest.mark.parametrize("fixed", [False, True])
@pytest.mark.parametrize("name", ["five_bar", "delta", "hexa", "biped"])
def test_what_has_no_shapes_is_shown_and_moves(name: str, fixed: bool) -> None:
    robot = without_shapes(name, fixed)
    scene = Scene(robot).show(robot.reference)
    assert "joint" in scene._commands.as_json()
    motion = psp3.trajectories.Sway(robot=robot)
    assert "set_animation" in Scene(robot).animate(motion, 0.2)._commands.as_json()


def test_two_results_without_shapes_stand_side_by_side() -> None:
    robot = without_shapes("five_bar")
    sway = psp3.trajectories.Sway(robot=robot)
    found = psp3.simulate(robot, psp3.ComputedTorque(robot, 100.0, 20.0), sway, 0.1)
    drawn = Scene(robot).animate({"one": found, "other": found})._commands.as_json()
    assert "robots/1" in drawn


def test_the_ghost_of_something_thin_has_a_thickness() -> None:
    """Half of it is left, where the margin would take all."""
    robot = without_shapes("five_bar")
    shape = pin.GeometryObject(
        "thin", 1, pin.SE3.Identity(), coal.Box(0.1, 0.001, 0.5 * GHOST_MARGIN)
    )
    shape.meshColor = BAR_COLOR
    robot.visual_model.addGeometryObject(shape)
    ghost = RobotVisualizer(robot, meshcat.Visualizer(window=DrawingCommands()), "robot", "#0b7285")
    (thin,) = ghost.visual_model.geometryObjects
    half = np.array([0.05, 0.0005, 0.25 * GHOST_MARGIN])
    np.testing.assert_allclose(
        thin.geometry.halfSide, [0.05 - GHOST_MARGIN, 0.5 * half[1], 0.5 * half[2]], rtol=1e-12
    )
