r"""Second-order systems and control-law partitioning: chapter 4 of the thesis, eq. 4.3 to 4.18.

A mass on a spring and a damper is the smallest system that shows what a controller does.
:class:`MassSpringDamper` has its poles, its damping case and its response in closed form.
:class:`PartitionedControl` is the law that turns *any* system

.. math:: m(x)\, \ddot x + f(x, \dot x) = F

into a unit mass and then lets the error decay like a mass-spring-damper of one's choice (eq. 4.18):
computed torque control in one dimension. :func:`simulate_tracking` closes the loop, also with a
model that is wrong.

The thesis prints two slips that are corrected here: the underdamped case is :math:`b^2 - 4mk < 0`,
and critical damping of the regulated system is :math:`b' = 2\sqrt{m k'}`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from psp3.checks import Array, checked_finite, checked_positive, finite_array
from psp3.errors import InvalidArray, InvalidValue, MotionDiverged

# The closest that b, written by a caller as 2 sqrt(m k), can be expected to come to it.
ROUNDING = 4.0 * np.finfo(float).eps


class DampingCase(StrEnum):
    """The three responses of a second-order system (section 4.2.2).

    They are told apart by the sign of :math:`b^2 - 4mk`.
    """

    OVERDAMPED = "overdamped"
    UNDERDAMPED = "underdamped"
    CRITICALLY_DAMPED = "critically damped"


class Response(NamedTuple):
    """Motion of a second-order system: ``position`` [m] and ``speed`` [m/s], both (...)."""

    position: Array
    speed: Array


class Gains(NamedTuple):
    """Gains of a regulator (eq. 4.6).

    ``kp`` on the position [N/m] and ``kv`` on the speed [N s/m].
    """

    kp: float
    kv: float


class Desired(NamedTuple):
    """Desired motion at one instant.

    ``position`` [m], ``speed`` [m/s] and ``acceleration`` [m/s²].
    """

    position: float
    speed: float
    acceleration: float


def critical_damping(stiffness: float, mass: float = 1.0) -> float:
    r"""Return the damping with which a spring and a mass return fastest without oscillating.

    .. math:: b = 2 \sqrt{m k}

    With the default unit mass it is the servo gain :math:`k_v = 2\sqrt{k_p}` of eq. 4.15.

    Parameters
    ----------
    stiffness : float
        Stiffness :math:`k` [N/m], or the gain :math:`k_p` [1/s²].
    mass : float
        Mass :math:`m` [kg].

    Returns
    -------
    float
        Damping :math:`b` [N s/m], or the gain :math:`k_v` [1/s].

    Raises
    ------
    InvalidValue
        If the stiffness or the mass is not positive and finite.
    """
    return (
        2.0
        * math.sqrt(checked_positive("mass", mass))
        * math.sqrt(checked_positive("stiffness", stiffness))
    )


@dataclass(frozen=True)
class MassSpringDamper:
    r"""A mass on a spring and a damper (eq. 4.3, Fig. 33).

    .. math:: m \ddot x + b \dot x + k x = 0

    Parameters
    ----------
    mass : float
        Mass :math:`m` [kg].
    damping : float
        Friction :math:`b` [N s/m]. Negative values, which a controller can produce, are unstable.
    stiffness : float
        Stiffness :math:`k` [N/m]. Negative values are unstable.

    Raises
    ------
    InvalidValue
        If the mass is not positive, or a value is not a finite number.
    """

    mass: float
    damping: float
    stiffness: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "mass", checked_positive("mass", self.mass))
        object.__setattr__(self, "damping", checked_finite("damping", self.damping))
        object.__setattr__(self, "stiffness", checked_finite("stiffness", self.stiffness))

    @property
    def _decay(self) -> float:
        return self.damping / (2.0 * self.mass)

    @property
    def _frequency(self) -> float:
        # Two roots instead of one of the quotient: neither overflows.
        return math.sqrt(abs(self.stiffness)) / math.sqrt(self.mass)

    @property
    def _half_gap(self) -> complex:
        """Half the distance of the poles, (b² − 4mk)^½ / 2m: real, imaginary or exactly zero."""
        decay, frequency = abs(self._decay), self._frequency
        if self.stiffness < 0.0:
            return complex(math.hypot(decay, frequency))
        difference = decay - frequency
        if abs(difference) <= ROUNDING * frequency:
            return 0j
        # The factored form of b² − 4mk loses nothing but the rounding of its factors.
        root = math.sqrt(abs(difference)) * math.sqrt(decay + frequency)
        return complex(root) if difference > 0.0 else complex(0.0, root)

    @property
    def poles(self) -> NDArray[np.complex128]:
        r"""Roots of the characteristic equation :math:`m s^2 + b s + k = 0` (eq. 4.4, 4.5).

        .. math:: s_{1,2} = -\frac{b}{2m} \mp \frac{\sqrt{b^2 - 4mk}}{2m}

        Shape (2,) [1/s], :math:`s_1` first. Real roots of very different size are both accurate to
        rounding.
        """
        decay, half_gap = self._decay, self._half_gap
        if half_gap.imag != 0.0 or half_gap == 0.0:
            return np.array([-decay - half_gap, -decay + half_gap])
        # The smaller root comes from the product s1 s2 = k/m, because the sum in eq. 4.5 would
        # cancel.
        large = abs(decay) + half_gap.real
        small = math.copysign(self._frequency * (self._frequency / large), self.stiffness)
        return np.array([-large, -small] if decay >= 0.0 else [small, large], dtype=complex)

    @property
    def damping_case(self) -> DampingCase:
        r"""Overdamped, underdamped or critically damped, by the sign of :math:`b^2 - 4mk`.

        See section 4.2.2.

        Real and equal roots are recognized when :math:`b` is :math:`2\sqrt{mk}` to within four
        rounding errors.
        """
        half_gap = self._half_gap
        if half_gap == 0.0:
            return DampingCase.CRITICALLY_DAMPED
        return DampingCase.UNDERDAMPED if half_gap.imag != 0.0 else DampingCase.OVERDAMPED

    @property
    def is_stable(self) -> bool:
        """Whether every motion dies out: damping and stiffness are both positive.

        With one of them zero the system stays bounded at best, and does not return to
        :math:`x = 0`.
        """
        return self.damping > 0.0 and self.stiffness > 0.0

    def energy(self, position: ArrayLike, speed: ArrayLike) -> Array:
        r"""Return the mechanical energy :math:`\tfrac12 m \dot x^2 + \tfrac12 k x^2`.

        Its rate is :math:`-b \dot x^2`.

        Parameters
        ----------
        position, speed : (...) array_like
            State of the mass [m], [m/s].

        Returns
        -------
        (...) ndarray
            Energy [J].
        """
        x, v = np.asarray(position, dtype=float), np.asarray(speed, dtype=float)
        return np.asarray(0.5 * (self.mass * v**2 + self.stiffness * x**2))

    def response(self, t: ArrayLike, position: ArrayLike, speed: ArrayLike) -> Response:
        r"""Return the free motion after a release at :math:`t = 0`.

        It is the solution of eq. 4.3 in closed form.

        With the poles :math:`s_1 \le s_2` of eq. 4.5, :math:`2\delta = s_2 - s_1` and
        :math:`E = (1 - e^{-2\delta t}) / 2\delta`,

        .. math::

            x &= e^{s_2 t} \big[ (e^{-2\delta t} - s_1 E)\, x_0 + E\, \dot x_0 \big], \\
            \dot x &= e^{s_2 t} \big[ (e^{-2\delta t} + s_2 E)\, \dot x_0 - \tfrac km E\, x_0 \big],

        and, for complex poles :math:`-\sigma \pm i\omega` with :math:`S = \sin(\omega t) / \omega`,

        .. math::

            x &= e^{-\sigma t} \big[ (\cos\omega t + \sigma S)\, x_0 + S\, \dot x_0 \big], \\
            \dot x &= e^{-\sigma t} \big[ (\cos\omega t - \sigma S)\, \dot x_0
            - \tfrac km S\, x_0 \big].

        Both pass into the critically damped response without loss as the poles meet, where
        :math:`E = S = t`.

        Parameters
        ----------
        t : (...) array_like
            Time since the release, not negative [s].
        position, speed : (...) array_like
            State at the release [m], [m/s]; broadcast against ``t``.

        Returns
        -------
        Response
            Position [m] and speed [m/s], of the shape that the arguments broadcast to.

        Raises
        ------
        InvalidArray
            If an argument is not finite.
        InvalidValue
            If a time is negative, or so long that the motion of an unstable system leaves the range
            of the numbers.
        """
        time, x0, v0 = (
            finite_array("t", t),
            finite_array("position", position),
            finite_array("speed", speed),
        )
        if (time < 0.0).any():
            raise InvalidValue("t", float(time.min()), "a time since the release, not negative")
        decay, half_gap, stiffness = self._decay, self._half_gap, self.stiffness / self.mass
        with np.errstate(over="ignore", invalid="ignore"):  # looked for below
            if half_gap.imag != 0.0:
                growth = np.exp(-decay * time)
                cosine, sine = (
                    np.cos(half_gap.imag * time),
                    np.sin(half_gap.imag * time) / half_gap.imag,
                )
                of_position, of_speed = cosine + decay * sine, cosine - decay * sine
            else:
                first, second = self.poles.real
                distance = 2.0 * half_gap.real
                growth, ratio = np.exp(second * time), np.exp(-distance * time)
                sine = -np.expm1(-distance * time) / distance if distance > 0.0 else time
                of_position, of_speed = ratio - first * sine, ratio + second * sine
            x = np.asarray(growth * (of_position * x0 + sine * v0))
            v = np.asarray(growth * (of_speed * v0 - stiffness * sine * x0))
        if not (np.isfinite(x).all() and np.isfinite(v).all()):
            pole = float(self.poles.real.max())
            raise InvalidValue(
                "t",
                float(time.max()),
                f"shorter: the system is unstable, it grows by e in {1.0 / pole:.3g} s",
            )
        return Response(x, v)

    def regulated(self, kp: float, kv: float) -> MassSpringDamper:
        r"""Return the closed loop under the regulator :math:`f = -k_p x - k_v \dot x`.

        See eq. 4.6 to 4.8.

        .. math:: m \ddot x + b' \dot x + k' x = 0, \qquad b' = b + k_v, \quad k' = k + k_p

        Parameters
        ----------
        kp : float
            Gain on the position [N/m].
        kv : float
            Gain on the speed [N s/m].

        Returns
        -------
        MassSpringDamper
            The closed loop. Gains that make :math:`b'` or :math:`k'` negative make it unstable: see
            :attr:`is_stable`.

        Raises
        ------
        InvalidValue
            If a gain is not a finite number.
        """
        return MassSpringDamper(
            self.mass,
            self.damping + checked_finite("kv", kv),
            self.stiffness + checked_finite("kp", kp),
        )

    def regulation_gains(self, stiffness: float, damping: float | None = None) -> Gains:
        r"""Return the gains that give the closed loop :math:`k'` and :math:`b'` (eq. 4.7, 4.8).

        They are its stiffness and damping.

        .. math:: k_p = k' - k, \qquad k_v = b' - b

        Parameters
        ----------
        stiffness : float
            Stiffness :math:`k'` of the closed loop [N/m].
        damping : float, optional
            Damping :math:`b'` of the closed loop [N s/m]; critical damping,
            :math:`b' = 2\sqrt{m k'}`, by default.

        Returns
        -------
        Gains
            ``kp`` [N/m] and ``kv`` [N s/m].

        Raises
        ------
        InvalidValue
            If the stiffness or the damping asked for is not positive and finite: such a closed loop
            is not stable.
        """
        k = checked_positive("stiffness of the closed loop", stiffness)
        b = (
            critical_damping(k, self.mass)
            if damping is None
            else checked_positive("damping of the closed loop", damping)
        )
        return Gains(k - self.stiffness, b - self.damping)

    def system(self) -> SecondOrderSystem:
        """Return the same system with an applied force, in the general form (eq. 4.9)."""
        return SecondOrderSystem(
            lambda _: self.mass, lambda x, v: self.damping * v + self.stiffness * x
        )


@dataclass(frozen=True)
class SecondOrderSystem:
    r"""Any system of one coordinate that a force drives (eq. 4.9).

    Also its non-linear form in section 4.3.

    .. math:: m(x)\, \ddot x + f(x, \dot x) = F

    Parameters
    ----------
    mass : callable
        :math:`m(x)`, from a position [m] to a mass [kg], positive everywhere.
    internal_force : callable
        :math:`f(x, \dot x)`, from a position [m] and a speed [m/s] to a force [N]: springs,
        friction, gravity.
    """

    mass: Callable[[float], float]
    internal_force: Callable[[float, float], float]

    def acceleration(self, position: float, speed: float, force: float) -> float:
        r"""Return :math:`\ddot x = (F - f(x, \dot x)) / m(x)` (eq. 4.9).

        Parameters
        ----------
        position, speed : float
            State [m], [m/s].
        force : float
            Applied force :math:`F` [N].

        Returns
        -------
        float
            Acceleration [m/s²].

        Raises
        ------
        InvalidValue
            If :math:`m(x)` is not positive.
        """
        # What interpolates returns arrays of one number.
        mass = checked_positive(f"mass at x = {position:.6g} m", float(self.mass(position)))
        return (force - self.internal_force(position, speed)) / mass


def cubic_spring(mass: float, damping: float, stiffness: float) -> SecondOrderSystem:
    r"""Return a mass on a damper and a spring that hardens (section 4.3).

    It hardens with the cube of its length.

    .. math:: m \ddot x + b \dot x + k x^3 = F

    Parameters
    ----------
    mass : float
        Mass :math:`m` [kg].
    damping : float
        Friction :math:`b` [N s/m].
    stiffness : float
        Stiffness :math:`k` [N/m³].

    Returns
    -------
    SecondOrderSystem
        The system.

    Raises
    ------
    InvalidValue
        If the mass is not positive, or a value is not a finite number.
    """
    m, b, k = (
        checked_positive("mass", mass),
        checked_finite("damping", damping),
        checked_finite("stiffness", stiffness),
    )
    return SecondOrderSystem(lambda _: m, lambda x, v: b * v + k * x**3)


@dataclass(frozen=True)
class PartitionedControl:
    r"""Control-law partitioning with a trajectory-following servo (eq. 4.10 to 4.18, Fig. 40).

    The model-based part makes a unit mass of the system, the servo part moves the unit mass:

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
        r"""Return the law of exact model, :math:`\alpha = m` and :math:`\beta = f` (eq. 4.12).

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
        r"""The error's own equation, :math:`\ddot e + k_v \dot e + k_p e = 0` (eq. 4.18).

        As a system of unit mass.

        Its ``response(t, e0, e0_dot)`` is the error to expect, its ``is_stable`` says whether the
        error dies out.
        """
        return MassSpringDamper(1.0, self.kv, self.kp)

    def servo(self, desired: Desired, position: float, speed: float) -> float:
        r"""Return the servo part :math:`f' = \ddot x_d + k_v \dot e + k_p e` (eq. 4.16).

        With a desired motion at rest in 0 it is eq. 4.14.

        Parameters
        ----------
        desired : Desired
            Desired position [m], speed [m/s] and acceleration [m/s²].
        position, speed : float
            State of the system [m], [m/s].

        Returns
        -------
        float
            Acceleration that is asked of the unit mass [m/s²].
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
        Force that the control law asked for [N].
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
        The control law. Its model of the system need not be right.
    desired : callable
        From a time [s] to the :class:`Desired` motion.
    t : (N,) array_like
        Increasing times at which to report, at least two [s]; the motion starts at the first.
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
        If the motion leaves the range of the numbers, or a force is not a finite number.
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
    # the step fell below the spacing of the numbers: the motion has no end in this interval
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
