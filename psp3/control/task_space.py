r"""Computed torque in the coordinates of a frame, bounded near singularities.

Where the smallest singular value :math:`\sigma` of the Jacobian vanishes, its inverse requires
infinite accelerations. For the tip of the 3-PSP this is the border of its reach, 23.9 mm from the
axis in the direction of a screw. Two measures keep the robot on this side of the singularity. Both
are exactly zero where :math:`\sigma \ge \varepsilon`:

* The inverse is damped only in the singular directions,

  .. math:: J^\# = \sum_i \frac{\sigma_i}{\sigma_i^2 + \lambda_i^2}\, v_i u_i^\top, \qquad
            \lambda_i = \varepsilon \Big[ 1 - \frac{\sigma_i^2}{\varepsilon^2} \Big]
            \text{ for } \sigma_i < \varepsilon,
            \text{ else } 0 ,

  so that :math:`\lVert J^\# \rVert \le 1.07 / \varepsilon`. :math:`\lambda^2` and its derivative
  are continuous.
* The smallest singular value is kept above a quarter of :math:`\varepsilon`. Damping alone is not
  enough: the tip reaches the fold with a speed, crosses it and runs away on the other branch. With
  :math:`z = \sigma - \varepsilon/4` and :math:`\omega = \sqrt{k_p}` the accelerations are
  corrected, if necessary, to satisfy

  .. math:: \ddot z \ge \frac{\dot z^2}{2 z} - 2 \omega \dot z - \omega^2 z \qquad (\dot z < 0) ,

  which for :math:`z = y^2` is the damped oscillator
  :math:`\ddot y + 2\omega \dot y + \tfrac12 \omega^2 y \ge 0`: whatever the speed, z does not
  become negative. The correction is the one that changes the frame's motion least, and it sets in
  smoothly between :math:`\varepsilon` and :math:`\varepsilon / 2`.

Sources: J. Luh, M. Walker and R. Paul, Resolved-acceleration control of mechanical manipulators,
IEEE Transactions on Automatic Control 25 (1980), for the law; Y. Nakamura and H. Hanafusa, Inverse
kinematic solutions with singularity robustness for robot manipulator control, Journal of Dynamic
Systems, Measurement, and Control 108 (1986), and S. Chiaverini, Singularity-robust task-priority
redundancy resolution for real-time kinematic control of robot manipulators, IEEE Transactions on
Robotics and Automation 13 (1997), for variable damping; A. Ames, S. Coogan, M. Egerstedt, G.
Notomista, K. Sreenath and P. Tabuada, Control barrier functions: theory and applications, European
Control Conference (2019), for corrections that keep a quantity positive.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from fuzzy2.support.described import Described
from psp3.checks import Array, checked_function, checked_not_negative
from psp3.closure.rank import RANK_TOLERANCE
from psp3.control.controller import SaysNothing, Widths, widths_of
from psp3.control.task_space_kernels import (
    FIRST_DIFFERENCE,
    FLOOR,
    SECOND_DIFFERENCE,
    TaskLaw,
)
from psp3.dynamics.dynamics_model import ForcesOfMotions
from psp3.errors import InvalidValue
from psp3.kinematics.frames import FrameMotion, frame_motion
from psp3.kinematics.task_space import TaskSpace, square_task
from psp3.kinematics.tasks import characteristic_length, checked_motors, rotating
from psp3.robots.closed_loop_robot import ClosedLoopRobot
from psp3.trajectories.motion import Motion


def damped_reciprocals(singular_values: ArrayLike, threshold: float) -> Array:
    r"""Return damped inverses of singular values, :math:`\sigma / (\sigma^2 + \lambda^2)`.

    :math:`\lambda = \varepsilon - \sigma^2/\varepsilon` below the threshold :math:`\varepsilon`,
    and 0 above.

    Parameters
    ----------
    singular_values : (...,) array_like
        Singular values, not negative.
    threshold : float
        :math:`\varepsilon`; at and above it there is no damping, and the result is the reciprocal.

    Returns
    -------
    (...,) ndarray
        Values of at most 1.07 over the threshold; if the threshold is 0, infinite at zero.
    """
    sigma = np.asarray(singular_values, dtype=float)
    damping = (
        np.maximum(threshold - sigma**2 / threshold, 0.0)
        if threshold > 0.0
        else np.zeros_like(sigma)
    )
    with np.errstate(divide="ignore", invalid="ignore"):
        # In this form the result is the exact reciprocal where there is no damping.
        damped: Array = np.where(damping > 0.0, sigma / (sigma**2 + damping**2), 1.0 / sigma)
    return damped


LEAST_DAMPED = 1e-12
"""Least threshold, because a smaller one is within the rounding of the singular value."""


class TaskSpaceComputedTorque(Described, SaysNothing):
    r"""Computed torque in the coordinates of a frame.

    The model turns the robot into a unit mass in the coordinates of the task.

    .. math:: \tau = M \ddot a + C \dot a + G, \qquad
              \ddot a = J^\# \big( \ddot x_d + k_v \dot e + k_p e - \dot J \dot a \big), \qquad
              e = x_d - x .

    Away from singularities the error obeys :math:`\ddot e + k_v \dot e + k_p e = 0`, whatever the
    pose; rotations about changing axes obey it to the second order of the angle. Near a singularity
    the inverse is damped, and the frame stops short of it, see :mod:`psp3.control.task_space`.

    Parameters
    ----------
    robot : ClosedLoopRobot
        The robot.
    kp, kv : float
        Gains [1/s²], [1/s], as in :class:`psp3.ComputedTorque`.
    path : callable, optional
        The desired :class:`psp3.kinematics.frames.FrameMotion` at a time [s]. By default the
        frame's path follows from the desired motion of the actuated joints. A given path may lead
        out of reach.
    frame : str
        The frame.
    task : sequence of str
        Coordinates of the frame, see :class:`psp3.kinematics.task_space.TaskSpace`; as many as the
        robot has coordinates. If there are more motors, the forces are distributed to them.
    damped_below : float
        Threshold :math:`\varepsilon`, as a share of the smallest singular value in the reference
        pose: below 1, and 0 for the plain inverse. Angles are converted to lengths with
        :func:`psp3.kinematics.tasks.characteristic_length`. For the tip of the 3-PSP the default of
        :math:`\varepsilon` is 0.047, a value that the tip reaches 0.9 mm from the border in the
        direction of a screw.

    Raises
    ------
    InvalidValue
        If a gain is negative or not finite, if the threshold is not within [0, 1), if the task does
        not have as many coordinates as the robot, if they do not determine its pose at the
        reference pose, or if some of the robot's coordinates are passive.
    UnknownName
        If the robot has no such frame, or there is no such coordinate.
    """

    def __init__(
        self,
        robot: ClosedLoopRobot,
        kp: float = 10.0,
        kv: float = 1.0,
        *,
        path: Callable[[float], FrameMotion] | None = None,
        frame: str = "tip",
        task: Sequence[str] = ("x", "y", "z"),
        damped_below: float = 0.15,
    ) -> None:
        if path is not None:
            checked_function("path", path)
        self.robot, self.path, self._forces_of = robot, path, ForcesOfMotions(robot)
        self.kp, self.kv = checked_not_negative("kp", kp), checked_not_negative("kv", kv)
        share = checked_not_negative("damped_below", damped_below)
        if share >= 1.0 or 0.0 < share < LEAST_DAMPED:
            raise InvalidValue(
                "damped_below",
                damped_below,
                f"0, or a share of the reference pose's singular value, {LEAST_DAMPED:g} or more "
                "and below 1",
            )
        self.space = square_task(checked_motors(robot), frame, task)
        self._scaled = _ScaledJacobian(self.space)
        self.threshold = share * self._scaled.at_reference
        r"""The singular value :math:`\varepsilon` below which the inverse is damped."""

    def _facts(self) -> dict[str, Any]:
        return {
            "robot": self.robot,
            "kp": self.kp,
            "kv": self.kv,
            "frame": self.space.frame,
            "task": self.space.task,
        }

    def reset(self) -> None:
        """Forget the pose of the last call, which affects only rounding."""
        self._forces_of.forget()

    def torque(self, t: float, positions: Array, speeds: Array, desired: Motion) -> Array:
        """Return the forces of the actuated joints (n,) [N or N m] for a state.

        The state is the joints' positions and speeds.
        """
        if self.path is None:
            goal = frame_motion(
                self.robot,
                desired.positions,
                desired.speeds,
                desired.accelerations,
                self.space.frame,
            )
        else:
            goal = self.path(t)
        rows, now = self.space.rows, self.space.state(positions, speeds)
        servo = goal.acceleration[rows] + self.kv * (goal.velocity[rows] - now.velocity)
        servo += self.kp * self.space.error(goal.placement, now.placement) - now.drift
        return self._forces_of(
            positions, speeds, self._accelerations(positions, speeds, now.jacobian, servo)
        )

    def table(self, robot: Any, widths: Widths) -> NamedTuple | None:
        """Return the controller's table for the compiled loop, or None, see :func:`steer`.

        A given path is a Python function, so it cannot be compiled. Kernels close the loops of any
        robot with Newton's method.
        """
        is_other = type(self) is not TaskSpaceComputedTorque
        if is_other or self.path is not None or widths_of(self.robot) != widths:
            return None
        if self.robot.compiled_table() is None:
            return None
        model: Any = self.robot.dynamics("core")
        scaled = self._scaled
        return TaskLaw(
            *(self.kp, self.kv, self.threshold, scaled.sign, scaled.length),
            model.frame_table(self.space.frame),
            *(np.array(self.space.rows), max(self.space.rows) > 2),
            *(scaled.rows, scaled.columns, model.compiled_table()),
        )

    def _accelerations(
        self, positions: Array, speeds: Array, jacobian: Array, servo: Array
    ) -> Array:
        """Return the accelerations of the actuated joints for those of ``servo``.

        The frame then has the accelerations of ``servo``, as far as possible.
        """
        scaled, epsilon = self._scaled, self.threshold
        left, sigma, right = np.linalg.svd(scaled.rows[:, np.newaxis] * jacobian / scaled.columns)
        accelerations: Array = right.T @ (
            damped_reciprocals(sigma, epsilon) * (left.T @ (scaled.rows * servo))
        )
        if sigma[-1] < epsilon:
            cost = right.T @ ((sigma**2 + epsilon**2)[:, np.newaxis] ** -1 * right)
            accelerations = accelerations + self._correction(
                positions, scaled.columns * speeds, accelerations, cost
            )
        return accelerations / scaled.columns

    def _correction(
        self, positions: Array, speeds: Array, accelerations: Array, cost: Array
    ) -> Array:
        """Return the correction that keeps the smallest singular value above its floor.

        Speeds and accelerations are scaled.
        """
        epsilon, omega = self.threshold, np.sqrt(self.kp)
        value, gradient, curvature = self._scaled.derivatives(positions, speeds)
        height, rate = value - FLOOR * epsilon, float(gradient @ speeds)
        least = -2.0 * omega * rate - omega**2 * height
        if rate < 0.0:
            # The distance is bounded, because the braking is infinite at the floor itself, which a
            # sampled controller may reach.
            least += rate**2 / (2.0 * max(height, 0.25 * FLOOR * epsilon))
        lacking = least - float(gradient @ accelerations) - curvature
        if lacking <= 0.0:
            return np.zeros_like(accelerations)
        x = float(np.clip(2.0 * (1.0 - value / epsilon), 0.0, 1.0))
        direction = cost @ gradient
        correction: Array = (
            x * x * (3.0 - 2.0 * x) * lacking / max(float(gradient @ direction), 1e-300) * direction
        )
        return correction


class _ScaledJacobian:
    """The task's dimensionless Jacobian, and a signed measure of singularity.

    The measure is the smallest singular value, with a sign that changes where it vanishes.
    """

    def __init__(self, space: TaskSpace) -> None:
        robot, self._space = space.robot, space
        self.length = characteristic_length(robot)
        self.rows = np.array([self.length if row >= 3 else 1.0 for row in space.rows])
        self.columns = np.where(rotating(robot.model)[robot.coordinates_v], self.length, 1.0)
        jacobian = self._at(robot.reference)
        values = np.linalg.svd(jacobian, compute_uv=False)
        self.at_reference, self.sign = float(values[-1]), float(np.sign(np.linalg.det(jacobian)))
        if not self.at_reference > RANK_TOLERANCE * values[0]:
            raise InvalidValue(
                "task",
                space.task,
                "coordinates that determine the pose of the robot at its reference pose",
            )

    def _at(self, positions: Array) -> Array:
        jacobian: Array = self.rows[:, np.newaxis] * self._space.jacobian(positions) / self.columns
        return jacobian

    def smallest(self, positions: Array) -> float:
        """Return the smallest singular value, with a sign.

        It is negative on the other side of the singularity than the reference pose.
        """
        jacobian = self._at(positions)
        return float(
            self.sign
            * np.sign(np.linalg.det(jacobian))
            * np.linalg.svd(jacobian, compute_uv=False)[-1]
        )

    def derivatives(self, positions: Array, speeds: Array) -> tuple[float, Array, float]:
        """Return the smallest singular value, its gradient, and second derivative in time.

        The latter is at the given scaled speeds.
        """
        step, value = FIRST_DIFFERENCE * self.length, self.smallest(positions)
        gradient = np.array(
            [
                (self.smallest(positions + unit) - self.smallest(positions - unit)) / (2.0 * step)
                for unit in np.diag(step / self.columns)
            ]
        )
        fastest = float(np.linalg.norm(speeds))
        if fastest == 0.0:
            return value, gradient, 0.0
        time = SECOND_DIFFERENCE * self.length / fastest
        way = time * speeds / self.columns
        curvature = (
            self.smallest(positions + way) - 2.0 * value + self.smallest(positions - way)
        ) / time**2
        return value, gradient, curvature
