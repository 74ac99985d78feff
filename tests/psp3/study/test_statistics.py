"""Estimates with intervals.

Against formulas, known laws, and how often the intervals hold the truth.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import asdict
from typing import Any

import numpy as np
import pytest

from psp3 import statistics
from psp3.errors import InvalidArray, InvalidValue, UnknownName
from psp3.study.run import METRICS, Run
from psp3.study.statistics import (
    Estimate,
    compare,
    mean,
    median,
    paired_difference,
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
    ):
        assert estimate.low < estimate.value < estimate.high
        assert estimate.count == 30


def test_interval_of_a_normal_mean_is_nearly_students() -> None:
    """200 normal numbers: Student's interval holds exactly.

    Bootstrap and 9999 resamples differ from it by a few percent of its width.
    """
    values = np.random.default_rng(3).normal(5.0, 2.0, size=200)
    half = 1.972 * values.std(ddof=1) / math.sqrt(200)
    estimate = mean(values)
    assert estimate.low == pytest.approx(values.mean() - half, abs=0.06 * half)
    assert estimate.high == pytest.approx(values.mean() + half, abs=0.06 * half)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("estimator", "truth"),
    [
        (lambda x, y: mean(x), math.exp(0.125)),
        (lambda x, y: median(x), 1.0),
        (lambda x, y: paired_difference(y, x), math.exp(0.125) * (0.5 * math.exp(0.045) - 1.0)),
        (lambda x, y: ratio_of_means(y, x), 0.5 * math.exp(0.045)),
    ],
    ids=["mean", "median", "difference", "ratio"],
)
def test_intervals_hold_the_truth_as_often_as_they_say(
    estimator: Callable[[Any, Any], Estimate], truth: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """300 sets of 30 seeds of skewed errors.

    Type-2 is type-1 times a lognormal factor, and all true values are by formula.

    95 % intervals hold it in 285 sets, give or take 4 by chance; bootstrap of so few skewed numbers
    is known to be a little short.
    """
    monkeypatch.setattr(statistics, "RESAMPLES", 999)
    rng, hits = np.random.default_rng(5), 0
    for _ in range(300):
        first = np.exp(0.5 * rng.standard_normal(30))
        second = 0.5 * first * np.exp(0.3 * rng.standard_normal(30))
        estimate = estimator(first, second)
        hits += estimate.low <= truth <= estimate.high
    assert 0.90 * 300 <= hits <= 0.98 * 300


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
    assert ratio_of_means([1.0, 2.0, math.nan], [2.0, 4.0, 1e9]) == ratio_of_means(
        [1.0, 2.0], [2.0, 4.0]
    )


@pytest.mark.parametrize("estimator", [mean, median])
def test_few_seeds(estimator: Callable[[Any], Estimate]) -> None:
    nothing, one, two = (estimator(values) for values in ([], [3.0], [3.0, 4.0]))
    assert math.isnan(nothing.value)
    assert nothing.count == 0
    assert (one.value, one.count) == (3.0, 1)
    assert math.isnan(one.low)
    assert math.isnan(one.high)
    assert (two.low, two.value, two.high) == (3.0, 3.5, 4.0)
    assert "n = 1" in str(one)
    assert str(two) == "3.5 (3 to 4, n = 2)"


def test_values_that_are_all_the_same() -> None:
    """The bias correction divides zero by zero there, and must not say so in NaN or warnings."""
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


def test_memory_is_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    """Batches change nothing but the order in which resamples are drawn."""
    monkeypatch.setattr(statistics, "NUMBERS_AT_A_TIME", 1000)
    batched = mean(SKEWED)
    assert batched.low == pytest.approx(mean(SKEWED, np.random.default_rng(1)).low, rel=0.02)


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
    assert first.pairs == 3
    assert second.difference == paired_difference([7.0, 9.0], [8.0, 11.0])
    assert (second.pairs, second.difference.count) == (3, 2)


def test_comparison_with_a_controller_that_does_not_depend_on_the_seed() -> None:
    rows = rows_of(Run("t1", snr_db=20.0).canonical(), {0: 1.0, 1: 2.0}) + rows_of(
        Run("ctc").canonical(), {0: 0.5}
    )
    (comparison,) = compare(rows, "t1", "ctc")
    assert comparison.difference == paired_difference([1.0, 2.0], [0.5, 0.5])


def test_nothing_to_compare() -> None:
    assert compare(rows_of(Run("it2", snr_db=20.0), {0: 1.0}), "it2", "t1") == []
    with pytest.raises(UnknownName, match="unknown controller 't2'"):
        compare([], "t2", "t1")
    with pytest.raises(InvalidValue, match="another controller"):
        compare([], "t1", "t1")
    for function in (lambda: summarize([], "jerk"), lambda: compare([], "it2", "t1", "jerk")):
        with pytest.raises(UnknownName, match="unknown metric 'jerk'"):
            function()
