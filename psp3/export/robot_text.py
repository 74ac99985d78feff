"""The description of a robot in the header: its coordinates, joints, motors and codes, in order."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

from fuzzy2.errors import NotExportable
from psp3.errors import InvalidValue, UnknownName
from psp3.multibody.closing import MOST_ITERATIONS
from psp3.multibody.named_frames import frame_number
from psp3.multibody.tree import GROUPS
from psp3.version import __version__

CODES = (
    "Return codes:",
    "0  done",
    "1  the loops could not be closed on the way to the positions: the report in the state says",
    "   which share of the way it came, the residual, and the group of loops",
    "2  the mass matrix is singular here",
    "3  a passive joint would be beyond its limits",
    "4  a result is not finite, for example because an argument is not",
    "5  the motors cannot produce this motion",
    "If it is not 0 the results are NaN, and the next call starts from the reference pose.",
)


KINDS = {
    "JointModelFreeFlyer": "position, then quaternion (x, y, z, w) of unit length; its speeds are "
    "linear, then angular, in its own axes",
    "JointModelPlanar": "position in a plane, then cosine and sine; its speeds are linear, then "
    "angular, in its own axes",
    "JointModelSpherical": "quaternion (x, y, z, w) of unit length; its speeds are angular, in its "
    "own axes",
}
TURNS = "cosine and sine; its speed is angular"
"""Descriptions of joints that have several numbers."""

LONGEST = 48
"""Greatest length of a prefix that is made from a name, because files are named after it, too."""


def identifier(name: str) -> str:
    """Return a name as an identifier of C."""
    word = re.sub(r"\W+", "_", name, flags=re.ASCII).strip("_")
    return f"robot_{word}" if not word or word[0].isdigit() else word


def prefix_of(name: str) -> str:
    """Return the prefix of all names in a robot's code, which is also the stem of its files."""
    return identifier(name or "robot")[:LONGEST]


def chosen(functions: Sequence[str] | None, known: Sequence[str] | dict[str, int]) -> list[str]:
    """Return the chosen functions; all by default.

    Raises
    ------
    UnknownName
        If there is no such function; the error lists the known ones.
    """
    wanted = list(known) if functions is None else list(functions)
    for name in wanted:
        if name not in known:
            raise UnknownName("function", name, list(known))
    if not wanted:
        raise InvalidValue("functions", functions, f"some of {', '.join(known)}")
    return wanted


def frames_of(robot: Any, frames: Sequence[str] | None) -> dict[str, str]:
    """Return the prefix of the functions of each frame.

    Raises
    ------
    UnknownName
        If the robot has no such frame.
    NotExportable
        If two frames have the same prefix.
    """
    if frames is None:
        frames = ("tip",) if robot.model.existFrame("tip") else ()
    prefixes: dict[str, str] = {}
    for frame in frames:
        frame_number(robot.model, frame)
        prefix = identifier(frame)
        if prefix in prefixes.values():
            raise NotExportable(f"frame {frame!r}", f"another one is {prefix} in C", "one of them")
        prefixes[frame] = prefix
    return prefixes


def _entries(model: Any, joints: Sequence[str], of_speeds: bool) -> list[str]:
    """Return a name for each coordinate, or each speed, of joints."""
    names = []
    for name in joints:
        joint = model.joints[model.getJointId(name)]
        count = joint.nv if of_speeds else joint.nq
        names += [name] if count == 1 else [f"{name}[{k}]" for k in range(count)]
    return names


def _kinds(model: Any, joints: Sequence[str]) -> str:
    """Describe the joints that have several numbers."""
    named: dict[str, list[str]] = {}
    for name in joints:
        joint = model.joints[model.getJointId(name)]
        if joint.nq > 1:
            named.setdefault(KINDS.get(joint.shortname(), TURNS), []).append(name)
    return "\n".join(f"{', '.join(names)}: {told}" for told, names in named.items())


def numbered(title: str, names: Sequence[str]) -> str:
    """Return names with their places, a line each."""
    return "\n".join([f"{title}:", *(f"{k:3d}  {name}" for k, name in enumerate(names))])


def about(robot: Any, table: Any, most_attempts: int) -> list[str]:
    """Return the paragraphs of the header."""
    model, groups = robot.model, int(table.tree[GROUPS])
    gravity = ", ".join(repr(float(g)) for g in model.gravity.linear)
    joints = [str(name) for name in list(model.names)[1:]]
    parts = [
        f"{robot.title}: kinematics and dynamics, written by psp3 {__version__}.",
        "SI units: m, rad, s, kg, N. Matrices stand row by row. Base axes are those of the model;\n"
        f"free fall is ({gravity}) m/s².",
        numbered("Positions of coordinates", _entries(model, robot.coordinates, False)),
    ]
    if len(robot.coordinates_q) != len(robot.coordinates_v):
        parts.append(
            numbered("Speeds, accelerations and forces", _entries(model, robot.coordinates, True))
        )
    parts.append(numbered("Coordinates of all joints, q", _entries(model, joints, False)))
    if kinds := _kinds(model, joints):
        parts.append(f"What they are:\n{kinds}")
    if tuple(robot.actuated) != tuple(robot.coordinates):
        parts.append(numbered("Motors", robot.actuated))
    parts.append("\n".join(CODES))
    parts.append(bound_of_time(groups, most_attempts))
    return parts


def bound_of_time(groups: int, most_attempts: int) -> str:
    """Describe the greatest number of iterations of a call."""
    if not groups:
        return "There are no loops: every call takes the same time, except for branches."
    return (
        f"Loops are closed from the last pose, in {groups} group(s), each in at most\n"
        f"{most_attempts} parts of the way, and each of these in at most {MOST_ITERATIONS} steps "
        "of Newton's method:\n"
        f"no call takes more than {groups * most_attempts * MOST_ITERATIONS} of them. Poses close "
        "to each other take two or three."
    )
