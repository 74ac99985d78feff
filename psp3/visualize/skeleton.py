"""Bars and balls for a robot whose file has no shapes to draw."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import coal
import numpy as np
import pinocchio as pin

from psp3.checks import Array
from psp3.closure.structure import robot_size
from psp3.robots.robot import Robot

THICKNESS = 0.012
"""Radius of the bars, as a share of the robot's size."""

BAR_COLOR, JOINT_COLOR = np.array([0.62, 0.65, 0.69, 1.0]), np.array([0.0, 0.447, 0.698, 1.0])


def drawn_shapes(robot: Robot) -> pin.GeometryModel:
    """Return the shapes of a robot; with a skeleton if none of them moves.

    The skeleton has a ball at each joint, and in each body a bar from its joint to every joint and
    every end of a loop that the body carries.

    Parameters
    ----------
    robot : Robot
        The robot.

    Returns
    -------
    pinocchio.GeometryModel
        The shapes, each placed in the axes of the joint that carries it.
    """
    if any(shape.parentJoint for shape in robot.visual_model.geometryObjects):
        return robot.visual_model
    shapes = robot.visual_model.copy()
    radius = THICKNESS * robot_size(robot.model, robot.q0)
    for joint in range(1, robot.model.njoints):
        _add(shapes, "joint", joint, pin.SE3.Identity(), coal.Sphere(2.0 * radius), JOINT_COLOR)
    for joint, point in _points(robot):
        length = float(np.linalg.norm(point))
        if length > radius:
            along = pin.Quaternion.FromTwoVectors(np.array([0.0, 0.0, 1.0]), point).matrix()
            middle = pin.SE3(along, 0.5 * point)
            _add(shapes, "bar", joint, middle, coal.Cylinder(radius, length), BAR_COLOR)
    return shapes


def _points(robot: Robot) -> Iterator[tuple[int, Array]]:
    """Yield what each body carries: joints and ends of loops, with their places in its axes."""
    parents = list(robot.model.parents)
    for joint in range(1, robot.model.njoints):
        yield parents[joint], robot.model.jointPlacements[joint].translation
    for loop in (*robot.constraint_models, *getattr(robot, "equations", ())):
        # A coupling joins no points.
        if hasattr(loop, "joint1_placement"):
            yield loop.joint1_id, loop.joint1_placement.translation
            yield loop.joint2_id, loop.joint2_placement.translation


def _add(
    shapes: pin.GeometryModel, kind: str, joint: int, place: pin.SE3, form: Any, color: Array
) -> None:
    shape = pin.GeometryObject(f"{kind} {shapes.ngeoms}", joint, place, form)
    shape.meshColor = color
    shapes.addGeometryObject(shape)
