"""Parts of a robot in addition to its tree: motors, and closures given by names of frames."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pinocchio as pin

from psp3.checks import Array, checked_finite, checked_kind, checked_names, one_row
from psp3.errors import InvalidValue, UnknownName
from psp3.multibody.equations import Coupling, Hinge, Spin
from psp3.multibody.named_frames import frame_number

CLOSURE_KINDS = ("3d", "6d", "hinge")
"""Kinds of closures that can be added: a point; position and orientation; a point and an axis."""

ONE_FREEDOM = "a joint of one degree of freedom: write a joint of several as a chain of such joints"


def check_parts(
    model: Any,
    constraint_models: Any,
    visual_model: Any,
    options: Mapping[str, Any],
    closures: Any,
) -> None:
    """Raise :class:`InvalidValue` if a part of a robot has the wrong type."""
    checked_kind("model", model, pin.Model, "a pinocchio.Model")
    vector = pin.StdVec_RigidConstraintModel
    checked_kind("constraint_models", constraint_models, (list, tuple, vector), "a list of loops")
    for loop in constraint_models:
        checked_kind("constraint_models", loop, pin.RigidConstraintModel, "RigidConstraintModels")
    wanted = "a pinocchio.GeometryModel or None"
    checked_kind("visual_model", visual_model, (pin.GeometryModel, type(None)), wanted)
    checked_kind("equations", options["equations"], tuple, "a list of Hinge or Coupling")
    for equation in options["equations"]:
        checked_kind("equations", equation, (Hinge, Coupling, Spin), "a list of Hinge or Coupling")
    if options["springs"] is not None:
        _check_springs(model, options["springs"])
    if options["tendons"] is not None:
        _check_tendons(options["tendons"])
    checked_kind("closures", closures, (list, tuple), "a list of two frames and a kind each")
    for closure in closures:
        if len(checked_names("closures", closure)) != 3:
            raise InvalidValue("closures", closure, "two frames and a kind each")


def _check_springs(model: pin.Model, springs: Any) -> None:
    checked_kind("springs", springs, Mapping, "a mapping of joints to stiffness and rest")
    for name, numbers in springs.items():
        if not isinstance(name, str) or not model.existJointName(name):
            raise UnknownName("joint with a spring", name, tuple(model.names)[1:])
        one_row(f"springs[{name!r}]", numbers, 2)


def _check_tendons(tendons: Any) -> None:
    wanted = "a mapping of motors to the levers of joints by their names"
    checked_kind("tendons", tendons, Mapping, wanted)
    for name, levers in tendons.items():
        checked_kind("tendons", name, str, wanted)
        checked_kind("tendons", levers, Mapping, wanted)
        for joint, lever in levers.items():
            checked_kind("tendons", joint, str, wanted)
            checked_finite(f"tendons[{name!r}][{joint!r}]", lever)


def motor_matrix(
    model: pin.Model, actuated: Sequence[str], tendons: Mapping[str, Mapping[str, float]]
) -> Array:
    """Return the joint velocities that the motors drive, one column per motor, (nv, m)."""
    matrix = np.zeros((model.nv, len(actuated)))
    for column, name in enumerate(actuated):
        for joint, lever in tendons.get(name, {name: 1.0}).items():
            if not model.existJointName(joint) or joint == model.names[0]:
                raise UnknownName("actuated joint", joint, tuple(model.names)[1:])
            driven = model.joints[model.getJointId(joint)]
            if driven.nv != 1:
                raise InvalidValue("actuated joint", joint, ONE_FREEDOM)
            matrix[driven.idx_v, column] += lever
    return matrix


def named_closures(
    model: pin.Model, closures: Sequence[tuple[str, str, str]], q: Array | None
) -> list[Any]:
    """Return additional closures, given by frames and kinds."""
    data, made = model.createData(), []
    pin.framesForwardKinematics(model, data, pin.neutral(model) if q is None else q)
    for first, second, kind in closures:
        if kind not in CLOSURE_KINDS:
            raise UnknownName("kind of closure", kind, CLOSURE_KINDS)
        number = frame_number(model, first)
        frame = model.frames[number]
        one = frame.parentJoint, frame.placement
        if second == "world":
            two = 0, data.oMf[number]
        else:
            frame = model.frames[_second_frame(model, second)]
            two = frame.parentJoint, frame.placement
        if kind == "hinge":
            made.append(Hinge(f"{first}-{second}", *one, *two))
        else:
            contact = pin.ContactType.CONTACT_6D if kind == "6d" else pin.ContactType.CONTACT_3D
            local = pin.ReferenceFrame.LOCAL
            loop = pin.RigidConstraintModel(contact, model, *one, *two, local)
            loop.name = f"{first}-{second}"
            made.append(loop)
    return made


def _second_frame(model: pin.Model, name: str) -> int:
    try:
        return frame_number(model, name)
    except UnknownName as error:
        raise UnknownName("frame", name, ("world", *error.known)) from None
