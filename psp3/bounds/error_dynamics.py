r"""How far a disturbance can drive the error of computed torque.

Under computed torque with gains :math:`k_p, k_v` every error :math:`e = a_d - a` obeys

.. math:: \ddot e + k_v \dot e + k_p e = -d(t), \qquad
          d = M^{-1} (\tau - \tau_{\text{ideal}}), \quad
          \tau_{\text{ideal}} = M (\ddot a_d + k_v \dot e + k_p e) + C \dot a + G,

where the residual acceleration d is what the force did that the servo had not asked for. So an
error is at most the greatest :math:`|d|` times the integral of the absolute impulse response, and
one disturbance, of that size and of the sign of the impulse response, comes arbitrarily near.

A digital controller sees the error once a period h and holds its force until the next. Then d is
taken beside the servo acceleration *that is held*, and the loop is the one in discrete time,

.. math:: x_{j+1} = F x_j - \int_0^h \binom{h - s}{1} d(jh + s)\, ds, \qquad
          x = \binom{e}{\dot e}, \quad
          F = \begin{pmatrix} 1 & h \\ 0 & 1 \end{pmatrix}
              - \binom{h^2 / 2}{h} \begin{pmatrix} k_p & k_v \end{pmatrix},

which is exact: held feedback is no part of d. What the desired acceleration changes within a
period is one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from psp3.checks import Array, checked_not_negative, checked_positive
from psp3.errors import InvalidValue

ROWS = 4096
"""Periods whose impulse responses are in memory at a time."""

NEGLIGIBLE = 1e-17
"""Share of a sum below which what is added is rounding."""

SLOWEST = 1e-6
"""Share of an error that must at least die out in a control period."""


@dataclass(frozen=True)
class ErrorDynamics:
    r"""The loop that every error obeys under computed torque.

    Parameters
    ----------
    kp, kv : float
        Gains of the servo [1/s²], [1/s].
    period : float
        Control period h [s]; 0 for a controller without one.

    Raises
    ------
    InvalidValue
        If a gain is not positive, or errors do not settle with gains and period: those of the
        matrix F do within :math:`\tfrac12 h k_p < k_v < 2 / h`.
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
        r"""Return the greatest error that disturbances of at most 1 m/s² can make from rest [s²].

        Without a period it is the integral of the absolute impulse response,

        .. math:: \int_0^\infty |g(t)|\, dt = \frac{1}{k_p} \begin{cases} 1 & \zeta \ge 1 \\
                  \coth \dfrac{\pi \zeta}{2 \sqrt{1 - \zeta^2}} & \zeta < 1 \end{cases}

        since at :math:`\zeta \ge 1` g has one sign, and else its half waves are a geometric series.
        With a period it is the sum of :func:`share_of_period` over all periods, to rounding.
        """
        if self.period == 0.0:
            ratio = self.damping_ratio
            if ratio >= 1.0:
                return 1.0 / self.kp
            return 1.0 / (self.kp * math.tanh(0.5 * math.pi * ratio / math.sqrt(1.0 - ratio**2)))
        block = powers(self.step, ROWS)
        rows, leap, total = block[:, 0], block[-1] @ self.step, 0.0
        # Ends, because errors settle: see SLOWEST.
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
    r"""Return what a disturbance of one period adds to a later error at most, in units of its size.

    .. math:: \int_0^h |\alpha (h - s) + \beta|\, ds

    Parameters
    ----------
    rows : (..., 2) ndarray
        What becomes of error and rate at the end of the period, :math:`(\alpha, \beta)`: the first
        row of a power of F.
    period : float
        Control period h [s].

    Returns
    -------
    (...,) ndarray
        [s²]
    """
    first, last = rows[..., 1] + period * rows[..., 0], rows[..., 1]
    # Of a straight line the mean size is that of its ends, or the areas of two triangles where it
    # changes its sign.
    ends = np.abs(first) + np.abs(last)
    crossing = np.maximum(-first * last, 0.0) / np.where(ends > 0.0, ends, 1.0)
    share: Array = period * (0.5 * ends - crossing)
    return share


def least_disturbance(moved: Array, sped: Array, period: float) -> Array:
    r"""Return the least bound on accelerations that explain what happened in a period.

    Of all :math:`d(s)` with :math:`\int_0^h d\, ds = v` and :math:`\int_0^h (h - s)\, d\, ds = p`
    the one of least :math:`\max |d|` has that size all the time, and changes its sign once:

    .. math:: D = \frac{2 r + \sqrt{4 r^2 + h^2 v^2}}{h^2}, \qquad
              r = \big| p - \tfrac12 h v \big|

    A constant one, r = 0, is :math:`|v| / h`.

    Parameters
    ----------
    moved, sped : (...,) ndarray
        What a period added to position p [m or rad] and speed v [per s] beside what the servo's
        held acceleration did.
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
