"""Coordinates of a frame that make up a task, and the length that weights angles."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from psp3.checks import checked_names, checked_robot
from psp3.errors import InvalidValue, UnknownName
from psp3.multibody.equations import Coupling
from psp3.multibody.named_frames import frame_number
from psp3.robots.closed_loop_robot import ClosedLoopRobot

TASK_COORDINATES = ("x", "y", "z", "rx", "ry", "rz")
"""Names of the rows of a task: velocity of a frame's origin and angular velocity, all in base axes.
"""


def characteristic_length(robot: ClosedLoopRobot) -> float:
    r"""Return the root mean square distance of a robot's joints from their mean position.

    The robot is in its reference configuration.

    .. math:: \ell = \sqrt{\frac1k \sum_i \lVert p_i - \bar p \rVert^2}

    Parameters
    ----------
    robot : ClosedLoopRobot
        The robot.

    Returns
    -------
    float
        Length [m].

    Raises
    ------
    InvalidValue
        If all joints are at one place, so that the length would be zero.
    """
    pin.forwardKinematics(robot.model, robot.data, robot.q0)
    places = np.array(
        [robot.data.oMi[index].translation for index in range(1, robot.model.njoints)]
    )
    length = float(np.sqrt(((places - places.mean(axis=0)) ** 2).sum(axis=1).mean()))
    if length < 1e-9:
        raise InvalidValue(
            "length", None, "given in meters for a robot whose joints are all in one place"
        )
    return length


def rotating(model: pin.Model) -> NDArray[np.bool_]:
    """Return which components of a joint velocity are angular, (nv,) of bool; screws' are."""
    data = model.createData()
    pin.computeJointJacobians(model, data, pin.neutral(model))
    angular = np.zeros(model.nv, dtype=bool)
    for index in range(1, model.njoints):
        joint = model.joints[index]
        columns = slice(joint.idx_v, joint.idx_v + joint.nv)
        # If there is only one column, Pinocchio's Jacobians have no second dimension.
        own = pin.getJointJacobian(model, data, index, pin.ReferenceFrame.LOCAL).reshape(
            6, model.nv
        )[:, columns]
        angular[columns] = np.abs(own[3:]).max(axis=0, initial=0.0) > 0.0
    return angular


def checked_motors(robot: ClosedLoopRobot) -> ClosedLoopRobot:
    """Return a robot; raise if its motors do not command all of its coordinates."""
    checked_robot(robot)
    if robot.commanded < len(robot.coordinates_v):
        followers = ", ".join(robot.coordinates[robot.commanded :])
        raise InvalidValue(
            "robot",
            robot.title,
            f"one whose motors command all coordinates; in this one {followers} follow (free="
            "'lock' holds what can be held)",
        )
    return robot


def equations_of(robot: ClosedLoopRobot) -> list[Any]:
    """Return a robot's closures without a constraint model, and those of its locked joints."""
    held: list[Any] = list(robot.equations)
    for one in robot.locked:
        if one.spin is not None:
            held.append(one.spin)
            continue
        number = robot.model.getJointId(one.joint)
        place = robot.q0[robot.model.joints[number].idx_q]
        # A held joint is a coupling of the joint with itself.
        held.append(Coupling(f"{one.joint}, held", number, number, (float(place),)))
    return held


def checked_frame(robot: ClosedLoopRobot, frame: str) -> str:
    """Return the name of a frame; raise if the robot has no such frame."""
    checked_robot(robot)
    frame_number(robot.model, frame)
    return frame


def checked_task(task: Sequence[str]) -> tuple[str, ...]:
    """Return a task's coordinates as a tuple.

    Raise if one is unknown or occurs twice, or if there are none.
    """
    names = checked_names("task", task)
    for name in names:
        if name not in TASK_COORDINATES:
            raise UnknownName("task coordinate", name, TASK_COORDINATES)
    if not names or len(set(names)) < len(names):
        raise InvalidValue(
            "task", names, f"one or more of {', '.join(TASK_COORDINATES)}, each once"
        )
    return names
