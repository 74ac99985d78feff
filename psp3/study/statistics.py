"""What many seeds say together.

Estimates with 95 % intervals, and the number of seeds that each of them stands on.

Means and medians carry bootstrap intervals: the errors of runs are skewed, and thirty of them are
too few for a normal law. Two controllers are compared by seed, since runs of one seed see the same
noise.

A run that diverged has no error, and its NaN cannot be averaged. Such runs are left out of means,
medians, differences and ratios, which favors the controller that diverges: their share stands
beside every summary, and the count of an estimate says how many runs it stands on.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from psp3.checks import Array, as_floats
from psp3.errors import InvalidArray, InvalidValue, UnknownName
from psp3.study.file import field_types
from psp3.study.run import CONTROLLERS, METRICS, Run

CONFIDENCE = 0.95
"""Share of intervals that are to hold the true value."""

RESAMPLES = 9999
"""Number of bootstrap resamples."""

NUMBERS_AT_A_TIME = 1_000_000
"""Size of the largest array of resamples, which bounds the memory of an estimate."""


@dataclass(frozen=True)
class Estimate:
    """A value with its 95 % interval, and how many seeds it stands on.

    Parameters
    ----------
    value : float
        The estimate; NaN if there is nothing to estimate from.
    low, high : float
        Ends of the interval; NaN if there are fewer than two seeds.
    count : int
        Number of seeds.
    """

    value: float
    low: float
    high: float
    count: int

    def __str__(self) -> str:
        if self.count < 2:
            return f"{self.value:.3g} (n = {self.count})"
        return f"{self.value:.3g} ({self.low:.3g} to {self.high:.3g}, n = {self.count})"


@dataclass(frozen=True)
class Summary:
    """What the seeds of one setting give.

    Parameters
    ----------
    run : Run
        The setting: the run with seed 0.
    mean, median : Estimate
        Of the metric, over the runs that did not diverge.
    diverged : Estimate
        Share of the runs that did; its count is the number of all seeds.
    """

    run: Run
    mean: Estimate
    median: Estimate
    diverged: Estimate


@dataclass(frozen=True)
class Comparison:
    """How a controller compares with another one, seed by seed.

    Parameters
    ----------
    run : Run
        The setting of the controller: its run with seed 0.
    baseline : str
        Controller that it is compared with.
    difference : Estimate
        Mean of the metric's difference, controller minus baseline, over the seeds with which
        neither diverged.
    ratio : Estimate
        Ratio of the metric's means, controller over baseline, over the same seeds.
    pairs : int
        Number of seeds that both have, those with which one diverged too.
    """

    run: Run
    baseline: str
    difference: Estimate
    ratio: Estimate
    pairs: int


def mean(values: ArrayLike, rng: np.random.Generator | None = None) -> Estimate:
    """Return the mean with its bias-corrected and accelerated bootstrap interval.

    Parameters
    ----------
    values : (N,) array_like
        One number per seed; those that are not finite are left out.
    rng : numpy.random.Generator, optional
        Source of the resamples; unless given, the same one at every call.

    Returns
    -------
    Estimate

    Raises
    ------
    InvalidArray
        If the values are not a row of numbers.
    """
    return _bootstrapped(_finite(values=values), lambda x, axis: x.mean(axis=axis), "BCa", rng)


def median(values: ArrayLike, rng: np.random.Generator | None = None) -> Estimate:
    """Return the median with its percentile bootstrap interval; parameters as for :func:`mean`.

    The acceleration of the other interval is of no use here: leaving one value out hardly ever
    moves a median smoothly.
    """
    return _bootstrapped(
        _finite(values=values), lambda x, axis: np.median(x, axis=axis), "percentile", rng
    )


def paired_difference(
    first: ArrayLike, second: ArrayLike, rng: np.random.Generator | None = None
) -> Estimate:
    """Return the mean of ``first - second`` with its interval.

    Parameters
    ----------
    first, second : (N,) array_like
        One number per seed, in the same order; pairs in which one is not finite are left out.
    rng : numpy.random.Generator, optional
        As for :func:`mean`.

    Returns
    -------
    Estimate

    Raises
    ------
    InvalidArray
        If they are not rows of numbers of the same length.
    """
    one, other = _finite(first=first, second=second)
    return _bootstrapped([one - other], lambda x, axis: x.mean(axis=axis), "BCa", rng)


def ratio_of_means(
    first: ArrayLike, second: ArrayLike, rng: np.random.Generator | None = None
) -> Estimate:
    """Return the mean of ``first`` over that of ``second``; pairs are resampled whole.

    Parameters as for :func:`paired_difference`.
    """
    return _bootstrapped(
        _finite(first=first, second=second),
        lambda x, y, axis: x.mean(axis=axis) / y.mean(axis=axis),
        "BCa",
        rng,
    )


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
        If there are other numbers than 0 and 1.
    """
    happened = as_floats("events", events, "(N,)")
    if np.ndim(events) != 1 or not np.isin(happened, (0.0, 1.0)).all():
        raise InvalidArray("events", "(N,), each 0 or 1", events)
    if not happened.size:
        return Estimate(np.nan, np.nan, np.nan, 0)
    from scipy.stats import binomtest

    interval = binomtest(int(happened.sum()), happened.size).proportion_ci(
        CONFIDENCE, method="wilson"
    )
    return Estimate(
        float(happened.mean()), float(interval.low), float(interval.high), happened.size
    )


def summarize(
    rows: Iterable[Mapping[str, Any]],
    metric: str = "sum_of_squared_errors",
    rng: np.random.Generator | None = None,
) -> list[Summary]:
    """Summarize a metric over the seeds of every setting.

    Parameters
    ----------
    rows : iterable of mapping
        Results, see :meth:`psp3.Study.rows`.
    metric : str
        One of :data:`psp3.study.run.METRICS`.
    rng : numpy.random.Generator, optional
        As for :func:`mean`.

    Returns
    -------
    list of Summary
        In the order in which the settings come.

    Raises
    ------
    UnknownName
        If there is no such metric.
    """
    _check_metric(metric)
    groups: dict[Run, list[Mapping[str, Any]]] = {}
    for row in rows:
        groups.setdefault(replace(_run(row), seed=0), []).append(row)
    summaries = []
    for setting, members in groups.items():
        values = [_value(row, metric) for row in members]
        summaries.append(
            Summary(
                setting,
                mean(values, rng),
                median(values, rng),
                share([row["diverged"] for row in members]),
            )
        )
    return summaries


def compare(
    rows: Sequence[Mapping[str, Any]],
    controller: str,
    baseline: str,
    metric: str = "sum_of_squared_errors",
    rng: np.random.Generator | None = None,
) -> list[Comparison]:
    """Compare a controller with another one under the same settings, seed by seed.

    Parameters
    ----------
    rows : sequence of mapping
        Results of both, see :meth:`psp3.Study.rows`.
    controller, baseline : str
        Names of the controllers. Settings that mean nothing to the baseline, as the mean variation
        to type-1, do not separate the two; so the baseline is the one with fewer of them.
    metric : str
        One of :data:`psp3.study.run.METRICS`.
    rng : numpy.random.Generator, optional
        As for :func:`mean`.

    Returns
    -------
    list of Comparison
        One for every setting of the controller that the baseline has too.

    Raises
    ------
    UnknownName
        If there is no such controller or metric.
    InvalidValue
        If both are the same controller.
    """
    _check_metric(metric)
    for name in (controller, baseline):
        if name not in CONTROLLERS:
            raise UnknownName("controller", name, CONTROLLERS)
    if controller == baseline:
        raise InvalidValue(
            "baseline", baseline, "another controller than the one that is compared with it"
        )
    by_run = {_run(row): row for row in rows}
    pairs: dict[Run, list[tuple[float, float]]] = {}
    for run, row in by_run.items():
        partner = (
            by_run.get(replace(run, controller=baseline).canonical())
            if run.controller == controller
            else None
        )
        if partner is not None:
            pairs.setdefault(replace(run, seed=0), []).append(
                (_value(row, metric), _value(partner, metric))
            )
    comparisons = []
    for setting, values in pairs.items():
        first, second = np.array(values).T
        difference, ratio = (
            paired_difference(first, second, rng),
            ratio_of_means(first, second, rng),
        )
        comparisons.append(Comparison(setting, baseline, difference, ratio, len(values)))
    return comparisons


def _check_metric(metric: str) -> None:
    if metric not in METRICS:
        raise UnknownName("metric", metric, METRICS)


def _run(row: Mapping[str, Any]) -> Run:
    return Run(**{name: row[name] for name in field_types()})


def _value(row: Mapping[str, Any], metric: str) -> float:
    # What a run measured before it diverged, such as its effort, is that of a shorter run.
    return float("nan") if row["diverged"] else float(row[metric])


def _finite(**named: ArrayLike) -> list[Array]:
    """Return rows of the same length without the columns in which one is not finite."""
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


def _bootstrapped(
    rows: list[Array], statistic: Callable[..., Any], method: str, rng: np.random.Generator | None
) -> Estimate:
    """Return a statistic of paired rows with its bootstrap interval."""
    count = len(rows[0])
    if count == 0:
        return Estimate(np.nan, np.nan, np.nan, 0)
    with np.errstate(divide="ignore", invalid="ignore"):
        value = float(statistic(*rows, axis=-1))
        if count == 1:
            return Estimate(value, np.nan, np.nan, 1)
        from scipy import stats

        def interval(method: str) -> tuple[float, float]:
            source = np.random.default_rng(0) if rng is None else rng
            with warnings.catch_warnings():
                # It warns of what is tested for below.
                warnings.simplefilter("ignore", stats.DegenerateDataWarning)
                found = stats.bootstrap(
                    rows,
                    statistic,
                    n_resamples=RESAMPLES,
                    batch=max(1, NUMBERS_AT_A_TIME // count),
                    vectorized=True,
                    paired=len(rows) > 1,
                    axis=-1,
                    confidence_level=CONFIDENCE,
                    method=method,
                    rng=source,
                ).confidence_interval
            return float(found.low), float(found.high)

        low, high = interval(method)
        if np.isnan(low) or np.isnan(high):
            # Values that are all the same, or nearly, leave nothing to correct for.
            low, high = interval("percentile")
    return Estimate(value, low, high, count)
