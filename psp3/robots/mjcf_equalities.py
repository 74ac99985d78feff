"""What holds the bodies of an exported robot together, and what drives them, in MuJoCo's words.

* A closure becomes a weld (6D) or a connect (3D) between two sites; a hinge two connects, at two
  points of its axis.
* A coupling becomes a joint equality with its polynomial, and a joint that is held one with a
  constant.
* A ball whose spin is held stays free in MuJoCo. That is the same robot if what spins is a body
  of revolution about the axis of the spin, as a rod between two balls: nothing else feels how it
  has turned. Anything else is refused.
* A motor on a tendon becomes a fixed tendon with a motor.

Sites, not bodies, are what is joined: their places do not depend on the configuration in which
MuJoCo compiles the model.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pinocchio as pin

from psp3.closure.coordinates import Locked, is_ball
from psp3.errors import InvalidValue
from psp3.multibody.equations import Coupling, Hinge
from psp3.robots.closed_loop_robot import ClosedLoopRobot

SYMMETRIC = 1e-6
"""Share of its largest moment, and of its size, by which a body that spins may be off its axis; the
axis of a spin is found to 1e-8.
"""

HINGE_SHARE = 0.5
"""Distance of the two points of a hinge, in mean distances of its bodies' joints to it."""

Text = Callable[[Any], str]


def check_exportable(robot: ClosedLoopRobot) -> None:
    """Raise :class:`InvalidValue` if what is held of a robot cannot be written for MuJoCo."""
    for held in robot.locked:
        if held.spin is not None and not _spins_freely(robot, held):
            raise InvalidValue(
                "robot",
                robot.title,
                f"one of which what spins is a body of revolution, and moves nothing else: "
                f"{held} is held, and MuJoCo has no words for that",
            )


def _spins_freely(robot: ClosedLoopRobot, held: Locked) -> bool:
    model, spin = robot.model, held.spin
    assert spin is not None
    for name in held.moving:
        if not is_ball(model.joints[model.getJointId(name)]):
            return False
    inertia, axis = model.inertias[spin.joint], spin.axis
    across = np.eye(3) - np.outer(axis, axis)
    moments = inertia.inertia
    round_one = 0.5 * np.trace(across @ moments) * across + (axis @ moments @ axis) * np.outer(
        axis, axis
    )
    off = np.abs(across @ inertia.lever).max()
    return bool(
        np.abs(moments - round_one).max() <= SYMMETRIC * np.abs(moments).max()
        and off <= SYMMETRIC * max(np.abs(inertia.lever).max(), 1e-3)
    )


def add_equalities(
    robot: ClosedLoopRobot,
    root: ET.Element,
    at_joint: dict[int, ET.Element],
    hard: dict[str, str],
    text: Text,
) -> None:
    """Write closures, hinges, couplings and joints that are held.

    ``hard`` holds the attributes of an equality, ``text`` writes numbers.
    """
    equality = ET.SubElement(root, "equality")
    sites = _Sites(at_joint, text)
    ends: tuple[tuple[int, pin.SE3], ...]
    for closure in robot.constraint_models:
        kind = "weld" if closure.type == pin.ContactType.CONTACT_6D else "connect"
        ends = (
            (closure.joint1_id, closure.joint1_placement),
            (closure.joint2_id, closure.joint2_placement),
        )
        sites.join(equality, kind, ends, hard)
    for one in robot.equations:
        if isinstance(one, Hinge):
            for ends in _points(robot, one):
                sites.join(equality, "connect", ends, hard)
        elif isinstance(one, Coupling):
            joints = {"joint1": robot.model.names[one.y], "joint2": robot.model.names[one.x]}
            coefficients = [*one.coefficients, *[0.0] * 5][:5]
            if one.x == one.y:
                del joints["joint2"]
            ET.SubElement(
                equality, "joint", joints | {"polycoef": text(coefficients)} | hard, name=one.name
            )
    for held in robot.locked:
        if held.spin is None:
            joint = robot.model.joints[robot.model.getJointId(held.joint)]
            q = robot.q0[joint.idx_q : joint.idx_q + joint.nq]
            place = q[0] if joint.nq == 1 else np.arctan2(q[1], q[0])
            constant = text([place, 0.0, 0.0, 0.0, 0.0])
            ET.SubElement(
                equality, "joint", {"joint1": held.joint, "polycoef": constant} | hard
            ).set("name", f"{held.joint}_held")


def _points(robot: ClosedLoopRobot, hinge: Hinge) -> Iterator[tuple[tuple[int, pin.SE3], ...]]:
    """Yield two points of a hinge's axis on both of its bodies.

    As far apart as the bodies are large, so that MuJoCo weighs turning and sliding alike.
    """
    sides = (
        (hinge.joint1_id, hinge.joint1_placement),
        (hinge.joint2_id, hinge.joint2_placement),
    )
    reach = float(np.mean([np.linalg.norm(placement.translation) for _, placement in sides]))
    for step in (0.0, HINGE_SHARE * reach if reach > 0.0 else 0.1):
        along = pin.SE3(np.eye(3), np.array([0.0, 0.0, step]))
        yield tuple((joint, placement * along) for joint, placement in sides)


def add_motors(
    robot: ClosedLoopRobot, root: ET.Element, limits: dict[str, float | None], text: Text
) -> None:
    """Write fixed tendons, and a motor on every actuated joint or tendon.

    ``limits`` holds the largest force of each motor that has one.
    """
    tendons = robot.options["tendons"] or {}
    if tendons:
        section = ET.SubElement(root, "tendon")
        for name, levers in tendons.items():
            fixed = ET.SubElement(section, "fixed", name=name)
            for joint, lever in levers.items():
                ET.SubElement(fixed, "joint", joint=joint, coef=text([lever]))
    actuators = ET.SubElement(root, "actuator")
    for name in robot.actuated:
        limit = limits.get(name)
        ET.SubElement(
            actuators,
            "motor",
            {"name": name, "tendon" if name in tendons else "joint": name}
            | ({"ctrlrange": text([-limit, limit])} if limit else {}),
        )


class _Sites:
    """Sites of the bodies, made where there is none yet."""

    def __init__(self, at_joint: dict[int, ET.Element], text: Text) -> None:
        self.at_joint, self.text, self.count = at_joint, text, 0

    def join(
        self,
        equality: ET.Element,
        kind: str,
        ends: tuple[tuple[int, pin.SE3], ...],
        hard: dict[str, str],
    ) -> None:
        """Write an equality between the sites at two placements, each on a joint's body."""
        self.count += 1
        names = [self._site(number, *end) for number, end in enumerate(ends, start=1)]
        ET.SubElement(
            equality,
            kind,
            {"name": "-".join(names), "site1": names[0], "site2": names[1]} | hard,
        )

    def _site(self, side: int, joint: int, placement: pin.SE3) -> str:
        x, y, z, w = pin.Quaternion(placement.rotation).coeffs()
        placed = {"pos": self.text(placement.translation), "quat": self.text([w, x, y, z])}
        for site in self.at_joint[joint].findall("site"):
            if placed.items() <= site.attrib.items():
                return site.get("name", "")
        name = f"closure{self.count}_{side}"
        ET.SubElement(self.at_joint[joint], "site", {"name": name, "group": "4"} | placed)
        return name
