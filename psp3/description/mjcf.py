"""Robots from MJCF files, the format of MuJoCo.

Bodies give the tree, equality constraints the loops, and actuators the motors.
"""

from __future__ import annotations

import tempfile
import xml.etree.ElementTree as ElementTree
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin

from fuzzy2.support.logs import logger_named
from psp3.checks import Array
from psp3.description.joint_replacement import replace_joints
from psp3.description.loop_file import check_actuated, rigid_constraint
from psp3.description.mjcf_document import MjcfDocument
from psp3.description.mjcf_expansion import spelled_out
from psp3.description.mjcf_tree import COLLISION_GROUP, MjcfJoint, PlainMjcf, plain_mjcf
from psp3.description.parts import RobotParts, check_number
from psp3.description.reference_configurations import set_reference_configuration
from psp3.description.xml import described
from psp3.multibody.equations import Coupling

logger = logger_named(__name__)

MOST_SHAPES = 2000
"""The largest number of drawn geoms. Pinocchio's parser takes seconds for these, and minutes for
more.
"""


def read_mjcf(
    path: str | Path,
    actuated: Sequence[str] | None = None,
    joint_type: Mapping[str, str] | None = None,
) -> RobotParts:
    """Read a robot from an MJCF file.

    Loops are the active equality constraints ``connect`` (a point) and ``weld`` (position and
    orientation), between bodies or sites. The actuated joints are those of the ``<actuator>``
    section, in its order, once each. A motor on a fixed tendon drives the joints of the tendon with
    its coefficients as lever arms. Joint equalities couple two joints with a polynomial, or hold
    one. ``q0`` is the key frame ``home``, if there is one. Pinocchio's coordinates are zero in
    MuJoCo's reference pose (``qpos0``), so angles and lengths differ by ``ref``.

    Forces that the equation of motion does not contain (springs of balls and of tendons, buoyancy,
    fluids) are logged as a warning, and so are meshes that cannot be read. Damping, friction,
    armature and limits of the joints are in the model. Springs of hinges and slides are returned
    separately.

    Parameters
    ----------
    path : path
        The file.
    actuated : sequence of str, optional
        Names of the actuated joints; by default those of the file.
    joint_type : mapping of str to str, optional
        Joint types that hinges stand for, as in a loop file: see
        :mod:`psp3.description.joint_replacement`.

    Returns
    -------
    RobotParts
        Tree, loops, actuated joints, home pose and shapes.

    Raises
    ------
    InvalidRobotFile
        If the file is missing or malformed, or contains something that cannot be read: active
        constraints other than loops, motors that do not drive a joint of one degree of freedom,
        geoms whose inertia is needed and not known, or elements that MuJoCo expands to several
        bodies (``composite``, ``flexcomp``; MuJoCo can write out the expansion).
    """
    document = spelled_out(path)
    plain = plain_mjcf(document)
    check_number(document.path, len(plain.joints), "joints")
    shapes = sum(1 for _ in plain.root.iter("geom"))
    if shapes > MOST_SHAPES:
        raise document.wrong(
            f"has {shapes} geoms to draw, and at most {MOST_SHAPES} are read: those of group "
            f"{COLLISION_GROUP} and above are not drawn"
        )
    model, visual_model = _tree(document, plain)
    for name, (body, placement) in plain.sites.items():
        number = model.getFrameId(body, pin.FrameType.BODY)
        frame = model.frames[number]
        model.addFrame(
            pin.Frame(
                name, frame.parentJoint, number, frame.placement * placement, pin.FrameType.OP_FRAME
            )
        )
    _set_joints(model, plain)
    check_number(document.path, model.nv, "speeds")
    replaced = dict(joint_type or {})
    model, visual_model = replace_joints(
        model, visual_model, list(replaced.items()), (), document.path
    )
    model.gravity = pin.Motion(_gravity(document), np.zeros(3))
    tendons = _tendons(document, plain, model)
    names = tuple(_motors(document, plain, tendons) if actuated is None else actuated)
    driven = tuple(name for name in names if name not in tendons)
    check_actuated(model, driven, document.path, "actuator" if actuated is None else "actuated")
    closures = _loops(document, plain, model)
    _warn(document, plain)
    return RobotParts(
        model,
        closures,
        names,
        _home(document, plain, model),
        visual_model,
        _couplings(document, plain, model),
        {
            joint.name: (joint.stiffness, joint.rest)
            for joint in plain.joints
            if joint.stiffness != 0.0
            and joint.kind in ("hinge", "slide")
            and joint.name not in replaced
        },
        {name: levers for name, levers in tendons.items() if name in names},
    )


def _tree(document: MjcfDocument, plain: PlainMjcf) -> tuple[pin.Model, Any]:
    # Pinocchio reads MJCF from files only.
    with tempfile.TemporaryDirectory() as directory:
        file = Path(directory) / "plain.xml"
        ElementTree.ElementTree(plain.root).write(file, encoding="utf-8")
        try:
            model = pin.buildModelFromMJCF(str(file))
            return model, _shapes(plain, model, file)
        except (ValueError, RuntimeError) as error:
            raise document.wrong(f"Pinocchio cannot read it: {error}") from error


def _shapes(plain: PlainMjcf, model: pin.Model, file: Path) -> Any:
    """Return the shapes, without those whose meshes cannot be read."""
    try:
        return pin.buildGeomFromMJCF(model, str(file), pin.GeometryType.VISUAL)
    except (ValueError, RuntimeError):
        # Meshes are tried one by one only if one of them cannot be read.
        if not plain.leave_out_unreadable():
            raise
    ElementTree.ElementTree(plain.root).write(file, encoding="utf-8")
    return pin.buildGeomFromMJCF(model, str(file), pin.GeometryType.VISUAL)


def _set_joints(model: pin.Model, plain: PlainMjcf) -> None:
    """Write limits, damping, friction, armature and the places of free joints into a model."""
    for item in plain.joints:
        joint = model.joints[model.getJointId(item.name)]
        velocities = slice(joint.idx_v, joint.idx_v + joint.nv)
        if joint.nq == 1:
            model.lowerPositionLimit[joint.idx_q], model.upperPositionLimit[joint.idx_q] = (
                item.limits
            )
        model.lowerEffortLimit[velocities], model.upperEffortLimit[velocities] = item.effort
        model.lowerDryFrictionLimit[velocities], model.upperDryFrictionLimit[velocities] = (
            -item.friction,
            item.friction,
        )
        model.damping[velocities] = item.damping
        model.armature[velocities] = item.armature
        if item.kind == "free":
            # Pinocchio's parser places a free joint elsewhere and moves the difference into its own
            # qpos0.
            model.jointPlacements[joint.id] = item.placement
    set_reference_configuration(model, "qpos0", pin.neutral(model))


def _gravity(document: MjcfDocument) -> Array:
    gravity = np.array([0.0, 0.0, -9.81])
    for option in document.root.findall("option"):
        gravity = document.vector(option, "gravity", (gravity[0], gravity[1], gravity[2]))
        for flag in option.findall("flag"):
            if flag.get("gravity") == "disable":
                return np.zeros(3)
    return gravity


def _is_scalar(model: pin.Model, joint: MjcfJoint | None) -> bool:
    """Tell whether a joint is a hinge or slide of the file that was not replaced."""
    return (
        joint is not None
        and joint.kind in ("hinge", "slide")
        and model.existJointName(joint.name)
        and model.joints[model.getJointId(joint.name)].nq == 1
    )


def _tendons(
    document: MjcfDocument, plain: PlainMjcf, model: pin.Model
) -> dict[str, dict[str, float]]:
    """Return the lever arms of the joints of every fixed tendon."""
    joints = {joint.name: joint for joint in plain.joints}
    tendons: dict[str, dict[str, float]] = {}
    for element in document.section("tendon"):
        if element.tag != "fixed" or not element.get("name"):
            continue
        levers: dict[str, float] = {}
        for part in element.findall("joint"):
            name = part.get("joint", "")
            if not _is_scalar(model, joints.get(name)):
                raise document.wrong(
                    f"tendon: {described(element)} pulls joint {name!r}, which is not a hinge or "
                    "slide of the file"
                )
            levers[name] = levers.get(name, 0.0) + document.number(part, "coef", 0.0)
        tendons[element.attrib["name"]] = levers
    return tendons


def _couplings(document: MjcfDocument, plain: PlainMjcf, model: pin.Model) -> tuple[Coupling, ...]:
    """Return the active joint equalities."""
    joints = {joint.name: joint for joint in plain.joints}
    couplings = []
    for element in document.section("equality"):
        if element.tag != "joint" or not document.is_true(element, "active", True):
            continue
        follows = element.get("joint1", "")
        leads = element.get("joint2", follows)
        for name in (follows, leads):
            if not _is_scalar(model, joints.get(name)):
                raise document.wrong(
                    f"equality: {described(element)} couples joint {name!r}, which is not a hinge "
                    "or slide of the file"
                )
        # The polynomial and Pinocchio's coordinates both count from MuJoCo's reference pose.
        given = document.numbers(element, "polycoef")
        coefficients = [0.0, 1.0, 0.0, 0.0, 0.0]
        if given is not None:
            if given.size > len(coefficients):
                raise document.wrong(f"{described(element)}: polycoef has more than five numbers")
            coefficients[: given.size] = map(float, given)
        if follows == leads:
            coefficients[1:] = [0.0] * 4
        couplings.append(
            Coupling(
                element.get("name") or f"{follows}-{leads}",
                model.getJointId(follows),
                model.getJointId(leads),
                tuple(coefficients),
            )
        )
    return tuple(couplings)


def _motors(
    document: MjcfDocument, plain: PlainMjcf, tendons: dict[str, dict[str, float]]
) -> list[str]:
    joints = {joint.name for joint in plain.joints}
    motors: list[str] = []
    for element in document.section("actuator"):
        name = element.get("joint") or element.get("jointinparent") or element.get("tendon")
        if name is None:
            raise document.wrong(
                f"actuator: {described(element)} drives neither a joint nor a fixed tendon; say "
                "which joints are actuated (actuated=[...])"
            )
        if element.get("tendon") is not None and name not in tendons:
            raise document.wrong(
                f"actuator: {described(element)} drives tendon {name!r}, which is not a fixed "
                "tendon of the file; say which joints are actuated (actuated=[...])"
            )
        if element.get("tendon") is None and name not in joints:
            raise document.wrong(
                f"actuator: {described(element)} drives joint {name!r}, which is not in the file"
            )
        # A position servo and a velocity servo may drive the same joint.
        if name not in motors:
            motors.append(name)
    if not motors:
        raise document.wrong(
            "has no <actuator> that drives a joint; say which joints are actuated (actuated=[...])"
        )
    return motors


# Loops


def _loops(document: MjcfDocument, plain: PlainMjcf, model: pin.Model) -> Any:
    closures = pin.StdVec_RigidConstraintModel()
    data = model.createData()
    pin.framesForwardKinematics(model, data, pin.neutral(model))
    for element in document.section("equality"):
        if not document.is_true(element, "active", True):
            continue
        if element.tag == "joint":
            continue
        if element.tag not in ("connect", "weld"):
            raise document.wrong(
                f"equality: an active {described(element)} is not read; only connect, weld and "
                "joint are"
            )
        (body1, place1), (body2, place2) = _places(document, plain, element)
        first, second = (
            model.frames[model.getFrameId(body, pin.FrameType.BODY)] for body in (body1, body2)
        )
        if first.parentJoint == second.parentJoint:
            raise document.wrong(
                f"equality: {described(element)} joins {body1!r} and {body2!r}, which do not "
                "move against each other"
            )
        if place1 is None:
            place1 = _of_body(data, first).actInv(_of_body(data, second) * place2)
        elif place2 is None:
            place2 = _of_body(data, second).actInv(_of_body(data, first) * place1)
        kind = "3d" if element.tag == "connect" else "6d"
        ends = (
            (first.parentJoint, first.placement * place1),
            (second.parentJoint, second.placement * place2),
        )
        closures.append(rigid_constraint(model, kind, *ends))
        closures[-1].name = element.get("name") or f"{body1}-{body2}"
    return closures


def _of_body(data: pin.Data, frame: Any) -> pin.SE3:
    return data.oMi[frame.parentJoint] * frame.placement


def _places(
    document: MjcfDocument, plain: PlainMjcf, element: ElementTree.Element
) -> list[tuple[str, pin.SE3 | None]]:
    """Return the two bodies of a loop and where it joins each.

    None stands for the place of the other body in the reference pose.
    """
    where = f"equality: {described(element)}"
    if element.get("site1") is not None or element.get("site2") is not None:
        for end in ("site1", "site2"):
            if element.get(end) not in plain.sites:
                raise document.wrong(f"{where}: {end} {element.get(end)!r} is not in the file")
        return [plain.sites[element.attrib[end]] for end in ("site1", "site2")]
    bodies = [element.get("body1", ""), element.get("body2", "world")]
    for end, body in zip(("body1", "body2"), bodies, strict=True):
        if body not in plain.bodies:
            raise document.wrong(
                f"{where}: {end} {body!r} is not in the file; its bodies are "
                f"{', '.join(plain.bodies)}"
            )
    anchor = pin.SE3(np.eye(3), document.vector(element, "anchor"))
    if element.tag == "connect":
        if element.get("anchor") is None:
            raise document.wrong(f"{where} lacks anchor")
        return [(bodies[0], anchor), (bodies[1], None)]
    pose = document.numbers(element, "relpose", 7)
    if pose is None or not pose[3:].any():
        return [(bodies[0], None), (bodies[1], anchor)]
    w, x, y, z = pose[3:] / np.linalg.norm(pose[3:])
    # As in MuJoCo's code, the position is that of the anchor in the first body, not of the second
    # body.
    return [(bodies[0], pin.SE3(pin.Quaternion(w, x, y, z), pose[:3])), (bodies[1], anchor)]


# Key frames


def _home(document: MjcfDocument, plain: PlainMjcf, model: pin.Model) -> Array | None:
    """Put the named key frames into the model, and return the one named home."""
    for key in document.section("keyframe"):
        positions = document.numbers(key, "qpos")
        if positions is None or not key.get("name"):
            continue
        widths = {"hinge": 1, "slide": 1, "ball": 4, "free": 7}
        needed = sum(widths[joint.kind] for joint in plain.joints)
        if positions.size != needed:
            raise document.wrong(
                f"{described(key)}: qpos must hold {needed} numbers, got {positions.size}"
            )
        q = pin.neutral(model)
        ends = np.cumsum([widths[joint.kind] for joint in plain.joints])
        for item, part in zip(plain.joints, np.split(positions, ends[:-1]), strict=True):
            if not model.existJointName(item.name):
                # The joint was removed, or replaced by two.
                continue
            joint = model.joints[model.getJointId(item.name)]
            q[joint.idx_q : joint.idx_q + joint.nq] = _coordinates(document, item, part, joint.nq)
        set_reference_configuration(model, key.attrib["name"], q)
    poses = {item.key(): np.array(item.data()) for item in model.referenceConfigurations}
    return poses.get("home")


def _coordinates(document: MjcfDocument, joint: MjcfJoint, position: Array, count: int) -> Array:
    """Return Pinocchio's ``count`` coordinates of a joint from MuJoCo's."""
    if joint.kind in ("hinge", "slide"):
        turned = position - joint.reference
        # The pose of a hinge that stands for a ball is a rotation about the axis of the hinge.
        return (
            turned
            if count == 1
            else np.asarray(pin.Quaternion(pin.AngleAxis(float(turned[0]), joint.axis)).coeffs())
        )
    w, x, y, z = position[-4:]
    if not np.any(position[-4:]):
        raise document.wrong(f"a key frame gives joint {joint.name!r} a quaternion of zeros")
    turn = pin.Quaternion(w, x, y, z).normalized()
    if joint.kind == "ball":
        return np.asarray(turn.coeffs())
    # MuJoCo's pose is relative to the world, Pinocchio's to the place of the body in the file.
    return np.asarray(pin.SE3ToXYZQUAT(joint.placement.actInv(pin.SE3(turn, position[:3]))))


def _warn(document: MjcfDocument, plain: PlainMjcf) -> None:
    ignored = [
        f"spring of joint {joint.name}"
        for joint in plain.joints
        if joint.stiffness != 0.0 and joint.kind in ("ball", "free")
    ]
    ignored += [
        f"tendon {element.get('name', '')}".strip()
        for element in document.section("tendon")
        if element.tag != "fixed"
        or any(element.get(key) for key in ("stiffness", "damping", "frictionloss"))
    ]
    ignored += [
        f"buoyancy of body {body.get('name')}"
        for body in document.root.iter("body")
        if document.number(body, "gravcomp", 0.0) != 0.0
    ]
    for option in document.root.findall("option"):
        ignored += [
            f"fluid ({name})"
            for name in ("density", "viscosity")
            if document.number(option, name, 0.0) != 0.0
        ]
    if ignored:
        logger.warning(
            "%s: forces that the equation of motion does not know: %s",
            document.path,
            ", ".join(ignored),
        )
    if document.unknown:
        logger.warning(
            "%s: no words of MJCF, and not read: %s", document.path, ", ".join(document.unknown)
        )
    for name in plain.from_outside:
        logger.warning(
            "%s: body %s, which MuJoCo lets its user move (mocap), stays where it is",
            document.path,
            name,
        )
    for name, reason in plain.unreadable.items():
        logger.warning(
            "%s: mesh %s cannot be read and is not drawn (%s)", document.path, name, reason
        )
