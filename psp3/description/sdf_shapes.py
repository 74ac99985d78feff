"""The shapes of the links of an SDF file."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin

from fuzzy2.support.logs import logger_named
from psp3.checks import Array
from psp3.description.meshes import not_opened
from psp3.description.sdf_frames import Frame
from psp3.description.sdf_tree import Tree
from psp3.description.xml import described

logger = logger_named(__name__)

SIZES = {
    "box": (("size", 3),),
    "sphere": (("radius", 1),),
    "cylinder": (("radius", 1), ("length", 1)),
    "capsule": (("radius", 1), ("length", 1)),
    "ellipsoid": (("radii", 3),),
    "cone": (("radius", 1), ("length", 1)),
}
"""Shapes that are drawn, and the number elements that each needs."""

GRAY = np.array([0.5, 0.5, 0.5, 1.0])
"""The default color of a shape."""


def shapes(tree: Tree) -> Any:
    """Return the shapes of all links, as a Pinocchio geometry model.

    Planes, height maps and images are not drawn. Meshes that cannot be read are left out and
    logged.

    Raises
    ------
    InvalidRobotFile
        If a number of a shape is malformed or not positive.
    """
    drawn = pin.GeometryModel()
    unreadable: dict[str, str] = {}
    for link in tree.reader.found.links:
        for number, visual in enumerate(link.element.findall("visual")):
            geometry = visual.find("geometry")
            if geometry is None:
                raise link.document.wrong(
                    f"{described(link.element)}: a <visual> has no <geometry>"
                )
            found = _shape(link, geometry, unreadable)
            if found is None:
                continue
            shape, file, scale = found
            pose, relative_to = link.document.pose(visual)
            base = link.scope.find(relative_to, link) if relative_to else link
            at = tree.place(link)
            where = at.placement * tree.reader.placement(link).actInv(
                tree.reader.placement(base) * pose
            )
            frame = tree.model.getFrameId(link.full_name, pin.FrameType.BODY)
            drawn.addGeometryObject(
                pin.GeometryObject(
                    f"{link.full_name}_{number}",
                    at.joint,
                    frame,
                    where,
                    shape,
                    file,
                    scale,
                    True,
                    _color(link, visual),
                )
            )
    if unreadable:
        logger.warning(
            "%s: meshes that cannot be read and are not drawn: %s",
            tree.reader.found.links[0].document.path,
            "; ".join(f"{file} ({reason})" for file, reason in unreadable.items()),
        )
    return drawn


def _shape(
    link: Frame, geometry: ElementTree.Element, unreadable: dict[str, str]
) -> tuple[Any, str, Array] | None:
    import coal

    one = np.ones(3)
    for item in geometry:
        if item.tag == "mesh":
            return _mesh(link, item, unreadable)
        if item.tag not in SIZES:
            continue
        sizes = []
        for tag, count in SIZES[item.tag]:
            value = link.document.numbers(item, tag, count)
            if value is None or (value <= 0.0).any():
                raise link.document.wrong(
                    f"{described(link.element)}: a <{item.tag}> needs a positive <{tag}>"
                )
            sizes += [float(x) for x in value]
        made = {
            "box": coal.Box,
            "sphere": coal.Sphere,
            "cylinder": coal.Cylinder,
            "capsule": coal.Capsule,
            "ellipsoid": coal.Ellipsoid,
            "cone": coal.Cone,
        }[item.tag](*sizes)
        return made, item.tag.upper(), one
    return None


def _mesh(
    link: Frame, mesh: ElementTree.Element, unreadable: dict[str, str]
) -> tuple[Any, str, Array] | None:
    import coal

    uri = (mesh.findtext("uri") or "").strip()
    scale = link.document.numbers(mesh, "scale", 3)
    scale = np.ones(3) if scale is None else scale
    if uri in unreadable:
        return None
    scheme, found, rest = uri.partition("://")
    folders = [link.document.path.parent, *link.document.roots]
    if scheme in ("model", "package"):
        folders += list(link.document.path.resolve().parents)
    candidates = [Path(folder) / (rest if found else uri) for folder in folders]
    path = next((one for one in candidates if one.is_file()), None)
    if path is None:
        unreadable[uri] = "no such file"
        return None
    if reason := not_opened(str(path)):
        unreadable[uri] = reason
        return None
    try:
        return coal.MeshLoader().load(str(path), scale), str(path), scale
    except (ValueError, RuntimeError) as error:
        unreadable[uri] = (str(error).strip().splitlines() or ["unreadable"])[-1]
        return None


def _color(link: Frame, visual: ElementTree.Element) -> Array:
    """Return the color of a shape, preferably the diffuse one."""
    material = visual.find("material")
    if material is None:
        return GRAY
    for tag in ("diffuse", "ambient"):
        color = link.document.numbers(material, tag, 3, 4)
        if color is not None:
            return np.append(color, 1.0)[:4]
    return GRAY
