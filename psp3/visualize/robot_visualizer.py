"""Pinocchio's MeshCat visualizer for robots with closed loops, and its translucent ghost."""

from __future__ import annotations

from typing import Any

import coal
import numpy as np
import pinocchio as pin
from pinocchio.visualize import MeshcatVisualizer

from psp3.checks import Array
from psp3.robots.robot import Robot
from psp3.visualize.animation import clip
from psp3.visualize.shapes import Glass, Satin, meshcat
from psp3.visualize.skeleton import drawn_shapes

GHOST_OPACITY = 0.4

GHOST_MARGIN = 0.0015
"""The ghost is thinner than the robot by this margin on all sides [m], so it is hidden where both
coincide, without flicker.
"""

MARK_LENGTH = 0.005
"""Cylinders with a smaller half length are marks on other shapes [m]."""

_PRIMITIVES = coal.Box | coal.Cylinder | coal.Sphere


class RobotVisualizer(MeshcatVisualizer):  # type: ignore[misc]
    """Pinocchio's visualizer with one node for each rigid body.

    A motion then needs one track per body instead of one per shape.

    Bodies that a loop joins rigidly, such as the thirds of the star, share a node.

    Parameters
    ----------
    robot : Robot
        What to show.
    viewer : meshcat.Visualizer
        Viewer to draw in.
    node : str
        Path of the robot in the scene.
    ghost : str, optional
        Show the moving parts only, translucent and in this color, ``#rrggbb``.
    """

    def __init__(
        self,
        robot: Robot,
        viewer: meshcat.Visualizer,
        node: str,
        ghost: str | None = None,
    ) -> None:
        self._ghost = None if ghost is None else Glass(ghost, GHOST_OPACITY)
        self._rigid = _rigidly_joined(robot)
        shapes = drawn_shapes(robot)
        super().__init__(robot.model, visual_model=shapes if ghost is None else _thinned(shapes))
        self.initViewer(viewer)
        self.loadViewerModel(node)

    def joint_node(self, joint: int) -> str:
        """Return the path of the body that a joint carries."""
        return (
            f"{self.viewerVisualGroupName}/{self.model.names[self._rigid.get(joint, (joint,))[0]]}"
        )

    @property
    def joints(self) -> list[int]:
        """Joints that carry a body of the scene."""
        carrying = {shape.parentJoint for shape in self.visual_model.geometryObjects}
        return sorted({self._rigid.get(joint, (joint,))[0] for joint in carrying})

    def getViewerNodeName(self, geometry_object: Any, geometry_type: Any) -> str:
        """Return the path of a shape: below its body."""
        return f"{self.joint_node(geometry_object.parentJoint)}/{geometry_object.name}"

    def loadViewerGeometryObject(
        self, geometry_object: Any, geometry_type: Any, color: Any = None
    ) -> None:
        """Draw a shape in its finish."""
        node = self.viewer[self.getViewerNodeName(geometry_object, geometry_type)]
        if isinstance(geometry_object.geometry, _PRIMITIVES):
            node.set_object(
                self.loadPrimitive(geometry_object), self._ghost or Satin(geometry_object.meshColor)
            )
        else:
            super().loadViewerGeometryObject(geometry_object, geometry_type, color)
        joint = geometry_object.parentJoint
        in_body = (
            self._rigid[joint][1] * geometry_object.placement
            if joint in self._rigid
            else geometry_object.placement
        )
        node.set_transform(in_body.homogeneous @ np.diag([*geometry_object.meshScale, 1.0]))

    def updatePlacements(self, geometry_type: Any) -> None:
        """Move every body to the placement of its joint in the last forward kinematics."""
        for joint in self.joints:
            self.viewer[self.joint_node(joint)].set_transform(self.data.oMi[joint].homogeneous)

    def clips(self, configurations: Array, seconds: Array) -> list[dict[str, Any]]:
        """Return the animations of all bodies through configurations of shape (n, nq)."""
        poses: dict[int, list[Array]] = {joint: [] for joint in self.joints}
        for q in configurations:
            pin.forwardKinematics(self.model, self.data, q)
            for joint, of_joint in poses.items():
                of_joint.append(pin.SE3ToXYZQUAT(self.data.oMi[joint]))
        clips = []
        for joint, of_joint in poses.items():
            pose = np.array(of_joint)
            # q and −q are the same rotation; the sign is chosen so that the browser interpolates
            # the shorter way between frames.
            pose[:, 3:] *= np.cumprod(
                np.append(
                    1.0, np.where((pose[1:, 3:] * pose[:-1, 3:]).sum(axis=1) < 0.0, -1.0, 1.0)
                )
            )[:, None]
            path = self.viewer[self.joint_node(joint)].path.lower()
            clips.append(clip(path, seconds, {"position": pose[:, :3], "quaternion": pose[:, 3:]}))
        return clips

    def corners(self, q: Array, moving_only: bool = False) -> Array:
        """Return the corners of the boxes around all shapes, (n, 3) [m]."""
        pin.forwardKinematics(self.model, self.data, q)
        pin.updateGeometryPlacements(self.model, self.data, self.visual_model, self.visual_data)
        corners = []
        for shape, placement in zip(
            self.visual_model.geometryObjects, self.visual_data.oMg, strict=True
        ):
            if moving_only and shape.parentJoint == 0:
                continue
            shape.geometry.computeLocalAABB()
            box = (
                np.array([shape.geometry.aabb_local.min_, shape.geometry.aabb_local.max_])
                * shape.meshScale
            )
            grid = np.stack(np.meshgrid(*box.T), axis=-1).reshape(-1, 3)
            corners.append(grid @ placement.rotation.T + placement.translation)
        return np.concatenate(corners) if corners else np.zeros((0, 3))


def _rigidly_joined(robot: Robot) -> dict[int, tuple[int, pin.SE3]]:
    """Return the other joint of each 6D loop and the placement in it.

    The entries are the joints whose body such a loop joins to another body.
    """
    joined: dict[int, tuple[int, pin.SE3]] = {}
    for loop in robot.constraint_models:
        if (
            loop.type == pin.ContactType.CONTACT_6D
            and loop.joint2_id not in joined
            and loop.joint1_id not in joined
        ):
            joined[loop.joint2_id] = (
                loop.joint1_id,
                loop.joint1_placement * loop.joint2_placement.inverse(),
            )
    # A body that others are joined to keeps its own node, because it must not be joined to another
    # itself.
    carriers = {carrier for carrier, _ in joined.values()}
    return {joint: entry for joint, entry in joined.items() if joint not in carriers}


def _thinned(visual_model: pin.GeometryModel) -> pin.GeometryModel:
    """Return the moving shapes, each thinner by the margin on all sides."""
    thin = pin.GeometryModel()
    for shape in visual_model.geometryObjects:
        moving, form = shape.copy(), shape.geometry
        # Marks on the arms are left out: they would be hidden inside thinner arms, or show as rings
        # through translucent ones.
        if shape.parentJoint == 0 or (
            isinstance(form, coal.Cylinder) and form.halfLength < MARK_LENGTH
        ):
            continue
        if isinstance(form, coal.Box):
            moving.geometry = coal.Box(*(2.0 * _inner(form.halfSide)))
        elif isinstance(form, coal.Cylinder):
            moving.geometry = coal.Cylinder(_inner(form.radius), 2.0 * _inner(form.halfLength))
        elif isinstance(form, coal.Sphere):
            moving.geometry = coal.Sphere(_inner(form.radius))
        thin.addGeometryObject(moving)
    return thin


def _inner(half: Any) -> Any:
    # At least half of it is left of what is thinner than the margin.
    return np.maximum(half - GHOST_MARGIN, 0.5 * half)
