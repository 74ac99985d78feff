r"""Periodic motions of the actuated joints as finite Fourier series.

The module also fits a series to noisy measurements.

Differentiating the fitted series gives the derivatives of a periodic motion without delay and
without amplified noise (J. Swevers, C. Ganseman, D. B. Tükel, J. De Schutter and H. Van Brussel,
Optimal robot excitation and identification, IEEE Transactions on Robotics and Automation, 1997).
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from psp3.checks import Array, checked_count, checked_positive, finite_rows, one_row
from psp3.closure.rank import numerical_rank
from psp3.errors import InvalidArray, PoorExcitation
from psp3.robots.robot import Robot
from psp3.trajectories.motion import finite_times
from psp3.trajectories.trajectory import Trajectory


class FourierSeries(Trajectory):
    r"""A periodic motion of the actuated joints, with H harmonics of one base frequency.

    .. math:: a(t) = c + \sum_{k=1}^H \big( s_k \sin k \omega t + c_k \cos k \omega t \big), \qquad
              \omega = 2\pi / T

    Parameters
    ----------
    center : (n,) array_like
        Constant term c [m or rad].
    sines, cosines : (H, n) array_like
        Amplitudes :math:`s_k` and :math:`c_k` [m or rad].
    period : float
        Time T after which the motion repeats [s].
    robot : Robot, optional
        See :class:`psp3.trajectories.trajectory.Trajectory`.

    Raises
    ------
    InvalidArray, InvalidValue
        If an array is not finite or has another shape, or the period is not positive.
    """

    def __init__(
        self,
        center: ArrayLike,
        sines: ArrayLike,
        cosines: ArrayLike,
        period: float,
        robot: Robot | None = None,
    ) -> None:
        super().__init__(robot, "joints")
        self.center = one_row("center", center, self.width)
        self.sines, self.cosines = (
            finite_rows("sines", sines, self.width),
            finite_rows("cosines", cosines, self.width),
        )
        if self.sines.ndim != 2 or self.sines.shape != self.cosines.shape or not len(self.sines):
            raise InvalidArray(
                "sines and cosines", f"(H, {self.width}) with H of at least 1", cosines
            )
        self.period = checked_positive("period", period)

    def _shape(self) -> dict[str, Any]:
        return {
            "period": f"{self.period:g} s",
            "harmonics": self.harmonics,
            "center": self.center,
        }

    @property
    def harmonics(self) -> int:
        """Number H of harmonics."""
        return len(self.sines)

    def joints(self, t: ArrayLike) -> tuple[Array, Array, Array]:
        """Return positions, speeds and accelerations (..., n) of the joints at times (...,).

        They are returned even if the robot cannot take them.

        Raises
        ------
        InvalidArray
            If a time is not finite.
        """
        return self._path(finite_times(t))

    def _path(self, t: Array) -> tuple[Array, Array, Array]:
        coefficients = np.concatenate([self.center[np.newaxis], self.sines, self.cosines])
        value, rate, curvature = (
            terms @ coefficients for terms in fourier_terms(t, self.period, self.harmonics)
        )
        return value, rate, curvature


def fourier_terms(t: ArrayLike, period: float, harmonics: int) -> tuple[Array, Array, Array]:
    """Return the terms of a Fourier series at times (...,) and their first two derivatives.

    Each of the three is (..., 2 H + 1).

    The order is the constant, the sines, the cosines.
    """
    times = np.asarray(t, dtype=np.float64)[..., np.newaxis]
    rates = 2.0 * np.pi / period * np.arange(1, harmonics + 1)
    sine, cosine, zero = np.sin(rates * times), np.cos(rates * times), np.zeros_like(times)
    return (
        np.concatenate([zero + 1.0, sine, cosine], axis=-1),
        np.concatenate([zero, rates * cosine, -rates * sine], axis=-1),
        np.concatenate([zero, -(rates**2) * sine, -(rates**2) * cosine], axis=-1),
    )


class FittedSeries(NamedTuple):
    """A series near measured positions, ``.motion``, with its uncertainty.

    ``noise`` (n,) is the standard deviation of the measured positions about it [m or rad];
    ``covariance`` (2 H + 1, 2 H + 1) that of the coefficients of a joint for noise of standard
    deviation 1, in the order of :func:`fourier_terms`.
    """

    motion: FourierSeries
    noise: Array
    covariance: Array


def fit_fourier_series(
    t: ArrayLike, positions: ArrayLike, period: float, harmonics: int, robot: Robot
) -> FittedSeries:
    r"""Return the Fourier series nearest to measured positions in the sense of least squares.

    Parameters
    ----------
    t : (N,) array_like
        Times of the measurements [s], over a period or more for a well-determined series.
    positions : (N, n) array_like
        Measured positions of the actuated joints [m or rad], whose errors are assumed to be
        independent.
    period : float
        Time after which the motion repeats [s].
    harmonics : int
        Number H of fitted harmonics. Too few omit a part of the motion, and too many include noise.
    robot : Robot
        Whose motion it is.

    Returns
    -------
    FittedSeries
        ``.motion .noise .covariance``.

    Raises
    ------
    InvalidArray, InvalidValue
        If an argument is malformed.
    PoorExcitation
        If the times do not determine 2 H + 1 coefficients.
    """
    times, rows = finite_times(t), finite_rows("positions", positions, len(robot.actuated))
    checked_positive("period", period)
    count = 2 * checked_count("harmonics", harmonics) + 1
    if times.ndim != 1 or rows.shape != (times.size, len(robot.actuated)):
        raise InvalidArray("t and positions", f"(N,) and (N, {len(robot.actuated)})", positions)
    terms, _, _ = fourier_terms(times, period, harmonics)
    left, values, right = np.linalg.svd(terms, full_matrices=False)
    rank = numerical_rank(values)
    # One more measurement than coefficients is needed to estimate the noise.
    if rank < count or times.size <= count:
        raise PoorExcitation(
            "Fourier coefficients and their noise", min(rank, times.size - 1), count
        )
    coefficients = (right.T / values) @ (left.T @ rows)
    noise = np.sqrt(np.sum((rows - terms @ coefficients) ** 2, axis=0) / (times.size - count))
    center, sines, cosines = np.split(coefficients, [1, 1 + harmonics])
    return FittedSeries(
        FourierSeries(center[0], sines, cosines, period, robot),
        noise,
        (right.T / values**2) @ right,
    )
