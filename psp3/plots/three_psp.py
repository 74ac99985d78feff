"""Figures of the 3-PSP: screw forces along a path, and its workspace."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

from psp3.checks import checked_kind, known_name
from psp3.errors import InvalidValue
from psp3.plots.panels import Panels, given_panels
from psp3.three_psp.robot import PSP3
from psp3.three_psp.workspace import WorkspaceMap, fold_tilt
from psp3.trajectories.screw_forces import ScrewForces


def figure_of_torques(forces: ScrewForces, axes: Sequence[Axes] | None = None) -> Panels:
    """Draw the steps from the tip's motion to the screw forces (after Figs 27, 28 and 31).

    Parameters
    ----------
    forces : ScrewForces
        From :func:`psp3.trajectories.screw_forces.screw_forces`.
    axes : sequence of 6 Axes, optional
        For the tip [mm], the heights [mm], the forces [N], the speeds [m/s], the accelerations
        [m/s²], and the norms of the three terms of the forces [N]; those of a new figure by
        default.

    Returns
    -------
    tuple of Axes
        The six axes.

    Raises
    ------
    InvalidValue
        If another number of axes is given.
    """
    checked_kind("forces", forces, ScrewForces, "forces along a motion, a ScrewForces")
    panels = given_panels(axes, 6) or tuple(
        Figure(figsize=(11.5, 5.8), layout="constrained").subplots(2, 3).flat
    )
    tip, heights, screws, speeds, accelerations, terms = panels
    motion, nuts = forces.motion, ("1", "2", "3")
    for panel, values, names, title, label in (
        (tip, 1e3 * motion.tip, ("x", "y", "z"), "Tip", "position [mm]"),
        (heights, 1e3 * motion.heights, nuts, "Nut heights", "height a [mm]"),
        (screws, forces.forces, nuts, "Screw forces", "force \N{GREEK SMALL LETTER TAU} [N]"),
        (speeds, motion.speeds, nuts, "Nut speeds", "speed [m/s]"),
        (accelerations, motion.accelerations, nuts, "Nut accelerations", "acceleration [m/s²]"),
    ):
        # Coinciding lines, as in a motion along arm 1, show through the gaps of those drawn over
        # them.
        for column, name, dashes in zip(
            values.T, names, ("-", (0, (6, 2)), (0, (2, 2))), strict=True
        ):
            panel.plot(forces.t, column, label=name, linestyle=dashes)
        panel.set(ylabel=label)
        panel.set_title(title)
    tip.legend(ncols=3)
    heights.legend(ncols=3, title="screw")
    for values, name in (
        (forces.gravity, "gravity, G"),
        (forces.inertial, "inertia, M ä"),
        (forces.coriolis, "Coriolis, C ȧ"),
    ):
        size = np.linalg.norm(values, axis=-1)
        # A term that is zero has no place on a logarithmic scale.
        terms.plot(forces.t, np.where(size > 0.0, size, np.nan), label=name)
    terms.set(yscale="log", ylabel="norm over the screws [N]")
    terms.set_title("What the forces are made of")
    terms.legend()
    for panel in panels:
        if forces.t.size > 1:
            panel.set_xlim(forces.t[0], forces.t[-1])
    for panel in panels[3:]:
        panel.set_xlabel("time t [s]")
    return panels


def figure_of_workspace(
    robot: PSP3, poses: WorkspaceMap, over: str = "tilt", axes: Sequence[Axes] | None = None
) -> Panels:
    """Draw the quality of poses over the workspace.

    Parameters
    ----------
    robot : PSP3
        The robot, for the fold of the tip's map.
    poses : WorkspaceMap
        A map of N by K poses, N tilts by K azimuths that go once around: from
        :func:`psp3.three_psp.workspace.map_over_tilt`, or from
        :func:`psp3.three_psp.workspace.map_over_reach`.
    over : {"tilt", "tip"}
        The two coordinates of the panels: tilt toward x and y [degrees], or the tip's x and y [mm].
    axes : sequence of 6 Axes, optional
        For the tip's distance from the vertical axis [mm] (over the tip: the tilt [degrees]), the
        parasitic motion [mm], the shortest and the longest arm [mm], and the condition numbers of
        the tip Jacobian and of the mass matrix; those of a new figure by default.

    Returns
    -------
    tuple of Axes
        The six axes.

    Raises
    ------
    InvalidValue
        If another number of axes is given, or the map has other dimensions.
    UnknownName
        If ``over`` has another value.
    """
    checked_kind("poses", poses, WorkspaceMap, "a map of the workspace")
    known_name("coordinates of a workspace figure", over, ("tilt", "tip"))
    if poses.tilt.ndim != 2 or min(poses.tilt.shape) < 2:
        raise InvalidValue("poses", poses.tilt.shape, "a map of N by K poses, both at least 2")
    panels = given_panels(axes, 6) or tuple(
        Figure(figsize=(11.5, 6.6), layout="constrained").subplots(2, 3).flat
    )
    tilt = np.degrees(poses.tilt)
    distance = 1e3 * np.hypot(poses.tip[..., 0], poses.tip[..., 1])
    if over == "tilt":
        x, y = tilt * np.cos(poses.azimuth), tilt * np.sin(poses.azimuth)
        first, labels = (
            ("Tip from the vertical axis [mm]", distance),
            ("tilt toward x [degrees]", "tilt toward y [degrees]"),
        )
    else:
        x, y = 1e3 * poses.tip[..., 0], 1e3 * poses.tip[..., 1]
        first, labels = ("Tilt [degrees]", tilt), ("tip x [mm]", "tip y [mm]")
    around = np.linspace(0.0, 2.0 * np.pi, 181)
    fold = np.degrees(fold_tilt(robot, around))
    for panel, (title, values) in zip(
        panels,
        (
            first,
            ("Parasitic motion of the center [mm]", 1e3 * poses.parasitic_motion),
            ("Shortest arm [mm]", 1e3 * poses.arms.min(axis=-1)),
            ("Longest arm [mm]", 1e3 * poses.arms.max(axis=-1)),
            ("Condition of the tip Jacobian", poses.tip_condition),
            ("Condition of the mass matrix", poses.mass_condition),
        ),
        strict=True,
    ):
        data = np.ma.masked_invalid(values)
        if values is poses.tip_condition:
            # Cut at 100: condition numbers are infinite on the fold, and poses above 100 are all
            # equally useless.
            levels = np.geomspace(1.0, 100.0, 13)
            filled = panel.contourf(
                x, y, data, levels=levels, norm=LogNorm(1.0, 100.0), extend="max"
            )
            ticks: list[float] | None = [1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0]
        else:
            filled, ticks = panel.contourf(x, y, data, levels=12), None
        # Otherwise vector formats show the seams between the levels.
        filled.set_edgecolor("face")
        bar = panel.figure.colorbar(
            filled, ax=panel, ticks=ticks, format=None if ticks is None else "%g", shrink=0.9
        )
        bar.ax.grid(visible=False)
        if over == "tilt" and fold.min() < tilt.max():
            panel.plot(fold * np.cos(around), fold * np.sin(around), color="white", linewidth=1.6)
            panel.plot(
                fold * np.cos(around),
                fold * np.sin(around),
                color="black",
                linestyle="--",
                linewidth=0.9,
                label="the tip folds",
            )
        panel.set(aspect="equal", xlim=(x.min(), x.max()), ylim=(y.min(), y.max()))
        panel.set_title(title)
    for panel in panels[3:]:
        panel.set_xlabel(labels[0])
    for panel in (panels[0], panels[3]):
        panel.set_ylabel(labels[1])
    if panels[0].lines:
        panels[0].legend(handles=[panels[0].lines[-1]], loc="lower left")
    return panels
