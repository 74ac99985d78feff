"""Robots from SDF files, the format of Gazebo.

In this format joints may connect links in any way, so they may close loops.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pinocchio as pin

from psp3.checks import Array
from psp3.description.loop_file import check_actuated
from psp3.description.parts import RobotParts, check_number
from psp3.description.sdf_document import SdfDocument
from psp3.description.sdf_frames import Frame, Reader, Scope
from psp3.description.sdf_joints import Joint, read_joint
from psp3.description.sdf_shapes import shapes
from psp3.description.sdf_tree import Tree
from psp3.description.sdf_unread import refuse_extensions, tell
from psp3.description.xml import described
from psp3.multibody.equations import Coupling

PARALLEL = 0.99
"""Axes of a gearbox and its joints with at least this cosine are parallel, because poses are
rounded.
"""


def read_sdf(
    path: str | Path, actuated: Sequence[str] | None = None, model_paths: Sequence[str | Path] = ()
) -> RobotParts:
    """Read a robot from an SDF file, version 1.4 or later.

    The file gives the placements of links, joints, frames and nested or included models; in this
    pose all coordinates are zero. A joint closes a loop if other joints already connect its two
    links; see :mod:`psp3.description.sdf_tree`. Joints of type ``gearbox``, and axes with
    ``<mimic>``, couple two coordinates. A universal joint ``j`` becomes two revolutes, ``j_axis``
    and ``j_axis2``. A model that no joint connects to the world floats on a free joint
    ``root_joint``. Names in nested models are ``model::name``. If a world has a single model that
    is not static, the names in that model have no prefix.

    Effects that the equation of motion does not contain (springs of balls, drag, wind, added mass
    of fluids, links without gravity) are logged as a warning, and so are links without an inertia.

    Parameters
    ----------
    path : path
        The file.
    actuated : sequence of str
        Names of the actuated joints, which an SDF file does not state.
    model_paths : sequence of path, optional
        Folders from which models may be included, in addition to the folder of the file;
        ``model://name`` is searched in all of them.

    Returns
    -------
    RobotParts
        Tree, loops, actuated joints, shapes, couplings and springs.

    Raises
    ------
    InvalidRobotFile
        If the file, or one that it includes, is missing or malformed, or holds elements that cannot
        be read without changing the robot.
    """
    path = Path(path)
    document = SdfDocument(path, (path.resolve().parent, *map(Path, model_paths)))
    reader = _described(document)
    if not reader.found.links:
        raise document.wrong("has no <link> in a <model>")
    joints = [read_joint(reader, frame) for frame in reader.found.joints]
    check_number(path, sum(joint.kind != "fixed" for joint in joints), "joints")
    refuse_extensions(reader)
    if actuated is None:
        known = [name for joint in joints for name in _driven(joint)]
        raise document.wrong(
            "names no motors, as SDF has no word for them: say which joints are actuated "
            "(actuated=[...]), of "
            f"{', '.join(known[:20]) or 'none'}{' and others' if len(known) > 20 else ''}"
        )
    names = tuple(actuated)
    pairs = [*_gears(reader, joints), *_mimics(joints)]
    kept = {*names, *(name for _, follows, leads, _ in pairs for name in (follows, leads))}
    tree = Tree(reader, joints, kept)
    check_number(path, tree.model.nv, "speeds")
    for name in names:
        if name in tree.still:
            raise document.wrong(
                f"actuated: joint {name!r} cannot move, because its links are welded or static"
            )
    check_actuated(tree.model, names, path, "actuated")
    tree.model.name = reader.found.models[0].name
    tree.model.gravity = pin.Motion(_gravity(document), np.zeros(3))
    tell(document, tree, joints)
    springs = {
        axis.name: (axis.stiffness, axis.rest)
        for joint in tree.moving
        for axis in joint.axes
        if axis.stiffness != 0.0
    }
    couplings = tuple(
        Coupling(name, tree.model.getJointId(follows), tree.model.getJointId(leads), coefficients)
        for name, follows, leads, coefficients in pairs
    )
    return RobotParts(
        tree.model,
        tree.closures,
        names,
        None,
        shapes(tree),
        (*tree.hinges, *couplings),
        springs,
    )


def _driven(joint: Joint) -> list[str]:
    """Return the coordinates of a joint that a motor can drive."""
    if joint.kind in ("fixed", "ball", "gearbox"):
        return []
    return [axis.name for axis in joint.axes]


def _described(document: SdfDocument) -> Reader:
    """Return the contents of a file: a world, or a single model."""
    reader = Reader()
    worlds, models = document.root.findall("world"), document.root.findall("model")
    if len(worlds) + len(models) != 1:
        raise document.wrong(
            f"must hold one <world> or one <model>, not {len(worlds)} and {len(models)}"
        )
    for model in models:
        outer = Scope("")
        outer.frames["world"] = Frame(
            outer, "world", "world", model, document, pin.SE3.Identity(), "", "world", "world"
        )
        reader.model(model, document, outer, bare=document.name(model))
    for world in worlds:
        movable = [
            model.get("name", "")
            for model in world.findall("model")
            if not document.is_true(model, "static")
        ]
        others = [item for item in world.findall("include") if not document.is_true(item, "static")]
        bare = movable[0] if len(movable) == 1 and not others else ""
        reader.world(world, document, bare)
    return reader


def _gravity(document: SdfDocument) -> Array:
    """Return the gravity of a world; for a single model, the default of the other formats."""
    world = document.root.find("world")
    if world is None:
        return np.array([0.0, 0.0, -9.81])
    # Until version 1.5 gravity was an element of <physics>.
    places = [world] if document.version > 5 else [world, *world.findall("physics")]
    for place in places:
        given = document.numbers(place, "gravity", 3)
        if given is not None:
            return given
    return np.array([0.0, 0.0, -9.8])


# Couplings

Pair = tuple[str, str, str, tuple[float, ...]]
"""A coupling: its name, the following coordinate, the leading coordinate, and the polynomial."""


def _gears(reader: Reader, joints: Sequence[Joint]) -> list[Pair]:
    """Return the gearboxes, θ₂ = −ratio θ₁.

    The angles are those of the joints between the reference body and the parent or child.
    """
    pairs: list[Pair] = []
    for gear in joints:
        if gear.kind != "gearbox":
            continue
        element, document = gear.frame.element, gear.frame.document
        ratio = document.number(element, "gearbox_ratio", 1.0)
        name = document.text(element, "gearbox_reference_body") or ""
        if not name:
            raise document.wrong(f"{described(element)} lacks <gearbox_reference_body>")
        body = None if name == "world" else reader.link(gear.frame.scope.find(name, gear.frame))
        (one, first), (two, second) = (
            _turn(reader, joints, gear, number, body) for number in (0, 1)
        )
        if one == two:
            raise document.wrong(f"{described(element)} couples joint {one!r} with itself")
        pairs.append((gear.name, two, one, (0.0, -ratio * first * second)))
    return pairs


def _turn(
    reader: Reader, joints: Sequence[Joint], gear: Joint, number: int, body: Frame | None
) -> tuple[str, float]:
    """Return the joint between a gearbox's parent or child and its reference body, and its sign."""
    link = (gear.parent, gear.child)[number]
    axis = reader.placement(gear.frame).rotation @ gear.axes[number].direction
    for joint in joints:
        if joint.kind not in ("revolute", "continuous"):
            continue
        ends = _same(joint.parent, body) and _same(joint.child, link)
        if not ends and not (_same(joint.child, body) and _same(joint.parent, link)):
            continue
        along = float(reader.placement(joint.frame).rotation @ joint.axes[0].direction @ axis)
        if abs(along) < PARALLEL:
            continue
        return joint.name, float(np.sign(along)) * (1.0 if ends else -1.0)
    raise gear.frame.document.wrong(
        f"{described(gear.frame.element)}: there is no revolute joint about its "
        f"{('axis', 'axis2')[number]} between the reference body "
        f"{'world' if body is None else body.full_name!r} and "
        f"{'world' if link is None else link.full_name!r}, whose angle it would couple"
    )


def _same(one: Frame | None, two: Frame | None) -> bool:
    return (one is None and two is None) or (
        one is not None and two is not None and one.full_name == two.full_name
    )


def _mimics(joints: Sequence[Joint]) -> list[Pair]:
    """Return the axes that follow others, y = offset + multiplier (x − reference)."""
    pairs: list[Pair] = []
    for joint in joints:
        for axis in joint.axes:
            if axis.mimic is None or joint.kind == "gearbox":
                continue
            document, title = joint.frame.document, described(joint.frame.element)
            leader = joint.frame.scope.find(document.name(axis.mimic, "joint"), joint.frame)
            number = {"axis": 0, "axis2": 1}.get(axis.mimic.get("axis", "axis"), 2)
            names = [_driven(other) for other in joints if other.frame is leader]
            if not names or number >= len(names[0]) or names[0][number] == axis.name:
                raise document.wrong(
                    f"{title}: <mimic> follows {axis.mimic.get('axis', 'axis')!r} of "
                    f"{leader.name!r}, which is not another axis of a joint"
                )
            multiplier, offset, reference = (
                document.number(axis.mimic, tag, default)
                for tag, default in (("multiplier", 1.0), ("offset", 0.0), ("reference", 0.0))
            )
            leads = names[0][number]
            pairs.append(
                (
                    f"{axis.name}-{leads}",
                    axis.name,
                    leads,
                    (offset - multiplier * reference, multiplier),
                )
            )
    return pairs
