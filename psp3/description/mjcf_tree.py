"""Rewrite the tree of an MJCF file so that Pinocchio's parser reads it as MuJoCo does.

The rewritten tree is called plain MJCF.

Pinocchio's parser reads only the first body of the world and ignores its placement. It merges
several joints of a body into one composite joint. It ignores orientations of geoms without a
position, masses of geoms that collide with nothing, sites of bodies without joints, and included
files. It does not know that a range can be switched off. So plain MJCF has one body ``world`` that
holds all others, at most one joint to a body, explicit inertias and orientations, and no classes.
The limits of the joints are stored separately.
"""

from __future__ import annotations

import re
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from psp3.checks import Array
from psp3.description.meshes import not_opened
from psp3.description.mjcf_document import SHORTEST, MjcfDocument, set_place, text_of
from psp3.description.mjcf_inertia import SIZES, MjcfInertias, placed
from psp3.description.xml import described

IN_A_BODY = {"inertial", "joint", "freejoint", "geom", "site", "body", "camera", "light"}
"""The elements that a body may hold."""

BETWEEN_JOINTS = re.compile(r"(?P<owner>.*):\d+", re.DOTALL)
"""Name of the massless body between two joints of one body, made of that body's name."""

RESERVED = "universe"
"""Pinocchio's name for the fixed world; its parser crashes if a joint has this name."""

COLLISION_GROUP = 3
"""By convention, geoms of this group and above are for collisions only. MuJoCo's viewer hides them.
"""


class MjcfJoint(NamedTuple):
    """A joint of an MJCF file, with properties that are set after Pinocchio has built the tree."""

    name: str
    """Its name in the tree."""
    kind: str
    """``hinge``, ``slide``, ``ball`` or ``free``."""
    reference: float
    """MuJoCo's coordinate where Pinocchio's is zero [m or rad]."""
    limits: tuple[float, float]
    """Limits of Pinocchio's coordinate [m or rad]."""
    effort: tuple[float, float]
    """Limits of the force [N or N m]."""
    damping: float
    """Viscous friction [N s/m or N m s]."""
    friction: float
    """Dry friction, MuJoCo's ``frictionloss`` [N or N m]."""
    armature: float
    """Inertia of the motor, seen at the joint [kg or kg m²]."""
    stiffness: float
    """Stiffness of the spring in the joint [N/m or N m]."""
    rest: float
    """Pinocchio's coordinate where the spring is at rest [m or rad]."""
    placement: pin.SE3
    """Placement of its body in the parent body, as in the file."""
    axis: Array
    """Axis of a hinge or slide, in the axes of its body, (3,)."""


class PlainMjcf(NamedTuple):
    """A tree in plain MJCF."""

    root: ElementTree.Element
    """The root element for Pinocchio's parser."""
    bodies: tuple[str, ...]
    """Names of the bodies, ``world`` first."""
    joints: tuple[MjcfJoint, ...]
    """The joints, in the order of MuJoCo's coordinates."""
    sites: dict[str, tuple[str, pin.SE3]]
    """The body of each site, and the site's placement in it."""
    unreadable: dict[str, str]
    """Files of meshes that cannot be drawn, with the reason."""
    from_outside: tuple[str, ...]
    """Bodies that a MuJoCo user moves from outside (``mocap``)."""

    def leave_out_unreadable(self) -> bool:
        """Remove shapes whose meshes cannot be read; tell whether there were any."""
        import coal

        lost = set()
        for mesh in self.root.iter("mesh"):
            try:
                coal.MeshLoader().load(mesh.attrib["file"], np.ones(3))
            except ValueError as error:
                self.unreadable[mesh.attrib["file"]] = str(error).strip().splitlines()[-1]
                lost.add(mesh.attrib["name"])
        for holder in list(self.root.iter()):
            for one in list(holder):
                if one.get("mesh") in lost or (one.tag == "mesh" and one.get("name") in lost):
                    holder.remove(one)
        return bool(lost)


def plain_mjcf(document: MjcfDocument) -> PlainMjcf:
    """Return the tree of an MJCF file as plain MJCF.

    Parameters
    ----------
    document : MjcfDocument
        The file.

    Returns
    -------
    PlainMjcf
        The tree, and its joints and sites.

    Raises
    ------
    InvalidRobotFile
        If MuJoCo would refuse a number, name or element of the tree, or an element is not
        supported.
    """
    return _Writer(document).write()


class _Writer:
    """Writes the plain tree while it walks through the bodies of a file."""

    def __init__(self, document: MjcfDocument) -> None:
        self.document = document
        self.inertias = MjcfInertias(document)
        self.bodies: dict[str, None] = {}
        self.joints: dict[str, MjcfJoint] = {}
        self.sites: dict[str, tuple[str, pin.SE3]] = {}
        self.assets: dict[str, ElementTree.Element] = {}
        self.meshes: dict[str, tuple[str, str]] = {}
        self.unreadable: dict[str, str] = {}
        self.from_outside: list[str] = []
        # Scaling to a total mass needs the mass of every body.
        self.total_mass = document.total_mass()
        self.colors: dict[str, str] = {}
        for element in document.section("asset"):
            if element.tag == "material":
                self.colors[element.get("name", "")] = element.get("rgba", "1 1 1 1")
            elif element.tag == "mesh":
                self.assets[element.get("name", "")] = element

    def write(self) -> PlainMjcf:
        root = ElementTree.Element("mujoco", model=self.document.root.get("model", "MuJoCo Model"))
        ElementTree.SubElement(root, "compiler", angle="radian")
        items = list(self.document.section("worldbody"))
        if not any(item.tag == "body" for item in items):
            raise self.document.wrong("has no <body> in its <worldbody>")
        for item in items:
            if item.tag in ("joint", "freejoint", "inertial"):
                raise self.document.wrong(
                    f"{described(item)} is in the <worldbody>, which cannot move"
                )
        body = _write_body(ElementTree.SubElement(root, "worldbody"), "world", pin.SE3.Identity())
        # Bodies fixed to the world need no inertia.
        _write_inertia(body, pin.Inertia.Zero())
        self.bodies["world"] = None
        self._fill(body, "world", items, False)
        asset = ElementTree.Element("asset")
        for name, (file, scale) in self.meshes.items():
            ElementTree.SubElement(asset, "mesh", name=name, file=file, scale=scale)
        root.insert(1, asset)
        if self.total_mass is not None:
            _scale_masses(root, self.total_mass)
        return PlainMjcf(
            root,
            tuple(self.bodies),
            tuple(self.joints.values()),
            self.sites,
            self.unreadable,
            tuple(self.from_outside),
        )

    def _fill(
        self,
        body: ElementTree.Element,
        name: str,
        items: Iterable[ElementTree.Element],
        moves: bool,
    ) -> None:
        """Write the shapes and child bodies of a body, and record its sites."""
        for item in items:
            if item.tag not in IN_A_BODY:
                raise self.document.wrong(
                    f"<{item.tag}> in body {name!r} is not read; {self.document.advice}"
                )
            if item.tag == "site":
                self._site(item, name)
            elif item.tag == "geom":
                self._shape(item, body)
            elif item.tag == "body":
                self._body(item, body, name, moves)

    def _body(
        self,
        element: ElementTree.Element,
        parent: ElementTree.Element,
        above: str,
        moves: bool,
    ) -> None:
        name = element.get("name") or f"body_{len(self.bodies)}"
        self._not_reserved(element, name)
        if name in self.bodies:
            raise self.document.wrong(f"there are two bodies {name!r}")
        self.bodies[name] = None
        if self.document.is_true(element, "mocap", False):
            self.from_outside.append(name)
        placement, body = self.document.placement(element), parent
        joints = [item for item in element if item.tag in ("joint", "freejoint")]
        if any(item.tag == "freejoint" or item.get("type") == "free" for item in joints) and (
            len(joints) > 1 or above != "world"
        ):
            raise self.document.wrong(
                f"{described(element)}: a free joint must be the only one of a body right in the "
                "<worldbody>"
            )
        for number, joint in enumerate(joints, start=1):
            if number < len(joints):
                # The first joint of a body is nearest to the parent: it carries the others.
                body = _write_body(body, f"{name}:{number}", placement)
                _write_inertia(body, pin.Inertia.Zero())
                self._joint(joint, body, name, placement)
                placement = pin.SE3.Identity()
        body = _write_body(body, name, placement)
        if joints:
            self._joint(joints[-1], body, name, placement)
        moves = moves or bool(joints)
        _write_inertia(body, self.inertias.of(element, moves or self.total_mass is not None))
        self._fill(body, name, element, moves)

    def _joint(
        self,
        element: ElementTree.Element,
        body: ElementTree.Element,
        owner: str,
        placement: pin.SE3,
    ) -> None:
        document = self.document
        kind = "free" if element.tag == "freejoint" else element.get("type", "hinge")
        if kind not in ("hinge", "slide", "ball", "free"):
            raise document.wrong(
                f"{described(element)}: type {kind!r} is unknown; known are hinge, slide, ball "
                "and free"
            )
        if document.numbers(element, "springdamper", 2) is not None:
            raise document.wrong(
                f"{described(element)}: springdamper, whose stiffness depends on the inertia of "
                "the whole robot, is not read; give stiffness and damping"
            )
        name = element.get("name") or f"{owner}_joint_{len(self.joints) + 1}"
        self._not_reserved(element, name)
        if name in self.joints:
            raise document.wrong(f"there are two joints {name!r}")
        plain = ElementTree.SubElement(body, "joint", name=name, type=kind)
        if kind != "free":
            plain.set("pos", text_of(document.vector(element, "pos")))
        axis = document.vector(element, "axis", (0.0, 0.0, 1.0))
        if kind in ("hinge", "slide"):
            if np.linalg.norm(axis) < SHORTEST:
                raise document.wrong(f"{described(element)}: the axis is zero")
            axis = axis / np.linalg.norm(axis)
            plain.set("axis", text_of(axis))
        turns = document.radians_per_unit if kind in ("hinge", "ball") else 1.0
        reference = (
            turns * document.number(element, "ref", 0.0) if kind in ("hinge", "slide") else 0.0
        )
        limits = (
            self._range(element, "range", "limited")
            if kind in ("hinge", "slide")
            else (-np.inf, np.inf)
        )
        self.joints[name] = MjcfJoint(
            name,
            kind,
            reference,
            (turns * limits[0] - reference, turns * limits[1] - reference),
            self._range(element, "actuatorfrcrange", "actuatorfrclimited"),
            document.number(element, "damping", 0.0),
            document.number(element, "frictionloss", 0.0),
            document.number(element, "armature", 0.0),
            document.number(element, "stiffness", 0.0),
            turns * document.number(element, "springref", 0.0) - reference,
            placement,
            axis,
        )

    def _range(
        self, element: ElementTree.Element, attribute: str, switch: str
    ) -> tuple[float, float]:
        """Return a range; it is infinite if its switch is off.

        With ``autolimits`` the switch is on if the range is given.
        """
        ends, state = self.document.numbers(element, attribute, 2), element.get(switch, "auto")
        automatic = ends is not None and ends.any()
        if state not in ("true", "false", "auto"):
            raise self.document.wrong(
                f"{described(element)}: {switch} must be true, false or auto, got {state!r}"
            )
        if state == "false" or (state == "auto" and not automatic):
            return -np.inf, np.inf
        if ends is None or not ends[0] < ends[1]:
            raise self.document.wrong(
                f"{described(element)}: {attribute} must be two numbers, the smaller one first, "
                f"got {element.get(attribute)!r}"
            )
        return float(ends[0]), float(ends[1])

    def _not_reserved(self, element: ElementTree.Element, name: str | None) -> None:
        if name == RESERVED:
            raise self.document.wrong(
                f"{described(element)}: Pinocchio keeps the name {RESERVED!r} for itself; choose "
                "another"
            )

    # Sites and shapes

    def _site(self, element: ElementTree.Element, owner: str) -> None:
        name = element.get("name")
        self._not_reserved(element, name)
        if name in self.sites:
            raise self.document.wrong(f"there are two sites {name!r}")
        if name is not None:
            ends = self.document.ends(element)
            self.sites[name] = owner, self.document.placement(element) if ends is None else ends[0]

    def _shape(self, geom: ElementTree.Element, body: ElementTree.Element) -> None:
        """Write a geom that is drawn.

        Infinite geoms, and those for collisions only, are left out.
        """
        kind = geom.get("type", "sphere")
        if kind not in ("plane", "hfield", "sdf", "mesh", *SIZES):
            raise self.document.wrong(f"{described(geom)}: type {kind!r} is unknown")
        if self.document.number(geom, "group", 0.0) >= COLLISION_GROUP or kind in (
            "plane",
            "hfield",
            "sdf",
        ):
            return
        plain = ElementTree.Element("geom", type=kind, contype="0", conaffinity="0")
        if kind == "mesh":
            if not self._is_drawn(geom.get("mesh", "")):
                return
            plain.set("mesh", geom.attrib["mesh"])
            placement = self.document.placement(geom)
        elif geom.get("mesh") is not None:
            # MuJoCo fits this primitive shape to a mesh.
            return
        else:
            placement, sizes = placed(self.document, geom, kind)
            plain.set("size", text_of(sizes))
        color = geom.get("rgba", self.colors.get(geom.get("material", ""), "0.5 0.5 0.5 1"))
        plain.set("rgba", text_of(self._color(geom, color)))
        set_place(plain, placement)
        body.append(plain)

    def _color(self, geom: ElementTree.Element, text: str) -> ArrayLike:
        color = self.document.numbers(ElementTree.Element("geom", rgba=text), "rgba", 4)
        return (0.5, 0.5, 0.5, 1.0) if color is None else color

    def _is_drawn(self, name: str) -> bool:
        """Return whether a mesh can be read, and if so, store it for drawing."""
        element = self.assets.get(name)
        if name in self.meshes or element is None:
            return name in self.meshes
        path = element.get("file")
        if path is None:
            self.unreadable[name] = "has no file"
            return False
        reason = "no such file" if not Path(path).is_file() else not_opened(path)
        if reason:
            self.unreadable[path] = reason
            return False
        scale = self.document.vector(element, "scale", (1.0, 1.0, 1.0))
        self.meshes[name] = path, text_of(scale)
        return True


def _scale_masses(root: ElementTree.Element, total: float) -> None:
    """Multiply all masses and inertias so that the masses add up to a given one [kg]."""
    inertials = list(root.iter("inertial"))
    share = total / sum(float(one.attrib["mass"]) for one in inertials)
    for one in inertials:
        for key in ("mass", "fullinertia"):
            one.set(key, text_of([share * float(number) for number in one.attrib[key].split()]))


def _write_body(parent: ElementTree.Element, name: str, placement: pin.SE3) -> ElementTree.Element:
    body = ElementTree.SubElement(parent, "body", name=name)
    set_place(body, placement)
    return body


def _write_inertia(body: ElementTree.Element, inertia: pin.Inertia) -> None:
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = inertia.inertia
    full = text_of([xx, yy, zz, xy, xz, yz])
    ElementTree.SubElement(
        body, "inertial", pos=text_of(inertia.lever), mass=text_of([inertia.mass]), fullinertia=full
    )
