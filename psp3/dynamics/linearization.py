r"""Linear systems that approximate a robot: about a pose, about a state, or along a motion.

The state is :math:`x = (a, \dot a)`, the actuated positions and speeds, and the input :math:`u =
\tau`, the actuator forces. Small deviations from a motion obey :math:`\delta\dot x = A\, \delta x +
B\, \delta u`, or, with forces that are constant during a period, :math:`\delta x_{k+1} = A_d\,
\delta x_k + B_d\, \delta u_k`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from psp3.checks import Array, as_floats, checked_kind, checked_positive, finite_array
from psp3.dynamics.derivatives import ClosedDynamics, inverse_dynamics_derivatives
from psp3.errors import InvalidArray, InvalidValue


class LinearSystem(NamedTuple):
    """A linear system, continuous or sampled.

    ``A`` (..., m, m), ``B`` (..., m, n), and ``period`` [s], which is None for a continuous system.

    For a robot, m = 2n: positions first, then speeds.
    """

    A: Array
    B: Array
    period: float | None = None


def linearize(
    robot: ClosedDynamics,
    positions: ArrayLike,
    speeds: ArrayLike | None = None,
    accelerations: ArrayLike | None = None,
) -> LinearSystem:
    r"""Return the linearization of a robot about given motions.

    .. math::

        A = \begin{bmatrix}
              0 & 1 \\ -M^{-1}\, \partial\tau/\partial a & -M^{-1}\, \partial\tau/\partial\dot a
            \end{bmatrix}, \qquad
        B = \begin{bmatrix} 0 \\ M^{-1} \end{bmatrix}

    The reference forces are those of the motion, ``robot.inverse_dynamics``; at rest they carry the
    weight.

    Parameters
    ----------
    robot : ClosedDynamics
        Any robot, with or without loops.
    positions : (..., n) array_like
        Actuated positions [m or rad]. The rows of a motion along a trajectory give a system for
        each time.
    speeds, accelerations : (..., n) array_like, optional
        Their rates; at rest by default.

    Returns
    -------
    LinearSystem
        ``.A`` (..., 2n, 2n) and ``.B`` (..., 2n, n), continuous. If the coordinates of the robot
        are not its motors, the input is the forces along the coordinates.

    Raises
    ------
    InvalidArray, ClosureFailed, SingularConfiguration
        See :meth:`psp3.ClosedLoopRobot.configuration`.
    """
    row = finite_array("positions", positions)
    rest = np.zeros(row.shape[-1:])
    by_positions, by_speeds, mass = inverse_dynamics_derivatives(
        robot,
        row,
        rest if speeds is None else speeds,
        rest if accelerations is None else accelerations,
    )
    n = mass.shape[-1]
    A, B = np.zeros((*mass.shape[:-2], 2 * n, 2 * n)), np.zeros((*mass.shape[:-2], 2 * n, n))
    A[..., :n, n:] = np.eye(n)
    A[..., n:, :n] = -np.linalg.solve(mass, by_positions)
    A[..., n:, n:] = -np.linalg.solve(mass, by_speeds)
    B[..., n:, :] = np.linalg.inv(mass)
    return LinearSystem(A, B)


def discretize(system: LinearSystem, period: float) -> LinearSystem:
    r"""Return the sampled form of a continuous system without approximation.

    The input is constant during each period.

    .. math::

        \begin{bmatrix} A_d & B_d \\ 0 & 1 \end{bmatrix}
        = \exp\left( \begin{bmatrix} A & B \\ 0 & 0 \end{bmatrix} T \right)

    Along a trajectory every A and B is constant during its period.

    Parameters
    ----------
    system : LinearSystem
        A continuous system.
    period : float
        Time T between two samples [s].

    Returns
    -------
    LinearSystem
        The sampled system, with the same shapes.

    Raises
    ------
    InvalidValue
        If the period is not positive, or the system is already sampled.
    InvalidArray
        If A and B are not finite, or their shapes do not match.

    References
    ----------
    C. Van Loan, Computing integrals involving the matrix exponential, IEEE Transactions on
    Automatic Control 23(3), 1978.
    """
    from scipy.linalg import expm

    A, B = checked_matrices(system)
    period = checked_positive("period", period)
    if system.period is not None:
        raise InvalidValue("system", f"sampled every {system.period} s", "continuous")
    m, n = B.shape[-2:]
    block = np.zeros((*A.shape[:-2], m + n, m + n))
    block[..., :m, :m], block[..., :m, m:] = period * A, period * B
    with np.errstate(over="ignore", invalid="ignore"):
        whole = expm(block)
    if not np.isfinite(whole).all():
        raise InvalidValue("period", period, "short enough for a finite result")
    return LinearSystem(whole[..., :m, :m], whole[..., :m, m:], period)


def checked_matrices(system: LinearSystem) -> tuple[Array, Array]:
    """Return A (..., m, m) and B (..., m, n) as float arrays.

    Raise :class:`InvalidArray` if they do not make a linear system.
    """
    checked_kind("system", system, LinearSystem, "a LinearSystem, as psp3.linearize returns it")
    A, B = as_floats("A", system.A, "(..., m, m)"), as_floats("B", system.B, "(..., m, n)")
    if A.ndim < 2 or A.shape[-2] != A.shape[-1] or not np.isfinite(A).all():
        raise InvalidArray("A", "(..., m, m)", system.A)
    if B.ndim != A.ndim or B.shape[:-1] != A.shape[:-1] or not np.isfinite(B).all():
        raise InvalidArray("B", str((*A.shape[:-1], "n")).replace("'", ""), system.B)
    return A, B
