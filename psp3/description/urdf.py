"""Robot description files.

A tree from a URDF, reference poses from an SRDF, loops and motors from a loop file.
"""

from __future__ import annotations

import logging
import xml.etree.ElementTree as ElementTree
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin

from psp3.description.joint_replacement import replace_joints
from psp3.description.loop_file import constraint_models, hinges, read_loops
from psp3.description.parts import RobotParts
from psp3.description.srdf import reference_poses
from psp3.description.urdf_checks import check_urdf
from psp3.description.xml import read_xml
from psp3.errors import InvalidRobotFile
from psp3.multibody.equations import Coupling

logger = logging.getLogger(__name__)


def read_robot(urdf: str | Path, loops: str | Path, srdf: str | Path | None = None) -> RobotParts:
    """Read a robot from a URDF and a loop file.

    Parameters
    ----------
    urdf : path
        The tree, with the frames that the loops join.
    loops : path
        The loop file, in the keys of :mod:`psp3.description.loop_file`.
    srdf : path, optional
        Reference poses; the pose ``home`` becomes ``q0``.

    Returns
    -------
    RobotParts
        The tree with its joints replaced as the loop file says, loops, actuated joints, home pose
        and shapes.

    Raises
    ------
    InvalidRobotFile
        If a file is missing or malformed, or a frame or joint it names does not exist.
    """
    model, visual_model = read_tree(urdf)
    content = read_loops(loops)
    coupled = _mimicking(Path(urdf))
    model, visual_model = replace_joints(
        model, visual_model, content.replaced, (*content.actuated, *coupled), loops
    )
    closures = constraint_models(model, content, loops)
    home = None
    if srdf is not None:
        poses = reference_poses(model, srdf)
        if "home" not in poses:
            raise InvalidRobotFile(srdf, f"has no pose 'home'; it has {', '.join(poses) or 'none'}")
        home = poses["home"]
    equations = (*hinges(model, content, loops), *_mimics(Path(urdf), model))
    return RobotParts(model, closures, content.actuated, home, visual_model, equations)


def _mimicking(path: Path) -> tuple[str, ...]:
    """Return the joints that mimic others, and those that they mimic."""
    names = [
        name
        for element in read_xml(path, "robot").findall("joint")
        for mimic in element.findall("mimic")
        for name in (element.get("name", ""), mimic.get("joint", ""))
    ]
    return tuple(dict.fromkeys(names))


def _mimics(path: Path, model: pin.Model) -> list[Coupling]:
    """Return the joints that mimic others, y = offset + multiplier · x."""
    couplings = []
    for element in read_xml(path, "robot").findall("joint"):
        mimic = element.find("mimic")
        if mimic is None:
            continue
        follows, leads = element.attrib["name"], mimic.get("joint", "")
        for name in (follows, leads):
            index = model.getJointId(name) if model.existJointName(name) else 0
            if index == 0 or model.joints[index].nq != 1:
                raise InvalidRobotFile(
                    path,
                    f"joint {follows!r} mimics {leads!r}, of which {name!r} is no joint of one "
                    "coordinate: make it revolute (without lower and upper it has no limits) or "
                    "prismatic",
                )
        try:
            offset, multiplier = (
                float(mimic.get(key, default))
                for key, default in (("offset", "0"), ("multiplier", "1"))
            )
        except ValueError as error:
            raise InvalidRobotFile(path, f"joint {follows!r}: mimic: {error}") from None
        couplings.append(
            Coupling(
                f"{follows}-{leads}",
                model.getJointId(follows),
                model.getJointId(leads),
                (offset, multiplier),
            )
        )
    return couplings


def read_tree(urdf: str | Path) -> tuple[pin.Model, Any]:
    """Return the Pinocchio model and the visual model of a URDF.

    A joint whose limits give neither ``lower`` nor ``upper`` has no position limits. (To the letter
    of the format both would be 0 and the joint could not move; many exporters leave them out.)
    Meshes are looked for beside the file and in the directories above it; those that cannot be read
    are left out of the visual model. Both are logged as warnings.

    Raises
    ------
    InvalidRobotFile
        If the file is missing or malformed, or Pinocchio cannot read it.
    """
    path = Path(urdf)
    root = read_xml(path, "robot")
    check_urdf(path, root)
    try:
        model = pin.buildModelFromUrdf(str(path))
    except (ValueError, RuntimeError) as error:
        raise InvalidRobotFile(path, f"Pinocchio cannot read it: {error}") from error
    _free_joints_without_limits(path, root, model)
    return model, _shapes_of_urdf(path, root, model)


def _free_joints_without_limits(path: Path, root: ElementTree.Element, model: pin.Model) -> None:
    unlimited = []
    for joint in root.findall("joint"):
        limit = joint.find("limit")
        if (
            joint.get("type") in ("revolute", "prismatic")
            and limit is not None
            and limit.get("lower") is limit.get("upper") is None
        ):
            index = model.joints[model.getJointId(joint.attrib["name"])].idx_q
            model.lowerPositionLimit[index], model.upperPositionLimit[index] = -np.inf, np.inf
            unlimited.append(joint.attrib["name"])
    if unlimited:
        more = f" and {len(unlimited) - 3} more" if len(unlimited) > 3 else ""
        logger.warning(
            "%s: without lower and upper limits, taken as unlimited: %s%s",
            path,
            ", ".join(unlimited[:3]),
            more,
        )


def _shapes_of_urdf(path: Path, root: ElementTree.Element, model: pin.Model) -> Any:
    """Return the shapes of all links, but for meshes that cannot be read."""
    directories = [str(directory) for directory in path.resolve().parents]

    def build(element: ElementTree.Element) -> Any:
        text = ElementTree.tostring(element, encoding="unicode")
        return pin.buildGeomFromUrdfString(
            model, text, pin.GeometryType.VISUAL, package_dirs=directories
        )

    for mesh in root.iter("mesh"):
        # Relative to the file, not to where the program was started.
        if "://" not in mesh.attrib["filename"]:
            mesh.set("filename", str(path.resolve().parent / mesh.attrib["filename"]))
    try:
        return build(root)
    except ValueError:
        _drop_unreadable_meshes(path, root, build)
    try:
        return build(root)
    except (ValueError, RuntimeError) as error:
        raise InvalidRobotFile(path, f"Pinocchio cannot read its shapes: {error}") from error


def _drop_unreadable_meshes(
    path: Path, root: ElementTree.Element, build: Callable[[ElementTree.Element], Any]
) -> None:
    """Take those visuals out of a URDF whose meshes are not to be had."""
    bare = ElementTree.fromstring(ElementTree.tostring(root))
    for link in bare.iter("link"):
        for shape in (*link.findall("visual"), *link.findall("collision")):
            link.remove(shape)
    trial = next(bare.iter("link"))
    unreadable: dict[str, str] = {}
    readable: set[str] = set()
    for link in root.findall("link"):
        for visual in link.findall("visual"):
            mesh = visual.find("geometry/mesh")
            if mesh is None:
                continue
            name = mesh.attrib["filename"]
            if name not in readable and name not in unreadable:
                trial.append(visual)
                try:
                    build(bare)
                    readable.add(name)
                except ValueError as error:
                    unreadable[name] = str(error).strip().splitlines()[-1]
                trial.remove(visual)
            if name in unreadable:
                link.remove(visual)
    for name, reason in unreadable.items():
        logger.warning("%s: mesh %s cannot be read and is not drawn (%s)", path, name, reason)
