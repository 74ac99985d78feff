"""Check a URDF before Pinocchio reads it.

Pinocchio's parser ignores what it does not understand, so mistakes would change the robot silently.

It gives no mass to a link whose mass is not a number, keeps only the last parent of a link with
two, and accepts an axis of zeros.
"""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from fuzzy2.support.logs import logger_named
from psp3.description.urdf_inertia import check_inertias
from psp3.description.xml import described, numbers, unique_names
from psp3.errors import InvalidRobotFile

logger = logger_named(__name__)

JOINT_TYPES = ("revolute", "continuous", "prismatic", "fixed", "floating", "planar")
"""Types of joint that a URDF may have."""

TURNING = ("revolute", "continuous", "prismatic")
"""Types of joint that move along or about an axis."""

SHAPES = ("box", "sphere", "cylinder", "capsule", "mesh")
"""Shapes that a link may have."""

CHILDREN: Mapping[str, tuple[str, ...]] = {
    "robot": ("link", "joint", "material"),
    "link": ("inertial", "visual", "collision"),
    "inertial": ("origin", "mass", "inertia"),
    "visual": ("origin", "geometry", "material"),
    "collision": ("origin", "geometry"),
    "geometry": SHAPES,
    "material": ("color", "texture"),
    "joint": ("origin", "parent", "child", "axis", "limit", "dynamics", "mimic"),
}
"""The children that are read of each element."""

SEVERAL = ("link", "joint", "material", "visual", "collision")
"""Elements that may occur several times in one parent."""

WORDS: Mapping[str, tuple[str, ...]] = {
    "robot": ("name",),
    "link": ("name",),
    "joint": ("name", "type"),
    "parent": ("link",),
    "child": ("link",),
    "mimic": ("joint",),
    "mesh": ("filename",),
    "material": ("name",),
    "texture": ("filename",),
}
"""Attributes that are texts."""

PASSED_OVER = (
    "calibration",
    "safety_controller",
    "gazebo",
    "transmission",
    "sensor",
    "contact",
    "mujoco",
    "ros2_control",
    "verbose",
)
"""Elements for other programs, which do not affect the motion."""

LARGEST_NUMBER = 1e50
"""The largest number of a mechanism: up to six numbers are multiplied with each other."""

UNBOUNDED = ("limit", "axis")
"""Elements whose numbers may be larger: limits may be infinite, and axes of any length."""

MATTERS = (
    "link",
    "joint",
    "inertial",
    "mass",
    "inertia",
    "mimic",
    "axis",
    "limit",
    "parent",
    "child",
    "dynamics",
    "geometry",
)
"""Elements that are refused, not ignored, at a wrong place."""

NUMBERS: Mapping[str, Mapping[str, int]] = {
    "mass": {"value": 1},
    "inertia": dict.fromkeys(("ixx", "ixy", "ixz", "iyy", "iyz", "izz"), 1),
    "origin": {"xyz": 3, "rpy": 3},
    "axis": {"xyz": 3},
    "limit": dict.fromkeys(("lower", "upper", "effort", "velocity"), 1),
    "dynamics": dict.fromkeys(("damping", "friction"), 1),
    "mimic": dict.fromkeys(("multiplier", "offset"), 1),
    "box": {"size": 3},
    "sphere": {"radius": 1},
    "cylinder": {"radius": 1, "length": 1},
    "capsule": {"radius": 1, "length": 1},
    "mesh": {"scale": 3},
    "color": {"rgba": 4},
}
"""Numbers in the elements of links and joints of a URDF, and how many each attribute holds."""

NEEDED: Mapping[str, tuple[str, ...]] = {
    "mass": ("value",),
    "inertia": ("ixx", "ixy", "ixz", "iyy", "iyz", "izz"),
    "box": ("size",),
    "sphere": ("radius",),
    "cylinder": ("radius", "length"),
    "mesh": ("filename",),
    "limit": ("effort", "velocity"),
    "axis": ("xyz",),
    "mimic": ("joint",),
}
"""Required attributes of each element."""


def check_urdf(path: Path, root: ElementTree.Element) -> None:
    """Raise :class:`InvalidRobotFile` with the first mistake in a URDF and its place.

    The URDF must be one tree of links, with finite numbers.
    """
    _check_places(path, root)
    links, joints = (
        unique_names(path, root.findall("link")),
        unique_names(path, root.findall("joint")),
    )
    for item in (*links.values(), *joints.values()):
        _check_numbers(path, item)
    for link in links.values():
        for visual in (*link.findall("visual"), *link.findall("collision")):
            if len([shape for shape in visual.findall("geometry/*") if shape.tag in SHAPES]) != 1:
                raise InvalidRobotFile(
                    path,
                    f"{described(link)}: a <{visual.tag}> needs a <geometry> with one of "
                    f"{', '.join(SHAPES)}",
                )
    for joint in joints.values():
        _check_joint(path, joint)
    _check_mimics(path, joints)
    _check_tree(path, links, joints)
    check_inertias(path, links, joints)


def _check_places(path: Path, root: ElementTree.Element) -> None:
    """Refuse important elements at a wrong place, and log others that are not read."""
    unread: dict[str, None] = {}
    waiting = [root]
    while waiting:
        element = waiting.pop()
        known, seen = CHILDREN.get(element.tag, ()), set()
        for child in element:
            if child.tag in known:
                if child.tag in seen and child.tag not in SEVERAL:
                    raise InvalidRobotFile(
                        path, f"{described(element)}: has more than one <{child.tag}>"
                    )
                seen.add(child.tag)
                waiting.append(child)
            elif child.tag in MATTERS:
                raise InvalidRobotFile(
                    path,
                    f"{described(element)}: {described(child)} does not belong there: move or "
                    "remove it",
                )
            elif child.tag not in PASSED_OVER and ":" not in child.tag and not _is_rest(child):
                unread[f"<{child.tag}> in <{element.tag}>"] = None
        attributes = (*WORDS.get(element.tag, ()), *NUMBERS.get(element.tag, ()))
        for attribute in element.attrib:
            if attribute not in attributes and element is not root:
                unread[f"{attribute} of <{element.tag}>"] = None
    if unread:
        logger.warning("%s: this is not read: %s", path, ", ".join(unread))


def _is_rest(element: ElementTree.Element) -> bool:
    """Tell whether an element is an origin of zeros, which some exporters write into links."""
    words = " ".join(element.attrib.values()).split()
    return element.tag == "origin" and set(words) <= {"0", "-0", "0.0", "-0.0"}


def _check_mimics(path: Path, joints: Mapping[str, ElementTree.Element]) -> None:
    """Refuse joints that mimic a missing joint or each other."""
    leaders = {
        name: mimic.attrib["joint"]
        for name, joint in joints.items()
        if (mimic := joint.find("mimic")) is not None and joint.get("type") != "fixed"
    }
    for name, leader in leaders.items():
        if leader not in joints:
            raise InvalidRobotFile(
                path, f"joint {name!r} mimics {leader!r}, which is not in the file"
            )
    settled: set[str] = set()
    for name in leaders:
        passed: list[str] = []
        while name in leaders and name not in settled:
            if name in passed:
                raise InvalidRobotFile(
                    path, f"joints mimic each other in a circle: {', '.join(passed)}"
                )
            passed.append(name)
            name = leaders[name]
        settled.update(passed)


def _check_numbers(path: Path, item: ElementTree.Element) -> None:
    for element in item.iter():
        for attribute in NEEDED.get(element.tag, ()):
            if element.get(attribute) is None:
                raise InvalidRobotFile(
                    path, f"{described(item)}: <{element.tag}> lacks {attribute}"
                )
        for attribute, count in NUMBERS.get(element.tag, {}).items():
            try:
                values = numbers(path, element, attribute, count)
            except InvalidRobotFile as error:
                raise InvalidRobotFile(path, f"{described(item)}: {error.reason}") from None
            if (
                values is not None
                and np.abs(values).max() > LARGEST_NUMBER
                and element.tag not in UNBOUNDED
            ):
                raise InvalidRobotFile(
                    path,
                    f"{described(item)}: {described(element)}: {attribute} is larger than "
                    f"{LARGEST_NUMBER:g}, so products of it would overflow",
                )


def _number(path: Path, element: ElementTree.Element, attribute: str, default: float) -> float:
    values = numbers(path, element, attribute, 1)
    return default if values is None else float(values[0])


def _check_joint(path: Path, joint: ElementTree.Element) -> None:
    kind = joint.get("type")
    if kind not in JOINT_TYPES:
        raise InvalidRobotFile(
            path,
            f"{described(joint)}: type {kind!r} is unknown; known are {', '.join(JOINT_TYPES)}",
        )
    axis, limit = joint.find("axis"), joint.find("limit")
    direction = None if axis is None else numbers(path, axis, "xyz", 3)
    if kind in (*TURNING, "planar") and direction is not None and not direction.any():
        raise InvalidRobotFile(path, f"{described(joint)}: the axis is zero")
    if kind in ("revolute", "prismatic"):
        if limit is None:
            raise InvalidRobotFile(path, f"{described(joint)}: a {kind} joint needs a <limit>")
        if _number(path, limit, "lower", 0.0) > _number(path, limit, "upper", 0.0):
            raise InvalidRobotFile(
                path, f"{described(joint)}: its lower limit is above its upper one"
            )


def _check_tree(
    path: Path, links: Mapping[str, ElementTree.Element], joints: Mapping[str, ElementTree.Element]
) -> None:
    if not links:
        raise InvalidRobotFile(path, "has no <link>")
    above: dict[str, str] = {}
    for joint in joints.values():
        parent, child = (_link(path, joint, role, links) for role in ("parent", "child"))
        if child in above:
            raise InvalidRobotFile(
                path,
                f"link {child!r} is the child of two joints; a URDF is a tree: close loops in a "
                "loop file instead",
            )
        above[child] = parent
    roots = [name for name in links if name not in above]
    if len(roots) != 1:
        raise InvalidRobotFile(
            path,
            f"exactly one link must have no parent, but {len(roots)} have none: "
            f"{', '.join(roots) or 'each is a child'}",
        )
    hanging = {roots[0]}
    for name in links:
        link, passed = name, {name}
        while link not in hanging:
            link = above[link]
            if link in passed:
                raise InvalidRobotFile(
                    path,
                    f"link {name!r} hangs on a circle of links, not on {roots[0]!r}",
                )
            passed.add(link)
        hanging |= passed


def _link(
    path: Path, joint: ElementTree.Element, role: str, links: Mapping[str, ElementTree.Element]
) -> str:
    """Return the name of a joint's parent or child link."""
    element = joint.find(role)
    link = "" if element is None else element.get("link", "")
    if link not in links:
        raise InvalidRobotFile(
            path, f"{described(joint)}: its {role} link {link!r} is not in the file"
        )
    return link
