"""Figures of the 3-PSP: its workspace, and the forces along a motion."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg

import psp3
from fuzzy2.plots.style import style
from psp3 import plots
from psp3.errors import InvalidValue, UnknownName
from psp3.three_psp import workspace
from psp3.trajectories import Helix, Hold
from psp3.trajectories.screw_forces import ScrewForces, screw_forces

ROBOT = psp3.load("psp3")

HEIGHTS = np.random.default_rng(0).uniform(-0.15, 0.15, size=(20, 3))


@pytest.fixture
def _styled() -> Iterator[None]:
    with style():
        yield


@pytest.mark.slow
@pytest.mark.usefixtures("_styled")
@pytest.mark.parametrize("over", ["tilt", "tip"])
def test_figure_of_the_workspace_has_units_and_the_fold(over: str) -> None:
    shares = np.linspace(0.0, 1.0, 12)[:, np.newaxis]
    around = np.radians(np.linspace(-180.0, 180.0, 25))
    whole = np.radians(80.0) * shares
    poses = (
        workspace.map_over_tilt(ROBOT, whole, around)
        if over == "tilt"
        else workspace.map_over_reach(ROBOT, shares, around)
    )
    panels = plots.figure_of_workspace(ROBOT, poses, over)
    figure: Any = panels[0].figure
    canvas: Any = FigureCanvasAgg(figure)
    canvas.draw()
    titles = " ".join(panel.get_title(loc="left") for panel in panels)
    for part in (
        "Parasitic motion of the center [mm]",
        "Shortest arm [mm]",
        "Longest arm [mm]",
        "tip Jacobian",
        "mass matrix",
    ):
        assert part in titles
    unit = "[degrees]" if over == "tilt" else "[mm]"
    assert unit in panels[3].get_xlabel()
    assert unit in panels[0].get_ylabel()
    low, high = panels[0].get_xlim()
    if over == "tilt":
        # The last line is the dashed fold: its distance from the middle is the tilt.
        x, y = np.array(panels[0].lines[-1].get_data(), dtype=float)
        np.testing.assert_allclose(
            np.hypot(x, y), np.degrees(workspace.fold_tilt(ROBOT, np.arctan2(y, x))), atol=1e-9
        )
        np.testing.assert_allclose((low, high), (-80.0, 80.0))
    else:
        np.testing.assert_allclose(low, -1e3 * ROBOT.tip_reach(np.pi), rtol=1e-9)
        assert not panels[0].lines


@pytest.mark.usefixtures("_styled")
def test_figure_of_the_workspace_refuses_what_it_cannot_draw() -> None:
    poses = workspace.map_over_tilt(
        ROBOT, np.linspace(0.0, 0.5, 3)[:, np.newaxis], np.linspace(0.0, 6.2, 5)
    )
    with pytest.raises(UnknownName, match="moon"):
        plots.figure_of_workspace(ROBOT, poses, "moon")
    with pytest.raises(InvalidValue, match="6 axes"):
        plots.figure_of_workspace(ROBOT, poses, axes=plots.figure_of_workspace(ROBOT, poses)[:2])
    with pytest.raises(InvalidValue, match="N by K"):
        plots.figure_of_workspace(ROBOT, workspace.map_at_heights(ROBOT, HEIGHTS))


def figure_of(forces: ScrewForces) -> plots.Panels:
    with style():
        panels = plots.figure_of_torques(forces)
        figure: Any = panels[0].figure
        canvas: Any = FigureCanvasAgg(figure)
        canvas.draw()
    return panels


def test_figure_shows_the_numbers_with_their_units() -> None:
    forces = screw_forces(Helix(robot=ROBOT), np.linspace(0.0, 2.0, 101))
    panels = figure_of(forces)
    motion = forces.motion
    curves = (
        1e3 * motion.tip,
        1e3 * motion.heights,
        forces.forces,
        motion.speeds,
        motion.accelerations,
    )
    for panel, values, unit in zip(
        panels, curves, ("[mm]", "[mm]", "[N]", "[m/s]", "[m/s²]"), strict=False
    ):
        for line, column in zip(panel.lines, values.T, strict=True):
            np.testing.assert_array_equal(
                np.array(line.get_data(), dtype=float), [forces.t, column]
            )
        assert unit in panel.get_ylabel()
    gravity = next(line for line in panels[5].lines if "gravity" in str(line.get_label()))
    np.testing.assert_allclose(
        np.asarray(gravity.get_ydata(), dtype=float), np.linalg.norm(forces.gravity, axis=-1)
    )
    assert "[s]" in panels[5].get_xlabel()


@pytest.mark.slow
def test_figure_of_a_tip_at_rest_and_of_one_sample_can_be_drawn() -> None:
    """Warnings are errors here: zeros on the logarithmic scale and empty limits would raise."""
    figure_of(screw_forces(Hold(robot=ROBOT), [0.0, 1.0]))
    figure_of(screw_forces(Hold(robot=ROBOT), [0.0]))


def test_figure_refuses_another_number_of_axes() -> None:
    forces = screw_forces(Hold(robot=ROBOT), [0.0, 1.0])
    with pytest.raises(InvalidValue, match="6 axes"):
        plots.figure_of_torques(forces, figure_of(forces)[:3])
