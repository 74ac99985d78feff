r"""Controllers of the screw forces: feed-forward, PD, PD with gravity, PID and computed torque.

A controller has ``reset()``, called once before a run, and ``torque(t, positions, speeds,
desired)``, called once a control period. Any object with these two methods can be simulated.
``desired`` is a :class:`psp3.trajectories.motion.Motion`; the servo errors are :math:`e = a_d - a`
and :math:`\dot e = \dot a_d - \dot a` (eq. 4.2).

If a robot's coordinates are not its motors, motion and errors are those of the first coordinates,
which the motors command, and the others are passive. A model then computes the motors' forces. With
more motors than coordinates these are the forces of least norm. With free coordinates, the
commanded ones get the servo's accelerations, whatever the others do (partial feedback
linearization, :meth:`psp3.ClosedLoopRobot.actuator_forces`).
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from fuzzy2.support.described import Described
from psp3.checks import Array, as_floats, checked_not_negative, checked_positive
from psp3.control import kernels
from psp3.control.controller import SaysNothing, Stateless, Widths, widths_of
from psp3.dynamics.dynamics_model import DynamicsModel, ForcesOfMotions, checked_model
from psp3.errors import InvalidArray
from psp3.trajectories.motion import Motion


def critically_damped_gains(bandwidth: float, mass: float | ArrayLike = 1.0) -> tuple[Any, Any]:
    r"""Return the gains of a critically damped loop with a given bandwidth.

    .. math:: k_p = \omega^2 M, \qquad k_v = 2 \omega M, \qquad
              \omega = \frac{\omega_b}{\sqrt{\sqrt 2 - 1}}

    The error obeys :math:`M (\ddot e + 2\omega \dot e + \omega^2 e) = 0`, all poles are at
    :math:`-\omega`, and the position follows a command :math:`k_p\, a_d` of the frequency
    :math:`\omega_b` with an amplitude of :math:`1/\sqrt 2`, which defines the bandwidth.

    Parameters
    ----------
    bandwidth : float
        Bandwidth :math:`\omega_b` [rad/s].
    mass : float or (n, n) array_like
        The mass that the feedback moves: 1 for :class:`ComputedTorque`, which turns the robot into
        a unit mass; for :class:`GravityCompensatedPD` the mass matrix, ``robot.mass_matrix`` at the
        pose in which the loop shall be critically damped [kg].

    Returns
    -------
    kp, kv : float or (n, n) ndarray
        Gains of the shape of ``mass``, the two arguments of the controllers [N/m, N s/m; 1/s², 1/s
        of a unit mass].

    Raises
    ------
    InvalidValue
        If the bandwidth is not positive, or a mass that is a number is negative.
    InvalidArray
        If the mass matrix is not square or not finite.
    """
    # |ω²/(ω + iω_b)²| = 1/√2.
    omega = checked_positive("bandwidth", bandwidth) / math.sqrt(math.sqrt(2.0) - 1.0)
    moved = _gain("mass", mass)
    return omega**2 * moved, 2.0 * omega * moved


def _gain(name: str, value: float | ArrayLike) -> float | Array:
    """Return a gain: a number that is not negative, or a square matrix."""
    # NumPy raises an error for rows of different lengths.
    if not isinstance(value, list | tuple) and np.ndim(value) == 0:
        return checked_not_negative(name, value)
    matrix = as_floats(name, value, "(n, n)")
    if matrix.ndim != 2 or matrix.shape[0] != matrix.shape[1] or not np.isfinite(matrix).all():
        raise InvalidArray(name, "(n, n)", value)
    return matrix


def _times(gain: float | Array, error: Array) -> Array:
    if not isinstance(gain, np.ndarray):
        return gain * error
    if len(gain) != len(error):
        raise InvalidArray("gain", f"({len(error)}, {len(error)}) of {len(error)} commanded", gain)
    product: Array = gain @ error
    return product


def _error(desired: Array, found: Array) -> Array:
    """Return the error of the first coordinates, which have a desired motion."""
    # Without a slice if possible, because it costs as much as the difference itself.
    return desired - (found if len(found) == len(desired) else found[: len(desired)])


def _allocated(model: Any, positions: Array, forces: Array) -> Array:
    """Return the motors' forces for forces along the coordinates; usually they are the same."""
    allocate = getattr(model, "allocated_forces", None)
    if allocate is None or getattr(model, "drives_coordinates", True):
        return forces
    motors: Array = allocate(positions, forces)
    return motors


def _table_of(model: Any, widths: Widths) -> NamedTuple | None:
    """Return a model's table for the compiled loop, or None if it has none."""
    make = getattr(model, "compiled_table", None)
    if make is None or widths_of(model) != widths:
        return None
    table: NamedTuple | None = make()
    return table


class _OfModel(Described, SaysNothing):
    """Base of controllers with a model, whose loops are closed from the pose of the last call."""

    def __init__(self, model: DynamicsModel) -> None:
        self.model = model
        self._forces_of = ForcesOfMotions(model)

    def reset(self) -> None:
        """Forget the pose of the last call, which affects only rounding."""
        self._forces_of.forget()

    def _model_table(self, widths: Widths) -> NamedTuple | None:
        return _table_of(self.model, widths)

    def _facts(self) -> dict[str, Any]:
        return {"model": self.model}


def feed_forward(
    forces_of: ForcesOfMotions, positions: Array, speeds: Array, desired: Motion
) -> Array:
    """Return the forces of a desired motion, with passive coordinates as they are."""
    wanted, rates, k = desired.positions, desired.speeds, len(desired.positions)
    if k < len(positions):
        wanted = np.concatenate([wanted, positions[k:]])
        rates = np.concatenate([rates, speeds[k:]])
    return forces_of(wanted, rates, desired.accelerations)


class FeedForward(_OfModel):
    r"""Open loop: the forces of the desired motion, without any feedback (eq. 4.1).

    .. math:: \tau = M(a_d)\, \ddot a_d + C(a_d, \dot a_d)\, \dot a_d + G(a_d)

    Parameters
    ----------
    model : DynamicsModel
        Source of M, C and G: a robot, or a model from ``robot.dynamics(name)``.
    """

    def torque(self, t: float, positions: Array, speeds: Array, desired: Motion) -> Array:
        """Return the forces of the desired motion, of shape (3,) [N]."""
        return feed_forward(self._forces_of, positions, speeds, desired)

    def table(self, robot: Any, widths: Widths) -> NamedTuple | None:
        """Return the controller's table for the compiled loop, or None, see :func:`steer`."""
        model = self._model_table(widths)
        if model is None or type(self) is not FeedForward:
            return None
        return kernels.classical(kernels.FEED_FORWARD, 0.0, 0.0, model, widths)


class PD(Described, SaysNothing, Stateless):
    r"""Proportional and derivative feedback, :math:`\tau = k_p e + k_v \dot e`.

    There is no gravity term, so with the thesis's gains (Table 6.1) every nut sags by its weight
    over :math:`k_p`, 87 mm.

    Parameters
    ----------
    kp : float or (n, n) array_like
        Proportional gain [N/m]: one number for each screw separately, or a matrix.
    kv : float or (n, n) array_like
        Derivative gain [N s/m]. :func:`critically_damped_gains` computes both from a bandwidth.
    model : ClosedLoopRobot, optional
        The robot, if its motors are not its first coordinates: it converts the feedback, which is
        forces along the coordinates, to the motors' forces of least norm.

    Raises
    ------
    InvalidValue
        If a gain is negative or not finite.
    InvalidArray
        If a matrix is not square or not finite.
    """

    def __init__(
        self,
        kp: float | ArrayLike = 1000.0,
        kv: float | ArrayLike = 100.0,
        model: Any = None,
    ) -> None:
        if model is not None:
            checked_model(model)
        self.kp, self.kv, self.model = _gain("kp", kp), _gain("kv", kv), model

    def _facts(self) -> dict[str, Any]:
        return {"model": self.model, "kp": self.kp, "kv": self.kv}

    @property
    def along_coordinates(self) -> bool:
        """Whether the forces are along the coordinates, because the motors are unknown."""
        return self.model is None

    def torque(self, t: float, positions: Array, speeds: Array, desired: Motion) -> Array:
        """Return the feedback forces, of shape (3,) [N]."""
        forces = _times(self.kp, _error(desired.positions, positions)) + _times(
            self.kv, _error(desired.speeds, speeds)
        )
        return _allocated(self.model, positions, forces)

    @property
    def _is_allocated(self) -> bool:
        """Whether the model converts forces along the coordinates to motor forces."""
        return not getattr(self.model, "drives_coordinates", True)

    def _feedback_table(self, robot: Any, widths: Widths, ki: float = 0.0) -> NamedTuple | None:
        is_allocated = self._is_allocated
        model = _table_of(self.model, widths) if is_allocated else robot
        if model is None:
            return None
        return kernels.classical(
            *(kernels.PD, self.kp, self.kv, model, widths, ki), is_allocated=is_allocated
        )

    def table(self, robot: Any, widths: Widths) -> NamedTuple | None:
        """Return the controller's table for the compiled loop, or None, see :func:`steer`."""
        if type(self) is not PD or robot is None:
            return None
        return self._feedback_table(robot, widths)


class GravityCompensatedPD(_OfModel, PD):
    r"""PD plus the model's gravity at the present pose, :math:`\tau = k_p e + k_v \dot e + G(a)`.

    It has no sag at rest.

    Parameters
    ----------
    model : DynamicsModel
        Source of G. If the motors do not command all coordinates, they hold the commanded ones
        against gravity while the others are passive.
    kp, kv : float or (n, n) array_like
        See :class:`PD`.
    """

    def __init__(
        self, model: DynamicsModel, kp: float | ArrayLike = 1000.0, kv: float | ArrayLike = 100.0
    ) -> None:
        PD.__init__(self, kp, kv)
        _OfModel.__init__(self, model)

    def _facts(self) -> dict[str, Any]:
        return PD._facts(self)

    def torque(self, t: float, positions: Array, speeds: Array, desired: Motion) -> Array:
        """Return feedback and gravity forces, of shape (3,) [N]."""
        rest, still = np.zeros(len(speeds)), np.zeros(len(desired.positions))
        feedback = PD.torque(self, t, positions, speeds, desired)
        return feedback + self._forces_of(positions, rest, still)

    def table(self, robot: Any, widths: Widths) -> NamedTuple | None:
        """Return the controller's table for the compiled loop, or None, see :func:`steer`."""
        model = self._model_table(widths)
        if model is None or type(self) is not GravityCompensatedPD:
            return None
        return kernels.classical(
            *(kernels.GRAVITY_COMPENSATED_PD, self.kp, self.kv, model, widths),
            is_allocated=self._is_allocated,
        )


class PID(PD):
    r"""PD plus the integral of the error, :math:`\tau = k_p e + k_v \dot e + k_i \int e\, dt`.

    The integral removes the sag without a model.

    The integral is the trapezoidal rule over the calls since the last reset.

    Parameters
    ----------
    kp, kv, model
        See :class:`PD`.
    ki : float
        Integral gain [N/(m s)]; for a mass m the loop is stable if ki < kp kv / m.
    """

    def __init__(
        self,
        kp: float | ArrayLike = 1000.0,
        kv: float | ArrayLike = 100.0,
        ki: float = 2000.0,
        model: Any = None,
    ) -> None:
        super().__init__(kp, kv, model)
        self.ki = checked_not_negative("ki", ki)
        self.reset()

    def _facts(self) -> dict[str, Any]:
        return super()._facts() | {"ki": self.ki}

    def reset(self) -> None:
        """Forget the integral."""
        self._integral: Array | float = 0.0
        self._last: tuple[float, Array] | None = None

    def torque(self, t: float, positions: Array, speeds: Array, desired: Motion) -> Array:
        """Return the feedback forces, of shape (3,) [N], and update the integral."""
        error = _error(desired.positions, positions)
        if self._last is not None:
            self._integral = self._integral + 0.5 * (t - self._last[0]) * (error + self._last[1])
        self._last = (t, error)
        integral = np.broadcast_to(self.ki * self._integral, error.shape)
        feedback = super().torque(t, positions, speeds, desired)
        return feedback + _allocated(self.model, positions, integral)

    def table(self, robot: Any, widths: Widths) -> NamedTuple | None:
        """Return the controller's table for the compiled loop, or None, see :func:`steer`."""
        if type(self) is not PID or robot is None:
            return None
        return self._feedback_table(robot, widths, self.ki)

    def take(self, table: Any, steps: Array) -> dict[str, Array]:
        """Take the state at the end of a compiled loop."""
        commanded = math.isqrt(table.kp.shape[1])
        self._integral = table.memory[kernels.INTEGRAL, :commanded].copy()
        last = table.memory[kernels.LAST_ERROR, :commanded].copy()
        self._last = (float(table.clock[kernels.TIME]), last)
        return {}


class ComputedTorque(_OfModel):
    r"""Computed torque (eq. 4.10–4.18).

    The model turns the robot into a unit mass, which a servo then controls.

    .. math:: \tau = \alpha\, (\ddot a_d + k_v \dot e + k_p e) + \beta, \qquad
              \alpha = M(a), \quad \beta = C(a, \dot a)\, \dot a + G(a)

    With an exact model the error obeys :math:`\ddot e + k_v \dot e + k_p e = 0` whatever the pose.

    Parameters
    ----------
    model : DynamicsModel
        Source of M, C and G: a robot, or a model from ``robot.dynamics(name)``.
    kp : float
        Proportional gain, 10 in Table 6.1 [1/s²].
    kv : float
        Derivative gain, 1 in Table 6.1 [1/s]: a damping ratio of 0.16.

    Raises
    ------
    InvalidValue
        If a gain is negative or not finite, or the model offers no M, C and G.
    """

    def __init__(self, model: DynamicsModel, kp: float = 10.0, kv: float = 1.0) -> None:
        super().__init__(model)
        self.kp, self.kv = checked_not_negative("kp", kp), checked_not_negative("kv", kv)

    def _facts(self) -> dict[str, Any]:
        return {"model": self.model, "kp": self.kp, "kv": self.kv}

    @classmethod
    def critically_damped(cls, model: DynamicsModel, kp: float = 10.0) -> ComputedTorque:
        r"""Return a controller with :math:`k_v = 2 \sqrt{k_p}`.

        Its error dies out fastest without overshoot (after eq. 4.15).
        """
        return cls(model, kp, 2.0 * np.sqrt(checked_not_negative("kp", kp)))

    def torque(self, t: float, positions: Array, speeds: Array, desired: Motion) -> Array:
        """Return the forces of eq. 4.10, of shape (3,) [N]."""
        servo = (
            desired.accelerations
            + self.kv * _error(desired.speeds, speeds)
            + self.kp * _error(desired.positions, positions)
        )
        return self._forces_of(positions, speeds, servo)

    def table(self, robot: Any, widths: Widths) -> NamedTuple | None:
        """Return the controller's table for the compiled loop, or None, see :func:`steer`."""
        model = self._model_table(widths)
        if model is None or type(self) is not ComputedTorque:
            return None
        return kernels.classical(kernels.COMPUTED_TORQUE, self.kp, self.kv, model, widths)
