"""Estimates with intervals.

Against formulas and known laws. How often intervals hold the truth is tested in
``test_intervals.py``.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import asdict
from typing import Any

import numpy as np
import pytest
from scipy import stats

from psp3.errors import InvalidArray, InvalidValue, UnknownName
from psp3.study.run import METRICS, Run
from psp3.study.statistics import (
    Estimate,
    compare,
    mean,
    median,
    paired_difference,
    ratio_of_geometric_means,
    ratio_of_means,
    share,
    summarize,
)

SKEWED = np.random.default_rng(7).lognormal(size=30)
RELATED = 0.5 * SKEWED * np.random.default_rng(8).lognormal(sigma=0.3, size=30)


def rows_of(run: Run, errors: dict[int, float]) -> list[dict[str, Any]]:
    """Results with these sums of squared errors by seed.

    NaN for a run that diverged, whose effort is nonetheless there.
    """
    return [
        asdict(run)
        | {"seed": seed}
        | dict.fromkeys(METRICS, 1.0)
        | {"sum_of_squared_errors": error, "diverged": float(math.isnan(error))}
        for seed, error in errors.items()
    ]


# Estimates


def test_values_are_those_of_numpy() -> None:
    """Nothing but the same sums in the same order, so exactly."""
    assert mean(SKEWED).value == SKEWED.mean()
    assert median(SKEWED).value == np.median(SKEWED)
    assert paired_difference(RELATED, SKEWED).value == (RELATED - SKEWED).mean()
    assert ratio_of_means(RELATED, SKEWED).value == RELATED.mean() / SKEWED.mean()
    for estimate in (
        mean(SKEWED),
        median(SKEWED),
        paired_difference(RELATED, SKEWED),
        ratio_of_means(RELATED, SKEWED),
        ratio_of_geometric_means(RELATED, SKEWED),
    ):
        assert estimate.low < estimate.value < estimate.high
        assert estimate.count == 30


def test_estimates_say_what_they_estimate_and_how() -> None:
    for estimate, estimand, method in (
        (mean(SKEWED), "mean", "symmetric bootstrap-t on the logarithm"),
        (mean(-SKEWED), "mean", "symmetric bootstrap-t"),
        (median(SKEWED), "median", "percentiles of the bootstrap"),
        (paired_difference(RELATED, SKEWED), "difference of means", "symmetric bootstrap-t"),
        (
            ratio_of_means(RELATED, SKEWED),
            "ratio of means",
            "symmetric bootstrap-t on the logarithm",
        ),
        (ratio_of_means(-RELATED, SKEWED), "ratio of means", "symmetric bootstrap-t"),
        (
            ratio_of_geometric_means(RELATED, SKEWED),
            "ratio of geometric means",
            "Student's t on logarithms",
        ),
        (share([0, 1]), "share", "Wilson's"),
    ):
        assert (estimate.estimand, estimate.method) == (estimand, method)


def test_geometric_means_are_those_of_logarithms() -> None:
    """By the t-test of SciPy on logarithms, to rounding."""
    result = stats.ttest_rel(np.log(RELATED), np.log(SKEWED))
    interval = result.confidence_interval(0.95)
    estimate = ratio_of_geometric_means(RELATED, SKEWED)
    assert estimate.value == pytest.approx(stats.gmean(RELATED) / stats.gmean(SKEWED), rel=1e-12)
    assert estimate.low == pytest.approx(math.exp(interval.low), rel=1e-12)
    assert estimate.high == pytest.approx(math.exp(interval.high), rel=1e-12)
    assert estimate.count == 30


def test_geometric_means_are_of_positive_numbers() -> None:
    for first, second, name in (([0.0, 1.0], [1.0, 1.0], "first"), ([1.0], [-1.0], "second")):
        with pytest.raises(InvalidArray, match=f"{name}.*each positive"):
            ratio_of_geometric_means(first, second)
    nothing, one = ratio_of_geometric_means([], []), ratio_of_geometric_means([6.0], [2.0])
    assert (nothing.count, one.count, one.value) == (0, 1, pytest.approx(3.0))
    assert math.isnan(nothing.value)
    assert math.isnan(one.low)


def test_pairs_make_a_difference_sharper() -> None:
    """What the pairing is for: a narrow interval.

    The spread of the two controllers over seeds would make it far wider.
    """
    paired = paired_difference(RELATED, SKEWED)
    scrambled = paired_difference(np.random.default_rng(1).permutation(RELATED), SKEWED)
    assert paired.value == pytest.approx(scrambled.value)
    assert paired.high - paired.low < 0.8 * (scrambled.high - scrambled.low)


def test_shares_have_wilsons_interval() -> None:
    """Against the formula, z = 1.959964."""
    for happened, count in ((0, 30), (1, 30), (15, 30), (30, 30), (3, 7)):
        estimate, p, z = (
            share([1] * happened + [0] * (count - happened)),
            happened / count,
            1.959963984540054,
        )
        middle, scale = p + z * z / (2 * count), 1.0 + z * z / count
        half = z * math.sqrt(p * (1.0 - p) / count + z * z / (4 * count * count))
        assert (estimate.value, estimate.count) == (p, count)
        assert estimate.low == pytest.approx((middle - half) / scale, abs=1e-12)
        assert estimate.high == pytest.approx((middle + half) / scale, abs=1e-12)
    assert share([0] * 30).high > 0.1, (
        "thirty seeds without a divergence do not prove that there is none"
    )


def test_numbers_that_are_not_finite_are_left_out_and_not_counted() -> None:
    some = [1.0, math.nan, 2.0, math.inf, 4.0]
    assert mean(some) == mean([1.0, 2.0, 4.0])
    assert median(some) == median([1.0, 2.0, 4.0])
    assert paired_difference(some, [0.5, 1.0, math.nan, 1.0, 1.5]) == paired_difference(
        [1.0, 4.0], [0.5, 1.5]
    )
    for ratio in (ratio_of_means, ratio_of_geometric_means):
        assert ratio([1.0, 2.0, math.nan], [2.0, 3.0, 1e9]) == ratio([1.0, 2.0], [2.0, 3.0])


@pytest.mark.parametrize("estimator", [mean, median])
def test_few_seeds(estimator: Callable[[Any], Estimate]) -> None:
    nothing, one, two = (estimator(values) for values in ([], [3.0], [3.0, 4.0]))
    assert math.isnan(nothing.value)
    assert nothing.count == 0
    assert (one.value, one.count) == (3.0, 1)
    assert math.isnan(one.low)
    assert math.isnan(one.high)
    assert (two.value, two.count) == (3.5, 2)
    # Half the resamples of two have no spread, so a mean has Student's interval on its logarithm,
    # with t = 12.706 for one degree of freedom; a median cannot lie beside both.
    reach = 12.7062047 * 0.5 / 3.5
    ends = (3.0, 4.0) if estimator is median else (3.5 / math.exp(reach), 3.5 * math.exp(reach))
    assert (two.low, two.high) == pytest.approx(ends, rel=1e-7)
    assert "n = 1" in str(one)
    assert str(median([3.0, 4.0])) == "3.5 (3 to 4, n = 2)"


def test_values_that_are_all_the_same() -> None:
    """Nothing is divided by no spread, in NaN or warnings."""
    assert mean([2.0] * 5) == Estimate(2.0, 2.0, 2.0, 5)
    assert median([2.0] * 5) == Estimate(2.0, 2.0, 2.0, 5)
    assert paired_difference([3.0] * 5, [1.0] * 5) == Estimate(2.0, 2.0, 2.0, 5)
    assert ratio_of_means([1.0, 2.0, 3.0], [2.0, 4.0, 6.0]) == Estimate(0.5, 0.5, 0.5, 3)


def test_same_values_give_the_same_interval_and_other_resamples_nearly_the_same() -> None:
    assert mean(SKEWED) == mean(SKEWED)
    one, other = mean(SKEWED), mean(SKEWED, np.random.default_rng(99))
    assert one != other
    assert other.low == pytest.approx(one.low, rel=0.02)
    assert other.high == pytest.approx(one.high, rel=0.02)


@pytest.mark.parametrize("values", ["abc", [[1.0, 2.0]], 3.0, [1j]])
def test_what_is_no_row_of_numbers(values: Any) -> None:
    with pytest.raises(InvalidArray):
        mean(values)
    with pytest.raises(InvalidArray):
        share(values)


def test_rows_of_different_length_and_events_that_are_none() -> None:
    with pytest.raises(InvalidArray, match="second"):
        paired_difference([1.0, 2.0], [1.0])
    with pytest.raises(InvalidArray, match="each 0 or 1"):
        share([0, 1, 2])


# Tables of results


def test_summary_groups_by_all_but_the_seed() -> None:
    one, other = Run("t1", snr_db=20.0), Run("t1", snr_db=10.0)
    rows = (
        rows_of(one, {0: 1.0, 1: 3.0})
        + rows_of(other, {0: 5.0, 1: math.nan, 2: 6.0})
        + rows_of(one, {2: 8.0})
    )
    first, second = summarize(rows)
    assert (first.run, second.run) == (one, other)
    assert first.mean == mean([1.0, 3.0, 8.0])
    assert first.median == median([1.0, 3.0, 8.0])
    assert first.diverged == share([0, 0, 0])
    assert second.mean == mean([5.0, 6.0])
    assert second.diverged == share([0, 1, 0])
    assert summarize([]) == []


def test_what_a_run_measured_before_it_diverged_does_not_count() -> None:
    (summary,) = summarize(
        rows_of(Run("t1", snr_db=20.0), {0: 1.0, 1: math.nan, 2: 2.0}), metric="effort"
    )
    assert summary.mean.count == 2


def test_comparison_pairs_seeds_under_the_same_setting() -> None:
    """Type-1 has no mean variation, so its runs are partners of type-2's with any."""
    type1 = {snr: Run("t1", snr_db=snr).canonical() for snr in (20.0, 10.0)}
    type2 = {snr: Run("it2", snr_db=snr, mean_variation=0.3).canonical() for snr in (20.0, 10.0)}
    rows = [
        *rows_of(type2[20.0], {2: 1.0, 0: 2.0, 1: 2.5, 7: 9.0}),
        *rows_of(type1[20.0], {0: 4.0, 1: 5.0, 2: 6.0}),
        *rows_of(type2[10.0], {0: 7.0, 1: math.nan, 2: 9.0}),
        *rows_of(type1[10.0], {0: 8.0, 1: 1.0, 2: 11.0}),
        *rows_of(Run("it2", snr_db=20.0, mean_variation=0.3, trajectory="line"), {0: 1.0}),
    ]
    first, second = compare(rows, "it2", "t1")
    assert (first.run, second.run) == (type2[20.0], type2[10.0])
    assert first.difference == paired_difference([1.0, 2.0, 2.5], [6.0, 4.0, 5.0])
    assert first.ratio == ratio_of_means([1.0, 2.0, 2.5], [6.0, 4.0, 5.0])
    assert first.ratio_of_geometric_means == ratio_of_geometric_means(
        [1.0, 2.0, 2.5], [6.0, 4.0, 5.0]
    )
    assert first.pairs == 3
    assert second.difference == paired_difference([7.0, 9.0], [8.0, 11.0])
    assert (second.pairs, second.difference.count) == (3, 2)


def test_comparison_with_a_controller_that_does_not_depend_on_the_seed() -> None:
    rows = rows_of(Run("t1", snr_db=20.0).canonical(), {0: 1.0, 1: 2.0}) + rows_of(
        Run("ctc").canonical(), {0: 0.5}
    )
    (comparison,) = compare(rows, "t1", "ctc")
    assert comparison.difference == paired_difference([1.0, 2.0], [0.5, 0.5])


def test_comparison_of_a_metric_that_is_zero_has_no_geometric_means() -> None:
    rows = rows_of(Run("it2", snr_db=20.0).canonical(), {0: 0.0, 1: 2.0}) + rows_of(
        Run("t1", snr_db=20.0).canonical(), {0: 1.0, 1: 2.0}
    )
    (comparison,) = compare(rows, "it2", "t1")
    assert comparison.ratio.value == pytest.approx(2.0 / 3.0)
    assert comparison.ratio_of_geometric_means.count == 0
    assert math.isnan(comparison.ratio_of_geometric_means.value)


def test_nothing_to_compare() -> None:
    assert compare(rows_of(Run("it2", snr_db=20.0), {0: 1.0}), "it2", "t1") == []
    with pytest.raises(UnknownName, match="unknown controller 't2'"):
        compare([], "t2", "t1")
    with pytest.raises(InvalidValue, match="another controller"):
        compare([], "t1", "t1")
    for function in (lambda: summarize([], "jerk"), lambda: compare([], "it2", "t1", "jerk")):
        with pytest.raises(UnknownName, match="unknown metric 'jerk'"):
            function()
