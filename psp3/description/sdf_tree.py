"""Build a tree from the graph of an SDF file, and close the remaining loops.

Joints of an SDF file may connect links in any way, and all loops are closed in the pose of the
file. Links that are welded become one body.

A spanning tree is selected from the joints. Two kinds of joints come first: those with more than
geometry (limits, damping, friction, springs, motors, couplings), and those without a constraint
model (prismatic, screw, universal). Among equals, joints come first if no earlier joint has the
same child.

The other joints close loops. A revolute becomes a hinge closure and a ball a point closure. Any
other joint, and any joint with forces of its own, remains a joint; it carries a massless copy of
its child, which is welded to the child. A part that no joint connects to the world floats, with the
first link in the file as its base.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin

from psp3.description.loop_file import rigid_constraint
from psp3.description.sdf_frames import Frame, Reader
from psp3.description.sdf_joints import Axis, Joint
from psp3.description.xml import check_inertia, described
from psp3.multibody.equations import Hinge

LENGTH = 1.0
"""The format's default mass [kg] and moments [kg m²] of a link without <inertial>."""


class Place(NamedTuple):
    """The place of a frame in the tree."""

    joint: int
    """The joint that moves it."""
    placement: pin.SE3
    """Its placement in that joint."""


class Tree:
    """A Pinocchio model that is built from links and joints.

    Parameters
    ----------
    reader : Reader
        The frames of the file.
    joints : sequence of Joint
        Its joints.
    kept : collection of str
        Names of joints that must be in the tree.

    Attributes
    ----------
    model : pinocchio.Model
        The tree.
    closures : pinocchio.StdVec_RigidConstraintModel
        Loops closed by balls and welds.
    hinges : list of Hinge
        Loops closed by revolutes.
    still : list of str
        Joints that cannot move, because their links are welded.
    unspecified : list of str
        Links that move and have no <inertial>.
    """

    def __init__(self, reader: Reader, joints: Sequence[Joint], kept: Collection[str]) -> None:
        self.reader, self.kept = reader, kept
        self.model = pin.Model()
        self.closures = pin.StdVec_RigidConstraintModel()
        self.hinges: list[Hinge] = []
        self.unspecified: list[str] = []
        self._bodies = _welded(reader, joints)
        self._members: dict[int, list[Frame]] = {}
        for link in reader.found.links:
            self._members.setdefault(self.body(link), []).append(link)
        moving = [joint for joint in joints if joint.kind not in ("fixed", "gearbox")]
        self.still = [
            joint.name for joint in moving if self.body(joint.parent) == self.body(joint.child)
        ]
        self.moving = [joint for joint in moving if joint.name not in self.still]
        in_tree, left = self._spanning()
        self._origins: list[pin.SE3] = [pin.SE3.Identity()]
        self._joint_of: dict[int, int] = {}
        self._copies: dict[str, int] = {}
        self._grow(in_tree, [joint for joint in left if self._must_stay(joint)])
        for joint in left:
            self._close(joint)
        self._frames(joints)

    def body(self, link: Frame | None) -> int:
        """Return the number of the body that a link is part of; 0 is the world."""
        return 0 if link is None else self._bodies[link.full_name]

    def place(self, frame: Frame) -> Place:
        """Return the place of a frame of the file in the tree."""
        link = self.reader.link(frame)
        joint = self._joint_of[self.body(link)]
        return Place(joint, self._origins[joint].actInv(self.reader.placement(frame)))

    # The spanning tree

    def _spanning(self) -> tuple[list[Joint], list[Joint]]:
        """Return the joints of the tree, and the others."""
        order, has_parent = [], {0}
        for number, joint in enumerate(self.moving):
            child = self.body(joint.child)
            order.append((not self._must_stay(joint), child in has_parent, number))
            has_parent.add(child)
        group = list(range(max(self._bodies.values(), default=0) + 1))
        in_tree: list[int] = []
        left: list[int] = []
        for _, _, number in sorted(order):
            joint = self.moving[number]
            ends = [_root(group, self.body(end)) for end in (joint.parent, joint.child)]
            (left if ends[0] == ends[1] else in_tree).append(number)
            group[ends[1]] = ends[0]
        return [self.moving[k] for k in sorted(in_tree)], [self.moving[k] for k in sorted(left)]

    def _must_stay(self, joint: Joint) -> bool:
        is_plain = joint.kind in ("revolute", "continuous", "ball")
        return not is_plain or self._is_kept(joint) or any(axis.acts for axis in joint.axes)

    def _is_kept(self, joint: Joint) -> bool:
        return any(name in self.kept for name in (joint.name, *(a.name for a in joint.axes)))

    def _grow(self, joints: Sequence[Joint], doubled: Sequence[Joint]) -> None:
        """Add all bodies, finishing each chain before the next one."""
        of_body: dict[int, list[Joint]] = {}
        for joint in joints:
            for end in (joint.parent, joint.child):
                of_body.setdefault(self.body(end), []).append(joint)
        for joint in doubled:
            of_body.setdefault(self.body(joint.parent), []).append(joint)
        self._copies = dict.fromkeys((joint.name for joint in doubled), 0)
        self._add_body(0, 0)
        self._branch(0, of_body)
        floating = False
        for link in self._bases(joints):
            body = self.body(link)
            if body in self._joint_of:
                continue
            number = self._float(link, is_first=not floating)
            floating = True
            self._add_body(body, number)
            self._branch(body, of_body)

    def _bases(self, joints: Sequence[Joint]) -> list[Frame]:
        """Return possible floating bases; those of the first part with a motor come first."""
        links = [self.reader.link(model) for model in self.reader.found.models]
        bases = [link for link in (*links, *self.reader.found.links) if link is not None]
        group = list(range(max(self._bodies.values(), default=0) + 1))
        for joint in joints:
            one, two = (_root(group, self.body(end)) for end in (joint.parent, joint.child))
            group[one] = two
        driven = [joint for joint in joints if self._is_kept(joint)]
        first = {_root(group, self.body(joint.child)) for joint in driven[:1]}
        return sorted(bases, key=lambda link: _root(group, self.body(link)) not in first)

    def _float(self, link: Frame, *, is_first: bool) -> int:
        """Add the joints that let a part float; return the number of the last one.

        The first part gets one free joint, because a robot has one floating base. Any other part
        gets six joints, each of which can be a coordinate or be held.
        """
        where, prefix = self.reader.placement(link), f"{link.scope.prefix}root_joint"
        if self.model.existJointName(prefix) or self.model.existJointName(f"{prefix}_x"):
            prefix = f"{link.full_name}_root_joint"
        joints = [(prefix, pin.JointModelFreeFlyer())]
        if not is_first:
            joints = [(f"{prefix}_{end}", model()) for end, model in _SIX]
        number = 0
        for name, model in joints:
            if self.model.existJointName(name):
                raise link.document.wrong(f"two joints of the robot would have the name {name!r}")
            place = self._origins[number].actInv(where)
            number = self.model.addJoint(number, model, place, name)
            self._origins.append(where)
            self.model.addJointFrame(number)
        return number

    def _branch(self, start: int, of_body: dict[int, list[Joint]]) -> None:
        waiting = [(start, joint) for joint in reversed(of_body.get(start, []))]
        while waiting:
            body, joint = waiting.pop()
            ends = [self.body(joint.parent), self.body(joint.child)]
            other = ends[1] if ends[0] == body else ends[0]
            if joint.name in self._copies:
                self._copies[joint.name] = self._add_joint(
                    joint, self._joint_of[body], is_forward=True
                )
                continue
            if other in self._joint_of:
                continue
            number = self._add_joint(joint, self._joint_of[body], is_forward=ends[0] == body)
            self._add_body(other, number)
            waiting += [(other, next_) for next_ in reversed(of_body[other]) if next_ is not joint]

    def _add_joint(self, joint: Joint, parent: int, *, is_forward: bool) -> int:
        """Add a joint in its own or in the reverse direction; return its number."""
        where, chain = self.reader.placement(joint.frame), joint.models()
        for name, model, axis in chain if is_forward else reversed(chain):
            if self.model.existJointName(name):
                raise joint.frame.document.wrong(
                    f"{described(joint.frame.element)}: two joints would have the name {name!r}"
                )
            if not is_forward:
                model = _reversed(joint, axis, model)
            parent = self.model.addJoint(parent, model, self._origins[parent].actInv(where), name)
            self._origins.append(where)
            self._limit(parent, axis)
            self.model.addJointFrame(parent)
        return parent

    def _limit(self, number: int, axis: Axis | None) -> None:
        if axis is None:
            return
        model, joint = self.model, self.model.joints[number]
        velocities = slice(joint.idx_v, joint.idx_v + joint.nv)
        if joint.nq == 1:
            model.lowerPositionLimit[joint.idx_q] = axis.limits[0]
            model.upperPositionLimit[joint.idx_q] = axis.limits[1]
        model.lowerEffortLimit[velocities], model.upperEffortLimit[velocities] = (
            -axis.effort,
            axis.effort,
        )
        model.lowerVelocityLimit[velocities], model.upperVelocityLimit[velocities] = (
            -axis.velocity,
            axis.velocity,
        )
        model.lowerDryFrictionLimit[velocities] = -axis.friction
        model.upperDryFrictionLimit[velocities] = axis.friction
        model.damping[velocities] = axis.damping

    def _add_body(self, body: int, number: int) -> None:
        """Attach the links of a body to a joint."""
        self._joint_of[body] = number
        above = (
            self.model.getFrameId(self.model.names[number], pin.FrameType.JOINT) if number else 0
        )
        for link in self._members.get(body, []):
            at = self._origins[number].actInv(self.reader.placement(link))
            self.model.addFrame(
                pin.Frame(link.full_name, number, above, at, pin.FrameType.BODY), False
            )
            if number:
                self.model.appendBodyToJoint(number, self._inertia(link), at)

    def _inertia(self, link: Frame) -> pin.Inertia:
        """Return the inertia of a link that moves, in its frame."""
        document, element = link.document, link.element
        inertial = element.find("inertial")
        if inertial is None or (inertial.find("mass") is None and inertial.find("inertia") is None):
            self.unspecified.append(link.full_name)
        if inertial is None:
            return pin.Inertia(LENGTH, np.zeros(3), LENGTH * np.eye(3))
        if document.has_flag(inertial, "auto"):
            raise document.wrong(
                f"{described(element)}: <inertial auto='true'> is not computed here; let the "
                "format's own tool write it out (gz sdf --print FILE --expand-auto-inertials)"
            )
        mass = document.number(inertial, "mass", LENGTH)
        place, relative_to = document.pose(inertial)
        if relative_to not in ("", link.name):
            raise document.wrong(
                f"{described(element)}: the pose of its <inertial> must be relative to the link, "
                f"not to {relative_to!r}"
            )
        matrix, moments = LENGTH * np.eye(3), inertial.find("inertia")
        if moments is not None:
            for row, column, tag in _ENTRIES:
                matrix[row, column] = matrix[column, row] = document.number(
                    moments, tag, matrix[row, column]
                )
        check_inertia(document.path, element, mass, matrix)
        turn = place.rotation
        return pin.Inertia(mass, place.translation, turn @ matrix @ turn.T)

    # Loops

    def _close(self, joint: Joint) -> None:
        """Close a loop with a joint that is not in the tree."""
        where = self.reader.placement(joint.frame)
        ends = []
        for link in (joint.parent, joint.child):
            number = self._joint_of[self.body(link)]
            ends.append((number, self._origins[number].actInv(where)))
        if joint.name in self._copies:
            copy = self._copies[joint.name], pin.SE3.Identity()
            weld = rigid_constraint(self.model, "6d", copy, ends[1])
            weld.name = joint.name
            self.closures.append(weld)
        elif joint.kind == "ball":
            point = rigid_constraint(self.model, "3d", *ends)
            point.name = joint.name
            self.closures.append(point)
        else:
            turn = pin.SE3(_rotation_to(joint.axes[0].direction), np.zeros(3))
            (one, at), (two, there) = ends
            self.hinges.append(Hinge(joint.name, one, at * turn, two, there * turn))

    def _frames(self, joints: Sequence[Joint]) -> None:
        """Add frames for the frames of the file, and for joints that are not in the tree."""
        named = [*self.reader.found.frames, *(joint.frame for joint in joints)]
        for frame in named:
            if not self.model.existFrame(frame.full_name):
                at = self.place(frame)
                self.model.addFrame(
                    pin.Frame(frame.full_name, at.joint, 0, at.placement, pin.FrameType.OP_FRAME),
                    False,
                )


_SIX = (
    ("x", pin.JointModelPX),
    ("y", pin.JointModelPY),
    ("z", pin.JointModelPZ),
    ("yaw", pin.JointModelRZ),
    ("pitch", pin.JointModelRY),
    ("roll", pin.JointModelRX),
)
"""The joints that let a second or later part float."""

_ENTRIES = (
    (0, 0, "ixx"),
    (1, 1, "iyy"),
    (2, 2, "izz"),
    (0, 1, "ixy"),
    (0, 2, "ixz"),
    (1, 2, "iyz"),
)


def _welded(reader: Reader, joints: Sequence[Joint]) -> dict[str, int]:
    """Return the number of the body of every link; links that are welded share one."""
    number: dict[str, int] = {}
    for link in reader.found.links:
        if link.full_name in number:
            raise link.document.wrong(f"two links would have the name {link.full_name!r}")
        number[link.full_name] = len(number) + 1
    # The world has number 0.
    group = list(range(len(number) + 1))
    for link in reader.found.links:
        if link.scope.is_static:
            group[_root(group, number[link.full_name])] = _root(group, 0)
    for joint in joints:
        if joint.kind == "fixed":
            one, two = (
                0 if end is None else number[end.full_name] for end in (joint.child, joint.parent)
            )
            group[_root(group, one)] = _root(group, two)
    roots = {name: _root(group, k) for name, k in number.items()}
    world = _root(group, 0)
    return {name: 0 if root == world else root for name, root in roots.items()}


def _root(group: list[int], item: int) -> int:
    while group[item] != item:
        group[item] = group[group[item]]
        item = group[item]
    return item


def _reversed(joint: Joint, axis: Axis | None, model: Any) -> Any:
    """Return a joint from child to parent, with the same coordinate."""
    if axis is None or joint.kind == "ball":
        return model
    back = joint._replace(axes=(axis._replace(direction=-axis.direction),))
    return back.models()[0][1]


def _rotation_to(direction: Any) -> Any:
    """Return a rotation of z to a direction."""
    axis = np.cross([0.0, 0.0, 1.0], direction)
    sine = float(np.linalg.norm(axis))
    axis = axis / sine if sine > 1e-10 else np.array([1.0, 0.0, 0.0])
    return pin.AngleAxis(math.atan2(sine, direction[2]), axis).toRotationMatrix()
