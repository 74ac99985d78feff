"""XML files of robots: read, and their numbers checked, before a parser of Pinocchio's sees them.

Pinocchio's parsers pass over what they do not understand: a mass that is not a number becomes a
body without mass.
"""

from __future__ import annotations

import math
import re
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterable
from pathlib import Path

import numpy as np

from psp3.checks import Array
from psp3.errors import InvalidRobotFile

LONGEST_SHOWN = 80
"""So many characters of an attribute are shown in an error message."""

BLANKS = " \t\r\n"
"""What XML takes for blanks."""

NUMBER = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")
"""A number that Python and the parsers in C and C++ read alike.

Not ``0x10``, ``1_0``, ``inf`` or digits that are not ASCII, which some of them read and others do
not.
"""


class _HasDoctype(Exception):
    """A file has a document type declaration."""


class _Builder(ElementTree.TreeBuilder):
    """Builds a tree, but of no file with a document type declaration.

    There a file can declare entities, which one parser replaces and another drops.
    """

    def doctype(self, name: str, public: str | None, system: str | None) -> None:
        """Refuse it, before any entity is read."""
        raise _HasDoctype


def read_xml(path: Path, tag: str | None) -> ElementTree.Element:
    """Return the outermost element of an XML file, whose tag must be the given one, if any.

    Blanks before the declaration are passed over.

    Raises
    ------
    InvalidRobotFile
        If the file is missing, is not XML, has a document type or entities of its own, or its
        outermost element is another one.
    """
    if not path.is_file():
        raise InvalidRobotFile(path, "no such file")
    try:
        text = path.read_bytes().lstrip(BLANKS.encode())
        root = ElementTree.fromstring(text, ElementTree.XMLParser(target=_Builder()))
    except _HasDoctype:
        raise InvalidRobotFile(
            path,
            "has a <!DOCTYPE>, whose entities robot parsers replace or drop each in its own way: "
            "take it out, and write out what its entities stand for",
        ) from None
    except (OSError, ElementTree.ParseError, LookupError, ValueError) as error:
        raise InvalidRobotFile(
            path, f"cannot be read as XML ({getattr(error, 'strerror', None) or error})"
        ) from error
    if tag is not None and root.tag != tag:
        raise InvalidRobotFile(path, f"its outermost element must be <{tag}>, not <{root.tag}>")
    return root


LEAST_MOMENT = -1e-9
"""A moment of inertia below this share of the largest one is negative, not rounded."""

SMALLEST_RADIUS = 1e-6
"""Beside a body's mass at this distance [m] its moments of inertia count as zero."""


def described(element: ElementTree.Element) -> str:
    """Return an element's tag, with its name if it has one, as an error message says them."""
    name = element.get("name")
    return f"<{element.tag}>" if name is None else f"<{element.tag} name={name!r}>"


def numbers(path: Path, element: ElementTree.Element, attribute: str, *counts: int) -> Array | None:
    """Return the finite numbers of an attribute, or None if the element does not have it.

    They are read here alone: what a parser of another language is given is written anew from them.

    Parameters
    ----------
    path : path
        The file, for error messages.
    element : xml.etree.ElementTree.Element
        The element.
    attribute : str
        Name of its attribute.
    *counts : int
        How many numbers there may be; without any, one or more.

    Returns
    -------
    (n,) ndarray or None
        The numbers.

    Raises
    ------
    InvalidRobotFile
        If there is something else (see :data:`NUMBER`), too many or too few, or one is not
        finite.
    """
    text = element.get(attribute)
    if text is None:
        return None
    words = re.split(f"[{BLANKS}]+", text.strip(BLANKS))
    values = np.array([float(word) if NUMBER.fullmatch(word) else math.nan for word in words])
    if not np.isfinite(values).all() or not values.size or (counts and values.size not in counts):
        wanted = f"{' or '.join(map(str, counts))} " if counts else ""
        plural = "s" if counts != (1,) else ""
        raise InvalidRobotFile(
            path,
            f"{described(element)}: {attribute} must be {wanted}finite number{plural}, got "
            f"{text[:LONGEST_SHOWN]!r}",
        )
    return values


def unique_names(
    path: Path, elements: Iterable[ElementTree.Element]
) -> dict[str, ElementTree.Element]:
    """Return elements of one kind by their names.

    Raise :class:`InvalidRobotFile` if one has none, or two have the same.
    """
    known: dict[str, ElementTree.Element] = {}
    for element in elements:
        name = element.get("name")
        if not name:
            raise InvalidRobotFile(path, f"a <{element.tag}> has no name")
        if name in known:
            raise InvalidRobotFile(path, f"there are two of {described(element)}")
        known[name] = element
    return known


def negative_moment(mass: float, inertia: Array) -> float | None:
    """Return a principal moment of an inertia (3, 3) that is negative [kg m²], None without one."""
    moments = np.linalg.eigvalsh(inertia)
    least = LEAST_MOMENT * abs(moments[2]) - mass * SMALLEST_RADIUS**2
    return float(moments[0]) if moments[0] < least else None


def check_inertia(path: Path, body: ElementTree.Element, mass: float, inertia: Array) -> None:
    """Raise :class:`InvalidRobotFile` if a mass or a moment is negative.

    That is a body's mass [kg] or a principal moment of its inertia (3, 3) [kg m²].

    Moments that no rigid body has (each must be at most the sum of the other two) pass: they matter
    only to bodies that turn, and the published ones of the 3-PSP's nuts, which do not, are such.
    """
    if mass < 0.0:
        raise InvalidRobotFile(path, f"{described(body)}: the mass {mass:g} is negative")
    moment = negative_moment(mass, inertia)
    if moment is not None:
        raise InvalidRobotFile(
            path,
            f"{described(body)}: a principal moment of inertia is negative, {moment:.6g} kg m²",
        )
