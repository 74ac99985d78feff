"""Read an SRDF file: named poses, and pairs of links that may touch."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from fuzzy2.support.bounded_files import shortened
from fuzzy2.support.logs import logger_named
from psp3.checks import Array
from psp3.description.reference_configurations import set_reference_configuration
from psp3.description.xml import described, numbers, read_xml, unique_names
from psp3.errors import InvalidRobotFile

logger = logger_named(__name__)

KNOWN = frozenset(
    {
        *("group", "group_state", "end_effector", "virtual_joint", "passive_joint"),
        *("disable_collisions", "enable_collisions", "disable_default_collisions"),
        *("link_sphere_approximation", "joint_property"),
    }
)
"""Elements of an SRDF. Only poses and excluded pairs are used; the others are for planners."""

READ = {
    "group_state": frozenset({"name", "group"}),
    "disable_collisions": frozenset({"link1", "link2", "reason"}),
}
"""The elements that are read, with their attributes."""


def reference_poses(model: pin.Model, srdf: str | Path) -> dict[str, Array]:
    """Return the reference poses of an SRDF by name, (nq,) each.

    They are also stored in the model's ``referenceConfigurations``.

    Joints that a pose does not name are at their neutral position. The SRDF gives an angle for a
    joint of unlimited angle, and a quaternion (x, y, z, w) for a ball joint.

    Raises
    ------
    InvalidRobotFile
        If the file is missing or malformed, or names a joint that the model does not have.
    """
    path = Path(srdf)
    poses = {
        name: _pose(path, state, model)
        for name, state in unique_names(path, _outermost(path).findall("group_state")).items()
    }
    for name, pose in poses.items():
        set_reference_configuration(model, name, pose)
    return poses


def _outermost(path: Path) -> ElementTree.Element:
    """Return the outermost element; log elements that are not SRDF or are in the wrong place."""
    outermost = read_xml(path, "robot")
    unknown = [described(child) for child in outermost if child.tag not in KNOWN]
    for child in outermost:
        inside = (one for one in child.iter() if one is not child)
        unknown += [f"{described(one)} in <{child.tag}>" for one in inside if one.tag in READ]
        if child.tag in READ:
            more = sorted(child.attrib.keys() - READ[child.tag])
            unknown += [f"{key} of {described(child)}" for key in more]
    if unknown:
        logger.warning("%s: this is not read: %s", path, shortened(", ".join(unknown)))
    return outermost


def _pose(path: Path, state: ElementTree.Element, model: pin.Model) -> Array:
    unread = [f"<{child.tag}>" for child in state if child.tag != "joint"]
    unread += [
        f"{key} of {described(child)}"
        for child in state
        for key in child.attrib.keys() - {"name", "value"}
    ]
    if unread:
        logger.warning("%s: %s: this is not read: %s", path, described(state), ", ".join(unread))
    pose = np.asarray(pin.neutral(model))
    for name, element in unique_names(path, state.findall("joint")).items():
        if not model.existJointName(name) or name == model.names[0]:
            raise InvalidRobotFile(path, f"{described(state)}: the robot has no joint {name!r}")
        joint = model.joints[model.getJointId(name)]
        is_angle = (joint.nq, joint.nv) == (2, 1)
        values = numbers(path, element, "value", 1 if is_angle else joint.nq)
        if values is None:
            raise InvalidRobotFile(path, f"{described(state)}: {described(element)} has no value")
        if is_angle:
            values = np.array([np.cos(values[0]), np.sin(values[0])])
        pose[joint.idx_q : joint.idx_q + joint.nq] = values
    if not pin.isNormalized(model, pose, 1e-6):
        raise InvalidRobotFile(
            path,
            f"{described(state)}: the coordinates of a ball joint or a free body are not a unit "
            "quaternion",
        )
    return pose


class Exclusion(NamedTuple):
    """Two links that are not checked for collisions, and why.

    ``first`` and ``second`` are their names, ``reason`` is the reason in the SRDF.
    """

    first: str
    second: str
    reason: str


def excluded_by_srdf(srdf: str | Path) -> list[Exclusion]:
    """Return the pairs of links that an SRDF excludes.

    Parameters
    ----------
    srdf : path
        The file, with elements ``disable_collisions``.

    Returns
    -------
    list of Exclusion

    Raises
    ------
    InvalidRobotFile
        If the file is missing or not XML, or an element does not name two links.
    """
    found = []
    for element in _outermost(Path(srdf)).findall("disable_collisions"):
        first, second = element.get("link1"), element.get("link2")
        if not first or not second or first == second:
            raise InvalidRobotFile(
                srdf,
                f"<disable_collisions> must name two links, link1 and link2, got {first!r} and "
                f"{second!r}",
            )
        found.append(Exclusion(first, second, element.get("reason") or "excluded by the SRDF"))
    return found
