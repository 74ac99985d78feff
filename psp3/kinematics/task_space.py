r"""Task space of a robot.

It gives the placement of a frame, its motion, and its distance from a desired placement.

With a the actuated positions and :math:`x = f(a)` the frame's coordinates,

.. math:: \dot x = J \dot a, \qquad \ddot x = J \ddot a + \dot J \dot a .

:math:`\dot J \dot a` is exact: the joints get the accelerations that keep the loops closed at
constant speeds of the actuated joints, and Pinocchio propagates these through the tree. For the tip
of the 3-PSP, :meth:`psp3.PSP3.rates_of_tip` is the inverse.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin

from fuzzy2.support.described import Described
from psp3.checks import Array
from psp3.errors import InvalidValue
from psp3.kinematics.frames import motion_and_jacobian
from psp3.kinematics.tasks import TASK_COORDINATES, checked_frame, checked_task
from psp3.multibody.named_frames import frame_number
from psp3.robots.closed_loop_robot import ClosedLoopRobot


class TaskState(NamedTuple):
    r"""A frame in one state of the robot, in t coordinates of a task.

    ``placement`` (4, 4); ``velocity`` (t,), :math:`J \dot a`; ``drift`` (t,),
    :math:`\dot J \dot a`; ``jacobian`` (t, n), :math:`J`.
    """

    placement: Array
    velocity: Array
    drift: Array
    jacobian: Array


class TaskSpace(Described):
    """Coordinates of a frame of a robot.

    Parameters
    ----------
    robot : ClosedLoopRobot
        The robot.
    frame : str
        Name of a frame of the model.
    task : sequence of str
        Some of ``x``, ``y``, ``z``, ``rx``, ``ry``, ``rz``: position of the frame's origin and
        rotation, in base axes.

    Attributes
    ----------
    rows : list of int
        Rows of the task in a velocity of six dimensions.

    Raises
    ------
    UnknownName
        If the model has no such frame, or there is no such coordinate.
    InvalidValue
        If the task is empty, or names a coordinate twice.
    """

    def __init__(
        self, robot: ClosedLoopRobot, frame: str = "tip", task: Sequence[str] = ("x", "y", "z")
    ) -> None:
        self.robot, self.frame, self.task = robot, checked_frame(robot, frame), checked_task(task)
        self.rows = [TASK_COORDINATES.index(name) for name in self.task]
        self._index = frame_number(robot.model, frame)
        self._is_position = max(self.rows) < 3

    def _facts(self) -> dict[str, Any]:
        return {"robot": self.robot, "frame": self.frame, "task": self.task}

    def state(self, position: Array, speed: Array) -> TaskState:
        """Return the frame's motion and Jacobian for one state.

        The state is positions and speeds (n,) of the actuated joints.
        """
        motion, jacobian = motion_and_jacobian(
            self.robot, self._index, position, speed, np.zeros_like(speed)
        )
        return TaskState(
            motion.placement,
            motion.velocity[self.rows],
            motion.acceleration[self.rows],
            jacobian[self.rows],
        )

    def jacobian(self, position: Array) -> Array:
        """Return the Jacobian (t, n) of the task at positions (n,) of the actuated joints."""
        if self._is_position:
            return self.robot.position_jacobian(position, self.frame)[self.rows]
        return self.robot.frame_jacobian(position, self.frame)[self.rows]

    def error(self, desired: Array, actual: Array) -> Array:
        r"""Return the difference of a placement from the desired one in task coordinates.

        The remaining rotation is :math:`\log (R_d R^\top)`, a vector along its axis in base axes
        whose length is its angle.

        Parameters
        ----------
        desired, actual : (4, 4) ndarray
            Homogeneous transforms.

        Returns
        -------
        (t,) ndarray
            Differences [m], [rad].
        """
        whole = np.concatenate(
            [desired[:3, 3] - actual[:3, 3], pin.log3(desired[:3, :3] @ actual[:3, :3].T)]
        )
        difference: Array = whole[self.rows]
        return difference


def square_task(robot: ClosedLoopRobot, frame: str, task: Sequence[str]) -> TaskSpace:
    """Return a task space with as many coordinates as the robot.

    Raise :class:`InvalidValue` if they are more or fewer.
    """
    space = TaskSpace(robot, frame, task)
    if len(space.task) != len(robot.coordinates_v):
        raise InvalidValue(
            "task",
            space.task,
            f"as many coordinates as the robot, {len(robot.coordinates_v)}: it has "
            f"{', '.join(robot.coordinates)}",
        )
    return space
