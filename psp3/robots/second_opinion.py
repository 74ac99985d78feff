"""Compare a robot with what MuJoCo reads from the same file.

MuJoCo compiles an MJCF file, see :mod:`psp3.description.mujoco_opinion`. It reads a URDF as a tree,
and the masses, mass matrix and bias forces of the tree are compared joint by joint, at a few poses
away from the zero pose. Shapes and everything that only shapes need are left out.
"""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin

from psp3.checks import Array
from psp3.description.mujoco_opinion import AGREEMENT, REFUSED, mujoco_disagreements
from psp3.description.xml import read_xml
from psp3.errors import MissingPackage
from psp3.robots.closed_loop_robot import ClosedLoopRobot

POSES = 3
"""Number of poses that are compared."""

BOUND = 2e-15
"""Mass and inertia of massless bodies in MuJoCo, which accepts no smaller ones [kg, kg m²]."""

LEAST = 1e-7
"""A smaller mass or inertia is negligible [kg, kg m²]. Relative to this, even many bodies with
:data:`BOUND` are below :data:`AGREEMENT`.
"""

MOST_SHOWN = 3
"""The largest number of disagreements in a message."""


class Opinion(NamedTuple):
    """Result of the comparison with MuJoCo."""

    summary: str
    """A summary; empty if MuJoCo cannot read the robot's file."""
    disagreements: tuple[str, ...]


def mujoco_opinion(robot: ClosedLoopRobot) -> Opinion:
    """Compare a robot with what MuJoCo reads from its file.

    Parameters
    ----------
    robot : ClosedLoopRobot
        The robot, loaded from a URDF or an MJCF file.

    Returns
    -------
    Opinion
        The agreement of both, their disagreements, why MuJoCo refuses the file, or a note that
        MuJoCo is not installed.
    """
    if robot.mjcf is None and robot.urdf is None:
        return Opinion("", ())
    try:
        if robot.mjcf is not None:
            return _of_mjcf(robot.mjcf)
        return _of_urdf(robot, Path(str(robot.urdf)))
    except MissingPackage:
        return Opinion("not installed", ())


def _of_mjcf(path: Path) -> Opinion:
    disagreements = mujoco_disagreements(path)
    if disagreements and disagreements[0].what == REFUSED:
        return _refusal(disagreements[0].theirs)
    return _summed_up(list(map(str, disagreements)), AGREEMENT)


def _refusal(reason: str) -> Opinion:
    """Return the opinion on a file that MuJoCo refuses, of which no number can be compared."""
    return Opinion(f"refuses the file: {' '.join(reason.split())}", ())


def _summed_up(disagreements: list[str], most: float) -> Opinion:
    if not disagreements:
        return Opinion(f"agrees to {max(most, 1e-15):.0e}", ())
    shown = disagreements[:MOST_SHOWN]
    if len(disagreements) > MOST_SHOWN:
        shown.append(f"{len(disagreements) - MOST_SHOWN} more")
    return Opinion(f"disagrees: {'; '.join(shown)}", tuple(disagreements))


def _of_urdf(robot: ClosedLoopRobot, path: Path) -> Opinion:
    try:
        import mujoco
    except ImportError as error:
        raise MissingPackage("mujoco", "mujoco", error) from error
    try:
        engine = mujoco.MjModel.from_xml_string(without_shapes(path))
    except ValueError as error:
        return _refusal(str(error))
    joints = _common_joints(robot.model, engine)
    if not joints:
        return Opinion("knows none of the joints by name", ())
    compared = [*_masses(robot.model, engine, joints), *_motions(robot.model, engine, joints)]
    wrong = [one for one in compared if not one.share <= AGREEMENT]
    return _summed_up(list(map(str, wrong)), max(one.share for one in compared))


def without_shapes(path: Path) -> str:
    """Return a URDF without its shapes, so that MuJoCo needs no file of a mesh."""
    root = read_xml(path, "robot")
    for link in root.iter("link"):
        for shape in [*link.findall("visual"), *link.findall("collision")]:
            link.remove(shape)
    extension = root.find("mujoco")
    if extension is None:
        extension = ElementTree.SubElement(root, "mujoco")
    compiler = extension.find("compiler")
    if compiler is None:
        compiler = ElementTree.SubElement(extension, "compiler")
    compiler.set("fusestatic", "false")
    # Massless bodies between two joints are allowed in this package, but an error in MuJoCo.
    for bound in ("boundmass", "boundinertia"):
        compiler.set(bound, compiler.get(bound, str(BOUND)))
    return ElementTree.tostring(root, encoding="unicode")


class _Compared(NamedTuple):
    """A number as both readers have it."""

    what: str
    joint: str
    ours: float
    theirs: float
    scale: float

    @property
    def share(self) -> float:
        return abs(self.ours - self.theirs) / max(self.scale, LEAST)

    def __str__(self) -> str:
        return f"{self.what} {self.joint}: {self.ours:.6g} here, {self.theirs:.6g} by MuJoCo"


class _Joint(NamedTuple):
    """A joint of one degree of freedom that both have."""

    name: str
    ours: int
    """Its number in Pinocchio's model."""
    body: int
    """The body that it moves in MuJoCo's model."""
    velocity: int
    """Index of its speed in MuJoCo's model."""


def _common_joints(model: pin.Model, engine: Any) -> list[_Joint]:
    import mujoco

    scalar = {int(kind) for kind in (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE)}
    found = []
    for number in range(engine.njnt):
        name = mujoco.mj_id2name(engine, mujoco.mjtObj.mjOBJ_JOINT, number)
        is_scalar = int(engine.jnt_type[number]) in scalar
        if name and is_scalar and model.existJointName(name):
            joint = model.getJointId(name)
            if model.joints[joint].nv == 1:
                body, velocity = int(engine.jnt_bodyid[number]), int(engine.jnt_dofadr[number])
                found.append(_Joint(name, joint, body, velocity))
    return found


def _masses(model: pin.Model, engine: Any, joints: list[_Joint]) -> list[_Compared]:
    """Compare the total mass that each joint carries."""
    data = model.createData()
    pin.computeSubtreeMasses(model, data)
    return [
        _Compared(
            "the mass that hangs on",
            joint.name,
            float(data.mass[joint.ours]),
            float(engine.body_subtreemass[joint.body]),
            float(engine.body_subtreemass[joint.body]),
        )
        for joint in joints
    ]


def _motions(model: pin.Model, engine: Any, joints: list[_Joint]) -> list[_Compared]:
    """Compare mass matrix and bias forces of the tree at a few poses.

    Joints that only one reader has rest at zero, where they do not affect the others.
    """
    import mujoco

    data, rng, found = mujoco.MjData(engine), np.random.default_rng(0), []
    ours = [model.joints[joint.ours].idx_v for joint in joints]
    theirs = [joint.velocity for joint in joints]
    for _ in range(POSES):
        position, speed = rng.uniform(-1.0, 1.0, (2, len(joints)))
        data.qpos[:] = engine.qpos0
        for joint, value in zip(joints, position, strict=True):
            data.qpos[engine.jnt_qposadr[engine.dof_jntid[joint.velocity]]] = value
        data.qvel[theirs] = speed
        mujoco.mj_forward(engine, data)
        columns, bias = _tree_dynamics(model, ours, position, speed)
        expected = np.zeros((len(joints), engine.nv))
        for row, unit in zip(expected, np.eye(engine.nv)[theirs], strict=True):
            mujoco.mj_mulM(engine, data, row, unit)
        matrix, forces = expected[:, theirs], data.qfrc_bias[theirs]
        inertias = np.diag(matrix)
        for i, joint in enumerate(joints):
            for k in range(i + 1):
                between = "" if k == i else f" and {joints[k].name}"
                scale = float(np.sqrt(inertias[i] * inertias[k]))
                what = "the mass matrix at"
                name = joint.name + between
                found.append(_Compared(what, name, columns[i, k], matrix[i, k], scale))
            # Relative to the forces for a unit acceleration, because many joints carry no weight.
            scale = float(np.abs(forces[i]) + inertias[i])
            found.append(_Compared("gravity and speeds at", joint.name, bias[i], forces[i], scale))
    return found


def _tree_dynamics(
    model: pin.Model, velocities: list[int], position: Array, speed: Array
) -> tuple[Array, Array]:
    """Return mass matrix and bias forces of some joints, the others at rest at zero."""
    data, way, v = model.createData(), np.zeros(model.nv), np.zeros(model.nv)
    way[velocities], v[velocities] = position, speed
    q, rest = pin.integrate(model, pin.neutral(model), way), np.zeros(model.nv)
    weight = pin.rnea(model, data, q, rest, rest).copy()
    # Column by column, because Pinocchio's ``crba`` is silently wrong for some orders of joints.
    columns = [pin.rnea(model, data, q, rest, unit) - weight for unit in np.eye(model.nv)]
    matrix = np.array(columns)[np.ix_(velocities, velocities)]
    return matrix, pin.rnea(model, data, q, v, rest)[velocities].copy()
