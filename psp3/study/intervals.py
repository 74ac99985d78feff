"""Ends of 95 % intervals of means, of ratios of means, of medians and of geometric means.

``docs/make_intervals.py`` measures how often these intervals hold the true value on skewed data.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from psp3.checks import Array, checked_random

CONFIDENCE = 0.95
"""Nominal share of intervals that hold the true value."""

MEASURED_COVERAGE: Mapping[str, float] = MappingProxyType(
    {
        "mean": 0.94,
        "median": 0.94,
        "difference of means": 0.92,
        "ratio of means": 0.94,
        "ratio of geometric means": 0.95,
    }
)
"""Measured share of intervals that held the true value, by estimand, over 4000 simulated sets of 30
skewed pairs like those of the study: the least over noise levels, from
``docs/concepts/intervals.md``.
"""

MEASURED_COVERAGE_OF_TEN: Mapping[str, float] = MappingProxyType(
    {
        "mean": 0.931,
        "median": 0.94,
        "difference of means": 0.915,
        "ratio of means": 0.955,
        "ratio of geometric means": 0.959,
    }
)
"""The same for sets of ten pairs like those of the study at 20 dB."""

RESAMPLES = 9999
"""Number of bootstrap resamples."""

NUMBERS_AT_A_TIME = 1_000_000
"""Size of the largest array of resamples, which bounds the memory of an estimate."""

NO_SPREAD = 1e-12
"""Relative standard error below which values differ by rounding only."""


class Interval(NamedTuple):
    """An interval from ``.low`` to ``.high``, and its ``.method``."""

    low: float
    high: float
    method: str


def coverage_in_words(*estimands: str, seeds: int = 30) -> str:
    """Return how often intervals of 95 % held the true value, to be printed beside them.

    Parameters
    ----------
    estimands : str
        Estimands, names in :data:`MEASURED_COVERAGE`.
    seeds : int
        Number of seeds. For fewer than thirty, the coverage measured with ten is reported.

    Returns
    -------
    str
        A clause without a full stop: "in simulations of 30 such seeds they held the truth in ...".
    """
    number, measured = (30, MEASURED_COVERAGE) if seeds >= 30 else (10, MEASURED_COVERAGE_OF_TEN)
    shares = [f"{100.0 * measured[name]:.3g} % ({name})" for name in estimands]
    return f"in simulations of {number} such seeds they held the truth in {', '.join(shares)}"


def bootstrap_t(
    x: Array, y: Array, logarithmic: bool, rng: np.random.Generator | None = None
) -> Interval:
    r"""Return the symmetric bootstrap-t interval of the mean of x over that of y.

    .. math:: P\big( |\hat\theta^* - \hat\theta| / s^* \le q \big) = 0.95, \qquad
              \hat\theta - q s \le \theta \le \hat\theta + q s

    with :math:`\theta` the ratio or its logarithm, and its standard error by the delta method,

    .. math:: s^2 = \frac{1}{N (N - 1)} \sum_k \Big( \frac{x_k - \hat r y_k}{\bar y} \Big)^2,
              \qquad \hat r = \bar x / \bar y,

    which is divided by :math:`\hat r^2` for the logarithm. Stars mark resamples of whole pairs.

    Parameters
    ----------
    x, y : (N,) ndarray
        Pairs, at least two. With ones for y, the ratio is the mean of x.
    logarithmic : bool
        Whether the interval is computed on the logarithm of the ratio; all numbers must then be
        positive.
    rng : numpy.random.Generator, optional
        Source of the resamples; the same at every call unless given.

    Returns
    -------
    Interval
        Student's interval if more than 5 % of the resamples have no spread, because there are too
        few values or too few different ones.

    Notes
    -----
    P. Hall, On symmetric bootstrap confidence intervals, Journal of the Royal Statistical Society
    B, 50:35-45, 1988.
    """
    count = len(x)
    with np.errstate(divide="ignore", invalid="ignore"):
        value = float(x.mean() / y.mean())
        # Both relative to the mean of y: the residual of x on y, and y's own spread. This computes
        # the error of the ratio without a difference of large numbers.
        left, other = (x - value * y) / y.mean(), y / y.mean() - 1.0
        scale = float(np.abs(x / y.mean()).max())
    error = float(left.std(ddof=1)) / np.sqrt(count)
    if error <= NO_SPREAD * scale:
        return Interval(value, value, "no spread")
    sizes = np.concatenate(
        [
            _sizes(drawn, left, other, value if logarithmic else None)
            for drawn in _resamples(count, rng)
        ]
    )
    reach, method = float(np.quantile(sizes, CONFIDENCE, method="higher")), "symmetric bootstrap-t"
    if not np.isfinite(reach):
        reach, method = _student(count), "Student's t"
    if not logarithmic:
        return Interval(value - reach * error, value + reach * error, method)
    with np.errstate(over="ignore"):
        factor = float(np.exp(reach * error / value))
    return Interval(value / factor, value * factor, f"{method} on the logarithm")


def student_of_logarithms(logarithms: Array) -> Interval:
    """Return Student's interval of a geometric mean from the logarithms, (N,), at least two."""
    reach = _student(len(logarithms)) * logarithms.std(ddof=1) / np.sqrt(len(logarithms))
    with np.errstate(over="ignore"):
        low, high = np.exp([logarithms.mean() - reach, logarithms.mean() + reach])
    return Interval(float(low), float(high), "Student's t on logarithms")


def percentiles_of_medians(values: Array, rng: np.random.Generator | None = None) -> Interval:
    """Return the percentile bootstrap interval of the median; parameters as above."""
    medians = [np.median(values[drawn], axis=1) for drawn in _resamples(len(values), rng)]
    ends = [0.5 - 0.5 * CONFIDENCE, 0.5 + 0.5 * CONFIDENCE]
    low, high = np.quantile(np.concatenate(medians), ends)
    return Interval(float(low), float(high), "percentiles of the bootstrap")


def _student(count: int) -> float:
    from scipy.stats import t

    return float(t.ppf(0.5 + 0.5 * CONFIDENCE, count - 1))


def _resamples(count: int, rng: np.random.Generator | None) -> Iterator[NDArray[np.int64]]:
    """Yield the indices of resampled values, (B, count), in batches that fit into memory."""
    checked_random(rng)
    source = np.random.default_rng(0) if rng is None else rng
    batch = max(1, NUMBERS_AT_A_TIME // count)
    for start in range(0, RESAMPLES, batch):
        yield source.integers(count, size=(min(batch, RESAMPLES - start), count))


def _sizes(drawn: NDArray[np.int64], left: Array, other: Array, value: float | None) -> Array:
    """Return the absolute studentized deviations of resamples, (B,).

    They are those of the ratio, or of its logarithm if its value is given.
    """
    count = len(left)
    # With the count of each value, all moments are one matrix product.
    offsets = count * np.arange(len(drawn))[:, np.newaxis]
    times = np.bincount((drawn + offsets).ravel(), minlength=drawn.size).reshape(drawn.shape)
    moments = np.stack([left, other, left**2, other**2, left * other], axis=1) / count
    mean_left, mean_other, squares, squares_other, products = (times @ moments).T
    with np.errstate(divide="ignore", invalid="ignore"):
        shift = mean_left / (1.0 + mean_other)
        spread = (
            (squares - mean_left**2)
            - 2.0 * shift * (products - mean_left * mean_other)
            + shift**2 * (squares_other - mean_other**2)
        )
        # A resample of one repeated value has no spread except for rounding.
        spread[spread <= NO_SPREAD * squares] = 0.0
        error = np.sqrt(spread / (count - 1)) / np.abs(1.0 + mean_other)
        if value is not None:
            shift, error = np.log1p(shift / value), error / (value + shift)
        sizes: Array = np.abs(shift) / error
    # Zero deviation over zero spread counts like any deviation over zero spread: infinite.
    sizes[np.isnan(sizes)] = np.inf
    return sizes
