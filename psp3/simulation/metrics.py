"""Figures of merit of a simulation."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from psp3.checks import Array
from psp3.errors import InvalidValue
from psp3.published import THESIS_SAMPLING_PERIOD
from psp3.simulation.result import Result

METRICS = (
    "sum_of_squared_errors",
    "integral_of_squared_error",
    "rms_error",
    "settled_error",
    "largest_error",
    "rms_tip_error",
    "largest_tip_error",
    "effort",
    "largest_torque",
    "coverage",
    "fallbacks",
    "left_stroke",
    "diverged",
    "end_time",
)
"""Names of the metrics of :func:`measured`."""


def measured(result: Result, samples: int, limits: tuple[Array, Array]) -> dict[str, float]:
    r"""Return the figures of merit of a run of any robot, which may have ended early.

    Parameters
    ----------
    result : Result
        A simulation.
    samples : int
        Number of samples of a complete run.
    limits : tuple of (p,) ndarray
        Lowest and highest positions of the joints.

    Returns
    -------
    dict of float
        Metrics by name, in the order of ``METRICS``. Of the joint errors [m or rad]: the sum of
        squares at one sample per 0.05 s, the integral of squares over time, the root mean square
        over the run and over its second half (``settled_error``), and the largest error of a joint.
        Of the tip [m]: root mean square and largest error, NaN without a tip. Effort :math:`\int
        \lVert\tau\rVert^2 dt` and largest force of a motor [N or N m]. The share of steps inside
        the trained range, and the share that fell back on the average over the rules. 1 if a joint
        left its limits. 1 if the run diverged, which means that it ended early or with forces that
        are not finite. The time when it ended [s]. Errors and forces of runs that diverged are NaN.
    """
    count = len(result.t)
    diverged = count < samples or not count or not np.isfinite(result.torque).all()
    values = [math.nan] * 9
    if not diverged:
        values = [
            sum_of_squared_errors(result),
            integral_of_squared_error(result),
            rms_error(result),
            settled_error(result),
            largest_error(result),
            rms_tip_error(result),
            largest_tip_error(result),
            effort(result),
            float(np.abs(result.torque).max()),
        ]
    lower, upper = limits
    outside = (result.positions < lower) | (result.positions > upper)
    shares = [_share(flags, count) for flags in (result.covered, result.fell_back)]
    if result.covered is None and count:
        # An untrained controller has no range to leave and no fallback.
        shares = [1.0, 0.0]
    values += [*shares, float(outside.any()), float(diverged)]
    return dict(zip(METRICS, [*values, float(result.t[-1]) if count else 0.0], strict=True))


def _share(flags: NDArray[np.bool_] | None, count: int) -> float:
    return float(flags.mean()) if flags is not None and count else math.nan


def sum_of_squared_errors(result: Result, sampling_period: float = THESIS_SAMPLING_PERIOD) -> float:
    r"""Return :math:`\sum_k \lVert e(t_k) \rVert^2` over the screws, as Table 6.3 counts it.

    Parameters
    ----------
    result : Result
        A simulation.
    sampling_period : float
        Time between the summed samples [s]. With 0.05 s the PD row, which is only its sag, has the
        printed value.

    Returns
    -------
    float
        Sum of squared errors [m²].

    Raises
    ------
    InvalidValue
        If the sampling period is not a multiple of the simulation's control period.
    """
    period = float(result.t[1] - result.t[0]) if result.t.size > 1 else sampling_period
    every = round(sampling_period / period)
    if every < 1 or abs(every * period - sampling_period) > 1e-9 * sampling_period:
        raise InvalidValue(
            "sampling_period", sampling_period, f"a multiple of the control period, {period:.6g} s"
        )
    error = _errors(result)[::every]
    return float((error**2).sum())


def integral_of_squared_error(result: Result) -> float:
    r"""Return :math:`\int \lVert e \rVert^2 dt` over the screws by the trapezoidal rule [m² s]."""
    error = _errors(result)
    return float(np.trapezoid((error**2).sum(axis=-1), result.t))


def rms_error(result: Result) -> float:
    r"""Return the root mean square of :math:`\lVert e \rVert` over the samples [m]."""
    error = _errors(result)
    return float(np.sqrt((error**2).sum(axis=-1).mean()))


def settled_error(result: Result) -> float:
    r"""Return the root mean square of :math:`\lVert e \rVert` over the second half [m or rad]."""
    error = _errors(result)[len(result.t) // 2 :]
    return float(np.sqrt((error**2).sum(axis=-1).mean()))


def largest_error(result: Result) -> float:
    """Return the largest error of a joint [m or rad]."""
    return float(np.abs(_errors(result)).max())


def effort(result: Result) -> float:
    r"""Return :math:`\int \lVert\tau\rVert^2 dt` by the trapezoidal rule [N² s]."""
    return float(np.trapezoid((result.torque**2).sum(axis=-1), result.t))


def rms_tip_error(result: Result) -> float:
    """Return the root mean square of the distance between the desired and the actual tip [m]."""
    distance = np.linalg.norm(result.desired.tip - result.tip, axis=-1)
    return float(np.sqrt((distance**2).mean()))


def largest_tip_error(result: Result) -> float:
    """Return the largest distance between the desired and the actual tip [m]."""
    return float(np.linalg.norm(result.desired.tip - result.tip, axis=-1).max())


def _errors(result: Result) -> Array:
    """Return the errors of the coordinates with a desired motion, which come first."""
    wanted = result.desired.positions
    return wanted - result.positions[..., : wanted.shape[-1]]
