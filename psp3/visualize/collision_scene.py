"""A scene of the two links that are nearest to each other.

It shows their shapes in color, and the shortest line between them.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Self

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from psp3.checks import Array
from psp3.collisions.model import CollisionModel, Nearest, collision_model
from psp3.robots.closed_loop_robot import ClosedLoopRobot
from psp3.visualize.animation import Frames
from psp3.visualize.scene import FIELD_OF_VIEW, VIEW_DIRECTION, Scene
from psp3.visualize.shapes import Flat, Tube, geometry, rgb

LINK_COLORS = "#c2255c", "#0b7285"
"""Colors of the first and the second link, which other scenes use for the actual and the desired
path."""

POINT_COLOR = "#f08c00"

POINT_RADIUS, WAY_RADIUS = 0.004, 0.0015
"""Radii of the nearest points, and of the tube between them [m]."""

SURROUNDINGS = 0.07
"""Distance around the nearest points, on every side, that is in the close view [m]."""

NODE = "robots/0/nearest"


class CollisionScene(Scene):
    """A robot on a floor, with the two links that are nearest to each other.

    The collision shapes of their bodies replace the visual shapes, in a different color for each
    body.

    Parameters
    ----------
    robot : ClosedLoopRobot
        What to show.
    model : CollisionModel, optional
        Its shapes; by default those of the file that it was loaded from, see
        :func:`psp3.collisions.model.collision_model`.
    """

    def __init__(self, robot: ClosedLoopRobot, model: CollisionModel | None = None) -> None:
        super().__init__(robot)
        self.model = collision_model(robot) if model is None else model
        self._hidden: list[str] = []

    def show_nearest(self, positions: ArrayLike) -> Self:
        """Show the robot at rest with its two nearest links.

        Parameters
        ----------
        positions : (n,) array_like
            Positions of the actuated joints [m or rad].

        Returns
        -------
        CollisionScene
            The scene itself.

        Raises
        ------
        InvalidArray, ClosureFailed, JointLimitExceeded, UnreachablePose
            See :meth:`psp3.collisions.model.CollisionModel.nearest`.
        """
        nearest = self.model.nearest(positions)
        self.show(positions)
        configuration = self.robot.configuration(np.reshape(positions, -1))
        for number, (link, color) in enumerate(zip(nearest.links, LINK_COLORS, strict=True)):
            # A body that stands on the floor keeps its visual shapes, because in one color it would
            # be hard to recognize.
            if self.model.joint_of(link):
                self._draw_body(f"{NODE}/{number}", link, color, configuration)
        seen_through = Flat(POINT_COLOR, opacity=0.95)
        seen_through.properties["depthTest"] = False
        for number, point in enumerate(nearest.points):
            node = self._viewer[f"{NODE}/point{number}"]
            node.set_object(geometry.Sphere(POINT_RADIUS), seen_through)
            node.set_transform(pin.SE3(np.eye(3), point).homogeneous)
        if np.linalg.norm(nearest.points[1] - nearest.points[0]) > POINT_RADIUS:
            self._viewer[f"{NODE}/way"].set_object(Tube(nearest.points, WAY_RADIUS), seen_through)
        self._set_stage(nearest)
        return self

    def _set_stage(self, nearest: Nearest) -> None:
        """Set a full view of the robot and a close view of the points, and add the legend."""
        corners = self._performers[0].body.corners(self.robot.q0)
        box = np.array([corners.min(axis=0), corners.max(axis=0)])
        cube = np.array(
            [nearest.points.min(axis=0), nearest.points.max(axis=0)]
        ) + SURROUNDINGS * np.array([[-1.0], [1.0]])
        apart = "apart" if nearest.distance >= 0.0 else "in each other"
        entries = [
            (link, color, "area")
            for link, color in zip(nearest.links, LINK_COLORS, strict=True)
            if self.model.joint_of(link)
        ]
        entries.append(
            (f"nearest points, {1e3 * abs(nearest.distance):.1f} mm {apart}", POINT_COLOR, "line")
        )
        self._commands.add(
            {
                "type": "stage",
                "points": _corners(box),
                "nearby": _corners(cube),
                "direction": VIEW_DIRECTION,
                "field_of_view": FIELD_OF_VIEW,
                "texts": [],
                "legend": [
                    {"text": text, "color": color, "mark": mark} for text, color, mark in entries
                ],
            }
        )
        # The next content must set the stage again.
        self._cast = None

    def _draw_body(self, node: str, link: str, color: str, configuration: Array) -> None:
        """Draw the collision shapes of the body that a link belongs to.

        They replace the body's visual shapes.
        """
        # Imported after psp3.visualize.shapes, which imports MeshCat without its warning.
        from psp3.visualize.robot_visualizer import RobotVisualizer

        body, model = self._performers[0].body, self.robot.model
        place = body.joint_node(self.model.joint_of(link))
        shapes = pin.GeometryModel()
        for shape in self.model.shapes.geometryObjects:
            if body.joint_node(shape.parentJoint) == place:
                colored = shape.copy()
                colored.meshColor = np.array([*rgb(color), 1.0])
                shapes.addGeometryObject(colored)
        alone = ClosedLoopRobot(
            model, self.robot.constraint_models, self.robot.actuated, self.robot.q0, shapes
        )
        RobotVisualizer(alone, self._viewer, node).display(configuration)
        self._hidden.append(place)
        self._viewer[place].set_property("visible", False)

    def _perform(self, frames: Mapping[str, Frames]) -> None:
        self._viewer[NODE].delete()
        for node in self._hidden:
            self._viewer[node].set_property("visible", True)
        self._hidden = []
        super()._perform(frames)


def _corners(box: Array) -> Array:
    """Return the corners (8, 3) of a box given by its lowest and highest coordinates (2, 3)."""
    return np.stack(np.meshgrid(*box.T), axis=-1).reshape(-1, 3).round(3)
