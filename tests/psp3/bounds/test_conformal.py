"""Conformal bounds: what exchangeability promises, counted over all orders."""

from __future__ import annotations

import itertools
import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import beta, binom, kstest

from psp3.bounds.conformal import conformal_bound, exact_share, rank_of_bound, scores_needed
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


VALUES = st.lists(st.sampled_from([0.0, 1.0, 2.0, 3.0, math.inf]), min_size=2, max_size=6)


@given(values=VALUES, share=SHARES)
def test_with_ties_it_is_the_test_by_ranks(values: list[float], share: Fraction) -> None:
    """All orders of scores with ties, counted in fractions.

    The other way to say what a conformal bound is: the new score keeps it unless so many of the
    others are below it that its own p-value, the share of all n + 1 that are as large, is at most
    1 - p. Over all orders at least a share p keep it; and one score lower, the next lower bound
    would be kept by fewer of scores without ties.
    """
    n = len(values) - 1
    if scores_needed(float(share)) > n:
        return
    rank = rank_of_bound(n, float(share))
    kept = 0
    orders = list(itertools.permutations(values))
    for new, *others in orders:
        holds = bool(new <= conformal_bound(others, float(share)))
        as_large = 1 + sum(score >= new for score in others)
        assert holds == (Fraction(as_large, n + 1) > 1 - Fraction(rank, n + 1))
        assert holds == (Fraction(as_large, n + 1) > 1 - share)
        kept += holds
    assert Fraction(kept, len(orders)) >= share
    if len(set(values)) == n + 1:
        assert Fraction(kept, len(orders)) == Fraction(rank, n + 1)
        assert Fraction(rank - 1, n + 1) < share


@pytest.mark.parametrize("ties", [False, True])
def test_the_share_of_one_bound_is_a_beta_law(ties: bool) -> None:
    """Of uniform scores a bound is the share that keeps it: a beta law of k and n + 1 - k.

    20 000 bounds of 54 scores for 95 %, by the test of Kolmogorov and Smirnov at 0.1 %. Rounded up
    to twentieths they have ties, and each bound is kept by as many or more.
    """
    scores = np.random.default_rng(0).uniform(size=(54, 20_000))
    kept = conformal_bound(np.ceil(20.0 * scores) / 20.0 if ties else scores, 0.95)
    rank = rank_of_bound(54, 0.95)
    law = beta(rank, 55 - rank)
    if ties:
        assert (kept >= conformal_bound(scores, 0.95)).all()
    else:
        assert kstest(kept, law.cdf).pvalue > 1e-3
        assert law.std() == pytest.approx(0.025, abs=5e-4)


@given(
    share=st.fractions(Fraction(1, 10**7), 1 - Fraction(1, 10**7), max_denominator=10**7),
    count=st.integers(0, 10**9),
)
def test_ranks_are_those_of_exact_arithmetic(share: Fraction, count: int) -> None:
    """Two fractions with denominators up to 10^7 differ by 1e-14, and numbers by 1e-16."""
    part = float(share)
    assert exact_share(part) == share
    assert rank_of_bound(count, part) == math.ceil((count + 1) * share)
    needed = scores_needed(part)
    assert needed == math.ceil(share / (1 - share))
    assert rank_of_bound(needed, part) <= needed
    assert rank_of_bound(needed - 1, part) > needed - 1


@pytest.mark.parametrize("nines", range(1, 8))
def test_shares_near_one_need_as_many_scores_as_they_say(nines: int) -> None:
    assert scores_needed(float("0." + nines * "9")) == 10**nines - 1


def test_a_number_that_is_no_simple_fraction_is_itself() -> None:
    """0.1 + 0.2 is more than 3/10, and of nine scores the third is not enough for it."""
    assert exact_share(0.3) == Fraction(3, 10)
    assert exact_share(0.1 + 0.2) == Fraction(0.1 + 0.2)
    assert rank_of_bound(9, 0.3) == 3
    assert rank_of_bound(9, 0.1 + 0.2) == 4
    assert exact_share(1e-300) == Fraction(1e-300)
    assert exact_share(1.0 - 2.0**-53) == 1 - Fraction(1, 2**53)


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
