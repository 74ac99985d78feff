"""Figures of fuzzy sets.

What stands on the axes, and whether the curves are the sets they claim to be.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from fuzzy2 import plots
from fuzzy2.errors import InvalidValue
from fuzzy2.sets.interval_type2 import (
    GaussianUncertainSigma,
    IntervalType2Set,
)
from fuzzy2.sets.shapes import Interval, Trapezoidal, Triangular
from fuzzy2.sets.type1 import SampledSet, Singleton
from tests.fuzzy2.plots.drawn import band, curve, edges
from tests.fuzzy2.plots.subjects import FUZZY, TRIANGLES

Array = NDArray[np.float64]

pytestmark = pytest.mark.usefixtures("styled")


def test_sets_of_every_type_share_axes() -> None:
    shapes = {
        "triangle": Triangular(0.0, 1.0, 2.0),
        "shoulder": Trapezoidal(2.0, 4.0, np.inf, np.inf),
        "footprint": IntervalType2Set(
            lower=Triangular(1.0, 2.0, 3.0, height=0.5), upper=Triangular(0.0, 2.0, 4.0)
        ),
        "fuzzy": FUZZY,
        "discrete": SampledSet([0.5, 1.5], [0.4, 1.0]),
        "point": Singleton(3.0),
    }
    (panel,) = plots.figure_of_sets(shapes)
    x, u = curve(panel, "triangle")
    np.testing.assert_allclose(u, np.clip(1.0 - np.abs(x - 1.0), 0.0, 1.0), atol=1e-15)
    left, right = panel.get_xlim()
    assert left < 0.0
    # The Gaussian falls to the visibility of 0.003 at 3.4 standard deviations; a landmark is there
    # at 4.
    assert 8.2 < right < 9.4
    assert edges(band(panel, "footprint"), 2.0) == (0.5, 1.0)
    legend = panel.get_legend()
    assert legend is not None
    assert [text.get_text() for text in legend.get_texts()] == list(shapes)
    np.testing.assert_array_equal(curve(panel, "point"), [[3.0, 3.0], [0.0, 1.0]])
    assert (panel.get_xlabel(), panel.get_ylabel()) == ("x", "membership u")


def test_a_single_set_needs_no_name() -> None:
    (panel,) = plots.figure_of_sets(Interval(1.0, 2.0))
    assert panel.get_legend() is None
    x, u = np.array(panel.lines[0].get_data(), dtype=float)
    # Vertical edges stay vertical: neighboring floats lie on both sides.
    np.testing.assert_array_equal(u, (x >= 1.0) & (x <= 2.0))
    assert np.diff(x)[np.diff(u) != 0.0].max() < 1e-15
    (alone,) = plots.figure_of_sets(Singleton(2.0))
    assert alone.get_xlim() == (1.0, 3.0)


def test_secondaries_are_vertical_slices() -> None:
    (panel,) = plots.figure_of_secondaries(FUZZY, [4.0, 6.5])
    for x in (4.0, 6.5):
        u, grades = curve(panel, f"x = {x:g}")
        np.testing.assert_allclose(
            grades, np.exp(-0.5 * ((u - np.exp(-0.5 * (x - 5.0) ** 2)) / 0.1) ** 2), atol=1e-12
        )
    (panel,) = plots.figure_of_secondaries(GaussianUncertainSigma(mean=0.0, sigma=(1.0, 2.0)), 1.0)
    u, grades = curve(panel, "x = 1")
    np.testing.assert_allclose(
        u[grades == 1.0][[0, -1]], [np.exp(-0.5), np.exp(-0.125)], atol=1e-15
    )
    (panel,) = plots.figure_of_secondaries(TRIANGLES, [3.0])
    np.testing.assert_array_equal(curve(panel, "x = 3"), [[0.0, 0.0], [0.0, 1.0]])
    assert (panel.get_xlabel(), panel.get_ylabel()) == ("membership u", "secondary grade")


def test_a_set_in_space_stands_over_its_footprint(drawn: list[Array]) -> None:
    panel: Any = plots.figure_in_space(TRIANGLES)[0]
    x, u, crest = (np.asarray(values) for values in panel.lines[0].get_data_3d())
    inside = (x >= 0.0) & (x <= 2.0)
    np.testing.assert_allclose(u, np.where(inside, 0.5, 0.0), atol=1e-12)
    np.testing.assert_array_equal(crest, 1.0)
    (surface,) = drawn
    over = surface.reshape(3, -1).T
    over = over[(over[:, 0] >= 0.0) & (over[:, 0] <= 2.0)]
    expected = np.clip(np.minimum((over[:, 1] - 0.2) / 0.3, (0.9 - over[:, 1]) / 0.4), 0.0, 1.0)
    # Walls at the α-cut of 0.01 go down to the floor.
    assert (np.isclose(over[:, 2], expected, atol=1e-9) | (over[:, 2] == 0.0)).all()
    assert over[:, 2].max() > 0.97
    assert (panel.get_xlabel(), panel.get_ylabel(), panel.get_zlabel()) == (
        "x",
        "membership u",
        "secondary grade",
    )


def test_no_sets_are_no_figure() -> None:
    with pytest.raises(InvalidValue, match="at least one fuzzy set"):
        plots.figure_of_sets({})
