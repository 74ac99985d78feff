"""Figures of workspaces: what is drawn is what the map holds, with units.

Lines lie where the closed form says.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection
from matplotlib.contour import QuadContourSet
from matplotlib.figure import Figure
from numpy.testing import assert_allclose, assert_array_equal

import psp3
from fuzzy2.plots.style import style
from psp3.errors import InvalidValue
from psp3.kinematics.border import Boundary
from psp3.kinematics.pose_map import KinematicMap, Status
from psp3.kinematics.workspace import Workspace
from psp3.plots.workspace import STATUS_COLORS, STATUS_NAMES, figure_of_cloud, figure_of_map
from tests.closed_form_kinematics import FiveBar
from tests.helpers import Array


@pytest.fixture(autouse=True)
def _styled() -> Iterator[None]:
    with style():
        yield


@pytest.fixture(scope="module")
def space() -> Workspace:
    return Workspace(psp3.load("five_bar"), "tip", ("x", "z"))


@pytest.fixture(scope="module")
def plane(space: Workspace) -> KinematicMap:
    return space.map({"x": np.linspace(-0.3, 0.3, 25), "z": np.linspace(-0.45, 0.25, 29)})


@pytest.fixture(scope="module")
def cranks() -> KinematicMap:
    space = Workspace(psp3.load("five_bar"), "tip", ("x", "z"), over="actuators")
    return space.map(
        {name: value + np.linspace(-1.0, 1.0, 33) for name, value in space.reference.items()}
    )


def drawn(panels: tuple[Any, ...]) -> Any:
    figure = panels[0].figure
    canvas: Any = FigureCanvasAgg(figure)
    canvas.draw()
    return figure


def lines(panel: Any, dashes: str) -> Array:
    """Vertices (N, 2) of the contour lines of a panel that have a linestyle."""
    vertices = [
        path.vertices
        for contour in panel.collections
        if isinstance(contour, QuadContourSet)
        and not contour.filled
        and contour.linestyles == [dashes]
        for path in contour.get_paths()
        if len(path.vertices)
    ]
    return np.concatenate(vertices) if vertices else np.empty((0, 2))


def test_six_panels_with_units(plane: KinematicMap) -> None:
    panels = figure_of_map(plane)
    figure = drawn(panels)
    titles = [panel.get_title(loc="left") for panel in panels]
    assert titles == [
        "Poses",
        "Actuation",
        "End effector",
        "Joint margin [mm]",
        "Condition",
        "Manipulability",
    ]
    assert panels[3].get_xlabel() == "tip x [mm]"
    assert panels[0].get_ylabel() == "tip z [mm]"
    assert_allclose(panels[0].get_xlim(), (-300.0, 300.0))
    assert_allclose(panels[5].get_ylim(), (-450.0, 250.0))
    # The axes of the six color bars are among them.
    assert len(figure.axes) == 12


def test_statuses_are_drawn_where_they_are(plane: KinematicMap) -> None:
    """Unreachable poses stay blank."""
    mesh = drawn(figure_of_map(plane)).axes[0].collections[0]
    shown = mesh.get_array().reshape(29, 25)
    assert_array_equal(np.ma.getmaskarray(shown), ~plane.reachable.T)
    assert_array_equal(shown.compressed(), plane.status.T[plane.reachable.T])
    assert set(STATUS_NAMES) == set(STATUS_COLORS) == set(Status) - {Status.UNREACHABLE}


def test_line_of_the_actuation_singularity(plane: KinematicMap) -> None:
    """The solid line is where the rods of the closed form are in line.

    Nodes are 25 mm apart, which turns rods of 280 mm by 0.09.
    """
    panel = figure_of_map(plane)[1]
    points = 1e-3 * lines(panel, "solid")
    assert len(points) > 12
    geometry = FiveBar()
    sines = []
    for point in points:
        rods = (point - geometry.elbows(geometry.inverse(point))) / geometry.rod
        sines.append(rods[0, 0] * rods[1, 1] - rods[0, 1] * rods[1, 0])
    reachable = np.isfinite(sines)
    assert reachable.mean() > 0.8
    assert np.abs(np.array(sines)[reachable]).max() < 0.09


def test_lines_over_the_cranks(cranks: KinematicMap) -> None:
    """The dashed line is where the closed form's Jacobian is singular.

    The dotted one is where a joint is at its limit, 1.5 or 2.6 rad.
    """
    panels = figure_of_map(cranks)
    assert panels[3].get_xlabel() == "leg1 shoulder [degrees]"
    angles, geometry = np.radians(lines(panels[2], "dashed")), FiveBar()
    assert len(angles) > 20
    stretch = np.linalg.norm(geometry.forward(angles)[:, np.newaxis] - geometry.shafts, axis=-1)
    ends = np.array([geometry.rod + geometry.crank, geometry.rod - geometry.crank])
    assert np.abs(stretch[..., np.newaxis] - ends).min(axis=(1, 2)).max() < 2e-3
    angles = np.radians(lines(panels[0], "dotted"))
    elbows = geometry.elbows(angles)
    with np.errstate(invalid="ignore"):
        reach = np.linalg.norm(geometry.forward(angles)[:, np.newaxis] - geometry.shafts, axis=-1)
        bends = np.pi - np.arccos(
            (geometry.crank**2 + geometry.rod**2 - reach**2) / (2.0 * geometry.crank * geometry.rod)
        )
    limits = np.minimum(np.abs(1.5 - np.abs(angles)), np.abs(2.6 - bends)).min(axis=1)
    assert len(elbows) > 20
    assert np.nanmax(limits) < 0.01


@pytest.mark.slow
def test_legend_names_the_lines_that_there_are(plane: KinematicMap, cranks: KinematicMap) -> None:
    for poses, names in (
        (plane, ["singularity of actuation", "limit of a joint"]),
        (cranks, ["singularity of the end effector", "limit of a joint"]),
    ):
        (legend,) = drawn(figure_of_map(poses)).legends
        assert [text.get_text() for text in legend.get_texts()] == names


def test_border_is_drawn_in_millimeters(space: Workspace, plane: KinematicMap) -> None:
    border = space.boundary(plane)
    panel = figure_of_map(plane, border)[0]
    (collection,) = [one for one in panel.collections if type(one) is LineCollection]
    assert_allclose(np.array(collection.get_segments()), 1e3 * border.segments)


def test_coordinates_of_two_units_need_not_be_equally_long() -> None:
    space = Workspace(psp3.load("planar_3rrr"), "tip", ("x", "y", "rz"))
    poses = space.map({"x": np.linspace(-0.05, 0.05, 6), "rz": np.linspace(-0.3, 0.3, 7)})
    panels = figure_of_map(poses)
    drawn(panels)
    assert panels[3].get_ylabel() == "tip rz [degrees]"
    assert panels[0].get_aspect() == "auto"


@pytest.mark.slow
def test_maps_that_hold_little_can_be_drawn(space: Workspace) -> None:
    """Nothing reachable; all values the same."""
    drawn(figure_of_map(space.map({"x": [2.0, 2.1], "z": [0.0, 0.1]})))
    drawn(figure_of_map(space.map({"x": [0.0, 1e-9], "z": [-0.3, -0.3 + 1e-9]})))


def test_cloud_of_a_planar_robot_is_flat(plane: KinematicMap) -> None:
    (panel,) = figure_of_cloud(plane)
    drawn((panel,))
    assert (panel.get_xlabel(), panel.get_ylabel()) == ("tip x [mm]", "tip z [mm]")
    points = np.concatenate([np.asarray(one.get_offsets()) for one in panel.collections])
    expected = 1e3 * plane.position[plane.reachable][:, [0, 2]]
    assert_allclose(np.sort(points, axis=0), np.sort(expected, axis=0))
    names = [text.get_text() for text in panel.get_legend().get_texts()]
    assert names == [
        STATUS_NAMES[Status(status)] for status in np.unique(plane.status[plane.reachable])
    ]


def test_cloud_in_space() -> None:
    space = Workspace(psp3.load("psp3"), "tip", ("x", "y", "z"), over="actuators")
    axis = np.linspace(-0.1, 0.1, 4)
    poses = space.map({"a1": axis, "a2": axis, "a3": axis})
    (panel,) = figure_of_cloud(poses)
    drawn((panel,))
    assert panel.name == "3d"
    assert panel.get_zlabel() == "tip z [mm]"  # type: ignore[attr-defined]
    assert sum(len(one.get_offsets()) for one in panel.collections) == poses.reachable.sum()


def test_given_axes_are_drawn_into(plane: KinematicMap) -> None:
    axes = tuple(Figure(figsize=(9.0, 5.0)).subplots(2, 3).flat)
    assert figure_of_map(plane, axes=axes) == axes
    own = Figure().subplots()
    assert figure_of_cloud(plane, axes=[own]) == (own,)


def test_what_cannot_be_drawn_is_refused(space: Workspace, plane: KinematicMap) -> None:
    axes = tuple(Figure().subplots(1, 2))
    with pytest.raises(InvalidValue, match="6 axes"):
        figure_of_map(plane, axes=axes)
    with pytest.raises(InvalidValue, match="one Axes"):
        figure_of_cloud(plane, axes=axes)
    with pytest.raises(InvalidValue, match="two coordinates"):
        figure_of_map(space.map({"x": [0.0, 0.1]}))
    with pytest.raises(InvalidValue, match="can be reached"):
        figure_of_cloud(space.map({"x": [2.0, 2.1], "z": [0.0, 0.1]}))


def test_an_empty_border_is_no_line(plane: KinematicMap) -> None:
    drawn(figure_of_map(plane, Boundary(np.zeros((0, 2, 2)), 0.0)))
