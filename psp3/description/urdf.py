"""Read robots from URDF, SRDF and loop files.

The tree is in the URDF and reference poses are in the SRDF. Loops and motors are in a loop file, or
loops follow from the names of frames.
"""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from collections.abc import Callable, Collection, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin

from fuzzy2.support.logs import logger_named
from psp3.description.closing_frames import closing_frames
from psp3.description.joint_replacement import replace_joints
from psp3.description.loop_file import Loops, constraint_models, hinges, read_loops
from psp3.description.meshes import not_opened
from psp3.description.parts import RobotParts, check_number
from psp3.description.srdf import reference_poses
from psp3.description.urdf_plain import make_meshes_absolute, plain_urdf
from psp3.errors import InvalidRobotFile, InvalidValue
from psp3.multibody.equations import Coupling

logger = logger_named(__name__)


def read_robot(
    urdf: str | Path,
    loops: str | Path | None = None,
    srdf: str | Path | None = None,
    actuated: Sequence[str] | None = None,
    closures: Sequence[tuple[str, str, str]] = (),
) -> RobotParts:
    """Read a robot from a URDF, and its loops from a loop file or from the names of its frames.

    Parameters
    ----------
    urdf : path
        The URDF file, with the frames that the loops join.
    loops : path, optional
        The loop file, see :mod:`psp3.description.loop_file`. Without one, the loops are those of
        :mod:`psp3.description.closing_frames`.
    srdf : path, optional
        Reference poses; the pose ``home`` becomes ``q0``.
    actuated : sequence of str, optional
        The motors. The default is those of the loop file; for a tree without loops, all joints of
        one degree of freedom that do not mimic another.
    closures : sequence of (str, str, str)
        Additional loops. Names of their frames do not declare the same loops again.

    Returns
    -------
    RobotParts
        The tree with its joints replaced as the loop file says, loops, actuated joints, home pose
        and shapes.

    Raises
    ------
    InvalidRobotFile
        If a file is missing or malformed, names a frame or joint that does not exist, or has no
        joint that can move.
    InvalidValue
        If the robot has loops and no motors are given.
    """
    path = Path(urdf)
    root = plain_urdf(path)
    check_number(
        path, len(root.findall("joint")) - len(root.findall("joint[@type='fixed']")), "joints"
    )
    model, visual_model = _tree(path, root)
    followers = {
        joint.attrib["name"]: mimic
        for joint in root.findall("joint")
        if (mimic := joint.find("mimic")) is not None
    }
    if loops is not None:
        content, where = read_loops(loops), loops
        if actuated is not None:
            content = content._replace(actuated=tuple(actuated))
    else:
        pairs, where = closing_frames(path, model, closures), path
        motors = _motors(path, model, actuated, set(followers), bool(pairs or closures))
        content = Loops(
            tuple((first, second) for first, second, _ in pairs),
            tuple(kind for _, _, kind in pairs),
            motors,
        )
    leaders = (mimic.attrib["joint"] for mimic in followers.values())
    model, visual_model = replace_joints(
        model, visual_model, content.replaced, (*content.actuated, *followers, *leaders), where
    )
    found = constraint_models(
        model, content, where, "name_mot" if actuated is None and loops else "actuated"
    )
    home = None
    if srdf is not None:
        poses = reference_poses(model, srdf)
        if "home" not in poses:
            raise InvalidRobotFile(srdf, f"has no pose 'home'; it has {', '.join(poses) or 'none'}")
        home = poses["home"]
    equations = (*hinges(model, content, where), *_mimics(path, followers, model))
    check_number(path, model.nv, "speeds")
    return RobotParts(model, found, content.actuated, home, visual_model, equations)


def _motors(
    path: Path,
    model: pin.Model,
    actuated: Sequence[str] | None,
    followers: Collection[str],
    has_loops: bool,
) -> tuple[str, ...]:
    """Return the motors of a robot without a loop file."""
    if model.nv == 0:
        raise InvalidRobotFile(path, "has no joint that can move")
    if actuated is not None:
        return tuple(actuated)
    movable = tuple(
        name
        for name, joint in zip(list(model.names)[1:], list(model.joints)[1:], strict=True)
        if joint.nv == 1 and name not in followers
    )
    if has_loops:
        raise InvalidValue(
            "actuated",
            None,
            f"the names of the motors, which {path.name} with its loops does not say, out of "
            f"{', '.join(movable)}",
        )
    return movable


def _mimics(
    path: Path, followers: Mapping[str, ElementTree.Element], model: pin.Model
) -> list[Coupling]:
    """Return the joints that mimic others, y = offset + multiplier · x."""
    couplings = []
    for follows, mimic in followers.items():
        leads = mimic.attrib["joint"]
        for name in (follows, leads):
            index = model.getJointId(name) if model.existJointName(name) else 0
            if index == 0 or model.joints[index].nq != 1:
                raise InvalidRobotFile(
                    path,
                    f"joint {follows!r} mimics {leads!r}, but {name!r} is not a joint of one "
                    "coordinate: make it revolute (without lower and upper it has no limits) or "
                    "prismatic",
                )
        couplings.append(
            Coupling(
                f"{follows}-{leads}",
                model.getJointId(follows),
                model.getJointId(leads),
                (float(mimic.get("offset", "0")), float(mimic.get("multiplier", "1"))),
            )
        )
    return couplings


def read_tree(urdf: str | Path) -> tuple[pin.Model, Any]:
    """Return the Pinocchio model and the visual model of a URDF.

    A joint whose limits give neither ``lower`` nor ``upper`` has no position limits. (By the format
    both would be 0 and the joint could not move, but many exporters leave them out.) Meshes are
    searched beside the file and in the directories above it; those that cannot be read are left out
    of the visual model. Both are logged as warnings.

    Raises
    ------
    InvalidRobotFile
        If the file is missing or malformed, or Pinocchio cannot read it.
    """
    path = Path(urdf)
    return _tree(path, plain_urdf(path))


def _tree(path: Path, root: ElementTree.Element) -> tuple[pin.Model, Any]:
    try:
        model = pin.buildModelFromXML(ElementTree.tostring(root, encoding="unicode"))
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
    """Return the shapes of all links, without meshes that cannot be read."""
    directories = [str(directory) for directory in path.resolve().parents]

    def build(element: ElementTree.Element) -> Any:
        text = ElementTree.tostring(element, encoding="unicode")
        # Into shapes of ours: Pinocchio never frees those that it makes itself.
        shapes = pin.GeometryModel()
        pin.buildGeomFromUrdfString(
            model, text, pin.GeometryType.VISUAL, shapes, package_dirs=directories
        )
        return shapes

    make_meshes_absolute(path, root)
    _drop_unopened_meshes(path, root)
    try:
        return build(root)
    except ValueError:
        _drop_unreadable_meshes(path, root, build)
    try:
        return build(root)
    except (ValueError, RuntimeError) as error:
        raise InvalidRobotFile(path, f"Pinocchio cannot read its shapes: {error}") from error


def _drop_unopened_meshes(path: Path, root: ElementTree.Element) -> None:
    """Remove visuals from a URDF if their meshes must not be opened."""
    folders = path.resolve().parents
    reasons: dict[str, str] = {}
    for link in root.findall("link"):
        for visual in link.findall("visual"):
            mesh = visual.find("geometry/mesh")
            if mesh is None:
                continue
            name = mesh.attrib["filename"]
            if name not in reasons:
                reasons[name] = not_opened(name, folders)
            if reasons[name]:
                link.remove(visual)
    _tell_not_drawn(path, {name: reason for name, reason in reasons.items() if reason})


def _tell_not_drawn(path: Path, reasons: Mapping[str, str]) -> None:
    for name, reason in reasons.items():
        logger.warning("%s: mesh %s cannot be read and is not drawn (%s)", path, name, reason)


def _drop_unreadable_meshes(
    path: Path, root: ElementTree.Element, build: Callable[[ElementTree.Element], Any]
) -> None:
    """Remove visuals from a URDF if their meshes cannot be read."""
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
    _tell_not_drawn(path, unreadable)
