r"""Exciting motions of a robot.

They are periodic motions within the limits of the joints, from which masses and inertias can be
identified best.

The coefficients of a Fourier series are chosen so that the information matrix of the base
parameters has the largest determinant (D-optimality: the smallest volume of the confidence
ellipsoid), which does not depend on the units of the parameters (J. Swevers, C. Ganseman, D. B.
Tükel, J. De Schutter and H. Van Brussel, Optimal robot excitation and identification, IEEE
Transactions on Robotics and Automation, 1997).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from psp3.checks import (
    Array,
    checked_count,
    checked_kind,
    checked_positive,
    checked_random,
    finite_rows,
    one_or_each,
    overflow_refused,
)
from psp3.errors import InvalidValue, PoorExcitation
from psp3.identification.base_parameters import UNREACHABLE, BaseParameters
from psp3.trajectories.fourier_series import FourierSeries, fourier_terms
from psp3.trajectories.trajectory import Trajectory

UNINFORMATIVE = 1e6
"""Value of the objective for motions that the robot cannot make, or that do not determine all base
parameters.
"""


SHARES = np.linspace(1.0, 0.5, 51)
"""Factors for the amplitudes of the best motion, tried in order until the robot can make it."""


class Information(NamedTuple):
    """What samples of a motion tell about base parameters.

    ``log_determinant`` is that of the information matrix :math:`Y^T Y` for unit noise of the
    forces, and depends on the units; ``condition`` is the condition number of Y with its columns
    scaled to the same length, and does not.
    """

    log_determinant: float
    condition: float


def information(
    base: BaseParameters, motion: Trajectory, t: ArrayLike, force_noise: ArrayLike = 1.0
) -> Information:
    r"""Return how well samples of a motion determine base parameters.

    .. math:: \log\det\big( Y^T \Sigma^{-1} Y \big), \qquad \operatorname{cond}(\Sigma^{-1/2} Y D)

    Parameters
    ----------
    base : BaseParameters
        What is to be found.
    motion : Trajectory
        The motion.
    t : (N,) array_like
        Times of the samples [s].
    force_noise : float or (n,) array_like
        Standard deviation of the measured forces [N or N m].

    Returns
    -------
    Information
        ``.log_determinant`` and ``.condition``, infinite if the samples do not determine all base
        parameters.

    Raises
    ------
    InvalidArray, InvalidValue
        If an argument is malformed.
    ClosureFailed, JointLimitExceeded, SingularConfiguration, UnreachablePose, UnreachableTip
        If the robot cannot make the motion.
    """
    noise = _noise(force_noise, len(base.unknowns.robot.actuated))
    positions, speeds, accelerations, _ = motion(t)
    return _information(base, (positions, speeds, accelerations), noise)


def _information(
    base: BaseParameters, joints: tuple[Array, Array, Array], noise: Array
) -> Information:
    weighted = (base.forces_of(*joints)[0] / noise[:, np.newaxis]).reshape(-1, len(base.columns))
    lengths = np.linalg.norm(weighted, axis=0)
    if len(weighted) < len(lengths) or (lengths == 0.0).any():
        return Information(-np.inf, np.inf)
    values = np.linalg.svd(weighted / lengths, compute_uv=False)
    if values[-1] <= 1e-13 * values[0]:
        return Information(-np.inf, np.inf)
    return Information(
        float(2.0 * (np.log(values).sum() + np.log(lengths).sum())), float(values[0] / values[-1])
    )


def _noise(force_noise: ArrayLike, n: int) -> Array:
    noise = one_or_each("force_noise", force_noise, n)
    if not (noise > 0.0).all():
        raise InvalidValue("force_noise", force_noise, "positive")
    return noise


def exciting_motion(
    base: BaseParameters,
    largest_speed: ArrayLike,
    largest_acceleration: ArrayLike,
    lower: ArrayLike | None = None,
    upper: ArrayLike | None = None,
    *,
    period: float = 5.0,
    harmonics: int = 5,
    force_noise: ArrayLike = 1.0,
    draws: int = 20,
    steps: int = 15,
    rng: np.random.Generator | None = None,
) -> FourierSeries:
    """Return a periodic motion for a good estimate of base parameters.

    The best of some random series is improved by a quasi-Newton method (L-BFGS-B). Each actuated
    joint stays within its limits at all times, not only at samples; if necessary, all its
    amplitudes are scaled down. At closely spaced samples, the loops must close within the limits of
    the other joints. The result is a good motion, but rarely the optimum.

    Parameters
    ----------
    base : BaseParameters
        What is to be found.
    largest_speed, largest_acceleration : float or (n,) array_like
        Limits of the actuated joints [m/s, m/s² or rad/s, rad/s²].
    lower, upper : (n,) array_like, optional
        Range of the actuated joints [m or rad]; the limits of the robot by default.
    period : float
        Time after which the motion repeats [s].
    harmonics : int
        Number of harmonics, 5 as in the source.
    force_noise : float or (n,) array_like
        Standard deviation of the measured forces; only their ratios matter [N or N m].
    draws, steps : int
        Number of random series, and largest number of steps of the quasi-Newton method, each of
        which evaluates slightly more than n (2 H + 1) series.
    rng : numpy.random.Generator, optional
        Source of the random series; by default the same at every call.

    Returns
    -------
    FourierSeries
        The motion, which :func:`psp3.simulate` can track.

    Raises
    ------
    InvalidArray, InvalidValue
        If an argument is malformed, or the range of a joint is empty or unlimited.
    PoorExcitation
        If no motion was found that the robot can make and that determines all base parameters.
    """
    from scipy.optimize import minimize

    checked_random(rng)
    with overflow_refused("period, noise and bounds of the motion"):
        search = _Search(
            base, largest_speed, largest_acceleration, lower, upper, period, harmonics, force_noise
        )
        checked_count("draws", draws)
        checked_count("steps", steps)
        source = np.random.default_rng(0) if rng is None else rng
        best = min((search.drawn(source) for _ in range(draws)), key=search.cost)
        found = minimize(search.cost, best, method="L-BFGS-B", options={"maxiter": steps})
        return search.makeable(min((best, found.x), key=search.cost))


class _Search:
    """The search for a series, which is given by numbers (n + 2 H n,).

    The numbers are centers, then sines and cosines, all as shares of half the range of each joint.
    """

    def __init__(
        self,
        base: BaseParameters,
        largest_speed: ArrayLike,
        largest_acceleration: ArrayLike,
        lower: ArrayLike | None,
        upper: ArrayLike | None,
        period: float,
        harmonics: int,
        force_noise: ArrayLike,
    ) -> None:
        checked_kind("base", base, BaseParameters, "what base_parameters(unknowns) returns")
        self._base, self._robot = base, base.unknowns.robot
        n = self._n = len(self._robot.actuated)
        limits = self._robot.limits
        # finite_rows is not used here, because limits of the robot may be infinite. The check of
        # the joint's range refuses these.
        self._lower = limits[0] if lower is None else finite_rows("lower", lower, n)
        self._upper = limits[1] if upper is None else finite_rows("upper", upper, n)
        if not (np.isfinite(self._upper - self._lower).all() and (self._upper > self._lower).all()):
            raise InvalidValue(
                "upper",
                self._upper.tolist(),
                f"greater than lower, {self._lower.tolist()}, and both finite",
            )
        self._bounds = [
            one_or_each(name, value, n)
            for name, value in (
                ("largest_speed", largest_speed),
                ("largest_acceleration", largest_acceleration),
            )
        ]
        for name, bound in zip(
            ("largest_speed", "largest_acceleration"), self._bounds, strict=True
        ):
            if not (bound > 0.0).all():
                raise InvalidValue(name, bound.tolist(), "positive")
        self._period, self._harmonics = (
            checked_positive("period", period),
            checked_count("harmonics", harmonics),
        )
        self._noise = _noise(force_noise, n)
        period, harmonics = self._period, self._harmonics
        points = 32 * harmonics
        self._close = np.arange(8 * points) * period / (8 * points)
        self._grid = fourier_terms(self._close[::8], period, harmonics)
        # Between M points of a grid, a trigonometric polynomial of degree H exceeds its values on
        # them at most by this factor (H. Ehlich and K. Zeller, Schwankung von Polynomen zwischen
        # Gitterpunkten, Mathematische Zeitschrift, 1964).
        self._beyond = 1.0 / np.cos(np.pi * harmonics / points)
        self._times = np.arange(4 * harmonics + 2) * period / (4 * harmonics + 2)

    def drawn(self, rng: np.random.Generator) -> Array:
        """Return the numbers of a random series that the robot can make."""
        slowness = 1.0 / np.repeat(np.arange(1, self._harmonics + 1), self._n)
        shape = np.concatenate(
            [
                0.3 * rng.uniform(-1.0, 1.0, self._n),
                *(rng.normal(size=slowness.size) * slowness for _ in range(2)),
            ]
        )
        for _ in range(30):
            if self.cost(shape) < UNINFORMATIVE:
                break
            # Toward the middle of the range, which the robot can more probably reach.
            shape = 0.8 * shape
        return shape

    def motion(self, numbers: Array) -> FourierSeries:
        """Return the series with its amplitudes reduced to fit the limits."""
        half = 0.5 * (self._upper - self._lower)
        shares = numbers.reshape(-1, self._n)
        # The center must not be at the ends of the range, where a joint could not move at all.
        center = self._lower + half * (1.0 + 0.95 * np.tanh(shares[0]))
        amplitudes = half * shares[1:]
        limits = [np.minimum(self._upper - center, center - self._lower), *self._bounds]
        excess = [
            self._beyond * np.abs(terms[:, 1:] @ amplitudes).max(axis=0) / limit
            for terms, limit in zip(self._grid, limits, strict=True)
        ]
        amplitudes = amplitudes / np.maximum(1.0, np.max(excess, axis=0))
        return FourierSeries(
            center,
            amplitudes[: self._harmonics],
            amplitudes[self._harmonics :],
            self._period,
            self._robot,
        )

    def cost(self, numbers: Array) -> float:
        """Return minus half the logarithm of the determinant of the information matrix."""
        motion = self.motion(numbers)
        try:
            found = _information(self._base, motion.joints(self._times), self._noise)
        except UNREACHABLE:
            return UNINFORMATIVE
        return min(-0.5 * found.log_determinant, UNINFORMATIVE)

    def makeable(self, numbers: Array) -> FourierSeries:
        """Return the series, made a little smaller if need be.

        That is necessary if the robot cannot make it between the samples of the search.
        """
        if self.cost(numbers) == UNINFORMATIVE:
            raise PoorExcitation(
                "base parameters, along any motion that was found", 0, len(self._base.columns)
            )
        motion = self.motion(numbers)
        for share in SHARES:
            smaller = FourierSeries(
                motion.center,
                share * motion.sines,
                share * motion.cosines,
                self._period,
                self._robot,
            )
            try:
                self._robot.configurations_along(smaller.joints(self._close)[0])
            except UNREACHABLE:
                continue
            return smaller
        raise PoorExcitation(
            "base parameters, along any motion that was found", 0, len(self._base.columns)
        )
