"""Figures of motions of any robot, a line a joint."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import cycle

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from psp3.checks import Array
from psp3.kinematics.tasks import rotating
from psp3.plots.panels import Panels, given_panels
from psp3.robots.robot import Robot
from psp3.simulation.result import Result
from psp3.trajectories.screw_forces import ScrewForces

DASHES = ("-", (0, (6, 2)), (0, (2, 2)))
"""Lines that coincide show through the gaps of those drawn over them."""

NAMED = 8
"""So many joints are named in a legend; more would hide what is drawn."""


def figure_of_joint_tracking(
    robot: Robot, result: Result, title: str, axes: Sequence[Axes] | None = None
) -> Panels:
    """Draw a simulation of any robot: positions beside the desired ones, errors, and forces.

    Parameters
    ----------
    robot : Robot
        The robot that was simulated.
    result : Result
        What happened.
    title : str
        What was simulated.
    axes : sequence of 3 Axes, optional
        For the positions, their errors and the forces over time [s]; those of a new figure by
        default.

    Returns
    -------
    tuple of Axes
        The three axes. Positions and errors are in rad and m, forces in N m and N, as the joints
        turn or slide.

    Raises
    ------
    InvalidValue
        If another number of axes is given.
    """
    panels = given_panels(axes, 3)
    if panels is None:
        figure = Figure(figsize=(9.0, 7.6), layout="constrained")
        figure.suptitle(title)
        panels = tuple(figure.subplots(3, 1, sharex=True))
    positions, errors, forces = panels
    length, force = _units(robot)
    _draw(positions, result.t, result.positions, robot.actuated)
    for line, column in zip(positions.lines, result.desired.positions.T, strict=True):
        positions.plot(result.t, column, color=line.get_color(), linestyle=":", linewidth=1.0)
    _draw(errors, result.t, result.desired.positions - result.positions, robot.actuated)
    _draw(forces, result.t, result.torque, robot.actuated)
    for panel, name, unit in (
        (positions, "position (desired: dotted)", length),
        (errors, "error", length),
        (forces, "force", force),
    ):
        panel.set(ylabel=f"{name} [{unit}]", xlim=(result.t[0], result.t[-1]))
    forces.set_xlabel("time t [s]")
    _name(positions, robot.actuated)
    return panels


def figure_of_joint_forces(
    robot: Robot, forces: ScrewForces, title: str, axes: Sequence[Axes] | None = None
) -> Panels:
    """Draw a motion of any robot with the forces that it takes.

    Parameters
    ----------
    robot : Robot
        The robot that moves.
    forces : ScrewForces
        From :func:`psp3.trajectories.screw_forces.screw_forces`.
    title : str
        What is drawn.
    axes : sequence of 4 Axes, optional
        For positions, speeds, accelerations and forces over time [s]; those of a new figure by
        default.

    Returns
    -------
    tuple of Axes
        The four axes; units are those of the joints, with rad and N m where they turn.

    Raises
    ------
    InvalidValue
        If another number of axes is given.
    """
    panels = given_panels(axes, 4)
    if panels is None:
        figure = Figure(figsize=(9.0, 9.0), layout="constrained")
        figure.suptitle(title)
        panels = tuple(figure.subplots(4, 1, sharex=True))
    length, force = _units(robot)
    motion = forces.motion
    for panel, values, name, unit in zip(
        panels,
        (motion.positions, motion.speeds, motion.accelerations, forces.forces),
        ("position", "speed", "acceleration", "force"),
        (length, f"{length} per s", f"{length} per s²", force),
        strict=True,
    ):
        _draw(panel, forces.t, values, robot.actuated)
        panel.set_ylabel(f"{name} [{unit}]")
        if forces.t.size > 1:
            panel.set_xlim(forces.t[0], forces.t[-1])
    panels[-1].set_xlabel("time t [s]")
    _name(panels[0], robot.actuated)
    return panels


def _draw(panel: Axes, t: Array, values: Array, names: Sequence[str]) -> None:
    for column, name, dashes in zip(values.T, names, cycle(DASHES)):
        panel.plot(t, column, label=name, linestyle=dashes)


def _name(panel: Axes, names: Sequence[str]) -> None:
    if len(names) <= NAMED:
        # Above the axes, where it hides nothing.
        panel.legend(
            ncols=min(len(names), 4), loc="lower left", bbox_to_anchor=(0.0, 1.0), frameon=False
        )


def _units(robot: Robot) -> tuple[str, str]:
    """Return the units of the motors' positions and forces."""
    turning = rotating(robot.model)[robot.actuated_v]
    if np.all(turning):
        return "rad", "N m"
    return ("rad, m", "N m, N") if np.any(turning) else ("m", "N")
