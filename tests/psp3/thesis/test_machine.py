"""The picture of the robot: whole, lit from the right side, with every part named."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import PolyCollection
from matplotlib.text import Text

from psp3.loading import load
from psp3.thesis import machine

ROBOT = load("psp3")


@pytest.fixture(scope="module")
def panel() -> machine.Axes:
    (panel,) = machine.figure_of_machine(ROBOT)
    return panel


def test_every_part_is_named_and_the_names_are_apart(panel: machine.Axes) -> None:
    figure = panel.get_figure(root=True)
    assert figure is not None
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    # Of a label with a line to its part the method of its own class gives the box of both.
    boxes = [Text.get_window_extent(text, canvas.get_renderer()) for text in panel.texts]
    assert len(boxes) == 6
    assert all(figure.bbox.contains(*corner) for box in boxes for corner in box.get_points())
    assert not any(one.overlaps(other) for one, other in combinations(boxes, 2))
    assert {text.get_text().split(",")[0] for text in panel.texts} == {
        *("screw", "nut 1", "nut 2", "nut 3", "star", "tip of the tool")
    }


def test_nothing_of_the_robot_is_outside_of_the_picture(panel: machine.Axes) -> None:
    (drawn,) = (one for one in panel.collections if isinstance(one, PolyCollection))
    corners = np.concatenate([path.vertices for path in drawn.get_paths()])
    (left, right), (low, high) = panel.get_xlim(), panel.get_ylim()
    assert left < corners[:, 0].min() < corners[:, 0].max() < right
    assert low < corners[:, 1].min() < corners[:, 1].max() < high


@pytest.mark.parametrize(
    ("shape", "volume"),
    [
        (machine.pin.hppfcl.Box(0.1, 0.2, 0.3), 0.006),
        # A prism of 20 sides, and a ball whose rings have 20 sides: a few percent are missing.
        (machine.pin.hppfcl.Cylinder(0.1, 0.5), np.pi * 0.005),
        (machine.pin.hppfcl.Sphere(0.1), 4.0 / 3.0 * np.pi * 0.001),
    ],
    ids=["box", "cylinder", "ball"],
)
def test_faces_close_a_shape_and_look_outward(shape: object, volume: float) -> None:
    """By Gauss's theorem: the fluxes of the position through the faces are three volumes."""
    total = 0.0
    for corners in machine._faces(shape):
        middle = corners.mean(axis=0)
        for one, other in zip(corners, np.roll(corners, -1, axis=0), strict=True):
            total += np.linalg.det([middle, one, other]) / 6.0
    assert total == pytest.approx(volume, rel=0.05)
    assert total <= volume * (1.0 + 1e-9)
