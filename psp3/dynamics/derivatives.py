r"""Analytic derivatives of inverse and forward dynamics.

They are in the actuated coordinates of any robot with loops.

The robot computes them: a :class:`psp3.ClosedLoopRobot` in the compiled core, see
:mod:`psp3.multibody.derivatives`, and ``robot.dynamics("pinocchio")`` from Pinocchio's derivatives,
see :mod:`psp3.dynamics.projected_derivatives`. The two share no code.
"""

from __future__ import annotations

from typing import NamedTuple, Protocol

from numpy.typing import ArrayLike

from psp3.checks import Array
from psp3.errors import InvalidValue


class InverseDynamicsDerivatives(NamedTuple):
    """Derivatives of the actuator forces, all (..., n, n).

    Entry (i, k) is that of force i by coordinate k.

    ``by_positions`` [N/m], ``by_speeds`` [N s/m] and ``by_accelerations``, which is the mass matrix
    [kg]; for a rotating joint, N m and rad replace N and m.
    """

    by_positions: Array
    by_speeds: Array
    by_accelerations: Array


class ForwardDynamicsDerivatives(NamedTuple):
    """Derivatives of the actuated accelerations, all (..., n, n).

    Entry (i, k) is that of acceleration i by coordinate k.

    ``by_positions`` [1/s²], ``by_speeds`` [1/s] and ``by_forces``, which is the inverse of the mass
    matrix [1/kg]; units are mixed if the robot has rotating and sliding joints.
    """

    by_positions: Array
    by_speeds: Array
    by_forces: Array


class ClosedDynamics(Protocol):
    """Interface of a tree with closed loops that has derivatives.

    A :class:`psp3.ClosedLoopRobot` is one, and so is its ``robot.dynamics("pinocchio")``.
    """

    actuated: tuple[str, ...]
    """Names of the actuated joints."""

    def inverse_dynamics_derivatives(
        self, positions: ArrayLike, speeds: ArrayLike, accelerations: ArrayLike
    ) -> InverseDynamicsDerivatives:
        """Return the derivatives of the forces of a motion (..., n)."""
        ...

    def forward_dynamics_derivatives(
        self, positions: ArrayLike, speeds: ArrayLike, forces: ArrayLike
    ) -> ForwardDynamicsDerivatives:
        """Return the derivatives of the accelerations under forces (..., n)."""
        ...


def inverse_dynamics_derivatives(
    robot: ClosedDynamics, positions: ArrayLike, speeds: ArrayLike, accelerations: ArrayLike
) -> InverseDynamicsDerivatives:
    r"""Return the derivatives of :math:`\tau(a, \dot a, \ddot a)`, the actuator forces of a motion.

    .. math::

        \delta\tau = \frac{\partial \tau}{\partial a}\, \delta a
        + \frac{\partial \tau}{\partial \dot a}\, \delta \dot a
        + M(a)\, \delta \ddot a

    Parameters
    ----------
    robot : ClosedDynamics
        Any robot, with or without loops.
    positions, speeds, accelerations : (..., n) array_like
        Motion of the actuated joints [m, m/s, m/s² or rad, rad/s, rad/s²].

    Returns
    -------
    InverseDynamicsDerivatives
        ``.by_positions .by_speeds .by_accelerations``, each (..., n, n).

    Raises
    ------
    InvalidArray, ClosureFailed, SingularConfiguration
        See :meth:`psp3.ClosedLoopRobot.configuration`.
    """
    _check_dynamics(robot, "inverse_dynamics_derivatives")
    return robot.inverse_dynamics_derivatives(positions, speeds, accelerations)


def forward_dynamics_derivatives(
    robot: ClosedDynamics, positions: ArrayLike, speeds: ArrayLike, forces: ArrayLike
) -> ForwardDynamicsDerivatives:
    r"""Return the derivatives of :math:`\ddot a(a, \dot a, \tau)`.

    They are the accelerations under given actuator forces.

    .. math::

        \frac{\partial \ddot a}{\partial \tau} = M^{-1}, \qquad
        \frac{\partial \ddot a}{\partial a} = -M^{-1} \frac{\partial \tau}{\partial a}, \qquad
        \frac{\partial \ddot a}{\partial \dot a} = -M^{-1} \frac{\partial \tau}{\partial \dot a}

    Parameters
    ----------
    robot : ClosedDynamics
        Any robot, with or without loops.
    positions, speeds, forces : (..., n) array_like
        State of the actuated joints [m, m/s or rad, rad/s] and their forces [N or N m].

    Returns
    -------
    ForwardDynamicsDerivatives
        ``.by_positions .by_speeds .by_forces``, each (..., n, n).

    Raises
    ------
    InvalidArray, ClosureFailed, SingularConfiguration
        See :meth:`psp3.ClosedLoopRobot.configuration`.
    """
    _check_dynamics(robot, "forward_dynamics_derivatives")
    return robot.forward_dynamics_derivatives(positions, speeds, forces)


def _check_dynamics(robot: object, question: str) -> None:
    """Raise :class:`InvalidValue` if an object has no such derivatives."""
    if not hasattr(robot, question):
        raise InvalidValue("robot", robot, 'a robot, as psp3.load("delta") returns it')
