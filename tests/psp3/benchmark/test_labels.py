"""Names beside points: found by the boxes of what is drawn."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.text import Annotation, Text

from psp3.benchmark.labels import label_points
from psp3.checks import Array

POINT = 5.0


def labeled(points: Array, figure: Figure) -> tuple[Axes, list[Annotation]]:
    """Return axes with points of pretty long names, and these."""
    axes = figure.subplots()
    axes.plot(*points.T, "o", markersize=POINT)
    axes.set(xscale="log", yscale="log")
    axes.margins(0.12)
    names = [f"it2-least-squares {number}" for number in range(len(points))]
    label_points(axes, [tuple(point) for point in points], names, ["black"] * len(points))
    figure.draw_without_rendering()
    return axes, [text for text in axes.texts if isinstance(text, Annotation)]


def points_in_clouds(count: int, seed: int) -> Array:
    """Return points about three places, most of which would have their names on each other."""
    rng = np.random.default_rng(seed)
    clouds = np.log([[1e1, 1e0], [1.2e1, 2e0], [3e2, 1.5e0]])
    return np.exp(clouds[rng.integers(3, size=count)] + 0.08 * rng.standard_normal((count, 2)))


@pytest.mark.parametrize("seed", range(4))
def test_names_cover_neither_names_nor_points_and_stay_in_the_axes(seed: int) -> None:
    """As many as there are entries, of the greatest length, at the size of the board's picture."""
    points = points_in_clouds(26, seed)
    axes, labels = labeled(points, Figure(figsize=(8.0, 5.0), layout="constrained"))
    # Text alone: the extent of an annotation has its line in it, too.
    boxes = [Text.get_window_extent(label) for label in labels]
    assert len(boxes) == len(points)
    for one, other in itertools.combinations(boxes, 2):
        assert not one.overlaps(other)
    radius = 0.5 * POINT * axes.figure.dpi / 72.0
    for x, y in axes.transData.transform(points):
        for box in boxes:
            nearest = np.clip([x, y], box.min, box.max)
            assert np.hypot(*(nearest - [x, y])) > radius
    for box in boxes:
        assert axes.bbox.x0 <= box.x0 <= box.x1 <= axes.bbox.x1
        assert axes.bbox.y0 <= box.y0 <= box.y1 <= axes.bbox.y1


def test_a_name_that_has_room_is_beside_its_point_without_a_line() -> None:
    _, labels = labeled(np.array([[1.0, 1.0], [100.0, 100.0]]), Figure(figsize=(8.0, 5.0)))
    assert [label.arrow_patch for label in labels] == [None, None]
    for label in labels:
        assert np.hypot(*label.xyann) < 0.6 * Text.get_window_extent(label).width


def test_where_there_is_no_room_every_name_is_written_all_the_same() -> None:
    _, labels = labeled(points_in_clouds(30, 0), Figure(figsize=(1.5, 1.0)))
    assert len(labels) == 30
