"""Type-1 systems that are embedded in a type-2 system."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from fuzzy2.support.checks import Array


def embedded_averages(
    strengths: Array, intervals: Array, count: int, rng: np.random.Generator
) -> Iterator[Array]:
    """Yield weighted averages that take one weight and one point from every interval.

    The first averages are those of all switch points of the first output, with the upper weights on
    either side; random choices follow.

    Parameters
    ----------
    strengths : (R, 2) ndarray
        Firing intervals of the rules.
    intervals : (R, m, 2) ndarray
        Consequents of the rules.
    count : int
        Number of random choices.
    rng : numpy.random.Generator
        Source of the random choices.

    Yields
    ------
    (m,) ndarray
        An average. Nothing is yielded if no rule fires.
    """
    choices: list[tuple[Array, Array]] = []
    for end in (0, 1):
        rank = np.argsort(np.argsort(intervals[:, 0, end], kind="stable"))
        choices += [
            (
                np.where((rank < k) == (end == 0), strengths[:, 1], strengths[:, 0]),
                intervals[..., end],
            )
            for k in range(len(rank) + 1)
        ]
    for _ in range(count):
        share, where = rng.random(len(strengths)), rng.random(intervals.shape[:2])
        weights = strengths[:, 0] + share * (strengths[:, 1] - strengths[:, 0])
        choices.append(
            (weights, intervals[..., 0] + where * (intervals[..., 1] - intervals[..., 0]))
        )
    for weights, values in choices:
        if weights.sum() > 0.0:
            yield weights @ values / weights.sum()
