"""Figures of operations: what is drawn is what they give."""

from __future__ import annotations

import numpy as np
import pytest

from fuzzy2 import plots
from fuzzy2.sets.type1 import SampledSet

pytestmark = pytest.mark.usefixtures("styled")


def test_join_and_meet_of_discrete_sets_are_stems() -> None:
    """By hand: maxima and minima of the four pairs.

    Each has the smaller of both grades, and of equal ones the best counts.
    """
    _, join, meet = plots.figure_of_join_and_meet(
        SampledSet([0.2, 0.6], [0.5, 1.0]), SampledSet([0.4, 0.6], [1.0, 0.3])
    )
    for panel, points, grades in (
        (join, [0.4, 0.6], [0.5, 1.0]),
        (meet, [0.2, 0.4, 0.6], [0.5, 1.0, 0.3]),
    ):
        theta, drawn = (np.asarray(values, dtype=float) for values in panel.lines[1].get_data())
        np.testing.assert_array_equal([theta, drawn], [points, grades])
        assert panel.lines[1].get_linestyle() == "None"
        np.testing.assert_array_equal(
            panel.lines[0].get_ydata(), [end for grade in grades for end in (0.0, grade, np.nan)]
        )
