"""Time series as samples."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from fuzzy2.errors import InvalidValue
from fuzzy2.support.checks import Array, finite_rows, listed, reals, whole_number


class Lagged(NamedTuple):
    """Result of :func:`lagged`."""

    X: Array
    """Past values, (N, p), with one column for each lag in the given order."""
    y: Array
    """Future values, (N,) or (N, m) like the series."""


def lagged(series: ArrayLike, lags: Sequence[int], horizon: int = 1) -> Lagged:
    r"""Return samples for predicting a time series from its past values.

    Row t of the inputs is :math:`(x_{t - l_1}, \dots, x_{t - l_p})` and of the outputs :math:`x_{t
    + h}`, for all t for which the series contains both.

    Parameters
    ----------
    series : (T,) or (T, m) array_like
        Values at equal time steps. If there are several columns, each lag contributes all of them.
    lags : sequence of int
        Different whole numbers of at least 0; 0 stands for the present value.
    horizon : int
        Number of steps ahead that is predicted, at least 1.

    Returns
    -------
    Lagged
        Inputs ``X`` (N, p) and outputs ``y``, with N = T - max(lags) - horizon.

    Raises
    ------
    InvalidValue
        If the series is not finite or is too short, or if an argument is outside its range.

    Examples
    --------
    >>> X, y = lagged([0.0, 1.0, 4.0, 9.0, 16.0], lags=[0, 2], horizon=1)
    >>> X.tolist(), y.tolist()
    ([[4.0, 0.0], [9.0, 1.0]], [9.0, 16.0])
    """
    values = reals("series", series)
    if values.ndim not in (1, 2):
        raise InvalidValue("series", values.shape, "of shape (T,) or (T, m)")
    finite_rows("series", values if values.ndim == 2 else values[:, np.newaxis], True, "(T, m)")
    numbers = [whole_number("lags", lag, 0) for lag in listed("lags", lags, "whole numbers")]
    if not numbers or len(set(numbers)) != len(numbers):
        raise InvalidValue("lags", lags, "at least one, all different")
    ahead, furthest = whole_number("horizon", horizon, 1), max(numbers)
    if len(values) <= furthest + ahead:
        raise InvalidValue(
            "series", values.shape, f"longer than {furthest + ahead}, the largest lag and horizon"
        )
    times = np.arange(furthest, len(values) - ahead)
    past = [values[times - lag].reshape(len(times), -1) for lag in numbers]
    return Lagged(np.concatenate(past, axis=1), values[times + ahead])
