"""Figures of the workspaces of any robot.

They show maps with borders and singularities, and clouds of reached positions.

As in :mod:`psp3.plots`, every function draws into the given axes, or into those of a new figure,
and returns them.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal

import numpy as np
from matplotlib import rcParams
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.colors import BoundaryNorm, ListedColormap, LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from fuzzy2.plots.names import literal
from fuzzy2.plots.style import BLUE, GREEN, ORANGE, VERMILLION
from psp3.checks import Array
from psp3.errors import InvalidValue
from psp3.kinematics.border import Boundary
from psp3.kinematics.pose_map import KinematicMap, Status
from psp3.plots.panels import Panels

STATUS_NAMES = {
    Status.BEYOND_LIMIT: "beyond a limit",
    Status.SINGULAR: "near-singular",
    Status.APART: "cut off",
    Status.USABLE: "usable",
}
"""Statuses of reachable poses, in words."""

STATUS_COLORS = {
    Status.BEYOND_LIMIT: ORANGE,
    Status.SINGULAR: VERMILLION,
    Status.APART: BLUE,
    Status.USABLE: GREEN,
}

LINES: dict[Literal["solid", "dashed", "dotted"], str] = {
    "solid": "singularity of actuation",
    "dashed": "singularity of the end effector",
    "dotted": "limit of a joint",
}
"""Meaning of the lines in maps."""

LARGEST_CONDITION = 100.0
"""Condition numbers above this are drawn alike, because such poses are all equally useless."""


def figure_of_map(
    poses: KinematicMap, border: Boundary | None = None, axes: Sequence[Axes] | None = None
) -> Panels:
    """Draw a map over two coordinates: the status and the quality of its poses.

    Lines are singularities, where the grid crosses them, and limits of joints. Unreachable poses
    stay blank.

    Parameters
    ----------
    poses : KinematicMap
        A map over two coordinates.
    border : Boundary, optional
        A border to draw around the statuses, from
        :meth:`psp3.kinematics.workspace.Workspace.boundary`.
    axes : sequence of 6 Axes, optional
        For the status, the measures of actuation and of the end effector, the least distance of a
        joint from its limits [mm], the condition number of the frame's Jacobian, and its
        manipulability; those of a new figure by default.

    Returns
    -------
    tuple of Axes
        The six axes, over the two coordinates [mm or degrees].

    Raises
    ------
    InvalidValue
        If the map has other dimensions, or another number of axes is given.
    """
    if len(poses.grid) != 2:
        raise InvalidValue("poses", tuple(poses.grid), "a map over two coordinates")
    panels = tuple(np.ravel(np.asarray(axes, dtype=object))) if axes is not None else _new_panels()
    if len(panels) != 6:
        raise InvalidValue("axes", len(panels), "6 axes for this figure")
    (x, x_label), (y, y_label) = (_in_drawing_units(poses, name) for name in poses.grid)
    measures = poses.measures
    _draw_status(panels[0], poses, x, y)
    for panel, title, values in zip(
        panels[1:],
        ("Actuation", "End effector", "Joint margin [mm]", "Condition", "Manipulability"),
        (
            measures.actuation,
            measures.end_effector,
            1e3 * poses.margin,
            measures.condition,
            measures.manipulability,
        ),
        strict=True,
    ):
        panel.set_title(title)
        _draw_values(panel, x, y, values, title)
    same_unit = len({poses.units[name] for name in poses.grid}) == 1
    drawn = set().union(*(_draw_lines(panel, poses, x, y) for panel in panels))
    for panel in panels:
        panel.set(xlim=(x[0], x[-1]), ylim=(y[0], y[-1]), aspect="equal" if same_unit else "auto")
    for panel in panels[3:]:
        panel.set_xlabel(x_label)
    for panel in (panels[0], panels[3]):
        panel.set_ylabel(y_label)
    if border is not None:
        scale = [1e3 if poses.units[name] == "m" else np.degrees(1.0) for name in poses.grid]
        panels[0].add_collection(
            LineCollection(
                list(border.segments * scale), colors=rcParams["text.color"], linewidths=1.6
            )
        )
    if axes is None and drawn:
        shown = [dashes for dashes in LINES if dashes in drawn]
        handles = [
            Line2D([], [], color=rcParams["text.color"], linestyle=dashes, linewidth=1.3)
            for dashes in shown
        ]
        panels[0].figure.legend(
            handles,
            [LINES[dashes] for dashes in shown],
            loc="outside lower center",
            ncols=3,
            frameon=False,
        )
    return panels


def figure_of_cloud(poses: KinematicMap, axes: Sequence[Axes] | None = None) -> Panels:
    """Draw the positions of the frame in the poses of a map, colored by status.

    Parameters
    ----------
    poses : KinematicMap
        A map over any number of coordinates.
    axes : sequence of one Axes, optional
        One with the projection ``3d``, or any other if all positions lie in a plane of the base's
        axes; that of a new figure by default.

    Returns
    -------
    tuple of Axes
        The axes, over the base's coordinates [mm].

    Raises
    ------
    InvalidValue
        If no pose of the map is reachable, or another number of axes is given.
    """
    if not poses.reachable.any():
        raise InvalidValue("poses", poses.robot, "a map with poses that can be reached")
    places = 1e3 * poses.position[poses.reachable]
    flat = np.ptp(places, axis=0) < 1e-6
    shown = [k for k in range(3) if not (flat.sum() == 1 and flat[k])]
    if axes is None:
        projection = {"projection": "3d"} if len(shown) == 3 else {}
        axes = (Figure(figsize=(5.4, 5.0), layout="constrained").add_subplot(**projection),)
    panels: Panels = tuple(axes)
    if len(panels) != 1:
        raise InvalidValue("axes", len(panels), "one Axes for this figure")
    # Matplotlib's 3D axes accept more arguments than their type says.
    panel: Any = panels[0]
    statuses = poses.status[poses.reachable]
    for status in sorted(set(statuses.tolist())):
        points = places[statuses == status][:, shown].T
        panel.scatter(
            *points,
            s=6.0,
            color=STATUS_COLORS[Status(status)],
            label=STATUS_NAMES[Status(status)],
            linewidths=0.0,
        )
    panel.set_aspect("equal")
    if len(shown) == 3:
        # Room for the label of the third axis, which constrained layout ignores.
        panel.set_box_aspect(None, zoom=0.86)
    for axis, k in zip("xyz", shown, strict=False):
        getattr(panel, f"set_{axis}label")(f"{poses.frame} {'xyz'[k]} [mm]")
    panel.legend(loc="upper left", markerscale=2.0)
    return panels


def _new_panels() -> Panels:
    return tuple(Figure(figsize=(11.5, 6.8), layout="constrained").subplots(2, 3).flat)


def _in_drawing_units(poses: KinematicMap, name: str) -> tuple[Array, str]:
    """Return the values of a coordinate in mm or degrees, and its label."""
    label = f"{poses.frame} {name}" if poses.over == "task" else name.replace("_", " ")
    if poses.units[name] == "m":
        return 1e3 * poses.grid[name], literal(f"{label} [mm]")
    return np.degrees(poses.grid[name]), literal(f"{label} [degrees]")


def _draw_status(panel: Axes, poses: KinematicMap, x: Array, y: Array) -> None:
    colors = ListedColormap([STATUS_COLORS[status] for status in STATUS_NAMES])
    norm = BoundaryNorm(np.arange(0.5, 5.0), colors.N)
    shown = np.ma.masked_less(poses.status, Status.BEYOND_LIMIT)
    panel.pcolormesh(x, y, shown.T, cmap=colors, norm=norm, shading="nearest", alpha=0.75)
    ticks = [float(status) for status in STATUS_NAMES]
    bar = panel.figure.colorbar(ScalarMappable(norm, colors), ax=panel, ticks=ticks, shrink=0.9)
    bar.ax.set_yticklabels(list(STATUS_NAMES.values()))
    bar.ax.grid(visible=False)
    panel.set_title("Poses")


def _draw_values(panel: Axes, x: Array, y: Array, values: Array, title: str) -> None:
    known = values[np.isfinite(values)]
    if not known.size:
        return
    # Near a singularity a few huge values would hide all others.
    low, high = (float(value) for value in np.quantile(known, [0.02, 0.98]))
    ticks: list[float] | None = None
    norm: Normalize
    if title == "Condition":
        levels, norm = np.geomspace(1.0, LARGEST_CONDITION, 13), LogNorm(1.0, LARGEST_CONDITION)
        ticks = [1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0]
    elif title == "Manipulability" and high > 20.0 * low > 0.0:
        levels, norm = np.geomspace(low, high, 13), LogNorm(low, high)
        ticks = [float(f"{value:.1g}") for value in np.geomspace(low, high, 7)[1:-1]]
    else:
        if title == "Joint margin [mm]":
            low = max(low, -high) if high > 0.0 else low
        elif title != "Manipulability":
            low = 0.0
        levels = np.asarray(MaxNLocator(12).tick_values(low, max(high, low + 1e-9)))
        norm = Normalize(levels[0], levels[-1])
    data = np.ma.masked_invalid(np.where(np.isposinf(values), 1e300, values)).T
    filled = panel.contourf(x, y, data, levels=levels, norm=norm, extend="both")
    # Otherwise vector formats show the seams between the levels.
    filled.set_edgecolor("face")
    bar = panel.figure.colorbar(
        filled, ax=panel, ticks=ticks, format=None if ticks is None else "%g", shrink=0.9
    )
    bar.ax.minorticks_off()
    bar.ax.grid(visible=False)


def _draw_lines(
    panel: Axes, poses: KinematicMap, x: Array, y: Array
) -> set[Literal["solid", "dashed", "dotted"]]:
    """Draw singularities and limits as the lines on which signed quantities vanish.

    Return the line styles that were used.
    """
    measures = poses.measures
    drawn: set[Literal["solid", "dashed", "dotted"]] = set()
    for values, dashes in zip(
        (
            measures.assembly * measures.actuation,
            measures.orientation * measures.assembly * measures.end_effector,
            np.where(np.isinf(poses.margin), np.nan, poses.margin),
        ),
        LINES,
        strict=True,
    ):
        data = np.ma.masked_invalid(values).T
        if data.count() and data.min() < 0.0 < data.max():
            panel.contour(
                x,
                y,
                data,
                levels=[0.0],
                colors=[rcParams["text.color"]],
                linestyles=[dashes],
                linewidths=[1.3],
            )
            drawn.add(dashes)
    return drawn
