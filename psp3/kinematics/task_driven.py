r"""A robot driven at one of its frames.

The inverse kinematics of any robot with loops is computed as the forward kinematics of another.

A massless chain is added to the base: three sliders and, if the task has angles, three hinges. A
closure joins its last joint to the frame. The added joints that belong to the task are actuated,
and the motors become ordinary joints. The result is a robot with loops: its configurations follow
from the task's coordinates by Newton's method with continuation, in one assembly mode, which is one
*working mode* of the original robot. It is singular if the end effector of the original robot is
singular (see :mod:`psp3.kinematics.singularities`), but not at singularities of actuation. Its mass
matrix is the original robot's inertia at the frame, :math:`J^{-T} M J^{-1}`.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from psp3.checks import Array, finite_rows
from psp3.errors import InvalidValue, MobilityMismatch
from psp3.kinematics.tasks import checked_frame, checked_motors, checked_task, equations_of
from psp3.multibody.named_frames import frame_number
from psp3.robots.closed_loop_robot import ClosedLoopRobot

_JOINTS = {
    "x": pin.JointModelPX,
    "y": pin.JointModelPY,
    "z": pin.JointModelPZ,
    "rx": pin.JointModelRX,
    "ry": pin.JointModelRY,
    "rz": pin.JointModelRZ,
}


def without_limits(model: pin.Model) -> pin.Model:
    """Return a copy of a model whose joints have no position limits."""
    free = model.copy()
    free.lowerPositionLimit = np.full(model.nq, -np.inf)
    free.upperPositionLimit = np.full(model.nq, np.inf)
    return free


class TaskDrivenRobot(ClosedLoopRobot):
    """A robot that is actuated in the coordinates of a task, and whose joints have no limits.

    Parameters
    ----------
    robot : ClosedLoopRobot
        The robot.
    frame : str
        Name of the frame that does the task.
    task : sequence of str
        As many coordinates as the robot's motors command: ``x``, ``y``, ``z``, the position of the
        frame in base axes [m], and ``rx``, ``ry``, ``rz``, angles [rad] by which the frame is
        rotated from its orientation in the robot's reference configuration, about the fixed base
        axes, x first, then y, then z. Coordinates that are not named are free. The rotation about a
        free axis comes last, unless only one angle is named, which then comes last.

    Attributes
    ----------
    robot, frame, task
        As given. The actuated joints are ``task_x`` and so on; configurations hold those of
        ``robot`` first.

    Raises
    ------
    UnknownName
        If the robot has no such frame, or there is no such coordinate.
    InvalidValue
        If the number of task coordinates is not that of the coordinates that the robot's motors
        command, they do not determine the pose, or some of the robot's coordinates follow its
        motors.
    ClosureFailed, SingularConfiguration
        If the reference configuration is a singularity of the frame.
    """

    def __init__(self, robot: ClosedLoopRobot, frame: str, task: Sequence[str]) -> None:
        self.robot, self.frame = checked_motors(robot), checked_frame(robot, frame)
        self.task = checked_task(task)
        if len(self.task) != robot.commanded:
            raise InvalidValue(
                "task",
                self.task,
                f"as many coordinates as the robot's motors command, {robot.commanded}",
            )
        at_reference = self._placement(robot.q0)
        self._orientation, self._turns = at_reference.rotation.copy(), _turns(self.task)
        model, last = without_limits(robot.model), 0
        for name in ("x", "y", "z", *self._turns):
            last = model.addJoint(last, _JOINTS[name](), pin.SE3.Identity(), f"task_{name}")
        closures = [
            pin.RigidConstraintModel(
                one.type,
                model,
                one.joint1_id,
                one.joint1_placement,
                one.joint2_id,
                one.joint2_placement,
                pin.ReferenceFrame.LOCAL,
            )
            for one in robot.constraint_models
        ]
        end = robot.model.frames[frame_number(robot.model, frame)]
        kind = pin.ContactType.CONTACT_6D if self._turns else pin.ContactType.CONTACT_3D
        sides = (last, pin.SE3(self._orientation, np.zeros(3))), (end.parentJoint, end.placement)
        closures.append(
            pin.RigidConstraintModel(kind, model, *sides[0], *sides[1], pin.ReferenceFrame.LOCAL)
        )
        try:
            super().__init__(
                model,
                closures,
                [f"task_{name}" for name in self.task],
                self.completed(robot.q0),
                equations=equations_of(robot),
                free="refuse",
            )
        except MobilityMismatch as error:
            free = ", ".join(error.mobility.free_joints)
            raise InvalidValue(
                "task",
                self.task,
                f"coordinates that determine the pose; with them held, {free} can still move",
            ) from error

    def completed(self, configurations: ArrayLike) -> Array:
        """Return the configurations of this robot that belong to given ones of the original robot.

        Parameters
        ----------
        configurations : (..., nq) array_like
            Configurations of ``robot``.

        Returns
        -------
        (..., nq + 3 or nq + 6) ndarray
            The given configurations, followed by the positions of the added joints.

        Raises
        ------
        InvalidArray
            If the configurations are not finite or of another shape.
        """
        q = finite_rows("configurations", configurations, self.robot.model.nq)
        rows = q.reshape(-1, q.shape[-1])
        out = np.concatenate([rows, np.zeros((len(rows), 3 + len(self._turns)))], axis=1)
        for whole, row in zip(out, rows, strict=True):
            here = self._placement(row)
            whole[row.size : row.size + 3] = here.translation
            if self._turns:
                whole[row.size + 3 :] = _angles(here.rotation @ self._orientation.T, self._turns)
        return out.reshape(*q.shape[:-1], out.shape[1])

    def _placement(self, q: Array) -> pin.SE3:
        model, data = self.robot.model, self.robot.data
        pin.forwardKinematics(model, data, q)
        return pin.updateFramePlacement(model, data, frame_number(model, self.frame))


def _turns(task: tuple[str, ...]) -> tuple[str, ...]:
    """Return the axes of the added hinges, from the base outward.

    The angle of the middle one must stay below 90°.
    """
    mine = [name for name in ("rz", "ry", "rx") if name in task]
    others = [name for name in ("rz", "ry", "rx") if name not in task]
    if not mine:
        return ()
    return (*mine, *others) if len(mine) == 1 else (*others, *mine)


def _angles(rotation: Array, turns: tuple[str, ...]) -> Array:
    """Return the angles of three hinges, in their order, that produce a rotation."""
    from scipy.spatial.transform import Rotation

    # Capital letters: the preceding hinges rotate each axis.
    return np.asarray(
        Rotation.from_matrix(rotation).as_euler("".join(name[1].upper() for name in turns)),
        dtype=float,
    )
