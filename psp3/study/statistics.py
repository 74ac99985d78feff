"""Statistics over seeds: means, ratios and differences, with confidence intervals.

Estimates with 95 % intervals, what they estimate, and the number of seeds behind each.

Errors of runs are skewed, and thirty of them are too few for a normal approximation. Means,
differences and ratios of means have symmetric bootstrap-t intervals, which are wider than other
bootstrap intervals and hold the true value more often; ``docs/concepts/intervals.md`` says how
often. Ratios of geometric means have Student's intervals on logarithms, which are nearly exact on
such data. Two controllers are compared seed by seed, because runs of one seed see the same noise.

A run that diverged has no error, and its NaN cannot be averaged. Such runs are left out of means,
medians, differences and ratios, which favors the controller that diverges. Therefore every summary
also gives their share, and the count of an estimate is the number of runs that it uses.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from psp3.checks import Array, as_floats, checked_random, known_name, overflow_refused
from psp3.errors import InvalidArray, InvalidValue
from psp3.study.intervals import CONFIDENCE as CONFIDENCE
from psp3.study.intervals import MEASURED_COVERAGE as MEASURED_COVERAGE
from psp3.study.intervals import RESAMPLES as RESAMPLES
from psp3.study.intervals import (
    Interval,
    bootstrap_t,
    percentiles_of_medians,
    student_of_logarithms,
)
from psp3.study.run import CONTROLLERS as CONTROLLERS
from psp3.study.run import METRICS, Run
from psp3.study.table import Table


@dataclass(frozen=True)
class Estimate:
    """A value with its 95 % interval and the number of seeds behind it.

    Parameters
    ----------
    value : float
        The estimate; NaN if there is no data.
    low, high : float
        Ends of the interval; NaN if there are fewer than two seeds.
    count : int
        Number of seeds.
    estimand : str
        What is estimated, in words.
    method : str
        How the interval was found, in words.
    """

    value: float
    low: float
    high: float
    count: int
    estimand: str = field(default="", compare=False)
    method: str = field(default="", compare=False)

    def __str__(self) -> str:
        if self.count < 2:
            return f"{self.value:.3g} (n = {self.count})"
        return f"{self.value:.3g} ({self.low:.3g} to {self.high:.3g}, n = {self.count})"


@dataclass(frozen=True)
class Summary:
    """Statistics of one setting over its seeds.

    Parameters
    ----------
    run : Run
        The setting: the run with seed 0.
    mean, median : Estimate
        Mean and median of the metric over the runs that did not diverge.
    diverged : Estimate
        Share of the runs that diverged; its count is the number of all seeds.
    """

    run: Run
    mean: Estimate
    median: Estimate
    diverged: Estimate


@dataclass(frozen=True)
class Contrast:
    """A controller compared with a baseline, seed by seed.

    Parameters
    ----------
    run : Run
        The controller's setting: its run with seed 0.
    baseline : str
        Controller that it is compared with.
    difference : Estimate
        Mean difference of the metric, controller minus baseline, over the seeds with which neither
        diverged.
    ratio : Estimate
        Ratio of the metric's means, controller over baseline, over the same seeds: the factor on
        the total error of all runs.
    pairs : int
        Number of seeds that both have, including those with which one diverged.
    ratio_of_geometric_means : Estimate
        Geometric mean of the ratios by seed, over the same seeds: the factor on the error of a
        typical run. NaN if the metric is not positive.
    """

    run: Run
    baseline: str
    difference: Estimate
    ratio: Estimate
    pairs: int
    ratio_of_geometric_means: Estimate


def mean(values: ArrayLike, rng: np.random.Generator | None = None) -> Estimate:
    r"""Return the mean with its symmetric bootstrap-t interval.

    .. math:: P\big( |\hat\theta^* - \hat\theta| / s^* \le q \big) = 0.95, \qquad
              \hat\theta - q s \le \theta \le \hat\theta + q s

    with :math:`\theta` the logarithm of the mean if all values are positive, and otherwise the
    mean; :math:`s` is its standard error from the delta method, and stars mark resamples. For
    differences use :func:`paired_difference`, which takes no logarithm even if all have one sign.

    Parameters
    ----------
    values : (N,) array_like
        One number per seed; those that are not finite are left out.
    rng : numpy.random.Generator, optional
        Source of the resamples; the same at every call unless given.

    Returns
    -------
    Estimate
        Its interval is Student's if more than 5 % of the resamples have no spread, because there
        are too few values or too few different ones.

    Raises
    ------
    InvalidArray
        If the values are not a row of numbers.

    Notes
    -----
    P. Hall, On symmetric bootstrap confidence intervals, Journal of the Royal Statistical Society
    B, 50:35-45, 1988.
    """
    (row,) = _finite(values=values)
    return _studentized(row, np.ones_like(row), bool((row > 0.0).all()), "mean", rng)


def median(values: ArrayLike, rng: np.random.Generator | None = None) -> Estimate:
    """Return the median with its percentile bootstrap interval; parameters as for :func:`mean`."""
    (row,) = _finite(values=values)
    checked_random(rng)
    count = len(row)
    if count == 0:
        return _nothing("median")
    value = float(np.median(row))
    if count == 1:
        return Estimate(value, np.nan, np.nan, 1, "median")
    return _with(value, percentiles_of_medians(row, rng), count, "median")


def paired_difference(
    first: ArrayLike, second: ArrayLike, rng: np.random.Generator | None = None
) -> Estimate:
    """Return the mean of ``first - second`` with its symmetric bootstrap-t interval.

    Parameters
    ----------
    first, second : (N,) array_like
        One number per seed, in the same order; pairs in which one is not finite are left out.
    rng : numpy.random.Generator, optional
        As for :func:`mean`.

    Returns
    -------
    Estimate
        As from :func:`mean`.

    Raises
    ------
    InvalidArray
        If they are not rows of numbers of the same length.
    """
    one, other = _finite(first=first, second=second)
    return _studentized(one - other, np.ones_like(one), False, "difference of means", rng)


def ratio_of_means(
    first: ArrayLike, second: ArrayLike, rng: np.random.Generator | None = None
) -> Estimate:
    """Return the mean of ``first`` over that of ``second``; pairs are resampled whole.

    Parameters as for :func:`paired_difference`. The interval is that of :func:`mean`, on the
    logarithm of the ratio where all numbers are positive.
    """
    one, other = _finite(first=first, second=second)
    positive = bool((one > 0.0).all() and (other > 0.0).all())
    return _studentized(one, other, positive, "ratio of means", rng)


def ratio_of_geometric_means(first: ArrayLike, second: ArrayLike) -> Estimate:
    r"""Return the geometric mean of ``first / second`` with Student's interval on logarithms.

    .. math:: \exp \Big( \bar d \pm t_{N - 1}\, s_d / \sqrt N \Big), \qquad
              d_k = \ln \frac{x_k}{y_k}

    This is the factor between typical runs. The ratio of means differs: runs with large errors
    dominate it.

    Parameters
    ----------
    first, second : (N,) array_like
        One positive number per seed, in the same order; pairs in which one is not finite are left
        out.

    Returns
    -------
    Estimate

    Raises
    ------
    InvalidArray
        If they are not rows of numbers of the same length, or not positive.
    """
    rows = _finite(first=first, second=second)
    for name, row in zip(("first", "second"), rows, strict=True):
        if not (row > 0.0).all():
            raise InvalidArray(name, "(N,), each positive", row)
    name, count = "ratio of geometric means", len(rows[0])
    if count == 0:
        return _nothing(name)
    with overflow_refused("the sizes of first and second"):
        logarithms = np.log(rows[0] / rows[1])
        value = float(np.exp(logarithms.mean()))
        if count == 1:
            return Estimate(value, np.nan, np.nan, 1, name)
        return _with(value, student_of_logarithms(logarithms), count, name)


def share(events: ArrayLike) -> Estimate:
    """Return the share of seeds with which something happened, with its Wilson interval.

    Parameters
    ----------
    events : (N,) array_like
        1 or True where it happened, 0 or False where not.

    Returns
    -------
    Estimate

    Raises
    ------
    InvalidArray
        If a value is neither 0 nor 1.
    """
    happened = as_floats("events", events, "(N,)")
    if np.ndim(events) != 1 or not np.isin(happened, (0.0, 1.0)).all():
        raise InvalidArray("events", "(N,), each 0 or 1", events)
    if not happened.size:
        return _nothing("share")
    from scipy.stats import binomtest

    interval = binomtest(int(happened.sum()), happened.size).proportion_ci(
        CONFIDENCE, method="wilson"
    )
    return Estimate(
        float(happened.mean()),
        float(interval.low),
        float(interval.high),
        happened.size,
        "share",
        "Wilson's",
    )


def summarize(
    rows: Table | Iterable[Mapping[str, Any]],
    metric: str = "sum_of_squared_errors",
    rng: np.random.Generator | None = None,
) -> list[Summary]:
    """Summarize a metric over the seeds of every setting.

    Parameters
    ----------
    rows : Table or iterable of mapping
        Results, see :meth:`psp3.Study.rows`.
    metric : str
        One of :data:`psp3.study.run.METRICS`.
    rng : numpy.random.Generator, optional
        As for :func:`mean`.

    Returns
    -------
    list of Summary
        One for each setting, in the order of the rows.

    Raises
    ------
    UnknownName
        If there is no such metric.
    """
    check_metric(metric)
    table = Table.of(rows)
    values, diverged = table.values(metric), table.column("diverged")
    return [
        Summary(
            setting,
            mean(values[places], rng),
            median(values[places], rng),
            share(diverged[places]),
        )
        for setting, places in table.groups()
    ]


def compare(
    rows: Table | Iterable[Mapping[str, Any]],
    controller: str,
    baseline: str,
    metric: str = "sum_of_squared_errors",
    rng: np.random.Generator | None = None,
) -> list[Contrast]:
    """Compare a controller with another one under the same settings, seed by seed.

    Parameters
    ----------
    rows : Table or iterable of mapping
        Results of both, see :meth:`psp3.Study.rows`.
    controller, baseline : str
        Names of the controllers. Fields that do not apply to the baseline, such as the mean
        variation of a type-1 controller, are ignored in the pairing, so choose as baseline the
        controller with fewer fields.
    metric : str
        One of :data:`psp3.study.run.METRICS`.
    rng : numpy.random.Generator, optional
        As for :func:`mean`.

    Returns
    -------
    list of Contrast
        One for every setting of the controller that the baseline has too.

    Raises
    ------
    UnknownName
        If there is no such controller or metric.
    InvalidValue
        If both are the same controller.
    """
    check_metric(metric)
    table = Table.of(rows)
    known = dict.fromkeys((*CONTROLLERS, *map(str, table.settings.column("controller"))))
    for name in (controller, baseline):
        known_name("controller", name, known)
    if controller == baseline:
        raise InvalidValue(
            "baseline", baseline, "another controller than the one that is compared with it"
        )
    values = table.values(metric)
    groups = dict(table.groups())
    comparisons = []
    for setting, places in groups.items():
        if setting.controller != controller:
            continue
        pairs = _partners(table, setting, places, baseline, groups)
        if not len(pairs):
            continue
        first, second = values[pairs[:, 0]], values[pairs[:, 1]]
        positive = not ((first <= 0.0) | (second <= 0.0)).any()
        comparisons.append(
            Contrast(
                setting,
                baseline,
                paired_difference(first, second, rng),
                ratio_of_means(first, second, rng),
                len(pairs),
                ratio_of_geometric_means(first, second)
                if positive
                else _nothing("ratio of geometric means"),
            )
        )
    return comparisons


def _partners(
    table: Table,
    setting: Run,
    places: NDArray[np.intp],
    baseline: str,
    groups: Mapping[Run, NDArray[np.intp]],
) -> NDArray[np.intp]:
    """Return the rows of a setting paired with the baseline's rows of the same seeds, (M, 2)."""
    other = replace(setting, controller=baseline)
    partner = other.canonical()
    there = groups.get(replace(partner, seed=0))
    if there is None:
        return np.empty((0, 2), dtype=np.intp)
    if not other.counts_seed:
        # The baseline does not depend on the seed and has one row.
        alone = there[table.seeds[there] == 0]
        return (
            np.stack(np.broadcast_arrays(places, alone), axis=1)
            if len(alone)
            else (np.empty((0, 2), dtype=np.intp))
        )
    place_of = dict(zip(table.seeds[there].tolist(), there.tolist(), strict=True))
    seeds = zip(places.tolist(), table.seeds[places].tolist(), strict=True)
    pairs = [(place, place_of[seed]) for place, seed in seeds if seed in place_of]
    return np.array(pairs, dtype=np.intp).reshape(-1, 2)


def check_metric(metric: str) -> None:
    """Raise :class:`UnknownName` if there is no such metric."""
    known_name("metric", metric, METRICS)


def _finite(**named: ArrayLike) -> list[Array]:
    """Return rows of equal length without the columns that hold a value that is not finite."""
    rows = [as_floats(name, values, "(N,)") for name, values in named.items()]
    for (name, values), row in zip(named.items(), rows, strict=True):
        if np.ndim(values) != 1 or len(row) != len(rows[0]):
            raise InvalidArray(
                name,
                "(N,)"
                if row is rows[0]
                else f"{rows[0].shape}, one number for each of the other row",
                row,
            )
    keep = np.logical_and.reduce([np.isfinite(row) for row in rows])
    return [row[keep] for row in rows]


def _nothing(estimand: str) -> Estimate:
    return Estimate(np.nan, np.nan, np.nan, 0, estimand)


def _with(value: float, interval: Interval, count: int, estimand: str) -> Estimate:
    return Estimate(value, interval.low, interval.high, count, estimand, interval.method)


def _studentized(
    x: Array, y: Array, logarithmic: bool, estimand: str, rng: np.random.Generator | None
) -> Estimate:
    """Return the ratio of the means of paired rows with its interval."""
    checked_random(rng)
    count = len(x)
    if count == 0:
        return _nothing(estimand)
    with (
        overflow_refused("the sizes of the numbers"),
        np.errstate(divide="ignore", invalid="ignore"),
    ):
        value = float(x.mean() / y.mean())
    if count == 1:
        return Estimate(value, np.nan, np.nan, 1, estimand)
    with overflow_refused("the sizes of the numbers"):
        return _with(value, bootstrap_t(x, y, logarithmic, rng), count, estimand)
