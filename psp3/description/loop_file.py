"""Loop files.

Which frames of a tree coincide in the assembled robot, and which joints are actuated.

The keys are those of toolbox-parallel-robots, so its files can be read here and ours there::

    closed_loop: [[frameA, frameB], ...]   # pairs of frames that coincide
    type: ['6d', '3d', ...]                # '6d': position and orientation; '3d': position only;
                                           # 'hinge': position and z axis
    name_mot: [joint, ...]                 # the actuated joints
    joint_name: [joint, ...]               # joints of the URDF that stand for others; optional
    joint_type: [SPHERICAL, ...]           # which: SPHERICAL, UJOINT_XY and its like, FIXED
"""

from __future__ import annotations

import reprlib
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin

from fuzzy2.support.logs import logger_named
from psp3.description.joint_replacement import REPLACEMENTS
from psp3.errors import InvalidRobotFile
from psp3.multibody.equations import Hinge
from psp3.multibody.named_frames import frames_named

logger = logger_named(__name__)

SHORT = reprlib.Repr()
"""Writes a value in an error message: of lists in lists in lists no more than two."""
SHORT.maxlevel = 2

KEYS = ("closed_loop", "type", "name_mot", "joint_name", "joint_type")
"""Keys of a loop file."""

KINDS = ("6d", "3d", "hinge")

SAME_PLACE = 1e-12
"""Frames of one name are the same if they are on one body and their placements differ by no more
than this [m, 1].
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
    """Joints that stand for another kind of joint, with the kind."""


def _names(path: Path, value: Any, key: str) -> tuple[str, ...]:
    if not isinstance(value, list) or not all(isinstance(name, str) for name in value):
        raise InvalidRobotFile(
            path, f"key {key!r} must hold a list of names, got {SHORT.repr(value)}"
        )
    return tuple(value)


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
        What the file says; whether the names exist in a model is checked by
        :func:`constraint_models`.

    Raises
    ------
    InvalidRobotFile
        If the file is missing, is not YAML, lacks a key or holds something else than the format
        asks for.
    """
    import yaml

    path = Path(path)
    try:
        content = yaml.safe_load(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError, yaml.YAMLError) as error:
        raise InvalidRobotFile(
            path, f"cannot be read as YAML ({getattr(error, 'strerror', None) or error})"
        ) from error
    if not isinstance(content, dict):
        raise InvalidRobotFile(path, "must hold the keys closed_loop, type and name_mot")
    missing = [key for key in ("closed_loop", "type", "name_mot") if key not in content]
    if missing:
        raise InvalidRobotFile(path, f"lacks the key {', '.join(missing)}")
    unread = [SHORT.repr(key) for key in content if key not in KEYS]
    if unread:
        logger.warning("%s: these keys are not read: %s", path, ", ".join(unread))
    pairs = content["closed_loop"]
    if not isinstance(pairs, list):
        raise InvalidRobotFile(
            path, f"key 'closed_loop' must hold a list of frame pairs, got {SHORT.repr(pairs)}"
        )
    frames = tuple(_names(path, pair, "closed_loop") for pair in pairs)
    if any(len(pair) != 2 for pair in frames):
        raise InvalidRobotFile(path, f"every closed loop joins two frames, got {SHORT.repr(pairs)}")
    itself = [pair for pair in frames if pair[0] == pair[1]]
    if itself:
        raise InvalidRobotFile(path, f"closed loop {list(itself[0])} joins a frame with itself")
    kinds = tuple(kind.lower() for kind in _names(path, content["type"], "type"))
    if len(kinds) != len(frames) or any(kind not in KINDS for kind in kinds):
        raise InvalidRobotFile(
            path,
            f"key 'type' must give '6d', '3d' or 'hinge' for each of the {len(frames)} closed "
            f"loops, got {SHORT.repr(content['type'])}",
        )
    actuated = _names(path, content["name_mot"], "name_mot")
    _no_name_twice(path, actuated, "name_mot")
    return Loops(
        tuple((pair[0], pair[1]) for pair in frames),
        kinds,
        actuated,
        _replaced(path, content, actuated),
    )


def _no_name_twice(path: Path, names: tuple[str, ...], key: str) -> None:
    twice = [name for name, count in Counter(names).items() if count > 1]
    if twice:
        raise InvalidRobotFile(path, f"{key} names a joint twice: {', '.join(twice)}")


def _replaced(
    path: Path, content: dict[str, Any], actuated: tuple[str, ...]
) -> tuple[tuple[str, str], ...]:
    names = _names(path, content.get("joint_name", []), "joint_name")
    kinds = tuple(
        kind.upper() for kind in _names(path, content.get("joint_type", []), "joint_type")
    )
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
    """Return the frame of a name.

    A URDF may give a joint and a link the same one, which is clear if the two coincide, or if it is
    said which is meant, as ``body:name`` or ``joint:name``.
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
        What names the motors, for error messages.

    Returns
    -------
    pinocchio.StdVec_RigidConstraintModel
        One constraint model per loop, in the local frame of its first frame; but none of hinges,
        see :func:`hinges`.

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

    In position (``"3d"``) or entirely (``"6d"``).
    """
    contact = pin.ContactType.CONTACT_6D if kind == "6d" else pin.ContactType.CONTACT_3D
    return pin.RigidConstraintModel(contact, model, *first, *second, pin.ReferenceFrame.LOCAL)


def check_actuated(model: pin.Model, actuated: tuple[str, ...], path: str | Path, key: str) -> None:
    """Raise :class:`InvalidRobotFile` unless all names fit.

    They must be those of different joints of one degree of freedom.
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
