r"""Masses and inertias from measured positions and forces.

The measurements are those of the actuated joints. Uncertainties of the results are estimated, too.

A Fourier series is fitted to the noisy positions of a periodic motion and differentiated. The
forces are then linear in the base parameters (C. G. Atkeson, C. H. An and J. M. Hollerbach, 1986;
J. Swevers, C. Ganseman, D. B. Tükel, J. De Schutter and H. Van Brussel, 1997).
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fuzzy2.support.described import Described
from psp3.checks import (
    Array,
    checked_kind,
    checked_not_negative,
    checked_positive,
    finite_rows,
    overflow_refused,
)
from psp3.closure.rank import numerical_rank
from psp3.errors import CorrelatedResiduals, InvalidArray, PoorExcitation
from psp3.identification.base_parameters import BaseParameters
from psp3.identification.physical_consistency import Body, bodies
from psp3.identification.residuals import deviation_from_independence, lag_one_correlation
from psp3.trajectories.fourier_series import (
    FittedSeries,
    FourierSeries,
    fit_fourier_series,
    fourier_terms,
)
from psp3.trajectories.motion import finite_times

CONFIDENCE = 0.95
"""Share of intervals that contain the true value."""

REFINEMENTS = 3
"""How often the noise of each joint's force is estimated again from the residuals; it changes
little after the first time.
"""

FALSE_WARNINGS = 0.01
"""Share of identifications with independent noise that falsely warn of correlated residuals."""

ROUNDING = 1e-10
"""Residuals below this share of the largest force are rounding, not noise."""

SENSITIVITY_SAMPLES = 100
"""Number of samples at which the effect of position errors is computed; it varies as slowly as the
motion.
"""


@dataclass(frozen=True, eq=False, repr=False)
class Identified(Described):
    """Base parameters found from measurements.

    Parameters
    ----------
    base : BaseParameters
        What was to be found.
    values : (r,) ndarray
        The estimates, in the order of ``base.names``.
    covariance : (r, r) ndarray
        Their covariance: that from noise of the forces plus that from noise of the positions, to
        first order.
    force_noise : (n,) ndarray
        Standard deviation of the residuals of each joint's measured force [N or N m].
    position_noise : (n,) ndarray
        Standard deviation of the measured positions about the fitted motion [m or rad].
    degrees_of_freedom : int
        Number of measured forces less that of estimates.
    condition : float
        Condition number of the weighted regressor with its columns scaled to the same length.
    motion : FourierSeries
        The motion that was fitted to the measured positions.
    residual_correlation : (n,) ndarray
        Correlation of each joint's residuals with those of the preceding sample. Standard errors
        and intervals are valid for independent noise, for which it is near zero.
    """

    base: BaseParameters
    values: Array
    covariance: Array
    force_noise: Array
    position_noise: Array
    degrees_of_freedom: int
    condition: float
    motion: FourierSeries
    residual_correlation: Array

    def _facts(self) -> dict[str, Any]:
        return {
            "parameters": tuple(
                f"{name} = {value:.4g} ± {error:.2g}"
                for name, value, error in zip(
                    self.base.names, self.values, self.standard_errors, strict=True
                )
            ),
            "condition": self.condition,
        }

    @property
    def standard_errors(self) -> Array:
        """Standard deviations of the estimates, (r,)."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def intervals(self) -> Array:
        """Ends of the 95 % confidence intervals by Student's distribution, (r, 2)."""
        from scipy.stats import t

        reach = float(t.ppf(0.5 + 0.5 * CONFIDENCE, self.degrees_of_freedom)) * self.standard_errors
        return np.stack([self.values - reach, self.values + reach], axis=-1)

    @property
    def unknowns(self) -> Array:
        """The unknowns with the estimated base parameters that are nearest to the model's, (p,).

        See :meth:`BaseParameters.nearest`.
        """
        return self.base.nearest(self.values)

    @property
    def bodies(self) -> tuple[Body, ...]:
        """The robot's bodies with these unknowns; each tells whether it can exist.

        If one cannot, another choice of the undetermined combinations may be possible.
        """
        return bodies(self.base.unknowns.robot, self.base.unknowns.expand(self.unknowns))


def identify(
    base: BaseParameters,
    t: ArrayLike,
    positions: ArrayLike,
    forces: ArrayLike,
    period: float,
    harmonics: int = 5,
    held: float = 0.0,
) -> Identified:
    r"""Return base parameters by weighted least squares.

    The data are a measured periodic motion and the forces that caused it.

    .. math::

        \hat\beta = (Y^T \Sigma^{-1} Y)^{-1}\, Y^T \Sigma^{-1}\, (\tau - \tau_0), \qquad
        \operatorname{cov} \hat\beta = A + A Y^T \Sigma^{-1} J\, \Gamma\, J^T \Sigma^{-1} Y A, \quad
        A = (Y^T \Sigma^{-1} Y)^{-1}

    with :math:`\tau_0` the forces of the known parameters, :math:`\Sigma` the noise of each joint's
    force, estimated from the residuals, :math:`\Gamma` the covariance of the Fourier coefficients
    and :math:`J` the derivative of the forces by them. Y itself is noisy, which causes an error of
    second order in the position noise; this error is not corrected.

    Parameters
    ----------
    base : BaseParameters
        What is to be found.
    t : (N,) array_like
        Times of the measurements [s], after the motion has become periodic; equal steps over whole
        periods are best.
    positions, forces : (N, n) array_like
        Measured positions [m or rad] and forces [N or N m] of the actuated joints. Errors are
        assumed to be independent.
    period : float
        Time after which the motion repeats [s].
    harmonics : int
        Number of harmonics of the motion. A controller that tracks badly adds harmonics to the
        desired ones.
    held : float
        Time for which each force was held constant after its sample, as a digital controller does
        [s]. The force then corresponds to the motion half of this time later.

    Returns
    -------
    Identified

    Raises
    ------
    InvalidArray, InvalidValue
        If an argument is malformed.
    PoorExcitation
        If the measurements do not determine all base parameters, or do not determine the motion.
    ClosureFailed, JointLimitExceeded, SingularConfiguration, UnreachablePose
        If the robot cannot make the fitted motion.

    Warns
    -----
    CorrelatedResiduals
        If neighboring residuals of a joint in time order are more correlated than in 1 % of
        identifications with independent noise of forces and positions. There is no warning about
        negative correlation, which makes intervals too wide, unless samples are hardly denser than
        the harmonics.
    """
    checked_kind("base", base, BaseParameters, "what base_parameters(unknowns) returns")
    period, held = checked_positive("period", period), checked_not_negative("held", held)
    with overflow_refused("positions, forces and period"):
        return _identified(base, t, positions, forces, period, harmonics, held)


def _identified(
    base: BaseParameters,
    t: ArrayLike,
    positions: ArrayLike,
    forces: ArrayLike,
    period: float,
    harmonics: int,
    held: float,
) -> Identified:
    robot = base.unknowns.robot
    measured = finite_rows("forces", forces, len(robot.actuated))
    fitted = fit_fourier_series(t, positions, period, harmonics, robot)
    if measured.shape != np.shape(positions):
        raise InvalidArray(
            "forces", f"{np.shape(positions)}, one row for each of positions", forces
        )
    times = finite_times(t) + 0.5 * held
    regressors, known = base.forces_of(*fitted.motion.joints(times))
    values, information, noise, condition = _weighted_least_squares(regressors, measured - known)
    covariance = np.asarray(np.linalg.inv(information), dtype=np.float64)
    chosen = np.unique(
        np.linspace(0.0, len(times) - 1.0, min(len(times), SENSITIVITY_SAMPLES))
        .round()
        .astype(np.int64)
    )
    derivatives = _derivatives_of_forces(base, values, fitted.motion, times[chosen])
    effects = covariance @ _effects_of_coefficients(
        derivatives, fitted, times, chosen, regressors, noise
    )
    for effect, size in zip(effects, fitted.noise, strict=True):
        covariance = covariance + size**2 * effect @ fitted.covariance @ effect.T
    residuals = measured - known - regressors @ values
    order = np.argsort(times, kind="stable")
    if np.abs(residuals).max() > ROUNDING * np.abs(measured).max():
        _warn_of_correlation(
            robot.actuated,
            residuals[order],
            regressors[order],
            _errors_of_motion(derivatives, fitted, times, chosen)[:, order],
        )
    return Identified(
        base,
        values,
        covariance,
        noise,
        fitted.noise,
        measured.size - values.size,
        condition,
        fitted.motion,
        lag_one_correlation(residuals[order]),
    )


def _warn_of_correlation(
    joints: Sequence[str], residuals: Array, regressors: Array, shared: Array
) -> None:
    """Warn about the joint with the most significant correlation of its residuals in time order."""
    from scipy.stats import norm

    deviations = np.array(
        [
            deviation_from_independence(residuals[:, joint], regressors[:, joint], shared[joint])
            for joint in range(len(joints))
        ]
    )
    # The probability that any of n joints exceeds the limit by chance is the given one.
    limit = float(norm.ppf((1.0 - FALSE_WARNINGS) ** (1.0 / len(joints))))
    worst = int(deviations.argmax())
    if deviations[worst] > limit:
        samples, correlation = len(residuals), float(lag_one_correlation(residuals)[worst])
        effective = samples * (1.0 - correlation) / (1.0 + correlation)
        warnings.warn(
            CorrelatedResiduals(
                joints[worst], correlation, float(deviations[worst]), samples, effective
            ),
            stacklevel=3,
        )


def _errors_of_motion(
    derivatives: Array, fitted: FittedSeries, times: Array, chosen: NDArray[np.int64]
) -> Array:
    """Return the effect of errors of the fitted motion on each joint's force, (n, N, n (2 H + 1)).

    The errors are independent errors of every joint's coefficients, with standard deviation 1.
    """
    by_time = np.argsort(times[chosen])
    nodes = times[chosen][by_time]
    after = np.clip(np.searchsorted(nodes, times), 1, len(nodes) - 1)
    gap = nodes[after] - nodes[after - 1]
    share = np.clip((times - nodes[after - 1]) / np.where(gap > 0.0, gap, 1.0), 0.0, 1.0)
    share = share[:, np.newaxis]
    between = (1.0 - share) * derivatives[:, :, by_time[after - 1]]
    between += share * derivatives[:, :, by_time[after]]
    terms = np.stack(fourier_terms(times, fitted.motion.period, fitted.motion.harmonics))
    axes, variances, _ = np.linalg.svd(fitted.covariance)
    terms = terms @ (axes * np.sqrt(variances))
    errors: Array = np.einsum("djsi,dsk,j->isjk", between, terms, fitted.noise)
    return errors.reshape(*errors.shape[:2], -1)


def _effects_of_coefficients(
    derivatives: Array,
    fitted: FittedSeries,
    times: Array,
    chosen: NDArray[np.int64],
    regressors: Array,
    noise: Array,
) -> Array:
    r"""Return :math:`Y^T \Sigma^{-1} J`.

    The result is for the Fourier coefficients of each joint, (n, r, 2 H + 1).
    """
    terms = np.stack(fourier_terms(times[chosen], fitted.motion.period, fitted.motion.harmonics))
    # Every selected sample represents those that are not selected.
    weighted = regressors[chosen] / noise[:, np.newaxis] ** 2 * (len(times) / len(chosen))
    effects: Array = np.einsum("sir,djsi,dsk->jrk", weighted, derivatives, terms, optimize=True)
    return effects


def _derivatives_of_forces(
    base: BaseParameters, values: Array, motion: FourierSeries, times: Array
) -> Array:
    """Return the derivatives of the forces by position, speed and acceleration.

    They are those of each joint, (3, n, S, n), by central differences.
    """
    state = np.stack(motion.joints(times))
    n = state.shape[-1]
    travel = float(np.abs(state[0] - motion.center).max(initial=0.0))
    # Forces are quadratic in speeds and linear in accelerations, so differences of any size are
    # exact for these.
    steps = (1e-4 * travel if travel > 0.0 else 1e-6, 1.0, 1.0)
    derivatives = np.empty((3, n, *state.shape[1:]))
    for order, step in enumerate(steps):
        for joint in range(n):
            shift = np.zeros_like(state)
            shift[order, :, joint] = step
            (after, known_after), (before, known_before) = (
                base.forces_of(*(state + shift)),
                base.forces_of(*(state - shift)),
            )
            derivatives[order, joint] = ((after - before) @ values + known_after - known_before) / (
                2.0 * step
            )
    return derivatives


def _weighted_least_squares(regressors: Array, forces: Array) -> tuple[Array, Array, Array, float]:
    """Return estimates, their information, the noise of joint forces and the condition.

    The information matrix, the noise of each joint's force and the condition number.
    """
    _, n, count = regressors.shape
    noise = np.ones(n)
    values, condition = np.zeros(count), np.inf
    lengths = np.linalg.norm(regressors.reshape(-1, count), axis=0)
    lengths[lengths == 0.0] = 1.0
    for _ in range(REFINEMENTS):
        weighted = (regressors / noise[:, np.newaxis] / lengths).reshape(-1, count)
        left, sizes, right = np.linalg.svd(weighted, full_matrices=False)
        rank = numerical_rank(sizes)
        if rank < count or len(weighted) <= count:
            raise PoorExcitation(
                "base parameters and the noise", min(rank, len(weighted) - 1), count
            )
        condition = float(sizes[0] / sizes[-1])
        values = (right.T / sizes) @ (left.T @ (forces / noise).ravel()) / lengths
        squares = np.sum((forces - regressors @ values) ** 2, axis=0)
        # The fit reduces the degrees of freedom of each joint's residuals by the joint's share of
        # the estimates.
        taken = np.sum((left**2).reshape(-1, n, count), axis=(0, 2))
        if not (len(forces) - taken > 1e-6).all():
            raise PoorExcitation(
                "base parameters and the noise of each joint", len(weighted) - 1, count
            )
        noise = np.sqrt(squares / (len(forces) - taken))
        # Forces without any noise still need a weight.
        noise = np.maximum(noise, 1e-14 * np.abs(forces).max(initial=1e-300))
    weighted = (regressors / noise[:, np.newaxis]).reshape(-1, count)
    return values, weighted.T @ weighted, noise, condition
