"""Rewrite a checked URDF: only its known elements, with their numbers written anew.

Pinocchio reads the result, called the plain URDF, instead of the file. Its parser silently drops
the inertia of a link whose mass ends in a blank, and does not read all digits that Python reads. So
only this package reads the numbers of the file, and Pinocchio reads numbers that Python wrote.
"""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np
import pinocchio as pin

from psp3.checks import Array
from psp3.description.urdf_checks import CHILDREN, NUMBERS, TURNING, WORDS, check_urdf
from psp3.description.xml import numbers, read_xml

LARGEST_AXIS = 1e6
"""An axis with entries above this, or below its reciprocal, is normalized, because the parser
squares them.
"""


def plain_urdf(urdf: str | Path) -> ElementTree.Element:
    """Return the outermost element of the plain URDF.

    A robot without a name gets the name of its file, and a fixed joint mimics nothing. Every joint
    has an explicit axis. By the format, a planar joint moves in the plane normal to its axis.
    Pinocchio ignores that axis, so the joint is rotated, and an added link and a fixed joint rotate
    its child back.

    Raises
    ------
    InvalidRobotFile
        If the file is missing or wrong, see :func:`psp3.description.urdf_checks.check_urdf`.
    """
    path = Path(urdf)
    root = read_xml(path, "robot")
    check_urdf(path, root)
    plain = _plain(path, root)
    plain.set("name", root.get("name") or path.stem)
    for joint in plain.findall("joint"):
        mimic = joint.find("mimic")
        if joint.get("type") == "fixed" and mimic is not None:
            joint.remove(mimic)
        if joint.get("type") in (*TURNING, "planar"):
            _write_axis(joint)
        if joint.get("type") == "planar":
            _turn_plane(plain, joint)
    return plain


def make_meshes_absolute(path: Path, root: ElementTree.Element) -> None:
    """Make mesh paths absolute; in the file they are relative to its folder."""
    for mesh in root.iter("mesh"):
        if "://" not in mesh.attrib["filename"]:
            mesh.set("filename", str(path.resolve().parent / mesh.attrib["filename"]))


def _plain(path: Path, element: ElementTree.Element) -> ElementTree.Element:
    """Return an element with only the attributes and children that the format has."""
    plain = ElementTree.Element(element.tag)
    for attribute in WORDS.get(element.tag, ()):
        if attribute in element.attrib:
            plain.set(attribute, element.attrib[attribute])
    for attribute, count in NUMBERS.get(element.tag, {}).items():
        values = numbers(path, element, attribute, count)
        if values is not None:
            plain.set(attribute, _written(values))
    for child in element:
        if child.tag in CHILDREN.get(element.tag, ()):
            plain.append(_plain(path, child))
    return plain


def _written(values: Array) -> str:
    return " ".join(repr(float(value)) for value in values)


def _read(text: str) -> Array:
    return np.array([float(word) for word in text.split()])


def _write_axis(joint: ElementTree.Element) -> None:
    """Give a joint an axis whose entries can be squared; the default axis if it has none."""
    axis = joint.find("axis")
    if axis is None:
        axis = ElementTree.SubElement(joint, "axis", xyz="1.0 0.0 0.0")
    direction = _read(axis.attrib["xyz"])
    size = np.abs(direction).max()
    if not 1.0 / LARGEST_AXIS <= size <= LARGEST_AXIS:
        axis.set("xyz", _written(direction / size))


def _turn_plane(plain: ElementTree.Element, joint: ElementTree.Element) -> None:
    """Rotate a planar joint until z is its axis, and rotate its link back."""
    normal = _read(joint.find("axis").attrib["xyz"])  # type: ignore[union-attr]
    normal /= np.linalg.norm(normal)
    if normal[2] == 1.0:
        return
    turn = pin.Quaternion.FromTwoVectors(np.array([0.0, 0.0, 1.0]), normal).matrix()
    origin = joint.find("origin")
    if origin is None:
        origin = ElementTree.SubElement(joint, "origin")
    before = pin.rpy.rpyToMatrix(_read(origin.get("rpy", "0 0 0")))
    origin.set("rpy", _written(pin.rpy.matrixToRpy(before @ turn)))
    link = joint.find("child")
    assert link is not None
    taken = {element.get("name") for element in plain}
    between = f"{link.attrib['link']}_plane"
    while between in taken:
        between += "_"
    ElementTree.SubElement(plain, "link", name=between)
    back = ElementTree.SubElement(plain, "joint", name=between, type="fixed")
    ElementTree.SubElement(back, "origin", xyz="0 0 0", rpy=_written(pin.rpy.matrixToRpy(turn.T)))
    ElementTree.SubElement(back, "parent", link=between)
    ElementTree.SubElement(back, "child", link=link.attrib["link"])
    link.set("link", between)
