"""The tree of an MJCF file in plain words.

Pinocchio's MJCF parser reads these as MuJoCo means them.

That parser takes only the first body of the world and forgets where it stands; makes one composite
joint of several joints of a body; passes over orientations of geoms without a position, masses of
geoms that collide with nothing, sites of bodies without joints, and included files; and does not
know a range that is switched off. So the tree is written out for it: one body ``world`` that holds
all others, at most one joint to a body, every inertia and orientation explicit, no classes. What
its joints are limited to is kept beside.
"""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from psp3.description.mjcf_document import MjcfDocument
from psp3.description.xml import check_inertia, described

IN_A_BODY = {"inertial", "joint", "freejoint", "geom", "site", "body", "camera", "light"}
"""What a body may hold."""

SIZES = {"sphere": 1, "capsule": 2, "cylinder": 2, "ellipsoid": 3, "box": 3}
"""Geoms whose mass and shape follow from numbers in the file, and how many sizes each has."""

UNIT_DENSITY = 1000.0
"""Density of a geom that gives none [kg/m³]."""

COLLISION_GROUP = 3
"""From this group on, geoms are by custom for collisions only, and MuJoCo's viewer hides them."""


class MjcfJoint(NamedTuple):
    """A joint of an MJCF file, with what Pinocchio is told of it after it has built the tree."""

    name: str
    """Its name in the tree."""
    kind: str
    """``hinge``, ``slide``, ``ball`` or ``free``."""
    reference: float
    """MuJoCo's coordinate where Pinocchio's is zero [m or rad]."""
    limits: tuple[float, float]
    """Of Pinocchio's coordinate [m or rad]."""
    effort: tuple[float, float]
    """Of the force [N or N·m]."""
    damping: float
    """Viscous friction [N s/m or N m s]."""
    friction: float
    """Dry friction, MuJoCo's ``frictionloss`` [N or N m]."""
    armature: float
    """Inertia of the motor, seen at the joint [kg or kg m²]."""
    stiffness: float
    """Of the spring in the joint [N/m or N m]."""
    rest: float
    """Pinocchio's coordinate where the spring is at rest [m or rad]."""


class PlainMjcf(NamedTuple):
    """A tree in plain MJCF."""

    root: ElementTree.Element
    """What Pinocchio reads."""
    bodies: tuple[str, ...]
    """Names of the bodies, ``world`` first."""
    joints: tuple[MjcfJoint, ...]
    """The joints, in the order of MuJoCo's coordinates."""
    sites: dict[str, tuple[str, pin.SE3]]
    """Body of each site, and its place there."""
    unreadable: dict[str, str]
    """Files of meshes that cannot be drawn, with the reason."""


def plain_mjcf(document: MjcfDocument) -> PlainMjcf:
    """Return the tree of an MJCF file in plain words.

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
        If a number, name or element of the tree is none that MuJoCo takes, or says something that
        is not read.
    """
    return _Writer(document).write()


class _Writer:
    """Writes the plain tree while it walks through the bodies of a file."""

    def __init__(self, document: MjcfDocument) -> None:
        self.document = document
        self.bodies: list[str] = []
        self.joints: dict[str, MjcfJoint] = {}
        self.sites: dict[str, tuple[str, pin.SE3]] = {}
        self.meshes: dict[str, tuple[str, str]] = {}
        self.unreadable: dict[str, str] = {}
        self.colors: dict[str, str] = {}
        for element in document.section("asset"):
            if element.tag == "material":
                self.colors[element.get("name", "")] = document.full(element).get("rgba", "1 1 1 1")
            elif element.tag == "mesh":
                self._mesh(document.full(element))

    def write(self) -> PlainMjcf:
        root = ElementTree.Element("mujoco", model=self.document.root.get("model", "MuJoCo Model"))
        ElementTree.SubElement(root, "compiler", angle="radian")
        asset = ElementTree.SubElement(root, "asset")
        for name, (file, scale) in self.meshes.items():
            ElementTree.SubElement(asset, "mesh", name=name, file=file, scale=scale)
        items = list(self.document.section("worldbody"))
        if not any(item.tag == "body" for item in items):
            raise self.document.wrong("has no <body> in its <worldbody>")
        for item in items:
            if item.tag in ("joint", "freejoint", "inertial"):
                raise self.document.wrong(
                    f"{described(item)} is in the <worldbody>, which cannot move"
                )
        body = _write_body(ElementTree.SubElement(root, "worldbody"), "world", pin.SE3.Identity())
        # What stands on the world needs no inertia.
        _write_inertia(body, pin.Inertia.Zero())
        self.bodies.append("world")
        self._fill(body, "world", items, None)
        return PlainMjcf(
            root, tuple(self.bodies), tuple(self.joints.values()), self.sites, self.unreadable
        )

    def _fill(
        self,
        body: ElementTree.Element,
        name: str,
        items: Iterable[ElementTree.Element],
        child_class: str | None,
    ) -> None:
        """Write shapes and bodies of a body, and note its sites."""
        for item in items:
            if item.tag not in IN_A_BODY:
                raise self.document.wrong(
                    f"<{item.tag}> in body {name!r} is not read; {self.document.advice}"
                )
            if item.tag == "site":
                self._site(self.document.full(item, child_class), name)
            elif item.tag == "geom":
                self._shape(self.document.full(item, child_class), body)
            elif item.tag == "body":
                self._body(item, body, name, child_class)

    def _body(
        self,
        element: ElementTree.Element,
        parent: ElementTree.Element,
        above: str,
        child_class: str | None,
    ) -> None:
        name = element.get("name") or f"body_{len(self.bodies)}"
        if name in self.bodies:
            raise self.document.wrong(f"there are two bodies {name!r}")
        self.bodies.append(name)
        if self.document.is_true(element, "mocap", False):
            raise self.document.wrong(
                f"{described(element)} is moved from outside (mocap), which is not read"
            )
        child_class = element.get("childclass", child_class)
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
                # The first joint of a body is the first to move it: it carries the others.
                body = _write_body(body, f"{name}:{number}", placement)
                _write_inertia(body, pin.Inertia.Zero())
                self._joint(joint, body, name, child_class)
                placement = pin.SE3.Identity()
        body = _write_body(body, name, placement)
        if joints:
            self._joint(joints[-1], body, name, child_class)
        _write_inertia(body, self._inertia(element, child_class))
        self._fill(body, name, element, child_class)

    def _joint(
        self,
        element: ElementTree.Element,
        body: ElementTree.Element,
        owner: str,
        child_class: str | None,
    ) -> None:
        document = self.document
        if element.tag == "joint":
            element = document.full(element, child_class)
        kind = "free" if element.tag == "freejoint" else element.get("type", "hinge")
        if kind not in ("hinge", "slide", "ball", "free"):
            raise document.wrong(
                f"{described(element)}: type {kind!r} is unknown; known are hinge, slide, ball "
                "and free"
            )
        name = element.get("name") or f"{owner}_joint_{len(self.joints) + 1}"
        if name in self.joints:
            raise document.wrong(f"there are two joints {name!r}")
        plain = ElementTree.SubElement(body, "joint", name=name, type=kind)
        if kind != "free":
            plain.set("pos", _text(document.vector(element, "pos")))
        if kind in ("hinge", "slide"):
            axis = document.vector(element, "axis", (0.0, 0.0, 1.0))
            if not axis.any():
                raise document.wrong(f"{described(element)}: the axis is zero")
            plain.set("axis", _text(axis / np.linalg.norm(axis)))
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
        )

    def _range(
        self, element: ElementTree.Element, attribute: str, switch: str
    ) -> tuple[float, float]:
        """Return a range that counts if its switch is on.

        It is by itself where there is one (``autolimits``).
        """
        ends, state = self.document.numbers(element, attribute, 2), element.get(switch, "auto")
        automatic = ends is not None and self.document.compiler.get("autolimits", "true") == "true"
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

    # Inertia

    def _inertia(self, element: ElementTree.Element, child_class: str | None) -> pin.Inertia:
        document = self.document
        from_geoms = document.compiler.get("inertiafromgeom", "auto")
        inertial = element.find("inertial")
        if inertial is not None and from_geoms != "true":
            inertia = self._given_inertia(element, inertial)
        elif from_geoms == "false":
            inertia = pin.Inertia.Zero()
        else:
            inertia = pin.Inertia.Zero()
            for geom in element.findall("geom"):
                inertia += self._inertia_of_geom(element, document.full(geom, child_class))
        return self._bounded(inertia)

    def _given_inertia(
        self, body: ElementTree.Element, inertial: ElementTree.Element
    ) -> pin.Inertia:
        document = self.document
        if inertial.get("mass") is None:
            raise document.wrong(f"{described(body)}: <inertial> needs a mass")
        mass = document.number(inertial, "mass", 0.0)
        diagonal, full = (
            document.numbers(inertial, "diaginertia", 3),
            document.numbers(inertial, "fullinertia", 6),
        )
        if diagonal is not None and full is None:
            matrix = np.diag(diagonal)
        elif full is not None and diagonal is None:
            xx, yy, zz, xy, xz, yz = full
            matrix = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        else:
            raise document.wrong(
                f"{described(body)}: <inertial> needs either diaginertia or fullinertia"
            )
        check_inertia(document.path, body, mass, matrix)
        placement = document.placement(inertial)
        return pin.Inertia(
            mass, placement.translation, placement.rotation @ matrix @ placement.rotation.T
        )

    def _bounded(self, inertia: pin.Inertia) -> pin.Inertia:
        """Return an inertia as the compiler's settings change it."""
        settings = ElementTree.Element("compiler", self.document.compiler)
        least_mass, least_moment = (
            self.document.number(settings, name, 0.0) for name in ("boundmass", "boundinertia")
        )
        moments, axes = np.linalg.eigh(inertia.inertia)
        balanced = np.maximum(moments, least_moment)
        if (
            self.document.is_true(settings, "balanceinertia", False)
            and balanced[2] > balanced[0] + balanced[1]
        ):
            balanced = np.full(3, balanced.mean())
        # Numbers that no setting changes stay as they are written, to the last digit.
        matrix = (
            inertia.inertia if (balanced == moments).all() else axes @ np.diag(balanced) @ axes.T
        )
        return pin.Inertia(max(inertia.mass, least_mass), inertia.lever, matrix)

    def _inertia_of_geom(self, body: ElementTree.Element, geom: ElementTree.Element) -> pin.Inertia:
        document = self.document
        kind = geom.get("type", "mesh" if geom.get("mesh") else "sphere")
        if kind in ("plane", "hfield"):
            return pin.Inertia.Zero()
        mass = document.number(geom, "mass", -1.0) if geom.get("mass") is not None else None
        density = document.number(geom, "density", UNIT_DENSITY)
        if (mass is not None and mass < 0.0) or density < 0.0:
            raise document.wrong(
                f"{described(body)}: {described(geom)} has a negative mass or density"
            )
        if (density if mass is None else mass) == 0.0:
            return pin.Inertia.Zero()
        if kind not in SIZES or document.is_true(geom, "shellinertia", False):
            raise document.wrong(
                f"{described(body)}: the inertia of a {kind} is not computed here; give the body "
                "an <inertial>"
            )
        placement, sizes = self._placed(geom, kind)
        return placement.act(
            _solid(kind, sizes, density * _volume(kind, sizes) if mass is None else mass)
        )

    def _placed(self, geom: ElementTree.Element, kind: str) -> tuple[pin.SE3, list[float]]:
        """Return place and sizes of a geom; lengths are halves, as in the file."""
        ends, sizes = self.document.ends(geom), self.document.numbers(geom, "size", 1, 2, 3)
        if ends is not None and kind == "sphere":
            raise self.document.wrong(
                f"{described(geom)}: a sphere cannot be given by its ends (fromto)"
            )
        needed = SIZES[kind] if ends is None else 1
        if sizes is None or sizes.size < needed or not (sizes[:needed] > 0.0).all():
            raise self.document.wrong(
                f"{described(geom)}: a {kind} needs {needed} positive sizes, got "
                f"{geom.get('size')!r}"
            )
        if ends is None:
            return self.document.placement(geom), [float(size) for size in sizes[:needed]]
        thickness = float(sizes[0])
        return ends[0], [thickness, ends[1]] if SIZES[kind] == 2 else [
            thickness,
            thickness,
            ends[1],
        ]

    # Sites and shapes

    def _site(self, element: ElementTree.Element, owner: str) -> None:
        name = element.get("name")
        if name in self.sites:
            raise self.document.wrong(f"there are two sites {name!r}")
        if name is not None:
            ends = self.document.ends(element)
            self.sites[name] = owner, self.document.placement(element) if ends is None else ends[0]

    def _shape(self, geom: ElementTree.Element, body: ElementTree.Element) -> None:
        """Write a geom for drawing.

        Those that are not finite, or for collisions only, are left out.
        """
        kind = geom.get("type", "mesh" if geom.get("mesh") else "sphere")
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
            if geom.get("mesh") not in self.meshes:
                return
            plain.set("mesh", geom.attrib["mesh"])
            placement = self.document.placement(geom)
        else:
            placement, sizes = self._placed(geom, kind)
            plain.set("size", _text(sizes))
        color = geom.get("rgba", self.colors.get(geom.get("material", ""), "0.5 0.5 0.5 1"))
        plain.set("rgba", _text(self._color(geom, color)))
        _place(plain, placement)
        body.append(plain)

    def _color(self, geom: ElementTree.Element, text: str) -> ArrayLike:
        color = self.document.numbers(ElementTree.Element("geom", rgba=text), "rgba", 4)
        return (0.5, 0.5, 0.5, 1.0) if color is None else color

    def _mesh(self, element: ElementTree.Element) -> None:
        """Keep a mesh for drawing, if it can be read."""
        import coal

        file, name = element.get("file"), element.get("name")
        if file is None:
            self.unreadable[name or "without a name"] = "has no file"
            return
        compiler = self.document.compiler
        if compiler.get("strippath") == "true":
            file = Path(file).name
        path = (
            self.document.path.parent / compiler.get("meshdir", compiler.get("assetdir", "")) / file
        ).resolve()
        scale = self.document.vector(element, "scale", (1.0, 1.0, 1.0))
        try:
            coal.MeshLoader().load(str(path), scale)
        except ValueError as error:
            self.unreadable[str(path)] = str(error).strip().splitlines()[-1]
            return
        self.meshes[name or Path(file).stem] = str(path), _text(scale)


def _volume(kind: str, sizes: list[float]) -> float:
    """Return the volume of a geom, with half lengths and radii as sizes [m³]."""
    ball = 4.0 / 3.0 * np.pi
    if kind == "sphere":
        return float(ball * sizes[0] ** 3)
    if kind == "ellipsoid":
        return float(ball * np.prod(sizes))
    if kind == "box":
        return float(8.0 * np.prod(sizes))
    radius, half = sizes
    return float(2.0 * np.pi * radius**2 * half + (ball * radius**3 if kind == "capsule" else 0.0))


def _solid(kind: str, sizes: list[float], mass: float) -> pin.Inertia:
    """Return the inertia of a homogeneous geom."""
    if kind == "sphere":
        return pin.Inertia.FromSphere(mass, *sizes)
    if kind == "ellipsoid":
        return pin.Inertia.FromEllipsoid(mass, *sizes)
    if kind == "box":
        return pin.Inertia.FromBox(mass, *(2.0 * size for size in sizes))
    radius, half = sizes
    return (pin.Inertia.FromCapsule if kind == "capsule" else pin.Inertia.FromCylinder)(
        mass, radius, 2.0 * half
    )


def _text(values: ArrayLike) -> str:
    return " ".join(f"{value:.17g}" for value in np.asarray(values, dtype=float))


def _place(element: ElementTree.Element, placement: pin.SE3) -> None:
    quaternion = pin.Quaternion(placement.rotation)
    element.set("pos", _text(placement.translation))
    element.set("quat", _text([quaternion.w, quaternion.x, quaternion.y, quaternion.z]))


def _write_body(parent: ElementTree.Element, name: str, placement: pin.SE3) -> ElementTree.Element:
    body = ElementTree.SubElement(parent, "body", name=name)
    _place(body, placement)
    return body


def _write_inertia(body: ElementTree.Element, inertia: pin.Inertia) -> None:
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = inertia.inertia
    full = _text([xx, yy, zz, xy, xz, yz])
    ElementTree.SubElement(
        body, "inertial", pos=_text(inertia.lever), mass=_text([inertia.mass]), fullinertia=full
    )
