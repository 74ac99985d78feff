"""Tables of the joints of any robot: labels, units, and the role of each joint."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from psp3.robots.closed_loop_robot import ClosedLoopRobot


class JointRow(NamedTuple):
    """A joint in one configuration."""

    joint: str
    values: Any
    """Its part of the configuration, (k,) [m, rad; a quaternion for a ball joint]."""
    unit: str
    role: str
    """``motor``, ``coordinate``, ``held`` or ``follows``."""
    is_within: bool
    """Whether it is within its limits."""


def position_labels(robot: ClosedLoopRobot) -> list[str]:
    """Return a label for each position of the coordinates, (p)."""
    return _labels(robot, "nq")


def speed_labels(robot: ClosedLoopRobot) -> list[str]:
    """Return a label for each speed and force of the coordinates, (n)."""
    return _labels(robot, "nv")


def force_units(robot: ClosedLoopRobot) -> list[str]:
    """Return ``N m`` or ``N`` for each force of the coordinates, (n)."""
    from psp3.kinematics.tasks import rotating

    turning = rotating(robot.model)[robot.coordinates_v]
    return ["N m" if turns else "N" for turns in turning]


def commanded_joints(robot: ClosedLoopRobot) -> tuple[str, ...]:
    """Return the coordinates that the motors command, (k); desired motions are given in these."""
    return robot.coordinates[: robot.commanded]


def what_follows(robot: ClosedLoopRobot) -> str:
    """Describe the coordinates that no motor commands, and how they move; empty if none."""
    others = robot.coordinates[robot.commanded :]
    if not others:
        return ""
    falls = robot.reference.size > robot.coordinates_v.size
    base = f"; {others[-1]} floats: nothing holds the robot up, so it falls" if falls else ""
    return f"no motor commands {', '.join(others)}, which follow{base}"


def joint_units(robot: ClosedLoopRobot, names: Iterable[str]) -> list[str]:
    """Return the unit, ``rad`` or ``m``, of each joint or motor; empty for a tendon."""
    from psp3.kinematics.tasks import rotating

    turning = rotating(robot.model)
    joints = {
        name: "rad" if turning[joint.idx_v] else "m"
        for name, joint in zip(robot.model.names, robot.model.joints, strict=True)
        if joint.nv == 1
    }
    return [joints.get(name, "") for name in names]


def joint_rows(robot: ClosedLoopRobot, q: Any) -> list[JointRow]:
    """Return a row for each joint of the tree."""
    from psp3.kinematics.tasks import rotating

    turning = rotating(robot.model)
    held = {one.joint for one in robot.locked}
    rows = []
    for name, joint in list(zip(robot.model.names, robot.model.joints, strict=True))[1:]:
        here = slice(joint.idx_q, joint.idx_q + joint.nq)
        lower, upper = robot.model.lowerPositionLimit[here], robot.model.upperPositionLimit[here]
        within = joint.nq != joint.nv or bool(((q[here] >= lower) & (q[here] <= upper)).all())
        unit = ("rad" if turning[joint.idx_v] else "m") if joint.nq == joint.nv else "m, quaternion"
        if joint.nq == 4 and joint.nv == 3:
            unit = "quaternion"
        role = (
            "motor"
            if name in robot.actuated
            else "coordinate"
            if name in robot.coordinates
            else "held"
            if name in held
            else "follows"
        )
        rows.append(JointRow(str(name), q[here], unit, role, within))
    return rows


def _labels(robot: ClosedLoopRobot, size: str) -> list[str]:
    labels = []
    for name in robot.coordinates:
        count = getattr(robot.model.joints[robot.model.getJointId(name)], size)
        labels += [name] if count == 1 else [f"{name} {k}" for k in range(1, count + 1)]
    return labels
