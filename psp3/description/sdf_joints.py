"""Read the joints of an SDF file: their types and the numbers of their axes."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ElementTree
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin

from psp3.checks import Array
from psp3.description.sdf_frames import Frame, Reader
from psp3.description.xml import described

AXES = {
    "revolute": 1,
    "continuous": 1,
    "prismatic": 1,
    "screw": 1,
    "gearbox": 2,
    "revolute2": 2,
    "universal": 2,
    "ball": 0,
    "fixed": 0,
}
"""Joint types, and how many axes each needs."""

UNLIMITED = 1e16
"""A limit of at least this is no limit; until version 1.9 it was the default."""


class Axis(NamedTuple):
    """An axis of a joint."""

    name: str
    """The name of its coordinate in the robot."""
    direction: Array
    """Its direction in the joint's frame, in the pose of the file, (3,), of length 1."""
    limits: tuple[float, float]
    """Limits of the coordinate [m or rad]."""
    effort: float
    """Largest force or torque of a motor [N or N m]."""
    velocity: float
    """Largest speed [m/s or rad/s]."""
    damping: float
    """Viscous friction [N s/m or N m s]."""
    friction: float
    """Dry friction [N or N m]."""
    stiffness: float
    """Stiffness of the spring [N/m or N m/rad]."""
    rest: float
    """The coordinate where the spring is at rest [m or rad]."""
    mimic: ElementTree.Element | None
    """The element <mimic>, which names the coordinate that it follows."""

    @property
    def acts(self) -> bool:
        """Whether it has forces, limits or a coupling, which only a joint can hold."""
        forces = (self.damping, self.friction, self.stiffness)
        return any(forces) or any(map(math.isfinite, self.limits)) or self.mimic is not None


class Joint(NamedTuple):
    """A joint."""

    frame: Frame
    """Its name and pose."""
    kind: str
    """One of :data:`AXES`."""
    parent: Frame | None
    """The link it hangs on; None for the world."""
    child: Frame | None
    """The link it carries."""
    axes: tuple[Axis, ...]
    """Its axes, the parent's first; a ball may have one, for its damping only."""
    pitch: float
    """Translation of a screw per rotation [m/rad]."""

    @property
    def name(self) -> str:
        """Its name in the robot."""
        return self.frame.full_name

    def models(self) -> list[tuple[str, Any, Axis | None]]:
        """Return its coordinates, the parent's first: name, Pinocchio's joint model and axis."""
        if self.kind == "ball":
            return [(self.name, pin.JointModelSpherical(), self.axes[0] if self.axes else None)]
        made: list[tuple[str, Any, Axis | None]] = []
        for axis in self.axes:
            if self.kind == "prismatic":
                model = pin.JointModelPrismaticUnaligned(axis.direction)
            elif self.kind == "screw":
                model = pin.JointModelHelicalUnaligned(axis.direction, self.pitch)
            else:
                model = pin.JointModelRevoluteUnaligned(axis.direction)
            made.append((axis.name, model, axis))
        return made


def read_joint(reader: Reader, frame: Frame) -> Joint:
    """Return a joint.

    Raises
    ------
    InvalidRobotFile
        If its type is unknown, its links are missing or the same, an axis is missing or zero, or a
        number is out of range.
    """
    element, document = frame.element, frame.document
    kind = (element.get("type") or "").strip().lower()
    if kind not in AXES:
        raise document.wrong(
            f"{described(element)}: type {element.get('type')!r} is unknown; known are "
            f"{', '.join(AXES)}"
        )
    ends: list[Frame | None] = []
    for role in ("parent", "child"):
        name = document.text(element, role) or ""
        if not name:
            raise document.wrong(f"{described(element)} lacks <{role}>")
        if name == "world" and role == "parent":
            ends.append(None)
        else:
            ends.append(reader.link(frame.scope.find(name, frame)))
    if ends[0] is ends[1]:
        raise document.wrong(f"{described(element)} joins a link with itself")
    tags = [tag for tag in ("axis", "axis2") if element.find(tag) is not None]
    needed = ["axis", "axis2"][: AXES[kind]]
    for tag in needed:
        if tag not in tags:
            raise document.wrong(f"{described(element)}: a {kind} joint needs an <{tag}>")
    if kind == "ball":
        needed = tags[:1]
    axes = [_axis(reader, frame, kind, tag, len(needed) > 1) for tag in needed]
    return Joint(frame, kind, ends[0], ends[1], tuple(axes), _pitch(frame, kind))


def _pitch(frame: Frame, kind: str) -> float:
    if kind != "screw":
        return 0.0
    element, document = frame.element, frame.document
    # The new element is a length per turn, the old one radians per meter of a left-handed thread.
    turns = document.numbers(element, "screw_thread_pitch", 1)
    old = document.numbers(element, "thread_pitch", 1)
    if turns is not None:
        return float(turns[0]) / (2.0 * math.pi)
    if old is None or old[0] == 0.0:
        raise document.wrong(
            f"{described(element)}: a screw needs a <screw_thread_pitch>, or a <thread_pitch> that "
            "is not zero"
        )
    return -1.0 / float(old[0])


def _axis(reader: Reader, frame: Frame, kind: str, tag: str, is_one_of_two: bool) -> Axis:
    document = frame.document
    element = _only(frame, frame.element, tag)
    assert element is not None
    number, title = document.number, described(frame.element)
    lower, upper, effort, velocity = -math.inf, math.inf, math.inf, math.inf
    limit = _only(frame, element, "limit")
    if limit is not None:
        lower = number(limit, "lower", -math.inf, infinite=True)
        upper = number(limit, "upper", math.inf, infinite=True)
        effort = number(limit, "effort", math.inf, infinite=True)
        velocity = number(limit, "velocity", math.inf, infinite=True)
    is_endless = kind in ("continuous", "ball")
    lower = -math.inf if lower <= -UNLIMITED or is_endless else lower
    upper = math.inf if upper >= UNLIMITED or is_endless else upper
    if not (lower <= upper and lower < math.inf and upper > -math.inf):
        raise document.wrong(f"{title}: its lower limit {lower:g} is above its upper one {upper:g}")
    dynamics, damping, friction, stiffness, rest = (
        _only(frame, element, "dynamics"),
        0.0,
        0.0,
        0.0,
        0.0,
    )
    if dynamics is not None:
        damping = number(dynamics, "damping", 0.0)
        friction = number(dynamics, "friction", 0.0)
        stiffness = number(dynamics, "spring_stiffness", 0.0)
        rest = number(dynamics, "spring_reference", 0.0)
    for what, value in (("damping", damping), ("friction", friction), ("stiffness", stiffness)):
        if value < 0.0:
            raise document.wrong(f"{title}: its {what} {value:g} is negative")
    return Axis(
        f"{frame.full_name}_{tag}" if is_one_of_two else frame.full_name,
        _direction(reader, frame, element),
        (lower, upper),
        # A negative limit of a force or speed means that there is no limit.
        effort if effort >= 0.0 else math.inf,
        velocity if velocity >= 0.0 else math.inf,
        damping,
        friction if kind != "ball" else 0.0,
        stiffness if kind != "ball" else 0.0,
        rest,
        _only(frame, element, "mimic") if kind != "ball" else None,
    )


def _only(frame: Frame, element: ElementTree.Element, tag: str) -> ElementTree.Element | None:
    """Return the only child with a tag; None if there is none."""
    found = element.findall(tag)
    if len(found) > 1:
        raise frame.document.wrong(f"{described(frame.element)} has {len(found)} of <{tag}>")
    return found[0] if found else None


def _direction(reader: Reader, frame: Frame, axis: ElementTree.Element) -> Array:
    """Return the direction of an axis in the joint's frame."""
    document, text = frame.document, frame.document.text(axis, "xyz")
    # An empty element stands for the default, z.
    vector = document.numbers(axis, "xyz", 3) if text else np.array([0.0, 0.0, 1.0])
    assert vector is not None
    length = float(np.linalg.norm(vector))
    if not 1e-100 < length < 1e100:
        raise document.wrong(f"{described(frame.element)}: its <{axis.tag}> has no direction")
    xyz = axis.find("xyz")
    if document.version >= 7:
        name = "" if xyz is None else xyz.get("expressed_in", "")
    else:
        # In version 1.4 every axis was given in the frame of the model.
        in_model = document.is_true(axis, "use_parent_model_frame", document.version == 4)
        name = frame.model if in_model else ""
    direction = np.asarray(vector / length)
    if not name:
        return direction
    turn = reader.placement(frame.scope.find(name, frame)).rotation
    return np.asarray(reader.placement(frame).rotation.T @ turn @ direction)
