"""Conformal bounds: what exchangeability promises, counted over all orders."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import binom

from psp3.bounds.conformal import conformal_bound, rank_of_bound, scores_needed
from psp3.errors import InvalidArray, InvalidValue

SHARES = st.fractions(Fraction(1, 50), Fraction(49, 50), max_denominator=100)


@given(
    share=SHARES,
    more=st.integers(0, 40),
    values=st.randoms(use_true_random=False),
    ties=st.booleans(),
)
def test_each_of_exchangeable_scores_is_as_likely_the_new_one(
    share: Fraction, more: int, values: object, ties: bool
) -> None:
    """Brute force: of n + 1 scores each is the new one once, and is compared with the others.

    Exactly k of n + 1 keep their bound without ties, with ties no fewer.
    """
    part = float(share)
    count = scores_needed(part) + more
    draw = values.sample(range(10 * count + 10), count + 1)  # type: ignore[attr-defined]
    scores = np.array(draw, dtype=float) // (7 if ties else 1)
    kept = sum(
        bool(scores[i] <= conformal_bound(np.delete(scores, i), part)) for i in range(count + 1)
    )
    expected = math.ceil((count + 1) * share)
    if ties and len(set(scores)) <= count:
        assert kept >= expected
    else:
        assert kept == expected
    assert share <= Fraction(expected, count + 1) < share + Fraction(1, count + 1)


@given(share=SHARES, count=st.integers(0, 2000))
def test_ranks_are_those_of_exact_arithmetic(share: Fraction, count: int) -> None:
    assert rank_of_bound(count, float(share)) == math.ceil((count + 1) * share)
    assert scores_needed(float(share)) == math.ceil(share / (1 - share))


@given(share=SHARES)
def test_one_score_less_is_refused_and_the_error_says_how_many(share: Fraction) -> None:
    needed = scores_needed(float(share))
    conformal_bound(np.arange(needed), float(share))
    with pytest.raises(InvalidValue, match=f"at least {needed} of them"):
        conformal_bound(np.arange(needed - 1), float(share))


def test_new_scores_keep_it_as_often_as_they_should() -> None:
    """Of a skewed law: 3000 bounds of 39 scores, each asked once, are a binomial law of 38 / 40.

    Within the interval of 99.9 %.
    """
    scores = np.random.default_rng(0).lognormal(0.0, 1.0, (40, 3000))
    kept = int((scores[39] <= conformal_bound(scores[:39], 0.95)).sum())
    low, high = binom.interval(0.999, 3000, 0.95)
    assert low <= kept <= high


def test_columns_are_bounded_one_by_one_and_failures_count() -> None:
    scores = np.array([[1.0, 5.0], [2.0, np.inf], [3.0, 4.0]])
    np.testing.assert_array_equal(conformal_bound(scores, 0.5), [2.0, 5.0])
    np.testing.assert_array_equal(conformal_bound(scores, 0.75), [3.0, np.inf])


@pytest.mark.parametrize("share", [0.0, 1.0, -0.5, 2.0, float("nan"), "many"])
def test_shares_that_are_none_are_refused(share: object) -> None:
    with pytest.raises(InvalidValue, match="share"):
        conformal_bound(np.arange(10.0), share)  # type: ignore[arg-type]


@pytest.mark.parametrize("scores", [3.0, [1.0, float("nan")], ["a", "b"]])
def test_scores_that_are_none_are_refused(scores: object) -> None:
    with pytest.raises(InvalidArray, match="scores"):
        conformal_bound(scores, 0.5)  # type: ignore[arg-type]
