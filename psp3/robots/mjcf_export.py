r"""Export of a robot to MJCF, the model format of MuJoCo.

The URDF stays the source: an MJCF is written from the robot as it is in memory, and read by MuJoCo,
or by Pinocchio again.

* A joint becomes hinges, slides and balls on one body. Where both engines have the same joint, name
  and coordinate are the same; :func:`mujoco_state` translates the others.
* Closures become equalities, see :mod:`psp3.robots.mjcf_equalities`. MuJoCo's constraints are
  springs; :data:`HARD` makes them as stiff as the time step allows. How far that is from rigid is
  measured in ``docs/engines.md``.
* A body without mass, as between the two hinges of a universal joint, is joined with the one that
  it carries, because MuJoCo moves no body without mass. Frames and visuals on it are left out, as
  are meshes and limits of velocity.
* An inertia that no rigid body can have is refused by MuJoCo. On a body that never turns it has no
  effect, so another one is written there; anywhere else it is an error.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from psp3.checks import (
    Array,
    checked_robot,
    one_row,
)
from psp3.errors import MasslessBody, UnexportableJoint, UnphysicalInertia
from psp3.multibody.equations import Coupling
from psp3.robots.closed_loop_robot import ClosedLoopRobot
from psp3.robots.mjcf_equalities import add_equalities, add_motors, check_exportable

HARD = ((1e-6, 1.0), (0.9999, 0.9999, 0.001, 0.5, 2.0))
"""``solref`` and ``solimp`` of closures and of the ends of joints: a time constant that MuJoCo
raises to two time steps, its smallest stable one, critically damped, and the largest impedance that
it takes.
"""

OPTION = {
    "timestep": "0.001",
    "integrator": "RK4",
    "solver": "Newton",
    "iterations": "100",
    "tolerance": "1e-12",
    "jacobian": "dense",
}
"""Settings of MuJoCo's solver. Its other integrators are of first order; with closures only,
Newton's method takes one iteration.
"""

LEAST = 1e-14
"""Smallest mass [kg] and moment of inertia [kg m²] that is written; MuJoCo refuses what is below
1e-15.
"""

ROUNDING = 1e-12
"""Part of the largest moment by which a triangle inequality may be off through rounding; so much is
put right on any body.
"""

UNLIMITED = 1e10
"""Limits beyond this are none."""


class _Motion(NamedTuple):
    """A joint of MuJoCo, in the body's axes."""

    kind: str
    axis: Array
    anchor: Array
    limits: tuple[float, float]
    forces: dict[str, float]
    """Armature, damping, dry friction and spring, by MuJoCo's names; what is zero is left out."""


class _Body(NamedTuple):
    """A body of MuJoCo.

    ``joint`` is the joint of Pinocchio whose frame is the body's, ``parent`` a place in the list of
    bodies, ``joints`` holds all joints that move it, each with its frame in the body in the neutral
    configuration, and ``turns`` says whether its orientation can change.
    """

    name: str
    joint: int
    parent: int
    placement: pin.SE3
    joints: list[tuple[int, pin.SE3]]
    turns: bool


def to_mjcf(robot: ClosedLoopRobot) -> str:
    """Return a robot as an MJCF document.

    Gravity, masses, joints with limits, armature, damping, friction and springs, closures,
    couplings, joints that are held, a motor on every actuated joint with the model's effort limit
    (none where that is not positive) or tendon, a site for every frame, primitive shapes of the
    visual model, and the keyframe ``home`` at ``robot.q0``.

    Parameters
    ----------
    robot : ClosedLoopRobot
        Any robot.

    Returns
    -------
    str
        The document, with all numbers to the last digit. Bodies come in depth-first order.

    Raises
    ------
    UnphysicalInertia
        If a body that turns has a moment of inertia that exceeds the sum of the other two.
    MasslessBody
        If a body without mass carries a closure, no other body or more than one.
    UnexportableJoint
        If a joint is helical, is a ball with armature, or has too many degrees of freedom.
    InvalidValue
        If the spin of a ball is held whose body is not one of revolution about it.
    """
    checked_robot(robot)
    model = robot.model
    check_exportable(robot)
    bodies = _tree(robot)
    root = ET.Element("mujoco", model=model.name or "robot")
    ET.SubElement(root, "compiler", angle="radian", autolimits="true", balanceinertia="false")
    option = ET.SubElement(root, "option", {"gravity": _text(model.gravity.linear)} | OPTION)
    ET.SubElement(option, "flag", contact="disable")
    # Shapes are looked at only: they touch nothing and weigh nothing.
    ET.SubElement(
        ET.SubElement(root, "default"), "geom", contype="0", conaffinity="0", group="1", density="0"
    )
    elements: list[ET.Element] = [ET.SubElement(root, "worldbody")]
    for body in bodies:
        # A body that floats is the world's own: no other may have a free joint in MuJoCo.
        floats = _floating(model, body)
        elements.append(_body_element(robot, body, elements[0 if floats else body.parent + 1]))
    at_joint = dict(zip((body.joint for body in bodies), elements[1:], strict=True))
    _add_frames(model, at_joint)
    add_equalities(robot, root, at_joint, _hard("solref", "solimp"), _text)
    _add_visuals(robot, at_joint)
    joints = set(model.names)
    limits = {name: _effort(model, name) for name in robot.actuated if name in joints}
    add_motors(robot, root, limits, _text)
    position, _ = mujoco_state(robot, robot.q0)
    ET.SubElement(ET.SubElement(root, "keyframe"), "key", name="home", qpos=_text(position))
    ET.indent(root)
    return ET.tostring(root, encoding="unicode") + "\n"


def mujoco_state(
    robot: ClosedLoopRobot, q: ArrayLike, v: ArrayLike | None = None
) -> tuple[Array, Array]:
    """Return a state in the coordinates of MuJoCo, for the model that :func:`to_mjcf` writes.

    Bodies may come in another order; quaternions have their real part first; what turns without end
    is an angle, not a cosine and a sine; a free body has its linear velocity in the axes of its
    parent, not in its own, and is counted from the world if that is its parent.

    Parameters
    ----------
    robot : ClosedLoopRobot
        The robot.
    q : (nq,) array_like
        Pinocchio configuration.
    v : (nv,) array_like, optional
        Pinocchio velocity, zero by default.

    Returns
    -------
    qpos, qvel : ndarray
        Position and velocity in MuJoCo.

    Raises
    ------
    InvalidArray
        If q or v is not finite or of another shape.
    """
    model = robot.model
    position = one_row("q", q, model.nq)
    velocity = np.zeros(model.nv) if v is None else one_row("v", v, model.nv)
    qpos, qvel = [np.zeros(0)], [np.zeros(0)]
    for body in _tree(robot):
        for number, frame in body.joints:
            joint = model.joints[number]
            x = position[joint.idx_q : joint.idx_q + joint.nq]
            rates = velocity[joint.idx_v : joint.idx_v + joint.nv]
            if _floating(model, body):
                # Counted from the world, not from where the body stands in the neutral pose.
                x = pin.SE3ToXYZQUAT(model.jointPlacements[number] * pin.XYZQUATToSE3(x))
            coordinates = _coordinates(np.asarray(x), rates, frame.rotation)
            qpos.append(coordinates[0])
            qvel.append(coordinates[1])
    return np.concatenate(qpos), np.concatenate(qvel)


def _coordinates(q: Array, v: Array, frame: Array) -> tuple[Array, Array]:
    # MuJoCo turns a ball about the axes of the body, which are those of the joint turned by the
    # frame.
    match q.size, v.size:
        case 7, 6:
            rotation = pin.Quaternion(q[3:]).toRotationMatrix()
            return np.concatenate([q[:3], q[6:], frame @ q[3:6]]), np.concatenate(
                [rotation @ v[:3], frame @ v[3:]]
            )
        case 4, 3:
            return np.concatenate([q[3:], frame @ q[:3]]), frame @ v
        case 2, 1:
            return np.array([np.arctan2(q[1], q[0])]), v
    return q, v


# From Pinocchio's tree to bodies with several joints


def _tree(robot: ClosedLoopRobot) -> list[_Body]:
    """Return the bodies in depth-first order, a parent before its children.

    The first is the base, which does not move.
    """
    model = robot.model
    children: list[list[int]] = [[] for _ in range(model.njoints)]
    for joint in range(1, model.njoints):
        children[model.parents[joint]].append(joint)
    closed = {
        joint
        for closure in [*robot.constraint_models, *robot.equations]
        if not isinstance(closure, Coupling)
        for joint in (closure.joint1_id, closure.joint2_id)
    }
    bodies = [_Body(_body_name(model, 0), 0, -1, pin.SE3.Identity(), [], False)]
    # What floats stands beside the base, and so comes after all that the base carries.
    roots = sorted(
        children[0], key=lambda joint: _is_free(model, joint) and _has_mass(model, joint)
    )
    waiting: list[tuple[int, int, list[int]]] = [(joint, 0, []) for joint in reversed(roots)]
    while waiting:
        joint, parent, carriers = waiting.pop()
        chain = [*carriers, joint]
        if not _has_mass(model, joint):
            if joint in closed or len(children[joint]) != 1:
                raise MasslessBody(_body_name(model, joint), joint in closed, len(children[joint]))
            waiting.append((children[joint][0], parent, chain))
            continue
        freedom = sum(model.joints[number].nv for number in chain)
        if freedom > 6:
            raise UnexportableJoint(
                model.names[joint],
                f"up to the next body with mass there are {freedom} degrees of freedom, not 6 at "
                "most",
            )
        placement, joints = pin.SE3.Identity(), []
        for number in reversed(chain):
            joints.append((number, placement.inverse()))
            # A joint composed of others has places between these, which are no part of its own
            # placement.
            placement = model.jointPlacements[number] * _neutral(model, number).M * placement
        turns = bodies[parent].turns or any(
            bool(_subspace(model, number)[3:].any()) for number in chain
        )
        bodies.append(
            _Body(_body_name(model, joint), joint, parent, placement, joints[::-1], turns)
        )
        waiting.extend((child, len(bodies) - 1, []) for child in reversed(children[joint]))
    return bodies


def _floating(model: pin.Model, body: _Body) -> bool:
    """Tell whether a body is free in the world by one joint."""
    if len(body.joints) != 1 or body.parent != 0:
        return False
    return _is_free(model, body.joints[0][0])


def _is_free(model: pin.Model, joint: int) -> bool:
    return "FreeFlyer" in str(model.joints[joint].shortname())


def _has_mass(model: pin.Model, joint: int) -> bool:
    inertia = model.inertias[joint]
    return bool(inertia.mass >= LEAST or np.abs(inertia.inertia).max() >= LEAST)


def _neutral(model: pin.Model, number: int) -> Any:
    """Return what Pinocchio computes of a joint in the neutral configuration.

    Its displacement M and its motion subspace S.
    """
    data = model.joints[number].createData()
    model.joints[number].calc(data, pin.neutral(model))
    return data


def _subspace(model: pin.Model, number: int) -> Array:
    """Motion subspace of a joint in the neutral configuration, (6, nv).

    Linear above angular, in the axes behind the joint.
    """
    return np.array(_neutral(model, number).S).reshape(6, -1)


def _motions(robot: ClosedLoopRobot, number: int, frame: pin.SE3) -> Iterator[_Motion]:
    """Yield the joints of MuJoCo that make up a joint of Pinocchio, in the order in which they act.

    A joint is a chain of screws, each seen from the end of the chain, or ends in a ball; the robot
    has no others.
    """
    model, anchor = robot.model, frame.translation
    joint = model.joints[number]
    if "Planar" in joint.shortname():
        raise UnexportableJoint(
            str(model.names[number]), "it is planar, of which the angle is a cosine and a sine"
        )
    ball = joint.nq > joint.nv and joint.nv >= 3
    if ball and model.armature[joint.idx_v : joint.idx_v + joint.nv].any():
        raise UnexportableJoint(str(model.names[number]), "it is a ball or free, and has armature")
    columns = _subspace(model, number).T
    for k, (linear, angular) in enumerate(
        columns.reshape(-1, 2, 3)[: joint.nv - 3 if ball else joint.nv]
    ):
        limits = (-np.inf, np.inf)
        # The coordinates of what turns without end are a cosine and a sine, and its limits theirs.
        if joint.nq == joint.nv or ball:
            limits = (
                float(model.lowerPositionLimit[joint.idx_q + k]),
                float(model.upperPositionLimit[joint.idx_q + k]),
            )
        forces = _forces(robot, number, joint.idx_v + k)
        if not angular.any():
            yield _Motion("slide", frame.rotation @ linear, anchor, limits, forces)
        elif abs(angular @ linear) > ROUNDING:
            raise UnexportableJoint(
                str(model.names[number]), f"it turns and slides at once ({joint.shortname()})"
            )
        else:
            yield _Motion(
                "hinge",
                frame.rotation @ angular,
                frame.act(np.cross(angular, linear)),
                limits,
                forces,
            )
    if ball:
        # MuJoCo brakes the three directions of a ball alike.
        forces = _forces(robot, number, joint.idx_v + joint.nv - 3)
        for other in range(joint.idx_v + joint.nv - 2, joint.idx_v + joint.nv):
            if _forces(robot, number, other) != forces:
                raise UnexportableJoint(
                    str(model.names[number]), "it is a ball that its directions brake unequally"
                )
        yield _Motion("ball", np.zeros(3), anchor, (-np.inf, np.inf), forces)


def _forces(robot: ClosedLoopRobot, number: int, velocity: int) -> dict[str, float]:
    """Return the numbers of a velocity's own forces, by MuJoCo's names."""
    model = robot.model
    stiffness, rest = (robot.options["springs"] or {}).get(str(model.names[number]), (0.0, 0.0))
    found = {
        "armature": float(model.armature[velocity]),
        "damping": float(model.damping[velocity]),
        "frictionloss": float(model.upperDryFrictionLimit[velocity]),
        "stiffness": float(stiffness),
        "springref": float(rest),
    }
    return {name: value for name, value in found.items() if value != 0.0}


def _body_name(model: pin.Model, joint: int) -> str:
    for frame in model.frames:
        # The world of an MJCF is no body of it.
        is_world = joint == 0 and frame.name == "world"
        if frame.parentJoint == joint and frame.type == pin.FrameType.BODY and not is_world:
            return str(frame.name)
    name = str(model.names[joint]) if joint else "base"
    while model.existFrame(name, pin.FrameType.BODY):
        name += "_"
    return name


# Elements of the document


def _text(numbers: ArrayLike) -> str:
    """Numbers as they are read back to the last bit, the sign of zero left out."""
    return " ".join(
        repr(float(number) + 0.0).removesuffix(".0")
        for number in np.asarray(numbers, dtype=float).ravel()
    )


def _hard(*names: str) -> dict[str, str]:
    return dict(zip(names, map(_text, HARD), strict=True))


def _placed(placement: pin.SE3) -> dict[str, str]:
    x, y, z, w = pin.Quaternion(placement.rotation).coeffs()
    return {"pos": _text(placement.translation), "quat": _text([w, x, y, z])}


def _body_element(robot: ClosedLoopRobot, body: _Body, parent: ET.Element) -> ET.Element:
    model = robot.model
    element = ET.SubElement(parent, "body", {"name": body.name} | _placed(body.placement))
    if body.joint == 0:
        return element
    element.append(_inertial(body, model.inertias[body.joint]))
    if _floating(model, body):
        (number, frame) = body.joints[0]
        list(_motions(robot, number, frame))  # refuses what MuJoCo cannot move
        ET.SubElement(element, "freejoint", name=str(model.names[number]))
        return element
    for number, frame in body.joints:
        name, motions = str(model.names[number]), list(_motions(robot, number, frame))
        for place, motion in enumerate(motions, start=1):
            joint = ET.SubElement(
                element,
                "joint",
                name=name if len(motions) == 1 else f"{name}_{place}",
                type=motion.kind,
            )
            joint.set("pos", _text(motion.anchor))
            if motion.kind != "ball":
                joint.set("axis", _text(motion.axis))
            if min(abs(limit) for limit in motion.limits) < UNLIMITED:
                joint.attrib |= {
                    "range": _text(np.clip(motion.limits, -UNLIMITED, UNLIMITED))
                } | _hard("solreflimit", "solimplimit")
            joint.attrib |= {key: _text(value) for key, value in motion.forces.items()}
            if name in robot.actuated and (limit := _effort(model, name)):
                joint.set("actuatorfrcrange", _text([-limit, limit]))
    return element


def _effort(model: pin.Model, name: str) -> float | None:
    """Effort limit of an actuated joint, None where the model has none."""
    limit = float(model.upperEffortLimit[model.joints[model.getJointId(name)].idx_v])
    return limit if 0.0 < limit < UNLIMITED else None


def _inertial(body: _Body, inertia: pin.Inertia) -> ET.Element:
    moments, axes = np.diag(inertia.inertia), np.eye(3)
    if np.any(inertia.inertia != np.diag(moments)):
        moments, axes = np.linalg.eigh(inertia.inertia)
    largest = moments.max()
    missing = 2.0 * largest - moments.sum()
    if missing > ROUNDING * max(largest, LEAST):
        if body.turns:
            raise UnphysicalInertia(body.name, moments)
        moments = np.full(3, moments.mean())
    elif missing > 0.0:
        moments = moments + missing + 4.0 * np.spacing(largest)
    moments = np.maximum(moments, LEAST)
    if np.linalg.det(axes) < 0.0:
        axes = -axes
    placement = pin.SE3(axes, inertia.lever)
    return ET.Element(
        "inertial",
        {"mass": _text(max(inertia.mass, LEAST)), "diaginertia": _text(moments)}
        | _placed(placement),
    )


def _add_frames(model: pin.Model, at_joint: dict[int, ET.Element]) -> None:
    """Write every frame as a site, but for bodies and joints.

    Nor is the joint behind a link that is fixed.
    """
    taken = {element.get("name") for element in at_joint.values()}
    for frame in model.frames:
        element = at_joint.get(frame.parentJoint)
        if (
            element is None
            or frame.type in (pin.FrameType.JOINT, pin.FrameType.FIXED_JOINT)
            or frame.name in taken
        ):
            continue
        taken.add(frame.name)
        ET.SubElement(
            element, "site", {"name": frame.name, "group": "4"} | _placed(frame.placement)
        )


def _add_visuals(robot: ClosedLoopRobot, at_joint: dict[int, ET.Element]) -> None:
    for item in robot.visual_model.geometryObjects:
        size = _size(item.geometry)
        if size is not None and item.parentJoint in at_joint:
            attributes = {
                "name": item.name,
                "type": type(item.geometry).__name__.lower(),
                "size": _text(size),
            }
            ET.SubElement(
                at_joint[item.parentJoint],
                "geom",
                attributes | _placed(item.placement) | {"rgba": _text(item.meshColor)},
            )


def _size(shape: Any) -> ArrayLike | None:
    """Sizes of a primitive shape as MuJoCo has them, halves where others have wholes.

    None for any other.
    """
    match type(shape).__name__:
        case "Box":
            return np.array(shape.halfSide)
        case "Sphere":
            return [shape.radius]
        case "Cylinder" | "Capsule":
            return [shape.radius, shape.halfLength]
        case "Ellipsoid":
            return np.array(shape.radii)
    return None
