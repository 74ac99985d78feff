"""The shapes of a robot, and the distances between them.

Pinocchio places the shapes, and coal measures the distances.

Distances between convex solids are computed with the algorithm of Gilbert, Johnson and Keerthi (A
fast procedure for computing the distance between complex objects in three-dimensional space, 1988),
and depths of overlap with the expanding polytope algorithm (van den Bergen, Proximity queries and
penetration depth computation on 3D game objects, 2001).
"""

from __future__ import annotations

import warnings
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike, NDArray

from fuzzy2.support.described import Described
from psp3.checks import Array, one_row
from psp3.collisions.pairs import pairs_to_check
from psp3.description.meshes import not_opened
from psp3.description.srdf import Exclusion, excluded_by_srdf
from psp3.description.urdf_plain import make_meshes_absolute, plain_urdf
from psp3.errors import InvalidRobotFile, InvalidValue, OverlappingShapes
from psp3.robots.robot import Robot

DISTANCE_TOLERANCE = 1e-8
"""Tolerance of distances [m]. With coal's default, 1e-6, the error between parallel cylinders is of
that size.
"""

LARGEST_DEVIATION = 1e-9
"""Largest deviation of a frame from its placement in the file of the shapes [m, and entries of a
rotation matrix].
"""


class Nearest(NamedTuple):
    """The two links that are nearest to each other in a pose.

    ``links`` are two names, ``distance`` is negative if they overlap [m], and ``points`` (2, 3) are
    the nearest points in base axes [m].
    """

    links: tuple[str, str]
    distance: float
    points: Array


class CollisionModel(Described):
    """The shapes of a robot, and the pairs of links that must not touch.

    Only one thread at a time may use an object, because it has a single ``data``.

    Parameters
    ----------
    robot : Robot
        The robot.
    shapes : pinocchio.GeometryModel
        Convex solids on its links; its own list of pairs is not used. For a robot without collision
        shapes, pass its ``visual_model``.
    excluded : iterable of (str, str, str), optional
        Pairs of links to leave out, with the reason, in addition to those of
        :mod:`psp3.collisions.pairs`.

    Raises
    ------
    InvalidValue
        If there is no shape, or one that is not convex.
    UnknownName
        If an excluded link does not exist.
    OverlappingShapes
        If two links already overlap at the reference pose, because such a pair cannot be checked
        along a motion.
    """

    def __init__(
        self, robot: Robot, shapes: Any, excluded: Iterable[tuple[str, str, str]] = ()
    ) -> None:
        objects = list(shapes.geometryObjects)
        if not objects:
            raise InvalidValue(
                "shapes",
                "a geometry model without shapes",
                "one with shapes: give the links <collision> elements",
            )
        for shape in objects:
            if (
                not hasattr(shape.geometry, "computeLocalAABB")
                or "BVH" in type(shape.geometry).__name__
            ):
                raise InvalidValue(
                    "shapes", f"{type(shape.geometry).__name__} {shape.name!r}", "convex solids"
                )
        self.robot = robot
        self.shapes = shapes.copy()
        self.shapes.removeAllCollisionPairs()
        self.links = tuple(_link(robot.model, shape) for shape in objects)
        """Link of each shape."""
        ends, self.excluded = pairs_to_check(
            robot,
            self.links,
            [shape.parentJoint for shape in objects],
            (Exclusion(*e) for e in excluded),
        )
        for end in ends:
            self.shapes.addCollisionPair(pin.CollisionPair(*end))
        number: dict[tuple[str, str], int] = {}
        self._pair = [
            number.setdefault((self.links[i], self.links[j]), len(number)) for i, j in ends
        ]
        self.pairs = tuple(number)
        """Pairs of links that are looked at, in the order of :meth:`distances`."""
        self._ends = np.array(ends, dtype=np.int64).reshape(-1, 2)
        self._boxes = _Boxes(objects)
        self._data, self._shape_data = robot.model.createData(), self.shapes.createData()
        for request in self._shape_data.distanceRequests:
            request.gjk_tolerance = request.epa_tolerance = DISTANCE_TOLERANCE
            with warnings.catch_warnings():
                # If the search started from the last result, the last digits of a distance would
                # depend on earlier calls. The name of the setting is old, but Pinocchio still uses
                # it.
                warnings.simplefilter("ignore", DeprecationWarning)
                request.enable_cached_gjk_guess = False
        self._refuse_overlaps()

    def _facts(self) -> dict[str, Any]:
        return {
            "robot": self.robot,
            "shapes": len(self.shapes.geometryObjects),
            "pairs": len(self.pairs),
        }

    def _refuse_overlaps(self) -> None:
        distances, _ = self._least(self.robot.q0, self._pair, len(self.pairs))
        overlapping = np.flatnonzero(distances <= 0.0)
        if overlapping.size:
            raise OverlappingShapes(
                [self.pairs[k] for k in overlapping], (-distances[overlapping]).tolist()
            )

    def joint_of(self, link: str) -> int:
        """Return the Pinocchio index of the joint that carries a link with shapes.

        The base is 0.
        """
        return int(self.shapes.geometryObjects[self.links.index(link)].parentJoint)

    def distances(self, positions: ArrayLike) -> Array:
        """Return the distances of all pairs of links.

        Parameters
        ----------
        positions : (..., n) array_like
            Positions of the actuated joints [m or rad].

        Returns
        -------
        (..., P) ndarray
            Distance of each of :attr:`pairs`, negative if they overlap [m].

        Raises
        ------
        InvalidArray, ClosureFailed, JointLimitExceeded, UnreachablePose
            See the robot's ``configuration``.
        """
        configurations = self.robot.configuration(positions)
        rows = [
            self._least(q, self._pair, len(self.pairs))[0]
            for q in configurations.reshape(-1, self.robot.model.nq)
        ]
        return np.array(rows).reshape(*configurations.shape[:-1], len(self.pairs))

    def nearest(self, positions: ArrayLike) -> Nearest:
        """Return the two links that are nearest to each other in one pose.

        Parameters
        ----------
        positions : (n,) array_like
            Positions of the actuated joints [m or rad].

        Returns
        -------
        Nearest

        Raises
        ------
        InvalidArray, ClosureFailed, JointLimitExceeded, UnreachablePose
            See the robot's ``configuration``.
        """
        row = one_row("positions", positions, len(self.robot.reference))
        return self.nearest_at(self.robot.configuration(row))

    def nearest_at(self, configuration: Array) -> Nearest:
        """Return the two links that are nearest to each other at a closed configuration (nq,)."""
        _, (k,) = self._least(configuration, [0] * len(self._pair), 1)
        found = pin.computeDistance(self.shapes, self._shape_data, k)
        points = np.array([found.getNearestPoint1(), found.getNearestPoint2()])
        return Nearest(self.pairs[self._pair[k]], float(found.min_distance), points)

    def least_distances(self, configurations: Array) -> tuple[Array, NDArray[np.int64]]:
        """Return the distances of the nearest links at closed configurations (N, nq).

        Parameters
        ----------
        configurations : (N, nq) ndarray
            Pinocchio configurations.

        Returns
        -------
        distance : (N,) ndarray
            Least distance over all pairs [m].
        pair : (N,) ndarray of int
            Index of this pair in :attr:`pairs`.
        """
        found = [self._least(q, [0] * len(self._pair), 1) for q in configurations]
        distance = np.array([least[0] for least, _ in found])
        return distance, np.array([self._pair[which[0]] for _, which in found], dtype=np.int64)

    def _least(self, q: Array, group: list[int], groups: int) -> tuple[Array, list[int]]:
        """Return the smallest distance in every group of pairs of shapes, and its pair."""
        pin.updateGeometryPlacements(self.robot.model, self._data, self.shapes, self._shape_data, q)
        boxes = self._boxes.distances(self._data, self._ends)
        bounds, least, which = boxes.tolist(), [np.inf] * groups, [-1] * groups
        for k in np.argsort(boxes, kind="stable").tolist():
            bound, of_group = bounds[k], group[k]
            # Overlapping boxes do not show the depth of the overlap of their shapes.
            if 0.0 < bound >= least[of_group]:
                if groups == 1:
                    break
                continue
            distance = pin.computeDistance(self.shapes, self._shape_data, k).min_distance
            if distance < least[of_group]:
                least[of_group], which[of_group] = distance, k
        return np.array(least), which


class _Boxes:
    """Boxes around the shapes, parallel to the axes of the base.

    Shapes are at least as far apart as their boxes.
    """

    def __init__(self, shapes: list[Any]) -> None:
        for shape in shapes:
            shape.geometry.computeLocalAABB()
        corners = np.array(
            [[shape.geometry.aabb_local.min_, shape.geometry.aabb_local.max_] for shape in shapes]
        )
        rotations = np.array([shape.placement.rotation for shape in shapes])
        centers = np.array([shape.placement.translation for shape in shapes])
        self._joints = sorted({shape.parentJoint for shape in shapes})
        self._of_shape = np.searchsorted(self._joints, [shape.parentJoint for shape in shapes])
        self._centers = np.einsum("sij,sj->si", rotations, corners.mean(axis=1)) + centers
        self._edges = rotations * 0.5 * (corners[:, 1] - corners[:, 0])[:, np.newaxis, :]

    def distances(self, data: pin.Data, ends: NDArray[np.int64]) -> Array:
        """Return the distances (K,) of pairs (K, 2) of boxes after the last forward kinematics."""
        rotations = np.array([data.oMi[joint].rotation for joint in self._joints])[self._of_shape]
        origins = np.array([data.oMi[joint].translation for joint in self._joints])[self._of_shape]
        centers = np.einsum("sij,sj->si", rotations, self._centers) + origins
        sizes = np.abs(rotations @ self._edges).sum(axis=-1)
        first, second = ends.T
        gaps = np.abs(centers[first] - centers[second]) - sizes[first] - sizes[second]
        distances: Array = np.linalg.norm(np.maximum(gaps, 0.0), axis=-1)
        return distances


def _link(model: pin.Model, shape: Any) -> str:
    """Return the name of the link that carries a shape, or of its joint if it has no link."""
    return str(
        model.frames[shape.parentFrame].name
        if shape.parentFrame < model.nframes
        else model.names[shape.parentJoint]
    )


def collision_model(
    robot: Robot, urdf: str | Path | None = None, srdf: str | Path | None = None
) -> CollisionModel:
    """Return the collision model of a robot, from the ``<collision>`` elements of its URDF.

    Parameters
    ----------
    robot : Robot
        The robot, with the dimensions of the file.
    urdf : path, optional
        The file; by default the one that the robot was loaded from.
    srdf : path, optional
        Pairs of links to leave out, see :mod:`psp3.collisions.pairs`; by default those of the SRDF
        that the robot was loaded from.

    Returns
    -------
    CollisionModel

    Raises
    ------
    InvalidValue
        If no file is given for a robot that was not loaded from one.
    InvalidRobotFile
        If a file is missing or malformed, has no ``<collision>`` element, or describes another
        robot, or a robot with other dimensions.
    UnknownName, OverlappingShapes
        See :class:`CollisionModel`.
    """
    if urdf is None:
        urdf, loaded_with = _files(robot)
        srdf = loaded_with if srdf is None else srdf
    path = Path(urdf)
    root = plain_urdf(path)
    make_meshes_absolute(path, root)
    for mesh in root.iterfind("link/collision/geometry/mesh"):
        if reason := not_opened(mesh.attrib["filename"], [path.parent]):
            raise InvalidRobotFile(path, f"mesh {mesh.attrib['filename']!r} {reason}")
    text = ElementTree.tostring(root, encoding="unicode")
    try:
        model = pin.buildModelFromXML(text)
        shapes = pin.buildGeomFromUrdfString(
            model, text, pin.GeometryType.COLLISION, package_dirs=[str(path.parent)]
        )
    except (ValueError, RuntimeError) as error:
        raise InvalidRobotFile(path, f"Pinocchio cannot read it: {error}") from error
    if not shapes.ngeoms:
        raise InvalidRobotFile(
            path,
            "has no <collision> element: give its links some, or take the visuals for them, "
            "CollisionModel(robot, robot.visual_model)",
        )
    _compare_dimensions(robot.model, model, path)
    return CollisionModel(
        robot,
        _attached(shapes, model, robot.model, path),
        [] if srdf is None else excluded_by_srdf(srdf),
    )


def _files(robot: Robot) -> tuple[Path, Path | None]:
    """Return the URDF and SRDF that a robot was loaded from."""
    if robot.urdf is None:
        raise InvalidValue("urdf", None, "the robot's file: this robot was not loaded from one")
    return robot.urdf, robot.srdf


def _compare_dimensions(model: pin.Model, of_file: pin.Model, path: Path) -> None:
    """Refuse a file if the robot's joints and frames have other placements.

    The shapes in the file would be at wrong places, too.
    """
    # Joints that were replaced on loading, and the frames on them, are not in the file.
    same = {
        index
        for index, name in enumerate(of_file.names)
        if index == 0
        or (
            model.existJointName(name)
            and model.names[model.parents[model.getJointId(name)]]
            == of_file.names[of_file.parents[index]]
            and model.joints[model.getJointId(name)].nq == of_file.joints[index].nq
        )
    }
    placements = [
        (
            f"joint {of_file.names[index]!r}",
            of_file.jointPlacements[index],
            model.jointPlacements[model.getJointId(of_file.names[index])],
        )
        for index in sorted(same - {0})
    ]
    for frame in of_file.frames:
        if (
            frame.parentJoint in same
            and frame.type == pin.FrameType.BODY
            and model.existFrame(frame.name, frame.type)
        ):
            mine = model.frames[model.getFrameId(frame.name, frame.type)]
            if model.names[mine.parentJoint] == of_file.names[frame.parentJoint]:
                placements.append((f"frame {frame.name!r}", frame.placement, mine.placement))
    for name, theirs, ours in placements:
        deviation = float(np.abs(theirs.homogeneous - ours.homogeneous).max())
        if deviation > LARGEST_DEVIATION:
            raise InvalidRobotFile(
                path,
                (
                    f"its shapes do not fit this robot: {name} is {deviation:.3g} (m) from where "
                    "the file has it; give a file of these sizes"
                ),
            )


def _attached(shapes: Any, of_file: pin.Model, model: pin.Model, path: Path) -> Any:
    """Return the shapes of a file on the links of a robot.

    The joints of the robot may differ from those of the file.
    """
    attached = pin.GeometryModel()
    for shape in shapes.geometryObjects:
        link = of_file.frames[shape.parentFrame]
        if not model.existFrame(link.name, link.type):
            raise InvalidRobotFile(
                path, f"describes another robot: this one has no link {link.name!r}"
            )
        frame = model.getFrameId(link.name, link.type)
        moved = shape.copy()
        moved.parentFrame, moved.parentJoint = frame, model.frames[frame].parentJoint
        moved.placement = model.frames[frame].placement * link.placement.actInv(shape.placement)
        attached.addGeometryObject(moved)
    return attached
