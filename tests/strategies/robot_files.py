"""Random robots as files: a URDF with its SRDF and loop file, by hand, all digits written."""

from __future__ import annotations

from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np
import pinocchio as pin

from psp3.multibody.equations import Hinge
from tests.helpers import Array
from tests.strategies.robots import Parts, simple_joints

WRITTEN = ("revolute", "slide", "z", "x", "slide along y")
"""Joints that a URDF has a word for, and that a motor can drive."""


def _text(numbers: Any) -> str:
    return " ".join(repr(float(one)) for one in np.ravel(numbers))


def _origin(element: ET.Element, place: pin.SE3) -> None:
    rpy = pin.rpy.matrixToRpy(place.rotation)
    ET.SubElement(element, "origin", xyz=_text(place.translation), rpy=_text(rpy))


def _axis(model: pin.Model, number: int) -> tuple[str, Array]:
    """Return kind and axis of a joint of one degree of freedom."""
    joint = model.joints[number]
    jacobian = pin.computeJointJacobian(model, model.createData(), pin.neutral(model), number)
    screw = jacobian.reshape(6, model.nv)[:, joint.idx_v]
    return ("revolute", screw[3:]) if screw[3:].any() else ("prismatic", screw[:3])


def _link(robot: ET.Element, name: str, inertia: pin.Inertia) -> None:
    inertial = ET.SubElement(ET.SubElement(robot, "link", name=name), "inertial")
    ET.SubElement(inertial, "origin", xyz=_text(inertia.lever), rpy="0 0 0")
    ET.SubElement(inertial, "mass", value=_text(inertia.mass))
    moments = inertia.inertia
    names = {"ixx": (0, 0), "ixy": (0, 1), "ixz": (0, 2), "iyy": (1, 1), "iyz": (1, 2)}
    entries = {name: _text(moments[at]) for name, at in {**names, "izz": (2, 2)}.items()}
    ET.SubElement(inertial, "inertia", entries)


def _frame(robot: ET.Element, name: str, body: int, place: pin.SE3) -> None:
    """Hang an empty link on a body, as a frame of that name."""
    ET.SubElement(robot, "link", name=name)
    joint = ET.SubElement(robot, "joint", name=f"at_{name}", type="fixed")
    ET.SubElement(joint, "parent", link=f"b{body}")
    ET.SubElement(joint, "child", link=name)
    _origin(joint, place)


def written_urdf(parts: Parts, folder: Path) -> tuple[Path, Path, Path]:
    """Write a robot of joints that a URDF knows; return URDF, loop file and SRDF."""
    model = parts.model
    robot = ET.Element("robot", name="random")
    ET.SubElement(robot, "link", name="b0")
    for number in range(1, model.njoints):
        name, (kind, axis) = str(model.names[number]), _axis(model, number)
        _link(robot, f"b{number}", model.inertias[number])
        joint = ET.SubElement(robot, "joint", name=name, type=kind)
        ET.SubElement(joint, "parent", link=f"b{model.parents[number]}")
        ET.SubElement(joint, "child", link=f"b{number}")
        _origin(joint, model.jointPlacements[number])
        ET.SubElement(joint, "axis", xyz=_text(axis))
        ET.SubElement(joint, "limit", lower="-100", upper="100", effort="50", velocity="50")
        damping = model.damping[model.joints[number].idx_v]
        ET.SubElement(joint, "dynamics", damping=_text(damping))
    pairs, kinds = [], []
    for number, loop in enumerate([*parts.constraint_models, *parts.equations]):
        names = [f"loop{number}_{end}" for end in "ab"]
        _frame(robot, names[0], loop.joint1_id, loop.joint1_placement)
        _frame(robot, names[1], loop.joint2_id, loop.joint2_placement)
        pairs.append(f"[{', '.join(names)}]")
        is_point = not isinstance(loop, Hinge) and loop.type == pin.ContactType.CONTACT_3D
        kinds.append("hinge" if isinstance(loop, Hinge) else "3d" if is_point else "6d")
    urdf, yaml, srdf = (folder / f"random.{suffix}" for suffix in ("urdf", "yaml", "srdf"))
    ET.ElementTree(robot).write(urdf, encoding="utf-8")
    yaml.write_text(
        f"closed_loop: [{', '.join(pairs)}]\ntype: [{', '.join(kinds)}]\n"
        f"name_mot: [{', '.join(parts.actuated)}]\n",
        encoding="utf-8",
    )
    home = ET.Element("robot", name="random")
    state = ET.SubElement(home, "group_state", name="home", group="all")
    for name in simple_joints(model):
        at = parts.q0[model.joints[model.getJointId(name)].idx_q]
        ET.SubElement(state, "joint", name=name, value=_text(at))
    ET.ElementTree(home).write(srdf, encoding="utf-8")
    return urdf, yaml, srdf
