r"""Control-law partitioning: chapter 4 of the thesis, eq. 4.9 to 4.18.

:class:`PartitionedControl` is the control law that turns *any* system

.. math:: m(x)\, \ddot x + f(x, \dot x) = F

into a unit mass, and then makes the error decay like a chosen mass-spring-damper (eq. 4.18). It is
computed torque control in one dimension. :func:`simulate_tracking` simulates the closed loop, also
with a wrong model. The systems are those of :mod:`psp3.thesis.chapter_4_systems`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from psp3.checks import Array, checked_finite, finite_array
from psp3.errors import InvalidArray, InvalidValue, MotionDiverged
from psp3.thesis.chapter_4_systems import (
    MassSpringDamper,
    SecondOrderSystem,
)


class Desired(NamedTuple):
    """Desired motion at one instant.

    ``position`` [m], ``speed`` [m/s] and ``acceleration`` [m/s²].
    """

    position: float
    speed: float
    acceleration: float


@dataclass(frozen=True)
class PartitionedControl:
    r"""Control-law partitioning with a trajectory-following servo (eq. 4.10 to 4.18, Fig. 40).

    The model-based part turns the system into a unit mass, and the servo part moves it:

    .. math:: F = \alpha(x)\, f' + \beta(x, \dot x), \qquad
              f' = \ddot x_d + k_v \dot e + k_p e, \qquad e = x_d - x

    With :math:`\alpha = m` and :math:`\beta = f` (eq. 4.12) the error obeys
    :math:`\ddot e + k_v \dot e + k_p e = 0` (eq. 4.18) whatever the system; with any other
    :math:`\alpha` and :math:`\beta` it does so approximately.

    Parameters
    ----------
    alpha : callable
        Model of the mass, :math:`\alpha(x)`, from a position [m] to a mass [kg].
    beta : callable
        Model of the internal force, :math:`\beta(x, \dot x)`, from position [m] and speed [m/s] to
        a force [N].
    kp : float
        Servo gain on the error [1/s²].
    kv : float
        Servo gain on the error's rate [1/s]; :func:`critical_damping` of ``kp`` damps the error
        critically.

    Raises
    ------
    InvalidValue
        If a gain is not a finite number.
    """

    alpha: Callable[[float], float]
    beta: Callable[[float, float], float]
    kp: float
    kv: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "kp", checked_finite("kp", self.kp))
        object.__setattr__(self, "kv", checked_finite("kv", self.kv))

    @classmethod
    def of(cls, system: SecondOrderSystem, kp: float, kv: float) -> PartitionedControl:
        r"""Return the law with exact model, :math:`\alpha = m` and :math:`\beta = f` (eq. 4.12).

        Parameters
        ----------
        system : SecondOrderSystem
            The system to control.
        kp, kv : float
            Servo gains [1/s²], [1/s].

        Returns
        -------
        PartitionedControl
            The law.
        """
        return cls(system.mass, system.internal_force, kp, kv)

    @property
    def error_dynamics(self) -> MassSpringDamper:
        r"""The error equation, :math:`\ddot e + k_v \dot e + k_p e = 0` (eq. 4.18).

        It is returned as a system of unit mass.

        Its ``response(t, e0, e0_dot)`` is the expected error, and ``is_stable`` says whether the
        error dies out.
        """
        return MassSpringDamper(1.0, self.kv, self.kp)

    def servo(self, desired: Desired, position: float, speed: float) -> float:
        r"""Return the servo part :math:`f' = \ddot x_d + k_v \dot e + k_p e` (eq. 4.16).

        If the desired motion is at rest in 0, this is eq. 4.14.

        Parameters
        ----------
        desired : Desired
            Desired position [m], speed [m/s] and acceleration [m/s²].
        position, speed : float
            State of the system [m], [m/s].

        Returns
        -------
        float
            Acceleration command for the unit mass [m/s²].
        """
        return (
            desired.acceleration
            + self.kv * (desired.speed - speed)
            + self.kp * (desired.position - position)
        )

    def force(self, desired: Desired, position: float, speed: float) -> float:
        r"""Return the force on the system, :math:`F = \alpha f' + \beta` (eq. 4.10).

        Parameters
        ----------
        desired : Desired
            Desired position [m], speed [m/s] and acceleration [m/s²].
        position, speed : float
            State of the system [m], [m/s].

        Returns
        -------
        float
            Force [N].
        """
        return self.alpha(position) * self.servo(desired, position, speed) + self.beta(
            position, speed
        )


@dataclass(frozen=True)
class Tracking:
    """A simulated closed loop; every array has shape (N,).

    Parameters
    ----------
    t : (N,) ndarray
        Time [s].
    position, speed : (N,) ndarray
        State of the system [m], [m/s].
    desired_position, desired_speed : (N,) ndarray
        Desired motion [m], [m/s].
    force : (N,) ndarray
        Force of the control law [N].
    """

    t: Array
    position: Array
    speed: Array
    desired_position: Array
    desired_speed: Array
    force: Array

    @property
    def error(self) -> Array:
        """Servo error, desired minus actual position (eq. 4.2), (N,) [m]."""
        return self.desired_position - self.position

    @property
    def error_speed(self) -> Array:
        """Rate of the servo error, desired minus actual speed (eq. 4.2), (N,) [m/s]."""
        return self.desired_speed - self.speed


def simulate_tracking(
    system: SecondOrderSystem,
    control: PartitionedControl,
    desired: Callable[[float], Desired],
    t: ArrayLike,
    position: float,
    speed: float,
) -> Tracking:
    r"""Integrate the closed loop of a system and a partitioned law.

    See eq. 4.9, 4.10 and 4.16.

    The law acts in continuous time, as in chapter 4; the integrator is DOP853 with relative
    tolerance 1e-10 and absolute tolerance 1e-12.

    Parameters
    ----------
    system : SecondOrderSystem
        The system.
    control : PartitionedControl
        The control law. Its model of the system may be wrong.
    desired : callable
        From a time [s] to the :class:`Desired` motion.
    t : (N,) array_like
        Increasing times of the returned samples, at least two [s]; the motion starts at the first.
    position, speed : float
        State at the first time [m], [m/s].

    Returns
    -------
    Tracking
        The motion at the times ``t``.

    Raises
    ------
    InvalidArray
        If the times are not finite or not of shape (N,).
    InvalidValue
        If the times do not increase, or a mass is not positive, or a start value is not a finite
        number.
    MotionDiverged
        If the motion overflows, or a force is not a finite number.
    """
    times = finite_array("t", t)
    if times.ndim != 1 or times.size < 2:
        raise InvalidArray("t", "(N,) with N of at least 2", times)
    if (np.diff(times) <= 0.0).any():
        raise InvalidValue(
            "t",
            float(np.diff(times).min()),
            "a list of times in increasing order, got a step of that size",
        )
    start = checked_finite("position", position), checked_finite("speed", speed)
    from scipy.integrate import solve_ivp

    latest = (float(times[0]), *start, math.nan)

    def rates(time: float, state: Array) -> tuple[float, float]:
        nonlocal latest
        x, v = state.tolist()
        try:
            force = control.force(desired(time), x, v)
            acceleration = system.acceleration(x, v, force)
        except OverflowError:
            force = acceleration = math.inf
        latest = (time, x, v, force)
        if not math.isfinite(acceleration):
            raise MotionDiverged(*latest)
        return v, acceleration

    solution = solve_ivp(
        rates, (times[0], times[-1]), start, method="DOP853", t_eval=times, rtol=1e-10, atol=1e-12
    )
    # the step fell below the spacing of floating-point numbers: the motion diverges in the interval
    if not solution.success:
        raise MotionDiverged(*latest)
    x, v = solution.y
    wanted = [desired(time) for time in times.tolist()]
    return Tracking(
        times,
        x,
        v,
        np.array([motion.position for motion in wanted], dtype=float),
        np.array([motion.speed for motion in wanted], dtype=float),
        np.array(
            [control.force(*state) for state in zip(wanted, x.tolist(), v.tolist(), strict=True)],
            dtype=float,
        ),
    )
