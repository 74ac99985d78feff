r"""Second-order systems: chapter 4 of the thesis, eq. 4.3 to 4.9.

A mass on a spring and a damper is the smallest system that shows what a controller does.
:class:`MassSpringDamper` has its poles, its damping case and its response in closed form;
:class:`SecondOrderSystem` is any system with one coordinate that a force drives.

Two misprints of the thesis are corrected here: the underdamped case is :math:`b^2 - 4mk < 0`, and
critical damping of the regulated system is :math:`b' = 2\sqrt{m k'}`.
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
from psp3.errors import InvalidValue

# How closely a caller's 2 sqrt(m k) in floating point can be expected to match critical damping.
ROUNDING = 4.0 * np.finfo(float).eps


class DampingCase(StrEnum):
    """The three responses of a second-order system (section 4.2.2).

    The sign of :math:`b^2 - 4mk` distinguishes them.
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
        # Two separate square roots do not overflow, unlike the root of the quotient.
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
        # The factored form of b² − 4mk avoids cancellation: only its factors are rounded.
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
        # The smaller root comes from the product s1 s2 = k/m, because the sum in eq. 4.5 suffers
        # cancellation.
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

        Both forms stay accurate as the poles meet, and become the critically damped response, where
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
            If a time is negative, or so long that the motion of an unstable system overflows.
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
            If the stiffness or the damping is not positive and finite, because such a closed loop
            is unstable.
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
    r"""A system with one coordinate that a force drives (eq. 4.9).

    It may be non-linear, as in section 4.3.

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
        # Interpolators return arrays of one number.
        mass = checked_positive(f"mass at x = {position:.6g} m", float(self.mass(position)))
        return (force - self.internal_force(position, speed)) / mass


def cubic_spring(mass: float, damping: float, stiffness: float) -> SecondOrderSystem:
    r"""Return a mass on a damper and a hardening spring (section 4.3).

    The spring force grows with the cube of the deflection.

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
