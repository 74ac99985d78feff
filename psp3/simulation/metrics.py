"""Figures of merit of a simulation."""

from __future__ import annotations

import numpy as np

from psp3.checks import Array
from psp3.errors import InvalidValue
from psp3.published import THESIS_SAMPLING_PERIOD
from psp3.simulation.result import Result


def sum_of_squared_errors(result: Result, sampling_period: float = THESIS_SAMPLING_PERIOD) -> float:
    r"""Return :math:`\sum_k \lVert e(t_k) \rVert^2` over the screws, as Table 6.3 counts it.

    Parameters
    ----------
    result : Result
        A simulation.
    sampling_period : float
        Time between the samples that are summed [s]. 0.05 s makes the PD row, which is its sag and
        nothing else, come out as printed.

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


def largest_tip_error(result: Result) -> float:
    """Return the largest distance between the desired and the actual tip [m]."""
    return float(np.linalg.norm(result.desired.tip - result.tip, axis=-1).max())


def _errors(result: Result) -> Array:
    """Return the errors of the coordinates of which a motion is desired, which are the first."""
    wanted = result.desired.positions
    return wanted - result.positions[..., : wanted.shape[-1]]
