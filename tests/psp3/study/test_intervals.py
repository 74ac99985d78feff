"""Intervals: against resamples one by one, Student's law, and how often they hold the truth."""

from __future__ import annotations

import importlib.util
import math
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from scipy import stats

from psp3.study import intervals
from psp3.study.intervals import (
    bootstrap_t,
    coverage_in_words,
    percentiles_of_medians,
    student_of_logarithms,
)
from tests.helpers import Array

ROOT = Path(__file__).resolve().parents[3]
X = np.random.default_rng(7).lognormal(size=12)
Y = 0.5 * X * np.random.default_rng(8).lognormal(sigma=0.3, size=12)


@pytest.fixture(scope="module")
def page() -> ModuleType:
    """Return the script that writes the table of coverages."""
    path = ROOT / "docs" / "make_intervals.py"
    spec = importlib.util.spec_from_file_location("make_intervals", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize("logarithmic", [False, True])
@pytest.mark.parametrize("second", [Y, np.ones(12)], ids=["ratio", "mean"])
def test_bootstrap_t_is_that_of_resamples_one_by_one(
    second: Array, logarithmic: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The same draws, each with ratio and standard error written out, to 1e-9."""
    monkeypatch.setattr(intervals, "RESAMPLES", 199)
    value = X.mean() / second.mean()

    def error(x: Array, y: Array) -> float:
        ratio = x.mean() / y.mean()
        squares = np.sum(((x - ratio * y) / y.mean()) ** 2) / (len(x) * (len(x) - 1))
        return float(np.sqrt(squares) / (ratio if logarithmic else 1.0))

    def transformed(ratio: float) -> float:
        return math.log(ratio) if logarithmic else ratio

    sizes = []
    for drawn in np.random.default_rng(0).integers(12, size=(199, 12)):
        x, y = X[drawn], second[drawn]
        shift = transformed(x.mean() / y.mean()) - transformed(value)
        sizes.append(abs(shift) / error(x, y))
    # The 190th of 199: 95 % of 198 gaps between them is 188.1, and the next one above is taken.
    reach = sorted(sizes)[189] * error(X, second)
    ends = np.array([transformed(value) - reach, transformed(value) + reach])
    found = bootstrap_t(X, second, logarithmic)
    np.testing.assert_allclose(
        [found.low, found.high], np.exp(ends) if logarithmic else ends, rtol=1e-9
    )


def test_interval_of_a_normal_mean_is_nearly_students() -> None:
    """200 normal numbers: Student's interval holds exactly.

    Bootstrap and 9999 resamples differ from it by a few percent of its width.
    """
    values = np.random.default_rng(3).normal(5.0, 2.0, size=200)
    half = 1.972 * values.std(ddof=1) / math.sqrt(200)
    found = bootstrap_t(values, np.ones(200), logarithmic=False)
    assert found.low == pytest.approx(values.mean() - half, abs=0.06 * half)
    assert found.high == pytest.approx(values.mean() + half, abs=0.06 * half)


def test_interval_of_logarithms_is_students() -> None:
    expected = np.exp(stats.ttest_1samp(np.log(X), 0.0).confidence_interval(0.95))
    found = student_of_logarithms(np.log(X))
    np.testing.assert_allclose([found.low, found.high], expected, rtol=1e-12)


def test_interval_of_a_median_is_that_of_scipy() -> None:
    """Another implementation with other draws; ends are among twelve numbers, so nearly equal."""
    other = stats.bootstrap((X,), np.median, method="percentile", rng=1).confidence_interval
    found = percentiles_of_medians(X)
    np.testing.assert_allclose([found.low, found.high], [other.low, other.high], rtol=0.05)


def test_units_and_order_do_not_matter() -> None:
    """Numbers of a thousandth, and pairs of a billion, to 1e-6."""
    whole = bootstrap_t(X, Y, logarithmic=True)
    small = bootstrap_t(1e-3 * X, 1e9 * Y, logarithmic=True)
    np.testing.assert_allclose(
        [small.low * 1e12, small.high * 1e12], [whole.low, whole.high], rtol=1e-6
    )


def test_nearly_equal_rows_lose_no_digits() -> None:
    """Pairs that differ by 1e-7: the difference of the ratio from one has its own spread.

    The logarithm of the ratio of such pairs is the mean of x/y - 1 weighted by y, to first order.
    """
    offsets = 1e-7 * np.random.default_rng(4).standard_normal(12)
    found = bootstrap_t(X * (1.0 + offsets), X, logarithmic=True)
    weighted = bootstrap_t(X * offsets * 1e7, X, logarithmic=False)
    np.testing.assert_allclose(
        [1e7 * (found.low - 1.0), 1e7 * (found.high - 1.0)],
        [weighted.low, weighted.high],
        rtol=1e-4,
    )


def test_too_few_different_numbers_have_students_interval() -> None:
    """Of three a ninth of the resamples have no spread, of five with four alike a third."""
    for values in ([1.0, 2.0, 4.0], [1.0, 1.0, 1.0, 1.0, 5.0]):
        row = np.array(values)
        expected = stats.ttest_1samp(row, 0.0).confidence_interval(0.95)
        found = bootstrap_t(row, np.ones_like(row), logarithmic=False)
        np.testing.assert_allclose([found.low, found.high], expected, rtol=1e-9)
        assert found.method == "Student's t"
    same = bootstrap_t(np.full(5, 0.1), np.full(5, 0.3), logarithmic=True)
    assert (same.low, same.high, same.method) == (0.1 / 0.3, 0.1 / 0.3, "no spread")


def test_memory_is_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    """Batches draw the same numbers, and nothing else changes."""
    whole, whole_median = bootstrap_t(X, Y, logarithmic=True), percentiles_of_medians(X)
    monkeypatch.setattr(intervals, "NUMBERS_AT_A_TIME", 1000)
    np.testing.assert_allclose(bootstrap_t(X, Y, logarithmic=True)[:2], whole[:2], rtol=1e-12)
    assert percentiles_of_medians(X) == whole_median


def test_intervals_hold_the_truth_as_often_as_the_page_says(
    page: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> None:
    """400 other sets of each case, with 999 resamples, beside the 4000 of the page.

    The difference of two shares p has the standard deviation sqrt(p (1 - p) (1/400 + 1/4000)),
    0.012 at 0.94; four of it are allowed, since twenty are compared.
    """
    monkeypatch.setattr(intervals, "RESAMPLES", 999)
    printed = page.read()
    assert set(printed) == set(page.CASES)
    for seed, (name, shares) in enumerate(printed.items()):
        found = page.coverage(page.CASES[name], 400, np.random.default_rng(1000 + seed))
        assert set(found) == set(shares)
        for estimate, share in shares.items():
            allowed = 4.0 * math.sqrt(share * (1.0 - share) * (1.0 / 400 + 1.0 / page.SETS))
            assert abs(found[estimate] - share) < allowed, (name, estimate)


def test_what_is_printed_beside_intervals_is_what_the_page_says(page: ModuleType) -> None:
    """The least share of the cases with 30 pairs, in whole percents."""
    printed = page.read()
    shares = [share for name, share in printed.items() if page.CASES[name].pairs == 30]
    assert set(intervals.MEASURED_COVERAGE) == set(page.ESTIMATES)
    for name, least in intervals.MEASURED_COVERAGE.items():
        assert least == round(min(share[name] for share in shares), 2)
    assert dict(intervals.MEASURED_COVERAGE_OF_TEN) == pytest.approx(printed["20 dB, 10 pairs"])


def test_coverage_in_words_is_that_of_so_many_seeds() -> None:
    many = "in simulations of 30 such seeds they held the truth in "
    few = "in simulations of 10 such seeds they held the truth in "
    both = ("mean", "difference of means")
    for seeds in (30, 31, 1000):
        assert coverage_in_words(*both, seeds=seeds) == (
            many + "94 % (mean), 92 % (difference of means)"
        )
    for seeds in (1, 10, 29):
        assert coverage_in_words(*both, seeds=seeds) == (
            few + "93.1 % (mean), 91.5 % (difference of means)"
        )
    assert coverage_in_words("median") == many + "94 % (median)"


def test_page_says_that_intervals_hold_well_enough(page: ModuleType) -> None:
    """What was asked of them: 0.94 for geometric means, 0.92 at 30 seeds for all that is used."""
    assert page.SETS >= 4000
    for name, shares in page.read().items():
        assert shares["ratio of geometric means"] >= 0.94
        if page.CASES[name].pairs == 30:
            assert min(shares.values()) >= 0.92
