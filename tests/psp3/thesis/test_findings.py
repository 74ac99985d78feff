"""Verdicts and numbers in words."""

from __future__ import annotations

import math

import numpy as np
import pytest

from psp3.study.statistics import Estimate
from psp3.thesis.findings import better, compared, significant, verdict, with_interval


@pytest.mark.parametrize(
    ("computed", "printed", "words"),
    [
        (4.6648, 4.6339, "reproduced (+0.7 %)"),
        (0.96, 1.0, "reproduced (-4.0 %)"),
        (1.06, 1.0, "same order"),
        (0.0185, 0.0241, "same order"),
        (0.3, 1.0, "not reproduced"),
        (3.1, 1.0, "not reproduced"),
        (math.nan, 1.0, "not reproduced: every run diverged"),
    ],
)
def test_verdicts_by_ratio(computed: float, printed: float, words: str) -> None:
    said = verdict(computed, printed, reason="as the sea is deep")
    assert said.startswith(words)
    assert said.count(":") == 1


def test_a_fit_reproduces_nothing_and_can_miss() -> None:
    matched = verdict(4.6648, 4.6339, reason="fitted", fitted=True)
    assert matched == "matched by a fit (+0.7 %): fitted"
    assert verdict(1.06, 1.0, reason="", fitted=True) == verdict(1.06, 1.0, reason="")


def test_verdict_says_whether_single_runs_spread_over_the_printed_number() -> None:
    within, outside = (verdict(2.0, 1.0, (low, 4.0), reason="") for low in (0.9, 1.1))
    assert within.endswith("printed within the spread of single runs")
    assert outside.endswith("printed outside of the spread of single runs")
    # A spread that holds everything makes nothing agree.
    assert verdict(10.0, 1.0, (0.0, 100.0), reason="").startswith("not reproduced")
    assert "spread" not in verdict(2.0, 1.0, (math.nan, math.nan), reason="")


@pytest.mark.parametrize(
    ("low", "high", "words"),
    [
        (-2.0, -0.1, "type-2 better"),
        (0.1, 2.0, "type-1 better"),
        (-1.0, 1.0, "no difference"),
        (math.nan, math.nan, "no difference"),
    ],
)
def test_better_needs_an_interval_beside_zero(low: float, high: float, words: str) -> None:
    assert better(Estimate(-1.0, low, high, 20), "type-2", "type-1").startswith(words)


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (5.3219, "5.32"),
        (29.84, "29.8"),
        (251.4, "251"),
        (0.04123, "0.0412"),
        (-2.741, "-2.74"),
        (0.0, "0"),
        (1.2e-9, "< 0.000001"),
        (math.inf, "–"),
    ],
)
def test_three_significant_digits_without_exponent(value: float, text: str) -> None:
    assert significant(value) == text


def test_interval_and_seeds_are_shown_where_they_say_something() -> None:
    assert with_interval(Estimate(5.321, 4.0, 7.371, 20)) == "5.32 (4.00 to 7.37)"
    assert with_interval(Estimate(5.321, 4.0, 7.371, 15), seeds=20) == "5.32 (4.00 to 7.37), n = 15"
    assert with_interval(Estimate(5.321, 4.0, 7.371, 20), seeds=20) == "5.32 (4.00 to 7.37)"
    assert with_interval(Estimate(0.031, math.nan, math.nan, 1)) == "0.0310"


def test_matrices_are_compared_row_by_row() -> None:
    rows = compared("row {}", np.eye(2), np.array([[1.0, 0.0], [0.3, 1.0]]), 0.1, "fitted")
    assert [row[0] for row in rows] == ["row 1", "row 2"]
    assert [row[-1] for row in rows] == [
        "matched by a fit, to 0.0000: fitted",
        "not matched, to 0.3000: fitted",
    ]
    assert compared("", np.eye(2), np.eye(2), None, "so")[0][-1] == "not reproducible: so"
