r"""Task space: where a frame of the robot is, how it moves, and how far that is from where it should be.

With a the actuated positions and :math:`x = f(a)` the frame's coordinates,

.. math:: \dot x = J \dot a, \qquad \ddot x = J \ddot a + \dot J \dot a .

:math:`\dot J \dot a` is exact: the joints are given the accelerations that keep the loops closed while the actuated ones move
uniformly, and Pinocchio carries these through the tree. For the tip of the 3-PSP, :meth:`psp3.PSP3.rates_of_tip` is the inverse.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from psp3.arrays import Array, finite_rows, together
from psp3.closed_loop_robot import ClosedLoopRobot
from psp3.errors import InvalidValue
from psp3.robot import PSP3
from psp3.singularities import TASK_COORDINATES, checked_frame, checked_task


class FrameMotion(NamedTuple):
    """Motion of a frame in base axes.

    ``placement`` (..., 4, 4), a homogeneous transform: rotation, and position [m]; ``velocity`` (..., 6), of the origin [m/s], then
    angular [rad/s]; ``acceleration`` (..., 6), of the origin [m/s²], then angular [rad/s²].
    """

    placement: Array
    velocity: Array
    acceleration: Array


def point_motion(position: ArrayLike, velocity: ArrayLike = (0.0, 0.0, 0.0), acceleration: ArrayLike = (0.0, 0.0, 0.0)) -> FrameMotion:
    """Return the motion of a frame that does not turn, as it is wanted of a tool whose orientation does not matter.

    Parameters
    ----------
    position, velocity, acceleration : (..., 3) array_like
        Of the origin, in base axes [m], [m/s], [m/s²]; at rest by default.

    Returns
    -------
    FrameMotion
        Its axes are those of the base.

    Raises
    ------
    InvalidArray
        If an argument is not finite or of another shape.
    """
    x, v, w = together(
        position=finite_rows("position", position, 3),
        velocity=finite_rows("velocity", velocity, 3),
        acceleration=finite_rows("acceleration", acceleration, 3),
    )
    placement = np.zeros((*x.shape[:-1], 4, 4))
    placement[..., :, :] = np.eye(4)
    placement[..., :3, 3] = x
    still = np.zeros_like(x)
    return FrameMotion(placement, np.concatenate([v, still], axis=-1), np.concatenate([w, still], axis=-1))


def frame_motion(
    robot: ClosedLoopRobot, positions: ArrayLike, speeds: ArrayLike, accelerations: ArrayLike, frame: str = "tip"
) -> FrameMotion:
    r"""Return how a frame moves while the actuated joints do, :math:`\dot x = J \dot a` and :math:`\ddot x = J \ddot a + \dot J \dot a`.

    Parameters
    ----------
    robot : ClosedLoopRobot
        The robot.
    positions, speeds, accelerations : (..., n) array_like
        Motion of the actuated joints [m or rad, per s, per s²].
    frame : str
        Name of a frame of the model.

    Returns
    -------
    FrameMotion
        Each field has the leading dimensions of the arguments.

    Raises
    ------
    InvalidArray, UnknownName
        If an argument is malformed, or the model has no such frame.
    ClosureFailed, JointLimitExceeded, SingularConfiguration
        If a pose cannot be taken, or the actuated joints do not determine the others there.
    """
    index, width = robot.model.getFrameId(checked_frame(robot, frame)), len(robot.actuated)
    arrays = {"positions": positions, "speeds": speeds, "accelerations": accelerations}
    a, v, w = together(**{name: finite_rows(name, values, width) for name, values in arrays.items()})
    rows = [_one_row(robot, index, *row)[0] for row in zip(a.reshape(-1, width), v.reshape(-1, width), w.reshape(-1, width), strict=True)]
    shapes = (4, 4), (6,), (6,)
    return FrameMotion(*(np.reshape([row[k] for row in rows], (*a.shape[:-1], *shape)) for k, shape in enumerate(shapes)))


def _one_row(robot: ClosedLoopRobot, index: int, position: Array, speed: Array, acceleration: Array) -> tuple[FrameMotion, Array]:
    """Return the motion of a frame, and its Jacobian (6, n), for one row of each argument."""
    model, data, base = robot.model, robot.data, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
    closure = robot.closure(position)
    q, v = closure.configuration, closure.complement @ speed
    pin.forwardKinematics(model, data, q, v, closure.complement @ acceleration + robot.drift(q, v))
    motion = FrameMotion(
        pin.updateFramePlacement(model, data, index).homogeneous,
        pin.getFrameVelocity(model, data, index, base).vector,
        # Classical: the second derivative of the origin's position. The spatial one lacks its centripetal part.
        pin.getFrameClassicalAcceleration(model, data, index, base).vector,
    )
    jacobian: Array = pin.computeFrameJacobian(model, data, q, index, base) @ closure.complement
    return motion, jacobian


class TaskState(NamedTuple):
    r"""A frame in one state of the robot, in t coordinates of a task.

    ``placement`` (4, 4); ``velocity`` (t,), :math:`J \dot a`; ``drift`` (t,), :math:`\dot J \dot a`; ``jacobian`` (t, n), :math:`J`.
    """

    placement: Array
    velocity: Array
    drift: Array
    jacobian: Array


class TaskSpace:
    """Coordinates of a frame of a robot.

    Parameters
    ----------
    robot : ClosedLoopRobot
        The robot.
    frame : str
        Name of a frame of the model.
    task : sequence of str
        Which of ``x``, ``y``, ``z``, ``rx``, ``ry``, ``rz``: position of the frame's origin and rotation, in base axes.

    Raises
    ------
    UnknownName
        If the model has no such frame, or there is no such coordinate.
    InvalidValue
        If the task is empty, or names a coordinate twice.
    """

    def __init__(self, robot: ClosedLoopRobot, frame: str = "tip", task: Sequence[str] = ("x", "y", "z")) -> None:
        self.robot, self.frame, self.task = robot, checked_frame(robot, frame), checked_task(task)
        self.rows = [TASK_COORDINATES.index(name) for name in self.task]
        self._index = robot.model.getFrameId(frame)
        self._has_closed_form = isinstance(robot, PSP3) and frame == "tip" and max(self.rows) < 3

    def state(self, position: Array, speed: Array) -> TaskState:
        """Return the frame's motion and Jacobian for one state; positions and speeds (n,) of the actuated joints."""
        motion, jacobian = _one_row(self.robot, self._index, position, speed, np.zeros_like(speed))
        return TaskState(motion.placement, motion.velocity[self.rows], motion.acceleration[self.rows], jacobian[self.rows])

    def jacobian(self, position: Array) -> Array:
        """Return the Jacobian (t, n) of the task's coordinates at positions (n,) of the actuated joints."""
        if self._has_closed_form and isinstance(self.robot, PSP3):
            return self.robot.tip_jacobian(position)[self.rows]
        return self.robot.frame_jacobian(position, self.frame)[self.rows]

    def error(self, desired: Array, actual: Array) -> Array:
        r"""Return how far a placement is from the desired one, in the task's coordinates.

        The rotation still to be made is :math:`\log (R_d R^\top)`, a vector along its axis in base axes, as long as its angle.

        Parameters
        ----------
        desired, actual : (4, 4) ndarray
            Homogeneous transforms.

        Returns
        -------
        (t,) ndarray
            Differences [m], [rad].
        """
        whole = np.concatenate([desired[:3, 3] - actual[:3, 3], pin.log3(desired[:3, :3] @ actual[:3, :3].T)])
        difference: Array = whole[self.rows]
        return difference


def square_task(robot: ClosedLoopRobot, frame: str, task: Sequence[str]) -> TaskSpace:
    """Return a task space with as many coordinates as the robot has motors; raise :class:`InvalidValue` if they are more or fewer."""
    space = TaskSpace(robot, frame, task)
    if len(space.task) != len(robot.actuated):
        raise InvalidValue("task", space.task, f"as many coordinates as the robot has motors, {len(robot.actuated)}")
    return space
