"""Joints that a URDF cannot write.

Revolutes of a tree that stand for ball and universal joints, or for no joint at all.

The loop files of toolbox-parallel-robots (keys ``joint_name`` and ``joint_type``) name them. What
becomes of a joint ``j``:

``SPHERICAL``
    A ball joint ``j`` in its place.
``UJOINT_XY``, ``UJOINT_YZ``, ...
    A universal joint: a revolute ``j_X`` about x of the frame of ``j``, then a revolute ``j_Y``
    about the turned y, with nothing between them. Frame ``j`` stays and moves with the second.
``FIXED``
    No joint: it is locked where its coordinate is zero.

Bodies, frames, shapes, limits of the other joints and their order stay as they are. A replaced
joint has no position limits, because those of one angle say nothing about several; its other
limits, damping and friction hold for each of its degrees of freedom.

The loader of example-parallel-robots reads the same files. It differs from this one in that it
drops the frame ``j`` and every limit; locks other joints than those named ``FIXED`` if a universal
joint comes before them (their numbers are those of the URDF's tree); leaves the shapes of
``UJOINT_XZ`` and ``UJOINT_YX`` where the URDF's tree had that number; takes an unknown type for the
one read before; and turns every three revolutes with massless links between them into a ball joint,
whether the file says so or not.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin

from psp3.errors import InvalidRobotFile

UNIVERSAL = tuple(f"UJOINT_{first}{second}" for first, second in itertools.permutations("XYZ", 2))
"""Universal joints, by the axes of their two revolutes."""

REPLACEMENTS = ("SPHERICAL", *UNIVERSAL, "FIXED")
"""What may stand in the key ``joint_type`` of a loop file."""

ABOUT = {"X": pin.JointModelRX, "Y": pin.JointModelRY, "Z": pin.JointModelRZ}
"""Revolutes about the axes of a joint's frame."""

PER_DEGREE_OF_FREEDOM = (
    "lowerEffortLimit",
    "upperEffortLimit",
    "lowerVelocityLimit",
    "upperVelocityLimit",
    "lowerDryFrictionLimit",
    "upperDryFrictionLimit",
    "damping",
    "armature",
    "rotorInertia",
    "rotorGearRatio",
)
"""What a Pinocchio model holds for each degree of freedom."""

POSITION_LIMITS = ("lowerPositionLimit", "upperPositionLimit", "positionLimitMargin")
"""What a Pinocchio model holds for each coordinate."""

BODY_MARK = "\x00"
"""Before the name of a body that a joint has, too: no file has it."""

NewJoints = Mapping[str, Sequence[tuple[str, Any]]]
"""For joints of the old tree, names and models of those that replace them, from the base
outward.
"""

LARGEST_QUATERNION_ENTRY = 1.01
"""Pinocchio's parsers give coordinates on the unit sphere this for a limit."""


def replace_joints(
    model: pin.Model,
    visual_model: Any,
    replaced: Sequence[tuple[str, str]],
    actuated: Sequence[str],
    path: str | Path,
) -> tuple[pin.Model, Any]:
    """Return a tree in which joints are replaced, with its visual model.

    Parameters
    ----------
    model : pinocchio.Model
        The tree as read; it stays as it is.
    visual_model : pinocchio.GeometryModel
        Its shapes; they stay as they are.
    replaced : sequence of (str, str)
        Names of joints with what replaces them, one of :data:`REPLACEMENTS`.
    actuated : sequence of str
        Names of the actuated joints. Among them, those of unlimited angle (``continuous`` in a
        URDF) become plain revolutes without limits: Pinocchio counts the former in two coordinates,
        cosine and sine, and what a motor drives is an angle.
    path : path
        The loop file, for error messages.

    Returns
    -------
    model : pinocchio.Model
        The new tree; the given one where nothing is to be done.
    visual_model : pinocchio.GeometryModel
        The shapes on the new tree.

    Raises
    ------
    InvalidRobotFile
        If a joint does not exist, its type is unknown, it is not a revolute (what is ``FIXED`` may
        be any joint), or a name that a universal joint needs is taken.
    """
    kinds = dict(replaced)
    for name, kind in replaced:
        _check(model, name, kind, path)
    new_joints = {name: _joints_of(name, kind) for name, kind in replaced if kind != "FIXED"}
    for name in actuated:
        if model.existJointName(name) and name not in kinds:
            joint = model.joints[model.getJointId(name)]
            if joint.nq == 2 and joint.nv == 1:
                new_joints[name] = [(name, revolute_like(joint))]
    if not kinds and not new_joints:
        return model, visual_model
    model, visual_model = rebuilt(model, visual_model, new_joints, path)
    locked = [model.getJointId(name) for name, kind in replaced if kind == "FIXED"]
    if locked:
        model, visual_model = _locked(model, visual_model, locked)
    return model, visual_model


def _locked(model: pin.Model, visual_model: Any, joints: list[int]) -> tuple[pin.Model, Any]:
    """Return a tree without some of its joints.

    Pinocchio looks its joints up by names among all frames, and fails where a body has the same.
    """
    joint_frame = pin.FrameType.JOINT
    for frame in model.frames:
        if frame.type != joint_frame and model.existJointName(frame.name):
            frame.name = BODY_MARK + frame.name
    model, visual_model = pin.buildReducedModel(model, visual_model, joints, pin.neutral(model))
    for frame in model.frames:
        frame.name = frame.name.removeprefix(BODY_MARK)
    return model, visual_model


def _check(model: pin.Model, name: str, kind: str, path: str | Path) -> None:
    if kind not in REPLACEMENTS:
        raise InvalidRobotFile(
            path,
            f"joint_type: {kind!r} for joint {name!r} is unknown; known are "
            f"{', '.join(REPLACEMENTS)}",
        )
    if not model.existJointName(name) or name == model.names[0]:
        raise InvalidRobotFile(
            path,
            f"joint_name: the robot has no joint {name!r}; its joints are "
            f"{', '.join(list(model.names)[1:])}",
        )
    joint = model.joints[model.getJointId(name)]
    if kind != "FIXED" and not joint.shortname().startswith(("JointModelR", "JointModelRevolute")):
        raise InvalidRobotFile(
            path,
            f"joint_name: only a revolute joint can become {kind}, and {name!r} is a "
            f"{joint.shortname()[10:]}",
        )


def _joints_of(name: str, kind: str) -> list[tuple[str, Any]]:
    """Names and models of the joints that replace one, from the base outward."""
    if kind == "SPHERICAL":
        return [(name, pin.JointModelSpherical())]
    return [(f"{name}_{axis}", ABOUT[axis]()) for axis in kind[-2:]]


def revolute_like(joint: Any) -> Any:
    """Return the revolute with one coordinate about the axis of one with two."""
    kind = joint.shortname()
    if kind[-1] in ABOUT:
        return ABOUT[kind[-1]]()
    # Pinocchio does not tell the axis of this kind of joint, but its motion.
    data = joint.createData()
    joint.calc(data, np.array([1.0, 0.0]))
    return pin.JointModelRevoluteUnaligned(np.asarray(data.S)[3:].ravel())


def rebuilt(
    model: pin.Model, visual_model: Any, new_joints: NewJoints, path: str | Path
) -> tuple[pin.Model, Any]:
    """Return the tree and its shapes with some of the joints replaced.

    What a joint has for each degree of freedom its replacements all have, or, of a joint of
    several, what it has for the first.
    """
    new = pin.Model()
    new.name, new.gravity = model.name, model.gravity
    new.inertias[0] = model.inertias[0]
    # Number of each joint of the old tree in the new one: of the last one, where it became several.
    number = [0]
    for old in range(1, model.njoints):
        name = model.names[old]
        parent, placement = number[model.parents[old]], model.jointPlacements[old]
        for new_name, joint in new_joints.get(name, [(name, model.joints[old])]):
            if new.existJointName(new_name) or (
                new_name != name and model.existJointName(new_name)
            ):
                raise InvalidRobotFile(
                    path,
                    f"joint_name: {name!r} becomes {new_name!r}, a name that another joint has; "
                    "rename that one",
                )
            parent = new.addJoint(parent, joint, placement, new_name)
            placement = pin.SE3.Identity()
            _copy_limits(model, old, new, parent, replaced=name in new_joints)
        new.appendBodyToJoint(parent, model.inertias[old], pin.SE3.Identity())
        number.append(parent)
    frames = _copy_frames(model, new, number, new_joints)
    shapes = visual_model.copy()
    for shape in shapes.geometryObjects:
        shape.parentJoint, shape.parentFrame = number[shape.parentJoint], frames[shape.parentFrame]
    return new, shapes


def _copy_limits(model: pin.Model, old: int, new: pin.Model, number: int, replaced: bool) -> None:
    before, after = model.joints[old], new.joints[number]
    for attribute in PER_DEGREE_OF_FREEDOM:
        getattr(new, attribute)[after.idx_v : after.idx_v + after.nv] = getattr(model, attribute)[
            before.idx_v : before.idx_v + min(before.nv, after.nv)
        ]
    coordinates = slice(after.idx_q, after.idx_q + after.nq)
    if not replaced:
        for attribute in POSITION_LIMITS:
            getattr(new, attribute)[coordinates] = getattr(model, attribute)[
                before.idx_q : before.idx_q + before.nq
            ]
    else:
        limit = LARGEST_QUATERNION_ENTRY if after.nq > after.nv else np.inf
        new.lowerPositionLimit[coordinates], new.upperPositionLimit[coordinates] = -limit, limit


def _copy_frames(
    model: pin.Model, new: pin.Model, number: list[int], new_joints: NewJoints
) -> list[int]:
    """Put the frames of the old tree in the new one, and return the number of each there."""
    place = [0]
    for frame in list(model.frames)[1:]:
        parent, joint, kind = place[frame.parentFrame], number[frame.parentJoint], frame.type
        if kind == pin.FrameType.JOINT and len(new_joints.get(frame.name, ())) > 1:
            for name, _ in new_joints[frame.name]:
                parent = new.addFrame(
                    pin.Frame(
                        name, new.getJointId(name), parent, pin.SE3.Identity(), pin.FrameType.JOINT
                    ),
                    False,
                )
            kind = pin.FrameType.OP_FRAME
        place.append(
            new.addFrame(
                pin.Frame(frame.name, joint, parent, frame.placement, kind, frame.inertia), False
            )
        )
    return place
