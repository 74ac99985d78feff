"""Compute the inertias of the bodies of an MJCF file by MuJoCo's rules.

The inertia is a body's ``<inertial>`` or the sum over its geoms, modified by the compiler settings.
The inertia of a mesh is computed only if the body can move, so the mesh file of a fixed body need
not exist.
"""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np
import pinocchio as pin

from psp3.checks import Array
from psp3.description.mesh_inertia import KINDS, MeshInertia, hull, mesh_inertia
from psp3.description.meshes import Mesh, read_mesh
from psp3.description.mjcf_document import SHORTEST, MjcfDocument
from psp3.description.xml import check_inertia, described
from psp3.errors import InvalidFile

SIZES = {"sphere": 1, "capsule": 2, "cylinder": 2, "ellipsoid": 3, "box": 3}
"""Geoms that numbers in the file describe, and how many sizes each has."""

UNIT_DENSITY = 1000.0
"""Default density of a geom [kg/m³]."""


class MjcfInertias:
    """The inertias of the bodies of a file.

    Parameters
    ----------
    document : MjcfDocument
        The expanded file.
    """

    def __init__(self, document: MjcfDocument) -> None:
        self.document = document
        self._meshes = {
            element.get("name", ""): element
            for element in document.section("asset")
            if element.tag == "mesh"
        }
        self._known: dict[tuple[str, bool], MeshInertia] = {}

    def of(self, body: ElementTree.Element, moves: bool) -> pin.Inertia:
        """Return the inertia of a body.

        Parameters
        ----------
        body : Element
            The body.
        moves : bool
            Whether it can move. If not, its meshes are not read and have no mass.

        Returns
        -------
        pinocchio.Inertia

        Raises
        ------
        InvalidRobotFile
            If the inertia is not given and cannot be computed, or is negative.
        """
        document = self.document
        from_geoms = document.setting(body, "inertiafromgeom", "auto")
        inertial = body.find("inertial")
        if inertial is not None and from_geoms != "true":
            inertia = self._given_inertia(body, inertial)
        else:
            inertia = pin.Inertia.Zero()
            if from_geoms != "false":
                for geom in body.findall("geom"):
                    inertia += self._of_geom(body, geom, moves)
            if inertia.mass == 0.0:
                # If ``boundmass`` gives such a body a mass, MuJoCo places the center of mass there.
                own = ElementTree.Element("body", pos=document.setting(body, "own_pos", "0 0 0"))
                inertia.lever = document.vector(own, "pos")
        return self._bounded(body, inertia)

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

    def _bounded(self, body: ElementTree.Element, inertia: pin.Inertia) -> pin.Inertia:
        """Return an inertia, modified by the compiler settings."""
        document = self.document
        settings = ElementTree.Element("compiler", document.settings.get(body, document.compiler))
        least_mass, least_moment = (
            document.number(settings, name, 0.0) for name in ("boundmass", "boundinertia")
        )
        moments, axes = np.linalg.eigh(inertia.inertia)
        balanced = np.maximum(moments, least_moment)
        if (
            document.is_true(settings, "balanceinertia", False)
            and balanced[2] > balanced[0] + balanced[1]
        ):
            balanced = np.full(3, balanced.mean())
        # Numbers that no setting changes keep all digits of the file.
        matrix = (
            inertia.inertia if (balanced == moments).all() else axes @ np.diag(balanced) @ axes.T
        )
        return pin.Inertia(max(inertia.mass, least_mass), inertia.lever, matrix)

    def _of_geom(
        self, body: ElementTree.Element, geom: ElementTree.Element, moves: bool
    ) -> pin.Inertia:
        document = self.document
        kind = geom.get("type", "sphere")
        groups = ElementTree.Element(
            "compiler", inertiagrouprange=document.setting(body, "inertiagrouprange", "0 5")
        )
        low, high = document.numbers(groups, "inertiagrouprange", 2)  # type: ignore[misc]
        if kind in ("plane", "hfield") or not low <= document.number(geom, "group", 0.0) <= high:
            return pin.Inertia.Zero()
        mass = document.number(geom, "mass", -1.0) if geom.get("mass") is not None else None
        density = document.number(geom, "density", UNIT_DENSITY)
        if (mass is not None and mass < 0.0) or density < 0.0:
            raise document.wrong(
                f"{described(body)}: {described(geom)} has a negative mass or density"
            )
        if (density if mass is None else mass) == 0.0:
            return pin.Inertia.Zero()
        fitted = geom.get("mesh") is not None
        if fitted and not moves:
            return pin.Inertia.Zero()
        shell = document.is_true(geom, "shellinertia", False)
        if kind == "mesh" and fitted:
            return self._of_mesh(body, geom, mass, density, shell)
        if kind not in SIZES or shell or fitted:
            what = f"a {kind} fitted to a mesh" if fitted else f"{'the shell of ' * shell}a {kind}"
            raise document.wrong(
                f"{described(body)}: the inertia of {what} is not computed here; give the body "
                "an <inertial>"
            )
        placement, sizes = placed(document, geom, kind)
        if mass is None:
            mass = density * _volume(kind, sizes)
        if mass <= SHORTEST:
            return pin.Inertia.Zero()
        return placement.act(_solid(kind, sizes, mass))

    # Meshes

    def _of_mesh(
        self,
        body: ElementTree.Element,
        geom: ElementTree.Element,
        mass: float | None,
        density: float,
        shell: bool,
    ) -> pin.Inertia:
        name = geom.attrib["mesh"]
        if (name, shell) not in self._known:
            try:
                self._known[name, shell] = self._computed(name, shell)
            except InvalidFile as error:
                raise self.document.wrong(
                    f"{described(body)}: the inertia of mesh {name!r} is needed, and cannot be "
                    f"computed: {error}; provide the mesh, or give the body an <inertial>"
                ) from error
        volume, center, inertia = self._known[name, shell]
        if mass is None:
            mass = density * volume
        if mass <= SHORTEST:
            return pin.Inertia.Zero()
        return self.document.placement(geom).act(pin.Inertia(mass, center, mass / volume * inertia))

    def _computed(self, name: str, shell: bool) -> MeshInertia:
        document = self.document
        element = self._meshes.get(name)
        if element is None:
            raise document.wrong(f"<asset> has no mesh {name!r}")
        # Before MuJoCo 3.3 this was an attribute of the geom.
        kind = "shell" if shell else element.get("inertia", KINDS[0])
        if kind not in KINDS:
            raise document.wrong(
                f"{described(element)}: inertia must be one of {', '.join(KINDS)}, got {kind!r}"
            )
        try:
            return mesh_inertia(self._placed_mesh(element), kind)
        except ValueError as error:
            if isinstance(error, InvalidFile):
                raise
            raise document.wrong(
                f'{described(element)}: {error}; with inertia="shell" it needs no volume'
            ) from None

    def _placed_mesh(self, element: ElementTree.Element) -> Mesh:
        """Return a mesh after the translation, rotation and scaling of its element."""
        document = self.document
        if element.get("file") is not None:
            vertices, faces = read_mesh(Path(element.attrib["file"]))
        else:
            vertices, faces = self._written_mesh(element)
        turn = document.rotation_of_quaternion(element, "refquat")
        vertices = (vertices - document.vector(element, "refpos")) @ turn
        scale = document.vector(element, "scale", (1.0, 1.0, 1.0))
        # Mirroring reverses the orientation of the triangles, so it is reversed again.
        return Mesh(vertices * scale, faces if np.prod(scale) > 0.0 else faces[:, ::-1])

    def _written_mesh(self, element: ElementTree.Element) -> Mesh:
        """Return a mesh whose vertices are in the element; without faces it is the convex hull."""
        document = self.document
        numbers = document.numbers(element, "vertex")
        if numbers is None or numbers.size % 3 or numbers.size < 12:
            raise document.wrong(
                f"{described(element)} has neither a file nor the coordinates of four vertices"
            )
        # In single precision, as MuJoCo stores them.
        vertices = numbers.astype(np.float32).astype(float).reshape(-1, 3)
        corners = document.numbers(element, "face")
        if corners is None:
            return hull(vertices)
        faces = corners.astype(int)
        if faces.size % 3 or (faces != corners).any() or not _within(faces, len(vertices)):
            raise document.wrong(
                f"{described(element)}: face must be whole numbers below {len(vertices)}, three "
                "to a triangle"
            )
        return Mesh(vertices, faces.reshape(-1, 3))


def _within(faces: Array, count: int) -> bool:
    return bool(faces.min(initial=0) >= 0 and faces.max(initial=0) < count)


def placed(
    document: MjcfDocument, geom: ElementTree.Element, kind: str
) -> tuple[pin.SE3, list[float]]:
    """Return placement and sizes of a geom; lengths are half lengths, as in the file."""
    ends, sizes = document.ends(geom), document.numbers(geom, "size", 1, 2, 3)
    if ends is not None and kind == "sphere":
        raise document.wrong(f"{described(geom)}: a sphere cannot be given by its ends (fromto)")
    needed = SIZES[kind] if ends is None else 1
    if sizes is None or sizes.size < needed or not (sizes[:needed] > 0.0).all():
        raise document.wrong(
            f"{described(geom)}: a {kind} needs {needed} positive sizes, got {geom.get('size')!r}"
        )
    if ends is None:
        return document.placement(geom), [float(size) for size in sizes[:needed]]
    thickness = float(sizes[0])
    return ends[0], [thickness, ends[1]] if SIZES[kind] == 2 else [
        thickness,
        thickness,
        ends[1],
    ]


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
