"""Write the closures and motors of an exported robot in MuJoCo's terms.

* A closure becomes a weld (6D) or a connect (3D) between two sites. A hinge becomes two connects,
  at two points of its axis.
* A coupling becomes a joint equality with its polynomial, and a held joint becomes one with a
  constant.
* A ball joint whose spin is held can spin in MuJoCo. That is the same robot if the spinning body is
  a body of revolution about the axis of the spin, such as a rod between two balls, because the spin
  then has no effect. Any other held spin is refused.
* A motor on a tendon becomes a fixed tendon with a motor.

Equalities join sites, not bodies, because the places of sites do not depend on the configuration in
which MuJoCo compiles the model.
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
from psp3.robots.simple_joints import is_round

HINGE_SHARE = 0.5
"""Distance between the two points of a hinge, relative to the mean distance of its bodies' joints
from it.
"""

Text = Callable[[Any], str]


def check_exportable(robot: ClosedLoopRobot) -> None:
    """Raise :class:`InvalidValue` if held motions of a robot cannot be written for MuJoCo."""
    for held in robot.locked:
        if held.spin is not None and not _spins_freely(robot, held):
            raise InvalidValue(
                "robot",
                robot.title,
                "one whose spinning body is one of revolution and moves nothing else: "
                f"{held} is held, which MuJoCo cannot represent",
            )


def _spins_freely(robot: ClosedLoopRobot, held: Locked) -> bool:
    model, spin = robot.model, held.spin
    assert spin is not None
    for name in held.moving:
        if not is_ball(model.joints[model.getJointId(name)]):
            return False
    return is_round(model, spin)


def add_equalities(
    robot: ClosedLoopRobot,
    root: ET.Element,
    at_joint: dict[int, ET.Element],
    hard: dict[str, str],
    text: Text,
) -> None:
    """Write closures, hinges, couplings and held joints.

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

    Their distance is about the size of the bodies, so that MuJoCo gives rotation and translation
    equal weight.
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
    """Sites of the bodies, created on demand."""

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
