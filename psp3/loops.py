"""Loop files: which frames of a tree coincide in the assembled robot, and which joints are actuated.

The keys are those of toolbox-parallel-robots, so its files can be read here and ours there::

    closed_loop: [[frameA, frameB], ...]   # pairs of frames that coincide
    type: ['6d', '3d', ...]                # '6d': position and orientation; '3d': position only
    name_mot: [joint, ...]                 # the actuated joints
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

import pinocchio as pin

from psp3.errors import InvalidRobotFile

KINDS = ("6d", "3d")


class Loops(NamedTuple):
    """Contents of a loop file: pairs of frame names, the kind of each closure, names of the actuated joints."""

    frames: tuple[tuple[str, str], ...]
    kinds: tuple[str, ...]
    actuated: tuple[str, ...]


def _names(path: Path, value: Any, key: str) -> tuple[str, ...]:
    if not isinstance(value, list) or not all(isinstance(name, str) for name in value):
        raise InvalidRobotFile(path, f"key {key!r} must hold a list of names, got {value!r}")
    return tuple(value)


def read_loops(path: str | Path) -> Loops:
    """Read a loop file.

    Parameters
    ----------
    path : path
        A YAML file with the keys ``closed_loop``, ``type`` and ``name_mot``.

    Returns
    -------
    Loops
        What the file says; whether the names exist in a model is checked by :func:`constraint_models`.

    Raises
    ------
    InvalidRobotFile
        If the file is missing, is not YAML, lacks a key or holds something else than the format asks for.
    """
    import yaml

    path = Path(path)
    try:
        content = yaml.safe_load(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise InvalidRobotFile(path, f"cannot be read as YAML ({getattr(error, 'strerror', None) or error})") from error
    if not isinstance(content, dict):
        raise InvalidRobotFile(path, "must hold the keys closed_loop, type and name_mot")
    missing = [key for key in ("closed_loop", "type", "name_mot") if key not in content]
    if missing:
        raise InvalidRobotFile(path, f"lacks the key {', '.join(missing)}")
    pairs = content["closed_loop"]
    if not isinstance(pairs, list):
        raise InvalidRobotFile(path, f"key 'closed_loop' must hold a list of frame pairs, got {pairs!r}")
    frames = tuple(_names(path, pair, "closed_loop") for pair in pairs)
    if any(len(pair) != 2 for pair in frames):
        raise InvalidRobotFile(path, f"every closed loop joins two frames, got {pairs!r}")
    kinds = tuple(kind.lower() for kind in _names(path, content["type"], "type"))
    if len(kinds) != len(frames) or any(kind not in KINDS for kind in kinds):
        raise InvalidRobotFile(
            path, f"key 'type' must give '6d' or '3d' for each of the {len(frames)} closed loops, got {content['type']!r}"
        )
    return Loops(tuple((pair[0], pair[1]) for pair in frames), kinds, _names(path, content["name_mot"], "name_mot"))


def constraint_models(model: pin.Model, loops: Loops, path: str | Path) -> Any:
    """Return the loops as Pinocchio constraint models.

    Parameters
    ----------
    model : pinocchio.Model
        The tree.
    loops : Loops
        Frame pairs and kinds of closure.
    path : path
        The loop file, for error messages.

    Returns
    -------
    pinocchio.StdVec_RigidConstraintModel
        One constraint model per loop, in the local frame of its first frame.

    Raises
    ------
    InvalidRobotFile
        If a frame or an actuated joint is not in the model, or an actuated joint has more than one degree of freedom.
    """
    models = pin.StdVec_RigidConstraintModel()
    for pair, kind in zip(loops.frames, loops.kinds, strict=True):
        for name in pair:
            if not model.existFrame(name):
                raise InvalidRobotFile(path, f"closed loop {list(pair)}: the robot has no frame {name!r}")
        first, second = (model.frames[model.getFrameId(name)] for name in pair)
        contact = pin.ContactType.CONTACT_6D if kind == "6d" else pin.ContactType.CONTACT_3D
        models.append(
            pin.RigidConstraintModel(
                contact, model, first.parentJoint, first.placement, second.parentJoint, second.placement, pin.ReferenceFrame.LOCAL
            )
        )
        models[-1].name = f"{pair[0]}-{pair[1]}"
    for name in loops.actuated:
        if not model.existJointName(name) or name == model.names[0]:
            known = ", ".join(list(model.names)[1:])
            raise InvalidRobotFile(path, f"name_mot: the robot has no joint {name!r}; its joints are {known}")
        joint = model.joints[model.getJointId(name)]
        if joint.nq != 1 or joint.nv != 1:
            raise InvalidRobotFile(
                path,
                f"name_mot: joint {name!r} has {joint.nv} degrees of freedom in {joint.nq} coordinates; only joints with one of each can "
                "be actuated (in a URDF, make a continuous joint revolute, with limits)",
            )
    if len(set(loops.actuated)) != len(loops.actuated):
        raise InvalidRobotFile(path, f"name_mot names a joint twice: {list(loops.actuated)}")
    return models
