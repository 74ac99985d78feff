"""Figures of type-reduced sets: their ends, grades and crisp values."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from fuzzy2 import plots
from fuzzy2.errors import InvalidValue
from fuzzy2.numbers import GaussianNumber, IntervalNumber
from fuzzy2.reduction.general import TypeReducedPlanes, TypeReducedPoints
from fuzzy2.sets.shapes import Triangular
from fuzzy2.sets.type1 import SampledSet
from tests.fuzzy2.plots.drawn import curve

pytestmark = pytest.mark.usefixtures("styled")


def test_type_reduced_sets_show_ends_grades_and_crisp_values() -> None:
    planes = TypeReducedPlanes(
        np.array([0.5, 1.0]), np.array([[1.0, 4.0], [2.0, 3.5]]), np.array(2.6)
    )
    points = TypeReducedPoints(SampledSet([5.0, 6.0, 8.0], [0.5, 1.0, 0.5]), 6.25)
    reduced: dict[str, plots.Reduced] = {
        "interval": [1.0, 3.0],
        "number": IntervalNumber(2.0, 0.5),
        "Gaussian": GaussianNumber(4.0, 0.5),
        "planes": planes,
        "set": Triangular(0.0, 1.0, 5.0),
        "samples": SampledSet([1.0, 2.0], [1.0, 0.5]),
        "points": points,
    }
    (panel,) = plots.figure_of_type_reduced(reduced)
    np.testing.assert_array_equal(
        curve(panel, "interval"), [[1.0, 1.0, 3.0, 3.0], [0.0, 1.0, 1.0, 0.0]]
    )
    np.testing.assert_array_equal(curve(panel, "number")[0], [1.5, 1.5, 2.5, 2.5])
    y, grades = curve(panel, "Gaussian")
    np.testing.assert_allclose(grades, np.exp(-0.5 * ((y - 4.0) / 0.5) ** 2), atol=1e-15)
    np.testing.assert_array_equal(
        curve(panel, "planes"), [[1, 1, 2, 2, 3.5, 3.5, 4, 4], [0, 0.5, 0.5, 1, 1, 0.5, 0.5, 0]]
    )
    crisp = [
        line.get_xdata()[0]  # type: ignore[index]
        for line in panel.lines
        if line.get_linestyle() == "--"
    ]
    # The centroid of a triangle is the mean of its corners; of samples, the weighted mean.
    np.testing.assert_allclose(crisp, [2.0, 2.0, 4.0, 2.6, 2.0, 4.0 / 3.0, 6.25], rtol=1e-12)
    stems: Any = next(one for one in panel.collections if one.get_label() == "points")
    np.testing.assert_array_equal(stems.get_segments()[1], [[6.0, 0.0], [6.0, 1.0]])
    assert panel.get_xlabel() == "output y"


@pytest.mark.parametrize(
    "reduced",
    [
        [1.0, 2.0, 3.0],
        [np.nan, np.nan],
        IntervalNumber([1.0, 2.0], [0.1, 0.1]),
        GaussianNumber([1.0, 2.0], [0.1, 0.1]),
        TypeReducedPlanes(np.array([1.0]), np.full((1, 2), np.nan), np.array(np.nan)),
    ],
)
def test_what_is_no_single_type_reduced_set_is_refused(reduced: Any) -> None:
    with pytest.raises(InvalidValue, match="reduced"):
        plots.figure_of_type_reduced(reduced)
