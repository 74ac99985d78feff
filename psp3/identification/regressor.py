r"""Actuator forces are linear in masses, first moments and inertias.

This module has the regressor of a robot with loops, in its actuated coordinates.

The inverse dynamics of the tree is :math:`Y_\text{tree}(q, \dot q, \ddot q)\, \theta` (C. G.
Atkeson, C. H. An and J. M. Hollerbach, Estimation of inertial parameters of manipulator loads and
links, The International Journal of Robotics Research, 1986), and the loops project it in the same
way as forces: :math:`Y = L^T Y_\text{tree}`.
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from psp3.checks import Array, checked_robot, finite_rows, together
from psp3.robots.closed_loop_robot import ClosedLoopRobot

PARAMETERS_OF_A_BODY = ("m", "mx", "my", "mz", "Ixx", "Ixy", "Iyy", "Ixz", "Iyz", "Izz")
"""Standard parameters of a body in Pinocchio's order: mass [kg], first moments [kg m] and inertia
about the joint's origin [kg m²], both in the joint's axes.
"""


def regressor(
    robot: ClosedLoopRobot, positions: ArrayLike, speeds: ArrayLike, accelerations: ArrayLike
) -> Array:
    r"""Return the matrix that maps standard parameters to actuator forces.

    .. math::

        \tau = Y(a, \dot a, \ddot a)\, \theta, \qquad
        Y = L^T Y_\text{tree}(q, \dot q, \ddot q), \qquad
        \dot q = L\, \dot a, \quad \ddot q = L\, \ddot a + \dot L\, \dot a

    Parameters
    ----------
    robot : ClosedLoopRobot
        Any robot, with or without loops. Its masses and inertias do not matter, but its gravity
        does.
    positions, speeds, accelerations : (..., n) array_like
        Motion of the actuated joints [m, m/s, m/s² or rad, rad/s, rad/s²].

    Returns
    -------
    (..., n, 10 B) ndarray
        Columns in the order of :func:`standard_parameters`, for the B bodies of the tree.

    Raises
    ------
    InvalidArray, ClosureFailed, JointLimitExceeded, SingularConfiguration
        See :meth:`psp3.ClosedLoopRobot.configuration`.
    """
    checked_robot(robot)
    n = len(robot.actuated)
    a, v, w = together(
        positions=finite_rows("positions", positions, n),
        speeds=finite_rows("speeds", speeds, n),
        accelerations=finite_rows("accelerations", accelerations, n),
    )
    out = np.empty((*a.shape, 10 * (robot.model.njoints - 1)))
    for row in np.ndindex(a.shape[:-1]):
        closure = robot.closure(a[row])
        q, L = closure.configuration, closure.complement
        velocities = L @ v[row]
        accelerations_of_joints = L @ w[row] + robot.drift(q, velocities)
        out[row] = L.T @ pin.computeJointTorqueRegressor(
            robot.model, robot.data, q, velocities, accelerations_of_joints
        )
    return out


def standard_parameters(robot: ClosedLoopRobot) -> Array:
    """Return the ten parameters of every body of a robot's tree, (10 B,).

    They are listed body by body, in the order of :data:`PARAMETERS_OF_A_BODY`.

    There is one body per joint, so bodies are in the order of the model's joints.
    """
    checked_robot(robot)
    inertias = list(robot.model.inertias)[1:]
    return np.concatenate([np.zeros(0), *(inertia.toDynamicParameters() for inertia in inertias)])


def parameter_names(robot: ClosedLoopRobot) -> tuple[str, ...]:
    """Return the names of :func:`standard_parameters`.

    ``m(a1)`` is the mass of the body that moves with joint ``a1``.
    """
    checked_robot(robot)
    return tuple(
        f"{parameter}({joint})"
        for joint in list(robot.model.names)[1:]
        for parameter in PARAMETERS_OF_A_BODY
    )
