"""Robots with the tasks they are made for, and what turns in them."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np

from psp3.kinematics.tasks import TASK_COORDINATES
from psp3.robots.closed_loop_robot import ClosedLoopRobot
from tests.helpers import Array

TASKS = {
    "five_bar": ("x", "z"),
    "planar_3rrr": ("x", "y", "rz"),
    "delta": ("x", "y", "z"),
    "gough_stewart": TASK_COORDINATES,
    "tricept": ("x", "y", "z"),
}


def built(parts: SimpleNamespace) -> ClosedLoopRobot:
    return ClosedLoopRobot(parts.model, parts.constraint_models, parts.actuated, parts.q0)


def scales(robot: ClosedLoopRobot, length: float) -> Array:
    """One for sliders, the length for hinges, by the name of Pinocchio's class.

    Another way than the joints' axes.
    """
    scale = np.ones(robot.model.nv)
    for joint in list(robot.model.joints)[1:]:
        prismatic = "P" in joint.shortname().removeprefix("JointModel")[:1]
        free_flyer = "FreeFlyer" in joint.shortname()
        columns = np.arange(joint.idx_v + 3 * free_flyer, joint.idx_v + joint.nv)
        scale[columns] = 1.0 if prismatic else length
    return scale
