"""Read loop files.

A loop file states which frames of a tree coincide in the assembled robot, and which joints are
actuated.

The keys are those of toolbox-parallel-robots, so each package can read the files of the other::

    closed_loop: [[frameA, frameB], ...]   # pairs of frames that coincide
    type: ['6d', '3d', ...]                # '6d': position and orientation; '3d': position only;
                                           # 'hinge': position and z axis
    name_mot: [joint, ...]                 # the actuated joints
    joint_name: [joint, ...]               # joints of the URDF that stand for others; optional
    joint_type: [SPHERICAL, ...]           # which: SPHERICAL, UJOINT_XY and its like, FIXED
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin

from fuzzy2.support.bounded_files import content_of, not_read, shortened
from fuzzy2.support.logs import logger_named
from psp3.description.joint_replacement import REPLACEMENTS
from psp3.errors import InvalidRobotFile
from psp3.multibody.equations import Hinge
from psp3.multibody.named_frames import frames_named

logger = logger_named(__name__)

TEXT, LIST, TABLE = (f"tag:yaml.org,2002:{kind}" for kind in ("str", "seq", "map"))
"""YAML's tags for a text, a list and a table of keys."""

LARGEST = 256 * 2**10
"""The largest loop file [bytes]."""

MOST = 20_000
"""The largest number of lists, keys and names in a loop file: thousands of loops, which YAML's
parser reads in two seconds.
"""

DEEPEST = 20
"""The deepest nesting of lists and keys; a loop file needs three levels."""

KEYS = ("closed_loop", "type", "name_mot", "joint_name", "joint_type")
"""Keys of a loop file."""

KINDS = ("6d", "3d", "hinge")

SAME_PLACE = 1e-12
"""Two frames with the same name are the same frame if they are on one body and their placements
differ by at most this [m, 1].
"""


class Loops(NamedTuple):
    """Contents of a loop file."""

    frames: tuple[tuple[str, str], ...]
    """Pairs of frames that coincide."""
    kinds: tuple[str, ...]
    """Kind of each closure, ``"6d"``, ``"3d"`` or ``"hinge"``."""
    actuated: tuple[str, ...]
    """Names of the actuated joints."""
    replaced: tuple[tuple[str, str], ...] = ()
    """Joints that stand for another kind of joint, with that kind."""


def _shown(node: Any) -> str:
    """Return how an error message shows a part of the file; lists are shortened."""
    if not isinstance(node.value, list):
        return repr(node.value[:80]) if node.tag == TEXT else str(node.value[:80])
    if node.id == "mapping" or node.tag != LIST:
        return f"a {node.id} {node.tag[:80]}"
    entries = [
        _shown(entry) if isinstance(entry.value, str) else f"{entry.id} of {len(entry.value)}"
        for entry in node.value[:6]
    ]
    return f"[{', '.join(entries)}{', ...' if len(node.value) > 6 else ''}]"


def _entries(path: Path, node: Any, key: str, of: str) -> list[Any]:
    if node.tag != LIST or node.id != "sequence":
        raise InvalidRobotFile(path, f"key {key!r} must hold a list of {of}, got {_shown(node)}")
    entries: list[Any] = node.value
    return entries


def _names(path: Path, node: Any, key: str) -> tuple[str, ...]:
    entries = _entries(path, node, key, "names")
    if any(entry.tag != TEXT or entry.id != "scalar" for entry in entries):
        raise InvalidRobotFile(path, f"key {key!r} must hold a list of names, got {_shown(node)}")
    return tuple(entry.value for entry in entries)


def _pair(path: Path, node: Any) -> tuple[str, str]:
    """Return the two frames of a closed loop."""
    # This is checked before the names, because a file may refer thousands of times to one long
    # list.
    if node.id == "sequence" and len(node.value) != 2:
        raise InvalidRobotFile(path, f"every closed loop joins two frames, got {_shown(node)}")
    first, second = _names(path, node, "closed_loop")
    if first == second:
        raise InvalidRobotFile(path, f"closed loop {[first, second]} joins a frame with itself")
    return first, second


def _keys(path: Path) -> dict[str, Any]:
    """Return the nodes of a YAML file by their keys.

    The nodes are not converted to dates, numbers or Python objects, so values under keys of other
    programs are never constructed, and an aliased list is stored once.
    """
    import yaml

    class Loader(yaml.SafeLoader):  # type: ignore[misc]
        depth = found = 0

        def compose_node(self, parent: Any, index: Any) -> Any:
            self.depth += 1
            self.found += 1
            if self.depth > DEEPEST:
                raise ValueError(f"lists or keys are nested more than {DEEPEST} deep")
            if self.found > MOST:
                raise ValueError(f"it holds more than {MOST} lists, keys and names")
            node = super().compose_node(parent, index)
            self.depth -= 1
            return node

    try:
        root = yaml.compose(content_of(path, LARGEST).decode("utf-8-sig"), Loader)
    except (OSError, ValueError, RecursionError, yaml.YAMLError) as error:
        raise InvalidRobotFile(path, not_read(error, "cannot be read as YAML")) from error
    if root is None or root.id != "mapping" or root.tag != TABLE:
        raise InvalidRobotFile(path, "must hold the keys closed_loop, type and name_mot")
    keys = [
        key.value if key.tag == TEXT and key.id == "scalar" else _shown(key)
        for key, _ in root.value
    ]
    _no_name_twice(path, tuple(keys), "the file", "a key")
    return dict(zip(keys, (node for _, node in root.value), strict=True))


def read_loops(path: str | Path) -> Loops:
    """Read a loop file.

    Parameters
    ----------
    path : path
        A YAML file with the keys ``closed_loop``, ``type`` and ``name_mot``, and perhaps
        ``joint_name`` and ``joint_type``.

    Returns
    -------
    Loops
        The contents of the file. :func:`constraint_models` checks whether the names exist in a
        model.

    Raises
    ------
    InvalidRobotFile
        If the file is missing, is not YAML, lacks a key or violates the format.
    """
    path = Path(path)
    content = _keys(path)
    missing = [key for key in ("closed_loop", "type", "name_mot") if key not in content]
    if missing:
        raise InvalidRobotFile(path, f"lacks the key {', '.join(missing)}")
    unread = [repr(key[:80]) for key in content if key not in KEYS]
    if unread:
        logger.warning("%s: these keys are not read: %s", path, shortened(", ".join(unread)))
    pairs = _entries(path, content["closed_loop"], "closed_loop", "frame pairs")
    frames = tuple(_pair(path, pair) for pair in pairs)
    kinds = tuple(kind.lower() for kind in _names(path, content["type"], "type"))
    if len(kinds) != len(frames) or any(kind not in KINDS for kind in kinds):
        raise InvalidRobotFile(
            path,
            f"key 'type' must give '6d', '3d' or 'hinge' for each of the {len(frames)} closed "
            f"loops, got {_shown(content['type'])}",
        )
    actuated = _names(path, content["name_mot"], "name_mot")
    _no_name_twice(path, actuated, "name_mot")
    return Loops(frames, kinds, actuated, _replaced(path, content, actuated))


def _no_name_twice(path: Path, names: tuple[str, ...], key: str, what: str = "a joint") -> None:
    twice = [name for name, count in Counter(names).items() if count > 1]
    if twice:
        raise InvalidRobotFile(path, f"{key} names {what} twice: {', '.join(twice)}")


def _replaced(
    path: Path, content: dict[str, Any], actuated: tuple[str, ...]
) -> tuple[tuple[str, str], ...]:
    names, kinds = (
        _names(path, content[key], key) if key in content else ()
        for key in ("joint_name", "joint_type")
    )
    kinds = tuple(kind.upper() for kind in kinds)
    if len(names) != len(kinds):
        raise InvalidRobotFile(
            path,
            f"key 'joint_type' must give a type for each of the {len(names)} joints of "
            f"'joint_name', got {len(kinds)}",
        )
    _no_name_twice(path, names, "joint_name")
    for name, kind in zip(names, kinds, strict=True):
        if kind not in REPLACEMENTS:
            raise InvalidRobotFile(
                path,
                f"joint_type: {kind!r} for joint {name!r} is unknown; known are "
                f"{', '.join(REPLACEMENTS)}",
            )
        if name in actuated:
            raise InvalidRobotFile(
                path,
                f"joint {name!r} is actuated (name_mot) and cannot be replaced by {kind} "
                "(joint_name); take it out of one of them",
            )
    return tuple(zip(names, kinds, strict=True))


def _frame(model: pin.Model, name: str, pair: tuple[str, str], path: str | Path) -> Any:
    """Return the frame with a name.

    A URDF may give a joint and a link the same name. The name is unique if the two frames coincide,
    or with a prefix, ``body:name`` or ``joint:name``.
    """
    first, *others = [model.frames[number] for number in frames_named(model, name)] or [None]
    if first is None:
        raise InvalidRobotFile(path, f"closed loop {list(pair)}: the robot has no frame {name!r}")
    for other in others:
        apart = np.abs(other.placement.homogeneous - first.placement.homogeneous).max()
        if other.parentJoint != first.parentJoint or apart > SAME_PLACE:
            raise InvalidRobotFile(
                path,
                f"closed loop {list(pair)}: the robot has several frames {name!r}; say "
                f"which, 'body:{name}', 'frame:{name}' or 'joint:{name}'",
            )
    return first


def constraint_models(
    model: pin.Model, loops: Loops, path: str | Path, key: str = "name_mot"
) -> Any:
    """Return the loops as Pinocchio constraint models.

    Parameters
    ----------
    model : pinocchio.Model
        The tree.
    loops : Loops
        Frame pairs and kinds of closure.
    path : path
        The loop file, for error messages.
    key : str
        The key or argument that names the motors, for error messages.

    Returns
    -------
    pinocchio.StdVec_RigidConstraintModel
        One constraint model per loop, in the local frame of its first frame, except for hinges; see
        :func:`hinges`.

    Raises
    ------
    InvalidRobotFile
        If a frame or an actuated joint is not in the model, a loop joins a body with itself, or an
        actuated joint has more than one degree of freedom.
    """
    models = pin.StdVec_RigidConstraintModel()
    for pair, kind, first, second in _joined(model, loops, path):
        if kind == "hinge":
            continue
        models.append(
            rigid_constraint(
                model,
                kind,
                (first.parentJoint, first.placement),
                (second.parentJoint, second.placement),
            )
        )
        models[-1].name = f"{pair[0]}-{pair[1]}"
    check_actuated(model, loops.actuated, path, key)
    return models


def hinges(model: pin.Model, loops: Loops, path: str | Path) -> tuple[Hinge, ...]:
    """Return the loops that are hinges about the z axes of their frames."""
    return tuple(
        Hinge(
            f"{pair[0]}-{pair[1]}",
            first.parentJoint,
            first.placement,
            second.parentJoint,
            second.placement,
        )
        for pair, kind, first, second in _joined(model, loops, path)
        if kind == "hinge"
    )


def _joined(
    model: pin.Model, loops: Loops, path: str | Path
) -> Iterator[tuple[tuple[str, str], str, Any, Any]]:
    """Yield the names, the kind and the two frames of every loop."""
    for pair, kind in zip(loops.frames, loops.kinds, strict=True):
        first, second = (_frame(model, name, pair, path) for name in pair)
        if first.parentJoint == second.parentJoint:
            raise InvalidRobotFile(
                path,
                f"closed loop {list(pair)}: both frames are on the same body, so there is "
                "nothing to close",
            )
        yield pair, kind, first, second


def rigid_constraint(
    model: pin.Model, kind: str, first: tuple[int, pin.SE3], second: tuple[int, pin.SE3]
) -> Any:
    """Return the constraint model that joins two placements, each in a joint.

    It joins their positions (``"3d"``), or positions and orientations (``"6d"``).
    """
    contact = pin.ContactType.CONTACT_6D if kind == "6d" else pin.ContactType.CONTACT_3D
    return pin.RigidConstraintModel(contact, model, *first, *second, pin.ReferenceFrame.LOCAL)


def check_actuated(model: pin.Model, actuated: tuple[str, ...], path: str | Path, key: str) -> None:
    """Raise :class:`InvalidRobotFile` unless all names can be those of motors.

    They must name different joints of one degree of freedom.
    """
    _no_name_twice(Path(path), actuated, key)
    for name in actuated:
        if not model.existJointName(name) or name == model.names[0]:
            known = ", ".join(list(model.names)[1:])
            raise InvalidRobotFile(
                path, f"{key}: the robot has no joint {name!r}; its joints are {known}"
            )
        joint = model.joints[model.getJointId(name)]
        if joint.nq != 1 or joint.nv != 1:
            raise InvalidRobotFile(
                path,
                f"{key}: joint {name!r} has {joint.nv} degrees of freedom in {joint.nq} "
                "coordinates; an actuated joint has one in one",
            )
