r"""Export of a robot to MJCF, the model format of MuJoCo.

The URDF remains the source. The MJCF is written from the robot in memory, for MuJoCo or Pinocchio
to read.

* A joint becomes hinges, slides and balls on one body. If both engines have the same joint, its
  name and coordinate are the same; :func:`mujoco_state` converts the others.
* Closures become equalities, see :mod:`psp3.robots.mjcf_equalities`. MuJoCo's constraints are
  springs; :data:`HARD` makes them as stiff as the time step allows. ``docs/engines.md`` has
  measurements of the remaining compliance.
* A massless body, such as that between the two hinges of a universal joint, is merged with the body
  that it carries, because MuJoCo cannot move a massless body. Its frames and visuals are left out.
  Meshes and velocity limits are left out, too.
* MuJoCo refuses an inertia that no rigid body can have. For a body that never rotates the inertia
  has no effect, so a possible one is written instead. For any other body it is an error.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from psp3.checks import Array, checked_robot, one_row
from psp3.errors import MasslessBody, UnexportableJoint, UnphysicalInertia
from psp3.multibody.equations import Coupling
from psp3.robots.closed_loop_robot import ClosedLoopRobot
from psp3.robots.mjcf_equalities import add_equalities, add_motors, check_exportable

HARD = ((1e-6, 1.0), (0.9999, 0.9999, 0.001, 0.5, 2.0))
"""``solref`` and ``solimp`` of closures and of the ends of joints: a time constant that MuJoCo
raises to two time steps, its smallest stable value; critical damping; and the largest impedance
that it accepts.
"""

OPTION = {
    "timestep": "0.001",
    "integrator": "RK4",
    "solver": "Newton",
    "iterations": "100",
    "tolerance": "1e-12",
    "jacobian": "dense",
}
"""Settings of MuJoCo's solver. Its other integrators are of first order. With closures only,
Newton's method needs one iteration.
"""

LEAST = 1e-14
"""Smallest mass [kg] and moment of inertia [kg m²] that is written; MuJoCo refuses values below
1e-15.
"""

ROUNDING = 1e-12
"""Share of the largest moment by which rounding may violate a triangle inequality; such a violation
is corrected on any body.
"""

UNLIMITED = 1e10
"""A limit beyond this is no limit."""


class _Motion(NamedTuple):
    """A joint of MuJoCo, in the body's axes."""

    kind: str
    axis: Array
    anchor: Array
    limits: tuple[float, float]
    forces: dict[str, float]
    """Armature, damping, dry friction and spring, by MuJoCo's names; zeros are left out."""


class _Body(NamedTuple):
    """A body of MuJoCo.

    ``joint`` is the Pinocchio joint whose frame is that of the body, and ``parent`` is an index in
    the list of bodies. ``joints`` holds all joints that move it, each with its frame in the body in
    the neutral configuration. ``turns`` tells whether its orientation can change.
    """

    name: str
    joint: int
    parent: int
    placement: pin.SE3
    joints: list[tuple[int, pin.SE3]]
    turns: bool


def to_mjcf(robot: ClosedLoopRobot) -> str:
    """Return a robot as an MJCF document.

    The document contains gravity; masses; joints with limits, armature, damping, friction and
    springs; closures, couplings and held joints; a motor on every actuated joint or tendon, with
    the model's effort limit if it is positive; a site for every frame; primitive shapes of the
    visual model; and the keyframe ``home`` at ``robot.q0``.

    Parameters
    ----------
    robot : ClosedLoopRobot
        Any robot.

    Returns
    -------
    str
        The document, with all digits of the numbers. Bodies are in depth-first order.

    Raises
    ------
    UnphysicalInertia
        If a body that rotates has a moment of inertia greater than the sum of the other two.
    MasslessBody
        If a massless body carries a closure, or does not carry exactly one other body.
    UnexportableJoint
        If a joint is helical, is a ball with armature, or has too many degrees of freedom.
    InvalidValue
        If the spin of a ball joint is held whose body is not a body of revolution about it.
    """
    checked_robot(robot)
    model = robot.model
    check_exportable(robot)
    bodies = _tree(robot)
    root = ET.Element("mujoco", model=model.name or "robot")
    ET.SubElement(root, "compiler", angle="radian", autolimits="true", balanceinertia="false")
    option = ET.SubElement(root, "option", {"gravity": _text(model.gravity.linear)} | OPTION)
    ET.SubElement(option, "flag", contact="disable")
    # Shapes are only for display: they have no contacts and no mass.
    ET.SubElement(
        ET.SubElement(root, "default"), "geom", contype="0", conaffinity="0", group="1", density="0"
    )
    elements: list[ET.Element] = [ET.SubElement(root, "worldbody")]
    for body in bodies:
        # A floating body must be a child of the world: MuJoCo allows free joints only there.
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

    The two engines differ as follows. MuJoCo's bodies may be in another order. Its quaternions have
    the real part first. A joint of unlimited angle has an angle, not a cosine and a sine. The
    linear velocity of a free body is in the axes of its parent, not in its own, and its position is
    relative to the world if that is its parent.

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
                # Relative to the world, not to the body's place in the neutral pose.
                x = pin.SE3ToXYZQUAT(model.jointPlacements[number] * pin.XYZQUATToSE3(x))
            coordinates = _coordinates(np.asarray(x), rates, frame.rotation)
            qpos.append(coordinates[0])
            qvel.append(coordinates[1])
    return np.concatenate(qpos), np.concatenate(qvel)


def _coordinates(q: Array, v: Array, frame: Array) -> tuple[Array, Array]:
    # MuJoCo rotates a ball joint about the axes of the body, which are those of the joint rotated
    # by the frame.
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
    # Floating bodies are siblings of the base, so they come after all that the base carries.
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
                f"up to the next body with mass there are {freedom} degrees of freedom, more "
                "than 6",
            )
        placement, joints = pin.SE3.Identity(), []
        for number in reversed(chain):
            joints.append((number, placement.inverse()))
            # A composite joint has placements between its parts, which are not in its own
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

    These are its displacement M and its motion subspace S.
    """
    data = model.joints[number].createData()
    model.joints[number].calc(data, pin.neutral(model))
    return data


def _subspace(model: pin.Model, number: int) -> Array:
    """Motion subspace of a joint in the neutral configuration, (6, nv).

    The linear part is above the angular part, in the axes after the joint.
    """
    return np.array(_neutral(model, number).S).reshape(6, -1)


def _motions(robot: ClosedLoopRobot, number: int, frame: pin.SE3) -> Iterator[_Motion]:
    """Yield the joints of MuJoCo that make up a joint of Pinocchio, in the order in which they act.

    A joint is a chain of screws, each in the axes at the end of the chain, or ends in a ball. The
    robot has no other joints.
    """
    model, anchor = robot.model, frame.translation
    joint = model.joints[number]
    if "Planar" in joint.shortname():
        raise UnexportableJoint(
            str(model.names[number]), "it is planar, and its angle is a cosine and a sine"
        )
    ball = joint.nq > joint.nv and joint.nv >= 3
    if ball and model.armature[joint.idx_v : joint.idx_v + joint.nv].any():
        raise UnexportableJoint(str(model.names[number]), "it is a ball or free, and has armature")
    columns = _subspace(model, number).T
    for k, (linear, angular) in enumerate(
        columns.reshape(-1, 2, 3)[: joint.nv - 3 if ball else joint.nv]
    ):
        limits = (-np.inf, np.inf)
        # The coordinates of a joint of unlimited angle are a cosine and a sine, and its limits are
        # theirs.
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
        # MuJoCo has the same damping and friction for all three axes of a ball joint.
        forces = _forces(robot, number, joint.idx_v + joint.nv - 3)
        for other in range(joint.idx_v + joint.nv - 2, joint.idx_v + joint.nv):
            if _forces(robot, number, other) != forces:
                raise UnexportableJoint(
                    str(model.names[number]), "it is a ball with unequal damping or friction"
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
        # The world is not a body element of an MJCF.
        is_world = joint == 0 and frame.name == "world"
        if frame.parentJoint == joint and frame.type == pin.FrameType.BODY and not is_world:
            return str(frame.name)
    name = str(model.names[joint]) if joint else "base"
    while model.existFrame(name, pin.FrameType.BODY):
        name += "_"
    return name


# Elements of the document


def _text(numbers: ArrayLike) -> str:
    """Return numbers as text that preserves all bits, except for the sign of zero."""
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
        list(_motions(robot, number, frame))  # refuses bodies that MuJoCo cannot move
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
    """Return the effort limit of an actuated joint; None if the model has none."""
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
    """Write every frame as a site, except those of bodies and joints.

    The frame of a fixed joint before a link is also left out.
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
    """Return the sizes of a primitive shape for MuJoCo, which uses half lengths.

    Return None for any other shape.
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
