"""Figures of controllers at work; most of them are drawn by ``test_figures.py`` of the thesis."""

from __future__ import annotations

import psp3
from fuzzy2.plots.style import style
from psp3 import plots
from psp3.trajectories import Hold

ROBOT = psp3.load("psp3")


def test_figure_of_tracking_does_not_magnify_rounding() -> None:
    """A tip that rests leaves a path of no extent: the axes of the path still span a millimeter."""
    result = psp3.simulate(ROBOT, psp3.FeedForward(ROBOT), Hold(robot=ROBOT), 0.02)
    with style():
        panels = plots.figure_of_tracking(result, "at rest")
    for low, high in (
        panels[6].get_xlim(),
        panels[6].get_ylim(),
        panels[6].get_zlim(),  # type: ignore[attr-defined]
    ):
        assert high - low >= 1.0 - 1e-12
