"""Motion of a point or a frame of a robot: placement, velocity and acceleration."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from psp3.checks import Array, checked_robot, finite_rows, together
from psp3.multibody.named_frames import frame_number
from psp3.robots.closed_loop_robot import ClosedLoopRobot


class FrameMotion(NamedTuple):
    """Motion of a frame in base axes.

    ``placement`` (..., 4, 4) is a homogeneous transform: rotation and position [m]. ``velocity``
    (..., 6) is that of the origin [m/s], then the angular velocity [rad/s]. ``acceleration`` (...,
    6) is that of the origin [m/s²], then the angular acceleration [rad/s²].
    """

    placement: Array
    velocity: Array
    acceleration: Array


def point_motion(
    position: ArrayLike,
    velocity: ArrayLike = (0.0, 0.0, 0.0),
    acceleration: ArrayLike = (0.0, 0.0, 0.0),
) -> FrameMotion:
    """Return the motion of a frame that does not rotate.

    It can be the desired motion of a tool whose orientation does not matter.

    Parameters
    ----------
    position, velocity, acceleration : (..., 3) array_like
        Motion of the origin in base axes [m], [m/s], [m/s²]; at rest by default.

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
    return FrameMotion(
        placement, np.concatenate([v, still], axis=-1), np.concatenate([w, still], axis=-1)
    )


def frame_motion(
    robot: ClosedLoopRobot,
    positions: ArrayLike,
    speeds: ArrayLike,
    accelerations: ArrayLike,
    frame: str = "tip",
) -> FrameMotion:
    r"""Return the motion of a frame for a motion of the actuated joints.

    It is :math:`\dot x = J \dot a` and :math:`\ddot x = J \ddot a + \dot J \dot a`.

    Parameters
    ----------
    robot : ClosedLoopRobot
        The robot.
    positions, speeds, accelerations : (..., n) array_like
        Motion of the coordinates, which usually are the actuated joints [m or rad, per s, per s²];
        positions (..., p).
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
        If a pose is unreachable, or the actuated joints do not determine the others there.
    """
    checked_robot(robot)
    index, n = frame_number(robot.model, frame), len(robot.coordinates_v)
    a, v, w = together(
        positions=finite_rows("positions", positions, len(robot.reference)),
        speeds=finite_rows("speeds", speeds, n),
        accelerations=finite_rows("accelerations", accelerations, n),
    )
    rows = [
        motion_and_jacobian(robot, index, *row)[0]
        for row in zip(*(values.reshape(-1, values.shape[-1]) for values in (a, v, w)), strict=True)
    ]
    shapes = (4, 4), (6,), (6,)
    return FrameMotion(
        *(
            np.reshape([row[k] for row in rows], (*a.shape[:-1], *shape))
            for k, shape in enumerate(shapes)
        )
    )


def motion_and_jacobian(
    robot: ClosedLoopRobot, index: int, position: Array, speed: Array, acceleration: Array
) -> tuple[FrameMotion, Array]:
    """Return the motion of a frame, and its Jacobian (6, n), for one row of each argument."""
    model, data, base = robot.model, robot.data, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
    closure = robot.closure(position)
    q, v = closure.configuration, closure.complement @ speed
    pin.forwardKinematics(model, data, q, v, closure.complement @ acceleration + robot.drift(q, v))
    motion = FrameMotion(
        pin.updateFramePlacement(model, data, index).homogeneous,
        pin.getFrameVelocity(model, data, index, base).vector,
        # The classical acceleration is the second derivative of the origin's position. The spatial
        # acceleration lacks the centripetal part.
        pin.getFrameClassicalAcceleration(model, data, index, base).vector,
    )
    # For a model with a single degree of freedom Pinocchio returns a vector.
    whole = pin.computeFrameJacobian(model, data, q, index, base).reshape(6, model.nv)
    return motion, np.asarray(whole @ closure.complement)
