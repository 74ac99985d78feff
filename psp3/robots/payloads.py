"""Payloads: a body that is fixed to one of a robot's frames.

The plant carries it, and the controller need not know about it.
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from psp3.checks import checked_not_negative, checked_robot, one_row
from psp3.errors import InvalidValue
from psp3.multibody.named_frames import frame_number
from psp3.robots.closed_loop_robot import ClosedLoopRobot


def with_payload(
    robot: ClosedLoopRobot, mass: float, inertia: ArrayLike = (0.0, 0.0, 0.0), frame: str = "tip"
) -> ClosedLoopRobot:
    r"""Return a robot that carries a payload, as a :class:`psp3.ClosedLoopRobot`.

    With :math:`J` the Jacobian of the frame's origin and :math:`J_\omega` that of its angular
    velocity, in base axes, and :math:`R` its rotation,

    .. math:: M' = M + m J^T J + J_\omega^T R I R^T J_\omega, \qquad V' = V + m g z,

    and C and G follow. In the closed form of the 3-PSP, a payload at the star's center is part of
    ``star_mass`` and ``star_inertia`` of :class:`psp3.Parameters`.

    Parameters
    ----------
    robot : ClosedLoopRobot
        The robot, which is not changed.
    mass : float
        Mass m of the payload, at the frame's origin [kg].
    inertia : (3,) array_like
        Its moments of inertia I about the frame's origin, along the frame's axes [kg m²].
    frame : str
        The frame to which it is fixed.

    Returns
    -------
    ClosedLoopRobot
        The robot for a plant: ``RungeKutta(with_payload(robot, 2.0))``.

    Raises
    ------
    UnknownName
        If the robot has no such frame.
    InvalidValue
        If the mass is negative or not finite, no rigid body has these moments, or the frame is
        fixed to the base.
    InvalidArray
        If the moments are not three finite numbers.
    """
    checked_robot(robot)
    mass, moments = checked_not_negative("mass", mass), one_row("inertia", inertia, 3)
    if (moments < 0.0).any() or 2.0 * moments.max() > moments.sum() * (1.0 + 1e-12):
        raise InvalidValue(
            "inertia",
            moments.tolist(),
            "moments of a rigid body: none negative, none above the sum of the other two",
        )
    model = robot.model.copy()
    place = model.frames[frame_number(model, frame)]
    if place.parentJoint == 0:
        raise InvalidValue("frame", frame, "one that moves; this one is fixed to the base")
    model.appendBodyToJoint(
        place.parentJoint, pin.Inertia(mass, np.zeros(3), np.diag(moments)), place.placement
    )
    return ClosedLoopRobot(
        model,
        robot.constraint_models,
        robot.actuated,
        robot.q0,
        robot.visual_model,
        **robot.options,
    )
