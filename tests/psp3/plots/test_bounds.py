"""The figure of a tube: what is drawn is the tube, and the errors in it."""

from __future__ import annotations

import numpy as np
import pytest

import psp3
from psp3 import plots
from psp3.bounds import runs_needed
from psp3.errors import InvalidValue
from tests.psp3.bounds.synthetic import KP, KV, PERIOD, constant, disturbed


def test_panels_show_the_tube_and_the_errors() -> None:
    bounds = np.array([0.5, 0.2])
    tube = psp3.TrackingTube([constant(bounds)] * runs_needed(0.9), KP, KV, share=0.9)
    runs = [constant(0.5 * bounds), disturbed(np.zeros((60, 1, 2)), start=(0.002, 0.0))]
    panels = plots.figure_of_tube(tube, runs)
    assert len(panels) == 2
    for i, panel in enumerate(panels):
        for line, run in zip(panel.lines, runs, strict=True):
            np.testing.assert_array_equal(line.get_ydata(), -run.positions[:, i])
        (band,) = panel.collections
        reach = tube.around(runs[0])[:, i]
        corners = np.asarray(band.get_paths()[0].vertices)
        assert corners[:, 1].max() == reach.max()
        assert corners[:, 1].min() == -reach.max()
    assert panels[-1].get_xlabel() == "time [s]"
    again = plots.figure_of_tube(tube, runs[:1], panels)
    assert again == panels
    with pytest.raises(InvalidValue):
        plots.figure_of_tube(tube, runs, panels[:1])


def test_each_run_is_looked_at_and_one_alone_is_no_list() -> None:
    tube = psp3.TrackingTube([constant(np.array([0.5, 0.2]))] * runs_needed(0.9), KP, KV, share=0.9)
    run = constant(np.array([0.1, 0.1]))
    slower = disturbed(np.zeros((60, 1, 2)), period=2.0 * PERIOD)
    for other, match in ((slower, "a period"), (constant(np.array([0.1])), "1 coordinates")):
        with pytest.raises(InvalidValue, match=match):
            plots.figure_of_tube(tube, [run, other])
    for wrong in (run, []):
        with pytest.raises(InvalidValue, match="a list of one or more runs"):
            plots.figure_of_tube(tube, wrong)  # type: ignore[arg-type]
