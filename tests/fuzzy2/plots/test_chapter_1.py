"""Figures 1 to 5 of the thesis: what is drawn is what the sets say."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from fuzzy2 import plots
from tests.fuzzy2.plots.drawn import band, curve, edges

pytestmark = pytest.mark.usefixtures("styled")


def test_figure_1_blurs_a_triangle() -> None:
    """Triangles of all corners from those of the figure fill the footprint from edge to edge.

    J at x′ is its section.
    """
    ordinary, blurred = plots.figure_1()
    x, u = curve(ordinary, "membership")
    np.testing.assert_allclose(
        u, np.clip(np.minimum((x - 2.0) / 3.0, (8.0 - x) / 3.0), 0.0, 1.0), atol=1e-15
    )
    corners = band(blurred, "footprint of uncertainty")
    lefts, peaks, rights = np.meshgrid(
        np.linspace(1.0, 3.0, 5), np.linspace(4.5, 5.5, 11), np.linspace(7.3, 8.7, 5)
    )
    for point in np.unique(corners[:, 0])[5:-5:10]:
        grades = np.clip(
            np.minimum((point - lefts) / (peaks - lefts), (rights - point) / (rights - peaks)),
            0.0,
            1.0,
        )
        # Peaks are 0.1 apart, and between two of them a triangle reaches 0.05 times a slope of at
        # most 0.56 higher.
        np.testing.assert_allclose([grades.min(), grades.max()], edges(corners, point), atol=0.03)
        low, high = edges(corners, point)
        assert low - 1e-12 <= grades.min() <= grades.max() <= high + 1e-12
    place, ends = curve(blurred, "$J_{x'}$")
    assert place.tolist() == [4.0, 4.0]
    # half a step of 0.016 times a slope of 0.4
    np.testing.assert_allclose(ends, edges(corners, 4.0), atol=4e-3)


def test_figure_2_shows_secondary_grades() -> None:
    (panel,) = plots.figure_2()
    (image,) = panel.images
    grades: Any = image.get_array()
    left, right, bottom, top = image.get_extent()
    rows, columns = grades.shape
    x = left + (np.arange(columns) + 0.5) * (right - left) / columns
    u = bottom + (np.arange(rows) + 0.5) * (top - bottom) / rows
    # The set of the figure, written out again.
    principal = np.exp(-0.5 * ((x - 5.0) / 1.4) ** 2)
    spread = 0.02 + 0.10 * np.abs(x - 5.0) / 1.4 * principal
    np.testing.assert_allclose(
        grades, np.exp(-0.5 * ((u[:, None] - principal) / spread) ** 2), atol=1e-9
    )
    np.testing.assert_allclose(curve(panel, "principal"), [x, principal], atol=1e-12)
    np.testing.assert_allclose([u[0], u[-1]], [0.0, 1.0], atol=1e-15)
    assert image.get_clim() == (0.0, 1.0)
    assert [axes.get_ylabel() for axes in panel.figure.axes] == ["membership u", "secondary grade"]


def test_figure_3_shows_what_gaussians_of_uncertain_parameters_cover() -> None:
    """Lower and upper edge are the extremes over many means.

    Or over many standard deviations, from the interval of the uncertain one.
    """
    for panel, curves in zip(
        plots.figure_3(),
        (
            lambda x: [np.exp(-0.5 * ((x - m) / 1.2) ** 2) for m in np.linspace(4.2, 5.8, 801)],
            lambda x: [np.exp(-0.5 * ((x - 5.0) / s) ** 2) for s in np.linspace(0.8, 1.8, 801)],
        ),
        strict=True,
    ):
        corners = band(panel, "footprint of uncertainty")
        for x in np.unique(corners[:, 0])[10:-10:25]:
            grades = curves(x)
            # 801 means are 0.002 apart, over which a Gaussian changes by less than 1e-6 at its top,
            # where they fall between two.
            np.testing.assert_allclose(edges(corners, x), [min(grades), max(grades)], atol=1e-6)
    assert panel.get_title(loc="left") == "Uncertain standard deviation"


def test_figure_4_shows_union_and_intersection() -> None:
    """Principal curves under minimum and maximum are those of the principal curves.

    For convex normal sets.
    """
    sets, union, intersection = plots.figure_4()
    x, first = curve(sets, "first")
    _, second = curve(sets, "second")
    # The secondary of a Gaussian cut at 0 or 1 has its peak there, so its principal curve stays as
    # it is.
    np.testing.assert_allclose(curve(union, "union"), [x, np.maximum(first, second)], atol=1e-9)
    np.testing.assert_allclose(
        curve(intersection, "intersection"), [x, np.minimum(first, second)], atol=1e-9
    )
    grades: Any = intersection.images[0].get_array()
    assert grades.max() > 0.9
    assert [panel.get_title(loc="left") for panel in (union, intersection)] == [
        "Union",
        "Intersection",
    ]


def test_figure_5_shows_join_and_meet() -> None:
    """Against the extension principle on a grid of 1001 memberships.

    1e-3 is a step of the grid times the greatest slope, 10.
    """
    numbers, join, meet = plots.figure_5()
    v = np.linspace(0.0, 1.0, 1001)
    f = np.exp(-0.5 * ((v - 0.42) / 0.15) ** 2)
    g = np.clip(np.minimum((v - 0.25) / 0.35, (0.7 - v) / 0.1), 0.0, 1.0)
    grades = np.minimum(f[:, None], g)
    for panel, name, image in (
        (join, "join", np.maximum(v[:, None], v)),
        (meet, "meet", np.minimum(v[:, None], v)),
    ):
        theta, drawn = curve(panel, name)
        for point in (0.3, 0.42, 0.5, 0.6, 0.65, 0.69):
            expected = grades[np.isclose(image, point, atol=1e-9)].max()
            assert abs(np.interp(point, theta, drawn) - expected) < 1e-2
    assert {line.get_label() for line in numbers.lines} == {"F", "G"}
    assert meet.get_xlabel() == "membership θ"
