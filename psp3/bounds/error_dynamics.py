r"""How far a disturbance can drive the error of computed torque.

Under computed torque with gains :math:`k_p, k_v` every error :math:`e = a_d - a` obeys

.. math:: \ddot e + k_v \dot e + k_p e = -d(t), \qquad
          d = M^{-1} (\tau - \tau_{\text{ideal}}), \quad
          \tau_{\text{ideal}} = M (\ddot a_d + k_v \dot e + k_p e) + C \dot a + G,

where the residual acceleration d is the effect of the difference between the actual force and the
ideal one of the servo. So an error is at most the greatest :math:`|d|` times the integral of the
absolute impulse response. The bound is tight: a disturbance of that size, with the sign of the
impulse response, comes arbitrarily near.

A digital controller samples the error once a period h and holds its force until the next sample.
Then d is relative to the *held* servo acceleration, and the loop is one in discrete time,

.. math:: x_{j+1} = F x_j - \int_0^h \binom{h - s}{1} d(jh + s)\, ds, \qquad
          x = \binom{e}{\dot e}, \quad
          F = \begin{pmatrix} 1 & h \\ 0 & 1 \end{pmatrix}
              - \binom{h^2 / 2}{h} \begin{pmatrix} k_p & k_v \end{pmatrix},

which is exact. Holding the feedback does not contribute to d, but changes of the desired
acceleration within a period do.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from psp3.checks import Array, checked_not_negative, checked_positive
from psp3.errors import InvalidValue

ROWS = 4096
"""Number of periods whose impulse responses are in memory at a time."""

NEGLIGIBLE = 1e-17
"""Terms below this share of a sum count as rounding."""

SLOWEST = 1e-6
"""Least share of an error that must die out in a control period."""


@dataclass(frozen=True)
class ErrorDynamics:
    r"""The dynamics of every error under computed torque.

    Parameters
    ----------
    kp, kv : float
        Gains of the servo [1/s²], [1/s].
    period : float
        Control period h [s]; 0 for a controller without one.

    Raises
    ------
    InvalidValue
        If a gain is not positive, or if errors do not settle with these gains and this period. They
        settle if :math:`\tfrac12 h k_p < k_v < 2 / h`, by the eigenvalues of F.
    """

    kp: float
    kv: float
    period: float = 0.0

    def __post_init__(self) -> None:
        """Check that errors settle."""
        kp, kv = checked_positive("kp", self.kp), checked_positive("kv", self.kv)
        h = checked_not_negative("period", self.period)
        for name, value in (("kp", kp), ("kv", kv), ("period", h)):
            object.__setattr__(self, name, value)
        # Jury's conditions for eigenvalues within the unit circle, in closed form.
        if h > 0.0 and not 0.5 * h * kp < kv < 2.0 / h:
            raise InvalidValue(
                "period",
                h,
                f"below {min(2.0 * kv / kp, 2.0 / kv):.6g} s, where errors settle with kp = "
                f"{kp:g} and kv = {kv:g}",
            )
        if 0.0 < h * min(kp / kv, 0.5 * kv) < SLOWEST:
            raise InvalidValue(
                "period",
                h,
                f"0 for a loop as slow as that of kp = {kp:g} and kv = {kv:g}, which needs more "
                f"than {1.0 / SLOWEST:.0e} periods to settle",
            )

    @property
    def damping_ratio(self) -> float:
        r"""Damping ratio :math:`\zeta = k_v / (2 \sqrt{k_p})` of the loop without a period."""
        return self.kv / (2.0 * math.sqrt(self.kp))

    @property
    def step(self) -> Array:
        """The matrix F of a period, (2, 2)."""
        h, kp, kv = self.period, self.kp, self.kv
        return np.array([[1.0 - 0.5 * h**2 * kp, h - 0.5 * h**2 * kv], [-h * kp, 1.0 - h * kv]])

    def worst_error(self) -> float:
        r"""Return the greatest error that disturbances of at most 1 m/s² can cause from rest [s²].

        Without a period it is the integral of the absolute impulse response,

        .. math:: \int_0^\infty |g(t)|\, dt = \frac{1}{k_p} \begin{cases} 1 & \zeta \ge 1 \\
                  \coth \dfrac{\pi \zeta}{2 \sqrt{1 - \zeta^2}} & \zeta < 1 \end{cases}

        because g has one sign if :math:`\zeta \ge 1`, and otherwise its half waves are a geometric
        series. With a period it is the sum of :func:`share_of_period` over all periods, to
        rounding.
        """
        if self.period == 0.0:
            ratio = self.damping_ratio
            if ratio >= 1.0:
                return 1.0 / self.kp
            return 1.0 / (self.kp * math.tanh(0.5 * math.pi * ratio / math.sqrt(1.0 - ratio**2)))
        block = powers(self.step, ROWS)
        rows, leap, total = block[:, 0], block[-1] @ self.step, 0.0
        # The loop ends because errors settle, see SLOWEST.
        while True:
            more = float(share_of_period(rows, self.period).sum())
            total += more
            if more <= NEGLIGIBLE * total:
                return total
            rows = rows @ leap


def powers(matrix: Array, count: int) -> Array:
    """Return the powers 0, 1, ... of a matrix (2, 2), (count, 2, 2), by doubling."""
    found, leap = np.eye(2)[np.newaxis], matrix
    while len(found) < count:
        found, leap = np.concatenate([found, found @ leap]), leap @ leap
    return found[:count]


def share_of_period(rows: Array, period: float) -> Array:
    r"""Return the greatest effect of one period's disturbance on a later error, per unit.

    .. math:: \int_0^h |\alpha (h - s) + \beta|\, ds

    Parameters
    ----------
    rows : (..., 2) ndarray
        Later effect of the error and its rate at the end of the period, :math:`(\alpha, \beta)`:
        the first row of a power of F.
    period : float
        Control period h [s].

    Returns
    -------
    (...,) ndarray
        [s²]
    """
    first, last = rows[..., 1] + period * rows[..., 0], rows[..., 1]
    # The mean absolute value of a straight line is the mean of its ends, or that of two triangles
    # if its sign changes.
    ends = np.abs(first) + np.abs(last)
    crossing = np.maximum(-first * last, 0.0) / np.where(ends > 0.0, ends, 1.0)
    share: Array = period * (0.5 * ends - crossing)
    return share


def least_disturbance(moved: Array, sped: Array, period: float) -> Array:
    r"""Return the least bound on disturbing accelerations that explain the motion in a period.

    Of all :math:`d(s)` with :math:`\int_0^h d\, ds = v` and :math:`\int_0^h (h - s)\, d\, ds = p`
    the one with the least :math:`\max |d|` has a constant absolute value, and changes sign once:

    .. math:: D = \frac{2 r + \sqrt{4 r^2 + h^2 v^2}}{h^2}, \qquad
              r = \big| p - \tfrac12 h v \big|

    For a constant d, r is 0 and D is :math:`|v| / h`.

    Parameters
    ----------
    moved, sped : (...,) ndarray
        Changes of position p [m or rad] and speed v [per s] in a period, minus those of the servo's
        held acceleration.
    period : float
        Control period h [s].

    Returns
    -------
    (...,) ndarray
        D [m/s² or rad/s²].
    """
    off = 2.0 * np.abs(moved - 0.5 * period * sped)
    least: Array = (off + np.hypot(off, period * sped)) / period**2
    return least
