r"""Linear-quadratic regulators: the feedback of least cost, about a pose or along a trajectory.

For a system :math:`\delta\dot x = A\, \delta x + B\, \delta u` the feedback
:math:`\delta u = -K\, \delta x` that minimizes

.. math::

    \int \big( \delta x^T Q\, \delta x + \delta u^T R\, \delta u \big)\, dt, \qquad
    \text{or, sampled,} \quad
    \sum_k \big( \delta x_k^T Q\, \delta x_k + \delta u_k^T R\, \delta u_k \big),

follows from a Riccati equation, and the least cost from :math:`\delta x` on is :math:`\delta x^T
P\, \delta x` (B. D. O. Anderson and J. B. Moore, Optimal Control: Linear Quadratic Methods, 1990,
chapters 2 and 3).
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fuzzy2.support.described import Described
from psp3.checks import (
    Array,
    as_floats,
    check_periods,
    checked_function,
    checked_positive,
    checked_robot,
    one_row,
    overflow_refused,
)
from psp3.control import kernels, linear_quadratic_kernels
from psp3.control.controller import SaysNothing, Widths, widths_of
from psp3.dynamics.dynamics_model import ForcesOfMotions
from psp3.dynamics.linearization import LinearSystem, checked_matrices, discretize, linearize
from psp3.errors import InvalidArray, InvalidValue, NoStabilizingSolution
from psp3.multibody.core import Tables
from psp3.robots.closed_loop_robot import ClosedLoopRobot
from psp3.trajectories.motion import Motion, motion_at
from psp3.trajectories.trajectory import Trajectory

MOST_PERIODS = 10**6
"""Most samples of a trajectory; each has a matrix of gains."""

SIZES = "the sizes of weights, inertia and period"
"""Arguments that can make numbers overflow in a Riccati equation."""


class Regulator(NamedTuple):
    """Gains ``K`` (..., n, m), cost ``P`` (..., m, m), and the closed loop's ``poles`` (..., m).

    The poles are the eigenvalues of A − BK.

    They are in 1/s for a continuous system, and factors per period for a sampled one.
    """

    K: Array
    P: Array
    poles: NDArray[np.complex128]


class TimeVaryingRegulator(NamedTuple):
    """Gains ``K`` (N, n, m) of N samples, and the cost ``P`` (N + 1, m, m) from each of them on.

    The last P is the final weight.
    """

    K: Array
    P: Array


def lqr(system: LinearSystem, Q: ArrayLike, R: ArrayLike) -> Regulator:
    r"""Return the linear-quadratic regulator for an infinite time.

    The gains come from the algebraic Riccati equation.

    .. math::

        \text{continuous:} \quad & A^T P + P A - P B R^{-1} B^T P + Q = 0, & K &= R^{-1} B^T P, \\
        \text{sampled:} \quad & A^T P A - A^T P B K + Q = P, & K &= (R + B^T P B)^{-1} B^T P A

    Parameters
    ----------
    system : LinearSystem
        A (..., m, m) and B (..., m, n), continuous or sampled, from
        :func:`psp3.dynamics.linearization.linearize` for instance.
    Q : (m, m) array_like
        Weight of the state, symmetric and positive semidefinite. Bryson's rule makes entries of
        different units comparable: ``numpy.diag(1.0 / largest**2)``, with the largest acceptable
        errors.
    R : (n, n) array_like
        Weight of the input, symmetric and positive definite.

    Returns
    -------
    Regulator
        ``.K .P .poles``.

    Raises
    ------
    InvalidArray
        If the matrices are not finite or their shapes do not match.
    InvalidValue
        If a weight is not symmetric, or lacks the required definiteness.
    NoStabilizingSolution
        If no feedback of finite cost makes the system stable.
    """
    from scipy.linalg import solve_continuous_are, solve_discrete_are

    A, B = checked_matrices(system)
    m, n = B.shape[-2:]
    Q, R = _weight("Q", Q, m), _weight("R", R, n, definite=True)
    K, P = np.empty((*A.shape[:-2], n, m)), np.empty(A.shape)
    solve = solve_continuous_are if system.period is None else solve_discrete_are
    with overflow_refused(SIZES):
        for row in np.ndindex(A.shape[:-2]):
            try:
                P[row] = solve(A[row], B[row], Q, R)
            except (np.linalg.LinAlgError, ValueError) as error:
                raise NoStabilizingSolution(
                    np.linalg.eigvals(A[row]).astype(complex), system.period
                ) from error
            K[row] = (
                np.linalg.solve(R, B[row].T @ P[row])
                if system.period is None
                else _gain(A[row], B[row], R, P[row])
            )
        poles = np.linalg.eigvals(A - B @ K).astype(complex)
    unstable = ~(poles.real < 0.0 if system.period is None else np.abs(poles) < 1.0)
    if unstable.any():
        raise NoStabilizingSolution(poles[unstable.any(axis=-1)][0], system.period)
    return Regulator(K, P, poles)


def time_varying_lqr(
    system: LinearSystem, Q: ArrayLike, R: ArrayLike, terminal: ArrayLike | None = None
) -> TimeVaryingRegulator:
    r"""Return the linear-quadratic regulator of a time-varying sampled system.

    The gains come from a recursion that starts at the end.

    .. math::

        K_k = (R + B_k^T P_{k+1} B_k)^{-1} B_k^T P_{k+1} A_k, \qquad
        P_k = Q + K_k^T R K_k + (A_k - B_k K_k)^T P_{k+1} (A_k - B_k K_k)

    Parameters
    ----------
    system : LinearSystem
        A (N, m, m) and B (N, m, n) of N periods, sampled.
    Q, R
        See :func:`lqr`.
    terminal : (m, m) array_like, optional
        Weight of the state after the last period; by default the cost of continuing for an infinite
        time with the last A and B.

    Returns
    -------
    TimeVaryingRegulator
        ``.K .P``.

    Raises
    ------
    InvalidArray, InvalidValue, NoStabilizingSolution
        See :func:`lqr`; also if the system is not sampled.
    """
    A, B = checked_matrices(system)
    if A.ndim != 3 or not len(A):
        raise InvalidArray("A", "(N, m, m) with N of at least 1", A)
    if system.period is None:
        raise InvalidValue(
            "system", "continuous", "sampled, see psp3.dynamics.linearization.discretize"
        )
    m, n = B.shape[-2:]
    Q, R = _weight("Q", Q, m), _weight("R", R, n, definite=True)
    K, P = np.empty((len(A), n, m)), np.empty((len(A) + 1, m, m))
    P[-1] = (
        lqr(LinearSystem(A[-1], B[-1], system.period), Q, R).P
        if terminal is None
        else _weight("terminal", terminal, m)
    )
    with overflow_refused(SIZES):
        for k in reversed(range(len(A))):
            K[k] = _gain(A[k], B[k], R, P[k + 1])
            closed = A[k] - B[k] @ K[k]
            # This form of the equation keeps P symmetric and positive in spite of rounding errors.
            P[k] = Q + K[k].T @ R @ K[k] + closed.T @ P[k + 1] @ closed
    return TimeVaryingRegulator(K, P)


def _gain(A: Array, B: Array, R: Array, P: Array) -> Array:
    return np.asarray(np.linalg.solve(R + B.T @ P @ B, B.T @ P @ A), dtype=np.float64)


def _weight(name: str, values: ArrayLike, width: int, definite: bool = False) -> Array:
    """Return a symmetric matrix (width, width) that is positive definite or semidefinite."""
    matrix = as_floats(name, values, f"({width}, {width})")
    if matrix.shape != (width, width) or not np.isfinite(matrix).all():
        raise InvalidArray(name, f"({width}, {width})", values)
    size = np.abs(matrix).max(initial=0.0)
    if np.abs(matrix - matrix.T).max(initial=0.0) > 1e-12 * size:
        raise InvalidValue(name, matrix.tolist(), "symmetric")
    least = np.linalg.eigvalsh(matrix).min(initial=np.inf)
    if definite and not least > 0.0:
        raise InvalidValue(name, matrix.tolist(), "positive definite")
    if least < -1e-12 * size:
        raise InvalidValue(name, matrix.tolist(), "positive semidefinite")
    symmetric: Array = 0.5 * (matrix + matrix.T)
    return symmetric


class LinearQuadraticRegulator(Described, SaysNothing):
    r"""Forces of the desired motion plus a regulator designed at one pose.

    It is the linear-quadratic regulator on the errors of position and speed.

    .. math::

        \tau = M(a_d)\, \ddot a_d + C(a_d, \dot a_d)\, \dot a_d + G(a_d)
        + K \begin{bmatrix} e \\ \dot e \end{bmatrix}

    While the desired motion is at rest, the first three terms are the weight. The gains are those
    of the sampled system, because the force is held for a period.

    If a robot's coordinates are not its motors, the feedback is a force along each of the k
    coordinates that the motors command. If other coordinates are free, K also returns them to the
    pose about which the robot is linearized, which should be an equilibrium.

    Parameters
    ----------
    robot : ClosedLoopRobot
        The robot that is the controller's model.
    Q : (2n, 2n) array_like
        Weight of the errors, positions first, see :func:`lqr`.
    R : (k, k) array_like
        Weight of the forces.
    period : float
        Control period [s].
    positions : (n,) array_like, optional
        Pose about which the robot is linearized [m or rad]; its reference pose by default.

    Raises
    ------
    InvalidArray, InvalidValue, NoStabilizingSolution
        See :func:`lqr`; also for a robot with a floating base, or with motors that act along
        coordinates that they do not command.
    """

    def __init__(
        self,
        robot: ClosedLoopRobot,
        Q: ArrayLike,
        R: ArrayLike,
        period: float = 0.002,
        positions: ArrayLike | None = None,
    ) -> None:
        checked_robot(robot)
        if len(robot.reference) != len(robot.coordinates_v):
            raise InvalidValue(
                "robot",
                robot.title,
                f"one without a floating base, not with {robot.coordinates[-1]}, whose positions "
                "are more than its speeds; close it to the world with closures=[...], or use "
                "ComputedTorque",
            )
        pose = (
            robot.reference
            if positions is None
            else one_row("positions", positions, len(robot.reference))
        )
        self.robot, self._forces_of, self._pose = robot, ForcesOfMotions(robot), pose
        self.system = discretize(_commanded(robot, linearize(robot, pose), pose), period)
        self.regulator = lqr(self.system, Q, R)

    def _facts(self) -> dict[str, Any]:
        return {"robot": self.robot, "gain": self.regulator.K}

    def reset(self) -> None:
        """Forget the pose of the last call, which affects only rounding."""
        self._forces_of.forget()

    def torque(self, t: float, positions: Array, speeds: Array, desired: Motion) -> Array:
        """Return the forces of the desired motion and of the feedback, of shape (n,) [N or N m]."""
        K, k, n = self.regulator.K, len(desired.positions), len(speeds)
        if k < n:
            at, rest = np.concatenate([desired.positions, self._pose[k:]]), np.zeros(n - k)
            rates = np.concatenate([desired.speeds, rest])
            desired = desired._replace(positions=at, speeds=rates)
        return _forces(self.robot, self._forces_of, K, positions, speeds, desired)

    def table(self, robot: Any, widths: Widths) -> NamedTuple | None:
        """Return the controller's table for the compiled loop, or None, see :func:`steer`."""
        if type(self) is not LinearQuadraticRegulator:
            return None
        return _table(self.robot, self.regulator.K, widths, 1.0, self._pose)


class TimeVaryingLinearQuadraticRegulator(Described, SaysNothing):
    r"""Forces of the desired motion plus a regulator designed along it.

    It is the linear-quadratic regulator on the errors of position and speed.

    It differs from :class:`LinearQuadraticRegulator` in its gains :math:`K(t)`, which come from the
    robot's linearization at every control period of the trajectory. After its end the last gains
    stay.

    Parameters
    ----------
    robot : ClosedLoopRobot
        The robot that is the controller's model.
    trajectory : Trajectory
        The desired motion.
    duration : float
        Duration of the gains [s].
    Q, R, period
        See :class:`LinearQuadraticRegulator`.
    terminal : (2n, 2n) array_like, optional
        Weight of the errors at the end, see :func:`time_varying_lqr`.

    Attributes
    ----------
    t : (N,) ndarray
        Times of the control periods [s].
    system : LinearSystem
        The robot's sampled linearization at these times.
    regulator : TimeVaryingRegulator
        The gains at these times.

    Raises
    ------
    InvalidArray, InvalidValue, NoStabilizingSolution
        See :func:`lqr`.
    """

    def __init__(
        self,
        robot: ClosedLoopRobot,
        trajectory: Trajectory,
        duration: float,
        Q: ArrayLike,
        R: ArrayLike,
        period: float = 0.002,
        terminal: ArrayLike | None = None,
    ) -> None:
        checked_robot(robot)
        checked_function("trajectory", trajectory)
        if robot.commanded < len(robot.coordinates_v):
            others = robot.coordinates[robot.commanded :]
            raise InvalidValue(
                "robot",
                robot.title,
                f"one whose motors command all coordinates, not one that lets {', '.join(others)} "
                "follow; LinearQuadraticRegulator takes free coordinates about an equilibrium",
            )
        self.robot, self.period = robot, checked_positive("period", period)
        self._forces_of = ForcesOfMotions(robot)
        duration = checked_positive("duration", duration)
        check_periods(duration, self.period, MOST_PERIODS)
        self.t = self.period * np.arange(int(duration / self.period + 1e-9) + 1)
        motion = motion_at(trajectory, self.t, robot.commanded)
        self.system = discretize(
            linearize(robot, motion.positions, motion.speeds, motion.accelerations), self.period
        )
        self.regulator = time_varying_lqr(self.system, Q, R, terminal)

    def _facts(self) -> dict[str, Any]:
        return {
            "robot": self.robot,
            "duration": f"{self.t[-1]:g} s",
            "period": f"{self.period:g} s",
            "gains": self.regulator.K,
        }

    def reset(self) -> None:
        """Forget the pose of the last call, which affects only rounding."""
        self._forces_of.forget()

    def torque(self, t: float, positions: Array, speeds: Array, desired: Motion) -> Array:
        """Return the forces of the desired motion and of the feedback, of shape (n,) [N or N m]."""
        # The small excess selects the right sample's gains in spite of rounding.
        sample = min(max(int(t / self.period + 1e-6), 0), len(self.t) - 1)
        K = self.regulator.K[sample]
        return _forces(self.robot, self._forces_of, K, positions, speeds, desired)

    def table(self, robot: Any, widths: Widths) -> NamedTuple | None:
        """Return the controller's table for the compiled loop, or None, see :func:`steer`."""
        if type(self) is not TimeVaryingLinearQuadraticRegulator:
            return None
        # After the last period its gains stay.
        gains = self.regulator.K[: len(self.t)]
        return _table(self.robot, gains, widths, self.period, self.robot.reference)


def _forces(
    robot: ClosedLoopRobot,
    forces_of: ForcesOfMotions,
    K: Array,
    positions: Array,
    speeds: Array,
    desired: Motion,
) -> Array:
    error = np.concatenate([desired.positions - positions, desired.speeds - speeds])
    feedback: Array = K @ error
    if robot.drives_coordinates:
        forces: Array = forces_of(desired.positions, desired.speeds, desired.accelerations)
        return forces + feedback
    if len(feedback) == len(speeds):
        # Distributed to the motors in their present pose, not in the desired one.
        feedback += robot.inverse_dynamics(*desired[:3])
        return robot.allocated_forces(positions, feedback)
    motors = forces_of(desired.positions, desired.speeds, desired.accelerations)
    return np.asarray(motors + robot.allocated_forces(positions, feedback))


def _commanded(robot: ClosedLoopRobot, system: LinearSystem, pose: Array) -> LinearSystem:
    """Return a linearization whose inputs are forces along the commanded coordinates only."""
    k = robot.commanded
    if robot.actuation_matrix(pose)[k:].any():
        raise InvalidValue(
            "robot",
            robot.title,
            f"one whose motors do not act along {', '.join(robot.coordinates[k:])}, which they do "
            "not command; choose their joints with coordinates=[...]",
        )
    return LinearSystem(system.A, system.B[..., :k])


def _table(
    robot: ClosedLoopRobot, K: Array, widths: Widths, period: float, pose: Array
) -> NamedTuple | None:
    table = robot.compiled_table()
    if table is None or widths_of(robot) != widths:
        return None
    if robot.drives_coordinates:
        kp, kv = K[..., : widths.motors], K[..., widths.motors :]
        return kernels.classical(kernels.FEED_FORWARD, kp, kv, table, widths, gain_period=period)
    # The core's own forces are along the coordinates, before they are distributed to motors.
    is_shared = widths.commanded == widths.speeds
    model: Any = Tables(*table[:3]) if is_shared else table
    return linear_quadratic_kernels.regulation(K, period, pose, model, table, widths)
