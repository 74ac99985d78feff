"""What a URDF must hold.

This is checked before Pinocchio reads it, because its parser passes over what it does not
understand.

To it, a link whose mass is not a number has no mass, a link with two parents has the last one, and
an axis of zeros is an axis.
"""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from psp3.description.xml import check_inertia, described, numbers, unique_names
from psp3.errors import InvalidRobotFile

JOINT_TYPES = ("revolute", "continuous", "prismatic", "fixed", "floating", "planar")
"""Types of joint that a URDF may have."""

NUMBERS: Mapping[str, Mapping[str, int]] = {
    "mass": {"value": 1},
    "inertia": dict.fromkeys(("ixx", "ixy", "ixz", "iyy", "iyz", "izz"), 1),
    "origin": {"xyz": 3, "rpy": 3},
    "axis": {"xyz": 3},
    "limit": dict.fromkeys(("lower", "upper", "effort", "velocity"), 1),
    "dynamics": dict.fromkeys(("damping", "friction"), 1),
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
}
"""Attributes without which an element says nothing."""

SHAPES = ("box", "sphere", "cylinder", "capsule", "mesh")
"""Shapes that a link may have."""


def check_urdf(path: Path, root: ElementTree.Element) -> None:
    """Raise :class:`InvalidRobotFile` with what is wrong in a URDF and where.

    It must be one tree of links with finite numbers.
    """
    if not root.get("name"):
        raise InvalidRobotFile(path, "the <robot> has no name")
    links, joints = (
        unique_names(path, root.findall("link")),
        unique_names(path, root.findall("joint")),
    )
    for item in (*links.values(), *joints.values()):
        _check_numbers(path, item)
    for link in links.values():
        _check_inertia(path, link)
        for visual in link.findall("visual"):
            if not any(visual.find(f"geometry/{shape}") is not None for shape in SHAPES):
                raise InvalidRobotFile(
                    path,
                    f"{described(link)}: a <visual> needs a <geometry> with one of "
                    f"{', '.join(SHAPES)}",
                )
    for joint in joints.values():
        _check_joint(path, joint)
    _check_tree(path, links, joints)


def _check_numbers(path: Path, item: ElementTree.Element) -> None:
    for element in item.iter():
        for attribute in NEEDED.get(element.tag, ()):
            if element.get(attribute) is None:
                raise InvalidRobotFile(
                    path, f"{described(item)}: <{element.tag}> lacks {attribute}"
                )
        for attribute, count in NUMBERS.get(element.tag, {}).items():
            try:
                numbers(path, element, attribute, count)
            except InvalidRobotFile as error:
                raise InvalidRobotFile(path, f"{described(item)}: {error.reason}") from None


def _check_inertia(path: Path, link: ElementTree.Element) -> None:
    inertial = link.find("inertial")
    if inertial is None:
        return
    mass, inertia = inertial.find("mass"), inertial.find("inertia")
    if mass is None or inertia is None:
        raise InvalidRobotFile(path, f"{described(link)}: <inertial> needs <mass> and <inertia>")
    xx, xy, xz, yy, yz, zz = (float(inertia.attrib[entry]) for entry in NEEDED["inertia"])
    check_inertia(
        path,
        link,
        float(mass.attrib["value"]),
        np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]),
    )


def _check_joint(path: Path, joint: ElementTree.Element) -> None:
    kind = joint.get("type")
    if kind not in JOINT_TYPES:
        raise InvalidRobotFile(
            path,
            f"{described(joint)}: type {kind!r} is unknown; known are {', '.join(JOINT_TYPES)}",
        )
    axis, limit = joint.find("axis"), joint.find("limit")
    direction = None if axis is None else numbers(path, axis, "xyz", 3)
    if (
        kind in ("revolute", "continuous", "prismatic")
        and direction is not None
        and not direction.any()
    ):
        raise InvalidRobotFile(path, f"{described(joint)}: the axis is zero")
    if kind in ("revolute", "prismatic"):
        if limit is None:
            raise InvalidRobotFile(path, f"{described(joint)}: a {kind} joint needs a <limit>")
        if float(limit.get("lower", "0")) > float(limit.get("upper", "0")):
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
            f"one link must have no joint above it, but {len(roots)} have none: "
            f"{', '.join(roots) or 'each is a child'}",
        )
    for name in links:
        link, passed = name, {name}
        while link != roots[0]:
            link = above[link]
            if link in passed:
                raise InvalidRobotFile(
                    path,
                    f"link {name!r} hangs on links that are children of each other, not on "
                    f"{roots[0]!r}",
                )
            passed.add(link)


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
