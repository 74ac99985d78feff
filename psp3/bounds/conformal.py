r"""Conformal bounds, which new samples keep with a given probability.

This is split conformal prediction. Each of n + 1 exchangeable scores is equally likely to be the
k-th smallest. So a new score exceeds the k-th smallest of n old ones with a probability of at most
:math:`1 - k / (n + 1)`, for any distribution and any n. Without ties the probability is exactly
that. With ties it is smaller, because a score equal to the bound keeps it. The probability is over
old and new scores together. For one set of old scores, the share of new scores that keep the bound
scatters about :math:`k / (n + 1)`; without ties it has the beta distribution of k and n + 1 - k.

V. Vovk, A. Gammerman and G. Shafer, Algorithmic Learning in a Random World, 2005; J. Lei, M.
G'Sell, A. Rinaldo, R. Tibshirani and L. Wasserman, Distribution-free predictive inference for
regression, Journal of the American Statistical Association 113, 2018.
"""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
from numpy.typing import ArrayLike

from psp3.checks import Array, as_floats, checked_count, checked_positive
from psp3.errors import InvalidArray, InvalidValue

LARGEST_DENOMINATOR = 10**7
"""Largest denominator: a share that is the number nearest to such a fraction counts as the
fraction."""


def checked_share(share: object) -> float:
    """Return a share, or raise :class:`InvalidValue` if it is not between 0 and 1."""
    number = checked_positive("share", share)
    if number >= 1.0:
        raise InvalidValue("share", share, "above 0 and below 1, since no bound holds for all")
    return number


def exact_share(share: object) -> Fraction:
    """Return a share as a fraction: 0.95 is 19/20, which floating point cannot represent.

    A number that is not the nearest to a fraction with a small denominator is converted exactly.

    Raises
    ------
    InvalidValue
        If the share is not between 0 and 1.
    """
    number = checked_share(share)
    meant = Fraction(number).limit_denominator(LARGEST_DENOMINATOR)
    return meant if float(meant) == number else Fraction(number)


def rank_of_bound(count: int, share: float) -> int:
    r"""Return the rank, in ascending order, of the score that is the bound.

    .. math:: k = \lceil (n + 1)\, p \rceil

    A rank greater than n means that there are too few scores, see :func:`scores_needed`.

    Parameters
    ----------
    count : int
        Number n of scores.
    share : float
        Share p of new scores that keep the bound, in (0, 1).

    Returns
    -------
    int
    """
    return math.ceil((checked_count("count", count, 0) + 1) * exact_share(share))


def scores_needed(share: float) -> int:
    r"""Return the least number of scores for a bound, :math:`\lceil p / (1 - p) \rceil`."""
    part = exact_share(share)
    return math.ceil(part / (1 - part))


def check_count(name: str, count: int, share: float) -> None:
    """Raise :class:`InvalidValue` with the argument's name if it has too few items for a share."""
    if rank_of_bound(count, share) > count:
        wanted = (
            f"at least {scores_needed(share)} of them for a share of {share:g}; give more, or ask "
            "for a smaller share"
        )
        raise InvalidValue(name, count, wanted)


def conformal_bound(scores: ArrayLike, share: float) -> Array:
    r"""Return a bound that a new score keeps with a probability of at least ``share``.

    It is the :math:`\lceil (n + 1)\, p \rceil`-th smallest of n scores. The probability is
    guaranteed if the new score and the old ones are exchangeable, as in independent runs under the
    same conditions. Without ties it is less than ``share`` plus 1 / (n + 1).

    Parameters
    ----------
    scores : (n, ...) array_like
        One row for each score; infinite for a failure.
    share : float
        Share p of new scores that keep the bound, in (0, 1).

    Returns
    -------
    (...,) ndarray
        The bound of each column separately.

    Raises
    ------
    InvalidValue
        If the share is not between 0 and 1, or there are too few scores for it.
    InvalidArray
        If scores are not numbers.
    """
    rows = as_floats("scores", scores, "(n, ...)")
    if scores is None or np.ndim(scores) == 0 or np.isnan(rows).any():
        raise InvalidArray("scores", "(n, ...), without NaN", scores)
    check_count("scores", len(rows), share)
    bound: Array = np.sort(rows, axis=0)[rank_of_bound(len(rows), share) - 1]
    return bound
