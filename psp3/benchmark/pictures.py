"""Pictures of a board: errors in every cell, and errors against the time of a step."""

from __future__ import annotations

import io
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fuzzy2.plots.names import literal
from fuzzy2.plots.panels import cycle_colors
from fuzzy2.plots.style import style
from psp3.benchmark.board import Board, Cell
from psp3.benchmark.labels import label_points
from psp3.benchmark.readings import NONE
from psp3.benchmark.tasks import PATHS
from psp3.plots.panels import Panels, given_panels

MARKERS = "osv^DPX*"
"""Colors of the conditions, in order."""

LINE = 0.3
"""Height of the line of an entry [inch]."""

SPREAD = 0.75
"""Share of an entry's line that its cells take."""

POINT = 5.0
"""Size of the point of an entry [points]."""

LONGEST = 24
"""Number of letters of a name that are drawn."""


def condition(cell: Cell) -> str:
    """Return the noise of a cell in words."""
    return "no noise" if cell.reading == NONE else f"{cell.reading}, {cell.snr_db:g} dB"


def figure_of_cells(board: Board, axes: Sequence[Axes] | None = None) -> Panels:
    """Draw the error of every entry in every cell, with its interval.

    Parameters
    ----------
    board : Board
        The scores.
    axes : sequence of Axes, optional
        One for each robot; those of a new figure by default.

    Returns
    -------
    tuple of Axes
        The axes.

    Raises
    ------
    InvalidValue
        If another number of axes is given.
    """
    names = [_shown(score.entry.name) for score in board.ranked]
    panels = given_panels(axes, len(board.robots))
    if panels is None:
        figure = Figure(
            figsize=(max(8.0, 2.0 + 3.0 * len(board.robots)), 2.2 + LINE * len(names)),
            layout="constrained",
        )
        panels = tuple(figure.subplots(1, len(board.robots), sharey=True, squeeze=False).flat)
    lines = np.arange(len(names))
    for panel, robot in zip(panels, board.robots, strict=True):
        cells = [cell for cell in board.cells if cell.robot == robot]
        conditions = list(dict.fromkeys(map(condition, cells)))
        for place, cell in enumerate(cells):
            number = conditions.index(condition(cell))
            color = cycle_colors()[number % len(cycle_colors())]
            found = [score.cells[cell].error for score in board.ranked]
            value, low, high = (
                1e3 * np.array([getattr(one, end) for one in found])
                for end in ("value", "low", "high")
            )
            reach = np.nan_to_num(np.maximum(np.stack([value - low, high - value]), 0.0))
            panel.errorbar(
                value,
                lines + SPREAD * ((place + 0.5) / len(cells) - 0.5),
                xerr=reach,
                fmt=MARKERS[number % len(MARKERS)],
                color=color,
                markerfacecolor=color if cell.path == PATHS[0] else "none",
                markersize=4.5,
                linewidth=1.0,
                label=f"{condition(cell)}, {cell.path} path",
            )
        panel.set(xscale="log", title=robot, xlabel="error of the tip [mm]")
    panels[0].set_yticks(lines, names)
    panels[0].set_ylim(len(names) - 0.5, -0.5)
    if axes is None:
        handles, labels = panels[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper center", ncols=2)
    return panels


def figure_of_times(board: Board, axes: Sequence[Axes] | None = None) -> Panels:
    """Draw the error over all cells against the time of a step, one point per entry.

    Parameters
    ----------
    board : Board
        The scores.
    axes : sequence of 1 Axes, optional
        Those of a new figure by default.

    Returns
    -------
    tuple of Axes
        The axes.

    Raises
    ------
    InvalidValue
        If another number of axes is given.
    """
    panels = given_panels(axes, 1)
    if panels is None:
        panels = (Figure(figsize=(8.0, 5.0), layout="constrained").subplots(),)
    (panel,) = panels
    points = [(1e6 * score.step_time, 1e3 * score.error.value) for score in board.ranked]
    colors = [panel.plot(*point, "o", markersize=POINT)[0].get_color() for point in points]
    panel.set(
        xscale="log", yscale="log", xlabel="time of a step [µs]", ylabel="error of the tip [mm]"
    )
    panel.margins(0.12)
    names = [_shown(score.entry.name) for score in board.ranked]
    label_points(panel, points, names, colors)
    return panels


def _shown(name: str) -> str:
    """Return the label of a name, cut if it is too long."""
    return literal(name if len(name) <= LONGEST else name[: LONGEST - 1] + "…")


def as_svg(panels: Panels) -> bytes:
    """Return the figure of axes as SVG, the same text every time."""
    text = io.BytesIO()
    drawn: Any = panels[0].get_figure(root=True)
    with style("light"):
        drawn.savefig(text, format="svg", metadata={"Date": None})
    return text.getvalue()
