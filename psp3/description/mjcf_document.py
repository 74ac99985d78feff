"""An MJCF file as MuJoCo reads it.

Included files are inserted, defaults are written out, angles are in radians, and every pose is a
position and a quaternion.

MuJoCo's own documentation of the format (XML Reference) says what each attribute means; the tests
compare with the models that MuJoCo compiles.
"""

from __future__ import annotations

import copy
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from fuzzy2.support.bounded_files import DEEPEST, MOST_ELEMENTS
from psp3.checks import Array
from psp3.description.mjcf_words import unknown_words
from psp3.description.xml import MOST_ATTRIBUTES, described, numbers, read_xml
from psp3.errors import InvalidRobotFile

ORIENTATIONS = {"quat": 4, "axisangle": 4, "euler": 3, "xyaxes": 6, "zaxis": 3}
"""Attributes that give an orientation, and how many numbers each holds."""

MOST_FILES = 200
"""The largest number of included and attached files. A file that is used several times counts each
time.
"""

LONGEST_NAME = 1000
"""The longest name of a copied element [characters]; each copy adds a prefix or suffix."""

SHORTEST = 1e-14
"""A shorter vector has no direction, and a smaller mass counts as zero: MuJoCo's ``mjEPS``."""

LARGEST = 1e50
"""The largest number that is read. No robot needs a larger one, and its square could overflow."""


class Spent:
    """Counts the files and elements that were read and copied for one robot."""

    def __init__(self) -> None:
        self.files = self.elements = 0


class MjcfDocument:
    """An MJCF file with the attributes that its elements inherit.

    Parameters
    ----------
    path : path
        The file.

    above : tuple of MjcfDocument
        The files that attach this one, the outermost first.

    Attributes
    ----------
    root : Element
        The file's root; included files are inserted.
    compiler : dict of str to str
        Settings of the compiler.
    unknown : tuple of str
        Words that the format does not have.
    radians_per_unit : float
        Factor from the file's unit of angle to radians.
    settings : dict
        Compiler settings for the inertia of a body. Bodies from an attached file keep the settings
        of that file.

    Raises
    ------
    InvalidRobotFile
        If it is missing or not an MJCF; includes a file that is missing, included twice or outside
        its folder; has compiler settings that are not supported; or expands to too many files or
        elements.
    """

    def __init__(self, path: str | Path, above: tuple[MjcfDocument, ...] = ()) -> None:
        self.path, self.above = Path(path), above
        self.folder: Path = above[0].folder if above else self.path.resolve().parent
        # Counted over all files of a robot.
        self.settings: dict[ElementTree.Element, dict[str, str]] = (
            above[0].settings if above else {}
        )
        self._spent: Spent = above[0]._spent if above else Spent()
        self.spend(files=1)
        self.root = read_xml(self.path, "mujoco")
        self._include(self.root, {self.path.resolve()})
        self.unknown = tuple(unknown_words(self.root))
        self.compiler: dict[str, str] = {}
        for element in self.root.findall("compiler"):
            self._update(self.compiler, element)
        if self.compiler.get("coordinate", "local") != "local":
            raise self.wrong(
                f"<compiler coordinate={self.compiler['coordinate']!r}> is not read, as MuJoCo "
                f"does not any more; {self.advice}"
            )
        self.radians_per_unit = (
            1.0 if self.compiler.get("angle", "degree") == "radian" else np.pi / 180.0
        )
        self._sequence = self.compiler.get("eulerseq", "xyz")
        if len(self._sequence) != 3 or not set(self._sequence) <= set("xyzXYZ"):
            raise self.wrong(
                "<compiler>: eulerseq must be three of the letters x, y, z, X, Y, Z, got "
                f"{self._sequence!r}"
            )
        self._main = "main"
        self._classes: dict[str, dict[str, dict[str, str]]] = {}
        for element in self.root.findall("default"):
            self._main = element.get("class", self._main)
            self._read_class(element, self._main, self._classes.get(self._main, {}))
        self._classes.setdefault(self._main, {})

    advice = "let MuJoCo write the model out (mj_saveLastXML) and read that file"
    """What an error message advises for an MJCF with elements that this reader does not support."""

    def wrong(self, reason: str) -> InvalidRobotFile:
        """Return the error for a reason, with the path of this file."""
        return InvalidRobotFile(self.path, reason)

    def spend(self, elements: int = 0, files: int = 0) -> None:
        """Count files and elements that are read or copied, and refuse more than a robot needs."""
        self._spent.elements += elements
        self._spent.files += files
        if self._spent.elements > MOST_ELEMENTS:
            raise self.wrong(f"expands to more than {MOST_ELEMENTS} elements")
        if self._spent.files > MOST_FILES:
            raise self.wrong(f"includes and attaches more than {MOST_FILES} files")

    def _update(self, known: dict[str, str], element: ElementTree.Element) -> None:
        """Add the attributes of an element to those of earlier elements."""
        known.update(element.attrib)
        if len(known) > MOST_ATTRIBUTES:
            raise self.wrong(f"<{element.tag}> has more than {MOST_ATTRIBUTES} attributes")

    def _include(self, element: ElementTree.Element, included: set[Path], depth: int = 1) -> None:
        """Put the children of included files where the elements <include> stand."""
        if depth > DEEPEST:
            raise self.wrong(
                f"elements are nested more than {DEEPEST} deep, the last {described(element)}"
            )
        for index in reversed(range(len(element))):
            child = element[index]
            if child.tag == "include":
                path = self._inside(child)
                if path in included:
                    raise self.wrong(f"{path.name} is included twice")
                included.add(path)
                self.spend(files=1)
                other = read_xml(path, None)
                self.spend(elements=sum(1 for _ in other.iter()))
                self._include(other, included, depth + 1)
                element[index : index + 1] = list(other)
            else:
                self._include(child, included, depth + 1)

    def _inside(self, element: ElementTree.Element) -> Path:
        """Return the file that an element names; it must be in the folder of the robot."""
        if not element.get("file"):
            raise self.wrong(f"{described(element)} has no file")
        path = (self.path.parent / element.attrib["file"]).resolve()
        if not path.is_relative_to(self.folder):
            raise self.wrong(
                f"{described(element)}: {element.attrib['file']!r} is outside of the file's folder "
                f"{self.folder}; copy it there"
            )
        return path

    def attached(self, element: ElementTree.Element) -> MjcfDocument:
        """Return the file of a model to attach."""
        path = self._inside(element)
        if path in [one.path.resolve() for one in (*self.above, self)]:
            raise self.wrong(f"{described(element)}: {path.name} attaches itself")
        other = MjcfDocument(path, (*self.above, self))
        self.unknown += other.unknown
        return other

    def written_out(self, root: ElementTree.Element) -> MjcfDocument:
        """Return this file with another tree, which is in radians and has no classes."""
        other = copy.copy(self)
        other.root, other.radians_per_unit = root, 1.0
        other._main, other._classes = "main", {"main": {}}
        return other

    def named(self, element: ElementTree.Element, name: str) -> None:
        """Give a copied element its own name."""
        if len(name) > LONGEST_NAME:
            raise self.wrong(
                f"<{element.tag}>: a copy has a name of more than {LONGEST_NAME} characters, "
                f"{name[:60]!r}...; give shorter names, prefix and sep"
            )
        element.set("name", name)

    def locate(self, mesh: ElementTree.Element) -> None:
        """Set the name of a mesh and the full path of its file."""
        file = mesh.get("file")
        if file is None:
            return
        if self.compiler.get("strippath") == "true":
            file = Path(file).name
        folder = self.compiler.get("meshdir", self.compiler.get("assetdir", ""))
        mesh.set("name", mesh.get("name") or Path(file).stem)
        mesh.set("file", str((self.path.parent / folder / file).resolve()))

    def _read_class(
        self, element: ElementTree.Element, name: str, inherited: Mapping[str, dict[str, str]]
    ) -> None:
        known = self._classes[name] = copy.deepcopy(dict(inherited))
        self.spend(elements=len(known))
        for child in element:
            if child.tag != "default":
                self._update(known.setdefault(child.tag, {}), child)
        for child in element.findall("default"):
            nested = child.get("class")
            if not nested or nested in self._classes:
                raise self.wrong(
                    f"<default>: a nested class needs a name of its own, got {nested!r}"
                )
            self._read_class(child, nested, known)

    def section(self, tag: str) -> Iterator[ElementTree.Element]:
        """Return the elements of all sections of a name; MuJoCo puts repeated sections together."""
        for section in self.root.findall(tag):
            yield from section

    def full(
        self, element: ElementTree.Element, child_class: str | None = None, tag: str | None = None
    ) -> ElementTree.Element:
        """Return an element with the attributes that it inherits.

        It inherits from its class, from the class of the body around it, or from the main class.
        """
        name = element.get("class") or child_class or self._main
        if name not in self._classes:
            raise self.wrong(f"{described(element)}: there is no default class {name!r}")
        result = ElementTree.Element(element.tag, self._classes[name].get(tag or element.tag, {}))
        result.attrib.update(element.attrib)
        return result

    def numbers(self, element: ElementTree.Element, attribute: str, *counts: int) -> Array | None:
        """Return the numbers of an attribute; None if it is missing.

        See :func:`psp3.description.xml.numbers`.
        """
        values = numbers(self.path, element, attribute, *counts)
        if values is not None and np.abs(values).max() > LARGEST:
            raise self.wrong(
                f"{described(element)}: {attribute} has a number beyond {LARGEST:g}, "
                f"{element.attrib[attribute][:80]!r}"
            )
        return values

    def number(self, element: ElementTree.Element, attribute: str, default: float) -> float:
        """Return the single number of an attribute."""
        value = self.numbers(element, attribute, 1)
        return default if value is None else float(value[0])

    def vector(
        self,
        element: ElementTree.Element,
        attribute: str,
        default: tuple[float, float, float] = (0.0, 0.0, 0.0),
    ) -> Array:
        """Return the three numbers of an attribute."""
        value = self.numbers(element, attribute, 3)
        return np.array(default) if value is None else value

    def is_true(self, element: ElementTree.Element, attribute: str, default: bool) -> bool:
        """Return the value of an attribute that is ``true`` or ``false``."""
        text = element.get(attribute, "true" if default else "false")
        if text not in ("true", "false"):
            raise self.wrong(
                f"{described(element)}: {attribute} must be true or false, got {text!r}"
            )
        return text == "true"

    def total_mass(self) -> float | None:
        """Return the total mass to which all bodies are scaled [kg]; None without scaling."""
        settings = ElementTree.Element("compiler", self.compiler)
        total = self.number(settings, "settotalmass", -1.0)
        return total if total > 0.0 else None

    def setting(self, body: ElementTree.Element, name: str, default: str) -> str:
        """Return a compiler setting that affects a body's inertia."""
        return self.settings.get(body, self.compiler).get(name, default)

    def place_in(self, element: ElementTree.Element, frame: pin.SE3) -> None:
        """Convert the placement of an element from a frame of its body to the body itself.

        The result is a position and a quaternion, or two ends. Numbers that do not change keep all
        the digits that are written in the file.
        """
        still = frame.isIdentity(0.0)
        ends = None if still else self.ends(element)
        if ends is not None:
            # The ends leave the rotation about their line open; the frame rotates it, too.
            thickness = element.get("size", "").split()[:1]
            wide = element.get("type") in ("box", "ellipsoid")
            element.set("size", " ".join([*thickness * (1 + wide), text_of([ends[1]])]))
            element.attrib.pop("fromto")
            set_place(element, frame * ends[0])
            return
        if element.get("fromto") is not None:
            return
        given = [attribute for attribute in ORIENTATIONS if element.get(attribute) is not None]
        if still and given in ([], ["quat"]):
            return
        placement = frame * self.placement(element)
        for attribute in given:
            element.attrib.pop(attribute)
        set_place(element, placement)

    def placement(self, element: ElementTree.Element) -> pin.SE3:
        """Return the placement of an element in its body, or of a body in its parent.

        It is given as ``pos`` and one of five attributes for the orientation.
        """
        return pin.SE3(self._rotation(element), self.vector(element, "pos"))

    def _rotation(self, element: ElementTree.Element) -> Array:
        given = [attribute for attribute in ORIENTATIONS if element.get(attribute) is not None]
        if not given:
            return np.eye(3)
        if len(given) > 1:
            raise self.wrong(f"{described(element)} has several orientations: {', '.join(given)}")
        values = self.numbers(element, given[0], ORIENTATIONS[given[0]])
        assert values is not None
        try:
            rotation: Array = getattr(self, f"_from_{given[0]}")(values)
            return rotation
        except ZeroDivisionError:
            raise self.wrong(
                f"{described(element)}: {given[0]} {element.get(given[0])!r} gives no direction"
            ) from None

    def rotation_of_quaternion(self, element: ElementTree.Element, attribute: str) -> Array:
        """Return the rotation of a quaternion attribute; the identity if it is missing."""
        values = self.numbers(element, attribute, 4)
        if values is None:
            return np.eye(3)
        if not values.any():
            raise self.wrong(f"{described(element)}: {attribute} gives no direction")
        return self._from_quat(values)

    def _from_quat(self, values: Array) -> Array:
        w, x, y, z = unit(values)
        return np.asarray(pin.Quaternion(w, x, y, z).toRotationMatrix())

    def _from_axisangle(self, values: Array) -> Array:
        return np.asarray(
            pin.AngleAxis(self.radians_per_unit * values[3], unit(values[:3])).toRotationMatrix()
        )

    def _from_euler(self, values: Array) -> Array:
        return self.rotation_from_euler(values)

    def rotation_from_euler(self, values: Array) -> Array:
        """Return the rotation of three angles, in the sequence and unit of the file."""
        rotation = np.eye(3)
        for letter, angle in zip(self._sequence, values, strict=True):
            turn = pin.utils.rotate(letter.lower(), self.radians_per_unit * angle)
            # Small letters rotate about the axes that were already rotated, capitals about those of
            # the parent.
            rotation = rotation @ turn if letter.islower() else turn @ rotation
        return rotation

    def _from_xyaxes(self, values: Array) -> Array:
        x = unit(values[:3])
        y = unit(values[3:] - (values[3:] @ x) * x)
        return np.column_stack([x, y, np.cross(x, y)])

    def _from_zaxis(self, values: Array) -> Array:
        return rotation_to(values)

    def ends(self, element: ElementTree.Element) -> tuple[pin.SE3, float] | None:
        """Return center and half length of an element that is given as the two ends of its z axis.

        The attribute is ``fromto``; return None if it is missing.
        """
        ends = self.numbers(element, "fromto", 6)
        if ends is None:
            return None
        axis = ends[:3] - ends[3:]
        try:
            return pin.SE3(rotation_to(axis), 0.5 * (ends[:3] + ends[3:])), 0.5 * float(
                np.linalg.norm(axis)
            )
        except ZeroDivisionError:
            raise self.wrong(
                f"{described(element)}: the two ends in fromto are the same point"
            ) from None


def text_of(values: ArrayLike) -> str:
    """Return numbers as the text of an attribute, with all of their digits."""
    return " ".join(f"{value:.17g}" for value in np.asarray(values, dtype=float))


def set_place(element: ElementTree.Element, placement: pin.SE3) -> None:
    """Set the position and quaternion of an element."""
    quaternion = pin.Quaternion(placement.rotation)
    element.set("pos", text_of(placement.translation))
    element.set("quat", text_of([quaternion.w, quaternion.x, quaternion.y, quaternion.z]))


def unit(vector: Array) -> Array:
    """Return a vector divided by its length; raise :class:`ZeroDivisionError` if it has none."""
    length = float(np.linalg.norm(vector))
    if length < SHORTEST:
        raise ZeroDivisionError
    return np.asarray(vector / length)


def rotation_to(direction: Array) -> Array:
    """Return the shortest rotation of z to a direction.

    It is half a turn about x if the direction is downward.
    """
    direction = unit(direction)
    axis = np.cross([0.0, 0.0, 1.0], direction)
    sine = float(np.linalg.norm(axis))
    axis = axis / sine if sine > 1e-10 else np.array([1.0, 0.0, 0.0])
    return np.asarray(pin.AngleAxis(np.arctan2(sine, direction[2]), axis).toRotationMatrix())
