"""Read XML files of robots, and check their numbers before one of Pinocchio's parsers reads them.

Pinocchio's parsers ignore what they do not understand: a body has no mass if its mass is not a
number.
"""

from __future__ import annotations

import math
import re
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterable
from pathlib import Path

import numpy as np

from fuzzy2.support.bounded_files import DEEPEST, MOST_ELEMENTS, content_of, not_read
from psp3.checks import Array
from psp3.errors import InvalidRobotFile

LONGEST_SHOWN = 80
"""The largest number of characters of an attribute in an error message."""

BLANKS = " \t\r\n"
"""The characters that are blanks in XML."""

NUMBER = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")
"""A number that Python and the C and C++ parsers read in the same way.

It excludes ``0x10``, ``1_0``, ``inf`` and digits that are not ASCII, which only some of them read.
"""


MOST_ATTRIBUTES = 100
"""The largest number of attributes of an element. Robot files need at most a third of that."""

PIECE = 2**20
"""The number of characters that the parser gets at a time."""

LONGEST_WORD = 1000
"""The longest tag or attribute name [characters]."""


class Refused(Exception):
    """The builder refuses a file; the message says why."""


class BoundedBuilder(ElementTree.TreeBuilder):
    """Builds the tree of a file, and refuses trees that no robot file has.

    A document type is refused before any entity is read, because some parsers expand the entities
    that it declares and others drop them.
    """

    def __init__(self) -> None:
        super().__init__()
        self._depth = self._found = 0

    def start(self, tag: str, attributes: dict[str, str]) -> ElementTree.Element:
        """Begin an element, or refuse it."""
        self._depth += 1
        self._found += 1
        if self._depth > DEEPEST:
            raise Refused(f"<{tag[:60]}> is nested deeper than {DEEPEST} elements")
        if self._found > MOST_ELEMENTS:
            raise Refused(f"has more than {MOST_ELEMENTS} elements")
        if len(attributes) > MOST_ATTRIBUTES:
            raise Refused(f"<{tag[:60]}> has more than {MOST_ATTRIBUTES} attributes")
        for word in (tag, *attributes):
            if len(word) > LONGEST_WORD:
                raise Refused(
                    f"<{tag[:60]}> has a tag or an attribute whose name, {word[:60]!r}..., is "
                    f"longer than {LONGEST_WORD} characters"
                )
        return super().start(tag, attributes)

    def end(self, tag: str) -> ElementTree.Element:
        """End an element."""
        self._depth -= 1
        return super().end(tag)

    def doctype(self, *_: str | None) -> None:
        """Refuse it."""
        raise Refused(
            "has a <!DOCTYPE>, whose entities robot parsers replace or drop each in its own way: "
            "take it out, and write out what its entities stand for"
        )


def read_xml(path: Path, tag: str | None) -> ElementTree.Element:
    """Return the outermost element of an XML file, whose tag must be the given one, if any.

    Blanks before the XML declaration are ignored.

    Raises
    ------
    InvalidRobotFile
        If the file is missing, is not XML, is too large, too deep or has too many elements, has a
        document type or its own entities, or has another outermost element.
    """
    if not path.is_file():
        raise InvalidRobotFile(path, "is a directory" if path.is_dir() else "no such file")
    try:
        text = content_of(path).lstrip(BLANKS.encode())
        parser = ElementTree.XMLParser(target=BoundedBuilder())
        # Piece by piece, because expat parses a piece to its end even after an element was refused.
        for start in range(0, len(text), PIECE):
            parser.feed(text[start : start + PIECE])
        root = parser.close()
    except Refused as error:
        raise InvalidRobotFile(path, str(error)) from None
    except (OSError, ElementTree.ParseError, LookupError, ValueError) as error:
        raise InvalidRobotFile(path, not_read(error, "cannot be read as XML")) from error
    if tag is not None and root.tag != tag:
        raise InvalidRobotFile(path, f"its outermost element must be <{tag}>, not <{root.tag}>")
    return root


LEAST_MOMENT = -1e-9
"""A moment of inertia below this share of the largest one counts as negative; above it, as rounded.
"""

SMALLEST_RADIUS = 1e-6
"""Moments of inertia smaller than those of the body's mass at this distance [m] count as zero."""


def described(element: ElementTree.Element) -> str:
    """Return an element's tag and name, if it has one, for an error message."""
    name = element.get("name")
    return f"<{element.tag}>" if name is None else f"<{element.tag} name={name!r}>"


def numbers(path: Path, element: ElementTree.Element, attribute: str, *counts: int) -> Array | None:
    """Return the finite numbers of an attribute, or None if the element does not have it.

    Only this function reads numbers from a file. Parsers in other languages get numbers that Python
    wrote.

    Parameters
    ----------
    path : path
        The file, for error messages.
    element : xml.etree.ElementTree.Element
        The element.
    attribute : str
        Name of its attribute.
    *counts : int
        The allowed numbers of values; by default, one or more.

    Returns
    -------
    (n,) ndarray or None
        The numbers.

    Raises
    ------
    InvalidRobotFile
        If a word is not a number (see :data:`NUMBER`), there are too many or too few, or one is not
        finite.
    """
    text = element.get(attribute)
    if text is None:
        return None
    words = re.split(f"[{BLANKS}]+", text.strip(BLANKS))
    # Splitting is limited, because an attribute may hold a million words.
    values = np.array(
        [float(word) if NUMBER.fullmatch(word) else math.nan for word in words]
        if not counts or len(words) <= max(counts)
        else [math.nan]
    )
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

    Raise :class:`InvalidRobotFile` if an element has no name, or two have the same.
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
    """Return a negative principal moment of an inertia (3, 3) [kg m²]; None if there is none."""
    moments = np.linalg.eigvalsh(inertia)
    least = LEAST_MOMENT * abs(moments[2]) - mass * SMALLEST_RADIUS**2
    return float(moments[0]) if moments[0] < least else None


def check_inertia(path: Path, body: ElementTree.Element, mass: float, inertia: Array) -> None:
    """Raise :class:`InvalidRobotFile` if a mass or a moment is negative.

    These are a body's mass [kg] and the principal moments of its inertia (3, 3) [kg m²].

    Impossible moments, one of which is more than the sum of the other two, are accepted. They
    matter only for bodies that rotate. The published moments of the 3-PSP's nuts are impossible,
    but the nuts do not rotate.
    """
    if mass < 0.0:
        raise InvalidRobotFile(path, f"{described(body)}: the mass {mass:g} is negative")
    moment = negative_moment(mass, inertia)
    if moment is not None:
        raise InvalidRobotFile(
            path,
            f"{described(body)}: a principal moment of inertia is negative, {moment:.6g} kg m²",
        )
