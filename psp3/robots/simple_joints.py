"""Replace joints by simpler ones, so that each coordinate is a single number with a name.

A ball joint has a quaternion, and none of its numbers is the spin about an axis. If this spin is to
be a coordinate, three hinges replace the ball joint: ``<ball>_swing`` and ``<ball>_tilt``, a
universal joint, and ``<ball>_spin`` about the axis. In the reference pose the tilt is zero. At a
tilt of 90°, swing and spin are the same motion, and the pose is singular.

A floating base in a loop keeps some of its motions, for example if the robot stands on a point of
its foot. To give these motions coordinates, slides ``<base>_x``, ``_y`` and ``_z`` and hinges
``<base>_yaw``, ``_pitch`` and ``_roll`` replace the free joint; they are singular at a pitch of
90°. A planar base is replaced by ``_x``, ``_y`` and ``_yaw``. The same is done for all floating
bodies except the first.

An angle that is stored as cosine and sine becomes a single number if it is a coordinate. A joint
that is a chain of joints, such as a universal joint or three sliding directions, becomes that
chain, ``<joint>_1``, ``<joint>_2``, ..., if a part of it is a coordinate or held.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin

from psp3.checks import Array
from psp3.closure.coordinates import bases, floating_base
from psp3.description.joint_replacement import (
    PER_DEGREE_OF_FREEDOM,
    POSITION_LIMITS,
    rebuilt,
    revolute_like,
)
from psp3.errors import UnsupportedJoint
from psp3.multibody.equations import Coupling, Hinge, Spin
from psp3.robots.pickling import constraints, plain


class SimpleTree(NamedTuple):
    """A tree in which simple joints replace others, and everything that refers to its joints."""

    model: pin.Model
    visual_model: Any
    constraint_models: list[Any]
    equations: list[Any]
    home: Array | None


SYMMETRIC = 1e-6
"""Share of its largest moment, and of its size, by which a spinning body may deviate from a body of
revolution; the axis of a spin is accurate to 1e-8.
"""


SAME_ORIGIN = 1e-12
"""Largest distance of the axes of a chain from the origin of its joint [m]."""


def is_round(model: pin.Model, spin: Spin) -> bool:
    """Tell whether the spinning body is a body of revolution, whose spin has no effect."""
    inertia, axis = model.inertias[spin.joint], spin.axis
    across = np.eye(3) - np.outer(axis, axis)
    moments = inertia.inertia
    round_one = 0.5 * np.trace(across @ moments) * across + (axis @ moments @ axis) * np.outer(
        axis, axis
    )
    off = np.abs(across @ inertia.lever).max()
    return bool(
        np.abs(moments - round_one).max() <= SYMMETRIC * np.abs(moments).max()
        and off <= SYMMETRIC * max(np.abs(inertia.lever).max(), 1e-3)
    )


def can_spin(model: pin.Model, spin: Spin) -> bool:
    """Tell whether a spin gets a coordinate: hinges can replace the ball, and it has an effect.

    Hinges cannot replace a ball joint with damping, friction or motor inertia.
    """
    if is_round(model, spin):
        return False
    joint = model.joints[spin.joint]
    own = slice(joint.idx_v, joint.idx_v + 3)
    parts = (model.damping, model.armature, model.upperDryFrictionLimit)
    return not any(np.asarray(part)[own].any() for part in parts)


def base_in_loop(model: pin.Model, closures: Sequence[Any]) -> int | None:
    """Return the joint of a base in a loop, or of a second floating base, or None."""
    free = floating_base(model, closures)
    return next((joint.id for joint in bases(model) if free is None or joint.id != free.id), None)


def parts_of_base(model: pin.Model, base: int) -> list[str]:
    """Return the joints that will replace a base, those of its angles first."""
    name, is_planar = str(model.names[base]), model.joints[base].nq == 4
    parts = ("yaw", "x", "y") if is_planar else ("yaw", "pitch", "roll", "x", "y", "z")
    return [f"{name}_{part}" for part in parts]


def of_several(model: pin.Model, speeds: Sequence[int], held: Sequence[int]) -> list[int]:
    """Return the joints of which a coordinate or a held motion is only a part."""
    found = []
    for joint in list(model.joints)[1:]:
        own = range(joint.idx_v, joint.idx_v + joint.nv)
        is_chain = joint.nq == joint.nv > 1 and any(v in own for v in (*speeds, *held))
        is_turning = (joint.nq, joint.nv) == (2, 1) and joint.idx_v in speeds
        if is_chain or is_turning:
            found.append(int(joint.id))
    return found


def with_simple_joints(
    tree: SimpleTree, spins: Sequence[Spin], base: int | None, chains: Sequence[int] = ()
) -> SimpleTree:
    """Return a tree with simple joints instead of spinning balls, a base and chains.

    Parameters
    ----------
    tree : SimpleTree
        The tree of a robot, with its home.
    spins : sequence of Spin
        The ball joints, each with its axis and the quaternion of the reference pose.
    base : int or None
        The joint of the base.
    chains : sequence of int
        Joints that are chains of others, or whose angle is stored as cosine and sine.

    Raises
    ------
    UnsupportedJoint
        If the joints of a chain do not have the same origin.
    """
    model, home = tree.model, tree.home
    assert home is not None
    replaced = {spin.name: _of_ball(spin) for spin in spins}
    if base is not None:
        replaced[str(model.names[base])] = _of_base(model, base, home)
    replaced |= {str(model.names[joint]): _of_chain(model, joint, home) for joint in chains}
    new_joints = {
        name: [(f"{name}_{part}" if part else name, joint) for part, joint, _ in parts]
        for name, parts in replaced.items()
    }
    new, shapes = rebuilt(model, tree.visual_model, new_joints, str(model.name))
    number, q = [0], np.zeros(new.nq)
    for name, joint in zip(list(model.names)[1:], list(model.joints)[1:], strict=True):
        if name in replaced:
            first = new.joints[new.getJointId(new_joints[name][0][0])]
            angles = [angle for _, _, angle in replaced[name]]
            q[first.idx_q : first.idx_q + len(angles)] = angles
            number.append(new.getJointId(new_joints[name][-1][0]))
        else:
            same = new.joints[new.getJointId(name)]
            q[same.idx_q : same.idx_q + same.nq] = home[joint.idx_q : joint.idx_q + joint.nq]
            number.append(same.id)
    for joint in chains:
        if model.joints[joint].nv > 1:
            first = new_joints[str(model.names[joint])][0][0]
            _as_before(model, joint, new, new.getJointId(first))
    loops = [
        one._replace(joints=(number[one.joints[0]], number[one.joints[1]]))
        for one in plain(tree.constraint_models)
    ]
    others = [_renumbered(one, number) for one in tree.equations]
    return SimpleTree(new, shapes, list(constraints(new, loops)), others, q)


def _of_base(model: pin.Model, base: int, home: Array) -> list[tuple[str, Any, float]]:
    """Return names, joints and coordinates of the replacement of a base."""
    joint = model.joints[base]
    x = home[joint.idx_q : joint.idx_q + joint.nq]
    if joint.nq == 4:
        angle = float(np.arctan2(x[3], x[2]))
        return [
            ("x", pin.JointModelPX(), float(x[0])),
            ("y", pin.JointModelPY(), float(x[1])),
            ("yaw", pin.JointModelRZ(), angle),
        ]
    roll, pitch, yaw = pin.rpy.matrixToRpy(pin.XYZQUATToSE3(x).rotation)
    kinds = (
        *(pin.JointModelPX(), pin.JointModelPY(), pin.JointModelPZ()),
        *(pin.JointModelRZ(), pin.JointModelRY(), pin.JointModelRX()),
    )
    names = ("x", "y", "z", "yaw", "pitch", "roll")
    return list(zip(names, kinds, map(float, (*x[:3], yaw, pitch, roll)), strict=True))


def _of_chain(model: pin.Model, number: int, home: Array) -> list[tuple[str, Any, float]]:
    """Return names, joints and coordinates of a chain, or of an angle in two coordinates."""
    joint = model.joints[number]
    x = home[joint.idx_q : joint.idx_q + joint.nq]
    if joint.nv == 1:
        return [("", revolute_like(joint), float(np.arctan2(x[1], x[0])))]
    jacobian = pin.computeJointJacobian(model, model.createData(), pin.neutral(model), number)
    screws = jacobian.reshape(6, model.nv)[:, joint.idx_v : joint.idx_v + joint.nv].T
    name = str(model.names[number])
    return [
        (str(k), _along(name, joint, screw), float(value))
        for k, (screw, value) in enumerate(zip(screws, x, strict=True), start=1)
    ]


def _along(name: str, joint: Any, screw: Array) -> Any:
    """Return the joint of one screw through the origin."""
    slide, turn = screw[:3], screw[3:]
    if not turn.any():
        return pin.JointModelPrismaticUnaligned(slide)
    pitch = float(slide @ turn)
    if np.abs(slide - pitch * turn).max() > SAME_ORIGIN:
        raise UnsupportedJoint(name, joint.shortname())
    if abs(pitch) > SAME_ORIGIN:
        return pin.JointModelHelicalUnaligned(turn, pitch)
    return pin.JointModelRevoluteUnaligned(turn)


def _as_before(model: pin.Model, old: int, new: pin.Model, first: int) -> None:
    """Copy limits, damping and friction of each degree of freedom of a joint to its chain."""
    before, after = model.joints[old], new.joints[first]
    for attributes, places, nows, count in (
        (PER_DEGREE_OF_FREEDOM, before.idx_v, after.idx_v, before.nv),
        (POSITION_LIMITS, before.idx_q, after.idx_q, before.nq),
    ):
        for attribute in attributes:
            values = getattr(model, attribute)[places : places + count]
            getattr(new, attribute)[nows : nows + count] = values


def _of_ball(spin: Spin) -> list[tuple[str, Any, float]]:
    """Return names, joints and angles of the replacement of a ball joint."""
    axes, angles = _axes(spin)
    kinds = (pin.JointModelRevoluteUnaligned(axis) for axis in axes)
    return list(zip(("swing", "tilt", "spin"), kinds, map(float, angles), strict=True))


def _axes(spin: Spin) -> tuple[tuple[Array, Array, Array], Array]:
    """Return the axes of swing, tilt and spin, and their angles in the reference pose."""
    turn = pin.Quaternion(np.asarray(spin.quaternion)).normalized().toRotationMatrix()
    axis = spin.axis / np.linalg.norm(spin.axis)
    turned = turn @ axis
    swing = np.cross(axis, turned)
    if np.linalg.norm(swing) < 1e-6:
        swing = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
    swing /= np.linalg.norm(swing)
    angle = float(np.arctan2(swing @ np.cross(axis, turned), axis @ turned))
    rest = pin.exp3(angle * swing).T @ turn
    spun = float(axis @ pin.log3(rest))
    return (swing, np.cross(axis, swing), axis), np.array([angle, 0.0, spun])


def _renumbered(one: Any, number: Sequence[int]) -> Any:
    if isinstance(one, Hinge):
        return one._replace(joint1_id=number[one.joint1_id], joint2_id=number[one.joint2_id])
    if isinstance(one, Coupling):
        return one._replace(y=number[one.y], x=number[one.x])
    return one._replace(joint=number[one.joint])
