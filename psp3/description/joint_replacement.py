"""Replace joints that stand for types that a URDF does not have.

A revolute joint may stand for a ball joint, for a universal joint, or for no joint at all.

The loop files of toolbox-parallel-robots (keys ``joint_name`` and ``joint_type``) name them. A
joint ``j`` is replaced by:

``SPHERICAL``
    A ball joint ``j``.
``UJOINT_XY``, ``UJOINT_YZ``, ...
    A universal joint: a revolute ``j_X`` about x of the frame of ``j``, then a revolute ``j_Y``
    about the turned y, with nothing between them. Frame ``j`` stays and moves with the second.
``FIXED``
    No joint: the joint is locked at coordinate zero.

Bodies, frames, shapes, and the limits and order of the other joints do not change. A replaced joint
has no position limits, because those of one angle say nothing about several; its other limits,
damping and friction hold for each of its degrees of freedom.

The loader of example-parallel-robots reads the same files. It differs from this one in that it
drops the frame ``j`` and every limit; locks the wrong joints for ``FIXED`` if a universal joint
comes before them (it uses the joint numbers of the URDF's tree); attaches the shapes of
``UJOINT_XZ`` and ``UJOINT_YX`` to the joint that had their number in the URDF's tree; takes an
unknown type for the preceding type; and turns any three revolutes with massless links between them
into a ball joint, even if the file does not name them.
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
"""Universal joints, named after the axes of their two revolutes."""

REPLACEMENTS = ("SPHERICAL", *UNIVERSAL, "FIXED")
"""The allowed values of the key ``joint_type`` in a loop file."""

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
"""Arrays of a Pinocchio model with an entry for each degree of freedom."""

POSITION_LIMITS = ("lowerPositionLimit", "upperPositionLimit", "positionLimitMargin")
"""Arrays of a Pinocchio model with an entry for each coordinate."""

BODY_MARK = "\x00"
"""A prefix for bodies that share their name with a joint. It cannot occur in a file."""

NewJoints = Mapping[str, Sequence[tuple[str, Any]]]
"""Maps joints of the old tree to names and models of their replacements, from the base outward."""

LARGEST_QUATERNION_ENTRY = 1.01
"""The limit that Pinocchio's parsers set for the entries of a unit quaternion."""


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
        The tree as read; it is not changed.
    visual_model : pinocchio.GeometryModel
        Its shapes; they are not changed.
    replaced : sequence of (str, str)
        Names of joints with what replaces them, one of :data:`REPLACEMENTS`.
    actuated : sequence of str
        Names of the actuated joints. An actuated joint of unlimited angle (``continuous`` in a
        URDF) becomes an ordinary revolute without limits: Pinocchio describes a continuous joint by
        cosine and sine, but a motor drives an angle.
    path : path
        The loop file, for error messages.

    Returns
    -------
    model : pinocchio.Model
        The new tree; the given one if nothing is replaced.
    visual_model : pinocchio.GeometryModel
        The shapes on the new tree.

    Raises
    ------
    InvalidRobotFile
        If a joint does not exist, its type is unknown, it is not a revolute (any joint may become
        ``FIXED``), or the name of a new joint is taken.
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

    Pinocchio finds joints by name among all frames, and fails if a body has the same name.
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
    """Return names and models of the joints that replace one, from the base outward."""
    if kind == "SPHERICAL":
        return [(name, pin.JointModelSpherical())]
    return [(f"{name}_{axis}", ABOUT[axis]()) for axis in kind[-2:]]


def revolute_like(joint: Any) -> Any:
    """Return the one-coordinate revolute with the axis of a two-coordinate one."""
    kind = joint.shortname()
    if kind[-1] in ABOUT:
        return ABOUT[kind[-1]]()
    # Pinocchio does not give the axis of this kind of joint, but the joint's motion shows it.
    data = joint.createData()
    joint.calc(data, np.array([1.0, 0.0]))
    return pin.JointModelRevoluteUnaligned(np.asarray(data.S)[3:].ravel())


def rebuilt(
    model: pin.Model, visual_model: Any, new_joints: NewJoints, path: str | Path
) -> tuple[pin.Model, Any]:
    """Return the tree and its shapes with some of the joints replaced.

    All degrees of freedom of the replacements get the limits, damping and friction of the first
    degree of freedom of the old joint.
    """
    new = pin.Model()
    new.name, new.gravity = model.name, model.gravity
    new.inertias[0] = model.inertias[0]
    # Number in the new tree of each old joint; the last of its replacements if there are several.
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
    """Copy the frames of the old tree to the new one, and return their new numbers."""
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
