r"""A tube around the desired motion in which controlled runs stay.

Each run shows how large a disturbing acceleration, added to the servo's, explains the robot's
motion (:func:`residual_accelerations`). A given share of runs keeps a bound on it
(:mod:`psp3.bounds.conformal`). This bound times the greatest error from a unit disturbance
(:meth:`psp3.bounds.ErrorDynamics.worst_error`) is the half-width of the tube.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike

from psp3.bounds.conformal import checked_share, conformal_bound, scores_needed
from psp3.bounds.error_dynamics import (
    ErrorDynamics,
    least_disturbance,
    powers,
    share_of_period,
)
from psp3.checks import Array, finite_rows
from psp3.errors import InvalidValue
from psp3.robots.robot import Robot
from psp3.simulation.result import Result

FOR_PROPORTIONS = 10
"""One of this many runs, and at least one, sets the proportions of the coordinates' bounds."""

LEAST_PROPORTION = 1e-3
"""Least bound of a coordinate, as a share of the greatest."""

ROUNDING = 1e-9
"""Relative margin of the tube's width for rounding, so a run that just keeps its bounds keeps the
tube."""

EVEN = 1e-6
"""Relative difference of control periods that counts as rounding of times."""


def residual_accelerations(result: Result, kp: float, kv: float) -> Array:
    r"""Return the accelerations that disturbed a run under computed torque, for each period.

    They are the least D for which some :math:`|d(t)| \le D` in the period, added to the held servo
    acceleration, gives the observed motion,

    .. math:: \ddot a = \ddot a_d + k_v \dot e + k_p e + d,

    see :func:`psp3.bounds.error_dynamics.least_disturbance`. Neither forces nor a model are needed:
    d is :math:`M^{-1} (\tau - \tau_\text{ideal})` of the real robot. It includes the effects on
    :math:`\tau` of errors of the learned model, noise, encoders, delay, friction and force limits.
    It also includes changes of the desired acceleration and of the robot's dynamics within a
    period. It does not include the effect of holding the feedback, which
    :class:`psp3.bounds.ErrorDynamics` models.

    Parameters
    ----------
    result : Result
        A run of N samples at equal intervals.
    kp, kv : float
        Gains of its controller [1/s²], [1/s].

    Returns
    -------
    (N - 1, k) ndarray
        D for each period and each of the k commanded coordinates [m/s² or rad/s²].

    Raises
    ------
    InvalidValue
        If there are fewer than two samples, if they are not at equal intervals or not finite, or if
        errors do not settle with these gains.
    """
    loop = ErrorDynamics(kp, kv, period_of(result))
    errors, rates = errors_of(result)
    now = np.stack([errors, rates], axis=-1)
    left = now[1:] - now[:-1] @ loop.step.T
    return least_disturbance(left[..., 0], left[..., 1], loop.period)


def period_of(result: Result) -> float:
    """Return the control period of a run [s]; raise :class:`InvalidValue` if there is none."""
    if not isinstance(result, Result):
        raise InvalidValue("result", result, "a run as psp3.simulate returns it")
    if len(result.t) < 2:
        raise InvalidValue("result", f"{len(result.t)} samples", "a run of at least two samples")
    steps = np.diff(result.t)
    period = float(result.t[-1] - result.t[0]) / len(steps)
    # Differences of large times have fewer correct digits.
    rounding = EVEN * abs(period) + 4.0 * float(np.spacing(np.abs(result.t).max()))
    if not (period > 0.0 and np.abs(steps - period).max() <= rounding):
        raise InvalidValue("result", "times", "at even and ascending times, one a control period")
    return period


def errors_of(result: Result) -> tuple[Array, Array]:
    """Return the errors of positions and speeds of commanded coordinates, (N, k) each.

    Raise :class:`InvalidValue` if one is not finite.
    """
    wanted, k = result.desired, result.desired.positions.shape[-1]
    errors = wanted.positions - result.positions[:, :k], wanted.speeds - result.speeds[:, :k]
    for what, of in zip(("positions", "speeds"), errors, strict=True):
        if not np.isfinite(of).all():
            raise InvalidValue(
                "result",
                f"{what} that are not finite",
                "a complete run; one that did not reach its end has no tube, and calibration "
                "takes None for it",
            )
    return errors


class TrackingTube:
    r"""A tube around the desired motion in which a given share of runs stays.

    .. math:: |e_i(t_j)| \le \big| (F^j x_0)_e \big| + D_i
              \sum_{l < j} \int_0^h \big| (F^l)_{ee} (h - s) + (F^l)_{e \dot e} \big|\, ds

    at every control period, with F of :class:`psp3.bounds.ErrorDynamics`, the errors :math:`x_0` at
    the start, and the bounds :math:`D_i` of the residual accelerations. Every run that keeps these
    bounds keeps the tube. One tenth of the calibration runs gives the proportions of the bounds.
    Each other run gives the least factor that bounds all its coordinates in all its periods, and
    the conformal bound of these factors is used. So a new run stays in the tube for its whole
    duration and in all coordinates with a probability of at least ``share``, if it is exchangeable
    with the calibration runs: it must have the same robot, path, gains, period and duration, and
    everything random, including rules learned from noise, must be drawn from the same distribution.
    For other gains and paths nothing is guaranteed; see :meth:`with_gains`.

    Parameters
    ----------
    runs : iterable of (Result or None)
        Calibration runs, in an order that does not depend on their outcome. A run that did not
        reach its end is given as None, and counts as one that does not keep the tube.
    kp, kv : float
        Gains of their controller [1/s²], [1/s].
    share : float
        Share of runs that keep the tube, in (0, 1).

    Attributes
    ----------
    dynamics : ErrorDynamics
        Gains and control period.
    share : float
        Share of runs, as given.
    runs : int
        Number of calibration runs.
    residual : (k,) ndarray
        Bounds :math:`D_i` of the residual acceleration of each coordinate [m/s² or rad/s²].
    is_guaranteed : bool
        Whether the gains are those of the calibration runs.

    Raises
    ------
    InvalidValue
        If there are too few runs for the share, or too few of them reached their end; also if they
        differ in control period, duration or coordinates, or are not finite.

    Notes
    -----
    A result does not state its robot and gains. The caller must make sure that all runs have the
    same robot, and the gains given here.
    """

    def __init__(
        self, runs: Iterable[Result | None], kp: float, kv: float, share: float = 0.95
    ) -> None:
        if not isinstance(runs, Iterable) or isinstance(runs, np.ndarray):
            wanted = "a list of runs, each as psp3.simulate returns it"
            raise InvalidValue("runs", type(runs).__name__, wanted)
        given, self.share = list(runs), checked_share(share)
        self.runs, self.is_guaranteed = len(given), True
        first = -(-self.runs // FOR_PROPORTIONS)
        if self.runs - first < scores_needed(self.share):
            raise InvalidValue(
                "runs",
                self.runs,
                f"at least {runs_needed(self.share)} of them for a share of {self.share:g}; do "
                "more, or ask for a smaller share",
            )
        whole = [run for run in given if run is not None]
        if not any(run is not None for run in given[:first]):
            raise InvalidValue("runs", None, "such that one of the first tenth reached its end")
        period, width = period_of(whole[0]), whole[0].desired.positions.shape[-1]
        self.dynamics = ErrorDynamics(kp, kv, period)
        for run in whole[1:]:
            self._check(run, width)
            if len(run.t) != len(whole[0].t):
                raise InvalidValue(
                    "runs",
                    f"{len(run.t)} and {len(whole[0].t)} samples",
                    "of one duration; give None for a run that did not reach its end",
                )
        greatest = np.array(
            [
                np.full(width, math.inf)
                if run is None
                else residual_accelerations(run, kp, kv).max(axis=0)
                for run in given
            ]
        )
        proportions = greatest[:first][np.isfinite(greatest[:first, 0])].max(axis=0)
        proportions = np.maximum(proportions, LEAST_PROPORTION * proportions.max())
        factor = float(conformal_bound((greatest[first:] / proportions).max(axis=1), self.share))
        if math.isinf(factor):
            raise InvalidValue(
                "runs",
                f"{self.runs - len(whole)} of {self.runs} that did not reach their end",
                f"fewer of these for a share of {self.share:g}",
            )
        self.residual: Array = factor * proportions

    def __repr__(self) -> str:
        loop = self.dynamics
        law = "" if self.is_guaranteed else "gains of no calibration run, "
        return (
            f"{type(self).__name__}(kp={loop.kp:g}, kv={loop.kv:g}, period={loop.period:g} s, "
            f"{law}{100.0 * self.share:g} % of runs by {self.runs}, "
            f"residual={_listed(self.residual)}, width={_listed(self.width)})"
        )

    @property
    def width(self) -> Array:
        """Half-width of the tube of runs that start on the path, (k,) [m or rad]."""
        widths: Array = self.residual * self.dynamics.worst_error()
        return widths

    def around(self, result: Result) -> Array:
        """Return the half-width at every sample of a run, (N, k) [m or rad].

        It begins with the error of the run's first sample, and ends at :attr:`width`.

        Raises
        ------
        InvalidValue
            If the run has another control period or other coordinates, or is not finite.
        """
        self._check(result, len(self.residual))
        count, loop = len(result.t), self.dynamics
        rows = powers(loop.step, count)[:, 0]
        starts = np.stack([array[0] for array in errors_of(result)])
        shares = share_of_period(rows, loop.period)[:-1]
        grown = np.concatenate([[0.0], np.cumsum(shares)])
        bounds: Array = np.abs(rows @ starts) + grown[:, np.newaxis] * self.residual
        return (1.0 + ROUNDING) * bounds

    def holds(self, result: Result) -> bool:
        """Return whether a run stays within the tube at every sample, see :meth:`around`."""
        bounds = self.around(result)
        return bool((np.abs(errors_of(result)[0]) <= bounds).all())

    def with_gains(self, kp: float, kv: float) -> TrackingTube:
        """Return the tube for other gains, with unchanged bounds of the residual acceleration.

        It has no guarantee, because the effect of a wrong model on the force depends on the servo's
        command. Test it on runs with these gains.

        Raises
        ------
        InvalidValue
            If errors do not settle with these gains.
        """
        other = object.__new__(TrackingTube)
        other.__dict__ |= self.__dict__
        other.dynamics = ErrorDynamics(kp, kv, self.dynamics.period)
        other.is_guaranteed = self.is_guaranteed and other.dynamics == self.dynamics
        return other

    def tip_width(self, robot: Robot, positions: ArrayLike) -> Array:
        r"""Return the tip's greatest distance from a path in the tube, to first order in its width.

        .. math:: \max_{\sigma_i = \pm 1} \Big\lVert \sum_i \sigma_i \tfrac12 \big(
                  p(a + w_i u_i) - p(a - w_i u_i) \big) \Big\rVert

        with the unit vectors :math:`u_i` and the half-widths w: the Jacobian of the tip p, from
        differences over the tube, times the farthest corner of the tube. The error is of the order
        of w² times the second derivatives of p.

        Parameters
        ----------
        robot : Robot
            The robot, whose coordinates are all commanded.
        positions : (..., k) array_like
            Desired positions along the path [m or rad].

        Returns
        -------
        (...,) ndarray
            [m]

        Raises
        ------
        InvalidValue
            If the robot has no frame ``tip``, or other coordinates.
        UnreachablePose, ClosureFailed, JointLimitExceeded
            If the tube leaves the poses that the robot can take.
        """
        width = self.width
        k = len(width)
        if not hasattr(robot, "reference"):
            raise InvalidValue("robot", robot, "a robot, as psp3.load returns it")
        if len(robot.reference) != k:
            raise InvalidValue("robot", robot.title, f"one of {k} coordinates, all commanded")
        path = finite_rows("positions", positions, k)
        ways = [0.5 * (robot.tip(path + step) - robot.tip(path - step)) for step in np.diag(width)]
        if not np.isfinite(ways).all():
            raise InvalidValue("robot", robot.title, "one with a frame named tip")
        farthest = np.zeros(path.shape[:-1])
        # Opposite corners are equally far.
        for signs in itertools.product((1.0, -1.0), repeat=k - 1):
            corner = ways[0] + sum(sign * way for sign, way in zip(signs, ways[1:], strict=True))
            np.maximum(farthest, np.linalg.norm(corner, axis=-1), out=farthest)
        return farthest

    def _check(self, run: Result, width: int) -> None:
        period, own = period_of(run), self.dynamics.period
        if abs(period - own) > EVEN * own:
            raise InvalidValue("result", f"a period of {period:g} s", f"one of {own:g} s")
        found = run.desired.positions.shape[-1]
        if found != width:
            raise InvalidValue("result", f"{found} coordinates", f"one of a robot with {width}")


def runs_needed(share: float) -> int:
    """Return the least number of calibration runs for a tube that a share of runs keeps.

    See :class:`TrackingTube`.
    """
    # Without one in ten, rounded up, 9 n / 10 runs are left, rounded down.
    return -(-FOR_PROPORTIONS * scores_needed(share) // (FOR_PROPORTIONS - 1))


def _listed(values: Array) -> str:
    return "[" + ", ".join(f"{value:.3g}" for value in values) + "]"
