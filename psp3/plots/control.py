"""Figures of runs under control: tracking, differences, and the terms of fuzzy controllers.

Every function draws into the given axes, or into those of a new figure, and returns them;
``axes[0].figure`` is the figure to save. No function uses ``matplotlib.pyplot``. The style follows
matplotlib's current settings::

    with fuzzy2.plots.style.style():
        figure_of_tracking(result, "PD")[0].figure.savefig("tracking.svg")
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from matplotlib import rcParams
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fuzzy2.learning.partition import term_names
from fuzzy2.plots.sets import figure_of_sets
from psp3.fuzzy_control.records import differences
from psp3.plots.panels import Panels, checked_result, checked_title, given_panels, muted
from psp3.simulation.result import Result

if TYPE_CHECKING:
    from psp3.fuzzy_control.computed_torque import FuzzyComputedTorque


def draw_tracking(axes: Sequence[Axes] | None, result: Result, title: str) -> Panels:
    """Draw heights, speeds and the path of the tip of a run."""
    checked_title(title)
    panels = given_panels(axes, 7)
    if panels is None:
        figure = Figure(figsize=(11.5, 6.4))
        figure.suptitle(title)
        grid = figure.add_gridspec(3, 3, width_ratios=(1.0, 1.0, 1.25))
        flat = [figure.add_subplot(grid[row, column]) for column in range(2) for row in range(3)]
        panels = (*flat, figure.add_subplot(grid[:, 2], projection="3d"))
    every = shown_samples(result.t.size)
    t = result.t[every]
    for panel, column in zip(panels[:6], (*range(3), *range(3)), strict=True):
        speeds = panel in panels[3:6]
        actual, desired = (
            (result.speeds, result.desired.speeds)
            if speeds
            else (result.heights, result.desired.heights)
        )
        # Drawn in this order, thin over thick, so both lines are visible where they coincide.
        panel.plot(t, actual[every, column], label="actual")
        panel.plot(
            t,
            desired[every, column],
            color=rcParams["text.color"],
            linestyle="--",
            linewidth=0.9,
            label="desired",
        )
        symbol = f"\\dot{{q}}_{column + 1}" if speeds else f"q_{column + 1}"
        panel.set_ylabel(f"${symbol}$ [{'m/s' if speeds else 'm'}]")
        panel.set_xlim(t[0], t[-1])
        if column == 2:
            panel.set_xlabel("time [s]")
        else:
            panel.tick_params(labelbottom=False)
    panels[0].set_title("heights of the nuts")
    panels[3].set_title("speeds of the nuts")
    space = panels[6]
    space.plot(*(1e3 * result.tip[every].T))
    space.plot(
        *(1e3 * result.desired.tip[every].T),
        color=panels[0].lines[1].get_color(),
        linestyle="--",
        linewidth=0.9,
    )
    space.set_title("path of the tip")
    space.set_xlabel("x [mm]")
    space.set_ylabel("y [mm]")
    space.set_zlabel("z [mm]", labelpad=8.0)  # type: ignore[attr-defined]
    space.locator_params(nbins=5)
    space.set_box_aspect((1.0, 1.0, 1.7), zoom=0.88)  # type: ignore[call-arg,arg-type]
    space.legend(["actual", "desired"], loc="upper right")
    return panels


def figure_of_tracking(result: Result, title: str, axes: Sequence[Axes] | None = None) -> Panels:
    """Draw Figures 52 and 53 for any controller: desired and actual heights, speeds and tip path.

    Parameters
    ----------
    result : Result
        A simulation.
    title : str
        Title of the figure.
    axes : sequence of 7 Axes, optional
        Three for the heights, three for the speeds, a 3D one for the path of the tip [mm]; new ones
        by default.

    Returns
    -------
    tuple of Axes
        The seven axes.

    Raises
    ------
    InvalidValue
        If another number of axes is given.
    """
    checked_result(result)
    panels = draw_tracking(axes, result, title)
    # Otherwise the axes of a straight path, or of a robot at rest, would magnify rounding errors.
    space: Any = panels[6]
    for axis in (space.xaxis, space.yaxis, space.zaxis):
        low, high = axis.get_view_interval()
        middle, half = 0.5 * (low + high), max(0.5 * (high - low), 0.5)
        axis.set_view_interval(middle - half, middle + half, ignore=True)
    return panels


DIFFERENCE_LABELS = (
    r"$\Delta q_{12}$ [m]",
    r"$\Delta q_{13}$ [m]",
    r"$\Delta\dot{q}_{12}$ [m/s]",
    r"$\Delta\dot{q}_{13}$ [m/s]",
)
"""Axis labels of the four inputs of the estimators."""


def figure_of_terms(
    axes: Sequence[Axes] | None, controller: FuzzyComputedTorque, title: str
) -> Panels:
    """Draw the terms of all inputs of a fuzzy controller."""
    panels = given_panels(axes, 4)
    if panels is None:
        figure = Figure(figsize=(9.0, 5.2), layout="constrained")
        figure.suptitle(title)
        panels = tuple(figure.subplots(2, 2, sharey=True).flat)
    for number, panel in enumerate(panels):
        draw_terms(panel, controller, number)
    return panels


def draw_terms(panel: Axes, controller: FuzzyComputedTorque, number: int) -> None:
    """Draw the terms of one input, and its trained range."""
    terms = controller.system_.inputs[number]
    low, high = controller.ranges_[:, number]
    reach = 0.15 * (high - low)
    figure_of_sets(dict(zip(term_names(len(terms)), terms, strict=True)), axes=panel)
    # Inputs are clamped to the trained range, so terms matter only within it.
    for end in (low, high):
        panel.axvline(end, color=muted(), linewidth=0.8, linestyle=":")
    panel.set(xlim=(low - reach, high + reach), xlabel=DIFFERENCE_LABELS[number])
    legend = panel.get_legend()
    assert legend is not None
    legend.set_loc("upper center")
    legend.set_bbox_to_anchor((0.5, 0.98), transform=panel.transAxes)
    panel.set_ylim(0.0, 1.35)
    panel.set_yticks([0.0, 0.5, 1.0])


def shown_samples(samples: int) -> slice:
    """Five hundred points look smooth, and keep the file small."""
    return slice(None, None, max(1, samples // 500))


def draw_differences(axes: Sequence[Axes] | None, result: Result, title: str) -> Panels:
    """Draw the four differences of a run and the path of its tip."""
    checked_title(title)
    panels = given_panels(axes, 5)
    if panels is None:
        # Placed by hand, because computing a layout with 3D axes takes as long as drawing them.
        figure = Figure(figsize=(11.5, 5.2))
        figure.set_layout_engine("none")
        figure.suptitle(title)
        grid = figure.add_gridspec(
            2,
            3,
            width_ratios=(1.0, 1.0, 1.25),
            left=0.065,
            right=0.96,
            bottom=0.1,
            top=0.86,
            wspace=0.3,
            hspace=0.18,
        )
        flat = [figure.add_subplot(grid[row, column]) for row in range(2) for column in range(2)]
        panels = (*flat, figure.add_subplot(grid[:, 2], projection="3d"))
    every = shown_samples(result.t.size)
    t, desired = result.t[every], result.desired
    actual_inputs = differences(result.heights[every], result.speeds[every])
    desired_inputs = differences(desired.heights[every], desired.speeds[every])
    for panel, actual, wanted, label in zip(
        panels[:4], actual_inputs.T, desired_inputs.T, DIFFERENCE_LABELS, strict=True
    ):
        panel.plot(t, actual, label="actual")
        panel.plot(
            t, wanted, color=rcParams["text.color"], linestyle="--", linewidth=0.9, label="desired"
        )
        panel.set(ylabel=label, xlim=(t[0], t[-1]))
    panels[0].legend(ncols=2, loc="lower center", bbox_to_anchor=(0.5, 1.0))
    for panel in panels[2:4]:
        panel.set_xlabel("time t [s]")
    space: Any = panels[4]
    space.plot(*(1e3 * result.tip[every].T), label="actual")
    space.plot(
        *(1e3 * desired.tip[every].T),
        color=rcParams["text.color"],
        linestyle="--",
        linewidth=0.9,
        label="desired",
    )
    space.set(title="Path of the tip", xlabel="x [mm]", ylabel="y [mm]")
    space.set_zlabel("z [mm]", labelpad=8.0)
    space.locator_params(nbins=5)
    space.set_box_aspect((1.0, 1.0, 1.4), zoom=0.85)
    return panels


def figure_of_differences(result: Result, title: str, axes: Sequence[Axes] | None = None) -> Panels:
    """Draw Figures 55 to 58 and 60 to 63.

    The figures show desired and actual inputs of the estimators, and the path of the tip.

    Parameters
    ----------
    result : Result
        A simulation.
    title : str
        Title of the figure.
    axes : sequence of 5 Axes, optional
        For the two differences of heights [m] and the two of speeds [m/s], and a 3D one for the
        path of the tip [mm]; new ones by default.

    Returns
    -------
    tuple of Axes
        The five axes.

    Raises
    ------
    InvalidValue
        If another number of axes is given.
    """
    checked_result(result)
    return draw_differences(axes, result, title)
