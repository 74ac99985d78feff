"""Expand an MJCF file until every element stands for itself.

``frame`` is merged into the poses in it, ``replicate`` and ``attach`` are replaced by the bodies
that they copy, and classes by attributes. Orientations become quaternions, and angles are converted
to radians. Bodies, joints, geoms and sites with their own attributes remain.

Attached models have their own compiler settings, classes and meshes, so each file is expanded
before it is attached. Loops, couplings, tendons and motors that refer only to attached elements are
copied with them; key frames are not.
"""

from __future__ import annotations

import copy
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import pinocchio as pin

from fuzzy2.support.bounded_files import MOST_ELEMENTS
from psp3.description.mjcf_document import MjcfDocument, text_of
from psp3.description.xml import described

PLACED = {"body", "geom", "site", "camera", "light", "inertial", "joint", "freejoint"}
"""Elements of a body that have a placement in it."""

TURNS = ("range", "ref", "springref")
"""Attributes of a joint that are angles if it is a hinge or ball."""

LIMITS = {"range": "limited", "actuatorfrcrange": "actuatorfrclimited"}
"""Limits of a joint, with the attribute that switches each on."""

OWNERS = {
    "joint": "joint",
    "joint1": "joint",
    "joint2": "joint",
    "jointinparent": "joint",
    "body": "body",
    "body1": "body",
    "body2": "body",
    "site": "site",
    "site1": "site",
    "site2": "site",
    "sidesite": "site",
    "refsite": "site",
    "cranksite": "site",
    "slidersite": "site",
    "geom": "geom",
    "tendon": "tendon",
    "tendon1": "tendon",
    "tendon2": "tendon",
}
"""Attributes that refer to another element, with the kind of that element."""


def spelled_out(path: str | Path) -> MjcfDocument:
    """Return an expanded MJCF file.

    Parameters
    ----------
    path : path
        The file.

    Returns
    -------
    MjcfDocument
        The file without classes, ``frame``, ``replicate`` and ``attach``.

    Raises
    ------
    InvalidRobotFile
        If the file, or one that it includes or attaches, is missing, malformed or refers to itself.
    """
    return _Expansion(MjcfDocument(path)).result()


class _Expansion:
    """Expands one file, part by part."""

    def __init__(self, document: MjcfDocument) -> None:
        self.document = document
        self.models = {
            str(item.get("name") or other.document.root.get("model", "MuJoCo Model")): other
            for item in document.section("asset")
            if item.tag == "model"
            for other in [_Expansion(document.attached(item))]
        }
        self._places: dict[tuple[str, str], tuple[ElementTree.Element, str | None]] | None = None
        # Elements of other sections that were copied with attached elements.
        self.additions: list[tuple[str, ElementTree.Element]] = []

    def result(self) -> MjcfDocument:
        """Return the whole expanded file."""
        root = ElementTree.Element("mujoco", self.document.root.attrib)
        world = ElementTree.SubElement(root, "worldbody")
        for section in self.document.root.findall("worldbody"):
            self.fill(world, section, None, pin.SE3.Identity())
        for tag, item in [*self.sections(), *self.additions]:
            holder = root.find(tag)
            if item.tag == tag:
                root.append(item)
            else:
                (ElementTree.SubElement(root, tag) if holder is None else holder).append(item)
        return self.document.written_out(root)

    # Sections other than the tree

    def sections(self) -> list[tuple[str, ElementTree.Element]]:
        """Return the elements of all other sections, with what they inherit."""
        written = []
        for section in self.document.root:
            self.document.spend(elements=1)
            if section.tag in ("option", "size", "statistic"):
                # These sections have attributes of their own.
                written.append((section.tag, section))
            elif section.tag not in ("default", "compiler", "worldbody"):
                self.document.spend(elements=len(section))
                written += [
                    (section.tag, self._item(section.tag, item))
                    for item in section
                    if item.tag != "model"
                ]
        return written

    def _item(self, section: str, item: ElementTree.Element) -> ElementTree.Element:
        if section not in ("asset", "equality", "tendon", "actuator"):
            return item
        # MuJoCo has one default for all kinds of equality, and one for all kinds of tendon.
        full = self.document.full(item, tag=section if section in ("equality", "tendon") else None)
        full.extend(item)
        full.attrib.pop("class", None)
        if item.tag == "mesh":
            self.document.locate(full)
        return full

    # The tree

    def fill(
        self,
        parent: ElementTree.Element,
        items: Iterable[ElementTree.Element],
        child_class: str | None,
        frame: pin.SE3,
    ) -> None:
        """Write elements of a frame into its body."""
        for item in items:
            self.document.spend(elements=1)
            inner_class = item.get("childclass", child_class)
            if item.tag == "frame":
                self.fill(parent, item, inner_class, frame * self.document.placement(item))
            elif item.tag == "replicate":
                self._replicate(parent, item, inner_class, frame)
            elif item.tag == "attach":
                self._attach(parent, item, frame)
            elif item.tag in PLACED:
                plain = self._placed(item, child_class, frame)
                parent.append(plain)
                if item.tag == "body":
                    self.fill(plain, item, inner_class, pin.SE3.Identity())
            else:
                parent.append(item)

    def _placed(
        self, item: ElementTree.Element, child_class: str | None, frame: pin.SE3
    ) -> ElementTree.Element:
        """Return an element with all of its attributes, placed in its body."""
        document = self.document
        if item.tag in ("body", "inertial", "freejoint"):
            plain = ElementTree.Element(item.tag, item.attrib)
        else:
            plain = document.full(item, child_class)
        for key in ("class", "childclass"):
            plain.attrib.pop(key, None)
        if item.tag == "joint":
            self._joint(plain, frame)
        elif item.tag != "freejoint":
            document.place_in(plain, frame)
        if item.tag == "body":
            # The inertia of a body depends on the settings of the file that it comes from.
            document.settings[plain] = {**document.compiler, "own_pos": item.get("pos", "0 0 0")}
        return plain

    def _joint(self, joint: ElementTree.Element, frame: pin.SE3) -> None:
        document = self.document
        if not frame.isIdentity(0.0):
            joint.set("pos", text_of(frame.act(document.vector(joint, "pos"))))
            axis = document.vector(joint, "axis", (0.0, 0.0, 1.0))
            joint.set("axis", text_of(frame.rotation @ axis))
        if joint.get("type", "hinge") in ("hinge", "ball") and document.radians_per_unit != 1.0:
            for key in TURNS:
                values = document.numbers(joint, key)
                if values is not None:
                    joint.set(key, text_of(document.radians_per_unit * values))
        if document.compiler.get("autolimits", "true") == "false":
            for key, switch in LIMITS.items():
                if joint.get(key) is not None and joint.get(switch, "auto") == "auto":
                    raise document.wrong(
                        f"{described(joint)} has {key} but not {switch}, and the compiler's "
                        "autolimits is false: say which is meant"
                    )

    # Copies

    def _replicate(
        self,
        parent: ElementTree.Element,
        item: ElementTree.Element,
        child_class: str | None,
        frame: pin.SE3,
    ) -> None:
        document = self.document
        count = document.number(item, "count", -1.0)
        if not 0 <= count <= MOST_ELEMENTS or count != int(count):
            raise document.wrong(
                f"<replicate>: count must be a whole number up to {MOST_ELEMENTS}, got "
                f"{item.get('count')!r}"
            )
        offset, angles = document.vector(item, "offset"), document.vector(item, "euler")
        turn = pin.SE3(document.rotation_from_euler(angles), np.zeros(3))
        # The offset is applied in the frame of the preceding copy, so it rotates with the copies.
        place = pin.SE3.Identity()
        # Empty copies count, too, because a million of them would also take long.
        document.spend(elements=int(count))
        digits = len(str(int(count)))
        for number in range(int(count)):
            place.rotation = document.rotation_from_euler(number * angles)
            copied = ElementTree.Element("body")
            self.fill(copied, item, child_class, frame * place)
            ending = f"{item.get('sep', '')}{number:0{digits}d}"
            self._rename(copied, "", ending, "")
            parent.extend(list(copied))
            place = place * pin.SE3(np.eye(3), offset) * turn

    def _attach(
        self, parent: ElementTree.Element, item: ElementTree.Element, frame: pin.SE3
    ) -> None:
        """Insert a body, a frame or a whole model, with the elements that refer to it."""
        document, prefix, model = self.document, item.get("prefix", ""), item.get("model")
        if model is not None and model not in self.models:
            raise document.wrong(
                f"<attach>: there is no model {model!r}; those of <asset> are "
                f"{', '.join(self.models) or 'none'}"
            )
        other = self if model is None else self.models[model]
        kind = "frame" if item.get("body") is None else "body"
        name, copied = item.get(kind), ElementTree.Element("body")
        if name is not None:
            found = other.place_of(kind, name)
            if found is None:
                raise document.wrong(f"<attach>: there is no {kind} {name!r} to attach")
            if model is None and item in found[0].iter():
                raise document.wrong(f"<attach>: {kind} {name!r} would attach itself")
            other.fill(copied, [found[0]], found[1], frame)
        elif model is None:
            raise document.wrong("<attach> needs a model, a body or a frame")
        else:
            for section in other.document.root.findall("worldbody"):
                other.fill(copied, section, None, frame)
        names = {
            ("joint" if one.tag == "freejoint" else one.tag, one.get("name"))
            for one in copied.iter()
        }
        self._rename(copied, prefix, "", "" if other is self else prefix)
        parent.extend(list(copied))
        self._bring_along(other, names, prefix)

    def _bring_along(
        self, other: _Expansion, names: set[tuple[str, str | None]], prefix: str
    ) -> None:
        """Copy elements that refer only to attached elements."""
        items = other.sections() + (other.additions if other is not self else [])
        if other is not self:
            for tag, item in items:
                if tag == "asset":
                    self._add(tag, item, prefix, prefix)
        # Tendons first: motors and equalities may refer to them.
        for wanted in ("tendon", "equality", "actuator"):
            for tag, item in items:
                if tag != wanted:
                    continue
                references = [
                    (OWNERS[key], value)
                    for one in item.iter()
                    for key, value in one.attrib.items()
                    if key in OWNERS and (OWNERS[key], value) != ("body", "world")
                ]
                if references and names.issuperset(references):
                    self._add(tag, item, prefix, "")
                    if tag == "tendon":
                        names.add(("tendon", item.get("name")))

    def _add(self, tag: str, item: ElementTree.Element, prefix: str, assets: str) -> None:
        self.document.spend(elements=sum(1 for _ in item.iter()))
        copied = ElementTree.Element("section")
        copied.append(copy.deepcopy(item))
        self._rename(copied, prefix, "", assets)
        for one in copied.iter():
            for key, value in one.attrib.items():
                if key in OWNERS and (OWNERS[key], value) != ("body", "world"):
                    one.set(key, prefix + value)
        self.additions.append((tag, copied[0]))

    def _rename(self, holder: ElementTree.Element, prefix: str, ending: str, assets: str) -> None:
        """Rename an element and all in it, and the meshes and materials that they refer to."""
        for one in holder.iter():
            if one.get("name"):
                self.document.named(one, prefix + one.attrib["name"] + ending)
            for key in ("mesh", "material"):
                if assets and one.get(key):
                    one.set(key, assets + one.attrib[key])

    def place_of(self, tag: str, name: str) -> tuple[ElementTree.Element, str | None] | None:
        """Return the body or frame with a name, and the class that it inherits."""
        if self._places is None:
            self._places = {}
            _list_places(self.document.root, None, self._places)
        return self._places.get((tag, name))


def _list_places(
    element: ElementTree.Element,
    child_class: str | None,
    found: dict[tuple[str, str], tuple[ElementTree.Element, str | None]],
) -> None:
    """List all bodies and frames; the first one if several have the same name."""
    for child in element:
        if child.tag in ("body", "frame"):
            found.setdefault((child.tag, child.get("name", "")), (child, child_class))
        if child.tag in ("worldbody", "body", "frame", "replicate"):
            _list_places(child, child.get("childclass", child_class), found)
