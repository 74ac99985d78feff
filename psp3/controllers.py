r"""Controllers of the screw forces: feed-forward, PD, PD with gravity, PID and computed torque.

A controller has ``reset()``, called once before a run, and ``torque(t, heights, speeds, desired)``, called once a control
period. Everything that offers these two can be simulated. ``desired`` is a :class:`psp3.trajectories.Motion`; the servo errors
are :math:`e = a_d - a` and :math:`\dot e = \dot a_d - \dot a` (eq. 4.2).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from psp3.arrays import Array, checked_not_negative
from psp3.errors import InvalidValue
from psp3.robot import DynamicsModel
from psp3.trajectories import Motion


class Controller(Protocol):
    """What the simulation needs of a controller."""

    def reset(self) -> None:
        """Forget everything about earlier runs."""
        ...

    def torque(self, t: float, heights: Array, speeds: Array, desired: Motion) -> Array:
        """Return the screw forces for the next control period."""
        ...


def _equation_of_motion(model: DynamicsModel) -> Callable[[ArrayLike, ArrayLike], tuple[Array, Array, Array]]:
    """How to get M, C and G of a model: in one call, or from its three methods."""
    whole = getattr(model, "equation_of_motion", None)
    if whole is not None:
        equation: Callable[[ArrayLike, ArrayLike], tuple[Array, Array, Array]] = whole
        return equation
    if all(hasattr(model, name) for name in ("mass_matrix", "coriolis_matrix", "gravity")):
        return lambda a, v: (model.mass_matrix(a), model.coriolis_matrix(a, v), model.gravity(a))  # type: ignore[attr-defined]
    raise InvalidValue("model", model, "a model with equation_of_motion, or with mass_matrix, coriolis_matrix and gravity")


class _Stateless:
    """A controller whose torque depends on the present only."""

    def reset(self) -> None:
        """Forget nothing: this controller remembers nothing."""


class FeedForward(_Stateless):
    r"""Open loop: the forces of the desired motion, without any feedback (eq. 4.1).

    .. math:: \tau = M(a_d)\, \ddot a_d + C(a_d, \dot a_d)\, \dot a_d + G(a_d)

    Parameters
    ----------
    model : DynamicsModel
        Where M, C and G come from: a robot, or one of ``robot.dynamics(name)``.
    """

    def __init__(self, model: DynamicsModel) -> None:
        self.model = model
        self._equation = _equation_of_motion(model)

    def torque(self, t: float, heights: Array, speeds: Array, desired: Motion) -> Array:
        """Return the forces of the desired motion, of shape (3,) [N]."""
        M, C, G = self._equation(desired.heights, desired.speeds)
        torque: Array = M @ desired.accelerations + C @ desired.speeds + G
        return torque


class PD(_Stateless):
    r"""Proportional and derivative feedback, :math:`\tau = k_p e + k_v \dot e`.

    There is no gravity term, so under the thesis's gains (Table 6.1) every screw sags by its weight over :math:`k_p`, 87 mm.

    Parameters
    ----------
    kp : float
        Proportional gain [N/m].
    kv : float
        Derivative gain [N s/m].

    Raises
    ------
    InvalidValue
        If a gain is negative or not finite.
    """

    def __init__(self, kp: float = 1000.0, kv: float = 100.0) -> None:
        self.kp, self.kv = checked_not_negative("kp", kp), checked_not_negative("kv", kv)

    def torque(self, t: float, heights: Array, speeds: Array, desired: Motion) -> Array:
        """Return the feedback forces, of shape (3,) [N]."""
        torque: Array = self.kp * (desired.heights - heights) + self.kv * (desired.speeds - speeds)
        return torque


class GravityCompensatedPD(PD):
    r"""PD plus the model's gravity at the present pose, :math:`\tau = k_p e + k_v \dot e + G(a)`: no sag at rest.

    Parameters
    ----------
    model : DynamicsModel
        Where G comes from.
    kp, kv : float
        See :class:`PD`.
    """

    def __init__(self, model: DynamicsModel, kp: float = 1000.0, kv: float = 100.0) -> None:
        super().__init__(kp, kv)
        self.model = model
        self._equation = _equation_of_motion(model)

    def torque(self, t: float, heights: Array, speeds: Array, desired: Motion) -> Array:
        """Return feedback and gravity forces, of shape (3,) [N]."""
        return super().torque(t, heights, speeds, desired) + self._equation(heights, speeds)[2]


class PID(PD):
    r"""PD plus the integral of the error, :math:`\tau = k_p e + k_v \dot e + k_i \int e\, dt`: the sag dies out without a model.

    The integral is the trapezoidal rule over the calls since the last reset.

    Parameters
    ----------
    kp, kv : float
        See :class:`PD`.
    ki : float
        Integral gain [N/(m s)]; the loop of a mass m is stable for ki < kp kv / m.
    """

    def __init__(self, kp: float = 1000.0, kv: float = 100.0, ki: float = 2000.0) -> None:
        super().__init__(kp, kv)
        self.ki = checked_not_negative("ki", ki)
        self.reset()

    def reset(self) -> None:
        """Forget the integral."""
        self._integral = np.zeros(3)
        self._last: tuple[float, Array] | None = None

    def torque(self, t: float, heights: Array, speeds: Array, desired: Motion) -> Array:
        """Return the feedback forces, of shape (3,) [N], and go on with the integral."""
        error = desired.heights - heights
        if self._last is not None:
            self._integral = self._integral + 0.5 * (t - self._last[0]) * (error + self._last[1])
        self._last = (t, error)
        return super().torque(t, heights, speeds, desired) + self.ki * self._integral


class ComputedTorque(_Stateless):
    r"""Computed torque: the model makes the robot a unit mass, which a servo then steers (eq. 4.10–4.18).

    .. math:: \tau = \alpha\, (\ddot a_d + k_v \dot e + k_p e) + \beta, \qquad \alpha = M(a), \quad \beta = C(a, \dot a)\, \dot a + G(a)

    With an exact model the error obeys :math:`\ddot e + k_v \dot e + k_p e = 0` whatever the pose.

    Parameters
    ----------
    model : DynamicsModel
        Where M, C and G come from: a robot, or one of ``robot.dynamics(name)``.
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
        self.model = model
        self.kp, self.kv = checked_not_negative("kp", kp), checked_not_negative("kv", kv)
        self._equation = _equation_of_motion(model)

    @classmethod
    def critically_damped(cls, model: DynamicsModel, kp: float = 10.0) -> ComputedTorque:
        r"""Return a controller with :math:`k_v = 2 \sqrt{k_p}`, whose error dies out fastest without overshoot (after eq. 4.15)."""
        return cls(model, kp, 2.0 * np.sqrt(checked_not_negative("kp", kp)))

    def torque(self, t: float, heights: Array, speeds: Array, desired: Motion) -> Array:
        """Return the forces of eq. 4.10, of shape (3,) [N]."""
        M, C, G = self._equation(heights, speeds)
        servo = desired.accelerations + self.kv * (desired.speeds - speeds) + self.kp * (desired.heights - heights)
        torque: Array = M @ servo + C @ speeds + G
        return torque
