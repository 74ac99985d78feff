"""Points that cover a set evenly."""

from __future__ import annotations

import numpy as np

from psp3.fuzzy_control.spreading import spread_evenly


def test_no_point_is_farther_from_the_chosen_than_these_are_from_each_other() -> None:
    """What makes the choice at most twice as coarse as the best one."""
    points = np.random.default_rng(0).uniform(size=(300, 3))
    chosen = points[spread_evenly(points, 20)]
    apart = np.linalg.norm(chosen[:, np.newaxis] - chosen, axis=-1)
    np.fill_diagonal(apart, np.inf)
    reach = np.linalg.norm(points[:, np.newaxis] - chosen, axis=-1).min(axis=1).max()
    assert reach <= apart.min()
    np.testing.assert_array_equal(spread_evenly(points, 7), spread_evenly(points, 20)[:7])
