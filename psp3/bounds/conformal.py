r"""Conformal bounds, which new samples keep with a stated probability.

Split conformal prediction: of n + 1 scores that are exchangeable, each is equally likely to be the
k-th smallest, so that a new one exceeds the k-th smallest of n old ones with a probability of at
most :math:`1 - k / (n + 1)`, whatever the law they come from and however few they are. Without ties
it is just that; with them it is less, since a score that is as large as the bound keeps it. The
probability is over old and new scores together: that of a bound from one set of old scores
scatters about it, without ties as a beta law of k and n + 1 - k.

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
"""Shares that are the nearest number to a fraction with no larger one are that fraction."""


def checked_share(share: object) -> float:
    """Return a share; raise :class:`InvalidValue` if it is not between 0 and 1."""
    number = checked_positive("share", share)
    if number >= 1.0:
        raise InvalidValue("share", share, "above 0 and below 1, since no bound holds for all")
    return number


def exact_share(share: object) -> Fraction:
    """Return the fraction that a share is: 0.95 is 19/20, which has no floating-point number.

    A number that is the nearest to no such fraction is itself, which is a fraction, too.

    Raises
    ------
    InvalidValue
        If it is not between 0 and 1.
    """
    number = checked_share(share)
    meant = Fraction(number).limit_denominator(LARGEST_DENOMINATOR)
    return meant if float(meant) == number else Fraction(number)


def rank_of_bound(count: int, share: float) -> int:
    r"""Return which of so many scores in ascending order is the bound.

    .. math:: k = \lceil (n + 1)\, p \rceil

    More than n say that there are too few: see :func:`scores_needed`.

    Parameters
    ----------
    count : int
        Number n of scores.
    share : float
        Share p of new scores that the bound is to hold for, in (0, 1).

    Returns
    -------
    int
    """
    return math.ceil((checked_count("count", count, 0) + 1) * exact_share(share))


def scores_needed(share: float) -> int:
    r"""Return how many scores a bound needs at least, :math:`\lceil p / (1 - p) \rceil`."""
    part = exact_share(share)
    return math.ceil(part / (1 - part))


def check_count(name: str, count: int, share: float) -> None:
    """Raise :class:`InvalidValue` that names what is given if it is too few for a share."""
    if rank_of_bound(count, share) > count:
        wanted = (
            f"at least {scores_needed(share)} of them for a share of {share:g}; give more, or ask "
            "for a smaller share"
        )
        raise InvalidValue(name, count, wanted)


def conformal_bound(scores: ArrayLike, share: float) -> Array:
    r"""Return a bound that a new score keeps with a probability of at least ``share``.

    The :math:`\lceil (n + 1)\, p \rceil`-th smallest of n scores. Guaranteed if the new score and
    the old ones are exchangeable, as are those of independent runs under the same conditions; if
    scores have no ties, the probability is less than ``share`` plus 1 / (n + 1).

    Parameters
    ----------
    scores : (n, ...) array_like
        A row for each; infinite for what failed altogether.
    share : float
        Share p of new scores that the bound is to hold for, in (0, 1).

    Returns
    -------
    (...,) ndarray
        For each column by itself.

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
